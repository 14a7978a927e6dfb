"""The one idea of the library, as a type: a field takes points and returns one value a point."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Field = Callable[[FloatArray], FloatArray]

__all__ = ["ArrayLike", "Field", "FloatArray", "IntArray"]
