"""Does every Sdf spec stand where `UsdaText` says?"""

from __future__ import annotations

import random
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from pxr import Sdf, Tf

from usdrender_lint.results import Span
from usdrender_lint.usda import Expression, UsdaText
from usdrender_lint.usda.lines import Lines

CORPUS = Path(__file__).parents[2] / "shared" / "corpus"

LAYER = """#usda 1.0
(
    "said of the layer"
    doc = \"\"\"over
        two lines\"\"\"
    customLayerData = {
        string renderSettingsPrimPath = "/old"
        dictionary deep = { int "a b" = 3; string 'q:r' = "z" }
    }
    renderSettingsPrimPath = "/Render/S"
    subLayers = [
        @./a.usda@,
        @./b.usda@ (offset = 10; scale = 2), @@@c@d.usda@@@
    ]
)
reorder rootPrims = ["World", "Render"]

def Scope "Render" (
    delete references = @./a.usda@
    prepend references = [@./a.usda@</X> (offset = 3), </Y>, @b.usda@ (
        offset = 3
    )]
    payload = @p.usda@
    inherits = </Z>
    variants = { string v = "a" }
    prepend variantSets = "v"
    prefixSubstitutions = { "a": "b" }
    symmetryFunction =
    active = false
    customData = { bool x = 1 }
)
{
    reorder nameChildren = ["S"]
    def "S" { rel camera = </World/C>; }
    custom uniform token[] ri:modes = ["a"] ( doc = "modes"; customData = { int n = 1 } )
    float shutter.timeSamples = { 1: 3, 2: None }
    float shutter = 4
    double curve.spline = { bezier, 1: 2 }
    float wired.connect = [</Render.shutter>, <../World.x>]
    delete rel products = <Q>
    prepend rel products = [<Q>, <../P>]
    rel products (
        displayName = "made"
    )
    float blocked = None; float after = -inf
    int [ ] spaced = []
    float nowhere = nan
    float animated = AnimationBlock
    string long = '''a
b'''
    float class = 1
    over "bare" {}
    class Foo::Bar.Baz 'quoted' {}
    variantSet "v" = {
        "a" (kind = "group") {
            token inner = "x"
            def Scope "S" {}
            variantSet "w" = {
                ".b|c" {
                    def "Deep" {}
                }
            }
        }
        'z' { }
    }
}
def "World" {}
"""


def text_at(text: UsdaText, span: Span | None) -> str:
    assert span
    return text.line(span.line)[span.column - 1 : span.end_column - 1]


def found(layer: str, *site: str | None) -> str:
    text = UsdaText(layer.encode())
    return text_at(text, text.span(*site))  # type: ignore[arg-type]


def body(statements: str) -> str:
    return f'#usda 1.0\ndef "A"\n{{\n    {statements}\n}}\n'


def accepted(layer: str) -> bool:
    return bool(Sdf.Layer.CreateAnonymous(".usda").ImportFromString(layer))


def test_the_sample_is_one() -> None:
    assert accepted(LAYER)


