"""How does a process begin that is a copy of this one, and that never outlives it?

Where a process can be copied, that takes 1 ms, and no thread is lost by it as long as there is only
one. This module imports next to nothing: the sooner a copy is made, the more it can do meanwhile.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import TYPE_CHECKING, NoReturn

if TYPE_CHECKING:
    from .frames import Channel

_PATIENCE = 1.0
"""Seconds for what was killed to be gone. What waits for a dead file server is not."""


class Pipes:
    """One end of a pair of pipes: importing `socket` would cost more than making the copy."""

    def __init__(self, read: int, write: int) -> None:
        self._read, self._write = read, write

    def fileno(self) -> int:
        return self._read

    def recv(self, size: int, /) -> bytes:
        return os.read(self._read, size)

    def sendall(self, data: bytes, /) -> None:
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(self._write, rest) :]

    def close(self) -> None:
        os.close(self._read)
        os.close(self._write)


class Lifeline(Pipes):
    """And one end of a pipe that says nothing: it breaks when the process at the other is gone. And
    a file for its last words, where there are such files that have no name."""

    def __init__(self, read: int, write: int, life: int, words: int | None) -> None:
        super().__init__(read, write)
        self.life: int | None = life
        self.words = words

    def cut(self) -> None:
        """Where it breaks, the process at the other end is gone at once (Linux)."""
        if self.life is not None:
            os.close(self.life)
            self.life = None

    def close(self) -> None:
        super().close()
        self.cut()
        if self.words is not None:
            os.close(self.words)
            self.words = None


class Line:
    """What a process and one that it makes hold of each other. Raises `OSError` where there are too
    many open files."""

    def __init__(self) -> None:
        ends: list[int] = []
        try:
            for _ in range(3):
                ends += os.pipe()
            if hasattr(os, "memfd_create"):
                ends.append(os.memfd_create("words"))
                ends.append(os.dup(ends[-1]))
        except OSError:
            for end in ends:
                os.close(end)
            raise
        tasks, results, life, words = ends[:2], ends[2:4], ends[4:6], ends[6:] or (None, None)
        self.ours = Lifeline(results[0], tasks[1], life[1], words[1])
        self.theirs = Lifeline(tasks[0], results[1], life[0], words[0])


class Copy:
    """A copied process, as seen from the one that made it."""

    def __init__(self, channel: Lifeline, pid: int) -> None:
        self.channel = channel
        self.pid = pid

    def kill(self) -> None:
        with suppress(OSError):  # it has gone by itself
            os.kill(self.pid, signal.SIGKILL)

    def gone(self) -> int | None:
        """Its exit code, as `subprocess` counts; None while it lives."""
        try:
            ended, status = os.waitpid(self.pid, os.WNOHANG)
        except ChildProcessError:  # somebody ignores the ends of children
            return 0
        return os.waitstatus_to_exitcode(status) if ended else None


def awaited(gone: Callable[[], int | None]) -> int | None:
    """The exit code of a process that was told to end; None if it has not by then."""
    deadline = time.monotonic() + _PATIENCE
    while (code := gone()) is None and time.monotonic() < deadline:
        time.sleep(0.001)
    return code


def can_be_copied() -> bool:
    # macOS forbids its own libraries in a copied process.
    return hasattr(os, "fork") and sys.platform != "darwin" and is_alone()


def is_alone() -> bool:
    """A copied process has one thread only, and every lock that another one held stays locked."""
    try:
        return len(os.listdir("/proc/self/task")) == 1
    except OSError:
        import threading

        return threading.active_count() == 1


def copied(task: Callable[[Pipes], None], others: Iterable[Channel] = ()) -> Copy:
    """A copy of this process that does `task` and ends. It holds on to nothing that belongs to the
    `others`, and neither speaks nor listens but through its end of the pipes.

    Raises `OSError` where there are too many processes or open files, or no memory for one more.
    """
    line = Line()
    try:
        pid = copied_to(line.theirs, task, (line.ours, *others))
    except OSError:
        line.ours.close()
        line.theirs.close()
        raise
    line.theirs.close()
    return Copy(line.ours, pid)


def copied_to(theirs: Lifeline, task: Callable[[Pipes], None], others: Iterable[Channel]) -> int:
    """The number of a copy that lives at that end of a line."""
    pid = os.fork()
    if pid == 0:

        def live() -> None:
            for end in others:
                end.close()
            _settle_down(theirs)
            task(theirs)

        do_and_exit(live)
    return pid


def _settle_down(line: Lifeline) -> None:
    """Become a process that neither speaks nor outlives its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent tells when to end
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(nothing, stream)
    if sys.platform == "linux" and line.life is not None:
        import fcntl

        # The signal that the pipe is broken reaches even a process that hangs: it ends it.
        fcntl.fcntl(line.life, fcntl.F_SETOWN, os.getpid())
        fcntl.fcntl(line.life, fcntl.F_SETFL, os.O_ASYNC | os.O_NONBLOCK)
        with suppress(BlockingIOError):  # raised by a pipe that is whole
            os.read(line.life, 1)
            os._exit(1)  # it was broken before it could tell


def do_and_exit(task: Callable[[], None]) -> NoReturn:
    """Without what Python does at its end: in a copy, what the other process still has to write or
    to clean up is not ours."""
    code = 1
    try:
        task()
        code = 0
    finally:
        os._exit(code)


def fill_closed_streams() -> None:
    """A stream that was closed leaves its number to the next pipe, which a copy would then take for
    the stream."""
    with suppress(OSError):
        while (number := os.open(os.devnull, os.O_RDWR)) < 3:
            pass
        os.close(number)
