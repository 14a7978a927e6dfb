"""What students hand in, made from a course's own notebooks, and the points it should get.

Nothing here uses the grader: what a notebook is worth follows from how it was made.
"""

import ast
import copy
import json
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

REGION = re.compile(
    r"^[ \t]*### BEGIN (SOLUTION|HIDDEN TESTS)\n(.*?)^[ \t]*### END \1\n?", re.S | re.M
)
STUB = "# Your answer here."
DEFINED = re.compile(r"^def (\w+)\((.*)\):", re.M)

Notebook = dict[str, Any]


@dataclass
class Course:
    """A notebook of the course: as it was written, and the exercises with their points."""

    stem: str
    source: Notebook
    points: dict[str, float]

    @property
    def solved(self) -> Notebook:
        """What the best of students hands in."""
        return _rewritten(self.source, {"SOLUTION": r"\2", "HIDDEN TESTS": ""})

    @property
    def released(self) -> Notebook:
        """What the students were given."""
        return _rewritten(self.source, {"SOLUTION": None, "HIDDEN TESTS": ""})

    @property
    def functions(self) -> list[str]:
        """The exercises that ask for one function, which nothing further down uses."""
        cells = self.solved["cells"]
        found = []
        for i, cell in enumerate(cells):
            head = DEFINED.search(text(cell)) if name_of(cell) in self.points else None
            # Its own check comes next.
            below = "\n".join(
                text(other) for other in cells[i + 2 :] if other["cell_type"] == "code"
            )
            if (
                head
                and len(ast.parse(text(cell)).body) == 1
                and not re.search(rf"\b{head[1]}\b", below)
            ):
                found.append(name_of(cell))
        return found


def read(file: Path) -> Course:
    """Read a notebook of the source folder."""
    source = json.loads(file.read_text(encoding="utf-8"))
    points = {
        name_of(cell).removesuffix("-check"): float(cell["metadata"]["nbgrader"]["points"])
        for cell in source["cells"]
        if cell["metadata"].get("nbgrader", {}).get("grade")
    }
    return Course(file.stem, source, points)


def _rewritten(source: Notebook, regions: dict[str, str | None]) -> Notebook:
    """Return a notebook with its regions replaced; None stands for the stub."""

    def new(found: re.Match[str]) -> str:
        kept = regions[found[1]]
        if kept is None:
            return re.match(r"[ \t]*", found[0])[0] + STUB + "\n"
        return found.expand(kept)

    notebook = copy.deepcopy(source)
    for cell in notebook["cells"]:
        cell["source"] = REGION.sub(new, text(cell) + "\n").rstrip("\n")
    return notebook


def text(cell: dict[str, Any]) -> str:
    """Return what a cell holds."""
    return "".join(cell["source"])


def name_of(cell: dict[str, Any]) -> str:
    """Return the grade_id of a cell, or nothing."""
    return cell["metadata"].get("nbgrader", {}).get("grade_id", "")


@dataclass
class Draft:
    """A submission that is being made."""

    course: Course
    victim: str  # the exercise that suffers, of `course.functions`
    answers: list[Any] = field(default_factory=list)  # wrong ones, of tests/answers
    notebook: Notebook = field(default_factory=dict)
    lost: set[str] = field(default_factory=set)  # exercises without points
    says: str = ""  # what must be said on the page
    files: dict[str, bytes] | None = None  # by their names, if not the notebook under its own

    def __post_init__(self) -> None:
        self.notebook = self.course.solved

    @property
    def expected(self) -> dict[str, float] | None:
        """The points of each exercise; None if there is no notebook to mark."""
        if self.lost == {"all"}:
            return None
        return {one: 0.0 if one in self.lost else p for one, p in self.course.points.items()}

    @property
    def handed_in(self) -> dict[str, bytes]:
        """The files."""
        return (
            {f"{self.course.stem}.ipynb": as_bytes(self.notebook)}
            if self.files is None
            else self.files
        )

    def at(self, name: str) -> int:
        """Return where a cell stands."""
        return next(i for i, cell in enumerate(self.notebook["cells"]) if name_of(cell) == name)

    def cell(self, name: str) -> dict[str, Any]:
        """Return a cell by its grade_id."""
        return self.notebook["cells"][self.at(name)]

    def add(self, source: str, place: int) -> None:
        """Put a cell of the student's own before the one at a place."""
        self.notebook["cells"].insert(place, _cell(source))

    def does(self, body: str, says: str) -> None:
        """Let the victim's function do something that earns no points."""
        head = DEFINED.search(text(self.cell(self.victim)))
        lines = "\n".join(f"    {line}" for line in body.splitlines())
        self.cell(self.victim)["source"] = f"def {head[1]}({head[2]}):\n{lines}"
        self.lost, self.says = {self.victim}, says

    def begins(self, code: str, says: str = "") -> None:
        """Let the victim's cell, whose answer is right, begin with something else."""
        self.cell(self.victim)["source"] = f"{code}\n{text(self.cell(self.victim))}"
        self.says = says


