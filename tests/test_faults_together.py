"""Faults that meet, and those that stand on a camera: none hides another one, none is told twice."""

from __future__ import annotations

import pytest

from usdrender_lint.testing import lint_files

STAGE = """#usda 1.0
(
    renderSettingsPrimPath = "/Render/S"
    startTimeCode = 1
    endTimeCode = 2
)
def Scope "Render"
{
    def RenderSettings "S"
    {
        %s
    }
    def RenderProduct "Beauty"
    {
        %s
    }
    def RenderVar "Color"
    {
        %s
    }
    def RenderVar "Id"
    {
        uniform token dataType = "int"
        uniform string sourceName = "id"
    }
}
def Xform "shot"
{
    def Xform "cameras"
    {
        def Camera "cam1"
        {
            %s
        }
    }
}
"""
SETTINGS = """rel camera = </shot/cameras/cam1>
        rel products = </Render/Beauty>"""
PRODUCT = """rel orderedVars = </Render/Color>
        token productName.timeSamples = { 1: "/o/a.1.exr", 2: "/o/a.2.exr" }"""
VAR = 'uniform string sourceName = "Ci"'


def told(
    settings: str = SETTINGS, product: str = PRODUCT, var: str = VAR, camera: str = ""
) -> list[str]:
    report, marks = lint_files({"main.usda": STAGE % (settings, product, var, camera)})
    assert report.problems == ()
    return sorted(m.rule for m in marks if m.severity != "note")


def test_the_stage_is_right() -> None:
    assert told() == []


# -- one fault behind another


@pytest.mark.parametrize(
    ("body", "rule"),
    [
        ("float2 clippingRange = (100, 1)", "invalid-clipping-range"),
        ("float focalLength = 0", "invalid-camera-lens"),
        ("double shutter:open = 1", "inverted-shutter"),
    ],
)
def test_a_camera_that_only_a_spec_tells_of_is_judged_too(body: str, rule: str) -> None:
    """The misspelt target leads elsewhere in the scene: the mask does not hold the camera."""
    settings = SETTINGS.replace("/shot/cameras/cam1", "/cameras/cam1")
    assert told(settings, camera=body) == sorted([rule, "unresolved-target"])


def test_a_camera_of_another_name_is_not_judged() -> None:
    settings = SETTINGS.replace("/shot/cameras/cam1", "/cameras/left")
    assert told(settings, camera="float focalLength = 0") == ["unresolved-target"]


@pytest.mark.parametrize(
    ("name", "rule"),
    [
        ("$SHOT/a.exr", "nonportable-product-name"),
        ("/o/a.exr", "static-product-name"),
        ("/o/a.####.doc", "unsupported-extension"),
    ],
)
def test_the_name_of_a_product_behind_a_misspelt_target(name: str, rule: str) -> None:
    settings = SETTINGS.replace("/Render/Beauty", "/Render/Beaty")
    product = f'rel orderedVars = </Render/Color>\n        token productName = "{name}"'
    assert told(settings, product) == sorted([rule, "unresolved-target"])


@pytest.mark.parametrize(
    ("var", "rule"),
    [
        ("", "empty-source-name"),
        ('uniform string sourceName = "depth"', "data-type-mismatch"),
    ],
)
def test_a_var_behind_a_misspelt_target(var: str, rule: str) -> None:
    product = PRODUCT.replace("</Render/Color>", "[</Render/Colour>, </Render/Id>]")
    assert told(product=product, var=var) == sorted([rule, "unresolved-target"])


def test_a_product_of_another_name_is_not_taken_for_the_missing_one() -> None:
    """Only a target that is nearly its name, or the one that was meant, makes it a product in use."""
    settings = SETTINGS.replace("/Render/Beauty", "/Render/Crypto")
    product = 'rel orderedVars = </Render/Color>\n        token productName = "/o/a.exr"'
    assert told(settings, product) == ["unresolved-target"]


@pytest.mark.parametrize(
    "target", ["</shot>", "</shot/cameras>", "</shot/cameras/cam1.focalLength>", "</Render/Id>"]
)
def test_the_only_camera_behind_a_target_of_another_type(target: str) -> None:
    settings = SETTINGS.replace("</shot/cameras/cam1>", target)
    assert told(settings, camera="float focalLength = 0") == [
        "invalid-camera-lens",
        "wrong-target-type",
    ]


@pytest.mark.parametrize(
    ("line", "rule"),
    [
        ("rel product = </Render/Beauty>", "misspelled-property"),
        ('token[] products = ["/Render/Beauty"]', "kind-mismatch"),
    ],
)
def test_the_name_of_a_product_whose_list_was_lost(line: str, rule: str) -> None:
    settings = f"rel camera = </shot/cameras/cam1>\n        {line}"
    product = 'rel orderedVars = </Render/Color>\n        token productName = "$A/a.exr"'
    assert told(settings, product) == sorted([rule, "nonportable-product-name"])


