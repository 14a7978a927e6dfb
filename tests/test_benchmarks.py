"""What the benchmarks compare with is the same mathematics, and they run without the peers."""

from functools import partial

import numpy as np
import pytest

import distmesh_edu as de
from benchmarks import level_set_peers, level_set_transcription, level_sets, measuring

SHAPES = {1: (31,), 2: (25, 25), 3: (13, 13, 13)}


@pytest.fixture
def alone(monkeypatch):
    for module in (level_set_peers, level_set_transcription):
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
