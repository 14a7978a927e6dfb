"""Lake Superior, its mesh, photographs; the Salish Sea; red blood cells; roses, stars, discs."""

import warnings
from importlib.resources import files

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.special import ndtr

import distmesh_edu as de
from distmesh_edu import examples, geometry

PUBLISHED_AREA = 82_100  # square kilometres


def test_the_shores_are_those_of_the_file():
    rings = de.examples.lake_superior_shores()
    assert [len(ring) for ring in rings] == [308, 7, 11, 7, 8, 16, 23, 33, 12, 11]
    assert all((ring[0] != ring[-1]).any() for ring in rings)


def test_the_map_has_the_lakes_area_and_size():
    shore, *islands = de.examples.lake_superior_shores()
    assert de.polygon_area(shore, islands) == pytest.approx(PUBLISHED_AREA, rel=0.005)
    width, height = np.ptp(shore, axis=0)
    assert 540 < width < 600  # published: 563 km long, 257 km wide, measured along the lake
    assert 240 < height < 300
    isle_royale = sorted(de.polygon_area(ring) for ring in islands)[-2]
    assert isle_royale == pytest.approx(535, rel=0.15)  # published: 535 square kilometres


def test_the_map_keeps_areas():
    """A one-degree cell of the map has the area of the sphere's: R**2 dlon (sin f2 - sin f1)."""
    from distmesh_edu.examples import EARTH_RADIUS, on_the_map

    corners = np.array([(-90.0, 48), (-89, 48), (-89, 49), (-90, 49)])
    exact = EARTH_RADIUS**2 * np.radians(1) * np.diff(np.sin(np.radians([48, 49])))[0]
    assert de.polygon_area(on_the_map(corners)) == pytest.approx(exact, rel=1e-12)


def test_water_is_negative_and_land_positive():
    fd = de.examples.lake_superior()
    shore, *islands = de.examples.lake_superior_shores()
    assert fd(np.array([[60.0, 60.0]]))[0] == pytest.approx(-78, abs=1)
    assert fd(np.array([[0.0, -200.0]]))[0] > 100
    assert all(fd(ring.mean(axis=0)[None])[0] > 0 for ring in islands)
    np.testing.assert_allclose(fd(shore), 0, atol=1e-9)


def test_a_mesh_of_the_lake_leaves_the_islands_out():
    shore, *islands = de.examples.lake_superior_shores()
    box = (shore.min(axis=0) - 5, shore.max(axis=0) + 5)
    fd = de.examples.lake_superior()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", de.ConvergenceWarning)
        mesh = de.distmesh2d(fd, None, 15, box, max_steps=60)
    assert mesh.area == pytest.approx(de.polygon_area(shore, islands), rel=0.03)
    largest = max(islands, key=de.polygon_area)
    centroids = mesh.p[mesh.t].mean(axis=1)
    assert (de.polygon(largest)(centroids) > 0).all()
    assert mesh.euler_characteristic < 0


def test_the_lake_fine_at_the_shore_is_good_once_its_worst_triangle_is():
    """What chapter 8 does: stop at the first triangulation that is good enough."""
    lake, box = de.examples.lake_superior(), ((-310, -120), (276, 166))
    grid = de.Grid(box, 2)
    size = grid.interpolate(6 + 0.2 * np.abs(lake(grid.points)), degree=1)
    for mesh in de.distmesh2d_steps(lake, size, 6, box, max_steps=500):
        latest = mesh.history[-1]
        if latest["step"] == mesh.steps and latest["minimum_quality"] > 0.4:
            break
    shore, *islands = de.examples.lake_superior_shores()
    assert mesh.quality.min() >= 0.3
    assert mesh.quality.mean() >= 0.93
    assert mesh.area == pytest.approx(de.polygon_area(shore, islands), rel=0.015)
    at_shore = np.isin(mesh.edges, mesh.boundary_facets).all(axis=1)
    assert np.median(mesh.edge_lengths[at_shore]) == pytest.approx(6.6, abs=0.6)
    assert mesh.edge_lengths.max() > 20


# ---- shapes of the book ----


