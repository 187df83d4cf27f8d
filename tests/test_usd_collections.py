"""What the reading of collections relies on in usd-core, tried, and the reading itself held against it:
what is asked of a stage of which little is populated has to be what the whole stage says."""

from __future__ import annotations

import random
import subprocess
import sys
from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from pxr import Sdf, Tf, Usd

from conftest import installed, since
from usdrender_lint.diagnostics import Diagnostics, sentences
from usdrender_lint.job import Config
from usdrender_lint.lint import lint
from usdrender_lint.model import Collection, Gives, Pattern, PredicateState, RenderScope, State
from usdrender_lint.opening import open_layer
from usdrender_lint.read import read
from usdrender_lint.read.patterns import Parsed, tree
from usdrender_lint.read.predicates import means_groups, read_predicates
from usdrender_lint.read.text import Texts
from usdrender_lint.registry import select
from usdrender_lint.stage import Opened, open_stage

WORLD = """
def Xform "World" (
    prepend apiSchemas = ["CollectionAPI:paths", "CollectionAPI:pattern"]
) {
    rel collection:paths:includes = </World/chars>
    pathExpression collection:pattern:membershipExpression = "/World/geo//"
    def Camera "cam" {
    }
    def Xform "geo" {
        def Sphere "ball" {
            def GeomSubset "half" {
            }
        }
        def Xform "geo" {
            def Sphere "ball" {
            }
        }
    }
    def Xform "chars" (
        kind = "component"
    ) {
        def Sphere "hero" {
        }
    }
    def Xform "off" (
        active = false
    ) {
    }
    over "ghost" {
    }
}
"""
PATHS = [
    "/World",
    "/World/cam",
    "/World/geo",
    "/World/geo/ball",
    "/World/geo/geo",
    "/World/geo/geo/ball",
    "/World/chars",
    "/World/chars/hero",
]


def a_pass(*statements: str, name: str = "A") -> str:
    """A pass; `@:` stands for the properties of its visibility."""
    lines = "".join(
        f"        {s.replace('@:', 'collection:renderVisibility:')}\n" for s in statements
    )
    return f'    def RenderPass "{name}" {{\n{lines}    }}\n'


def in_render(*passes: str) -> str:
    return f'def Scope "Render" {{\n{"".join(passes)}}}\n'


OFF = "bool @:includeRoot = false"


def expression(text: str) -> str:
    return f'pathExpression @:membershipExpression = "{text}"'


@pytest.fixture
def collection(tmp_path: Path) -> Callable[..., Usd.CollectionAPI]:
    """The visibility of the pass with these statements, on a whole stage."""
    stages = []

    def made(*statements: str) -> Usd.CollectionAPI:
        file = tmp_path / f"{len(stages)}.usda"
        file.write_text("#usda 1.0\n" + in_render(a_pass(*statements)) + WORLD, "utf-8")
        stages.append(Usd.Stage.Open(str(file)))
        return Usd.CollectionAPI(stages[-1].GetPrimAtPath("/Render/A"), "renderVisibility")

    return made


def members(collection: Usd.CollectionAPI) -> list[str]:
    with Diagnostics():
        query = collection.ComputeMembershipQuery()
        return [path for path in PATHS if query.IsPathIncluded(path)]


