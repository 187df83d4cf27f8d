"""What may stand behind an option, and what is told where it may not?"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from .discover import USD_SUFFIXES
from .formats import BY_SUFFIX, FORMATS
from .registry import UnknownRuleError, matching
from .rule import Severity


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
) -> dict[str, Severity]:
    chosen: dict[str, Severity] = {}
    given = _split(values)
    if values and not given:
        raise click.BadParameter("no rule is named", ctx, param)
    for value in given:
        name, equals, level = value.partition("=")
        if not equals:
            raise click.BadParameter(f"{value!r} is not RULE=LEVEL", ctx, param)
        if level not in list(Severity):
            raise click.BadParameter(f"{level!r} is not error, warning or note", ctx, param)
        try:
            chosen.update(dict.fromkeys(matching(name), Severity(level)))
        except UnknownRuleError as error:
            raise click.BadParameter(str(error), ctx, param) from None
    return chosen


def outputs(
    ctx: click.Context, param: click.Parameter, values: tuple[str, ...]
) -> list[tuple[str | None, Path]]:
    found: list[tuple[str | None, Path]] = []
    for value in values:
        prefix, colon, rest = value.partition(":")
        # One letter is a drive of Windows.
        prefixed = colon and len(prefix) > 1 and prefix.isalpha()
        if prefixed and prefix not in FORMATS:
            known = ", ".join(FORMATS[:-1]) + f" or {FORMATS[-1]}"
            raise click.BadParameter(f"{prefix!r} is not {known}", ctx, param)
        file = Path(rest if prefixed else value)
        if not str(rest if prefixed else value).strip() or file.is_dir():
            raise click.BadParameter(f"{value!r} names no file", ctx, param)
        if file.suffix.lower() in USD_SUFFIXES:
            raise click.BadParameter(f"{value!r} is a USD file by its name", ctx, param)
        found.append((prefix if prefixed else BY_SUFFIX.get(file.suffix.lower()), file))
    return found


def baseline_file(ctx: click.Context, param: click.Parameter, value: str | None) -> Path | None:
    if value is None:
        return None
    if not value.strip() or Path(value).is_dir():
        raise click.BadParameter(f"{value!r} names no file", ctx, param)
    if Path(value).suffix.lower() in USD_SUFFIXES:
        raise click.BadParameter(f"{value!r} is a USD file by its name", ctx, param)
    return Path(value)
