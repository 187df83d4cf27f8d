"""What the program relies on in usd-core, tried: a new version of USD that answers otherwise fails here
first, by name."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from pxr import Sdf, Tf, Usd, UsdGeom, UsdUtils

from conftest import since
from usdrender_lint.diagnostics import Diagnostics
from usdrender_lint.read.specs import items
from usdrender_lint.stage import PROBE, all_below

DEFAULT = Usd.TimeCode.Default()


class Folder:
    """Layers in a temporary folder, and the stages opened there: a prim dies with its stage."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.stages: list[Usd.Stage] = []

    def write(self, name: str, text: str) -> str:
        file = self.path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text if text.startswith("#usda") else f"#usda 1.0\n{text}", "utf-8")
        return str(file)

    def stage(self, main: str, **layers: str) -> Usd.Stage:
        for name, text in layers.items():
            self.write(f"{name}.usda", text)
        self.stages.append(Usd.Stage.Open(self.write("main.usda", main)))
        return self.stages[-1]


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    return Folder(tmp_path)


def mask_of(*paths: str) -> Usd.StagePopulationMask:
    mask = Usd.StagePopulationMask()
    for path in paths:
        mask.Add(path)
    return mask


def masked(folder: Folder, main: str, *paths: str) -> Usd.Stage:
    return Usd.Stage.OpenMasked(folder.write("main.usda", main), mask_of(*paths))


def populated(stage: Usd.Stage) -> list[str]:
    return [str(p.GetPath()) for p in stage.TraverseAll()]


def error_names(stage: Usd.Stage) -> list[str]:
    return [type(e).__name__ for e in stage.GetCompositionErrors()]


class TestValues:
    def attribute(self, folder: Folder, statement: str, weaker: str = "") -> Usd.Attribute:
        """Of the camera `</C>`, as a stronger layer writes it over a weaker one."""
        stage = folder.stage(
            f'(\n    subLayers = [@weak.usda@]\n)\nover "C" {{\n    {statement}\n}}\n',
            weak=f'def Camera "C" {{\n    {weaker}\n}}\n',
        )
        names = stage.GetPrimAtPath("/C").GetAuthoredPropertyNames()
        return stage.GetPrimAtPath("/C").GetAttribute(names[0])

    def typed(self, attribute: Usd.Attribute) -> float:
        """The one typed C++ read of a single value at the default time that Python can ask for."""
        with Diagnostics():
            camera = UsdGeom.Camera(attribute.GetPrim()).GetCamera(DEFAULT)
        return float(camera.focalLength)

    def test_a_block_kills_the_fallback_at_the_default_time_only(self, folder: Folder) -> None:
        blocked = self.attribute(folder, "float focalLength = None", "float focalLength = 7")
        assert blocked.Get() is None
        assert blocked.Get(1.0) == 50
        assert not blocked.HasAuthoredValue()
        assert blocked.GetResolveInfo().ValueIsBlocked()
        assert isinstance(blocked.GetPropertyStack()[0].default, Sdf.ValueBlock)

    def test_a_mistyped_opinion_is_passed_over_for_a_weaker_one_of_the_right_type(
        self, folder: Folder
    ) -> None:
        both = self.attribute(folder, "double focalLength = 9", "float focalLength = 7")
        assert both.HasAuthoredValue()
        assert both.Get() == 9
        assert self.typed(both) == 7

    def test_python_shows_a_mistyped_value_and_the_type_of_the_schema(self, folder: Folder) -> None:
        alone = self.attribute(folder, 'string focalLength = "nine"')
        assert alone.Get() == "nine"
        assert alone.GetTypeName() == Sdf.ValueTypeNames.Float
        assert alone.GetPropertyStack()[0].typeName == Sdf.ValueTypeNames.String

    def test_types_that_differ_in_role_only_are_read_alike(self, folder: Folder) -> None:
        attribute = self.attribute(folder, "texCoord2f clippingRange = (3, 4)")
        clipping = UsdGeom.Camera(attribute.GetPrim()).GetCamera(DEFAULT).clippingRange
        assert (clipping.min, clipping.max) == (3, 4)
        assert Sdf.ValueTypeNames.TexCoord2f.type == Sdf.ValueTypeNames.Float2.type
        assert Sdf.ValueTypeNames.TexCoord2f != Sdf.ValueTypeNames.Float2

    @pytest.mark.parametrize(
        ("samples", "field"),
        [(".timeSamples = { 1: 9 }", "timeSamples"), (".spline = { bezier, 1: 9 }", "spline")],
    )
    def test_samples_alone_are_authored_and_give_the_fallback(
        self, folder: Folder, samples: str, field: str
    ) -> None:
        sampled = self.attribute(folder, f"float focalLength{samples}")
        assert sampled.Get() == 50
        assert sampled.Get(1.0) == 9
        assert sampled.HasAuthoredValue()
        assert sampled.GetPropertyStack(DEFAULT)[0].HasInfo(field)
        assert not sampled.GetPropertyStack(DEFAULT)[0].HasInfo("default")

    def test_a_spline_has_no_time_samples(self, folder: Folder) -> None:
        assert (
            self.attribute(folder, "float focalLength.spline = { bezier, 1: 9 }").GetTimeSamples()
            == []
        )

    def test_samples_do_not_hide_the_default_of_a_weaker_layer(self, folder: Folder) -> None:
        sampled = self.attribute(
            folder, "float focalLength.timeSamples = { 1: 9 }", "float focalLength = 7"
        )
        assert sampled.Get() == 7

    @pytest.mark.parametrize(("weaker", "value"), [("", 50), ("float focalLength = 7", 7)])
    def test_an_animation_block_lets_the_weaker_default_through(
        self, folder: Folder, weaker: str, value: float
    ) -> None:
        animated = self.attribute(folder, "float focalLength = AnimationBlock", weaker)
        assert animated.Get() == value
        assert animated.HasAuthoredValue() is bool(weaker)
        assert animated.GetPropertyStack()[0].HasInfo("default")
        assert isinstance(animated.GetPropertyStack()[0].default, Sdf.AnimationBlock)

    def test_a_declaration_is_authored_and_holds_no_value(self, folder: Folder) -> None:
        declared = self.attribute(folder, "float focalLength")
        assert declared.IsAuthored()
        assert not declared.HasAuthoredValue()
        assert not declared.GetPropertyStack()[0].HasInfo("default")

    def test_namespaced_properties_do_not_hide_in_the_authored_names(self, folder: Folder) -> None:
        prim = self.attribute(folder, 'string ri:a = "x"; rel karma:b = </C>').GetPrim()
        assert prim.GetAuthoredPropertyNames() == ["karma:b", "ri:a"]


