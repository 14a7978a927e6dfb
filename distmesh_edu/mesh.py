"""The mesh: points, triangles, and what can be measured on them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ._types import ArrayLike, FloatArray, IntArray
from ._validation import as_points

#: One row of `Mesh.history`: how the mesh stood at a retriangulation.
HISTORY = np.dtype(
    [
        ("step", np.int64),
        ("move", np.float64),
        ("minimum_quality", np.float64),
        ("mean_quality", np.float64),
    ]
)


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangulation: points p, triangles t, and how they came about.

    It unpacks as ``p, t``.

    Parameters
    ----------
    p : array_like of shape (n, 2), length
        The nodes.
    t : array_like of int, of shape (m, 3)
        Each row holds the numbers of a triangle's corners. A clockwise triangle is turned round:
        in a mesh all run anticlockwise.
    converged : bool
        Whether the generator reached its equilibrium, rather than its cap of steps.
    steps : int
        How many steps it took.
    history : ndarray of dtype HISTORY
        A row for each retriangulation: its step, the largest move of an interior node in the
        step before it (in units of h0), and the least and the mean quality.

    Raises
    ------
    ValueError
        If the shapes are others, or `t` names a node that does not exist.

    Examples
    --------
    >>> mesh = Mesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 3, 2)])
    >>> mesh.area, mesh.euler_characteristic, len(mesh.edges)
    (1.0, 1, 5)
    >>> mesh.t.tolist()
    [[0, 1, 2], [3, 0, 2]]
    """

    p: FloatArray
    t: IntArray
    converged: bool = True
    steps: int = 0
    history: NDArray[np.void] = field(default_factory=lambda: np.zeros(0, HISTORY), repr=False)

    def __post_init__(self) -> None:
        p, t = as_points("p", self.p, dim=2), _as_triangles(self.t, len(self.p))
        object.__setattr__(self, "p", p)
        object.__setattr__(self, "t", oriented(p, t))

    def __iter__(self) -> Iterator[FloatArray | IntArray]:
        return iter((self.p, self.t))

    def __repr__(self) -> str:
        ended = "converged" if self.converged else "not converged"
        return f"Mesh({len(self.p)} nodes, {len(self.t)} triangles, {ended}, {self.steps} steps)"

    @cached_property
    def areas(self) -> FloatArray:
        """The signed area of each triangle (length squared): positive, or 0 where it is flat."""
        return signed_areas(self.p, self.t)

    @property
    def area(self) -> float:
        """The sum of the areas (length squared)."""
        return float(self.areas.sum())

    @cached_property
    def orientation(self) -> IntArray:
        """1 for each triangle, which runs anticlockwise in a mesh, and 0 for a flat one."""
        return np.asarray(np.sign(self.areas), dtype=np.int64)

    @cached_property
    def quality(self) -> FloatArray:
        """The radius ratio 2 r_in / r_circ of each triangle: 1 equilateral, 0 flat."""
        return radius_ratio(self.p, self.t)

    @cached_property
    def edges(self) -> IntArray:
        """The edges, of shape (k, 2): each once, with the smaller node number first."""
        return unique_edges(self.t)

    @cached_property
    def boundary_facets(self) -> IntArray:
        """The edges of one triangle only, of shape (k, 2), with the region on their left."""
        directed = self.t[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        _, first, count = np.unique(_keys(directed), return_index=True, return_counts=True)
        return np.asarray(directed[np.sort(first[count == 1])])

    @cached_property
    def edge_lengths(self) -> FloatArray:
        """The length of each row of `edges`."""
        vectors = self.p[self.edges[:, 0]] - self.p[self.edges[:, 1]]
        return np.hypot(vectors[:, 0], vectors[:, 1])

    @property
    def euler_characteristic(self) -> int:
        """Nodes in use - edges + triangles: the number of pieces less the number of holes."""
        return len(np.unique(self.t)) - len(self.edges) + len(self.t)


def signed_areas(p: FloatArray, t: IntArray) -> FloatArray:
    """Return the area of each triangle, positive where its corners run anticlockwise.

    Parameters
    ----------
    p : ndarray of shape (n, 2), length
    t : ndarray of int, of shape (m, 3)

    Returns
    -------
    ndarray of shape (m,), length squared

    Examples
    --------
    >>> signed_areas(np.array([[0.0, 0], [1, 0], [0, 1]]), np.array([[0, 1, 2], [0, 2, 1]]))
    array([ 0.5, -0.5])
    """
    a, b, c = p[t].transpose(1, 2, 0)
    return np.asarray((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2


def oriented(p: FloatArray, t: IntArray) -> IntArray:
    """Return the triangles with two corners exchanged in each clockwise one.

    Parameters
    ----------
    p : ndarray of shape (n, 2), length
    t : ndarray of int, of shape (m, 3)

    Returns
    -------
    ndarray of int, of shape (m, 3)

    Examples
    --------
    >>> oriented(np.array([[0.0, 0], [1, 0], [0, 1]]), np.array([[0, 2, 1]]))
    array([[2, 0, 1]])
    """
    clockwise = signed_areas(p, t) < 0
    return np.where(clockwise[:, None], t[:, [1, 0, 2]], t) if clockwise.any() else t


def radius_ratio(p: FloatArray, t: IntArray) -> FloatArray:
    """Return 2 r_in / r_circ for each triangle: 1 if equilateral, 0 if flat.

    Parameters
    ----------
    p : ndarray of shape (n, 2), length
    t : ndarray of int, of shape (m, 3)

    Returns
    -------
    ndarray of shape (m,), dimensionless

    Notes
    -----
    With sides a, b, c and area A, r_in = 2A / (a + b + c) and r_circ = abc / 4A, so that the
    ratio is 16 A**2 / (abc (a + b + c)).

    Examples
    --------
    >>> radius_ratio(np.array([[0.0, 0], [4, 0], [0, 3]]), np.array([[0, 1, 2]]))
    array([0.8])
    """
    corners = p[t]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    product = sides.prod(axis=1) * sides.sum(axis=1)
    flat = product == 0  # three corners in one place
    return 16 * signed_areas(p, t) ** 2 / np.where(flat, 1, product)


def unique_edges(t: IntArray) -> IntArray:
    """Return every edge of the triangles once, the smaller node number first.

    Parameters
    ----------
    t : ndarray of int, of shape (m, 3)

    Returns
    -------
    ndarray of int, of shape (k, 2)
        In ascending order.

    Examples
    --------
    >>> unique_edges(np.array([[0, 1, 2], [2, 1, 3]])).tolist()
    [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]]
    """
    pairs = t[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    keys = np.unique(_keys(pairs))  # one number an edge sorts far faster than rows do
    return np.stack((keys >> 32, keys & 0xFFFFFFFF), axis=1)


def _keys(pairs: IntArray) -> IntArray:
    """Return one number for each pair of nodes, whatever their order."""
    pairs = pairs.astype(np.int64, copy=False)  # 32 bits would not hold it
    return np.asarray((pairs.min(axis=1) << 32) | pairs.max(axis=1))


def _as_triangles(t: ArrayLike, nodes: int) -> IntArray:
    try:
        rows = np.asarray(t)
    except ValueError as error:
        raise ValueError(f"t must hold three node numbers a row; {error}.") from error
    if rows.size == 0:
        rows = rows.reshape(0, 3).astype(np.int64)
    if rows.ndim != 2 or rows.shape[1] != 3 or not np.issubdtype(rows.dtype, np.integer):
        raise ValueError(
            f"t must hold three node numbers a row; got the shape {rows.shape} of {rows.dtype}."
        )
    if rows.size and not (rows.min() >= 0 and rows.max() < nodes):
        raise ValueError(
            f"t must name nodes 0 to {nodes - 1}; it holds {rows.min()} to {rows.max()}. "
            "Numbers start at 0."
        )
    a, b, c = rows.T
    twice = (a == b) | (b == c) | (c == a)
    if twice.any():
        raise ValueError(f"t names a node twice in {rows[int(np.argmax(twice))].tolist()}.")
    return rows.astype(np.int64)
