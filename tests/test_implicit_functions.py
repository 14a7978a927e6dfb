"""Shapes as fields: exact distances, right signs, and clear errors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.path import Path
from scipy.spatial import cKDTree

import distmesh_edu as de
from distmesh_edu import implicit_functions as shapes

SQUARE = np.array([(-1.0, -1), (1, -1), (1, 1), (-1, 1)])
STAR = np.array(
    [(0.0, 3), (0.4, 0.4), (3, 0), (0.4, -0.4), (0, -3), (-0.4, -0.4), (-3, 0), (-0.4, 0.4)]
)
NEEDLE = np.array([(0.0, 0.0), (10.0, 1e-3), (10.0, -1e-3)])


def brute_force_distance(rings, points):
    """Distance to every side in turn, as it is defined."""
    best = np.full(len(points), np.inf)
    for ring in rings:
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            t = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
            best = np.minimum(best, np.linalg.norm(points - a - t[:, None] * (b - a), axis=1))
    return best


def inside_by_parity(rings, points):
    """Inside an odd number of rings, counted by another library's crossing test."""
    return sum(Path(ring).contains_points(points).astype(int) for ring in rings) % 2 == 1


def random_star(rng, corners):
    """Return a polygon that cannot cross itself: corners at growing angles about the origin."""
    angles = 2 * np.pi * (np.arange(corners) + rng.uniform(0, 0.9, corners)) / corners
    radii = rng.uniform(0.2, 1.0, corners)
    return np.stack((radii * np.cos(angles), radii * np.sin(angles)), axis=1)


def test_circle_is_the_distance_to_its_boundary():
    p = np.array([[[3.0, 4.0], [0.0, 0.0]], [[1.0, 0.0], [0.0, -0.5]]])
    np.testing.assert_allclose(de.circle()(p), [[4, -1], [0, -0.5]])
    np.testing.assert_allclose(
        de.circle((3, 4), 2)(p), [[-2, 3], [np.sqrt(20) - 2, np.hypot(3, 4.5) - 2]]
    )


def test_rectangle_is_exact_beyond_its_corners():
    p = np.random.default_rng(1).uniform(-3, 3, (500, 2))
    inside = (np.abs(p) < 1).all(axis=1)
    expected = np.where(inside, -1, 1) * brute_force_distance([SQUARE], p)
    np.testing.assert_allclose(de.rectangle(((-1, -1), (1, 1)))(p), expected, atol=1e-14)


@pytest.mark.parametrize(
    "ring", [SQUARE, SQUARE[::-1], STAR, NEEDLE], ids=["square", "clockwise", "star", "needle"]
)
def test_polygon_is_exact_and_signed(ring):
    p = np.random.default_rng(2).uniform(-11, 11, (4000, 2))
    d = de.polygon(ring)(p)
    np.testing.assert_allclose(np.abs(d), brute_force_distance([ring], p), atol=1e-13)
    np.testing.assert_array_equal(d < 0, inside_by_parity([ring], p))


def test_polygon_sign_holds_next_to_a_sharp_corner():
    # All round the tip of a needle of 2e-4 radians, the closest point is the tip or just beside it.
    angle = np.linspace(0, 2 * np.pi, 720, endpoint=False) + 1e-3
    for radius in (1e-6, 1e-2, 1.0):
        p = radius * np.stack((np.cos(angle), np.sin(angle)), axis=1)
        assert (de.polygon(NEEDLE)(p) > 0).all()
    assert (de.polygon(NEEDLE)(np.array([[1e-3, 0.0], [5.0, 0.0], [9.999, 0.0]])) < 0).all()


@given(seed=st.integers(0, 10**6), corners=st.integers(4, 60), holes=st.booleans())
@settings(max_examples=60, deadline=None)
def test_polygon_with_holes_equals_the_definition(seed, corners, holes):
    rng = np.random.default_rng(seed)
    rings = [random_star(rng, corners)]
    room = 0.9 * brute_force_distance(rings, np.zeros((1, 2)))[0]
    if holes and inside_by_parity(rings, np.zeros((1, 2)))[0] and room > 0.01:
        rings.append(room * random_star(rng, 5))
    p = rng.uniform(-1.2, 1.2, (300, 2))
    d = de.polygon(rings[0], rings[1:])(p)
    exact = brute_force_distance(rings, p)
    np.testing.assert_allclose(np.abs(d), exact, atol=1e-13)
    clear = exact > 1e-12
    np.testing.assert_array_equal((d < 0)[clear], inside_by_parity(rings, p)[clear])


