"""What lies beyond the last node: padding functions, which put ghost values at both ends.

A difference scheme looks a few nodes to either side, and at the end of the grid there are none.
Each function here says what to imagine there. They share one signature, (phi, width, axis), and
stand wherever a solver takes `boundary`; a function of yours with that signature will do as well.
It must continue each line of nodes by itself, for a solver may hand it some lines at a time.
"""

from __future__ import annotations

import numpy as np

from ._indexing import along
from ._types import FloatArray


def periodic(phi: FloatArray, width: int, axis: int) -> FloatArray:
    """Continue phi by itself: what leaves on the right comes back on the left.

    Parameters
    ----------
    phi : ndarray of any shape
        Values at the nodes. The first node is not stored again at the end: a period of length 1
        with a spacing of 0.1 has ten nodes (`Grid` with `periodic=True` leaves it out).
    width : int
        How many ghost values to put at either end.
    axis : int
        Along which axis.

    Returns
    -------
    ndarray
        Longer by 2 width along the axis.

    Examples
    --------
    >>> periodic(np.array([0.0, 1.0, 2.0]), 1, 0)
    array([2., 0., 1., 2., 0.])
    """
    nodes = phi.shape[axis]
    if width > nodes:  # once round is not enough
        return np.asarray(np.take(phi, np.arange(-width, nodes + width) % nodes, axis))
    at = along(axis)
    return np.concatenate((phi[at(nodes - width)], phi, phi[at(0, width)]), axis)


def neumann(phi: FloatArray, width: int, axis: int) -> FloatArray:
    """Continue phi by its last value: slope zero beyond the box, so that nothing comes in.

    Parameters
    ----------
    phi : ndarray of any shape
        Values at the nodes.
    width : int
        How many ghost values to put at either end.
    axis : int
        Along which axis.

    Returns
    -------
    ndarray
        Longer by 2 width along the axis.

    Examples
    --------
    >>> neumann(np.array([0.0, 1.0, 3.0]), 2, 0)
    array([0., 0., 0., 1., 3., 3., 3.])
    """
    at = along(axis)
    first, last = phi[at(0, 1)], phi[at(-1)]
    return np.concatenate((*[first] * width, phi, *[last] * width), axis)


def extrapolated(phi: FloatArray, width: int, axis: int) -> FloatArray:
    """Continue phi by the straight line through its last two values.

    Parameters
    ----------
    phi : ndarray of any shape, with two nodes at least along the axis
        Values at the nodes.
    width : int
        How many ghost values to put at either end.
    axis : int
        Along which axis.

    Returns
    -------
    ndarray
        Longer by 2 width along the axis.

    Raises
    ------
    ValueError
        If there is only one node along the axis.

    Notes
    -----
    Right where a smooth phi goes on as it came. A front that should only leave may find a way in
    through such ghosts, for they believe whatever slope stands at the rim: `reinitialize`
    takes `neumann` for that reason.

    Examples
    --------
    >>> extrapolated(np.array([0.0, 1.0, 3.0]), 2, 0)
    array([-2., -1.,  0.,  1.,  3.,  5.,  7.])
    """
    if phi.shape[axis] < 2:
        raise ValueError(
            f"phi must have 2 nodes at least along axis {axis}, for a line takes two; got the "
            f"shape {phi.shape}. Take a finer grid, or neumann."
        )
    at = along(axis)
    first, last = phi[at(0, 1)], phi[at(-1)]
    steps = range(1, width + 1)
    before = [first - step * (phi[at(1, 2)] - first) for step in reversed(steps)]
    after = [last + step * (last - phi[at(-2, -1)]) for step in steps]
    return np.concatenate((*before, phi, *after), axis)
