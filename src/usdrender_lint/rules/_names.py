"""How is the name of a product read: where is the frame, the extension, what is for a shell to expand?"""

from __future__ import annotations

import posixpath
import re
from functools import lru_cache

from ..lazily import lazily
from ..rule import Renderer

_PLAIN = lazily(r"[\w./-]*")

_FRAME_TOKEN = lazily(
    r"""
      [$]F{1,3}\d*(?![A-Za-z_]) | [$]\{F{1,3}\d*\} | [$]\{?FRAME\b\}?    # husk, Houdini, shells
    | <F\d*> | <frame[^<>]*> | \{frame[^{}]*\} | \[frame\] | @Frame@?    # pipelines, Maya
    | [#]{2,} | (?<=[._-])[#](?=\.) | %0?\d*d(?![A-Za-z])             # Nuke, usdrecord, printf
    """,
    re.VERBOSE | re.IGNORECASE,
)
"""What some program or other replaces by the frame. USD itself replaces nothing."""

_PLACEHOLDER = lazily(r"[$]\w|[$]\{|%\w+%|[<{\[`]")
"""Something is to be filled in before the name is used."""

_NUMBER = lazily(r"(?<!\d)\d{3,}(?=\.[A-Za-z]\w*$)")

_MOVIES = frozenset({".avi", ".gif", ".m4v", ".mkv", ".mov", ".mp4", ".mxf", ".webm"})

DRIVER_ATTRIBUTES = ("arnold:driver", "ri:productType")
"""On a product they choose what writes the file, whatever its extension."""


def is_plain(name: str) -> bool:
    """Most are: nothing in it is to be replaced, or means anything to a shell."""
    return _PLAIN.fullmatch(name) is not None


def frame_token(name: str) -> str | None:
    """The first token that some program replaces by the frame."""
    if is_plain(name):
        return None
    found = _FRAME_TOKEN.search(name)
    return found[0] if found else None


def without_expanded(name: str, renderer: Renderer) -> str:
    """The name without what the renderer itself replaces."""
    for pattern in (*renderer.frame_tokens, *renderer.name_variables):
        name = re.sub(pattern, "", name)
    return name


def without_tokens(name: str, renderer: Renderer) -> str:
    """Without frame tokens of any kind, too."""
    return _FRAME_TOKEN.sub("", without_expanded(name, renderer))


def has_placeholder(name: str) -> bool:
    return frame_token(name) is not None or _PLACEHOLDER.search(name) is not None


def frame_number(name: str) -> str | None:
    """Digits before the extension that look like one frame's number."""
    found = _NUMBER.search(name)
    return found[0] if found else None


@lru_cache(maxsize=256)
def extension_of(name: str) -> str:
    """As written, with the dot; a frame number or token behind it is no extension."""
    stem, extension = posixpath.splitext(name.replace("\\", "/"))
    if extension[1:].isdigit() or (
        not is_plain(extension) and _FRAME_TOKEN.fullmatch(extension[1:])
    ):
        extension = posixpath.splitext(stem)[1]
    return extension


def is_movie(name: str) -> bool:
    return extension_of(name).lower() in _MOVIES


def is_file(name: str, renderer: Renderer) -> bool:
    """Not empty, nor one of a renderer's names for no file at all."""
    return bool(name) and name not in renderer.special_product_names


def quoted(name: str) -> str:
    """Fit for a message: control characters spelled out."""
    return "'" + "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in name) + "'"
