"""The grid: nodes where they should be, and arrays that become fields again."""

import numpy as np
import pytest

import distmesh_edu as de

BOX = ((-2.0, -1.0), (2.0, 1.0))


def test_nodes_include_both_ends_and_follow_ij_order():
    grid = de.Grid(BOX, (0.5, 0.25))
    assert grid.shape == (9, 9)
    assert grid.points.shape == (9, 9, 2)
    x, y = grid.axes
    np.testing.assert_allclose(grid.points[3, 5], (x[3], y[5]))
    np.testing.assert_allclose((x[0], x[-1], y[0], y[-1]), (-2, 2, -1, 1))


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_grids_of_one_to_three_dimensions(dim):
    grid = de.Grid(((0.0,) * dim, (1.0,) * dim), 0.25)
    assert grid.dim == dim
    assert grid.points.shape == (5,) * dim + (dim,)
    plane = grid.points @ np.arange(1.0, dim + 1)
    p = np.random.default_rng(0).uniform(0, 1, (20, dim))
    for degree in (1, 3):
        np.testing.assert_allclose(
            grid.interpolate(plane, degree=degree)(p), p @ np.arange(1.0, dim + 1), atol=1e-12
        )


def test_a_line_may_be_given_as_two_numbers():
    assert de.Grid((0, 1), 0.5) == de.Grid(((0,), (1,)), 0.5)


def test_the_grid_cannot_be_changed():
    grid = de.Grid(BOX, 0.5)
    with pytest.raises(AttributeError):
        grid.dx = (1.0, 1.0)


@pytest.mark.parametrize(("degree", "order"), [(1, 2), (3, 4)])
def test_order_of_interpolation(degree, order):
    p = np.random.default_rng(1).uniform(-0.9, 0.9, (2000, 2))

    def error(dx):
        grid = de.Grid(((-1, -1), (1, 1)), dx)
        x, y = np.moveaxis(grid.points, -1, 0)
        field = grid.interpolate(np.sin(3 * x) * np.cos(2 * y), degree=degree)
        return np.abs(field(p) - np.sin(3 * p[:, 0]) * np.cos(2 * p[:, 1])).max()

    assert np.log2(error(1 / 16) / error(1 / 32)) == pytest.approx(order, abs=0.3)


def test_linear_interpolation_puts_the_circle_inside_itself():
    """Errata E5.6a: the boundary lies up to dx**2 / 8 inside (0.00125 for dx = 0.1)."""
    grid = de.Grid(((-2, -2), (2, 2)), 0.1)
    angle = np.linspace(0, 2 * np.pi, 1000)
    ring = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    values = de.circle()(grid.points)
    linear, cubic = (grid.interpolate(values, degree=k)(ring) for k in (1, 3))
    assert linear.min() > -1e-12
    assert 0.001 < linear.max() < 0.00126
    assert np.abs(cubic).max() < 2e-5


def test_a_periodic_axis_stores_its_end_once_and_wraps():
    grid = de.Grid(((0, 0), (2 * np.pi, 1)), (2 * np.pi / 32, 0.25), periodic=(True, False))
    assert grid.shape == (32, 5)
    field = grid.interpolate(np.sin(grid.points[..., 0]))
    x = np.array([-7.0, -0.05, 0.0, 6.25, 6.3, 100.0])
    p = np.stack((x, np.full_like(x, 0.5)), axis=1)
    np.testing.assert_allclose(field(p), np.sin(x), atol=2e-6)


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: de.Grid(BOX, 0), ValueError, "dx must be positive"),
        (lambda: de.Grid(BOX, -0.1), ValueError, "dx must be positive"),
        (lambda: de.Grid(BOX, 0.3), ValueError, "dx must divide the box.*Take 4 / 13 or 4 / 14"),
        (lambda: de.Grid(BOX, 5), ValueError, "dx must divide the box.*Take 4 / 1[.]"),
        (lambda: de.Grid(BOX, (0.5, 0.5, 0.5)), ValueError, "one for each of the 2 axes"),
        (lambda: de.Grid(BOX, np.nan), ValueError, "dx must be finite"),
        (lambda: de.Grid((BOX[1], BOX[0]), 0.5), ValueError, "bbox must hold the lower corner"),
        (lambda: de.Grid("box", 0.5), TypeError, "bbox must hold real numbers"),
        (lambda: de.Grid(BOX, 0.5).interpolate(np.zeros((5, 9))), ValueError, "grid's shape"),
        (lambda: de.Grid(BOX, 0.5).interpolate(np.full((9, 5), np.nan)), ValueError, "finite"),
        (lambda: de.Grid(BOX, 0.5).interpolate(np.zeros((9, 5)), degree=2), ValueError, "degree"),
        (lambda: de.Grid(BOX, 1).interpolate(np.zeros((5, 3))), ValueError, "4 nodes along each"),
    ],
)
def test_bad_input_is_named(make, error, words):
    with pytest.raises(error, match=words):
        make()


