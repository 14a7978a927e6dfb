"""Checks of meshes and of mesh sizes, as a student makes them; `checks` hands them on."""

from typing import Any

import numpy as np

from ._checking import field_values, node, number, numbers, point, refuse
from ._types import ArrayLike, Field, FloatArray, IntArray
from .gradient_limiting import limit_gradient
from .mesh import Mesh, simplex_volumes

__all__ = ["expect_limited", "expect_mesh"]


def expect_limited(
    h: Any,
    wanted: ArrayLike,
    g: float,
    dx: float,
    *,
    within: float = 1e-6,
    rise: float | None = None,
) -> None:
    """Expect sizes that grow by g dx from node to node at most, and are as large as they can be.

    Parameters
    ----------
    h : array_like, length
        The student's limited sizes.
    wanted : array_like of h's shape, length
        The sizes asked for.
    g : float, dimensionless
        The steepest slope allowed.
    dx : float, length
        The spacing.
    within : float, dimensionless
        How far below the largest possible sizes h may be, as a share of the largest size.
    rise : float, length, optional
        By how much h may grow from node to node, whatever it does along diagonals; if None, no
        more than g dx, nor than the exact formula allows.

    Raises
    ------
    CheckFailed
        If h is above what was asked for, grows too fast, or is smaller than need be.

    Notes
    -----
    Thesis theorem 5.10.1: the largest such function is the minimum over y of h(y) + g |x - y|.

    Examples
    --------
    >>> expect_limited([0.3, 0.1, 0.3], [1.0, 0.1, 1.0], 0.2, 1.0)
    """
    asked_for = np.asarray(wanted, dtype=float)
    sizes = numbers(h, "the limited size", asked_for.shape)
    slack = within * asked_for.max()
    over = sizes - asked_for
    if over.max() > slack:
        worst = np.unravel_index(np.argmax(over), over.shape)
        refuse(
            "the limited size",
            f"at most {number(asked_for[worst])}, which was asked for",
            number(sizes[worst]),
            where=node(worst),
            hint="Limiting makes sizes smaller, never larger.",
        )
    for axis in range(sizes.ndim):
        _expect_rise(sizes, axis, g * dx * (1 + 1e-6) + slack if rise is None else rise)
    _expect_largest(sizes, limit_gradient(asked_for, g, dx), slack, diagonals=rise is None)


def expect_mesh(
    p: Any,
    t: Any,
    *,
    fd: Field | None = None,
    euler: int | None = None,
    volume: float | None = None,
    quality: float = 0.0,
    within: float = 0.02,
) -> None:
    """Expect a mesh: turned the right way round, conforming, without orphans, and of its region.

    Parameters
    ----------
    p : array_like of shape (n, dim), length
        The nodes.
    t : array_like of int, of shape (m, dim + 1)
        The simplices.
    fd : callable, optional
        The region's field: no centroid may lie further outside than `within`.
    euler : int, optional
        The region's Euler characteristic: 1 for a disc, 0 for a ring, 1 for a ball.
    volume : float, length to the power dim, optional
        The region's area or volume, to `within` of itself.
    quality : float, dimensionless
        The least quality that a simplex may have.
    within : float
        The tolerance for `fd` (length) and for `volume` (dimensionless).

    Raises
    ------
    CheckFailed
        That names the first simplex, node or number that is wrong.

    Examples
    --------
    >>> expect_mesh([(0, 0), (1, 0), (0, 1)], [(0, 1, 2)], euler=1, volume=0.5)
    """
    nodes, simplices = _arrays_of_mesh(p, t)
    _expect_turned(nodes, simplices)
    mesh = Mesh(nodes, simplices)
    _expect_conforming(mesh)
    if mesh.quality.min() < quality:
        worst = int(mesh.quality.argmin())
        refuse(
            "the quality",
            f"{quality:g} or more",
            f"{mesh.quality[worst]:.3f}",
            where=f"in simplex {worst}",
        )
    if fd is not None:
        _expect_in_region(mesh, fd, within)
    if euler is not None and mesh.euler_characteristic != euler:
        hint = "A hole takes one away, a piece more adds one: is something filled, torn or loose?"
        refuse("the Euler characteristic", str(euler), str(mesh.euler_characteristic), hint=hint)
    if volume is not None and abs(mesh.volume - volume) > within * volume:
        refuse(
            "the mesh's area" if mesh.dim == 2 else "the mesh's volume",
            number(volume),
            number(mesh.volume),
        )


