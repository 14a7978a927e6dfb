"""What students get: notebooks without solutions and hidden checks, their pages, and the zip."""

import ast
import html
import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from tests.answers import answers_to
from tests.test_pages import RAW_TEX, opened
from tools import book, exercises

SOURCES = {path.stem: path for path in exercises.notebooks("source")}
RELEASED = {path.stem: path for path in exercises.notebooks("release")}
EACH = pytest.mark.parametrize("stem", SOURCES)
KINDS = ("SOLUTION", "HIDDEN TESTS")
STUB = "# Your answer here."
TAGS = ["raises-exception", "hide-input", "remove-output"]

REGION = re.compile(
    r"^[^\n]*BEGIN (?P<kind>SOLUTION|HIDDEN TESTS)\n(?P<text>.*?)^[^\n]*END (?P=kind)$",
    re.DOTALL | re.MULTILINE,
)
# A teacher who turns the switch publishes the solutions; hidden checks are never published.
PUBLISHED = "publish_solutions: true" in (book.ROOT / "_config.yml").read_text("utf-8")
LONG = 60  # characters: what is as long as this stands in no other place by chance


def read(path):
    return nbformat.read(path, as_version=4)


def lines(text):
    return {line.strip() for line in text.splitlines()} - {""}


def words(text):
    """Return a text with all its white space made alike."""
    return " ".join(text.split())


def secrets(path, *kinds):
    """Return a source's secret regions, and the lines in them that stand nowhere else in it."""
    regions, shown = [], set()
    for cell in read(path).cells:
        regions += [
            m["text"] for m in REGION.finditer(cell.source) if m["kind"] in (kinds or KINDS)
        ]
        shown |= lines(REGION.sub("", cell.source))
    return regions, lines("\n".join(regions)) - shown


# ---- a course of two exercises ----


def cell(source, name, **nbgrader):
    kind = {"grade": False, "solution": False, "locked": False, "task": False, "schema_version": 3}
    made = new_code_cell(source, id=name)
    made.metadata["nbgrader"] = kind | nbgrader | {"grade_id": name}
    if nbgrader.get("grade"):
        made.metadata["tags"] = TAGS
    return made


TWICE = """def twice(x):
    \"\"\"Return x, doubled.\"\"\"
    ### BEGIN SOLUTION
    doubled = 2 * x
    return doubled
    ### END SOLUTION"""
CHECK = """assert twice(2) == 4
### BEGIN HIDDEN TESTS
assert twice(617) == 1234
### END HIDDEN TESTS"""
TEXT = """<!-- exercise: twice-as-much -->
## Twice as $x$

*Code, 3 points.* Double $x$:

```python
twice(2)
```

<details><summary>Hint</summary>

What is $x + x$?

</details>"""
LIMIT = "<!-- exercise: limit -->\n## The limit\n\n*Recall, 1 point.* What is the limit?"


@pytest.fixture
def course(tmp_path):
    """Write the sources of a small course."""
    imports = cell("import math", "imports", locked=True)
    imports.outputs = [nbformat.v4.new_output("stream", text="left over")]
    notebook = new_notebook(
        cells=[
            new_markdown_cell("# Exercises: Numbers\n\nTwo of them.", id="head"),
            imports,
            new_markdown_cell(TEXT, id="twice-as-much-text"),
            cell(TWICE, "twice-as-much", solution=True),
            cell(CHECK, "twice-as-much-check", grade=True, locked=True, points=3),
            new_markdown_cell(LIMIT, id="limit-text"),
            cell(
                "limit = ...\n### BEGIN SOLUTION\nlimit = 8.125\n### END SOLUTION",
                "limit",
                solution=True,
            ),
            cell("assert limit > 8", "limit-check", grade=True, locked=True, points=1),
        ],
        metadata={"kernelspec": {"name": "other", "display_name": "x", "language": "python"}},
    )
    source = tmp_path / "course" / "source" / "03_numbers" / "03_numbers.ipynb"
    source.parent.mkdir(parents=True)
    nbformat.write(notebook, source)
    shutil.copy(exercises.COURSE / "nbgrader_config.py", tmp_path / "course")
    return tmp_path / "course"


