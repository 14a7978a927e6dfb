"""The generator to rely on: valid meshes of whatever is asked for, an end, a word on the rest."""

import warnings
from functools import cache
from itertools import product

import numpy as np
import pytest
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st
from regions import bad_input, ball, cube, euler_characteristic, good_input, topology

import distmesh_edu as de
from benchmarks import mesh_cases
from distmesh_edu.mesh_generation import _triangulate, mend_boundary
from distmesh_edu.mesh_improvement import without_flat
from distmesh_edu.region import as_region

SQUARE = ((-1, -1), (1, 1))
CORNERS = np.array([(-1, -1), (-1, 1), (1, 1), (1, -1)], dtype=float)
H0 = {1: 0.1, 2: 0.1, 3: 0.35}


@cache
def of_ball(dim, **options):
    return de.generate_mesh(ball(dim), None, H0[dim], cube(dim), **options)


@cache
def of_case(name, seed=1):
    case = mesh_cases.ALL[name]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", de.ResolutionWarning)
        return de.generate_mesh(*case.variant(seed), rng=seed)


def check(mesh, pfix=()):
    """Assert what holds of every mesh: orientation, no node unused or twice, a closed boundary."""
    assert (mesh.volumes > 0).all()
    assert len(mesh.orphans) == 0
    assert len(np.unique(mesh.p, axis=0)) == len(mesh.p)
    np.testing.assert_array_equal(mesh.p[: len(pfix)], np.reshape(pfix, (-1, mesh.dim)))
    facets = np.sort(mesh.boundary_facets, axis=1)
    if mesh.dim > 1:
        ridges = np.concatenate([np.delete(facets, k, axis=1) for k in range(mesh.dim)])
        assert (np.unique(ridges, axis=0, return_counts=True)[1] % 2 == 0).all()


def depths(mesh, fd):
    """Return how far each boundary node is from the boundary."""
    return np.abs(fd(mesh.p[mesh.boundary_nodes]))


def mesh_and_words(*args, **kwargs):
    """Return the mesh and the warnings that it came with."""
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        mesh = de.generate_mesh(*args, **kwargs)
    assert all(warning.filename == __file__ for warning in seen)
    return mesh, [(warning.category, str(warning.message)) for warning in seen]


def meets_itself(mesh):
    """Return whether four facets of a solid's surface, or more, share an edge."""
    edges = mesh.boundary_facets[:, [[0, 1], [1, 2], [2, 0]]] if mesh.dim == 3 else np.empty(0)
    _, facets = np.unique(np.sort(edges.reshape(-1, 2)), axis=0, return_counts=True)
    return bool((facets > 2).any())


@st.composite
def unions(draw, dim, h0):
    """Draw a union of balls and boxes, and the boxes' corners on its boundary.

    The boxes' sides lie on a lattice, so that steps between them are none or 3 h0 high.
    """
    parts, corners, side = [], np.empty((0, dim)), 3 * h0
    signs = np.array(list(product((0, 1), repeat=dim)))
    for _ in range(draw(st.integers(1, 3))):
        at = [draw(st.floats(-1, 1)) for _ in range(dim)]
        if draw(st.booleans()):
            parts.append(ball(dim, np.array(at), draw(st.floats(2 * h0, 0.9))))
        else:
            lower = side * np.floor(np.array(at) / side)
            upper = lower + side * np.array([draw(st.integers(1, 2)) for _ in range(dim)])
            parts.append(de.box((lower, upper)))
            corners = np.concatenate((corners, lower + signs * (upper - lower)))
    union = lambda p: np.min([part(p) for part in parts], axis=0)  # noqa: E731
    on = np.abs(union(corners)) < 1e-9
    return union, np.unique(corners[on].round(9), axis=0)


def steady(examples):
    """Return settings with the same examples in each run, that do not search for smaller ones."""
    phases = (Phase.explicit, Phase.generate)
    return settings(max_examples=examples, deadline=None, derandomize=True, phases=phases)


