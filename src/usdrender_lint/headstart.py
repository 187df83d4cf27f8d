"""What can be made ready while this process finds out what is asked of it?

Importing USD takes longer than all the rest of a small run. So a worker begins with it at once, as a
copy of this process, and is told what its work is when that is known.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from .copies import Copy, Pipes, can_be_copied, copied, fill_closed_streams

_begun: list[Copy] = []
"""At most one."""


def begin(argv: Sequence[str]) -> None:
    """If anything on the command line is there to be linted. Without a word where it cannot be done:
    then the work begins when it is known."""
    if not any(arg == "-" or os.path.exists(arg) for arg in argv):
        return
    if "pxr" in sys.modules or not can_be_copied() or _has_one_core():
        return
    fill_closed_streams()
    try:
        _begun.append(copied(_get_ready))
    except OSError:  # too many processes, or no memory for one more
        return


def _has_one_core() -> bool:
    """Nothing would be done meanwhile, and what both import would be imported twice."""
    return hasattr(os, "sched_getaffinity") and len(os.sched_getaffinity(0)) == 1


def _get_ready(channel: Pipes) -> None:
    from .ready import get_ready

    get_ready()
    from .worker import serve_whatever

    serve_whatever(channel)


def claim() -> Copy | None:
    """The copy, for the one who asks first."""
    return _begun.pop() if _begun else None


def end() -> None:
    """Nobody has claimed it."""
    if copy := claim():
        copy.kill()
