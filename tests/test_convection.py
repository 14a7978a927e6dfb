"""Convection: upwind differences, time steps and their limit, regions carried along."""

from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

import distmesh_edu as de
from distmesh_edu import _slabs
from distmesh_edu.convection import march, next_step

DIMS = pytest.mark.parametrize("dim", [1, 2, 3])
BOUNDARIES = [de.periodic, de.neumann, de.extrapolated]
SCHEMES = [de.upwind, de.eno2, de.eno3, de.weno5]
DATA = Path(__file__).parent / "data"

shapes = array_shapes(min_dims=1, max_dims=3, min_side=2, max_side=7)
levels = st.floats(-10, 10, allow_subnormal=False)
cfls = st.floats(0.01, 1.0)


def euler(phi, velocity, dx, dt, boundary=de.periodic):
    """One step of the upwind method, whatever its length."""

    def rate(phi, t):
        return de.convection_rate(phi, velocity, dx, boundary=boundary)

    return de.runge_kutta_step(phi, rate, 0.0, dt, 1)


def listing(name):
    lines = (DATA / name).read_text("utf-8").splitlines()
    head, *rows = [line.split(",") for line in lines if not line.startswith("#")]
    return dict(zip(head, np.array(rows, dtype=float).T, strict=True))


# ---- differences ----


@given(
    dim=st.integers(1, 3),
    slopes=st.tuples(levels, levels, levels),
    velocity=st.tuples(levels, levels, levels),
)
def test_a_plane_is_convected_exactly(dim, slopes, velocity):
    """Whatever the flow, and with a spacing of its own for each axis."""
    slopes, velocity, dx = slopes[:dim], velocity[:dim], (0.1, 0.25, 0.5)[:dim]
    nodes = np.indices((6, 5, 4)[:dim])
    start = sum(g * h * one for g, h, one in zip(slopes, dx, nodes, strict=True))
    end = start - 0.3 * np.dot(slopes, velocity)
    np.testing.assert_allclose(de.advect(start, velocity, dx, 0.3), end, rtol=0, atol=1e-10)


def test_minus_looks_left_and_plus_looks_right():
    minus, plus = de.upwind(np.array([1.0, 2.0, 4.0, 8.0]), 0.5, 0, boundary=de.periodic)
    np.testing.assert_array_equal(minus, [-14, 2, 4, 8])
    np.testing.assert_array_equal(plus, [2, 4, 8, -14])


def test_the_flow_comes_from_the_left_or_from_the_right():
    phi, u = np.array([0.0, 1.0, 4.0, 9.0, 16.0]), np.array([1.0, 2.0, 0.0, -1.0, -2.0])
    np.testing.assert_array_equal(de.convection_rate(phi, u, 1.0), [-1, -2, 0, 7, 14])


# ---- order of accuracy ----


def wave(points, velocity, t):
    """Return a smooth function of period one along each axis, carried along."""
    places = 2 * np.pi * (points - t * np.asarray(velocity))
    return np.exp(np.sin(places) / 2).prod(axis=-1)


def translation_error(scheme, dim, n, boundary=de.periodic, **options):
    """Return the mean error after a time of 0.2, with another spacing along each axis."""
    dx = (1 / n, 1 / (n + 4), 1 / (n - 4))[:dim]
    velocity = (1.0, -0.6, 0.3)[:dim]
    points = de.Grid(((0,) * dim, (1,) * dim), dx, periodic=True).points
    phi = de.advect(
        wave(points, velocity, 0), velocity, dx, 0.2, differences=scheme, boundary=boundary
    )
    return np.abs(phi - wave(points, velocity, 0.2)).mean()


@pytest.mark.parametrize(
    ("scheme", "order", "dim", "n"),
    [
        (de.upwind, 1, 1, 160),
        (de.upwind, 1, 2, 80),
        (de.upwind, 1, 3, 32),
        (de.eno2, 2, 1, 160),
        (de.eno2, 2, 2, 64),
        (de.eno2, 2, 3, 24),
        (de.eno3, 3, 1, 80),
        (de.eno3, 3, 2, 48),
        (de.weno5, 3, 1, 160),
    ],
)
def test_order_of_a_translation(scheme, order, dim, n):
    """For WENO5 it is the order of its Runge-Kutta method."""
    coarse, fine = (translation_error(scheme, dim, k) for k in (n, 2 * n))
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.2)