@pytest.mark.parametrize(("dim", "h0", "examples"), [(1, 0.05, 25), (2, 0.09, 25), (3, 0.3, 8)])
def test_meshes_of_random_unions_are_valid(dim, h0, examples):
    """Of parts and gaps at least 3 h0 wide, whose topology a fine grid tells beforehand."""

    @given(data=st.data(), h0=st.floats(h0, 1.4 * h0), seed=st.integers(0, 99))
    @steady(examples)
    def holds(data, h0, seed):
        fd, corners = data.draw(unions(dim, h0))
        euler = topology(fd, cube(dim, 2.5), h0, 2.8 * h0)
        assume(euler is not None)
        mesh, seen = mesh_and_words(fd, None, h0, cube(dim, 3), corners, rng=seed)
        check(mesh, corners)
        # In a crevice finer than an edge a surface may meet itself. Then there is a warning.
        assert mesh.euler_characteristic == euler or (meets_itself(mesh) and seen)
        assert depths(mesh, fd).max() < 0.05 * h0 or seen
        assert {kind for kind, _ in seen} <= {de.ResolutionWarning}
        again, _ = mesh_and_words(fd, None, h0, cube(dim, 3), corners, rng=seed)
        np.testing.assert_array_equal(mesh.p, again.p)
        np.testing.assert_array_equal(mesh.t, again.t)

    holds()


def test_a_surface_that_meets_itself_is_told_from_one_that_does_not():
    p = [(0, 0, 0), (0, 0, 1), (1, 0, 0), (1, 1, 0), (-1, 0, 0), (-1, -1, 0)]
    assert not meets_itself(of_ball(3))
    assert not meets_itself(de.Mesh(p[:4], [(0, 1, 2, 3)]))
    assert meets_itself(de.Mesh(p, [(0, 1, 2, 3), (0, 1, 4, 5)]))
    assert not meets_itself(of_ball(2))


def test_the_fine_grid_knows_the_topology():
    ring = de.difference(de.circle(), de.circle(radius=0.5))
    assert topology(ring, cube(2), 0.1, 0.3) == 0
    assert topology(ring, cube(2), 0.1, 1.1) is None
    shell = de.difference(de.sphere(), de.sphere(radius=0.5))
    assert topology(shell, cube(3), 0.1, 0.3) == 2
    assert topology(de.torus(), cube(3, 1.3), 0.1, 0.3) == 0
    apart = np.array([True, False, True])
    assert euler_characteristic(apart) == 2


# What is known of a ball: its mesh, its edges, its end.


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_of_a_ball(dim):
    mesh = of_ball(dim)
    check(mesh)
    assert mesh.converged
    assert mesh.euler_characteristic == 1
    assert depths(mesh, ball(dim)).max() < 1e-9
    assert mesh.volume == pytest.approx({1: 2, 2: np.pi, 3: 4 / 3 * np.pi}[dim], rel=0.07)
    assert mesh.quality.min() >= {1: 1 - 1e-9, 2: 0.69, 3: 0.29}[dim]
    assert mesh.edge_lengths.mean() == pytest.approx(H0[dim], rel=0.16)
    assert len(de.unresolved(mesh, ball(dim))) == 0


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_a_constant_size_function_is_the_uniform_mesh_in_number(dim):
    sevens = lambda p: np.full(p.shape[:-1], 7.0)  # noqa: E731
    mesh = de.generate_mesh(ball(dim), sevens, H0[dim], cube(dim))
    assert len(mesh.p) == pytest.approx(len(of_ball(dim).p), rel=0.05)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_edges_follow_the_size_function(dim):
    """In units of fh they are equally long in all zones; the smallest are about h0."""
    h0 = {1: 0.01, 2: 0.03, 3: 0.12}[dim]
    fh = lambda p: h0 + 0.25 * np.linalg.norm(p, axis=-1)  # noqa: E731
    mesh = de.generate_mesh(ball(dim), fh, h0, cube(dim))
    middle = mesh.p[mesh.edges].mean(axis=1)
    relative, at = mesh.edge_lengths / fh(middle), np.linalg.norm(middle, axis=1)
    zones = [relative[(at >= a) & (at < b)].mean() for a, b in ((0, 0.3), (0.3, 0.7), (0.7, 1))]
    np.testing.assert_allclose(zones, np.mean(zones), rtol=0.2)
    assert np.mean(zones) == pytest.approx(1.1, abs=0.2)


def test_each_piece_is_meshed():
    pieces = de.union(de.circle((-2, 0)), de.circle((2, 0), 0.5), de.rectangle(((-0.5, 2), (1, 3))))
    mesh = de.generate_mesh(pieces, None, 0.15, ((-3, -1), (3, 3)), [(-0.5, 2), (1, 2)])
    check(mesh, [(-0.5, 2), (1, 2)])
    assert mesh.euler_characteristic == 3
    assert mesh.volume == pytest.approx(1.25 * np.pi + 1.5, rel=0.02)
    line = lambda p: np.abs(np.abs(p[..., 0]) - 1.5) - 0.57  # noqa: E731
    mesh = de.generate_mesh(line, None, 0.1, ((-2.1,), (2.1,)))
    assert mesh.euler_characteristic == 2
    np.testing.assert_allclose(np.sort(mesh.p[mesh.boundary_nodes, 0]), (-2.07, -0.93, 0.93, 2.07))
    balls = de.union(de.sphere((-1.5, 0, 0)), de.sphere((1.5, 0, 0)))
    mesh = de.generate_mesh(balls, None, 0.4, ((-2.5, -1, -1), (2.5, 1, 1)))
    assert mesh.euler_characteristic == 2


