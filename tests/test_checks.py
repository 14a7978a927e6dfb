"""The checks that exercises call: what is right passes, and each mistake gets its own sentence."""

import sys
import warnings

import numpy as np
import pytest
from IPython.testing.globalipapp import start_ipython

import distmesh_edu as de
from distmesh_edu import checks
from distmesh_edu.checks import CheckFailed

BOX = ((-2, -2), (2, 2))
RNG = np.random.default_rng(1)
VALUES = RNG.uniform(0.1, 2, size=(6, 6))


def says(function, *args, **kwargs):
    """Return what a check says."""
    with pytest.raises(CheckFailed) as caught:
        function(*args, **kwargs)
    return str(caught.value)


def said_of(source):
    """Return what `exercise` says of a cell whose code stands in no file."""
    names = {"checks": checks, "np": np}
    body = "\n".join(f"    {line}" for line in source.splitlines())
    with pytest.raises(CheckFailed) as caught:
        exec(compile(f"with checks.exercise('It'):\n{body}", "<cell>", "exec"), names)
    return str(caught.value)


# --- The sentence ---------------------------------------------------------------------------------


def test_a_failure_names_what_was_expected_and_found_where_and_a_hint():
    failed = CheckFailed("x", expected="1", found="2", where="at node 3", hint="Look left.")
    assert str(failed) == "Not yet: x should be 1, but is 2, at node 3. Hint: Look left."
    assert (failed.what, failed.expected, failed.found) == ("x", "1", "2")
    assert (failed.where, failed.hint) == ("at node 3", "Look left.")


def test_a_notebook_shows_one_sentence_and_no_traceback(capsys):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        shell = start_ipython()
    shell.run_cell(
        "from distmesh_edu import checks\n"
        "def answer(): return 1 / 0\n"
        "with checks.exercise('Divide'):\n    checks.expect_values(answer(), 1)"
    )
    said = capsys.readouterr()
    assert "Traceback" not in said.out + said.err
    assert said.out.startswith(
        "Not yet: your code stopped with ZeroDivisionError: division by zero"
    )
    assert said.out.count("Not yet") == 1
    assert max(len(line) for line in said.out.splitlines()) <= 88


def test_an_exercise_says_that_it_is_passed(capsys):
    for title in ("Double it", "Is it?"):
        with checks.exercise(title):
            pass
    assert capsys.readouterr().out == "Passed: Double it.\nPassed: Is it?\n"


def test_a_warning_costs_no_marks(capsys):
    """Nbgrader gives none to a check that writes to stderr."""
    with checks.exercise("Divide"):
        assert np.isinf(np.float64(1) / np.zeros(1))
        sys.stderr.write("a word to the wise\n")
    said = capsys.readouterr()
    assert said.err == ""
    assert said.out == "a word to the wise\nPassed: Divide.\n"


def test_a_missing_entry_is_named():
    assert "there is no entry 'disc'. Hint: Keep the keys" in said_of("{}['disc']")


def test_a_missing_name_within_a_helper_of_a_check_is_the_cells():
    said = said_of("def _compare():\n    return step(1)\n_compare()")
    assert "there is no `step`. Hint: Write it in the cell above" in said


def test_a_missing_name_sends_the_student_to_the_cell_above():
    assert "there is no `step`. Hint: Write it in the cell above" in said_of("step(1)")


def test_an_error_in_an_answer_names_its_function_and_line():
    said = said_of("def step(phi):\n    a = 1\n    return phi[9]\nstep([1])")
    assert "IndexError: list index out of range, in line 4 of the cell with `step`" in said


def test_a_missing_name_within_an_answer_is_the_answers():
    said = said_of("def step():\n    return missing\nstep()")
    assert "NameError: name 'missing' is not defined, in line 3 of the cell with `step`" in said


@pytest.mark.parametrize("empty", ["None", "...", "lambda *_: None", "lambda *_: ..."])
def test_no_answer_is_no_mistake(empty):
    said = said_of(f"answer = {empty}\nchecks.expect_variation_kept(answer, np.ones(3))")
    assert "Write it in the cell above" in said
    said = said_of(
        f"answer = {empty}\nchecks.expect_values(answer() if callable(answer) else answer, 1)"
    )
    assert "Write it in the cell above" in said


def test_arithmetic_with_no_answer_is_no_mistake():
    assert "there is no answer here" in said_of("None + 1")


def test_what_should_be_a_function_and_is_none():
    assert "should be a function, but is 3 (a int)" in said_of("checks.expect_order(3, 1)")


def test_leaving_is_not_allowed():
    assert "SystemExit" in said_of("import sys\nsys.exit()")


def test_a_student_may_stop_a_check():
    with pytest.raises(KeyboardInterrupt), checks.exercise("It"):
        raise KeyboardInterrupt


