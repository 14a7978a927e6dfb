"""What every public door asks of its arguments: each error names one, its value, and a remedy."""

import operator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Points = NDArray[np.float64]


def as_numbers(name: str, value: ArrayLike) -> Points:
    """Return `value` as a float array, or say that it holds something other than finite numbers."""
    try:
        raw = np.asarray(value)
    except ValueError as error:
        raise TypeError(f"{name} must hold numbers in rows of equal length; {error}.") from error
    if raw.dtype.kind not in "iuf" and raw.size:
        raise TypeError(f"{name} must hold real numbers; got {value!r}.")
    numbers = raw.astype(np.float64)
    if not np.isfinite(numbers).all():
        where = [int(i) for i in np.argwhere(~np.isfinite(numbers))[0]]
        found = f"{name}{where if where else ''} is {numbers[tuple(where)]}"
        raise ValueError(f"{name} must be finite; {found}. Remove or replace it.")
    return numbers


def as_count(name: str, value: Any) -> int:
    """Return `value` as a whole number of 1 at least."""
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} must be a whole number; got {value!r}.") from None
    if number < 1:
        raise ValueError(f"{name} must be 1 at least; got {number}.")
    return number


def as_generator(rng: Any) -> np.random.Generator:
    """Return `rng` as a generator of random numbers."""
    try:
        return np.random.default_rng(rng)
    except (TypeError, ValueError) as error:
        raise type(error)(
            f"rng must be a seed, a whole number of 0 at least, or a numpy Generator; got {rng!r}."
        ) from error


def as_positive(name: str, value: ArrayLike) -> float:
    """Return `value` as a positive float."""
    number = as_numbers(name, value)
    if number.ndim or number <= 0:
        raise ValueError(f"{name} must be one positive number; got {value!r}.")
    return float(number)


def as_points(name: str, value: ArrayLike, dim: int) -> Points:
    """Return `value` as an array of points of shape (n, dim)."""
    points = as_numbers(name, value)
    if points.size == 0:
        points = points.reshape(-1, dim)
    if points.ndim != 2 or points.shape[1] != dim:
        raise ValueError(
            f"{name} must have the shape (n, {dim}), one point a row; got {points.shape}."
        )
    return points


def as_values(name: str, value: ArrayLike, least: int = 2) -> Points:
    """Return `value` as an array of values on a grid: 1 to 3 axes, `least` nodes along each."""
    values = as_numbers(name, value)
    if not 1 <= values.ndim <= 3:
        raise ValueError(
            f"{name} must be an array of values on a grid, with one, two or three axes; got the "
            f"shape {values.shape}. Sample a field with field(grid.points)."
        )
    if min(values.shape) < least:
        raise ValueError(
            f"{name} must have {least} nodes at least along each axis, for so many meet in a "
            f"difference; got the shape {values.shape}. Take a finer grid."
        )
    return values


def as_spacing(dx: ArrayLike, dim: int) -> tuple[float, ...]:
    """Return `dx` as one positive spacing for each axis."""
    steps = as_numbers("dx", dx)
    if steps.shape not in ((), (dim,)):
        raise ValueError(
            f"dx must be one number or one for each of the {dim} axes of phi; got the shape "
            f"{steps.shape}."
        )
    steps = np.broadcast_to(steps, (dim,))
    if not (steps > 0).all():
        axis = int(np.argmin(steps > 0))
        raise ValueError(f"dx must be positive; along axis {axis} it is {steps[axis]:g}.")
    return tuple(float(step) for step in steps)


def as_speed(speed: ArrayLike, shape: tuple[int, ...]) -> Points:
    """Return a speed as an array, a number or of the given shape, or say what is wrong with it."""
    values = as_numbers("speed", speed)
    if values.shape not in ((), shape):
        raise ValueError(f"speed must be a number or have phi's shape {shape}; got {values.shape}.")
    return values


def as_level_set(phi: Points) -> Points:
    """Return phi, or say that it has no interface."""
    if phi.min() >= 0 or phi.max() < 0:
        raise ValueError(
            "phi must have an interface: nodes where it is negative, and nodes where it is not; "
            f"its values lie between {phi.min():g} and {phi.max():g}. Shift it by the level you "
            "want, or make the box larger."
        )
    return phi


def as_boundary(boundary: Any) -> Any:
    """Return `boundary`, or say that it is no padding function."""
    if not callable(boundary):
        raise TypeError(
            "boundary must be a padding function, extrapolated, neumann or periodic itself, or one "
            f"with their signature; got {boundary!r}."
        )
    return boundary


def as_time(time: ArrayLike) -> float:
    """Return `time` as a number of zero or more."""
    number = as_numbers("time", time)
    if number.ndim or number < 0:
        raise ValueError(
            f"time must be one number, zero or more; got {time!r}. To go back in time, reverse the "
            "velocity or the speed."
        )
    return float(number)


def as_cfl(cfl: ArrayLike, differences: Any) -> float:
    """Return `cfl` as a CFL number for which the steps of a scheme are stable."""
    number, limit = as_positive("cfl", cfl), getattr(differences, "cfl", 1.0)
    if number > limit:
        name = getattr(differences, "__name__", "this scheme")
        raise ValueError(
            f"cfl must not be above {limit:g} with {name}; got {number:g}. In longer steps errors "
            "grow without bound."
        )
    return number


def as_bbox(bbox: ArrayLike, dim: int | None = None) -> Points:
    """Return `bbox` as an array of two rows, the lower corner and the upper one."""
    box = as_numbers("bbox", bbox)
    if box.ndim != 2 or box.shape[0] != 2 or (dim is not None and box.shape[1] != dim):
        wanted = "((xmin, ymin), (xmax, ymax))" if dim in (2, None) else f"two rows of {dim}"
        raise ValueError(f"bbox must be {wanted}; got the shape {box.shape}.")
    if not (box[0] < box[1]).all():
        axis = int(np.argmin(box[0] < box[1]))
        raise ValueError(
            "bbox must hold the lower corner, then the upper one, ((xmin, ymin), (xmax, ymax)); "
            f"along axis {axis} it runs from {box[0, axis]:g} to {box[1, axis]:g}."
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
    """Return the field's values at points of shape (..., dim), checked: shape (...) and finite."""
    lent = points.view()
    lent.flags.writeable = False  # a field that changes its argument fails in its own line
    values = np.asarray(field(lent))
    if values.shape != points.shape[:-1]:
        raise ValueError(
            f"{name} must return one value a point: it was given points of shape "
            f"{points.shape} and returned the shape {values.shape}. Compute with p[..., 0] "
            "and p[..., 1], and keep the leading shape."
        )
    if values.dtype.kind not in "iuf":
        raise TypeError(f"{name} must return real numbers; it returned the type {values.dtype}.")
    if not np.isfinite(values).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(values))[0])
        raise ValueError(
            f"{name} must be finite; it returned {values[where]} at {points[where].tolist()}. "
            "Give it a value there, or keep the box away from that point."
        )
    return values.astype(np.float64)
