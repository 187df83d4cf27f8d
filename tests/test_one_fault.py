"""One fault gives one finding, and what nobody could look at is no fault."""

from __future__ import annotations

from pathlib import Path

import pytest

from conftest import since
from usdrender_lint.lint import lint
from usdrender_lint.renderers import renderer
from usdrender_lint.testing import lint_files

META = '(\n    renderSettingsPrimPath = "/Render/S"\n)\n'
WORLD = 'def Xform "World"\n{\n    def Camera "cam"\n    {\n    }\n}\n'


def stage(
    settings: str = "rel camera = </World/cam>\n        rel products = </Render/P>",
    product: str = 'token productName = "/out/a.exr"\n        rel orderedVars = </Render/v>',
    var: str = 'string sourceName = "Ci"',
    more: str = "",
    *,
    on_settings: str = "",
    on_product: str = "",
    on_var: str = "",
    world: str = WORLD,
) -> str:
    return (
        f'#usda 1.0\n{META}def Scope "Render"\n{{\n'
        f'    def RenderSettings "S" {on_settings}\n    {{\n        {settings}\n    }}\n'
        f'    def RenderProduct "P" {on_product}\n    {{\n        {product}\n    }}\n'
        f'    def RenderVar "v" {on_var}\n    {{\n        {var}\n    }}\n{more}}}\n{world}'
    )


def found(main: str, **layers: str) -> list[str]:
    files = {f"{name}.usda": f"#usda 1.0\n{text}" for name, text in layers.items()}
    report, marks = lint_files({"main.usda": main, **files})
    assert report.problems == ()
    return [m.rule for m in marks]


def test_the_base_is_right() -> None:
    assert found(stage()) == []


# 1. What a failed reference may bring is not missing: false errors.

FAILED = "(\n        references = @./no.usda@\n    )"


@pytest.mark.parametrize(
    "main",
    [
        stage(product="bool disableMotionBlur = 0", on_product=FAILED),
        stage(settings="rel products = </Render/P>", on_settings=FAILED),
        stage(settings="rel products = </Render/P>", on_product=FAILED),
        stage(settings="bool disableMotionBlur = 0", on_settings=FAILED),
        stage(var='token dataType = "int"', on_var=FAILED),
        stage(more=f'    def RenderPass "A" {FAILED}\n    {{\n    }}\n'),
    ],
    ids=["product", "camera", "camera of the product", "products", "var", "pass"],
)
def test_what_stands_behind_a_failed_arc_is_not_missing(main: str) -> None:
    assert found(main) == ["composition-error"]


# 2. A property of a prim of the right type is no camera, product or var: false green.


@pytest.mark.parametrize(
    "main",
    [
        stage(settings="rel camera = </World/cam.focalLength>\n        rel products = </Render/P>"),
        stage(settings="rel camera = </World/cam>\n        rel products = </Render/P.productName>"),
        stage(
            product='token productName = "/out/a.exr"\n        rel orderedVars = </Render/v.sourceName>'
        ),
    ],
    ids=["camera", "products", "orderedVars"],
)
def test_a_property_is_the_wrong_type_of_target(main: str) -> None:
    assert "wrong-target-type" in found(main)


# 3. Products of a second instance are rendered, too: false green, and a false note.


def instances(settings: str) -> str:
    scopes = "".join(
        f'    def Scope "{n}" (\n        instanceable = true\n        references = </_Set>\n    )\n    {{\n    }}\n'
        for n in "AB"
    )
    return (
        f'#usda 1.0\n{META}def Scope "Render"\n{{\n    def RenderSettings "S"\n    {{\n        {settings}\n    }}\n{scopes}}}\n'
        f'class "_Set"\n{{\n    def RenderProduct "P"\n    {{\n        token productName = "/out/a.exr"\n        rel orderedVars = </_Set/v>\n    }}\n'
        f'    def RenderVar "v"\n    {{\n        string sourceName = "Ci"\n    }}\n}}\n{WORLD}'
    )


@pytest.mark.parametrize(
    ("settings", "rules"),
    [
        ("rel products = </Render/B/P>", ["missing-camera"]),
        ("rel camera = </World/cam>; rel products = </Render/B/P>", []),
        (
            "rel camera = </World/cam>; rel products = [</Render/A/P>, </Render/B/P>]",
            ["duplicate-product-name"],
        ),
    ],
)
def test_products_of_every_instance_are_outputs(settings: str, rules: list[str]) -> None:
    assert found(instances(settings)) == rules