def _cell(source: str) -> dict[str, Any]:
    return {
        "cell_type": "code",
        "metadata": {},
        "source": source,
        "outputs": [],
        "execution_count": None,
    }


def as_bytes(notebook: Notebook) -> bytes:
    """Return a notebook as a file holds it."""
    return json.dumps(notebook, ensure_ascii=False).encode()


KINDS: dict[str, Callable[[Draft], None]] = {}


def kind(make: Callable[[Draft], None]) -> Callable[[Draft], None]:
    """Note a kind of submission under its name."""
    KINDS[make.__name__.replace("_", " ").strip()] = make
    return make


@kind
def _good(draft: Draft) -> None:
    draft.says = "Passed."


@kind
def _empty(draft: Draft) -> None:
    draft.notebook = draft.course.released
    draft.lost, draft.says = {*draft.course.points}, "There is no answer here yet."


# One answer of those that are known to be wrong.
@kind
def _wrong(draft: Draft) -> None:
    answer = draft.answers[0]
    draft.cell(answer.exercise)["source"] = answer.source
    draft.lost, draft.says = {answer.exercise}, answer.says


@kind
def _broken(draft: Draft) -> None:
    draft.cell(draft.victim)["source"] = "def half(:\n    return"
    draft.lost, draft.says = {draft.victim}, "SyntaxError"


@kind
def _endless(draft: Draft) -> None:
    draft.does("while True:\n    pass", "seconds and was stopped")


@kind
def _endless_cell(draft: Draft) -> None:
    draft.cell(draft.victim)["source"] = "i = 1\nwhile i > 0:\n    i += 1"
    draft.lost, draft.says = {draft.victim}, "When the cell of your answer was run, it did not end"


@kind
def _stubborn(draft: Draft) -> None:
    inner = (
        "while True:\n    try:\n        while True:\n            pass\n    except BaseException:\n"
    )
    draft.does(f"{inner}        pass", "seconds and was stopped")


@kind
def _asks(draft: Draft) -> None:
    draft.does("return float(input('How much?'))", "Nobody is there to type it")


@kind
def _exits(draft: Draft) -> None:
    draft.does("import sys\nsys.exit()", "SystemExit")


@kind
def _quits(draft: Draft) -> None:
    draft.cell(draft.victim)["source"] = "quit()"
    draft.lost, draft.says = {draft.victim}, "Python itself came to its end"


@kind
def _quits_again_and_again(draft: Draft) -> None:
    place = draft.at(draft.victim)
    for i in range(12):
        draft.add(f"quit()  # {i}", place)
    names = [*draft.course.points]
    draft.lost = {*names[names.index(draft.victim) :]}
    draft.says = "nothing was run any more"


@kind
def _ends_python(draft: Draft) -> None:
    draft.does("import os\nos._exit(1)", "Python itself came to its end")


@kind
def _prints(draft: Draft) -> None:
    draft.does("while True:\n    print('here I am', '.' * 1000)", "printed without end")


@kind
def _shows(draft: Draft) -> None:
    draft.does("while True:\n    display('here I am')", "printed without end")


@kind
def _eats_memory(draft: Draft) -> None:
    draft.does("kept = []\nwhile True:\n    kept.append(np.ones(1_000_000))", "more memory than")


# What is kept under a name of the notebook would leave no room for the rest.
@kind
def _keeps_memory(draft: Draft) -> None:
    draft.does("while True:\n    kept.append(np.ones(1_000_000))", "more memory than")
    draft.begins("kept = []", draft.says)


@kind
def _takes_one_large_array(draft: Draft) -> None:
    draft.begins("large = np.ones(250_000_000)", "more memory than")
    draft.lost = {draft.victim}


