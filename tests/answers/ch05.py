"""Answers to the exercises on reinitialization."""

import numpy as np

import distmesh_edu as de
from tests.answers import Answers

ANSWERS = Answers()

ANSWERS.right("corner", steps=129)
ANSWERS.right("corner", steps=np.ceil((np.sqrt(2) - 0.5) / (0.5 / np.sqrt(2) * 0.02)))
ANSWERS.wrong("corner", "a normal may be diagonal", steps=92)
ANSWERS.wrong("corner", "or at its rim", steps=200)
ANSWERS.wrong("corner", "the middle of a side", steps=71)
ANSWERS.wrong("corner", "These are cells, not steps", steps=46)
ANSWERS.wrong("corner", "Ten steps go three cells and a half", steps=10)


@ANSWERS.right("tug-of-war")
def zero_at_rest(x0, s, h):
    mean = (-s * x0 + s * (h - x0)) / 2
    left = mean - h / 2
    return -left


@ANSWERS.wrong("tug-of-war", "There it was at first")
def zero_at_rest(x0, s, h):
    return x0


@ANSWERS.wrong("tug-of-war", "if the mean of the two values were 0")
def zero_at_rest(x0, s, h):
    return h / 2


@ANSWERS.wrong("tug-of-war", "The slope at the end is 1, not s")
def zero_at_rest(x0, s, h):
    return h / 2 + (x0 - h / 2) / s


@ANSWERS.wrong("tug-of-war", "which sign has the mean")
def zero_at_rest(x0, s, h):
    return h / 2 - s * (x0 - h / 2)


@ANSWERS.wrong("tug-of-war", "It has moved less")
def zero_at_rest(x0, s, h):
    return x0 + s * (x0 - h / 2)


@ANSWERS.right("four-cases")
def godunov(minus, plus, a):
    slope = []
    for left, right, speed in zip(minus, plus, a, strict=True):
        if speed * left <= 0 <= speed * right:
            slope.append(0)
        elif left * right > 0:
            slope.append(left if speed * left > 0 else right)
        else:
            slope.append(max(left, right, key=abs))
    return slope


@ANSWERS.wrong("four-cases", "It is as before")
def godunov(minus, plus, a):
    slope = np.where(np.abs(minus) >= np.abs(plus), minus, plus)
    slope = np.where((a * plus <= 0) & (a * minus >= 0), 0, slope)
    slope = np.where((a * plus > 0) & (a * minus > 0), minus, slope)
    return np.where((a * plus < 0) & (a * minus < 0), plus, slope)


@ANSWERS.wrong("four-cases", "It is right for a > 0. For a < 0, what")
def godunov(minus, plus, a):
    return np.maximum(np.maximum(minus, -plus), 0)


@ANSWERS.wrong("four-cases", "It looks downwind")
def godunov(minus, plus, a):
    return np.maximum(np.maximum(np.sign(a) * plus, -np.sign(a) * minus), 0)


@ANSWERS.wrong("four-cases", "Nothing arrives at a valley")
def godunov(minus, plus, a):
    steeper = np.where(np.abs(minus) >= np.abs(plus), minus, plus)
    one_sign = np.where(a * minus > 0, minus, plus)
    return np.where(minus * plus > 0, one_sign, steeper)


@ANSWERS.wrong("four-cases", "so the slope is not 0")
def godunov(minus, plus, a):
    one_sign = np.where(a * minus > 0, minus, plus)
    return np.where(minus * plus > 0, one_sign, 0)


@ANSWERS.wrong("four-cases", "Of two fronts that meet at a ridge")
def godunov(minus, plus, a):
    flatter = np.where(np.abs(minus) < np.abs(plus), minus, plus)
    slope = np.where(a * minus > 0, minus, plus)
    slope = np.where((a * minus > 0) & (a * plus < 0), flatter, slope)
    return np.where((a * minus <= 0) & (a * plus >= 0), 0, slope)


@ANSWERS.wrong("four-cases", "the side depends on the sign of a")
def godunov(minus, plus, a):
    steeper = np.where(np.abs(minus) >= np.abs(plus), minus, plus)
    slope = np.where((a * minus <= 0) & (a * plus >= 0), 0, steeper)
    slope = np.where((minus > 0) & (plus > 0), minus, slope)
    return np.where((minus < 0) & (plus < 0), plus, slope)


