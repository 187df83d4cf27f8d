"""Which baseline holds for which of the linted files, and what becomes of it?"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from .baseline import Baseline, BaselineError, load
from .console import tell
from .output import OutputError, write_file
from .plan import KnownIn, Plan
from .records import dataclass
from .results import Located, Report
from .wanted import WantedError


@dataclass(frozen=True, slots=True)
class Held:
    """A baseline, and the files that it holds for."""

    file: Path
    start: str
    """The folder from which it tells of layers."""
    roots: frozenset[str]
    """Linted files, as shown."""
    known: Baseline
    """Its layers as this run shows them."""

    def owns(self, finding: Located, report: Report) -> bool:
        first = finding.roots[0]
        return report.behalf.get(first, first) in self.roots

    def part(self, report: Report) -> Report:
        """What it has a say in. A finding of several stages belongs to the first of them."""
        return replace(
            report,
            findings=tuple(f for f in report.findings if self.owns(f, report)),
            suppressed=(),
            ran={file: rules for file, rules in report.ran.items() if file in self.roots},
        )

    def stale(self, report: Report) -> int:
        """How many findings are gone."""
        return self.known.stale(self.part(report))

    def updated(self, report: Report) -> Held:
        return replace(self, known=self.known.updated(self.part(report)))

    def text(self, shown_from: str) -> str:
        return self.known.moved(shown_from, self.start).text()


def known_to(plans: Plan, *, may_be_missing: bool) -> list[Held]:
    """`WantedError` for a file that cannot be used."""
    try:
        return [_held(one, str(plans.shown.root), may_be_missing) for one in plans.baselines]
    except BaselineError as error:
        raise WantedError(str(error)) from None


def _held(one: KnownIn, shown_from: str, may_be_missing: bool) -> Held:
    missing = may_be_missing and not one.file.exists()
    known = Baseline({}) if missing else load(one.file).moved(one.start, shown_from)
    return Held(one.file, one.start, frozenset(one.roots), known)


def hide(report: Report, baselines: Iterable[Held]) -> Report:
    """What a baseline knows is told no more."""
    for one in baselines:
        part = one.known.hide(one.part(report))
        others = (f for f in report.findings if not one.owns(f, report))
        report = replace(
            report,
            findings=tuple(sorted((*others, *part.findings), key=lambda f: f.sort_key)),
            suppressed=tuple(
                sorted((*report.suppressed, *part.suppressed), key=lambda f: f.sort_key)
            ),
        )
    return report


def tell_stale(known: Iterable[Held], report: Report) -> None:
    for one in known:
        if gone := one.stale(report):
            which = "1 finding that is" if gone == 1 else f"{gone} findings that are"
            tell(f"note: {one.file} holds {which} gone: see --update-baseline")


def update(
    known: list[Held], report: Report, shown_from: str, *, quiet: bool
) -> tuple[list[Held], bool]:
    """The new baselines, if they could be written. What was not looked at is neither new nor gone."""
    if not report.complete:
        for one in known:
            tell(f"error: {one.file} is not updated: the run is incomplete")
        return known, False
    updated = []
    for old in known:
        new = old.updated(report)
        try:
            write_file(old.file, new.text(shown_from))
        except OutputError as error:
            tell(f"error: {error}")
            return known, False
        updated.append(new)
        if not quiet:
            added, gone = new.known.beyond(old.known), old.known.beyond(new.known)
            all_told = f"{added} added, {gone} taken out, {new.known.count} in all"
            tell(f"note: {old.file} is written: {all_told}")
    return updated, True
