"""Arguments of the public functions, whose errors name what was not expected."""

from __future__ import annotations

import math
import re
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, wraps
from importlib import import_module
from inspect import Parameter, isfunction, signature
from os import PathLike
from pathlib import Path
from types import SimpleNamespace, UnionType
from typing import Any, SupportsFloat, SupportsIndex, TypeVar, Union

from stickslip.fmi.errors import Fault
from stickslip.fmi.messages import printable, suggestion

_PACKAGE = "stickslip"  # which imports this module
F = TypeVar("F", bound=Callable[..., Any])
_TAKEN: dict[object, Any] = {  # in place of a class: numbers of numpy, paths as texts, tables
    float: SupportsFloat,
    int: SupportsIndex,
    bool: object,
    Path: (str, PathLike),
    tuple: Iterable,
}
_SEVERAL = (Sequence, Iterable, list)


def checked(function: F) -> F:
    """Return a function whose errors name an argument that it has not, or of another class.

    Classes are those of the annotations. They are compared where the function fails as Python does,
    not with a Fault, and a text with a list of them: what works with another class goes on working.

    Raises TypeError.
    """
    name = function.__qualname__.removesuffix(".__init__")
    taken = signature(function)
    names = [*taken.parameters]
    kinds = {one.kind for one in taken.parameters.values()}
    free = Parameter.VAR_KEYWORD in kinds
    named = [key for key, one in taken.parameters.items() if one.kind is Parameter.KEYWORD_ONLY]
    most = math.inf if Parameter.VAR_POSITIONAL in kinds else len(names) - len(named) - free

    @wraps(function)
    def call(*args: object, **given: object) -> object:
        for key in given if not free else ():
            if key not in taken.parameters:
                known = [one for one in names if one != "self"]
                raise TypeError(f"{name} has no argument {key!r}{suggestion(key, known)}")
        if len(args) > most:
            first, wanted = printable(repr(args[int(most)]), 80), ", ".join(named) or "none"
            raise TypeError(f"{name}: {first}: give it by name; arguments with a name: {wanted}")
        try:
            return function(*args, **given)
        except (Fault, AttributeError, TypeError, ValueError) as fault:
            for key, value in (*zip(names, args, strict=False), *given.items()):
                kind = _kind(function, key)
                letters = isinstance(value, str) and _fits([value], kind)  # for a list of texts
                if not _fits(value, kind) and (letters or not isinstance(fault, Fault)):
                    kind = taken.parameters[key].annotation
                    expected, got = getattr(kind, "__name__", kind), printable(repr(value), 80)
                    raise TypeError(f"{name}: {key}: expected {expected}, got {got}") from fault
            raise

    return call  # type: ignore[return-value]


def public(value: Any) -> Any:
    """Return a public function or class, the calls of which are checked."""
    if isinstance(value, type):
        kind: Any = value
        if isfunction(kind.__init__):
            kind.__init__ = checked(kind.__init__)
        return kind
    found = checked(value)
    found.__module__ = _PACKAGE  # where it is found when it goes to another process
    return found


@cache
def _kind(function: Callable[..., object], name: str) -> object:
    """Return what an annotation means; ``object`` where it names what is imported for it alone."""
    own = signature(function).parameters.get(name)  # also of options that it passes on
    if own is None or (text := own.annotation) is Parameter.empty:
        return object
    space = function.__globals__
    package, words = import_module(_PACKAGE), {*re.findall(r"\w+", str(text))} - {*space}
    names = {word: getattr(package, word) for word in words & {*dir(package)}}
    if "pd" in str(text):
        names["pd"] = import_module("pandas")  # late: large
    try:
        return typing.get_type_hints(SimpleNamespace(__annotations__={"": text}), space, names)[""]
    except (NameError, TypeError):
        return object


def _fits(value: object, kind: object) -> bool:
    origin = typing.get_origin(kind) or kind
    if origin in (Union, UnionType):
        return any(_fits(value, one) for one in typing.get_args(kind))
    if origin is Mapping:  # or a row of a table
        return hasattr(value, "items") or hasattr(value, "_asdict")
    if getattr(origin, "__module__", "") == "numpy":  # lists, series and numbers are arrays, too
        return True
    if origin in _SEVERAL:
        parts = value if isinstance(value, (list, tuple)) else ()
        inner = (*typing.get_args(kind), object)[0]
        return (
            not isinstance(value, str)
            and isinstance(value, Iterable)
            and all(_fits(one, inner) for one in parts)
        )
    try:
        return isinstance(value, _TAKEN.get(origin, origin))
    except TypeError:  # a Literal, or a protocol
        return True
