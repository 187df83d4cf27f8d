"""Where do the prims, variants and statements of a usda text begin and end?

Offsets in bytes, no values and no paths: `usda` makes those out of it. The text is never
parsed as a whole. One pass notes which braces belong together, and from then on a prim is
entered or stepped over at will; strings, comments and asset paths are skipped as Sdf's own
grammar (`pxr/usd/sdf/textFileFormatParser.h`) reads them, so a decoy in one of them is none.
Text that Sdf would refuse gives some answer in time linear to its length.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import field
from functools import cached_property

from ..lazily import lazily
from ..records import dataclass
from .lines import LINE_BREAK, Range

# Every repetition is possessive and every closing mark optional: what is not closed runs to
# its end, once. Otherwise each stray mark would cost a walk through the rest of the text.
STRING = (
    rb'(?:"""(?:[^"\\]++|\\.|"(?!""))*+(?:""")?+'
    rb"|'''(?:[^'\\]++|\\.|'(?!''))*+(?:''')?+"
    rb'|"(?:[^"\\\r\n]++|\\[^\r\n])*+"?+'
    rb"|'(?:[^'\\\r\n]++|\\[^\r\n])*+'?+)"
)
ASSET = rb"(?:@@@(?:[^@\\\r\n]++|\\@@@|\\|@(?!@@))*+(?:@@@@{0,2}+)?+|@[^@\r\n]*+@?+)"
PRIM_PATH = rb"<[^<>\r\n]*+>"
BLOCK_COMMENT = rb"/\*(?:[^*]++|\*(?!/))*+(?:\*/)?+"
COMMENT = rb"(?:#[^\r\n]*+|//[^\r\n]*+|" + BLOCK_COMMENT + rb")"
OPAQUE = rb"|" + STRING + rb"|" + ASSET + rb"|" + COMMENT + rb"|/)*+"
PAD = rb"(?:[\s;]++|" + COMMENT + rb")*+"
SPACE = rb"(?:[ \t]++|" + BLOCK_COMMENT + rb")*+"
GAP = rb"(?:[ \t]++|" + BLOCK_COMMENT + rb")++"

# Bytes beyond ASCII are let through: Sdf has already judged which of them make identifiers.
WORD = rb"[A-Za-z_\x80-\xff][\w\x80-\xff]*+"
TYPE = WORD + rb"(?:::" + WORD + rb")*+"
OPERATION = rb"(?:(?P<operation>add|append|prepend|delete|reorder)" + GAP + rb")?"

SEPARATORS = lazily(PAD)
NEXT_BRACE = lazily(  # or a long stretch without any mark
    rb"(?:[^{}\"'#@/]{1,256}+(?=[{}\"'#@/]|\Z)" + OPAQUE + rb"([{}]|\Z|)", re.S
)
MARKS = (b"{", b"}", b'"', b"'", b"#", b"@", b"/")
NEXT_OF_KIND = {
    b"(": lazily(rb"(?:[^()\"'#@/]++" + OPAQUE + rb"([()]|\Z)", re.S),
    b"[": lazily(rb"(?:[^\]\[\"'#@/]++" + OPAQUE + rb"([\]\[]|\Z)", re.S),
}
NEXT_COMMENT = lazily(
    rb"(?:[^\"'#@/]++|" + STRING + rb"|" + ASSET + rb"|/(?![/*]))*+(" + COMMENT + rb"|\Z)", re.S
)
NEXT_CODE = lazily(  # comments that have their lines for themselves are passed over
    rb"(?:[ \t]*+(?:\r\n|\n|\r)[ \t]*+" + COMMENT + rb")*[ \t]*+(?:\r\n|\n|\r)", re.S
)
REST_OF_STATEMENT = lazily(rb"(?:[^\]\[(){}\r\n;\"'#@/]++" + OPAQUE, re.S)
ITEM = lazily(  # an asset and the prim in it are one item: an arc
    rb"(?:[\s,:;]++|" + COMMENT + rb")*+(?P<item>" + STRING + rb"|" + ASSET + rb"(?:" + SPACE
    + PRIM_PATH + rb")?+|" + PRIM_PATH + rb"|[({\[]|[^\]\[(){}<>\s,:;\"'@#=/]++)",
    re.S,
)  # fmt: skip
LEADING_ASSET = lazily(ASSET)

# Metadata without parentheses of its own is taken along: the way through many siblings is short.
BODY = PAD + rb"(?:\((?P<metadata>(?:[^()\"'#@/]++" + OPAQUE + rb")\)" + PAD + rb")?(?P<open>[({])"
PRIM = lazily(
    rb"(?P<specifier>def|over|class)" + GAP + rb"(?:(?P<type>" + TYPE + rb"(?:" + SPACE + rb"\."
    + SPACE + TYPE + rb")*+)" + GAP + rb")?(?P<name>" + STRING + rb")" + BODY,
    re.S,
)  # fmt: skip
VARIANT_SET = lazily(
    rb"variantSet" + GAP + rb"(?P<name>" + STRING + rb")" + PAD + rb"=" + PAD + rb"(?P<open>\{)",
    re.S,
)
VARIANT = lazily(rb"(?P<name>" + STRING + rb")" + BODY, re.S)
ORDER = lazily(rb"reorder" + GAP + rb"(?P<name>nameChildren|properties|rootPrims)" + SPACE)
PROPERTY = lazily(
    OPERATION + rb"(?:(?P<custom>custom)" + GAP + rb")?"
    rb"(?:(?P<variability>uniform|config|varying)" + GAP + rb")?"
    rb"(?P<type>" + TYPE + rb"(?:" + SPACE + rb"\[" + SPACE + rb"\])?)" + GAP + rb"(?P<name>" + WORD
    + rb"(?::" + WORD + rb")*+)"
    + SPACE + rb"(?:\." + SPACE + rb"(?P<suffix>timeSamples|connect|spline|default)\b" + SPACE
    + rb")?",
)  # fmt: skip
METADATA = lazily(OPERATION + rb"(?P<name>" + TYPE + rb")" + SPACE)
DICTIONARY = lazily(
    rb"(?P<type>" + TYPE + rb"(?:" + SPACE + rb"\[" + SPACE + rb"\])?)" + GAP
    + rb"(?P<name>" + STRING + rb"|" + WORD + rb")" + SPACE,
    re.S,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Block:
    """A prim, a variant, a variant set or the layer."""

    start: int
    """Of what stands between the braces."""
    end: int
    name: Range
    """With its quotes; of the layer its first line."""
    specifier: Range | None = None
    type: Range | None = None
    metadata: Range | None = None
    """What stands between the parentheses."""


@dataclass(frozen=True, slots=True)
class Statement:
    """One statement of a prim, of its metadata or of a dictionary."""

    name: Range
    operation: bytes = b""
    """`prepend`, `delete` ..., empty for none."""
    custom: Range | None = None
    variability: Range | None = None
    type: Range | None = None
    suffix: bytes = b""
    """Of an attribute: `timeSamples`, `connect`, `spline`."""
    value: Range | None = None
    metadata: Range | None = None


@dataclass(frozen=True, slots=True)
class Contents:
    """What a block holds itself."""

    prims: dict[bytes, int] = field(default_factory=dict)
    """Offset of the header by name: a layer may have a million of them."""
    variants: dict[tuple[bytes, bytes], Block] = field(default_factory=dict)
    """By set and variant; the set itself under an empty variant."""
    properties: dict[bytes, list[Range]] = field(default_factory=dict)
    """Their statements, which are read when they are asked for."""
    orders: dict[bytes, Statement] = field(default_factory=dict)


class Scan:
    """The text of one layer."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._contents: dict[int, Contents] = {}
        self._prims: dict[int, Block | None] = {}
        self.root = self._root()

    @cached_property
    def _closing(self) -> dict[int, int]:
        """Where each opened brace is closed. The metadata of the layer is read without."""
        data = self._data
        closing: dict[int, int] = {}
        waiting: list[int] = []
        position, nearest = 0, dict.fromkeys(MARKS, 0)
        while position < len(data):
            match = NEXT_BRACE.match(data, position)
            assert match, "the pattern matches the empty text"  # noqa: S101 for mypy
            position = match.end()
            if match[1] == b"{":
                waiting.append(position - 1)
            elif match[1]:
                if waiting:
                    closing[waiting.pop()] = position - 1
            elif position < len(data):
                # A long stretch of numbers: to look for one mark after the other is ten times as
                # fast as to look at every byte for all of them. None is looked for twice.
                for mark, at in nearest.items():
                    if at < position:
                        found = data.find(mark, position)
                        nearest[mark] = found if found >= 0 else len(data)
                position = min(nearest.values())
        return closing

    def _root(self) -> Block:
        first = LINE_BREAK.search(self._data)
        line = self._data[: first.start() if first else None]
        start, metadata = self._skip(0), None
        if self._data[start : start + 1] == b"(":
            metadata = self._inside(start)
            start = metadata[1] + 1
        return Block(start, len(self._data), (0, len(line.rstrip())), metadata=metadata)

    def comments(self) -> Iterator[Range]:
        """With their marks; those to the end of a line without its line break."""
        for match in NEXT_COMMENT.finditer(self._data):
            if match[1]:
                yield match.span(1)

    def below(self, comment: Range) -> int | None:
        """Where the line below a comment begins, or below those that follow it; None if the comment
        shares its line with anything else."""
        start, end = comment
        break_before = max(self._data.rfind(b"\n", 0, start), self._data.rfind(b"\r", 0, start))
        # The first line is the header, a comment only by its mark.
        if break_before < 0 or self._data[break_before + 1 : start].strip():
            return None
        match = NEXT_CODE.match(self._data, end)
        return match.end() if match else None

    def _skip(self, start: int, end: int | None = None) -> int:
        """Past blanks, line breaks, semicolons and comments."""
        match = SEPARATORS.match(self._data, start, len(self._data) if end is None else end)
        assert match, "the pattern matches the empty text"  # noqa: S101 for mypy
        return match.end()

    def _inside(self, start: int) -> Range:
        """What stands between the bracket at `start` and the one that closes it."""
        kind = self._data[start : start + 1]
        if kind not in NEXT_OF_KIND:
            return start + 1, self._closing.get(start, len(self._data))
        depth, position = 0, start
        while match := NEXT_OF_KIND[kind].match(self._data, position):
            if not match[1]:
                break
            position = match.end()
            depth += 1 if match[1] == kind else -1
            if depth == 0:
                return start + 1, position - 1
        return start + 1, len(self._data)

    def _body(self, header: re.Match[bytes]) -> tuple[int, Range | None]:
        """Where the brace after a header stands, and the metadata before it."""
        opening = header.start("open")
        if self._data[opening] == 0x7B:
            return opening, header.span("metadata") if header["metadata"] is not None else None
        metadata = self._inside(opening)
        return self._skip(metadata[1] + 1), metadata

    def _block(self, header: re.Match[bytes]) -> Block:
        opening, metadata = self._body(header)
        found = {name: header.span(name) for name, text in header.groupdict().items() if text}
        return Block(
            *self._inside(opening),
            found["name"],
            found.get("specifier"),
            found.get("type"),
            metadata,
        )

    def prim(self, parent: Block, name: bytes) -> Block | None:
        start = self.contents(parent).prims.get(name)
        if start is None:
            return None
        if start not in self._prims:
            match = PRIM.match(self._data, start)
            self._prims[start] = self._block(match) if match else None
        return self._prims[start]

    def contents(self, block: Block) -> Contents:
        if block.start not in self._contents:
            self._contents[block.start] = self._read_contents(block)
        return self._contents[block.start]

    def _read_contents(self, block: Block) -> Contents:
        contents = Contents()
        position = self._skip(block.start, block.end)
        while position < block.end:
            start = position
            if match := PRIM.match(self._data, start, block.end):
                contents.prims.setdefault(self.unquoted(match.span("name")), start)
                position = self._inside(self._body(match)[0])[1] + 1
            elif match := VARIANT_SET.match(self._data, start, block.end):
                position = self._read_variants(match, contents) + 1
            else:
                position = self._statement_end(start, block.end)
                self._read_statement(start, position, contents)
            position = self._skip(max(position, start + 1), block.end)
        return contents

    def _read_variants(self, header: re.Match[bytes], contents: Contents) -> int:
        """Adds the variants of a set, and says where the set ends."""
        start, end = self._inside(header.start("open"))
        name = self.unquoted(header.span("name"))
        contents.variants.setdefault((name, b""), Block(end, end, header.span("name")))
        position = self._skip(start, end)
        while match := VARIANT.match(self._data, position, end):
            child = self._block(match)
            contents.variants.setdefault((name, self.unquoted(child.name)), child)
            position = self._skip(child.end + 1, end)
        return end

    def _read_statement(self, start: int, end: int, contents: Contents) -> None:
        if match := ORDER.match(self._data, start, end):
            statement = self._statement(match, end)
            contents.orders.setdefault(match["name"], statement)
        elif match := PROPERTY.match(self._data, start, end):
            contents.properties.setdefault(match["name"], []).append((start, end))

    def property(self, block: Block, name: bytes) -> Iterator[Statement]:
        """The statements of a property."""
        for start, end in self.contents(block).properties.get(name, ()):
            if match := PROPERTY.match(self._data, start, end):
                yield self._statement(match, end, of_property=True)

    def metadata(self, inside: Range) -> Iterator[Statement]:
        """The entries of a block of metadata. A bare string is its own name."""
        for start, end in self._statements(inside):
            if match := METADATA.match(self._data, start, end):
                yield self._statement(match, end)
            elif first := next(self.items((start, end)), None):
                yield Statement(first, value=first)

    def dictionary(self, value: Range) -> Iterator[Statement]:
        """The entries of a dictionary; none of another value."""
        if self._data[value[0] : value[0] + 1] == b"{":
            for start, end in self._statements((value[0] + 1, value[1] - 1)):
                if match := DICTIONARY.match(self._data, start, end):
                    yield self._statement(match, end)

    def items(self, inside: Range) -> Iterator[Range]:
        """The values in a list, a dictionary or a statement; bracketed ones as a whole."""
        position, end = inside
        while match := ITEM.match(self._data, position, end):
            start, position = match.span("item")
            if self._data[start] in b"([{":
                position = min(self._inside(start)[1] + 1, end)
            yield start, position

    def asset(self, arc: Range) -> bytes | None:
        """What stands between the `@`s of an arc; None for one within the layer."""
        match = LEADING_ASSET.match(self._data, *arc)
        return self.unquoted(match.span()) if match else None

    def prim_of(self, arc: Range) -> Range | None:
        """The prim in the asset of an arc, without its brackets."""
        match = LEADING_ASSET.match(self._data, *arc)
        start = self._data.find(b"<", match.end(), arc[1]) if match else -1
        return (start + 1, arc[1] - 1) if start >= 0 else None

    def unquoted(self, string: Range) -> bytes:
        """What stands between the quotes, or the `@`s, of a string; escapes are left alone."""
        start, end = string
        tripled = self._data[start : start + 3] in (b'"""', b"'''", b"@@@") and end > start + 5
        marks = 3 if tripled else 1
        return self._data[start + marks : end - marks]

    def _statements(self, inside: Range) -> Iterator[Range]:
        position = self._skip(*inside)
        while position < inside[1]:
            end = max(self._statement_end(position, inside[1]), position + 1)
            yield position, end
            position = self._skip(end, inside[1])

    def _statement_end(self, start: int, end: int) -> int:
        """A statement ends with its line or a semicolon, unless a bracket is open."""
        position = start
        while match := REST_OF_STATEMENT.match(self._data, position, end):
            position = match.end()
            if position >= end or self._data[position] not in b"([{":
                break
            position = min(self._inside(position)[1] + 1, end)
        return position

    def _statement(
        self, head: re.Match[bytes], end: int, *, of_property: bool = False
    ) -> Statement:
        """What follows a head: a value, which in metadata may be several items, and metadata."""
        words = head.groupdict()
        found = {name: head.span(name) for name, word in words.items() if word}
        assigned = self._data[head.end() : head.end() + 1] == b"="
        items = list(self.items((head.end() + assigned, end)))
        value = metadata = None
        if assigned and items:
            value = items[0][0], items[0 if of_property else -1][1]
        after = items[assigned] if of_property and len(items) > assigned else None
        if after and self._data[after[0]] == 0x28:
            metadata = after[0] + 1, after[1] - 1
        return Statement(
            found["name"],
            words.get("operation") or b"",
            found.get("custom"),
            found.get("variability"),
            found.get("type"),
            words.get("suffix") or b"",
            value,
            metadata,
        )
