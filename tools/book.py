"""Where the pages of the book are; as a program, checks that they were built and weighs them."""

import re
import sys
from pathlib import Path

from sphinx_external_toc.parsing import parse_toc_yaml

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "_build"
MAX_BYTES = 2_000_000  # a page with its own pictures: some seconds on a slow telephone line


def pages(root: Path = ROOT) -> list[str]:
    """Return the pages of the table of contents, such as `book/index`."""
    return list(parse_toc_yaml(root / "_toc.yml"))


def notebooks() -> list[Path]:
    """Return the committed notebooks of the book."""
    return sorted((ROOT / "book").rglob("[!.]*.ipynb"))


def executed(notebook: Path) -> Path:
    """Return the copy of a notebook that the build executed."""
    return BUILD / "jupyter_execute" / notebook.relative_to(ROOT)


def html_file(page: str, build: Path = BUILD) -> Path:
    """Return the built page."""
    return build / "html" / f"{page}.html"


def weight(file: Path) -> int:
    """Return the bytes of a page and of the book's own pictures on it."""
    own = set(re.findall(r'src="([^"]*_images/[^"]+)"', file.read_text(encoding="utf-8")))
    return file.stat().st_size + sum((file.parent / image).stat().st_size for image in own)


def problems(root: Path = ROOT) -> list[str]:
    """Say of each page that is missing, empty or too heavy what is wrong and what to do."""
    found = []
    for page in pages(root):
        file = html_file(page, root / "_build")
        if not file.exists() or "<h1>" not in file.read_text(encoding="utf-8"):
            found.append(f"{page}: the page was not built, or is empty: see the messages above")
        elif weight(file) > MAX_BYTES:
            found.append(
                f"{page}: {weight(file) / 1e6:.2f} MB is more than {MAX_BYTES / 1e6:.0f} MB. "
                "Give its sliders fewer steps, draw smaller figures, or split the page"
            )
    return found


def main() -> int:
    """Print the weights, then the address of the start page or the problems."""
    for page in pages():
        if html_file(page).exists():
            print(f"{weight(html_file(page)) / 1e6:6.2f} MB  {page}")
    if found := problems():
        print(*found, sep="\n", file=sys.stderr)
        return 1
    print(f"\nThe book is ready. Open {html_file(pages()[0]).as_uri()}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
