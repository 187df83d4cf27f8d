"""What does a rule see? The render spec of a stage, as plain frozen values.

`UsdRenderComputeSpec` is not in USD's Python bindings and `pxr` ships no type
information, so `read` converts the composed stage once and everything after it
works on these. No value here holds a live USD object: paths are `str`, arrays
are tuples. They can be compared, sorted, pickled, and outlive their stage.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum
from typing import Generic, Protocol, TypeVar

from .records import dataclass

T = TypeVar("T")

RENDER_TYPES = ("RenderSettings", "RenderProduct", "RenderVar", "RenderPass")

EXPECTED = {
    "camera": "Camera",
    "products": "RenderProduct",
    "orderedVars": "RenderVar",
    "renderSource": "RenderSettings",
    "inputPasses": "RenderPass",
}
"""What each relationship of a render prim is to lead to."""

EXTERNAL_CAMERA = "adskUsd:externalCamera"
"""Maya's default USD render settings have no camera in USD, but the name of one of Maya's own."""
INCLUDE_AOVS = "includeAovs"
"""Of a product: husk writes its AOVs whatever its type."""
EXTRAS = (EXTERNAL_CAMERA, INCLUDE_AOVS)
"""Attributes of no schema that are read of render prims. Settings and products may have hundreds of
others, which nobody judges; of vars, whose channels they name, all are read."""


class State(StrEnum):
    """Whether a renderer meets a prim."""

    LIVE = "live"
    INACTIVE = "inactive"
    OVER = "over"
    """Only `over`s: no layer defines it."""
    ABSTRACT = "abstract"
    """A `class`, or below one."""
    MISSING = "missing"
    UNKNOWN = "unknown"
    """Perhaps behind an asset that did not open."""


_LIVE = State.LIVE
"""Rules ask most of all whether a prim is live, and Python 3.11 is slow to look up a member."""


class ValueState(StrEnum):
    """Where the value that a C++ reader gets at the default time comes from."""

    AUTHORED = "authored"
    FALLBACK = "fallback"
    """No opinion: the schema's fallback."""
    BLOCKED = "blocked"
    """`= None`. Without a fallback: an empty value (tried on 26.11)."""
    SAMPLED = "sampled"
    """Time samples or a spline and no default: the schema's fallback is read."""
    MISTYPED = "mistyped"
    """Authored with a type that the typed read passes over, for a weaker opinion of the right type
    or the fallback."""


@dataclass(frozen=True, slots=True)
class Site:
    """A USD object that a finding is about; `locate` finds its layer and line.

    `path` is a composed Sdf path of a prim or property, or "/" for what a layer
    says about itself. `field` names an Sdf field (`typeName`, `active`,
    `renderSettingsPrimPath`, `references` ...), `target` one entry of a
    relationship's list. With `layer`, that layer's own opinion is meant: it
    stands at the path `spec` in the layer's namespace, as does `target`.
    """

    path: str
    field: str | None = None
    target: str | None = None
    layer: str | None = None
    spec: str | None = None

    @property
    def site(self) -> Site:
        return self

    @property
    def prim_path(self) -> str:
        return self.path.partition(".")[0] or "/"

    @property
    def property_name(self) -> str | None:
        return self.path.partition(".")[2] or None


class HasSite(Protocol):
    """Whatever a finding can stand at."""

    @property
    def site(self) -> Site: ...


@dataclass(frozen=True, slots=True)
class Attr(Generic[T]):
    """A schema attribute as a typed C++ read at the default time sees it."""

    name: str
    value: T
    state: ValueState
    site: Site
    samples: tuple[tuple[float, T], ...] = ()
    """Only filled for `productName` and the attributes of cameras, which are meant to vary."""
    authored_type: str | None = None
    """Type name of the strongest opinion's spec."""
    varying: str | None = None
    """`timeSamples` or `spline`, if the strongest opinion has one, also beside a default."""
    unread: str = ""
    """What an opinion says in a type that the typed read passes over, as text."""

    @property
    def authored(self) -> bool:
        """`HasAuthoredValue()`: blocked counts as not authored."""
        return self.state not in (ValueState.FALLBACK, ValueState.BLOCKED)

    @property
    def spoiled(self) -> bool:
        """Blocked, or of a type that is not read: not what it holds is wrong with it."""
        return self.state in (ValueState.BLOCKED, ValueState.MISTYPED)


