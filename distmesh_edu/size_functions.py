"""Size functions: how large elements are to be, from distances, curvature, features and data.

On a grid a size function is an array, as all values on a grid are. Of several wishes the smallest
counts, `np.minimum(a, b)`; then `limit_gradient`, and `Grid.interpolate` makes a field of it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from ._indexing import along
from ._types import ArrayLike, Field, FloatArray
from ._validation import (
    as_field,
    as_level_set,
    as_numbers,
    as_positive,
    as_spacing,
    as_values,
    evaluate,
)
from .boundaries import extrapolated
from .geometry import curvature, gradient, unit_normal
from .gradient_limiting import limit_gradient
from .grid import Grid
from .redistancing import redistance

_NEAR = 1.5  # cells: the nodes that speak for the boundary's curvature
_KINK = 0.5  # of 2, that of two parallel walls: how far slopes leap on the medial axis, at least


def size_from_distance(d: ArrayLike, smallest: float, grading: float) -> FloatArray:
    """Return smallest + grading |d|: fine at a boundary, growing away from it.

    Parameters
    ----------
    d : array_like of any shape, length
        Distances; their sign does not matter.
    smallest : float, length
        The size where d is zero.
    grading : float, dimensionless
        How fast sizes grow with the distance; zero or more.

    Returns
    -------
    ndarray of d's shape, length

    Raises
    ------
    ValueError, TypeError
        If d is not finite, `smallest` is not positive, or `grading` is negative.

    Notes
    -----
    The slope is `grading` already, as |grad d| = 1: there is nothing to limit. Since d may be any
    array, this is a field as well: ``lambda p: size_from_distance(fd(p), 0.1, 0.3)``.

    Examples
    --------
    >>> size_from_distance([-2.0, 0.0, 1.0], 0.1, 0.3)
    array([0.7, 0.1, 0.4])
    """
    slope = as_numbers("grading", grading)
    if slope.ndim or slope < 0:
        raise ValueError(f"grading must be one number, zero or more; got {grading!r}.")
    return as_positive("smallest", smallest) + slope * np.abs(as_numbers("d", d))


def size_from_curvature(
    phi: ArrayLike,
    dx: float | Sequence[float],
    smallest: float,
    largest: float,
    *,
    angle: float = 0.5,
) -> FloatArray:
    """Return angle / |kappa| next to the boundary, kappa its largest principal curvature.

    Parameters
    ----------
    phi : array_like of two or three axes, with four nodes at least along each
        An implicit function of the region.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.
    smallest, largest : float, length
        The bounds. Where the boundary is straight, and away from it, the size is the largest.
    angle : float, radians
        By how much the boundary may turn along an edge: 2 pi / angle edges go round a circle.

    Returns
    -------
    ndarray of phi's shape, length
        Steep: pass it through `limit_gradient`.

    Raises
    ------
    ValueError, TypeError
        If phi is not finite, has no interface or too few nodes, or a bound or the angle is not
        positive or the bounds are exchanged.

    Notes
    -----
    At a node within 1.5 cells of the boundary, the curvatures are those of the contour through it
    (`curvature`, and in space also the gradient of the normal, for the sum of their squares).
    The boundary lies farther in by the distance d = phi / |grad phi|, and has 1 / kappa - d for
    radius of curvature. At a corner the curvature is as large as the grid can tell: the smallest
    size stands there.

    Examples
    --------
    >>> grid = Grid(((-2, -2), (2, 2)), 0.1)
    >>> h = size_from_curvature((grid.points**2).sum(axis=-1) - 1, 0.1, 0.01, 1.0)
    >>> h[30, 20].round(3), h[0, 0]  # on the unit circle, and away from it
    (np.float64(0.5), np.float64(1.0))
    """
    values = as_level_set(as_values("phi", phi, least=4))
    if values.ndim < 2:
        raise ValueError("phi must have two or three axes: on a line nothing is curved.")
    steps = as_spacing(dx, values.ndim)
    low, high = _as_bounds(smallest, largest)
    slope = np.maximum(np.linalg.norm(gradient(values, steps), axis=-1), 1e-300)
    distance = values / slope
    total = curvature(values, steps)
    # The two principal curvatures have this sum, and this sum of squares.
    squares = _sum_of_squares(values, steps) if values.ndim == 3 else total**2
    root = np.sqrt(np.maximum(2 * squares - total**2, 0))
    bend = np.zeros(values.shape)
    for kappa in ((total - root) / 2, (total + root) / 2):
        bend = np.maximum(bend, np.abs(kappa) / np.maximum(np.abs(1 - kappa * distance), 1e-3))
    size = np.clip(as_positive("angle", angle) / np.maximum(bend, 1e-300), low, high)
    return np.where(np.abs(distance) <= _NEAR * max(steps), size, high)


def size_from_data(
    data: ArrayLike, dx: float | Sequence[float], change: float, smallest: float, largest: float
) -> FloatArray:
    """Return change / |grad data|, between bounds: the data change by so much along an edge.

    Parameters
    ----------
    data : array_like of one to three axes, with three nodes at least along each
        A picture, a depth, a solution on a coarser mesh: what the elements are to resolve.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.
    change : float, unit of the data
        By how much the data may change from one end of an edge to the other.
    smallest, largest : float, length
        The bounds.

    Returns
    -------
    ndarray of data's shape, length
        Steep: pass it through `limit_gradient`.

    Raises
    ------
    ValueError, TypeError
        If the data are not finite, dx does not fit them, or `change` or a bound is not positive
        or the bounds are exchanged.

    Examples
    --------
    >>> size_from_data([0.0, 0.0, 0.0, 1.0, 2.0], 0.5, 0.4, 0.1, 1.0)
    array([1. , 1. , 0.4, 0.2, 0.2])
    """
    values = as_values("data", data, least=3)
    low, high = _as_bounds(smallest, largest)
    slope = np.linalg.norm(gradient(values, as_spacing(dx, values.ndim)), axis=-1)
    return np.asarray(np.clip(as_positive("change", change) / np.maximum(slope, 1e-300), low, high))


def medial_axis(phi: ArrayLike, grid: Grid) -> FloatArray:
    """Return points of the medial axis: places inside with two closest boundary points or more.

    Parameters
    ----------
    phi : array_like of the grid's shape, length
        A signed distance.
    grid : Grid
        Where its values stand; four nodes at least along each axis.

    Returns
    -------
    ndarray of shape (n, dim), length
        One wherever the medial axis crosses a line between two neighbouring nodes.

    Raises
    ------
    ValueError, TypeError
        If phi does not fit the grid, is not finite, or has no interface.

    Notes
    -----
    There the distance has a ridge. Along each grid line, the straight line through two nodes is
    continued from the left, and the one through the next two from the right. Where the slope falls
    by more than 0.5 from one to the other, more than the bend on either side explains, and the
    lines meet between the nodes in the middle, there is a point: exactly between straight walls.
    Where the normals of the two closest boundary points differ by less than about 30 degrees the
    axis goes unseen, and with it the branches that noise grows. In trials with rectangles,
    ellipses, annuli, discs and balls the points were within a cell or so of the medial axis, and
    none was missing farther than that.

    Examples
    --------
    >>> grid = Grid((0, 4), 0.5)
    >>> medial_axis(np.abs(grid.axes[0] - 2.2) - 1.5, grid)
    array([[2.2]])
    """
    values = as_level_set(as_values("phi", phi, least=4))
    if values.shape != grid.shape:
        raise ValueError(
            f"phi must have the grid's shape {grid.shape}; got {values.shape}. Sample a field "
            "with field(grid.points)."
        )
    points = grid.points
    found = [np.empty((0, grid.dim))]
    for axis, h in enumerate(grid.dx):
        left, right = along(axis)(1, -2), along(axis)(2, -1)
        share = _ridge(-values, h, axis)
        ridge = np.isfinite(share) & (np.minimum(values[left], values[right]) < 0)
        place = points[left][ridge]
        place[:, axis] += share[ridge] * h
        found.append(place)
    return np.concatenate(found)


def feature_size(phi: ArrayLike, grid: Grid) -> FloatArray:
    """Return |d| plus the distance to the medial axis: half the width of the region, here.

    Parameters
    ----------
    phi : array_like of the grid's shape, length
        A signed distance.
    grid : Grid
        Where its values stand; four nodes at least along each axis.

    Returns
    -------
    ndarray of phi's shape, length
        Between parallel walls half their distance; next to a convex corner, where the medial axis
        ends, zero: bound it from below.

    Raises
    ------
    ValueError, TypeError
        If phi does not fit the grid, is not finite, has no interface, or no medial axis.

    Notes
    -----
    The local feature size of Amenta and Bern [AmentaBern1999]_ is this at the boundary; on the
    way to the medial axis the two distances change by the same amounts. Its slope is at most 2.

    Examples
    --------
    >>> grid = Grid((0, 4), 0.5)
    >>> feature_size(np.abs(grid.axes[0] - 2) - 1.5, grid)[1:5]
    array([1.5, 1.5, 1.5, 1.5])
    """
    axis = medial_axis(phi, grid)
    if not len(axis):
        raise ValueError(
            "phi has no medial axis that the grid can see: the region is thinner than a cell or "
            "two, or phi is no distance. Take a finer grid, or redistance phi."
        )
    distance, _ = cKDTree(axis).query(grid.points)
    return np.asarray(np.abs(as_numbers("phi", phi)) + distance)


def size_function(
    fd: Field,
    grid: Grid,
    smallest: float,
    largest: float,
    *,
    g: float = 0.3,
    angle: float | None = 0.5,
    across: float | None = 4.0,
    also: Field | None = None,
) -> Field:
    """Return the largest size that curvature, features, bounds and a slope of g allow.

    Parameters
    ----------
    fd : Field
        An implicit function of the region; only its zeros and its sign count.
    grid : Grid
        Where sizes are computed; a spacing of half the smallest size, or less.
    smallest, largest : float, length
        The bounds.
    g : float, dimensionless
        The steepest slope, measured along paths inside the region.
    angle : float, radians, optional
        By how much the boundary may turn along an edge; None to leave the curvature out.
    across : float, dimensionless, optional
        How many elements from wall to wall, at least; None to leave features out.
    also : Field, length, optional
        One more wish for the size.

    Returns
    -------
    Field
        Ready for a mesh generator, with ``h0=smallest``.

    Raises
    ------
    ValueError, TypeError
        If fd has no interface on the grid, a number is not positive, or the bounds are exchanged.

    Examples
    --------
    >>> from distmesh_edu import circle
    >>> fh = size_function(circle(), Grid(((-1.2, -1.2), (1.2, 1.2)), 0.05), 0.1, 1.0)
    >>> fh(np.array([[1.0, 0.0], [0.0, 0.0]])).round(2)
    array([0.48, 0.5 ])
    """
    low, high = _as_bounds(smallest, largest)
    values = as_level_set(evaluate("fd", as_field("fd", fd), grid.points))
    d = redistance(values, grid.dx)
    h = np.full(grid.shape, high)
    if angle is not None and grid.dim > 1:
        h = np.minimum(h, size_from_curvature(values, grid.dx, low, high, angle=angle))
    if across is not None:
        h = np.minimum(h, 2 * feature_size(d, grid) / as_positive("across", across))
    if also is not None:
        h = np.minimum(h, evaluate("also", as_field("also", also), grid.points))
    limited = limit_gradient(np.maximum(h, low), g, grid.dx, inside=values <= 0)
    # Linear: a cubic would swing beyond the bounds next to a thin wall.
    return grid.interpolate(limited, degree=1)


def _as_bounds(smallest: float, largest: float) -> tuple[float, float]:
    low, high = as_positive("smallest", smallest), as_positive("largest", largest)
    if low > high:
        raise ValueError(f"smallest must not be above largest; got {low:g} and {high:g}.")
    return low, high


def _ridge(d: FloatArray, dx: float, axis: int) -> FloatArray:
    """Return where each interval but the outermost has a ridge, from 0 to 1; NaN without one."""
    at = along(axis)
    slope = np.diff(extrapolated(d, 1, axis), axis=axis) / dx
    before, rise, fall, after = (slope[at(k, k - 4 or None)] for k in (0, 1, 3, 4))
    leap = rise - fall
    # What a bend takes off the slope it takes off in the intervals on either side as well.
    kink = leap - np.maximum(before - rise, 0) - np.maximum(fall - after, 0)
    width = [(1, 1) if k == axis else (0, 0) for k in range(d.ndim)]
    beside = np.pad(leap, width)
    sharpest = leap * (1 + 1e-9) >= np.maximum(beside[at(0, -2)], beside[at(2)])
    way = d[at(2, -1)] - d[at(1, -2)] - fall * dx
    share = way / np.where(leap > 0, leap * dx, np.inf)
    meets = (kink > _KINK) & sharpest & (share > -1e-9) & (share < 1 + 1e-9)
    return np.where(meets, share, np.nan)


def _sum_of_squares(phi: FloatArray, dx: Sequence[float]) -> FloatArray:
    """Return the sum of the squares of the principal curvatures: the trace of (grad N)**2."""
    normal = np.moveaxis(unit_normal(phi, dx), -1, 0)
    turn = np.stack([gradient(part, dx) for part in normal])  # turn[i, ..., j] = d N_i / d x_j
    return np.asarray(np.einsum("i...j,j...i->...", turn, turn))
