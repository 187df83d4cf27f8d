"""How does a file on which USD dies or hangs cost nothing but itself?

The files are linted in processes of their own. When one of them dies or takes too long, the file
that it was at is blamed, and a new process takes the rest. This process opens no layer and imports
nothing of USD: where a process can be copied, a worker is a copy of this small one, made before USD
is there (1 ms, and no thread that could be lost by it), or of one that has USD and nothing else to
do; elsewhere it is started anew.
"""

from __future__ import annotations

import math
import select
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import field, replace

from ..discover import Shown
from ..job import Asked, FileResult
from ..lint import lint_here
from ..records import dataclass
from ..results import Problem
from . import headstart
from .aside import last_words, listening
from .copies import awaited, can_be_copied, copied, fill_closed_streams
from .frames import Channel, framed, frames_in, packed, unpacked
from .machine import cores
from .stem import Process, Stem
from .worker import Limits, Linting, Named, Order, Work, begin, introduced, serve

FEW = 12
"""Files for which one worker is enough: another one would first import USD, too."""

MOST = 200
"""Workers. `select` knows no more than 1024 files, and 512 on Windows."""

TIMEOUT = 60.0

_TICK = 0.1
_LONGEST = 3600.0
"""Seconds to sleep at a stretch."""
_CHUNK = 16
_START_LIMIT = 60.0
"""Until a started Python must have said that it is there; it may turn out to be another program."""


Progress = Callable[[int, int, Named | None], None]
"""How many are done, of how many, and which one takes the longest by now."""


