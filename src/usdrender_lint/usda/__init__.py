"""Where in the text of a usda layer does an Sdf spec stand?

For places only, never for truth: text that Sdf refuses gets an answer too.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from functools import cached_property
from operator import itemgetter
from typing import TYPE_CHECKING

from ..records import dataclass
from ..results import Span
from .lines import LINE_BREAK, Lines, Range
from .patterns import find_pattern
from .spelling import SpecPath, absolute, decoded, encoded, raw_offset, unescaped

if TYPE_CHECKING:
    from .scan import Block, Scan, Statement

KEYWORDS = {
    "documentation": "doc",
    "inheritPaths": "inherits",
    "layerRelocates": "relocates",
    "subLayerOffsets": "subLayers",
    "variantSelection": "variants",
    "variantSetNames": "variantSets",
}
"""Sdf fields that the text calls by another name."""
ORDERS = {"primOrder": (b"nameChildren", b"rootPrims"), "propertyOrder": (b"properties",)}
SUFFIXES = {
    "default": b"",
    "targetPaths": b"",
    "connectionPaths": b"connect",
    "spline": b"spline",
    "timeSamples": b"timeSamples",
}
"""Fields of a property that are values, and what follows the name in the text."""


@dataclass(frozen=True, slots=True)
class Expression:
    """A path expression as written."""

    path: str
    """Of its attribute, in the layer's namespace."""
    text: str
    span: Span
    string: Range
    """With its quotes."""


@dataclass(frozen=True, slots=True)
class Comment:
    """A comment, and what it may be about."""

    text: str
    """With its mark, as far as its first line goes."""
    line: int
    column: int
    below: int | None
    """The next line that holds more than a comment; None if the comment does not stand alone."""
    path: str
    """The prim in whose text it stands, with its variants; "/" for none."""


