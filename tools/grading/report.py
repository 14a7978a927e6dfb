"""The table of all students, and a page for each."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import feedback

if TYPE_CHECKING:
    from .course import Chapter

FORMULA = ("=", "+", "-", "@", "\t", "\r")


@dataclass
class Marked:
    """A notebook of a student: where it lay, and what came out."""

    chapter: Chapter
    place: str
    result: dict[str, Any]

    @property
    def points(self) -> float:
        """The sum over its exercises."""
        return sum(one["points"] or 0.0 for one in self.result.get("exercises", {}).values())

    @property
    def remarks(self) -> list[str]:
        """What is to be said of the whole notebook."""
        if "error" in self.result:
            last = str(self.result["error"]).strip().splitlines()[-1]
            return [f"The notebook could not be marked: {last}."]
        by_hand = sum(one["points"] is None for one in self.result["exercises"].values())
        said = [f"{by_hand} of its answers are to be read by a person."] if by_hand else []
        return [*self.result["remarks"], *said]

    @property
    def incidents(self) -> list[str]:
        """What a teacher should know of single exercises."""
        titles = {one.name: one.title for one in self.chapter.exercises}
        each = self.result.get("exercises", {})
        if each and not any(one["answered"] for one in each.values()):
            return ["No exercise is answered."]
        return [f"{titles[name]}: {one['says']}" for name, one in each.items() if one["stopped"]]


@dataclass
class Sheet:
    """All that is known of a student."""

    name: str
    number: str
    notebooks: list[Marked] = field(default_factory=list)  # one for a chapter
    troubles: list[str] = field(default_factory=list)  # of files that are no such notebooks
    page: str = ""

    def of(self, chapter: Chapter) -> Marked | None:
        """Return the notebook of a chapter, or None."""
        return next((one for one in self.notebooks if one.chapter.stem == chapter.stem), None)

    @property
    def total(self) -> float:
        """The points of all notebooks."""
        return sum(one.points for one in self.notebooks)

    @property
    def notes(self) -> list[str]:
        """All remarks, with the notebook they are about."""
        return self.troubles + [
            f"{one.chapter.stem}: {remark}"
            for one in self.notebooks
            for remark in one.remarks + one.incidents
        ]


def chapters(sheets: list[Sheet]) -> list[Chapter]:
    """Return the chapters of which anyone handed in a notebook."""
    found = {one.chapter.stem: one.chapter for sheet in sheets for one in sheet.notebooks}
    return [found[stem] for stem in sorted(found)]


def write(sheets: list[Sheet], out: Path) -> Path:
    """Write grades.csv and feedback/<student>.html, and return the path of the table."""
    pages = out / "feedback"
    pages.mkdir(parents=True, exist_ok=True)
    for old in pages.glob("*.html"):
        old.unlink()
    _name_pages(sheets)
    handed = chapters(sheets)
    for sheet in sheets:
        (pages / sheet.page).write_text(feedback.page(sheet, handed), encoding="utf-8")
    table = out / "grades.csv"
    # The mark at the beginning lets spreadsheets know that it is UTF-8.
    with table.open("w", encoding="utf-8-sig", newline="") as file:
        csv.writer(file).writerows(rows(sheets, handed))
    return table


def rows(sheets: list[Sheet], handed: list[Chapter]) -> list[list[str]]:
    """Return the table: student, id, total, of, each notebook and its exercises, page, notes."""
    columns = [
        name
        for chapter in handed
        for name in [chapter.stem, *(f"{chapter.stem}/{one.name}" for one in chapter.exercises)]
    ]
    table = [["student", "id", "total", "of", *columns, "page", "notes"]]
    most = feedback.number(sum(chapter.points for chapter in handed))
    for sheet in sheets:
        points = [cell for chapter in handed for cell in _points(sheet.of(chapter), chapter)]
        who = [_text(sheet.name), _text(sheet.number)]
        total = [feedback.number(sheet.total), most]
        table.append([*who, *total, *points, sheet.page, _text(" | ".join(sheet.notes))])
    return table


def _points(marked: Marked | None, chapter: Chapter) -> list[str]:
    if marked is None:
        return [""] * (1 + len(chapter.exercises))
    each = marked.result.get("exercises", {})
    found = [each.get(one.name, {"points": 0.0})["points"] for one in chapter.exercises]
    return [
        feedback.number(marked.points),
        *("" if p is None else feedback.number(p) for p in found),
    ]


def _text(text: str) -> str:
    """Return a text that no spreadsheet takes for a formula."""
    return f"'{text}" if text.startswith(FORMULA) else text


def _name_pages(sheets: list[Sheet]) -> None:
    """Give each page the student's name, as far as file systems allow it."""
    taken: set[str] = set()
    for sheet in sheets:
        bare = re.sub(r'[<>:"/\\|?*\x00-\x1f]+', "_", sheet.name).strip(" .")[:80] or "student"
        name, count = bare, 1
        while name.casefold() in taken:
            count += 1
            name = f"{bare} {count}"
        taken.add(name.casefold())
        sheet.page = f"{name}.html"
