"""Which text of a binary layer is not UTF-8, and how is everything else read all the same?

C++ does not mind, and hands bytes in any encoding to renderers; USD's Python raises where such a
text is met, or prints, and leaves it out (26.11). usda text of the kind does not even parse.
"""

from __future__ import annotations

import os
from pathlib import Path

from pxr import Sdf, Tf

from ..handed import bytes_at
from ..lazily import lazily
from ..usda import UsdaText

_MOST = 64 << 20
"""Bytes of a layer that is written out as text and read again."""
_WRITTEN = lazily(rb"\\\\|\\x[89a-fA-F][0-9a-fA-F]")
"""How USD writes such a byte into usda; a backslash is written as two."""
_INSTEAD = "\ufffd"


def loaded_layers() -> list[Sdf.Layer]:
    """What is in memory before a file is opened belongs to somebody else, and is left as it is."""
    return list(Sdf.Layer.GetLoadedLayers())


def make_decodable(besides: list[Sdf.Layer]) -> dict[str, list[str]] | None:
    """Put a replacement character for all that is not UTF-8 into the layers that were opened since
    `besides` was asked for, in memory only. The files, each with the prims and layer metadata that
    hold such text; None if one of them cannot be changed."""
    found: dict[str, list[str]] = {}
    for layer in Sdf.Layer.GetLoadedLayers():
        if layer.anonymous or not layer.realPath:
            continue
        text, places = _decodable(layer)
        if places:
            if layer in besides or not _takes(layer, text):
                return None
            found[layer.realPath] = places
    return found or None


def _takes(layer: Sdf.Layer, text: str) -> bool:
    """A name that is not UTF-8 is no name with a replacement character, either."""
    try:
        return bool(layer.ImportFromString(text))
    except Tf.ErrorException:
        return False


def _decodable(layer: Sdf.Layer) -> tuple[str, list[str]]:
    """The layer as text, and which prims of it hold what is replaced."""
    file = layer.realPath.partition("[")[0]
    if Path(bytes_at(file)).stat().st_size > _MOST:
        return "", ["/"]
    import tempfile  # 6 ms, and there is hardly ever such text

    with tempfile.TemporaryDirectory() as folder:
        written = os.path.join(folder, "layer.usda")  # noqa: PTH118 USD takes a str
        if not layer.Export(written):
            return "", []
        data = Path(written).read_bytes()
    mark = _INSTEAD.encode()
    escaped = _WRITTEN.sub(lambda m: m[0] if m[0] == b"\\\\" else mark, data)
    text = escaped.decode(errors="replace")
    if text.encode() == data:
        return text, []
    whole, at, places = UsdaText(text.encode()), -1, dict[str, None]()
    while (at := whole.find(mark, at + 1)) >= 0:
        places[whole.around(at) or "/"] = None
    return text, list(places)
