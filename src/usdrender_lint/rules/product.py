"""Will each product be written, once, in the form it asks for?"""

from __future__ import annotations

import posixpath
from collections.abc import Iterator

from ..model import Product, Settings, Site, ValueState, Var
from ..rule import Context, Finding, Severity, rule
from ._chains import dead_ends
from ._names import DRIVER_ATTRIBUTES, extension_of
from ._words import nearest, one_of, paths

GROUP = "product"

SCHEMA_TYPES = ("raster", "deepRaster")


@rule("product-without-vars", on=Product, severity=Severity.ERROR, since="0.1")
def product_without_vars(product: Product, context: Context) -> Iterator[Finding]:
    """A product lists no vars."""
    if product.ordered_vars.named:
        return
    said = "lists no vars" if product.ordered_vars.authored else "has no orderedVars"
    yield Finding(
        Site(f"{product.path}.orderedVars"),
        f"<{product.path}> {said}: renderers write nothing for it",
        label="no channels",
        help="list at least one RenderVar: rel orderedVars = </Render/Vars/color>",
        related=dead_ends(product.ordered_vars),
    )


@rule(
    "empty-product-name",
    on=Product,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("blocked-value",),
)
def empty_product_name(product: Product, context: Context) -> Iterator[Finding]:
    """A product has no name, so there is no file to write."""
    name = product.product_name
    if product.first_name or product.maybe_more:
        return
    said = {
        ValueState.AUTHORED: "is empty",
        ValueState.BLOCKED: "is blocked",
        ValueState.SAMPLED: "is empty",
    }.get(name.state, "is not set")
    yield Finding(
        name,
        f"productName of <{product.path}> {said}: {context.renderer.unnamed_product or 'there is no file to write'}",
        label="no name",
        help=f'name the file: token productName = "{product.name}.exr"',
    )


@rule(
    "duplicate-product-name",
    on=Settings,
    severity=Severity.ERROR,
    since="0.1",
    about=("productName",),
)
def duplicate_product_name(settings: Settings, context: Context) -> Iterator[Finding]:
    """Two products of one render write the same file."""
    products = list(
        {o.product.path: o.product for o in settings.outputs if o.product.live}.values()
    )
    if _are_different(products):
        return
    written = [_files(p, context) for p in products]
    told: set[str] = set()
    for fold in (False, True):
        for product, earlier, name in _collisions(products, written, fold):
            if product.path in told:
                continue
            told.add(product.path)
            where = " where upper and lower case are one" if fold else ""
            yield Finding(
                product.product_name,
                f"'{name}' is written by <{earlier.path}> too{where}: one file overwrites the other",
                label="same file",
                help="give each product of a render a name of its own",
                related=((earlier.product_name, "writes it first"),),
                severity=Severity.WARNING if fold else None,
            )

    for product, earlier in _same_default(products, context):
        if product.path not in told:
            yield Finding(
                product.product_name,
                f"'{product.product_name.value}' is the default name of <{earlier.path}> too:"
                " what reads names without a time writes one file over the other",
                label="same default",
                help="give each product of a render a name of its own, or leave the samples alone",
                related=((earlier.product_name, "has it first"),),
                severity=Severity.WARNING,
            )


def _are_different(products: list[Product]) -> bool:
    """Mostly one look at the names is enough."""
    if any(p.product_name.samples for p in products):
        return False
    names = [p.product_name.value for p in products]
    return len({_normal(name, fold=True) for name in names}) == len(names)


def _same_default(products: list[Product], context: Context) -> Iterator[tuple[Product, Product]]:
    """Where samples tell names apart that are one at the default time."""
    first: dict[str, Product] = {}
    for product in products:
        name = product.product_name.value
        if name and name not in context.renderer.special_product_names:
            earlier = first.setdefault(_normal(name, fold=False), product)
            if earlier is not product:
                yield product, earlier


def _files(product: Product, context: Context) -> dict[float | None, str]:
    """File names by time, held from one sample to the next as tokens are; None is any time."""
    varying: dict[float | None, str] = dict(product.product_name.samples)
    names = varying or {None: product.product_name.value}
    special = context.renderer.special_product_names
    return {time: name for time, name in names.items() if name and name not in special}


def _collisions(
    products: list[Product], written: list[dict[float | None, str]], fold: bool
) -> Iterator[tuple[Product, Product, str]]:
    """Each product that writes, at some time, a file that an earlier one writes at that time."""
    times = sorted({time for names in written for time in names if time is not None})
    at_any_time: dict[str, Product] = {}
    at: dict[tuple[float, str], Product] = {}
    ever: dict[str, Product] = {}
    for product, names in zip(products, written, strict=True):
        found: tuple[Product, str] | None = None
        if None in names:
            key = _normal(names[None], fold)
            if earlier := at_any_time.get(key) or ever.get(key):
                found = earlier, names[None]
            at_any_time.setdefault(key, product)
        else:
            for time, name in _held(names, times):
                key = _normal(name, fold)
                if earlier := at.get((time, key)) or at_any_time.get(key):
                    found = found or (earlier, name)
                at.setdefault((time, key), product)
                ever.setdefault(key, product)
        if found:
            yield product, *found