class TestSchemas:
    def test_render_types_are_known_by_name_without_their_module(self) -> None:
        command = (
            "import sys; from pxr import Usd; stage = Usd.Stage.CreateInMemory();"
            "prim = stage.DefinePrim('/S', 'RenderSettings');"
            "assert prim.IsA('RenderSettings') and not prim.IsA('RenderProduct');"
            "assert stage.DefinePrim('/C', 'Camera').IsA('Camera');"
            "sys.exit('pxr.UsdRender' in sys.modules)"
        )
        assert subprocess.run([sys.executable, "-c", command], check=False).returncode == 0

    @pytest.mark.parametrize("name", ["", "RenderSetting", "RenderSettingsBase"])
    def test_an_unknown_type_looks_like_none_at_all(self, name: str) -> None:
        stage = Usd.Stage.CreateInMemory()
        prim = stage.DefinePrim("/S", name)
        assert prim.GetPrimTypeInfo().GetSchemaType() == Tf.Type.Unknown
        assert not prim.IsA("RenderSettings")
        assert prim.GetTypeName() == name

    def test_an_unknown_type_is_said_nothing_about(self, folder: Folder) -> None:
        with Diagnostics() as said:
            folder.stage('def RenderSetting "S" {\n    int2 resolution = (1, 1)\n}\n')
        assert said.messages == []

    def test_the_definition_tells_relationships_from_attributes(self) -> None:
        definition = Usd.SchemaRegistry().FindConcretePrimDefinition("RenderSettings")
        assert definition.GetSchemaRelationshipSpec("camera") is not None
        assert definition.GetSchemaAttributeSpec("camera") is None
        assert definition.GetSchemaAttributeSpec("resolution").default == (2048, 1080)

    def test_applied_schemas_that_no_plugin_registers_are_listed_in_the_type_info_only(
        self, folder: Folder
    ) -> None:
        stage = folder.stage(
            'def RenderSettings "S" (\n    prepend apiSchemas = ["KarmaRenderSettingsAPI"]\n) {\n}\n'
        )
        prim = stage.GetPrimAtPath("/S")
        assert prim.GetPrimTypeInfo().GetAppliedAPISchemas() == ["KarmaRenderSettingsAPI"]
        assert list(prim.GetAppliedSchemas()) == []

    def test_the_collections_of_a_pass_are_built_in(self) -> None:
        stage = Usd.Stage.CreateInMemory()
        prim = stage.DefinePrim("/A", "RenderPass")
        built_in = {"renderVisibility", "cameraVisibility", "prune", "matte"}
        assert {f"CollectionAPI:{n}" for n in built_in} <= set(prim.GetAppliedSchemas())
        include_root = {
            n: prim.GetAttribute(f"collection:{n}:includeRoot").Get() for n in sorted(built_in)
        }
        assert include_root == {
            "cameraVisibility": True,
            "matte": None,
            "prune": None,
            "renderVisibility": True,
        }

    @pytest.mark.parametrize(
        ("name", "known"), [("color3f", True), ("token[]", True), ("rgb", False), ("", False)]
    )
    def test_value_types_are_found_by_name(self, name: str, known: bool) -> None:
        assert bool(Sdf.ValueTypeNames.Find(name)) is known