# 4. A sublayer that fails in a *referenced* layer hides what is below the reference, no more, no less.


def test_a_failed_sublayer_of_a_reference_does_not_hide_a_typo_elsewhere() -> None:
    world = WORLD + 'def "Set" (\n    references = @./set.usda@</Set>\n)\n{\n}\n'
    settings = "rel camera = [</World/cma>, </Set/cam>]\n        rel products = </Render/P>"
    set_ = (
        '(\n    subLayers = [@./no.usda@]\n)\ndef "Set"\n{\n    def Camera "cam"\n    {\n    }\n}\n'
    )
    assert "unresolved-target" in found(stage(settings, world=world), set=set_)


def test_a_failed_sublayer_of_a_reference_hides_what_is_below_it() -> None:
    world = (
        WORLD
        + 'def "Bad" (\n    references = @./no.usda@\n)\n{\n}\n'
        + 'def "Set" (\n    references = @./set.usda@</Set>\n)\n{\n}\n'
    )
    settings = "rel camera = </Set/cam>\n        rel products = </Render/P>"
    product = (
        'rel camera = </Bad/cam>; token productName = "/out/a.exr"; rel orderedVars = </Render/v>'
    )
    set_ = '(\n    subLayers = [@./no2.usda@]\n)\ndef "Set"\n{\n}\n'
    told = found(stage(settings, product, world=world), set=set_)
    assert "unresolved-target" not in told


# 5. Only arcs that are composed can fail.


@pytest.mark.parametrize("strong", ["delete references = @./no.usda@", "references = @./no.usda@"])
def test_an_arc_that_a_stronger_layer_takes_away_does_not_fail(strong: str) -> None:
    weak = "prepend references = [@./no.usda@, @./no2.usda@]"
    report, _ = lint_files(
        {
            "main.usda": f'#usda 1.0\n(\n    subLayers = [@./weak.usda@]\n)\nover "Render" (\n    {strong}\n)\n{{\n}}\n',
            "weak.usda": f'#usda 1.0\ndef "Render" (\n    {weak}\n)\n{{\n}}\n',
        }
    )
    assert len(report.findings) == 1


# 6. A reference whose expression leads nowhere fails like any other.


def test_an_asset_path_that_is_an_expression_may_fail_too() -> None:
    world = 'def "World" (\n    references = @`"${NAME}.usda"`@\n)\n{\n}\n'
    main = stage(world=world).replace(
        META, META.replace(")\n", '    expressionVariables = { string NAME = "no" }\n)\n')
    )
    assert found(main) == ["composition-error"]


def test_an_internal_reference_that_leads_nowhere_hides_what_it_was_to_bring() -> None:
    world = 'def "World" (\n    references = </No>\n)\n{\n}\n'
    assert found(stage(world=world)) == ["composition-error"]


# 7. What is printed are words of the format, never of the parser.


@pytest.mark.parametrize(
    "text",
    [
        pytest.param('def "A"\n{\n    rel camera = <.>\n}\n', marks=since(26, 5)),  # read before
        'def "A" (\n    references = @a\nb@\n)\n{\n}\n',
        'def "A"\n{\n    rel camera.timeSamples = { 1: 2 }\n}\n',
    ],
)
def test_no_name_of_the_parser_is_printed(tmp_path: Path, text: str) -> None:
    (tmp_path / "main.usda").write_text(f"#usda 1.0\n{text}")
    (finding,) = lint([str(tmp_path / "main.usda")], cwd=tmp_path).findings
    assert "pxr" not in finding.message
    assert "::" not in finding.message


def test_an_ill_formed_expression_is_told_in_a_whole_sentence(tmp_path: Path) -> None:
    (tmp_path / "main.usda").write_text(
        '#usda 1.0\ndef "A"\n{\n    pathExpression e = "/World//{"\n}\n'
    )
    (finding,) = lint([str(tmp_path / "main.usda")], cwd=tmp_path).findings
    assert not finding.message.endswith(":")


# 8. One fault, one finding.


