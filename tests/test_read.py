"""Does the model say what USD, and a renderer after it, makes of a stage?"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from pxr import Sdf, Usd

from usdrender_lint.crate import mentions
from usdrender_lint.diagnostics import Diagnostics
from usdrender_lint.model import (
    EXTERNAL_CAMERA,
    INCLUDE_AOVS,
    Attr,
    Candidate,
    Output,
    Rel,
    RenderScope,
    State,
    ValueState,
    Var,
)
from usdrender_lint.opening import open_layer
from usdrender_lint.read import read, strays
from usdrender_lint.read.text import Texts
from usdrender_lint.renderers import choose
from usdrender_lint.run import subjects_of
from usdrender_lint.stage import Opened, open_stage

Layers = dict[str, str]
Read = Callable[..., RenderScope]

SETTINGS = "/Render/S"
CAMERAS = """
def Xform "World" {
    def Camera "cam" {
    }
    def Camera "other" {
    }
    def Xform "rig" {
        def Camera "cam_left" {
        }
    }
}
"""


def usda(text: str) -> str:
    return text if text.startswith("#usda") else f"#usda 1.0\n{text}"


def opened(folder: Path, main: str, layers: Layers) -> Opened:
    for name, text in {"main.usda": main, **layers}.items():
        file = folder / name
        file.write_text(usda(text), "utf-8")
        if file.suffix == ".usdc":
            text_file = file.with_suffix(".tmp.usda")
            text_file.write_text(usda(text), "utf-8")
            assert Sdf.Layer.FindOrOpen(str(text_file)).Export(str(file))
            text_file.unlink()
    layer = open_layer(str(folder / "main.usda"))
    assert isinstance(layer, Sdf.Layer), layer
    return open_stage(layer, ("/Render",))


@pytest.fixture
def scope(tmp_path: Path) -> Read:
    """Reads the stage of `main`; further layers by name, a `.usdc` is written as a crate."""

    def read_scope(main: str, layers: Layers | None = None) -> RenderScope:
        with Diagnostics():
            return read(opened(tmp_path, main, layers or {}), Texts())

    return read_scope


def render(settings: str = "", product: str = "", more: str = "") -> str:
    """The settings S that list the product P, in the scope."""
    return (
        'def Scope "Render" {\n'
        f'    def RenderSettings "S" {{\n        rel products = </Render/P>\n        {settings}\n    }}\n'
        f'    def RenderProduct "P" {{\n        {product}\n    }}\n    {more}\n}}\n'
    )


def the_output(scope: RenderScope) -> Output:
    (settings,) = scope.settings
    (output,) = settings.outputs
    return output


def rel_of(scope: RenderScope, path: str, name: str) -> Rel:
    return next(r for p in scope.prims() if p.path == path for r in p.rels if r.name == name)


def states(rel: Rel) -> dict[str, State]:
    return {t.path: t.state for t in rel.targets}


# (USD's name, the model's, type, fallback, two values as written and as read, another type's, empty)
BASE: list[tuple[str, str, str, Any, tuple[str, Any], tuple[str, Any], str, Any]] = [
    ("resolution", "resolution", "int2", (2048, 1080), ("(4, 2)", (4, 2)), ("(8, 4)", (8, 4)),
     'string X = "8x4"', (0, 0)),
    ("pixelAspectRatio", "pixel_aspect_ratio", "float", 1.0, ("2", 2.0), ("3", 3.0),
     "double X = 3", 0.0),
    ("aspectRatioConformPolicy", "aspect_ratio_conform_policy", "token", "expandAperture",
     ('"cropAperture"', "cropAperture"), ('"adjustApertureWidth"', "adjustApertureWidth"),
     'string X = "cropAperture"', ""),
    ("dataWindowNDC", "data_window_ndc", "float4", (0.0, 0.0, 1.0, 1.0),
     ("(0, 0, 0.5, 1)", (0.0, 0.0, 0.5, 1.0)), ("(0, 0, 2, 2)", (0.0, 0.0, 2.0, 2.0)),
     "double4 X = (0, 0, 2, 2)", (0.0, 0.0, 0.0, 0.0)),
    ("disableMotionBlur", "disable_motion_blur", "bool", False, ("1", True), ("0", False),
     "int X = 1", False),
    ("disableDepthOfField", "disable_depth_of_field", "bool", False, ("1", True), ("0", False),
     "int X = 1", False),
]  # fmt: skip


@pytest.mark.parametrize("base", BASE, ids=[b[0] for b in BASE])
class TestEffectiveValue:
    """RULES.md, 4: the settings' values unless the product authors its own."""

    def effective(
        self, scope: Read, base: tuple[Any, ...], settings: str, product: str
    ) -> Attr[Any]:
        name, field, kind = base[:3]
        blocked, sampled = (
            f"{kind} {name} = None",
            f"{kind} {name}.timeSamples = {{ 1: {base[5][0]} }}",
        )
        forms = {
            "nothing": "",
            "one": f"{kind} {name} = {base[4][0]}",
            "other": f"{kind} {name} = {base[5][0]}",
            "declared": f"{kind} {name}",
            "blocked": blocked,
            "sampled": sampled,
            "mistyped": base[6].replace("X", name),
            "as a relationship": f"rel {name} = </World/cam>",
        }
        output = the_output(scope(render(forms[settings], forms[product])))
        found: Attr[Any] = getattr(output, field)
        return found

    @pytest.mark.parametrize(
        ("settings", "product", "from_product", "state"),
        [
            ("nothing", "nothing", False, ValueState.FALLBACK),
            ("one", "nothing", False, ValueState.AUTHORED),
            ("nothing", "one", True, ValueState.AUTHORED),
            ("one", "other", True, ValueState.AUTHORED),
            ("one", "declared", False, ValueState.AUTHORED),
            ("one", "blocked", False, ValueState.AUTHORED),
            ("one", "as a relationship", False, ValueState.AUTHORED),
            ("one", "sampled", True, ValueState.SAMPLED),
            ("one", "mistyped", True, ValueState.MISTYPED),
            ("nothing", "sampled", True, ValueState.SAMPLED),
            ("blocked", "nothing", False, ValueState.BLOCKED),
            ("blocked", "blocked", False, ValueState.BLOCKED),
            ("blocked", "one", True, ValueState.AUTHORED),
            ("sampled", "nothing", False, ValueState.SAMPLED),
            ("sampled", "blocked", False, ValueState.SAMPLED),
            ("mistyped", "nothing", False, ValueState.MISTYPED),
            ("as a relationship", "nothing", False, ValueState.FALLBACK),
        ],
    )
    def test_of(
        self,
        scope: Read,
        base: tuple[Any, ...],
        settings: str,
        product: str,
        from_product: bool,
        state: ValueState,
    ) -> None:
        found = self.effective(scope, base, settings, product)
        authored = {"one": base[4][1], "other": base[5][1], "blocked": base[7]}
        owner, form = ("/Render/P", product) if from_product else (SETTINGS, settings)
        assert found.value == authored.get(form, base[3])
        assert found.state is state
        assert found.site.prim_path == owner

    def test_one_equal_to_the_fallback_overrides(self, scope: Read, base: tuple[Any, ...]) -> None:
        name, field, kind, fallback = base[:4]
        written = f'"{fallback}"' if kind == "token" else str(fallback).replace("False", "0")
        output = the_output(
            scope(render(f"{kind} {name} = {base[4][0]}", f"{kind} {name} = {written}"))
        )
        assert getattr(output, field).value == fallback
        assert getattr(output, field).site.prim_path == "/Render/P"


