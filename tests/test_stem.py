"""Does a copy become several that work as one would, and is nothing left of them?"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from test_workers import Doing, named, told
from usdrender_lint.discover import Target
from usdrender_lint.job import FileResult
from usdrender_lint.processes import copies
from usdrender_lint.processes import stem as stems
from usdrender_lint.processes.copies import Lifeline, Line, Pipes, awaited, copied
from usdrender_lint.processes.stem import Stem
from usdrender_lint.processes.worker import serve_whatever
from usdrender_lint.processes.workers import Isolated, Worker, forked, run

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="made there only"),
    # The tests themselves may have loaded USD, with its threads; the program never has.
    pytest.mark.filterwarnings("ignore:.*multi-threaded, use of fork.*:DeprecationWarning"),
]


@dataclass(frozen=True)
class Slow(Doing):
    """So that no process takes what another one should."""

    def __call__(self, file: Target) -> FileResult:
        time.sleep(0.2)
        return super().__call__(file)


@dataclass(frozen=True)
class Family(Slow):
    """Tells who made the process."""

    def __call__(self, file: Target) -> FileResult:
        return replace(super().__call__(file), chatter=(str(os.getpid()), str(os.getppid())))


def laid(count: int) -> Stem:
    """A copy of this process, and so many lines to what it may become."""
    lines = [Line() for _ in range(count)]
    theirs = [line.theirs for line in lines]

    def wait(channel: Pipes) -> None:
        serve_whatever(channel, theirs)

    copy = copied(wait, [line.ours for line in lines])
    for end in theirs:
        end.close()
    return Stem(copy, [line.ours for line in lines])


@contextmanager
def crew(jobs: int, lines: int, timeout: float = 0.0) -> Iterator[tuple[Isolated, int]]:
    """How to lint with a stem, and the number of its process. Nothing is left of either."""
    before = opened()
    stem = laid(lines)
    pid = stem._copy.pid
    try:
        yield Isolated(jobs, timeout, stem=[stem]), pid
    finally:
        stem.end()
        children = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    assert str(pid) not in children
    assert opened() == before


def opened() -> set[str]:
    return {entry.name for entry in Path("/proc/self/fd").iterdir()}


def no_other(*_: object) -> Worker:
    raise AssertionError("a worker that has to get ready")


def pids(results: list[FileResult | None]) -> list[tuple[int, int]]:
    return [(int(r.chatter[0]), int(r.chatter[1])) for r in results if r]


def test_several_work_each_a_copy_of_the_one_that_was_ready() -> None:
    with crew(2, 3) as (how, stem):
        results = run(Family(), named("a", "b", "c"), how, no_other)
    assert told(results) == ["a", "b", "c"]
    found = pids(results)
    assert len({pid for pid, _ in found}) == 2
    assert {parent for _, parent in found} == {stem}


def test_one_is_enough_where_one_is_wanted() -> None:
    with crew(1, 3) as (how, stem):
        results = run(Family(), named("a", "b"), how, no_other)
        assert pids(results) == [(stem, os.getpid())] * 2


def test_more_than_there_are_lines_get_ready_themselves() -> None:
    with crew(3, 2) as (how, stem):
        results = run(Family(), named("a", "b", "c"), how, forked)
    assert sorted(parent for _, parent in pids(results)) == sorted([os.getpid(), stem, stem])


def test_what_kills_one_of_them_is_told_and_costs_no_other() -> None:
    names = ["abort", "a", "b", "killed", "exit", "c", "speaks-abort", "d"]
    with crew(2, 2) as (how, _):
        results = run(Doing(), named(*names), how, forked)
    died = {"killed": "out-of-memory"} | dict.fromkeys(
        ("abort", "exit", "speaks-abort"), "crashed-usd"
    )
    assert told(results) == [died.get(name, name) for name in names]
    assert [r and "what was said last" in r.chatter for r in results] == [
        "speaks" in n for n in names
    ]
    assert results[0] is not None
    assert results[0].chatter == ("abort: the process that linted it ended with SIGABRT",)


def test_one_that_hangs_is_ended() -> None:
    with crew(2, 2, timeout=0.5) as (how, _):
        results = run(Doing(), named("sleep", "a", "b"), how, forked)
    assert told(results) == ["timed-out", "a", "b"]


def test_they_work_on_where_the_one_that_made_them_was_killed() -> None:
    """Only how one of them ended is not known then."""

    killed = []

    def kills(*_: object) -> None:
        if not killed:
            os.kill(stem, signal.SIGKILL)
            killed.append(stem)

    with crew(2, 2) as (how, stem):
        results = run(Slow(), named("a", "b", "abort", "c"), replace(how, progress=kills), forked)
    assert told(results) == ["a", "b", "crashed-usd", "c"]
    assert killed


def test_a_process_with_a_thread_is_not_copied(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever lock that thread holds would stay locked. Others are started then."""
    monkeypatch.setattr(stems, "is_alone", lambda: False)
    with crew(2, 2) as (how, _):
        results = run(Family(), named("a", "b"), how, forked)
    assert told(results) == ["a", "b"]
    assert {parent for _, parent in pids(results)} == {os.getpid()}


def test_where_only_some_can_be_made_the_others_are_started(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    really, made = stems.copied_to, list[int]()

    def once(*args: Any) -> int:
        if made:
            raise BlockingIOError
        made.append(1)
        return really(*args)

    monkeypatch.setattr(stems, "copied_to", once)
    with crew(2, 2) as (how, stem):
        results = run(Family(), named("a", "b"), how, forked)
    assert {parent for _, parent in pids(results)} == {stem, os.getpid()}


def test_one_that_has_died_before_is_no_harm() -> None:
    with crew(2, 2) as (how, stem):
        os.kill(stem, signal.SIGKILL)
        assert told(run(Doing(), named("a", "b"), how, forked)) == ["a", "b"]


def test_one_that_is_told_to_end_before_it_has_begun_never_does(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Its lifeline is cut before it holds on to it."""
    really = copies._settle_down

    def late(line: Lifeline) -> None:
        assert line.life is not None
        line.recv(1)  # until the other end of the line is closed
        really(line)

    monkeypatch.setattr(copies, "_settle_down", late)
    copy = copied(lambda _: (tmp_path / "begun").touch())
    copy.channel.close()
    assert awaited(copy.gone) == 1
    assert not (tmp_path / "begun").exists()


@pytest.mark.parametrize("when", ["meanwhile", "progress"])
def test_an_interrupt_ends_all_of_them(when: str) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    began = time.monotonic()
    with crew(2, 2) as (how, _), pytest.raises(KeyboardInterrupt):
        run(Doing(), named("sleep", "sleep"), replace(how, **{when: interrupted}), no_other)
    assert time.monotonic() - began < 60
