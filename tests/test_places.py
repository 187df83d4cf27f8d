"""Does a finding stand at the opinion that has to be changed, and name the others that matter?"""

from __future__ import annotations

from pathlib import Path

import pytest
from pxr import Sdf

from conftest import before
from usdrender_lint.job import Config
from usdrender_lint.lint import lint
from usdrender_lint.registry import select
from usdrender_lint.results import Located, Location, Report

META = '(\n    renderSettingsPrimPath = "/Render/S"\n)\n'
WORLD = 'def Xform "World"\n{\n    def Camera "cam"\n    {\n    }\n}\n'


def place(at: Location) -> str:
    """The layer, and its line with the place in braces."""
    name = at.path + (f"[{at.member}]" if at.member else "")
    if at.span is None or at.source is None:
        return name
    start, end = at.span.column - 1, at.span.end_column - 1
    before, here, after = at.source[:start], at.source[start:end], at.source[end:]
    return f"{name}: {before.lstrip()}{{{here}}}{after}"


class Scene:
    """Layers in a folder, of which `main.usda` is linted."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def write(self, **layers: str) -> Scene:
        for name, text in layers.items():
            file = self.folder / f"{name}.usda"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(f"#usda 1.0\n{text}", "utf-8")
        return self

    def lint(self, rule: str, root: str = "main.usda") -> Report:
        return lint([str(self.folder / root)], Config(select([rule])), cwd=self.folder)

    def all(self, rule: str, root: str = "main.usda") -> tuple[Located, ...]:
        return self.lint(rule, root).findings

    def one(self, rule: str, root: str = "main.usda") -> tuple[str, ...]:
        """The place of the only finding, then those of what is related."""
        (found,) = self.all(rule, root)
        return (place(found.location), *(place(r.location) for r in found.related))


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    return Scene(tmp_path)


def spec(
    settings: str = "rel camera = </World/cam>\n        rel products = </Render/P>",
    product: str = 'token productName = "/out/a.exr"\n        rel orderedVars = </Render/v>',
    more: str = "",
    meta: str = META,
    world: str = WORLD,
) -> str:
    return (
        f'{meta}def Scope "Render"\n{{\n    def RenderSettings "S"\n    {{\n        {settings}\n    }}\n'
        f'    def RenderProduct "P"\n    {{\n        {product}\n    }}\n'
        f'    def RenderVar "v"\n    {{\n        string sourceName = "Ci"\n    }}\n{more}}}\n{world}'
    )


def over(body: str, sublayer: str = "w.usda") -> str:
    return (
        f'(\n    renderSettingsPrimPath = "/Render/S"\n    subLayers = [@{sublayer}@]\n)\n'
        f'over "Render"\n{{\n    over "S"\n    {{\n        {body}\n    }}\n}}\n'
    )


class TestTheOpinionThatCounts:
    RIGHT = "rel camera = </World/cam>\n        rel products = </Render/P>\n        uniform int2 resolution = (0, 0)"

    def test_a_mistyped_one_is_passed_over(self, scene: Scene) -> None:
        scene.write(main=over("float2 resolution = (3, 3)"), w=spec(self.RIGHT))
        assert scene.one("invalid-resolution") == ("w.usda: uniform int2 resolution = {(0, 0)}",)
        assert scene.one("type-mismatch") == ("main.usda: {float2} resolution = (3, 3)",)

    def test_a_weaker_mistyped_one_is_not_asked(self, scene: Scene) -> None:
        mistyped = self.RIGHT.replace("int2", "float2")
        scene.write(main=over("int2 resolution = (0, 0)"), w=spec(mistyped))
        assert scene.one("invalid-resolution") == ("main.usda: int2 resolution = {(0, 0)}",)

    def test_through_a_reference(self, scene: Scene) -> None:
        main = (
            META
            + 'def "Render" (\n    references = @w.usda@</Render>\n)\n{\n    over "S"\n    {\n        float2 resolution = (3, 3)\n    }\n}\n'
        )
        scene.write(main=main + WORLD, w=spec(self.RIGHT))
        assert scene.one("invalid-resolution") == ("w.usda: uniform int2 resolution = {(0, 0)}",)

    def test_what_is_missing_is_missing_where_the_prim_is_defined(self, scene: Scene) -> None:
        scene.write(main=over("int a = 1"), w=spec("rel products = </Render/P>"))
        assert scene.one("missing-camera") == ('w.usda: def RenderSettings {"S"}',)

    def test_of_overs_alone_the_strongest_will_do(self, scene: Scene) -> None:
        orphan = 'over "Render"\n{\n    over RenderSettings "S"\n    {\n    }\n}\n'
        scene.write(main=over("int a = 1") + 'def "World"\n{\n}\n', w=orphan)
        assert scene.one("default-settings-not-live")[1] == 'main.usda: over {"S"}'


class TestWhatIsNotLive:
    OFF = '(\n    subLayers = [@w.usda@]\n    renderSettingsPrimPath = "/Render/S"\n)\nover "{}" (\n    active = false\n)\n{{\n}}\n'

    @pytest.mark.parametrize("prim", ["World", "Above"])
    def test_the_opinion_that_switches_it_off(self, scene: Scene, prim: str) -> None:
        """Of the prim itself or of one above it, in whatever layer."""
        world = 'def "Above"\n{\n    def Camera "cam"\n    {\n    }\n}\ndef Camera "World"\n{\n}\n'
        target = "</Above/cam>" if prim == "Above" else "</World>"
        weak = spec(f"rel camera = {target}\n        rel products = </Render/P>", world=world)
        scene.write(main=self.OFF.format(prim), w=weak)
        assert scene.one("dead-target") == (
            f"w.usda: rel camera = {{{target}}}",
            "main.usda: active = {false}",
        )

    def test_the_default_settings(self, scene: Scene) -> None:
        main = over("").replace('"S"\n', '"S" (\n        active = false\n    )\n')
        scene.write(main=main, w=spec())
        assert scene.one("default-settings-not-live") == (
            'main.usda: renderSettingsPrimPath = {"/Render/S"}',
            "main.usda: active = {false}",
        )


class TestChainsOfRelationships:
    def shot(self, *relationships: str) -> str:
        return 'def "Shot"\n{\n' + "".join(f"    custom {r}\n" for r in relationships) + "}\n"

    def test_the_end_is_what_is_broken(self, scene: Scene) -> None:
        broken = spec(
            "rel camera = </Shot.a>\n        rel products = </Render/P>",
            world=WORLD + self.shot("rel a = </Shot.b>", "rel b = </World/no>"),
        )
        scene.write(main=broken)
        assert scene.one("unresolved-target")[:2] == (
            "main.usda: custom rel b = {</World/no>}",
            "main.usda: rel camera = {</Shot.a>}",
        )

    def test_one_end_of_two_chains_is_one_finding(self, scene: Scene) -> None:
        more = '    def RenderProduct "Q"\n    {\n        token productName = "/out/q.exr"\n        rel orderedVars = </Shot.vars>  # Q\n    }\n'
        both = spec(
            "rel camera = </World/cam>\n        rel products = [</Render/P>, </Render/Q>]",
            'token productName = "/out/a.exr"\n        rel orderedVars = </Shot.vars>  # P',
            more,
            world=WORLD + self.shot("rel vars = </Render/no>"),
        )
        scene.write(main=both)
        at, *related = scene.one("unresolved-target")
        assert at == "main.usda: custom rel vars = {</Render/no>}"
        assert related[:1] + related[2:] == [
            f"main.usda: rel orderedVars = {{</Shot.vars>}}  # {name}" for name in "PQ"
        ]

    @pytest.mark.parametrize(
        ("rule", "target", "end"),
        [
            ("wrong-target-type", "World", "{</World>}"),
            ("dead-target", "World/off", "{</World/off>}"),
        ],
    )
    def test_whatever_is_wrong_with_it(
        self, scene: Scene, rule: str, target: str, end: str
    ) -> None:
        world = (
            WORLD
            + 'over "World"\n{\n    def Camera "off" (\n        active = false\n    )\n    {\n    }\n}\n'
        )
        world = WORLD.replace(
            "    def Camera",
            '    def Camera "off" (\n        active = false\n    )\n    {\n    }\n    def Camera',
        )
        rel = "rel camera = </Shot.a>\n        rel products = </Render/P>"
        scene.write(main=spec(rel, world=world + self.shot(f"rel a = </{target}>")))
        assert scene.one(rule)[:2] == (
            f"main.usda: custom rel a = {end}",
            "main.usda: rel camera = {</Shot.a>}",
        )

    def test_a_second_camera_at_the_end_of_a_chain(self, scene: Scene) -> None:
        world = WORLD + 'def Camera "other"\n{\n}\n' + self.shot("rel a = [</World/cam>, </other>]")
        rel = "rel camera = </Shot.a>\n        rel products = </Render/P>"
        scene.write(main=spec(rel, world=world))
        assert scene.one("multiple-cameras") == (
            "main.usda: custom rel a = [</World/cam>, {</other>}]",
            "main.usda: rel camera = {</Shot.a>}",
        )

    @pytest.mark.parametrize(
        ("last", "end"),
        [
            ("rel b", "custom rel {b}"),
            ("rel b = []", "custom rel b = {[]}"),
            ("rel b = </Shot.a>", "custom rel b = {</Shot.a>}"),
        ],
    )
    def test_a_dead_end_is_related(self, scene: Scene, last: str, end: str) -> None:
        rel = "rel camera = </Shot.a>\n        rel products = </Render/P>"
        scene.write(main=spec(rel, world=WORLD + self.shot("rel a = </Shot.b>", last)))
        assert scene.one("missing-camera") == (
            "main.usda: rel {camera} = </Shot.a>",
            f"main.usda: {end}",
        )


class TestWhatWasMeant:
    """A name that is near is asked for; the only prim of the type is no guess at all."""

    @pytest.mark.parametrize(
        ("written", "help"),
        [
            ("/World/cmam", "did you mean </World/cam>?"),
            ("/World/CAM", "did you mean </World/cam>?"),
            ("/World/distance", "the only Camera found is </World/cam>"),
        ],
    )
    def test_a_camera(self, scene: Scene, written: str, help: str) -> None:
        scene.write(main=spec(f"rel camera = <{written}>\n        rel products = </Render/P>"))
        (found,) = scene.all("unresolved-target")
        assert found.help == help


class TestCyclesOfPasses:
    def passes(self, **inputs: str) -> str:
        return spec(
            more="".join(
                f'    def RenderPass "{n}"\n    {{\n        rel renderSource = </Render/S>\n        rel inputPasses = {i}\n    }}\n'
                for n, i in inputs.items()
            )
        )

    def test_every_edge_is_told_and_the_last_one_is_the_place(self, scene: Scene) -> None:
        scene.write(main=self.passes(B="</Render/C>", C="</Render/A>", A="</Render/B>"))
        assert scene.one("input-pass-cycle") == tuple(
            f"main.usda: rel inputPasses = {{</Render/{n}>}}" for n in "ABC"
        )

    def test_two_that_share_a_pass(self, scene: Scene) -> None:
        scene.write(
            main=self.passes(A="</Render/B>", B="[</Render/A>, </Render/C>]", C="[</Render/B>]")
        )
        assert [place(f.location) for f in scene.all("input-pass-cycle")] == [
            "main.usda: rel inputPasses = [{</Render/A>}, </Render/C>]",
            "main.usda: rel inputPasses = [</Render/A>, {</Render/C>}]",
        ]

    def test_a_pass_that_waits_for_itself(self, scene: Scene) -> None:
        scene.write(main=self.passes(A="</Render/A>"))
        assert scene.one("input-pass-cycle") == ("main.usda: rel inputPasses = {</Render/A>}",)


class TestArcs:
    """What an arc does not bring is to be mended in its list."""

    def test_an_item_of_a_list(self, scene: Scene) -> None:
        scene.write(main=over("", "w.usda@, @no.usda"), w=spec())
        assert scene.one("composition-error") == ("main.usda: subLayers = [@w.usda@, {@no.usda@}]",)

    def test_one_of_two_that_name_the_same_layer(self, scene: Scene) -> None:
        arcs = "(\n        references = [@w.usda@</A>, @w.usda@</B>]\n    )"
        both = spec().replace('RenderVar "v"', f'RenderVar "v" {arcs}')
        scene.write(main=both, w='def "A"\n{\n}\n')
        assert scene.one("composition-error") == (
            "main.usda: references = [@w.usda@</A>, {@w.usda@</B>}]",
        )

    def test_in_a_layer_that_is_referenced(self, scene: Scene) -> None:
        inner = (
            'def "Rig"\n{\n    def "cam" (\n        payload = @no.usda@\n    )\n    {\n    }\n}\n'
        )
        world = 'def "World" (\n    references = @rig.usda@</Rig>\n)\n{\n}\n'
        scene.write(main=spec(world=world), rig=inner)
        assert scene.one("composition-error")[0] == "rig.usda: payload = {@no.usda@}"

    def test_in_a_variant(self, scene: Scene) -> None:
        arcs = '(\n        variants = { string v = "on" }\n        variantSets = "v"\n    )'
        body = '\n        variantSet "v" = {\n            "off" (references = @no.usda@</Off>) {\n            }\n            "on" (references = @no.usda@</On>) {\n            }\n        }\n'
        text = spec().replace('RenderVar "v"\n    {', f'RenderVar "v" {arcs}\n    {{{body}')
        scene.write(main=text)
        assert scene.one("composition-error") == (
            'main.usda: "on" (references = {@no.usda@</On>}) {',
        )

    def test_who_else_asks_for_it_is_related(self, scene: Scene) -> None:
        """The root layer comes first, whatever the layers are called."""
        scene.write(
            main=over("", "no.usda@, @a.usda"),
            a="(\n    subLayers = [@no.usda@]\n)\n" + spec(meta=""),
        )
        assert scene.one("composition-error") == (
            "main.usda: subLayers = [{@no.usda@}, @a.usda@]",
            "a.usda: subLayers = [{@no.usda@}]",
        )


class TestLayersThatDoNotParse:
    """Who opens one wants to know what for."""

    BROKEN = 'def "A"\n{\n    what\n}\n'

    def test_a_sublayer(self, scene: Scene) -> None:
        scene.write(main=over("", "x.usda@, @w.usda"), x="", w=self.BROKEN)
        assert scene.one("syntax-error") == (
            "w.usda: {w}hat",
            "main.usda: subLayers = [@x.usda@, {@w.usda@}]",
        )

    def test_a_reference(self, scene: Scene) -> None:
        world = 'def "World" (\n    references = @w.usda@</A>\n)\n{\n}\n'
        scene.write(main=spec(world=world), w=self.BROKEN)
        assert scene.one("syntax-error") == (
            "w.usda: {w}hat",
            "main.usda: references = {@w.usda@</A>}",
        )


class TestExpressionsOfArcs:
    def sublayer(self, expression: str, variables: str = "") -> str:
        return f'(\n    renderSettingsPrimPath = "/Render/S"\n    expressionVariables = {{ {variables} }}\n    subLayers = [@`{expression}`@]\n)\n'

    def test_what_leads_to_no_file(self, scene: Scene) -> None:
        scene.write(main=self.sublayer('"${SHOT}.usda"', 'string SHOT = "no"') + spec(meta=""))
        assert scene.one("composition-error") == (
            'main.usda: subLayers = [{@`"${SHOT}.usda"`@}]',
            'main.usda: expressionVariables = { string SHOT = {"no"} }',
        )
        (found,) = scene.all("composition-error")
        assert found.message.endswith("comes to 'no.usda', which leads to no file")

    def test_a_variable_that_nobody_sets(self, scene: Scene) -> None:
        scene.write(main=self.sublayer('"${SHOT}.usda"') + spec(meta=""))
        (found,) = scene.all("composition-error")
        assert found.help == "write SHOT in the expressionVariables of the root layer"

    def test_what_cannot_be_evaluated(self, scene: Scene) -> None:
        """USD names no layer but the session layer, whose name is an address in memory."""
        scene.write(main=self.sublayer('"${SHOT}.usda') + spec(meta=""))
        assert scene.one("composition-error") == ('main.usda: subLayers = [{@`"${SHOT}.usda`@}]',)
        (found,) = scene.all("composition-error")
        assert "0x" not in repr((found.message, found.location, found.related, found.roots))

    def test_of_a_reference(self, scene: Scene) -> None:
        arc = '(\n        references = @`"${SHOT}`@\n    )'
        scene.write(main=spec().replace('RenderVar "v"', f'RenderVar "v" {arc}'))
        assert scene.one("composition-error") == ('main.usda: references = {@`"${SHOT}`@}',)


class TestCyclesOfArcs:
    def test_sublayers(self, scene: Scene) -> None:
        scene.write(
            main=over("", "a.usda"), a="(\n    subLayers = [@w.usda@, @main.usda@]\n)\n", w=spec()
        )
        assert scene.one("composition-error") == (
            "a.usda: subLayers = [@w.usda@, {@main.usda@}]",
            "main.usda: subLayers = [{@a.usda@}]",
        )

    @pytest.mark.parametrize("arc", ["references", "payload"])
    def test_layers_that_refer_to_each_other(self, scene: Scene, arc: str) -> None:
        scene.write(
            main=f'def "Render" (\n    {arc} = @a.usda@</A>\n)\n{{\n}}\n',
            a=f'def "A" (\n    {arc} = @main.usda@</Render>\n)\n{{\n}}\n',
        )
        assert scene.one("composition-error") == (
            f"a.usda: {arc} = {{@main.usda@</Render>}}",
            f"main.usda: {arc} = {{@a.usda@</A>}}",
        )

    def test_classes_that_inherit_each_other(self, scene: Scene) -> None:
        pair = "".join(
            f'    class "{a}" (\n        inherits = </Render/{b}>\n    )\n    {{\n    }}\n'
            for a, b in ("xy", "yx")
        )
        scene.write(main=spec(more=pair))
        assert scene.one("composition-error") == (
            "main.usda: inherits = {</Render/x>}",
            "main.usda: inherits = {</Render/y>}",
        )


class TestPackages:
    """The text of a member has lines, comments and expressions like any other."""

    def package(self, scene: Scene, **members: str) -> str:
        scene.write(**members)
        with Sdf.ZipFileWriter.CreateNew(str(scene.folder / "p.usdz")) as writer:
            for name in members:
                writer.AddFile(str(scene.folder / f"{name}.usda"), f"{name}.usda")
        return "p.usdz"

    LOST = "rel camera = </World/no>  {}\n        rel products = </Render/P>"

    def test_the_first_member(self, scene: Scene) -> None:
        root = self.package(scene, main=spec(self.LOST.format("")))
        assert scene.one("unresolved-target", root)[0] == (
            "p.usdz[main.usda]: rel camera = {</World/no>}  "
        )

    def test_a_member_below_it(self, scene: Scene) -> None:
        root = self.package(scene, main=over(""), w=spec(self.LOST.format("")))
        assert scene.one("unresolved-target", root)[0] == (
            "p.usdz[w.usda]: rel camera = {</World/no>}  "
        )

    def test_a_member_of_a_package_in_a_package(self, scene: Scene) -> None:
        inner = self.package(scene, main=spec(self.LOST.format("")))
        (scene.folder / inner).rename(scene.folder / "in.usdz")
        (scene.folder / "top.usda").write_text(f"#usda 1.0\n{over('', 'in.usdz')}", "utf-8")
        with Sdf.ZipFileWriter.CreateNew(str(scene.folder / "p.usdz")) as writer:
            for name in ("top.usda", "in.usdz"):
                writer.AddFile(str(scene.folder / name), name)
        assert scene.one("unresolved-target", "p.usdz")[0].startswith(
            "p.usdz[in.usdz[main.usda]]: rel camera"
        )

    @pytest.mark.parametrize("member", ["main", "w"])
    def test_comments_silence(self, scene: Scene, member: str) -> None:
        comment = "# usdrender-lint: ignore[unresolved-target] why not"
        broken = spec(self.LOST.format(comment))
        members = {"main": broken} if member == "main" else {"main": over(""), "w": broken}
        report = scene.lint("unresolved-target", self.package(scene, **members))
        assert report.findings == ()
        assert [f.location.member for f in report.suppressed] == [f"{member}.usda"]

    def test_a_comment_that_silences_nothing_has_its_place(self, scene: Scene) -> None:
        text = spec("rel camera = </World/cam>  # usdrender-lint: ignore[unresolved-target]")
        report = lint(
            [str(scene.folder / self.package(scene, main=text))],
            Config(select(["default"])),
            cwd=scene.folder,
        )
        (unused,) = (f for f in report.findings if f.rule.id == "unused-suppression")
        assert place(unused.location) == (
            "p.usdz[main.usda]: rel camera = </World/cam>  # usdrender-lint: ignore[{unresolved-target}]"
        )

    BROKEN = 'def "A"\n{\n    what\n}\n'

    def test_a_first_member_that_does_not_parse(self, scene: Scene) -> None:
        root = self.package(scene, main=self.BROKEN)
        assert scene.one("syntax-error", root) == ("p.usdz[main.usda]: {w}hat",)

    def test_a_member_that_does_not_parse(self, scene: Scene) -> None:
        root = self.package(scene, main=over(""), w=self.BROKEN)
        assert scene.one("syntax-error", root) == (
            "p.usdz[w.usda]: {w}hat",
            "p.usdz[main.usda]: subLayers = [{@w.usda@}]",
        )


class TestExpressions:
    """A pattern is at its own columns, however the expression is written. It has one line: what comes
    after a line break is not read."""

    WORLD = WORLD.replace("{\n    def", '{\n    def Sphere "ball"\n    {\n    }\n    def', 1)

    def expression(self, written: str, more: str = "") -> str:
        render_pass = (
            '    def RenderPass "A"\n    {\n        rel renderSource = </Render/S>\n'
            f"        pathExpression collection:prune:membershipExpression = {written}\n{more}    }}\n"
        )
        return spec(more=render_pass, world=self.WORLD)

    @pytest.mark.parametrize(
        ("written", "shown"),
        [
            ('"/World/no /World/ball"', '"{/World/no} /World/ball"'),
            ('"/World/ball + /World/no//"', '"/World/ball + {/World/no//}"'),
            ('"/World//{isa:Sphere} - /World/no"', '"/World//{isa:Sphere} - {/World/no}"'),
            ('"/World/ball (/World/cam & /World/no)"', '"/World/ball (/World/cam & {/World/no})"'),
            ('"/World/nobody ~/World/no"', '"{/World/nobody} ~/World/no"'),
            ("'''/World/ball /World/no'''", "'''/World/ball {/World/no}'''"),
            ('"/World/\\x62all /World/no"', '"/World/\\x62all {/World/no}"'),
            ('"\\t/World/no\\t/World/ball"', '"\\t{/World/no}\\t/World/ball"'),
        ],
    )
    def test_on_one_line(self, scene: Scene, written: str, shown: str) -> None:
        scene.write(main=self.expression(written))
        first = scene.all("unresolved-member")[0]
        assert place(first.location).endswith(f"= {shown}")

    def test_a_condition_is_read_as_usd_reads_it(self, scene: Scene) -> None:
        scene.write(main=self.expression("\"/World/ball /World//{ isa:'Spher' }\""))
        (found,) = scene.all("unknown-predicate")
        assert found.location.span is not None
        assert place(found.location).endswith("/World/ball {/World//{ isa:'Spher' }}\"")

    def test_what_is_written_relative(self, scene: Scene) -> None:
        scene.write(main=self.expression('"/World/ball World/geo//"'))
        assert scene.one("relative-pattern")[0].endswith('"/World/ball {World/geo//}"')

    def test_another_collection(self, scene: Scene) -> None:
        scene.write(main=self.expression('"/World/ball %/World:no"'))
        (found,) = scene.all("missing-included-collection")
        assert place(found.location).endswith('"/World/ball {%/World:no}"')

    def test_through_a_reference(self, scene: Scene) -> None:
        """The layer knows the prim by another name."""
        scene.write(
            main=META + 'def "Render" (\n    references = @w.usda@</Show>\n)\n{\n}\n' + self.WORLD,
            w='def "Show"\n{\n    def RenderPass "A"\n    {\n        rel renderSource = </Show/S>\n'
            '        pathExpression collection:prune:membershipExpression = "/Show/S /Show/no"\n    }\n'
            '    def RenderSettings "S"\n    {\n    }\n}\n',
        )
        (found,) = scene.all("unresolved-member")
        assert place(found.location).endswith('= "/Show/S {/Show/no}"')

    def test_a_weaker_one_that_a_stronger_one_takes_in(self, scene: Scene) -> None:
        stronger = 'over "Render"\n{\n    over "A"\n    {\n        pathExpression collection:prune:membershipExpression = "%_ + /World/ball"\n    }\n}\n'
        scene.write(
            main='(\n    renderSettingsPrimPath = "/Render/S"\n    subLayers = [@w.usda@]\n)\n'
            + stronger,
            w=self.expression('"/World/no"'),
        )
        assert scene.one("unresolved-member")[0].startswith("w.usda: pathExpression")

    @pytest.mark.parametrize(
        ("written", "shown"),
        [
            ('"/World/ball $x"', '"/World/ball {$x}"'),
            ('"/World/ball\\t-"', '"/World/ball\\t-{"}'),
            pytest.param('"/World/[gc]"', '"/World/{[gc]}"', marks=before(26, 11)),
            ('"""/World/ball\n        /World/cam"""', '{/World/cam}"""'),
            ('"""\n        /World/ball"""', '{collection:prune:membershipExpression} = """'),
        ],
    )
    def test_where_it_is_ill_formed(self, scene: Scene, written: str, shown: str) -> None:
        scene.write(main=self.expression(written))
        (found,) = scene.all("syntax-error")
        assert place(found.location).endswith(shown)