class TestMasks:
    WORLD = (
        'def Scope "Render" {\n    def Scope "Vars" {\n    }\n}\n'
        'def "World" {\n    def "set" {\n        def "table" {\n        }\n    }\n'
        '    def "other" {\n    }\n}\n'
    )

    def test_a_mask_populates_ancestors_and_all_below(self, folder: Folder) -> None:
        stage = masked(folder, self.WORLD, "/World/set")
        assert populated(stage) == ["/World", "/World/set", "/World/set/table"]

    def test_a_probe_populates_a_prim_without_what_lies_below(self, folder: Folder) -> None:
        stage = masked(folder, self.WORLD, "/Render", f"/World/set/{PROBE}")
        assert populated(stage) == ["/Render", "/Render/Vars", "/World", "/World/set"]

    def test_a_probe_below_what_is_in_the_mask_is_in_it(self) -> None:
        mask = mask_of("/Render")
        assert mask.Includes(f"/Render/Vars/{PROBE}")
        assert not mask.Includes(f"/World/{PROBE}")

    def test_prims_of_a_wider_mask_appear_on_the_same_stage(self, folder: Folder) -> None:
        stage = masked(folder, self.WORLD, "/Render")
        assert not stage.GetPrimAtPath("/World/set")
        mask = stage.GetPopulationMask()
        mask.Add(f"/World/set/{PROBE}")
        assert not stage.GetPrimAtPath("/World/set")
        stage.SetPopulationMask(mask)
        assert stage.GetPrimAtPath("/World/set")

    def test_a_prim_outside_the_mask_looks_like_a_missing_one(self, folder: Folder) -> None:
        stage = masked(folder, self.WORLD, "/Render")
        assert not stage.GetPrimAtPath("/World")
        assert not stage.GetPrimAtPath("/Nowhere")

    def test_child_names_do_not_stop_at_the_mask(self, folder: Folder) -> None:
        stage = masked(folder, self.WORLD, f"/World/{PROBE}")
        world = stage.GetPrimAtPath("/World")
        assert world.GetAllChildrenNames() == []
        assert world.GetPrimIndex().ComputePrimChildNames()[0] == ["set", "other"]

    def test_a_property_path_raises_and_stays_in_the_mask(self) -> None:
        mask = mask_of("/Render")
        with pytest.raises(Tf.ErrorException):
            mask.Add("/World.prop")
        assert [str(p) for p in mask.GetPaths()] == ["/Render", "/World.prop"]

    def test_payloads_of_ancestors_are_loaded_and_others_not_even_opened(
        self, folder: Folder
    ) -> None:
        folder.write(
            "near.usda", 'def "P" {\n    def "set" {\n        def "x" {\n        }\n    }\n}\n'
        )
        far = folder.write("far.usda", 'def "P" {\n}\n')
        stage = masked(
            folder,
            'def "World" (\n    payload = @near.usda@</P>\n) {\n'
            '    def "far" (\n        payload = @far.usda@</P>\n    ) {\n    }\n}\n',
            f"/World/set/{PROBE}",
        )
        assert populated(stage) == ["/World", "/World/set"]
        assert Sdf.Layer.Find(far) is None

    def test_forwarding_through_a_prim_outside_the_mask_stops_there(self, folder: Folder) -> None:
        stage = masked(
            folder,
            'def RenderSettings "S" {\n    rel camera = </World.cam>\n}\n'
            'def "World" {\n    rel cam = </World/C>\n    def Camera "C" {\n    }\n}\n',
            "/S",
        )
        camera = stage.GetPrimAtPath("/S").GetRelationship("camera")
        assert camera.GetForwardedTargets() == ["/World.cam"]
        mask = stage.GetPopulationMask()
        mask.Add(f"/World/{PROBE}")
        stage.SetPopulationMask(mask)
        assert stage.GetRelationshipAtPath("/S.camera").GetForwardedTargets() == ["/World/C"]


