"""What is wrong with a configuration, and where does it stand?"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ..likeness import closest
from ..records import dataclass
from ..results import Span
from . import ConfigError, Source, Wrong
from .places import Path as TomlPath
from .places import Stretch, places


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that is wrong with a value, or with its key."""

    path: TomlPath
    message: str
    at_key: bool = False


def located(file: Path, text: str, faults: Iterable[Fault]) -> ConfigError:
    """The faults at their places, in the order of the text."""
    found = places(text)
    told = []
    for fault in faults:
        first, second = found.keys.get(fault.path), found.values.get(fault.path)
        stretch = (first or second) if fault.at_key else (second or first)
        stretch = stretch or Stretch(0, 0)
        told.append((stretch.start, wrong_at(file, text, stretch, fault.message)))
    return ConfigError(wrong for _, wrong in sorted(told, key=lambda one: one[0]))


def wrong_value(source: Source, path: TomlPath, message: str) -> ConfigError:
    """Of a value that is only wrong beside others, or on this machine."""
    return located(source.file, source.text, [Fault((*source.above, *path), message)])


def wrong_at(file: Path, text: str, stretch: Stretch, message: str) -> Wrong:
    """A stretch of several lines is told by its first."""
    begin = text.rfind("\n", 0, stretch.start) + 1
    line_end = text.find("\n", stretch.start)
    line_end = len(text) if line_end < 0 else line_end
    column = stretch.start - begin + 1
    end = min(stretch.end, line_end) - begin + 1
    span = Span(text.count("\n", 0, stretch.start) + 1, column, max(end, column + 1))
    return Wrong(file, message, span, text[begin:line_end])


def suggestion(word: str, known: Iterable[str]) -> str:
    """The end of a sentence about a word that is none of those known."""
    meant = closest(word, known)
    return f": did you mean '{meant}'?" if meant else ""
