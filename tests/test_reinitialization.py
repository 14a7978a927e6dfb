"""Signed distances from any phi: by the equation of chapter 5."""

import warnings
from itertools import pairwise

import numpy as np
import pytest

import distmesh_edu as de
from distmesh_edu import reinitialization
from distmesh_edu.geometry import gradient
from distmesh_edu.reinitialization import next_to_interface
from tests.level_sets import BOTH, DIMS, SIZE, ball, displacement, in_band, level_set, plane

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


def test_in_the_middle_of_a_thin_feature_the_steeper_slope_counts():
    """To both sides phi rises as steeply: a central difference would see no slope at all."""
    thin = de.subcell_distance([1.0, 1, -1, 1, 1], 0.5, differences=de.upwind)
    assert thin[2] == pytest.approx(-0.25)
    ridge = de.subcell_distance([-3.0, -2, 1, -1, -3], 1.0, differences=de.upwind)
    assert ridge[2] == pytest.approx(1 / 3)


def test_a_node_next_to_the_interface_is_held_within_a_cell_of_it():
    """Where phi leaps, the parabola of ENO2 may see a slope that would put it farther away."""
    phi = np.array([-4.0, -3.9, -3.8, 0.1, 0.2, 0.3])
    assert de.subcell_distance(phi, 1.0)[2] < -1.5
    assert de.reinitialize(phi, 1.0, band=1.0)[2] == -1


def test_flat_data_have_no_distance_and_do_no_harm():
    phi = np.array([-1.0, -1, -1, 1, 1, 1])
    assert np.isfinite(de.subcell_distance(np.zeros(5), 1.0)).all()
    np.testing.assert_array_equal(de.smeared_sign(np.zeros(5), 1.0), 0)
    expected = [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5]
    np.testing.assert_allclose(de.redistance(phi, 1.0), expected)
    np.testing.assert_allclose(de.reinitialize(phi, 1.0), expected, atol=0.6)  # sides, to a cell


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


# ---- only the nodes that the band can hang on ----


@pytest.mark.parametrize("scheme", [de.upwind, de.eno2, de.weno5])
@pytest.mark.parametrize("boundary", [de.neumann, de.periodic])
@DIMS
def test_in_the_band_it_does_not_count_that_few_nodes_are_worked_on(
    dim, scheme, boundary, monkeypatch
):
    d, dx = ball(dim, {1: 201, 2: 81, 3: 33}[dim])
    found = []
    for few in (0.0, 1.1):  # never, and always
        monkeypatch.setattr(reinitialization, "_FEW", few)
        options = {"band": 3 * max(dx), "differences": scheme, "boundary": boundary}
        found.append(de.reinitialize(level_set(d), dx, **options))
    everywhere, nearby = found
    np.testing.assert_allclose(nearby[in_band(d, dx)], everywhere[in_band(d, dx)], atol=1e-6)
    far = np.abs(d) > 14 * max(dx)
    np.testing.assert_array_equal(nearby[far], level_set(d)[far])


def test_the_callback_sees_the_whole_grid():
    d, dx = ball(2, 161)
    seen = []
    de.reinitialize(level_set(d), dx, band=max(dx), callback=lambda _, phi: seen.append(phi))
    assert {phi.shape for phi in seen} == {d.shape}
    assert np.ptp([phi[0, 0] for phi in seen]) == 0
    assert np.ptp([phi[80, 80 + 42] for phi in seen]) > 0


@pytest.mark.parametrize("few", [0.0, 1.1], ids=["everywhere", "nearby"])
@pytest.mark.parametrize("shift", [1, 50, 99, 150])
def test_on_a_ring_it_does_not_count_where_the_seam_is(shift, few, monkeypatch):
    monkeypatch.setattr(reinitialization, "_FEW", few)
    phi = 3 * np.sin(np.pi * (np.arange(200) * 0.02 - 0.01) / 2)
    found = [
        de.reinitialize(np.roll(phi, k), 0.02, band=0.2, boundary=de.periodic) for k in (0, shift)
    ]
    band = np.abs(found[0]) < 0.2
    np.testing.assert_allclose(np.roll(found[1], -shift)[band], found[0][band], atol=1e-12)


@pytest.mark.parametrize("factor", [1e-160, 1e160])
@DIMS
def test_very_large_and_very_small_values_have_the_same_distances(dim, factor):
    d, dx = ball(dim, 21)
    phi = level_set(d)
    for solver in (de.subcell_distance, de.smeared_sign):
        np.testing.assert_allclose(solver(factor * phi, dx), solver(phi, dx), rtol=1e-12)


def test_a_scheme_that_is_none_is_named_by_the_distance_below_a_cell():
    with pytest.raises(TypeError, match="differences must be a scheme"):
        de.subcell_distance(PHI, 0.1, differences="eno2")
    with pytest.raises(TypeError, match="boundary must be a padding function"):
        de.subcell_distance(PHI, 0.1, boundary="periodic")
