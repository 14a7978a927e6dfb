"""The mesh: what is measured on it, against cases that can be done by hand."""

import sys
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

import distmesh_edu as de
from distmesh_edu.mesh import (
    boundary_facets,
    mean_ratio,
    minimum_angle,
    oriented,
    radius_ratio,
    simplex_volumes,
    unique_edges,
)

SQUARE = np.array([(0.0, 0), (1, 0), (1, 1), (0, 1)])
# A ring of eight triangles between two squares: one hole.
RING_P = np.concatenate((3 * SQUARE - 1, SQUARE))
RING_T = np.array(
    [(k, (k + 1) % 4, 4 + k) for k in range(4)]
    + [((k + 1) % 4, 4 + (k + 1) % 4, 4 + k) for k in range(4)]
)
DIMENSIONS = pytest.mark.parametrize("dim", [1, 2, 3])

# The corner of a cube, and the simplex of equal edges: each with the origin as a corner.
RIGHT = {dim: np.concatenate((np.zeros((1, dim)), np.eye(dim))) for dim in (1, 2, 3)}
REGULAR = {
    1: np.array([(0.0,), (1,)]),
    2: np.array([(0, 0), (1, 0), (0.5, np.sqrt(3) / 2)]),
    3: np.array([(0.0, 0, 0), (1, 0, 1), (1, 1, 0), (0, 1, 1)]),
}


def one(p):
    """Return the simplex whose corners are the points, in their order."""
    p = np.asarray(p, dtype=float)
    return p, np.arange(len(p))[None]


def filled(inside, bbox, h):
    """Mesh a region by Delaunay triangulation of a shifted grid, less what lies outside."""
    grid = de.Grid(bbox, h).points
    p = grid.reshape(-1, grid.shape[-1])
    p = p + np.random.default_rng(0).uniform(-0.1 * h, 0.1 * h, p.shape)
    t = Delaunay(p).simplices
    mesh = de.Mesh(p, t[inside(p[t].mean(axis=1)) < 0])
    return de.Mesh(p, mesh.t[mesh.volumes > 0])


def disc(p):
    return np.hypot(p[:, 0], p[:, 1]) - 1


def annulus(p):
    return np.maximum(disc(p), 0.5 - np.hypot(p[:, 0], p[:, 1]))


def ball(p):
    return np.linalg.norm(p, axis=1) - 1


def shell(p):
    return np.abs(np.linalg.norm(p, axis=1) - 0.75) - 0.3


def ring_in_space(p):
    return np.hypot(np.hypot(p[:, 0], p[:, 1]) - 0.7, p[:, 2]) - 0.35


PLANE, SPACE = ((-1.2, -1.2), (1.2, 1.2)), ((-1.2, -1.2, -1.2), (1.2, 1.2, 1.2))
# All that Delaunay makes of points drawn from a ball: convex, so that its surface has no pinch.
BALL_P = np.random.default_rng(0).normal(size=(150, 3))
BALL_P *= np.tile([0.3, 0.6, 1, 1, 1], 30)[:, None] / np.linalg.norm(BALL_P, axis=1, keepdims=True)
BALL = de.Mesh(BALL_P, Delaunay(BALL_P).simplices)


def line(cells=4):
    return de.Mesh(
        np.linspace(0, 2, cells + 1)[:, None],
        np.stack((np.arange(cells), np.arange(cells) + 1), axis=1),
    )


# ---- what a mesh is ----


def test_it_unpacks_and_says_what_it_is():
    mesh = de.Mesh(SQUARE, [(0, 1, 2), (0, 2, 3)], converged=False, steps=7)
    p, t = mesh
    assert p is mesh.p
    assert t is mesh.t
    assert repr(mesh) == "Mesh(4 nodes, 2 triangles, not converged, 7 steps)"
    assert "1 tetrahedra" in repr(de.Mesh(*one(RIGHT[3])))
    assert "4 intervals" in repr(line())


