"""However much there is of anything, it is followed to its end, and in time that grows with it."""

from __future__ import annotations

import difflib
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pxr import Pcp, Sdf

from usdrender_lint.likeness import is_like, likeness, most_alike
from usdrender_lint.read import read
from usdrender_lint.read.patterns import Op, tree
from usdrender_lint.read.text import Texts
from usdrender_lint.stage import open_stage
from usdrender_lint.testing import lint_files

META = '#usda 1.0\n(\n    renderSettingsPrimPath = "/Render/S"\n)\n'
CAMERA = 'def Camera "cam"\n{\n}\n'


def stage(camera: str = "/cam", inside: str = "", outside: str = "", more: str = "") -> str:
    return f"""{META}def Scope "Render"
{{
    def RenderSettings "S"
    {{
        rel camera = <{camera}>
        rel products = </Render/P>
    }}
    def RenderProduct "P"
    {{
        token productName = "/out/a.exr"
        rel orderedVars = </Render/v>
    }}
    def RenderVar "v"
    {{
        string sourceName = "Ci"
    }}
{more}{inside}}}
{CAMERA}{outside}"""


def found(main: str) -> list[str]:
    report, marks = lint_files({"main.usda": main})
    assert report.problems == ()
    return [f"{m.rule}: {m.text}" for m in marks]


def chain(length: int, above: str, end: str) -> str:
    further = [f"{above}/H{n}.next" for n in range(1, length)]
    return "".join(
        f'def "H{n}"\n{{\n    rel next = <{target}>\n}}\n'
        for n, target in enumerate([*further, end])
    )


@pytest.mark.parametrize("length", [8, 9, 21, 1100])
def test_relationships_are_followed_to_their_end(length: int) -> None:
    """USD follows as many; a chain outside the scope has to be populated on the way."""
    assert found(stage("/H0.next", outside=chain(length, "", "/cam"))) == []
    assert found(stage("/Render/H0.next", inside=chain(length, "/Render", "/cam"))) == []


def test_the_end_of_a_long_chain_is_told_when_it_is_missing() -> None:
    (only,) = found(stage("/H0.next", outside=chain(30, "", "/gone")))
    assert only.startswith("unresolved-target: camera </gone> does not exist")


@pytest.mark.parametrize("length", [3, 12, 40])
def test_collections_are_followed_to_their_end(length: int) -> None:
    passes = (
        '    def RenderPass "A"\n    {\n        rel renderSource = </Render/S>\n'
        "        rel collection:renderVisibility:includes = </C0.collection:c>\n    }\n"
    )
    others = "".join(
        f'def "C{n}" (\n    apiSchemas = ["CollectionAPI:c"]\n)\n{{\n    rel collection:c:includes = '
        f"<{f'/C{n + 1}.collection:c' if n < length - 1 else '/cam'}>\n}}\n"
        for n in range(length)
    )
    assert not [f for f in found(stage(more=passes, outside=others)) if "does not exist" in f]


def test_groups_within_groups() -> None:
    """1,500 took 30 s when each was searched anew."""
    count = 1500
    inside = "".join(f'def Scope "g{n}"\n{{\n' for n in range(count)) + "}\n" * count
    assert found(stage(inside=inside)) == []


def test_groups_within_groups_spell_out_few_paths(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each takes as long as it is deep: of 8,000 within each other 2 s, five times over."""
    spelt, spell = [], Sdf.Path.__str__

    def counted(path: Sdf.Path) -> str:
        spelt.append(path)
        return spell(path)

    monkeypatch.setattr(Sdf.Path, "__str__", counted)

    def spells(depth: int) -> int:
        spelt.clear()
        groups = "".join(f'def Scope "g{n}"\n{{\n' for n in range(depth)) + "}\n" * depth
        assert found(stage(inside=groups)) == []
        return len(spelt)

    assert spells(60) == spells(20)


def test_the_children_of_one_prim_are_listed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """For each of 10,000 missing products the 10,000 that are there were."""
    listed, listing = [], Pcp.PrimIndex.ComputePrimChildNames

    def counted(index: Pcp.PrimIndex) -> object:
        listed.append(index)
        return listing(index)

    monkeypatch.setattr(Pcp.PrimIndex, "ComputePrimChildNames", counted)

    def lists(missing: int) -> int:
        listed.clear()
        wanted = ", ".join(f"</Render/X{n}>" for n in range(missing))
        assert found(stage().replace("products = </Render/P>", f"products = [{wanted}]"))
        return len(listed)

    assert lists(80) == lists(40) > 0


def test_an_expression_of_any_depth() -> None:
    mixed = " ".join(f"/a{n} {'+&-'[n % 3]}" for n in range(3000)) + " /b"
    node = tree(Sdf.PathExpression(mixed))
    assert node is not None
    assert node.holds("/nope") is not True


def test_a_long_list_is_asked_only_about_what_is_near() -> None:
    node = tree(Sdf.PathExpression(" + ".join(f"/World/x{n}" for n in range(5000)) + " + //cam"))
    assert node is not None
    assert node.op is Op.UNION
    assert [node.holds(p) for p in ("/World/x77", "/World/y", "/a/cam", "/World")] == [
        True, False, True, False,
    ]  # fmt: skip
    assert [node.may_hold_below(p) for p in ("/World", "/World/x77/b")] == [True, True]


def steps_of_reading(folder: Path, variables: int) -> int:
    """Calls of functions, of Python and of its built-ins, for a stage of so many vars."""
    more = "".join(
        f'    def RenderVar "v{n}"\n    {{\n        uniform token dataType = "float"\n'
        f'        uniform string sourceName = "s{n}"\n    }}\n'
        for n in range(variables)
    )
    file = folder / f"{variables}.usda"
    file.write_text(stage(more=more), "utf-8")
    counted = 0

    def count(_frame: object, event: str, _what: object) -> None:
        nonlocal counted
        counted += event in ("call", "c_call")

    layer = Sdf.Layer.FindOrOpen(str(file))
    opened = open_stage(layer, ("/Render",))
    sys.setprofile(count)
    try:
        read(opened, Texts())
    finally:
        sys.setprofile(None)
    return counted


def test_reading_a_var_takes_few_steps(tmp_path: Path) -> None:
    steps_of_reading(tmp_path, 1)  # what is looked up once is looked up
    few, more = steps_of_reading(tmp_path, 10), steps_of_reading(tmp_path, 110)
    assert few < 2800
    assert more - few < 100 * 165


NAMES = st.text("abcXY_1", min_size=1, max_size=8)


@given(NAMES, NAMES, st.sampled_from([0.0, 0.25, 0.5, 0.75, 0.8, 1.0]))
def test_names_are_as_like_as_a_full_comparison_finds(one: str, other: str, least: float) -> None:
    assert is_like(one, other, least) is (likeness(one, other) >= least)


@given(NAMES, st.lists(NAMES, max_size=30), st.integers(1, 5))
def test_the_most_alike_are_those_that_a_full_comparison_finds(
    name: str, known: list[str], most: int
) -> None:
    ratios = {
        other: difflib.SequenceMatcher(None, other.lower(), name.lower()).ratio() for other in known
    }
    best = sorted(ratios, key=lambda other: (-ratios[other], other))[:most]
    assert most_alike(name, known, most) == [(ratios[other], other) for other in best]
