"""Motion along the normal: Godunov's choice, fronts that grow, shrink and meet, arrival times."""

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage

import distmesh_edu as de
from distmesh_edu.convection import runge_kutta_step

SCHEMES = {"upwind": de.upwind, "eno2": de.eno2, "eno3": de.eno3, "weno5": de.weno5}
ORDERS = {"upwind": 1, "eno2": 2, "eno3": 3, "weno5": 5}
SPACING = (0.1, 0.25, 0.16)

DIMS = pytest.mark.parametrize("dim", [1, 2, 3])
SIGNS = pytest.mark.parametrize("sign", [1, -1])
EVERY_SCHEME = pytest.mark.parametrize("scheme", SCHEMES.values(), ids=SCHEMES)


def slopes_given(pairs):
    """Return a scheme that finds the slopes it is told, whatever phi is."""
    return lambda phi, dx, axis, *, boundary: pairs[axis]


def random_slopes(dim, seed=0, whole=True):
    rng = np.random.default_rng(seed)
    shape = (dim, 2, *(60, 12, 7)[dim - 1 : dim] * dim)
    return rng.integers(-3, 4, shape).astype(float) if whole else rng.standard_normal(shape)


def grid(dim, n, half=2.0):
    """Return a grid about the origin with another spacing along each axis."""
    sides = np.array((1.0, 1.1, 0.9)[:dim]) * half
    return de.Grid((-sides, sides), tuple(2 * sides / (np.array((n, n + 2, n + 4)[:dim]) - 1)))


def radius(points):
    return np.linalg.norm(points, axis=-1)


# ---- Godunov's choice ----


@DIMS
@SIGNS
def test_it_is_the_extreme_over_the_slopes_between_the_two_sides(dim, sign):
    """Godunov's flux: of a p^2, the least between rising slopes, the largest between falling."""
    pairs = random_slopes(dim)
    share = np.linspace(0, 1, 601).reshape(-1, *[1] * (pairs.ndim - 1))
    between = sign * (pairs[:, 0] + share * (pairs[:, 1] - pairs[:, 0])) ** 2
    rises = pairs[:, 0] <= pairs[:, 1]
    extreme = np.where(rises, between.min(axis=0), between.max(axis=0))
    phi = np.zeros(pairs.shape[2:])
    norm = de.godunov_norm(phi, sign, 1.0, differences=slopes_given(pairs))
    np.testing.assert_allclose(norm, np.sqrt(np.abs(extreme).sum(axis=0)), rtol=0, atol=1e-12)


def branches(speed, minus, plus):
    """Return the slope of one axis as section 4.3 lists the cases, the last two the right way."""
    a, b = speed * minus, speed * plus
    steeper = np.where(np.abs(a) >= np.abs(b), minus, plus)
    return np.select(
        [(a > 0) & (b > 0), (a < 0) & (b < 0), (a <= 0) & (b >= 0), (a >= 0) & (b <= 0)],
        [minus, plus, 0.0, steeper],
    )


@DIMS
@pytest.mark.parametrize("whole", [True, False], ids=["ties", "no ties"])
def test_one_line_is_what_the_branches_say(dim, whole):
    pairs = random_slopes(dim, 1, whole)
    speed = np.random.default_rng(2).choice([-2.0, -1.0, 1.0, 0.3], pairs.shape[2:])
    norm = de.godunov_norm(np.zeros(speed.shape), speed, 1.0, differences=slopes_given(pairs))
    chosen = np.stack([branches(speed, *pair) for pair in pairs])
    np.testing.assert_allclose(norm, radius(np.moveaxis(chosen, 0, -1)), rtol=1e-14, atol=0)


