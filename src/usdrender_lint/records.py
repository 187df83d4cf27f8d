"""How is a plain value declared, so that a hundred kinds of them cost nothing at start-up?

`dataclasses.dataclass` writes and compiles the methods of each class when it is declared: some
0.5 ms a class, which was most of what a run spent before it opened a file. This one shares them
between all classes, and compiles the only one that has to be quick, `__init__`, when the first
value of its class is made. Declare as usual; for mypy, `fields`, `replace` and `is_dataclass` these
are data classes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:
    import dataclasses
    from dataclasses import MISSING, Field, FrozenInstanceError
    from operator import attrgetter

    _MANY = 3
    """Fields of a class for which it pays to open its values while they are made."""

    def dataclass(*, frozen=False, slots=False, eq=True):
        """With `slots`, as the class has to be made anew, no method of it can say `super()`."""

        def declare(declared):
            described = _described(declared)
            own = [name for name in declared.__annotations__ if name in described]
            members = dict(declared.__dict__)
            members.pop("__dict__", None)
            members.pop("__weakref__", None)
            for name in own:
                members.pop(name, None)  # a default would stand where the slot has to be
                if not slots and described[name].default is not MISSING:
                    members[name] = described[name].default
            if slots:
                members["__slots__"] = tuple(own)
            members["__dataclass_fields__"] = described
            members["__match_args__"] = tuple(n for n, f in described.items() if f.init)
            members["__repr__"] = _repr
            members["__reduce__"] = _reduce
            if eq:
                members["_compared"] = _getter([n for n, f in described.items() if f.compare])
                members["__eq__"] = _eq
                members["__hash__"] = _hash if frozen else None
            if frozen:
                members["__setattr__"] = _refuse_to_set
                members["__delattr__"] = _refuse_to_delete
            record = type(declared)(declared.__name__, declared.__bases__, members)
            record.__init__ = _first_init(record, frozen)
            return record

        return declare

    def _described(declared):
        """Its fields by name, those of the classes that it derives from first."""
        described = {}
        for base in reversed(declared.__mro__[1:]):
            described.update(base.__dict__.get("__dataclass_fields__", {}))
        for name, kind in declared.__annotations__.items():
            default = declared.__dict__.get(name, MISSING)
            one = default if isinstance(default, Field) else dataclasses.field(default=default)
            one.name, one.type, one._field_type = name, kind, dataclasses._FIELD
            described[name] = one
        return described

    def _getter(names):
        """Of a tuple of attributes, also where there is one or none."""
        if len(names) > 1:
            return staticmethod(attrgetter(*names))
        return staticmethod(lambda record: tuple(getattr(record, name) for name in names))

    def _first_init(record, frozen):
        """An `__init__` that puts the one in its place that the class needs."""

        def __init__(self, *arguments, **named):  # noqa: N807 it becomes the method
            record.__init__ = _init(record, frozen)
            record.__init__(self, *arguments, **named)

        return __init__

    def _init(record, frozen):
        known = {"_missing": MISSING, "_set": object.__setattr__, "_record": record}
        parameters, lines = ["self"], []
        opens = frozen and len(record.__dataclass_fields__) >= _MANY
        if opens:
            known["_opened"] = _opened(record)
            lines.append("_set(self, '__class__', _opened)")
        for name, one in record.__dataclass_fields__.items():
            parameter = value = name
            if one.default is not MISSING:
                known[f"_default_{name}"] = one.default
                parameter = f"{name}=_default_{name}"
                value = name if one.init else f"_default_{name}"
            elif one.default_factory is not MISSING:
                known[f"_new_{name}"] = one.default_factory
                parameter = f"{name}=_missing"
                given = f" if {name} is _missing else {name}" if one.init else ""
                value = f"_new_{name}(){given}"
            if one.init:
                parameters.append(parameter)
            is_shut = frozen and not opens
            lines.append(f"_set(self, {name!r}, {value})" if is_shut else f"self.{name} = {value}")
        if opens:
            lines.append("self.__class__ = _record")
        if hasattr(record, "__post_init__"):
            lines.append("self.__post_init__()")
        body = "\n ".join(lines or ["pass"])
        exec(f"def __init__({', '.join(parameters)}):\n {body}", known)  # noqa: S102 as dataclasses does
        return known["__init__"]

    def _opened(record):
        """A class like it, whose values can be changed: setting a field of a frozen one takes six
        times as long, so while it is made a value is one of this class."""
        # Both, or Python goes a long way round to either.
        changing = {"__setattr__": object.__setattr__, "__delattr__": object.__delattr__}
        return type(record)(record.__name__, (record,), {"__slots__": (), **changing})

    def _repr(self):
        values = (f"{name}={getattr(self, name)!r}" for name in self.__dataclass_fields__)
        return f"{self.__class__.__qualname__}({', '.join(values)})"

    def _reduce(self):
        return self.__class__, tuple(getattr(self, name) for name in self.__match_args__)

    def _eq(self, other):
        if other.__class__ is not self.__class__:
            return NotImplemented
        return self._compared(self) == self._compared(other)

    def _hash(self):
        return hash(self._compared(self))

    def _refuse_to_set(self, name, value):
        raise FrozenInstanceError(f"cannot assign to field {name!r}")

    def _refuse_to_delete(self, name):
        raise FrozenInstanceError(f"cannot delete field {name!r}")
