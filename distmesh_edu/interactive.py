"""Sliders on a figure: `explore`, which serves a live notebook, a printed page and a plain text."""

from __future__ import annotations

import asyncio
import base64
import inspect
import itertools
import os
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cached_property
from html import escape
from typing import Any

import ipywidgets

from ._artists import read
from ._controls import Control, Position, Value, find_start, read_controls, say
from ._page import Row, page
from ._pictures import FigureFunction, drawn, png, quick_png, size_on_page, webp
from ._words import write

STATIC_VARIABLE = "DISTMESH_EDU_STATIC"
"""The environment variable that is "1" while the pages of the book are built."""

PAUSE = 0.03
"""Seconds between a change and its picture: what was sent meanwhile is read first, and replaced."""

PLAY_STEP = 250
"""Milliseconds from one value to the next while a live figure plays."""

WIDGET = "application/vnd.jupyter.widget-view+json"


def explore(
    figure: FigureFunction,
    /,
    *,
    start: Mapping[str, Value] | None = None,
    **parameters: tuple[float, float, float] | list[Any],
) -> Explorer:
    """Put a slider on each range and a list on each choice of a figure's parameters.

    Parameters
    ----------
    figure : callable
        A pure function of its parameters that returns a Matplotlib figure.
    start : dict, optional
        The value a parameter starts with; its first value where none is given.
    **parameters : tuple or list
        For each parameter of `figure` either a range ``(low, high, step)`` or a list of choices:
        strings, numbers or bools. At most three.

    Returns
    -------
    Explorer
        What a notebook shows as the last value of a cell.

    Raises
    ------
    TypeError, ValueError
        If a parameter is not one of the figure's, a range or a list does not hold together, `start`
        is not on it, or the figure would need too many frames or too much room on the page.

    Notes
    -----
    The figure is drawn here for the first time, so that an exception in it stops the cell.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> def line(slope):
    ...     fig = Figure()
    ...     fig.subplots().plot([0, 1], [0, slope])
    ...     return fig
    >>> explore(line, slope=(0, 2, 1))
    <explore line: slope from 0 to 2, 3 values>
    """
    if not callable(figure):
        raise TypeError(
            f"figure must be a function that returns a figure, found {type(figure).__name__}; "
            "pass the function itself, without calling it"
        )
    _check_names(figure, parameters)
    controls = read_controls(parameters)
    return Explorer(figure, controls, find_start(controls, start))


class Explorer:
    """A figure with its controls, made by `explore`.

    Parameters
    ----------
    figure : callable
        A function that returns a Matplotlib figure.
    controls : sequence of Control
        Its parameters and their values.
    start : tuple of int
        The index of each control's start value.
    """

    def __init__(
        self, figure: FigureFunction, controls: Sequence[Control], start: Position
    ) -> None:
        self._figure = figure
        self._controls = tuple(controls)
        self._start = start
        self._texts: dict[Position, str] = {}
        with drawn(figure, self._values(start)) as made:
            self._texts[start] = write(read(made))
            self._size = size_on_page(made)
            self._png = png(made)
            self._first = quick_png(made)
        if _for_a_page():
            _ = self._html  # what is too heavy stops the cell as well
        for corner in self._corners():
            if corner not in self._texts:
                with drawn(figure, self._values(corner)) as made:
                    self._texts[corner] = write(read(made))

    @cached_property
    def widget(self) -> ipywidgets.VBox:
        """The live picture and its controls, for a layout of one's own."""
        live = _Live(self._controls, self._start, self._live_png)
        live.picture.value = self._first
        live.picture.layout.width = f"{self._size[0]}px"
        return live.box

    def __repr__(self) -> str:
        name = getattr(self._figure, "__name__", type(self._figure).__name__)
        return f"<explore {name}: {'; '.join(map(str, self._controls)) or 'no controls'}>"

    def _repr_mimebundle_(
        self, include: Collection[str] | None = None, exclude: Collection[str] | None = None
    ) -> dict[str, Any]:
        bundle: dict[str, Any] = {
            "text/plain": self._text(),
            "image/png": base64.b64encode(self._png).decode("ascii"),
        }
        if _for_a_page():
            bundle["text/html"] = self._html
        elif self._controls:
            bundle[WIDGET] = self.widget._repr_mimebundle_()[WIDGET]
        return {
            kind: content
            for kind, content in bundle.items()
            if (not include or kind in include) and kind not in (exclude or ())
        }

    def _values(self, position: Position) -> dict[str, Value]:
        pairs = zip(self._controls, position, strict=True)
        return {control.name: control.values[index] for control, index in pairs}

    def _corners(self) -> list[Position]:
        """Where the text looks: at the start, and with all controls lowest and highest."""
        lowest = tuple(0 for _ in self._controls)
        highest = tuple(len(control.values) - 1 for control in self._controls)
        return list(dict.fromkeys([self._start, lowest, highest]))

    def _text(self) -> str:
        lines = [repr(self)]
        for corner in self._corners():
            words = say(self._controls, corner)
            lines += [f"at {words}:"] if words else []
            lines.append(self._texts[corner])
        return "\n".join(lines)

    def _live_png(self, position: Position) -> bytes:
        with drawn(self._figure, self._values(position)) as made:
            return quick_png(made)

    @cached_property
    def _html(self) -> str:
        frames = []
        for position in itertools.product(*(range(len(c.values)) for c in self._controls)):
            with drawn(self._figure, self._values(position)) as made:
                if position in self._corners():
                    self._texts[position] = write(read(made))
                frames.append(webp(made))
        rows = [
            Row(control.label, control.texts, index, control.is_range)
            for control, index in zip(self._controls, self._start, strict=True)
        ]
        return page(frames, rows, self._size, say(self._controls, self._start))


