"""What do the text layers of a stage say literally?"""

from __future__ import annotations

from pathlib import Path

from pxr import Sdf, Usd

from ..model import Site
from ..sites import find
from ..usda import UsdaText


class Texts:
    """Texts of layers, each read and parsed at most once a stage, and only when asked for."""

    def __init__(self) -> None:
        self._known: dict[str, UsdaText | None] = {}

    def of(self, layer: Sdf.Layer) -> UsdaText | None:
        """None for a binary layer, a member of a package or a layer without a file."""
        return self.of_file(layer.realPath)

    def of_file(self, file: str) -> UsdaText | None:
        if file not in self._known:
            data = text_of(file)
            self._known[file] = None if data is None else UsdaText(data)
        return self._known[file]

    def written_target(self, stage: Usd.Stage, site: Site) -> str | None:
        """The text between the angle brackets of one entry of a relationship's list."""
        spot = find(stage, site)
        text = self.of(spot.layer)
        if text is None or spot.target is None:
            return None
        return text.written_target(spot.path, spot.target)


def text_of(file: str) -> bytes | None:
    """The bytes of a usda layer: by what they are, for `.usd` may be text or crate."""
    if not file:
        return None
    try:
        with Path(file).open("rb") as stream:
            head = stream.read(8)
            if head.startswith((b"PXR-USDC", b"PK\x03\x04")):
                return None
            return head + stream.read()
    except OSError:
        return None
