"""Grade a folder or a zip of submitted notebooks: `make grade SUBMISSIONS=...`."""

import argparse
import os
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tools.grading import kernels, pool

ROOT = Path(__file__).resolve().parents[1]

ABOUT = """\
Writes grades.csv, a row for each student, and feedback/<student>.html. What is handed in may lie
in <student>/<notebook>.ipynb, in nbgrader's submitted/<student>/<assignment>/, in files that bear
the students' names, in a download from Moodle or Canvas, and in zips within these. A notebook is
known by the marks in its cells, whatever its file is called.

A notebook that never ends, takes too much memory, ends Python or is damaged is reported for its
student, and harms nobody else's. This is no sandbox: the code runs as you, with your files and
your network. It guards against mistakes, not against malice. Grade what you do not trust in a
container, or as a user who may do nothing.

A run that was stopped goes on where it was; a notebook is graded anew when it, the course or a
limit has changed.
"""


@dataclass
class Options:
    """What the command line says."""

    submissions: Path
    out: Path
    timeout: float
    cell_timeout: float | None
    memory: int
    jobs: int
    course: Path
    slow: bool


def options(arguments: Sequence[str]) -> Options:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        "python -m tools.grade",
        description=__doc__,
        epilog=ABOUT,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("submissions", type=Path, help="a folder, a zip, or one notebook")
    add("--out", type=Path, help="where to write; by default <submissions>_graded beside it")
    add("--timeout", type=float, default=120, help="seconds for a notebook (120)")
    add("--cell-timeout", type=float, help="seconds for a cell (from nbgrader_config.py: 20)")
    add("--memory", type=int, default=1000, help="megabytes for a notebook, on Linux alone (1000)")
    add("--jobs", type=int, default=0, help="notebooks at once (one more than there are cores)")
    add("--course", type=Path, default=ROOT / "exercises", help="the course (exercises)")
    add("--slow", action="store_true", help="start kernels as Jupyter does, and limit no memory")
    found = parser.parse_args(arguments)
    place = found.submissions.resolve()
    found.out = found.out or place.with_name(f"{place.stem}_graded")
    return Options(**vars(found))


def main(arguments: Sequence[str] | None = None) -> int:
    """Grade, and return 0 if all went well, whatever the students handed in."""
    wishes = options(sys.argv[1:] if arguments is None else arguments)
    if not wishes.submissions.exists():
        print(
            f"{wishes.submissions} is not there. Name a folder, a zip or a notebook.",
            file=sys.stderr,
        )
        return 2
    with tempfile.TemporaryDirectory(prefix="grade-") as temporary:
        os.environ |= kernels.quiet_environment(Path(temporary))
        if kernels.FORKS and not wishes.slow:
            pool.preload()  # in another process, while this one loads the rest
        from tools.grading.session import Session

        return Session(wishes).run()


if __name__ == "__main__":
    sys.exit(main())