def test_the_name_of_a_product_that_nobody_lists_is_not_judged() -> None:
    product = 'rel orderedVars = </Render/Color>\n        token productName = "$A/a.exr"'
    assert told("rel camera = </shot/cameras/cam1>", product) == []


def test_a_var_whose_list_is_misspelt() -> None:
    product = PRODUCT.replace("orderedVars", "orderedvars")
    assert told(product=product, var="") == ["empty-source-name", "misspelled-property"]


@pytest.mark.parametrize("source", ["</Render/T>", "<Render/S>"])
def test_a_pass_prunes_the_camera_whatever_its_source_is_called(source: str) -> None:
    render_pass = f"""
    def RenderPass "A"
    {{
        rel renderSource = {source}
        rel collection:prune:includes = </shot>
    }}
    def RenderVar "Id\""""
    main = (STAGE % (SETTINGS, PRODUCT, VAR, "")).replace('\n    def RenderVar "Id"', render_pass)
    _, marks = lint_files({"main.usda": main})
    assert "prune-removes-camera" in {m.rule for m in marks}


MISSING_LAYER = "(\n    subLayers = [@./nowhere.usda@]\n"


@pytest.mark.parametrize(
    ("old", "new", "rule"),
    [
        (
            "rel camera = </shot/cameras/cam1>",
            "rel camera = </shot/cameras/cam>",
            "unresolved-target",
        ),
        ("</Render/Beauty>", "</Render/Beaty>", "unresolved-target"),
        ("</Render/Color>", "</Render/Colour>", "unresolved-target"),
        ('"/Render/S"', '"/Render/s"', "default-settings-unresolved"),
    ],
)
def test_what_is_probably_misspelt_is_noted_where_a_layer_is_missing(
    old: str, new: str, rule: str
) -> None:
    """The layer may bring it: so that is no error. But it does not hide what anybody can see."""
    main = (STAGE % (SETTINGS, PRODUCT, VAR, "")).replace("(\n", MISSING_LAYER, 1)
    _, before = lint_files({"main.usda": main})
    assert [m.rule for m in before if m.severity != "note"] == ["composition-error"]
    _, after = lint_files({"main.usda": main.replace(old, new)})
    assert {(m.rule, m.severity) for m in after} - {(m.rule, m.severity) for m in before} == {
        (rule, "note")
    }


def test_what_is_like_nothing_here_is_in_the_missing_layer() -> None:
    main = (STAGE % (SETTINGS, PRODUCT, VAR, "")).replace("(\n", MISSING_LAYER, 1)
    _, marks = lint_files({"main.usda": main.replace("/shot/cameras/cam1>", "/cameras/main>")})
    assert "unresolved-target" not in {m.rule for m in marks}


# -- one fault, once


def test_a_type_that_is_written_as_another_one() -> None:
    var = 'string dataType = "float"\n        uniform string sourceName = "depth"'
    assert told(var=var) == ["type-mismatch"]


def test_a_misspelt_product_type_is_not_told_for_husk_again() -> None:
    product = PRODUCT + '\n        token productType = "rasterr"'
    var = VAR + (
        '\n        custom string driver:parameters:aov:name = "C"'
        '\n        custom token driver:parameters:aov:format = "color3f"'
        "\n        custom int karma:x = 1"
    )
    var = var.replace('"Ci"', '"C.*"') + '\n        uniform token sourceType = "lpe"'
    assert told(product=product, var=var) == ["unknown-product-type"]


# -- no fault


@pytest.mark.parametrize("token", ["####", "{frame:04d}", "%04d", "$F4"])
def test_a_frame_token_on_a_stage_for_several_renderers(token: str) -> None:
    """Karma and V-Ray know their own tokens; that does not make the others plain text."""
    product = f'''rel orderedVars = </Render/Color>
        token productName = "/o/a.{token}.exr"'''
    settings = (
        SETTINGS + "\n        int karma:a = 1\n        int arnold:b = 1\n        int ri:c = 1"
    )
    assert told(settings, product) == []


def severity(settings: str, var: str = VAR) -> dict[str, str]:
    _, marks = lint_files({"main.usda": STAGE % (settings, PRODUCT, var, "")})
    return {m.rule: m.severity for m in marks}


@pytest.mark.parametrize(("attribute", "expected"), [("karma:a", "note"), ("ri:a", "warning")])
def test_karma_reads_the_deprecated_flag(attribute: str, expected: str) -> None:
    settings = f"{SETTINGS}\n        int {attribute} = 1\n        bool instantaneousShutter = 1"
    assert severity(settings)["deprecated-instantaneous-shutter"] == expected