def released(course):
    exercises.generate(course, course / "release")
    return course / "release" / "03_numbers" / "03_numbers.ipynb"


def test_a_release_has_stubs_for_solutions_and_no_hidden_check(course):
    cells = {cell.id: cell for cell in read(released(course)).cells}
    assert cells["twice-as-much"].source == f"{TWICE.split('    ###')[0]}    {STUB}"
    assert cells["limit"].source == f"limit = ...\n{STUB}"
    assert cells["twice-as-much-check"].source == "assert twice(2) == 4"
    assert cells["limit-check"].source == "assert limit > 8"
    assert cells["twice-as-much-text"].source == TEXT


def test_a_release_is_clean_and_its_checks_are_locked_and_folded(course):
    source, notebook = read(course / "source/03_numbers/03_numbers.ipynb"), read(released(course))
    assert [cell.id for cell in notebook.cells] == [cell.id for cell in source.cells]
    assert notebook.metadata.kernelspec.name == "python3"
    for cell in notebook.cells:
        if cell.cell_type != "code":
            continue
        assert cell.outputs == []
        assert cell.execution_count is None
        nbgrader = cell.metadata.nbgrader
        assert re.fullmatch("[0-9a-f]{32}", nbgrader.checksum)
        assert cell.metadata.deletable is False
        assert cell.metadata.get("editable", True) == bool(nbgrader.solution)
        assert ("jupyter" in cell.metadata) == nbgrader.grade
        if nbgrader.grade:
            assert cell.metadata.tags == TAGS
            assert cell.metadata.jupyter.source_hidden


def test_a_release_is_the_same_each_time_and_forgets_what_is_gone(course):
    first = released(course).read_bytes()
    gone = course / "release" / "02_gone"
    gone.mkdir()
    assert released(course).read_bytes() == first
    assert not gone.exists()
    assert sorted(path.name for path in course.iterdir()) == [
        "nbgrader_config.py",
        "release",
        "source",
    ], "no gradebook lies about"


def test_a_misspelt_mark_is_noticed_and_the_old_release_stays(course):
    path = released(course)
    before = path.read_bytes()
    source = course / "source/03_numbers/03_numbers.ipynb"
    text = source.read_text("utf-8")
    source.write_text(text.replace("HIDDEN TESTS", "HIDEN TESTS"), "utf-8")
    with pytest.raises(ValueError, match=r"03_numbers.*BEGIN HIDEN TESTS.*misspelt"):
        released(course)
    source.write_text(text.replace("### END SOLUTION", ""), "utf-8")
    with pytest.raises(RuntimeError, match=r"(?s)03_numbers.*no end solution"):
        released(course)
    assert path.read_bytes() == before


def test_no_sources_no_release(tmp_path):
    with pytest.raises(FileNotFoundError, match="to release"):
        exercises.generate(tmp_path, tmp_path / "release")


# ---- what is committed ----


def tree(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_text("utf-8")
        for path in sorted(folder.rglob("*"))
        if path.is_file() and ".ipynb_checkpoints" not in path.parts
    }


def test_the_released_notebooks_are_in_step_with_their_sources(tmp_path):
    exercises.generate(exercises.COURSE, tmp_path / "release")
    new, kept = tree(tmp_path / "release"), tree(exercises.COURSE / "release")
    assert [name for name in new.keys() | kept if new.get(name) != kept.get(name)] == [], (
        "run `make release`, and commit exercises/release"
    )


@EACH
def test_a_released_notebook_holds_no_secret(stem):
    regions, hidden = secrets(SOURCES[stem])
    assert hidden
    assert all(lines(region) for region in regions)
    raw = RELEASED[stem].read_text("utf-8")
    shown = {line for cell in read(RELEASED[stem]).cells for line in lines(cell.source)}
    assert hidden & shown == set()
    assert not re.search("(BEGIN|END) (SOLUTION|HIDDEN)", raw)
    for secret in hidden:
        assert len(secret) < LONG or json.dumps(secret)[1:-1] not in raw


