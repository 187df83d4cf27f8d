"""Who may import whom. Read from the source, so that no import has to happen to be judged."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from conftest import ROOT

PACKAGE = "usdrender_lint"
SOURCE = ROOT / "src" / PACKAGE

OUTSIDE = {
    "pxr": (
        "processes.ready",
        "diagnostics",
        "opening",
        "sublayers",
        "stage",
        "sites",
        "reach",
        "locate",
        "concerns",
        "ignores",
        "lint_file",
        "read",
        "read.*",
    ),
    "click": ("endings", "cli", "options"),
    "packaging": ("config.keys", "config.read"),
    "rich": ("report.explain",),
    "markdown_it": ("report.explain",),
}
"""Everything that is not the standard library, and the modules that know it."""

LAYERS = (
    ("__main__",),
    ("endings",),
    ("cli",),
    ("options", "answers"),
    ("plan", "baselines"),
    ("wanted",),
    ("formats", "console", "progress"),
    ("testing",),
    ("processes.workers",),
    ("processes.headstart",),
    ("processes.worker",),
    ("processes.ready",),
    ("lint",),
    ("lint_file", "ignores", "variants"),
    ("job", "merge"),
    ("report", "report.*", "output"),
    ("run", "signs", "settle", "locate", "concerns", "suppress", "baseline"),
    ("read", "read.*"),
    ("context",),
    ("uses",),
    (
        "diagnostics",
        "opening",
        "refusal",
        "heads",
        "unopened",
        "sublayers",
        "stage",
        "packages",
        "torn",
        "sites",
        "reach",
        "discover",
        "crate",
        "usda",
        "usda.*",
        "renderers",
        "registry",
        "pages",
        "config",
        "config.*",
        "gitignore",
        "patterns",
        "processes.machine",
        "processes.frames",
        "processes.copies",
        "processes.stem",
        "processes.aside",
    ),
    ("results", "likeness", "rules", "rules.*", "lpe", "lpe.*"),
    ("rule",),
    ("model", "printable", "handed"),
    ("records", "lazily", "whole"),
)
"""From the top; a module imports from its own line and from those below."""


@dataclass(frozen=True)
class Import:
    by: str
    """Module of the package, without the package's name; `""` is the package itself."""
    name: str
    """The same for a module of the package, else the name of the package outside."""
    inside: bool
    """Of this package."""
    at_once: bool
    """When the module is imported, not when a function runs."""
    line: int

    def __str__(self) -> str:
        return f"{self.by}:{self.line} imports {self.name}"