class TestAttr:
    def over(self, scope: Read, strong: str, weak: str) -> Attr[tuple[int, int]]:
        found = scope(
            f'(\n    subLayers = [@weak.usda@]\n)\nover "S" {{\n    {strong}\n}}\n',
            {"weak.usda": f'def RenderSettings "S" {{\n    {weak}\n}}\n'},
        )
        return found.settings[0].resolution

    @pytest.mark.parametrize(
        ("strong", "weak", "value", "state"),
        [
            ("int2 resolution = (1, 1)", "int2 resolution = (2, 2)", (1, 1), "authored"),
            ("int2 resolution", "int2 resolution = (2, 2)", (2, 2), "authored"),
            ("int2 resolution = None", "int2 resolution = (2, 2)", (0, 0), "blocked"),
            ("int2 resolution = AnimationBlock", "int2 resolution = (2, 2)", (2, 2), "authored"),
            ("int2 resolution = AnimationBlock", "", (2048, 1080), "fallback"),
            ("float2 resolution = (1, 1)", "int2 resolution = (2, 2)", (2, 2), "mistyped"),
            ("int2 resolution = (1, 1)", "float2 resolution = (2, 2)", (1, 1), "authored"),
            ("rel resolution = </C>", "int2 resolution = (2, 2)", (2, 2), "authored"),
            (
                "int2 resolution.timeSamples = { 1: (1, 1) }",
                "int2 resolution = (2, 2)",
                (2, 2),
                "authored",
            ),
            (
                "int2 resolution = (1, 1)",
                "int2 resolution.timeSamples = { 1: (2, 2) }",
                (1, 1),
                "authored",
            ),
            ("", "int2 resolution.timeSamples = { 1: (2, 2) }", (2048, 1080), "sampled"),
        ],
    )
    def test_of_two_layers(
        self, scope: Read, strong: str, weak: str, value: tuple[int, int], state: str
    ) -> None:
        found = self.over(scope, strong, weak)
        assert (found.value, found.state) == (value, state)

    def test_blocks_and_fallbacks_are_not_authored(self, scope: Read) -> None:
        assert not self.over(scope, "int2 resolution = None", "").authored
        assert not self.over(scope, "int2 resolution", "").authored

    def test_a_spline_reads_as_samples_do(self, scope: Read) -> None:
        found = scope(render("float pixelAspectRatio.spline = { bezier, 1: 3 }"))
        ratio = found.settings[0].pixel_aspect_ratio
        assert (ratio.value, ratio.state, ratio.site.field) == (1.0, ValueState.SAMPLED, "spline")

    def test_the_site_of_samples_is_their_field(self, scope: Read) -> None:
        found = self.over(scope, "int2 resolution.timeSamples = { 1: (1, 1) }", "")
        assert found.site.field == "timeSamples"

    def test_types_that_differ_in_role_only_are_read(self, scope: Read) -> None:
        window = scope(render("color4f dataWindowNDC = (0, 0, 2, 2)")).settings[0].data_window_ndc
        assert (window.value, window.state) == ((0.0, 0.0, 2.0, 2.0), ValueState.AUTHORED)

    def test_the_samples_of_a_product_name_are_kept(self, scope: Read) -> None:
        (product,) = scope(
            render(product='token productName.timeSamples = { 1: "a.0001", 2: None, 3: "a.0003" }')
        ).products
        assert product.product_name.samples == ((1.0, "a.0001"), (3.0, "a.0003"))
        assert product.product_name.value == ""
        assert product.first_name == "a.0001"

    @pytest.mark.parametrize(
        ("statement", "field", "value"),
        [
            ("token[] includedPurposes = None", "included_purposes", ()),
            ("token[] includedPurposes = []", "included_purposes", ()),
            ("", "included_purposes", ("default", "render")),
            ("", "material_binding_purposes", ("full", "")),
            ('token renderingColorSpace = "raw"', "rendering_color_space", "raw"),
            ("", "rendering_color_space", ""),
        ],
    )
    def test_values_of_settings_alone(
        self, scope: Read, statement: str, field: str, value: object
    ) -> None:
        assert getattr(scope(render(statement)).settings[0], field).value == value

    @pytest.mark.parametrize(
        ("written", "known"), [("color3f", True), ("rgb", False), ("float[]", True)]
    )
    def test_a_data_type_is_a_value_type_of_usd_or_not(
        self, scope: Read, written: str, known: bool
    ) -> None:
        var = f'def RenderVar "v" {{\n        token dataType = "{written}"\n    }}'
        assert scope(render(more=var)).vars[0].data_type_known is known


class TestExtras:
    def test_of_a_var_all_of_others_what_rules_ask_for(self, scope: Read) -> None:
        said = 'custom bool includeAovs = 1\n        string karma:note = "x"'
        var = f'def RenderVar "V" {{\n        {said}\n    }}'
        found = scope(render(f'string {EXTERNAL_CAMERA} = "persp"\n        {said}', said, var))
        assert {p.path: [(e.name, e.value) for e in p.extras] for p in found.prims()} == {
            "/Render/S": [(EXTERNAL_CAMERA, "persp"), (INCLUDE_AOVS, "true")],
            "/Render/P": [(INCLUDE_AOVS, "true")],
            "/Render/V": [(INCLUDE_AOVS, "true"), ("karma:note", "x")],
        }


class TestOutputs:
    @pytest.mark.parametrize(
        ("settings", "product", "camera"),
        [
            ("", "", ()),
            ("rel camera = </World/cam>", "", ("/World/cam",)),
            ("", "rel camera = </World/other>", ("/World/other",)),
            ("rel camera = </World/cam>", "rel camera = </World/other>", ("/World/other",)),
            ("rel camera = </World/cam>", "rel camera = </World/no>", ("/World/no",)),
            ("rel camera = </World/cam>", "rel camera = </World>", ("/World",)),
            ("rel camera = </World/cam>", "rel camera = []", ("/World/cam",)),
            ("rel camera = </World/cam>", "rel camera = None", ("/World/cam",)),
            ("rel camera = </World/cam>", "rel camera", ("/World/cam",)),
            ("rel camera = </World/cam>", 'string camera = "/World/other"', ("/World/cam",)),
            ("rel camera = </World/cam>", "rel camera = </Render/S.camera>", ("/World/cam",)),
            ("rel camera = </World/cam>", "rel camera = </Render/P.camera>", ("/World/cam",)),
            ('string camera = "/World/cam"', "", ()),
        ],
    )
    def test_camera(
        self, scope: Read, settings: str, product: str, camera: tuple[str, ...]
    ) -> None:
        output = the_output(scope(render(settings, product) + CAMERAS))
        assert tuple(t.path for t in output.camera.targets) == camera

    def test_a_camera_that_a_reference_drops_leaves_the_settings(self, scope: Read) -> None:
        found = scope(
            'def Scope "Render" {\n    def RenderSettings "S" {\n'
            "        rel camera = </World/cam>\n        rel products = </Render/P>\n    }\n"
            '    def RenderProduct "P" (\n        references = @p.usda@</P>\n    ) {\n    }\n}\n'
            + CAMERAS,
            {"p.usda": 'def RenderProduct "P" {\n    rel camera = </World/other>\n}\n'},
        )
        assert [t.path for t in the_output(found).camera.targets] == ["/World/cam"]
        assert [x.path for x in the_output(found).product.camera.lost] == ["/World/other"]

    def test_products_in_order_and_only_products(self, scope: Read) -> None:
        (settings,) = scope(
            'def Scope "Render" {\n    def RenderSettings "S" {\n        rel products = ['
            "</Render/B>, </Render/V>, </Nowhere>, </Render/A>, </Render/S.more>]\n"
            "        rel more = [</Render/C>, </Render/B>]\n    }\n"
            '    def RenderProduct "A" {\n    }\n    def RenderProduct "B" {\n    }\n'
            '    def RenderProduct "C" {\n    }\n    def RenderVar "V" {\n    }\n}\n'
        ).settings
        assert [o.product.name for o in settings.outputs] == ["B", "A", "C"]
        assert {o.settings for o in settings.outputs} == {SETTINGS}

    def test_vars_in_order_and_only_vars(self, scope: Read) -> None:
        names = "".join(f'    def RenderVar "{n}" {{\n    }}\n' for n in "abc")
        output = the_output(
            scope(
                render(
                    product="rel orderedVars = [</Render/c>, </Render/P>, </Nowhere>, </Render/a>]",
                    more=names,
                )
            )
        )
        assert [v.name for v in output.vars] == ["c", "a"]

    def test_one_product_of_two_settings_is_two_outputs(self, scope: Read) -> None:
        other = 'def RenderSettings "T" {\n        rel products = </Render/P>\n        int2 resolution = (4, 2)\n    }'
        found = scope(render("int2 resolution = (8, 4)", more=other)).settings
        assert [s.outputs[0].resolution.value for s in found] == [(8, 4), (4, 2)]