@pytest.mark.parametrize(("h0", "half"), [(0.35, 0.9), (0.375, 2), (0.4, 0.9), (0.5, 0.75)])
def test_corners_of_a_box_keep_their_tetrahedra(h0, half):
    """Another node took a corner's place, and the fixed one was left without a tetrahedron."""
    corners = np.array(list(product((-0.75, 0.75), repeat=3)))
    mesh = de.generate_mesh(de.box(cube(3, 0.75)), None, h0, cube(3, half), corners)
    check(mesh, corners)
    assert mesh.volume == pytest.approx(1.5**3, rel=0.005)
    assert mesh.quality.min() > 0.25


@pytest.mark.parametrize(
    ("dim", "pfix"),
    [
        (1, [(0,), (0.01,), (0.5,)]),
        (2, [(0, 0), (0.01, 0), (0.5, 0.5), (0.5, 0.51)]),
        (2, [(1, 0), (np.cos(0.03), np.sin(0.03))]),
        (3, [(0, 0, 0), (0.04, 0, 0)]),
    ],
)
def test_fixed_points_closer_than_h0_are_kept(dim, pfix):
    mesh, _ = mesh_and_words(ball(dim), None, H0[dim], cube(dim), pfix)
    check(mesh, pfix)
    assert mesh.euler_characteristic == 1
    assert mesh.quality.mean() > 0.8


# What is not as it should be: fields, boxes, places.


@pytest.mark.parametrize("scale", [0.2, 5])
@pytest.mark.parametrize("dim", [1, 2, 3])
def test_a_factor_in_the_distance_changes_nothing(dim, scale):
    """In space a fifth left flat tetrahedra, mean quality 0.48; five brought false warnings."""
    mesh = de.generate_mesh(lambda p: scale * ball(dim)(p), None, H0[dim], cube(dim))
    assert mesh.quality.mean() == pytest.approx(of_ball(dim).quality.mean(), abs=0.02)
    assert len(mesh.p) == pytest.approx(len(of_ball(dim).p), rel=0.15)
    assert depths(mesh, ball(dim)).max() < 1e-6


@pytest.mark.parametrize("scale", [0.2, 5])
@pytest.mark.parametrize("dim", [1, 2, 3])
def test_any_smooth_function_will_do(dim, scale):
    fd = lambda p: scale * ((p**2).sum(axis=-1) - 1)  # noqa: E731
    mesh = de.generate_mesh(fd, None, H0[dim], cube(dim))
    check(mesh)
    assert depths(mesh, ball(dim)).max() < 1e-6
    assert mesh.quality.mean() > 0.86
    assert len(de.unresolved(mesh, fd)) == 0


@pytest.mark.parametrize(("degree", "tolerance"), [(1, 0.005), (3, 1e-4)])
def test_a_gridded_distance_will_do(degree, tolerance):
    grid = de.Grid(((-2, -2), (2, 2)), 0.1)
    fd = grid.interpolate(de.circle()(grid.points), degree=degree)
    mesh = de.generate_mesh(fd, None, 0.1, SQUARE)
    check(mesh)
    assert mesh.converged
    assert mesh.quality.min() > 0.65
    assert depths(mesh, ball(2)).max() < tolerance


@pytest.mark.parametrize("offset", [1e3, 1e6])
@pytest.mark.parametrize("dim", [1, 2, 3])
def test_far_from_the_origin_the_mesh_is_the_same(dim, offset):
    mesh = de.generate_mesh(ball(dim, offset), None, H0[dim], cube(dim) + offset)
    assert len(mesh.p) == len(of_ball(dim).p)
    np.testing.assert_allclose(mesh.volume, of_ball(dim).volume, rtol=1e-3)
    assert depths(mesh, ball(dim, offset)).max() < 1e-8


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_what_is_given_is_not_changed(dim):
    pfix, bbox = 0.5 * np.eye(dim), cube(dim)
    lent = []

    def field(p):
        lent.append(p)
        return ball(dim)(p)

    def size(p):
        lent.append(p)
        return np.ones(len(p))

    de.generate_mesh(field, size, H0[dim], bbox, pfix)
    np.testing.assert_array_equal(pfix, 0.5 * np.eye(dim))
    np.testing.assert_array_equal(bbox, cube(dim))
    assert not any(p.flags.writeable for p in lent)


