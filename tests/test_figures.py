"""The notebooks and their figures: what each must say, and that each looks as it did."""

import ast
import re
import sys
from pathlib import Path

import nbformat
import pytest
from matplotlib.testing.compare import compare_images

from tools.book import BUILD, notebooks
from tools.figures import BASELINE, figure_cells, fresh, name, pictures

MAX_IMPORT_LINES = 6
MAX_CELL_LINES = 14
MIN_CAPTION = 20
MIN_ALT = 40
# The root of the mean square of the differences, of 255. The pinned packages draw the same pixels
# each time; one black pixel turned white, in a picture of 900 by 600, already differs by 0.35.
TOLERANCE = 0.1
# A cell tagged "ties" shows a mesh that a tie in the Delaunay triangulation decides:
# where a processor rounds otherwise, it has other triangles, of the same sizes in the same places.
TIES_TOLERANCE = 25.0
TIES_TAG = "ties"

NOTEBOOKS = pytest.mark.parametrize("path", notebooks(), ids=lambda path: path.stem)


def code_cells(path: Path) -> list[nbformat.NotebookNode]:
    return [cell for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "code"]


def test_there_are_notebooks():
    assert notebooks()


@NOTEBOOKS
def test_a_figure_has_name_caption_and_alt_text(path):
    for cell in figure_cells(path):
        where = f"{path.name}, the cell that begins {cell.source[:40]!r}"
        mystnb = cell.metadata.get("mystnb", {})
        caption = mystnb.get("figure", {}).get("caption", "")
        alt = mystnb.get("image", {}).get("alt", "")
        assert re.fullmatch(r"fig-[a-z0-9]+(-[a-z0-9]+)*", name(cell)), (
            f"{where}: mystnb.figure.name, fig-..."
        )
        assert len(caption) >= MIN_CAPTION, f"{where}: mystnb.figure.caption says what is seen"
        assert len(alt) >= MIN_ALT, f"{where}: mystnb.image.alt says it to who does not see it"
        assert alt != caption, f"{where}: the alt text describes, the caption interprets"
        assert len(pictures(cell)) == 1, f"{where}: one figure to a cell"


def test_the_names_of_figures_are_unique():
    names = [name(cell) for path in notebooks() for cell in figure_cells(path)]
    assert len(names) == len(set(names)), sorted(n for n in names if names.count(n) > 1)


@NOTEBOOKS
def test_the_first_code_cell_holds_the_imports(path):
    first, *others = code_cells(path)
    assert lines(first) <= MAX_IMPORT_LINES
    assert imports(first), "the first code cell holds the imports"
    assert all(alias.name != "*" for node in imports(first) for alias in node.names)
    assert [cell.source for cell in others if imports(cell)] == [], (
        "imports after the first code cell"
    )


def imports(cell: nbformat.NotebookNode) -> list[ast.Import | ast.ImportFrom]:
    nodes = ast.walk(ast.parse(cell.source))  # a magic is a syntax error
    return [node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)]


@NOTEBOOKS
def test_cells_are_short(path):
    long = [cell.source for cell in code_cells(path) if lines(cell) > MAX_CELL_LINES]
    assert long == []


def lines(cell: nbformat.NotebookNode) -> int:
    return sum(bool(line.strip()) for line in cell.source.splitlines())


@NOTEBOOKS
def test_it_is_committed_executed_and_clean(path):
    notebook = nbformat.read(path, as_version=4)
    counts = [cell.execution_count for cell in notebook.cells if cell.cell_type == "code"]
    # nbval compares nothing where there is no count.
    assert counts == list(range(1, len(counts) + 1)), (
        "not executed from top to bottom: run `make refresh`"
    )
    assert "widgets" not in notebook.metadata, "holds the state of widgets: run `make refresh`"
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    mimes = {mime for output in outputs for mime in output.get("data", {})}
    assert not any("widget" in mime for mime in mimes), "holds views of widgets: run `make refresh`"
    assert "text/html" not in mimes, "holds a page's frames: run `make refresh`"
    assert not [cell for cell in notebook.cells if "execution" in cell.metadata], (
        "holds times: `make refresh`"
    )


@pytest.mark.skipif(
    sys.platform != "linux", reason="the baseline was drawn on Linux; fonts differ elsewhere"
)
def test_the_figures_look_as_they_did():
    figures = fresh()
    ties = {
        name(cell)
        for path in notebooks()
        for cell in figure_cells(path)
        if TIES_TAG in cell.metadata.get("tags", [])
    }
    kept = {file.stem for file in BASELINE.glob("*.png")}
    remedy = "Look at it; if it is meant, run `make baseline` and commit tests/baseline"
    assert figures.keys() - kept == set(), f"figures without a baseline. {remedy}"
    assert kept - figures.keys() == set(), f"baselines that no figure of the book has. {remedy}"
    changed = [
        figure for figure, png in figures.items() if not looks_alike(figure, png, figure in ties)
    ]
    assert changed == [], (
        f"figures that changed: the differences are in _build/figure_differences. {remedy}"
    )


def looks_alike(figure: str, png: bytes, ties: bool) -> bool:
    """Compare a figure with its baseline; where they differ, leave both and their difference."""
    folder = BUILD / "figure_differences" / figure
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    (folder / "now.png").write_bytes(png)
    (folder / "baseline.png").write_bytes((BASELINE / f"{figure}.png").read_bytes())
    alike = differs(folder / "baseline.png", folder / "now.png", ties) is None
    if alike:
        for file in folder.iterdir():
            file.unlink()
        folder.rmdir()
    return alike


def differs(expected: Path, actual: Path, ties: bool = False) -> str | None:
    """Return what is different between two pictures, or None."""
    try:
        return compare_images(str(expected), str(actual), TIES_TOLERANCE if ties else TOLERANCE)
    except Exception as error:  # of another size
        return str(error)