@EACH
def test_a_released_notebook_is_valid_code_with_something_to_do(stem):
    source = {cell.id: cell for cell in read(SOURCES[stem]).cells}
    for cell in read(RELEASED[stem]).cells:
        if cell.cell_type == "code":
            ast.parse(cell.source)
            marks = source[cell.id].source.count("BEGIN SOLUTION")
            assert cell.source.count(STUB) == marks
            assert bool(marks) == bool(cell.metadata.nbgrader.solution)
            assert len(lines(cell.source)) > bool(marks), "a stub alone says not what to answer"


@EACH
def test_it_is_the_last_section_of_its_chapter(stem):
    chapters = [
        [chapter["file"], *(section["file"] for section in chapter.get("sections", []))]
        for chapter in toc()
    ]
    (mine,) = [files for files in chapters if Path(files[0]).name == stem]
    assert mine[-1] == page(stem)


def toc():
    import yaml  # the reader that Jupyter Book reads it with

    parts = yaml.safe_load((book.ROOT / "_toc.yml").read_text("utf-8"))["parts"]
    return [chapter for part in parts for chapter in part["chapters"]]


def page(stem):
    return f"exercises/release/{stem}/{stem}"


def test_the_page_for_teachers_quotes_what_wrong_answers_are_told():
    page = (book.ROOT / "book" / "for_teachers.md").read_text("utf-8")
    rows = re.findall(
        r"^\| \{numref\}`ex-(\d\d)-([a-z-]+)` \| .* \| \*(.+)\* \|$", page, re.MULTILINE
    )
    answers = {stem[:2]: answers_to(stem) for stem in SOURCES}
    assert {chapter for chapter, _, _ in rows} == answers.keys()
    for chapter, exercise, quoted in rows:
        told = [a.says for a in answers[chapter] if a.exercise == exercise and not a.right]
        assert any(quoted in says for says in told), f"{exercise}: nobody is told {quoted!r}"
    assert sum(not answer.right for one in answers.values() for answer in one) > 300
    projects = set(
        re.findall(r"^\| \{numref\}`ex-(\d\d)-[a-z-]+` \| What [^|]+\? \|$", page, re.MULTILINE)
    )
    assert projects == answers.keys()


# ---- the zip ----


@pytest.fixture(scope="module")
def kit(tmp_path_factory):
    """Pack what `make release` packs."""
    folder = tmp_path_factory.mktemp("kit")
    kit = folder / exercises.KIT.name
    exercises.pack(kit, exercises.build_wheel(folder / "wheel"))
    return kit


def contents(archive):
    return {name: archive.read(name) for name in archive.namelist()}


def test_the_zip_holds_what_its_readme_says(kit):
    with zipfile.ZipFile(kit) as archive:
        files = contents(archive)
    assert {Path(name).parts[0] for name in files} == {kit.stem}
    inside = {Path(name).name: content for name, content in files.items()}
    (wheel,) = [name for name in inside if name.endswith(".whl")]
    assert inside.keys() == {"README.txt", wheel} | {path.name for path in RELEASED.values()}
    for path in RELEASED.values():
        assert inside[path.name] == path.read_bytes()
    readme = inside["README.txt"].decode()
    assert f"python -m pip install jupyterlab ./{wheel}" in readme
    assert "WHEEL" not in readme
    assert max(map(len, readme.splitlines())) <= 88


def test_the_zip_and_its_wheel_hold_no_secret(kit, tmp_path):
    with zipfile.ZipFile(kit) as archive:
        archive.extractall(tmp_path)
    (wheel,) = tmp_path.rglob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "library")
    texts = [words(text) for text in readable(tmp_path)]
    assert len(texts) > len(RELEASED) + 20
    assert leaks(texts) == []