@pytest.mark.parametrize(
    ("change", "error", "words"), [row for dim in (1, 2, 3) for row in bad_input(dim)]
)
@pytest.mark.filterwarnings("ignore:invalid value")
def test_bad_input_is_named(change, error, words, request):
    dim = int(request.node.callspec.id[0])
    with pytest.raises(error, match=words):
        de.generate_mesh(**(good_input(dim) | change))


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"goal": 0}, ValueError, "goal must be one positive number"),
        ({"goal": "high"}, TypeError, "goal must hold real numbers"),
        ({"patience": 0}, ValueError, "patience must be 1"),
        ({"patience": 2.5}, TypeError, "patience must be a whole number"),
        ({"bbox": cube(4)}, ValueError, "bbox must be"),
    ],
)
def test_bad_tuning_is_named(change, error, words):
    with pytest.raises(error, match=words):
        de.generate_mesh(**(good_input(2) | change))


# How it ends, and what it tells.


@pytest.mark.parametrize("dim", [2, 3])
def test_the_cap_is_told_and_the_mesh_is_of_use(dim):
    with pytest.warns(de.ConvergenceWarning, match="cap of 3 steps.*Raise max_steps") as seen:
        mesh = de.generate_mesh(ball(dim), None, H0[dim], cube(dim), max_steps=3)
    assert seen[0].filename == __file__
    assert not mesh.converged
    assert mesh.steps == 3
    check(mesh)
    assert mesh.quality.min() > 0.2
    assert mesh.quality.mean() > 0.8


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_history_and_callback_tell_how_it_went(dim):
    seen = []
    mesh = de.generate_mesh(ball(dim), None, 0.9 * H0[dim], cube(dim), callback=seen.append)
    assert [len(one.history) for one in seen] == list(range(1, len(mesh.history) + 1))
    assert not any(one.converged for one in seen)
    step = mesh.history["step"]
    assert step[0] == 0
    assert step[-1] == mesh.steps
    assert (np.diff(step[:-1]) > 0).all()
    assert mesh.history["mean_quality"][-1] == mesh.quality.mean()
    assert mesh.history["minimum_quality"][-1] == mesh.quality.min()
    with pytest.raises(ValueError, match="read-only"):
        mesh.history["move"] = 0


@pytest.mark.parametrize(("dim", "low", "high"), [(2, 0.05, 0.8), (3, 0.01, 0.35)])
def test_the_goal_is_reached_or_approached(dim, low, high):
    careless, careful = (
        de.generate_mesh(ball(dim), None, H0[dim], cube(dim), goal=goal) for goal in (low, high)
    )
    assert careless.quality.min() < of_ball(dim).quality.min() < careful.quality.min()
    assert careful.quality.min() > high - 0.1


def test_patience_makes_the_mean_a_little_better():
    hasty, patient = (of_ball(2, patience=steps) for steps in (3, 200))
    assert hasty.steps < of_ball(2).steps < patient.steps < 1000
    assert hasty.quality.mean() < patient.quality.mean()
    assert patient.quality.mean() >= of_ball(2).quality.mean()


@pytest.mark.parametrize(
    "name", ["disc 0.05", "point and line 0.02", "square with hole, graded 0.02"]
)
def test_it_stops_when_it_gets_nowhere_and_not_before(name):
    """In 15 steps the mean quality made up for less than three tenths of what it lacked."""
    history = of_case(name).history[:-1]  # the last row is that of the finished mesh
    step, lack = history["step"], 1 - history["mean_quality"]

    def left(row):
        """Return what share is left of what was lacking 15 steps before; the start is no mesh."""
        before = np.flatnonzero(step[: max(row - 1, 0)] <= step[row] - 15)
        return lack[row] / lack[before[-1]] if len(before) else 0

    assert left(len(history) - 1) > 0.7
    assert all(left(row) <= 0.7 for row in range(len(history) - 1))


