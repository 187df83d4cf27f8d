"""What does USD say while it works, and how is it kept from standard error?"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from typing import Any

from pxr import Tf

from .lazily import lazily

_ADDRESS = lazily(r" <0x[0-9a-f]+>|(?<=@anon:)0x[0-9a-f]+:")
"""Of a stage or a layer in memory: nobody can follow it, and it differs from run to run."""


def sentences(said: Iterable[Any]) -> list[str]:
    """The texts of diagnostics. One that USD breaks off within a letter cannot be read at all."""
    found = []
    for one in said:
        with suppress(UnicodeDecodeError):
            found.append(_ADDRESS.sub("", one.commentary.strip()))
    return found


class Diagnostics:
    """Collects what USD would print while it is entered."""

    def __init__(self) -> None:
        self.messages: list[str] = []
        self._context: Any = None
        self._trap: Any = None

    def __enter__(self) -> Diagnostics:
        # Tf.DiagnosticTrap is absent in 25.11; importing UsdUtils costs 58 ms.
        if hasattr(Tf, "DiagnosticTrap"):
            self._context = Tf.DiagnosticTrap()
            self._trap = self._context.__enter__()
        else:
            from pxr import UsdUtils

            self._trap = UsdUtils.CoalescingDiagnosticDelegate()
        return self

    def __exit__(self, *error: object) -> None:
        self.collect()
        if self._context is not None:
            self._context.__exit__(*error)
        self._context = self._trap = None

    def collect(self) -> None:
        """Take what was said so far. What is left in a trap is printed when it ends."""
        if self._context is None:
            self.messages += sentences(self._trap.TakeUncoalescedDiagnostics())
        elif not self._trap.IsClean():
            errors, warnings = self._trap.GetErrors(), self._trap.GetWarnings()
            self.messages += sentences([*errors, *warnings, *self._trap.GetStatuses()])
            self._trap.Clear()
