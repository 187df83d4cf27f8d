"""What do the rules say about the subjects?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from .model import Camera, Layer, RenderPrim, RenderScope, Scene, State, Suppressions
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


Subject = RenderScope | RenderPrim | Camera | Layer | Scene | Suppressions


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


def run(
    rules: Iterable[AnyRule], subjects: Iterable[Subject], context: Context
) -> tuple[list[Told], list[Crash]]:
    told: list[Told] = []
    crashes: list[Crash] = []
    everything = list(subjects)
    shown = _shown(everything)
    live = _by_kind(s for s in everything if not _is_dead(s))
    all_there_is = _by_kind(everything)
    for rule in rules:
        if rule.about and shown is not None and rule.about.isdisjoint(shown):
            continue
        for subject in (all_there_is if rule.by_itself else live).get(rule.on, ()):
            try:
                for finding in rule.check(subject, context):
                    told.append(Told(rule, finding))
            except Exception as error:  # noqa: BLE001 a rule's bug must not cost the other rules' findings
                name = subject.path if not isinstance(subject, RenderScope) else subject.root
                crashes.append(Crash(rule, name, f"{type(error).__name__}: {error}"))
    return told, crashes


def _shown(subjects: list[Subject]) -> set[str] | None:
    """None where no scope is among them to tell."""
    scope = next((s for s in subjects if isinstance(s, RenderScope)), None)
    return None if scope is None else signs_of(scope)


def _is_dead(subject: Subject) -> bool:
    return isinstance(subject, RenderPrim) and not subject.live


def _by_kind(subjects: Iterable[Subject]) -> dict[type, list[Subject]]:
    """Those that a rule `on` a kind sees."""
    found: dict[type, list[Subject]] = {}
    for subject in subjects:
        for kind in type(subject).__mro__:
            found.setdefault(kind, []).append(subject)
    return found