class TestState:
    @pytest.mark.parametrize(
        ("world", "state", "because"),
        [
            ('def Camera "C" {\n}\n', State.LIVE, None),
            ('def "Z" {\n}\n', State.MISSING, None),
            ('def Camera "C" (\n    active = false\n) {\n}\n', State.INACTIVE, None),
            ('over Camera "C" {\n}\n', State.OVER, None),
            ('over "C" {\n}\n', State.OVER, None),
            ('class Camera "C" {\n}\n', State.ABSTRACT, None),
        ],
    )
    def test_of_a_target(self, scope: Read, world: str, state: State, because: str | None) -> None:
        found = scope(render("rel camera = </C>") + world)
        (target,) = rel_of(found, SETTINGS, "camera").targets
        assert (target.state, target.because) == (state, because)
        assert ("Camera" in target.isa) is ("Camera" in world)

    @pytest.mark.parametrize(
        ("above", "state", "because"),
        [
            ('def "A" {\n', State.LIVE, None),
            ('class "A" {\n', State.ABSTRACT, None),
            ('over "A" {\n', State.OVER, None),
            ('def "A" (\n    active = false\n) {\n', State.INACTIVE, "/A"),
        ],
    )
    def test_of_a_target_comes_from_above_too(
        self, scope: Read, above: str, state: State, because: str | None
    ) -> None:
        camera = '    def "B" {\n        def Camera "C" {\n        }\n    }\n}\n'
        found = scope(render("rel camera = </A/B/C>") + above + camera)
        (target,) = rel_of(found, SETTINGS, "camera").targets
        assert (target.state, target.because) == (state, because)
        assert target.type_name == "Camera"

    def test_what_an_inactive_prim_does_not_hold_is_missing(self, scope: Read) -> None:
        found = scope(render("rel camera = </A/C>") + 'def "A" (\n    active = false\n) {\n}\n')
        assert states(rel_of(found, SETTINGS, "camera")) == {"/A/C": State.MISSING}

    def test_below_an_inactive_reference_the_specs_of_its_layer_tell(self, scope: Read) -> None:
        found = scope(
            render("rel camera = </A/C>")
            + 'def "A" (\n    active = false\n    references = @set.usda@</Set>\n) {\n}\n',
            {"set.usda": 'def "Set" {\n    def Camera "C" {\n    }\n}\n'},
        )
        (target,) = rel_of(found, SETTINGS, "camera").targets
        assert (target.state, target.because, target.type_name) == (State.INACTIVE, "/A", "Camera")

    @pytest.mark.parametrize(
        ("arc", "asset"),
        [("references", "@no.usda@"), ("payload", "@no.usda@"), ("references", "@no.usda@</X>")],
    )
    def test_behind_an_arc_that_does_not_open_it_is_unknown(
        self, scope: Read, arc: str, asset: str
    ) -> None:
        found = scope(
            render("rel camera = [</A/B/C>, </Z/C>]")
            + f'def "A" (\n    {arc} = {asset}\n) {{\n}}\ndef "Z" {{\n}}\n'
        )
        camera = rel_of(found, SETTINGS, "camera")
        assert states(camera) == {"/A/B/C": State.UNKNOWN, "/Z/C": State.MISSING}
        assert camera.targets[0].because == "no.usda"

    def test_behind_a_sublayer_that_does_not_open_everything_missing_is_unknown(
        self, scope: Read
    ) -> None:
        found = scope(
            "(\n    subLayers = [@no.usda@]\n)\n"
            + render("rel camera = [</Z/C>, </World/cam>]")
            + CAMERAS
        )
        assert states(rel_of(found, SETTINGS, "camera")) == {
            "/Z/C": State.UNKNOWN,
            "/World/cam": State.LIVE,
        }

    def test_behind_a_layer_that_does_not_parse_it_is_unknown(self, scope: Read) -> None:
        found = scope(
            render("rel camera = </A/C>") + 'def "A" (\n    references = @bad.usda@\n) {\n}\n',
            {"bad.usda": "def {"},
        )
        assert states(rel_of(found, SETTINGS, "camera")) == {"/A/C": State.UNKNOWN}

    @pytest.mark.parametrize("over", ['over "C" {\n}\n', 'def "C" {\n}\n'])
    def test_a_prim_whose_reference_does_not_open_may_be_more_than_it_seems(
        self, scope: Read, over: str
    ) -> None:
        found = scope(
            render("rel camera = </C>") + over.replace("{", "(\n    references = @no.usda@\n) {", 1)
        )
        assert states(rel_of(found, SETTINGS, "camera")) == {"/C": State.UNKNOWN}

    def test_a_typed_prim_is_what_it_is_whatever_its_reference(self, scope: Read) -> None:
        found = scope(
            render("rel camera = </C>") + 'def Camera "C" (\n    references = @no.usda@\n) {\n}\n'
        )
        assert states(rel_of(found, SETTINGS, "camera")) == {"/C": State.LIVE}

    @pytest.mark.parametrize(
        ("path", "state", "is_property"),
        [
            ("/Render/A.nuke:writeNode", State.LIVE, True),
            ("/Render/A.nuke:other", State.MISSING, True),
            ("/Render/Z.nuke:writeNode", State.MISSING, True),
        ],
    )
    def test_of_a_property(self, scope: Read, path: str, state: State, is_property: bool) -> None:
        found = scope(
            'def Scope "Render" {\n    def RenderPass "A" {\n'
            f'        string nuke:writeNode = "W"\n        rel renderSource = <{path}>\n    }}\n}}\n'
        )
        (target,) = rel_of(found, "/Render/A", "renderSource").targets
        assert (target.state, target.is_property) == (state, is_property)

    def test_of_a_type_that_no_schema_registers(self, scope: Read) -> None:
        found = scope(render("rel camera = </C>") + 'def OmniLidar "C" {\n}\n')
        (target,) = rel_of(found, SETTINGS, "camera").targets
        assert (target.state, target.type_name, target.type_known) == (
            State.LIVE,
            "OmniLidar",
            False,
        )
        assert target.isa == frozenset()

    def test_of_render_prims_themselves(self, scope: Read) -> None:
        found = scope(
            'def Scope "Render" {\n    def RenderVar "live" {\n    }\n'
            '    def RenderVar "off" (\n        active = false\n    ) {\n    }\n'
            '    over RenderVar "undefined" {\n    }\n    class RenderVar "abstract" {\n    }\n}\n'
        )
        assert {v.name: v.state for v in found.vars} == {
            "live": State.LIVE,
            "off": State.INACTIVE,
            "undefined": State.OVER,
            "abstract": State.ABSTRACT,
        }

    def test_through_an_instance_a_target_is_live(self, scope: Read) -> None:
        found = scope(
            render("rel camera = </B/C>")
            + "".join(
                f'def "{n}" (\n    instanceable = true\n    references = </_Set>\n) {{\n}}\n'
                for n in "AB"
            )
            + 'class "_Set" {\n    def Camera "C" {\n    }\n}\n'
        )
        assert states(rel_of(found, SETTINGS, "camera")) == {"/B/C": State.LIVE}


