"""Which findings are one and the same, told for several stages or prims?"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace

from .results import Located

NAMED = 3
"""Prims that a message lists beside its own."""


def merged(findings: Iterable[Located]) -> tuple[Located, ...]:
    """Equal findings of several stages are one that says where it holds, and so are those that one
    opinion gives to several prims."""
    known: dict[tuple[object, ...], Located] = {}
    for finding in findings:
        identity = finding.identity
        if same := known.get(identity):
            finding = replace(same, roots=tuple(sorted({*same.roots, *finding.roots})))
        known[identity] = finding
    return tuple(_numbered(sorted(_shared(known.values()), key=lambda f: f.sort_key)))


def _shared(findings: Iterable[Located]) -> Iterator[Located]:
    sharing: dict[tuple[object, ...], list[Located]] = {}
    for finding in findings:
        sharing.setdefault(finding.shared_with, []).append(finding)
    for shared in sharing.values():
        if len(shared) == 1 and len(shared[0].roots) == 1:  # most are
            yield shared[0]
            continue
        first, *others = sorted(shared, key=lambda f: f.sort_key)
        also = tuple(sorted({f.prim_path for f in others} - {first.prim_path}))
        roots = tuple(sorted({root for f in shared for root in f.roots}))
        yield replace(first, message=f"{first.message}{_also(also)}", also=also, roots=roots)


def _also(prims: tuple[str, ...]) -> str:
    if not prims:
        return ""
    named = ", ".join(f"<{path}>" for path in prims[:NAMED])
    return f" (also for {named}{f' and {len(prims) - NAMED} more' if len(prims) > NAMED else ''})"


def _numbered(findings: Iterable[Located]) -> Iterator[Located]:
    """A rule may say two things of one property: each is known by a fingerprint of its own."""
    seen: Counter[tuple[str, ...]] = Counter()
    for finding in findings:
        known_by = finding.known_by
        seen[known_by] += 1
        yield finding if seen[known_by] == finding.nth else replace(finding, nth=seen[known_by])
