"""A figure in words: whatever changes in the figure changes the text, and nothing else does."""

import io
import re

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import LineCollection, PatchCollection, PolyCollection
from matplotlib.colors import ListedColormap, LogNorm
from matplotlib.patches import Circle, ConnectionPatch, Ellipse, FancyArrowPatch, Polygon
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from distmesh_edu._artists import read
from distmesh_edu._words import write

mpl.use("agg")

X = np.linspace(0, 1, 11)
GRID = np.add.outer(X**2, X[:6])
POINTS = np.array([[0, 0], [1, 0], [1.1, 1], [0, 1], [0.5, 0.4]])
TRIANGLES = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])


def text_of(draw, **changes):
    """Return the text of a figure with one pair of axes that `draw` fills."""
    fig = plt.figure()
    try:
        draw(fig, **changes)
        return write(read(fig))
    finally:
        plt.close(fig)


def on_axes(method, *names, **fixed):
    """Make a drawing function that calls a method of the axes with named data, then keywords."""

    def draw(fig, **changes):
        ax = fig.add_subplot(projection=projection)
        given = {**fixed, **changes}
        data = [given.pop(name) for name in names]
        getattr(ax, method)(*data, **given)

    projection = fixed.pop("projection", None)
    return draw


def changed(values, index=2):
    values = np.array(values, dtype=float)
    values.flat[index] += 0.01
    return values


def setter(name, **fixed):
    return lambda fig, **changes: fig.add_subplot().set(
        **{name: changes.get("value", fixed["value"])}
    )


def add(make, **fixed):
    """Make a drawing function that adds one artist to the axes."""

    def draw(fig, **changes):
        ax = fig.add_subplot()
        ax.set(xlim=(0, 2), ylim=(0, 2))
        ax.add_artist(make(**{**fixed, **changes}))

    return draw


def legend(fig, name="exact", colour="red", title="what", **look):
    ax = fig.add_subplot()
    ax.legend(handles=[plt.Line2D([], [], color=colour, label=name, **look)], title=title)


def twin(fig, y=X, where="twinx"):
    ax = fig.add_subplot()
    ax.plot(X)
    getattr(ax, where)().plot(y)


def inset(fig, y=X):
    fig.add_subplot().inset_axes([0.1, 0.1, 0.4, 0.4]).plot(y)


def colourbar(fig, top=1.0, label="size"):
    ax = fig.add_subplot()
    fig.colorbar(ax.imshow(GRID, vmax=top), label=label)


def words(fig, suptitle="all", note="free", place=0.4, face="white"):
    fig.suptitle(suptitle)
    fig.text(place, 0.5, note)
    fig.add_subplot()
    fig.set_facecolor(face)


def panels(fig, shape=(1, 2), y=X):
    fig.subplots(*shape).flat[1].plot(y)


def part(fig, y=X, title="left"):
    left, _ = fig.subfigures(1, 2)
    left.suptitle(title)
    left.subplots().plot(y)


def view(fig, elev=30, top=1.0):
    ax = fig.add_subplot(projection="3d")
    ax.view_init(elev=elev)
    ax.set_zlim(0, top)


def in_space(method, z=X[:5], colour="red"):
    def draw(fig, z=z, colour=colour):
        ax = fig.add_subplot(projection="3d")
        ax.set(xlim=(0, 1), ylim=(0, 1), zlim=(0, 1))
        getattr(ax, method)(POINTS[:, 0], POINTS[:, 1], z, color=colour)

    return draw


def faces_in_space(fig, z=X[:5], gid=None, triangles=TRIANGLES, **look):
    ax = fig.add_subplot(projection="3d")
    faces = Poly3DCollection(np.column_stack((POINTS, z))[triangles], **look)
    faces.set_gid(gid)
    ax.add_collection(faces, autolim=False)
    ax.set(xlim=(0, 1), ylim=(0, 1), zlim=(0, 1))


def ticks(fig, places=(0, 1, 3), names=("a", "b", "c")):
    ax = fig.add_subplot()
    ax.set_xticks(places, names)
    ax.set_xlim(0, 3)


def dashed(fig, dashes=(3, 2)):
    fig.add_subplot().plot(X, dashes=dashes)


