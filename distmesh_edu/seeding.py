"""Where the nodes of a mesh start: on a lattice that is coarse where edges are to be long.

Or where those of an earlier mesh ended, with the lattice's in the gaps.
"""

from itertools import product

import numpy as np
from scipy.spatial import cKDTree

from ._types import BoolArray, FloatArray
from .region import Region

__all__ = ["reseeded", "seeds"]

#: Rows that span a lattice whose edges are 1 long on average: intervals, equilateral triangles,
#: and in space the body-centred cubes, whose tetrahedra are far better than those of cubes.
LATTICES = {
    1: np.array([[1.0]]),
    2: np.array([[1.0, 0.0], [0.5, np.sqrt(3) / 2]]),
    3: 1.098 * np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 0.5]]),
}

#: Of two nodes nearer to each other than this share of the edges there, one goes; of two nearer
#: than the second, one goes while there are more nodes than the lattice has.
CROWDED, NEAR = 0.65, 0.9
#: A lattice point farther than this share of an edge from every node comes in; one farther than
#: the second while there are fewer. In a mesh of equilateral triangles the farthest points, their
#: centres, are 0.58 of an edge away.
GAP, ROOM = 0.7, 0.5

#: Points of one level of the lattice: no mesh of so many nodes would ever be done.
POINTS_LIMIT = 1e7


def seeds(region: Region, rng: np.random.Generator) -> FloatArray:
    """Return the nodes to start from, the fixed ones first: a lattice, coarse where edges are long.

    A coarse lattice is refined where the wanted edges are shorter than its own, or unknown because
    the boundary is near; one halving of the vectors that span it makes 2**dim points of each. What
    a level still has too many is thinned out evenly.

    Parameters
    ----------
    region : Region
    rng : numpy.random.Generator
        Shifts the thinning.

    Returns
    -------
    ndarray of shape (n, dim), length

    Raises
    ------
    ValueError
        If fewer nodes are left than one simplex needs, or there would be far too many.

    Examples
    --------
    >>> from distmesh_edu import circle
    >>> from distmesh_edu.region import as_region
    >>> disc = as_region(circle(), None, 0.2, ((-1, -1), (1, 1)), None, dim=2)
    >>> seeds(disc, np.random.default_rng(0)).shape
    (88, 2)
    """
    dim = region.bbox.shape[1]
    sides = region.bbox[1] - region.bbox[0]
    level = 0 if region.fh is None else max(0, int(np.log2(sides.max() / region.h0)) - 2)
    span = LATTICES[dim] * region.h0 * 2**level
    halves = np.array(list(product((0.0, 0.5), repeat=dim)))
    p, leaves, smallest = _cover(region.bbox, span), [], np.inf
    while level:
        p = p[_may_meet(p, span, region)]
        h = np.minimum(_size_inside(p, region), _size_inside(p + span.sum(axis=0) / 2, region))
        smallest = min(smallest, h.min(initial=np.inf))
        refine = np.isinf(h) | (h < 2**level * smallest)
        _check_count(refine.sum() * len(halves), region)
        leaves.append((p[~refine], level))
        p = (p[refine, None] + halves @ span).reshape(-1, dim)
        span, level = span / 2, level - 1
    leaves.append((p, 0))
    return np.concatenate((region.pfix, _thinned(leaves, region, rng)))


def reseeded(p: FloatArray, region: Region, rng: np.random.Generator) -> FloatArray:
    """Return the nodes of an earlier mesh made ready for a region, the fixed ones first.

    Where they are crowded some go; where they leave gaps points of the lattice come in. How many
    there are in all stays near what the lattice has, or the density would drift from step to step.

    Parameters
    ----------
    p : ndarray of shape (n, dim), length
        Nodes in the region or on its boundary.
    region : Region
    rng : numpy.random.Generator
        For the lattice: see `seeds`.

    Returns
    -------
    ndarray of shape (m, dim), length

    Raises
    ------
    ValueError
        As `seeds` does.

    Examples
    --------
    >>> from distmesh_edu import circle
    >>> from distmesh_edu.region import as_region
    >>> disc = as_region(circle(), None, 0.2, ((-1, -1), (1, 1)), None, dim=2)
    >>> half = np.array([[0.0, 0.2], [0.0, 0.4], [0.0, 0.42]])
    >>> len(reseeded(half, disc, np.random.default_rng(0)))
    88
    """
    lattice = seeds(region, rng)
    scale = region.h0 / region.size(lattice).min()
    p = np.concatenate((region.pfix, p))
    p = _uncrowded(p, scale * region.size(p), len(region.pfix), len(p) - len(lattice))
    gap, _ = cKDTree(p).query(lattice)
    gap /= scale * region.size(lattice)
    lack = min(len(lattice) - len(p), (gap > ROOM).sum())
    filling = np.argsort(-gap, kind="stable")[: max(lack, (gap > GAP).sum())]
    return np.concatenate((p, lattice[filling]))


