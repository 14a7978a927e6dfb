"""One submission of each kind to a toy course: all get their marks, and are told why."""

import copy
import csv
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import nbformat
import psutil
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from benchmarks import grading, submissions
from benchmarks.submissions import KINDS, Draft, as_bytes
from tests.test_pages import AXE, WCAG
from tools import grade as grade_program
from tools.grading import course as courses
from tools.grading import feedback, intake, names, pool, report, session, words

ROOT = Path(__file__).resolve().parents[1]
LIMITS = ["--cell-timeout", "4", "--timeout", "40", "--memory", "400"]
STEMS = ["01_numbers", "02_words"]


def marks(name, points=None, *, answer=False):
    """Return the metadata of a cell of nbgrader's."""
    found = {"grade_id": name, "schema_version": 3, "solution": answer, "grade": points is not None}
    if points is not None:
        found["points"] = points
    return {"nbgrader": {**found, "locked": not answer, "task": False}}


def exercise(name, title, points, head, solution, visible, hidden):
    """Return the three cells of an exercise; the solution is the last line of its answer."""
    indent = "    " if head.startswith("def") else ""
    answer = f"{head}\n{indent}### BEGIN SOLUTION\n{indent}{solution}\n{indent}### END SOLUTION"
    check = (
        f'with checks.exercise("{title}"):\n    {visible}\n'
        f"    ### BEGIN HIDDEN TESTS\n    {hidden}\n    ### END HIDDEN TESTS"
    )
    return [
        new_markdown_cell(f"<!-- exercise: {name} -->\n## {title}\n\n*Code, {points} points.* Do."),
        new_code_cell(answer, metadata=marks(name, answer=True)),
        new_code_cell(check, metadata=marks(f"{name}-check", points)),
    ]


def write_course(root):
    """Write a course of two notebooks."""
    imports = new_code_cell(
        "import numpy as np\nimport distmesh_edu as de\nfrom distmesh_edu import checks",
        metadata=marks("imports"),
    )
    halves = exercise(
        *("half", "Half of it", 2, 'def half(x):\n    """Half."""', "return x / 2"),
        'checks.expect_values(half(4.0), 2.0, what="half of 4")',
        'checks.expect_values(half(-3.0), -1.5, what="half of -3")',
    )
    limit = exercise(
        *("limit", "The limit", 1, "limit = ...", "limit = 1.0"),
        'checks.expect_values(limit, 1.0, what="the limit")',
        "pass",
    )
    total = exercise(
        *("total", "A sum & more", 3, "def total(values):", "return np.sum(values)"),
        'checks.expect_values(total([1, 2]), 3.0, what="the sum of 1 and 2")',
        'checks.expect_values(total(np.ones(4_000_000)), 4e6, what="the sum of ones")',
    )
    greet = exercise(
        *("greet", "A greeting", 2, "def greet():", "return 7"),
        "checks.expect_values(greet(), 7)",
        "pass",
    )
    for stem, cells in zip(STEMS, [[*halves, *limit, *total], greet], strict=True):
        title = new_markdown_cell(f"# Exercises: {stem[3:].title()}")
        notebook = new_notebook(cells=[title, imports, *cells])
        notebook.metadata["kernelspec"] = {
            "name": "python3",
            "display_name": "Python 3",
            "language": "python",
        }
        place = root / "source" / stem / f"{stem}.ipynb"
        place.parent.mkdir(parents=True)
        nbformat.write(notebook, place)
    shutil.copy(ROOT / "exercises/nbgrader_config.py", root)
    return submissions.read(root / "source/01_numbers/01_numbers.ipynb")


def draft_of(kind, course, victim="half"):
    """Return a submission of a kind."""
    draft = Draft(course, victim)
    source = 'def half(x):\n    """A third."""\n    return x / 3'
    draft.answers = [SimpleNamespace(exercise="half", source=source, says="half of 4 should be 2")]
    KINDS[kind](draft)
    return draft


def command(folder, out, course, *more):
    """Return how one grades."""
    options = ["--out", str(out), "--course", str(course), *LIMITS, *more]
    return [sys.executable, "-m", "tools.grade", str(folder), *options]


