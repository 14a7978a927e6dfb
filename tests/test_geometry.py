"""What an implicit function knows of its boundary: exact on planes, second order on curves."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import distmesh_edu as de
from distmesh_edu import examples, geometry
from distmesh_edu import implicit_functions as shapes

DIMS = pytest.mark.parametrize("dim", [1, 2, 3])
PLANE_AND_SPACE = pytest.mark.parametrize("dim", [2, 3])
SPACING = (0.25, 0.2, 0.125)  # one for each axis


def grid(dim, dx=None, reach=1.5):
    return de.Grid(([-reach] * dim, [reach] * dim), dx or (0.25, 0.2, 0.125)[:dim])


def ball(dim, radius=1.0, squared=False):
    """Return a field with this zero set, off the nodes: the distance, or one that is not."""
    center = np.array([0.03, -0.02, 0.01])[:dim]
    if squared:
        return lambda p: ((p - center) ** 2).sum(axis=-1) - radius**2
    return shapes.sphere(center, radius)


def order(errors):
    """Return the observed orders from one halving of dx to the next."""
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


# ---- the gradient, normals, curvatures on grids ----


@DIMS
def test_the_gradient_of_a_quadratic_is_exact_at_the_rim_too(dim):
    g = grid(dim)
    rng = np.random.default_rng(dim)
    matrix, vector = rng.normal(size=(dim, dim)), rng.normal(size=dim)
    matrix = matrix + matrix.T
    phi = np.einsum("...i,ij,...j->...", g.points, matrix, g.points) / 2 + g.points @ vector
    exact = g.points @ matrix + vector
    np.testing.assert_allclose(geometry.gradient(phi, g.dx), exact, atol=1e-12)
    length = np.linalg.norm(exact, axis=-1, keepdims=True)
    np.testing.assert_allclose(geometry.unit_normal(phi, g.dx), exact / length, atol=1e-11)


@DIMS
def test_the_gradient_is_second_order(dim):
    errors = []
    for n in (20, 40, 80):
        g = grid(dim, 3 / n)
        phi = np.sin(g.points.sum(axis=-1)) * np.exp(g.points[..., 0] / 2)
        x, s = g.points[..., 0], g.points.sum(axis=-1)
        along = [np.exp(x / 2) * (np.cos(s) + (axis == 0) * np.sin(s) / 2) for axis in range(dim)]
        errors.append(np.abs(geometry.gradient(phi, g.dx) - np.stack(along, axis=-1)).max())
    np.testing.assert_allclose(order(errors), 2, atol=0.2)


@PLANE_AND_SPACE
@pytest.mark.parametrize("squared", [False, True])
def test_curvature_is_second_order_on_a_ball(dim, squared):
    errors = []
    for n in (40, 80) if dim == 3 else (40, 80, 160):
        g = grid(dim, 3 / n)
        phi = np.sin(ball(dim, squared=squared)(g.points))  # neither a distance nor a quadratic
        r = np.linalg.norm(g.points - np.array([0.03, -0.02, 0.01])[:dim], axis=-1)
        band = np.abs(r - 1) < 0.3
        exact = (dim - 1) / r[band]
        errors.append(np.abs(geometry.curvature(phi, g.dx)[band] - exact).max())
        mean = geometry.mean_curvature(phi, g.dx)[band]
        np.testing.assert_allclose(mean * (dim - 1), geometry.curvature(phi, g.dx)[band])
    np.testing.assert_allclose(order(errors), 2, atol=0.2)


@PLANE_AND_SPACE
def test_curvature_is_second_order_at_the_rim_too(dim):
    def waves(p):
        return 2 * p[..., 0] + np.sin(p.sum(axis=-1)) + 0.2 * np.cos(2 * p[..., 1])

    errors = []
    for n in (24, 48):
        g = grid(dim, 3 / n)
        exact = geometry.curvature_at(waves, g.points)
        errors.append(np.abs(geometry.curvature(waves(g.points), g.dx) - exact).max())
    np.testing.assert_allclose(order(errors), 2, atol=0.2)


@DIMS
def test_a_plane_is_not_curved(dim):
    g = grid(dim)
    phi = shapes.half_plane(np.arange(1, dim + 1))(g.points)
    np.testing.assert_allclose(geometry.curvature(phi, g.dx), 0, atol=1e-11)
    np.testing.assert_allclose(np.linalg.norm(geometry.gradient(phi, g.dx), axis=-1), 1)


def test_a_catenoid_is_curved_but_not_in_the_mean():
    """Curvature 0 does not mean a plane (errata E2.4b)."""

    def catenoid(p):
        return np.hypot(p[..., 0], p[..., 1]) - np.cosh(p[..., 2])

    z, t = np.array([0.0, 0.4, -0.7]), np.array([0.3, 2.0, 4.0])
    p = np.stack((np.cosh(z) * np.cos(t), np.cosh(z) * np.sin(t), z), axis=-1)
    np.testing.assert_allclose(geometry.curvature_at(catenoid, p), 0, atol=1e-6)


def thesis_2_10(p):
    """Return the curvature of a sphere as printed: each denominator lacks phi_z squared."""
    x, y, z = 2 * p
    xx = yy = zz = 2.0
    top = (x * x * yy + y * y * xx) + (x * x * zz + z * z * xx) + (y * y * zz + z * z * yy)
    return top / (x * x + y * y) ** 1.5


@pytest.mark.parametrize(
    ("direction", "printed"), [((1, 1, 1), 3.674), ((0.6, 0, 0.8), 9.259), ((0.01, 0, 1), 2.0e6)]
)
def test_the_sphere_has_curvature_two_and_not_what_is_printed(direction, printed):
    p = np.array(direction) / np.linalg.norm(direction)
    assert thesis_2_10(p) == pytest.approx(printed, rel=1e-3)
    for field in (shapes.sphere(), lambda p: (p**2).sum(axis=-1) - 1):
        assert geometry.curvature_at(field, p) == pytest.approx(2, abs=1e-6)
        assert geometry.mean_curvature_at(field, p) == pytest.approx(1, abs=1e-6)


def test_where_the_gradient_is_zero_nothing_is_nan():
    g = de.Grid(((-1, -1), (1, 1)), 0.25)
    phi = (g.points**2).sum(axis=-1) - 0.5
    assert (geometry.unit_normal(phi, g.dx)[4, 4] == 0).all()
    assert geometry.curvature(phi, g.dx)[4, 4] == 0
    for flat in (np.ones((5, 6)), np.zeros((4, 4, 4))):
        assert (geometry.curvature(flat, 0.1) == 0).all()
        assert (geometry.unit_normal(flat, 0.1) == 0).all()
    middle = np.zeros((1, 2))
    assert (geometry.unit_normal_at(de.circle(), middle) == 0).all()
    assert geometry.curvature_at(lambda p: (p**2).sum(axis=-1), middle)[0] == 0


@DIMS
def test_closest_points_on_a_grid_lie_on_the_ball(dim):
    errors = []
    for n in (20, 40) if dim == 3 else (20, 40, 80):
        g = grid(dim, 3 / n)
        c = geometry.closest_points(ball(dim)(g.points), g)
        center = np.array([0.03, -0.02, 0.01])[:dim]
        offset = g.points - center
        r = np.linalg.norm(offset, axis=-1, keepdims=True)
        errors.append(np.abs(c - center - offset / r)[np.abs(r[..., 0] - 1) < 0.4].max())
    if dim == 1:
        np.testing.assert_allclose(errors, 0, atol=1e-13)
    else:
        np.testing.assert_allclose(order(errors), 2, atol=0.2)


# ---- volume and interface ----


@DIMS
@given(data=st.data())
@settings(max_examples=40, deadline=None)
def test_plane_cuts_are_exact(dim, data):
    """A plane through the middle of a box halves it; its area comes from the box's own corners."""
    normal = np.array(data.draw(st.lists(st.floats(-1, 1), min_size=dim, max_size=dim)))
    if np.abs(normal).max() < 1e-3:
        normal[0] = 1.0
    g = grid(dim)
    phi = shapes.half_plane(normal)(g.points)
    side = 3.0**dim
    if (np.abs(phi) > 1e-9).all():  # else the plane may run along nodes, where rounding decides
        assert geometry.volume(phi, g.dx) == pytest.approx(side / 2, rel=1e-12)
    both = geometry.volume(phi, g.dx) + geometry.volume(-phi, g.dx)
    assert both == pytest.approx(side, rel=1e-12)
    # Of a layer between two parallel planes: volume = area integrated over its thickness.
    levels = 0.1 + np.array([-1, 1]) * 1e-4
    layer = np.diff([geometry.volume(phi - level, g.dx) for level in levels])[0]
    area = geometry.interface_area(phi - 0.1, g.dx)
    assert layer == pytest.approx(2e-4 * area, rel=1e-3)


