"""Redistancing by closest points: a signed distance at every node, to the zero set of a spline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from ._indexing import along
from ._slabs import slabs
from ._spline import CubicSpline
from ._types import ArrayLike, BoolArray, FloatArray, IntArray
from ._validation import as_level_set, as_spacing, as_values
from .reinitialization import next_to_interface

_KINK = 0.75  # at a kink, second differences leap by the slope's size; here, by most of it
_REACH = 2  # how many cells away a kink still makes a spline swing
_FORGOTTEN = 14  # nodes until a cubic spline has forgotten its end: each divides that by 3.7
_TREE_BAND = 3.5  # cells about the interface whose closest points are looked up one by one
_PARTING = 0.5  # how far apart, per distance, neighbours' closest points lie on a medial axis


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
    ValueError, TypeError
        If phi is not finite, has no interface or too few nodes, or dx does not fit it.

    Notes
    -----
    The zero set is that of the cubic spline through phi: the nodes next to it walk down to it by
    Newton's method and leave a point each, with the normal and the curvatures of the spline. From
    the closest such point, at the height m along the normal and tau beside it, the distance is
    m + tau.H tau / 2, with the Hessian of a distance at that height, H = K (I + m K)**-1: of
    third order, since the points lie a cell apart. Where the data are kinked within a cell (a
    corner, a feature thinner than two cells) straight lines between neighbouring nodes replace
    the spline, which would swing; outside a corner that may be off by up to a cell. Spacings
    that differ by more than a factor of two or so cost accuracy, too.

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
    first, last = node.min(axis=1), node.max(axis=1)  # of the box about the interface
    corner = np.maximum(first - _FORGOTTEN, 0)
    box = tuple(slice(a, b + _FORGOTTEN + 1) for a, b in zip(corner, last, strict=True))
    spline = CubicSpline(phi[box])
    place = node * h
    for _ in range(5):  # Newton squares the error, which begins at a tenth of a cell or so
        value, gradient = spline(place / h - corner[:, None], order=1)
        gradient = gradient / h
        step = value * gradient / np.maximum((gradient**2).sum(axis=0), 1e-300)
        place = np.clip(place - step, (node - 1.5) * h, (node + 1.5) * h)
        if np.abs(step / h).max() < 1e-6:
            break
    value, gradient, hessian = spline(place / h - corner[:, None], order=2)
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
