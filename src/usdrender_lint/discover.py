"""Which root layers does a list of paths mean?"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

from .records import dataclass
from .results import Problem

USD_SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")


@dataclass(frozen=True, slots=True)
class Target:
    """A root layer to lint."""

    file: Path
    """Absolute, symbolic links of folders kept as given."""
    shown: str
    about: tuple[str, ...] = ()
    """Real paths of the layers on whose behalf it is linted: only what concerns one of them is told."""


class Shown:
    """How paths are written in every report: relative to the repository, with `/`.

    Relative to the folder above the current one that holds `.git`, else to the
    current folder; so a report is the same on every machine and from every folder
    of a checkout.
    """

    def __init__(self, cwd: Path | None = None) -> None:
        here = (cwd or Path.cwd()).absolute()
        self.root = next((p for p in (here, *here.parents) if (p / ".git").exists()), here)

        self._known: dict[str | Path, str] = {}

    def __call__(self, path: str | Path) -> str:
        if path not in self._known:
            self._known[path] = self._spelt(path)
        return self._known[path]

    def _spelt(self, path: str | Path) -> str:
        try:
            return os.path.relpath(path, self.root).replace(os.sep, "/")
        except ValueError:  # another drive on Windows
            return Path(path).absolute().as_posix()


class RealPaths(dict[str, str]):
    """Links resolved; each path once."""

    def __missing__(self, file: str) -> str:
        self[file] = os.path.realpath(file)
        return self[file]


def discover(paths: Iterable[str], shown: Shown) -> tuple[list[Target], list[Problem]]:
    """Targets in the order of their shown paths, each file once, and every path that gave none."""
    targets: dict[str, Target] = {}
    problems: list[Problem] = []
    for given in dict.fromkeys(paths):
        path = Path(given)
        if not given.strip():
            problems.append(
                Problem("missing-path", "", "an empty path names no file and no folder")
            )
            continue
        if _is_folder(path):
            refused: list[OSError] = []
            found = [Path(p) for p in _usd_files(path, refused)]
            problems.extend(_unsearched(error, shown) for error in refused)
            if not found and not refused:
                problems.append(
                    Problem("no-usd-files", shown(path), "no USD file in this folder or below it")
                )
        elif problem := _not_there(path, shown):
            problems.append(problem)
            continue
        elif path.suffix.lower() not in USD_SUFFIXES:
            expected = ", ".join(USD_SUFFIXES[:-1]) + f" or {USD_SUFFIXES[-1]}"
            problems.append(
                Problem(
                    "unreadable-file",
                    shown(path),
                    f"not a USD file by its name: expected {expected}",
                )
            )
            continue
        else:
            found = [path]
        for file in found:
            absolute = file.absolute()
            key = os.path.realpath(absolute)
            targets.setdefault(key, Target(absolute, shown(absolute)))
    return sorted(targets.values(), key=lambda t: t.shown), problems


def _is_folder(path: Path) -> bool:
    with suppress(OSError):  # below a folder that may not be entered
        return path.is_dir()
    return False


def _not_there(path: Path, shown: Shown) -> Problem | None:
    try:
        path.lstat()
    except (FileNotFoundError, NotADirectoryError):
        return Problem("missing-path", shown(path), "no such file or folder")
    except OSError as error:
        return Problem("unreadable-file", shown(path), f"cannot be read: {_reason(error)}")
    return None


def _unsearched(error: OSError, shown: Shown) -> Problem:
    where = shown(str(error.filename))
    return Problem("unreadable-folder", where, f"cannot be searched: {_reason(error)}")


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()


def _usd_files(folder: Path, refused: list[OSError]) -> Iterator[str]:
    for where, folders, files in os.walk(folder, onerror=refused.append):
        folders[:] = [f for f in folders if not f.startswith(".")]
        for name in files:
            if name.lower().endswith(USD_SUFFIXES) and not name.startswith("."):
                yield str(Path(where, name))