@DIMENSIONS
def test_simplices_of_negative_volume_are_turned_round(dim):
    p, t = one(RIGHT[dim])
    mirrored = t[:, [*range(1, dim + 1), 0] if dim % 2 else [0, *range(dim, 0, -1)]]
    assert simplex_volumes(p, mirrored)[0] == -simplex_volumes(p, t)[0] < 0
    mesh = de.Mesh(p, np.concatenate((t, mirrored)))
    assert (mesh.orientation == 1).all()
    assert mesh.t[0].tolist() == t[0].tolist()  # one that stands right stays as it is
    assert sorted(mesh.t[1].tolist()) == sorted(t[0].tolist())


def test_the_first_two_corners_are_exchanged():
    p = np.array([(0.0, 0), (1, 0), (0, 1)])
    np.testing.assert_array_equal(
        oriented(p, np.array([(0, 2, 1), (1, 2, 0)])), [(2, 0, 1), (1, 2, 0)]
    )


@DIMENSIONS
def test_a_mesh_without_nodes_or_simplices(dim):
    for p in (np.empty((0, dim)), RIGHT[dim]):
        mesh = de.Mesh(p, [])
        assert mesh.t.shape == (0, dim + 1)
        assert mesh.dim == dim
        assert mesh.volume == 0
        assert mesh.edges.shape == (0, 2)
        assert mesh.edge_lengths.shape == (0,)
        assert mesh.boundary_facets.shape == (0, dim)
        assert mesh.quality.shape == mesh.mean_ratio.shape == (0,)
        assert mesh.euler_characteristic == 0
        assert mesh.orphans.tolist() == list(range(len(p)))
    assert de.Mesh([], []).dim == 2


@DIMENSIONS
def test_the_summary_has_what_was_measured(dim):
    mesh = {1: line(), 2: de.Mesh([*RING_P, (9, 9)], RING_T), 3: BALL}[dim]
    text = mesh.summary()
    lines = {words[:12].strip(): words[12:].split() for words in text.splitlines()[2:-1]}
    lengths = mesh.edge_lengths
    expected = [lengths.min(), lengths.mean(), lengths.max()]
    np.testing.assert_allclose([float(word) for word in lines["edge length"]], expected, rtol=1e-3)
    assert float(lines["radius ratio"][0]) == pytest.approx(mesh.quality.min(), rel=1e-3)
    assert float(lines["mean ratio"][1]) == pytest.approx(mesh.mean_ratio.mean(), rel=1e-3)
    assert ("least angle" in lines) == (dim > 1)
    assert f"{['length', 'area', 'volume'][dim - 1]} {mesh.volume:.6g}" in text
    assert f"orphans {len(mesh.orphans)}," in text
    assert text.endswith(f"Euler characteristic {mesh.euler_characteristic}")


def test_the_summary_of_nothing():
    assert de.Mesh([], []).summary() == "Mesh(0 nodes, 0 triangles, converged, 0 steps)"


# ---- volumes ----


@DIMENSIONS
def test_volume_of_the_corner_of_a_cube(dim):
    mesh = de.Mesh(*one(2 * RIGHT[dim]))
    assert mesh.volume == pytest.approx({1: 2, 2: 4 / 2, 3: 8 / 6}[dim])
    assert mesh.volumes.shape == (1,)


@DIMENSIONS
def test_volumes_are_determinants(dim):
    p = np.random.default_rng(0).random((12, dim))
    t = np.array(list(combinations(range(12), dim + 1)))
    edges = p[t[:, 1:]] - p[t[:, :1]]
    np.testing.assert_allclose(
        simplex_volumes(p, t), np.linalg.det(edges) / (1, 1, 2, 6)[dim], atol=1e-15
    )


