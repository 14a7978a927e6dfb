"""What it costs to grade a class, and whether everyone gets the points they should."""

import csv
import html
import io
import json
import os
import random
import re
import subprocess
import sys
import tempfile
import threading
import time
import zipfile
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import psutil

from tests.answers import answers_to

from . import submissions
from .submissions import KINDS, Course, Draft

ROOT = Path(__file__).resolve().parents[1]
STUDENTS = 100
# Most of a class hands in what it should; of each other kind there is one, or as many as this.
MANY = {"wrong": 20, "empty": 6, "broken": 3, "endless": 3, "eats memory": 2}
FIRST = ["Ada", "Béla", "Chloé", "Đorđe", "Éva", "Jörg", "Łukasz", "Noor", "Søren", "Zoë", "李"]
LAYOUTS = ["folder", "flat", "zip", "Moodle"]


@dataclass
class Outcome:
    """What a class cost, and who did not get what they should."""

    seconds: float
    work: float  # seconds that the processors worked on the notebooks, added up
    megabytes: float
    surprises: list[str] = field(default_factory=list)


def report() -> None:
    """Grade a class of a hundred, and print what it cost and whether the marks are right."""
    courses = [
        submissions.read(file) for file in sorted((ROOT / "exercises/source").glob("*/*.ipynb"))
    ]
    with tempfile.TemporaryDirectory() as temporary:
        place = Path(temporary)
        drafts = make_class(place / "class", courses, STUDENTS, seed=1)
        kinds = Counter(name.split(", ")[1].rsplit(" ", 1)[0] for name in drafts)
        print(f"\nGrading {len(drafts)} submissions to {len(courses)} notebooks on {cores()} cores")
        print("  " + ", ".join(f"{count} {kind}" for kind, count in kinds.most_common()))
        outcome = graded(place / "class", place / "out", drafts)
    print(
        f"  {outcome.seconds:.0f} s; {outcome.megabytes:.0f} MB at most, in all processes together"
    )
    print(f"  The processors worked on the notebooks for {outcome.work:.0f} s, all added up.")
    loops = sum(kinds[kind] for kind in ("endless", "endless cell", "stubborn"))
    print(f"  {loops} of them had a loop without end, which runs for 20 s before it is stopped.")
    print(f"  {len(drafts) - len(outcome.surprises)} of {len(drafts)} got what they should.")
    print(*(f"  NOT: {one}" for one in outcome.surprises), sep="\n", end="")


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def make_class(folder: Path, courses: list[Course], size: int, seed: int) -> dict[str, Draft]:
    """Write the submissions of a class, of each kind at least one, and return the drafts."""
    kinds = [kind for kind in KINDS for _ in range(MANY.get(kind, 1))]
    kinds = ["good"] * max(0, size - len(kinds)) + kinds
    chance = random.Random(seed)
    drafts = {}
    for i, kind in enumerate(kinds):
        student = f"{FIRST[i % len(FIRST)]}, {kind} {i:03}"
        drafts[student] = drafted(kind, courses, chance)
        put(folder, student, drafts[student], LAYOUTS[i % len(LAYOUTS)], 1000 + i)
    return drafts


def drafted(kind: str, courses: list[Course], chance: random.Random) -> Draft:
    """Return a submission of a kind to a notebook drawn at random."""
    course = chance.choice([course for course in courses if course.functions])
    draft = Draft(course, chance.choice(course.functions))
    if kind == "wrong":
        answers = [one for one in answers_to(course.stem) if one.exercise in course.functions]
        draft.answers = [chance.choice([one for one in answers if not one.right])]
    elif kind == "good":
        for name in course.functions:  # in the style of the solution, or in another
            others = [one for one in answers_to(course.stem) if one.right and one.exercise == name]
            if others and chance.random() < 0.5:
                draft.cell(name)["source"] = chance.choice(others).source
    # No two students hand in the same bytes, which would be graded once.
    if kind in ("good", "wrong"):
        draft.add(imports(course.stem), draft.at("imports") + 1)
    KINDS[kind](draft)
    if draft.files is None:
        draft.notebook["metadata"]["student"] = chance.random()
    return draft


