"""How much of this machine may the program use?"""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path

_GROUPS = Path("/sys/fs/cgroup")
_SHARE = 0.8
"""Of the memory: what is left keeps the rest of the machine alive."""


def cores() -> int:
    """As many as this process may run on: a container, a farm's slot or `taskset` may give it fewer
    than there are."""
    if hasattr(os, "sched_getaffinity"):
        count = len(os.sched_getaffinity(0))
    else:
        count = os.cpu_count() or 1
    quota = _quota()
    return max(1, count if quota is None else min(count, round(quota)))


def _quota() -> float | None:
    """Cores that a container may keep busy on average, in both versions of Linux's control groups."""
    limit, _, period = _said("cpu.max").partition(" ")
    if not limit:
        limit, period = _said("cpu/cpu.cfs_quota_us"), _said("cpu/cpu.cfs_period_us")
    if limit.isdigit() and period.isdigit() and int(period):
        return int(limit) / int(period)
    return None


def most_memory() -> int | None:
    """Bytes that one process may fill; None where nobody tells how much there is."""
    found = []
    if sys.platform != "win32":
        with suppress(ValueError, OSError):
            found.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    for name in ("memory.max", "memory/memory.limit_in_bytes"):
        if (said := _said(name)).isdigit():
            found.append(int(said))
    return int(min(found) * _SHARE) if found else None


def _said(name: str) -> str:
    try:
        return (_GROUPS / name).read_text("ascii").strip()
    except (OSError, UnicodeDecodeError):
        return ""
