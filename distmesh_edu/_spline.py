"""The cubic spline through values on a grid, with gradient and Hessian, at many places at once."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.linalg import solve_banded

Values = NDArray[np.float64]

_BLOCK = 4096  # places worked on at once: their 64 coefficients each stay in the cache


class CubicSpline:
    """A tensor product of cubic splines in one, two or three dimensions; distances in cells."""

    def __init__(self, values: Values) -> None:
        self.shape = values.shape
        for axis in range(values.ndim):
            values = _coefficients(values, axis)
        self._windows = sliding_window_view(values, (4,) * values.ndim)

    def __call__(self, x: Values, *, order: int) -> list[Values]:
        """Return the value (n), the gradient (dim, n), if order is 2 the Hessian (dim, dim, n).

        The places x, of shape (dim, n), are counted in cells from the first node.
        """
        blocks = np.array_split(x, x.shape[1] // _BLOCK + 1, axis=1)
        parts = [self._at(block, order) for block in blocks]
        return [np.concatenate(part, axis=-1) for part in zip(*parts, strict=True)]

    def _at(self, x: Values, order: int) -> list[Values]:
        dim = len(x)
        cell = [np.clip(a, 0, n - 2).astype(np.intp) for a, n in zip(x, self.shape, strict=True)]
        window = np.moveaxis(self._windows[tuple(cell)], 0, -1)
        # derivatives[k1, k2, ...] after all axes: k1 times along the first, k2 along the second
        derivatives: dict[tuple[int, ...], Any] = {(): window}
        for axis in reversed(range(dim)):
            weights = _weights(x[axis] - cell[axis])
            derivatives = {
                (k, *rest): sum(w * part[..., i, :] for i, w in enumerate(weights[k]))
                for rest, part in derivatives.items()
                for k in range(order + 1 - sum(rest))
            }
        unit = np.eye(dim, dtype=int)
        found = [derivatives[(0,) * dim], np.stack([derivatives[tuple(e)] for e in unit])]
        if order == 2:
            hessian = [[derivatives[tuple(e + f)] for f in unit] for e in unit]
            found.append(np.array(hessian))
        return found


def _coefficients(values: Values, axis: int) -> Values:
    """Return the coefficients of uniform B-splines, for one node more at either end."""
    rows = np.moveaxis(values, axis, -1)
    c = np.empty((*rows.shape[:-1], rows.shape[-1] + 2))
    phi, b = np.moveaxis(rows, -1, 0), np.moveaxis(c, -1, 0)
    # At node i, phi = (b_before + 4 b + b_after) / 6. Not-a-knot makes the fourth difference of b
    # zero about the second node, so that there phi and b have the same second difference.
    b[2] = phi[1] - (phi[0] - 2 * phi[1] + phi[2]) / 6
    b[-3] = phi[-2] - (phi[-3] - 2 * phi[-2] + phi[-1]) / 6
    if len(phi) > 4:
        inner = 6 * rows[..., 2:-2].reshape(-1, len(phi) - 4).T
        inner[0] -= b[2].ravel()
        inner[-1] -= b[-3].ravel()
        matrix = np.array([[1.0], [4.0], [1.0]]) * np.ones(len(inner))
        solved = solve_banded((1, 1), matrix, inner, overwrite_b=True, check_finite=False)
        c[..., 3:-3] = solved.T.reshape(c[..., 3:-3].shape)
    b[1] = 6 * phi[1] - 4 * b[2] - b[3]
    b[0] = 6 * phi[0] - 4 * b[1] - b[2]
    b[-2] = 6 * phi[-2] - 4 * b[-3] - b[-4]
    b[-1] = 6 * phi[-1] - 4 * b[-2] - b[-3]
    return np.moveaxis(c, -1, axis)


def _weights(u: Values) -> list[tuple[Values, ...]]:
    """Return the four B-splines about a cell at u in [0, 1], and their first two derivatives."""
    v = 1 - u
    return [
        (v**3 / 6, 2 / 3 - u * u * (1 - u / 2), 2 / 3 - v * v * (1 - v / 2), u**3 / 6),
        (-v * v / 2, u * (1.5 * u - 2), -v * (1.5 * v - 2), u * u / 2),
        (v, 3 * u - 2, 3 * v - 2, u),
    ]
