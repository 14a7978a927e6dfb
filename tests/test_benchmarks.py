"""What the benchmarks compare with is the same mathematics, and they run without the peers."""

from functools import partial
from itertools import islice

import numpy as np
import pytest
from scipy.spatial import Delaunay

import distmesh_edu as de
from benchmarks import (
    level_set_peers,
    level_set_transcription,
    level_sets,
    measuring,
    mesh_cases,
    mesh_peers,
    meshes,
    transcription,
)
from distmesh_edu import distmesh

SHAPES = {1: (31,), 2: (25, 25), 3: (13, 13, 13)}


@pytest.fixture
def alone(monkeypatch):
    for module in (level_set_peers, level_set_transcription, mesh_peers):
        monkeypatch.setattr(module, "peer", lambda name: None)


def wavy(dim):
    """Return the values of a bumpy, distorted ball on a grid, and the spacing."""
    grid = level_sets.box(dim, SHAPES[dim][0])
    x = grid.points
    return (np.linalg.norm(x, axis=-1) - 1.1 - 0.1 * np.cos(4 * x[..., 0])) * (2 + x[..., 0]), 4 / (
        SHAPES[dim][0] - 1
    )


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_plain_step_is_that_of_the_library(dim):
    phi, dx = wavy(dim)
    ours = phi - 0.1 * de.godunov_norm(phi, 1.0, dx)
    np.testing.assert_allclose(level_set_transcription.step(phi, dx, 0.1), ours, atol=1e-12)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_plain_reinitialization_is_that_of_the_library(dim):
    phi, dx = wavy(dim)
    ours = de.reinitialize(phi, dx, band=3 * dx)
    np.testing.assert_allclose(
        level_set_transcription.reinitialize(phi, dx, 3 * dx), ours, atol=1e-12
    )


@pytest.mark.parametrize("speed", [1.0, -1.0])
def test_rows_in_turn_are_the_library_s_norm_times_the_speed(speed):
    phi, dx = wavy(2)
    rate = level_set_transcription.evolve_normal_eno2(phi, np.full_like(phi, speed), dx)
    np.testing.assert_allclose(rate, speed * de.godunov_norm(phi, speed, dx), atol=1e-12)


@pytest.mark.parametrize("dim", [2, 3])
def test_compiled_loop_is_the_library_s_step(dim):
    pytest.importorskip("numba")
    phi, dx = wavy(dim)
    padded = np.pad(phi, 2)
    out = level_set_transcription.fused_step()(padded, np.zeros_like(padded), dx, 0.1)
    ours = phi - 0.1 * de.godunov_norm(phi, 1.0, dx)
    np.testing.assert_allclose(out[(slice(2, -2),) * dim], ours, atol=1e-12)


def test_zeros_between_nodes_are_where_straight_lines_have_them():
    grid = level_sets.box(2, 9)
    found = level_sets.crossings(grid.points[..., 0] + 0.2, grid)
    np.testing.assert_allclose(found[:, 0], -0.2)
    assert len(found) == 9


def test_order_is_the_power_of_the_spacing():
    assert level_sets.order([8e-3, 1e-3], [11, 21]) == pytest.approx(3)


def test_redistancing_is_reported_without_peers(alone, capsys):
    found = level_sets.redistancing("Circle", partial(level_sets.ball, 2), (25, 49))
    printed = capsys.readouterr().out
    assert "scikit-fmm, order 2: not installed" in printed
    line = next(line for line in printed.splitlines() if line.startswith("  redistance"))
    assert float(line.split()[-1]) == 1  # the ratio of ours to ours
    ours = found[49]["redistance"]
    assert ours["band"] < found[49]["scipy EDT, half a cell"]["band"] / 10
    assert found[49]["(the truth itself)"]["moved"] <= ours["moved"] * 1.01


def test_aims_are_judged_by_what_was_measured(capsys):
    def measured(band, seconds):
        names = ("redistance", "reinitialize, band", "  plain, same steps")
        return {n: {"band": band, "seconds": seconds[n]} for n in names}

    slow = {"redistance": 1.0, "reinitialize, band": 4.0, "  plain, same steps": 8.0}
    found = {51: measured(16e-2, slow), 101: measured(4e-2, slow), 201: measured(1e-2, slow)}
    for n in found:
        found[n]["scikit-fmm, order 2"] = {"band": 0.8, "seconds": 1.25}
    level_sets._reach("disc", found, time=1, better=100)
    said = capsys.readouterr().out.splitlines()
    met = [line.startswith("  met ") for line in said]
    assert met == [True, False, False, True, False]  # order 2, 2 times, order 2, 0.8, 80 times


def test_step_is_reported_without_numba(alone, capsys):
    table = level_sets.one_step(sizes=((25, 25), (9, 9, 9)))
    printed = capsys.readouterr().out
    assert printed.count("numba: not installed") == 1
    assert table[25, 25]["distmesh_edu"] > 0


def test_works_take_turns():
    turns = []
    found = measuring.side_by_side({k: lambda k=k: turns.append(k) or k for k in "ab"}, repeats=2)
    assert turns == ["a", "b", "a", "b"]
    assert found["b"][0] == "b"


