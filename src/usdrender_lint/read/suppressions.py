"""What does the metadata of a layer's specs say to this program?"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pxr import Sdf, Usd, Vt

from ..crate import mentions
from ..records import dataclass
from ..usda import UsdaText

KEY = "usdrenderLint"


@dataclass(frozen=True, slots=True)
class Authored:
    """One entry of the dictionary `usdrenderLint` of a spec."""

    layer: str
    """Its identifier."""
    spec: str
    reaches: str
    """The composed prim or property that it is about; "/" for the layer."""
    field: str
    key: str
    """Empty: there is something else than a dictionary."""
    names: tuple[str, ...] | None
    """None: no list of strings."""


def authored_in(layer: Sdf.Layer, text: UsdaText | None) -> Iterator[Authored]:
    """Everything in one layer, in its own namespace."""
    word = KEY.encode()
    if not text.mentions(word) if text else mentions(layer.realPath, [word]) is False:
        return
    yield from authored_on_layer(layer)
    found: list[Sdf.Spec] = []

    def visit(path: Sdf.Path) -> None:
        if path.IsPrimPath() or path.IsPrimVariantSelectionPath() or path.IsPropertyPath():
            spec = layer.GetObjectAtPath(path)
            if spec and spec.HasInfo("customData"):
                found.append(spec)

    layer.Traverse(Sdf.Path.absoluteRootPath, visit)
    for spec in found:
        yield from _on_spec(spec, str(spec.path.StripAllVariantSelections()))


def authored_on_layer(layer: Sdf.Layer) -> Iterator[Authored]:
    if layer.pseudoRoot.HasInfo("customLayerData"):
        yield from _entries(layer, "/", "/", "customLayerData", layer.customLayerData)


def authored_above(stage: Usd.Stage, path: str) -> Iterator[Authored]:
    """Opinions of all layers on a prim or property, and on the prims above it."""
    above = Sdf.Path(path)
    if above.IsPropertyPath():
        prop = stage.GetPropertyAtPath(above)
        if prop and prop.HasCustomDataKey(KEY):
            for spec in prop.GetPropertyStack(Usd.TimeCode.Default()):
                yield from _on_spec(spec, str(above))
        above = above.GetPrimPath()
    while above.IsPrimPath():
        prim = stage.GetPrimAtPath(above)
        if prim and prim.HasCustomDataKey(KEY):
            for spec in prim.GetPrimStack():
                yield from _on_spec(spec, str(above))
        above = above.GetParentPath()


def is_composed(stage: Usd.Stage, spec: str) -> bool:
    """Whether the variants in the path of a spec of the root layer are those that are selected."""
    for path in Sdf.Path(spec).GetPrefixes():
        if path.IsPrimVariantSelectionPath():
            name, variant = path.GetVariantSelection()
            prim = stage.GetPrimAtPath(path.StripAllVariantSelections())
            if not prim or prim.GetVariantSet(name).GetVariantSelection() != variant:
                return False
    return True


def _on_spec(spec: Sdf.Spec, reaches: str) -> Iterator[Authored]:
    if spec.HasInfo("customData"):
        data = spec.customData
        yield from _entries(spec.layer, str(spec.path), reaches, "customData", data)


def _entries(
    layer: Sdf.Layer, spec: str, reaches: str, field: str, data: Any
) -> Iterator[Authored]:
    said = dict(data).get(KEY)
    if said is None:
        return
    field = f"{field}:{KEY}"
    if not isinstance(said, dict):
        yield Authored(layer.identifier, spec, reaches, field, "", None)
        return
    for key in sorted(said):
        at = f"{field}:{key}"
        yield Authored(layer.identifier, spec, reaches, at, key, _names(said[key]))


def _names(value: Any) -> tuple[str, ...] | None:
    if isinstance(value, str):
        return (value,)
    # Python's own list, as scripts set it, can be in no file but on a stage in memory.
    if isinstance(value, Vt.StringArray | Vt.TokenArray | list):
        return tuple(str(name) for name in value)
    return None
