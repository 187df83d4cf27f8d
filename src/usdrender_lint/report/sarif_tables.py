"""What do the results of a SARIF log refer to by index: files, members of packages, USD objects?"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from urllib.parse import quote

from ..packages import extent
from ..records import dataclass
from ..results import Located, Location, Place, Report
from .fingerprint import file_line_hashes

Json = dict[str, object]
Alert = Sequence[Located]
"""Findings that scanners take for one, because rule, file and line are the same; the worst first."""

ROOT = "%SRCROOT%"
ABOVE = "%ABOVE{}%"
"""The folder so many levels above the root. For files outside of the repository: the standard wants
`..` resolved, and GitHub refuses a whole upload for one result with an absolute address."""
MIME_TYPES = {".usda": "model/vnd.usda", ".usdz": "model/vnd.usdz+zip"}
"""The two that are registered."""
_URI_SAFE = "/!$&'()*+,;=@~"
"""What a relative reference may hold as it is. No colon: what stands before one is a scheme."""


def line_of(location: Location) -> int | None:
    """The line of the file. A member of a package has lines, but the file is the package."""
    return location.span.line if location.span and not location.member else None


@dataclass(frozen=True, slots=True)
class _Object:
    """A prim, a property, a variant or the layer itself."""

    name: str
    kind: str
    parent: str | None


@dataclass(frozen=True, slots=True)
class Tables:
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


def tables_of(report: Report, alerts: Iterable[Alert]) -> Tables:
    addresses = _addresses(report)
    objects = _objects(report)
    return Tables(
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
        yield (at := as_place(finding))
        yield from (replace(at, prim_path=prim) for prim in finding.also)
        yield from finding.related


def as_place(finding: Located) -> Place:
    return Place(
        finding.message,
        finding.location,
        finding.prim_path,
        finding.property,
        finding.property_kind,
    )


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


def bases(report: Report, tables: Tables) -> Iterator[tuple[str, Json]]:
    """Without a `uri`, which would tell names of users and differ between machines."""
    yield ROOT, {"description": {"text": "The root of the repository that was linted."}}
    told = [*tables.addresses.values(), *(_address(p.path) for p in report.problems)]
    for base in sorted({str(address.get("uriBaseId", ROOT)) for address in told} - {ROOT}):
        levels = base.strip("%").removeprefix("ABOVE")
        times = "1 level" if levels == "1" else f"{levels} levels"
        yield base, {"description": {"text": f"The folder {times} above that root."}}


def artifacts(report: Report, tables: Tables) -> Iterator[Json]:
    with_result = {finding.location.path for finding in report.findings}
    for path, address in tables.addresses.items():
        # resultFile: a file with a result that the tool was not told to look at.
        role = (path in report.files and "analysisTarget") or (path in with_result and "resultFile")
        roles = {"roles": [role]} if role else {}
        yield {"location": address, **_mime_type(path), **roles}


def members(report: Report, tables: Tables) -> Iterator[Json]:
    """Layers in packages, as artifacts within artifacts.

    Named by their bytes: Microsoft's validator refuses the URI that the standard wants.
    """
    members = {
        (place.location.path, member, place.location.file)
        for place in _places(report)
        if (member := place.location.member)
    }
    for path, member, file in sorted(members):
        if found := extent(file, member):
            yield {
                "parentIndex": tables.artifact_index[path],
                "offset": found.start,
                "length": len(found),
                "description": {"text": f"The layer '{member}' in the package."},
                **_mime_type(member),
            }


def _mime_type(path: str) -> Json:
    mime_type = MIME_TYPES.get(Path(path).suffix.lower())
    return {"mimeType": mime_type} if mime_type else {}


def logical_locations(tables: Tables) -> list[Json]:
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
        yield (
            qualified_name(place),
            _Object(place.property, place.property_kind or "property", parent),
        )


def qualified_name(place: Place) -> str:
    return f"{place.prim_path}.{place.property}" if place.property else place.prim_path


def _line_hashes(alerts: Iterable[Alert]) -> dict[tuple[str, int], str]:
    wanted: defaultdict[str, set[int]] = defaultdict(set)
    for first, *_ in alerts:
        if line := line_of(first.location):
            wanted[first.location.file].add(line)
    return {
        (file, line): value
        for file, lines in wanted.items()
        for line, value in file_line_hashes(file, lines).items()
    }
