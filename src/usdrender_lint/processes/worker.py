"""What does a process do that lints for another one?"""

from __future__ import annotations

import math
import signal
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import field, replace
from typing import Any, Protocol

from ..discover import Shown
from ..discover import Target as File
from ..handed import accept, handed_over
from ..job import Config, FileResult
from ..lint import lint_here
from ..records import dataclass
from .aside import Aside, listening
from .copies import Lifeline, do_and_exit
from .frames import Channel, framed, packed, received, unpacked
from .machine import most_memory
from .ready import get_ready, use_threads
from .stem import divide


class Named(Protocol):
    """A file, and whatever else there is to know about it."""

    @property
    def shown(self) -> str: ...


class Work(Protocol):
    """What a worker does. It crosses to another process, so it has to be known by name there."""

    def prepare(self, threads: int | None) -> None:
        """What has to be done once, and is not the fault of a file. USD may take so many threads;
        None: as many as it likes."""

    def __call__(self, file: Any, /) -> FileResult: ...


@dataclass(frozen=True, slots=True)
class Order:
    file: File
    config: Config

    @property
    def shown(self) -> str:
        return self.file.shown


@dataclass(frozen=True, slots=True)
class Linting:
    shown: Shown
    handed: Mapping[str, str] = field(default_factory=handed_over)

    def prepare(self, threads: int | None) -> None:
        get_ready()
        use_threads(threads)
        accept(self.handed)

    def __call__(self, order: Order, /) -> FileResult:
        return lint_here([(order.file, order.config)], self.shown)[0]


@dataclass(frozen=True, slots=True)
class Limits:
    """What one worker may take."""

    seconds: float
    """For one file; 0: as many as it likes."""
    threads: int | None
    """Of USD, which takes one for each core by itself; None: as many as it likes."""


def begin() -> None:
    """What a Python that was started as a worker does."""
    import socket

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent tells when to end
    if sys.platform == "win32":
        channel = socket.fromshare(sys.stdin.buffer.read())
    else:
        channel = socket.socket(fileno=int(sys.argv[1]))
    do_and_exit(lambda: serve_whatever(channel))


def introduced(work: Work, files: Sequence[Named], limits: Limits) -> bytes:
    """What a process has to be told first that was not made for this very work."""
    return framed(packed((work, tuple(files), limits)))


def serve_whatever(channel: Channel, lines: Sequence[Lifeline] = ()) -> None:
    """As `serve`, of a process that begins without knowing what it will have to do; or as so many of
    them, each at the end of a line."""
    try:
        told = unpacked(received(channel))
    except (EOFError, OSError):  # nobody wants anything
        return
    if isinstance(told, int):
        divide(channel, lines[:told], serve_whatever)
        return
    for line in lines:
        line.close()
    serve(channel, *told)


def serve(channel: Channel, work: Work, files: Sequence[Named], limits: Limits) -> None:
    """Lint what is asked for, until nobody asks any more."""
    _limit_resources()
    work.prepare(limits.threads)
    channel.sendall(framed(b""))
    with listening(getattr(channel, "words", None)) as aside:
        _serve(channel, work, files, limits, aside)


def _serve(
    channel: Channel, work: Work, files: Sequence[Named], limits: Limits, aside: Aside | None
) -> None:
    while True:
        try:
            asked = unpacked(received(channel))
        except (EOFError, OSError):
            return
        for one in asked:
            if limits.seconds and hasattr(signal, "alarm"):
                # Should nobody be left to tell that it takes too long.
                signal.alarm(math.ceil(limits.seconds) + 5)
            file = files[one] if isinstance(one, int) else one
            result = work(file)
            if aside is not None and (said := aside.taken()):
                result = replace(result, chatter=(*result.chatter, *said))
            channel.sendall(framed(packed(result)))
        if hasattr(signal, "alarm"):  # waiting for more takes as long as it takes
            signal.alarm(0)


def _limit_resources() -> None:
    """A damaged file may ask for all the memory there is; and a crash need not be kept."""
    if sys.platform != "win32":
        import resource

        # Layers that are mapped into memory do not count as data.
        for kind, most in ((resource.RLIMIT_CORE, 0), (resource.RLIMIT_DATA, most_memory())):
            soft, hard = resource.getrlimit(kind)
            known = [limit for limit in (most, soft) if limit not in (None, resource.RLIM_INFINITY)]
            with suppress(OSError, ValueError):
                resource.setrlimit(kind, (min(known, default=soft), hard))