class TestForwarding:
    def camera(self, scope: Read, more: str) -> Rel:
        found = scope(render(f"rel camera = </Render/S.a>\n        {more}") + CAMERAS)
        return rel_of(found, SETTINGS, "camera")

    @pytest.mark.parametrize(
        ("more", "targets"),
        [
            ("rel a = </World/cam>", {"/World/cam": "a"}),
            ("rel a = </Render/S.b>; rel b = </World/cam>", {"/World/cam": "b"}),
            (
                "rel a = [</World/other>, </Render/S.b>]; rel b = </World/cam>",
                {"/World/other": "a", "/World/cam": "b"},
            ),
            ("rel a = []", {}),
            ("rel a", {}),
            ("rel a = </Render/S.a>", {}),
            ("rel a = </Render/S.b>; rel b = </Render/S.a>", {}),
            ("rel a = [</Render/S.a>, </World/cam>]", {"/World/cam": "a"}),
            ("rel a = </Render/S.camera>", {}),
            ("rel a = [</World/cam>, </Render/S.b>]; rel b = </World/cam>", {"/World/cam": "a"}),
            ('string a = "x"', {"/Render/S.a": ""}),
            ("", {"/Render/S.a": ""}),
        ],
    )
    def test_leads_where_usd_says_and_tells_the_way(
        self, scope: Read, tmp_path: Path, more: str, targets: dict[str, str]
    ) -> None:
        camera = self.camera(scope, more)
        assert {t.path: t.via[-1:] for t in camera.targets} == targets
        stage = Usd.Stage.Open(str(tmp_path / "main.usda"))
        forwarded = stage.GetRelationshipAtPath("/Render/S.camera").GetForwardedTargets()
        assert list(targets) == [str(p) for p in forwarded]

    def test_the_entry_that_began_the_chain_is_the_site(self, scope: Read) -> None:
        (target,) = self.camera(scope, "rel a = </World/cam>").targets
        assert (target.site.path, target.site.target) == ("/Render/S.camera", "/Render/S.a")

    def test_through_prims_that_have_to_be_populated_first(self, scope: Read) -> None:
        hops = "".join(
            f'def "H{n}" {{\n    rel next = </H{n + 1}.next>\n    def "deep" {{\n    }}\n}}\n'
            for n in range(5)
        )
        found = scope(
            render("rel camera = </H0.next>")
            + hops
            + 'def "H5" {\n    rel next = </World/cam>\n}\n'
            + CAMERAS
        )
        (target,) = rel_of(found, SETTINGS, "camera").targets
        assert (target.path, target.state, target.via) == ("/World/cam", State.LIVE, "/H5.next")

    def test_through_a_relationship_that_is_an_attribute_in_part(self, scope: Read) -> None:
        camera = self.camera(scope, "token a = </World/cam>".replace("</World/cam>", '"x"'))
        assert [t.is_property for t in camera.targets] == [True]


class TestRel:
    @pytest.mark.parametrize(
        ("statement", "authored", "as_attribute", "named"),
        [
            ("", False, False, False),
            ("rel camera", False, False, False),
            ("rel camera = None", True, False, False),
            ("rel camera = []", True, False, False),
            ("rel camera = </World/cam>", True, False, True),
            ('string camera = "/World/cam"', True, True, True),
        ],
    )
    def test_of_one_layer(
        self, scope: Read, statement: str, authored: bool, as_attribute: bool, named: bool
    ) -> None:
        camera = rel_of(scope(render(statement) + CAMERAS), SETTINGS, "camera")
        assert (camera.authored, camera.written_as_attribute, camera.named) == (
            authored,
            as_attribute,
            named,
        )

    def test_list_edits_of_several_layers(self, scope: Read) -> None:
        found = scope(
            "(\n    subLayers = [@a.usda@, @b.usda@]\n)\n"
            + 'over "Render" {\n    over "S" {\n        delete rel products = </Render/Q>\n    }\n}\n',
            {
                "a.usda": 'over "Render" {\n    over "S" {\n        prepend rel products = </Render/R>\n    }\n}\n',
                "b.usda": 'def "Render" {\n    def RenderSettings "S" {\n        rel products = [</Render/P>, </Render/Q>]\n    }\n}\n',
            },
        )
        assert list(states(rel_of(found, SETTINGS, "products"))) == ["/Render/R", "/Render/P"]


class TestLost:
    LAYERS: Layers = {  # noqa: RUF012
        "show.usda": 'def "Show" {\n    def RenderSettings "S" {\n'
        "        rel camera = </Cameras/main>\n"
        "        rel products = [</Show/P>, </Other/P>]\n    }\n"
        '    def RenderProduct "P" {\n    }\n}\n'
    }

    @pytest.mark.parametrize("arc", ["references", "payload"])
    def test_targets_that_an_arc_drops(self, scope: Read, arc: str, tmp_path: Path) -> None:
        found = scope(f'def "Render" (\n    {arc} = @show.usda@</Show>\n) {{\n}}\n', self.LAYERS)
        products = rel_of(found, SETTINGS, "products")
        assert [t.path for t in products.targets] == ["/Render/P"]
        (lost,) = products.lost
        assert (lost.path, lost.arc_prim) == ("/Other/P", "/Render")
        assert (lost.site.spec, lost.site.target) == ("/Show/S.products", "/Other/P")
        assert Path(lost.site.layer or "") == tmp_path / "show.usda"

    def test_what_a_stronger_list_replaces_is_no_loss(self, scope: Read) -> None:
        found = scope(
            'def "Render" (\n    references = @show.usda@</Show>\n) {\n'
            '    over "S" {\n        rel products = </Render/P>\n'
            "        prepend rel camera = </C>\n    }\n}\n",
            self.LAYERS,
        )
        assert rel_of(found, SETTINGS, "products").lost == ()
        assert [x.path for x in rel_of(found, SETTINGS, "camera").lost] == ["/Cameras/main"]

    def test_nothing_is_lost_to_inherits_within_a_layer(self, scope: Read) -> None:
        found = scope(
            'class RenderSettings "_base" {\n    rel camera = </World/cam>\n}\n'
            'def "Render" {\n    def RenderSettings "S" (\n        inherits = </_base>\n    ) {\n    }\n}\n'
            + CAMERAS
        )
        camera = rel_of(found, SETTINGS, "camera")
        assert (states(camera), camera.lost) == ({"/World/cam": State.LIVE}, ())