class TestRelationships:
    @pytest.mark.parametrize(
        "statement", ['string camera = "/World/C"', "token[] camera = []", "string camera"]
    )
    def test_asking_one_that_is_authored_as_an_attribute_raises(
        self, folder: Folder, statement: str
    ) -> None:
        stage = folder.stage(f'def RenderSettings "S" {{\n    {statement}\n}}\n')
        camera = stage.GetPrimAtPath("/S").GetRelationship("camera")
        assert camera
        assert camera.IsAuthored()
        for ask in (camera.GetTargets, camera.GetForwardedTargets):
            with pytest.raises(Tf.ErrorException):
                ask()

    @pytest.mark.parametrize("right_first", [True, False])
    def test_the_strongest_layer_says_of_which_kind_a_property_is(
        self, folder: Folder, right_first: bool
    ) -> None:
        kinds = ["prepend rel camera = </C>", 'string camera = "/C"']
        strong, weak = kinds if right_first else reversed(kinds)
        stage = folder.stage(
            f'(\n    subLayers = [@weak.usda@]\n)\nover "S" {{\n    {strong}\n}}\n',
            weak=f'def RenderSettings "S" {{\n    {weak}\n}}\n',
        )
        camera = stage.GetPrimAtPath("/S").GetRelationship("camera")
        assert len(camera.GetPropertyStack()) == 2
        with Diagnostics() as said:
            if right_first:
                assert camera.GetTargets() == ["/C"]
                said.collect()
                assert "inconsistent spec types" in said.messages[0]
            else:
                with pytest.raises(Tf.ErrorException):
                    camera.GetTargets()

    def test_an_attribute_that_is_authored_as_a_relationship_reads_as_the_fallback(
        self, folder: Folder
    ) -> None:
        stage = folder.stage('def RenderSettings "S" {\n    rel resolution = </C>\n}\n')
        resolution = stage.GetPrimAtPath("/S").GetAttribute("resolution")
        assert resolution.Get() == (2048, 1080)
        assert resolution.IsAuthored()
        assert isinstance(resolution.GetPropertyStack()[0], Sdf.RelationshipSpec)

    @pytest.mark.parametrize(
        ("statement", "authored"),
        [("rel camera = None", True), ("rel camera = []", True), ("rel camera", False)],
    )
    def test_an_empty_list_is_authored(
        self, folder: Folder, statement: str, authored: bool
    ) -> None:
        stage = folder.stage(f'def RenderSettings "S" {{\n    {statement}\n}}\n')
        camera = stage.GetPrimAtPath("/S").GetRelationship("camera")
        assert camera.HasAuthoredTargets() is authored
        assert camera.GetTargets() == []

    def test_relative_targets_are_absolute_once_parsed(self, folder: Folder) -> None:
        file = folder.write(
            "main.usda",
            'def "Render" {\n    def "A" {\n        rel r = [<Render/S>, <../B>]\n    }\n}\n',
        )
        layer = Sdf.Layer.FindOrOpen(file)
        targets = layer.GetRelationshipAtPath("/Render/A.r").targetPathList.explicitItems
        assert targets == ["/Render/A/Render/S", "/Render/B"]
        assert "<Render/S>" not in layer.ExportToString()

    def test_a_target_twice_in_one_list_does_not_parse(self, folder: Folder) -> None:
        with pytest.raises(Tf.ErrorException):
            folder.stage('def "A" {\n    rel r = [</B>, </B>]\n}\n')

    @pytest.mark.parametrize("arc", ["references", "payload"])
    def test_an_arc_drops_targets_that_lead_out_of_it(self, folder: Folder, arc: str) -> None:
        stage = folder.stage(
            f'def "Render" (\n    {arc} = @show.usda@</Show>\n) {{\n}}\n',
            show='def "Show" {\n    def RenderSettings "S" {\n'
            "        rel products = [</Show/P>, </Elsewhere/P>]\n    }\n}\n",
        )
        with Diagnostics():
            products = stage.GetPrimAtPath("/Render/S").GetRelationship("products")
            assert products.GetTargets() == ["/Render/P"]
        assert products.HasAuthoredTargets()
        assert error_names(stage) == []
        spec = products.GetPropertyStack()[0]
        assert spec.targetPathList.explicitItems == ["/Show/P", "/Elsewhere/P"]

    def test_forwarding_ends_at_a_cycle(self, folder: Folder) -> None:
        stage = folder.stage(
            'def RenderSettings "S" {\n    rel camera = </S.a>\n    rel a = [</S.b>, </C>]\n'
            "    rel b = </S.a>\n}\n"
        )
        assert stage.GetRelationshipAtPath("/S.camera").GetForwardedTargets() == ["/C"]

    def test_a_property_that_is_no_relationship_is_a_target_itself(self, folder: Folder) -> None:
        stage = folder.stage(
            'def RenderPass "A" {\n    string nuke:writeNode = "W"\n'
            "    rel renderSource = </A.nuke:writeNode>\n}\n"
        )
        source = stage.GetRelationshipAtPath("/A.renderSource")
        assert source.GetForwardedTargets() == ["/A.nuke:writeNode"]