def test_polygon_far_from_everything_and_at_the_center_of_a_circle():
    # Where all sides are equally far, every piece must be looked at before one can be chosen.
    angle = np.linspace(0, 2 * np.pi, 1000, endpoint=False)
    ring = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    p = np.array([[0.0, 0.0], [1e-9, 0.0], [1e4, 2e4]])
    d = de.polygon(ring)(p)
    np.testing.assert_allclose(np.abs(d), brute_force_distance([ring], p), rtol=1e-12)
    assert d[0] < 0 < d[2]


def test_polygon_with_a_finely_drawn_bay():
    # Sides of very different lengths stand in trees of their own.
    t = np.linspace(0, 1, 3000)
    bay = np.stack((0.495 + 0.01 * t, 1e-3 * np.sin(60 * np.pi * t) ** 2), axis=1)
    ring = np.concatenate(([(0, 0)], bay, [(1, 0), (1, 1), (0, 1)]))
    p = np.random.default_rng(0).uniform((0.49, -0.01), (0.51, 0.01), (200, 2))
    p = np.concatenate((p, np.random.default_rng(1).uniform(-0.5, 1.5, (200, 2))))
    d = de.polygon(ring)(p)
    np.testing.assert_allclose(np.abs(d), brute_force_distance([ring], p), atol=1e-14)
    np.testing.assert_array_equal(d < 0, inside_by_parity([ring], p))


def test_polygon_keeps_the_leading_shape_and_takes_many_points():
    field = de.polygon(SQUARE)
    assert field(np.zeros((4, 5, 2))).shape == (4, 5)
    assert field(np.zeros(2)).shape == ()
    assert field(np.zeros((0, 2))).shape == (0,)
    assert field(np.zeros((40_000, 2))).shape == (40_000,)


@pytest.mark.parametrize("start", np.linspace(0, 6, 50))
def test_a_ring_closed_up_to_rounding_is_closed(start):
    angle = np.linspace(start, start + 2 * np.pi, 30)
    ring = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    assert de.polygon(ring)(np.zeros((1, 2)))[0] == pytest.approx(-np.cos(np.pi / 29))


@pytest.mark.parametrize(
    ("scale", "offset"), [(1e-9, 0), (1, 0), (1, 1e6), (1e6, 0), (1e6, 1e6), (1e6, 1e9)]
)
def test_polygon_of_any_size_and_place(scale, offset):
    p = np.random.default_rng(4).uniform(-4, 4, (500, 2))
    d = de.polygon(STAR * scale + offset)(p * scale + offset)
    np.testing.assert_allclose(d / scale, de.polygon(STAR)(p), atol=1e-9 + 1e-14 * offset / scale)


