"""A mesh generator to rely on: the truss of DistMesh, started better, stopped sooner, and mended.

What it shares with `distmesh2d` it takes from there. What differs, and what each difference buys,
is measured in the book's chapter "Making it fast and robust".
"""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from ._simplices import facets_and_owners
from ._types import ArrayLike, BoolArray, Field, FloatArray, IntArray
from ._validation import (
    as_bbox,
    as_count,
    as_field,
    as_generator,
    as_points,
    as_positive,
)
from ._warnings import ConvergenceWarning, ResolutionWarning
from .distmesh import (
    bar_forces,
    delaunay,
    incidence,
    lengths,
    project,
    triangulate,
    without_orphans,
)
from .mesh import HISTORY, Mesh, oriented, radius_ratio, unique_edges
from .mesh_improvement import lift_worst, press_out, smooth, to_boundary, without_flat
from .region import Region, as_region
from .seeding import reseeded, seeds

__all__ = ["generate_mesh", "unresolved"]

#: How far outside, in units of h0, counts as inside; in space so much that the flat tetrahedra
#: between nodes on the boundary are left out.
TOLERANCE = {1: 1e-3, 2: 1e-3, 3: 0.1}
#: A tetrahedron better than this is inside even where it is not so deep.
GOOD = 0.2
#: The step of Euler's method: a node in space has twice as many bars as one in the plane.
DELTAT = {1: 0.2, 2: 0.2, 3: 0.1}
#: How much longer than there is room for the bars want to be.
FSCALE = {1: 1.1, 2: 1.2, 3: 1.1}
#: The radius ratio that each simplex should reach at least.
GOAL = {1: 1.0, 2: 0.7, 3: 0.3}
#: How often to try for it, with other simplices.
CHANCES = 4
#: A boundary triangle worse than this and obtuse at its inner corner is flat.
FLAT = 0.45
#: How deep, in edges, a node of the finished mesh's boundary may lie inside and still be moved to
#: the region's. Where simplices would have to stretch farther, as in sharp corners, they would be
#: flat; an interval never is.
DEPTH = {1: 1.0, 2: 0.5, 3: 0.5}
#: A boundary node deeper than that is moved there where this share of the goal is kept.
SHARE = 0.7
#: A node of the finished truss nearer to a fixed one than this share of an edge is left out.
CROWD = 0.3
#: How many steps may pass before the mean quality must have made up for three tenths of its lack.
PATIENCE = {1: 20, 2: 15, 3: 100}
#: The share of its velocity that a node keeps in a step.
MOMENTUM = 0.8
#: Retriangulate when a node has moved by this share of the edges there; move no farther in a step.
TTOL = 0.3
#: At rest: no interior node moves by more than this share of the edges there.
DPTOL = 2e-3


