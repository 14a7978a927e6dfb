"""Gradient limiting against what it must be: below h, as flat as asked, and the largest such."""

import itertools
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from scipy.spatial.distance import cdist

import distmesh_edu as de
from distmesh_edu.convection import upwind
from distmesh_edu.gradient_limiting import limit_gradient, limit_gradient_pde

DIMS = pytest.mark.parametrize("dim", [1, 2, 3])
BOTH = pytest.mark.parametrize("solver", [limit_gradient, limit_gradient_pde])
SHAPE = {1: (150,), 2: (26, 31), 3: (11, 9, 10)}
DX = (0.1, 0.13, 0.08)
G = 0.3


def nodes(dim):
    """Return the positions of the nodes, of shape (..., dim)."""
    return np.moveaxis(np.indices(SHAPE[dim]), 0, -1) * DX[:dim]


def envelope(h, g, dx):
    """Return min over y of h(y) + g |x - y|, by going through all pairs."""
    places = np.indices(h.shape).reshape(h.ndim, -1).T * np.broadcast_to(dx, h.ndim)
    return (g * cdist(places, places) + h.ravel()).min(axis=1).reshape(h.shape)


def wishes(kind, dim, seed=0):
    """Return sizes of several kinds."""
    rng = np.random.default_rng(seed)
    x = nodes(dim)
    if kind == "noise":
        return rng.uniform(0.02, 0.5, SHAPE[dim])
    if kind == "peaks":
        return np.where(rng.random(SHAPE[dim]) < 0.02, rng.uniform(0.01, 0.2, SHAPE[dim]), 3.0)
    if kind == "smooth, a little too steep":
        h = ndimage.gaussian_filter(rng.standard_normal(SHAPE[dim]), 3)
        slope = np.max(de.godunov_norm(h, 1.0, DX[:dim], differences=upwind))
        return 0.1 + (h - h.min()) * 1.5 * G / slope
    if kind == "huge":
        return 10.0 ** rng.uniform(-2, 8, SHAPE[dim])
    if kind == "plane":
        return 0.1 + G * 1.05 * (x @ np.array((0.9, 0.35, 0.26))[:dim])
    return 0.05 + G * 1.03 * np.linalg.norm(x - 0.4 * np.array(SHAPE[dim]) * DX[:dim], axis=-1)


KINDS = ("noise", "peaks", "smooth, a little too steep", "huge", "plane", "cone")


# ---- the envelope ----


@DIMS
@pytest.mark.parametrize("kind", KINDS)
def test_it_is_the_envelope(dim, kind):
    """To rounding on 95 % of the nodes, and within 1e-3 of the range everywhere."""
    h = wishes(kind, dim)
    error = limit_gradient(h, G, DX[:dim]) - envelope(h, G, DX[:dim])
    assert error.min() >= -1e-12 * h.max()
    assert (error <= 1e-11 * h.max()).mean() >= 0.95
    assert error.max() <= 1e-3 * np.ptp(h)


@pytest.mark.parametrize("kind", ["noise", "peaks", "huge"])
@DIMS
def test_rough_sizes_come_out_exact(dim, kind):
    h = wishes(kind, dim, seed=1)
    np.testing.assert_allclose(
        limit_gradient(h, G, DX[:dim]), envelope(h, G, DX[:dim]), rtol=1e-12, atol=1e-12
    )


@pytest.mark.parametrize("angle", [5, 10, 22.5, 33, 41])
@pytest.mark.parametrize("excess", [1.005, 1.04])
def test_a_plane_hardly_too_steep_is_flattened_in_any_direction(angle, excess):
    """No neighbour lies straight downhill: offers between neighbours alone would change nothing."""
    x = np.moveaxis(np.indices((65, 65)), 0, -1) / 64
    h = 0.1 + G * excess * x @ (np.cos(np.radians(angle)), np.sin(np.radians(angle)))
    exact = envelope(h, G, 1 / 64)
    assert (h - exact).max() > 20 * (limit_gradient(h, G, 1 / 64) - exact).max()


def test_a_source_that_no_neighbour_has_is_found_two_cells_away():
    """The neighbours on the way are just small enough to be sources themselves."""
    h = 0.1 + G * np.array([[0.0, 0.97], [0.97, 1.38], [3.0, 2.28]])
    found = limit_gradient(h, G, 1.0, inside=np.ones((3, 2), dtype=bool))
    assert found[2, 1] == pytest.approx(0.1 + G * np.sqrt(5))
    np.testing.assert_allclose(found, envelope(h, G, 1.0))


