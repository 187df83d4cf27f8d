"""What is wrong with one root layer? The part of a run that touches USD."""

from __future__ import annotations

import sys
from _thread import allocate_lock
from collections.abc import Iterable, Iterator
from contextlib import redirect_stderr
from dataclasses import replace
from io import StringIO

from pxr import Sdf, Tf, Usd

from .concerns import Concerns
from .context import Outline
from .crate import forget_large
from .diagnostics import Diagnostics, sentences
from .discover import Shown
from .discover import Target as File
from .handed import handed_over
from .ignores import Ignores
from .job import Config, FileResult, crashed_rule
from .lazily import lazily
from .locate import Locator, severity_of
from .model import Layer, RenderScope, Site
from .opening import open_layer
from .packages import split_package
from .read import read
from .read.expressions import ill_formed_expressions
from .read.scene import read_scene
from .read.specs import look_through
from .read.text import Texts
from .read.undecodable import loaded_layers, make_decodable
from .read.variants import VariantSet, selecting, variant_sets
from .records import dataclass
from .renderers import ANY, choose, renderer
from .results import Located, Problem, RendererChoice
from .rule import Context, Renderer, Severity
from .run import Crash, Subject, Told, run, subjects_of
from .settle import settle, unique
from .stage import Opened, open_stage
from .sublayers import sublayers_of
from .torn import torn_among
from .unopened import DamagedError, ParseProblem, Unreadable
from .variants import Outcome, merge_outcomes

OLDEST = (25, 11)
"""Of usd-core: older ones lack what is asked of them here."""
if Usd.GetVersion()[1:] < OLDEST:
    oldest, installed = ("{}.{:02}".format(*v) for v in (OLDEST, Usd.GetVersion()[1:]))
    raise ImportError(f"it is {installed}, and {oldest} is the oldest that will do", name="pxr")

_NO_VALUE = "a value in it cannot be read"

MOST_VARIANTS = 64
"""Selections that `--variants` lints of one stage, beside the composed one."""


_DAMAGED = lazily(r"Corrupt asset|Failed verification|[Uu]npack")
"""What USD says where a layer opens and its values or names make no sense."""


_ALONE = allocate_lock()
"""What USD prints is caught in the place of standard error, which all threads of a host share."""


def lint_file(file: File, config: Config, shown: Shown) -> FileResult:
    """Open, read, run, settle and locate; nothing of the stage outlives the call."""
    with _ALONE, Diagnostics() as said:
        try:
            result = _File(file, config, shown).lint()
        except Exception as error:  # noqa: BLE001 a bug met in one file must not cost the others
            result = _failed(file, error)
        finally:
            forget_large()
    if not said.messages:
        return result
    # USD composes in several threads: who speaks first is chance.
    return replace(result, chatter=(*result.chatter, *sorted(set(map(_named, said.messages)))))


def _named(said: str) -> str:
    """With the names that people know."""
    for file, instead in handed_over().items():
        said = said.replace(instead, file)
    return said


def _failed(file: File, error: Exception) -> FileResult:
    if isinstance(error, DamagedError):
        return _damaged(file.shown, str(error))
    if isinstance(error, Tf.ErrorException) and _is_corrupt(sentences(error.args)):
        return _damaged(file.shown, _NO_VALUE, sentences(error.args))
    if isinstance(error, (UnicodeDecodeError, UndecodableError)):
        said = "holds text that is not UTF-8, or one of its layers does: nothing of it was linted"
        return FileResult(problems=(Problem("undecodable-text", file.shown, said),))
    if isinstance(error, MemoryError):
        needs = "linting it needs more memory than there is"
        return FileResult(problems=(Problem("out-of-memory", file.shown, needs),))
    what = f"{type(error).__name__}: {error}".splitlines()[0]
    message = f"linting it failed: {what}. This is a bug of usdrender-lint; -v tells where"
    import traceback

    where = "".join(traceback.format_exception(error))
    return FileResult(problems=(Problem("crashed-lint", file.shown, message),), chatter=(where,))