@kind
def _deletes_files(draft: Draft) -> None:
    code = "import os, pathlib, shutil\npathlib.Path('a').write_text('b')\n"
    draft.begins(f"{code}shutil.rmtree(os.getcwd())\nos.chdir('/')")


@kind
def _leaves_processes(draft: Draft) -> None:
    code = "import subprocess\nsubprocess.Popen(['sleep', '1234'], start_new_session=True)\n"
    draft.begins(f"{code}subprocess.Popen('sleep 1234 & sleep 1234', shell=True)", "were ended")


@kind
def _warns(draft: Draft) -> None:
    draft.begins("import warnings\nwarnings.warn('this is only a warning')")


@kind
def _overwrites_checks(draft: Draft) -> None:
    draft.add("checks = 3", draft.at(draft.victim))
    names = [*draft.course.points]
    draft.lost = {*names[names.index(draft.victim) :]}
    draft.says = "gets another meaning in a cell of your own"


@kind
def _overwrites_at_the_end(draft: Draft) -> None:
    draft.add("np = 3\nsum = 4\nfrom math import *", len(draft.notebook["cells"]))
    draft.says = "gets another meaning in a cell of your own"


# To make the check of an empty answer content does not help.
@kind
def _edits_check(draft: Draft) -> None:
    draft.cell(draft.victim)["source"] = STUB
    draft.cell(f"{draft.victim}-check")["source"] = "print('Passed')"
    draft.cell(f"{draft.victim}-check")["metadata"]["nbgrader"]["points"] = 1000
    draft.lost, draft.says = {draft.victim}, "had been edited; the course's own was used"


@kind
def _skips_checks(draft: Draft) -> None:
    draft.notebook = draft.course.released
    for cell in draft.notebook["cells"]:
        cell["metadata"]["tags"] = ["skip-execution"]
    draft.lost = {*draft.course.points}


@kind
def _deletes_check(draft: Draft) -> None:
    del draft.notebook["cells"][draft.at(f"{draft.victim}-check")]
    draft.says = "had been deleted; it was put back"


@kind
def _deletes_answer(draft: Draft) -> None:
    del draft.notebook["cells"][draft.at(draft.victim)]
    draft.lost, draft.says = {draft.victim}, "is missing: its cell had been deleted"


@kind
def _deletes_both(draft: Draft) -> None:
    place = draft.at(draft.victim)
    del draft.notebook["cells"][place : place + 2]
    draft.lost, draft.says = {draft.victim}, "is missing: its cell had been deleted"


@kind
def _deletes_imports(draft: Draft) -> None:
    del draft.notebook["cells"][draft.at("imports")]
    draft.says = "The cell of imports had been deleted; it was put back"


# The answer stands in a cell of the student's own, and its place and check are gone.
@kind
def _answers_elsewhere(draft: Draft) -> None:
    place = draft.at(draft.victim)
    draft.add(text(draft.cell(draft.victim)), place)
    del draft.notebook["cells"][place + 1 : place + 3]


# An empty cell, and below it a copy with the answer.
@kind
def _doubles_answer(draft: Draft) -> None:
    place = draft.at(draft.victim)
    draft.notebook["cells"].insert(place, copy.deepcopy(draft.notebook["cells"][place]))
    draft.cell(draft.victim)["source"] = STUB
    draft.says = "was there 2 times"


# What was tried out below a check that had passed takes nothing away.
@kind
def _tries_below(draft: Draft) -> None:
    cells, place = draft.notebook["cells"], draft.at(draft.victim)
    right = copy.deepcopy(cells[place])
    draft.does("return 'tried'", "was there 2 times")
    cells[place], tried = right, cells[place]
    cells.insert(place + 2, tried)
    draft.lost = set()


@kind
def _doubles_check(draft: Draft) -> None:
    again = copy.deepcopy(draft.cell(f"{draft.victim}-check"))
    draft.notebook["cells"].append(again)
    draft.says = "was there 2 times"


@kind
def _moves_cells(draft: Draft) -> None:
    draft.notebook["cells"].reverse()
    draft.says = "The cells stood in another order"


@kind
def _changes_type(draft: Draft) -> None:
    for name in (draft.victim, f"{draft.victim}-check"):
        cell = draft.cell(name)
        cell["cell_type"] = "markdown"
        del cell["outputs"], cell["execution_count"]
    draft.says = "had become a markdown cell"


