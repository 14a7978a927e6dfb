"""`explore`: what it accepts and refuses, and what it serves to a kernel, a page and a text."""

import base64
import io
import json
import re
import time
from html.parser import HTMLParser

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from distmesh_edu import _controls, _page, _pictures, interactive
from distmesh_edu.interactive import STATIC_VARIABLE, WIDGET, explore

mpl.use("agg")


@pytest.fixture
def static(monkeypatch):
    monkeypatch.setenv(STATIC_VARIABLE, "1")


@pytest.fixture(autouse=True)
def no_figure_is_left_open(monkeypatch):
    monkeypatch.delenv(STATIC_VARIABLE, raising=False)
    before = plt.get_fignums()
    yield
    assert plt.get_fignums() == before


def wave(n=1, shift=0.0, scheme="upwind"):
    """Draw a figure that differs for all its values, save that shifts above 1 look like 1."""
    fig, ax = plt.subplots(figsize=(2, 1.5))
    x = np.linspace(0, 1, 20)
    ax.plot(x, np.sin(n * x) + min(shift, 1.0), color="r" if scheme == "upwind" else "b")
    ax.set(xlim=(0, 1), ylim=(-1, 2))
    return fig


def bundle(explorer, **which):
    return explorer._repr_mimebundle_(**which)


# ---- the values ----


def test_a_range_counts_in_decimals():
    (control,) = _controls.read_controls({"h0": (0.1, 0.4, 0.05)})
    assert control.values == (0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4)
    assert control.texts == ("0.1", "0.15", "0.2", "0.25", "0.3", "0.35", "0.4")


def test_a_range_of_integers_stays_one():
    (control,) = _controls.read_controls({"n_steps": (np.int64(0), 6, 2)})
    assert control.values == (0, 2, 4, 6)
    assert all(type(value) is int for value in control.values)
    assert control.label == "n steps"


def test_a_range_ends_where_it_says_and_passes_zero():
    (control,) = _controls.read_controls({"a": (-1, 1, 1 / 3)})
    assert (control.values[0], control.values[-1], len(control.values)) == (-1.0, 1.0, 7)
    (control,) = _controls.read_controls({"a": (-0.1, 0.1, 0.05)})
    assert control.values == (-0.1, -0.05, 0.0, 0.05, 0.1)


def test_start_tells_true_from_one():
    controls = _controls.read_controls({"a": [1, True, "x"], "b": (0.1, 0.4, 0.1)})
    assert _controls.find_start(controls, {"a": True, "b": 0.1 + 0.2}) == (1, 2)


