"""What is said of an exercise, in one sentence or two."""

import re
from dataclasses import dataclass
from typing import Any

from .course import Chapter

LONGEST = 1200  # characters of a message that came out of a student's code
GROWS = "Does a list or an array grow with every step?"
# Second halves of sentences, by why a cell was given up or the name of its error.
REASONS = {
    "endless": "it did not end within {cell:g} seconds and was stopped. Is there a loop that never "
    "comes to its end?",
    "ended": "Python itself came to its end. Is there an exit() or quit() in your code? Leave it "
    "out.",
    "memory": "it took more memory than a notebook may have ({memory} MB). " + GROWS,
    "MemoryError": "it took more memory than a notebook may have ({memory} MB). " + GROWS,
    "printed": "it printed without end and was stopped. Is there a print() in a loop that goes on?",
    "no time": "no time was left: a whole notebook has {notebook:g} seconds.",
    "too often": "nothing was run any more: too many cells had brought Python to its end.",
    "StdinNotImplementedError": "it waited at input() for something to be typed. Nobody is there "
    "to type it: give the value in the code.",
    "SystemExit": "it asked Python to end. Leave sys.exit() and exit() out.",
    "KeyboardInterrupt": "it was interrupted.",
}
STOPPED = {*REASONS} - {"KeyboardInterrupt"}  # a teacher should know of these
REASONS["_ArrayMemoryError"] = REASONS["MemoryError"]


@dataclass(frozen=True)
class Outcome:
    """How a cell ended: nothing, the name of an error, or why the cell was given up."""

    kind: str
    text: str = ""


@dataclass(frozen=True)
class Said:
    """What is known of an exercise after the run."""

    check: Outcome
    answer: Outcome
    empty: bool = False
    missing: bool = False


def outcome(name: str, text: str) -> Outcome:
    """Return how a cell ended that ended with an error; a check tells what the answer met."""
    for error in ("StdinNotImplementedError", "MemoryError"):
        if name == "CheckFailed" and f"{error}:" in text:
            return Outcome(error, text)
    return Outcome(name, text)


def sentence(said: Said, points: float | None, of: float, limits: Any) -> str:
    """Return what the student is told of an exercise."""
    if points is None:
        return "This answer is read by your teacher; its points are not in the sum yet."
    if points >= of:
        return "Passed."
    if said.empty:
        return "There is no answer here yet."
    own = _of_the_answer(said.answer, limits)
    if said.missing and said.check.kind in ("NameError", "CheckFailed"):
        own = "The cell for the answer had been deleted."
    return " ".join(filter(None, [own, _of_the_check(said.check, limits)]))


def _of_the_check(outcome: Outcome, limits: Any) -> str:
    if outcome.kind in ("CheckFailed", ""):
        return shortened(outcome.text)
    if outcome.kind == "stderr":
        return f"While this was checked, your code wrote to the error stream: {_line(outcome.text)}"
    return f"While this was checked, {_why(outcome, limits)}"


def _line(text: str) -> str:
    """Return the line of a warning, or the last one, without the place on this machine."""
    lines = [line.strip() for line in text.splitlines() if line.strip()] or [""]
    chosen = next((line for line in lines if "Warning:" in line), lines[-1])
    return shortened(re.sub(r"^\S+:\d+: (?=\w+Warning:)", "", chosen))


def _of_the_answer(outcome: Outcome, limits: Any) -> str:
    if outcome.kind in ("", "stderr"):
        return ""
    return f"When the cell of your answer was run, {_why(outcome, limits)}"


def _why(outcome: Outcome, limits: Any) -> str:
    """Return why a cell did not end well, as the second half of a sentence."""
    if outcome.kind in REASONS:
        values = {"cell": limits.cell, "notebook": limits.notebook, "memory": limits.memory}
        return REASONS[outcome.kind].format(**values)
    said = f"{outcome.kind}: {shortened(outcome.text)}" if outcome.text else outcome.kind
    return f"it stopped with {said}" + ("" if said.endswith((".", "?", "!")) else ".")


def shortened(text: str) -> str:
    """Return a message, cut if it is very long."""
    text = text.strip()
    return text if len(text) <= LONGEST else text[: LONGEST - 4].rstrip() + " ..."


def left_behind(count: int) -> str:
    """Say that processes were left behind."""
    what = "A process" if count == 1 else f"{count} processes"
    was = "was" if count == 1 else "were"
    return f"{what} that the notebook had started still ran at its end, and {was} ended."


def overwritten(found: dict[str, list[str]], chapter: Chapter) -> list[str]:
    """Say which names have another meaning now, and where they got it."""
    said = []
    for name, cells in found.items():
        if name.endswith("import *"):
            said.append(f"`{name}` may give another meaning to names such as `sum` and `max`.")
            continue
        where = " and ".join(
            dict.fromkeys(chapter.title_of(one) if one else "a cell of your own" for one in cells)
        )
        said.append(
            f"The name `{name}` gets another meaning in {where}; what needs it afterwards may "
            "fail. Choose another name."
        )
    return said
