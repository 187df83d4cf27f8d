"""How are paths and strings spelled in the text of usda?"""

from __future__ import annotations

import re

from ..lazily import lazily
from ..records import dataclass

_PATH = lazily(r"(?P<prim>(?:[^.{]|\{[^}]*\})*)(?:\.(?P<property>[^\[]*))?")
_STEP = lazily(r"\{(?P<set>[^={}]*)=(?P<variant>[^{}]*)\}|(?P<prim>[^/{}]+)")
_ESCAPE = lazily(rb"\\(?:x([0-9a-fA-F]{0,2})|([0-7]{1,3})|(.))", re.S)
_CONTROL = dict(zip(b"abfnrtv", b"\a\b\f\n\r\t\v", strict=True))


@dataclass(frozen=True, slots=True)
class SpecPath:
    """An Sdf path in the namespace of a layer."""

    steps: tuple[tuple[str, ...], ...]
    """A prim's name, or a variant set and a variant."""
    property_name: str | None

    @classmethod
    def of(cls, text: str) -> SpecPath:
        if "{" not in text:  # as most are
            prim, dot, name = text.partition(".")
            names = tuple((one,) for one in prim.split("/") if one)
            return cls(names, name.partition("[")[0] if dot else None)
        match = _PATH.match(text)
        assert match, "the pattern matches the empty text"  # noqa: S101 for mypy
        found = _STEP.finditer(match["prim"])
        steps = ((m["prim"],) if m["prim"] else (m["set"], m["variant"]) for m in found)
        return cls(tuple(steps), match["property"])

    @property
    def owner(self) -> str:
        """The prim without variants: what relative targets start from."""
        return "/" + "/".join(step[0] for step in self.steps if len(step) == 1)


def absolute(written: str, owner: str) -> str:
    """What a path in a list of `owner` means."""
    if not written or written.startswith("/"):
        return written
    names = owner.strip("/").split("/")
    while written.startswith(".."):
        names = names[:-1]
        written = written[2:].removeprefix("/")
    base = "/" + "/".join(names)
    if written in ("", "."):
        return base
    separator = "" if written.startswith(".") or base == "/" else "/"
    return base + separator + written


def unescaped(string: bytes) -> bytes:
    """As `TfEscapeString` reads it."""

    def one(match: re.Match[bytes]) -> bytes:
        hexadecimal, octal, other = match.groups()
        if hexadecimal is not None:
            return bytes((int(hexadecimal or b"0", 16),))
        if octal is not None:
            return bytes((int(octal, 8) & 0xFF,))
        return bytes((_CONTROL.get(other[0], other[0]),))

    return _ESCAPE.sub(one, string)


def raw_offset(raw: bytes, offset: int) -> int:
    """Where a byte of a string stands in its text, in which some are escaped."""
    at = plain = 0
    for escape in _ESCAPE.finditer(raw):
        if plain + escape.start() - at >= offset:
            break
        plain += escape.start() - at + 1
        at = escape.end()
    return at + offset - plain


def decoded(text: bytes) -> str:
    return text.decode("utf-8", "replace")


def encoded(text: str) -> bytes:
    return text.encode("utf-8", "surrogatepass")