BAD = {
    "not callable": (lambda: explore(3), TypeError, "figure"),
    "a figure": (lambda: explore(Figure()), TypeError, "without calling it"),
    "unknown": (lambda: explore(wave, m=(0, 1, 1)), ValueError, "'m'.*n, shift, scheme"),
    "missing": (lambda: explore(lambda h0: wave(h0)), ValueError, "'h0'"),
    "a number": (lambda: explore(wave, n=3), TypeError, "n must be.*3"),
    "two numbers": (lambda: explore(wave, n=(0, 1)), TypeError, "low, high, step"),
    "words": (lambda: explore(wave, n=(0, 1, "1")), TypeError, "low, high, step"),
    "a bool": (lambda: explore(wave, n=(0, 1, True)), TypeError, "low, high, step"),
    "infinite": (lambda: explore(wave, n=(0, float("inf"), 1)), ValueError, "finite"),
    "zero step": (lambda: explore(wave, n=(0, 1, 0)), ValueError, "step 0.*positive"),
    "negative step": (lambda: explore(wave, n=(0, 1, -1)), ValueError, "step -1.*positive"),
    "backwards": (lambda: explore(wave, n=(2, 1, 1)), ValueError, "from 2 to 1"),
    "dividing": (lambda: explore(wave, shift=(0, 1, 0.3)), ValueError, "0.3.*divide.*0.9"),
    "empty": (lambda: explore(wave, scheme=[]), ValueError, "scheme is an empty list"),
    "a choice twice": (lambda: explore(wave, scheme=["a", "a"]), ValueError, "twice"),
    "an odd choice": (lambda: explore(wave, scheme=[None]), TypeError, "None"),
    "four": (
        lambda: explore(lambda **_: wave(), a=[1], b=[1], c=[1], d=[1]),
        ValueError,
        "at most 3.*a, b, c, d",
    ),
    "start off the grid": (
        lambda: explore(wave, n=(0, 4, 2), start={"n": 3}),
        ValueError,
        "n = 3",
    ),
    "start of nobody": (lambda: explore(wave, n=(0, 4, 2), start={"m": 3}), ValueError, "'m'"),
    "start no dict": (lambda: explore(wave, n=(0, 4, 2), start=3), TypeError, "start.*3"),
    "no figure": (lambda: explore(lambda n: n, n=(0, 1, 1)), TypeError, "Figure, found int"),
    "frames": (lambda: explore(wave, n=(0, 200, 1)), ValueError, "201 frames.*limit is 200"),
    "frames of two": (
        lambda: explore(wave, n=(0, 99, 1), shift=(0, 2, 1)),
        ValueError,
        "300 frames.*coarser",
    ),
    "endless": (lambda: explore(wave, n=(0, 1, 1e-12)), ValueError, "frames.*limit"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_named(case):
    call, error, words = BAD[case]
    with pytest.raises(error, match=words):
        call()


def test_an_exception_in_the_first_figure_is_raised_and_leaves_nothing():
    def broken(n):
        plt.subplots()
        raise ZeroDivisionError(n)

    with pytest.raises(ZeroDivisionError):
        explore(broken, n=(0, 1, 1))


# ---- the page ----


class Page(HTMLParser):
    """The elements of a piece of HTML with their attributes, and the text in each script."""

    def __init__(self, html):
        super().__init__()
        self.elements, self.data, self.is_data = [], "", False
        self.feed(html)

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        self.is_data = dict(attributes).get("class") == "explore-data"

    def handle_data(self, data):
        self.data += data * self.is_data

    def find(self, name):
        return [attributes for tag, attributes in self.elements if tag == name]

    def frame(self, number):
        data = json.loads(self.data)
        stored = data["frames"][data["order"][number]]
        source = self.find("img")[0]["src"].partition(",")[2]
        return base64.b64decode(stored or source)


def pixels(content):
    return np.asarray(Image.open(io.BytesIO(content)).convert("RGB")).astype(int)


def rendered(**values):
    with _pictures.drawn(wave, values) as made:
        return pixels(_pictures.quick_png(made))


CONTROLS = {
    "one": ({"n": (1, 9, 4)}, None, 0),
    "two": ({"n": (1, 9, 4), "shift": (0, 1, 0.5)}, {"shift": 0.5, "n": 5}, 4),
    "three": (
        {"n": (1, 9, 4), "shift": (0, 1, 0.5), "scheme": ["upwind", "eno2"]},
        {"scheme": "eno2"},
        1,
    ),
    "a choice": ({"scheme": ["upwind", "eno2"]}, None, 0),
}


@pytest.mark.parametrize("case", CONTROLS)
def test_each_frame_belongs_to_its_values(static, case):
    parameters, start, first = CONTROLS[case]
    page = Page(bundle(explore(wave, start=start, **parameters))["text/html"])
    values = [control.values for control in _controls.read_controls(parameters)]
    combinations = [dict(zip(parameters, one, strict=True)) for one in product(values)]
    assert len(json.loads(page.data)["order"]) == len(combinations)
    for number, combination in enumerate(combinations):
        wanted, frame = rendered(**combination), pixels(page.frame(number))
        assert np.abs(frame - wanted).max() <= 128 / (_pictures.EDGE_SHADES - 1) + 1
    shown = base64.b64decode(page.find("img")[0]["src"].partition(",")[2])
    assert shown == page.frame(first)


def product(values):
    return [(a, *rest) for a in values[0] for rest in product(values[1:])] if values else [()]


def test_equal_frames_are_stored_once(static):
    page = Page(bundle(explore(wave, shift=(0, 3, 0.5)))["text/html"])
    data = json.loads(page.data)
    assert data["order"] == [0, 1, 2, 2, 2, 2, 2]
    assert len(data["frames"]) == 3


def test_the_html_asks_nobody_and_hides_what_needs_its_script(static):
    html = bundle(explore(wave, n=(1, 9, 4), scheme=["upwind", "</script>&"]))["text/html"]
    assert "http:" not in html
    assert "https:" not in html
    assert not re.search(r'(?:src|href)="(?!data:)', html)
    assert html.startswith('<div class="explore">')
    assert html.count('alt=""') == 1
    page = Page(html)
    assert [one["alt"] for one in page.find("img")] == [""]
    assert page.find("img")[0]["class"] == "explore-picture"
    assert (page.find("img")[0]["width"], page.find("img")[0]["height"]) == ("200", "150")
    (group,) = [one for one in page.find("div") if one.get("class") == "explore-controls"]
    assert "hidden" in group
    assert all("id" not in attributes for _, attributes in page.elements)
    assert len(page.find("label")) == 2
    assert json.loads(page.data)["texts"] == [["1", "5", "9"], ["upwind", "</script>&"]]
    assert '<p class="explore-values">n = 1, scheme = upwind</p>' in html


def test_no_controls_is_a_figure_alone(static):
    page = Page(bundle(explore(wave))["text/html"])
    assert [tag for tag, _ in page.elements] == ["div", "style", "img"]


def test_what_is_too_heavy_says_so(static, monkeypatch):
    monkeypatch.setattr(_page, "WEIGHT_LIMIT", 10_000)
    with pytest.raises(ValueError, match=r"0\.0\d MB.*3 frames.*limit is 0\.01 MB.*smaller"):
        explore(wave, n=(1, 9, 4))


def test_a_frame_is_the_lighter_of_two_encodings():
    lines = wave()
    smooth, ax = plt.subplots(figsize=(2, 2))
    x = np.linspace(0, 9, 300)
    ax.imshow(np.sin(np.add.outer(x, x**2 / 3)), cmap="twilight")
    for figure, is_lossless in ((lines, True), (smooth, False)):
        assert (b"VP8L" in _pictures.webp(figure)[:16]) == is_lossless
        plt.close(figure)


# ---- the text, and the whole bundle ----


def test_the_bundle_without_and_with_a_page(monkeypatch):
    explorer = explore(wave, n=(1, 9, 4))
    live = bundle(explorer)
    assert set(live) == {"text/plain", "image/png", WIDGET}
    monkeypatch.setenv(STATIC_VARIABLE, "1")
    static = bundle(explore(wave, n=(1, 9, 4)))
    assert set(static) == {"text/plain", "image/png", "text/html"}
    assert static["text/plain"] == live["text/plain"]
    assert static["image/png"] == live["image/png"]
    assert pixels(base64.b64decode(live["image/png"])).shape == (150, 200, 3)


def test_the_bundle_can_be_chosen_from():
    explorer = explore(wave, n=(1, 9, 4))
    assert set(bundle(explorer, include=["image/png"])) == {"image/png"}
    assert set(bundle(explorer, exclude={WIDGET, "image/png"})) == {"text/plain"}


def test_the_text_tells_start_and_corners_once_each():
    text = bundle(explore(wave, n=(1, 9, 4), shift=(0, 1, 0.5), start={"n": 5}))["text/plain"]
    assert re.findall(r"^at (.*):$", text, re.M) == [
        "n = 5, shift = 0",
        "n = 1, shift = 0",
        "n = 9, shift = 1",
    ]
    assert text.count("20 points") == 3
    assert "0x" not in text
    assert (
        text == bundle(explore(wave, n=(1, 9, 4), shift=(0, 1, 0.5), start={"n": 5}))["text/plain"]
    )
    assert bundle(explore(wave, n=(1, 9, 4)))["text/plain"].count("20 points") == 2
    assert bundle(explore(wave))["text/plain"].count("20 points") == 1


# ---- with widgets ----


def inputs(explorer):
    """Return the widgets that hold a value: below the picture and the message, one in a row."""
    rows = explorer.widget.children[2:]
    return [row.children[0] if hasattr(row, "children") else row for row in rows]


def test_a_widget_moves_the_picture_at_once_where_no_loop_runs():
    explorer = explore(wave, n=(1, 9, 4), scheme=["upwind", "eno2"], start={"n": 5})
    picture = explorer.widget.children[0]
    slider, choice = inputs(explorer)
    assert (slider.description, slider.label, choice.label) == ("n", "5", "upwind")
    assert (pixels(picture.value) == rendered(n=5)).all()
    slider.index = 2
    assert (pixels(picture.value) == rendered(n=9)).all()
    choice.index = 1
    assert (pixels(picture.value) == rendered(n=9, scheme="eno2")).all()


def test_an_exception_while_sliding_is_told_and_the_picture_stays():
    def fragile(n):
        fig = wave(n)
        if n == 5:
            raise ValueError("five <is> too many")
        return fig

    explorer = explore(fragile, n=(1, 9, 4))
    picture, message = explorer.widget.children[:2]
    (slider,) = inputs(explorer)
    slider.index = 1
    assert (pixels(picture.value) == rendered(n=1)).all()
    assert message.value.startswith("ValueError: five &lt;is&gt; too many")
    assert "n = 1" in message.value
    slider.index = 2
    assert (pixels(picture.value) == rendered(n=9)).all()
    assert message.value == ""
    slider.index = 1
    assert "n = 9" in message.value


LIVE = """
import time
import matplotlib.pyplot as plt
from distmesh_edu.interactive import explore
drawn = []
def slow(n):
    time.sleep(0.2)
    drawn.append(n)
    fig, ax = plt.subplots(figsize=(2, 1.5))
    ax.plot([0, n], [0, 1])
    return fig
explorer = explore(slow, n=(0, 40, 1))
slider = explorer.widget.children[2].children[0]
def state():
    picture = explorer.widget.children[0].value
    return dict(drawn=drawn, id=slider.model_id, picture=hash(picture), index=slider.index,
                figures=plt.get_fignums())
explorer
"""


@pytest.fixture(scope="module")
def kernel():
    """Start a kernel, as a notebook has one, with an explorer whose figure takes 0.2 s."""
    from jupyter_client.manager import start_new_kernel

    manager, client = start_new_kernel(kernel_name="python3")
    try:
        reply = client.execute_interactive(LIVE, output_hook=lambda _: None, timeout=60)
        assert reply["content"]["status"] == "ok", reply["content"]
        yield client
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)


def state(client):
    call = {"state": "state()"}
    reply = client.execute_interactive(
        "", user_expressions=call, output_hook=lambda _: None, timeout=30
    )
    return eval(reply["content"]["user_expressions"]["state"]["data"]["text/plain"])


def subshell(client):
    client.control_channel.send(client.session.msg("create_subshell_request"))
    return client.get_control_msg(timeout=30)["content"]["subshell_id"]


def slide(client, values, *, pause, shell):
    comm = state(client)["id"]
    for value in values:
        data = {"method": "update", "state": {"index": value}, "buffer_paths": []}
        message = client.session.msg("comm_msg", {"comm_id": comm, "data": data})
        message["header"]["subshell_id"] = shell
        client.shell_channel.send(message)
        time.sleep(pause)


@pytest.mark.parametrize("pause", [0.0, 0.02])
@pytest.mark.parametrize("in_subshell", [False, True])
def test_the_newest_change_wins_and_stale_ones_are_not_drawn(kernel, pause, in_subshell):
    """JupyterLab may send what sliders say to another thread of the kernel, a subshell."""
    before = state(kernel)
    last = 40 if before["drawn"][-1] != 40 else 31
    slide(
        kernel,
        [*range(1, 30), last],
        pause=pause,
        shell=subshell(kernel) if in_subshell else None,
    )
    deadline = time.monotonic() + 20
    while (now := state(kernel))["drawn"][-1] != last and time.monotonic() < deadline:
        time.sleep(0.1)
    time.sleep(0.5)
    now = state(kernel)
    fresh = now["drawn"][len(before["drawn"]) :]
    # The picture shows what the slider says. A kernel that is flooded under load may let messages
    # overtake each other (seen in a subshell: the slider itself then ends elsewhere); browsers do
    # not flood it, they send the next change when the last one is done.
    assert fresh[-1] == now["index"]
    assert in_subshell or now["index"] == last
    # Of 30 changes one after the other; a busy machine may draw a few more than one.
    assert len(fresh) <= 10 + 30 * pause / 0.2
    assert now["picture"] != before["picture"]
    assert now["figures"] == []


def test_an_exception_in_the_first_figure_stops_the_cell(kernel):
    reply = kernel.execute_interactive(
        "explore(lambda n: 1 / n, n=(0, 1, 1))", output_hook=lambda _: None, timeout=30
    )
    assert reply["content"]["ename"] == "ZeroDivisionError"


def test_limits_are_named():
    assert _controls.FRAME_LIMIT == 200
    assert _page.WEIGHT_LIMIT <= 1_500_000
    assert interactive.STATIC_VARIABLE == "DISTMESH_EDU_STATIC"
