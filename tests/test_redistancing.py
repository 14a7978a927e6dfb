"""Redistancing by closest points, and the spline that it stands on."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import distmesh_edu as de
from distmesh_edu._spline import CubicSpline
from distmesh_edu.geometry import volume
from tests.level_sets import DIMS, EDGES, OFFSET, SIZE, ball, in_band, level_set, plane

# ---- the spline ----


@DIMS
def test_the_spline_is_the_grids_spline_with_its_derivatives(dim):
    rng = np.random.default_rng(dim)
    shape = (11, 9, 8)[:dim]
    values = rng.standard_normal(shape)
    box = de.Grid((np.zeros(dim), np.array(shape) - 1.0), 1.0)
    field = box.interpolate(values)
    places = rng.uniform(0.2, 6.8, (dim, 50))
    value, slope, bend = CubicSpline(values)(places, order=2)
    np.testing.assert_allclose(value, field(places.T), rtol=0, atol=1e-12)
    step = 1e-4
    ways = step * np.eye(dim)
    for k in range(dim):
        rise = field(places.T + ways[k]) - field(places.T - ways[k])
        np.testing.assert_allclose(slope[k], rise / (2 * step), rtol=0, atol=1e-5)
        for j in range(dim):
            pair = sum(
                s * t * field(places.T + s * ways[k] + t * ways[j])
                for s in (1, -1)
                for t in (1, -1)
            )
            np.testing.assert_allclose(bend[k, j], pair / (4 * step**2), rtol=0, atol=3e-3)


@DIMS
def test_the_spline_of_a_cubic_is_that_cubic(dim):
    """To the rim and beyond it, as the not-a-knot condition promises, on the fewest nodes too."""
    for count in (4, 5, 6, 9):
        x = np.indices((count,) * dim).astype(float)
        places = np.random.default_rng(0).uniform(-0.5, count - 0.5, (dim, 40))
        value, slope, bend = CubicSpline(np.prod(x**3 - x, axis=0))(places, order=2)
        parts = places**3 - places
        scale = np.abs(value).max()
        np.testing.assert_allclose(value, parts.prod(axis=0), rtol=0, atol=1e-12 * scale)
        rest = [np.delete(parts, k, axis=0).prod(axis=0) for k in range(dim)]
        for k in range(dim):
            expected = (3 * places[k] ** 2 - 1) * rest[k]
            np.testing.assert_allclose(slope[k], expected, rtol=0, atol=1e-11 * scale)
            expected = 6 * places[k] * rest[k]
            np.testing.assert_allclose(bend[k, k], expected, rtol=0, atol=1e-11 * scale)


def test_many_places_are_worked_on_in_blocks():
    values = np.random.default_rng(0).standard_normal((12, 10))
    places = np.random.default_rng(1).uniform(0, 9, (2, 10_001))
    spline = CubicSpline(values)
    for whole, part in zip(spline(places, order=2), spline(places[:, -7:], order=2), strict=True):
        np.testing.assert_array_equal(whole[..., -7:], part)


# ---- closest points ----


@pytest.mark.parametrize("seed", range(12))
@DIMS
def test_a_plane_has_its_distance(dim, seed):
    """In any direction, with a spacing of its own for each axis, where the foot is in the box."""
    d, dx, inside = plane(dim, np.random.default_rng(100 * dim + seed))
    found = de.redistance(-3 * d, dx)
    np.testing.assert_allclose(found[inside], -d[inside], rtol=0, atol=1e-10)


@pytest.mark.parametrize(("dim", "counts"), [(1, (21, 41)), (2, (21, 61)), (3, (21, 41))])
def test_observed_order_of_the_distance(dim, counts):
    errors = []
    for n in counts:
        d, dx = ball(dim, n)
        found = de.redistance(np.sin(d) * (d + 2), dx)
        errors.append(np.abs(found - d)[in_band(d, dx)].max())
    assert np.log(errors[0] / errors[1]) / np.log(counts[1] / counts[0]) >= 2.8
    assert errors[1] < 3e-5


def test_observed_order_about_a_flower():
    """Petals with radii of curvature down to 0.07, and a phi with slopes from 0.5 to 2.8."""
    errors = []
    for n in (141, 401):
        box = de.Grid(((-2, -2), (2, 2)), 4 / (n - 1))
        d = de.examples.five_petals_distance()(box.points)
        found = de.redistance(de.examples.five_petals()(box.points), box.dx)
        errors.append(np.abs(found - d)[in_band(d, box.dx)].max())
    assert errors[0] < 2e-4
    assert np.log(errors[0] / errors[1]) / np.log(400 / 140) >= 2.8


@DIMS
@settings(max_examples=15, deadline=None, derandomize=True)
@given(factor=st.floats(-300, 300), power=st.sampled_from([1, 3, 5]))
def test_only_the_zeros_and_the_signs_count(dim, factor, power):
    """Whatever the unit of phi; and of a smooth function of it, up to the error of the spline."""
    d, dx = ball(dim, 21 if dim < 3 else 15)
    same = de.redistance(10.0**factor * level_set(d), dx)
    np.testing.assert_allclose(same, de.redistance(level_set(d), dx), rtol=0, atol=1e-9)
    bent = de.redistance(np.sinh(power * d / 4), dx)
    assert np.abs(bent - de.redistance(d, dx))[in_band(d, dx, 2)].max() < 0.01 * max(dx)


@DIMS
def test_the_unit_of_length_does_not_count(dim):
    d, dx = ball(dim, 15)
    expected = de.redistance(level_set(d), dx)
    for unit in (1e-9, 1e9):
        found = de.redistance(level_set(d), unit * np.array(dx))
        np.testing.assert_allclose(found / unit, expected, rtol=0, atol=1e-9)


@DIMS
def test_a_distance_stays_as_it_is(dim):
    d, dx = ball(dim, SIZE[dim])
    once = de.redistance(level_set(d), dx)
    twice = de.redistance(once, dx)
    band = in_band(d, dx)
    assert np.abs(twice - once)[band].max() < 1e-3 * max(dx)


@DIMS
def test_turning_phi_inside_out_or_about_changes_nothing_else(dim):
    d, dx = ball(dim, 21)
    found = de.redistance(level_set(d), dx)
    np.testing.assert_allclose(de.redistance(-level_set(d), dx), -found, rtol=0, atol=1e-12)
    for axis in range(dim):
        mirrored = de.redistance(np.flip(level_set(d), axis), dx)
        far = np.abs(np.flip(mirrored, axis) - found)  # of two equally far points, one is taken
        assert far[in_band(d, dx)].max() < 1e-9
        assert far.max() < 0.02 * max(dx)
    turned = de.redistance(level_set(d).T, dx[::-1]).T
    assert np.abs(turned - found)[in_band(d, dx)].max() < 1e-9


@DIMS
def test_inside_and_outside_are_alike_for_the_roughest_data(dim):
    """With kinks in every cell, and nodes on the interface among them."""
    phi = np.random.default_rng(dim).integers(-2, 3, (15, 12, 9)[:dim]).astype(float)
    assert (phi == 0).any()
    found = de.redistance(phi, EDGES[:dim])
    np.testing.assert_allclose(de.redistance(-phi, EDGES[:dim]), -found, rtol=0, atol=1e-12)


@DIMS
def test_no_node_changes_sides(dim):
    phi = np.random.default_rng(dim).standard_normal((20, 15, 12)[:dim])
    np.testing.assert_array_equal(de.redistance(phi, EDGES[:dim]) < 0, phi < 0)


@pytest.mark.parametrize(
    ("fd", "worst"),
    [
        (de.union(de.circle((-0.7, 0.1), 0.5), de.circle((0.8, 0), 0.4)), 0.5),
        (de.rectangle(((-1.03, -0.52), (1.01, 0.57))), 1.0),
        (de.polygon([(-1.2, -0.9), (1.3, -0.7), (0.1, 1.1)]), 1.0),
    ],
    ids=["two discs", "rectangle", "triangle"],
)
def test_far_away_and_next_to_the_medial_axis_the_error_stays_below_a_cell(fd, worst):
    for n in (41, 81):
        box = de.Grid(((-2, -2), (2, 2)), 4 / (n - 1))
        phi = fd(box.points)
        d = de.polygon_distance(box.points) if fd is None else phi
        outside = phi > 0  # where the distance to a union is exact
        error = np.abs(de.redistance(np.sinh(phi), box.dx) - d) / box.dx[0]
        assert error[outside].max() < worst
        assert np.median(error[outside]) < 0.01


def test_inside_a_ring_the_middle_line_is_kept():
    box = de.Grid(((-2, -2), (2, 2)), 0.05)
    r = np.linalg.norm(box.points - OFFSET[:2], axis=-1)
    d = np.maximum(0.5 - r, r - 1.5)
    error = np.abs(de.redistance(d * (2 + np.cos(r)), box.dx) - d)
    assert error.max() < 0.05 * 0.5
    assert np.median(error) < 1e-4


@pytest.mark.parametrize("cells", [1.5, 2.0, 3.0, 6.0])
@pytest.mark.parametrize("offset", [0.0, 0.3, 0.5])
def test_twenty_redistancings_leave_a_thin_bar_its_area(cells, offset):
    h = 0.05
    x, y = np.meshgrid(*[np.arange(-30, 31) * h] * 2, indexing="ij")
    phi = np.maximum(np.abs(y - offset * h) - cells * h / 2, np.abs(x) - 1.02)
    area = volume(phi, h)
    for _ in range(20):
        phi = de.redistance(phi, h)
    assert volume(phi, h) / area == pytest.approx(1, abs=0.06)


@pytest.mark.parametrize(("cells", "within"), [(3, 0.04), (4, 0.01), (6, 0.005)])
def test_twenty_redistancings_leave_a_small_disc_its_area(cells, within):
    h = 0.1
    x, y = np.meshgrid(*[np.arange(-15, 16) * h] * 2, indexing="ij")
    for offset in (0.0, 0.31, 0.5):
        phi = np.hypot(x - offset * h, y - 0.7 * offset * h) - cells * h
        area = volume(phi, h)
        for _ in range(20):
            phi = de.redistance(phi, h)
        assert volume(phi, h) / area == pytest.approx(1, abs=within)


@DIMS
def test_nodes_on_the_interface_are_at_distance_zero(dim):
    """A cube whose faces run through nodes: corners, edges and all."""
    x = np.moveaxis(np.indices((13,) * dim), 0, -1) - 6.0
    q = np.abs(x) - 3
    d = np.linalg.norm(np.maximum(q, 0), axis=-1) + np.minimum(q.max(axis=-1), 0)
    found = de.redistance(d * (2 + np.sin(d)), 1.0)
    np.testing.assert_array_equal(found[d == 0], 0)
    assert np.abs(found - d).max() < 0.05


@DIMS
@pytest.mark.parametrize("sign", [1, -1])
def test_a_feature_of_a_single_node_is_not_lost(dim, sign):
    phi = np.ones((9,) * dim)
    phi[(4,) * dim] = -1
    found = sign * de.redistance(sign * phi, 1.0)
    r = np.linalg.norm(np.moveaxis(np.indices(phi.shape), 0, -1) - 4.0, axis=-1)
    np.testing.assert_array_equal(found < 0, phi < 0)
    assert -0.5 <= found.min() <= -0.25
    on_axis = r == np.abs(np.indices(phi.shape) - 4).max(axis=0)
    np.testing.assert_allclose(found[on_axis & (r > 0)], (r - 0.5)[on_axis & (r > 0)])
    assert np.abs(found - r + 0.5).max() < 1


@DIMS
def test_a_lone_node_on_the_interface_is_a_point(dim):
    phi = -np.ones((9,) * dim)
    phi[(4,) * dim] = 0
    r = np.linalg.norm(np.moveaxis(np.indices(phi.shape), 0, -1) - 4.0, axis=-1)
    np.testing.assert_allclose(de.redistance(phi, 1.0), -r, rtol=0, atol=1e-12)


@DIMS
def test_an_interface_that_leaves_the_box(dim):
    """A sphere of which the box holds a piece: by the rim, the distance is as good as elsewhere."""
    dx = (0.1, 0.11, 0.12)[:dim]
    axes = [h * np.arange(13) + 0.2 for h in dx]
    d = np.linalg.norm(np.meshgrid(*axes, indexing="ij"), axis=0) - 1
    found = de.redistance(level_set(d), dx)
    assert np.abs(found - d)[in_band(d, dx)].max() < 0.01 * max(dx)
    assert np.abs(found - d).max() < max(dx)


@DIMS
def test_the_fewest_nodes(dim):
    x = np.moveaxis(np.indices((4,) * dim), 0, -1)
    d = x[..., 0] - 1.3
    np.testing.assert_allclose(de.redistance(2 * d, 1.0), d, rtol=0, atol=1e-12)
    d = x[:3, ..., 0][tuple([slice(3)] * dim)] - 1.3
    np.testing.assert_allclose(de.reinitialize(2 * d, 1.0), d, rtol=0, atol=0.02)
