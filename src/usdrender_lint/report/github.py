"""What does GitHub show in a pull request? The report as workflow commands.

The runner prints of a command only its message, so that begins with the place, as in `concise`.
Commands beyond the limit are written all the same: the log holds every finding.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..printable import escaped
from ..results import Located, Problem, Report
from ..rule import Severity
from . import NAME
from .concise import line
from .full import Ink, counts, listed, plural

LIMIT = 10
"""Annotations of one level that GitHub takes from one step. It drops the others without a word."""

LEVELS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.NOTE: "notice"}


def render(report: Report, *, quiet: bool = False) -> str:
    """The most severe first, because GitHub takes the first; the counts unless `quiet`."""
    commands: dict[str, list[str]] = {level: [] for level in LEVELS.values()}
    commands["error"] = [_problem(problem) for problem in report.problems]
    for finding in report.findings:
        commands[LEVELS[finding.severity]].append(_finding(finding))
    if more := _more(commands):
        # The first of its level: after ten others it would be dropped itself.
        commands["notice"].insert(0, more)
    lines = [command for level in commands.values() for command in level]
    if not quiet:
        # Only numbers: the runner would obey a `##[command]` from a file's name in any plain line.
        lines.append(counts(report))
    return "".join(f"{one}\n" for one in lines)


def _finding(finding: Located) -> str:
    at = finding.location
    place: dict[str, object] = {"file": at.path}
    # The lines of a layer in a package are not those of the package.
    if at.span and not at.member:
        place |= {
            "line": at.span.line,
            "col": at.span.column,
            "endLine": at.span.line,
            "endColumn": at.span.end_column,
        }
    text = line(finding, Ink(False))
    if finding.help:
        text += f"\nhelp: {escaped(finding.help)}"
    return _command(LEVELS[finding.severity], place, finding.rule.id, text)


def _problem(problem: Problem) -> str:
    place = {"file": problem.path} if problem.path else {}
    text = ": ".join(escaped(part) for part in (problem.path, problem.message) if part)
    return _command("error", place, problem.kind, text)


def _more(commands: Mapping[str, list[str]]) -> str | None:
    """How many GitHub drops; None if none."""
    if all(len(level) <= LIMIT for level in commands.values()):
        return None
    # This one takes a place, too.
    room = {level: LIMIT - (level == "notice") for level in commands}
    more = [
        plural(len(found) - room[level], f"more {level}")
        for level, found in commands.items()
        if len(found) > room[level]
    ]
    text = f"GitHub shows {LIMIT} annotations of a level. In the log of this step: {listed(more)}"
    return _command("notice", {}, None, text)


def _command(level: str, place: Mapping[str, object], what: str | None, text: str) -> str:
    properties = {**place, "title": f"{NAME} ({what})" if what else NAME}
    written = ",".join(f"{name}={_in_property(str(value))}" for name, value in properties.items())
    return f"::{level} {written}::{_in_message(text)}"


def _in_message(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _in_property(text: str) -> str:
    return _in_message(text).replace(":", "%3A").replace(",", "%2C")
