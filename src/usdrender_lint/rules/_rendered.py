"""What does a render scope render, and with which values?"""

from __future__ import annotations

from collections.abc import Iterator

from ..model import (
    Output,
    RenderScope,
    Settings,
    SettingsBase,
    Site,
    ValueState,
    View,
)

Size = tuple[int, int]
Window = tuple[float, float, float, float]


def named_settings(scope: RenderScope) -> set[str]:
    """The live settings that the default or a pass names."""
    targets = [t for p in scope.passes if p.live for t in p.render_source.targets]
    if scope.default.target is not None:
        targets.append(scope.default.target)
    return {t.path for t in targets if t.live and "RenderSettings" in t.isa}


def live(scope: RenderScope) -> Iterator[SettingsBase]:
    yield from (s for s in scope.settings if s.live)
    yield from (p for p in scope.products if p.live)


def outputs_of(scope: RenderScope) -> Iterator[tuple[Settings, Output]]:
    """What is rendered, and with which settings."""
    for settings in scope.settings:
        if settings.live:
            yield from ((settings, o) for o in settings.outputs if o.product.live)


def views_of(settings: Settings) -> list[View]:
    """What is rendered with it: without products a renderer makes its default image."""
    outputs: list[View] = [o for o in settings.outputs if o.product.live]
    return outputs or [settings]


def windows_of(scope: RenderScope) -> Iterator[tuple[SettingsBase, list[Size]]]:
    """Prims with a data window of their own, and the sizes of the images that it is for."""
    sizes: dict[Site, dict[Size, None]] = {}
    for _, output in outputs_of(scope):
        sizes.setdefault(output.data_window_ndc.site, {})[output.resolution.value] = None
    for prim in live(scope):
        own = prim.data_window_ndc
        if own.state is ValueState.AUTHORED:
            yield prim, list(sizes.get(own.site, ())) or [prim.resolution.value]
