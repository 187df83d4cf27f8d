"""What does GitLab show in a merge request? The report as a Code Quality artifact."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterable, Iterator

from ..printable import escaped
from ..results import Located, Problem, Report
from ..rule import Severity
from . import to_json
from .full import roots_shown, spec

Json = dict[str, object]

SEVERITIES = {Severity.ERROR: "major", Severity.WARNING: "minor", Severity.NOTE: "info"}
OF_PROBLEMS = "blocker"
"""What was not linted is no better than what was before; without a word it would look so."""


def render(report: Report) -> str:
    issues = [*map(_problem, report.problems), *map(_finding, report.findings)]
    return to_json(list(_told_apart(issues)))


def _finding(finding: Located) -> Json:
    at = finding.location
    # The lines of a layer in a package are not those of the package.
    line = at.span.line if at.span and not at.member else None
    parts = [f"{finding.rule.id}:", escaped(finding.message)]
    if not line:
        # The description alone tells the place.
        parts += [_member(at.member), spec(finding.prim_path, finding.property)]
    if roots := roots_shown(finding):
        parts.append(f"(in {roots})")
    text = " ".join(filter(None, parts))
    severity = SEVERITIES[finding.severity]
    return _issue(finding.rule.id, text, finding.fingerprint, severity, at.path, line or 1)


def _member(member: str | None) -> str:
    return f"in {escaped(member)}" if member else ""


def _problem(problem: Problem) -> Json:
    parts = "\0".join((problem.kind, problem.path, problem.rule or ""))
    fingerprint = hashlib.sha256(parts.encode("utf-8", "surrogatepass")).hexdigest()[:16]
    text = f"{problem.kind}: {escaped(problem.message)}"
    # Without a path GitLab refuses the whole report.
    return _issue(problem.kind, text, fingerprint, OF_PROBLEMS, problem.path or ".", 1)


def _issue(name: str, text: str, fingerprint: str, severity: str, path: str, line: int) -> Json:
    return {
        "description": text,
        "check_name": name,
        "fingerprint": fingerprint,
        "severity": severity,
        "location": {"path": path, "lines": {"begin": line}},
    }


def _told_apart(issues: Iterable[Json]) -> Iterator[Json]:
    """GitLab shows one of several that share a fingerprint, and two problems of a file may."""
    seen: Counter[object] = Counter()
    for issue in issues:
        seen[issue["fingerprint"]] += 1
        count = seen[issue["fingerprint"]]
        yield issue if count == 1 else {**issue, "fingerprint": f"{issue['fingerprint']}-{count}"}