def grade(folder, out, course, *more, scratch=None, code=0):
    """Grade in a process of its own, and return what it printed."""
    environment = {**os.environ, "TMPDIR": str(scratch)} if scratch else {**os.environ}
    run = subprocess.run(
        command(folder, out, course, *more),
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
        env=environment,
        timeout=300,
    )
    assert run.returncode == code, run.stdout + run.stderr
    return run.stdout + run.stderr


@dataclass
class Graded:
    """A class that was graded."""

    root: Path
    drafts: dict[str, Draft]
    printed: str

    @property
    def place(self):
        """What was handed in, where it was written to, and the course."""
        return self.root / "class", self.root / "out", self.root / "course"

    def row(self, student):
        """Return a student's line of the table."""
        return grading.rows(self.root / "out")[student]

    def page(self, student):
        """Return a student's page."""
        return (self.root / "out/feedback" / self.row(student)["page"]).read_text("utf-8")


def mixed(course):
    """Return a wrong answer, one whose check is gone, and one in the second of two cells."""
    draft = draft_of("wrong", course)
    draft.notebook["cells"].insert(draft.at("limit"), copy.deepcopy(draft.cell("limit")))
    draft.cell("limit")["source"] = "# nothing yet"
    del draft.notebook["cells"][draft.at("total-check")]
    return draft


@pytest.fixture(scope="module")
def graded(tmp_path_factory):
    """Grade one submission of each kind, in all layouts that a folder may mix."""
    root = tmp_path_factory.mktemp("class")
    course = write_course(root / "course")
    drafts = {}
    for i, kind in enumerate(KINDS):
        student = f"Zoë {kind}"
        drafts[student] = draft_of(kind, course)
        grading.put(root / "class", student, drafts[student], grading.LAYOUTS[i % 4], 100 + i)
    drafts["Zoë mixed"] = mixed(course)
    grading.put(root / "class", "Zoë mixed", drafts["Zoë mixed"], "flat", 99)
    (root / "class/list of students.csv").write_text("Zoë")
    scratch = root / "t"
    scratch.mkdir()
    printed = grade(
        *(root / one for one in ("class", "out", "course")), "--jobs", "4", scratch=scratch
    )
    return Graded(root, drafts, printed)


@pytest.mark.parametrize("kind", [*KINDS, "mixed"])
def test_each_kind_gets_its_marks_and_its_words(graded, kind):
    student = f"Zoë {kind}"
    draft = graded.drafts[student]
    assert grading.differences(draft, graded.row(student), graded.page(student)) == []


def test_a_wrong_mark_is_noticed(graded):
    draft, row = graded.drafts["Zoë endless"], graded.row("Zoë endless")
    wrong = grading.differences(draft, row | {"01_numbers/half": "2", "total": "6"}, "")
    assert [line.split(":")[0] for line in wrong] == [
        "half of 01_numbers",
        "6 points in all, not 4",
        "is not told",
    ]


def test_all_are_in_the_table_and_nobody_else(graded):
    assert grading.rows(graded.root / "out").keys() == graded.drafts.keys()
    assert "list of students.csv" in graded.printed
    assert f"{len(KINDS) + 1} students" in graded.printed


def test_the_table_has_columns_for_all_and_says_what_a_teacher_should_know(graded):
    row = graded.row("Zoë endless")
    assert [*row] == [
        *("student", "id", "total", "of", "01_numbers"),
        *("01_numbers/half", "01_numbers/limit", "01_numbers/total", "page", "notes"),
    ]
    assert (row["total"], row["of"], row["01_numbers/half"]) == ("4", "6", "0")
    assert "did not end within 4 seconds" in row["notes"]
    assert "No exercise is answered" in graded.row("Zoë empty")["notes"]
    assert graded.row("Zoë good")["notes"] == ""


def test_nothing_is_left_of_any_notebook(graded):
    assert [*(graded.root / "t").iterdir()] == []
    mine = str(graded.root / "t")
    left = []
    for process in psutil.process_iter():
        try:
            if process.environ().get("TMPDIR", "").startswith(mine):
                left.append(process.cmdline())
        except psutil.Error:
            continue
    assert left == []


def test_a_page_asks_no_host_and_shows_no_hidden_check(graded):
    for student in graded.drafts:
        page = graded.page(student)
        assert not re.search(r"(https?:)?//\w|<(script|link|img|iframe)|url\(", page)
        assert "HIDDEN" not in page
        assert "expect_values" not in page
        assert str(graded.root) not in page


