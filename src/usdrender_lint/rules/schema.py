"""Do properties keep to what the schemas and renderers know of them?"""

from __future__ import annotations

from collections.abc import Iterator

from ..model import Described, RenderPrim, RenderScope, Site
from ..rule import Context, Finding, Severity, Sign, rule
from ._words import a_or_an, nearest, one_of

GROUP = "property"

_NEAR_NAMESPACE = 0.8
_SHORT = 3


@rule(
    "unknown-property",
    on=RenderPrim,
    severity=Severity.NOTE,
    since="0.1",
    about=(Sign.ODD_PROPERTY,),
)
def unknown_property(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """A property without namespace is none of the schema's, nor of the renderer's."""
    for found in prim.properties:
        if found.is_schema or found.belongs_to or ":" in found.name or not found.has_value:
            continue
        if found.is_relationship:
            continue  # UsdRender hands on all authored relationships (26.11)
        if found.name in context.renderer.properties or nearest(found.name, prim.built_in):
            continue
        yield Finding(
            Site(f"{prim.path}.{found.name}"),
            f"'{found.name}' is no property of {a_or_an(prim.type_name)}: UsdRender hands only namespaced ones to the renderer",
            label="not handed on",
            help="give it the renderer's namespace, if the renderer is to see it",
        )


@rule(
    "unknown-namespace",
    on=RenderPrim,
    severity=Severity.NOTE,
    since="0.1",
)
def unknown_namespace(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """A namespace is nearly, but not quite, that of a renderer."""
    known = context.renderer.known_namespaces
    told: set[str] = set()
    for found in prim.properties:
        head, colon, _ = found.name.partition(":")
        if not colon or found.is_schema or head in known or head in told:
            continue
        meant = nearest(head, known, _NEAR_NAMESPACE)
        # Of two or three letters most are near another one: only the case may differ.
        if meant and (len(head) > _SHORT or head.lower() == meant.lower()):
            told.add(head)
            yield Finding(
                Site(f"{prim.path}.{found.name}"),
                f"no renderer listens to the namespace '{head}:'",
                label="nobody listens",
                help=f"did you mean '{meant}:'?",
            )


@rule(
    "removed-schema",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    about=(Sign.OTHER_PRIM, Sign.RENDER_PASS),
)
def removed_schema(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Something is used that UsdRender no longer has."""
    for other in scope.others:
        if other.type_name == "RenderDenoisePass":
            yield Finding(
                Site(other.path, "typeName"),
                "RenderDenoisePass is no longer a type of UsdRender: nobody takes it for a pass",
                label="removed from USD",
                help="write the denoiser as a RenderPass of its own passType",
            )
    for one in scope.passes:
        for found in one.properties if one.live else ():
            if found.name in ("denoise:enable", "denoise:pass"):
                yield Finding(
                    Site(f"{one.path}.{found.name}"),
                    f"'{found.name}' is no longer a property of RenderPass: it has no effect",
                    label="removed from USD",
                    help="write the denoiser as a RenderPass of its own, with this one among its inputPasses",
                )


@rule(
    "disallowed-token",
    on=Described,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("collection-mode-portability",),
    by_itself=True,
    about=(Sign.ODD_PROPERTY,),
)
def disallowed_token(prim: Described, context: Context) -> Iterator[Finding]:
    """A token is none that the schema allows."""
    for found in prim.properties:
        # Un-namespaced tokens of UsdRender have rules that know what renderers do with them.
        if not found.refused or (":" not in found.name and isinstance(prim, RenderPrim)):
            continue
        meant = nearest(found.refused[0], found.allowed, 0.6)
        yield Finding(
            Site(f"{prim.path}.{found.name}", "default"),
            f"'{found.name}' is '{found.refused[0]}', not {one_of(found.allowed)}",
            label="not allowed",
            help=f"did you mean '{meant}'?" if meant else "leave it out for the fallback",
        )


@rule(
    "variability-mismatch",
    on=RenderPrim,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
)
def variability_mismatch(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """A uniform attribute is authored as varying, or the reverse."""
    for found in prim.properties:
        if not found.is_schema or found.is_relationship or found.schema_is_relationship:
            continue
        if found.uniform == found.schema_uniform:
            continue
        right = f"{'uniform ' if found.schema_uniform else ''}{found.schema_type} {found.name}"
        yield Finding(
            found,
            f"'{found.name}' is {'uniform' if found.schema_uniform else 'varying'} in the schema, and authored otherwise",
            label="harmless, but tools may animate it" if found.schema_uniform else "",
            help=f"write {right}",
        )


@rule("custom-builtin", on=RenderPrim, severity=Severity.NOTE, since="0.1", default=False)
def custom_builtin(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """A property of the schema is authored as custom."""
    for found in prim.properties:
        if found.is_schema and found.custom:
            yield Finding(
                Site(f"{prim.path}.{found.name}", "custom"),
                f"'{found.name}' is a property of {a_or_an(prim.type_name)}, not a custom one",
                label="built in",
                help="leave out 'custom'",
            )
