"""In what do the products of one render see the scene differently?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from ..model import Attr, HasSite, Output, Rel, Settings, ValueState


def are_alike(outputs: Iterable[Output]) -> bool:
    """Mostly they are: then nothing in them need be told apart."""
    return len({(*(t.path for t in o.camera.targets[:1]), *_values(o)) for o in outputs}) < 2


def _values(output: Output) -> tuple[object, ...]:
    return tuple(attr.value for _, attr in _attrs(output))


def views(outputs: Iterable[Output]) -> dict[str, set[object]]:
    """What is seen, by what can differ; products without a camera are another matter."""
    found: dict[str, set[object]] = {}
    for output in outputs:
        for what, value in _view(output):
            found.setdefault(what, set()).add(value)
    return found


def _view(output: Output) -> Iterator[tuple[str, object]]:
    if output.camera.targets:
        yield "camera", output.camera.targets[0].path
    for what, attr in _attrs(output):
        yield what, attr.value


def overrides(settings: Settings, output: Output) -> Iterator[tuple[str, HasSite]]:
    """What the product sees otherwise than its settings, and where that is said."""
    own = output.product.camera
    if own.targets and own.targets[0].path != _first(settings.camera):
        yield "camera", own.targets[0]
    for (what, seen), (_, common) in zip(_attrs(output), _attrs(settings), strict=True):
        # A value that is not read as it was meant is another matter.
        if seen.value != common.value and seen.state is ValueState.AUTHORED:
            yield what, seen


def _first(rel: Rel) -> str | None:
    return rel.targets[0].path if rel.targets else None


def _attrs(one: Output | Settings) -> Iterator[tuple[str, Attr[Any]]]:
    yield "resolution", one.resolution
    yield "pixel aspect", one.pixel_aspect_ratio
    yield "data window", one.data_window_ndc
