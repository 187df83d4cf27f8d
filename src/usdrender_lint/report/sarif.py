"""What does a code scanner read? The report as one run of SARIF 2.1.0.

Where the standard leaves a choice, the one that GitHub's code scanning shows best is
taken. A result stands at one line of one file, because GitHub shows an alert in a
pull request only if the diff holds every line of it. No times, no machine, no command
line: the same report gives the same bytes. Braces in messages are not doubled, as the
standard has it, because no reader undoes that where a message has no arguments.
"""

from __future__ import annotations

import re
import struct
import zipfile
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from urllib.parse import quote

from ..pages import MalformedPageError, parse
from ..records import dataclass
from ..results import Located, Location, Place, Problem, Report
from ..rule import AnyRule, Severity
from . import HOME, NAME, page_url, to_json
from .fingerprint import file_line_hashes

Json = dict[str, object]
Alert = Sequence[Located]
"""Findings that scanners take for one, because rule, file and line are the same; the worst first."""

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
ROOT = "%SRCROOT%"
ABOVE = "%ABOVE{}%"
"""The folder so many levels above the root. For files outside of the repository: the standard wants
`..` resolved, and GitHub refuses a whole upload for one result with an absolute address."""
MAX_RESULTS = 25_000
"""GitHub refuses the whole upload for one more, and shows the 5,000 worst."""
MAX_DESCRIPTION = 1024
"""GitHub refuses the whole upload for one longer description."""

PRECISION = {Severity.ERROR: "very-high", Severity.WARNING: "high", Severity.NOTE: "medium"}
"""GitHub sorts by it. An error follows from how values are read, a warning guesses what was meant."""
PROBLEM_SEVERITY = {
    Severity.ERROR: "error",
    Severity.WARNING: "warning",
    Severity.NOTE: "recommendation",
}
MIME_TYPES = {".usda": "model/vnd.usda", ".usdz": "model/vnd.usdz+zip"}
"""The two that are registered."""

_INSERTION_POINT = {"startLine": 1, "startColumn": 1, "endLine": 1, "endColumn": 1}
"""GitHub refuses a result without a line; equal columns claim no text."""
_URI_SAFE = "/!$&'()*+,;=@~"
"""What a relative reference may hold as it is. No colon: what stands before one is a scheme."""


def render(report: Report, pages: Mapping[str, str]) -> str:
    """`pages` holds the Markdown of the rules' pages by rule id."""
    return to_json({"$schema": SCHEMA, "version": "2.1.0", "runs": [_run(report, pages)]})


def _run(report: Report, pages: Mapping[str, str]) -> Json:
    every = _alerts(report.findings)
    alerts = _worst(every)
    tables = _tables(report, alerts)
    return {
        "tool": {"driver": _driver(report, pages)},
        "invocations": [_invocation(report, tables, left_out=len(every) - len(alerts))],
        "originalUriBaseIds": dict(_bases(report, tables)),
        "artifacts": [*_artifacts(report, tables), *_members(report, tables)],
        "logicalLocations": _logical_locations(tables),
        "results": [_result(alert, tables) for alert in alerts],
        "columnKind": "unicodeCodePoints",
        "defaultEncoding": "utf-8",
        "properties": {
            "renderers": [
                {"root": choice.root, "name": choice.name, "reason": choice.reason}
                for choice in report.renderers
            ]
        },
    }


def _alerts(findings: Iterable[Located]) -> list[Alert]:
    alerts: defaultdict[tuple[object, ...], list[Located]] = defaultdict(list)
    for finding in findings:
        place = _line(finding.location) or finding.fingerprint
        alerts[finding.rule.id, finding.location.path, place].append(finding)
    return [sorted(alert, key=lambda finding: finding.severity.rank) for alert in alerts.values()]


def _worst(alerts: list[Alert]) -> list[Alert]:
    """As many as may be told, in their order."""
    if len(alerts) <= MAX_RESULTS:
        return alerts
    ranked = sorted(range(len(alerts)), key=lambda i: (alerts[i][0].severity.rank, i))
    return [alerts[i] for i in sorted(ranked[:MAX_RESULTS])]


def _line(location: Location) -> int | None:
    """The line of the file. A member of a package has lines, but the file is the package."""
    return location.span.line if location.span and not location.member else None


# The tool