@pytest.mark.parametrize(
    ("main", "rule"),
    [
        (stage(product="token productName = None; rel orderedVars = </Render/v>"), "blocked-value"),
        (stage(var="string sourceName = None"), "blocked-value"),
        (stage(var='string sourceName = "Ci"; token dataType = None'), "blocked-value"),
        (stage(var='string sourceName = "Ci"; token sourceType = None'), "blocked-value"),
    ],
    ids=["productName", "sourceName", "dataType", "sourceType"],
)
def test_a_block_is_told_once(main: str, rule: str) -> None:
    assert len(found(main)) == 1


@pytest.mark.parametrize(
    "main",
    [
        stage(product='token productname = "/out/a.exr"; rel orderedVars = </Render/v>'),
        stage(product='token productName = "/out/a.exr"; rel orderedvars = </Render/v>'),
        stage(settings="rel cameras = </World/cam>; rel products = </Render/P>"),
        stage(var='string sourcename = "Ci"'),
        stage(
            more='    def RenderPass "A"\n    {\n        rel renderSources = </Render/S>\n    }\n'
        ),
    ],
    ids=["productname", "orderedvars", "cameras", "sourcename", "renderSources"],
)
def test_a_misspelt_property_explains_that_the_right_one_is_missing(main: str) -> None:
    assert found(main) == ["misspelled-property"]


def test_an_override_without_a_definition_is_told_once_as_a_default() -> None:
    over = '    over "T"\n    {\n    }\n'
    main = stage(more=over).replace('PrimPath = "/Render/S"', 'PrimPath = "/Render/T"')
    told = found(main)
    assert "default-settings-not-live" in told
    assert "default-settings-wrong-type" not in told
    assert "dangling-over" not in told


def test_an_override_without_a_definition_is_told_once_as_a_target() -> None:
    over = '    over RenderVar "w"\n    {\n    }\n'
    product = 'token productName = "/out/a.exr"; rel orderedVars = [</Render/v>, </Render/w>]'
    assert len(found(stage(product=product, more=over))) == 1


def test_a_layer_of_overrides_may_repeat_the_default() -> None:
    main = f'#usda 1.0\n{META}over "Render"\n{{\n    over "S"\n    {{\n        int2 resolution = (1, 1)\n    }}\n}}\n'
    assert found(main) == []


def test_an_excluded_collection_is_told_once() -> None:
    render_pass = (
        '    def RenderPass "A"\n    {\n        rel renderSource = </Render/S>\n'
        "        rel collection:prune:includes = </World>\n"
        "        rel collection:prune:excludes = </Render/A.collection:matte>\n    }\n"
    )
    assert found(stage(more=render_pass)) == ["invalid-collection"]


def test_a_bad_expansion_rule_is_told_once() -> None:
    render_pass = (
        '    def RenderPass "A"\n    {\n        rel renderSource = </Render/S>\n'
        '        rel collection:prune:includes = </World>\n        token collection:prune:expansionRule = "all"\n    }\n'
    )
    assert len(found(stage(more=render_pass))) == 1


# 9. Places.


def test_a_class_is_shown_where_it_is_one() -> None:
    _, (mark,) = lint_files(
        {
            "main.usda": '#usda 1.0\n(\n    subLayers = [@./weak.usda@]\n)\nover "Render"\n{\n}\ndef "World"\n{\n}\n',
            "weak.usda": '#usda 1.0\nclass Scope "Render"\n{\n    def RenderVar "v"\n    {\n    }\n}\n',
        }
    )
    assert (mark.rule, mark.file) == ("render-scope-not-live", "weak.usda")


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("<Render/S>", "relative-target"),
        ("</Render/A/Render/S>", "relative-target"),
        ("<Render/T>", "unresolved-target"),
        ("</Render/A/Render/T>", "unresolved-target"),
    ],
)
def test_a_layer_that_was_saved_again_has_the_same_fault(written: str, told: str) -> None:
    """USD writes the whole path for the one that was relative."""
    render_pass = f'    def RenderPass "A"\n    {{\n        rel renderSource = {written}\n    }}\n'
    assert found(stage(more=render_pass)) == [told]


def test_a_camera_below_its_own_settings_is_in_no_other_layer() -> None:
    """<World/cam> on </Render/S>, where the scene comes from elsewhere."""
    main = stage(settings="rel camera = </Render/S/World/cam>", world="")
    _, marks = lint_files({"main.usda": main})
    told = [(m.rule, m.severity) for m in marks]
    assert ("unresolved-target", "error") in told


