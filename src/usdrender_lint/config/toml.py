"""What stands in a TOML file, or where it stops being one?"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from ..lazily import lazily
from ..whole import read_whole
from . import ConfigError, Wrong
from .places import Stretch
from .wrong import wrong_at

_BARE = lazily(r"[A-Za-z_][\w.:/*-]*")
_AT = lazily(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")


def load(file: Path) -> tuple[str, dict[str, Any]]:
    """The text, with `\\n` for its line breaks, and its meaning. `ConfigError` where there is none."""
    text = read_text(file)
    try:
        return text, tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise _not_toml(file, text, str(error)) from None
    except RecursionError:
        raise ConfigError([Wrong(file, "nested too deeply")]) from None
    except ValueError:  # Python reads no number of more than some thousand digits
        raise ConfigError([Wrong(file, "a number in it is too long")]) from None


def read_text(file: Path) -> str:
    try:
        data = read_whole(file)
    except FileNotFoundError:
        raise ConfigError([Wrong(file, "no such file")]) from None
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise ConfigError([Wrong(file, f"cannot be read: {reason}")]) from None
    if data.startswith(b"\xef\xbb\xbf"):
        said = "begins with a UTF-8 byte order mark, which TOML does not allow"
        raise ConfigError([Wrong(file, said)])
    try:
        return data.decode().replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        text = data[: error.start].decode().replace("\r\n", "\n")
        stretch = Stretch(len(text), len(text) + 1)
        raise ConfigError([wrong_at(file, text, stretch, "not UTF-8 from here on")]) from None


def _not_toml(file: Path, text: str, said: str) -> ConfigError:
    """What `tomllib` says ends with the place, if it is not the end of the text."""
    found = _AT.search(said)
    at = len(text)
    if found and found[1]:
        lines = text.split("\n")
        at = sum(len(line) + 1 for line in lines[: int(found[1]) - 1]) + int(found[2]) - 1
    what = said[: found.start()] if found else said
    if what == "Invalid value" and (bare := _BARE.match(text, at)):
        word = bare[0].lower() if bare[0].lower() in ("true", "false") else f'"{bare[0]}"'
        what = f"{bare[0]} is no value: did you mean {word}?"
        return ConfigError([wrong_at(file, text, Stretch(*bare.span()), f"not TOML: {what}")])
    what = f"not TOML: {what[:1].lower()}{what[1:]}"
    if at >= len(text):
        # Behind the last line break there is nothing to show.
        what, at = f"{what}, at the end", max(0, len(text.rstrip()) - 1)
    return ConfigError([wrong_at(file, text, Stretch(at, at + 1), what)])
