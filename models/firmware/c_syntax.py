"""Reads the C of models/: functions over doubles, integers and structs of them, as a tree.

It has no goto, switch, do, comma operator, function pointers or pointer arithmetic.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise

from stickslip.models.errors import UnknownModel

_TOKEN = re.compile(
    r"(?P<space>\s+|/\*.*?\*/)|(?P<number>\d+\.\d*(?:e[+-]?\d+)?|\d+e[+-]?\d+|\d+)|(?P<name>[A-Za-z_]\w*)|"
    r"(?P<sign>->|\+\+|--|[-+*/<>=!]=|&&|\|\||[-+*/%<>=!&?:;,.(){}\[\]])",
    re.DOTALL,
)
_LEVELS = (("||",), ("&&",), ("==", "!="), ("<", ">", "<=", ">="), ("+", "-"), ("*", "/"))
_ASSIGNMENTS = ("=", "+=", "-=", "*=", "/=")
_SCALARS = {"double": "LREAL", "int": "INT", "size_t": "INT", "bool": "BOOL", "void": ""}


@dataclass(frozen=True)
class Node:
    """An expression: its kind, the word that it has, and its parts.

    Kinds: number, name, member (word of a part), index, call (word of the parts), unary, binary,
    choice (condition, first, second), cast (word is the type), list (initialisers; words are the
    members that they name, or "").
    """

    kind: str
    word: str = ""
    parts: tuple[Node, ...] = ()
    words: tuple[str, ...] = ()

    def names(self) -> Iterator[str]:
        """Yield the names and called functions in it."""
        if self.kind in ("name", "call"):
            yield self.word
        for part in self.parts:
            yield from part.names()


@dataclass(frozen=True)
class Declared:
    """A variable, parameter or member: a scalar or struct, an array, or a pointer to one."""

    name: str
    type: str
    sizes: tuple[Node, ...] = ()
    is_pointer: bool = False


@dataclass(frozen=True)
class Statement:
    """A statement: ``do`` an expression or assignment, declare, if, while, for, return, exit.

    ``word`` is the operator of an assignment; ``nodes`` are expressions, ``blocks`` statements.
    """

    kind: str
    word: str = ""
    nodes: tuple[Node | None, ...] = ()
    blocks: tuple[tuple[Statement, ...], ...] = ()
    variable: Declared | None = None


@dataclass
class Function:
    """A function: what it returns, its parameters and its statements."""

    name: str
    returns: str
    parameters: list[Declared]
    body: tuple[Statement, ...] = field(default=())


class Reader:
    """Reads definitions; ``structs`` are the names of types."""

    def __init__(self, text: str, structs: dict[str, str]) -> None:
        self.structs = structs
        self.tokens: list[tuple[str, str]] = []
        place = 0
        while place < len(text):
            match = _TOKEN.match(text, place)
            if match is None:
                raise UnknownModel(f"cannot read {text[place : place + 30]!r}")
            place = match.end()
            if match.lastgroup != "space":
                self.tokens.append((str(match.lastgroup), match[0]))
        self.tokens += [("end", "")] * 3

    def _peek(self, ahead: int = 0) -> str:
        return self.tokens[ahead][1]

    def _take(self, expected: str = "") -> str:
        word = self.tokens.pop(0)[1]
        if expected and word != expected:
            raise UnknownModel(f"found {word!r} in place of {expected!r}")
        return word

    def _accept(self, word: str) -> bool:
        return self._peek() == word and bool(self._take())

    def _is_type(self, ahead: int = 0) -> bool:
        return self._peek(ahead) in ("const", *_SCALARS, *self.structs)

    def _type(self) -> str:
        while self._peek() in ("const", "static", "inline"):
            self._take()
        word = self._take()
        if word not in _SCALARS and word not in self.structs:
            raise UnknownModel(f"cannot translate the type {word!r}")
        return (_SCALARS | self.structs)[word]

    def _declared(self, type_: str) -> Declared:
        pointer = self._accept("*")
        name, sizes = self._take(), []
        while self._accept("["):
            sizes.append(Node("number", "0") if self._peek() == "]" else self.expression())
            self._take("]")
        return Declared(name, type_, tuple(sizes), pointer)

    def members(self) -> list[Declared]:
        """Read ``typedef struct {...} Name;``."""
        while self._take() != "{":
            pass
        found = []
        while not self._accept("}"):
            type_ = self._type()
            found.append(self._declared(type_))
            while self._accept(","):
                found.append(self._declared(type_))
            self._take(";")
        return found

    def function(self) -> Function:
        """Read the definition of a function."""
        returns = self._type()
        result = self._declared(returns)
        if result.is_pointer:
            raise UnknownModel(f"{result.name} returns a pointer")
        self._take("(")
        parameters = []
        while not self._accept(")"):
            parameters.append(self._declared(self._type()))
            self._accept(",")
        return Function(result.name, returns, parameters, self._block())

    def _block(self) -> tuple[Statement, ...]:
        """Read statements in braces, or one."""
        if not self._accept("{"):
            return tuple(self._statements())
        found: list[Statement] = []
        while not self._accept("}"):
            found += self._statements()
        return tuple(found)

    def _statements(self) -> list[Statement]:
        word = self._peek()
        if word == "if":
            return [self._if()]
        if word == "while":
            self._take()
            condition = self._condition()
            return [Statement("while", nodes=(condition,), blocks=(self._block(),))]
        if word == "for":
            return self._for()
        if word == "return":
            self._take()
            value = None if self._peek() == ";" else self.expression()
            self._take(";")
            return [Statement("return", nodes=(value,))]
        if word in ("break", "continue"):
            self._take()
            self._take(";")
            return [Statement(word)]
        found = self._declaration() if self._is_type() else self._simple()
        self._take(";")
        return found

    def _condition(self) -> Node:
        self._take("(")
        condition = self.expression()
        self._take(")")
        return condition

    def _if(self) -> Statement:
        self._take("if")
        condition, then = self._condition(), self._block()
        otherwise = self._block() if self._accept("else") else ()
        return Statement("if", nodes=(condition,), blocks=(then, otherwise))

    def _for(self) -> list[Statement]:
        self._take("for")
        self._take("(")
        first: list[Statement] = []
        if self._peek() != ";":
            first = self._declaration() if self._is_type() else self._simple()
        self._take(";")
        condition = None if self._peek() == ";" else self.expression()
        self._take(";")
        last = [] if self._peek() == ")" else self._simple()
        self._take(")")
        blocks = (tuple(first), tuple(last), self._block())
        return [Statement("for", nodes=(condition,), blocks=blocks)]

    def _declaration(self) -> list[Statement]:
        type_, found = self._type(), []
        while True:
            variable = self._declared(type_)
            value = None
            if self._accept("="):
                value = self._list() if self._peek() == "{" else self.expression()
            found.append(Statement("declare", nodes=(value,), variable=variable))
            if not self._accept(","):
                return found

    def _simple(self) -> list[Statement]:
        """Read an assignment or a call; ``(void)a`` is none; ``a = b = c`` is two."""
        found: list[Statement] = []
        while True:
            if [self._peek(k) for k in range(3)] == ["(", "void", ")"]:
                self.expression()
            else:
                found += self._assignment()
            if not self._accept(","):
                return found

    def _assignment(self) -> list[Statement]:
        target = self.expression()
        operator = self._take() if self._peek() in (*_ASSIGNMENTS, "++", "--") else ""
        if operator in ("++", "--"):
            return [Statement("do", f"{operator[0]}=", (target, Node("number", "1")))]
        if not operator:
            return [Statement("do", "", (target,))]
        chain = [target]
        chain.append(self.expression())
        while self._accept("="):
            chain.append(self.expression())
        pairs = list(pairwise(chain))
        return [Statement("do", operator, pair) for pair in reversed(pairs)]

    def _list(self) -> Node:
        self._take("{")
        parts, words = [], []
        while not self._accept("}"):
            words.append("")
            if self._accept("."):
                words[-1] = self._take()
                self._take("=")
            parts.append(self.expression())
            self._accept(",")
        return Node("list", "", tuple(parts), tuple(words))

    def expression(self, level: int = -1) -> Node:
        """Read an expression, of operators that bind as those of a level or more."""
        if level == -1:
            condition = self.expression(0)
            if not self._accept("?"):
                return condition
            first = self.expression()
            self._take(":")
            return Node("choice", "", (condition, first, self.expression()))
        if level == len(_LEVELS):
            return self._unary()
        left = self.expression(level + 1)
        while self._peek() in _LEVELS[level]:
            operator = self._take()
            left = Node("binary", operator, (left, self.expression(level + 1)))
        return left

    def _unary(self) -> Node:
        if self._peek() in ("-", "!", "*", "&"):
            return Node("unary", self._take(), (self._unary(),))
        if self._peek() == "(" and self._is_type(1):
            self._take()
            type_ = self._type()
            self._take(")")
            inner = self._list() if self._peek() == "{" else self._unary()
            return Node("cast", type_, (inner,))
        return self._postfix()

    def _postfix(self) -> Node:
        kind, word = self.tokens.pop(0)
        if word == "(":
            found = self.expression()
            self._take(")")
        elif kind == "name" and self._accept("("):
            arguments = []
            while not self._accept(")"):
                arguments.append(self.expression())
                self._accept(",")
            return Node("call", word, tuple(arguments))
        elif kind in ("number", "name"):
            found = Node(kind, word)
        else:
            raise UnknownModel(f"found {word!r} in an expression")
        while self._peek() in ("->", ".", "["):
            if self._take() == "[":
                found = Node("index", "", (found, self.expression()))
                self._take("]")
            else:
                found = Node("member", self._take(), (found,))
        return found
