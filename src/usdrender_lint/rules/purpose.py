"""Which geometry and which materials will the render see?"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from ..model import Settings, ValueState
from ..rule import Context, Finding, Severity, rule
from ._purposes import ALL_PURPOSE
from ._words import joined, nearest, one_of, spelt

GROUP = "purpose"

_MEANT_FOR_ALL = {"all", "default"}

PURPOSES = ("default", "render", "proxy", "guide")
_MEANT_PURPOSES = {"geometry": "default", "full": "render", "final": "render", "": "default"}
MATERIAL_PURPOSES = ("full", "preview")


@rule(
    "unknown-purpose",
    on=Settings,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("default-purpose-omitted", "render-purpose-omitted"),
    by_itself=True,
    about=("includedPurposes",),
)
def unknown_purpose(settings: Settings, context: Context) -> Iterator[Finding]:
    """`includedPurposes` holds a word that is no purpose."""
    wrong = [p for p in settings.included_purposes.value if p not in PURPOSES]
    if not wrong:
        return
    meant = [m for p in wrong if (m := _MEANT_PURPOSES.get(p) or nearest(p, PURPOSES, 0.7))]
    yield Finding(
        settings.included_purposes,
        f"{one_of(wrong).replace(' or ', ' and ')} in includedPurposes {'is no purpose' if len(wrong) == 1 else 'are no purposes'}"
        ": no prim has it",
        label="matches nothing",
        help=f"did you mean {one_of(dict.fromkeys(meant))}?"
        if meant
        else f"purposes are {one_of(PURPOSES)}",
    )


@rule(
    "repeated-purpose",
    on=Settings,
    severity=Severity.NOTE,
    since="0.1",
    about=("includedPurposes", "materialBindingPurposes"),
)
def repeated_purpose(settings: Settings, context: Context) -> Iterator[Finding]:
    """A list of purposes holds one of them twice."""
    for attr in (settings.included_purposes, settings.material_binding_purposes):
        counts = Counter(attr.value)
        twice = [p for p, count in counts.items() if count > 1]
        if twice:
            yield Finding(
                attr,
                f"{attr.name} holds {joined([spelt(p) for p in twice])} more than once: was another purpose meant?",
                label="twice the same",
                help="leave one, or write the purpose that is missing",
            )


@rule(
    "proxy-with-render",
    on=Settings,
    severity=Severity.WARNING,
    since="0.1",
    about=("includedPurposes",),
)
def proxy_with_render(settings: Settings, context: Context) -> Iterator[Finding]:
    """Both the stand-ins and the real geometry are rendered."""
    purposes = settings.included_purposes.value
    if "proxy" in purposes and "render" in purposes:
        yield Finding(
            settings.included_purposes,
            "includedPurposes holds both 'proxy' and 'render': where a prim has both, both are drawn, one in the other",
            label="stand-ins and real geometry",
            help="leave 'proxy' to previews",
        )


@rule(
    "unknown-material-purpose",
    on=Settings,
    severity=Severity.WARNING,
    since="0.1",
    by_itself=True,
    about=("materialBindingPurposes",),
)
def unknown_material_purpose(settings: Settings, context: Context) -> Iterator[Finding]:
    """`materialBindingPurposes` holds a word that is not one of the schema's."""
    known = (*MATERIAL_PURPOSES, *ALL_PURPOSE)
    wrong = [p for p in settings.material_binding_purposes.value if p not in known]
    if not wrong:
        return
    meant = [m for p in wrong if (m := nearest(p, MATERIAL_PURPOSES, 0.7))]
    yield Finding(
        settings.material_binding_purposes,
        f"{one_of(wrong).replace(' or ', ' and ')} in materialBindingPurposes:"
        " only bindings made for it are found, and renderers know 'full' and 'preview'",
        label="not 'full', 'preview' or ''",
        help=f"did you mean {one_of(dict.fromkeys(meant))}?"
        if meant
        else "'full' is for final renders",
    )


@rule(
    "many-material-purposes",
    on=Settings,
    severity=Severity.NOTE,
    since="0.1",
    supersedes=("no-all-purpose-fallback",),
    about=("materialBindingPurposes",),
)
def many_material_purposes(settings: Settings, context: Context) -> Iterator[Finding]:
    """More than one material purpose is listed, where most renders want one."""
    attr = settings.material_binding_purposes
    special = dict.fromkeys(p for p in attr.value if p in MATERIAL_PURPOSES)
    if attr.state is ValueState.AUTHORED and len(special) > 1:
        yield Finding(
            attr,
            f"materialBindingPurposes lists {one_of(special).replace(' or ', ' and ')}:"
            " most renders want one, with '' to fall back on",
            label="more than one",
            help=f"write ['{next(iter(special))}', ''], if one is enough",
        )


@rule(
    "empty-purposes",
    on=Settings,
    severity=Severity.WARNING,
    since="0.1",
    about=("includedPurposes",),
)
def empty_purposes(settings: Settings, context: Context) -> Iterator[Finding]:
    """`includedPurposes` is an empty list."""
    attr = settings.included_purposes
    if attr.state is ValueState.AUTHORED and not attr.value:
        yield Finding(
            attr,
            f"includedPurposes of <{settings.path}> is empty: a renderer that goes by it draws no geometry",
            label="no purposes",
            help='write ["default", "render"], or leave it out, which means the same',
        )


