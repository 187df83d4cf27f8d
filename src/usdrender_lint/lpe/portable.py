"""What in an expression is not Open Shading Language, and whose is it?"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

from ..records import dataclass
from .dialects import ALL, MEANINGS, OSL, Dialect
from .parse import parse
from .tree import Complement, Either, Event, Expression, Repeat, Symbol, walk


@dataclass(frozen=True, slots=True)
class Extension:
    """Something that only some renderers read."""

    what: str
    column: int
    dialects: tuple[Dialect, ...]


@lru_cache(maxsize=1024)
def extensions(text: str, dialects: tuple[Dialect, ...] = ALL) -> tuple[Extension, ...]:
    """By column. `<RS8>` is one, though Open Shading Language reads it too: as a label "8"."""
    readers: dict[tuple[int, str], list[Dialect]] = {}
    for dialect in dialects:
        read = parse(text, dialect)
        if isinstance(read, Expression):
            for what, column in _own(read):
                readers.setdefault((column, what), []).append(dialect)
    return tuple(Extension(w, c, tuple(d)) for (c, w), d in sorted(readers.items()))


def _own(expression: Expression) -> Iterator[tuple[str, int]]:
    dialect = expression.dialect
    if expression.name:
        yield f"the name '{expression.name.strip()}'", 1
    for prefix in expression.prefixes:
        if prefix.name in dialect.prefixes:
            yield f"the prefix '{prefix}'", prefix.column
    labels: set[int] = set()
    for part in walk(expression.body):
        match part:
            case Event():
                labels.update(id(p) for slot in part.slots[2:] for p in walk(slot))
            case Symbol() if id(part) not in labels:
                yield from _letter(part, dialect)
            case Repeat(mark="?"):
                yield "the repetition '?'", part.column + len(str(part.item))
            case Complement():
                yield "the operator '^'", part.column
            case Either() if mark := part.operators.strip("|"):
                yield f"the operator '{mark[0]}'", part.column
            case _:
                pass


def _letter(symbol: Symbol, dialect: Dialect) -> Iterator[tuple[str, int]]:
    if symbol.number and symbol.letter in OSL.letters:
        yield f"the numbered lobe '{symbol}'", symbol.column
    elif symbol.letter in dialect.letters and symbol.letter not in OSL.letters:
        meaning = MEANINGS.get(symbol.letter)
        yield f"the event '{symbol}'{f' ({meaning})' if meaning else ''}", symbol.column
