"""What of a text can be shown on one line? All of it, with what is not printable spelt out."""

from __future__ import annotations


def escaped(text: str) -> str:
    r"""Text that a terminal only shows: what is not printable becomes `\x1b`, `\n`, `\u202e`."""
    return text if text.isprintable() else "".join(map(_visible, text))


def _visible(char: str) -> str:
    return char if char.isprintable() else char.encode("unicode_escape").decode("ascii")
