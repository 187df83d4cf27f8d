"""What can a person ask for, and which exit code answers?"""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from traceback import format_exc
from typing import Any, TextIO

import click

from . import __version__
from .baseline import Baseline, BaselineError, load
from .discover import USD_SUFFIXES
from .lint import Config, lint
from .output import OutputError, write_file, write_out
from .pages import page_text, pages
from .registry import UnknownRuleError, all_rules, matching, select
from .renderers import names as renderer_names
from .results import Report
from .rule import Severity

CLEAN, FINDINGS, INCOMPLETE = 0, 1, 2
INTERRUPTED, PIPE_CLOSED = 130, 141

FORMATS = ("full", "concise", "json", "sarif", "github", "gitlab", "junit")
_BY_SUFFIX = {".sarif": "sarif", ".json": "json", ".xml": "junit"}

_EPILOG = """\b
Exit codes:
  0    everything was linted, and nothing at or above --fail-on was found
  1    everything was linted, and something was found
  2    the run is incomplete or invalid: nothing is clean that was not looked at
  130  interrupted
  141  the reader of the output closed it
"""


def run(argv: Sequence[str]) -> int:
    """The whole program but for `sys.exit`. Whatever goes wrong ends in a sentence and a code."""
    if sys.stdout is None:
        return _failed("Error: standard output is closed\n")
    try:
        # Not `command.main`, which ends with 1 when a pipe is closed: that means findings here.
        with command.make_context("usdrender-lint", list(argv)) as context:
            return int(command.invoke(context))
    except click.exceptions.Exit as answered:
        return answered.exit_code
    except click.ClickException as error:
        told = StringIO()
        error.show(told)
        return _failed(told.getvalue())
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        _forget(sys.stdout)
        return PIPE_CLOSED
    except (OutputError, OSError) as error:
        _forget(sys.stdout)
        return _failed(f"Error: {_reason(error)}\n")
    except Exception:  # noqa: BLE001 Python's own code for it is 1, and 1 means findings
        return _failed(f"{format_exc()}Error: this is a bug of usdrender-lint\n")


def _failed(told: str) -> int:
    _say(told)
    return INCOMPLETE


def _say(text: str) -> None:
    """On standard error, as far as that can be written: the exit code says it, too."""
    if sys.stderr is not None:
        try:
            sys.stderr.write(text)
            sys.stderr.flush()
        except OSError:
            _forget(sys.stderr)