class TestLiveness:
    DEAD = (
        'def "Render" (\n    active = false\n) {\n    def RenderSettings "S" {\n    }\n}\n'
        'class "_Class" {\n    def RenderSettings "S" {\n    }\n}\n'
        'over "Over" {\n    def RenderSettings "S" {\n    }\n}\n'
    )

    def test_below_an_inactive_prim_nothing_is_composed(self, folder: Folder) -> None:
        stage = folder.stage(self.DEAD)
        assert not stage.GetPrimAtPath("/Render").IsActive()
        assert not stage.GetPrimAtPath("/Render/S")
        assert stage.GetRootLayer().GetPrimAtPath("/Render/S")

    def test_below_classes_and_overs_prims_are_there(self, folder: Folder) -> None:
        stage = folder.stage(self.DEAD)
        abstract, undefined = (stage.GetPrimAtPath(f"/{n}/S") for n in ("_Class", "Over"))
        assert abstract.IsAbstract()
        assert abstract.IsDefined()
        assert not undefined.IsDefined()
        assert not undefined.IsAbstract()

    def test_only_a_predicate_for_all_prims_meets_them(self, folder: Folder) -> None:
        root = folder.stage(self.DEAD).GetPseudoRoot()
        usual = [str(p.GetPath()) for p in Usd.PrimRange(root)]
        everything = Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)
        met = [str(p.GetPath()) for p in Usd.PrimRange(root, everything)]
        assert usual == ["/"]
        assert met == ["/", "/Render", "/_Class", "/_Class/S", "/Over", "/Over/S"]

    def test_instances_share_one_prototype_and_answer_by_path(self, folder: Folder) -> None:
        stage = folder.stage(
            'def "A" (\n    instanceable = true\n    references = </_Set>\n) {\n}\n'
            'def "B" (\n    instanceable = true\n    references = </_Set>\n) {\n}\n'
            'class "_Set" {\n    def RenderVar "v" {\n    }\n}\n'
        )
        one, other = (stage.GetPrimAtPath(f"/{n}/v") for n in "AB")
        assert one.IsInstanceProxy()
        assert one.GetPrimInPrototype() == other.GetPrimInPrototype()
        assert not list(Usd.PrimRange(stage.GetPrimAtPath("/A")))[1:]


class TestListing:
    """USD is asked by number and through its classes: the answers are those of a loop over an object."""

    TEXT = """def Scope "A" (
    variantSets = "v"
    variants = { string v = "x" }
)
{
    token[] tokens = ["a", "b"]
    int2 two = (1, 2)
    prepend rel targets = </B>
    append rel targets = </C>
    delete rel targets = </D>
    def "b" (
        active = false
    )
    {
    }
    class "c"
    {
        def "e"
        {
        }
    }
    over "d" (
        instanceable = true
        references = </P>
    )
    {
    }
    variantSet "v" = {
        "x" {
            def "f"
            {
            }
        }
        "y" {
        }
    }
}
def "P"
{
    def "q"
    {
    }
}
"""

    def test_what_is_listed_can_be_asked_for_by_number(self, folder: Folder) -> None:
        layer = Sdf.Layer.FindOrOpen(folder.write("main.usda", self.TEXT))
        spec = layer.GetPrimAtPath("/A")
        assert items(layer.rootPrims) == list(layer.rootPrims)
        assert items(spec.nameChildren) == list(spec.nameChildren)
        assert items(spec.variantSets) == list(spec.variantSets.values())
        (variants,) = items(spec.variantSets)
        assert items(variants.variants) == list(variants.variants.values())
        assert len(spec.nameChildren) == len(variants.variants) + 1 == 3
        value = layer.GetAttributeAtPath("/A.tokens").default
        assert items(value) == list(value) == ["a", "b"]
        assert layer.GetAttributeAtPath("/A.two").default[:] == [1, 2]
        edits = layer.GetRelationshipAtPath("/A.targets").targetPathList
        assert sorted(edits.GetAddedOrExplicitItems()) == ["/B", "/C"]

    def test_there_is_one_object_for_each_value_of_an_enumeration(self, folder: Folder) -> None:
        layer = Sdf.Layer.FindOrOpen(folder.write("main.usda", 'def "A" {\n uniform token a\n}\n'))
        assert layer.GetPrimAtPath("/A").specifier is Sdf.SpecifierDef
        assert layer.GetAttributeAtPath("/A.a").variability is Sdf.VariabilityUniform

    def test_children_come_in_the_order_of_a_range(self, folder: Folder) -> None:
        stage = folder.stage(self.TEXT)
        root = stage.GetPseudoRoot()
        every = Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)
        paths = [str(p.GetPath()) for p in all_below(root)]
        assert paths == [str(p.GetPath()) for p in Usd.PrimRange(root, every)]
        assert {"/A/b", "/A/c/e", "/A/d/q", "/A/f"} < {*paths}

    def test_a_method_of_the_class_refuses_a_prim_that_is_no_more(self, folder: Folder) -> None:
        stage = Usd.Stage.Open(folder.write("main.usda", self.TEXT))
        prim = stage.GetPrimAtPath("/A")
        assert Usd.Prim.GetPath(prim) == "/A"
        del stage
        for method in (Usd.Prim.GetPrimStack, Usd.Prim.IsActive, Usd.Prim.GetTypeName):
            with pytest.raises(Tf.CppException, match="expired"):
                method(prim)