def test_a_failed_payload_is_not_called_a_reference() -> None:
    """target-outside-reference says 'what </Render> references' and relates to its `references`."""
    report, _ = lint_files(
        {
            "main.usda": f'#usda 1.0\n{META}def "Render" (\n    payload = @./show.usda@</Show>\n)\n{{\n}}\n{WORLD}',
            "show.usda": '#usda 1.0\ndef "Show"\n{\n    def RenderSettings "S"\n    {\n        rel camera = </World/cam>\n    }\n}\n',
        }
    )
    finding = next(f for f in report.findings if f.rule.id == "target-outside-reference")
    (place,) = finding.related
    assert place.location.span is not None
    assert "payload" in (place.location.source or "")


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("int2 resolutionScale = (2, 2)", ["unknown-property"]),
        ("int2 proxyResolution = (2, 2)", ["unknown-property"]),
        ('token[] excludedPurposes = ["guide"]', ["unknown-property"]),
        ("bool enableMotionBlur = 1", ["unknown-property"]),
        ("int resolutionX = 2", ["unknown-property"]),
        ("float pixelAspect = 1", ["misspelled-property"]),
        ("int2 resoluton = (2, 2)", ["misspelled-property"]),
    ],
)
def test_a_name_of_its_own_is_no_typo(written: str, told: list[str]) -> None:
    settings = f"rel camera = </World/cam>\n        rel products = </Render/P>\n        {written}"
    assert found(stage(settings)) == told


@pytest.mark.parametrize(
    ("type_name", "told"),
    [
        ("RenderVars", ["unknown-prim-type"]),
        ("UsdRenderVar", ["unknown-prim-type"]),
        ("renderVar", ["unknown-prim-type"]),
        ("OmniRenderProduct", []),
        ("HoudiniRenderSettings", []),
        ("PxrRenderSettings", []),
        ("RenderLayer", []),
    ],
)
def test_the_type_of_a_plugin_is_no_typo(type_name: str, told: list[str]) -> None:
    assert found(stage(more=f'    def {type_name} "x"\n    {{\n    }}\n')) == told


@pytest.mark.parametrize("name", ["productName", "sourceName"])
def test_an_attribute_written_as_a_relationship_is_not_also_empty(name: str) -> None:
    parts = {
        "productName": {
            "product": "rel productName = </World>\n        rel orderedVars = </Render/v>"
        },
        "sourceName": {"var": "rel sourceName = </World>"},
    }[name]
    assert found(stage(**parts)) == ["kind-mismatch"]


def test_text_that_is_not_utf8_is_told_at_its_byte(tmp_path: Path) -> None:
    file = tmp_path / "main.usda"
    file.write_bytes(
        b'#usda 1.0\ndef Scope "Render"\n{\n    string a = "caf\xe9"\n    nonsense\n}\n'
    )
    (finding,) = lint([str(file)], cwd=tmp_path).findings
    assert finding.rule.id == "syntax-error"
    assert finding.location.span is not None
    assert finding.location.span.line == 4


# 10. What only follows from a fault is not told beside it, and a second fault is.


CAMERA = "rel camera = </World/cam>\n        rel products = </Render/P>"
PRODUCT = 'token productName = "/out/a.exr"\n        rel orderedVars = </Render/v>'
GEO = WORLD.replace("def Camera", 'def Mesh "geo" {}\n    def Camera')
PASS = '    def RenderPass "A"\n    {\n        rel renderSource = </Render/S>\n    }\n'


@pytest.mark.parametrize("second", ["/World/none", "/World/geo", "/World/cam2"])
def test_a_second_camera_is_too_many_whatever_it_is(second: str) -> None:
    """Nothing depends on it: the first one is rendered."""
    settings = f"rel camera = [</World/cam>, <{second}>]\n        rel products = </Render/P>"
    assert found(stage(settings, world=GEO)) == ["multiple-cameras"]


def test_a_broken_first_camera_is_told_beside_the_second() -> None:
    settings = "rel camera = [</World/no>, </World/cam>]\n        rel products = </Render/P>"
    assert sorted(found(stage(settings))) == ["multiple-cameras", "unresolved-target"]