def test_a_page_escapes_what_a_student_wrote(graded):
    marked = report.Marked(
        SimpleNamespace(
            stem="x",
            title="<b>",
            points=1.0,
            exercises=[SimpleNamespace(name="e", title="</h3>", points=1.0)],
        ),
        "<i>.ipynb",
        {
            "remarks": [],
            "exercises": {
                "e": {"points": 0.0, "says": "<u> `<s>`", "answer": "</pre><script>", **ANSWERED}
            },
        },
    )
    sheet = report.Sheet("<em>", "", [marked])
    page = feedback.page(sheet, [marked.chapter])
    for tag in ("<b>", "</h3></h3>", "<i>", "<u>", "<s>", "<script>", "<em>"):
        assert tag not in page
    assert "<code>&lt;s&gt;</code>" in page


ANSWERED = {"answered": True, "stopped": False}


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_a_page_is_accessible(graded, browser, theme):
    context = browser.new_context(color_scheme=theme, viewport={"width": 360, "height": 900})
    tab = context.new_page()
    for student in ("Zoë wrong", "Zoë moves cells", "Zoë not json"):
        tab.goto((graded.root / "out/feedback" / graded.row(student)["page"]).as_uri())
        assert tab.evaluate("document.documentElement.scrollWidth") <= 360
        tab.evaluate(AXE.read_text(encoding="utf-8"))
        result = tab.evaluate("tags => axe.run({runOnly: tags, preload: false})", WCAG)
        assert result["passes"]
        assert [fault["id"] for fault in result["violations"]] == []
    context.close()


def test_a_new_answer_is_graded_and_nothing_else(graded, tmp_path):
    shutil.copytree(graded.root / "out/results", tmp_path / "out/results")
    for student, kind in (("Ada", "good"), ("Eve", "empty"), ("Max", "wrong")):
        draft = graded.drafts[f"Zoë {kind}"]
        if student == "Max":
            draft.notebook["metadata"]["new"] = True
        grading.put(tmp_path / "class", student, draft, "flat", 1)
    printed = grade(tmp_path / "class", tmp_path / "out", graded.root / "course")
    assert "2 notebooks were graded before" in printed
    assert "1 of 1 notebooks" in printed
    found = grading.rows(tmp_path / "out")
    assert {name: row["total"] for name, row in found.items()} == {
        "Ada": "6",
        "Eve": "0",
        "Max": "4",
    }


def test_what_decides_about_marks_decides_whether_they_are_kept(tmp_path):
    toy = write_course(tmp_path / "course")
    student = intake.Student("Ada")
    file = intake.File(("Ada", "x.ipynb"), as_bytes(toy.solved))

    def key(*options):
        wishes = [str(tmp_path), "--course", str(tmp_path / "course"), *options]
        return session.Session(grade_program.options(wishes))._job(student, file).key

    keys = [key(), key("--memory", "9"), key("--timeout", "9"), key("--cell-timeout", "9")]
    keys.append(key("--slow"))
    student.files = [file, intake.File(("Ada", "helpers.py"), b"a = 1")]
    keys.append(key())
    student.files = [file, intake.File(("Ada", "helpers.py"), b"a = 2")]
    keys.append(key())
    file = intake.File(file.parts, as_bytes(toy.released))
    keys.append(key())
    place = tmp_path / "course/source/02_words/02_words.ipynb"
    place.write_text(place.read_text("utf-8").replace("greet(), 7", "greet(), 8"))
    keys.append(key())
    assert len(set(keys)) == len(keys)
    assert key() == keys[-1]


def test_a_run_that_was_stopped_goes_on(graded, tmp_path):
    course = graded.drafts["Zoë good"].course
    for i in range(3):
        draft = Draft(course, "half")
        draft.begins(f"import time\ntime.sleep({0.6 if i else 0})  # {i}")
        grading.put(tmp_path / "class", f"S{i}", draft, "flat", i)
    out, results = tmp_path / "out", tmp_path / "out/results"
    shutil.copytree(graded.root / "out/results", results)  # the course's own is among them
    before = len([*results.glob("*.json")])
    toy = graded.root / "course"
    begun = subprocess.Popen(
        command(tmp_path / "class", out, toy, "--jobs", "1"), cwd=ROOT, stderr=subprocess.PIPE
    )
    while len([*results.glob("*.json")]) < before + 1 and begun.poll() is None:
        time.sleep(0.02)
    begun.send_signal(signal.SIGINT)
    said = begun.communicate(timeout=20)[1].decode()
    assert begun.returncode == 130
    assert "What is graded is kept" in said
    assert "Traceback" not in said
    assert not (out / "grades.csv").exists()
    kept = len([*results.glob("*.json")]) - before
    assert 1 <= kept < 3
    printed = grade(tmp_path / "class", out, toy)
    assert f"{kept} notebooks were graded before" in printed
    assert {row["total"] for row in grading.rows(out).values()} == {"6"}