@dataclass(frozen=True, slots=True)
class Candidate:
    """A prim that may have been meant."""

    path: str
    type_name: str
    site: Site

    @property
    def name(self) -> str:
        return self.path.rpartition("/")[2]


@dataclass(frozen=True, slots=True)
class Target:
    """What one forwarded target of a relationship leads to."""

    path: str
    state: State
    site: Site
    """The entry in the relationship's list; for a forwarded target the entry that began the chain."""
    type_name: str = ""
    isa: frozenset[str] = frozenset()
    """Which of the render types and `Camera` the prim is or derives from."""
    type_known: bool = True
    """False for a type that no installed schema registers."""
    is_property: bool = False
    via: str = ""
    """The relationship that forwards to it, the last one of a chain."""
    end: Site | None = None
    """Of a forwarded target the entry that ended the chain: where the path itself is written."""
    as_written: str | None = None
    """Text of the layer, for a relative path that leads nowhere."""
    probably_relative: bool = False
    """A missing path below its owner whose remainder exists below the root: in a
    binary layer, where no text tells, it was probably written relative."""
    meant: str | None = None
    """For a relative path that leads nowhere: the same path from the root, if that prim exists."""
    because: str | None = None
    """Why it is not live: the asset that did not open, the inactive ancestor."""
    candidates: tuple[Candidate, ...] = ()
    """Prims of the right type that may have been meant, best first; only for broken targets."""
    only_in: str = ""
    """Of a missing prim: the variant, not selected, that holds it, as `variant 'b' of 'look' on </World>`."""
    perhaps_elsewhere: bool = False
    """Missing in a part of a shot that holds nothing of its kind: the rest may bring it."""

    @property
    def written(self) -> Site:
        """The entry that says this very path, in whatever relationship."""
        return self.end or self.site

    @property
    def live(self) -> bool:
        return self.state is _LIVE

    @property
    def unknown(self) -> bool:
        return self.state is State.UNKNOWN


@dataclass(frozen=True, slots=True)
class Lost:
    """A target that a reference or payload arc drops because it leads outside."""

    path: str
    """As written, in the namespace of the referenced layer."""
    site: Site
    arc_prim: str
    """The composed prim that brings in the layer."""
    arc_field: str
    """`references`, `payload` or `inheritPaths`: what brings it in."""


@dataclass(frozen=True, slots=True)
class Clobbered:
    """A target that a weaker layer lists, and a stronger layer's explicit list drops."""

    path: str
    site: Site
    """In the weaker layer."""


@dataclass(frozen=True, slots=True)
class Rel:
    """A schema relationship after forwarding."""

    name: str
    site: Site
    authored: bool = False
    """Some layer gives a list, even an empty one."""
    targets: tuple[Target, ...] = ()
    lost: tuple[Lost, ...] = ()
    clobbered: tuple[Clobbered, ...] = ()
    written_as_attribute: bool = False
    maybe_more: bool = False
    """An arc on the prim, or a sublayer, did not open: it may bring targets."""
    forwarding: tuple[str, ...] = ()
    """All relationships that it leads through."""
    dead_ends: tuple[Site, ...] = ()
    """Relationships that it forwards to and that name nothing, or lead back; only where there is no
    target."""

    @property
    def named(self) -> bool:
        """Someone named a target, even if composition or a wrong kind of property lost it, or may
        have where nobody could look."""
        return bool(self.targets or self.lost or self.written_as_attribute or self.maybe_more)

    def of_type(self, type_name: str) -> Iterator[Target]:
        """Live targets of that type."""
        return (t for t in self.targets if t.live and type_name in t.isa)


