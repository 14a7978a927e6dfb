"""A submitted notebook, put into the shape that nbgrader expects, and what had to be done to it."""

import copy
from collections import Counter

from nbformat import NotebookNode
from nbgrader import utils
from nbgrader.preprocessors import DeduplicateIds, NbGraderPreprocessor, OverwriteCells

from .course import Chapter


class _Cell:
    """A cell as nbgrader's gradebook would return it."""

    def __init__(self, cell: NotebookNode) -> None:
        self.name = cell.metadata.nbgrader.grade_id
        self.cell_type, self.source = cell.cell_type, cell.source
        self.locked = utils.is_locked(cell)
        self.checksum = cell.metadata.nbgrader.checksum
        self.max_score = cell.metadata.nbgrader.get("points")


class _Source:
    """Takes the gradebook's place: many processes would wait for each other at its database."""

    def __init__(self, chapter: Chapter) -> None:
        self.cells = chapter.cells

    def find_source_cell(self, name: str, *_: str) -> _Cell:
        return _Cell(self.cells[name])

    find_graded_cell = find_source_cell


class _Overwrite(OverwriteCells):
    """Puts back the cells that are not the student's to change, from the chapter."""

    def preprocess(
        self, nb: NotebookNode, resources: dict[str, object]
    ) -> tuple[NotebookNode, dict[str, object]]:
        self.notebook_id = self.assignment_id = ""
        self.gradebook = _Source(resources["chapter"])
        return NbGraderPreprocessor.preprocess(self, nb, resources)


def repair(chapter: Chapter, notebook: NotebookNode) -> list[str]:
    """Mend a notebook in place, and say what was wrong.

    What is gone, doubled, moved, edited or of another type is set right as far as it is the
    course's; the answers themselves, and cells of the student's own, stay as they are.
    """
    _known(chapter, notebook)
    found = [*_doubled(chapter, notebook), *_changed(chapter, notebook)]
    DeduplicateIds().preprocess(notebook, {})
    found += [*_sorted(chapter, notebook), *_missing(chapter, notebook)]
    _Overwrite().preprocess(notebook, {"chapter": chapter})
    notebook.metadata["kernelspec"] = copy.deepcopy(chapter.graded.metadata.get("kernelspec", {}))
    return found


def name(cell: NotebookNode) -> str:
    """Return a cell's grade_id, or nothing."""
    return cell.metadata.get("nbgrader", {}).get("grade_id", "")


def _known(chapter: Chapter, notebook: NotebookNode) -> None:
    """Give each cell of the chapter the metadata that it was handed out with."""
    for cell in notebook.cells:
        kept = chapter.cells.get(name(cell))
        cell.metadata = copy.deepcopy(kept.metadata) if kept else NotebookNode()


def _doubled(chapter: Chapter, notebook: NotebookNode) -> list[str]:
    count = Counter(filter(None, map(name, notebook.cells)))
    return [
        f"{_start(chapter.title_of(one))} was there {times} times; the last of these counts."
        for one, times in count.items()
        if times > 1
    ]


def _changed(chapter: Chapter, notebook: NotebookNode) -> list[str]:
    """Say which cells have another type, or another text though they are locked."""
    found = []
    for cell in notebook.cells:
        if not name(cell):
            continue
        kept, title = chapter.cells[name(cell)], _start(chapter.title_of(name(cell)))
        if cell.cell_type != kept.cell_type:
            found.append(f"{title} had become a {cell.cell_type} cell; it was run as a code cell.")
        ours = {_bare(kept.source), _bare(chapter.given[name(cell)])}
        if utils.is_locked(kept) and _bare(cell.source) not in ours:
            found.append(f"{title} had been edited; the course's own was used.")
    return list(dict.fromkeys(found))


def _sorted(chapter: Chapter, notebook: NotebookNode) -> list[str]:
    """Bring the chapter's cells back into their order; a cell of the student's own goes along."""
    blocks: list[list[NotebookNode]] = [[]]
    for cell in notebook.cells:
        if name(cell):
            blocks.append([])
        blocks[-1].append(cell)
    place = {one: i for i, one in enumerate(chapter.ids)}
    order = [place[name(block[0])] for block in blocks[1:]]
    doubled = any(cell.metadata.get("nbgrader") == {} for cell in notebook.cells)
    if order == sorted(order) or doubled:
        return []
    kept = sorted(blocks[1:], key=lambda block: place[name(block[0])])
    notebook.cells = [cell for block in [blocks[0], *kept] for cell in block]
    return ["The cells stood in another order; they were run in the order of the course."]


def _missing(chapter: Chapter, notebook: NotebookNode) -> list[str]:
    """Put back what the student is not to lack, and say so; an answer cannot be put back."""
    found = []
    for i, one in enumerate(chapter.ids):
        names = [name(cell) for cell in notebook.cells]
        if one in names:
            continue
        title, cell = _start(chapter.title_of(one)), chapter.cells[one]
        if utils.is_solution(cell):
            found.append(f"{title} is missing: its cell had been deleted.")
            if not utils.is_grade(cell):
                continue
        else:
            found.append(f"{title} had been deleted; it was put back.")
        # As far down as may be, for the answer may stand in a cell of the student's own.
        later = [names.index(other) for other in chapter.ids[i + 1 :] if other in names]
        first = not any(other in names for other in chapter.ids[:i])
        place = 0 if first else min(later, default=len(names))
        notebook.cells.insert(place, copy.deepcopy(cell))
    return found


def _bare(source: str) -> str:
    """Return a text without what editors change unasked."""
    return "\n".join(line.rstrip() for line in source.strip().splitlines())


def _start(text: str) -> str:
    return text[0].upper() + text[1:]
