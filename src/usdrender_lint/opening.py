"""Does a file open as a layer, and if not, why not? In a sentence for the one who wrote it."""

from __future__ import annotations

import os
import stat

from pxr import Sdf, Tf

from . import packages
from .diagnostics import sentences
from .discover import USD_SUFFIXES
from .handed import bytes_at
from .heads import LFS, POINTER, why_no_layer
from .unopened import ParseProblem, Unreadable

FOLDER = "a folder"
_MANY = 100
"""Complaints of USD about one file that are read, from the first and to the last."""

ARGUMENTS = ":SDF_FORMAT_ARGS:"
"""What parts the name of a file from what its format is to be told."""


def look(file: str) -> Unreadable | None:
    """What the first bytes tell before USD is asked; its own messages differ by extension."""
    if not file.isascii() and file.encode(errors="replace").decode() != file:
        return Unreadable(file, "unreadable-file", "its name is not UTF-8, which USD needs")
    if what := _wrong_name(file):
        return Unreadable(file, "unreadable-file", what)
    at = bytes_at(file)
    try:
        if what := no_file(os.stat(at).st_mode):
            return Unreadable(file, "unreadable-file", f"{what}, not a file")
        with open(at, "rb", buffering=0) as stream:
            head = stream.read(1024)
    except OSError as error:
        return _cannot_be_read(file, error)
    if head.startswith(LFS):
        return Unreadable(file, "lfs-pointer", POINTER)
    wrong = why_no_layer(file, head)
    if wrong is None and at != file and head.startswith(packages.MAGIC):
        wrong = "a package cannot be linted from standard input"
    return Unreadable(file, "unreadable-file", wrong) if wrong else None


def _wrong_name(file: str) -> str | None:
    name = os.path.basename(file)
    if name.lower() in USD_SUFFIXES:
        return "its name is an ending alone, by which USD knows no format: give it a name"
    if ARGUMENTS in name:
        return f"its name holds '{ARGUMENTS}', behind which USD reads no name: rename it"
    return None


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
        return "holds neither usda text, which begins with '#usda 1.0', nor a binary crate"
    from .refusal import of_member

    if why := of_member(file):
        return why.message
    if first := packages.first_member(file, None):
        said = f"its first file is '{first}', and USD opens no other: put the root layer first"
        return (
            said if not first.lower().endswith(USD_SUFFIXES) else f"USD cannot open '{first}' in it"
        )
    return "the package is truncated or damaged"


def _refused(file: str, error: Tf.ErrorException) -> Unreadable | ParseProblem:
    from .refusal import why_not

    try:
        said = error.args
        if len(said) > 2 * _MANY:  # each quotes the rest of its line, which may be long
            said = (*said[:_MANY], *said[-_MANY:])
        return why_not(file, sentences(said))
    except OSError as gone:  # since it was looked at
        return _cannot_be_read(file, gone)
