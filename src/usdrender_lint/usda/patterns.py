"""Where in a path expression does one of its patterns stand?"""

from __future__ import annotations

import re
from collections.abc import Iterator

from ..lazily import lazily

_CONDITION = r"""\{(?:[^{}"'\\]|\\.|"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*')*\}"""
_TERM = lazily(rf"%(?:[\w/.:-]|\.\.)*|(?:[^\s(){{}}+&~\-\[\]]|\[[^\]]*\]|{_CONDITION})+", re.S)
"""A pattern or a reference; what is between them are operators and blanks."""
_UNSAID = lazily(r"[\s\"']+")
"""USD gives conditions back with other blanks and quotes than they were written with."""


def find_pattern(expression: str, wanted: str, owner: str) -> tuple[int, int] | None:
    """Beginning and end of the pattern that means `wanted`, written from the root or from `owner`."""
    meant = _UNSAID.sub("", wanted)
    for start, end in _terms(expression):
        written = expression[start:end]
        if meant in (_UNSAID.sub("", one) for one in (written, _from_root(written, owner))):
            return start, end
    return None


def _terms(expression: str) -> Iterator[tuple[int, int]]:
    return (match.span() for match in _TERM.finditer(expression))


def _from_root(written: str, owner: str) -> str:
    if written.startswith(("/", "%")):
        return written
    while written.startswith(".."):
        owner = owner.rpartition("/")[0]
        written = written[2:].removeprefix("/")
    written = written.removeprefix("./") if written != "." else ""
    joint = "" if not written or written.startswith("/") else "/"
    return f"{owner}{joint}{written}" or "/"
