"""The regions that the benchmarks mesh, as plain data, and three starts for each of them.

Sizes are lengths, so that a generator of any kind can be asked for the same edges; the published
algorithm takes them relative to one another, and sees no difference.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import gamma, pi

import numpy as np

import distmesh_edu as de

#: How many starts each region has: seeds 0, 1 and 2.
STARTS = 3

#: How the names of those cases begin that take a plain program long.
SLOW = ("disc 0.02", "disc 0.01", "lake", "ball 0.1", "cylinder")


@dataclass(frozen=True)
class Case:
    """A region, the edges wanted in it, and what is known of the mesh beforehand."""

    name: str
    fd: Callable[[np.ndarray], np.ndarray]
    fh: Callable[[np.ndarray], np.ndarray] | None  # the wanted edge; None: h0 everywhere
    h0: float  # the smallest edge
    bbox: np.ndarray
    pfix: np.ndarray  # of shape (k, dim), often empty
    measure: float  # the exact area or volume
    euler: int  # its Euler characteristic
    rings: tuple[np.ndarray, ...] = ()  # its boundary: closed curves, by many points or corners

    @property
    def dim(self):
        """The dimension of its space."""
        return self.bbox.shape[1]

    @property
    def cap(self):
        """The steps allowed to a program that may not come to rest."""
        return 6000 if self.dim == 3 else 300 if self.name.startswith("lake") else 3000

    @property
    def slow(self):
        """Whether a plain program takes so long that one start must do."""
        return self.name.startswith(SLOW)

    def edge(self, p):
        """Return the wanted edge at each point, also where it is uniform."""
        return np.full(len(p), self.h0) if self.fh is None else self.fh(p)

    def box(self, seed):
        """Return the box: as published for seed 0, else lower by a random part of h0."""
        if seed == 0:
            return self.bbox
        offset = np.random.default_rng(seed).random(self.dim)
        return self.bbox + self.h0 * np.array([-offset, np.ones(self.dim)])

    def variant(self, seed):
        """Return the arguments fd, fh, h0, bbox, pfix; pass the same seed on as rng."""
        return self.fd, self.fh, self.h0, self.box(seed), self.pfix


def _case(name, fd, fh, h0, bbox, measure, euler, pfix=(), rings=()):
    bbox = np.array(bbox, dtype=float)
    fixed = np.array(pfix, dtype=float).reshape(-1, bbox.shape[1])
    return Case(name, fd, fh, h0, bbox, fixed, measure, euler, tuple(rings))


def _rim(a, b=None):
    """Return an ellipse with half axes a and b, or a circle, as a closed curve of many points."""
    angle = np.linspace(0, 2 * pi, 5000, endpoint=False)
    return np.stack((a * np.cos(angle), (b or a) * np.sin(angle)), axis=1)


def _away(h0, slope, *fields):
    """Return the size that grows with the distance from the nearest of some things."""
    return lambda p: h0 + slope * np.min([np.abs(d(p)) for d in fields], axis=0)


SQUARE = ((-1, -1), (1, 1))
CORNERS = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=float)
UNIT_CORNERS = (CORNERS + 1) / 2
# The polygon of the paper of Persson and Strang.
POLYGON = np.array(
    [
        *[(-0.4, -0.5), (0.4, -0.2), (0.4, -0.7), (1.5, -0.4), (0.9, 0.1)],
        *[(1.6, 0.8), (0.5, 0.5), (0.2, 1.0), (0.1, 0.4), (-0.7, 0.7)],
    ]
)


def _discs():
    for h0 in (0.1, 0.05, 0.02, 0.01):
        yield _case(f"disc {h0}", de.circle(), None, h0, SQUARE, pi, 1, rings=[_rim(1)])


def _annuli():
    fd = de.difference(de.circle(), de.circle(radius=0.4))
    for h0 in (0.1, 0.03):
        rings = [_rim(1), _rim(0.4)]
        yield _case(f"annulus {h0}", fd, None, h0, SQUARE, 0.84 * pi, 0, rings=rings)


def _squares_with_a_hole():
    hole = de.circle(radius=0.5)
    fd = de.difference(de.rectangle(SQUARE), hole)
    rings = [CORNERS, _rim(0.5)]
    for name, h0, slope in (("uniform", 0.05, 0), ("graded", 0.05, 0.3), ("graded", 0.02, 0.3)):
        fh = _away(h0, slope, hole) if slope else None
        title = f"square with hole, {name} {h0}"
        yield _case(title, fd, fh, h0, SQUARE, 4 - pi / 4, 0, CORNERS, rings)


def _superellipse(p):
    return (p[..., 0] ** 4 + p[..., 1] ** 4) ** 0.25 - 1


def _not_a_distance(p):
    return p[..., 0] ** 2 / 4 + p[..., 1] ** 2 - 1


def _single_ones():
    area, box = de.polygon_area(POLYGON), ((-1, -1), (2, 1))
    yield _case("polygon 0.1", de.polygon(POLYGON), None, 0.1, box, area, 1, POLYGON, [POLYGON])
    box, rings = ((-2, -1), (2, 1)), [_rim(2, 1)]
    yield _case("ellipse, its equation 0.2", _not_a_distance, None, 0.2, box, 2 * pi, 1, (), rings)
    yield _case("ellipse, its distance 0.2", de.ellipse(), None, 0.2, box, 2 * pi, 1, (), rings)
    area = 4 * gamma(5 / 4) ** 2 / gamma(3 / 2)
    angle = np.linspace(0, 2 * pi, 5000, endpoint=False)
    round_it = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    rings = [round_it / (_superellipse(round_it) + 1)[:, None]]
    yield _case("superellipse 0.1", _superellipse, None, 0.1, SQUARE, area, 1, (), rings)
    # As in the paper of Persson and Strang, with one size at the point and at the line.
    fh = _away(0.02, 0.3, de.segment((0, 0), (0, 0)), de.segment((0.3, 0.7), (0.7, 0.5)))
    unit = ((0, 0), (1, 1))
    corners = UNIT_CORNERS
    yield _case("point and line 0.02", de.rectangle(unit), fh, 0.02, unit, 1, 1, corners, [corners])


def _lakes():
    shore, *islands = de.examples.lake_superior_shores()
    fd = de.polygon(shore, islands)
    area, box = de.polygon_area(shore, islands), ((-310, -120), (276, 166))
    pieces = 1 - len(islands)
    rings = [shore, *islands]
    yield _case("lake, uniform 8 km", fd, None, 8.0, box, area, pieces, rings=rings)
    grid = de.Grid(box, 2)
    fh = grid.interpolate(3 + 0.2 * np.abs(fd(grid.points)), degree=1)
    yield _case("lake, 3 km at its shore", fd, fh, 3.0, box, area, pieces, rings=rings)


def _in_space():
    cube, ball = ((-1, -1, -1), (1, 1, 1)), 4 / 3 * pi
    for h0 in (0.2, 0.1):
        yield _case(f"ball {h0}", de.sphere(), None, h0, cube, ball, 1)
    hole = de.sphere(radius=0.5)

    def fh(p):
        return 0.1 * np.minimum(4 * np.linalg.norm(p, axis=-1) - 1, 2)

    fd = de.difference(de.cylinder(), hole)
    name = "cylinder with spherical hole 0.1"
    yield _case(name, fd, fh, 0.1, cube, 2 * pi - ball / 8, 2)


#: The cases in the plane that the totals are over; the lake, twice; those in space.
PLANE = (*_discs(), *_annuli(), *_squares_with_a_hole(), *_single_ones())
LAKES = tuple(_lakes())
SPACE = tuple(_in_space())
ALL = {case.name: case for case in (*PLANE, *LAKES, *SPACE)}
