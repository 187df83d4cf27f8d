"""What keeps text from being usda is told by its line, its column and what is wrong there."""

from __future__ import annotations

from pathlib import Path

import pytest
from pxr import Sdf

from conftest import since
from usdrender_lint.lint import lint
from usdrender_lint.usda.unread import is_type

IN_SETTINGS = {
    'rel products = [</A>, </B>\n    ¦}\n    def "x"\n    {': (
        "expected a comma, or ] for the [ of line 6, found '}'"
    ),
    "rel products = [</A>, </B>¦)": "expected a comma or ], found ')'",
    "rel products = [<Render/A> ¦<Render/B>]": "expected a comma or ], found '<Render/B>]'",
    'token[] x = ["a" ¦"b"]': "expected a comma or ], found '\"b\"]'",
    'string x = ¦"abc': "a string is not closed",
    "string x = ¦'abc": "a string is not closed",
    'string x = ¦"""abc "" \\"""': "a string is not closed",
    "string x = ¦'''abc": "a string is not closed",
    "asset x = ¦@a.usda": "an asset path is not closed",
    "int x = ¦12abc": "'12abc' is no number",
    "float x = ¦1.2.3": "'1.2.3' is no number",
    "¦preprend rel products = </A>": "'preprend' is no keyword: did you mean 'prepend'?",
    '¦defn RenderVar "x"\n        {\n        }': "'defn' is no keyword: did you mean 'def'?",
    '¦variantset "look" = {\n        }': "'variantset' is no keyword: did you mean 'variantSet'?",
    '¦RenderVar "x"\n        {\n        }': "'def', 'over' or 'class' is missing before 'RenderVar'",
    "rel produ ¦cts = </A>": "expected '=', found 'cts'",
    'token product ¦Name = "a.exr"': "expected '=', found 'Name'",
    "int ¦= 1": "a name is missing after 'int'",
    "¦int": "'int' begins no statement that USD can read",
    "¦uniform": "something is missing after 'uniform'",
    "int x ¦=": "a value is missing after '='",
    "int x ¦= # one": "a value is missing after '='",
    "int x ¦1": "expected '=', found '1'",
    "double x.¦conect = </A.b>": (
        "after the '.' of an attribute stands 'timeSamples', 'connect' or 'spline',"
        " and not 'conect'"
    ),
    "int ¦2x = 1": "a name cannot begin with '2'",
    'token ri:my¦-name = "x"': "'-' cannot stand in the name of a property",
    'rel camera = ¦"/World/cam"': (
        "a target stands in angle brackets, as in </World/camera>, and not '\"/World/cam\"'"
    ),
    "rel camera = </World/cam¦": "expected a path and >",
    "rel camera = </World/my¦ cam>": "expected a path and >, found 'cam>'",
    "rel products¦ = [</A>, </A>]": "a target stands twice in the list",
    'int x = ¦"a"': "expected a value of another type, found '\"a\"'",
    "token x = ¦raster": "expected a value of another type, found 'raster'",
    "token x = ¦none": "'none' is no value: did you mean None?",
    "pathExpression x = ¦/World//": "no value begins with '/': text stands in quotes",
    "int2 resolution = ¦(1920)": (
        "the value has not as many components as its type, int2, found '(1920)'"
    ),
    "int2 resolution = ¦1920, 1080": "the value has fewer components than its type, found '1920,'",
    'token[] x = ¦"default"': (
        "the type is an array, and the value has no brackets, found '\"default\"'"
    ),
    "int x = 1 ¦int y = 2": "expected the end of the line, found 'int'",
    "float x.timeSamples = {\n            1: 2,\n            2 ¦3,\n        }": (
        "expected :, found '3'"
    ),
    'uniform ¦uniform token x = "a"': "'uniform' stands after 'uniform', and only one of them may",
    'uniform ¦custom token x = "a"': "'custom' stands before 'uniform'",
    "¦/* a comment": "a comment is not closed",
    "¦<<<<<<< HEAD": "a merge conflict is left here, found '<<<<<<<'",
    "¦what": "'what' begins no statement that USD can read",
    "int x = 1 ¦}": "expected the end of the line, found '}'",
    'string x = """a\n"""¦}': "expected the end of the line, found '}'",
    'int x = 1 (\n            doc = "x"\n        ) ¦}': "expected the end of the line, found '}'",
    "rel r = [\n        ] ¦}": "expected the end of the line, found '}'",
    "rel camera = </A> ¦</B>": "expected the end of the line, found '<'",
    'def RenderVar¦}"A" {\n        }': "expected a type or a name in quotes, found '}'",
    'def "A" {} ¦}': "expected the end of the line, found '}'",
    'def "A" {}¦; def "B" {}': "expected the end of the line, found ';'",
    "¦...": "'...' begins no statement that USD can read",
    "¦%": "'%' begins no statement that USD can read",
}
WHOLE = {
    'def Scope "Render"\n¦{\n    def "A"\n    {\n    }\n': "this { is not closed",
    'def Scope "Render"\n{\n}\n¦}\n': "nothing is open that '}' closes",
    'def Scope "Render" (\n    kind = "group"\n\n¦{\n}\n': (
        "expected ) for the ( of line 2, found '{'"
    ),
    'def Scope "Render"\n    ¦def "A"\n    {\n    }\n': (
        "expected { after the name of a prim, found 'def'"
    ),
    'def Scope "A"\n{\n\n¦def Scope "B"\n{\n    def "C"\n    {\n    }\n}': (
        "expected } for the { of line 3, found 'def'"
    ),
    'def "A"\n{\n\n¦variantSet "look" = {\n    "a" {\n    }\n}': (
        "expected } for the { of line 3, found 'variantSet'"
    ),
    'def Scope ¦"Render"\n': "expected { after the name of a prim, found the end of the text",
    'def Scope "Render"\n¦<<<<<<< HEAD\n{\n}\n': "a merge conflict is left here, found '<<<<<<<'",
    'def Scope "Render" (\n    doc = "(" # )\n)\n¦def "A"\n{\n}\n': (
        "expected { after the name of a prim, found 'def'"
    ),
    "def Scope ¦Render\n{\n}\n": 'the name of a prim stands in quotes, as in "Render"',
    "¦def\n{\n}\n": "a name in quotes is missing after 'def'",
    'def Render ¦Settings "S"\n{\n}\n': (
        "one type stands between 'def' and the name, and not 'Settings'"
    ),
    'def "A" (\n    active = ¦"maybe"\n)\n{\n}\n': (
        "expected a value of another type, found '\"maybe\"'"
    ),
    'def "A" (\n    customData = {\n        ¦x = 3\n    }\n)\n{\n}\n': (
        "an entry of a dictionary is written as type name = value, near 'x'"
    ),
    'def "A" (\n    variants = {\n        string look =¦= "x"\n    }\n)\n{\n}\n': (
        "no value begins with '='"
    ),
    '(\n    subLayers = [\n        ¦"a.usda"\n    ]\n)\n': (
        "an asset stands between two @, as in @layer.usda@"
    ),
    'def "A"\n{\n}\ndef ¦"A"\n{\n}\n': "duplicate prim 'A', near '\"A\"'",
}