class TestLadder:
    @pytest.mark.parametrize(
        ("site", "expected"),
        [
            # objects
            (("/",), "#usda 1.0"),
            (("/Render",), '"Render"'),
            (("/Render/quoted",), "'quoted'"),
            (("/Render.ri:modes",), "ri:modes"),
            (("/Render.class",), "class"),
            (("/Render.after",), "after"),
            (("/Render{v=a}",), '"a"'),
            (("/Render{v=z}",), "'z'"),
            (("/Render{v=}",), '"v"'),
            (("/Render{v=a}S",), '"S"'),
            (("/Render{v=a}.inner",), "inner"),
            (("/Render{v=a}{w=.b|c}Deep",), '"Deep"'),
            # what does not exist
            (("/Render/S/missing/below",), '"S"'),
            (("/Render/missing.x", "default"), '"Render"'),
            (("/Render.missing", "default"), '"Render"'),
            (("/Render{v=missing}S",), '"Render"'),
            (("/missing", "active"), "#usda 1.0"),
            (("/Render.products", "connectionPaths"), "products"),
            (("/Render/S", "active"), '"S"'),
            # fields of prims
            (("/Render", "specifier"), "def"),
            (("/Render/bare", "specifier"), "over"),
            (("/Render/quoted", "specifier"), "class"),
            (("/Render", "typeName"), "Scope"),
            (("/Render/quoted", "typeName"), "Foo::Bar.Baz"),
            (("/Render/bare", "typeName"), '"bare"'),
            (("/Render", "active"), "false"),
            (("/Render", "symmetryFunction"), "symmetryFunction"),
            (("/Render", "prefixSubstitutions"), '{ "a": "b" }'),
            (("/Render", "inheritPaths"), "</Z>"),
            (("/Render", "variantSelection"), '{ string v = "a" }'),
            (("/Render", "variantSelection:v"), '"a"'),
            (("/Render", "variantSetNames"), '"v"'),
            (("/Render", "customData:x"), "1"),
            (("/Render", "primOrder"), '["S"]'),
            (("/Render{v=a}", "kind"), '"group"'),
            # fields of properties
            (("/Render.shutter", "default"), "4"),
            (("/Render.shutter", "timeSamples"), "{ 1: 3, 2: None }"),
            (("/Render.curve", "spline"), "{ bezier, 1: 2 }"),
            (("/Render.wired", "connectionPaths"), "[</Render.shutter>, <../World.x>]"),
            (("/Render.blocked", "default"), "None"),
            (("/Render.after", "default"), "-inf"),
            (("/Render.nowhere", "default"), "nan"),
            (("/Render.animated", "default"), "AnimationBlock"),
            (("/Render.long", "default"), "long"),
            (("/Render.ri:modes", "typeName"), "token[]"),
            (("/Render.spaced", "typeName"), "int [ ]"),
            (("/Render.products", "typeName"), "products"),
            (("/Render.ri:modes", "custom"), "custom"),
            (("/Render.ri:modes", "variability"), "uniform"),
            (("/Render.ri:modes", "documentation"), '"modes"'),
            (("/Render.ri:modes", "customData:n"), "1"),
            (("/Render.products", "displayName"), '"made"'),
            # fields of the layer
            (("/", "renderSettingsPrimPath"), '"/Render/S"'),
            (("/", "customLayerData:renderSettingsPrimPath"), '"/old"'),
            (("/", "customLayerData:deep:a b"), "3"),
            (("/", "customLayerData:deep:q:r"), '"z"'),
            (("/", "customLayerData:missing"), "customLayerData"),
            (("/", "comment"), '"said of the layer"'),
            (("/", "documentation"), "doc"),
            (("/", "primOrder"), '["World", "Render"]'),
            (("/", "missing"), "#usda 1.0"),
            # arcs
            (("/", "subLayers", "./b.usda"), "@./b.usda@"),
            (("/", "subLayers", "c@d.usda"), "@@@c@d.usda@@@"),
            (("/", "subLayers", "missing.usda"), "subLayers"),
            (("/Render", "references", "./a.usda"), "@./a.usda@</X>"),
            (("/Render", "references", "/Y"), "</Y>"),
            (("/Render", "references", "b.usda"), "@b.usda@"),
            (("/Render", "references"), "references"),
            (("/Render", "payload", "p.usda"), "@p.usda@"),
            (("/Render", "inheritPaths", "/Z"), "</Z>"),
            # targets
            (("/Render/S.camera", "targetPaths", "/World/C"), "</World/C>"),
            (("/Render.products", "targetPaths", "/P"), "<../P>"),
            (("/Render.products", None, "/P"), "<../P>"),
            (("/Render.products", "targetPaths", "/missing"), "[<Q>, <../P>]"),
            (("/Render.products", "targetPaths"), "[<Q>, <../P>]"),
            (("/Render.wired", "connectionPaths", "/World.x"), "<../World.x>"),
        ],
        ids=str,
    )
    def test_rung(self, site: tuple[str | None, ...], expected: str) -> None:
        assert found(LAYER, *site) == expected

    def test_a_target_stands_where_it_is_added_rather_than_deleted(self) -> None:
        text = UsdaText(LAYER.encode())
        span = text.span("/Render.products", "targetPaths", "/Render/Q")
        assert span
        assert "prepend" in text.line(span.line)

    def test_a_target_that_is_only_deleted_is_found(self) -> None:
        assert found(body("delete rel r = <Q>"), "/A.r", "targetPaths", "/A/Q") == "<Q>"

    def test_layer_without_anything_but_its_first_line(self) -> None:
        assert UsdaText(b"#usda 1.0  ").span("/A/B.c", "default") == Span(1, 1, 10)

    def test_empty_text_has_no_place(self) -> None:
        assert UsdaText(b"").span("/") is None


