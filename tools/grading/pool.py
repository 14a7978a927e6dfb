"""Many notebooks at once, each in a process of its own, with results kept as they come."""

from __future__ import annotations

import contextlib
import json
import multiprocessing
import os
import time
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from multiprocessing.connection import wait
from pathlib import Path
from typing import TYPE_CHECKING, Any

import psutil

from . import kernels

if TYPE_CHECKING:
    from .run import Job

GRACE = 30  # seconds that a process may take beyond its notebook's
PRELOADED = [
    "tools.grading.run",
    "distmesh_edu",
    "distmesh_edu.checks",
    "scipy.interpolate",
    "scipy.ndimage",
    "scipy.optimize",
    "scipy.sparse.csgraph",
    "scipy.spatial",
    "ipykernel.ipkernel",
    "ipykernel.kernelapp",
]


@dataclass
class _Working:
    job: Job
    process: Any
    deadline: float


def cores() -> int:
    """Return how many processes may run at once on this machine."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def result_of(place: Path, key: str) -> dict[str, Any] | None:
    """Return a result that was kept, or None."""
    try:
        found = json.loads((place / f"{key}.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) and "again" not in found else None


def preload() -> None:
    """Start the process that kernels are forked from; it loads what they need."""
    from multiprocessing import forkserver  # which there is not on Windows

    multiprocessing.set_forkserver_preload(PRELOADED)
    forkserver.ensure_running()


def run(
    jobs: Iterable[Job],
    place: Path,
    *,
    workers: int = 0,
    forks: bool = kernels.FORKS,
    done: Callable[[], None] = lambda: None,
) -> None:
    """Mark notebooks, as many at once as there are cores, and keep each result in a file.

    A notebook whose process ends without a result has one all the same, which says so.
    """
    place.mkdir(parents=True, exist_ok=True)
    waiting = deque(jobs)
    context = multiprocessing.get_context("forkserver" if forks else "spawn")
    if forks:
        preload()
    working: list[_Working] = []
    try:
        while waiting or working:
            while waiting and len(working) < (workers or cores() + 1):
                working.append(_started(waiting.popleft(), place, context, forks))
            soonest = min(one.deadline for one in working) - time.monotonic()
            wait([one.process.sentinel for one in working], timeout=max(0.0, soonest))
            for one in [one for one in working if _over(one)]:
                working.remove(one)
                again = _finished(one, place)
                if again:
                    waiting.appendleft(one.job)
                else:
                    done()
    finally:
        for one in working:
            _end(one)


def _started(job: Job, place: Path, context: Any, forks: bool) -> _Working:
    file = place / f"{job.key}.json"
    file.unlink(missing_ok=True)
    from .run import grade  # which loads nbgrader

    process = context.Process(target=grade, args=(job, file), kwargs={"forks": forks})
    process.start()
    return _Working(job, process, time.monotonic() + job.limits.notebook - job.seconds + GRACE)


def _over(one: _Working) -> bool:
    return not one.process.is_alive() or time.monotonic() > one.deadline


def _finished(one: _Working, place: Path) -> bool:
    """Put down what a process left, and return whether its notebook needs a new start."""
    late = one.process.is_alive()
    _end(one)
    file = place / f"{one.job.key}.json"
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        why = "it went far beyond its time" if late else "the process that ran it was ended"
        found = {"error": f"{why} (code {one.process.exitcode})"}
        file.write_text(json.dumps(found), encoding="utf-8")
    again = found.get("again")
    if again:
        file.unlink()
        one.job.outputs = {int(i): outputs for i, outputs in again["outputs"].items()}
        one.job.given_up = {int(i): reason for i, reason in again["given_up"].items()}
        one.job.seconds, one.job.starts = again["seconds"], again["starts"]
    return bool(again)


def _end(one: _Working) -> None:
    """End a process with all that it started."""
    if one.process.is_alive():
        try:
            left = psutil.Process(one.process.pid).children(recursive=True)
        except psutil.Error:
            left = []
        one.process.kill()
        for child in left:
            with contextlib.suppress(psutil.Error):
                child.kill()
    one.process.join()