@pytest.mark.parametrize("petals", [3, 4, 9])
def test_a_rose_is_negative_in_its_leaves(petals):
    field = examples.rose(petals, radius=2)
    middles = np.pi / (2 * petals) + 2 * np.pi * np.arange(petals) / petals
    way = np.stack((np.cos(middles), np.sin(middles)), axis=1)
    np.testing.assert_allclose(field(2 * way), 0, atol=1e-12)
    np.testing.assert_allclose(field(way), -1, atol=1e-12)
    between = middles + np.pi / petals
    way = np.stack((np.cos(between), np.sin(between)), axis=1)
    np.testing.assert_allclose(field(0.5 * way), 2.5, atol=1e-12)


def test_the_rose_has_the_area_of_its_leaves():
    """Each leaf has pi r^2 / 36 for nine of them: a quarter of the disc in all."""
    grid = de.Grid(((-1.1, -1.1), (1.1, 1.1)), 0.005)
    area = geometry.volume(examples.rose()(grid.points), grid.dx)
    assert area == pytest.approx(np.pi / 4, rel=2e-3)


def test_the_nodes_in_the_rose_and_the_star_are_those_of_the_measurements():
    """Counted in runs of the listings on the thesis's grid: 316 and 481, text's star 125."""
    points = de.Grid(((-2, -2), (2, 2)), 0.05).points
    assert np.count_nonzero(examples.rose()(points) < 0) == 316
    inside = examples.star()(points) < -1e-12  # four cusps lie on nodes
    assert np.count_nonzero(inside) == 481
    assert np.count_nonzero(examples.star(1 / 3)(points) < -1e-12) == 125


@pytest.mark.parametrize(
    ("exponent", "area"), [(2 / 3, 3 * np.pi / 8), (1 / 3, 0.2), (1, 2), (2, np.pi)]
)
def test_a_star_has_its_area(exponent, area):
    grid = de.Grid(((-1.2, -1.2), (1.2, 1.2)), 0.0048)
    found = geometry.volume(examples.star(exponent)(grid.points), grid.dx)
    assert found == pytest.approx(area, rel=0.03 if exponent < 0.5 else 5e-3)  # thin cusps


def zalesak_boundary(radius=0.15, half=0.025, top=0.1):
    rim = -np.sqrt(radius**2 - half**2)
    start = np.arctan2(rim, half)
    angle = np.linspace(start, np.pi - start, 100_001)
    arc = radius * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    y, x = np.linspace(rim, top, 30_001), np.linspace(-half, half, 10_001)
    sides = [np.stack((np.full_like(y, s * half), y), axis=1) for s in (-1, 1)]
    end = np.stack((x, np.full_like(x, top)), axis=1)
    return np.concatenate((arc, *sides, end)) + (0.5, 0.75)


def test_the_slotted_disc_is_an_exact_distance():
    field, boundary = examples.zalesak(), zalesak_boundary()
    rng = np.random.default_rng(17)
    p = np.concatenate((rng.uniform(0, 1, (3000, 2)), rng.uniform(0.3, 0.95, (6000, 2))))
    d, sampled = field(p), cKDTree(boundary).query(p)[0]
    np.testing.assert_allclose(field(boundary), 0, atol=1e-12)
    assert (np.abs(d) <= sampled + 1e-12).all()
    assert (sampled <= np.hypot(d, 2e-5) + 1e-9).all()
    q = p - (0.5, 0.75)
    in_slot = (np.abs(q[:, 0]) < 0.025) & (q[:, 1] < 0.1)
    np.testing.assert_array_equal(d < 0, (np.linalg.norm(q, axis=1) < 0.15) & ~in_slot)
    mirrored = field(p * (-1, 1) + (1, 0))
    np.testing.assert_allclose(mirrored, d, atol=1e-14)


def test_the_slotted_disc_has_its_area():
    half, r = 0.025, 0.15
    lid = half * np.sqrt(r**2 - half**2) + r**2 * np.arcsin(half / r)
    exact = np.pi * r**2 - (0.1 * 2 * half + lid)
    grid = de.Grid(((0.3, 0.55), (0.7, 0.95)), 0.001)
    found = geometry.volume(examples.zalesak()(grid.points), grid.dx)
    assert found == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("amplitude", [0.05, 0.3, 0.6])