class UndecodableError(Exception):
    """A layer holds text that is not UTF-8, and cannot be read without it."""


def _is_corrupt(said: Iterable[str]) -> bool:
    return any(map(_DAMAGED.search, said))


def _damaged(file: str, what: str, said: Iterable[str] = ()) -> FileResult:
    message = f"USD opens it, and it is damaged: {what}"
    return FileResult(problems=(Problem("unreadable-file", file, message),), chatter=tuple(said))


@dataclass(slots=True)
class _Stage:
    """One opening of the file: what was found, and what the next opening needs to know."""

    opened: Opened
    scope: RenderScope
    findings: tuple[Located, ...]
    crashes: list[Crash]
    choice: RendererChoice
    used: list[Sdf.Layer]


class _File:
    def __init__(self, file: File, config: Config, shown: Shown) -> None:
        self._path = file.file
        self._about = file.about
        self._root = file.shown
        self._config = config
        self._shown = shown
        self._texts = Texts()
        self._ignores = Ignores(self._texts, shown)
        self._silent = config.selection.told
        self._judges_suppressions = config.selection.judges_suppressions
        self._whole = True
        """Whether no part of the stage was missing in any of its openings."""

    def lint(self) -> FileResult:
        before = loaded_layers()
        # To be found by whatever brings them in.
        handed = [open_layer(file) for file in handed_over()]
        if self._about and not all(isinstance(one, Sdf.Layer) for one in handed):
            return FileResult()  # what it holds is told where it is linted itself
        layer = open_layer(self._path)
        if isinstance(layer, Unreadable):
            return FileResult(problems=(self._unreadable(layer),))
        if isinstance(layer, ParseProblem):
            guilty = ill_formed_expressions(self._texts, self._path) or [_as_layer(layer)]
            return self._without_stage(guilty, [layer])
        result = self._decoded(layer)
        if result is not None:
            return result
        undecodable = make_decodable(before)
        if undecodable is None:
            raise UndecodableError
        result = self._composed(layer)
        problems = (self._undecodable(file, at) for file, at in undecodable.items())
        return replace(result, problems=(*result.problems, *problems))

    def _decoded(self, layer: Sdf.Layer) -> FileResult | None:
        """None if it holds text that is not UTF-8: that is raised, or printed by USD's Python where
        it stands in a dictionary or an array, which then lacks it."""
        printed = StringIO()
        try:
            with redirect_stderr(printed):
                result = self._composed(layer)
        except UnicodeDecodeError:
            return None
        if UnicodeDecodeError.__name__ in printed.getvalue():
            return None
        if sys.stderr is not None:
            sys.stderr.write(printed.getvalue())
        return result

    def _composed(self, layer: Sdf.Layer) -> FileResult:
        _held, endless = sublayers_of(layer, look_through, self._texts.mention)
        if endless is not None:
            return FileResult(problems=(self._unreadable(endless),))
        try:
            composed = self._lint_stage(layer)
        except Tf.ErrorException as error:
            return self._unopened(layer, error)
        return self._result(composed, layer)

    def _result(self, composed: _Stage, layer: Sdf.Layer) -> FileResult:
        findings, problems = composed.findings, self._problems(composed)
        if self._config.variants:
            outcomes, more = self._lint_variants(composed, layer)
            findings, problems = merge_outcomes(findings, outcomes), [*problems, *more]
        files = {split_package(file)[0] for file in _files_of(composed.used)}
        return FileResult(
            findings,
            tuple(problems),
            composed.choice,
            tuple(sorted(map(self._shown, files))),
            ignores=self._ignores.own,
            needed=self._ignores.needed,
            silent=self._silent if self._whole else None,
            outline=_outline(composed),
        )

    def _lint_stage(self, layer: Sdf.Layer, session: Sdf.Layer | None = None) -> _Stage:
        opened = open_stage(
            layer, self._config.scopes, session, whole=self._config.selection.needs_scene
        )
        scope = read(opened, self._texts)
        chosen, reason = (
            choose(scope.evidence, self._config.own_renderers)
            if self._config.renderer == "auto"
            else (renderer(self._config.renderer, self._config.own_renderers), "asked for")
        )
        locator = Locator(opened.stage, self._path, self._texts, self._shown, opened.unparsed)
        self._ignores.enter(opened.stage, locator, layer if self._tells_idle else None)
        if opened.unparsed or any(error.touches_spec for error in scope.errors):
            self._whole = False
        used = list(opened.stage.GetUsedLayers())
        files = opened.reopened.union(one.realPath for one in used)
        opened.unreadable += torn_among(files.difference(one.file for one in opened.unreadable))
        found, crashes = self._findings([*self._subjects(opened, scope, used)], chosen, locator)
        if self._about:
            concerns = Concerns(opened.stage, self._about)
            found = tuple(one for one in found if one in concerns)
        choice = RendererChoice(self._root, chosen.name, reason)
        return _Stage(opened, scope, found, crashes, choice, used)

    def _subjects(
        self, opened: Opened, scope: RenderScope, used: list[Sdf.Layer]
    ) -> Iterator[Subject]:
        yield from subjects_of(scope)
        yield from map(_as_layer, dict.fromkeys(opened.unparsed))
        if self._config.selection.needs_scene:
            yield read_scene(opened.stage, scope)
        for file in sorted(_files_of(used)):
            yield from ill_formed_expressions(self._texts, file)

    def _lint_variants(
        self, composed: _Stage, layer: Sdf.Layer
    ) -> tuple[list[Outcome], list[Problem]]:
        """Every variant of one set after the other, the other sets as they are composed."""
        outcomes: list[Outcome] = []
        problems: list[Problem] = []
        for found in variant_sets(composed.opened, composed.scope):
            for choice in found.others:
                if len(outcomes) >= MOST_VARIANTS:
                    said = f"more than {MOST_VARIANTS} variants: the rest was not linted"
                    problems.append(Problem("too-many-variants", self._root, said))
                    return outcomes, problems
                try:
                    linted = self._lint_stage(layer, selecting(found, choice))
                except Tf.ErrorException:
                    said = f"USD cannot open the stage with {found.spelt(choice)}"
                    problems.append(Problem("unopened-stage", self._root, said))
                    continue
                problems.extend(self._problems(linted))
                outcomes.append(_outcome(found, choice, linted))
        return outcomes, problems

    def _unopened(self, layer: Sdf.Layer, error: Tf.ErrorException) -> FileResult:
        """The layer parses and the stage does not open: an ill-formed expression in a referenced
        layer, or something that USD gives up on."""
        guilty = [
            problem
            for file in _brought_in(layer)
            for problem in ill_formed_expressions(self._texts, file)
        ]
        if guilty:
            return self._without_stage(guilty, [])
        said = sorted(set(sentences(error.args)))
        if _is_corrupt(said):
            damaged = "USD opens it, and it is damaged, or a layer that it uses is"
            problem = Problem("unreadable-file", self._root, damaged)
            return FileResult(problems=(problem,), chatter=tuple(said))
        message = "USD opens its layers and gives up on the stage: one of them may be damaged"
        problem = Problem("unopened-stage", self._root, message)
        return FileResult(problems=(problem,), chatter=tuple(said))

    def _without_stage(self, guilty: list[Layer], unparsed: list[ParseProblem]) -> FileResult:
        locator = Locator(None, self._path, self._texts, self._shown, unparsed)
        if self._tells_idle:
            self._ignores.enter_text(self._path)
        found, crashes = self._findings([*guilty], renderer(ANY), locator)
        return FileResult(
            found,
            tuple(self._crashed(crashes)),
            layers=(self._root,),
            ignores=self._ignores.own,
            needed=self._ignores.needed,
        )

    def _findings(
        self, subjects: list[Subject], chosen: Renderer, locator: Locator
    ) -> tuple[tuple[Located, ...], list[Crash]]:
        judged = self._config.judged_by(chosen)
        self._silent &= judged.silent
        told, crashes = run(judged.rules, subjects, Context(chosen))
        told = [t for t in unique(told) if self._severity(t, chosen) is not None]
        settled = settle(told)
        kept = {id(one) for one in settled}
        found: list[Located] = []
        # What another finding explains away comes back with the next change: its suppression is no
        # idle one.
        for one in told if self._judges_suppressions else settled:
            severity = self._severity(one, chosen)
            if severity is not None and one.rule.id in self._config.selection.told:
                located = self._ignores.judge(locator.locate(one, severity))
                left_out = self._config.leaves_out(one.rule.id, located.location.file)
                if id(one) in kept and not left_out:
                    found.append(located)
        return tuple(found), crashes

    def _severity(self, told: Told, chosen: Renderer) -> Severity | None:
        return severity_of(told.rule, told.finding, chosen, self._config.severities)

    @property
    def _tells_idle(self) -> bool:
        """Whether its own suppressions are asked about: those of the files that were given."""
        return self._judges_suppressions and not self._about

    def _problems(self, linted: _Stage) -> list[Problem]:
        unreadable = [self._unreadable(u) for u in linted.opened.unreadable]
        return [*unreadable, *self._crashed(linted.crashes)]

    def _unreadable(self, found: Unreadable) -> Problem:
        asked = f" (brought in by {self._shown(found.asked_by)})" if found.asked_by else ""
        return Problem(found.kind, self._shown(found.file), found.message + asked)

    def _undecodable(self, file: str, places: list[str]) -> Problem:
        metadata = ("the metadata of the layer" if p == "/" else f"<{p}>" for p in places[:4])
        more = f" and {len(places) - 4} more" if len(places) > 4 else ""
        said = f"holds text that is not UTF-8, in {', '.join(metadata)}{more}: read without it"
        return Problem("undecodable-text", self._shown(file), said)

    def _crashed(self, crashes: list[Crash]) -> Iterator[Problem]:
        for crash in crashes:
            yield crashed_rule(self._root, crash)


