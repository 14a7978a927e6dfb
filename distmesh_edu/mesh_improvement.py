"""What mends the last bad simplices once a truss has done its work: averages, and small moves.

A truss knows lengths, not shapes. It makes nearly all simplices good in a few steps and then takes
hundreds for the last ones. Here the nodes move while the simplices stay: first each to the mean of
what surrounds it, which lifts the average; then those at the worst simplices, one small move after
another, each of which makes the worst better.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ._simplices import facets_and_owners
from ._types import BoolArray, FloatArray, IntArray
from .distmesh import newton_step
from .mesh import boundary_facets, radius_ratio, simplex_volumes, unique_edges
from .region import Region

__all__ = ["lift_worst", "press_out", "signed_quality", "smooth", "to_boundary", "without_flat"]

#: The first move tried, as a share of the shortest edge at a node, and the smallest.
FIRST_MOVE, LAST_MOVE = 0.2, 0.003
#: An improvement of a quality that is worth a move.
WORTH = 1e-6
#: A triangle worse than this and obtuse is flat.
FLAT = 0.45


def signed_quality(p: FloatArray, t: IntArray) -> FloatArray:
    """Return the radius ratio of each simplex, below zero where it is turned inside out.

    Parameters
    ----------
    p : ndarray of shape (n, dim), length
    t : ndarray of int, of shape (m, dim + 1)

    Returns
    -------
    ndarray of shape (m,), dimensionless

    Examples
    --------
    >>> p = np.array([[0.0, 0], [4, 0], [0, 3]])
    >>> signed_quality(p, np.array([[0, 1, 2], [0, 2, 1]]))
    array([ 0.8, -0.8])
    """
    return np.asarray(np.copysign(radius_ratio(p, t), simplex_volumes(p, t)))


def to_boundary(p: FloatArray, region: Region, steps: int = 3) -> FloatArray:
    """Return the points moved to the boundary, by a few steps of Newton's method.

    Parameters
    ----------
    p : ndarray of shape (n, dim), length
    region : Region
        Whose boundary.
    steps : int
        One is exact for a distance; another field takes a few.

    Returns
    -------
    ndarray of shape (n, dim), length
    """
    for _ in range(steps if len(p) else 0):
        p = p - newton_step(p, region.distance(p), region)
    return p


def smooth(p: FloatArray, t: IntArray, fixed: int, region: Region, sweeps: int = 5) -> FloatArray:
    """Return the nodes after sweeps that move each interior one to the mean of its surroundings.

    Parameters
    ----------
    p : ndarray of shape (n, dim), length
    t : ndarray of int, of shape (m, dim + 1)
        Positively oriented.
    fixed : int
        How many nodes, the first ones, stay.
    region : Region
        Its size function weighs the simplices: small ones pull more, so that gradings survive.
    sweeps : int
        The most; they end as soon as the mean quality no longer rises.

    Returns
    -------
    ndarray of shape (n, dim), length

    Notes
    -----
    Laplacian smoothing, with the centroids of a node's simplices in place of its neighbours.
    """
    stays = np.zeros(len(p), dtype=bool)
    stays[:fixed] = True
    stays[boundary_facets(t)] = True
    interior = np.flatnonzero(~stays & np.isin(np.arange(len(p)), t))
    corners = csr_array(
        (np.ones(t.size), t.ravel(), np.arange(0, t.size + 1, t.shape[1])), (len(t), len(p))
    )
    around = corners.T.tocsr()[interior]
    mean = signed_quality(p, t).mean()
    for _ in range(sweeps):
        centroids = p[t].mean(axis=1)
        weight = 1 / region.size(centroids)
        moved = p.copy()
        moved[interior] = (around @ (weight[:, None] * centroids)) / (around @ weight)[:, None]
        before, mean = mean, signed_quality(moved, t).mean()
        if mean <= before:
            break
        p = moved
    return p


def press_out(p: FloatArray, t: IntArray, fixed: int, region: Region, least: float) -> FloatArray:
    """Return the nodes with those of the mesh's boundary on the region's, where that does no harm.

    Parameters
    ----------
    p : ndarray of shape (n, dim), length
    t : ndarray of int, of shape (m, dim + 1)
        Positively oriented.
    fixed : int
        How many nodes, the first ones, stay.
    region : Region
        Whose boundary.
    least : float
        The quality (radius ratio) below which no simplex may be stretched. One that is worse
        already may not become worse.

    Returns
    -------
    ndarray of shape (n, dim), length
    """
    rim = np.unique(boundary_facets(t))
    rim = rim[rim >= fixed]
    moved, allowed = p.copy(), np.minimum(signed_quality(p, t), least)
    moved[rim] = to_boundary(p[rim], region)
    while (harmed := signed_quality(moved, t) < allowed).any():
        back = t[harmed]
        moved[back] = p[back]
    return moved


def without_flat(p: FloatArray, t: IntArray, fixed: int) -> IntArray:
    """Return the triangles but the flat ones at the boundary, which no node of it needs.

    They press an inner node against their outer edge, span a bay between two outer edges, or are
    a bump whose tip no other triangle uses. Without one, the next behind it may be another.
    Tetrahedra and intervals all stay.

    Parameters
    ----------
    p : ndarray of shape (n, dim), length
    t : ndarray of int, of shape (m, dim + 1)
    fixed : int
        How many nodes, the first ones, may not lose their last triangle.

    Returns
    -------
    ndarray of int, of shape (k, dim + 1)

    Examples
    --------
    >>> p = np.array([[0.0, 0], [4, 0], [2, 3], [2, -0.1]])
    >>> without_flat(p, np.array([[0, 1, 2], [0, 3, 1]]), fixed=0)
    array([[0, 1, 2]])
    """
    while p.shape[1] == 2 and (flat := _needless(p, t, fixed)).any():
        t = t[~flat]
    return t


def _needless(p: FloatArray, t: IntArray, fixed: int) -> BoolArray:
    """Return which triangles are flat, and obtuse at a node that needs them as little as the rest.

    At an inner node, or, where there are two outer edges, at any: but a node that no other
    triangle uses must be the obtuse one, and not fixed.
    """
    facets, owners = facets_and_owners(t)
    outer = np.bincount(owners, minlength=len(t))[:, None]
    alone = (np.bincount(t.ravel()) == 1)[t]
    goes = np.where(alone, t >= fixed, ~alone.any(axis=1, keepdims=True)) & (outer == 2)
    goes |= ~np.isin(t, facets) & (outer == 1)
    return np.asarray((goes & _obtuse(p[t])).any(axis=1) & (radius_ratio(p, t) < FLAT))


def _obtuse(corners: FloatArray) -> BoolArray:
    """Return at which corners triangles, of shape (m, 3, 2), have an obtuse angle."""
    ahead = np.roll(corners, -1, axis=1) - corners
    return np.asarray(np.einsum("mij,mij->mi", ahead, np.roll(ahead, 1, axis=1)) > 0)


def lift_worst(
    p: FloatArray, t: IntArray, fixed: int, region: Region, goal: float, rounds: int = 60
) -> FloatArray:
    """Return the nodes moved so that the worst simplices are better; none becomes the new worst.

    Each round takes nodes of simplices below the goal, no two of them neighbours, and tries moves
    in all directions, those of boundary nodes along the boundary. A node goes where the worst of
    its simplices is best; one that finds nothing better tries moves half as long in its next turn.

    Parameters
    ----------
    p : ndarray of shape (n, dim), length
    t : ndarray of int, of shape (m, dim + 1)
        Positively oriented.
    fixed : int
        How many nodes, the first ones, stay.
    region : Region
        Whose boundary holds the boundary nodes.
    goal : float
        The quality (radius ratio) that is good enough.
    rounds : int
        The most.

    Returns
    -------
    ndarray of shape (n, dim), length
    """
    p, quality, edges = p.copy(), signed_quality(p, t), unique_edges(t)
    on_boundary = np.zeros(len(p), dtype=bool)
    on_boundary[boundary_facets(t)] = True
    room = _shortest_edge(p, edges)
    reach = FIRST_MOVE * room
    for _ in range(rounds):
        movable = np.zeros(len(p), dtype=bool)
        movable[t[quality < goal]] = True
        movable[:fixed] = False
        movable &= reach > LAST_MOVE * room
        if not movable.any():
            break
        stars = _stars(t, _apart(movable, edges, t, quality))
        better = _best_moves(p, t, stars, reach, on_boundary, region)
        moved = (better != p[stars.nodes]).any(axis=1)
        reach[stars.nodes[~moved]] /= 2
        p[stars.nodes] = better
        quality[stars.simplices] = signed_quality(p, t[stars.simplices])
    return p


def _shortest_edge(p: FloatArray, edges: IntArray) -> FloatArray:
    """Return the length of the shortest edge at each node."""
    shortest = np.full(len(p), np.inf)
    lengths = np.linalg.norm(p[edges[:, 0]] - p[edges[:, 1]], axis=1)
    for end in edges.T:
        np.minimum.at(shortest, end, lengths)
    return shortest


class _Stars(NamedTuple):
    """Some nodes and the simplices around each, in rows sorted by node."""

    nodes: IntArray
    first: IntArray  # the row where each node's begin
    simplices: IntArray  # one a row
    corners: IntArray  # which corner of the simplex the node is
    turns: IntArray  # which of the nodes it is

    def worst(self, quality: FloatArray) -> FloatArray:
        """Return the least of each node's rows."""
        return np.asarray(np.minimum.reduceat(quality, self.first))