def test_the_five_petals_and_their_distance(amplitude):
    angle = np.linspace(0, 2 * np.pi, 250_001)
    r = 1 + amplitude * np.cos(5 * angle)
    curve = np.stack((r * np.cos(angle), r * np.sin(angle)), axis=1)
    p = np.random.default_rng(18).uniform(-2, 2, (4000, 2))
    field, distance = examples.five_petals(amplitude), examples.five_petals_distance(amplitude)
    d, sampled = distance(p), cKDTree(curve).query(p)[0]
    assert (np.abs(d) <= sampled + 1e-13).all()
    assert (sampled <= np.hypot(d, 8e-5) + 1e-13).all()
    np.testing.assert_array_equal(field(p) < 0, d < 0)
    np.testing.assert_allclose(distance(curve[::1000]), 0, atol=1e-14)
    np.testing.assert_allclose(field(curve[::1000]), 0, atol=1e-14)


def test_the_distance_to_the_five_petals_has_slope_one_and_the_level_set_has_not():
    distance, p = examples.five_petals_distance(), np.random.default_rng(19).normal(size=(2000, 2))
    length = np.linalg.norm(geometry.gradient_at(distance, p), axis=1)
    assert (np.abs(length - 1) < 1e-8).mean() > 0.99
    on_it = p - distance(p)[:, None] * geometry.gradient_at(distance, p)
    on_it = on_it[np.abs(distance(on_it)) < 1e-9]
    slopes = np.linalg.norm(geometry.gradient_at(examples.five_petals(), on_it), axis=1)
    assert slopes.min() == pytest.approx(0.51, abs=0.03)
    assert slopes.max() == pytest.approx(2.79, abs=0.03)


def test_the_five_petals_have_their_area():
    grid = de.Grid(((-1.5, -1.5), (1.5, 1.5)), 0.01)
    exact = np.pi * (1 + 0.3**2 / 2)
    for field in (examples.five_petals(), examples.five_petals_distance()):
        found = geometry.volume(field(grid.points), grid.dx)
        assert found == pytest.approx(exact, rel=2e-4)


SHAPES = [
    examples.rose(),
    examples.star(),
    examples.zalesak(),
    examples.five_petals(),
    examples.five_petals_distance(),
]


@pytest.mark.parametrize("field", SHAPES)
def test_a_shape_of_the_book_takes_any_leading_shape(field):
    p = np.random.default_rng(20).uniform(-1, 1, (3, 4, 2))
    copy = p.copy()
    assert field(p).shape == (3, 4)
    assert np.shape(field(p[0, 0])) == ()
    assert field(p[:0]).shape == (0, 4)
    np.testing.assert_array_equal(p, copy)
    assert np.isfinite(field(np.zeros((1, 2)))).all()


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: examples.rose(0), ValueError, "petals must be 1 at least"),
        (lambda: examples.rose(2.5), TypeError, "petals must be a whole number"),
        (lambda: examples.rose(radius=0), ValueError, "radius must be one positive number"),
        (lambda: examples.star(0), ValueError, "exponent must be one positive number"),
        (lambda: examples.zalesak(width=0.4), ValueError, "must leave the slot in the disc"),
        (lambda: examples.zalesak(length=0.3), ValueError, "must leave the slot in the disc"),
        (lambda: examples.zalesak(length=0.001), ValueError, "must leave the slot in the disc"),
        (lambda: examples.zalesak(radius=-1), ValueError, "radius must be one positive number"),
        (lambda: examples.zalesak((0, 0, 0)), ValueError, "center must be one point"),
        (lambda: examples.five_petals(1.2), ValueError, "amplitude must be less than 1"),
        (lambda: examples.five_petals_distance(0), ValueError, "amplitude must be one positive"),
    ],
)
def test_bad_input_of_a_shape_is_named(make, error, words):
    with pytest.raises(error, match=words):
        make()


# ---- photographs ----

PLATE = de.Grid(((-1, -1), (1, 1)), 0.01)


