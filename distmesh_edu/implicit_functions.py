"""Shapes as fields: functions that are negative inside, zero on the boundary, positive outside."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ._types import ArrayLike, Field, FloatArray, IntArray
from ._validation import as_bbox, as_field, as_numbers, as_points, as_positive

_CANDIDATES = 500_000  # pairs of points and pieces compared at once, to bound the memory
_SPREAD = 64.0  # how much longer the longest side in a tree may be than the shortest
_BLOCK = 16_384  # points of a polygon's distance worked on at once: their arrays stay in the cache


def circle(center: ArrayLike = (0.0, 0.0), radius: float = 1.0) -> Field:
    """Return the signed distance |x - center| - radius to a circle.

    Parameters
    ----------
    center : array_like of shape (2,), length
        The circle's center.
    radius : float, length
        Its radius.

    Returns
    -------
    Field
        Exact everywhere; it has no gradient at the center.

    Raises
    ------
    ValueError
        If `radius` is not positive or `center` is not one point.

    Examples
    --------
    >>> circle()(np.array([[0.0, 0.0], [2.0, 0.0]]))
    array([-1.,  1.])
    """
    middle, r = as_numbers("center", center), as_positive("radius", radius)
    if middle.shape != (2,):
        raise ValueError(f"center must be one point (x, y); got the shape {middle.shape}.")

    def distance(p: FloatArray) -> FloatArray:
        return np.asarray(np.hypot(p[..., 0] - middle[0], p[..., 1] - middle[1]) - r)

    return distance


def rectangle(bbox: ArrayLike) -> Field:
    """Return the signed distance to an axis-parallel rectangle.

    Parameters
    ----------
    bbox : array_like of shape (2, 2), length
        The corners ((xmin, ymin), (xmax, ymax)).

    Returns
    -------
    Field
        Exact everywhere, beyond the corners too, where max(|x| - a, |y| - b) is too small.

    Raises
    ------
    ValueError
        If the lower corner is not below and left of the upper one.

    Notes
    -----
    With q = |x - center| - half widths, the distance is |max(q, 0)| + min(max(q_x, q_y), 0):
    the first term acts outside, the second inside.

    Examples
    --------
    >>> rectangle(((-1, -1), (1, 1)))(np.array([[0.0, 0.0], [4.0, 5.0]]))
    array([-1.,  5.])
    """
    lower, upper = as_bbox(bbox, dim=2)
    center, half = (lower + upper) / 2, (upper - lower) / 2

    def distance(p: FloatArray) -> FloatArray:
        q = np.abs(p - center) - half
        outside = np.linalg.norm(np.maximum(q, 0), axis=-1)
        return np.asarray(outside + np.minimum(q.max(axis=-1), 0))

    return distance


def union(*fields: Field) -> Field:
    """Return min(d1, d2, ...): the points that lie in one of the regions at least.

    Parameters
    ----------
    *fields : Field
        Signed distances, or other functions that are negative inside.

    Returns
    -------
    Field
        The right sign everywhere. Of exact distances it is exact outside; inside, its size is
        only a lower bound of the distance.

    Raises
    ------
    TypeError
        If one of `fields` cannot be called, or there is none.

    Examples
    --------
    >>> union(circle(), circle((3, 0)))(np.array([[1.5, 0.0]]))
    array([0.5])
    """
    parts = _parts("union", fields)
    return lambda p: np.minimum.reduce([part(p) for part in parts])


def intersection(*fields: Field) -> Field:
    """Return max(d1, d2, ...): the points that lie in every region.

    Parameters
    ----------
    *fields : Field
        Signed distances, or other functions that are negative inside.

    Returns
    -------
    Field
        The right sign everywhere. Of exact distances it is exact inside; outside, it is only a
        lower bound of the distance.

    Raises
    ------
    TypeError
        If one of `fields` cannot be called, or there is none.

    Examples
    --------
    >>> intersection(circle(), circle((1, 0)))(np.array([[0.5, 0.0]]))
    array([-0.5])
    """
    parts = _parts("intersection", fields)
    return lambda p: np.maximum.reduce([part(p) for part in parts])


def difference(region: Field, *holes: Field) -> Field:
    """Return max(d, -d1, -d2, ...): the points of a region that lie in none of the holes.

    Parameters
    ----------
    region : Field
        Negative inside the region.
    *holes : Field
        Negative inside what is taken away.

    Returns
    -------
    Field
        The right sign everywhere. Of exact distances it is exact inside; outside (in a hole,
        too) it is only a lower bound of the distance.

    Raises
    ------
    TypeError
        If an argument cannot be called, or there is no hole.

    Examples
    --------
    >>> difference(circle(), circle(radius=0.5))(np.array([[0.6, 0.0], [0.0, 0.0]]))
    array([-0.1,  0.5])
    """
    first, *rest = _parts("difference", (region, *holes), least=2)
    return intersection(first, *(complement(hole) for hole in rest))


def complement(field: Field) -> Field:
    """Return -d: inside and outside change places.

    Parameters
    ----------
    field : Field
        Negative inside.

    Returns
    -------
    Field
        As exact as `field`.

    Raises
    ------
    TypeError
        If `field` cannot be called.

    Examples
    --------
    >>> complement(circle())(np.array([[0.0, 0.0]]))
    array([1.])
    """
    part = as_field("field", field)
    return lambda p: -part(p)


def polygon(vertices: ArrayLike, holes: Sequence[ArrayLike] = ()) -> Field:
    """Return the signed distance to a polygon, which may have holes.

    Parameters
    ----------
    vertices : array_like of shape (n, 2), length
        The corners in order, either way round. A last corner equal to the first is dropped.
    holes : sequence of array_like of shape (m, 2), length
        The corners of each hole.

    Returns
    -------
    Field
        Exact everywhere. Memory grows with the number of points, not with points times corners.

    Raises
    ------
    ValueError
        If a ring has fewer than three corners, a corner twice in a row, or a NaN; if rings cross
        or (up to rounding) touch themselves or one another; or if a hole lies outside, or in
        another hole.

    Notes
    -----
    The distance is the least over all sides, found with a k-d tree. The sign at a point whose
    closest point lies within a side is that of the side's normal; where it is a corner, that of
    the sum of the two unit normals there [BaerentzenAanaes2005]_, which holds at corners however
    sharp.

    Examples
    --------
    >>> square = polygon([(0, 0), (4, 0), (4, 4), (0, 4)], holes=[[(1, 1), (2, 1), (2, 2)]])
    >>> square(np.array([[3.0, 3.0], [7.0, 8.0], [1.75, 1.25]]))
    array([-1.  ,  5.  ,  0.25])
    """
    rings = _rings(vertices, holes)
    sides = _Sides(rings)
    crossing = sides.first_crossing()
    if crossing is not None:
        raise ValueError(
            "vertices: the polygon crosses or touches itself: the sides that start at "
            f"{crossing[0].tolist()} and {crossing[1].tolist()} meet. Separate them, or give "
            "the parts as polygons of their own and take their union."
        )
    _check_nesting(rings)

    def distance(p: FloatArray) -> FloatArray:
        points = np.asarray(p, dtype=np.float64)
        if points.shape[-1:] != (2,):
            raise ValueError(f"p must have the shape (..., 2); got {points.shape}.")
        rows = points.reshape(-1, 2)
        blocks = np.array_split(rows, len(rows) // _BLOCK + 1)
        values = np.concatenate([sides.signed_distance(block) for block in blocks])
        return np.asarray(values.reshape(points.shape[:-1]))

    return distance


def polygon_area(vertices: ArrayLike, holes: Sequence[ArrayLike] = ()) -> float:
    """Return the area of a polygon less that of its holes, by the shoelace formula.

    Parameters
    ----------
    vertices : array_like of shape (n, 2), length
        The corners in order, either way round.
    holes : sequence of array_like of shape (m, 2), length
        The corners of each hole.

    Returns
    -------
    float
        The area, length squared.

    Raises
    ------
    ValueError
        If a ring has fewer than three corners, a corner twice in a row, or a NaN.

    Examples
    --------
    >>> polygon_area([(0, 0), (4, 0), (4, 4), (0, 4)], holes=[[(1, 1), (2, 1), (2, 2)]])
    15.5
    """
    return sum(_signed_area(ring) for ring in _rings(vertices, holes))


def _parts(name: str, fields: Sequence[Field], least: int = 1) -> list[Field]:
    if len(fields) < least:
        raise TypeError(f"{name} takes {least} or more fields; got {len(fields)}.")
    return [as_field(f"argument {number} of {name}", f) for number, f in enumerate(fields, 1)]


def _signed_area(ring: FloatArray) -> float:
    x, y = (ring - ring[0]).T  # about a corner: far from the origin the products would cancel
    return float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def _rings(vertices: ArrayLike, holes: Sequence[ArrayLike]) -> list[FloatArray]:
    """Return the rings with the region on their left: outer one anticlockwise, holes clockwise."""
    if len(holes) and np.ndim(holes[0]) == 1:
        raise ValueError("holes must be a list of rings; got one ring. Write holes=[ring].")
    rings = []
    named = [("vertices", vertices), *((f"holes[{k}]", hole) for k, hole in enumerate(holes))]
    for name, corners in named:
        ring = as_points(name, corners, dim=2)
        if len(ring) > 1 and _same(ring[0], ring[-1], ring):
            ring = ring[:-1]
        if len(ring) < 3:
            raise ValueError(f"{name} must have three corners at least; got {len(ring)}.")
        twice = _same(ring, np.roll(ring, -1, axis=0), ring)
        if twice.any():
            raise ValueError(
                f"{name} has the corner {ring[int(np.argmax(twice))].tolist()} twice in a row. "
                "Remove one."
            )
        region_on_left = (_signed_area(ring) > 0) == (name == "vertices")
        rings.append(ring if region_on_left else ring[::-1])
    return rings


def _same(a: FloatArray, b: FloatArray, ring: FloatArray) -> NDArray[np.bool_]:
    """Say which points are equal up to rounding: a ring closed by a cosine of 2 pi is closed."""
    rounding = 1e-12 * np.ptp(ring, axis=0).max() + 4 * np.spacing(np.abs(ring).max())
    return np.asarray(np.linalg.norm(a - b, axis=-1) <= rounding)


def _check_nesting(rings: Sequence[FloatArray]) -> None:
    """Refuse a hole outside, or in another hole; no rings cross, so that one corner tells."""
    outer, *holes = rings
    regions = [_Sides([outer])] + [_Sides([hole[::-1]]) for hole in holes]
    for k, hole in enumerate(holes):
        inside = [region.signed_distance(hole[:1])[0] < 0 for region in regions]
        if not inside[0]:
            raise ValueError(
                f"holes[{k}] must lie inside the polygon; its corner {hole[0].tolist()} does "
                "not. Check the order of the arguments."
            )
        others = [m for m in range(len(holes)) if m != k and inside[m + 1]]
        if others:
            raise ValueError(
                f"holes[{k}] lies inside holes[{others[0]}]. Remove it, or, if it is an island "
                "in the hole, take the union with a polygon of its own."
            )


class _Sides:
    """The sides of some closed rings, in a k-d tree that finds the one closest to a point."""

    def __init__(self, rings: Sequence[FloatArray]) -> None:
        self.start = np.concatenate(rings)
        self.end = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
        self.vector = self.end - self.start
        self.length = np.hypot(*self.vector.T)
        outward = self.vector[:, ::-1] * (1, -1) / self.length[:, None]
        before = np.concatenate([np.roll(r, 1) for r in _numbers_per_ring(rings)])
        after = np.concatenate([np.roll(r, -1) for r in _numbers_per_ring(rings)])
        # The normal that decides the sign where a side starts, within it, and where it ends.
        self.normals = np.stack([outward + outward[before], outward, outward + outward[after]])
        self.after: IntArray = after

        level = np.floor(np.log(self.length.max() / self.length) / np.log(_SPREAD))
        self.trees = [self._tree(np.flatnonzero(level == one)) for one in np.unique(level)]

    def _tree(self, sides: IntArray) -> tuple[cKDTree, IntArray, float]:
        """Cut sides into pieces; return a tree of their middles, their sides, half the longest.

        Middles bound the distance to the pieces well only if these are short and of like length.
        """
        length = self.length[sides]
        pieces = np.ceil(length / (2 * length.mean())).astype(np.int64)
        owner = np.repeat(sides, pieces)
        number = np.arange(len(owner)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        fraction = (number + 0.5) / np.repeat(pieces, pieces)
        tree = cKDTree(self.start[owner] + fraction[:, None] * self.vector[owner])
        return tree, owner, float((length / pieces).max()) / 2

    def signed_distance(self, p: FloatArray) -> FloatArray:
        """Return the signed distance at points of shape (n, 2)."""
        side = self.closest(p)
        t, offset = self.offset(p, side)
        place = (t > 0).astype(np.int64) + (t >= 1)
        distance = np.hypot(offset[:, 0], offset[:, 1])
        along_normal = (offset * self.normals[place, side]).sum(axis=1)
        return np.asarray(np.copysign(distance, along_normal))

    def closest(self, p: FloatArray) -> IntArray:
        """Return the number of the side closest to each point."""
        side = np.zeros(len(p), dtype=np.int64)
        least = np.full(len(p), np.inf)
        for tree, owner, half_piece in self.trees:
            unsure, k = np.arange(len(p)), 8
            while unsure.size:
                k = min(k, tree.n)
                missed = []
                for which in np.array_split(unsure, unsure.size * k // _CANDIDATES + 1):
                    found = tree.query(p[which], k=k)
                    reach, piece = (one.reshape(-1, k) for one in found)  # k = 1 gives a row
                    self._improve(p, which, owner[piece], side, least)
                    # No piece beyond the k-th is closer than its middle, as far at least, allows.
                    missed.append(least[which] > reach[:, -1] - half_piece)
                unsure = unsure[np.concatenate(missed) & (k < tree.n)]
                k *= 2
        return side

    def _improve(
        self, p: FloatArray, which: IntArray, sides: IntArray, side: IntArray, least: FloatArray
    ) -> None:
        """Where one of some sides is closer to a point than the closest so far, write it down."""
        _, offset = self.offset(p[which, None], sides)
        distance = np.hypot(offset[..., 0], offset[..., 1])
        best = distance.argmin(axis=1)[:, None]
        distance = np.take_along_axis(distance, best, axis=1)[:, 0]
        closer = distance < least[which]
        least[which[closer]] = distance[closer]
        side[which[closer]] = np.take_along_axis(sides, best, axis=1)[closer, 0]

    def offset(self, p: FloatArray, side: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return where on a side (0 start, 1 end) its point closest to p is, and the way to p."""
        along, vector = p - self.start[side], self.vector[side]
        t = np.clip((along * vector).sum(axis=-1) / self.length[side] ** 2, 0, 1)
        return t, along - t[..., None] * vector

    def first_crossing(self) -> tuple[FloatArray, FloatArray] | None:
        """Return the starts of two sides that meet elsewhere than at a common corner, or None."""
        x = np.sort(np.stack((self.start[:, 0], self.end[:, 0])), axis=0)
        order = np.argsort(x[0])
        ahead = np.searchsorted(x[0][order], x[1][order], side="right")
        for k, i in enumerate(order):
            j = order[k + 1 : ahead[k]]  # the sides that begin, from left to right, before i ends
            neighbour = (self.after[j] == i) | (self.after[i] == j)
            meets = np.where(neighbour, self._folds_back(i, j), self._meets(i, j))
            if meets.any():
                return self.start[i], self.start[j[int(np.argmax(meets))]]
        return None

    def _meets(self, i: int, j: IntArray) -> NDArray[np.bool_]:
        """Say which sides j have a point in common with side i."""
        a, b, c, d = self.start[i], self.end[i], self.start[j], self.end[j]
        apart = (np.maximum(a, b) < np.minimum(c, d)) | (np.maximum(c, d) < np.minimum(a, b))
        split_by_i = _side(b - a, c - a) * _side(b - a, d - a) <= 0
        split_by_j = _side(d - c, a - c) * _side(d - c, b - c) <= 0
        return np.asarray(~apart.any(axis=1) & split_by_i & split_by_j)

    def _folds_back(self, i: int, j: IntArray) -> NDArray[np.bool_]:
        """Say which sides j, neighbours of i, run back along it."""
        u, v = self.vector[i], self.vector[j]
        return np.asarray((_side(u, v) == 0) & ((u * v).sum(axis=-1) < 0))


def _numbers_per_ring(rings: Sequence[FloatArray]) -> list[IntArray]:
    sizes = [len(ring) for ring in rings]
    return np.split(np.arange(sum(sizes)), np.cumsum(sizes)[:-1])


def _side(u: FloatArray, v: FloatArray) -> FloatArray:
    """Return 1 where v points to the left of u, -1 where to the right, 0 along it."""
    return np.asarray(np.sign(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]))
