"""The HTML of `explore` in a real browser, from file://, with every other host out of reach."""

import json
import re
from contextlib import contextmanager

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest

from distmesh_edu.interactive import STATIC_VARIABLE, explore

mpl.use("agg")

WIDE, NARROW = 1200, 360
SIZES, STEPS, SCHEMES = [0.1, 0.15, 0.2, 0.25, 0.3], range(5), ["upwind", "eno2"]


def bar(size=0.1, gradient_step=0, scheme="upwind"):
    """Draw a figure that differs for all its values, without any text that would tell them."""
    fig, ax = plt.subplots(figsize=(4, 2))
    ax.bar([0, 1], [size, gradient_step], color="r" if scheme == "upwind" else "b")
    ax.set(ylim=(0, 4))
    return fig


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """Write a page with two explorers, of three controls and of one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(STATIC_VARIABLE, "1")
        three = explore(
            bar,
            size=(0.1, 0.3, 0.05),
            gradient_step=(0, 4, 1),
            scheme=["upwind", "eno2"],
            start={"size": 0.15},
        )
        one = explore(bar, gradient_step=(0, 4, 1), start={"gradient_step": 3})
        parts = [each._repr_mimebundle_()["text/html"] for each in (three, one)]
    file = tmp_path_factory.mktemp("page") / "page.html"
    file.write_text(
        '<!doctype html><html lang="en" data-theme="light"><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width"><title>Page</title>'
        f"<body>{'<p>Between.</p>'.join(parts)}",
        encoding="utf-8",
    )
    return file


@pytest.fixture(scope="module")
def frames(page):
    """Read the addresses of the frames of the first explorer, by values."""
    html = page.read_text(encoding="utf-8")
    data = json.loads(re.search(r'class="explore-data">(.*?)</script>', html)[1])
    start = re.search(r'src="(data:image/webp[^"]*)"', html)[1]
    assert data["texts"] == [[f"{s:g}" for s in SIZES], [str(n) for n in STEPS], SCHEMES]
    stored = [start if one is None else f"data:image/webp;base64,{one}" for one in data["frames"]]
    values = [(size, step, scheme) for size in SIZES for step in STEPS for scheme in SCHEMES]
    return {each: stored[place] for each, place in zip(values, data["order"], strict=True)}


@contextmanager
def opened(browser, page, *, width=WIDE, **options):
    """Open a page, and see that it asks nobody for anything and raises no error."""
    context = browser.new_context(viewport={"width": width, "height": 900}, **options)
    wrong = []
    context.route(
        re.compile("^https?:"), lambda route: (wrong.append(route.request.url), route.abort())
    )
    tab = context.new_page()
    tab.on("pageerror", lambda error: wrong.append(str(error)))
    tab.on("console", lambda message: wrong.append(message.text))
    tab.goto(page.as_uri())
    yield tab
    context.close()
    assert wrong == []


def source(explorer):
    return explorer.locator("img").get_attribute("src")


def wait_for(explorer, wanted):
    """Wait for a frame; what counts is the picture, whatever the controls say."""
    explorer.locator("img").evaluate(
        """(picture, wanted) => new Promise((done, failed) => {
            const end = performance.now() + 10000;
            const look = () => picture.src === wanted ? done()
                : performance.now() > end ? failed("the frame did not come") : setTimeout(look, 5);
            look();
        })""",
        wanted,
    )


def parts(tab, number=0):
    explorer = tab.locator(".explore").nth(number)
    return explorer, explorer.locator("input"), explorer.locator("button")


def stand_still(tab):
    """Stop the page's clock: from now on only `tab.clock.run_for` moves it, however slow we are."""
    tab.clock.install(time=0)
    tab.clock.pause_at(1000)