@kind
def _other_kernel(draft: Draft) -> None:
    draft.notebook["metadata"]["kernelspec"] = {"name": "julia-9", "display_name": "?"}
    draft.says = "asks for the kernel “julia-9”"


@kind
def _old_format(draft: Draft) -> None:
    cells = [
        {key: value for key, value in cell.items() if key not in ("execution_count", "id")}
        | ({"input": cell["source"], "language": "python"} if cell["cell_type"] == "code" else {})
        for cell in draft.notebook["cells"]
    ]
    old = {"nbformat": 3, "nbformat_minor": 0, "metadata": {"name": ""}}
    draft.notebook = {**old, "worksheets": [{"cells": cells, "metadata": {}}]}
    draft.says = "had the old format 3"


# Cells without what every cell has, and marks that are none.
@kind
def _damaged_cells(draft: Draft) -> None:
    draft.notebook["cells"] += [
        {"cell_type": "code"},
        {"cell_type": "unheard of", "source": 3, "metadata": 4},
        {"cell_type": "code", "source": ["1 + ", "1"], "metadata": {"nbgrader": "?"}},
        {"cell_type": "code", "source": "2", "metadata": {"nbgrader": {"grade_id": ["?"]}}},
        {"cell_type": "code", "source": "3", "metadata": {"nbgrader": {"grade_id": "unheard"}}},
    ]


def _only(draft: Draft, name: str, data: bytes, says: str) -> None:
    """Hand in a file that is no notebook of the course."""
    draft.files, draft.lost, draft.says = {name: data}, {"all"}, says


@kind
def _not_json(draft: Draft) -> None:
    whole = as_bytes(draft.notebook)
    _only(draft, f"{draft.course.stem}.ipynb", whole[: len(whole) // 2], "The file is damaged")


@kind
def _no_bytes(draft: Draft) -> None:
    _only(draft, f"{draft.course.stem}.ipynb", b"", "The file is empty")


@kind
def _json_of_another_kind(draft: Draft) -> None:
    _only(draft, "settings.ipynb", b'{"a": [1, 2]}', "JSON, but not a notebook")


@kind
def _no_chapter(draft: Draft) -> None:
    notebook = {**draft.notebook, "cells": [_cell("print('my diary')")]}
    _only(draft, "diary.ipynb", as_bytes(notebook), "belongs to no chapter of this course")


@kind
def _a_pdf(draft: Draft) -> None:
    _only(draft, f"{draft.course.stem}.pdf", b"%PDF-1.7", "No notebook was handed in")


@kind
def _a_pdf_in_disguise(draft: Draft) -> None:
    _only(draft, f"{draft.course.stem}.ipynb", b"%PDF-1.7", "The file is a PDF document")


@kind
def _broken_zip(draft: Draft) -> None:
    _only(draft, "homework.zip", b"PK\x03\x04 and then nothing", "The zip cannot be opened")


@kind
def _renamed(draft: Draft) -> None:
    draft.files = {"Kopie von Übung (final) 2.ipynb": as_bytes(draft.notebook)}


# Some editors begin a file with a mark; a notebook is none the worse for it.
@kind
def _begins_with_a_mark(draft: Draft) -> None:
    draft.begins("# déjà vu: ½")
    whole = b"\xef\xbb\xbf" + as_bytes(draft.notebook)
    draft.files = {f"{draft.course.stem}.ipynb": whole}


# The best of them counts, not the last; checkpoints and what macOS adds count nothing.
@kind
def _several_files(draft: Draft) -> None:
    name = draft.course.stem
    draft.files = {
        f"{name}.ipynb": as_bytes(draft.course.released),
        f"{name} (1).ipynb": as_bytes(draft.notebook),
        f"{name} (2).ipynb": as_bytes(draft.course.released),
        f".ipynb_checkpoints/{name}-checkpoint.ipynb": b"an old state",
        f"__MACOSX/._{name}.ipynb": b"\x00\x05\x16\x07",
    }
    draft.says = "2 different files for"


@kind
def _a_file_beside(draft: Draft) -> None:
    draft.begins("from my_helpers import seven\nassert seven == 7")
    draft.files = {
        f"{draft.course.stem}.ipynb": as_bytes(draft.notebook),
        "my_helpers.py": b"seven = 7",
    }
