"""What happens when the program is run: `usdrender-lint` and `python -m usdrender_lint`."""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import NoReturn

from .processes import headstart

_SELDOM = 100_000
"""Objects between two searches for cycles, which are few here; Python's 700 cost a tenth of a run."""


class Terminated(KeyboardInterrupt):
    """Somebody asks the program to end: as for Ctrl-C, nothing half-done is left behind."""


def _terminate(*_: object) -> None:
    raise Terminated


def main(argv: Sequence[str] | None = None) -> int:
    before = None
    # A handler that is not Python's, as that of a host may be, could not be put back.
    if signal.getsignal(signal.SIGTERM) is not None:
        with suppress(ValueError):  # not the main thread of its host
            before = signal.signal(signal.SIGTERM, _terminate)
    try:
        if argv is None:
            argv = sys.argv[1:]
            headstart.begin(argv)
        from .endings import run

        return run(list(argv))
    except Terminated:
        return 143
    except KeyboardInterrupt:
        return 130
    finally:
        headstart.end()
        if before is not None:
            signal.signal(signal.SIGTERM, before)


def program() -> NoReturn:
    """The process from start to end. What it made is not put away piece by piece: the system takes
    it back at once."""
    gc.set_threshold(_SELDOM)
    code = main()
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            with suppress(OSError, ValueError):
                stream.flush()
    os._exit(code)


if __name__ == "__main__":
    program()
