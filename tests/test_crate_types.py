"""Do the tables of a crate file say the same of its specs as USD does?"""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from pxr import Sdf

from conftest import ROOT
from usdrender_lint import crate as tables
from usdrender_lint import lint_file
from usdrender_lint.lint import lint
from usdrender_lint.read.crate_types import crate_types

WANTED = re.compile(rb"Render(?:Settings|Var)")
TYPES = ("", "Scope", "RenderSettings", "RenderVar", "RenderVars", "Mesh", "MyRenderVar")


def walked(layer: Sdf.Layer) -> list[str]:
    def below(spec: Sdf.PrimSpec) -> Iterator[Sdf.PrimSpec]:
        yield spec
        for child in spec.nameChildren:
            yield from below(child)
        for variants in spec.variantSets:
            for variant in variants.variants:
                yield from below(variant.primSpec)

    specs = (spec for root in layer.rootPrims for spec in below(root))
    found = (s for s in specs if WANTED.fullmatch(s.typeName.encode()))
    return sorted({str(s.path.StripAllVariantSelections()) for s in found})


def grow(chance: random.Random, parent: Sdf.PrimSpec | Sdf.Layer, depth: int) -> None:
    for number in range(chance.randint(0, 6 if depth < 4 else 0)):
        name = chance.choice(["a", "b", "RenderVar", "lamp_"]) + str(number)
        specifier = chance.choice([Sdf.SpecifierDef, Sdf.SpecifierOver, Sdf.SpecifierClass])
        prim = Sdf.PrimSpec(parent, name, specifier, chance.choice(TYPES))
        for _ in range(chance.randint(0, 3)):
            attribute = Sdf.AttributeSpec(
                prim,
                f"value{_}",
                chance.choice([Sdf.ValueTypeNames.Float, Sdf.ValueTypeNames.Token]),
            )
            if attribute.typeName == Sdf.ValueTypeNames.Token:
                attribute.default = chance.choice(["RenderVar", "typeName", "x" * 300])
            else:
                attribute.default = chance.random()
        if chance.random() < 0.2:
            Sdf.RelationshipSpec(prim, "camera").targetPathList.Prepend("/RenderVar0")
        if chance.random() < 0.2:
            kinds = Sdf.VariantSetSpec(prim, "kind")
            for variant in ("one", "two"):
                grow(chance, Sdf.VariantSpec(kinds, variant).primSpec, depth + 1)
        grow(chance, prim, depth + 1)


def crate(folder: Path, layer: Sdf.Layer) -> str:
    file = folder / "layer.usdc"
    assert layer.Export(str(file))
    return str(file)


@pytest.mark.parametrize("seed", range(60))
def test_every_spec_of_a_type_is_found(tmp_path: Path, seed: int) -> None:
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    grow(random.Random(seed), layer, 0)  # noqa: S311 to be repeated
    found = crate_types(crate(tmp_path, layer), WANTED)
    assert found is not None
    assert found.paths() == walked(layer)
    assert (found.count > 0) == bool(walked(layer))


def test_many_specs_are_found(tmp_path: Path) -> None:
    """More than a chunk of them, and numbers of every width."""
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    chance = random.Random(1)  # noqa: S311 to be repeated
    with Sdf.ChangeBlock():
        for number in range(9000):
            kind = chance.choice(TYPES) if number % 97 == 0 else ""
            Sdf.PrimSpec(layer, f"p{chance.randrange(10**9)}_{number}", Sdf.SpecifierDef, kind)
    found = crate_types(crate(tmp_path, layer), WANTED)
    assert found is not None
    assert found.paths() == walked(layer) != []


def test_a_version_beyond_the_known_ones_is_not_read(tmp_path: Path) -> None:
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    Sdf.PrimSpec(layer, "a", Sdf.SpecifierDef, "RenderVar")
    file = Path(crate(tmp_path, layer))
    data = bytearray(file.read_bytes())
    assert (0, 4) <= tuple(data[8:10]) <= (0, 13)
    data[9] = 14
    file.write_bytes(data)
    assert crate_types(str(file), WANTED) is None


@pytest.mark.parametrize("seed", range(40))
def test_what_is_damaged_raises_nothing(tmp_path: Path, seed: int) -> None:
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    grow(random.Random(3), layer, 0)  # noqa: S311 to be repeated
    file = Path(crate(tmp_path, layer))
    chance = random.Random(seed)  # noqa: S311 to be repeated
    data = bytearray(file.read_bytes())
    for _ in range(chance.randint(1, 30)):
        data[chance.randrange(len(data))] = chance.randrange(256)
    file.write_bytes(data[: chance.choice([len(data), chance.randrange(len(data))])])
    found = crate_types(str(file), WANTED)
    assert found is None or isinstance(found.paths(), list | None)


def test_what_is_no_crate_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "a.usdc").write_text("#usda 1.0\n", "utf-8")
    assert crate_types(str(tmp_path / "a.usdc"), WANTED) is None
    assert crate_types(str(tmp_path / "gone.usdc"), WANTED) is None


def test_no_large_table_outlives_its_stage(monkeypatch: pytest.MonkeyPatch) -> None:
    def kept() -> int:
        return tables._tokens_of_large.cache_info().currsize

    def forget() -> None:
        before.append(kept())
        tables.forget_large()

    before: list[int] = []
    monkeypatch.setattr(tables, "_LITTLE", 0)
    monkeypatch.setattr(lint_file, "forget_large", forget)
    lint([str(ROOT / "fixtures" / "formats" / "scene.usdc")])
    assert (before, kept()) == ([1], 0)