def test_nbgrader_itself_gives_the_same_marks(graded, tmp_path):
    kinds = ["mixed", "edits check"]
    work = tmp_path / "nbgrader"
    shutil.copytree(graded.root / "course", work)
    for kind in kinds:
        place = work / f"submitted/{kind.replace(' ', '-')}/01_numbers/01_numbers.ipynb"
        place.parent.mkdir(parents=True)
        place.write_bytes(as_bytes(graded.drafts[f"Zoë {kind}"].notebook))
    script = tmp_path / "run.py"
    script.write_text(NBGRADER)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"  # it calls alembic
    run = subprocess.run(
        [sys.executable, script, *(kind.replace(" ", "-") for kind in kinds)],
        capture_output=True,
        text=True,
        check=False,
        cwd=work,
        env={**os.environ, "JUPYTER_PREFER_ENV_PATH": "1", "PATH": path},
    )
    assert run.returncode == 0, run.stderr[-2000:]
    theirs = json.loads(run.stdout.splitlines()[-1])
    for kind in kinds:
        row = graded.row(f"Zoë {kind}")
        ours = {name: float(row[f"01_numbers/{name}"]) for name in ("half", "limit", "total")}
        assert theirs[kind.replace(" ", "-")] == ours, kind


NBGRADER = """
import json, sys
from nbgrader.apps import NbGraderAPI
from traitlets.config import Config
from traitlets.config.loader import PyFileConfigLoader

config = PyFileConfigLoader("nbgrader_config.py", ".").load_config()
api = NbGraderAPI(config=config)
made = api.generate_assignment("01_numbers")
assert made["success"], made
found = {}
for student in sys.argv[1:]:
    done = api.autograde("01_numbers", student)
    assert done["success"], done
    with api.gradebook as book:
        grades = book.find_submission_notebook("01_numbers", "01_numbers", student).grades
        found[student] = {g.name.removesuffix("-check"): g.score for g in grades}
print("\\n" + json.dumps(found))
"""


def test_where_nothing_can_be_forked_kernels_start_as_jupyter_does(graded, tmp_path):
    shutil.copytree(graded.root / "out/results", tmp_path / "out/results")
    grading.put(tmp_path / "class", "Ada", graded.drafts["Zoë endless"], "flat", 1)
    slow = ["--slow", "--cell-timeout", "1"]
    printed = grade(tmp_path / "class", tmp_path / "out", graded.root / "course", *slow)
    assert "the memory of a notebook is not limited" in printed
    assert "1 of 1 notebooks" in printed
    assert grading.rows(tmp_path / "out")["Ada"]["total"] == "4"


def test_a_course_whose_solutions_fail_here_grades_nobody(tmp_path):
    course = write_course(tmp_path / "course")
    place = tmp_path / "course/source/01_numbers/01_numbers.ipynb"
    place.write_text(place.read_text("utf-8").replace("half(-3.0)", "half(-5.0)"))
    (tmp_path / "01_numbers_Ada.ipynb").write_bytes(as_bytes(course.solved))
    single = tmp_path / "01_numbers_Ada.ipynb"
    printed = grade(single, tmp_path / "out", tmp_path / "course", code=1)
    assert "01_numbers: the solutions do not earn all points here" in printed
    assert "half: 0, Not yet: half of -3" in printed
    assert not (tmp_path / "out/grades.csv").exists()


def test_what_is_not_there_is_said(tmp_path):
    assert "is not there" in grade(tmp_path / "x", tmp_path / "out", ROOT / "exercises", code=2)


# ---- what teachers have on their disks ----


def collected(root, files, stems=STEMS):
    """Write files, and return the names of those that come out of a student's hands, by student."""
    for name, data in files.items():
        place = root / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(data) if data is not None else place.mkdir()
    handed = intake.collect(root, stems)
    return {student.name: [f.name for f in student.files] for student in handed.students}


