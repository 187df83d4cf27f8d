"""How does a composed stage become the model? The only package that knows UsdRender."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, TypeVar

from pxr import Sdf, Usd

from ..model import (
    EXPECTED,
    RENDER_TYPES,
    Attr,
    DefaultSettings,
    FrameRange,
    OtherPrim,
    Output,
    Pass,
    Product,
    Rel,
    RenderPrim,
    RenderScope,
    ScopePrim,
    Settings,
    Site,
    State,
    Stray,
    TypeOpinion,
    Var,
    VariantChoice,
)
from ..stage import Opened, is_render_prim, widen_to_targets
from .arcs import Failures
from .cameras import read_cameras
from .collections import read_collections
from .colors import read_color_space
from .evidence import read_evidence
from .external import file_found, source_in_file
from .members import widen_to_members
from .metadata import authored_default, default_path, read_default
from .parts import Definitions, Part, read_part
from .prims import Asked, state_of, type_is_known
from .properties import read_properties
from .strays import stray_paths
from .targets import Targets
from .text import Texts
from .values import (
    plain_asset,
    plain_floats,
    plain_ints,
    plain_text,
    plain_tokens,
    read_attr,
    read_extras,
)

T = TypeVar("T")


def read(opened: Opened, texts: Texts) -> RenderScope:
    """The render spec of a stage that `open_stage` opened; widens its mask as needed."""
    stage = opened.stage
    strays = stray_paths(opened)
    said = authored_default(stage)
    default = default_path(said)
    widen_to_targets(opened, [*strays, *([default] if default else [])])
    widen_to_members(opened)
    failures = Failures(opened)
    part = read_part(opened, default)
    targets = Targets(opened, failures, texts, part)
    settings = read_default(stage, said, default, targets)
    return _Reader(opened, failures, targets, texts, part).scope(strays, settings)


class _Reader:
    def __init__(
        self, opened: Opened, failures: Failures, targets: Targets, texts: Texts, part: Part
    ) -> None:
        self._opened = opened
        self._part = part
        self._stage: Usd.Stage = opened.stage
        self._failures = failures
        self._targets = targets
        self._products: dict[str, Product] = {}
        self._vars: dict[str, Var] = {}
        self._prims = targets.prims

    def scope(self, strays: list[str], default: DefaultSettings) -> RenderScope:
        rendered = self._prims.rendered
        self._vars = {p.path: self._var(p) for p in rendered if "RenderVar" in p.kinds}
        self._products = {p.path: self._product(p) for p in rendered if "RenderProduct" in p.kinds}
        settings = tuple(self._settings(p) for p in rendered if "RenderSettings" in p.kinds)
        needed = _needed(settings)
        passes = tuple(self._pass(p, needed) for p in rendered if "RenderPass" in p.kinds)
        everything: list[RenderPrim] = [
            *settings,
            *self._products.values(),
            *self._vars.values(),
            *passes,
        ]
        outside = sorted({*strays, *(p.path for p in rendered if not self._is_inside(p.path))})
        root, frames = self._stage.GetRootLayer(), _frames(self._stage)
        return RenderScope(
            root.identifier,
            Site("/"),
            tuple(self._scope_prims()),
            settings,
            tuple(self._products.values()),
            tuple(self._vars.values()),
            passes,
            (*self._others(), *self._misspelt(strays)),
            tuple(s for path in outside if (s := self._stray(path))),
            default,
            self._failures.errors(_essential(everything, self._opened.scopes)),
            read_evidence(self._stage, self._prims),
            frames,
            read_cameras(self._stage, frames, settings, self._products.values()),
            tuple(self._missing_variants()),
            tuple(self._topmost(Usd.Prim.IsInstance)),
            tuple(self._topmost(Usd.Prim.HasAuthoredPayloads)),
            self._part.only_overrides,
            self._part.is_part,
            self._part.is_library,
            homes=self._opened.scopes,
        )

    def _is_inside(self, path: str) -> bool:
        return any(path.startswith(scope + "/") for scope in self._opened.scopes)

    def _common(self, asked: Asked, names: tuple[str, ...]) -> dict[str, Any]:
        path = asked.path
        return {
            "path": path,
            "type_name": asked.type_name,
            "state": asked.state,
            "site": Site(path),
            "properties": read_properties(asked),
            "built_in": asked.schema.built_in,
            "extras": read_extras(asked),
            "rels": tuple([self._targets.rel(asked, name) for name in names]),
            "other_types": tuple(_other_types(asked)),
            "collections_applied": asked.schema.collections,
            "maybe_more": self._failures.hiding(path) is not None,
            "prototype": str(asked.prim.GetPrimInPrototype().GetPath()) if asked.is_proxy else "",
        }

    def _base(self, prim: Asked) -> dict[str, Any]:
        return {
            "resolution": read_attr(prim, "resolution", plain_ints, (0, 0)),
            "pixel_aspect_ratio": read_attr(prim, "pixelAspectRatio", float, 0.0),
            "aspect_ratio_conform_policy": read_attr(
                prim, "aspectRatioConformPolicy", plain_text, ""
            ),
            "data_window_ndc": read_attr(prim, "dataWindowNDC", plain_floats, (0.0,) * 4),
            "instantaneous_shutter": read_attr(prim, "instantaneousShutter", bool, False),
            "disable_motion_blur": read_attr(prim, "disableMotionBlur", bool, False),
            "disable_depth_of_field": read_attr(prim, "disableDepthOfField", bool, False),
        }

    def _var(self, prim: Asked) -> Var:
        data_type = read_attr(prim, "dataType", plain_text, "")
        return Var(
            **self._common(prim, ()),
            data_type=data_type,
            data_type_known=bool(Sdf.ValueTypeNames.Find(data_type.value)),
            source_name=read_attr(prim, "sourceName", plain_text, ""),
            source_type=read_attr(prim, "sourceType", plain_text, ""),
        )

    def _product(self, prim: Asked) -> Product:
        common = self._common(prim, ("camera", "orderedVars"))
        camera, ordered_vars = common["rels"]
        return Product(
            **common,
            **self._base(prim),
            camera=camera,
            product_type=read_attr(prim, "productType", plain_text, ""),
            product_name=read_attr(prim, "productName", plain_text, "", with_samples=True),
            ordered_vars=ordered_vars,
        )

    def _settings(self, prim: Asked) -> Settings:
        common = self._common(prim, ("camera", "products"))
        camera, products = common["rels"]
        base = self._base(prim)
        rendering_color_space = read_attr(prim, "renderingColorSpace", plain_text, "")
        color_space, color_space_names = read_color_space(prim.prim, rendering_color_space)
        return Settings(
            **common,
            **base,
            camera=camera,
            products=products,
            included_purposes=read_attr(prim, "includedPurposes", plain_tokens, ()),
            material_binding_purposes=read_attr(prim, "materialBindingPurposes", plain_tokens, ()),
            rendering_color_space=rendering_color_space,
            color_space=color_space,
            color_space_names=color_space_names,
            outputs=tuple(self._outputs(prim.path, camera, products, base)),
        )

    def _outputs(
        self, settings: str, camera: Rel, products: Rel, base: dict[str, Attr[Any]]
    ) -> Iterator[Output]:
        for target in products.targets:
            if product := self._products.get(target.path):
                ordered = (self._vars.get(t.path) for t in product.ordered_vars.targets)
                yield Output(
                    settings=settings,
                    product=product,
                    camera=product.camera if product.camera.targets else camera,
                    vars=tuple(v for v in ordered if v is not None),
                    **{
                        name: _effective(getattr(product, name), inherited)
                        for name, inherited in base.items()
                    },
                )

    def _pass(self, asked: Asked, needed: frozenset[str]) -> Pass:
        prim = asked.prim
        common = self._common(asked, ("renderSource", "inputPasses"))
        render_source, input_passes = common["rels"]
        return Pass(
            **common,
            pass_type=read_attr(asked, "passType", plain_text, ""),
            command=read_attr(asked, "command", plain_tokens, ()),
            file_name=read_attr(asked, "fileName", plain_asset, ""),
            render_source=render_source,
            input_passes=input_passes,
            collections=read_collections(asked, self._targets, needed),
            file_found=file_found(prim),
            source_in_file=source_in_file(prim, render_source),
        )

    def _scope_prims(self) -> Iterator[ScopePrim]:
        """The scopes, and the groups below them that are no render prims themselves."""
        definitions = Definitions(RENDER_TYPES)
        for number, one in enumerate(self._prims.in_scopes):
            if one.is_render_prim:
                continue
            # Mostly the next prim or the one after tells, and spares a walk over specs.
            near = self._prims.in_scopes[number + 1 : number + 3]
            yield ScopePrim(
                one.path,
                one.type_name,
                one.state,
                Site(one.path),
                _state_site(one),
                any(_is_defined_in(below, one) for below in near) or definitions.hold(one.stack),
                self._failures.hiding(one.path),
            )

    def _others(self) -> Iterator[OtherPrim]:
        for one in self._prims.groups:
            if one.path not in self._opened.scopes:
                yield self._other(one)

    def _misspelt(self, strays: list[str]) -> Iterator[OtherPrim]:
        for path in strays:
            prim = self._stage.GetPrimAtPath(path)
            if prim and not is_render_prim(prim) and not type_is_known(prim):
                yield self._other(Asked(prim, path))

    def _other(self, one: Asked) -> OtherPrim:
        return OtherPrim(
            one.path,
            one.type_name,
            one.state,
            one.is_known,
            Site(one.path),
            read_properties(one),
            self._failures.hiding(one.path) is not None,
            _content(one.prim),
        )

    def _topmost(self, wanted: Callable[[Usd.Prim], bool]) -> Iterator[Site]:
        last = Sdf.Path.emptyPath
        for one in self._prims.in_scopes:
            # Depth first: what is below the last one comes before anything else.
            if wanted(one.prim) and (last.isEmpty or not one.at.HasPrefix(last)):
                last = one.at
                yield Site(one.path)

    def _missing_variants(self) -> Iterator[VariantChoice]:
        for one in self._prims.in_scopes:
            selections: dict[str, str] = {}
            for spec in one.stack:
                if spec.HasInfo("variantSelection"):
                    for name, selection in spec.variantSelections.items():
                        selections.setdefault(str(name), str(selection))
            if not selections or one.is_proxy or self._failures.hiding(path := one.path):
                continue
            sets = one.prim.GetVariantSets()
            for name, selection in sorted(selections.items()):
                choices = tuple(sets.GetVariantSet(name).GetVariantNames())
                # An expression: what it comes to. USD evaluates none for a set that is not there.
                if selection.startswith("`") and sets.HasVariantSet(name):
                    selection = sets.GetVariantSelection(name)
                if selection and selection not in choices:
                    site = Site(path, f"variantSelection:{name}")
                    yield VariantChoice(path, name, selection, choices, site)

    def _stray(self, path: str) -> Stray | None:
        prim = self._stage.GetPrimAtPath(path)
        if not prim or not is_render_prim(prim):
            return None  # in a variant that is not selected, or below an inactive prim
        top = Sdf.Path(path).GetPrefixes()[0]
        return Stray(
            path,
            str(prim.GetTypeName()),
            State.ABSTRACT if prim.IsAbstract() else state_of(prim),  # inactive in a class, too
            Site(path, "typeName"),
            Site(str(top)),
        )


def _needed(settings: tuple[Settings, ...]) -> frozenset[str]:
    """What a render cannot do without, should a pass remove it."""
    cameras = (o.camera for s in settings for o in s.outputs)
    rels = [*cameras, *(s.camera for s in settings)]
    found = {t.path for rel in rels for t in rel.targets if t.live}
    return frozenset(found.union(s.path for s in settings))


def _effective(product: Attr[T], settings: Attr[T]) -> Attr[T]:
    """A product's own opinion, even one equal to the fallback; a block inherits."""
    return product if product.authored else settings