def test_area_is_a_word_of_the_plane():
    mesh = de.Mesh(SQUARE, [(0, 1, 2), (0, 2, 3)])
    np.testing.assert_array_equal(mesh.areas, mesh.volumes)
    assert mesh.area == mesh.volume == 1
    with pytest.raises(AttributeError, match=r"tetrahedra has no area; \.volume .* its volume"):
        _ = de.Mesh(*one(RIGHT[3])).area
    with pytest.raises(AttributeError, match=r"intervals has no area; .* its length"):
        _ = line().areas


# ---- quality ----


@DIMENSIONS
def test_equal_edges_are_best_in_every_measure(dim):
    p, t = one(REGULAR[dim])
    assert radius_ratio(p, t)[0] == pytest.approx(1, rel=1e-14)
    assert mean_ratio(p, t)[0] == pytest.approx(1, rel=1e-14)
    if dim > 1:
        best = {2: 60, 3: np.degrees(np.arccos(1 / 3))}[dim]
        assert minimum_angle(p, t)[0] == pytest.approx(best, rel=1e-14)


def test_the_radius_ratio_of_triangles():
    p = np.array([(0.0, 0), (4, 0), (0, 3), (1, 0), (0, 1)])
    t = np.array([(0, 1, 2), (0, 3, 4)])
    right_isosceles = 2 * (2 - np.sqrt(2)) / 2 / (np.sqrt(2) / 2)
    np.testing.assert_allclose(radius_ratio(p, t), [2 * 1 / 2.5, right_isosceles])


def test_the_measures_of_the_corner_of_a_cube():
    p, t = one(RIGHT[3])
    r_in = 1 / (3 + np.sqrt(3))  # 3 V / surface
    r_circ = np.sqrt(3) / 2  # half the cube's diagonal
    assert radius_ratio(p, t)[0] == pytest.approx(3 * r_in / r_circ)
    assert mean_ratio(p, t)[0] == pytest.approx(12 * 0.5 ** (2 / 3) / (3 * 1 + 3 * 2))
    assert minimum_angle(p, t)[0] == pytest.approx(np.degrees(np.arctan(np.sqrt(2))))


def test_the_measures_of_the_half_of_a_square():
    p, t = one(RIGHT[2])
    assert mean_ratio(p, t)[0] == pytest.approx(np.sqrt(3) / 2)  # 4 sqrt(3) A / (1 + 1 + 2)
    assert minimum_angle(p, t)[0] == pytest.approx(45)


def test_an_interval_has_no_angle():
    with pytest.raises(ValueError, match="an interval has no angles"):
        _ = line().minimum_angle


def test_a_sliver_is_worst_where_its_angles_are():
    """Four points near a square's corners: no edge is short, and yet it is nearly flat."""
    height = 1e-3
    mesh = de.Mesh(*one([(0, 0, 0), (1, 0, height), (1, 1, 0), (0, 1, height)]))
    assert mesh.edge_lengths.min() > 0.9
    # At a side: between the faces to the other two corners, a height above the side and below.
    assert mesh.minimum_angle[0] == pytest.approx(np.degrees(2 * height), rel=1e-3)
    assert mesh.quality[0] < 4 * height


FLAT = {
    1: [np.zeros((2, 1))],
    2: [[(0, 0), (1, 0), (2, 0)], [(0, 0), (0.1, 0.3), (0.1, 0.3)], np.ones((3, 2))],
    3: [
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.2, 0.2, 0)],
        [(0, 0, 0), (1, 1, 1), (2, 2, 2), (0, 1, 0)],
        [(0, 0, 0), (1, 1, 1), (2, 2, 2), (5, 5, 5)],
        [(0, 0, 0), (0, 0, 0), (1, 0, 0), (0, 1, 0)],
        np.ones((4, 3)),
    ],
}


@pytest.mark.parametrize(
    ("dim", "points"), [(dim, points) for dim, flat in FLAT.items() for points in flat]
)
def test_a_flat_simplex_measures_zero(dim, points):
    mesh = de.Mesh(*one(points))
    assert mesh.volume == mesh.quality[0] == mesh.mean_ratio[0] == 0
    assert mesh.orientation[0] == 0
    if dim > 1:
        assert mesh.minimum_angle[0] == 0


