"""What does a run give? Findings with their places, what could not be done, and nothing to compute.

Every reporter, the exit code and the language of the summary are functions of a `Report`.
"""

from __future__ import annotations

import builtins
from dataclasses import field
from enum import StrEnum

from .records import dataclass
from .rule import AnyRule, Severity


@dataclass(frozen=True, slots=True)
class Span:
    """A stretch of one line of a text layer. Columns count code points, from 1; the end is exclusive."""

    line: int
    column: int
    end_column: int


@dataclass(frozen=True, slots=True)
class Location:
    """Where the opinion stands."""

    file: str
    """File that holds the layer, absolute; for a member of a package the `.usdz`."""
    path: str
    """The same as shown: relative to the repository's root, `/` as separator."""
    member: str | None = None
    """Layer inside the package."""
    span: Span | None = None
    """None: a binary layer, or one without a file."""
    source: str | None = None
    """The text of that line, without its line break."""


class Verdict(StrEnum):
    """Whether a finding is reported, and if not, by whose word."""

    REPORTED = "reported"
    BY_COMMENT = "by comment"
    BY_METADATA = "by metadata"
    BY_BASELINE = "by baseline"


@dataclass(frozen=True, slots=True)
class Place:
    """An object that belongs to a finding, with what it has to do with it."""

    message: str
    location: Location
    prim_path: str
    property: str | None
    property_kind: str = ""
    """`attribute` or `relationship`; empty where there is no property, or no stage to ask."""


@dataclass(frozen=True, slots=True)
class Opinion:
    """What a finding is about as its layer has it: alike for all prims that share the opinion."""

    path: str
    """Of the prim, in the namespace of the layer."""
    target: str | None
    message: str


@dataclass(frozen=True, slots=True)
class Step:
    """One layer on the way from the root layer to that of a finding."""

    arc: str
    """What brings it in: sublayer, reference, payload ..."""
    path: str
    """As shown; of a member of a package with its name in brackets."""


@dataclass(frozen=True, slots=True)
class Located:
    """A finding that knows its rule, its severity and its place."""

    rule: AnyRule
    severity: Severity
    message: str
    label: str
    help: str
    location: Location
    prim_path: str
    """"/" for what a layer says about itself."""
    property: str | None
    target: str | None
    related: tuple[Place, ...] = ()
    roots: tuple[str, ...] = ()
    """The stages in which it holds, as shown paths."""
    variants: tuple[tuple[str, tuple[str, ...]], ...] = ()
    """`/Render{quality}` and the variants of that set in which it holds; empty: in all that were linted."""
    verdict: Verdict = Verdict.REPORTED
    opinion: Opinion | None = None
    """Where a reference, a class or another arc brings it in under another path."""
    also: tuple[str, ...] = ()
    """Further prims that share the opinion, and so the fault, sorted."""
    nth: int = 1
    """Of several findings that nothing but their words tells apart."""
    property_kind: str = ""
    """See `Place`."""
    chain: tuple[Step, ...] = ()
    """From the first of its roots to the layer that holds the opinion; empty where that is the root."""

    @builtins.property
    def sort_key(self) -> tuple[object, ...]:
        span = self.location.span
        return (
            self.location.path,
            self.location.member or "",
            span.line if span else 0,
            span.column if span else 0,
            self.rule.id,
            self.prim_path,
            self.property or "",
            self.target or "",
            self.message,
        )

    @builtins.property
    def identity(self) -> tuple[object, ...]:
        """Equal for the same finding met through several stages, if it fares alike in them."""
        return (*self.sort_key, self.severity, self.verdict)

    @builtins.property
    def layer(self) -> str:
        """The layer as shown; a member of a package as USD writes it."""
        at = self.location
        return f"{at.path}[{at.member}]" if at.member else at.path

    @builtins.property
    def written(self) -> Opinion:
        """What is wrong, in the namespace of its layer: it does not change with who uses it."""
        return self.opinion or Opinion(self.prim_path, self.target, self.message)

    @builtins.property
    def shared_with(self) -> tuple[object, ...]:
        """Equal for what one opinion does to several prims."""
        return (
            self.rule.id,
            self.location,
            self.written,
            self.property,
            self.severity,
            self.verdict,
            self.variants,
        )

    @builtins.property
    def known_by(self) -> tuple[str, str, str, str, str]:
        """Layer, prim, property, target and rule: what stays while lines and words change."""
        at = self.written
        return self.layer, at.path, self.property or "", at.target or "", self.rule.id

    @builtins.property
    def fingerprint(self) -> str:
        """16 hex digits that survive edits elsewhere in the file: no line, no time."""
        import hashlib

        layer, prim, name, target, rule = self.known_by
        parts = (rule, layer, prim, name, target, *([str(self.nth)] if self.nth > 1 else []))
        return hashlib.sha256("\0".join(parts).encode("utf-8", "surrogatepass")).hexdigest()[:16]


