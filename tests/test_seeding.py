"""Where a mesh starts: the lattice itself where it is uniform, and the wanted density elsewhere."""

import numpy as np
import pytest
from regions import ball, cube
from scipy.spatial import Delaunay, cKDTree

import distmesh_edu as de
from distmesh_edu import seeding
from distmesh_edu.region import as_region
from distmesh_edu.seeding import LATTICES, seeds


def started(fd, fh, h0, bbox, pfix=None, seed=0):
    bbox = np.asarray(bbox)
    return seeds(as_region(fd, fh, h0, bbox, pfix, bbox.shape[1]), np.random.default_rng(seed))


def wanted(fh, inside, h0, bbox, finest, cells):
    """Return how many nodes of the density of a lattice lie in a zone: an integral of 1 / h**dim.

    By the midpoint rule; `finest` is the least of fh over the region, which stands for h0.
    """
    axes = [np.linspace(a, b, cells + 1)[:-1] + (b - a) / cells / 2 for a, b in np.transpose(bbox)]
    p = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    p = p[inside(p)]
    cell = np.prod(np.diff(bbox, axis=0)) / cells ** len(axes)
    node = np.linalg.det(LATTICES[len(axes)])
    return float((cell / node / (h0 * fh(p) / finest) ** len(axes)).sum())


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_where_edges_are_equal_the_nodes_are_the_whole_lattice(dim):
    h0, bbox = 0.3, cube(dim)
    p = started(ball(dim), None, h0, bbox)
    counts = (p - bbox[0]) @ np.linalg.inv(LATTICES[dim] * h0)
    np.testing.assert_allclose(counts, counts.round(), atol=1e-9)
    axes = [np.arange(-30, 31)] * dim
    every = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, dim) @ LATTICES[dim] * h0
    every = every + bbox[0]
    assert len(p) == (np.linalg.norm(every, axis=1) < 1 + 1e-3 * h0).sum()
    assert len(np.unique(p.round(9), axis=0)) == len(p)


def test_the_disc_of_h0_0_2_starts_with_the_published_88():
    p = started(de.circle(), None, 0.2, cube(2))
    assert len(p) == 88
    nearest = cKDTree(p).query(p, k=2)[0][:, 1]
    np.testing.assert_allclose(nearest, 0.2)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_edges_of_the_lattice_are_one_on_average(dim):
    axes = [np.arange(-4, 5)] * dim
    p = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, dim) @ LATTICES[dim]
    p = p + 1e-6 * np.random.default_rng(0).normal(size=p.shape)
    if dim == 1:
        t = np.stack((np.arange(8), np.arange(1, 9)), axis=1)
    else:
        t = Delaunay(p).simplices
        t = t[(np.linalg.norm(p[t].mean(axis=1), axis=1) < 2)]
    mesh = de.Mesh(p, t)
    assert mesh.edge_lengths.mean() == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize(
    ("dim", "h0", "slope", "cells"),
    [(1, 1e-4, 0.02, 5000), (2, 0.005, 0.08, 800), (3, 0.025, 0.15, 120)],
)
def test_the_density_of_the_nodes_is_one_over_h_to_the_dim(dim, h0, slope, cells, seed):
    """In each of four rings about the finest place; from first to last edges grow threefold."""
    fh = lambda p: h0 + slope * np.linalg.norm(p, axis=-1)  # noqa: E731
    p = started(ball(dim), fh, h0, cube(dim), seed=seed)
    for inner in (0.1, 0.3, 0.5, 0.7):

        def ring(q, inner=inner):
            return np.abs(np.linalg.norm(q, axis=-1) - inner - 0.1) < 0.1

        expected = wanted(fh, ring, h0, cube(dim), fh(p).min(), cells)
        assert expected > 10
        assert ring(p).sum() == pytest.approx(expected, rel=0.06, abs=3)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_the_size_function_need_not_exist_outside(dim):
    asked = []

    def fh(p):
        asked.append(np.linalg.norm(p, axis=-1).max(initial=0))
        return 0.05 + 0.4 * (1 - np.linalg.norm(p, axis=-1))

    started(ball(dim), fh, 0.05, cube(dim))
    assert 0.9 < max(asked) < 1 + 1e-3 * 0.05