class TestTargets:
    @pytest.mark.parametrize(
        ("written", "meant"),
        [
            ("/X/Y", "/X/Y"),
            ("Q", "/P/A/Q"),
            ("Q/R.x", "/P/A/Q/R.x"),
            ("../B", "/P/B"),
            ("..", "/P"),
            ("../.x", "/P.x"),
            ("../..", "/"),
            ("../../B", "/B"),
            (".", "/P/A"),
            (".x:y", "/P/A.x:y"),
            ("Grüß", "/P/A/Grüß"),
        ],
    )
    @pytest.mark.parametrize(
        ("start", "end", "path"),
        [
            ("", "", "/P/A.r"),
            ('variantSet "v" = {\n"x" {\n', "}\n}\n", "/P/A{v=x}.r"),
        ],
        ids=["plain", "in a variant"],
    )
    def test_relative_targets_start_from_the_prim(
        self, start: str, end: str, path: str, written: str, meant: str
    ) -> None:
        layer = (
            '#usda 1.0\ndef "P" {\ndef "A" {\n'
            f"{start}rel r = [</Other>, <{written}>] # <{meant}>\n{end}}}\n}}\n"
        )
        assert found(layer, path, "targetPaths", meant) == f"<{written}>"
        assert UsdaText(layer.encode()).written_target(path, meant) == written
        assert str(Sdf.Path(written).MakeAbsolutePath("/P/A")) == meant

    @pytest.mark.parametrize("path", ["/A.r", "/A.missing", "/missing.r", "/A"])
    def test_nothing_was_written_for_another_target(self, path: str) -> None:
        assert UsdaText(body("rel r = <Q>").encode()).written_target(path, "/Other") is None

    @pytest.mark.parametrize(
        "operation", ["", "prepend ", "append ", "add ", "delete ", "reorder ", "custom "]
    )
    def test_every_kind_of_list(self, operation: str) -> None:
        layer = body(f"rel r (\n doc = 'x'\n )\n{operation}rel r = [\n  </X>, # </Y>\n  </Y>,\n ]")
        assert found(layer, "/A.r", "targetPaths", "/Y") == "</Y>"
        assert found(layer, "/A.r", "targetPaths") == "r"