class TestCandidates:
    def camera(self, scope: Read, path: str, world: str) -> tuple[Candidate, ...]:
        found = scope(render(f"rel camera = <{path}>") + world)
        (target,) = rel_of(found, SETTINGS, "camera").targets
        return target.candidates

    @pytest.mark.parametrize(
        ("path", "first"),
        [
            ("/World/Cam", "/World/cam"),
            ("/World/othr", "/World/other"),
            ("/Elsewhere/other", "/World/other"),
            ("/World/rig", "/World/rig/cam_left"),
            ("/World/rig/cam_leftt", "/World/rig/cam_left"),
        ],
    )
    def test_the_best_comes_first(self, scope: Read, path: str, first: str) -> None:
        found = self.camera(scope, path, CAMERAS)
        assert found[0].path == first
        assert {c.type_name for c in found} == {"Camera"}
        assert len(found) == 3

    def test_only_prims_that_live(self, scope: Read) -> None:
        world = (
            'def Camera "cam_a" (\n    active = false\n) {\n}\nover Camera "cam_b" {\n}\n'
            'class Camera "cam_c" {\n}\ndef Xform "cam_d" {\n}\n'
        )
        assert self.camera(scope, "/cam_e", world) == ()

    def test_of_what_is_right_there_are_none(self, scope: Read) -> None:
        assert self.camera(scope, "/World/cam", CAMERAS) == ()

    def test_behind_a_failed_arc_nobody_guesses(self, scope: Read) -> None:
        world = CAMERAS + 'def "A" (\n    references = @no.usda@\n) {\n}\n'
        assert self.camera(scope, "/A/cam", world) == ()

    def test_cameras_of_a_reference_beside_what_is_missing(self, scope: Read) -> None:
        found = scope(
            render("rel camera = </Set/maincam>")
            + 'def "Set" (\n    references = @set.usda@</Set>\n) {\n}\n',
            {"set.usda": 'def "Set" {\n    def Camera "main_cam" {\n    }\n}\n'},
        )
        (target,) = rel_of(found, SETTINGS, "camera").targets
        assert [c.path for c in target.candidates] == ["/Set/main_cam"]

    @pytest.mark.parametrize(
        ("name", "written", "meant"),
        [
            ("products", "/Render/p", "/Render/P"),
            ("products", "/Render/S", "/Render/P"),
            ("products", "/Nowhere/P", "/Render/P"),
        ],
    )
    def test_products(self, scope: Read, name: str, written: str, meant: str) -> None:
        found = scope(
            f'def "Render" {{\n    def RenderSettings "S" {{\n        rel {name} = <{written}>\n    }}\n'
            '    def RenderProduct "P" {\n    }\n}\n'
        )
        (target,) = rel_of(found, SETTINGS, name).targets
        assert [c.path for c in target.candidates] == [meant]

    def test_default_settings(self, scope: Read) -> None:
        found = scope('(\n    renderSettingsPrimPath = "/Render/s"\n)\n' + render())
        target = found.default.target
        assert target is not None
        assert target.state is State.MISSING
        assert [c.path for c in target.candidates] == [SETTINGS]


class TestRelativeTargets:
    SOURCE = (
        'def "Render" {{\n    def RenderSettings "S" {{\n    }}\n'
        '    def "Passes" {{\n        def RenderPass "A" {{\n            {}\n        }}\n    }}\n}}\n'
    )

    def source(self, found: RenderScope) -> tuple[str, State, str | None, bool, str | None]:
        (target,) = rel_of(found, "/Render/Passes/A", "renderSource").targets
        return (
            target.path,
            target.state,
            target.as_written,
            target.probably_relative,
            target.meant,
        )

    def test_in_text_it_is_known_how_it_was_written(self, scope: Read) -> None:
        found = scope(self.SOURCE.format("rel renderSource = <Render/S>"))
        path = "/Render/Passes/A/Render/S"
        assert self.source(found) == (path, State.MISSING, "Render/S", False, "/Render/S")

    def test_nothing_is_meant_that_is_not_there(self, scope: Read) -> None:
        found = scope(self.SOURCE.format("rel renderSource = <Render/T>"))
        path = "/Render/Passes/A/Render/T"
        assert self.source(found) == (path, State.MISSING, "Render/T", False, None)

    def test_an_absolute_path_below_its_owner_was_not_written_relative(self, scope: Read) -> None:
        path = "/Render/Passes/A/Render/S"
        found = scope(self.SOURCE.format(f"rel renderSource = <{path}>"))
        assert self.source(found)[:3] == (path, State.MISSING, None)

    def test_one_that_leads_somewhere_is_right(self, scope: Read) -> None:
        found = scope(self.SOURCE.format("rel renderSource = <../../S>"))
        assert self.source(found) == ("/Render/S", State.LIVE, None, False, None)

    def test_in_a_crate_it_was_probably_relative(self, scope: Read) -> None:
        found = scope(
            "(\n    subLayers = [@weak.usdc@]\n)\n",
            {"weak.usdc": self.SOURCE.format("rel renderSource = <Render/S>")},
        )
        path = "/Render/Passes/A/Render/S"
        assert self.source(found) == (path, State.MISSING, None, True, "/Render/S")

    def test_in_a_sublayer_its_text_is_asked(self, scope: Read) -> None:
        found = scope(
            "(\n    subLayers = [@weak.usda@]\n)\n",
            {"weak.usda": self.SOURCE.format("rel renderSource = <Render/S>")},
        )
        assert self.source(found)[2] == "Render/S"

    def test_in_a_variant_its_text_is_found(self, scope: Read) -> None:
        found = scope(
            'def "Render" {\n    def RenderSettings "S" {\n    }\n    def "Passes" {\n'
            '        def RenderPass "A" (\n            variants = { string v = "on" }\n'
            '            prepend variantSets = "v"\n        ) {\n'
            '            variantSet "v" = {\n                "on" {\n'
            "                    rel renderSource = <Render/S>\n"
            "                }\n            }\n        }\n    }\n}\n"
        )
        assert self.source(found)[2] == "Render/S"

    def test_in_a_referenced_layer_its_text_is_found(self, scope: Read) -> None:
        found = scope(
            'def "Render" (\n    references = @show.usda@</Show>\n) {\n}\n',
            {
                "show.usda": self.SOURCE.format("rel renderSource = <Render/S>").replace(
                    '"Render"', '"Show"'
                )
            },
        )
        assert self.source(found)[2] == "Render/S"


