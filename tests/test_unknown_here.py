"""What is right for somebody is no fault, and what nobody told before is told."""

from __future__ import annotations

from pathlib import Path

import pytest
from pxr import Sdf

from test_one_fault import META, WORLD, found, stage
from usdrender_lint.lint import lint
from usdrender_lint.testing import lint_files


@pytest.mark.parametrize(
    ("asset", "severity"),
    [
        ("ayon+entity://proj/asset?version=latest", "note"),
        ("shotgrid://x", "note"),
        ("studio:lib/rs?v=3", "note"),
        ("op:/stage/x.sop", "note"),
        ("https://example.com/a.usd", "note"),
        ("./no.usda", "error"),
        ("C:/shots/no.usda", "error"),
    ],
)
@pytest.mark.parametrize("arc", ["references", "payload"])
def test_what_only_another_resolver_finds_is_unknown(asset: str, severity: str, arc: str) -> None:
    world = WORLD.replace('"World"', f'"World" (\n    {arc} = @{asset}@\n)').replace('"cam"', '"x"')
    _, marks = lint_files({"main.usda": stage(world=world)})
    assert [(m.rule, m.severity) for m in marks] == [("composition-error", severity)]


def test_a_declaration_is_no_opinion() -> None:
    more = '    def RenderPass "A"\n    {\n        rel renderSource = </Render/S>\n        rel camera\n    }\n'
    product = 'token productName = "/out/a.exr"\n        rel orderedVars = </Render/v>\n        rel products'
    assert found(stage(product=product, more=more)) == []
    assert found(stage(product=f"{product} = </Render/P>")) == ["misplaced-property"]


def test_the_shutter_matters_only_to_motion_blur() -> None:
    world = WORLD.replace(
        '"cam"\n    {',
        '"cam"\n    {\n        double shutter:open = 1\n        double shutter:close = 0',
    )
    blurred = "rel camera = </World/cam>\n        rel products = </Render/P>"
    assert found(stage(blurred, world=world)) == ["inverted-shutter"]
    sharp = f"{blurred}\n        uniform bool disableMotionBlur = 1"
    assert found(stage(sharp, world=world)) == []
    # Most renderers do not read the deprecated flag: they blur, and ask when the shutter closes.
    still = f"{blurred}\n        uniform bool instantaneousShutter = 1"
    assert found(stage(still, world=world)) == [
        "deprecated-instantaneous-shutter",
        "inverted-shutter",
    ]


def test_a_var_without_a_source_is_called_by_its_path() -> None:
    intrinsic = 'uniform token sourceType = "intrinsic"'
    _, marks = lint_files({"main.usda": stage(var=intrinsic)})
    assert [(m.rule, m.text.rpartition(": ")[2]) for m in marks] == [
        ("empty-source-name", "what is it to hold?"),
        ("intrinsic-source-type", "</Render/v> gets no data"),
    ]


def test_two_vars_that_meet_in_two_renders_are_told_once() -> None:
    more = """
    def RenderSettings "T"
    {
        rel camera = </World/cam>
        rel products = [</Render/Q>, </Render/R>]
    }
    def RenderProduct "Q"
    {
        token productName = "/out/q.exr"
        rel orderedVars = </Render/w>
    }
    def RenderProduct "R"
    {
        token productName = "/out/r.exr"
        rel orderedVars = </Render/v>
    }
    def RenderVar "w"
    {
        uniform token dataType = "color4f"
        string sourceName = "Ci"
    }
"""
    settings = "rel camera = </World/cam>\n        rel products = [</Render/P>, </Render/Q>]"
    assert found(stage(settings, more=more)).count("conflicting-aov") == 1


@pytest.mark.parametrize(
    ("name", "renderer", "told"),
    [
        ("a.EXR", "any", ["note unsupported-extension"]),
        ("a.PNG", "any", ["note unsupported-extension"]),
        ("a.EXR", "arnold", []),
        ("a.EXR", "renderman", ["note unsupported-extension"]),
        ("a.PNG", "renderman", ["warning unsupported-extension"]),
    ],
)
def test_upper_case_is_the_same_format_where_it_is(
    name: str, renderer: str, told: list[str]
) -> None:
    product = f'token productName = "/out/{name}"\n        rel orderedVars = </Render/v>'
    _, marks = lint_files({"main.usda": stage(product=product)}, renderer=renderer)
    assert [f"{m.severity} {m.rule}" for m in marks] == told


