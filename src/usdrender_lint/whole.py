"""What does a small file hold, whatever stands under its name?"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

_MOST = 1 << 26
"""Bytes that are taken from what is no plain file: some devices have no end."""


def read_whole(file: str | os.PathLike[str]) -> bytes:
    """`OSError` for what cannot be read. A pipe is waited for: the shell's `<(...)` is one."""
    with Path(file).open("rb") as stream:
        if stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
            return stream.read()
        data = stream.read(_MOST + 1)
    if len(data) > _MOST:
        raise OSError(errno.EFBIG, "it has no end")
    return data


def is_pipe(file: str | os.PathLike[str]) -> bool:
    """Whether to read it is to wait for somebody who writes into it."""
    try:
        return stat.S_ISFIFO(Path(file).stat().st_mode)
    except (OSError, ValueError):
        return False