@pytest.mark.parametrize(("crest", "at_the_middle"), [(-1, -0.5), (1, 0.1)])
def test_a_valley_stays_and_a_ridge_is_eaten_away(crest, at_the_middle):
    """An expansion, |x| - 0.5, and a shock, 0.5 - |x|, after t = 0.4 (erratum E4.3)."""
    x = np.linspace(-2.0, 2.0, 81)
    for scheme in SCHEMES.values():
        phi = de.move_in_normal_direction(
            crest * (0.5 - np.abs(x)), 1.0, 0.05, 0.4, differences=scheme
        )
        assert phi[40] == pytest.approx(at_the_middle, abs=0.05)
    upwind = de.move_in_normal_direction(
        crest * (0.5 - np.abs(x)), 1.0, 0.05, 0.4, differences=de.upwind
    )
    assert upwind[40] == pytest.approx(at_the_middle, abs=1e-12)


@DIMS
@EVERY_SCHEME
def test_a_faster_front_of_the_other_sign_sees_the_negative(dim, scheme):
    """Outwards in phi is inwards in -phi; of the speed, only the sign counts."""
    phi = np.random.default_rng(3).standard_normal((9, 8, 7)[:dim])
    speed = np.random.default_rng(4).choice([-2.0, 0.5], phi.shape)
    norm = de.godunov_norm(phi, speed, SPACING[:dim], differences=scheme)
    other = de.godunov_norm(-phi, -7 * speed, SPACING[:dim], differences=scheme)
    np.testing.assert_allclose(norm, other, rtol=1e-12)


@DIMS
@SIGNS
@EVERY_SCHEME
def test_a_mirror_changes_nothing(dim, sign, scheme):
    phi = np.random.default_rng(5).standard_normal((9, 8, 7)[:dim])
    for axis in range(dim):
        norm = de.godunov_norm(phi, sign, SPACING[:dim], differences=scheme)
        mirrored = de.godunov_norm(np.flip(phi, axis), sign, SPACING[:dim], differences=scheme)
        np.testing.assert_allclose(np.flip(mirrored, axis), norm, rtol=1e-9)


def test_a_node_that_stands_still_has_no_slope():
    speed = np.array([1.0, 0.0, -1.0, 0.0])
    norm = de.godunov_norm([0.0, 1.0, 4.0, 9.0], speed, 1.0, differences=de.upwind)
    np.testing.assert_array_equal(norm, [1, 0, 5, 0])
    norm = de.godunov_norm([9.0, 4.0, 1.0, 0.0], speed, 1.0, differences=de.upwind)
    np.testing.assert_array_equal(norm, [5, 0, 3, 0])


directions = st.floats(-5, 5, allow_subnormal=False)


@given(
    dim=st.integers(1, 3),
    slopes=st.tuples(directions, directions, directions),
    speed=st.sampled_from([1.0, -1.0]),
    scheme=st.sampled_from(list(SCHEMES.values())),
)
def test_a_plane_has_its_slope_and_moves_by_it(dim, slopes, speed, scheme):
    """In any direction, with a spacing of its own for each axis."""
    slopes, dx = np.array(slopes[:dim]), SPACING[:dim]
    nodes = np.moveaxis(np.indices((6, 5, 4)[:dim]), 0, -1)
    phi = (nodes * dx * slopes).sum(axis=-1)
    steepness = np.linalg.norm(slopes)
    norm = de.godunov_norm(phi, speed, dx, differences=scheme)
    np.testing.assert_allclose(norm, steepness, rtol=0, atol=1e-11)
    moved = de.move_in_normal_direction(phi, speed, dx, 0.3, differences=scheme)
    np.testing.assert_allclose(moved, phi - speed * 0.3 * steepness, rtol=0, atol=1e-11)


@DIMS
@SIGNS
@pytest.mark.parametrize("name", SCHEMES)
def test_observed_order_of_the_norm(dim, sign, name):
    """Where phi is smooth and rises along each axis, within 0.2 of nominal."""
    errors = []
    for n in (20, 40):
        dx = (1 / n, 1 / (1.1 * n), 1 / (0.9 * n))[:dim]
        axes = [h * np.arange(round(1 / h) + 1) for h in dx]
        x = np.meshgrid(*axes, indexing="ij")
        phi = sum(np.exp((1 + k) * a) for k, a in enumerate(x))
        slopes = [(1 + k) * np.exp((1 + k) * a) for k, a in enumerate(x)]
        inner = np.all([(a > 0.3) & (a < 0.7) for a in x], axis=0)
        found = de.godunov_norm(phi, sign, dx, differences=SCHEMES[name])
        error = np.abs(found - np.sqrt(sum(s**2 for s in slopes)))
        errors.append(error[inner].mean())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(ORDERS[name], abs=0.2)


