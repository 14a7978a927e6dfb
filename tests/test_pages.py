"""The built book in a real browser: from file://, with every other host out of reach.

Of an explorer the picture alone is compared: a slider that moves while the picture stays must fail.
The longest tests come first: they are shared out in this order, and all processes end together.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tools import book

AXE = Path(__file__).parent / "vendor" / "axe.min.js"
WCAG = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]
WIDE, NARROW = 1300, 360  # CSS pixels: a laptop, and the narrowest of telephones
LOOKS = [(theme, width) for theme in ("light", "dark") for width in (WIDE, NARROW)]
WAIT = 3000  # milliseconds for a picture to change

PICTURE = """async explorer => {
    const picture = explorer.querySelector(".explore-picture");
    for (let attempts = 20; ; attempts -= 1) {
        // It fails while the next picture takes its place.
        try { await picture.decode(); break; }
        catch (error) { if (!attempts) throw error; }
    }
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [picture.naturalWidth, picture.naturalHeight];
    canvas.getContext("2d").drawImage(picture, 0, 0);
    return canvas.toDataURL();
}"""
RAW_TEX = r"""() => {
    const text = document.querySelector("article").cloneNode(true);
    text.querySelectorAll("pre, code, script, mjx-container").forEach(element => element.remove());
    return text.textContent.match(/\\\(|\\\[|\$\$|\\begin\{/g) ?? [];
}"""
STICKS_OUT = """e.getBoundingClientRect().right > innerWidth + 1 && !(function scrolls(p) {
    return p && (getComputedStyle(p).overflowX != "visible" || scrolls(p.parentElement));
})(e.parentElement.closest("article *"))"""
EXPLORERS = [page for page in book.pages() if (book.ROOT / f"{page}.ipynb").exists()]


@contextmanager
def opened(
    browser, page: str, theme: str = "light", width: int = WIDE, scripts: bool = True
) -> Iterator:
    """Open a built page; at the end it must have asked no host, and logged no error."""
    file = book.html_file(page)
    assert file.exists(), f"{file.name} is not built: run `make book`"
    context = browser.new_context(
        viewport={"width": width, "height": 900}, color_scheme=theme, java_script_enabled=scripts
    )
    asked, errors = [], []
    context.route(
        lambda url: url.startswith("http"),
        lambda route: (asked.append(route.request.url), route.abort()),
    )
    context.add_init_script(
        f"localStorage.setItem('mode', '{theme}'); localStorage.setItem('theme', '{theme}')"
    )
    tab = context.new_page()
    tab.on(
        "console", lambda message: errors.append(message.text) if message.type == "error" else None
    )
    tab.on("pageerror", lambda error: errors.append(str(error)))
    tab.on("requestfailed", lambda request: errors.append(f"{request.url}: {request.failure}"))
    tab.goto(file.as_uri(), wait_until="load")
    if scripts:
        tab.evaluate("() => window.MathJax?.startup?.promise")
    yield tab
    context.close()
    assert asked == [], "the page asked other hosts"
    assert not scripts or errors == [], "the page logged errors"


def changed(tab, explorer, picture: str) -> str:
    """Wait until the picture is another one than that given, and return it."""
    for _ in range(WAIT // 50):
        if (now := explorer.evaluate(PICTURE)) != picture:
            return now
        tab.wait_for_timeout(50)
    pytest.fail("the picture did not change")


@pytest.mark.parametrize("page", EXPLORERS)
def test_explorers_answer(browser, page):
    with opened(browser, page) as tab:
        for explorer in tab.locator(".explore").all():
            for row in explorer.locator(".explore-row:has(input)").all():
                slider, button = row.locator("input[type=range]"), row.locator("button")
                by_keyboard(tab, explorer, slider)
                by_pointer(tab, explorer, slider)
                play_and_pause(tab, explorer, button, slider)
            for choice in explorer.locator("select").all():
                picture = explorer.evaluate(PICTURE)
                choice.focus()
                choice.press(
                    "ArrowDown" if choice.evaluate("s => s.selectedIndex == 0") else "ArrowUp"
                )
                changed(tab, explorer, picture)


def by_keyboard(tab, explorer, slider) -> None:
    """Move a slider from end to end, and by one step."""
    slider.focus()
    slider.press("Home")
    tab.wait_for_timeout(100)
    first = explorer.evaluate(PICTURE)
    slider.press("ArrowRight")
    assert slider.evaluate("s => Number(s.value) > Number(s.min)"), (
        "the arrow key did not move the slider"
    )
    slider.press("End")
    changed(tab, explorer, first)


def by_pointer(tab, explorer, slider) -> None:
    """Take a slider from its right end to its left."""
    slider.scroll_into_view_if_needed()
    last = explorer.evaluate(PICTURE)
    box = slider.bounding_box()
    middle = box["y"] + box["height"] / 2
    tab.mouse.move(box["x"] + box["width"] - 4, middle)
    tab.mouse.down()
    tab.mouse.move(box["x"] + 2, middle, steps=4)
    tab.mouse.up()
    changed(tab, explorer, last)


def play_and_pause(tab, explorer, button, slider) -> None:
    """Play from the left end, and pause before the right one."""
    slider.press("Home")
    tab.wait_for_timeout(100)
    first = still(tab, explorer)
    button.press("Enter")
    changed(tab, explorer, first)
    if slider.evaluate("s => s.value != s.max"):  # at its end it stops by itself
        assert button.get_attribute("aria-label").startswith("Pause"), (
            "it does not say that it plays"
        )
        button.press("Enter")
    still(tab, explorer)


def still(tab, explorer) -> str:
    """Return the picture, which must not be changing."""
    tab.wait_for_timeout(50)
    picture = explorer.evaluate(PICTURE)
    tab.wait_for_timeout(700)  # longer than a frame is shown
    assert explorer.evaluate(PICTURE) == picture, "the picture changes by itself"
    return picture


@pytest.mark.parametrize("page", book.pages())
def test_is_whole(browser, page):
    with opened(browser, page) as tab:
        assert found(tab, "article img", "!e.alt.trim()") == [], "pictures without alt text"
        assert found(tab, "img", "!e.naturalWidth") == [], "pictures that were not found"
        assert tab.evaluate(RAW_TEX) == [], "mathematics that was not typeset"
        assert found(tab, ".math", "!e.querySelector('mjx-container')") == [], (
            "mathematics that was not typeset"
        )
        assert found(tab, "mjx-merror", "true") == [], "mathematics with an error"
        tab.evaluate("() => document.fonts.ready")
        lost = tab.evaluate(
            "() => [...document.fonts].filter(f => f.status == 'error').map(f => f.family)"
        )
        assert lost == [], "fonts that were not found"


def found(tab, selector: str, condition: str) -> list[str]:
    """Return the beginnings of the elements `e` that meet a condition."""
    script = (
        "[...document.querySelectorAll({!r})].filter(e => {}).map(e => e.outerHTML.slice(0, 200))"
    )
    return tab.evaluate(script.format(selector, condition))


@pytest.mark.parametrize(("theme", "width"), LOOKS)
@pytest.mark.parametrize("page", [*book.pages(), "search"])
def test_is_accessible_and_fits(browser, page, theme, width):
    with opened(browser, page, theme, width) as tab:
        assert tab.evaluate("document.documentElement.dataset.theme") == theme
        assert tab.evaluate("document.documentElement.scrollWidth") <= width, (
            "the page is too wide",
            found(tab, "article *", STICKS_OUT)[:5],
        )
        tab.wait_for_function("() => !window.MathJax || MathJax.startup.promise.then(() => true)")
        beyond = "e.getBoundingClientRect().left < 0"
        assert found(tab, "article mjx-container", beyond) == [], "no one can scroll there"
        tab.wait_for_timeout(300)  # the theme's icons are put in place after the page
        tab.evaluate(AXE.read_text(encoding="utf-8"))
        # Without `preload`, which reads the style sheets once more: file:// does not allow it.
        result = tab.evaluate("tags => axe.run({runOnly: tags, preload: false})", WCAG)
        assert result["passes"], "axe-core checked nothing"
        faults = [
            (fault["id"], node["html"][:200])
            for fault in result["violations"]
            for node in fault["nodes"]
        ]
        assert faults == []


@pytest.mark.parametrize("page", EXPLORERS)
def test_without_scripts_the_picture_stands_alone(browser, page):
    with opened(browser, page, scripts=False) as tab:
        for explorer in tab.locator(".explore").all():
            assert explorer.locator(".explore-picture").is_visible()
            assert not explorer.locator("input, select, button").filter(visible=True).count()


def test_the_book_has_explorers():
    built = [book.html_file(page) for page in EXPLORERS]
    assert all(file.exists() for file in built), "pages are not built: run `make book`"
    assert any('class="explore"' in file.read_text(encoding="utf-8") for file in built)