@given(dim=st.integers(1, 3), seed=st.integers(0, 2**32 - 1), g=st.floats(0.05, 5))
@settings(max_examples=40, deadline=None)
def test_random_sizes(dim, seed, g):
    """Nowhere below the envelope, and hardly above; any shape and spacing."""
    rng = np.random.default_rng(seed)
    shape = rng.integers(2, (60, 14, 7)[dim - 1], dim)
    dx = rng.uniform(1, 2, dim)
    h = 0.1 + ndimage.gaussian_filter(rng.exponential(size=shape), rng.choice([0, 1, 3]))
    error = limit_gradient(h, g, dx) - envelope(h, g, dx)
    assert error.min() >= -1e-12 * h.max()
    assert error.max() <= 0.03 * g * dx.min() + 1e-12 * h.max()


@DIMS
@pytest.mark.parametrize("kind", ["noise", "peaks", "cone"])
def test_it_is_below_h_flat_enough_and_stays_as_it_is(dim, kind):
    h = wishes(kind, dim)
    limited = limit_gradient(h, G, DX[:dim])
    assert (limited <= h).all()
    for axis in range(dim):  # along grid lines it holds exactly
        assert np.abs(np.diff(limited, axis=axis)).max() <= G * DX[axis] * (1 + 1e-9)
    np.testing.assert_allclose(limit_gradient(limited, G, DX[:dim]), limited, rtol=0, atol=1e-11)


@DIMS
def test_what_is_flat_enough_is_returned_unchanged(dim):
    h = 0.2 + G / 2 * np.abs(nodes(dim) @ np.array((0.9, -0.4, 0.2))[:dim])
    for solver in (limit_gradient, limit_gradient_pde):
        np.testing.assert_array_equal(solver(h, G, DX[:dim]), h)


@DIMS
@BOTH
def test_smaller_wishes_never_make_it_larger(dim, solver):
    h = wishes("peaks", dim)
    less = np.minimum(h, wishes("noise", dim))
    assert (solver(less, G, DX[:dim]) <= solver(h, G, DX[:dim]) + 1e-4).all()


@BOTH
def test_sizes_and_spacings_may_have_any_unit(solver):
    h = wishes("noise", 2)
    mm = solver(1000 * h, G, 1000 * np.array(DX[:2]))
    np.testing.assert_allclose(mm, 1000 * solver(h, G, DX[:2]), rtol=1e-9)


@BOTH
def test_what_it_is_given_stays_as_it_was(solver):
    h, inside = wishes("noise", 2), np.ones(SHAPE[2], dtype=bool)
    inside[3, 4] = False
    h.setflags(write=False)
    inside.setflags(write=False)
    solver(h, G, DX[:2], inside=inside)


# ---- the equation ----


def sources(n, dim=2):
    """Return sizes with two point sources in the unit box, and the exact envelope."""
    x = np.moveaxis(np.indices((n,) * dim), 0, -1) / (n - 1)
    h, exact = np.ones((n,) * dim), np.ones((n,) * dim)
    for share, size in ((0.25, 0.05), (0.75, 0.2)):
        at = (round(share * (n - 1)),) * dim
        h[at] = size
        exact = np.minimum(exact, size + 0.3 * np.linalg.norm(x - x[at], axis=-1))
    return h, exact


def test_the_equation_on_a_line_ends_at_the_envelope():
    x = np.linspace(-2, 2, 401)
    h = np.where(np.abs(x) < 0.05, 0.1, 1.0)
    found = limit_gradient_pde(h, 0.3, 0.01, tolerance=1e-10)
    np.testing.assert_allclose(found, envelope(h, 0.3, 0.01), rtol=0, atol=1e-10)


@pytest.mark.parametrize(("dim", "coarse", "fine"), [(2, 41, 81), (3, 13, 25)])
def test_the_equation_is_of_first_order(dim, coarse, fine):
    """But for the logarithm that a point source costs: 0.7 or so is seen instead of 1."""
    errors = []
    for n in (coarse, fine):
        h, exact = sources(n, dim)
        found = limit_gradient_pde(h, 0.3, 1 / (n - 1))
        assert (found >= exact - 1e-12).all()
        errors.append(np.abs(found - exact).mean())
    assert 0.6 < np.log2(errors[0] / errors[1]) < 1.1


