"""Signed distances from any phi: by the equation of chapter 5, and by closest points."""

import warnings
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import distmesh_edu as de
from distmesh_edu._spline import CubicSpline
from distmesh_edu.geometry import gradient, volume
from distmesh_edu.reinitialization import next_to_interface

DIMS = pytest.mark.parametrize("dim", [1, 2, 3])
BOTH = pytest.mark.parametrize("subcell", [True, False], ids=["fix", "smeared"])
SIZE = {1: 41, 2: 41, 3: 21}
OFFSET = np.array((0.013, 0.007, -0.011))
EDGES = (0.10, 0.14, 0.08)


def ball(dim, n, part=0.0):
    """Return the distance to a unit sphere on a grid of n nodes an axis, and the spacing.

    The spacings differ, and the middle lies on no node; it moves by a part of a cell if asked.
    """
    dx = tuple(4 / (n - 1) * np.array((1.0, 1.1, 0.95)[:dim]))
    axes = [h * (np.arange(n) - (n - 1) / 2 - part) - c for h, c in zip(dx, OFFSET, strict=False)]
    return np.linalg.norm(np.meshgrid(*axes, indexing="ij"), axis=0) - 1, dx


def level_set(d):
    """Return another function with the same zeros and signs, whose slope is 2 at the front."""
    return d * (d + 2)


def in_band(d, dx, cells=3):
    return np.abs(d) <= cells * max(dx)


def displacement(phi, d):
    """Return how far from the true interface the zeros of phi between two nodes lie, at most."""
    worst = 0.0
    for axis in range(phi.ndim):
        a, b = (np.moveaxis(phi, axis, 0)[part] for part in (slice(-1), slice(1, None)))
        da, db = (np.moveaxis(d, axis, 0)[part] for part in (slice(-1), slice(1, None)))
        crossed = (a < 0) != (b < 0)
        share = (a / np.where(crossed, a - b, 1))[crossed]
        worst = max(worst, np.abs(da[crossed] * (1 - share) + db[crossed] * share).max())
    return worst


def plane(dim, rng, aspect=2.0):
    """Return the distance to a random plane, the spacing, and where the foot is in the box."""
    shape = rng.integers(5, (40, 16, 9)[dim - 1], dim)
    dx = rng.uniform(1, aspect, dim)
    normal = rng.standard_normal(dim)
    normal /= np.linalg.norm(normal)
    places = np.moveaxis(np.indices(shape), 0, -1) * dx
    through = dx * ((np.array(shape) - 1) / 2 + rng.uniform(-1, 1, dim))
    d = ((places - through) * normal).sum(axis=-1)
    foot = places - d[..., None] * normal
    inside = ((foot >= 0) & (foot <= dx * (np.array(shape) - 1))).all(axis=-1)
    return d, dx, inside


# ---- the parts ----


def test_next_to_interface_by_hand():
    phi = np.array([[-2.0, -1, 1], [-1, 0, 1], [1, 1, 2]])
    expected = [[False, True, True], [True, True, False], [True, False, False]]
    np.testing.assert_array_equal(next_to_interface(phi), expected)
    np.testing.assert_array_equal(next_to_interface(-phi), expected)


@DIMS
def test_next_to_interface_is_everyone_with_a_neighbour_across(dim):
    phi = np.random.default_rng(dim).choice([-1.0, 1.0, 1.0, 0.0], (9, 8, 7)[:dim])
    expected = phi == 0
    for place in np.ndindex(phi.shape):
        for axis in range(dim):
            for step in (-1, 1):
                other = (*place[:axis], place[axis] + step, *place[axis + 1 :])
                if 0 <= other[axis] < phi.shape[axis]:
                    expected[place] |= phi[place] * phi[other] < 0
    np.testing.assert_array_equal(next_to_interface(phi), expected)


@DIMS
def test_the_sign_is_smeared_over_a_cell_whatever_the_scale(dim):
    d, dx = ball(dim, SIZE[dim])
    sign = de.smeared_sign(level_set(d), dx)
    np.testing.assert_allclose(de.smeared_sign(1e5 * level_set(d), dx), sign, rtol=1e-12)
    np.testing.assert_array_equal(np.sign(sign), np.sign(d))
    assert np.abs(sign).max() <= 1
    expected = d / np.hypot(d, max(dx))
    band = in_band(d, dx, 2)
    assert np.abs(sign - expected)[band].max() < (0.1 if dim < 3 else 0.2)


@pytest.mark.parametrize("scheme", [de.upwind, de.eno2, de.weno5])
@DIMS
def test_the_distance_below_a_cell_is_exact_for_a_plane(dim, scheme):
    d, dx, _ = plane(dim, np.random.default_rng(dim))
    found = de.subcell_distance(-7 * d, dx, differences=scheme)
    np.testing.assert_allclose(found, -d, rtol=0, atol=1e-12)


