"""Answers to the exercises: right ones in another style than the solution, and wrong ones.

Each wrong one says what a student who gives it must be told. What students usually get wrong, in
the page for teachers, is told from here.
"""

import inspect
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any


@dataclass(frozen=True)
class Answer:
    """What a student may write in the answer cell of an exercise.

    `names` holds what the cell defines; `says` a piece of the sentence that a wrong answer gets.
    """

    exercise: str
    right: bool
    says: str
    names: dict[str, Any]

    def __str__(self) -> str:
        return f"{self.exercise}: {self.says or 'right'}"

    @property
    def source(self) -> str:
        """The cell, as the student would have typed it."""
        return "\n\n".join(as_source(name, value) for name, value in self.names.items())


def as_source(name: str, value: Any) -> str:
    """Return the lines that define a name: a function's own, without what decorates it here."""
    if not inspect.isfunction(value):
        return f"{name} = {value!r}"
    lines = textwrap.dedent(inspect.getsource(value)).splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("def "))
    return "\n".join(lines[first:]) + (
        "" if value.__name__ == name else f"\n\n{name} = {value.__name__}"
    )


class Answers(list[Answer]):
    """The answers to the exercises of one notebook, in the order in which they are written down."""

    def right(self, exercise: str, **values: Any) -> Callable[[Any], Any]:
        """Note a right answer: values by their names, or the function that this decorates."""
        return self._note(exercise, True, "", values)

    def wrong(self, exercise: str, says: str, **values: Any) -> Callable[[Any], Any]:
        """Note a wrong answer, and a piece of what its student must be told."""
        return self._note(exercise, False, says, values)

    def _note(self, exercise: str, right: bool, says: str, values: dict[str, Any]) -> Any:
        if values:
            return self.append(Answer(exercise, right, says, values))

        def decorated(function: Callable[..., Any]) -> Callable[..., Any]:
            self.append(Answer(exercise, right, says, {function.__name__: function}))
            return function

        return decorated


def answers_to(stem: str) -> Answers:
    """Return the answers to a notebook's exercises, such as those of 03_convection."""
    return import_module(f"tests.answers.ch{stem[:2]}").ANSWERS
