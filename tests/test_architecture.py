"""The tree keeps its shape: imports go one way, rooms have names, public names are told of."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

import touchwarp as tw

CHECKOUT = Path(__file__).resolve().parent.parent
PACKAGE = CHECKOUT / "src" / "touchwarp"
SOURCES = sorted(PACKAGE.rglob("*.py"))
IN_ROOMS = [
    path for path in SOURCES if path not in (PACKAGE / "__init__.py", PACKAGE / "__main__.py")
]

# A room may import from itself and from what stands before it.
FLOW = (
    "errors",
    "outputs",
    "scene",
    "scan",
    "goals",
    "solve",
    "warp",
    "hand",
    "check",
    "export",
    "live",
    "cli",
)
NAMELESS = {"util", "utils", "common", "core", "misc", "helper", "helpers"}
IMPORT_NAMES = {
    "fast-simplification": "fast_simplification",
    "libigl": "igl",
    "pypng": "png",
    "python-fcl": "fcl",
}
UNSEEN = {"lxml", "networkx", "websockets"}  # imported by trimesh and uvicorn, not by us


def room_of(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported_modules(source: str) -> Iterator[str]:
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "relative imports hide the room"
            module = node.module or ""
            yield from (f"{module}.{alias.name}" for alias in node.names)


def backward_imports(room: str, source: str) -> list[str]:
    """The imports in `source`, a file of `room`, that go against the flow."""
    backward = []
    for module in imported_modules(source):
        package, _, rest = module.partition(".")
        if package != "touchwarp":
            continue
        target = rest.split(".")[0]
        if target in FLOW:
            against = FLOW.index(target) > FLOW.index(room)
        else:
            against = room != "cli"  # the public names, which only the command line may use
        if against:
            backward.append(module)
    return backward


@pytest.mark.parametrize("path", IN_ROOMS, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_follow_the_flow(path: Path) -> None:
    assert backward_imports(room_of(path), path.read_text()) == []


@pytest.mark.parametrize(
    ("room", "source"),
    [
        ("scene", "from touchwarp.goals import Goal"),
        ("solve", "import touchwarp.warp.file"),
        ("warp", "def f():\n    from touchwarp.check import check"),
        ("check", "from touchwarp import load_warp"),
    ],
)
def test_the_flow_rejects_a_backward_import(room: str, source: str) -> None:
    assert len(backward_imports(room, source)) == 1


def untyped_functions(source: str) -> list[str]:
    """The functions in `source` that lack an annotation, those compiled by numba aside."""

    def search(node: ast.AST) -> Iterator[str]:
        if isinstance(node, ast.FunctionDef):
            if any("njit" in ast.unparse(decorator) for decorator in node.decorator_list):
                return
            given = node.args
            every = [*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg]
            missing = [a.arg for a in every if a is not None and a.annotation is None]
            if set(missing) - {"self", "cls"} or node.returns is None:
                yield node.name
        for child in ast.iter_child_nodes(node):
            yield from search(child)

    return list(search(ast.parse(source)))


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_functions_are_typed_unless_compiled(path: Path) -> None:
    assert untyped_functions(path.read_text()) == []


def test_a_missing_annotation_is_found() -> None:
    source = (
        "@njit(cache=True)\ndef kernel(x):\n    return x\n"
        "class A:\n    def good(self, x: int) -> int: ...\n    def bad(self, x) -> int: ...\n"
        "def worse(x: int): ...\n"
    )
    assert untyped_functions(source) == ["bad", "worse"]


def test_rooms_have_names() -> None:
    inside = [path.relative_to(PACKAGE).with_suffix("") for path in SOURCES]
    assert [path for path in inside if {*path.parts} & NAMELESS] == []
    assert {room_of(path) for path in SOURCES} <= {*FLOW, "__init__", "__main__"}


def test_no_file_is_over_400_lines() -> None:
    folders = ("src", "tests", "benchmarks", "examples", "docs", ".ci")
    files = [
        path
        for folder in folders
        for path in (CHECKOUT / folder).rglob("*.py")
        if ".venv" not in path.parts
    ]
    assert len(files) > len(SOURCES)
    long = {str(path.relative_to(CHECKOUT)): len(path.read_text().splitlines()) for path in files}
    assert {name: lines for name, lines in long.items() if lines > 400} == {}


def test_every_public_name_can_be_loaded_and_tells_what_it_is() -> None:
    for name in tw.__all__:
        value = getattr(tw, name)
        assert not isinstance(value, type(sys)), f"tw.{name} is a module"
        assert name == "__version__" or (value.__doc__ or "").strip(), f"tw.{name} has no docstring"


def test_type_checkers_see_the_names_that_run_time_finds() -> None:
    tree = ast.parse((PACKAGE / "__init__.py").read_text())
    (block,) = [node for node in tree.body if isinstance(node, ast.If)]
    typed = {
        alias.name: node.module.removeprefix("touchwarp.")
        for node in block.body
        if isinstance(node, ast.ImportFrom) and node.module
        for alias in node.names
    }
    assert typed == tw._ROOM_OF
    assert {*tw.__all__} == {*typed, "__version__"}


def test_the_docs_tell_every_public_name() -> None:
    text = (CHECKOUT / "docs" / "python.md").read_text()
    untold = [n for n in tw.__all__ if n != "__version__" and not re.search(rf"`tw\.{n}\b", text)]
    assert untold == []


@pytest.mark.parametrize(
    "first", ["touchwarp.solve", "touchwarp.goals", "touchwarp.check", "touchwarp.warp"]
)
def test_rooms_do_not_hide_the_functions_of_their_name(first: str) -> None:
    script = (
        f"import {first}; import touchwarp as tw; "
        "assert all(callable(f) for f in (tw.solve, tw.goals, tw.check))"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'touchwarp' has no attribute 'sole'"):
        _ = tw.sole  # type: ignore[attr-defined]


def test_import_and_help_load_no_numerics() -> None:
    script = (
        "import sys, touchwarp.cli.main; "
        "print(sorted({'numpy', 'numba', 'scipy', 'trimesh', 'rich'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], check=True, capture_output=True, text=True
    )
    assert done.stdout.strip() == "[]"


def test_dependencies_are_declared_used_and_explained() -> None:
    project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text())["project"]
    declared = {re.split(r"[<>=~!\[; ]", line)[0] for line in project["dependencies"]}
    imported = {module.split(".")[0] for p in SOURCES for module in imported_modules(p.read_text())}
    foreign = imported - set(sys.stdlib_module_names) - {"touchwarp"}
    assert foreign == {IMPORT_NAMES.get(name, name) for name in declared - UNSEEN}
    explained = (CHECKOUT / "docs" / "dependencies.md").read_text()
    assert [name for name in declared if f"| {name} |" not in explained] == []
