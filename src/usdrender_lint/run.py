"""What do the rules say about the subjects?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from .model import Described, Layer, RenderPrim, RenderScope, Scene, State, Suppressions
from .records import dataclass
from .rule import AnyRule, Context, Finding
from .signs import signs_of


@dataclass(frozen=True, slots=True)
class Told:
    """A finding and the rule that told it."""

    rule: AnyRule
    finding: Finding


@dataclass(frozen=True, slots=True)
class Crash:
    """A rule that raised. Data, not an end: the other rules still run, and the run is incomplete."""

    rule: AnyRule
    subject: str
    error: str


Subject = RenderScope | Described | Layer | Scene | Suppressions


def subjects_of(scope: RenderScope) -> Iterator[Subject]:
    """The scope as a whole, and every live render prim: nobody renders the others. In a layer of mere
    overrides also those that say their type: whoever defines them gets what stands there."""
    yield scope
    shared: set[str] = set()
    for prim in scope.prims():
        is_override = scope.only_overrides and prim.state is State.OVER
        if (prim.live or is_override) and prim.prototype not in shared:
            yield prim
        if prim.prototype:  # what instances share is judged once, at the first of them
            shared.add(prim.prototype)
    yield from scope.cameras


_SHOWN = 1024
"""Different stages of which it is kept which rules speak of them: more are hardly ever alike."""


class Rules:
    """Those that judge many stages. Which of them have something to speak of is found out once for
    all stages that show the same."""

    def __init__(self, rules: Iterable[AnyRule]) -> None:
        self._rules = tuple(rules)
        self._speaking: dict[frozenset[str], tuple[AnyRule, ...]] = {}

    def __iter__(self) -> Iterator[AnyRule]:
        return iter(self._rules)

    def speaking_of(self, shown: frozenset[str] | None) -> tuple[AnyRule, ...]:
        """`shown`: the signs of a stage; None where nobody can tell."""
        if shown is None:
            return self._rules
        found = self._speaking.get(shown)
        if found is None:
            found = tuple(r for r in self._rules if not (r.about and r.about.isdisjoint(shown)))
            if len(self._speaking) < _SHOWN:
                self._speaking[shown] = found
        return found


def run(
    rules: Rules, subjects: Iterable[Subject], context: Context
) -> tuple[list[Told], list[Crash]]:
    told: list[Told] = []
    crashes: list[Crash] = []
    everything = list(subjects)
    live = _by_kind(s for s in everything if not _is_dead(s))
    all_there_is = _by_kind(everything)
    for rule in rules.speaking_of(_shown(everything)):
        for subject in (all_there_is if rule.by_itself else live).get(rule.on, ()):
            try:
                for finding in rule.check(subject, context):
                    told.append(Told(rule, finding))
            except Exception as error:  # noqa: BLE001 a rule's bug must not cost the other rules' findings
                name = subject.path if not isinstance(subject, RenderScope) else subject.root
                crashes.append(Crash(rule, name, f"{type(error).__name__}: {error}"))
    return told, crashes


def _shown(subjects: list[Subject]) -> frozenset[str] | None:
    """None where no scope is among them to tell."""
    scope = next((s for s in subjects if isinstance(s, RenderScope)), None)
    return None if scope is None else frozenset(signs_of(scope))


def _is_dead(subject: Subject) -> bool:
    return isinstance(subject, RenderPrim) and not subject.live


def _by_kind(subjects: Iterable[Subject]) -> dict[type, list[Subject]]:
    """Those that a rule `on` a kind sees."""
    found: dict[type, list[Subject]] = {}
    for subject in subjects:
        for kind in type(subject).__mro__:
            found.setdefault(kind, []).append(subject)
    return found
