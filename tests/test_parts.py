"""A layer that other layers complete is not blamed for what it leaves to them."""

from __future__ import annotations

import pytest

from usdrender_lint.testing import lint_files

META = '(\n    renderSettingsPrimPath = "/Render/S"\n)\n'
LIGHT = 'def DistantLight "key"\n{\n}\n'
WORLD = 'def Xform "World"\n{\n    def Camera "cam"\n    {\n    }\n}\n'
VARS = 'def RenderVar "v"\n{\nuniform string sourceName = "Ci"\n}\n'
PRODUCT = (
    'def RenderProduct "P"\n{\ntoken productName = "a.exr"\nrel orderedVars = </Render/Vars/v>\n}\n'
)
PASS = 'def RenderPass "A"\n{\nrel renderSource = </Render/S>\n}\n'
SETTINGS = 'def RenderSettings "S"\n{\nrel camera = </World/cam>\nrel products = </Render/P>\n}\n'


def scope(*prims: str, specifier: str = "def Scope", name: str = "Render") -> str:
    return f'{specifier} "{name}"\n{{\n{"".join(prims)}}}\n'


def over(name: str, inside: str = "") -> str:
    return f'over "{name}"\n{{\n{inside}}}\n'


def told(text: str, **layers: str) -> list[str]:
    files = {f"{name}.usda": f"#usda 1.0\n{more}" for name, more in layers.items()}
    report, marks = lint_files({"main.usda": f"#usda 1.0\n{text}", **files})
    assert report.problems == ()
    return [f"{m.severity} {m.rule}" for m in marks]


@pytest.mark.parametrize("beside", ["", LIGHT])
@pytest.mark.parametrize(
    "inside",
    [
        over("S", "rel camera = </World/cam>\n"),
        over("Products", PRODUCT) + over("S", "prepend rel products = </Render/Products/P>\n"),
        over("P", 'token productName = "b.exr"\n'),
    ],
    ids=["camera", "another product", "name"],
)
def test_who_only_overrides_the_scope_may_define_a_light(inside: str, beside: str) -> None:
    assert told(over("Render", inside) + beside) == []


def test_settings_under_an_over_are_no_override() -> None:
    main = scope(SETTINGS, PRODUCT, specifier="over") + WORLD
    assert "error render-scope-not-live" in told(main)


@pytest.mark.parametrize(
    ("inside", "rule"),
    [
        (over("S"), "default-settings-not-live"),
        (over("P"), "default-settings-unresolved"),
    ],
)
def test_a_scene_that_overrides_its_default_settings_gets_a_note(inside: str, rule: str) -> None:
    assert told(META + over("Render", inside)) == []
    assert told(META + over("Render", inside) + WORLD) == [f"note {rule}"]


def test_a_default_without_any_scope_leads_nowhere() -> None:
    assert told(META + WORLD) == ["error default-settings-unresolved"]


@pytest.mark.parametrize(
    ("library", "rules"),
    [
        (scope(VARS, name="Vars"), []),
        (VARS, []),
        (scope(scope(VARS, name="Vars")), ["note no-render-settings"]),
        (
            scope(scope(VARS, name="Vars"), scope(PRODUCT, name="Products")),
            ["note no-render-settings"],
        ),
    ],
    ids=["by themselves", "at the root", "in the scope", "with products"],
)
def test_a_library_is_not_blamed_for_missing_settings(library: str, rules: list[str]) -> None:
    assert told(library) == rules


def test_with_a_scene_it_is_no_library() -> None:
    assert told(scope(VARS) + WORLD) == ["warning no-render-settings"]
    assert told(scope(VARS, name="Vars") + WORLD) == ["warning outside-render-scope"]


@pytest.mark.parametrize(
    ("part", "severity"),
    [
        (scope(PRODUCT), "note"),
        (scope(PASS), "note"),
        (META + scope(SETTINGS, PRODUCT.replace("Vars/v", "v"), VARS), "note"),
        (scope(PRODUCT, VARS), "error"),  # a var is here: was it meant?
        (META + scope(PASS), "error"),
        (META + scope(SETTINGS, PRODUCT.replace("Vars/v", "v"), VARS) + LIGHT, "error"),
    ],
    ids=["products", "passes", "no scene", "another var", "with a default", "a scene"],
)
def test_what_a_part_lacks_may_be_elsewhere(part: str, severity: str) -> None:
    assert f"{severity} unresolved-target" in told(part)


