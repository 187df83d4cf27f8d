"""The program in one screen: discover, open, read, run, settle, locate, suppress, report."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import field, replace
from pathlib import Path

from . import __version__
from .context import (
    MOST_STAGES,
    Outline,
    Plan,
    advised,
    not_used,
    planned,
    seen_through,
    siblings,
)
from .discover import Shown, discover
from .discover import Target as File
from .model import Layer
from .records import dataclass
from .registry import Selection, select
from .renderers import ANY, renderer
from .results import Located, Problem, RendererChoice, Report, Verdict
from .rule import Context, Severity
from .run import Crash
from .suppress import Ignore, Key, findings_of

NAMED = 3
"""Prims that a message lists beside its own."""


@dataclass(frozen=True, slots=True)
class Config:
    """What the person asked for."""

    selection: Selection = field(default_factory=select)
    severities: dict[str, Severity] = field(default_factory=dict)
    renderer: str = "auto"
    variants: bool = False
    """Also every variant of the variant sets that reach the render spec."""
    scopes: tuple[str, ...] = ("/Render",)
    ignores: bool = True
    """Whether comments and metadata hide findings."""
    roots: tuple[str, ...] = ()
    """Stages through which the layers that they use are linted: patterns of `glob`, absolute or from
    the current folder."""


@dataclass(frozen=True, slots=True)
class FileResult:
    """What one root layer gave."""

    findings: tuple[Located, ...] = ()
    problems: tuple[Problem, ...] = ()
    renderer: RendererChoice | None = None
    layers: tuple[str, ...] = ()
    """All that took part; none where the root layer could not be linted."""
    chatter: tuple[str, ...] = ()
    ignores: tuple[Ignore, ...] = ()
    """All suppressions that the root layer holds."""
    needed: frozenset[Key] = frozenset()
    """Suppressions, of whatever layer, that silence something here, or may in what was not seen."""
    ran: frozenset[str] | None = None
    """Rules that looked at everything; None if a part of the stage is missing."""
    outline: Outline | None = None
    """None where there was no stage."""


def lint(paths: Iterable[str], config: Config | None = None, cwd: Path | None = None) -> Report:
    """Lint files and folders. Never raises for what is wrong with them: see `Report.problems`."""
    config = config or Config()
    shown = Shown(cwd)
    files, problems = discover(paths, shown)
    plan = planned(files, config.roots, config.scopes, cwd or Path.cwd(), shown)
    results = _lint_all(plan.targets, config, shown)
    results, notes = _in_context(plan, results, config, shown)
    return _report(plan, problems, results, notes, config)


def _lint_all(files: Iterable[File], config: Config, shown: Shown) -> list[FileResult]:
    return [_lint_file(file, config, shown) for file in files]


def _in_context(
    plan: Plan, results: list[FileResult], config: Config, shown: Shown
) -> tuple[list[FileResult], list[str]]:
    """What holds of each layer in the stages that use it; and what is to be said of the roots."""
    results = [_unless_idle(*one, shown) for one in zip(plan.targets, results, strict=True)]
    notes = [*plan.notes, *not_used(plan, [r.layers for r in results], shown)]
    seen = seen_through(plan.targets, [r.outline or Outline() for r in results], plan.roots)
    if not plan.roots:
        alone = [i for i, r in enumerate(results) if not seen[i] and _may_be_part(r)]
        for i, advised in zip(alone, _advised(plan, results, alone, config, shown), strict=True):
            results[i] = advised
    return [_as_part(r) if seen[i] else r for i, r in enumerate(results)], notes


def _unless_idle(file: File, result: FileResult, shown: Shown) -> FileResult:
    """A root that uses none of the layers on whose behalf it was linted has nothing to say."""
    if not file.about or result.outline is None:
        return result
    files = {str(shown.root / layer) for layer in result.layers}
    files.update(f.location.file for f in result.findings)  # one that does not parse takes no part
    about = {*file.about}
    uses = about & files or any(os.path.realpath(one) in about for one in files)
    return result if uses else FileResult()


def _as_part(result: FileResult) -> FileResult:
    """Of a layer that is seen through stages, only what it says about itself."""
    own = tuple(f for f in result.findings if f.rule.on is Layer)
    return replace(result, findings=own, renderer=None)


def _may_be_part(result: FileResult) -> bool:
    """Whether something seems to be missing."""
    told = (f for f in result.findings if f.verdict is Verdict.REPORTED)
    return any(f.target is not None or f.severity is not Severity.NOTE for f in told)


def _advised(
    plan: Plan, results: list[FileResult], alone: list[int], config: Config, shown: Shown
) -> Iterator[FileResult]:
    """Those of layers that a stage beside or above them sublayers, with word of it."""
    beside = siblings([plan.given[i] for i in alone], config.scopes, shown)
    stages = {stage.shown: stage for found in beside for stage in found}
    opened = list(stages.values())[:MOST_STAGES]
    linted = zip(opened, _lint_all(opened, config, shown), strict=True)
    # Where a part of the stage is missing, nothing is known to be right.
    found = {stage.shown: r.findings for stage, r in linted if r.ran is not None}
    for i, near in zip(alone, beside, strict=True):
        known = {one.shown: found[one.shown] for one in near if one.shown in found}
        yield replace(results[i], findings=advised(results[i].findings, known))


def _lint_file(file: File, config: Config, shown: Shown) -> FileResult:
    # USD is imported only when there is a file to open.
    from .lint_file import lint_file

    return lint_file(file, config, shown)


def _report(
    plan: Plan,
    problems: list[Problem],
    results: list[FileResult],
    notes: list[str],
    config: Config,
) -> Report:
    problems = [*problems, *(p for r in results for p in r.problems)]
    ran = {} if problems else _ran(plan, results)
    files = [file for file, r in zip(plan.targets, results, strict=True) if r.layers]
    about, crashes = findings_of(
        {f.shown: r.ignores for f, r in zip(plan.targets, results, strict=True) if r.ignores},
        frozenset[Key]().union(*(r.needed for r in results)),
        ran,
        config.selection.run,
        Context(renderer(ANY)),
        config.severities,
    )
    problems = [*problems, *(crashed_rule(file, crash) for file, crash in crashes)]
    found = [*(f for r in results for f in r.findings), *about]
    if not config.ignores:
        found = [replace(f, verdict=Verdict.REPORTED) for f in found]
    merged = _merge(found)
    return Report(
        __version__,
        config.selection.run,
        tuple(file.shown for file in files if not file.about),
        tuple(f for f in merged if f.verdict is Verdict.REPORTED),
        tuple(sorted(dict.fromkeys(problems), key=lambda p: (p.path, p.kind, p.message))),
        tuple(r.renderer for r in results if r.renderer),
        config.selection.skipped,
        tuple(sorted({layer for r in results for layer in r.layers})),
        tuple(dict.fromkeys(c for r in results for c in r.chatter)),
        tuple(f for f in merged if f.verdict is not Verdict.REPORTED),
        ran,
        tuple(file.shown for file in files if file.about),
        tuple(notes),
    )


def _ran(plan: Plan, results: list[FileResult]) -> dict[str, frozenset[str]]:
    ran: dict[str, set[str]] = {f.shown: set() for f in plan.given}
    broken: set[str] = set()
    for file, result in zip(plan.targets, results, strict=True):
        for layer in {file.shown, *result.layers}.intersection(ran):
            ran[layer].update(result.ran or ())
            if result.ran is None:
                broken.add(layer)
    return {f: frozenset(rules) for f, rules in ran.items() if f not in broken}


def crashed_rule(root: str, crash: Crash) -> Problem:
    said = f"the rule {crash.rule.id} failed on <{crash.subject}>: {crash.error}"
    message = f"{said}. This is a bug of usdrender-lint"
    return Problem("crashed-rule", root, message, crash.rule.id)


def _merge(findings: Iterable[Located]) -> tuple[Located, ...]:
    """Equal findings of several stages are one that says where it holds, and so are those that one
    opinion gives to several prims."""
    merged: dict[tuple[object, ...], Located] = {}
    for finding in findings:
        known = merged.get(finding.identity)
        if known is not None:
            finding = replace(known, roots=tuple(sorted({*known.roots, *finding.roots})))
        merged[finding.identity] = finding
    return tuple(_numbered(sorted(_shared(merged.values()), key=lambda f: f.sort_key)))


def _shared(findings: Iterable[Located]) -> Iterator[Located]:
    sharing: dict[tuple[object, ...], list[Located]] = {}
    for finding in findings:
        sharing.setdefault(finding.shared_with, []).append(finding)
    for shared in sharing.values():
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
        seen[finding.known_by] += 1
        yield replace(finding, nth=seen[finding.known_by])
