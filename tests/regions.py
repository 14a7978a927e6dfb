"""Regions on a line, in the plane and in space, for tests of mesh generators; and bad input."""

from itertools import product

import numpy as np
import pytest

import distmesh_edu as de


def ball(dim, center=0.0, radius=1.0):
    """Return the distance to an interval, a disc or a ball."""
    return lambda p: np.linalg.norm(p - center, axis=-1) - radius


def cube(dim, half=1.0):
    """Return the box of side 2 half about the origin."""
    return np.array([[-half] * dim, [half] * dim])


def euler_characteristic(inside):
    """Return that of the union of the closed pixels, or voxels, where a boolean array is true.

    Points - edges + squares - cubes: along each axis a cell of the union is either as long as a
    pixel, or the point between two pixels, and belongs to the union if one that touches it does.
    """
    total = 0
    for long in product((False, True), repeat=inside.ndim):
        cells = np.pad(inside, 1)
        for axis in (axis for axis, is_long in enumerate(long) if not is_long):
            n = cells.shape[axis]
            cells = cells.take(range(n - 1), axis) | cells.take(range(1, n), axis)
        total += (-1) ** sum(long) * int(cells.sum())
    return total


def topology(fd, bbox, h0, width):
    """Return the Euler characteristic if all parts, and all gaps, are at least `width` wide.

    Else None: then to grow or to shrink the region by half of that changes its topology.
    """
    margin = width + h0
    axes = [np.arange(a - margin, b + margin, h0 / 4) for a, b in np.transpose(bbox)]
    d = fd(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1))
    found = {euler_characteristic(d < depth) for depth in width / 2 * np.linspace(-1, 1, 7)}
    return found.pop() if len(found) == 1 else None


def _nan_at_right(p):
    return np.where(p[..., 0] > 0.5, np.nan, np.linalg.norm(p, axis=-1) - 1)


def bad_input(dim):
    """Return changes of good arguments for a ball of h0 0.3, and the errors that they cause."""
    good, zero = ball(dim), np.zeros(dim)
    step = np.eye(dim)[0]
    flat = cube(dim)[:, ::-1] if dim == 2 else cube(dim)
    cut = cube(dim) * 1.1
    cut[1, 0] = 0.5
    changes = [
        ({"fd": _nan_at_right}, ValueError, r"fd must be finite; it returned nan at"),
        ({"fd": lambda p: np.stack((p, p))}, ValueError, r"fd must return one value a point"),
        ({"fd": lambda p: 1.0}, ValueError, r"fd must return one value a point"),
        ({"fd": de.complement(good)}, ValueError, r"pass complement\(fd\)"),
        ({"fd": "circle"}, TypeError, "fd must be a field"),
        ({"fd": lambda p: 1 + 0 * p[..., 0]}, ValueError, "region is empty, thinner than h0"),
        ({"fd": ball(dim, 0.111, 0.01)}, ValueError, "region is empty, thinner than h0"),
        ({"fd": lambda p: 1e-3 * good(p)}, ValueError, "fd must be a distance.*0.001"),
        ({"fd": lambda p: 1e3 * good(p)}, ValueError, "fd must be a distance.*1e.03"),
        ({"fd": lambda p: np.sign(good(p))}, ValueError, "fd must be a distance"),
        ({"fd": lambda p: good(p) + 1j}, TypeError, "fd must return real numbers"),
        ({"h0": 0}, ValueError, "h0 must be one positive number; got 0"),
        ({"h0": -0.1}, ValueError, "h0 must be one positive number"),
        ({"h0": [0.1, 0.1]}, ValueError, "h0 must be one positive number"),
        ({"h0": np.nan}, ValueError, "h0 must be finite"),
        ({"h0": None}, TypeError, "h0 must hold real numbers; got None"),
        ({"h0": 3}, ValueError, "h0 must not be larger than the box; h0 = 3, .* measures 2"),
        ({"h0": 3e-8}, ValueError, "h0 = 3e-08 would fill the box with .* points"),
        ({"bbox": (-1, 1)}, ValueError, "bbox must be"),
        ({"bbox": cube(4)}, ValueError, "bbox must be"),
        ({"bbox": cube(dim)[::-1]}, ValueError, "bbox must hold the lower corner"),
        ({"bbox": flat * 0}, ValueError, "bbox must hold the lower corner"),
        ({"bbox": cut}, ValueError, r"bbox cuts the region: fd is -0.5 at \[0.5.*Widen"),
        ({"bbox": cube(dim) * np.nan}, ValueError, "bbox must be finite|bbox.* is nan"),
        ({"fh": lambda p: p[..., 0] + 0.5}, ValueError, "fh must be positive"),
        ({"fh": lambda p: 0 * p[..., 0]}, ValueError, "fh must be positive"),
        ({"fh": lambda p: np.sqrt(-1 + 0 * p[..., 0])}, ValueError, "fh must be finite"),
        ({"fh": lambda p: np.ones(3)}, ValueError, "fh must return one value a point"),
        ({"fh": 1.0}, TypeError, "fh must be a field"),
        ({"pfix": [1.5 * step]}, ValueError, r"pfix must lie in the region.*\[1.5.* is 0.5"),
        ({"pfix": [zero, step / 2, zero]}, ValueError, "pfix gives .* twice, in rows 0 and 2"),
        ({"pfix": [[0] * (dim + 1)]}, ValueError, rf"pfix must have the shape \(n, {dim}\)"),
        ({"pfix": [zero * np.nan]}, ValueError, "pfix must be finite"),
        ({"pfix": [["a"] * dim]}, TypeError, "pfix must hold real numbers"),
        ({"max_steps": 0}, ValueError, "max_steps must be 1"),
        ({"max_steps": 10.0}, TypeError, "max_steps must be a whole number; got 10.0"),
        ({"rng": -1}, ValueError, "rng must be a seed.*got -1"),
        ({"rng": "a"}, TypeError, "rng must be a seed.*got 'a'"),
    ]
    return [pytest.param(*change, id=f"{dim}d-{k}") for k, change in enumerate(changes)]


def good_input(dim):
    """Return arguments for a ball, to be changed for the worse."""
    return {"fd": ball(dim), "fh": None, "h0": 0.3, "bbox": cube(dim)}
