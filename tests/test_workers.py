"""Nothing brings a run down: not a crash or a hang of USD, not a signal, not what stands in a folder."""

from __future__ import annotations

import faulthandler
import json
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from conftest import ROOT
from usdrender_lint.__main__ import main
from usdrender_lint.discover import Shown, Target
from usdrender_lint.formats import FORMATS
from usdrender_lint.job import Config, FileResult
from usdrender_lint.lint import lint
from usdrender_lint.processes import machine, worker, workers
from usdrender_lint.processes.aside import listening
from usdrender_lint.processes.frames import packed, unpacked
from usdrender_lint.processes.workers import Isolated, Worker, forked, run, spawned
from usdrender_lint.registry import select
from usdrender_lint.testing import BASE

CLEAN = ROOT / "fixtures" / "clean" / "film_shot.usda"
posix = pytest.mark.skipif(os.name == "nt", reason="signals and special files are others there")
linux = pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")

pytestmark = pytest.mark.filterwarnings(
    # The tests themselves may have loaded USD, with its threads; the program never has.
    "ignore:.*multi-threaded, use of fork.*:DeprecationWarning"
)

STARTS = [
    pytest.param(forked, marks=pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")),
    spawned,
]
"""Both ways to a worker, whichever this system would take."""


@dataclass(frozen=True)
class Doing:
    """Does what the names of files say."""

    prepared: str = ""

    def prepare(self, threads: int | None) -> None:
        if self.prepared:
            self(Target(self.prepared, self.prepared))

    def __call__(self, file: Target) -> FileResult:
        name = file.shown
        faulthandler.disable()  # pytest's, which would speak in a copied process, too
        if "speaks" in name:
            os.write(2, b"what was said last\n")
        if "abort" in name:
            os.abort()
        if "killed" in name:
            os.kill(os.getpid(), signal.SIGKILL)
        if "exit" in name:
            os._exit(3)
        if "raise" in name:
            raise RuntimeError(name)
        if "sleep" in name:
            time.sleep(600)
        if "greedy" in name:
            bytearray(400_000_000)
        return FileResult(layers=(name,), chatter=(str(os.getpid()),))


@dataclass(frozen=True)
class DyingLater(Doing):
    """Dies of what it did before, unless there was nothing before."""

    def __call__(self, file: Target) -> FileResult:
        faulthandler.disable()
        if DID:
            os.abort()
        DID.append(file.shown)
        return FileResult(layers=(file.shown,))


DID: list[str] = []


@dataclass(frozen=True)
class Telling(Doing):
    def prepare(self, threads: int | None) -> None:
        DID.append(str(threads))

    def __call__(self, file: Target) -> FileResult:
        return FileResult(chatter=(DID[-1],))


@dataclass(frozen=True)
class Printing(Doing):
    def __call__(self, file: Target) -> FileResult:
        os.write(2, file.shown.encode())
        return FileResult(chatter=("said",))


def named(*names: str) -> list[Target]:
    return [Target(name, name) for name in names]


def told(results: list[FileResult | None]) -> list[str]:
    """The name for what was linted, the kind of the problem for what was not."""
    return [
        "nothing" if r is None else r.problems[0].kind if r.problems else r.layers[0]
        for r in results
    ]


# What libraries print


@pytest.mark.parametrize("start", STARTS)
def test_what_a_file_makes_a_worker_print_is_told_of_it(
    start: workers.Start, capfd: pytest.CaptureFixture[str]
) -> None:
    results = run(Printing(), named("one", "", "\n", "x" * 5000), Isolated(1), start)
    assert [r.chatter for r in results if r] == [
        ("said", "one"),
        ("said",),
        ("said",),
        ("said", f"{'x' * 2000} ... and 3000 bytes more"),
    ]
    assert capfd.readouterr().err == ""


def printing(asked: list[Any], shown: Shown) -> list[FileResult]:
    os.write(2, b"posix_madvise failed\n")
    return [FileResult(layers=(file.shown,)) for file, _ in asked]


def test_what_is_printed_in_this_process_is_told_with_v_only(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workers, "lint_here", printing)
    monkeypatch.delitem(sys.modules, "pxr", raising=False)
    for more, told in (((), False), (("-v",), True)):
        main(["-j", "0", "--isolated", *more, str(CLEAN)])
        said = capfd.readouterr()
        assert "posix_madvise" not in said.err
        assert ("USD: posix_madvise failed" in said.out) is told
    os.write(2, b"heard again")
    assert capfd.readouterr().err == "heard again"


def test_a_host_hears_what_is_printed(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """All its threads share one standard error, and so does whatever it runs beside a lint."""
    monkeypatch.setattr(workers, "lint_here", printing)
    assert "pxr" in sys.modules
    main(["-j", "0", "--isolated", str(CLEAN)])
    assert capfd.readouterr().err == "posix_madvise failed\n"


def test_no_file_is_left_of_what_is_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Where it cannot be kept in memory."""
    monkeypatch.delattr(os, "memfd_create", raising=False)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with listening() as aside:
        os.write(2, b"aside")
        assert aside is not None
        assert aside.taken() == ("aside",)
        assert aside.taken() == ()
        assert os.name == "nt" or not [*tmp_path.iterdir()]  # not even if the process is killed
    assert not [*tmp_path.iterdir()]
    assert capfd.readouterr().err == ""


# Death and delay


@posix
@pytest.mark.parametrize(("start", "jobs"), [(forked, 1), (forked, 2), (forked, 5), (spawned, 3)])
def test_a_file_that_kills_its_worker_costs_no_other(start: workers.Start, jobs: int) -> None:
    names = ["abort", "a", "b", "killed", "exit", "c", "raise", "abort-2", "abort-3", "d"]
    results = run(Doing(), named(*names), Isolated(jobs), start)
    died = {"killed": "out-of-memory"} | dict.fromkeys(
        ("abort", "exit", "raise", "abort-2", "abort-3"), "crashed-usd"
    )
    assert told(results) == [died.get(name, name) for name in names]
    assert results[0] is not None
    assert results[0].problems[0].message.startswith("USD crashed while reading it: ")
    assert results[0].chatter == ("abort: the process that linted it ended with SIGABRT",)


@pytest.mark.parametrize("start", STARTS)
def test_a_file_that_takes_too_long_costs_no_other(start: workers.Start) -> None:
    began = time.monotonic()
    results = run(Doing(), named("a", "sleep", "b", "c"), Isolated(1, timeout=0.5), start)
    assert told(results) == ["a", "timed-out", "b", "c"]
    assert results[1] is not None
    assert results[1].problems[0].message.startswith("linting it took longer than 0.5 s")
    assert time.monotonic() - began < 60


@linux
@pytest.mark.parametrize("jobs", [1, 2])
def test_last_words_are_told(jobs: int) -> None:
    """Of a worker that dies or hangs: they may name the guilty layer."""
    names = ["a", "speaks", "speaks-abort", "b", "speaks-sleep"]
    results = run(Doing(), named(*names), Isolated(jobs, timeout=1), forked)
    assert told(results) == ["a", "speaks", "crashed-usd", "b", "timed-out"]
    said = ["what was said last" in r.chatter for r in results if r]
    assert said == ["speaks" in name for name in names]


@posix
def test_a_worker_that_was_harmed_before_blames_no_innocent_file() -> None:
    results = run(DyingLater(), named("a", "b", "c"), Isolated(1), forked)
    assert told(results) == ["a", "b", "c"]


@posix
def test_memory_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    """The worker's Python is told by an exception, which ends it."""
    monkeypatch.setattr(worker, "most_memory", lambda: 300_000_000)
    if sys.platform != "linux":
        pytest.skip("RLIMIT_DATA counts something else there")
    assert told(run(Doing(), named("a", "greedy", "b"), Isolated(1), forked)) == [
        "a", "crashed-usd", "b"
    ]  # fmt: skip


def test_an_exhausted_memory_is_no_bug(monkeypatch: pytest.MonkeyPatch) -> None:
    from usdrender_lint import lint_file

    def fails(_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(lint_file._File, "lint", fails)
    problem = lint([str(CLEAN)]).problems[0]
    assert (problem.kind, "bug" in problem.message) == ("out-of-memory", False)


@pytest.mark.parametrize("start", STARTS)
def test_where_no_worker_lives_nothing_is_claimed(start: workers.Start) -> None:
    """A file that was not looked at has no result."""
    assert told(run(Doing("exit"), named("a", "b"), Isolated(2), start)) == ["nothing"] * 2


def test_where_no_worker_can_be_started_nothing_is_claimed() -> None:
    def fails(*_: object) -> Worker:
        raise BlockingIOError

    assert run(Doing(), named("a", "b"), Isolated(2), fails) == [None, None]


@posix
def test_a_file_that_killed_a_worker_is_never_tried_here() -> None:
    """Not even if no other worker can be had."""
    started = []

    def once(*args: object) -> Worker:
        if started:
            raise BlockingIOError
        started.append(1)
        return forked(*args)  # type: ignore[arg-type]

    assert told(run(Doing(), named("a", "abort", "b"), Isolated(1), once)) == [
        "a", "crashed-usd", "nothing"
    ]  # fmt: skip


def test_what_no_worker_took_is_linted_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "_way", lambda: None)
    files = [Target(str(CLEAN), "film_shot.usda")]
    asked = [(file, Config()) for file in files]
    assert Isolated()(asked, Shown()) == Isolated(0)(asked, Shown())


@linux
@pytest.mark.parametrize("start", STARTS)
def test_nothing_is_left_open(start: workers.Start) -> None:
    def count() -> int:
        return sum(1 for _ in Path("/proc/self/fd").iterdir())

    before = count()
    run(Doing(), named("a", "abort", "b", "sleep"), Isolated(2, timeout=0.5), start)
    assert count() == before


@linux
@pytest.mark.parametrize("failing", ["pipe", "fork"])
def test_nothing_is_left_open_where_no_process_can_be_had(
    failing: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    really, asked = os.pipe, list[int]()

    def opened() -> set[Path]:
        return {*Path("/proc/self/fd").iterdir()}

    def fails() -> tuple[int, int]:
        asked.append(1)
        if len(asked) < 3 and failing == "pipe":
            return really()
        raise BlockingIOError

    monkeypatch.setattr(os, failing, fails)
    before = opened()
    assert run(Doing(), named("a", "b"), Isolated(2), forked) == [None, None]
    assert opened() == before


def test_what_goes_wrong_in_a_worker_is_not_taken_for_its_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One that waits for work ends well only if nobody has any."""
    asked: list[str] = []

    def fails(*_: object) -> None:
        asked.append("served")
        raise OSError("a library that cannot be loaded")

    monkeypatch.setattr(worker, "serve", fails)
    ours, theirs = socket.socketpair()
    with ours, theirs:
        ours.sendall(worker.introduced(Doing(), (), worker.Limits(0, None)))
        with pytest.raises(OSError, match="cannot be loaded"):
            worker.serve_whatever(theirs)
        ours.close()
        worker.serve_whatever(theirs)
    assert asked == ["served"]


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_worker_that_waits_takes_the_next_run(start: workers.Start, jobs: int) -> None:
    started = []

    def counted(*asked: object) -> Worker:
        started.append(asked)
        return start(*asked)  # type: ignore[arg-type]

    with Isolated(jobs).keeping() as how:
        assert told(run(Doing(), named("a", "b"), how, counted)) == ["a", "b"]
        (kept,) = how.kept or ()
        before = len(started)
        assert told(run(Doing(), named("c"), how, counted)) == ["c"]
        assert len(started) == before
        assert how.kept == [kept]
    assert kept.gone() is not None


@posix
def test_a_worker_that_died_while_it_waited_costs_nothing() -> None:
    with Isolated(1).keeping() as how:
        assert told(run(Doing(), named("a"), how, forked)) == ["a"]
        (kept,) = how.kept or ()
        kept.stop()
        assert told(run(Doing(), named("b", "abort"), how, forked)) == ["b", "crashed-usd"]


def test_a_pause_of_all_is_nobodys_delay() -> None:
    """Ctrl-Z stops the workers with the program."""
    worker = Worker(None, 0, lambda: None, ready=True, since=100.0)  # type: ignore[arg-type]
    crew = workers._Crew(Doing(), named("a"), Isolated(), forked)
    crew._workers.append(worker)
    crew._forgive(0.3)
    assert worker.since == 100.0
    crew._forgive(30.0)
    assert worker.since == 130.0
    crew._workers.clear()


# In a host


def test_threads_lint_one_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two at a time would each give back a standard error that is not the host's."""
    from usdrender_lint import lint_file

    inside, most, errors = 0, [0], sys.stderr

    def composed(*_: object) -> FileResult:
        nonlocal inside
        inside += 1
        most.append(inside)
        time.sleep(0.02)
        inside -= 1
        return FileResult()

    monkeypatch.setattr(lint_file._File, "_composed", composed)
    threads = [threading.Thread(target=lint, args=([str(CLEAN)],)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert (max(most), len(most)) == (1, 5)
    assert sys.stderr is errors


@pytest.mark.parametrize("handler", [None, signal.SIG_DFL])
def test_what_a_host_does_when_it_is_terminated_stays(
    handler: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    """None: something that is not Python's, which Python could take away and not give back."""
    handlers = [handler]
    monkeypatch.setattr(signal, "getsignal", lambda _: handlers[-1])
    monkeypatch.setattr(signal, "signal", lambda _, new: handlers.append(new) or handlers[-2])
    assert main([str(CLEAN), "-j0", "-q"]) == 0
    assert handlers[-1] is handler
    assert len(handlers) == (1 if handler is None else 3)


# What crosses


def test_results_cross_unchanged() -> None:
    folder = ROOT / "fixtures" / "bad"
    config = Config(select(["ALL"]), variants=True)
    files = [Target(str(f), f.name) for f in sorted(folder.glob("*.usda"))]
    results = workers.lint_here([(file, config) for file in files], Shown())
    assert sum(len(r.findings) for r in results) > 100
    assert unpacked(packed(results)) == results
    crossed = unpacked(packed(results))
    rules = [(a.rule, b.rule) for r, c in zip(results, crossed, strict=True) for a, b in zip(r.findings, c.findings, strict=True)]  # fmt: skip
    assert all(a is b for a, b in rules)
    assert unpacked(packed(config)) == config


def test_what_python_can_pickle_crosses() -> None:
    pattern = re.compile("a+", re.I)
    assert unpacked(packed((pattern,))) == (pattern,)


def test_work_is_shared_fairly() -> None:
    assert [Isolated().count(n) for n in (1, 11)] == [1, 1]
    assert Isolated(4).count(2) == 2
    assert Isolated(10_000).count(10_000) == workers.MOST
    assert 1 <= Isolated().count(1000) <= machine.cores()


@pytest.mark.parametrize("start", STARTS)
def test_workers_share_the_cores(start: workers.Start, monkeypatch: pytest.MonkeyPatch) -> None:
    """USD starts a thread for each core, in every process."""
    monkeypatch.setattr(workers, "cores", lambda: 8)
    for jobs, threads in ((1, "None"), (2, "4"), (3, "2")):
        results = run(Telling(), named("a", "b", "c"), Isolated(jobs), start)
        assert [r and r.chatter for r in results] == [(threads,)] * 3


@pytest.mark.parametrize(
    ("said", "cores"),
    [
        ({}, 8),
        ({"cpu.max": "max 100000"}, 8),
        ({"cpu.max": "200000 100000"}, 2),
        ({"cpu.max": "20000 100000"}, 1),
        ({"cpu/cpu.cfs_quota_us": "-1", "cpu/cpu.cfs_period_us": "100000"}, 8),
        ({"cpu/cpu.cfs_quota_us": "300000", "cpu/cpu.cfs_period_us": "100000"}, 3),
    ],
)
def test_cores_that_may_be_used(
    said: dict[str, str], cores: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, text in said.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(f"{text}\n")
    monkeypatch.setattr(machine, "_GROUPS", tmp_path)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)), raising=False)
    assert machine.cores() == cores


def test_memory_that_may_be_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "_GROUPS", tmp_path)
    whole = machine.most_memory()
    (tmp_path / "memory.max").write_text("1000000\n")
    assert machine.most_memory() == 800_000
    (tmp_path / "memory.max").write_text("max\n")
    assert machine.most_memory() == whole


# The program as a process


ENVIRONMENT = os.environ | {
    "PYTHONPATH": os.pathsep.join(
        filter(None, (str(Path(workers.__file__).parents[2]), os.environ.get("PYTHONPATH")))
    )
}

SLOW = """
import os, pathlib, sys, time
from usdrender_lint.processes import workers
from usdrender_lint.__main__ import main

def slow(self, file, /):
    pathlib.Path("pid").write_text(str(os.getpid()))
    time.sleep(float(os.environ.get("SLOW", "600")))
    return linted(self, file)

linted = workers.Linting.__call__
workers.Linting.__call__ = slow
sys.exit(main(sys.argv[1:]))
"""
"""The program with a worker that takes its time."""

LESS = """
import os, signal
import multiprocessing, random, subprocess, tempfile  # Python's own modules ask for some of it
for module, names in (
    (os, ("fork", "memfd_create", "sched_getaffinity", "mkfifo", "getuid", "WNOHANG")),
    (signal, ("SIGKILL", "SIGIO", "SIGALRM", "SIGHUP", "alarm", "pthread_sigmask")),
):
    for name in names:
        vars(module).pop(name, None)
subprocess.Popen.kill = subprocess.Popen.terminate
"""
"""As on Windows, as far as it can be tried elsewhere."""

STARTED: list[subprocess.Popen[bytes]] = []


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.chdir(tmp_path)
    yield
    while STARTED:
        process = STARTED.pop()
        process.kill()
        process.communicate()


def start(code: str, *args: str) -> subprocess.Popen[bytes]:
    process = subprocess.Popen(
        [sys.executable, "-c", code, *args],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=ENVIRONMENT,
    )
    STARTED.append(process)
    return process


def lint_with(*args: str, timeout: float = 120) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, "-m", "usdrender_lint", *args],
        capture_output=True,
        env=ENVIRONMENT,
        timeout=timeout,
    )


def pid_of_worker() -> int:
    def written() -> bool:
        return Path("pid").exists() and Path("pid").read_text() != ""

    wait_until(written)
    return int(Path("pid").read_text())


def wait_until(true: Callable[[], bool], seconds: float = 60) -> None:
    deadline = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def is_gone(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


@linux
@pytest.mark.parametrize(
    ("sent", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)]
)
@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_signal_ends_the_program_and_its_workers(
    sent: signal.Signals, code: int, jobs: str
) -> None:
    process = start(SLOW, str(CLEAN), str(CLEAN.with_name("stereo.usda")), "-j", jobs, "--output-file", "out.json")  # fmt: skip
    worker = pid_of_worker()
    began = time.monotonic()
    process.send_signal(sent)
    out, err = process.communicate(timeout=30)
    assert (process.returncode, out, err) == (code, b"", b"")
    wait_until(lambda: is_gone(worker), 10)
    assert time.monotonic() - began < 5  # 0.1 on a machine that does nothing else
    assert {file.name for file in Path().iterdir()} == {"pid"}


@pytest.mark.parametrize("jobs", ["", "-j1", "-j2", "-j0"])
def test_usd_is_loaded_where_files_are_opened_only(jobs: str) -> None:
    code = """
import sys
from usdrender_lint.__main__ import main
main(sys.argv[1:])
print("pxr" in sys.modules)
"""
    args = [jobs] if jobs else []
    process = start(code, str(CLEAN), str(CLEAN.with_name("stereo.usda")), "-q", *args)
    loaded = process.communicate(timeout=60)[0].split()[-1]
    assert loaded == (b"True" if jobs == "-j0" else b"False")


def test_the_same_bytes_however_many_workers() -> None:
    paths = [str(ROOT / "fixtures" / name) for name in ("bad", "broken", "clean")]
    runs = {"-j0": paths, "-j1": paths[::-1], "-j3": [*paths, *paths]}
    written = []
    for jobs, given in runs.items():
        files = [f"--output-file={chosen}:{chosen}" for chosen in FORMATS]
        done = lint_with(*given, *files, "-v", jobs, "--output-format", "concise")
        texts = {chosen: Path(chosen).read_bytes() for chosen in FORMATS}
        written.append((done.returncode, done.stdout, done.stderr, texts))
    assert written[0][0] == 2
    assert b"USD: " in written[0][1]
    assert all(len(text) > 1000 for text in written[0][3].values())
    assert written[1:] == written[:1] * 2


@linux
def test_progress_is_shown_on_a_terminal_and_leaves_nothing() -> None:
    import pty

    for letter in "abc":
        Path(f"{letter}\x1b[31m.usda").write_text(BASE)
    environment = ENVIRONMENT | {"SLOW": "1.2", "TERM": "xterm", "COLUMNS": "80"}
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", SLOW, ".", "-j1"],
        stdout=subprocess.PIPE, stderr=theirs, env=environment,
    )  # fmt: skip
    STARTED.append(process)
    os.close(theirs)
    seen = b""
    try:
        while more := os.read(ours, 4096):
            seen += more
    except OSError:  # the terminal's other end is closed
        pass
    os.close(ours)
    lines = seen.decode().split("\r")
    assert any(line.startswith("[######..............] 1/3  b\\x1b[31m.usda") for line in lines)
    assert "\x1b" not in seen.decode()
    assert lines[-1] == ""
    assert lines[-2].strip() == ""
    assert len(lines[-2]) == max(map(len, lines)) < 80
    assert max(map(len, lines)) > 0


