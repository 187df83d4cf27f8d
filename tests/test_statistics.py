"""Counts instead of findings."""

from __future__ import annotations

from usdrender_lint.model import RenderPrim
from usdrender_lint.report import statistics
from usdrender_lint.results import Located, Location, Report
from usdrender_lint.rule import Rule, Severity


def findings(rule: str, severity: Severity, *paths: str) -> tuple[Located, ...]:
    made: Rule[RenderPrim] = Rule(
        rule, RenderPrim, severity, "0.1", "", lambda subject, context: iter(())
    )
    return tuple(
        Located(made, severity, "message", "", "", Location(f"/{path}", path), "/R", None, None)
        for path in paths
    )


def render(*found: tuple[Located, ...], color: bool = False, quiet: bool = True) -> str:
    report = Report("0.1.0", (), ("a",), tuple(one for some in found for one in some))
    return statistics.render(report, color=color, quiet=quiet)


def test_the_most_frequent_first_then_the_worst_then_by_name() -> None:
    text = render(
        findings("b-note", Severity.NOTE, "a"),
        findings("z-error", Severity.ERROR, "a"),
        findings("a-warning", Severity.WARNING, "a"),
        findings("often", Severity.NOTE, *"aabbbbbbbbbc"),
        findings("b-error", Severity.ERROR, "a"),
    )
    assert text.splitlines() == [
        "12  note     often      3 files",
        " 1  error    b-error    1 file",
        " 1  error    z-error    1 file",
        " 1  warning  a-warning  1 file",
        " 1  note     b-note     1 file",
    ]


def test_the_lines_add_up_to_the_summary() -> None:
    text = render(
        findings("both", Severity.NOTE, "a"), findings("both", Severity.ERROR, "a"), quiet=False
    )
    assert text.splitlines() == [
        "1  error    both  1 file",
        "1  note     both  1 file",
        "2 findings (1 error, 1 note) in 1 file.",
    ]


def test_nothing_found() -> None:
    assert render() == ""
    assert render(quiet=False) == "No findings in 1 file.\n"


def test_color() -> None:
    text = render(findings("one", Severity.ERROR, "a"), color=True)
    assert text == "\x1b[1m1\x1b[0m  \x1b[1;31merror  \x1b[0m  one  1 file\n"
