"""The Cartesian grid: where a field becomes an array, and an array a field again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import NdBSpline, make_interp_spline

from ._types import ArrayLike, Field, FloatArray
from ._validation import as_bbox, as_numbers


@dataclass(frozen=True, init=False)
class Grid:
    """The nodes lower + i dx of a box, in one, two or three dimensions.

    Parameters
    ----------
    bbox : array_like of shape (2, dim), length
        The lower and the upper corner, ((xmin, ymin), (xmax, ymax)) in the plane.
    dx : float or sequence of float, length
        The spacing, one number or one for each axis. It must divide the side of the box: a grid
        that ends short of the corner you asked for would be a silent surprise.
    periodic : bool or sequence of bool
        An axis along which the box repeats. Its last node is the first one again, so it is not
        stored.

    Raises
    ------
    ValueError
        If `dx` is not positive or does not divide the box, or `bbox` is not one.

    Examples
    --------
    >>> grid = Grid(((0, 0), (1, 2)), 0.5)
    >>> grid.shape, grid.points.shape
    ((3, 5), (3, 5, 2))
    >>> bool(np.all(grid.points[1, 4] == (0.5, 2.0)))
    True
    """

    bbox: tuple[tuple[float, ...], tuple[float, ...]]
    dx: tuple[float, ...]
    periodic: tuple[bool, ...]

    def __init__(
        self,
        bbox: ArrayLike,
        dx: float | Sequence[float],
        periodic: bool | Sequence[bool] = False,
    ) -> None:
        corners = as_numbers("bbox", bbox)
        box = as_bbox(corners[:, None] if corners.ndim == 1 else corners)  # (a, b) on a line
        dim = box.shape[1]
        steps = _one_for_each_axis("dx", as_numbers("dx", dx), dim)
        _check_division(box, steps)
        wraps = _one_for_each_axis("periodic", np.asarray(periodic, dtype=bool), dim)
        # A frozen dataclass is filled through object: from here on nothing can change it.
        object.__setattr__(self, "bbox", tuple(tuple(row) for row in box.tolist()))
        object.__setattr__(self, "dx", tuple(steps.tolist()))
        object.__setattr__(self, "periodic", tuple(wraps.tolist()))

    @property
    def dim(self) -> int:
        """The number of axes."""
        return len(self.dx)

    @property
    def axes(self) -> tuple[FloatArray, ...]:
        """The coordinates of the nodes along each axis."""
        axes = zip(*self.bbox, self.dx, self.periodic, strict=True)
        return tuple(_nodes(a, b, dx)[: -1 if wraps else None] for a, b, dx, wraps in axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """The number of nodes along each axis: the shape of an array of values."""
        return tuple(len(axis) for axis in self.axes)

    @property
    def points(self) -> FloatArray:
        """The nodes, of shape (nx, ny, 2) in the plane: `points[i, j]` is (x_i, y_j)."""
        return np.stack(np.meshgrid(*self.axes, indexing="ij"), axis=-1)

    def interpolate(self, values: ArrayLike, *, degree: int = 3) -> Field:
        """Return the field that takes the given values at the nodes.

        Parameters
        ----------
        values : array_like of the grid's shape
            `values[i, j]` belongs to (x_i, y_j).
        degree : int
            The degree of the interpolating spline along each axis: 3, smooth, or 1, linear
            between neighbours. Linear interpolation puts a kink on every grid line, and bends a
            curved boundary inwards by up to dx**2 / 8 times its curvature.

        Returns
        -------
        Field
            Continued beyond the box by the polynomials at its rim for two cells, and from there
            on by the values it has reached: trust it within a cell or two.

        Raises
        ------
        ValueError
            If `values` has another shape than the grid, is not finite, or the grid has not more
            nodes than `degree` along each axis.

        Notes
        -----
        A tensor product of interpolating splines, with the not-a-knot condition at the ends.

        Examples
        --------
        >>> grid = Grid(((0, 0), (1, 1)), 0.25)
        >>> field = grid.interpolate(grid.points[..., 0] * grid.points[..., 1])
        >>> float(np.round(field(np.array([0.3, 0.7])), 12))
        0.21
        """
        array = as_numbers("values", values)
        if array.shape != self.shape:
            raise ValueError(
                f"values must have the grid's shape {self.shape}; got {array.shape}. "
                "values[i, j] is the value at (x_i, y_j)."
            )
        if degree not in (1, 3):
            raise ValueError(f"degree must be 1 (linear) or 3 (cubic); got {degree!r}.")
        if min(self.shape) <= degree:
            raise ValueError(
                f"degree {degree} needs {degree + 1} nodes along each axis at least; the grid "
                f"has {self.shape}. Take a smaller dx, or degree=1."
            )
        surface = self._tensor_spline(array, degree)
        lower, upper = (np.array(corner) for corner in self.bbox)
        wraps, margin = np.array(self.periodic), 2 * np.array(self.dx)

        def field(p: FloatArray) -> FloatArray:
            points = np.asarray(p, dtype=np.float64)
            if wraps.any():
                points = np.where(wraps, lower + np.mod(points - lower, upper - lower), points)
            # Farther out a cubic grows wild: a mesh generator would find water behind the rim.
            near = np.clip(points, lower - margin, upper + margin)
            return np.asarray(surface(near, extrapolate=True), dtype=np.float64)

        return field

    def _tensor_spline(self, values: FloatArray, degree: int) -> NdBSpline:
        """Interpolate along one axis after the other; what is left are coefficients."""
        knots: list[FloatArray] = []
        for axis, (low, high) in enumerate(zip(*self.bbox, strict=True)):
            ends = None
            if self.periodic[axis]:  # the spline wants the first node again at the end
                values = np.concatenate((values, values.take([0], axis=axis)), axis=axis)
                ends = "periodic"
            x = _nodes(low, high, self.dx[axis])
            spline = make_interp_spline(x, values, degree, axis=axis, bc_type=ends)
            knots.append(spline.t)
            values = np.moveaxis(spline.c, 0, axis)
        return NdBSpline(tuple(knots), values, degree)


def _nodes(low: float, high: float, dx: float) -> FloatArray:
    return np.asarray(low + dx * np.arange(round((high - low) / dx) + 1), dtype=np.float64)


def _one_for_each_axis(name: str, value: np.ndarray, dim: int) -> np.ndarray:
    if value.shape not in ((), (dim,)):
        raise ValueError(
            f"{name} must be one value or one for each of the {dim} axes; got the shape "
            f"{value.shape}."
        )
    return np.broadcast_to(value, (dim,))


def _check_division(box: FloatArray, steps: FloatArray) -> None:
    for axis, (side, dx) in enumerate(zip(box[1] - box[0], steps, strict=True)):
        if dx <= 0:
            raise ValueError(f"dx must be positive; along axis {axis} it is {dx:g}.")
        cells = side / dx
        if round(cells) < 1 or abs(cells - round(cells)) > 1e-6:
            more = f"{side:g} / {int(cells) + 1}"
            remedy = more if cells < 1 else f"{side:g} / {int(cells)} or {more}"
            raise ValueError(
                f"dx must divide the box; along axis {axis} the side {side:g} holds "
                f"{cells:.4g} steps of {dx:g}. Take {remedy}."
            )