def _driver(report: Report, pages: Mapping[str, str]) -> Json:
    return {
        "name": NAME,
        "fullName": f"{NAME} {report.version}",
        "version": report.version,
        "semanticVersion": report.version,
        "informationUri": HOME,
        "rules": [_descriptor(rule, pages.get(rule.id, "")) for rule in report.rules],
        "notifications": [
            *(_notification_descriptor(kind) for kind in _kinds(report)),
            *([_SKIPPED_RULE] if report.skipped else []),
        ],
    }


def _descriptor(rule: AnyRule, page: str) -> Json:
    page = _with_absolute_links(page)
    return {
        "id": rule.id,
        "name": _pascal(rule.id),
        "shortDescription": {"text": _cut(rule.summary)},
        "fullDescription": {"text": _cut(_why(page) or rule.summary)},
        "help": {"text": _plain(page) or rule.summary, "markdown": page or rule.summary},
        "helpUri": page_url(rule.id),
        "defaultConfiguration": {"level": rule.severity.value},
        "properties": {
            "precision": PRECISION[rule.severity],
            "problem.severity": PROBLEM_SEVERITY[rule.severity],
            "tags": list(dict.fromkeys(filter(None, ("usd", "render", rule.group)))),
        },
    }


def _notification_descriptor(kind: str) -> Json:
    """GitHub's validation asks of notifications what it asks of rules."""
    text = f"The run is incomplete: {kind.replace('-', ' ')}."
    return {
        "id": kind,
        "name": _pascal(kind),
        "shortDescription": {"text": text},
        "fullDescription": {"text": text},
        "help": {"text": "What could be linted is reported all the same. The exit code is 2."},
        "defaultConfiguration": {"level": "error"},
    }


_SKIPPED_RULE: Json = {
    "id": "skipped-rule",
    "name": "SkippedRule",
    "shortDescription": {"text": "A rule was asked for and did not run."},
    "fullDescription": {"text": "A rule was asked for and did not run; the message says why."},
    "help": {"text": "Rules that need the whole stage run with --scene, or selected by name."},
    "defaultConfiguration": {"level": "note"},
}


def _kinds(report: Report) -> list[str]:
    return sorted({problem.kind for problem in report.problems})


def _pascal(kebab: str) -> str:
    return "".join(word.capitalize() for word in kebab.split("-"))


def _with_absolute_links(page: str) -> str:
    """Pages link to their neighbours in the same folder, which a scanner's web page has not."""
    return re.sub(r"\]\(([a-z0-9-]+)\.md\)", lambda link: f"]({page_url(link[1])})", page)


def _why(page: str) -> str:
    """The first paragraph of prose, on one line."""
    try:
        paragraph = parse(page).why.partition("\n\n")[0]
    except MalformedPageError:  # of a rule that is not ours: its result must still be told
        return ""
    return _plain(" ".join(paragraph.split()))


def _plain(markdown: str) -> str:
    """Without the marks of Markdown; usda in a fenced block stays as it is."""
    parts = re.split(r"^```.*\n", markdown, flags=re.MULTILINE)
    return "".join(_plain_prose(p) if i % 2 == 0 else p for i, p in enumerate(parts)).strip()


def _plain_prose(markdown: str) -> str:
    headless = re.sub(r"^#+ ", "", markdown, flags=re.MULTILINE)
    # Code comes first: a path expression such as `/World//*` is no emphasis.
    marks = r"`([^`]+)`|\[([^\]]+)\]\([^)]*\)|(?:\*\*|\*)([^*\s][^*\n]*)(?:\*\*|\*)"
    return re.sub(marks, lambda m: m[1] or _plain_prose(m[2] or m[3]), headless)


def _cut(text: str) -> str:
    if len(text) <= MAX_DESCRIPTION:
        return text
    return text[: MAX_DESCRIPTION - 1].rpartition(" ")[0] + "…"


def _invocation(report: Report, tables: _Tables, left_out: int) -> Json:
    """A notification of level error means by the standard that the run failed."""
    kinds = _kinds(report)
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


def _notification_location(problem: Problem, tables: _Tables) -> Json:
    where = tables.file(problem.path)
    return {"locations": [{"physicalLocation": {"artifactLocation": where}}]} if where else {}


