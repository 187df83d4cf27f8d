"""What is in a usdz package?

As USD looks for it: from header to header, the first of a name counts, and the directory at the end
is not asked. So what USD reads of a damaged package is what is shown of it.
"""

from __future__ import annotations

import mmap
import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import IO

from .lazily import lazily
from .records import dataclass

MAGIC = b"PK\x03\x04"
"""What a package with a file in it begins with, and each file in it."""
_IN_PACKAGE = lazily(r"(.*?\.usdz)\[(.*)\]", re.IGNORECASE | re.DOTALL)
_HEADER = struct.Struct("<4s2xHH8xIIHH")
_ENCRYPTED, _STREAMED = 1, 8
_ZIP64 = 0xFFFFFFFF

Bytes = bytes | mmap.mmap


@dataclass(frozen=True, slots=True)
class _Member:
    name: str
    flags: int
    is_packed: bool
    size: int
    extent: range


def split_package(name: str) -> tuple[str, str | None]:
    """A file, and the member that is meant if it is a package."""
    match = _IN_PACKAGE.fullmatch(name) if name.endswith("]") else None
    return (match[1], match[2]) if match else (name, None)


def first_member(package: str, member: str | None) -> str | None:
    """That of a package, or of a package in it; it is what USD opens."""
    try:
        with Path(package).open("rb") as stream, _mapped(stream) as data:
            if not member:
                return _first(data)
            inner = _found(data, member)
            return _first(data[inner.start : inner.stop]) if inner else None
    except (OSError, ValueError):
        return None


def _first(data: Bytes) -> str | None:
    found = next(_members(data), None)
    if found is None or not found.name.lower().endswith(".usdz"):
        return found.name if found else None
    inner = _first(data[found.extent.start : found.extent.stop])
    return f"{found.name}[{inner}]" if inner else found.name


def bytes_of(package: IO[bytes], member: str) -> bytes | None:
    """A member, which may be in a package that is a member itself."""
    try:
        with _mapped(package) as data:
            found = _found(data, member)
            return None if found is None else data[found.start : found.stop]
    except (OSError, ValueError):
        return None


def extent(package: str, member: str) -> range | None:
    """Where in the file the bytes of a member are."""
    try:
        with Path(package).open("rb") as stream, _mapped(stream) as data:
            return _found(data, member)
    except (OSError, ValueError):
        return None


def unread(package: str) -> str | None:
    """What keeps USD from the first member of a package, though it is whole."""
    try:
        with Path(package).open("rb") as stream:
            found = _header(stream.read(1 << 17), 0)
    except OSError:
        return None
    if found is None:
        return None
    if found.size == _ZIP64:
        return f"'{found.name}' in it is written as zip64, which USD does not read"
    if found.flags & _STREAMED and not found.size:
        return f"'{found.name}' in it has its size behind it, where USD does not look"
    return None


def _mapped(stream: IO[bytes]) -> mmap.mmap:
    """`ValueError` for an empty file."""
    return mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)


def _found(data: Bytes, member: str) -> range | None:
    first, inner = split_package(member)
    found = next((one for one in _members(data) if one.name == first), None)
    if found is None or found.is_packed:
        return None
    at = found.extent
    if inner is None:
        return at
    within = _found(data[at.start : at.stop], inner)
    return range(at.start + within.start, at.start + within.stop) if within is not None else None


def _members(data: Bytes) -> Iterator[_Member]:
    at = 0
    while (found := _header(data, at)) and found.extent.stop <= len(data):
        yield found
        at = found.extent.stop


def _header(data: Bytes, at: int) -> _Member | None:
    if at + _HEADER.size > len(data):
        return None
    mark, flags, method, size, _, name, more = _HEADER.unpack_from(data, at)
    if mark != MAGIC:
        return None
    named = at + _HEADER.size
    start = named + name + more
    return _Member(
        data[named : named + name].decode(errors="replace"),
        flags,
        bool(method or flags & _ENCRYPTED),
        size,
        range(start, start + size),
    )
