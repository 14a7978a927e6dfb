"""Pictures: the exact pieces of a step, discs that no threshold finds, a lake and its meshes."""

import warnings
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import distmesh_edu as de
from distmesh_edu import geometry
from distmesh_edu.segmentation import _drawn, _expected, _light, _parted, _spread

SHAPES = [(60,), (24, 30), (9, 12, 10)]
DISCS = {1: (200,), 2: (80, 70), 3: (40, 36, 38)}
BOX = ((-315, -280), (285, 320))


def coordinates(shape):
    """Return the pixels' places, from -1 to 1 along each axis."""
    return np.meshgrid(*(np.linspace(-1, 1, n) for n in shape), indexing="ij")


def lit(shade, light=0.45, noise=0.07, seed=0):
    """Return the picture of a shade in a light that grows along the diagonal, and noise."""
    slope = sum(w * x for w, x in zip((0.8, 0.6, 0.5), coordinates(shade.shape), strict=False))
    return shade * (1 + light * slope) + noise * np.random.default_rng(seed).normal(
        size=shade.shape
    )


def disc(shape):
    """Return the signed distance in pixels to a disc, not quite in the middle of a picture."""
    places = np.meshgrid(*(np.arange(n) - n / 2 + 0.37 for n in shape), indexing="ij")
    return np.sqrt(sum(x**2 for x in places)) - 0.29 * min(shape)


def picture(shape, **changes):
    return lit(np.where(disc(shape) > 0, 0.8, 0.4), **changes)


def shore(phi, grid):
    """Return where phi, straight between neighbours, is zero on the grid's lines."""
    found = []
    for axis in range(phi.ndim):
        a, b = np.moveaxis(phi, axis, 0)[:-1], np.moveaxis(phi, axis, 0)[1:]
        places = np.moveaxis(grid.points, axis, 0)
        cross = (a < 0) != (b < 0)
        share = (a[cross] / (a[cross] - b[cross]))[:, None]
        found.append((1 - share) * places[:-1][cross] + share * places[1:][cross])
    return np.concatenate(found)


# The three pieces of a step.


@pytest.mark.parametrize("shape", SHAPES)
def test_a_cosine_decays_as_it_should(shape):
    """Of the lattice's Laplacian, cosines without a slope at the rim are the eigenvectors."""
    wave, rate = np.ones(shape), 0.0
    for k, n in enumerate(shape, start=2):
        at = (np.arange(n) + 0.5).reshape(
            [-1 if axis == k - 2 else 1 for axis in range(len(shape))]
        )
        wave, rate = wave * np.cos(np.pi * k * at / n), rate + 4 * np.sin(np.pi * k / n / 2) ** 2
    np.testing.assert_allclose(_spread(3 + wave, 0.7), 3 + np.exp(-0.7 * rate) * wave, atol=1e-13)


def test_spreading_is_the_heat_equation_between_pixels():
    flows = np.diff(np.eye(12), axis=0)  # from each pixel to the next; none across the rim
    phi = np.random.default_rng(1).normal(size=12)
    np.testing.assert_allclose(_spread(phi, 0.9), expm(-0.9 * flows.T @ flows) @ phi, atol=1e-13)


@pytest.mark.parametrize("shape", SHAPES)
def test_spreading_keeps_the_mean_and_the_bounds(shape):
    phi = np.random.default_rng(2).uniform(-1, 1, shape)
    for time in (1e-3, 1.0, 1e3):
        spread = _spread(phi, time)
        assert spread.mean() == pytest.approx(phi.mean(), abs=1e-14)
        assert phi.min() - 1e-14 <= spread.min() <= spread.max() <= phi.max() + 1e-14
        np.testing.assert_allclose(
            _spread(_spread(phi, time / 3), 2 * time / 3), spread, atol=1e-13
        )
    np.testing.assert_allclose(_spread(phi, 1e4), phi.mean(), atol=1e-12)


