"""Does the runner take every command, and do people see the worst first?"""

from __future__ import annotations

import re
from typing import Any

import pytest

from usdrender_lint.model import RenderPrim
from usdrender_lint.report import github
from usdrender_lint.results import Located, Location, Problem, Report, Span
from usdrender_lint.rule import Rule, Severity

RULE: Rule[RenderPrim] = Rule(
    "unresolved-target", RenderPrim, Severity.ERROR, "0.1", "", lambda subject, context: iter(())
)
TEXT = Location("/show/shots/render.usda", "shots/render.usda", None, Span(12, 22, 34), "source")
BINARY = Location("/show/look.usdc", "look.usdc")
PACKED = Location("/show/c.usdz", "c.usdz", "sub/a.usda", Span(3, 1, 2), "source")
NASTY = "100%\r\n::error::x, y:\x1b[2J##[warning]\u2028\udcf6"


def a_finding(location: Location = TEXT, **more: Any) -> Located:
    values: dict[str, Any] = {
        "rule": RULE,
        "severity": Severity.ERROR,
        "message": "camera </World/cam> does not exist",
        "label": "",
        "help": "",
        "prim_path": "/Render/Primary",
        "property": "camera",
        "target": None,
    }
    return Located(location=location, **(values | more))


def render(*findings: Located, problems: tuple[Problem, ...] = ()) -> list[str]:
    report = Report("0.1.0", (), ("shots/render.usda",), findings, problems)
    return github.render(report, quiet=True).split("\n")[:-1]


def understood(line: str) -> tuple[str, dict[str, str], str]:
    """Level, properties and message, read as the runner's `ActionCommand.TryParseV2` does."""
    end = line.index("::", 2)
    assert line.startswith("::")
    level, _, properties = line[2:end].partition(" ")
    pairs = dict(pair.split("=", 1) for pair in properties.split(","))
    return (
        level,
        {name: decoded(value, (",", "%2C"), (":", "%3A")) for name, value in pairs.items()},
        decoded(line[end + 2 :]),
    )


def decoded(text: str, *more: tuple[str, str]) -> str:
    for plain, code in (*more, ("\n", "%0A"), ("\r", "%0D"), ("%", "%25")):
        text = text.replace(code, plain)
    return text


@pytest.mark.parametrize(
    ("finding", "expected"),
    [
        (
            a_finding(help="did you mean </World/main_cam>?"),
            "::error file=shots/render.usda,line=12,col=22,endLine=12,endColumn=34,"
            "title=usdrender-lint (unresolved-target)"
            "::shots/render.usda:12:22: error[unresolved-target] camera </World/cam> does not exist "
            "</Render/Primary.camera>%0Ahelp: did you mean </World/main_cam>?",
        ),
        (
            a_finding(BINARY, severity=Severity.WARNING),
            "::warning file=look.usdc,title=usdrender-lint (unresolved-target)"
            "::look.usdc: warning[unresolved-target] camera </World/cam> does not exist "
            "</Render/Primary.camera>",
        ),
        (
            a_finding(PACKED, severity=Severity.NOTE, prim_path="/", property=None),
            "::notice file=c.usdz,title=usdrender-lint (unresolved-target)"
            "::c.usdz[sub/a.usda]:3:1: note[unresolved-target] camera </World/cam> does not exist",
        ),
    ],
    ids=["text", "binary", "package"],
)
def test_a_finding(finding: Located, expected: str) -> None:
    assert render(finding) == [expected]


def test_problems_are_errors() -> None:
    found = render(
        problems=(
            Problem("unreadable-file", "a,b.usdc", "the file is empty"),
            Problem("crashed-usd", "", "out of memory"),
        )
    )
    assert found == [
        "::error file=a%2Cb.usdc,title=usdrender-lint (unreadable-file)"
        "::a,b.usdc: the file is empty",
        "::error title=usdrender-lint (crashed-usd)::out of memory",
    ]


def test_whatever_a_name_holds_it_is_one_command() -> None:
    finding = a_finding(
        Location("/x", NASTY, NASTY, Span(1, 1, 2), NASTY),
        message=NASTY,
        help=NASTY,
        prim_path=NASTY,
        property=NASTY,
    )
    lines = render(finding, problems=(Problem("unreadable-file", NASTY, NASTY),))
    assert len(lines) == 2
    for line in lines:
        assert not re.search(r"[\r\n]", line)
        level, properties, message = understood(line)
        assert level == "error"
        assert properties["file"] == NASTY
        assert set(properties) == {"file", "title"}
        visible = r"100%\r\n::error::x, y:\x1b[2J##[warning]\u2028\udcf6"
        assert message.count(visible) >= 2
        assert message.replace("\n", "").isprintable()


def many(severity: Severity, count: int) -> list[Located]:
    return [a_finding(severity=severity, message=f"{severity} {n}") for n in range(count)]


def test_the_most_severe_come_first_and_what_was_not_looked_at_before() -> None:
    found = render(
        *many(Severity.NOTE, 1),
        *many(Severity.ERROR, 2),
        *many(Severity.WARNING, 1),
        problems=(Problem("unreadable-file", "a", "is empty"),),
    )
    assert [understood(line)[0] for line in found] == ["error"] * 3 + ["warning", "notice"]
    assert "is empty" in found[0]
    assert "error 0" in found[1]
    assert "error 1" in found[2]


@pytest.mark.parametrize(
    ("errors", "warnings", "notes", "told"),
    [
        (10, 10, 10, None),
        (11, 0, 0, "1 more error"),
        (0, 13, 0, "3 more warnings"),
        (0, 0, 11, "2 more notices"),  # the tenth place is taken by the sentence itself
        (11, 0, 10, "1 more error and 1 more notice"),
        (12, 13, 14, "2 more errors, 3 more warnings and 5 more notices"),
    ],
)
def test_what_github_drops_is_told_where_github_does_not_drop_it(
    errors: int, warnings: int, notes: int, told: str | None
) -> None:
    found = render(
        *many(Severity.ERROR, errors),
        *many(Severity.WARNING, warnings),
        *many(Severity.NOTE, notes),
    )
    sentence = "GitHub shows 10 annotations of a level. In the log of this step: "
    about = [n for n, line in enumerate(found) if sentence in line]
    assert about == ([] if told is None else [errors + warnings])
    assert told is None or found[about[0]] == f"::notice title=usdrender-lint::{sentence}{told}"
    assert len(found) == errors + warnings + notes + len(about)


def test_the_log_ends_with_how_much_was_looked_at() -> None:
    assert github.render(Report("0", (), ("a",), ())) == "No findings in 1 file.\n"
    text = github.render(Report("0", (), ("a",), (a_finding(),)))
    assert text.splitlines()[1:] == ["1 finding (1 error) in 1 file."]
    assert github.render(Report("0", (), ("a",), ()), quiet=True) == ""
