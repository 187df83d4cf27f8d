"""Does what is wrong with a stage concern one of its layers?"""

from __future__ import annotations

import os
from collections.abc import Collection

from pxr import Sdf, Usd

from .results import Located
from .rule import Severity


class Concerns:
    """Tells the findings that a change of some layers may have brought about.

    A finding concerns a layer if

    - it stands there, or something that belongs to it does;
    - the layer says something about the same prim, or about its target: a camera of the wrong type;
    - something is missing that the layer may have held. When a camera is renamed, the broken target
      stands in the render layer, and no layer tells any more where the camera was; when a product
      is, an `over` is left of it. So a target or a prim that is not there, not defined or inactive
      concerns every layer that says something about a prim above it. And an error about what is not
      there, be it a target's prim or a value, concerns every layer of the stage: a layer that lost
      its last prim says nothing at all, and such a stage does not render.

    Errors in which a layer has no part, such as a bad value that another layer writes, wait for
    those who change that layer.
    """

    def __init__(self, stage: Usd.Stage, files: Collection[str]) -> None:
        self._stage = stage
        self._files = files
        used = stage.GetUsedLayers()
        self._layers = {one for one in used if os.path.realpath(one.realPath) in files}

    def __contains__(self, finding: Located) -> bool:
        places = (finding.location, *(place.location for place in finding.related))
        if any(os.path.realpath(place.file) in self._files for place in places):
            return True
        paths = (*self._to(finding.prim_path), *self._to(finding.target))
        if any(map(self._speaks_of, paths)):
            return True
        return finding.severity is Severity.ERROR and self._is_missing(finding)

    def _to(self, text: str | None) -> list[str]:
        """The prim at a path; if it is not live, with those above it."""
        path = _prim_path(text)
        if path is None:
            return []
        prim = self._stage.GetPrimAtPath(path)
        is_live = prim and prim.IsActive() and prim.IsDefined()
        return [str(path)] if is_live else [*map(str, path.GetPrefixes())]

    def _speaks_of(self, path: str) -> bool:
        prim = self._stage.GetPrimAtPath(path)
        if prim:
            return any(spec.layer in self._layers for spec in prim.GetPrimStack())
        # Below an inactive prim, and outside the mask, nothing is composed.
        return any(layer.GetPrimAtPath(path) for layer in self._layers)

    def _is_missing(self, finding: Located) -> bool:
        if target := _prim_path(finding.target):
            return not self._stage.GetPrimAtPath(target)
        if finding.property is None:
            return False
        found = self._stage.GetPropertyAtPath(f"{finding.prim_path}.{finding.property}")
        return not found or not found.IsAuthored()


def _prim_path(target: str | None) -> Sdf.Path | None:
    """None where the target is no path, but an asset or a word."""
    if target is None or not target.startswith("/") or not Sdf.Path.IsValidPathString(target):
        return None
    path = Sdf.Path(target).GetPrimPath()
    return None if path == Sdf.Path.absoluteRootPath else path
