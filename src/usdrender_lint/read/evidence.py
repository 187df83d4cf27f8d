"""Which renderers have left traces in a stage?"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import suppress

from pxr import Tf, Usd

from ..model import Evidence
from .prims import Asked, Prims


def read_evidence(stage: Usd.Stage, prims: Prims) -> Evidence:
    """Traces on render prims, in the scopes and in the root layer's own data; nothing else is opened."""
    namespaces: Counter[str] = Counter()
    schemas: Counter[str] = Counter()
    product_types: Counter[str] = Counter()
    camera_types: Counter[str] = Counter()
    for one in prims.rendered:
        for name in one.authored:
            head, colon, _ = name.partition(":")
            if colon:
                namespaces[head] += 1
        for schema in one.schema.applied:
            schemas[schema.partition(":")[0]] += 1
        if "camera" in one.authored:
            camera_types.update(_camera_types(stage, one))
        if "productType" in one.authored and (said := one.prim.GetAttribute("productType")):
            product_types[str(said.Get() or "")] += 1
    names = {one.path.rpartition("/")[2] for one in prims.in_scopes}
    return Evidence(
        tuple(sorted(namespaces.items())),
        tuple(sorted(schemas.items())),
        tuple(sorted(product_types.items())),
        tuple(sorted(camera_types.items())),
        tuple(sorted(names)),
        tuple(sorted(stage.GetRootLayer().customLayerData)),
    )


def _camera_types(stage: Usd.Stage, asked: Asked) -> Iterator[str]:
    relationship = asked.prim.GetRelationship("camera")
    if not relationship:
        return
    with suppress(Tf.ErrorException):  # authored as an attribute
        for path in relationship.GetForwardedTargets():
            camera = stage.GetPrimAtPath(path.GetPrimPath())
            # A camera of the host application is never saved: its name is all there is.
            yield str(camera.GetTypeName()) if camera and camera.GetTypeName() else path.name