@pytest.mark.parametrize(
    ("files", "expected"),
    [
        (["Ada/01_numbers.ipynb", "Béla/x.ipynb"], ["Ada", "Béla"]),
        (["submitted/Ada/01_numbers/01_numbers.ipynb", "source/01_numbers/a.ipynb"], ["Ada"]),
        (["Ada/01_numbers/01_numbers.ipynb", "Béla/02_words/02_words.ipynb"], ["Ada", "Béla"]),
        (["Ada/01_numbers/01_numbers.ipynb"], ["Ada"]),
        (["class/Ada/x.ipynb", "class/Béla/x.ipynb"], ["Ada", "Béla"]),
        (["class/Ada_01_numbers.ipynb", "class/Béla_01_numbers.ipynb"], ["Ada", "Béla"]),
        (["01_numbers/Ada.ipynb", "02_words/Ada.ipynb"], ["Ada"]),
        (["01_numbers/Ada/x.ipynb", "02_words/Ada/y.ipynb"], ["Ada"]),
        (["Ada Müller_01_numbers.ipynb", "01_numbers - Béla (1).ipynb"], ["Ada Müller", "Béla"]),
        (["Ada_numbers.ipynb", "ada words-Copy1.ipynb", "Ada ex 2.ipynb"], ["Ada"]),
        (["ada_01_numbers.ipynb.txt", "béla.ipynb.json"], ["ada", "béla"]),
        (["Bach_01_numbers.ipynb", "Bach 12.ipynb"], ["Bach", "Bach 12"]),
        (["Ada B_12_assignsubmission_file_/x.ipynb"], ["Ada B"]),
        (["Ada B_12_assignsubmission_file_x.ipynb"], ["Ada B"]),
        (
            ["Ada_12_assignsubmission_file_/x.ipynb", "Ada_12_assignsubmission_onlinetext_/o.html"],
            ["Ada"],
        ),
        (
            ["Ada_12_assignsubmission_file_/x.ipynb", "Ada_13_assignsubmission_file_/x.ipynb"],
            ["Ada (12)", "Ada (13)"],
        ),
        (["bada_LATE_12345_67890_01_numbers.ipynb", "bada_12345_67891_x.ipynb"], ["bada"]),
        (["Ada\u0308_01_numbers.ipynb", "Ad\u00e4_02_words.ipynb"], ["Adä"]),
        (["Ada/.ipynb_checkpoints/x.ipynb", "Ada/x.ipynb", "__MACOSX/Eve/x.ipynb"], ["Ada"]),
    ],
)
def test_students_are_found_in_their_files(tmp_path, files, expected):
    found = collected(tmp_path / "given", dict.fromkeys(files, b"{}"))
    assert [*found] == expected


def test_a_folder_of_one_student_is_that_student_s(tmp_path):
    found = collected(tmp_path / "Ada", {"01_numbers.ipynb": b"{}", "02_words.ipynb": b"{}"})
    assert found == {"Ada": ["01_numbers.ipynb", "02_words.ipynb"]}


def test_an_empty_folder_is_a_student_without_a_file(tmp_path):
    found = intake.collect(tmp_path, STEMS).students
    assert found == []
    collected(tmp_path, {"Ada/nothing": None, "Béla/x.ipynb": b"{}"})
    ada = intake.collect(tmp_path, STEMS).students[0]
    assert (ada.name, ada.files[0].trouble) == ("Ada", "The folder is empty.")


