"""Can a scheduler run a pass by what it says of its command and its file?"""

from __future__ import annotations

from collections.abc import Iterator

from ..lazily import lazily
from ..likeness import likeness
from ..model import Pass, State
from ..rule import Context, Finding, Severity, rule
from ._words import a_or_an, nearest

GROUP = "pass"

_OPTION = lazily(r"-{1,2}[A-Za-z][\w-]*[ \t]+\S")
_VARIABLE = lazily(r"(?<!\{)\{([A-Za-z_][\w:]*)\}(?!\})")
_LIKE = 0.75


@rule("unsplit-command", on=Pass, severity=Severity.WARNING, since="0.1", about=("command",))
def unsplit_command(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A command is written as one string, and not as a list of arguments."""
    command = render_pass.command.value
    if len(command) == 1 and _is_whole_command(command[0]):
        said = f"the command of <{render_pass.path}> is one string, '{command[0]}': a program of that name is looked for"
        words = command[0].split()
    else:
        words = next((w.split() for w in command if _OPTION.match(w)), [])
        said = f"'{' '.join(words)}' is one argument of the command of <{render_pass.path}>: the blank belongs to it"
    if words:
        listed = ", ".join(f'"{w}"' for w in words)
        yield Finding(
            render_pass.command,
            said,
            label="not split",
            help=f"write each argument as a string of its own: {listed}",
        )


def _is_whole_command(text: str) -> bool:
    """Words follow the program; blanks in the path of a program make no words."""
    first, *others = text.split()
    if not others:
        return False
    is_path = "/" in first or "\\" in first
    goes_on = "/" in others[0].lstrip("/") or "\\" in others[0]
    starts = any(w.startswith(("-", "/", "{", "$", "./", "../")) for w in others)
    return starts or not (is_path and goes_on)


@rule(
    "unknown-command-variable", on=Pass, severity=Severity.WARNING, since="0.1", about=("command",)
)
def unknown_command_variable(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """The command of a pass has a variable that no attribute of the pass fills."""
    built_in = set(render_pass.built_in)
    authored = {p.name for p in render_pass.properties}
    told: set[str] = set()
    for word in render_pass.command.value:
        for name in _VARIABLE.findall(word):
            if name in authored or name in told:
                continue
            told.add(name)
            if name in built_in:
                said, todo = f"'{name}' is not set", f"set {name}, or leave {{{name}}} out"
            elif meant := _meant(name, built_in | authored):
                said, todo = f"the pass has no '{name}'", f"did you mean '{{{meant}}}'?"
            else:
                continue  # the farm may know more variables than the pass
            yield Finding(
                render_pass.command,
                f"the command of <{render_pass.path}> asks for {{{name}}}, and {said}",
                label="nothing to put in",
                help=todo,
            )


def _meant(name: str, known: set[str]) -> str | None:
    return nearest(name, known, _LIKE)


@rule("unresolved-pass-file", on=Pass, severity=Severity.WARNING, since="0.1", about=("fileName",))
def unresolved_pass_file(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """The file of a pass does not exist."""
    if render_pass.file_found is False:
        yield Finding(
            render_pass.file_name,
            f"fileName @{render_pass.file_name.value}@ of <{render_pass.path}> leads to no file",
            label="no such file",
            help="correct the path; it starts from the layer that it is written in",
        )


@rule(
    "external-render-source", on=Pass, severity=Severity.WARNING, since="0.1", about=("fileName",)
)
def external_render_source(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A pass names a file, and a render source that is not in it."""
    file = render_pass.file_name.value
    target = render_pass.source_in_file
    if target is not None:
        if target.state is State.MISSING:
            said = "does not exist there"
        elif target.state is State.UNKNOWN or "RenderSettings" in target.isa:
            return
        else:
            kind = a_or_an(target.type_name) if target.type_name else "a prim without a type"
            said = f"is {kind} there, no RenderSettings"
        yield Finding(
            target,
            f"render source <{target.path}> is looked for in @{file}@, and {said}",
            label="not in the file",
            help="point it at RenderSettings of that file, or remove fileName to mean those of this stage",
        )
    for named in render_pass.render_source.targets[:1]:
        if file and named.is_property and named.state is State.MISSING:
            yield Finding(
                named,
                f"render source <{named.path}> does not exist: nothing says what to render in @{file}@",
                label="no such property",
                help=_named_otherwise(render_pass, named.path),
            )


def _named_otherwise(render_pass: Pass, path: str) -> str:
    prim, _, name = path.partition(".")
    own = [p.name for p in render_pass.properties] if prim == render_pass.path else []
    best = max(own, key=lambda o: likeness(o, name), default="")
    if best and likeness(best, name) >= _LIKE:
        return f"did you mean <{prim}.{best}>?"
    return f"write a string attribute that names it, such as string {name}"


@rule("incomplete-pass", on=Pass, severity=Severity.NOTE, since="0.1", default=False)
def incomplete_pass(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A pass says neither what kind it is nor what to run."""
    if not render_pass.pass_type.value and not render_pass.command.value:
        yield Finding(
            render_pass,
            f"<{render_pass.path}> has neither passType nor command: a scheduler cannot tell what to run",
            label="how is it run?",
            help='write uniform token passType = "..."',
        )