@pytest.mark.parametrize("args", [(), ("-q",)])
def test_no_progress_where_nobody_looks(args: tuple[str, ...]) -> None:
    Path("a.usda").write_text(CLEAN.read_text("utf-8"), "utf-8")
    process = start(SLOW.replace('"600"', '"2.5"'), "a.usda", *args)
    assert process.communicate(timeout=60)[1] == b""


def test_limits_that_make_no_sense_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    for wrong in ("--timeout=-1", "--timeout=nan", "--timeout=inf", "--jobs=-1", "-jx"):
        assert main([str(CLEAN), wrong]) == 2
        assert "error: Invalid value" in capsys.readouterr().err


def test_no_timeout_is_no_limit() -> None:
    assert lint_with(str(CLEAN), "--timeout", "0").returncode == 0


# What may stand in a folder


def error_lines(*args: str) -> list[str]:
    done = lint_with(*args, "-q")
    assert done.returncode == 2
    assert b"\x1b" not in done.stdout + done.stderr
    return done.stderr.decode().splitlines()


@posix
def test_what_is_no_file_is_told_and_not_opened() -> None:
    os.mkfifo("pipe.usda")
    Path("zeros.usdc").symlink_to("/dev/zero")
    Path("loop.usda").symlink_to("loop.usda")
    Path("folder.usda").mkdir()
    Path("folder.usda", "good.usda").write_text(CLEAN.read_text("utf-8"), "utf-8")
    with socket.socket(socket.AF_UNIX) as one:
        one.bind("socket.usd")
        found = error_lines(".", "--timeout", "30")
    assert [line for line in found if "loop" not in line] == [
        "error: pipe.usda: a named pipe, not a file",
        "error: socket.usd: a socket, not a file",
        "error: zeros.usdc: a device, not a file",
    ]
    assert error_lines("/dev/zero")[0].endswith("not a USD file by its name: expected .usd, .usda, .usdc or .usdz")  # fmt: skip