def test_a_second_render_source_is_too_many_whatever_it_is() -> None:
    more = PASS.replace("= </Render/S>", "= [</Render/S>, </Render/No>]")
    assert found(stage(more=more)) == ["multiple-render-sources"]


def test_a_name_on_the_settings_is_missing_on_their_product() -> None:
    settings = f'{CAMERA}\n        token productName = "/out/a.exr"'
    assert found(stage(settings, product="rel orderedVars = </Render/v>")) == ["misplaced-property"]


def test_a_list_on_the_settings_is_missing_on_their_product() -> None:
    settings = f"{CAMERA}\n        rel orderedVars = </Render/v>"
    main = stage(settings, product='token productName = "/out/a.exr"')
    assert found(main) == ["misplaced-property"]


def test_one_misplaced_name_does_not_name_two_products() -> None:
    settings = 'rel camera = </World/cam>\n        rel products = [</Render/P>, </Render/Q>]\n        token productName = "/out/a.exr"'
    second = '    def RenderProduct "Q"\n    {\n        rel orderedVars = </Render/v>\n    }\n'
    told = found(stage(settings, product="rel orderedVars = </Render/v>", more=second))
    assert sorted(told) == ["empty-product-name", "empty-product-name", "misplaced-property"]


def test_a_misplaced_property_hides_no_other_fault_of_the_product() -> None:
    settings = f'{CAMERA}\n        token productName = "/out/a.exr"'
    main = stage(settings, product="rel orderedVars = </Render/no>")
    assert sorted(found(main)) == ["misplaced-property", "unresolved-target"]


def test_settings_that_are_the_default_and_a_source_are_inactive_once() -> None:
    main = stage(more=PASS, on_settings="(\n        active = false\n    )")
    assert found(main) == ["default-settings-not-live"]


def test_another_dead_target_is_told_beside_inactive_default_settings() -> None:
    dead = '    def RenderSettings "T" (\n        active = false\n    )\n    {\n    }\n'
    more = dead + PASS.replace("/Render/S", "/Render/T")
    main = stage(more=more, on_settings="(\n        active = false\n    )")
    assert sorted(found(main)) == ["dead-target", "default-settings-not-live"]


def test_where_the_default_settings_are_missing_there_are_none() -> None:
    main = stage().replace('def RenderSettings "S"', 'def Scope "T"').replace(CAMERA, "")
    assert found(main) == ["default-settings-unresolved"]


def test_samples_without_a_default_leave_a_source_without_a_name() -> None:
    assert found(stage(var='string sourceName.timeSamples = { 1: "Ci" }')) == ["animated-uniform"]


def test_animating_one_attribute_does_not_hide_that_another_is_empty() -> None:
    var = 'token dataType.timeSamples = { 1: "color3f" }'
    assert sorted(found(stage(var=var))) == ["animated-uniform", "empty-source-name"]


def test_a_blank_at_the_end_is_no_extension() -> None:
    product = PRODUCT.replace("a.exr", "a.exr ")
    assert found(stage(product=product)) == ["nonportable-product-name"]


def test_a_blank_at_the_end_does_not_hide_the_extension() -> None:
    product = PRODUCT.replace("a.exr", "a.xyz ")
    assert sorted(found(stage(product=product))) == [
        "nonportable-product-name",
        "unsupported-extension",
    ]


def test_a_default_in_two_sublayers_is_missing_once() -> None:
    main = stage().replace(META, "(\n    subLayers = [@./one.usda@, @./two.usda@]\n)\n")
    assert found(main, one=META, two=META) == ["default-settings-in-sublayer"]


def test_settings_that_nobody_uses_and_that_share_a_product_are_told_once() -> None:
    other = f'    def RenderSettings "A"\n    {{\n        {CAMERA}\n    }}\n'
    assert found(stage(more=other)) == ["shared-product"]


