"""How does a process get ready to lint, soonest?"""

from __future__ import annotations

import os
from contextlib import suppress


def get_ready() -> None:
    """Import USD, and whatever opens a stage and judges it. Meanwhile USD reads the definitions of
    its schemas, for which the first stage would wait, and which does not hold Python up.

    USD has one thread for its own use until `use_threads` gives it more. Those that it has once
    begun never end: limited afterwards, they wake up for work that they may not take, which cost
    two processes side by side a third of their time (usd-core 26.11). Before 26.11 a limit holds for
    the thread that set it: so the schemas are read in this one."""
    from threading import Thread

    from pxr import Usd

    use_threads(1)
    importing = Thread(target=_try_to_import)
    importing.start()
    try:
        Usd.SchemaRegistry()
    finally:
        importing.join()
    _import()


def _try_to_import() -> None:
    with suppress(Exception):  # raised by the next attempt
        _import()


def _import() -> None:
    from .. import lint_file  # noqa: F401 it is what will be called
    from ..registry import all_rules

    all_rules()


def use_threads(most: int | None) -> None:
    """None: as many as there are cores. What a person says about it stands above both."""
    from pxr import Work

    if "PXR_WORK_THREAD_LIMIT" in os.environ:
        return
    if most is None:
        Work.SetMaximumConcurrencyLimit()
    elif most != Work.GetConcurrencyLimit():  # USD lifts the old limit before it sets the new one
        Work.SetConcurrencyLimit(most)
