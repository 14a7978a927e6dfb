"""The mesh: what is measured on it, against cases that can be done by hand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

import distmesh_edu as de
from distmesh_edu.mesh import radius_ratio, unique_edges

SQUARE = np.array([(0.0, 0), (1, 0), (1, 1), (0, 1)])
# A ring of eight triangles between two squares: one hole.
RING_P = np.concatenate((3 * SQUARE - 1, SQUARE))
RING_T = np.array(
    [(k, (k + 1) % 4, 4 + k) for k in range(4)]
    + [((k + 1) % 4, 4 + (k + 1) % 4, 4 + k) for k in range(4)]
)


def test_it_unpacks_and_says_what_it_is():
    mesh = de.Mesh(SQUARE, [(0, 1, 2), (0, 2, 3)], converged=False, steps=7)
    p, t = mesh
    assert p is mesh.p
    assert t is mesh.t
    assert repr(mesh) == "Mesh(4 nodes, 2 triangles, not converged, 7 steps)"


def test_clockwise_triangles_are_turned_round():
    mesh = de.Mesh(SQUARE, [(0, 2, 1), (0, 2, 3)])
    assert (mesh.orientation == 1).all()
    assert set(map(frozenset, mesh.t.tolist())) == {frozenset((0, 1, 2)), frozenset((0, 2, 3))}


def test_a_flat_triangle_has_quality_and_orientation_zero():
    mesh = de.Mesh([(0, 0), (1, 0), (2, 0), (0, 0), (0, 0)], [(0, 1, 2), (0, 3, 4)])
    np.testing.assert_array_equal(mesh.quality, [0, 0])
    np.testing.assert_array_equal(mesh.orientation, [0, 0])


def test_quality_is_twice_the_inradius_over_the_circumradius():
    p = np.array([(0.0, 0), (1, 0), (0.5, np.sqrt(3) / 2), (4, 0), (0, 3), (0, 1)])
    t = np.array([(0, 1, 2), (0, 3, 4), (0, 1, 5)])
    right_isosceles = 2 * (2 - np.sqrt(2)) / 2 / (np.sqrt(2) / 2)
    np.testing.assert_allclose(radius_ratio(p, t), [1, 2 * 1 / 2.5, right_isosceles])


@given(
    points=st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), min_size=3, max_size=3),
    angle=st.floats(0, 6),
    scale=st.floats(1e-3, 1e3),
)
@settings(max_examples=100, deadline=None)
def test_quality_does_not_depend_on_place_size_or_direction(points, angle, scale):
    p, t = np.array(points), np.array([[0, 1, 2]])
    turn = np.array([(np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))])
    q = radius_ratio(p, t)[0]
    assert 0 <= q <= 1 + 1e-12
    assert radius_ratio(scale * p @ turn.T + (3, 4), t)[0] == pytest.approx(q, abs=1e-6)


def test_ring_of_triangles():
    ring = de.Mesh(RING_P, RING_T)
    assert ring.area == pytest.approx(9 - 1)
    assert ring.euler_characteristic == 0
    assert len(ring.edges) == 16
    assert len(ring.boundary_facets) == 8


def test_euler_characteristic_ignores_nodes_out_of_use():
    assert de.Mesh([*SQUARE, (9, 9)], [(0, 1, 2), (0, 2, 3)]).euler_characteristic == 1


def test_boundary_facets_have_the_region_on_their_left():
    ring = de.Mesh(RING_P, RING_T)
    start, end = ring.p[ring.boundary_facets[:, 0]], ring.p[ring.boundary_facets[:, 1]]
    twice_area = start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]
    assert twice_area.sum() / 2 == pytest.approx(ring.area)  # Green: right only if so oriented


def test_edges_equal_a_set_of_pairs():
    t = Delaunay(np.random.default_rng(0).random((200, 2))).simplices
    pairs = {
        tuple(sorted(pair))
        for row in t.tolist()
        for pair in zip(row, row[1:] + row[:1], strict=True)
    }
    assert [tuple(edge) for edge in unique_edges(t.astype(np.int64)).tolist()] == sorted(pairs)


@pytest.mark.parametrize("kind", [np.uint8, np.int32, np.uint32, np.int64])
def test_edges_of_every_type_of_integer(kind):
    t = np.array([(0, 1, 2), (2, 1, 3)], dtype=kind)
    assert unique_edges(t).tolist() == [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]]


def test_edge_lengths():
    np.testing.assert_allclose(
        np.sort(de.Mesh(SQUARE, [(0, 1, 2), (0, 2, 3)]).edge_lengths), [1, 1, 1, 1, np.sqrt(2)]
    )


@pytest.mark.parametrize(
    ("p", "t", "words"),
    [
        (SQUARE, [(0, 1, 4)], "t must name nodes 0 to 3; it holds 0 to 4"),
        (SQUARE, [(-1, 1, 2)], "it holds -1 to 2"),
        (SQUARE, [(0, 1)], "three node numbers a row"),
        (SQUARE, [(0.5, 1, 2)], "three node numbers a row"),
        ([(0, 0, 0)], [], r"p must have the shape \(n, 2\)"),
        ([(0, np.inf)], [], r"p\[0, 1\] is inf"),
        (SQUARE, [(0, 1, 2), (0, 1)], "three node numbers a row"),
        (SQUARE, [(0, 0, 1)], r"t names a node twice in \[0, 0, 1\]"),
    ],
)
def test_bad_input_is_named(p, t, words):
    with pytest.raises(ValueError, match=words):
        de.Mesh(p, t)