# ---- motion ----


@DIMS
@SIGNS
@pytest.mark.parametrize(("name", "worst"), [("upwind", 0.1), ("eno2", 0.01), ("weno5", 1e-3)])
def test_an_interval_a_disc_and_a_ball_have_the_radius_they_should(dim, sign, name, worst):
    """From radius 1, at speed 1 or -1 for a time of 0.4; phi is not even a distance."""
    box = grid(dim, 41 if dim < 3 else 31)
    r = radius(box.points)
    scheme = SCHEMES[name]
    phi = de.move_in_normal_direction(r**2 - 1, sign, box.dx, 0.4, differences=scheme)
    exact = (r - sign * 0.4) ** 2 - 1
    near = np.abs(r - 1 - sign * 0.4) < 0.15
    slope = 2.0  # of phi at the front, which turns a value into a length
    assert np.abs(phi - exact)[near].max() / slope < worst


@pytest.mark.parametrize(
    ("name", "sign"), [("upwind", 1), ("upwind", -1), ("eno2", 1), ("eno2", -1), ("eno3", 1)]
)
def test_observed_order_of_the_motion(name, sign):
    errors = []
    for n in (61, 121):
        box = grid(2, n)
        r = radius(box.points)
        scheme = SCHEMES[name]
        phi = de.move_in_normal_direction(np.exp(r), sign, box.dx, 0.3, differences=scheme)
        ring = (r > 0.9) & (r < 1.3)
        errors.append(np.abs(phi - np.exp(r - sign * 0.3))[ring].mean())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(ORDERS[name], abs=0.2)


def pieces(phi):
    return ndimage.label(phi < 0)[1]


@DIMS
def test_two_discs_meet_and_a_hole_closes(dim):
    """Nobody has to tell the front that two pieces have become one, when each has gone 0.3."""
    box = grid(dim, 41)
    place = np.zeros(dim)
    place[0] = 0.8
    discs = np.minimum(radius(box.points - place), radius(box.points + place)) - 0.5
    hole = np.maximum(0.3 - radius(box.points), radius(box.points) - 1.2)
    for start, before, after in ((discs, 2, 1), (-hole, 2, 1)):
        sign = 1 if start is discs else -1  # the hole is a piece of the outside, which shrinks
        early, late = (
            de.move_in_normal_direction(start, sign, box.dx, t, differences=de.upwind)
            for t in (0.2, 0.4)
        )
        if dim > 1 or start is discs:
            assert (pieces(early), pieces(late)) == (before, after)
        else:  # on a line, the outside of a ring is in three pieces
            assert (pieces(early), pieces(late)) == (3, 2)


def test_a_speed_may_be_a_number_an_array_or_a_function_of_time():
    x = np.linspace(-2.0, 2.0, 41)
    phi = np.abs(x) - 1
    steady = de.move_in_normal_direction(phi, 0.5, 0.1, 0.4)
    spread = de.move_in_normal_direction(phi, np.full(41, 0.5), 0.1, 0.4)
    np.testing.assert_array_equal(steady, spread)
    slower = de.move_in_normal_direction(phi, lambda t: 2 - 5 * t, 0.1, 0.4, cfl=0.2)
    there = de.move_in_normal_direction(phi, 0.4, 0.1, 1.0)  # the integral of 2 - 5 t is 0.4
    assert np.abs(slower - there)[np.abs(x) > 0.6].max() < 1e-3
    half = de.move_in_normal_direction(phi, np.where(x > 0, 1.0, 0.0), 0.1, 0.3)
    np.testing.assert_array_equal(half[x < 0], phi[x < 0])
    assert half[-1] == pytest.approx(phi[-1] - 0.3)


