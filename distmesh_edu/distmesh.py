"""DistMesh in the plane: a truss that relaxes, retriangulated as it moves, held by a distance.

The algorithm of Persson and Strang in the eight steps of section 5.5 of the thesis, one function
a step, with the five corrections that the book's errata prove necessary.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import Delaunay, QhullError, cKDTree

from ._types import ArrayLike, Field, FloatArray, IntArray
from ._validation import Region, as_count, as_generator, as_positive, as_region
from ._warnings import ConvergenceWarning
from .mesh import HISTORY, Mesh, radius_ratio, unique_edges

# The functions of the single steps are for reading, and for whoever builds on them.
__all__ = ["distmesh2d", "distmesh2d_steps"]


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
    steps = distmesh2d_steps(
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
    )
    for mesh in steps:
        last = mesh
    if not last.converged:
        warnings.warn(_how_far(last, dptol), ConvergenceWarning, stacklevel=2)
    return last


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
    tuning = {"dptol": dptol, "ttol": ttol, "Fscale": Fscale, "deltat": deltat}
    for name, value in tuning.items():
        as_positive(name, value)
    steps = as_count("max_steps", max_steps)
    return _relax(region, as_generator(rng), steps, **tuning)


def _relax(
    region: Region,
    rng: np.random.Generator,
    max_steps: int,
    dptol: float,
    ttol: float,
    Fscale: float,
    deltat: float,
) -> Iterator[Mesh]:
    # 1. Distribute points over the box
    p = triangular_lattice(region.bbox, region.h0)
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
        F = bar_forces(p, bars, D, region, Fscale)
        F[:fixed] = 0
        before, p = p, p + deltat * F
        # 7. Bring points back to the boundary
        p, interior = project(p, fixed, region)
        # 8. Stop when the interior is at rest (if there is none, the boundary)
        moves = deltat * F[interior] if len(interior) else p - before
        move = longest(moves) / region.h0
        if move < dptol:
            break

    yield _at_the_end(p, region, log, step + 1, move, move < dptol)


def _at_the_end(
    p: FloatArray, region: Region, log: _Log, steps: int, move: float, converged: bool
) -> Mesh:
    """Return the mesh with triangles that belong to its nodes; if it never settled, the best."""
    log.record(steps, move, p, triangulate(p, region))
    p, t = log.last if converged else log.best
    # A node that a place thinner than h0 has left without a triangle would make a solver fail.
    used = np.union1d(np.arange(len(region.pfix)), t)
    return Mesh(p[used], np.searchsorted(used, t), converged, steps, log.history)


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


def triangular_lattice(bbox: FloatArray, h0: float) -> FloatArray:
    """1. Return the corners of equilateral triangles of side h0 that fill the box."""
    (x0, y0), (x1, y1) = bbox
    slack = 1e-9 * h0  # so that rounding does not lose the last row
    x, y = np.meshgrid(
        np.arange(x0, x1 + slack, h0), np.arange(y0, y1 + slack, h0 * np.sqrt(3) / 2)
    )
    x[1::2] += h0 / 2
    return np.stack((x.ravel(), y.ravel()), axis=1)


def keep_inside(p: FloatArray, region: Region) -> FloatArray:
    """2a. Return the points inside, without those that a fixed point already stands on."""
    lattice, p = p, p[region.distance(p) < region.geps]
    if len(region.pfix):
        gap, _ = cKDTree(region.pfix).query(p)
        p = p[gap > 1e-6 * region.h0]
    if len(p) + len(region.pfix) < 3:
        raise ValueError(
            f"fd leaves {len(p)} points inside of a lattice of side h0 = {region.h0:g} in the "
            "box: the region is empty, thinner than h0, or elsewhere. Take a smaller h0, check "
            "bbox, or pass complement(fd) if fd is positive inside."
        )
    _check_slope(region.slope(lattice))
    return p


def reject(p: FloatArray, region: Region, rng: np.random.Generator) -> FloatArray:
    """2b. Keep each point with a probability proportional to the wanted density, 1 / h**2."""
    h = region.size(p)
    keep = rng.random(len(p)) < (h.min(initial=np.inf) / h) ** 2
    if keep.sum() + len(region.pfix) < 3:
        raise ValueError(
            f"fh keeps {keep.sum()} of {len(p)} points: over the region it goes from {h.min():g} "
            f"to {h.max():g}. Take h0 near the smallest edge you want, or bound fh from below."
        )
    return np.asarray(p[keep])


def longest(vectors: FloatArray) -> float:
    """Return the length of the longest row."""
    return float(np.hypot(vectors[:, 0], vectors[:, 1]).max(initial=0))


def triangulate(p: FloatArray, region: Region) -> IntArray:
    """3. Return the Delaunay triangles whose centroids lie inside."""
    try:
        # About the box's center: far from the origin Qhull would lose the digits that matter.
        t: IntArray = Delaunay(p - region.bbox.mean(axis=0)).simplices.astype(np.int64)
    except QhullError:  # all the points lie on one line
        t = np.empty((0, 3), dtype=np.int64)
    centroids = p[t].mean(axis=1)
    t = t[region.distance(centroids) < -region.geps]
    if not len(t):
        raise ValueError(
            f"fd leaves no triangle of size h0 = {region.h0:g} inside: the region is thinner "
            "than h0. Take a smaller h0."
        )
    return t


def incidence(bars: IntArray, nodes: int) -> csr_array:
    """4. Return the matrix D of bars by nodes: +1 where a bar starts, -1 where it ends.

    D p are the bars as vectors, and the transpose of D adds the bars' forces up at the nodes.
    """
    ends = np.tile([1.0, -1.0], len(bars))
    return csr_array((ends, bars.ravel(), 2 * np.arange(len(bars) + 1)), (len(bars), nodes))


def bar_forces(
    p: FloatArray, bars: IntArray, D: csr_array, region: Region, Fscale: float
) -> FloatArray:
    """6. Return the sum, at each node, of the forces of the bars that are too short."""
    vectors = D @ p
    L = np.hypot(vectors[:, 0], vectors[:, 1])
    h = region.size((p[bars[:, 0]] + p[bars[:, 1]]) / 2)
    L0 = h * Fscale * np.sqrt((L**2).sum() / (h**2).sum())  # thesis eq. (5.7)
    F = np.maximum(L0 - L, 0)  # thesis eq. (5.6), with k = 1: bars push, they never pull
    return np.asarray(D.T @ (vectors * (F / np.maximum(L, 1e-12 * L0))[:, None]))


def project(p: FloatArray, fixed: int, region: Region) -> tuple[FloatArray, IntArray]:
    """7. Return the points with those outside moved to the boundary, and which are interior.

    A step of Newton's method along the gradient, d grad d / |grad d|**2: exact for a distance,
    and of first order for any smooth function. Fixed points stay where they are.
    """
    d = region.distance(p)
    outside = fixed + np.flatnonzero(d[fixed:] > 0)
    q, dq = p[outside], d[outside]
    # Best for a one-sided difference, of a field that varies over h0 at coordinates of that size.
    deps = np.sqrt(np.finfo(float).eps * region.h0 * max(region.h0, np.abs(region.bbox).max()))
    shifts = deps * np.eye(2)
    gradient = np.stack([(region.distance(q + e) - dq) / deps for e in shifts], axis=1)
    square = (gradient**2).sum(axis=1)
    step = np.divide(dq, square, out=np.zeros_like(dq), where=square > 0)
    p = p.copy()
    p[outside] = q - step[:, None] * gradient
    return p, np.flatnonzero(d < -region.geps)


def _check_slope(slope: float) -> None:
    """Refuse an fd that is far from a length: the tolerances compare it with h0."""
    if not 0.02 < slope < 50:
        raise ValueError(
            f"fd must be a distance, or nearly so: near its zeros its gradient should have a "
            f"length of about 1, and has {slope:.2g}. Divide fd by that."
        )


def _how_far(mesh: Mesh, dptol: float) -> str:
    return (
        f"distmesh2d stopped at its cap of {mesh.steps} steps: in the last one a node still "
        f"moved {mesh.history['move'][-1]:.2g} h0, above dptol = {dptol:g}. The best mesh since "
        f"half-time is returned; its least quality is {mesh.quality.min():.2f}, the mean "
        f"{mesh.quality.mean():.3f}. Raise max_steps, or look where the region is thinner than "
        "h0, or fixed points are closer."
    )
