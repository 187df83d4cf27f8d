"""From paths to a report: discover, lint each file, see it in its stages, merge what is found."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from . import __version__
from .config.find import NOTHING, Configurations
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
from .job import Asked, Config, FileResult, Lint, crashed_rule
from .merge import merged
from .model import Layer
from .records import dataclass
from .renderers import ANY, renderer
from .results import Located, Problem, Report, Verdict
from .rule import Context, Severity
from .run import Crash
from .suppress import Key, findings_of


def lint_here(asked: Iterable[Asked], shown: Shown) -> list[FileResult]:
    """In this process: what brings USD down brings it down, too."""
    return [_lint_file(file, config, shown) for file, config in asked]


def lint(paths: Iterable[str], config: Config | None = None, cwd: Path | None = None) -> Report:
    """Lint files and folders. Never raises for what is wrong with them: see `Report.problems`."""
    config = config or Config()
    shown = Shown(cwd)
    found = discover(paths, shown, Configurations(NOTHING))
    asked = [(file, config) for file in found.files]
    return report_on(asked, found.problems, shown, config, cwd=cwd)


def report_on(
    asked: Sequence[Asked],
    problems: Iterable[Problem],
    shown: Shown,
    otherwise: Config,
    lint_files: Lint = lint_here,
    *,
    cwd: Path | None = None,
    part: str = "",
) -> Report:
    """Lint each file as it is asked for; `otherwise` stands for all where there is none.

    `part` names that of a run that several share: what is not found here may be found there.
    """
    groups = _groups(asked, otherwise, cwd or Path.cwd(), shown)
    linted = [(file, group.config) for group in groups for file in group.plan.targets]
    results = lint_files(linted, shown)
    results, notes = _in_context(groups, results, shown, lint_files)
    notes += _speechless(linted, results)
    problems = [*problems, *(p for r in results for p in r.problems)]
    ran = {} if part or problems else _ran(linted, results)
    return replace(_report(groups, problems, results, notes, ran), part=part)


def _speechless(linted: Sequence[Asked], results: list[FileResult]) -> Iterator[str]:
    """Word of it if there is no finding because nobody looked for one."""
    looked = [
        config.selection.told - result.silent
        for (_, config), result in zip(linted, results, strict=True)
        if result.silent is not None
    ]
    if looked and not any(looked):
        yield "no rule that is selected is for the renderer that a stage was judged by: see --renderer"


@dataclass(frozen=True, slots=True)
class _Group:
    """Files for which the same is asked."""

    config: Config
    plan: Plan


def _groups(asked: Sequence[Asked], otherwise: Config, cwd: Path, shown: Shown) -> list[_Group]:
    files: dict[int, list[File]] = {}
    configs = {id(config): config for _, config in asked} or {id(otherwise): otherwise}
    for file, config in asked:
        files.setdefault(id(config), []).append(file)
    return [
        _Group(c, planned(files.get(one, []), c.roots, c.scopes, cwd, shown))
        for one, c in configs.items()
    ]


def _in_context(
    groups: list[_Group], results: list[FileResult], shown: Shown, lint_files: Lint
) -> tuple[list[FileResult], list[str]]:
    """What holds of each layer in the stages that use it; and what is to be said of the roots."""
    targets = [file for group in groups for file in group.plan.targets]
    results = [_unless_idle(*one, shown) for one in zip(targets, results, strict=True)]
    roots = frozenset[str]().union(*(group.plan.roots for group in groups))
    seen = seen_through(targets, [r.outline or Outline() for r in results], roots)
    notes: list[str] = []
    start = 0
    for group in groups:
        plan, end = group.plan, start + len(group.plan.targets)
        notes += [*plan.notes, *not_used(plan, [r.layers for r in results[start:end]], shown)]
        if not plan.roots:
            alone = [i for i in range(start, end) if not seen[i] and _may_be_part(results[i])]
            own = [(targets[i], results[i]) for i in alone]
            for i, told in zip(alone, _advised(own, group.config, shown, lint_files), strict=True):
                results[i] = told
        start = end
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
    alone: list[tuple[File, FileResult]], config: Config, shown: Shown, lint_files: Lint
) -> Iterator[FileResult]:
    """Those of layers that a stage beside or above them sublayers, with word of it."""
    beside = siblings([file for file, _ in alone], config.scopes, shown)
    stages = {stage.shown: stage for found in beside for stage in found}
    opened = list(stages.values())[:MOST_STAGES]
    linted = zip(opened, lint_files([(stage, config) for stage in opened], shown), strict=True)
    # Where a part of the stage is missing, nothing is known to be right.
    found = {stage.shown: r.findings for stage, r in linted if r.silent is not None}
    for (_, result), near in zip(alone, beside, strict=True):
        known = {one.shown: found[one.shown] for one in near if one.shown in found}
        yield replace(result, findings=advised(result.findings, known))


def _lint_file(file: File, config: Config, shown: Shown) -> FileResult:
    # USD is imported only when there is a file to open.
    from .lint_file import lint_file

    return lint_file(file, config, shown)


def _report(
    groups: list[_Group],
    problems: list[Problem],
    results: list[FileResult],
    notes: list[str],
    ran: dict[str, frozenset[str]],
) -> Report:
    linted = [(file, group.config) for group in groups for file in group.plan.targets]
    files = [file for (file, _), r in zip(linted, results, strict=True) if r.layers]
    configs = [group.config for group in groups]
    about: list[Located] = []
    for config in configs:
        of_these, crashes = _about_suppressions(config, linted, results, ran)
        about += of_these
        problems = [*problems, *(crashed_rule(file, crash) for file, crash in crashes)]
    found = [*(f for r in results for f in r.findings), *about]
    if not all(config.ignores for config in configs):
        found = [replace(f, verdict=Verdict.REPORTED) for f in found]
    told = merged(found)
    rules = {rule.id: rule for config in configs for rule in config.selection.run}
    return Report(
        __version__,
        tuple(rules[name] for name in sorted(rules)),
        tuple(sorted(file.shown for file in files if not file.about)),
        tuple(f for f in told if f.verdict is Verdict.REPORTED),
        tuple(sorted(dict.fromkeys(problems), key=lambda p: (p.path, p.kind, p.message))),
        tuple(r.renderer for r in results if r.renderer),
        tuple(sorted({s for c in configs for s in c.selection.skipped}, key=lambda s: s.rule)),
        tuple(sorted({layer for r in results for layer in r.layers})),
        tuple(dict.fromkeys(c for r in results for c in r.chatter)),
        tuple(f for f in told if f.verdict is not Verdict.REPORTED),
        ran,
        tuple(sorted({file.shown for file in files if file.about})),
        tuple(notes),
        {file.shown: config.fail_on for file, config in linted},
        {file.shown: group.plan.given[0].shown for group in groups for file in group.plan.added},
    )


def _about_suppressions(
    config: Config,
    linted: Sequence[Asked],
    results: list[FileResult],
    ran: dict[str, frozenset[str]],
) -> tuple[list[Located], list[tuple[str, Crash]]]:
    """What is found of the suppressions in the files that are judged by one configuration."""
    ignores = {
        file.shown: result.ignores
        for (file, its), result in zip(linted, results, strict=True)
        if result.ignores and its is config
    }
    if not ignores:
        return [], []
    found, crashes = findings_of(
        ignores,
        frozenset[Key]().union(*(r.needed for r in results)),
        ran,
        config.selection.run,
        Context(renderer(ANY)),
        config.severities,
    )
    return [f for f in found if not config.leaves_out(f.rule.id, f.location.file)], crashes


def _ran(linted: Sequence[Asked], results: list[FileResult]) -> dict[str, frozenset[str]]:
    ran: dict[str, frozenset[str]] = {f.shown: frozenset() for f, _ in linted if not f.about}
    broken: set[str] = set()
    speaking: dict[tuple[int, frozenset[str]], frozenset[str]] = {}
    for (file, config), result in zip(linted, results, strict=True):
        about = {file.shown, *result.layers}.intersection(ran)
        if result.silent is None:
            broken |= about
            continue
        key = id(config), result.silent
        if key not in speaking:
            speaking[key] = config.selection.told - result.silent
        for layer in about:
            ran[layer] = ran[layer] | speaking[key] if ran[layer] else speaking[key]
    particular = {id(config): config for _, config in linted if config.per_file_ignores}
    for file, _ in linted:
        for config in particular.values() if not file.about else ():
            at = str(file.file)
            ran[file.shown] -= {r for r in ran[file.shown] if config.leaves_out(r, at)}
    return {f: rules for f, rules in ran.items() if f not in broken}
