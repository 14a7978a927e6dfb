"""Answers to the exercises on implicit functions."""

import math

import numpy as np

import distmesh_edu as de
from tests.answers import Answers

ANSWERS = Answers()

ANSWERS.right("no-slope", point=[-1, 1.0], before=0.707, behind=1.0)
ANSWERS.wrong("no-slope", "the closest point is not unique", point=(0, 0), before=1, behind=1)
ANSWERS.wrong("no-slope", "the closest point is not unique", point=(0.5, -0.5), before=1, behind=1)
ANSWERS.wrong("no-slope", "the gradient (0.707, 0.707)", point=(2, 2), before=1, behind=1)
ANSWERS.wrong("no-slope", "the gradient (1, 0)", point=(1, 0.3), before=1, behind=1)
ANSWERS.wrong("no-slope", "two numbers, (x, y)", point=1, before=1, behind=1)
ANSWERS.wrong("no-slope", "from the nearest side", point=(1, 1), before=1, behind=1)
ANSWERS.wrong("no-slope", "how long is the way", point=(1, -1), before=1.4142, behind=1)
ANSWERS.wrong("no-slope", "How far is (2, 2)", point=(1, 1), before=0.7071, behind=0.7071)


@ANSWERS.right("vase")
def mean_curvature(R, R1, R2):
    square = 1 + R1**2
    return (square - R * R2) / (2 * R * square**1.5)


@ANSWERS.wrong("vase", "That is the sum, div N")
def mean_curvature(R, R1, R2):
    square = 1 + R1**2
    return (square - R * R2) / (R * square**1.5)


@ANSWERS.wrong("vase", "1/R is the bend of the level circle")
def mean_curvature(R, R1, R2):
    return (1 / R - R2 / (1 + R1**2) ** 1.5) / 2


@ANSWERS.wrong("vase", "which sign must R'' have")
def mean_curvature(R, R1, R2):
    return (1 / (R * math.sqrt(1 + R1**2)) + R2 / (1 + R1**2) ** 1.5) / 2


@ANSWERS.wrong("vase", "So it is where R' = 0")
def mean_curvature(R, R1, R2):
    return (1 / R - R2) / 2


@ANSWERS.wrong("vase", "There is a bend around the axis as well")
def mean_curvature(R, R1, R2):
    return -R2 / (1 + R1**2) ** 1.5 / 2


@ANSWERS.wrong("vase", "the wrong sign")
def mean_curvature(R, R1, R2):
    square = 1 + R1**2
    return (R * R2 - square) / (2 * R * square**1.5)


@ANSWERS.right("grid-nodes")
def grid_nodes(bbox, counts):
    low, high = bbox
    nodes = np.empty((*counts, len(counts)))
    for place in np.ndindex(*counts):
        for k, i in enumerate(place):
            nodes[(*place, k)] = low[k] + i * (high[k] - low[k]) / (counts[k] - 1)
    return nodes


@ANSWERS.right("grid-nodes")
def grid_nodes(bbox, counts):
    low, high = np.array(bbox, dtype=float)
    n = np.array(counts)
    return low + np.moveaxis(np.indices(counts), 0, -1) * ((high - low) / (n - 1))


@ANSWERS.wrong("grid-nodes", "along z, which way do the nodes go")
def grid_nodes(bbox, counts):
    (a, c, e), (b, d, f) = bbox
    m, n, k = counts
    x = a + np.arange(m) * (b - a) / (m - 1)
    y = c + np.arange(n) * (d - c) / (n - 1)
    z = e + np.arange(k) * (e - f) / (k - 1)
    return np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1)


