"""One opinion that several prims share is one finding, which names them all."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

import pytest

from usdrender_lint.lint import lint
from usdrender_lint.report import json as json_report
from usdrender_lint.report import sarif
from usdrender_lint.results import Located, Report

SCOPE = """\
#usda 1.0
(
    renderSettingsPrimPath = "/Render/S"
)
def Scope "Render"
{
    def RenderSettings "S"
    {
        rel camera = </World/cam>
        rel products = [PRODUCTS]
    }
BODY}
def Xform "World"
{
    def Camera "cam"
    {
    }
}
"""

VAR = '    def RenderVar "v"\n    {\n        string sourceName = "Ci"\n    }\n'


def scene(names: Iterable[str], body: str, more: str = "") -> str:
    products = ", ".join(f"</Render/{name}>" for name in names)
    return SCOPE.replace("PRODUCTS", products).replace("BODY", body) + more


def inheriting(names: str, inside: str = "") -> str:
    """Products that have everything but their names from one class."""
    return VAR + "".join(
        f'    def RenderProduct "{n}" (\n        inherits = </_P>\n    )\n    {{\n'
        f'        token productName = "/out/{n}.exr"\n{inside}    }}\n'
        for n in names
    )


def klass(inside: str) -> str:
    return f'class RenderProduct "_P"\n{{\n    rel orderedVars = </Render/v>\n    {inside}\n}}\n'


def run(folder: Path, *roots: str, **layers: str) -> Report:
    for name, text in layers.items():
        (folder / f"{name}.usda").write_text(text)
    return lint([str(folder / f"{r}.usda") for r in roots or ("main",)], cwd=folder)


def only(report: Report) -> Located:
    assert report.problems == ()
    (finding,) = report.findings
    return finding


@pytest.mark.parametrize(
    ("inside", "rule"),
    [
        ('uniform token productType = "rastr"', "unknown-product-type"),
        ("rel camera = </World/nope>", "unresolved-target"),
        ("uniform int2 resolution = (0, 0)", "invalid-resolution"),
        ("rel productType = </World>", "kind-mismatch"),
        ("bool disableMotionBlurs = 1", "misspelled-property"),
        ("uniform float pixelAspectRatio = 0", "invalid-pixel-aspect-ratio"),
    ],
)
def test_an_opinion_of_a_class_is_told_once(tmp_path: Path, inside: str, rule: str) -> None:
    main = scene("ABC", inheriting("ABC"), klass(inside))
    finding = only(run(tmp_path, main=main))
    assert finding.rule.id == rule
    assert finding.prim_path == "/Render/A"
    assert finding.also == ("/Render/B", "/Render/C")
    assert finding.message.endswith("(also for </Render/B>, </Render/C>)")
    assert finding.location.source is not None
    assert inside in finding.location.source


def test_many_prims_are_counted(tmp_path: Path) -> None:
    names = "ABCDEFGH"
    main = scene(names, inheriting(names), klass("rel camera = </World/nope>"))
    finding = only(run(tmp_path, main=main))
    assert len(finding.also) == 7
    assert finding.message.endswith("(also for </Render/B>, </Render/C>, </Render/D> and 4 more)")


LIBRARY = """\
#usda 1.0
def RenderProduct "P"
{
    token productName = "/out/a.exr"
    rel orderedVars = </P/v>
    def RenderVar "v"
    {
        uniform token dataType = "nope"
        string sourceName = "Ci"
    }
}
"""


def referencing(names: str) -> str:
    return "".join(
        f'    def "{n}" (\n        references = @./lib.usda@</P>\n    )\n    {{\n'
        f'        token productName = "/out/{n}.exr"\n    }}\n'
        for n in names
    )


def test_an_opinion_of_a_referenced_layer_is_told_once(tmp_path: Path) -> None:
    finding = only(run(tmp_path, main=scene("AB", referencing("AB")), lib=LIBRARY))
    assert finding.rule.id == "unknown-data-type"
    assert (finding.prim_path, finding.also) == ("/Render/A/v", ("/Render/B/v",))
    assert finding.location.path == "lib.usda"


def test_what_is_missing_below_a_reference_is_missing_once(tmp_path: Path) -> None:
    library = LIBRARY.replace('        string sourceName = "Ci"\n', "").replace("nope", "color3f")
    finding = only(run(tmp_path, main=scene("AB", referencing("AB")), lib=library))
    assert finding.rule.id == "empty-source-name"
    assert (finding.prim_path, finding.also) == ("/Render/A/v", ("/Render/B/v",))


def test_what_instances_share_is_told_once(tmp_path: Path) -> None:
    body = "".join(
        f'    def Scope "{n}" (\n        instanceable = true\n        references = @./lib.usda@</G>\n    )\n    {{\n    }}\n'
        for n in "GH"
    )
    library = (
        '#usda 1.0\ndef Scope "G"\n{\n'
        + LIBRARY.partition("\n")[2]
        .replace("</P/v>", "</G/P/v>")
        .replace("nope", "color3f")
        .replace('        string sourceName = "Ci"\n', "")
        + "}\n"
    )
    main = scene(["G/P", "H/P"], body)
    report = run(tmp_path, main=main, lib=library)
    assert [(f.rule.id, f.also) for f in report.findings if f.location.path == "lib.usda"] == [
        ("duplicate-product-name", ()),
        ("empty-source-name", ("/Render/H/P/v",)),
    ]


def test_a_fault_that_differs_by_prim_stays_apart(tmp_path: Path) -> None:
    """Three products of one name: the second and the third each lose a file."""
    body = (
        inheriting("ABC")
        .replace('token productName = "/out/A.exr"', "")
        .replace('token productName = "/out/B.exr"', "")
        .replace('token productName = "/out/C.exr"', "")
    )
    main = scene("ABC", body, klass('token productName = "/out/x.exr"'))
    report = run(tmp_path, main=main)
    assert {f.rule.id for f in report.findings} == {"duplicate-product-name"}
    assert [f.prim_path for f in report.findings] == sorted({f.prim_path for f in report.findings})


def test_opinions_of_their_own_stay_apart(tmp_path: Path) -> None:
    bad = "        rel camera = </World/nope>\n"
    report = run(tmp_path, main=scene("AB", inheriting("AB", bad), klass("")))
    assert [(f.prim_path, f.also) for f in report.findings] == [
        ("/Render/A", ()),
        ("/Render/B", ()),
    ]


def test_a_prim_that_says_otherwise_is_not_named(tmp_path: Path) -> None:
    body = inheriting("AB") + inheriting("C", "        rel camera = </World/cam>\n").replace(
        VAR, ""
    )
    main = scene("ABC", body, klass("rel camera = </World/nope>"))
    told = [f for f in run(tmp_path, main=main).findings if f.rule.id != "per-product-view"]
    assert [(f.prim_path, f.also) for f in told] == [("/Render/A", ("/Render/B",))]


def test_an_ignored_prim_does_not_silence_the_others(tmp_path: Path) -> None:
    ignored = inheriting("A").replace(
        "inherits = </_P>",
        "inherits = </_P>\n        customData = {\n            dictionary usdrenderLint = {\n"
        '                string[] ignore = ["unresolved-target"]\n            }\n        }',
    )
    main = scene(
        "ABC", ignored + inheriting("BC").replace(VAR, ""), klass("rel camera = </World/nope>")
    )
    report = run(tmp_path, main=main)
    finding = only(report)
    assert (finding.prim_path, finding.also) == ("/Render/B", ("/Render/C",))
    assert [f.prim_path for f in report.suppressed] == ["/Render/A"]


def test_two_stages_that_bring_a_layer_in_at_different_prims(tmp_path: Path) -> None:
    report = run(
        tmp_path,
        "one",
        "two",
        one=scene("A", referencing("A")),
        two=scene("B", referencing("B")),
        lib=LIBRARY,
    )
    finding = only(report)
    assert finding.roots == ("one.usda", "two.usda")
    assert (finding.prim_path, finding.also) == ("/Render/A/v", ("/Render/B/v",))


def test_what_it_is_known_by_does_not_change_with_its_users(tmp_path: Path) -> None:
    """A baseline and the alerts of a scanner outlive a further prim that shares the opinion."""
    few = only(run(tmp_path, main=scene("BC", referencing("BC")), lib=LIBRARY))
    many = only(run(tmp_path, main=scene("ABC", referencing("ABC")), lib=LIBRARY))
    assert few.prim_path != many.prim_path
    assert few.fingerprint == many.fingerprint
    assert (
        few.known_by == many.known_by == ("lib.usda", "/P/v", "dataType", "", "unknown-data-type")
    )


def test_every_prim_is_in_the_reports_for_machines(tmp_path: Path) -> None:
    names = "ABCDEFGH"
    main = scene(names, inheriting(names), klass("rel camera = </World/nope>"))
    report = run(tmp_path, main=main)
    (finding,) = json.loads(json_report.render(report))["findings"]
    assert finding["primPath"] == "/Render/A"
    assert finding["also"] == [f"/Render/{n}" for n in names[1:]]
    (sarif_run,) = json.loads(sarif.render(report, {}))["runs"]
    (result,) = sarif_run["results"]
    (location,) = result["locations"]
    named = [one["fullyQualifiedName"] for one in location["logicalLocations"]]
    assert named == [f"/Render/{n}.camera" for n in names]
    objects = sarif_run["logicalLocations"]
    assert [
        objects[one["index"]]["fullyQualifiedName"] for one in location["logicalLocations"]
    ] == named
    assert result["properties"]["also"] == [f"/Render/{n}" for n in names[1:]]


def test_two_faults_of_one_value_have_a_fingerprint_each(tmp_path: Path) -> None:
    main = scene(
        "A",
        inheriting("A")
        + '    def RenderPass "pass"\n    {\n        rel renderSource = </Render/S>\n'
        '        string[] command = ["nuke", "{filenam}", "{passTyp}"]\n    }\n',
        klass(""),
    )
    report = run(tmp_path, main=main)
    assert len({f.known_by for f in report.findings}) == 1
    assert len({f.fingerprint for f in report.findings}) == len(report.findings) == 2


def test_a_message_is_one_line(tmp_path: Path) -> None:
    main = scene("", "").replace('PrimPath = "/Render/S"', 'PrimPath = "/Render/S\\n"')
    report = run(tmp_path, main=main)
    assert report.findings
    assert all(f.message.isprintable() and f.help.isprintable() for f in report.findings)
