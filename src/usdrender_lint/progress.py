"""How far is a run that lasts? One line on the terminal, which is gone when the run ends."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from .console import say, terminal_width
from .printable import escaped
from .processes.worker import Named

_PATIENCE = 2.0
"""Seconds: for less, a line would only flicker."""
_PAUSE = 0.1
_CELLS = 20


@contextmanager
def bar(*, quiet: bool) -> Iterator[Bar | None]:
    """Only where somebody is looking, and never in a log."""
    if quiet or sys.stderr is None or not sys.stderr.isatty() or os.environ.get("TERM") == "dumb":
        yield None
        return
    drawn = Bar()
    try:
        yield drawn
    finally:
        drawn.erase()


class Bar:
    """Called with how many files are done, of how many, and which one takes long."""

    def __init__(self) -> None:
        self._width = 0
        self._next = time.monotonic() + _PATIENCE

    def __call__(self, done: int, total: int, slow: Named | None) -> None:
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + _PAUSE
        full = _CELLS * done // total
        text = f"[{'#' * full}{'.' * (_CELLS - full)}] {done}/{total}"
        if slow is not None:
            text = f"{text}  {escaped(slow.shown)}"
        # The last column stays free: some terminals go on to the next line when it is filled.
        line, width = _cut(text, terminal_width() - 1)
        say(f"\r{line}{' ' * (self._width - width)}")
        self._width = max(width, self._width)

    def erase(self) -> None:
        if self._width:
            say(f"\r{' ' * self._width}\r")


def _cut(text: str, room: int) -> tuple[str, int]:
    """As much as there is room for, and the columns that it fills."""
    from unicodedata import east_asian_width  # 3 ms, for runs that last

    width = 0
    for index, letter in enumerate(text):
        cells = 2 if east_asian_width(letter) in "WF" else 1
        if width + cells > room:
            return text[:index], width
        width += cells
    return text, width
