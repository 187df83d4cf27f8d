"""What can a person ask for, and what is done about it?"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from . import __version__, options
from .config.find import NOTHING, Configurations
from .console import say, tell, terminal_width, use_color
from .discover import Shard
from .formats import FORMATS, WITH_DETAILS, Style, prepare, render
from .lint import report_on
from .output import OutputError, write_file, write_out
from .pages import page_text
from .patterns import Patterns
from .plan import Plan, Sought, plan
from .processes.workers import TIMEOUT, Isolated
from .progress import bar
from .registry import UnknownRuleError, all_rules
from .renderers import names as renderer_names
from .results import Report
from .rule import Severity
from .wanted import Options

if TYPE_CHECKING:
    from .baselines import Held

CLEAN, FINDINGS, INCOMPLETE = 0, 1, 2

_SECTIONS = {
    "select_": "Rules",
    "fail_on": "What fails the run",
    "config_file": "Configuration",
    "exclude": "Files",
    "jobs": "Processes",
    "output_format": "Output",
    "show_files": "Information",
}
"""Above which options `--help` says what they and the next ones are about."""

_EPILOG = """\b
Exit codes:
  0    everything was linted, and nothing at or above --fail-on was found
  1    everything was linted, and something was found
  2    the run is incomplete or invalid: nothing is clean that was not looked at
  130  interrupted
  141  the reader of the output closed it
  143  terminated
