"""What does git leave out of a folder? Its patterns, from the files that git reads them from.

Only those of the repository: what a person's own git leaves out would make the report another on
every machine.
"""

from __future__ import annotations

import os
from collections.abc import Sequence

from .patterns import Patterns, lines_of
from .whole import is_pipe, read_whole

FILE = ".gitignore"

Ignored = tuple[Patterns, ...]
"""The nearest first: it decides before those of the folders above."""


def of_repository(folder: str) -> Ignored:
    """What `.git/info/exclude` of a repository says."""
    return _added((), os.path.join(_git(folder), "info", "exclude"), folder)


def above(folder: str, repository: str) -> Ignored:
    """What holds in a folder by the word of the folders above it."""
    found = of_repository(repository)
    if folder == repository:
        return found
    at = repository
    for name in ("", *os.path.relpath(os.path.dirname(folder), repository).split(os.sep)):
        if name != ".":
            at = os.path.join(at, name) if name else at
            found = within(found, at)
    return found


def within(ignored: Ignored, folder: str) -> Ignored:
    """What holds in a folder that has a file of its own, beside what holds above it."""
    return _added(ignored, os.path.join(folder, FILE), folder)


def leaves_out(ignored: Ignored, path: str, *, is_folder: bool) -> bool:
    for patterns in ignored:
        decided = patterns.decide(path, is_folder=is_folder)
        if decided is not None:
            return decided
    return False


def _added(ignored: Ignored, file: str, folder: str) -> Ignored:
    try:
        if is_pipe(file):
            return ignored
        text = read_whole(file).decode(errors="surrogateescape")
        lines: Sequence[str] = lines_of(text)
    except OSError:
        return ignored  # git passes over what it cannot read, too
    return (Patterns(lines, folder), *ignored) if lines else ignored


def _git(folder: str) -> str:
    """The folder that holds `info`; a worktree names it in a file."""
    git = os.path.join(folder, ".git")
    try:
        with open(git, encoding="utf-8", errors="surrogateescape") as stream:
            named = stream.read().removeprefix("gitdir:").strip()
        git = os.path.join(folder, named)
        with open(os.path.join(git, "commondir"), encoding="utf-8") as stream:
            return os.path.join(git, stream.read().strip())
    except OSError:
        return git
    except ValueError:  # it names a folder by what is no name: a NUL, or no UTF-8
        return os.path.join(folder, ".git")