@DIMS
@pytest.mark.parametrize("sign", [1, -1])
def test_a_cfl_number_of_one_is_an_exact_shift(dim, sign):
    phi = np.random.default_rng(0).integers(-9, 9, (8, 7, 6)[:dim]).astype(float)
    velocity = [0.0] * dim
    velocity[-1] = 2.0 * sign
    shifted = de.advect(phi, velocity, 0.5, 0.75, boundary=de.periodic, cfl=1)
    np.testing.assert_array_equal(shifted, np.roll(phi, 3 * sign, axis=-1))


def test_what_the_smearing_is():
    """Upwind solves phi_t + u phi_x = D phi_xx more exactly, with D = u dx (1 - CFL) / 2."""
    dx, cfl, time = 0.01, 0.4, 0.5
    x = de.Grid((0, 1), dx, periodic=True).axes[0]
    phi = de.advect(np.sin(2 * np.pi * x), 1.0, dx, time, boundary=de.periodic, cfl=cfl)
    amplitude = np.abs(np.fft.rfft(phi)[1]) / (len(x) / 2)
    diffusion = -np.log(amplitude) / (4 * np.pi**2 * time)
    assert diffusion == pytest.approx(dx * (1 - cfl) / 2, rel=0.01)


# ---- stability ----


@given(
    phi=arrays(np.float64, st.integers(2, 30), elements=levels),
    cfl=cfls,
    sign=st.sampled_from([1, -1]),
    boundary=st.sampled_from([de.periodic, de.neumann]),
)
def test_the_total_variation_never_grows(phi, cfl, sign, boundary):
    def variation(phi):
        return np.abs(np.diff(boundary(phi, 1, 0)))[1:].sum()

    later = euler(phi, sign * 2.0, 0.1, cfl * 0.05, boundary)
    assert variation(later) <= variation(phi) + 1e-10


@given(data=st.data(), n=st.integers(2, 20), cfl=st.floats(0.01, 0.5))
def test_the_total_variation_never_grows_where_the_speed_varies(data, n, cfl):
    """Half the limit, for two neighbours may both take from the interval between them."""
    phi, u = (data.draw(arrays(np.float64, n, elements=levels)) for _ in range(2))
    dt = cfl * min(de.time_step_limit([u], 0.1), 1e3)
    later = euler(phi, u, 0.1, dt)
    before, after = (np.abs(np.diff(one, append=one[0])).sum() for one in (phi, later))
    assert after <= before + 1e-10


@given(data=st.data(), shape=shapes, cfl=cfls, boundary=st.sampled_from(BOUNDARIES[:2]))
def test_no_new_highs_or_lows(data, shape, cfl, boundary):
    """In any dimension and any flow: each new value is a mean of old ones."""
    phi = data.draw(arrays(np.float64, shape, elements=levels))
    velocity = [data.draw(arrays(np.float64, shape, elements=levels)) for _ in shape]
    dx = (0.1, 0.3, 0.2)[: len(shape)]
    dt = cfl * min(de.time_step_limit(velocity, dx), 1e3)
    later = euler(phi, velocity, dx, dt, boundary)
    assert phi.min() - 1e-10 <= later.min()
    assert later.max() <= phi.max() + 1e-10


@pytest.mark.parametrize("dim", [2, 3])
def test_along_the_diagonal_the_sum_of_speeds_counts(dim):
    """Equation (3.9) against (3.10), which takes the length of V and the smallest spacing."""
    phi = np.random.default_rng(0).normal(size=(12,) * dim)
    velocity, dx = (1.0,) * dim, 0.1
    right, popular = de.time_step_limit(velocity, dx), dx / np.sqrt(dim)
    ends = []
    for dt in (right, popular):
        end = phi
        for _ in range(100):
            end = euler(end, velocity, dx, dt)
        ends.append(np.abs(end).max())
    assert ends[0] <= np.abs(phi).max()
    assert ends[1] > 1e6


