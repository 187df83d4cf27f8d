"""Which rules speak most? Counts instead of findings."""

from __future__ import annotations

from collections import defaultdict

from ..results import Located, Report
from .full import BOLD, SEVERITY_SGR, Ink, plural, summary


def render(report: Report, *, color: bool, verbose: bool = False, quiet: bool = False) -> str:
    """A line for each rule, most findings first, then the summary unless `quiet`.

    A rule that spoke with two severities has two lines, so that they add up to the summary.
    """
    found: defaultdict[tuple[str, str], list[Located]] = defaultdict(list)
    for finding in report.findings:
        found[finding.rule.id, finding.severity].append(finding)
    by_count = sorted(found.values(), key=lambda of: (-len(of), of[0].severity.rank, of[0].rule.id))
    ink = Ink(color)
    wide = max((len(rule) for rule, _ in found), default=0)
    number = max((len(str(len(of))) for of in by_count), default=0)
    lines = "".join(
        f"{ink(BOLD, f'{len(of):>{number}}')}"
        f"  {ink(SEVERITY_SGR[of[0].severity], f'{of[0].severity:7}')}"
        f"  {of[0].rule.id:{wide}}"
        f"  {plural(len({f.location.path for f in of}), 'file')}\n"
        for of in by_count
    )
    return lines if quiet else lines + summary(report, verbose=verbose)
