"""Shapes as fields: exact distances, right signs, and clear errors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.path import Path

import distmesh_edu as de

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


def test_boolean_operations_are_exact_on_one_side_only():
    """The thesis says that min and max give the distance; errata E2.4c measures where not."""
    a, b = de.circle((0, 0), 0.5), de.circle((0.5, 0), 0.5)
    middle = np.array([[0.25, 0.0]])
    assert de.union(a, b)(middle)[0] == pytest.approx(-0.25)
    true = -np.sqrt(3) / 4  # the corners of the union, at (0.25, +-0.433), are closest
    assert true == pytest.approx(-0.4330, abs=1e-4)


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
    ],
)
def test_bad_input_is_named(make, error, words):
    with pytest.raises(error, match=words):
        make()