def half_plane(p):
    return p[..., 0] - 0.005


def photo(fd=half_plane, grid=PLATE, **changes):
    return examples.photograph(fd, grid, **({"noise": 0, "light": 0, "blur": 0} | changes))


def test_land_is_bright_and_water_dark():
    expected = np.where(half_plane(PLATE.points) > 0, 0.8, 0.4)
    np.testing.assert_array_equal(photo(), expected)
    np.testing.assert_array_equal(photo(lambda p: 9 * half_plane(p) ** 3), expected)
    assert (photo(lambda p: 0 * p[..., 0]) == 0.4).all()  # the shore itself is wet


def test_the_noise_is_normal_and_each_pixel_has_its_own():
    noise = photo(noise=0.07) - photo()
    count = noise.size
    assert abs(noise.mean()) < 4 * 0.07 / np.sqrt(count)
    assert noise.std() == pytest.approx(0.07, rel=4 / np.sqrt(2 * count))
    share = (np.abs(noise) < 0.07).mean()
    assert share == pytest.approx(2 * ndtr(1) - 1, abs=4 * 0.5 / np.sqrt(count))
    for there in (noise[1:] * noise[:-1], noise[:, 1:] * noise[:, :-1]):
        assert abs(there.mean()) < 4 * 0.07**2 / np.sqrt(count)


def test_the_noise_is_added_last():
    """It is the same on any picture: neither blurred nor dimmed."""
    noise = photo(noise=0.02) - photo()
    dim = photo(noise=0.05, light=0.6, blur=3) - photo(light=0.6, blur=3)
    np.testing.assert_allclose(dim, 2.5 * noise, atol=1e-12)


def test_one_seed_one_picture():
    one = photo(noise=0.1, rng=3)
    np.testing.assert_array_equal(one, photo(noise=0.1, rng=3))
    np.testing.assert_array_equal(one, photo(noise=0.1, rng=np.random.default_rng(3)))
    assert (one != photo(noise=0.1, rng=4)).mean() > 0.99
    rng = np.random.default_rng(3)
    assert (photo(noise=0.1, rng=rng) != photo(noise=0.1, rng=rng)).mean() > 0.99


@pytest.mark.parametrize("light", [0.45, 0.7])
def test_the_light_is_a_plane_and_runs_along_the_diagonal(light):
    lit = photo(light=light) / photo()
    assert lit[0, 0] == pytest.approx(1 - 1.4 * light)
    assert lit[-1, -1] == pytest.approx(1 + 1.4 * light)
    assert lit.mean() == pytest.approx(1)
    assert lit.min() > 0
    for axis in (0, 1):
        np.testing.assert_allclose(np.diff(lit, 2, axis=axis), 0, atol=1e-14)
        assert (np.diff(lit, axis=axis) > 0).all()


@pytest.mark.parametrize("blur", [1.0, 3.0])
def test_a_shore_is_blurred_into_the_bells_integral(blur):
    picture = photo(blur=blur)
    pixels = (PLATE.axes[0] - 0.005) / 0.01
    expected = 0.4 + 0.4 * ndtr(pixels / blur)
    np.testing.assert_allclose(picture, expected[:, None] + 0 * picture, atol=6e-3)
    flat = photo(lambda p: 0 * p[..., 0] + 1, blur=blur)
    np.testing.assert_allclose(flat, 0.8, atol=1e-14)


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"noise": -0.1}, ValueError, "noise must be one number, 0 or more; got -0.1"),
        ({"noise": np.nan}, ValueError, "noise must be finite"),
        ({"noise": [0.1, 0.2]}, ValueError, "noise must be one number"),
        ({"light": -1}, ValueError, "light must be one number, 0 or more; got -1"),
        ({"light": 0.8}, ValueError, "light must be at most 0.7.*got 0.8"),
        ({"light": np.inf}, ValueError, "light must be finite"),
        ({"blur": -2}, ValueError, "blur must be one number, 0 or more; got -2"),
        ({"blur": "much"}, TypeError, "blur must hold real numbers"),
        ({"grid": PLATE.points}, TypeError, "grid must be a Grid in the plane"),
        ({"grid": de.Grid((0, 1), 0.1)}, TypeError, "grid must be a Grid in the plane"),
        ({"grid": de.Grid(((0,) * 3, (1,) * 3), 0.5)}, TypeError, "grid must be a Grid in the"),
        ({"fd": 1.0}, TypeError, "fd must be a field"),
        ({"fd": lambda p: np.nan * p[..., 0]}, ValueError, "fd must be finite"),
        ({"fd": lambda p: np.zeros(3)}, ValueError, "fd must return one value a point"),
        ({"rng": -1}, ValueError, "rng must be a seed"),
        ({"rng": "a"}, TypeError, "rng must be a seed"),
    ],
)
def test_bad_input_of_a_photograph_is_named(change, error, words):
    with pytest.raises(error, match=words):
        photo(**change)