def zipped(place, files, flags=0):
    """Write a zip."""
    place.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(place, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return place


def test_zips_are_folders(tmp_path):
    inner = zipped(tmp_path / "inner.zip", {"my work/x.ipynb": "{}", "__MACOSX/x.ipynb": ""})
    whole = zipped(
        tmp_path / "class.zip",
        {
            "class/Ada.zip": inner.read_bytes(),
            "class/Béla_7_assignsubmission_file_/x.ipynb": "{}",
            "class/../../Eve/x.ipynb": "{}",
            "class/Eve/.ipynb_checkpoints/x.ipynb": "{}",
        },
    )
    found = intake.collect(whole, STEMS).students
    assert {one.name: [f.name for f in one.files] for one in found} == {
        "Ada": ["Ada/my work/x.ipynb"],
        "Béla": ["Béla_7_assignsubmission_file_/x.ipynb"],
        "Eve": ["Eve/x.ipynb"],
    }


def test_a_name_in_a_zip_that_does_not_say_it_is_utf_8(tmp_path):
    place = zipped(tmp_path / "class.zip", {"Xx/x.ipynb": "{}", "Ada/x.ipynb": "{}"})
    place.write_bytes(place.read_bytes().replace(b"Xx/", "é/".encode()))
    assert [one.name for one in intake.collect(place, STEMS).students] == ["Ada", "é"]


def test_zips_that_are_too_much_are_not_opened(tmp_path, monkeypatch):
    monkeypatch.setattr(intake, "MAX_ZIP", 1000)
    zipped(tmp_path / "Ada.zip", {"x.ipynb": "0" * 1001})
    place = zipped(tmp_path / "Béla.zip", {"a.zip": ""})
    for _ in range(3):
        place = zipped(place, {"a.zip": place.read_bytes()})
    (tmp_path / "Chloé.ipynb").write_bytes(b"0" * 2000)
    monkeypatch.setattr(intake, "MAX_FILE", 1999)
    found = {one.name: one.files[0].trouble for one in intake.collect(tmp_path, STEMS).students}
    assert "holds too much" in found["Ada"]
    assert "zips within zips" in found["Béla"]
    assert "larger than" in found["Chloé"]


def test_two_students_of_one_name_have_two_pages(tmp_path):
    sheets = [report.Sheet(name, "") for name in ("Ada", "ada", "A/d:a", "A?d*a", "=1+1", "..")]
    report.write(sheets, tmp_path)
    pages = [sheet.page for sheet in sheets]
    assert len({page.casefold() for page in pages}) == 6
    assert all((tmp_path / "feedback" / page).exists() for page in pages)
    with (tmp_path / "grades.csv").open(encoding="utf-8-sig", newline="") as file:
        assert [row["student"] for row in csv.DictReader(file)][4] == "'=1+1"


# ---- the parts ----


def test_the_grader_and_what_students_get_speak_of_the_same_exercises():
    course = courses.load(ROOT / "exercises")
    for stem, chapter in course.chapters.items():
        assert len(course.own_ids[stem]) > len(chapter.ids) / 2, "it could not be recognised"
        for one in chapter.exercises:
            assert one.title != one.name, f"{stem}: {one.name} has no title"
            assert one.name in chapter.ids


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("np = 1", ["np"]),
        ("sum = 0\nfor list in []: pass", ["sum", "list"]),
        ("from scipy import special as de", ["de"]),
        ("def max(a): return a", ["max"]),
        ("def f():\n    global np\n    np = 3", ["np"]),
        ("with open('x') as checks: pass", ["checks"]),
        ("if True:\n    min: int = 3", ["min"]),
        ("from numpy import *", ["from numpy import *"]),
        ("import numpy as np\nimport numpy.linalg\nfrom distmesh_edu import checks", []),
        ("def f(np, sum):\n    max = 3\n    return [min for min in sum]", []),
        ("class Own:\n    sum = 3", []),
        ("np.random = 3\nx[np] = 1", []),
        ("%matplotlib inline\n!ls", []),
        ("def broken(", []),
    ],
)
def test_names_that_are_overwritten_are_found(source, expected):
    imports = "import numpy as np\nimport distmesh_edu as de\nfrom distmesh_edu import checks"
    cells = [new_code_cell(imports, metadata=marks("imports")), new_code_cell(source)]
    assert [*names.overwritten(new_notebook(cells=cells))] == expected


def test_a_warning_is_quoted_without_the_place_it_came_from():
    text = "/var/x/12.py:3: RuntimeWarning: divide by zero\n  a / 0\n"
    said = words.Said(words.Outcome("stderr", text), words.Outcome(""))
    assert words.sentence(said, 0.0, 1.0, None).endswith("RuntimeWarning: divide by zero")


def test_a_result_that_is_half_done_or_broken_is_none(tmp_path):
    for key, text in {"a": '{"again": {}}', "b": "{", "c": "[]", "d": '{"stem": "x"}'}.items():
        (tmp_path / f"{key}.json").write_text(text)
    assert [pool.result_of(tmp_path, key) for key in "abcde"] == [
        None, None, None, {"stem": "x"}, None,
    ]  # fmt: skip