@dataclass(frozen=True, slots=True)
class Property:
    """An authored property, schema or not."""

    name: str
    site: Site
    is_relationship: bool
    type_name: str = ""
    """Of the strongest opinion; empty for relationships."""
    is_schema: bool = False
    """The prim's own definition has a property of this name."""
    schema_type: str = ""
    schema_is_relationship: bool = False
    type_fits: bool = True
    """A typed C++ read accepts the authored type: it equals the schema's, or differs in role only."""
    belongs_to: tuple[str, ...] = ()
    """Render types that have it built in, where the prim's own type does not."""
    custom: bool = False
    has_value: bool = True
    uniform: bool = False
    schema_uniform: bool = False
    refused: tuple[str, ...] = ()
    """Tokens in its value that the schema does not allow."""
    allowed: tuple[str, ...] = ()
    """The tokens that the schema allows, where some are refused."""


@dataclass(frozen=True, slots=True)
class TypeOpinion:
    """A weaker layer's type for a prim, where it differs."""

    type_name: str
    site: Site


@dataclass(frozen=True, slots=True)
class Described:
    """A prim whose properties are held against its schema: a render prim, or a camera in use."""

    path: str
    type_name: str
    """As authored; may be a type that derives from the schema's."""
    site: Site
    properties: tuple[Property, ...]
    """All that some layer authors; of a camera those that its schema does not have, or of another
    type."""
    built_in: tuple[str, ...]
    """Un-namespaced properties of its definition."""


@dataclass(frozen=True, slots=True)
class RenderPrim(Described):
    """What every render prim has. A rule `on=RenderPrim` sees all four types."""

    state: State
    rels: tuple[Rel, ...]
    extras: tuple[Attr[str], ...]
    """Authored attributes that its schema does not have, their values as text, by name: of a var all,
    of other prims those among `EXTRAS`."""
    other_types: tuple[TypeOpinion, ...]
    """Render types that weaker layers give it."""
    maybe_more: bool
    """An arc on it, or a sublayer, did not open: what it lacks may be there."""
    prototype: str
    """Its path in the prototype, if it stands in an instance: all instances share what it says."""
    collections_applied: tuple[str, ...]
    """Names of its collections, built in or by `apiSchemas`."""

    @property
    def name(self) -> str:
        return self.path.rpartition("/")[2]

    @property
    def live(self) -> bool:
        return self.state is _LIVE

    def has(self, name: str) -> bool:
        """Some layer authors a property of that name."""
        return any(p.name == name for p in self.properties)

    def extra_attr(self, name: str) -> Attr[str] | None:
        """An authored attribute that the schema does not have."""
        for attr in self.extras:
            if attr.name == name:
                return attr
        return None

    def attrs(self) -> Iterator[Attr[object]]:
        """Every schema attribute that the model holds, authored or not."""
        for name in self.__match_args__:
            value = getattr(self, name)
            if isinstance(value, Attr):
                yield value


@dataclass(frozen=True, slots=True)
class SettingsBase(RenderPrim):
    """What RenderSettings and RenderProduct share (`RenderSettingsBase`)."""

    camera: Rel
    resolution: Attr[tuple[int, int]]
    pixel_aspect_ratio: Attr[float]
    aspect_ratio_conform_policy: Attr[str]
    data_window_ndc: Attr[tuple[float, float, float, float]]
    instantaneous_shutter: Attr[bool]
    disable_motion_blur: Attr[bool]
    disable_depth_of_field: Attr[bool]


@dataclass(frozen=True, slots=True)
class Var(RenderPrim):
    data_type: Attr[str]
    data_type_known: bool
    """`dataType` is the name of a value type of USD."""
    source_name: Attr[str]
    source_type: Attr[str]


@dataclass(frozen=True, slots=True)
class Product(SettingsBase):
    product_type: Attr[str]
    product_name: Attr[str]
    ordered_vars: Rel

    @property
    def first_name(self) -> str:
        """The name at the default time, else at the first sample: Solaris writes samples only."""
        if self.product_name.value or not self.product_name.samples:
            return self.product_name.value
        return self.product_name.samples[0][1]


