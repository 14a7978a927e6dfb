"""Ghost values: what each padding function puts beyond the last nodes."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from distmesh_edu import extrapolated, neumann, periodic

BOUNDARIES = pytest.mark.parametrize("boundary", [periodic, neumann, extrapolated])

values = arrays(
    np.float64,
    array_shapes(min_dims=1, max_dims=3, min_side=2, max_side=5),
    elements=st.floats(-100, 100, allow_subnormal=False),
)


def continue_the_line(line, widths, axis, options):
    """Fill the ghosts of one line for `np.pad`, which asks a function for what it cannot do."""
    before, after = widths
    inner = line[before : len(line) - after]
    line[:before] = inner[0] - np.arange(before, 0, -1) * (inner[1] - inner[0])
    line[len(line) - after :] = inner[-1] + np.arange(1, after + 1) * (inner[-1] - inner[-2])


PADS = {periodic: "wrap", neumann: "edge", extrapolated: continue_the_line}


@BOUNDARIES
@given(phi=values, width=st.integers(0, 12), data=st.data())
def test_padding_agrees_with_numpys(boundary, phi, width, data):
    """Up to widths that go more than twice round a periodic axis of five nodes."""
    axis = data.draw(st.integers(0, phi.ndim - 1))
    widths = [(width, width) if k == axis else (0, 0) for k in range(phi.ndim)]
    before = phi.copy()
    padded = boundary(phi, width, axis)
    np.testing.assert_allclose(padded, np.pad(phi, widths, PADS[boundary]), rtol=0, atol=1e-10)
    np.testing.assert_array_equal(phi, before)
    assert not np.shares_memory(padded, phi)


@BOUNDARIES
@pytest.mark.parametrize("dim", [2, 3])
def test_the_order_of_the_axes_does_not_matter(boundary, dim):
    """The corners' ghosts are the same whichever axis was padded first."""
    phi = np.random.default_rng(0).integers(-50, 50, (4, 5, 6)[:dim]).astype(float)
    there, back = phi, phi
    for axis in range(dim):
        there = boundary(there, 3, axis)
        back = boundary(back, 3, dim - 1 - axis)
    np.testing.assert_array_equal(there, back)


@pytest.mark.parametrize(("dim", "width"), [*product([1, 2, 3], [1, 2, 5])])
def test_a_plane_goes_on_as_it_came(dim, width):
    def plane(shape, start):
        nodes = np.moveaxis(np.indices(shape), 0, -1) + start
        return 3.0 - nodes @ np.array([2, -5, 7])[:dim]

    padded = plane((4,) * dim, 0)
    for axis in range(dim):
        padded = extrapolated(padded, width, axis)
    np.testing.assert_array_equal(padded, plane((4 + 2 * width,) * dim, -width))


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_periodic_padding_moves_with_the_data(dim):
    """A grid without ends: where the numbering starts makes no difference."""
    phi = np.random.default_rng(1).normal(size=(6, 5, 4)[:dim])
    for axis in range(dim):
        turned = periodic(np.roll(phi, 2, axis), 3, axis)
        longer = periodic(phi, 5, axis)
        kept = np.arange(turned.shape[axis])
        np.testing.assert_array_equal(turned, longer.take(kept, axis))


def test_a_line_takes_two_nodes():
    with pytest.raises(ValueError, match=r"phi must have 2 nodes at least along axis 1.*\(3, 1\)"):
        extrapolated(np.ones((3, 1)), 1, 1)
    np.testing.assert_array_equal(neumann(np.ones((3, 1)), 1, 1), np.ones((3, 3)))
    np.testing.assert_array_equal(periodic(np.ones((3, 1)), 1, 1), np.ones((3, 3)))