def test_the_limit_on_the_time_step():
    x = np.linspace(0, 1, 4)
    assert de.time_step_limit(2.0, 0.5) == 0.25
    assert de.time_step_limit([x], 0.1) == pytest.approx(0.1)
    assert de.time_step_limit((3.0, -4.0), (0.1, 0.2)) == pytest.approx(1 / 50)
    assert de.time_step_limit((x, 1.0, -x[::-1]), 0.5) == pytest.approx(0.25)
    # The components are largest at different nodes: their sum is what counts.
    assert de.time_step_limit((x, x[::-1]), 0.5) == pytest.approx(0.5)
    assert de.time_step_limit((0.0, 0.0), 1.0) == np.inf


@pytest.mark.parametrize("stages", [1, 2, 3])
@pytest.mark.parametrize(
    "speed",
    [
        lambda t: np.cos(np.pi * t),  # stands still halfway
        lambda t: np.sin(2 * np.pi * t),  # and at the start, the middle and the end
        lambda t: np.sin(np.pi * t) ** 8,
        lambda t: np.exp(6 * t - 6),
        lambda t: 1 / (1.01 - t),
    ],
    ids=["cos", "sin", "burst", "exp", "sudden"],
)
def test_steps_stay_below_the_limit_when_the_velocity_changes(speed, stages):
    times = [0.0]
    phi = np.sin(2 * np.pi * np.arange(20) / 20)
    de.advect(
        phi,
        lambda t: speed(t),
        0.05,
        1.0,
        boundary=de.periodic,
        stages=stages,
        callback=lambda t, phi: times.append(t),
    )
    assert times[-1] == 1.0
    for start, stop in pairwise(times):
        stage_times = np.array([start, (start + stop) / 2, stop])
        assert (stop - start) * np.abs(speed(stage_times)).max() / 0.05 <= 0.5 * (1 + 1e-8)
        between = np.linspace(start, stop, 50)
        assert (stop - start) * np.abs(speed(between)).max() / 0.05 <= 0.6


def test_a_flow_that_swings_brings_everything_back():
    """The velocity is zero at the start, halfway and at the end, yet much happens between."""
    x = de.Grid((0, 1), 1 / 80, periodic=True).axes[0]
    start = np.exp(np.sin(2 * np.pi * x))
    options = {"differences": de.weno5, "boundary": de.periodic}
    half = de.advect(start, lambda t: np.sin(2 * np.pi * t), 1 / 80, 0.5, **options)
    full = de.advect(start, lambda t: np.sin(2 * np.pi * t), 1 / 80, 1.0, **options)
    np.testing.assert_allclose(half, np.exp(np.sin(2 * np.pi * (x - 1 / np.pi))), atol=1e-3)
    np.testing.assert_allclose(full, start, atol=1e-3)


# ---- symmetry and the forms of a velocity ----


@DIMS
@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("solver", [de.advect, de.advect_semi_lagrangian])
def test_a_mirrored_flow_gives_the_mirrored_result(solver, boundary, dim):
    rng = np.random.default_rng(3)
    shape, dx = (9, 8, 7)[:dim], (0.1, 0.2, 0.3)[:dim]
    phi, *velocity = rng.normal(size=(dim + 1, *shape))
    result = solver(phi, velocity, dx, 0.2, boundary=boundary)
    for axis in range(dim):
        turned = [np.flip(u, axis) * (-1 if k == axis else 1) for k, u in enumerate(velocity)]
        mirrored = solver(np.flip(phi, axis), turned, dx, 0.2, boundary=boundary)
        if solver is de.advect:
            np.testing.assert_array_equal(np.flip(mirrored, axis), result)
        else:  # the spline is solved from one end to the other
            np.testing.assert_allclose(np.flip(mirrored, axis), result, rtol=0, atol=1e-10)


@DIMS
@pytest.mark.parametrize("solver", [de.advect, de.advect_semi_lagrangian])
def test_a_velocity_may_be_numbers_arrays_or_a_function_of_time(solver, dim):
    shape = (9, 8, 7)[:dim]
    phi = np.random.default_rng(0).normal(size=shape)
    numbers = (1.0, -2.0, 3.0)[:dim]
    mixed = [np.full(shape, u) if k else u for k, u in enumerate(numbers)]
    stacked = np.stack([np.full(shape, u) for u in numbers])
    forms = [numbers, mixed, stacked, lambda t: numbers, lambda t: stacked]
    if dim == 1:
        forms += [1.0, stacked[0], [np.float64(1.0)], lambda t: 1.0, lambda t: stacked[0]]
    results = [solver(phi, form, 0.1, 0.07) for form in forms]
    for result in results:
        np.testing.assert_array_equal(result, results[0])