@dataclass(frozen=True, slots=True)
class Isolated:
    """How files are linted in processes of their own."""

    jobs: int | None = None
    """None: as many as there are cores, and one for few files. 0: none, all in this process."""
    timeout: float = TIMEOUT
    """Seconds for one file; 0 for no limit."""
    progress: Progress | None = None
    meanwhile: Callable[[], None] = lambda: None
    """What this process may do while it waits."""
    kept: list[Worker] | None = None
    """One that has done its part and waits for more, which spares importing USD once more. None: no
    worker outlives a run."""
    stem: list[Stem] = field(default_factory=list)
    """What has begun before it was known what for; at most one, and gone when it is taken."""
    hosted: bool = field(default_factory=lambda: "pxr" in sys.modules)
    """Somebody else has loaded USD into this process, whose standard error is not ours to take."""

    @contextmanager
    def keeping(self) -> Iterator[Isolated]:
        begun, kept = headstart.claim(), list[Worker]()
        stem = Stem(*begun) if begun else None
        try:
            yield replace(self, kept=kept, stem=[stem] if stem else [])
        finally:
            for worker in kept:
                worker.end()
            if stem:
                stem.end()

    def __call__(self, asked: Sequence[Asked], shown: Shown) -> list[FileResult]:
        start = _way()
        if start is None or self.jobs == 0 or not asked:
            return self._lint_here(asked, shown)
        fill_closed_streams()
        results = run(Linting(shown), [Order(*one) for one in asked], self, start)
        # What no worker could be started for.
        left = [one for one, result in zip(asked, results, strict=True) if result is None]
        here = iter(self._lint_here(left, shown))
        return [next(here) if result is None else result for result in results]

    def _lint_here(self, asked: Sequence[Asked], shown: Shown) -> list[FileResult]:
        if not asked:
            return []
        if self.hosted:
            return lint_here(asked, shown)
        with listening() as aside:
            *results, last = lint_here(asked, shown)
            said = aside.taken() if aside is not None else ()
            return [*results, replace(last, chatter=(*last.chatter, *said))]

    def limits(self, files: int) -> Limits:
        workers = self.count(files)
        return Limits(self.timeout, max(1, cores() // workers) if workers > 1 else None)

    def count(self, files: int) -> int:
        if self.jobs is not None:
            return max(1, min(self.jobs, files, MOST))
        return 1 if files < FEW else min(cores(), math.ceil(files / FEW) + 1, MOST)


Start = Callable[[Work, Sequence[Named], Isolated, "Sequence[Worker]"], "Worker"]
"""A new worker, which must not hold on to what belongs to those that are there."""


def run(work: Work, files: Sequence[Named], how: Isolated, start: Start) -> list[FileResult | None]:
    """A result for each file; None where workers cannot be had."""
    with _Crew(work, files, how, start) as crew:
        return crew.run()


# This process


@dataclass(slots=True)
class Worker:
    """A process that lints, as seen from here."""

    channel: Channel
    stop: Callable[[], None]
    gone: Callable[[], int | None]
    """Its exit code, as `subprocess` counts; None while it lives."""
    files: deque[int] = field(default_factory=deque)
    """What it was given and has not answered. The first is the one that it is at."""
    ready: bool = False
    since: float = field(default_factory=time.monotonic)
    """When it began with the first of its files, or was started."""
    fresh: bool = True
    """Nothing that it did before can have harmed it."""
    knows: bool = True
    """The files of this run by their numbers, since it was started for it."""
    heard: bytearray = field(default_factory=bytearray)

    def introduce(self, work: Work, limits: Limits) -> None:
        with suppress(OSError):  # it has died: that is noticed where it is listened to
            self.channel.sendall(introduced(work, (), limits))

    def give(self, numbers: Sequence[int], files: Sequence[Named]) -> None:
        self.files.extend(numbers)
        self.since = time.monotonic()
        said = tuple(n if self.knows else files[n] for n in numbers)
        with suppress(OSError):  # it has died: that is noticed where it is listened to
            self.channel.sendall(framed(packed(said)))

    def hear(self) -> list[bytes] | None:
        """The frames that are there by now, None when there will be no more."""
        try:
            data = self.channel.recv(1 << 20)
        except OSError:
            data = b""
        if not data:
            return None
        self.heard += data
        return frames_in(self.heard)

    def words(self) -> tuple[str, ...]:
        """What was printed in it since its last result, where that can be known."""
        number = getattr(self.channel, "words", None)
        return () if number is None else last_words(number)

    def end(self) -> int | None:
        """Its exit code, whether or not it would have gone by itself; None if it cannot be ended."""
        self.stop()
        return self.wait()

    def wait(self) -> int | None:
        self.channel.close()
        return awaited(self.gone)


class _Crew:
    """All workers of a run."""

    def __init__(self, work: Work, files: Sequence[Named], how: Isolated, start: Start) -> None:
        self._work, self._files, self._how, self._start = work, files, how, start
        self._wanted = how.count(len(files))
        fair = len(files) // (self._wanted * 4) if self._wanted > 1 else len(files)
        self._chunk = max(1, min(_CHUNK, fair))
        self._left = deque(range(len(files)))
        self._again: deque[tuple[int, FileResult]] = deque()
        """On which a worker died that had done something before: that may have been the reason."""
        self._results: list[FileResult | None] = [None] * len(files)
        self._done = 0
        self._workers: list[Worker] = []
        self._given_up = False

    def __enter__(self) -> _Crew:
        return self

    def __exit__(self, *_: object) -> None:
        for worker in self._workers:
            worker.stop()
        for worker in self._workers:
            worker.end()

    def run(self) -> list[FileResult | None]:
        self._call_back()
        if stem := self._divide():
            self._how.meanwhile()
            self._take_branches(stem)
            self._hire()
        else:
            self._hire()
            self._how.meanwhile()
        while self._workers:
            self._listen()
            self._dismiss_the_late()
            self._hire()
            self._tell_progress()
        for index, died in self._again:  # never in this process
            self._settle(index, died)
        return self._results

    def _call_back(self) -> None:
        while self._how.kept and self._left:
            self._employ(self._how.kept.pop())

    def _divide(self) -> Stem | None:
        """What has begun early, if it is to become several workers, for which it takes its time."""
        if not self._how.stem or not self._left:
            return None
        stem = self._how.stem.pop()
        if self._wanted > 1 and stem.can_divide:
            stem.divide(self._wanted)
            return stem
        self._introduce(stem.remain())
        return None

    def _take_branches(self, stem: Stem) -> None:
        for branch in stem.branches(_START_LIMIT):
            self._introduce(branch)

    def _introduce(self, process: Process) -> None:
        worker = Worker(process.channel, process.kill, process.gone)
        worker.introduce(self._work, self._how.limits(len(self._files)))
        self._employ(worker)

    def _employ(self, worker: Worker) -> None:
        """One that was not started for this run."""
        worker.knows = False
        self._workers.append(worker)
        worker.give(self._next(), self._files)

    def _hire(self) -> None:
        while len(self._workers) < self._wanted and (self._left or self._again):
            if self._given_up:
                return
            try:
                others = [*self._workers, *(self._how.kept or ())]
                worker = self._start(self._work, self._files, self._how, others)
            except OSError:  # too many processes, or no memory for one more
                self._given_up = True
                return
            self._workers.append(worker)
            numbers = [self._again.popleft()[0]] if self._again else self._next()
            worker.give(numbers, self._files)

    def _next(self) -> list[int]:
        return [self._left.popleft() for _ in range(min(self._chunk, len(self._left)))]

    def _listen(self) -> None:
        patience = None if self._how.progress is None else _TICK
        for worker in self._workers:
            if limit := self._limit(worker):
                rest = max(0.0, worker.since + limit - time.monotonic())
                patience = min(rest, _LONGEST if patience is None else patience)
        asked = time.monotonic()
        ready, _, _ = select.select([w.channel for w in self._workers], [], [], patience)
        self._forgive(time.monotonic() - asked - (patience or 0.0))
        by_channel = {id(worker.channel): worker for worker in self._workers}
        for channel in ready:
            worker = by_channel[id(channel)]
            frames = worker.hear()
            if frames is None:
                self._bury(worker)
                continue
            for frame in frames:
                self._take(worker, frame)
            if worker.ready and not worker.files:
                self._feed(worker)

    def _forgive(self, overslept: float) -> None:
        """Ctrl-Z and a closed lid stop all of us."""
        if overslept > 1.0:
            for worker in self._workers:
                worker.since += overslept

    def _take(self, worker: Worker, frame: bytes) -> None:
        worker.since = time.monotonic()
        if not worker.ready:
            worker.ready = True
            return
        worker.fresh = False
        self._settle(worker.files.popleft(), unpacked(frame))

    def _settle(self, index: int, result: FileResult) -> None:
        self._results[index] = result
        self._done += 1

    def _feed(self, worker: Worker) -> None:
        if self._left:
            worker.give(self._next(), self._files)
        elif self._how.kept == []:
            self._workers.remove(worker)
            self._how.kept.append(worker)
        else:
            self._let_go(worker)

    def _let_go(self, worker: Worker) -> None:
        self._workers.remove(worker)
        worker.end()

    def _bury(self, worker: Worker) -> None:
        """It has died. If it had done other things before, they may be to blame: that is tried."""
        self._workers.remove(worker)
        words = worker.words()
        if (code := worker.wait()) is None:  # it has closed its end, and does not die
            worker.stop()
        if not worker.ready:
            self._given_up = True
            self._left.extendleft(reversed(worker.files))
            return
        index = worker.files.popleft()
        self._left.extendleft(reversed(worker.files))
        died = _died(self._files[index], code, words)
        if worker.fresh:
            self._settle(index, died)
        else:
            self._again.append((index, died))

    def _dismiss_the_late(self) -> None:
        now = time.monotonic()
        for worker in [*self._workers]:
            limit = self._limit(worker)
            if not limit or now - worker.since < limit:
                continue
            words = worker.words()
            self._let_go(worker)
            if not worker.ready:
                self._given_up = True
            else:
                index = worker.files.popleft()
                self._settle(index, _late(self._files[index], limit, words))
            self._left.extendleft(reversed(worker.files))

    def _limit(self, worker: Worker) -> float:
        return self._how.timeout if worker.ready else _START_LIMIT

    def _tell_progress(self) -> None:
        if self._how.progress is not None:
            at_work = [w for w in self._workers if w.ready and w.files]
            slowest = min(at_work, key=lambda w: w.since, default=None)
            file = self._files[slowest.files[0]] if slowest else None
            self._how.progress(self._done, len(self._files), file)


def _died(file: Named, code: int | None, words: tuple[str, ...]) -> FileResult:
    name = ""
    if code is not None and code < 0:
        with suppress(ValueError):
            name = signal.Signals(-code).name
    if name == "SIGKILL":
        what, kind = "linting it was killed: it may need more memory than there is", "out-of-memory"
    elif name:
        what, kind = (
            "USD crashed while reading it: it may be damaged, or nested too deeply",
            "crashed-usd",
        )
    else:
        what, kind = "the process that linted it ended without a result", "crashed-usd"
    how = f"{file.shown}: the process that linted it ended with {name or code}"
    return FileResult(problems=(Problem(kind, file.shown, what),), chatter=(*words, how))


def _late(file: Named, limit: float, words: tuple[str, ...]) -> FileResult:
    said = f"linting it took longer than {limit:g} s: --timeout allows more"
    return FileResult(problems=(Problem("timed-out", file.shown, said),), chatter=words)


# How a worker comes to be


def _way() -> Start | None:
    """None: nothing but this process. A host in which USD is loaded has reasons to ask for it here,
    and cannot be copied."""
    if "pxr" in sys.modules:
        return None
    if can_be_copied():
        return forked
    return spawned if sys.executable and not getattr(sys, "frozen", False) else None


def forked(work: Work, files: Sequence[Named], how: Isolated, others: Sequence[Worker]) -> Worker:
    """A copy of this process."""
    limits = how.limits(len(files))
    copy = copied(
        lambda channel: serve(channel, work, files, limits), [other.channel for other in others]
    )
    return Worker(copy.channel, copy.kill, copy.gone)


def spawned(work: Work, files: Sequence[Named], how: Isolated, others: Sequence[Worker]) -> Worker:
    """A Python that is started anew."""
    import socket
    import subprocess

    ours, theirs = socket.socketpair()
    code = f"import sys; sys.path[:] = {sys.path!r}; from {begin.__module__} import begin; begin()"
    command = [sys.executable, "-c", code]
    number = theirs.fileno()
    windows = sys.platform == "win32"
    with theirs:
        process = subprocess.Popen(  # noqa: S603 ourselves
            [*command, str(number)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            pass_fds=() if windows else (number,),
        )
        if process.stdin is not None:
            with process.stdin as told:
                if sys.platform == "win32":
                    told.write(theirs.share(process.pid))
    worker = Worker(ours, process.kill, process.poll)
    ours.settimeout(_START_LIMIT)  # it may turn out to be no Python that listens
    with suppress(OSError):
        ours.sendall(introduced(work, files, how.limits(len(files))))
    ours.settimeout(None)
    return worker
