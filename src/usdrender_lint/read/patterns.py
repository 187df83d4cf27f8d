"""What does a path expression say, and what can it match?

USD answers for prims on its stage only, and only where the expression counts. Asked here is what it
says literally, and what it could match on a stage of which most is not populated.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import field
from enum import StrEnum
from fnmatch import fnmatchcase
from typing import Any

from pxr import Sdf

from ..records import dataclass

_DEEPEST = 100
_LONG = 16
STRETCH = "//"
"""The part of a pattern that matches any number of levels, also none."""


@dataclass(frozen=True, slots=True)
class Parsed:
    """A pattern taken apart."""

    text: str
    prefix: str
    """Its literal beginning; relative if the pattern is."""
    parts: tuple[str, ...]
    """Names, globs and stretches, one for each level."""
    conditions: tuple[str, ...]
    """The predicate expressions in its braces."""
    below: bool
    """It ends in a stretch, and without a condition on it."""
    is_property: bool
    crashes: bool
    """`//{x}/a`, a nameless condition before a name, makes USD read beyond its memory (26.11)."""

    @classmethod
    def of(cls, pattern: Any) -> Parsed:
        text = str(pattern.GetText())
        split = _split(text)
        return cls(
            text,
            str(pattern.GetPrefix()),
            tuple(split.parts),
            tuple(split.conditions),
            bool(pattern.HasTrailingStretch()),
            bool(pattern.IsProperty()),
            split.crashes,
        )

    @property
    def names_all(self) -> bool:
        """Nothing but names, and a stretch at the end."""
        named = self.parts[:-1] if self.below else self.parts
        literal = "/" + "/".join(named) == self.prefix
        return literal and not self.conditions and not self.is_property

    @property
    def bare(self) -> bool:
        """It names prims and not what lies below them."""
        return not self.is_property and not self.below and self.parts[-1:] not in ((), (STRETCH,))

    def may_match(self, path: str) -> bool:
        """Leaving predicates aside."""
        return self._is_near(path) and _matches(self.parts, _names(path))

    def may_match_below(self, path: str) -> bool:
        """Something below the path, leaving predicates aside."""
        return self._is_near(path) and _matches_below(self.parts, _names(path))

    def _is_near(self, path: str) -> bool:
        """Cheaply: whether the literal beginning leads to or past the path."""
        above, below = sorted((f"{self.prefix}/", f"{path}/"), key=len)
        return not self.is_property and (self.prefix == "/" or below.startswith(above))


@dataclass(slots=True)
class _Split:
    parts: list[str] = field(default_factory=list)
    conditions: list[str] = field(default_factory=list)
    crashes: bool = False


def _split(text: str) -> _Split:
    found, at, nameless = _Split(), 0, False
    while at < len(text):
        if text.startswith(STRETCH, at):
            found.parts.append(STRETCH)
            at += 2
        elif text[at] == "/":
            found.crashes |= nameless
            at += 1
        end = at
        while end < len(text) and text[end] not in "/{":
            end += 1
        name, at, nameless = text[at:end], end, False
        if text.startswith("{", at):
            end = _closing_brace(text, at)
            found.conditions.append(text[at + 1 : end])
            # `/a//{x}` is `/a//` with a condition: `/a` itself may match (tried on 26.11).
            nameless = not name and found.parts[-1:] == [STRETCH]
            name = name or ("" if nameless else "*")
            at = end + 1
        if name:
            found.parts.append(name)
    return found


def _closing_brace(text: str, at: int) -> int:
    quote = ""
    while at < len(text):
        char = text[at]
        if quote and char == "\\":
            at += 1
        elif quote:
            quote = "" if char == quote else quote
        elif char in "\"'":
            quote = char
        elif char == "}":
            return at
        at += 1
    return at


def _names(path: str) -> tuple[str, ...]:
    return tuple(name for name in path.split("/") if name)


def _matches(parts: tuple[str, ...], names: tuple[str, ...]) -> bool:
    if not parts:
        return not names
    if parts[0] == STRETCH:
        return any(_matches(parts[1:], names[n:]) for n in range(len(names) + 1))
    return bool(names) and fnmatchcase(names[0], parts[0]) and _matches(parts[1:], names[1:])


def _matches_below(parts: tuple[str, ...], names: tuple[str, ...]) -> bool:
    if not parts:
        return False
    if not names or parts[0] == STRETCH:
        return True
    return fnmatchcase(names[0], parts[0]) and _matches_below(parts[1:], names[1:])


class Op(StrEnum):
    PATTERN = "pattern"
    REFERENCE = "reference"
    UNION = "union"
    INTERSECTION = "intersection"
    DIFFERENCE = "difference"
    COMPLEMENT = "complement"
    TOO_DEEP = "too deep"
    """Operators within operators, more than anybody writes: nothing is known of it."""


@dataclass(frozen=True, slots=True)
class Node:
    """A path expression as a tree."""

    op: Op
    parts: tuple[Node, ...] = ()
    pattern: Parsed | None = None
    reference: tuple[str, str] = ("", "")
    """Prim and name of another collection; the prim is empty for one of the same prim."""
    depth: int = 0
    near: _Near | None = None
    """Of a long union: so that not all parts are asked about every path."""

    def _parts_near(self, path: str) -> Iterable[Node]:
        return self.parts if self.near is None else self.near.of(path)

    def patterns(self, adds: bool = True) -> Iterator[tuple[Parsed, bool]]:
        """All patterns, each with whether it puts prims in or takes them out."""
        if self.pattern is not None:
            yield self.pattern, adds
        for index, part in enumerate(self.parts):
            turns = self.op is Op.COMPLEMENT or (self.op is Op.DIFFERENCE and index > 0)
            yield from part.patterns(adds != turns)

    def references(self) -> Iterator[tuple[str, str]]:
        if self.op is Op.REFERENCE:
            yield self.reference
        for part in self.parts:
            yield from part.references()

    def holds(self, path: str) -> bool | None:
        """None where a predicate or another collection decides."""
        match self.op:
            case Op.PATTERN if self.pattern is not None:
                if not self.pattern.may_match(path):
                    return False
                return None if self.pattern.conditions else True
            case Op.UNION:
                return _any(part.holds(path) for part in self._parts_near(path))
            case Op.INTERSECTION:
                return _not(_any(_not(part.holds(path)) for part in self.parts))
            case Op.DIFFERENCE:
                first, *others = (part.holds(path) for part in self.parts)
                return _not(_any((_not(first), *others)))
            case Op.COMPLEMENT:
                return _not(self.parts[0].holds(path))
        return None

    def may_hold_below(self, path: str) -> bool:
        """False only if the expression surely leaves out all that can be below the path."""
        match self.op:
            case Op.PATTERN:
                return self.pattern is not None and self.pattern.may_match_below(path)
            case Op.UNION:
                return any(part.may_hold_below(path) for part in self._parts_near(path))
            case Op.INTERSECTION:
                return all(part.may_hold_below(path) for part in self.parts)
            case Op.DIFFERENCE:
                return self.parts[0].may_hold_below(path)
        return True


class _Near:
    """The parts of a union that can match something at, above or below a path."""

    def __init__(self, parts: Iterable[Node]) -> None:
        self._anywhere: list[Node] = []
        self._at: dict[str, list[Node]] = {}
        self._below: dict[str, list[Node]] = {}
        for part in parts:
            prefix = part.pattern.prefix if part.pattern is not None else "/"
            if prefix == "/":
                self._anywhere.append(part)
                continue
            self._at.setdefault(prefix, []).append(part)
            while prefix := prefix.rpartition("/")[0]:
                self._below.setdefault(prefix, []).append(part)

    def of(self, path: str) -> Iterator[Node]:
        yield from self._anywhere
        yield from self._below.get(path, ())
        while path:
            yield from self._at.get(path, ())
            path = path.rpartition("/")[0]


def _not(one: bool | None) -> bool | None:
    return None if one is None else not one


def _any(found: Iterable[bool | None]) -> bool | None:
    answers = set(found)
    if True in answers:
        return True
    return None if None in answers else False


@dataclass(slots=True)
class _Growing:
    """A node whose operands are not all known yet: a list of thousands grows by one at a time."""

    op: Op
    parts: list[Node]

    def node(self) -> Node:
        depth = 1 + max(part.depth for part in self.parts)
        if depth > _DEEPEST:
            return Node(Op.TOO_DEEP, depth=depth)
        long = self.op is Op.UNION and len(self.parts) > _LONG
        near = _Near(self.parts) if long else None
        return Node(self.op, tuple(self.parts), depth=depth, near=near)


def tree(expression: Sdf.PathExpression) -> Node | None:
    """None for an expression that is empty."""
    made: list[Node | _Growing] = []
    ops = Sdf.PathExpression
    kinds = {
        ops.Complement: Op.COMPLEMENT,
        ops.ImpliedUnion: Op.UNION,
        ops.Union: Op.UNION,
        ops.Intersection: Op.INTERSECTION,
        ops.Difference: Op.DIFFERENCE,
    }

    def grown() -> Node:
        one = made.pop()
        return one.node() if isinstance(one, _Growing) else one

    def logic(op: Any, index: int) -> None:
        # Told before, between and after the operands, which are told in their own turn.
        if op == ops.Complement and index == 1:
            made.append(_Growing(Op.COMPLEMENT, [grown()]).node())
        elif op != ops.Complement and index == 2:
            last, first = grown(), made[-1]
            # `a + b + c` comes as two unions, one in the other: a long list would be a deep tree.
            if isinstance(first, _Growing) and first.op is kinds[op]:
                first.parts.append(last)
            else:
                made.append(_Growing(kinds[op], [grown(), last]))

    def reference(found: Any) -> None:
        made.append(Node(Op.REFERENCE, reference=(str(found.path), str(found.name))))

    def pattern(found: Any) -> None:
        made.append(Node(Op.PATTERN, pattern=Parsed.of(found)))

    expression.Walk(logic, reference, pattern)
    return grown() if made else None
