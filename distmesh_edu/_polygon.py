"""The sides of a polygon: checked, and searched for the one closest to a point."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_CANDIDATES = 500_000  # pairs of points and pieces compared at once, to bound the memory
_SPREAD = 64.0  # how much longer the longest side in a tree may be than the shortest
_BLOCK = 16_384  # points worked on at once: their arrays stay in the cache


def signed_area(ring: FloatArray) -> float:
    """Return the area of a ring, negative where it runs clockwise."""
    x, y = (ring - ring[0]).T  # about a corner: far from the origin the products would cancel
    return float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def oriented(name: str, ring: FloatArray) -> FloatArray:
    """Return a ring, checked, with the region on its left: clockwise if it is a hole."""
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
    region_on_left = (signed_area(ring) > 0) == (name == "vertices")
    return ring if region_on_left else ring[::-1]


def _same(a: FloatArray, b: FloatArray, ring: FloatArray) -> NDArray[np.bool_]:
    """Say which points are equal up to rounding: a ring closed by a cosine of 2 pi is closed."""
    rounding = 1e-12 * np.ptp(ring, axis=0).max() + 4 * np.spacing(np.abs(ring).max())
    return np.asarray(np.linalg.norm(a - b, axis=-1) <= rounding)


def check_nesting(rings: Sequence[FloatArray]) -> None:
    """Refuse a hole outside, or in another hole; no rings cross, so that one corner tells."""
    outer, *holes = rings
    regions = [Sides([outer])] + [Sides([hole[::-1]]) for hole in holes]
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


class Sides:
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

    def distance(self, p: FloatArray) -> FloatArray:
        """Return the signed distance at points of shape (..., 2)."""
        points = np.asarray(p, dtype=np.float64)
        if points.shape[-1:] != (2,):
            raise ValueError(f"p must have the shape (..., 2); got {points.shape}.")
        rows = points.reshape(-1, 2)
        blocks = np.array_split(rows, len(rows) // _BLOCK + 1)
        values = np.concatenate([self.signed_distance(block) for block in blocks])
        return np.asarray(values.reshape(points.shape[:-1]))

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

    def check_crossing(self) -> None:
        """Refuse sides that meet elsewhere than at a common corner."""
        crossing = self.first_crossing()
        if crossing is not None:
            raise ValueError(
                "vertices: the polygon crosses or touches itself: the sides that start at "
                f"{crossing[0].tolist()} and {crossing[1].tolist()} meet. Separate them, or give "
                "the parts as polygons of their own and take their union."
            )

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
