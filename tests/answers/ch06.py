"""Answers to the exercises on DistMesh."""

import numpy as np
from scipy.spatial import Delaunay

import distmesh_edu as de
from tests.answers import Answers

ANSWERS = Answers()

ANSWERS.right(
    "good-edges",
    corners=[(0.5, 0, 0.005), (-0.5, 0, 0.005), (0, 0.45, -0.002), (0, -0.55, 0)],
)
ANSWERS.wrong(
    "good-edges",
    "How far out of one plane",
    corners=[(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)],
)
ANSWERS.wrong(
    "good-edges",
    "its edges give it away",
    corners=[(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.3, 0.3, 0.01)],
)
ANSWERS.wrong(
    "good-edges",
    "All four lie in one plane",
    corners=[(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)],
)
ANSWERS.wrong("good-edges", "four points of three coordinates", corners=[(0, 0), (1, 0), (0, 1)])


@ANSWERS.right("quality-from-edges")
def quality(a, b, c):
    s = (a + b + c) / 2
    area = np.sqrt(s * (s - a) * (s - b) * (s - c))
    inside, around = area / s, a * b * c / (4 * area)
    return 2 * inside / around


@ANSWERS.wrong("quality-from-edges", "Half of it")
def quality(a, b, c):
    s = a + b + c
    area = np.sqrt(s * (s - 2 * a) * (s - 2 * b) * (s - 2 * c)) / 4
    return 8 * area**2 / (s * a * b * c)


@ANSWERS.wrong("quality-from-edges", "Twice too large")
def quality(a, b, c):
    return 2 * (b + c - a) * (c + a - b) * (a + b - c) / (a * b * c)


@ANSWERS.wrong("quality-from-edges", "ends with a root")
def quality(a, b, c):
    s = (a + b + c) / 2
    area = s * (s - a) * (s - b) * (s - c)
    return 8 * area**2 / (s * a * b * c)


@ANSWERS.wrong("quality-from-edges", "It has a unit: an area is missing")
def quality(a, b, c):
    s = (a + b + c) / 2
    return 8 * np.sqrt(s * (s - a) * (s - b) * (s - c)) / (s * a * b * c)


@ANSWERS.wrong("quality-from-edges", "stands on its head")
def quality(a, b, c):
    return a * b * c / ((b + c - a) * (c + a - b) * (a + b - c))


@ANSWERS.wrong("quality-from-edges", "That is the mean ratio")
def quality(a, b, c):
    s = (a + b + c) / 2
    area = np.sqrt(s * (s - a) * (s - b) * (s - c))
    return 4 * np.sqrt(3) * area / (a**2 + b**2 + c**2)


@ANSWERS.wrong("quality-from-edges", "That is the radius inside")
def quality(a, b, c):
    s = (a + b + c) / 2
    return np.sqrt((s - a) * (s - b) * (s - c) / s)


@ANSWERS.right("where-to-begin")
def start_nodes(points, h, pfix, rng):
    taken = {tuple(np.round(x, 8)) for x in pfix}
    least, nodes = min(h), list(pfix)
    for x, size, draw in zip(points, h, rng.random(len(points)), strict=True):
        if tuple(np.round(x, 8)) not in taken and draw * size ** len(x) < least ** len(x):
            nodes.append(x)
    return nodes


@ANSWERS.wrong("where-to-begin", "the probability to keep a point, not to drop it")
def start_nodes(points, h, pfix, rng):
    keep = rng.random(len(points)) > (h.min() / h) ** points.shape[1]
    for fixed in pfix:
        keep &= np.linalg.norm(points - fixed, axis=1) > 1e-9
    return np.concatenate([pfix, points[keep]])


@ANSWERS.wrong("where-to-begin", "Which power?")
def start_nodes(points, h, pfix, rng):
    keep = rng.random(len(points)) < (h.min() / h) ** 2
    for fixed in pfix:
        keep &= np.linalg.norm(points - fixed, axis=1) > 1e-9
    return np.concatenate([pfix, points[keep]])


@ANSWERS.wrong("where-to-begin", "who leaves?")
def start_nodes(points, h, pfix, rng):
    keep = rng.random(len(points)) < (h.min() / h) ** points.shape[1]
    return np.concatenate([pfix, points[keep]])