@posix
@pytest.mark.parametrize(
    "layer",
    [
        "(\n    subLayers = [@./pipe.usda@]\n)\n",
        "(\n    subLayers = [@./below.usda@]\n)\n",
        'def Scope "Render" (\n    references = @./pipe.usda@</Render>\n)\n{\n}\n',
        'def Scope "Render" (\n    payload = @./pipe.usda@\n)\n{\n}\n',
    ],
)
def test_a_pipe_that_a_layer_brings_in_is_told_and_not_waited_for(layer: str) -> None:
    os.mkfifo("pipe.usda")
    Path("below.usda").write_text("#usda 1.0\n(\n    subLayers = [@./pipe.usda@]\n)\n")
    Path("top.usda").write_text(f"#usda 1.0\n{layer}")
    by = "below" if "below" in layer else "top"
    assert error_lines("top.usda") == [
        f"error: pipe.usda: a named pipe, not a file (brought in by {by}.usda)"
    ]


@posix
@pytest.mark.parametrize("odd", ["pipe", "link", "far"])
def test_a_pipe_is_found_among_many_files(odd: str) -> None:
    """A folder of which a layer names many files is looked through, as far as that pays."""
    Path("parts").mkdir()
    for number in range(40):
        Path("parts", f"{number}.usda").write_text("#usda 1.0\n")
    for number in range(1000 if odd == "far" else 0):
        Path("parts", f"other_{number}.usda").touch()
    os.mkfifo("parts/pipe" if odd == "link" else "parts/a.usda")
    if odd == "link":
        Path("parts/a.usda").symlink_to("pipe")
    arcs = ", ".join(f"@./parts/{name}.usda@" for name in [*range(40), "a"])
    Path("top.usda").write_text(f'#usda 1.0\ndef "R" (\n    references = [{arcs}]\n)\n{{\n}}\n')
    assert error_lines("top.usda") == [
        "error: parts/a.usda: a named pipe, not a file (brought in by top.usda)"
    ]


