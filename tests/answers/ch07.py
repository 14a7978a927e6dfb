"""Answers to the exercises on gradient limiting and size functions."""

import numpy as np

import distmesh_edu as de
from tests.answers import Answers

ANSWERS = Answers()

ANSWERS.right("behind-the-wall", witness=[0.61, 0.3], size=0.416)
ANSWERS.wrong("behind-the-wall", "in sight of (0.2, 0.2)", witness=(0.5, 0.1), size=0.3)
ANSWERS.wrong("behind-the-wall", "the crow's way short", witness=(1.0, 0.2), size=0.48)
ANSWERS.wrong("behind-the-wall", "through the wall", witness=(0.65, 0.2), size=0.185)
ANSWERS.wrong("behind-the-wall", "a size of its own", witness=(0.65, 0.2), size=0.397)
ANSWERS.wrong("behind-the-wall", "in the square", witness=(0.65, -0.2), size=0.5)
ANSWERS.wrong("behind-the-wall", "two straight pieces", witness=(0.65, 0.2), size=0.5)


@ANSWERS.right("price")
def triangles(length, width, smallest, g):
    upper = 1 / (smallest + g * width)
    return length * 4 / (3**0.5 * g) * (1 / smallest - upper)


@ANSWERS.wrong("price", "less than the square on its side")
def triangles(length, width, smallest, g):
    return length * width / (smallest * (smallest + g * width))


@ANSWERS.wrong("price", "do you count nodes")
def triangles(length, width, smallest, g):
    return 2 / np.sqrt(3) * length * width / (smallest * (smallest + g * width))


@ANSWERS.wrong("price", "The size in the middle does not stand for all")
def triangles(length, width, smallest, g):
    return 4 / np.sqrt(3) * length * width / (smallest + g * width / 2) ** 2


@ANSWERS.wrong("price", "goes with the square of h")
def triangles(length, width, smallest, g):
    return 4 / np.sqrt(3) * length / g * np.log(1 + g * width / smallest)


@ANSWERS.right("on-a-line")
def limited_on_a_line(x, h, g):
    return [min(h[j] + g * abs(x[i] - x[j]) for j in range(len(x))) for i in range(len(x))]


@ANSWERS.right("on-a-line")
def limited_on_a_line(x, h, g):
    tilted = np.minimum.accumulate(h - g * x) + g * x
    return np.minimum.accumulate((tilted + g * x)[::-1])[::-1] - g * x


@ANSWERS.wrong("on-a-line", "Small sizes on the right are not heard of")
def limited_on_a_line(x, h, g):
    h = h.copy()
    for i in range(1, len(h)):
        h[i] = min(h[i], h[i - 1] + g * (x[i] - x[i - 1]))
    return h


@ANSWERS.wrong("on-a-line", "it has to pass on what it has just been told")
def limited_on_a_line(x, h, g):
    new = h.copy()
    for i in range(len(h)):
        for j in (i - 1, i + 1):
            if 0 <= j < len(h):
                new[i] = min(new[i], h[j] + g * abs(x[i] - x[j]))
    return new


@ANSWERS.wrong("on-a-line", "You lift the small size")
def limited_on_a_line(x, h, g):
    h, rise = h.copy(), g * np.diff(x)
    for i in range(1, len(h)):
        h[i] = max(h[i], h[i - 1] - rise[i - 1])
    for i in range(len(h) - 2, -1, -1):
        h[i] = max(h[i], h[i + 1] - rise[i])
    return h


@ANSWERS.wrong("on-a-line", "use each gap as it is")
def limited_on_a_line(x, h, g):
    h, dx = h.copy(), x[1] - x[0]
    for i in range(1, len(h)):
        h[i] = min(h[i], h[i - 1] + g * dx)
    for i in range(len(h) - 2, -1, -1):
        h[i] = min(h[i], h[i + 1] + g * dx)
    return h


@ANSWERS.wrong("on-a-line", "How far is it from node to node")
def limited_on_a_line(x, h, g):
    i = np.arange(len(h))
    return (h[:, None] + g * np.abs(i[:, None] - i)).min(axis=0)


@ANSWERS.wrong("on-a-line", "changes the caller's array")
def limited_on_a_line(x, h, g):
    for i in range(1, len(h)):
        h[i] = min(h[i], h[i - 1] + g * (x[i] - x[i - 1]))
    for i in range(len(h) - 2, -1, -1):
        h[i] = min(h[i], h[i + 1] + g * (x[i + 1] - x[i]))
    return h


