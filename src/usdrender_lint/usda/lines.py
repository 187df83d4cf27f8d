"""On which line of a text does a byte stand?"""

from __future__ import annotations

from array import array
from bisect import bisect_left
from itertools import islice

from ..lazily import lazily

Range = tuple[int, int]
"""The first byte of a stretch of text, and the one after its last."""

LINE_BREAK = lazily(rb"\r\n|\n|\r")


class Lines:
    """Numbers of lines, without a list of them all: a large layer has millions."""

    _STEP = 1 << 12

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._breaks = array("Q", [0])
        """How many line breaks end before each multiple of the step, as far as anybody asked."""
        self._starts: dict[int, int] = {}
        """Of lines that were asked about: their text is asked for next."""

    def at(self, offset: int) -> tuple[int, int]:
        """The number of the line there, from 1, and where it starts."""
        chunk = offset // self._STEP
        while len(self._breaks) <= chunk:
            self._go_on()
        number = self._breaks[chunk] + self._count(chunk * self._STEP, offset) + 1
        start = self._data.rfind(b"\n", 0, offset) + 1
        start = self._data.rfind(b"\r", start, offset) + 1 or start
        if self._data[offset : offset + 1] != b"\n":  # of a CR LF it would be the start of nothing
            self._starts[number] = start
        return number, start

    def range(self, number: int) -> Range:
        """A line without its line break; an empty range if there is none of that number."""
        start = self._starts.get(number, 0)
        if number > 1 and not start:
            while self._breaks[-1] < number - 1 and self._counted < len(self._data):
                self._go_on()
            chunk = max(bisect_left(self._breaks, number - 1) - 1, 0)
            breaks = LINE_BREAK.finditer(self._data, chunk * self._STEP)
            skipped = number - 2 - self._breaks[chunk]
            before = next(islice(breaks, skipped, None), None)
            start = before.end() if before else len(self._data)
        end = LINE_BREAK.search(self._data, start)
        return start, end.start() if end else len(self._data)

    @property
    def _counted(self) -> int:
        return (len(self._breaks) - 1) * self._STEP

    def _go_on(self) -> None:
        start = self._counted
        self._breaks.append(self._breaks[-1] + self._count(start, start + self._STEP))

    def _count(self, start: int, end: int) -> int:
        """A CR LF counts once, where its LF stands."""
        data = self._data
        breaks = data.count(b"\n", start, end)
        if returns := data.count(b"\r", start, end):
            breaks += returns - data.count(b"\r\n", start, end + 1)
        return breaks
