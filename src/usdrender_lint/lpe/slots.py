"""Does each place between `<` and `>` hold what belongs there?

First the event, second its scattering, then labels. Open Shading Language's reader
(lpeparse.cpp, `parseSymbol`) takes any character in any place.
"""

from __future__ import annotations

from collections.abc import Iterator

from .dialects import CAMERA, Dialect
from .paths import scatters
from .problem import lookalike, quoted, shown, straightened
from .suspicion import Suspicion, instead
from .tree import Choice, Event, Item, Label, Part, Symbol, walk


def slot_suspicions(event: Event, dialect: Dialect) -> Iterator[Suspicion]:
    """One at most, besides letters that only have another name in that dialect."""
    slots = _Slots(event, dialect)
    yield from slots.renamed()
    for check in (slots.empty, slots.strange, slots.event, slots.scattering, slots.labels):
        if found := check():
            yield found
            return


def renamed(symbol: Symbol, dialect: Dialect) -> Suspicion:
    """A letter that the dialect writes otherwise."""
    meant = dialect.instead[symbol.letter]
    message = f"{dialect.title} has no '{symbol.letter}': it calls that {meant}"
    return Suspicion(message, symbol.column, instead(symbol, meant))


class _Slots:
    def __init__(self, event: Event, dialect: Dialect) -> None:
        self._event = event
        self._dialect = dialect
        self._slots = event.slots
        self._texts = [str(slot) for slot in event.slots]

    def _said(self, message: str, meant: list[str] | None, at: Part | None = None) -> Suspicion:
        edit = instead(self._event, f"<{''.join(meant)}>") if meant else None
        return Suspicion(message, (at or self._event).column, edit)

    def renamed(self) -> Iterator[Suspicion]:
        for slot in self._slots[1:2]:
            for leaf in _leaves(slot):
                if isinstance(leaf, Symbol) and leaf.letter in self._dialect.instead:
                    yield renamed(leaf, self._dialect)

    def empty(self) -> Suspicion | None:
        if self._slots:
            return None
        return Suspicion("'<>' is any event, '.'", self._event.column, instead(self._event, "."))

    def strange(self) -> Suspicion | None:
        """A character that is no letter of the language, nor can be meant for a label."""
        for symbol in (p for slot in self._slots for p in walk(slot) if isinstance(p, Symbol)):
            if alike := lookalike(symbol.letter):
                return self._said(alike, [straightened(t) for t in self._texts], symbol)
            if symbol.text != "." and not symbol.letter.isalnum():
                meant = [t for t in self._texts if not t.isspace()]
                strange = shown(symbol.letter)
                message = f"{strange} inside '< >' is taken for a name that nothing has"
                return self._said(message, meant if meant != self._texts else None, symbol)
        return None

    def event(self) -> Suspicion | None:
        for leaf in _leaves(self._slots[0]):
            if isinstance(leaf, Label):
                message = f"{quoted(leaf)} stands where the event belongs: {_THIRD}"
                return self._said(message, ["..", *self._texts] if len(self._slots) == 1 else None)
            if leaf.letter in self._dialect.scatterings:
                message = (
                    f"{quoted(leaf)} is a scattering in the place of the event: it matches nothing"
                )
                return self._said(message, self._scattering_first())
            if leaf.letter not in f"{self._dialect.events}.":
                return self._said(f"no event is called {quoted(leaf)}", None, leaf)
        return None

    def _scattering_first(self) -> list[str] | None:
        """`<D>` was meant as `<.D>`, `<DR>` as `<RD>`."""
        first, *rest = self._texts
        if not scatters(self._slots[0], self._dialect):
            return None
        if not rest or isinstance(self._slots[1], Label):
            return [".", first, *rest]
        leaves = _leaves(self._slots[1])
        bounces = f"{self._dialect.bounces}."
        if leaves and all(isinstance(x, Symbol) and x.letter in bounces for x in leaves):
            return [rest[0], first, *rest[1:]]
        return None

    def scattering(self) -> Suspicion | None:
        if len(self._slots) == 1:
            return None
        for leaf in _leaves(self._slots[1]):
            if isinstance(leaf, Label):
                message = f"{quoted(leaf)} stands where the scattering belongs: {_THIRD}"
                return self._said(message, [self._texts[0], ".", *self._texts[1:]])
            if leaf.letter not in f"{self._dialect.scatterings}.x":
                known = " ".join(self._dialect.scatterings)
                events = all(t in tuple(self._dialect.bounces) for t in self._texts)
                meant = ["[", *self._texts, "]."] if events else None
                return self._said(f"{quoted(leaf)} is no scattering: {known} are", meant, leaf)
        return self._unscattered()

    def _unscattered(self) -> Suspicion | None:
        """`<LD>`: only a surface or a volume scatters."""
        events = _leaves(self._slots[0])
        still = CAMERA + self._dialect.ends
        if not events or not scatters(self._slots[1], self._dialect):
            return None
        if not all(isinstance(e, Symbol) and e.letter in still for e in events):
            return None
        first, second, *labels = self._texts
        message = f"{quoted(first)} never has the scattering {quoted(second)}"
        return self._said(message, [first, ".", *labels])

    def labels(self) -> Suspicion | None:
        """`<RDS>`: two scatterings are a set, in one place."""
        for leaf in (leaf for slot in self._slots[2:] for leaf in _leaves(slot)):
            if isinstance(leaf, Symbol) and leaf.letter in self._dialect.letters:
                first, *rest = self._texts
                scatterings = all(t in tuple(self._dialect.scatterings) for t in rest)
                meant = [first, "[", *rest, "]"] if scatterings else None
                message = f"{quoted(leaf)} is taken for a label, as all from the third place on"
                return self._said(message, meant, leaf)
        return None


_THIRD = "labels are third, as in <L.'key'>"


def _leaves(slot: Item) -> list[Symbol | Label]:
    """What a place names; `[^ ]` and `( )` are not looked into."""
    match slot:
        case Symbol() | Label():
            return [slot]
        case Choice():
            return [leaf for item in slot.items for leaf in _leaves(item)]
        case _:
            return []
