"""Which files does a layer bring in, told by its bytes?

A stage of thousands of layers need not be opened to learn that it does not use the one that is
asked about. Sublayers are followed to the last, and so is what stands on prims in layers that name a
render scope; elsewhere a reference counts only if it leads to a file that is asked about. It may be
one that composition does not use: that, the opened stage tells.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field
from pathlib import Path

from .crate import tokens_of
from .discover import USD_SUFFIXES, RealPaths
from .handed import bytes_at
from .lazily import lazily
from .records import dataclass

_ASSET = lazily(rb"@(?=([^@\r\n]*+)@)")
"""Whatever stands between two marks of a line: a stray one, as of a comment, shifts no others."""
_TRIPLED = lazily(rb"@@@([^\r\n]*?)@@@")
_SUFFIXES = tuple(suffix.encode() for suffix in USD_SUFFIXES)
_HEAD = 64 * 1024
"""Bytes in which the metadata of a text layer mostly ends."""
_MANY = 64
"""Assets of one layer that are followed. A layer that brings in more is opened instead."""
_MOST_TOKENS = 1 << 17
"""Bytes of names in a crate; to unpack more of them takes longer than to open it."""


@dataclass(frozen=True, slots=True)
class Reach:
    """What a layer brings in, itself or by what it brings in. Real paths, links resolved."""

    stack: frozenset[str]
    """By sublayers alone, without the layer itself."""
    maybe: frozenset[str]
    """By what stands on prims."""
    sure: bool
    """Whether there is nothing else."""


@dataclass(slots=True)
class _Layer:
    sublayers: list[str] = field(default_factory=list)
    others: list[str] = field(default_factory=list)
    follow: bool = False
    """Whether what stands on its prims may bring in parts of the render spec."""
    sure: bool = True


class Uses:
    """What layers bring in; each file is read at most once.

    `wanted`: the files that are asked about. Of layers that name no render scope, only references
    to these are noted: they may have thousands.
    """

    def __init__(self, wanted: Iterable[str], scopes: Iterable[str]) -> None:
        names = sorted({Path(file).name.encode() for file in wanted})
        self._wanted = frozenset(names)
        tops = [scope.rpartition("/")[2].encode() for scope in scopes]
        self._scopes = [quote + name + quote for name in tops for quote in (b'"', b"'")]
        self._scope_names = [b"\0" + name + b"\0" for name in tops]
        self._layers: dict[str, _Layer] = {}
        self._reaches: dict[str, Reach] = {}
        self._existing: dict[str, bool] = {}
        self._real = RealPaths()
        self.unreadable: set[str] = set()

    def of(self, file: str) -> Reach:
        """All that a layer brings in, of whatever depth."""
        if file not in self._reaches:
            self._reaches[file] = self._reach(file)
        return self._reaches[file]

    def _reach(self, file: str) -> Reach:
        stack: set[str] = set()
        maybe: set[str] = set()
        root, sure = self._real[file], True
        pending = [(str(Path(file).absolute()), True)]
        while pending:
            one, by_sublayers = pending.pop()
            layer = self._layer(one)
            sure = sure and layer.sure
            known = stack if by_sublayers else maybe
            for path in layer.sublayers:
                if (real := self._real[path]) not in known and real != root:
                    known.add(real)
                    pending.append((path, by_sublayers))
            for path in layer.others:
                if (real := self._real[path]) not in maybe:
                    maybe.add(real)
                    if layer.follow:
                        pending.append((path, False))
        return Reach(frozenset(stack), frozenset(maybe), sure)

    def between(self, files: Mapping[str, str | Path]) -> set[str]:
        """Those of the files, by real paths, that another one sublayers, and does not sublayer in
        turn."""
        stacks = {real: self.of(str(file)).stack for real, file in files.items()}
        return {
            layer
            for real, stack in stacks.items()
            for layer in stack
            if layer in stacks and real not in stacks[layer]
        }

    def _layer(self, file: str) -> _Layer:
        if file not in self._layers:
            self._layers[file] = self._read(file)
        return self._layers[file]

    def _read(self, file: str) -> _Layer:
        data = self._bytes_of(file)
        if data.startswith(b"PXR-USDC"):
            return self._read_crate(file)
        if data.startswith(b"PK"):
            return _Layer()  # a package holds all that it needs
        if not data.startswith(b"#"):
            self.unreadable.add(self._real[file])
            return _Layer()
        return self._read_text(file, data)

    def _bytes_of(self, file: str) -> bytes:
        """All of a text layer, or its head if nobody asks for more."""
        try:
            at = Path(bytes_at(file))
            if not at.is_file():  # a pipe would be waited for
                return b""
            with at.open("rb") as stream:
                head = stream.read(_HEAD)
                if len(head) < _HEAD or not head.startswith(b"#"):
                    return head
                is_enough = not self._wanted and _metadata_ends(head)
                return head if is_enough else head + stream.read()
        except (OSError, ValueError):
            return b""

    def _read_text(self, file: str, data: bytes) -> _Layer:
        layer = _Layer()
        self._add(layer.sublayers, layer, file, _sublayers(data))
        layer.follow = any(scope in data for scope in self._scopes)
        if layer.follow or any(name in data for name in self._wanted):
            found = {m[1] for m in (*_ASSET.finditer(data), *_TRIPLED.finditer(data))}
            assets = [asset for asset in found if _may_be_layer(asset)]
            if layer.follow and len(assets) > _MANY:
                layer.follow = layer.sure = False
            if not layer.follow:
                assets = [asset for asset in assets if self._is_wanted(asset)]
            self._add(layer.others, layer, file, assets)
        return layer

    def _read_crate(self, file: str) -> _Layer:
        """A crate has a table of all its words: those of fields tell which kinds of arcs there are."""
        layer = _Layer()
        tokens = tokens_of(file, _MOST_TOKENS)
        if tokens is None:
            layer.sure = False
            return layer
        words = tokens.split(b"\0")
        assets = [word for word in words if _may_be_layer(word)]
        has_sublayers = b"\0subLayers\0" in tokens
        has_arcs = b"\0references\0" in tokens or b"\0payload\0" in tokens
        if has_sublayers and not has_arcs:
            self._add(layer.sublayers, layer, file, assets)
            return layer
        if not has_arcs:
            return layer
        named = any(name in tokens for name in self._scope_names)
        layer.sure = not (has_sublayers or named)  # it is not known which is which
        self._add(layer.others, layer, file, filter(self._is_wanted, assets))
        return layer

    def _is_wanted(self, asset: bytes) -> bool:
        name = re.split(rb"[/\\]", _without_arguments(asset))[-1]
        return name.partition(b"[")[0] in self._wanted or name.startswith(b"`")

    def _add(self, to: list[str], layer: _Layer, file: str, assets: Iterable[bytes]) -> None:
        for asset in assets:
            path = self._resolved(file, asset)
            if path is None:
                layer.sure = False
            elif path:
                to.append(path)

    def _resolved(self, file: str, asset: bytes) -> str | None:
        """The file that an asset path means; empty for none, None where it takes a variable, a search
        path or another resolver to tell."""
        path = _without_arguments(asset).decode(errors="replace")
        if path.startswith("`"):
            return None
        path = path.partition("[")[0] if path.endswith("]") else path
        # From where a layer was found, not from where a link to it leads: as USD does it.
        found = os.path.normpath(Path(file).parent / path)
        if found not in self._existing:
            self._existing[found] = os.path.exists(found)  # noqa: PTH110 a name may be too long
        if self._existing[found]:
            return found
        return "" if Path(path).is_absolute() or path.startswith(".") else None


def _metadata_ends(head: bytes) -> int | None:
    """Where the metadata of a text layer ends, if its first bytes tell."""
    # Its patterns take 15 ms to compile.
    from .usda.scan import Scan

    metadata = Scan(head).root.metadata
    if metadata is None:  # there is none, or nothing but comments so far
        return len(head) if len(head) < _HEAD or b"{" in head else None
    return metadata[1] if metadata[1] < len(head) else None


def _sublayers(data: bytes) -> Iterator[bytes]:
    """As written, of a text layer."""
    if b"subLayers" not in data:
        return
    from .usda.scan import Scan

    end = _metadata_ends(data[:_HEAD])
    scan = Scan(data if end is None else data[: end + 1])
    for statement in scan.metadata(scan.root.metadata or (0, 0)):
        start, end = statement.name
        if data[start:end] == b"subLayers" and statement.value:
            for item in scan.items((statement.value[0] + 1, statement.value[1] - 1)):
                if asset := scan.asset(item):
                    yield asset


def _without_arguments(asset: bytes) -> bytes:
    return asset.partition(b":SDF_FORMAT_ARGS:")[0]


def _may_be_layer(asset: bytes) -> bool:
    path = _without_arguments(asset).lower()
    return path.removesuffix(b"]").endswith(_SUFFIXES) or path.startswith(b"`")
