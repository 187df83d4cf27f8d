"""Does a file open as a layer, and if not, why not? In a sentence for the one who wrote it."""

from __future__ import annotations

import os
import stat

from pxr import Sdf, Tf

from . import crate, packages
from .diagnostics import sentences
from .discover import USD_SUFFIXES
from .handed import bytes_at
from .lazily import lazily
from .unopened import EMPTY, ParseProblem, Unreadable

FOLDER = "a folder"

_LFS = b"version https://git-lfs.github.com/spec/v1"
_HEADER = lazily(rb"#(?:usda|sdf)\b")
_UTF16 = "UTF-16 text, which USD refuses: save it as UTF-8 without BOM"
_NO_LAYER = {
    b"\xef\xbb\xbf": "begins with a UTF-8 byte order mark, which USD refuses: save it as UTF-8 without BOM",
    b"\xff\xfe": _UTF16,
    b"\xfe\xff": _UTF16,
    b"#\0": _UTF16,  # the first letter of a header, where there is no mark
    b"\0#": _UTF16,
    b"PK\x05\x06": "a zip package without a file in it",
}
"""What is told of a file by its first bytes."""


def look(file: str) -> Unreadable | None:
    """What the first bytes tell before USD is asked; its own messages differ by extension."""
    if not file.isascii() and file.encode(errors="replace").decode() != file:
        return Unreadable(file, "unreadable-file", "its name is not UTF-8, which USD needs")
    at = bytes_at(file)
    try:
        if what := no_file(os.stat(at).st_mode):
            return Unreadable(file, "unreadable-file", f"{what}, not a file")
        with open(at, "rb", buffering=0) as stream:
            head = stream.read(1024)
    except OSError as error:
        return _cannot_be_read(file, error)
    if head.startswith(_LFS):
        told = "a Git LFS pointer, not the file itself: run `git lfs pull`"
        return Unreadable(file, "lfs-pointer", told)
    if not head:
        wrong: str | None = EMPTY
    elif at != file and head.startswith(packages.MAGIC):
        wrong = "a package cannot be linted from standard input"
    elif head.startswith((*_NO_LAYER,)):
        wrong = next(told for first, told in _NO_LAYER.items() if head.startswith(first))
    else:
        wrong = _wrong_format(file, head)
    return Unreadable(file, "unreadable-file", wrong) if wrong else None


def _cannot_be_read(file: str, error: OSError) -> Unreadable:
    reason = (error.strerror or str(error)).lower()
    return Unreadable(file, "unreadable-file", f"cannot be read: {reason}")


def no_file(mode: int) -> str | None:
    """What stands where a file should. Opening a pipe is waiting for somebody who writes into it;
    a device may have no end, or do something."""
    if stat.S_ISREG(mode):
        return None
    kinds = {stat.S_IFDIR: FOLDER, stat.S_IFIFO: "a named pipe", stat.S_IFSOCK: "a socket"}
    return kinds.get(stat.S_IFMT(mode), "a device")


def _wrong_format(file: str, head: bytes) -> str | None:
    suffix = os.path.splitext(file)[1].lower()
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
    if not (is_crate or is_package) and b"\0" in head:
        return "binary data that is not USD"
    return None


def open_layer(file: str) -> Sdf.Layer | Unreadable | ParseProblem:
    """The layer, or why there is none."""
    if found := look(file):
        return found
    try:
        instead = bytes_at(file)
        layer = Sdf.Layer.FindOrOpen(file) if instead == file else _in_memory(file, instead)
    except Tf.ErrorException as error:
        return _refused(file, error)
    return Unreadable(file, "unreadable-file", _missing_in(file)) if layer is None else layer


def _in_memory(file: str, instead: str) -> Sdf.Layer | None:
    """What `instead` holds, under the name of `file`."""
    if found := Sdf.Layer.Find(file):
        return found
    read = Sdf.Layer.OpenAsAnonymous(instead)
    if read is None:
        return None
    layer = Sdf.Layer.New(read.GetFileFormat(), file)
    layer.TransferContent(read)
    return layer


def open_member(name: str) -> Sdf.Layer | Unreadable | ParseProblem:
    """A layer inside a package, or why there is none. `name` is `package.usdz[member]`."""
    try:
        if layer := Sdf.Layer.FindOrOpen(name):
            return layer
    except Tf.ErrorException as error:
        return _refused(name, error)
    return Unreadable(name, "unreadable-file", "USD cannot open this member of the package")


def _missing_in(file: str) -> str:
    """Why USD finds nothing, and has no words for it."""
    if not file.lower().endswith(".usdz"):
        return "USD finds nothing of USD in it"
    if first := packages.first_member(file, None):
        said = f"its first file is '{first}', and USD opens no other: put the root layer first"
        return (
            said if not first.lower().endswith(USD_SUFFIXES) else f"USD cannot open '{first}' in it"
        )
    return "the package is truncated or damaged"


def _refused(file: str, error: Tf.ErrorException) -> Unreadable | ParseProblem:
    from .refusal import why_not

    try:
        return why_not(file, sentences(error.args))
    except OSError as gone:  # since it was looked at
        return _cannot_be_read(file, gone)
