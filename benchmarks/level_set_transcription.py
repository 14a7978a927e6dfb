"""Level sets written plainly: what the library is measured against. Not for use.

`eno2_norm` and `reinitialize` are the library's formulas on whole arrays, as one would write them
first. `evolve_normal_eno2` has the arrangement of the listings of sections 4.4 and 4.8 of the
thesis "Mesh generation with a signed distance function", one row and one node after the other,
rewritten from its mathematics. `fused_step` is what a compiler makes of the same formulas.
"""

import numpy as np

from .measuring import peer


def pad(phi, axis, ghosts):
    """Return phi with two ghost values at both ends of an axis: on a straight line, or equal."""
    widths = [(2, 2) if k == axis else (0, 0) for k in range(phi.ndim)]
    if ghosts == "line":
        return np.pad(phi, widths, mode="reflect", reflect_type="odd")
    return np.pad(phi, widths, mode="edge")


def eno2_slopes(phi, dx, axis, ghosts):
    """Return the one-sided derivatives along an axis, from the left and from the right."""
    padded = np.moveaxis(pad(phi, axis, ghosts), axis, 0)
    D1 = (padded[1:] - padded[:-1]) / dx
    D2 = (D1[1:] - D1[:-1]) / dx
    c = np.where(np.abs(D2[:-1]) <= np.abs(D2[1:]), D2[:-1], D2[1:]) / 2
    minus = D1[1:-2] + c[:-1] * dx
    plus = D1[2:-1] - c[1:] * dx
    return np.moveaxis(minus, 0, axis), np.moveaxis(plus, 0, axis)


def eno2_norm(phi, sign, dx, ghosts):
    """Return |grad phi| by ENO2 and Godunov's choice."""
    squares = 0
    for axis in range(phi.ndim):
        minus, plus = eno2_slopes(phi, dx, axis, ghosts)
        squares = squares + np.maximum(np.maximum(sign * minus, -sign * plus), 0) ** 2
    return np.sqrt(squares)


def step(phi, dx, dt):
    """Return phi after one forward Euler step of phi_t + |grad phi| = 0."""
    return phi - dt * eno2_norm(phi, 1.0, dx, "line")


def reinitialize(phi0, dx, band):
    """Return phi after the steps that `distmesh_edu.reinitialize` takes for a band."""
    sign = np.sign(phi0)
    near, squares = phi0 == 0, 0
    for axis in range(phi0.ndim):
        for side in (-1, 1):
            change = (np.roll(phi0, side, axis) < 0) != (phi0 < 0)
            np.moveaxis(change, axis, 0)[0 if side == 1 else -1] = False  # roll joins the ends
            near = near | change
        minus, plus = eno2_slopes(phi0, dx, axis, "line")
        squares = squares + np.maximum(np.abs(minus), np.abs(plus)) ** 2
    distance = np.clip(phi0 / np.sqrt(np.maximum(squares, 1e-300)), -dx, dx)
    phi = np.where(near, distance, phi0)
    speed = np.where(near, 0, sign)
    dt = 0.5 * dx / np.sqrt(phi.ndim)
    for _ in range(int(np.ceil((band + 5 * dx) / dt))):
        first = phi + dt * speed * (1 - eno2_norm(phi, sign, dx, "edge"))
        second = first + dt * speed * (1 - eno2_norm(first, sign, dx, "edge"))
        phi = (phi + second) / 2
    return phi


def der_eno2(data, dx, side):
    """Return the derivatives of a row from one side, node by node; two ghosts stand at each end."""
    data[1] = 2 * data[2] - data[3]
    data[0] = 2 * data[1] - data[2]
    data[-2] = 2 * data[-3] - data[-4]
    data[-1] = 2 * data[-2] - data[-3]
    D1 = (data[1:] - data[:-1]) / dx
    D2 = (D1[1:] - D1[:-1]) / dx
    absD2 = np.abs(D2)
    derivative = np.zeros(len(data))
    for i in range(len(data) - 4):
        k = i - 1 if side == "minus" else i
        c = D2[k + 1] / 2 if absD2[k + 1] <= absD2[k + 2] else D2[k + 2] / 2
        derivative[i + 2] = D1[k + 2] + c * (2 * (i - k) - 1) * dx
    return derivative


