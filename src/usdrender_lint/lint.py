"""The program in one screen: discover, open, read, run, settle, locate, suppress, report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import field, replace
from pathlib import Path

from . import __version__
from .discover import Shown, discover
from .discover import Target as File
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


def lint(paths: Iterable[str], config: Config | None = None, cwd: Path | None = None) -> Report:
    """Lint files and folders. Never raises for what is wrong with them: see `Report.problems`."""
    config = config or Config()
    shown = Shown(cwd)
    files, problems = discover(paths, shown)
    results = [_lint_file(file, config, shown) for file in files]
    return _report(files, [*problems, *(p for r in results for p in r.problems)], results, config)


def _lint_file(file: File, config: Config, shown: Shown) -> FileResult:
    # USD is imported only when there is a file to open.
    from .lint_file import lint_file

    return lint_file(file, config, shown)


def _report(
    files: list[File], problems: list[Problem], results: list[FileResult], config: Config
) -> Report:
    ran = {} if problems else _ran(files, results)
    about, crashes = findings_of(
        {f.shown: r.ignores for f, r in zip(files, results, strict=True) if r.ignores},
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
        tuple(file.shown for file, r in zip(files, results, strict=True) if r.layers),
        tuple(f for f in merged if f.verdict is Verdict.REPORTED),
        tuple(sorted(dict.fromkeys(problems), key=lambda p: (p.path, p.kind, p.message))),
        tuple(r.renderer for r in results if r.renderer),
        config.selection.skipped,
        tuple(sorted({layer for r in results for layer in r.layers})),
        tuple(dict.fromkeys(c for r in results for c in r.chatter)),
        tuple(f for f in merged if f.verdict is not Verdict.REPORTED),
        ran,
    )


def _ran(files: list[File], results: list[FileResult]) -> dict[str, frozenset[str]]:
    ran: dict[str, set[str]] = {f.shown: set() for f in files}
    broken: set[str] = set()
    for file, result in zip(files, results, strict=True):
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