@ANSWERS.wrong("where-to-begin", "No draw decides on a fixed node")
def start_nodes(points, h, pfix, rng):
    keep = rng.random(len(points)) < (h.min() / h) ** points.shape[1]
    for fixed in pfix:
        keep &= np.linalg.norm(points - fixed, axis=1) > 1e-9
    return np.concatenate([points[keep], pfix])


@ANSWERS.wrong("where-to-begin", "Only the ratios of h count")
def start_nodes(points, h, pfix, rng):
    keep = rng.random(len(points)) < 1 / h ** points.shape[1]
    for fixed in pfix:
        keep &= np.linalg.norm(points - fixed, axis=1) > 1e-9
    return np.concatenate([pfix, points[keep]])


@ANSWERS.wrong("where-to-begin", "You keep where h is large")
def start_nodes(points, h, pfix, rng):
    keep = rng.random(len(points)) < (h / h.max()) ** points.shape[1]
    for fixed in pfix:
        keep &= np.linalg.norm(points - fixed, axis=1) > 1e-9
    return np.concatenate([pfix, points[keep]])


@ANSWERS.wrong("where-to-begin", "from `rng`, and from nowhere else")
def start_nodes(points, h, pfix, rng):
    keep = np.random.default_rng(0).random(len(points)) < (h.min() / h) ** points.shape[1]
    for fixed in pfix:
        keep &= np.linalg.norm(points - fixed, axis=1) > 1e-9
    return np.concatenate([pfix, points[keep]])


@ANSWERS.wrong("where-to-begin", "with three points on fixed ones")
def start_nodes(points, h, pfix, rng):
    keep = rng.random(len(points)) < (h.min() / h) ** points.shape[1]
    taken = {tuple(x) for x in pfix}
    keep &= [tuple(x) not in taken for x in points]
    return np.concatenate([pfix, points[keep]])


@ANSWERS.right("bar-forces")
def bar_forces(p, bars, L0):
    F = 0 * p
    for (i, j), wanted in zip(bars, L0, strict=True):
        bar = p[i] - p[j]
        length = np.sqrt(bar @ bar)
        if length < wanted:
            F[i] += (wanted / length - 1) * bar
            F[j] -= (wanted / length - 1) * bar
    return F


@ANSWERS.wrong("bar-forces", "adds only once")
def bar_forces(p, bars, L0):
    a, b = bars.T
    L = np.linalg.norm(p[a] - p[b], axis=1)
    push = (np.maximum(L0 - L, 0) / L)[:, None] * (p[a] - p[b])
    F = np.zeros_like(p)
    F[a] += push
    F[b] -= push
    return F


@ANSWERS.wrong("bar-forces", "too long pull with you")
def bar_forces(p, bars, L0):
    F = np.zeros_like(p)
    for (i, j), wanted in zip(bars, L0, strict=True):
        length = np.linalg.norm(p[i] - p[j])
        F[i] += (wanted - length) * (p[i] - p[j]) / length
        F[j] -= (wanted - length) * (p[i] - p[j]) / length
    return F


@ANSWERS.wrong("bar-forces", "pull together what they should push apart")
def bar_forces(p, bars, L0):
    F = np.zeros_like(p)
    for (i, j), wanted in zip(bars, L0, strict=True):
        length = np.linalg.norm(p[i] - p[j])
        F[i] += max(wanted - length, 0) * (p[j] - p[i]) / length
        F[j] -= max(wanted - length, 0) * (p[j] - p[i]) / length
    return F


@ANSWERS.wrong("bar-forces", "length of the vector that you multiply")
def bar_forces(p, bars, L0):
    F = np.zeros_like(p)
    for (i, j), wanted in zip(bars, L0, strict=True):
        bar = p[i] - p[j]
        F[i] += max(wanted - np.linalg.norm(bar), 0) * bar
        F[j] -= max(wanted - np.linalg.norm(bar), 0) * bar
    return F


