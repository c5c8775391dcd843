"""The arrows of the design, held by reading the imports of the package."""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import bematist

PACKAGE = Path(bematist.__file__).parent
MODULES = {
    ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__"): path
    for path in sorted(PACKAGE.rglob("*.py"))
}

DATA_TYPES = {"recording", "trajectory", "attitudes", "frames", "units", "earth", "errors"}
ESTIMATORS = {"ahrs", "foot", "hand", "methods", "align", "stance", "steps", "updates", "smooth"}
SHOWING = {"report", "reproduce", "cli"}
TOP = {"cli", "reproduce"}
FORBIDDEN = {
    "evo": "GPL-3",
    "allantools": "LGPL",
    "obspy": "LGPL",
    "ahrs": "a peer for tests",
    "vqf": "a peer for tests",
    "imufusion": "a peer for tests",
    "pandas": "slow to import, and not needed",
}
LONGEST = 400


def room(module: str) -> str:
    """The room of a module: bematist.io.table → io; the package itself → ""."""
    return module.split(".")[1] if "." in module else ""


def imports(source: str, module: str, *, is_package: bool = False, top_level: bool = False, typing_too: bool = True) -> Iterator[str]:
    """Full names of the modules that a source imports; relative ones resolved, `from a import b` as a and a.b."""
    for node in _walk(ast.parse(source), top_level=top_level, typing_too=typing_too):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parts = module.split(".")
            here = parts if is_package else parts[:-1]
            base = here[: len(here) - node.level + 1] if node.level else []
            name = ".".join([*base, *([node.module] if node.module else [])])
            yield name
            yield from (f"{name}.{alias.name}" for alias in node.names)


def _walk(node: ast.AST, *, top_level: bool, typing_too: bool) -> Iterator[ast.AST]:
    for child in ast.iter_child_nodes(node):
        if top_level and isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        if not typing_too and isinstance(child, ast.If) and "TYPE_CHECKING" in ast.dump(child.test):
            continue
        yield child
        yield from _walk(child, top_level=top_level, typing_too=typing_too)


def imported(module: str, **options: bool) -> set[str]:
    path = MODULES[module]
    return set(imports(path.read_text("utf-8"), module, is_package=path.name == "__init__.py", **options))


def ours(module: str, **options: bool) -> set[str]:
    """Modules of the package that a module imports (names within modules left out)."""
    return {name for name in imported(module, **options) if name in MODULES}


def rooms_used(module: str) -> set[str]:
    """Rooms that a module imports, its own and the package itself (`from bematist import __version__`) left out."""
    return {room(name) for name in ours(module)} - {room(module), ""}


@pytest.mark.parametrize("module", [m for m in MODULES if room(m) == "kernels"])
def test_kernels_import_nothing_of_ours(module: str) -> None:
    assert not rooms_used(module)


@pytest.mark.parametrize("module", [m for m in MODULES if room(m) in DATA_TYPES])
def test_data_types_know_no_estimator_and_no_command(module: str) -> None:
    allowed = {"report"} if module in ("bematist.trajectory", "bematist.attitudes") else set()  # `trajectory.report()` is a contract
    assert not rooms_used(module) & (ESTIMATORS | SHOWING | {"io", "evaluate", "simulate"}) - allowed


@pytest.mark.parametrize("module", [m for m in MODULES if room(m) not in {*TOP, "__main__"}])
def test_nobody_imports_the_command_line(module: str) -> None:
    assert not rooms_used(module) & TOP


@pytest.mark.parametrize("module", [m for m in MODULES if room(m) in ESTIMATORS | {"evaluate", "simulate"}])
def test_estimators_neither_read_nor_show(module: str) -> None:
    assert not rooms_used(module) & (SHOWING | {"io", "outputs"})


@pytest.mark.parametrize("module", [m for m in MODULES if room(m) == "io"])
def test_readers_know_no_estimator(module: str) -> None:
    assert not rooms_used(module) & (ESTIMATORS | SHOWING)


@pytest.mark.parametrize("module", MODULES)
def test_no_peer_is_imported(module: str) -> None:
    found = {name.split(".")[0] for name in imported(module)} & set(FORBIDDEN)
    assert not found, {name: FORBIDDEN[name] for name in found}


@pytest.mark.parametrize("module", MODULES)
def test_modules_are_short(module: str) -> None:
    assert len(MODULES[module].read_text("utf-8").splitlines()) < LONGEST


def needed_at_import(module: str) -> set[str]:
    found = ours(module, top_level=True, typing_too=False) - {module}
    # `from package import submodule` needs the submodule; the package's own name comes with every import of its parts.
    return {name for name in found if not module.startswith(f"{name}.")}


def cycle(graph: dict[str, set[str]]) -> list[str]:
    """A cycle of a graph, or nothing."""
    done: set[str] = set()

    def visit(node: str, path: list[str]) -> list[str]:
        if node in path:
            return [*path[path.index(node) :], node]
        if node in done:
            return []
        for after in sorted(graph[node]):
            if found := visit(after, [*path, node]):
                return found
        done.add(node)
        return []

    return next((found for node in sorted(graph) if (found := visit(node, []))), [])


def test_no_module_needs_itself() -> None:
    assert not cycle({module: needed_at_import(module) for module in MODULES})


def test_the_package_holds_the_rooms() -> None:
    assert {room(m) for m in MODULES} >= DATA_TYPES | {"cli", "evaluate", "foot", "io", "kernels", "methods", "report"}


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("import bematist.foot", "bematist.foot"),
        ("from bematist import foot", "bematist.foot"),
        ("from .. import foot", "bematist.foot"),
        ("from ..foot import FootIns", "bematist.foot"),
        ("def f():\n    from bematist.foot import FootIns", "bematist.foot"),
        ("if x:\n    import evo.core", "evo.core"),
    ],
)
def test_the_check_sees_every_form_of_import(line: str, found: str) -> None:
    assert found in set(imports(line, "bematist.io.table"))


def test_the_check_can_fail() -> None:
    assert cycle({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == ["a", "b", "c", "a"]
    inside = "def f():\n    import bematist.cli"
    assert "bematist.cli" not in set(imports(inside, "bematist.foot", top_level=True))
    guarded = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import bematist.cli"
    assert "bematist.cli" not in set(imports(guarded, "bematist.foot", typing_too=False))


HEAVY = {"numpy", "numba", "polars", "pydantic", "scipy", "plotly", "matplotlib", "rich.table", "pymap3d"}


def test_help_imports_nothing_heavy() -> None:
    """The command line without a command must answer at once."""
    import subprocess

    code = "import sys, bematist.cli; print('\\n'.join(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "bematist.cli" in loaded
    assert not HEAVY & set(loaded)