@DIMS
def test_the_distance_below_a_cell_is_of_second_order(dim):
    errors = []
    for n in (21, 41):
        d, dx = ball(dim, n)
        error = np.abs(de.subcell_distance(level_set(d), dx) - d)
        errors.append(error[next_to_interface(d)].max())
    assert np.log2(errors[0] / errors[1]) > 1.6


def test_flat_data_have_no_distance_and_do_no_harm():
    phi = np.array([-1.0, -1, -1, 1, 1, 1])
    assert np.isfinite(de.subcell_distance(np.zeros(5), 1.0)).all()
    np.testing.assert_array_equal(de.smeared_sign(np.zeros(5), 1.0), 0)
    expected = [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5]
    np.testing.assert_allclose(de.redistance(phi, 1.0), expected)
    np.testing.assert_allclose(de.reinitialize(phi, 1.0), expected, atol=0.6)  # sides, to a cell


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


# ---- the equation ----


@DIMS
def test_the_slope_becomes_one(dim):
    d, dx = ball(dim, SIZE[dim])
    phi = de.reinitialize(level_set(d), dx, band=4 * max(dx))
    slope = np.linalg.norm(gradient(phi, dx), axis=-1)
    band = in_band(d, dx)
    assert np.abs(slope - 1)[band].max() < (0.05 if dim < 3 else 0.15)
    assert np.abs(np.linalg.norm(gradient(level_set(d), dx), axis=-1) - 1)[band].max() > 1


@pytest.mark.parametrize("scheme", [de.upwind, de.eno2, de.eno3, de.weno5])
@pytest.mark.parametrize("dim", [1, 2])
def test_with_the_fix_the_band_is_of_second_order(dim, scheme):
    """Upwind differences as well: the start from the held nodes is of second order."""
    errors = []
    for n in (31, 91):
        worst = 0.0
        for part in np.linspace(0, 1, 8 if dim == 1 else 1, endpoint=False):
            d, dx = ball(dim, n, part)
            phi = de.reinitialize(level_set(d), dx, band=3 * max(dx), differences=scheme)
            worst = max(worst, np.abs(phi - d)[in_band(d, dx)].max())
        errors.append(worst)
    assert np.log(errors[0] / errors[1]) / np.log(3) > 1.75


def test_with_the_fix_the_band_about_a_ball_is_of_second_order():
    errors = []
    for n in (21, 41):
        d, dx = ball(3, n)
        phi = de.reinitialize(level_set(d), dx, band=3 * max(dx))
        errors.append(np.abs(phi - d)[in_band(d, dx)].max())
    assert np.log2(errors[0] / errors[1]) > 1.75


def test_the_interface_moves_at_second_order_with_the_fix_and_at_first_without():
    moved = {True: [], False: []}
    for subcell, lengths in moved.items():
        for n in (31, 61, 121):
            d, dx = ball(2, n)
            phi = de.reinitialize(level_set(d), dx, band=0.5, subcell=subcell)
            lengths.append(displacement(phi, d))
    orders = {fix: np.log2(m[0] / m[2]) / 2 for fix, m in moved.items()}
    assert orders[True] > 1.8
    assert 0.6 < orders[False] < 1.4
    assert moved[False][2] > 5 * moved[True][2]


@DIMS
def test_with_the_fix_no_node_changes_sides(dim):
    d, dx = ball(dim, SIZE[dim])
    for phi in (level_set(d), 50 * level_set(d), np.sin(2 * d) * (1.5 + np.cos(5 * d))):
        np.testing.assert_array_equal(de.reinitialize(phi, dx, band=0.3) < 0, phi < 0)


@DIMS
def test_what_was_far_off_scale_comes_out_the_same(dim):
    """The fix starts from phi / |grad phi|; without it, only the sign must not know the scale."""
    d, dx = ball(dim, 31 if dim < 3 else 17)
    phi, time = level_set(d), 1.0
    fixed = [de.reinitialize(c * phi, dx, band=time) for c in (1, 100, 0.01)]
    band = in_band(d, dx)
    for other in fixed[1:]:
        assert np.abs(other - fixed[0])[band].max() < (0.02 if dim < 3 else 0.1) * max(dx)
    smeared = de.reinitialize(100 * phi, dx, band=time, subcell=False)
    steep = 100 * phi
    step = 0.5 / np.linalg.norm(1 / np.array(dx))
    sign = steep / np.hypot(steep, max(dx))  # the thesis's (4.14)
    for _ in range(int(time / step)):
        steep = steep + step * sign * (1 - de.godunov_norm(steep, sign, dx))
    assert displacement(smeared, d) < 0.7 * max(dx) < 0.6 * displacement(steep, d)