class TestTheWayToALayer:
    """How the root comes to the layer that holds the opinion."""

    BROKEN = spec("rel camera = </World/no>\n        rel products = </Render/P>", meta="")

    def way(self, scene: Scene, rule: str = "unresolved-target", root: str = "main.usda") -> str:
        (found,) = scene.all(rule, root)
        return " ".join(f"({step.arc}) {step.path}" for step in found.chain)

    def arc(self, name: str, to: str, kind: str = "references") -> str:
        return f'def "{name}" (\n    {kind} = {to}\n)\n{{\n}}\n'

    def test_none_to_the_root(self, scene: Scene) -> None:
        scene.write(main=self.BROKEN)
        assert self.way(scene) == ""

    def test_sublayers(self, scene: Scene) -> None:
        scene.write(
            main="(\n    subLayers = [@x.usda@, @a.usda@]\n)\n",
            x="",
            a="(\n    subLayers = [@x.usda@, @b.usda@]\n)\n",
            b=self.BROKEN,
        )
        assert self.way(scene) == "(sublayer) a.usda (sublayer) b.usda"

    @pytest.mark.parametrize(("kind", "arc"), [("references", "reference"), ("payload", "payload")])
    def test_through_an_arc(self, scene: Scene, kind: str, arc: str) -> None:
        scene.write(main=self.arc("Render", "@a.usda@</Render>", kind) + WORLD, a=self.BROKEN)
        assert self.way(scene, "target-outside-reference") == f"({arc}) a.usda"

    def test_a_sublayer_that_refers_to_one_with_a_sublayer(self, scene: Scene) -> None:
        scene.write(
            main="(\n    subLayers = [@light.usda@]\n)\n" + WORLD,
            light=self.arc("Render", "@look.usda@</Render>"),
            look="(\n    subLayers = [@aovs.usda@]\n)\n",
            aovs=self.BROKEN,
        )
        assert self.way(scene, "target-outside-reference") == (
            "(sublayer) light.usda (reference) look.usda (sublayer) aovs.usda"
        )

    def test_a_reference_in_a_reference(self, scene: Scene) -> None:
        scene.write(
            main=self.arc("Render", "@a.usda@</A>") + WORLD,
            a='def "A"\n{\n    def "In" (\n        references = @b.usda@</Render>\n    )\n    {\n    }\n}\n',
            b='def "Render"\n{\n    def RenderSettings "S"\n    {\n        int2 resolution = (0, 0)\n    }\n}\n',
        )
        assert self.way(scene, "invalid-resolution") == "(reference) a.usda (reference) b.usda"

    def test_within_a_variant(self, scene: Scene) -> None:
        text = (
            'def "Render" (\n    variants = { string v = "on" }\n    variantSets = "v"\n)\n{\n    variantSet "v" = {\n'
            '        "on" (\n            references = @a.usda@</Render>\n        ) {\n        }\n    }\n}\n'
        )
        scene.write(main=text + WORLD, a=self.BROKEN)
        assert self.way(scene, "target-outside-reference") == "(reference) a.usda"

    def test_to_what_a_layer_says_of_itself(self, scene: Scene) -> None:
        scene.write(
            main=self.arc("Render", "@a.usda@</Render>") + WORLD,
            a="(\n    subLayers = [@no.usda@]\n)\n" + self.BROKEN,
        )
        assert self.way(scene, "composition-error") == "(reference) a.usda"