@ANSWERS.right("any-dimension")
def normal_step(phi, a, dx, dt):
    new = np.empty(phi.shape)
    for node in np.ndindex(*phi.shape):
        squares = 0.0
        for axis in range(phi.ndim):
            around = []
            for way in (-1, 1):
                there = list(node)
                there[axis] = min(max(node[axis] + way, 0), phi.shape[axis] - 1)
                around.append(phi[tuple(there)])
            # Towards larger phi the front comes from the smallest value, else from the largest.
            best = min(*around) if a > 0 else max(*around)
            rise = (phi[node] - best) * (1 if a > 0 else -1)
            squares += (max(rise, 0) / dx[axis]) ** 2
        new[node] = phi[node] - dt * a * squares**0.5
    return new


@ANSWERS.right("any-dimension")
def normal_step(phi, a, dx, dt):
    norm = 0
    for axis, h in enumerate(dx):
        lines = np.moveaxis(phi, axis, 0)
        wide = np.concatenate([lines[:1], lines, lines[-1:]])
        slope = (wide[1:] - wide[:-1]) / h
        minus, plus = slope[:-1], slope[1:]
        if a > 0:
            part = np.maximum(np.maximum(minus, 0) ** 2, np.minimum(plus, 0) ** 2)
        else:
            part = np.maximum(np.minimum(minus, 0) ** 2, np.maximum(plus, 0) ** 2)
        norm = norm + np.moveaxis(part, 0, axis)
    return phi - dt * a * norm**0.5


@ANSWERS.wrong("any-dimension", "The third axis is missing")
def normal_step(phi, a, dx, dt):
    squares = np.zeros(phi.shape)
    for axis in range(min(phi.ndim, 2)):
        minus, plus = de.upwind(phi, dx[axis], axis, boundary=de.neumann)
        squares += np.maximum(np.maximum(np.sign(a) * minus, -np.sign(a) * plus), 0) ** 2
    return phi - dt * a * np.sqrt(squares)


@ANSWERS.wrong("any-dimension", "You add the slopes")
def normal_step(phi, a, dx, dt):
    total = np.zeros(phi.shape)
    for axis, h in enumerate(dx):
        minus, plus = de.upwind(phi, h, axis, boundary=de.neumann)
        total += np.maximum(np.maximum(np.sign(a) * minus, -np.sign(a) * plus), 0)
    return phi - dt * a * total


@ANSWERS.wrong("any-dimension", "The root of the sum of squares is missing")
def normal_step(phi, a, dx, dt):
    squares = np.zeros(phi.shape)
    for axis, h in enumerate(dx):
        minus, plus = de.upwind(phi, h, axis, boundary=de.neumann)
        squares += np.maximum(np.maximum(np.sign(a) * minus, -np.sign(a) * plus), 0) ** 2
    return phi - dt * a * squares


@ANSWERS.wrong("any-dimension", "Your ghosts go on in a straight line")
def normal_step(phi, a, dx, dt):
    squares, sign = np.zeros(phi.shape), np.sign(a)
    for axis in range(phi.ndim):
        minus, plus = de.upwind(phi, dx[axis], axis, boundary=de.extrapolated)
        squares += np.maximum(np.maximum(sign * minus, -sign * plus), 0) ** 2
    return phi - dt * a * np.sqrt(squares)


@ANSWERS.wrong("any-dimension", "Your ghosts are from the other end")
def normal_step(phi, a, dx, dt):
    squares, sign = np.zeros(phi.shape), np.sign(a)
    for axis, h in enumerate(dx):
        minus = (phi - np.roll(phi, 1, axis)) / h
        plus = (np.roll(phi, -1, axis) - phi) / h
        squares += np.maximum(np.maximum(sign * minus, -sign * plus), 0) ** 2
    return phi - dt * a * np.sqrt(squares)


@ANSWERS.wrong("any-dimension", "For a < 0, sides change")
def normal_step(phi, a, dx, dt):
    squares, sign = np.zeros(phi.shape), 1
    for axis in range(phi.ndim):
        minus, plus = de.upwind(phi, dx[axis], axis, boundary=de.neumann)
        squares += np.maximum(np.maximum(sign * minus, -sign * plus), 0) ** 2
    return phi - dt * a * np.sqrt(squares)


