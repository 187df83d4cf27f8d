"""Are the files that somebody means linted, all of them and no others?"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from io import BytesIO, TextIOWrapper
from pathlib import Path

import pytest

from shows import CLEAN, FAILED, Call, Run, Write, call, found, show, write
from usdrender_lint.config.find import Configurations, absolute
from usdrender_lint.discover import RealPaths, Shard, Shown, discover

__all__ = ["call", "show", "write"]  # fixtures

Here = pytest.MonkeyPatch


def shown(run: Run) -> list[str]:
    return run.out.splitlines()


# Searching folders


def test_usd_files_at_any_depth_and_no_others(call: Call, write: Write) -> None:
    for name in ("a.usd", "b/c.usda", "b/d/e.USDC", "f.usdz", "g.txt", "usda", "b/h.usda.bak"):
        write(name)
    assert shown(call("--show-files", ".")) == ["a.usd", "b/c.usda", "b/d/e.USDC", "f.usdz"]


def test_hidden_ones_are_not_searched_for(call: Call, write: Write) -> None:
    for name in (".hidden.usda", ".cache/a.usda", "b.usda"):
        write(name)
    assert shown(call("--show-files", ".")) == ["b.usda"]
    assert shown(call("--show-files", ".hidden.usda", ".cache")) == [
        ".cache/a.usda",
        ".hidden.usda",
    ]


def test_each_file_once(call: Call, write: Write, show: Path) -> None:
    write("a/x.usda")
    (show / "a" / "y.usda").symlink_to("x.usda")
    (show / "b").symlink_to("a")
    assert shown(call("--show-files", ".", "a", "a/x.usda", str(show))) == ["a/x.usda"]
    assert len(shown(call("--show-files", "b", "a"))) == 1


def test_loops_of_links_end(call: Call, write: Write, show: Path) -> None:
    write("a/x.usda")
    (show / "a" / "up").symlink_to("..")
    (show / "a" / "itself").symlink_to("itself")
    (show / "a" / "itself.usda").symlink_to("itself.usda")
    (show / "a" / "folder.usda").symlink_to("../a")
    run = call("--show-files", ".")
    assert shown(run) == ["a/itself.usda", "a/x.usda"]
    assert call(".").code == 2


def test_a_link_to_a_folder_that_is_named_is_searched(call: Call, write: Write, show: Path) -> None:
    write("v003/x.usda")
    (show / "latest").symlink_to("v003")
    assert shown(call("--show-files", "latest")) == ["latest/x.usda"]


def test_a_folder_without_usd_is_no_success(call: Call, write: Write) -> None:
    write("a/x.txt")
    run = call("a")
    assert run.code == 2
    assert "error: a: no USD file in this folder or below it" in run.err


def test_a_path_before_a_link_and_dots(write: Write, show: Path, monkeypatch: Here) -> None:
    """`link/..` is where the link leads to, not where it stands."""
    write("real/deep/x.usda")
    (show / "real" / "y.usda").touch()
    (show / "link").symlink_to("real/deep")
    monkeypatch.chdir(show)
    assert absolute("link/../y.usda") == str(show / "real" / "y.usda")
    assert absolute("link/x.usda") == str(show / "link" / "x.usda")
    assert absolute("real/../real/y.usda") == str(show / "real" / "y.usda")
    assert absolute("none/../real/y.usda") == str(show / "real" / "y.usda")


def test_a_folder_is_looked_into_once_and_its_files_not_at_all(
    write: Write, show: Path, monkeypatch: Here
) -> None:
    for folder in ("a", "b/c"):
        for number in range(20):
            write(f"{folder}/{number}.usda")
    scanned: list[str] = []
    scandir = os.scandir
    monkeypatch.setattr(os, "scandir", lambda path: scanned.append(path) or scandir(path))
    stat: list[str] = []
    for name in ("stat", "lstat"):
        real = getattr(os, name)

        def counted(
            path: object, *args: object, real: Callable[..., object] = real, **more: object
        ) -> object:
            stat.append(str(path))
            return real(path, *args, **more)

        monkeypatch.setattr(os, name, counted)
    result = discover([str(show)], Shown(), Configurations())
    assert len(result.files) == 40
    assert sorted(scanned) == sorted(str(show / f) for f in ("", "a", "b", "b/c"))
    assert [path for path in stat if path.endswith(".usda")] == []
    # What is asked about folders: what holds in the first one, and where each really is.
    assert len(stat) <= 40


ODD = [
    "a/x.usda",
    "a/gone.usda",
    "gone/x.usda",
    "a",
    ".",
    "",
    "a/..",
    "a/.",
    "a//x.usda",
    "b/../a/x.usda",
]
"""Names of files and folders, as they are written on a command line."""


@pytest.mark.skipif(os.name == "nt", reason="links need rights there")
def test_links_are_resolved_as_the_system_resolves_them(show: Path, write: Write) -> None:
    write("a/x.usda")
    write("b/y.usda")
    (show / "b/link.usda").symlink_to(show / "a/x.usda")
    (show / "latest").symlink_to("a")
    (show / "b/loop").symlink_to("loop")
    real = RealPaths()
    links = [
        "b/link.usda",
        "latest/x.usda",
        "latest",
        "latest/../a/x.usda",
        "b/loop",
        "b/loop/x.usda",
    ]
    for name in (*ODD, *links):
        for path in (f"{show}/{name}", name):
            assert real[path] == os.path.realpath(path)


def test_paths_are_shown_from_the_root(show: Path) -> None:
    shown = Shown(show)
    for name in (*ODD, "../beside.usda", f"../{show.name}2/x.usda"):
        path = f"{show}/{name}"
        expected = os.path.relpath(path, show).replace(os.sep, "/")
        assert shown(path) == shown(Path(path)) == expected


# Excluding


EXCLUDED = [
    (["*_old.usda"], ["a/x.usda", "cache/y.usda"]),
    (["cache/"], ["a/x.usda", "a/x_old.usda"]),
    (["cache"], ["a/x.usda", "a/x_old.usda"]),
    (["/a/x.usda"], ["a/x_old.usda", "cache/y.usda"]),
    (["a/*", "!a/x.usda"], ["a/x.usda", "cache/y.usda"]),
    (["a", "!a/x.usda"], ["cache/y.usda"]),
    (["x.usda/"], ["a/x.usda", "a/x_old.usda", "cache/y.usda"]),
    (["**/*_old.*", "cache/**"], ["a/x.usda"]),
]


@pytest.mark.parametrize(("patterns", "left"), EXCLUDED)
@pytest.mark.parametrize("where", ["option", "exclude", "extend-exclude"])
def test_excluded(
    where: str, patterns: list[str], left: list[str], call: Call, write: Write
) -> None:
    """Named or found: pre-commit passes names."""
    names = ["a/x.usda", "a/x_old.usda", "cache/y.usda"]
    for name in names:
        write(name)
    options = []
    if where == "option":
        options = [part for pattern in patterns for part in ("--exclude", pattern)]
    else:
        write("usdrender-lint.toml", f"{where} = {json.dumps(patterns)}")
    assert shown(call("--show-files", ".", *options)) == left
    assert shown(call("--show-files", *names, *options)) == left
    assert shown(call("--show-files", "a", "cache", *options)) == left


def test_each_file_by_its_own_configuration(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", 'exclude = ["x.usda", "b"]')
    write("a/usdrender-lint.toml", 'exclude = ["y.usda"]')
    for name in ("x.usda", "y.usda", "a/x.usda", "a/y.usda", "a/b/z.usda", "b/z.usda"):
        write(name)
    assert shown(call("--show-files", ".")) == ["a/b/z.usda", "a/x.usda", "y.usda"]


def test_the_option_adds_to_the_configuration(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", 'exclude = ["a"]')
    for name in ("a/x.usda", "b/x.usda", "c/x.usda"):
        write(name)
    assert shown(call("--show-files", ".", "--exclude", "b")) == ["c/x.usda"]


def test_the_option_counts_from_the_current_folder(
    call: Call, write: Write, show: Path, monkeypatch: Here
) -> None:
    write("a/x.usda")
    write("b/a/x.usda")
    monkeypatch.chdir(show / "b")
    assert shown(call("--show-files", str(show), "--exclude", "/a/")) == [str(show / "a/x.usda")]


def test_a_pattern_that_means_nothing_is_told(call: Call) -> None:
    run = call("--exclude", "a[b", ".")
    assert run.code == 2
    assert "'[' is never closed" in run.err


def test_what_is_excluded_counts_as_nothing(call: Call, write: Write) -> None:
    write("a.usda", CLEAN)
    write("b.usda", FAILED)
    run = call("a.usda", "b.usda", "--exclude", "b.usda")
    assert run.code == 0
    assert "No findings in 1 file" in run.out
    assert run.err == ""
    assert "note: b.usda is excluded\n" in call("a.usda", "b.usda", "--exclude", "b.usda", "-v").err


@pytest.mark.parametrize("paths", [["cache/a.usda"], ["cache"], ["."]])
def test_that_all_are_excluded_is_told(paths: list[str], call: Call, write: Write) -> None:
    write("cache/a.usda", FAILED)
    run = call(*paths, "--exclude", "cache/")
    assert run.code == 0
    assert run.err == "note: no file was linted: all are excluded\n"
    assert run.out == "Nothing was linted.\n"


def test_what_is_missing_is_told_though_it_would_be_excluded(call: Call) -> None:
    run = call("cache/a.usda", "--exclude", "cache/")
    assert run.code == 2
    assert "no such file or folder" in run.err


# What git ignores


def test_what_git_ignores_is_not_searched(call: Call, write: Write, show: Path) -> None:
    write(".gitignore", "out/\n*.usdc\n")
    write("a/.gitignore", "!keep.usdc\n/top.usda\n")
    write(".git/info/exclude", "mine.usda\n")
    for name in (
        *("out/x.usda", "x.usdc", "a/keep.usdc", "a/top.usda", "a/b/top.usda", "mine.usda"),
        *("a/mine.usda", "y.usda"),
    ):
        write(name)
    assert shown(call("--show-files", ".")) == ["a/b/top.usda", "a/keep.usdc", "y.usda"]
    assert shown(call("--show-files", "a")) == ["a/b/top.usda", "a/keep.usdc"]
    assert len(shown(call("--show-files", "--no-gitignore", "."))) == 8


def test_what_is_named_is_linted_though_git_ignores_it(call: Call, write: Write) -> None:
    write(".gitignore", "out/\n")
    write("out/x.usda")
    assert shown(call("--show-files", "out/x.usda")) == ["out/x.usda"]
    assert shown(call("--show-files", "out")) == ["out/x.usda"]


def test_that_git_ignores_all_is_no_success(call: Call, write: Write) -> None:
    """Nobody has said that these are not to be linted."""
    write(".gitignore", "*.usda\n")
    write("a/x.usda", CLEAN)
    run = call("a")
    assert run.code == 2
    assert (
        "git ignores all that may be USD in this folder: name the files, or --no-gitignore"
        in run.err
    )
    assert call("a", "--no-gitignore").code == 0


def test_without_a_repository_nothing_is_ignored(
    call: Call, tmp_path: Path, monkeypatch: Here
) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / ".gitignore").write_text("*.usda")
    (tmp_path / "a" / "x.usda").touch()
    monkeypatch.chdir(tmp_path)
    assert shown(call("--show-files", "a")) == ["a/x.usda"]


def test_a_repository_within_is_one_of_its_own(call: Call, write: Write) -> None:
    write(".gitignore", "*.usda\n")
    write("usdrender-lint.toml", 'exclude = ["y.usdc"]')
    write("sub/.git", "gitdir: ../.git/modules/sub\n")
    write(".git/modules/sub/info/exclude", "mine.usda\n")
    write("sub/.gitignore", "z.usda\n")
    for name in ("sub/x.usda", "sub/y.usdc", "sub/deep/z.usda", "sub/mine.usda", "x.usda"):
        write(name)
    assert shown(call("--show-files", ".")) == ["sub/x.usda", "sub/y.usdc"]


def test_the_same_files_as_git_lists(
    call: Call, write: Write, tmp_path: Path, monkeypatch: Here
) -> None:
    folder = tmp_path / "repository"
    folder.mkdir()
    subprocess.run(["git", "init", "-q", folder], check=True)
    for name in ("a/b/x.usda", "a/b/y.usda", "a/c/x.usda", "d/x.usda", "d/e/f/x.usda", "x.usda"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).touch()
    (folder / ".gitignore").write_text("a/*/x.usda\n/d/*\n!/d/e\n")
    (folder / "a" / "b" / ".gitignore").write_text("!x.usda\ny*\n")
    (folder / "d" / "e" / ".gitignore").write_text("# none\n/f/../f\n")
    told = subprocess.run(
        ["git", "-C", folder, "ls-files", "-co", "--exclude-standard", "*.usda"],
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    monkeypatch.chdir(folder)
    assert shown(call("--show-files", ".")) == sorted(told.splitlines())


# Lists of files


@pytest.mark.parametrize(
    "data",
    [
        b"a.usda\nb c.usda\n",
        b"a.usda\r\n\r\nb c.usda",
        b"a.usda\0b c.usda\0",
        b"\xef\xbb\xbfa.usda\nb c.usda\n",
        "a.usda\r\nb c.usda\r\n".encode("utf-16"),
    ],
    ids=["lines", "windows", "nul", "bom", "utf-16"],
)
def test_a_list_of_files(data: bytes, call: Call, write: Write, monkeypatch: Here) -> None:
    for name in ("a.usda", "b c.usda", "d.usda"):
        write(name, CLEAN)
    write("list.txt").write_bytes(data)
    assert shown(call("--show-files", "--files-from", "list.txt")) == ["a.usda", "b c.usda"]
    assert len(shown(call("--show-files", "--files-from", "list.txt", "d.usda"))) == 3
    monkeypatch.setattr(sys, "stdin", TextIOWrapper(BytesIO(data)))
    assert shown(call("--show-files", "--files-from", "-")) == ["a.usda", "b c.usda"]


def test_a_name_with_a_line_break(call: Call, write: Write) -> None:
    write("a\nb.usda", CLEAN)
    write("list.txt").write_bytes(b"a\nb.usda\0")
    run = call("--show-files", "--files-from", "list.txt", "--output-format", "json")
    assert json.loads(run.out)["files"] == ["a\nb.usda"]


def test_what_a_list_names_must_be_there(call: Call, write: Write) -> None:
    write("a.usda", CLEAN)
    write("list.txt", "a.usda\nnone.usda\n")
    run = call("--files-from", "list.txt")
    assert run.code == 2
    assert "error: none.usda: no such file or folder" in run.err
    assert "1 file" in run.out


@pytest.mark.parametrize(
    ("name", "said"), [("none.txt", "cannot be read"), ("list.txt", "names no file")]
)
def test_a_list_that_names_nothing_is_no_success(
    name: str, said: str, call: Call, write: Write
) -> None:
    write("list.txt", "\n \n")
    run = call("--files-from", name)
    assert run.code == 2
    assert said in run.err


def test_without_paths_nothing_is_meant(call: Call) -> None:
    run = call()
    assert run.code == 2
    assert "Missing argument 'PATHS...'" in run.err


# Shards


def test_each_file_is_in_one_shard(call: Call, write: Write) -> None:
    names = [f"shots/sh{number:03}/x.usda" for number in range(60)]
    for name in names:
        write(name)
    parts = [shown(call("--show-files", ".", "--shard", f"{i}/4")) for i in (1, 2, 3, 4)]
    assert sorted(name for part in parts for name in part) == names
    assert all(5 <= len(part) <= 30 for part in parts)
    write("shots/new/x.usda")
    for number, part in enumerate(parts, 1):
        now = shown(call("--show-files", ".", "--shard", f"{number}/4"))
        assert set(part) <= set(now) <= {*part, "shots/new/x.usda"}


def test_a_shard_goes_by_the_path_alone() -> None:
    """The same on every machine, and in every version: farms start one each."""
    shards = [next(i for i in range(1, 6) if name in Shard(i, 5)) for name in "abcdefgh"]
    assert shards == [1, 2, 1, 5, 3, 3, 5, 3]


def test_an_empty_shard_is_told(call: Call, write: Write) -> None:
    write("x.usda", FAILED)
    runs = [call("x.usda", "--shard", f"{number}/3") for number in (1, 2, 3)]
    assert sorted(run.code for run in runs) == [0, 0, 1]
    for number, run in enumerate(runs, 1):
        if run.code == 0:
            assert run.err == f"note: no file was linted: shard {number} of 3 has none\n"


def test_a_missing_file_is_missing_in_every_shard(call: Call) -> None:
    assert {call("none.usda", "--shard", f"{number}/2").code for number in (1, 2)} == {2}


@pytest.mark.parametrize("value", ["", "1", "0/2", "3/2", "1/0", "-1/2", "a/b", "1/2/3", "½/2"])
def test_what_is_no_shard(value: str, call: Call) -> None:
    run = call("--shard", value, ".")
    assert run.code == 2
    assert f"'{value}' is not I/N, such as 1/4" in run.err


def test_a_shard_does_not_know_what_others_find(call: Call, write: Write) -> None:
    """A suppression that silences nothing here may silence something there."""
    marked = CLEAN.replace(
        "main_cam>\n", "main_cam>  # usdrender-lint: ignore[unresolved-target] x\n", 1
    )
    write("x.usda", marked)
    assert found(call("--output-format", "concise", "--fail-on", "note", "x.usda"))
    for number in (1, 2):
        assert call("--fail-on", "note", "x.usda", "--shard", f"{number}/2").code == 0


def test_a_baseline_is_not_updated_by_a_part(call: Call, write: Write) -> None:
    write("x.usda", CLEAN)
    run = call("--shard", "1/2", "--baseline", "b.json", "--update-baseline", "x.usda")
    assert run.code == 2
    assert "--update-baseline and --shard exclude each other" in run.err


def test_each_shard_has_a_category_of_its_own(call: Call, write: Write) -> None:
    write("x.usda", CLEAN)
    run = call("x.usda", "--shard", "2/4", "--output-format", "sarif")
    (told,) = json.loads(run.out)["runs"]
    assert told["automationDetails"] == {"id": "usdrender-lint/shard-2-of-4/"}


# What is shown


def test_paths_are_told_from_the_repository_of_what_is_named(
    call: Call, write: Write, show: Path, tmp_path: Path, monkeypatch: Here
) -> None:
    write("shots/x.usda", FAILED)
    for here in (show, show / "shots", tmp_path, Path("/")):
        monkeypatch.chdir(here)
        run = call("--output-format", "json", str(show / "shots"))
        assert json.loads(run.out)["findings"][0]["path"] == "shots/x.usda"


def test_what_would_not_be_found_is_told(call: Call, write: Write) -> None:
    write("x.usda")
    run = call("--show-files", "x.usda", "none.usda")
    assert run.code == 2
    assert run.out == "x.usda\n"
    assert run.err == "error: none.usda: no such file or folder\n"


def test_what_holds_and_who_says_so(call: Call, write: Write, show: Path) -> None:
    write("base.toml", '[severity]\ncamera = "note"\n\n[per-file-ignores]\n"a b/" = ["camera"]\n')
    write(
        "shots/usdrender-lint.toml",
        'extend = "../base.toml"\nignore = [\n  "product"]\nextend-exclude = ["cache/"]\n'
        'baseline = "known.json"\nfail-on = "error"\n',
    )
    run = call(
        *("--show-config", "shots", "--fail-on", "note", "--ignore", "var"),
        *("--exclude", "*_old.usda", "--severity", "missing-camera=error", "--scene"),
    )
    assert run.code == 0
    assert (
        run.out
        == """\
