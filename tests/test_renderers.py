"""What each renderer accepts, and which one a stage seems to be for."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from usdrender_lint import renderers
from usdrender_lint.model import Evidence
from usdrender_lint.registry import all_rules
from usdrender_lint.renderers import ANY, choose, names, renderer
from usdrender_lint.rule import Severity

FOLDER = Path(renderers.__file__).parent
TABLES: dict[str, dict[str, Any]] = {
    file.stem: tomllib.loads(file.read_text("utf-8")) for file in sorted(FOLDER.glob("*.toml"))
}
COPY = FOLDER / "tables.py"
COPIED = """\
# Written by `pytest --update`.
# fmt: off
# ruff: noqa
\"\"\"What do the TOML files beside this one say? To read them takes longer than to lint a small file.\"\"\"

from __future__ import annotations

from typing import Any

BUILT_IN: dict[str, dict[str, Any]] = {
"""
DOCUMENTED = {
    *re.findall(r"^    ([a-z-]+) = ", renderers.__doc__ or "", re.M),
    "severity",
    "evidence",
}
EVIDENCE = {
    "namespaces",
    "schemas",
    "product-types",
    "camera-types",
    "prim-names",
    "layer-data",
}


def test_what_runs_is_what_the_files_say(update: bool) -> None:
    entries = "".join(f"    {name!r}: {table!r},\n" for name, table in TABLES.items())
    copied = f"{COPIED}{entries}}}\n"
    if update:
        COPY.write_text(copied, "utf-8")
    assert COPY.read_text("utf-8") == copied, "run pytest --update"
    assert names() == [*TABLES]


def test_the_known_ones() -> None:
    assert {"any", "arnold", "omniverse"} <= set(names())
    assert names() == sorted(names())


def test_an_unknown_name_is_a_key_error() -> None:
    with pytest.raises(KeyError):
        renderer("maxwell")


@pytest.mark.parametrize("name", TABLES)
class TestTable:
    def test_holds_only_keys_that_are_read(self, name: str) -> None:
        assert set(TABLES[name]) <= DOCUMENTED
        assert set(TABLES[name].get("evidence", {})) <= EVIDENCE

    def test_becomes_a_renderer(self, name: str) -> None:
        found = renderer(name)
        assert found.name == name
        assert found.title == TABLES[name]["title"]
        assert renderer(name) is found

    def test_says_which_traces_it_leaves(self, name: str) -> None:
        assert any(TABLES[name].get("evidence", {}).values()) is (name != ANY)

    def test_severities_are_those_of_rules(self, name: str) -> None:
        assert set(renderer(name).severities) <= set(all_rules())

    def test_accepts_what_all_accept(self, name: str) -> None:
        found, common = renderer(name), renderer(ANY)
        assert found.data_types >= common.data_types
        assert found.special_product_names >= common.special_product_names
        assert found.source_name_attributes >= common.source_name_attributes


def test_off_is_no_severity() -> None:
    levels = TABLES["omniverse"]["severity"]
    expected = {rule: None if level == "off" else Severity(level) for rule, level in levels.items()}
    assert renderer("omniverse").severities == expected
    assert renderer("omniverse").severities["empty-product-name"] is None


@pytest.mark.parametrize(
    ("type_name", "accepted"),
    [("OmniLidar", True), ("OmniSensorLidar", True), ("OmniGraph", False), ("", False)],
)
def test_cameras_are_accepted_by_pattern(type_name: str, accepted: bool) -> None:
    assert renderer("omniverse").accepts_camera(type_name) is accepted
    assert not renderer(ANY).accepts_camera(type_name)


class TestChoose:
    @pytest.mark.parametrize(
        ("evidence", "name", "reason"),
        [
            (Evidence(), "any", "no traces of a renderer"),
            (Evidence(namespaces=(("primvars", 9),)), "any", "no traces of a renderer"),
            (
                Evidence(namespaces=(("arnold", 2), ("omni", 1))),
                "arnold",
                "properties in the namespace 'arnold'",
            ),
            (
                Evidence(namespaces=(("arnold", 2), ("omni", 4))),
                "omniverse",
                "properties in the namespace 'omni'",
            ),
            (Evidence(product_types=(("arnold", 1),)), "arnold", "productType 'arnold'"),
            (
                Evidence(schemas=(("ArnoldOptionsAPI", 1),)),
                "arnold",
                "applied schemas 'ArnoldOptionsAPI'",
            ),
            (Evidence(prim_names=("OmniverseKit",)), "omniverse", "prims named 'OmniverseKit'"),
            (Evidence(layer_data=("omni_layer",)), "omniverse", "layer data 'omni_layer'"),
            (Evidence(prim_names=("LdrColor", "Vars")), "omniverse", "prims named 'LdrColor'"),
        ],
    )
    def test_by_the_traces(self, evidence: Evidence, name: str, reason: str) -> None:
        chosen, said = choose(evidence)
        assert (chosen.name, said) == (name, reason)

    def test_of_many_traces_of_a_kind_some_are_named(self) -> None:
        chosen, said = choose(Evidence(schemas=tuple((f"OmniRtx{n}API", 1) for n in range(16))))
        assert chosen.name == "omniverse"
        assert said == "applied schemas 'OmniRtx0API', 'OmniRtx1API', 'OmniRtx2API' and 13 more"

    def test_traces_of_all_kinds_are_named_and_count(self) -> None:
        evidence = Evidence(
            namespaces=(("omni", 1), ("rtx", 1)),
            product_types=(("arnold", 1),),
            layer_data=("omni_layer",),
        )
        chosen, said = choose(evidence)
        assert chosen.name == "omniverse"
        assert said == "properties in the namespace 'omni', 'rtx'; layer data 'omni_layer'"

    def test_what_is_made_for_several_is_judged_by_what_any_of_them_accepts(self) -> None:
        both = Evidence(namespaces=(("omni", 3), ("arnold", 2)))
        chosen, said = choose(both)
        assert (chosen.name, said) == (
            "any",
            "traces of arnold and omniverse, none by far the most",
        )
        assert chosen.product_types == renderer("arnold").product_types
        assert chosen.accepts_camera("OmniLidar")
        assert chosen.severities["empty-product-name"] is None
        assert not renderer(ANY).accepts_camera("OmniLidar")
