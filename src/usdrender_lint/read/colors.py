"""What does the name of a color space mean?"""

from __future__ import annotations

from pxr import Gf, Usd

from ..model import Attr, ColorSpace, ValueState

_DATA = ("raw", "data", "unknown", "identity")
"""Their gamma is 1, as that of linear spaces. `Gf.ColorSpace.IsData` is absent in 25.11."""


def read_color_space(prim: Usd.Prim, name: Attr[str]) -> tuple[ColorSpace | None, tuple[str, ...]]:
    """What the name means on a prim; if nothing, the names to choose from."""
    if name.state is not ValueState.AUTHORED:
        return None, ()
    defined = _defined(prim)
    if name.value in defined:
        return defined[name.value], ()
    if Gf.ColorSpace.IsValid(name.value):
        space = Gf.ColorSpace(name.value)
        canonical = str(space.GetName())
        return ColorSpace(canonical, float(space.GetGamma()), canonical in _DATA), ()
    return None, (*sorted(defined), *_built_in())


def _defined(prim: Usd.Prim) -> dict[str, ColorSpace]:
    """Spaces of the ColorSpaceDefinitionAPIs on the prim and above, the nearest first.

    The value of `name` counts, not the name of the API's instance.
    """
    found: dict[str, ColorSpace] = {}
    while prim:
        for definition in Usd.ColorSpaceDefinitionAPI.GetAll(prim):
            name = str(definition.GetNameAttr().Get() or "")
            gamma = float(definition.GetGammaAttr().Get() or 0.0)
            found.setdefault(name, ColorSpace(name, gamma, is_data=False))
        prim = prim.GetParent()
    return found


def _built_in() -> list[str]:
    names = Gf.ColorSpaceNames
    values = {str(getattr(names, n)) for n in dir(names) if not n.startswith("_")}
    return sorted(v for v in values if Gf.ColorSpace.IsValid(v))
