"""The geometry that an implicit function carries: normals, curvatures, closest points, volumes."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from itertools import permutations, product
from math import factorial

import numpy as np

from ._types import ArrayLike, BoolArray, Field, FloatArray
from ._validation import (
    as_count,
    as_field,
    as_numbers,
    as_positive,
    as_spacing,
    as_values,
    evaluate,
)
from ._warnings import ConvergenceWarning
from .grid import Grid

_FIRST = np.finfo(float).eps ** (1 / 3)  # the step that balances dx**2 with eps / dx,
_SECOND = np.finfo(float).eps ** (1 / 4)  # and the one that balances it with eps / dx**2
_STIFF = 0.1  # of 1, that of a plane: the least stiffness in the search for a closest point


# ---- arrays on grids ----


def gradient(phi: ArrayLike, dx: ArrayLike) -> FloatArray:
    """Return the gradient (d phi/dx, d phi/dy, ...) by central differences.

    Parameters
    ----------
    phi : array_like of shape (nx,), (nx, ny) or (nx, ny, nz)
        Values on a grid, of any unit; 3 nodes at least along each axis.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.

    Returns
    -------
    ndarray of shape phi.shape + (dim,), unit of phi / length
        Second order, at the rim too, where one-sided differences of second order stand in.

    Raises
    ------
    TypeError, ValueError
        If `phi` is not such an array, or `dx` not such a spacing.

    Notes
    -----
    Thesis eq. (2.4).

    Examples
    --------
    >>> x = np.linspace(0, 1, 5)
    >>> gradient(x**2, 0.25)[:, 0]
    array([0. , 0.5, 1. , 1.5, 2. ])
    """
    values = as_values("phi", phi, least=3)
    return _gradient(values, as_spacing(dx, values.ndim))


def unit_normal(phi: ArrayLike, dx: ArrayLike) -> FloatArray:
    """Return the outward unit normal N = grad phi / |grad phi|.

    Parameters
    ----------
    phi : array_like of shape (nx,), (nx, ny) or (nx, ny, nz)
        Values on a grid; 3 nodes at least along each axis.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.

    Returns
    -------
    ndarray of shape phi.shape + (dim,), dimensionless
        At every node the normal of the contour through it, second order; the zero vector where
        the gradient is zero.

    Raises
    ------
    TypeError, ValueError
        If `phi` is not such an array, or `dx` not such a spacing.

    Notes
    -----
    Thesis eq. (2.5).

    Examples
    --------
    >>> grid = Grid(((0, 0), (2, 2)), 1)
    >>> unit_normal(3 * grid.points[..., 0] + 4 * grid.points[..., 1], 1)[1, 1]
    array([0.6, 0.8])
    """
    return _normalized(gradient(phi, dx))


def curvature(phi: ArrayLike, dx: ArrayLike) -> FloatArray:
    """Return div N, the sum of the principal curvatures of the contour through each node.

    Parameters
    ----------
    phi : array_like of shape (nx,), (nx, ny) or (nx, ny, nz)
        Values on a grid; 4 nodes at least along each axis.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.

    Returns
    -------
    ndarray of phi's shape, 1/length
        1/R on a circle, 2/R on a sphere, 0 on a line (points have no curvature); positive where
        the region is convex. Second order. 0 where the gradient is zero; around such a place the
        contours are small, and the values as large as these are bent.

    Raises
    ------
    TypeError, ValueError
        If `phi` is not such an array, or `dx` not such a spacing.

    Notes
    -----
    With g the gradient of phi and H its matrix of second derivatives, div (g / |g|) =
    (|g|**2 trace H - g . H g) / |g|**3 in any dimension. In the plane this is thesis eq. (2.9), in
    space eq. (2.10) with the power 3/2 of the *whole* |g|**2 in the denominators: as printed
    they lack phi_z**2. The thesis calls div N the mean curvature; that is `mean_curvature`.

    Examples
    --------
    >>> grid = Grid(((-1, -1), (1, 1)), 0.25)
    >>> float(curvature((grid.points**2).sum(axis=-1), 0.25)[4, 6])  # on the circle of radius 0.5
    2.0
    """
    values = as_values("phi", phi, least=4)
    steps = as_spacing(dx, values.ndim)
    return _divergence_of_normal(_gradient(values, steps), _hessian(values, steps))


def mean_curvature(phi: ArrayLike, dx: ArrayLike) -> FloatArray:
    """Return div N / (dim - 1), the mean of the principal curvatures.

    Parameters
    ----------
    phi : array_like of shape (nx, ny) or (nx, ny, nz)
        Values on a grid; 4 nodes at least along each axis.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.

    Returns
    -------
    ndarray of phi's shape, 1/length
        1/R on a circle and on a sphere: half of what the thesis calls mean curvature in space.

    Raises
    ------
    TypeError, ValueError
        If `phi` is not such an array, or `dx` not such a spacing.

    Examples
    --------
    >>> grid = Grid(((-1, -1, -1), (1, 1, 1)), 0.25)
    >>> float(mean_curvature((grid.points**2).sum(axis=-1), 0.25)[4, 4, 6])  # radius 0.5
    2.0
    """
    dim = _surface_dim("phi", np.ndim(phi))
    return curvature(phi, dx) / dim


def closest_points(phi: ArrayLike, grid: Grid) -> FloatArray:
    """Return x - phi N, for each node x of a grid the closest point of the interface.

    Parameters
    ----------
    phi : array_like of the grid's shape, length
        A signed distance. (For another function see `closest_point`.)
    grid : Grid
        Where its values stand; 3 nodes at least along each axis.

    Returns
    -------
    ndarray of shape phi.shape + (dim,), length
        Second order. Where there is more than one closest point, the differences mix the
        normals on either side, and the result is none of them.

    Raises
    ------
    TypeError, ValueError
        If `phi` does not fit the grid.

    Notes
    -----
    Thesis eq. (2.3).

    Examples
    --------
    >>> grid = Grid((0, 4), 0.5)
    >>> closest_points(np.abs(grid.axes[0] - 2) - 1, grid)[[0, -1], 0]
    array([1., 3.])
    """
    values = as_values("phi", phi, least=3)
    if values.shape != grid.shape:
        raise ValueError(
            f"phi must have the grid's shape {grid.shape}; got {values.shape}. Sample a field "
            "with field(grid.points)."
        )
    return np.asarray(grid.points - values[..., None] * unit_normal(values, grid.dx))


def volume(phi: ArrayLike, dx: ArrayLike) -> float:
    """Return the measure of the region phi < 0: a length, an area or a volume.

    Parameters
    ----------
    phi : array_like of shape (nx,), (nx, ny) or (nx, ny, nz)
        Values on a grid. What lies beyond the grid is not counted.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.

    Returns
    -------
    float, length ** dim
        Exact where the boundary is flat and phi linear; else second order.

    Raises
    ------
    TypeError, ValueError
        If `phi` is not such an array, or `dx` not such a spacing.

    Notes
    -----
    Each cell that the boundary crosses is cut into simplices (Kuhn's: see `_simplices`), on which
    phi is taken to be linear. The share of a simplex with phi < 0 follows from the sorted values
    at its corners, by the recursion of Cox and de Boor: the share with phi < c, as a function of
    c, is the integral of the B-spline whose knots are these values [CurrySchoenberg1966]_.

    Examples
    --------
    >>> grid = Grid(((0, 0), (1, 1)), 0.25)
    >>> round(volume(grid.points.sum(axis=-1) - 0.5, 0.25), 12)  # a triangle
    0.125
    """
    values = as_values("phi", phi)
    steps = as_spacing(dx, values.ndim)
    inside, crossed, corners = _cells(values)
    share = sum(float(_shares(f)[-1][0].sum()) for f, _ in _simplices(corners, steps))
    whole = np.count_nonzero(inside & ~crossed)
    return float((whole + share / factorial(values.ndim)) * np.prod(steps))


def interface_area(phi: ArrayLike, dx: ArrayLike) -> float:
    """Return the measure of the interface phi = 0: a number of points, a length or an area.

    Parameters
    ----------
    phi : array_like of shape (nx,), (nx, ny) or (nx, ny, nz)
        Values on a grid.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis.

    Returns
    -------
    float, length ** (dim - 1)
        Exact where the boundary is flat and phi linear; else second order.

    Raises
    ------
    TypeError, ValueError
        If `phi` is not such an array, or `dx` not such a spacing.

    Notes
    -----
    See `volume`. Where phi is linear, raising the level by dc moves the interface by
    dc / |grad phi|; hence the measure of the interface is |grad phi| times the derivative of the
    volume by the level (the co-area formula), which the last step but one of the recursion
    holds.

    Examples
    --------
    >>> grid = Grid(((0, 0), (1, 1)), 0.25)
    >>> round(interface_area(grid.points.sum(axis=-1) - 0.5, 0.25) ** 2, 12)
    0.5
    """
    values = as_values("phi", phi)
    steps = as_spacing(dx, values.ndim)
    dim, total = values.ndim, 0.0
    for f, slope in _simplices(_cells(values)[2], steps):
        first, last = _shares(f)[-2]
        spread = f[-1] - f[0]
        flat = spread == 0  # a simplex that the interface does not enter
        total += float((slope * (first - last) * ~flat / np.where(flat, 1, spread)).sum())
    return total * dim * float(np.prod(steps)) / factorial(dim)


# ---- fields at points ----


def gradient_at(fd: Field, p: ArrayLike, *, step: float | None = None) -> FloatArray:
    """Return the gradient of a field at points, by central differences.

    Parameters
    ----------
    fd : Field
        Any field.
    p : array_like of shape (..., dim), length
        Where.
    step : float, length, optional
        Half the distance between the two points of a difference. The default is 6e-6 max(1, |p|):
        for a shape much smaller than 1, give 1e-5 of its size.

    Returns
    -------
    ndarray of shape (..., dim), unit of fd / length
        For a smooth field with the default step, right to about ten digits.

    Raises
    ------
    TypeError, ValueError
        If `fd` is not a field, `p` not points, or `step` not positive.

    Examples
    --------
    >>> gradient_at(lambda p: p[..., 0] * p[..., 1], (2.0, 3.0)).round(8)
    array([3., 2.])
    """
    points = _as_places(p)
    return _gradient_at(as_field("fd", fd), points, _steps(points, step, _FIRST))


def unit_normal_at(fd: Field, p: ArrayLike, *, step: float | None = None) -> FloatArray:
    """Return grad fd / |grad fd| at points.

    Parameters
    ----------
    fd : Field
        Any field, negative inside: then the normal points outwards.
    p : array_like of shape (..., dim), length
        Where.
    step : float, length, optional
        As in `gradient_at`.

    Returns
    -------
    ndarray of shape (..., dim), dimensionless
        The zero vector where the gradient is zero.

    Raises
    ------
    TypeError, ValueError
        If `fd` is not a field, `p` not points, or `step` not positive.

    Examples
    --------
    >>> unit_normal_at(lambda p: 3 * p[..., 0] + 4 * p[..., 1], (2.0, 3.0)).round(8)
    array([0.6, 0.8])
    """
    return _normalized(gradient_at(fd, p, step=step))


def curvature_at(fd: Field, p: ArrayLike, *, step: float | None = None) -> FloatArray:
    """Return div N of a field at points: the sum of the principal curvatures.

    Parameters
    ----------
    fd : Field
        Any field, negative inside.
    p : array_like of shape (..., dim), length
        Where. On the boundary it is the boundary's curvature, elsewhere that of the contour there.
    step : float, length, optional
        Of the differences. The default is 1.2e-4 max(1, |p|): for a shape much smaller than 1,
        give 1e-4 of its size.

    Returns
    -------
    ndarray of shape (...), 1/length
        As in `curvature`; for a smooth field with the default step, right to about six digits.

    Raises
    ------
    TypeError, ValueError
        If `fd` is not a field, `p` not points, or `step` not positive.

    Examples
    --------
    >>> curvature_at(lambda p: (p**2).sum(axis=-1) - 4, [(2.0, 0.0)]).round(5)
    array([0.5])
    """
    points, field = _as_places(p), as_field("fd", fd)
    steps = _steps(points, step, _SECOND)
    return _divergence_of_normal(
        _gradient_at(field, points, steps), _hessian_at(field, points, steps)
    )


def mean_curvature_at(fd: Field, p: ArrayLike, *, step: float | None = None) -> FloatArray:
    """Return div N / (dim - 1) of a field at points: the mean of the principal curvatures.

    Parameters
    ----------
    fd : Field
        Any field, negative inside.
    p : array_like of shape (..., dim), length
        Where; in the plane or in space.
    step : float, length, optional
        As in `curvature_at`.

    Returns
    -------
    ndarray of shape (...), 1/length

    Raises
    ------
    TypeError, ValueError
        If `fd` is not a field, `p` not points, or `step` not positive.

    Examples
    --------
    >>> mean_curvature_at(lambda p: (p**2).sum(axis=-1) - 4, [(2.0, 0.0, 0.0)]).round(5)
    array([0.5])
    """
    dim = _surface_dim("p", _as_places(p).shape[-1])
    return curvature_at(fd, p, step=step) / dim


def closest_point(
    fd: Field, p: ArrayLike, *, step: float | None = None, max_steps: int = 100
) -> FloatArray:
    """Return the points c with fd(c) = 0 and p - c parallel to grad fd(c), the least far from p.

    Parameters
    ----------
    fd : Field
        A smooth field, a distance or not. For a distance with |grad fd| = 1, `closest_points` and
        p - fd(p) grad fd(p) need no iteration.
    p : array_like of shape (..., dim), length
        Where to start.
    step : float, length, optional
        Of the differences, as in `curvature_at`.
    max_steps : int
        How often the points may move.

    Returns
    -------
    ndarray of shape (..., dim), length
        On the boundary up to rounding, closest to p up to about 1e-8 of the size of the shape.
        The search runs downhill, so that c is closer to p than its neighbours on the boundary
        are. Where there are several such points, as for p far inside an
        ellipse, it is not known to be the closest of them all.

    Raises
    ------
    TypeError, ValueError
        If `fd` is not a field, `p` not points, or `step` or `max_steps` not positive.

    Warns
    -----
    ConvergenceWarning
        If some points have not come to rest, for example since the gradient vanishes where they
        start. They are returned where they stand.

    Notes
    -----
    Newton's method, one step across the boundary and one along it. Across: fd / |grad fd|. Along:
    what p - c has of tangent, divided by the stiffness 1 + lambda H, where lambda = (p - c) .
    grad fd / |grad fd|**2 and H is the matrix of second derivatives of fd. The sizes of its
    eigenvalues are taken, so that it does not run to a farthest point.

    Examples
    --------
    >>> ellipse = lambda p: p[..., 0] ** 2 / 4 + p[..., 1] ** 2 - 1
    >>> closest_point(ellipse, [(3.0, 0.0), (0.0, 0.5)]).round(6) + 0.0
    array([[2., 0.],
           [0., 1.]])
    """
    places, field, cap = _as_places(p), as_field("fd", fd), as_count("max_steps", max_steps)
    goal = places.reshape(-1, places.shape[-1])
    c, lost = _onto_boundary(field, goal, step, cap)
    share, moving = np.ones(len(c)), np.flatnonzero(~lost)
    for _ in range(cap):
        if not moving.size:
            break
        at, to = c[moving], goal[moving]
        move = _along_boundary(field, at, to, step)
        trial, astray = _onto_boundary(field, at + share[moving, None] * move, step, cap)
        before, after = (np.linalg.norm(to - one, axis=-1) for one in (at, trial))
        # A step that leads away from p was too long: try a part of it next time.
        nearer = (after <= before * (1 + 1e-14)) & ~astray
        c[moving] = np.where(nearer[:, None], trial, at)
        share[moving] = np.where(nearer, np.minimum(1, 2 * share[moving]), share[moving] / 4)
        moving = moving[~_small(move, at, step)]
    stuck = np.union1d(np.flatnonzero(lost), moving)
    if stuck.size:
        warnings.warn(
            f"closest_point: {stuck.size} of {len(c)} points have not come to rest after {cap} "
            f"steps, the first for p = {goal[stuck[0]].tolist()}. Start closer to the boundary, or "
            "raise max_steps.",
            ConvergenceWarning,
            stacklevel=2,
        )
    return c.reshape(places.shape)


# ---- one formula for any dimension ----


def _normalized(g: FloatArray) -> FloatArray:
    length = np.linalg.norm(g, axis=-1, keepdims=True)
    return np.asarray(g / np.where(length == 0, 1, length))


def _divergence_of_normal(g: FloatArray, hessian: FloatArray) -> FloatArray:
    """Return (|g|^2 trace H - g . H g) / |g|^3, with n = g / |g|."""
    length = np.linalg.norm(g, axis=-1)
    n = _normalized(g)
    trace = np.trace(hessian, axis1=-2, axis2=-1)
    along = np.einsum("...i,...ij,...j->...", n, hessian, n)
    flat = length == 0
    return np.where(flat, 0, (trace - along) / np.where(flat, 1, length))


def _gradient(phi: FloatArray, steps: tuple[float, ...]) -> FloatArray:
    parts = [np.gradient(phi, dx, axis=axis, edge_order=2) for axis, dx in enumerate(steps)]
    return np.stack(parts, axis=-1)


def _hessian(phi: FloatArray, steps: tuple[float, ...]) -> FloatArray:
    """Return the matrix of second derivatives, of shape phi.shape + (dim, dim)."""
    rows = np.stack([_gradient(part, steps) for part in np.moveaxis(_gradient(phi, steps), -1, 0)])
    matrix = np.moveaxis(rows, 0, -2)
    for axis, dx in enumerate(steps):
        # A difference of differences would reach two nodes far: on the diagonal, one will do.
        matrix[..., axis, axis] = _second(phi, dx, axis)
    return matrix


def _second(phi: FloatArray, dx: float, axis: int) -> FloatArray:
    f = np.moveaxis(phi, axis, 0)
    second = np.empty_like(f)
    second[1:-1] = f[2:] - 2 * f[1:-1] + f[:-2]
    second[0] = 2 * f[0] - 5 * f[1] + 4 * f[2] - f[3]
    second[-1] = 2 * f[-1] - 5 * f[-2] + 4 * f[-3] - f[-4]
    return np.moveaxis(second / dx**2, 0, axis)


def _surface_dim(name: str, dim: int) -> int:
    if dim < 2:
        raise ValueError(
            f"{name} must be in the plane or in space: on a line the interface consists of "
            "points, which have no curvature to take a mean of."
        )
    return dim - 1


# ---- cells cut into simplices ----

_Corners = dict[tuple[int, ...], FloatArray]


def _cells(phi: FloatArray) -> tuple[BoolArray, BoolArray, _Corners]:
    """Return which cells begin inside, which the boundary crosses, and the corners of these."""
    offsets = list(product((0, 1), repeat=phi.ndim))
    views = {offset: phi[tuple(slice(k, k - 1 or None) for k in offset)] for offset in offsets}
    below = [view < 0 for view in views.values()]
    crossed = np.logical_or.reduce(below) & ~np.logical_and.reduce(below)
    return below[0], crossed, {offset: view[crossed] for offset, view in views.items()}


def _simplices(
    corners: _Corners, steps: tuple[float, ...]
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield sorted corner values, (dim + 1, n), and |grad phi|, of each simplex.

    Kuhn's simplices: walk from corner (0, 0, 0) of a cell to (1, 1, 1), along
    one axis after the other. Each order of the axes is another walk, and
    visits the corners of another simplex; they fill the cell, all have the
    same volume, and those of neighbouring cells match.
    """
    for order in permutations(range(len(steps))):
        place, walk = [0] * len(steps), [corners[(0,) * len(steps)]]
        for axis in order:
            place[axis] = 1
            walk.append(corners[tuple(place)])
        # Each leg of the walk runs along an axis, and shows the derivative along it.
        legs = zip(np.diff(walk, axis=0), order, strict=True)
        slopes = [rise / steps[axis] for rise, axis in legs]
        yield np.sort(walk, axis=0), np.linalg.norm(slopes, axis=0)


def _shares(f: FloatArray) -> list[FloatArray]:
    """Return the rows F_i^(k) of the recursion; the last is the share below 0.

    F_i^(0) = [f_i < 0], and F_i^(k) = (f_{i+k} F_{i+1}^(k-1) - f_i F_i^(k-1))
    / (f_{i+k} - f_i): the share of the simplex with the corners i, ..., i+k
    is mixed from those of two faces, as the place where phi = 0 divides the
    edge from f_i to f_{i+k}.
    """
    rows = [(f < 0).astype(np.float64)]
    for k in range(1, len(f)):
        low, high, before = f[:-k], f[k:], rows[-1]
        equal = high == low
        mixed = high * before[1:] - low * before[:-1]
        mixed /= np.where(equal, 1, high - low)
        rows.append(np.where(equal, before[:-1], mixed))
    return rows


# ---- differences of fields ----


def _as_places(p: ArrayLike) -> FloatArray:
    points = as_numbers("p", p)
    if points.ndim < 1 or points.shape[-1] not in (1, 2, 3):
        raise ValueError(
            f"p must have the shape (..., dim), with dim 1, 2 or 3; got {points.shape}."
        )
    return points


def _steps(p: FloatArray, step: float | None, default: float) -> FloatArray:
    """Return a step for each point: what is asked for, or a share of its size or of 1."""
    if step is not None:
        return np.full(p.shape[:-1], as_positive("step", step))
    return np.asarray(default * np.maximum(1, np.abs(p).max(axis=-1)))


def _gradient_at(fd: Field, p: FloatArray, steps: FloatArray) -> FloatArray:
    ways = steps[..., None, None] * np.eye(p.shape[-1])
    ends = p[..., None, :] + ways, p[..., None, :] - ways
    rise = evaluate("fd", fd, ends[0]) - evaluate("fd", fd, ends[1])
    return np.asarray(rise / (2 * steps[..., None]))


def _hessian_at(fd: Field, p: FloatArray, steps: FloatArray) -> FloatArray:
    """Return the matrix of second derivatives at points, of shape (..., dim, dim)."""
    dim = p.shape[-1]
    ways = steps[..., None, None] * np.eye(dim)
    both = ways[..., :, None, :] + ways[..., None, :, :]
    sides = {s: evaluate("fd", fd, p[..., None, :] + s * ways) for s in (1, -1)}
    middle = evaluate("fd", fd, p)[..., None]
    # f(x + a + b) + f(x - a - b) less the same for a and for b alone: second order, and symmetric.
    pairs = sum(evaluate("fd", fd, p[..., None, None, :] + s * both) for s in (1, -1))
    alone = sides[1] + sides[-1] - middle
    second = (pairs - alone[..., :, None] - alone[..., None, :]) / 2
    diagonal = np.arange(dim)
    second[..., diagonal, diagonal] = sides[1] - 2 * middle + sides[-1]
    return np.asarray(second / steps[..., None, None] ** 2)


def _small(move: FloatArray, p: FloatArray, step: float | None) -> BoolArray:
    return np.asarray(np.linalg.norm(move, axis=-1) < 1e-2 * _steps(p, step, _FIRST))


def _slope(fd: Field, p: FloatArray, step: float | None) -> FloatArray:
    """Return the gradient; where it is zero, a small one, to see more a step further on."""
    steps = _steps(p, step, _FIRST)
    g = _gradient_at(fd, p, steps)
    way = np.eye(p.shape[-1])[0] * np.abs(evaluate("fd", fd, p) / steps)[..., None]
    return np.where((g == 0).all(axis=-1, keepdims=True), way, g)


def _onto_boundary(
    fd: Field, p: FloatArray, step: float | None, cap: int
) -> tuple[FloatArray, BoolArray]:
    """Return where Newton's method for fd = 0 leads along the gradient, and which got nowhere."""
    c, moving = p.copy(), np.arange(len(p))
    for _ in range(cap):
        if not moving.size:
            break
        at = c[moving]
        g = _slope(fd, at, step)
        square = (g**2).sum(axis=-1)
        move = -(evaluate("fd", fd, at) / np.where(square == 0, 1, square))[:, None] * g
        c[moving] += move
        moving = moving[~_small(move, at, step)]
    lost = np.zeros(len(c), dtype=np.bool_)
    lost[moving] = True
    return c, lost


def _along_boundary(fd: Field, c: FloatArray, p: FloatArray, step: float | None) -> FloatArray:
    """Return the Newton step from c, on the boundary, that brings it closer to p."""
    g, one = _slope(fd, c, step), np.eye(c.shape[-1])
    square = np.maximum((g**2).sum(axis=-1), np.finfo(float).tiny)
    n = g / np.sqrt(square)[:, None]
    tangent = one - n[:, :, None] * n[:, None, :]
    bend = tangent @ _hessian_at(fd, c, _steps(c, step, _SECOND)) @ tangent
    stretch = ((p - c) * g).sum(axis=-1) / square  # lambda
    stiffness, ways = np.linalg.eigh(tangent + stretch[:, None, None] * bend)
    pull = np.einsum("nij,nj->ni", tangent, p - c)
    parts = np.einsum("nji,nj->ni", ways, pull) / np.maximum(np.abs(stiffness), _STIFF)
    return np.asarray(np.einsum("nij,nj->ni", ways, parts))