class TestDefaultSettings:
    KEY = "renderSettingsPrimPath"

    def test_only_the_root_and_the_session_layer_are_asked(self, folder: Folder) -> None:
        stage = folder.stage(
            "(\n    subLayers = [@weak.usda@]\n)\n", weak=f'(\n    {self.KEY} = "/Render/S"\n)\n'
        )
        assert not stage.HasAuthoredMetadata(self.KEY)
        assert stage.GetMetadata(self.KEY) == ""

    def test_the_session_wins_even_with_an_empty_value(self, folder: Folder) -> None:
        stage = folder.stage(f'(\n    {self.KEY} = "/Render/S"\n)\n')
        assert stage.GetMetadata(self.KEY) == "/Render/S"
        stage.GetSessionLayer().pseudoRoot.SetInfo(self.KEY, "")
        assert stage.GetMetadata(self.KEY) == ""

    def test_a_path_in_brackets_opens_and_comes_back_as_a_path(self, folder: Folder) -> None:
        stage = folder.stage(f"(\n    {self.KEY} = </Render/S>\n)\n")
        value = stage.GetRootLayer().pseudoRoot.GetInfo(self.KEY)
        assert isinstance(value, Sdf.Path)
        assert f"{self.KEY} = /Render/S" in stage.GetRootLayer().ExportToString()

    def test_only_the_pseudo_root_lists_keys_that_no_plugin_registers(self, folder: Folder) -> None:
        stage = folder.stage('(\n    renderSettingsPath = "/Render/S"\n)\n')
        layer = stage.GetRootLayer()
        assert "renderSettingsPath" not in layer.pseudoRoot.GetMetaDataInfoKeys()
        value = stage.GetPseudoRoot().GetAllAuthoredMetadata()["renderSettingsPath"]
        assert isinstance(value, Sdf.UnregisteredValue)
        assert value.value == '"/Render/S"'


class TestArcs:
    def test_composition_errors_name_a_type_and_a_root_site_and_nothing_else(
        self, folder: Folder
    ) -> None:
        with Diagnostics():
            stage = folder.stage(
                "(\n    subLayers = [@no.usda@]\n)\n"
                'def "A" (\n    references = @no.usda@\n) {\n}\n'
                'def "B" (\n    payload = @show.usda@</No>\n) {\n}\n',
                show='def "Show" {\n}\n',
            )
        errors = stage.GetCompositionErrors()
        told = {(type(e).__name__, str(e.rootSite.path)) for e in errors}
        assert told == {
            ("ErrorInvalidSublayerPath", "/"),
            ("ErrorInvalidAssetPath", "/A"),
            ("ErrorUnresolvedPrimPath", "/B"),
        }
        facts = {n for e in errors for n in dir(e) if not n.startswith("_")}
        assert facts == {"errorType", "rootSite"}

    @pytest.mark.parametrize(
        ("main", "name"),
        [
            ('def "A" (\n    references = </A/B>\n) {\n    def "B" {\n    }\n}\n', "ErrorArcCycle"),
            ("(\n    subLayers = [@main.usda@]\n)\n", "ErrorSublayerCycle"),
        ],
    )
    def test_cycles_have_a_type_of_their_own(self, folder: Folder, main: str, name: str) -> None:
        with Diagnostics():
            assert name in error_names(folder.stage(main))

    def test_errors_of_prims_outside_the_mask_are_not_met(self, folder: Folder) -> None:
        stage = masked(
            folder, 'def "Render" {\n}\ndef "A" (\n    references = @no.usda@\n) {\n}\n', "/Render"
        )
        assert error_names(stage) == []

    def test_a_sublayer_that_does_not_parse_is_passed_over_with_a_warning(
        self, folder: Folder
    ) -> None:
        with Diagnostics() as said:
            stage = folder.stage("(\n    subLayers = [@weak.usda@]\n)\n", weak="def {\n")
        assert any("weak.usda" in one for one in said.messages)
        assert error_names(stage) == ["ErrorInvalidSublayerPath"]

    def test_a_missing_variant_is_no_error(self, folder: Folder) -> None:
        stage = folder.stage(
            'def "A" (\n    variants = { string v = "no" }\n    prepend variantSets = "v"\n) {\n'
            '    variantSet "v" = {\n        "yes" {\n        }\n    }\n}\n'
        )
        assert error_names(stage) == []

    def test_the_map_of_a_node_leads_from_the_stage_into_its_layer_and_back(
        self, folder: Folder
    ) -> None:
        stage = folder.stage(
            'def "Render" (\n    references = @show.usda@</Show>\n) {\n}\n',
            show='def "Show" {\n    def "S" {\n        rel r = </Show/P>\n    }\n}\n',
        )
        (node,) = stage.GetPrimAtPath("/Render/S").GetPrimIndex().rootNode.children
        assert node.mapToRoot.MapTargetToSource("/Render/P") == "/Show/P"
        assert node.mapToRoot.MapSourceToTarget("/Show/P") == "/Render/P"
        assert node.mapToRoot.MapSourceToTarget("/Elsewhere").isEmpty
        assert node.GetIntroPath() == "/Render"