def test_one_seed_one_mesh():
    size = lambda p: 1 + 4 * np.linalg.norm(p, axis=-1)  # noqa: E731

    def mesh(rng):
        return de.generate_mesh(de.circle(), size, 0.05, SQUARE, rng=rng)

    np.testing.assert_array_equal(mesh(3).p, mesh(3).p)
    np.testing.assert_array_equal(mesh(3).p, mesh(np.random.default_rng(3)).p)
    assert mesh(3).p.shape != mesh(4).p.shape or (mesh(3).p != mesh(4).p).any()


# What the mesh does not resolve.


def near(places, point, distance):
    return len(places) > 0 and np.linalg.norm(places - point, axis=1).min() < distance


@pytest.mark.parametrize("half", [0.001, 0.03, 0.06])
def test_a_bar_thinner_than_h0_is_told(half):
    """It was left out without a word unless a lattice point happened to lie in it."""
    bar = de.rectangle(((-2, -half), (2, half)))
    fd = de.union(de.circle((-2, 0)), de.circle((2, 0)), bar)
    mesh, seen = mesh_and_words(fd, None, 0.2, ((-3, -1), (3, 1)))
    check(mesh)
    (kind, words), *more = seen
    assert kind is de.ResolutionWarning
    assert not more
    assert "the worst near" in words
    places = de.unresolved(mesh, fd)
    assert (np.abs(places) < (1.2, 0.2)).all()
    assert f"near ({places[0, 0]:.4g}, {places[0, 1]:.4g})" in words


def test_an_arm_and_a_hole_smaller_than_h0_are_told():
    for radius in (1e-3, 0.03, 0.06):
        holed = de.difference(de.circle(), de.circle((0.3, 0.2), radius))
        mesh, seen = mesh_and_words(holed, None, 0.2, SQUARE)
        assert [kind for kind, _ in seen] == [de.ResolutionWarning]
        assert near(de.unresolved(mesh, holed), (0.3, 0.2), 0.1)
    arm = de.union(de.circle(), de.rectangle(((0.9, -0.02), (1.8, 0.02))))
    mesh, seen = mesh_and_words(arm, None, 0.2, ((-1, -1), (2, 1)))
    assert near(de.unresolved(mesh, arm), (1.3, 0), 0.2)
    bubble = de.difference(de.sphere(), de.sphere((0.3, 0.2, 0.1), 0.03))
    mesh, seen = mesh_and_words(bubble, None, 0.35, cube(3))
    assert near(de.unresolved(mesh, bubble), (0.3, 0.2, 0.1), 0.1)


def test_a_plate_all_too_thin_is_refused():
    plate = de.box(((-1, -1, -0.01), (1, 1, 0.01)))
    with pytest.raises(ValueError, match="thinner than h0"):
        de.generate_mesh(plate, None, 0.4, ((-1, -1, -0.4), (1, 1, 0.4)))


def test_a_tube_as_thin_as_its_edges_is_told():
    """A torus of tetrahedra of which one is flat came without a word."""
    with pytest.warns(de.ResolutionWarning, match="The least quality, 0.0"):
        mesh = de.generate_mesh(de.torus(), None, 0.3, ((-1.3,) * 3, (1.3,) * 3))
    assert mesh.quality.min() < 0.15


def test_a_bar_all_too_thin_is_refused():
    with pytest.raises(ValueError, match="thinner than h0"):
        de.generate_mesh(
            de.rectangle(((-1, -0.02), (1, 0.02))), None, 0.2, ((-1.05, -0.15), (1, 0.1))
        )


def test_unresolved_corners_edges_and_nodes():
    t = np.array([(0, 1, 2), (0, 2, 3)])
    octagon = np.array([(0.3, 0), (1, 0.3), (0.7, 1), (0, 0.7)])
    cut = de.unresolved(de.Mesh(octagon, t), de.rectangle(((0, 0), (1, 1))))
    assert len(cut) == 0 or (cut != 0.5).all()
    corner = de.Mesh([(0, 0), (2, 0), (0, 2)], [(0, 1, 2)])
    assert near(de.unresolved(corner, de.rectangle(((0, 0), (2, 2)))), (1, 1), 1e-9)
    square = de.Mesh([(0, 0), (1, 0), (1, 1), (0, 1)], t)
    assert len(de.unresolved(square, de.rectangle(((0, 0), (1, 1))))) == 0
    assert len(de.unresolved(square, lambda p: 9 * de.rectangle(((0, 0), (1, 1)))(p))) == 0
    spare = de.Mesh([*square.p, (0.4, 0.6)], t)
    np.testing.assert_array_equal(
        de.unresolved(spare, de.rectangle(((0, 0), (1, 1)))), [(0.4, 0.6)]
    )
    none = np.empty((0, 3), dtype=int)
    assert de.unresolved(de.Mesh(square.p, none), de.circle()).shape == (4, 2)
    with pytest.raises(TypeError, match="fd must be a field"):
        de.unresolved(square, 1.0)


