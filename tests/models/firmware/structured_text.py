"""Runs structured text: functions and function blocks of LREAL, INT, BOOL, arrays and structs.

IEC 61131-3 mixes no types without a conversion, and tells no names apart by their case; a program
that counts on either fails here as in a controller. What is VAR_IN_OUT is passed by reference.
"""

from __future__ import annotations

import contextlib
import math
import operator
import re
from collections.abc import Callable
from copy import deepcopy
from typing import Any

Scope = dict[str, Any]
Expression = Callable[[Scope], Any]
Place = Callable[[Scope], tuple[Any, Any]]  # where a value is: a dict or list, and the key in it

_TOKEN = re.compile(
    r"(?P<space>\s+|\(\*.*?\*\))|(?P<real>\d+\.\d+(?:E[+-]?\d+)?)|(?P<dots>\.\.)|(?P<whole>\d+)|"
    r"(?P<word>[A-Za-z](?:_?[A-Za-z0-9])*)|(?P<sign>:=|<=|>=|<>|[-+*/()\[\]=<>,;:.])",
    re.DOTALL,
)
_STARTS = {"LREAL": 0.0, "INT": 0, "BOOL": False}
_LEVELS = (  # of operators, those that bind least first
    {"OR": operator.or_},
    {"AND": operator.and_},
    {"=": operator.eq, "<>": operator.ne},
    {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge},
    {"+": operator.add, "-": operator.sub},
    {"*": operator.mul, "/": operator.truediv},
)
_STANDARD: dict[str, tuple[type, Callable[[Any], Any]]] = {
    "ABS": (float, abs),
    "EXP": (float, math.exp),
    "LN": (float, math.log),
    "SIN": (float, math.sin),
    "TRUNC": (float, math.trunc),
    "DINT_TO_INT": (int, int),
    "INT_TO_LREAL": (int, float),
}


class Return(Exception):
    """RETURN was met."""


class Exit(Exception):
    """EXIT was met."""


class Unit:
    """A function, or an instance of a function block: it keeps its variables between calls."""

    def __init__(
        self,
        name: str,
        keeps: bool,
        variables: Scope,
        inputs: set[str],
        shared: set[str],
        body: Any,
    ):
        self.name, self.keeps, self.inputs, self.body = name, keeps, inputs, body
        self.variables, self.shared = variables, shared

    def __call__(self, **arguments: Any) -> Scope:
        """Run it; what is shared is given as the place where it is."""
        scope = self.variables if self.keeps else {k: _copy(v) for k, v in self.variables.items()}
        for name, value in arguments.items():
            assert name in self.inputs | self.shared, f"{self.name} has no input {name}"
            if name in self.shared:
                holder, key = value
                assert _same(holder[key], scope[name]), f"{name} is of another type"
                scope[name] = holder[key]
            else:
                store(scope, name, value)
        with contextlib.suppress(Return):
            self.body(scope)
        for name in self.shared & arguments.keys():
            holder, key = arguments[name]
            holder[key] = scope[name]
        return scope


def _copy(value: Any) -> Any:
    return deepcopy(value) if isinstance(value, (list, dict)) else value


def _same(one: Any, other: Any) -> bool:
    """Tell whether values are of one type, with all that they contain."""
    if type(one) is not type(other):
        return False
    if isinstance(one, list):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_same(one[name], other[name]) for name in one)
    return True


def store(scope: Any, name: Any, value: Any) -> None:
    """Assign: arrays and structs are copied."""
    if isinstance(scope, list):
        assert 0 <= name < len(scope), f"[{name}] of {len(scope)}"
    else:
        assert name in scope, f"{name} is not declared"
    assert _same(value, scope[name]), f"{name} := {value!r} is of another type"
    scope[name] = _copy(value)


def load(text: str) -> dict[str, Unit]:
    """Return the functions and function blocks of a file by name."""
    return _Parser(text).units()