@pytest.mark.parametrize("solver", [de.advect, de.advect_semi_lagrangian])
def test_what_it_is_given_stays_as_it_was(solver):
    phi = np.arange(12.0).reshape(4, 3).T @ np.ones((4, 5))
    phi = np.vstack((phi, phi))
    u = np.full(phi.shape, 0.5)
    before = phi.copy(), u.copy()
    kept = [solver(phi, (u, 1.0), 0.1, time) for time in (0.0, 1.0)]
    assert not np.shares_memory(kept[0], phi)
    np.testing.assert_array_equal(kept[0], phi)
    np.testing.assert_array_equal(phi, before[0])
    np.testing.assert_array_equal(u, before[1])
    still = solver(phi, (0.0, 0.0), 0.1, 5.0)
    np.testing.assert_allclose(still, phi, rtol=0, atol=1e-12)


def test_integers_are_numbers_too():
    np.testing.assert_allclose(de.advect([0, 1, 2, 3], 1, 1, 2), [-2, -1, 0, 1])


@pytest.mark.parametrize("solver", [de.advect, de.advect_semi_lagrangian])
def test_the_callback_sees_each_step(solver):
    seen = []
    phi = np.sin(np.arange(20.0))
    end = solver(phi, 1.0, 0.1, 3.0, cfl=0.3, callback=lambda t, phi: seen.append((t, phi)))
    times = np.array([t for t, _ in seen])
    # 3.0 / 0.03: rounding must not turn the hundred steps into 101.
    np.testing.assert_allclose(times, np.arange(1, 101) * 0.03)
    assert times[-1] == 3.0
    np.testing.assert_array_equal(seen[-1][1], end)
    np.testing.assert_array_equal(solver(phi, 1.0, 0.1, 0.03, cfl=0.3), seen[0][1])


# ---- the ends of the grid ----


@DIMS
@pytest.mark.parametrize("scheme", SCHEMES)
def test_where_the_flow_leaves_nothing_is_asked_of_the_boundary(dim, scheme):
    """Only at the first order: the others look to both sides."""

    def other(phi, width, axis):
        padded = de.neumann(phi, width, axis)
        padded[(slice(None),) * axis + (slice(-width, None),)] = 77.0
        return padded

    phi = np.random.default_rng(0).normal(size=(8, 7, 6)[:dim])
    kept, changed = (
        de.advect(phi, (1.0,) * dim, 0.1, 0.1, differences=scheme, boundary=boundary)
        for boundary in (de.neumann, other)
    )
    assert np.array_equal(kept, changed) == (scheme is de.upwind)


def test_neumann_freezes_the_value_at_an_inflow():
    """Erratum E3.5c."""
    x = np.linspace(-2, 2, 81)
    phi = np.exp(-10 * (x + 1) ** 2)
    end = de.advect(phi, 1.0, 0.05, 0.5, boundary=de.neumann, cfl=1)
    np.testing.assert_allclose(end[:11], phi[0], rtol=1e-12)
    np.testing.assert_allclose(end[10:], phi[:-10], rtol=0, atol=1e-15)


# ---- slabs ----


@DIMS
@pytest.mark.parametrize(("boundary", "scheme"), [*product(BOUNDARIES, SCHEMES)])
def test_slabs_give_what_the_whole_array_gives(monkeypatch, boundary, scheme, dim):
    shape = (37, 6, 5)[:dim]
    phi, *velocity = np.random.default_rng(dim).normal(size=(dim + 1, *shape))

    def rate(nodes):
        monkeypatch.setattr(_slabs, "SLAB", nodes)
        return de.convection_rate(phi, velocity, 0.1, differences=scheme, boundary=boundary)

    whole = rate(10**9)
    for rows in (4, 7, 36, 37):
        np.testing.assert_array_equal(rate(rows * phi[0].size), whole)


def test_a_large_array_goes_through_slabs(monkeypatch):
    """Or the test above would say nothing. This scheme looks less far than it may."""
    lengths = []

    @de._types.scheme(stages=1, width=2, cfl=1.0)
    def watched(phi, dx, axis, *, boundary=de.neumann):
        lengths.append(len(phi))
        return de.upwind(phi, dx, axis, boundary=boundary)

    assert _slabs.SLAB < 200**2
    phi = np.random.default_rng(0).normal(size=(23, 5))
    whole = de.convection_rate(phi, (1.0, -1.0), 1.0)
    monkeypatch.setattr(_slabs, "SLAB", 50)
    slabs = de.convection_rate(phi, (1.0, -1.0), 1.0, differences=watched)
    assert lengths == [10, 10, 10, 10, 3, 3]
    np.testing.assert_array_equal(slabs, whole)