# A drawing, and changes each of which must show.
CASES = {
    "line": (
        on_axes("plot", "x", "y", x=X, y=X**2, label="exact"),
        [
            {"x": changed(X)},
            {"y": changed(X**2)},
            {"y": X[::-1] ** 2},
            {"y": np.where(X == 1, np.nan, X**2)},
            {"label": "exakt"},
            {"color": "red"},
            {"linestyle": "--"},
            {"linewidth": 2},
            {"marker": "o"},
            {"drawstyle": "steps"},
            {"alpha": 0.5},
            {"visible": False},
        ],
    ),
    "marker": (
        on_axes("plot", "x", x=X, marker="o", ls="none"),
        [{"marker": "s"}, {"ms": 3}, {"mfc": "red"}, {"mec": "red"}],
    ),
    "dashes": (dashed, [{"dashes": (3, 1)}]),
    "scatter": (
        on_axes("scatter", "x", "y", x=X, y=X, c=X, s=30),
        [{"x": changed(X)}, {"y": changed(X)}, {"c": changed(X)}, {"s": 31}, {"c": "red"}]
        + [{"cmap": "magma"}, {"vmax": 2}, {"marker": "s"}, {"edgecolor": "k"}, {"norm": "log"}]
        + [{"c": X[::-1]}, {"c": ["r"] * 5 + ["b"] * 6}, {"alpha": 0.5}],
    ),
    "colours of points": (
        on_axes("scatter", "x", "y", x=X, y=X, c=["r"] * 5 + ["b"] * 6),
        [{"c": ["r"] * 6 + ["b"] * 5}, {"c": ["b"] * 6 + ["r"] * 5}],
    ),
    "segments": (
        add(LineCollection, segments=POINTS[TRIANGLES], colors="red", linewidths=1),
        [{"segments": changed(POINTS, 3)[TRIANGLES]}, {"colors": "blue"}, {"linewidths": 2}]
        + [{"linestyles": "dashed"}, {"array": X[:4]}, {"segments": POINTS[TRIANGLES[:3]]}],
    ),
    "polygons": (
        add(PolyCollection, verts=POINTS[TRIANGLES], facecolors="red", edgecolors="k"),
        [{"verts": changed(POINTS, 3)[TRIANGLES]}, {"facecolors": "blue"}, {"edgecolors": "r"}]
        + [{"hatch": "/"}, {"alpha": 0.2}, {"facecolors": ["r", "r", "b", "b"]}],
    ),
    "circles": (
        add(lambda r, **look: PatchCollection([Circle((0, 0), r), Circle((1, 1), 1)], **look), r=1),
        [{"r": 1.01}, {"facecolor": "red"}],
    ),
    "triplot": (
        on_axes("triplot", "x", "y", "t", x=POINTS[:, 0], y=POINTS[:, 1], t=TRIANGLES, color="r"),
        [{"x": changed(POINTS[:, 0])}, {"t": TRIANGLES[:3]}, {"color": "b"}, {"lw": 3}],
    ),
    "tripcolor": (
        on_axes(
            "tripcolor", "x", "y", "t", "c", x=POINTS[:, 0], y=POINTS[:, 1], t=TRIANGLES, c=X[:4]
        ),
        [{"y": changed(POINTS[:, 1])}, {"c": changed(X[:4])}, {"cmap": "magma"}]
        + [{"edgecolors": "k"}, {"c": X[3::-1]}, {"vmin": -1}],
    ),
    "gouraud": (
        on_axes(
            "tripcolor",
            "x",
            "y",
            "t",
            "c",
            x=POINTS[:, 0],
            y=POINTS[:, 1],
            t=TRIANGLES,
            c=X[:5],
            shading="gouraud",
        ),
        [{"y": changed(POINTS[:, 1])}, {"c": changed(X[:5])}],
    ),
    "pcolormesh": (
        on_axes("pcolormesh", "x", "y", "z", x=X[:6], y=X, z=GRID, shading="nearest"),
        [{"x": X[:6] * 1.01}, {"z": changed(GRID)}, {"cmap": ListedColormap(["r", "b"])}]
        + [{"norm": LogNorm(0.1, 2)}, {"z": GRID[::-1]}, {"edgecolors": "k"}],
    ),
    "contour": (
        on_axes("contour", "x", "y", "z", x=X[:6], y=X, z=GRID, levels=[0.2, 0.5, 1.0]),
        [{"z": changed(GRID, 30)}, {"levels": [0.2, 0.5, 1.1]}, {"colors": "k"}, {"x": X[1:7]}]
        + [{"linewidths": 3}, {"linestyles": "dashed"}, {"cmap": "magma"}],
    ),
    "one contour": (
        on_axes("contour", "z", z=GRID, levels=[0.5], colors="k"),
        [{"colors": "r"}, {"levels": [0.6]}],
    ),
    "contourf": (
        on_axes("contourf", "z", z=GRID, levels=4),
        [{"z": changed(GRID, 30)}, {"levels": 5}, {"cmap": "magma"}, {"alpha": 0.3}],
    ),
    "fill_between": (
        on_axes("fill_between", "x", "y", x=X, y=X**2),
        [{"y": changed(X**2)}, {"color": "red"}, {"y2": 0.1}, {"hatch": "x"}],
    ),
    "quiver": (
        on_axes("quiver", "x", "y", "u", "v", x=X, y=X, u=X, v=X),
        [{"x": changed(X)}, {"u": changed(X)}, {"v": changed(X)}, {"color": "red"}],
    ),
    "streamplot": (
        on_axes("streamplot", "x", "y", "u", "v", x=X[:6], y=X, u=GRID, v=GRID + 1, density=0.3),
        [{"v": GRID + 2}, {"color": "red"}, {"linewidth": 2}],
    ),
    "stem": (on_axes("stem", "x", "y", x=X, y=X), [{"y": changed(X)}, {"bottom": 0.1}]),
    "errorbar": (
        on_axes("errorbar", "x", "y", "e", x=X, y=X, e=X),
        [{"e": changed(X)}, {"y": changed(X)}, {"ecolor": "r"}],
    ),
    "image": (
        on_axes("imshow", "z", z=GRID),
        [{"z": changed(GRID)}, {"z": GRID.T}, {"z": GRID[::-1]}, {"z": GRID[:, ::-1]}]
        + [{"extent": (0, 1, 0, 2)}, {"cmap": "magma"}, {"vmax": 9}, {"origin": "lower"}]
        + [{"alpha": 0.4}, {"interpolation": "nearest"}],
    ),
    "square image": (on_axes("imshow", "z", z=GRID[:6]), [{"z": GRID[:6].T}]),
    "image in colour": (
        on_axes("imshow", "z", z=GRID[:6, :, None] * [0.1, 0.2, 0.3]),
        [{"z": GRID[:6, :, None] * [0.1, 0.3, 0.2]}],
    ),
    "bars": (
        on_axes("bar", "x", "h", x=X, h=X, color="r", label="count"),
        [{"h": changed(X)}, {"x": changed(X)}, {"color": "b"}, {"edgecolor": "k"}, {"width": 0.5}]
        + [{"h": X[::-1]}, {"hatch": "/"}, {"color": ["r"] * 10 + ["b"]}, {"linewidth": 2}],
    ),
    "named bars": (
        on_axes("bar", "x", "h", x=["a", "b"], h=[1, 2]),
        [{"x": ["a", "c"]}, {"h": [1, 3]}],
    ),
    "histogram": (on_axes("hist", "x", x=X), [{"x": X**2}, {"bins": 5}, {"histtype": "step"}]),
    "circle": (
        add(Circle, xy=(0, 0), radius=1.0),
        [{"xy": (0, 0.1)}, {"radius": 1.1}, {"facecolor": "r"}, {"linestyle": "--"}],
    ),
    "ellipse": (add(Ellipse, xy=(0, 0), width=1, height=2), [{"height": 2.1}, {"angle": 10}]),
    "polygon": (add(Polygon, xy=POINTS), [{"xy": changed(POINTS)}, {"alpha": 0.5}]),
    "arrow": (
        on_axes("arrow", "x", "y", "u", "v", x=0, y=0, u=1, v=1),
        [{"u": 1.1}, {"x": 0.1}, {"color": "red"}],
    ),
    "curved arrow": (
        add(FancyArrowPatch, posA=(0, 0), posB=(1, 1)),
        [{"posA": (0, 0.1)}, {"posB": (1, 1.1)}, {"color": "r"}],
    ),
    "connection": (
        add(ConnectionPatch, xyA=(0, 0), xyB=(1, 1), coordsA="data"),
        [{"xyA": (0, 0.1)}, {"xyB": (1, 1.1)}],
    ),
    "spans": (on_axes("axvspan", "a", "b", a=0, b=1), [{"a": 0.1}, {"color": "red"}]),
    "rules": (on_axes("axhline", "y", y=0.5), [{"y": 0.6}, {"color": "red"}, {"ls": ":"}]),
    "text": (
        on_axes("text", "x", "y", "s", x=0.1, y=0.2, s="here"),
        [{"s": "there"}, {"x": 0.2}, {"y": 0.1}, {"color": "r"}, {"size": 20}, {"rotation": 30}]
        + [{"bbox": {"facecolor": "r"}}, {"alpha": 0.5}],
    ),
    "annotation": (
        on_axes(
            "annotate", "s", "xy", "to", s="a", xy=(0, 0), to=(1, 1), arrowprops={"color": "r"}
        ),
        [{"s": "b"}, {"xy": (0, 0.1)}, {"to": (1, 1.1)}, {"arrowprops": {"color": "b"}}],
    ),
    "table": (on_axes("table", cellText=[["1", "2"]]), [{"cellText": [["1", "3"]]}]),
    "title": (setter("title", value="a"), [{"value": "b"}]),
    "x label": (setter("xlabel", value="a"), [{"value": "b"}]),
    "y label": (setter("ylabel", value="a"), [{"value": "b"}]),
    "limits": (setter("xlim", value=(0, 1)), [{"value": (0, 1.1)}, {"value": (1, 0)}]),
    "scale": (setter("yscale", value="linear"), [{"value": "log"}]),
    "aspect": (setter("aspect", value="equal"), [{"value": "auto"}, {"value": 2}]),
    "face": (setter("facecolor", value="w"), [{"value": "r"}]),
    "ticks": (ticks, [{"places": (0, 1, 2)}, {"names": ("a", "b", "d")}]),
    "legend": (
        legend,
        [{"name": "other"}, {"colour": "blue"}, {"title": "how"}, {"ls": "--"}],
    ),
    "twin": (twin, [{"y": changed(X)}, {"where": "twiny"}]),
    "inset": (inset, [{"y": changed(X)}]),
    "colour bar": (colourbar, [{"top": 2.0}, {"label": "length"}]),
    "words of the figure": (
        words,
        [{"suptitle": "one"}, {"note": "bound"}, {"place": 0.5}, {"face": "0.9"}],
    ),
    "panels": (panels, [{"shape": (2, 1)}, {"y": changed(X)}]),
    "part of a figure": (part, [{"y": changed(X)}, {"title": "right"}]),
    "view": (view, [{"elev": 40}, {"top": 2.0}]),
    "line in space": (in_space("plot"), [{"z": changed(X[:5])}, {"colour": "b"}]),
    "points in space": (in_space("scatter"), [{"z": changed(X[:5])}, {"colour": "b"}]),
    "faces in space": (
        faces_in_space,
        [{"z": changed(X[:5])}, {"triangles": TRIANGLES[:3]}, {"facecolors": "r"}]
        + [{"facecolors": ["r", "r", "b", "b"]}, {"edgecolors": "r"}, {"linewidths": 3}]
        + [{"array": X[:4]}, {"alpha": 0.5}],
    ),
    "surface in space": (in_space("plot_trisurf"), [{"z": changed(X[:5])}, {"colour": "b"}]),
}


