"""A mesh that follows a moving region: nodes stay, go and come, on a line, in plane and space."""

import numpy as np
import pytest
from regions import ball, cube
from scipy.spatial import cKDTree

import distmesh_edu as de
from distmesh_edu.region import as_region
from distmesh_edu.seeding import CROWDED, GAP, reseeded, seeds

EDGES = {1: 0.1, 2: 0.15, 3: 0.3}
LEAST = {1: 1.0, 2: 0.6, 3: 0.2}
#: The radii of a ball whose boundary moves by about a third of an edge a frame.
RADII = {1: np.linspace(1, 0.5, 16), 2: np.linspace(1, 0.5, 11), 3: np.linspace(1, 0.6, 5)}


def meshed(dim, radius=1.0, start=None, **others):
    others = {"patience": 5, **others}
    return de.generate_mesh(
        ball(dim, 0, radius), None, EDGES[dim], cube(dim), start=start, **others
    )


def followed(dim, radii):
    meshes = []
    for radius in radii:
        meshes.append(meshed(dim, radius, meshes[-1] if meshes else None))
    return meshes


def ready(p, dim=2, fh=None, pfix=None, h0=None):
    """Return the nodes made ready for a ball, and the lattice that fills their gaps."""
    h0 = EDGES[dim] if h0 is None else h0
    region = as_region(ball(dim), fh, h0, cube(dim), pfix, dim)
    lattice = seeds(region, np.random.default_rng(0))
    return reseeded(np.asarray(p, dtype=float), region, np.random.default_rng(0)), lattice


def dumbbell(width):
    """Return two discs, joined by a bar unless its width is negative."""
    discs = de.circle((-0.6, 0), 0.35), de.circle((0.6, 0), 0.35)
    bar = de.rectangle(((-0.6, -width / 2), (0.6, width / 2))) if width > 0 else discs[0]
    return de.union(*discs, bar)


@pytest.mark.parametrize("dim", [2, 3])
def test_nodes_of_an_unchanged_region_hardly_move(dim):
    """In another box, whose lattice stands elsewhere: it would move them by a third of an edge."""
    before = de.generate_mesh(ball(dim), None, EDGES[dim], 1.037 * cube(dim))
    after = meshed(dim, start=before)
    moved = cKDTree(after.p).query(before.p)[0] / EDGES[dim]
    assert np.median(moved) < 0.2
    assert np.quantile(moved, 0.9) < 0.45
    # Two lattices have not quite the same number of points in one region.
    assert len(after.p) == pytest.approx(len(before.p), rel=0.05)


def test_even_nodes_on_a_line_stay():
    before = meshed(1)
    np.testing.assert_allclose(
        np.sort(meshed(1, start=before).p, 0), np.sort(before.p, 0), atol=1e-12
    )


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_a_shrinking_mesh_is_as_good_as_the_first(dim):
    for radius, mesh in zip(RADII[dim], followed(dim, RADII[dim]), strict=True):
        fresh = meshed(dim, radius)
        assert mesh.quality.min() >= LEAST[dim]
        assert mesh.volume == pytest.approx(fresh.volume, rel=0.04)
        assert len(mesh.orphans) == 0
        assert mesh.euler_characteristic == 1
        assert mesh.edge_lengths.mean() == pytest.approx(fresh.edge_lengths.mean(), rel=0.08)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_a_growing_mesh_is_as_good_and_covers_the_region(dim):
    for radius, mesh in zip(RADII[dim][::-1], followed(dim, RADII[dim][::-1]), strict=True):
        assert mesh.quality.min() >= LEAST[dim]
        assert mesh.volume == pytest.approx(meshed(dim, radius).volume, rel=0.04)
        assert len(mesh.orphans) == 0
        assert mesh.euler_characteristic == 1


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_a_growing_mesh_gets_the_nodes_that_a_fresh_one_has(dim):
    """No gap is ever wide: without a count, edges would stretch by a fifth."""
    last = followed(dim, RADII[dim][::-1])[-1]
    assert len(last.p) == pytest.approx(len(meshed(dim, RADII[dim][0]).p), rel=0.06)


def test_a_fine_spot_that_travels_takes_its_nodes_along():
    """The region stays, and its sizes go round: fine at the spot, three times as coarse beyond."""
    start = None
    for angle in np.linspace(0, np.pi, 13):
        spot = 0.5 * np.array([np.cos(angle), np.sin(angle)])
        fh = lambda p, spot=spot: 0.05 + 0.25 * np.linalg.norm(p - spot, axis=-1)  # noqa: E731
        start = de.generate_mesh(de.circle(), fh, 0.05, cube(2), start=start, patience=5)
        fresh = de.generate_mesh(de.circle(), fh, 0.05, cube(2), patience=5)
        assert start.quality.min() > 0.6
        assert len(start.p) == pytest.approx(len(fresh.p), rel=0.15)
    a, b = start.p[start.edges.T]
    wanted = fh((a + b) / 2)
    share = start.edge_lengths / wanted
    near = np.linalg.norm((a + b) / 2 - spot, axis=1) < 0.3
    assert np.median(share[near]) == pytest.approx(np.median(share[~near]), rel=0.15)