def test_a_scheme_of_ones_own_needs_no_attributes(monkeypatch):
    """It is given the whole array, for nobody knows how far it looks."""

    def central(phi, dx, axis, *, boundary):
        minus, plus = de.upwind(phi, dx, axis, boundary=boundary)
        return (minus + plus) / 2, (minus + plus) / 2

    monkeypatch.setattr(_slabs, "SLAB", 20)
    x = np.linspace(0, 1, 41)
    rate = de.convection_rate(x**2, 1.0, x[1], differences=central)
    np.testing.assert_allclose(rate[1:-1], -2 * x[1:-1])


# ---- time ----


@pytest.mark.parametrize("stages", [1, 2, 3])
@pytest.mark.parametrize(
    ("rate", "end"),
    [
        (lambda y, t: -y, np.exp(-1)),
        (lambda y, t: -y * np.cos(t), np.exp(-np.sin(1))),
        (lambda y, t: t - y**2, 0.8333833914643602),  # by scipy's DOP853
    ],
    ids=["decay", "linear in y, not in t", "neither"],
)
def test_order_of_the_runge_kutta_methods(rate, end, stages):
    def error(n):
        def step(y, t, dt):
            return de.runge_kutta_step(y, rate, t, dt, stages)

        y = march(np.ones(1), step, 1.0, lambda t: 1 / n)
        return abs(y[0] - end)

    assert np.log2(error(40) / error(80)) == pytest.approx(stages, abs=0.2)


@pytest.mark.parametrize(
    "solver",
    [
        lambda phi, callback: de.advect(phi, 1.0, 0.1, 0.3, callback=callback),
        lambda phi, callback: de.advect_semi_lagrangian(phi, 1.0, 0.1, 0.3, callback=callback),
        lambda phi, callback: de.move_in_normal_direction(phi, 1.0, 0.1, 0.3, callback=callback),
        lambda phi, callback: de.reinitialize(phi, 0.1, band=0.3, callback=callback),
    ],
)
def test_a_callback_cannot_change_what_it_sees(solver):
    def spoil(_, phi):
        phi *= 0

    with pytest.raises(ValueError, match="read-only"):
        solver(np.linspace(-1, 1, 21), spoil)


def test_steps_are_equal_and_divide_the_time():
    assert next_step(0.0, 1.0, lambda t: 0.3) == 0.25
    assert next_step(0.0, 1.0, lambda t: np.inf) == 1.0
    assert next_step(2.0, 3.0, lambda t: 1.0) == 1.0
    assert next_step(0.95, 3.0, lambda t: 0.1 if t < 1 else 0.01) == pytest.approx(0.01)


@pytest.mark.parametrize("solver", [de.advect, de.advect_semi_lagrangian])
def test_rounding_adds_no_step_and_misses_no_end(solver):
    for steps in range(1, 60):
        times = []
        cfl = 0.7 / steps  # for a limit of 1
        solver(np.arange(4.0), 1.0, 1.0, 0.7, cfl=cfl, callback=lambda t, _, to=times: to.append(t))
        assert len(times) == steps
        assert times[-1] == 0.7


# ---- the thesis's listings ----


def test_the_listing_of_figure_3_1():
    octave = listing("listing_3_5.csv")
    x = -2 + 0.05 * np.arange(81)
    phi, mirrored = np.exp(-10 * (x + 1) ** 2), np.exp(-10 * (x - 1) ** 2)

    def run(phi, u, cfl):
        return de.advect(phi, u, 0.05, 0.5, boundary=de.neumann, cfl=cfl)

    np.testing.assert_allclose(run(phi, 1, 1), octave["printed"], rtol=0, atol=1e-15)
    np.testing.assert_allclose(run(phi, 1, 0.5), octave["half"], rtol=0, atol=1e-15)
    np.testing.assert_allclose(run(mirrored, -1, 1), octave["minus_right"], rtol=0, atol=1e-15)


