"""Runs structured text: functions and function blocks of LREAL, INT and BOOL.

IEC 61131-3 mixes no types without a conversion, and tells no names apart by their case; a program
that counts on either fails here as in a controller.
"""

from __future__ import annotations

import contextlib
import math
import operator
import re
from collections.abc import Callable
from typing import Any

Scope = dict[str, Any]
Expression = Callable[[Scope], Any]

_TOKEN = re.compile(
    r"(?P<space>\s+|\(\*.*?\*\))|(?P<real>\d+\.\d+(?:E[+-]?\d+)?)|(?P<whole>\d+)|"
    r"(?P<word>[A-Za-z](?:_?[A-Za-z0-9])*)|(?P<sign>:=|<=|>=|<>|[-+*/()=<>,;:])",
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
    "INT_TO_LREAL": (int, float),
}


class Return(Exception):
    """RETURN was met."""


class Unit:
    """A function, or an instance of a function block: it keeps its variables between calls."""

    def __init__(self, name: str, keeps: bool, variables: Scope, inputs: set[str], body: Any):
        self.name, self.keeps, self.inputs, self.body = name, keeps, inputs, body
        self.variables = variables

    def __call__(self, **arguments: Any) -> Scope:
        scope = self.variables if self.keeps else dict(self.variables)
        for name, value in arguments.items():
            assert name in self.inputs, f"{self.name} has no input {name}"
            store(scope, name, value)
        with contextlib.suppress(Return):
            self.body(scope)
        return scope


def store(scope: Scope, name: str, value: Any) -> None:
    assert name in scope, f"{name} is not declared"
    assert type(value) is type(scope[name]), f"{name} := {value!r} is of another type"
    scope[name] = value


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
            kind = self.take("FUNCTION", "FUNCTION_BLOCK")
            name = self.take("word")
            variables: Scope = {}
            if kind == "FUNCTION":
                self.take(":")
                variables[name] = _STARTS[self.take(*_STARTS)]
            inputs = self.declarations(variables)
            body = self.block(f"END_{kind}")
            self.take(f"END_{kind}")
            assert len({word.upper() for word in variables}) == len(variables)
            self.known[name] = Unit(name, kind == "FUNCTION_BLOCK", variables, inputs, body)
        return self.known

    def declarations(self, variables: Scope) -> set[str]:
        inputs = set()
        while self.peek() in ("VAR_INPUT", "VAR_OUTPUT", "VAR"):
            section = self.take()
            while not self.accept("END_VAR"):
                name = self.take("word")
                assert name not in variables, f"{name} is declared twice"
                self.take(":")
                variables[name] = _STARTS[self.take(*_STARTS)]
                if self.accept(":="):
                    store(variables, name, self.expression()({}))
                self.take(";")
                if section == "VAR_INPUT":
                    inputs.add(name)
        return inputs

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
        name = self.take("word")
        self.take(":=")
        value = self.expression()
        self.take(";")
        return lambda scope: store(scope, name, value(scope))

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
        return self.call(word) if self.accept("(") else lambda scope: scope[word]

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
            arguments[argument] = self.expression()
            self.accept(",")
        assert arguments.keys() == unit.inputs
        return lambda scope: unit(**{a: e(scope) for a, e in arguments.items()})[name]


def _applied(function: Callable[..., Any], left: Expression, right: Expression) -> Expression:
    def run(scope: Scope) -> Any:
        a, b = left(scope), right(scope)
        assert type(a) is type(b), f"{a!r} and {b!r} are of different types"
        return function(a, b)

    return run