@pytest.mark.parametrize("time", [0.05, 1.0, 4.0])
def test_parting_solves_its_equation(time):
    start = np.linspace(-1.3, 1.3, 27)
    fine = solve_ivp(lambda t, y: y - y**3, (0, time), start, rtol=1e-11, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(_parted(start, time), fine, atol=1e-9)
    rest = np.array([-1.0, 0, 1])
    np.testing.assert_allclose(_parted(rest, time), rest, atol=1e-15)


def test_parting_for_ever_is_the_sign():
    phi = np.array([-0.9, -1e-3, 1e-3, 0.5])
    np.testing.assert_allclose(_parted(phi, 50.0), np.sign(phi), atol=1e-12)


def test_being_drawn_solves_its_equation():
    rng = np.random.default_rng(3)
    phi, dark, bright, gap = rng.uniform(-1, 1, 20), *rng.uniform(0.01, 2, (3, 20))
    pull = lambda t, y: ((1 - y) * dark - (1 + y) * bright) / np.mean(gap**2)  # noqa: E731
    fine = solve_ivp(pull, (0, 0.6), phi, rtol=1e-11, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(_drawn(phi, dark, bright, 0.6, gap), fine, atol=1e-9)
    target = (dark - bright) / (dark + bright)
    np.testing.assert_allclose(_drawn(phi, dark, bright, 1e5, gap), target, atol=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
def test_the_light_is_found_where_it_is_a_plane(shape):
    plane = 0.7 + sum(0.1 * k * x for k, x in enumerate(coordinates(shape), start=1))
    shade = np.random.default_rng(4).uniform(0.3, 0.9, shape)
    np.testing.assert_allclose(_light(plane * shade, shade), plane, atol=1e-12)
    np.testing.assert_allclose(_light(plane, np.ones(shape)), plane, atol=1e-12)


def test_the_light_is_the_nearest_plane():
    """What it leaves of the picture is perpendicular to every plane times the shade."""
    rng = np.random.default_rng(5)
    f, shade = rng.normal(size=(2, 20, 15))
    left = f - shade * _light(f, shade)
    for plane in (np.ones(f.shape), *coordinates(f.shape)):
        assert abs((left * shade * plane).sum()) < 1e-11


@pytest.mark.parametrize("shape", SHAPES)
def test_what_is_expected_of_a_clean_picture_is_the_picture(shape):
    land = np.random.default_rng(6).random(shape) > 0.4
    f = lit(np.where(land, 0.8, 0.4), noise=0)
    light = lit(np.ones(shape), noise=0)
    dark, bright, found = _expected(f, np.where(land, 1.0, -1.0), light)
    np.testing.assert_allclose(np.where(land, bright, dark), f, atol=1e-12)
    np.testing.assert_allclose(bright, 2 * dark, atol=1e-12)
    np.testing.assert_allclose(found, light, atol=1e-12)


def test_a_short_step_is_that_of_the_equation():
    """(phi(dt) - phi(0)) / dt is the right-hand side, up to an error of first order in dt."""
    f = picture((24, 20), noise=0.02)
    fidelity, width = 0.9, 1.7
    light = _light(f, np.ones_like(f))

    def error(dt):
        seen = []
        options = {"fidelity": fidelity, "width": width, "dt": dt}
        de.segment_picture(f, 1, callback=seen.append, **options)
        phi, after = seen
        c0, c1, _ = _expected(f, phi, light)
        padded = np.pad(phi, 1, mode="edge")
        shifts = [padded[2:, 1:-1], padded[:-2, 1:-1], padded[1:-1, 2:], padded[1:-1, :-2]]
        drawn = ((1 - phi) * (f - c0) ** 2 - (1 + phi) * (f - c1) ** 2) / np.mean((c1 - c0) ** 2)
        right = sum(shifts) - 4 * phi + (phi - phi**3) / width**2 + fidelity * drawn
        return np.abs((after - phi) / dt - right).max()

    assert error(1e-4) < 0.02
    assert error(1e-3) / error(1e-4) == pytest.approx(10, rel=0.1)


# Discs in uneven light.


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("dim", [1, 2, 3])
def test_a_disc_is_found_within_a_pixel(dim, seed):
    shape = DISCS[dim]
    grid = de.Grid(((0,) * dim, np.array(shape) - 1), 1)
    d = disc(shape)
    phi = de.segment_picture(picture(shape, seed=seed))
    far = np.abs(grid.interpolate(d, degree=1)(shore(phi, grid)))
    assert len(far) == pytest.approx(len(shore(d, grid)), rel=0.03)
    assert far.mean() < {1: 1, 2: 0.35, 3: 0.35}[dim]
    assert far.max() < 2
    assert ((phi < 0) != (d < 0)).mean() < 5e-3
    assert np.median(np.abs(phi[np.abs(d) > 5])) > 0.9


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_no_threshold_finds_it(dim):
    """The best of all is wrong at a twentieth of the pixels, and five times as often at least."""
    f, water = picture(DISCS[dim]).ravel(), disc(DISCS[dim]).ravel() < 0
    sides = water[np.argsort(f)]
    wrong = np.concatenate(([0], np.cumsum(~sides))) + sides.sum() - np.append(0, np.cumsum(sides))
    assert wrong[0] == water.sum()
    found = de.segment_picture(picture(DISCS[dim])).ravel() < 0
    assert wrong.min() > 0.05 * len(f)
    assert wrong.min() > 5 * (found != water).sum()


@pytest.mark.parametrize("factor", [1e-6, 3.0, 255.0, 1e9])
@pytest.mark.parametrize("dim", [1, 2, 3])
def test_the_unit_of_brightness_does_not_matter(dim, factor):
    f = picture(DISCS[dim])
    found = de.segment_picture(factor * f, 10)
    np.testing.assert_allclose(found, de.segment_picture(f, 10), atol=1e-11)


def test_whole_numbers_will_do():
    f = np.clip(255 * picture(DISCS[2]), 0, 255).astype(np.uint8)
    found, exact = (de.segment_picture(one) for one in (f, f.astype(float)))
    np.testing.assert_array_equal(found, exact)
    assert ((found < 0) != (disc(f.shape) < 0)).mean() < 5e-3


@pytest.mark.parametrize("dim", [2, 3])
def test_axes_may_be_exchanged(dim):
    f = picture(DISCS[dim])
    phi = de.segment_picture(f, 10)
    np.testing.assert_allclose(de.segment_picture(f.T, 10), phi.T, atol=1e-11)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_the_picture_may_be_reversed(dim):
    f = picture(DISCS[dim])
    phi = de.segment_picture(f, 10)
    for axis in range(dim):
        found = de.segment_picture(np.flip(f, axis), 10)
        np.testing.assert_allclose(found, np.flip(phi, axis), atol=1e-11)


@pytest.mark.parametrize("shift", [-0.3, 0.1, 5.0])
def test_in_even_light_all_may_be_brighter(shift):
    """The model multiplies, so that this is not exact; but no pixel changes sides."""
    f = picture(DISCS[2], light=0)
    np.testing.assert_array_equal(de.segment_picture(f + shift) < 0, de.segment_picture(f) < 0)


def test_some_thirty_steps_are_enough():
    f = picture(DISCS[2])
    fields = []
    de.segment_picture(f, 80, callback=fields.append)
    assert np.abs(fields[80] - fields[30]).max() < 0.02
    assert np.abs(fields[30] - fields[3]).max() > 0.1


@pytest.mark.parametrize(
    "change", [{"dt": 1e-3}, {"dt": 100}, {"width": 0.1}, {"width": 30}, {"fidelity": 100}]
)
def test_the_field_stays_between_the_phases(change):
    """With any positive numbers: each of the three pieces keeps it there."""
    fields = []
    de.segment_picture(picture(DISCS[2]), 5, callback=fields.append, **change)
    assert max(np.abs(phi).max() for phi in fields) <= 1 + 1e-12


def test_small_fidelity_loses_islands_and_large_keeps_specks():
    land = np.zeros((60, 60), dtype=bool)
    land[:20] = land[40:44, 30:34] = True
    land[50:] = True
    f = lit(np.where(land, 0.8, 0.4), light=0, noise=0.15)
    weak, usual, strong = (de.segment_picture(f, fidelity=x) > 0 for x in (0.1, 0.7, 20))
    assert not weak[38:46, 28:36].any()
    assert usual[40:44, 30:34].mean() > 0.5
    assert (strong != land).sum() > 5 * (usual != land).sum()


def test_a_wider_layer_is_wider():
    f = lit(np.where(np.abs(coordinates((120,))[0]) > 0.5, 0.8, 0.4), light=0, noise=0)
    layers = [(np.abs(de.segment_picture(f, width=w)) < 0.95).sum() for w in (0.5, 1, 2)]
    assert layers[0] < layers[1] < layers[2]


# The callback.


def test_the_callback_sees_the_start_and_every_step_and_spoils_nothing():
    f = picture(DISCS[2])
    before, seen = f.copy(), []

    def spoil(phi):
        seen.append(phi.copy())
        phi[:] = np.nan

    phi = de.segment_picture(f, 7, callback=spoil)
    np.testing.assert_array_equal(f, before)
    np.testing.assert_array_equal(phi, de.segment_picture(f, 7))
    assert len(seen) == 8
    np.testing.assert_array_equal(seen[-1], phi)
    for steps in (1, 4):
        np.testing.assert_array_equal(seen[steps], de.segment_picture(f, steps))


# Bad input.


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"picture": np.full((9, 9), 0.3)}, ValueError, "picture must have two shades; it is 0.3"),
        ({"picture": np.array([[0, 1], [np.nan, 1]])}, ValueError, "picture must be finite"),
        ({"picture": np.array([[0, 1], [np.inf, 1]])}, ValueError, "picture must be finite"),
        ({"picture": np.array([["a", "b"]])}, TypeError, "picture must hold real numbers"),
        ({"picture": np.eye(9) * 1j}, TypeError, "picture must hold real numbers"),
        ({"picture": np.eye(9) > 0}, TypeError, "picture must hold real numbers"),
        ({"picture": np.empty((0, 0))}, ValueError, "picture must have 3 nodes at least"),
        ({"picture": []}, ValueError, "picture must have 3 nodes at least"),
        ({"picture": np.ones((1, 9))}, ValueError, "picture must have 3 nodes at least"),
        ({"picture": 1.0}, ValueError, "picture must be an array of values"),
        ({"picture": np.zeros((3, 3, 3, 3))}, ValueError, "picture must be an array of values"),
        ({"steps": 0}, ValueError, "steps must be 1 at least; got 0"),
        ({"steps": 2.5}, TypeError, "steps must be a whole number; got 2.5"),
        ({"fidelity": 0}, ValueError, "fidelity must be one positive number; got 0"),
        ({"fidelity": np.nan}, ValueError, "fidelity must be finite"),
        ({"width": -1}, ValueError, "width must be one positive number; got -1"),
        ({"width": "wide"}, TypeError, "width must hold real numbers"),
        ({"dt": 0}, ValueError, "dt must be one positive number; got 0"),
        ({"dt": [1, 1]}, ValueError, "dt must be one positive number"),
    ],
)
def test_bad_input_is_named(change, error, words):
    with pytest.raises(error, match=words):
        de.segment_picture(**({"picture": picture((20, 20)), "steps": 2} | change))


