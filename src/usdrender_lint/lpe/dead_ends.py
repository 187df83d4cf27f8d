"""Where does an expression lead nowhere?"""

from __future__ import annotations

from collections.abc import Iterator

from .dialects import CAMERA
from .paths import ALONG, BEFORE, ENDED, Paths, States, after, before, repeated
from .problem import quoted
from .suspicion import Edit, Suspicion, instead
from .tree import (
    Choice,
    Either,
    Event,
    Expression,
    Group,
    Item,
    Label,
    Part,
    Repeat,
    Sequence,
    Symbol,
)


def dead_ends(expression: Expression) -> list[Suspicion]:
    """What explains the most is told alone: a misread `|`, then that nothing is matched at all."""
    paths = Paths(expression)
    if misread := list(_misread(expression, paths)):
        return misread
    if after(paths[expression.body], BEFORE) & ENDED:
        return list(_dead_parts(expression.body, paths))
    return [_dead_end(expression, paths)]


# -- alternatives


def _misread(expression: Expression, paths: Paths) -> Iterator[Suspicion]:
    """`AB|CD` is `A(B|C)D`. Where `AB` or `CD` makes sense, that was meant.

    RenderMan documents `CD|(SD)L`, and ships `C(D[DS]*[LO])|O`: there it makes none.
    """
    if expression.dialect.long_alternatives:
        return
    waiting: list[tuple[Part, States]] = [(expression.body, BEFORE)]
    while waiting:
        part, states = waiting.pop()
        match part:
            case Sequence():
                if found := _long_alternatives(part, states, expression, paths):
                    yield found
                for item in part.items:
                    waiting.append((item, states))
                    states = after(paths[item], states)
            case Group():
                waiting.append((part.body, states))
            case Choice():
                waiting += ((item, states) for item in part.items)
            case Either():
                waiting += ((option, states) for option in part.options)
            case Repeat():
                waiting.append((part.item, after(repeated(paths[part.item], 0, None), states)))
            case _:
                pass


def _long_alternatives(
    sequence: Sequence, states: States, expression: Expression, paths: Paths
) -> Suspicion | None:
    joined = next((item for item in sequence.items if isinstance(item, Either)), None)
    if joined is None or len(sequence.items) == 1:
        return None
    branches: list[list[Part]] = [[]]
    for item in sequence.items:
        if isinstance(item, Either):
            branches[-1].append(item.options[0])
            branches += ([option] for option in item.options[1:])
        else:
            branches[-1].append(item)
    ways = {_through(branch, states, paths) for branch in branches}
    if len(ways) > 1 or not ways.pop():
        return None
    meant = "|".join(_grouped(branch) for branch in branches)
    if sequence is expression.body and not expression.dialect.reads_on:
        meant = f"({meant})"
    return Suspicion(
        f"'|' joins just the two beside it, {quoted(joined)}: "
        "a longer alternative needs parentheses of its own",
        joined.column,
        instead(sequence, meant),
    )


def _through(branch: list[Part], states: States, paths: Paths) -> States:
    for part in branch:
        states = after(paths[part], states)
    return states


def _grouped(branch: list[Part]) -> str:
    text = "".join(map(str, branch))
    return text if len(branch) == 1 else f"({text})"


# -- an expression that matches nothing


def _dead_end(expression: Expression, paths: Paths) -> Suspicion:
    """The first item that cannot follow those before it, or the missing end."""
    sequence, states, index = expression.body, BEFORE, 0
    previous: Item | None = None
    while index < len(sequence.items):
        item = sequence.items[index]
        if following := after(paths[item], states):
            previous, states, index = item, following, index + 1
        elif isinstance(item, Group):
            sequence, index = item.body, 0
        else:
            return _misplaced(item, states, previous, expression, paths)
    ends = expression.dialect.ends
    last = previous or expression.body
    message = (
        f"no path ends in {quoted(last)}: it ends in {', '.join(ends[:-1])} or {ends[-1]}, or '.*'"
    )
    return Suspicion(message, last.column)


def _misplaced(
    item: Item, states: States, previous: Item | None, expression: Expression, paths: Paths
) -> Suspicion:
    text = quoted(item)
    edit = None
    if not any(paths[item]):
        message = f"no path has {text}"
    elif states == ENDED:
        message = f"nothing is left for {text}: the path has ended"
        if isinstance(item, Label) and isinstance(previous, Symbol):
            start = previous.column - 1
            edit = Edit(start, start + len(f"{previous}{item}"), f"<{previous}.{item}>")
    elif states == BEFORE:
        message = f"{text} cannot be first: a path begins at the camera, C"
        if previous is None and after(paths[expression.body], ALONG) & ENDED:
            edit = Edit(item.column - 1, item.column - 1, CAMERA)
    elif isinstance(item, Symbol | Event):
        message = f"{text} can only be first"
    else:
        message = f"no path has {text} here"
    return Suspicion(message, item.column, edit)


# -- parts of an expression that matches something


def _dead_parts(root: Part, paths: Paths) -> Iterator[Suspicion]:
    """Alternatives and repetitions that no path takes."""
    waiting = [(root, BEFORE, ENDED)]
    while waiting:
        part, entry, leave = waiting.pop()
        match part:
            case Sequence():
                waiting += _links(part, entry, leave, paths)
                continue
            case Group():
                choices: tuple[Part, ...] = (part.body,)
            case Choice():
                choices = part.items
            case Either() if set(part.operators) == {"|"}:
                choices = part.options
            case Repeat():
                choices = (part.item,)
                again = repeated(paths[part.item], 0, None)
                entry, leave = after(again, entry), before(again, leave)
            case _:
                continue
        for choice in choices:
            if after(paths[choice], entry) & leave:
                waiting.append((choice, entry, leave))
            elif not _harmless(part):
                yield _dead_part(choice, entry, paths)


def _harmless(part: Part) -> bool:
    """`CL.*`, where nothing can follow but nothing more is asked for."""
    return isinstance(part, Repeat) and str(part.item) == "."


def _links(
    sequence: Sequence, entry: States, leave: States, paths: Paths
) -> list[tuple[Part, States, States]]:
    """Each item with where it is entered and left if the whole is to lead on."""
    entries = [entry]
    for item in sequence.items[:-1]:
        entries.append(after(paths[item], entries[-1]))
    links: list[tuple[Part, States, States]] = []
    for item, states in zip(reversed(sequence.items), reversed(entries), strict=False):
        links.append((item, states, leave))
        leave = before(paths[item], leave)
    return links


def _dead_part(part: Part, entry: States, paths: Paths) -> Suspicion:
    text = quoted(part)
    if after(paths[part], entry):
        message = f"{text} ends the path, and more is asked for after it"
    elif entry == ENDED:
        message = f"nothing is left for {text}: the path has ended"
    else:
        message = f"no path has {text} here"
    return Suspicion(message, part.column)