# --- Values ---------------------------------------------------------------------------------------


def test_values_may_be_off_by_the_tolerance():
    checks.expect_values(VALUES + 1e-9, VALUES)
    assert "should be" in says(checks.expect_values, VALUES + 1e-6, VALUES)
    checks.expect_values(1.01, 1, within=0.011)
    checks.expect_values(0.0, 0.0)


@pytest.mark.parametrize(
    ("wrong", "hint"),
    [
        (0 * VALUES, "all 0"),
        (-VALUES, "wrong sign"),
        (2 * VALUES, "twice too large"),
        (VALUES / 2, "half of"),
        (-2 * VALUES, "wrong sign, and are twice"),
        (VALUES**2, "the squares of"),
        (np.sqrt(VALUES), "the roots of"),
        (3.5 * VALUES, "3.5 times"),
        (VALUES + 0.25, "off by the same 0.25"),
        (np.roll(VALUES, 1, axis=0), "off by one"),
        (np.roll(VALUES, -1, axis=1), "off by one"),
        (VALUES[::-1], "reverse order"),
        (VALUES.T, "axes are exchanged"),
        (np.pad(VALUES[1:-1, 1:-1], 1), "Only the values at the ends"),
    ],
)
def test_a_kind_of_mistake_is_recognised(wrong, hint):
    assert hint in says(checks.expect_values, wrong, VALUES)


def test_a_lost_sign_is_recognised():
    values = VALUES - 1
    assert "lost their sign" in says(checks.expect_values, np.abs(values), values)


def test_other_mistakes_get_no_invented_hint():
    assert "Hint" not in says(checks.expect_values, RNG.normal(size=(6, 6)), VALUES)


def test_known_mistakes_come_first():
    said = says(checks.expect_values, -2.0, 2.0, mistakes=[(1.0, "no"), (-2.0, "Look right.")])
    assert said.endswith("Hint: Look right.")


def test_the_worst_place_is_named():
    wrong = VALUES.copy()
    wrong[2, 3] += 1
    assert "at node [2, 3]" in says(checks.expect_values, wrong, VALUES)
    points = RNG.uniform(size=(3, 2))
    said = says(checks.expect_values, [0, 1, 0], np.zeros(3), at=points)
    assert f"at ({points[1, 0]:.4g}, {points[1, 1]:.4g})" in said


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        (VALUES[0], "an array of shape (6, 6), but is an array of shape (6,)"),
        ("many", "numbers, but is 'many' (a str)"),
        (np.full((6, 6), np.nan), "finite, but is nan, at node [0, 0]"),
        (None, "has no answer"),
        ([[1, 2], [3]], "numbers, but is [[1, 2], [3]]"),
    ],
)
def test_what_is_no_array_of_numbers_is_named(wrong, sentence):
    assert sentence in says(checks.expect_values, wrong, VALUES)


# --- Choices and arguments ------------------------------------------------------------------------


def test_a_choice_is_known_by_its_key_alone():
    key = checks.choice_key("c", "which")
    checks.expect_choice("c", key)
    checks.expect_choice(" C", key)
    assert "c" not in key.partition(":")[2] or len(key.partition(":")[2]) == 8
    assert (
        says(checks.expect_choice, "b", key, hint="Try.")
        == "Not yet: (b) is not the one. Hint: Try."
    )
    assert "one of the letters a, b, c, d, but is 'maybe'" in says(
        checks.expect_choice, "maybe", key
    )
    assert "cell above" in says(checks.expect_choice, ..., key)
    assert checks.choice_key("c", "other") != key


def test_a_changed_argument_is_noticed():
    def careless(phi):
        phi[0] = 0
        return phi

    assert "begin with a copy" in says(checks.expect_arguments_kept, careless, np.ones(3))
    checks.expect_arguments_kept(np.negative, np.ones(3))


# --- Schemes --------------------------------------------------------------------------------------


def sided(forward, backward):
    """Return a step that takes these sides for u > 0 and u < 0: 0 left, 1 right."""

    def step(phi, u, dx, dt):
        left, right = np.diff(phi, prepend=0) / dx, np.diff(phi, append=0) / dx
        return phi - dt * u * (left, right)[forward if u > 0 else backward]

    return step


def test_an_upwind_step_passes():
    checks.expect_upwind(sided(0, 1))


