"""Which renderers have left traces in a stage?"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import suppress

from pxr import Tf, Usd

from ..model import Evidence
from ..stage import Opened, in_scopes


def read_evidence(opened: Opened, render_prims: Iterable[Usd.Prim]) -> Evidence:
    """Traces on render prims, in the scopes and in the root layer's own data; nothing else is opened."""
    namespaces: Counter[str] = Counter()
    schemas: Counter[str] = Counter()
    product_types: Counter[str] = Counter()
    camera_types: Counter[str] = Counter()
    for prim in render_prims:
        camera_types.update(_camera_types(opened.stage, prim))
        for name in prim.GetAuthoredPropertyNames():
            head, colon, _ = name.partition(":")
            if colon:
                namespaces[head] += 1
        listed = prim.GetPrimTypeInfo().GetAppliedAPISchemas()
        schemas.update(schema.partition(":")[0] for schema in listed)
        product_type = prim.GetAttribute("productType")
        if product_type and product_type.IsAuthored():
            product_types[str(product_type.Get() or "")] += 1
    names = {prim.GetName() for prim in in_scopes(opened)}
    return Evidence(
        tuple(sorted(namespaces.items())),
        tuple(sorted(schemas.items())),
        tuple(sorted(product_types.items())),
        tuple(sorted(camera_types.items())),
        tuple(sorted(names)),
        tuple(sorted(opened.stage.GetRootLayer().customLayerData)),
    )


def _camera_types(stage: Usd.Stage, prim: Usd.Prim) -> Iterator[str]:
    relationship = prim.GetRelationship("camera")
    if not relationship or not relationship.IsAuthored():
        return
    with suppress(Tf.ErrorException):  # authored as an attribute
        for path in relationship.GetForwardedTargets():
            camera = stage.GetPrimAtPath(path.GetPrimPath())
            # A camera of the host application is never saved: its name is all there is.
            yield str(camera.GetTypeName()) if camera and camera.GetTypeName() else path.name
