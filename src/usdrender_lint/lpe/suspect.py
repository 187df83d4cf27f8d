"""Does an expression that is read match nothing, or something else than was meant?"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from .dead_ends import dead_ends
from .dialects import Dialect
from .parse import parse
from .problem import nearest, short, unknown_prefix
from .slots import renamed, slot_suspicions
from .suspicion import Edit, Suspicion, edited, instead
from .tree import (
    Choice,
    Event,
    Except,
    Expression,
    Group,
    Label,
    Part,
    Repeat,
    Sequence,
    Symbol,
    walk,
)


def suspicions(expression: Expression) -> Iterator[Suspicion]:
    """By column. Where a dialect stops reading early, only that is told of the whole."""
    if expression.name:
        return
    found = [*_prefixes(expression), *_parts(expression)]
    found += [_unread(expression)] if expression.unread else dead_ends(expression)
    yield from sorted(found, key=lambda s: s.column)


def mended(expression: Expression) -> str | None:
    """The expression as it was probably meant, if it is read so and nothing in it is suspect."""
    written = text = str(expression)
    for _ in range(4):
        read = parse(text, expression.dialect)
        found = tuple(suspicions(read)) if isinstance(read, Expression) else ()
        edits = [s.edit for s in found if s.edit]
        if not edits:
            break
        text = edited(text, edits)
    clean = isinstance(read, Expression) and not found
    return text if clean and text != written else None


def _prefixes(expression: Expression) -> Iterator[Suspicion]:
    known = expression.dialect.prefixes
    for prefix in expression.prefixes:
        if prefix.name not in known:
            start = prefix.column - 1
            meant = nearest(prefix.name, known)
            edit = Edit(start, start + len(prefix.name), meant) if meant else None
            yield Suspicion(unknown_prefix(prefix.name, expression.dialect), prefix.column, edit)


def _unread(expression: Expression) -> Suspicion:
    """lpeparse.cpp, `parseCat`: it returns at the `)` of the `(` that the text begins with."""
    text, rest = str(expression), expression.unread
    start = expression.body.column - 1
    whole = f"({text[start:]})"
    read = isinstance(parse(whole, expression.dialect), Expression)
    return Suspicion(
        f"{expression.dialect.title} reads only to the ')' that closes the first '(': "
        f"'{short(rest)}' is lost",
        len(text) - len(rest) + 1,
        Edit(start, len(text), whole) if read else None,
    )


def _parts(expression: Expression) -> Iterator[Suspicion]:
    dialect = expression.dialect
    inside: set[int] = set()
    for part in walk(expression.body):
        match part:
            case Event():
                inside.update(id(p) for p in walk(part))
                yield from slot_suspicions(part, dialect)
            case Choice(items=()):
                yield Suspicion("'[]' matches nothing", part.column)
            case Group(body=Sequence(items=())):
                yield _crash("'()' holds nothing", part)
            case Repeat(low=0, high=0):
                yield _crash(f"'{part.mark}' is no times at all", part)
            case Repeat(low=low, high=int(high)) if high < low:
                edit = instead(part, f"{part.item}{{{high},{low}}}")
                yield Suspicion(f"'{short(part.mark)}' counts backwards", part.column, edit)
            case Except():
                yield from _mixed(part, dialect)
            case Label(name=""):
                yield Suspicion("this label is empty", part.column)
            case Symbol() if part.number:
                yield from _lobe(part, dialect)
            case Symbol() if part.letter in dialect.instead and id(part) not in inside:
                yield renamed(part, dialect)
            case Sequence():
                yield from _split_events(part, dialect)
            case _:
                pass


def _crash(what: str, part: Part) -> Suspicion:
    """lpexp.cpp: `Cat` and `NRepeat` then have no state to give, and a null pointer is followed."""
    return Suspicion(f"{what}: Open Shading Language can crash on it", part.column)


def _mixed(part: Except, dialect: Dialect) -> Iterator[Suspicion]:
    """lpeparse.cpp, `parseNegor`: the kind of the last one decides for all, with a warning."""
    kinds = [_kind(item, dialect) for item in part.items]
    if len(set(kinds)) > 1:
        mix = " and ".join(sorted(set(kinds)))
        message = f"'{short(str(part))}' mixes {mix}: all are taken for {kinds[-1]}"
        yield Suspicion(message, part.column)


def _kind(item: Symbol | Label, dialect: Dialect) -> str:
    if isinstance(item, Label):
        return "labels"
    return "events" if item.letter in dialect.events else "scatterings"


def _lobe(symbol: Symbol, dialect: Dialect) -> Iterator[Suspicion]:
    highest = dialect.lobes[symbol.letter]
    if len(symbol.number) > 3 or not 1 <= int(symbol.number) <= highest:
        lobes = f"{symbol.letter}1 to {symbol.letter}{highest}"
        message = f"'{short(str(symbol))}': {dialect.title} has {lobes}"
        yield Suspicion(message, symbol.column)


def _split_events(sequence: Sequence, dialect: Dialect) -> Iterator[Suspicion]:
    """`RD` is any reflection and then any diffuse bounce; `<RD>` is a diffuse reflection."""
    for first, second in pairwise(sequence.items):
        if not (isinstance(first, Symbol) and isinstance(second, Symbol)):
            continue
        if first.letter in "RT" and second.letter in dialect.scatterings:
            start, pair = first.column - 1, f"{first}{second}"
            edit = Edit(start, start + len(pair), f"<{pair}>")
            message = f"'{pair}' is two bounces: one of that kind is <{pair}>"
            yield Suspicion(message, first.column, edit)
