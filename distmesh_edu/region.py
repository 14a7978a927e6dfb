"""What is to be meshed: the fields, the sizes and the box, checked before anything is computed."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from ._validation import Points, as_bbox, as_field, as_points, as_positive, evaluate

__all__ = ["Region"]

LATTICE_LIMIT = 5e7
"""Points of the first lattice: a gigabyte or two. Beyond, h0 is a slip rather than a wish."""


@dataclass(frozen=True)
class Region:
    """What is to be meshed: the fields, checked whenever they are asked, and the sizes.

    Parameters
    ----------
    fd : Field, length
        Negative inside.
    fh : Field or None, relative size
        The wanted edges; None is uniform.
    h0 : float, length
        The smallest edges.
    bbox : ndarray of shape (2, dim), length
        The lower corner of a box around the region, and the upper one.
    pfix : ndarray of shape (k, dim), length
        The fixed points, none of them twice.
    tolerance : float, dimensionless
        How far outside a point may lie and still count as inside, in units of h0.
    """

    fd: Callable[[Points], Points]
    fh: Callable[[Points], Points] | None
    h0: float
    bbox: Points
    pfix: Points
    tolerance: float

    @property
    def geps(self) -> float:
        """How far outside a point may lie and still count as inside (length)."""
        return self.tolerance * self.h0

    def distance(self, p: Points) -> Points:
        """Return fd at the points, one value each, or say what is wrong with it."""
        return evaluate("fd", self.fd, p)

    def inside(self, p: Points) -> NDArray[np.bool_]:
        """Return which points lie inside, or nearly so, and not on a fixed point.

        Those far beyond the box never do: an interpolated distance may mean nothing there. Refuse
        a region with fewer than one simplex needs, and a field that is no length.
        """
        beyond = np.maximum(self.bbox[0] - p, p - self.bbox[1]).max(axis=1) > self.h0 / 2
        within = (self.distance(p) < self.geps) & ~beyond
        kept = within
        if len(self.pfix):
            gap, _ = cKDTree(self.pfix).query(p)
            kept = within & (gap > 1e-6 * self.h0)
        if kept.sum() + len(self.pfix) <= p.shape[1]:
            raise ValueError(
                f"fd leaves {kept.sum()} points inside of a lattice of side h0 = {self.h0:g} in "
                "the box: the region is empty, thinner than h0, or elsewhere. Take a smaller h0, "
                "check bbox, or pass complement(fd) if fd is positive inside."
            )
        _check_slope(self.slope(p[within]))
        return np.asarray(kept)

    def slope(self, p: Points) -> float:
        """Return about how long the gradient of fd is near its zeros: 1 for a distance."""
        nearest = p[np.argsort(np.abs(self.distance(p)))[:20]]
        steps = self.h0 / 10 * np.eye(p.shape[1])
        rises = [self.distance(nearest + e) - self.distance(nearest - e) for e in steps]
        return float(np.median(np.linalg.norm(rises, axis=0))) / (self.h0 / 5)

    def in_lengths(self, p: Points) -> "Region":
        """Return the region with fd divided by its slope, if that is far from 1.

        Whatever compares fd with edges then does what it does for a distance.
        """
        slope = self.slope(p)
        if 0.5 < slope < 2:  # at corners a distance's own may be 0.6
            return self
        return replace(self, fd=lambda q: self.distance(q) / slope)

    def size(self, p: Points) -> Points:
        """Return fh at the points, one positive value each, or say what is wrong with it."""
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
    fd: Any,
    fh: Any,
    h0: float,
    bbox: ArrayLike,
    pfix: ArrayLike | None,
    dim: int,
    tolerance: float = 1e-3,
    *,
    fills: bool = True,
) -> Region:
    """Return what is to be meshed, or say which argument makes no sense.

    `fills` says whether the mesh starts from a lattice of side h0 in all of the box.
    """
    region = Region(
        as_field("fd", fd),
        None if fh is None else as_field("fh", fh),
        as_positive("h0", h0),
        as_bbox(bbox, dim),
        np.empty((0, dim)) if pfix is None else as_points("pfix", pfix, dim),
        tolerance,
    )
    _check_size(region, fills)
    _check_box(region)
    _check_fixed_points(region)
    return region


def _check_size(region: Region, fills: bool) -> None:
    """Refuse a box smaller than h0, and an h0 so small that no memory would hold the lattice."""
    sides = region.bbox[1] - region.bbox[0]
    if region.h0 > sides.min():
        raise ValueError(
            f"h0 must not be larger than the box; h0 = {region.h0:g}, and the box measures "
            f"{' by '.join(f'{side:g}' for side in sides)}."
        )
    points = (sides / region.h0).prod()
    if fills and points > LATTICE_LIMIT:
        raise ValueError(
            f"h0 = {region.h0:g} would fill the box with {points:.1e} points, more than "
            f"{LATTICE_LIMIT:.0e}. Take a larger h0, or a box closer to the region."
        )


def _check_box(region: Region) -> None:
    """Refuse a box whose rim, sampled every h0, cuts the region."""
    rim = _rim(region.bbox, region.h0)
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


def _rim(bbox: Points, h0: float) -> Points:
    """Return points every h0 on the sides of a box."""
    sides = []
    for axis in range(bbox.shape[1]):
        lines = [np.linspace(a, b, int(np.ceil((b - a) / h0)) + 1) for a, b in bbox.T]
        lines[axis] = bbox[:, axis]
        sides.append(np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1))
    return np.concatenate([side.reshape(-1, bbox.shape[1]) for side in sides])


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


def _check_slope(slope: float) -> None:
    """Refuse an fd that is far from a length: the tolerances compare it with h0."""
    if not 0.02 < slope < 50:
        raise ValueError(
            f"fd must be a distance, or nearly so: near its zeros its gradient should have a "
            f"length of about 1, and has {slope:.2g}. Divide fd by that."
        )