class TestUsd:
    def test_a_pattern_without_stretch_holds_one_prim(self, collection: Any) -> None:
        assert members(collection(OFF, expression("/World/geo"))) == ["/World/geo"]
        assert members(collection(OFF, expression("/World/c*"))) == ["/World/cam", "/World/chars"]

    def test_an_include_holds_what_is_below(self, collection: Any) -> None:
        assert members(collection(OFF, "rel @:includes = </World/chars>")) == PATHS[-2:]

    def test_includes_take_nothing_from_an_expression(self, collection: Any) -> None:
        assert members(collection(OFF, "rel @:includes = </World.collection:pattern>")) == []
        assert members(collection(OFF, "rel @:includes = </World.collection:paths>")) == PATHS[-2:]

    def test_an_expression_takes_nothing_from_includes(self, collection: Any) -> None:
        assert members(collection(OFF, expression("%/World:paths"))) == []
        assert members(collection(OFF, expression("%/World:pattern"))) == PATHS[2:6]

    @pytest.mark.parametrize("path", ["/World.collection:nope", "/Nope.collection:nope"])
    def test_a_missing_collection_is_said_nothing_about(self, collection: Any, path: str) -> None:
        found = collection(OFF, f"rel @:includes = <{path}>")
        assert found.Validate() == (True, "")
        assert not found.IsInRelationshipsMode()
        assert members(found) == []

    def test_excludes_alone_are_of_everything_only_by_include_root(self, collection: Any) -> None:
        excluded = "rel @:excludes = </World/geo>"
        assert members(collection(excluded)) == ["/World", "/World/cam", *PATHS[-2:]]
        assert members(collection(OFF, excluded)) == []

    def test_excluding_a_collection_takes_nothing_out(self, collection: Any) -> None:
        assert members(collection("rel @:excludes = </World.collection:paths>")) == PATHS

    def test_a_relative_pattern_is_absolute_once_parsed(self, collection: Any) -> None:
        attribute = collection(OFF, expression("geo// ../x")).GetMembershipExpressionAttr()
        (spec,) = attribute.GetPropertyStack(Usd.TimeCode.Default())
        assert spec.default.GetText() == "/Render/A/geo// /Render/x"

    @since(26, 11)
    def test_letters_beyond_ascii_are_refused_by_a_sentence_that_breaks_off(self) -> None:
        with pytest.raises(Tf.ErrorException) as refused:
            Sdf.PathExpression("/World/ü")
        (error,) = refused.value.args
        with pytest.raises(UnicodeDecodeError):
            _ = error.commentary
        assert sentences(refused.value.args) == []

    def test_a_union_with_everything_is_everything(self) -> None:
        assert Sdf.PathExpression("geo// + //").GetText() == "//"

    def test_only_the_first_line_of_an_expression_is_read(self) -> None:
        """Without a word; though a line break before it is refused."""
        assert Sdf.PathExpression("/a /b\n- /b").GetText() == "/a /b"
        assert Sdf.PathExpression("/a\r\n /b").GetText() == "/a"
        with pytest.raises(Tf.ErrorException):
            Sdf.PathExpression("\n/a")

    @pytest.mark.parametrize(
        "condition", ["isMesh", "kind", "kind:nope", "variant:a=b", "specifier:nope", "hdType:mesh"]
    )
    def test_what_a_predicate_raises_at(self, collection: Any, condition: str) -> None:
        found = collection(OFF, expression("//{" + condition + "}"))
        with pytest.raises(Tf.ErrorException):
            found.ComputeMembershipQuery()

    @pytest.mark.parametrize("condition", ["isa:mesh", "isa:Nope", "hasAPI:Nope", "isa"])
    def test_an_unknown_type_matches_nothing(self, collection: Any, condition: str) -> None:
        assert members(collection(OFF, expression("//{" + condition + "}"))) == []

    def test_a_nameless_condition_holds_where_the_stretch_begins(self, collection: Any) -> None:
        assert members(collection(OFF, expression("/World//{isa:Xform}")))[0] == "/World"
        assert "/World" not in members(collection(OFF, expression("/World//*{isa:Xform}")))

    def test_a_name_after_a_nameless_condition_crashes(self) -> None:
        """Should this fail, USD has been mended, and `Parsed.crashes` may go."""
        program = (
            "from pxr import Sdf, Usd\n"
            "stage = Usd.Stage.CreateInMemory()\n"
            "prim = stage.DefinePrim('/a')\n"
            "it = Usd.CollectionAPI.Apply(prim, 'it')\n"
            "it.CreateMembershipExpressionAttr(Sdf.PathExpression('//{defined}/b'))\n"
            "print(it.Validate()[0], bool(it.ComputeMembershipQuery()), flush=True)\n"
            "it.ComputeMembershipQuery().IsPathIncluded('/a')\n"
        )
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, check=False)
        assert done.stdout.split() == [b"True", b"True"]
        assert done.returncode < 0 or done.returncode > 1

    def test_an_arc_drops_patterns_that_lead_out_of_it(self, tmp_path: Path) -> None:
        (tmp_path / "show.usda").write_text(
            '#usda 1.0\n(\n    defaultPrim = "Render"\n)\n'
            + in_render(
                a_pass(expression("/World/geo//")),
                a_pass(expression("~/World/geo//"), name="B"),
                a_pass(expression("// - /World/geo//"), name="C"),
                a_pass(expression("/Render/rig// //x"), name="D"),
            ),
            "utf-8",
        )
        main = tmp_path / "main.usda"
        main.write_text(
            '#usda 1.0\ndef "Shot" (\n    references = @./show.usda@\n) {\n}\n', "utf-8"
        )
        stage = Usd.Stage.Open(str(main))
        name = "collection:renderVisibility:membershipExpression"
        said = {n: stage.GetAttributeAtPath(f"/Shot/{n}.{name}").Get().GetText() for n in "ABCD"}
        assert said == {"A": "", "B": "//", "C": "//", "D": "/Shot/rig// //x"}