@dataclass(frozen=True, slots=True)
class Problem:
    """Something that kept the run from being complete. Never a finding, never hidden."""

    kind: str
    """unreadable-file, missing-path, no-usd-files, crashed-rule, crashed-usd ..."""
    path: str
    """As shown."""
    message: str
    rule: str | None = None


@dataclass(frozen=True, slots=True)
class RendererChoice:
    """Which renderer a stage was judged by, and why."""

    root: str
    name: str
    reason: str


@dataclass(frozen=True, slots=True)
class Skipped:
    """A rule that was asked for and cannot run, and what would make it."""

    rule: str
    reason: str


@dataclass(frozen=True, slots=True)
class Report:
    """One whole run."""

    version: str
    """Of this program."""
    rules: tuple[AnyRule, ...]
    """All rules that ran, by id."""
    files: tuple[str, ...]
    """Root layers that were linted, as shown, sorted."""
    findings: tuple[Located, ...]
    """By path, line, column, rule; without the suppressed ones."""
    problems: tuple[Problem, ...] = ()
    renderers: tuple[RendererChoice, ...] = ()
    skipped: tuple[Skipped, ...] = ()
    """Rules that were asked for and did not run."""
    layers: tuple[str, ...] = ()
    """Files of all layers that took part, as shown, sorted; packages once."""
    chatter: tuple[str, ...] = ()
    """What USD said on the way that became no finding; for `-v`."""
    suppressed: tuple[Located, ...] = ()
    """What a comment, metadata or the baseline hides, in the same order."""
    ran: dict[str, frozenset[str]] = field(default_factory=dict)
    """For each linted file, as shown, the rules whose silence tells that there is nothing to find:
    those that ran, if the run was complete and every stage that uses the file was whole."""
    through: tuple[str, ...] = ()
    """Roots that were linted on behalf of layers, as shown, sorted: only what concerns these is told."""
    notes: tuple[str, ...] = ()
    """What is to be known of the run beside what was found."""
    gates: dict[str, str] = field(default_factory=dict)
    """For each linted file, as shown, the least severity that fails the run, or `never`."""
    behalf: dict[str, str] = field(default_factory=dict)
    """For each of `through` one of the files as whose configuration asks it was linted."""
    part: str = ""
    """Which part of a run that several share, as in `shard-1-of-4`; empty for the whole."""
    counts: dict[Severity, int] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self.counts.update((s, sum(f.severity is s for f in self.findings)) for s in Severity)

    @builtins.property
    def complete(self) -> bool:
        return not self.problems

    def gate(self, root: str) -> Severity | None:
        """The least severity at which a finding in that stage fails the run; None: none does."""
        level = self.gates.get(root, Severity.WARNING.value)
        return None if level == "never" else Severity(level)

    def fails(self, finding: Located) -> bool:
        """Whether a finding fails the run in any stage in which it holds."""
        gates = (self.gate(root) for root in finding.roots or (finding.location.path,))
        return any(gate and finding.severity.rank <= gate.rank for gate in gates)

    @builtins.property
    def in_baseline(self) -> int:
        """How many findings the baseline hides."""
        return sum(f.verdict is Verdict.BY_BASELINE for f in self.suppressed)

    @builtins.property
    def ignored(self) -> int:
        """How many findings the layers themselves hide."""
        return len(self.suppressed) - self.in_baseline