def test_the_listings_left_difference_for_both_signs():
    """Erratum E3.5a: with u = -1 it multiplies a saw-tooth by 1 + 2 CFL = 3 in each step."""

    def left(phi, dx, axis, *, boundary):
        minus, _ = de.upwind(phi, dx, axis, boundary=boundary)
        return minus, minus

    x = -2 + 0.05 * np.arange(81)
    phi, highest = np.exp(-10 * (x - 1) ** 2), []
    for _ in range(4):
        phi = de.advect(phi, -1, 0.05, 0.5, differences=left, boundary=de.neumann, cfl=1)
        highest.append(np.abs(phi).max())
        if len(highest) == 1:
            printed = listing("listing_3_5.csv")["minus_printed"]
            np.testing.assert_allclose(phi, printed, rtol=0, atol=1e-13)
    assert highest[0] == pytest.approx(1.84, abs=0.01)
    assert highest[1] == pytest.approx(8.86, abs=0.01)
    assert highest[3] == pytest.approx(8.8e4, rel=0.1)  # rounding, times 3**40, is 1 % of it


def test_the_listing_of_section_3_8():
    right = listing("listing_3_8.csv")
    x = -2 + 0.05 * np.arange(80)
    triangle = np.maximum(0.5 - np.abs(x + 1), 0)
    options = {"differences": de.eno2, "boundary": de.periodic}
    heun = de.advect(triangle, 1, 0.05, 2.5, **options)
    np.testing.assert_allclose(heun, right["heun"], rtol=0, atol=1e-14)
    with pytest.warns(de.StabilityWarning, match="eno2 with stages=1 is unstable"):
        euler = de.advect(triangle, 1, 0.05, 2.5, stages=1, **options)
    with pytest.warns(de.StabilityWarning, match="eno2 with stages=1 is unstable"):
        minus = de.advect(triangle, -1, 0.05, 0.5, stages=1, **options)
    np.testing.assert_allclose(euler, right["euler"], rtol=0, atol=1e-14)
    np.testing.assert_allclose(minus, right["minus"], rtol=0, atol=1e-14)


# ---- semi-Lagrangian ----


