"""The page that a student gets: one file, which asks nothing of any host."""

from __future__ import annotations

import re
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .course import Chapter
    from .report import Marked, Sheet

STYLE = """
:root { color-scheme: light dark; --back: #fdfdfc; --text: #1d1f21; --soft: #f0efec;
  --line: #8a8a86; --good: #1b6630; --some: #7a4b00; }
@media (prefers-color-scheme: dark) {
  :root { --back: #16181a; --text: #e6e6e3; --soft: #24272a; --line: #85898d; --good: #8fd6a0;
    --some: #f0c069; } }
body { background: var(--back); color: var(--text); font: 1rem/1.5 system-ui, sans-serif;
  margin: 0 auto; max-width: 50rem; padding: 1.5rem 1rem 4rem; overflow-wrap: break-word; }
h1 { line-height: 1.2; } h2 { margin-top: 2.5rem; } h3 { margin: 2rem 0 .3rem; }
table { border-collapse: collapse; }
caption { text-align: left; font-weight: 600; padding: .3rem 0; }
th, td { border: 1px solid var(--line); padding: .25rem .7rem; text-align: left; }
td + td { text-align: right; }
pre { background: var(--soft); border: 1px solid var(--line); overflow-x: auto; padding: .7rem;
  font-size: .875rem; line-height: 1.4; tab-size: 4; }
code { background: var(--soft); padding: 0 .2em; } pre code { padding: 0; }
.passed { color: var(--good); } .open { color: var(--some); } .points { font-weight: 600; }
section.file { border-left: .3rem solid var(--some); padding-left: 1rem; }
@media print { pre { white-space: pre-wrap; } }
"""


def number(value: float) -> str:
    """Return points as one writes them."""
    return f"{value:.2f}".rstrip("0").rstrip(".")


def page(sheet: Sheet, handed: list[Chapter]) -> str:
    """Return the page of a student, for the chapters that the class handed in."""
    title = f"Feedback for {escape(sheet.name)}"
    most = number(sum(chapter.points for chapter in handed))
    parts = [
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"<title>{title}</title>\n"
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<style>{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>",
        _of_files(sheet),
        f'<p class="points">{number(sheet.total)} of {most} points</p>' if handed else "",
        _overview(sheet, handed),
        *(_notebook(one) for one in sheet.notebooks),
        "</main>\n</body>\n</html>\n",
    ]
    return "\n".join(filter(None, parts))


def _of_files(sheet: Sheet) -> str:
    """Return what was wrong with the files themselves."""
    said = [*sheet.troubles]
    for one in sheet.notebooks:
        said += [f"{one.chapter.title}: {remark}" for remark in one.remarks]
    if not said:
        return ""
    items = "\n".join(f"<li>{_worded(one)}</li>" for one in said)
    return f'<section class="file">\n<h2>What you handed in</h2>\n<ul>\n{items}\n</ul>\n</section>'


def _overview(sheet: Sheet, handed: list[Chapter]) -> str:
    if not handed:
        return ""
    rows = []
    for chapter in handed:
        marked = sheet.of(chapter)
        got = f"{number(marked.points)} of {number(chapter.points)}" if marked else "not handed in"
        rows.append(f'<tr><th scope="row">{escape(chapter.title)}</th><td>{got}</td></tr>')
    head = '<thead><tr><th scope="col">Notebook</th><th scope="col">Points</th></tr></thead>'
    body = "\n".join(rows)
    return f"<table>\n<caption>Your points</caption>\n{head}\n<tbody>\n{body}\n</tbody>\n</table>"


def _notebook(marked: Marked) -> str:
    parts = [f"<h2>{escape(marked.chapter.title)}</h2>", f"<p>File: {escape(marked.place)}</p>"]
    results = marked.result.get("exercises", {})
    for exercise in marked.chapter.exercises:
        if exercise.name not in results:
            continue
        one = results[exercise.name]
        got = "not marked yet" if one["points"] is None else number(one["points"])
        kind = "passed" if (one["points"] or 0) >= exercise.points else "open"
        parts.append(
            f"<h3>{escape(exercise.title)}</h3>\n"
            f'<p class="points">{got} of {number(exercise.points)} points</p>\n'
            f'<p class="{kind}">{_worded(one["says"])}</p>'
        )
        if one["answer"].strip():
            label = f"Your answer to {escape(exercise.title, quote=True)}"
            parts.append(
                f'<pre tabindex="0" role="region" aria-label="{label}"><code>'
                f"{escape(one['answer'])}</code></pre>"
            )
    return "\n".join(parts)


def _worded(text: str) -> str:
    """Return a sentence, with what stands between ` and ` as code."""
    return re.sub(r"`([^`\n]+)`", r"<code>\1</code>", escape(text, quote=False))