def _stars(t: IntArray, chosen: BoolArray) -> _Stars:
    rows = np.flatnonzero(chosen[t].ravel())
    rows = rows[np.argsort(t.ravel()[rows], kind="stable")]
    nodes, first, turns = np.unique(t.ravel()[rows], return_index=True, return_inverse=True)
    return _Stars(nodes, first, *np.divmod(rows, t.shape[1]), turns)


def _apart(movable: BoolArray, edges: IntArray, t: IntArray, quality: FloatArray) -> BoolArray:
    """Return which of the nodes go first: those worse off than all their movable neighbours."""
    stars = _stars(t, movable)
    rank = np.zeros(len(movable), dtype=np.int64)
    order = np.argsort(stars.worst(quality[stars.simplices]), kind="stable")
    rank[stars.nodes[order]] = np.arange(len(order))
    a, b = edges[movable[edges].all(axis=1)].T
    goes = movable.copy()
    goes[np.where(rank[a] < rank[b], b, a)] = False
    return goes


def _best_moves(
    p: FloatArray,
    t: IntArray,
    stars: _Stars,
    reach: FloatArray,
    on_boundary: BoolArray,
    region: Region,
) -> FloatArray:
    """Return where each node's worst simplex is best: where it stands, or one of the moves."""
    nodes, dim = stars.nodes, p.shape[1]
    directions = _directions(dim)[:, None]
    # All at once: asking fd, not computing qualities, is what takes time.
    trials = (p[nodes] + reach[nodes, None] * directions).reshape(-1, dim)
    strays = np.tile(on_boundary[nodes], len(directions)) | (region.distance(trials) > 0)
    trials[strays] = to_boundary(trials[strays], region, 2)
    corners = p[t[stars.simplices]]
    alone = np.arange(corners[..., 0].size).reshape(corners.shape[:2])
    best = p[nodes]
    worst = stars.worst(signed_quality(corners.reshape(-1, dim), alone))
    for trial in trials.reshape(-1, *best.shape):
        corners[np.arange(len(corners)), stars.corners] = trial[stars.turns]
        found = stars.worst(signed_quality(corners.reshape(-1, dim), alone))
        better = found > worst + WORTH
        best[better], worst[better] = trial[better], found[better]
    return best


def _directions(dim: int) -> FloatArray:
    """Return unit vectors along the axes and the diagonals: 2, 8 or 26 of them."""
    steps = np.array([step for step in product((-1.0, 0.0, 1.0), repeat=dim) if any(step)])
    return np.asarray(steps / np.linalg.norm(steps, axis=1)[:, None])