def select_der_normal(speed, minus, plus):
    """Return Godunov's choice of the two derivatives, node by node, by four branches."""
    chosen = np.zeros(len(minus))
    for i in range(len(minus)):
        left, right = speed[i] * minus[i], speed[i] * plus[i]
        if left <= 0 and right <= 0:
            chosen[i] = plus[i]
        elif left >= 0 and right >= 0:
            chosen[i] = minus[i]
        elif left >= 0 and right <= 0:
            chosen[i] = plus[i] if abs(right) >= abs(left) else minus[i]
    return chosen


def evolve_normal_eno2(phi, speed, dx):
    """Return speed * |grad phi| in the plane, first row by row and then column by column."""
    data, a = np.zeros(np.add(phi.shape, 4)), np.zeros(np.add(phi.shape, 4))
    data[2:-2, 2:-2], a[2:-2, 2:-2] = phi, speed
    squares = np.zeros_like(data)
    for lines, speeds, out in ((data, a, squares), (data.T, a.T, squares.T)):
        for i in range(2, len(lines) - 2):
            minus = der_eno2(lines[i].copy(), dx, "minus")
            plus = der_eno2(lines[i].copy(), dx, "plus")
            out[i] += select_der_normal(speeds[i], minus, plus) ** 2
    return (a * np.sqrt(squares))[2:-2, 2:-2]


def fused_step():
    """Return a step compiled by numba into one loop over the nodes, or None without numba.

    It is called as step(padded, out, dx, dt), where `padded` is phi with two ghosts at each end.
    """
    numba = peer("numba")
    if numba is None:
        return None

    @numba.njit
    def square(a, b, c, d, e):
        left, here, right = a - 2 * b + c, b - 2 * c + d, c - 2 * d + e
        minus = c - b + (left if abs(left) <= abs(here) else here) / 2
        plus = d - c - (here if abs(here) <= abs(right) else right) / 2
        slope = max(minus, -plus, 0.0)
        return slope * slope

    @numba.njit
    def in_the_plane(p, out, factor):
        for i in range(2, p.shape[0] - 2):
            for j in range(2, p.shape[1] - 2):
                c = p[i, j]
                s = square(p[i - 2, j], p[i - 1, j], c, p[i + 1, j], p[i + 2, j])
                s += square(p[i, j - 2], p[i, j - 1], c, p[i, j + 1], p[i, j + 2])
                out[i, j] = c - factor * np.sqrt(s)

    @numba.njit
    def in_space(p, out, factor):
        for i in range(2, p.shape[0] - 2):
            for j in range(2, p.shape[1] - 2):
                for k in range(2, p.shape[2] - 2):
                    c = p[i, j, k]
                    s = square(p[i - 2, j, k], p[i - 1, j, k], c, p[i + 1, j, k], p[i + 2, j, k])
                    s += square(p[i, j - 2, k], p[i, j - 1, k], c, p[i, j + 1, k], p[i, j + 2, k])
                    s += square(p[i, j, k - 2], p[i, j, k - 1], c, p[i, j, k + 1], p[i, j, k + 2])
                    out[i, j, k] = c - factor * np.sqrt(s)

    def step(padded, out, dx, dt):
        for axis in range(padded.ndim):
            p = np.moveaxis(padded, axis, 0)
            p[1], p[-2] = 2 * p[2] - p[3], 2 * p[-3] - p[-4]
            p[0], p[-1] = 2 * p[1] - p[2], 2 * p[-2] - p[-3]
        (in_the_plane if padded.ndim == 2 else in_space)(padded, out, dt / dx)
        return out

    return step