# ---- the Salish Sea ----


def test_the_sea_lies_on_a_square_grid():
    height, grid = examples.salish_sea()
    assert height.shape == grid.shape == (120, 91)
    assert height.dtype == float
    assert grid.dx[0] == pytest.approx(grid.dx[1], rel=2e-5)
    assert grid.dx[0] == pytest.approx(2.43, abs=0.01)


def test_the_nodes_of_the_sea_are_those_of_the_file_on_mercators_map():
    """They have y = R cos(f0) ln(tan(pi/4 + f/2)), for each latitude f of the file."""
    with files("distmesh_edu").joinpath("data", "salish_sea.npz").open("rb") as file:
        data = dict(np.load(file))
    height, grid = examples.salish_sea()
    np.testing.assert_array_equal(height, data["topo"].T)
    scale, f = 6371.0088 * np.cos(np.radians(49)), np.radians(data["latitude"])
    y = scale * np.log(np.tan(np.pi / 4 + f / 2) / np.tan(np.pi / 4 + np.radians(49) / 2))
    x = scale * np.radians(data["longitude"] - 236)  # from 124 W
    expected = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    np.testing.assert_allclose(grid.points, expected, atol=0.01)
    spacings = np.concatenate((np.diff(x), np.diff(y)))
    np.testing.assert_allclose(spacings, grid.dx[0], rtol=0.01)


@pytest.mark.parametrize(
    ("longitude", "latitude", "low", "high"),
    [
        (-123.8, 49.3, -450, -300),  # the strait of Georgia, 448 m deep at most
        (-124.0, 48.25, -250, -100),  # the strait of Juan de Fuca
        (-125.9, 48.05, -1500, -100),  # the open ocean
        (-123.0, 49.85, 1200, 2678),  # Garibaldi's massif
        (-125.75, 49.66, 1000, 2195),  # the Golden Hinde, on Vancouver Island
        (-123.5, 48.02, 100, 1200),  # the foot of the Olympic Mountains
    ],
)
def test_a_known_place_of_the_sea_is_as_high_as_it_is(longitude, latitude, low, high):
    height, grid = examples.salish_sea()
    scale = 6371.0088 * np.cos(np.radians(49))
    north = np.log(np.tan(np.pi / 4 + np.radians([latitude, 49]) / 2))
    place = scale * np.array([np.radians(longitude + 124), north[0] - north[1]])
    node = tuple(np.rint((place - grid.bbox[0]) / grid.dx).astype(int))
    np.testing.assert_allclose(grid.points[node], place, atol=1.25)
    assert low < height[node] < high


def test_the_sea_is_fresh_each_time():
    height, _ = examples.salish_sea()
    deepest = height.min()
    height[:] = 0
    assert examples.salish_sea()[0].min() == deepest < 0


# ---- red blood cells ----

#: diameter, thinnest, thickest: Evans and Fung's means, another cell, and one without dimples.
DISCOCYTES = [(7.82, 0.81, 2.58), (8.0, 1.0, 2.12), (5.0, 1.5, 1.5)]
STOMATOCYTES = [(8.0, 0.15, 0.88, 1.2, 0.3), (6.0, 0.5, 0.4, 0.8, 0.5)]