@ANSWERS.wrong("grid-nodes", "How many cells do six nodes make")
def grid_nodes(bbox, counts):
    axes = [a + np.arange(n) * (b - a) / n for a, b, n in zip(*bbox, counts, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


@ANSWERS.wrong("grid-nodes", "Look up `indexing` of `np.meshgrid`")
def grid_nodes(bbox, counts):
    axes = [np.linspace(*ends) for ends in zip(*bbox, counts, strict=True)]
    return np.stack(np.meshgrid(*axes), axis=-1)


@ANSWERS.wrong("grid-nodes", "along which axis do you stack")
def grid_nodes(bbox, counts):
    axes = [np.linspace(*ends) for ends in zip(*bbox, counts, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"))


@ANSWERS.wrong("grid-nodes", "an array of shape (4, 3, 6, 3)")
def grid_nodes(bbox, counts):
    axes = [np.arange(a, b, (b - a) / (n - 1)) for a, b, n in zip(*bbox, counts, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)[:-1]


@ANSWERS.wrong("grid-nodes", "middles of cells")
def grid_nodes(bbox, counts):
    axes = [a + (np.arange(n) + 0.5) * (b - a) / n for a, b, n in zip(*bbox, counts, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


@ANSWERS.wrong("grid-nodes", "not enough values to unpack")
def grid_nodes(bbox, counts):
    (a, c, e), (b, d, f) = bbox
    m, n, k = counts
    axes = np.linspace(a, b, m), np.linspace(c, d, n), np.linspace(e, f, k)
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


@ANSWERS.right("capsule")
def rod(p, a, b, radius):
    flat = np.reshape(p, (-1, len(a)))
    values = []
    for q in flat:
        length = math.dist(a, b)
        if length == 0:
            values.append(math.dist(q, a) - radius)
            continue
        axis = (b - a) / length
        ahead = min(max(float((q - a) @ axis), 0.0), length)
        values.append(math.dist(q, a + ahead * axis) - radius)
    return np.reshape(values, np.shape(p)[:-1])


@ANSWERS.wrong("capsule", "a line that never ends")
def rod(p, a, b, radius):
    t = (p - a) @ (b - a) / ((b - a) @ (b - a))
    return np.linalg.norm(p - a - t[..., None] * (b - a), axis=-1) - radius


@ANSWERS.wrong("capsule", "the rod ends at both")
def rod(p, a, b, radius):
    t = np.minimum((p - a) @ (b - a) / ((b - a) @ (b - a)), 1)
    return np.linalg.norm(p - a - t[..., None] * (b - a), axis=-1) - radius


@ANSWERS.wrong("capsule", "distances to the two ends only")
def rod(p, a, b, radius):
    ends = np.linalg.norm(p - a, axis=-1), np.linalg.norm(p - b, axis=-1)
    return np.minimum(*ends) - radius


@ANSWERS.wrong("capsule", "The rod has a radius")
def rod(p, a, b, radius):
    t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    return np.linalg.norm(p - a - t[..., None] * (b - a), axis=-1)


@ANSWERS.wrong("capsule", "differences of squares")
def rod(p, a, b, radius):
    t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    return ((p - a - t[..., None] * (b - a)) ** 2).sum(axis=-1) - radius**2


@ANSWERS.wrong("capsule", "finite")
def rod(p, a, b, radius):
    with np.errstate(invalid="ignore", divide="ignore"):
        t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    return np.linalg.norm(p - a - t[..., None] * (b - a), axis=-1) - radius


@ANSWERS.wrong("capsule", "a single point should be one number")
def rod(p, a, b, radius):
    t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a) or 1), 0, 1)
    return np.linalg.norm(p - a - np.outer(t, b - a), axis=-1) - radius


@ANSWERS.right("as-sharp-as-a-needle")
def divergence_of_normal(g, H):
    total, square = 0.0, (g**2).sum(axis=-1)
    for i, j in ((0, 1), (0, 2), (1, 2)):
        total = total + g[..., i] ** 2 * H[..., j, j] + g[..., j] ** 2 * H[..., i, i]
        total = total - 2 * g[..., i] * g[..., j] * H[..., i, j]
    return total / square**1.5


@ANSWERS.right("as-sharp-as-a-needle")
def divergence_of_normal(g, H):
    """Return the trace of (I - N N^T) H / |g|."""
    size = np.linalg.norm(g, axis=-1)[..., None, None]
    n = g[..., None] / size
    along = np.eye(3) - n * np.swapaxes(n, -1, -2)
    return np.trace(along @ H / size, axis1=-2, axis2=-1)


@ANSWERS.wrong("as-sharp-as-a-needle", "It is as before")
def divergence_of_normal(g, H):
    total, under = 0.0, (g[..., 0] ** 2 + g[..., 1] ** 2) ** 1.5
    for i, j in ((0, 1), (0, 2), (1, 2)):
        total = total + g[..., i] ** 2 * H[..., j, j] + g[..., j] ** 2 * H[..., i, i]
        total = total - 2 * g[..., i] * g[..., j] * H[..., i, j]
    return total / under


@ANSWERS.wrong("as-sharp-as-a-needle", "The length of the gradient has three")
def divergence_of_normal(g, H):
    total = 0.0
    for i, j in ((0, 1), (0, 2), (1, 2)):
        top = g[..., i] ** 2 * H[..., j, j] + g[..., j] ** 2 * H[..., i, i]
        top = top - 2 * g[..., i] * g[..., j] * H[..., i, j]
        total = total + top / (g[..., i] ** 2 + g[..., j] ** 2) ** 1.5
    return total


@ANSWERS.wrong("as-sharp-as-a-needle", "the curvature of a distance only")
def divergence_of_normal(g, H):
    return np.trace(H, axis1=-2, axis2=-1)


@ANSWERS.wrong("as-sharp-as-a-needle", "changes from place to place, too")
def divergence_of_normal(g, H):
    return np.trace(H, axis1=-2, axis2=-1) / np.linalg.norm(g, axis=-1)


@ANSWERS.wrong("as-sharp-as-a-needle", "with which power of |grad phi|")
def divergence_of_normal(g, H):
    square = (g**2).sum(axis=-1)
    bent = np.einsum("...i,...ij,...j", g, H, g)
    return np.trace(H, axis1=-2, axis2=-1) - bent / square


@ANSWERS.wrong("as-sharp-as-a-needle", "That is the mean of the two curvatures")
def divergence_of_normal(g, H):
    square = (g**2).sum(axis=-1)
    bent = np.einsum("...i,...ij,...j", g, H, g)
    return (square * np.trace(H, axis1=-2, axis2=-1) - bent) / square**1.5 / 2


@ANSWERS.wrong("as-sharp-as-a-needle", "turned in space")
def divergence_of_normal(g, H):
    g, pairs = np.reshape(g, (-1, 3)), ((0, 1), (0, 2), (1, 2))
    H, total, square = np.reshape(H, (-1, 3, 3)), 0.0, (g**2).sum(axis=1)
    for i, j in pairs:
        total = total + g[:, i] ** 2 * H[:, j, j] + g[:, j] ** 2 * H[:, i, i]
        total = total - 2 * g[:, i] * g[:, j] * H[:, i, j]
    return total / square**1.5


@ANSWERS.right("back-to-the-boundary")
def steps_to_zero(phi, gradient, p, steps):
    if steps == 0:
        return p
    moved = []
    for place, value, slope in zip(p, phi(p), gradient(p), strict=True):
        size = math.hypot(*slope)
        moved.append(place - value / size * (slope / size) if size else place)
    return steps_to_zero(phi, gradient, np.array(moved), steps - 1)


@ANSWERS.wrong("back-to-the-boundary", "a hundred times as long")
def steps_to_zero(phi, gradient, p, steps):
    for _ in range(steps):
        p = p - phi(p)[:, None] * gradient(p)
    return p


@ANSWERS.wrong("back-to-the-boundary", "That is x - phi N")
def steps_to_zero(phi, gradient, p, steps):
    for _ in range(steps):
        g = gradient(p)
        p = p - phi(p)[:, None] * g / np.linalg.norm(g, axis=1, keepdims=True)
    return p


@ANSWERS.wrong("back-to-the-boundary", "over which axis do you sum")
def steps_to_zero(phi, gradient, p, steps):
    for _ in range(steps):
        g = gradient(p)
        p = p - phi(p)[:, None] * g / np.sum(g**2)
    return p


@ANSWERS.wrong("back-to-the-boundary", "Each coordinate alone")
def steps_to_zero(phi, gradient, p, steps):
    for _ in range(steps):
        p = p - phi(p)[:, None] / gradient(p)
    return p


@ANSWERS.wrong("back-to-the-boundary", "which way does phi grow")
def steps_to_zero(phi, gradient, p, steps):
    for _ in range(steps):
        g = gradient(p)
        p = p + phi(p)[:, None] * g / np.sum(g**2, axis=1, keepdims=True)
    return p


@ANSWERS.wrong("back-to-the-boundary", "does your loop go round")
def steps_to_zero(phi, gradient, p, steps):
    g = gradient(p)
    return p - phi(p)[:, None] * g / np.sum(g**2, axis=1, keepdims=True)


@ANSWERS.wrong("back-to-the-boundary", "at the new place")
def steps_to_zero(phi, gradient, p, steps):
    g = gradient(p)
    for _ in range(steps):
        p = p - phi(p)[:, None] * g / np.sum(g**2, axis=1, keepdims=True)
    return p


@ANSWERS.wrong("back-to-the-boundary", "finite")
def steps_to_zero(phi, gradient, p, steps):
    with np.errstate(invalid="ignore", divide="ignore"):
        for _ in range(steps):
            g = gradient(p)
            p = p - phi(p)[:, None] * g / np.sum(g**2, axis=1, keepdims=True)
    return p


@ANSWERS.wrong("back-to-the-boundary", "changes the caller's array")
def steps_to_zero(phi, gradient, p, steps):
    for _ in range(steps):
        g = gradient(p)
        square = np.sum(g**2, axis=1, keepdims=True)
        p -= phi(p)[:, None] * g / np.where(square == 0, 1, square)
    return p


RATIOS = {3: 0.5, 4: 0.7071, 6: 0.8660, 12: 0.9659}
CLOSE = {3: 0.501, 4: 0.708, 6: 0.8665, 12: 0.9662}
POLYGON = "corners-of-a-polygon"
ANSWERS.right(POLYGON, worst=RATIOS, claim="b", power=2)
ANSWERS.right(POLYGON, worst=CLOSE, claim="B", power=1.98)
ONE = dict.fromkeys(RATIOS, 1.0)
ANSWERS.wrong(POLYGON, "straight beyond a corner", worst=ONE, claim="a", power=2)
ZERO = dict.fromkeys(RATIOS, 0)
ANSWERS.wrong(POLYGON, "Leave out the points inside", worst=ZERO, claim="a", power=2)
UPSIDE = {3: 2.0, 4: 1.414, 6: 1.155, 12: 1.035}
ANSWERS.wrong(POLYGON, "not the other way round", worst=UPSIDE, claim="b", power=2)
ANSWERS.wrong(POLYGON, "What is the ratio at points inside", worst=RATIOS, claim="d", power=2)
ANSWERS.wrong(POLYGON, "becomes a quarter, not a half", worst=RATIOS, claim="b", power=1)
ANSWERS.wrong(POLYGON, "the factor from n = 6", worst=RATIOS, claim="b", power=4)


@ANSWERS.right("shape")
def shape(p):
    """Return a pair of spectacles; how thick the rings are makes its area."""
    x, y = abs(p[..., 0]), p[..., 1]
    ring = abs(np.hypot(x - 1, y) - 0.7) - 0.1658
    bar = de.box(((-0.4, -0.15), (0.4, 0.15)))(np.stack((x, y), axis=-1))
    return np.minimum(ring, bar)


@ANSWERS.right("shape")
def shape(p):
    """Return a button, its area measured and then scaled."""
    plate = de.rectangle(((-1, -0.7), (1, 0.7)))
    button = de.difference(plate, de.circle((-0.5, 0), 0.3), de.circle((0.5, 0), 0.3))
    grid = de.Grid(((-1.2, -1.2), (1.2, 1.2)), 0.02)
    area = de.volume(button(grid.points), grid.dx)
    return de.scaling(button, math.sqrt(3 / area))(p)


@ANSWERS.wrong("shape", "no distance, such as x**2 + y**2 - 1")
def shape(p):
    x, y = p[..., 0], p[..., 1]
    holes = [(x - c) ** 2 + y**2 - 0.09 for c in (-0.5, 0.5)]
    return np.maximum(x**2 + y**2 - 1.14, -np.minimum(*holes))


@ANSWERS.wrong("shape", "stretched without its values")
def shape(p):
    return np.maximum(np.hypot(*p.T).T - 1, 0.25 - np.hypot(abs(p[..., 0]) - 0.4, p[..., 1])) / 2


@ANSWERS.wrong("shape", "the number of holes should be 2, but is 0")
def shape(p):
    return np.linalg.norm(p, axis=-1) - np.sqrt(3 / np.pi)


@ANSWERS.wrong("shape", "the number of holes should be 2, but is 1")
def shape(p):
    return de.difference(de.circle(), de.circle((-0.2, 0), 0.25), de.circle((0.2, 0), 0.25))(p)


@ANSWERS.wrong("shape", "the number of pieces should be 1, but is 2")
def shape(p):
    return abs(np.hypot(abs(p[..., 0]) - 1, p[..., 1]) - 0.6) - 0.2


@ANSWERS.wrong("shape", "Left and right differ")
def shape(p):
    return de.difference(de.circle(), de.circle((-0.4, 0), 0.2), de.circle((0.4, 0), 0.25))(p)


@ANSWERS.wrong("shape", "By which factor do areas grow")
def shape(p):
    return de.difference(de.circle(), de.circle((-0.4, 0), 0.25), de.circle((0.4, 0), 0.25))(p)


@ANSWERS.wrong("shape", "up to 0.1 or more")
def shape(p):
    return de.difference(de.circle(), de.circle((-0.4, 0), 0.05), de.circle((0.4, 0), 0.05))(p)


@ANSWERS.wrong("shape", "so nowhere")
def shape(p):
    return np.ones(p.shape[:-1])


@ANSWERS.wrong("shape", "is it negative inside")
def shape(p):
    return 1 - np.linalg.norm(p, axis=-1)


@ANSWERS.wrong("shape", "fit into the box")
def shape(p):
    return np.linalg.norm(p, axis=-1) - 2.1


@ANSWERS.wrong("shape", "with any axes before them")
def shape(p):
    return np.hypot(p[:, 0], p[:, 1]) - 1