def test_cuts_of_a_cube_that_everybody_knows():
    g = de.Grid(((0, 0, 0), (1, 1, 1)), (0.25, 0.2, 0.5))
    s = g.points.sum(axis=-1)
    assert geometry.volume(s - 0.5, g.dx) == pytest.approx(0.5**3 / 6, rel=1e-12)
    assert geometry.interface_area(s - 0.5, g.dx) == pytest.approx(np.sqrt(3) / 8, rel=1e-12)
    # Half way along the diagonal the cut is a regular hexagon with sides sqrt(1/2).
    assert geometry.volume(s - 1.5, g.dx) == pytest.approx(0.5, rel=1e-12)
    assert geometry.interface_area(s - 1.5, g.dx) == pytest.approx(3 * np.sqrt(3) / 4, rel=1e-12)
    line = de.Grid((0, 1), 0.1)
    assert geometry.volume(line.axes[0] - 0.33, 0.1) == pytest.approx(0.33)
    assert geometry.interface_area(np.cos(20 * line.axes[0]), 0.1) == pytest.approx(6)


def test_a_boundary_that_runs_along_nodes_is_counted_once():
    for dim in (1, 2, 3):
        g = de.Grid(([-1] * dim, [1] * dim), 0.25)
        for phi in (g.points[..., 0], -g.points[..., -1], 3 * g.points[..., 0]):
            assert geometry.volume(phi, g.dx) == pytest.approx(2 ** (dim - 1), rel=1e-12)
            assert geometry.interface_area(phi, g.dx) == pytest.approx(2 ** (dim - 1), rel=1e-12)
    touching = np.abs(np.linspace(-1, 1, 9))
    assert geometry.volume(touching, 0.25) == 0
    assert geometry.interface_area(touching, 0.25) == 0