def test_a_flat_triangle_at_the_boundary_is_dropped_and_its_node_moved_there():
    p = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0.15)])
    t = np.array([(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)])
    region = as_region(de.rectangle(((0, 0), (1, 1))), None, 0.5, ((0, 0), (1, 1)), None, 2)
    q, left = mend_boundary(p, t, region, np.full(5, 0.25))
    np.testing.assert_array_equal(left, t[1:])
    np.testing.assert_allclose(q, [*p[:4], (0.5, 0)], atol=1e-9)
    p[4, 1] = 0.4  # no longer flat
    q, left = mend_boundary(p, t, region, np.full(5, 0.25))
    np.testing.assert_array_equal(left, t)
    np.testing.assert_allclose(q, p)


def test_a_good_tetrahedron_on_a_hollow_wall_stays_and_a_flat_one_does_not():
    """The centroids of both lie less than a tenth of h0 deep."""
    shell = de.difference(de.sphere(), de.sphere(radius=0.5))
    region = as_region(shell, None, 0.35, cube(3), None, 3, 0.1)
    angle = 2 / 3 * np.pi * np.arange(3)
    ring = 0.202 * np.stack((np.cos(angle), np.sin(angle), 0 * angle), axis=1)
    height = np.sqrt(0.25 - 0.202**2)
    p = np.array([*(ring + (0, 0, height)), (0, 0, height + 0.286)])
    assert 0 < -shell(p.mean(axis=0)) < 0.1 * 0.35
    assert len(_triangulate(p, region)) == 1
    flat = np.array([(0.2, 0, 0.98), (0, 0.2, 0.98), (-0.2, 0, 0.98), (0, -0.2, 0.975)])
    assert 0 < -shell(flat.mean(axis=0)) < 0.1 * 0.35
    with pytest.raises(ValueError, match="thinner than h0"):
        _triangulate(np.concatenate((flat, flat[:1] + 1e-12)), region)


def test_boundary_nodes_are_moved_to_the_boundary_unless_fixed_or_deep():
    p = np.array([(0, 0.1), (1, -0.1), (1, 0.7), (0, 1.0)])
    t = np.array([(0, 1, 2), (0, 2, 3)])
    pfix = p[:1]
    region = as_region(de.rectangle(((0, 0), (1, 1))), None, 0.5, ((0, 0), (1, 1)), pfix, 2)
    q, _ = mend_boundary(p, t, region, np.full(4, 0.25))
    np.testing.assert_allclose(q, [(0, 0.1), (1, 0), (1, 0.7), (0, 1)], atol=1e-9)


# Flat triangles at the boundary.

#: A square of which a side is pressed upon by one inner node, and the triangle behind by another.
BEHIND = (
    np.array([(0, 0), (4, 0), (4, 4), (0, 4), (2, 0.4), (1, 0.45)], dtype=float),
    np.array([(0, 1, 4), (0, 4, 5), (1, 2, 4), (4, 2, 5), (2, 3, 5), (3, 0, 5)]),
)
#: Two shores, and between them an ear, whose long edges are both outer ones.
BAY = (
    np.array([(0, 0), (1, 0.15), (0.5, -1), (2, 0), (2.5, -1), (3, 0)], dtype=float),
    np.array([(0, 2, 1), (3, 4, 5), (0, 1, 3)]),
)


def test_a_flat_triangle_behind_another_is_dropped_too():
    p, t = BEHIND
    np.testing.assert_array_equal(without_flat(p, t, 0), t[2:])
    assert set(t[2:].ravel()) == set(range(6))
    p = p.copy()
    p[5] = 1.6, 2  # the one behind is not flat
    np.testing.assert_array_equal(without_flat(p, t, 0), t[1:])


def test_a_flat_ear_across_a_bay_is_dropped():
    p, t = BAY
    np.testing.assert_array_equal(without_flat(p, t, 0), t[:2])
    p = p.copy()
    p[1] = 1, 1.2  # neither flat nor obtuse
    np.testing.assert_array_equal(without_flat(p, t, 0), t)


@pytest.mark.parametrize("order", [(0, 1, 3), (1, 3, 0), (3, 0, 1), (3, 1, 0)])
def test_which_corner_of_it_comes_first_does_not_matter(order):
    p, t = BAY
    np.testing.assert_array_equal(without_flat(p, np.array([*t[:2], order]), 0), t[:2])