@ANSWERS.right("across")
def size_across(p, d, axis, across, smallest, largest):
    sizes = []
    for point, depth in zip(p, d, strict=True):
        to_axis = min(sum((point - other) ** 2) ** 0.5 for other in axis)
        sizes.append(max(smallest, min(largest, 2 * (abs(depth) + to_axis) / across)))
    return sizes


@ANSWERS.wrong("across", "half the width over")
def size_across(p, d, axis, across, smallest, largest):
    apart = np.linalg.norm(p[:, None] - axis, axis=-1)
    return np.clip((np.abs(d) + apart.min(axis=1)) / across, smallest, largest)


@ANSWERS.wrong("across", "the wall is |d| away")
def size_across(p, d, axis, across, smallest, largest):
    apart = np.linalg.norm(p[:, None] - axis, axis=-1)
    return np.clip(2 * (d + apart.min(axis=1)) / across, smallest, largest)


@ANSWERS.wrong("across", "What of the bounds")
def size_across(p, d, axis, across, smallest, largest):
    apart = np.linalg.norm(p[:, None] - axis, axis=-1)
    return 2 * (np.abs(d) + apart.min(axis=1)) / across


@ANSWERS.wrong("across", "may not be below `smallest` either")
def size_across(p, d, axis, across, smallest, largest):
    apart = np.linalg.norm(p[:, None] - axis, axis=-1)
    return np.minimum(2 * (np.abs(d) + apart.min(axis=1)) / across, largest)


@ANSWERS.wrong("across", "the distance to the axis, squared")
def size_across(p, d, axis, across, smallest, largest):
    apart = ((p[:, None] - axis) ** 2).sum(axis=-1)
    return np.clip(2 * (np.abs(d) + apart.min(axis=1)) / across, smallest, largest)


@ANSWERS.wrong("across", "should be an array of shape (40,)")
def size_across(p, d, axis, across, smallest, largest):
    apart = np.linalg.norm(p[:, None] - axis, axis=-1)
    return np.clip(2 * (np.abs(d)[:, None] + apart) / across, smallest, largest)


@ANSWERS.right("limiting-step")
def mended(h, g, dx, dt):
    nx, ny = h.shape
    new = np.empty_like(h)
    for i in range(nx):
        for j in range(ny):
            x = min(h[max(i - 1, 0), j], h[min(i + 1, nx - 1), j], h[i, j])
            y = min(h[i, max(j - 1, 0)], h[i, min(j + 1, ny - 1)], h[i, j])
            slope = ((h[i, j] - x) ** 2 + (h[i, j] - y) ** 2) ** 0.5 / dx
            new[i, j] = h[i, j] + dt * (min(slope, g) - slope)
    return new


@ANSWERS.right("limiting-step")
def mended(h, g, dx, dt):
    slope = de.godunov_norm(h, 1, dx, differences=de.upwind, boundary=de.neumann)
    return h - dt * np.maximum(slope - g, 0)


@ANSWERS.wrong("limiting-step", "It is as before")
def mended(h, g, dx, dt):
    wide = np.pad(h, 1, mode="edge")
    x = np.maximum(np.maximum(wide[:-2, 1:-1], wide[2:, 1:-1]) - h, 0) / dx
    y = np.maximum(np.maximum(wide[1:-1, :-2], wide[1:-1, 2:]) - h, 0) / dx
    return h - dt * np.maximum(np.hypot(x, y) - g, 0)


@ANSWERS.wrong("limiting-step", "Central differences look to both sides")
def mended(h, g, dx, dt):
    wide = np.pad(h, 1, mode="edge")
    x = (wide[2:, 1:-1] - wide[:-2, 1:-1]) / (2 * dx)
    y = (wide[1:-1, 2:] - wide[1:-1, :-2]) / (2 * dx)
    return h - dt * np.maximum(np.hypot(x, y) - g, 0)


@ANSWERS.wrong("limiting-step", "look at the signs")
def mended(h, g, dx, dt):
    wide = np.pad(h, 1, mode="edge")
    x = np.maximum(abs(wide[2:, 1:-1] - h), abs(h - wide[:-2, 1:-1])) / dx
    y = np.maximum(abs(wide[1:-1, 2:] - h), abs(h - wide[1:-1, :-2])) / dx
    return h - dt * np.maximum(np.hypot(x, y) - g, 0)


@ANSWERS.wrong("limiting-step", "should stay, not rise")
def mended(h, g, dx, dt):
    wide = np.pad(h, 1, mode="edge")
    x = np.maximum(h - np.minimum(wide[:-2, 1:-1], wide[2:, 1:-1]), 0) / dx
    y = np.maximum(h - np.minimum(wide[1:-1, :-2], wide[1:-1, 2:]), 0) / dx
    return h - dt * (np.hypot(x, y) - g)


