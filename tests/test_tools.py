"""What the Makefile calls: the check of the built book, and the cleaning of the notebooks."""

import subprocess
import sys

from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook, new_output

from tools import book, check, install_browser
from tools.refresh import tidy

HTML = '<article><h1>A page</h1><img src="../_images/a.png"><img src="../_images/a.png"></article>'


def built(root, html):
    """Write a book of one page."""
    (root / "_toc.yml").write_text("format: jb-book\nroot: book/index\n")
    page = book.html_file("book/index", root / "_build")
    page.parent.mkdir(parents=True)
    page.write_text(html)
    images = root / "_build" / "html" / "_images"
    images.mkdir()
    (images / "a.png").write_bytes(bytes(1000))
    return page


def test_a_good_page_has_no_problem_and_counts_each_picture_once(tmp_path):
    page = built(tmp_path, HTML)
    assert book.problems(tmp_path) == []
    assert book.weight(page) == len(HTML) + 1000


def test_a_missing_page_is_a_problem(tmp_path):
    built(tmp_path, HTML).unlink()
    assert "was not built" in book.problems(tmp_path)[0]


def test_an_empty_page_is_a_problem(tmp_path):
    built(tmp_path, "<article></article>")
    assert "empty" in book.problems(tmp_path)[0]


def test_a_heavy_page_is_a_problem(tmp_path):
    built(tmp_path, HTML + "x" * book.MAX_BYTES)
    assert "fewer steps" in book.problems(tmp_path)[0]


def test_tidy_keeps_what_is_the_same_each_time():
    data = {"text/plain": "1", "application/vnd.jupyter.widget-view+json": {"model_id": "chance"}}
    cell = new_code_cell("x", outputs=[new_output("display_data", data)], execution_count=3)
    cell.metadata = {
        "mystnb": {"figure": {"name": "fig-1"}},
        "execution": {"iopub.status.busy": "now"},
    }
    notebook = new_notebook(cells=[new_markdown_cell("text"), cell])
    notebook.metadata["widgets"] = {"state": {}}
    notebook.metadata["language_info"] = {"name": "python", "version": "3.99"}
    before = [cell.id for cell in notebook.cells]
    tidy(notebook)
    assert cell.outputs[0].data == {"text/plain": "1"}
    assert list(cell.metadata) == ["mystnb"]
    assert cell.execution_count == 3
    assert set(notebook.metadata) == {"kernelspec", "language_info"}
    assert notebook.metadata["language_info"] == {"name": "python"}
    assert [cell.id for cell in notebook.cells] == before


def test_a_missing_browser_fails_only_in_continuous_integration(monkeypatch, capsys):
    monkeypatch.setattr(install_browser, "find_browser", lambda: None)
    monkeypatch.setattr(install_browser, "as_root", lambda: None)
    monkeypatch.delenv("CI", raising=False)
    assert install_browser.main() == 0
    monkeypatch.setenv("CI", "true")
    assert install_browser.main() == 1
    assert capsys.readouterr().err.count("install Chromium") == 2


def test_a_browser_is_installed_where_one_may(monkeypatch, capsys):
    done = []
    monkeypatch.setattr(install_browser, "find_browser", lambda: "/a/browser" if done else None)
    monkeypatch.setattr(install_browser, "as_root", lambda: ["sudo", "-n"])
    monkeypatch.setattr(install_browser, "install", done.append)
    assert install_browser.main() == 0
    assert done == [["sudo", "-n"]]


def test_no_root_no_installation(monkeypatch):
    failed = subprocess.CompletedProcess([], 1)
    monkeypatch.setattr(install_browser.os, "geteuid", lambda: 1000, raising=False)
    monkeypatch.setattr(install_browser.shutil, "which", lambda name: f"/usr/bin/{name}")
    monkeypatch.setattr(install_browser.subprocess, "run", lambda *_, **__: failed)
    assert install_browser.as_root() is None
    monkeypatch.setattr(install_browser.shutil, "which", lambda name: None)
    assert install_browser.as_root() is None


def test_the_summary_fails_when_one_check_does(monkeypatch, capsys):
    good, bad = [sys.executable, "-c", ""], [sys.executable, "-c", "raise SystemExit(3)"]
    run = subprocess.run
    monkeypatch.setattr(check.subprocess, "run", lambda command, **_: run(command[2:], check=False))
    monkeypatch.setattr(check, "CHECKS", {"one": good, "two": good})
    assert check.main() == 0
    monkeypatch.setattr(check, "CHECKS", {"one": bad, "two": good})
    assert check.main() == 1
    assert "FAILED  one" in capsys.readouterr().out
