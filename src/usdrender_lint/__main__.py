"""What happens when the program is run: `usdrender-lint` and `python -m usdrender_lint`."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import NoReturn

_SELDOM = 100_000
"""Objects between two searches for cycles, which are few here; Python's 700 cost a tenth of a run."""


def main(argv: Sequence[str] | None = None) -> int:
    try:
        from .cli import run

        return run(list(sys.argv[1:] if argv is None else argv))
    except KeyboardInterrupt:  # while modules are still being imported
        return 130


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
