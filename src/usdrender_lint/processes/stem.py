"""How does a copy that is ready become several, none of which has to get ready itself?

Importing USD takes a hundred times as long as copying a process that has. The one that is copied
lints nothing itself then: only who made a process is told how it ended.
"""

from __future__ import annotations

import os
import select
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

from .copies import Copy, Lifeline, Pipes, awaited, copied_to, is_alone
from .frames import Channel, framed, frames_in, packed, received, unpacked


class Process(Protocol):
    """As seen from the one that it works for."""

    @property
    def channel(self) -> Channel: ...
    def kill(self) -> None: ...
    def gone(self) -> int | None:
        """Its exit code, as `subprocess` counts; None while it lives."""


class Stem:
    """A copy that does not know yet what for, as seen from the one that made it, and the lines that
    are laid to those that it may become."""

    def __init__(self, copy: Copy, lines: Sequence[Lifeline]) -> None:
        self._copy = copy
        self._lines = [*lines]
        self._heard = bytearray()
        self._ended: dict[int, int | None] = {}
        self._is_taken = False
        self._has_branches = False

    @property
    def can_divide(self) -> bool:
        return bool(self._lines)

    def remain(self) -> Copy:
        """As it is."""
        self._close(self._lines)
        self._is_taken = True
        return self._copy

    def divide(self, count: int) -> None:
        """As soon as it is ready, into as many as there are lines for."""
        self._close(self._lines[count:])
        try:
            self._copy.channel.sendall(framed(packed(len(self._lines))))
        except OSError:  # it has died: nobody will be at the lines
            return

    def branches(self, patience: float) -> Iterator[Branch]:
        """What it has become, once it has. None if it has died, or could not."""
        made = 0
        if select.select([self._copy.channel], [], [], patience)[0]:
            try:
                made = unpacked(received(self._copy.channel))
            except (EOFError, OSError):
                made = 0
        self._close(self._lines[made:])
        lines, self._lines = self._lines, []
        self._has_branches = bool(lines)
        for number, line in enumerate(lines):
            yield Branch(self, line, number)

    def code(self, number: int) -> int | None:
        """The exit code of what stood at a line; None while it lives."""
        while number not in self._ended and select.select([self._copy.channel], [], [], 0)[0]:
            try:
                more = self._copy.channel.recv(1 << 16)
            except OSError:
                more = b""
            if not more:  # it was killed, and nobody knows any more
                return 0
            self._heard += more
            self._ended.update(map(unpacked, frames_in(self._heard)))
        return self._ended.get(number)

    def end(self) -> None:
        """All of its branches have: then it does by itself, and what they took of the processor counts
        as this process's."""
        if self._is_taken:
            return
        self._close(self._lines)
        if not self._has_branches or awaited(self._copy.gone) is None:
            self._copy.kill()
            awaited(self._copy.gone)
        self._copy.channel.close()

    def _close(self, lines: Sequence[Lifeline]) -> None:
        for line in lines:
            line.close()
        self._lines = [line for line in self._lines if line not in lines]


class Branch:
    """One of several, as seen from the process that made the stem."""

    def __init__(self, stem: Stem, channel: Lifeline, number: int) -> None:
        self.channel = channel
        self._stem = stem
        self._number = number

    def kill(self) -> None:
        """Its number may be another's by now."""
        self.channel.cut()

    def gone(self) -> int | None:
        return self._stem.code(self._number)


def divide(channel: Channel, lines: Sequence[Lifeline], task: Callable[[Pipes], None]) -> None:
    """Of the copy: become one for each line, which does `task`; tell how many there are, and how each
    of them ended. None if a library has begun a thread, which a copy would not have."""
    numbers: dict[int, int] = {}
    for number, line in enumerate(lines if _is_alone() else ()):
        others = (channel, *(one for one in lines if one is not line))
        try:
            numbers[copied_to(line, task, others)] = number
        except OSError:  # too many processes, or no memory for one more
            break
    for line in lines:
        line.close()
    channel.sendall(framed(packed(len(numbers))))
    while numbers:
        pid, status = os.wait()
        channel.sendall(framed(packed((numbers.pop(pid), os.waitstatus_to_exitcode(status)))))


def _is_alone() -> bool:
    """Before Python 3.13 a thread that has ended is forgotten there a moment before it is gone."""
    for _ in range(20):
        if is_alone():
            return True
        time.sleep(0.0005)
    return False
