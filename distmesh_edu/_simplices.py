"""The formulas for simplices, one body for intervals, triangles and tetrahedra, and who meets whom.

Inside, arrays run over components first and over the m simplices last: each line then works on
long rows of numbers, several times faster than on short ones.
"""

from __future__ import annotations

from itertools import combinations
from math import factorial, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: The corners of each facet of a simplex, in an order that turns it outward.
FACETS = {
    1: np.array([(1,), (0,)]),
    2: np.array([(0, 1), (1, 2), (2, 0)]),
    3: np.array([(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)]),
}


def simplex_volumes(p: FloatArray, t: IntArray) -> FloatArray:
    """Return det(a_1, ..., a_dim) / dim! for each simplex, a_i its edges from the first corner.

    That is its length, area or volume, positive where its corners run to the right, anticlockwise,
    or as the right-hand rule has it; negative in its mirror image.

    Parameters
    ----------
    p : ndarray of shape (n, dim), length
    t : ndarray of int, of shape (m, dim + 1)

    Returns
    -------
    ndarray of shape (m,), length to the power dim

    Examples
    --------
    >>> simplex_volumes(np.array([[0.0, 0], [1, 0], [0, 1]]), np.array([[0, 1, 2], [0, 2, 1]]))
    array([ 0.5, -0.5])
    """
    a = _edges_from_first_corner(p, t)
    return np.asarray(_determinant(a) / factorial(len(a)))


def oriented(p: FloatArray, t: IntArray) -> IntArray:
    """Return the simplices with two corners exchanged in each that has a negative volume.

    Parameters
    ----------
    p : ndarray of shape (n, dim), length
    t : ndarray of int, of shape (m, dim + 1)

    Returns
    -------
    ndarray of int, of shape (m, dim + 1)

    Examples
    --------
    >>> oriented(np.array([[0.0, 0], [1, 0], [0, 1]]), np.array([[0, 2, 1]]))
    array([[2, 0, 1]])
    """
    mirrored = _determinant(_edges_from_first_corner(p, t)) < 0
    if not mirrored.any():
        return t
    swapped = [1, 0, *range(2, t.shape[1])]
    return np.where(mirrored[:, None], t[:, swapped], t)


def radius_ratio(p: FloatArray, t: IntArray) -> FloatArray:
    """Return dim r_in / r_circ for each simplex: 1 if all its edges are equal, 0 if it is flat.

    Parameters
    ----------
    p : ndarray of shape (n, dim), length
    t : ndarray of int, of shape (m, dim + 1)

    Returns
    -------
    ndarray of shape (m,), dimensionless

    Notes
    -----
    With the edges a_i from corner 0, their determinant D, and the normals n_i of the facets
    opposite the corners, of such lengths that a_i . n_i = D: the heights are D / |n_i|, so that
    r_in = D / sum |n_i|, and the circumcentre, seen from corner 0, is sum |a_i|**2 n_i / 2D.

    Examples
    --------
    >>> radius_ratio(np.array([[0.0, 0], [4, 0], [0, 3]]), np.array([[0, 1, 2]]))
    array([0.8])
    """
    a = _edges_from_first_corner(p, t)
    n = _normals(a)
    determinant = _dot(a[:, 0], n[:, 1])
    centre = (_dot(a, a) * n[:, 1:]).sum(axis=1)
    product = _length(n).sum(axis=0) * _length(centre)
    flat = product == 0  # all corners in one place
    return 2 * len(a) * determinant**2 / np.where(flat, 1, product)