def test_no_new_round_begins_once_the_budget_is_spent():
    turns = []
    measuring.side_by_side({"a": lambda: turns.append(1)}, repeats=5, budget=0.0)
    assert len(turns) == 1


every_case = pytest.mark.parametrize("case", mesh_cases.ALL.values(), ids=lambda c: c.name)
SMALL = mesh_cases.Case(
    "disc", de.circle(), None, 0.3, np.array([[-1.0, -1], [1, 1]]), np.empty((0, 2)), np.pi, 1
)


@every_case
def test_rings_are_the_boundary_and_enclose_the_area(case):
    for ring in case.rings:
        assert np.abs(case.fd(ring)).max() < 1e-9 * case.h0
    if case.rings:
        area = de.polygon_area(case.rings[0], case.rings[1:])
        assert area == pytest.approx(case.measure, rel=1e-6)


@every_case
def test_starts_differ_and_all_boxes_hold_the_region(case):
    boxes = [case.variant(seed)[3] for seed in range(mesh_cases.STARTS)]
    corners = [box[0] / case.h0 % 1 for box in boxes]
    assert len({tuple(corner.round(6)) for corner in corners}) == mesh_cases.STARTS
    for box in boxes:
        assert (box[0] <= case.bbox[0]).all()
        assert (box[1] >= case.bbox[1]).all()


@every_case
def test_smallest_edge_is_h0_and_fixed_points_lie_on_the_boundary(case):
    p = np.random.default_rng(0).uniform(*case.bbox, (4000, case.dim))
    edge = case.edge(p[case.fd(p) < 0])
    assert case.h0 * (1 - 1e-9) <= edge.min() < 1.2 * case.h0
    assert np.abs(case.fd(case.pfix)).max(initial=0) < 1e-12


@pytest.mark.parametrize("name", ["ball 0.2", "cylinder with spherical hole 0.1"])
def test_measure_in_space_is_the_fields(name):
    case = mesh_cases.ALL[name]
    n = 100
    middles = [a + (np.arange(n) + 0.5) * (b - a) / n for a, b in case.bbox.T]
    d = case.fd(np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1))
    share = (d < 0).mean() * np.prod(case.bbox[1] - case.bbox[0])
    assert share == pytest.approx(case.measure, rel=2e-3)


@pytest.mark.parametrize("name", ["disc 0.1", "square with hole, graded 0.05", "ball 0.2"])
def test_first_step_of_the_listing_is_the_library_s(name, monkeypatch):
    # Where points lie on one circle there is a choice: both take Qhull's for the same numbers.
    monkeypatch.setattr(distmesh, "delaunay", lambda p, center: Delaunay(p).simplices)
    case = mesh_cases.ALL[name]
    fd, fh, h0, box, pfix = case.variant(1)
    steps = getattr(distmesh, f"distmesh{case.dim}d_steps")(fd, fh, h0, box, pfix, rng=1)
    mesh = next(islice(steps, 1, None))
    listing = getattr(transcription, f"distmesh{case.dim}d")
    run = listing(fd, case.edge, h0, box, pfix, np.random.default_rng(1), max_steps=1)
    assert run.steps == run.calls == 1
    assert not run.converged
    np.testing.assert_allclose(run.p, mesh.p, atol=1e-6 * h0)


def test_listing_in_space_starts_with_the_nodes_of_the_thesis_s():
    # 587 nodes: the thesis's listing, run in GNU Octave 7.3.
    fd, _, *place = mesh_cases.ALL["ball 0.2"].variant(0)
    ones = partial(np.ones_like, subok=False)
    run = transcription.distmesh3d(
        fd, lambda p: ones(p[:, 0]), *place, np.random.default_rng(0), max_steps=1
    )
    assert len(run.p) == 587


def test_intended_test_ends_the_listing_sooner():
    fd, _, *place = SMALL.variant(0)
    printed, intended = (
        transcription.distmesh2d(fd, SMALL.edge, *place, np.random.default_rng(0), intended=i)
        for i in (False, True)
    )
    assert printed.converged
    assert intended.converged
    assert intended.steps < printed.steps


def test_curves_are_divided_evenly_and_keep_their_corners():
    square = mesh_cases.CORNERS
    points = mesh_peers.divided(square, lambda p: np.full(len(p), 0.5))
    assert len(points) == 16
    for corner in square:
        assert np.abs(points - corner).sum(axis=1).min() < 1e-12
    sides = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    np.testing.assert_allclose(sides, 0.5)


def test_divided_edges_follow_the_size():
    case = mesh_cases.ALL["square with hole, graded 0.02"]
    points = mesh_peers.divided(case.rings[0], case.edge)
    after = np.roll(points, -1, axis=0)
    sides = np.linalg.norm(after - points, axis=1)
    np.testing.assert_allclose(sides / case.edge((points + after) / 2), 1, atol=0.2)


@pytest.mark.parametrize("turned", [False, True])
def test_point_inside_a_ring_is_inside(turned):
    for ring in mesh_cases.ALL["lake, uniform 8 km"].rings:
        p = mesh_peers.inside(ring[::-1] if turned else ring)
        assert de.polygon(ring)(p[None])[0] < 0