class TestPatterns:
    """Our own reading of expressions, against USD's evaluation."""

    PATTERNS = (
        "//", "/World", "/World//", "//geo", "//geo//", "/World/*", "/World/*//", "/*", "/World/g?o",
        "/World/[gc]*", "/World/[!g]*//", "//ball", "/World//ball", "/World/geo//*", "/W*/geo/ball",
        "//{isa:Sphere}", "/World//{isa:Xform}", "//geo{isa:Xform}//", "/World/geo.radius",
        "//geo/ball", "//g*//b*", "/World/chars/hero", "/", "//*", "/World/geo{isa:Sphere}/ball",
        "/World/{isa:Xform}", "//{isa:Xform}//", "//{isa:Xform}//ball", "//geo//geo//ball",
    )  # fmt: skip

    def patterns(self) -> list[str]:
        """Before 26.11 those with a class of characters cannot be read."""
        return [p for p in self.PATTERNS if "[" not in p or installed() >= (26, 11)]

    def random_expression(self, dice: random.Random, depth: int) -> str:
        if depth == 0:
            return dice.choice(self.patterns())
        one, other = (self.random_expression(dice, depth - 1) for _ in range(2))
        return dice.choice([f"~({one})", *(f"({one} {op} {other})" for op in ["+", "-", "&", ""])])

    def test_they_hold_what_usd_says_or_leave_it_open(self, collection: Any) -> None:
        dice = random.Random(20)  # noqa: S311
        found = collection(OFF, expression("//"))
        attribute = found.GetMembershipExpressionAttr()
        texts = [*self.patterns(), *(self.random_expression(dice, n % 4) for n in range(400))]
        open_answers = 0
        for text in texts:
            attribute.Set(Sdf.PathExpression(text))
            held, node = set(members(found)), tree(Sdf.PathExpression(text))
            for path in PATHS:
                said = node.holds(path) if node else False
                open_answers += said is None
                assert said in (None, path in held), (text, path)
                below = [p for p in held if p.startswith(path + "/")]
                assert not below or (node and node.may_hold_below(path)), (text, path)
        assert open_answers < len(texts) * len(PATHS) / 2

    @pytest.mark.parametrize(
        ("text", "names_all", "below", "bare"),
        [
            ("/World", True, False, True),
            ("/World//", True, True, False),
            ("/World/*", False, False, True),
            ("/World{model}", False, False, True),
            ("/World//{model}", False, False, False),
            ("/World//a", False, False, True),
            ("//", True, True, False),
            ("/World.radius", False, False, False),
        ],
    )
    def test_taking_one_apart(self, text: str, names_all: bool, below: bool, bare: bool) -> None:
        node = tree(Sdf.PathExpression(text))
        assert node
        assert node.pattern
        assert (node.pattern.names_all, node.pattern.below, node.pattern.bare) == (
            names_all,
            below,
            bare,
        )

    @pytest.mark.parametrize(
        ("text", "crashes"),
        [
            ("//{defined}/a", True),
            ("/x//{defined}/a//", True),
            ("//{defined}//a", False),
            ("//*{defined}/a", False),
            ('//a{isa:"/}/"}', False),
            ("//{defined}", False),
        ],
    )
    def test_what_usd_must_not_be_asked(self, text: str, crashes: bool) -> None:
        node = tree(Sdf.PathExpression(text))
        assert node
        assert [p.crashes for p, _ in node.patterns()] == [crashes]

    def test_signs(self) -> None:
        node = tree(Sdf.PathExpression("(/a - (/b - /c)) + (~/d & %/e:f)"))
        assert node
        assert {p.text: adds for p, adds in node.patterns()} == {
            "/a": True,
            "/b": False,
            "/c": True,
            "/d": False,
        }
        assert list(node.references()) == [("/e", "f")]

    def test_nothing(self) -> None:
        assert tree(Sdf.PathExpression()) is None
        assert isinstance(Parsed, type)