def generate_mesh(
    fd: Field,
    fh: Field | None,
    h0: float,
    bbox: ArrayLike,
    pfix: ArrayLike | None = None,
    *,
    start: Mesh | ArrayLike | None = None,
    rng: int | np.random.Generator = 0,
    max_steps: int = 1000,
    goal: float | None = None,
    patience: int | None = None,
    callback: Callable[[Mesh], object] | None = None,
) -> Mesh:
    """Return a mesh of the region fd < 0 whose edges follow the size function fh.

    Parameters
    ----------
    fd : Field, length
        Negative inside. A signed distance, or a smooth function whose gradient at its zeros has
        a length of about 1: a factor of some tens does no harm.
    fh : Field or None, relative size
        The wanted edge length, up to a factor: its smallest value in the region stands for h0.
        None is uniform. It should not grow faster than its distance: see `limit_gradient`.
    h0 : float, length
        The smallest edges.
    bbox : array_like of shape (2, dim), length
        A box around the region, ((xmin, ymin), (xmax, ymax)) in the plane. It also says in how
        many dimensions the mesh lives: one, two or three.
    pfix : array_like of shape (k, dim), length, optional
        Nodes that the mesh must have, such as corners. They come first, in this order.
    start : Mesh or array_like of shape (n, dim), length, optional
        Nodes to begin with in place of a lattice, such as the mesh of the region as it was a
        moment ago. Those of them that are crowded go, and gaps are filled.
    rng : int or numpy.random.Generator
        Chooses which lattice points to keep where edges grow. One seed always gives one mesh.
    max_steps : int
        The cap. It is there for safety: the truss stops sooner.
    goal : float, optional
        The radius ratio that every simplex should have at least; 0.7 in the plane and 0.3 in
        space if None. Nodes at worse ones are moved until all have it, as far as that goes.
    patience : int, optional
        Stop when in so many steps the mean quality made up for less than three tenths of what it
        lacked; 15 in the plane, 100 in space if None. More patience makes the mean a little better.
    callback : callable, optional
        Called with a `Mesh` at each retriangulation: for progress bars and animations.

    Returns
    -------
    Mesh
        `p, t`, whether it came to rest or stopped improving, in how many steps, and how its
        quality went; the last row of its history is that of the finished mesh.

    Raises
    ------
    TypeError
        If a field cannot be called.
    ValueError
        If an argument makes no sense, a field returns a NaN or the wrong shape, fh is not
        positive, fd is far from a length, a fixed point lies outside or is given twice, the box
        cuts the region, or no simplex of size h0 fits inside.

    Warns
    -----
    ConvergenceWarning
        If the truss was stopped by `max_steps`.
    ResolutionWarning
        If the region has features that edges of this size cannot follow, or the least quality is
        below half the goal; it says where.

    Notes
    -----
    The truss is that of [PerssonStrang2004]_. It starts from a lattice that is coarse where edges
    are long; moves with momentum, which a node loses when the force turns against it; judges
    every move by the size of the edges there; and asks fh only when it is triangulated anew.
    A triangle at the boundary that is flat because its inner corner wants to be a boundary node
    is dropped, and the node moved there. `mesh_improvement` has what follows.

    Examples
    --------
    >>> from distmesh_edu import circle
    >>> mesh = generate_mesh(circle(), None, 0.2, ((-1, -1), (1, 1)))
    >>> len(mesh.p), bool(mesh.quality.min() > 0.7)
    (88, True)
    """
    dim = as_bbox(bbox).shape[1]
    if dim not in GOAL:
        raise ValueError(f"bbox must be two corners in one, two or three dimensions; got {dim}.")
    region = as_region(fd, fh, h0, bbox, pfix, dim, TOLERANCE[dim], fills=fh is None)
    goal = GOAL[dim] if goal is None else as_positive("goal", goal)
    patience = PATIENCE[dim] if patience is None else as_count("patience", patience)
    rng = as_generator(rng)
    p = seeds(region, rng)
    if (scaled := region.in_lengths(p)) is not region:
        region, p = scaled, seeds(scaled, rng)
    if start is not None:
        p = reseeded(_arrived(start, region), region, rng)
    log = _Log(region, patience, callback)
    p, t = _relax(p, region, as_count("max_steps", max_steps), log)
    p, t = _finish(p, t, region, goal)
    log.record(p, t)
    mesh = Mesh(p, t, log.why != "cap", log.steps, log.history)
    _warn(mesh, region, log, goal)
    return mesh


def _arrived(start: Mesh | ArrayLike, region: Region) -> FloatArray:
    """Return the nodes of an earlier mesh that are in the region or were left just outside it.

    The latter are put on its boundary: those farther off than h0 were in what it lost.
    """
    p = as_points("start", start.p if isinstance(start, Mesh) else start, region.bbox.shape[1])
    p = p[region.distance(p) < region.h0]
    outside = region.distance(p) > 0
    p[outside] = to_boundary(p[outside], region)
    return p[region.distance(p) < region.geps]


