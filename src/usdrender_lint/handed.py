"""Where are the bytes of a file: under its own name, or handed over by somebody who has not saved them?

Whoever reads a layer asks here. The layer keeps its name, so what it refers to is found beside it,
and no report knows of another one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

_INSTEAD: dict[str, str] = {}
"""The file that holds the bytes, by the one that they are meant for."""


def bytes_at(file: str) -> str:
    """The file to read instead of `file`, which is mostly itself."""
    return _INSTEAD.get(file, file) if _INSTEAD else file


def handed_over() -> dict[str, str]:
    """What is read instead of which files; to be known in another process, too."""
    return dict(_INSTEAD)


def accept(instead: Mapping[str, str]) -> None:
    _INSTEAD.update(instead)


@contextmanager
def handing_over(file: str, data: bytes) -> Iterator[None]:
    """As if `file` held `data`."""
    import tempfile  # most runs do without

    kind = ".usdc" if data.startswith(b"PXR-USDC") else ".usda"
    name = Path(file).name if Path(file).suffix else f"stdin{kind}"
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        instead = Path(folder, name)
        instead.write_bytes(data)
        before = handed_over()
        accept({file: str(instead)})
        try:
            yield
        finally:
            _INSTEAD.clear()
            accept(before)