class TestPredicates:
    @pytest.mark.parametrize(
        ("condition", "state", "meant"),
        [
            ("isa:Mesh", PredicateState.KNOWN, None),
            ("model:false", PredicateState.KNOWN, None),
            ("isa:StudioMeshThing", PredicateState.KNOWN, None),
            ("isMesh", PredicateState.UNKNOWN, "isa:Mesh"),
            ("Sphere", PredicateState.UNKNOWN, "isa:Sphere"),
            ("kinds:component", PredicateState.UNKNOWN, "kind"),
            ("anything", PredicateState.UNKNOWN, None),
            ("hdType:mesh", PredicateState.HYDRA, None),
            ("kind", PredicateState.BAD_ARGUMENTS, None),
            ("variant:look=red", PredicateState.BAD_ARGUMENTS, None),
            ("isa:mesh", PredicateState.NO_SUCH_TYPE, "isa:Mesh"),
            ("isa:UsdGeomMesh", PredicateState.NO_SUCH_TYPE, "isa:Mesh"),
            ("isa:Light", PredicateState.NO_SUCH_TYPE, "hasAPI:LightAPI"),
        ],
    )
    def test_one(self, condition: str, state: PredicateState, meant: str | None) -> None:
        (found,) = read_predicates(condition)
        assert (found.state, found.meant) == (state, meant)

    def test_several(self) -> None:
        found = read_predicates("isa:Mesh and not (model or nope)")
        assert [p.name for p in found if p.state is not PredicateState.KNOWN] == ["nope"]

    @pytest.mark.parametrize(
        ("condition", "groups"),
        [
            ("model", True),
            ("kind:component", True),
            ("isa:Xform,Scope", True),
            ("isa:Gprim", False),
            ("model:false", False),
            ("model and isa:Mesh", False),
        ],
    )
    def test_which_hold_for_groups_only(self, condition: str, groups: bool) -> None:
        assert means_groups(condition) is groups


Read = Callable[..., RenderScope]


@pytest.fixture
def scope(tmp_path: Path) -> Read:
    """What is read from a masked stage, after it was found to be what the whole stage says."""

    def read_scope(*statements: str, name: str = "main.usda", **layers: str) -> RenderScope:
        for layer, text in layers.items():
            (tmp_path / f"{layer}.usda").write_text(f"#usda 1.0\n{text}", "utf-8")
        text_file = tmp_path / "main.usda"
        text_file.write_text("#usda 1.0\n" + in_render(a_pass(*statements)) + WORLD, "utf-8")
        file = tmp_path / name
        if file != text_file:
            assert Sdf.Layer.FindOrOpen(str(text_file)).Export(str(file))
        layer = open_layer(str(file))
        assert isinstance(layer, Sdf.Layer)
        with Diagnostics():
            masked = open_stage(layer, ("/Render",))
            found = read(masked, Texts())
            whole = read(Opened(Usd.Stage.Open(layer), ("/Render",)), Texts())
        assert found.passes == whole.passes
        return found

    return read_scope


def the_collection(scope: RenderScope) -> Collection:
    (found,) = scope.passes[0].collections
    return found


def with_class(*values: object) -> object:
    """Before 26.11 no expression with a class of characters can be read."""
    return pytest.param(*values, marks=since(26, 11))


