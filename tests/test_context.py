"""Is a layer judged through the stages that use it, and never green where it is broken?"""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Mapping
from itertools import permutations
from pathlib import Path

import pytest
from pxr import Sdf

from conftest import ROOT
from usdrender_lint import lint as lint_module
from usdrender_lint.__main__ import main
from usdrender_lint.baseline import Baseline
from usdrender_lint.job import Config
from usdrender_lint.lint import lint
from usdrender_lint.results import Report
from usdrender_lint.rule import Severity

SCOPE = """
def Scope "Render"
{
    def RenderSettings "final"
    {
        rel camera = </World/cam>
        rel products = </Render/beauty>
    }
    def RenderProduct "beauty"
    {
        token productName = "/out/beauty.exr"
        rel orderedVars = </Render/Vars/color>
    }
    def Scope "Vars"
    {
        def RenderVar "color"
        {
            uniform token dataType = "color3f"
            uniform string sourceName = "Ci"
        }
    }
}
"""
CAMERA = 'over "World"\n{\n    def Camera "cam"\n    {\n    }\n}\n'
RENAMED = CAMERA.replace('"cam"', '"cam2"')
LAYOUT = 'def Xform "World"\n{\n    def Sphere "ball"\n    {\n    }\n}\n'
BAD_VAR = 'over "Render"\n{\n    over "Vars"\n    {\n        over "color"\n        {\n            uniform token dataType = "color9"\n        }\n    }\n}\n'


Call = Callable[..., tuple[int, str, str]]


def layer(*sublayers: str, text: str = "", default: bool = True) -> str:
    lines = ['    renderSettingsPrimPath = "/Render/final"\n'] if default else []
    if sublayers:
        lines.append(f"    subLayers = [{', '.join(f'@{one}@' for one in sublayers)}]\n")
    return f"#usda 1.0\n(\n{''.join(lines)})\n{text}"


def part(text: str) -> str:
    return f"#usda 1.0\n{text}"


SHOT = {
    "shot.usda": layer("./render.usda", "./camera.usda", "./layout.usda"),
    "render.usda": part(SCOPE),
    "camera.usda": part(CAMERA),
    "layout.usda": part(LAYOUT),
}


def write(folder: Path, files: Mapping[str, str]) -> None:
    for name, text in files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)


def linted(
    folder: Path, files: Mapping[str, str], *given: str, roots: tuple[str, ...] = ()
) -> Report:
    """Write the files, and lint those given, by default all."""
    write(folder, files)
    paths = [str(folder / name) for name in given or files]
    return lint(paths, Config(roots=roots), cwd=folder)


def told(report: Report) -> list[str]:
    """What is found, where, and through which stages."""
    assert report.complete, report.problems
    return [
        f"{f.rule.id} {f.location.path} in {' '.join(f.roots)}"
        for f in report.findings
        if f.severity is not Severity.NOTE
    ]


