"""What does one renderer in particular not do with a spec that is right by the schema?"""

from __future__ import annotations

from collections.abc import Iterator

from ..model import INCLUDE_AOVS, Attr, HasSite, Output, Product, RenderScope, Var
from ..rule import Context, Finding, Renderer, Severity, rule
from ._handful import handful
from ._types import pixel
from ._views import overrides

GROUP = "renderer"


@rule(
    "arnold-single-view",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    renderers=("arnold",),
    supersedes=("per-product-view",),
)
def arnold_single_view(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A product has a view of its own, and Arnold has one for all."""
    found = {
        at.site: _own_view(output.product, what, at)
        for settings in scope.settings
        for output in settings.outputs
        if settings.live and output.product.live
        for what, at in overrides(settings, output)
    }
    yield from handful(found.values(), "products")


_INSTEAD = {
    "camera": "only its Hydra delegate renders through it, kick takes the settings' camera",
    "resolution": "Arnold has one for all products, that of the settings or of the last product",
}


def _own_view(product: Product, what: str, at: HasSite) -> Finding:
    return Finding(
        at,
        f"<{product.path}> has its own {what}: {_INSTEAD.get(what, 'Arnold takes that of the settings')}",
        label=f"its own {what}",
        help="give this view settings of its own, and render them one after the other",
        # An own camera works in one of Arnold's two ways.
        severity=Severity.NOTE if what == "camera" else None,
    )


@rule(
    "arnold-deep-product",
    on=Product,
    severity=Severity.WARNING,
    since="0.1",
    renderers=("arnold",),
)
def arnold_deep_product(product: Product, context: Context) -> Iterator[Finding]:
    """A product is `deepRaster`, which Arnold calls `deep`."""
    if product.product_type.value == "deepRaster" and not product.has("arnold:driver"):
        yield Finding(
            product.product_type,
            f"Arnold does not know 'deepRaster': <{product.path}> will be written flat",
            label="not Arnold's word",
            help='write uniform token productType = "deep"',
        )


@rule(
    "omniverse-semantic-compression",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    renderers=("omniverse",),
)
def omniverse_semantic_compression(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A semantic var is not compressed as SimReady asks."""
    found = (
        Finding(
            attr or var.source_name,
            f"'{name}' is not compressed with blosc: SimReady asks that of semantic vars, for video codecs change the labels",
            label=f"'{attr.value}'" if attr else "no compression",
            help='author uniform token srtx:compression:type = "blosc"',
        )
        for var in scope.vars
        # Kit writes the source as a token, and reads it.
        if var.live
        and (name := var.source_name.value or var.source_name.unread).startswith("semantic")
        and ((attr := var.extra_attr("srtx:compression:type")) is None or attr.value != "blosc")
    )
    yield from handful(found, "vars")


_AOV_NAME = "driver:parameters:aov:name"
_AOV_FORMAT = "driver:parameters:aov:format"


def _outputs(scope: RenderScope) -> Iterator[Output]:
    return (o for s in scope.settings if s.live for o in s.outputs if o.product.live)


def _rendered(scope: RenderScope) -> list[Var]:
    """Live vars of live products of live settings, each once."""
    found = {v.path: v for o in _outputs(scope) for v in o.vars if v.live}
    return list(found.values())


@rule(
    "karma-incomplete-var",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    renderers=("karma",),
)
def karma_incomplete_var(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A var has not the attributes without which husk stops or Karma leaves it out."""
    found = (f for var in _rendered(scope) if (f := _incomplete(var, context.renderer)))
    yield from handful(found, "vars")


def _incomplete(var: Var, renderer: Renderer) -> Finding | None:
    given = [a for n in renderer.aov_name_attributes if (a := var.extra_attr(n)) and a.value]
    if not given:
        return Finding(
            var.extra_attr(_AOV_NAME) or var,
            f"<{var.path}> has no {_AOV_NAME}: husk stops the whole render",
            label="no AOV name",
            help=f'author custom string {_AOV_NAME} = "{var.name}"',
        )
    wrong = next((a for a in given if a.authored_type != "string"), None)
    if wrong is not None:
        return Finding(
            wrong,
            f"{wrong.name} of <{var.path}> is of type {wrong.authored_type}, not string: Karma leaves the AOV out",
            label=f"a {wrong.authored_type}",
            help=f'author custom string {wrong.name} = "{wrong.value}"',
        )
    format_ = var.extra_attr(_AOV_FORMAT)
    if format_ is None or not format_.value:
        known = _husk_knows(var.data_type.value, renderer)
        return Finding(
            format_ or var,
            f"<{var.path}> has no {_AOV_FORMAT}: Karma leaves the AOV out",
            label="no AOV format",
            help=f'author custom token {_AOV_FORMAT} = "{var.data_type.value if known else "color3f"}"',
        )
    if format_.authored_type != "token":
        return Finding(
            format_,
            f"{_AOV_FORMAT} of <{var.path}> is of type {format_.authored_type}, not token: Karma leaves the AOV out",
            label=f"a {format_.authored_type}",
            help=f'author custom token {_AOV_FORMAT} = "{format_.value}"',
        )
    return None


@rule(
    "karma-data-type",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    renderers=("karma",),
    supersedes=("unknown-data-type", "unsupported-data-type"),
)
def karma_data_type(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A type of pixel is none that husk can write."""
    found = (
        Finding(
            attr,
            f"husk does not know '{attr.value}' in {attr.name}, and stops the whole render",
            label="unknown to husk",
            help=_husk_type(attr.value, context.renderer),
        )
        for var in _rendered(scope)
        for attr in _types(var)
        if not _husk_knows(attr.value, context.renderer)
    )
    yield from handful(found, "types of vars")


def _types(var: Var) -> Iterator[Attr[str]]:
    yield var.data_type
    format_ = var.extra_attr(_AOV_FORMAT)
    if format_ is not None and format_.value and format_.authored_type == "token":
        yield format_


def _husk_knows(name: str, renderer: Renderer) -> bool:
    known = name in renderer.data_types or pixel(name) is not None
    return known and name not in renderer.unsupported_data_types


def _husk_type(name: str, renderer: Renderer) -> str:
    single = name.replace("double", "float") if "double" in name else name.removesuffix("d") + "f"
    if pixel(single) and _husk_knows(single, renderer):
        return f"write '{single}'"
    return "such as float, color3f, color4h or int"


_OTHER_RENDERERS = frozenset(
    {
        *("Ci", "Oi", "a", "alpha", "z", "depth", "id", "primId", "instanceId", "elementId"),
        *("RGBA", "rgba", "A", "Z", "ID", "color", "beauty", "Neye", "__depth", "__Nworld"),
        *("__Pworld", "LdrColor", "HdrColor"),
    }
)
"""Names by which other renderers, or Hydra, know their own quantities."""


@rule(
    "karma-raw-source",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    renderers=("karma",),
)
def karma_raw_source(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A raw source has the name of another renderer, where Karma looks for a VEX export."""
    found = (
        Finding(
            var.source_name,
            f"Karma takes '{var.source_name.value}' for a VEX export, 'vex:{var.source_name.value}': "
            "unless a shader writes it, the AOV stays empty",
            label="another renderer's name",
            help="use Karma's own source, such as ray:hitPz or ray:hitN, or the expression C.* with sourceType 'lpe'",
        )
        for var in _rendered(scope)
        if var.source_type.value == "raw" and var.source_name.value in _OTHER_RENDERERS
    )
    yield from handful(found, "vars")


@rule(
    "husk-nonraster-aovs",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    renderers=("karma",),
)
def husk_nonraster_aovs(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A product that is not raster does not ask husk for its AOVs."""
    found = {
        o.product.path: o.product
        for o in _outputs(scope)
        if o.product.product_type.value != "raster" and not _includes_aovs(o.product)
    }
    for product in found.values():
        yield Finding(
            product.product_type,
            f"<{product.path}> is '{product.product_type.value}' without includeAovs: husk leaves its AOVs out",
            label="not raster",
            help="author custom bool includeAovs = 1 on the product",
        )


def _includes_aovs(product: Product) -> bool:
    attr = product.extra_attr(INCLUDE_AOVS)
    return attr is not None and attr.value not in ("false", "0", "")
