"""Which light paths can an expression match at all?

A path is the camera, then bounces, then the light, emitter or background where it ends. So an
expression is followed through three states: before the camera, on the way, and ended. It matches
something if it leads from the first to the last.
"""

from __future__ import annotations

from .dialects import CAMERA, Dialect
from .tree import (
    Choice,
    Complement,
    Either,
    Event,
    Except,
    Expression,
    Group,
    Item,
    Label,
    Part,
    Repeat,
    Sequence,
    Symbol,
    walk,
)

States = int
"""A set of states, as bits."""
BEFORE, ALONG, ENDED = 1, 2, 4
ANY = BEFORE | ALONG | ENDED

Steps = tuple[States, States, States]
"""Where a part leads from each of the states."""
NOWHERE: Steps = (0, 0, 0)
STAY: Steps = (BEFORE, ALONG, ENDED)
ANYWHERE: Steps = (ANY, ALONG | ENDED, ENDED)
AS_CAMERA: Steps = (ALONG, 0, 0)
AS_BOUNCE: Steps = (0, ALONG, 0)
AS_END: Steps = (0, ENDED, 0)


def then(first: Steps, second: Steps) -> Steps:
    return after(second, first[0]), after(second, first[1]), after(second, first[2])


def after(steps: Steps, states: States) -> States:
    """Where a part leads from any of these states."""
    return (
        (steps[0] if states & BEFORE else 0)
        | (steps[1] if states & ALONG else 0)
        | (steps[2] if states & ENDED else 0)
    )


def before(steps: Steps, states: States) -> States:
    """From where a part leads to any of these states."""
    return (
        (BEFORE if steps[0] & states else 0)
        | (ALONG if steps[1] & states else 0)
        | (ENDED if steps[2] & states else 0)
    )


def union(first: Steps, second: Steps) -> Steps:
    return first[0] | second[0], first[1] | second[1], first[2] | second[2]


def both(first: Steps, second: Steps) -> Steps:
    return first[0] & second[0], first[1] & second[1], first[2] & second[2]


def repeated(steps: Steps, low: int, high: int | None) -> Steps:
    """States only go forward, so three times is as far as any number of times."""
    least = STAY
    for _ in range(min(low, 3)):
        least = then(least, steps)
    more = STAY
    optional = 3 if high is None else min(max(high - low, 0), 3)
    for _ in range(optional):
        more = union(STAY, then(more, steps))
    return then(least, more)


class Paths:
    """Where each part of one expression leads."""

    def __init__(self, expression: Expression) -> None:
        self._expression = expression
        self._dialect = expression.dialect
        self._steps: dict[int, Steps] = {}
        """By identity: equal parts stand in many places, and comparing them takes time."""
        for part in reversed(tuple(walk(expression.body))):
            self._steps[id(part)] = self._of(part)

    def __getitem__(self, part: Part) -> Steps:
        return self._steps[id(part)]

    def _of(self, part: Part) -> Steps:
        match part:
            case Symbol():
                return letter(part.letter, self._dialect)
            case Label():
                # Which of the events it may qualify is not looked at: `R'1'` and `'1'` both.
                return union(STAY, one_event()) if self._dialect.qualifying_labels else one_event()
            case Except():
                return excluding("".join(str(i) for i in part.items), self._dialect)
            case Event():
                return self._event(part)
            case Choice():
                # An empty one matches nothing, which is told without following it.
                return self._any(part.items) if part.items else one_event()
            case Group():
                return self[part.body]
            case Repeat():
                return repeated(self[part.item], part.low, part.high)
            case Complement():
                return ANYWHERE
            case Either():
                return self._either(part)
            case Sequence():
                steps = STAY
                for item in part.items:
                    steps = then(steps, self[item])
                return steps

    def _any(self, items: tuple[Item, ...]) -> Steps:
        steps = NOWHERE
        for item in items:
            steps = union(steps, self[item])
        return steps

    def _either(self, either: Either) -> Steps:
        steps = self[either.options[0]]
        for mark, option in zip(either.operators, either.options[1:], strict=True):
            if mark == "&":
                steps = both(steps, self[option])
            elif mark == "|":
                steps = union(steps, self[option])
        return steps

    def _event(self, event: Event) -> Steps:
        """By the event alone; one that cannot be is `suspect`'s affair, and leads anywhere here."""
        if not event.slots:
            return one_event()
        first = event.slots[0]
        steps = self[first] if isinstance(first, Symbol | Choice | Except) else NOWHERE
        events = self._dialect.events + "."
        named = [p for p in walk(first) if isinstance(p, Symbol) and p.letter not in events]
        if named or steps == NOWHERE:
            return one_event()
        if len(event.slots) > 1 and scatters(event.slots[1], self._dialect) and steps[1] & ALONG:
            return AS_BOUNCE
        return steps


def one_event() -> Steps:
    """Any event, but one."""
    return union(union(AS_CAMERA, AS_BOUNCE), AS_END)


def letter(name: str, dialect: Dialect) -> Steps:
    if name == CAMERA:
        return AS_CAMERA
    if name in dialect.ends:
        return AS_END
    if name in dialect.either:
        return union(AS_BOUNCE, AS_END)
    if name in dialect.bounces or name in dialect.scatterings:
        return AS_BOUNCE
    return one_event()


def excluding(names: str, dialect: Dialect) -> Steps:
    """Of `[^ ]`. Excluding scatterings or labels leaves some of every kind."""
    if not set(names) <= set(dialect.events):
        return one_event()
    steps = NOWHERE
    for name in dialect.events:
        if name not in names:
            steps = union(steps, letter(name, dialect))
    return steps


def scatters(slot: Item, dialect: Dialect) -> bool:
    """Does the slot ask for a scattering, which only a bounce has?"""
    symbols = [p for p in walk(slot) if isinstance(p, Symbol)]
    plain = isinstance(slot, Symbol | Choice)
    return plain and bool(symbols) and all(s.letter in dialect.scatterings for s in symbols)