def test_vars_in_a_library_of_their_own_are_told_once() -> None:
    main = '#usda 1.0\ndef Scope "Vars"\n{\n    def RenderVar "A"\n    {\n        string sourceName = "Ci"\n    }\n}\n'
    assert found(main) == []  # to be referenced by a shot
    assert found(main + WORLD) == ["outside-render-scope"]


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ("rel resolution = </World>", ["kind-mismatch"]),
        ("int2 resoluton = (2, 2)", ["misspelled-property"]),
        (
            'uniform token[] materialBindingPurposes = ["default", "full"]',
            ["unknown-material-purpose"],
        ),
        (
            'uniform token[] materialBindingPurposes = ["full", "preview"]',
            ["many-material-purposes"],
        ),
        (
            'uniform token[] materialBindingPurposes = ["full", "preview", "x"]',
            ["many-material-purposes", "unknown-material-purpose"],
        ),
        ("float2 resolution = (2, 2)", ["type-mismatch"]),
    ],
)
def test_rules_that_must_be_selected_do_not_repeat_others(settings: str, told: list[str]) -> None:
    rules = (
        "default",
        "default-resolution",
        "many-material-purposes",
        "no-all-purpose-fallback",
        "variability-mismatch",
    )
    main = stage(f"{CAMERA}\n        {settings}", var='uniform string sourceName = "Ci"')
    report, marks = lint_files({"main.usda": main}, rules=rules)
    assert report.problems == ()
    assert sorted({m.rule for m in marks} - {"default-resolution"}) == told
    assert ("default-resolution" in {m.rule for m in marks}) == ("resol" not in settings)


def test_a_rule_that_is_off_for_a_renderer_takes_nothing_away() -> None:
    """MoonRay needs no sourceName; but that it is blocked is told then."""
    assert renderer("moonray").severities["empty-source-name"] is None
    main = stage(var="string sourceName = None")
    _, marks = lint_files({"main.usda": main}, renderer="moonray")
    assert [m.rule for m in marks] == ["blocked-value"]


TWO = "rel camera = </World/cam>\n        rel products = [</Render/P>, </Render/Q>]"
SECOND = (
    '    def RenderProduct "Q"\n    {\n        token productName = "/out/q.exr"\n'
    "        rel orderedVars = </Render/v>\n    }\n"
)


def test_a_dead_prim_is_told_once_whoever_leads_to_it() -> None:
    """One line brings it to life for all."""
    dead = "(\n        active = false\n    )"
    report, marks = lint_files({"main.usda": stage(TWO, more=SECOND, on_var=dead)})
    assert [m.rule for m in marks] == ["dead-target"]
    places = [p.message for p in report.findings[0].related]
    assert places == ["is switched off here", "leads there, too"]


def test_of_all_that_lead_to_a_dead_prim_the_worst_is_told() -> None:
    """A product that loses one of two vars is less than one that loses its only var."""
    dead = '    def RenderVar "w" (\n        active = false\n    )\n    {\n        string sourceName = "a"\n    }\n'
    product = PRODUCT.replace("</Render/v>", "[</Render/v>, </Render/w>]")
    second = SECOND.replace("/Render/v", "/Render/w")
    _, marks = lint_files({"main.usda": stage(TWO, product, more=dead + second)})
    assert [(m.rule, m.severity) for m in marks] == [("dead-target", "error")]


def test_two_dead_prims_are_told_twice() -> None:
    dead = '    def RenderVar "w" (\n        active = false\n    )\n    {\n        string sourceName = "a"\n    }\n'
    product = PRODUCT.replace("</Render/v>", "[</Render/v>, </Render/w>]")
    main = stage(product=product, more=dead, on_var="(\n        active = false\n    )")
    assert found(main) == ["dead-target", "dead-target"]


def test_a_var_may_be_what_a_product_without_vars_should_list() -> None:
    product = 'token productName = "/out/a.exr"'
    spare = '    def RenderVar "w"\n    {\n        string sourceName = "albedo"\n    }\n'
    assert found(stage(TWO, product, more=SECOND + spare)) == ["product-without-vars"]
    assert found(stage(TWO, more=SECOND + spare)) == ["orphan-var"]


def test_a_misspelt_camera_of_the_settings_is_what_their_products_lack() -> None:
    settings = TWO.replace("rel camera", "rel camra")
    own = PRODUCT + "\n        rel camera = </World/cam>"
    assert found(stage(settings, own, more=SECOND)) == ["misspelled-property"]


CLOSES_FIRST = (
    'def Xform "World"\n{\n    def Camera "cam"\n    {\n        double shutter:open = 1\n'
    "        double shutter:close = 0\n    }\n}\n"
)


