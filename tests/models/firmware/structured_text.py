"""Runs structured text: functions and function blocks of LREAL, INT, BOOL, arrays and structs.

IEC 61131-3 mixes no types without a conversion, and tells no names apart by their case; a program
that counts on either fails here as in a controller. What is VAR_IN_OUT is passed by reference.
"""

import contextlib
import math
from collections.abc import Callable, Iterable
from copy import deepcopy
from dataclasses import dataclass
from functools import reduce
from operator import add, and_, eq, ge, gt, le, lt, mul, ne, neg, not_, or_, sub
from typing import Any

from lark import Lark, Transformer, v_args
from lark.exceptions import VisitError

Scope = dict[str, Any]
Expression = Callable[[Scope], Any]
Place = Callable[[Scope], tuple[Any, Any]]  # where a value is: a dict or list, and the key in it

_GRAMMAR = r"""
start: (array | struct | function | function_block)*
array: "TYPE" NAME ":" "ARRAY" "[" WHOLE ".." WHOLE "]" "OF" type ";" "END_TYPE"
struct: "TYPE" NAME ":" "STRUCT" (NAME ":" type ";")* "END_STRUCT" ";" "END_TYPE"
function: "FUNCTION" NAME ":" type section* block "END_FUNCTION"
function_block: "FUNCTION_BLOCK" NAME section* block "END_FUNCTION_BLOCK"
section: SECTION variable* "END_VAR"
variable: NAME ":" type [":=" constant] ";"
type: NAME
?constant: expression | "[" constant ("," constant)* "]" -> constants

block: statement*
?statement: LEAVE ";" -> leave
    | NAME "(" NAME ":=" expression ("," NAME ":=" expression)* ")" ";" -> instance
    | place ":=" expression ";" -> assignment
    | "IF" branch ("ELSIF" branch)* ["ELSE" block] "END_IF" ";" -> choice
    | "FOR" NAME ":=" expression "TO" expression ["BY" expression] "DO" block "END_FOR" ";" -> loop
    | "WHILE" expression "DO" block "END_WHILE" ";" -> repetition

branch: expression "THEN" block

?expression: left{conjunction, OR}
?conjunction: left{equation, AND}
?equation: left{comparison, EQUAL}
?comparison: left{sum, ORDER}
?sum: left{product, SIGN}
?product: left{factor, TIMES}
?left{term, sign}: term (sign term)*
?factor: "(" expression ")"
    | (SIGN | NOT) factor -> unary
    | (REAL | WHOLE | BOOL) -> literal
    | NAME "(" expression ")" -> standard
    | NAME "(" [NAME ":=" expression ("," NAME ":=" expression)*] ")" -> call
    | place -> value
place: NAME ("." member | "[" expression "]")*
member: NAME

SECTION.2: /VAR(_INPUT|_IN_OUT|_OUTPUT)?\b/
LEAVE.2: /(RETURN|EXIT)\b/
OR: "OR"
AND: "AND"
NOT: "NOT"
EQUAL.2: "=" | "<>"
ORDER: "<=" | ">=" | "<" | ">"
SIGN: "+" | "-"
TIMES: "*" | "/"
BOOL.2: /(TRUE|FALSE)\b/
REAL: /\d+\.\d+(E[+-]?\d+)?/
WHOLE: /\d+/
NAME: /[A-Za-z](_?[A-Za-z0-9])*/
%ignore /\s+|\(\*.*?\*\)/s
"""
_STARTS = {"LREAL": 0.0, "INT": 0, "DINT": 0, "BOOL": False}


def _divided(a: Any, b: Any) -> Any:
    """Divide; whole numbers, here of one sign, without a rest."""
    return a // b if type(a) is int else a / b


_OPERATORS = dict(
    zip(
        ("OR", "AND", "=", "<>", "<", "<=", ">", ">=", "+", "-", "*", "/"),
        (or_, and_, eq, ne, lt, le, gt, ge, add, sub, mul, _divided),
        strict=True,
    )
)
_STANDARD: dict[str, tuple[type, Callable[[Any], Any]]] = {
    "ABS": (float, abs),
    "EXP": (float, math.exp),
    "LN": (float, math.log),
    "SIN": (float, math.sin),
    "TRUNC": (float, math.trunc),
    "DINT_TO_INT": (int, int),
    "DINT_TO_LREAL": (int, float),
    "INT_TO_LREAL": (int, float),
}


class Return(Exception):
    """RETURN was met."""


class Exit(Exception):
    """EXIT was met."""


@dataclass
class Unit:
    """A function, or an instance of a function block: it keeps its variables between calls."""

    name: str
    keeps: bool
    variables: Scope
    inputs: set[str]
    shared: set[str]
    body: Callable[[Scope], None]

    def __getitem__(self, name: str) -> Any:
        return self.variables[name]

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
    program = _Program()
    try:
        program.transform(_PARSER.parse(text))
    except VisitError as error:
        raise error.orig_exc from None
    return program.units