@ANSWERS.wrong("bar-forces", "pushes at both its ends")
def bar_forces(p, bars, L0):
    F = np.zeros_like(p)
    for (i, j), wanted in zip(bars, L0, strict=True):
        length = np.linalg.norm(p[i] - p[j])
        F[i] += max(wanted - length, 0) * (p[i] - p[j]) / length
    return F


@ANSWERS.wrong("bar-forces", "in opposite directions")
def bar_forces(p, bars, L0):
    a, b = bars.T
    L = np.linalg.norm(p[a] - p[b], axis=1)
    push = (np.maximum(L0 - L, 0) / L)[:, None] * (p[a] - p[b])
    F = np.zeros_like(p)
    np.add.at(F, a, push)
    np.add.at(F, b, push)
    return F


@ANSWERS.right("three-faults")
def steps_7_and_8(p, F, fd, fixed, h0, deltat=0.2):
    """Node by node, with differences to both sides."""
    moved, longest = [], 0.0
    for i, (place, force) in enumerate(zip(p, F, strict=True)):
        if i < fixed:
            moved.append(place)
            continue
        x = place + deltat * force
        d = float(fd(x[None])[0])
        if d > 0:
            ends = x + 1e-6 * np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
            a, b, c, e = fd(ends)
            slope = np.array([a - c, b - e]) / 2e-6
            x = x - d * slope / (slope @ slope)
        elif d < -0.001 * h0:
            longest = max(longest, deltat * np.hypot(*force))
        moved.append(x)
    return np.array(moved), longest / h0


@ANSWERS.wrong("three-faults", "Step 7 has projected it")
def steps_7_and_8(p, F, fd, fixed, h0, deltat=0.2):
    F = F.copy()
    F[:fixed] = 0
    p = p + deltat * F
    d, deps = fd(p), 1.5e-8 * h0
    out = d > 0
    d_x = (fd(p[out] + [deps, 0]) - d[out]) / deps
    d_y = (fd(p[out] + [0, deps]) - d[out]) / deps
    share = d[out] / (d_x**2 + d_y**2)
    p[out] -= share[:, None] * np.stack([d_x, d_y], axis=1)
    inside = d < -0.001 * h0
    return p, deltat * np.hypot(*F[inside].T).max() / h0


@ANSWERS.wrong("three-faults", "Is d a distance?")
def steps_7_and_8(p, F, fd, fixed, h0, deltat=0.2):
    F = F.copy()
    F[:fixed] = 0
    p = p + deltat * F
    d, deps = fd(p), 1.5e-8 * h0
    out = (d > 0) & (np.arange(len(p)) >= fixed)
    d_x = (fd(p[out] + [deps, 0]) - d[out]) / deps
    d_y = (fd(p[out] + [0, deps]) - d[out]) / deps
    p[out] -= d[out, None] * np.stack([d_x, d_y], axis=1)
    inside = d < -0.001 * h0
    return p, deltat * np.hypot(*F[inside].T).max() / h0


@ANSWERS.wrong("three-faults", "along the unit gradient")
def steps_7_and_8(p, F, fd, fixed, h0, deltat=0.2):
    F = F.copy()
    F[:fixed] = 0
    p = p + deltat * F
    d, deps = fd(p), 1.5e-8 * h0
    out = (d > 0) & (np.arange(len(p)) >= fixed)
    d_x = (fd(p[out] + [deps, 0]) - d[out]) / deps
    d_y = (fd(p[out] + [0, deps]) - d[out]) / deps
    share = d[out] / np.hypot(d_x, d_y)
    p[out] -= share[:, None] * np.stack([d_x, d_y], axis=1)
    inside = d < -0.001 * h0
    return p, deltat * np.hypot(*F[inside].T).max() / h0


@ANSWERS.wrong("three-faults", "the power comes first")
def steps_7_and_8(p, F, fd, fixed, h0, deltat=0.2):
    F = F.copy()
    F[:fixed] = 0
    p = p + deltat * F
    d, deps = fd(p), 1.5e-8 * h0
    out = (d > 0) & (np.arange(len(p)) >= fixed)
    d_x = (fd(p[out] + [deps, 0]) - d[out]) / deps
    d_y = (fd(p[out] + [0, deps]) - d[out]) / deps
    share = d[out] / (d_x**2 + d_y**2)
    p[out] -= share[:, None] * np.stack([d_x, d_y], axis=1)
    inside = d < -0.001 * h0
    return p, np.sqrt(np.sum(deltat * F[inside] ** 2, axis=1)).max() / h0


