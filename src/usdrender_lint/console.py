"""How does the program speak beside its reports: to whom, in color, how wide?"""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from typing import TextIO

from .printable import escaped


def say(text: str) -> None:
    """On standard error, as far as that can be written: the exit code says it, too."""
    if sys.stderr is not None:
        try:
            sys.stderr.write(text)
            sys.stderr.flush()
        except OSError:
            forget(sys.stderr)


def forget(stream: TextIO) -> None:
    """Python flushes its streams once more at exit, and would print a traceback of its own."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def tell(sentence: str) -> None:
    say(f"{escaped(sentence)}\n")


def use_color(asked: str | None, stream: TextIO | None = None) -> bool:
    """--color over NO_COLOR over FORCE_COLOR over a terminal that can."""
    if asked is None:
        return False
    if asked != "auto":
        return asked == "always"
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return (stream or sys.stdout).isatty() and os.environ.get("TERM") != "dumb"


def terminal_width() -> int:
    import shutil

    return shutil.get_terminal_size().columns
