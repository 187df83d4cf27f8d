"""Does what must not vary stay still?"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..model import Attr, Pass, RenderPrim, Site, ValueState
from ..rule import Context, Finding, Severity, Sign, rule
from ._words import spelt

GROUP = "animation"


@rule(
    "animated-uniform",
    on=RenderPrim,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("empty-source-name",),
    about=(Sign.VARYING,),
)
def animated_uniform(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """An attribute that has one value for all frames is animated."""
    for attr, name in _uniform(prim):
        if attr.varying is None:
            continue
        samples = "a spline" if attr.varying == "spline" else "time samples"
        if attr.state is ValueState.SAMPLED:
            spelt_out = f"{samples} and no default: OpenUSD's render spec reads the fallback"
        else:
            spelt_out = (
                f"{samples} beside its default: OpenUSD's render spec reads only the default"
            )
        yield Finding(
            Site(attr.site.path, attr.varying),
            f"{name} of <{prim.path}> has {spelt_out}, {spelt(attr.value)}",
            label="must not vary",
            help="write one value for all frames",
        )


def _uniform(prim: RenderPrim) -> Iterator[tuple[Attr[Any], str]]:
    for attr in prim.attrs():
        if attr.name != "productName":  # the one that is meant to vary
            yield attr, attr.name
    if isinstance(prim, Pass):
        for one in prim.collections:
            for member in (one.mode, one.expansion_rule, one.include_root, one.expression):
                yield member, member.name