@dataclass(frozen=True, slots=True)
class Output:
    """A product as one settings prim renders it (OpenUSD's `pxr/usd/usdRender/spec.cpp`).

    The settings' values unless the product authors its own; time samples without
    a default, or a value of the wrong type, put the *schema's fallback* over the
    settings' value, and a blocked value inherits.
    """

    settings: str
    product: Product
    camera: Rel
    resolution: Attr[tuple[int, int]]
    pixel_aspect_ratio: Attr[float]
    aspect_ratio_conform_policy: Attr[str]
    data_window_ndc: Attr[tuple[float, float, float, float]]
    disable_motion_blur: Attr[bool]
    disable_depth_of_field: Attr[bool]
    instantaneous_shutter: Attr[bool]
    vars: tuple[Var, ...]

    @property
    def site(self) -> Site:
        return self.product.site


@dataclass(frozen=True, slots=True)
class ColorSpace:
    """What the name of a color space stands for, in USD or in a definition of the scene."""

    name: str
    """The canonical one, where an alias is written."""
    gamma: float
    is_data: bool
    """Raw, data, unknown, identity: it says nothing about color."""


@dataclass(frozen=True, slots=True)
class Settings(SettingsBase):
    products: Rel
    included_purposes: Attr[tuple[str, ...]]
    material_binding_purposes: Attr[tuple[str, ...]]
    rendering_color_space: Attr[str]
    color_space: ColorSpace | None
    """What it means; None where neither USD nor the scene knows the name."""
    color_space_names: tuple[str, ...]
    """Those to choose from, only where `color_space` is None."""
    outputs: tuple[Output, ...]


View = Output | Settings | Product
"""Something that is rendered through a camera."""


@dataclass(frozen=True, slots=True)
class Camera(Described):
    """A camera that something is rendered through."""

    projection: Attr[str]
    horizontal_aperture: Attr[float]
    vertical_aperture: Attr[float]
    focal_length: Attr[float]
    clipping_range: Attr[tuple[float, float]]
    f_stop: Attr[float]
    focus_distance: Attr[float]
    shutter_open: Attr[float]
    shutter_close: Attr[float]
    instance: str | None
    """The instance that it stands in: what is there is shared and has no path of its own."""
    views: tuple[View, ...]
    """Outputs of live settings; settings without products; products that no settings list."""

    @property
    def is_perspective(self) -> bool:
        return self.projection.value != "orthographic"

    def over_time(self, *attrs: Attr[T]) -> Iterator[tuple[float | None, tuple[T, ...]]]:
        """The values at each time of the frame range at which one of them is sampled; at None where
        none is."""
        if not any(attr.samples for attr in attrs):
            yield None, tuple(attr.value for attr in attrs)
            return
        sampled = [dict(attr.samples) for attr in attrs]
        times = sorted({time for samples in sampled for time in samples})
        for time in times:
            pairs = zip(sampled, attrs, strict=True)
            yield time, tuple(samples.get(time, attr.value) for samples, attr in pairs)


@dataclass(frozen=True, slots=True)
class Member(Target):
    """A prim that a collection names: by an include, an exclude, or the literal beginning of a pattern."""

    nearest: str = ""
    """Of a missing one: the prim above it that exists."""
    instance: str | None = None
    """The native instance that it is or stands in."""
    invisible: str | None = None
    """The prim whose constant `visibility` hides it: itself or one above."""
    is_group: bool = False
    """There is nothing to be seen of it but what is below it."""


class PredicateState(StrEnum):
    """Whether USD can evaluate a predicate."""

    KNOWN = "known"
    UNKNOWN = "unknown"
    HYDRA = "hydra"
    """Only Hydra's own library has it."""
    BAD_ARGUMENTS = "bad-arguments"
    NO_SUCH_TYPE = "no-such-type"
    """It asks for a type that does not exist and looks like one that does: it matches nothing."""


@dataclass(frozen=True, slots=True)
class Predicate:
    """A condition in the braces of a pattern."""

    name: str
    text: str
    state: PredicateState
    meant: str | None = None


