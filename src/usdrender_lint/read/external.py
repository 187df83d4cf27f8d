"""What is in the file that a pass names?"""

from __future__ import annotations

from pxr import Sdf, Tf, Usd

from ..lazily import lazily
from ..model import Rel, Site, State, Target
from ..opening import open_layer
from ..stage import kinds_of
from .prims import state_of

_USD = frozenset({".usd", ".usda", ".usdc", ".usdz"})
_LATER = lazily(r"^[A-Za-z][\w+.-]+:|[$<{%#`*]")
"""A scheme that another resolver knows, or something that is filled in before the name is used."""


def file_found(prim: Usd.Prim) -> bool | None:
    """Whether the pass's file resolves; None without one, or where that cannot be told here."""
    asset = _asset(prim)
    if asset is None or not asset.path:
        return None
    if asset.resolvedPath:
        return True
    return None if _LATER.search(asset.path) else False


def source_in_file(prim: Usd.Prim, source: Rel) -> Target | None:
    """What the render source of a pass is in the USD file that the pass names."""
    asset = _asset(prim)
    wanted = next(iter(source.targets), None)
    if asset is None or wanted is None or wanted.is_property or wanted.via:
        return None
    extension = Sdf.FileFormat.GetFileExtension(asset.resolvedPath)
    if not asset.resolvedPath or f".{extension.lower()}" not in _USD:
        return None
    return _look(asset.resolvedPath, wanted.path, wanted.site)


def _look(file: str, path: str, site: Site) -> Target:
    unknown = Target(path, State.UNKNOWN, site, because=file)
    layer = open_layer(file)
    if not isinstance(layer, Sdf.Layer):
        return unknown
    try:
        stage = Usd.Stage.OpenMasked(layer, Usd.StagePopulationMask([path]))
    except Tf.ErrorException:
        return unknown
    prim = stage.GetPrimAtPath(path)
    if not prim:
        return unknown if stage.GetCompositionErrors() else Target(path, State.MISSING, site)
    return Target(path, state_of(prim), site, str(prim.GetTypeName()), kinds_of(prim))


def _asset(prim: Usd.Prim) -> Sdf.AssetPath | None:
    attribute = prim.GetAttribute("fileName")
    value = attribute.Get() if attribute else None
    return value if isinstance(value, Sdf.AssetPath) else None