@pytest.mark.parametrize(
    ("name", "renderer", "told"),
    [
        ("a.EXR", "any", []),
        ("a.EXR", "renderman", ["error"]),
        ("a.rat", "any", []),
        ("a.rat", "renderman", ["error"]),
        ("a.dtex", "any", ["warning"]),
        ("a.dtex", "renderman", ["warning"]),
        ("a.png", "any", ["error"]),
    ],
)
def test_deep_formats_are_each_renderers_own(name: str, renderer: str, told: list[str]) -> None:
    product = (
        f'token productName = "/out/{name}"\n        token productType = "deepRaster"\n'
        "        rel orderedVars = </Render/v>"
    )
    _, marks = lint_files({"main.usda": stage(product=product)}, renderer=renderer)
    assert [m.severity for m in marks if m.rule == "deep-needs-exr"] == told
    named = f'{product}\n        token ri:productType = "deepshad"'
    _, marks = lint_files({"main.usda": stage(product=named)}, renderer=renderer)
    assert [m for m in marks if m.rule == "deep-needs-exr"] == []


def test_a_hub_of_targets_needs_no_type() -> None:
    hub = '    def "Hub"\n    {\n        custom rel products = </Render/P>\n    }\n'
    through = "rel camera = </World/cam>\n        rel products = </Render/Hub.products>"
    assert found(stage(through, more=hub)) == []
    assert found(stage(more=hub)) == ["untyped-render-prim"]


def test_settings_of_an_unknown_type_are_a_plugins() -> None:
    main = stage().replace("def RenderSettings", "def StudioSettings")
    _, marks = lint_files({"main.usda": main})
    assert [(m.rule, m.severity) for m in marks] == [("default-settings-wrong-type", "note")]


@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
@pytest.mark.parametrize("at", ["/Render", "/Foo/S"])
def test_a_misspelt_type_is_told_wherever_it_stands(at: str, suffix: str, tmp_path: Path) -> None:
    layer = Sdf.Layer.CreateNew(str(tmp_path / f"main{suffix}"))
    Sdf.CreatePrimInLayer(layer, at).specifier = Sdf.SpecifierDef
    layer.GetPrimAtPath(at).typeName = "RenderSetting"
    layer.pseudoRoot.SetInfo("renderSettingsPrimPath", at)
    layer.Save()
    assert [f.rule.id for f in lint([layer.realPath], cwd=tmp_path).findings] == [
        "unknown-prim-type"
    ]


def test_a_property_renders_nothing_by_itself() -> None:
    job = '    def RenderPass "A"\n    {\n        rel renderSource = </Render/A.nuke:node>\n        string nuke:node = "x"\n'
    assert found(stage(more=f"{job}    }}\n")) == ["wrong-target-type"]
    command = '        string[] command = ["nuke", "-x", "comp.nk"]\n'
    assert "wrong-target-type" not in found(stage(more=f"{job}{command}    }}\n"))


@pytest.mark.parametrize(
    ("name", "told"),
    [("/out/a.exr", [("duplicate-product-name", "warning")]), ("/out/b.exr", [])],
)
def test_products_with_samples_share_a_default_name(name: str, told: list[str]) -> None:
    samples = 'token productName.timeSamples = {\n            1: "/out/b.1.exr",\n            2: "/out/b.2.exr",\n        }'
    more = (
        f'    def RenderProduct "Q"\n    {{\n        token productName = "{name}"\n        {samples}\n'
        "        rel orderedVars = </Render/v>\n    }\n"
    )
    settings = "rel camera = </World/cam>\n        rel products = [</Render/P>, </Render/Q>]"
    _, marks = lint_files({"main.usda": stage(settings, more=more)})
    assert [(m.rule, m.severity) for m in marks] == told


@pytest.mark.parametrize("kind", ["lpe", "primvar"])
def test_the_name_of_a_channel_is_no_source(kind: str) -> None:
    named = 'string driver:parameters:aov:name = "a"'
    assert found(stage(var=named)) == []
    assert found(stage(var=f'{named}\n        token sourceType = "{kind}"')) == [
        "empty-source-name"
    ]


IN_A_VARIANT = """ (
    variants = {
        string rig = "a"
    }
    prepend variantSets = "rig"
)
{
    def Camera "cam"
    {
    }
    variantSet "rig" = {
        "a" {
        }
        "b" {
            def Camera "hero"
            {
            }
        }
    }
}
"""