def points_in_space(seed, size=5.0, count=3000):
    return np.random.default_rng(seed).uniform(-size, size, (count, 3))


def biconcave_polynomial(p, d, a, m):
    """Return the left side of thesis eq. (6.1)."""
    w, z = p[..., 0] ** 2 + p[..., 1] ** 2, p[..., 2]
    P = (1 - 2 * m) * d**2 / (4 * m)
    Q = (1 - m) * d**4 / (16 * a**2 * m)
    R = (m - 1) * d**4 / (16 * m)
    return w**2 + P * w + Q * z**2 + R


def upper_polynomial(p, d, a, m):
    """Return the left side of thesis eq. (6.2), with 2 m**2 in B in place of the printed 2 m2."""
    w, z = p[..., 0] ** 2 + p[..., 1] ** 2, p[..., 2]
    A = -(4 * m - 3) * d**2 / (4 * m)
    B = 3 * (1 - 3 * m + 2 * m**2) * d**4 / (16 * m**2)
    C = -((m - 1) ** 2) * (4 * m - 1) * d**6 / (64 * m**3)
    D = (1 - m) ** 3 * d**8 / (256 * a**2 * m**3)
    E = (m - 1) ** 3 * d**8 / (256 * m**3)
    return w**4 + A * w**3 + B * w**2 + C * w + D * z**2 + E


def lower_polynomial(p, d, a, m):
    """Return the left side of thesis eq. (6.4)."""
    w, z = p[..., 0] ** 2 + p[..., 1] ** 2, p[..., 2]
    F = -(3 * m - 2) * d**2 / (4 * m)
    G = (1 - 4 * m + 3 * m**2) * d**4 / (16 * m**2)
    H = (1 - m) ** 2 * d**6 / (64 * a**2 * m**2)
    I = -((m - 1) ** 2) * d**6 / (64 * m**2)  # noqa: E741
    return w**3 + F * w**2 + G * w + H * z**2 + I


def same_up_to_a_power(polynomial, values, s, m, power):
    """Assert that they differ by a positive constant times (1 + k s)**power, s = (2 r / d)**2."""
    quotient = polynomial / values / (1 + m / (1 - m) * s) ** power
    assert quotient.min() > 0
    np.testing.assert_allclose(quotient, np.median(quotient), rtol=1e-6)


@pytest.mark.parametrize(("d", "b", "h"), DISCOCYTES)
def test_the_discocyte_is_the_thesis_polynomial(d, b, h):
    p = points_in_space(21)
    m, s = (1 + np.sqrt(1 - (b / h) ** 2)) / 2, 4 * (p[:, 0] ** 2 + p[:, 1] ** 2) / d**2
    field = examples.discocyte(d, b, h)
    same_up_to_a_power(biconcave_polynomial(p, d, b / 2, m), field(p), s, m, 1)


@pytest.mark.parametrize(("d", "a1", "m1", "a2", "m2"), STOMATOCYTES)
def test_the_stomatocyte_is_the_thesis_polynomials(d, a1, m1, a2, m2):
    p = points_in_space(22)
    s, values = 4 * (p[:, 0] ** 2 + p[:, 1] ** 2) / d**2, examples.stomatocyte(d, a1, m1, a2, m2)(p)
    up = p[:, 2] > 0
    same_up_to_a_power(upper_polynomial(p[up], d, a1, m1), values[up], s[up], m1, 3)
    same_up_to_a_power(lower_polynomial(p[~up], d, a2, m2), values[~up], s[~up], m2, 2)


def meridian(field, d, side, count=20_001):
    """Return r and z of the surface above (1) or below (-1) the plane, by halving intervals."""
    r = d / 2 * np.sin(np.linspace(0, np.pi / 2, count))
    low, high = np.zeros(count), np.full(count, d)
    for _ in range(60):
        middle = (low + high) / 2
        inside = field(np.stack((r, 0 * r, side * middle), axis=1)) < 0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return r, side * low