class _Log:
    """What the run looked like at each retriangulation, and whether it still gets anywhere."""

    def __init__(
        self, region: Region, patience: int, callback: Callable[[Mesh], object] | None
    ) -> None:
        self.region, self.patience, self.callback = region, patience, callback
        self.history = np.zeros(0, HISTORY)
        self.steps, self.move, self.why = 0, np.inf, "cap"

    def record(self, p: FloatArray, t: IntArray) -> None:
        quality = radius_ratio(p, t)
        row = np.array([(self.steps, self.move, quality.min(), quality.mean())], HISTORY)
        self.history = np.concatenate((self.history, row))
        self.history.flags.writeable = False
        if self.callback is not None:
            self.callback(Mesh(p, t, False, self.steps, self.history))

    def stands_still(self) -> bool:
        """Whether the mean quality made up for less than three tenths of what it lacked."""
        rows = self.history[:-2]
        rows = rows[rows["step"] <= self.steps - self.patience]
        if not len(rows):
            return False
        now, then = 1 - self.history["mean_quality"][-1], 1 - rows["mean_quality"][-1]
        return bool(now > (1 - 0.3) * then)


def _relax(p: FloatArray, region: Region, max_steps: int, log: _Log) -> tuple[FloatArray, IntArray]:
    """Return the nodes and simplices of the truss once it is at rest, or gets nowhere."""
    dim, fixed = p.shape[1], len(region.pfix)
    scale = region.h0 / region.size(p).min()
    edge = scale * region.size(p)
    # A lattice is all ties, and Qhull takes twice as long to break them as it does otherwise.
    shaken = 1e-3 * region.h0 * np.random.default_rng(0).normal(size=p.shape)
    velocity, p_old = np.zeros_like(p), np.full_like(p, np.inf)
    for _ in range(max_steps):
        if (lengths(p - p_old) > TTOL * edge).any():
            p, t = mend_boundary(p, _triangulate(p + shaken, region), region, edge / 4)
            p_old, shaken = p, np.zeros(())
            D = incidence(bars := unique_edges(t), len(p))
            h, edge = region.size(p[bars].mean(axis=1)), scale * region.size(p)
            log.record(p, t)
            if log.stands_still():
                log.why = "plateau"
                return p, t
        F = bar_forces(D, p, h, FSCALE[dim])
        F[:fixed] = 0
        velocity = _faster(velocity, DELTAT[dim] * F, edge)
        p, d = project(p + velocity, fixed, region)
        log.steps += 1
        log.move = float((DELTAT[dim] * lengths(F) / edge)[d < -region.geps].max(initial=0))
        if log.move < DPTOL and (d < -region.geps).any():
            log.why = "rest"
            break
    return mend_boundary(p, _triangulate(p, region), region, edge / 4)


def _faster(velocity: FloatArray, push: FloatArray, edge: FloatArray) -> FloatArray:
    """Return the velocity after a push: it keeps a share, unless that would climb back uphill."""
    uphill = np.einsum("ij,ij->i", velocity, push) < 0
    velocity = np.where(uphill[:, None], 0, MOMENTUM * velocity) + push
    speed = lengths(velocity)
    return np.asarray(velocity * np.minimum(1, TTOL * edge / np.maximum(speed, 1e-300))[:, None])


def _triangulate(p: FloatArray, region: Region) -> IntArray:
    """Return the Delaunay simplices that lie inside.

    In space `tolerance`, in edges there, keeps flat tetrahedra out, and along a hollow wall some
    good ones too, whose centroids are not deep: those stay.
    """
    if p.shape[1] < 3:
        return triangulate(p, region)
    t = delaunay(p, region.bbox.mean(axis=0))
    middle = p[t].mean(axis=1)
    d = region.distance(middle)
    within = d < -1e-3 * region.h0
    t, d, h = t[within], d[within], region.size(middle[within])
    kept = t[(d < -region.geps * h / h.min(initial=np.inf)) | (radius_ratio(p, t) > GOOD)]
    return kept if len(kept) else triangulate(p, region)  # which says what is wrong


