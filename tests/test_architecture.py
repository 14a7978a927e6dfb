"""The shape of the library, read from its source, and what holds for every file that is kept."""

import ast
import hashlib
import io
import re
import subprocess
import sys
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "distmesh_edu"

MAX_FUNCTION_LINES = 25
MAX_MODULE_LINES = 250

# A module may import those named here and what they may import in their turn. The rest of the rule:
# one whose name begins with "_" may be imported by all and imports none; `__init__` may import all.
MAY_IMPORT = {
    "boundaries": set(),
    "implicit_functions": set(),
    "grid": set(),
    "geometry": {"grid"},
    "mesh": set(),
    "region": set(),
    "seeding": {"region"},
    "segmentation": set(),
    "convection": {"boundaries"},
    "eno": {"boundaries"},
    "examples": {"implicit_functions", "grid"},
    "normal_motion": {"convection", "eno"},
    "reinitialization": {"normal_motion"},
    "redistancing": {"reinitialization"},
    "gradient_limiting": {"normal_motion"},
    "size_functions": {"gradient_limiting", "redistancing", "geometry", "implicit_functions"},
    "distmesh": {"mesh", "region"},
    "mesh_improvement": {"distmesh"},
    "mesh_generation": {"mesh_improvement", "seeding"},
    "mesh_checks": {"mesh", "gradient_limiting"},
    "checks": {"mesh_checks"},
}
# What draws and what interacts stand below all of these.
MAY_IMPORT |= {"plotting": set(MAY_IMPORT), "interactive": set(MAY_IMPORT)}
# Beyond Python's own. meshio is imported inside the two methods that need it.
OTHERS = {module: {"numpy", "scipy"} for module in MAY_IMPORT} | {
    "mesh": {"numpy", "scipy", "meshio"},
    "plotting": {"numpy", "scipy", "matplotlib", "mpl_toolkits"},
    "interactive": {"numpy", "scipy", "matplotlib", "ipywidgets", "IPython"},
}
LAZY = ["matplotlib", "ipywidgets", "meshio", "IPython"]

SOURCES = {
    path.stem: path.read_text(encoding="utf-8") for path in sorted((ROOT / PACKAGE).glob("*.py"))
}
PUBLIC = [module for module in SOURCES if not module.startswith("_")]
MODULES = pytest.mark.parametrize("module", SOURCES)
PUBLIC_MODULES = pytest.mark.parametrize("module", PUBLIC)


def imported(source: str) -> tuple[set[str], set[str]]:
    """Return the modules of this package and the other packages that a source imports anywhere."""
    own, others = set(), set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            prefix = [PACKAGE] * bool(node.level) + [node.module] * bool(node.module)
            names = [".".join([*prefix, alias.name]) for alias in node.names]
        else:
            continue
        for name in names:
            package, _, rest = name.partition(".")
            if package == PACKAGE:
                own.add(rest.partition(".")[0] or "__init__")
            else:
                others.add(package)
    return own, others - set(sys.stdlib_module_names)


def reachable(module: str) -> set[str]:
    """Return what stands further up a module's own line."""
    above = MAY_IMPORT[module]
    return above.union(*(reachable(one) for one in above))


@PUBLIC_MODULES
def test_a_module_stands_in_the_table(module):
    assert module in MAY_IMPORT, "say in MAY_IMPORT what it may import"


@PUBLIC_MODULES
def test_imports_go_up_only(module):
    own, others = imported(SOURCES[module])
    assert {name for name in own if not name.startswith("_")} <= reachable(module)
    assert "__init__" not in own
    assert others <= OTHERS[module]


@MODULES
def test_private_modules_import_none(module):
    if module.startswith("_") and module != "__init__":
        assert imported(SOURCES[module])[0] == set()


def test_importing_the_package_draws_nothing_in():
    script = f"import sys, {PACKAGE}; print(*(name for name in {LAZY} if name in sys.modules))"
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert run.stdout.split() == []


@PUBLIC_MODULES
def test_a_module_has_its_tests(module):
    assert (ROOT / "tests" / f"test_{module}.py").exists()


