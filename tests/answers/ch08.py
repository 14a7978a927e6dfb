"""Answers to the exercises on results."""

import numpy as np
from scipy import ndimage

import distmesh_edu as de
from tests.answers import Answers

ANSWERS = Answers()

ANSWERS.right("two-units", factor=10**6, choice="C")
ANSWERS.wrong("two-units", "a quotient of different units does not", factor=1, choice="c")
ANSWERS.wrong("two-units", "Which of the two polynomials grows more", factor=1e-6, choice="c")
ANSWERS.wrong("two-units", "how many more", factor=1000, choice="c")
ANSWERS.wrong("two-units", "That is (6.2) alone", factor=1e24, choice="c")
ANSWERS.wrong("two-units", "how many below", factor=16, choice="c")
ANSWERS.wrong("two-units", "(b) is not the one", factor=1e6, choice="b")
ANSWERS.wrong("two-units", "what is left of the quotient at both", factor=1e6, choice="d")


@ANSWERS.right("coefficient-b")
def coefficient_b(d, k):
    m = k / (1 + k)
    return 3 * (1 - 3 * m + 2 * m**2) * d**4 / (16 * m**2)


@ANSWERS.wrong("coefficient-b", "the other half's 0.3")
def coefficient_b(d, k):
    m = k / (1 + k)
    return 3 * (1 - 3 * m + 2 * 0.3) * d**4 / (16 * m**2)


@ANSWERS.wrong("coefficient-b", "One of them has a minus")
def coefficient_b(d, k):
    m = k / (1 + k)
    return 3 * (1 - 3 * m + 2 * m) * d**4 / (16 * m**2)


@ANSWERS.wrong("coefficient-b", "Divide by the factor before q**4")
def coefficient_b(d, k):
    return 3 * k * (1 - k) * (d / 2) ** 4


@ANSWERS.wrong("coefficient-b", "look at the s in (s - 1)")
def coefficient_b(d, k):
    return -3 * d**4 / (16 * k)


@ANSWERS.wrong("coefficient-b", "which power of 4 is left")
def coefficient_b(d, k):
    return 3 * (1 - k) * d**4 / k**2


@ANSWERS.right("lake-and-islands")
def lake_and_islands(phi):
    """Flood from each node, water first and then land."""
    n, m = phi.shape

    def flood(mask, neighbours):
        left, pieces = {(i, j) for i in range(n) for j in range(m) if mask[i, j]}, []
        while left:
            front = [left.pop()]
            piece = set(front)
            while front:
                i, j = front.pop()
                near = {(i + a, j + b) for a, b in neighbours} & left
                left -= near
                piece |= near
                front += near
            pieces.append(piece)
        return pieces

    cross = [(0, 1), (0, -1), (1, 0), (-1, 0)]
    lake = np.zeros((n, m), dtype=bool)
    for i, j in max(flood(phi < 0, cross), key=len):
        lake[i, j] = True
    star = [(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1) if (a, b) != (0, 0)]
    lands = flood(~lake, star)
    return lake, sum(all(0 < i < n - 1 and 0 < j < m - 1 for i, j in piece) for piece in lands)


@ANSWERS.right("lake-and-islands")
def lake_and_islands(phi):
    """Count as Euler did: nodes, links and squares."""
    pieces, many = ndimage.label(phi < 0)
    sizes = ndimage.sum_labels(phi < 0, pieces, np.arange(1, many + 1))
    lake = pieces == 1 + np.argmax(sizes)
    links = (lake[1:] & lake[:-1]).sum() + (lake[:, 1:] & lake[:, :-1]).sum()
    squares = (lake[1:, 1:] & lake[1:, :-1] & lake[:-1, 1:] & lake[:-1, :-1]).sum()
    return lake, 1 - (lake.sum() - links + squares)


@ANSWERS.wrong("lake-and-islands", "The ponds are in it")
def lake_and_islands(phi):
    lake = phi < 0
    return lake, ndimage.label(~lake, np.ones((3, 3)))[1] - 2


@ANSWERS.wrong("lake-and-islands", "touches it at a corner only")
def lake_and_islands(phi):
    pieces, _ = ndimage.label(phi < 0, np.ones((3, 3)))
    lake = pieces == np.bincount(pieces[phi < 0]).argmax()
    return lake, ndimage.label(~lake, np.ones((3, 3)))[1] - 2


