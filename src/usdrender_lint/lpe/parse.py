"""How is a text read, and where does reading stop?

The structure is that of Open Shading Language's reader, src/liboslexec/lpeparse.cpp: two things
that surprise are its own. Between `<` and `>` any character is a symbol, a stray `)` too; and `|`
joins just the two items beside it.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NoReturn

from ..lazily import lazily
from .dialects import Dialect
from .problem import PREFIX, Problem, shown, unknown, unknown_prefix
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
    Prefix,
    Repeat,
    Sequence,
    Symbol,
)

DEEPEST = 50
"""Real expressions nest three deep. Open Shading Language has no limit but the machine's stack."""
DIGITS = lazily(r"[0-9]*")
REPETITIONS: dict[str, tuple[int, int | None]] = {"*": (0, None), "+": (1, None), "?": (0, 1)}


@lru_cache(maxsize=1024)  # several rules read each expression, and shots have the same ones
def parse(text: str, dialect: Dialect) -> Expression | Problem:
    """The text as that dialect reads it."""
    try:
        return _Reader(text, dialect).expression()
    except _StopError as stop:
        return stop.problem


class _StopError(Exception):
    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.message)
        self.problem = problem


class _Reader:
    def __init__(self, text: str, dialect: Dialect) -> None:
        self._text = text
        self._dialect = dialect
        self._at = 0
        self._open: list[int] = []
        """Where each bracket stands that is not closed yet."""
        self._depth = 0
        self._in_event = False

    # -- the whole

    def expression(self) -> Expression:
        text, dialect = self._text, self._dialect
        if not text:
            self._stop("the expression is empty")
        if text.startswith("lpe:"):
            self._stop("'lpe:' is no part of the expression: it comes from sourceType")
        prefixes = self._prefixes()
        if (rest := text[self._at :]).strip() in dialect.names:
            return Expression(dialect, Sequence(()), prefixes, name=rest)
        if not rest:
            self._stop("the expression is missing after the prefix")
        if self._head == "(" and not dialect.reads_on:
            start = self._column
            body = Sequence((self._group(),), start)
            return Expression(dialect, body, prefixes, unread=text[self._at :])
        return Expression(dialect, self._sequence(""), prefixes)

    def _prefixes(self) -> tuple[Prefix, ...]:
        found = []
        dialect = self._dialect
        while match := PREFIX.match(self._text, self._at):
            name = match[0][:-1]
            if name not in dialect.prefixes and not dialect.ignores_prefixes:
                self._stop(unknown_prefix(name, dialect))
            found.append(Prefix(name, self._column))
            self._at = match.end()
        return tuple(found)

    def _sequence(self, closing: str) -> Sequence:
        """Items up to the closing bracket, or to the end of the text."""
        start = self._column
        long = self._dialect.long_alternatives
        operators = ""
        parted: list[list[list[Item]]] = [[]]
        """Parts between long alternatives, of items, of short alternatives."""
        while self._head and self._head != closing:
            if self._head == "^" and self._dialect.complements and not parted[-1]:
                parted[-1].append([self._complement()])
            elif self._head not in self._dialect.operators:
                parted[-1].append([self._item()])
            else:
                operators += self._operator(parted[-1], closing)
                if long:
                    parted.append([])
                else:
                    parted[-1][-1].append(self._item())
        if closing and not self._head:
            self._never_closed()
        sequences = tuple(_sequence(part, start) for part in parted)
        if len(sequences) == 1:
            return sequences[0]
        return Sequence((Either(sequences, operators, start),), start)

    def _operator(self, left: list[list[Item]], closing: str) -> str:
        mark = self._head
        if not left:
            self._stop(f"'{mark}' has nothing to its left")
        right = self._text[self._at + 1 : self._at + 2]
        # Between < and > Open Shading Language takes whatever comes for a symbol.
        if not right or (
            not self._in_event and (right == closing or right in self._dialect.operators)
        ):
            self._stop(f"'{mark}' has nothing to its right")
        self._at += 1
        return mark

    def _complement(self) -> Item:
        start = self._column
        self._at += 1
        self._deeper()
        if not self._head:
            self._at -= 1
            self._stop("'^' has nothing to its right")
        item = self._complement() if self._head == "^" else self._item()
        self._depth -= 1
        return Complement(item, start)

    # -- items

    def _item(self) -> Item:
        match self._head:
            case "(":
                item: Item = self._group()
            case "[":
                item = self._choice()
            case "<":
                item = self._event()
            case _:
                item = self._symbol()
        return self._repeated(item)

    def _group(self) -> Group:
        start = self._opened()
        body = self._sequence(")")
        self._closed()
        return Group(body, start)

    def _choice(self) -> Choice | Except:
        start = self._opened()
        if self._head == "^":
            self._at += 1
            return self._except(start)
        items: list[Item] = []
        while self._head != "]":
            if not self._head:
                self._never_closed()
            items.append(self._item())
        self._closed()
        return Choice(tuple(items), start)

    def _except(self, start: int) -> Except:
        items: list[Symbol | Label] = []
        while self._head != "]":
            if not self._head:
                self._never_closed()
            if self._head == "'":
                items.append(self._label())
            elif self._head in self._dialect.letters:
                items.append(self._letter())
            elif self._head in ".x":
                self._stop(f"'{self._head}' cannot be excluded")
            elif self._head in "([<":
                self._stop(f"'[^ ]' excludes letters and labels, not '{self._head}'")
            else:
                self._unknown()
        if not items:
            self._at = start - 1
            self._stop("'[^]' excludes nothing")
        self._closed()
        return Except(tuple(items), start)

    def _event(self) -> Event:
        if self._in_event:
            self._stop("'<' inside '< >'")
        start = self._opened()
        self._in_event = True
        slots: list[Item] = []
        while self._head != ">":
            if not self._head:
                self._never_closed()
            slots.append(self._item())
        self._in_event = False
        self._closed()
        return Event(tuple(slots), start)

    def _symbol(self) -> Symbol | Label:
        if self._head == "'":
            return self._label()
        if self._in_event or self._head == "." or self._head in self._dialect.letters:
            return self._letter()
        return self._unknown()

    def _letter(self) -> Symbol:
        start, letter = self._column, self._head
        self._at += 1
        number = ""
        if letter in self._dialect.lobes:
            number = self._digits()
        return Symbol(letter + number, start)

    def _label(self) -> Label:
        end = self._text.find("'", self._at + 1)
        if end < 0:
            self._stop("the quote of this label is never closed")
        label = Label(self._text[self._at + 1 : end], self._column)
        self._at = end + 1
        return label

    # -- repetitions

    def _repeated(self, item: Item) -> Item:
        if not self._head or self._head not in self._dialect.repetitions:
            return item
        if self._in_event:
            self._stop(f"'{self._head}' inside '< >': only the whole event can be repeated")
        start = self._at
        if self._head == "{":
            low, high = self._range()
        else:
            low, high = REPETITIONS[self._head]
            self._at += 1
        mark = self._text[start : self._at]
        if self._head and self._head in "*+{?":
            self._stop(f"'{mark}{self._head}': one repetition only")
        return Repeat(item, mark, low, high, item.column)

    def _range(self) -> tuple[int, int | None]:
        start = self._at
        self._at += 1
        low = self._digits()
        if not low and self._head == ",":
            self._stop("a number is missing before ',': {0,2} is from none to two")
        high: str | None = low
        if low and self._head == ",":
            self._at += 1
            high = self._digits() or None
        if not self._head:
            self._at = start
            self._stop("'{' is never closed")
        if not low or self._head != "}":
            self._stop(
                f"{shown(self._head)} in '{{ }}': it holds one number or two, {{2}} or {{2,5}}"
            )
        self._at += 1
        return _count(low), None if high is None else _count(high)

    # -- the text

    @property
    def _head(self) -> str:
        return self._text[self._at : self._at + 1]

    @property
    def _column(self) -> int:
        return self._at + 1

    def _digits(self) -> str:
        match = DIGITS.match(self._text, self._at)
        digits = match[0] if match else ""
        self._at += len(digits)
        return digits

    def _deeper(self) -> None:
        self._depth += 1
        if self._depth > DEEPEST:
            self._stop(f"nested more than {DEEPEST} deep")

    def _opened(self) -> int:
        self._deeper()
        self._open.append(self._at)
        self._at += 1
        return self._at

    def _closed(self) -> None:
        self._depth -= 1
        self._open.pop()
        self._at += 1

    # -- what is wrong

    def _stop(self, message: str) -> NoReturn:
        raise _StopError(Problem(message, self._column))

    def _never_closed(self) -> NoReturn:
        self._at = self._open[-1]
        self._stop(f"'{self._head}' is never closed")

    def _unknown(self) -> NoReturn:
        opened = self._open[-1] if self._open else None
        raise _StopError(unknown(self._text, self._at, opened, self._dialect))


def _sequence(items: list[list[Item]], start: int) -> Sequence:
    """Of items, each with the ones that `|` has joined to it."""
    joined = tuple(item[0] if len(item) == 1 else _either(item) for item in items)
    return Sequence(joined, joined[0].column if joined else start)


def _either(items: list[Item]) -> Either:
    options = tuple(Sequence((item,), item.column) for item in items)
    return Either(options, "|" * (len(items) - 1), items[0].column)


def _count(digits: str) -> int:
    """Python refuses to convert some thousand digits; no path is that long."""
    return int(digits) if len(digits) < 10 else 10**9
