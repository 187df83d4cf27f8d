"""Where in a TOML text does each key and each value stand?

`tomllib` says what a text means and whether it is TOML at all, but not where. This finds the places
in a text that `tomllib` has accepted, and so judges nothing; it is used to tell of a mistake.
"""

from __future__ import annotations

import re

from ..lazily import lazily
from ..records import dataclass

Path = tuple[str | int, ...]
"""`("severity", "camera")`, `("ignore", 0)`."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """From one character of the text to before another."""

    start: int
    end: int


@dataclass(frozen=True, slots=True)
class Places:
    """For each path the places of its key and of its value. An element of a list has no key; what
    only a header or a dotted key brings about has no value."""

    keys: dict[Path, Stretch]
    values: dict[Path, Stretch]


_BLANK = lazily(r"(?:[ \t\r\n]|#[^\n]*)*")
_SPACE = lazily(r"[ \t]*")
_BARE_KEY = lazily(r"[A-Za-z0-9_-]+")
_STRING = lazily(
    r'"""(?:\\.|[^\\])*?"""(?:"{0,2})' r"|'''.*?'''(?:'{0,2})" r'|"(?:\\.|[^"\\])*"' r"|'[^']*'",
    re.S,
)
# A date may be parted from its time by a space.
_BARE_VALUE = lazily(r"\d{4}-\d\d-\d\d \d\d:[^\s,\]}#]*|[^\s,\]}#]+")


def places(text: str) -> Places:
    """Of a text in which line breaks are `\\n` alone, as `tomllib` reads it."""
    scanner = _Scanner(text)
    scanner.document()
    return Places(scanner.keys, scanner.values)


class _Scanner:
    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0
        self._last: dict[Path, int] = {}
        """Index of the newest table of each array of tables."""
        self.keys: dict[Path, Stretch] = {}
        self.values: dict[Path, Stretch] = {}

    def document(self) -> None:
        table: Path = ()
        while self._skip():
            if self._text.startswith("[", self._at):
                table = self._header()
            else:
                self._pair(table)

    def _skip(self) -> bool:
        """Whether anything is left behind blanks, line breaks and comments."""
        self._pass(_BLANK)
        return self._at < len(self._text)

    def _pass(self, pattern: re.Pattern[str]) -> Stretch:
        found = pattern.match(self._text, self._at)
        start, self._at = self._at, found.end() if found else self._at
        return Stretch(start, self._at)

    def _header(self) -> Path:
        is_array = self._text.startswith("[[", self._at)
        self._at += 1 + is_array
        path: Path = ()
        names = self._names()
        for position, (name, stretch) in enumerate(names, 1):
            path = (*path, name)
            self.keys.setdefault(path, stretch)
            if is_array and position == len(names):
                self._last[path] = self._last.get(path, -1) + 1
            if path in self._last:
                path = (*path, self._last[path])
                self.keys.setdefault(path, stretch)
        self._at += 1 + is_array
        return path

    def _names(self) -> list[tuple[str, Stretch]]:
        found = []
        while True:
            self._pass(_SPACE)
            if self._text[self._at] in "\"'":
                stretch = self._pass(_STRING)
                import tomllib

                name = tomllib.loads(f"_ = {self._text[stretch.start : stretch.end]}")["_"]
            else:
                stretch = self._pass(_BARE_KEY)
                name = self._text[stretch.start : stretch.end]
            found.append((name, stretch))
            self._pass(_SPACE)
            if not self._text.startswith(".", self._at):
                return found
            self._at += 1

    def _pair(self, table: Path) -> None:
        path = table
        for name, stretch in self._names():
            path = (*path, name)
            self.keys.setdefault(path, stretch)
        self._at += 1  # the equals sign
        self._pass(_SPACE)
        self._value(path)

    def _value(self, path: Path) -> None:
        start = self._at
        match self._text[start]:
            case "[":
                self._list(path)
            case "{":
                self._inline_table(path)
            case '"' | "'":
                self._pass(_STRING)
            case _:
                self._pass(_BARE_VALUE)
        self.values[path] = Stretch(start, self._at)

    def _list(self, path: Path) -> None:
        self._at += 1
        index = 0
        while self._skip() and self._text[self._at] != "]":
            self._value((*path, index))
            index += 1
            self._comma()
        self._at += 1

    def _inline_table(self, path: Path) -> None:
        self._at += 1
        while self._skip() and self._text[self._at] != "}":
            self._pair(path)
            self._comma()
        self._at += 1

    def _comma(self) -> None:
        self._skip()
        if self._text.startswith(",", self._at):
            self._at += 1