@dataclass(frozen=True, slots=True)
class Pattern:
    """One path pattern of a membership expression, made absolute."""

    text: str
    site: Site
    start: Member
    """What its literal beginning leads to; the root for one that begins with a wildcard."""
    adds: bool
    """It puts prims in; False behind a `-` or a `~`."""
    names_all: bool
    """No wildcard follows the literal beginning."""
    below: bool
    """It ends in `//`: what lies below is meant, too."""
    crashes: bool = False
    """USD does when it evaluates it (26.11)."""
    relative: str | None = None
    """As written, where that is relative to the prim."""
    cut: tuple[str, ...] = ()
    """Groups that it names while nothing below them is a member."""
    names_groups: bool = False
    """By its condition it can name groups only, and no pattern names what is below them."""
    predicates: tuple[Predicate, ...] = ()


class Gives(StrEnum):
    """What one collection gets from another one that it takes in."""

    MEMBERS = "members"
    NO_PRIM = "no-prim"
    NO_COLLECTION = "no-collection"
    WRONG_MODE = "wrong-mode"
    """Includes take nothing from an expression, nor does an expression from includes (26.11)."""
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class OtherCollection:
    """A collection that another one takes in."""

    path: str
    """Of its prim."""
    name: str
    as_written: str
    """`/World.collection:name` in includes, `%/World:name` in an expression."""
    site: Site
    gives: Gives
    applied: tuple[str, ...] = ()
    """Collections that the prim has."""
    has_opinions: bool = False
    """Properties of that name are there, though the collection is not applied."""


@dataclass(frozen=True, slots=True)
class Collection:
    """A collection of a render pass, evaluated by USD."""

    name: str
    site: Site
    mode: Attr[str]
    expansion_rule: Attr[str]
    include_root: Attr[bool]
    includes: Rel
    excludes: Rel
    expression: Attr[str]
    expression_counts: bool
    """USD evaluates the membership expression."""
    problem: str | None
    """Why `CollectionAPI.Validate()` refuses it, in USD's words."""
    patterns: tuple[Pattern, ...] = ()
    """Of the composed expression, whether or not it counts."""
    others: tuple[OtherCollection, ...] = ()
    """Collections that the includes or the expression take in."""
    members: tuple[Member, ...] = ()
    """Prims that the side that counts names, but for excluded ones and other collections."""
    lost: tuple[Lost, ...] = ()
    """Targets and patterns that a reference or payload arc drops because they lead outside."""
    held: frozenset[str] | None = None
    """Of cameras, settings, members of the pass and all prims above these: what USD takes for
    members. None where USD cannot tell."""
    reached: frozenset[str] = frozenset()
    """Of the same prims: those below which there may be members."""

    def holding(self, path: str) -> str | None:
        """The topmost prim at or above a path that was asked about and is a member."""
        names = path.split("/")
        above = ("/".join(names[:n]) for n in range(2, len(names) + 1))
        return next((p for p in above if p in (self.held or ())), None)


@dataclass(frozen=True, slots=True)
class Pass(RenderPrim):
    pass_type: Attr[str]
    command: Attr[tuple[str, ...]]
    file_name: Attr[str]
    """As authored; empty without one."""
    render_source: Rel
    input_passes: Rel
    collections: tuple[Collection, ...]
    file_found: bool | None = None
    """The asset that `fileName` names resolves; None where only its own resolver or a later
    substitution can tell."""
    source_in_file: Target | None = None
    """What the render source is in the USD file that `fileName` names."""

    def collection(self, name: str) -> Collection | None:
        return next((c for c in self.collections if c.name == name), None)


@dataclass(frozen=True, slots=True)
class OtherPrim:
    """A prim in the render scope that is of none of the four types, or one elsewhere whose type is
    nearly one of them."""

    path: str
    type_name: str
    state: State
    type_known: bool
    site: Site
    properties: tuple[Property, ...]
    behind_failed_arc: bool
    """A reference or payload on it or above it did not open: it may be more than it seems."""
    content: str = ""
    """`geometry` or `light`, if it is either."""

    @property
    def name(self) -> str:
        return self.path.rpartition("/")[2]