@ANSWERS.wrong("any-dimension", "Each axis has its own spacing")
def normal_step(phi, a, dx, dt):
    squares, sign = np.zeros(phi.shape), np.sign(a)
    for axis in range(phi.ndim):
        minus, plus = de.upwind(phi, dx[0], axis, boundary=de.neumann)
        squares += np.maximum(np.maximum(sign * minus, -sign * plus), 0) ** 2
    return phi - dt * a * np.sqrt(squares)


@ANSWERS.wrong("any-dimension", "It looks downwind")
def normal_step(phi, a, dx, dt):
    squares, sign = np.zeros(phi.shape), -np.sign(a)
    for axis in range(phi.ndim):
        minus, plus = de.upwind(phi, dx[axis], axis, boundary=de.neumann)
        squares += np.maximum(np.maximum(sign * minus, -sign * plus), 0) ** 2
    return phi - dt * a * np.sqrt(squares)


@ANSWERS.wrong("any-dimension", "Not yet: phi of shape (9,)")
def normal_step(phi, a, dx, dt):
    slopes = np.gradient(phi, *dx)
    if phi.ndim == 1:
        slopes = [slopes]
    return phi - dt * a * np.sqrt(sum(slope**2 for slope in slopes))


@ANSWERS.wrong("any-dimension", "changes the caller's array")
def normal_step(phi, a, dx, dt):
    squares, sign = np.zeros(phi.shape), np.sign(a)
    for axis, h in enumerate(dx):
        minus, plus = de.upwind(phi, h, axis, boundary=de.neumann)
        squares += np.maximum(np.maximum(sign * minus, -sign * plus), 0) ** 2
    phi -= dt * a * np.sqrt(squares)
    return phi


@ANSWERS.wrong("any-dimension", "it is done by the library")
def normal_step(phi, a, dx, dt):
    norm = de.godunov_norm(phi, a, dx, differences=de.upwind, boundary=de.neumann)
    return phi - dt * a * norm


@ANSWERS.right("steep")
def mended(phi, dx, steps):
    """Make a length of phi first; then the sign is right as it was."""
    phi = de.subcell_distance(phi, dx)
    sign = phi / np.sqrt(phi**2 + dx**2)
    for _ in range(steps):
        norm = de.godunov_norm(phi, sign, dx, differences=de.upwind, boundary=de.neumann)
        phi = phi + 0.5 * dx / np.sqrt(2) * sign * (1 - norm)
    return phi


@ANSWERS.right("steep")
def mended(phi, dx, steps):
    """Hold the nodes next to the interface."""
    near = de.reinitialization.next_to_interface(phi)
    sign = np.where(near, 0, np.sign(phi))
    phi = np.where(near, de.subcell_distance(phi, dx), phi)
    for _ in range(steps):
        norm = de.godunov_norm(phi, sign, dx, differences=de.upwind, boundary=de.neumann)
        phi = phi + 0.5 * dx / np.sqrt(2) * sign * (1 - norm)
    return phi


@ANSWERS.wrong("steep", "It is as before")
def mended(phi, dx, steps):
    sign = phi / np.sqrt(phi**2 + dx**2)
    dt = 0.5 * dx / np.sqrt(2)
    for _ in range(steps):
        norm = de.godunov_norm(phi, sign, dx, differences=de.upwind, boundary=de.neumann)
        phi = phi + dt * sign * (1 - norm)
    return phi


@ANSWERS.wrong("steep", "Next to the interface |S| should stay")
def mended(phi, dx, steps):
    sign = np.sign(phi)
    for _ in range(steps):
        norm = de.godunov_norm(phi, sign, dx, differences=de.upwind, boundary=de.neumann)
        phi = phi + 0.5 * dx / np.sqrt(2) * sign * (1 - norm)
    return phi


@ANSWERS.wrong("steep", "however steep phi is")
def mended(phi, dx, steps):
    sign = de.smeared_sign(phi, dx)
    for _ in range(steps):
        norm = de.godunov_norm(phi, sign, dx, differences=de.upwind, boundary=de.neumann)
        phi = phi + 0.5 * dx / np.sqrt(2) * sign * (1 - norm)
    return phi


@ANSWERS.wrong("steep", "with disc(1, 0). Hint: Three cells from the interface")
def mended(phi, dx, steps):
    slope = np.hypot(*np.gradient(phi, dx))
    sign = phi / np.sqrt(phi**2 + slope**2)
    for _ in range(steps):
        norm = de.godunov_norm(phi, sign, dx, differences=de.upwind, boundary=de.neumann)
        phi = phi + 0.5 * dx / np.sqrt(2) * sign * (1 - norm)
    return phi


