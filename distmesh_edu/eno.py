"""ENO and WENO: derivatives from one side that look for the smoothest data to either side.

Each grid interval gets one polynomial, through the values at its two ends and through one or two
more nodes, chosen where the data are smoothest. Its derivative at the right end of the interval is
that node's derivative from the left, `minus`; at the left end it is that node's `plus`.
"""

from __future__ import annotations

import numpy as np

from ._indexing import along
from ._types import Boundary, FloatArray, scheme
from .boundaries import extrapolated


@scheme(stages=2, width=2, cfl=0.9)
def eno2(
    phi: FloatArray, dx: float, axis: int, *, boundary: Boundary = extrapolated
) -> tuple[FloatArray, FloatArray]:
    """Return one-sided derivatives of second order: a parabola for each interval.

    Parameters
    ----------
    phi : ndarray of any shape
        Values at the nodes.
    dx : float, length
        The spacing along the axis.
    axis : int
        Along which axis.
    boundary : padding function
        What lies beyond the last nodes; see `distmesh_edu.boundaries`.

    Returns
    -------
    minus, plus : ndarray of phi's shape
        The derivatives from the left and from the right, phi per length.

    Notes
    -----
    Thesis section 3.7, equations (3.11) to (3.19). With forward Euler it is unstable in the sense
    of von Neumann: take two Runge-Kutta stages, as its attribute `stages` says.

    Examples
    --------
    >>> minus, plus = eno2(np.array([0.0, 1.0, 4.0, 9.0]), 1.0, 0)
    >>> minus
    array([1., 1., 4., 5.])
    """
    at = along(axis)
    D1, D2 = _newton_coefficients(boundary(phi, 2, axis), dx, axis, 2)
    c = _smaller_of_neighbours(D2, axis)
    slope = D1[at(1, -1)]
    return (slope + c)[at(0, -1)], (slope - c)[at(1)]


@scheme(stages=3, width=3, cfl=0.9)
def eno3(
    phi: FloatArray, dx: float, axis: int, *, boundary: Boundary = extrapolated
) -> tuple[FloatArray, FloatArray]:
    """Return one-sided derivatives of third order: a cubic for each interval.

    Parameters
    ----------
    phi : ndarray of any shape
        Values at the nodes.
    dx : float, length
        The spacing along the axis.
    axis : int
        Along which axis.
    boundary : padding function
        What lies beyond the last nodes; see `distmesh_edu.boundaries`.

    Returns
    -------
    minus, plus : ndarray of phi's shape
        The derivatives from the left and from the right, phi per length.

    Notes
    -----
    Thesis section 3.7, equations (3.11) to (3.21), with the last coefficient D3 / 6 where the
    thesis prints D3 / 3 (erratum E3.7c). Unstable with forward Euler.

    Examples
    --------
    >>> minus, plus = eno3(np.arange(-3.0, 4.0) ** 3, 1.0, 0)
    >>> minus[3], plus[3]
    (np.float64(0.0), np.float64(0.0))
    """
    at = along(axis)
    D1, D2, D3 = _newton_coefficients(boundary(phi, 3, axis), dx, axis, 3)
    left, right = D2[at(1, -2)], D2[at(2, -1)]
    grows_left = np.abs(left) <= np.abs(right)
    c = np.where(grows_left, left, right)
    best = _smaller_of_neighbours(D3, axis)  # for each node, of the two intervals around it
    c_star = np.where(grows_left, best[at(0, -1)], best[at(1)])
    slope = D1[at(2, -2)]
    # 3 (i - k*)**2 - 6 (i - k*) + 2 at both ends of the interval, where i - k*
    # is 1 and 2 if its parabola leans to the left, 0 and 1 if to the right
    at_right_end = slope + c + np.where(grows_left, 2, -1) * c_star
    at_left_end = slope - c + np.where(grows_left, -1, 2) * c_star
    return at_right_end[at(0, -1)], at_left_end[at(1)]


@scheme(stages=3, width=3, cfl=1.0)
def weno5(
    phi: FloatArray, dx: float, axis: int, *, boundary: Boundary = extrapolated
) -> tuple[FloatArray, FloatArray]:
    """Return one-sided derivatives of fifth order: a weighted mean of the three cubics of ENO3.

    Parameters
    ----------
    phi : ndarray of any shape
        Values at the nodes.
    dx : float, length
        The spacing along the axis.
    axis : int
        Along which axis.
    boundary : padding function
        What lies beyond the last nodes; see `distmesh_edu.boundaries`.

    Returns
    -------
    minus, plus : ndarray of phi's shape
        The derivatives from the left and from the right, phi per length.

    Notes
    -----
    Jiang and Peng [JiangPeng2000]_. Where phi is smooth the weights tend to those that give order
    five; a cubic that crosses a kink gets next to no weight. Unstable with forward Euler.

    Examples
    --------
    >>> x = np.linspace(0.0, 1.0, 21)
    >>> minus, plus = weno5(x**4, 0.05, 0)
    >>> round(float(minus[10]), 4)
    0.5
    """
    at = along(axis)
    (D1,) = _newton_coefficients(boundary(phi, 3, axis), dx, axis, 1)
    v = [D1[at(k, k - 4 or None)] for k in range(5)]  # the five slopes about each interval
    a, b, c, d, e = v
    roughness = (
        13 / 12 * (a - 2 * b + c) ** 2 + (a - 4 * b + 3 * c) ** 2 / 4,
        13 / 12 * (b - 2 * c + d) ** 2 + (b - d) ** 2 / 4,
        13 / 12 * (c - 2 * d + e) ** 2 + (3 * c - 4 * d + e) ** 2 / 4,
    )
    tiny = 1e-6 * np.maximum.reduce([slope * slope for slope in v]) + 1e-99
    weights = [1 / (rough + tiny) ** 2 for rough in roughness]
    at_right_end = _mean(
        (0.1, 0.6, 0.3),
        weights,
        ((2 * a - 7 * b + 11 * c) / 6, (-b + 5 * c + 2 * d) / 6, (2 * c + 5 * d - e) / 6),
    )
    at_left_end = _mean(
        (0.3, 0.6, 0.1),
        weights,
        ((-a + 5 * b + 2 * c) / 6, (2 * b + 5 * c - d) / 6, (11 * c - 7 * d + 2 * e) / 6),
    )
    return at_right_end[at(0, -1)], at_left_end[at(1)]


def _newton_coefficients(phi: FloatArray, dx: float, axis: int, order: int) -> list[FloatArray]:
    """Return D^k / k! times dx**(k - 1) for k = 1 to order: each one an array of slopes.

    D^1 belongs to the intervals, D^2 to the nodes between them, D^3 to intervals again.
    """
    coefficients = [np.diff(phi, axis=axis) / dx]
    for k in range(2, order + 1):
        coefficients.append(np.diff(coefficients[-1], axis=axis) / k)
    return coefficients


def _smaller_of_neighbours(values: FloatArray, axis: int) -> FloatArray:
    """Return the one of smaller size of each value and the next; of equals, the left one."""
    at = along(axis)
    size = np.abs(values)
    return np.where(size[at(0, -1)] <= size[at(1)], values[at(0, -1)], values[at(1)])


def _mean(
    ideal: tuple[float, ...], weights: list[FloatArray], values: tuple[FloatArray, ...]
) -> FloatArray:
    """Return the mean of the values, weighted by the ideal weights times those found."""
    parts = [k * weight for k, weight in zip(ideal, weights, strict=True)]
    total = parts[0] + parts[1] + parts[2]
    return sum(part * value for part, value in zip(parts, values, strict=True)) / total