coordinates = st.integers(-40, 40).map(lambda k: k / 8)  # so coarse that flat ones are drawn, too


@st.composite
def moved_simplices(draw):
    """Draw a simplex and its image: turned, enlarged, moved, and with its corners in any order."""
    dim = draw(st.sampled_from([1, 2, 3]))
    points = st.tuples(*[coordinates] * dim)
    p = np.array(draw(st.lists(points, min_size=dim + 1, max_size=dim + 1)))
    rng = np.random.default_rng(draw(st.integers(0, 99)))
    turn, _ = np.linalg.qr(rng.normal(size=(dim, dim)))
    image = draw(st.floats(1e-3, 1e3)) * p @ turn.T + rng.uniform(-3, 3, dim)
    return p, image[rng.permutation(dim + 1)]


@given(moved_simplices())
@settings(max_examples=200, deadline=None)
def test_quality_does_not_depend_on_place_size_direction_or_order(simplices):
    before, after = (one(p) for p in simplices)
    for measure in (radius_ratio, mean_ratio):
        assert -1e-12 <= measure(*before)[0] <= 1 + 1e-12
        assert measure(*after)[0] == pytest.approx(measure(*before)[0], abs=1e-6)
    if before[0].shape[1] > 1:
        best = {2: 60, 3: 70.53}[before[0].shape[1]]
        assert 0 <= minimum_angle(*before)[0] <= best
        assert minimum_angle(*after)[0] == pytest.approx(minimum_angle(*before)[0], abs=0.01)


@DIMENSIONS
def test_the_measures_are_what_their_definitions_say(dim):
    p = np.random.default_rng(0).random((12, dim))
    t = np.array(list(combinations(range(12), dim + 1)))
    edges = p[t[:, 1:]] - p[t[:, :1]]
    center = np.linalg.solve(2 * edges, (edges**2).sum(axis=2)[..., None])[..., 0]
    # The gradients of the barycentric coordinates: their lengths are one over the heights.
    gradients = np.linalg.inv(edges)
    gradients = np.concatenate((gradients, -gradients.sum(axis=2, keepdims=True)), axis=2)
    slopes = np.linalg.norm(gradients, axis=1)
    r_in, r_circ = 1 / slopes.sum(axis=1), np.linalg.norm(center, axis=1)
    np.testing.assert_allclose(radius_ratio(p, t), dim * r_in / r_circ, atol=1e-12)

    squares = [
        ((p[t[:, i]] - p[t[:, j]]) ** 2).sum(axis=1) for i, j in combinations(range(dim + 1), 2)
    ]
    ideal = simplex_volumes(*one(REGULAR[dim])) / np.linalg.norm(REGULAR[dim][1]) ** dim
    relative = np.abs(simplex_volumes(p, t)) / ideal
    np.testing.assert_allclose(mean_ratio(p, t), relative ** (2 / dim) / np.mean(squares, axis=0))

    if dim > 1:
        cosines = -np.einsum("mki,mkj->mij", gradients, gradients) / (
            slopes[:, :, None] * slopes[:, None, :]
        )
        widest = cosines.max(axis=(1, 2))
        np.testing.assert_allclose(minimum_angle(p, t), np.degrees(np.arccos(widest)), atol=1e-5)


# ---- edges ----


@DIMENSIONS
def test_edges_equal_a_set_of_pairs(dim):
    t = BALL.t[:, : dim + 1]
    pairs = {tuple(sorted(pair)) for row in t.tolist() for pair in combinations(row, 2)}
    assert [tuple(edge) for edge in unique_edges(t).tolist()] == sorted(pairs)


