"""Does each var hold the numbers that its source gives, in a form that renderers write?"""

from __future__ import annotations

import re
from collections.abc import Iterator

from ..model import RenderScope, ValueState, Var
from ..rule import Context, Finding, Renderer, Severity, Sign, rule
from ._handful import handful
from ._types import Pixel, pixel
from ._used import live, used
from ._words import nearest

GROUP = "var"

_MEANT_TYPES = {
    "color": "color3f",
    "colour": "color3f",
    "rgb": "color3f",
    "rgba": "color4f",
    "vector": "vector3f",
    "vector3": "vector3f",
    "normal": "normal3f",
    "point": "point3f",
    "integer": "int",
    "scalar": "float",
    "float1": "float",
    "vec2": "float2",
    "vec3": "float3",
    "vec4": "float4",
}
_VALUE_TYPES = (
    "color3f", "color4f", "color3h", "color4h", "float", "float2", "float3", "float4", "half",
    "half3", "half4", "double", "int", "int2", "int3", "vector3f", "normal3f", "point3f", "uint",
)  # fmt: skip


@rule(
    "unknown-data-type",
    on=Var,
    severity=Severity.ERROR,
    since="0.1",
    by_itself=True,
    about=(Sign.UNKNOWN_DATA_TYPE,),
)
def unknown_data_type(var: Var, context: Context) -> Iterator[Finding]:
    """`dataType` names no value type of USD."""
    kind = var.data_type
    if kind.spoiled or var.data_type_known:
        return
    if kind.value in context.renderer.data_types:
        return
    meant = _MEANT_TYPES.get(kind.value.lower()) or nearest(kind.value, _VALUE_TYPES, 0.7)
    yield Finding(
        kind,
        f"dataType '{kind.value}' is no type of USD: renderers refuse the var, or write a color",
        label="no such type",
        help=f"did you mean '{meant}'?" if meant else "such as color3f, color4f, float or int",
    )


