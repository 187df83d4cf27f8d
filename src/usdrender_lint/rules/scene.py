"""Does the render spec fit the scene? These rules open the whole stage."""

from __future__ import annotations

from collections.abc import Iterator

from ..model import Scene, Settings, Site
from ..rule import Context, Finding, Severity, rule
from ._purposes import ALL_PURPOSE
from ._words import one_of

GROUP = "scene"


def _rendered(scene: Scene) -> list[Settings]:
    return [s for s in scene.scope.settings if s.live]


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


@rule(
    "hidden-render-geometry",
    on=Scene,
    severity=Severity.WARNING,
    since="0.1",
    default=False,
    group="purpose",
    supersedes=("render-purpose-omitted",),
)
def hidden_render_geometry(scene: Scene, context: Context) -> Iterator[Finding]:
    """The scene has geometry for final renders, and the settings leave it out."""
    use = next((u for u in scene.purposes if u.purpose == "render"), None)
    for settings in _rendered(scene) if use else ():
        if use is None or "render" in settings.included_purposes.value:
            continue
        yield Finding(
            settings.included_purposes,
            f"includedPurposes of <{settings.path}> leaves out {_count(use.count, 'gprim')} of purpose 'render'",
            label="no 'render'",
            help="add 'render'",
            related=((use.first, "is of purpose 'render'"),),
        )


@rule(
    "unshaded-by-purpose",
    on=Scene,
    severity=Severity.WARNING,
    since="0.1",
    default=False,
    group="purpose",
)
def unshaded_by_purpose(scene: Scene, context: Context) -> Iterator[Finding]:
    """Geometry has materials, but none for the purposes that the settings ask for."""
    for settings in _rendered(scene):
        asked = {"" if p in ALL_PURPOSE else p for p in settings.material_binding_purposes.value}
        # A binding for all purposes is what every renderer falls back on.
        missed = [u for u in scene.bindings if "" not in u.purposes and not u.purposes & asked]
        if not missed:
            continue
        count = sum(u.count for u in missed)
        bound = sorted({p for u in missed for p in u.purposes})
        yield Finding(
            settings.material_binding_purposes,
            f"{_count(count, 'gprim')} will be unshaded: materials are bound for {one_of(bound)} only,"
            f" and <{settings.path}> asks for {one_of(sorted(asked - {''})) or 'none of them'}",
            label="finds no material there",
            help=f"list {one_of(bound)}, or bind materials for all purposes",
            related=((missed[0].first, f"is bound for {one_of(sorted(missed[0].purposes))} only"),),
        )


@rule(
    "unknown-primvar",
    on=Scene,
    severity=Severity.WARNING,
    since="0.1",
    default=False,
    group="var",
)
def unknown_primvar(scene: Scene, context: Context) -> Iterator[Finding]:
    """A var outputs a primvar that nothing in the scene has."""
    for var in scene.scope.vars:
        name = var.source_name.value
        if not var.live or var.source_type.value != "primvar" or not name:
            continue
        if name not in scene.primvars:
            yield Finding(
                var.source_name,
                f"no prim of the scene has a primvar '{name}'",
                label="no such primvar",
                help="correct the name; a procedural that makes it at render time is a reason to ignore this",
            )


@rule(
    "lights-hidden-by-pass",
    on=Scene,
    severity=Severity.WARNING,
    since="0.1",
    group="collection",
)
def lights_hidden_by_pass(scene: Scene, context: Context) -> Iterator[Finding]:
    """A pass shows geometry and none of the scene's lights."""
    for view in scene.passes:
        if view.shows_geometry and not view.shows_lights:
            yield Finding(
                Site(f"{view.path}.collection:renderVisibility:includes"),
                f"renderVisibility of <{view.path}> shows geometry, but none of the scene's lights: the pass renders black",
                label="no lights",
                help="add the lights to the collection; it holds for them as for geometry",
            )


@rule(
    "default-settings-in-reference",
    on=Scene,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
    group="stage",
    supersedes=("default-settings-unset",),
)
def default_settings_in_reference(scene: Scene, context: Context) -> Iterator[Finding]:
    """A referenced layer has default settings, which stay behind."""
    default = scene.scope.default
    if default.opinion is not None and default.opinion.value:
        return
    for opinion in scene.referenced_defaults:
        yield Finding(
            opinion,
            f"renderSettingsPrimPath = '{opinion.value}' of a referenced layer is not read: the stage has no default render settings",
            label="stays behind",
            help="bring the render prims in by a sublayer, and write the path into the root layer",
        )
