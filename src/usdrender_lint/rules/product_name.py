"""Does each product's name lead to one file a frame, wherever it is rendered?"""

from __future__ import annotations

import re
from collections.abc import Iterator

from ..lazily import lazily
from ..model import FrameRange, Product, RenderScope
from ..rule import Context, Finding, Renderer, Severity, Sign, once, rule
from ._handful import handful
from ._names import (
    DRIVER_ATTRIBUTES,
    extension_of,
    frame_number,
    frame_token,
    has_placeholder,
    is_file,
    is_movie,
    is_plain,
    quoted,
    without_expanded,
    without_tokens,
)
from ._used import listed, lost_its_list
from ._words import joined

GROUP = "product"


def _rendered(scope: RenderScope) -> Iterator[Product]:
    """Live products that live settings list, for only these are ever written; where a list was lost,
    or other layers hold the settings, all."""
    lists = [(s, s.products) for s in scope.settings if s.live]
    products = (p for p in scope.products if p.live)
    if not scope.settings or any(lost_its_list(prim, rel) for prim, rel in lists):
        return products
    named = listed(rel for _, rel in lists)
    return (p for p in products if p.path in named)


@once
def _files(scope: RenderScope, context: Context) -> tuple[tuple[Product, str], ...]:
    """With their names."""
    named = ((p, p.first_name) for p in _rendered(scope))
    return tuple((p, name) for p, name in named if is_file(name, context.renderer))


