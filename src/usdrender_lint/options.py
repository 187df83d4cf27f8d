"""What may stand behind an option, and what is told where it may not?"""

from __future__ import annotations

import codecs
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from .config.find import absolute
from .discover import STDIN, USD_SUFFIXES, Shard
from .formats import BY_SUFFIX, FORMATS
from .handed import handing_over
from .patterns import PatternError, Patterns, check
from .registry import UnknownRuleError, all_rules, matching
from .rule import Severity
from .wanted import OFF
from .whole import read_whole

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

MOST_SECONDS = 1_000_000
"""Eleven days. Clocks of some systems count no further than 68 years."""


def _split(values: Sequence[str]) -> list[str]:
    return [part.strip() for value in values for part in value.split(",") if part.strip()]


def selectors(ctx: click.Context, param: click.Parameter, values: tuple[str, ...]) -> list[str]:
    found = _split(values)
    if values and not found:
        raise click.BadParameter("no rule is named", ctx, param)
    for selector in found:
        try:
            matching(selector)
        except UnknownRuleError as error:
            raise click.BadParameter(str(error), ctx, param) from None
    return found


def severities(
    ctx: click.Context, param: click.Parameter, values: tuple[str, ...]
) -> dict[str, str]:
    chosen: dict[str, str] = {}
    given = _split(values)
    if values and not given:
        raise click.BadParameter("no rule is named", ctx, param)
    for value in given:
        name, equals, level = value.partition("=")
        if not equals:
            raise click.BadParameter(f"{value!r} is not RULE=LEVEL", ctx, param)
        if level not in [*Severity, OFF]:
            raise click.BadParameter(f"{level!r} is not error, warning, note or off", ctx, param)
        try:
            chosen.update(dict.fromkeys(matching(name), level))
        except UnknownRuleError as error:
            raise click.BadParameter(str(error), ctx, param) from None
    return chosen


class Renderer(click.Choice[str]):
    """Names that are known before any configuration is read. Others may be a show's own."""

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        return value


def outputs(
    ctx: click.Context, param: click.Parameter, values: tuple[str, ...]
) -> list[tuple[str | None, Path]]:
    found: list[tuple[str | None, Path]] = []
    taken: set[Path] = set()
    for value in values:
        prefix, colon, rest = value.partition(":")
        # One letter is a drive of Windows.
        prefixed = colon and len(prefix) > 1 and prefix.isalpha()
        if prefixed and prefix not in FORMATS:
            known = ", ".join(FORMATS[:-1]) + f" or {FORMATS[-1]}"
            raise click.BadParameter(f"{prefix!r} is not {known}", ctx, param)
        named = rest if prefixed else value
        file = Path(named)
        if not named.strip() or _is_folder(named):
            raise click.BadParameter(f"{value!r} names no file", ctx, param)
        _refuse_usd(ctx, param, value, file)
        if not file.parent.is_dir():  # told now, and not after an hour
            raise click.BadParameter(f"there is no folder {str(file.parent)!r}", ctx, param)
        if _is_no_pipe(file):
            if file.resolve() in taken:
                raise click.BadParameter(f"{str(file)!r} is named twice", ctx, param)
            taken.add(file.resolve())
        found.append((prefix if prefixed else BY_SUFFIX.get(file.suffix.lower()), file))
    return found


def baseline_file(ctx: click.Context, param: click.Parameter, value: str | None) -> Path | None:
    if value is None:
        return None
    if not value.strip() or _is_folder(value):
        raise click.BadParameter(f"{value!r} names no file", ctx, param)
    _refuse_usd(ctx, param, value, Path(value))
    return Path(value)


def _is_folder(name: str) -> bool:
    """A name that ends with a separator is none of a file, whether the folder is there or not."""
    if name.endswith(("/", os.sep)):
        return True
    try:
        return Path(name).is_dir()
    except OSError:  # too long a name, which is told where it is to be opened
        return False


def _is_no_pipe(file: Path) -> bool:
    """Nor a device: what is written to those several times stands there several times."""
    try:
        return file.is_file() or not file.exists()
    except OSError:  # too long a name, again
        return False


def _refuse_usd(ctx: click.Context, param: click.Parameter, value: str, file: Path) -> None:
    """What is written replaces what was there: never a scene, nor one that a link leads to."""
    if file.suffix.lower() in USD_SUFFIXES:
        raise click.BadParameter(f"{value!r} is a USD file by its name", ctx, param)
    if Path(os.path.realpath(file)).suffix.lower() in USD_SUFFIXES:
        raise click.BadParameter(f"{value!r} is a link to a USD file", ctx, param)