CHANGES = [
    pytest.param(draw, change, id=f"{name}: {', '.join(change)} {number}")
    for name, (draw, changes) in CASES.items()
    for number, change in enumerate(changes)
]


@pytest.mark.parametrize(("draw", "change"), CHANGES)
def test_a_change_shows(draw, change):
    assert text_of(draw, **change) != text_of(draw)


@pytest.mark.parametrize("name", CASES)
def test_the_same_figure_has_the_same_text(name):
    draw, _ = CASES[name]
    text = text_of(draw)
    assert text == text_of(draw)
    assert "0x" not in text
    assert "nan" not in text


@pytest.mark.parametrize("name", CASES)
def test_a_dropped_artist_shows(name):
    fig = plt.figure()
    CASES[name][0](fig)
    before = write(read(fig))
    axes = fig.axes[-1]
    for artist in [*axes.lines, *axes.collections, *axes.images, *axes.patches, *axes.texts]:
        artist.set_visible(False)
        after = write(read(fig))
        assert after != before
        before = after
    plt.close(fig)


def test_reading_leaves_the_picture_as_it_is():
    pictures = []
    for is_read in (False, True):
        fig = plt.figure()
        CASES["surface in space"][0](fig)
        fig.add_subplot(2, 2, 1).scatter(X, X, c=X)
        if is_read:
            write(read(fig))
        buffer = io.BytesIO()
        fig.savefig(buffer, format="png")
        pictures.append(buffer.getvalue())
        plt.close(fig)
    assert pictures[0] == pictures[1]


