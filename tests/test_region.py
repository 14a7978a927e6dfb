"""What is to be meshed: the sizes, the fields and the box, checked before anything is built."""

import numpy as np
import pytest
from regions import ball, cube

import distmesh_edu as de
from distmesh_edu.region import LATTICE_LIMIT, as_region


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_the_arguments_become_arrays(dim):
    fd = ball(dim)
    region = as_region(fd, None, 1, [[-1] * dim, [1] * dim], [[0] * dim], dim, 0.1)
    assert region.fd is fd
    assert region.h0 == 1.0
    assert region.geps == 0.1
    np.testing.assert_array_equal(region.bbox, cube(dim))
    assert region.pfix.dtype == region.bbox.dtype == np.float64
    assert as_region(fd, None, 1, cube(dim), None, dim).pfix.shape == (0, dim)
    assert as_region(fd, None, 1, cube(dim), [], dim).pfix.shape == (0, dim)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_inside_is_inside_or_nearly_so_and_not_on_a_fixed_point(dim):
    step = np.eye(dim)[0]
    region = as_region(ball(dim), None, 0.5, cube(dim), [0.5 * step], dim, 0.1)
    distances = np.array([0, 0.3, 0.5, 0.5 + 4e-7, 0.5 + 6e-7, 1, 1.049, 1.051, 2])
    kept = region.inside(distances[:, None] * step)
    assert kept.tolist() == [True, True, False, False, True, True, True, False, False]


@pytest.mark.parametrize("scale", [0.1, 1, 7])
@pytest.mark.parametrize("dim", [1, 2, 3])
def test_the_slope_is_that_at_the_zeros(dim, scale):
    region = as_region(lambda p: scale * ((p**2).sum(-1) - 1), None, 0.1, cube(dim), None, dim)
    p = np.random.default_rng(0).uniform(-1, 1, size=(3000, dim))
    assert region.slope(p) == pytest.approx(2 * scale, rel=0.15)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_no_size_function_is_one_everywhere(dim):
    p = np.random.default_rng(0).normal(size=(7, dim))
    np.testing.assert_array_equal(as_region(ball(dim), None, 1, cube(dim), None, dim).size(p), 1)
    linear = as_region(ball(dim), lambda p: 5 + p[..., 0], 1, cube(dim), None, dim)
    np.testing.assert_array_equal(linear.size(p), 5 + p[:, 0])


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_the_box_may_cut_less_than_half_an_edge_off(dim):
    """Lattices end within a step of the box; the truss grows into what is left."""
    box = cube(dim)
    box[:, 0] = -1.1, 0.76
    as_region(ball(dim), None, 0.5, box, None, dim)
    box[1, 0] = 0.74
    with pytest.raises(ValueError, match=r"bbox cuts the region: fd is -0.26 at \[0.74.*Widen"):
        as_region(ball(dim), None, 0.5, box, None, dim)


@pytest.mark.parametrize("dim", [1, 2, 3])
@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_box_is_checked_on_all_its_sides(dim, axis, side):
    if axis < dim:
        box = cube(dim)
        box[side, axis] *= 0.5
        with pytest.raises(ValueError, match="bbox cuts the region"):
            as_region(ball(dim), None, 0.3, box, None, dim)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_a_lattice_that_no_memory_holds_is_refused(dim):
    h0 = 2 / (LATTICE_LIMIT * 1.02) ** (1 / dim)
    with pytest.raises(ValueError, match=r"would fill the box with 5.1e.07 points, more than"):
        as_region(ball(dim), None, h0, cube(dim), None, dim)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_fixed_points_may_be_a_little_outside_and_close_but_not_one(dim):
    step = np.eye(dim)[0]
    good = as_region(ball(dim), None, 0.5, cube(dim), [1.09 * step, step, 0.99 * step], dim)
    assert len(good.pfix) == 3
    with pytest.raises(ValueError, match=r"pfix must lie in the region.* 0.11 outside"):
        as_region(ball(dim), None, 0.5, cube(dim), [0 * step, 1.11 * step], dim)
    with pytest.raises(ValueError, match="twice, in rows 1 and 2"):
        as_region(ball(dim), None, 0.5, cube(dim), [0 * step, step, step * (1 - 1e-7)], dim)


def test_nothing_can_be_changed():
    region = as_region(de.circle(), None, 0.5, cube(2), None, 2)
    with pytest.raises(AttributeError):
        region.h0 = 1.0
    given = []

    def fd(p):
        given.append(p)
        return de.circle()(p)

    as_region(fd, None, 0.5, cube(2), None, 2).distance(np.zeros((3, 2)))
    assert not any(p.flags.writeable for p in given)


def test_too_few_points_inside_are_no_region():
    region = as_region(de.circle(), None, 0.5, cube(2), [(0, 0)], 2)
    assert region.inside(np.array([(0.1, 0.1), (0.2, 0)])).all()
    with pytest.raises(ValueError, match=r"leaves 1 points inside .* thinner than h0"):
        region.inside(np.array([(0.1, 0.1), (2, 0)]))


def test_what_is_far_beyond_the_box_is_not_inside():
    """An interpolated distance may say anything there."""
    two = lambda p: np.minimum(ball(2)(p), np.linalg.norm(p - 3, axis=-1) - 0.5)  # noqa: E731
    region = as_region(two, None, 0.5, cube(2, 1.1), None, 2)
    p = np.array([[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [-0.5, 0.0], [3.0, 3.0]])
    assert region.inside(p).tolist() == [True, True, True, True, False]