@pytest.mark.parametrize(
    ("camera", "told"),
    [
        ("</World/cma>", ["inverted-shutter", "unresolved-target"]),
        ("<World/cam>", ["inverted-shutter", "relative-target"]),
        ("</World/other_thing>", ["unresolved-target"]),
        ("</World>", ["inverted-shutter", "wrong-target-type"]),
    ],
)
def test_a_camera_is_judged_though_its_name_is_misspelt(camera: str, told: list[str]) -> None:
    """Both must be mended, and the second need not wait for the first."""
    settings = f"rel camera = {camera}\n        rel products = </Render/P>"
    assert sorted(found(stage(settings, world=CLOSES_FIRST))) == told


def test_a_stray_var_is_not_also_an_orphan() -> None:
    stray = 'def RenderVar "w"\n{\n    string sourceName = "albedo"\n}\n'
    assert found(stage(world=WORLD + stray)) == ["outside-render-scope"]


@pytest.mark.parametrize(
    "text",
    ['def "A"\n{\n    string a = "open\n}\n', 'def "A" (\n    references = @x.usda\n)\n{\n}\n'],
)
def test_the_place_of_a_syntax_error_is_not_empty(tmp_path: Path, text: str) -> None:
    (tmp_path / "main.usda").write_text(f"#usda 1.0\n{text}")
    (finding,) = lint([str(tmp_path / "main.usda")], cwd=tmp_path).findings
    span, source = finding.location.span, finding.location.source
    assert span is not None
    assert source is not None
    assert source[span.column - 1 : span.end_column - 1]


def test_a_class_is_no_stray_where_a_prim_of_it_is_inactive() -> None:
    shared = (
        'class "_Set"\n{\n    def RenderVar "w" (\n        active = false\n    )\n    {\n'
        '        string sourceName = "albedo"\n    }\n}\n'
    )
    assert found(stage(world=WORLD + shared)) == []


@pytest.mark.parametrize(
    ("settings", "product", "rule"),
    [
        ("rel product = </Render/P>", None, "misspelled-property"),
        ('token[] products = ["/Render/P"]', None, "kind-mismatch"),
        (None, 'token product_name = "/out/a.exr"', "misspelled-property"),
        (None, 'string productName = "/out/a.exr"', "type-mismatch"),
        (None, "rel productName = </World>", "kind-mismatch"),
    ],
)
def test_what_a_pass_waits_for_is_told_by_its_cause(
    settings: str | None, product: str | None, rule: str
) -> None:
    settings = settings or "rel products = </Render/P>"
    product = product or 'token productName = "/out/a.exr"'
    passes = (
        '    def RenderPass "A"\n    {\n        rel renderSource = </Render/S>\n    }\n'
        '    def RenderPass "B"\n    {\n        rel renderSource = </Render/S>\n'
        "        rel inputPasses = </Render/A>\n    }\n"
    )
    main = stage(
        f"rel camera = </World/cam>\n        {settings}",
        f"{product}\n        rel orderedVars = </Render/v>",
        more=passes,
    )
    assert [r for r in found(main) if r != "passes-overwrite-output"] == [rule]


def test_a_pass_of_another_application_points_where_it_likes_whatever_type_names_its_file() -> None:
    external = (
        '    def RenderPass "A"\n    {\n        string fileName = "comp.nk"\n'
        "        rel renderSource = </Write1>\n    }\n"
    )
    assert found(stage(more=external)) == ["type-mismatch"]


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("Xform", "is an Xform, which brings a transform where nothing is to be moved: the"),
        ("scope", "is a scope: the"),
    ],
)
def test_only_what_moves_is_said_to_bring_a_transform(kind: str, said: str) -> None:
    main = stage().replace('def Scope "Render"', f'def {kind} "Render"')
    _, (mark,) = lint_files({"main.usda": main})
    assert mark.text == f"</Render> {said} convention is a Scope"


def test_what_layers_declare_of_types_of_their_own_is_read_by_its_value() -> None:
    """The type is the strongest layer's, and the value the one of the layer that has any."""
    declared = "custom asset[] studio:look\n        custom string studio:tags"
    main = stage(
        f"rel camera = </World/cam>\n        rel products = </Render/P>\n        {declared}",
        on_settings="(references = @./weak.usda@</S>)",
    )
    weak = 'over "S"\n{\n    custom asset studio:look = @a.usd@\n    custom string[] studio:tags = ["a"]\n}\n'
    assert found(main, weak=weak) == []
