"""How is a regular expression compiled only when something is matched with it?

There are ninety of them, and compiling them takes longer than linting a small file, which needs few.
"""

from __future__ import annotations

import re
from typing import Any, AnyStr, cast

_USES = (
    "findall",
    "finditer",
    "flags",
    "fullmatch",
    "groupindex",
    "groups",
    "match",
    "pattern",
    "scanner",
    "search",
    "split",
    "sub",
    "subn",
)


def lazily(pattern: AnyStr, flags: int = 0) -> re.Pattern[AnyStr]:
    """As `re.compile`, but a pattern that is wrong raises when it is used first."""
    return cast("re.Pattern[AnyStr]", _Later(pattern, flags))


class _Later:
    def __init__(self, pattern: Any, flags: int) -> None:
        self._asked = (pattern, flags)

    def __reduce__(self) -> tuple[Any, ...]:
        """Copied or pickled without what was compiled, as Python does it with its own."""
        return _Later, self._asked

    def __getattr__(self, name: str) -> object:
        """Called for what is not there yet: after the first time everything is."""
        compiled = re.compile(*self._asked)
        for use in _USES:
            setattr(self, use, getattr(compiled, use))
        return getattr(compiled, name)
