"""What a figure is made of: the numbers, the colours and the words of every artist in it."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from functools import singledispatch
from itertools import groupby
from typing import Any, NamedTuple, TypeAlias

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.category import StrCategoryLocator
from matplotlib.collections import Collection, QuadMesh
from matplotlib.colors import to_rgba_array
from matplotlib.figure import Figure, FigureBase
from matplotlib.image import AxesImage, BboxImage, FigureImage
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import ConnectionPatch, FancyArrowPatch, Patch
from matplotlib.quiver import Barbs, Quiver
from matplotlib.spines import Spine
from matplotlib.table import Cell
from matplotlib.text import Annotation, Text
from matplotlib.ticker import FixedLocator, NullLocator
from numpy.typing import ArrayLike, NDArray

FloatArray: TypeAlias = NDArray[np.float64]
Fields: TypeAlias = dict[str, Any]

_KINDS = {"Line2D": "line", "AxesImage": "image", "Text": "text", "Annotation": "annotation"}

_STROKES = {"-": "solid", "--": "dashed", "-.": "dashdot", ":": "dotted", "None": "none"}


class Entry(NamedTuple):
    """One artist, or a run of bars that look alike."""

    depth: int
    kind: str
    label: str
    gid: str
    fields: Fields


def read(figure: Figure) -> Iterator[Entry]:
    """Return an entry for each visible artist of a figure, from the outside in.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure, not drawn yet: drawing moves titles and axes about.

    Yields
    ------
    Entry
        Its fields are named data, each of them a count (int), a number (float), a word (str), a
        tuple of these, an array, colours (an array of shape (n, 4) under a name that ends in
        "colour"), or fields again. Where the order of data means nothing, they come sorted.
    """
    yield from _walk(figure, 0)


def _walk(artist: Artist, depth: int) -> Iterator[Entry]:
    yield _entry([artist], depth)
    parts = [part for part in _parts(artist) if _is_seen(part)]
    for _, group in groupby(parts, key=_family):
        members = list(group)
        if len(members) > 1:
            yield _entry(members, depth + 1)
        else:
            yield from _walk(members[0], depth + 1)


def _entry(members: Sequence[Artist], depth: int) -> Entry:
    artist = members[0]
    kind = _KINDS.get(type(artist).__name__, type(artist).__name__)
    if artist is getattr(artist.axes, "title", None):
        kind = "title"
    fields = _patches(members) if isinstance(artist, Patch) else _fields(artist)
    return Entry(depth, kind, _label(artist), str(artist.get_gid() or ""), fields)


def _parts(artist: Artist) -> Iterable[Artist]:
    if isinstance(artist, Cell):
        return [artist.get_text()]
    if isinstance(artist, (Line2D, Collection, AxesImage, Patch, Text, Legend)):
        return []
    frame = getattr(artist, "patch", None)
    parts = artist.get_children()
    return [part for part in parts if part is not frame and not isinstance(part, (Spine, Axis))]


def _is_seen(artist: Artist) -> bool:
    return artist.get_visible() and not (type(artist) is Text and not artist.get_text())


def _family(artist: Artist) -> Hashable:
    if isinstance(artist, Patch) and not isinstance(artist, Cell):
        return type(artist), _label(artist), artist.get_gid(), str(_look(artist))
    return id(artist)


def _label(artist: Artist) -> str:
    label = str(artist.get_label() or "")
    return "" if label.startswith("_") else label  # Matplotlib's own, such as _child3


# ---- what an artist shows ----


@singledispatch
def _fields(_: Artist) -> Fields:
    return {}


@_fields.register(FigureBase)
def _figure(figure: Any) -> Fields:
    size = tuple(figure.get_size_inches()) if isinstance(figure, Figure) else None
    return {"inches": size, "colour": _rgba(figure.get_facecolor())}


@_fields.register(Axes)
def _axes(axes: Any) -> Fields:
    spec = axes.get_subplotspec()
    in_space = axes.name == "3d"
    return {
        "projection": "" if axes.name == "rectilinear" else axes.name,
        "cell": spec.get_geometry() if spec is not None else None,
        **{name: _axis(axes, name) for name in ("xyz" if in_space else "xy")},
        "aspect": axes.get_aspect(),
        "seen from": (axes.elev, axes.azim, axes.roll) if in_space else None,
        "colour": _rgba(axes.get_facecolor()) if axes.axison else None,
    }


def _axis(axes: Axes, name: str) -> Fields:
    axis = getattr(axes, f"{name}axis")
    locator = axis.get_major_locator()
    # Ticks that Matplotlib chooses follow from the limits; these were set.
    is_set = isinstance(locator, (FixedLocator, NullLocator, StrCategoryLocator))
    places = [float(place) for place in locator()] if is_set else []
    return {
        "label": axis.label.get_text(),
        "limits": tuple(getattr(axes, f"get_{name}lim")()),
        "scale": axis.get_scale(),
        "hidden": not axis.get_visible(),
        "side": side if (side := axis.get_ticks_position()) in ("top", "right") else None,
        "no ticks": is_set and not places,
        "ticks": (*places, *axis.get_major_formatter().format_ticks(places)) if places else None,
    }


@_fields.register(Line2D)
def _line(line: Any) -> Fields:
    in_space = hasattr(line, "get_data_3d")
    data = line.get_data_3d() if in_space else line.get_data(orig=False)
    return {"points": len(data[0]), **_columns(data), **_look(line)}


@_fields.register(Collection)
def _collection(collection: Any) -> Fields:
    _project(collection)
    paths = [] if isinstance(collection, QuadMesh) else collection.get_paths()
    vertices = np.concatenate([np.empty((0, 2)), *(path.vertices for path in paths)])
    if isinstance(collection, QuadMesh):
        vertices = np.reshape(np.asarray(collection.get_coordinates()), (-1, 2))
    offsets = np.ma.filled(collection.get_offsets(), np.nan)
    if hasattr(collection, "do_3d_projection"):  # the farthest comes first
        offsets = np.sort(offsets, axis=0)
    arrows = {"Quiver": "UV", "Barbs": "uv"} if isinstance(collection, (Quiver, Barbs)) else {}
    return {
        "paths": len(paths),
        "vertices": len(vertices),
        **_columns(np.sort(vertices, axis=0).T),
        **({"offsets": len(offsets), **_columns(offsets.T, "offset ")} if offsets.any() else {}),
        **{name: getattr(collection, name) for name in arrows.get(type(collection).__name__, "")},
        "sizes": np.asarray(collection.get_sizes()) if hasattr(collection, "get_sizes") else None,
        **_mapping(collection),
        **_look(collection),
    }


@_fields.register(AxesImage)
@_fields.register(FigureImage)
@_fields.register(BboxImage)
def _image(image: Any) -> Fields:
    array = np.ma.asarray(image.get_array())
    return {
        "shape": array.shape,
        **(_mapping(image) if array.ndim == 2 else {"values": array}),
        "extent": tuple(image.get_extent()) if hasattr(image, "get_extent") else None,
        "origin": image.origin,
        "interpolation": image.get_interpolation(),
        "alpha": image.get_alpha(),
    }


def _mapping(artist: Any) -> Fields:
    """Values that a colour map turns into colours."""
    if artist.get_array() is None:
        return {}
    artist.norm.autoscale_None(artist.get_array())  # as drawing would
    colours = artist.get_cmap()
    is_known = colours.name in mpl.colormaps
    return {
        "values": artist.get_array(),
        "colours": colours.name,
        "own colour": None if is_known else _rgba(colours(np.linspace(0, 1, 5))),
        "norm": type(artist.norm).__name__,
        "from": artist.get_clim(),
        "levels": tuple(getattr(artist, "levels", ())),
        "boundaries": tuple(getattr(artist.norm, "boundaries", ())),
    }


def _patches(patches: Sequence[Any]) -> Fields:
    vertices = np.concatenate([_outline(patch) for patch in patches])
    counts = {"in all": len(patches), "vertices": len(vertices)}
    return {**counts, **_columns(vertices.T), **_look(patches[0])}


def _outline(patch: Any) -> FloatArray:
    if isinstance(patch, ConnectionPatch):
        return np.array([patch.xy1, patch.xy2], dtype=float)
    if isinstance(patch, FancyArrowPatch):  # its path is made for the screen; these are its ends
        ends, path = vars(patch)["_posA_posB"], vars(patch)["_path_original"]
        return np.array(path.vertices if ends is None else ends, dtype=float)
    _project(patch)
    vertices = patch.get_patch_transform().transform(patch.get_path().vertices)
    return np.asarray(vertices, dtype=float)


def _project(artist: Any) -> None:
    """Give an artist in space the outline that the reader sees of it."""
    if hasattr(artist, "do_3d_projection"):
        artist.axes.M = artist.axes.get_proj()
        artist.do_3d_projection()


@_fields.register(Text)
def _text(text: Any) -> Fields:
    in_space = hasattr(text, "get_position_3d")
    place = text.get_position_3d() if in_space else text.get_position()
    is_note = isinstance(text, Annotation)
    return {
        "": text.get_text(),
        "at": tuple(map(float, place)),
        "points to": tuple(map(float, text.xy)) if is_note else None,
        "arrow": _look(text.arrow_patch) if is_note and text.arrow_patch else None,
        **_look(text),
        "box": _look(text.get_bbox_patch()) if text.get_bbox_patch() else None,
    }


@_fields.register(Legend)
def _legend(legend: Any) -> Fields:
    entries = zip(legend.get_texts(), legend.legend_handles, strict=True)
    looks = [{"": text.get_text(), **_look(handle)} for text, handle in entries]
    return {"title": legend.get_title().get_text(), "entries": tuple(looks)}


# ---- how an artist looks ----


@singledispatch
def _look(_: Artist) -> Fields:
    return {}


@_look.register(Line2D)
def _line_look(line: Any) -> Fields:
    has_marker = line.get_marker() not in ("None", "none", " ", "", None)
    marker = {
        "": str(line.get_marker()),
        "size": line.get_markersize(),
        "face colour": _rgba(line.get_markerfacecolor()),
        "edge colour": _rgba(line.get_markeredgecolor()),
    }
    return {
        "colour": _rgba(line.get_color(), line.get_alpha()),
        "style": _STROKES.get(line.get_linestyle(), line.get_linestyle()),
        "dashes": vars(line).get("_unscaled_dash_pattern", (0, None))[1],
        "width": line.get_linewidth(),
        "drawn as": line.get_drawstyle() if line.get_drawstyle() != "default" else None,
        "marker": marker if has_marker else None,
    }


@_look.register(Collection)
def _collection_look(collection: Any) -> Fields:
    collection.update_scalarmappable()
    look: Fields = {}
    sides = {"face colour": collection.get_facecolor(), "edge colour": collection.get_edgecolor()}
    for name, colours in sides.items():
        if collection.get_array() is None or len(colours) == 1:  # else the values say it
            in_space = hasattr(collection, "do_3d_projection")
            look[name] = np.sort(colours, axis=0) if in_space else colours
    dashes = tuple(tuple(dashes) for _, dashes in collection.get_linestyle() if dashes)
    widths = tuple(np.unique(np.atleast_1d(collection.get_linewidth())))
    alpha = collection.get_alpha()
    return {
        **look,
        "width": widths,
        "dashes": dashes,
        "hatch": collection.get_hatch(),
        "alpha": alpha,
    }


@_look.register(Patch)
def _patch_look(patch: Any) -> Fields:
    return {
        "face colour": _rgba(patch.get_facecolor()),
        "edge colour": _rgba(patch.get_edgecolor()),
        "style": str(patch.get_linestyle()),
        "width": patch.get_linewidth(),
        "hatch": patch.get_hatch(),
    }


@_look.register(Text)
def _text_look(text: Any) -> Fields:
    turned = text.get_rotation() or None
    colour = _rgba(text.get_color(), text.get_alpha())
    return {"colour": colour, "size": text.get_fontsize(), "turned": turned}


def _rgba(colours: Any, alpha: float | None = None) -> FloatArray:
    return np.asarray(to_rgba_array(colours, alpha), dtype=float)


def _columns(columns: Iterable[ArrayLike], prefix: str = "") -> Fields:
    return {prefix + name: column for name, column in zip("xyz", columns, strict=False)}
