"""How a check says what is wrong: one friendly sentence, and no traceback."""

import sys
import textwrap
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr
from pathlib import Path
from types import TracebackType
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

UNANSWERED = "Write it in the cell above, run that cell, and then this one again."
WIDTH = 88  # characters of a line of a sentence
# How an absent answer shows in the message of the error that it leads to.
NOTHING = ("NoneType", "ellipsis", "'Ellipsis'")


class CheckFailed(AssertionError):  # noqa: N818  (a student reads it, and has made no error yet)
    """A check that an answer did not pass, in one sentence; a notebook shows no more than that.

    Parameters
    ----------
    what : str
        What was looked at, such as "the value at node 3".
    expected, found : str
        What it should be, and what it is.
    where : str
        At which node, point or triangle.
    hint : str
        What may be the cause, or what to try.
    """

    def __init__(
        self, what: str, *, expected: str = "", found: str = "", where: str = "", hint: str = ""
    ) -> None:
        self.what, self.expected, self.found = what, expected, found
        self.where, self.hint = where, hint
        said = f"Not yet: {what}"
        if expected:
            said += f" should be {expected}"
        if found:
            said += f", but is {found}" if expected else f" is {found}"
        if where:
            said += f", {where}"
        super().__init__(said.rstrip(".") + "." + (f" Hint: {hint}" if hint else ""))

    def _render_traceback_(self) -> list[str]:
        # JupyterLab breaks long lines within words.
        return textwrap.wrap(str(self), WIDTH, break_long_words=False, break_on_hyphens=False)


@contextmanager
def exercise(title: str) -> Iterator[None]:
    """Say of an exercise that it is passed, or in one sentence why not.

    Parameters
    ----------
    title : str
        The exercise's title.

    Raises
    ------
    CheckFailed
        If a check fails, a name is missing, or the answer's code raises an error.

    Examples
    --------
    >>> with exercise("Double it"):
    ...     assert 2 * 2 == 4
    Passed: Double it.
    """
    try:
        # To a check that writes to stderr, be it only a warning, nbgrader gives no points.
        with warnings.catch_warnings(), redirect_stderr(sys.stdout):
            warnings.simplefilter("ignore")
            yield
    except CheckFailed:
        raise
    except (Exception, SystemExit) as error:
        raise explained(error) from None
    print(f"Passed: {title}" + "." * (title[-1] not in "?!."))  # noqa: T201


def explained(error: BaseException) -> CheckFailed:
    """Return the sentence for an error that came out of an answer."""
    where, depth = line_of_answer(error.__traceback__)
    if isinstance(error, NameError) and not depth:
        return CheckFailed(f"there is no `{error.name}`", hint=UNANSWERED)
    if isinstance(error, KeyError) and not depth:
        return CheckFailed(f"there is no entry {error}", hint="Keep the keys that stand there.")
    if any(word in str(error) for word in NOTHING):
        return CheckFailed("there is no answer here", where=where, hint=UNANSWERED)
    said = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    hint = "Read the line, and try the function on three numbers that you can check by hand."
    return CheckFailed(f"your code stopped with {said}", where=where, hint=hint)


def line_of_answer(trace: TracebackType | None) -> tuple[str, int]:
    """Return where in a cell an error arose, and how many functions of cells deep that is.

    The code of a cell is in no file, so what is in no file is the student's; but for the helpers
    of checks, whose names begin with "_".
    """
    frames = [frame for frame in traceback.extract_tb(trace) if not Path(frame.filename).exists()]
    inner = [frame for frame in frames if frame.name != "<module>" and frame.name[0] != "_"]
    if not inner:
        return "", 0
    line = f": `{inner[-1].line}`" if inner[-1].line else ""
    return f"in line {inner[-1].lineno} of the cell with `{inner[-1].name}`{line}", len(inner)


def asked(function: Any, *args: Any, what: str = "") -> Any:
    """Return what an answer that should be a function says of these arguments."""
    name = what or f"`{getattr(function, '__name__', 'the answer')}`"
    if function is None or function is ...:
        raise CheckFailed(f"{name} has no answer", hint=UNANSWERED)
    if not callable(function):
        raise CheckFailed(name, expected="a function", found=described(function))
    value = function(*args)
    if value is None or value is ...:
        raise CheckFailed(f"{name} returns nothing", hint=UNANSWERED)
    return value


def numbers(found: Any, what: str, shape: tuple[int, ...] | None = None) -> FloatArray:
    """Return an answer as an array of finite numbers of this shape, or say what it is instead."""
    if found is None or found is ...:
        raise CheckFailed(f"{what} has no answer", hint=UNANSWERED)
    try:
        values = np.asarray(found, dtype=float)
    except (TypeError, ValueError):
        refuse(what, "numbers", described(found))
    if shape is not None and values.shape != shape:
        refuse(what, of_shape(shape), of_shape(values.shape), hint="Print its shape.")
    if not np.isfinite(values).all():
        bad = np.unravel_index(np.argmin(np.isfinite(values)), values.shape)
        hint = "Look for a division by zero, the root of a negative number, or a step too long."
        refuse(what, "finite", str(values[bad]), where=node(bad), hint=hint)
    return values


def field_values(fd: Any, points: FloatArray) -> FloatArray:
    """Return what a student's field says, once it is sure that it is numbers of the right shape."""
    what = f"what `{getattr(fd, '__name__', 'your field')}` returns for points of shape "
    return numbers(asked(fd, points.copy()), what + str(points.shape), points.shape[:-1])


def refuse(what: str, expected: str, found: str, *, where: str = "", hint: str = "") -> NoReturn:
    """Raise `CheckFailed`."""
    raise CheckFailed(what, expected=expected, found=found, where=where, hint=hint)


def of_shape(shape: tuple[int, ...]) -> str:
    """Return a shape in words."""
    return f"an array of shape {shape}" if shape else "one number"


def described(value: Any) -> str:
    """Return a value, shortened, with its type."""
    text = repr(value)
    return f"{text if len(text) < 40 else text[:37] + '...'} (a {type(value).__name__})"


def number(value: ArrayLike) -> str:
    """Return a number with six digits."""
    return f"{float(np.asarray(value)):.6g}"


def point(coordinates: ArrayLike) -> str:
    """Return a point with four digits a coordinate."""
    return "at (" + ", ".join(f"{float(x):.4g}" for x in np.atleast_1d(coordinates)) + ")"


def node(index: tuple[Any, ...]) -> str:
    """Return a place in an array."""
    return f"at node [{', '.join(str(int(i)) for i in index)}]" if index else ""


__all__ = ["CheckFailed", "exercise"]
