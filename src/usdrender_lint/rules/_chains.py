"""What is told of the way to a target, and of the opinions that make it what it is?"""

from __future__ import annotations

from ..model import HasSite, Rel, Site, State, Target

Related = tuple[tuple[HasSite, str], ...]


def start_of(target: Target) -> Related:
    """Where the chain begins that ends at the entry which names the target."""
    return ((target.site, f"leads there, by way of <{target.via}>"),) if target.via else ()


def dead_ends(rel: Rel) -> Related:
    """Why a relationship that names something leads to nothing."""
    return tuple(
        (
            site,
            "leads back, and to no prim" if site.target else "is where it leads, and names nothing",
        )
        for site in rel.dead_ends
    )


def why_not_live(target: Target) -> tuple[HasSite, str]:
    """The opinion that keeps renderers from meeting the prim."""
    if target.state is State.INACTIVE:
        return Site(target.because or target.path, "active"), "is switched off here"
    return Site(target.path), "is the prim"