class TestCollections:
    PREFIX = "collection:renderVisibility"

    def collection(self, folder: Folder, name: str, *statements: str) -> Usd.CollectionAPI:
        body = "".join(f"    {s.replace('@', f'collection:{name}')}\n" for s in statements)
        stage = folder.stage(f'def RenderPass "A" {{\n{body}}}\ndef "World" {{\n}}\n')
        self.stage = stage
        return Usd.CollectionAPI(stage.GetPrimAtPath("/A"), name)

    @pytest.mark.parametrize(
        ("name", "statements", "by_relationships"),
        [
            ("renderVisibility", [], True),
            ("prune", [], False),
            ("renderVisibility", ["bool @:includeRoot = false"], False),
            ("renderVisibility", ["bool @:includeRoot = None"], False),
            ("renderVisibility", ["bool @:includeRoot.timeSamples = { 1: 0 }"], True),
            ("renderVisibility", ['token @:expansionRule = "explicitOnly"'], False),
            pytest.param(
                "renderVisibility", ['token @:mode = "expression"'], False, marks=since(26, 5)
            ),
            ("renderVisibility", ['token @:mode = "relationship"'], True),
            # The expression is ignored all the same: `mode` has to be read, too.
            ("prune", ['token @:mode = "relationship"'], False),
            ("prune", ["rel @:includes = </World>"], True),
            ("prune", ["rel @:includes = </Nowhere>"], True),
            ("prune", ["rel @:includes = </World.collection:none>"], False),
            ("prune", ["rel @:excludes = </World>"], True),
        ],
        ids=str,
    )
    def test_what_makes_usd_look_at_the_relationships(
        self, folder: Folder, name: str, statements: list[str], by_relationships: bool
    ) -> None:
        expression = 'pathExpression @:membershipExpression = "/World//"'
        found = self.collection(folder, name, expression, *statements)
        assert found.IsInRelationshipsMode() is by_relationships

    @since(26, 5)
    def test_relationship_mode_without_targets_has_no_members(self, folder: Folder) -> None:
        found = self.collection(
            folder,
            "prune",
            'token @:mode = "relationship"',
            'pathExpression @:membershipExpression = "/World//"',
        )
        assert not found.ComputeMembershipQuery().IsPathIncluded("/World")

    def test_an_unknown_predicate_raises_when_the_mode_is_asked_for(self, folder: Folder) -> None:
        found = self.collection(
            folder, "prune", 'pathExpression @:membershipExpression = "//{nope}"'
        )
        for ask in (found.IsInRelationshipsMode, found.Validate):
            with pytest.raises(Tf.ErrorException):
                ask()

    def test_includes_authored_as_an_attribute_raise(self, folder: Folder) -> None:
        found = self.collection(folder, "prune", 'string @:includes = "/World"')
        with pytest.raises(Tf.ErrorException):
            found.IsInRelationshipsMode()

    @pytest.mark.parametrize(
        ("statements", "valid"),
        [
            (["rel @:includes = </World>"], True),
            (["rel @:includes = </World>", "rel @:excludes = </World/x>"], True),
            (["rel @:includes = </World/x>", "rel @:excludes = </Other>"], False),
            (["rel @:includes = </World>", 'token @:expansionRule = "nope"'], False),
            (["rel @:includes = </A.collection:prune>"], False),
        ],
        ids=str,
    )
    def test_what_validation_refuses(
        self, folder: Folder, statements: list[str], valid: bool
    ) -> None:
        found, reason = self.collection(folder, "prune", *statements).Validate()
        assert (found, bool(reason)) == (valid, not valid)


class TestExpressions:
    ILL = 'def "A" {\n    pathExpression e = "/World/geo//{"\n}\n'

    @since(26, 11)
    def test_one_in_the_root_layer_keeps_it_from_opening_without_a_file_or_line(
        self, folder: Folder
    ) -> None:
        with pytest.raises(Tf.ErrorException) as raised:
            folder.stage(self.ILL)
        said = " ".join(e.commentary for e in raised.value.args)
        assert "Ill-formed path expression </World/geo//{> at character " in said
        assert "main.usda:" not in said

    def test_one_in_a_sublayer_is_empty_without_a_word(self, folder: Folder) -> None:
        with Diagnostics() as said:
            stage = folder.stage("(\n    subLayers = [@weak.usda@]\n)\n", weak=self.ILL)
            value = stage.GetAttributeAtPath("/A.e")
            assert value.HasAuthoredValue()
            assert value.Get().IsEmpty()
        assert said.messages == []
        assert error_names(stage) == []

    def test_one_in_a_referenced_layer_keeps_the_stage_from_opening(self, folder: Folder) -> None:
        with pytest.raises(Tf.ErrorException):
            folder.stage('def "R" (\n    references = @weak.usda@</A>\n) {\n}\n', weak=self.ILL)

    def test_its_text_can_be_tried_alone(self) -> None:
        place = "at character 14: |<input>:1:14: "  # before 26.11
        with pytest.raises(Tf.ErrorException, match=place):
            Sdf.PathExpression("/World/geo//{")
        assert Sdf.PathExpression("/World/geo//").GetText() == "/World/geo//"