def mean_ratio(p: FloatArray, t: IntArray) -> FloatArray:
    """Return the mean ratio of each simplex: 1 if all its edges are equal, 0 if it is flat.

    It compares the volume with the mean of the squared lengths of the edges.

    Parameters
    ----------
    p : ndarray of shape (n, dim), length
    t : ndarray of int, of shape (m, dim + 1)

    Returns
    -------
    ndarray of shape (m,), dimensionless

    Notes
    -----
    (V / V_1)**(2 / dim) / mean(l**2), where V_1 = sqrt((dim + 1) / 2**dim) / dim! is the volume of
    the simplex whose edges are 1: 4 sqrt(3) A / sum(l**2) for a triangle.

    Examples
    --------
    >>> mean_ratio(np.array([[0.0, 0], [1, 0], [0, 1]]), np.array([[0, 1, 2]])).round(3)
    array([0.866])
    """
    a = _edges_from_first_corner(p, t)
    dim = len(a)
    i, j = np.array(list(combinations(range(dim), 2)), dtype=np.int64).reshape(-1, 2).T
    between = a[:, i] - a[:, j]  # the edges that do not meet the first corner
    squares = _dot(a, a).sum(axis=0) + _dot(between, between).sum(axis=0)
    mean = squares / (dim * (dim + 1) / 2)
    volume = np.abs(_determinant(a)) / sqrt((dim + 1) / 2**dim)
    return np.asarray(volume ** (2 / dim) / np.where(mean == 0, 1, mean))


def minimum_angle(p: FloatArray, t: IntArray) -> FloatArray:
    """Return the smallest angle between two facets of each triangle or tetrahedron, in degrees.

    At most 60 in a triangle; dihedral in a tetrahedron, and at most arccos(1/3), about 70.5.

    Parameters
    ----------
    p : ndarray of shape (n, dim), length
    t : ndarray of int, of shape (m, dim + 1)

    Returns
    -------
    ndarray of shape (m,), degrees

    Raises
    ------
    ValueError
        If the simplices are intervals, which have no angles.

    Examples
    --------
    >>> minimum_angle(np.array([[0.0, 0], [1, 0], [0, 1]]), np.array([[0, 1, 2]]))
    array([45.])
    """
    a = _edges_from_first_corner(p, t)
    if len(a) == 1:
        raise ValueError("an interval has no angles; minimum_angle is for triangles, tetrahedra.")
    n = _normals(a)
    i, j = np.array(list(combinations(range(len(a) + 1), 2))).T
    # Facets that meet at the angle A have inward normals that meet at 180 degrees less A.
    cosine = 0.0 - _dot(n[:, i], n[:, j])  # not -x: where a facet is a point, it must not be -0.0
    sine = _length(_cross(n[:, i], n[:, j]))
    return np.asarray(np.degrees(np.arctan2(sine, cosine).min(axis=0)))


def unique_edges(t: IntArray) -> IntArray:
    """Return every edge of the simplices once, the smaller node number first.

    Parameters
    ----------
    t : ndarray of int, of shape (m, dim + 1)

    Returns
    -------
    ndarray of int, of shape (k, 2)
        In ascending order.

    Examples
    --------
    >>> unique_edges(np.array([[0, 1, 2], [2, 1, 3]])).tolist()
    [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]]
    """
    i, j = np.array(list(combinations(range(t.shape[1]), 2))).T
    a, b = t[:, i].ravel(), t[:, j].ravel()
    nodes = int(t.max(initial=0)) + 1
    # A sparse matrix has each entry once: to make one takes half the time of sorting the pairs.
    entries = np.ones(len(a), dtype=bool)
    matrix = csr_array((entries, (np.minimum(a, b), np.maximum(a, b))), shape=(nodes, nodes))
    matrix.sum_duplicates()
    first = np.repeat(np.arange(nodes), np.diff(matrix.indptr))
    return np.stack((first, matrix.indices.astype(np.int64, copy=False)), axis=1)


def boundary_facets(t: IntArray) -> IntArray:
    """Return the facets that belong to one simplex only, turned outward.

    Parameters
    ----------
    t : ndarray of int, of shape (m, dim + 1)
        Of positive volume: see `oriented`.

    Returns
    -------
    ndarray of int, of shape (k, dim)
        In the plane edges with the region on their left. In space triangles that run anticlockwise
        for who looks at them from outside. On a line the two ends of each piece.

    Examples
    --------
    >>> boundary_facets(np.array([[0, 1, 2], [2, 1, 3]])).tolist()
    [[0, 1], [2, 0], [1, 3], [3, 2]]
    """
    return facets_and_owners(t)[0]


