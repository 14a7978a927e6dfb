"""One run of `make grade`: from what was handed in to the table and the pages."""

import json
import sys
import time
from typing import TYPE_CHECKING, Any

from . import course, intake, kernels, opening, pool, report
from .run import Job, Limits

if TYPE_CHECKING:
    from tools.grade import Options

MAX_OF_ONE = 5  # notebooks of one student for one chapter that are marked


class Session:
    """What is to be graded, and what is known so far."""

    def __init__(self, wishes: "Options") -> None:
        self.wishes = wishes
        self.course = course.load(wishes.course)
        cell = wishes.cell_timeout or float(self.course.config.Execute.get("timeout", 20))
        self.limits = Limits(min(cell, wishes.timeout), wishes.timeout, wishes.memory)
        self.forks = kernels.FORKS and not wishes.slow
        self.results = wishes.out / "results"
        self.jobs: dict[str, Job] = {}
        self.begin = time.perf_counter()

    def run(self) -> int:
        """Grade all, and say where the results are."""
        exclude = self.wishes.out.resolve()
        handed = intake.collect(self.wishes.submissions, [*self.course.chapters], exclude)
        if not handed.students:
            print(f"{self.wishes.submissions} holds no notebooks.", file=sys.stderr)
            return 2
        self._say_beforehand(handed)
        plans = [(student, *self._planned(student)) for student in handed.students]
        try:
            if not self._course_is_sound():
                return 1
            self._grade()
        except KeyboardInterrupt:
            print("\nStopped. What is graded is kept; the same command goes on.", file=sys.stderr)
            return 130
        sheets = [self._sheet(*plan) for plan in plans]
        self._say_afterwards(sheets, report.write(sheets, self.wishes.out))
        return 0

    def _say_beforehand(self, handed: intake.Handed) -> None:
        print(f"{len(handed.students)} students.")
        if handed.left:
            print("Left aside, as no student's: " + ", ".join(handed.left))
        if not self.forks:
            print("Here the memory of a notebook is not limited, and grading takes its time.")

    def _planned(
        self, student: intake.Student
    ) -> tuple[list[tuple[str, intake.File, Job]], list[str]]:
        """Return what is to be graded of a student, and what is wrong with the rest."""
        found: dict[str, tuple[str, intake.File, Job]] = {}
        troubles, other = [], []
        for file in student.files:
            try:
                job = self._job(student, file)
            except opening.NotANotebook as error:
                troubles.append(f"{file.name.strip('/')}: {error}")
            else:
                if job:
                    found.setdefault(job.key, (job.chapter.stem, file, job))
                else:
                    other.append(file.parts[-1])
        if not found and not troubles:
            names = f" There was: {', '.join(sorted(other))}." if other else ""
            troubles.append(f"No notebook was handed in.{names} {opening.WANTED}")
        plan, left = self._not_too_many([*found.values()])
        for _, _, job in plan:
            self.jobs.setdefault(job.key, job)
        return plan, troubles + left

    def _job(self, student: intake.Student, file: intake.File) -> Job | None:
        """Return what is to be done for a file; None if it is none to grade."""
        if file.trouble:
            raise opening.NotANotebook(file.trouble)
        if not file.is_notebook:
            if len(file.parts) == 1:  # there is nothing else of this student
                kind = opening.SUFFIXES.get(file.suffix, "of another kind")
                raise opening.NotANotebook(f"The file is {kind}, not a notebook. {opening.WANTED}")
            return None
        raw = opening.parsed(file.data)
        chapter = self.course.chapters[opening.chapter_of(raw, self.course)]
        beside = student.beside(file)
        facts = repr((*sorted(beside), self.limits, self.forks, self.course.digest)).encode()
        key = intake.digest(file.data, *(beside[name] for name in sorted(beside)), facts)
        return Job(key, chapter, raw, beside, self.limits)

    def _not_too_many(
        self, plan: list[tuple[str, intake.File, Job]]
    ) -> tuple[list[tuple[str, intake.File, Job]], list[str]]:
        kept, said = [], []
        for entry in plan:
            if sum(other[0] == entry[0] for other in kept) < MAX_OF_ONE:
                kept.append(entry)
            else:
                said.append(
                    f"{entry[1].name}: one file too many for {entry[0]}; it was not graded."
                )
        return kept, said

    def _course_is_sound(self) -> bool:
        """See that the solutions earn all points here, or say what does not work."""
        stems = {job.chapter.stem for job in self.jobs.values()}
        ours = {}
        for stem in sorted(stems):
            chapter = self.course.chapters[stem]
            raw = json.loads(json.dumps(chapter.solved))
            key = intake.digest(b"the solutions", stem.encode(), self.course.digest.encode())
            ours[key] = Job(key, chapter, raw, {}, Limits(memory=self.limits.memory))
        missing = [job for key, job in ours.items() if pool.result_of(self.results, key) is None]
        pool.run(missing, self.results, workers=self.wishes.jobs, forks=self.forks)
        for key, job in ours.items():
            marked = report.Marked(job.chapter, "", pool.result_of(self.results, key) or {})
            if marked.points < job.chapter.points:
                (self.results / f"{key}.json").unlink(missing_ok=True)
                print(
                    f"{job.chapter.stem}: the solutions do not earn all points here.",
                    file=sys.stderr,
                )
                for name, one in marked.result.get("exercises", {}).items():
                    print(f"  {name}: {one['points'] or 0:g}, {one['says']}", file=sys.stderr)
                print(marked.result.get("error", ""), "Nothing was graded.", file=sys.stderr)
                return False
        return True

    def _grade(self) -> None:
        missing = [j for j in self.jobs.values() if pool.result_of(self.results, j.key) is None]
        if len(missing) < len(self.jobs):
            print(f"{len(self.jobs) - len(missing)} notebooks were graded before.")
        count = 0

        def done() -> None:
            nonlocal count
            count += 1
            print(f"\r{count} of {len(missing)} notebooks", end="", flush=True)

        pool.run(missing, self.results, workers=self.wishes.jobs, forks=self.forks, done=done)
        print("" if missing else "Nothing to grade anew.")

    def _sheet(
        self,
        student: intake.Student,
        plan: list[tuple[str, intake.File, Job]],
        troubles: list[str],
    ) -> report.Sheet:
        """Return what is known of a student; of several notebooks for a chapter the best counts."""
        sheet = report.Sheet(student.name, student.number, troubles=[*troubles])
        for stem in sorted({stem for stem, _, _ in plan}):
            tried = [self._marked(file, job) for one, file, job in plan if one == stem]
            best = max(tried, key=lambda one: one.points)
            if len(tried) > 1:
                names = ", ".join(one.place for one in tried)
                sheet.troubles.append(
                    f"{len(tried)} different files for {stem} ({names}): {best.place} counts, "
                    "which has the most points."
                )
            sheet.notebooks.append(best)
        return sheet

    def _marked(self, file: intake.File, job: Job) -> report.Marked:
        missing: dict[str, Any] = {"error": "there is no result"}
        found = pool.result_of(self.results, job.key) or missing
        return report.Marked(job.chapter, file.name, found)

    def _say_afterwards(self, sheets: list[report.Sheet], table: Any) -> None:
        noted = sum(bool(sheet.notes) for sheet in sheets)
        seconds = time.perf_counter() - self.begin
        print(f"{len(sheets)} students in {seconds:.0f} s; {noted} have notes.")
        print(f"{table}\n{table.parent / 'feedback'}")