def test_the_format_that_husk_is_to_be_told_is_one_that_it_knows() -> None:
    """What is written as the type of the pixel may be misspelt itself."""
    var = 'uniform token dataType = "color4"\n        string driver:parameters:aov:name = "C"'
    report, _ = lint_files(
        {"main.usda": STAGE % (SETTINGS + "\n        int karma:a = 1", PRODUCT, var, "")}
    )
    (finding,) = [f for f in report.findings if f.rule.id == "karma-incomplete-var"]
    assert finding.help == 'author custom token driver:parameters:aov:format = "color3f"'


# -- what is wrong with a camera


@pytest.mark.parametrize(
    ("body", "rule"),
    [
        ('string focalLength = "35"', "type-mismatch"),
        ("double horizontalAperture = 35", "type-mismatch"),
        ("float3 clippingRange = (1, 2, 3)", "type-mismatch"),
        ("float focallength = 35", "misspelled-property"),
        ('token projection = "ortho"', "disallowed-token"),
        ('token projection = "Perspective"', "disallowed-token"),
        ("float horizontalApeture = 35", "misspelled-property"),
    ],
)
def test_a_camera_is_held_against_its_schema(body: str, rule: str) -> None:
    assert told(camera=body) == [rule]


@pytest.mark.parametrize(
    "body",
    [
        "float cameraAperture = 35",
        'token projection = "orthographic"',
        "token projection = None",
        "float focalLengthX = 35",
        "float fthetaWidth = 35",
        "custom float houdini:focallength = 35",
        "custom int2 resolution = (3, 4)",
        'token cameraProjectionType = "pinhole"',
    ],
)
def test_what_others_say_of_a_camera_is_theirs(body: str) -> None:
    assert told(camera=body) == []


@pytest.mark.parametrize("name", ["Cam", "camera", "Cameras", "UsdGeomCamera", "Camrea"])
def test_a_camera_of_a_misspelt_type(name: str) -> None:
    """USD takes it for a type of a plug-in that is not here."""
    main = (STAGE % (SETTINGS, PRODUCT, VAR, "")).replace("def Camera", f"def {name}")
    _, marks = lint_files({"main.usda": main})
    assert [(m.rule, m.severity, m.line) for m in marks if m.severity != "note"] == [
        ("wrong-target-type", "error", 33)
    ]


@pytest.mark.parametrize("name", ["OmniLidar", "VRayCamera", "CameraRig"])
def test_a_camera_of_a_renderers_own_type(name: str) -> None:
    main = (STAGE % (SETTINGS, PRODUCT, VAR, "")).replace("def Camera", f"def {name}")
    _, marks = lint_files({"main.usda": main})
    assert [m.rule for m in marks if m.severity != "note"] == []


# -- what a var holds


@pytest.mark.parametrize(
    ("kind", "source", "rules"),
    [
        ("float", "Ci", ["data-type-mismatch"]),
        ("int", "RGBA", ["data-type-mismatch"]),
        ("half3", "Ci", []),
        ("float", "N", ["data-type-mismatch"]),
        ("float", "crypto_asset", []),
        ("float", "  ", ["empty-source-name"]),
    ],
)
def test_a_color_is_more_than_one_number(kind: str, source: str, rules: list[str]) -> None:
    var = f'uniform token dataType = "{kind}"\n        uniform string sourceName = "{source}"'
    assert told(var=var) == rules


# -- whose settings they are


@pytest.mark.parametrize(
    ("namespace", "noted"),
    [
        ("kamra", True),
        ("arnnold", True),
        ("Ri", True),
        ("rig", False),
        ("ray", False),
        ("x", False),
    ],
)
def test_a_misspelt_namespace_is_noted(namespace: str, noted: bool) -> None:
    assert ("unknown-namespace" in severity(f"{SETTINGS}\n        int {namespace}:a = 1")) is noted


@pytest.mark.parametrize(
    ("line", "noted"),
    [
        ('renderSettingPrimPath = "/Render/T"', True),
        ('customLayerData = { string renderSettingsPath = "/Render/T" }', True),
        ('customLayerData = { string renderSettingsPrimPath = "/Render/S" }', False),
    ],
)
def test_a_misspelt_key_beside_the_right_one_is_noted(line: str, noted: bool) -> None:
    """It changes nothing, and may be the one that was meant."""
    main = (STAGE % (SETTINGS, PRODUCT, VAR, "")).replace("(\n", f"(\n    {line}\n", 1)
    _, marks = lint_files({"main.usda": main})
    assert [m.severity for m in marks if m.rule == "default-settings-misspelled"] == [
        "note"
    ] * noted
