"""What does a code scanner read? The report as one run of SARIF 2.1.0.

Where the standard leaves a choice, the one that GitHub's code scanning shows best is
taken. A result stands at one line of one file, because GitHub shows an alert in a
pull request only if the diff holds every line of it. No times, no machine, no command
line: the same report gives the same bytes. Braces in messages are not doubled, as the
standard has it, because no reader undoes that where a message has no arguments.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from ..results import Located, Location, Place, Problem, Report
from . import NAME, to_json
from .sarif_rules import driver, kinds_of
from .sarif_tables import (
    Alert,
    Json,
    Tables,
    artifacts,
    as_place,
    bases,
    line_of,
    logical_locations,
    members,
    qualified_name,
    tables_of,
)

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
MAX_RESULTS = 25_000
"""GitHub refuses the whole upload for one more, and shows the 5,000 worst."""
_INSERTION_POINT = {"startLine": 1, "startColumn": 1, "endLine": 1, "endColumn": 1}
"""GitHub refuses a result without a line; equal columns claim no text."""


def render(report: Report, pages: Mapping[str, str]) -> str:
    """`pages` holds the Markdown of the rules' pages by rule id."""
    return to_json({"$schema": SCHEMA, "version": "2.1.0", "runs": [_run(report, pages)]})


def _run(report: Report, pages: Mapping[str, str]) -> Json:
    every = _alerts(report.findings)
    alerts = _worst(every)
    tables = tables_of(report, alerts)
    return {
        "tool": {"driver": driver(report, pages)},
        "invocations": [_invocation(report, tables, left_out=len(every) - len(alerts))],
        "originalUriBaseIds": dict(bases(report, tables)),
        "artifacts": [*artifacts(report, tables), *members(report, tables)],
        "logicalLocations": logical_locations(tables),
        "results": [_result(alert, tables) for alert in alerts],
        **_automation(report),
        "columnKind": "unicodeCodePoints",
        "defaultEncoding": "utf-8",
        "properties": {
            "renderers": [
                {"root": choice.root, "name": choice.name, "reason": choice.reason}
                for choice in report.renderers
            ]
        },
    }


def _automation(report: Report) -> Json:
    """Code scanning takes what stands before the last slash for the category: without one of their
    own the parts of a run would replace each other."""
    return {"automationDetails": {"id": f"{NAME}/{report.part}/"}} if report.part else {}


def _alerts(findings: Iterable[Located]) -> list[Alert]:
    alerts: defaultdict[tuple[object, ...], list[Located]] = defaultdict(list)
    for finding in findings:
        place = line_of(finding.location) or finding.fingerprint
        alerts[finding.rule.id, finding.location.path, place].append(finding)
    return [sorted(alert, key=lambda finding: finding.severity.rank) for alert in alerts.values()]


def _worst(alerts: list[Alert]) -> list[Alert]:
    """As many as may be told, in their order."""
    if len(alerts) <= MAX_RESULTS:
        return alerts
    ranked = sorted(range(len(alerts)), key=lambda i: (alerts[i][0].severity.rank, i))
    return [alerts[i] for i in sorted(ranked[:MAX_RESULTS])]


def _invocation(report: Report, tables: Tables, left_out: int) -> Json:
    """A notification of level error means by the standard that the run failed."""
    kinds = kinds_of(report)
    return {
        "executionSuccessful": report.complete,
        "toolExecutionNotifications": [
            {
                "descriptor": {"id": problem.kind, "index": kinds.index(problem.kind)},
                "level": "error",
                "message": {"text": _sentence(_with_path(problem))},
                **_notification_location(problem, tables),
                **_associated_rule(problem, tables),
            }
            for problem in report.problems
        ]
        + _left_out(left_out),
        **_skipped_rules(report, len(kinds)),
    }


def _left_out(count: int) -> list[Json]:
    if not count:
        return []
    text = f"{count:,} results are left out: a run may hold {MAX_RESULTS:,}, the worst are here."
    return [{"level": "warning", "message": {"text": text}}]


def _skipped_rules(report: Report, descriptor: int) -> Json:
    if not report.skipped:
        return {}
    return {
        "toolConfigurationNotifications": [
            {
                "descriptor": {"id": "skipped-rule", "index": descriptor},
                "level": "note",
                "message": {"text": _sentence(f"The rule '{skipped.rule}' {skipped.reason}")},
                "associatedRule": {"id": skipped.rule},
            }
            for skipped in report.skipped
        ]
    }


def _with_path(problem: Problem) -> str:
    return f"{problem.path}: {problem.message}" if problem.path else problem.message


def _notification_location(problem: Problem, tables: Tables) -> Json:
    where = tables.file(problem.path)
    return {"locations": [{"physicalLocation": {"artifactLocation": where}}]} if where else {}


