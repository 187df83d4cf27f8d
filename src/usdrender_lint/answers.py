"""What is answered instead of linting: which files would be linted, and what would hold for them?"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .config import Asked, Configuration
from .config.find import Configurations
from .console import tell
from .lazily import lazily
from .output import write_out
from .plan import Sought, seek
from .records import dataclass
from .wanted import Options, wanted

COMPLETE, INCOMPLETE = 0, 2

_BARE = lazily(r"[A-Za-z0-9_-]+")


def show_files(sought: Sought, configurations: Configurations, chosen: str) -> int:
    """One a line as seen from the current folder, so that other programs find them; or as JSON."""
    found, _ = seek(sought, configurations)
    files = [_from_here(Path(file.file)) for file in found.files]
    if chosen == "json":
        write_out(json.dumps({"version": 1, "files": files}, indent=2, ensure_ascii=False) + "\n")
    else:
        write_out("".join(f"{file}\n" for file in files))
    for problem in found.problems:
        tell(f"error: {problem.path}: {problem.message}")
    return INCOMPLETE if found.problems else COMPLETE


@dataclass(frozen=True, slots=True)
class _Value:
    """What holds for a key, or for an entry of a table, and by whose word."""

    value: Any
    origins: tuple[str, ...] = ()
    """Options, and files with their lines; none: it is the default."""


Values = dict[str, _Value | dict[str, _Value]]


def show_config(
    sought: Sought, options: Options, configurations: Configurations, chosen: str
) -> int:
    """What holds for each path, by default for the current folder."""
    paths: dict[Configuration, list[str]] = {}
    for path in sought.paths or ["."]:
        paths.setdefault(configurations.of_files_in(path), []).append(path)
    for configuration in paths:
        wanted(configuration, options)  # tells what cannot be had
    said = [(c, paths[c], _values(c, options, sought)) for c in paths]
    if chosen == "json":
        write_out(json.dumps(_as_data(said), indent=2, ensure_ascii=False) + "\n")
    else:
        write_out("\n".join("".join(_as_toml(*one)) for one in said))
    return COMPLETE


def _values(configuration: Configuration, options: Options, sought: Sought) -> Values:
    from .config.keys import KEYS

    found: Values = {}
    for name, key in KEYS.items():
        if isinstance(key.default, dict):
            found[name] = _entries(name, configuration, options)
        elif isinstance(key.default, list):
            found[name] = _list(name, key.default, configuration, options, sought)
        else:
            option = getattr(options, name.replace("-", "_"), None)
            asked = configuration.asked(name)
            if option is not None:
                value = str(option) if isinstance(option, Path) else option
                found[name] = _Value(value, (f"--{name}",))
            else:
                found[name] = _Value(asked.value, (_at(asked),)) if asked else _Value(key.default)
    return found


def _list(
    name: str,
    default: list[str],
    configuration: Configuration,
    options: Options,
    sought: Sought,
) -> _Value:
    """`--select` says which rules run, whatever the configuration says; other options add."""
    given = {
        "select": options.select or (),
        "extend-select": options.extend_select,
        "ignore": options.ignore,
        "exclude": sought.exclude.patterns if sought.exclude else (),
    }.get(name, ())
    begun = {"extend-select": "select", "extend-exclude": "exclude"}.get(name)
    asked = configuration.added(name, begun) if begun else [configuration.asked(name)]
    if options.select and name in ("select", "extend-select", "ignore"):
        asked = []
    said = [one for one in asked if one]
    values = [*(value for one in said for value in one.value), *given]
    origins = (*map(_at, said), *([f"--{name}"] if given else []))
    return _Value(values, origins) if origins else _Value(default)


def _entries(name: str, configuration: Configuration, options: Options) -> dict[str, _Value]:
    entries = configuration.entries(name).items()
    found = {entry: _Value(asked.value, (_at(asked),)) for entry, asked in entries}
    if name == "severity":
        for rule, level in sorted(options.severity.items()):
            found[rule] = _Value(level, ("--severity",))
    return found


def _at(asked: Asked) -> str:
    return f"{_from_here(asked.source.file)}:{asked.line}"


def _from_here(file: Path) -> str:
    here = Path.cwd()
    return str(file.relative_to(here)) if file.is_relative_to(here) else str(file)


def _as_data(said: list[tuple[Configuration, list[str], Values]]) -> dict[str, Any]:
    def value(one: _Value) -> dict[str, Any]:
        return {"value": one.value, "from": list(one.origins) or ["default"]}

    return {
        "version": 1,
        "configurations": [
            {
                "paths": paths,
                "files": [_from_here(source.file) for source in configuration.sources],
                "values": {
                    name: value(one)
                    if isinstance(one, _Value)
                    else {entry: value(inside) for entry, inside in one.items()}
                    for name, one in values.items()
                },
            }
            for configuration, paths, values in said
        ],
    }


def _as_toml(configuration: Configuration, paths: list[str], values: Values) -> Iterator[str]:
    """As a configuration could say it, with a comment that tells who does."""
    files = ", which extends ".join(_from_here(one.file) for one in configuration.sources)
    yield f"# {', '.join(paths)}: {files or 'no configuration'}\n"
    yield from _lines({n: v for n, v in values.items() if isinstance(v, _Value)})
    for name, entries in values.items():
        if isinstance(entries, dict) and entries:
            yield f"\n[{name}]\n"
            yield from _lines(entries)


def _lines(values: dict[str, _Value]) -> Iterator[str]:
    said = {_pair(name, one.value): one.origins for name, one in values.items()}
    width = max(map(len, said), default=0)
    for pair, origins in said.items():
        yield f"{pair:{width}}  # {', '.join(origins) or 'default'}\n"


def _pair(name: str, value: Any) -> str:
    """JSON's texts, lists and words are TOML's, too; it has no word for nothing."""
    key = name if _BARE.fullmatch(name) else json.dumps(name, ensure_ascii=False)
    if value is None:
        return f"# no {key}"
    return f"{key} = {json.dumps(value, ensure_ascii=False)}"
