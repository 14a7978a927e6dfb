"""DistMesh: a truss that relaxes, retriangulated as it moves, held by a distance.

The algorithm of Persson and Strang in the eight steps of sections 5.5 and 5.7 of the thesis, one
function a step and one body for every dimension, with the five corrections that the book's errata
prove necessary.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import Delaunay, QhullError

from ._types import ArrayLike, Field, FloatArray, IntArray
from ._validation import as_count, as_generator, as_positive
from ._warnings import ConvergenceWarning
from .mesh import HISTORY, Mesh, radius_ratio, unique_edges
from .region import Region, as_region

# The functions of the single steps are for reading, and for whoever builds on them.
__all__ = ["distmesh2d", "distmesh2d_steps", "distmesh3d", "distmesh3d_steps"]


def distmesh2d(
    fd: Field,
    fh: Field | None,
    h0: float,
    bbox: ArrayLike,
    pfix: ArrayLike | None = None,
    *,
    rng: int | np.random.Generator = 0,
    max_steps: int = 1000,
    dptol: float = 0.001,
    ttol: float = 0.1,
    Fscale: float = 1.2,
    deltat: float = 0.2,
) -> Mesh:
    """Return a mesh of the region fd < 0 whose edges follow the size function fh.

    Parameters
    ----------
    fd : Field, length
        Negative inside. A signed distance, or a smooth function whose gradient at its zeros has
        a length of about 1: a factor of some tens does no harm.
    fh : Field or None, relative size
        The wanted edge length, up to a factor that the region's size decides. None is uniform.
    h0 : float, length
        The edge length of the lattice it starts from: the smallest edges of the mesh, about.
    bbox : array_like of shape (2, 2), length
        A box around the region, ((xmin, ymin), (xmax, ymax)).
    pfix : array_like of shape (k, 2), length, optional
        Nodes that the mesh must have, such as corners. They come first, in this order.
    rng : int or numpy.random.Generator
        Chooses which lattice points to keep where fh is large. One seed always gives one mesh.
    max_steps : int
        The cap: published versions may run for ever.
    dptol : float
        Stop when no interior node would move farther than this times h0 in a step.
    ttol : float
        Triangulate anew when a node has moved farther than this times h0.
    Fscale : float
        How much longer than their space allows the bars want to be: the pressure that drives
        nodes to the boundary.
    deltat : float
        The step of Euler's method. Much above 0.2 the truss rattles.

    Returns
    -------
    Mesh
        `p, t`, and whether it converged, in how many steps, and how its quality went.

    Raises
    ------
    TypeError
        If a field cannot be called.
    ValueError
        If an argument makes no sense, a field returns a NaN or the wrong shape, fh is not
        positive, fd is far from a length, a fixed point lies outside or is given twice, the box
        cuts the region, no triangle of size h0 fits inside, or no memory would hold the lattice.

    Warns
    -----
    ConvergenceWarning
        If `max_steps` did not suffice; the best triangulation since half-time is returned.

    Notes
    -----
    [PerssonStrang2004]_ and thesis section 5.5, corrected: lattice points equal to a fixed point
    are removed; fixed points are not projected; the projection divides by |grad d|**2; the
    stopping test measures the step, deltat |F|; a last triangulation makes t belong to p. Beyond
    these: without interior nodes the boundary's moves are tested, and nodes that no triangle uses
    are dropped at the end.

    Examples
    --------
    >>> from distmesh_edu import circle
    >>> distmesh2d(circle(), None, 0.2, ((-1, -1), (1, 1))).t.shape
    (143, 3)
    """
    return _at_rest(
        distmesh2d_steps(
            fd,
            fh,
            h0,
            bbox,
            pfix,
            rng=rng,
            max_steps=max_steps,
            dptol=dptol,
            ttol=ttol,
            Fscale=Fscale,
            deltat=deltat,
        ),
        dptol,
    )


def distmesh2d_steps(
    fd: Field,
    fh: Field | None,
    h0: float,
    bbox: ArrayLike,
    pfix: ArrayLike | None = None,
    *,
    rng: int | np.random.Generator = 0,
    max_steps: int = 1000,
    dptol: float = 0.001,
    ttol: float = 0.1,
    Fscale: float = 1.2,
    deltat: float = 0.2,
) -> Iterator[Mesh]:
    """Yield the mesh at the start, after each step, and at the end: for animations.

    Parameters
    ----------
    fd, fh, h0, bbox, pfix, rng, max_steps, dptol, ttol, Fscale, deltat
        As for `distmesh2d`, which returns the last of these meshes.

    Yields
    ------
    Mesh
        Between retriangulations its triangles are those of the last one. The last mesh yielded
        is that of `distmesh2d`; whether it converged is for you to ask, no warning is given.

    Raises
    ------
    TypeError, ValueError
        As `distmesh2d`.

    Examples
    --------
    >>> from distmesh_edu import circle
    >>> steps = distmesh2d_steps(circle(), None, 0.2, ((-1, -1), (1, 1)))
    >>> [next(steps).steps for _ in range(3)]
    [0, 1, 2]
    """
    region = as_region(fd, fh, h0, bbox, pfix, dim=2)
    return _checked(region, rng, max_steps, Tuning(dptol, ttol, Fscale, deltat))


def distmesh3d(
    fd: Field,
    fh: Field | None,
    h0: float,
    bbox: ArrayLike,
    pfix: ArrayLike | None = None,
    *,
    rng: int | np.random.Generator = 0,
    max_steps: int = 2000,
    dptol: float = 0.001,
    ttol: float = 0.1,
    Fscale: float = 1.1,
    deltat: float = 0.1,
) -> Mesh:
    """Return a mesh of tetrahedra of the region fd < 0 whose edges follow the size function fh.

    Parameters
    ----------
    fd, fh, h0, bbox, pfix, rng, max_steps, dptol, ttol, Fscale, deltat
        As for `distmesh2d`, with points (x, y, z) and a box ((xmin, ymin, zmin), (xmax, ymax,
        zmax)). The pressure and the step are smaller than in the plane, as a node has more bars.

    Returns
    -------
    Mesh
        `p` of shape (n, 3) and `t` of shape (m, 4). A few of its tetrahedra will be slivers, four
        nodes near one circle: `generate_mesh` removes them.

    Raises
    ------
    TypeError, ValueError
        As `distmesh2d`.

    Warns
    -----
    ConvergenceWarning
        If `max_steps` did not suffice; the best triangulation since half-time is returned.

    Notes
    -----
    Thesis section 5.7, with the five corrections of `distmesh2d`. As in its listing, the nodes
    start from a cubic lattice, points up to h0 / 10 outside are kept, and a tetrahedron counts
    as inside if its centroid lies h0 / 10 deep.

    Examples
    --------
    >>> from distmesh_edu import sphere
    >>> len(distmesh3d(sphere(), None, 0.5, ((-1, -1, -1), (1, 1, 1))).p)
    33
    """
    return _at_rest(
        distmesh3d_steps(
            fd,
            fh,
            h0,
            bbox,
            pfix,
            rng=rng,
            max_steps=max_steps,
            dptol=dptol,
            ttol=ttol,
            Fscale=Fscale,
            deltat=deltat,
        ),
        dptol,
    )


def distmesh3d_steps(
    fd: Field,
    fh: Field | None,
    h0: float,
    bbox: ArrayLike,
    pfix: ArrayLike | None = None,
    *,
    rng: int | np.random.Generator = 0,
    max_steps: int = 2000,
    dptol: float = 0.001,
    ttol: float = 0.1,
    Fscale: float = 1.1,
    deltat: float = 0.1,
) -> Iterator[Mesh]:
    """Yield the mesh at the start, after each step, and at the end: for animations.

    Parameters
    ----------
    fd, fh, h0, bbox, pfix, rng, max_steps, dptol, ttol, Fscale, deltat
        As for `distmesh3d`, which returns the last of these meshes.

    Yields
    ------
    Mesh
        As `distmesh2d_steps`.

    Raises
    ------
    TypeError, ValueError
        As `distmesh2d`.

    Examples
    --------
    >>> from distmesh_edu import sphere
    >>> next(distmesh3d_steps(sphere(), None, 0.5, ((-1, -1, -1), (1, 1, 1)))).t.shape[1]
    4
    """
    region = as_region(fd, fh, h0, bbox, pfix, dim=3, tolerance=0.1)
    return _checked(region, rng, max_steps, Tuning(dptol, ttol, Fscale, deltat))


class Tuning(NamedTuple):
    """The constants of the method, dimensionless: see `distmesh2d`."""

    dptol: float
    ttol: float
    Fscale: float
    deltat: float


def _checked(region: Region, rng: object, max_steps: int, tuning: Tuning) -> Iterator[Mesh]:
    for name, value in tuning._asdict().items():
        as_positive(name, value)
    return _relax(region, as_generator(rng), as_count("max_steps", max_steps), tuning)


def _at_rest(steps: Iterator[Mesh], dptol: float) -> Mesh:
    """Return the last mesh, with a warning if it is not at rest."""
    for mesh in steps:
        last = mesh
    if not last.converged:
        warnings.warn(_how_far(last, dptol), ConvergenceWarning, stacklevel=3)
    return last


def _relax(
    region: Region, rng: np.random.Generator, max_steps: int, tuning: Tuning
) -> Iterator[Mesh]:
    dptol, ttol, Fscale, deltat = tuning
    # 1. Distribute points over the box
    p = lattice(region.bbox, region.h0)
    # 2. Remove those outside, and thin out where fh is large
    p = reject(keep_inside(p, region), region, rng)
    p = np.concatenate((region.pfix, p))
    p_old = np.full_like(p, np.inf)
    fixed, move, log = len(region.pfix), np.inf, _Log(max_steps)

    for step in range(max_steps):
        if longest(p - p_old) > ttol * region.h0:
            p_old = p
            # 3. Retriangulate
            t = triangulate(p, region)
            # 4. Describe each bar by its two nodes
            bars = unique_edges(t)
            D = incidence(bars, len(p))
            log.record(step, move, p, t)
        # 5. Show the current mesh
        yield Mesh(p, t, False, step, log.history)

        # 6. Move the nodes by the forces of the bars
        h = region.size(p[bars].mean(axis=1))
        F = bar_forces(D, p, h, Fscale)
        F[:fixed] = 0
        before, p = p, p + deltat * F
        # 7. Bring points back to the boundary
        p, d = project(p, fixed, region)
        # 8. Stop when the interior is at rest (if there is none, the boundary)
        interior = d < -region.geps
        moves = deltat * F[interior] if interior.any() else p - before
        move = longest(moves) / region.h0
        if move < dptol:
            break

    yield _at_the_end(p, region, log, step + 1, move, move < dptol)


def _at_the_end(
    p: FloatArray, region: Region, log: _Log, steps: int, move: float, converged: bool
) -> Mesh:
    """Return the mesh with simplices that belong to its nodes; if it never settled, the best."""
    log.record(steps, move, p, triangulate(p, region))
    p, t = log.last if converged else log.best
    return Mesh(*without_orphans(p, t, len(region.pfix)), converged, steps, log.history)


def without_orphans(p: FloatArray, t: IntArray, fixed: int) -> tuple[FloatArray, IntArray]:
    """Return the mesh without nodes that no simplex uses, save the fixed ones.

    A place thinner than h0 may leave such a node behind, and a solver would fail at it.
    """
    used = np.union1d(np.arange(fixed), t)
    return p[used], np.searchsorted(used, t)


class _Log:
    """How the mesh stood at each retriangulation, and the best of those since half-time.

    A truss that does not settle shakes its worst triangles from good to bad and back: the last
    mesh is a lottery. In the first half, it has not yet spread out, and the lattice is regular.
    """

    def __init__(self, max_steps: int) -> None:
        self.half_time = max_steps / 2
        self.history = np.zeros(0, HISTORY)
        self.best_quality = -np.inf

    def record(self, step: int, move: float, p: FloatArray, t: IntArray) -> None:
        quality = radius_ratio(p, t)
        row = np.array([(step, move, quality.min(), quality.mean())], HISTORY)
        self.history = np.concatenate((self.history, row))
        self.history.flags.writeable = False  # every mesh of the run shows it
        self.last = p, t
        if step >= self.half_time and quality.min() > self.best_quality:
            self.best_quality = quality.min()
            self.best = p, t


def lattice(bbox: FloatArray, h0: float) -> FloatArray:
    """1. Return the nodes of a lattice of side h0 that fills the box.

    In the plane the corners of equilateral triangles; on a line and in space, of a grid.
    """
    sides = np.full(bbox.shape[1], h0)
    if len(sides) == 2:
        sides[1] *= np.sqrt(3) / 2
    slack = 1e-9 * h0  # so that rounding does not lose the last row
    axes = [np.arange(a, b + slack, side) for (a, b), side in zip(bbox.T, sides, strict=True)]
    p = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    if len(sides) == 2:
        p[:, 1::2, 0] += h0 / 2
    # The first coordinate runs fastest: neighbours in space are neighbours in the list.
    return p.transpose(*range(p.ndim - 2, -1, -1), p.ndim - 1).reshape(-1, len(sides))


def keep_inside(p: FloatArray, region: Region) -> FloatArray:
    """2a. Return the points inside, without those that a fixed point already stands on."""
    return p[region.inside(p)]


def reject(p: FloatArray, region: Region, rng: np.random.Generator) -> FloatArray:
    """2b. Keep each point with a probability proportional to the wanted density, 1 / h**dim."""
    h = region.size(p)
    keep = rng.random(len(p)) < (h.min(initial=np.inf) / h) ** p.shape[1]
    if keep.sum() + len(region.pfix) <= p.shape[1]:
        raise ValueError(
            f"fh keeps {keep.sum()} of {len(p)} points: over the region it goes from {h.min():g} "
            f"to {h.max():g}. Take h0 near the smallest edge you want, or bound fh from below."
        )
    return np.asarray(p[keep])


def lengths(vectors: FloatArray) -> FloatArray:
    """Return the length of each row."""
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))


def longest(vectors: FloatArray) -> float:
    """Return the length of the longest row."""
    return float(lengths(vectors).max(initial=0))


def delaunay(p: FloatArray, center: FloatArray) -> IntArray:
    """Return the Delaunay simplices of the points; on a line, the intervals between neighbours.

    About a centre near the points: far from the origin Qhull would lose the digits that matter.
    """
    if p.shape[1] == 1:
        order = np.argsort(p[:, 0])
        return np.stack((order[:-1], order[1:]), axis=1)
    try:
        return np.asarray(Delaunay(p - center).simplices, dtype=np.int64)
    except QhullError:  # all the points lie on one line, or in one plane
        return np.empty((0, p.shape[1] + 1), dtype=np.int64)


def triangulate(p: FloatArray, region: Region) -> IntArray:
    """3. Return the Delaunay simplices whose centroids lie inside."""
    t = delaunay(p, region.bbox.mean(axis=0))
    t = t[region.distance(p[t].mean(axis=1)) < -region.geps]
    if not len(t):
        raise ValueError(
            f"fd leaves no {'triangle' if p.shape[1] == 2 else 'simplex'} of size "
            f"h0 = {region.h0:g} inside: the region is thinner than h0. Take a smaller h0."
        )
    return t


def incidence(bars: IntArray, nodes: int) -> csr_array:
    """4. Return the matrix D of bars by nodes: +1 where a bar starts, -1 where it ends.

    D p are the bars as vectors, and the transpose of D adds the bars' forces up at the nodes.
    """
    ends = np.tile([1.0, -1.0], len(bars))
    # A copy: SciPy sorts a matrix's indices in place, and these would be the caller's bars.
    return csr_array((ends, bars.flatten(), 2 * np.arange(len(bars) + 1)), (len(bars), nodes))


def bar_forces(D: csr_array, p: FloatArray, h: FloatArray, Fscale: float) -> FloatArray:
    """6. Return the sum, at each node, of the forces of the bars that are too short for h."""
    vectors, dim = D @ p, p.shape[1]
    L = lengths(vectors)
    L0 = h * Fscale * ((L**dim).sum() / (h**dim).sum()) ** (1 / dim)  # thesis eq. (5.7)
    F = np.maximum(L0 - L, 0)  # thesis eq. (5.6), with k = 1: bars push, they never pull
    return np.asarray(D.T @ (vectors * (F / np.maximum(L, 1e-12 * L0))[:, None]))


def project(p: FloatArray, fixed: int, region: Region) -> tuple[FloatArray, FloatArray]:
    """7. Return the points with those outside moved to the boundary, and fd before that.

    A step of Newton's method along the gradient, d grad d / |grad d|**2: exact for a distance,
    and of first order for any smooth function. Fixed points stay where they are.
    """
    d = region.distance(p)
    outside = fixed + np.flatnonzero(d[fixed:] > 0)
    p = p.copy()
    p[outside] -= newton_step(p[outside], d[outside], region)
    return p, d


def newton_step(p: FloatArray, d: FloatArray, region: Region) -> FloatArray:
    """Return d grad d / |grad d|**2, with the gradient by one-sided differences."""
    # Best for a one-sided difference, of a field that varies over h0 at coordinates of that size.
    deps = np.sqrt(np.finfo(float).eps * region.h0 * max(region.h0, np.abs(region.bbox).max()))
    shifts = deps * np.eye(p.shape[1])
    gradient = np.stack([(region.distance(p + e) - d) / deps for e in shifts], axis=1)
    square = (gradient**2).sum(axis=1)
    share = np.divide(d, square, out=np.zeros_like(d), where=square > 0)
    return np.asarray(share[:, None] * gradient)


def _how_far(mesh: Mesh, dptol: float) -> str:
    return (
        f"DistMesh stopped at its cap of {mesh.steps} steps: in the last one a node still "
        f"moved {mesh.history['move'][-1]:.2g} h0, above dptol = {dptol:g}. The best mesh since "
        f"half-time is returned; its least quality is {mesh.quality.min():.2f}, the mean "
        f"{mesh.quality.mean():.3f}. Raise max_steps, or look where the region is thinner than "
        "h0, or fixed points are closer."
    )
