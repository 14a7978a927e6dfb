"""The same arithmetic on slabs that fit into the processor's cache: some three times as fast.

On a large array NumPy's time goes into fetching fresh memory for each intermediate result. A slab,
some rows of the array, is a small domain of its own: what lies beyond it are its neighbours' rows,
and a boundary condition is what says so. So whatever works on a whole array works on a slab.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
Padding = Callable[[Values, int, int], Values]

SLAB = 24_000
"""Nodes of a slab: a dozen intermediate arrays of this size stay in a core's own cache."""

ROWS = 4
"""The fewest rows of a slab: with fewer, most of the work along the first axis is done twice."""


def slabs(shape: tuple[int, ...]) -> Iterator[slice]:
    """Yield the rows of one slab after the other."""
    rows = max(ROWS, SLAB // max(1, int(np.prod(shape[1:]))))
    for start in range(0, shape[0], rows):
        yield slice(start, min(start + rows, shape[0]))


def in_slabs(
    function: Callable[..., Values],
    phi: Values,
    boundary: Padding,
    width: int | None,
    *others: NDArray[Any],
) -> Values:
    """Return `function(phi, boundary, *others)`, worked out slab by slab.

    The function may look `width` nodes beyond its rows, by calling `boundary` on the rows it was
    given; with None it is given the whole. The others are arrays of phi's shape, or of none.
    """
    whole = next(slabs(phi.shape)).stop == len(phi)
    if width is None or whole:
        return function(phi, boundary, *others)
    padded = boundary(phi, width, 0)
    out = np.empty_like(phi)
    with np.errstate():  # which gives the buffer its size back at the end
        np.setbufsize(64)  # slices of a slab are added faster where they are not buffered first
        for slab in slabs(phi.shape):
            around = padded[slab.start : slab.stop + 2 * width]
            parts = (other[slab] if other.ndim else other for other in others)
            out[slab] = function(phi[slab], _neighbours(around, width, boundary), *parts)
    return out


def _neighbours(around: Values, width: int, boundary: Padding) -> Padding:
    """Return the padding that puts a slab's neighbours where the first axis asks for ghosts."""

    def padded(slab: Values, asked: int, axis: int) -> Values:
        if axis:
            return boundary(slab, asked, axis)
        if asked > width:
            raise ValueError(
                f"differences looks at {asked} nodes on either side, and its attribute width says "
                f"{width}. Set width to {asked}."
            )
        return around[width - asked : len(around) - (width - asked)]

    return padded
