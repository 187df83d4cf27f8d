"""What is asked for one file, and what comes of it?"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field

from .context import Outline
from .discover import Shown
from .discover import Target as File
from .patterns import Patterns
from .records import dataclass
from .registry import Selection, select
from .renderers import Own
from .results import Located, Problem, RendererChoice
from .rule import Renderer, Severity
from .run import Crash, Rules
from .suppress import Ignore, Key

SCOPES = ("/Render",)
"""Where the schema has render prims, and renderers look for them."""


@dataclass(frozen=True, slots=True)
class Judged:
    """What becomes of the rules that are asked for on the stages that one renderer judges."""

    judge: Renderer
    rules: Rules
    """Those that run."""
    silent: frozenset[str]
    """Those of which nothing is told, whatever there is to find."""


@dataclass(frozen=True, slots=True)
class Config:
    """What the person asked for."""

    selection: Selection = field(default_factory=select)
    severities: dict[str, Severity] = field(default_factory=dict)
    renderer: str = "auto"
    own_renderers: tuple[Own, ...] = ()
    """Beside those of the package."""
    variants: bool = False
    """Also every variant of the variant sets that reach the render spec."""
    scopes: tuple[str, ...] = SCOPES
    ignores: bool = True
    """Whether comments and metadata hide findings."""
    roots: tuple[str, ...] = ()
    """Stages through which the layers that they use are linted: patterns of `glob`, absolute or from
    the current folder."""
    per_file_ignores: tuple[tuple[Patterns, frozenset[str]], ...] = ()
    """Rules not to report of the layers whose files a pattern matches."""
    fail_on: str = "warning"
    """The least severity that fails a run; `never` for none."""
    _judged: dict[int, Judged] = field(init=False, compare=False, default_factory=dict)

    def judged_by(self, judge: Renderer) -> Judged:
        if id(judge) not in self._judged:
            self._judged[id(judge)] = self._by(judge)
        return self._judged[id(judge)]

    def _by(self, judge: Renderer) -> Judged:
        told = self.selection.told
        rules = Rules(r for r in self.selection.run if not r.renderers or judge.name in r.renderers)
        off = {rule for rule, severity in judge.severities.items() if severity is None}
        speaking = told.intersection(r.id for r in rules) - off.difference(self.severities)
        return Judged(judge, rules, told - speaking)

    def leaves_out(self, rule: str, file: str) -> bool:
        """Whether a rule is not to be reported of a file's layers."""
        return any(rule in rules and file in files for files, rules in self.per_file_ignores)


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
    silent: frozenset[str] | None = None
    """Of the rules that are asked for those that did not look at it, which are fewer than those that
    did; None if a part of the stage is missing."""
    outline: Outline | None = None
    """None where there was no stage."""


Asked = tuple[File, Config]
"""A file, and what is asked for it."""
Lint = Callable[[Sequence[Asked], Shown], list[FileResult]]


def crashed_rule(root: str, crash: Crash) -> Problem:
    said = f"the rule {crash.rule.id} failed on <{crash.subject}>: {crash.error}"
    message = f"{said}. This is a bug of usdrender-lint"
    return Problem("crashed-rule", root, message, crash.rule.id)