class TestOneRun:
    def test_the_clean_scenes_are_clean_as_a_folder(self) -> None:
        report = lint([str(ROOT / "fixtures" / "clean")], cwd=ROOT)
        assert told(report) == []
        assert len(report.files) == len([*(ROOT / "fixtures" / "clean").rglob("*.usda")])

    def test_a_layer_is_no_stage_beside_the_shot_that_sublayers_it(self, tmp_path: Path) -> None:
        assert told(linted(tmp_path, SHOT, "render.usda")) != []
        report = linted(tmp_path, SHOT)
        assert told(report) == []
        assert report.files == ("camera.usda", "layout.usda", "render.usda", "shot.usda")
        assert [choice.root for choice in report.renderers] == ["shot.usda"]

    def test_what_holds_in_the_shot_is_told_once_and_of_the_shot(self, tmp_path: Path) -> None:
        files = SHOT | {"camera.usda": part(RENAMED)}
        assert told(linted(tmp_path, files)) == ["unresolved-target render.usda in shot.usda"]

    def test_it_is_the_same_whatever_the_order(self, tmp_path: Path) -> None:
        files = SHOT | {
            "camera.usda": part(RENAMED),
            "render.usda": part(SCOPE.replace("color3f", "color9")),
        }
        reports = [linted(tmp_path, files, *order) for order in permutations(files)]
        first = reports[0]
        assert len(told(first)) == 2
        for report in reports[1:]:
            assert report.findings == first.findings
            assert report.files == first.files

    def test_two_shots_that_share_a_layer_are_one_finding(self, tmp_path: Path) -> None:
        files = {
            "a.usda": layer("./render.usda", text=LAYOUT),
            "b.usda": layer("./render.usda", "./camera.usda"),
            "c.usda": layer("./render.usda", text=LAYOUT),
            "render.usda": SHOT["render.usda"],
            "camera.usda": part(CAMERA.replace("over", "def")),
        }
        assert told(linted(tmp_path, files)) == ["unresolved-target render.usda in a.usda c.usda"]

    def test_only_the_topmost_stage_counts(self, tmp_path: Path) -> None:
        """`lighting` completes what `shot` lacks, and both use `render`."""
        files = SHOT | {
            "shot.usda": layer("./render.usda", default=False),
            "lighting.usda": layer("./shot.usda", "./camera.usda", "./layout.usda"),
        }
        assert told(linted(tmp_path, files, "shot.usda", "render.usda")) != []
        assert told(linted(tmp_path, files)) == []

    def test_layers_that_sublayer_each_other_are_judged_by_themselves(self, tmp_path: Path) -> None:
        files = {
            "a.usda": layer("./b.usda", text=SCOPE + LAYOUT),
            "b.usda": layer("./a.usda"),
        }
        report = linted(tmp_path, files)
        assert "unresolved-target a.usda in a.usda b.usda" in told(report)

    def test_a_layer_that_does_not_parse_is_told(self, tmp_path: Path) -> None:
        files = SHOT | {"render.usda": part('def "Render" {\n')}
        assert "syntax-error render.usda in render.usda shot.usda" in told(linted(tmp_path, files))

    def test_a_shot_that_cannot_be_read_completes_nothing(self, tmp_path: Path) -> None:
        files = SHOT | {"shot.usda": "version https://git-lfs.github.com/spec/v1\n"}
        report = linted(tmp_path, files)
        assert [p.kind for p in report.problems] == ["lfs-pointer"]
        assert "unresolved-target" in [f.rule.id for f in report.findings]

    def test_links_lead_to_the_same_layer(self, tmp_path: Path) -> None:
        write(tmp_path / "store", SHOT)
        (tmp_path / "linked").symlink_to(tmp_path / "store")
        given = [str(tmp_path / "linked" / "shot.usda"), str(tmp_path / "store" / "render.usda")]
        assert told(lint(given, cwd=tmp_path)) == []

    def test_a_crate_is_no_stage_either(self, tmp_path: Path) -> None:
        write(tmp_path, SHOT)
        for name in ("render", "shot"):
            text = (tmp_path / f"{name}.usda").read_text().replace("render.usda", "render.usdc")
            made = Sdf.Layer.CreateAnonymous(".usdc")
            made.ImportFromString(text)
            made.Export(str(tmp_path / f"{name}.usdc"))
            (tmp_path / f"{name}.usda").unlink()
        assert told(lint([str(tmp_path)], cwd=tmp_path)) == []

    def test_a_baseline_of_the_layer_alone_is_stale_in_the_folder(self, tmp_path: Path) -> None:
        alone = linted(tmp_path, SHOT, "render.usda")
        known = Baseline({}).updated(alone)
        assert known.count == len(alone.findings) > 0
        assert known.stale(linted(tmp_path, SHOT)) == known.count


