"""The course: its notebooks, their exercises, and what a student was given of them."""

import copy
import hashlib
import re
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import nbformat
import numpy as np
import scipy
from nbgrader import utils
from nbgrader.preprocessors import ClearHiddenTests, ClearOutput, ClearSolutions, ComputeChecksums
from traitlets.config import Config
from traitlets.config.loader import PyFileConfigLoader

import distmesh_edu

TITLE = re.compile(r"<!-- exercise: (\S+) -->\s*##\s+(.+)")


@dataclass(frozen=True)
class Exercise:
    """A graded cell, the cell its answer stands in, and what it is worth."""

    name: str  # the grade_id of the answer
    check: str  # the grade_id of the graded cell
    title: str
    points: float


@dataclass(frozen=True)
class Chapter:
    """One notebook of the course.

    `graded` is what is run: hidden checks, no solutions, and nbgrader's checksums. `released` holds
    the same cells as the students have them, `solved` as the teacher wrote them.
    """

    stem: str
    graded: nbformat.NotebookNode
    released: nbformat.NotebookNode
    solved: nbformat.NotebookNode
    beside: dict[str, bytes]

    @cached_property
    def ids(self) -> list[str]:
        """The grade_ids, from the first cell to the last."""
        return [cell.metadata.nbgrader.grade_id for cell in marked(self.graded)]

    @cached_property
    def cells(self) -> dict[str, nbformat.NotebookNode]:
        """The cells by their grade_ids."""
        return dict(zip(self.ids, marked(self.graded), strict=True))

    @cached_property
    def given(self) -> dict[str, str]:
        """What the student found in each cell."""
        return dict(zip(self.ids, (cell.source for cell in marked(self.released)), strict=True))

    @cached_property
    def title(self) -> str:
        """The first heading, without the word before the colon."""
        headings = (re.search(r"^# (.+)", cell.source, re.M) for cell in self.graded.cells)
        found = next((heading[1] for heading in headings if heading), self.stem)
        return found.removeprefix("Exercises:").strip()

    @cached_property
    def exercises(self) -> list[Exercise]:
        """The exercises, in their order."""
        titles = dict(TITLE.findall("\n\n".join(cell.source for cell in self.graded.cells)))
        return [
            Exercise(name, check, titles.get(name, name), float(cell.metadata.nbgrader.points))
            for check, cell in self.cells.items()
            if utils.is_grade(cell)
            for name in [check.removesuffix("-check")]
        ]

    @cached_property
    def points(self) -> float:
        """What the whole notebook is worth."""
        return sum(exercise.points for exercise in self.exercises)

    def title_of(self, grade_id: str) -> str:
        """Return how to speak of a cell, such as: the check of “One step”."""
        for exercise in self.exercises:
            if grade_id == exercise.name:
                return f"the answer to “{exercise.title}”"
            if grade_id == exercise.check:
                return f"the check of “{exercise.title}”"
            if grade_id == f"{exercise.name}-given":
                return f"the given cell of “{exercise.title}”"
        return "the cell of imports" if grade_id == "imports" else f"the cell “{grade_id}”"


@dataclass(frozen=True)
class Course:
    """All notebooks, by their stems, and nbgrader's settings."""

    root: Path
    chapters: dict[str, Chapter]
    config: Config

    @cached_property
    def own_ids(self) -> dict[str, set[str]]:
        """By stem, the grade_ids that no other notebook of the course has."""
        others = {
            stem: {i for other in self.chapters.values() if other.stem != stem for i in other.ids}
            for stem in self.chapters
        }
        return {stem: set(one.ids) - others[stem] for stem, one in self.chapters.items()}

    @cached_property
    def digest(self) -> str:
        """A fingerprint of all that decides about marks: exercises, checks, grader, versions."""
        folders = [self.root / "source", Path(distmesh_edu.__file__).parent, Path(__file__).parent]
        files = [self.root / "nbgrader_config.py"]
        files += [file for folder in folders for file in sorted(folder.rglob("*"))]
        found = hashlib.sha256(f"{sys.version} {np.__version__} {scipy.__version__}".encode())
        for file in files:
            if file.is_file() and not {"__pycache__", ".ipynb_checkpoints"} & set(file.parts):
                found.update(f"\n{file.name}\n".encode() + file.read_bytes())
        return found.hexdigest()


def marked(notebook: nbformat.NotebookNode) -> list[nbformat.NotebookNode]:
    """Return the cells that nbgrader knows."""
    return [cell for cell in notebook.cells if "grade_id" in cell.metadata.get("nbgrader", {})]


def settings(root: Path) -> Config:
    """Return nbgrader's settings for the course."""
    file = root / "nbgrader_config.py"
    return PyFileConfigLoader(file.name, str(root)).load_config() if file.exists() else Config()


def load(root: Path) -> Course:
    """Read a course: a folder with nbgrader_config.py and source/<stem>/<stem>.ipynb."""
    config = settings(root)
    files = sorted((root / "source").glob("*/[!.]*.ipynb"))
    if not files:
        raise FileNotFoundError(f"{root / 'source'} holds no <stem>/<stem>.ipynb")
    chapters = {}
    for file in files:
        beside = {
            other.relative_to(file.parent).as_posix(): other.read_bytes()
            for other in sorted(file.parent.rglob("*"))
            if other.is_file()
            and other.suffix != ".ipynb"
            and ".ipynb_checkpoints" not in other.parts
        }
        solved = nbformat.read(file, as_version=4)
        chapters[file.stem] = Chapter(file.stem, *given_and_kept(solved, config), beside)
    return Course(root, chapters, config)


def given_and_kept(
    solved: nbformat.NotebookNode, config: Config
) -> tuple[nbformat.NotebookNode, nbformat.NotebookNode, nbformat.NotebookNode]:
    """Return a notebook with stubs and hidden checks, without these, and as it was."""
    resources: dict[str, Any] = {}
    graded = copy.deepcopy(solved)
    for step in (ClearSolutions, ClearOutput, ComputeChecksums):
        graded, resources = step(config=config).preprocess(graded, resources)
    released, _ = ClearHiddenTests(config=config).preprocess(copy.deepcopy(graded), resources)
    return graded, released, solved
