"""What does a show ask for in `usdrender-lint.toml`, and where does it say so?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..patterns import Patterns
from ..records import dataclass
from ..results import Span

if TYPE_CHECKING:
    from .places import Path as TomlPath
    from .places import Places

NAME = "usdrender-lint.toml"
SHARED = "pyproject.toml"
TABLE = ("tool", "usdrender-lint")


@dataclass(frozen=True, slots=True)
class Wrong:
    """One mistake of a file, with its place if it has one."""

    file: Path
    message: str
    span: Span | None = None
    source: str | None = None


class ConfigError(Exception):
    """A configuration cannot be used: nothing is linted by another than was asked for."""

    def __init__(self, wrongs: Iterable[Wrong]) -> None:
        self.wrongs = tuple(wrongs)
        super().__init__("; ".join(f"{wrong.file}: {wrong.message}" for wrong in self.wrongs))


@dataclass(frozen=True, slots=True)
class Asked:
    """One value, and where it stands."""

    value: Any
    source: Source
    path: TomlPath

    @property
    def line(self) -> int:
        return self.source.line(self.path)


@dataclass(frozen=True, eq=False)
class Source:
    """One file of a configuration."""

    file: Path
    text: str
    table: dict[str, Any]
    above: TomlPath
    """What leads to the table in the file."""
    folder: str
    """Patterns count from here."""

    def line(self, path: TomlPath) -> int:
        found = self._places
        stretch = found.keys.get(path) or found.values[path]
        return self.text.count("\n", 0, stretch.start) + 1

    @cached_property
    def _places(self) -> Places:
        from .places import places

        return places(self.text)


@dataclass(frozen=True, eq=False)
class Configuration:
    """What holds for the files below a folder: a file and those that it extends."""

    sources: tuple[Source, ...] = ()
    """The nearest first; none: nobody says anything."""

    @property
    def file(self) -> Path | None:
        return self.sources[0].file if self.sources else None

    def asked(self, key: str) -> Asked | None:
        """By the nearest file that says it."""
        return next(self._all(key), None)

    def added(self, key: str, until: str) -> list[Asked]:
        """By all files down from the one that says `until`, which starts anew."""
        found: list[Asked] = []
        for source in self.sources:
            if key in source.table:
                found.insert(0, self._in(source, key))
            if until in source.table:
                break
        return found

    def entries(self, key: str) -> dict[str, Asked]:
        """Of a table: an entry of the nearer file stands above that of the farther one."""
        found: dict[str, Asked] = {}
        for asked in reversed([*self._all(key)]):
            for name, value in asked.value.items():
                found.pop(name, None)
                found[name] = Asked(value, asked.source, (*asked.path, name))
        return found

    def excluded(self) -> list[Patterns]:
        """Files and folders that nobody is to lint."""
        said = [self.asked("exclude"), *self.added("extend-exclude", "exclude")]
        return [Patterns(one.value, one.source.folder) for one in said if one]

    def _all(self, key: str) -> Iterator[Asked]:
        return (self._in(source, key) for source in self.sources if key in source.table)

    def _in(self, source: Source, key: str) -> Asked:
        return Asked(source.table[key], source, (*source.above, key))
