"""Pictures: what is drawn is what was asked for."""

import io

import numpy as np
import pytest
from matplotlib.colors import to_rgba_array
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.proj3d import proj_transform

import distmesh_edu as de
from distmesh_edu.plotting import OPENED, WATER

# Two cubes of five tetrahedra each, side by side along x.
CUBE = np.array([(x, y, z) for x in (0.0, 1) for y in (0, 1) for z in (0, 1)])
FIVE = np.array([(0, 3, 5, 6), (1, 0, 3, 5), (2, 0, 3, 6), (4, 0, 5, 6), (7, 3, 5, 6)])
CUBES = de.Mesh(
    np.concatenate((CUBE, CUBE * (-1, 1, 1) + (2, 0, 0))), np.concatenate((FIVE, FIVE + 8))
)
# The nodes between them belong to both.
CUBES = de.Mesh(CUBES.p, np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 4, 5, 6, 7])[CUBES.t])

MESH = de.Mesh([(0, 0), (2, 0), (2, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])


@pytest.fixture
def ax():
    return Figure().subplots()


@pytest.fixture
def space():
    return Figure().add_subplot(projection="3d")


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


def test_plot_mesh_takes_a_cut_in_the_plane(ax):
    drawn = de.plot_mesh(ax, MESH, cut=((0, 1), 0.5))
    np.testing.assert_allclose(drawn.get_paths()[0].vertices[:3], MESH.p[MESH.t[0]])
    assert len(drawn.get_paths()) == 1


def seen(space, points):
    """Return where the picture shows points in space."""
    x, y, _ = proj_transform(*np.transpose(points), space.get_proj())
    return np.stack((x, y), axis=1)


def shades(colours):
    """Return how many of the colours are shades of WATER, and how many of OPENED."""
    ratios = [colours[:, :3] / to_rgba_array(name)[0, :3] for name in (WATER, OPENED)]
    return [int((np.ptp(ratio, axis=1) < 1e-6).sum()) for ratio in ratios]


def test_plot_mesh_in_space_draws_the_surface_where_it_is(space):
    drawn = de.plot_mesh(space, CUBES)
    space.figure.savefig(io.BytesIO())
    paths = [path.vertices[:3].mean(axis=0) for path in drawn.get_paths()]
    faces = seen(space, CUBES.p[CUBES.boundary_facets].mean(axis=1))
    assert len(paths) == 2 * 10  # two triangles on each of ten squares
    np.testing.assert_allclose(np.sort(paths, axis=0), np.sort(faces, axis=0), atol=1e-3)
    assert shades(drawn.get_facecolor()) == [20, 0]


def test_plot_mesh_in_space_names_a_mesh_that_did_not_come_to_rest(space):
    assert de.plot_mesh(space, CUBES).get_gid() == "mesh"
    assert de.plot_mesh(space, de.Mesh(*CUBES, converged=False)).get_gid() == "unsettled mesh"


def test_light_in_space_comes_from_above(space):
    water = to_rgba_array(WATER)[0, 0]
    up, down = (
        de.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.2, 0.2, z)], [(0, 1, 2, 3)]) for z in (1, -1)
    )
    for mesh, level in ((up, "darkest"), (down, "brightest")):  # the face in the plane z = 0
        red = np.sort(de.plot_mesh(space, mesh).get_facecolor()[:, 0])
        if level == "brightest":
            assert red[-2] < red[-1] == pytest.approx(water)
        else:
            assert red[1] > red[0] > 0.5 * water


def test_a_cut_opens_the_mesh_and_leaves_the_view_alone(space):
    drawn = de.plot_mesh(space, CUBES, cut=((1, 0, 0), 1))
    assert shades(drawn.get_facecolor()) == [10, 2]  # one cube; the square it shared is laid open
    assert space.get_xlim()[0] <= 0 < 2 <= space.get_xlim()[1]
    limits = [space.get_xlim(), space.get_ylim(), space.get_zlim()]
    scales = np.ptp(limits, axis=1) / space.get_box_aspect()
    np.testing.assert_allclose(scales, scales[0])  # one scale on all axes
    other = de.plot_mesh(space, CUBES, cut=((-2, 0, 0), -2))
    assert shades(other.get_facecolor()) == [10, 2]
    space.figure.savefig(io.BytesIO())
    middles = [
        np.mean([path.vertices[:3].mean(axis=0) for path in half.get_paths()], axis=0)
        for half in (drawn, other)
    ]
    np.testing.assert_allclose(middles, seen(space, [(0.5, 0.5, 0.5), (1.5, 0.5, 0.5)]), atol=0.01)
    np.testing.assert_allclose([space.get_xlim(), space.get_ylim(), space.get_zlim()], limits)


