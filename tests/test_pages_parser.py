"""The form of a rule page, and how it looks on a terminal."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from usdrender_lint import pages
from usdrender_lint.model import Layer, RenderPrim, Scene
from usdrender_lint.report import explain
from usdrender_lint.rule import AnyRule, Rule, Severity

PAGE = """\
# unresolved-target

*error · camera · the render scope · on by default · since 0.1*

A renderer without a camera renders nothing. See `inputs:camera:exposure`,
[/Render/X] and </World>.

A second *paragraph*.

## Bad

Words before.

```usda
#usda 1.0
## not a heading
```

`weak.usda`:
```usda
over "World" {}
```

`sub/a b.usda`:

```usda
```

Another scene:

```usda
second
```

```console
$ not a scene
```

## Good

```usda
good
```

## When to ignore it

Never.

## See also

- <https://openusd.org/>
- [the schema](https://openusd.org/schema)
"""


def test_parts() -> None:
    page = pages.parse(PAGE)
    assert page.title == "unresolved-target"
    assert page.facts == "*error · camera · the render scope · on by default · since 0.1*"
    assert page.why.startswith("A renderer without a camera")
    assert page.why.endswith("\n\nA second *paragraph*.")
    assert tuple(page.sections) == pages.SECTIONS
    assert page.sections["When to ignore it"].text == "Never."


def test_cases() -> None:
    page = pages.parse(PAGE)
    first, second = page.cases("Bad")
    assert first.main == "#usda 1.0\n## not a heading\n"
    assert first.files == {"weak.usda": 'over "World" {}\n', "sub/a b.usda": ""}
    assert (second.main, second.files) == ("second\n", {})
    assert [case.main for case in page.cases("Good")] == ["good\n"]
    assert page.cases("See also") == ()


def test_a_case_knows_its_line() -> None:
    lines = PAGE.splitlines()
    for case in pages.parse(PAGE).cases("Bad"):
        assert lines[case.line - 1] == case.main.splitlines()[0]


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("# unresolved-target\n", "", "line 1: a page begins with '# rule-id'."),
        ("*error · camera · the render scope · on by default · since 0.1*", "", "line 3: the line"),
        ("A renderer", "## Why\n\nA renderer", "line 3: below the facts a page says why."),
        ("## Good", "### Good", "here are Bad, When to ignore it, See also."),
        ("## See also", "## Bad", "here are Bad, Good, When to ignore it, Bad."),
        ("Another scene:", "## More", "here are Bad, More, Good"),
        ("good\n```", "good\n", "line 41: this block is never closed."),
        ("#usda 1.0\n## not a heading\n```", "```usda", "line 14: this block is never closed."),
        ("Words before.", "`a.usda`:", "line 14: a.usda belongs to an unnamed block"),
        ("`sub/a b.usda`:", "`weak.usda`:", "line 26: this scene has a weak.usda already."),
        ("Another scene:", "`c.usda`:\n\nAnother scene:", "line 31: a block must follow the name"),
        ("$ not a scene\n```", "$ not a scene\n```\n`c.usda`:", "a block must follow the name"),
        ("```console", "`c.usda`:\n```console", "line 36: the block of c.usda must be marked"),
    ],
)
def test_a_malformed_page_is_refused(old: str, new: str, sentence: str) -> None:
    assert PAGE.count(old) == 1
    with pytest.raises(pages.MalformedPageError, match=re.escape(sentence)):
        pages.parse(PAGE.replace(old, new))


@pytest.mark.parametrize("text", ["", "\n", "text\n", "# a\n", "# a\n\n*b*\n", "# a\n\n*b*\n\nc\n"])
def test_a_page_that_is_cut_off_is_refused(text: str) -> None:
    with pytest.raises(pages.MalformedPageError):
        pages.parse(text)


def rule(
    on: type[Layer | RenderPrim | Scene] = RenderPrim,
    severity: Severity = Severity.ERROR,
    group: str = "camera",
    default: bool = True,
) -> AnyRule:
    return Rule("x", on, severity, "0.1", "", lambda *_: iter(()), group=group, default=default)


@pytest.mark.parametrize(
    ("made", "expected"),
    [
        (rule(), "*error · camera · the render scope · on by default · since 0.1*"),
        (
            rule(on=Layer, severity=Severity.NOTE, group="layers", default=False),
            "*note · layers · one layer · only when selected · since 0.1*",
        ),
        (
            rule(on=Scene),
            "*error · camera · the whole stage · only with --scene or by name · since 0.1*",
        ),
        (rule(group=""), "*error · the render scope · on by default · since 0.1*"),
    ],
)
def test_facts_line(made: AnyRule, expected: str) -> None:
    assert pages.facts_line(made) == expected


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty source tree, in which `pages` believes to stand."""
    module = tmp_path / "src" / "usdrender_lint" / "pages.py"
    module.parent.mkdir(parents=True)
    (tmp_path / "rules").mkdir()
    monkeypatch.setattr(pages, "__file__", str(module))
    return tmp_path


def test_pages_of_the_repository(installed: Path) -> None:
    for name in ("b-rule.md", "a-rule.md", "README.md", "notes.txt"):
        (installed / "rules" / name).write_text(f"# {name} ·\n", encoding="utf-8")
    assert list(pages.pages()) == ["a-rule", "b-rule"]
    assert pages.page_text("b-rule") == "# b-rule.md ·\n"


def test_pages_of_a_wheel_come_first(installed: Path) -> None:
    shipped = installed / "src" / "usdrender_lint" / "pages"
    shipped.mkdir()
    (shipped / "a-rule.md").write_text("shipped", encoding="utf-8")
    (installed / "rules" / "b-rule.md").write_text("source", encoding="utf-8")
    assert pages.pages() == {"a-rule": "shipped"}


@pytest.mark.parametrize("name", ["unknown", "README", "../secret", "", "a-rule.md"])
def test_an_unknown_page_is_a_sentence(installed: Path, name: str) -> None:
    (installed / "rules" / "README.md").write_text("catalogue", encoding="utf-8")
    (installed / "secret.md").write_text("secret", encoding="utf-8")
    with pytest.raises(pages.UnknownPageError) as error:
        pages.page_text(name)
    assert str(error.value) == f"There is no page for {name!r} in {installed / 'rules'}."


SGR = re.compile(r"\x1b\[[0-9;]*m")


def test_explain_without_color_is_the_page() -> None:
    assert explain.render(PAGE, color=False, width=20) == PAGE


@pytest.mark.parametrize("width", [30, 80, 300])
def test_explain_loses_no_word(width: int) -> None:
    shown = SGR.sub("", explain.render(PAGE, color=True, width=width))
    for word in (
        "unresolved-target",
        "inputs:camera:exposure",
        "[/Render/X]",
        "</World>",
        "<https://openusd.org/>",
        "https://openusd.org/schema",
    ):
        assert word in shown
    assert "\x1b" not in shown


def test_explain_shows_blocks_verbatim() -> None:
    code = '#usda 1.0\n\tdef "x" :smile: [b] {\n\n' + "    long = 1 " * 30 + "\n}\n"
    shown = explain.render(PAGE.replace("good\n", code), color=True, width=40)
    assert code in re.sub(r" *\n", "\n", SGR.sub("", shown)).replace("1\n}", "1 \n}")


def test_explain_keeps_prose_narrow() -> None:
    text = explain.render(PAGE.replace("Never.", "word " * 100), color=True, width=300)
    assert max(map(len, SGR.sub("", text).splitlines())) <= explain.MAX_WIDTH


def test_explain_closes_its_colors() -> None:
    text = explain.render(PAGE, color=True, width=80)
    for line in text.splitlines():
        codes = SGR.findall(line)
        assert codes[1::2] == ["\x1b[0m"] * (len(codes) // 2)
    assert SGR.search(text)


@pytest.mark.parametrize("name", ["NO_COLOR", "TERM", "COLUMNS"])
def test_explain_is_no_matter_of_the_environment(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = explain.render(PAGE, color=True, width=80)
    monkeypatch.setenv(name, "dumb" if name == "TERM" else "20")
    assert explain.render(PAGE, color=True, width=80) == before