def test_the_keyboard_moves_the_picture_and_no_other(browser, page, frames):
    with opened(browser, page) as tab:
        explorer, sliders, _ = parts(tab)
        other, before = tab.locator(".explore").nth(1), source(tab.locator(".explore").nth(1))
        assert source(explorer) == frames[0.15, 0, "upwind"]
        shown = explorer.locator("img").screenshot()
        sliders.nth(0).focus()
        tab.keyboard.press("ArrowRight")
        assert source(explorer) == frames[0.2, 0, "upwind"]
        tab.keyboard.press("End")
        sliders.nth(1).focus()
        tab.keyboard.press("End")
        tab.keyboard.press("ArrowLeft")
        assert source(explorer) == frames[0.3, 3, "upwind"]
        explorer.locator("select").focus()
        tab.keyboard.press("ArrowDown")
        assert source(explorer) == frames[0.3, 3, "eno2"]
        assert explorer.locator("img").screenshot() != shown
        assert source(other) == before


def test_values_are_said_once_and_in_words(browser, page):
    with opened(browser, page) as tab:
        explorer, sliders, buttons = parts(tab)
        assert sliders.nth(0).get_attribute("aria-valuetext") == "0.15"
        sliders.nth(0).focus()
        tab.keyboard.press("ArrowRight")
        assert sliders.nth(0).get_attribute("aria-valuetext") == "0.2"
        outputs = explorer.locator("output")
        assert outputs.all_text_contents() == ["0.2", "0"]
        assert [one.get_attribute("aria-live") for one in outputs.all()] == ["off", "off"]
        assert tab.get_by_role("slider", name="gradient step", exact=True).count() == 2
        assert tab.get_by_role("combobox", name="scheme", exact=True).count() == 1
        assert tab.get_by_role("button", name="Play gradient step", exact=True).count() == 2
        assert not explorer.locator(".explore-values").is_visible()
        assert buttons.count() == 2


def test_the_pointer_moves_the_picture(browser, page, frames):
    with opened(browser, page) as tab:
        explorer, sliders, _ = parts(tab)
        box = sliders.nth(1).bounding_box()
        middle = box["y"] + box["height"] / 2
        tab.mouse.move(box["x"] + 12, middle)
        tab.mouse.down()
        tab.mouse.move(box["x"] + box["width"] / 2, middle, steps=5)
        assert source(explorer) == frames[0.15, 2, "upwind"]
        tab.mouse.move(box["x"] + box["width"] - 5, middle, steps=5)
        tab.mouse.up()
        assert source(explorer) == frames[0.15, 4, "upwind"]


@pytest.mark.parametrize("by", ["keyboard", "pointer"])
def test_play_runs_to_the_end_and_over_again(browser, page, frames, by):
    with opened(browser, page) as tab:
        explorer, _, buttons = parts(tab)
        button = buttons.nth(0)

        def press():
            if by == "pointer":
                return button.click()
            button.focus()
            return tab.keyboard.press("Enter")

        stand_still(tab)
        press()
        assert button.get_attribute("aria-label") == "Pause size"
        tab.clock.run_for(650)
        assert source(explorer) == frames[0.2, 0, "upwind"]
        press()
        tab.clock.run_for(5000)
        assert source(explorer) == frames[0.2, 0, "upwind"]
        assert button.get_attribute("aria-label") == "Play size"
        press()
        tab.clock.run_for(5000)
        assert source(explorer) == frames[0.3, 0, "upwind"]
        assert button.get_attribute("aria-label") == "Play size"
        press()
        assert source(explorer) == frames[0.1, 0, "upwind"]
        tab.clock.run_for(650)
        assert source(explorer) == frames[0.15, 0, "upwind"]


def test_a_hand_stops_play(browser, page, frames):
    with opened(browser, page) as tab:
        explorer, sliders, buttons = parts(tab)
        stand_still(tab)
        buttons.nth(0).click()
        buttons.nth(1).click()
        assert buttons.nth(0).get_attribute("aria-label") == "Play size"
        tab.clock.run_for(650)
        assert source(explorer) == frames[0.15, 1, "upwind"]
        sliders.nth(0).focus()
        tab.keyboard.press("Home")
        tab.clock.run_for(5000)
        assert source(explorer) == frames[0.1, 1, "upwind"]
        assert buttons.nth(1).get_attribute("aria-label") == "Play gradient step"


