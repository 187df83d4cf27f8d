"""What is a light path expression made of?

`str` of any part is its text, letter by letter. Columns are code points, from 1, and do not count
when two parts are compared.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field

from ..records import dataclass
from .dialects import Dialect


def _column() -> int:
    return field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Symbol:
    """A letter, `.` or `x`, in RenderMan with a number; between `<` and `>` any character."""

    text: str
    column: int = _column()

    @property
    def letter(self) -> str:
        return self.text[0]

    @property
    def number(self) -> str:
        return self.text[1:]

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True, slots=True)
class Label:
    """`'key'`: a light group, an object, a material."""

    name: str
    column: int = _column()

    def __str__(self) -> str:
        return f"'{self.name}'"


@dataclass(frozen=True, slots=True)
class Choice:
    """`[LO]`: one of these."""

    items: tuple[Item, ...]
    column: int = _column()

    def __str__(self) -> str:
        return f"[{''.join(map(str, self.items))}]"


@dataclass(frozen=True, slots=True)
class Except:
    """`[^LO]`: one event, none of these."""

    items: tuple[Symbol | Label, ...]
    column: int = _column()

    def __str__(self) -> str:
        return f"[^{''.join(map(str, self.items))}]"


@dataclass(frozen=True, slots=True)
class Event:
    """`<RD'floor'>`: the event, its scattering, its labels."""

    slots: tuple[Item, ...]
    column: int = _column()

    def __str__(self) -> str:
        return f"<{''.join(map(str, self.slots))}>"


@dataclass(frozen=True, slots=True)
class Group:
    """`(...)`."""

    body: Sequence
    column: int = _column()

    def __str__(self) -> str:
        return f"({self.body})"


@dataclass(frozen=True, slots=True)
class Repeat:
    """`.*`, `D+`, `T?`, `S{1,2}`."""

    item: Item
    mark: str
    low: int
    high: int | None
    column: int = _column()

    def __str__(self) -> str:
        return f"{self.item}{self.mark}"


@dataclass(frozen=True, slots=True)
class Either:
    """`L|O`. V-Ray also combines by `&` and `-`."""

    options: tuple[Sequence, ...]
    operators: str
    """One between each two options."""
    column: int = _column()

    def __str__(self) -> str:
        rest = zip(self.operators, self.options[1:], strict=True)
        return f"{self.options[0]}{''.join(f'{mark}{option}' for mark, option in rest)}"


@dataclass(frozen=True, slots=True)
class Complement:
    """V-Ray's `^(...)`: every path but these."""

    item: Item
    column: int = _column()

    def __str__(self) -> str:
        return f"^{self.item}"


@dataclass(frozen=True, slots=True)
class Sequence:
    """One after the other."""

    items: tuple[Item, ...]
    column: int = _column()

    def __str__(self) -> str:
        return "".join(map(str, self.items))


Item = Symbol | Label | Choice | Except | Event | Group | Repeat | Either | Complement
Part = Item | Sequence


@dataclass(frozen=True, slots=True)
class Prefix:
    """`unoccluded;`."""

    name: str
    column: int = _column()

    def __str__(self) -> str:
        return f"{self.name};"


@dataclass(frozen=True, slots=True)
class Expression:
    """A light path expression as one dialect reads it."""

    dialect: Dialect
    body: Sequence
    prefixes: tuple[Prefix, ...] = ()
    unread: str = ""
    """What the dialect never looks at."""
    name: str = ""
    """The renderer's own word for an expression, which then has no body."""

    def __str__(self) -> str:
        return f"{''.join(map(str, self.prefixes))}{self.name}{self.body}{self.unread}"


def parts(part: Part) -> tuple[Part, ...]:
    """What a part is directly made of."""
    match part:
        case Choice() | Except() | Sequence():
            return part.items
        case Event():
            return part.slots
        case Group():
            return (part.body,)
        case Repeat() | Complement():
            return (part.item,)
        case Either():
            return part.options
        case Symbol() | Label():
            return ()


def walk(part: Part) -> Iterator[Part]:
    """The part and all that is in it, in the order of the text."""
    waiting = [part]
    while waiting:
        yield (part := waiting.pop())
        waiting.extend(reversed(parts(part)))
