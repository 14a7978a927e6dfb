"""Pictures: what is drawn is what was asked for."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import distmesh_edu as de

MESH = de.Mesh([(0, 0), (2, 0), (2, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])


@pytest.fixture
def ax():
    return Figure().subplots()


def test_plot_mesh_draws_every_triangle_where_it_is(ax):
    triangles = de.plot_mesh(ax, MESH)
    assert triangles.get_gid() == "mesh"
    drawn = [path.vertices[:3] for path in triangles.get_paths()]
    np.testing.assert_allclose(drawn, MESH.p[MESH.t])
    assert ax.get_aspect() == 1
    assert ax.get_xlim()[0] <= 0 < 2 <= ax.get_xlim()[1]


def test_plot_mesh_names_a_mesh_that_did_not_come_to_rest(ax):
    assert de.plot_mesh(ax, de.Mesh(*MESH, converged=False)).get_gid() == "unsettled mesh"


def test_plot_mesh_by_quality_colours_by_the_radius_ratio(ax):
    triangles = de.plot_mesh(ax, MESH, by_quality=True)
    np.testing.assert_allclose(triangles.get_array(), MESH.quality)
    assert (triangles.norm.vmin, triangles.norm.vmax) == (0, 1)


def test_plot_quality_adds_up_to_all_triangles(ax):
    de.plot_quality(ax, MESH, bins=10)
    heights = [bar.get_height() for bar in ax.patches]
    assert len(heights) == 10
    assert sum(heights) == pytest.approx(100)


def test_plot_field_draws_the_zero_contour_where_it_is_and_does_not_transpose(ax):
    values = de.plot_field(ax, de.rectangle(((-1, -0.5), (1, 0.5))), ((-2, -1), (2, 1)))
    assert values.shape == (201, 101)
    zero = ax.collections[-1].get_paths()[0].vertices
    np.testing.assert_allclose(zero.max(axis=0), (1, 0.5), atol=1e-6)


def test_plot_field_takes_levels(ax):
    de.plot_field(ax, de.circle(), ((-2, -2), (2, 2)), levels=[-0.5, 0.5], nodes=50)
    assert list(ax.collections[0].levels) == [-0.5, 0.5]