@ANSWERS.wrong("lake-and-islands", "Which number does `label` give")
def lake_and_islands(phi):
    pieces, _ = ndimage.label(phi < 0)
    lake = pieces == np.bincount(pieces.ravel()).argmax()
    return lake, ndimage.label(~lake, np.ones((3, 3)))[1] - 2


@ANSWERS.wrong("lake-and-islands", "Land that reaches the border of the picture")
def lake_and_islands(phi):
    pieces, _ = ndimage.label(phi < 0)
    lake = pieces == np.bincount(pieces[phi < 0]).argmax()
    return lake, ndimage.label(~lake, np.ones((3, 3)))[1]


@ANSWERS.wrong("lake-and-islands", "More than one piece of land")
def lake_and_islands(phi):
    pieces, _ = ndimage.label(phi < 0)
    lake = pieces == np.bincount(pieces[phi < 0]).argmax()
    return lake, ndimage.label(~lake, np.ones((3, 3)))[1] - 1


@ANSWERS.wrong("lake-and-islands", "are one island")
def lake_and_islands(phi):
    pieces, _ = ndimage.label(phi < 0)
    lake = pieces == np.bincount(pieces[phi < 0]).argmax()
    land, count = ndimage.label(~lake)
    border = np.concatenate([land[0], land[-1], land[:, 0], land[:, -1]])
    return lake, count - len(set(border) - {0})


@ANSWERS.wrong("lake-and-islands", "An islet in a pond is none")
def lake_and_islands(phi):
    pieces, _ = ndimage.label(phi < 0)
    lake = pieces == np.bincount(pieces[phi < 0]).argmax()
    land, count = ndimage.label(phi > 0, np.ones((3, 3)))
    border = np.concatenate([land[0], land[-1], land[:, 0], land[:, -1]])
    return lake, count - len(set(border) - {0})


# Without islands this one subtracts a piece of land that is not there.
@ANSWERS.wrong("lake-and-islands", "of a lake without any")
def lake_and_islands(phi):
    pieces, _ = ndimage.label(phi < 0)
    lake = pieces == np.bincount(pieces[phi < 0]).argmax()
    return lake, ndimage.label(~lake, np.ones((3, 3)))[1] - 2


@ANSWERS.right("skin-volume")
def skin_volume(p, facets):
    """Loop, with the origin in the first node, and a dictionary of edges."""
    runs = {}
    volume = 0.0
    for triangle in facets:
        for i in range(3):
            a, b = int(triangle[i]), int(triangle[i - 2])
            runs[a, b] = runs.get((a, b), 0) + 1
            runs[b, a] = runs.get((b, a), 0) - 1
        volume += np.linalg.det(p[triangle] - p[0])
    if any(runs.values()):
        raise ValueError("this skin has a hole, or a triangle is turned")
    return volume / 6


@ANSWERS.wrong("lake-and-islands", "which one is the lake")
def lake_and_islands(phi):
    return ndimage.label(phi < 0)


@ANSWERS.wrong("skin-volume", "Without signs nothing cancels")
def skin_volume(p, facets):
    return np.abs(np.linalg.det(p[facets])).sum() / 6


@ANSWERS.wrong("skin-volume", "boxes over three edges")
def skin_volume(p, facets):
    a, b, c = p[facets.T]
    return (a * np.cross(b, c)).sum()


@ANSWERS.wrong("skin-volume", "without one of its triangles should be refused")
def skin_volume(p, facets):
    a, b, c = p[facets.T]
    return (a * np.cross(b, c)).sum() / 6