class TestReading:
    def patterns(self, scope: RenderScope) -> dict[str, Pattern]:
        return {p.text: p for p in the_collection(scope).patterns}

    def test_members_and_what_is_held(self, scope: Read) -> None:
        found = the_collection(
            scope(OFF, "rel @:includes = [</World/geo>, </World/ghost>, </World/off/x>, </Wrld>]")
        )
        assert {m.path: m.state for m in found.members} == {
            "/World/geo": State.LIVE,
            "/World/ghost": State.OVER,
            "/World/off/x": State.MISSING,
            "/Wrld": State.MISSING,
        }
        assert found.held is not None
        assert {"/World/geo", "/World/ghost"} <= found.held
        assert "/World" not in found.held
        assert "/World" in found.reached

    def test_where_a_missing_one_may_be(self, scope: Read) -> None:
        found = the_collection(scope(OFF, "rel @:includes = </World/gea/ball>"))
        (member,) = found.members
        assert member.nearest == "/World"
        assert member.candidates[0].path == "/World/geo"

    @pytest.mark.parametrize(
        ("text", "cut"),
        [
            ("/World/geo", {"/World/geo": ("/World/geo",)}),
            ("/World/geo//", {}),
            ("/World/geo/ball", {}),
            ("/World/geo + /World//ball", {}),
            ("/World/geo /World/geo/geo", {"/World/geo/geo": ("/World/geo/geo",)}),
            with_class("/World/[gc]*", {"/World/[gc]*": ("/World/geo", "/World/chars")}),
            with_class("/World/[gc]* - /World/geo", {"/World/[gc]*": ("/World/chars",)}),
            with_class("/World/[gc]* & //geo", {"/World/[gc]*": ("/World/geo",)}),
            ("/*/geo/geo", {"/*/geo/geo": ("/World/geo/geo",)}),
            ("//geo", {}),
            ("/World/* ~/World/cam", {}),
            ("/World/off /World/ghost /World/cam", {}),
            ("/World/geo - /World/chars", {"/World/geo": ("/World/geo",)}),
        ],
    )
    def test_groups_that_are_cut_off(
        self, scope: Read, text: str, cut: dict[str, tuple[str, ...]]
    ) -> None:
        patterns = self.patterns(scope(OFF, expression(text)))
        assert {p.text: p.cut for p in patterns.values() if p.cut} == cut

    @pytest.mark.parametrize(
        ("text", "groups"),
        [
            ("//{kind:component}", True),
            ("//{kind:component}//", False),
            ("//{kind:component} //{isa:Gprim}", False),
            ("//{isa:Gprim}", False),
        ],
    )
    def test_conditions_for_groups(self, scope: Read, text: str, groups: bool) -> None:
        patterns = self.patterns(scope(OFF, expression(text)))
        assert any(p.names_groups for p in patterns.values()) is groups

    @pytest.mark.parametrize("name", ["main.usda", "crate.usdc"])
    def test_relative_patterns(self, scope: Read, name: str) -> None:
        text = "geo// ../../World/geo// . /Render/B//"
        patterns = self.patterns(scope(OFF, expression(text), name=name))
        assert {p.relative for p in patterns.values()} == {None, "geo//", "."}

    @pytest.mark.parametrize("name", ["main.usda", "crate.usdc"])
    def test_the_way_up_is_a_path_like_others(self, scope: Read, name: str) -> None:
        """It shows in the text only, and what is found is not to hang on the format."""
        patterns = self.patterns(scope(OFF, expression("../geo"), name=name))
        assert patterns["/Render/geo"].relative is None

    @pytest.mark.parametrize(
        ("statement", "gives"),
        [
            ("rel @:includes = </World.collection:paths>", Gives.MEMBERS),
            ("rel @:includes = </World.collection:pattern>", Gives.WRONG_MODE),
            ("rel @:includes = </World.collection:nope>", Gives.NO_COLLECTION),
            ("rel @:includes = </Wrld.collection:paths>", Gives.NO_PRIM),
            (expression("%/World:pattern"), Gives.MEMBERS),
            (expression("%/World:paths"), Gives.WRONG_MODE),
            (expression("%:nope"), Gives.NO_COLLECTION),
        ],
    )
    def test_what_another_collection_gives(self, scope: Read, statement: str, gives: Gives) -> None:
        (other,) = the_collection(scope(OFF, statement)).others
        assert other.gives is gives

    def test_the_weaker_expression_is_no_other_collection(self, scope: Read) -> None:
        assert the_collection(scope(OFF, expression("%_ + /World//"))).others == ()

    @pytest.mark.parametrize("text", ["//{isMesh}", "//{isa:Xform}/ball"])
    def test_nothing_is_held_where_usd_cannot_be_asked(self, scope: Read, text: str) -> None:
        assert the_collection(scope(OFF, expression(text))).held is None

    def test_includes_are_not_forwarded(self, scope: Read) -> None:
        found = the_collection(
            scope("rel other = </World>", OFF, "rel @:includes = </Render/A.other>")
        )
        assert [t.path for t in found.includes.targets] == ["/Render/A.other"]

    def test_an_instance_and_what_hides_a_prim(self, tmp_path: Path) -> None:
        (tmp_path / "main.usda").write_text(
            "#usda 1.0\n"
            + in_render(
                a_pass(OFF, "rel @:includes = [</W/tree>, </W/tree/leaf>, </W/plain/leaf>]")
            )
            + 'class "tree" {\n    def Sphere "leaf" {\n    }\n}\n'
            'def Xform "W" {\n    token visibility = "invisible"\n'
            '    def "tree" (\n        instanceable = true\n        inherits = </tree>\n    ) {\n    }\n'
            '    def "plain" (\n        inherits = </tree>\n    ) {\n    }\n}\n',
            "utf-8",
        )
        layer = open_layer(str(tmp_path / "main.usda"))
        assert isinstance(layer, Sdf.Layer)
        found = the_collection(read(open_stage(layer, ("/Render",)), Texts()))
        assert [m.instance for m in found.members] == ["/W/tree", "/W/tree", None]
        assert [m.invisible for m in found.members] == ["/W", "/W", "/W"]

    def test_all_is_plain_values(self, scope: Read) -> None:
        def check(value: object) -> None:
            assert not type(value).__module__.startswith("pxr"), value
            if is_dataclass(value):
                for one in fields(value):
                    check(getattr(value, one.name))
            elif isinstance(value, tuple | frozenset):
                for item in value:
                    check(item)

        found = scope(OFF, expression("geo// /World/* //{isMesh} %/World:paths"))
        check(found.passes)
        assert replace(found.passes[0]) == found.passes[0]


