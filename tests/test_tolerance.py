"""The comparison of outputs must catch what changed, and pass what only rounding changed."""

import os
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_notebook, new_output

from tests.tolerance import TIES_ATOL, TIES_RTOL, difference

ROOT = Path(__file__).resolve().parents[1]

SAME = [
    ("area 3.14159265358979", "area 3.14159265358123"),
    ("[ 1.e-17 -2.]", "[-3.e-17 -2.]"),
    ("array([1., 2.])", "array([1.00000001, 2.])"),
    ("-0.", "0."),
    ("82,100.00001", "82,100.00002"),
    ("1.5%", "1.5000001%"),
    ("−2.5", "-2.5"),
    ("nan inf", "nan inf"),
    ("[0.1,\n 0.2]", "[0.1,   0.2]"),
    ("steps ≈ 100, quality ≈0.62", "steps ≈ 71, quality ≈0.58"),
    ("steps ≈   9.4", "steps ≈   9.3"),  # padded, in a table
]
CHANGED = [
    ("area 3.14159265358979", "area 3.14259265358979"),
    ("array([1., 2.])", "array([1., 2., 3.])"),
    ("array([1., 2.])", "array([1., 3.])"),
    ("1.0e-3", "1.0e-4"),
    ("-2.5", "2.5"),
    ("88 nodes", "89 nodes"),
    ("82,100 km", "82,101 km"),
    ("1000000", "1000001"),
    ("1.5%", "1.5"),
    ("nan", "1.0"),
    ("inf", "-inf"),
    ("eno2", "eno3"),
    ("converged in 9.0", "stopped in 9.0"),
    ("steps ≈ 100", "steps ≈ 100 or more"),
    ("steps ≈ 100", "steps 100"),
    ("steps ≈ 100", "steps ≈ 30"),
    ("quality ≈ 0.62", "quality ≈ 0.12"),
    ("quality ≈ 0.62, mean 0.95", "quality ≈ 0.62, mean 0.96"),
    ("quality ≈ 0.62", "quality ≈ nan"),
    ("a b", "a"),
    ("a", "a b"),
    ("", "0"),
]


@pytest.mark.parametrize(("old", "new"), SAME)
def test_passes_rounding(old, new):
    assert difference(old, new) is None
    assert difference(new, old) is None


@pytest.mark.parametrize(("old", "new"), CHANGED)
def test_catches_a_change(old, new):
    assert difference(old, new)
    assert difference(new, old)


def test_ties_have_the_stated_width():
    assert difference("≈ 1000", f"≈ {1000 * (1 - TIES_RTOL) + 1}") is None
    assert difference("≈ 1000", f"≈ {1000 * (1 - TIES_RTOL) - 1}")
    assert difference("≈ 0.01", f"≈ {0.01 + 0.99 * TIES_ATOL}") is None
    assert difference("≈ 0.01", f"≈ {0.01 + 1.01 * TIES_ATOL}")


def stream(text, name="stdout"):
    return new_output("stream", name=name, text=text)


def result(text):
    return new_output("execute_result", {"text/plain": text}, execution_count=1)


# What a cell runs, what the notebook says it gave, and whether that should pass.
CELLS = {
    "a changed twelfth digit": ("print(0.123456789012)", [stream("0.123456789013\n")], True),
    "a changed fourth digit": ("print(0.123456789012)", [stream("0.123556789012\n")], False),
    "an array": (
        "import numpy as np; np.array([0.1, -2e-9])",
        [result("array([ 1.0000001e-01, -2.1000000e-09])")],
        True,
    ),
    "a changed integer": ("88", [result("89")], False),
    "a changed word": ("print('stopped at 3.0')", [stream("converged at 3.0\n")], False),
    "a tie, within": ("print('steps ≈', 83)", [stream("steps ≈ 91\n")], True),
    "a tie, beyond": ("print('steps ≈', 83)", [stream("steps ≈ 191\n")], False),
    "a missing output": ("None", [stream("area 3.14\n")], False),
    "a missing result": ("print(1)", [stream("1\n"), result("1")], False),
    "a new output": ("print('area', 3.14)", [], False),
    # A reader should not meet a warning that the author never saw.
    "a new warning": ("import sys; print('beware', file=sys.stderr)", [], False),
    "nothing": ("x = 1", [], True),
}


def test_nbval_uses_it(tmp_path):
    cells = [
        new_code_cell(source, outputs=outputs, execution_count=k)
        for k, (source, outputs, _) in enumerate(CELLS.values(), start=1)
    ]
    nbformat.write(new_notebook(cells=cells), tmp_path / "tiny.ipynb")
    options = [
        "-p",
        "tests.tolerance",
        "--nbval",
        "--nbval-current-env",
        "-rA",
        "-p",
        "no:cacheprovider",
    ]
    run = subprocess.run(
        [sys.executable, "-m", "pytest", *options, "tiny.ipynb"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    lines = run.stdout.splitlines()
    passed = {name for k, name in enumerate(CELLS) if f"PASSED tiny.ipynb::Cell {k}" in lines}
    assert passed == {name for name, (_, _, good) in CELLS.items() if good}, run.stdout
    assert "the notebook has '89', now it is '88'" in run.stdout
