"""Which root layers does a list of paths mean?"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import field
from pathlib import Path

from . import gitignore
from .config import NAME, SHARED, Configuration
from .config.find import Configurations, absolute
from .handed import bytes_at
from .packages import split_package
from .patterns import Patterns
from .records import dataclass
from .results import Problem

USD_SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")
STDIN = "<stdin>"


@dataclass(frozen=True, slots=True)
class Target:
    """A root layer to lint."""

    file: str
    """Absolute, symbolic links of folders kept as given."""
    shown: str
    about: tuple[str, ...] = ()
    """Real paths of the layers on whose behalf it is linted: only what concerns one of them is told."""


class Shown:
    """How paths are written in every report: relative to the repository, with `/`.

    Relative to the folder that holds `.git`, else to that of the configuration, else to the current
    one; so a report is the same on every machine and from every folder of a show.
    """

    def __init__(self, cwd: Path | None = None, root: str | None = None) -> None:
        here = str((cwd or Path.cwd()).absolute())
        self.root = Path(root or Configurations().repository(here) or here)
        self._above = str(self.root).rstrip(os.sep) + os.sep
        self._known: dict[str | Path, str] = {}
        self._named: dict[str, str] = {}

    def __call__(self, path: str | Path) -> str:
        known = self._known.get(path)
        if known is None:
            known = self._known[path] = self._spelt(path)
        return known

    def call(self, path: str, name: str) -> None:
        """Write a path as this name."""
        self._known[path] = self._known[Path(path)] = self._named[path] = name

    def below(self, path: str) -> str:
        """Of an absolute path without `..`, of which there may be a hundred thousand."""
        if path in self._named:
            return self._named[path]
        if path.startswith(self._above):
            return path[len(self._above) :].replace(os.sep, "/")
        return self(path)

    def _spelt(self, path: str | Path) -> str:
        plain = os.path.normpath(path)
        if plain.startswith(self._above):
            return plain[len(self._above) :].replace(os.sep, "/")
        try:
            return os.path.relpath(path, self.root).replace(os.sep, "/")
        except ValueError:  # another drive on Windows
            return Path(path).absolute().as_posix()


class RealPaths(dict[str, str]):
    """Links resolved; each path once, and so each folder above many of them."""

    def __missing__(self, file: str) -> str:
        folder, name = os.path.split(file)
        # Windows tells a path as the disk spells it.
        is_plain = os.sep == "/" and folder.startswith("/") and name not in ("", ".", "..")
        if is_plain and not os.path.islink(file):
            self[file] = os.path.join(self[folder], name)
        else:
            self[file] = os.path.realpath(file)
        return self[file]


def root_of(paths: Iterable[str], configurations: Configurations) -> str | None:
    """The one folder from which all given paths are told, if there is one. It goes by them and not by
    the current folder: artists lint from anywhere."""
    found = {configurations.root(path) for path in paths}
    return found.pop() if len(found) == 1 else None


@dataclass(frozen=True, slots=True)
class Shard:
    """One of several runs that share the files."""

    number: int
    """From 1."""
    of: int

    def __str__(self) -> str:
        return f"shard-{self.number}-of-{self.of}"

    def __contains__(self, shown: str) -> bool:
        """By the path alone: a file that is added moves no other into another shard."""
        import hashlib

        digest = hashlib.sha256(shown.encode("utf-8", "surrogateescape")).digest()
        return int.from_bytes(digest[:8], "big") % self.of == self.number - 1


@dataclass(frozen=True, slots=True)
class Found:
    """What a list of paths means."""

    files: list[Target] = field(default_factory=list)
    """In the order of their shown paths, each file once."""
    problems: list[Problem] = field(default_factory=list)
    """Every path that gave none."""
    excluded: list[str] = field(default_factory=list)
    """Paths that were named, and are excluded; as shown."""


def discover(
    paths: Iterable[str],
    shown: Shown,
    configurations: Configurations | None = None,
    exclude: Patterns | None = None,
    *,
    gitignored: bool = False,
) -> Found:
    """`exclude` beside what the configurations exclude; `gitignored` finds what git leaves out, too."""
    search = _Search(configurations or Configurations(), exclude, gitignored=gitignored)
    targets: dict[str, Target] = {}
    found = Found()
    for given in dict.fromkeys(paths):
        path = absolute(given) if given.strip() else ""
        if not path:
            said = "an empty path names no file and no folder"
            found.problems.append(Problem("missing-path", "", said))
            continue
        is_folder = os.path.isdir(path)
        is_handed = bytes_at(path) != path
        if not is_folder and not is_handed and (problem := _no_file(path, shown)):
            found.problems.append(problem)
            continue
        if search.excludes(path + os.sep * is_folder):
            found.excluded.append(shown.below(path))
            continue
        files = search.below(path) if is_folder else search.named(path)
        for file in files:
            real, target = search.real(file), Target(file, shown.below(file))
            known = targets.get(real)
            # Of several names of one file that of the file itself, and not of a link to it; what is
            # handed over stands for all of them.
            if known is None or search.rank(target) < search.rank(known):
                targets[real] = target
        if is_folder:
            found.problems.extend(search.problems(path, shown))
            if search.only_excluded:
                found.excluded.append(shown.below(path))
    found.files.extend(sorted(targets.values(), key=lambda target: target.shown))
    return found


class _Search:
    """Looks into folders, into none twice."""

    def __init__(
        self, configurations: Configurations, exclude: Patterns | None, *, gitignored: bool
    ) -> None:
        self._configurations = configurations
        self._exclude = (exclude,) if exclude else ()
        self._gitignored = gitignored
        self._of_configuration: dict[Configuration, tuple[Patterns, ...]] = {}
        self._real_folders: dict[str, str] = {}
        self._links: set[str] = set()
        self._start("")

    def _start(self, folder: str) -> None:
        self._folder = folder
        self._refused: list[OSError] = []
        self._files = self._left_out = self._ignored = 0

    def below(self, folder: str) -> Iterator[str]:
        """The USD files in a folder and in those below it. Links to folders are not followed: what
        they lead to stands elsewhere, or above."""
        self._start(folder)
        repository = self._configurations.repository(folder)
        ignored: gitignore.Ignored = ()
        if repository and not self._gitignored:
            ignored = gitignore.above(folder, repository)
        waiting = [(folder, ignored)]
        while waiting:
            where, ignored = waiting.pop()
            try:
                with os.scandir(where) as entries:
                    inside = list(entries)
            except OSError as error:
                self._refused.append(error)
                continue
            ignored = self._enter(where, {entry.name for entry in inside}, ignored)
            exclude, real = self._excluded_in(where), self._real_folder(where)
            for entry in inside:
                name = entry.name
                if name.startswith("."):
                    continue
                is_folder = entry.is_dir(follow_symlinks=False)
                if not is_folder and not name.lower().endswith(USD_SUFFIXES):
                    continue
                if _decided(exclude, entry.path, is_folder=is_folder):
                    self._left_out += 1
                elif gitignore.leaves_out(ignored, entry.path, is_folder=is_folder):
                    self._ignored += 1
                elif is_folder:
                    self._real_folders[entry.path] = f"{real}{os.sep}{name}"
                    waiting.append((entry.path, ignored))
                elif not entry.is_symlink():
                    self._files += 1
                    yield entry.path
                elif not _is_folder(entry):
                    self._files += 1
                    self._links.add(entry.path)
                    yield entry.path

    def named(self, file: str) -> list[str]:
        if os.path.islink(file):
            self._links.add(file)
        return [file]

    def _enter(self, folder: str, names: set[str], ignored: gitignore.Ignored) -> gitignore.Ignored:
        """What git leaves out in a folder that holds these names."""
        is_repository = ".git" in names
        self._configurations.enter(
            folder, is_repository=is_repository, may_speak=NAME in names or SHARED in names
        )
        if self._gitignored:
            return ()
        if is_repository and folder != self._folder:
            ignored = gitignore.of_repository(folder)
        if gitignore.FILE in names and (is_repository or self._configurations.repository(folder)):
            ignored = gitignore.within(ignored, folder)
        return ignored

    def _excluded_in(self, folder: str) -> tuple[Patterns, ...]:
        configuration = self._configurations.of(folder)
        if configuration not in self._of_configuration:
            found = (*self._exclude, *configuration.excluded())
            self._of_configuration[configuration] = found
        return self._of_configuration[configuration]

    def excludes(self, path: str) -> bool:
        """Whether a path that is named is excluded, or a folder above it; that of a folder ends with
        the separator."""
        return any(path in patterns for patterns in self._excluded_in(os.path.dirname(path)))

    @property
    def only_excluded(self) -> bool:
        """Whether nothing was found in the folder because somebody wants none of it linted."""
        return bool(self._left_out) and not (self._files or self._ignored or self._refused)

    def problems(self, folder: str, shown: Shown) -> Iterator[Problem]:
        """What kept the search from finding anything, or all there is."""
        yield from (_unsearched(error, shown) for error in self._refused)
        if self._ignored and not (self._files or self._refused):
            said = (
                "git ignores all that may be USD in this folder: name the files, or --no-gitignore"
            )
            yield Problem("no-usd-files", shown(folder), said)
        elif not (self._files or self._refused or self._left_out):
            said = "no USD file in this folder or below it"
            yield Problem("no-usd-files", shown(folder), said)

    def rank(self, target: Target) -> tuple[bool, bool, str]:
        file = target.file
        return bytes_at(file) == file, file in self._links, target.shown

    def real(self, file: str) -> str:
        """By which a file is known, whatever links lead to it."""
        if file in self._links:
            return os.path.realpath(file)
        folder, _, name = file.rpartition(os.sep)
        return f"{self._real_folder(folder)}{os.sep}{name}"

    def _real_folder(self, folder: str) -> str:
        if folder not in self._real_folders:
            self._real_folders[folder] = os.path.realpath(folder or os.sep).rstrip(os.sep)
        return self._real_folders[folder]


def _is_folder(link: os.DirEntry[str]) -> bool:
    try:
        return link.is_dir()
    except OSError:  # a link that leads to itself is told when it is to be opened
        return False


def _decided(all_patterns: tuple[Patterns, ...], path: str, *, is_folder: bool) -> bool:
    return any(patterns.decide(path, is_folder=is_folder) for patterns in all_patterns)


def _no_file(path: str, shown: Shown) -> Problem | None:
    """Why a path that is no folder is no USD file."""
    try:
        os.lstat(path)
    except (FileNotFoundError, NotADirectoryError):
        package, member = split_package(path)
        if member and os.path.isfile(package):
            said = f"a member of a package is linted with all of it: name {shown(package)}"
            return Problem("missing-path", shown(path), said)
        return Problem("missing-path", shown(path), "no such file or folder")
    except OSError as error:
        return Problem("unreadable-file", shown(path), f"cannot be read: {_reason(error)}")
    if not path.lower().endswith(USD_SUFFIXES):
        expected = ", ".join(USD_SUFFIXES[:-1]) + f" or {USD_SUFFIXES[-1]}"
        said = f"not a USD file by its name: expected {expected}"
        return Problem("unreadable-file", shown(path), said)
    return None


def _unsearched(error: OSError, shown: Shown) -> Problem:
    where = shown(str(error.filename))
    return Problem("unreadable-folder", where, f"cannot be searched: {_reason(error)}")


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()