@ANSWERS.wrong("steep", "with disc(20, 1). Hint: Three cells from the interface")
def mended(phi, dx, steps):
    phi = phi / np.abs(phi).max()
    sign = phi / np.sqrt(phi**2 + dx**2)
    for _ in range(steps):
        norm = de.godunov_norm(phi, sign, dx, differences=de.upwind, boundary=de.neumann)
        phi = phi + 0.5 * dx / np.sqrt(2) * sign * (1 - norm)
    return phi


@ANSWERS.wrong("steep", "it is solved by the library")
def mended(phi, dx, steps):
    return de.redistance(phi, dx)


@ANSWERS.right("at-rest")
def at_rest(a, b, h):
    values = []
    for one, other in zip(np.ravel(a), np.ravel(b), strict=True):
        low, high = sorted((one, other))
        d = low + h
        if d > high:
            d = (low + high + (2 * h * h - (high - low) ** 2) ** 0.5) / 2
        values.append(d)
    return np.reshape(values, np.shape(a))


@ANSWERS.right("at-rest")
def at_rest(a, b, h):
    d = np.minimum(a, b) + h
    for _ in range(60):
        x, y = np.maximum(d - a, 0), np.maximum(d - b, 0)
        d = d - (x**2 + y**2 - h**2) / (2 * (x + y))
    return d


@ANSWERS.wrong("at-rest", "Only the smaller neighbour is asked")
def at_rest(a, b, h):
    return np.minimum(a, b) + h


@ANSWERS.wrong("at-rest", "d - a or d - b is below 0")
def at_rest(a, b, h):
    root = np.sqrt(np.maximum(2 * h**2 - (a - b) ** 2, 0))
    return np.where(np.isfinite(a + b), (a + b + root) / 2, np.minimum(a, b) + h)


@ANSWERS.wrong("at-rest", "d - a or d - b is below 0")
def at_rest(a, b, h):
    disc = 2 * h**2 - (a - b) ** 2
    both = (a + b + np.sqrt(np.maximum(disc, 0))) / 2
    return np.where(disc >= 0, both, np.minimum(a, b) + h)


@ANSWERS.wrong("at-rest", "take the one above both neighbours")
def at_rest(a, b, h):
    root = np.sqrt(np.maximum(2 * h**2 - (a - b) ** 2, 0))
    return np.where(np.abs(a - b) < h, (a + b - root) / 2, np.minimum(a, b) + h)


@ANSWERS.wrong("at-rest", "its news comes first")
def at_rest(a, b, h):
    root = np.sqrt(np.maximum(2 * h**2 - (a - b) ** 2, 0))
    return np.where(np.abs(a - b) < h, (a + b + root) / 2, np.maximum(a, b) + h)


@ANSWERS.wrong("at-rest", "with an unknown neighbour, should be finite")
def at_rest(a, b, h):
    apart = np.minimum(np.abs(a - b), h)
    with np.errstate(invalid="ignore"):
        return (a + b + np.sqrt(2 * h**2 - apart**2)) / 2 - (np.abs(a - b) - apart) / 2


ANSWERS.right(
    "identical-interface",
    change={
        "smeared": (-0.1348, -1.8385),
        "held": [-0.01067, 2.0409],
        "closest": (-0.00004, -0.0015),
    },
    verdict=" B",
)
ANSWERS.wrong(
    "identical-interface",
    "Give it in per cent",
    change={"smeared": (-0.001348, -0.018385), "held": (0, 0), "closest": (0, 0)},
    verdict="b",
)
ANSWERS.wrong(
    "identical-interface",
    "each call begins with what the last one made",
    change={"smeared": (-0.1348, -0.1348), "held": (0, 0), "closest": (0, 0)},
    verdict="a",
)
ANSWERS.wrong(
    "identical-interface",
    "(c) is not the one",
    change={
        "smeared": (-0.1348, -1.8385),
        "held": (-0.01067, 2.0409),
        "closest": (-0.00004, -0.0015),
    },
    verdict="c",
)