# Beyond the box.


def boxed(dim):
    """Return a grid whose spacing differs from axis to axis."""
    return de.Grid((np.arange(dim) - 1.0, np.arange(dim) + 1.0), np.array([0.25, 0.2, 0.4])[:dim])


def beyond(grid, cells, count=400):
    """Return random points up to so many cells beyond the box."""
    lower, upper = np.array(grid.bbox)
    margin = cells * np.array(grid.dx)
    return np.random.default_rng(7).uniform(lower - margin, upper + margin, (count, grid.dim))


@pytest.mark.parametrize("degree", [1, 3])
@pytest.mark.parametrize("dim", [1, 2, 3])
def test_polynomials_go_on_for_two_cells(dim, degree):
    """In each coordinate of the spline's degree: it is its own interpolant, and continuation."""
    grid = boxed(dim)
    weights = np.random.default_rng(8).normal(size=(dim, degree + 1))

    def polynomial(p):
        return np.prod([np.polyval(weights[k], p[..., k]) for k in range(dim)], axis=0)

    field, p = grid.interpolate(polynomial(grid.points), degree=degree), beyond(grid, 2)
    np.testing.assert_allclose(field(p), polynomial(p), atol=1e-9)
    lower, upper = np.array(grid.bbox)
    assert ((p < lower).any(axis=0) & (p > upper).any(axis=0)).all()


@pytest.mark.parametrize("degree", [1, 3])
@pytest.mark.parametrize("dim", [1, 2, 3])
def test_farther_out_the_values_stay_what_they_were(dim, degree):
    """A cubic grew wild there, and a mesh generator found water behind the rim."""
    grid = boxed(dim)
    values = np.random.default_rng(9).normal(size=grid.shape)
    field, p = grid.interpolate(values, degree=degree), beyond(grid, 50)
    margin = 2 * np.array(grid.dx)
    lower, upper = np.array(grid.bbox) + (-margin, margin)
    near = np.clip(p, lower, upper)
    assert (np.abs(p - near).max(axis=0) > 40 * np.array(grid.dx)).all()
    np.testing.assert_array_equal(field(p), field(near))
    np.testing.assert_array_equal(field(1e300 * np.sign(p)), field(np.where(p < 0, lower, upper)))
    within = np.linspace(lower, upper, 41)
    rim = np.stack(np.meshgrid(*within.T, indexing="ij"), axis=-1)
    assert np.abs(field(p)).max() <= 1.5 * np.abs(field(rim)).max()


def test_a_distance_far_from_its_grid_is_positive_still():
    grid = de.Grid(((-2, -2), (2, 2)), 0.1)
    field = grid.interpolate(de.circle()(grid.points))
    p = beyond(grid, 1000, 5000)
    p = p[np.abs(p).max(axis=1) > 2]
    assert field(p).min() > 0.9
    assert field(p).max() < np.hypot(2.2, 2.2)


def test_a_periodic_axis_has_no_beyond():
    grid = de.Grid(((0, 0), (2 * np.pi, 1)), (2 * np.pi / 32, 0.25), periodic=(True, False))
    x, y = np.moveaxis(grid.points, -1, 0)
    field, (u, v) = grid.interpolate(np.sin(x) * (1 + y)), beyond(grid, 40).T
    expected = np.sin(u) * (1 + np.clip(v, -0.5, 1.5))
    np.testing.assert_allclose(field(np.stack((u, v), axis=1)), expected, atol=2e-5)