@pytest.mark.parametrize("peer", ["gmsh", "triangle"])
@pytest.mark.parametrize("name", ["annulus 0.1", "square with hole, graded 0.05", "ball 0.2"])
def test_peers_with_a_boundary_fill_the_region(peer, name):
    pytest.importorskip({"gmsh": "gmsh", "triangle": "meshpy.triangle"}[peer])
    case = mesh_cases.ALL[name]
    found = getattr(mesh_peers, peer)()(case, 0)
    if (peer, name) == ("triangle", "ball 0.2"):
        assert found is None
        return
    mesh = de.Mesh(*found)
    assert mesh.volume == pytest.approx(case.measure, rel=0.02)
    assert mesh.euler_characteristic == case.euler
    assert (mesh.edge_lengths / case.edge(mesh.p[mesh.edges].mean(axis=1))).mean() > 0.8


def test_suite_is_reported_without_peers(alone, capsys):
    found = meshes.suite([SMALL], starts=2)
    meshes.totals(found | {mesh_cases.PLANE[0].name: found["disc"]})
    meshes.short_form({mesh_cases.PLANE[0].name: found["disc"]})
    printed = capsys.readouterr().out
    assert "gmsh: not installed" in printed
    assert "| 1 regions in the plane | 1 / 0." in printed
    first, *_ = found["disc"].values()
    assert [o.ratio for o in first] == [1, 1]
    listing = found["disc"][meshes.PRINTED][0]
    assert listing.ratio == listing.seconds / first[0].seconds
    assert listing.rest
    assert listing.right
    assert listing.least > 0.6
    assert listing.edge == pytest.approx(1, abs=0.2)
    assert listing.area < 0  # a polygon in a disc


def test_program_that_fails_is_said_to(alone, capsys):
    def broken(case, seed):
        raise ValueError("no such region")

    def nonsense(case, seed):
        return transcription.Run(np.full((3, 2), np.nan), np.array([[0, 1, 2]]), 1, 1, True)

    works = {"good": meshes._listing, "broken": broken, "nonsense": nonsense}
    found = meshes.suite([SMALL], starts=1, works=works | {"shy": lambda case, seed: None})
    printed = capsys.readouterr().out
    assert "broken                    failed: no such region" in printed
    assert "nonsense                  failed:" in printed
    assert "shy" not in printed
    assert [len(rows) for rows in found["disc"].values()] == [1, 0, 0, 0]


def outcome(**known):
    plain = {"seconds": 1.0, "ratio": 1.0, "nodes": 9, "steps": 9, "calls": 2, "rest": True}
    judged = {"least": 0.5, "mean": 0.96, "area": 0.001, "right": True, "edge": 1.0, "floor": 0.1}
    return meshes.Outcome(**plain | judged | known)


def test_share_compares_sums_of_medians_at_the_same_starts():
    def of(*runs):
        return [outcome(seconds=seconds, ratio=ratio) for seconds, ratio in runs]

    # Ours took 3, 1 and 2 s in one case, and the other program saw its first start only.
    ours = of((3, 1), (1, 1), (2, 1))
    found = {
        "one": {"ours": ours, "it": of((6, 2))},
        "two": {"ours": ours, "it": of((6, 2), (18, 18), (14, 7))},
    }
    assert meshes._share(found, ["one", "two"], "it") == (20, 4)
    assert meshes._share(found, ["one", "two"], "ours") == (4, 1)


@pytest.mark.parametrize("good", [True, False])
def test_aims_for_meshes_are_judged_by_what_was_measured(good, capsys):
    plane = {} if good else {"rest": False, "least": 0.3, "mean": 0.92, "floor": 0.01}
    lake = {} if good else {"rest": False, "least": 0.3, "area": -0.02, "seconds": 11.0}
    ball = {} if good else {"least": 0.2, "edge": 0.85}
    slow = 16.0 if good else 6.0
    cases = {"disc 0.01": plane, "lake, uniform 8 km": lake, "ball 0.1": ball}
    found = {
        name: {
            meshes.FAST: [outcome(**values)],
            meshes.PRINTED: [outcome(seconds=slow, ratio=slow)],
        }
        for name, values in cases.items()
    }
    meshes.aims(found)
    said = capsys.readouterr().out.splitlines()[2:]
    assert len(said) == 13
    failing = [line for line in said if line.startswith("  NOT met")]
    assert len(failing) == (0 if good else 12)  # it did make a mesh of every case


def test_aim_for_a_case_without_a_mesh_is_not_met(capsys):
    disc = {meshes.FAST: [], meshes.PRINTED: [outcome()]}
    meshes.aims(
        {
            "disc 0.1": {meshes.FAST: [outcome()], meshes.PRINTED: [outcome()]},
            "disc 0.01": disc,
            "lake, uniform 8 km": disc,
        }
    )
    printed = capsys.readouterr().out
    assert "NOT met plane: every case has a mesh, but disc 0.01" in printed
    assert "NOT met lake, uniform 8 km: 0 of 0 runs" in printed