def test_the_tip_of_a_sharp_corner_stays():
    """The same ear without the other shore: its far node has no other triangle."""
    p, t = BAY
    np.testing.assert_array_equal(without_flat(p, t[[0, 2]], 0), t[[0, 2]])
    tip = np.array([(0, 0), (1, -0.05), (1, 0.05), (2, -0.1), (2, 0.1)])
    wedge = np.array([(0, 1, 2), (1, 3, 2), (3, 4, 2)])
    assert de.Mesh(tip, wedge).quality[0] < 0.2
    np.testing.assert_array_equal(without_flat(tip, wedge, 0), wedge)


def test_a_flat_bump_is_dropped_unless_its_tip_is_fixed():
    """A node on a wall, a little outside, of which a Delaunay triangulation makes a triangle."""
    p = np.array([(2, -0.1), (0, 0), (4, 0), (2, 3)])
    t = np.array([(1, 0, 2), (1, 2, 3)])
    np.testing.assert_array_equal(without_flat(p, t, 0), t[1:])
    np.testing.assert_array_equal(without_flat(p, t, 1), t)


def test_a_flat_triangle_inside_stays():
    """Nobody sees it from outside: to drop it would make a hole."""
    p = np.array([(0, 0), (1, 0), (0.5, 0.1), (0.5, -0.8), (-0.2, 1), (1.2, 1)])
    t = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 4), (2, 1, 5), (2, 5, 4)])
    assert de.Mesh(p, t).quality[0] < 0.3
    np.testing.assert_array_equal(without_flat(p, t, 0), t)


def test_on_a_line_and_in_space_all_stay():
    pressed = np.array([(0, 0, 0), (3, 0, 0), (0, 3, 0), (0, 0, 3), (1, 1, 0.02)])
    t = np.array([(0, 1, 2, 4), (0, 1, 4, 3), (1, 2, 4, 3), (2, 0, 4, 3)])
    assert de.Mesh(pressed, t).quality[0] < 0.1
    np.testing.assert_array_equal(without_flat(pressed, t, 0), t)
    line = np.array([(0.0,), (1e-6,), (1.0,)])
    np.testing.assert_array_equal(without_flat(line, t[:2, :2], 0), t[:2, :2])


# Where the fields are asked, and places are named.


@pytest.mark.parametrize("grading", [None, 0.25])
@pytest.mark.parametrize("dim", [1, 2, 3])
def test_fields_are_not_asked_far_beyond_the_box(dim, grading):
    """Sizes never beyond it; the distance within two of the longest edges, or lattice cells."""
    h0, asked = H0[dim] / (1 if grading is None else 2), {"fd": [], "fh": []}

    def recorded(name, field):
        return lambda p: (asked[name].append(p.reshape(-1, dim).copy()), field(p))[1]

    sizes = recorded("fh", lambda p: h0 + (grading or 0) * np.linalg.norm(p, axis=-1))
    mesh = de.generate_mesh(recorded("fd", ball(dim)), sizes, h0, cube(dim))
    beyond = {name: np.abs(np.concatenate(p)).max() - 1 for name, p in asked.items()}
    assert beyond["fh"] < 1e-6 * h0
    assert 0 < beyond["fd"] < max(2.1 * mesh.edge_lengths.max(), 3.3 * h0)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_sizes_need_not_exist_beyond_the_box(dim):
    inside = lambda p: (np.abs(p) < 1 + 1e-9).all(axis=-1)  # noqa: E731
    h0 = H0[dim] / 2
    sizes = lambda p: np.where(inside(p), h0 + 0.25 * np.linalg.norm(p, axis=-1), np.nan)  # noqa: E731
    check(de.generate_mesh(ball(dim), sizes, h0, cube(dim)))


def rings(p):
    """Return a field that is negative in a ball and in shells about it: flat amid the gaps."""
    return -2 / np.pi * np.cos(np.pi / 2 * np.linalg.norm(p, axis=-1))


@pytest.mark.parametrize("cells", [2, 4, 8])
def test_no_place_is_named_far_from_an_interval(cells):
    """From where the field is flat, Newton's method led 60,000 kilometres away."""
    nodes = np.linspace(-1, 1, cells + 1)[:, None]
    mesh = de.Mesh(nodes, np.stack((np.arange(cells), np.arange(cells) + 1), axis=1))
    places = de.unresolved(mesh, rings)
    assert np.abs(places).max(initial=0) <= 1 + 5 * 2 / cells
    assert (len(places) > 0) == (cells == 2)  # as near as the next shell is then


