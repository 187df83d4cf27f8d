"""What do two processes of one run say to each other: frames, each after its length, of what Python
can take apart and put together again?"""

from __future__ import annotations

import copyreg
import io
import pickle
from typing import Any, Protocol

from ..registry import all_rules
from ..rule import AnyRule, Rule

HEAD = 8
"""Bytes of a length."""


class Channel(Protocol):
    """A socket, or what looks like one."""

    def fileno(self) -> int: ...
    def recv(self, size: int, /) -> bytes: ...
    def sendall(self, data: bytes, /) -> None: ...
    def close(self) -> None: ...


def framed(data: bytes) -> bytes:
    return len(data).to_bytes(HEAD, "little") + data


def received(channel: Channel) -> bytes:
    """The next frame, however long it takes to come; `EOFError` if none will."""
    return _exactly(channel, int.from_bytes(_exactly(channel, HEAD), "little"))


def _exactly(channel: Channel, size: int) -> bytes:
    data = bytearray()
    while len(data) < size:
        if not (more := channel.recv(min(size - len(data), 1 << 20))):
            raise EOFError
        data += more
    return bytes(data)


def frames_in(heard: bytearray) -> list[bytes]:
    """The whole ones, taken out of what was heard."""
    frames = []
    while len(heard) >= HEAD:
        end = HEAD + int.from_bytes(heard[:HEAD], "little")
        if len(heard) < end:
            break
        frames.append(bytes(heard[HEAD:end]))
        del heard[:end]
    return frames


def packed(value: object) -> bytes:
    """Rules are known on both sides: they cross by their names."""
    stream = io.BytesIO()
    pickler = pickle.Pickler(stream, pickle.HIGHEST_PROTOCOL)
    # What Python knows of other types is looked for nowhere else.
    pickler.dispatch_table = copyreg.dispatch_table | {Rule: lambda rule: (_rule, (rule.id,))}
    pickler.dump(value)
    return stream.getvalue()


def unpacked(data: bytes) -> Any:
    return pickle.loads(data)  # noqa: S301 of our own workers


def _rule(id: str) -> AnyRule:
    return all_rules()[id]
