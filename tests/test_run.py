"""Do all rules see what they ask for, whatever one of them does?"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from pxr import Sdf, Usd

from usdrender_lint.job import Config
from usdrender_lint.lint import lint
from usdrender_lint.model import (
    Layer,
    Pass,
    Product,
    RenderPrim,
    RenderScope,
    Settings,
    SettingsBase,
    Site,
    Var,
)
from usdrender_lint.opening import open_layer
from usdrender_lint.read import read
from usdrender_lint.read.text import Texts
from usdrender_lint.registry import select
from usdrender_lint.renderers import renderer
from usdrender_lint.rule import Context, Finding, Severity, once, rule
from usdrender_lint.run import Rules, run, subjects_of
from usdrender_lint.stage import open_stage
from usdrender_lint.testing import BASE, HEADER, lint_files

CONTEXT = Context(renderer("any"))
LAYERS = [Layer(f"{n}.usda", Site("/", layer=f"{n}.usda"), None) for n in "ab"]

STAGE = """#usda 1.0
(
    renderSettingsPrimPath = "/Render/S"
)
def Scope "Render"
{
    def RenderSettings "S"
    {
        rel products = </Render/P>
    }
    def RenderProduct "P"
    {
    }
    def RenderVar "v"
    {
    }
    def RenderVar "off" (
        active = false
    )
    {
    }
    def RenderPass "A"
    {
    }
    over RenderPass "undefined"
    {
    }
}
"""


@rule("about-layers", on=Layer, severity=Severity.NOTE, since="0.1")
def about_layers(layer: Layer, context: Context) -> Iterator[Finding]:
    """One finding a layer."""
    yield Finding(layer, f"{layer.path} for {context.renderer.name}")


@rule("falls-over", on=Layer, severity=Severity.NOTE, since="0.1")
def falls_over(layer: Layer, context: Context) -> Iterator[Finding]:
    """Raises on one layer, after a finding."""
    yield Finding(layer, f"{layer.path} before")
    if layer.path == "a.usda":
        raise KeyError("nothing of that name")
    yield Finding(layer, f"{layer.path} after")


@pytest.fixture
def main(tmp_path: Path) -> Path:
    file = tmp_path / "main.usda"
    file.write_text(STAGE)
    return file


@pytest.fixture
def scope(main: Path) -> RenderScope:
    layer = open_layer(str(main))
    assert isinstance(layer, Sdf.Layer)
    return read(open_stage(layer, ("/Render",)), Texts())


def messages(*rules: object) -> tuple[list[str], list[str]]:
    told, crashes = run(Rules(rules), LAYERS, CONTEXT)  # type: ignore[arg-type]
    return [t.finding.message for t in told], [
        f"{c.rule.id} {c.subject} {c.error}" for c in crashes
    ]


def test_each_rule_sees_each_subject_and_the_context() -> None:
    assert messages(about_layers) == (["a.usda for any", "b.usda for any"], [])


def test_a_rule_that_raises_is_a_crash_and_the_others_run() -> None:
    said, crashes = messages(falls_over, about_layers)
    assert crashes == ["falls-over a.usda KeyError: 'nothing of that name'"]
    assert said == [
        "a.usda before",
        "b.usda before",
        "b.usda after",
        "a.usda for any",
        "b.usda for any",
    ]


def test_a_rule_that_raises_at_once_is_a_crash_too() -> None:
    def at_once(layer: Layer, context: Context) -> Iterator[Finding]:
        raise ValueError(layer.path)

    said, crashes = messages(replace(about_layers, check=at_once))
    assert (said, len(crashes)) == ([], 2)


def test_what_rules_ask_is_answered_once_for_each_subject() -> None:
    asked = []

    @once
    def name_of(layer: Layer, context: Context) -> str:
        asked.append(layer.path)
        return layer.path

    @once
    def length_of(layer: Layer, context: Context) -> int:
        return len(layer.path)

    first, second = LAYERS
    context = Context(renderer("any"))
    answers = [name_of(one, context) for one in (first, first, second, replace(second))]
    assert answers == ["a.usda", "a.usda", "b.usda", "b.usda"]
    assert asked == ["a.usda", "b.usda", "b.usda"]  # what is equal need not be the same
    assert (length_of(second, context), name_of(second, Context(renderer("any")))) == (6, "b.usda")
    assert len(asked) == 4


def test_an_interrupt_is_no_crash() -> None:
    def interrupted(layer: Layer, context: Context) -> Iterator[Finding]:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        messages(replace(about_layers, check=interrupted))


def test_a_crash_on_the_scope_names_its_root(scope: RenderScope) -> None:
    @rule("on-scope", on=RenderScope, severity=Severity.NOTE, since="0.1")
    def on_scope(scope: RenderScope, context: Context) -> Iterator[Finding]:
        yield from ()
        raise RuntimeError

    _, (crash,) = run(Rules([on_scope]), subjects_of(scope), CONTEXT)
    assert Path(crash.subject).name == "main.usda"


@pytest.mark.parametrize(
    ("on", "paths"),
    [
        (Settings, ["/Render/S"]),
        (Product, ["/Render/P"]),
        (Var, ["/Render/v"]),
        (Pass, ["/Render/A"]),
        (SettingsBase, ["/Render/S", "/Render/P"]),
        (RenderPrim, ["/Render/S", "/Render/P", "/Render/v", "/Render/A"]),
        (Layer, []),
    ],
)
def test_a_rule_sees_the_live_prims_of_its_kind(
    scope: RenderScope, on: type[RenderPrim], paths: list[str]
) -> None:
    @rule("seen", on=on, severity=Severity.NOTE, since="0.1")
    def seen(prim: RenderPrim, context: Context) -> Iterator[Finding]:
        yield Finding(prim, prim.path)

    told, crashes = run(Rules([seen]), subjects_of(scope), CONTEXT)
    assert [t.finding.message for t in told] == paths
    assert crashes == []


def test_a_rule_on_the_scope_sees_all_of_it_once(scope: RenderScope) -> None:
    @rule("seen", on=RenderScope, severity=Severity.NOTE, since="0.1")
    def seen(scope: RenderScope, context: Context) -> Iterator[Finding]:
        yield Finding(scope, f"{len(scope.vars)} vars")

    told, _ = run(Rules([seen]), subjects_of(scope), CONTEXT)
    assert [t.finding.message for t in told] == ["2 vars"]


def test_each_stage_has_the_rules_that_speak_of_it(scope: RenderScope) -> None:
    """Also if the same rules judged another one before."""

    @rule("passing", on=RenderScope, severity=Severity.NOTE, since="0.1", about=("products",))
    def passing(scope: RenderScope, context: Context) -> Iterator[Finding]:
        yield Finding(scope, "it names products")

    bare = replace(scope, settings=())
    rules = Rules([passing])
    told = [len(run(rules, subjects_of(s), CONTEXT)[0]) for s in (scope, bare, scope, bare)]
    assert told == [1, 0, 1, 0]


def test_a_crash_makes_the_report_incomplete_and_costs_no_finding(main: Path) -> None:
    @rule("product-without-vars", on=Product, severity=Severity.ERROR, since="0.1")
    def broken(product: Product, context: Context) -> Iterator[Finding]:
        yield from ()
        raise RuntimeError("out of luck")

    whole = select(["product-without-vars", "missing-render-source"])
    rules = tuple(broken if r.id == broken.id else r for r in whole.run)
    config = Config(replace(whole, run=rules))
    report = lint([str(main)], config, cwd=main.parent)
    (problem,) = report.problems
    assert (problem.kind, problem.path, problem.rule) == ("crashed-rule", "main.usda", broken.id)
    assert "out of luck" in problem.message
    assert "/Render/P" in problem.message
    assert not report.complete
    assert [f.rule.id for f in report.findings] == ["missing-render-source"]


OVERRIDES = {
    "RenderSettings": ("Render", "Primary"),
    "RenderProduct": ("Render", "Beauty"),
    "RenderVar": ("Render", "Vars", "color"),
    "RenderPass": ("Render", "Pass"),
    "Camera": ("World", "main_cam"),
}
FORMS = [
    "{type} {name}",
    "{type} {name} = None",
    "{type} {name} = AnimationBlock",
    "{type} {name}.timeSamples = {{ 1: None }}",
    "{type} {name}.connect = </World.x>",
    "rel {name}",
    "rel {name} = None",
    "rel {name} = </World>",
    "rel {name} = [</World.x>, </World/sets>, </Render.collection:x>, <.{name}>]",
    'string {name} = "x"',
    'string {name} = ""',
    'string {name}.timeSamples = {{ 1: "x" }}',
    'token {name} = "x"',
    'token[] {name} = ["a", "a", ""]',
    "token[] {name} = []",
    "int {name} = -3",
    "int64 {name} = -9223372036854775808",
    "bool {name} = true",
    "double {name} = nan",
    "double {name}.timeSamples = {{ 1: nan, 2: inf }}",
    "float {name}.spline = {{ 1: 2 }}",
    "double3 {name} = (1, 2, 3)",
    "int2[] {name} = []",
    "asset {name} = @x.usda@",
    "asset {name} = @@",
    'pathExpression {name} = "//"',
    "opaque {name}",
]


@pytest.mark.parametrize("type_name", OVERRIDES)
@pytest.mark.parametrize("form", FORMS)
def test_no_rule_raises_whatever_is_authored(type_name: str, form: str) -> None:
    """All properties of a type at once, in a form that may or may not be theirs."""
    definition = Usd.SchemaRegistry().FindConcretePrimDefinition(type_name)
    statements = ""
    for name in definition.GetPropertyNames():
        attribute = definition.GetSchemaAttributeSpec(name)
        value_type = attribute.typeName if attribute else "token"
        statements += f"        {form.format(type=value_type, name=name)}\n"
    prims = OVERRIDES[type_name]
    opening = "".join(f'over "{prim}"\n{{\n' for prim in prims)
    one_more = '    def RenderPass "Pass"\n    {\n    }\n    def Scope "Vars"'
    files = {
        "main.usda": f"{HEADER}{opening}{statements}" + "}\n" * len(prims),
        "base.usda": BASE.replace('    def Scope "Vars"', one_more),
    }
    report, found = lint_files(files, rules=["ALL"])
    assert [p.message for p in report.problems] == []
    assert "syntax-error" not in {mark.rule for mark in found}
