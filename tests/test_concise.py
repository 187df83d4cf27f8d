"""One line a finding."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from usdrender_lint.model import RenderPrim
from usdrender_lint.report import concise
from usdrender_lint.results import Located, Location, Problem, Report, Span
from usdrender_lint.rule import Rule, Severity

RULE: Rule[RenderPrim] = Rule(
    "unresolved-target", RenderPrim, Severity.ERROR, "0.1", "", lambda subject, context: iter(())
)
TEXT = Location("/show/shots/render.usda", "shots/render.usda", None, Span(12, 22, 34), "source")
BINARY = Location("/show/shots/look.usdc", "shots/look.usdc")
PACKED = Location("/show/c.usdz", "c.usdz", "sub/a.usda", Span(3, 1, 2), "source")
FINDING = Located(
    RULE,
    Severity.ERROR,
    "camera </World/cam> does not exist",
    "no prim here",
    "did you mean </World/main_cam>?",
    TEXT,
    "/Render/Primary",
    "camera",
    None,
)


def render(*findings: Located, color: bool = False, base: str = "/show") -> str:
    report = Report("0.1.0", (), ("shots/render.usda",), findings)
    return concise.render(report, color=color, quiet=True, base=Path(base))


@pytest.mark.parametrize(
    ("finding", "expected"),
    [
        (
            FINDING,
            "shots/render.usda:12:22: error[unresolved-target] "
            "camera </World/cam> does not exist </Render/Primary.camera>\n",
        ),
        (
            replace(FINDING, location=BINARY, property=None, severity=Severity.NOTE),
            "shots/look.usdc: note[unresolved-target] "
            "camera </World/cam> does not exist </Render/Primary>\n",
        ),
        (
            replace(FINDING, location=PACKED, message="odd", prim_path="/", property=None),
            "c.usdz[sub/a.usda]:3:1: error[unresolved-target] odd\n",
        ),
    ],
    ids=["text", "binary", "package"],
)
def test_line(finding: Located, expected: str) -> None:
    assert render(finding) == expected


def test_paths_are_relative_to_where_one_stands() -> None:
    assert render(FINDING, base="/show/shots").startswith("render.usda:12:22: ")


@pytest.mark.parametrize("color", [False, True])
def test_one_line_whatever_the_names(color: bool) -> None:
    hostile = "inputs:camera:exposure [/Render/X] \x1b[2J\n\u202e日本\t"
    finding = replace(
        FINDING,
        message=hostile,
        prim_path=hostile,
        property=hostile,
        location=Location("/x", hostile, hostile, Span(1, 1, 2), hostile),
    )
    plain = re.sub(r"\x1b\[[0-9;]*m", "", render(finding, color=color))
    assert plain.count("\n") == 1
    assert plain[:-1].isprintable()
    assert plain.count(r"inputs:camera:exposure [/Render/X] \x1b[2J\n\u202e日本\t") == 5
    assert color or "\x1b" not in render(finding)


def test_colors_are_closed() -> None:
    codes = re.findall(r"\x1b\[[0-9;]*m", render(FINDING, color=True))
    assert codes
    assert codes[1::2] == ["\x1b[0m"] * (len(codes) // 2)


def test_the_summary_is_that_of_full() -> None:
    report = Report(
        "0.1.0", (), ("a",), (FINDING,), problems=(Problem("unreadable-file", "b", "is empty"),)
    )
    assert concise.render(report, color=False).splitlines()[1:] == [
        "1 finding (1 error) in 1 file.",
        "The run is incomplete: 1 error kept 1 file from being linted (see above).",
    ]


def test_a_finding_in_a_shared_layer_says_in_which_stages_it_holds() -> None:
    """Its place alone does not tell which of fifty shots is broken."""
    roots = tuple(f"sh{n}.usda" for n in range(5))
    said = render(replace(FINDING, roots=roots))
    assert said.endswith(" (in sh0.usda, sh1.usda, sh2.usda and 2 more)\n")
    assert "(in " not in render(replace(FINDING, roots=(FINDING.location.path,)))


def test_the_summary_tells_of_stages_that_layers_were_seen_through() -> None:
    report = Report("0.1.0", (), ("a",), (), through=("b", "c"))
    assert concise.render(report, color=False) == "No findings in 1 file, seen through 2 stages.\n"