@rule(
    "unsupported-data-type",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("data-type-mismatch",),
)
def unsupported_data_type(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """`dataType` is a type of USD that no image holds, or none of the renderer's."""
    found = (f for var in live(scope, context) if (f := _unsupported(var, context.renderer)))
    yield from handful(found, "vars")


def _unsupported(var: Var, renderer: Renderer) -> Finding | None:
    name = var.data_type.value
    if name in renderer.unsupported_data_types and not _format(var):
        said = f"{renderer.title} does not take dataType '{name}': it refuses the var, or writes something else"
    elif var.data_type_known and pixel(name) is None and name not in renderer.data_types:
        said = f"dataType '{name}' is no pixel: renderers refuse the var, or write a color"
    else:
        return None
    return Finding(
        var.data_type,
        said,
        label="no type of a pixel",
        help="such as color3f, color4f, float, int or normal3f",
    )


_SCALARS = frozenset(
    {
        *("a", "A", "alpha", "z", "Z", "depth", "cameraDepth", "zback", "ray:hitPz"),
        *("id", "ID", "primId", "instanceId", "elementId", "cpuTime", "sampleCount"),
    }
)
"""Sources that hold one number, whatever the renderer."""

_SEVERAL = {
    **dict.fromkeys(("Ci", "RGBA", "color", "LdrColor", "HdrColor"), ("a color", "color3f")),
    **dict.fromkeys(("N", "normal", "Neye", "__Nworld"), ("a vector", "normal3f")),
    **dict.fromkeys(("P", "__Pworld"), ("a point", "point3f")),
}
"""Sources that hold more than one number: what they are, and the type for it."""

_FORMATS = ("arnold:format", "driver:parameters:aov:format")
"""Attributes that some renderers read instead of `dataType`, strongest first."""


def _format(var: Var) -> Pixel | None:
    """What the renderer's own attribute says, if it says anything."""
    found = (pixel(a.value) for f in _FORMATS if (a := var.extra_attr(f)))
    return next((f for f in found if f), None)


@rule(
    "data-type-mismatch",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("low-precision-data",),
    about=("sourceName",),
)
def data_type_mismatch(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """`dataType` does not fit what the source gives."""
    found = (
        finding
        for var in used(scope, context)
        if not (var.maybe_more and not var.data_type.authored)
        and (held := pixel(var.data_type.value))
        and (finding := _mismatch(var, held))
    )
    yield from handful(found, "vars")


def _mismatch(var: Var, held: Pixel) -> Finding | None:
    name, kind = var.source_name.value, var.data_type
    if kind.state is ValueState.MISTYPED:
        return None  # what the line says may well fit: it is only written as another type
    said = (
        f"dataType '{kind.value}'" if kind.authored else f"the fallback '{kind.value}' of dataType"
    )
    written = _format(var) or held
    if (
        var.source_type.value == "raw"
        and name in _SCALARS
        and min(held.components, written.components) > 1
    ):
        exact = "int" if name.lower().endswith("id") else "float"
        return Finding(
            kind,
            f"{said} holds {held.components} numbers, but '{name}' is one",
            label=f"{held.components} numbers",
            help=f'write uniform token dataType = "{exact}"',
            related=((var.source_name, "is one number"),),
        )
    if (
        var.source_type.value == "raw"
        and name in _SEVERAL
        and max(held.components, written.components) == 1
    ):
        what, exact = _SEVERAL[name]
        return Finding(
            kind,
            f"{said} holds one number, but '{name}' is {what}",
            label="one number",
            help=f'write uniform token dataType = "{exact}"',
            related=((var.source_name, f"is {what}"),),
        )
    if var.source_type.value == "lpe" and name and max(held.components, written.components) == 1:
        return Finding(
            kind,
            f"{said} holds one number, but a light path expression gives a color",
            label="one number",
            help='write uniform token dataType = "color3f"',
            related=((var.source_type, "makes it an expression"),),
        )
    return None


@rule(
    "nonstandard-data-type",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
    about=(Sign.UNKNOWN_DATA_TYPE,),
)
def nonstandard_data_type(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """`dataType` is a name that some renderers know and USD does not."""
    found = (
        Finding(
            var.data_type,
            f"dataType '{var.data_type.value}' is no type of USD: some renderers know it, others take a color",
            label="not a type of USD",
            help="write a type of USD, if other renderers read this: half for float16, color3f for colors",
        )
        for var in used(scope, context)
        if not var.data_type_known and var.data_type.value in context.renderer.data_types
    )
    yield from handful(found, "vars")


_EXACT = frozenset({*_SCALARS, "P", "__Pworld", "__Pref", "Pref", "ray:hitP"}) - {
    *("a", "A", "alpha", "cpuTime", "sampleCount"),
}


@rule(
    "low-precision-data",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
    supersedes=("nonstandard-data-type",),
    about=("dataType",),
)
def low_precision_data(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Depth, positions or ids are written with 16 bits."""
    found = (
        Finding(
            var.data_type,
            f"dataType '{var.data_type.value}' has 16 bits for '{var.source_name.value}': whole numbers are exact only to 2048",
            label="16 bits",
            help="use the type with 32 bits, such as float or point3f",
        )
        for var in used(scope, context)
        if (held := pixel(var.data_type.value))
        and held.half
        and var.source_type.value == "raw"
        and _needs_precision(var.source_name.value)
    )
    yield from handful(found, "vars")


def _needs_precision(source: str) -> bool:
    # Cryptomatte's ranks hold hashes: every bit counts.
    return source in _EXACT or re.fullmatch(r"crypto\w*\d\d", source.lower()) is not None


@rule(
    "aov-format-mismatch",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
)
def aov_format_mismatch(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """The renderer's own format attribute disagrees with `dataType`."""
    found = (
        finding
        for var in used(scope, context)
        for name in _FORMATS
        if (finding := _format_mismatch(var, name))
    )
    yield from handful(found, "vars")


def _format_mismatch(var: Var, name: str) -> Finding | None:
    attr = var.extra_attr(name)
    if attr is None or not (written := pixel(attr.value)):
        return None
    held = pixel(var.data_type.value)
    if not held or (written.components, written.whole) == (held.components, held.whole):
        return None
    return Finding(
        attr,
        f"'{name}' is '{attr.value}' and dataType '{var.data_type.value}': husk and Arnold take the one, others the other",
        label=f"not {var.data_type.value}",
        help="make them agree in the number of components",
        related=((var.data_type, "is what other renderers read"),),
    )
