"""The thesis's own examples: its counts, its statistics, and what its errata say of them."""

import numpy as np
import pytest

import distmesh_edu as de
from distmesh_edu.distmesh import as_region, bar_forces, incidence, keep_inside, lattice, reject

BOX = ((-1, -1), (1, 1))
CORNERS = [(-1, -1), (-1, 1), (1, 1), (1, -1)]


def thesis_square(p):
    return np.maximum(np.abs(p).max(axis=-1) - 1, 0.5 - np.hypot(p[..., 0], p[..., 1]))


def on_grid(fd, dx, degree=1):
    grid = de.Grid(((-2, -2), (2, 2)), dx)
    return grid.interpolate(fd(grid.points), degree=degree)


HOLE, MOVED_HOLE = (de.difference(de.circle(), de.circle((x, 0), 0.5)) for x in (0, 0.25))


@pytest.mark.parametrize(
    ("fd", "dx", "h0", "pfix", "nodes", "triangles", "mean"),
    [
        (de.circle(), 0.1, 0.1, None, 362, 661, 0.985),
        (HOLE, 0.1, 0.1, None, 272, 455, 0.966),
        (MOVED_HOLE, 0.1, 0.1, None, 272, 457, 0.969),
        (thesis_square, 0.1, 0.15, CORNERS, 178, 282, 0.957),
        (thesis_square, 0.1, 0.1, CORNERS, 404, 690, 0.970),
        (de.circle(), 0.2, 0.1, None, 360, 657, 0.984),
    ],
)
def test_the_thesis_examples_have_its_counts(fd, dx, h0, pfix, nodes, triangles, mean):
    """The thesis's listings 5.6 and 5.9, run in GNU Octave 7.3, less the duplicate of E5.5d."""
    mesh = de.distmesh2d(on_grid(fd, dx), None, h0, BOX, pfix, max_steps=800)
    assert mesh.converged
    assert len(mesh.p) == nodes
    assert abs(len(mesh.t) - triangles) <= 1  # a tie decides whether a flat one at the rim stays
    assert mesh.quality.mean() == pytest.approx(mean, abs=0.003)
    assert mesh.quality.min() > 0.6


@pytest.mark.parametrize(
    ("fd", "fh", "dx", "h0", "pfix", "counts", "expected"),
    [
        (HOLE, None, 0.1, 0.1, None, (504, 272), 272),
        (thesis_square, None, 0.1, 0.15, CORNERS, (224, 174), 174),
        (thesis_square, lambda p: 4 * np.hypot(*p.T), 0.05, 0.05, CORNERS, (1927, 1542), 597.7),
    ],
)
def test_the_start_has_the_thesis_counts(fd, fh, dx, h0, pfix, counts, expected):
    """Octave 7.3: points of the box, inside, and expected after rejection; duplicates taken off."""
    region = as_region(on_grid(fd, dx), fh, h0, BOX, pfix, dim=2)
    p = lattice(region.bbox, h0)
    inside = keep_inside(p, region)
    assert (len(p), len(inside)) == counts
    kept = [len(reject(inside, region, np.random.default_rng(seed))) for seed in range(20)]
    assert np.mean(kept) == pytest.approx(expected, abs=3 * np.sqrt(expected / 20))


@pytest.mark.parametrize(("degree", "rests"), [(1, False), (3, True)])
def test_the_kinks_of_linear_interpolation_keep_the_truss_from_rest(degree, rests):
    """Errata E5.9: the disc on a grid of 0.2, with a test as strict as the printed one."""
    fd = on_grid(de.circle(), 0.2, degree)
    *_, mesh = de.distmesh2d_steps(fd, None, 0.1, BOX, dptol=0.001 / np.sqrt(5), max_steps=500)
    assert mesh.converged == rests


@pytest.mark.parametrize("h0", [0.1, 0.15, 0.3])
def test_a_distance_drives_nodes_into_right_angles(h0):
    mesh = de.distmesh2d(de.rectangle(BOX), None, h0, BOX)
    for corner in CORNERS:
        assert np.hypot(*(mesh.p - corner).T).min() < 1e-6


def test_one_node_among_five_goes_the_thesis_way():
    """Thesis figure 5.1, a unit pentagon: the first of 30 steps, run in NumPy from (5.5), (5.6)."""
    angle = np.pi / 2 + 2 * np.pi * np.arange(5) / 5
    p = np.concatenate((np.stack((np.cos(angle), np.sin(angle)), axis=1), [(0.45, 0.3)]))
    D = incidence(np.array([(i, 5) for i in range(5)]), 6)
    for place in [(0.34799872, 0.25196771), (0.25636176, 0.19467537), (0.17104715, 0.13809722)]:
        L = np.linalg.norm(D @ p, axis=1)
        scale = np.sqrt((L**2).mean())  # so that every bar wants the length 1.2
        p[5] += 0.2 * bar_forces(D, p, np.ones(5), 1.2 / scale)[5]
        np.testing.assert_allclose(p[5], place, atol=1e-8)


def test_a_row_at_rest_sharpens_the_size_function():
    """All bars push equally: l = Fscale h - (Fscale - 1) mean(h), in units of the scale."""
    p = np.linspace(0, 1, 9)[:, None]
    bars = np.stack((np.arange(8), np.arange(1, 9)), axis=1)
    D = incidence(bars, 9)
    for _ in range(2000):
        h = 1 + p[bars].mean(axis=1)[:, 0]
        F = bar_forces(D, p, h, 1.2)
        F[[0, -1]] = 0
        p = p + 0.2 * F
    expected = (1.2 * h - 0.2 * h.mean()) / h.sum()
    np.testing.assert_allclose(np.diff(p[:, 0]), expected, rtol=1e-6)


def test_a_graded_disc_has_the_thesis_statistics():
    """Thesis 5.11.2, h = 4 r: 481 to 537 nodes, mean quality 0.976 to 0.982 over 20 seeds."""
    for seed in range(2):
        fh = lambda p: 4 * np.hypot(p[..., 0], p[..., 1])  # noqa: E731
        mesh = de.distmesh2d(on_grid(HOLE, 0.05), fh, 0.05, BOX, rng=seed, max_steps=1500)
        assert 465 < len(mesh.p) < 555
        assert 0.97 < mesh.quality.mean() < 0.985
        assert mesh.quality.min() > 0.5