@DIMS
@BOTH
def test_inside_and_outside_are_treated_alike(dim, subcell):
    d, dx = ball(dim, 21)
    phi = np.where(np.abs(d) < 0.2 * min(dx), 0, level_set(d))
    assert (phi == 0).any() or dim == 1
    one = de.reinitialize(phi, dx, band=0.3, subcell=subcell)
    other = de.reinitialize(-phi, dx, band=0.3, subcell=subcell)
    np.testing.assert_allclose(other, -one, rtol=0, atol=1e-12)
    for axis in range(dim):
        mirrored = de.reinitialize(np.flip(phi, axis), dx, band=0.3, subcell=subcell)
        np.testing.assert_allclose(np.flip(mirrored, axis), one, rtol=0, atol=1e-9)


@pytest.mark.parametrize("scheme", [de.upwind, de.eno2])
@pytest.mark.parametrize("shape", ["falls to the rim", "waves"])
def test_the_trap_at_the_boundary(shape, scheme):
    """Ghosts on the line through the last values let the outside in; closed ones do not."""
    x, y = np.meshgrid(*[np.arange(-40, 41) * 0.05] * 2, indexing="ij")
    d = np.hypot(x - 0.013, y - 0.007) - 1
    fall = (2.05 - np.maximum(np.abs(x), np.abs(y))) / 2
    phi = d * (fall if shape == "falls to the rim" else 1 + 0.9 * np.sin(9 * x) * np.cos(7 * y))
    options = {"differences": scheme, "band": 3.0}  # twice what it takes to cross the box
    closed = de.reinitialize(phi, 0.05, **options)
    trap = de.reinitialize(phi, 0.05, boundary=de.extrapolated, **options)
    assert np.abs(closed - d).max() < 0.05
    assert np.abs(trap - d).max() > 1.0


def test_it_stops_by_the_band():
    """Just long enough for a distance of `band`, and some cells more."""
    d, dx = ball(2, 41)
    times = []
    de.reinitialize(level_set(d), dx, band=0.4, callback=lambda t, _: times.append(t))
    dt = 0.5 / np.linalg.norm(1 / np.array(dx))
    assert times[0] == pytest.approx(dt)
    assert 0.4 + 5 * max(dx) <= times[-1] < 0.4 + 5 * max(dx) + dt
    untouched = np.abs(d) > 0.4 + 15 * max(dx)
    assert not untouched.any() or np.abs(d[untouched]).min() > 0.4


@DIMS
def test_it_stops_when_it_stands_still(dim):
    d, dx = ball(dim, 21)
    fields = []
    found = de.reinitialize(level_set(d), dx, callback=lambda t, phi: fields.append(phi))
    dt = 0.5 / np.linalg.norm(1 / np.array(dx))
    rates = [np.abs(b - a).max() / dt for a, b in pairwise(fields)]
    assert rates[-1] <= 0.01 < min(rates[:-1])
    assert np.abs(found - d)[d > -0.8].max() < 0.1


def test_it_says_so_when_it_does_not_come_to_rest():
    d, dx = ball(2, 21)
    with pytest.warns(
        de.ConvergenceWarning, match=r"still moves after \d+ steps.*Give a band"
    ) as w:
        de.reinitialize(level_set(d), dx, tolerance=1e-300)
    assert w[0].filename == __file__


@pytest.mark.parametrize(("scheme", "stages"), [(de.eno2, 1), (de.eno3, 2), (de.weno5, 1)])
def test_an_unstable_pair_warns(scheme, stages):
    d, dx = ball(2, 11)
    with pytest.warns(de.StabilityWarning, match=f"{scheme.__name__} with stages={stages}"):
        de.reinitialize(d, dx, band=0.1, differences=scheme, stages=stages)


def test_a_steep_start_far_away_does_not_disturb_the_band():
    d, dx = ball(2, 41)
    found = de.reinitialize(np.sinh(6 * d), dx, band=0.3)
    assert np.abs(found - d)[np.abs(d) < 0.3].max() < 0.03


# ---- the listing of section 4.8 on 401 x 401 nodes, ten steps, in the row y = 0 ----

ROW = [200, 210, 298, 300, 301, 310, 390]
PRINTED = [  # run in GNU Octave 7.3: forward Euler, D3/3
    *(-1.0341418272687268, -1.01715796028799, -0.016025480089195607, 0.0),
    *(0.007982385324275055, 0.16876458766031846, 2.512130696213523),
]
CORRECTED = [  # D3/6, and Heun's method
    *(-1.0339974886324834, -1.0170329716728035, -0.020464420556512892, 0.0),
    *(0.009983274994133982, 0.16889479750270814, 2.5122556985963542),
]


def doubled(phi, dx, axis, *, boundary):
    """ENO3 as the thesis prints it: the third-order correction taken twice."""
    two = de.eno2(phi, dx, axis, boundary=boundary)
    three = de.eno3(phi, dx, axis, boundary=boundary)
    return [2 * b - a for a, b in zip(two, three, strict=True)]