@DIMS
@pytest.mark.parametrize("cfl", [1.5, 4.0, 7.3])
def test_a_cubic_is_carried_exactly(dim, cfl):
    """Away from the rim, where the spline has to make up its end."""
    n = {1: 120, 2: 70, 3: 52}[dim]
    dx = (0.02, 0.025, 0.015)[:dim]
    velocity = (0.4, -0.6, 0.3)[:dim]
    x = np.stack([h * (one - n / 2) for h, one in zip(dx, np.indices((n,) * dim), strict=True)])

    def cubic(x):
        return sum((k + 1) * x[k] ** 3 - 2 * x[k] ** 2 + x[k] for k in range(dim)) + x.prod(axis=0)

    shift = 0.2 * np.array(velocity).reshape(-1, *[1] * dim)
    end = de.advect_semi_lagrangian(cubic(x), velocity, dx, 0.2, cfl=cfl)
    inner = (slice(n // 2 - 2, n // 2 + 2),) * dim
    np.testing.assert_allclose(end[inner], cubic(x - shift)[inner], rtol=0, atol=1e-9)


@DIMS
def test_semi_lagrangian_order_in_space(dim):
    """Four for a given number of steps, that of a cubic spline; halfway between nodes in each."""
    n = {1: 20, 2: 20, 3: 12}[dim]
    velocity = np.array((1.5, -2.5, 0.5)[:dim]) / n

    def error(n):
        points = de.Grid(((0,) * dim, (1,) * dim), 1 / n, periodic=True).points
        start, end = (wave(points, velocity, t) for t in (0.0, 3.0))
        cfl = n * np.abs(velocity).sum()  # three steps
        moved = de.advect_semi_lagrangian(
            start, velocity, 1 / n, 3.0, boundary=de.periodic, cfl=cfl
        )
        return np.abs(moved - end).max()

    assert np.log(error(n) / error(3 * n)) / np.log(3) == pytest.approx(4, abs=0.2)


def test_semi_lagrangian_order_in_time():
    """A turning plane: space is exact, so what is left comes from the paths."""
    x, y = np.moveaxis(de.Grid(((-1, -1), (1, 1)), 0.05).points, -1, 0)
    middle = np.hypot(x, y) < 0.3

    def error(cfl):
        end = de.advect_semi_lagrangian(x, (-y, x), 0.05, 1.0, cfl=cfl)
        return np.abs(end - (x * np.cos(1) + y * np.sin(1)))[middle].max()

    assert np.log2(error(5.0) / error(2.5)) == pytest.approx(2, abs=0.2)


def test_semi_lagrangian_order_in_time_of_a_changing_flow():
    """Along a line, with a speed that hangs on the time only."""
    x = np.linspace(0, 1, 41)

    def error(cfl):
        end = de.advect_semi_lagrangian(x, lambda t: 1 + t**2, x[1], 1.0, cfl=cfl)
        return np.abs(end - (x - 4 / 3)).max()

    assert np.log2(error(4.0) / error(2.0)) == pytest.approx(2, abs=0.2)


@DIMS
@pytest.mark.parametrize("cfl", [3.0, 6.0, 1000.0])
def test_semi_lagrangian_shifts_by_whole_cells_exactly(dim, cfl):
    """In steps of one cell, of several, and of more than once round."""
    phi = np.random.default_rng(0).normal(size=(8, 7, 6)[:dim])
    velocity = (1.0, -2.0, 0.0)[:dim]
    end = de.advect_semi_lagrangian(phi, velocity, 1.0, 12.0, boundary=de.periodic, cfl=cfl)
    shifted = np.roll(phi, (12, -24, 0)[:dim], axis=tuple(range(dim)))
    np.testing.assert_allclose(end, shifted, rtol=0, atol=1e-9)


def test_semi_lagrangian_on_a_ring_does_not_see_where_the_numbering_starts():
    phi, u = np.random.default_rng(0).normal(size=(2, 40))

    def run(shift):
        moved = de.advect_semi_lagrangian(
            np.roll(phi, shift), np.roll(u, shift), 0.1, 0.5, boundary=de.periodic
        )
        return np.roll(moved, -shift)

    np.testing.assert_allclose(run(17), run(0), rtol=0, atol=1e-6)


# ---- regions ----


@pytest.mark.parametrize(
    ("solver", "options", "worst"),
    [
        (de.advect, {"cfl": 0.9}, 0.8),
        (de.advect, {"cfl": 0.9, "differences": de.weno5}, 2e-3),
        (de.advect_semi_lagrangian, {}, 2e-3),
    ],
    ids=["upwind", "weno5", "semi-Lagrangian"],
)
def test_a_disc_that_turns_keeps_its_area_as_well_as_the_scheme_can(solver, options, worst):
    grid = de.Grid(((-1, -1), (1, 1)), 1 / 32)
    x, y = np.moveaxis(grid.points, -1, 0)
    phi = de.circle((0.4, 0.0), 0.3)(grid.points)
    turned = solver(phi, (-2 * np.pi * y, 2 * np.pi * x), grid.dx, 1.0, **options)
    before, after = (grid.dx[0] ** 2 * np.clip(0.5 - 32 * f, 0, 1).sum() for f in (phi, turned))
    assert abs(after / before - 1) < worst
    if solver is de.advect and "differences" not in options:
        assert after < 0.9 * before  # and first order loses much


# ---- bad input ----

PHI = np.arange(20.0).reshape(4, 5) ** 2
NAN = np.where(PHI == 36, np.nan, PHI)


@pytest.mark.parametrize("solver", [de.advect, de.advect_semi_lagrangian])
@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"phi": NAN}, ValueError, r"phi must be finite; phi\[1, 1\] is nan"),
        ({"phi": PHI + 1j}, TypeError, "phi must hold real numbers"),
        ({"phi": 3.0}, ValueError, r"phi must be an array of values on a grid.*the shape \(\)"),
        ({"phi": np.ones((2,) * 4)}, ValueError, "one, two or three axes"),
        ({"phi": np.ones((4, 1))}, ValueError, r"phi must have [24] nodes at least along each"),
        ({"velocity": 1.0}, ValueError, "one component for each of the 2 axes of phi, uv; got 1"),
        ({"velocity": (1, 1, 1)}, ValueError, "velocity must have one component for each"),
        ({"velocity": np.ones((4, 5, 2))}, ValueError, r"shape \(4, 5, 2\).*moveaxis"),
        ({"velocity": (1, PHI.T)}, ValueError, r"velocity\[1\] must be a number or have phi's"),
        ({"velocity": (np.inf, 1)}, ValueError, r"velocity\[0\] must be finite"),
        ({"velocity": lambda t: (1, np.nan)}, ValueError, r"velocity\[1\] must be finite"),
        ({"velocity": lambda t: 1}, ValueError, "one component for each of the 2 axes"),
        ({"velocity": None}, ValueError, "one component for each of the 2 axes"),
        ({"velocity": ("a", "b")}, TypeError, r"velocity\[0\] must hold real numbers"),
        ({"dx": 0}, ValueError, "dx must be positive; along axis 0 it is 0"),
        ({"dx": (0.1, -0.1)}, ValueError, "dx must be positive; along axis 1 it is -0.1"),
        ({"dx": (0.1,) * 3}, ValueError, "dx must be one number or one for each of the 2 axes"),
        ({"dx": np.nan}, ValueError, "dx must be finite"),
        ({"time": -1.0}, ValueError, "time must be one number, zero or more.*reverse the velocity"),
        ({"time": np.inf}, ValueError, "time must be finite"),
        ({"cfl": 0}, ValueError, "cfl must be one positive number"),
        ({"cfl": np.nan}, ValueError, "cfl must be finite"),
    ],
)
def test_bad_arguments_are_named(solver, change, error, words):
    arguments = {"phi": PHI, "velocity": (1.0, 2.0), "dx": 0.1, "time": 0.1} | change
    with pytest.raises(error, match=words):
        solver(**arguments)


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"cfl": 1.1}, ValueError, "cfl must not be above 1 with upwind; got 1.1"),
        ({"differences": "upwind"}, TypeError, "differences must be a scheme, the function upwind"),
        ({"stages": 4}, ValueError, "stages must be 1, 2 or 3; got 4"),
    ],
)
def test_bad_options_of_advect_are_named(options, error, words):
    with pytest.raises(error, match=words):
        de.advect(PHI, (1.0, 1.0), 0.1, 0.1, **options)


