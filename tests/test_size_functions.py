"""Sizes against what is known of shapes: their curvatures, their medial axes, their widths."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

import distmesh_edu as de
from distmesh_edu.gradient_limiting import limit_gradient
from distmesh_edu.size_functions import (
    feature_size,
    medial_axis,
    size_from_curvature,
    size_from_data,
    size_from_distance,
    size_function,
)

SQUARE = de.Grid(((-2, -2), (2, 2)), 0.1)


def near(phi, grid):
    return np.abs(phi) <= 1.49 * max(grid.dx)


# ---- distance and data ----


def test_sizes_from_distance_grow_by_their_grading():
    fh = lambda p: size_from_distance(de.circle()(p), 0.1, 0.3)  # noqa: E731
    p = np.array([[0.0, 0.0], [1.0, 0.0], [3.0, 4.0]])
    np.testing.assert_allclose(fh(p), [0.4, 0.1, 1.3])
    h = fh(SQUARE.points)
    np.testing.assert_allclose(limit_gradient(h, 0.3, 0.1), h, atol=1e-3)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_sizes_from_data_let_them_change_by_so_much(dim):
    slope = np.array((0.3, -0.4, 1.2))[:dim]
    dx = (0.1, 0.2, 0.15)[:dim]
    data = np.moveaxis(np.indices((9, 8, 7)[:dim]), 0, -1) * dx @ slope
    h = size_from_data(data, dx, 0.05, 0.01, 1.0)
    np.testing.assert_allclose(h, 0.05 / np.linalg.norm(slope))
    assert (size_from_data(data, dx, 0.05, 0.3, 1.0) == 0.3).all()
    assert (size_from_data(np.ones((5, 5)), 0.1, 0.05, 0.3, 1.0) == 1.0).all()


# ---- curvature ----


@pytest.mark.parametrize("scale", [1.0, 7.0])
@pytest.mark.parametrize(("fd", "radius"), [(de.circle(radius=1.2), 1.2), (de.circle(), 1.0)])
def test_a_circle_has_one_size_at_its_boundary(fd, radius, scale):
    """2 pi / angle edges to the turn, whatever the slope of phi and however far off the node."""
    for grid in (SQUARE, de.Grid(((-2, -2), (2, 2)), (0.1, 0.05))):
        phi = fd(grid.points)
        h = size_from_curvature(scale * phi, grid.dx, 0.01, 9.0, angle=0.25)
        np.testing.assert_allclose(h[near(phi, grid)], 0.25 * radius, rtol=0.02)
        assert (h[np.abs(phi) > 2 * max(grid.dx)] == 9.0).all()


def test_an_ellipse_is_finest_at_its_ends():
    grid = de.Grid(((-2.5, -1.5), (2.5, 1.5)), 0.025)
    a, b = 2.0, 1.0
    h = size_from_curvature(de.ellipse()(grid.points), grid.dx, 1e-3, 9.0, angle=1.0)
    i, j = round(4.5 / 0.025), round(1.5 / 0.025)
    assert h[i, j] == pytest.approx(b**2 / a, rel=0.02)  # at (2, 0)
    assert h[round(2.5 / 0.025), round(2.5 / 0.025)] == pytest.approx(a**2 / b, rel=0.02)


@pytest.mark.parametrize(
    ("fd", "kappa"),
    [
        (de.sphere(), lambda p: np.ones(p.shape[:-1])),
        (de.torus(), None),
        (lambda p: np.hypot(p[..., 0], p[..., 1]) - 0.8, lambda p: np.full(p.shape[:-1], 1 / 0.8)),
        (lambda p: p[..., 0] * p[..., 1] / 2 - p[..., 2], None),
    ],
    ids=["ball", "torus", "cylinder", "saddle"],
)
def test_in_space_the_larger_curvature_counts(fd, kappa):
    """Against the eigenvalues of the second derivatives, in the tangent plane at the boundary."""
    grid = de.Grid(((-1.6,) * 3, (1.6,) * 3), 0.1)
    phi = fd(grid.points)
    h = size_from_curvature(phi, grid.dx, 1e-3, 1e3, angle=1.0)
    slope = np.linalg.norm(de.gradient(phi, grid.dx), axis=-1)
    chosen = (np.abs(phi) <= 0.8 * 0.1 * slope) & (np.abs(grid.points) < 1.4).all(axis=-1)
    p = grid.points[chosen][::7]
    foot = de.closest_point(fd, p) if kappa is None else p
    expected = np.array([largest_curvature(fd, x) for x in foot]) if kappa is None else kappa(p)
    np.testing.assert_allclose(h[chosen][::7] * expected, 1, atol=0.2)  # tube: 3 cells


def largest_curvature(fd, x, step=1e-3):
    e = step * np.eye(3)
    g = np.array([fd(x + d) - fd(x - d) for d in e]) / (2 * step)
    hessian = np.array(
        [[fd(x + a + b) - fd(x + a - b) - fd(x - a + b) + fd(x - a - b) for b in e] for a in e]
    ) / (4 * step**2)
    n = g / np.linalg.norm(g)
    tangent = np.eye(3) - np.outer(n, n)
    return np.abs(np.linalg.eigvalsh(tangent @ hessian @ tangent)).max() / np.linalg.norm(g)


def test_a_corner_gets_the_smallest_size_and_a_side_the_largest():
    grid = de.Grid(((-2, -2), (2, 2)), 0.05)
    phi = de.rectangle(((-1, -1), (1, 1)))(grid.points)
    h = size_from_curvature(phi, grid.dx, 0.03, 0.7)
    assert h[60, 60] == pytest.approx(0.03, rel=0.3)
    assert h[60, 40] == 0.7


# ---- the medial axis, and how wide a region is ----

T = np.linspace(0, 1, 2001)[:, None]
TURN = np.array([[np.cos(0.4), np.sin(0.4)], [-np.sin(0.4), np.cos(0.4)]])
RECTANGLE = np.concatenate(
    [T * (2, 0) - (1, 0), *((s, 0) + T * (s, t) for s in (-1, 1) for t in (-1, 1))]
)
RING = np.concatenate((np.cos(2 * np.pi * T), np.sin(2 * np.pi * T)), axis=1)
X, Y = np.meshgrid(np.linspace(-0.5, 0.5, 41), np.linspace(-0.5, 0.5, 41))
SLAB = np.stack((X, Y, 0 * X), axis=-1).reshape(-1, 3)
BOX = ((-1.5, -1.5, -1.0), (1.5, 1.5, 1.0))
SHAPES = {
    "interval": (lambda p: np.abs(p[..., 0] - 0.13) - 1, ((-2,), (2,)), np.array([[0.13]])),
    "rectangle": (de.rectangle(((-2, -1), (2, 1))), ((-2.4, -1.2), (2.4, 1.2)), RECTANGLE),
    "turned": (
        de.rotation(de.rectangle(((-2, -1), (2, 1))), 0.4),
        ((-2.4, -2.4), (2.4, 2.4)),
        RECTANGLE @ TURN,
    ),
    "ellipse": (de.ellipse(), ((-2.4, -1.2), (2.4, 1.2)), T * (3, 0) - (1.5, 0)),
    "annulus": (
        lambda p: np.abs(np.hypot(p[..., 0], p[..., 1]) - 1) - 0.4,
        ((-1.6, -1.6), (1.6, 1.6)),
        RING,
    ),
    "disc": (de.circle(), ((-1.2, -1.2), (1.2, 1.2)), np.zeros((1, 2))),
    "ball": (de.sphere(), ((-1.2,) * 3, (1.2,) * 3), np.zeros((1, 3))),
}


@pytest.mark.parametrize("name", SHAPES)
def test_the_medial_axis_is_found_to_within_a_cell_or_so(name):
    """No point is off it, and none of it is missing: what is close to both is all that counts."""
    fd, bbox, exact = SHAPES[name]
    for dx in (0.1, 0.05) if len(bbox[0]) < 3 else (0.1,):
        grid = de.Grid(bbox, dx)
        phi = fd(grid.points)
        axis = medial_axis(phi, grid)
        found, _ = cKDTree(axis).query(grid.points)
        true, _ = cKDTree(exact).query(grid.points)
        assert np.abs(found - true)[phi < 0].max() < 1.2 * dx


def test_a_flat_box_has_its_middle_plane():
    grid = de.Grid(((-1.6, -1.6, -1.2), (1.6, 1.6, 1.2)), 0.1)
    axis = medial_axis(de.box(BOX)(grid.points), grid)
    flat = axis[np.abs(axis[:, :2]).max(axis=1) < 0.45]
    np.testing.assert_allclose(flat[:, 2], 0, atol=1e-12)
    assert cKDTree(axis).query(SLAB)[0].max() < 0.071


def test_the_middle_of_a_strip_is_found_wherever_it_lies_between_nodes():
    grid = de.Grid((0, 4), 0.125)
    for middle in np.linspace(1.9, 2.1, 17):
        axis = medial_axis(np.abs(grid.axes[0] - middle) - 1.2, grid)
        np.testing.assert_allclose(axis, middle, atol=1e-12)


def test_features_are_half_as_wide_as_what_they_lie_between():
    grid = de.Grid(((-1.6, -1.6), (1.6, 1.6)), 0.05)
    phi = SHAPES["annulus"][0](grid.points)
    np.testing.assert_allclose(feature_size(phi, grid)[phi < 0], 0.4, atol=0.05)
    phi = SHAPES["ellipse"][0](grid.points)  # its ends are outside of this box
    assert feature_size(phi, grid)[32, 51] == pytest.approx(1.0, abs=0.05)  # at (0, 0.95)


# ---- all together ----


def test_a_size_function_keeps_to_its_bounds_and_its_slope():
    grid = de.Grid(((-2.2, -1.2), (2.2, 1.2)), 0.05)
    fh = size_function(de.ellipse(), grid, 0.1, 0.4, g=0.2)
    h = fh(grid.points)
    inside = de.ellipse()(grid.points) <= 0
    assert h.min() >= 0.1
    assert h.max() <= 0.4
    for axis in range(2):
        both = np.diff(np.where(inside, h, np.nan), axis=axis)
        assert np.nanmax(np.abs(both)) <= 0.2 * 0.05 * (1 + 1e-9)
    # At the ends the radius of curvature is 1/2, and half a radian of it a quarter.
    assert fh(np.array([[1.95, 0.0]])) == pytest.approx(0.25, abs=0.03)


def test_each_wish_counts_and_may_be_left_out():
    grid = de.Grid(((-1.6, -1.6), (1.6, 1.6)), 0.05)
    fd = SHAPES["annulus"][0]
    at = np.array([1.0, 0.0])
    sizes = [
        size_function(fd, grid, 0.01, 0.9, angle=angle, across=across, also=also)(at)
        for angle, across, also in (
            (None, None, None),
            (None, 4.0, None),
            (None, 8.0, None),
            (0.2, None, None),
            (None, None, lambda p: 0.05 + 0 * p[..., 0]),
        )
    ]
    # 0.12 on the inner circle of radius 0.6, and 0.3 times the way to the middle
    np.testing.assert_allclose(sizes, [0.9, 0.2, 0.1, 0.12 + 0.3 * 0.4, 0.05], atol=0.03)


def test_only_the_zeros_of_fd_count():
    grid = de.Grid(((-1.4, -1.4), (1.4, 1.4)), 0.1)
    a = size_function(de.circle(), grid, 0.05, 1.0)
    b = size_function(lambda p: 3 * ((p**2).sum(axis=-1) - 1), grid, 0.05, 1.0)
    inside = grid.points[de.circle()(grid.points) < 0]
    np.testing.assert_allclose(a(inside), b(inside), atol=0.03)


@pytest.mark.parametrize("dim", [1, 3])
def test_on_a_line_and_in_space(dim):
    grid = de.Grid(((-1.3,) * dim, (1.3,) * dim), 0.1)
    fh = size_function(de.sphere((0.0,) * dim), grid, 0.05, 1.0, angle=0.2)
    expected = 0.5 if dim == 1 else 0.2 + 0.3
    assert fh(np.zeros(dim)) == pytest.approx(expected, abs=0.06)
    if dim == 3:
        assert fh(np.array([0.95, 0.0, 0.0])) == pytest.approx(0.2 + 0.3 * 0.05, abs=0.03)


def test_a_wall_parts_two_chambers():
    """One is to be fine: the other, behind a wall thinner than a chamber, does not hear of it."""
    chambers = de.union(
        de.rectangle(((-1, -0.5), (-0.1, 0.5))), de.rectangle(((0.1, -0.5), (1, 0.5)))
    )
    grid = de.Grid(((-1.2, -0.6), (1.2, 0.6)), 0.05)
    fine = lambda p: np.where(p[..., 0] < 0, 0.02, 1.0)  # noqa: E731
    fh = size_function(chambers, grid, 0.01, 0.5, angle=None, across=None, also=fine)
    left, right = fh(np.array([[-0.2, 0.0], [0.2, 0.0]]))
    assert left == pytest.approx(0.02)
    assert right == pytest.approx(0.5)


# ---- what is said of bad arguments ----

PHI = de.circle()(SQUARE.points)
CURVED = {"phi": PHI, "dx": 0.1, "smallest": 0.1, "largest": 1.0}
DATA = {"data": PHI, "dx": 0.1, "change": 0.1, "smallest": 0.1, "largest": 1.0}
WHOLE = {"fd": de.circle(), "grid": SQUARE, "smallest": 0.1, "largest": 1.0}
NAN = np.where(PHI > 1.8, np.nan, PHI)


@pytest.mark.parametrize(
    ("function", "arguments", "words"),
    [
        (size_from_distance, {"d": np.nan, "smallest": 0.1, "grading": 0.3}, "d must be finite"),
        (size_from_distance, {"d": 1.0, "smallest": 0.0, "grading": 0.3}, "smallest must be one"),
        (size_from_distance, {"d": 1.0, "smallest": 0.1, "grading": -1}, "grading must be one num"),
        (size_from_curvature, CURVED | {"phi": NAN}, "phi must be finite"),
        (size_from_curvature, CURVED | {"phi": PHI + 9}, "phi must have an interface"),
        (size_from_curvature, CURVED | {"phi": PHI[0] - 1.5}, "on a line nothing is curved"),
        (size_from_curvature, CURVED | {"phi": PHI[:, 19:22]}, "phi must have 4 nodes"),
        (size_from_curvature, CURVED | {"dx": -0.1}, "dx must be positive"),
        (size_from_curvature, CURVED | {"smallest": 2.0}, "smallest must not be above largest"),
        (size_from_curvature, CURVED | {"largest": np.nan}, "largest must be finite"),
        (size_from_curvature, CURVED | {"angle": 0.0}, "angle must be one positive number"),
        (size_from_data, DATA | {"data": NAN}, "data must be finite"),
        (size_from_data, DATA | {"change": 0.0}, "change must be one positive number"),
        (size_from_data, DATA | {"smallest": -1.0}, "smallest must be one positive number"),
        (
            medial_axis,
            {"phi": PHI[:25], "grid": SQUARE},
            r"grid's shape \(41, 41\); got \(25, 41\)",
        ),
        (medial_axis, {"phi": PHI + 9, "grid": SQUARE}, "phi must have an interface"),
        (medial_axis, {"phi": NAN, "grid": SQUARE}, "phi must be finite"),
        (feature_size, {"phi": np.where(PHI < -0.99, -0.01, 1), "grid": SQUARE}, "no medial axis"),
        (size_function, WHOLE | {"fd": lambda p: 1 + p[..., 0] ** 2}, "must have an interface"),
        (size_function, WHOLE | {"fd": lambda p: np.nan * p[..., 0]}, "fd must be finite"),
        (size_function, WHOLE | {"smallest": 0.0}, "smallest must be one positive number"),
        (size_function, WHOLE | {"g": 0.0}, "g must be one positive number"),
        (size_function, WHOLE | {"across": -4}, "across must be one positive number"),
        (size_function, WHOLE | {"angle": -4}, "angle must be one positive number"),
        (size_function, WHOLE | {"also": lambda p: p}, "also must return one value a point"),
        (size_function, WHOLE | {"also": lambda p: 0 * p[..., 0] + np.inf}, "also must be finite"),
    ],
)
def test_bad_arguments_are_named(function, arguments, words):
    with pytest.raises(ValueError, match=words):
        function(**arguments)


def test_what_is_no_field_is_named():
    for name in ("fd", "also"):
        with pytest.raises(TypeError, match=f"{name} must be a field"):
            size_function(**WHOLE | {name: 3.0})
