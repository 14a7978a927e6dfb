"""The checks of meshes and sizes: what is right passes, and each mistake gets its own sentence."""

import numpy as np
import pytest

import distmesh_edu as de
from distmesh_edu.checks import CheckFailed, expect_limited, expect_mesh

SQUARE = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float)
HALVES = np.array([(0, 1, 2), (0, 2, 3)])
WANTED = np.random.default_rng(3).uniform(0.1, 2, size=(12, 9))


def says(function, *args, **kwargs):
    """Return what a check says."""
    with pytest.raises(CheckFailed) as caught:
        function(*args, **kwargs)
    return str(caught.value)


def test_meshes_pass():
    expect_mesh(SQUARE, HALVES, euler=1, volume=1, quality=0.8)
    ring = de.difference(de.circle(), de.circle((0, 0), 0.4))
    mesh = de.generate_mesh(ring, None, 0.2, ((-1, -1), (1, 1)))
    expect_mesh(mesh.p, mesh.t, fd=ring, euler=0, volume=np.pi * 0.84, within=0.03)
    corner = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    expect_mesh(corner, [(0, 1, 2, 3)], euler=1, volume=1 / 6)


@pytest.mark.parametrize(
    ("p", "t", "sentence"),
    [
        (SQUARE, HALVES[:, ::-1], "Its corners run clockwise"),
        (SQUARE, HALVES[:1], "node 3 should be the corner of a simplex, but is an orphan"),
        (SQUARE, HALVES + 1, "Nodes are counted from 0"),
        (SQUARE, HALVES[[0, 1, 0, 0]], "Do simplices overlap, or stand there twice"),
        (SQUARE[:, :1], HALVES, "nodes of shape (n, dim)"),
        (SQUARE, HALVES[:0], "Which of them did you keep"),
        (SQUARE, [(0, 1, 1)], "flat"),
        (SQUARE[[0, 1, 2, 2]], [(0, 1, 2), (0, 1, 3)], "there twice"),
        (None, HALVES, "has no answer"),
    ],
)
def test_what_is_no_mesh_is_told_why(p, t, sentence):
    assert sentence in says(expect_mesh, p, t)


def test_a_mesh_of_another_region_is_told_why():
    assert "the Euler characteristic should be 0" in says(expect_mesh, SQUARE, HALVES, euler=0)
    assert "the mesh's area should be 2" in says(expect_mesh, SQUARE, HALVES, volume=2)
    assert "the quality should be 0.9" in says(expect_mesh, SQUARE, HALVES, quality=0.9)
    outside = de.half_plane((1, 0), (0.4, 0))
    said = says(expect_mesh, SQUARE, HALVES, fd=outside)
    assert "taken out" in said
    assert "simplex 0" in said  # its centroid is at 2/3, that of the other at 1/3


def limited(h, g, dx, sweeps=99):
    """Limit by sweeps along the axes: on one axis the exact answer."""
    h = h.copy()
    for _ in range(sweeps):
        for axis in range(h.ndim):
            a = np.moveaxis(h, axis, 0)
            for i in range(1, len(a)):
                a[i] = np.minimum(a[i], a[i - 1] + g * dx)
            for i in range(len(a) - 2, -1, -1):
                a[i] = np.minimum(a[i], a[i + 1] + g * dx)
    return h


def test_limited_sizes_pass():
    expect_limited(de.limit_gradient(WANTED, 0.3, 0.1), WANTED, 0.3, 0.1)
    expect_limited(limited(WANTED[0], 0.3, 0.1), WANTED[0], 0.3, 0.1)


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        (WANTED[0], "Look both ways"),
        (limited(WANTED[0], 0.2, 0.1), "It may be larger there"),
        (limited(WANTED[0], 0.3, 0.1) + 0.05, "never larger"),
        (np.minimum(WANTED[0], WANTED[0].min() + 0.031 * abs(np.arange(9))), "Look both ways"),
        (np.full(9, WANTED[0].min()), "It may be larger there"),
        (np.full(9, np.nan), "finite"),
        (WANTED[0, 1:], "shape"),
    ],
)
def test_sizes_that_are_not_the_largest_limited_ones_are_told_why(wrong, sentence):
    assert sentence in says(expect_limited, wrong, WANTED[0], 0.3, 0.1)


def test_sizes_limited_along_the_axes_alone_are_too_large_in_the_plane():
    along_axes = limited(WANTED, 0.3, 0.1)
    assert (along_axes > de.limit_gradient(WANTED, 0.3, 0.1) + 1e-3).any()
    assert "along a diagonal" in says(expect_limited, along_axes, WANTED, 0.3, 0.1)
