"""What is a rule? A typed function of one subject, and a few facts about it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import field
from enum import StrEnum
from fnmatch import fnmatchcase
from functools import wraps
from typing import Any, Generic, TypeVar, cast

from .model import HasSite, Scene
from .records import dataclass

S = TypeVar("S")
T = TypeVar("T")


class Severity(StrEnum):
    """What a renderer will do, not how strongly anyone feels."""

    ERROR = "error"
    """A renderer fails, or silently ignores what was written."""
    WARNING = "warning"
    """A likely mistake."""
    NOTE = "note"
    """Practice, portability."""

    @property
    def rank(self) -> int:
        """0 for the worst."""
        return ("error", "warning", "note").index(self)


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong with one USD object.

    `message` says what is seen here, with the values; `label` stands under the
    source line, beside the caret; `help` says what to do. `related` are other
    objects that belong to it, each with a sentence.
    """

    at: HasSite
    message: str
    label: str = ""
    help: str = ""
    related: tuple[tuple[HasSite, str], ...] = ()
    severity: Severity | None = None
    """Only where it differs from the rule's own."""
    explains: tuple[HasSite, ...] = ()
    """Other objects at which this finding is the cause of what is found; without any, `at` is it."""


@dataclass(frozen=True, slots=True)
class Renderer:
    """What one renderer accepts. Read from `renderers/<name>.toml`; see `renderers/__init__.py`."""

    name: str
    title: str
    is_any: bool = False
    """No renderer in particular, but what those accept that the stage may be for."""
    product_types: frozenset[str] = frozenset()
    """Accepted beside the schema's own."""
    deep_types: frozenset[str] = frozenset()
    """Product types that write deep images, beside the schema's own."""
    deep_extensions: frozenset[str] = frozenset()
    """File extensions for deep images beside exr, with the dot."""
    special_product_names: frozenset[str] = frozenset()
    """Names that are no files."""
    unnamed_product: str = ""
    """What it does with a product that has no name; empty: it writes no file."""
    camera_types: frozenset[str] = frozenset()
    """Prim types that may stand where a Camera is expected; a final * matches the rest."""
    data_types: frozenset[str] = frozenset()
    """Names that it takes for `dataType` beside USD's value types."""
    unsupported_data_types: frozenset[str] = frozenset()
    """Value types of USD that it does not take for `dataType`."""
    host_prims: frozenset[str] = frozenset()
    """Prims that the host application makes and never saves."""
    source_name_attributes: frozenset[str] = frozenset()
    """Attributes of a var that may name its source instead of `sourceName`."""
    extensions: frozenset[str] = frozenset()
    """File extensions that it writes, in lower case, with the dot."""
    unsupported_extensions: frozenset[str] = frozenset()
    """Those of `extensions` that it does not write after all."""
    exact_extension_case: frozenset[str] = frozenset()
    """Titles of those to whom `.PNG` is no `.png`: its own, or for `any` those of all renderers."""
    multi_channel_extensions: frozenset[str] = frozenset()
    """Beside exr, of files that hold any number of channels."""
    frame_tokens: tuple[str, ...] = ()
    """Regular expressions of what it replaces by the frame in a product's name."""
    name_variables: tuple[str, ...] = ()
    """Regular expressions of what else it expands in a product's name."""
    known_namespaces: frozenset[str] = frozenset()
    """Of properties that belong to any renderer, and the general ones."""
    aov_name_attributes: tuple[str, ...] = ()
    """Attributes of a var that name its channel, strongest first."""
    source_types: frozenset[str] = frozenset()
    """Accepted beside the schema's own."""
    source_prefixes: frozenset[str] = frozenset()
    """With which a sourceName may begin though its sourceType says the same."""
    renames_duplicates: bool = False
    """Vars that share a sourceName are told apart by the names of their prims."""
    lpe_dialect: str | None = None
    """None: any dialect will do."""
    properties: frozenset[str] = frozenset()
    """Un-namespaced properties that it reads on render prims."""
    accepted_types: frozenset[tuple[str, str]] = frozenset()
    """(property, type name) pairs that it reads although the schema says otherwise."""
    severities: dict[str, Severity | None] = field(default_factory=dict)
    """Rules whose severity differs here; None: the rule is off."""

    def accepts_camera(self, type_name: str) -> bool:
        """Whether a prim of that type may stand where a Camera is expected."""
        return any(fnmatchcase(type_name, pattern) for pattern in self.camera_types)


