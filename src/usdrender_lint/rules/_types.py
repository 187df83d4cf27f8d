"""How many numbers does a dataType hold, and of what kind?"""

from __future__ import annotations

from functools import lru_cache

from ..lazily import lazily
from ..records import dataclass

_PIXEL = lazily(
    r"(?P<base>half|float|double|int|uint)(?P<size>[234])?"
    r"|(?P<other>u?int64|uchar|u?int8|[iu]8|float16)"
    r"|(?:color|point|vector|normal|texCoord)(?P<length>[234])(?P<kind>[hfd]|[iu]8)"
)


@dataclass(frozen=True, slots=True)
class Pixel:
    components: int
    whole: bool
    """Whole numbers."""
    half: bool
    """16 bits: whole numbers only to 2048."""


@lru_cache(maxsize=256)  # all vars have one of a few
def pixel(data_type: str) -> Pixel | None:
    """None for a type that is no pixel of an image: text, matrices, arrays ..."""
    found = _PIXEL.fullmatch(data_type)
    if found is None:
        return None
    kind = found["base"] or found["other"] or found["kind"]
    whole = kind.startswith(("int", "uint", "uchar", "i8", "u8"))
    half = kind in ("half", "float16", "h")
    return Pixel(int(found["size"] or found["length"] or 1), whole, half)
