"""The exercises as students get them: the released notebooks, and one zip with all they need.

The sources hold solutions and hidden checks; what is released holds neither.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import nbformat
from nbgrader.apps import NbGraderAPI
from traitlets.config import Config
from traitlets.config.loader import PyFileConfigLoader

from tools.book import BUILD, ROOT
from tools.refresh import KERNEL

COURSE = ROOT / "exercises"
KIT = BUILD / "distmesh_edu_exercises.zip"
STUDENTS = "students.txt"  # what the zip's README says
PACKAGE = ["pyproject.toml", "README.md", "LICENSE", "distmesh_edu"]  # what the wheel is made of
# The earliest time that a zip can hold: the same files give the same bytes on any day.
ZIP_TIME = (1980, 1, 1, 0, 0, 0)
EPOCH = "315532800"  # the same in seconds, as wheels want it
# A misspelt mark hides nothing, and says no word about it.
MARK = re.compile(r"^\s*#+ *(BEGIN|END)\b.*$", re.IGNORECASE | re.MULTILINE)


def notebooks(kind: str, course: Path = COURSE) -> list[Path]:
    """Return the notebooks of a course, in order; the kind is "source" or "release"."""
    return sorted(path for path in (course / kind).glob("*/*.ipynb") if path.name[0] != ".")


def settings(course: Path, folder: Path) -> Config:
    """Return the course's own settings for nbgrader, at work in another folder."""
    config = PyFileConfigLoader("nbgrader_config.py", path=str(course)).load_config()
    config.CourseDirectory.root = str(folder)
    # As with `--no-db`: a release is no reason for a gradebook.
    config.SaveCells.enabled = False
    config.GenerateAssignment.no_database = True
    return config


def generate(course: Path, release: Path) -> None:
    """Write what nbgrader makes of a course's sources into a folder, and nothing else there."""
    if not notebooks("source", course):
        raise FileNotFoundError(f"{course}: no source/<name>/<name>.ipynb to release")
    # Without links: on some systems the temporary folder is one, and nbgrader compares the names.
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        shutil.copytree(course / "source", folder / "source", ignore=shutil.ignore_patterns(".*"))
        nbgrader = NbGraderAPI(config=settings(course, folder))
        for source in notebooks("source", folder):
            result = nbgrader.generate_assignment(source.parent.name)
            if not result["success"]:
                raise RuntimeError(f"{source.name}: {result.get('log') or result.get('error')}")
        for released in notebooks("release", folder):
            tidy(released)
        if release.exists():
            shutil.rmtree(release)
        shutil.copytree(folder / "release", release)


def tidy(path: Path) -> None:
    """Write a released notebook for the kernel that everybody has, with its checks folded."""
    notebook = nbformat.read(path, as_version=4)
    for mark in MARK.finditer("\n".join(cell.source for cell in notebook.cells)):
        found = mark.group().strip()
        raise ValueError(f"{path.name}: {found!r} is no mark that nbgrader knows: is it misspelt?")
    notebook.metadata = nbformat.from_dict(
        {"kernelspec": KERNEL, "language_info": {"name": "python"}}
    )
    for cell in notebook.cells:
        if cell.metadata.get("nbgrader", {}).get("grade"):
            # JupyterLab shows its first line, which names the exercise, and opens it on a click.
            cell.metadata["jupyter"] = {"source_hidden": True}
    nbformat.validate(notebook)
    nbformat.write(notebook, path)


def build_wheel(folder: Path) -> Path:
    """Build the library's wheel with what is installed here, from a copy that holds only its own.

    In the checkout itself, files of an earlier build that are gone since would find their way in.
    """
    source = folder / "package"
    source.mkdir(parents=True)
    for name in PACKAGE:
        if (ROOT / name).is_dir():
            shutil.copytree(
                ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__", ".*")
            )
        else:
            shutil.copy(ROOT / name, source)
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "--no-input"]
    build = ["wheel", "--no-deps", "--no-index", "--no-build-isolation", "--no-cache-dir"]
    subprocess.run(
        [*pip, *build, "--wheel-dir", str(folder), str(source)],
        check=True,
        env=os.environ | {"SOURCE_DATE_EPOCH": EPOCH},
    )
    (wheel,) = folder.glob("*.whl")
    return wheel


def pack(kit: Path, wheel: Path, course: Path = COURSE) -> None:
    """Write the students' zip: the released notebooks, the library, and how to begin."""
    readme = (course / STUDENTS).read_text(encoding="utf-8").replace("WHEEL", wheel.name)
    files = {path.name: path.read_bytes() for path in notebooks("release", course)}
    files |= {"README.txt": readme.encode(), wheel.name: wheel.read_bytes()}
    kit.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(kit, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in sorted(files.items()):
            entry = zipfile.ZipInfo(f"{kit.stem}/{name}", ZIP_TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content)


def main() -> int:
    """Write the released notebooks anew; with --zip the students' zip as well."""
    parser = argparse.ArgumentParser(prog="python -m tools.exercises", description=__doc__)
    parser.add_argument("--zip", action="store_true", help="also write the students' zip")
    chosen = parser.parse_args()
    generate(COURSE, COURSE / "release")
    for path in notebooks("release"):
        print(path.relative_to(ROOT))
    if chosen.zip:
        with tempfile.TemporaryDirectory() as folder:
            pack(KIT, build_wheel(Path(folder)))
        print(f"\nThe students' zip: {KIT.relative_to(ROOT)}, {KIT.stat().st_size / 1e3:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