@ANSWERS.wrong("three-faults", "Only interior nodes count")
def steps_7_and_8(p, F, fd, fixed, h0, deltat=0.2):
    F = F.copy()
    F[:fixed] = 0
    p = p + deltat * F
    d, deps = fd(p), 1.5e-8 * h0
    out = (d > 0) & (np.arange(len(p)) >= fixed)
    d_x = (fd(p[out] + [deps, 0]) - d[out]) / deps
    d_y = (fd(p[out] + [0, deps]) - d[out]) / deps
    share = d[out] / (d_x**2 + d_y**2)
    p[out] -= share[:, None] * np.stack([d_x, d_y], axis=1)
    return p, deltat * np.hypot(*F.T).max() / h0


@ANSWERS.wrong("three-faults", "Nodes outside have not come back")
def steps_7_and_8(p, F, fd, fixed, h0, deltat=0.2):
    F = F.copy()
    F[:fixed] = 0
    p = p + deltat * F
    inside = fd(p) < -0.001 * h0
    return p, deltat * np.hypot(*F[inside].T).max() / h0


@ANSWERS.right("last-triangles")
def last_mesh(p, fd, geps):
    """Simplex by simplex, with a dictionary of new numbers."""
    number, t = {}, []
    for corners in Delaunay(p).simplices.tolist():
        if fd(p[corners].mean(axis=0)) < -geps:
            first, *others = p[corners]
            if np.linalg.det(np.array(others) - first) < 0:
                corners = [*corners[:-2], corners[-1], corners[-2]]
            t.append([number.setdefault(i, len(number)) for i in corners])
    return p[list(number)], t


@ANSWERS.wrong("last-triangles", "Which sign has d outside?")
def last_mesh(p, fd, geps):
    t = Delaunay(p).simplices
    t = t[fd(p[t].mean(axis=1)) >= 0]
    mirrored = np.linalg.det(p[t[:, 1:]] - p[t[:, :1]]) < 0
    t[mirrored, :2] = t[mirrored, 1::-1]
    used, t = np.unique(t, return_inverse=True)
    return p[used], t.reshape(-1, p.shape[1] + 1)


@ANSWERS.wrong("last-triangles", "an orphan")
def last_mesh(p, fd, geps):
    t = Delaunay(p).simplices
    t = t[fd(p[t].mean(axis=1)) < -geps]
    mirrored = np.linalg.det(p[t[:, 1:]] - p[t[:, :1]]) < 0
    t[mirrored, :2] = t[mirrored, 1::-1]
    return p, t


@ANSWERS.wrong("last-triangles", "exchange two of them")
def last_mesh(p, fd, geps):
    t = Delaunay(p).simplices
    t = t[fd(p[t].mean(axis=1)) < -geps]
    used, t = np.unique(t, return_inverse=True)
    return p[used], t.reshape(-1, p.shape[1] + 1)


@ANSWERS.wrong("last-triangles", "Nodes are counted from 0")
def last_mesh(p, fd, geps):
    t = Delaunay(p).simplices
    t = t[fd(p[t].mean(axis=1)) < -geps]
    mirrored = np.linalg.det(p[t[:, 1:]] - p[t[:, :1]]) < 0
    t[mirrored, :2] = t[mirrored, 1::-1]
    return p[np.unique(t)], t


@ANSWERS.wrong("last-triangles", "Are all those kept whose centroid")
def last_mesh(p, fd, geps):
    t = Delaunay(p).simplices
    t = t[(fd(p[t]) < -geps).all(axis=1)]
    mirrored = np.linalg.det(p[t[:, 1:]] - p[t[:, :1]]) < 0
    t[mirrored, :2] = t[mirrored, 1::-1]
    t = t[fd(p[t].mean(axis=1)) < -geps]
    used, t = np.unique(t, return_inverse=True)
    return p[used], t.reshape(-1, p.shape[1] + 1)


