"""Rules that need the whole stage run when asked for, and never cost a run that did not ask."""

from __future__ import annotations

from pathlib import Path

import pytest
from pxr import Sdf, Usd

from conftest import ROOT
from usdrender_lint import stage
from usdrender_lint.job import Config
from usdrender_lint.lint import lint
from usdrender_lint.read import scene
from usdrender_lint.registry import all_rules, select
from usdrender_lint.results import Report

FIXTURES = sorted((ROOT / "fixtures").glob("[bc]*/*.usda"))
STAGE = """\
#usda 1.0
(
    renderSettingsPrimPath = "/Render/S"
)
def Scope "Render"
{
    def RenderSettings "S"
    {
        rel camera = </World/cam>
        rel products = </Render/P>
        uniform token[] includedPurposes = ["default"]
        uniform token[] materialBindingPurposes = ["preview", ""]
    }
    def RenderProduct "P"
    {
        token productName = "/out/x.exr"
        rel orderedVars = [</Render/v>, </Render/id>]
    }
    def RenderVar "v"
    {
        uniform string sourceName = "Ci"
    }
    def RenderVar "id"
    {
        uniform token dataType = "int"
        uniform string sourceName = "object_id"
        uniform token sourceType = "primvar"
    }
    def RenderPass "chars"
    {
        rel renderSource = </Render/S>
        uniform bool collection:renderVisibility:includeRoot = false
        rel collection:renderVisibility:includes = </World/char>
    }
}
def Xform "World"
{
    def Camera "cam"
    {
    }
    def Xform "char" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {
        uniform token purpose = "render"
        rel material:binding:full = </World/mtl>
        def Sphere "head"
        {
        }
        def Sphere "body"
        {
        }
    }
    def Material "mtl"
    {
    }
    def DistantLight "sun"
    {
    }
}
"""

SCENE_RULES = sorted(r.id for r in all_rules().values() if r.needs_scene)


def lint_text(folder: Path, text: str, *rules: str, scene: bool = False) -> Report:
    file = folder / "main.usda"
    file.write_text(text, "utf-8")
    selection = select(rules or ("default",), scene=scene)
    return lint([str(file)], Config(selection), cwd=folder)


def messages(report: Report) -> dict[str, str]:
    return {f.rule.id: f.message for f in report.findings}


def test_by_default_they_are_skipped_and_that_is_said(tmp_path: Path) -> None:
    report = lint_text(tmp_path, STAGE)
    assert not set(messages(report)).intersection(SCENE_RULES)
    assert "lights-hidden-by-pass" in {s.rule for s in report.skipped}


def test_a_group_does_not_open_the_whole_stage(tmp_path: Path) -> None:
    report = lint_text(tmp_path, STAGE, "purpose")
    assert {s.rule for s in report.skipped} == {"hidden-render-geometry", "unshaded-by-purpose"}


def test_with_scene_all_of_them_run(tmp_path: Path) -> None:
    report = lint_text(tmp_path, STAGE, scene=True)
    found = messages(report)
    assert report.skipped == ()
    assert "2 gprims of purpose 'render'" in found["hidden-render-geometry"]
    assert "2 gprims will be unshaded" in found["unshaded-by-purpose"]
    assert "'object_id'" in found["unknown-primvar"]
    assert "none of the scene's lights" in found["lights-hidden-by-pass"]


@pytest.mark.parametrize("rule", SCENE_RULES)
def test_a_named_rule_runs_without_the_flag(rule: str, tmp_path: Path) -> None:
    report = lint_text(tmp_path, STAGE, rule)
    assert [r.id for r in report.rules if r.needs_scene] == [rule]


def test_what_is_right_is_met_with_silence(tmp_path: Path) -> None:
    right = (
        STAGE.replace('["default"]', '["default", "render"]')
        .replace('["preview", ""]', '["full", ""]')
        .replace("includes = </World/char>", "includes = [</World/char>, </World/sun>]")
        .replace(
            'def Sphere "head"\n        {\n',
            'def Sphere "head"\n        {\n            int primvars:object_id = 1\n',
        )
    )
    report = lint_text(tmp_path, right, *SCENE_RULES)
    assert messages(report) == {}


def test_a_binding_for_all_purposes_is_what_everybody_falls_back_on(tmp_path: Path) -> None:
    text = STAGE.replace("material:binding:full", "material:binding")
    assert messages(lint_text(tmp_path, text, "unshaded-by-purpose")) == {}


def test_a_material_for_each_purpose_asked_for_may_come_from_further_up(tmp_path: Path) -> None:
    inside = 'def Sphere "head"\n        {\n'
    text = STAGE.replace(
        inside, f"{inside}            rel material:binding:preview = </World/mtl>\n"
    )
    found = messages(lint_text(tmp_path, text, "unshaded-by-purpose"))
    assert "1 gprim will be unshaded" in found["unshaded-by-purpose"]


@pytest.mark.parametrize("name", ["full:collection", "collection", "collection:full:chars"])
def test_what_does_not_bind_a_material_for_a_purpose_is_no_binding(
    name: str, tmp_path: Path
) -> None:
    text = STAGE.replace("material:binding:full", f"material:binding:{name}")
    assert messages(lint_text(tmp_path, text, "unshaded-by-purpose")) == {}