def _state_site(one: Asked) -> Site:
    path, state = one.path, one.state
    if state is State.INACTIVE:
        return Site(path, "active")
    for spec in one.stack if state is State.ABSTRACT else ():
        if spec.specifier == Sdf.SpecifierClass:
            return Site(path, "specifier", None, spec.layer.identifier, str(spec.path))
    return Site(path, "specifier")


def _essential(prims: list[RenderPrim], scopes: tuple[str, ...]) -> Iterator[str]:
    """Prims whose loss a render feels: the spec's own, and targets that are not plainly there."""
    yield from scopes
    for prim in prims:
        yield prim.path
        for rel in prim.rels:
            if rel.name in EXPECTED:
                yield from (t.path for t in rel.targets if t.state is not State.LIVE)


def _is_defined_in(prim: Asked, group: Asked) -> bool:
    """A layer that says something of the group defines the render prim below it."""
    return prim.at.HasPrefix(group.at) and any(
        spec.typeName in RENDER_TYPES
        and spec.specifier is Sdf.SpecifierDef
        and spec.layer == above.layer
        and spec.path.HasPrefix(above.path)
        for spec in prim.stack
        for above in group.stack
    )


def _other_types(one: Asked) -> Iterator[TypeOpinion]:
    for spec in one.stack if len(one.stack) > 1 else ():
        name = spec.typeName
        if name in RENDER_TYPES and name != one.type_name:
            site = Site(one.path, "typeName", None, spec.layer.identifier, str(spec.path))
            yield TypeOpinion(name, site)


def _content(prim: Usd.Prim) -> str:
    if prim.IsA("Gprim"):
        return "geometry"
    is_light = prim.IsA("BoundableLightBase") or prim.IsA("NonboundableLightBase")
    return "light" if is_light else ""


def _frames(stage: Usd.Stage) -> FrameRange:
    def authored(key: str) -> float | None:
        return float(stage.GetMetadata(key)) if stage.HasAuthoredMetadata(key) else None

    return FrameRange(
        authored("startTimeCode"),
        authored("endTimeCode"),
        Site("/", "startTimeCode"),
    )
