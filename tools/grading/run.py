"""One notebook: repaired, run cell by cell within its limits, and marked."""

import contextlib
import json
import logging
import os
import re
import signal
import time
import traceback
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import nbformat
from nbclient.exceptions import CellTimeoutError, DeadKernelError
from nbgrader import utils
from nbgrader.preprocessors import Execute

from . import kernels, names, opening, repair, words
from .course import Chapter

MAX_PRINTED = 1_000_000  # characters that a cell may print or show
WEIGHT = 500  # characters that each message stands for, beside its own
MAX_STARTS = 8  # times that a notebook may bring its kernel to an end
KEPT_FREE = 0.5  # of the memory: a cell that fails and holds more is given up, to make room
ANSI = re.compile(r"\x1b\[[0-9;]*[A-Za-z]")


@dataclass(frozen=True)
class Limits:
    """Seconds of a cell and of a notebook, and megabytes."""

    cell: float = 20
    notebook: float = 120
    memory: int = 1000


@dataclass
class Job:
    """A notebook to be marked, and how far it has come."""

    key: str  # of what was handed in, the course and the limits
    chapter: Chapter
    raw: dict[str, Any]
    beside: dict[str, bytes]
    limits: Limits
    outputs: dict[int, list[Any]] = field(default_factory=dict)
    given_up: dict[int, str] = field(default_factory=dict)
    seconds: float = 0.0
    starts: int = 0


class _GivenUp(Exception):  # noqa: N818  (ends one run, so that the next may leave the cell out)
    """A cell has used up its kernel."""

    def __init__(self, index: int, reason: str) -> None:
        super().__init__(reason)
        self.index, self.reason = index, reason


class _Run(Execute):
    """nbgrader's Execute within the limits of a job, and without the cells that were given up."""

    def set_up(self, job: Job, nursery: kernels.Nursery) -> None:
        self.job, self.nursery = job, nursery
        self.begin = time.monotonic() - job.seconds
        self.printed = self.current = 0
        self.flooded: set[int] = set()
        self.left_behind = 0
        self.shutdown_kernel = "immediate"
        self.interrupt_on_timeout, self.iopub_timeout = True, 4
        self.timeout_func = lambda _: max(0.1, min(job.limits.cell, self.left))
        self.extra_arguments = []

    @property
    def left(self) -> float:
        """The seconds that the notebook has left."""
        return self.job.limits.notebook - (time.monotonic() - self.begin)

    def create_kernel_manager(self) -> Any:
        self.km = self.nursery.manager(kernel_name="python3", config=self.config)
        return self.km

    def start_new_kernel(self, **kwargs: Any) -> None:
        super().start_new_kernel(cwd=str(self.nursery.work), **kwargs)

    def preprocess_cell(self, cell: Any, resources: Any, index: int) -> Any:
        if index in self.job.outputs or index in self.job.given_up or cell.cell_type != "code":
            return cell, resources
        if self.left <= 0:
            self.job.given_up[index] = "no time"
            return cell, resources
        self.printed, self.current = 0, index
        try:
            super().preprocess_cell(cell, resources, index)
        except (DeadKernelError, CellTimeoutError) as error:
            reason = "ended" if isinstance(error, DeadKernelError) else "endless"
            raise _GivenUp(index, "printed" if index in self.flooded else reason) from None
        room = self.job.limits.memory * 1e6 * KEPT_FREE
        if utils.has_failed(cell) and room and kernels.memory_used(self.km) > room:
            raise _GivenUp(index, "memory")
        if utils.is_grade(cell):
            self.job.outputs[index] = cell.outputs
        return cell, resources

    def _cleanup_kernel(self) -> None:
        self.left_behind = kernels.left_behind(self.km)
        super()._cleanup_kernel()

    def on_cell_executed(self, **kwargs: Any) -> None:
        super().on_cell_executed(**kwargs)
        payload = kwargs["execute_reply"]["content"].get("payload", [])
        if any(one.get("source") == "ask_exit" for one in payload):
            raise _GivenUp(kwargs["cell_index"], "ended")

    def process_message(self, msg: Any, cell: Any, cell_index: int) -> Any:
        if msg["msg_type"] in ("stream", "display_data", "execute_result", "update_display_data"):
            self.printed += len(json.dumps(msg["content"], default=str)) + WEIGHT
            if self.printed > MAX_PRINTED:
                if cell_index not in self.flooded:
                    self.flooded.add(cell_index)
                    kernels.interrupt(self.km)
                return None
        return super().process_message(msg, cell, cell_index)