def code_lines(source: str) -> set[int]:
    """Return the numbers of the lines that are neither blank, nor comment, nor docstring."""
    skipped = (
        tokenize.COMMENT,
        tokenize.NL,
        tokenize.NEWLINE,
        tokenize.INDENT,
        tokenize.DEDENT,
        tokenize.ENDMARKER,
    )
    lines = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in skipped:
            lines |= set(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(ast.parse(source)):
        if (
            isinstance(node, ast.Expr)
            and isinstance(node.value, ast.Constant)
            and isinstance(node.value.value, str)
        ):
            lines -= set(range(node.lineno, node.end_lineno + 1))
    return lines


@MODULES
def test_modules_and_functions_are_short(module):
    lines = code_lines(SOURCES[module])
    assert len(lines) <= MAX_MODULE_LINES
    for node in ast.walk(ast.parse(SOURCES[module])):
        if isinstance(node, ast.FunctionDef):
            length = sum(node.body[0].lineno <= line <= node.end_lineno for line in lines)
            assert length <= MAX_FUNCTION_LINES, f"{node.name}: {length} lines below its signature"


@MODULES
def test_the_library_does_not_print(module):
    calls = [
        node.func for node in ast.walk(ast.parse(SOURCES[module])) if isinstance(node, ast.Call)
    ]
    printing = any(isinstance(call, ast.Name) and call.id == "print" for call in calls)
    # A check in a notebook says that it is passed; nothing else does.
    assert printing == (module == "_checking")


def public_functions(source: str) -> list[ast.FunctionDef]:
    """Return the functions a reader may call: those of a module, and the methods of its classes."""
    tree = ast.parse(source)
    classes = [
        node
        for node in tree.body
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    ]
    bodies = [tree.body, *(node.body for node in classes)]
    found = [node for body in bodies for node in body if isinstance(node, ast.FunctionDef)]
    # A module may say in `__all__` which of its functions these are.
    listed = [
        ast.literal_eval(n.value)
        for n in tree.body
        if isinstance(n, ast.Assign) and ast.unparse(n.targets[0]) == "__all__"
    ]
    return [
        node
        for node in found
        if node.name in (listed[0] if listed else [node.name]) and not node.name.startswith("_")
    ]


@PUBLIC_MODULES
def test_public_functions_say_what_they_take_and_give(module):
    for function in public_functions(SOURCES[module]):
        text = ast.get_docstring(function) or ""
        where = f"the docstring of {module}.{function.name}"
        assert text, f"{where} is missing"
        arguments = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
        if [argument for argument in arguments if argument.arg != "self"]:
            assert "Parameters\n---" in text, f"{where} has no Parameters"
        a_property = any(isinstance(one, ast.Name) for one in function.decorator_list)
        nothing = isinstance(function.returns, ast.Constant) and function.returns.value is None
        if not nothing and not a_property:
            assert re.search(r"(Returns|Yields)\n---", text), f"{where} has no Returns"
        if any(isinstance(node, ast.Raise) for node in ast.walk(function)):
            assert "Raises\n---" in text, f"{where} has no Raises"


# ---- what holds for every file that is kept ----

# Put together from pieces, so that this file does not name them itself.
REGISTRIES = [
    ".".join(pieces)
    for pieces in (("pypi", "org"), ("pythonhosted", "org"), ("npmjs", "org"), ("anaconda", "org"))
]
BASE64 = re.compile(r"[A-Za-z0-9+/=]{80,}")  # the pictures in a notebook hold any letters
MACHINE_PATH = re.compile(r"(?<![\w.~}\])])/(?:home|Users|root|tmp|work|mnt)/\w|\b[A-Z]:\\{1,2}\w")


def kept_files() -> list[Path]:
    """Return the files of this project that git keeps, or would."""
    git = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    run = subprocess.run(git, capture_output=True, text=True, check=False, cwd=ROOT)
    if run.returncode:
        pytest.skip("not a git checkout")
    files = [ROOT / name for name in run.stdout.split("\0") if name]
    return [file for file in files if file.is_file() and "vendor" not in file.parts]


def test_no_file_names_a_registry_or_a_machine():
    found = []
    for file in kept_files():
        try:
            text = BASE64.sub("", file.read_text(encoding="utf-8"))
        except UnicodeDecodeError:
            continue
        found += [(file.name, host) for host in REGISTRIES if host in text]
        found += [(file.name, path.group()) for path in MACHINE_PATH.finditer(text)]
    assert found == []


@pytest.mark.parametrize("folder", ["tests/vendor", "book/_assets/vendor/mathjax"])
def test_what_is_vendored_is_unchanged(folder):
    listed = {}
    for line in (ROOT / folder / "SHA256SUMS").read_text().splitlines():
        checksum, name = line.split(maxsplit=1)
        listed[name] = checksum
    ours = {"SHA256SUMS", "README.md"}
    files = {
        path.relative_to(ROOT / folder).as_posix(): path
        for path in (ROOT / folder).rglob("*")
        if path.is_file()
    }
    assert listed == {
        name: hashlib.sha256(path.read_bytes()).hexdigest()
        for name, path in files.items()
        if name not in ours
    }
    assert any("LICENSE" in name for name in files)
