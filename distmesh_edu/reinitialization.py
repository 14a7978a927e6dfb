"""Reinitialization: an equation that turns any implicit function into a signed distance."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence

import numpy as np
from scipy import ndimage

from ._indexing import along
from ._nodes import Nodes
from ._slabs import in_slabs
from ._types import ArrayLike, BoolArray, Boundary, Differences, FloatArray
from ._validation import (
    as_boundary,
    as_cfl,
    as_level_set,
    as_positive,
    as_spacing,
    as_values,
)
from ._warnings import ConvergenceWarning
from .boundaries import extrapolated, neumann, periodic
from .convection import Callback, Rate, read_only, runge_kutta_order, runge_kutta_step
from .eno import eno2
from .normal_motion import upwind_norm

_FEW = 0.3  # of all nodes: with more, gathering them costs more than the rest


def reinitialize(
    phi: ArrayLike,
    dx: float | Sequence[float],
    *,
    band: float | None = None,
    differences: Differences = eno2,
    boundary: Boundary = neumann,
    subcell: bool = True,
    cfl: float = 0.5,
    stages: int | None = None,
    tolerance: float = 0.01,
    callback: Callback | None = None,
) -> FloatArray:
    """Return phi evolved by phi_t + S(phi0) (|grad phi| - 1) = 0 until it is a signed distance.

    Parameters
    ----------
    phi : array_like of one to three axes, with three nodes at least along each
        Values at the nodes, phi0 in the equation; they need not be distances.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.
    band : float, length, optional
        How far from the interface phi is to be a distance. Distances spread from the interface
        with speed one, so this is how long the equation runs. Everywhere if None: until phi
        stands still.
    differences : scheme
        `upwind`, `eno2`, `eno3`, `weno5`, or a function of yours with their signature.
    boundary : padding function
        What lies beyond the last nodes. With `neumann` nothing comes in from there. Do not take
        `extrapolated`: a slope at the rim that points the wrong way then feeds itself.
    subcell : bool
        Hold the nodes next to the interface to their distance from it, as phi0 has it (Russo and
        Smereka). Without it the sign is smeared over a cell, and the interface moves a little
        with each step.
    cfl : float, dimensionless
        The CFL number of a step, dt sqrt(1 / dx**2 + 1 / dy**2 + ...): at most what the scheme
        bears, 1 for `upwind` and `weno5`, 0.9 for `eno2` and `eno3`.
    stages : {1, 2, 3}, optional
        The order of the TVD Runge-Kutta method; the one that goes with the scheme if None.
    tolerance : float, dimensionless
        Without a band: the largest |phi_t| that counts as standing still.
    callback : callable, optional
        Called as callback(t, phi) after each step.

    Returns
    -------
    ndarray of phi's shape, length
        Negative where phi is, with `subcell`. Beyond the band it is neither phi nor a distance:
        some value between, or phi itself where nothing had to be computed.

    Raises
    ------
    ValueError, TypeError
        If phi is not finite, has no interface or too few nodes, dx does not fit it, `cfl` is too
        large, or `differences` is no scheme.

    Warns
    -----
    ConvergenceWarning
        Without a band: if phi still moves after twice the time in which distances cross the box.
    StabilityWarning
        If `stages` is less than what goes with the scheme.

    Notes
    -----
    Thesis sections 4.6 to 4.8, after Sussman, Smereka and Osher [SussmanSmerekaOsher1994]_. The
    norm is Godunov's. Next to the interface the fix puts phi0 / |grad phi0| and leaves it alone,
    which is where the equation of Russo and Smereka [RussoSmereka2000]_ ends. Without it, S is
    phi / sqrt(phi**2 + |grad phi|**2 dx**2) of the phi of the moment
    [PengMerrimanOsherZhaoKang1999]_, which is the same for phi and 100 phi; the thesis's (4.14)
    lacks the gradient, and destroys what is steep (erratum E4.7a).

    Examples
    --------
    >>> x = np.linspace(-2.0, 2.0, 9)
    >>> reinitialize(5 * x, 0.5).round(2)
    array([-2. , -1.5, -1. , -0.5,  0. ,  0.5,  1. ,  1.5,  2. ])
    """
    values = as_level_set(as_values("phi", phi, least=3))
    steps = as_spacing(dx, values.ndim)
    as_boundary(boundary)
    order = runge_kutta_order(differences, stages)
    dt = as_cfl(cfl, differences) / float(np.linalg.norm(1 / np.array(steps)))
    time, settled = _how_long(values.shape, steps, band, tolerance)
    values, held = _beginning(values, steps, boundary, subcell)
    rate, nodes = _equation(values, held, steps, differences, boundary, subcell, band)
    active, whole = values.ravel()[nodes.number] if nodes else values, _spread(values, nodes)
    inside = active < 0
    for step in range(1, int(np.ceil(time / dt)) + 1):
        before, active = active, runge_kutta_step(active, rate, 0.0, dt, order)
        if subcell:  # a cliff next to the interface may overshoot: back to where it came from
            crossed = (active < 0) != inside
            active[crossed] = np.where(inside[crossed], -min(steps) / 2, min(steps) / 2)
        if callback is not None:
            callback(step * dt, read_only(whole(active)))
        if settled and np.abs(active - before).max() <= settled * dt:
            break
    else:
        if settled:
            words = _still_moving(active - before, dt, step)
            warnings.warn(words, ConvergenceWarning, stacklevel=2)
    return whole(active)


def subcell_distance(
    phi: ArrayLike,
    dx: float | Sequence[float],
    *,
    differences: Differences = eno2,
    boundary: Boundary = extrapolated,
) -> FloatArray:
    """Return phi / |grad phi|, the distance to the interface, good to second order next to it.

    Parameters
    ----------
    phi : array_like of one to three axes, with three nodes at least along each
        Values at the nodes.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.
    differences : scheme
        What takes the slopes.
    boundary : padding function
        What lies beyond the last nodes.

    Returns
    -------
    ndarray of phi's shape, length

    Raises
    ------
    ValueError, TypeError
        If phi is not finite or has too few nodes, dx does not fit it, or `differences` is no
        scheme.

    Notes
    -----
    Along each axis the steeper of the slopes from the left and from the right counts: at a node in
    the middle of a thin feature both are steep, and their mean is zero.

    Examples
    --------
    >>> subcell_distance([-3.0, -1.0, 1.0, 3.0], 0.5)
    array([-0.75, -0.25,  0.25,  0.75])
    """
    values = _to_scale(as_values("phi", phi, least=3))
    runge_kutta_order(differences)
    as_boundary(boundary)
    squares = np.zeros_like(values)
    for axis, h in enumerate(as_spacing(dx, values.ndim)):
        minus, plus = differences(values, h, axis, boundary=boundary)
        squares += np.maximum(np.abs(minus), np.abs(plus)) ** 2
    return values / np.sqrt(np.maximum(squares, 1e-300))


def smeared_sign(phi: ArrayLike, dx: float | Sequence[float]) -> FloatArray:
    """Return phi / sqrt(phi**2 + |grad phi|**2 dx**2): the sign, smeared over a cell.

    Parameters
    ----------
    phi : array_like of one to three axes, with three nodes at least along each
        Values at the nodes.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.

    Returns
    -------
    ndarray of phi's shape, dimensionless
        About 1 far outside, -1 far inside, 0 on the interface; the same for phi and 100 phi.

    Raises
    ------
    ValueError, TypeError
        If phi is not finite or has too few nodes, or dx does not fit it.

    Examples
    --------
    >>> smeared_sign([-100.0, 0.0, 100.0], 1.0).round(3)
    array([-0.707,  0.   ,  0.707])
    """
    values = _to_scale(as_values("phi", phi, least=3))
    steps = as_spacing(dx, values.ndim)
    slopes = [np.gradient(values, h, axis=axis) for axis, h in enumerate(steps)]
    rise = np.sqrt(sum(slope**2 for slope in slopes)) * max(steps)
    return values / np.maximum(np.hypot(values, rise), 1e-300)


def next_to_interface(phi: FloatArray, boundary: Boundary = neumann) -> BoolArray:
    """Say which nodes lie on the interface or have a neighbour on its other side.

    Parameters
    ----------
    phi : ndarray of any shape
        Values at the nodes.
    boundary : padding function
        What lies beyond the last nodes; `periodic` if the first comes after the last.

    Returns
    -------
    ndarray of bool, of phi's shape

    Examples
    --------
    >>> next_to_interface(np.array([-2.0, -1.0, 1.0, 2.0]))
    array([False,  True,  True, False])
    """
    near = phi == 0
    for axis in range(phi.ndim):
        at = along(axis)
        side = np.sign(boundary(phi, 1, axis))
        changes = side[at(0, -1)] * side[at(1)] < 0
        near |= changes[at(0, -1)] | changes[at(1)]
    return np.asarray(near)


def _to_scale(phi: FloatArray) -> FloatArray:
    """Return phi over its largest size, for squares of very large or small values overflow."""
    return phi / (np.abs(phi).max() or 1.0)


def _how_long(
    shape: tuple[int, ...], dx: Sequence[float], band: float | None, tolerance: float
) -> tuple[float, float]:
    """Return the time to run for, and the largest rate that ends it before, zero for none."""
    still = as_positive("tolerance", tolerance)
    if band is None:
        return 2 * float(np.linalg.norm(np.multiply(dx, shape))), still
    # Schemes blur the front behind which phi is a distance over some cells.
    return as_positive("band", band) + 5 * max(dx), 0.0


def _beginning(
    phi: FloatArray, dx: Sequence[float], boundary: Boundary, subcell: bool
) -> tuple[FloatArray, FloatArray]:
    """Return the values to begin with, and the sign, zero at the nodes that are held."""
    wraps = boundary is periodic
    near = next_to_interface(phi, periodic if wraps else neumann) & subcell
    distance = subcell_distance(phi, dx, boundary=periodic if wraps else extrapolated)
    within_a_cell = np.clip(distance, -max(dx), max(dx))
    return np.where(near, within_a_cell, phi), np.where(near, 0, np.sign(phi))


def _equation(
    phi: FloatArray,
    held: FloatArray,
    dx: Sequence[float],
    differences: Differences,
    boundary: Boundary,
    subcell: bool,
    band: float | None,
) -> tuple[Rate, Nodes | None]:
    """Return phi_t as a function of phi, and the nodes it is taken at, None for all."""
    width = getattr(differences, "width", None)

    def change(phi: FloatArray, boundary: Boundary, speed: FloatArray) -> FloatArray:
        return speed * (1 - upwind_norm(phi, boundary, np.sign(speed), dx, differences))

    def rate(phi: FloatArray, _: float) -> FloatArray:
        speed = held if subcell else smeared_sign(phi, dx)
        return in_slabs(change, phi, boundary, width, speed)

    if band is None or not subcell or width is None or boundary not in (neumann, periodic):
        return rate, None
    nodes = _nodes_in_reach(held, dx, band, width, boundary)
    if nodes is None:
        return rate, None
    flat, speed = phi.ravel().copy(), held.ravel()[nodes.number]

    def rate_there(phi: FloatArray, _: float) -> FloatArray:
        flat[nodes.number] = phi
        return nodes.work(change, flat, speed)

    return rate_there, nodes


def _nodes_in_reach(
    held: FloatArray, dx: Sequence[float], band: float, width: int, boundary: Boundary
) -> Nodes | None:
    """Return the nodes that a distance in the band can hang on; None if none or too many."""
    # What begins further off than this, on its side, is not below the distances in the band.
    reach = max(band + 5 * max(dx), 2 * band) + max(dx)
    wide, middle = held, []
    for axis, (h, n) in enumerate(zip(dx, held.shape, strict=True)):
        beyond = min(int(np.ceil(reach / h)), n)
        wide = boundary(wide, beyond, axis)
        middle.append(slice(beyond, beyond + n))
    away = ndimage.distance_transform_edt(wide, sampling=dx)[tuple(middle)]
    chosen = (away <= reach) & (held != 0)
    return Nodes(chosen, width, boundary) if 0 < chosen.mean() < _FEW else None


def _spread(values: FloatArray, nodes: Nodes | None) -> Callable[[FloatArray], FloatArray]:
    """Return the function that puts what the nodes have become back among the other values."""
    if nodes is None:
        return lambda active: active

    def whole(active: FloatArray) -> FloatArray:
        out = values.ravel().copy()
        out[nodes.number] = active
        return out.reshape(values.shape)

    return whole


def _still_moving(change: FloatArray, dt: float, steps: int) -> str:
    where = np.unravel_index(int(np.abs(change).argmax()), change.shape)
    return (
        f"phi still moves after {steps} steps: its rate is {np.abs(change).max() / dt:.2g} at node "
        f"{tuple(int(i) for i in where)}. Give a band, or a larger tolerance; or use redistance."
    )