def _expect_rise(sizes: FloatArray, axis: int, most: float) -> None:
    rises = np.abs(np.diff(sizes, axis=axis))
    if rises.size and rises.max() > most:
        worst = np.unravel_index(np.argmax(rises), rises.shape)
        hint = "Look both ways: a size may not fall too fast either. Is one sweep enough?"
        refuse(
            "the change from node to node",
            f"at most {number(most)}",
            number(rises[worst]),
            where=f"from {node(worst)[3:]}",
            hint=hint,
        )


def _expect_largest(
    sizes: FloatArray, largest: FloatArray, slack: float, *, diagonals: bool
) -> None:
    """Expect sizes no smaller than the exact ones and, if diagonals count, no larger."""
    for sign, said in (
        (-1, "Along the axes it may grow slowly enough; and along a diagonal?"),
        (1, "It may be larger there without growing too fast. Which slope do you allow?"),
    ):
        short = sign * (largest - sizes)
        if (sign > 0 or diagonals) and short.max() > slack:
            worst = np.unravel_index(np.argmax(short), short.shape)
            what, right, found = "the limited size", number(largest[worst]), number(sizes[worst])
            refuse(what, right, found, where=node(worst), hint=said)


def _arrays_of_mesh(p: Any, t: Any) -> tuple[FloatArray, IntArray]:
    """Return nodes and simplices, if they can be those of a mesh."""
    nodes, corners = numbers(p, "the nodes p"), numbers(t, "the simplices t")
    if nodes.ndim != 2 or corners.ndim != 2 or corners.shape[1] != nodes.shape[1] + 1:
        refuse(
            "a mesh",
            "nodes of shape (n, dim) and simplices of shape (m, dim + 1)",
            f"of shapes {nodes.shape} and {corners.shape}",
        )
    if not len(corners):
        refuse("the mesh", "of some simplices", "empty", hint="Which of them did you keep?")
    simplices = corners.astype(np.int64)
    if (simplices != corners).any() or simplices.min() < 0 or simplices.max() >= len(nodes):
        hint = "Nodes are counted from 0."
        refuse(
            "the numbers in t",
            f"from 0 to {len(nodes) - 1}",
            f"{corners.min():g} to {corners.max():g}",
            hint=hint,
        )
    return nodes, simplices


def _expect_turned(nodes: FloatArray, simplices: IntArray) -> None:
    volumes = simplex_volumes(nodes, simplices)
    if (flat := np.abs(volumes) < 1e-14 * np.ptp(nodes) ** nodes.shape[1]).any():
        refuse(f"simplex {flat.argmax()}", "of some size", f"flat ({flat.sum()} are)")
    if (wrong := volumes < 0).any():
        hint = "Its corners run clockwise: exchange two of them."
        refuse(
            f"the area of simplex {wrong.argmax()}",
            "positive",
            f"{volumes[wrong][0]:.4g} ({wrong.sum()} of {len(wrong)} are negative)",
            hint=hint,
        )


def _expect_conforming(mesh: Mesh) -> None:
    if len(mesh.orphans):
        hint = "No simplex uses it: a solver would find no equation there. Renumber the rest."
        refuse(
            f"node {mesh.orphans[0]}",
            "the corner of a simplex",
            f"an orphan ({len(mesh.orphans)} are)",
            hint=hint,
        )
    if len(np.unique(mesh.p.round(12), axis=0)) < len(mesh.p):
        refuse("every node", "at a place of its own", "there twice, some of them")
    turned = [np.delete(np.sort(mesh.t, axis=1), i, axis=1) for i in range(mesh.dim + 1)]
    facets, times = np.unique(np.concatenate(turned), axis=0, return_counts=True)
    if times.max() > 2:
        refuse(
            f"the facet of nodes {facets[times.argmax()]}",
            "shared by two simplices at most",
            f"shared by {times.max()}",
            hint="Do simplices overlap, or stand there twice?",
        )


def _expect_in_region(mesh: Mesh, fd: Field, within: float) -> None:
    centroids = mesh.p[mesh.t].mean(axis=1)
    far = field_values(fd, centroids)
    if far[worst := int(far.argmax())] > within:
        what, found = f"the centroid of simplex {worst}", f"{far[worst]:.4g} outside"
        hint = "Triangles whose centroid is outside, d > 0, are to be taken out."
        refuse(what, "inside the region", found, where=point(centroids[worst]), hint=hint)