def test_a_target_in_a_variant_that_is_not_selected_is_told_as_that() -> None:
    settings = "rel camera = </World/hero>\n        rel products = </Render/P>"
    world = 'def Xform "World"' + IN_A_VARIANT
    _, (mark,) = lint_files({"main.usda": stage(settings, world=world)})
    assert mark.text == (
        "camera </World/hero> does not exist:"
        " it is only in variant 'b' of 'rig' on </World>, which is not selected"
    )
    selected = world.replace('rig = "a"', 'rig = "b"')
    assert found(stage(settings, world=selected)) == []


def test_default_settings_in_a_variant_that_is_not_selected_are_told_as_that() -> None:
    scope = 'def Scope "Render"' + IN_A_VARIANT.replace("Camera", "RenderSettings")
    main = f"#usda 1.0\n{META.replace('/S', '/hero')}{scope}{WORLD}"
    _, marks = lint_files({"main.usda": main})
    (mark,) = [m for m in marks if m.rule == "default-settings-unresolved"]
    assert "only in variant 'b' of 'rig' on </Render>" in mark.text


@pytest.mark.parametrize("strays", [1, 2, 6])
def test_each_stray_exclude_is_told(strays: int) -> None:
    names = [f"s{i}" for i in range(strays)]
    world = WORLD + "".join(f'def Sphere "{n}"\n{{\n}}\n' for n in (*names, "in"))
    excludes = ", ".join(f"</{n}>" for n in names)
    more = (
        '    def RenderPass "A"\n    {\n        rel renderSource = </Render/S>\n'
        "        rel collection:prune:includes = </in>\n"
        f"        rel collection:prune:excludes = [{excludes}]\n    }}\n"
    )
    _, marks = lint_files({"main.usda": stage(more=more, world=world)})
    texts = [m.text for m in marks if m.rule == "invalid-collection"]
    assert len(texts) == (strays if strays <= 4 else 1)
    assert strays <= 4 or "5 other excludes" in texts[0]


def test_a_key_below_another_key_is_told() -> None:
    nested = '(\n    customLayerData = {\n        dictionary show = {\n            string renderSettingsPrimPath = "/Render/S"\n        }\n    }\n)\n'
    _, (mark,) = lint_files({"main.usda": stage().replace(META, nested)})
    assert (mark.rule, mark.line) == ("default-settings-misspelled", 5)


@pytest.mark.parametrize(
    ("var", "product", "told"),
    [
        ('token dataType = "color"', "", ["unknown-data-type error"]),
        ('token dataType = "color"', "int arnold:x = 1", ["nonstandard-data-type note"]),
        ("", "int arnold:x = 1", []),
        ("string arnold:name = 'a'", "int arnold:x = 1", ["empty-source-name warning"]),
    ],
)
def test_arnold_is_judged_by_what_it_reads(var: str, product: str, told: list[str]) -> None:
    source = "" if "arnold" in var else 'string sourceName = "Ci"\n        '
    named = 'token productName = "/out/a.exr"\n        rel orderedVars = </Render/v>\n        '
    _, marks = lint_files({"main.usda": stage(product=named + product, var=source + var)})
    assert [f"{m.rule} {m.severity}" for m in marks] == told


@pytest.mark.parametrize(("renderer", "severity"), [("any", "warning"), ("arnold", "note")])
def test_only_kick_names_a_file_after_the_product(renderer: str, severity: str) -> None:
    main = stage(product="rel orderedVars = </Render/v>")
    _, (mark,) = lint_files({"main.usda": main}, renderer=renderer)
    assert (mark.rule, mark.severity) == ("empty-product-name", severity)
    assert ("kick" in mark.text) == (renderer == "arnold")


def test_a_scene_for_ovrtx_needs_neither_settings_nor_files() -> None:
    """It may have no other trace of Omniverse than the sources of its vars (ovrtx, "Outputs")."""
    text = """#usda 1.0
def "Render"
{
    def RenderProduct "Camera"
    {
        int2 resolution = (1920, 1080)
        rel camera = </World/Camera>
        rel orderedVars = [<LdrColor>]
        def RenderVar "LdrColor"
        {
            string sourceName = "LdrColor"
        }
    }
}
def Xform "World"
{
    def Camera "Camera"
    {
    }
}
"""
    _, marks = lint_files({"main.usda": text})
    assert marks == []


def test_vars_of_moonray_may_name_the_file_that_their_product_does_not() -> None:
    """As hdMoonray's own `testSuite/aov/cryptomatte` does."""
    product = "rel orderedVars = </Render/v>"
    var = 'token parameters:moonray:file_name = "/tmp/a.exr"'
    _, marks = lint_files({"main.usda": stage(product=product, var=var)}, renderer="moonray")
    assert [f"{m.severity} {m.rule}" for m in marks] == ["note empty-product-name"]