def test_a_speed_of_zero_and_a_time_of_zero_leave_everything_as_it_was():
    phi = np.array([[-1.0, 2.0], [3.0, 1.0]])
    for speed, time in ((0.0, 5.0), (1.0, 0.0)):
        np.testing.assert_array_equal(de.move_in_normal_direction(phi, speed, 1.0, time), phi)


def test_steps_are_as_long_as_the_diagonal_allows():
    times = []
    de.move_in_normal_direction(
        np.ones((5, 5, 5)),
        -2.0,
        (0.1, 0.2, 0.2),
        1.0,
        cfl=0.3,
        callback=lambda t, _: times.append(t),
    )
    longest = 0.3 / 2 / np.sqrt(100 + 25 + 25)
    assert longest * 0.98 < times[0] <= longest
    assert times[-1] == 1.0


def test_what_it_is_given_stays_as_it_was():
    phi, speed = np.arange(5.0) - 2, np.ones(5)
    phi.setflags(write=False)
    speed.setflags(write=False)
    de.godunov_norm(phi, speed, 1.0)
    de.move_in_normal_direction(phi, speed, 1.0, 1.0)
    de.crossing_times(phi, 1.0, 1.0)


# ---- the listing of section 4.4, run in GNU Octave 7.3 once its line with S_phi is moved ----

INSIDE = {
    "star": [481, 441, 401, 357, 337, 305, 281, 245, 233, 201, 185, 157, 145, 117, 113, 89, 85]
    + [61, 61, 41, 41, 25, 25, 13, 13, 5, 5, 1, 1, 0, 0],
    "rose": [316, 424, 548, 671, 776, 869, 988, 1067, 1158, 1250, 1341, 1416, 1508, 1559, 1648]
    + [1718, 1797, 1849, 1935, 1994, 2076, 2128, 2203, 2264, 2341, 2408, 2469, 2537, 2620, 2685]
    + [2756],
}
NODES = ([40, 44, 28, 60, 3], [40, 47, 47, 41, 79])
AFTER_TEN_STEPS = {
    "star": [-0.49904470590577066, 0.08270909082846868, 0.41683513631890656, 0.40476177326199886]
    + [2.2013474978800938],
    "rose": [-0.9633483891726818, -0.8938952527867103, -0.0994420496272625, -0.137721912934474]
    + [1.5592872951310142],
}
STEPS = {  # the listing measures its CFL number anew at each step: no normal is quite diagonal
    "star": [0.5 * 0.05 / np.sqrt(2)] * 10,
    "rose": [0.017677669607169093, 0.017677670998592753, 0.017677671139000935]
    + [0.017677670657499936, 0.017677670542823307, 0.01767767090938133, 0.01767766970102147]
    + [0.017677670900639802, 0.01767766952995896, 0.017677669570564696],
}
SPEED = {"star": -1, "rose": 1}
LISTING = pytest.mark.parametrize("name", SPEED)


def shape_of_section_4_4(name):
    x, y = np.meshgrid(*[np.arange(-40, 41) * 0.05] * 2, indexing="ij")
    if name == "star":  # the listing's, not the text's (erratum E4.4b)
        return np.cbrt(x**2) + np.cbrt(y**2) - 1
    return np.hypot(x, y) - np.sin(9 * np.arctan2(y, x))


@LISTING
def test_the_listing_to_all_its_digits(name):
    phi = shape_of_section_4_4(name)
    for dt in STEPS[name]:
        phi = phi - dt * SPEED[name] * de.godunov_norm(phi, SPEED[name], 0.05)
    np.testing.assert_allclose(phi[NODES], AFTER_TEN_STEPS[name], rtol=0, atol=2e-14)


@LISTING
def test_the_solver_takes_the_listings_steps(name):
    counts = [int((shape_of_section_4_4(name) < 0).sum())]
    fields = []

    def record(_, phi):
        counts.append(int((phi < 0).sum()))
        fields.append(phi)

    time = 30 * STEPS["star"][0]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", de.StabilityWarning)  # forward Euler, as in the listing
        de.move_in_normal_direction(
            shape_of_section_4_4(name), SPEED[name], 0.05, time, stages=1, callback=record
        )
    assert counts == INSIDE[name]
    np.testing.assert_allclose(fields[9][NODES], AFTER_TEN_STEPS[name], rtol=0, atol=2e-7)