def test_a_line_reads_well():
    def draw(fig):
        angle = 2 * np.pi * np.arange(100) / 100
        fig.add_subplot().plot(np.cos(angle), 1 + np.sin(angle), label="circle", color="C0")

    (line,) = [one for one in text_of(draw).splitlines() if "line" in one and "points" in one]
    assert line.strip().startswith(
        'line "circle": 100 points, x mean 0.0 rms 0.7071068 trend -0.01010101'
    )
    assert "y mean 1.0 rms 1.224745" in line
    assert line.endswith('colour tab:blue, style "solid", width 1.5')


def test_floats_can_be_told_from_counts():
    text = text_of(on_axes("plot", "x", x=np.arange(11.0), lw=2))
    assert "11 points, x mean 5.0 rms" in text
    assert "width 2.0" in text


def test_a_colour_is_no_number():
    for colour in ("#12e456", "#0e1234", "#123456"):
        text = text_of(on_axes("plot", "x", x=X, color=colour))
        assert "#" not in text
        assert re.search(r"colour rgb\(\d+ \d+ \d+\)", text)


@pytest.mark.parametrize("method", ["triplot", "tripcolor"])
def test_a_mesh_gives_counts_and_means_and_the_rest_about(method):
    def draw(fig, triangles=TRIANGLES):
        ax = fig.add_subplot()
        quality = [X[:4]] if method == "tripcolor" else []
        made = getattr(ax, method)(*POINTS.T, triangles, *quality)
        for artist in made if isinstance(made, list) else [made]:
            artist.set_gid("mesh")

    (line,) = [
        one for one in text_of(draw).splitlines() if re.search(r"[1-9]\d* (points|paths)", one)
    ]
    for number in re.finditer(r"(\S+) (\S+) (?:-?\d+\.\d+)", line):
        assert number[1] == "mean" or number[2] in ("mean", "≈"), number[0]
    assert "trend" not in line
    reordered = text_of(draw, triangles=TRIANGLES[::-1])
    assert method == "tripcolor" or reordered == text_of(draw)


