"""Level sets with a known distance, which the tests of chapter 5 share."""

import numpy as np
import pytest

DIMS = pytest.mark.parametrize("dim", [1, 2, 3])
BOTH = pytest.mark.parametrize("subcell", [True, False], ids=["fix", "smeared"])
SIZE = {1: 41, 2: 41, 3: 21}
OFFSET = np.array((0.013, 0.007, -0.011))
EDGES = (0.10, 0.14, 0.08)


def ball(dim, n, part=0.0):
    """Return the distance to a unit sphere on a grid of n nodes an axis, and the spacing.

    The spacings differ, and the middle lies on no node; it moves by a part of a cell if asked.
    """
    dx = tuple(4 / (n - 1) * np.array((1.0, 1.1, 0.95)[:dim]))
    axes = [h * (np.arange(n) - (n - 1) / 2 - part) - c for h, c in zip(dx, OFFSET, strict=False)]
    return np.linalg.norm(np.meshgrid(*axes, indexing="ij"), axis=0) - 1, dx


def level_set(d):
    """Return another function with the same zeros and signs, whose slope is 2 at the front."""
    return d * (d + 2)


def in_band(d, dx, cells=3):
    return np.abs(d) <= cells * max(dx)


def displacement(phi, d):
    """Return how far from the true interface the zeros of phi between two nodes lie, at most."""
    worst = 0.0
    for axis in range(phi.ndim):
        a, b = (np.moveaxis(phi, axis, 0)[part] for part in (slice(-1), slice(1, None)))
        da, db = (np.moveaxis(d, axis, 0)[part] for part in (slice(-1), slice(1, None)))
        crossed = (a < 0) != (b < 0)
        share = (a / np.where(crossed, a - b, 1))[crossed]
        worst = max(worst, np.abs(da[crossed] * (1 - share) + db[crossed] * share).max())
    return worst


def plane(dim, rng, aspect=2.0):
    """Return the distance to a random plane, the spacing, and where the foot is in the box."""
    shape = rng.integers(5, (40, 16, 9)[dim - 1], dim)
    dx = rng.uniform(1, aspect, dim)
    normal = rng.standard_normal(dim)
    normal /= np.linalg.norm(normal)
    places = np.moveaxis(np.indices(shape), 0, -1) * dx
    through = dx * ((np.array(shape) - 1) / 2 + rng.uniform(-1, 1, dim))
    d = ((places - through) * normal).sum(axis=-1)
    foot = places - d[..., None] * normal
    inside = ((foot >= 0) & (foot <= dx * (np.array(shape) - 1))).all(axis=-1)
    return d, dx, inside