EXACT = {1: (2.0, 2.0), 2: (np.pi, 2 * np.pi), 3: (4 / 3 * np.pi, 4 * np.pi)}


@DIMS
@pytest.mark.parametrize("squared", [False, True])
def test_volume_and_area_of_a_ball_are_second_order(dim, squared):
    errors = []
    for n in (20, 40, 80):
        g = grid(dim, 3 / n)
        phi = ball(dim, squared=squared)(g.points)
        found = geometry.volume(phi, g.dx), geometry.interface_area(phi, g.dx)
        errors.append(np.abs(np.array(found) / EXACT[dim] - 1))
    errors = np.array(errors)
    if dim == 1:
        assert errors[:, 1].max() < 1e-12  # two points, always
        assert (errors[:, 0] < 0.1 * np.array([3 / 20, 3 / 40, 3 / 80]) ** 2 * 2).all()
    else:
        np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2, atol=0.2)
    assert errors[-1].max() < 2e-3


@PLANE_AND_SPACE
def test_volume_and_area_do_not_depend_on_the_size_of_phi_or_the_order_of_the_axes(dim):
    g = grid(dim)
    phi = ball(dim, squared=True)(g.points)
    for measure in (geometry.volume, geometry.interface_area):
        found = measure(phi, g.dx)
        assert measure(1e-6 * phi, g.dx) == pytest.approx(found, rel=1e-12)
        assert measure(phi.T, g.dx[::-1]) == pytest.approx(found, rel=1e-12)
        assert measure(phi, np.array(g.dx) * 2) == pytest.approx(
            found * 2 ** (dim - (measure is geometry.interface_area)), rel=1e-12
        )


def test_measures_of_an_ellipse_a_torus_and_a_capsule():
    g = de.Grid(((-2, -1.5), (2, 1.5)), 0.02)
    phi = shapes.ellipse(half_axes=(1.5, 1))(g.points)
    assert geometry.volume(phi, g.dx) == pytest.approx(1.5 * np.pi, rel=2e-4)
    assert geometry.interface_area(phi, g.dx) == pytest.approx(7.932719794645, rel=1e-4)
    g = de.Grid(((-1.5, -1.5, -0.6), (1.5, 1.5, 0.6)), 0.05)
    phi = shapes.torus(major_radius=1, minor_radius=0.4)(g.points)
    assert geometry.volume(phi, g.dx) == pytest.approx(2 * np.pi**2 * 0.16, rel=1e-2)
    assert geometry.interface_area(phi, g.dx) == pytest.approx(4 * np.pi**2 * 0.4, rel=1e-2)
    phi = shapes.segment((-0.8, 0, 0), (0.8, 0, 0), 0.5)(g.points)
    assert geometry.volume(phi, g.dx) == pytest.approx(np.pi * (0.4 + 4 / 3 * 0.125), rel=5e-3)