def _held(names: dict[float | None, str], times: list[float]) -> Iterator[tuple[float, str]]:
    """The name at every time of any product; before the first sample the first holds."""
    name = next(iter(names.values()), None)
    for time in times:
        name = names.get(time, name)
        if name is not None:
            yield time, name


def _normal(name: str, fold: bool) -> str:
    path = posixpath.normpath(name.replace("\\", "/"))
    return path.casefold() if fold else path


@rule(
    "unknown-product-type",
    on=Product,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("husk-nonraster-aovs",),
)
def unknown_product_type(product: Product, context: Context) -> Iterator[Finding]:
    """No renderer at hand writes products of this type."""
    kind = product.product_type
    if kind.spoiled or kind.value in SCHEMA_TYPES or ":" in kind.value:
        return
    known = (*SCHEMA_TYPES, *sorted(context.renderer.product_types))
    if kind.value in known:
        return
    meant = nearest(kind.value, known, 0.7) or _by_prefix(kind.value)
    yield Finding(
        kind,
        f"productType '{kind.value}' is not {one_of(known)}",
        label="no such product type",
        help=f"did you mean '{meant}'?" if meant else "leave it out for a raster image",
    )


def _by_prefix(value: str) -> str | None:
    return "deepRaster" if value.lower().startswith("deep") else None


@rule(
    "deep-needs-exr",
    on=Product,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("too-many-vars-for-format", "unsupported-extension"),
    about=("productName",),
)
def deep_needs_exr(product: Product, context: Context) -> Iterator[Finding]:
    """A deep product's name has an extension that holds no deep data."""
    name, kind = product.first_name, product.product_type.value
    if not name or not (kind == "deepRaster" or kind in context.renderer.deep_types):
        return
    if any(product.has(attribute) for attribute in DRIVER_ATTRIBUTES):
        return
    extension = extension_of(name)
    if context.renderer.title not in context.renderer.exact_extension_case:
        extension = extension.lower()
    if extension in {".exr", *context.renderer.deep_extensions}:
        return
    is_dtex = extension.lower() == ".dtex"
    if is_dtex:
        found = "by the name '.dtex' RenderMan writes"
    else:
        found = f"'{extension}' files hold" if extension else "a name without extension gets"
    yield Finding(
        product.product_name,
        f"{found} no deep data: <{product.path}> is '{product.product_type.value}' but will be written flat",
        label="not .exr",
        help='name the driver, too: token ri:productType = "deepshad"'
        if is_dtex
        else "write an .exr, or make it productType 'raster'",
        severity=Severity.WARNING if is_dtex else None,
        related=((product.product_type, "makes it deep"),) if product.product_type.authored else (),
    )


_SINGLE_IMAGE = frozenset({".jpeg", ".jpg", ".png"})
_PERHAPS_LAYERED = frozenset({".tif", ".tiff"})
"""What a writer makes of several images in a TIFF is its own affair."""
_ALPHA = ("a", "A", "alpha")


@rule(
    "too-many-vars-for-format",
    on=Settings,
    severity=Severity.WARNING,
    since="0.1",
    about=("productName",),
)
def too_many_vars_for_format(settings: Settings, context: Context) -> Iterator[Finding]:
    """A product lists more vars than a file of its format holds."""
    for output in settings.outputs:
        product, extension = output.product, extension_of(output.product.first_name).lower()
        if extension not in _SINGLE_IMAGE and extension not in _PERHAPS_LAYERED:
            continue
        shown = [v for v in output.vars if v.live]
        if extension in context.renderer.multi_channel_extensions or _is_one_image(shown):
            continue
        if not product.live or any(product.has(name) for name in DRIVER_ATTRIBUTES):
            continue
        lost = extension in _SINGLE_IMAGE and len(shown) > 2
        yield Finding(
            product.product_name,
            f"a {extension} file holds one image, and <{product.path}> lists {len(shown)} vars: "
            f"{paths(v.path for v in shown)}",
            label="room for one image",
            help="write an .exr, or one product for each var",
            related=((product.ordered_vars, "the vars"),),
            severity=Severity.ERROR if lost else None,
        )


def _is_one_image(shown: list[Var]) -> bool:
    """One var, or a color and its alpha."""
    if len(shown) < 2:
        return True
    alpha = [v for v in shown if v.source_name.value in _ALPHA]
    return len(shown) == 2 and len(alpha) == 1
