"""How does a file on which USD dies or hangs cost nothing but itself?

The files are linted in processes of their own. When one of them dies or takes too long, the file
that it was at is blamed, and a new process takes the rest. This process opens no layer and imports
nothing of USD: where a process can be copied, a worker is a copy of this small one, made before USD
is there (1 ms, and no thread that could be lost by it); elsewhere it is started anew.
"""

from __future__ import annotations

import io
import math
import os
import pickle
import select
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import field, replace
from pathlib import Path
from typing import Any, NoReturn, Protocol

from .discover import Shown
from .discover import Target as File
from .handed import accept, handed_over
from .lint import Asked, Config, FileResult, lint_here
from .machine import cores, most_memory
from .records import dataclass
from .registry import all_rules
from .results import Problem
from .rule import AnyRule, Rule

FEW = 12
"""Files for which one worker is enough: another one would first import USD, too."""

MOST = 200
"""Workers. `select` knows no more than 1024 files, and 512 on Windows."""

TIMEOUT = 60.0

_TICK = 0.1
_LONGEST = 3600.0
"""Seconds to sleep at a stretch."""
_CHUNK = 16
_HEAD = 8
_START_LIMIT = 60.0
"""Until a started Python must have said that it is there; it may turn out to be another program."""
_PATIENCE = 1.0
"""For what was killed to be gone. What waits for a dead file server is not."""


class Named(Protocol):
    """A file, and whatever else there is to know about it."""

    @property
    def shown(self) -> str: ...


Progress = Callable[[int, int, Named | None], None]
"""How many are done, of how many, and which one takes the longest by now."""