@rule(
    "static-product-name",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("frame-token-in-product-name", "name-only-time-sampled"),
    about=("productName",),
)
def static_product_name(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """All frames of a sequence get the same file name."""
    if scope.frames.several:
        found = (
            _static(product, name, scope.frames, context.renderer)
            for product, name in _files(scope, context)
            if _is_static(product, name, context.renderer)
        )
        yield from handful(found, "products")


def _is_static(product: Product, name: str, renderer: Renderer) -> bool:
    samples = product.product_name.samples
    # A single sample is how Houdini writes one frame of many.
    if len(samples) == 1 or len({value for _, value in samples}) > 1 or is_movie(name):
        return False
    # Where it is one of several, a name may hold what another program replaces.
    if renderer.frame_tokens and not renderer.is_any:
        return not any(
            re.search(p, name) for p in (*renderer.frame_tokens, *renderer.name_variables)
        )
    return not has_placeholder(name)


def _static(product: Product, name: str, frames: FrameRange, renderer: Renderer) -> Finding:
    said = ""
    if token := frame_token(without_expanded(name, renderer)):
        said = f", for {renderer.title} does not replace '{token}'"
    elif number := frame_number(name):
        said = f", though '{number}' looks like the number of one"
    expands = any(re.fullmatch(p, "$F4") for p in renderer.frame_tokens)
    token = "put $F4 into the name, or " if expands else ""
    return Finding(
        product.product_name,
        f"{quoted(name)} is the name for all frames from {frames.start:g} to {frames.end:g}{said}: each overwrites the last",
        label="the same for every frame",
        help=f"{token}give every frame a name in productName.timeSamples",
        related=((frames, "the stage's frames"),),
    )


@rule(
    "unsupported-extension",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    about=("productName",),
)
def unsupported_extension(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A product's name has no extension, or one that no renderer writes."""
    found = (
        _unsupported(product, name, context.renderer)
        for product, name in _files(scope, context)
        if _is_plain_image(product, context.renderer)
        and not _is_written(name, context.renderer)
        and (name.endswith("/") or not has_placeholder(extension_of(name) or name))
    )
    yield from handful(found, "products")


def _is_written(name: str, renderer: Renderer) -> bool:
    # That a blank follows it is a fault of the name.
    extension = extension_of(name).strip()
    if renderer.exact_extension_case and extension != extension.lower():
        return False
    known = extension.lower()
    return known in renderer.extensions and known not in renderer.unsupported_extensions


def _is_plain_image(product: Product, renderer: Renderer) -> bool:
    kind = product.product_type.value
    special = ":" in kind or kind in renderer.product_types
    return not special and not any(product.has(name) for name in DRIVER_ATTRIBUTES)


def _unsupported(product: Product, name: str, renderer: Renderer) -> Finding:
    extension = extension_of(name)
    known = sorted(renderer.extensions - renderer.unsupported_extensions - {""})
    severity = None
    if name.endswith("/"):
        said = f"{quoted(name)} is a folder, and names no file in it"
        help_, label = f"write the file's name, too: {name}{product.name}.exr", "a folder"
    elif not extension:
        said = f"{quoted(name)} has no extension, which tells renderers the format: some write OpenEXR, some refuse"
        help_, label = f"add one, such as {name.rstrip('.')}.exr", "no extension"
    elif extension.lower() in known:
        plain = extension.lower()
        who = joined(sorted(renderer.exact_extension_case))
        said = (
            f"'{extension}' is not '{plain}' to {who}: it warns, and writes OpenEXR under that name"
        )
        help_, label = f"write {name.removesuffix(extension)}{plain}", "upper case"
        # Then the file is what its name says, or nobody said that it is for that renderer.
        if plain == ".exr" or who != renderer.title:
            severity = Severity.NOTE
    else:
        said = f"'{extension}' is a format that renderers do not write: they put OpenEXR under that name, or refuse"
        help_, label = f"known are {', '.join(known)}", "no such format"
    return Finding(product.product_name, said, label=label, help=help_, severity=severity)


@rule(
    "frame-token-in-product-name",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
    about=("productName",),
)
def frame_token_in_product_name(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A product's name holds a frame token, which USD does not replace."""
    found = (
        Finding(
            product.product_name,
            f"'{token}' in {quoted(name)} is replaced by some programs only: elsewhere a file of just that name is written",
            label="a frame token",
            help="give every frame its name in productName.timeSamples, if other programs render this too",
        )
        for product, name in _files(scope, context)
        if not is_plain(name) and (token := frame_token(without_expanded(name, context.renderer)))
    )
    yield from handful(found, "products")


@rule(
    "name-only-time-sampled",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
    about=(Sign.SAMPLED_NAME,),
)
def name_only_time_sampled(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A product's name has time samples and no default."""
    found = (
        Finding(
            product.product_name,
            f"productName of <{product.path}> has time samples and no default: "
            "what reads it without a time finds no name",
            label="no default",
            help=f'add token productName = "{name}"',
        )
        for product, name in _files(scope, context)
        if not product.product_name.value
    )
    yield from handful(found, "products")


_VARIABLE = lazily(
    r"""
      [$]\{\w+\} | [$][A-Za-z_]\w* | %[A-Za-z_]\w*%             # shells
    | <(?:Scene|RenderLayer|RenderPass\w*|Camera|Extension)>     # Maya, which alone replaces them
    """,
    re.VERBOSE,
)
_DRIVE = lazily(r"[A-Za-z]:")


@rule(
    "nonportable-product-name",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("frame-token-in-product-name", "relative-product-name"),
    about=("productName",),
)
def nonportable_product_name(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A product's name holds what only a shell or one platform understands."""
    found = (
        finding
        for product, name in _files(scope, context)
        if (finding := _nonportable(product, name, context.renderer))
    )
    yield from handful(found, "products")


def _nonportable(product: Product, name: str, renderer: Renderer) -> Finding | None:
    if is_plain(name):
        return None
    faults = dict(_faults(without_tokens(name, renderer)))
    if faults:
        return Finding(
            product.product_name,
            f"{quoted(name)} {joined(list(faults.values()))}: nothing resolves or expands a productName",
            label=next(iter(faults)),
            help="write the plain path, with '/', as it is to be on disk",
        )
    if _DRIVE.match(name):
        return Finding(
            product.product_name,
            f"{quoted(name)} begins with a drive letter, which only Windows has",
            label="a drive letter",
            help="use a path that all machines of the farm have, if some do not run Windows",
            severity=Severity.NOTE,
        )
    return None


def _faults(name: str) -> Iterator[tuple[str, str]]:
    """In a word, and as a part of a sentence."""
    if any(ord(c) < 32 for c in name):
        # "C:\renders" in usda holds a carriage return.
        yield "control characters", "holds control characters, as a backslash in usda makes them"
    elif re.match(_DRIVE.pattern + r"[^/\\]", name):
        yield (
            "no slash",
            "has no slash after the drive letter, as single backslashes in usda are dropped",
        )
    elif "\\" in name:
        yield "backslashes", "holds backslashes"
    if name != name.strip():
        yield "a blank at an end", "begins or ends with a blank"
    if name.lstrip().startswith("~"):
        yield "a shell's '~'", "begins with '~'"
    if variable := _VARIABLE.search(name):
        yield "a variable", f"holds the variable '{variable[0]}'"
    if odd := sorted({c for c in name if c in "*?\"'|`"}):
        yield "characters of a shell", f"holds {joined(odd)}, which shells read"


@rule(
    "relative-product-name",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
    about=("productName",),
)
def relative_product_name(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A product's name is relative to wherever the render is started."""
    found = (
        Finding(
            product.product_name,
            f"{quoted(name)} is relative to the folder in which the render is started, not to this layer",
            label="relative",
            help="write an absolute path",
        )
        for product, name in _files(scope, context)
        if not name.startswith(("/", "\\", "$", "{", "<", "`")) and not re.match(r"\w+:", name)
    )
    yield from handful(found, "products")
