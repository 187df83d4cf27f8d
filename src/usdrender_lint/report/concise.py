"""How does a report look to grep and to an editor? One line a finding."""

from __future__ import annotations

from pathlib import Path

from ..printable import escaped
from ..results import Located, Report
from .full import (
    BOLD,
    SEVERITY_SGR,
    Ink,
    position,
    roots_shown,
    shown,
    spec,
    summary,
    variants_shown,
)


def render(
    report: Report,
    *,
    color: bool,
    verbose: bool = False,
    quiet: bool = False,
    base: Path | None = None,
) -> str:
    """All findings, then the summary unless `quiet`."""
    base = base or Path.cwd()
    lines = "".join(f"{line(finding, Ink(color), base)}\n" for finding in report.findings)
    return lines if quiet else lines + summary(report, verbose=verbose)


def line(finding: Located, ink: Ink, base: Path | None = None, *, with_roots: bool = True) -> str:
    """Place, rule, message, object, stages. Without `base` paths are the report's own."""
    at = finding.location
    roots = roots_shown(finding, base) if with_roots else ""
    parts = (
        f"{ink(BOLD, shown(at, base))}{position(at.span)}:",
        ink(SEVERITY_SGR[finding.severity], f"{finding.severity}[{finding.rule.id}]"),
        escaped(finding.message),
        spec(finding.prim_path, finding.property),
        f"(in {roots})" if roots else "",
        f"(only with {variants_shown(finding)})" if finding.variants else "",
    )
    return " ".join(filter(None, parts))
