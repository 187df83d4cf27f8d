"""What can be made ready while this process finds out what is asked of it?

Importing USD takes longer than all the rest of a small run. So a worker begins with it at once, as a
copy of this process, and is told what its work is when that is known.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from functools import partial

from .copies import Copy, Lifeline, Line, Pipes, can_be_copied, copied, fill_closed_streams

_MOST = 16
"""Lines that are laid in advance: one costs 30 us."""

_begun: list[tuple[Copy, list[Lifeline]]] = []
"""At most one, and the lines that it has to spare."""


def begin(argv: Sequence[str]) -> None:
    """If anything on the command line is there to be linted. Without a word where it cannot be done:
    then the work begins when it is known."""
    if not any(arg == "-" or os.path.exists(arg) for arg in argv):
        return
    if "pxr" in sys.modules or not can_be_copied():
        return
    # Only Linux tells, and only there lines can be cut.
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 0
    if cores == 1:  # nothing would be done meanwhile, and much would be imported twice
        return
    fill_closed_streams()
    lines: list[Line] = []
    try:
        lines.extend(Line() for _ in range(min(cores, _MOST)))
        theirs = [line.theirs for line in lines]
        ours = [line.ours for line in lines]
        copy = copied(partial(_get_ready, lines=theirs), ours)
    except OSError:  # too many processes, or no memory for one more
        for line in lines:
            line.ours.close()
            line.theirs.close()
        return
    for end in theirs:
        end.close()
    _begun.append((copy, ours))


def _get_ready(channel: Pipes, lines: Sequence[Lifeline]) -> None:
    from .ready import get_ready

    get_ready()
    from .worker import serve_whatever

    serve_whatever(channel, lines)


def claim() -> tuple[Copy, list[Lifeline]] | None:
    """The copy and its lines, for the one who asks first."""
    return _begun.pop() if _begun else None


def end() -> None:
    """Nobody has claimed it."""
    if begun := claim():
        begun[0].kill()