def crosses(ring):
    """Say whether two sides that are not neighbours cross, one pair after the other."""

    def left(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0

    n, corner = len(ring), [*ring, ring[0]]
    for i in range(n):
        for j in range(i + 2, n - (i == 0)):
            a, b, c, d = corner[i], corner[i + 1], corner[j], corner[j + 1]
            if left(a, b, c) != left(a, b, d) and left(c, d, a) != left(c, d, b):
                return True
    return False


def test_crossings_are_found_wherever_they_are():
    rng = np.random.default_rng(5)
    found = []
    for _ in range(200):
        ring = random_star(rng, 12)
        i, j = rng.choice(12, 2, replace=False)
        ring[[i, j]] = ring[[j, i]]  # two corners have changed places
        try:
            de.polygon(ring)
        except ValueError:
            found.append(True)
        else:
            found.append(False)
        assert found[-1] == crosses(ring)
    assert 10 < sum(found) < 200


def test_polygon_area_subtracts_holes_wherever_it_lies():
    hole = 0.25 * SQUARE
    assert de.polygon_area(SQUARE, [hole]) == pytest.approx(3.75)
    assert de.polygon_area(SQUARE[::-1] + 1e6, [hole + 1e6]) == pytest.approx(3.75, rel=1e-9)


def test_boolean_operations_have_the_right_sign():
    a, b = de.circle((0, 0), 1), de.circle((1, 0), 1)
    p = np.random.default_rng(3).uniform(-2, 3, (2000, 2))
    in_a, in_b = a(p) < 0, b(p) < 0
    np.testing.assert_array_equal(de.union(a, b)(p) < 0, in_a | in_b)
    np.testing.assert_array_equal(de.intersection(a, b)(p) < 0, in_a & in_b)
    np.testing.assert_array_equal(de.difference(a, b)(p) < 0, in_a & ~in_b)
    np.testing.assert_array_equal(de.complement(a)(p) < 0, ~in_a)


def arcs_of_two_discs(keep_a, keep_b, samples=40_001):
    """Sample those parts of two circles that bound a combination of their discs."""
    angle = np.linspace(0, 2 * np.pi, samples)
    unit = 0.5 * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    on_a, on_b = unit, unit + (0.5, 0)
    in_b = np.linalg.norm(on_a - (0.5, 0), axis=1) < 0.5
    in_a = np.linalg.norm(on_b, axis=1) < 0.5
    corners = [(0.25, np.sqrt(3) / 4), (0.25, -np.sqrt(3) / 4)]
    return np.concatenate((on_a[in_b == keep_a], on_b[in_a == keep_b], corners))


@pytest.mark.parametrize(
    ("operation", "keep", "at_middle", "inside", "outside"),
    [
        (de.union, (False, False), -0.25, 0.183, 0),
        (de.intersection, (True, True), -0.25, 0, 0.036),
        (de.difference, (False, True), 0.25, 0, 0.411),
    ],
    ids=["union", "intersection", "difference"],
)
def test_boolean_operations_are_exact_on_one_side_only(operation, keep, at_middle, inside, outside):
    """The thesis says that min and max give the distance; errata E2.4c measures where not."""
    field = operation(de.circle((0, 0), 0.5), de.circle((0.5, 0), 0.5))
    p = de.Grid(((-1, -1), (1.5, 1)), 0.0125).points
    d = field(p)
    true = np.copysign(cKDTree(arcs_of_two_discs(*keep)).query(p)[0], d)
    assert field(np.array([0.25, 0.0])) == pytest.approx(at_middle)
    np.testing.assert_array_less(np.abs(d), np.abs(true) + 1e-12)
    defect = np.abs(true - d)
    assert defect[d < 0].max() == pytest.approx(inside, abs=1e-3)
    assert defect[d > 0].max() == pytest.approx(outside, abs=1e-3)


def test_the_middle_of_a_union_is_farther_from_its_corners_than_min_says():
    corners = np.array([(0.25, np.sqrt(3) / 4), (0.25, -np.sqrt(3) / 4)])
    middle = np.array([0.25, 0.0])
    assert np.linalg.norm(corners - middle, axis=1).min() == pytest.approx(0.4330, abs=1e-4)
    beyond_a_corner = np.array([2.0, 2.0])
    assert np.abs(beyond_a_corner).max() - 1 == 1
    assert de.rectangle(((-1, -1), (1, 1)))(beyond_a_corner) == pytest.approx(np.sqrt(2))


# ---- the shapes of every dimension ----


def around(*parts):
    """Put samples of the parts of a boundary into one tree."""
    return cKDTree(np.concatenate([np.asarray(part, dtype=float) for part in parts]))


def ring(radius, height=0.0, samples=720):
    angle = np.linspace(0, 2 * np.pi, samples, endpoint=False)
    flat = radius * np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    return np.concatenate((flat, np.full((samples, 1), height)), axis=-1)


def ellipse_boundary(a, b):
    angle = np.linspace(0, 2 * np.pi, 400_000)
    return np.stack((a * np.cos(angle), b * np.sin(angle)), axis=1)


def box_surface(half, samples):
    """Sample every face of a box of any dimension, edges included."""
    axes = [np.linspace(-h, h, samples) for h in half]
    faces = []
    for axis, h in enumerate(half):
        for side in (-h, h):
            sides = [np.array([side]) if k == axis else one for k, one in enumerate(axes)]
            faces.append(np.stack(np.meshgrid(*sides, indexing="ij"), -1).reshape(-1, len(half)))
    return np.concatenate(faces)


def cylinder_surface(radius, height, samples=160):
    heights = np.linspace(-height / 2, height / 2, samples)
    radii = np.linspace(0, radius, samples)
    lids = [ring(r, z) for r in radii for z in (-height / 2, height / 2)]
    return np.concatenate([ring(radius, z) for z in heights] + lids)


def torus_surface(major, minor, samples=720):
    angle = np.linspace(0, 2 * np.pi, samples // 4, endpoint=False)
    return np.concatenate(
        [ring(major + minor * np.cos(t), minor * np.sin(t), samples) for t in angle]
    )


def sphere_surface(radius, samples=400):
    angles = np.linspace(0, np.pi, samples)
    return np.concatenate([ring(radius * np.sin(t), radius * np.cos(t)) for t in angles])


def stadium_boundary(half, radius):
    """Pull the two halves of a circle apart, and join them by straight sides."""
    circle = ellipse_boundary(radius, radius)
    side = np.linspace(-half, half, 20_001)
    straight = [np.stack((side, np.full_like(side, y)), axis=1) for y in (-radius, radius)]
    return np.concatenate((circle + np.sign(circle[:, :1]) * (half, 0), *straight))


# name: the field, the samples of its boundary, and how far apart they lie
SHAPES = {
    "interval": (shapes.box(((-1.0,), (1.0,))), np.array([[-1.0], [1.0]]), 0),
    "ball on a line": (shapes.sphere((0.0,), 1.2), np.array([[-1.2], [1.2]]), 0),
    "stadium": (shapes.segment((-0.5, 0), (0.5, 0), 0.5), stadium_boundary(0.5, 0.5), 6e-5),
    "rectangle": (shapes.box(((-1, -0.5), (1, 0.5))), box_surface((1, 0.5), 4001), 5e-4),
    "disc": (shapes.sphere((0.0, 0.0)), ellipse_boundary(1, 1), 2e-5),
    "ellipse": (shapes.ellipse(half_axes=(1.5, 0.5)), ellipse_boundary(1.5, 0.5), 3e-5),
    "box": (shapes.box(((-1, -0.5, -0.8), (1, 0.5, 0.8))), box_surface((1, 0.5, 0.8), 201), 0.01),
    "sphere": (shapes.sphere(), sphere_surface(1), 0.01),
    "cylinder": (shapes.cylinder(radius=0.7, height=1.6), cylinder_surface(0.7, 1.6), 0.01),
    "torus": (shapes.torus(major_radius=1, minor_radius=0.4), torus_surface(1, 0.4), 0.015),
}
SHAPE = pytest.mark.parametrize("name", SHAPES)


@SHAPE
def test_a_shape_is_the_distance_to_its_boundary(name):
    field, boundary, spacing = SHAPES[name]
    p = np.random.default_rng(6).uniform(-2, 2, (3000, boundary.shape[1]))
    d, sampled = np.abs(field(p)), cKDTree(boundary).query(p)[0]
    np.testing.assert_allclose(field(boundary), 0, atol=1e-12)
    # The nearest sample is not nearer than the boundary. It lies beside the closest point by half
    # the diagonal of a patch, which counts up to three times where the boundary curves away.
    aside = 3 * spacing * np.sqrt(max(boundary.shape[1] - 1, 1)) / 2
    assert (sampled >= d - 1e-12).all()
    assert (sampled <= np.hypot(d, aside) + 1e-12).all()


@SHAPE
def test_a_shape_is_negative_inside(name):
    """On the way from inside to far away, the sign changes where the boundary is, and once."""
    field, boundary, _ = SHAPES[name]
    dim = boundary.shape[1]
    start = np.array([1.0, 0.0, 0.0]) if name == "torus" else np.zeros(dim)
    ways = np.random.default_rng(7).normal(size=(200, dim))
    if name == "torus":
        ways[:, 0] = np.abs(ways[:, 0])
    t = np.linspace(0, 6, 500)
    d = field(start + t[:, None, None] * ways / np.linalg.norm(ways, axis=1)[:, None])
    assert (d[0] < 0).all()
    assert (d[-1] > 0).all()
    assert (np.abs(np.diff(np.sign(d), axis=0)).sum(axis=0) == 2).all()


@SHAPE
def test_the_gradient_of_a_shape_has_length_one(name):
    field, boundary, _ = SHAPES[name]
    dim = boundary.shape[1]
    p = np.random.default_rng(8).uniform(-2, 2, (2000, dim))
    ways = 1e-6 * np.eye(dim)
    slopes = [(field(p + way) - field(p - way)) / 2e-6 for way in ways]
    length = np.linalg.norm(slopes, axis=0)
    assert (length < 1 + 1e-8).all()
    assert (length > 1 - 1e-8).mean() > 0.995  # but next to where there is no gradient


@SHAPE
def test_a_shape_takes_any_leading_shape_and_changes_nothing(name):
    field, boundary, _ = SHAPES[name]
    p = np.random.default_rng(9).uniform(-1, 1, (3, 4, boundary.shape[1]))
    copy = p.copy()
    assert field(p).shape == (3, 4)
    assert np.shape(field(p[0, 0])) == ()
    assert field(p[:0]).shape == (0, 4)
    np.testing.assert_array_equal(field(p)[1], field(p[1]))
    np.testing.assert_array_equal(p, copy)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_a_half_plane_is_linear(dim):
    rng = np.random.default_rng(dim)
    normal, point, p = rng.normal(size=dim), rng.normal(size=dim), rng.normal(size=(50, dim))
    expected = (p - point) @ normal / np.linalg.norm(normal)
    np.testing.assert_allclose(shapes.half_plane(normal, point)(p), expected, atol=1e-14)
    np.testing.assert_allclose(
        shapes.half_plane(7 * normal)(p), p @ normal / np.linalg.norm(normal), atol=1e-14
    )
    opposite = shapes.half_plane(-normal, point)(p)
    np.testing.assert_allclose(opposite, -shapes.half_plane(normal, point)(p), atol=1e-14)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_a_segment_is_the_distance_to_the_nearest_of_its_points(dim):
    rng = np.random.default_rng(dim)
    a, b, p = rng.normal(size=dim), rng.normal(size=dim), rng.normal(size=(500, dim)) * 2
    pieces = a + np.linspace(0, 1, 20_001)[:, None] * (b - a)
    nearest = cKDTree(pieces).query(p)[0]
    np.testing.assert_allclose(shapes.segment(a, b)(p), nearest, atol=2e-4)
    np.testing.assert_allclose(shapes.segment(a, b, 0.3)(p), nearest - 0.3, atol=2e-4)
    np.testing.assert_array_equal(shapes.segment(a, b)(np.stack((a, b))) < 1e-15, True)
    if dim > 1:
        inside = shapes.segment(a, b, 0.3)(a + 0.3 * (b - a))
        assert inside == pytest.approx(-0.3)
    ball = shapes.segment(a, a, 0.5)(p)
    np.testing.assert_allclose(ball, np.linalg.norm(p - a, axis=1) - 0.5, atol=1e-14)


def test_a_cylinder_beyond_its_rims_and_along_any_axis():
    field = shapes.cylinder((1, 2, 3), radius=2, height=4, axis=(0, 5, 0))
    p = np.array([(1, 2, 3), (1, 7, 3), (6, 2, 3), (6, 8, 3), (1, 2, 4.5)], dtype=float)
    np.testing.assert_allclose(field(p), [-2, 3, 3, 5, -0.5], atol=1e-14)


def test_a_torus_about_any_axis():
    field = shapes.torus((0, 0, 1), 2, 0.5, axis=(3, 0, 0))
    p = np.array([(0, 2, 1), (0, 0, 3), (0, 0, 1), (1, 2, 1)], dtype=float)
    np.testing.assert_allclose(field(p), [-0.5, -0.5, 1.5, 0.5], atol=1e-14)


# ---- the ellipse: no formula, and every difficulty ----


def ellipse_distance_by_halving(p, a, b):
    """Solve for the closest point by bisection, in more digits than double precision has."""
    a, b, x, y = (np.asarray(v, dtype=np.longdouble) for v in (a, b, *np.abs(p).T))
    focal = (a - b) * (a + b)
    low = np.maximum(np.maximum(b * y, a * x - focal), np.longdouble(1e-40))
    high = np.maximum(np.hypot(a * x, b * y), low)
    for _ in range(400):
        middle = np.where(high > 2 * low, np.sqrt(low * high), (low + high) / 2)
        far = (a * x / (middle + focal)) ** 2 + (b * y / middle) ** 2 > 1
        low, high = np.where(far, middle, low), np.where(far, high, middle)
    u, v = a * x / (low + focal), b * y / low
    v = np.where((y == 0) & (u < 1), np.sqrt(np.maximum(1 - u * u, 0)), v)
    size = np.hypot(x - a * u / np.hypot(u, v), y - b * v / np.hypot(u, v))
    return np.where((x / a) ** 2 + (y / b) ** 2 < 1, -size, size).astype(float)


def hard_points(a, b):
    """Points on, beside, inside and far from an ellipse, and on the curve of its centers."""
    t = np.linspace(0, np.pi / 2, 400)
    rim = np.stack((a * np.cos(t), b * np.sin(t)), axis=1)
    centers = np.stack(
        ((a * a - b * b) / a * np.cos(t) ** 3, (a * a - b * b) / b * np.sin(t) ** 3), axis=1
    )
    line, zero = np.linspace(0, 2 * a, 400), np.zeros(400)
    return np.concatenate(
        (
            *(rim * s for s in (1, 1 - 1e-9, 1 + 1e-9, 0.5, 3)),
            centers,
            np.stack((line, zero), axis=1),
            np.stack((line, zero + 1e-13 * b), axis=1),
            np.stack((zero, line), axis=1),
            [(0, 0), (a, 0), (0, b), ((a * a - b * b) / a, 0), (1e6 * a, 1e6 * a)],
        )
    )


@pytest.mark.parametrize(
    ("a", "b"), [(2, 1), (1, 1), (1, 1 - 1e-9), (1e3, 1e-3), (1e3, 1), (1, 1e-3), (1e-3, 1e-3)]
)
def test_the_distance_to_an_ellipse_is_exact_up_to_rounding(a, b):
    p = hard_points(a, b)
    expected = ellipse_distance_by_halving(p, a, b)
    scale = np.maximum(a, np.abs(p).max(axis=1))
    on_it = np.abs(expected) < 1e-12 * a  # where rounding decides the sign
    for points, axes in ((p, (a, b)), (p[:, ::-1], (b, a)), (p * (-1, 1), (a, b))):
        d = shapes.ellipse(half_axes=axes)(points)
        assert (np.abs(np.abs(d) - np.abs(expected)) / scale).max() < 1e-15
        np.testing.assert_array_equal((d < 0)[~on_it], (expected < 0)[~on_it])


@given(
    center=st.tuples(*[st.floats(-5, 5)] * 2),
    axes=st.tuples(*[st.floats(1e-3, 1e3)] * 2),
    angle=st.floats(-7, 7),
)
@settings(max_examples=60, deadline=None)
def test_an_ellipse_turned_back_and_moved_back_is_itself(center, axes, angle):
    p = np.random.default_rng(0).uniform(-5, 5, (50, 2))
    plain = shapes.ellipse(half_axes=axes)
    moved = shapes.translation(plain, center)
    np.testing.assert_allclose(moved(p + center), plain(p), atol=1e-11)
    np.testing.assert_allclose(shapes.ellipse(center, axes)(p), moved(p), atol=1e-11)
    turned = shapes.rotation(shapes.ellipse(center, axes), angle, center)
    back = shapes.rotation(turned, -angle, center)
    np.testing.assert_allclose(back(p), shapes.ellipse(center, axes)(p), atol=1e-11)


# ---- motions ----


@given(angle=st.floats(-10, 10), seed=st.integers(0, 1000))
@settings(max_examples=40, deadline=None)
def test_a_rotation_carries_points_along(angle, seed):
    rng = np.random.default_rng(seed)
    cos, sin = np.cos(angle), np.sin(angle)
    p, center = rng.uniform(-2, 2, (20, 2)), rng.uniform(-1, 1, 2)
    there = center + (p - center) @ np.array([[cos, sin], [-sin, cos]])
    field = de.rectangle(((-1, 0), (2, 0.5)))
    np.testing.assert_allclose(shapes.rotation(field, angle, center)(there), field(p), atol=1e-13)

    # In space about z: the same in the plane, and z stays. About any axis: back and forth.
    deep = np.concatenate((there, rng.uniform(-1, 1, (20, 1))), axis=1)
    flat = np.concatenate((p, deep[:, 2:]), axis=1)
    solid = shapes.box(((-1, 0, -0.5), (2, 0.5, 0.5)))
    middle = (*center, 0.3)
    np.testing.assert_allclose(shapes.rotation(solid, angle, middle)(deep), solid(flat), atol=1e-13)
    axis = rng.normal(size=3)
    turned = shapes.rotation(solid, angle, middle, axis)
    along = middle + np.linspace(-2, 2, 9)[:, None] * axis
    np.testing.assert_allclose(turned(along), solid(along), atol=1e-13)
    back = shapes.rotation(turned, -angle, middle, axis)
    np.testing.assert_allclose(back(flat), solid(flat), atol=1e-13)


def test_a_quarter_turn_in_space_follows_the_right_hand():
    field = shapes.rotation(shapes.sphere((1, 0, 0), 0.1), np.pi / 2, axis=(0, 0, 1))
    assert field(np.array([0.0, 1, 0])) == pytest.approx(-0.1)
    field = shapes.rotation(shapes.sphere((0, 1, 0), 0.1), np.pi / 2, axis=(1, 0, 0))
    assert field(np.array([0.0, 0, 1])) == pytest.approx(-0.1)


@SHAPE
def test_scaling_and_translation_keep_a_distance(name):
    field, boundary, spacing = SHAPES[name]
    dim = boundary.shape[1]
    center, shift = np.full(dim, 0.3), np.arange(1.0, dim + 1)
    p = np.random.default_rng(10).uniform(-4, 4, (500, dim))
    there = shapes.translation(shapes.scaling(field, 2.5, center), shift)
    sampled = cKDTree(center + 2.5 * (boundary - center) + shift).query(p)[0]
    np.testing.assert_allclose(sampled, np.abs(there(p)), atol=2.5 * spacing * np.sqrt(dim) + 1e-12)
    np.testing.assert_allclose(there(shift + center + 2.5 * (p - center)), 2.5 * field(p))


# ---- blends ----

OPERATIONS = pytest.mark.parametrize("operation", [de.union, de.intersection, de.difference])


def discs(dim):
    away = np.zeros(dim)
    away[0] = 0.7
    return shapes.sphere(np.zeros(dim), 0.5), shapes.sphere(away, 0.4)


@pytest.mark.parametrize("dim", [1, 2, 3])
@OPERATIONS
def test_a_blend_differs_from_the_sharp_operation_where_it_may(operation, dim):
    a, b = discs(dim)
    p = np.random.default_rng(11).uniform(-1, 1.5, (20_000, dim))
    sharp, smooth = operation(a, b)(p), shapes.blend(a, b, 0.3, operation)(p)
    second = -b(p) if operation is de.difference else b(p)
    same = np.abs(a(p) - second) >= 0.3
    np.testing.assert_allclose(smooth[same], sharp[same], atol=1e-15)
    added = smooth - sharp if operation is not de.union else sharp - smooth
    assert added[~same].min() >= -1e-15
    assert added.max() == pytest.approx(0.3 / 4, rel=0.02)  # the bound is sharp
    assert (added <= 0.3 / 4 + 1e-15).all()


@pytest.mark.parametrize("dim", [2, 3])
@OPERATIONS
def test_a_blend_of_distances_is_a_lower_bound_of_the_distance(operation, dim):
    """No step changes it by more than its length, so that its zeros are that far away at least."""
    a, b = discs(dim)
    field = shapes.blend(a, b, 0.3, operation)
    rng = np.random.default_rng(12)
    p = rng.uniform(-1, 1.5, (20_000, dim))
    way = rng.normal(size=p.shape) * 10 ** rng.uniform(-6, 0, (len(p), 1))
    length = np.linalg.norm(way, axis=1)
    assert (np.abs(field(p + way) - field(p)) <= length * (1 + 1e-12) + 1e-15).all()


@OPERATIONS
def test_a_blend_has_no_kink(operation):
    """The slope of the sharp one jumps by 1 and more from one point to the next."""
    a, b = discs(2)
    x = np.linspace(-0.4, 1.0, 14_001)
    p = np.stack((x, np.full_like(x, 0.2)), axis=1)

    def largest_jump(field):
        return np.abs(np.diff(field(p), 2)).max() / (x[1] - x[0])

    assert largest_jump(operation(a, b)) > 0.5
    assert largest_jump(shapes.blend(a, b, 0.3, operation)) < 0.01


def test_a_blend_is_symmetric_but_for_the_difference():
    a, b = discs(2)
    p = np.random.default_rng(13).uniform(-1, 1.5, (500, 2))
    for operation in (de.union, de.intersection):
        np.testing.assert_allclose(
            shapes.blend(a, b, 0.2, operation)(p), shapes.blend(b, a, 0.2, operation)(p)
        )
    np.testing.assert_array_equal(shapes.blend(a, b, 0.2)(p), shapes.blend(a, b, 0.2, de.union)(p))


def test_arguments_are_not_changed():
    ring = SQUARE.copy()
    p = np.array([[0.1, 0.2]])
    de.polygon(ring)(p)
    np.testing.assert_array_equal(ring, SQUARE)
    np.testing.assert_array_equal(p, [[0.1, 0.2]])


BOW_TIE = [(0, 0), (1, 1), (1, 0), (0, 1)]
SPIKE = [(0, 0), (2, 0), (1, 0), (1, 1)]
TOUCHING = [(0, 0), (2, 0), (2, 2), (1, 0), (0, 2)]


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: de.circle(radius=0), ValueError, "radius must be one positive number"),
        (lambda: de.circle(radius=np.nan), ValueError, "radius must be finite"),
        (lambda: de.circle(center=(1, 2, 3)), ValueError, r"center must be one point \(x, y\)"),
        (lambda: de.circle(center="here"), TypeError, "center must hold real numbers"),
        (lambda: de.rectangle(((0, 0), (0, 1))), ValueError, "bbox must hold the lower corner"),
        (lambda: de.rectangle((0, 1)), ValueError, "bbox must be"),
        (lambda: de.union(), TypeError, "union takes 1 or more fields; got 0"),
        (lambda: de.union(de.circle(), 3), TypeError, "argument 2 of union must be a field"),
        (lambda: de.difference(de.circle()), TypeError, "difference takes 2 or more fields"),
        (lambda: de.difference(3, de.circle()), TypeError, "argument 1 of difference must be"),
        (lambda: de.difference(de.circle(), 3), TypeError, "argument 2 of difference must be"),
        (lambda: de.complement(None), TypeError, "field must be a field"),
        (lambda: de.polygon([(0, 0), (1, 1)]), ValueError, "vertices must have three corners"),
        (lambda: de.polygon([(0, 0), (1, 1), (0, 0)]), ValueError, "three corners"),
        (lambda: de.polygon([(0, 0), (1, np.nan), (1, 1)]), ValueError, r"vertices\[1, 1\] is nan"),
        (lambda: de.polygon([(0, 0), (1, 0), (1, 0), (1, 1)]), ValueError, "twice in a row"),
        (lambda: de.polygon(BOW_TIE), ValueError, "crosses or touches itself"),
        (lambda: de.polygon(SPIKE), ValueError, "crosses or touches itself"),
        (lambda: de.polygon(TOUCHING), ValueError, "crosses or touches itself"),
        (lambda: de.polygon(SQUARE, [SQUARE + 0.5]), ValueError, "crosses or touches itself"),
        (lambda: de.polygon(SQUARE, [SQUARE + 5]), ValueError, r"holes\[0\] must lie inside"),
        (
            lambda: de.polygon(SQUARE, [[(0, 0), (0.5, 0.5)]]),
            ValueError,
            r"holes\[0\] must have three",
        ),
        (lambda: de.polygon([[0, 0, 0]] * 3), ValueError, r"shape \(n, 2\)"),
        (lambda: de.polygon(SQUARE, SQUARE / 2), ValueError, r"Write holes=\[ring\]"),
        (lambda: de.polygon(SQUARE, [SQUARE / 2, SQUARE / 4]), ValueError, "lies inside holes"),
        (lambda: de.polygon(SQUARE)(np.zeros((4, 3))), ValueError, r"shape \(\.\.\., 2\)"),
        (lambda: de.circle(radius=None), TypeError, "radius must hold real numbers; got None"),
        (lambda: shapes.sphere(radius=-1), ValueError, "radius must be one positive number"),
        (lambda: shapes.sphere(1.0), ValueError, "center must be one vector"),
        (lambda: shapes.box(((0, 0, 0), (1, 1, 0))), ValueError, "along axis 2"),
        (lambda: shapes.half_plane((0, 0)), ValueError, "normal must not be zero"),
        (lambda: shapes.half_plane((0, 1), (1, 2, 3)), ValueError, "point must be .* length 2"),
        (lambda: shapes.ellipse(half_axes=(1, 0)), ValueError, "half_axes must be positive"),
        (lambda: shapes.ellipse(half_axes=2), ValueError, "half_axes must be one vector"),
        (lambda: shapes.ellipse((0, 0, 0)), ValueError, "center must be .* length 2"),
        (lambda: shapes.cylinder(height=0), ValueError, "height must be one positive number"),
        (lambda: shapes.cylinder(axis=(0, 0, 0)), ValueError, "axis must not be zero"),
        (lambda: shapes.cylinder((0, 0)), ValueError, "center must be .* length 3"),
        (lambda: shapes.torus(minor_radius=1), ValueError, "less than major_radius"),
        (lambda: shapes.torus(axis=(1, 0)), ValueError, "axis must be .* length 3"),
        (lambda: shapes.segment((0, 0), (1, 1, 1)), ValueError, "b must be .* length 2"),
        (lambda: shapes.segment((0, 0), (1, 1), -1), ValueError, "radius must be .* 0 or positive"),
        (lambda: shapes.rotation(3, 1), TypeError, "field must be a field"),
        (lambda: shapes.rotation(de.circle(), (1, 2)), ValueError, "angle must be one number"),
        (lambda: shapes.rotation(shapes.sphere(), 1, axis=(0, 0, 0)), ValueError, "axis must not"),
        (
            lambda: shapes.rotation(de.circle(), 1, axis=(0, 0, 1))(np.zeros((4, 2))),
            ValueError,
            r"axis=\(0, 0, 1\) got points of shape \(4, 2\)",
        ),
        (
            lambda: shapes.rotation(shapes.sphere((0.0,)), 1)(np.zeros((4, 1))),
            ValueError,
            r"got points of shape \(4, 1\)",
        ),
        (lambda: shapes.translation(de.circle(), 1), ValueError, "shift must be one vector"),
        (lambda: shapes.translation(None, (1, 1)), TypeError, "field must be a field"),
        (lambda: shapes.scaling(de.circle(), 0), ValueError, "factor must be one positive"),
        (lambda: shapes.scaling(de.circle(), (2, 1)), ValueError, "factor must be one positive"),
        (lambda: shapes.blend(de.circle(), 1, 0.1), TypeError, "argument 2 of blend"),
        (lambda: shapes.blend(de.circle(), de.circle(), 0), ValueError, "width must be one"),
        (
            lambda: shapes.blend(de.circle(), de.circle(), 1, min),
            ValueError,
            "operation must be union, intersection or difference",
        ),
    ],
)
def test_bad_input_is_named(make, error, words):
    with pytest.raises(error, match=words):
        make()
