"""What every public door asks of its arguments: each error names one, its value, and a remedy."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Points = NDArray[np.float64]


def as_numbers(name: str, value: ArrayLike) -> Points:
    """Return `value` as a float array, or say that it holds something other than finite numbers."""
    try:
        numbers = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise TypeError(
            f"{name} must hold real numbers in rows of equal length; got {value!r}."
        ) from error
    if not np.isfinite(numbers).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(numbers))[0])
        raise ValueError(
            f"{name} must be finite; {name}{list(where) if where else ''} is "
            f"{numbers[where]}. Remove or replace it."
        )
    return numbers


def as_positive(name: str, value: ArrayLike) -> float:
    """Return `value` as a positive float."""
    number = as_numbers(name, value)
    if number.ndim or number <= 0:
        raise ValueError(f"{name} must be one positive number; got {value!r}.")
    return float(number)


def as_points(name: str, value: ArrayLike, dim: int) -> Points:
    """Return `value` as an array of points of shape (n, dim)."""
    points = as_numbers(name, value)
    if points.ndim != 2 or points.shape[1] != dim:
        raise ValueError(
            f"{name} must have the shape (n, {dim}), one point a row; got {points.shape}."
        )
    return points


def as_bbox(bbox: ArrayLike, dim: int | None = None) -> Points:
    """Return `bbox` as an array of two rows, the lower corner and the upper one."""
    box = as_numbers("bbox", bbox)
    if box.ndim != 2 or box.shape[0] != 2 or (dim is not None and box.shape[1] != dim):
        wanted = "((xmin, ymin), (xmax, ymax))" if dim in (2, None) else f"two rows of {dim}"
        raise ValueError(f"bbox must be {wanted}; got the shape {box.shape}.")
    if not (box[0] < box[1]).all():
        raise ValueError(
            f"bbox must go from its lower to its upper corner; got {box[0].tolist()} to "
            f"{box[1].tolist()}. Swap the two, or widen the box."
        )
    return box


def as_field(name: str, field: Any) -> Any:
    """Return `field`, or say that it cannot be called."""
    if not callable(field):
        raise TypeError(
            f"{name} must be a field, a function of points; got {field!r}. Pass the function "
            "itself, or give values on a grid to Grid.interpolate."
        )
    return field


def evaluate(name: str, field: Any, points: Points) -> Points:
    """Return the field's values at points of shape (n, dim), checked: shape (n,) and finite."""
    values = np.asarray(field(points), dtype=np.float64)
    if values.shape != points.shape[:-1]:
        raise ValueError(
            f"{name} must return one value a point: it was given points of shape "
            f"{points.shape} and returned the shape {values.shape}. Compute with p[..., 0] "
            "and p[..., 1], and keep the leading shape."
        )
    if not np.isfinite(values).all():
        i = int(np.argmin(np.isfinite(values)))
        raise ValueError(
            f"{name} must be finite; it returned {values[i]} at {points[i].tolist()}. "
            "Give it a value there, or keep the box away from that point."
        )
    return values
