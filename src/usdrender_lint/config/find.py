"""Which configuration holds for a file? That of the nearest folder above it which has one."""

from __future__ import annotations

import os
from pathlib import Path

from ..whole import is_pipe, read_whole
from . import NAME, SHARED, TABLE, ConfigError, Configuration, Wrong

NOTHING = Configuration()


class Configurations:
    """Those of one run; each folder is looked at once."""

    def __init__(self, fixed: Configuration | None = None) -> None:
        self._fixed = fixed
        """One that somebody named: it holds for every file."""
        self._of_folder: dict[str, Configuration] = {}
        self._repositories: dict[str, str | None] = {}

    def of(self, folder: str) -> Configuration:
        """For the files in an absolute folder. The search ends with the repository."""
        if self._fixed is not None:
            return self._fixed
        waiting: list[str] = []
        at = folder
        while at not in self._of_folder:
            waiting.append(at)
            found = configuration_in(at)
            above = os.path.dirname(at)
            if found is not None or above == at or is_repository(at):
                self._of_folder[at] = found or NOTHING
                break
            at = above
        found = self._of_folder[at]
        self._of_folder.update(dict.fromkeys(waiting, found))
        return found

    def enter(self, folder: str, *, is_repository: bool, may_speak: bool) -> None:
        """Spare the questions about a folder that a search has looked into."""
        above = os.path.dirname(folder)
        if is_repository:
            self._repositories[folder] = folder
        elif above in self._repositories:
            self._repositories[folder] = self._repositories[above]
        if not may_speak and (is_repository or above in self._of_folder):
            self._of_folder[folder] = NOTHING if is_repository else self._of_folder[above]

    def of_file(self, file: str) -> Configuration:
        """For an absolute one."""
        return self.of(os.path.dirname(file))

    def of_files_in(self, path: str) -> Configuration:
        """Of a file, or of those in a folder."""
        path = absolute(path)
        return self.of(path if os.path.isdir(path) else os.path.dirname(path))

    def root(self, path: str) -> str | None:
        """The folder from which a file or folder is told: its repository, else its show."""
        path = absolute(path)
        folder = path if os.path.isdir(path) else os.path.dirname(path)
        if found := self.repository(folder):
            return found
        file = self.of(folder).file
        if file is None:
            return None
        home = str(file.parent).rstrip(os.sep) + os.sep
        return str(file.parent) if f"{folder}{os.sep}".startswith(home) else None

    def repository(self, folder: str) -> str | None:
        """The nearest folder that holds `.git`."""
        waiting: list[str] = []
        at = folder
        while at not in self._repositories:
            waiting.append(at)
            above = os.path.dirname(at)
            if above == at or is_repository(at):
                self._repositories[at] = at if is_repository(at) else None
                break
            at = above
        found = self._repositories[at]
        self._repositories.update(dict.fromkeys(waiting, found))
        return found


def absolute(path: str | Path) -> str:
    """Without `..`, and with symbolic links as given: a show is where it is seen."""
    plain = os.path.abspath(path)
    if ".." in os.fspath(path) and not _same(plain, path):
        return os.path.realpath(path)  # a link stands before the `..`
    return plain


def _same(one: str, other: str | Path) -> bool:
    try:
        return os.path.samefile(one, other)
    except OSError:
        return not os.path.lexists(other)


def is_repository(folder: str) -> bool:
    return os.path.exists(os.path.join(folder, ".git"))


def configuration_in(folder: str) -> Configuration | None:
    """Of a folder itself. A file of its own stands above what a project's file says."""
    for name in (NAME, SHARED):
        file = os.path.join(folder, name)
        if is_pipe(file):
            raise ConfigError([Wrong(Path(file), "a named pipe, not a file")])
        if os.path.lexists(file) and (name == NAME or _speaks(Path(file))):
            from .read import configuration

            return configuration(Path(file), folder)
    return None


def _speaks(file: Path) -> bool:
    """Most projects say nothing to this program: what their file says is not worth a parser."""
    try:
        if TABLE[1].encode() not in read_whole(file):
            return False
    except OSError:
        pass  # it is told when the file is loaded
    from .read import has_table
    from .toml import load

    return has_table(load(file)[1])