@pytest.mark.parametrize(
    ("step", "hint"),
    [
        (sided(1, 0), "looks downwind: it takes the right-hand difference at u > 0"),
        (sided(1, 1), "looks downwind: it takes the right-hand difference at u > 0"),
        (sided(0, 0), "looks downwind: it takes the left-hand difference at u < 0"),
        (lambda phi, u, dx, dt: phi - dt * u * np.gradient(phi, dx), "central difference"),
        (lambda phi, u, dx, dt: phi - dt * u * 2 * np.gradient(phi, dx), "both differences"),
        (lambda phi, u, dx, dt: sided(0, 1)(phi, u, dx, -dt), "The sign is wrong"),
        (lambda phi, u, dx, dt: sided(0, 1)(phi, u, 1, dt), "forgets to divide by dx"),
        (lambda phi, u, dx, dt: sided(0, 1)(phi, u, dx, 1), "forgets the time step"),
        (lambda phi, u, dx, dt: sided(0, 1)(phi, np.sign(u), dx, dt), "should be"),
        (lambda phi, u, dx, dt: phi, "Nothing has moved"),
    ],
)
def test_a_step_to_the_wrong_side_is_told_so(step, hint):
    assert hint in says(checks.expect_upwind, step)


def test_a_forgotten_speed_is_noticed():
    def step(phi, u, dx, dt):
        return sided(0, 0)(phi, 1, dx, dt) if u > 0 else sided(1, 1)(phi, 1, dx, dt)

    assert "forgets the speed" in says(checks.expect_upwind, step)


def test_an_order_is_observed():
    checks.expect_order(lambda n: 1 / n**1.9, 2)
    checks.expect_order(lambda n: 1e-16, 5)
    said = says(checks.expect_order, lambda n: 1 / n, 2, hint="Euler?")
    assert "should be 2 or more, but is 1.00: the errors are 0.05 (n = 20)" in said
    assert said.endswith("Hint: Euler?")


def test_new_wiggles_are_noticed():
    phi = RNG.normal(size=30)
    checks.expect_variation_kept(lambda a: (a + np.roll(a, 1)) / 2, phi)
    said = says(checks.expect_variation_kept, lambda a: a - 0.4 * np.gradient(a), np.eye(30)[3])
    assert "the total variation should be at most" in said
    assert "after step 1" in said


# --- Distances ------------------------------------------------------------------------------------

DISTANCES = {
    "circle": de.circle(),
    "rectangle": de.rectangle(((-1, -1), (1, 1))),
    "ellipse": de.ellipse(),
    "star of a polygon": de.polygon([(-1, -1), (1, -1), (0.2, 0), (1, 1), (-1, 1)]),
}
NOT_DISTANCES = {
    "a square": (lambda p: (p**2).sum(-1) - 1, "never changes faster than you walk"),
    "half": (lambda p: 0.5 * de.circle()(p), "the slope should be 1, but is 0.5"),
    "turned": (lambda p: -de.circle()(p), "the value should be negative, but is 1, at (0, 0)"),
    "corners": (lambda p: np.abs(p).max(-1) - 1, "Are corners measured to their vertex?"),
    "a union": (de.union(de.circle(), de.circle((0.5, 0))), "There the interface should be"),
    "shape": (lambda p: p, "an array of shape"),
}


@pytest.mark.parametrize("shape", DISTANCES)
def test_distances_are_recognised(shape):
    for seed in range(3):
        checks.expect_signed_distance(
            DISTANCES[shape], BOX, inside=[(-0.1, 0)], outside=BOX, rng=seed
        )
        checks.expect_unit_slope(DISTANCES[shape], BOX, rng=seed)


@pytest.mark.parametrize("shape", NOT_DISTANCES)
def test_what_is_no_distance_is_told_why(shape):
    field, sentence = NOT_DISTANCES[shape]
    assert sentence in says(checks.expect_signed_distance, field, BOX, inside=[(0, 0)])


def test_slope_one_is_less_than_a_distance():
    checks.expect_unit_slope(NOT_DISTANCES["corners"][0], BOX)
    checks.expect_unit_slope(lambda p: np.linalg.norm(p, axis=-1), ((0, 0, 0), (1, 1, 1)))
    assert "the slope" in says(checks.expect_unit_slope, NOT_DISTANCES["half"][0], BOX)


def test_an_interface_that_stays_passes():
    grid = de.Grid(BOX, 0.1)
    phi = de.circle()(grid.points)
    checks.expect_interface_kept(phi, 3 * phi)
    checks.expect_interface_kept(phi, phi + 0.003)


def test_an_interface_that_moves_is_noticed():
    phi = de.circle()(de.Grid(BOX, 0.1).points)
    assert "the move of a zero" in says(checks.expect_interface_kept, phi, phi + 0.008)
    assert "run past a node" in says(checks.expect_interface_kept, phi, phi + 0.2)
    assert "phi should be of the sign" in says(checks.expect_interface_kept, phi, -phi)


def test_the_seed_decides_on_the_points():
    asked = []

    def spy(points):
        asked.append(points)
        return de.circle()(points)

    for seed in (1, 1, 2):
        checks.expect_unit_slope(spy, BOX, rng=seed)
    first = asked[:: len(asked) // 3]
    assert np.array_equal(first[0], first[1])
    assert not np.array_equal(first[0], first[2])
