"""The one idea of the library, as a type: a field takes points and returns one value a point."""

from collections.abc import Callable
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
Field = Callable[[FloatArray], FloatArray]

Boundary = Callable[[FloatArray, int, int], FloatArray]
"""Takes values, a width and an axis; returns the values with `width` ghost nodes at both ends."""


class Differences(Protocol):
    """A scheme: the two one-sided derivatives of phi along an axis, both of phi's shape."""

    stages: int
    """The order of the Runge-Kutta method that goes with it."""

    width: int
    """How many nodes on either side it looks at."""

    cfl: float
    """Up to which CFL number it was seen to be stable, with that method."""

    __name__: str

    def __call__(
        self, phi: FloatArray, dx: float, axis: int, *, boundary: Boundary = ...
    ) -> tuple[FloatArray, FloatArray]:
        """Return the derivatives from the left and from the right, (minus, plus)."""


def scheme(*, stages: int, width: int, cfl: float) -> Callable[[Callable[..., Any]], Differences]:
    """Give a function the attributes of a scheme: it stays the function that it is."""

    def mark(function: Callable[..., Any]) -> Differences:
        marked = cast(Differences, function)
        marked.stages, marked.width, marked.cfl = stages, width, cfl
        return marked

    return mark


__all__ = [
    "ArrayLike",
    "BoolArray",
    "Boundary",
    "Differences",
    "Field",
    "FloatArray",
    "IntArray",
    "scheme",
]
