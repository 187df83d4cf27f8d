"""How does a report reach standard output or a file, whole or not at all?"""

from __future__ import annotations

import os
import sys
from pathlib import Path


class OutputError(Exception):
    """A report cannot be written."""


def write_out(text: str) -> None:
    """To standard output, in UTF-8 whatever the terminal says: JSON allows no other encoding.

    `BrokenPipeError` when the reader has gone.
    """
    try:
        _write_out(text)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OutputError(f"standard output cannot be written: {_reason(error)}") from None


def _write_out(text: str) -> None:
    stream = getattr(sys.stdout, "buffer", None)
    if stream is None:
        sys.stdout.write(text)
        return
    if sys.stdout.isatty() and (encoding := sys.stdout.encoding or "ascii").lower() != "utf-8":
        stream.write(text.encode(encoding, "backslashreplace"))
    else:
        stream.write(text.encode("utf-8", "backslashreplace"))
    stream.flush()


def write_file(file: Path, text: str) -> None:
    """Beside the file, then renamed: an interrupted run leaves the old report or the new one."""
    data = text.encode("utf-8", "backslashreplace")
    try:
        if file.exists() and not file.is_file():  # a pipe or a device cannot be replaced
            file.write_bytes(data)
            return
        _replace(file.resolve(), data)
    except OSError as error:
        raise OutputError(f"{file} cannot be written: {_reason(error)}") from None


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()


def _replace(file: Path, data: bytes) -> None:
    import tempfile

    handle, beside = tempfile.mkstemp(prefix=f".{file.name}.", dir=file.parent)
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
        mode = file.stat().st_mode & 0o777 if file.exists() else 0o666 & ~_umask()
        Path(beside).chmod(mode)
        Path(beside).replace(file)
    except BaseException:
        Path(beside).unlink(missing_ok=True)
        raise


def _umask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current