def test_the_equation_meets_the_numbers_of_an_independent_run():
    """Two point sources, g = 0.3: the trial that the errata rest on found these errors."""
    for n, worst in ((41, 0.0079), (81, 0.0049), (161, 0.0029)):
        h = np.ones((n, n))
        x = np.linspace(0, 1, n)
        exact = np.ones((n, n))
        for i, j, size in ((n // 4, n // 4, 0.05), (n // 2, 3 * n // 4, 0.2)):
            h[i, j] = size
            cone = size + 0.3 * np.hypot(x[:, None] - x[i], x - x[j])
            exact = np.minimum(exact, cone)
        found = limit_gradient_pde(h, 0.3, x[1])
        assert np.abs(found - exact).max() == pytest.approx(worst, rel=0.05)
        np.testing.assert_allclose(limit_gradient(h, 0.3, x[1]), exact, rtol=0, atol=1e-12)


@DIMS
def test_small_sizes_travel_at_speed_one(dim):
    """After a time t, nothing has changed farther than t from the small size, and much within."""
    h = np.full(SHAPE[dim], 5.0)
    middle = tuple(n // 2 for n in SHAPE[dim])
    h[middle] = 0.1
    away = np.linalg.norm(nodes(dim) - nodes(dim)[middle], axis=-1)
    t = 0.6 if dim == 1 else 0.3
    found = limit_gradient_pde(h, 1.0, DX[:dim], time=t)
    far = away > t + 4 * max(DX)
    assert (found[far] > 4.9).all()
    assert (found[away < 0.5 * t] < 4.0).all()


def test_a_time_is_met_to_the_last_step():
    times = []
    limit_gradient_pde(
        wishes("noise", 2), G, 0.1, time=1.0, cfl=0.5, callback=lambda t, _: times.append(t)
    )
    assert times[-1] == pytest.approx(1.0)
    assert times[0] <= 0.5 * 0.1 / np.sqrt(2) + 1e-12
    h = wishes("noise", 2)
    np.testing.assert_array_equal(limit_gradient_pde(h, G, 0.1, time=0.0), h)


def test_a_callback_sees_sizes_fall_and_cannot_change_them():
    seen = []

    def record(_, h):
        assert not h.flags.writeable
        seen.append(h.copy())

    limit_gradient_pde(wishes("noise", 1), G, 0.1, callback=record)
    assert len(seen) > 3
    assert all((later <= earlier).all() for earlier, later in itertools.pairwise(seen))


def test_the_equation_ends_without_a_warning_on_all_kinds():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for kind in KINDS:
            if kind != "huge":
                limit_gradient_pde(wishes(kind, 2), G, DX[:2])


def test_a_cap_warns():
    """A tolerance below rounding cannot be met."""
    with pytest.warns(de.ConvergenceWarning, match="still moves after .* steps"):
        limit_gradient_pde(1 + 1e9 * wishes("noise", 2), G, 0.1, tolerance=1e-12)


# ---- ways inside a region ----


def behind_a_wall(solver, n=121):
    """Return the size found behind a wall, by a straight line through it, and by the way round."""
    x = np.linspace(0, 1, n)
    wall = (np.abs(x - 0.5) < 0.02)[:, None] & (x < 0.9)
    h = np.ones((n, n))
    h[5, 5] = 0.05
    way_round = np.hypot(0.5 - x[5], 0.9 - x[5]) + np.hypot(x[n - 6] - 0.5, 0.9 - x[5])
    found = solver(h, 0.3, x[1], inside=~wall)[n - 6, 5]
    return found, limit_gradient(h, 0.3, x[1])[n - 6, 5], 0.05 + 0.3 * way_round


def test_behind_a_wall():
    """The errata's numbers: straight through it 0.325, the equation 0.648, the way round 0.634."""
    found, through, way_round = behind_a_wall(limit_gradient)
    assert through == pytest.approx(0.325, abs=5e-4)
    assert way_round == pytest.approx(0.634, abs=5e-4)
    assert behind_a_wall(limit_gradient_pde)[0] == pytest.approx(0.648, abs=5e-4)
    # The wall ends at two corners, and is as thick as the nodes make it: longer by a cell or two.
    assert 0 < found - way_round < 0.3 * 2.5 / 120


def around_a_disc(solver, n):
    """Return the errors behind a disc that the ways bend around, over g dx."""
    x = np.linspace(0, 1, n)
    begin = round(0.1 * (n - 1))
    X, Y = np.meshgrid(x, x, indexing="ij")
    radius, r = 0.25, np.hypot(X - 0.5, Y - 0.5)
    h = np.full((n, n), 10.0)
    h[begin, n // 2] = 0.05
    touch = np.arccos(radius / 0.4) + np.arccos(np.clip(radius / np.maximum(r, radius), -1, 1))
    bend = np.arccos(np.clip((0.5 - X) / np.maximum(r, 1e-9), -1, 1)) - touch
    tangents = np.sqrt(0.4**2 - radius**2) + np.sqrt(np.maximum(r**2 - radius**2, 0))
    way = np.where(bend > 0, tangents + radius * bend, np.hypot(X - 0.1, Y - 0.5))
    inside = r >= radius
    error = solver(h, 0.3, x[1], inside=inside) - 0.05 - 0.3 * way
    return error[inside] / 0.3 / x[1]


def test_ways_around_a_bend_are_of_first_order():
    """Too long by a cell and a half at most, whatever the grid; the equation by many."""
    for n in (41, 81):
        error = around_a_disc(limit_gradient, n)
        assert error.min() > -0.05
        assert error.max() < 1.7
        assert around_a_disc(limit_gradient_pde, n).max() > 3


@BOTH
@DIMS
def test_pieces_know_nothing_of_each_other(dim, solver):
    h = wishes("noise", dim)
    inside = np.ones(SHAPE[dim], dtype=bool)
    cut = SHAPE[dim][0] // 2
    inside[cut : cut + 2] = False
    h[inside & (np.arange(SHAPE[dim][0]) > cut).reshape((-1,) + (1,) * (dim - 1))] += 100
    found = solver(h, G, DX[:dim], inside=inside)
    assert found[:cut].max() < 10
    assert found[cut + 2 :].min() > 90


@DIMS
def test_a_convex_region_has_the_envelope_of_its_nodes(dim):
    h = wishes("noise", dim, seed=3)
    inside = np.linalg.norm(nodes(dim) - nodes(dim).max(axis=tuple(range(dim))) / 2, axis=-1)
    inside = inside <= 0.9 * inside.max() / np.sqrt(dim)
    # What is outside does not matter; were it a source, it would be the strongest.
    exact = envelope(np.where(inside, h, 1e9), G, DX[:dim])
    found = limit_gradient(np.where(inside, h, 1e-6), G, DX[:dim], inside=inside)
    np.testing.assert_allclose(found[inside], exact[inside], rtol=0, atol=0.02 * G * DX[0])


@BOTH
def test_outside_stands_the_value_of_the_nearest_node_inside(solver):
    h = np.array([0.001, 0.1, 0.5, 0.9, 0.001, 0.002])
    inside = np.array([False, True, True, True, False, False])
    found = solver(h, 0.2, 1.0, inside=inside)
    np.testing.assert_allclose(found, [0.1, 0.1, 0.3, 0.5, 0.5, 0.5], atol=1e-3)


# ---- what is said of bad arguments ----

H = np.linspace(0.1, 1.0, 12).reshape(3, 4)
HOLLOW = np.zeros((3, 4), dtype=bool)


@BOTH
@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"h": np.where(H > 0.95, np.nan, H)}, ValueError, r"h\[2, 3\] is nan"),
        ({"h": np.where(H > 0.95, np.inf, H)}, ValueError, r"h\[2, 3\] is inf"),
        ({"h": H - 0.1}, ValueError, r"h must be positive, .* h\[0, 0\] is 0. Bound it"),
        ({"h": -H}, ValueError, "h must be positive"),
        ({"h": "small"}, TypeError, "h must hold real numbers"),
        ({"h": 0.3}, ValueError, "one, two or three axes"),
        ({"h": np.ones((2, 2, 2, 2))}, ValueError, "one, two or three axes"),
        ({"g": 0.0}, ValueError, "g must be one positive number; got 0.0"),
        ({"g": -0.3}, ValueError, "g must be one positive number"),
        ({"g": np.nan}, ValueError, "g must be finite"),
        ({"g": H}, ValueError, "g must be one positive number"),
        ({"dx": 0.0}, ValueError, "dx must be positive"),
        ({"dx": (0.1, 0.1, 0.1)}, ValueError, "one for each of the 2 axes"),
        ({"inside": H}, TypeError, "inside must hold True and False; got the type float64"),
        ({"inside": ~HOLLOW[:2]}, ValueError, r"inside must have h's shape \(3, 4\); got \(2, 4\)"),
        ({"inside": HOLLOW}, ValueError, "inside must be True somewhere"),
    ],
)
def test_bad_arguments_are_named(solver, change, error, words):
    with pytest.raises(error, match=words):
        solver(**{"h": H, "g": 0.3, "dx": 0.1} | change)


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ({"time": -1.0}, "time must be one number, zero or more"),
        ({"tolerance": 0.0}, "tolerance must be one positive number"),
        ({"cfl": 1.1}, "cfl must not be above 1 with upwind"),
        ({"cfl": 0.0}, "cfl must be one positive number"),
    ],
)
def test_bad_options_are_named(option, words):
    with pytest.raises(ValueError, match=words):
        limit_gradient_pde(H, 0.3, 0.1, **option)