@ANSWERS.wrong("skin-volume", "is each run both ways")
def skin_volume(p, facets):
    edges = np.sort(facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    if (np.unique(edges, axis=0, return_counts=True)[1] != 2).any():
        raise ValueError("the skin is not closed")
    return np.linalg.det(p[facets]).sum() / 6


@ANSWERS.wrong("skin-volume", "The areas of what is missing may cancel")
def skin_volume(p, facets):
    a, b, c = p[facets.T]
    if np.abs(np.cross(b - a, c - a).sum(axis=0)).max() > 1e-9:
        raise ValueError("the skin is not closed")
    return np.linalg.det(p[facets]).sum() / 6


@ANSWERS.wrong("skin-volume", "a skin that looks inwards")
def skin_volume(p, facets):
    ahead = facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    if {*map(tuple, ahead)} != {*map(tuple, ahead[:, ::-1])}:
        raise ValueError("the skin is not whole")
    return abs(np.linalg.det(p[facets]).sum()) / 6


@ANSWERS.wrong("skin-volume", "the volume around a hollow")
def skin_volume(p, facets):
    from scipy.spatial import ConvexHull

    return ConvexHull(p[facets].reshape(-1, 3)).volume


@ANSWERS.right("stiffness")
def stiffness(p, t):
    """By the angles: minus half the cotangent of the angle opposite an edge; sparse."""
    from scipy.sparse import coo_array

    rows, columns, entries = [], [], []
    for corners in t:
        for i in range(3):
            a, b, c = np.roll(corners, i)
            u, v = p[a] - p[c], p[b] - p[c]
            half = u @ v / abs(u[0] * v[1] - u[1] * v[0]) / 2
            rows += [a, b, a, b]
            columns += [b, a, a, b]
            entries += [-half, -half, half, half]
    return coo_array((entries, (rows, columns)), shape=(len(p), len(p)))


@ANSWERS.right("stiffness")
def stiffness(p, t):
    K = np.zeros((len(p), len(p)))
    for corners in t:
        x = np.column_stack((np.ones(3), p[corners]))
        slopes = np.linalg.inv(x)[1:]
        K[np.ix_(corners, corners)] += abs(np.linalg.det(x)) / 2 * slopes.T @ slopes
    return K


@ANSWERS.wrong("stiffness", "overwrite each other")
def stiffness(p, t):
    K = np.zeros((len(p), len(p)))
    for corners in t:
        x = np.column_stack((np.ones(3), p[corners]))
        slopes = np.linalg.inv(x)[1:]
        K[np.ix_(corners, corners)] = abs(np.linalg.det(x)) / 2 * slopes.T @ slopes
    return K


@ANSWERS.wrong("stiffness", "Triangles that share nodes")
def stiffness(p, t):
    a, b, c = p[t.T]
    edge = np.stack([c - b, a - c, b - a], axis=1)
    area = np.abs(np.linalg.det(edge[:, :2])) / 2
    K = np.zeros((len(p), len(p)))
    local = edge @ edge.transpose(0, 2, 1) / (4 * area)[:, None, None]
    K[t[:, :, None], t[:, None, :]] += local
    return K


@ANSWERS.wrong("stiffness", "Clockwise triangles are taken off")
def stiffness(p, t):
    K = np.zeros((len(p), len(p)))
    for corners in t:
        x = np.column_stack((np.ones(3), p[corners]))
        slopes = np.linalg.inv(x)[1:]
        K[np.ix_(corners, corners)] += np.linalg.det(x) / 2 * slopes.T @ slopes
    return K


@ANSWERS.wrong("stiffness", "Each triangle counts with its area")
def stiffness(p, t):
    K = np.zeros((len(p), len(p)))
    for corners in t:
        slopes = np.linalg.inv(np.column_stack((np.ones(3), p[corners])))[1:]
        K[np.ix_(corners, corners)] += slopes.T @ slopes
    return K


@ANSWERS.wrong("stiffness", "twice too large")
def stiffness(p, t):
    K = np.zeros((len(p), len(p)))
    for corners in t:
        x = np.column_stack((np.ones(3), p[corners]))
        slopes = np.linalg.inv(x)[1:]
        K[np.ix_(corners, corners)] += abs(np.linalg.det(x)) * slopes.T @ slopes
    return K


@ANSWERS.wrong("stiffness", "Corners i and j of one triangle")
def stiffness(p, t):
    K = np.zeros((len(p), len(p)))
    for corners in t:
        x = np.column_stack((np.ones(3), p[corners]))
        squares = (np.linalg.inv(x)[1:] ** 2).sum(axis=0)
        K[corners, corners] += abs(np.linalg.det(x)) / 2 * squares
    return K


@ANSWERS.right("read-off")
def read_off(p, t, values, points):
    """Loop over the points; shares are quotients of areas."""

    def area(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    found = []
    for q in points:
        value = values[np.hypot(*(p - q).T).argmin()]
        for i, j, k in t:
            whole = area(p[i], p[j], p[k])
            shares = area(q, p[j], p[k]), area(p[i], q, p[k]), area(p[i], p[j], q)
            if min(shares) >= -1e-9 * whole:
                value = np.dot(shares, values[[i, j, k]]) / whole
                break
        found.append(value)
    return found


@ANSWERS.wrong("read-off", "The nodes were triangulated anew")
def read_off(p, t, values, points):
    from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

    linear = LinearNDInterpolator(p, values)(points)
    nearest = NearestNDInterpolator(p, values)(points)
    return np.where(np.isnan(linear), nearest, linear)


@ANSWERS.wrong("read-off", "the nearest node's value everywhere")
def read_off(p, t, values, points):
    gap = np.linalg.norm(points[:, None] - p, axis=-1)
    return values[gap.argmin(axis=1)]


@ANSWERS.wrong("read-off", "the mean of three corners")
def read_off(p, t, values, points):
    found = []
    for q in points:
        x = np.concatenate([np.ones((len(t), 1, 3)), p[t].transpose(0, 2, 1)], axis=1)
        inside = np.linalg.solve(x, np.array([[1.0], [q[0]], [q[1]]])).min(axis=(1, 2))
        found.append(values[t[inside.argmax()]].mean())
    return np.array(found)


@ANSWERS.wrong("read-off", "The shares went to other corners")
def read_off(p, t, values, points):
    found = []
    for q in points:
        x = np.concatenate([np.ones((len(t), 1, 3)), p[t].transpose(0, 2, 1)], axis=1)
        share = np.linalg.solve(x, np.array([[1.0], [q[0]], [q[1]]]))[:, :, 0]
        best = share.min(axis=1).argmax()
        found.append(share[best, [1, 2, 0]] @ values[t[best]])
    return np.array(found)


@ANSWERS.wrong("read-off", "Rounding put a point on an edge outside")
def read_off(p, t, values, points):
    x = np.concatenate([np.ones((len(t), 1, 3)), p[t].transpose(0, 2, 1)], axis=1)
    found = []
    for q in points:
        share = np.linalg.solve(x, np.array([[1.0], [q[0]], [q[1]]]))[:, :, 0]
        best = share.min(axis=1).argmax()
        if share[best].min() > 0:
            found.append(share[best] @ values[t[best]])
        else:
            found.append(values[np.hypot(*(p - q).T).argmin()])
    return np.array(found)


@ANSWERS.wrong("read-off", "The nearest node has a value")
def read_off(p, t, values, points):
    x = np.concatenate([np.ones((len(t), 1, 3)), p[t].transpose(0, 2, 1)], axis=1)
    found = []
    for q in points:
        share = np.linalg.solve(x, np.array([[1.0], [q[0]], [q[1]]]))[:, :, 0]
        best = share.min(axis=1).argmax()
        inside = share[best].min() >= -1e-9
        found.append(share[best] @ values[t[best]] if inside else np.nan)
    return np.array(found)


@ANSWERS.wrong("read-off", "Is it the nearest of all the nodes")
def read_off(p, t, values, points):
    """Goes on with the plane of the best triangle, where there is none."""
    x = np.concatenate([np.ones((len(t), 1, 3)), p[t].transpose(0, 2, 1)], axis=1)
    found = []
    for q in points:
        share = np.linalg.solve(x, np.array([[1.0], [q[0]], [q[1]]]))[:, :, 0]
        best = share.min(axis=1).argmax()
        found.append(share[best] @ values[t[best]])
    return np.array(found)


ANSWERS.right("length-of-a-lake", share={"basin": 1.0, "disc": 0.853, "ponds": 1.9}, claim="n")
ANSWERS.wrong(
    "length-of-a-lake",
    "That is L_eff itself",
    share={"basin": 2.0, "disc": 0.853, "ponds": 5.7},
    claim="n",
)
ANSWERS.wrong(
    "length-of-a-lake",
    "Take the root of the eigenvalue",
    share={"basin": 0.636, "disc": 0.2316, "ponds": 3.45},
    claim="n",
)
ANSWERS.wrong(
    "length-of-a-lake",
    "That is what Merian says",
    share={"basin": 1.0, "disc": 0.853, "ponds": 1.0},
    claim="y",
)
ANSWERS.wrong(
    "length-of-a-lake",
    "Is any of your shares larger than 1",
    share={"basin": 0.998, "disc": 0.847, "ponds": 1.88},
    claim="y",
)


@ANSWERS.right("picture-to-mesh")
def lake_mesh(picture, grid, h):
    """Fit a plane of light, blur, take a threshold, and count distances in pixels."""
    x, y = np.moveaxis(grid.points, -1, 0)
    dark = np.zeros(picture.shape)
    columns = [np.ones_like(x), x, y]
    for _ in range(6):
        scaled = np.stack([c * (1 - dark / 2) for c in columns], axis=-1).reshape(-1, 3)
        plane = np.linalg.lstsq(scaled, picture.ravel(), rcond=None)[0]
        light = np.maximum(plane[0] + plane[1] * x + plane[2] * y, 0.05)
        even = ndimage.gaussian_filter(picture / light, 1)
        level = (np.quantile(even, 0.05) + np.quantile(even, 0.95)) / 2
        dark = (even < level).astype(float)
    pieces, _ = ndimage.label(dark)
    lake = pieces == np.bincount(pieces[dark > 0]).argmax()
    d = ndimage.distance_transform_edt(~lake) - ndimage.distance_transform_edt(lake)
    fd = grid.interpolate(ndimage.gaussian_filter(d, 1.5) * grid.dx[0], degree=1)
    p, t = de.generate_mesh(fd, None, h, grid.bbox)
    return p, t


@ANSWERS.wrong("picture-to-mesh", "the dark corner of the land")
def lake_mesh(picture, grid, h):
    pieces, _ = ndimage.label(picture < 0.6)
    lake = pieces == np.bincount(pieces[pieces > 0]).argmax()
    return de.generate_mesh(
        grid.interpolate(de.redistance(np.where(lake, -1.0, 1.0), grid.dx)), None, h, grid.bbox
    )


@ANSWERS.wrong("picture-to-mesh", "Is the pond in it")
def lake_mesh(picture, grid, h):
    d = ndimage.gaussian_filter(de.redistance(de.segment_picture(picture), grid.dx), 2)
    return de.generate_mesh(grid.interpolate(d), None, h, grid.bbox)


@ANSWERS.wrong("picture-to-mesh", "Is land taken for water")
def lake_mesh(picture, grid, h):
    phi = -de.segment_picture(picture)
    pieces, _ = ndimage.label(phi < 0)
    lake = pieces == np.bincount(pieces[pieces > 0]).argmax()
    d = de.redistance(np.where(lake, -1.0, 1.0), grid.dx)
    fd = de.intersection(grid.interpolate(d), de.rectangle(((-4.9, -4.9), (4.9, 4.9))))
    return de.generate_mesh(fd, None, h, grid.bbox)


@ANSWERS.wrong("picture-to-mesh", "about h = 0.3")
def lake_mesh(picture, grid, h):
    phi = de.segment_picture(picture)
    pieces, _ = ndimage.label(phi < 0)
    lake = pieces == np.bincount(pieces[pieces > 0]).argmax()
    land, _ = ndimage.label(~lake, np.ones((3, 3)))
    lake |= (np.bincount(land.ravel()) < 30)[land]
    d = ndimage.gaussian_filter(de.redistance(np.where(lake, -1.0, 1.0), grid.dx), 1)
    return de.generate_mesh(grid.interpolate(d), None, h / 2.5, grid.bbox)


@ANSWERS.wrong("picture-to-mesh", "the number of holes should be")
def lake_mesh(picture, grid, h):
    phi = de.segment_picture(picture)
    pieces, _ = ndimage.label(phi < 0)
    lake = ndimage.binary_fill_holes(pieces == np.bincount(pieces[pieces > 0]).argmax())
    d = ndimage.gaussian_filter(de.redistance(np.where(lake, -1.0, 1.0), grid.dx), 1)
    return de.generate_mesh(grid.interpolate(d), None, h, grid.bbox)


@ANSWERS.wrong("picture-to-mesh", "distance from the true shore should be at most 0.3")
def lake_mesh(picture, grid, h):
    """Erode the specks and the pond away, and the shore with them."""
    wet = ndimage.binary_erosion(de.segment_picture(picture) < 0, iterations=4)
    d = ndimage.gaussian_filter(de.redistance(np.where(wet, -1.0, 1.0), grid.dx), 1)
    return de.generate_mesh(grid.interpolate(d), None, h, grid.bbox)