def test_passes_of_other_applications_need_no_settings() -> None:
    inside = PRODUCT.replace("Vars/v", "v") + VARS
    external = 'def RenderPass "A"\n{\nasset fileName = @{shot}.nk@\n}\n'
    assert "warning no-render-settings" in told(scope(inside) + WORLD)
    assert told(scope(inside, external) + WORLD) == ["note missing-render-source"]
    assert "warning no-render-settings" in told(
        scope(inside, external, PASS.replace('"A"', '"B"')) + WORLD
    )


@pytest.mark.parametrize(
    ("settings", "severity"),
    [
        ("", "note"),
        (SETTINGS.replace('"S"', '"Old"'), "error"),
        (SETTINGS, "warning"),
    ],
    ids=["no settings", "it would lead there", "it leads nowhere"],
)
def test_a_default_in_a_sublayer_says_whether_it_would_work(settings: str, severity: str) -> None:
    inside = [settings, PRODUCT.replace("Vars/v", "v"), VARS] if settings else []
    main = "(\n    subLayers = [@weak.usda@]\n)\n" + (scope(*inside) if inside else "") + WORLD
    found = told(main, weak='(\n    renderSettingsPrimPath = "/Render/Old"\n)\n')
    assert found == [f"{severity} default-settings-in-sublayer"]


@pytest.mark.parametrize(
    ("text", "severity"),
    [
        (WORLD, "warning"),
        ('class RenderSettings "RenderSettings"\n{\n}\n', "warning"),
        (scope(VARS), "error"),
        (META, "error"),
    ],
    ids=["a scene", "a definition of schemas", "vars", "a default"],
)
def test_without_a_render_spec_a_missing_layer_is_no_error(text: str, severity: str) -> None:
    sublayers = "    subLayers = [@./no.usda@]\n)\n"
    main = text.replace(")\n", sublayers, 1) if text == META else f"(\n{sublayers}{text}"
    assert told(main) == [f"{severity} composition-error"]


def test_a_definition_of_schemas_asks_for_those_that_only_usds_own_tools_find() -> None:
    sublayers = "(\n    subLayers = [@usd/schema.usda@, @usdGeom/schema.usda@]\n)\n"
    schemas = 'class RenderSettings "RenderSettings"\n{\n}\n'
    assert told(sublayers + schemas) == ["note composition-error"] * 2
    assert told(sublayers + scope(VARS)) == ["error composition-error"] * 2


def typed(name: str, inside: str) -> str:
    return f'over Render{name} "{name}"\n{{\n{inside}\n}}\n'


@pytest.mark.parametrize(
    ("override", "rules"),
    [
        (typed("Settings", "uniform int2 resolutoin = (9, 5)"), ["error misspelled-property"]),
        (typed("Settings", "uniform float2 resolution = (9, 5)"), ["error type-mismatch"]),
        (typed("Settings", "uniform int2 resolution = (0, 5)"), ["error invalid-resolution"]),
        (typed("Settings", 'string camera = "/cam"'), ["error kind-mismatch"]),
        (typed("Product", "rel products = </Render/P>"), ["error misplaced-property"]),
        (typed("Var", 'uniform token dataType = "rgb"'), ["error unknown-data-type"]),
        # What depends on other layers is theirs to tell.
        (typed("Settings", "rel camera = </World/other>"), []),
        (typed("Product", "uniform int2 resolution = (9, 5)"), []),
        (typed("Var", 'uniform string sourceName = "C<RD>L"'), []),
        (over("S", "uniform int2 resolutoin = (9, 5)\n"), []),  # of whatever type
    ],
)
def test_an_override_that_says_its_type_is_judged_by_what_it_says(
    override: str, rules: list[str]
) -> None:
    assert told(over("Render", override)) == rules