class TestReferences:
    SHOW = part(SCOPE.replace("        rel camera = </World/cam>\n", ""))
    USER = (
        'def "Render" (\n    references = @./show.usda@</Render>\n)\n{\n'
        '    over "final"\n    {\n        rel camera = </World/cam>\n    }\n}\n'
    )

    def test_a_render_spec_without_a_world_is_judged_where_it_is_used(self, tmp_path: Path) -> None:
        files = {
            "shot.usda": layer(text=self.USER + CAMERA.replace("over", "def")),
            "show.usda": self.SHOW,
        }
        assert told(linted(tmp_path, files, "show.usda")) != []
        assert told(linted(tmp_path, files)) == []

    def test_what_is_wrong_there_is_told_through_the_shot(self, tmp_path: Path) -> None:
        files = {
            "shot.usda": layer(text=self.USER + CAMERA.replace("over", "def")),
            "show.usda": self.SHOW.replace("color3f", "color9"),
        }
        assert told(linted(tmp_path, files)) == ["unknown-data-type show.usda in shot.usda"]

    def test_a_target_outside_is_told_where_it_is_lost(self, tmp_path: Path) -> None:
        """Nobody names the camera anew, so USD drops it."""
        files = {
            "shot.usda": layer(text=self.USER.replace("</World/cam>", "</World/other>") + LAYOUT),
            "show.usda": part(SCOPE),
        }
        files["shot.usda"] = files["shot.usda"].replace("rel camera = </World/other>", "")
        report = linted(tmp_path, files)
        assert "target-outside-reference show.usda in shot.usda" in told(report)

    def test_a_shot_that_lends_its_scope_is_still_a_stage(self, tmp_path: Path) -> None:
        files = {
            "a.usda": layer(text=SCOPE + LAYOUT, default=False),
            "b.usda": layer(text=self.USER.replace("show", "a") + CAMERA.replace("over", "def")),
        }
        assert told(linted(tmp_path, files)) == [
            "default-settings-unset a.usda in a.usda",
            "unresolved-target a.usda in a.usda",
        ]

    def test_a_stage_that_takes_a_part_of_it_does_not_judge_the_rest(self, tmp_path: Path) -> None:
        text = self.SHOW.replace("color3f", "color9")
        takes = 'def Scope "Render"\n{\n    def "p" (\n        references = @./show.usda@</Render/beauty>\n    )\n    {\n    }\n}\n'
        found = told(linted(tmp_path, {"shot.usda": layer(text=takes), "show.usda": text}))
        assert "unknown-data-type show.usda in show.usda" in found


def fifty(folder: Path) -> None:
    """Shots in layers under git. The odd ones take the render layer of their sequence."""
    files = {"seq/render.usda": part(SCOPE)}
    for n in range(50):
        shot = f"shots/sh{n:03}"
        render = "../../seq/render.usda" if n % 2 else "./layers/render.usda"
        names = [render, *(f"./layers/{name}.usda" for name in ("camera", "layout"))]
        extras = [f"./layers/extra{k}.usda" for k in range(6)]
        files[f"{shot}/shot.usda"] = layer(*names, *extras)
        files[f"{shot}/layers/camera.usda"] = SHOT["camera.usda"]
        files[f"{shot}/layers/layout.usda"] = SHOT["layout.usda"]
        for extra in extras:
            files[f"{shot}/{extra[2:]}"] = part('over "World"\n{\n}\n')
        if not n % 2:
            files[f"{shot}/layers/render.usda"] = SHOT["render.usda"]
    write(folder, files)
    subprocess.run(["git", "init", "-q"], cwd=folder, check=True)


SHOTS = ("shots/*/*.usda",)
BROKEN = {
    "renamed": {"camera.usda": part(RENAMED)},
    "emptied": {"camera.usda": part("")},
    "inactive": {"camera.usda": part(CAMERA.replace('"cam"', '"cam" (active = false)'))},
    "inactive above": {"camera.usda": part(CAMERA.replace('"World"', '"World" (active = false)'))},
    "of another type": {"camera.usda": part(CAMERA.replace("Camera", "Xform"))},
    "only an over": {"camera.usda": part(CAMERA.replace("def Camera", "over"))},
    "does not parse": {"camera.usda": part('def "x" {')},
    "overrides": {"camera.usda": part(CAMERA + BAD_VAR)},
    "a mistake of its own": {
        "camera.usda": part(
            CAMERA.replace("    {\n    }", "    {\n        float focalLength = -1\n    }")
        )
    },
}


