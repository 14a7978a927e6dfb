"""From the bytes of a file to the cells of a notebook, or to what is wrong with the file."""

import json
from collections import Counter
from typing import Any

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook, new_raw_cell

from .course import Course

CELLS = {"code": new_code_cell, "markdown": new_markdown_cell, "raw": new_raw_cell}
BEGINNINGS = {
    b"PK\x03\x04": "a zip archive or an office document",
    b"%PDF": "a PDF document",
    b"<!DOCTYPE": "a web page",
    b"<html": "a web page",
    b"\x89PNG": "a picture",
    b"\xff\xd8": "a picture",
}
SUFFIXES = {
    ".pdf": "a PDF document",
    ".html": "a web page",
    ".htm": "a web page",
    ".py": "a Python program",
    ".docx": "an office document",
    ".odt": "an office document",
    ".txt": "a text",
}
ANEW = "Open it in JupyterLab, save it, and hand it in anew."
WANTED = "Hand in the notebook itself, the file that ends in .ipynb."


class NotANotebook(Exception):  # noqa: N818  (nothing went wrong here)
    """Says in plain words what a file is instead."""


def parsed(data: bytes) -> dict[str, Any]:
    """Return a notebook's JSON, with its cells under `cells`, or raise `NotANotebook`."""
    if not data.strip():
        raise NotANotebook(f"The file is empty. {WANTED}")
    for beginning, kind in BEGINNINGS.items():
        if data.lstrip()[: len(beginning)].lower() == beginning.lower():
            raise NotANotebook(f"The file is {kind}, not a notebook. {WANTED}")
    try:
        raw = json.loads(_text(data))
    except (ValueError, RecursionError):
        message = "The file is damaged: it is not the JSON that notebooks are written in."
        raise NotANotebook(f"{message} {ANEW}") from None
    if not isinstance(raw, dict) or not isinstance(raw.get("nbformat"), int):
        raise NotANotebook(f"The file is JSON, but not a notebook. {WANTED}")
    if raw["nbformat"] > 4:
        message = (
            f"The notebook has format {raw['nbformat']}, which is newer than what is known here."
        )
        raise NotANotebook(f"{message} {ANEW}")
    if raw["nbformat"] < 4:
        raw = _upgraded(raw)
    cells = raw.get("cells")
    if not isinstance(cells, list) or not all(isinstance(cell, dict) for cell in cells):
        raise NotANotebook("The notebook is damaged: it has no list of cells.")
    return raw


def _text(data: bytes) -> str:
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16")
    return data.decode("utf-8-sig")


def _upgraded(raw: dict[str, Any]) -> dict[str, Any]:
    """Return a notebook of an old format in the present one."""
    old = raw["nbformat"]
    try:
        raw = nbformat.convert(nbformat.from_dict(raw), 4)
    except Exception as error:  # whatever a damaged notebook leads to
        message = f"The notebook has the old format {old}, and cannot be converted ({error})."
        raise NotANotebook(f"{message} {ANEW}") from error
    raw["old_format"] = old
    return raw


def grade_id(cell: dict[str, Any]) -> str:
    """Return what nbgrader calls a cell, or nothing."""
    metadata = cell.get("metadata")
    marks = metadata.get("nbgrader") if isinstance(metadata, dict) else None
    found = marks.get("grade_id") if isinstance(marks, dict) else None
    return found if isinstance(found, str) else ""


def chapter_of(raw: dict[str, Any], course: Course) -> str:
    """Return the stem of the notebook that this one is, going by its cells alone."""
    ids = {grade_id(cell) for cell in raw["cells"]}
    shared = Counter({stem: len(ids & own) for stem, own in course.own_ids.items()})
    stem, count = shared.most_common(1)[0]
    if not count:
        raise NotANotebook(
            "The notebook belongs to no chapter of this course: none of its cells bears the mark "
            "of an exercise. Copy the answers into the notebook that was given out, and hand it in."
        )
    return stem


def notebook(raw: dict[str, Any]) -> nbformat.NotebookNode:
    """Return the cells alone, whatever else the file says: no outputs, no tags, no attachments."""
    made = new_notebook()
    for cell in raw["cells"]:
        source = cell.get("source", "")
        text = "".join(map(str, source)) if isinstance(source, list) else str(source)
        one = CELLS.get(cell.get("cell_type"), new_raw_cell)(text)
        if name := grade_id(cell):
            one.metadata["nbgrader"] = {"grade_id": name}
        made.cells.append(one)
    return made


def remarks(raw: dict[str, Any]) -> list[str]:
    """Say what is unusual about the file itself."""
    found = []
    if "old_format" in raw:
        found.append(f"The notebook had the old format {raw['old_format']}; it was converted.")
    metadata = raw.get("metadata")
    spec = metadata.get("kernelspec") if isinstance(metadata, dict) else None
    name = str(spec.get("name", "")) if isinstance(spec, dict) else ""
    if name not in ("", "python", "python3"):
        found.append(
            f"The notebook asks for the kernel “{name}”; it was run with the course's own."
        )
    return found
