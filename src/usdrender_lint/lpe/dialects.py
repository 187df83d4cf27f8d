"""Which letters, prefixes and operators does each renderer read?

Open Shading Language is the one that `UsdRenderVar.sourceType` names, and the only one, with
MoonRay, whose reader is public. Of the others only the documentation and the expressions they
ship are known: where those are silent, a dialect reads what Open Shading Language reads.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from types import MappingProxyType

from ..records import dataclass

CAMERA = "C"
MEANINGS = MappingProxyType(
    {
        "C": "camera",
        "L": "light",
        "O": "emissive object",
        "B": "background",
        "V": "volume",
        "R": "reflection",
        "T": "transmission",
        "A": "albedo",
        "D": "diffuse",
        "G": "glossy",
        "S": "specular",
        "s": "straight",
    }
)


@dataclass(frozen=True, slots=True, eq=False)  # told apart by being the same one
class Dialect:
    """One renderer's language. The defaults are Open Shading Language."""

    name: str
    title: str
    bounces: str = "RTV"
    """Events on the way."""
    ends: str = "LOB"
    """Events at which a path ends."""
    either: str = ""
    """Events that may stand on the way and at the end."""
    scatterings: str = "DGSs"
    instead: Mapping[str, str] = field(default_factory=dict)
    """Letters that are read and never match, and what to write for them."""
    lobes: Mapping[str, int] = field(default_factory=dict)
    """Scatterings that may carry a number, and the highest."""
    prefixes: frozenset[str] = frozenset()
    """Words that may stand before the expression, each ended by `;`."""
    ignores_prefixes: bool = False
    """An unknown prefix is let through, without effect."""
    names: frozenset[str] = frozenset()
    """Words that stand for an expression the renderer has."""
    optional: bool = False
    """`?` is a repetition."""
    operators: str = "|"
    """What stands between two alternatives."""
    complements: bool = False
    """`^` before an alternative is every path but these."""
    long_alternatives: bool = False
    """`|` parts all that stands left and right of it, not just its two neighbours."""
    reads_on: bool = False
    """A leading `(...)` does not end the expression."""
    qualifying_labels: bool = False
    """A label may belong to the event before it, instead of being one."""

    @property
    def events(self) -> str:
        return CAMERA + self.bounces + self.either + self.ends

    @property
    def letters(self) -> str:
        return self.events + self.scatterings

    @property
    def repetitions(self) -> str:
        return "*+{?" if self.optional else "*+{"


# src/liboslexec/lpeparse.cpp (ad63273a). `Parser::parse` hands the whole text to `parseCat`, which
# returns at the `)` that closes a leading `(`: what follows is never looked at.
OSL = Dialect("osl", "Open Shading Language")

# rmanwiki.pixar.com "Light Path Expressions", whose parser is derived from Open Shading Language's
# (RixLPEInline.h), and the channels that RenderMan for Blender ships
# (rman_dspychan_definitions.json): they hold `(C<RD>[DS]+<L.>)|(C<RD>[DS]*O)` and, with `|` between
# two neighbours, `C(D[DS]*[LO])|O`. The list of prefixes may lack some.
RENDERMAN = Dialect(
    "renderman",
    "RenderMan",
    scatterings="DGSsU",
    lobes=MappingProxyType({"D": 4, "S": 8, "U": 12}),
    prefixes=frozenset(
        {
            "shadows",
            "holdouts",
            "unoccluded",
            "noclamp",
            "nothruput",
            "noinfinitecheck",
            "overwrite",
        }
    ),
    ignores_prefixes=True,
    names=frozenset(
        {
            "diffuse",
            "indirectdiffuse",
            "specular",
            "indirectspecular",
            "subsurface",
            "refraction",
            "emission",
            "shadowcollector",
            "reflectioncollector",
        }
    ),
    reads_on=True,
)

# help.autodesk.com "Light Path Expression AOVs". That its own `((C<TD>A)|(CVA)|(C<RD>A))` has a
# pair of parentheses too many is what Open Shading Language's reader asks for.
ARNOLD = Dialect("arnold", "Arnold", ends="LOBA")

# sidefx.com/docs/houdini/solaris/support/lpe.html: "all specular scatter types are defined as G".
KARMA = Dialect(
    "karma",
    "Karma",
    ends="LOBA",
    instead=MappingProxyType({"S": "G", "s": "G"}),
    prefixes=frozenset({"unoccluded", "shadow"}),
    reads_on=True,
)

# dreamworksanimation/moonray: lib/rendering/lpe/StateMachine.cc gives Open Shading Language's
# parser the events U (extra aovs) and M (material aovs); lib/rendering/pbr/core/Aov.cc has the
# names and the prefix, and warns of any other one.
MOONRAY = Dialect(
    "moonray",
    "MoonRay",
    either="UM",
    prefixes=frozenset({"unoccluded"}),
    ignores_prefixes=True,
    names=frozenset(
        {
            "caustic",
            "diffuse",
            "emission",
            "glossy",
            "mirror",
            "reflection",
            "translucent",
            "transmission",
        }
    ),
)

# docs.chaos.com "Light Path Expressions", with the preset `C<RD>(.+L|.*[OB])`: there `|` parts
# sequences; `CR'1'.+L` is "indirect for object label 1"; and `^ & -` combine expressions.
VRAY = Dialect(
    "vray",
    "V-Ray",
    prefixes=frozenset({"shadow"}),
    optional=True,
    operators="|&-",
    complements=True,
    long_alternatives=True,
    reads_on=True,
    qualifying_labels=True,
)

ALL = (OSL, RENDERMAN, ARNOLD, KARMA, MOONRAY, VRAY)
DIALECTS: Mapping[str, Dialect] = MappingProxyType({d.name: d for d in ALL})


def titles(dialects: tuple[Dialect, ...]) -> str:
    """`A`, `A and B`, `A, B and C`."""
    *first, last = (d.title for d in dialects)
    return f"{', '.join(first)} and {last}" if first else last