class Sign(StrEnum):
    """What most stages do not show, and many rules speak of; `signs` looks for it."""

    RENDER_PASS = "render pass"  # noqa: S105 no secret
    OTHER_PRIM = "other prim"
    """One in the render scope that is neither a render prim nor a mere group, or one of a misspelt
    type."""
    STRAY = "stray"
    """A render prim outside the scope."""
    OVER = "over"
    """A render prim that no layer defines."""
    OTHER_TYPE = "other type"
    """Layers disagree on the type of a prim."""
    ODD_SCOPE = "odd scope"
    """A prim that groups render prims and is not live, or no Scope."""
    ODD_DEFAULT = "odd default"
    """The default settings are named in a wrong place, or are anything but a live RenderSettings."""
    ODD_TARGET = "odd target"
    """A relationship leads, or was to lead, elsewhere than straight to live prims of the right type."""
    ODD_PROPERTY = "odd property"
    """One that is not as its schema has it, or is of no schema and in no namespace."""
    BLOCKED = "blocked"
    VARYING = "varying"
    """An attribute has time samples or a spline, and is meant to have one value."""
    SAMPLED_NAME = "sampled name"
    """A product's name has time samples."""
    UNKNOWN_DATA_TYPE = "unknown data type"
    COLLECTION = "collection"
    """Somebody writes a collection of a pass."""
    COLLECTION_PROPERTY = "collection property"
    INSTANCED_CAMERA = "instanced camera"
    MISSING_VARIANT = "missing variant"
    ARC_ERROR = "arc error"


@dataclass(frozen=True, slots=True)
class Context:
    """What a rule may know beside its subject."""

    renderer: Renderer
    answers: dict[object, tuple[object, Any]] = field(default_factory=dict, compare=False)
    """What rules asked about a subject, by the question; see `once`."""


def once(ask: Callable[[S, Context], T]) -> Callable[[S, Context], T]:
    """A question that several rules ask about one subject, answered once. All get the same answer, so
    it must be one that nobody can change or use up."""

    @wraps(ask)
    def answer(subject: S, context: Context) -> T:
        about, found = context.answers.get(ask, (None, None))
        if about is not subject:
            found = ask(subject, context)
            context.answers[ask] = subject, found
        return cast("T", found)

    return answer


@dataclass(frozen=True, slots=True)
class Rule(Generic[S]):
    id: str
    on: type[S]
    severity: Severity
    since: str
    summary: str
    """First line of the function's docstring."""
    check: Callable[[S, Context], Iterator[Finding]]
    group: str = ""
    """What `--select camera` means; that of its module unless it says otherwise."""
    default: bool = True
    """Runs without being selected."""
    renderers: tuple[str, ...] = ()
    """Speaks only where the stage is judged by one of these; empty: everywhere."""
    supersedes: tuple[str, ...] = ()
    """Rules whose findings at or below the same object only repeat this one's cause."""
    by_itself: bool = False
    """It judges one opinion, whatever other layers say: so, too, in a layer of mere overrides."""
    about: frozenset[str] = frozenset()
    """Signs, and names of attributes and relationships: on a stage that shows none of them it has
    nothing to say, and does not run. Empty: it may always have."""

    @property
    def needs_scene(self) -> bool:
        """The run must open the whole stage for it."""
        return self.on is Scene

    @property
    def only_when(self) -> str:
        """What has to be asked for before it runs; empty: nothing."""
        if self.needs_scene:
            return "only with --scene or by name"
        return "" if self.default else "only when selected"


def rule(
    id: str,
    *,
    on: type[S],
    severity: Severity,
    since: str,
    default: bool = True,
    group: str = "",
    renderers: tuple[str, ...] = (),
    supersedes: tuple[str, ...] = (),
    by_itself: bool = False,
    about: Iterable[str] = (),
) -> Callable[[Callable[[S, Context], Iterator[Finding]]], Rule[S]]:
    """Turn a function into a `Rule`. Nothing is registered: see `registry`."""

    def decorate(check: Callable[[S, Context], Iterator[Finding]]) -> Rule[S]:
        summary = (check.__doc__ or "").strip().partition("\n")[0].rstrip()
        return Rule(
            id,
            on,
            severity,
            since,
            summary,
            check,
            group,
            default,
            renderers,
            supersedes,
            by_itself,
            frozenset(about),
        )

    return decorate


AnyRule = Rule[Any]