@pytest.mark.parametrize(("d", "b", "h"), DISCOCYTES)
def test_a_discocyte_is_as_thick_and_as_wide_as_asked(d, b, h):
    field = examples.discocyte(d, b, h)
    ends = [(d / 2, 0, 0), (0, -d / 2, 0), (0, 0, b / 2), (0, 0, -b / 2)]
    np.testing.assert_allclose(field(np.array(ends)), 0, atol=1e-9)
    r, z = meridian(field, d, 1)
    assert 2 * z.max() == pytest.approx(h, rel=1e-6)
    k = (1 + np.sqrt(1 - (b / h) ** 2)) / (1 - np.sqrt(1 - (b / h) ** 2))
    assert r[z.argmax()] == pytest.approx(d / 2 * np.sqrt((k - 1) / (2 * k)), abs=0.01 * d)


@pytest.mark.parametrize(("d", "a1", "m1", "a2", "m2"), STOMATOCYTES)
def test_a_stomatocyte_reaches_as_far_as_its_formula(d, a1, m1, a2, m2):
    """Where it has a dimple, a sqrt(q**q / ((q + 1)**(q + 1) m (1 - m)**q))."""
    field = examples.stomatocyte(d, a1, m1, a2, m2)
    ends = [(d / 2, 0, 0), (0, -d / 2, 0), (0, 0, a1), (0, 0, -a2)]
    np.testing.assert_allclose(field(np.array(ends)), 0, atol=1e-9)
    for side, q, a, m in ((1, 3, a1, m1), (-1, 2, a2, m2)):
        z = np.abs(meridian(field, d, side)[1])
        rise = np.sqrt(q**q / ((q + 1) ** (q + 1) * m * (1 - m) ** q)) if m > 1 / (q + 1) else 1
        assert z.max() == pytest.approx(a * rise, rel=1e-6)
        assert (z.max() > 1.0001 * a) == (m > 1 / (q + 1))


@pytest.mark.parametrize("m1", [0.23, 0.27])
@pytest.mark.parametrize("m2", [0.31, 0.36])
def test_where_a_dimple_begins(m1, m2):
    field = examples.stomatocyte(8, 1, m1, 1, m2)
    for side, m, least in ((1, m1, 1 / 4), (-1, m2, 1 / 3)):
        z = np.abs(meridian(field, 8, side)[1])
        assert (z.argmax() > 0) == (m > least)


CELLS = [
    *(pytest.param(examples.discocyte(d, b, h), d, b / 2, b / 2) for d, b, h in DISCOCYTES),
    *(pytest.param(examples.stomatocyte(d, a, m, b, n), d, a, b) for d, a, m, b, n in STOMATOCYTES),
]


