"""Is a text a light path expression, and in whose language?"""

from __future__ import annotations

from functools import lru_cache

from ..lazily import lazily
from .dialects import ALL, CAMERA, OSL, Dialect
from .parse import parse
from .problem import Problem
from .suspect import suspicions
from .suspicion import Suspicion
from .tree import Choice, Either, Event, Expression, Group, Part, Repeat, Sequence, Symbol

_PREFIX = "lpe:"
_MARKS = frozenset("<[*+")
"""What no plain AOV name holds."""
# Houdini's $F, ${NAME} and `expressions`; a label may hold anything.
_VARIABLE = lazily(r"\$[A-Za-z_{]|`")


@lru_cache(maxsize=1024)  # several rules read each expression, and shots have the same ones
def read(text: str, dialects: tuple[Dialect, ...] = ALL) -> Expression | Problem:
    """As Open Shading Language reads it; else as the dialect that finds the least odd in it; else
    the problem of the one that came furthest."""
    readings: list[Expression] = []
    problems: list[Problem] = []
    for dialect in dialects:
        reading = parse(text, dialect)
        if isinstance(reading, Problem):
            problems.append(reading)
        elif dialect is OSL:
            return reading
        else:
            readings.append(reading)
    if readings:
        return min(readings, key=lambda r: sum(1 for _ in suspicions(r)))
    return max(problems, key=lambda p: p.column, default=Problem("no renderer reads it", 1))


@lru_cache(maxsize=1024)
def suspicions_in(text: str, dialects: tuple[Dialect, ...] = ALL) -> tuple[Suspicion, ...]:
    """What is odd in the text as these dialects read it; nothing, where none does."""
    reading = read(text, dialects)
    return () if isinstance(reading, Problem) else tuple(suspicions(reading))


def accepted_by(text: str, dialects: tuple[Dialect, ...] = ALL) -> tuple[str, ...]:
    """The names of the dialects that read the text."""
    return tuple(d.name for d in dialects if isinstance(parse(text, d), Expression))


def strip_prefix(text: str) -> str:
    """Without `lpe:`, which renderers add by themselves, however often it stands there."""
    start = 0
    while text.startswith(_PREFIX, start):
        start += len(_PREFIX)
    return text[start:]


def has_variable(text: str) -> bool:
    """Is something in the text still to be replaced, so that it cannot be judged?"""
    return bool(_VARIABLE.search(text))


def looks_like_lpe(text: str) -> bool:
    """Is a name, of which nothing says so, an expression nevertheless?

    A name of letters alone is not: `CL` may be an AOV.
    """
    if text.startswith(_PREFIX):
        return True
    if _MARKS.isdisjoint(text):
        return False
    return any(
        isinstance(reading, Expression) and _begins_at_camera(reading.body)
        for reading in (parse(text, dialect) for dialect in ALL)
    )


def _begins_at_camera(part: Part) -> bool:
    """By what is written first: `.*` too may begin there, but is no sign of an expression."""
    while True:
        match part:
            case Symbol():
                return part.letter == CAMERA
            case Sequence(items=inner) | Choice(items=inner) | Event(slots=inner):
                if not inner:
                    return False
                part = inner[0]
            case Either():
                part = part.options[0]
            case Group():
                part = part.body
            case Repeat():
                part = part.item
            case _:
                return False