@pytest.mark.parametrize(("name", "options"), [("pixel", {}), ("speck", {"fidelity": 0.01})])
def test_a_picture_of_one_phase_is_refused(name, options):
    """A dead pixel, a speck that too little fidelity washes away."""
    speck = np.hypot(*np.meshgrid(np.arange(40) - 19.5, np.arange(40) - 19.5)) < 1.5
    pictures = {
        "pixel": np.where(np.arange(1600).reshape(40, 40) == 820, 0.0, 1.0),
        "speck": np.where(speck, 0.6, 1.0),
    }
    with pytest.raises(ValueError, match=r"picture falls into one phase.*Raise fidelity"):
        de.segment_picture(pictures[name], **options)


COASTS = {
    "straight": lambda x, y: x > 0,
    "aside": lambda x, y: x > 0.34,
    "wavy": lambda x, y: x > 0.3 * np.sin(5 * y),
    "corner": lambda x, y: (x > 0.2) & (y > 0.1),
}


@pytest.mark.parametrize("light", [0, 0.45])
@pytest.mark.parametrize("coast", COASTS)
def test_a_coast_from_rim_to_rim_is_found(coast, light):
    """In even light and without noise any threshold finds it; 38 per cent were wrong."""
    land = COASTS[coast](*coordinates((100, 100)))
    phi = de.segment_picture(lit(np.where(land, 0.8, 0.4), light=light, noise=0.01))
    assert ((phi > 0) != land).mean() < 0.01


