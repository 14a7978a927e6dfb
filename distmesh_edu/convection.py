"""Convection: an implicit function carried along by a given velocity, phi_t + V . grad phi = 0."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from scipy import ndimage

from ._indexing import along
from ._slabs import in_slabs
from ._types import ArrayLike, Boundary, Differences, FloatArray, scheme
from ._validation import (
    as_boundary,
    as_cfl,
    as_numbers,
    as_positive,
    as_spacing,
    as_time,
    as_values,
)
from ._warnings import StabilityWarning
from .boundaries import extrapolated

Velocity = Sequence[ArrayLike] | ArrayLike | Callable[[float], Sequence[ArrayLike] | ArrayLike]
Rate = Callable[[FloatArray, float], FloatArray]
Callback = Callable[[float, FloatArray], Any]

_RIM = 12  # nodes until a cubic spline has forgotten its end: each divides the error by 3.7


@scheme(stages=1, width=1, cfl=1.0)
def upwind(
    phi: FloatArray, dx: float, axis: int, *, boundary: Boundary = extrapolated
) -> tuple[FloatArray, FloatArray]:
    """Return the backward and the forward difference, D- phi and D+ phi: one line per interval.

    Parameters
    ----------
    phi : ndarray of any shape
        Values at the nodes.
    dx : float, length
        The spacing along the axis.
    axis : int
        Along which axis.
    boundary : padding function
        What lies beyond the last nodes; see `distmesh_edu.boundaries`.

    Returns
    -------
    minus, plus : ndarray of phi's shape
        The derivatives from the left and from the right, phi per length; of first order.

    Notes
    -----
    Thesis equations (3.5) and (3.6). Stable with forward Euler up to a CFL number of 1.

    Examples
    --------
    >>> minus, plus = upwind(np.array([0.0, 1.0, 4.0]), 0.5, 0)
    >>> minus, plus
    (array([2., 2., 6.]), array([2., 6., 6.]))
    """
    at = along(axis)
    slope = np.diff(boundary(phi, 1, axis), axis=axis) / dx
    return slope[at(0, -1)], slope[at(1)]


def time_step_limit(velocity: Velocity, dx: float | Sequence[float]) -> float:
    """Return the time step at which the CFL number is one, 1 / max(|u| / dx + |v| / dy + ...).

    Parameters
    ----------
    velocity : sequence of array_like, length / time
        Its components (u, v, w), as many as the space has dimensions: numbers or arrays. On a
        line, one number needs no brackets.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.

    Returns
    -------
    float, time
        In a longer step something would travel further than the scheme looks. Infinite where
        nothing moves.

    Raises
    ------
    ValueError, TypeError
        If the components do not fit each other or `dx`, or are not finite numbers.

    Notes
    -----
    Thesis equation (3.9). Its (3.10), with the largest |V| over the smallest spacing, allows steps
    longer by a factor of up to the root of the dimension, and these are unstable (erratum E3.6b).

    Examples
    --------
    >>> time_step_limit((3.0, -5.0), 0.5)
    0.0625
    """
    components = [as_numbers(f"velocity[{k}]", one) for k, one in enumerate(_parts(velocity))]
    shapes = {one.shape for one in components} - {()}
    if len(components) > 3 or len(shapes) > 1:
        found = (
            f"{len(components)} of them" if len(components) > 3 else f"the shapes {sorted(shapes)}"
        )
        raise ValueError(
            "velocity must have one to three components, numbers or arrays of one shape; got "
            f"{found}. On a line, put its one component in brackets: [u]."
        )
    return _limit(components, as_spacing(dx, len(components)))


def convection_rate(
    phi: ArrayLike,
    velocity: Velocity,
    dx: float | Sequence[float],
    *,
    differences: Differences = upwind,
    boundary: Boundary = extrapolated,
) -> FloatArray:
    """Return phi_t = -V . grad phi, each derivative taken from the side the flow comes from.

    Parameters
    ----------
    phi : array_like of one to three axes
        Values at the nodes.
    velocity : sequence of array_like, length / time
        One component for each axis: numbers, or arrays of phi's shape.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.
    differences : scheme
        `upwind`, `eno2`, `eno3`, `weno5`, or a function of yours with their signature.
    boundary : padding function
        What lies beyond the last nodes.

    Returns
    -------
    ndarray of phi's shape, phi per time

    Raises
    ------
    ValueError, TypeError
        If the velocity or dx does not fit phi, or something is not finite.

    Examples
    --------
    >>> convection_rate([0.0, 1.0, 4.0], 2.0, 0.5)
    array([ -4.,  -4., -12.])
    """
    values = as_values("phi", phi)
    steps = as_spacing(dx, values.ndim)
    as_boundary(boundary)
    components = _components(velocity, values.shape)
    runge_kutta_order(differences)
    return _rate(values, components, steps, differences, boundary)


def runge_kutta_step(phi: FloatArray, rate: Rate, t: float, dt: float, stages: int) -> FloatArray:
    """Return phi one time step later, by one, two or three forward Euler steps and their means.

    Parameters
    ----------
    phi : ndarray
        The values at time t.
    rate : callable
        Takes phi and a time, returns phi_t, a new array.
    t : float, time
        When the step begins.
    dt : float, time
        How long it is.
    stages : {1, 2, 3}
        1 is forward Euler; 2 and 3 are the TVD Runge-Kutta methods of that order.

    Returns
    -------
    ndarray
        The values at time t + dt.

    Raises
    ------
    ValueError
        If `stages` is not 1, 2 or 3.

    Notes
    -----
    Shu and Osher [ShuOsher1988]_: every stage is a mean of Euler steps, with positive weights. What
    an Euler step does not enlarge, the total variation say, the means do not enlarge either.

    Examples
    --------
    >>> decay = lambda phi, t: -phi
    >>> runge_kutta_step(np.array([1.0]), decay, 0.0, 0.1, 3).round(6)
    array([0.904833])
    """

    def euler(phi: FloatArray, t: float) -> FloatArray:
        return phi + dt * rate(phi, t)

    if stages == 1:
        return euler(phi, t)
    if stages == 2:
        return (phi + euler(euler(phi, t), t + dt)) / 2
    if stages == 3:
        halfway = (3 * phi + euler(euler(phi, t), t + dt)) / 4
        return (phi + 2 * euler(halfway, t + dt / 2)) / 3
    raise ValueError(f"stages must be 1, 2 or 3; got {stages!r}.")


def advect(
    phi: ArrayLike,
    velocity: Velocity,
    dx: float | Sequence[float],
    time: float,
    *,
    differences: Differences = upwind,
    boundary: Boundary = extrapolated,
    cfl: float = 0.5,
    stages: int | None = None,
    callback: Callback | None = None,
) -> FloatArray:
    """Return phi carried along by a velocity for some time: phi_t + V . grad phi = 0.

    Parameters
    ----------
    phi : array_like of one to three axes
        Values at the nodes.
    velocity : sequence of array_like, or callable, length / time
        One component for each axis: numbers, or arrays of phi's shape. A function of the time
        that returns them if they change. On a line, the one component needs no brackets.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.
    time : float, time
        How long.
    differences : scheme
        `upwind`, `eno2`, `eno3`, `weno5`, or a function of yours with their signature.
    boundary : padding function
        What lies beyond the last nodes: `extrapolated`, `neumann`, `periodic`, or yours.
    cfl : float, dimensionless
        The largest CFL number of a step, dt max(|u| / dx + |v| / dy + ...): at most what the
        scheme bears, 1 for `upwind` and `weno5`, 0.9 for `eno2` and `eno3`.
    stages : {1, 2, 3}, optional
        The order of the TVD Runge-Kutta method; the one that goes with the scheme if None.
    callback : callable, optional
        Called as callback(t, phi) after each step.

    Returns
    -------
    ndarray of phi's shape
        The values at the end. The steps are equal while the velocity does not change.

    Raises
    ------
    ValueError, TypeError
        If the velocity or dx does not fit phi, something is not finite, `cfl` is more than the
        scheme bears, or `differences` is no scheme.

    Warns
    -----
    StabilityWarning
        If `stages` is less than what goes with the scheme.

    Notes
    -----
    Thesis sections 3.2 to 3.7 [OsherSethian1988]_. At an end where the flow comes in, phi is made
    up by `boundary`: keep your interface away from there, or make it periodic.

    Examples
    --------
    >>> x = np.linspace(0.0, 1.0, 11)
    >>> advect(x - 0.25, 1.0, 0.1, 0.5).round(6)[:3]
    array([-0.75, -0.65, -0.55])
    """
    values = as_values("phi", phi)
    steps = as_spacing(dx, values.ndim)
    as_boundary(boundary)
    order = runge_kutta_order(differences, stages)
    largest = as_cfl(cfl, differences)

    def flow(t: float) -> list[FloatArray]:
        return _components(velocity(t) if callable(velocity) else velocity, values.shape)

    start = flow(0.0)
    first_limit = largest * _limit(start, steps)

    def rate(phi: FloatArray, t: float) -> FloatArray:
        now = flow(t) if callable(velocity) else start
        return _rate(phi, now, steps, differences, boundary)

    def limit(t: float) -> float:
        return largest * _limit(flow(t), steps) if callable(velocity) else first_limit

    def step(phi: FloatArray, t: float, dt: float) -> FloatArray:
        return runge_kutta_step(phi, rate, t, dt, order)

    return march(values, step, time, limit, callback)


def advect_semi_lagrangian(
    phi: ArrayLike,
    velocity: Velocity,
    dx: float | Sequence[float],
    time: float,
    *,
    boundary: Boundary = extrapolated,
    cfl: float = 4.0,
    callback: Callback | None = None,
) -> FloatArray:
    """Return phi carried along by a velocity, each node fetching the value that comes to it.

    Parameters
    ----------
    phi : array_like of one to three axes, with four nodes at least along each
        Values at the nodes.
    velocity : sequence of array_like, or callable, length / time
        One component for each axis: numbers, or arrays of phi's shape. A function of the time
        that returns them if they change. On a line, the one component needs no brackets.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.
    time : float, time
        How long.
    boundary : padding function
        What lies beyond the last nodes: `extrapolated`, `neumann`, `periodic`, or yours.
    cfl : float, dimensionless
        The largest CFL number of a step. No stability limits it: few long steps lose less by
        interpolation, many short ones follow curved paths better.
    callback : callable, optional
        Called as callback(t, phi) after each step.

    Returns
    -------
    ndarray of phi's shape
        The values at the end.

    Raises
    ------
    ValueError, TypeError
        If the velocity or dx does not fit phi, or something is not finite.

    Notes
    -----
    Along a path dx/dt = V the value of phi stays the same. Each step goes back along the path from
    every node, by the midpoint rule with the velocity in the middle of the step, and interpolates
    phi by a cubic spline where it arrives [StaniforthCote1991]_.

    Examples
    --------
    >>> x = np.linspace(0.0, 1.0, 11)
    >>> advect_semi_lagrangian(x - 0.25, 1.0, 0.1, 0.5).round(6)[:3]
    array([-0.75, -0.65, -0.55])
    """
    values = as_values("phi", phi, least=4)
    steps = as_spacing(dx, values.ndim)
    as_boundary(boundary)
    largest = as_positive("cfl", cfl)
    nodes = np.indices(values.shape, dtype=np.float64)

    def cells_per_time(t: float) -> FloatArray:
        flow = _components(velocity(t) if callable(velocity) else velocity, values.shape)
        return np.stack([u / h for u, h in zip(flow, steps, strict=True)])

    def limit(t: float) -> float:
        return largest * _limit(cells_per_time(t), (1.0,) * values.ndim)

    def step(phi: FloatArray, t: float, dt: float) -> FloatArray:
        speed = cells_per_time(t + dt / 2)
        reach = int(np.ceil(dt * np.abs(speed).max())) + 1
        halfway = nodes - dt / 2 * speed
        passing = [_sampled(one, halfway, reach, boundary, degree=1) for one in speed]
        return _sampled(phi, nodes - dt * np.stack(passing), reach, boundary, degree=3)

    return march(values, step, time, limit, callback)


def march(
    phi: FloatArray,
    step: Callable[[FloatArray, float, float], FloatArray],
    time: float,
    limit: Callable[[float], float],
    callback: Callback | None = None,
) -> FloatArray:
    """Return phi after some time, in equal steps no longer than allowed.

    Parameters
    ----------
    phi : ndarray
        The values at time zero.
    step : callable
        Takes phi, a time and the length of a step, returns phi at its end, a new array.
    time : float, time
        How long; zero or more.
    limit : callable
        Takes a time, returns the longest step allowed then.
    callback : callable, optional
        Called as callback(t, phi) after each step, with an array that cannot be written to.

    Returns
    -------
    ndarray
        The values at the end.

    Examples
    --------
    >>> march(np.ones(1), lambda phi, t, dt: phi - dt * phi, 1.0, lambda t: 0.5)
    array([0.25])
    """
    now, end = 0.0, as_time(time)
    while now < end:
        dt = next_step(now, end, limit)
        phi = step(phi, now, dt)
        now = end if dt >= end - now else now + dt
        if callback is not None:
            callback(now, read_only(phi))
    return phi


def read_only(phi: FloatArray) -> FloatArray:
    """Return a view of an array through which it cannot be changed.

    Parameters
    ----------
    phi : ndarray

    Returns
    -------
    ndarray

    Examples
    --------
    >>> read_only(np.zeros(2)).flags.writeable
    False
    """
    view = phi.view()
    view.flags.writeable = False
    return view


def next_step(now: float, end: float, limit: Callable[[float], float]) -> float:
    """Return the longest step that divides the time left and that the limits along it allow.

    Parameters
    ----------
    now, end : float, time
    limit : callable
        Takes a time, returns the longest step allowed then. It is asked now, at the middle and at
        the end of the step, where the Runge-Kutta stages are, and at one time more.

    Returns
    -------
    float, time

    Examples
    --------
    >>> next_step(0.0, 1.0, lambda t: 0.3)
    0.25
    """
    dt = _equal_step(end - now, limit(now))
    while True:
        # A flow that stands still now may race a moment later. One that swings may stand still at
        # both ends and in the middle of a long step, hence the 0.38.
        later = min(limit(now + share * dt) for share in (0.38, 0.5, 1))
        if dt <= later * (1 + 1e-9):
            return dt
        dt = _equal_step(end - now, later)


def _equal_step(time: float, limit: float) -> float:
    # Rounding must not turn the hundred steps of a time that a hundred divide into 101.
    return time / max(1, int(np.ceil(time / limit - 1e-9)))


def runge_kutta_order(differences: Differences, stages: int | None = None) -> int:
    """Return the order of the Runge-Kutta method to take with a scheme, and warn of a bad pair.

    Parameters
    ----------
    differences : scheme
        A function with the signature of `upwind`; one of yours need not say its `stages`.
    stages : {1, 2, 3}, optional
        What the caller asks for; the scheme's own if None.

    Returns
    -------
    int

    Raises
    ------
    TypeError, ValueError
        If `differences` is no scheme, or `stages` no order.

    Warns
    -----
    StabilityWarning
        If less is asked for than the scheme needs.

    Examples
    --------
    >>> runge_kutta_order(upwind)
    1
    """
    if not callable(differences):
        raise TypeError(
            "differences must be a scheme, the function upwind, eno2, eno3 or weno5 itself, or one "
            f"with their signature; got {differences!r}."
        )
    needed = getattr(differences, "stages", 1)
    if stages is None:
        return int(needed)
    if stages not in (1, 2, 3):
        raise ValueError(f"stages must be 1, 2 or 3; got {stages!r}.")
    if stages < needed:
        name = getattr(differences, "__name__", "this scheme")
        warnings.warn(
            f"{name} with stages={stages} is unstable: small waves grow from step to step, until "
            f"they are as large as what they ride on. Take stages={needed}, or leave it out.",
            StabilityWarning,
            stacklevel=3,
        )
    return stages


def _rate(
    phi: FloatArray,
    velocity: list[FloatArray],
    dx: Sequence[float],
    differences: Differences,
    boundary: Boundary,
) -> FloatArray:
    """Return -V . grad phi, upwind; see `convection_rate`."""

    def rate(phi: FloatArray, boundary: Boundary, *velocity: FloatArray) -> FloatArray:
        total = np.zeros_like(phi)
        for axis, (u, h) in enumerate(zip(velocity, dx, strict=True)):
            minus, plus = differences(phi, h, axis, boundary=boundary)
            total -= u * np.where(u > 0, minus, plus)
        return total

    return in_slabs(rate, phi, boundary, getattr(differences, "width", None), *velocity)


def _limit(velocity: Iterable[FloatArray], dx: Sequence[float]) -> float:
    fastest = np.max(sum(np.abs(u) / h for u, h in zip(velocity, dx, strict=True)))
    return 1 / float(fastest) if fastest else np.inf


def _parts(velocity: Any) -> list[Any]:
    """Return the components of a velocity, as they were given; a number is the one component."""
    if callable(velocity):
        raise TypeError(
            f"velocity must be numbers or arrays here; got the function {velocity!r}. Call it with "
            "a time first: velocity(t)."
        )
    try:
        return list(velocity)
    except TypeError:
        return [velocity]


def _components(velocity: Any, shape: tuple[int, ...]) -> list[FloatArray]:
    """Return a velocity as one array of the given shape for each axis."""
    dim = len(shape)
    parts = _parts(velocity)
    if dim == 1 and len(parts) == shape[0]:  # its values, without brackets
        parts = [velocity]
    if len(parts) != dim:
        shaped = isinstance(velocity, np.ndarray) and velocity.ndim
        found = f"the shape {velocity.shape}" if shaped else f"{len(parts)} of them"
        raise ValueError(
            f"velocity must have one component for each of the {dim} axes of phi, {'uvw'[:dim]}; "
            f"got {found}. Turn points of shape (..., {dim}) with np.moveaxis(velocity, -1, 0)."
        )
    components = []
    for k, one in enumerate(parts):
        values = as_numbers(f"velocity[{k}]", one)
        if values.shape not in ((), shape):
            raise ValueError(
                f"velocity[{k}] must be a number or have phi's shape {shape}; got {values.shape}."
            )
        components.append(np.broadcast_to(values, shape))
    return components


def _sampled(
    values: FloatArray, places: FloatArray, reach: int, boundary: Boundary, degree: int
) -> FloatArray:
    """Interpolate values at places given in cells, up to `reach` cells beyond the last nodes."""
    rim = reach + (_RIM if degree > 1 else 1)
    for axis in range(values.ndim):
        values = boundary(values, rim, axis)
    return np.asarray(ndimage.map_coordinates(values, places + rim, order=degree, mode="nearest"))
