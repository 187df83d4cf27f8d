"""Which prim specs of a crate file are of a certain type? Answered without a walk from spec to spec,
which costs Python 7 us each: from the tables that the file itself is made of.

Layout of `pxr/usd/sdf/crateFile.cpp` from version 0.4.0 on. Whatever looks otherwise than that is
not answered at all.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterable, Iterator
from itertools import accumulate, chain
from pathlib import Path

from ..crate import tokens_of, unpack
from ..lazily import lazily

_SECTION = struct.Struct("<16sqq")
_COUNT = struct.Struct("<Q")
_KNOWN = ((0, 4), (0, 13))
"""The first version and the last one whose tables have this form."""
_MOST = 1 << 30
_INLINED_TOKEN = 0x400B
"""Upper bits of a value that is an index into the tokens."""
_END_OF_SET = -1
_TYPE_NAME = lazily(b"typeName")
_ASKED = frozenset({b"FIELDS", b"FIELDSETS", b"PATHS", b"SPECS"})
_WIDTHS = "0s", "b", "h", "i"
"""Of a difference, by its two bits. The first stands for the commonest one, and takes no room."""
_FORMATS = tuple(
    "".join(_WIDTHS[byte >> shift & 3] for shift in (0, 2, 4, 6)) for byte in range(256)
)
_CHUNK = 1024
"""Bytes of such bits that are read at once."""
_REFUSED = (OSError, struct.error, ValueError, LookupError, OverflowError, MemoryError)


class CrateTypes:
    """The specs of one file whose type name a pattern matches."""

    def __init__(
        self,
        tokens: bytes,
        sections: dict[bytes, bytes],
        part: re.Pattern[bytes],
        whole: re.Pattern[bytes],
    ) -> None:
        self._sections = sections
        self._tokens = tokens
        types = set(_matching(tokens, part, whole))
        sets = set(self._sets_of(types)) if types else set[int]()
        self._specs = list(self._specs_of(sets)) if sets else []

    @property
    def count(self) -> int:
        return len(self._specs)

    def paths(self) -> list[str] | None:
        """Without variants, sorted. None: the file does not tell."""
        try:
            return self._paths()
        except _REFUSED:
            return None

    def _paths(self) -> list[str]:
        section = _Section(self._sections[b"SPECS"])
        number = section.number()
        of_specs = list(section.integers(number))
        return sorted(set(self._prims_of({of_specs[spec] for spec in self._specs})))

    def _sets_of(self, types: set[int]) -> Iterator[int]:
        """Where the sets of fields begin that have one of the types."""
        section = _Section(self._sections[b"FIELDS"])
        number = section.number()
        names = list(section.integers(number))
        values = struct.unpack(f"<{number}Q", unpack(section.packed(), 8 * number))
        type_name = next(_matching(self._tokens, _TYPE_NAME, _TYPE_NAME), None)
        wanted = set()
        for field, (name, value) in enumerate(zip(names, values, strict=True)):
            if name == type_name:
                if value >> 48 != _INLINED_TOKEN:
                    raise ValueError("a type name that is no token")
                if value & 0xFFFFFFFF in types:
                    wanted.add(field)
        section = _Section(self._sections[b"FIELDSETS"])
        begin = 0
        for at, field in enumerate(section.integers(section.number())):
            if field == _END_OF_SET:
                begin = at + 1
            elif field in wanted:
                yield begin

    def _specs_of(self, sets: set[int]) -> Iterator[int]:
        section = _Section(self._sections[b"SPECS"])
        number = section.number()
        section.packed()  # their paths
        return (spec for spec, one in enumerate(section.integers(number)) if one in sets)

    def _prims_of(self, wanted: set[int]) -> Iterator[str]:
        section = _Section(self._sections[b"PATHS"])
        section.number()  # of all paths, whether or not they are written
        number = section.number()
        indexes, elements, jumps = (section.integers(number) for _ in range(3))
        names: list[int] = []
        """Elements of the path, as far as to the parent of the one that comes next."""
        siblings: list[tuple[int, int]] = []
        """Where paths follow that have not come yet, and the depth of their parent."""
        for at, (index, element, jump) in enumerate(zip(indexes, elements, jumps, strict=True)):
            if index in wanted and element > 0:
                yield self._spelt([*names[1:], element])
            if jump > 0:
                siblings.append((at + jump, len(names)))
            if jump > 0 or jump == -1:
                names.append(element)
            elif jump == -2 and siblings:
                expected, depth = siblings.pop()
                if expected != at + 1:
                    raise ValueError("paths in disorder")
                del names[depth:]

    def _spelt(self, elements: Iterable[int]) -> str:
        tokens = [self._token(element) for element in elements]
        return "/" + "/".join(t for t in tokens if not t.startswith("{"))

    def _token(self, index: int) -> str:
        if not hasattr(self, "_names"):
            self._names = self._tokens.split(b"\0")
        return self._names[index + 1].decode()


def crate_types(
    file: str, pattern: re.Pattern[bytes], part: re.Pattern[bytes] | None = None
) -> CrateTypes | None:
    """The specs whose type the pattern matches. None: the file does not tell.

    `part` is found in each of these names: what begins with a literal is found many times as fast
    among a million others.
    """
    tokens = tokens_of(file)
    if tokens is None:
        return None
    try:
        return CrateTypes(tokens, _sections(file), part or pattern, pattern)
    except _REFUSED:
        return None


def _sections(file: str) -> dict[bytes, bytes]:
    with Path(file).open("rb") as stream:
        bootstrap = stream.read(88)
        first, last = _KNOWN
        if not bootstrap.startswith(b"PXR-USDC") or not first <= tuple(bootstrap[8:10]) <= last:
            raise ValueError("another version")
        stream.seek(*struct.unpack_from("<q", bootstrap, 16))
        (count,) = _COUNT.unpack(stream.read(8))
        listed = [_SECTION.unpack(stream.read(_SECTION.size)) for _ in range(min(count, 64))]
        found = {}
        for name, start, size in listed:
            if not 0 <= size < _MOST:
                raise ValueError("too large")
            if name.rstrip(b"\0") in _ASKED:
                stream.seek(start)
                found[name.rstrip(b"\0")] = stream.read(size)
    return found


def _matching(tokens: bytes, part: re.Pattern[bytes], whole: re.Pattern[bytes]) -> Iterator[int]:
    """Indexes of the tokens in which `part` is found and that `whole` matches."""
    number, counted = 0, 0
    for match in part.finditer(tokens):
        start, end = tokens.rfind(b"\0", 0, match.start()), tokens.find(b"\0", match.start())
        if whole.fullmatch(tokens, start + 1, end):
            number += tokens.count(b"\0", counted, start)
            counted = start
            yield number


class _Section:
    """What stands in one section, one after the other."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    def number(self) -> int:
        (number,) = _COUNT.unpack_from(self._data, self._at)
        self._at += 8
        if number >= _MOST:
            raise ValueError("too many")
        return int(number)

    def packed(self) -> bytes:
        size = self.number()
        packed = self._data[self._at : self._at + size]
        self._at += size
        if len(packed) != size:
            raise ValueError("cut off")
        return packed

    def integers(self, number: int) -> Iterator[int]:
        """`Sdf_IntegerCompression`: the commonest difference, two bits a difference for how it is
        written, and those that differ from the commonest."""
        codes = (2 * number + 7) // 8
        plain = unpack(self.packed(), 4 + codes + 4 * number)
        if len(plain) < 4 + codes:
            raise ValueError("cut off")
        (common,) = struct.unpack_from("<i", plain)
        return accumulate(_differences(plain, number, common, 4 + codes))


def _differences(plain: bytes, number: int, common: int, at: int) -> Iterator[int]:
    return chain.from_iterable(_chunks(plain, number, common, at))


def _chunks(plain: bytes, number: int, common: int, at: int) -> Iterator[list[int]]:
    codes_end = at
    for start in range(4, codes_end, _CHUNK):
        codes = plain[start : min(start + _CHUNK, codes_end)]
        wanted = min(number, 4 * len(codes))
        number -= wanted
        if not any(codes):
            yield [common] * wanted
            continue
        form = "<" + "".join([_FORMATS[byte] for byte in codes])
        found = struct.unpack_from(form, plain, at)
        at += struct.calcsize(form)
        yield [d if d.__class__ is int else common for d in found[:wanted]]