def mend_boundary(
    p: FloatArray, t: IntArray, region: Region, depth: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Return the mesh with the nodes of its boundary on the region's, and fewer flat triangles.

    A triangle whose outer edge is its longest by far holds a node that presses on the boundary
    from inside and finds no place there. Without the triangle it is a boundary node. All boundary
    nodes no deeper than `depth` inside are moved to the boundary.
    """
    facets, owners = facets_and_owners(t)
    rim, p = np.zeros(len(p), dtype=bool), p.copy()
    rim[facets] = True
    if p.shape[1] == 2:
        pressed, flat = _pressed(p, t, facets, owners, rim)
        rim[pressed], t = True, np.delete(t, flat, axis=0)
    rim[: len(region.pfix)] = False
    rim[rim] = -region.distance(p[rim]) < depth[rim]
    p[rim] = to_boundary(p[rim], region)
    return p, t


def _pressed(
    p: FloatArray, t: IntArray, facets: IntArray, owners: IntArray, rim: BoolArray
) -> tuple[IntArray, IntArray]:
    """Return the inner nodes pressed against an outer edge, and the numbers of their triangles."""
    apex = t[owners].sum(axis=1) - facets.sum(axis=1)
    a, b = (p[facets[:, k]] - p[apex] for k in (0, 1))
    obtuse = np.einsum("ij,ij->i", a, b) < 0
    flat = obtuse & ~rim[apex] & (radius_ratio(p, t[owners]) < FLAT)
    return apex[flat], owners[flat]


def _finish(p: FloatArray, t: IntArray, region: Region, goal: float) -> tuple[FloatArray, IntArray]:
    """Return the mesh with its nodes where the simplices around them are best.

    Where that does not reach the goal, other simplices of the moved nodes may.
    """
    p, t = _give_way(p, t, region)
    dim, fixed, best = p.shape[1], len(region.pfix), -np.inf
    depth = DEPTH[dim] * region.h0 / region.size(p).min() * region.size(p)
    if dim == 1:
        return without_orphans(*mend_boundary(p, t, region, depth), fixed)
    for _ in range(CHANCES):
        p = smooth(p, oriented(p, t), fixed, region)
        t = without_flat(p, _triangulate(p, region), fixed)
        p, t = mend_boundary(p, t, region, depth)
        p = press_out(p, t := oriented(p, t), fixed, region, SHARE * goal)
        p = lift_worst(p, t, fixed, region, goal)
        p = press_out(p, t := without_flat(p, t, fixed), fixed, region, SHARE * goal)
        least = float(radius_ratio(p, t).min())
        if least > best:
            best, finished = least, (p, t)
        if least >= goal:
            break
    return without_orphans(*finished, fixed)


def _give_way(p: FloatArray, t: IntArray, region: Region) -> tuple[FloatArray, IntArray]:
    """Return the mesh without nodes that stand close to a fixed one.

    In a corner of a box a fixed node may lose its only tetrahedron, and with it the bars that keep
    others away; the first to arrive then takes its place.
    """
    fixed = len(region.pfix)
    edge = region.h0 / region.size(p).min() * region.size(p)
    near, _ = cKDTree(p[:fixed]).query(p)  # infinitely far where none is fixed
    stays = near > CROWD * edge
    stays[:fixed] = True
    return (p, t) if stays.all() else (p[stays], _triangulate(p[stays], region))


def unresolved(mesh: Mesh, fd: Field) -> FloatArray:
    """Return where a region has features that the edges of its mesh are too long to follow.

    Parameters
    ----------
    mesh : Mesh
        A mesh of the region.
    fd : Field, length
        The region's distance.

    Returns
    -------
    ndarray of shape (k, dim), length
        The middles of edges that run outside, and of boundary facets and boundary nodes that lie
        inside, by more than a fifth of the edges' length there; nodes that no simplex uses; and
        points of the region's boundary from which the mesh's is farther than three fifths: holes
        that it covers, arms that it leaves out. The worst come first.

    Raises
    ------
    TypeError, ValueError
        If fd is no field.

    Examples
    --------
    >>> from distmesh_edu import rectangle
    >>> corner = Mesh([(0, 0), (2, 0), (0, 2)], [(0, 1, 2)])
    >>> unresolved(corner, rectangle(((0, 0), (2, 2))))
    array([[1., 1.]])
    """
    if not len(mesh.t):
        return mesh.p
    bbox = np.stack((mesh.p.min(axis=0), mesh.p.max(axis=0)))
    region = Region(as_field("fd", fd), None, mesh.edge_lengths.min(), bbox, mesh.p[:0], 0)
    edges, facets = mesh.p[mesh.edges].mean(axis=1), mesh.p[mesh.boundary_facets].mean(axis=1)
    region = region.in_lengths(facets)
    longest = np.zeros(len(mesh.p))
    for end in mesh.edges.T:
        np.maximum.at(longest, end, mesh.edge_lengths)
    rim, missed = mesh.boundary_nodes, _missed(mesh, region, longest)
    where = np.concatenate((edges, facets, mesh.p[rim], mesh.p[mesh.orphans], missed[0]))
    excess = (
        region.distance(edges) / mesh.edge_lengths,
        -region.distance(facets) / longest[mesh.boundary_facets].min(axis=1),
        -region.distance(mesh.p[rim]) / longest[rim],
        np.ones(len(mesh.orphans)),
        missed[1] / 3,
    )
    how_far = np.concatenate(excess)
    worst = np.argsort(-how_far)
    return where[worst[how_far[worst] > 0.2]]


def _missed(mesh: Mesh, region: Region, longest: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points of the region's boundary, and how far from each, in edges, the mesh's is.

    They are the nearest to the mesh's nodes, for holes that it covers, and to points one and two
    heights outside its boundary facets, for what it leaves out.
    """
    facets = mesh.boundary_facets
    apex = mesh.t[mesh.boundary_simplices].sum(axis=1) - facets.sum(axis=1)
    middle = mesh.p[facets].mean(axis=1)
    height, size = middle - mesh.p[apex], longest[facets].min(axis=1)
    start = np.concatenate((mesh.p, middle + height, middle + 2 * height))
    size = np.concatenate((longest, size, size))
    near = np.abs(region.distance(start)) < 1.5 * size
    start, size = start[near], size[near]
    p = to_boundary(start, region)
    # Where the distance has a kink, Newton's method may lead elsewhere, or far away.
    found = (np.abs(region.distance(p)) < 0.05 * size) & (lengths(p - start) < 3 * size)
    gap, _ = cKDTree(np.concatenate((mesh.p[mesh.boundary_nodes], middle))).query(p[found])
    return p[found], gap / size[found]


def _warn(mesh: Mesh, region: Region, log: _Log, goal: float) -> None:
    """Say what the mesh is not."""
    if log.why == "cap":
        words = (
            f"generate_mesh stopped at its cap of {log.steps} steps; a node still moved "
            f"{log.move:.2g} of an edge. Raise max_steps."
        )
        warnings.warn(words, ConvergenceWarning, stacklevel=3)
    where, worst = unresolved(mesh, region.fd), int(mesh.quality.argmin())
    if len(where) or mesh.quality[worst] < goal / 2:
        found = f"{len(where)} places, the worst near {_place(where[0])}" if len(where) else "none"
        words = (
            "the region has features too fine for edges of this size: unresolved(mesh, fd) has "
            f"{found}. The least quality, {mesh.quality[worst]:.2f}, is near "
            f"{_place(mesh.p[mesh.t[worst]].mean(axis=0))}. Take smaller edges there, or smooth "
            "the region."
        )
        warnings.warn(words, ResolutionWarning, stacklevel=3)


def _place(p: FloatArray) -> str:
    return f"({', '.join(f'{x:.4g}' for x in p)})"