class _Parser:
    def __init__(self, text: str) -> None:
        self.tokens: list[tuple[str, str]] = []
        place = 0
        while place < len(text):
            match = _TOKEN.match(text, place)
            assert match, f"not structured text: {text[place : place + 40]!r}"
            place = match.end()
            if match.lastgroup != "space":
                self.tokens.append((str(match.lastgroup), match[0]))
        self.tokens.append(("end", ""))
        self.known: dict[str, Unit] = {}
        self.types: dict[str, Any] = {}

    def peek(self) -> str:
        return self.tokens[0][1]

    def take(self, *expected: str) -> str:
        kind, word = self.tokens.pop(0)
        assert not expected or word in expected or kind in expected, f"{word!r}, not {expected}"
        return word

    def accept(self, word: str) -> bool:
        return self.peek() == word and bool(self.take())

    def units(self) -> dict[str, Unit]:
        while self.peek():
            kind = self.take("FUNCTION", "FUNCTION_BLOCK", "TYPE")
            name = self.take("word")
            if kind == "TYPE":
                self.struct(name)
                continue
            variables: Scope = {}
            if kind == "FUNCTION":
                self.take(":")
                variables[name] = self.type()
            inputs, shared = self.declarations(variables)
            body = self.block(f"END_{kind}")
            self.take(f"END_{kind}")
            _check_case(variables)
            keeps = kind == "FUNCTION_BLOCK"
            self.known[name] = Unit(name, keeps, variables, inputs, shared, body)
        return self.known

    def struct(self, name: str) -> None:
        self.take(":")
        self.take("STRUCT")
        members: Scope = {}
        while not self.accept("END_STRUCT"):
            member = self.take("word")
            self.take(":")
            members[member] = self.type()
            self.take(";")
        self.take(";")
        self.take("END_TYPE")
        _check_case(members)
        self.types[name] = members

    def type(self) -> Any:
        """Return a value of a type, as it starts."""
        if not self.accept("ARRAY"):
            return deepcopy((_STARTS | self.types)[self.take(*_STARTS, *self.types)])
        self.take("[")
        self.take("0")
        self.take("..")
        last = int(self.take("whole"))
        self.take("]")
        self.take("OF")
        element = self.type()
        return [deepcopy(element) for _ in range(last + 1)]

    def declarations(self, variables: Scope) -> tuple[set[str], set[str]]:
        named: dict[str, set[str]] = {"VAR_INPUT": set(), "VAR_IN_OUT": set()}
        while self.peek() in (*named, "VAR_OUTPUT", "VAR"):
            section = self.take()
            while not self.accept("END_VAR"):
                name = self.take("word")
                assert name not in variables, f"{name} is declared twice"
                self.take(":")
                variables[name] = self.type()
                if self.accept(":="):
                    store(variables, name, self.start())
                self.take(";")
                named.get(section, set()).add(name)
        return named["VAR_INPUT"], named["VAR_IN_OUT"]

    def start(self) -> Any:
        if not self.accept("["):
            return self.expression()({})
        values = []
        while not self.accept("]"):
            values.append(self.start())
            self.accept(",")
        return values

    def block(self, *ends: str) -> Callable[[Scope], None]:
        statements = []
        while self.peek() not in ends:
            statements.append(self.statement())

        def run(scope: Scope) -> None:
            for statement in statements:
                statement(scope)

        return run

    def statement(self) -> Callable[[Scope], None]:
        if self.accept("IF"):
            return self.choice()
        if self.accept("FOR"):
            return self.loop()
        if self.accept("RETURN"):
            self.take(";")

            def leave(_: Scope) -> None:
                raise Return

            return leave
        if self.accept("WHILE"):
            return self.repetition()
        if self.accept("EXIT"):
            self.take(";")

            def end(_: Scope) -> None:
                raise Exit

            return end
        if self.accept(";"):
            return lambda _: None
        place = self.place(self.take("word"))
        self.take(":=")
        value = self.expression()
        self.take(";")
        return lambda scope: store(*place(scope), value(scope))

    def place(self, name: str) -> Place:
        """Read what is behind the name of a variable: members and elements."""
        found: Place = lambda scope: (scope, name)  # noqa: E731
        while self.peek() in (".", "["):
            if self.take() == ".":
                member = self.take("word")
                found = _inside(found, lambda _, member=member: member)
            else:
                found = _inside(found, self.expression())
                self.take("]")
        return found

    def repetition(self) -> Callable[[Scope], None]:
        condition = self.expression()
        self.take("DO")
        block = self.block("END_WHILE")
        self.take("END_WHILE")
        self.take(";")

        def run(scope: Scope) -> None:
            with contextlib.suppress(Exit):
                while condition(scope):
                    block(scope)

        return run

    def choice(self) -> Callable[[Scope], None]:
        branches = []
        while True:
            condition = self.expression()
            self.take("THEN")
            branches.append((condition, self.block("ELSIF", "ELSE", "END_IF")))
            if not self.accept("ELSIF"):
                break
        otherwise = self.block("END_IF") if self.accept("ELSE") else lambda _: None
        self.take("END_IF")
        self.take(";")

        def run(scope: Scope) -> None:
            for condition, block in branches:
                holds = condition(scope)
                assert type(holds) is bool
                if holds:
                    return block(scope)
            return otherwise(scope)

        return run

    def loop(self) -> Callable[[Scope], None]:
        name = self.take("word")
        self.take(":=")
        first = self.expression()
        self.take("TO")
        last = self.expression()
        step = self.expression() if self.accept("BY") else lambda _: 1
        self.take("DO")
        block = self.block("END_FOR")
        self.take("END_FOR")
        self.take(";")

        def run(scope: Scope) -> None:
            by = step(scope)
            with contextlib.suppress(Exit):
                for k in range(first(scope), last(scope) + (1 if by > 0 else -1), by):
                    store(scope, name, k)
                    block(scope)

        return run

    def expression(self, level: int = 0) -> Expression:
        if level == len(_LEVELS):
            return self.factor()
        left = self.expression(level + 1)
        while self.peek() in _LEVELS[level]:
            left = _applied(_LEVELS[level][self.take()], left, self.expression(level + 1))
        return left

    def factor(self) -> Expression:
        kind, word = self.tokens.pop(0)
        if word == "(":
            inner = self.expression()
            self.take(")")
            return inner
        if word in ("-", "NOT"):
            inner = self.factor()
            apply = operator.neg if word == "-" else operator.not_
            return lambda scope: apply(inner(scope))
        if kind in ("real", "whole") or word in ("TRUE", "FALSE"):
            value = (
                word == "TRUE" if kind == "word" else float(word) if kind == "real" else int(word)
            )
            return lambda _: value
        assert kind == "word", f"{word!r} in an expression"
        if self.accept("("):
            return self.call(word)
        place = self.place(word)

        def value(scope: Scope) -> Any:
            holder, key = place(scope)
            assert not isinstance(holder, list) or 0 <= key < len(holder)
            return holder[key]

        return value

    def call(self, name: str) -> Expression:
        if name in _STANDARD:
            expected, function = _STANDARD[name]
            inner = self.expression()
            self.take(")")

            def standard(scope: Scope) -> Any:
                value = inner(scope)
                assert type(value) is expected, f"{name} of {value!r}"
                return function(value)

            return standard
        unit, arguments = self.known[name], {}
        while not self.accept(")"):
            argument = self.take("word")
            self.take(":=")
            shared = argument in unit.shared
            arguments[argument] = self.place(self.take("word")) if shared else self.expression()
            self.accept(",")
        assert arguments.keys() == unit.inputs | unit.shared
        return lambda scope: unit(**{a: e(scope) for a, e in arguments.items()})[name]


def _check_case(names: Scope) -> None:
    assert len({word.upper() for word in names}) == len(names)


def _inside(outer: Place, key: Expression) -> Place:
    def place(scope: Scope) -> tuple[Any, Any]:
        holder, name = outer(scope)
        return holder[name], key(scope)

    return place


def _applied(function: Callable[..., Any], left: Expression, right: Expression) -> Expression:
    def run(scope: Scope) -> Any:
        a, b = left(scope), right(scope)
        assert type(a) is type(b), f"{a!r} and {b!r} are of different types"
        return function(a, b)

    return run