"""


class Command(click.Command):
    """A command whose options are shown in sections."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        sections: list[tuple[str, list[tuple[str, str]]]] = []
        for param in self.get_params(ctx):
            if isinstance(param, click.Option) and (shown := param.get_help_record(ctx)):
                if name := _SECTIONS.get(param.name or ""):
                    sections.append((name, []))
                sections[-1][1].append(shown)
        for name, options_of in sections:
            with formatter.section(name):
                formatter.write_dl(options_of)


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
        told = str(UnknownRuleError(rule_id, all_rules()))
        if rule_id in {rule.group for rule in all_rules().values()}:
            told = f"{rule_id!r} is a subject, and each of its rules has a page; see --list-rules"
        raise click.BadParameter(told, param_hint="'--explain'")
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
    cls=Command,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog=_EPILOG,
)
@click.argument("paths", nargs=-1, metavar="PATHS...", shell_complete=options.any_file)
@click.option(
    "--select",
    "select_",
    multiple=True,
    metavar="RULES",
    callback=options.selectors,
    shell_complete=options.any_rule,
    help="Rules to run: ids, subjects such as 'camera', 'default' or 'ALL', separated by commas.",
)
@click.option(
    "--extend-select",
    multiple=True,
    metavar="RULES",
    callback=options.selectors,
    shell_complete=options.any_rule,
    help="Rules to run beside those that are selected.",
)
@click.option(
    "--ignore",
    multiple=True,
    metavar="RULES",
    callback=options.selectors,
    shell_complete=options.any_rule,
    help="Rules not to report.",
)
@click.option(
    "--severity",
    multiple=True,
    metavar="RULE=LEVEL",
    callback=options.severities,
    shell_complete=options.any_severity,
    help="Report a rule or subject as error, warning or note, or not at all: off.",
)
@click.option(
    "--renderer",
    type=options.Renderer(["auto", *renderer_names()]),
    help="The renderer to judge by, also one that the configuration adds; by default 'auto', "
    "which goes by what the stage holds for one.",
)
@click.option(
    "--scene/--no-scene",
    default=None,
    help="Run the rules that need the whole stage, too: slow on large ones.",
)
@click.option(
    "--variants/--no-variants",
    default=None,
    help="Lint every variant of the variant sets that reach the render spec, one set at a time.",
)
@click.option(
    "--fail-on",
    type=click.Choice([*(s.value for s in Severity), "never"]),
    help="The least severity that makes the exit code 1; by default warning.",
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
    shell_complete=options.any_file,
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
    "--config",
    "config_file",
    metavar="FILE",
    envvar="USDRENDER_LINT_CONFIG",
    show_envvar=True,
    callback=options.config_file,
    shell_complete=options.any_file,
    help="The configuration of all files, instead of usdrender-lint.toml or pyproject.toml in the "
    "nearest folder above each.",
)
@click.option("--isolated", is_flag=True, is_eager=True, help="Read no configuration.")
@click.option(
    "--exclude",
    multiple=True,
    metavar="PATTERN",
    callback=options.patterns,
    shell_complete=options.any_file,
    help="Files and folders not to lint, named or found, as in .gitignore; beside those of the "
    "configuration.",
)
@click.option(
    "--no-gitignore",
    is_flag=True,
    help="Find files that git ignores, too.",
)
@click.option(
    "--files-from",
    metavar="FILE",
    shell_complete=options.any_file,
    help="Lint also the files and folders that a file names, one a line or ended by NULs; '-' is "
    "standard input.",
)
@click.option(
    "--stdin-filename",
    metavar="FILE",
    callback=options.stdin_filename,
    shell_complete=options.any_file,
    help="The layer that '-' stands for: what it refers to is looked for beside it, and reports and "
    "configurations know it by this name.",
)
@click.option(
    "--shard",
    metavar="I/N",
    callback=options.shard,
    help="Lint only the I-th of N parts of the files, which other runs lint.",
)
@click.option(
    "-j",
    "--jobs",
    type=click.IntRange(min=0),
    metavar="N",
    help="Processes that lint at the same time. By default one for few files, else as many as there "
    "are cores; 0: none but this one, which dies where USD does.",
)
@click.option(
    "--timeout",
    type=float,
    default=TIMEOUT,
    show_default=True,
    metavar="SECONDS",
    callback=options.seconds,
    help="How long one file may take; 0: as long as it likes.",
)
@click.option(
    "--output-format",
    type=click.Choice(FORMATS),
    default="full",
    show_default=True,
    envvar="USDRENDER_LINT_OUTPUT_FORMAT",
    show_envvar=True,
    is_eager=True,
    help="What to write to standard output.",
)
@click.option(
    "--output-file",
    multiple=True,
    metavar="[FORMAT:]FILE",
    callback=options.outputs,
    shell_complete=options.any_file,
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
    help="Also which renderer each stage was judged by, which rules and files were left out, and "
    "what USD said.",
)
@click.option(
    "--show-files",
    is_flag=True,
    help="Show the files that would be linted, and lint none.",
)
@click.option(
    "--show-config",
    is_flag=True,
    help="Show what holds for PATHS and which file, line or option says so, and lint none.",
)
@click.option(
    "--explain",
    metavar="RULE",
    # Not eager: --color and --output-format have to be known, wherever they stand.
    expose_value=False,
    callback=_eager(_explain),
    shell_complete=options.any_rule,
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
    extend_select: list[str],
    ignore: list[str],
    severity: dict[str, str],
    renderer: str | None,
    scene: bool | None,
    variants: bool | None,
    fail_on: str | None,
    exit_zero: bool,
    baseline: Path | None,
    update_baseline: bool,
    no_ignores: bool,
    config_file: Path | None,
    isolated: bool,
    exclude: Patterns | None,
    no_gitignore: bool,
    files_from: str | None,
    stdin_filename: str | None,
    shard: Shard | None,
    output_format: str,
    output_file: list[tuple[str | None, Path]],
    statistics: bool,
    color: str,
    jobs: int | None,
    timeout: float,
    quiet: bool,
    verbose: bool,
    show_files: bool,
    show_config: bool,
) -> int:
    """Tell what is wrong with the render spec of OpenUSD stages.

    PATHS are files (.usd .usda .usdc .usdz) or folders to search for them; '-' is a layer on
    standard input.
    """
    asked = Options(
        tuple(select_) or None,
        tuple(extend_select),
        tuple(ignore),
        severity,
        renderer,
        scene,
        variants,
        fail_on,
        baseline,
        not no_ignores,
    )
    _refuse_together(quiet, "--quiet", verbose, "--verbose")
    _refuse_together(update_baseline, "--update-baseline", no_ignores, "--no-ignores")
    _refuse_together(update_baseline, "--update-baseline", shard, "--shard")
    named = options.names_from(files_from) if files_from is not None else []
    sought = _sought([*paths, *named], stdin_filename, files_from, exclude, no_gitignore, shard)
    configurations = _configurations(config_file, isolated)
    if show_config:
        from . import answers

        return answers.show_config(sought, asked, configurations, output_format)
    if not sought.paths:
        raise click.UsageError("Missing argument 'PATHS...'.")
    if show_files:
        from . import answers

        return answers.show_files(sought, configurations, output_format)
    style = Style(statistics, quiet, verbose)
    plans = plan(sought, asked, configurations)
    _tell_excluded(plans, style)
    known = _known(plans, update_baseline)
    with (
        bar(quiet=quiet) as progress,
        Isolated(jobs, timeout, progress, lambda: prepare(output_format)).keeping() as how,
    ):
        report = report_on(
            plans.asked, plans.problems, plans.shown, plans.otherwise, how, part=str(shard or "")
        )
    _complain(report, color)
    _tell_beside(report, output_format, style)
    written = True
    if known and not no_ignores:
        from . import baselines

        if update_baseline:
            known, written = baselines.update(known, report, str(plans.shown.root), quiet=quiet)
        elif not quiet:
            baselines.tell_stale(known, report)
        report = baselines.hide(report, known)
    for chosen, file in output_file:
        written &= _wrote(file, render(report, chosen or output_format, None, style))
    write_out(render(report, output_format, color, style))
    return exit_code(report, exit_zero) if written else INCOMPLETE


