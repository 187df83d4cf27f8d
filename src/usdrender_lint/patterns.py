"""Which paths does a list of patterns mean? The patterns of `.gitignore`, wherever one is asked for.

A library for it costs more to import than most runs take.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable
from functools import cache
from itertools import groupby

from .lazily import lazily


class PatternError(Exception):
    """A pattern that no path ever matches."""


class Patterns:
    """Patterns that count from one folder; the last one that matches decides."""

    def __init__(self, patterns: Iterable[str], folder: str) -> None:
        self.patterns = tuple(patterns)
        self.folder = folder
        self._folders = tuple(
            dict.fromkeys(one.rstrip(os.sep) + os.sep for one in (folder, _real(folder)))
        )
        self._groups = _compiled(self.patterns)

    def decide(self, path: str, *, is_folder: bool) -> bool | None:
        """Whether an absolute path is meant, whatever the folders above it are. None: no word of it."""
        name = self._relative(path) + ("/" if is_folder else "")
        for meant, matches in self._groups:
            if matches(name):
                return meant
        return None

    def __contains__(self, file: str) -> bool:
        """Whether a file is meant, or a folder above it."""
        if not self._groups:
            return False
        *folders, name = self._relative(file).split("/")
        above = ""
        for folder in folders:
            above += f"{folder}/"
            for meant, matches in self._groups:
                if matches(above):
                    if meant:
                        return True
                    break
        return next((meant for meant, matches in self._groups if matches(above + name)), False)

    def __bool__(self) -> bool:
        return bool(self._groups)

    def _relative(self, path: str) -> str:
        """From the folder; for what stands elsewhere, from the root of the disk."""
        for folder in self._folders:
            if path.startswith(folder):
                path = path[len(folder) :]
                break
        else:
            path = os.path.splitdrive(path)[1].lstrip(os.sep)
        return path.replace(os.sep, "/") if os.sep != "/" else path


@cache
def _real(folder: str) -> str:
    return os.path.realpath(folder)


def check(pattern: str) -> None:
    """`PatternError` for a pattern that cannot mean anything."""
    if not pattern.removeprefix("!").strip("/ "):
        raise PatternError("an empty pattern matches nothing")
    try:
        _translated(pattern.removeprefix("!"))
    except ValueError as error:
        raise PatternError(str(error)) from None


def lines_of(text: str) -> list[str]:
    """The patterns of a `.gitignore`."""
    found = []
    for line in text.split("\n"):
        line = _TRAILING.sub("", line.removesuffix("\r"))
        if line and not line.startswith("#"):
            found.append(line)
    return found


_Matches = Callable[[str], re.Match[str] | None]
_LONGEST = 1 << 13
"""Characters of a pattern; to compile one of a million takes minutes."""
_TRAILING = lazily(r"(?<!\\) +$")


@cache
def _compiled(patterns: tuple[str, ...]) -> tuple[tuple[bool, _Matches], ...]:
    """The last first; neighbours that say the same as one expression."""
    read = []
    for pattern in patterns:
        negated = pattern.startswith("!")
        try:
            read.append((not negated, _translated(pattern[negated:])))
        except ValueError:
            continue  # git passes it over, too
    return tuple(
        (meant, re.compile("|".join(one for _, one in group), re.S).fullmatch)
        for meant, group in groupby(reversed(read), lambda one: one[0])
    )


def _translated(pattern: str) -> str:
    """A regular expression of relative paths, those of folders with a `/` at the end."""
    only_folders = pattern.endswith("/")
    pattern = pattern.removesuffix("/")
    anchored = "/" in pattern
    pattern = pattern.removeprefix("/")
    if not pattern:
        raise ValueError("an empty pattern matches nothing")
    if len(pattern) > _LONGEST:
        raise ValueError("it is longer than any path")
    end = "/" if only_folders else "/?"
    if not anchored:
        return f"(?:.*/)?{_segment(pattern)}{end}"
    parts = pattern.split("/")
    found = ""
    for index, part in enumerate(parts):
        is_last = index == len(parts) - 1
        if part == "**":
            found += "[^/].*" if is_last else "(?:[^/]+/)*"
        else:
            found += _segment(part) + ("" if is_last else "/")
    return found + ("/?" if parts[-1] == "**" and not only_folders else end)


_CLASSES = {
    "alnum": "a-zA-Z0-9",
    "alpha": "a-zA-Z",
    "blank": " \\t",
    "digit": "0-9",
    "lower": "a-z",
    "punct": r"!-/:-@\[-`{-~",
    "space": r"\s",
    "upper": "A-Z",
    "xdigit": "0-9a-fA-F",
}


def _segment(part: str) -> str:
    """Of a name in a path; a folder's `/` is no empty name behind it."""
    found, at = "(?=[^/])", 0
    while at < len(part):
        char = part[at]
        at += 1
        if char == "*":
            found += "" if found.endswith("[^/]*") else "[^/]*"
        elif char == "?":
            found += "[^/]"
        elif char == "[":
            piece, at = _bracket(part, at)
            found += piece
        elif char == "\\":
            if at == len(part):
                raise ValueError("a backslash at the end stands for nothing")
            found += re.escape(part[at])
            at += 1
        else:
            found += re.escape(char)
    return found


def _bracket(part: str, at: int) -> tuple[str, int]:
    negated = part[at : at + 1] in ("!", "^")
    at += negated
    start, inside = at, ""
    while True:
        if at >= len(part):
            raise ValueError("'[' is never closed")
        char = part[at]
        if char == "]" and at > start:
            break
        if char == "[" and part.startswith("[:", at):
            end = part.find(":]", at)
            name = part[at + 2 : end]
            if end < 0 or name not in _CLASSES:
                raise ValueError(f"'{part[at:]}' begins no class of characters")
            inside += _CLASSES[name]
            at = end + 2
            continue
        low, at = _character(part, at)
        if part.startswith("-", at) and part[at + 1 : at + 2] not in ("]", ""):
            high, at = _character(part, at + 1)
            if low <= high:  # else it is empty
                inside += f"{re.escape(low)}-{re.escape(high)}"
            continue
        inside += re.escape(low)
    if negated:
        return f"(?!/)[^{inside}]" if inside else "[^/]", at + 1
    return (f"(?!/)[{inside}]" if inside else "(?!)"), at + 1


def _character(part: str, at: int) -> tuple[str, int]:
    if part[at] == "\\":
        at += 1
        if at >= len(part):
            raise ValueError("'[' is never closed")
    return part[at], at + 1