def imports(stem: str) -> str:
    """Return what the answers of others need beside what their notebook imports."""
    lines = (
        Path(sys.modules[f"tests.answers.ch{stem[:2]}"].__file__).read_text("utf-8").splitlines()
    )
    needed = [line for line in lines if re.match(r"(import|from) (?!tests)", line)]
    return "\n".join(needed)


def put(folder: Path, student: str, draft: Draft, layout: str, number: int) -> None:
    """Write what a student hands in, in one of the ways in which teachers get it."""
    files = draft.handed_in
    if layout == "flat" and draft.files is None:
        files = {f"{student}_{name}": data for name, data in files.items()}
    elif layout == "zip":
        whole = io.BytesIO()
        with zipfile.ZipFile(whole, "w") as archive:
            for name, data in files.items():
                archive.writestr(f"my homework/{name}", data)
        files = {f"{student}.zip": whole.getvalue()}
    else:
        top = f"{student}_{number}_assignsubmission_file_" if layout == "Moodle" else student
        files = {f"{top}/{name}": data for name, data in files.items()}
    for name, data in files.items():
        place = folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(data)


def graded(folder: Path, out: Path, drafts: dict[str, Draft], *options: str) -> Outcome:
    """Grade a class in a process of its own, and compare with what everyone should get."""
    command = [sys.executable, "-m", "tools.grade", str(folder), "--out", str(out), *options]
    begin = time.perf_counter()
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL)
    watch = _Watch(process.pid)
    code = process.wait()
    seconds = time.perf_counter() - begin
    if code:
        return Outcome(seconds, 0.0, watch.stop(), [f"the grader ended with {code}"])
    results = [file.read_text(encoding="utf-8") for file in (out / "results").glob("*.json")]
    work = sum(json.loads(result).get("cpu", 0.0) for result in results)
    return Outcome(seconds, work, watch.stop(), surprises(out, drafts))


def rows(out: Path) -> dict[str, dict[str, str]]:
    """Return the table of grades, by the student's name."""
    with (out / "grades.csv").open(encoding="utf-8-sig", newline="") as file:
        return {row["student"]: row for row in csv.DictReader(file)}


def surprises(out: Path, drafts: dict[str, Draft]) -> list[str]:
    """Return what is not as it should be."""
    table = rows(out)
    found = [f"{name}: not in the table" for name in sorted(drafts.keys() - table.keys())]
    found += [f"{name}: nobody's" for name in sorted(table.keys() - drafts.keys())]
    for name in sorted(drafts.keys() & table.keys()):
        page = (out / "feedback" / table[name]["page"]).read_text(encoding="utf-8")
        found += [f"{name}: {wrong}" for wrong in differences(drafts[name], table[name], page)]
    return found


def differences(draft: Draft, row: dict[str, str], page: str) -> list[str]:
    """Return where a student's points, or what is said to them, are not as they should be."""
    stem = draft.course.stem
    got = {k.split("/")[1]: v for k, v in row.items() if k.startswith(f"{stem}/")}
    points = {one: float(text) for one, text in got.items() if text}
    expected = draft.expected or {}
    found = [
        f"{one} of {stem}: {points.get(one)} points, not {expected.get(one)}"
        for one in draft.course.points
        if points.get(one) != expected.get(one)
    ]
    if float(row["total"]) != sum(expected.values()):
        found.append(f"{row['total']} points in all, not {sum(expected.values()):g}")
    said = html.unescape(page).replace("<code>", "`").replace("</code>", "`")
    if draft.says not in said:
        found.append(f"is not told: {draft.says}")
    return found


class _Watch:
    """Looks once a second how much memory a process and all that it started hold together."""

    def __init__(self, pid: int) -> None:
        self.process, self.most, self.over = psutil.Process(pid), 0.0, threading.Event()
        self.thread = threading.Thread(target=self._look, daemon=True)
        self.thread.start()

    def stop(self) -> float:
        self.over.set()
        self.thread.join()
        return self.most

    def _look(self) -> None:
        while not self.over.wait(1.0):
            try:
                family = [self.process, *self.process.children(recursive=True)]
            except psutil.Error:
                return
            self.most = max(self.most, sum(map(_megabytes, family)))


def _megabytes(process: psutil.Process) -> float:
    """Return what a process holds; pages that several share are shared out among them."""
    try:
        held = process.memory_full_info()
    except psutil.Error:
        return 0.0
    return getattr(held, "pss", held.rss) / 1e6