@pytest.mark.parametrize(
    "f", [np.zeros((9, 9)), np.array([0.0, 1.0]), np.eye(2), np.add.outer(range(40), range(30)) / 9]
)
def test_a_picture_of_nothing_but_light_is_refused(f):
    with pytest.raises(ValueError, match="picture"):
        de.segment_picture(f)


def test_a_picture_whose_mean_was_taken_off_is_segmented_or_refused():
    f = picture(DISCS[2])
    try:
        phi = de.segment_picture(f - f.mean())
    except ValueError as error:
        assert "picture" in str(error)  # noqa: PT017
    else:
        assert ((phi < 0) != (disc(f.shape) < 0)).mean() < 0.05


# Lake Superior.


@cache
def lake():
    """Return its distance, the grid of its picture, and that distance there."""
    fd, grid = de.examples.lake_superior(), de.Grid(BOX, 600 / 511)
    return fd, grid, fd(grid.points)


@cache
def island_pixels():
    _, *islands = de.examples.lake_superior_shores()
    return [de.polygon(island)(lake()[1].points) < 0 for island in islands]


@cache
def lake_found(seed=0):
    _, grid, d = lake()
    return de.segment_picture(de.examples.photograph(lambda p: d, grid, rng=seed))


@pytest.mark.parametrize("seed", range(3))
def test_the_shore_of_lake_superior_is_found(seed):
    """Within a pixel on average, and with every island of more than 30 pixels."""
    (fd, grid, _), phi = lake(), lake_found(seed)
    rim, *islands = de.examples.lake_superior_shores()
    far = np.abs(fd(shore(phi, grid))) / grid.dx[0]
    assert far.mean() < 0.35  # 0.29 was measured
    assert far.max() < 4
    for island in island_pixels():
        pixels = phi[island]
        assert (pixels > 0).any() or len(pixels) <= 30
        assert (pixels > 0).mean() > 0.8 or len(pixels) <= 100
    exact = de.polygon_area(rim, islands)
    assert geometry.volume(phi, grid.dx) == pytest.approx(exact, rel=0.01)


@cache
def lake_distance():
    _, grid, _ = lake()
    return grid.interpolate(de.redistance(lake_found(), grid.dx))


@pytest.mark.parametrize("h0", [8, 6, 3])
def test_the_lake_of_the_picture_is_meshed_well(h0):
    """With edges of one size, and with sizes from 3 to 20 km."""
    fd, grid = lake_distance(), lake()[1]
    fh = de.size_function(fd, grid, 3, 20, g=0.2) if h0 == 3 else None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", de.ResolutionWarning)  # inlets, and islands of few pixels
        mesh = de.generate_mesh(fd, fh, h0, BOX)
    assert mesh.converged
    assert mesh.quality.min() >= 0.4
    assert mesh.quality.mean() >= 0.93
    assert len(mesh.orphans) == 0
    assert mesh.volume == pytest.approx(geometry.volume(lake_found(), grid.dx), rel=0.01)
    near = np.linalg.norm(de.unresolved(mesh, fd)[:, None] - mesh.p, axis=2).min(axis=1)
    assert near.max() < 4 * h0
