"""The exercises: solutions pass, what is handed out does not, wrong answers get their sentence."""

import ast
import re
from pathlib import Path

import nbformat
import pytest

from distmesh_edu.checks import CheckFailed
from tests.answers import answers_to

ROOT = Path(__file__).resolve().parents[1] / "exercises"
SOURCES = {path.stem: path for path in sorted((ROOT / "source").glob("*/[!.]*.ipynb"))}
EACH = pytest.mark.parametrize("stem", SOURCES)

HEAD = re.compile(
    r"<!-- exercise: (?P<id>[a-z0-9-]+) -->\n## (?P<title>.+)\n\n"
    r"\*(?P<rung>Recall|Derive|Code|Experiment|Project), (?P<points>\d+) points?\.\* "
)
RUNGS = ["Recall", "Derive", "Code", "Experiment", "Project"]
TAGS = ["raises-exception", "hide-input", "remove-output"]
HIDDEN = re.compile(
    r"^ *### BEGIN HIDDEN TESTS\n.*?### END HIDDEN TESTS\n?", re.DOTALL | re.MULTILINE
)
SOLUTION = re.compile(r"^( *)### BEGIN SOLUTION\n(.*?)### END SOLUTION", re.DOTALL | re.MULTILINE)


def cells_of(stem, kind="source"):
    """Return the cells of a notebook by their identifiers."""
    path = ROOT / kind / stem / f"{stem}.ipynb"
    return {cell.id: cell for cell in nbformat.read(path, as_version=4).cells}


def exercises_of(stem):
    """Return id, title, rung and points of each exercise."""
    return [m for cell in cells_of(stem).values() if (m := HEAD.match(cell.source))]


def run(source, names):
    """Run a cell as a kernel would: its code stands in no file."""
    exec(compile(source, "<cell>", "exec"), names)


def told(stem, exercise, answer, kind="source", visible=False):
    """Return what the check says of an answer, "" if it passes."""
    cells, names = cells_of(stem, kind), {"__name__": "__main__"}
    run(cells["imports"].source, names)
    if given := cells.get(f"{exercise}-given"):
        run(given.source, names)
    if callable(answer):
        answer(names)
    else:
        run(answer, names)
    check = cells[f"{exercise}-check"].source
    try:
        run(HIDDEN.sub("", check) if visible else check, names)
    except CheckFailed as failed:
        return str(failed)
    return ""


ALL = [(stem, m["id"]) for stem in SOURCES for m in exercises_of(stem)]
CODE = [(stem, m["id"]) for stem in SOURCES for m in exercises_of(stem) if m["rung"] == "Code"]
ANSWERS = [(stem, answer) for stem in SOURCES for answer in answers_to(stem)]
EVERY = pytest.mark.parametrize(("stem", "exercise"), ALL)


def test_there_are_enough():
    assert len(SOURCES) == 7
    assert len(ALL) >= 45
    assert len(CODE) >= 25


@EACH
def test_a_notebook_is_a_ladder(stem):
    rungs = [m["rung"] for m in exercises_of(stem)]
    assert 5 <= len(rungs) <= 8
    assert rungs == sorted(rungs, key=RUNGS.index)
    assert set(rungs) == set(RUNGS)
    assert rungs.count("Project") == 1


@EACH
def test_a_notebook_has_no_outputs_and_plain_markdown(stem):
    for cell in cells_of(stem).values():
        assert not cell.get("outputs")
        if cell.cell_type == "markdown":
            assert not re.search(
                r"^(:::|```\{)|\{(ref|doc|numref|cite|eq)\}", cell.source, re.MULTILINE
            )


@EVERY
def test_an_exercise_has_all_its_parts(stem, exercise):
    cells = cells_of(stem)
    order = [name for name in cells if name.startswith(exercise)]
    head = HEAD.match(cells[f"{exercise}-text"].source)
    answer, check = cells[exercise], cells[f"{exercise}-check"]
    assert (
        order.index(f"{exercise}-text") < order.index(exercise) < order.index(f"{exercise}-check")
    )
    assert "<details><summary>Hint</summary>\n\n" in cells[f"{exercise}-text"].source
    assert answer.metadata.nbgrader.solution
    assert not answer.metadata.nbgrader.grade
    assert len(SOLUTION.findall(answer.source)) >= 1
    assert check.metadata.nbgrader.grade
    assert check.metadata.nbgrader.locked
    assert check.metadata.nbgrader.points == int(head["points"])
    assert check.metadata.tags == TAGS
    assert check.source.startswith(f'with checks.exercise("{head["title"]}"):\n')
    if head["rung"] in ("Code", "Project"):
        assert HIDDEN.search(check.source)
    for cell, width in ((answer, 80), (check, 96)):
        assert max(len(line) for line in cell.source.splitlines()) <= width


@EVERY
def test_a_solution_passes(stem, exercise):
    solution = cells_of(stem)[exercise].source
    assert told(stem, exercise, solution) == ""
    assert told(stem, exercise, solution, visible=True) == ""


@EVERY
def test_what_is_handed_out_earns_nothing_and_a_friendly_word(stem, exercise):
    stub = SOLUTION.sub(r"\1# Your answer here.", cells_of(stem)[exercise].source)
    said = told(stem, exercise, stub, visible=True)
    assert said.startswith("Not yet: ")
    assert "above" in said, "it does not say where to write the answer"


@EVERY
def test_a_cell_that_was_not_run_gets_a_friendly_word(stem, exercise):
    assert "cell above" in told(stem, exercise, "", visible=True)


@pytest.mark.parametrize(("stem", "exercise"), CODE)
def test_a_code_exercise_has_three_wrong_answers_and_another_right_one(stem, exercise):
    mine = [answer for answer in answers_to(stem) if answer.exercise == exercise]
    assert sum(not answer.right for answer in mine) >= 3
    assert sum(answer.right for answer in mine) >= 1
    assert len({answer.source for answer in mine}) == len(mine)
    # A sentence for each mistake, not one for all.
    assert len({answer.says for answer in mine if not answer.right}) >= 3


@pytest.mark.parametrize(("stem", "answer"), ANSWERS, ids=str)
def test_an_answer_is_told_what_it_should_be(stem, answer):
    said = told(stem, answer.exercise, lambda names: names.update(answer.names))
    if answer.right:
        assert said == ""
    else:
        assert said.startswith("Not yet: ")
        assert answer.says
        assert answer.says in said


def test_answers_name_exercises_that_exist():
    assert {(stem, answer.exercise) for stem, answer in ANSWERS} <= set(ALL)


@EACH
def test_answers_hold_as_cells_too(stem):
    """The sources, as the benchmark of the grading puts them into notebooks, define the names."""
    for answer in answers_to(stem):
        tree = ast.parse(answer.source)
        defined = {n.name for n in tree.body if isinstance(n, ast.FunctionDef)}
        defined |= {t.id for n in tree.body if isinstance(n, ast.Assign) for t in n.targets}
        assert set(answer.names) <= defined