class TestOpening:
    def test_a_parse_error_names_line_and_column_in_bytes(self, folder: Folder) -> None:
        with pytest.raises(Tf.ErrorException) as raised:
            folder.stage('#usda 1.0\ndef "Ä" { bad }\n')
        assert "main.usda:2:12: " in raised.value.args[0].commentary

    @pytest.mark.parametrize(
        ("name", "data"),
        [
            ("a.usda", b""),
            ("a.usda", b"\xef\xbb\xbf#usda 1.0\n"),
            ("a.usda", b"#usda1.0\n"),
            ("a.usda", b"PXR-USDC\0\0\0\0\0\0\0\0"),
            ("a.usdc", b"#usda 1.0\n"),
        ],
    )
    def test_what_is_no_layer_raises(self, tmp_path: Path, name: str, data: bytes) -> None:
        file = tmp_path / name
        file.write_bytes(data)
        with pytest.raises(Tf.ErrorException):
            Sdf.Layer.FindOrOpen(str(file))

    @pytest.mark.parametrize(("name", "data"), [("a.usdz", b"PK\x03\x04"), ("a.usd", b"\0\1\2")])
    def test_some_of_it_is_only_none(self, tmp_path: Path, name: str, data: bytes) -> None:
        file = tmp_path / name
        file.write_bytes(data)
        with Diagnostics():
            assert Sdf.Layer.FindOrOpen(str(file)) is None

    def test_a_usd_file_may_be_text_or_crate(self, folder: Folder) -> None:
        text = folder.write("text.usd", 'def "A" {\n}\n')
        layer = Sdf.Layer.FindOrOpen(text)
        assert layer.Export(str(folder.path / "crate.usdc"))
        (folder.path / "crate.usd").write_bytes((folder.path / "crate.usdc").read_bytes())
        assert Sdf.Layer.FindOrOpen(str(folder.path / "crate.usd")).GetPrimAtPath("/A")

    def test_a_layer_that_is_held_hides_what_was_written_since(self, folder: Folder) -> None:
        folder.stage('def "A" {\n}\n')
        file = folder.write("main.usda", 'def "B" {\n}\n')
        assert Sdf.Layer.FindOrOpen(file).GetPrimAtPath("/A")
        folder.stages.clear()
        assert Sdf.Layer.FindOrOpen(file).GetPrimAtPath("/B")

    def test_a_prim_dies_with_its_stage(self) -> None:
        prim = Usd.Stage.CreateInMemory().DefinePrim("/A")
        assert not prim.IsValid()

    def test_a_member_of_a_package_is_named_in_brackets_and_the_first_is_the_package(
        self, folder: Folder
    ) -> None:
        package = str(folder.path / "p.usdz")
        UsdUtils.CreateNewUsdzPackage(folder.write("in.usda", 'def "A" {\n}\n'), package)
        assert Usd.Stage.Open(package).GetRootLayer().realPath == package
        stage = folder.stage("(\n    subLayers = [@p.usdz[in.usda]@]\n)\n")
        assert stage.GetLayerStack()[-1].realPath == f"{package}[in.usda]"


@since(26, 5)
class TestDiagnostics:
    def test_a_trap_takes_warnings_off_stderr(
        self, folder: Folder, capfd: pytest.CaptureFixture[str]
    ) -> None:
        with Tf.DiagnosticTrap() as trap:
            folder.stage("(\n    subLayers = [@no.usda@]\n)\n")
            assert len(trap.GetWarnings()) == 1
            trap.Clear()
        assert capfd.readouterr().err == ""

    def test_what_is_left_in_a_trap_is_printed_when_it_ends(
        self, folder: Folder, capfd: pytest.CaptureFixture[str]
    ) -> None:
        with Tf.DiagnosticTrap():
            folder.stage("(\n    subLayers = [@no.usda@]\n)\n")
            assert capfd.readouterr().err == ""
        assert "no.usda" in capfd.readouterr().err

    def test_errors_raise_in_a_trap_too_and_carry_their_text(self, folder: Folder) -> None:
        with Tf.DiagnosticTrap() as trap, pytest.raises(Tf.ErrorException) as raised:
            folder.stage("def {\n")
        assert trap.IsClean()
        assert "main.usda" in raised.value.args[0].commentary
