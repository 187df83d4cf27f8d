"""Which findings were there before, and are not to be told again?

A baseline is a JSON array with one finding a line, sorted by layer, without line numbers or times:
it survives edits, and branches that add to it merge. Its version stands last, so that every line
before it ends with a comma and none changes when another is added below.
"""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from .records import dataclass
from .results import Located, Report, Verdict
from .whole import read_whole

VERSION = 1


class BaselineError(Exception):
    """A baseline cannot be used; says which, where and why."""


class Entry(NamedTuple):
    """What a finding is known by. As sorted: a change in one layer touches neighbouring lines."""

    layer: str
    prim: str
    """As the layer names it, like the target."""
    property: str
    """Empty for none, as is the target."""
    target: str
    rule: str


@dataclass(frozen=True, slots=True)
class Baseline:
    """How many findings of each kind are known."""

    known: Mapping[Entry, int]

    def hide(self, report: Report) -> Report:
        """Of several findings that are known by the same, the first ones are those that were known."""
        left = Counter(self.known)
        told: list[Located] = []
        hidden: list[Located] = []
        for finding in report.findings:
            entry = _entry(finding)
            if left[entry] > 0:
                left[entry] -= 1
                hidden.append(replace(finding, verdict=Verdict.BY_BASELINE))
            else:
                told.append(finding)
        suppressed = sorted((*report.suppressed, *hidden), key=lambda f: f.sort_key)
        return replace(report, findings=tuple(told), suppressed=tuple(suppressed))

    def stale(self, report: Report) -> int:
        """How many findings are gone, of the files that were linted and the rules that ran."""
        return self.beyond(self.updated(report))

    def beyond(self, other: Baseline) -> int:
        """How many findings it holds that another does not."""
        return (Counter(self.known) - Counter(other.known)).total()

    def moved(self, start: str, to: str) -> Baseline:
        """The same, with layers that were told from one folder told from another."""
        if start == to:
            return self
        return Baseline({_moved(entry, start, to): count for entry, count in self.known.items()})

    @property
    def count(self) -> int:
        return sum(self.known.values())

    def updated(self, report: Report) -> Baseline:
        """What is reported is known from now on; what is gone is known no more, if the run shows
        that it is."""
        found = Counter(map(_entry, report.findings))
        known = {
            entry: max(count, found[entry])
            for entry, count in self.known.items()
            if entry.rule not in report.ran.get(_file(entry), frozenset())
        }
        return Baseline(known | {entry: found[entry] for entry in found.keys() - known.keys()})

    def text(self) -> str:
        lines = [
            json.dumps(
                {
                    "rule": entry.rule,
                    "layer": entry.layer,
                    "prim": entry.prim,
                    "property": entry.property or None,
                    "target": entry.target or None,
                    "count": count,
                },
                ensure_ascii=False,
            )
            for entry, count in sorted(self.known.items())
        ]
        return "[\n" + "".join(f"{line},\n" for line in lines) + f'{{"version": {VERSION}}}\n]\n'


def _entry(finding: Located) -> Entry:
    return Entry(*finding.known_by)


def _file(entry: Entry) -> str:
    """The package for a layer inside one."""
    return entry.layer.partition("[")[0] if entry.layer.endswith("]") else entry.layer


def _moved(entry: Entry, start: str, to: str) -> Entry:
    file = _file(entry)
    inside = entry.layer[len(file) :]
    try:
        layer = os.path.relpath(Path(start, file), to).replace(os.sep, "/")
    except ValueError:  # another drive of Windows, from which no path leads here
        layer = Path(start, file).as_posix()
    return entry._replace(layer=f"{layer}{inside}")


def load(file: Path) -> Baseline:
    """`BaselineError` for a file that is missing or no baseline."""
    try:
        data = read_whole(file)
    except FileNotFoundError:
        raise BaselineError(f"{file}: no such baseline; --update-baseline makes one") from None
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise BaselineError(f"{file}: the baseline cannot be read: {reason}") from None
    return Baseline(_read(file, data))


def _read(file: Path, data: bytes) -> dict[Entry, int]:
    try:
        text = data.decode("utf-8")
        items = json.loads(text)
    except UnicodeDecodeError as error:
        raise _wrong(file, data[: error.start].count(b"\n") + 1, "not UTF-8") from None
    except json.JSONDecodeError as error:
        why = f"not JSON: {error.msg.lower()}"
        if text.startswith("\ufeff"):
            why = "begins with a UTF-8 byte order mark, which JSON does not allow"
        raise _wrong(file, error.lineno, why) from None
    except RecursionError:
        raise _wrong(file, 1, "nested too deeply") from None
    except ValueError:  # Python reads no number of more than some thousand digits
        raise _wrong(file, 1, "a number in it is too long") from None
    if not isinstance(items, list) or not items:
        raise _wrong(file, 1, "not a list of findings")
    known: dict[Entry, int] = {}
    for number, item in enumerate(items):
        try:
            if number < len(items) - 1:
                entry, count = _parsed(item)
                # Branches that were merged may both have it.
                known[entry] = max(count, known.get(entry, 0))
            elif item != {"version": VERSION}:
                raise ValueError(f'the last entry must be {{"version": {VERSION}}}')
        except ValueError as error:
            raise _wrong(file, _line_of(text, number), str(error)) from None
    return known


def _parsed(item: Any) -> tuple[Entry, int]:
    if not isinstance(item, dict):
        raise ValueError("not a finding")
    for key in ("rule", "layer", "prim", "property", "target"):
        needed = key in ("rule", "layer", "prim")
        value = item.get(key)
        if not (isinstance(value, str) and value) and (needed or value is not None):
            raise ValueError(f"'{key}' must be a text{'' if needed else ' or null'}")
    count = item.get("count")
    if not isinstance(count, int) or isinstance(count, bool) or count < 1:
        raise ValueError("'count' must be a number from 1")
    names = (item["layer"], item["prim"], item.get("property"), item.get("target"), item["rule"])
    return Entry(*(name or "" for name in names)), count


def _line_of(text: str, number: int) -> int:
    """Where in a text that is a JSON array one of its elements begins."""
    decoder, start, end = json.JSONDecoder(), 0, text.index("[") + 1
    for _ in range(number + 1):
        start = next(i for i in range(end, len(text)) if text[i] not in " \t\r\n,")
        _, end = decoder.raw_decode(text, start)
    return text.count("\n", 0, start) + 1


def _wrong(file: Path, line: int, why: str) -> BaselineError:
    return BaselineError(f"{file}:{line}: not a baseline: {why}")
