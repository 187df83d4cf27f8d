"""Are our values those of the standard library, but for when they are paid for?"""

from __future__ import annotations

import copy
import pickle
from dataclasses import FrozenInstanceError, field, fields, is_dataclass, replace
from typing import Any, Generic, TypeVar

import pytest

from usdrender_lint.records import dataclass

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Point(Generic[T]):
    x: T
    y: int = 0
    names: list[str] = field(default_factory=list)
    line: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Deep(Point[int]):
    z: int = 7
    count: int = field(init=False, default=0)

    @property
    def sum(self) -> int:
        return self.x + self.y + self.z


@dataclass(slots=True)
class Counter:
    found: dict[str, int] = field(default_factory=dict)
    doubled: dict[str, int] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self.doubled.update((k, 2 * n) for k, n in self.found.items())


@dataclass(frozen=True, slots=True)
class Nothing:
    pass


@dataclass(frozen=True, slots=True)
class One:
    only: str


@dataclass(frozen=True, eq=False)
class Named:
    name: str = "?"


def test_values_come_by_place_by_name_and_by_default() -> None:
    assert (Point(1, 2).x, Point(1, 2).y, Point(x=1).y, Point(1).names) == (1, 2, 0, [])
    assert Point(1).names is not Point(1).names
    assert (Deep(1, 2).z, Deep(1, 2, [], 3, 4).z, Deep(1, 2).sum) == (7, 4, 10)
    assert Named().name == "?"
    for wrong in ({}, {"x": 1, "w": 2}):
        with pytest.raises(TypeError):
            Point(**wrong)
    with pytest.raises(TypeError):
        Deep(1, count=3)  # type: ignore[call-arg]


def test_values_are_compared_by_what_they_say() -> None:
    assert Point(1, line=5) == Point(1, line=6)
    assert Point(1) != Point(2)
    assert Point(1) != Deep(1)
    assert hash(One("a")) == hash(One("a")) != hash(One("b"))
    assert len({One("a"), One("a"), Nothing(), Nothing()}) == 2
    assert Named() != Named()
    with pytest.raises(TypeError, match="unhashable"):
        hash(Counter())


def test_values_stay_what_they_are() -> None:
    for change in (lambda p: setattr(p, "x", 2), lambda p: setattr(p, "w", 2)):
        with pytest.raises((FrozenInstanceError, AttributeError)):
            change(Point(1))
    with pytest.raises(FrozenInstanceError):
        del Point(1).x  # type: ignore[misc]
    assert type(Deep(1)) is Deep
    counter = Counter()
    counter.found = {"a": 1}
    with pytest.raises(AttributeError):
        counter.lost = 1  # type: ignore[attr-defined]
    assert not hasattr(Point(1), "__dict__")


def test_what_is_computed_is_not_given() -> None:
    assert Counter({"a": 2}).doubled == {"a": 4}
    assert replace(Counter({"a": 2}), found={}).doubled == {}


def test_what_derives_from_a_value_is_declared_as_one() -> None:
    class Undeclared(Point[int]):
        pass

    with pytest.raises(TypeError, match="Undeclared"):
        Undeclared(1)


@pytest.mark.parametrize(
    "value", [Point(1, 2, ["a"], 9), Deep(1, z=3), Counter({"a": 2}), Nothing(), One("a")]
)
def test_values_travel_between_processes(value: Any) -> None:
    assert pickle.loads(pickle.dumps(value)) == copy.copy(value) == value  # noqa: S301 our own bytes
    assert repr(pickle.loads(pickle.dumps(value))) == repr(value)  # noqa: S301


def test_the_standard_library_knows_them() -> None:
    assert is_dataclass(Deep)
    assert is_dataclass(Point(1))
    assert [f.name for f in fields(Deep)] == ["x", "y", "names", "line", "z", "count"]
    assert replace(Deep(1, 2), y=5) == Deep(1, 5)
    assert repr(Point(1)) == "Point(x=1, y=0, names=[], line=1)"
    match One("a"):
        case One(said):
            assert said == "a"


def test_an_init_is_written_when_the_first_value_is_made() -> None:
    @dataclass(frozen=True, slots=True)
    class Late:
        x: int

    first = Late.__init__
    Late(1)
    assert Late.__init__ is not first
    assert Late(2).x == 2
