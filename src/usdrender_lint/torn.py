"""Which of the layers in use are crates that USD reads past the end of what they hold?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from . import packages
from .crate import is_torn
from .unopened import Unreadable

_SAID = (
    "USD opens it, and it is damaged: its table of names is shorter than it says, and what USD reads"
    " behind it is another at each run"
)


def torn_among(names: Iterable[str]) -> Iterator[Unreadable]:
    """Of names as USD has them: files, packages, members of packages."""
    for name in sorted(filter(None, {*names})):
        if _is_torn(*packages.split_package(name)):
            yield Unreadable(name, "unreadable-file", _SAID)


def _is_torn(file: str, member: str | None) -> bool:
    if not file.lower().endswith(".usdz"):
        return is_torn(file)
    if member is None or member.lower().endswith(".usdz"):
        first = packages.first_member(file, member)
        member = f"{member}[{first}]" if member else first
    at = packages.extent(file, member) if member else None
    return at is not None and is_torn(file, at.start)