class UsdaText:
    """The text of one usda layer. Nothing is read before it is asked for."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._targets: dict[tuple[int, str], dict[str, Range]] = {}
        self._entries: dict[tuple[Range, str], list[Statement]] = {}
        self._arcs: dict[tuple[Range, str], dict[str, list[Range]]] = {}
        self._begins: dict[int, list[tuple[bytes, int]]] = {}
        self._drawn: dict[int, str] = {}
        """Lines that were asked for: thousands of findings may stand in one that is long."""

    @cached_property
    def _scan(self) -> Scan:
        # Its patterns take 15 ms to compile, which a run without findings saves.
        from .scan import Scan

        return Scan(self._data)

    @cached_property
    def _lines(self) -> Lines:
        return Lines(self._data)

    def span(self, path: str, field: str | None = None, target: str | None = None) -> Span | None:
        """Of the entry `target`, else the field's value, the property's name, the prim's name, the
        parent's name and so upward, else the first line. None for an empty text."""
        spans = map(self._span, self._ladder(SpecPath.of(path), field, target))
        return next(filter(None, spans), None)

    def line(self, number: int) -> str:
        """The text of a line, from 1, without its line break."""
        if number not in self._drawn:
            self._drawn[number] = self._text(self._lines.range(number))
        return self._drawn[number]

    def written_target(self, path: str, target: str) -> str | None:
        """The text between the angle brackets of the entry that means `target`."""
        parsed = SpecPath.of(path)
        blocks = self._descend(parsed)
        if parsed.property_name is None or len(blocks) <= len(parsed.steps):
            return None
        entry = self._targets_of(blocks[-1], parsed).get(target)
        return self._text((entry[0] + 1, entry[1] - 1)) if entry else None

    def find(self, word: bytes, start: int = 0) -> int:
        """The offset of a word, -1 for none."""
        return self._data.find(word, start)

    def mentions(self, word: bytes) -> bool:
        return word in self._data

    def comments(self, word: bytes) -> Iterator[Comment]:
        """Those that hold a word. If the text does not hold it at all, that is all that is asked."""
        if word not in self._data:
            return
        below = None
        for start, end in self._scan.comments():
            if self._data.find(word, start, end) >= 0:
                # Of several that follow each other the first has walked to the end.
                if below is None or below <= start:
                    below = self._scan.below((start, end))
                line, line_start = self._lines.at(start)
                yield Comment(
                    decoded(LINE_BREAK.split(self._data[start:end])[0]),
                    line,
                    1 + len(self._text((line_start, start))),
                    None if below is None else self._lines.at(below)[0],
                    self.around(start) or "/",
                )

    def around(self, offset: int) -> str:
        """The innermost prim or variant in whose text or metadata a byte stands; "" for none."""
        path, block = "", self._scan.root
        while True:
            contents = self._scan.contents(block)
            if block.start not in self._begins:  # of prims, in the order of the text
                self._begins[block.start] = list(contents.prims.items())
            begins = self._begins[block.start]
            at = bisect_right(begins, offset, key=itemgetter(1)) - 1
            name = begins[at][0] if at >= 0 else None
            child = None if name is None else self._scan.prim(block, name)
            if name is not None and child and offset < child.end:
                path, block = f"{path}{'' if path.endswith('}') else '/'}{decoded(name)}", child
                continue
            for (of, variant), child in contents.variants.items():
                if variant and child.name[0] <= offset < child.end:
                    path, block = f"{path}{{{decoded(of)}={decoded(variant)}}}", child
                    break
            else:
                return path

    def expressions(self) -> Iterator[Expression]:
        """Every value of every attribute declared `pathExpression`, block by block, and those in
        dictionaries of metadata, of which the prim is told."""
        yield from self._expressions_in("/", self._scan.root.metadata)
        waiting = [("", self._scan.root)]
        while waiting:
            path, block = waiting.pop()
            if path:
                yield from self._expressions_in(path, block.metadata)
            if self._data.find(b"pathExpression", block.start, block.end) < 0:
                continue
            contents = self._scan.contents(block)
            for name in contents.properties:
                for statement in self._scan.property(block, name):
                    yield from self._expressions_of(f"{path}.{decoded(name)}", statement)
                    yield from self._expressions_in(path, statement.metadata)
            children = [
                (f"{path}{'' if path.endswith('}') else '/'}{decoded(name)}", child)
                for name in contents.prims
                if (child := self._scan.prim(block, name))
            ]
            children += [
                (f"{path}{{{decoded(name)}={decoded(variant)}}}", child)
                for (name, variant), child in contents.variants.items()
            ]
            waiting += reversed(children)

    def _expressions_of(self, path: str, statement: Statement) -> Iterator[Expression]:
        declared = self._data[slice(*statement.type)] if statement.type else b""
        if statement.value and declared.partition(b"[")[0].strip() == b"pathExpression":
            for string in self._strings(statement.value):
                if span := self._span(string) or self._span(statement.name):
                    yield Expression(path, self._string(string), span, string)

    def _expressions_in(self, path: str, metadata: Range | None) -> Iterator[Expression]:
        if metadata is None or self._data.find(b"pathExpression", *metadata) < 0:
            return
        waiting = [one.value for one in self._scan.metadata(metadata) if one.value]
        while waiting:
            for entry in self._scan.dictionary(waiting.pop(0)):
                yield from self._expressions_of(path, entry)
                if entry.value:
                    waiting.append(entry.value)

    def _strings(self, value: Range, depth: int = 2) -> Iterator[Range]:
        """The strings of a value: itself, in a list, in time samples, in lists in time samples."""
        for start, end in self._scan.items(value):
            if self._data[start] in b"\"'":
                yield start, end
            elif self._data[start] in b"[{" and depth:
                yield from self._strings((start + 1, end - 1), depth - 1)

    def _patterns(self, value: Range, pattern: str, path: SpecPath) -> Iterator[Range]:
        """One pattern of an expression."""
        for string in self._strings(value):
            if found := find_pattern(self._string(string), pattern, path.owner):
                yield self._within(string, *found)

    def in_expression(self, path: str, text: str, start: int) -> Span | None:
        """What an expression says from one of its characters on, as far as the line goes; the mark
        that ends it for the character behind its last."""
        for expression in self.expressions():
            if (expression.path, expression.text) == (path, text):
                first, last = self._within(expression.string, start, len(text))
                line_end = LINE_BREAK.search(self._data, first, last)
                end = line_end.start() if line_end else last
                return self._span((first, max(end, first + 1)))
        return None

    def _within(self, string: Range, start: int, end: int) -> Range:
        """Of characters of a string, which may be escaped in the text."""
        raw, text = self._scan.unquoted(string), self._string(string)
        first = string[0] + (string[1] - string[0] - len(raw)) // 2
        before, here = (len(encoded(part)) for part in (text[:start], text[start:end]))
        return first + raw_offset(raw, before), first + raw_offset(raw, before + here)

    # The ladder

    def _ladder(self, path: SpecPath, field: str | None, target: str | None) -> Iterator[Range]:
        """Stretches of the text from the one that is asked for to the first line."""
        blocks = self._descend(path)
        if len(blocks) > len(path.steps):
            if path.property_name is not None:
                yield from self._in_property(blocks[-1], path, field, target)
            elif field:
                yield from self._in_prim(blocks[-1], path, field, target)
        for block in reversed(blocks):
            yield block.name

    def _descend(self, path: SpecPath) -> list[Block]:
        """The layer and the blocks along a path, as far as they exist."""
        blocks = [self._scan.root]
        for step in path.steps:
            names = tuple(map(encoded, step))
            if len(names) == 2:
                block = self._scan.contents(blocks[-1]).variants.get((names[0], names[1]))
            else:
                block = self._scan.prim(blocks[-1], names[0])
            if block is None:
                break
            blocks.append(block)
        return blocks

    def _in_prim(
        self, block: Block, path: SpecPath, field: str, target: str | None
    ) -> Iterator[Range]:
        if field in ORDERS:
            orders = self._scan.contents(block).orders
            for statement in (orders[name] for name in ORDERS[field] if name in orders):
                yield from _value_or_name(statement)
        elif field in ("specifier", "typeName"):
            word = block.specifier if field == "specifier" else block.type
            if word:
                yield word
        elif block.metadata:
            yield from self._in_metadata(block.metadata, path, field, target)

    def _in_property(
        self, block: Block, path: SpecPath, field: str | None, target: str | None
    ) -> Iterator[Range]:
        statements = self._statements(block, path)
        if target and field in (None, "targetPaths", "connectionPaths"):
            entry = self._targets_of(block, path).get(target)
            if entry:
                yield entry
        if target and field == "default":
            for statement in statements:
                if statement.value and not statement.suffix:
                    yield from self._patterns(statement.value, target, path)
        if field:
            for statement in statements:
                yield from self._in_statement(statement, path, field, target)
        for statement in statements:
            yield statement.name

    def _in_statement(
        self, statement: Statement, path: SpecPath, field: str, target: str | None
    ) -> Iterator[Range]:
        if field in SUFFIXES:
            if statement.value and statement.suffix == SUFFIXES[field]:
                yield from _value_or_name(statement)
        elif field in ("custom", "typeName", "variability"):
            words = {"custom": statement.custom, "typeName": statement.type}
            word = words.get(field, statement.variability)
            if word and self._data[slice(*word)] != b"rel":
                yield word
        elif statement.metadata:
            yield from self._in_metadata(statement.metadata, path, field, target)

    def _in_metadata(
        self, inside: Range, path: SpecPath, field: str, target: str | None
    ) -> Iterator[Range]:
        key, _, rest = field.partition(":")
        keyword = KEYWORDS.get(key, key)
        entries = self._entries_of(inside, keyword)
        if target:
            yield from self._arcs_of(inside, keyword, entries, path).get(target, ())
        for entry in entries:
            if rest and entry.value:
                for found in self._in_dictionary(entry.value, rest):
                    strings = self._strings(found) if target else ()
                    yield from (s for s in strings if self._string(s) == target)
                    yield found
            yield from _value_or_name(entry)

    def _keyword(self, entry: Statement) -> str:
        """A comment is a bare string."""
        return "comment" if entry.name == entry.value else self._text(entry.name)

    def _in_dictionary(self, value: Range, key: str) -> Iterator[Range]:
        """The entry of a key; `a:b` is the key `a:b`, or `b` in the dictionary `a`."""
        waiting = [(value, key)]
        while waiting:
            value, key = waiting.pop()
            for entry in self._scan.dictionary(value):
                name = self._text(entry.name)
                if name[0] in "\"'":
                    name = self._string(entry.name)
                if name == key:
                    yield from _value_or_name(entry)
                elif key.startswith(name + ":") and entry.value:
                    waiting.append((entry.value, key[len(name) + 1 :]))

    # Values

    def _statements(self, block: Block, path: SpecPath) -> list[Statement]:
        """The statements of a property; those that take something away last."""
        name = encoded(path.property_name or "")
        return sorted(self._scan.property(block, name), key=_removes)

    def _targets_of(self, block: Block, path: SpecPath) -> dict[str, Range]:
        """The entries of a property's lists by the absolute path that they mean."""
        key = block.start, path.property_name or ""
        if key not in self._targets:
            self._targets[key] = {}
            for statement in self._statements(block, path):
                for entry in self._elements(statement):
                    if self._data[entry[0]] == 0x3C:
                        self._targets[key].setdefault(self._leads_to(entry, path), entry)
        return self._targets[key]

    def _elements(self, statement: Statement) -> Iterator[Range]:
        """The elements of a list, or the one value that stands for a list."""
        if statement.value:
            start, end = statement.value
            listed = self._data[start] == 0x5B
            yield from self._scan.items((start + 1, end - 1) if listed else (start, end))

    def _entries_of(self, inside: Range, keyword: str) -> list[Statement]:
        """Those of a keyword; what takes something away last. Of one with thousands of arcs each arc
        is asked for."""
        key = inside, keyword
        if key not in self._entries:
            found = [e for e in self._scan.metadata(inside) if self._keyword(e) == keyword]
            self._entries[key] = sorted(found, key=_removes)
        return self._entries[key]

    def _arcs_of(
        self, inside: Range, keyword: str, entries: list[Statement], path: SpecPath
    ) -> dict[str, list[Range]]:
        """The arcs in the lists of some metadata, by what they may be called."""
        key = inside, keyword
        if key not in self._arcs:
            found = self._arcs[key] = {}
            for arc in (arc for entry in entries for arc in self._elements(entry)):
                for meaning in self._meanings(arc, path):
                    found.setdefault(meaning, []).append(arc)
        return self._arcs[key]

    def _meanings(self, arc: Range, path: SpecPath) -> tuple[str, ...]:
        """What an arc may be called: its asset, and its asset and prim."""
        asset = self._leads_to(arc, path)
        inner = self._scan.prim_of(arc)
        return (asset, f"{asset}<{self._text(inner)}>") if inner else (asset,)

    def _leads_to(self, arc: Range, path: SpecPath) -> str:
        """The asset of an arc as authored; without one the prim or property."""
        asset = self._scan.asset(arc)
        if asset is not None:
            return decoded(asset.replace(rb"\@@@", b"@@@"))
        return absolute(self._text((arc[0] + 1, arc[1] - 1)), path.owner)

    # Text

    def _string(self, string: Range) -> str:
        return decoded(unescaped(self._scan.unquoted(string)))

    def _text(self, stretch: Range) -> str:
        return decoded(self._data[slice(*stretch)])

    def _span(self, stretch: Range) -> Span | None:
        """None for what goes over several lines, and for an empty text."""
        start, end = stretch
        if not self._data or LINE_BREAK.search(self._data, start, end):
            return None
        number, line_start = self._lines.at(start)
        column = 1 + len(self._text((line_start, start)))
        return Span(number, column, column + len(self._text(stretch)))


def _removes(statement: Statement) -> bool:
    return statement.operation in (b"delete", b"reorder")


def _value_or_name(statement: Statement) -> Iterator[Range]:
    if statement.value:
        yield statement.value
    yield statement.name