def test_play_is_calmer_for_who_asked_for_less_motion(browser, page, frames):
    with opened(browser, page, reduced_motion="reduce") as tab:
        explorer, _, buttons = parts(tab)
        stand_still(tab)
        buttons.nth(1).click()
        tab.clock.run_for(1100)
        assert source(explorer) == frames[0.15, 0, "upwind"]
        tab.clock.run_for(200)
        assert source(explorer) == frames[0.15, 1, "upwind"]


def test_paper_has_the_start_frame_and_its_values(browser, page, frames):
    with opened(browser, page) as tab:
        explorer, sliders, _ = parts(tab)
        sliders.nth(0).focus()
        tab.keyboard.press("End")
        tab.emulate_media(media="print")
        wait_for(explorer, frames[0.15, 0, "upwind"])
        values = explorer.locator(".explore-values")
        assert values.is_visible()
        assert values.text_content() == "size = 0.15, gradient step = 0, scheme = upwind"
        assert not explorer.locator("input, select, button, output").filter(visible=True).count()
        tab.emulate_media(media="screen")
        wait_for(explorer, frames[0.3, 0, "upwind"])
        tab.evaluate("window.dispatchEvent(new Event('beforeprint'))")
        assert source(explorer) == frames[0.15, 0, "upwind"]
        tab.evaluate("window.dispatchEvent(new Event('afterprint'))")
        assert source(explorer) == frames[0.3, 0, "upwind"]


def test_without_scripts_the_start_frame_and_its_values_stand(browser, page, frames):
    with opened(browser, page, java_script_enabled=False) as tab:
        explorer, _, _ = parts(tab)
        assert source(explorer) == frames[0.15, 0, "upwind"]
        assert explorer.locator(".explore-values").is_visible()
        assert not explorer.locator("input, select, button, output").filter(visible=True).count()


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("width", [WIDE, NARROW])
def test_it_fits_can_be_touched_and_be_seen(browser, page, theme, width):
    with opened(browser, page, width=width) as tab:
        tab.evaluate("theme => document.documentElement.dataset.theme = theme", theme)
        ground = "#14181e" if theme == "dark" else "#ffffff"
        tab.evaluate("colour => document.body.style.background = colour", ground)
        assert tab.evaluate("document.documentElement.scrollWidth") <= width
        for control in tab.locator("input, select, button").all():
            box = control.bounding_box()
            assert box["height"] >= 40
            assert box["width"] >= 40
            assert 0 <= box["x"] <= box["x"] + box["width"] <= width
        explorer, _, _ = parts(tab)
        background = "one => getComputedStyle(one).backgroundColor"
        assert explorer.locator("img").evaluate(background) == "rgb(255, 255, 255)"
        for name in (".explore-name", "output", "select", "button"):
            ink = explorer.locator(name).first.evaluate("one => getComputedStyle(one).color")
            assert contrast(ink, ground) >= 4.5, name


def contrast(ink, ground):
    """Return the contrast of two colours as WCAG 2 defines it."""

    def luminance(parts):
        linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    first = luminance([int(part) / 255 for part in re.findall(r"\d+", ink)[:3]])
    second = luminance([int(ground[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    return (max(first, second) + 0.05) / (min(first, second) + 0.05)


def test_focus_can_be_seen(browser, page):
    with opened(browser, page) as tab:
        _, sliders, buttons = parts(tab)
        for control in (buttons.nth(0), sliders.nth(0), tab.locator("select").first):
            control.evaluate("one => one.blur()")
            before = control.screenshot()
            tab.keyboard.press("Tab")  # so that the browser takes the focus for the keyboard's
            control.focus()
            assert control.screenshot() != before


def test_a_second_copy_of_the_script_changes_nothing(browser, page, frames):
    with opened(browser, page) as tab:
        explorer, _, buttons = parts(tab)
        tab.evaluate(
            "new Function(document.querySelector('.explore > script:last-of-type').text)()"
        )
        stand_still(tab)
        buttons.nth(0).click()
        assert buttons.nth(0).get_attribute("aria-label") == "Pause size"
        tab.clock.run_for(650)
        assert source(explorer) == frames[0.2, 0, "upwind"]
