"""Which baseline holds for which of the linted files, and what becomes of it?"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from .baseline import Baseline, load
from .records import dataclass
from .results import Located, Report


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


def held(
    file: Path, start: str, roots: Iterable[str], shown_from: str, *, may_be_missing: bool
) -> Held:
    """`BaselineError` for a file that cannot be used."""
    missing = may_be_missing and not file.exists()
    known = Baseline({}) if missing else load(file).moved(start, shown_from)
    return Held(file, start, frozenset(roots), known)


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