class TestRoots:
    @pytest.fixture
    def opened(self, monkeypatch: pytest.MonkeyPatch) -> list[str]:
        """All stages that a run opens."""
        seen: list[str] = []
        real = lint_module._lint_file

        def noted(file: lint_module.File, *rest: object) -> lint_module.FileResult:
            seen.append(file.shown)
            return real(file, *rest)  # type: ignore[arg-type]

        monkeypatch.setattr(lint_module, "_lint_file", noted)
        return seen

    @pytest.mark.parametrize("roots", [SHOTS, ("shots/*/shot.usda",), ("**/shot.usda",)])
    def test_one_broken_camera_layer_of_fifty_shots(
        self, tmp_path: Path, opened: list[str], roots: tuple[str, ...]
    ) -> None:
        fifty(tmp_path)
        changed = ["shots/sh007/layers/camera.usda", "shots/sh008/layers/camera.usda"]
        silent = linted(tmp_path, {}, *changed, roots=roots)
        assert (told(silent), silent.notes) == ([], ())
        assert silent.through == ("shots/sh007/shot.usda", "shots/sh008/shot.usda")
        assert sorted(opened) == sorted([*changed, *silent.through])
        write(tmp_path, dict.fromkeys(changed, part(RENAMED)))
        report = linted(tmp_path, {}, *changed, roots=roots)
        assert told(report) == [
            "unresolved-target seq/render.usda in shots/sh007/shot.usda",
            "unresolved-target shots/sh008/layers/render.usda in shots/sh008/shot.usda",
        ]
        assert report.files == tuple(changed)
        backwards = linted(tmp_path, {}, *reversed(changed), roots=roots)
        assert backwards.findings == report.findings

    def test_a_layer_of_the_sequence_is_seen_through_all_of_its_shots(self, tmp_path: Path) -> None:
        fifty(tmp_path)
        write(tmp_path, {"shots/sh003/layers/camera.usda": part(RENAMED)})
        report = linted(tmp_path, {}, "seq/render.usda", roots=SHOTS)
        assert len(report.through) == 25
        assert told(report) == ["unresolved-target seq/render.usda in shots/sh003/shot.usda"]
        write(tmp_path, {"seq/render.usda": part(SCOPE.replace("color3f", "color9"))})
        (finding, other) = linted(tmp_path, {}, "seq/render.usda", roots=SHOTS).findings
        assert {finding.rule.id, other.rule.id} == {"unresolved-target", "unknown-data-type"}
        assert len(finding.roots) + len(other.roots) == 26

    def test_the_folder_needs_no_roots_and_they_change_nothing(self, tmp_path: Path) -> None:
        fifty(tmp_path)
        write(tmp_path, {"shots/sh003/layers/camera.usda": part(RENAMED)})
        bare = linted(tmp_path, {}, ".")
        assert told(bare) == ["unresolved-target seq/render.usda in shots/sh003/shot.usda"]
        assert linted(tmp_path, {}, ".", roots=SHOTS).findings == bare.findings

    @pytest.mark.parametrize("change", BROKEN, ids=str)
    def test_whatever_breaks_the_shot_is_told_of_the_layer(
        self, tmp_path: Path, change: str
    ) -> None:
        assert told(linted(tmp_path, SHOT, "camera.usda", roots=("shot.usda",))) == []
        files = SHOT | BROKEN[change]
        # Stronger than what it overrides.
        files["shot.usda"] = layer("./camera.usda", "./render.usda", "./layout.usda")
        whole = told(linted(tmp_path, files, "shot.usda"))
        assert whole != []
        found = told(linted(tmp_path, files, "camera.usda", roots=("shot.usda",)))
        assert [one.replace("camera.usda shot.usda", "shot.usda") for one in found] == whole

    def test_what_another_layer_breaks_waits_for_that_layer(self, tmp_path: Path) -> None:
        files = SHOT | {"render.usda": part(SCOPE.replace("color3f", "color9"))}
        report = linted(tmp_path, files, "camera.usda", roots=("shot.usda",))
        assert told(report) == []
        assert told(linted(tmp_path, files, "render.usda", roots=("shot.usda",))) == [
            "unknown-data-type render.usda in shot.usda"
        ]

    def test_what_is_missing_is_told_of_each_layer_that_may_have_held_it(
        self, tmp_path: Path
    ) -> None:
        members = (
            '    def RenderPass "p" (\n        prepend apiSchemas = ["CollectionAPI:matte"]\n    )\n    {\n'
            "        rel renderSource = </Render/final>\n"
            "        rel collection:matte:includes = </World/table>\n    }\n"
        )
        render = SCOPE.replace('def Scope "Vars"', members.lstrip() + '    def Scope "Vars"')
        files = SHOT | {"render.usda": part(render), "look.usda": part("")}
        files["shot.usda"] = layer("./render.usda", "./camera.usda", "./layout.usda", "./look.usda")
        whole = told(linted(tmp_path, files, "shot.usda"))
        assert len(whole) == 1
        assert told(linted(tmp_path, files, "layout.usda", roots=("shot.usda",))) == whole
        # It is a warning, and says nothing of what stands above the missing prim.
        assert told(linted(tmp_path, files, "look.usda", roots=("shot.usda",))) == []

    def test_an_override_of_what_the_layer_has_renamed(self, tmp_path: Path) -> None:
        over = 'over "Render"\n{\n    over "beauty"\n    {\n    }\n}\n'
        names = [f"./{name}" for name in ("overs.usda", *SHOT) if name != "shot.usda"]
        files = SHOT | {"shot.usda": layer(*names), "overs.usda": part(over)}
        assert told(linted(tmp_path, files, "render.usda", roots=("shot.usda",))) == []
        files["render.usda"] = part(SCOPE.replace("/beauty>", "/b>").replace('"beauty"', '"b"'))
        found = told(linted(tmp_path, files, "render.usda", roots=("shot.usda",)))
        assert found == ["dangling-over overs.usda in shot.usda"]

    def test_roots_are_known_by_their_layers(self, tmp_path: Path) -> None:
        """What a wildcard matches and another root sublayers is a layer; what is spelled out is a
        root."""
        lone = "default-settings-unset render.usda in render.usda"
        assert told(linted(tmp_path, SHOT, roots=("*.usda",))) == []
        both = ("shot.usda", "render.usda")
        assert lone in told(linted(tmp_path, SHOT, roots=both))
        assert lone in told(linted(tmp_path, SHOT, "render.usda", roots=both))

    def test_a_root_that_references_the_layer(self, tmp_path: Path) -> None:
        data_type = '            uniform token dataType = "color3f"\n'
        show = TestReferences.SHOW.removeprefix("#usda 1.0").replace(data_type, "")
        files = {
            "shot.usda": layer(text=TestReferences.USER + CAMERA.replace("over", "def")),
            "show.usda": layer("./vars.usda", text=show, default=False),
            "vars.usda": part(BAD_VAR),
        }
        report = linted(tmp_path, files, "vars.usda", roots=("shot.usda",))
        assert told(report) == ["unknown-data-type vars.usda in shot.usda"]

    @pytest.mark.parametrize("text", ["crate", "expression"])
    def test_a_root_that_does_not_tell_its_layers_is_opened(
        self, tmp_path: Path, text: str
    ) -> None:
        write(tmp_path, SHOT | {"camera.usda": part(RENAMED)})
        if text == "crate":
            made = Sdf.Layer.CreateAnonymous(".usdc")
            made.ImportFromString(
                layer(*SHOT, text='def "a" (references = @./x.usda@)\n{\n}\n').replace(
                    "@shot.usda@, ", ""
                )
            )
            made.Export(str(tmp_path / "shot.usdc"))
            root = "shot.usdc"
        else:
            header = layer('`"${C}.usda"`', "./render.usda", "./layout.usda").replace(
                "(\n", '(\n    expressionVariables = { string C = "camera" }\n', 1
            )
            write(tmp_path, {"shot.usda": header})
            root = "shot.usda"
        found = told(linted(tmp_path, {}, "camera.usda", roots=(root,)))
        assert found == [f"unresolved-target render.usda in {root}"]

    def test_a_root_that_was_opened_in_vain_says_nothing(self, tmp_path: Path) -> None:
        other = layer('`"${GONE}.usda"`', text=SCOPE + LAYOUT)
        files = SHOT | {"other.usda": other}
        report = linted(tmp_path, files, "camera.usda", roots=("shot.usda", "other.usda"))
        assert told(report) == []
        assert report.through == ("shot.usda",)

    @pytest.mark.parametrize(
        ("text", "kind"),
        [("version https://git-lfs.github.com/spec/v1\n", "lfs-pointer"), ("", "unreadable-file")],
    )
    def test_a_root_that_cannot_be_read_may_use_the_layer(
        self, tmp_path: Path, text: str, kind: str
    ) -> None:
        files = SHOT | {"other.usda": text}
        report = linted(tmp_path, files, "camera.usda", roots=("shot.usda", "other.usda"))
        assert [(p.path, p.kind) for p in report.problems] == [("other.usda", kind)]
        assert report.through == ("shot.usda",)

    def test_roots_without_effect_are_told(self, tmp_path: Path) -> None:
        files = SHOT | {"old.usda": part(SCOPE)}
        report = linted(tmp_path, files, "old.usda", roots=("shot.usda", "no/*.usda"))
        assert "default-settings-unset old.usda in old.usda" in told(report)
        assert report.notes == (
            "no file matches the root 'no/*.usda'",
            "no root uses old.usda, which is linted as a stage of its own",
        )

    def test_what_stands_outside_the_render_spec_is_used_too(self, tmp_path: Path) -> None:
        files = SHOT | {
            "layout.usda": part(
                'def "World"\n{\n    def "t" (references = @./tree.usda@)\n    {\n    }\n}\n'
            ),
            "tree.usda": part('def "tree"\n{\n}\n'),
        }
        report = linted(tmp_path, files, "tree.usda", roots=("shot.usda",))
        assert (told(report), report.notes, report.through) == ([], (), ())

    def test_a_root_that_cannot_be_linted_leaves_the_run_incomplete(self, tmp_path: Path) -> None:
        files = SHOT | {"layout.usda": "version https://git-lfs.github.com/spec/v1\n"}
        report = linted(tmp_path, files, "camera.usda", roots=("shot.usda",))
        assert [p.path for p in report.problems] == ["layout.usda"]

    IGNORE = "  # usdrender-lint: ignore[unresolved-target]"

    def test_a_suppression_is_idle_only_if_it_is_in_all_roots(self, tmp_path: Path) -> None:
        camera = "        rel camera = </World/cam>"
        files = SHOT | {
            "render.usda": part(SCOPE.replace(camera, camera + self.IGNORE)),
            "other.usda": layer("./render.usda"),
        }
        needed = linted(tmp_path, files, "render.usda", roots=("shot.usda", "other.usda"))
        assert told(needed) == []
        assert [f.roots for f in needed.suppressed] == [("other.usda",)]

    def test_a_baseline_hides_what_is_seen_through_a_root(self, tmp_path: Path) -> None:
        files = SHOT | {"camera.usda": part(RENAMED)}
        known = Baseline({}).updated(linted(tmp_path, files, "shot.usda"))
        seen = linted(tmp_path, files, "camera.usda", roots=("shot.usda",))
        assert known.hide(seen).findings == ()
        assert known.stale(seen) == 0
        # Nor is anything pruned of a layer that was not asked about.
        write(tmp_path, SHOT)
        assert known.stale(linted(tmp_path, {}, "camera.usda", roots=("shot.usda",))) == 0
        assert known.stale(linted(tmp_path, {}, "render.usda", roots=("shot.usda",))) == 1


