"""Is the place that a site gets the one where its opinion stands?"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import pytest
from pxr import Sdf, Usd, UsdUtils

from conftest import ROOT
from usdrender_lint.diagnostics import Diagnostics
from usdrender_lint.discover import Shown
from usdrender_lint.job import Config
from usdrender_lint.lint import lint
from usdrender_lint.locate import SYNTAX, Locator, severity_of
from usdrender_lint.model import Site
from usdrender_lint.read.text import Texts
from usdrender_lint.registry import all_rules, select
from usdrender_lint.results import Location, Report, Span
from usdrender_lint.rule import Finding, Renderer, Severity
from usdrender_lint.run import Told
from usdrender_lint.unopened import ParseProblem

NOWHERE = "(no text)"
SCENES = sorted((ROOT / "fixtures" / "bad").glob("*.usda"))


@dataclass
class Shot:
    """Layers in a folder, the first of which is the root."""

    folder: Path
    stages: list[Usd.Stage] = field(default_factory=list)

    def write(self, **layers: str) -> Shot:
        for name, text in layers.items():
            (self.folder / f"{name}.usda").write_text(f"#usda 1.0\n{text}", "utf-8")
        return self

    def location(self, site: Site, root: str = "main.usda") -> Location:
        with Diagnostics():
            stage = Usd.Stage.Open(str(self.folder / root))
            self.stages.append(stage)
            return Locator(stage, root, Texts(), Shown(self.folder), []).location(site)

    def at(
        self,
        path: str,
        field: str | None = None,
        target: str | None = None,
        root: str = "main.usda",
    ) -> tuple[str, str]:
        """The layer, and the line up to the place, which is put in braces."""
        return told(self.location(Site(path, field, target), root))


def told(location: Location) -> tuple[str, str]:
    if location.span is None:
        return location.path, NOWHERE
    assert location.source is not None
    start, end = location.span.column - 1, location.span.end_column - 1
    before, here = location.source[:start], location.source[start:end]
    return location.path, f"{before.lstrip()}{{{here}}}"


@pytest.fixture
def shot(tmp_path: Path) -> Shot:
    return Shot(tmp_path)


def render(body: str = "", layers: str = "") -> str:
    """The settings S below /Render."""
    head = f"(\n    subLayers = [{layers}]\n)\n" if layers else ""
    return f'{head}def Scope "Render"\n{{\n    def RenderSettings "S"\n    {{\n        {body}\n    }}\n}}\n'


def over(body: str, layers: str = "") -> str:
    return render(body, layers).replace("def Scope", "over").replace("def RenderSettings", "over")


class TestLadder:
    @pytest.mark.parametrize(
        ("path", "field", "place"),
        [
            ("/Render/S.resolution", "default", "int2 resolution = {(1, 1)}"),
            ("/Render/S.resolution", "typeName", "{int2}"),
            ("/Render/S.resolution", None, "int2 {resolution}"),
            ("/Render/S.resolution", "timeSamples", "int2 {resolution}"),
            ("/Render/S", "typeName", "def {RenderSettings}"),
            ("/Render/S", "specifier", "{def}"),
            ("/Render/S", None, 'def RenderSettings {"S"}'),
            # What is missing is missing on the prim that lacks it, or at the next above that is there.
            ("/Render/S", "active", 'def RenderSettings {"S"}'),
            ("/Render/S.camera", "targetPaths", 'def RenderSettings {"S"}'),
            ("/Render/S/no.camera", "targetPaths", 'def RenderSettings {"S"}'),
            ("/Render/S/no/no", None, 'def RenderSettings {"S"}'),
            ("/Render/no.camera", None, 'def Scope {"Render"}'),
            ("/no", None, "{#usda 1.0}"),
            ("/no/no.camera", "default", "{#usda 1.0}"),
            ("/", None, "{#usda 1.0}"),
            ("/", "renderSettingsPrimPath", "{#usda 1.0}"),
        ],
    )
    def test_rung(self, shot: Shot, path: str, field: str | None, place: str) -> None:
        shot.write(main=render("int2 resolution = (1, 1)"))
        assert shot.at(path, field) == ("main.usda", place)

    def test_time_samples(self, shot: Shot) -> None:
        shot.write(main=render("int2 resolution.timeSamples = { 1: (1, 1) }"))
        assert shot.at("/Render/S.resolution", "timeSamples") == (
            "main.usda",
            "int2 resolution.timeSamples = {{ 1: (1, 1) }}",
        )

    def test_samples_beside_a_default(self, shot: Shot) -> None:
        shot.write(main=render("float a = 1\n        float a.timeSamples = { 1: 2 }"))
        assert shot.at("/Render/S.a", "default")[1] == "float a = {1}"
        assert shot.at("/Render/S.a", "timeSamples")[1] == "float a.timeSamples = {{ 1: 2 }}"

    @pytest.mark.parametrize(
        ("metadata", "field", "target", "place"),
        [
            ('renderSettingsPrimPath = "/S"', "renderSettingsPrimPath", None,
             'renderSettingsPrimPath = {"/S"}'),
            ('renderSettingsPath = "/S"', "renderSettingsPath", None, 'renderSettingsPath = {"/S"}'),
            ('customLayerData = { string a = "/S" }', "customLayerData:a", None,
             'customLayerData = { string a = {"/S"}'),
            ("subLayers = [@a.usda@, @b.usda@]", "subLayers", "b.usda",
             "subLayers = [@a.usda@, {@b.usda@}"),
        ],
    )  # fmt: skip
    def test_metadata_of_the_layer(
        self, shot: Shot, metadata: str, field: str, target: str | None, place: str
    ) -> None:
        shot.write(main=f"(\n    {metadata}\n)\n")
        assert shot.at("/", field, target) == ("main.usda", place)

    @pytest.mark.parametrize(
        ("metadata", "field", "target", "place"),
        [
            ("active = false", "active", None, "active = {false}"),
            ("references = [@a.usda@</A>, @b.usda@]", "references", "b.usda",
             "references = [@a.usda@</A>, {@b.usda@}"),
            ("payload = @a.usda@</A>", "payload", "a.usda", "payload = {@a.usda@</A>}"),
            ("prepend inherits = </A>", "inheritPaths", "/A", "prepend inherits = {</A>}"),
            ("instanceable = true", "instanceable", None, "instanceable = {true}"),
        ],
    )  # fmt: skip
    def test_metadata_of_a_prim(
        self, shot: Shot, metadata: str, field: str, target: str | None, place: str
    ) -> None:
        shot.write(main=f'def "Render" (\n    {metadata}\n)\n{{\n}}\n')
        assert shot.at("/Render", field, target) == ("main.usda", place)


class TestLayers:
    def test_the_strongest_spec_that_has_the_field(self, shot: Shot) -> None:
        shot.write(
            main=over("int2 resolution", "@a.usda@, @b.usda@"),
            a=over("int2 resolution = (1, 1)"),
            b=render("int2 resolution = (2, 2)"),
        )
        assert shot.at("/Render/S.resolution", "default") == (
            "a.usda",
            "int2 resolution = {(1, 1)}",
        )
        assert shot.at("/Render/S", "typeName") == ("b.usda", "def {RenderSettings}")

    def test_without_the_field_the_strongest_of_the_object(self, shot: Shot) -> None:
        shot.write(main=over("int2 resolution", "@a.usda@"), a=render("int2 resolution"))
        assert shot.at("/Render/S.resolution", "default") == ("main.usda", "int2 {resolution}")
        assert shot.at("/Render/S.camera") == ("a.usda", 'def RenderSettings {"S"}')

    def test_a_sublayer_alone(self, shot: Shot) -> None:
        shot.write(main="(\n    subLayers = [@sub/a.usda@]\n)\n")
        (shot.folder / "sub").mkdir()
        shot.write(**{"sub/a": render("int2 resolution = (1, 1)")})
        assert shot.at("/Render/S.resolution", "default") == (
            "sub/a.usda",
            "int2 resolution = {(1, 1)}",
        )

    def test_a_stronger_layer_that_gives_no_samples(self, shot: Shot) -> None:
        shot.write(main=over("float a = 1", "@a.usda@"), a=render("float a.timeSamples = { 1: 2 }"))
        assert shot.at("/Render/S.a", "timeSamples")[0] == "a.usda"

    def test_the_layer_that_a_site_names(self, shot: Shot) -> None:
        shot.write(main=over("int2 resolution = (1, 1)", "@a.usda@"), a=render("rel camera = </C>"))
        named = str(shot.folder / "a.usda")
        site = Site("/Elsewhere.camera", "targetPaths", "/C", named, "/Render/S.camera")
        assert told(shot.location(site)) == ("a.usda", "rel camera = {</C>}")

    def test_for_the_session_layer_stands_the_root(self, shot: Shot) -> None:
        shot.write(main=render("int2 resolution = (1, 1)"))
        session = Sdf.Layer.CreateAnonymous("session.usda")
        session.ImportFromString(f"#usda 1.0\n{over('int2 resolution = (3, 3)')}")
        root = Sdf.Layer.FindOrOpen(str(shot.folder / "main.usda"))
        stage = Usd.Stage.Open(root, session)
        locator = Locator(stage, root.realPath, Texts(), Shown(shot.folder), [])
        location = locator.location(Site("/Render/S.resolution", "default"))
        assert location == Location(root.realPath, "main.usda")

    def test_below_an_inactive_prim_the_specs_are_still_there(self, shot: Shot) -> None:
        shot.write(
            main='(\n    subLayers = [@a.usda@]\n)\nover "Render" (\n    active = false\n)\n{\n}\n',
            a=render("int2 resolution = (1, 1)"),
        )
        assert shot.at("/Render/S") == ("a.usda", 'def RenderSettings {"S"}')
        assert shot.at("/Render", "active") == ("main.usda", "active = {false}")


class TestArcs:
    SHOW = (
        'def "Show"\n{\n    def RenderSettings "S"\n    {\n'
        "        int2 resolution = (1, 1)\n        rel products = [</Show/P>, </Show/Q>]\n    }\n}\n"
    )

    @pytest.mark.parametrize("arc", ["references", "payload", "inherits", "specializes"])
    def test_the_spec_in_its_own_namespace(self, shot: Shot, arc: str) -> None:
        external = arc in ("references", "payload")
        main = (
            f'def "Render" (\n    {arc} = {"@show.usda@" if external else ""}</Show>\n)\n{{\n}}\n'
        )
        shot.write(main=main + ("" if external else self.SHOW), show=self.SHOW)
        file = "show.usda" if external else "main.usda"
        assert shot.at("/Render/S.resolution", "default") == (file, "int2 resolution = {(1, 1)}")
        assert shot.at("/Render/S") == (file, 'def RenderSettings {"S"}')
        assert shot.at("/Render/S.products", "targetPaths", "/Render/Q") == (
            file,
            "rel products = [</Show/P>, {</Show/Q>}",
        )

    def test_an_override_of_a_reference_comes_first(self, shot: Shot) -> None:
        main = 'def "Render" (\n    references = @show.usda@</Show>\n)\n{\n    over "S"\n    {\n        int2 resolution = (2, 2)\n    }\n}\n'
        shot.write(main=main, show=self.SHOW)
        assert shot.at("/Render/S.resolution", "default")[1] == "int2 resolution = {(2, 2)}"
        assert shot.at("/Render/S.products", "targetPaths", "/Render/P") == (
            "show.usda",
            "rel products = [{</Show/P>}",
        )

    def test_a_reference_in_a_reference(self, shot: Shot) -> None:
        shot.write(
            main='def "Render" (\n    references = @mid.usda@</Mid/In>\n)\n{\n}\n',
            mid='def "Mid"\n{\n    def "In" (\n        references = @show.usda@</Show>\n    )\n    {\n    }\n}\n',
            show=self.SHOW,
        )
        assert shot.at("/Render/S.products", "targetPaths", "/Render/Q") == (
            "show.usda",
            "rel products = [</Show/P>, {</Show/Q>}",
        )

    def test_the_sublayer_of_a_reference(self, shot: Shot) -> None:
        shot.write(
            main='def "Render" (\n    references = @mid.usda@</Show>\n)\n{\n}\n',
            mid="(\n    subLayers = [@show.usda@]\n)\n",
            show=self.SHOW,
        )
        assert shot.at("/Render/S.resolution", "default")[0] == "show.usda"

    def test_in_a_variant(self, shot: Shot) -> None:
        shot.write(
            main='def "Render" (\n    variants = { string v = "on" }\n    prepend variantSets = "v"\n)\n{\n'
            '    variantSet "v" = {\n        "off" {\n            def RenderSettings "S"\n            {\n            }\n        }\n'
            '        "on" {\n            def RenderSettings "S"\n            {\n'
            "                int2 resolution = (1, 1); rel products = </Render/Q>\n            }\n        }\n    }\n}\n"
        )
        assert shot.at("/Render/S.resolution", "default")[1] == "int2 resolution = {(1, 1)}"
        location = shot.location(Site("/Render/S"))
        assert location.span is not None
        assert location.span.line == 14
        assert shot.at("/Render/S.products", "targetPaths", "/Render/Q")[1].endswith(
            "{</Render/Q>}"
        )

    def test_in_the_first_instance(self, shot: Shot) -> None:
        arc = "instanceable = true\n    references = @show.usda@</Show>"
        shot.write(
            main="".join(f'def "{n}" (\n    {arc}\n)\n{{\n}}\n' for n in ("Render", "Other")),
            show=self.SHOW,
        )
        for root in ("/Render", "/Other"):
            assert shot.at(f"{root}/S.resolution", "default") == (
                "show.usda",
                "int2 resolution = {(1, 1)}",
            )


class TestTargets:
    @pytest.mark.parametrize(
        ("target", "layer", "place"),
        [
            ("/A", "main.usda", "prepend rel products = [{</A>}"),
            ("/B", "a.usda", "append rel products = {</B>}"),
            ("/C", "b.usda", "rel products = [{</C>}"),
            ("/D", "b.usda", "rel products = [</C>, {</D>}"),
        ],
    )
    def test_the_list_edit_that_brought_it(
        self, shot: Shot, target: str, layer: str, place: str
    ) -> None:
        shot.write(
            main=over("prepend rel products = [</A>, </X>]", "@a.usda@, @b.usda@"),
            a=over("append rel products = </B>"),
            b=render("rel products = [</C>, </D>]"),
        )
        assert shot.at("/Render/S.products", "targetPaths", target) == (layer, place)

    def test_a_list_that_deletes_it_is_not_the_place(self, shot: Shot) -> None:
        shot.write(
            main=over("delete rel products = </A>", "@a.usda@"), a=render("rel products = </A>")
        )
        assert shot.at("/Render/S.products", "targetPaths", "/A")[0] == "a.usda"

    def test_a_relative_one(self, shot: Shot) -> None:
        shot.write(main=render("rel products = [<../P>, <Render/P>]"))
        assert shot.at("/Render/S.products", "targetPaths", "/Render/P")[1].endswith("{<../P>}")
        assert shot.at("/Render/S.products", "targetPaths", "/Render/S/Render/P")[1].endswith(
            "{<Render/P>}"
        )

    def test_one_that_nobody_lists_is_at_the_list(self, shot: Shot) -> None:
        shot.write(main=render("rel products = [</A>]"))
        assert shot.at("/Render/S.products", "targetPaths", "/B")[1] == "rel products = {[</A>]}"

    def test_a_list_over_several_lines(self, shot: Shot) -> None:
        shot.write(main=render("rel products = [\n            </A>,\n            </B>,\n        ]"))
        location = shot.location(Site("/Render/S.products", "targetPaths", "/B"))
        assert location.span == Span(8, 13, 17)


class TestFormats:
    SITE = Site("/Render/S.resolution", "default")

    def crate(self, shot: Shot, name: str) -> str:
        shot.write(tmp=render("int2 resolution = (1, 1)"))
        assert Sdf.Layer.FindOrOpen(str(shot.folder / "tmp.usda")).Export(str(shot.folder / name))
        return name

    def test_a_crate_has_no_lines(self, shot: Shot) -> None:
        name = self.crate(shot, "main.usdc")
        location = shot.location(self.SITE, name)
        assert location == Location(str(shot.folder / name), name)

    def test_a_crate_below_text(self, shot: Shot) -> None:
        self.crate(shot, "a.usdc")
        shot.write(main="(\n    subLayers = [@a.usdc@]\n)\n")
        assert shot.at("/Render/S.resolution", "default") == ("a.usdc", NOWHERE)

    def test_a_usd_file_that_is_text_has_lines(self, shot: Shot) -> None:
        shot.write(main=render("int2 resolution = (1, 1)"))
        (shot.folder / "main.usda").rename(shot.folder / "main.usd")
        assert shot.at("/Render/S.resolution", "default", root="main.usd") == (
            "main.usd",
            "int2 resolution = {(1, 1)}",
        )

    @pytest.mark.parametrize("member", ["in.usdc", "in.usda"])
    def test_a_member_of_a_package(self, shot: Shot, member: str) -> None:
        """The first is the package to USD, and the text of each is at hand."""
        shot.write(tmp=render("int2 resolution = (1, 1)"))
        text = Sdf.Layer.FindOrOpen(str(shot.folder / "tmp.usda"))
        text.Export(str(shot.folder / member))
        package = shot.folder / "p.usdz"
        assert UsdUtils.CreateNewUsdzPackage(str(shot.folder / member), str(package))
        shot.write(main="(\n    subLayers = [@p.usdz@]\n)\n")
        for root in ("p.usdz", "main.usda"):
            location = shot.location(self.SITE, root)
            assert (location.file, location.path) == (str(package), "p.usdz")
            assert location.member == member
            here = "int2 resolution = {(1, 1)}" if member == "in.usda" else NOWHERE
            assert told(location) == ("p.usdz", here)

    @pytest.mark.parametrize("ending", ["\n", "\r\n"], ids=["LF", "CR LF"])
    def test_line_breaks(self, shot: Shot, ending: str) -> None:
        text = f"#usda 1.0\n{render('int2 resolution = (1, 1)')}".replace("\n", ending)
        (shot.folder / "main.usda").write_bytes(text.encode())
        location = shot.location(self.SITE)
        assert location.span == Span(6, 27, 33)
        assert location.source == "        int2 resolution = (1, 1)"

    def test_columns_count_code_points_and_a_tab_is_one(self, shot: Shot) -> None:
        shot.write(main=render('\tstring größe = "𠮷"; int2 resolution = (1, 1)'))
        assert shot.at("/Render/S.resolution", "default")[1].endswith("resolution = {(1, 1)}")
        location = shot.location(self.SITE)
        assert location.span == Span(6, 48, 54)
        assert shot.at("/Render/S.größe", "default")[1] == 'string größe = {"𠮷"}'

    def test_a_value_over_several_lines_is_at_its_name(self, shot: Shot) -> None:
        shot.write(main=render("int2[] a = [\n            (1, 1),\n        ]"))
        assert shot.at("/Render/S.a", "default")[1] == "int2[] {a}"


class TestCrates:
    """Binary scenes are judged as their text is, but for the lines."""

    def report(self, file: Path) -> Report:
        return lint([str(file)], Config(select(["ALL"])), cwd=file.parent)

    def said(self, report: Report) -> list[tuple[str, ...]]:
        return sorted(
            (
                *self.about(f.rule.id, f.severity, f.message),
                f.prim_path,
                f.property or "",
                f.target or "",
            )
            for f in report.findings
        )

    def about(self, rule: str, severity: str, message: str) -> tuple[str, ...]:
        """A crate does not tell how a path was written: the words are others, and nothing else."""
        worded = rule in ("relative-target", "unresolved-target")
        return rule, severity, *(() if worded else (message,))

    @pytest.mark.parametrize("scene", SCENES, ids=lambda f: f.stem)
    def test_what_is_found_is_the_same(self, tmp_path: Path, scene: Path) -> None:
        crate = tmp_path / f"{scene.stem}.usdc"
        with Diagnostics():
            assert Sdf.Layer.FindOrOpen(str(scene)).Export(str(crate))
        report = self.report(crate)
        assert report.findings
        assert report.problems == ()
        assert self.said(report) == self.said(self.report(scene))
        assert {f.location.span for f in report.findings} == {None}


class TestSyntax:
    def location(self, shot: Shot, text: str, column: int) -> Location:
        file = shot.folder / "bad.usda"
        file.write_text(text, "utf-8")
        problem = ParseProblem(str(file), "", 2, column)
        locator = Locator(None, "bad.usda", Texts(), Shown(shot.folder), [problem])
        return locator.location(Site("/", SYNTAX, layer=str(file)))

    def test_where_usd_stopped(self, shot: Shot) -> None:
        location = self.location(shot, '#usda 1.0\ndef "A" { bad }\n', 11)
        assert told(location) == ("bad.usda", 'def "A" { {b}')

    def test_usd_counts_bytes(self, shot: Shot) -> None:
        location = self.location(shot, '#usda 1.0\ndef "Äö" { bad }\n', 14)
        assert told(location) == ("bad.usda", 'def "Äö" { {b}')

    @pytest.mark.parametrize("column", [17, 18, 100])
    def test_behind_the_end_of_the_line(self, shot: Shot, column: int) -> None:
        location = self.location(shot, '#usda 1.0\ndef "A" { bad  \n', column)
        assert location.span is not None
        assert location.span.column <= 17
        assert location.span.end_column >= location.span.column

    def test_a_whole_run_says_the_same(self, shot: Shot) -> None:
        shot.write(main='def "Äö" { bad }\n')
        (finding,) = lint([str(shot.folder / "main.usda")], cwd=shot.folder).findings
        assert finding.rule.id == "syntax-error"
        assert told(finding.location) == ("main.usda", 'def "Äö" { {b}')

    def test_not_where_a_parser_of_a_single_value_stopped(self, shot: Shot) -> None:
        """USD quotes it before its own place, and it counts the lines of the value."""
        shot.write(main='def "A" (\n    variants = {\n        string q = "a b"\n    }\n)\n{\n}\n')
        (finding,) = lint([str(shot.folder / "main.usda")], cwd=shot.folder).findings
        assert told(finding.location) == ("main.usda", "{v}")
        assert finding.message == "\"a b\" is not a valid variant name, near 'variants'"

    def test_a_value_of_which_usd_tells_no_line(self, shot: Shot) -> None:
        shot.write(main='def "A"\n{\n    int2 x = (1, 2, 3)\n}\n')
        (finding,) = lint([str(shot.folder / "main.usda")], cwd=shot.folder).findings
        assert told(finding.location) == ("main.usda", "int2 x = {(1, 2, 3)}")
        assert finding.message == "the value has not as many components as its type, int2"

    def test_an_expression_in_metadata(self, shot: Shot) -> None:
        data = 'customData = {\n        pathExpression e = "/a $"\n    }'
        shot.write(main=f'def "A" (\n    {data}\n)\n{{\n}}\n')
        (finding,) = lint([str(shot.folder / "main.usda")], cwd=shot.folder).findings
        assert told(finding.location) == ("main.usda", 'pathExpression e = "/a {$}')

    @pytest.mark.parametrize("arc", ["sublayer", "reference"])
    def test_the_way_to_an_expression(self, shot: Shot, arc: str) -> None:
        brings = "(\n    subLayers = [@low.usda@]\n)\n"
        by = {
            "sublayer": "(\n    subLayers = [@mid.usda@]\n)\n",
            "reference": 'def "Render" (\n    references = @mid.usda@</A>\n)\n{\n}\n',
        }
        expression = 'def "A"\n{\n    pathExpression e = "//{"\n}\n'
        shot.write(main=by[arc], mid=brings, low=expression)
        (finding,) = lint([str(shot.folder / "main.usda")], cwd=shot.folder).findings
        assert finding.rule.id == "syntax-error"
        steps = [(step.arc, step.path) for step in finding.chain]
        assert steps == [(arc, "mid.usda"), ("sublayer", "low.usda")]

    def test_an_expression_is_where_it_breaks_off(self, shot: Shot) -> None:
        shot.write(main='def "A"\n{\n    pathExpression e = "//{"\n}\n')
        (finding,) = lint([str(shot.folder / "main.usda")], cwd=shot.folder).findings
        assert told(finding.location) == ("main.usda", 'pathExpression e = "//{{"}')


class TestFindings:
    def test_what_is_related_gets_a_place_of_its_own(self, shot: Shot) -> None:
        shot.write(main=over("rel camera = </C>", "@a.usda@"), a=render("int2 resolution = (1, 1)"))
        stage = Usd.Stage.Open(str(shot.folder / "main.usda"))
        locator = Locator(stage, "main.usda", Texts(), Shown(shot.folder), [])
        related = (Site("/Render/S.resolution", "default"), "is so small")
        finding = Finding(Site("/Render/S.camera", "targetPaths", "/C"), "x", related=(related,))
        rule = all_rules()["missing-camera"]
        located = locator.locate(Told(rule, finding), Severity.NOTE)
        assert (located.prim_path, located.property, located.target) == (
            "/Render/S",
            "camera",
            "/C",
        )
        (place,) = located.related
        assert (place.message, place.prim_path, place.property) == (
            "is so small",
            "/Render/S",
            "resolution",
        )
        assert told(place.location) == ("a.usda", "int2 resolution = {(1, 1)}")

    @pytest.mark.parametrize(
        ("of_finding", "of_renderer", "chosen", "severity"),
        [
            (None, {}, {}, Severity.ERROR),
            (Severity.NOTE, {}, {}, Severity.NOTE),
            (Severity.NOTE, {"missing-camera": Severity.WARNING}, {}, Severity.WARNING),
            (None, {"missing-camera": None}, {}, None),
            (None, {"other": None}, {}, Severity.ERROR),
            (None, {"missing-camera": None}, {"missing-camera": Severity.NOTE}, Severity.NOTE),
            (Severity.NOTE, {}, {"missing-camera": Severity.ERROR}, Severity.ERROR),
        ],
    )
    def test_the_person_stands_above_the_renderer_above_the_rule(
        self,
        of_finding: Severity | None,
        of_renderer: dict[str, Severity | None],
        chosen: dict[str, Severity],
        severity: Severity | None,
    ) -> None:
        rule = all_rules()["missing-camera"]
        assert rule.severity is Severity.ERROR
        finding = Finding(Site("/S"), "x", severity=of_finding)
        renderer = Renderer("r", "R", severities=of_renderer)
        assert severity_of(rule, finding, renderer, chosen) is severity


class TestMessages:
    def test_a_long_value_is_cut_in_its_middle(self, shot: Shot) -> None:
        """In the message: the excerpt, and what is to be written, stay whole."""
        long = f"x '{'a' * 200}{'b' * 40}' y"
        finding = Finding(Site("/Render"), long, help=long)
        locator = Locator(None, "main.usda", Texts(), Shown(shot.folder), [])
        located = locator.locate(Told(all_rules()["missing-camera"], finding), Severity.NOTE)
        assert located.message == f"x '{'a' * 60} ... {'b' * 30}' y"
        assert located.help == long
