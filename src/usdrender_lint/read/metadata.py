"""What does the root layer stack say about the default RenderSettings?"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pxr import Sdf, Usd

from ..likeness import is_like
from ..model import DefaultSettings, MetadataOpinion, Site
from ..unopened import DamagedError
from .targets import Targets

KEY = "renderSettingsPrimPath"
_SIMILAR = 0.8
"""Found by trial: takes in renderSettingsPath, leaves out renderSettings."""


def authored_default(stage: Usd.Stage) -> MetadataOpinion | None:
    """The opinion that USD uses: the session layer's, else the root layer's. No other layer counts."""
    for layer in (stage.GetSessionLayer(), stage.GetRootLayer()):
        if layer is not None and layer.pseudoRoot.HasInfo(KEY):
            return opinion_of(layer, counts=True)
    return None


def default_path(opinion: MetadataOpinion | None) -> str | None:
    """The absolute prim path that an opinion names, if it names one."""
    if opinion is None or not opinion.value or _problem(opinion.value):
        return None
    return opinion.value


def read_default(
    stage: Usd.Stage, opinion: MetadataOpinion | None, path: str | None, targets: Targets
) -> DefaultSettings:
    """`opinion` and `path`: what the two functions above tell."""
    weaker = [
        opinion_of(layer, counts=False)
        for layer in stage.GetLayerStack(includeSessionLayers=False)[1:]
        if layer.pseudoRoot.HasInfo(KEY)
    ]
    target = None
    if path is not None and opinion is not None:
        site = Site("/", KEY, path, opinion.site.layer)
        target = targets.suggested(path, site, "RenderSettings")
    return DefaultSettings(
        opinion,
        tuple(weaker),
        tuple(_misspelled(stage)),
        _problem(opinion.value) if opinion and path is None else None,
        target,
    )


def opinion_of(layer: Sdf.Layer, *, counts: bool) -> MetadataOpinion:
    """What one layer says; `counts`: USD asks it."""
    value = layer.pseudoRoot.GetInfo(KEY)
    return MetadataOpinion(
        KEY, _plain(value), Site("/", KEY, layer=layer.identifier), counts=counts
    )


def _plain(value: Any) -> str:
    # Authored as `</Render/S>` the value comes back as a path (26.11).
    return f"<{value}>" if isinstance(value, Sdf.Path) else str(value)


def _problem(value: str) -> str | None:
    """Why a value is no absolute prim path. An empty one is no value."""
    if not value:
        return None
    if value.startswith("<"):
        return "it stands in angle brackets"
    if value != value.strip():
        return "it begins or ends with white space"
    if value == "/":
        return "it is the root of the stage"
    if value.endswith("/"):
        return "it ends with a slash"
    if not Sdf.Path.IsValidPathString(value):
        return "it is not a valid path"
    path = Sdf.Path(value)
    if not path.IsAbsolutePath():
        return "it is relative"
    if path.ContainsPrimVariantSelection():
        return "it holds a variant selection"
    if not path.IsPrimPath():
        return "it names a property"
    return None


def _misspelled(stage: Usd.Stage) -> Iterator[MetadataOpinion]:
    root = stage.GetRootLayer()
    for where, key, value in _strings_in(root.customLayerData):
        if _looks_like(key, or_equal=True):
            site = Site("/", f"customLayerData:{where}", layer=root.identifier)
            yield MetadataOpinion(key, value, site, in_custom_data=True, counts=False)
    # A layer does not list keys that no plugin registers; the pseudo-root of the stage does.
    try:
        authored = stage.GetPseudoRoot().GetAllAuthoredMetadata()
    except TypeError:  # USD has no such value, nor a sentence for it
        raise DamagedError("its metadata holds a value of a wrong type") from None
    for key in sorted(authored):
        value = authored[key]
        if isinstance(value, Sdf.UnregisteredValue) and _looks_like(key, or_equal=False):
            text = str(value.value).strip('"')
            yield MetadataOpinion(key, text, Site("/", key, layer=root.identifier), counts=False)


def _strings_in(data: dict[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Where each string of a dictionary stands, its key and itself. Dictionaries may stand deep
    within each other: deeper than calls may."""
    waiting = [("", data)]
    while waiting:
        above, one = waiting.pop()
        for key in sorted(one):
            if isinstance(one[key], str):
                yield above + key, key, one[key]
            elif isinstance(one[key], dict):
                waiting.append((f"{above}{key}:", one[key]))


def _looks_like(key: str, *, or_equal: bool) -> bool:
    if key == KEY:
        return or_equal
    return is_like(key, KEY, _SIMILAR)
