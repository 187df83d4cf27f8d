"""Does the text, or the table of words, of a layer tell which layers it brings in, as USD does?"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from pxr import Sdf, Tf, Usd

from conftest import ROOT
from usdrender_lint.uses import Reach, Uses

STAGES = sorted(
    file
    for folder in ("clean", "bad", "formats", "seed")
    for file in (ROOT / "fixtures" / folder).rglob("*.usd*")
)


def write(folder: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        if name.endswith(".usdc"):
            layer = Sdf.Layer.CreateAnonymous(".usdc")
            layer.ImportFromString(f"#usda 1.0\n{text}\n")
            layer.Export(str(file))
        else:
            file.write_text(f"#usda 1.0\n{text}\n")


def reach(folder: Path, files: dict[str, str], wanted: str = "part.usda") -> Reach:
    """Of `main.usda` or `main.usdc`, asked about one file; as paths from the folder."""
    write(folder, files)
    main = next(name for name in files if name.startswith("main."))
    found = Uses([str(folder / wanted)], ["/Render"]).of(str(folder / main))

    def short(paths: frozenset[str]) -> frozenset[str]:
        return frozenset(Path(os.path.relpath(p, folder.resolve())).as_posix() for p in paths)

    return Reach(short(found.stack), short(found.maybe), found.sure)


def sublayers(*paths: str) -> str:
    return f"(\n    subLayers = [{', '.join(f'@{path}@' for path in paths)}]\n)"


@pytest.mark.parametrize("file", STAGES, ids=lambda f: f.relative_to(ROOT).as_posix())
def test_the_stack_is_that_of_usd(file: Path) -> None:
    try:
        stage = Usd.Stage.OpenMasked(str(file), Usd.StagePopulationMask(["/Render"]))
    except Tf.ErrorException:
        pytest.skip("USD opens no stage")
    stack = {os.path.realpath(one.realPath) for one in stage.GetLayerStack(False)}
    used = {os.path.realpath(one.realPath) for one in stage.GetUsedLayers() if one.realPath}
    found = Uses(used, ["/Render"]).of(str(file))
    assert found.stack | {os.path.realpath(file)} == stack
    assert used - stack <= found.maybe or not found.sure


@pytest.mark.parametrize("suffix", ["usda", "usdc"])
def test_sublayers_are_followed_to_the_last(tmp_path: Path, suffix: str) -> None:
    files = {
        f"main.{suffix}": sublayers(f"./layers/a.{suffix}"),
        f"layers/a.{suffix}": sublayers("../part.usda"),
        "part.usda": "",
    }
    found = reach(tmp_path, files)
    assert found == Reach(frozenset({f"layers/a.{suffix}", "part.usda"}), found.maybe, True)


@pytest.mark.parametrize(
    "header",
    [
        "(\n    subLayers = [\n        @./part.usda@ (offset = 1; scale = 2),\n    ]\n)",
        '(\n    "a doc with @ in it, subLayers = [@./no.usda@]"\n    subLayers = [@part.usda@]\n)',
        "# (\n# subLayers = [@./no.usda@]\n(\n    subLayers = [@@@./part.usda@@@]\n)",
        '(\n    customLayerData = { string subLayers = "x" }\n    subLayers = [@./x/../part.usda@]\n)',
        "(\n    subLayers = [@./part.usda:SDF_FORMAT_ARGS:a=b@]\n)",
    ],
)
def test_a_header_is_read_as_usd_reads_it(tmp_path: Path, header: str) -> None:
    found = reach(tmp_path, {"main.usda": header, "part.usda": "", "no.usda": ""})
    assert found.stack == {"part.usda"}
    assert found.sure


def test_a_long_header_is_read_to_its_end(tmp_path: Path) -> None:
    doc = f'(\n    doc = """{"x" * 100_000}"""\n    subLayers = [@./part.usda@]\n)'
    write(tmp_path, {"main.usda": doc, "part.usda": ""})
    part = str((tmp_path / "part.usda").resolve())
    assert Uses([part], ["/Render"]).of(str(tmp_path / "main.usda")).stack == {part}
    assert Uses([], ["/Render"]).of(str(tmp_path / "main.usda")).stack == {part}


def test_layers_that_sublayer_each_other_end(tmp_path: Path) -> None:
    files = {"main.usda": sublayers("./part.usda"), "part.usda": sublayers("./main.usda")}
    assert reach(tmp_path, files).stack == {"part.usda"}


@pytest.mark.parametrize("suffix", ["usda", "usdc"])
def test_a_reference_to_what_is_asked_about_counts_anywhere(tmp_path: Path, suffix: str) -> None:
    prims = 'def "World"\n{\n    def "a" (references = @./part.usda@)\n    {\n    }\n'
    prims += '    def "b" (references = @./other.usda@)\n    {\n    }\n}'
    found = reach(tmp_path, {f"main.{suffix}": prims, "part.usda": "", "other.usda": ""})
    assert found == Reach(frozenset(), frozenset({"part.usda"}), True)


def test_references_of_a_render_scope_are_followed(tmp_path: Path) -> None:
    files = {
        "main.usda": 'def "Render" (references = @./show.usda@)\n{\n}',
        "show.usda": sublayers("./part.usda"),
        "part.usda": "",
    }
    assert reach(tmp_path, files).maybe == {"show.usda", "part.usda"}


def test_a_stray_mark_hides_no_asset(tmp_path: Path) -> None:
    prims = 'def "a" (references = @./part.usda@) # ask lighting@studio\n{\n}\n'
    prims = prims.replace("# ask", "/* render@studio */ # ask").replace(
        "(references", "/* x@y */ (references"
    )
    assert "part.usda" in reach(tmp_path, {"main.usda": prims, "part.usda": ""}).maybe


@pytest.mark.parametrize(
    "header",
    [
        '(\n    subLayers = [@`"${PART}"`@]\n)',
        "(\n    subLayers = [@show:part.usda@]\n)",
        "(\n    subLayers = [@on_a_search_path.usda@]\n)",
    ],
)
def test_what_needs_a_resolver_is_not_sure(tmp_path: Path, header: str) -> None:
    assert not reach(tmp_path, {"main.usda": header}).sure


def test_a_missing_sublayer_brings_nothing(tmp_path: Path) -> None:
    assert reach(tmp_path, {"main.usda": sublayers("./gone.usda")}) == Reach(
        frozenset(), frozenset(), True
    )


def test_a_crate_that_does_not_tell_its_arcs_apart_is_not_sure(tmp_path: Path) -> None:
    prims = f'{sublayers("./a.usda")}\ndef "a" (references = @./b.usda@)\n{{\n}}'
    assert not reach(tmp_path, {"main.usdc": prims, "a.usda": "", "b.usda": ""}).sure


def test_many_references_beside_a_render_scope_are_not_followed(tmp_path: Path) -> None:
    prims = 'def "Render"\n{\n}\n' + "".join(
        f'def "a{n}" (references = @./a{n}.usda@)\n{{\n}}\n' for n in range(100)
    )
    files = {"main.usda": prims, **{f"a{n}.usda": "" for n in range(100)}}
    found = reach(tmp_path, files)
    assert (found.maybe, found.sure) == (frozenset(), False)


def test_a_link_is_left_by_its_name(tmp_path: Path) -> None:
    """As USD does it: `./part.usda` of a linked layer lies beside the link."""
    files = {"store/v1.usda": sublayers("./part.usda"), "store/part.usda": "", "shot/part.usda": ""}
    write(tmp_path, files)
    link = tmp_path / "shot" / "shot.usda"
    link.symlink_to(tmp_path / "store" / "v1.usda")
    stage = Usd.Stage.Open(str(link))
    folders = [Path(one.realPath).parent.name for one in stage.GetLayerStack(False)]
    assert folders == ["shot", "shot"]
    found = Uses([], ["/Render"]).of(str(link))
    assert found.stack == {str((tmp_path / "shot" / "part.usda").resolve())}


def test_what_cannot_be_read_is_kept_apart(tmp_path: Path) -> None:
    uses = Uses([], ["/Render"])
    assert uses.of(str(tmp_path / "gone.usda")) == Reach(frozenset(), frozenset(), True)
    assert uses.unreadable == {os.path.realpath(tmp_path / "gone.usda")}


def test_a_name_that_no_file_can_have_is_none(tmp_path: Path) -> None:
    found = reach(tmp_path, {"main.usda": f"(\n    subLayers = [@./{'a' * 5000}.usda@]\n)"})
    assert found.stack == frozenset()
