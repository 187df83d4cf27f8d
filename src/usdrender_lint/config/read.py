"""What does a configuration file ask for, with all that it extends?"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from .. import __version__
from ..whole import is_pipe
from . import SHARED, TABLE, ConfigError, Configuration, Source, Wrong
from .keys import FILE_OF_KEYS
from .kinds import faults
from .toml import load
from .wrong import located, wrong_value

_LONGEST = 64
"""Files of one chain: each is looked for among all before it."""


def configuration(file: Path, home: str) -> Configuration:
    """What a file asks for. Patterns count from the folder of the file that they stand in if it is
    `home` or above it, else from `home`: what a studio keeps for all its shows is meant for each.

    `ConfigError` for whatever is wrong in it.
    """
    sources: list[Source] = []
    following: Path | None = file
    while following is not None:
        following = _follow(following, home, sources)
    _check_versions(sources)
    return Configuration(tuple(sources))


def _follow(file: Path, home: str, sources: list[Source]) -> Path | None:
    """Add a file's source; the file that it extends, if it does."""
    try:
        source = _source(file, home)
    except ConfigError as error:
        if sources and error.wrongs[0].span is None:  # a file that is not there: who asks for it?
            said = f"{sources[-1].table['extend']}: {error.wrongs[0].message}"
            raise wrong_value(sources[-1], ("extend",), said) from None
        raise
    sources.append(source)
    if "extend" not in source.table:
        return None
    wanted = Path(os.path.normpath(source.file.parent / source.table["extend"]))
    chain = [one.file for one in sources]
    if is_pipe(wanted):
        said = f"{source.table['extend']}: a named pipe, not a file"
        raise wrong_value(source, ("extend",), said)
    if len(chain) >= _LONGEST:
        raise wrong_value(source, ("extend",), f"more than {_LONGEST} files extend each other")
    if any(_same(wanted, one) for one in chain):
        names = " -> ".join(str(one) for one in (*chain, wanted))
        raise wrong_value(source, ("extend",), f"extends itself: {names}")
    return wanted


def _same(one: Path, other: Path) -> bool:
    return os.path.realpath(one) == os.path.realpath(other)


def _source(file: Path, home: str) -> Source:
    text, whole = load(file)
    above = TABLE if file.name == SHARED else ()
    table: Any = whole
    for name in above:
        table = table.get(name, {}) if isinstance(table, dict) else {}
    if above and not has_table(whole):
        said = f"no table [{'.'.join(TABLE)}] in it"
        raise ConfigError([Wrong(file, said)])
    found = [*faults(FILE_OF_KEYS, table, above)]
    if found:
        raise located(file, text, found)
    return Source(file, text, table, above, _folder(file, home))


def has_table(whole: dict[str, Any]) -> bool:
    """Whether a `pyproject.toml` says anything to this program."""
    tool = whole.get(TABLE[0])
    return isinstance(tool, dict) and TABLE[1] in tool


def _folder(file: Path, home: str) -> str:
    folder = str(file.parent)
    above = folder.rstrip(os.sep) + os.sep
    return folder if f"{home.rstrip(os.sep)}{os.sep}".startswith(above) else home


def _check_versions(sources: list[Source]) -> None:
    for source in sources:
        wanted = source.table.get("required-version")
        if wanted is not None:
            from packaging.specifiers import SpecifierSet

            if not SpecifierSet(wanted).contains(__version__, prereleases=True):
                said = f"'{wanted}' is required here, and this is usdrender-lint {__version__}"
                raise wrong_value(source, ("required-version",), said)