class TestFile:
    def read_pass(self, folder: Path, *statements: str) -> Any:
        (folder / "other.usda").write_text(
            '#usda 1.0\ndef "Render" {\n    def RenderSettings "Main" {\n    }\n}\n', "utf-8"
        )
        (folder / "broken.usda").write_text("#usda 1.0\ndef {", "utf-8")
        (folder / "script.nk").write_text("", "utf-8")
        (folder / "main.usda").write_text("#usda 1.0\n" + in_render(a_pass(*statements)), "utf-8")
        layer = open_layer(str(folder / "main.usda"))
        assert isinstance(layer, Sdf.Layer)
        with Diagnostics():
            return read(open_stage(layer, ("/Render",)), Texts()).passes[0]

    @pytest.mark.parametrize(
        ("asset", "found"),
        [
            ("./other.usda", True),
            ("script.nk", True),
            ("missing.nk", False),
            ("comp_$VERSION.nk", None),
            ("comp_{shot}.nk", None),
            ("studio:comp", None),
            ("", None),
        ],
    )
    def test_whether_it_is_found(self, tmp_path: Path, asset: str, found: bool | None) -> None:
        assert self.read_pass(tmp_path, f"asset fileName = @{asset}@").file_found is found

    @pytest.mark.parametrize(
        ("asset", "source", "state"),
        [
            ("other.usda", "</Render/Main>", State.LIVE),
            ("other.usda", "</Render/A>", State.MISSING),
            ("broken.usda", "</Render/Main>", State.UNKNOWN),
            ("other.usda", "</Render/A.node>", None),
            ("script.nk", "</Render/Main>", None),
            ("missing.usda", "</Render/Main>", None),
        ],
    )
    def test_what_the_source_is_in_it(
        self, tmp_path: Path, asset: str, source: str, state: State | None
    ) -> None:
        found = self.read_pass(
            tmp_path, f"asset fileName = @{asset}@", f"rel renderSource = {source}"
        ).source_in_file
        assert (found.state if found else None) is state


def test_a_relative_pattern_that_leads_to_something_is_left_alone(tmp_path: Path) -> None:
    file = tmp_path / "main.usda"
    body = f'    def RenderPass "A"\n    {{\n{expression("geo sky")}\n        def Mesh "geo"\n        {{\n        }}\n    }}\n'
    text = f'#usda 1.0\ndef Scope "Render"\n{{\n{body}}}\n'.replace("@", "collection:prune")
    file.write_text(text)
    report = lint([str(file)], Config(select(["relative-pattern"])), tmp_path)
    (found,) = report.findings
    assert found.message.startswith("'sky' of 'prune' is relative")