@pytest.mark.parametrize("kind", [np.uint8, np.int32, np.uint32, np.int64])
def test_edges_and_facets_of_every_type_of_integer(kind):
    t = np.array([(0, 1, 2), (2, 1, 3)], dtype=kind)
    edges = unique_edges(t)
    assert edges.tolist() == [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]]
    assert edges.dtype == np.int64
    assert boundary_facets(t).tolist() == [[0, 1], [2, 0], [1, 3], [3, 2]]


def test_the_numbers_of_nodes_may_be_large():
    """Three of them make a facet's number: 64 bits must hold it."""
    t = np.array([(0, 1, 2, 3), (0, 2, 1, 4)]) + 5_000_000
    assert len(unique_edges(t)) == 9
    assert len(boundary_facets(t)) == 6


def test_edge_lengths():
    lengths = np.sort(de.Mesh(SQUARE, [(0, 1, 2), (0, 2, 3)]).edge_lengths)
    np.testing.assert_allclose(lengths, [1, 1, 1, 1, np.sqrt(2)])
    lengths = np.sort(de.Mesh(*one(RIGHT[3])).edge_lengths)
    np.testing.assert_allclose(lengths, [1, 1, 1] + 3 * [np.sqrt(2)])
    np.testing.assert_allclose(line().edge_lengths, 0.5)


# ---- the boundary ----


def test_boundary_facets_have_the_region_on_their_left():
    ring = de.Mesh(RING_P, RING_T)
    assert ring.area == pytest.approx(9 - 1)
    assert len(ring.boundary_facets) == 8
    start, end = ring.p[ring.boundary_facets.T]
    twice_area = start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]
    assert twice_area.sum() / 2 == pytest.approx(ring.area)  # Green: right only if so oriented


@pytest.mark.parametrize("region", [ball, shell, ring_in_space])
def test_boundary_facets_in_space_enclose_the_volume(region):
    mesh = filled(region, SPACE, 0.3)
    a, b, c = mesh.p[mesh.boundary_facets.T]
    flux = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    assert flux.sum() == pytest.approx(mesh.volume)  # Gauss: right only if all normals look out


def test_each_facet_of_a_tetrahedron_looks_outward():
    p, t = one(RIGHT[3])
    faces = boundary_facets(t)
    assert len(faces) == 4
    a, b, c = p[faces.T]
    normals = np.cross(b - a, c - a)
    assert (np.einsum("ij,ij->i", normals, a - p.mean(axis=0)) > 0).all()


def test_the_surface_of_a_ball_is_closed():
    directed = BALL.boundary_facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    there, count = np.unique(directed, axis=0, return_counts=True)
    assert (count == 1).all()
    back = np.unique(directed[:, ::-1], axis=0)
    np.testing.assert_array_equal(there, back)  # each edge once in either direction


@DIMENSIONS
def test_boundary_simplices_have_the_facets(dim):
    mesh = {1: line(), 2: filled(annulus, PLANE, 0.2), 3: BALL}[dim]
    corners = mesh.t[mesh.boundary_simplices]
    assert len(corners) == len(mesh.boundary_facets)
    assert all(
        set(f) < set(s)
        for f, s in zip(mesh.boundary_facets.tolist(), corners.tolist(), strict=True)
    )