@rule(
    "default-purpose-omitted",
    on=Settings,
    severity=Severity.NOTE,
    since="0.1",
    about=("includedPurposes",),
)
def default_purpose_omitted(settings: Settings, context: Context) -> Iterator[Finding]:
    """`includedPurposes` does not list 'default'."""
    attr = settings.included_purposes
    if attr.state is ValueState.AUTHORED and attr.value and "default" not in attr.value:
        yield Finding(
            attr,
            f"includedPurposes is {spelt(attr.value)}, without 'default': a renderer that takes the list"
            " by the letter drops all geometry that has no purpose of its own",
            label="no 'default'",
            help="list 'default' too",
        )


@rule(
    "render-purpose-omitted",
    on=Settings,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
    about=("includedPurposes",),
)
def render_purpose_omitted(settings: Settings, context: Context) -> Iterator[Finding]:
    """`includedPurposes` lists neither 'render' nor 'proxy'."""
    attr = settings.included_purposes
    if attr.state is ValueState.AUTHORED and attr.value and not {"render", "proxy"} & {*attr.value}:
        yield Finding(
            attr,
            f"includedPurposes is {spelt(attr.value)}: assets that have geometry for 'render' and 'proxy'"
            " will not be in the picture",
            label="no 'render'",
            help="list 'render' for final frames",
        )


@rule(
    "guide-in-render", on=Settings, severity=Severity.NOTE, since="0.1", about=("includedPurposes",)
)
def guide_in_render(settings: Settings, context: Context) -> Iterator[Finding]:
    """Guides will be in the picture."""
    attr = settings.included_purposes
    if attr.state is ValueState.AUTHORED and "guide" in attr.value:
        yield Finding(
            attr,
            "includedPurposes holds 'guide': rig controls and other helpers will be in the picture",
            label="guides are rendered",
            help="leave 'guide' to viewports",
        )


@rule(
    "empty-material-purposes",
    on=Settings,
    severity=Severity.WARNING,
    since="0.1",
    about=("materialBindingPurposes",),
)
def empty_material_purposes(settings: Settings, context: Context) -> Iterator[Finding]:
    """`materialBindingPurposes` is an empty list."""
    attr = settings.material_binding_purposes
    if attr.state is ValueState.AUTHORED and not attr.value:
        yield Finding(
            attr,
            f"materialBindingPurposes of <{settings.path}> is empty: a renderer that goes by it finds no materials",
            label="no purposes",
            help='write ["full", ""], or leave it out, which means the same',
        )


@rule(
    "material-purpose-order",
    on=Settings,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("houdini-all-purpose", "many-material-purposes", "repeated-purpose"),
    about=("materialBindingPurposes",),
)
def material_purpose_order(settings: Settings, context: Context) -> Iterator[Finding]:
    """Bindings for all purposes are looked up before those for a special one."""
    attr = settings.material_binding_purposes
    if attr.state is not ValueState.AUTHORED or "" not in attr.value:
        return
    hidden = [p for p in attr.value[attr.value.index("") + 1 :] if p not in ALL_PURPOSE]
    if hidden:
        kept = (*(p for p in dict.fromkeys(attr.value) if p not in ALL_PURPOSE), "")
        yield Finding(
            attr,
            f"materialBindingPurposes lists '' before {one_of(hidden).replace(' or ', ' and ')}:"
            " a binding for all purposes is taken first, and the special one never",
            label="'' comes first",
            help=f"let '' be the last: {spelt(kept)}",
        )


@rule(
    "houdini-all-purpose",
    on=Settings,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
    about=("materialBindingPurposes",),
)
def houdini_all_purpose(settings: Settings, context: Context) -> Iterator[Finding]:
    """`materialBindingPurposes` holds the token's name, 'allPurpose', where its value is ''."""
    attr = settings.material_binding_purposes
    if attr.state is ValueState.AUTHORED and "allPurpose" in attr.value:
        meant = (*(p for p in dict.fromkeys(attr.value) if p not in ALL_PURPOSE), "")
        yield Finding(
            attr,
            "'allPurpose' in materialBindingPurposes names a purpose that no binding has:"
            " the token of that name is the empty string",
            label="not ''",
            help=f"write {spelt(meant)}",
        )


@rule(
    "no-all-purpose-fallback",
    on=Settings,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
    about=("materialBindingPurposes",),
)
def no_all_purpose_fallback(settings: Settings, context: Context) -> Iterator[Finding]:
    """`materialBindingPurposes` does not fall back on bindings for all purposes."""
    attr = settings.material_binding_purposes
    named = set(attr.value)
    if _MEANT_FOR_ALL & named:
        return  # a word that nobody knows, and that stands for the fallback
    if attr.state is ValueState.AUTHORED and named and not named & set(ALL_PURPOSE):
        yield Finding(
            attr,
            f"materialBindingPurposes is {spelt(attr.value)}, without '' to fall back on:"
            " some renderers then find no material where only one for all purposes is bound",
            label="no fallback",
            help=f"write {spelt((*attr.value, ''))}",
        )
