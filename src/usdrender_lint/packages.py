"""What is in a usdz package?

`zipfile` is imported where there is one to open: most runs do without.
"""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import IO

from .lazily import lazily

MAGIC = b"PK\x03\x04"
"""What a package with a file in it begins with."""
_IN_PACKAGE = lazily(r"(.*?\.usdz)\[(.*)\]", re.IGNORECASE | re.DOTALL)


def split_package(name: str) -> tuple[str, str | None]:
    """A file, and the member that is meant if it is a package."""
    match = _IN_PACKAGE.fullmatch(name) if name.endswith("]") else None
    return (match[1], match[2]) if match else (name, None)


def first_member(package: str, member: str | None) -> str | None:
    """That of a package, or of a package in it; it is what USD opens."""
    import zipfile

    try:
        with Path(package).open("rb") as stream:
            inner = bytes_of(stream, member) if member else b""
            with zipfile.ZipFile(io.BytesIO(inner) if inner else stream) as archive:
                return next(iter(archive.namelist()), None)
    except _damages():
        return None


def _damages() -> tuple[type[Exception], ...]:
    """What `zipfile` raises of a damaged package: also that it wants a later version of the format."""
    import zipfile
    import zlib

    read = (zipfile.BadZipFile, zlib.error, EOFError, KeyError)
    return (*read, OSError, RuntimeError, ValueError)


def bytes_of(package: IO[bytes], member: str) -> bytes | None:
    """A member, which may be in a package that is a member itself."""
    import zipfile

    first, inner = split_package(member)
    try:
        with zipfile.ZipFile(package) as archive:
            found = archive.read(first)
    except _damages():
        return None
    return bytes_of(io.BytesIO(found), inner) if inner else found