def _files_of(layers: Iterable[Sdf.Layer]) -> set[str]:
    return {file for one in layers if (file := one.realPath)}


def _outcome(found: VariantSet, choice: str, linted: _Stage) -> Outcome:
    return Outcome(found.key, found.selected, found.choices, choice, linted.findings)


def _outline(linted: _Stage) -> Outline:
    stage = linted.opened.stage
    local = stage.GetLayerStack(includeSessionLayers=False)
    has_arcs = len(linted.used) > len(local) + 1  # the session layer is another
    return Outline(
        tuple(split_package(one.realPath)[0] for one in local if one.realPath),
        frozenset(f"/{n}" for one in local for n in one.pseudoRoot.GetInfo("primChildren")),
        frozenset(_brought(stage, linted.scope, {*local}) if has_arcs else ()),
    )


def _brought(
    stage: Usd.Stage, scope: RenderScope, local: set[Sdf.Layer]
) -> Iterator[tuple[str, str]]:
    paths = {prefix for prim in scope.prims() for prefix in Sdf.Path(prim.path).GetPrefixes()}
    for path in paths:
        for spec in stage.GetPrimAtPath(path).GetPrimStack():
            if spec.path.IsRootPrimPath() and spec.layer.realPath and spec.layer not in local:
                yield split_package(spec.layer.realPath)[0], str(spec.path)


def _as_layer(problem: ParseProblem) -> Layer:
    site = Site("/", "syntax", layer=problem.file, spec=problem.spec)
    return Layer(problem.file, site, problem.message, problem.asked)


def _brought_in(layer: Sdf.Layer) -> Iterator[str]:
    """The files of all layers that a layer's arcs lead to: what does not open is not kept by USD,
    so they are followed by their paths."""
    pending, seen = [layer], {layer.realPath}
    while pending:
        one = pending.pop()
        look_through(one)
        for asset in one.GetCompositionAssetDependencies():
            file = one.ComputeAbsolutePath(asset)
            if file in seen:
                continue
            seen.add(file)
            yield file
            found = open_layer(file)
            if isinstance(found, Sdf.Layer):
                pending.append(found)
