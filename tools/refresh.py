"""Execute the committed notebooks afresh, in place, and keep only what is the same each time."""

import os
import sys

import nbformat
from nbclient import NotebookClient

from tools.book import ROOT, notebooks

KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}
# Views and states, whose identifiers are new in each run.
WIDGETS = "application/vnd.jupyter.widget"


def tidy(notebook: nbformat.NotebookNode) -> None:
    """Take out widgets, versions and what editors add. The cells keep their identifiers."""
    notebook.metadata = nbformat.from_dict(
        {"kernelspec": KERNEL, "language_info": {"name": "python"}}
    )
    for cell in notebook.cells:
        for key in ("execution", "collapsed", "scrolled", "trusted", "ExecuteTime"):
            cell.metadata.pop(key, None)
        merge_streams(cell)
        for output in cell.get("outputs", []):
            for mime in [mime for mime in output.get("data", {}) if mime.startswith(WIDGETS)]:
                del output.data[mime]
                output.metadata.pop(mime, None)


def merge_streams(cell: nbformat.NotebookNode) -> None:
    """Join what a cell printed: how it was cut in pieces on its way is chance."""
    merged: list[nbformat.NotebookNode] = []
    for output in cell.get("outputs", []):
        last = merged[-1] if merged else {}
        if output.output_type == "stream" and last.get("name") == output.name:
            last.text += output.text
        else:
            merged.append(output)
    if "outputs" in cell:
        cell.outputs = merged


def main() -> int:
    """Refresh the notebooks named on the command line, or all of them."""
    # Live: with the variable set, the notebooks would hold the pages' frames, some megabytes.
    os.environ.pop("DISTMESH_EDU_STATIC", None)
    chosen = [path for path in notebooks() if not sys.argv[1:] or path.stem in sys.argv[1:]]
    for path in chosen:
        print(f"refreshing {path.relative_to(ROOT)}", flush=True)
        notebook = nbformat.read(path, as_version=4)
        place = {"metadata": {"path": str(path.parent)}}
        NotebookClient(notebook, timeout=600, record_timing=False, resources=place).execute()
        tidy(notebook)
        nbformat.validate(notebook)
        nbformat.write(notebook, path)
    return 0 if chosen else "No such notebook in book/."


if __name__ == "__main__":
    sys.exit(main())