@pytest.mark.parametrize("offset", [-5, 5])
def test_a_cut_may_leave_nothing_or_all(space, offset):
    drawn = de.plot_mesh(space, CUBES, cut=((1, 0, 0), offset), by_quality=True)
    space.figure.savefig(io.BytesIO())
    assert len(drawn.get_paths()) == (20 if offset > 0 else 0)


def test_centroids_in_the_plane_of_a_cut_go_whatever_rounding_does(ax):
    lowest = MESH.p[MESH.t].mean(axis=1)[:, 1].min()
    for offset in (lowest, np.nextafter(lowest, 1), lowest + 1e-12):
        assert de.plot_mesh(ax, MESH, cut=((0, 1), offset)).get_paths() == []
    assert len(de.plot_mesh(ax, MESH, cut=((0, 1), lowest + 1e-6)).get_paths()) == 1


def test_plot_mesh_in_space_by_quality_colours_by_the_tetrahedron_behind(space):
    stretched = de.Mesh(np.where(CUBES.p > 1, 4, CUBES.p), CUBES.t)  # the second cube alone
    behind = stretched.quality[5:]
    drawn = de.plot_mesh(space, stretched, by_quality=True, cut=((-1, 0, 0), -1.01))
    # Three faces of each tetrahedron at a corner are seen, and none of the one in the middle.
    np.testing.assert_allclose(np.sort(drawn.get_array()), np.sort(np.repeat(behind[1:], 3)))
    assert (drawn.norm.vmin, drawn.norm.vmax) == (0, 1)


def test_axes_and_mesh_must_have_the_same_dimension(ax, space):
    with pytest.raises(ValueError, match=r'ax must be in space .*projection="3d"'):
        de.plot_mesh(ax, CUBES)
    with pytest.raises(ValueError, match="ax must be flat"):
        de.plot_mesh(space, MESH)
    with pytest.raises(ValueError, match="triangles or tetrahedra to draw; it has intervals"):
        de.plot_mesh(ax, de.Mesh([(0,), (1,)], [(0, 1)]))


@pytest.mark.parametrize(
    ("cut", "error", "words"),
    [
        (0.5, TypeError, r"a normal and an offset, such as \(\(0, 1, 0\), 0.5\); got 0.5"),
        ((0, 1, 0), TypeError, "a normal and an offset"),
        (((0, 1), 0.5), ValueError, "a normal of 3 numbers, not all 0, and one offset"),
        (((0, 0, 0), 0.5), ValueError, "not all 0"),
        (((0, 1, 0), (0.5, 1)), ValueError, "one offset"),
        ((("x", "y", "z"), 0.5), TypeError, r"cut\[0\] must hold real numbers"),
        (((0, 1, 0), np.nan), ValueError, r"cut\[1\] is nan"),
    ],
)
def test_a_cut_that_is_no_plane(space, cut, error, words):
    with pytest.raises(error, match=words):
        de.plot_mesh(space, CUBES, cut=cut)


def test_plot_quality_adds_up_to_all_triangles(ax):
    de.plot_quality(ax, MESH, bins=10)
    heights = [bar.get_height() for bar in ax.patches]
    assert len(heights) == 10
    assert sum(heights) == pytest.approx(100)


def test_plot_quality_says_of_what(ax):
    for mesh, name in ((MESH, "triangles"), (CUBES, "tetrahedra")):
        de.plot_quality(ax, mesh)
        assert ax.get_ylabel() == f"{name} (%)"


def test_plot_field_draws_the_zero_contour_where_it_is_and_does_not_transpose(ax):
    values = de.plot_field(ax, de.rectangle(((-1, -0.5), (1, 0.5))), ((-2, -1), (2, 1)))
    assert values.shape == (201, 101)
    zero = ax.collections[-1].get_paths()[0].vertices
    np.testing.assert_allclose(zero.max(axis=0), (1, 0.5), atol=1e-6)


def test_plot_field_takes_levels(ax):
    de.plot_field(ax, de.circle(), ((-2, -2), (2, 2)), levels=[-0.5, 0.5], nodes=50)
    assert list(ax.collections[0].levels) == [-0.5, 0.5]
