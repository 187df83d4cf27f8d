"""Which path expressions of a text layer are ill-formed?

In a root or referenced layer such an expression makes the stage fail to open without naming file
or line; in a sublayer the stage opens, nothing is said, and the value is empty though authored
(26.11). So the text itself is asked.
"""

from __future__ import annotations

import re

from pxr import Sdf, Tf, Usd

from ..diagnostics import sentences
from ..lazily import lazily
from ..model import Layer, Site
from .text import Texts

_AT = lazily(r"at character (\d+)(?: \(.*?\))?:\s*(.*)", re.DOTALL)
_RULE_AT = lazily(r"<input>:1:(\d+): parse error matching (.*?) -- ", re.DOTALL)
"""Before 26.11 USD names a rule of its parser."""
_RULES = (
    ("PathExprCloseGroup", "expected ')' to close expression group"),
    ("one<'}'>", "expected '}' to close predicate expression"),
    ("eolf", "expected end of path expression"),
)


def ill_formed_expressions(texts: Texts, file: str) -> list[Layer]:
    if not texts.mention(file, b"pathExpression"):
        return []
    text = texts.of_file(file)
    found = []
    for expression in text.expressions() if text else ():
        if problem := _problem(expression.text):
            site = Site("/", "syntax", expression.text, file, expression.path)
            found.append(Layer(file, site, problem))
    return found


def broken_at(text: str) -> int | None:
    """The character of an ill-formed expression from which on USD does not read it, from 0; None if
    USD does not say."""
    return _broken(text)[0]


def _problem(text: str) -> str:
    return _broken(text)[1]


def _broken(text: str) -> tuple[int | None, str]:
    """Where, and why; no reason for a well-formed one."""
    try:
        Sdf.PathExpression(text)
    except Tf.ErrorException as error:
        start, why = _place(text, "".join(sentences(error.args)))
        if start is None:
            return None, f"ill-formed path expression '{text}': USD takes only ASCII letters in it"
        at_end = start >= len(text)
        where = "at its end" if at_end else f"at character {start + 1}"
        why = why or ("something is left open" if at_end else "")
        return start, f"ill-formed path expression '{text}', {where}{': ' if why else ''}{why}"
    # Without a word USD takes the first line for all of it (26.11).
    rest = text.partition("\n")[2].strip()
    if not rest:
        return None, ""
    said = f"USD reads only the first line of a path expression: '{rest}' is not read"
    return text.index(rest, text.index("\n")), said


def _place(text: str, said: str) -> tuple[int | None, str]:
    """Where USD says that an expression is not read from, and why."""
    if match := _AT.search(said):
        return int(match[1]) - 1, match[2]
    match = _RULE_AT.search(said)
    if match is None:
        return None, ""
    start = len(text.encode()[: int(match[1]) - 1].decode(errors="ignore"))
    rest = text[start:].strip(" \t")
    if rest in ("+", "-", "&"):
        return len(text), "expected path expression after operator"
    if not rest:
        why = next((said for rule, said in _RULES if match[2].endswith(rule)), "")
        return len(text), "" if why == _RULES[-1][1] else why
    if not rest[0].isascii():
        return None, ""
    start = text.index(rest, start)
    if rest.lstrip("/").startswith("["):
        start = text.index("[", start)
        return start, f"'[' is read by usd-core 26.11 and newer, and this is {_installed()}"
    found = (said for rule, said in _RULES if match[2].endswith(rule))
    return start, next(found, "expected path expression")


def _installed() -> str:
    _, year, month = Usd.GetVersion()
    return f"{year}.{month:02}"
