"""Is a rule spared only where it has nothing to say? `conftest` asks that of every stage that is linted;
here of what real stages seldom hold."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from pxr import Sdf, Usd

from conftest import TOO_NARROW
from usdrender_lint.model import (
    Attr,
    Layer,
    RenderPrim,
    RenderScope,
    Scene,
    Site,
    Suppressions,
    ValueState,
)
from usdrender_lint.opening import open_layer
from usdrender_lint.read import read
from usdrender_lint.read.text import Texts
from usdrender_lint.registry import all_rules
from usdrender_lint.renderers import renderer
from usdrender_lint.rule import Context, Finding, Severity, Sign, rule
from usdrender_lint.run import Rules, run, subjects_of
from usdrender_lint.signs import signs_of
from usdrender_lint.stage import open_stage

TYPES = ("RenderSettings", "RenderProduct", "RenderVar", "RenderPass", "Camera")

USUAL = {
    "RenderSettings": {
        "camera": "rel camera = </{0}/Cam>",
        "products": "rel products = </Render/{0}/P>",
        "resolution": "uniform int2 resolution = (1920, 1080)",
    },
    "RenderProduct": {
        "productName": 'token productName = "/out/{0}.exr"',
        "orderedVars": "rel orderedVars = </Render/{0}/V>",
    },
    "RenderVar": {
        "dataType": 'uniform token dataType = "color3f"',
        "sourceName": 'uniform string sourceName = "Ci"',
    },
    "RenderPass": {
        "renderSource": "rel renderSource = </Render/{0}/S>",
        "passType": 'uniform token passType = "render"',
        "command": 'uniform string[] command = ["render"]',
    },
    "Camera": {},
}
"""What a prim of each type says where all is well; {0} is the group it stands in."""

FORMS = [
    "{type} {name}",
    "{type} {name} = None",
    "{type} {name}.timeSamples = {{ 1: None }}",
    "rel {name}",
    "rel {name} = None",
    "rel {name} = </World>",
    "rel {name} = [</World.x>, </Render/{group}/S>, <.{name}>, </Render/{group}/V>]",
    "prepend rel {name} = [</Render/{group}/P>, <P>]",
    'string {name} = "C<RD>"',
    'string {name} = "lpe:C.*"',
    'string {name} = ""',
    'string {name}.timeSamples = {{ 1: "x", 2: "y" }}',
    'uniform token {name} = "lpe"',
    'uniform token {name} = "half"',
    'uniform token {name} = "no such word"',
    'custom uniform token {name} = "explicitOnly"',
    'uniform token[] {name} = ["proxy", "render", "render", ""]',
    "uniform token[] {name} = []",
    'uniform token[] {name} = ["", "allPurpose", "full", "preview", "guide"]',
    'uniform token {name} = "intrinsic"',
    'uniform token {name} = "srgb_rec709_scene"',
    'uniform token {name} = "float16"',
    "rel {name} = </Render/{group}/A>",
    "rel {name} = <Render/{group}/V>",
    "double {name} = 5",
    "double {name} = -1",
    "float {name} = 0",
    "uniform float {name} = -1.5",
    "float {name}.timeSamples = {{ 1: 0, 2: -1 }}",
    "float {name}.spline = {{ 1: 2 }}",
    "uniform bool {name} = true",
    "uniform bool {name} = false",
    "uniform bool {name}.timeSamples = {{ 1: true }}",
    "uniform int2 {name} = (0, 1)",
    "float2 {name} = (3, 2)",
    "uniform float4 {name} = (0, 0, 0.5, 1)",
    "uniform float4 {name} = (10, 10, 20, 5)",
    "asset {name} = @no.usda@",
    'uniform pathExpression {name} = "/Wurld//{{isa:Mesh}}"',
    'uniform pathExpression {name} = "World//geo"',
    'uniform string[] {name} = ["a {{b}} -c", "-d e"]',
]
"""Of a property of any name and type; most fit only some."""


def names_of(type_name: str) -> list[tuple[str, str]]:
    """The properties of a type, those of collections but once, and some that it does not have."""
    definition = Usd.SchemaRegistry().FindConcretePrimDefinition(type_name)
    found = []
    for name in definition.GetPropertyNames():
        if not name.startswith("collection:") or name.startswith("collection:renderVisibility"):
            attribute = definition.GetSchemaAttributeSpec(name)
            found.append((name, str(attribute.typeName) if attribute else "token"))
    strange = (
        "resolutoin",
        "productName",
        "dataTyp",
        "collection:none:includes",
        "denoise:enable",
        "arnold:x",
    )
    known = {name for name, _ in found}
    return [*found, *((name, "token") for name in strange if name not in known)]


GROUPS = [(kind, *named) for kind in TYPES for named in names_of(kind)]


def stage_of(form: str) -> str:
    """One group of prims for each property of each type, and in each group only that one is odd."""
    groups, cameras = "", ""
    for number, (kind, name, value_type) in enumerate(GROUPS):
        group = f"G{number}"
        odd = form.format(type=value_type, name=name, group=group)
        says = {t: {n: s.format(group) for n, s in USUAL[t].items()} for t in TYPES}
        says[kind][name] = odd
        spelt = {t: "".join(f"            {s}\n" for s in says[t].values()) for t in TYPES}
        prims = "".join(
            f'        def {t} "{p}"\n        {{\n{spelt[t]}        }}\n'
            for t, p in zip(TYPES, "SPVA", strict=False)
        )
        groups += f'    def Scope "{group}"\n    {{\n{prims}    }}\n'
        cameras += (
            f'def Scope "{group}"\n{{\n    def Camera "Cam"\n    {{\n{spelt["Camera"]}    }}\n}}\n'
        )
    return f'#usda 1.0\ndef Scope "Render"\n{{\n{groups}}}\n{cameras}'


def read_text(folder: Path, text: str) -> RenderScope:
    file = folder / "main.usda"
    file.write_text(text)
    layer = open_layer(str(file))
    assert isinstance(layer, Sdf.Layer), layer
    return read(open_stage(layer, ("/Render",)), Texts())


def parts_of(scope: RenderScope) -> Iterator[tuple[str, RenderScope]]:
    """Each group as if it stood alone."""
    for number, group in enumerate(GROUPS):
        above = f"/Render/G{number}/"
        kinds = ("settings", "products", "vars", "passes")
        own = {k: tuple(p for p in getattr(scope, k) if p.path.startswith(above)) for k in kinds}
        cameras = tuple(c for c in scope.cameras if c.path == f"/G{number}/Cam")
        yield " ".join(group[:2]), replace(scope, **own, cameras=cameras)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("signs")


@pytest.mark.parametrize("form", FORMS)
def test_a_rule_is_spared_where_it_is_silent(folder: Path, form: str) -> None:
    contexts = [Context(renderer(name)) for name in ("any", "omniverse")]
    wrong, rules = [], [r for r in all_rules().values() if r.about]
    for name, part in parts_of(read_text(folder, stage_of(form))):
        shown, subjects = signs_of(part), list(subjects_of(part))
        spared = Rules(replace(r, about=frozenset()) for r in rules if r.about.isdisjoint(shown))
        for context in contexts:
            told, crashes = run(spared, subjects, context)
            wrong += [(name, t.rule.id, t.finding.message) for t in told]
            wrong += [(name, c.rule.id, c.error) for c in crashes]
    assert wrong == [], TOO_NARROW


def test_few_rules_run_where_all_is_well(folder: Path) -> None:
    """What it is for. Should this fail, a sign is shown that is none."""
    scope = read_text(folder, stage_of("custom {type} {name}"))
    number = next(i for i, g in enumerate(GROUPS) if g[:2] == ("Camera", "arnold:x"))
    _, part = list(parts_of(scope))[number]
    assert signs_of(part) == {
        *("camera", "products", "orderedVars", "renderSource", "resolution", "productName"),
        *("dataType", "sourceName", "passType", "command", Sign.RENDER_PASS),
    }


def test_every_sign_is_spoken_of() -> None:
    spoken = {sign for one in all_rules().values() for sign in one.about}
    assert set(Sign) - spoken == set(), "no rule is about it: remove the Sign"


def test_what_is_no_sign_is_the_name_of_a_property() -> None:
    registry = Usd.SchemaRegistry()
    definitions = [registry.FindConcretePrimDefinition(kind) for kind in TYPES]
    known = {name for one in definitions for name in one.GetPropertyNames()} | {*Sign}
    strange = {name for one in all_rules().values() for name in one.about} - known
    assert strange == set(), "in `about=` stand names of properties as USD spells them, and Signs"


def test_what_tells_no_sign_is_never_spared() -> None:
    """Signs are those of the render spec."""
    beside = [
        r.id for r in all_rules().values() if r.about and r.on in (Layer, Scene, Suppressions)
    ]
    assert beside == [], "leave `about=` out: it would be asked of the render prims"


def test_a_type_of_a_plug_in_may_have_other_fallbacks(folder: Path) -> None:
    scope = read_text(
        folder, '#usda 1.0\ndef Scope "Render"\n{\n    def RenderSettings "S"\n    {\n    }\n}\n'
    )
    (usual,) = scope.settings
    purposes = Attr("includedPurposes", ("proxy", "render"), ValueState.FALLBACK, Site("/Render/S"))
    strange = replace(usual, type_name="StudioSettings", included_purposes=purposes)
    assert "includedPurposes" not in signs_of(scope)
    assert "includedPurposes" in signs_of(replace(scope, settings=(strange,)))


@rule("about-vars", on=RenderPrim, severity=Severity.NOTE, since="0.1", about=("orderedVars",))
def about_vars(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """Speaks wherever it is asked."""
    yield Finding(prim, prim.path)


@pytest.mark.parametrize("line", ["rel orderedVars = </Render/P>", ""])
def test_a_rule_runs_where_its_signs_are_shown(folder: Path, line: str) -> None:
    scope = read_text(
        folder,
        f'#usda 1.0\ndef Scope "Render"\n{{\n    def RenderProduct "P"\n    {{\n        {line}\n    }}\n}}\n',
    )
    told, _ = run(Rules([about_vars]), subjects_of(scope), Context(renderer("any")))
    assert [t.finding.message for t in told] == (["/Render/P"] if line else [])


@pytest.mark.parametrize(
    ("prim", "rule_id", "sign"),
    [
        ("over RenderVar", "dangling-over", Sign.OVER),
        ("def RenderDenoisePass", "removed-schema", Sign.OTHER_PRIM),
    ],
)
def test_one_of_its_signs_is_enough(folder: Path, prim: str, rule_id: str, sign: Sign) -> None:
    """Of those that mostly show together."""
    scope = read_text(
        folder, f'#usda 1.0\ndef Scope "Render"\n{{\n    {prim} "P"\n    {{\n    }}\n}}\n'
    )
    spoken_of = all_rules()[rule_id]
    assert signs_of(scope) & spoken_of.about == {sign}
    told, _ = run(Rules([spoken_of]), subjects_of(scope), Context(renderer("any")))
    assert len(told) == 1


def test_without_a_scope_to_tell_all_rules_run(folder: Path) -> None:
    scope = read_text(
        folder, '#usda 1.0\ndef Scope "Render"\n{\n    def RenderProduct "P"\n    {\n    }\n}\n'
    )
    told, _ = run(Rules([about_vars]), scope.products, Context(renderer("any")))
    assert [t.finding.message for t in told] == ["/Render/P"]
