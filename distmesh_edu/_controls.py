"""What a slider or a list may be set to: the parameters of a figure, read and checked."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from numbers import Integral, Real
from typing import TypeAlias

Value: TypeAlias = bool | int | float | str
Position: TypeAlias = tuple[int, ...]

CONTROL_LIMIT = 3
"""Controls on one figure: with a fourth, nobody remembers what the others did."""

FRAME_LIMIT = 200
"""Pictures behind one figure of the page; at a tenth of a second each, 20 s of the book's build."""


@dataclass(frozen=True)
class Control:
    """One parameter of a figure and the values that it may take.

    Parameters
    ----------
    name : str
        The parameter's name.
    values : tuple of bool, int, float or str
        The values, in the order in which a reader meets them.
    is_range : bool
        True for a slider, which can be played; False for a list to choose from.
    """

    name: str
    values: tuple[Value, ...]
    is_range: bool

    @property
    def label(self) -> str:
        """The name as a reader sees it."""
        return self.name.replace("_", " ")

    @property
    def texts(self) -> tuple[str, ...]:
        """The values as a reader sees them: 0.2 rather than 0.20000000000000001."""
        return tuple(_text(value) for value in self.values)

    def __str__(self) -> str:
        texts = self.texts
        if self.is_range:
            return f"{self.label} from {texts[0]} to {texts[-1]}, {len(texts)} values"
        return f"{self.label} one of {', '.join(texts)}"


def read_controls(parameters: Mapping[str, object]) -> tuple[Control, ...]:
    """Return one control for each parameter, in the order given.

    Parameters
    ----------
    parameters : mapping of str to object
        A range (low, high, step) or a list of choices for each name.

    Returns
    -------
    tuple of Control
        At most `CONTROL_LIMIT` controls with at most `FRAME_LIMIT` combinations of values.

    Raises
    ------
    TypeError, ValueError
        If a parameter is neither a range nor a list, or asks for too much.
    """
    if len(parameters) > CONTROL_LIMIT:
        names = ", ".join(parameters)
        raise ValueError(
            f"explore takes at most {CONTROL_LIMIT} parameters, found {len(parameters)} ({names}); "
            "give the others a default in the figure"
        )
    controls = tuple(_read(name, given) for name, given in parameters.items())
    _check_frames(math.prod(len(control.values) for control in controls))
    return controls


def find_start(controls: Sequence[Control], start: Mapping[str, object] | None) -> Position:
    """Return the index of the start value in each control; the first one where none is given.

    Parameters
    ----------
    controls : sequence of Control
        The controls of a figure.
    start : mapping of str to value, or None
        Start values by name.

    Returns
    -------
    tuple of int
        One index for each control.

    Raises
    ------
    TypeError, ValueError
        If `start` is no mapping, names an unknown control, or holds a value that is not on it.
    """
    if start is not None and not isinstance(start, Mapping):
        raise TypeError(f"start must be a dict such as {{'h0': 0.1}}, found {start!r}")
    given = dict(start or {})
    names = [control.name for control in controls]
    for name in given:
        if name not in names:
            known = ", ".join(names) or "none"
            raise ValueError(f"start names {name!r}, which is no control here; known: {known}")
    return tuple(_index(c, given[c.name]) if c.name in given else 0 for c in controls)


def say(controls: Sequence[Control], position: Position) -> str:
    """Return a position in words: ``h0 = 0.1, step = 40``.

    Parameters
    ----------
    controls : sequence of Control
        The controls of a figure.
    position : tuple of int
        One index for each control.

    Returns
    -------
    str
        The labels and values, empty when there are no controls.
    """
    return ", ".join(
        f"{control.label} = {control.texts[index]}"
        for control, index in zip(controls, position, strict=True)
    )


def _read(name: str, given: object) -> Control:
    if isinstance(given, tuple):
        return Control(name, _range_values(name, given), is_range=True)
    if isinstance(given, list):
        return Control(name, _choice_values(name, given), is_range=False)
    raise TypeError(
        f"{name} must be a range or a list, found {given!r}; "
        f"write {name}=(low, high, step) or {name}=[first, second]"
    )


def _range_values(name: str, given: tuple[object, ...]) -> tuple[Value, ...]:
    numbers = [item for item in given if isinstance(item, Real) and not isinstance(item, bool)]
    if len(given) != 3 or len(numbers) != 3:
        raise TypeError(f"{name} must be three numbers (low, high, step), found {given!r}")
    if not all(math.isfinite(number) for number in numbers):
        raise ValueError(f"{name} must be finite, found {given!r}; choose numbers")
    # Decimal arithmetic on the numbers as they are written: 0.1 + 2 * 0.05 is 0.2.
    low, high, step = (Decimal(_written(number)) for number in numbers)
    if step <= 0:
        raise ValueError(f"{name} has step {step}; the step must be positive")
    if high < low:
        raise ValueError(f"{name} runs from {low} to {high}; write the smaller one first")
    steps = round((high - low) / step)
    _check_frames(steps + 1)
    if abs((high - low) / step - steps) > Decimal("1e-9"):
        raise ValueError(
            f"{name} has step {step}, which does not divide the range from {low} to {high}; "
            f"end at {low + steps * step}, or choose another step"
        )
    kind = int if all(isinstance(number, Integral) for number in numbers) else float
    return (*(kind(low + i * step) for i in range(steps)), kind(high))


def _choice_values(name: str, given: list[object]) -> tuple[Value, ...]:
    if not given:
        raise ValueError(f"{name} is an empty list; give at least one choice")
    values: list[Value] = []
    for item in given:
        plain = item.item() if hasattr(item, "item") else item  # a NumPy scalar
        if not isinstance(plain, (bool, int, float, str)):
            raise TypeError(f"{name} holds {item!r}; a choice must be a string, number or bool")
        values.append(plain)
    texts = [_text(value) for value in values]
    if len(set(texts)) < len(texts):
        raise ValueError(f"{name} holds a choice twice, found {given!r}; name each once")
    return tuple(values)


def _index(control: Control, wanted: object) -> int:
    for index, value in enumerate(control.values):
        if isinstance(value, bool) != isinstance(wanted, bool):
            continue  # True equals 1, and is another choice
        if value == wanted:
            return index
        if isinstance(value, float) and isinstance(wanted, Real) and math.isclose(value, wanted):
            return index
    raise ValueError(f"start has {control.name} = {wanted!r}, which is not a value of {control}")


def _check_frames(count: int) -> None:
    if count > FRAME_LIMIT:
        raise ValueError(
            f"{count} frames asked for, the limit is {FRAME_LIMIT}; "
            "take a coarser step, a shorter range or fewer parameters"
        )


def _written(number: Real) -> str:
    return str(int(number)) if isinstance(number, Integral) else repr(float(number))


def _text(value: Value) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value)
