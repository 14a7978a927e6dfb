"""Named data become a line of text, to be read, and to be compared within rounding."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any, TypeAlias

import numpy as np
from matplotlib.colors import CSS4_COLORS, TABLEAU_COLORS, to_hex
from numpy.typing import NDArray

Entry: TypeAlias = tuple[int, str, str, str, Mapping[str, Any]]

NOISE = 1e-9
"""A number below this part of its data's scale is rounding noise, and written as 0.0."""

ABOUT = "≈ "
"""Before a number that a tie in the triangulation may change."""

MESH = "mesh"
"""The gid of what shows a mesh at rest: ties change its data a little, its counts and means not."""

UNSETTLED = "unsettled mesh"
"""The gid of what shows a mesh that never came to rest: of its data only the size is repeatable."""

_COLOURS = {to_hex(code): name for name, code in (CSS4_COLORS | TABLEAU_COLORS).items()}


def write(entries: Iterable[Entry]) -> str:
    """Return a line for each entry, indented by its depth.

    Parameters
    ----------
    entries : iterable of (depth, kind, label, gid, fields)
        Data by name: counts, numbers, words, tuples of them, arrays, colours, or fields again.

    Returns
    -------
    str
        Lines in which a number with a point or an exponent is a float of seven digits, and one with
        neither is a count. "≈" stands before what a tie may change: see `MESH` and `UNSETTLED`.

    Notes
    -----
    Of an array the text gives the mean, the root mean square, and the trend: the mean of the values
    times a weight that grows from -1 to 1 along each axis. A transposed image has the same mean and
    the same root mean square, and another trend. A mesh has none: the order of its triangles may
    change.
    """
    lines = []
    for depth, kind, label, gid, fields in entries:
        name = f"{kind} {_quoted(label)}" if label else kind
        said = _fields(fields, gid)
        lines.append(f"{'  ' * depth}{name}: {said}" if said else f"{'  ' * depth}{name}")
    return "\n".join(lines)


def _fields(fields: Mapping[str, Any], gid: str) -> str:
    said = (_field(name, value, gid) for name, value in fields.items())
    return ", ".join(words for words in said if words)


def _field(name: str, value: Any, gid: str) -> str:
    if isinstance(value, (bool, np.bool_)):
        return name if value else ""
    if isinstance(value, (int, np.integer)):
        return f"{ABOUT if gid == UNSETTLED else ''}{value} {name}"
    if isinstance(value, np.ndarray) and name.endswith("colour"):
        said = _colours(value, gid)
    else:
        said = _value(value, gid)
    return f"{name} {said}".strip() if said else ""


def _value(value: Any, gid: str) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return _quoted(value) if value else ""
    if isinstance(value, Mapping):
        return f"({_fields(value, gid)})"
    if isinstance(value, (list, tuple)):
        scale = max((abs(item) for item in value if isinstance(item, float)), default=0.0)
        return " ".join(_item(item, gid, scale) for item in value)
    if isinstance(value, np.ndarray):
        return _array(value, gid) if value.size else ""
    return _about(gid) + _number(value)


def _item(item: Any, gid: str, scale: float) -> str:
    if isinstance(item, (int, np.integer)):
        return str(item)
    return _about(gid) + _number(item, scale) if isinstance(item, float) else _value(item, gid)


def _about(gid: str) -> str:
    return ABOUT if gid in (MESH, UNSETTLED) else ""


def _array(values: NDArray[Any], gid: str) -> str:
    array: NDArray[np.float64] = np.ma.filled(np.ma.asarray(values, dtype=float), np.nan)
    finite = np.isfinite(array)
    missing = f"{np.count_nonzero(~finite)} missing"
    if not finite.any():
        return missing
    rms = float(np.sqrt(np.mean(array[finite] ** 2)))
    said = [f"rms {_about(gid)}{_number(rms)}"]
    if gid != UNSETTLED:
        said.insert(0, f"mean {_number(float(array[finite].mean()), rms)}")
    for axis, count in enumerate(array.shape):
        if count > 1 and not _about(gid):
            others = tuple(other for other in range(array.ndim) if other != axis)
            weights = np.expand_dims(np.linspace(-1, 1, count), others)
            trend = float(np.mean((array * weights)[finite]))
            said.append(f"trend {_number(trend, rms)}")
    return " ".join(said if finite.all() else [*said, missing])


def _number(value: float, scale: float = 0.0) -> str:
    if abs(value) <= NOISE * scale or value == 0:
        return "0.0"
    text = f"{value:.7g}"
    return text if set(text) & set(".en") else text + ".0"


def _colours(rgba: NDArray[np.float64], gid: str) -> str:
    distinct = sorted({_colour(one, gid) for one in rgba})
    if len(distinct) <= 1:
        return distinct[0] if distinct else "none"
    names = (
        " ".join(distinct)
        if len(distinct) <= 3
        else f"{ABOUT if gid == UNSETTLED else ''}{len(rgba)} colours"
    )
    channels = zip(("red", "green", "blue", "alpha"), rgba.T, strict=True)
    said = "; ".join(f"{name} {_array(channel, gid)}" for name, channel in channels)
    return f"{names} ({said})"


def _colour(rgba: NDArray[np.float64], gid: str) -> str:
    *rgb, alpha = (float(part) for part in rgba)
    if alpha == 0:
        return "none"
    # A code such as #12e456 would be read as a number by whoever compares these texts.
    code = f"rgb({' '.join(str(round(255 * part)) for part in rgb)})"
    name = _COLOURS.get(to_hex((rgb[0], rgb[1], rgb[2])), code)
    return name if alpha == 1 else f"{name} alpha {_about(gid)}{_number(alpha)}"


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