# shots: shots/usdrender-lint.toml, which extends base.toml
extend = "../base.toml"      # shots/usdrender-lint.toml:1
# no required-version        # default
select = ["default"]         # default
extend-select = []           # default
ignore = ["product", "var"]  # shots/usdrender-lint.toml:2, --ignore
fail-on = "note"             # --fail-on
renderer = "auto"            # default
renderers = []               # default
variants = false             # default
scene = true                 # --scene
scopes = ["/Render"]         # default
exclude = ["*_old.usda"]     # --exclude
extend-exclude = ["cache/"]  # shots/usdrender-lint.toml:4
baseline = "known.json"      # shots/usdrender-lint.toml:5
roots = []                   # default

[severity]
camera = "note"           # base.toml:2
missing-camera = "error"  # --severity

[per-file-ignores]
"a b/" = ["camera"]  # base.toml:5
"""
    )


def test_what_holds_as_data(call: Call, write: Write) -> None:
    write("a/usdrender-lint.toml", 'fail-on = "error"\n[severity]\ncamera = "note"\n')
    write("a/x.usda")
    write("b/x.usda")
    run = call("--show-config", "a/x.usda", "a", "b", "--output-format", "json")
    told = json.loads(run.out)
    assert told["version"] == 1
    first, second = told["configurations"]
    assert first["paths"] == ["a/x.usda", "a"]
    assert first["files"] == ["a/usdrender-lint.toml"]
    assert first["values"]["fail-on"] == {"value": "error", "from": ["a/usdrender-lint.toml:1"]}
    assert first["values"]["severity"] == {
        "camera": {"value": "note", "from": ["a/usdrender-lint.toml:3"]}
    }
    assert second["files"] == []
    assert second["values"]["fail-on"] == {"value": "warning", "from": ["default"]}


def test_the_current_folder_is_meant_where_none_is_named(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", 'fail-on = "error"')
    assert call("--show-config").out.startswith("# .: usdrender-lint.toml\n")
    assert call("--show-config", "--isolated").out.startswith("# .: no configuration\n")


def test_selecting_says_all_about_rules(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", 'extend-select = ["var"]\nignore = ["camera"]\n')
    told = json.loads(call("--show-config", "--select", "product", "--output-format", "json").out)
    values = told["configurations"][0]["values"]
    assert values["select"] == {"value": ["product"], "from": ["--select"]}
    assert values["extend-select"] == {"value": [], "from": ["default"]}
    assert values["ignore"] == {"value": [], "from": ["default"]}


def test_a_mistake_is_told_there_too(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", 'selct = ["var"]\n')
    write("x.usda")
    for option in ("--show-config", "--show-files"):
        run = call(option, "x.usda")
        assert run.code == 2
        assert run.out == ""
        assert "did you mean 'select'?" in run.err
