"""Statements and expressions of C in structured text."""

from collections.abc import Iterator
from typing import NamedTuple

from pycparser import c_ast

from stickslip.models.errors import UnknownModel
from stickslip.models.firmware.program import (
    LIBRARY,
    ROLES,
    SMALLEST,
    Function,
    Program,
    Variable,
    distinct,
    literal,
    spelt,
    used_names,
    walk,
    whole,
)

_BINDING = {"OR": 1, "AND": 2, "=": 3, "<>": 3, "<": 4, ">": 4, "<=": 4, ">=": 4}
_BINDING |= {"+": 5, "-": 5, "*": 6, "/": 6}
_PLACES = (c_ast.ID, c_ast.StructRef, c_ast.ArrayRef)  # what * and & are applied to
_BLOCKS = (c_ast.Compound, c_ast.DeclList, c_ast.EmptyStatement, c_ast.ExprList)
_STEPS = ("p++", "++", "p--", "--")
# comparison and step -> what is added to the bound of FOR, and what follows it
_COUNTED = {"<+": (-1, ""), "<=+": (0, ""), ">-": (1, " BY -1"), ">=-": (0, " BY -1")}
_SPELT = {"||": "OR", "&&": "AND", "==": "=", "!=": "<>"}


class Text(NamedTuple):
    """An expression; what binds by 9 needs no brackets."""

    text: str
    type: str
    binding: int = 9
    sizes: tuple[int, ...] = ()

    def converted(self, type_: str) -> "Text":
        """Return a whole number as a real one where that is needed."""
        if (self.type, type_) != ("INT", "LREAL"):
            return self
        if self.text.lstrip("-").isdigit():
            return Text(f"{self.text}.0", "LREAL", self.binding)
        return Text(f"INT_TO_LREAL({self.text})", "LREAL")


