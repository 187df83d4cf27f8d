"""What does a script read? The report as versioned JSON: 1-based, sorted, the same bytes on every run."""

from __future__ import annotations

from ..results import Located, Location, Place, Problem, Report
from . import NAME, page_url, to_json

VERSION = 1
"""Grows when a key changes its meaning or goes; a new key changes nothing for its readers."""


def render(report: Report) -> str:
    return to_json(
        {
            "version": VERSION,
            "tool": {"name": NAME, "version": report.version},
            "files": len(report.files),
            "findings": [_finding(finding) for finding in report.findings],
            "errors": [_error(problem) for problem in report.problems],
            "summary": {
                **{severity.value: count for severity, count in report.counts.items()},
                "suppressed": report.ignored,
                "baseline": report.in_baseline,
            },
        }
    )


def _finding(finding: Located) -> dict[str, object]:
    return {
        "rule": finding.rule.id,
        "severity": finding.severity.value,
        "message": finding.message,
        **_position(finding.location),
        "primPath": finding.prim_path,
        "property": finding.property,
        "target": finding.target,
        "help": finding.help or None,
        **_roots(finding.roots),
        "chain": [{"arc": step.arc, "path": step.path} for step in finding.chain],
        **({"also": list(finding.also)} if finding.also else {}),
        "variants": {name: list(chosen) for name, chosen in finding.variants},
        "related": [_related(place) for place in finding.related],
        "fixable": False,
        "fix": None,
        "fingerprint": finding.fingerprint,
        "url": page_url(finding.rule.id),
    }


def _position(location: Location) -> dict[str, object]:
    """Four times null where a layer has no text."""
    span = location.span
    return {
        "path": _layer(location),
        "line": span and span.line,
        "column": span and span.column,
        "endLine": span and span.line,
        "endColumn": span and span.end_column,
    }


def _layer(location: Location) -> str:
    """A member of a package as USD writes it: `pkg.usdz[sub/a.usda]`."""
    return f"{location.path}[{location.member}]" if location.member else location.path


def _roots(roots: tuple[str, ...]) -> dict[str, object]:
    """Nearly every finding holds in one stage; only for others there is a list."""
    every = {"roots": list(roots)} if len(roots) > 1 else {}
    return {"root": roots[0] if roots else None, **every}


def _related(place: Place) -> dict[str, object]:
    span = place.location.span
    return {
        "message": place.message,
        "path": _layer(place.location),
        "line": span and span.line,
        "column": span and span.column,
        "primPath": place.prim_path,
        "property": place.property,
    }


def _error(problem: Problem) -> dict[str, object]:
    rule = {"rule": problem.rule} if problem.rule else {}
    return {"kind": problem.kind, "path": problem.path, "message": problem.message, **rule}