def _uncrowded(p: FloatArray, edge: FloatArray, fixed: int, surplus: int) -> FloatArray:
    """Return the points without the later one of each crowded pair, the closest pairs first."""
    pairs = cKDTree(p).query_pairs(NEAR * edge.max(initial=0), output_type="ndarray")
    apart = np.linalg.norm(p[pairs[:, 0]] - p[pairs[:, 1]], axis=1) / edge[pairs].min(axis=1)
    kept = np.ones(len(p), dtype=bool)
    for k in np.argsort(apart, kind="stable"):
        if apart[k] > (NEAR if surplus > 0 else CROWDED):
            break
        i, j = pairs[k]
        if kept[i] and kept[j] and j >= fixed:
            kept[j], surplus = False, surplus - 1
    return np.asarray(p[kept])


def _check_count(points: int, region: Region) -> None:
    """Refuse an h0 so small that no memory would hold the lattice."""
    if points > POINTS_LIMIT:
        raise ValueError(
            f"h0 = {region.h0:g} and fh ask for a lattice of more than {POINTS_LIMIT:.0e} points. "
            "Take a larger h0, or an fh that grows faster away from its least value."
        )


def _cover(bbox: FloatArray, span: FloatArray) -> FloatArray:
    """Return the lattice points, counted from the lower corner, whose cells meet the box."""
    corners = np.array(list(product(*bbox.T))) - bbox[0]
    counts = corners @ np.linalg.inv(span)
    slack = 1e-9  # so that rounding does not lose the last row
    ranges = [
        np.arange(np.floor(a - slack) - 1, np.floor(b + slack) + 1)
        for a, b in zip(counts.min(axis=0), counts.max(axis=0), strict=True)
    ]
    p = bbox[0] + np.stack(np.meshgrid(*ranges, indexing="ij"), axis=-1) @ span
    p = p.reshape(-1, len(span))
    radius = np.linalg.norm(span, axis=1).sum()
    return np.asarray(p[((p > bbox[0] - radius) & (p < bbox[1] + radius)).all(axis=1)])


def _may_meet(p: FloatArray, span: FloatArray, region: Region) -> BoolArray:
    """Return which cells may meet the region: their centre is inside, or not far from it.

    How far is d / |grad d|, which is right for a distance and near enough for smooth functions.
    """
    middle = p + span.sum(axis=0) / 2
    radius = np.linalg.norm(np.abs(span).sum(axis=0)) / 2
    # Beyond the box the fields need not exist. The point of it that is nearest to the centre is no
    # farther from what the cell and the region share.
    centre = np.clip(middle, *region.bbox)
    meets = np.linalg.norm(middle - centre, axis=1) <= radius
    d = region.distance(centre)
    rises = [region.distance(centre + e) - d for e in radius / 10 * np.eye(len(span))]
    slope = np.linalg.norm(rises, axis=0) / (radius / 10)
    return np.asarray(meets & (d <= 2 * radius * np.maximum(slope, 1e-3)))


def _size_inside(p: FloatArray, region: Region) -> FloatArray:
    """Return fh where the points are inside, and infinity elsewhere, where fh need not exist."""
    h, p = np.full(len(p), np.inf), np.clip(p, *region.bbox)
    within = region.distance(p) < region.geps
    h[within] = region.size(p[within])
    return h


def _thinned(
    leaves: list[tuple[FloatArray, int]], region: Region, rng: np.random.Generator
) -> FloatArray:
    """Return the points inside, of each level as many as the wanted density, 1 / h**dim, asks.

    As `distmesh.reject` does, but evenly: a running sum of the shares keeps a point whenever it
    passes a whole number, and neighbours on the list are neighbours in space.
    """
    p = np.concatenate([points for points, _ in leaves])
    spacing = np.concatenate([np.full(len(points), 2.0**level) for points, level in leaves])
    kept = region.inside(p)
    p, spacing = p[kept], spacing[kept]
    h = region.size(p)
    share = np.minimum(spacing * h.min(initial=np.inf) / h, 1) ** p.shape[1]
    total = np.cumsum(np.concatenate(([rng.random()], share)))
    p = p[np.diff(np.floor(total)) > 0]
    if len(p) + len(region.pfix) <= p.shape[1]:
        raise ValueError(
            f"fh keeps {len(p)} of {len(h)} points: over the region it goes from {h.min():g} to "
            f"{h.max():g}. Take h0 near the smallest edge you want, or bound fh from below."
        )
    return np.asarray(p)
