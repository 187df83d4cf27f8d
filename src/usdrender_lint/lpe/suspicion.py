"""How is it said that an expression is not what was meant?"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from ..records import dataclass
from .tree import Part


class Edit(NamedTuple):
    """What to write instead, from one offset (from 0) to another."""

    start: int
    end: int
    text: str


@dataclass(frozen=True, slots=True)
class Suspicion:
    """Something in an expression that its author cannot have meant."""

    message: str
    column: int
    """In code points, from 1."""
    edit: Edit | None = None

    def meant(self, text: str) -> str | None:
        """The whole expression as it was probably meant."""
        return edited(text, [self.edit]) if self.edit else None


def instead(part: Part, text: str) -> Edit:
    start = part.column - 1
    return Edit(start, start + len(str(part)), text)


def edited(text: str, edits: Iterable[Edit]) -> str:
    """Of edits that overlap only the first is made."""
    pieces: list[str] = []
    at = 0
    for edit in sorted(edits):
        if edit.start >= at:
            pieces += text[at : edit.start], edit.text
            at = edit.end
    return "".join((*pieces, text[at:]))