# ---- fields at points ----


@DIMS
def test_differences_of_a_smooth_field(dim):
    rng = np.random.default_rng(dim)
    p, matrix = rng.uniform(-3, 3, (4, 5, dim)), rng.normal(size=(dim, dim))
    wave = rng.normal(size=dim)

    def field(q):
        return np.einsum("...i,ij,...j->...", q, matrix, q) + np.sin(q @ wave)

    exact = p @ (matrix + matrix.T) + np.cos(p @ wave)[..., None] * wave
    found = geometry.gradient_at(field, p)
    np.testing.assert_allclose(found, exact, rtol=1e-8, atol=1e-8)
    normal = exact / np.linalg.norm(exact, axis=-1, keepdims=True)
    np.testing.assert_allclose(geometry.unit_normal_at(field, p), normal, atol=1e-7)


def implicit_curvature_of_the_ellipse(t, a, b):
    return a * b / (a**2 * np.sin(t) ** 2 + b**2 * np.cos(t) ** 2) ** 1.5


def test_curvature_at_points_of_an_ellipse_whatever_function_gives_it():
    t = np.linspace(0, 2 * np.pi, 40)
    p = np.stack((2 * np.cos(t), np.sin(t)), axis=1)
    expected = implicit_curvature_of_the_ellipse(t, 2, 1)
    for field in (
        shapes.ellipse(),
        lambda p: p[..., 0] ** 2 / 4 + p[..., 1] ** 2 - 1,
        lambda p: np.exp(p[..., 0] ** 2 / 4 + p[..., 1] ** 2) - np.e,
    ):
        np.testing.assert_allclose(geometry.curvature_at(field, p), expected, atol=2e-5)
        np.testing.assert_allclose(geometry.mean_curvature_at(field, p), expected, atol=2e-5)


def test_a_step_of_ones_own_suits_small_shapes():
    small = shapes.sphere((0.0, 0.0, 0.0), 1e-6)
    p = np.array([[0.0, 1e-6, 0.0]])
    np.testing.assert_allclose(geometry.curvature_at(small, p, step=1e-10), 2e6, rtol=1e-5)
    np.testing.assert_allclose(geometry.gradient_at(small, p, step=1e-11), [[0, 1, 0]], atol=1e-5)


def test_large_coordinates_take_a_larger_step():
    far = shapes.sphere((1e6, 0.0, 0.0), 1e6)
    p = np.array([[1e6, 1e6, 0.0], [2e6, 0.0, 0.0]])
    np.testing.assert_allclose(geometry.curvature_at(far, p), 2e-6, rtol=1e-4)


# ---- the closest point ----


@pytest.mark.parametrize("axes", [(2, 1), (3, 0.5), (0.3, 0.2), (1, 1)])
def test_the_closest_point_of_an_ellipse_from_any_function(axes):
    p = np.random.default_rng(14).uniform(-4, 4, (400, 2)) * max(axes)
    p = p[(p / axes ** np.ones(2) ** 2).any(axis=1)]
    exact = shapes.ellipse(half_axes=axes)(p)
    p, exact = p[exact > 0], exact[exact > 0]
    for field in (
        lambda q: ((q / axes) ** 2).sum(axis=-1) - 1,
        lambda q: np.sqrt(((q / axes) ** 2).sum(axis=-1)) - 1,
    ):
        c = geometry.closest_point(field, p)
        np.testing.assert_allclose(field(c), 0, atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(p - c, axis=1), exact, rtol=1e-12, atol=1e-12)


@DIMS
def test_the_closest_point_is_where_the_point_came_from(dim):
    """Leave a point of an ellipsoid along its normal: it is the closest one, near by."""
    rng = np.random.default_rng(dim)
    half = np.array([1.5, 1.0, 0.8])[:dim]
    way = rng.normal(size=(200, dim))
    on_it = half * way / np.linalg.norm(way, axis=1, keepdims=True)
    normal = on_it / half**2
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    p = on_it + rng.uniform(-0.2, 2, (200, 1)) * normal
    c = geometry.closest_point(lambda q: ((q / half) ** 2).sum(axis=-1) - 1, p.reshape(4, 50, dim))
    assert c.shape == (4, 50, dim)
    np.testing.assert_allclose(c.reshape(200, dim), on_it, atol=1e-7)