@pytest.mark.parametrize(
    ("scheme", "stages", "expected"), [(doubled, 1, PRINTED), (de.eno3, 2, CORRECTED)]
)
def test_the_listing_of_section_4_8(scheme, stages, expected):
    """Some columns about y = 0 are enough: ten steps look 60 nodes far at most."""
    x, y = np.meshgrid(np.arange(-200, 201) * 0.01, np.arange(-62, 63) * 0.01, indexing="ij")
    phi = x**2 + y**2 - 1
    sign = phi / np.hypot(phi, 0.01)
    corner = 7 / np.hypot(7, 0.01)  # where the listing finds its largest CFL number
    dt = 0.5 * 0.01 / np.sqrt(2) / corner

    def rate(phi, _):
        return sign * (1 - de.godunov_norm(phi, sign, 0.01, differences=scheme))

    for _ in range(10):
        phi = de.runge_kutta_step(phi, rate, 0.0, dt, stages)
    np.testing.assert_allclose(phi[ROW, 62], expected, rtol=0, atol=5e-12)


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


def test_what_they_are_given_stays_as_it_was():
    phi = level_set(ball(2, 11)[0])
    phi.setflags(write=False)
    for solver in (de.redistance, de.reinitialize, de.smeared_sign, de.subcell_distance):
        solver(phi, 0.4)


@pytest.mark.parametrize("solver", [de.redistance, de.reinitialize])
def test_nothing_is_said_where_all_is_well(solver):
    """No stray warning of numpy's either, with zeros, kinks and plateaus in phi."""
    phi = np.clip(np.round(3 * level_set(ball(2, 21)[0])), -2, 2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", de.ConvergenceWarning)
        assert np.isfinite(solver(phi, 0.2)).all()


# ---- what is said of bad arguments ----

PHI = np.linspace(-1.0, 1.0, 20).reshape(4, 5)
BAD = [
    ({"phi": np.where(PHI > 0.9, np.nan, PHI)}, ValueError, r"phi\[3, 4\] is nan"),
    ({"phi": np.where(PHI > 0.9, np.inf, PHI)}, ValueError, r"phi\[3, 4\] is inf"),
    ({"phi": "abc"}, TypeError, "phi must hold real numbers"),
    ({"phi": 3.0}, ValueError, "phi must be an array of values on a grid"),
    ({"phi": np.zeros((4, 4, 4, 4))}, ValueError, "one, two or three axes"),
    ({"phi": PHI[:, :2]}, ValueError, "nodes at least along each axis.*Take a finer grid"),
    ({"dx": 0.0}, ValueError, "dx must be positive"),
    ({"dx": (0.1, -0.1)}, ValueError, "along axis 1 it is -0.1"),
    ({"dx": (0.1, 0.1, 0.1)}, ValueError, "one for each of the 2 axes"),
    ({"dx": np.nan}, ValueError, "dx must be finite"),
]


@pytest.mark.parametrize(("change", "error", "words"), BAD)
@pytest.mark.parametrize(
    "solver", [de.redistance, de.reinitialize, de.subcell_distance, de.smeared_sign]
)
def test_bad_arguments_are_named(solver, change, error, words):
    with pytest.raises(error, match=words):
        solver(**{"phi": PHI, "dx": 0.1} | change)


@pytest.mark.parametrize("solver", [de.redistance, de.reinitialize])
def test_a_phi_without_an_interface_is_named(solver):
    for phi in (PHI + 2, PHI - 2, np.zeros((4, 4))):
        with pytest.raises(ValueError, match=r"phi must have an interface.*Shift it"):
            solver(phi, 0.1)


def test_redistance_needs_a_node_more():
    with pytest.raises(ValueError, match="phi must have 4 nodes at least"):
        de.redistance(PHI[:, :3], 0.1)
    de.reinitialize(PHI[:3, :3] + 0.5, 0.1, band=0.1)


@pytest.mark.parametrize(
    ("option", "error", "words"),
    [
        ({"band": 0.0}, ValueError, "band must be one positive number"),
        ({"band": -1.0}, ValueError, "band must be one positive number"),
        ({"band": np.inf}, ValueError, "band must be finite"),
        ({"tolerance": 0.0}, ValueError, "tolerance must be one positive number"),
        ({"cfl": 1.5}, ValueError, "cfl must not be above"),
        ({"stages": 4}, ValueError, "stages must be 1, 2 or 3; got 4"),
        ({"differences": "eno2"}, TypeError, "differences must be a scheme"),
    ],
)
def test_bad_options_of_reinitialize_are_named(option, error, words):
    with pytest.raises(error, match=words):
        de.reinitialize(PHI, 0.1, **option)
