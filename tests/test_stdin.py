"""A layer on standard input is linted as the file that it is meant for."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from pxr import Sdf

from usdrender_lint.__main__ import main
from usdrender_lint.handed import handed_over

RENDER = """\
#usda 1.0
(
    renderSettingsPrimPath = "/Render/S"
    subLayers = [@./world.usda@]
)
def Scope "Render"
{
    def RenderSettings "S"
    {
        rel camera = </World/gone>
        rel products = </Render/P>
        uniform token renderingColorSpace = "QQQQ"
    }
    def RenderProduct "P"
    {
        token productName = ""  # usdrender-lint: ignore[empty-product-name] asked for later
        rel orderedVars = </Render/v>
    }
    def RenderVar "v"
    {
        string sourceName = "Ci"
    }
}
"""
WORLD = '#usda 1.0\ndef Xform "World"\n{\n    def Camera "cam"\n    {\n    }\n}\n'


@dataclass
class Answer:
    code: int
    out: str
    err: str

    @property
    def findings(self) -> list[tuple[object, ...]]:
        keys = ("path", "line", "column", "rule", "message")
        return [tuple(f[k] for k in keys) for f in json.loads(self.out)["findings"]]


Lint = Callable[..., Answer]


@pytest.fixture
def show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / ".git").mkdir()
    (tmp_path / "shots").mkdir()
    (tmp_path / "shots" / "world.usda").write_text(WORLD, "utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def lint(show: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Lint:
    def run(*args: str, data: str | bytes = "") -> Answer:
        held = data.encode() if isinstance(data, str) else data
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(held)))
        code = main(["--output-format", "json", *args])
        out, err = capsys.readouterr()
        return Answer(code, out, err)

    return run


def crate_of(text: str, folder: Path) -> bytes:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(text)
    layer.Export(str(folder / "kept.usdc"))
    return (folder / "kept.usdc").read_bytes()


@pytest.mark.parametrize("kind", ["text", "parse error", "latin-1", "no header"])
@pytest.mark.parametrize("saved", [True, False])
def test_the_same_text_gives_the_same_findings(
    lint: Lint, show: Path, kind: str, saved: bool
) -> None:
    data = {
        "text": RENDER.encode(),
        "parse error": RENDER.replace("rel camera", "camera").encode(),
        "latin-1": RENDER.replace("QQQQ", "\xe9").encode("latin-1"),
        "no header": RENDER.encode()[10:],
    }[kind]
    file = show / "shots" / "render.usda"
    file.write_bytes(data)
    by_file = lint("shots/render.usda")
    file.unlink()
    if saved:  # an older state, which nobody asks about
        file.write_text("#usda 1.0\n", "utf-8")
    by_stdin = lint("-", "--stdin-filename", "shots/render.usda", data=data)
    assert by_file.findings
    assert (by_stdin.code, by_stdin.out, by_stdin.err) == (by_file.code, by_file.out, by_file.err)


@pytest.mark.parametrize("name", ["render.usdc", "render.usd"])
def test_the_same_crate_gives_the_same_findings(
    lint: Lint, show: Path, tmp_path_factory: pytest.TempPathFactory, name: str
) -> None:
    data = crate_of(RENDER, tmp_path_factory.mktemp("elsewhere"))
    file = show / "shots" / name
    file.write_bytes(data)
    by_file = lint(f"shots/{name}")
    file.unlink()
    by_stdin = lint("-", "--stdin-filename", f"shots/{name}", data=data)
    assert by_file.findings
    assert (by_stdin.code, by_stdin.out, by_stdin.err) == (by_file.code, by_file.out, by_file.err)


def test_the_nameless_one(lint: Lint, tmp_path_factory: pytest.TempPathFactory) -> None:
    text = RENDER.replace("./world", "./shots/world")
    crate = crate_of(text, tmp_path_factory.mktemp("elsewhere"))
    told = {
        (path, rule)
        for data in (text, crate)
        for path, _, _, rule, _ in lint("-", data=data).findings
    }
    assert ("<stdin>", "unresolved-target") in told
    assert {path for path, _ in told} == {"<stdin>"}


def test_what_does_not_parse_is_told_as_well_without_a_name(lint: Lint) -> None:
    text = RENDER.replace("rel camera =", "rel camera")
    ((*place, rule, message),) = lint("-", data=text).findings
    assert (place, rule) == (["<stdin>", 10, 20], "syntax-error")
    assert message == "expected '=', found '<'"


def test_nameless_from_a_folder_below(
    lint: Lint, show: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(show / "shots")
    assert lint("-", data=RENDER).findings[0][0] == "<stdin>"


def test_beside_files_and_instead_of_the_saved_one(lint: Lint, show: Path) -> None:
    (show / "shots" / "render.usda").write_text("#usda 1.0\n", "utf-8")
    answer = lint("shots", "-", "--stdin-filename", "shots/render.usda", data=RENDER)
    assert json.loads(answer.out)["files"] == 2
    assert "shots/render.usda" in {path for path, *_ in answer.findings}


def test_a_stage_sees_what_is_handed_over(lint: Lint, show: Path) -> None:
    (show / "shot.usda").write_text(
        "#usda 1.0\n(\n    subLayers = [@./shots/render.usda@]\n)\n", "utf-8"
    )
    (show / "shots" / "render.usda").write_text("#usda 1.0\n", "utf-8")
    (show / "usdrender-lint.toml").write_text('roots = ["shot.usda"]\n', "utf-8")
    answer = lint("-", "--stdin-filename", "shots/render.usda", data=RENDER)
    (finding,) = (f for f in json.loads(answer.out)["findings"] if f["rule"] == "unresolved-target")
    assert (finding["path"], finding["root"]) == ("shots/render.usda", "shot.usda")


def test_the_configuration_of_the_name_holds(lint: Lint, show: Path) -> None:
    (show / "shots" / "usdrender-lint.toml").write_text('select = ["unresolved-target"]\n', "utf-8")
    answer = lint("-", "--stdin-filename", "shots/render.usda", data=RENDER)
    assert {rule for *_, rule, _ in answer.findings} == {"unresolved-target"}
    (show / "shots" / "usdrender-lint.toml").write_text('exclude = ["render.usda"]\n', "utf-8")
    answer = lint("-", "--stdin-filename", "shots/render.usda", data=RENDER)
    assert (answer.code, answer.findings) == (0, [])


def test_a_baseline_knows_it(lint: Lint) -> None:
    name = ("-", "--stdin-filename", "shots/render.usda", "--baseline", "known.json")
    lint(*name, "--update-baseline", data=RENDER)
    again = lint(*name, data=RENDER)
    assert (again.code, again.findings) == (0, [])


@pytest.mark.parametrize(
    ("data", "said"),
    [(b"", "the file is empty"), (b"PK\x03\x04", "a package cannot be linted from standard input")],
)
def test_what_cannot_be_linted_is_told(lint: Lint, data: bytes, said: str) -> None:
    answer = lint("-", data=data)
    (error,) = json.loads(answer.out)["errors"]
    assert (answer.code, error["path"], error["message"]) == (2, "<stdin>", said)


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["a.usda", "--stdin-filename", "b.usda"], "needs '-' among PATHS"),
        (["-", "--stdin-filename", "b.txt"], "no USD file by its name"),
        (["-", "--files-from", "-"], "exclude each other"),
    ],
)
def test_options_that_make_no_sense(lint: Lint, args: list[str], said: str) -> None:
    answer = lint(*args, data="x.usda\n")
    assert answer.code == 2
    assert said in answer.err


@pytest.mark.parametrize("jobs", ["0", "1", "2"])
@pytest.mark.parametrize("data", [RENDER, RENDER.replace("rel camera", "camera")])
def test_no_temporary_name_is_told(show: Path, jobs: str, data: str) -> None:
    """By a process of its own, which has workers."""
    text = data.replace("./world", "./gone")
    run = subprocess.run(
        [sys.executable, "-m", "usdrender_lint", "-v", "-j", jobs, "-"],
        input=text, capture_output=True, text=True, cwd=show, check=False,
    )  # fmt: skip
    assert run.returncode == 1
    assert "<stdin>" in run.stdout
    assert "/tmp" not in (run.stdout + run.stderr).replace(str(show), "")  # noqa: S108
    assert not handed_over()