def test_an_unsettled_mesh_gives_nothing_but_sizes_and_all_about():
    def draw(fig, shift=0.0):
        (line,) = fig.add_subplot().plot(X + shift, X, "o-", color="red")
        line.set_gid("unsettled mesh")

    (line,) = [one for one in text_of(draw).splitlines() if "points" in one]
    assert re.search(r"≈ \d+ points", line)
    assert "mean" not in line
    assert "trend" not in line
    assert [n for n in re.finditer(r"(\S+) \d+\.\d+", line) if n[1] != "≈"] == []
    assert text_of(draw, shift=1.0) != text_of(draw)


@pytest.mark.parametrize("colours", [{}, {"array": X[:4]}, {"facecolors": ["r", "r", "b", "b"]}])
def test_a_mesh_in_space_gives_counts_and_means_and_the_rest_about(colours):
    def draw(fig, triangles=TRIANGLES):
        faces_in_space(fig, gid="mesh", triangles=triangles, **colours)

    (line,) = [one for one in text_of(draw).splitlines() if "Poly3DCollection" in one]
    assert "Poly3DCollection: 4 paths" in line
    for number in re.finditer(r"(\S+) (\S+) (?:-?\d+\.\d+)", line):
        assert number[1] == "mean" or number[2] in ("mean", "≈"), number[0]
    assert "trend" not in line
    if not colours:
        assert text_of(draw, triangles=TRIANGLES[::-1]) == text_of(draw)


def test_an_unsettled_mesh_in_space_gives_nothing_but_sizes_and_all_about():
    text = text_of(faces_in_space, gid="unsettled mesh", facecolors=["r", "r", "b", "b"])
    (line,) = [one for one in text.splitlines() if "Poly3DCollection" in one]
    assert re.search(r"≈ 4 paths, ≈ \d+ vertices, x rms ≈", line)
    assert "mean" not in line
    assert "trend" not in line
    assert [n for n in re.finditer(r"(\S+) \d+\.\d+", line) if n[1] != "≈"] == []