def patterns(
    ctx: click.Context, param: click.Parameter, values: tuple[str, ...]
) -> Patterns | None:
    for value in values:
        try:
            check(value)
        except PatternError as error:
            raise click.BadParameter(str(error), ctx, param) from None
    return Patterns(values, str(Path.cwd())) if values else None


def shard(ctx: click.Context, param: click.Parameter, value: str | None) -> Shard | None:
    if value is None:
        return None
    number, slash, of = value.partition("/")
    if not (slash and number.isdecimal() and of.isdecimal() and 1 <= int(number) <= int(of)):
        raise click.BadParameter(f"{value!r} is not I/N, such as 1/4", ctx, param)
    return Shard(int(number), int(of))


def stdin_filename(ctx: click.Context, param: click.Parameter, value: str | None) -> str | None:
    if value is None:
        return None
    if Path(value).suffix.lower() not in USD_SUFFIXES or _is_folder(value):
        raise click.BadParameter(f"{value!r} is no USD file by its name", ctx, param)
    return absolute(value)


def from_stdin(ctx: click.Context, name: str | None) -> str:
    """Reads the layer that comes from standard input, until the command ends; its path."""
    path = name or absolute(STDIN)
    if sys.stdin is None:
        raise click.UsageError("'-': standard input is closed", ctx)
    data = sys.stdin.buffer.read()
    try:
        ctx.with_resource(handing_over(path, data))
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        said = f"{Path(path).name[:80]!r} cannot be kept meanwhile: {reason}"
        raise click.BadParameter(said, ctx, param_hint="--stdin-filename") from None
    return path


def names_from(value: str) -> list[str]:
    """One a line, or each ended by a NUL where there is one: `git diff -z` and `find -print0`."""
    if not value.strip():
        raise click.BadParameter(f"{value!r} names no file", param_hint="--files-from")
    try:
        data = sys.stdin.buffer.read() if value == "-" else read_whole(value)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise click.BadParameter(
            f"{value!r} cannot be read: {reason}", param_hint="--files-from"
        ) from None
    if data.startswith((codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)):  # it begins as UTF-16 does
        text = data.decode("utf-32", "replace")
    elif data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):  # `>` of PowerShell
        text = data.decode("utf-16", "replace")
    else:
        text = os.fsdecode(data.removeprefix(codecs.BOM_UTF8))
    names = text.split("\0") if "\0" in text else text.splitlines()
    found = [name for name in names if name.strip()]
    if not found:
        raise click.BadParameter(f"{value!r} names no file", param_hint="--files-from")
    return found


def config_file(ctx: click.Context, param: click.Parameter, value: str | None) -> Path | None:
    if value is None:
        return None
    if ctx.params.get("isolated"):
        if ctx.get_parameter_source(param.name or "") is ParameterSource.ENVIRONMENT:
            return None
        raise click.UsageError("--isolated and --config exclude each other", ctx)
    if not value.strip() or Path(value).is_dir():
        raise click.BadParameter(f"{value!r} names no file", ctx, param)
    if not Path(value).exists():
        raise click.BadParameter(f"there is no file {value!r}", ctx, param)
    return Path(absolute(value))


def seconds(ctx: click.Context, param: click.Parameter, value: float) -> float:
    if not 0 <= value <= MOST_SECONDS:
        raise click.BadParameter(f"{value} is not between 0 and {MOST_SECONDS}", ctx, param)
    return value


def any_file(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Left to the shell, which knows its files."""
    from click.shell_completion import CompletionItem

    return [CompletionItem(incomplete, type="file")]


def any_rule(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    """Rules; where several may be named, subjects, too, and the next one after a comma."""
    if not param.multiple:
        return [name for name in all_rules() if name.startswith(incomplete)]
    from .config.keys import selectors as known

    before, comma, begun = incomplete.rpartition(",")
    return [f"{before}{comma}{name}" for name in known() if name.startswith(begun)]


def any_severity(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    from .config.keys import selectors as known

    name, equals, begun = incomplete.partition("=")
    if not equals:
        return [f"{one}=" for one in known() if one.startswith(name)]
    return [f"{name}={level}" for level in (*Severity, OFF) if level.startswith(begun)]
