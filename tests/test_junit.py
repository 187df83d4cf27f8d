"""Do servers that only know tests take the report, and does a red test mean a red job?"""

from __future__ import annotations

import sys
from typing import Any
from xml.etree import ElementTree

import pytest

from usdrender_lint.model import RenderPrim
from usdrender_lint.report import junit
from usdrender_lint.results import Located, Location, Problem, Report, Span
from usdrender_lint.rule import Rule, Severity


def a_rule(id: str) -> Rule[RenderPrim]:
    return Rule(id, RenderPrim, Severity.ERROR, "0.1", "", lambda subject, context: iter(()))


RENDER = Location("/show/render.usda", "render.usda", None, Span(12, 22, 34), "source")
PACKED = Location("/show/c.usdz", "c.usdz", "sub/a.usda", Span(3, 1, 2), "source")
BROKEN = Problem("unreadable-file", "b.usdc", "the file is empty")


def a_finding(location: Location = RENDER, rule: str = "unresolved-target", **more: Any) -> Located:
    values: dict[str, Any] = {
        "severity": Severity.ERROR,
        "message": "camera </World/cam> does not exist",
        "label": "",
        "help": "",
        "prim_path": "/Render/Primary",
        "property": "camera",
        "target": None,
        "roots": ("shot.usda",),
    }
    return Located(rule=a_rule(rule), location=location, **(values | more))


def read(
    *findings: Located,
    files: tuple[str, ...] = ("shot.usda",),
    problems: tuple[Problem, ...] = (),
    fails: str = "warning",
) -> ElementTree.Element:
    text = junit.render(
        Report("0.1.0", (), files, findings, problems, gates=dict.fromkeys(files, fails))
    )
    return ElementTree.fromstring(text.encode("utf-8"))  # noqa: S314 it is our own


def outcomes(top: ElementTree.Element) -> list[tuple[str | None, ...]]:
    return [
        (suite.get("name"), case.get("classname"), case.get("name"), *(c.tag for c in case))
        for suite in top
        for case in suite
    ]


def test_a_whole_report() -> None:
    report = Report(
        "0.1.0",
        (),
        ("clean.usda", "shot.usda"),
        (
            a_finding(help="did you mean </World/main_cam>?"),
            a_finding(message="product </Render/x> does not exist", severity=Severity.WARNING),
            a_finding(PACKED, rule="other-rule", severity=Severity.NOTE, message="odd"),
        ),
        (BROKEN,),
    )
    assert (
        junit.render(report)
        == """\
<?xml version="1.0" encoding="UTF-8"?>
<testsuites name="usdrender-lint" tests="4" failures="1" errors="1">
  <testsuite name="b.usdc" tests="1" failures="0" errors="1">
    <testcase name="unreadable-file" classname="b.usdc" file="b.usdc">
      <error message="the file is empty" type="unreadable-file">b.usdc: the file is empty</error>
    </testcase>
  </testsuite>
  <testsuite name="clean.usda" tests="1" failures="0" errors="0">
    <testcase name="render-spec" classname="clean.usda" file="clean.usda" />
  </testsuite>
  <testsuite name="shot.usda" tests="2" failures="1" errors="0">
    <testcase name="other-rule" classname="c.usdz[sub/a.usda]" file="c.usdz">
      <system-out>c.usdz[sub/a.usda]:3:1: note[other-rule] odd &lt;/Render/Primary.camera&gt;</system-out>
    </testcase>
    <testcase name="unresolved-target" classname="render.usda" file="render.usda">
      <failure message="camera &lt;/World/cam&gt; does not exist (and 1 more)" type="error">render.usda:12:22: error[unresolved-target] camera &lt;/World/cam&gt; does not exist &lt;/Render/Primary.camera&gt;
  help: did you mean &lt;/World/main_cam&gt;?
render.usda:12:22: warning[unresolved-target] product &lt;/Render/x&gt; does not exist &lt;/Render/Primary.camera&gt;</failure>
    </testcase>
  </testsuite>
</testsuites>
"""
    )


@pytest.mark.parametrize(
    ("fails", "failed"),
    [
        ("error", ["e"]),
        ("warning", ["e", "w"]),
        ("note", ["e", "n", "w"]),
        ("never", []),
    ],
)
def test_what_fails_no_run_fails_no_test(fails: str, failed: list[str]) -> None:
    top = read(
        a_finding(rule="e"),
        a_finding(rule="w", severity=Severity.WARNING),
        a_finding(rule="n", severity=Severity.NOTE),
        fails=fails,
    )
    assert [
        case.get("name") for case in top.iter("testcase") if case.find("failure") is not None
    ] == failed
    assert top.get("failures") == str(len(failed))
    assert all(len(case) == 1 for case in top.iter("testcase"))


def test_the_message_is_that_of_a_finding_that_fails() -> None:
    top = read(
        a_finding(severity=Severity.NOTE, message="harmless"),
        a_finding(message="bad"),
    )
    (failure,) = top.iter("failure")
    assert (failure.get("message"), failure.get("type")) == ("bad", "error")
    assert "harmless" in (failure.text or "")


def test_a_finding_is_told_of_every_stage_in_which_it_holds() -> None:
    top = read(a_finding(roots=("a.usda", "b.usda")), files=("a.usda", "b.usda", "c.usda"))
    assert outcomes(top) == [
        ("a.usda", "render.usda", "unresolved-target", "failure"),
        ("b.usda", "render.usda", "unresolved-target", "failure"),
        ("c.usda", "c.usda", "render-spec"),
    ]


def test_a_finding_without_a_stage_belongs_to_its_layer() -> None:
    assert outcomes(read(a_finding(roots=()), files=())) == [
        ("render.usda", "render.usda", "unresolved-target", "failure")
    ]


def test_no_two_cases_of_a_suite_have_one_name() -> None:
    crashed = [Problem("crashed-rule", "shot.usda", f"KeyError {n}", f"r{n}") for n in range(3)]
    top = read(
        *(a_finding(message=f"{n}") for n in range(3)),
        a_finding(Location("/show/render.usdc", "render.usdc")),
        problems=(*crashed, Problem("crashed-usd", "", "out of memory")),
    )
    found = outcomes(top)
    assert len({case[:3] for case in found}) == len(found) == 4
    assert ("usdrender-lint", "usdrender-lint", "crashed-usd", "error") in found
    (error,) = [e for e in top.iter("error") if e.get("type") == "crashed-rule"]
    assert error.get("message") == "KeyError 0 (and 2 more)"
    assert (error.text or "").count("KeyError") == 3


def test_any_text_is_valid_xml() -> None:
    """Every character that exists, and those that only a broken name has."""
    every = "".join(map(chr, range(sys.maxunicode + 1)))
    for nasty in (every, "]]>&amp;<!--\"'\r\n\t"):
        top = read(
            a_finding(
                Location("/x", nasty, nasty, Span(1, 1, 2)),
                message=nasty,
                help=nasty,
                prim_path=nasty,
                property=nasty,
                roots=(nasty,),
            ),
            files=(nasty,),
            problems=(Problem("unreadable-file", nasty, nasty),),
        )
        assert top.get("tests") == "2"


def test_what_xml_has_not_can_be_read() -> None:
    top = read(a_finding(message="a\x00b\x1b[2J\n\udcf6\ufffe<&>日本"))
    (failure,) = top.iter("failure")
    assert failure.get("message") == r"a\x00b\x1b[2J\n\udcf6\ufffe<&>日本"