class Work(Protocol):
    """What a worker does. It crosses to another process, so it has to be known by name there."""

    def prepare(self) -> None:
        """What has to be done once, and is not the fault of a file."""

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

    def prepare(self) -> None:
        from . import lint_file  # noqa: F401 it imports USD

        accept(self.handed)

    def __call__(self, order: Order, /) -> FileResult:
        return lint_here([(order.file, order.config)], self.shown)[0]


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

    @contextmanager
    def keeping(self) -> Iterator[Isolated]:
        kept: list[Worker] = []
        try:
            yield replace(self, kept=kept)
        finally:
            for worker in kept:
                worker.end()

    def __call__(self, asked: Sequence[Asked], shown: Shown) -> list[FileResult]:
        start = _way()
        if start is None or self.jobs == 0 or not asked:
            return lint_here(asked, shown)
        _fill_closed_streams()
        results = run(Linting(shown), [Order(*one) for one in asked], self, start)
        # What no worker could be started for.
        left = [one for one, result in zip(asked, results, strict=True) if result is None]
        here = iter(lint_here(left, shown))
        return [next(here) if result is None else result for result in results]

    def limits(self, files: int) -> Limits:
        workers = self.count(files)
        return Limits(self.timeout, max(1, cores() // workers) if workers > 1 else None)

    def count(self, files: int) -> int:
        if self.jobs is not None:
            return max(1, min(self.jobs, files, MOST))
        return 1 if files < FEW else min(cores(), math.ceil(files / FEW) + 1, MOST)


@dataclass(frozen=True, slots=True)
class Limits:
    """What one worker may take."""

    seconds: float
    """For one file; 0: as many as it likes."""
    threads: int | None
    """Of USD, which takes one for each core by itself; None: as many as it likes."""


Start = Callable[[Work, Sequence[Named], Isolated, "Sequence[Worker]"], "Worker"]
"""A new worker, which must not hold on to what belongs to those that are there."""


def run(work: Work, files: Sequence[Named], how: Isolated, start: Start) -> list[FileResult | None]:
    """A result for each file; None where workers cannot be had."""
    with _Crew(work, files, how, start) as crew:
        return crew.run()


# What is said between this process and a worker: frames, each after its length.


class Channel(Protocol):
    """A socket, or what looks like one."""

    def fileno(self) -> int: ...
    def recv(self, size: int, /) -> bytes: ...
    def sendall(self, data: bytes, /) -> None: ...
    def close(self) -> None: ...


class _Pipes:
    """One end of a pair of pipes: importing `socket` would cost more than starting the worker."""

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


def _framed(data: bytes) -> bytes:
    return len(data).to_bytes(_HEAD, "little") + data


def _receive(channel: Channel) -> bytes:
    size = int.from_bytes(_exactly(channel, _HEAD), "little")
    return _exactly(channel, size)


def _exactly(channel: Channel, size: int) -> bytes:
    data = bytearray()
    while len(data) < size:
        if not (more := channel.recv(min(size - len(data), 1 << 20))):
            raise EOFError
        data += more
    return bytes(data)


def _rule(id: str) -> AnyRule:
    return all_rules()[id]


def packed(value: object) -> bytes:
    """Rules are known on both sides: they cross by their names."""
    stream = io.BytesIO()
    pickler = pickle.Pickler(stream, pickle.HIGHEST_PROTOCOL)
    pickler.dispatch_table = {Rule: lambda rule: (_rule, (rule.id,))}
    pickler.dump(value)
    return stream.getvalue()


def unpacked(data: bytes) -> Any:
    return pickle.loads(data)  # noqa: S301 of our own workers


# This process


@dataclass(slots=True)
class Worker:
    """A process that lints, as seen from here."""

    channel: Channel
    pid: int
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

    def give(self, numbers: Sequence[int], files: Sequence[Named]) -> None:
        self.files.extend(numbers)
        self.since = time.monotonic()
        said = tuple(n if self.knows else files[n] for n in numbers)
        with suppress(OSError):  # it has died: that is noticed where it is listened to
            self.channel.sendall(_framed(packed(said)))

    def hear(self) -> list[bytes] | None:
        """The frames that are there by now, None when there will be no more."""
        try:
            data = self.channel.recv(1 << 20)
        except OSError:
            data = b""
        if not data:
            return None
        self.heard += data
        frames = []
        while len(self.heard) >= _HEAD:
            end = _HEAD + int.from_bytes(self.heard[:_HEAD], "little")
            if len(self.heard) < end:
                break
            frames.append(bytes(self.heard[_HEAD:end]))
            del self.heard[:end]
        return frames

    def kill(self) -> None:
        with suppress(OSError):  # it has gone by itself
            os.kill(self.pid, getattr(signal, "SIGKILL", signal.SIGTERM))

    def end(self) -> int | None:
        """Its exit code, whether or not it would have gone by itself; None if it cannot be ended."""
        self.kill()
        return self.wait()

    def wait(self) -> int | None:
        self.channel.close()
        deadline = time.monotonic() + _PATIENCE
        while (code := self.gone()) is None and time.monotonic() < deadline:
            time.sleep(0.001)
        return code


class _Crew:
    """All workers of a run."""

    def __init__(self, work: Work, files: Sequence[Named], how: Isolated, start: Start) -> None:
        self._work, self._files, self._how, self._start = work, files, how, start
        self._wanted = how.count(len(files))
        fair = len(files) // (self._wanted * 4) if self._wanted > 1 else len(files)
        self._chunk = max(1, min(_CHUNK, fair))
        self._left = deque(range(len(files)))
        self._again: deque[tuple[int, int | None]] = deque()
        """On which a worker died that had done something before: that may have been the reason."""
        self._results: list[FileResult | None] = [None] * len(files)
        self._done = 0
        self._workers: list[Worker] = []
        self._given_up = False

    def __enter__(self) -> _Crew:
        return self

    def __exit__(self, *_: object) -> None:
        for worker in self._workers:
            worker.kill()
        for worker in self._workers:
            worker.end()

    def run(self) -> list[FileResult | None]:
        self._call_back()
        self._hire()
        self._how.meanwhile()
        while self._workers:
            self._listen()
            self._dismiss_the_late()
            self._hire()
            self._tell_progress()
        for index, code in self._again:  # never in this process
            self._settle(index, _died(self._files[index], code))
        return self._results

    def _call_back(self) -> None:
        while self._how.kept and self._left:
            worker = self._how.kept.pop()
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
        if (code := worker.wait()) is None:  # it has closed its end, and does not die
            worker.kill()
        if not worker.ready:
            self._given_up = True
            self._left.extendleft(reversed(worker.files))
            return
        index = worker.files.popleft()
        self._left.extendleft(reversed(worker.files))
        if worker.fresh:
            self._settle(index, _died(self._files[index], code))
        else:
            self._again.append((index, code))

    def _dismiss_the_late(self) -> None:
        now = time.monotonic()
        for worker in [*self._workers]:
            limit = self._limit(worker)
            if not limit or now - worker.since < limit:
                continue
            self._let_go(worker)
            if not worker.ready:
                self._given_up = True
            else:
                index = worker.files.popleft()
                self._settle(index, _late(self._files[index], limit))
            self._left.extendleft(reversed(worker.files))

    def _limit(self, worker: Worker) -> float:
        return self._how.timeout if worker.ready else _START_LIMIT

    def _tell_progress(self) -> None:
        if self._how.progress is not None:
            at_work = [w for w in self._workers if w.ready and w.files]
            slowest = min(at_work, key=lambda w: w.since, default=None)
            file = self._files[slowest.files[0]] if slowest else None
            self._how.progress(self._done, len(self._files), file)


def _died(file: Named, code: int | None) -> FileResult:
    name = ""
    if code is not None and code < 0:
        with suppress(ValueError):
            name = signal.Signals(-code).name
    if name == "SIGKILL":
        what, kind = "linting it was killed: it may need more memory than there is", "out-of-memory"
    elif name:
        what, kind = "USD crashed while reading it", "crashed-usd"
    else:
        what, kind = "the process that linted it ended without a result", "crashed-usd"
    how = f"{file.shown}: the process that linted it ended with {name or code}"
    return FileResult(problems=(Problem(kind, file.shown, what),), chatter=(how,))


def _late(file: Named, limit: float) -> FileResult:
    said = f"linting it took longer than {limit:g} s: --timeout allows more"
    return FileResult(problems=(Problem("timed-out", file.shown, said),))


# How a worker comes to be


def _way() -> Start | None:
    """None: nothing but this process. A host in which USD is loaded has reasons to ask for it here,
    and cannot be copied."""
    if "pxr" in sys.modules:
        return None
    # macOS forbids its own libraries in a copied process.
    if hasattr(os, "fork") and sys.platform != "darwin" and _is_alone():
        return forked
    return spawned if sys.executable and not getattr(sys, "frozen", False) else None


def _fill_closed_streams() -> None:
    """A stream that was closed leaves its number to the next pipe, which a worker would then take
    for the stream."""
    while (number := os.open(os.devnull, os.O_RDWR)) < 3:
        pass
    os.close(number)


def _is_alone() -> bool:
    """A copied process has one thread only, and every lock that another one held stays locked."""
    try:
        return sum(1 for _ in Path("/proc/self/task").iterdir()) == 1
    except OSError:
        return threading.active_count() == 1


def forked(work: Work, files: Sequence[Named], how: Isolated, others: Sequence[Worker]) -> Worker:
    """A copy of this process."""
    tasks, results, life = os.pipe(), os.pipe(), os.pipe()
    ours = _Lifeline(results[0], tasks[1], life[1])
    pid = os.fork()
    if pid == 0:

        def serve_as_copy() -> None:
            for end in (ours, *(other.channel for other in others)):
                end.close()
            _settle_down(life[0])
            serve(_Pipes(tasks[0], results[1]), work, files, how.limits(len(files)))

        _do_and_exit(serve_as_copy)
    for theirs in (tasks[0], results[1], life[0]):
        os.close(theirs)
    return Worker(ours, pid, lambda: _exit_code(pid))


class _Lifeline(_Pipes):
    """And a pipe that says nothing: it breaks when this process is gone."""

    def __init__(self, read: int, write: int, life: int) -> None:
        super().__init__(read, write)
        self._life = life

    def close(self) -> None:
        super().close()
        os.close(self._life)


def _exit_code(pid: int) -> int | None:
    try:
        ended, status = os.waitpid(pid, os.WNOHANG)
    except ChildProcessError:  # somebody ignores the ends of children
        return 0
    return os.waitstatus_to_exitcode(status) if ended else None


def _settle_down(life: int) -> None:
    """Become a process that neither speaks nor outlives its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent tells when to end
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(nothing, stream)
    if sys.platform == "linux":
        import fcntl

        # The signal that the pipe is broken reaches even a process that hangs: it ends it.
        fcntl.fcntl(life, fcntl.F_SETOWN, os.getpid())
        fcntl.fcntl(life, fcntl.F_SETFL, os.O_ASYNC)


def spawned(work: Work, files: Sequence[Named], how: Isolated, others: Sequence[Worker]) -> Worker:
    """A Python that is started anew."""
    import socket
    import subprocess

    ours, theirs = socket.socketpair()
    code = f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import begin; begin()"
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
    worker = Worker(ours, process.pid, process.poll)
    ours.settimeout(_START_LIMIT)  # it may turn out to be no Python that listens
    with suppress(OSError):
        ours.sendall(_framed(packed((work, tuple(files), how.limits(len(files))))))
    ours.settimeout(None)
    return worker


# The worker


def begin() -> None:
    """What a Python that was started as a worker does."""
    import socket

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent tells when to end
    if sys.platform == "win32":
        channel = socket.fromshare(sys.stdin.buffer.read())
    else:
        channel = socket.socket(fileno=int(sys.argv[1]))
    work, files, limits = unpacked(_receive(channel))
    _do_and_exit(lambda: serve(channel, work, files, limits))


def _do_and_exit(task: Callable[[], None]) -> NoReturn:
    """Without what Python does at its end: in a copy, what the other process still has to write or
    to clean up is not ours."""
    code = 1
    try:
        task()
        code = 0
    finally:
        os._exit(code)


def serve(channel: Channel, work: Work, files: Sequence[Named], limits: Limits) -> None:
    """Lint what is asked for, until nobody asks any more."""
    _limit_resources()
    if limits.threads is not None:  # before USD is loaded; what a person says about it stands
        os.environ.setdefault("PXR_WORK_THREAD_LIMIT", str(limits.threads))
    work.prepare()
    channel.sendall(_framed(b""))
    while True:
        try:
            asked = unpacked(_receive(channel))
        except (EOFError, OSError):
            return
        for one in asked:
            if limits.seconds and hasattr(signal, "alarm"):
                # Should nobody be left to tell that it takes too long.
                signal.alarm(math.ceil(limits.seconds) + 5)
            file = files[one] if isinstance(one, int) else one
            channel.sendall(_framed(packed(work(file))))
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
