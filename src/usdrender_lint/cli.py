"""What can a person ask for, and which exit code answers?"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from . import __version__, options
from .console import forget, say, tell, terminal_width, use_color
from .formats import FORMATS, Style, render
from .lint import Config, lint
from .output import OutputError, write_file, write_out
from .pages import page_text
from .printable import escaped
from .registry import UnknownRuleError, all_rules, select
from .renderers import names as renderer_names
from .results import Report
from .rule import Severity

if TYPE_CHECKING:
    from .baseline import Baseline

CLEAN, FINDINGS, INCOMPLETE = 0, 1, 2
INTERRUPTED, PIPE_CLOSED = 130, 141

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
        forget(sys.stdout)
        return PIPE_CLOSED
    except (OutputError, OSError) as error:
        forget(sys.stdout)
        return _failed(f"Error: {_reason(error)}\n")
    except Exception:  # noqa: BLE001 Python's own code for it is 1, and 1 means findings
        from traceback import format_exc

        return _failed(f"{format_exc()}Error: this is a bug of usdrender-lint\n")


def _failed(told: str) -> int:
    say(told)
    return INCOMPLETE


def _reason(error: Exception) -> str:
    return error.strerror.lower() if isinstance(error, OSError) and error.strerror else str(error)


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
    return explain.render(
        page_text(rule_id), color=use_color(ctx.params.get("color")), width=terminal_width()
    )


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
    callback=options.selectors,
    help="Rules to run: ids, groups such as 'camera', 'default' or 'ALL', separated by commas.",
)
@click.option(
    "--ignore",
    multiple=True,
    metavar="RULES",
    callback=options.selectors,
    help="Rules not to report.",
)
@click.option(
    "--severity",
    multiple=True,
    metavar="RULE=LEVEL",
    callback=options.severities,
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
    callback=options.baseline_file,
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
    callback=options.outputs,
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
    known = _known(baseline, may_be_missing=update_baseline) if baseline else None
    report = lint(paths, Config(selection, severity, renderer, variants, ignores=not no_ignores))
    _complain(report, color)
    for note in report.notes if not quiet else ():
        tell(f"Note: {note}")
    written = True
    if baseline and known and not no_ignores:
        if update_baseline:
            known, written = _update(baseline, known, report, quiet)
        elif (gone := known.stale(report)) and not quiet:
            which = "1 finding that is" if gone == 1 else f"{gone} findings that are"
            tell(f"Note: {baseline} holds {which} gone: see --update-baseline")
        report = known.hide(report)
    style = Style(fail_on, statistics, quiet, verbose)
    for chosen, file in output_file:
        try:
            write_file(file, render(report, chosen or output_format, None, style))
        except OutputError as error:
            written = False
            tell(f"Error: {error}")
    write_out(render(report, output_format, color, style))
    return exit_code(report, fail_on, exit_zero) if written else INCOMPLETE


def _known(file: Path, *, may_be_missing: bool) -> Baseline:
    from .baseline import Baseline, BaselineError, load

    try:
        return Baseline({}) if may_be_missing and not file.exists() else load(file)
    except BaselineError as error:
        raise click.ClickException(escaped(str(error))) from None


def _update(file: Path, known: Baseline, report: Report, quiet: bool) -> tuple[Baseline, bool]:
    """The new baseline, if it could be written. What was not looked at is neither new nor gone."""
    if not report.complete:
        tell(f"Error: {file} is not updated: the run is incomplete")
        return known, False
    new = known.updated(report)
    try:
        write_file(file, new.text())
    except OutputError as error:
        tell(f"Error: {error}")
        return known, False
    if not quiet:
        changes = f"{new.beyond(known)} added, {known.beyond(new)} taken out"
        tell(f"Note: {file} is written: {changes}, {new.count} in all")
    return new, True


def exit_code(report: Report, fail_on: str, exit_zero: bool) -> int:
    """One contract for every format. What is incomplete is never clean, and never merely found."""
    if not report.complete:
        return INCOMPLETE
    if exit_zero or fail_on == "never":
        return CLEAN
    worst = Severity(fail_on).rank
    return FINDINGS if any(f.severity.rank <= worst for f in report.findings) else CLEAN


def _complain(report: Report, color: str) -> None:
    if report.problems:
        from .report import full

        say(full.problems(report, use_color(color, sys.stderr)))