def test_a_mesh_follows_a_region_that_parts_and_one_that_joins():
    width = np.array([0.3, 0.24, -1, 0.24, 0.3])
    pieces, start = [], None
    for w in width:
        start = de.generate_mesh(dumbbell(w), None, 0.07, cube(2), start=start, patience=5)
        pieces.append(start.euler_characteristic)
    assert pieces == [1, 1, 2, 1, 1]


def test_a_follower_of_a_small_step_begins_with_better_triangles_than_a_graded_lattice():
    def first(radius, start):
        seen = []
        fd = de.circle((0, 0), radius)
        fh = lambda p: 0.05 + 0.3 * np.abs(fd(p))  # noqa: E731
        mesh = de.generate_mesh(fd, fh, 0.05, cube(2), start=start, callback=seen.append)
        return mesh, seen[0].quality.mean()

    before, _ = first(1.0, None)
    assert first(0.99, before)[1] > first(0.99, None)[1] + 0.05


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_fixed_points_come_first_and_are_kept(dim):
    pfix = np.array([np.full(dim, 0.1), -np.eye(dim)[0]])
    start = meshed(dim)
    for _ in range(3):
        start = meshed(dim, start=start, pfix=pfix)
        np.testing.assert_array_equal(start.p[:2], pfix)
        assert cKDTree(start.p).query(pfix, k=2)[0][:, 1].min() > 0.25 * EDGES[dim]


@pytest.mark.parametrize("dim", [1, 2, 3])
@pytest.mark.parametrize("where", ["no points", "far outside"])
def test_a_start_of_which_nothing_arrives_is_none(dim, where):
    start = np.zeros((0, dim)) if where == "no points" else np.full((5, dim), 7.0)
    np.testing.assert_array_equal(meshed(dim, start=start).p, meshed(dim).p)


def test_a_mesh_and_its_points_are_the_same_start_and_stay_as_they_were():
    before = meshed(2)
    copy = before.p.copy()
    np.testing.assert_array_equal(meshed(2, 0.95, before).p, meshed(2, 0.95, before.p.tolist()).p)
    np.testing.assert_array_equal(before.p, copy)


def test_nodes_left_just_outside_come_to_the_boundary_and_those_far_out_go():
    """An edge of 0.15 is what counts: 0.1 outside is near, 0.2 is far."""
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    circle = np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    begun = []
    meshed(2, 1.0, np.concatenate((1.1 * circle, 1.2 * circle)), callback=begun.append)
    radius = np.linalg.norm(begun[0].p, axis=1)
    assert radius.max() < 1 + 1e-3
    found = cKDTree(begun[0].p).query(circle)[0]
    assert found.max() < 1e-6


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_crowded_nodes_go_and_gaps_are_filled(dim):
    rng = np.random.default_rng(5)
    cloud = rng.uniform(-1, 1, (4000 if dim == 3 else 400, dim))
    cloud = cloud[ball(dim)(cloud) < 0]
    cloud = cloud[cloud[:, 0] > 0]  # crowded on one side, and none on the other
    p, lattice = ready(cloud, dim)
    stayed = p[(cKDTree(cloud).query(p)[0] == 0)]
    assert cKDTree(stayed).query(stayed, k=2)[0][:, 1].min() >= CROWDED * EDGES[dim]
    assert cKDTree(p).query(lattice)[0].max() <= GAP * EDGES[dim]
    assert 0.3 * len(lattice) < (p[:, 0] < 0).sum() < 0.6 * len(lattice)


def test_what_is_crowded_and_what_is_a_gap_goes_by_the_edges_there():
    fh = lambda p: 0.05 + 0.3 * np.linalg.norm(p, axis=-1)  # noqa: E731
    pair = np.array([[0.0, 0.0], [0.045, 0.0], [0.8, 0.0], [0.845, 0.0]])
    p, lattice = ready(pair, fh=fh, h0=0.05)
    scale = 0.05 / fh(lattice).min()
    found = cKDTree(p).query(pair)[0] == 0
    assert found.tolist() == [True, True, True, False]
    assert (cKDTree(p).query(lattice)[0] <= GAP * scale * fh(lattice)).all()


def test_nodes_on_fixed_points_give_way_to_them():
    pfix = np.array([[0.0, 0.0], [0.05, 0.0]])  # nearer to each other than nodes may be
    p, _ = ready([[0.0, 0.0], [0.02, 0.01], [0.5, 0.5]], pfix=pfix)
    np.testing.assert_array_equal(p[:3], [*pfix, [0.5, 0.5]])


@pytest.mark.parametrize(
    ("start", "error", "words"),
    [
        ([[0.0, 0.0, 0.0]], ValueError, r"start must have the shape \(n, 2\).*got \(1, 3\)"),
        (de.Mesh([(0,), (1,)], [(0, 1)]), ValueError, r"start must have the shape \(n, 2\)"),
        ([[0.0, np.nan]], ValueError, r"start must be finite; start\[0, 1\] is nan"),
        ([[np.inf, 0.0]], ValueError, r"start must be finite; start\[0, 0\] is inf"),
        (5.0, ValueError, r"start must have the shape \(n, 2\)"),
        ("the last mesh", TypeError, "start must hold real numbers; got 'the last mesh'"),
        ([[0.0, 0.0], [1.0]], TypeError, "start must hold numbers in rows of equal length"),
        (object(), TypeError, "start must hold real numbers"),
    ],
)
def test_a_wrong_start_is_named(start, error, words):
    with pytest.raises(error, match=words):
        meshed(2, start=start)