@dataclass(frozen=True, slots=True)
class Stray:
    """A prim of a render type outside the render scope, in the root layer stack."""

    path: str
    type_name: str
    state: State
    site: Site
    root_site: Site
    """The root prim it stands below."""


@dataclass(frozen=True, slots=True)
class MetadataOpinion:
    """One layer's value for `renderSettingsPrimPath`, or for a key that looks like it."""

    key: str
    value: str
    site: Site
    in_custom_data: bool = False
    counts: bool = True
    """USD asks this layer: the root layer or the session layer."""


@dataclass(frozen=True, slots=True)
class DefaultSettings:
    """What the root layer stack says about the default RenderSettings."""

    opinion: MetadataOpinion | None
    """The one that USD uses."""
    sublayers: tuple[MetadataOpinion, ...]
    misspelled: tuple[MetadataOpinion, ...]
    problem: str | None = None
    """Why the value is no absolute prim path."""
    target: Target | None = None

    @property
    def site(self) -> Site:
        return self.opinion.site if self.opinion else Site("/", "renderSettingsPrimPath")


@dataclass(frozen=True, slots=True)
class ScopePrim:
    """A root prim in which render prims are expected, or a grouping prim below it."""

    path: str
    type_name: str
    state: State
    site: Site
    state_site: Site
    """What makes it so: `active`, or the specifier of the layer that makes it a class."""
    holds_render_prims: bool
    """A render prim stands below it in some layer of the root layer stack or the composed stage."""
    because: str | None = None


@dataclass(frozen=True, slots=True)
class VariantChoice:
    """A variant that a prim of the render scope selects, and no layer has."""

    prim: str
    variant_set: str
    selection: str
    choices: tuple[str, ...]
    site: Site


@dataclass(frozen=True, slots=True)
class ArcError:
    """A composition error: one cause, and how often it was met."""

    kind: str
    """missing-asset, foreign-resolver, foreign-format, missing-prim, cycle ..."""
    arc: str
    """sublayer, reference, payload, inherits ..."""
    asset: str
    """As authored; empty for an internal arc."""
    prim: str
    """Target prim of the arc, when that is what is missing."""
    site: Site
    count: int
    prims: tuple[str, ...]
    """Composed prims where the error was met, sorted, at most a handful."""
    further: tuple[Site, ...]
    """Other opinions that ask for the same, or the other arcs of a cycle."""
    variables: tuple[Site, ...]
    """What the variables are, for an arc that is an expression."""
    said: str
    """What the expression comes to, or why it comes to nothing."""
    unset: tuple[str, ...]
    """Variables of the expression that nobody sets."""
    touches_spec: bool
    """It stands on, above or below a render prim or a render target, or is a sublayer of the root layer stack."""


@dataclass(frozen=True, slots=True)
class Layer:
    """One layer as authored, as far as it can be told without composition."""

    path: str
    site: Site
    problem: str | None
    """What does not parse, in words of USD's format, not of its parser."""
    asked: Site | None = None
    """The arc that brings it in; of a root layer there is none."""


class Extent(StrEnum):
    """For which findings a suppression is meant."""

    LINE = "line"
    NEXT_LINE = "next line"
    LAYER = "layer"
    PRIM = "prim"
    """And what is below it."""
    PROPERTY = "property"


class Flaw(StrEnum):
    """Why a suppression silences nothing, whatever there is to silence."""

    NO_RULE = "no rule"
    UNKNOWN_RULE = "unknown rule"
    GROUP = "group"
    """The name of several rules."""
    UNKNOWN_WORD = "unknown word"
    """Something else than `ignore`."""
    NOT_CLOSED = "not closed"
    NO_LIST = "no list"
    """Metadata of another type."""


@dataclass(frozen=True, slots=True)
class Suppression:
    """What a comment or the metadata of a spec wants silenced: one rule."""

    site: Site
    """Of the comment or the metadata; its target is the rule."""
    extent: Extent
    rule: str = ""
    """As written; also another word that stands in the wrong place."""
    flaw: Flaw | None = None
    in_comment: bool = True
    idle: bool = False
    """The rule ran wherever its layer takes part, and there was nothing to silence."""