# ---- crossing times ----


def arrival_error(dim, n, scheme, side, interpolation="hermite"):
    """Return the largest error of the distance to the unit sphere, not too near the origin."""
    box = grid(dim, n)
    d = radius(box.points) - 1
    found = de.crossing_times(
        d * (d + 2), box.dx, 0.5, differences=scheme, interpolation=interpolation
    )
    return np.abs(found - d)[(side * d > 0) & (np.abs(d) < 0.45)].max()


@DIMS
@pytest.mark.parametrize("interpolation", ["linear", "hermite"])
@EVERY_SCHEME
def test_a_plane_arrives_in_time(dim, interpolation, scheme):
    """Exactly, inside and outside, whatever the slope and the spacing."""
    dx = SPACING[:dim]
    nodes = np.moveaxis(np.indices((9, 8, 7)[:dim]), 0, -1) - 3.2
    slopes = np.array((0.3, -0.5, 2.0)[:dim])
    phi = 7 * (nodes * dx * slopes).sum(axis=-1)
    d = phi / 7 / np.linalg.norm(slopes)
    found = de.crossing_times(
        phi, dx, 0.3, differences=scheme, boundary=de.extrapolated, interpolation=interpolation
    )
    reached = np.abs(d) < 0.3
    np.testing.assert_allclose(found[reached], d[reached], rtol=0, atol=1e-12)
    np.testing.assert_array_equal(found[~reached], np.copysign(np.inf, d[~reached]))


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(("name", "least"), [("upwind", 0.8), ("eno2", 1.7), ("eno3", 2.5)])
def test_arrival_times_converge_with_the_scheme(side, name, least):
    coarse, fine = (arrival_error(2, n, SCHEMES[name], side) for n in (31, 61))
    assert np.log2(coarse / fine) > least


@pytest.mark.parametrize(("dim", "n", "factor"), [(2, 41, 500), (3, 21, 10)])
def test_a_cubic_in_time_beats_a_line(dim, n, factor):
    line, cubic = (arrival_error(dim, n, de.weno5, 1, how) for how in ("linear", "hermite"))
    assert factor * cubic < line < 1e-3


def test_a_line_in_time_is_of_second_order_whatever_the_scheme():
    coarse, fine = (arrival_error(2, n, de.weno5, 1, "linear") for n in (31, 61))
    assert np.log2(coarse / fine) == pytest.approx(2, abs=0.2)


@DIMS
def test_arrival_times_are_distances_inside_and_outside(dim):
    for side in (1, -1):
        assert arrival_error(dim, 31, de.eno3, side) < 2e-3


def test_arrival_times_do_not_ask_what_phi_is_elsewhere():
    x = np.linspace(-2.0, 2.0, 81)
    found = de.crossing_times(np.sinh(3 * (x - 0.31)), 0.05, 0.5, differences=de.eno3)
    near = np.abs(x - 0.31) < 0.45
    np.testing.assert_allclose(found[near], (x - 0.31)[near], atol=2e-3)


def test_a_node_on_the_interface_is_crossed_at_time_zero():
    assert de.crossing_times([-2.0, 0.0, 2.0], 1.0, 2.0)[1] == 0.0


# ---- what is said of bad arguments ----

PHI = np.linspace(-1.0, 1.0, 12).reshape(3, 4)


