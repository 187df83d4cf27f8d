"""Do patterns mean what git takes them to mean?"""

from __future__ import annotations

import os
import random
import shutil
import subprocess
from pathlib import Path

import pytest

from usdrender_lint.patterns import PatternError, Patterns, check, lines_of

NAMES = ("a", "b", "ab", "abc", "c", ".a", "aab", "a b", "#a", "]", "a-c", "A")
ATOMS = (
    *("a", "b", "ab", "*", "?", "[ab]", "[!a]", "[^a]", "[a-c]", "\\a", "a*", "*b", ".a"),
    *("[[:alpha:]]", "[]a]", "a ", "\\ ", "#a", "\\#a", "[a\\-c]"),
)


@pytest.fixture(scope="module")
def repository(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str]]:
    """A folder of many small files, and their paths in it."""
    if not shutil.which("git"):
        pytest.skip("git is not there to be asked")
    folder = tmp_path_factory.mktemp("repository").resolve()
    subprocess.run(["git", "init", "-q", folder], check=True)
    chance = random.Random(0)  # noqa: S311 it guards nothing
    files = []
    for _ in range(300):
        path = "/".join(chance.choice(NAMES) for _ in range(chance.randint(1, 4)))
        file = folder / path
        if file.exists() or any((folder / p).is_file() for p in Path(path).parents):
            continue
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch()
        files.append(path)
    return folder, files


def some_pattern(chance: random.Random) -> str:
    parts = [
        "**"
        if chance.random() < 0.15
        else "".join(chance.choice(ATOMS) for _ in range(chance.choice((1, 1, 1, 2))))
        for _ in range(chance.randint(1, 3))
    ]
    # git tells several stars in a row from one, by accident of how it compares the beginning.
    parts = [part if part == "**" else part.replace("**", "*") for part in parts]
    start = chance.choice(("", "", "", "/")) + "/".join(parts)
    pattern = start + chance.choice(("", "", "/"))
    return ("!" if chance.random() < 0.2 else "") + pattern


@pytest.mark.parametrize("seed", range(40))
def test_the_same_files_as_git(seed: int, repository: tuple[Path, list[str]]) -> None:
    folder, files = repository
    chance = random.Random(seed)  # noqa: S311 it guards nothing
    text = "\n".join(some_pattern(chance) for _ in range(chance.randint(1, 4))) + "\n"
    (folder / ".gitignore").write_text(text, "utf-8")
    told = subprocess.run(
        ["git", "-C", folder, "check-ignore", "--no-index", "--stdin", "-z"],
        input="\0".join(files),
        capture_output=True,
        text=True,
        check=False,
    ).stdout
    patterns = Patterns(lines_of(text), str(folder))
    assert {f for f in files if str(folder / f) in patterns} == set(told.split("\0")) - {""}, text


def test_lines_of_a_file() -> None:
    text = "# what the renderer leaves\r\n\n*.exr  \ncache/\n\\#1\nname\\ \n"
    assert lines_of(text) == ["*.exr", "cache/", "\\#1", "name\\ "]


@pytest.mark.parametrize(
    ("pattern", "said"),
    [
        ("", "an empty pattern matches nothing"),
        (" ", "an empty pattern matches nothing"),
        ("/", "an empty pattern matches nothing"),
        ("!", "an empty pattern matches nothing"),
        ("a[b", "'[' is never closed"),
        ("a[b\\", "'[' is never closed"),
        ("a[[:vowel:]]", "'[:vowel:]]' begins no class of characters"),
        ("a\\", "a backslash at the end stands for nothing"),
    ],
)
def test_what_can_mean_nothing_is_told(pattern: str, said: str) -> None:
    with pytest.raises(PatternError) as error:
        check(pattern)
    assert str(error.value) == said


@pytest.mark.parametrize("pattern", ["a", "/a/", "!a", "**", "[]]", "[!]]", "a/**/b", "#"])
def test_what_means_something_is_not_told(pattern: str) -> None:
    check(pattern)


def test_a_file_elsewhere_is_known_by_its_whole_path() -> None:
    patterns = Patterns(["*_old.usda", "cache/", "/elsewhere/deep/"], "/show")
    assert "/elsewhere/a_old.usda" in patterns
    assert "/elsewhere/cache/a.usda" in patterns
    assert "/elsewhere/deep/a.usda" in patterns
    assert "/show/elsewhere/deep/a.usda" in patterns
    assert "/elsewhere/a.usda" not in patterns
    assert "/show/deep/a.usda" not in patterns


def test_the_folder_itself_is_not_meant() -> None:
    assert "/cache/show/a.usda" not in Patterns(["cache/"], "/cache/show")


def test_a_folder_is_known_by_the_name_behind_its_link(tmp_path: Path) -> None:
    """USD tells of layers by their real paths."""
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    patterns = Patterns(["/a.usda"], str(tmp_path / "link"))
    assert str(tmp_path / "link" / "a.usda") in patterns
    assert os.path.realpath(tmp_path / "link" / "a.usda") in patterns


def test_the_last_pattern_that_matches_decides() -> None:
    patterns = Patterns(["*.usda", "!keep.usda"], "/show")
    assert "/show/a/b.usda" in patterns
    assert "/show/a/keep.usda" not in patterns


def test_what_stands_in_an_excluded_folder_cannot_be_taken_back() -> None:
    assert "/show/a/keep.usda" in Patterns(["a/", "!keep.usda"], "/show")


def test_nothing_is_said() -> None:
    patterns = Patterns([], "/show")
    assert not patterns
    assert "/show/a.usda" not in patterns
    assert patterns.decide("/show/a.usda", is_folder=False) is None