@pytest.mark.parametrize(("dim", "h0", "share"), [(1, 1e-4, 0.2), (2, 0.002, 0.1), (3, 0.02, 0.5)])
def test_strong_grading_spares_most_of_the_box(dim, h0, share):
    """A lattice of the smallest edges would ask fd at each of its points."""
    asked = []

    def fd(p):
        asked.append(p.size // dim)
        return ball(dim)(p)

    started(fd, lambda p: h0 + 0.3 * np.linalg.norm(p, axis=-1), h0, cube(dim))
    assert sum(asked) < share * (2 / h0) ** dim / np.linalg.det(LATTICES[dim])


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_fixed_points_come_first_and_nothing_stands_on_them(dim):
    lattice = started(ball(dim), None, 0.25, cube(dim))
    pfix = np.concatenate((lattice[[7, 4]], np.full((1, dim), 0.123)))
    p = started(ball(dim), None, 0.25, cube(dim), pfix)
    np.testing.assert_array_equal(p[:3], pfix)
    assert len(p) == len(lattice) + 1
    assert len(np.unique(p, axis=0)) == len(p)


def test_fine_places_far_from_each_other_are_all_found():
    """The coarse lattice has no point near either of them."""
    a, b = ball(2, (-0.731, 0.513), 0), ball(2, (0.377, -0.619), 0)
    fh = lambda p: 0.01 + 0.3 * np.minimum(a(p), b(p))  # noqa: E731
    p = started(de.circle(), fh, 0.01, cube(2))
    for distance in (a, b):
        assert (distance(p) < 0.05).sum() > 12


def test_a_thin_arm_of_a_large_region_is_not_lost_between_coarse_points():
    arm = de.rectangle(((0, -0.02), (3, 0.02)))
    fd = de.union(de.circle(), arm)
    fh = lambda p: 0.02 + 0.3 * np.maximum(-de.circle()(p), 0)  # noqa: E731
    p = started(fd, fh, 0.02, ((-1, -1), (3, 1)))
    along = np.sort(p[p[:, 0] > 1][:, 0])
    assert along[-1] > 2.97
    assert np.diff(along).max() < 0.03


def test_one_generator_one_start():
    fh = lambda p: 0.02 + 0.3 * np.linalg.norm(p, axis=-1)  # noqa: E731
    starts = [started(de.circle(), fh, 0.02, cube(2), seed=seed) for seed in (3, 3, 4)]
    np.testing.assert_array_equal(starts[0], starts[1])
    assert starts[0].shape != starts[2].shape or (starts[0] != starts[2]).any()


def test_a_size_function_that_leaves_no_simplex_is_refused():
    fh = lambda p: 1e-3 + np.linalg.norm(p, axis=-1)  # noqa: E731
    with pytest.raises(ValueError, match=r"fh keeps \d of \d+ points"):
        started(de.circle(), fh, 0.4, cube(2))


def test_sizes_may_shrink_to_a_point_that_the_boxs_lattice_would_never_fit(monkeypatch):
    h0, bbox = 2e-5, cube(2)  # a lattice of side h0 would have 1e10 points
    fh = lambda p: np.maximum(np.linalg.norm(p, axis=-1), 1e-4) ** 0.8  # noqa: E731
    region = as_region(ball(2), fh, h0, bbox, None, 2, fills=False)
    assert len(seeds(region, np.random.default_rng(0))) < 30_000
    monkeypatch.setattr(seeding, "POINTS_LIMIT", 1e4)
    with pytest.raises(ValueError, match="h0 = 2e-05 and fh ask for a lattice of more than 1e"):
        seeds(region, np.random.default_rng(0))