def _associated_rule(problem: Problem, tables: _Tables) -> Json:
    if not problem.rule:
        return {}
    index = {"index": tables.rules[problem.rule]} if problem.rule in tables.rules else {}
    return {"associatedRule": {"id": problem.rule, **index}}


# Results


def _result(alert: Alert, tables: _Tables) -> Json:
    first, *others = alert
    further = [place for other in others for place in (_as_place(other), *other.related)]
    related = list(dict.fromkeys((*first.related, *further)))
    return {
        "ruleId": first.rule.id,
        "ruleIndex": tables.rules[first.rule.id],
        "level": first.severity.value,
        "message": {"text": " ".join(_sentences(first, others, related))},
        "locations": [
            {
                **_location(_as_place(first), tables, first.also),
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
    if not _line(first.location):
        yield f"It is about {_object(_as_place(first))}."
    if first.help:
        yield f"Help: {_sentence(first.help)}"
    if first.related:
        yield f"See also: {_links(first.related, related)}."
    if others:
        yield f"The same rule here: {_links([_as_place(other) for other in others], related)}."


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
    return text if _line(place.location) else f"{text}, {_object(place)}"


def _object(place: Place) -> str:
    """Prim or property, and the layer in the package: where the file shows no line."""
    path = _qualified_name(place)
    what = "the layer's metadata" if path == "/" else f"<{path}>"
    if not place.location.member:
        return what
    line = f", line {place.location.span.line}" if place.location.span else ""
    return f"{what} in '{place.location.member}'{line}"


def _location(place: Place, tables: _Tables, also: Iterable[str] = ()) -> Json:
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
            for name in map(_qualified_name, places)
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


def _fingerprints(finding: Located, tables: _Tables) -> Json:
    """GitHub follows an alert from commit to commit by the first of them.

    Its own hash for a binary layer would change at every save, so that one is ours.
    """
    line = _line(finding.location)
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


# What results refer to by index


@dataclass(frozen=True, slots=True)
class _Object:
    """A prim, a property, a variant or the layer itself."""

    name: str
    kind: str
    parent: str | None


@dataclass(frozen=True, slots=True)
class _Tables:
    rules: dict[str, int]
    addresses: dict[str, Json]
    """By shown path, of all files that took part; in the order of the artifacts."""
    objects: dict[str, _Object]
    """By fully qualified name; in the order of the logical locations."""
    object_index: dict[str, int]
    artifact_index: dict[str, int]
    line_hashes: dict[tuple[str, int], str]
    """By file and line; without files that could not be hashed."""

    def file(self, path: str) -> Json:
        """Empty for what has no address: a folder above the repository."""
        if path in self.addresses:
            return self.addresses[path] | {"index": self.artifact_index[path]}
        return _address(path)


def _tables(report: Report, alerts: Iterable[Alert]) -> _Tables:
    addresses = _addresses(report)
    objects = _objects(report)
    return _Tables(
        rules=_index(rule.id for rule in report.rules),
        addresses=addresses,
        objects=objects,
        object_index=_index(objects),
        artifact_index=_index(addresses),
        line_hashes=_line_hashes(alerts),
    )


def _index(keys: Iterable[str]) -> dict[str, int]:
    return {key: index for index, key in enumerate(keys)}


def _places(report: Report) -> Iterator[Place]:
    for finding in report.findings:
        yield (at := _as_place(finding))
        yield from (replace(at, prim_path=prim) for prim in finding.also)
        yield from finding.related


def _as_place(finding: Located) -> Place:
    return Place(finding.message, finding.location, finding.prim_path, finding.property)


def _addresses(report: Report) -> dict[str, Json]:
    files = {*report.files, *report.layers, *(place.location.path for place in _places(report))}
    addresses = {path: _address(path) for path in sorted(files)}
    return {path: address for path, address in addresses.items() if address}


def _address(shown: str) -> Json:
    if Path(shown).is_absolute():  # another drive of Windows
        return {"uri": Path(shown).as_uri()}
    climbs = re.match(r"(?:\.\.(?:/|$))*", shown)
    above = climbs[0].count("..") if climbs else 0
    below = quote(shown.removeprefix("../" * above), safe=_URI_SAFE, errors="surrogateescape")
    base = ABOVE.format(above) if above else ROOT
    return {"uri": below, "uriBaseId": base} if below.strip(".") else {}


def _bases(report: Report, tables: _Tables) -> Iterator[tuple[str, Json]]:
    """Without a `uri`, which would tell names of users and differ between machines."""
    yield ROOT, {"description": {"text": "The root of the repository that was linted."}}
    told = [*tables.addresses.values(), *(_address(p.path) for p in report.problems)]
    for base in sorted({str(address.get("uriBaseId", ROOT)) for address in told} - {ROOT}):
        levels = base.strip("%").removeprefix("ABOVE")
        times = "1 level" if levels == "1" else f"{levels} levels"
        yield base, {"description": {"text": f"The folder {times} above that root."}}


def _artifacts(report: Report, tables: _Tables) -> Iterator[Json]:
    with_result = {finding.location.path for finding in report.findings}
    for path, address in tables.addresses.items():
        # resultFile: a file with a result that the tool was not told to look at.
        role = (path in report.files and "analysisTarget") or (path in with_result and "resultFile")
        roles = {"roles": [role]} if role else {}
        yield {"location": address, **_mime_type(path), **roles}


def _members(report: Report, tables: _Tables) -> Iterator[Json]:
    """Layers in packages, as artifacts within artifacts.

    Named by their bytes: Microsoft's validator refuses the URI that the standard wants.
    """
    members = {
        (place.location.path, member, place.location.file)
        for place in _places(report)
        if (member := place.location.member)
    }
    for path, member, file in sorted(members):
        if extent := _extent(file, member):
            yield {
                "parentIndex": tables.artifact_index[path],
                "offset": extent.start,
                "length": len(extent),
                "description": {"text": f"The layer '{member}' in the package."},
                **_mime_type(member),
            }


def _extent(package: str, member: str) -> range | None:
    """Where in a usdz the bytes of a member are; USD wants them stored, not compressed."""
    try:
        with zipfile.ZipFile(package) as archive, Path(package).open("rb") as raw:
            info = archive.getinfo(member)
            raw.seek(info.header_offset)
            # A header of 30 bytes, which ends with the lengths of the name and the padding after it.
            name, padding = struct.unpack("<26xHH", raw.read(30))
    except (OSError, KeyError, zipfile.BadZipFile, struct.error):
        return None
    start = info.header_offset + 30 + name + padding
    return range(start, start + info.compress_size)


def _mime_type(path: str) -> Json:
    mime_type = MIME_TYPES.get(Path(path).suffix.lower())
    return {"mimeType": mime_type} if mime_type else {}


def _logical_locations(tables: _Tables) -> list[Json]:
    return [
        {
            "name": entry.name,
            "fullyQualifiedName": path,
            "kind": entry.kind,
            **({"parentIndex": tables.object_index[entry.parent]} if entry.parent else {}),
        }
        for path, entry in tables.objects.items()
    ]


def _objects(report: Report) -> dict[str, _Object]:
    """All that places name, and every parent: sorted, so that parents come first."""
    found = {path: entry for place in _places(report) for path, entry in _lineage(place)}
    return dict(sorted(found.items()))


def _lineage(place: Place) -> Iterator[tuple[str, _Object]]:
    """From the pseudo-root down."""
    # The standard wants name and qualified name of a top-level object to be equal. No root
    # prim's are, but the pseudo-root's.
    parent = "/"
    yield parent, _Object(parent, "layer", None)
    for element in re.finditer(r"/?([^/{}]+)|\{[^{}]*\}", place.prim_path):
        path = place.prim_path[: element.end()]
        kind = "prim" if element[1] else "variant"
        yield path, _Object(element[1] or element[0], kind, parent)
        parent = path
    if place.property:
        # Whether it is an attribute or a relationship is not known here.
        yield _qualified_name(place), _Object(place.property, "property", parent)


def _qualified_name(place: Place) -> str:
    return f"{place.prim_path}.{place.property}" if place.property else place.prim_path


def _line_hashes(alerts: Iterable[Alert]) -> dict[tuple[str, int], str]:
    wanted: defaultdict[str, set[int]] = defaultdict(set)
    for first, *_ in alerts:
        if line := _line(first.location):
            wanted[first.location.file].add(line)
    return {
        (file, line): value
        for file, lines in wanted.items()
        for line, value in file_line_hashes(file, lines).items()
    }
