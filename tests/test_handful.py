"""One cause is told a handful of times at most."""

from __future__ import annotations

from usdrender_lint.model import Site
from usdrender_lint.rule import Finding
from usdrender_lint.rules._handful import HANDFUL, handful
from usdrender_lint.testing import BASE, HEADER, lint_files


def made(count: int, label: str = "x") -> list[Finding]:
    return [Finding(Site(f"/{label}{i}"), f"{label}{i} is wrong", label) for i in range(count)]


def test_a_few_stay_as_they_are() -> None:
    found = made(HANDFUL)
    assert list(handful(found, "vars")) == found


def test_many_become_the_first_which_names_others() -> None:
    (one,) = handful(made(40), "vars")
    assert one.message == "x0 is wrong (so it is with 39 other vars)"
    assert one.at == Site("/x0")
    assert [at for at, _ in one.related] == [Site(f"/x{i}") for i in range(1, HANDFUL + 1)]


def test_another_label_is_another_cause() -> None:
    found = list(handful([*made(9), *made(2, "y")], "vars"))
    assert [f.at.site.path for f in found] == ["/x0", "/y0", "/y1"]


def test_members_that_are_missing_are_told_for_each_collection() -> None:
    """A pass made for another shot names thousands that are not in this one."""
    gone = ", ".join(f"</World/gone{n}>" for n in range(50))
    rules = "".join(f"rel collection:{c}:includes = [{gone}]\n" for c in ("prune", "matte"))
    a_pass = f'def RenderPass "A"\n{{\nrel renderSource = </Render/Primary>\n{rules}}}\n'
    main = f'{HEADER}def Scope "Render"\n{{\n{a_pass}}}\n'
    _, marks = lint_files({"main.usda": main, "base.usda": BASE}, rules=["unresolved-member"])
    assert sorted(m.text for m in marks) == [
        f"'{name}' includes </World/gone0>, which does not exist "
        f"(so it is with 49 other members of '{name}')"
        for name in ("matte", "prune")
    ]