@dataclass(frozen=True, slots=True)
class Suppressions:
    """All suppressions of one layer, and the rules there are."""

    path: str
    site: Site
    said: tuple[Suppression, ...]
    rules: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class FrameRange:
    """What the stage says about time."""

    start: float | None
    """`startTimeCode`; None where nobody authors it."""
    end: float | None
    site: Site

    @property
    def several(self) -> bool:
        """More than one frame is to be rendered."""
        return self.start is not None and self.end is not None and self.end > self.start

    def holds(self, time: float) -> bool:
        """Without a range every time may be rendered."""
        return (self.start is None or time >= self.start) and (self.end is None or time <= self.end)


@dataclass(frozen=True, slots=True)
class Evidence:
    """Traces that renderers and host applications leave, each with how often it was met."""

    namespaces: tuple[tuple[str, int], ...] = ()
    """Of properties on render prims."""
    schemas: tuple[tuple[str, int], ...] = ()
    """Applied to render prims."""
    product_types: tuple[tuple[str, int], ...] = ()
    camera_types: tuple[tuple[str, int], ...] = ()
    """Of the prims that are used as cameras; the name of one that has no type here."""
    prim_names: tuple[str, ...] = ()
    """In the scopes."""
    layer_data: tuple[str, ...] = ()
    """Keys of the root layer's customLayerData."""


@dataclass(frozen=True, slots=True)
class RenderScope:
    """All of a stage's render spec at once."""

    root: str
    """Path of the root layer."""
    site: Site
    scopes: tuple[ScopePrim, ...]
    settings: tuple[Settings, ...]
    products: tuple[Product, ...]
    vars: tuple[Var, ...]
    passes: tuple[Pass, ...]
    others: tuple[OtherPrim, ...]
    strays: tuple[Stray, ...]
    default: DefaultSettings
    errors: tuple[ArcError, ...]
    evidence: Evidence
    frames: FrameRange
    cameras: tuple[Camera, ...]
    missing_variants: tuple[VariantChoice, ...]
    instances: tuple[Site, ...]
    """Instances at or below the scopes, the topmost of each branch."""
    payloads: tuple[Site, ...]
    """Prims at or below the scopes that are brought in by a payload."""
    only_overrides: bool
    """No layer defines the scope, nor settings in it: an override layer, a session layer or a mere
    header."""
    is_part: bool
    """No layer defines anything but render prims and their groups: layers that bring the scene, and
    its cameras, are to complete it."""
    is_library: bool
    """A part without settings, that names none: products, vars or passes for those of a shot."""
    homes: tuple[str, ...] = ("/Render",)
    """Where render prims belong in this show."""

    def prims(self) -> Iterator[RenderPrim]:
        yield from self.settings
        yield from self.products
        yield from self.vars
        yield from self.passes


@dataclass(frozen=True, slots=True)
class PurposeUse:
    """How much geometry of the scene has a purpose, inherited or its own."""

    purpose: str
    count: int
    first: Site


@dataclass(frozen=True, slots=True)
class BindingUse:
    """How much geometry has materials bound for exactly these purposes ("" is for all)."""

    purposes: frozenset[str]
    count: int
    first: Site


@dataclass(frozen=True, slots=True)
class PassView:
    """What the renderVisibility of a pass leaves of the scene."""

    path: str
    shows_geometry: bool
    shows_lights: bool


@dataclass(frozen=True, slots=True)
class Scene:
    """The whole stage beside its render spec. A rule `on=Scene` makes the run open all of it."""

    path: str
    site: Site
    scope: RenderScope
    purposes: tuple[PurposeUse, ...]
    bindings: tuple[BindingUse, ...]
    primvars: frozenset[str]
    """Those that vars ask for and some prim has."""
    passes: tuple[PassView, ...]
    """Of live passes with a renderVisibility, in a scene with lights."""
    referenced_defaults: tuple[MetadataOpinion, ...]
    """What layers beyond the root layer stack say of a default, which nobody reads."""
