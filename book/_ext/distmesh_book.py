"""What the book asks of Sphinx beyond its configuration: fresh caches, one alt text a figure."""

import hashlib
import html
import os
import shutil
import sys
from collections.abc import Iterable
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx.transforms import SphinxTransform
from sphinx.util import logging

ROOT = Path(__file__).resolve().parents[2]
PASSED = "passed"  # a file beside the doctrees: the last build ended without a warning

logger = logging.getLogger(__name__)


def digest(files: Iterable[Path]) -> str:
    """Return a short hash of the files' names and contents."""
    found = hashlib.sha256(sys.version.encode())
    for file in sorted(file for file in files if file.is_file()):
        name = file.relative_to(ROOT).as_posix()
        if "__pycache__" not in name:
            found.update(f"{name}\0{file.stat().st_size}\0".encode() + file.read_bytes())
    return found.hexdigest()[:16]


def choose_caches(app: Sphinx, config: Config) -> None:
    """Execute the notebooks anew when the library changed; write the pages anew when an asset did.

    Jupyter's cache looks at the code of a notebook alone. It would go on showing the old numbers.
    """
    caches = Path(app.outdir).parent / "notebook_cache"
    library = (ROOT / "distmesh_edu").rglob("*")
    cache = caches / digest([*library, ROOT / "requirements" / "lock.txt"])
    for old in caches.glob("*"):
        if old != cache:
            shutil.rmtree(old)
    config.nb_execution_cache_path = str(cache)
    config.book_assets = digest((ROOT / "book" / "_assets").rglob("*"))


def forget_unless_passed(app: Sphinx, config: Config) -> None:
    """Read every page again after a build that warned, failed or was stopped.

    Sphinx does not read an unchanged page twice, so a second `-W` build would be silent about it.
    """
    passed = Path(app.doctreedir) / PASSED
    if not passed.exists():
        (Path(app.doctreedir) / "environment.pickle").unlink(missing_ok=True)
    passed.unlink(missing_ok=True)


def note_if_passed(app: Sphinx, exception: Exception | None) -> None:
    """Note that this build ended without a warning."""
    if exception is None and not app._warncount:
        (Path(app.doctreedir) / PASSED).touch()


class AltText(SphinxTransform):
    """Give a slider's picture the alt text of its cell; without one, warn.

    MyST-NB hands `mystnb.image.alt` to plain pictures only; the text stands once, in the metadata.
    """

    default_priority = 700

    def apply(self, **kwargs: object) -> None:
        """Treat every code cell that shows a picture."""
        for cell in self.document.findall(nodes.container):
            if cell.get("nb_element") != "cell_code":
                continue
            explorers = [
                raw for raw in cell.findall(nodes.raw) if 'class="explore"' in raw.astext()
            ]
            if not explorers and not any(cell.findall(nodes.image)):
                continue
            alt = cell["cell_metadata"].get("mystnb", {}).get("image", {}).get("alt", "").strip()
            if not alt:
                self.warn(
                    cell,
                    "has a figure, but no alt text: say in its metadata, as mystnb.image.alt, "
                    "what the figure shows",
                )
            for explorer in explorers:
                self.fill(cell, explorer, alt)

    def fill(self, cell: nodes.container, explorer: nodes.raw, alt: str) -> None:
        """Write the alt text into the one place that is kept for it."""
        place = '<img class="explore-picture" alt=""'
        text = explorer.astext()
        if text.count(place) != 1:
            self.warn(
                cell,
                f"has an explorer with {text.count(place)} places for its alt text, not 1: {place}",
            )
        filled = text.replace(place, place.replace('""', f'"{html.escape(alt)}"'))
        explorer.replace_self(nodes.raw("", filled, **explorer.attributes))

    def warn(self, cell: nodes.container, what: str) -> None:
        """Warn, which fails a `-W` build."""
        logger.warning("code cell %d %s", cell["cell_index"], what, location=cell, type="book")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the above."""
    # Here, not in the Makefile: the plain `jupyter-book build .` gives the same pages.
    os.environ["DISTMESH_EDU_STATIC"] = "1"
    app.add_config_value("book_assets", "", "html")
    app.connect("config-inited", choose_caches, priority=100)
    app.connect("config-inited", forget_unless_passed)
    app.connect("build-finished", note_if_passed)
    app.add_transform(AltText)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