def readable(folder):
    for path in sorted(folder.rglob("*")):
        if path.suffix == ".ipynb":
            yield "\n".join(cell.source for cell in read(path).cells)
        elif path.suffix in (".py", ".txt", ".md", ".csv"):
            yield path.read_text("utf-8")
        elif path.suffix == ".html":
            yield text_of(path.read_text("utf-8"))


def leaks(texts, published=False):
    """Return what stands in one of these texts: whole solutions, and hidden checks line by line."""
    wanted = set()
    for path in SOURCES.values():
        wanted |= {words(text) for text in secrets(path, *KINDS[published:])[0]}
        wanted |= {words(line) for line in secrets(path, "HIDDEN TESTS")[1]}
    return [
        secret for secret in wanted if len(secret) >= LONG and any(secret in text for text in texts)
    ]


def text_of(page):
    """Return what a page says: no tags, no pictures."""
    return html.unescape(re.sub(r"<[^>]*>", "", page))


def test_the_wheel_is_the_library_and_works_alone(kit, tmp_path):
    with zipfile.ZipFile(kit) as archive:
        archive.extractall(tmp_path)
    (wheel,) = tmp_path.rglob("*.whl")
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run(
        [*pip, "--no-deps", "--no-index", "--target", str(tmp_path / "lib"), str(wheel)], check=True
    )
    library = book.ROOT / "distmesh_edu"
    mine = {path.relative_to(library) for path in library.rglob("*") if path.is_file()}
    mine = {path for path in mine if "__pycache__" not in path.parts and path.name[0] != "."}
    there = tmp_path / "lib" / "distmesh_edu"
    assert {path for path in mine if not (there / path).is_file()} == set()
    script = "import distmesh_edu.checks, sys; print(sys.modules['distmesh_edu'].__file__)"
    run = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(tmp_path / "lib")},
    )
    assert Path(run.stdout.strip()).parent == there


def test_the_same_files_give_the_same_zip(kit, tmp_path):
    exercises.pack(tmp_path / kit.name, exercises.build_wheel(tmp_path / "wheel"))
    assert (tmp_path / kit.name).read_bytes() == kit.read_bytes()


# ---- the pages: on a small book, with the switch off and on ----

CONF = f"""import sys
sys.path.insert(0, {str(book.ROOT / "book" / "_ext")!r})
extensions = ["myst_nb", "sphinx_exercise", "distmesh_exercises"]
exclude_patterns = ["_build", "source"]
myst_enable_extensions = ["dollarmath"]
nb_execution_mode = "off"
"""
INDEX = """# A book

{numref}`ex-03-limit`, {ref}`ex-03-twice-as-much`

```{toctree}
:numbered:
release/03_numbers/03_numbers
```
"""


@pytest.fixture
def small_book(course):
    """Return a function that builds a book of that course and gives back its page."""
    path = released(course)
    (course / "conf.py").write_text(CONF, "utf-8")
    (course / "index.md").write_text(INDEX, "utf-8")

    def build(*options):
        sphinx = [sys.executable, "-m", "sphinx", "-q", "-W", "-n", "-b", "html"]
        out = course / "_build" / "html"
        run = subprocess.run(
            [*sphinx, *options, str(course), str(out)], capture_output=True, text=True, check=False
        )
        assert run.returncode == 0, run.stderr
        assert [copy.read_bytes() for copy in out.glob("_downloads/*/*")] == [path.read_bytes()]
        return (out / "release/03_numbers/03_numbers.html").read_text("utf-8")

    return build


def test_exercises_are_numbered_labelled_and_referred_to(small_book, course):
    page = small_book()
    index = (course / "_build/html/index.html").read_text("utf-8")
    for label, number in (("ex-03-twice-as-much", "1.1"), ("ex-03-limit", "1.2")):
        assert f'id="{label}">\n\n<p class="admonition-title"><span class="caption-number">' in page
        assert f"Exercise {number}" in page
        assert f'03_numbers.html#{label}"><span class="std std-numref">Exercise {number}' in index
    box = page.partition('id="ex-03-twice-as-much"')[2].partition("cell_input")[0]
    assert "<details><summary>Hint</summary>" in box
    assert r"\(x + x\)</span>?</p>" in box
    assert "Show the check" in page
    assert page.count("<h1>") == 1
    assert ">The limit<" in page


