"""What is told of a file that does not open, or that opens damaged?"""

from __future__ import annotations

from .model import Site
from .records import dataclass


@dataclass(frozen=True, slots=True)
class ParseProblem:
    """Why the text of a layer is no usda. `column` counts bytes from 1, as USD does; 0 where only an
    expression is known to be wrong and its place has to be found in the text."""

    file: str
    message: str
    line: int = 0
    column: int = 0
    spec: str | None = None
    """The property that cannot be read, where no line is told."""
    asked: Site | None = None
    """The arc that brings the layer in; of a root layer there is none."""


@dataclass(frozen=True, slots=True)
class Unreadable:
    """Why a file is no layer at all. Not a finding: nothing of it could be looked at."""

    file: str
    kind: str
    message: str
    asked_by: str | None = None
    """File of the layer that brings it in."""


class DamagedError(Exception):
    """A layer opens, and what it holds does not hang together: a spec is listed and not there."""
