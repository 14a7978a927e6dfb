"""The figures of the book as the build drew them; as a program, makes them the tests' baseline."""

import base64
from collections.abc import Iterator
from pathlib import Path

import nbformat

from tools.book import ROOT, executed, notebooks

BASELINE = ROOT / "tests" / "baseline"


def figure_cells(notebook: Path) -> Iterator[nbformat.NotebookNode]:
    """Yield the code cells that show a figure, or that say they do."""
    for cell in nbformat.read(notebook, as_version=4).cells:
        if cell.cell_type == "code" and ("mystnb" in cell.metadata or pictures(cell)):
            yield cell


def pictures(cell: nbformat.NotebookNode) -> list[str]:
    """Return the pictures among the outputs of a cell, in base 64."""
    return [
        output.data["image/png"] for output in cell.outputs if "image/png" in output.get("data", {})
    ]


def name(cell: nbformat.NotebookNode) -> str:
    """Return the name of a cell's figure."""
    return str(cell.metadata.get("mystnb", {}).get("figure", {}).get("name", ""))


def fresh() -> dict[str, bytes]:
    """Return the figures of the last build by their names."""
    missing = [path.name for path in notebooks() if not executed(path).exists()]
    if missing:
        raise FileNotFoundError(f"{', '.join(missing)}: not built yet. Run `make book`")
    cells = [
        cell for path in notebooks() for cell in figure_cells(executed(path)) if pictures(cell)
    ]
    return {name(cell): base64.b64decode(pictures(cell)[0]) for cell in cells}


def main() -> None:
    """Write the baseline anew."""
    BASELINE.mkdir(exist_ok=True)
    for old in BASELINE.glob("*.png"):
        old.unlink()
    for figure, png in fresh().items():
        (BASELINE / f"{figure}.png").write_bytes(png)
    print(f"tests/baseline: {len(fresh())} figures. Look at each that `git status` shows changed.")


if __name__ == "__main__":
    main()
