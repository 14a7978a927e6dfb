"""Lake Superior: the packaged data, its map, and a mesh of it."""

import warnings

import numpy as np
import pytest

import distmesh_edu as de

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