def grade(job: Job, place: Path, *, forks: bool = kernels.FORKS) -> None:
    """Mark a notebook, and write what came out: the marks, or how far it came before a new start.

    Runs in a process of its own, which ends after it.
    """
    logging.disable(logging.CRITICAL)  # what nbgrader logs is said in the remarks
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a person who stops it all stops the others
    nursery = kernels.Nursery(job.limits.memory if forks else 0, forks=forks)
    try:
        result = _graded(job, nursery)
    except Exception:
        result = {"error": traceback.format_exc()}
    finally:
        nursery.close()
    result["cpu"] = sum(os.times()[:4])  # seconds, with those of the kernel, which has ended
    temporary = place.with_suffix(f".{os.getpid()}")
    temporary.write_text(json.dumps(result), encoding="utf-8")
    temporary.replace(place)


def _graded(job: Job, nursery: kernels.Nursery) -> dict[str, Any]:
    begin = time.monotonic()
    notebook = opening.notebook(job.raw)
    remarks = [*opening.remarks(job.raw), *repair.repair(job.chapter, notebook)]
    for name, data in {**job.beside, **job.chapter.beside}.items():
        _written(nursery.work, name, data)
    run = _Run()
    run.set_up(job, nursery)
    for index, outputs in job.outputs.items():
        notebook.cells[index].outputs = [nbformat.from_dict(one) for one in outputs]
    try:
        run.preprocess(notebook, {})
    except _GivenUp as end:
        job.given_up[end.index] = end.reason
        if run.left > 0 and job.starts < MAX_STARTS:
            return {
                "again": {
                    "outputs": job.outputs,
                    "given_up": job.given_up,
                    "seconds": job.seconds + time.monotonic() - begin,
                    "starts": job.starts + 1,
                }
            }
        reason = "no time" if run.left <= 0 else "too often"
        remaining = range(end.index + 1, len(notebook.cells))
        job.given_up |= {i: reason for i in remaining if i not in job.outputs}
    if run.left_behind:
        remarks.append(words.left_behind(run.left_behind))
    return _marks(job, notebook, run.flooded) | {
        "remarks": [*remarks, *words.overwritten(names.overwritten(notebook), job.chapter)],
        "seconds": job.seconds + time.monotonic() - begin,
    }


def _written(folder: Path, name: str, data: bytes) -> None:
    """Write a file beside the notebook, wherever its name would like to lead."""
    place = folder.joinpath(*(part for part in Path(name).parts if part not in ("..", "/", "\\")))
    with contextlib.suppress(OSError, ValueError):
        if place.resolve().is_relative_to(folder.resolve()):
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(data)


def _marks(job: Job, notebook: nbformat.NotebookNode, flooded: set[int]) -> dict[str, Any]:
    """Return the points of each exercise, with a sentence and the answer's own cell."""
    place = {repair.name(cell): i for i, cell in enumerate(notebook.cells) if repair.name(cell)}
    found = {}
    for exercise in job.chapter.exercises:
        check = place[exercise.check]
        answer = place.get(exercise.name)
        said = words.Said(
            check=_outcome(job, notebook.cells[check], check, flooded),
            answer=words.Outcome("")
            if answer is None
            else _outcome(job, notebook.cells[answer], answer, flooded),
            empty=answer is not None and _empty(job.chapter, notebook.cells[answer], exercise.name),
            missing=answer is None,
        )
        points = _points(notebook.cells[check], given_up=check in job.given_up)
        source = notebook.cells[answer].source if answer is not None else ""
        found[exercise.name] = {
            "points": points,
            "says": words.sentence(said, points, exercise.points, job.limits),
            "answer": "" if said.empty else source,
            "answered": not (said.empty or said.missing),
            "stopped": bool({said.check.kind, said.answer.kind} & words.STOPPED),
        }
    return {"stem": job.chapter.stem, "exercises": found}


def _points(cell: nbformat.NotebookNode, *, given_up: bool) -> float | None:
    """Return what nbgrader gives for a graded cell; None if a person has to read it."""
    if given_up:
        return 0.0
    try:
        return utils.determine_grade(cell)[0]
    except (ValueError, KeyError):  # a graded cell that returns no such share of its points
        return 0.0


def _outcome(job: Job, cell: nbformat.NotebookNode, index: int, flooded: set[int]) -> words.Outcome:
    """Return how a cell ended: the name of its error, and what that said."""
    if index in job.given_up:
        return words.Outcome(job.given_up[index])
    errors = [one for one in cell.get("outputs", []) if one.output_type == "error"]
    written = [
        one for one in cell.get("outputs", []) if one.get("name") == "stderr" and one.get("text")
    ]
    if index in flooded and errors:
        return words.Outcome("printed")
    if any(error.ename == "CellTimeoutError" for error in errors):
        return words.Outcome("endless")
    if errors:
        return words.outcome(errors[0].ename, ANSI.sub("", errors[0].evalue))
    return words.Outcome("stderr", ANSI.sub("", written[0].text)) if written else words.Outcome("")


def _empty(chapter: Chapter, cell: nbformat.NotebookNode, name: str) -> bool:
    """Return whether the cell is as it was handed out."""
    same = cell.source.split() == chapter.given[name].split()
    return same or cell.metadata.nbgrader.get("checksum") == utils.compute_checksum(cell)
