"""What do its first bytes tell of a file that USD cannot open by its name?"""

from __future__ import annotations

import os

from . import crate, packages
from .lazily import lazily

LFS = b"version https://git-lfs.github.com/spec/v1"
POINTER = "a Git LFS pointer, not the file itself: run `git lfs pull`"
EMPTY = "the file is empty"

_HEADER = lazily(rb"#(?:usda|sdf)\b")
_UTF16 = "UTF-16 text, which USD refuses: save it as UTF-8 without BOM"
_UTF32 = "UTF-32 text, which USD refuses: save it as UTF-8 without BOM"
_PACKED = "packed by {}, which USD does not read: unpack it"
_NO_LAYER = {
    b"\xef\xbb\xbf": "begins with a UTF-8 byte order mark, which USD refuses: save it as UTF-8 without BOM",
    b"\xff\xfe\0\0": _UTF32,  # it begins as UTF-16 does
    b"\0\0\xfe\xff": _UTF32,
    b"#\0\0\0": _UTF32,  # the first letter of a header, where there is no mark
    b"\0\0\0#": _UTF32,
    b"\xff\xfe": _UTF16,
    b"\xfe\xff": _UTF16,
    b"#\0": _UTF16,
    b"\0#": _UTF16,
    b"PK\x05\x06": "a zip package without a file in it",
    b"\x1f\x8b": _PACKED.format("gzip"),
    b"BZh": _PACKED.format("bzip2"),
    b"\xfd7zXZ": _PACKED.format("xz"),
    b"(\xb5/\xfd": _PACKED.format("zstd"),
    b"7z\xbc\xaf": _PACKED.format("7-Zip"),
    b"Rar!": _PACKED.format("RAR"),
}


def why_no_layer(name: str, head: bytes) -> str | None:
    """None where the bytes may be what the name says."""
    if not head:
        return EMPTY
    if head.startswith((*_NO_LAYER,)):
        return next(told for first, told in _NO_LAYER.items() if head.startswith(first))
    if not head.strip(b"\0"):
        return "begins with nothing but zero bytes, as a full disk or a broken copy leaves them"
    return _wrong_format(name, head)


def _wrong_format(name: str, head: bytes) -> str | None:
    suffix = os.path.splitext(name)[1].lower()
    is_crate, is_package = head.startswith(crate.MAGIC), head.startswith(packages.MAGIC)
    expected = {
        ".usd": not is_package,
        ".usda": not (is_crate or is_package),
        ".usdc": is_crate,
        ".usdz": is_package,
    }
    if not expected.get(suffix, True):
        found = (
            "a binary crate"
            if is_crate
            else "a zip package"
            if is_package
            else "usda text"
            if _HEADER.match(head)
            else "something else"
        )
        return f"named {suffix}, but holds {found}: USD opens it by its name"
    if is_crate or is_package or b"\0" not in head:
        return None
    if _HEADER.match(head):
        line = head.count(b"\n", 0, head.index(b"\0")) + 1
        return f"a zero byte stands in its text, in line {line}: it is damaged"
    return "binary data that is not USD"