def test_no_place_is_named_far_from_a_disc():
    mesh = de.generate_mesh(de.circle(), None, 0.5, SQUARE)
    places = de.unresolved(mesh, rings)
    assert np.linalg.norm(places, axis=1).max(initial=0) <= 1 + 5 * mesh.edge_lengths.max()


# The aims of the benchmarks that are no timings.


@pytest.mark.parametrize(
    "name",
    [
        *("disc 0.05", "annulus 0.1", "square with hole, uniform 0.05", "polygon 0.1"),
        *("square with hole, graded 0.02", "ellipse, its equation 0.2", "point and line 0.02"),
    ],
)
def test_the_plane_is_meshed_well(name):
    case, mesh = mesh_cases.ALL[name], of_case(name)
    check(mesh, case.pfix)
    assert mesh.converged
    assert mesh.euler_characteristic == case.euler
    assert mesh.quality.min() >= 0.35
    assert mesh.quality.mean() >= 0.93
    assert mesh.volume == pytest.approx(case.measure, rel=0.01)
    assert (mesh.edge_lengths / case.edge(mesh.p[mesh.edges].mean(axis=1))).mean() < 1.15
    assert len(de.unresolved(mesh, case.fd)) == 0


def test_the_ball_is_meshed_well():
    mesh = of_case("ball 0.2")
    check(mesh)
    assert mesh.converged
    assert mesh.quality.min() >= 0.25
    assert mesh.quality.mean() >= 0.9
    assert mesh.edge_lengths.mean() == pytest.approx(0.2, rel=0.1)
    assert mesh.volume == pytest.approx(4 / 3 * np.pi, rel=0.03)


def test_lake_superior_is_meshed_well_and_its_narrows_are_named():
    case = mesh_cases.ALL["lake, uniform 8 km"]
    mesh, ((kind, _),) = mesh_and_words(*case.variant(0))
    assert kind is de.ResolutionWarning
    assert mesh.converged
    assert len(mesh.orphans) == 0
    assert mesh.quality.min() >= 0.4
    assert mesh.quality.mean() >= 0.95
    assert mesh.volume == pytest.approx(case.measure, rel=0.01)
    places = de.unresolved(mesh, case.fd)
    small = [island for island in case.rings[1:] if np.ptp(island, axis=0).max() < 8.2]
    assert len(small) == 3
    for island in small:
        assert near(places, island.mean(axis=0), 8)
    assert near(places, (-46, -34), 8)  # the canal across the Keweenaw Peninsula


def test_graded_edges_leave_no_flat_tetrahedra_at_the_surface():
    """How deep a centroid must lie is judged by the edges there, not by the smallest."""
    cell, box = de.examples.discocyte(7.82, 0.4, 2.58), ((-4.5, -4.5, -1.8), (4.5, 4.5, 1.8))
    grid = de.Grid(box, 0.15)
    fd = grid.interpolate(de.redistance(cell(grid.points), grid.dx))
    fh = lambda p: np.minimum(0.2 + 0.2 * np.hypot(p[..., 0], p[..., 1]), 0.6)  # noqa: E731
    mesh = de.generate_mesh(fd, fh, 0.2, box)
    assert mesh.quality.min() > 0.2


@pytest.mark.xfail(
    strict=True, reason="in the crevice between ball and box the surface meets itself"
)
def test_a_surface_does_not_meet_itself_in_a_crevice():
    """Found by the random unions, which allow it where a warning came; it should not be."""
    s = 0.96572985
    lower, upper = ((-s, -s, s), (s, s, 3 * s)), ((0, 0, 0), (s, 2 * s, 2 * s))
    ball_ = de.sphere((-0.5, -0.05225731, 1.0), 0.8159951387959752)
    fd = de.union(de.box(lower), ball_, de.box(upper))
    corners = np.array(
        [(-1, -1, 1), (-1, -1, 3), (-1, 1, 1), (-1, 1, 3), (0, 0, 0), (0, 2, 0), (0, 2, 2)]
        + [(1, -1, 1), (1, -1, 3), (1, 0, 0), (1, 0, 2), (1, 1, 1), (1, 1, 3), (1, 2, 0), (1, 2, 2)]
    )
    mesh, seen = mesh_and_words(fd, None, 0.32190995, cube(3, 3), s * corners)
    assert seen
    assert not meets_itself(mesh)