class Statements:
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

    def text(self) -> str:
        """Return the function."""
        self.block(self.function.body, is_last=True)
        shared = [p for p in self.parameters if p.is_pointer or p.sizes]
        sections = {
            "VAR_INPUT": [p for p in self.parameters if p not in shared],
            "VAR_IN_OUT": shared,
            "VAR": list(self.locals.values()),
        }
        comment = self.function.comment.replace("/*", "(*").replace("*/", "*)")
        lines = [f"FUNCTION {self.own} : {self.program.type_name(self.function.returns) or 'BOOL'}"]
        for section, variables in sections.items():
            shown = [self.program.declaration(one, self.names[one.name]) for one in variables]
            shown += self.further if section == "VAR" else []
            if shown:
                lines += [section, *shown, "END_VAR"]
        lines += [*self.lines, "END_FUNCTION", ""]
        return comment.replace("\n * ", "\n   ") + "\n".join(lines)

    def emit(self, line: str) -> None:
        """Add a line."""
        self.lines.append("    " * self.depth + line)

    def inner(self, *blocks: c_ast.Node, is_last: bool = False) -> None:
        """Add what is inside a statement."""
        self.depth += 1
        before = len(self.lines)
        for block in blocks:
            self.block(block, is_last=is_last)
        if len(self.lines) == before:
            self.emit(";")
        self.depth -= 1

    def block(self, block: c_ast.Node, *, is_last: bool = False) -> None:
        """Add statements; what follows ``if (...) continue;`` is in its ELSE."""
        nodes = _items(block)
        for k, node in enumerate(nodes):
            first = _items(node.iftrue) if isinstance(node, c_ast.If) else []
            if first and isinstance(first[-1], c_ast.Continue):
                rest = c_ast.Compound([*_items(node.iffalse), *nodes[k + 1 :]])
                done = c_ast.Compound(first[:-1])
                one = c_ast.If(node.cond, done, rest)
                if not done.block_items:
                    one = c_ast.If(c_ast.UnaryOp("!", node.cond), rest, None)
                self.statement(one)
                return
            if nodes[k + 1 :] and isinstance(node, c_ast.If) and _continues(node):
                raise self.refused("continue is inside of an if that more follows")
            self.statement(node, is_last=is_last and k + 1 == len(nodes))

    def statement(self, node: c_ast.Node, *, is_last: bool = False) -> None:
        """Add a statement."""
        match node:
            case c_ast.Decl(storage=[]):
                if isinstance(node.type, c_ast.PtrDecl):
                    self.aliases[node.name] = self.frozen(node.init)
                elif node.init is not None:
                    self.assign(c_ast.ID(node.name), node.init)
            case c_ast.Assignment(op="=", lvalue=target, rvalue=c_ast.Assignment() as value):
                self.statement(value)
                self.assign(target, value.lvalue)
            case c_ast.Assignment(op=operator, lvalue=target, rvalue=value):
                changed = c_ast.BinaryOp(operator[:-1], target, value)
                self.assign(target, value if operator == "=" else changed)
            case c_ast.UnaryOp(op=operator, expr=target) if operator in _STEPS:
                self.assign(target, c_ast.BinaryOp(operator[-1], target, whole(1)))
            case c_ast.FuncCall():
                call = self.expression(node)
                name = f"ignored_{call.type}" if call.type else "done"
                self.emit(f"{self.another(name, call.type)} := {call.text};")
            case c_ast.Return():
                if node.expr is not None:
                    self.assign(c_ast.ID(self.own), node.expr)
                if not is_last:
                    self.emit("RETURN;")
            case c_ast.If():
                self._if(node, is_last=is_last)
            case c_ast.While():
                self._while(node.cond, node.stmt)
            case c_ast.For():
                self._for(node)
            case c_ast.Break():
                self.emit("EXIT;")
            case c_ast.EmptyStatement() | c_ast.ExprList():
                self.block(node)
            case _:
                self.expression(node)  # has no effect, or is refused

    def assign(self, target: c_ast.Node, value: c_ast.Node) -> None:
        """Add an assignment; a choice or a list becomes several."""
        match value:
            case c_ast.TernaryOp():
                both = [c_ast.Assignment("=", target, one) for one in (value.iftrue, value.iffalse)]
                self._if(c_ast.If(value.cond, *both))
            case c_ast.CompoundLiteral(init=values):
                self.assign(target, values)
            case c_ast.InitList(exprs=parts) if self.expression(target).sizes:
                for k, part in enumerate(parts):
                    self.assign(c_ast.ArrayRef(target, whole(k)), part)
            case c_ast.InitList(exprs=parts):
                type_ = self.expression(target).type
                members = self.program.fields[type_]
                named = [part for part in parts if isinstance(part, c_ast.NamedInitializer)]
                given = {part.name[0].name: part.expr for part in named}
                given = given if named == parts else dict(zip(members, parts, strict=False))
                for name, one in members.items():
                    zero = None if one.sizes or type_ in ROLES else whole(0)
                    if (part := given.get(name, zero)) is not None:
                        self.assign(c_ast.StructRef(target, ".", c_ast.ID(name)), part)
            case _:
                left = self.expression(target)
                self.emit(f"{left.text} := {self.expression(value).converted(left.type).text};")

    def _if(self, node: c_ast.If, *, is_last: bool = False) -> None:
        """Add IF, with ELSIF where all that follows ELSE is one IF."""
        self.emit(f"IF {self.expression(node.cond).text} THEN")
        self.inner(node.iftrue, is_last=is_last)
        if _items(node.iffalse):
            place = len(self.lines)
            self.emit("ELSE")
            self.inner(node.iffalse, is_last=is_last)
            inner, margin = self.lines[place + 1 :], "    " * (self.depth + 1)
            ends = [k for k, line in enumerate(inner) if line == f"{margin}END_IF;"]
            if inner[0].startswith(f"{margin}IF ") and ends[:1] == [len(inner) - 1]:
                moved = [line[4:] for line in inner[:-1]]
                self.lines[place:] = [moved[0].replace("IF ", "ELSIF ", 1), *moved[1:]]
        self.emit("END_IF;")

    def _while(self, condition: c_ast.Node, *blocks: c_ast.Node) -> None:
        before = len(self.lines)
        test = "TRUE" if condition is None else self.expression(condition).text
        if len(self.lines) > before:
            raise self.refused("the condition of a loop has a choice in it")
        self.emit(f"WHILE {test} DO")
        self.inner(*blocks)
        self.emit("END_WHILE;")

    def _for(self, node: c_ast.For) -> None:
        """Add FOR for a loop that counts and whose bound stays as it is, else WHILE."""
        match node:
            case c_ast.For(
                init=c_ast.DeclList(decls=[c_ast.Decl(name=name, init=c_ast.Node() as start)]),
                cond=c_ast.BinaryOp(left=c_ast.ID(name=counter), op=comparison, right=bound),
                next=c_ast.UnaryOp(expr=c_ast.ID(name=counted), op=step),
            ) if (
                name == counter == counted
                and comparison + step[-1] in _COUNTED
                and self.locals[name].type == "INT"
                and not isinstance(bound, c_ast.FuncCall)
                and not {name, *used_names(bound)}.intersection(self._assigned(node.stmt))
            ):
                more, by = _COUNTED[comparison + step[-1]]
                begin, end = self.expression(start).text, self.expression(bound).text
                if end.isdigit():
                    end = str(int(end) + more)
                elif more:
                    end += f" {'+' if more > 0 else '-'} 1"
                self.emit(f"FOR {self.names[name]} := {begin} TO {end}{by} DO")
                self.inner(node.stmt)
                self.emit("END_FOR;")
            case _:
                self.block(node.init)
                self._while(node.cond, node.stmt, node.next)

    def _assigned(self, node: c_ast.Node) -> Iterator[str]:
        """Yield the names of what statements assign to, or hand to a function by its place."""
        for one in walk(node):
            match one:
                case (
                    c_ast.Assignment(lvalue=target)
                    | c_ast.UnaryOp(op="p++" | "++" | "p--" | "--" | "&", expr=target)
                ):
                    while isinstance(target, c_ast.StructRef | c_ast.ArrayRef):
                        target = target.name
                    yield from used_names(target)
                case c_ast.Decl(name=name):
                    yield name
                case c_ast.FuncCall():
                    values = [p.name for p in self.known.values() if not (p.is_pointer or p.sizes)]
                    yield from {*used_names(one)}.difference(values)


def _continues(node: c_ast.Node) -> bool:
    """Return whether a statement may end the pass of a loop around it."""
    inner = (one for _, one in node.children() if not isinstance(one, c_ast.For | c_ast.While))
    return isinstance(node, c_ast.Continue) or any(map(_continues, inner))


def _items(node: c_ast.Node) -> list[c_ast.Node]:
    """Return the statements of a block, of a single statement or of none."""
    return list(node or ()) if node is None or isinstance(node, _BLOCKS) else [node]
