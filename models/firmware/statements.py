"""Statements of C in structured text."""

from __future__ import annotations

from collections.abc import Iterator

from pycparser import c_ast

from stickslip.models.firmware.expressions import Expressions
from stickslip.models.firmware.program import ROLES, used_names, walk, whole

_BLOCKS = (c_ast.Compound, c_ast.DeclList, c_ast.EmptyStatement, c_ast.ExprList)
_STEPS = ("p++", "++", "p--", "--")
# comparison and step -> what is added to the bound of FOR, and what follows it
_COUNTED = {"<+": (-1, ""), "<=+": (0, ""), ">-": (1, " BY -1"), ">=-": (0, " BY -1")}


class Statements(Expressions):
    """The lines of one function."""

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
