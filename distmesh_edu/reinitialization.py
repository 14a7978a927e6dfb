"""Signed distances from any implicit function: by an equation, and by closest points."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from ._indexing import along
from ._slabs import slabs
from ._spline import CubicSpline
from ._types import ArrayLike, BoolArray, Boundary, Differences, FloatArray, IntArray
from ._validation import as_boundary, as_cfl, as_level_set, as_positive, as_spacing, as_values
from ._warnings import ConvergenceWarning
from .boundaries import extrapolated, neumann
from .convection import Callback, Rate, runge_kutta_order, runge_kutta_step
from .eno import eno2
from .normal_motion import upwind_norm

_KINK = 0.75  # at a kink, second differences leap by the slope's size; here, by most of it
_REACH = 2  # how many cells away a kink still makes a spline swing
_TREE_BAND = 3.5  # cells about the interface whose closest points are looked up one by one
_PARTING = 0.5  # how far apart, per distance, neighbours' closest points lie on a medial axis


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
        Negative where phi is. Where the distances have not arrived, phi is still what it was.

    Raises
    ------
    ValueError, TypeError
        If phi is not finite, has no interface or too few nodes, dx does not fit it, `cfl` is too
        large, or `differences` is no scheme.

    Warns
    -----
    ConvergenceWarning
        Without a band: if phi still moves after the time in which distances cross the box.
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
    values, rate = _equation(values, steps, differences, boundary, subcell)
    inside = values < 0
    far = float(np.linalg.norm(np.multiply(steps, values.shape)))
    # Schemes blur the front behind which phi is a distance over some cells.
    time = 2 * far if band is None else as_positive("band", band) + 5 * max(steps)
    settled = as_positive("tolerance", tolerance) * dt if band is None else 0.0
    for step in range(1, int(np.ceil(time / dt)) + 1):
        before, values = values, runge_kutta_step(values, rate, 0.0, dt, order)
        if subcell:  # a cliff next to the interface may overshoot: back to where it came from
            crossed = (values < 0) != inside
            values[crossed] = np.where(inside[crossed], -min(steps) / 2, min(steps) / 2)
        if callback is not None:
            callback(step * dt, values)
        if settled and np.abs(values - before).max() <= settled:
            break
    else:
        if band is None:
            warnings.warn(
                _still_moving(values - before, dt, step), ConvergenceWarning, stacklevel=2
            )
    return values


def redistance(phi: ArrayLike, dx: float | Sequence[float]) -> FloatArray:
    """Return the signed distance to the zero set of phi, from the closest points of its spline.

    Parameters
    ----------
    phi : array_like of one to three axes, with four nodes at least along each
        Values at the nodes; they need not be distances. Only the zero set and the signs count.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.

    Returns
    -------
    ndarray of phi's shape, length
        Negative where phi is. No node changes sides.

    Raises
    ------
    ValueError
        If phi is not finite, has no interface or too few nodes, or dx does not fit it.

    Notes
    -----
    The zero set is that of the cubic spline through phi: the nodes next to it walk down to it by
    Newton's method and leave a point each, with the normal and the curvatures of the spline. From
    the closest such point, at the height m along the normal and tau beside it, the distance is
    m + tau.H tau / 2, with the Hessian of a distance at that height, H = K (I + m K)**-1: of
    third order, since the points lie a cell apart. Where the data are kinked within a cell (a
    corner, a feature thinner than two cells) straight lines between neighbouring nodes replace
    the spline, which would swing.

    The closest of the points is found by a k-d tree near the interface and near the medial axis,
    where it matters, and elsewhere by a distance transform.

    Examples
    --------
    >>> x = np.linspace(-2.0, 2.0, 9)
    >>> redistance(x**3 - 1, 0.5).round(6)
    array([-3. , -2.5, -2. , -1.5, -1. , -0.5,  0. ,  0.5,  1. ])
    """
    values = as_level_set(as_values("phi", phi, least=4))
    steps = np.array(as_spacing(dx, values.ndim))
    seeds = _seeds(values, steps)
    nearest = _nearest_seed(seeds, values.shape, steps)
    distance = _distance(seeds, nearest, steps)
    return np.where(values < 0, -distance, distance)


def subcell_distance(
    phi: ArrayLike, dx: float | Sequence[float], *, differences: Differences = eno2
) -> FloatArray:
    """Return phi / |grad phi|, the distance to the interface, good to second order next to it.

    Parameters
    ----------
    phi : array_like of one to three axes
        Values at the nodes.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.
    differences : scheme
        What takes the slopes.

    Returns
    -------
    ndarray of phi's shape, length

    Notes
    -----
    Along each axis the steeper of the slopes from the left and from the right counts: at a node in
    the middle of a thin feature both are steep, and their mean is zero.

    Examples
    --------
    >>> subcell_distance([-3.0, -1.0, 1.0, 3.0], 0.5)
    array([-0.75, -0.25,  0.25,  0.75])
    """
    values = as_values("phi", phi, least=3)
    squares = np.zeros_like(values)
    for axis, h in enumerate(as_spacing(dx, values.ndim)):
        minus, plus = differences(values, h, axis, boundary=extrapolated)
        squares += np.maximum(np.abs(minus), np.abs(plus)) ** 2
    return values / np.sqrt(np.maximum(squares, 1e-300))


def smeared_sign(phi: ArrayLike, dx: float | Sequence[float]) -> FloatArray:
    """Return phi / sqrt(phi**2 + |grad phi|**2 dx**2): the sign, smeared over a cell.

    Parameters
    ----------
    phi : array_like of one to three axes
        Values at the nodes.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.

    Returns
    -------
    ndarray of phi's shape, dimensionless
        About 1 far outside, -1 far inside, 0 on the interface; the same for phi and 100 phi.

    Examples
    --------
    >>> smeared_sign([-100.0, 0.0, 100.0], 1.0).round(3)
    array([-0.707,  0.   ,  0.707])
    """
    values = as_values("phi", phi, least=3)
    steps = as_spacing(dx, values.ndim)
    slopes = [np.gradient(values, h, axis=axis) for axis, h in enumerate(steps)]
    rise = np.sqrt(sum(slope**2 for slope in slopes)) * max(steps)
    return values / np.maximum(np.hypot(values, rise), 1e-300)


def next_to_interface(phi: FloatArray) -> BoolArray:
    """Say which nodes lie on the interface or have a neighbour on its other side.

    Parameters
    ----------
    phi : ndarray of any shape
        Values at the nodes.

    Returns
    -------
    ndarray of bool, of phi's shape

    Examples
    --------
    >>> next_to_interface(np.array([-2.0, -1.0, 1.0, 2.0]))
    array([False,  True,  True, False])
    """
    side = np.sign(phi)
    near = side == 0
    for axis in range(phi.ndim):
        at = along(axis)
        changes = side[at(0, -1)] * side[at(1)] < 0
        near[at(0, -1)] |= changes
        near[at(1)] |= changes
    return np.asarray(near)


def _equation(
    phi: FloatArray,
    dx: Sequence[float],
    differences: Differences,
    boundary: Boundary,
    subcell: bool,
) -> tuple[FloatArray, Rate]:
    """Return the values to begin with, and phi_t as a function of phi."""
    near = next_to_interface(phi) & subcell
    within_a_cell = np.clip(subcell_distance(phi, dx), -max(dx), max(dx))
    held = np.where(near, 0, np.sign(phi))

    def rate(phi: FloatArray, _: float) -> FloatArray:
        speed = held if subcell else smeared_sign(phi, dx)
        return speed * (1 - upwind_norm(phi, np.sign(speed), dx, differences, boundary))

    return np.where(near, within_a_cell, phi), rate


def _still_moving(change: FloatArray, dt: float, steps: int) -> str:
    where = np.unravel_index(int(np.abs(change).argmax()), change.shape)
    return (
        f"phi still moves after {steps} steps: its rate is {np.abs(change).max() / dt:.2g} at node "
        f"{tuple(int(i) for i in where)}. Give a band, or a larger tolerance; or use redistance."
    )


@dataclass(frozen=True)
class _Seeds:
    """Points of the interface, one for each node next to it; arrays of shape (..., n)."""

    node: IntArray  # (dim, n), in cells from the first node
    place: FloatArray  # (dim, n), length
    normal: FloatArray  # (dim, n)
    bend: FloatArray  # (dim, dim, n), the Hessian over the slope: curvatures, for tangents


def _seeds(phi: FloatArray, dx: FloatArray) -> _Seeds:
    """Walk from the nodes next to the interface down to the zero set of the spline."""
    near = next_to_interface(phi)
    node = np.array(np.nonzero(near))
    h = dx[:, None]
    # Squares of very large or small values would overflow.
    phi = phi / (np.abs(phi[near]).max() or np.abs(phi).max())
    spline = CubicSpline(phi)
    place = node * h
    for _ in range(5):  # Newton squares the error, which begins at a tenth of a cell or so
        value, gradient = spline(place / h, order=1)
        gradient = gradient / h
        step = value * gradient / np.maximum((gradient**2).sum(axis=0), 1e-300)
        place = np.clip(place - step, (node - 1.5) * h, (node + 1.5) * h)
        if np.abs(step / h).max() < 1e-6:
            break
    value, gradient, hessian = spline(place / h, order=2)
    gradient = gradient / h
    slope = np.maximum(np.sqrt((gradient**2).sum(axis=0)), 1e-300)
    seeds = _Seeds(node, place, gradient / slope, hessian / h / dx[:, None, None] / slope)
    arrived = np.abs(value) <= 1e-6 * slope * dx.min()
    close = ((place - node * h) ** 2).sum(axis=0) <= (1.01 * dx.max()) ** 2
    # A radius of curvature below half a cell, or no direction at all, is no surface to trust.
    sharp = np.abs(seeds.bend).max(axis=(0, 1)) * dx.max() > 2
    _straighten(seeds, ~arrived | ~close | sharp | _kinked(phi, node), phi, dx)
    return seeds


def _kinked(phi: FloatArray, node: IntArray) -> BoolArray:
    """Say at which nodes phi has a kink within two cells: its bend swings by about its slope."""
    kinked = np.zeros(node.shape[1], dtype=np.bool_)
    for axis, count in enumerate(phi.shape):
        line, values = list(node), []
        for offset in range(-_REACH - 1, _REACH + 2):
            line[axis] = np.clip(node[axis] + offset, 0, count - 1)
            beyond = line[axis] != node[axis] + offset
            values.append(np.where(beyond, np.nan, phi[tuple(line)]))
        slope = np.diff(values, axis=0)
        bend = np.diff(slope, axis=0)
        swing = np.fmax.reduce(bend) - np.fmin.reduce(bend)
        kinked |= swing > _KINK * np.fmax.reduce(np.abs(slope))
    return np.asarray(kinked)


def _beside(phi: FloatArray, node: IntArray, axis: int) -> list[tuple[int, FloatArray]]:
    """Return the values before and after some nodes along an axis, NaN beyond the rim."""
    found = []
    for side in (-1, 1):
        other = node.copy()
        other[axis] += side
        beyond = (other[axis] < 0) | (other[axis] == phi.shape[axis])
        other[axis, beyond] = 0
        found.append((side, np.where(beyond, np.nan, phi[tuple(other)])))
    return found


def _straighten(seeds: _Seeds, which: BoolArray, phi: FloatArray, dx: FloatArray) -> None:
    """Put the plane through the crossings on the grid lines in place of the spline."""
    seeds.bend[..., which] = 0
    # A node on the interface is its own closest point; about a kink, one without a direction.
    at_zero = which & (phi[tuple(seeds.node)] == 0)
    seeds.place[:, at_zero] = seeds.node[:, at_zero] * dx[:, None]
    seeds.normal[:, at_zero] = np.nan
    which = which & ~at_zero
    node = seeds.node[:, which]
    here = phi[tuple(node)]
    steepness = np.zeros(node.shape)  # one over the signed way to the crossing along each axis
    for axis, h in enumerate(dx):
        for side, there in _beside(phi, node, axis):
            crosses = np.sign(here) != np.sign(there)
            share = np.where(crosses & np.isfinite(there), (here - there) / here / h, 0)
            closer = share > np.abs(steepness[axis])
            steepness[axis, closer] = side * share[closer]
    size = np.sqrt((steepness**2).sum(axis=0))
    outward = steepness / size * np.where(here < 0, 1, -1)
    seeds.place[:, which] = node * dx[:, None] + steepness / size**2
    seeds.normal[:, which] = outward


def _nearest_seed(seeds: _Seeds, shape: tuple[int, ...], dx: FloatArray) -> IntArray:
    """Return the number of the seed closest to each node, or, far away, of one hardly farther."""
    off = ((seeds.place - seeds.node * dx[:, None]) ** 2).sum(axis=0)
    close = np.flatnonzero(off <= (0.5001 * dx.max()) ** 2)  # one of the two at each crossing is
    number = np.zeros(shape, dtype=np.intp)
    number[tuple(seeds.node[:, close])] = close
    elsewhere = np.ones(shape, dtype=np.bool_)
    elsewhere[tuple(seeds.node[:, close])] = False
    distance, node = ndimage.distance_transform_edt(elsewhere, sampling=dx, return_indices=True)
    nearest: IntArray = number[tuple(node)]
    unsure = (distance <= _TREE_BAND * dx.max()) | _next_to_medial_axis(node, distance, dx)
    places = np.stack([dx[k] * i for k, i in enumerate(np.nonzero(unsure))], axis=1)
    nearest[unsure] = cKDTree(seeds.place.T).query(places)[1]
    return nearest


def _next_to_medial_axis(node: IntArray, distance: FloatArray, dx: FloatArray) -> BoolArray:
    """Say where two neighbours' closest nodes of the interface lie far apart, and next to that."""
    found = np.zeros(distance.shape, dtype=np.bool_)
    for axis in range(distance.ndim):
        at = along(axis)
        apart = sum((h * np.diff(where, axis=axis)) ** 2 for h, where in zip(dx, node, strict=True))
        parting = apart > (3 * dx.max() + _PARTING * distance[at(1)]) ** 2
        found[at(0, -1)] |= parting
        found[at(1)] |= parting
    return np.asarray(ndimage.binary_dilation(found))