def facets_and_owners(t: IntArray) -> tuple[IntArray, IntArray]:
    """Return the facets of one simplex only, and the number of the simplex of each.

    Parameters
    ----------
    t : ndarray of int, of shape (m, dim + 1)

    Returns
    -------
    facets : ndarray of int, of shape (k, dim)
    owners : ndarray of int, of shape (k,)
        In ascending order.

    Examples
    --------
    >>> facets_and_owners(np.array([[0, 1, 2], [2, 1, 3]]))[1].tolist()
    [0, 0, 1, 1]
    """
    facets = t[:, FACETS[t.shape[1] - 1]].reshape(-1, t.shape[1] - 1)
    total = len(facets)
    # Each facet adds the total and its number: a sum below twice the total is of one alone.
    sums = _facet_matrix(t).data
    alone = np.sort(sums[sums < 2 * total]) - total
    return np.asarray(facets[alone]), alone // t.shape[1]


def number_of_facets(t: IntArray) -> int:
    """Return how many different facets the simplices have.

    Parameters
    ----------
    t : ndarray of int, of shape (m, dim + 1)

    Returns
    -------
    int

    Examples
    --------
    >>> number_of_facets(np.array([[0, 1, 2], [2, 1, 3]]))
    5
    """
    return int(_facet_matrix(t).nnz)


def _facet_matrix(t: IntArray) -> csr_array:
    """Return the sparse matrix with an entry for each facet, the sum over who has it."""
    corners = t.T[FACETS[t.shape[1] - 1]].astype(np.int64, copy=False)
    least, greatest, total = corners.min(axis=1), corners.max(axis=1), corners.sum(axis=1)
    # These three tell facets of up to three nodes apart; two of them make one column.
    nodes = int(t.max(initial=0)) + 1
    columns = (total - least) * nodes + greatest
    numbers = np.arange(t.size).reshape(t.shape).T + t.size
    matrix = csr_array(
        (numbers.ravel(), (least.ravel(), columns.ravel())), shape=(nodes, 2 * nodes**2)
    )
    matrix.sum_duplicates()
    return matrix


def _edges_from_first_corner(p: FloatArray, t: IntArray) -> FloatArray:
    """Return the edges a_1 ... a_dim from corner 0, of shape (dim, dim, m): components first."""
    corners = np.take(np.ascontiguousarray(p.T), t.T, axis=1)
    return np.asarray(corners[:, 1:] - corners[:, :1])


def _determinant(a: FloatArray) -> FloatArray:
    if len(a) == 1:
        return np.asarray(a[0, 0])
    normal = _cross(a[:, -2], a[:, -1])
    return np.asarray(normal[0]) if len(a) == 2 else _dot(a[:, 0], normal)


def _normals(a: FloatArray) -> FloatArray:
    """Return n_0 ... n_dim, normal to the facet opposite each corner, of shape (dim, dim + 1, m).

    They point inward if the volume is positive, and add up to nothing; a_i . n_i = D.
    """
    if len(a) == 1:
        others = np.ones_like(a)
    elif len(a) == 2:
        (ax, bx), (ay, by) = a
        others = np.array([(by, -ay), (-bx, ax)])
    else:
        others = np.asarray(_cross(a[:, [1, 2, 0]], a[:, [2, 0, 1]]))
    return np.concatenate((-others.sum(axis=1, keepdims=True), others), axis=1)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the components of a x b: one in the plane, three in space."""
    if len(a) == 2:
        return np.asarray([a[0] * b[1] - a[1] * b[0]])
    axes = ((1, 2), (2, 0), (0, 1))
    return np.asarray([a[i] * b[j] - a[j] * b[i] for i, j in axes])


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray((a * b).sum(axis=0))


def _length(a: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(_dot(a, a)))