class TestAlone:
    @pytest.mark.parametrize("where", ["", "layers/"])
    def test_a_stage_beside_or_above_that_completes_it_is_named(
        self, tmp_path: Path, where: str
    ) -> None:
        names = [f"./{where}{name}.usda" for name in ("render", "camera")]
        files = {
            "shot.usda": layer(*names),
            f"{where}render.usda": SHOT["render.usda"],
            f"{where}camera.usda": SHOT["camera.usda"],
        }
        report = linted(tmp_path, files, f"{where}render.usda")
        assert report.findings != ()
        for finding in report.findings:
            assert finding.help.startswith("it is right in shot.usda, which sublayers this layer")

    def test_a_stage_that_lacks_the_same_is_not(self, tmp_path: Path) -> None:
        files = SHOT | {"camera.usda": part(RENAMED)}
        helps = {f.rule.id: f.help for f in linted(tmp_path, files, "render.usda").findings}
        assert "shot.usda" not in helps["unresolved-target"]
        assert "shot.usda" in helps["default-settings-unset"]

    def test_a_stage_of_which_a_part_is_missing_is_not(self, tmp_path: Path) -> None:
        files = SHOT | {"shot.usda": layer("./render.usda", "./gone.usda")}
        for finding in linted(tmp_path, files, "render.usda").findings:
            assert "shot.usda" not in finding.help

    def test_few_files_are_looked_at(self, tmp_path: Path) -> None:
        many = {f"a{n:03}.usda": part("") for n in range(100)}
        report = linted(tmp_path, SHOT | many, "render.usda")
        assert all("shot.usda" not in finding.help for finding in report.findings)


