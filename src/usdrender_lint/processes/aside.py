"""What do libraries print to standard error by themselves, past all that Python could catch?

It is told with `-v`, and never stands between what this program says.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import IO

_STDERR = 2
_MOST = 2000
"""Bytes to be told; whoever prints more repeats himself."""


class Aside:
    """A file that takes what is printed. `number`: one that another process holds, too, which can
    ask it should this one die."""

    def __init__(self, number: int | None = None) -> None:
        self._file: IO[bytes] | None = None
        if number is not None:
            self._number = os.dup(number)
        elif hasattr(os, "memfd_create"):
            self._number = os.memfd_create("stderr")
        else:
            from tempfile import TemporaryFile  # gone with the process, whatever ends it

            self._file = TemporaryFile(buffering=0)  # noqa: SIM115 closed below
            self._number = self._file.fileno()
        os.dup2(self._number, _STDERR)

    def taken(self) -> tuple[str, ...]:
        """What was printed since this was asked."""
        _flush()
        size = os.lseek(self._number, 0, os.SEEK_CUR)
        if not size:
            return ()
        os.lseek(self._number, 0, os.SEEK_SET)
        said = os.read(self._number, _MOST)
        os.ftruncate(self._number, 0)
        os.lseek(self._number, 0, os.SEEK_SET)
        return _told(said, size)

    def close(self) -> None:
        if self._file is None:
            os.close(self._number)
        else:
            self._file.close()


def last_words(number: int) -> tuple[str, ...]:
    """What another process has printed into that file, and did not live to take."""
    return _told(os.pread(number, _MOST, 0), os.fstat(number).st_size)


def _told(said: bytes, size: int) -> tuple[str, ...]:
    text = said.decode(errors="replace").strip()
    if size > _MOST:
        text += f" ... and {size - _MOST} bytes more"
    return (text,) if text else ()


@contextmanager
def listening(number: int | None = None) -> Iterator[Aside | None]:
    """Nothing is printed meanwhile. None where there is no standard error, or no room for a file."""
    _flush()
    try:
        before = os.dup(_STDERR)
    except OSError:
        yield None
        return
    aside = None
    with suppress(OSError):
        aside = Aside(number)
    try:
        yield aside
    finally:
        _flush()
        os.dup2(before, _STDERR)
        os.close(before)
        if aside is not None:
            aside.close()


def _flush() -> None:
    if sys.stderr is not None:
        with suppress(OSError, ValueError):
            sys.stderr.flush()