def _refuse_together(one: object, its_name: str, other: object, others_name: str) -> None:
    if one and other:
        raise click.UsageError(f"{its_name} and {others_name} exclude each other")


def _sought(
    paths: list[str],
    stdin_filename: str | None,
    files_from: str | None,
    exclude: Patterns | None,
    gitignored: bool,
    shard: Shard | None,
) -> Sought:
    if "-" not in paths:
        if stdin_filename is not None:
            raise click.UsageError("--stdin-filename needs '-' among PATHS")
        return Sought(paths, exclude, gitignored, shard)
    if files_from == "-":
        raise click.UsageError("'-' and --files-from - exclude each other")
    given = options.from_stdin(click.get_current_context(), stdin_filename)
    paths = [given if path == "-" else path for path in paths]
    return Sought(paths, exclude, gitignored, shard, "" if stdin_filename else given)


def _configurations(file: Path | None, isolated: bool) -> Configurations:
    if isolated:
        return Configurations(NOTHING)
    if file is None:
        return Configurations()
    from .config.read import configuration

    return Configurations(configuration(file, str(Path.cwd())))


def _tell_excluded(plans: Plan, style: Style) -> None:
    if style.verbose:
        for path in plans.excluded:
            tell(f"note: {path} is excluded")
    if (why := plans.why_nothing) and not style.quiet:
        tell(f"note: no file was linted: {why}")


def _known(plans: Plan, update_baseline: bool) -> list[Held]:
    if not plans.baselines:
        if update_baseline:
            needed = "--baseline FILE, or one in a configuration"
            raise click.UsageError(f"--update-baseline needs {needed}")
        return []
    from .baselines import known_to

    return known_to(plans, may_be_missing=update_baseline)


def _complain(report: Report, color: str) -> None:
    if report.problems:
        from .report import full

        say(full.problems(report, use_color(color, sys.stderr)))


def _tell_beside(report: Report, output_format: str, style: Style) -> None:
    """What the report itself does not say."""
    if style.verbose and output_format not in WITH_DETAILS:
        from .report import full

        say("".join(f"{line}\n" for line in full.details(report)))
    for note in report.notes if not style.quiet else ():
        tell(f"note: {note}")


def _wrote(file: Path, text: str) -> bool:
    try:
        write_file(file, text)
    except OutputError as error:
        tell(f"error: {error}")
        return False
    return True


def exit_code(report: Report, exit_zero: bool) -> int:
    """One contract for every format. What is incomplete is never clean, and never merely found."""
    if not report.complete:
        return INCOMPLETE
    if exit_zero:
        return CLEAN
    return FINDINGS if any(map(report.fails, report.findings)) else CLEAN
