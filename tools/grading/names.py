"""Names that a notebook relies on and a student gave another meaning, found without running it."""

import ast
import builtins
from collections.abc import Iterator

from IPython.core.inputtransformer2 import TransformerManager
from nbformat import NotebookNode
from nbgrader import utils

BUILTINS = {one for one in dir(builtins) if not one.startswith("_")} - {"copyright", "credits"}


def overwritten(notebook: NotebookNode) -> dict[str, list[str]]:
    """Return the names, each with the grade_ids of the cells that overwrite it ("" for others)."""
    trees = {i: _tree(c.source) for i, c in enumerate(notebook.cells) if c.cell_type == "code"}
    locked = {i for i in trees if utils.is_locked(notebook.cells[i])}
    imported = {}
    for i in sorted(locked):
        imported |= dict(_imports(trees[i]))
    found: dict[str, list[str]] = {}
    for i in sorted(set(trees) - locked):
        where = notebook.cells[i].metadata.get("nbgrader", {}).get("grade_id", "")
        same = dict(_imports(trees[i]))
        for one in _bound(trees[i]):
            again = one in imported and same.get(one) == imported[one]
            needed = one in imported or one in BUILTINS or one.endswith("import *")
            if needed and not again:
                found.setdefault(one, []).append(where)
    return found


def _tree(source: str) -> ast.Module:
    try:
        return ast.parse(TransformerManager().transform_cell(source))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return ast.Module([], [])


def _imports(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """Yield the names that imports give, and what they give them to."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.asname or alias.name.partition(".")[0], alias.name
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                yield alias.asname or alias.name, f"{node.module}.{alias.name}"


def _bound(tree: ast.Module) -> list[str]:
    """Return the names that a cell binds for the whole notebook, each once."""
    found: dict[str, None] = {}
    for node in _outside_functions(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            found[node.name] = None
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store | ast.Del):
            found[node.id] = None
        elif isinstance(node, ast.Import | ast.ImportFrom):
            for name, full in _imports(node):
                found[f"from {full.removesuffix('.*')} import *" if name == "*" else name] = None
        elif isinstance(node, ast.ExceptHandler | ast.MatchAs | ast.MatchStar) and node.name:
            found[node.name] = None
    for node in ast.walk(tree):
        if isinstance(node, ast.Global):
            found |= dict.fromkeys(node.names)
    return list(found)


def _outside_functions(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a cell, those of functions, classes and comprehensions left out."""
    inner = ast.Lambda | ast.ListComp | ast.SetComp | ast.DictComp | ast.GeneratorExp
    for child in ast.iter_child_nodes(node):
        yield child
        if not isinstance(child, inner | ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield from _outside_functions(child)