@ANSWERS.right("redistancing")
def redistanced(phi, dx):
    """Straight pieces of the interface in two triangles to a cell, and the closest one."""
    nodes = np.moveaxis(np.indices(phi.shape), 0, -1) * dx
    nx, ny = phi.shape
    pieces, points = [], [nodes[phi == 0]]
    for corners in (((0, 0), (1, 0), (1, 1)), ((0, 0), (0, 1), (1, 1))):
        at = [np.s_[i : nx - 1 + i, j : ny - 1 + j] for i, j in corners]
        zeros, crossed = [], []
        for k in range(3):
            f, g = phi[at[k]], phi[at[k - 1]]
            crossed.append((f < 0) != (g < 0))
            share = f / np.where(crossed[k], f - g, 1)
            zeros.append(nodes[at[k]] + share[..., None] * (nodes[at[k - 1]] - nodes[at[k]]))
        for k in range(3):
            both = crossed[k] & crossed[k - 1]
            pieces.append(np.stack((zeros[k][both], zeros[k - 1][both]), axis=1))
    a, b = np.moveaxis(np.concatenate(pieces), 1, 0)
    away, along = nodes[:, :, None] - a, b - a
    square = np.maximum((along**2).sum(axis=-1), 1e-300)
    foot = np.clip((away * along).sum(axis=-1) / square, 0, 1)
    distance = np.linalg.norm(away - foot[..., None] * along, axis=-1).min(axis=-1)
    distance = np.maximum(distance, 1e-9 * dx)  # a node on a piece keeps its sign
    for point in np.concatenate(points):
        distance = np.minimum(distance, np.linalg.norm(nodes - point, axis=-1))
    return np.sign(phi) * distance


@ANSWERS.right("redistancing")
def redistanced(phi, dx):
    """Run the equation with the nodes next to the interface held; first order."""
    changes = np.zeros(phi.shape, dtype=bool)
    for axis in (0, 1):
        side, held = np.moveaxis(np.sign(phi), axis, 0), np.moveaxis(changes, axis, 0)
        turns = side[1:] * side[:-1] < 0
        held[1:] |= turns
        held[:-1] |= turns
    sign = np.where(changes, 0, np.sign(phi))
    start = de.subcell_distance(phi, dx)
    d = np.where(changes, start, np.clip(phi, -dx, dx))
    for _ in range(int(4 * sum(phi.shape))):
        norm = de.godunov_norm(d, sign, dx, differences=de.upwind, boundary=de.neumann)
        d = d + 0.5 * dx / np.sqrt(2) * sign * (1 - norm)
    return d


@ANSWERS.wrong("redistancing", "this is the library's answer")
def redistanced(phi, dx):
    return de.redistance(phi, dx)


@ANSWERS.wrong("redistancing", "Inside, distances are negative")
def redistanced(phi, dx):
    nodes = np.moveaxis(np.indices(phi.shape), 0, -1) * dx
    near = nodes[de.reinitialization.next_to_interface(phi)]
    return np.linalg.norm(nodes[:, :, None] - near, axis=-1).min(axis=-1) + dx / 2


@ANSWERS.wrong("redistancing", "tell where between their nodes it is")
def redistanced(phi, dx):
    nodes = np.moveaxis(np.indices(phi.shape), 0, -1) * dx
    inside, outside = nodes[phi < 0], nodes[phi >= 0]
    to_inside = np.linalg.norm(nodes[:, :, None] - inside, axis=-1).min(axis=-1)
    to_outside = np.linalg.norm(nodes[:, :, None] - outside, axis=-1).min(axis=-1)
    return np.where(phi < 0, dx / 2 - to_outside, to_inside - dx / 2)


@ANSWERS.wrong("redistancing", "where do the nodes behind those get")
def redistanced(phi, dx):
    return de.subcell_distance(phi, dx)


@ANSWERS.wrong("redistancing", "has the news come to the corners")
def redistanced(phi, dx):
    near = de.reinitialization.next_to_interface(phi)
    sign = np.where(near, 0, np.sign(phi))
    d = np.where(near, de.subcell_distance(phi, dx), np.clip(phi, -9 * dx, 9 * dx))
    for _ in range(40):
        norm = de.godunov_norm(d, sign, dx, differences=de.upwind, boundary=de.neumann)
        d = d + 0.5 * dx / np.sqrt(2) * sign * (1 - norm)
    return d


@ANSWERS.wrong("redistancing", "the sign of the result")
def redistanced(phi, dx):
    sign = phi / np.sqrt(phi**2 + dx**2)
    for _ in range(200):
        norm = de.godunov_norm(phi, sign, dx, differences=de.upwind, boundary=de.neumann)
        phi = phi + 0.5 * dx / np.sqrt(2) * sign * (1 - norm)
    return phi