class TestConfigured:
    """By the command line, with a configuration above."""

    @pytest.fixture
    def call(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> Call:
        monkeypatch.chdir(tmp_path)

        def run(*args: str) -> tuple[int, str, str]:
            code = main(["--output-format", "concise", *args])
            return code, *capsys.readouterr()

        return run

    ROOTS = 'roots = ["shots/*/shot.usda"]\n'

    @pytest.fixture
    def show(self, tmp_path: Path) -> Path:
        fifty(tmp_path)
        (tmp_path / "usdrender-lint.toml").write_text(self.ROOTS)
        return tmp_path

    CAMERA = "shots/sh007/layers/camera.usda"

    def test_a_hook_on_a_commit(self, show: Path, call: Call) -> None:
        assert call(self.CAMERA) == (0, "No findings in 1 file, seen through 1 stage.\n", "")
        write(show, {self.CAMERA: part(RENAMED)})
        code, out, err = call(self.CAMERA)
        assert (code, err) == (1, "")
        assert out.splitlines() == [
            "seq/render.usda:7:22: error[unresolved-target] camera </World/cam> does not exist "
            "</Render/final.camera> (in shots/sh007/shot.usda)",
            "1 finding (1 error) in 1 file, seen through 1 stage.",
        ]

    def test_roots_count_from_the_folder_of_the_configuration(
        self, show: Path, call: Call, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        write(show, {self.CAMERA: part(RENAMED)})
        monkeypatch.chdir(show / "shots" / "sh007" / "layers")
        code, out, err = call("camera.usda")
        assert (code, err) == (1, "")
        assert "seen through 1 stage" in out

    def test_what_roots_do_not_do_is_told_on_standard_error(self, show: Path, call: Call) -> None:
        write(show, {"old.usda": part(""), "usdrender-lint.toml": 'roots = ["shot/*.usda"]\n'})
        assert call("old.usda")[2] == "note: no file matches the root 'shot/*.usda'\n"
        write(show, {"usdrender-lint.toml": self.ROOTS})
        note = "note: no root uses old.usda, which is linted as a stage of its own\n"
        assert call("old.usda") == (0, "No findings in 1 file.\n", note)
        assert call("-q", "old.usda") == (0, "", "")

    @pytest.mark.parametrize(("gate", "code"), [("error", 1), ("never", 0)])
    def test_the_gate_of_the_configuration_counts(
        self, show: Path, call: Call, gate: str, code: int
    ) -> None:
        write(show, {"usdrender-lint.toml": f'{self.ROOTS}fail-on = "{gate}"\n'})
        write(show, {self.CAMERA: part(RENAMED)})
        assert call(self.CAMERA)[0] == code

    def test_its_baseline_hides_what_is_known_of_the_stage(self, show: Path, call: Call) -> None:
        write(show, {"usdrender-lint.toml": f'{self.ROOTS}baseline = "known.json"\n'})
        write(show, {self.CAMERA: part(RENAMED)})
        assert call("--update-baseline", "shots")[0] == 0
        seen = "No findings in 1 file, seen through 1 stage; 1 in the baseline.\n"
        assert call(self.CAMERA) == (0, seen, "")
        # It is hidden where it is known, and told where it is new.
        other = self.CAMERA.replace("sh007", "sh008")
        write(show, {other: part(RENAMED)})
        assert call(self.CAMERA, other)[0] == 1

    def test_a_layer_falls_to_the_shard_of_its_stage(self, show: Path, call: Call) -> None:
        """Elsewhere it would be judged by itself."""
        (show / "usdrender-lint.toml").unlink()
        runs = [call("--shard", f"{n}/3", ".") for n in (1, 2, 3)]
        assert [(code, err) for code, _, err in runs] == [(0, "")] * 3
        counted = [int(out.split()[3]) for _, out, _ in runs]
        assert min(counted) > 0
        assert sum(counted) == len([*show.rglob("*.usda")])