class TestText:
    def test_columns_count_code_points(self) -> None:
        layer = '#usda 1.0\ndef "Grüß𠮷" {\n\tstring s = "𠮷𠮷"; rel größe:𠮷 = </Ü𠮷>\n}\n'
        assert accepted(layer)
        text = UsdaText(layer.encode())
        assert text.span("/Grüß𠮷") == Span(2, 5, 12)
        assert text.span("/Grüß𠮷.s", "default") == Span(3, 13, 17)
        assert text.span("/Grüß𠮷.größe:𠮷") == Span(3, 23, 30)
        assert text.span("/Grüß𠮷.größe:𠮷", "targetPaths", "/Ü𠮷") == Span(3, 33, 38)

    @pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"], ids=["LF", "CR LF", "CR"])
    def test_line_breaks(self, ending: str) -> None:
        layer = '#usda 1.0\n\ndef "A" {\n    float x = 1\n    float y = 2\n}\n'
        text = UsdaText(layer.replace("\n", ending).encode())
        assert text.span("/A.y", "default") == Span(5, 15, 16)
        assert [text.line(n) for n in range(1, 9)] == [*layer.split("\n"), ""]

    def test_every_byte_is_on_its_line(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(Lines, "_STEP", 4)
        chance = random.Random(1)  # noqa: S311
        for _ in range(200):
            data = b"".join(chance.choices([b"a", b"\r", b"\n", b"\r\n", b"bcd"], k=12))
            lines = Lines(data)
            kept = data.decode().splitlines(keepends=True)
            for number, line in enumerate(kept, 1):
                start = len("".join(kept[: number - 1]))
                assert lines.range(number) == (start, start + len(line.rstrip("\r\n")))
                for offset in range(start, start + len(line.rstrip("\n")) or start + 1):
                    assert lines.at(offset) == (number, start)

    def test_very_long_line(self) -> None:
        numbers = ", ".join(["0.125"] * 300_000)
        layer = body(f"float[] a = [{numbers}]; rel camera = </C>")
        assert found(layer, "/A.camera", "targetPaths", "/C") == "</C>"

    @pytest.mark.parametrize(
        "decoy",
        [
            '# def "B" { rel x = </Y>; }',
            '// def "B" { rel x = </Y>; }',
            '/* def "B" {\n rel x = </Y>; } */',
            'string d = "def \\"B\\" { rel x = </Y>; }"',
            "string d = 'it\\'s def \"B\" {'",
            'string d = """def "B" {\nrel x = </Y>\n"" \\""" {"""',
            "string d = '''\ndef \"B\" {\n'''",
            'string d = "\\\\"',
            "asset d = @{\"'#/*@",
            "asset d = @@@{@\"\\@@@'@@@@",
            'def "C" {\ndef "B" { rel x = </Y>; }\n}',
            'float y = 1 ( customData = { string B = "B"; dictionary def = { int x = 1 } } )',
            "float y.timeSamples = { 1: 2,\n 3: 4 }",
            "float2[] y = [\n(1, 2),\n(3, 4)\n]",
            'rel y = [</C.x>,\n</C>] (\n doc = "}" )',
            'variantSet "B" = { "B" {\ndef "B" { rel x = </Y>; }\n} }',
            'reorder nameChildren = ["B"]; reorder properties = ["x"]',
            "float /* rel x */ def = 1",
            "float B:x = 1",
        ],
    )
    def test_decoys(self, decoy: str) -> None:
        layer = body(f'{decoy}\n    def "B" {{\n {decoy}\n rel x = </X>; }}\n    rel z = </Z>')
        assert accepted(layer)
        text = UsdaText(layer.encode())
        prim, x, z = text.span("/A/B"), text.span("/A/B.x"), text.span("/A.z")
        assert prim
        assert x
        assert text.line(prim.line) == '    def "B" {'
        assert text.line(x.line) == " rel x = </X>; }"
        assert text_at(text, prim) + text_at(text, x) + text_at(text, z) == '"B"xz'
        assert found(layer, "/A/B.x", "targetPaths", "/X") == "</X>"

    def test_header_over_several_lines(self) -> None:
        layer = (
            '#usda 1.0\n# a comment\n\n(\n    defaultPrim = "A"\n)\n'
            'def /* { */ Scope /* ( */ """A""" # (\n(\n    doc = "(" # )\n'
            "    customData = { double3 up = (0, 1, 0) }\n)\n// {\n{\n    float x = 1\n}\n"
        )
        assert accepted(layer)
        assert found(layer, "/A", "typeName") == "Scope"
        assert found(layer, "/A") == '"""A"""'
        assert found(layer, "/A.x", "default") == "1"
        assert found(layer, "/A", "customData:up") == "(0, 1, 0)"

    @pytest.mark.parametrize(
        "text",
        [
            b"",
            b"\n",
            b"\xff\xfe\x00",
            b"PXR-USDC\x00{",
            b'#usda 1.0\ndef "A" (',
            b'#usda 1.0\ndef "A" (())',
            b'#usda 1.0\ndef "A" { rel x = [</B>',
            b'#usda 1.0\ndef "A" { string x = "',
            b"#usda 1.0\n}}}))]]",
            b"#usda 1.0\n/* " + b"{" * 1000,
            b'#usda 1.0\ndef "A" {' * 2000,
        ],
    )
    def test_text_that_sdf_refuses_does_no_harm(self, text: bytes) -> None:
        layer = UsdaText(text)
        for site in [("/A.x", "default"), ("/A.x", "targetPaths", "/B"), ("/A", "references", "x")]:
            assert (layer.span(*site) is None) is (text == b"")
        assert not list(layer.expressions())


class TestExpressions:
    def test_all_of_them(self) -> None:
        """Ill-formed ones too: for their sake the text is asked and not Sdf."""
        layer = (
            '#usda 1.0\n(\n    doc = "pathExpression x = 3"\n)\n'
            'def "A" (\n    doc = "pathExpression"\n)\n{\n'
            '    pathExpression e = "//a" ( doc = "no" )\n'
            "    uniform pathExpression[] list = [\"//b\", '//c']\n"
            '    string pathExpression = "no"\n'
            '    # pathExpression no = "no"\n'
            "    pathExpression none = None\n"
            '    variantSet "v" = {\n        "x" {\n            def "B" {\n'
            '                pathExpression s:t.timeSamples = { 1: "//d", 2: None, 3: "//e" }\n'
            "            }\n        }\n    }\n"
            '    def "C" { over "D" { pathExpression two = """//f\n//g""" } }\n}\n'
        )
        text = UsdaText(layer.encode())
        assert [(e.path, e.text, text_at(text, e.span)) for e in text.expressions()] == [
            ("/A.e", "//a", '"//a"'),
            ("/A.list", "//b", '"//b"'),
            ("/A.list", "//c", "'//c'"),
            ("/A/C/D.two", "//f\n//g", "two"),
            ("/A{v=x}B.s:t", "//d", '"//d"'),
            ("/A{v=x}B.s:t", "//e", '"//e"'),
        ]

    @pytest.mark.parametrize(
        "literal",
        [
            r'"//\"a\""',
            r"'it\'s'",
            r'"\a\b\f\n\r\t\v\\n"',
            r'"\x41\x4g\x"',
            r'"\101\1234\8"',
            r'"\q\é"',
            r'"\xc3\xa9"',
            '"""two\n\\\nlines\\""""',
            "''''a' '''",
            '""',
        ],
    )
    def test_escapes_mean_what_sdf_makes_of_them(self, literal: str) -> None:
        layer = Sdf.Layer.CreateAnonymous(".usda")
        assert layer.ImportFromString(body(f"string e = {literal}"))
        (expression,) = UsdaText(body(f"pathExpression e = {literal}").encode()).expressions()
        assert expression.text == layer.GetAttributeAtPath("/A.e").default

    def test_value(self) -> None:
        (expression,) = UsdaText(body('pathExpression e = "/a"').encode()).expressions()
        assert expression == Expression("/A.e", "/a", Span(4, 24, 28), (43, 47))


def test_large_layer() -> None:
    """The wanted prim at the end of some megabytes of arrays, prims and decoys."""
    points = ", ".join(["(12.345678, -0.98765, 1001.5)"] * 2000)
    scenery = "".join(
        f'    def Mesh "m{n}" (\n        doc = "def \\"Render\\" {{"\n    )\n    {{\n'
        f"        point3f[] points = [{points}]\n"
        f'        def Scope "Render" {{ rel camera = </Wrong>; }} # "Render"\n    }}\n'
        for n in range(60)
    )
    crowd = "".join(f'    def "p{n}" {{ float x = {n}; }}\n' for n in range(20_000))
    layer = (
        f'#usda 1.0\n(\n    renderSettingsPrimPath = "/Render/S"\n)\n'
        f'def "World"\n{{\n{scenery}{crowd}}}\n'
        '/* def Scope "Render" {} */\n'
        'def Scope "Render"\n{\n    def RenderSettings "S" { rel camera = <../../World/C>; }\n}\n'
    )
    assert len(layer) > 4_000_000
    assert accepted(layer)
    text = UsdaText(layer.encode())
    last = layer.count("\n")
    assert text.span("/Render") == Span(last - 3, 11, 19)
    assert text.span("/Render/S.camera", "targetPaths", "/World/C") == Span(last - 1, 43, 58)
    assert text_at(text, text.span("/World/p19999.x", "default")) == "19999"
    assert text_at(text, text.span("/", "renderSettingsPrimPath")) == '"/Render/S"'
    assert text_at(text, text.span("/World/m59/Render.camera", "targetPaths")) == "</Wrong>"


def test_import_is_cheap() -> None:
    """Nothing that a run without findings could do without."""
    heavy = "{'pxr', 'tree_sitter', 'usdrender_lint.usda.scan'} & set(sys.modules)"
    command = f"import sys, usdrender_lint.usda; sys.exit(bool({heavy}))"
    assert subprocess.run([sys.executable, "-c", command], check=False).returncode == 0


def text_layers() -> list[Path]:
    files = sorted(p for p in CORPUS.rglob("*") if p.suffix in (".usd", ".usda"))
    return [p for p in files if p.read_bytes().startswith(b"#usda")]


def opened(path: Path) -> Sdf.Layer | None:
    try:
        return Sdf.Layer.OpenAsAnonymous(str(path))
    except Tf.ErrorException:
        return None


def specs(layer: Sdf.Layer) -> list[Sdf.Path]:
    paths: list[Sdf.Path] = []
    layer.Traverse("/", paths.append)
    return paths


def targets(spec: Sdf.Spec) -> Iterator[Sdf.Path]:
    relationship = isinstance(spec, Sdf.RelationshipSpec)
    edits = spec.targetPathList if relationship else spec.connectionPathList
    for kind in ("explicit", "added", "prepended", "appended", "deleted", "ordered"):
        yield from getattr(edits, f"{kind}Items")


@pytest.mark.skipif(not CORPUS.is_dir(), reason="the corpus of real layers is not here")
class TestCorpus:
    def test_every_spec_and_every_target(self) -> None:
        places = 0
        for file in text_layers():
            layer = opened(file)
            text = UsdaText(file.read_bytes())
            for path in specs(layer) if layer else ():
                if path.IsTargetPath():
                    continue
                assert text_at(text, text.span(str(path))) in self.expected(path), (file, path)
                places += 1
                if path.IsPropertyPath():
                    places += self.prove_targets(text, layer.GetPropertyAtPath(path))
        assert places > 10_000

    @staticmethod
    def expected(path: Sdf.Path) -> tuple[str, ...]:
        if path.IsPropertyPath():
            return (path.name,)
        if path.IsPrimVariantSelectionPath():
            variant_set, variant = path.GetVariantSelection()
            return (f'"{variant or variant_set}"',)
        return (f'"{path.name}"', f"'{path.name}'") if path.IsPrimPath() else ("#usda 1.0",)

    @staticmethod
    def prove_targets(text: UsdaText, spec: Sdf.PropertySpec) -> int:
        owner = spec.path.GetPrimPath().StripAllVariantSelections()
        wanted = set(targets(spec))
        for target in wanted:
            path = str(spec.path)
            written = text.written_target(path, str(target))
            assert written
            assert Sdf.Path(written).MakeAbsolutePath(owner) == target
            span = text.span(path, None, str(target))
            assert text_at(text, span) == f"<{written}>", (path, target)
        return len(wanted)
