"""What do the text layers of a stage say literally?"""

from __future__ import annotations

import mmap
import os

from pxr import Sdf, Usd

from ..handed import bytes_at
from ..model import Site
from ..packages import bytes_of, first_member, split_package
from ..sites import find
from ..usda import UsdaText

_BINARY = (b"PXR-USDC", b"PK\x03\x04")
_LITTLE = 1 << 16
"""Bytes of a text that is read rather than looked through in its file."""
_ROOM = 1 << 22
"""Bytes of texts that are kept though nothing but a word of them was asked about."""


class Texts:
    """Texts of layers, each read and parsed at most once a stage, and only when asked for."""

    def __init__(self) -> None:
        self._known: dict[str, UsdaText | None] = {}
        self._full_names: dict[str, str] = {}
        self._room = _ROOM
        self._words: dict[tuple[str, bytes], bool | None] = {}

    def of(self, layer: Sdf.Layer) -> UsdaText | None:
        """None for a binary layer or one without a file."""
        return self.of_file(layer.realPath)

    def file_of(self, layer: Sdf.Layer) -> str:
        return self.full_name(layer.realPath or layer.identifier)

    def full_name(self, file: str) -> str:
        """`package.usdz[member]` for a package, which to USD is its first member."""
        outermost = file.rstrip("]")
        if not outermost.lower().endswith(".usdz"):
            return file
        if file not in self._full_names:
            first = first_member(*split_package(file))
            closing = file[len(outermost) :]
            self._full_names[file] = f"{outermost}[{first}]{closing}" if first else file
        return self._full_names[file]

    def of_file(self, file: str) -> UsdaText | None:
        file = self.full_name(file)
        if file not in self._known:
            data = text_of(file)
            self._known[file] = None if data is None else UsdaText(data)
        return self._known[file]

    def mention(self, file: str, word: bytes) -> bool | None:
        """Whether the text of a layer holds a word; None for a binary layer, or one that cannot be
        read. That alone does not keep the text of a large one: there may be more of them than fit
        into memory."""
        file = self.full_name(file)
        key = file, word
        if key not in self._words:
            self._words[key] = self._mention(file, word)
        return self._words[key]

    def _mention(self, file: str, word: bytes) -> bool | None:
        if file not in self._known:
            found = _text_or(file, word)
            if isinstance(found, bool):
                return found
            if found is not None:
                if len(found) > self._room:
                    return word in found
                self._room -= len(found)
            self._known[file] = None if found is None else UsdaText(found)
        text = self._known[file]
        return None if text is None else text.mentions(word)

    def written_target(self, stage: Usd.Stage, site: Site) -> str | None:
        """The text between the angle brackets of one entry of a relationship's list."""
        spot = find(stage, site)
        text = self.of(spot.layer)
        if text is None or spot.target is None:
            return None
        return text.written_target(spot.path, spot.target)


def _text_or(name: str, word: bytes) -> bytes | bool | None:
    """The bytes of a usda layer, None if it is binary or cannot be read; of a large one only whether
    it holds the word."""
    if name.endswith("]"):
        return text_of(name)
    try:
        with open(bytes_at(name), "rb", buffering=0) as stream:
            head = stream.read(8)
            if head.startswith(_BINARY):
                return None
            if os.fstat(stream.fileno()).st_size <= _LITTLE:
                return head + stream.read()
            with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as whole:
                return whole.find(word) >= 0
    except OSError:
        return None


def text_of(name: str) -> bytes | None:
    """The bytes of a usda layer: by what they are, for `.usd` may be text or crate. The layer may be
    a member of a package, also of one in a package."""
    file, member = split_package(name)
    try:
        with open(bytes_at(file), "rb", buffering=0) as stream:
            if member:
                found = bytes_of(stream, member)
                return None if found is None or found.startswith(_BINARY) else found
            if stream.read(8).startswith(_BINARY):
                return None
            stream.seek(0)
            return stream.read()
    except OSError:
        return None