@posix
def test_a_pipe_in_the_neighborhood_is_not_waited_for() -> None:
    """Layers beside a given one are read to learn whether they use it, in the program itself."""
    os.mkfifo("pipe.usda")
    Path("part.usda").write_text(BASE.replace("</World/main_cam>", "</World/cam>"), "utf-8")
    Path("shot.usda").write_text(
        "#usda 1.0\n(\n    subLayers = [@./part.usda@, @./pipe.usda@]\n)\n"
    )
    assert lint_with("part.usda", timeout=60).returncode == 1


@posix
def test_a_pipe_that_is_found_too_late_costs_its_file_only() -> None:
    """Behind a reference, where nobody looked: the limit of time is the last net."""
    os.mkfifo("pipe.usda")
    Path("below.usda").write_text(
        '#usda 1.0\ndef "R" (\n    references = @./pipe.usda@</R>\n)\n{\n}\n'
    )
    Path("top.usda").write_text('#usda 1.0\ndef Scope "Render" (\n    references = @./below.usda@</R>\n)\n{\n}\n')  # fmt: skip
    Path("good.usda").write_text(CLEAN.read_text("utf-8"), "utf-8")
    done = lint_with("top.usda", "good.usda", "--timeout", "3")
    assert done.stderr.decode().startswith("error: top.usda: linting it took longer than 3 s")
    assert done.stdout.decode().startswith("No findings in 1 file.\n")
    assert done.returncode == 2