def _associated_rule(problem: Problem, tables: Tables) -> Json:
    if not problem.rule:
        return {}
    index = {"index": tables.rules[problem.rule]} if problem.rule in tables.rules else {}
    return {"associatedRule": {"id": problem.rule, **index}}


# Results


def _result(alert: Alert, tables: Tables) -> Json:
    first, *others = alert
    further = [place for other in others for place in (as_place(other), *other.related)]
    related = list(dict.fromkeys((*first.related, *further)))
    return {
        "ruleId": first.rule.id,
        "ruleIndex": tables.rules[first.rule.id],
        "level": first.severity.value,
        "message": {"text": " ".join(_sentences(first, others, related))},
        "locations": [
            {
                **_location(as_place(first), tables, first.also),
                **({"message": {"text": first.label}} if first.label else {}),
            }
        ],
        "relatedLocations": [
            {
                "id": number,
                **_location(place, tables),
                "message": {"text": _sentence(_related_text(place))},
            }
            for number, place in enumerate(related, 1)
        ],
        "partialFingerprints": _fingerprints(first, tables),
        "properties": {
            **_facts(first),
            **({"alsoHere": [_described(other) for other in others]} if others else {}),
        },
    }


def _sentences(first: Located, others: Alert, related: Sequence[Place]) -> Iterator[str]:
    """What a reader needs who sees nothing but the message and one line of the file."""
    yield _sentence(first.message)
    if not line_of(first.location):
        yield f"It is about {_object(as_place(first))}."
    if first.help:
        yield f"Help: {_sentence(first.help)}"
    if first.related:
        yield f"See also: {_links(first.related, related)}."
    if others:
        yield f"The same rule here: {_links([as_place(other) for other in others], related)}."


def _sentence(text: str) -> str:
    text = text.strip()
    return text if text.endswith((".", "!", "?")) else f"{text}."


def _links(places: Iterable[Place], related: Sequence[Place]) -> str:
    """GitHub shows a related location only where the message links to its id."""
    return ", ".join(
        f"[{_escaped(_related_text(place))}]({related.index(place) + 1})"
        for place in dict.fromkeys(places)
    )


def _escaped(link_text: str) -> str:
    return re.sub(r"([\\\[\]])", r"\\\1", link_text)


def _related_text(place: Place) -> str:
    text = place.message.strip().removesuffix(".")
    return text if line_of(place.location) else f"{text}, {_object(place)}"


def _object(place: Place) -> str:
    """Prim or property, and the layer in the package: where the file shows no line."""
    path = qualified_name(place)
    what = "the layer's metadata" if path == "/" else f"<{path}>"
    if not place.location.member:
        return what
    line = f", line {place.location.span.line}" if place.location.span else ""
    return f"{what} in '{place.location.member}'{line}"


def _location(place: Place, tables: Tables, also: Iterable[str] = ()) -> Json:
    """`also` are further prims that share what stands there."""
    path = place.location.path
    places = (place, *(replace(place, prim_path=prim) for prim in also))
    return {
        "physicalLocation": {
            "artifactLocation": tables.file(path),
            "region": _region(place.location),
        },
        "logicalLocations": [
            {
                "fullyQualifiedName": name,
                "kind": tables.objects[name].kind,
                "index": tables.object_index[name],
            }
            for name in map(qualified_name, places)
        ],
    }


def _region(location: Location) -> Json:
    span = location.span
    if not span or location.member:
        return {**_INSERTION_POINT}
    return {
        "startLine": span.line,
        "startColumn": span.column,
        "endLine": span.line,
        "endColumn": span.end_column,
    }


def _fingerprints(finding: Located, tables: Tables) -> Json:
    """GitHub follows an alert from commit to commit by the first of them.

    Its own hash for a binary layer would change at every save, so that one is ours.
    """
    line = line_of(finding.location)
    ours = finding.fingerprint
    theirs = tables.line_hashes.get((finding.location.file, line)) if line else f"{ours}:1"
    return {
        **({"primaryLocationLineHash": theirs} if theirs else {}),
        "usdrenderLint/v1": ours,
    }


def _facts(finding: Located) -> Json:
    """The USD object as rows of a table: viewers that show no logical locations show these."""
    facts = {
        "primPath": finding.prim_path,
        "property": finding.property,
        "target": finding.target,
        "also": list(finding.also),
        "roots": list(finding.roots),
        "usdPackageMember": finding.location.member,
    }
    return {key: value for key, value in facts.items() if value}


def _described(other: Located) -> Json:
    """A finding that shares its result with a worse or earlier one."""
    return {
        "message": other.message,
        "help": other.help,
        "level": other.severity.value,
        **_facts(other),
        "fingerprint": other.fingerprint,
    }
