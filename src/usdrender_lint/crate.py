"""Which words does a crate file hold at all? Answered from its table of tokens, mostly in 0.1 ms."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterable
from functools import lru_cache
from typing import BinaryIO

from .handed import bytes_at

MAGIC = b"PXR-USDC"
"""What every crate begins with."""
_SECTION = struct.Struct("<16sqq")
_MAX_TOKENS = 1 << 28
_SHORT = 1 << 16
"""Bytes of a table of tokens that is unpacked in 4 ms."""
_LITTLE = 1 << 20
"""Bytes of a crate, of which the tokens of several are kept."""


def mentions(file: str, words: Iterable[bytes], *, whole: bool = True) -> bool | None:
    """Whether one of `words` is a token of the crate, or without `whole` begins one; None if the
    file tells nothing."""
    tokens = tokens_of(file)
    if tokens is None:
        return None
    end = b"\0" if whole else b""
    return any(b"\0" + word + end in tokens for word in words)


def tokens_of(file: str, most: int = _MAX_TOKENS) -> bytes | None:
    """All tokens of a crate, each between two zeros; None if the file tells nothing, or more than
    `most` bytes.

    Layout of `pxr/usd/sdf/crateFile.cpp` since version 0.4.0: the bootstrap's table of contents
    names the TOKENS section, which is zero-terminated strings under LZ4.
    """
    file = bytes_at(file)
    try:
        at = os.stat(file)
        version = at.st_ino, at.st_mtime_ns, at.st_size
        asked = _tokens_of_little if at.st_size < _LITTLE else _tokens_of_large
        tokens = asked(file, most, version)
    except (OSError, struct.error, IndexError, ValueError):
        return None
    return tokens


def _tokens_in(file: str, most: int, _version: tuple[int, ...]) -> bytes | None:
    with open(file, "rb") as stream:
        table = _table(stream, 0, most)
    return b"\0" + table[0] if table is not None and len(table[0]) == table[1] else None


# Several questions are asked of one crate, one soon after the other.
_tokens_of_little = lru_cache(maxsize=8)(_tokens_in)
_tokens_of_large = lru_cache(maxsize=1)(_tokens_in)


def is_torn(file: str, base: int = 0) -> bool:
    """Whether a crate, which begins at `base` of a file, has a table of tokens that holds less than
    it announces. USD then reads on in whatever its memory holds: it may refuse the crate at one run
    and not at the next (26.11). Not asked of large tables."""
    try:
        with open(bytes_at(file), "rb") as stream:
            table = _table(stream, base, _SHORT)
    except (OSError, struct.error, IndexError, ValueError):
        return False
    return table is not None and len(table[0]) < table[1]


def forget_large() -> None:
    """Where nobody will ask again: there may be 200 MB of them."""
    _tokens_of_large.cache_clear()


def _table(stream: BinaryIO, base: int, most: int) -> tuple[bytes, int] | None:
    """The tokens, and how many bytes of them are announced."""
    read, seek = stream.read, stream.seek
    seek(base)
    bootstrap = read(88)
    if not bootstrap.startswith(MAGIC) or tuple(bootstrap[8:11]) < (0, 4, 0):
        return None
    seek(base + struct.unpack_from("<q", bootstrap, 16)[0])
    (count,) = struct.unpack("<Q", read(8))
    for _ in range(min(count, 64)):
        name, start, _size = _SECTION.unpack(read(_SECTION.size))
        if name.rstrip(b"\0") == b"TOKENS":
            seek(base + start)
            _number, plain_size, packed_size = struct.unpack("<QQQ", read(24))
            if plain_size > most or packed_size > most:
                return None
            return unpack(read(packed_size), plain_size), plain_size
    return None


def unpack(packed: bytes, size: int) -> bytes:
    """Undo `TfFastCompression`: a count of chunks (0: one chunk, no sizes), then LZ4 blocks."""
    chunks = packed[0]
    if not chunks:
        return _lz4(packed[1:], size)
    out, at = b"", 1
    for _ in range(chunks):
        (length,) = struct.unpack_from("<i", packed, at)
        out += _lz4(packed[at + 4 : at + 4 + length], size)
        at += 4 + length
    return out


def _lz4(block: bytes, size: int) -> bytes:
    out = bytearray()
    at, end, done = 0, len(block), 0
    while at < end and done <= size:
        token = block[at]
        at += 1
        if literals := token >> 4:
            if literals == 15:
                at, literals = _more(block, at, literals)
            out += block[at : at + literals]
            at += literals
            done += literals
        if at >= end:
            break
        distance = block[at] | block[at + 1] << 8
        at += 2
        length = token & 15
        if length == 15:
            at, length = _more(block, at, length)
        length += 4
        start = done - distance
        if distance <= 0 or start < 0:
            raise ValueError("a match before the beginning")
        if distance >= length:
            out += out[start : start + length]
        else:
            pattern = bytes(out[start:])
            out += (pattern * (length // distance + 1))[:length]
        done += length
    return bytes(out)


def _more(block: bytes, at: int, length: int) -> tuple[int, int]:
    while True:
        byte = block[at]
        at += 1
        length += byte
        if byte != 255:
            return at, length
