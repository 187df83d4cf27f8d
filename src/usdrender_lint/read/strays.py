"""Which render prims stand outside the render scope, asked of layers rather than of the stage?"""

from __future__ import annotations

import mmap
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from pxr import Sdf, Usd

from ..handed import bytes_at
from ..lazily import lazily
from ..stage import Opened, everything, render_prims
from .crate_types import crate_types
from .specs import children_of, there, variants_of

_KIND = r"(?:[Ss]ettings?|[Pp]roducts?|[Vv]ars?|[Pp]ass(?:es)?)"
_TYPE = lazily(f"(?:Usd)?[Rr]ender{_KIND}")
"""Of the names that come near a type's, only these are looked for outside the scopes."""
_WORD = lazily(  # with a literal beginning the search is eight times as fast
    rb"ender(?:(?<=\bRender)(?:Settings|Product|Var|Pass)\b"
    rb"|(?:(?<=\b[Rr]ender)|(?<=\bUsd[Rr]ender))" + _KIND.encode() + rb'(?=\s+"))'
)


def stray_paths(opened: Opened) -> list[str]:
    """Composed paths of specs of a render type, or nearly of one, outside the scopes, in the root
    layer stack, sorted. Of a stage that is there as a whole, those of its prims."""
    stage, scopes = opened.stage, opened.scopes
    if opened.whole:
        return sorted(_on_stage(opened))
    found: set[str] = set()
    for layer in stage.GetLayerStack(includeSessionLayers=False):
        found.update(_in_layer(layer, scopes))
    return sorted(found)


def _on_stage(opened: Opened) -> Iterator[str]:
    prims: Iterable[Usd.Prim] = render_prims(opened)
    if any(map(_TYPE.fullmatch, opened.other_types)):
        prims = everything(opened.stage)
    for prim in prims:
        path = str(prim.GetPath())
        if _TYPE.fullmatch(prim.GetTypeName()) and not any(
            path.startswith(f"{scope}/") for scope in opened.scopes
        ):
            yield path


def _in_layer(layer: Sdf.Layer, scopes: tuple[str, ...]) -> Iterable[str]:
    """A walk of all specs from Python costs 7 us each: most layers can be spared it."""
    file = bytes_at(layer.realPath)
    if not file or not Path(file).is_file():
        return _outside(layer, scopes)
    with Path(file).open("rb") as stream:
        head = stream.read(8)
    if head.startswith(b"PXR-USDC"):
        return _in_crate(file, layer, scopes)
    # Every typed spec has its type's name in the text once. Where the scopes account for all of
    # the names, none is left for a stray; a name in a comment or string costs a walk, no more.
    if not head.startswith(b"PK") and _named_in_text(file) <= _inside(layer, scopes):
        return ()
    return _outside(layer, scopes)


def _in_crate(file: str, layer: Sdf.Layer, scopes: tuple[str, ...]) -> Iterable[str]:
    typed = crate_types(file, re.compile(_TYPE.pattern.encode()))
    if typed is not None and typed.count <= _inside(layer, scopes):
        return ()
    paths = typed.paths() if typed is not None else None
    if paths is None:
        return _outside(layer, scopes)
    return [path for path in paths if not any(path.startswith(scope + "/") for scope in scopes)]


def _named_in_text(file: str) -> int:
    with Path(file).open("rb") as stream:
        if not stream.read(1):
            return 0
        with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as text:
            return sum(1 for _ in _WORD.finditer(text))


def _inside(layer: Sdf.Layer, scopes: tuple[str, ...]) -> int:
    count = 0
    for scope in scopes:
        if spec := layer.GetPrimAtPath(scope):
            count += sum(_is_wanted(s) for child in children_of(spec) for s in _walk(child))
    return count


def _outside(layer: Sdf.Layer, scopes: tuple[str, ...]) -> Iterator[str]:
    for root in there(layer.rootPrims):
        for spec in _walk(root, skip=scopes):
            if _is_wanted(spec):
                yield str(spec.path.StripAllVariantSelections())


def _is_wanted(spec: Sdf.PrimSpec) -> bool:
    return bool(_TYPE.fullmatch(spec.typeName))


def _walk(spec: Sdf.PrimSpec, skip: tuple[str, ...] = ()) -> Iterator[Sdf.PrimSpec]:
    pending = [spec]
    while pending:
        one = pending.pop()
        if skip and str(one.path) in skip:
            # A render prim *at* the scope's own path is outside, too.
            if _is_wanted(one):
                yield one
            continue
        yield one
        pending.extend(children_of(one))
        pending.extend(variants_of(one))