def test_the_switch_publishes_solutions_and_never_hidden_checks(small_book):
    off = text_of(small_book())
    assert "doubled = 2 * x" not in off
    assert "8.125" not in off
    page = small_book("-D", "publish_solutions=1")
    on = text_of(page)
    assert "doubled = 2 * x\n    return doubled" in on
    assert "limit = 8.125" in on
    assert page.count('<details class="solution">') == 2
    assert "617" not in on
    assert "SOLUTION" not in on
    assert text_of(small_book()) == off


def test_an_exercise_without_its_heading_is_a_warning(small_book, course):
    path = course / "release/03_numbers/03_numbers.ipynb"
    text = path.read_text("utf-8")
    path.write_text(text.replace("## The limit", "The limit"), "utf-8")
    with pytest.raises(AssertionError, match="an exercise begins with a line such as"):
        small_book()


# ---- the pages of the book, as built ----


def built(stem):
    file = book.html_file(page(stem))
    assert file.exists(), f"{file.name} is not built: run `make book`"
    return file


@EACH
def test_the_page_offers_the_notebook_as_released(stem):
    text = built(stem).read_text("utf-8")
    links = re.findall(r'href="([^"]+\.ipynb)"', text)
    assert len(links) >= 2, "the theme's button, and a link in the text"
    for link in links:
        assert (built(stem).parent / link).read_bytes() == RELEASED[stem].read_bytes()


@EACH
def test_the_page_shows_no_secret_and_no_result_of_a_check(stem):
    text = text_of(built(stem).read_text("utf-8"))
    assert secrets(SOURCES[stem], *KINDS[PUBLISHED:])[1] & lines(text) == set()
    assert "Not yet:" not in text
    assert "Traceback" not in text


def test_the_whole_book_holds_no_hidden_check():
    folder = book.BUILD / "html"
    if not folder.exists():
        pytest.skip("the book is not built")
    texts = [words(text) for text in readable(folder)]
    assert len(texts) > len(book.pages())
    assert leaks(texts, PUBLISHED) == []
    assert not [path for path in folder.rglob("*") if "exercises/source" in path.as_posix()]


@EACH
def test_the_page_reads_well(browser, stem):
    texts = [c.source for c in read(RELEASED[stem]).cells if c.source.startswith("<!-- exercise:")]
    names = [re.match(r"<!-- exercise: (\S+)", text)[1] for text in texts]
    with opened(browser, page(stem)) as tab:
        boxes = tab.locator("article div.exercise")
        labels = [box.get_attribute("id") for box in boxes.all()]
        assert labels == [f"ex-{stem[:2]}-{name}" for name in names]
        numbers = [re.match(r"Exercise (\d+)\.(\d+)", box.inner_text()) for box in boxes.all()]
        first = int(numbers[0][2])
        assert [int(number[2]) for number in numbers] == list(range(first, first + len(numbers)))
        assert len({number[1] for number in numbers}) == 1
        assert tab.locator("article h1").count() == 1
        assert tab.locator("article h2").count() == len(names)
        said = tab.locator("article").inner_text()
        assert "<!--" not in said
        assert "{exercise}" not in said
        assert "<details" not in said
        checks = tab.locator("article details.hide").all()
        assert len(checks) == len(names)
        folds = tab.locator("article div.exercise details").all()
        assert len(folds) == sum(text.count("<summary>") for text in texts)
        assert folds
        for fold in [*folds, *checks]:
            assert not fold.evaluate("e => e.open")
            fold.locator("summary").press("Enter")
            assert fold.evaluate("e => e.open")
        assert tab.evaluate(RAW_TEX) == [], "mathematics that was not typeset"