BAD_VALUES = [
    ({"phi": np.where(PHI > 0.9, np.nan, PHI)}, ValueError, r"phi\[2, 3\] is nan"),
    ({"phi": np.where(PHI > 0.9, np.inf, PHI)}, ValueError, r"phi\[2, 3\] is inf"),
    ({"phi": "abc"}, TypeError, "phi must hold real numbers"),
    ({"phi": np.zeros((2, 2, 2, 2))}, ValueError, "one, two or three axes"),
    ({"phi": PHI[:, :1]}, ValueError, "phi must have 2 nodes at least"),
    ({"dx": 0.0}, ValueError, "dx must be positive"),
    ({"dx": (0.1, -0.1)}, ValueError, "along axis 1 it is -0.1"),
    ({"dx": (0.1, 0.1, 0.1)}, ValueError, "one for each of the 2 axes"),
    ({"differences": "eno2"}, TypeError, "differences must be a scheme"),
]
BAD_SPEEDS = [
    ({"speed": np.ones(4)}, ValueError, r"speed must .* have phi's shape \(3, 4\); got \(4,\)"),
    ({"speed": np.nan}, ValueError, "speed must be finite"),
    ({"speed": "fast"}, TypeError, "speed must hold real numbers"),
]


@pytest.mark.parametrize(("change", "error", "words"), BAD_VALUES + BAD_SPEEDS)
@pytest.mark.parametrize("time", [{}, {"time": 0.1}], ids=["godunov_norm", "move"])
def test_bad_arguments_are_named(change, error, words, time):
    solver = de.move_in_normal_direction if time else de.godunov_norm
    with pytest.raises(error, match=words):
        solver(**{"phi": PHI, "dx": 0.1, "speed": 1.0} | time | change)


@pytest.mark.parametrize(("change", "error", "words"), BAD_VALUES)
def test_bad_arguments_of_crossing_times_are_named(change, error, words):
    with pytest.raises(error, match=words):
        de.crossing_times(**{"phi": PHI, "dx": 0.1, "time": 0.1} | change)


@pytest.mark.parametrize("solver", [de.move_in_normal_direction, de.crossing_times])
@pytest.mark.parametrize(
    ("option", "error", "words"),
    [
        ({"time": -1.0}, ValueError, "time must be one number, zero or more"),
        ({"time": np.inf}, ValueError, "time must be finite"),
        ({"cfl": 1.1}, ValueError, "cfl must not be above"),
        ({"cfl": 0.0}, ValueError, "cfl must be one positive number"),
    ],
)
def test_bad_times_and_steps_are_named(solver, option, error, words):
    more = {} if solver is de.crossing_times else {"speed": 1.0}
    with pytest.raises(error, match=words):
        solver(PHI, dx=0.1, **more | {"time": 0.1} | option)


def test_bad_options_are_named():
    with pytest.raises(ValueError, match="stages must be 1, 2 or 3; got 4"):
        de.move_in_normal_direction(PHI, 1.0, 0.1, 0.1, stages=4)
    with pytest.raises(ValueError, match="'hermite' or 'linear'; got 'cubic'"):
        de.crossing_times(PHI, 0.1, 0.1, interpolation="cubic")
    with pytest.raises(ValueError, match="speed must be finite"):
        de.move_in_normal_direction(PHI, lambda t: np.nan, 0.1, 0.1)
    for phi in (PHI + 2, PHI - 2):
        with pytest.raises(ValueError, match=r"phi must have an interface.*Shift it"):
            de.crossing_times(phi, 0.1, 0.1)


@pytest.mark.parametrize(("scheme", "stages"), [(de.eno2, 1), (de.eno3, 2), (de.weno5, 1)])
def test_an_unstable_pair_warns(scheme, stages):
    with pytest.warns(de.StabilityWarning, match=f"{scheme.__name__} with stages={stages}"):
        de.move_in_normal_direction(PHI, 1.0, 0.1, 0.1, differences=scheme, stages=stages)


def test_a_runge_kutta_step_of_the_rate_is_what_the_solver_takes():
    phi = np.cos(np.arange(12.0)).reshape(3, 4)
    found = de.move_in_normal_direction(phi, 1.0, 1.0, 0.3)
    step = runge_kutta_step(phi, lambda phi, t: -de.godunov_norm(phi, 1.0, 1.0), 0.0, 0.3, 2)
    np.testing.assert_array_equal(found, step)


def test_a_front_is_at_its_start_at_time_zero_and_not_at_minus_zero():
    times = de.crossing_times(np.arange(-2.0, 3.0), 1.0, 1.5)
    assert times[2] == 0
    assert not np.signbit(times[2])