@posix
def test_a_file_that_vanishes_on_the_way_is_no_bug(monkeypatch: pytest.MonkeyPatch) -> None:
    from usdrender_lint import opening

    file = Path("gone.usda")
    file.write_text("#usda 1.0\ndef\n")

    def looked(name: str) -> None:
        Path(name).unlink()

    monkeypatch.setattr(opening, "look", looked)
    problems = lint(["gone.usda"]).problems
    assert [(p.kind, "bug" in p.message) for p in problems] == [("unreadable-file", False)]


@posix
def test_ten_thousand_paths() -> None:
    Path("a.usda").write_text(CLEAN.read_text("utf-8"), "utf-8")
    names = [f"./{'./' * (n % 50)}{n % 7}.usda" for n in range(9_999)]
    done = lint_with("a.usda", *names, "--output-format", "json")
    report = json.loads(done.stdout)
    assert (done.returncode, report["files"], len(report["errors"])) == (2, 1, 7)


@posix
@pytest.mark.parametrize("chosen", FORMATS)
def test_a_name_that_is_no_text_is_told_in_every_format(chosen: str) -> None:
    """Where the file system keeps such names at all."""
    try:
        Path(os.fsdecode(b"caf\xe9.usda")).write_text(CLEAN.read_text("utf-8"), "utf-8")
    except OSError:
        pytest.skip("no such names here")
    done = lint_with(".", "--output-format", chosen)
    assert done.returncode == 2
    assert done.stderr.decode().endswith(": its name is not UTF-8, which USD needs\n")
    done.stdout.decode()