@ANSWERS.wrong("limiting-step", "not on each axis")
def mended(h, g, dx, dt):
    wide = np.pad(h, 1, mode="edge")
    x = np.maximum(h - np.minimum(wide[:-2, 1:-1], wide[2:, 1:-1]), 0) / dx
    y = np.maximum(h - np.minimum(wide[1:-1, :-2], wide[1:-1, 2:]), 0) / dx
    return h - dt * (np.maximum(x - g, 0) + np.maximum(y - g, 0))


@ANSWERS.wrong("limiting-step", "on one side only")
def mended(h, g, dx, dt):
    wide = np.pad(h, 1, mode="edge")
    x = np.maximum(h - wide[:-2, 1:-1], 0) / dx
    y = np.maximum(h - wide[1:-1, :-2], 0) / dx
    return h - dt * np.maximum(np.hypot(x, y) - g, 0)


@ANSWERS.wrong("limiting-step", "changes the caller's array")
def mended(h, g, dx, dt):
    wide = np.pad(h, 1, mode="edge")
    x = np.maximum(h - np.minimum(wide[:-2, 1:-1], wide[2:, 1:-1]), 0) / dx
    y = np.maximum(h - np.minimum(wide[1:-1, :-2], wide[1:-1, 2:]), 0) / dx
    h -= dt * np.maximum(np.hypot(x, y) - g, 0)
    return h


def sizes_in_words(p, fine, coarse, ratio):
    r = np.sqrt(p[..., 0] ** 2 + p[..., 1] ** 2)
    low, high = min(fine, coarse), max(fine, coarse)
    r = np.minimum(np.maximum(r, low), high)
    return (abs(r - coarse) + ratio * abs(r - fine)) / (high - low)


def true_grading(fine, coarse, ratio, h0):
    return max((ratio * h0 - h0) / (fine - coarse), (ratio * h0 - h0) / (coarse - fine))


def endless(p, fine, coarse, ratio):
    r = np.linalg.norm(p, axis=-1)
    return 1 + (ratio - 1) * (r - fine) / (coarse - fine)


def never_below_one(p, fine, coarse, ratio):
    r = np.linalg.norm(p, axis=-1)
    return np.maximum(1 + (ratio - 1) * (r - fine) / (coarse - fine), 1)


def in_one_order(p, fine, coarse, ratio):
    low, high = min(fine, coarse), max(fine, coarse)
    r = np.clip(np.linalg.norm(p, axis=-1), low, high)
    return 1 + (ratio - 1) * (r - low) / (high - low)


def clipped_backwards(p, fine, coarse, ratio):
    r = np.clip(np.linalg.norm(p, axis=-1), fine, coarse)
    return 1 + (ratio - 1) * (r - fine) / (coarse - fine)


def interpolated(p, fine, coarse, ratio):
    return np.interp(np.linalg.norm(p, axis=-1), [fine, coarse], [1, ratio])


def relative_slope(fine, coarse, ratio, h0):
    return (ratio - 1) / abs(coarse - fine)


def signed_slope(fine, coarse, ratio, h0):
    return (ratio - 1) * h0 / (coarse - fine)


def slope_by_the_ratio(fine, coarse, ratio, h0):
    return ratio * h0 / abs(coarse - fine)


BY_HAND = (
    ("It goes on beyond the circles", endless, true_grading),
    ("beyond the other it goes on", never_below_one, true_grading),
    ("one order of them taken for granted", in_one_order, true_grading),
    ("It is `ratio` everywhere", clipped_backwards, true_grading),
    ("want the smaller radius first", interpolated, true_grading),
    ("the slope of the relative sizes", sizes_in_words, relative_slope),
    ("A slope limit is positive", sizes_in_words, signed_slope),
    ("not a rise by", sizes_in_words, slope_by_the_ratio),
)
ANSWERS.right("by-hand", sizes_by_hand=sizes_in_words, grading=true_grading)
for said, sizes, slope in BY_HAND:
    ANSWERS.wrong("by-hand", said, sizes_by_hand=sizes, grading=slope)

COUNTS = {0.4: 275, 0.2: 488, 0.1: 814, 0.05: 1262}
QUALITIES = {0.4: 0.93, 0.2: 0.96, 0.1: 0.975, 0.05: 0.98}
ANSWERS.right("halving-g", counts=COUNTS, qualities=QUALITIES, choice="C")
ANSWERS.wrong("halving-g", "(b) is not the one", counts=COUNTS, qualities=QUALITIES, choice="b")
ANSWERS.wrong(
    "halving-g",
    "a mesh unpacks as p, t",
    counts={0.4: 171, 0.2: 298, 0.1: 482, 0.05: 728},
    qualities=QUALITIES,
    choice="c",
)
ANSWERS.wrong(
    "halving-g",
    "the mean quality for g = 0.4",
    counts=COUNTS,
    qualities={0.4: 0.71, 0.2: 0.71, 0.1: 0.75, 0.05: 0.72},
    choice="c",
)