def told(folder: Path, marked: str) -> tuple[str, int, int]:
    file = folder / "main.usda"
    file.write_bytes(marked.replace("¦", "", 1).encode())
    report = lint([str(file)], cwd=folder)
    assert report.problems == ()
    (finding,) = report.findings
    assert finding.rule.id == "syntax-error"
    span = finding.location.span
    assert span is not None
    return finding.message, span.line, span.column


def check(folder: Path, marked: str, said: str) -> None:
    before = marked.partition("¦")[0]
    column = len(before.rpartition("\n")[2]) + 1
    line = marked.replace("¦", "").splitlines()[before.count("\n")]
    # Behind the end of a line its last character is shown.
    assert told(folder, marked) == (said, before.count("\n") + 1, min(column, len(line)))


@pytest.mark.parametrize(("statement", "said"), IN_SETTINGS.items())
@pytest.mark.parametrize("line_break", ["\n", "\r\n"])
def test_a_statement(tmp_path: Path, statement: str, said: str, line_break: str) -> None:
    lines = f'#usda 1.0\ndef Scope "Ö"\n{{\n    def RenderSettings "S"\n    {{\n        {statement}\n    }}\n}}\n'
    check(tmp_path, lines.replace("\n", line_break), said)


@pytest.mark.parametrize(("text", "said"), WHOLE.items())
def test_a_text(tmp_path: Path, text: str, said: str) -> None:
    check(tmp_path, f"#usda 1.0\n{text}", said)


def test_all_types_of_usd_are_known() -> None:
    found = (getattr(Sdf.ValueTypeNames, name) for name in dir(Sdf.ValueTypeNames))
    types = {str(one.scalarType) for one in found if isinstance(one, Sdf.ValueTypeName)}
    assert {"token", "color3f"} <= types
    assert not [one for one in types if not is_type(one.encode())]
    assert not any(map(is_type, (b"preprend", b"tokenx", b"float5")))


def test_a_line_that_ends_as_on_an_old_mac(tmp_path: Path) -> None:
    text = '#usda 1.0\ndef "A"\r{\r  \n  ¦preprend rel r = </A>\r}\n'
    assert told(tmp_path, text)[1:] == (5, 3)


@since(26, 11)
def test_a_path_with_an_empty_name(tmp_path: Path) -> None:
    check(
        tmp_path,
        '#usda 1.0\ndef "A"\n{\n    rel r = </World/¦/cam>\n}\n',
        "this is no path, found '/cam>'",
    )


def test_a_list_that_a_form_feed_ends(tmp_path: Path) -> None:
    text = '#usda 1.0\ndef "A"\n{\n    rel r = [\n        </World/a>\n        \f\n    ]\n}\n'
    message, line, _ = told(tmp_path, text)
    assert (message, line) == ("expected a comma, or ] for the [ of line 4", 6)