class TestStrays:
    @pytest.fixture(autouse=True, params=[True, False], ids=["walked", "by text and tables"])
    def _small(self, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
        """Little layers are walked: let half of the tests take all of them for large ones."""
        if not request.param:
            monkeypatch.setattr(strays, "_FEW", -1)

    def test_however_many_specs_there_are(self, scope: Read) -> None:
        for number in (strays._FEW - 5, strays._FEW + 5):
            others = "".join(f'def "o{n}" {{\n}}\n' for n in range(number))
            assert self.paths(scope(render() + others + 'def RenderVar "v" {\n}\n')) == ["/v"]
            assert self.paths(scope(render() + others)) == []

    def paths(self, found: RenderScope) -> list[str]:
        return [s.path for s in found.strays]

    def test_beside_the_scope(self, scope: Read) -> None:
        found = scope(render() + 'def "Other" {\n    def RenderVar "v" {\n    }\n}\n')
        (stray,) = found.strays
        assert (stray.path, stray.type_name, stray.state) == ("/Other/v", "RenderVar", State.LIVE)
        assert stray.root_site.path == "/Other"
        assert [v.path for v in found.vars] == ["/Other/v"]

    def test_none_in_the_scope_however_often_its_text_names_the_types(self, scope: Read) -> None:
        found = scope(
            render(more='# RenderSettings, RenderVar\n    string doc = "RenderPass"\n    ')
        )
        assert self.paths(found) == []

    def test_a_name_in_a_comment_hides_none(self, scope: Read) -> None:
        found = scope(
            render(more='def "RenderVar" {\n    }\n') + '# RenderVar\ndef RenderVar "v" {\n}\n'
        )
        assert self.paths(found) == ["/v"]

    def test_at_the_path_of_the_scope_itself(self, scope: Read) -> None:
        assert self.paths(scope('def RenderSettings "Render" {\n}\n')) == ["/Render"]

    @pytest.mark.parametrize("name", ["weak.usda", "weak.usdc", "weak.usd"])
    def test_in_sublayers_of_every_format(self, scope: Read, name: str) -> None:
        found = scope(
            f"(\n    subLayers = [@{name}@]\n)\n" + render(),
            {name: 'def "Other" {\n    def RenderVar "v" {\n    }\n}\n'},
        )
        assert self.paths(found) == ["/Other/v"]

    @pytest.mark.parametrize(("selected", "paths"), [("on", ["/Other/v"]), ("off", [])])
    def test_in_a_variant_only_while_it_is_selected(
        self, scope: Read, selected: str, paths: list[str]
    ) -> None:
        found = scope(
            render()
            + f'def "Other" (\n    variants = {{ string x = "{selected}" }}\n'
            + '    prepend variantSets = "x"\n) {\n    variantSet "x" = {\n        "on" {\n'
            + '            def RenderVar "v" {\n            }\n        }\n        "off" {\n        }\n'
            + "    }\n}\n"
        )
        assert self.paths(found) == paths

    def test_what_relationships_reach_outside_is_read_wherever_it_comes_from(
        self, scope: Read
    ) -> None:
        found = scope(
            'def "Render" {\n    def RenderSettings "S" {\n        rel products = </Set/P>\n    }\n}\n'
            'def "Set" (\n    references = @set.usda@</Set>\n) {\n}\n',
            {"set.usda": 'def "Set" {\n    def RenderProduct "P" {\n    }\n}\n'},
        )
        assert self.paths(found) == ["/Set/P"]
        assert [p.path for p in found.products] == ["/Set/P"]

    def test_what_only_a_reference_brings_is_not_looked_for(self, scope: Read) -> None:
        found = scope(
            render() + 'def "Set" (\n    references = @set.usda@</Set>\n) {\n}\n',
            {"set.usda": 'def "Set" {\n    def RenderProduct "P" {\n    }\n}\n'},
        )
        assert self.paths(found) == []

    def test_a_class_is_one_that_nobody_renders(self, scope: Read) -> None:
        found = scope(render() + 'class RenderSettings "_base" {\n}\n')
        assert [(s.path, s.state) for s in found.strays] == [("/_base", State.ABSTRACT)]

    def test_the_default_settings_are_read_wherever_they_stand(self, scope: Read) -> None:
        found = scope(
            '(\n    renderSettingsPrimPath = "/Set/S"\n)\ndef "Set" (\n    references = @set.usda@</Set>\n) {\n}\n',
            {"set.usda": 'def "Set" {\n    def RenderSettings "S" {\n    }\n}\n'},
        )
        assert [s.path for s in found.settings] == ["/Set/S"]
        assert found.default.target is not None
        assert found.default.target.state is State.LIVE


class TestCrate:
    def crate(self, tmp_path: Path, text: str) -> str:
        file = tmp_path / "a.usdc"
        layer = Sdf.Layer.CreateAnonymous(".usda")
        assert layer.ImportFromString(usda(text))
        assert layer.Export(str(file))
        return str(file)

    @pytest.mark.parametrize(
        ("text", "answer"),
        [
            ('def RenderVar "v" {\n}\n', True),
            ('def "RenderVar" {\n}\n', True),
            ('def "RenderVars" {\n}\n', False),
            ('def "MyRenderVar" {\n}\n', False),
            ("", False),
            ("".join(f'def "p{n}" {{\n}}\n' for n in range(5000)), False),
            (
                "".join(f'def "p{n}" {{\n}}\n' for n in range(5000)) + 'def RenderVar "v" {\n}\n',
                True,
            ),
            (f'def "{"a" * 100_000}" {{\n}}\ndef RenderVar "v" {{\n}}\n', True),
        ],
        ids=["type", "name", "longer", "ending", "empty", "many", "last of many", "long"],
    )
    def test_tokens_are_compared_whole(self, tmp_path: Path, text: str, answer: bool) -> None:
        assert mentions(self.crate(tmp_path, text), [b"RenderVar"]) is answer

    def test_what_is_no_crate_tells_nothing(self, tmp_path: Path) -> None:
        good = Path(self.crate(tmp_path, 'def RenderVar "v" {\n}\n')).read_bytes()
        file = tmp_path / "b.usdc"
        for data in (b"", b"PXR-USDC", b"#usda 1.0\n", good[:60], good[:100], good[:-200]):
            file.write_bytes(data)
            assert mentions(str(file), [b"RenderVar"]) is None
        assert mentions(str(tmp_path / "missing.usdc"), [b"RenderVar"]) is None

    def test_an_old_version_tells_nothing(self, tmp_path: Path) -> None:
        data = bytearray(Path(self.crate(tmp_path, "")).read_bytes())
        data[8:11] = b"\0\3\0"
        (tmp_path / "old.usdc").write_bytes(data)
        assert mentions(str(tmp_path / "old.usdc"), [b"RenderVar"]) is None

    def test_a_crate_that_was_written_again_is_read_again(self, tmp_path: Path) -> None:
        file = self.crate(tmp_path, 'def RenderVar "v" {\n}\n')
        assert mentions(file, [b"RenderVar"]) is True
        Path(file).write_bytes(Path(self.crate(tmp_path / "new", "")).read_bytes())
        assert mentions(file, [b"RenderVar"]) is False


class TestTexts:
    @pytest.mark.parametrize("filling", [0, 1 << 18], ids=["small", "large"])
    def test_a_word_is_found_wherever_it_stands(self, tmp_path: Path, filling: int) -> None:
        file = tmp_path / "a.usda"
        file.write_bytes(b"#usda 1.0\n" + b"#" * filling + b"\n# the last word")
        texts = Texts()
        assert texts.mention(str(file), b"word")
        assert texts.mention(str(file), b"usda")
        assert not texts.mention(str(file), b"none")
        assert texts.of_file(str(file)) is not None
        assert texts.mention(str(file), b"last")
        assert not texts.mention(str(file), b"none")

    def test_what_is_no_text_holds_no_word(self, tmp_path: Path) -> None:
        file = tmp_path / "a.usd"
        for filling in (0, 1 << 18):
            file.write_bytes(b"PXR-USDC" + b"#" * filling + b"word")
            texts = Texts()
            assert not texts.mention(str(file), b"word")
            assert texts.of_file(str(file)) is None
        assert not Texts().mention(str(tmp_path / "gone.usda"), b"word")
        assert not Texts().mention(str(tmp_path), b"word")

    def test_only_so_many_texts_are_kept_for_a_word(self, tmp_path: Path) -> None:
        texts = Texts()
        for number in range(100):
            file = tmp_path / f"{number}.usda"
            file.write_bytes(b"#usda 1.0\n" + b"#" * 60_000)
            assert not texts.mention(str(file), b"word")
        assert sum(text is not None for text in texts._known.values()) < 100


class TestEvidence:
    @pytest.mark.parametrize(
        ("main", "renderer"),
        [
            (render(), "any"),
            (render("int arnold:AA_samples = 3"), "arnold"),
            (render(product='token productType = "arnold"'), "arnold"),
            (render(product='token productType = "deep"'), "any"),
            (render("int omni:rtx:x = 3"), "omniverse"),
            (render(more='def Scope "OmniverseKit" {\n    }'), "omniverse"),
            (
                "(\n    customLayerData = { dictionary omni_layer = {} }\n)\n" + render(),
                "omniverse",
            ),
            (render("int arnold:a = 3; int arnold:b = 3; int omni:a = 3"), "arnold"),
            (render("int arnold:a = 3; int omni:a = 3; int omni:b = 3"), "omniverse"),
            (render() + 'def "World" {\n    int arnold:a = 3\n}\n', "any"),
        ],
    )
    def test_chooses_the_renderer_that_left_most_traces(
        self, scope: Read, main: str, renderer: str
    ) -> None:
        chosen, reason = choose(scope(main).evidence)
        assert chosen.name == renderer
        assert ("no traces" in reason) is (renderer == "any")

    def test_of_schemas_that_no_plugin_registers(self, scope: Read) -> None:
        found = scope(
            'def RenderSettings "Render" (\n'
            '    prepend apiSchemas = ["KarmaRenderSettingsAPI", "ArnoldOptionsAPI:x"]\n) {\n}\n'
        )
        assert found.evidence.schemas == (("ArnoldOptionsAPI", 1), ("KarmaRenderSettingsAPI", 1))


class TestDefault:
    KEY = "renderSettingsPrimPath"

    @pytest.mark.parametrize(
        ("value", "problem"),
        [
            ('"/Render/S"', None),
            ('""', None),
            ('"Render/S"', "it is relative"),
            ("</Render/S>", "it stands in angle brackets"),
            ('"</Render/S>"', "it stands in angle brackets"),
            ('" /Render/S"', "it begins or ends with white space"),
            ('"/"', "it is the root of the stage"),
            ('"/Render/S/"', "it ends with a slash"),
            ('"/Render//S"', "it is not a valid path"),
            ('"/Render/S.camera"', "it names a property"),
            ('"/Render{v=a}S"', "it holds a variant selection"),
        ],
    )
    def test_problem(self, scope: Read, value: str, problem: str | None) -> None:
        default = scope(f"(\n    {self.KEY} = {value}\n)\n" + render()).default
        assert default.problem == problem
        assert (default.target is None) is (problem is not None or value == '""')

    def test_only_of_a_broken_one_it_is_asked_what_was_meant(self, scope: Read) -> None:
        for path, meant in (("/Render/S", []), ("/Render/T", ["/Render/S"])):
            target = scope(f'(\n    {self.KEY} = "{path}"\n)\n' + render()).default.target
            assert target is not None
            assert [c.path for c in target.candidates] == meant

    def test_sublayers_do_not_count(self, scope: Read) -> None:
        default = scope(
            "(\n    subLayers = [@weak.usda@]\n)\n" + render(),
            {"weak.usda": f'(\n    {self.KEY} = "/Render/S"\n)\n'},
        ).default
        assert default.opinion is None
        assert [(o.value, o.counts) for o in default.sublayers] == [(SETTINGS, False)]

    def test_the_session_comes_before_the_root(self, tmp_path: Path) -> None:
        (tmp_path / "main.usda").write_text(
            usda(f'(\n    {self.KEY} = "/Render/T"\n)\n' + render())
        )
        session = Sdf.Layer.CreateAnonymous(".usda")
        session.ImportFromString(usda(f'(\n    {self.KEY} = "/Render/S"\n)\n'))
        root = Sdf.Layer.FindOrOpen(str(tmp_path / "main.usda"))
        mask = Usd.StagePopulationMask()
        mask.Add("/Render")
        stage = Usd.Stage.OpenMasked(root, session, mask)
        default = read(Opened(stage, ("/Render",)), Texts()).default
        assert default.opinion is not None
        assert default.opinion.value == SETTINGS
        assert default.opinion.site.layer == session.identifier

    @pytest.mark.parametrize(
        ("metadata", "keys"),
        [
            ('renderSettingsPath = "/Render/S"', ["renderSettingsPath"]),
            ('rendersettingsprimpath = "/Render/S"', ["rendersettingsprimpath"]),
            (
                'customLayerData = { string renderSettingsPrimPath = "/Render/S" }',
                ["renderSettingsPrimPath"],
            ),
            ('customLayerData = { string renderSettings = "/Render/S" }', []),
            ('renderCamera = "/Render/S"', []),
            ("customLayerData = { int renderSettingsPrimPath = 3 }", []),
        ],
    )
    def test_misspelled(self, scope: Read, metadata: str, keys: list[str]) -> None:
        default = scope(f"(\n    {metadata}\n)\n" + render()).default
        assert [o.key for o in default.misspelled] == keys
        assert {o.value for o in default.misspelled} <= {SETTINGS}


class TestArcErrors:
    def told(self, found: RenderScope) -> list[tuple[str, str, str, str, int, bool]]:
        return [(e.kind, e.arc, e.asset, e.prim, e.count, e.touches_spec) for e in found.errors]

    @pytest.mark.parametrize(
        ("arc", "told"),
        [
            ("references = @no.usda@", ("missing-asset", "reference", "no.usda", "")),
            ("payload = @no.usda@</A>", ("missing-asset", "payload", "no.usda", "")),
            ("references = @show.usda@</No>", ("missing-prim", "reference", "show.usda", "/No")),
            ("references = @show.usda@", ("no-default-prim", "reference", "show.usda", "")),
            ("references = </No>", ("missing-prim", "reference", "", "/No")),
        ],
    )
    def test_kinds(self, scope: Read, arc: str, told: tuple[str, ...]) -> None:
        found = scope(f'def "Render" (\n    {arc}\n) {{\n}}\n', {"show.usda": 'def "Show" {\n}\n'})
        assert self.told(found) == [(*told, 1, True)]

    def test_cycle(self, scope: Read) -> None:
        found = scope(
            'def "Render" (\n    references = </Render/A>\n) {\n    def "A" {\n    }\n}\n'
        )
        assert {e[0] for e in self.told(found)} == {"cycle"}

    def test_one_cause_is_told_once_with_its_count(self, scope: Read) -> None:
        vars_ = "".join(
            f'    def RenderVar "v{n}" (\n        references = @no.usda@</V>\n    ) {{\n    }}\n'
            for n in range(7)
        )
        (error,) = scope(f'def "Render" {{\n{vars_}}}\n').errors
        assert (error.kind, error.count) == ("missing-asset", 7)
        assert error.prims == tuple(f"/Render/v{n}" for n in range(5))

    def test_one_that_no_render_needs(self, scope: Read) -> None:
        found = scope(
            render("rel camera = </World/cam>")
            + 'def "World" {\n    def Camera "cam" (\n        references = @no.usda@\n    ) {\n    }\n}\n'
        )
        assert self.told(found) == [("missing-asset", "reference", "no.usda", "", 1, False)]

    def test_a_missing_sublayer_touches_everything(self, scope: Read) -> None:
        found = scope("(\n    subLayers = [@no.usda@]\n)\n" + render())
        assert self.told(found) == [("missing-asset", "sublayer", "no.usda", "", 1, True)]

    def test_a_layer_that_does_not_parse_is_told_as_its_own_problem(self, tmp_path: Path) -> None:
        with Diagnostics():
            stage = opened(
                tmp_path, "(\n    subLayers = [@bad.usda@]\n)\n" + render(), {"bad.usda": "def {"}
            )
            found = read(stage, Texts())
        assert found.errors == ()
        assert [Path(p.file).name for p in stage.unparsed] == ["bad.usda"]

    def test_a_layer_that_is_none_is_told_with_who_asks_for_it(self, tmp_path: Path) -> None:
        with Diagnostics():
            stage = opened(tmp_path, 'def "Render" (\n    references = @a.usda@\n) {\n}\n', {})
            (tmp_path / "a.usda").write_bytes(b"")
            stage = open_stage(stage.stage.GetRootLayer(), ("/Render",))
            found = read(stage, Texts())
        assert found.errors == ()
        (problem,) = stage.unreadable
        assert (Path(problem.file).name, Path(problem.asked_by or "").name) == (
            "a.usda",
            "main.usda",
        )


class TestProperties:
    def properties(self, scope: Read, statement: str) -> dict[str, Any]:
        (settings,) = scope(render(statement)).settings
        return {p.name: p for p in settings.properties}

    def test_of_the_schema(self, scope: Read) -> None:
        found = self.properties(scope, "int2 resolution = (1, 1)")["resolution"]
        assert (found.is_schema, found.type_name, found.schema_type) == (True, "int2", "int2")
        assert found.type_fits
        assert not found.is_relationship

    @pytest.mark.parametrize(
        ("statement", "fits"),
        [
            ("float2 resolution = (1, 1)", False),
            ("int2 resolution = (1, 1)", True),
            ("color4f dataWindowNDC = (0, 0, 1, 1)", True),
            ('string[] includedPurposes = ["render"]', False),
        ],
    )
    def test_types(self, scope: Read, statement: str, fits: bool) -> None:
        name = statement.split()[1]
        assert self.properties(scope, statement)[name].type_fits is fits

    def test_of_another_render_type(self, scope: Read) -> None:
        found = self.properties(scope, 'token productName = "a"')["productName"]
        assert (found.is_schema, found.belongs_to) == (False, ("RenderProduct",))

    def test_of_nobody(self, scope: Read) -> None:
        found = self.properties(scope, "custom float resolutoin = 1")["resolutoin"]
        assert (found.is_schema, found.belongs_to, found.custom) == (False, (), True)

    @pytest.mark.parametrize(
        ("statement", "is_relationship", "wanted"),
        [('string camera = "/C"', False, True), ("rel resolution = </C>", True, False)],
    )
    def test_kinds(self, scope: Read, statement: str, is_relationship: bool, wanted: bool) -> None:
        found = self.properties(scope, statement)[statement.split()[1]]
        assert (found.is_relationship, found.schema_is_relationship) == (is_relationship, wanted)

    def test_a_declaration_has_no_value(self, scope: Read) -> None:
        found = self.properties(scope, "float a; float b = 1; float c.timeSamples = { 1: 1 }")
        assert [found[n].has_value for n in "abc"] == [False, True, True]


class TestCollections:
    @pytest.mark.parametrize(
        ("statements", "counts"),
        [
            ('pathExpression @:membershipExpression = "/World//"', False),
            ('pathExpression @:membershipExpression = "/World//"; bool @:includeRoot = 0', True),
            (
                'pathExpression @:membershipExpression = "/World//"; bool @:includeRoot = 0;'
                " rel @:includes = </World>",
                False,
            ),
            (
                'pathExpression @:membershipExpression = "/World//"; bool @:includeRoot = 0;'
                ' token @:mode = "relationship"',
                False,
            ),
            ('pathExpression @:membershipExpression = "//{nope}"; bool @:includeRoot = 0', True),
            (
                'pathExpression @:membershipExpression = "//"; bool @:includeRoot = 0;'
                ' string @:includes = "/World"',
                False,
            ),
        ],
    )
    def test_whether_the_expression_counts(
        self, scope: Read, statements: str, counts: bool
    ) -> None:
        found = scope(
            'def "Render" {\n    def RenderPass "A" {\n        '
            + statements.replace("@", "collection:renderVisibility")
            + "\n    }\n}\n"
            + CAMERAS
        )
        (collection,) = found.passes[0].collections
        assert collection.name == "renderVisibility"
        assert collection.expression_counts is counts

    def test_only_those_that_are_written_and_applied(self, scope: Read) -> None:
        found = scope(
            'def "Render" {\n    def RenderPass "A" (\n        prepend apiSchemas = ["CollectionAPI:mine"]\n    ) {\n'
            "        rel collection:matte:includes = </World>\n"
            "        rel collection:mine:includes = </World>\n"
            "        rel collection:mate:includes = </World>\n    }\n}\n"
        )
        assert [c.name for c in found.passes[0].collections] == ["matte", "mine"]

    def test_in_usds_words_why_one_is_refused(self, scope: Read) -> None:
        found = scope(
            'def "Render" {\n    def RenderPass "A" {\n'
            "        rel collection:matte:includes = </World/a>\n"
            "        rel collection:matte:excludes = </Other>\n    }\n}\n"
        )
        assert found.passes[0].collections[0].problem

    def test_nothing_below_members_is_populated(self, tmp_path: Path) -> None:
        stage = opened(
            tmp_path,
            'def "Render" {\n    def RenderPass "A" {\n'
            "        rel collection:matte:includes = </World>\n    }\n}\n" + CAMERAS,
            {},
        )
        read(stage, Texts())
        world = stage.stage.GetPrimAtPath("/World")
        assert world
        assert not world.GetChildren()


class TestScope:
    def test_groups_and_what_they_hold(self, scope: Read) -> None:
        found = scope(
            'def Scope "Render" {\n    def Scope "Vars" (\n        active = false\n    ) {\n'
            '        def RenderVar "v" {\n        }\n    }\n'
            '    def Scope "Empty" {\n    }\n    over "Overs" {\n        over RenderVar "v" {\n        }\n    }\n}\n'
        )
        assert [(s.path, s.state, s.holds_render_prims) for s in found.scopes] == [
            ("/Render", State.LIVE, True),
            ("/Render/Vars", State.INACTIVE, True),
            ("/Render/Empty", State.LIVE, False),
            ("/Render/Overs", State.OVER, False),
        ]

    def test_other_prims_with_their_properties(self, scope: Read) -> None:
        found = scope(
            'def "Render" {\n    def RenderSetting "S" {\n        int2 resolution = (1, 1)\n    }\n'
            '    def "T" (\n        references = @no.usda@\n    ) {\n    }\n}\n'
        )
        setting, untyped = found.others
        assert (setting.type_name, setting.type_known, setting.behind_failed_arc) == (
            "RenderSetting",
            False,
            False,
        )
        assert setting.properties[0].belongs_to == ("RenderSettings", "RenderProduct")
        assert (untyped.type_name, untyped.behind_failed_arc) == ("", True)

    @pytest.mark.parametrize(
        ("main", "overrides"),
        [
            ("", True),
            ('over "Render" {\n    def RenderVar "v" {\n    }\n}\n', True),
            ('class "Render" {\n}\n', True),
            ('over "Render" {\n}\ndef "World" {\n}\n', True),
            ('over "Render" {\n    def RenderSettings "S" {\n    }\n}\ndef "World" {\n}\n', False),
            ('def "World" {\n}\n', False),
        ],
    )
    def test_a_layer_of_overrides(self, scope: Read, main: str, overrides: bool) -> None:
        assert scope(main).only_overrides is overrides

    def test_instances_are_read_once(self, scope: Read) -> None:
        found = scope(
            'def "Render" {\n'
            + "".join(
                f'    def "{n}" (\n        instanceable = true\n        references = </_Set>\n    ) {{\n    }}\n'
                for n in "AB"
            )
            + '}\nclass "_Set" {\n    def RenderVar "v" {\n    }\n}\n'
        )
        assert [v.path for v in found.vars if v.live] == ["/Render/A/v", "/Render/B/v"]
        judged = [s.path for s in subjects_of(found) if isinstance(s, Var)]
        assert judged == ["/Render/A/v"]

    def test_the_model_outlives_its_stage(self, scope: Read) -> None:
        found = scope('(\n    renderSettingsPrimPath = "/Render/S"\n)\n' + render() + CAMERAS)
        assert pickle.loads(pickle.dumps(found)) == found  # noqa: S301
        assert hash(found)