def with_cones(grid):
    """Cones about the hole and the place, each with a flat tip, and no limiting at all."""
    away = np.hypot(grid.points[..., 0] - 0.6, grid.points[..., 1] - 0.5) - 0.25
    corner = np.hypot(grid.points[..., 0] - 2, grid.points[..., 1] - 1)
    first = 0.03 + 0.2 * np.maximum(abs(away) - 0.02, 0)
    second = 0.02 + 0.3 * np.maximum(corner - 0.02, 0)
    return np.minimum(np.minimum(first, second), 0.2)


def with_curvature(grid):
    hole = de.circle((0.6, 0.5), 0.25)(grid.points)
    bend = de.size_from_curvature(hole, grid.dx, 0.01, 0.2, angle=0.1)
    near = np.linalg.norm(grid.points - np.array((2, 1)), axis=-1) < 0.025
    return de.limit_gradient(np.where(near, 0.02, bend), 0.3, grid.dx)


def a_cliff(grid):
    hole = de.circle((0.6, 0.5), 0.25)(grid.points)
    near = np.linalg.norm(grid.points - np.array((2, 1)), axis=-1) < 0.025
    return np.where(near, 0.02, np.where(abs(hole) < 0.025, 0.03, 0.2))


def all_small(grid):
    return np.full(grid.shape, 0.02)


def from_the_middle(grid):
    to_middle = np.linalg.norm(grid.points - np.array((0.6, 0.5)), axis=-1)
    to_corner = np.linalg.norm(grid.points - np.array((2, 1)), axis=-1)
    return np.minimum(np.minimum(0.03 + 0.3 * to_middle, 0.02 + 0.3 * to_corner), 0.2)


def by_the_equation(grid):
    hole = de.circle((0.6, 0.5), 0.25)(grid.points)
    near = np.linalg.norm(grid.points - np.array((2, 1)), axis=-1) < 0.025
    cliff = np.where(near, 0.02, np.where(abs(hole) < 0.025, 0.03, 0.2))
    return de.limit_gradient_pde(cliff, 0.3, grid.dx)


def sharp_tip(grid):
    to_rim = abs(de.circle((0.6, 0.5), 0.25)(grid.points))
    to_corner = np.linalg.norm(grid.points - np.array((1.985, 1)), axis=-1)
    return np.minimum(np.minimum(0.02 + 0.3 * to_rim, 0.02 + 0.3 * to_corner), 0.2)


def along_the_axes(grid):
    to_rim = abs(de.circle((0.6, 0.5), 0.25)(grid.points))
    to_corner = np.abs(grid.points - np.array((2, 1))).sum(axis=-1)
    first = 0.03 + 0.3 * np.maximum(to_rim - 0.02, 0)
    second = 0.02 + 0.3 * np.maximum(to_corner - 0.03, 0)
    return np.minimum(np.minimum(first, second), 0.2)


def unbounded(grid):
    to_rim = abs(de.circle((0.6, 0.5), 0.25)(grid.points))
    to_corner = np.linalg.norm(grid.points - np.array((2, 1)), axis=-1)
    return np.minimum(0.024 + 0.3 * to_rim, 0.014 + 0.3 * to_corner)


ANSWERS.right("plate", place=(2, 1), plate_sizes=with_cones)
ANSWERS.right("plate", place=(2.0, 1.0), plate_sizes=with_curvature)
ANSWERS.wrong("plate", "Limit the sizes", place=(2, 1), plate_sizes=a_cliff)
ANSWERS.wrong("plate", "smaller than they need be", place=(2, 1), plate_sizes=all_small)
ANSWERS.wrong("plate", "How far is it to its rim", place=(2, 1), plate_sizes=from_the_middle)
ANSWERS.wrong("plate", "has its size at its tip alone", place=(1.985, 1), plate_sizes=sharp_tip)
ANSWERS.wrong("plate", "not as long as both sides", place=(2, 1), plate_sizes=along_the_axes)
ANSWERS.wrong("plate", "Does it come from the equation", place=(2, 1), plate_sizes=by_the_equation)
ANSWERS.wrong("plate", "Bound your sizes from above", place=(2, 1), plate_sizes=unbounded)
ANSWERS.wrong("plate", "in the plate, 0.5 from the rim", place=(0.9, 0.9), plate_sizes=with_cones)
