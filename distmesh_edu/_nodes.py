"""The same arithmetic at some nodes of a grid only: where few matter, many times as fast.

A node is a small domain of its own: what lies beyond it along an axis are its neighbours, and a
boundary condition is what says so. So whatever works on a whole array works on scattered nodes.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
Padding = Callable[[Values, int, int], Values]

BLOCK = 4_000
"""Nodes worked on at once: they and their neighbours stay in a core's own cache."""


class Nodes:
    """Some nodes of a grid, each with the numbers of its neighbours along every axis.

    The boundary must copy: put values of the grid, and no others, beyond its rim.
    """

    def __init__(self, chosen: NDArray[np.bool_], width: int, boundary: Callable[..., Any]) -> None:
        self.number = np.flatnonzero(chosen)
        self._width = width
        every = np.arange(chosen.size).reshape(chosen.shape)
        place = np.nonzero(chosen)
        lines = [_lines(boundary(every, width, k), place, k, width) for k in range(chosen.ndim)]
        self._blocks = [
            (slice(start, start + BLOCK), [line[:, start : start + BLOCK] for line in lines])
            for start in range(0, len(self.number), BLOCK)
        ]

    def work(self, function: Callable[..., Values], flat: Values, *others: Values) -> Values:
        """Return `function(phi, boundary, *others)` at the nodes, from all the grid's values.

        The others are arrays of one value for each of the nodes.
        """
        parts = []
        for block, lines in self._blocks:
            dim = len(lines)
            shape = (1,) * dim + (-1,)
            phi = flat[self.number[block]].reshape(shape)
            mine = (other[block].reshape(shape) for other in others)
            parts.append(function(phi, self._neighbours(flat, lines), *mine).ravel())
        return np.concatenate(parts)

    def _neighbours(self, flat: Values, lines: list[NDArray[np.int64]]) -> Padding:
        """Return the padding that puts the nodes' neighbours where an axis asks for ghosts."""

        def padded(_: Values, asked: int, axis: int) -> Values:
            line = lines[axis][self._width - asked : self._width + asked + 1]
            shape = [1] * len(lines) + [line.shape[1]]
            shape[axis] = len(line)
            return flat[line].reshape(shape)

        return padded


def _lines(
    padded: NDArray[np.int64], place: tuple[NDArray[np.int64], ...], axis: int, width: int
) -> NDArray[np.int64]:
    """Return the numbers of the 2 width + 1 nodes about each place, along an axis."""
    rows = []
    for offset in range(2 * width + 1):
        there = list(place)
        there[axis] = place[axis] + offset
        rows.append(padded[tuple(there)])
    return np.array(rows)