@pytest.mark.parametrize(("field", "d", "above", "below"), CELLS)
def test_the_gradient_of_a_cell_is_as_long_as_its_docstring_says(field, d, above, below):
    angle = np.linspace(0, 6, 7)
    equator = d / 2 * np.stack((np.cos(angle), np.sin(angle), 0 * angle), axis=1)
    slopes = geometry.gradient_at(field, equator)
    np.testing.assert_allclose(np.linalg.norm(slopes, axis=1), 1, rtol=1e-5)
    np.testing.assert_allclose(slopes, equator / (d / 2), atol=1e-5)
    slopes = geometry.gradient_at(field, np.array([(0, 0, above), (0, 0, -below)]))
    expected = [(0, 0, d / (2 * above)), (0, 0, -d / (2 * below))]
    np.testing.assert_allclose(slopes, expected, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize(("field", "d", "above", "below"), CELLS)
def test_a_cell_is_negative_inside_round_and_without_a_jump(field, d, above, below):
    assert field(np.zeros(3)) == pytest.approx(-d / 4)
    p = points_in_space(23)
    far = np.linalg.norm(p, axis=1) > d
    assert (field(p[far]) > 0).all()
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([(c, -s, 0), (s, c, 0), (0, 0, 1)])
    np.testing.assert_allclose(field(p @ turn), field(p), rtol=1e-9, atol=1e-9)
    plane = p * (1, 1, 0)
    for step in (1e-4, 1e-6):
        jump = field(plane + (0, 0, step)) - field(plane - (0, 0, step))
        assert np.abs(jump).max() <= d / 4 * step**2 / min(above, below) ** 2
    if above == below:
        np.testing.assert_allclose(field(p * (1, 1, -1)), field(p), rtol=1e-12)


@pytest.mark.parametrize(("field", "d", "above", "below"), CELLS)
def test_a_cell_takes_any_leading_shape(field, d, above, below):
    p = points_in_space(24, count=12).reshape(3, 4, 3)
    copy = p.copy()
    assert field(p).shape == (3, 4)
    assert np.shape(field(p[0, 0])) == ()
    assert field(p[:0]).shape == (0, 4)
    np.testing.assert_array_equal(p, copy)


#: Volume and surface, from the meridians.
MEASURES = {"discocyte": (99.2, 135.9), "stomatocyte": (89.8, 138.8)}


@pytest.mark.parametrize("name", MEASURES)
def test_a_cell_has_its_volume_and_its_surface(name):
    """Pappus: 2 pi r z dr and 2 pi r ds, summed along the meridian."""
    field, d = (examples.discocyte(), 7.82) if name == "discocyte" else (examples.stomatocyte(), 8)
    volume = area = 0.0
    for side in (1, -1):
        r, z = meridian(field, d, side)
        ring = np.pi * (r[1:] + r[:-1])
        volume += (ring * np.abs(z[1:] + z[:-1]) / 2 * np.diff(r)).sum()
        area += (ring * np.hypot(np.diff(r), np.diff(z))).sum()
    assert volume == pytest.approx(MEASURES[name][0], abs=0.06)
    assert area == pytest.approx(MEASURES[name][1], abs=0.06)


@pytest.mark.parametrize("name", MEASURES)
def test_a_cell_is_meshed_well(name):
    """On the thesis's grid, with its h0; redistanced, where the thesis reinitializes."""
    grid = de.Grid(((-4.5, -4.5, -1.5), (4.5, 4.5, 1.5)), 0.1)
    field = getattr(examples, name)()
    fd = grid.interpolate(de.redistance(field(grid.points), grid.dx))
    mesh = de.generate_mesh(fd, None, 0.3, grid.bbox)
    assert mesh.converged
    assert mesh.euler_characteristic == 1
    assert mesh.quality.min() >= 0.2
    assert mesh.quality.mean() >= 0.88
    volume, area = MEASURES[name]
    assert mesh.volume == pytest.approx(volume, rel=0.01)
    a, b, c = np.moveaxis(mesh.p[mesh.boundary_facets], 1, 0)
    found = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert found == pytest.approx(area, rel=0.02)
    slope = np.linalg.norm(geometry.gradient_at(field, mesh.p[mesh.boundary_nodes]), axis=1)
    assert (np.abs(field(mesh.p[mesh.boundary_nodes])) / slope).max() < 0.03


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: examples.discocyte(0), "diameter must be one positive number; got 0"),
        (lambda: examples.discocyte(np.inf), "diameter must be finite"),
        (lambda: examples.discocyte(thinnest=-1), "thinnest must be one positive number; got -1"),
        (lambda: examples.discocyte(thickest=0), "thickest must be one positive number; got 0"),
        (lambda: examples.discocyte(thinnest=3), "thickest must be thinnest, 3, or more.*got 2.58"),
        (lambda: examples.discocyte(thickest=[1, 2]), "thickest must be one positive number"),
        (lambda: examples.stomatocyte(-8), "diameter must be one positive number; got -8"),
        (lambda: examples.stomatocyte(a1=0), "a1 must be one positive number; got 0"),
        (lambda: examples.stomatocyte(a2=np.nan), "a2 must be finite"),
        (lambda: examples.stomatocyte(m1=0), "m1 must be one positive number; got 0"),
        (lambda: examples.stomatocyte(m1=1), "m1 must be less than 1.*got 1"),
        (lambda: examples.stomatocyte(m2=1.5), "m2 must be less than 1.*got 1.5"),
        (lambda: examples.stomatocyte(m2=-0.1), "m2 must be one positive number; got -0.1"),
    ],
)
def test_bad_input_of_a_cell_is_named(make, words):
    with pytest.raises(ValueError, match=words):
        make()