ANSWERS.right("is-fscale-k", at_rim={(1, 1.2): 63, (0.5, 1.2): 63, (1, 1): 48}, verdict=" C")
ANSWERS.wrong(
    "is-fscale-k",
    "the number of boundary nodes for k = 1, Fscale = 1 should be",
    at_rim={(1, 1.2): 63, (0.5, 1.2): 63, (1, 1): 63},
    verdict="a",
)
ANSWERS.wrong(
    "is-fscale-k",
    "the number of all nodes",
    at_rim={(1, 1.2): 365, (0.5, 1.2): 365, (1, 1): 365},
    verdict="d",
)
ANSWERS.wrong(
    "is-fscale-k",
    "(b) is not the one",
    at_rim={(1, 1.2): 63, (0.5, 1.2): 63, (1, 1): 48},
    verdict="b",
)


@ANSWERS.right("your-region")
def my_mesh():
    """Mesh a washer with an eccentric hole, by the published loop."""
    hole = de.circle((0.3, 0), 0.35)
    fd = de.difference(de.circle(), hole)

    def fh(p):
        return 1 + 3 * np.abs(hole(p))

    bbox = ((-1.1, -1.1), (1.1, 1.1))
    mesh = de.distmesh2d(fd, fh, 0.06, bbox, rng=1)
    return fd, fh, bbox, mesh.p, mesh.t


@ANSWERS.right("your-region")
def my_mesh():
    """Mesh a nut: a hexagon with a round hole, finest at the six corners."""
    turn = np.pi / 3 * np.arange(6)
    six = 2 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    fd = de.difference(de.polygon(six), de.circle(radius=1))

    def fh(p):
        nearest = np.linalg.norm(p[..., None, :] - six, axis=-1).min(axis=-1)
        return 0.05 + 0.15 * nearest

    bbox = ((-2.2, -2.0), (2.2, 2.0))
    p, t = de.generate_mesh(fd, fh, 0.05, bbox, six)
    return fd, fh, bbox, p, t


@ANSWERS.wrong("your-region", "`de.difference` makes one")
def my_mesh():
    fd, bbox = de.circle(), ((-1.1, -1.1), (1.1, 1.1))

    def fh(p):
        return 0.05 + 0.2 * np.abs(fd(p))

    p, t = de.generate_mesh(fd, fh, 0.05, bbox)
    return fd, fh, bbox, p, t


@ANSWERS.wrong("your-region", "Where does your problem ask for small edges?")
def my_mesh():
    fd = de.difference(de.circle(), de.circle(radius=0.4))

    def fh(p):
        return np.full(p.shape[:-1], 0.1)

    bbox = ((-1.1, -1.1), (1.1, 1.1))
    p, t = de.generate_mesh(fd, fh, 0.1, bbox)
    return fd, fh, bbox, p, t


@ANSWERS.wrong("your-region", "Did the generator get this fh?")
def my_mesh():
    fd = de.difference(de.circle(), de.circle(radius=0.4))

    def fh(p):
        return np.hypot(*p.T) ** 2

    bbox = ((-1.1, -1.1), (1.1, 1.1))
    p, t = de.generate_mesh(fd, None, 0.1, bbox)
    return fd, fh, bbox, p, t


@ANSWERS.wrong("your-region", "the Euler characteristic")
def my_mesh():
    """Mesh the disc, and forget the hole."""
    hole = de.circle(radius=0.06)
    fd, bbox = de.difference(de.circle(), hole), ((-1.1, -1.1), (1.1, 1.1))

    def fh(p):
        return 0.1 + 0.2 * np.abs(hole(p))

    p, t = de.generate_mesh(de.circle(), fh, 0.1, bbox)
    return fd, fh, bbox, p, t


@ANSWERS.wrong("your-region", "is fd negative inside?")
def my_mesh():
    fd = de.difference(de.circle(), de.circle(radius=0.4))

    def fh(p):
        return 0.05 + 0.2 * np.abs(fd(p))

    bbox = ((-1.1, -1.1), (1.1, 1.1))
    p, t = de.generate_mesh(fd, fh, 0.05, bbox)
    return de.complement(fd), fh, bbox, p, t
