"""Expressions of C in structured text."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

from pycparser import c_ast

from stickslip.models.errors import UnknownModel
from stickslip.models.firmware.program import LIBRARY, Function, Program, Variable, spelt, walk
from stickslip.models.firmware.words import SMALLEST, distinct, literal

_BINDING = {"OR": 1, "AND": 2, "=": 3, "<>": 3, "<": 4, ">": 4, "<=": 4, ">=": 4}
_BINDING |= {"+": 5, "-": 5, "*": 6, "/": 6}
_PLACES = (c_ast.ID, c_ast.StructRef, c_ast.ArrayRef)  # what * and & are applied to
_SPELT = {"||": "OR", "&&": "AND", "==": "=", "!=": "<>"}


class Text(NamedTuple):
    """An expression; what binds by 9 needs no brackets."""

    text: str
    type: str
    binding: int = 9
    sizes: tuple[int, ...] = ()

    def converted(self, type_: str) -> Text:
        """Return a whole number as a real one where that is needed."""
        if (self.type, type_) != ("INT", "LREAL"):
            return self
        if self.text.lstrip("-").isdigit():
            return Text(f"{self.text}.0", "LREAL", self.binding)
        return Text(f"INT_TO_LREAL({self.text})", "LREAL")


class Expressions(ABC):
    """The names of one function, and its lines as far as they are translated."""

    def __init__(self, program: Program, function: Function) -> None:
        self.program, self.function = program, function
        self.own = f"{program.prefix}_{function.name}"  # its result has this name, too
        self.parameters = [p for p in function.parameters if p.type]
        self.locals: dict[str, Variable] = {}
        for node in walk(function.body):
            if isinstance(node, c_ast.Decl) and not isinstance(node.type, c_ast.PtrDecl):
                one = program.variable(node)
                if self.locals.setdefault(one.name, one) != one:
                    raise self.refused(f"{one.name} has two types")
        self.known = {p.name: p for p in self.parameters} | self.locals
        self.names = distinct(self.known) | {self.own: self.own}
        self.known[self.own] = Variable(self.own, function.returns)
        self.aliases: dict[str, c_ast.Node] = {}  # pointer -> what it points to
        self.further: list[str] = []
        self.lines: list[str] = []
        self.depth = 1

    @abstractmethod
    def assign(self, target: c_ast.Node, value: c_ast.Node) -> None:
        """Add an assignment before what is being translated."""

    def refused(self, reason: str) -> UnknownModel:
        """Return why there is no structured text."""
        return UnknownModel(f"{self.function.name}: {reason}")

    def another(self, name: str, type_: str) -> str:
        """Declare a further variable."""
        line = f"    {name} : {self.program.type_name(type_) or 'BOOL'};"
        if line not in self.further:
            self.further.append(line)
        return name

    def kept(self, value: c_ast.Node, type_: str) -> c_ast.ID:
        """Return a further variable that has a value."""
        name = self.another(f"value_{len(self.further)}", type_)
        self.known[name], self.names[name] = Variable(name, type_), name
        self.assign(c_ast.ID(name), value)
        return c_ast.ID(name)

    def frozen(self, node: c_ast.Node) -> c_ast.Node:
        """Return what a pointer points to, with its indices as they are now."""
        match node:
            case c_ast.StructRef(name=base, type=sign, field=field):
                return c_ast.StructRef(self.frozen(base), sign, field)
            case c_ast.ArrayRef(name=base, subscript=place):
                base, is_number = self.frozen(base), isinstance(place, c_ast.Constant)
                return c_ast.ArrayRef(base, place if is_number else self.kept(place, "INT"))
        return node

    def expression(self, node: c_ast.Node) -> Text:
        """Return an expression; what has to be done before it is added."""
        program = self.program
        match node:
            case c_ast.Constant(value=value) if value.isdigit():
                return Text(value, "INT")
            case c_ast.Constant(type="double", value=value):
                number = float(value)
                return Text(literal(max(number, SMALLEST) if number else number), "LREAL")
            case c_ast.ID(name=name) if name in self.aliases:
                return self.expression(self.aliases[name])
            case c_ast.ID(name=name) if name in self.known:
                return Text(self.names[name], self.known[name].type, 9, self.known[name].sizes)
            case c_ast.ID(name=name) if name in program.constants:
                return self.expression(program.constants[name])
            case c_ast.ID(name=name):
                raise self.refused(f"{name} is not known")
            case c_ast.StructRef(field=c_ast.ID(name=name)):
                base = self.expression(node.name)
                one, shown = program.fields[base.type][name], program.member(base.type, name)
                return Text(f"{base.text}.{shown}", one.type, 9, one.sizes)
            case c_ast.ArrayRef():
                array, place = self.expression(node.name), self.expression(node.subscript)
                return Text(f"{array.text}[{place.text}]", array.type, 9, array.sizes[1:])
            case c_ast.UnaryOp(op="*" | "&", expr=inner) if isinstance(inner, _PLACES):
                return self.expression(inner)
            case c_ast.UnaryOp(op="!" | "-" as sign):
                inner = self.expression(node.expr)
                text = inner.text if inner.binding > 6 else f"({inner.text})"
                return Text(f"{'NOT ' if sign == '!' else '-'}{text}", inner.type, 6)
            case c_ast.BinaryOp(op="!=" | "==", right=c_ast.ID(name="NULL")):
                # a variable stands in its place, which nothing reads
                return Text("TRUE" if node.op == "!=" else "FALSE", "BOOL")
            case c_ast.BinaryOp() if _SPELT.get(node.op, node.op) in _BINDING:
                return self._binary(node)
            case c_ast.TernaryOp():
                return self.expression(self.kept(node, self._type(node)))
            case c_ast.Cast(to_type=c_ast.Typename(type=to)):
                inner, type_ = self.expression(node.expr), program.type_of(to)
                if (inner.type, type_) == ("LREAL", "INT"):
                    return Text(f"DINT_TO_INT(TRUNC({inner.text}))", "INT")
                return inner.converted(type_)
            case c_ast.FuncCall(name=c_ast.ID(name=name), args=c_ast.ExprList(exprs=parts)):
                return self._call(name, parts)
        raise self.refused(f"cannot translate {spelt(node)!r}")

    def _type(self, node: c_ast.Node) -> str:
        if not isinstance(node, c_ast.TernaryOp):
            return self.expression(node).type
        types = {self._type(node.iftrue), self._type(node.iffalse)}
        return "LREAL" if "LREAL" in types else types.pop()

    def _binary(self, node: c_ast.BinaryOp) -> Text:
        left, right = self.expression(node.left), self.expression(node.right)
        common = "LREAL" if "LREAL" in (left.type, right.type) else left.type
        left, right = left.converted(common), right.converted(common)
        operator = _SPELT.get(node.op, node.op)
        binding = _BINDING[operator]
        a = left.text if left.binding >= binding else f"({left.text})"
        b = right.text if right.binding > binding and right.text[0] != "-" else f"({right.text})"
        return Text(f"{a} {operator} {b}", "BOOL" if binding < 5 else common, binding)

    def _call(self, name: str, parts: list[c_ast.Node]) -> Text:
        if name in LIBRARY:
            inner = self.expression(parts[0]).converted("LREAL").text
            exp = f"{self.program.prefix}_exp(x := {inner})"
            return Text(exp if name == "elementary_exp" else f"{LIBRARY[name]}({inner})", "LREAL")
        if name not in self.program.functions:
            raise self.refused(f"{name} is not known")
        given = []
        for parameter, part in zip(self.program.functions[name].parameters, parts, strict=True):
            if not parameter.type:
                given.append(Text("", ""))
            elif isinstance(part, c_ast.ID) and part.name == "NULL":
                given.append(Text(self.another("nothing", parameter.type), parameter.type))
            else:
                given.append(self.expression(part).converted(parameter.type))
        called = self.program.variant(name, [one.sizes for one in given])
        used = {p.name: one for p, one in zip(called.parameters, given, strict=True) if p.type}
        names = distinct(used)
        arguments = ", ".join(f"{names[own]} := {one.text}" for own, one in used.items())
        return Text(f"{self.program.prefix}_{called.name}({arguments})", called.returns)