def test_the_closest_point_of_a_curve_that_bends_both_ways():
    p = np.random.default_rng(15).uniform(-1.5, 1.5, (2000, 2))
    exact = np.abs(examples.five_petals_distance()(p))
    p, exact = p[exact < 0.15], exact[exact < 0.15]
    c = geometry.closest_point(examples.five_petals(), p)
    np.testing.assert_allclose(examples.five_petals_distance()(c), 0, atol=1e-11)
    np.testing.assert_allclose(np.linalg.norm(p - c, axis=1), exact, atol=1e-11)


def test_far_away_it_is_closer_than_its_neighbours_are():
    rng = np.random.default_rng(16)
    p = rng.uniform(-2, 2, (300, 2))
    p = p[np.linalg.norm(p, axis=1) > 1.0]
    c = geometry.closest_point(examples.five_petals(), p)
    exact, length = np.abs(examples.five_petals_distance()(p)), np.linalg.norm(p - c, axis=1)
    assert (length >= exact - 1e-12).all()
    assert 0.7 < (length <= exact + 1e-9).mean() < 1  # honest: not all are the closest of all
    normal = geometry.unit_normal_at(examples.five_petals(), c)
    tangent = np.stack((-normal[:, 1], normal[:, 0]), axis=1)
    for side in (-1e-3, 1e-3):
        beside = geometry.closest_point(examples.five_petals(), c + side * tangent)
        assert (np.linalg.norm(p - beside, axis=1) > length).all()


def test_the_closest_point_of_a_center_is_some_point():
    for dim in (2, 3):
        c = geometry.closest_point(lambda p: (p**2).sum(axis=-1) - 4, np.zeros((1, dim)))
        assert np.linalg.norm(c) == pytest.approx(2)


def test_a_field_without_zeros_has_no_closest_point():
    with pytest.warns(de.ConvergenceWarning, match="1 of 1 points have not come to rest after 7"):
        geometry.closest_point(lambda p: (p**2).sum(axis=-1) + 1, [(0.3, 0.4)], max_steps=7)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        geometry.closest_point(de.circle(), [(0.3, 0.4)])


def test_arguments_are_not_changed():
    p, phi = np.array([[0.3, 0.4]]), np.arange(16.0).reshape(4, 4)
    copies = p.copy(), phi.copy()
    geometry.closest_point(lambda q: (q**2).sum(axis=-1) - 1, p)
    geometry.curvature(phi, 1)
    geometry.volume(phi - 5, 1)
    np.testing.assert_array_equal(p, copies[0])
    np.testing.assert_array_equal(phi, copies[1])


GRID = de.Grid(((0, 0), (1, 1)), 0.25)


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: geometry.gradient(np.ones((2, 5)), 1), ValueError, "phi must have 3 nodes"),
        (lambda: geometry.curvature(np.ones((5, 3)), 1), ValueError, "phi must have 4 nodes"),
        (lambda: geometry.volume(np.ones((1, 5)), 1), ValueError, "phi must have 2 nodes"),
        (lambda: geometry.volume(np.ones((2,) * 4), 1), ValueError, "one, two or three axes"),
        (lambda: geometry.gradient([[1, 2, np.nan]] * 3, 1), ValueError, r"phi\[0, 2\] is nan"),
        (lambda: geometry.unit_normal(np.ones((5, 5)), 0), ValueError, "dx must be positive"),
        (lambda: geometry.interface_area(np.ones((5, 5)), (1, 2, 3)), ValueError, "dx must be one"),
        (lambda: geometry.mean_curvature(np.ones(5), 1), ValueError, "phi must be in the plane"),
        (lambda: geometry.closest_points(np.ones((5, 4)), GRID), ValueError, "the grid's shape"),
        (lambda: geometry.gradient_at(3, [(0, 0)]), TypeError, "fd must be a field"),
        (lambda: geometry.gradient_at(de.circle(), 3.0), ValueError, r"p must have the shape"),
        (lambda: geometry.gradient_at(de.circle(), [(0, 0)], step=0), ValueError, "step must be"),
        (lambda: geometry.curvature_at(de.circle(), np.ones((2, 4))), ValueError, "dim 1, 2 or 3"),
        (lambda: geometry.mean_curvature_at(abs, [(1.0,)]), ValueError, "p must be in the plane"),
        (lambda: geometry.closest_point(de.circle(), [(0, 0)], max_steps=0), ValueError, "max_ste"),
        (lambda: geometry.gradient_at(lambda p: p, [(0, 0)]), ValueError, "one value a point"),
    ],
)
def test_bad_input_is_named(make, error, words):
    with pytest.raises(error, match=words):
        make()
