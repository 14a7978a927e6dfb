"""What mends the last bad simplices: it never makes worse what it is there to make better."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from regions import ball, cube

import distmesh_edu as de
from distmesh_edu.distmesh import triangulate
from distmesh_edu.mesh_improvement import lift_worst, press_out, signed_quality, smooth, to_boundary
from distmesh_edu.region import as_region
from distmesh_edu.seeding import seeds


def region_of(dim, fh=None, h0=0.3):
    return as_region(ball(dim), fh, h0, cube(dim), None, dim, 0.1 if dim == 3 else 1e-3)


def shaken(dim, seed, size=0.15, h0=0.3):
    """Return the nodes and simplices of a ball whose boundary is right and whose inside is not."""
    region, rng = region_of(dim, h0=h0), np.random.default_rng(seed)
    p = seeds(region, rng)
    rim = de.Mesh(p, triangulate(p, region)).boundary_nodes
    p = p + size * h0 * rng.normal(size=p.shape)
    p[rim] = to_boundary(p[rim], region)
    p = p[ball(dim)(p) < 1e-9]
    mesh = de.Mesh(p, triangulate(p, region))
    used = np.unique(mesh.t)
    mesh = de.Mesh(p[used], np.searchsorted(used, mesh.t))
    p = mesh.p.copy()
    p[mesh.boundary_nodes] = to_boundary(p[mesh.boundary_nodes], region)
    t = mesh.t[signed_quality(p, mesh.t) > 0]
    return p, t, region


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_the_quality_is_signed(dim):
    p = np.concatenate((np.zeros((1, dim)), np.eye(dim)))
    t = np.arange(dim + 1)[None]
    mirrored = t[:, [1, 0, *range(2, dim + 1)]]
    quality = de.Mesh(p, t).quality[0]
    assert quality > 0.5
    assert signed_quality(p, t) == quality
    assert signed_quality(p, mirrored) == -quality


@pytest.mark.parametrize("scale", [0.2, 1, 5])
@pytest.mark.parametrize("dim", [1, 2, 3])
def test_newtons_method_finds_the_boundary_from_both_sides(dim, scale):
    """Of a field that is no distance; one step is exact for one that is."""
    p = np.random.default_rng(0).normal(size=(50, dim))
    p *= np.linspace(0.8, 1.2, 50)[:, None] / np.linalg.norm(p, axis=1)[:, None]
    square = as_region(lambda p: scale * ((p**2).sum(-1) - 1), None, 0.3, cube(dim), None, dim)
    np.testing.assert_allclose(np.linalg.norm(to_boundary(p, square), axis=1), 1, atol=1e-6)
    once = to_boundary(p, region_of(dim), 1)
    np.testing.assert_allclose(np.linalg.norm(once, axis=1), 1, atol=1e-7)
    assert to_boundary(p[:0], region_of(dim)).shape == (0, dim)


@pytest.mark.parametrize("dim", [2, 3])
@given(seed=st.integers(0, 999), size=st.floats(0.02, 0.3))
@settings(max_examples=15, deadline=None)
def test_smoothing_never_lowers_the_mean_quality(dim, seed, size):
    p, t, region = shaken(dim, seed, size)
    fixed = 3
    after = smooth(p, t, fixed, region)
    assert signed_quality(after, t).mean() >= signed_quality(p, t).mean()
    stays = np.union1d(np.arange(fixed), de.Mesh(p, t).boundary_nodes)
    np.testing.assert_array_equal(after[stays], p[stays])


@pytest.mark.parametrize("dim", [2, 3])
def test_smoothing_raises_a_poor_mean(dim):
    p, t, region = shaken(dim, 1)
    before, after = (signed_quality(q, t).mean() for q in (p, smooth(p, t, 0, region)))
    assert 1 - after < 0.85 * (1 - before)


def test_smoothing_leaves_a_node_where_the_mean_is_best():
    """In an uneven star of triangles that is not the place that the centroids ask for."""
    ring = np.array([(1, 0), (0.2, 0.5), (-0.9, 0.7), (-0.6, -0.6), (0.7, -0.9)])
    t = np.array([(k, (k + 1) % 5, 5) for k in range(5)])
    axis = np.linspace(-0.3, 0.3, 61)
    places = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 1, 2)
    stars = [np.concatenate((ring, place)) for place in places]
    best = stars[np.argmax([signed_quality(p, t).mean() for p in stars])]
    np.testing.assert_array_equal(smooth(best, t, 0, region_of(2)), best)
    worse = smooth(stars[0], t, 0, region_of(2))
    assert signed_quality(stars[0], t).mean() < signed_quality(worse, t).mean()


def test_smoothing_puts_a_node_amid_its_triangles():
    """The one interior node of a hexagon goes where the centroids around it average to itself."""
    angle = np.arange(6) * np.pi / 3
    ring = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    p = np.concatenate((ring, [(0.4, -0.3)]))
    t = np.array([(k, (k + 1) % 6, 6) for k in range(6)])
    after = smooth(p, t, 0, region_of(2), 40)
    np.testing.assert_allclose(after[6], 0, atol=1e-6)
    # Where fh is small the triangles pull more.
    graded = smooth(p, t, 0, region_of(2, lambda p: 1 + 0.5 * p[..., 0]), 1)
    assert graded[6, 0] < smooth(p, t, 0, region_of(2), 1)[6, 0] - 0.01


@pytest.mark.parametrize("dim", [2, 3])
@given(seed=st.integers(0, 999), size=st.floats(0.02, 0.3), goal=st.floats(0.1, 1.0))
@settings(max_examples=12, deadline=None)
def test_lifting_never_lowers_the_least_quality(dim, seed, size, goal):
    p, t, region = shaken(dim, seed, size)
    given_p = p.copy()
    after = lift_worst(p, t, 3, region, goal, rounds=10)
    np.testing.assert_array_equal(p, given_p)
    assert signed_quality(after, t).min() >= signed_quality(p, t).min()
    np.testing.assert_array_equal(after[:3], p[:3])
    rim = de.Mesh(p, t).boundary_nodes
    on = np.abs(ball(dim)(p[rim])) < 1e-9
    np.testing.assert_allclose(ball(dim)(after[rim[on]]), 0, atol=1e-6)
    assert ball(dim)(after).max() < 1e-6


def spoilt(dim, way):
    """Return a good mesh of a ball with one inner node moved towards a facet: by 1 onto it."""
    mesh = de.generate_mesh(ball(dim), None, 0.3 if dim == 2 else 0.5, cube(dim))
    inner = np.setdiff1d(np.arange(len(mesh.p)), mesh.boundary_nodes)
    node = inner[np.linalg.norm(mesh.p[inner], axis=1).argmin()]
    simplex = mesh.t[np.flatnonzero((mesh.t == node).any(axis=1))[0]]
    p = mesh.p.copy()
    p[node] += way * (p[np.setdiff1d(simplex, node)].mean(axis=0) - p[node])
    return p, mesh.t, mesh


@pytest.mark.parametrize("dim", [2, 3])
def test_a_sliver_is_repaired_by_moving_its_nodes(dim):
    p, t, mesh = spoilt(dim, 0.98)
    goal = 0.6 if dim == 2 else 0.3
    assert 0 < signed_quality(p, t).min() < 0.05
    after = lift_worst(p, t, 0, region_of(dim), goal)
    assert signed_quality(after, t).min() >= min(goal, mesh.quality.min()) * 0.99
    moved = np.flatnonzero((after != p).any(axis=1))
    assert len(moved) < len(p) / 2


@pytest.mark.parametrize("dim", [2, 3])
def test_a_simplex_turned_inside_out_is_turned_right(dim):
    p, t, _ = spoilt(dim, 1.1)
    assert signed_quality(p, t).min() < 0
    after = lift_worst(p, t, 0, region_of(dim), 0.3)
    assert signed_quality(after, t).min() > 0.25


@pytest.mark.parametrize("dim", [2, 3])
def test_what_is_good_enough_stays(dim):
    p, t, region = shaken(dim, 0, 0.02)
    goal = signed_quality(p, t).min()
    np.testing.assert_array_equal(lift_worst(p, t, 0, region, goal), p)
    np.testing.assert_array_equal(lift_worst(p, t, len(p), region, 1.0), p)


def test_boundary_nodes_slide_along_a_straight_side():
    """A node near one corner of a square, the others fixed, goes where its triangles are equal."""
    p = np.array([(0.0, 0), (1, 0), (1, 1), (0, 1), (0.1, 0)])
    t = np.array([(0, 4, 3), (4, 1, 2), (4, 2, 3)])
    square = as_region(de.rectangle(((0, 0), (1, 1))), None, 0.5, ((0, 0), (1, 1)), None, 2)
    after = lift_worst(p, t, 4, square, 1.0)
    np.testing.assert_array_equal(after[:4], p[:4])
    np.testing.assert_allclose(after[4], (0.5, 0), atol=0.02)
    assert abs(after[4, 1]) < 1e-12


def test_boundary_nodes_are_pressed_out_where_that_does_no_harm():
    """Of two that lie inside by as much, the one whose triangle would become flat stays there."""
    square = as_region(de.rectangle(((0, 0), (1, 1))), None, 0.5, ((0, 0), (1, 1)), None, 2)
    p = np.array([(0.0, 0), (0.5, 0.1), (1, 0), (1, 0.5), (0.9, 0.75), (1, 1), (0, 1)])
    p = np.concatenate((p, [(0.88, 0.76)]))
    t = np.array([(0, 1, 6), (1, 2, 7), (1, 7, 6), (2, 3, 7), (3, 4, 7), (4, 5, 7), (5, 6, 7)])
    t = de.Mesh(p, t).t
    before = signed_quality(p, t)
    after = press_out(p, t, 0, square, 0.4)
    np.testing.assert_allclose(after[1], (0.5, 0), atol=1e-9)
    changed = signed_quality(after, t) != before
    assert (signed_quality(after, t)[changed] >= np.minimum(before[changed], 0.4)).all()
    assert (press_out(p, t, 2, square, 0.4)[1] == p[1]).all()
    np.testing.assert_allclose(press_out(p, t, 0, square, 1e-9)[4], (1, 0.75), atol=1e-9)
    np.testing.assert_array_equal(press_out(p, t, 0, square, 2.0)[1], p[1])


@pytest.mark.parametrize("dim", [2, 3])
@given(seed=st.integers(0, 999), least=st.floats(0.05, 0.9))
@settings(max_examples=12, deadline=None)
def test_pressing_out_never_stretches_below_the_least(dim, seed, least):
    p, t, region = shaken(dim, seed, 0.1)
    rim = de.Mesh(p, t).boundary_nodes
    p[rim] *= np.random.default_rng(seed).uniform(0.85, 1, size=(len(rim), 1))
    t = t[signed_quality(p, t) > 0]
    before, after = (signed_quality(q, t) for q in (p, press_out(p, t, 2, region, least)))
    assert (after >= np.minimum(before, least)).all()
    np.testing.assert_array_equal(press_out(p, t, 2, region, least)[:2], p[:2])


def test_an_inner_node_is_not_moved_into_a_hole():
    """The facets of a hole cut into it: between them and the boundary there is room, outside."""
    rim = [(np.cos(0.7), -np.sin(0.7)), (np.cos(0.7), np.sin(0.7))]
    p = np.array([*rim, (0.95, 0.6), (1.04, 0), (0.95, -0.6), (1.02, 0)])
    t = np.array([(k, 5, (k + 1) % 5) for k in range(5)])
    t = de.Mesh(p, t).t
    fd = de.difference(de.rectangle(((-2, -2), (2, 2))), de.circle())
    region = as_region(fd, None, 0.5, ((-2, -2), (2, 2)), None, 2)
    after = lift_worst(p, t, 5, region, 1.0)
    assert signed_quality(after, t).min() > signed_quality(p, t).min()
    assert np.hypot(*after[5]) > 1 - 1e-9
