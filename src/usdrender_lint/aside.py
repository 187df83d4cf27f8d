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
    """A file that takes what is printed."""

    def __init__(self) -> None:
        self._file: IO[bytes] | None = None
        if hasattr(os, "memfd_create"):
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
        text = os.read(self._number, _MOST).decode(errors="replace").strip()
        os.ftruncate(self._number, 0)
        os.lseek(self._number, 0, os.SEEK_SET)
        if size > _MOST:
            text += f" ... and {size - _MOST} bytes more"
        return (text,) if text else ()

    def close(self) -> None:
        if self._file is None:
            os.close(self._number)
        else:
            self._file.close()


@contextmanager
def listening() -> Iterator[Aside | None]:
    """Nothing is printed meanwhile. None where there is no standard error, or no room for a file."""
    _flush()
    try:
        before = os.dup(_STDERR)
    except OSError:
        yield None
        return
    aside = None
    with suppress(OSError):
        aside = Aside()
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
