"""When is one cause told often enough?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from ..rule import Finding

HANDFUL = 4

LACKING = (
    "default-resolution",
    "empty-product-name",
    "empty-source-name",
    "input-pass-without-output",
    "missing-camera",
    "missing-render-source",
    "product-without-vars",
    "settings-without-products",
)
"""Rules that tell that a prim does not say something. Where it does, but in a way that nobody reads,
that is the cause, and told instead."""


def handful(findings: Iterable[Finding], what: str) -> Iterator[Finding]:
    """A few findings of one cause, which is what their label says, as they are; of more only the
    first, which names some others."""
    causes: dict[str, list[Finding]] = {}
    for finding in findings:
        causes.setdefault(finding.label, []).append(finding)
    for found in causes.values():
        if len(found) <= HANDFUL:
            yield from found
        else:
            yield _first(found, what)


def _first(found: list[Finding], what: str) -> Finding:
    first, others = found[0], found[1:]
    return replace(
        first,
        message=f"{first.message} (so it is with {len(others)} other {what})",
        related=(*first.related, *((f.at, "the same here") for f in others[:HANDFUL])),
    )