@DIMENSIONS
def test_boundary_facets_come_in_the_order_of_their_simplices(dim):
    mesh = {1: line(), 2: filled(annulus, PLANE, 0.2), 3: BALL}[dim]
    facets = [frozenset(facet) for row in mesh.t.tolist() for facet in combinations(row, dim)]
    alone = [k // (dim + 1) for k, facet in enumerate(facets) if facets.count(facet) == 1]
    assert mesh.boundary_simplices.tolist() == alone


def test_boundary_nodes():
    assert de.Mesh(RING_P, RING_T).boundary_nodes.tolist() == list(range(8))
    assert (
        sorted(line().boundary_facets.ravel().tolist()) == line().boundary_nodes.tolist() == [0, 4]
    )
    fan = de.Mesh([*SQUARE, (0.5, 0.5)], [(k, (k + 1) % 4, 4) for k in range(4)])
    assert fan.boundary_nodes.tolist() == [0, 1, 2, 3]


def test_orphans():
    mesh = de.Mesh([(9, 9), *SQUARE, (8, 8)], [(1, 2, 3), (1, 3, 4)])
    assert mesh.orphans.tolist() == [0, 5]
    assert mesh.euler_characteristic == 1  # they do not count
    assert de.Mesh(RING_P, RING_T).orphans.tolist() == []


@pytest.mark.parametrize(
    ("region", "bbox", "expected"),
    [
        (disc, PLANE, 1),
        (annulus, PLANE, 0),
        (lambda p: np.minimum(disc(2 * (p - 0.5)), disc(2 * (p + 0.6))), PLANE, 2),
        (ball, SPACE, 1),
        (ring_in_space, SPACE, 0),
        (shell, SPACE, 2),
    ],
    ids=["disc", "annulus", "two discs", "ball", "solid torus", "shell"],
)
def test_euler_characteristic(region, bbox, expected):
    mesh = filled(region, bbox, 0.15 if len(bbox[0]) == 2 else 0.2)
    assert mesh.euler_characteristic == expected


def test_euler_characteristic_where_nodes_are_numbered_at_random():
    assert BALL.euler_characteristic == 1
    assert len(BALL.boundary_nodes) - 0.5 * len(BALL.boundary_facets) == 2  # a sphere's own


def test_euler_characteristic_on_a_line():
    assert line().euler_characteristic == 1
    assert de.Mesh(line().p, line().t[[0, 1, 3]]).euler_characteristic == 2


# ---- files ----

MESHES = {1: line(), 2: de.Mesh(RING_P, RING_T), 3: BALL}
ENDINGS = pytest.mark.parametrize("ending", ["vtk", "vtu", "msh"])


@ENDINGS
@DIMENSIONS
def test_a_file_gives_back_what_was_written(tmp_path, capfd, dim, ending):
    path = tmp_path / f"mesh.{ending}"
    mesh = MESHES[dim]
    mesh.write(path)
    read = de.Mesh.read(str(path))
    np.testing.assert_array_equal(read.p, mesh.p)
    np.testing.assert_array_equal(read.t, mesh.t)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
    assert capfd.readouterr() == ("", "")


def test_other_programs_find_points_in_space(tmp_path):
    meshio = pytest.importorskip("meshio")
    MESHES[2].write(tmp_path / "mesh.vtu")
    content = meshio.read(tmp_path / "mesh.vtu")
    np.testing.assert_array_equal(content.points[:, 2], 0)
    assert [block.type for block in content.cells] == ["triangle"]


def write_cells(path, points, *cells):
    meshio = pytest.importorskip("meshio")
    meshio.vtu.write(path, meshio.Mesh(np.array(points, dtype=float), list(cells)))
    return path


def test_the_simplices_of_the_highest_dimension_are_read(tmp_path):
    """As Gmsh writes them: the boundary's edges too, and the triangles in several blocks."""
    cells = [
        ("vertex", [[0]]),
        ("line", [[0, 1]]),
        ("triangle", [[0, 1, 2]]),
        ("triangle", [[0, 2, 3]]),
    ]
    path = write_cells(tmp_path / "a.vtu", np.pad(SQUARE, ((0, 0), (0, 1))), *cells)
    assert de.Mesh.read(path).t.tolist() == [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        ([("vertex", [[0]])], "a.vtu holds no simplices"),
        ([("quad", [[0, 1, 2, 3]])], "a.vtu holds cells of the type quad"),
        ([("tetra", [[0, 1, 2, 3]]), ("quad", [[0, 1, 2, 3]])], "holds cells of the type quad"),
        ([("triangle", [[0, 1, 2]])], "made of triangles, 2 points lie off the plane z = 0"),
        ([("line", [[0, 1]])], "made of intervals, 3 points lie off the x axis"),
    ],
)
def test_a_file_of_something_else_is_refused(tmp_path, cells, words):
    path = write_cells(tmp_path / "a.vtu", [(0, 0, 0), (1, 0, 1), (0, 1, 0), (0, 0, 1)], *cells)
    with pytest.raises(ValueError, match=words):
        de.Mesh.read(path)


