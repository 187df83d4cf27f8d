"""How does the program end, whatever goes wrong: with which sentence, and which exit code?"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path

import click

from .cli import CLEAN, INCOMPLETE, command
from .config import ConfigError, Wrong
from .console import forget, say, use_color
from .output import OutputError
from .printable import escaped
from .wanted import WantedError

PIPE_CLOSED = 141

_COMPLETE = "_USDRENDER_LINT_COMPLETE"


def run(argv: Sequence[str]) -> int:
    """The whole program but for `sys.exit`. Whatever goes wrong ends in a sentence and a code."""
    if sys.stdout is None:
        return _failed("error: standard output is closed\n")
    try:
        if asked := os.environ.get(_COMPLETE):
            return _complete(asked)
        # Not `command.main`, which ends with 1 when a pipe is closed: that means findings here.
        with command.make_context("usdrender-lint", list(argv)) as context:
            return int(command.invoke(context))
    except click.exceptions.Exit as answered:
        return answered.exit_code
    except click.ClickException as error:
        return _failed(_usage(error))
    except ConfigError as error:
        return _failed("\n".join(map(_wrong, error.wrongs)))
    except WantedError as error:
        return _failed(f"error: {escaped(str(error))}\n")
    except BrokenPipeError:
        forget(sys.stdout)
        return PIPE_CLOSED
    except (OutputError, OSError) as error:
        forget(sys.stdout)
        return _failed(f"error: {_reason(error)}\n")
    except Exception as error:  # noqa: BLE001 Python's own code for it is 1, and 1 means findings
        if isinstance(error, ImportError) and (error.name or "").partition(".")[0] == "pxr":
            return _failed(f"error: {_without_usd(error)}\n")
        from traceback import format_exc

        return _failed(f"{format_exc()}error: this is a bug of usdrender-lint\n")


def _usage(error: click.ClickException) -> str:
    """As click shows it, but that an error begins like every other one."""
    told = f"error: {escaped(error.format_message())}\n"
    context = error.ctx if isinstance(error, click.UsageError) else None
    if context is None:
        return told
    return f"{context.get_usage()}\nTry '{context.command_path} --help' for help.\n\n{told}"


def _without_usd(error: ImportError) -> str:
    if isinstance(error, ModuleNotFoundError):
        return "usd-core is not installed: pip install usd-core"
    return f"usd-core cannot be loaded: {escaped(str(error))}"


def _complete(instruction: str) -> int:
    """What a shell asks for when it starts, and at each press of the Tab key."""
    from click.shell_completion import shell_complete

    # What is given back is 1 for a shell that click does not know, and 1 means findings here.
    unknown = shell_complete(command, {}, "usdrender-lint", _COMPLETE, instruction)
    return _failed(f"error: {_COMPLETE}={escaped(instruction)} is unknown\n") if unknown else CLEAN


def _wrong(wrong: Wrong) -> str:
    from .report import full

    file = wrong.file
    place = file.relative_to(Path.cwd()) if file.is_relative_to(Path.cwd()) else file
    color = use_color("auto", sys.stderr)
    return full.fault(str(place), wrong.span, wrong.source, wrong.message, color=color)


def _failed(told: str) -> int:
    say(told)
    return INCOMPLETE


def _reason(error: Exception) -> str:
    return error.strerror.lower() if isinstance(error, OSError) and error.strerror else str(error)
