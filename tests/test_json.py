"""Is the JSON report what scripts were promised?"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from usdrender_lint.model import RenderScope
from usdrender_lint.report import json as json_report
from usdrender_lint.report import page_url
from usdrender_lint.results import Located, Location, Place, Problem, Report, Span, Step
from usdrender_lint.rule import Rule, Severity

RULE = Rule(
    "unresolved-target", RenderScope, Severity.ERROR, "0.1", "A target.", lambda *_: iter(())
)
IN_TEXT = Location("/show/render.usda", "render.usda", None, Span(12, 22, 34), "  rel camera")
IN_BINARY = Location("/show/look.usdc", "look.usdc")
IN_PACKAGE = Location("/show/pkg.usdz", "pkg.usdz", "sub/a.usda", Span(3, 1, 9))


def a_finding(location: Location, **more: Any) -> Located:
    values: dict[str, Any] = {
        "rule": RULE,
        "severity": Severity.ERROR,
        "message": "camera </World/名前> does not exist",
        "label": "no prim here",
        "help": "",
        "prim_path": "/Render/Primary",
        "property": None,
        "target": None,
        "roots": ("shot.usda",),
    }
    return Located(location=location, **(values | more))


def a_report(*findings: Located, problems: tuple[Problem, ...] = ()) -> Report:
    return Report("0.1.0", (RULE,), ("a.usda", "shot.usda"), findings, problems)


def loaded(report: Report) -> dict[str, Any]:
    value: dict[str, Any] = json.loads(json_report.render(report))
    return value


def test_a_whole_report_with_its_keys_in_order() -> None:
    finding = a_finding(
        IN_TEXT,
        help="did you mean </World/main_cam>?",
        property="camera",
        target="/World/名前",
        related=(Place("is a Camera", IN_PACKAGE, "/World/main_cam", None),),
        chain=(Step("sublayer", "render.usda"),),
    )
    expected = {
        "version": 1,
        "tool": {"name": "usdrender-lint", "version": "0.1.0"},
        "files": 2,
        "findings": [
            {
                "rule": "unresolved-target",
                "severity": "error",
                "message": "camera </World/名前> does not exist",
                "path": "render.usda",
                "line": 12,
                "column": 22,
                "endLine": 12,
                "endColumn": 34,
                "primPath": "/Render/Primary",
                "property": "camera",
                "target": "/World/名前",
                "help": "did you mean </World/main_cam>?",
                "root": "shot.usda",
                "chain": [{"arc": "sublayer", "path": "render.usda"}],
                "variants": {},
                "related": [
                    {
                        "message": "is a Camera",
                        "path": "pkg.usdz[sub/a.usda]",
                        "line": 3,
                        "column": 1,
                        "primPath": "/World/main_cam",
                        "property": None,
                    }
                ],
                "fixable": False,
                "fix": None,
                "fingerprint": finding.fingerprint,
                "url": page_url("unresolved-target"),
            }
        ],
        "errors": [
            {"kind": "unreadable-file", "path": "b.usda", "message": "truncated"},
            {"kind": "crashed-rule", "path": "a.usda", "message": "KeyError", "rule": "some-rule"},
        ],
        "summary": {"error": 1, "warning": 0, "note": 0, "suppressed": 0, "baseline": 0},
    }
    report = a_report(
        finding,
        problems=(
            Problem("unreadable-file", "b.usda", "truncated"),
            Problem("crashed-rule", "a.usda", "KeyError", "some-rule"),
        ),
    )

    assert json_report.render(report) == json.dumps(expected, indent=2, ensure_ascii=False) + "\n"
    assert json_report.render(report) == json_report.render(report)


def test_without_text_all_four_positions_are_null() -> None:
    (finding,) = loaded(a_report(a_finding(IN_BINARY)))["findings"]

    assert finding["path"] == "look.usdc"
    assert [finding[key] for key in ("line", "column", "endLine", "endColumn")] == [None] * 4


def test_what_is_absent_is_null() -> None:
    (finding,) = loaded(a_report(a_finding(IN_TEXT, roots=())))["findings"]

    assert [finding[key] for key in ("help", "property", "target", "root", "fix")] == [None] * 5


def test_a_layer_in_a_package_is_named_as_usd_does() -> None:
    (finding,) = loaded(a_report(a_finding(IN_PACKAGE)))["findings"]

    assert (finding["path"], finding["line"]) == ("pkg.usdz[sub/a.usda]", 3)


def test_several_roots_are_a_list_beside_the_first() -> None:
    (finding,) = loaded(a_report(a_finding(IN_TEXT, roots=("a.usda", "shot.usda"))))["findings"]

    assert finding["root"] == "a.usda"
    assert finding["roots"] == ["a.usda", "shot.usda"]
    assert list(finding).index("roots") == list(finding).index("root") + 1


def test_the_summary_counts_by_severity() -> None:
    findings = (
        a_finding(IN_TEXT),
        a_finding(IN_TEXT, severity=Severity.NOTE),
        a_finding(IN_BINARY, severity=Severity.NOTE),
    )
    summary = loaded(a_report(*findings))["summary"]

    assert summary == {"error": 1, "warning": 0, "note": 2, "suppressed": 0, "baseline": 0}


def test_a_clean_report_has_all_keys() -> None:
    assert list(loaded(a_report())) == ["version", "tool", "files", "findings", "errors", "summary"]


def test_a_name_that_is_not_utf8_can_be_written(tmp_path: Path) -> None:
    report = a_report(a_finding(Location("/show/gr\udcf6n.usda", "gr\udcf6n.usda")))
    output = tmp_path / "report.json"
    output.write_text(json_report.render(report), encoding="utf-8")

    (finding,) = json.loads(output.read_text(encoding="utf-8"))["findings"]
    assert finding["path"] == "gr\udcf6n.usda"


def test_the_module_does_not_stand_in_the_way_of_the_library() -> None:
    from usdrender_lint import report

    assert report.json is json_report
    assert report.to_json({"ö": [1]}) == '{\n  "ö": [\n    1\n  ]\n}\n'
