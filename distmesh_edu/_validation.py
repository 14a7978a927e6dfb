"""What every public door asks of its arguments: each error names one, its value, and a remedy."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

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


@dataclass(frozen=True)
class Region:
    """What is to be meshed: the fields, checked whenever they are asked, and the sizes."""

    fd: Callable[[Points], Points]
    fh: Callable[[Points], Points] | None
    h0: float
    bbox: Points
    pfix: Points

    @property
    def geps(self) -> float:
        """How far outside a point may lie and still count as inside (length)."""
        return 1e-3 * self.h0

    def distance(self, p: Points) -> Points:
        return evaluate("fd", self.fd, p)

    def size(self, p: Points) -> Points:
        if self.fh is None:
            return np.ones(len(p))
        h = evaluate("fh", self.fh, p)
        if h.size and h.min() <= 0:
            raise ValueError(
                f"fh must be positive wherever the mesh goes; it is {h.min():g} at "
                f"{p[int(h.argmin())].tolist()}. Bound it from below, as in "
                "lambda p: np.maximum(fh(p), smallest)."
            )
        return h


def as_region(
    fd: Any, fh: Any, h0: float, bbox: ArrayLike, pfix: ArrayLike | None, dim: int
) -> Region:
    """Return what is to be meshed, or say which argument makes no sense."""
    region = Region(
        as_field("fd", fd),
        None if fh is None else as_field("fh", fh),
        as_positive("h0", h0),
        as_bbox(bbox, dim),
        np.empty((0, dim)) if pfix is None else as_points("pfix", pfix, dim),
    )
    _check_box(region)
    _check_fixed_points(region)
    return region


def _check_box(region: Region) -> None:
    """Refuse a box smaller than h0, and one that the region sticks out of."""
    lower, upper = region.bbox
    if region.h0 > (upper - lower).min():
        raise ValueError(
            f"h0 must be smaller than the box; h0 = {region.h0:g}, and the box measures "
            f"{' by '.join(f'{side:g}' for side in upper - lower)}."
        )
    counts = np.ceil((upper - lower) / region.h0).astype(int) + 1
    x, y = (np.linspace(a, b, n) for a, b, n in zip(lower, upper, counts, strict=True))
    rim = np.concatenate(
        [np.stack((x, np.full_like(x, side)), axis=1) for side in (lower[1], upper[1])]
        + [np.stack((np.full_like(y, side), y), axis=1) for side in (lower[0], upper[0])]
    )
    d = region.distance(rim)
    # Less than half a triangle beyond the box does no harm: the truss grows into it.
    if d.min() < -region.h0 / 2:
        where = rim[int(d.argmin())].tolist()
        everywhere = bool((d < region.geps).all())
        remedy = (
            "It is nowhere positive on the box's rim: pass complement(fd) if its sign is "
            "flipped, or else widen the box."
            if everywhere
            else "Widen the box until the region lies inside it."
        )
        raise ValueError(f"bbox cuts the region: fd is {d.min():g} at {where}. {remedy}")


def _check_fixed_points(region: Region) -> None:
    """Refuse a fixed point outside the region, and one given twice."""
    pfix = region.pfix
    if not len(pfix):
        return
    d = region.distance(pfix)
    # A distance interpolated on a grid is off by a little at corners: allow a fifth of h0.
    if d.max() > 0.2 * region.h0:
        where = pfix[int(d.argmax())].tolist()
        raise ValueError(
            f"pfix must lie in the region or on its boundary; {where} is {d.max():g} outside. "
            "Move it there, or remove it."
        )
    close = cKDTree(pfix).query_pairs(1e-6 * region.h0)
    if close:
        i, j = min(close)
        raise ValueError(
            f"pfix gives the point {pfix[i].tolist()} twice, in rows {i} and {j}. Remove one."
        )