def _forget(stream: TextIO) -> None:
    """Python flushes its streams once more at exit, and would print a traceback of its own."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _reason(error: Exception) -> str:
    return error.strerror.lower() if isinstance(error, OSError) and error.strerror else str(error)


def _split(values: Sequence[str]) -> list[str]:
    return [part.strip() for value in values for part in value.split(",") if part.strip()]


def _selectors(ctx: click.Context, param: click.Parameter, values: tuple[str, ...]) -> list[str]:
    found = _split(values)
    if values and not found:
        raise click.BadParameter("no rule is named", ctx, param)
    for selector in found:
        try:
            matching(selector)
        except UnknownRuleError as error:
            raise click.BadParameter(str(error), ctx, param) from None
    return found


def _severities(
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


def _outputs(
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
        found.append((prefix if prefixed else _BY_SUFFIX.get(file.suffix.lower()), file))
    return found


def _baseline_file(ctx: click.Context, param: click.Parameter, value: str | None) -> Path | None:
    if value is None:
        return None
    if not value.strip() or Path(value).is_dir():
        raise click.BadParameter(f"{value!r} names no file", ctx, param)
    if Path(value).suffix.lower() in USD_SUFFIXES:
        raise click.BadParameter(f"{value!r} is a USD file by its name", ctx, param)
    return Path(value)


def _eager(answer: Callable[[click.Context, Any], str]) -> Callable[..., None]:
    """An option that answers and ends, before paths are asked for."""

    def callback(ctx: click.Context, param: click.Parameter, value: Any) -> None:
        if not value or ctx.resilient_parsing:
            return
        text = answer(ctx, value)
        write_out(text)
        ctx.exit(CLEAN)

    return callback


def _explain(ctx: click.Context, rule_id: str) -> str:
    if rule_id not in all_rules():
        raise click.BadParameter(
            str(UnknownRuleError(rule_id, all_rules())), param_hint="--explain"
        )
    from .report import catalogue, explain

    if ctx.params.get("output_format") == "json":
        return catalogue.explained(all_rules()[rule_id], page_text(rule_id), __version__)
    return explain.render(page_text(rule_id), color=_color(ctx.params.get("color")), width=_width())


def _list_rules(ctx: click.Context, _: bool) -> str:
    from .report import catalogue

    rules = all_rules().values()
    if ctx.params.get("output_format") == "json":
        return catalogue.listed(rules, __version__)
    return catalogue.render(rules)


@click.command(
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog=_EPILOG,
)
@click.argument("paths", nargs=-1, required=True, metavar="PATHS...")
@click.option(
    "--select",
    "select_",
    multiple=True,
    metavar="RULES",
    callback=_selectors,
    help="Rules to run: ids, groups such as 'camera', 'default' or 'ALL', separated by commas.",
)
@click.option(
    "--ignore", multiple=True, metavar="RULES", callback=_selectors, help="Rules not to report."
)
@click.option(
    "--severity",
    multiple=True,
    metavar="RULE=LEVEL",
    callback=_severities,
    help="Report a rule or group as error, warning or note.",
)
@click.option(
    "--renderer",
    type=click.Choice(["auto", *renderer_names()]),
    default="auto",
    show_default=True,
    help="The renderer to judge by; 'auto' goes by what the stage holds for one.",
)
@click.option(
    "--scene",
    is_flag=True,
    help="Run the rules that need the whole stage, too: slow on large ones.",
)
@click.option(
    "--variants",
    is_flag=True,
    help="Lint every variant of the variant sets that reach the render spec, one set at a time.",
)
@click.option(
    "--fail-on",
    type=click.Choice([*(s.value for s in Severity), "never"]),
    default="warning",
    show_default=True,
    help="The least severity that makes the exit code 1.",
)
@click.option(
    "--exit-zero",
    is_flag=True,
    help="Exit with 0 whatever is found. An incomplete run still exits with 2.",
)
@click.option(
    "--baseline",
    metavar="FILE",
    callback=_baseline_file,
    help="Hide the findings that this file holds.",
)
@click.option(
    "--update-baseline",
    is_flag=True,
    help="Write what is found to the baseline, and take out what is found no more.",
)
@click.option(
    "--no-ignores",
    is_flag=True,
    help="Show all findings, also those that comments, metadata or the baseline hide.",
)
@click.option(
    "--output-format",
    type=click.Choice(FORMATS),
    default="full",
    show_default=True,
    envvar="USDRENDER_LINT_OUTPUT_FORMAT",
    is_eager=True,
    help="What to write to standard output.",
)
@click.option(
    "--output-file",
    multiple=True,
    metavar="[FORMAT:]FILE",
    callback=_outputs,
    help="Write a report to a file, too; its format by the prefix, else by '.sarif', '.json' "
    "or '.xml' (junit), else as on standard output. May be given several times.",
)
@click.option(
    "--statistics",
    is_flag=True,
    help="In 'full' and 'concise', how often each rule spoke instead of the findings.",
)
@click.option(
    "--color",
    type=click.Choice(["auto", "always", "never"]),
    default="auto",
    show_default=True,
    is_eager=True,
    help="Color on the terminal.",
)
@click.option("-q", "--quiet", is_flag=True, help="Only findings and errors, no summary.")
@click.option(
    "-v",
    "--verbose",
    is_flag=True,
    help="Also which renderer each stage was judged by, and what USD said.",
)
@click.option(
    "--explain",
    metavar="RULE",
    # Not eager: --color and --output-format have to be known, wherever they stand.
    expose_value=False,
    callback=_eager(_explain),
    help="Show the page of a rule: what it means, how to mend it.",
)
@click.option(
    "--list-rules",
    is_flag=True,
    expose_value=False,
    callback=_eager(_list_rules),
    help="List all rules by subject.",
)
@click.version_option(__version__, message="%(prog)s %(version)s")
def command(
    paths: tuple[str, ...],
    select_: list[str],
    ignore: list[str],
    severity: dict[str, Severity],
    renderer: str,
    scene: bool,
    variants: bool,
    fail_on: str,
    exit_zero: bool,
    baseline: Path | None,
    update_baseline: bool,
    no_ignores: bool,
    output_format: str,
    output_file: list[tuple[str | None, Path]],
    statistics: bool,
    color: str,
    quiet: bool,
    verbose: bool,
) -> int:
    """Tell what is wrong with the render spec of OpenUSD stages.

    PATHS are files (.usd .usda .usdc .usdz) or folders to search for them.
    """
    selection = select(select_ or ["default"], ignore, scene=scene)
    if not selection.told:
        raise click.UsageError("no rule is selected: nothing would be linted")
    if update_baseline and (baseline is None or no_ignores):
        why = "needs --baseline FILE" if baseline is None else "and --no-ignores exclude each other"
        raise click.UsageError(f"--update-baseline {why}")
    known = _known(baseline, may_be_missing=update_baseline) if baseline else Baseline({})
    report = lint(paths, Config(selection, severity, renderer, variants, ignores=not no_ignores))
    _complain(report, color)
    written = True
    if baseline and not no_ignores:
        if update_baseline:
            known, written = _update(baseline, known, report, quiet)
        elif (gone := known.stale(report)) and not quiet:
            which = "1 finding that is" if gone == 1 else f"{gone} findings that are"
            _tell(f"Note: {baseline} holds {which} gone: see --update-baseline")
        report = known.hide(report)
    style = _Style(fail_on, statistics, quiet, verbose)
    for chosen, file in output_file:
        try:
            write_file(file, _render(report, chosen or output_format, None, style))
        except OutputError as error:
            written = False
            from .report.full import escaped

            _say(f"Error: {escaped(str(error))}\n")
    write_out(_render(report, output_format, color, style))
    return exit_code(report, fail_on, exit_zero) if written else INCOMPLETE


def _known(file: Path, *, may_be_missing: bool) -> Baseline:
    try:
        return Baseline({}) if may_be_missing and not file.exists() else load(file)
    except BaselineError as error:
        raise click.ClickException(_escaped(str(error))) from None


def _update(file: Path, known: Baseline, report: Report, quiet: bool) -> tuple[Baseline, bool]:
    """The new baseline, if it could be written. What was not looked at is neither new nor gone."""
    if not report.complete:
        _tell(f"Error: {file} is not updated: the run is incomplete")
        return known, False
    new = known.updated(report)
    try:
        write_file(file, new.text())
    except OutputError as error:
        _tell(f"Error: {error}")
        return known, False
    if not quiet:
        changes = f"{new.beyond(known)} added, {known.beyond(new)} taken out"
        _tell(f"Note: {file} is written: {changes}, {new.count} in all")
    return new, True


def _tell(sentence: str) -> None:
    _say(f"{_escaped(sentence)}\n")


def _escaped(text: str) -> str:
    from .report.full import escaped

    return escaped(text)


def exit_code(report: Report, fail_on: str, exit_zero: bool) -> int:
    """One contract for every format. What is incomplete is never clean, and never merely found."""
    if not report.complete:
        return INCOMPLETE
    if exit_zero or fail_on == "never":
        return CLEAN
    worst = Severity(fail_on).rank
    return FINDINGS if any(f.severity.rank <= worst for f in report.findings) else CLEAN


@dataclass(frozen=True, slots=True)
class _Style:
    """What a person asked for about the reports, beside their format."""

    fail_on: str
    statistics: bool
    quiet: bool
    verbose: bool


def _render(report: Report, chosen: str, color: str | None, style: _Style) -> str:
    """`color` None: for a file."""
    quiet, verbose = style.quiet, style.verbose
    match chosen:
        case "json":
            from .report import json

            return json.render(report)
        case "sarif":
            from .report import sarif

            return sarif.render(report, pages())
        case "github":
            from .report import github

            return github.render(report, quiet=quiet)
        case "gitlab":
            from .report import gitlab

            return gitlab.render(report)
        case "junit":
            from .report import junit

            fails = None if style.fail_on == "never" else Severity(style.fail_on)
            return junit.render(report, fails)
        case _ if style.statistics:
            from .report import statistics

            return statistics.render(report, color=_color(color), verbose=verbose, quiet=quiet)
        case "concise":
            from .report import concise

            return concise.render(
                report, color=_color(color), verbose=verbose, quiet=quiet, base=Path.cwd()
            )
        case _:
            from .report import full

            terminal = color is not None and sys.stdout.isatty()
            return full.render(
                report,
                color=_color(color),
                width=_width() if terminal else None,
                verbose=verbose,
                quiet=quiet,
                base=Path.cwd(),
                links=terminal and _color(color) and os.environ.get("TERM") != "dumb",
            )


def _complain(report: Report, color: str) -> None:
    if report.problems:
        from .report import full

        _say(full.problems(report, _color(color, sys.stderr)))


def _color(asked: str | None, stream: TextIO | None = None) -> bool:
    """--color over NO_COLOR over FORCE_COLOR over a terminal that can."""
    if asked is None:
        return False
    if asked != "auto":
        return asked == "always"
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return (stream or sys.stdout).isatty() and os.environ.get("TERM") != "dumb"


def _width() -> int:
    return shutil.get_terminal_size().columns