HANGS = (1761, 1)
"""A byte of a crate, and a value with which USD 26.11 mostly never ends to read it. Sometimes it dies
of it or refuses it, for it goes by what happens to be in its memory."""


def test_a_crate_that_hangs_or_kills_usd_costs_itself_only() -> None:
    data = bytearray((ROOT / "fixtures" / "formats" / "scene.usdc").read_bytes())
    data[HANGS[0]] = HANGS[1]
    Path("a.usdc").write_bytes(data)
    Path("b.usda").write_text(CLEAN.read_text("utf-8"), "utf-8")
    done = lint_with("a.usdc", "b.usda", "--timeout", "4", "--output-format", "json")
    report = json.loads(done.stdout)
    assert (done.returncode, report["files"]) == (2, 1)
    assert [e["path"] for e in report["errors"]] == ["a.usdc"]


@pytest.mark.parametrize("jobs", ["-j1", "-j2"])
def test_with_what_every_system_offers(jobs: str) -> None:
    """The program and its workers, which are started anew where no process can be copied."""
    Path("site").mkdir()
    Path("site", "sitecustomize.py").write_text(LESS)
    path = os.pathsep.join((str(Path("site").absolute()), ENVIRONMENT["PYTHONPATH"]))
    code = "from usdrender_lint.processes import workers; workers.lint_here = None; from usdrender_lint.__main__ import program; program()"
    done = subprocess.run(
        [sys.executable, "-c", code, str(CLEAN), str(CLEAN.with_name("stereo.usda")), jobs],
        capture_output=True,
        env=ENVIRONMENT | {"PYTHONPATH": path},
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.endswith(b" in 2 files.\n")
