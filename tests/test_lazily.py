"""Are regular expressions compiled when they are first used, and is none of them wrong?"""

from __future__ import annotations

import copy
import gc
import pickle
import re
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

import pytest

import usdrender_lint
from usdrender_lint.lazily import _Later, lazily


def test_every_pattern_of_the_package_compiles() -> None:
    for info in walk_packages(usdrender_lint.__path__, f"{usdrender_lint.__name__}."):
        if not info.name.endswith("__main__"):
            import_module(info.name)
    patterns = [one for one in gc.get_objects() if type(one) is _Later]
    assert len(patterns) > 70
    for one in patterns:
        re.compile(*one._asked)


def test_it_does_what_the_compiled_one_does() -> None:
    text = "a1 b22 c"
    late, early = lazily(r"([a-z])(?P<n>\d*)", re.I), re.compile(r"([a-z])(?P<n>\d*)", re.I)
    for use in ("match", "search", "fullmatch", "findall", "split"):
        ours, theirs = getattr(late, use)(text), getattr(early, use)(text)
        assert getattr(ours, "groups", lambda o=ours: o)() == getattr(theirs, "groups", lambda t=theirs: t)()  # fmt: skip
    assert late.sub("x", text) == early.sub("x", text)
    assert late.subn("x", text, 1) == early.subn("x", text, 1)
    assert [m.span() for m in late.finditer(text)] == [m.span() for m in early.finditer(text)]
    for fact in ("pattern", "flags", "groups", "groupindex"):
        assert getattr(late, fact) == getattr(early, fact)
    with pytest.raises(AttributeError):
        late.nonsense  # type: ignore[attr-defined]  # noqa: B018


@pytest.mark.parametrize("copied", [copy.copy, lambda one: pickle.loads(pickle.dumps(one))])  # noqa: S301
def test_it_is_copied_before_and_after_it_is_compiled(
    copied: Callable[[re.Pattern[str]], re.Pattern[str]],
) -> None:
    one = lazily("a+", re.I)
    assert copied(one).match("AA")
    assert one.match("aa")
    assert copied(one).match("AA")


def test_it_compiles_once_and_not_before() -> None:
    code = """
import re, sys
count = []
really = re.compile
re.compile = lambda *a: count.append(a) or really(*a)
from usdrender_lint.lazily import lazily
one = lazily("a+")
assert not count
assert one.match("aa") and one.match("aaa") and one.search("baa")
print(len(count))
"""
    source = str(Path(usdrender_lint.__path__[0]).parent)
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path.insert(0, {source!r}){code}"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "1\n"
