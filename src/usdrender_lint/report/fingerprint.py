"""Which hash does GitHub give a line? `primaryLocationLineHash`, as its own upload step computes it.

The hash of a line is a polynomial over the 100 UTF-16 units that follow its start,
modulo 2^64, blanks left out and line breaks made alike; so it survives edits
elsewhere in the file. Equal hashes are counted from the top of the file.
"""

from __future__ import annotations

import sys
from array import array
from collections import Counter
from collections.abc import Collection
from itertools import accumulate
from pathlib import Path

from ..handed import bytes_at

LIMIT = 8 * 1024 * 1024
"""Bytes. Text takes some 0.2 s/MB; a larger file is left to GitHub, which fills in what is absent."""

_WINDOW = 100
_BASE = 37
_MASK = (1 << 64) - 1
_LEAVING = pow(_BASE, _WINDOW, 1 << 64)
"""Weight of what has just left the window."""
_PADDING = "\uffff" + "\0" * _WINDOW
_UTF16 = f"utf-16-{sys.byteorder[0]}e"


def file_line_hashes(file: str, wanted: Collection[int]) -> dict[int, str]:
    """Hashes of those lines of a text file; nothing for a file that cannot or need not be hashed."""
    path = Path(bytes_at(file))
    try:
        if path.stat().st_size > LIMIT:
            return {}
        data = path.read_bytes()
    except OSError:
        return {}
    return line_hashes(data.decode("utf-8", "replace"), wanted)


def line_hashes(text: str, wanted: Collection[int]) -> dict[int, str]:
    """Hashes of those lines, from 1; lines that the text does not have are absent."""
    last = max(wanted, default=0)
    kept = _needed(_without_blanks(text), last) + _PADDING
    units = array("H", kept.encode(_UTF16, "surrogatepass"))
    # The hash of a window is a difference of two hashes that begin at the start of the file.
    from_start = array("Q", accumulate(units, _append, initial=0))
    starts = (0, *(i for i, unit in enumerate(units, 1) if unit == ord("\n")))
    seen: Counter[str] = Counter()
    hashes = {}
    for line, start in enumerate(starts[:last], 1):
        value = f"{from_start[start + _WINDOW] - from_start[start] * _LEAVING & _MASK:x}"
        seen[value] += 1
        if line in wanted:
            hashes[line] = f"{value}:{seen[value]}"
    return hashes


def _append(value: int, unit: int) -> int:
    return value * _BASE + unit & _MASK


def _without_blanks(text: str) -> str:
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text.replace(" ", "").replace("\t", "")


def _needed(text: str, last: int) -> str:
    """The text up to where the window of line `last` ends."""
    start = 0
    for _ in range(last - 1):
        start = text.find("\n", start) + 1
        if not start:
            return text
    return text[: start + _WINDOW]