def test_bad_arguments_of_the_parts_are_named():
    with pytest.raises(ValueError, match=r"got the shape \(19,\)"):
        de.convection_rate(np.ones(20), np.ones(19), 0.1)
    with pytest.raises(TypeError, match=r"numbers or arrays here.*Call it with a time first"):
        de.convection_rate(PHI, lambda t: (1, 1), 0.1)
    with pytest.raises(TypeError, match=r"numbers or arrays here.*Call it with a time first"):
        de.time_step_limit(lambda t: (1, 1), 0.1)
    with pytest.raises(ValueError, match=r"got 81 of them. On a line.*\[u\]"):
        de.time_step_limit(np.ones(81), 0.1)
    with pytest.raises(ValueError, match=r"got the shapes \[\(3,\), \(4,\)\]"):
        de.time_step_limit((np.ones(3), np.ones(4)), 0.1)
    with pytest.raises(ValueError, match="dx must be one number or one for each of the 2 axes"):
        de.time_step_limit((1.0, 1.0), (0.1, 0.1, 0.1))
    with pytest.raises(TypeError, match=r"velocity\[0\] must hold real numbers"):
        de.time_step_limit("fast", 0.1)
    with pytest.raises(TypeError, match="differences must be a scheme"):
        de.convection_rate(PHI, (1, 1), 0.1, differences=None)
    with pytest.raises(ValueError, match="stages must be 1, 2 or 3; got 0"):
        de.runge_kutta_step(PHI, lambda phi, t: phi, 0.0, 0.1, 0)


@pytest.mark.parametrize(
    ("scheme", "stages"), [(de.eno2, 1), (de.eno3, 1), (de.eno3, 2), (de.weno5, 2)]
)
def test_an_unstable_pair_warns(scheme, stages):
    with pytest.warns(de.StabilityWarning, match=rf"stages={stages} is unstable.*stages=[23]"):
        de.advect(PHI, (1.0, 1.0), 0.1, 0.1, differences=scheme, stages=stages)


def test_semi_lagrangian_needs_four_nodes():
    with pytest.raises(ValueError, match=r"phi must have 4 nodes at least.*\(3, 5\)"):
        de.advect_semi_lagrangian(np.ones((3, 5)), (1.0, 1.0), 0.1, 0.1)