class _Live:
    """Widgets whose picture follows the newest values, however many changes came before."""

    def __init__(
        self,
        controls: Sequence[Control],
        start: Position,
        render: Callable[[Position], bytes],
    ) -> None:
        self._controls = controls
        self._render = render
        self._wanted = self._shown = start
        self._is_scheduled = False
        # Messages may arrive in other threads, where pyplot must not be used: this one draws.
        try:
            self._loop: asyncio.AbstractEventLoop | None = asyncio.get_running_loop()
        except RuntimeError:
            self._loop = None
        layout = ipywidgets.Layout(max_width="100%", object_fit="contain")
        self.picture = ipywidgets.Image(format="png", layout=layout)
        self._complaint = ipywidgets.HTML()
        # One width for all names, so that the sliders stand below each other.
        width = f"{max((len(control.label) for control in controls), default=0) + 1}ch"
        self._inputs = [_input(c, index, width) for c, index in zip(controls, start, strict=True)]
        for one in self._inputs:
            one.observe(self._request, "index")
        rows = [_with_play(c, one) for c, one in zip(controls, self._inputs, strict=True)]
        self.box = ipywidgets.VBox([self.picture, self._complaint, *rows])

    def _request(self, _: object) -> None:
        self._wanted = tuple(one.index for one in self._inputs)
        if self._loop is None or not self._loop.is_running():
            self._draw()
        elif not self._is_scheduled:
            self._is_scheduled = True
            self._loop.call_soon_threadsafe(self._loop.call_later, PAUSE, self._draw)

    def _draw(self) -> None:
        self._is_scheduled = False
        wanted = self._wanted
        try:
            picture = self._render(wanted)
        except Exception as error:
            said = f"{type(error).__name__}: {error}"
            shown = say(self._controls, self._shown)
            self._complaint.value = escape(f"{said} (The picture still shows {shown}.)")
            return
        self._shown = wanted
        self.picture.value = picture
        self._complaint.value = ""


def _input(control: Control, index: int, width: str) -> ipywidgets.Widget:
    """Return a widget with a trait `index`: a slider for a range, a list for a choice."""
    kind = ipywidgets.SelectionSlider if control.is_range else ipywidgets.Dropdown
    options = [(text, number) for number, text in enumerate(control.texts)]
    style = {"description_width": width}
    return kind(options=options, value=index, description=control.label, style=style)


def _with_play(control: Control, slider: ipywidgets.Widget) -> ipywidgets.Widget:
    if not control.is_range:
        return slider
    last = len(control.values) - 1
    play = ipywidgets.Play(
        value=slider.index, min=0, max=last, interval=PLAY_STEP, show_repeat=False
    )
    link = ipywidgets.jslink((play, "value"), (slider, "index"))
    play.link = link  # else the link could be collected as garbage
    return ipywidgets.HBox([slider, play])


def _check_names(figure: FigureFunction, parameters: Mapping[str, object]) -> None:
    try:
        signature = inspect.signature(figure).parameters
    except ValueError:  # a built-in function does not tell
        return
    takes_any = any(one.kind is one.VAR_KEYWORD for one in signature.values())
    named = {
        name: one
        for name, one in signature.items()
        if one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY)
    }
    for name in parameters:
        if name not in named and not takes_any:
            known = ", ".join(named) or "none"
            raise ValueError(f"{name!r} is not a parameter of the figure; its parameters: {known}")
    for name, one in named.items():
        if one.default is one.empty and name not in parameters:
            raise ValueError(
                f"the figure's parameter {name!r} has no value; "
                f"give it a default, or a range {name}=(low, high, step)"
            )


def _for_a_page() -> bool:
    return os.environ.get(STATIC_VARIABLE) == "1"
