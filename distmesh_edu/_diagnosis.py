"""What kind of wrong numbers are: turned round, twice too large, one node late."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Same = Callable[[FloatArray, FloatArray], bool]

# Factors that people forget, and what to say of them.
FACTORS = {
    -1: "Your values have the wrong sign.",
    2: "Your values are twice too large: a factor 2 is missing or there once too often.",
    0.5: "Your values are half of what they should be: look for a factor 2.",
    -2: "Your values have the wrong sign, and are twice too large.",
    -0.5: "Your values have the wrong sign, and half the size.",
}


def diagnosis(found: FloatArray, expected: FloatArray, tolerance: float) -> str:
    """Return a hint on how wrong values differ from right ones; nothing if it is none of these.

    Parameters
    ----------
    found, expected : ndarray of one shape
        Finite numbers that do not agree.
    tolerance : float
        How far apart numbers may be that are called the same.

    Returns
    -------
    str
        One sentence, or "".
    """

    def same(one: FloatArray, other: FloatArray) -> bool:
        return one.shape == other.shape and bool(np.all(np.abs(one - other) <= tolerance))

    tolerance = min(tolerance, 1e-3 * float(np.abs(expected).max(initial=0)))
    if not found.any():
        return "Your values are all 0."
    for factor, said in FACTORS.items():
        if same(found, factor * expected):
            return said
    if found.size > 1:
        return _of_many(found, expected, same)
    return ""


def _of_many(found: FloatArray, expected: FloatArray, same: Same) -> str:
    """Return the hint on many values, which can be confused in more ways than one can."""
    if same(found, expected**2):
        return "Your values are the squares of the right ones: take the root."
    if same(found**2, np.abs(expected)):
        return "Your values are the roots of the right ones."
    if same(found, np.abs(expected)):
        return "Your values have lost their sign."
    factor = float((found * expected).sum() / max((expected**2).sum(), 1e-300))
    if same(found, factor * expected) and factor:
        return f"Your values are {factor:.4g} times the right ones."
    if same(found - found.mean(), expected - expected.mean()):
        return f"Your values are all off by the same {np.mean(found - expected):.4g}."
    for axis in range(found.ndim):
        for step in (1, -1):
            if found.shape[axis] > 3 and same(
                *(_without_ends(a, axis) for a in (np.roll(found, step, axis), expected))
            ):
                return "Your values are right, but stand one node further: an index is off by one."
        if same(np.flip(found, axis), expected):
            return "Your values are right, but in the reverse order."
    if found.ndim == 2 and same(found.T, expected):
        return "Your values are right, but the two axes are exchanged."
    if min(found.shape) > 4 and same(_core(found), _core(expected)):
        return "Only the values at the ends are wrong: look at what you do there."
    return ""


def _without_ends(values: FloatArray, axis: int) -> FloatArray:
    return np.take(values, np.arange(1, values.shape[axis] - 1), axis)


def _core(values: FloatArray) -> FloatArray:
    for axis in range(values.ndim):
        values = np.take(values, np.arange(2, values.shape[axis] - 2), axis)
    return values


__all__ = ["diagnosis"]