def module_of(file: Path) -> str:
    parts = file.relative_to(SOURCE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


FILES = {module_of(file): file for file in sorted(SOURCE.rglob("*.py"))}


@cache
def tree_of(module: str) -> ast.Module:
    return ast.parse(FILES[module].read_text("utf-8"))


def imports_of(module: str) -> Iterator[Import]:
    tree = tree_of(module)
    late = {
        id(node)
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef)
        for node in ast.walk(function)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            for name, inside in names_in(module, node):
                yield Import(module, name, inside, id(node) not in late, node.lineno)


def names_in(module: str, node: ast.Import | ast.ImportFrom) -> Iterator[tuple[str, bool]]:
    if isinstance(node, ast.Import):
        names = [alias.name for alias in node.names]
    elif not node.level:
        names = [node.module or ""]
    else:
        is_package = FILES[module].name == "__init__.py"
        here = module.split(".") if module else []
        above = here[: len(here) - node.level + is_package]
        base = ".".join([*above, node.module] if node.module else above)
        for alias in node.names:
            below = f"{base}.{alias.name}" if base else alias.name
            yield (below if below in FILES else base), True
        return
    for name in names:
        top, _, rest = name.partition(".")
        if top == PACKAGE:
            yield rest, True
        elif top not in sys.stdlib_module_names:
            yield top, False


IMPORTS = [found for module in FILES for found in imports_of(module)]


def matches(module: str, patterns: tuple[str, ...]) -> bool:
    return any(fnmatchcase(module, pattern) for pattern in patterns)


def layer_of(module: str) -> int | None:
    return next((n for n, patterns in enumerate(LAYERS) if matches(module, patterns)), None)


def test_the_imports_are_seen() -> None:
    """Every other test here passes when nothing is."""
    seen = {(i.by, i.name, i.inside, i.at_once) for i in IMPORTS}
    assert ("stage", "pxr", False, True) in seen
    assert ("report.explain", "rich", False, False) in seen
    assert ("cli", "lint", True, True) in seen
    assert ("lint", "lint_file", True, False) in seen
    assert ("rules.camera", "rules._words", True, True) in seen
    assert ("read", "read.arcs", True, True) in seen
    assert ("read.arcs", "stage", True, True) in seen
    assert ("registry", "rules", True, True) in seen
    assert ("cli", "", True, True) in seen


def test_each_package_outside_is_known_to_few() -> None:
    """So what parses, opens, asks or paints can be replaced in one place."""
    strange = [
        str(i) for i in IMPORTS if not i.inside and not matches(i.by, OUTSIDE.get(i.name, ()))
    ]
    assert strange == []


def test_rules_know_the_model_and_nothing_else() -> None:
    """No file, line, color or output format, and no USD; names are compared everywhere alike."""
    allowed = ("model", "rule", "likeness", "records", "lazily", "lpe", "lpe.*", "rules._*")
    strange = [
        str(i)
        for i in IMPORTS
        if i.by.startswith("rules.") and not (i.inside and matches(i.name, allowed))
    ]
    assert strange == []


@pytest.mark.parametrize("module", ["model", "rule", "results", "run", "signs", "settle"])
def test_what_rules_and_reports_share_knows_no_file_and_no_usd(module: str) -> None:
    allowed = {"model", "records", "rule", "run", "signs"}
    strange = {i.name for i in IMPORTS if i.by == module} - allowed
    assert strange == set()


def test_reports_are_made_of_the_report() -> None:
    # SARIF tells where in a package a layer stands.
    near = ("results", "rule", "records", "pages", "printable", "handed", "packages")
    allowed = (*near, "report", "report.*")
    strange = [
        str(i)
        for i in IMPORTS
        if i.by.startswith("report") and i.inside and not matches(i.name, allowed)
    ]
    assert strange == []


def test_only_the_registry_knows_which_rules_there_are() -> None:
    """Adding a rule touches no list."""
    strange = [
        str(i)
        for i in IMPORTS
        if i.inside
        and matches(i.name, ("rules", "rules.*"))
        and i.by != "registry"
        and not i.by.startswith("rules.")
    ]
    assert strange == []


def test_imports_go_one_way() -> None:
    strange = []
    for found in IMPORTS:
        if found.inside:
            upper, lower = layer_of(found.by), layer_of(found.name)
            if upper is not None and lower is not None and lower < upper:
                strange.append(str(found))
    assert strange == []


def test_imports_go_in_no_circle() -> None:
    """Nor do those within functions."""
    graph: dict[str, set[str]] = {}
    for found in IMPORTS:
        # The package itself holds only the version.
        if found.inside and found.name not in ("", found.by):
            graph.setdefault(found.by, set()).add(found.name)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


def test_nothing_heavy_comes_with_the_command_line() -> None:
    """`--help` and a misspelt option are answered without USD and rich."""
    seen, waiting = set[str](), ["__main__", "endings", "registry", *rules_modules()]
    heavy = []
    while waiting:
        module = waiting.pop()
        if module in seen:
            continue
        seen.add(module)
        for found in imports_of(module):
            if found.inside and found.at_once:
                assert found.name in FILES, f"{found}, which is not there"
                waiting.append(found.name)
            elif found.name in ("pxr", "rich", "markdown_it") and found.at_once:
                heavy.append(str(found))
    assert heavy == []


def test_no_rule_is_told_what_it_never_asks() -> None:
    """Whatever is in the model is read from every stage."""
    asked = {n.attr for m in FILES for n in ast.walk(tree_of(m)) if isinstance(n, ast.Attribute)}
    by_name = {"Evidence"}  # by the names of what tells of a renderer, in its TOML file
    idle = [
        f"{kind.name}.{field.target.id}"
        for module in ("model", "rule")
        for kind in tree_of(module).body
        if isinstance(kind, ast.ClassDef) and kind.name not in by_name
        for field in kind.body
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)
        if field.target.id not in asked
    ]
    assert idle == []


def test_what_is_answered_once_can_be_heard_twice() -> None:
    """The second rule that asks would find an iterator used up, and be silent."""
    answers = {
        f"{module}.{node.name}": ast.unparse(node.returns).partition("[")[0] if node.returns else ""
        for module in FILES
        for node in ast.walk(tree_of(module))
        if isinstance(node, ast.FunctionDef)
        and "once" in (ast.unparse(decorator) for decorator in node.decorator_list)
    }
    assert len(answers) > 2
    lasting = {"tuple", "frozenset", "str", "bool", "int", "float"}
    assert {name: kind for name, kind in answers.items() if kind not in lasting} == {}


def test_what_takes_long_to_declare_is_declared_our_way() -> None:
    """`records.dataclass` and `lazily` do at first use what takes most of a start otherwise."""
    slow = [
        f"{module}:{node.lineno}"
        for module in FILES.keys()
        - {"records", "testing"}  # rules are tested once they are written
        for node in ast.walk(tree_of(module))
        if isinstance(node, ast.ImportFrom)
        and node.module == "dataclasses"
        and any(alias.name == "dataclass" for alias in node.names)
    ]
    slow += [
        f"{module}:{call.lineno}"
        for module in FILES
        for statement in tree_of(module).body
        if not isinstance(statement, ast.FunctionDef | ast.ClassDef)
        for call in ast.walk(statement)
        if isinstance(call, ast.Call) and ast.unparse(call.func) == "re.compile"
    ]
    assert slow == []


def rules_modules() -> list[str]:
    return [module for module in FILES if module.startswith("rules.")]


def test_few_places_catch_whatever_may_happen() -> None:
    """A bug costs a rule its findings or a file its own; and none ends in the code of findings."""
    broad = {
        module
        for module in FILES
        for node in ast.walk(tree_of(module))
        if isinstance(node, ast.ExceptHandler)
        and (node.type is None or (isinstance(node.type, ast.Name) and node.type.id == "Exception"))
    }
    assert broad == {"run", "lint_file", "endings"}
