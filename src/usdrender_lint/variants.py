"""In which variants does a finding hold?"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from .records import dataclass
from .results import Located


@dataclass(frozen=True, slots=True)
class Outcome:
    """What was found with one variant of one set selected, the other sets as they are composed."""

    variant_set: str
    """The prim and its set, as `/Render{quality}`."""
    composed: str
    """The variant of that set which the stage itself selects; empty for none."""
    choices: tuple[str, ...]
    selected: str
    findings: tuple[Located, ...]


def merge_outcomes(
    composed: tuple[Located, ...], outcomes: Iterable[Outcome]
) -> tuple[Located, ...]:
    """Every finding once: without a word on variants if it holds in all that were linted, else with
    those of each set in which it holds."""
    listed = list(outcomes)
    holding = [{f.identity for f in outcome.findings} for outcome in listed]
    everywhere = {f.identity for f in composed}
    findings = {f.identity: f for f in composed}
    for outcome in listed:
        for finding in outcome.findings:
            findings.setdefault(finding.identity, finding)
    merged = []
    for identity, finding in findings.items():
        in_composed = identity in everywhere
        if in_composed and all(identity in found for found in holding):
            merged.append(finding)
            continue
        merged.append(replace(finding, variants=_where(identity, in_composed, listed, holding)))
    return tuple(merged)


def _where(
    identity: tuple[object, ...],
    in_composed: bool,
    outcomes: list[Outcome],
    holding: list[set[tuple[object, ...]]],
) -> tuple[tuple[str, tuple[str, ...]], ...]:
    holds: dict[str, set[str]] = {}
    every: dict[str, tuple[str, ...]] = {}
    for outcome, found in zip(outcomes, holding, strict=True):
        every[outcome.variant_set] = outcome.choices
        selected = holds.setdefault(outcome.variant_set, set())
        if in_composed:
            selected.add(outcome.composed)
        if identity in found:
            selected.add(outcome.selected)
    return tuple(
        (name, tuple(sorted(selected)))
        for name, selected in sorted(holds.items())
        if selected and not selected.issuperset(every[name])
    )
