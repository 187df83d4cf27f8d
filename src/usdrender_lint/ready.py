"""How does a process get ready to lint, soonest?"""

from __future__ import annotations


def get_ready() -> None:
    """Import USD, and whatever opens a stage and judges it. Meanwhile USD reads the definitions of
    its schemas, for which the first stage would wait, and which does not hold Python up.

    USD has one thread for its own use until `use_threads` gives it more. Those that it has once
    begun never end: limited afterwards, they wake up for work that they may not take, which cost
    two processes side by side a third of their time (usd-core 26.11)."""
    from threading import Thread

    from pxr import Usd, Work

    Work.SetConcurrencyLimit(1)
    schemas = Thread(target=Usd.SchemaRegistry)
    schemas.start()
    try:
        from . import lint_file  # noqa: F401 it is what will be called
        from .registry import all_rules

        all_rules()
    finally:
        schemas.join()


def use_threads(most: int | None) -> None:
    """None: as many as there are cores. What a person says about it (`PXR_WORK_THREAD_LIMIT`) stands
    above both."""
    from pxr import Work

    if most is None:
        Work.SetMaximumConcurrencyLimit()
    elif most != Work.GetConcurrencyLimit():  # USD lifts the old limit before it sets the new one
        Work.SetConcurrencyLimit(most)