def _distance(seeds: _Seeds, nearest: IntArray, dx: FloatArray) -> FloatArray:
    """Return the distance from each node to the quadric about its seed."""
    trace = np.trace(seeds.bend)
    along_normal = np.einsum("ijn,jn->in", seeds.bend, seeds.normal)
    twice = (along_normal * seeds.normal).sum(axis=0)
    # Sum and product of the principal curvatures: of the bend less what it has along the normal.
    mean = trace - twice
    square = (seeds.bend**2).sum(axis=(0, 1)) - 2 * (along_normal**2).sum(axis=0) + twice**2
    product = (mean**2 - square) / 2
    axes = [h * np.arange(n) for h, n in zip(dx, nearest.shape, strict=True)]
    out = np.empty(nearest.shape)
    for rows in slabs(nearest.shape):
        x = [axes[0][rows], *axes[1:]]
        out[rows] = _distance_from_quadric(seeds, mean, product, nearest[rows], x, dx.max())
    return out


def _distance_from_quadric(
    seeds: _Seeds,
    mean: FloatArray,
    product: FloatArray,
    nearest: IntArray,
    axes: Sequence[FloatArray],
    cell: float,
) -> FloatArray:
    """Return the distance from each node of a box to the quadric about the seed it is given."""
    x = np.meshgrid(*axes, indexing="ij", sparse=True)
    way = [a - place[nearest] for a, place in zip(x, seeds.place, strict=True)]
    normal = [part[nearest] for part in seeds.normal]
    m = sum(w * n for w, n in zip(way, normal, strict=True))
    tau = [w - m * n for w, n in zip(way, normal, strict=True)]
    beside = sum(t * t for t in tau)
    kappa, gauss = mean[nearest], product[nearest]
    if len(axes) < 3:  # one curvature, and one direction beside the normal
        bent = kappa * beside
        gauss = np.zeros(())
    else:
        bent = sum(
            (1 if i == j else 2) * tau[i] * tau[j] * seeds.bend[i, j][nearest]
            for i in range(3)
            for j in range(i + 1)
        )
    # tau.H tau with H = K (I + m K)**-1, for K with this trace and determinant
    denominator = 1 + m * kappa + m * m * gauss
    focused = denominator < 0.1  # beyond the centre of curvature the quadric means nothing
    d = np.abs(m + (bent + m * gauss * beside) / 2 / np.where(focused, np.inf, denominator))
    straight = np.sqrt(sum(w * w for w in way))
    # Which seed is closest is known to within a cell; what is NaN is a point without a direction.
    fits = (d > 0) & (d <= straight) & (d > straight - cell)
    return np.asarray(np.where(fits, d, straight))