@ENDINGS
def test_a_file_that_is_broken_or_missing(tmp_path, capfd, ending):
    path = tmp_path / f"mesh.{ending}"
    with pytest.raises(FileNotFoundError):
        de.Mesh.read(path)
    MESHES[3].write(path)
    whole = path.read_bytes()
    for content in (b"", b"something else\n\n", whole[: len(whole) // 2]):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=rf"meshio cannot read mesh\.{ending}: \w"):
            de.Mesh.read(path)
    assert capfd.readouterr() == ("", "")


def test_other_endings_are_refused(tmp_path):
    for ask in (MESHES[2].write, de.Mesh.read):
        with pytest.raises(
            ValueError, match=r"must end in one of \.msh, \.vtk, \.vtu; got 'a\.stl'"
        ):
            ask(tmp_path / "a.stl")


def test_a_mesh_without_simplices_is_not_written(tmp_path):
    with pytest.raises(ValueError, match="the mesh has no triangles"):
        de.Mesh(SQUARE, []).write(tmp_path / "a.vtu")


def test_a_file_is_replaced_by_a_whole_one_only(tmp_path, monkeypatch):
    meshio = pytest.importorskip("meshio")
    path = tmp_path / "mesh.vtk"
    MESHES[2].write(path)
    before = path.read_bytes()

    def full(path, content):
        path.write_bytes(b"half of")
        raise OSError("no space left")

    monkeypatch.setattr(meshio.vtk, "write", full)
    with pytest.raises(OSError, match="no space left"):
        MESHES[3].write(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_without_meshio_one_learns_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "meshio", None)
    for ask in (MESHES[2].write, de.Mesh.read):
        with pytest.raises(ImportError, match=r"pip install 'distmesh-edu\[io\]'"):
            ask(tmp_path / "a.vtu")


# ---- bad input ----


@pytest.mark.parametrize(
    ("p", "t", "words"),
    [
        (SQUARE, [(0, 1, 4)], "t must name nodes 0 to 3; it holds 0 to 4"),
        (SQUARE, [(-1, 1, 2)], "it holds -1 to 2"),
        (SQUARE, [(0, 1)], "three node numbers a row"),
        (SQUARE, [(0, 1, 2, 3)], r"three node numbers a row, for p has the shape \(4, 2\)"),
        (SQUARE, [(0.5, 1, 2)], "three node numbers a row"),
        (SQUARE, [(0, 1, 2), (0, 1)], "three node numbers a row"),
        (SQUARE, [(0, 0, 1)], r"t names a node twice in \[0, 0, 1\]"),
        (np.zeros((4, 3)), [(0, 1, 2)], r"four node numbers a row, for p has the shape \(4, 3\)"),
        (np.zeros((4, 3)), [(0, 1, 2, 0)], r"t names a node twice in \[0, 1, 2, 0\]"),
        (np.zeros((4, 1)), [(0, 1, 2)], "two node numbers a row"),
        (np.zeros((4, 1)), [(1, 1)], r"t names a node twice in \[1, 1\]"),
        (np.zeros((4, 4)), [], r"p must have the shape \(n, 1\), \(n, 2\) or \(n, 3\), .*\(4, 4\)"),
        (np.zeros(4), [], r"p must have the shape .*; got \(4,\)"),
        ([(0, np.inf)], [], r"p\[0, 1\] is inf"),
    ],
)
def test_bad_input_is_named(p, t, words):
    with pytest.raises(ValueError, match=words):
        de.Mesh(p, t)


def test_points_that_are_no_numbers():
    with pytest.raises(TypeError, match="p must hold"):
        de.Mesh([("a", "b")], [])
