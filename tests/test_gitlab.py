"""Does GitLab take the report, and does it show each finding?"""

from __future__ import annotations

import json
from typing import Any

import pytest

from usdrender_lint.model import RenderPrim
from usdrender_lint.report import gitlab
from usdrender_lint.results import Located, Location, Problem, Report, Span
from usdrender_lint.rule import Rule, Severity

RULE: Rule[RenderPrim] = Rule(
    "unresolved-target", RenderPrim, Severity.ERROR, "0.1", "", lambda subject, context: iter(())
)
TEXT = Location("/show/shots/render.usda", "shots/render.usda", None, Span(12, 22, 34), "source")
BINARY = Location("/show/look.usdc", "look.usdc")
PACKED = Location("/show/c.usdz", "c.usdz", "sub/a.usda", Span(3, 1, 2), "source")


def a_finding(location: Location = TEXT, **more: Any) -> Located:
    values: dict[str, Any] = {
        "rule": RULE,
        "severity": Severity.ERROR,
        "message": "camera </World/名前> does not exist",
        "label": "",
        "help": "",
        "prim_path": "/Render/Primary",
        "property": "camera",
        "target": None,
    }
    return Located(location=location, **(values | more))


def issues(*findings: Located, problems: tuple[Problem, ...] = ()) -> list[dict[str, Any]]:
    text = gitlab.render(Report("0.1.0", (), ("shots/render.usda",), findings, problems))
    assert text.encode("utf-8")
    found: list[dict[str, Any]] = json.loads(text)
    return found


def test_a_finding_with_its_keys_in_order() -> None:
    finding = a_finding()
    (issue,) = issues(finding)
    assert issue == {
        "description": "unresolved-target: camera </World/名前> does not exist",
        "check_name": "unresolved-target",
        "fingerprint": finding.fingerprint,
        "severity": "major",
        "location": {"path": "shots/render.usda", "lines": {"begin": 12}},
    }
    assert list(issue) == ["description", "check_name", "fingerprint", "severity", "location"]


@pytest.mark.parametrize(
    ("location", "place"),
    [(BINARY, "</Render/Primary.camera>"), (PACKED, "in sub/a.usda </Render/Primary.camera>")],
    ids=["binary", "package"],
)
def test_without_a_line_the_description_tells_the_place(location: Location, place: str) -> None:
    (issue,) = issues(a_finding(location))
    assert issue["location"] == {"path": location.path, "lines": {"begin": 1}}
    assert issue["description"] == f"unresolved-target: camera </World/名前> does not exist {place}"


@pytest.mark.parametrize(
    ("severity", "theirs"),
    [(Severity.ERROR, "major"), (Severity.WARNING, "minor"), (Severity.NOTE, "info")],
)
def test_severities(severity: Severity, theirs: str) -> None:
    assert [issue["severity"] for issue in issues(a_finding(severity=severity))] == [theirs]


def test_no_two_issues_share_a_fingerprint() -> None:
    """It knows neither line nor message, so that it survives edits."""
    findings = [a_finding(message=message) for message in ("one", "two", "three")]
    same = findings[0].fingerprint
    crashed = [Problem("crashed-rule", "a", text, "r") for text in ("one", "two")]
    found = [issue["fingerprint"] for issue in issues(*findings, problems=tuple(crashed))]
    assert found[2:] == [same, f"{same}-2", f"{same}-3"]
    assert len(set(found)) == 5


def test_what_was_not_linted_is_no_silence() -> None:
    found = issues(
        problems=(Problem("unreadable-file", "a.usdc", "is empty"), Problem("crashed-usd", "", "!"))
    )
    assert [(i["description"], i["severity"], i["location"]["path"]) for i in found] == [
        ("unreadable-file: is empty", "blocker", "a.usdc"),
        ("crashed-usd: !", "blocker", "."),
    ]


def test_nothing_is_an_empty_list() -> None:
    assert issues() == []


def test_nasty_names() -> None:
    nasty = 'a"\\\r\n\x1b[2J\u202e\udcf6</script>'
    path = f"{nasty}.usda"
    (problem, issue) = issues(
        a_finding(Location("/x", path, nasty), message=nasty, prim_path=nasty, property=nasty),
        problems=(Problem("unreadable-file", path, nasty),),
    )
    visible = r'a"\\r\n\x1b[2J\u202e\udcf6</script>'
    assert problem["description"] == f"unreadable-file: {visible}"
    assert issue["description"].count(visible) == 4
    assert issue["location"]["path"] == path
    assert problem["location"]["path"] == path
