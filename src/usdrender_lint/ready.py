"""How does a process get ready to lint, soonest?"""

from __future__ import annotations


def get_ready() -> None:
    """Import USD, and whatever opens a stage and judges it. Meanwhile USD reads the definitions of
    its schemas, for which the first stage would wait, and which does not hold Python up."""
    from threading import Thread

    from pxr import Usd

    schemas = Thread(target=Usd.SchemaRegistry)
    schemas.start()
    try:
        from . import lint_file  # noqa: F401 it is what will be called
        from .registry import all_rules

        all_rules()
    finally:
        schemas.join()
