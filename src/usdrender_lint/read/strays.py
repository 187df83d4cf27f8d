"""Which render prims stand outside the render scope, asked of layers rather than of the stage?"""

from __future__ import annotations

import mmap
from collections.abc import Iterable, Iterator
from pathlib import Path

from pxr import Sdf, Usd

from ..handed import bytes_at
from ..lazily import lazily
from ..model import RENDER_TYPES
from ..stage import Opened, everything, render_prims
from .crate_types import crate_types
from .specs import children_of, there, variants_of

_KIND = r"(?:[Ss]ettings?|[Pp]roducts?|[Vv]ars?|[Pp]ass(?:es)?)"
_TYPE = lazily(f"(?:Usd)?[Rr]ender{_KIND}")
"""Of the names that come near a type's, only these are looked for outside the scopes."""
_IN_TOKENS = lazily(f"(?:Usd)?[Rr]ender{_KIND}".encode())
_PART = lazily(f"ender{_KIND}".encode())
_WORD = lazily(  # with a literal beginning the search is eight times as fast
    rb"ender(?:(?<=\bRender)(?:Settings|Product|Var|Pass)\b"
    rb"|(?:(?<=\b[Rr]ender)|(?<=\bUsd[Rr]ender))" + _KIND.encode() + rb'(?=\s+"))'
)


_FEW = 40
"""Specs outside the scopes that are looked at sooner than a file is: most layers have fewer."""


def stray_paths(opened: Opened) -> list[str]:
    """Composed paths of specs of a render type, or nearly of one, outside the scopes, in the root
    layer stack, sorted. Of a stage that is there as a whole, those of its prims."""
    stage, scopes = opened.stage, opened.scopes
    if opened.whole:
        return sorted(_on_stage(opened))
    found: set[str] = set()
    for layer in stage.GetLayerStack(includeSessionLayers=False):
        few = _outside(layer, scopes, _FEW)
        found.update(_in_layer(layer, scopes) if few is None else few)
    return sorted(found)


def _on_stage(opened: Opened) -> Iterator[str]:
    prims = [*render_prims(opened)]
    if any(map(_TYPE.fullmatch, opened.other_types)):
        own = set(opened.stage.GetLayerStack(includeSessionLayers=False))
        prims += (p for p in everything(opened.stage) if _nearly_typed_in(own, p))
    for prim in prims:
        path = str(prim.GetPath())
        if not any(path.startswith(f"{scope}/") for scope in opened.scopes):
            yield path


def _nearly_typed_in(layers: set[Sdf.Layer], prim: Usd.Prim) -> bool:
    """What another asset misspells is its own affair."""
    return bool(_TYPE.fullmatch(prim.GetTypeName())) and any(
        _is_wanted(spec) and spec.layer in layers for spec in prim.GetPrimStack()
    )


def _in_layer(layer: Sdf.Layer, scopes: tuple[str, ...]) -> Iterable[str]:
    """A walk of all specs from Python costs 2 us each: most large layers can be spared it."""
    file = bytes_at(layer.realPath)
    if not file or not Path(file).is_file():
        return _outside(layer, scopes) or ()
    with Path(file).open("rb") as stream:
        head = stream.read(8)
    if head.startswith(b"PXR-USDC"):
        return _in_crate(file, layer, scopes)
    # Every typed spec has its type's name in the text once. Where the scopes account for all of
    # the names, none is left for a stray; a name in a comment or string costs a walk, no more.
    if not head.startswith(b"PK") and _named_in_text(file) <= _inside(layer, scopes):
        return ()
    return _outside(layer, scopes) or ()


def _in_crate(file: str, layer: Sdf.Layer, scopes: tuple[str, ...]) -> Iterable[str]:
    typed = crate_types(file, _IN_TOKENS, _PART)
    if typed is not None and typed.count <= _inside(layer, scopes):
        return ()
    paths = typed.paths() if typed is not None else None
    if paths is None:
        return _outside(layer, scopes) or ()
    return [path for path in paths if not any(path.startswith(scope + "/") for scope in scopes)]


def _named_in_text(file: str) -> int:
    with Path(file).open("rb") as stream:
        if not stream.read(1):
            return 0
        with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as text:
            return sum(1 for _ in _WORD.finditer(text))


def _inside(layer: Sdf.Layer, scopes: tuple[str, ...]) -> int:
    tops = filter(None, map(layer.GetPrimAtPath, scopes))
    pending = [child for top in tops for child in children_of(top)]
    count = 0
    while pending:
        one = pending.pop()
        count += _is_wanted(one)
        pending += children_of(one)
        pending += variants_of(one)
    return count


def _outside(
    layer: Sdf.Layer, scopes: tuple[str, ...], most: int | None = None
) -> list[str] | None:
    """By a walk over all specs; None if there are more than `most`."""
    skip = {Sdf.Path(scope) for scope in scopes}
    found = list[str]()
    listed = len(layer.rootPrims)
    if most is not None and listed > most:
        return None
    pending = there(layer.rootPrims)
    while pending:
        one = pending.pop()
        # A render prim *at* the scope's own path is outside, too.
        if _is_wanted(one):
            found.append(str(one.path.StripAllVariantSelections()))
        if one.path in skip:
            continue
        listed += len(one.nameChildren)
        if most is not None and listed > most:
            return None
        pending += children_of(one)
        pending += variants_of(one)
    return found


def _is_wanted(spec: Sdf.PrimSpec) -> bool:
    name = spec.typeName
    return bool(name) and (name in RENDER_TYPES or _TYPE.fullmatch(name) is not None)
