"""The frames of a figure become one piece of HTML that asks nobody for anything."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files

WEIGHT_LIMIT = 1_200_000
"""Bytes of HTML for one figure; a page may hold several, and a phone has to fetch them."""

_PLAY = (
    '<svg viewBox="0 0 16 16" aria-hidden="true" focusable="false">'
    '<path class="explore-triangle" d="M4 2v12l10-6z"/>'
    '<path class="explore-bars" d="M3 2h4v12H3zM9 2h4v12H9z"/></svg>'
)


@dataclass(frozen=True)
class Row:
    """What the page shows of one control.

    Parameters
    ----------
    label : str
        Its name.
    texts : tuple of str
        Its values.
    start : int
        The index of the start value.
    is_range : bool
        True for a slider with a play button, False for a list.
    """

    label: str
    texts: tuple[str, ...]
    start: int
    is_range: bool


def page(frames: Sequence[bytes], rows: Sequence[Row], size: tuple[int, int], values: str) -> str:
    """Return the HTML of a figure with its controls.

    Parameters
    ----------
    frames : sequence of bytes
        A WebP file for each combination of values; the last control runs fastest.
    rows : sequence of Row
        The controls.
    size : tuple of int, pixels
        Width and height of the picture on the page.
    values : str
        The start values in words, for paper and for readers without scripts.

    Returns
    -------
    str
        An element ``<div class="explore">`` with its style sheet and its script.

    Raises
    ------
    ValueError
        If it weighs more than `WEIGHT_LIMIT`.
    """
    start = 0
    for row in rows:
        start = start * len(row.texts) + row.start
    html = "\n".join(
        [
            '<div class="explore">',
            f"<style>\n{_asset('explore.css')}</style>",
            f'<img class="explore-picture" alt="" width="{size[0]}" height="{size[1]}" '
            f'decoding="sync" src="data:image/webp;base64,{_base64(frames[start])}">',
            *(_controls(frames, rows, start, values) if rows else []),
            "</div>",
        ]
    )
    _check_weight(len(html.encode()), len(frames))
    return html


def _controls(frames: Sequence[bytes], rows: Sequence[Row], start: int, values: str) -> list[str]:
    stored = list(dict.fromkeys(frames))
    number = {frame: index for index, frame in enumerate(stored)}
    data = {
        "texts": [row.texts for row in rows],
        "order": [number[frame] for frame in frames],
        # The start frame is in the page already: the script takes it from there.
        "frames": [None if frame == frames[start] else _base64(frame) for frame in stored],
    }
    return [
        f'<p class="explore-values">{escape(values)}</p>',
        '<div class="explore-controls" role="group" aria-label="Controls of the picture" hidden>',
        *(_row(row) for row in rows),
        "</div>",
        # "<" would let a value end the script element.
        f'<script type="application/json" class="explore-data">{_json(data)}</script>',
        f"<script>\n{_asset('explore.js')}</script>",
    ]


def _row(row: Row) -> str:
    label, text = escape(row.label), escape(row.texts[row.start])
    if row.is_range:
        button = (
            f'<button type="button" class="explore-play" data-label="{label}" '
            f'aria-label="Play {label}">{_PLAY}</button>'
        )
        # Firefox would bring back the slider of the last visit, not its picture: autocomplete off.
        control = (
            f'<input type="range" min="0" max="{len(row.texts) - 1}" step="1" value="{row.start}" '
            f'aria-valuetext="{text}" autocomplete="off">'
        )
        # The slider says its value itself; an output that spoke too would speak at every frame.
        # The longest value keeps its room, so that the slider does not change its length.
        room = max(len(value) for value in row.texts)
        output = f'<output aria-live="off" style="min-width: {room}ch">{text}</output>'
    else:
        button = output = ""
        options = "".join(
            f'<option value="{index}"{" selected" * (index == row.start)}>{escape(value)}</option>'
            for index, value in enumerate(row.texts)
        )
        control = f'<select autocomplete="off">{options}</select>'
    name = f'<label><span class="explore-name">{label}</span>{control}</label>'
    return f'<div class="explore-row">{button}{name}{output}</div>'


def _check_weight(weight: int, count: int) -> None:
    if weight > WEIGHT_LIMIT:
        raise ValueError(
            f"the figure weighs {weight / 1e6:.2f} MB on the page with its {count} frames, "
            f"the limit is {WEIGHT_LIMIT / 1e6:.2f} MB; "
            "take a coarser step, fewer values, a smaller figure or fewer lines in it"
        )


def _asset(name: str) -> str:
    return files("distmesh_edu").joinpath("data", name).read_text(encoding="utf-8")


def _base64(content: bytes) -> str:
    return base64.b64encode(content).decode("ascii")


def _json(data: object) -> str:
    return json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
