"""How a notebook of exercises becomes a page: numbered exercises, folded checks, a switch.

The notebooks hold plain Markdown, for whoever works in JupyterLab. What Sphinx can do beyond that
is added here, while it reads them; the files stay as they are, and so does the notebook that the
page offers for download.
"""

import re
from pathlib import Path

import nbformat
from nbformat.v4 import new_markdown_cell
from sphinx.application import Sphinx
from sphinx.util import logging

EXERCISE = re.compile(
    r"<!-- exercise: (?P<name>[a-z0-9]+(?:-[a-z0-9]+)*) -->\n+"
    r"## (?P<title>[^\n]+)\n+(?P<text>.+)",
    re.DOTALL,
)
BEGINS = "<!-- exercise:"
# Lines of nbgrader's: a hidden check never goes onto a page, not even with the solutions.
HIDDEN = re.compile(r"^.*BEGIN HIDDEN TESTS(?:.|\n)*?END HIDDEN TESTS.*\n?", re.MULTILINE)
MARK = re.compile(r"^.*(?:BEGIN|END) SOLUTION.*\n?", re.MULTILINE)

logger = logging.getLogger(__name__)


def is_released(path: Path) -> bool:
    """Return whether a page is a notebook that is handed to students."""
    return path.suffix == ".ipynb" and path.parent.parent.name == "release"


def rewrite(app: Sphinx, docname: str, source: list[str]) -> None:
    """Give a page of exercises its numbers and labels, as Sphinx reads it."""
    path = Path(app.env.doc2path(docname))
    if not is_released(path):
        return
    notebook = nbformat.reads(source[0], as_version=4)
    solutions = published(app, path) if app.config.publish_solutions else {}
    notebook.cells[0].source += offer(path.name)
    cells = []
    for cell in notebook.cells:
        if cell.cell_type == "markdown" and cell.source.startswith(BEGINS):
            cell.source = numbered(cell.source, path.stem[:2], docname)
        elif cell.metadata.get("nbgrader", {}).get("grade"):
            cell.metadata["mystnb"] = {
                "code_prompt_show": "Show the check",
                "code_prompt_hide": "Hide the check",
            }
        cells.append(cell)
        if solution := solutions.get(grade_id(cell)):
            cells.append(folded(solution, f"{cell.id}-solution"))
    notebook.cells = cells
    source[0] = nbformat.writes(notebook)


def offer(name: str) -> str:
    """Return the sentence that offers the notebook itself."""
    return (
        f"\n\n[Download this notebook](path:{name}) to work on it in JupyterLab. "
        "This page shows it as it is handed out."
    )


def numbered(text: str, chapter: str, docname: str) -> str:
    """Return an exercise's cell with its heading, and below it a numbered exercise with a label."""
    found = EXERCISE.fullmatch(text)
    if not found:
        logger.warning(
            "an exercise begins with a line such as <!-- exercise: upwind-step -->, a line such as "
            "## One step, and its text; found %r",
            text[:80],
            location=docname,
            type="book",
        )
        return text
    fence = outer_fence(found["text"])
    return (
        f"## {found['title']}\n\n{fence}{{exercise}}\n:label: ex-{chapter}-{found['name']}\n\n"
        f"{found['text'].rstrip()}\n{fence}"
    )


def outer_fence(text: str) -> str:
    """Return a fence that is longer than any within a text."""
    return "`" * max(3, 1 + max(map(len, re.findall("`+", text)), default=0))


def published(app: Sphinx, path: Path) -> dict[str, nbformat.NotebookNode]:
    """Return the answer cells of a released notebook's source by their grade_id."""
    source = path.parents[2] / "source" / path.parent.name / path.name
    app.env.note_dependency(str(source))
    cells = nbformat.read(source, as_version=4).cells
    return {
        grade_id(cell): cell for cell in cells if cell.metadata.get("nbgrader", {}).get("solution")
    }


def grade_id(cell: nbformat.NotebookNode) -> str:
    """Return the name by which nbgrader knows a cell, or nothing."""
    return str(cell.metadata.get("nbgrader", {}).get("grade_id", ""))


def folded(cell: nbformat.NotebookNode, name: str) -> nbformat.NotebookNode:
    """Return a cell that shows a solution to whoever opens it, and no hidden check."""
    text = MARK.sub("", HIDDEN.sub("", cell.source)).strip("\n")
    if cell.cell_type == "code":
        fence = outer_fence(text)
        text = f"{fence}python\n{text}\n{fence}"
    inside = f'<details class="solution"><summary>A solution</summary>\n\n{text}\n\n</details>'
    return new_markdown_cell(inside, id=name)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the above, and the one switch that publishes the solutions."""
    # "env": whoever turns it has all pages read anew.
    app.add_config_value("publish_solutions", False, "env", bool)
    app.connect("source-read", rewrite)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