HEAD = 'def Sphere "head"\n        {\n'
VALUE = "            int primvars:object_id = 1\n"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (HEAD, HEAD + "            # primvars:object_id\n"),
        (HEAD, HEAD + '            string note = "primvars:object_id"\n'),
        (HEAD, HEAD + VALUE.replace("_id", "_ids")),
        (HEAD, HEAD + VALUE.replace(" = 1", "")),
        (HEAD, HEAD + VALUE.replace("1", "None")),
        (HEAD, HEAD.replace("\n", " (\n            active = false\n        )\n", 1) + VALUE),
        ('def Material "mtl"\n    {\n', f'class "mtl"\n    {{\n{VALUE}'),
    ],
)
def test_a_primvar_that_is_only_spoken_of(tmp_path: Path, before: str, after: str) -> None:
    assert before in STAGE
    found = messages(lint_text(tmp_path, STAGE.replace(before, after), "unknown-primvar"))
    assert found == {"unknown-primvar": "no prim of the scene has a primvar 'object_id'"}


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (HEAD, HEAD + VALUE),
        (HEAD, HEAD + VALUE.replace(" = 1", ".timeSamples = { 1: 2 }")),
        (HEAD, HEAD.replace("def Sphere", "over") + VALUE),
        ('"object_id"', '"normals"'),
        (HEAD, f'def "copy" (\n        instanceable = true\n        references = </World/one>\n    )\n    {{\n    }}\n    {HEAD}'),
    ],
)  # fmt: skip
def test_a_primvar_that_some_prim_has(tmp_path: Path, before: str, after: str) -> None:
    one = f'class "one"\n    {{\n        def Sphere "ball"\n        {{\n{VALUE}        }}\n    }}\n'
    text = STAGE.replace(before, after)
    if "</World/one>" in after:
        text = text.replace('def Camera "cam"', f'{one}    def Camera "cam"')
    assert messages(lint_text(tmp_path, text, "unknown-primvar")) == {}


def test_the_words_of_a_crate_are_unpacked_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    crate = tmp_path / "main.usdc"
    layer = Sdf.Layer.CreateAnonymous(".usda")
    assert layer.ImportFromString(STAGE)
    assert layer.Export(str(crate))
    unpacked: list[str] = []
    tokens_of = scene.tokens_of
    monkeypatch.setattr(scene, "tokens_of", lambda f: (unpacked.append(f), tokens_of(f))[1])
    report = lint([str(crate)], Config(select(SCENE_RULES)), cwd=tmp_path)
    assert {f.rule.id for f in report.findings} >= {"hidden-render-geometry", "unknown-primvar"}
    assert unpacked == [str(crate)]


def test_only_the_first_prim_of_a_type_is_asked_whether_it_is_of_the_render_spec(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    built = Usd.Stage.CreateInMemory()
    for number in range(100):
        built.DefinePrim(f"/World/ball_{number}", "Sphere")
        built.DefinePrim(f"/Render/var_{number}", "RenderVar")
    asked: list[str] = []
    kinds_of = stage.kinds_of
    monkeypatch.setattr(
        stage, "kinds_of", lambda p: (asked.append(p.GetTypeName()), kinds_of(p))[1]
    )
    assert len(stage.render_prims(stage.Opened(built, ("/Render",)))) == 100
    assert asked.count("Sphere") == 1


def test_masked_and_whole_say_the_same(tmp_path: Path) -> None:
    text = STAGE.replace("</World/cam>", "</World/camera>")
    masked = lint_text(tmp_path, text)
    whole = lint_text(tmp_path, text, scene=True)
    others = [f.identity for f in whole.findings if not f.rule.needs_scene]
    assert [f.identity for f in masked.findings] == others


@pytest.mark.parametrize("file", FIXTURES, ids=lambda f: f.name)
def test_masked_and_whole_say_the_same_of_every_fixture(file: Path) -> None:
    masked, whole = lint([str(file)]), lint([str(file)], Config(select(scene=True)))
    others = [f.identity for f in whole.findings if not f.rule.needs_scene]
    assert [f.identity for f in masked.findings] == others


def test_on_a_whole_stage_strays_are_found_among_its_prims(tmp_path: Path) -> None:
    """Also one whose type only comes near that of a render prim; and none in the scope, or that
    another asset misspells."""
    (tmp_path / "asset.usda").write_text(
        '#usda 1.0\ndef Xform "A"\n{\n    def renderVar "near"\n    {\n    }\n}\n'
    )
    text = (
        STAGE
        + 'def RenderVar "stray"\n{\n}\ndef Xform "W"\n{\n    def renderVar "near"\n    {\n    }\n}\n'
        + 'def "B" (\n    references = @./asset.usda@</A>\n)\n{\n}\n'
    )
    for whole in (False, True):
        found = [(f.rule.id, f.prim_path) for f in lint_text(tmp_path, text, scene=whole).findings]
        assert [path for rule, path in found if rule == "outside-render-scope"] == ["/stray"]
        assert [path for rule, path in found if rule == "unknown-prim-type"] == ["/W/near"]
