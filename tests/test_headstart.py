"""Does a worker begin before it is known what for, and is it gone if it was for nothing?"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from conftest import ROOT, since
from usdrender_lint.__main__ import main
from usdrender_lint.processes import headstart, machine, workers

CLEAN = ROOT / "fixtures" / "clean" / "film_shot.usda"
ENVIRONMENT = os.environ | {
    "PYTHONPATH": os.pathsep.join(
        filter(None, (str(Path(workers.__file__).parents[2]), os.environ.get("PYTHONPATH")))
    )
}
linux = pytest.mark.skipif(sys.platform != "linux", reason="made where processes are copied")

PROGRAM = """
import os, sys
from pathlib import Path
from usdrender_lint.processes import headstart, workers
from usdrender_lint.__main__ import program

def copied(task, others=()):
    copy = really(task, others)
    Path("pid").write_text(str(copy.pid))
    return copy

def another(*_):
    Path("another").touch()
    raise OSError

really = headstart.copied
headstart.copied = copied
if "ALONE" in os.environ:
    workers.forked = another
program()
"""


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.chdir(tmp_path)
    yield
    assert headstart.claim() is None


def run(*args: str, **environment: str) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, "-c", PROGRAM, *args],
        capture_output=True,
        env=ENVIRONMENT | environment,
        timeout=120,
        check=False,
    )


def is_gone(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def copies_asked_for(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """None is made."""
    made: list[object] = []
    monkeypatch.setattr(headstart, "copied", lambda task, _: made.append(task))
    monkeypatch.setattr(headstart, "can_be_copied", lambda: True)
    return made


def forget() -> None:
    for _, lines in headstart._begun:
        for line in lines:
            line.close()
    headstart._begun.clear()


@pytest.mark.parametrize(
    ("args", "begins"),
    [
        ([str(CLEAN)], True),
        ([str(CLEAN.parent), "-j2"], True),
        (["-q", "-"], True),
        ([], False),
        (["--help"], False),
        (["--list-rules"], False),
        (["--explain", "dead-target"], False),
        (["missing.usda"], False),
    ],
)
def test_it_begins_where_there_may_be_something_to_lint(
    args: list[str], begins: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = copies_asked_for(monkeypatch)
    monkeypatch.delitem(sys.modules, "pxr", raising=False)
    headstart.begin(args)
    assert len(made) == begins
    forget()


@linux
def test_with_one_core_there_is_nothing_to_gain(monkeypatch: pytest.MonkeyPatch) -> None:
    made = copies_asked_for(monkeypatch)
    monkeypatch.delitem(sys.modules, "pxr", raising=False)
    for cores in ({3}, {0, 3}):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _, cores=cores: cores)
        headstart.begin([str(CLEAN)])
    assert len(made) == 1
    forget()


def test_a_host_gets_no_process_that_it_did_not_ask_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(headstart, "copied", None)
    assert main([str(CLEAN), "-j0"]) == 0


@linux
@pytest.mark.parametrize(
    ("args", "said"),
    [((), b"in 1 file"), (("-j2", str(CLEAN.with_name("forwarding.usda"))), b"in 2 files")],
)
def test_the_one_that_began_does_the_work(args: tuple[str, ...], said: bytes) -> None:
    """By itself or as two, none of which gets ready anew."""
    done = run(str(CLEAN), *args, ALONE="1")
    assert (done.returncode, done.stdout, done.stderr) == (0, b"No findings %s.\n" % said, b"")
    assert not Path("another").exists()
    assert is_gone(int(Path("pid").read_text()))


@linux
@pytest.mark.parametrize(
    "args",
    [
        ("--nonsense", str(CLEAN)),
        ("-j0", str(CLEAN)),
        ("--show-files", str(CLEAN)),
        ("--help", str(CLEAN)),
        ("--baseline", "missing.json", str(CLEAN)),
        (str(CLEAN), "--explain", "dead-target"),
    ],
)
def test_the_one_that_nobody_needs_is_gone(args: tuple[str, ...]) -> None:
    began = time.monotonic()
    done = run(*args)
    assert b"Traceback" not in done.stderr
    pid = int(Path("pid").read_text())
    while not is_gone(pid):
        assert time.monotonic() < began + 60
        time.sleep(0.01)


THREADS = """
import os, sys, time
from usdrender_lint.processes import headstart, workers
from usdrender_lint.discover import Shown, Target
from usdrender_lint.job import Config, FileResult
from usdrender_lint.registry import select
from usdrender_lint.processes.worker import Linting, Order

class Telling(Linting):
    def __call__(self, order):
        assert not super().__call__(order).problems
        from pxr import Work
        time.sleep(0.1)  # Python's own may take a moment to be gone
        threads = len(os.listdir("/proc/self/task"))
        return FileResult(chatter=(str(threads), str(Work.GetConcurrencyLimit())))

jobs, file = int(sys.argv[1]), sys.argv[2]
headstart.begin([file])
orders = [Order(Target(file, file), Config(select()))] * jobs
with workers.Isolated(jobs).keeping() as how:
    results = workers.run(Telling(Shown(None)), orders, how, workers.forked)
print(*sorted(" of ".join(r.chatter) for r in results), sep=", ")
"""


@linux
@pytest.mark.parametrize(("jobs", "said"), [(1, None), (1, "1"), (machine.cores(), None)])
def test_threads_that_usd_has_and_may_have(jobs: int, said: str | None) -> None:
    """Those that it has begun it keeps, and they take time from the other worker."""
    alone = jobs > 1 or said == "1"
    environment = {k: v for k, v in ENVIRONMENT.items() if k != "PXR_WORK_THREAD_LIMIT"}
    if said is not None:
        environment |= {"PXR_WORK_THREAD_LIMIT": said, "TF_ENV_SETTING_ALERTS_ENABLED": "0"}
    done = subprocess.run(
        [sys.executable, "-c", THREADS, str(jobs), str(CLEAN)],
        capture_output=True,
        text=True,
        env=environment,
        timeout=120,
        check=True,
    )
    told = "1 of 1" if alone else rf"\d+ of {len(os.sched_getaffinity(0))}"
    assert re.fullmatch(", ".join([told] * jobs), done.stdout.strip()), done.stdout


@since(26, 5)  # before, UsdUtils is imported for what USD says
def test_who_is_ready_has_all_that_a_stage_would_wait_for_and_one_thread() -> None:
    """Another thread would make it impossible to copy the process."""
    code = """
import sys, threading
from usdrender_lint.processes.ready import get_ready
get_ready()
modules = set(sys.modules)
from usdrender_lint.lint import lint
assert not lint(sys.argv[1:]).findings
late = [m for m in set(sys.modules) - modules if m.startswith(("pxr", "usdrender_lint.rules"))]
print(threading.active_count(), late)
"""
    done = subprocess.run(
        [sys.executable, "-c", code, str(CLEAN)],
        capture_output=True,
        text=True,
        env=ENVIRONMENT,
        timeout=120,
        check=True,
    )
    assert done.stdout == "1 []\n"


@linux
def test_with_standard_input_and_error_closed() -> None:
    done = subprocess.run(
        [
            "sh",
            "-c",
            'exec "$@" <&- 2>&-',
            "sh",
            sys.executable,
            "-m",
            "usdrender_lint",
            str(CLEAN),
        ],
        stdout=subprocess.PIPE,
        env=ENVIRONMENT,
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, b"No findings in 1 file.\n")