def words(text: str) -> list[str]:
    """Return the words of a file, without comments."""
    return [str(word) for word in _PARSER.lex(text)]


@v_args(inline=True)
class _Program(Transformer):
    """Makes functions of Python, callees first, of the tree of structured text."""

    def __init__(self) -> None:
        super().__init__()
        self.types: dict[str, Any] = dict(_STARTS)
        self.units: dict[str, Unit] = {}

    def NAME(self, token):  # noqa: N802 - as in the grammar
        return str(token)

    def struct(self, name, *members):
        self.types[name] = _distinct(zip(members[::2], members[1::2], strict=True))

    def type(self, name):
        return deepcopy(self.types[name])

    def array(self, name, first, last, element):
        assert first == "0"
        self.types[name] = [deepcopy(element) for _ in range(int(last) + 1)]

    def constants(self, *values):
        return lambda scope: [value(scope) for value in values]

    def variable(self, name, value, start):
        variable = {name: value}
        if start:
            store(variable, name, start({}))
        return name, variable[name]

    def section(self, *parts):
        return parts

    def function(self, name, result, *parts):
        self._unit(name, [("", (name, result)), *parts], keeps=False)

    def function_block(self, name, *parts):
        self._unit(name, parts, keeps=True)

    def _unit(self, name, parts, *, keeps):
        *sections, body = parts
        variables = _distinct([variable for _, *own in sections for variable in own])
        inputs, shared = (
            {own for kind, *some in sections if kind == wanted for own, _ in some}
            for wanted in ("VAR_INPUT", "VAR_IN_OUT")
        )
        self.units[name] = Unit(name, keeps, variables, inputs, shared, body)
        if keeps:
            self.types[name] = self.units[name]

    def block(self, *statements):
        def run(scope: Scope) -> None:
            for statement in statements:
                statement(scope)

        return run

    def leave(self, word):
        def run(_: Scope) -> None:
            raise {"RETURN": Return, "EXIT": Exit}[word]

        return run

    def instance(self, name, *parts):
        given = dict(zip(parts[::2], parts[1::2], strict=True))
        return lambda scope: scope[name](**{one: value(scope) for one, value in given.items()})

    def assignment(self, place, value):
        return lambda scope: store(*place(scope), value(scope))

    def branch(self, *parts):
        return parts

    def choice(self, *parts):
        *branches, otherwise = parts

        def run(scope: Scope) -> None:
            for condition, block in branches:
                holds = condition(scope)
                assert type(holds) is bool
                if holds:
                    return block(scope)
            return otherwise and otherwise(scope)

        return run

    def loop(self, name, first, last, step, block):
        def run(scope: Scope) -> None:
            by = step(scope) if step else 1
            with contextlib.suppress(Exit):
                for k in range(first(scope), last(scope) + (1 if by > 0 else -1), by):
                    store(scope, name, k)
                    block(scope)

        return run

    def repetition(self, condition, block):
        def run(scope: Scope) -> None:
            with contextlib.suppress(Exit):
                while holds := condition(scope):
                    assert type(holds) is bool
                    block(scope)

        return run

    def member(self, name):
        return lambda _: name

    def place(self, name, *inside):
        """Return where a variable, a member or an element is."""
        return reduce(_inside, inside, lambda scope: (scope, name))

    def value(self, place):
        def value(scope: Scope) -> Any:
            holder, key = place(scope)
            assert not isinstance(holder, list) or 0 <= key < len(holder)
            return holder[key]

        value.place = place
        return value

    def left(self, first, *others):
        for sign, second in zip(others[::2], others[1::2], strict=True):
            first = _applied(_OPERATORS[sign], first, second)
        return first

    def unary(self, sign, inner):
        apply = {"-": neg, "NOT": not_}[sign]
        return lambda scope: apply(inner(scope))

    def literal(self, word):
        value = {"REAL": float, "WHOLE": int, "BOOL": "TRUE".__eq__}[word.type](word)
        return lambda _: value

    def standard(self, name, inner):
        expected, function = _STANDARD[name]

        def standard(scope: Scope) -> Any:
            value = inner(scope)
            assert type(value) is expected, f"{name} of {value!r}"
            return function(value)

        return standard

    def call(self, name, *parts):
        unit, arguments = self.units[name], dict(zip(parts[::2], parts[1::2], strict=True))
        assert arguments.keys() == unit.inputs | unit.shared
        arguments |= {one: arguments[one].place for one in unit.shared}
        return lambda scope: unit(**{a: e(scope) for a, e in arguments.items()})[name]


_PARSER = Lark(_GRAMMAR, parser="lalr", lexer="basic")


def _distinct(variables: Iterable[tuple[str, Any]]) -> Scope:
    """Return variables by name, of which none differ by case only."""
    found: Scope = {}
    for name, value in variables:
        assert name.upper() not in {known.upper() for known in found}, f"{name} is declared twice"
        found[name] = value
    return found


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
