"""Motion along the normal, phi_t + a |grad phi| = 0: fronts that grow, shrink, meet and arrive."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ._slabs import in_slabs
from ._types import ArrayLike, Boundary, Differences, FloatArray
from ._validation import as_boundary, as_cfl, as_level_set, as_spacing, as_speed, as_time, as_values
from .boundaries import extrapolated, neumann
from .convection import Callback, Rate, march, runge_kutta_order, runge_kutta_step
from .eno import eno2

Speed = ArrayLike | Callable[[float], ArrayLike]


def godunov_norm(
    phi: ArrayLike,
    speed: ArrayLike,
    dx: float | Sequence[float],
    *,
    differences: Differences = eno2,
    boundary: Boundary = extrapolated,
) -> FloatArray:
    """Return |grad phi|, each slope taken from where a front of that speed comes from.

    Parameters
    ----------
    phi : array_like of one to three axes
        Values at the nodes.
    speed : array_like, number or of phi's shape
        Only its sign counts: positive where the front moves towards larger phi. Where it is zero
        the norm is zero.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.
    differences : scheme
        `upwind`, `eno2`, `eno3`, `weno5`, or a function of yours with their signature.
    boundary : padding function
        What lies beyond the last nodes.

    Returns
    -------
    ndarray of phi's shape, phi per length

    Raises
    ------
    ValueError, TypeError
        If speed or dx does not fit phi, or something is not finite.

    Notes
    -----
    For a front that moves towards larger phi, a slope from the left counts if it rises, one from
    the right if it falls; of two that count, the steeper one, and none at a valley. That is
    max(minus, -plus, 0) along each axis: Godunov's choice [Godunov1959]_ in the form of Rouy and
    Tourin [RouyTourin1992]_, thesis section 4.3. A negative speed swaps the sides.

    Examples
    --------
    >>> x = np.linspace(-2.0, 2.0, 5)
    >>> godunov_norm(np.abs(x), 1.0, 1.0), godunov_norm(np.abs(x), -1.0, 1.0)
    (array([1., 1., 0., 1., 1.]), array([1., 1., 1., 1., 1.]))
    """
    values = as_values("phi", phi)
    steps = as_spacing(dx, values.ndim)
    as_boundary(boundary)
    runge_kutta_order(differences)
    sign = np.sign(as_speed(speed, values.shape))

    def norm(phi: FloatArray, boundary: Boundary, sign: FloatArray) -> FloatArray:
        return upwind_norm(phi, boundary, sign, steps, differences)

    return in_slabs(norm, values, boundary, getattr(differences, "width", None), sign)


def move_in_normal_direction(
    phi: ArrayLike,
    speed: Speed,
    dx: float | Sequence[float],
    time: float,
    *,
    differences: Differences = eno2,
    boundary: Boundary = extrapolated,
    cfl: float = 0.5,
    stages: int | None = None,
    callback: Callback | None = None,
) -> FloatArray:
    """Return phi after its level sets have moved along their normals: phi_t + a |grad phi| = 0.

    Parameters
    ----------
    phi : array_like of one to three axes
        Values at the nodes.
    speed : array_like or callable, length / time
        a: a number, or an array of phi's shape; a function of the time that returns it if it
        changes. Positive moves the front outwards, towards larger phi.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.
    time : float, time
        How long.
    differences : scheme
        `upwind`, `eno2`, `eno3`, `weno5`, or a function of yours with their signature.
    boundary : padding function
        What lies beyond the last nodes.
    cfl : float, dimensionless
        The largest CFL number of a step, dt max|a| sqrt(1 / dx**2 + 1 / dy**2 + ...): at
        most what the scheme bears, 1 for `upwind` and `weno5`, 0.9 for `eno2` and `eno3`.
    stages : {1, 2, 3}, optional
        The order of the TVD Runge-Kutta method; the one that goes with the scheme if None.
    callback : callable, optional
        Called as callback(t, phi) after each step.

    Returns
    -------
    ndarray of phi's shape
        The values at the end.

    Raises
    ------
    ValueError, TypeError
        If speed or dx does not fit phi, something is not finite, `cfl` is more than the scheme
        bears, or `differences` is no scheme.

    Warns
    -----
    StabilityWarning
        If `stages` is less than what goes with the scheme.

    Notes
    -----
    Thesis sections 4.2 to 4.4. The CFL number is that of (4.5) for the worst direction a normal
    can have, the diagonal.

    Examples
    --------
    >>> x = np.linspace(-2.0, 2.0, 9)
    >>> move_in_normal_direction(2 * x, 1.0, 0.5, 1.0)[:3]
    array([-6., -5., -4.])
    """
    values = as_values("phi", phi)
    steps = as_spacing(dx, values.ndim)
    as_boundary(boundary)
    order = runge_kutta_order(differences, stages)
    reach = as_cfl(cfl, differences) / float(np.linalg.norm(1 / np.array(steps)))

    def speed_at(t: float) -> FloatArray:
        return as_speed(speed(t) if callable(speed) else speed, values.shape)

    start = speed_at(0.0)

    def change(phi: FloatArray, boundary: Boundary, a: FloatArray) -> FloatArray:
        return -a * upwind_norm(phi, boundary, np.sign(a), steps, differences)

    def rate(phi: FloatArray, t: float) -> FloatArray:
        a = speed_at(t) if callable(speed) else start
        return in_slabs(change, phi, boundary, getattr(differences, "width", None), a)

    def limit(t: float) -> float:
        fastest = np.abs(speed_at(t) if callable(speed) else start).max()
        return reach / float(fastest) if fastest else np.inf

    def step(phi: FloatArray, t: float, dt: float) -> FloatArray:
        return runge_kutta_step(phi, rate, t, dt, order)

    return march(values, step, time, limit, callback)


def crossing_times(
    phi: ArrayLike,
    dx: float | Sequence[float],
    time: float,
    *,
    differences: Differences = eno2,
    boundary: Boundary = neumann,
    cfl: float = 0.5,
    interpolation: str = "hermite",
) -> FloatArray:
    """Return when a front of speed one, started from the zeros of phi, crosses each node.

    Parameters
    ----------
    phi : array_like of one to three axes
        Values at the nodes; they need not be distances.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.
    time : float, time
        How long to wait for the front, in either direction.
    differences : scheme
        `upwind`, `eno2`, `eno3`, `weno5`, or a function of yours with their signature.
    boundary : padding function
        What lies beyond the last nodes.
    cfl : float, dimensionless
        The largest CFL number of a step; see `move_in_normal_direction`.
    interpolation : {"hermite", "linear"}
        What phi does at a node between two steps: the cubic with the values and the rates of
        both, or the straight line.

    Returns
    -------
    ndarray of phi's shape, time
        Outside, the time when the front arrives that moves outwards; inside, minus the time of
        the one that moves inwards: the signed distance, as the speed is one. Where no front
        arrived, infinity, with the sign of phi.

    Raises
    ------
    ValueError, TypeError
        If dx does not fit phi, phi is not finite or nowhere zero, `cfl` is too large, or
        `interpolation` is neither of the two.

    Notes
    -----
    Thesis section 4.5, after Kimmel and Bruckstein [KimmelBruckstein1993]_ and Osher
    [Osher1993]_.

    Examples
    --------
    >>> x = np.linspace(-1.0, 1.0, 9)
    >>> crossing_times(4 * x - 0.5, 0.25, 0.5).round(3)
    array([  -inf,   -inf,   -inf, -0.375, -0.125,  0.125,  0.375,    inf,
              inf])
    """
    values = as_level_set(as_values("phi", phi))
    steps = as_spacing(dx, values.ndim)
    as_boundary(boundary)
    order = runge_kutta_order(differences)
    dt = as_cfl(cfl, differences) / float(np.linalg.norm(1 / np.array(steps)))
    count = int(np.ceil(as_time(time) / dt - 1e-9))
    if interpolation not in ("hermite", "linear"):
        raise ValueError(f"interpolation must be 'hermite' or 'linear'; got {interpolation!r}.")

    def change(phi: FloatArray, boundary: Boundary) -> FloatArray:
        return -upwind_norm(phi, boundary, np.ones(()), steps, differences)

    def rate(phi: FloatArray, _: float) -> FloatArray:
        return in_slabs(change, phi, boundary, getattr(differences, "width", None))

    def arrivals(phi: FloatArray) -> FloatArray:
        return _arrivals(phi, rate, time / max(count, 1), count, order, interpolation == "hermite")

    return np.where(values > 0, arrivals(values), 0 - arrivals(-values))


def _arrivals(
    phi: FloatArray, rate: Rate, dt: float, count: int, stages: int, smooth: bool
) -> FloatArray:
    """Return when phi passes from above zero to zero, zero where it is not above at first."""
    arrival = np.where(phi > 0, np.inf, 0.0)
    slope = later_slope = rate(phi, 0.0) if smooth else phi
    for step in range(count):
        later = runge_kutta_step(phi, rate, step * dt, dt, stages)
        if smooth:
            later_slope = rate(later, 0.0)
        crossed = (arrival == np.inf) & (later <= 0)
        a, b = phi[crossed], later[crossed]
        share = a / (a - b)
        if smooth:
            share = _zero_of_cubic(a, b, dt * slope[crossed], dt * later_slope[crossed], share)
        arrival[crossed] = (step + share) * dt
        phi, slope = later, later_slope
    return arrival


def _zero_of_cubic(
    a: FloatArray, b: FloatArray, slope_a: FloatArray, slope_b: FloatArray, guess: FloatArray
) -> FloatArray:
    """Return where in [0, 1] the cubic from a > 0 to b <= 0 with these end slopes is zero."""
    low, high, s = np.zeros_like(a), np.ones_like(a), guess
    # The cubic as c0 + s (c1 + s (c2 + s c3)).
    c2 = 3 * (b - a) - 2 * slope_a - slope_b
    c3 = 2 * (a - b) + slope_a + slope_b
    for _ in range(8):
        value = a + s * (slope_a + s * (c2 + s * c3))
        above = value > 0
        low, high = np.where(above, s, low), np.where(above, high, s)
        descent = slope_a + s * (2 * c2 + 3 * s * c3)
        newton = s - value / np.where(descent < 0, descent, -np.inf)
        within = (descent < 0) & (newton >= low) & (newton <= high)
        s = np.where(within, newton, (low + high) / 2)
    return s


def upwind_norm(
    phi: FloatArray,
    boundary: Boundary,
    sign: FloatArray,
    dx: Sequence[float],
    differences: Differences,
) -> FloatArray:
    """Return `godunov_norm` of arguments that have been checked.

    Parameters
    ----------
    phi : ndarray of any shape
        Values at the nodes.
    boundary : padding function
        What lies beyond the last nodes.
    sign : ndarray, a number or of phi's shape
        1, 0 or -1.
    dx : sequence of float, length
        The spacing along each axis.
    differences : scheme
        What takes the slopes.

    Returns
    -------
    ndarray of phi's shape, phi per length
    """
    squares, flipped = np.zeros_like(phi), -sign
    for axis, h in enumerate(dx):
        minus, plus = differences(phi, h, axis, boundary=boundary)
        squares += np.maximum(np.maximum(sign * minus, flipped * plus), 0) ** 2
    return np.sqrt(squares)
