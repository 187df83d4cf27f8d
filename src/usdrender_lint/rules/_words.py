"""How do rules spell paths, lists and guesses?"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ..likeness import likeness
from ..model import Candidate, Target

SIMILAR = 0.78
"""Ratio from which two names may be one misspelt; found by trial on real files."""

_ENDING = 2
"""Letters that a plural or a slip adds at the end."""
_OPPOSITES = (("enable", "disable"), ("in", "out"), ("in", "ex"), ("on", "off"), ("min", "max"))


def one_of(names: Iterable[str]) -> str:
    """'a', 'b' or 'c'."""
    quoted = [f"'{n}'" for n in names]
    if len(quoted) < 2:
        return "".join(quoted)
    return f"{', '.join(quoted[:-1])} or {quoted[-1]}"


def paths(found: Iterable[str], most: int = 4) -> str:
    """</a>, </b> and 3 more."""
    listed = [f"<{p}>" for p in found]
    if len(listed) > most:
        return f"{', '.join(listed[:most])} and {len(listed) - most} more"
    if len(listed) < 2:
        return "".join(listed)
    return f"{', '.join(listed[:-1])} and {listed[-1]}"


def nearest(name: str, known: Iterable[str], least: float = SIMILAR) -> str | None:
    """The name that was probably meant, if any is near enough. Antonyms are never typos of each other."""
    best = max(
        (k for k in known if not _are_opposites(name, k) and not _extends(name, k)),
        key=lambda k: (likeness(name, k), k),
        default=None,
    )
    return best if best is not None and likeness(name, best) >= least else None


def _extends(name: str, known: str) -> bool:
    """`resolutionX` and `proxyResolution` are names of their own, not a misspelt `resolution`."""
    if name.startswith(known) and name[len(known) :][:1].isupper():
        return True
    long, short = name.lower(), known.lower()
    return len(long) - len(short) > _ENDING and (long.startswith(short) or long.endswith(short))


def _are_opposites(one: str, other: str) -> bool:
    a, b = one.lower(), other.lower()
    return any(
        (a.startswith(x) and b.startswith(y)) or (a.startswith(y) and b.startswith(x))
        for x, y in _OPPOSITES
        if a.startswith((x, y)) and b.startswith((x, y)) and a[:3] != b[:3]
    )


def is_near(target: Target, other: Candidate) -> bool:
    """Of nearly the same name, or below it as the camera is below an Xform."""
    name = target.path.partition(".")[0].rpartition("/")[2]
    return likeness(name, other.name) >= SIMILAR or other.path.startswith(target.path + "/")


def probably_meant(target: Target) -> Candidate | None:
    """By a target that may yet be elsewhere: only a prim beside it, of nearly the same name."""
    beside = target.path.rpartition("/")[0]
    for other in target.candidates[:1]:
        if other.path.rpartition("/")[0] == beside and is_near(target, other):
            return other
    return None


def meant_instead(target: Target, other: Candidate) -> str:
    """Of a target that what did not open may bring."""
    hiding = target.because or ""
    asset = hiding if hiding.startswith("<") else f"@{hiding}@"
    return f"did you mean <{other.path}>? {asset} did not open, and may also bring it"


def did_you_mean(target: Target, kind: str, plural: str) -> str:
    """What a broken target may have meant, or which prims there are to choose from."""
    found = target.candidates
    if not found:
        return f"no {kind} was found to point it at"
    best = found[0]
    if is_near(target, best):
        return f"did you mean <{best.path}>?"
    if len(found) == 1:  # no guess: it may be of the right type and nothing else
        return f"the only {kind} found is <{best.path}>"
    return f"{plural} found: {paths(c.path for c in found)}"


def a_or_an(noun: str) -> str:
    return f"{'an' if noun[:1].lower() in 'aeioux' else 'a'} {noun}"


def joined(parts: Sequence[str]) -> str:
    """a, b and c."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


def spelt(value: object) -> str:
    """A value as usda has it, but for sizes: true, 0.5, (0, 0, 1, 1), 'raw', 1920 x 1080."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return f"{value:g}"
    if isinstance(value, tuple):
        if len(value) == 2 and all(isinstance(v, int) for v in value):
            return f"{value[0]} x {value[1]}"
        opening, closing = "[]" if all(isinstance(v, str) for v in value) else "()"
        return f"{opening}{', '.join(map(spelt, value))}{closing}"
    return f"'{value}'"
