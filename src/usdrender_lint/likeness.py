"""How alike are two names, and which of many is most like one? In time that many names can afford; `difflib` is imported where there is something to compare."""

from __future__ import annotations

from collections.abc import Iterable
from heapq import heappush, heapreplace

_MEANT = 0.6
"""Of two words that are less alike than that, one is no misspelling of the other."""


_LONGEST = 1000
"""Characters of what may be misspelt by anybody: to compare millions takes minutes."""


def likeness(one: str, other: str) -> float:
    """1 for the same but for upper and lower case, 0 for nothing in common."""
    if max(len(one), len(other)) > _LONGEST:
        return float(one.lower() == other.lower())
    from difflib import SequenceMatcher

    return SequenceMatcher(None, one.lower(), other.lower()).ratio()


def is_like(one: str, other: str, least: float) -> bool:
    """Whether the likeness is as great as that. Most names have not even the letters for it."""
    if max(len(one), len(other)) > _LONGEST:
        return one.lower() == other.lower()
    one, other = one.lower(), other.lower()
    common = sum([min(one.count(letter), other.count(letter)) for letter in {*one}])
    most = 2.0 * common / (len(one) + len(other))
    return most >= least and likeness(one, other) >= least


def most_alike(name: str, known: Iterable[str], most: int) -> list[tuple[float, str]]:
    """The names most like one, best first, equally alike ones by the alphabet.

    `difflib` takes 20 us for two names, and an upper bound is known for a tenth of it: so what can
    be none of the best is not compared.
    """
    if len(name) > _LONGEST:
        return []
    from difflib import SequenceMatcher

    matcher = SequenceMatcher()
    matcher.set_seq2(name.lower())
    best: list[tuple[float, _Backwards]] = []
    for other in sorted(one for one in set(known) if len(one) <= _LONGEST):
        matcher.set_seq1(other.lower())
        least = best[0][0] if len(best) == most else -1.0
        if matcher.real_quick_ratio() <= least or matcher.quick_ratio() <= least:
            continue
        ratio = matcher.ratio()
        if len(best) < most:
            heappush(best, (ratio, _Backwards(other)))
        elif ratio > least:
            heapreplace(best, (ratio, _Backwards(other)))
    return [(ratio, str(other)) for ratio, other in sorted(best, reverse=True)]


def closest(name: str, known: Iterable[str]) -> str | None:
    """The one that was likely meant, if any; upper and lower case are no difference."""
    for ratio, other in most_alike(name, known, 1):
        return other if ratio >= _MEANT else None
    return None


class _Backwards(str):
    """Of equally alike names the last of the alphabet is the worst."""

    __slots__ = ()

    def __lt__(self, other: str) -> bool:
        return str.__gt__(self, other)
