"""The C of a model as functions and types of structured text (IEC 61131-3).

Structs become STRUCTs and what a pointer points to VAR_IN_OUT. A conditional expression becomes IF
before the statement that it is in. exp, log and sin are those of the controller.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from stickslip.models.errors import UnknownModel
from stickslip.models.export.description import Model, Role
from stickslip.models.export.sources import shared_files
from stickslip.models.firmware.amalgam import needed, pieces, without_comments
from stickslip.models.firmware.c_syntax import Declared, Function, Node, Reader, Statement

_ROLES: dict[str, Role] = {
    "Inputs": "input",
    "States": "state",
    "Memory": "memory",
    "Parameters": "parameter",
    "Outputs": "output",
}
_ALIASES = {"Law": "Parameters", "LawState": "States"}
_LIBRARY = {"elementary_exp": "exp", "elementary_log": "LN", "elementary_sin": "SIN"}
_NULL = Node("name", "NULL")
_BINDING = {"OR": 1, "AND": 2, "=": 3, "<>": 3, "<": 4, ">": 4, "<=": 4, ">=": 4}
_BINDING |= {"+": 5, "-": 5, "*": 6, "/": 6}
_SPELT = {"||": "OR", "&&": "AND", "==": "=", "!=": "<>"}
_RESERVED = """
    abs abstract and any array at bool by byte case char clk concat configuration constant
    cos date delete dint div do dt dword else elsif end exit exp expt extends false final
    find for from function if implements in insert int interface internal jmp ld left len
    limit ln log lreal lword max method mid min mod move mux n ne not of on or out pointer
    private program property protected public r read real reference replace resource ret
    retain return right s sel shl shr sin sint sqrt st step stn string struct super tan task
    then this time to tod true trunc type udint uint until usint var when while with word
    write xor
"""
_SIZE = re.compile(r"sizeof\(\(\w+ \*\)NULL\)->(\w+) / sizeof\(double\)")
_MACRO = re.compile(r"^#define (\w+)\((\w+)\)(.*)", re.DOTALL)
SMALLEST = 2.0**-126
"""Compilers such as matiec take no literal that is not 0 and below what a REAL holds."""

Text = tuple[str, str, int]
"""An expression in structured text, its type, and how it binds: 9 for what needs no brackets."""


def literal(value: float) -> str:
    """Return a real literal: it needs a point, also before an exponent."""
    mantissa, exponent, power = repr(float(value)).partition("e")
    return (mantissa if "." in mantissa else f"{mantissa}.0") + exponent.upper() + power


class Translation:
    """The functions that a model's steps need, in structured text.

    Attributes
    ----------
    text : TYPEs and FUNCTIONs, callees first
    """

    def __init__(self, model: Model, roots: Sequence[str]) -> None:
        self.prefix = model.name.capitalize()
        sources = [*shared_files(model), model.folder / "model.c"]
        found = pieces(path.read_text(encoding="utf-8") for path in sources)
        order = needed(found | dict.fromkeys(_LIBRARY, ""), roots)
        found |= dict.fromkeys(_LIBRARY, "")
        self.fields: dict[str, list[Declared]] = {
            struct: [
                Declared(name, "LREAL", tuple(Node("number", str(n)) for n in size))
                for name, size in model.fields.get(role, ())
            ]
            for struct, role in _ROLES.items()
        }
        self.sizes = {
            name: size[0] for fields in model.fields.values() for name, size in fields if size
        }
        self.structs = {name: name for name, fields in self.fields.items() if fields}
        self.structs |= {
            alias: name for alias, name in _ALIASES.items() if name in self.structs and model.law
        }
        self.missing = {name for name in _ROLES if name not in self.structs}
        self.constants: dict[str, str] = {}
        self.functions: dict[str, Function] = {}
        self.comments: dict[str, str] = {}
        own: list[str] = []
        macros = [match for name in order if (match := _MACRO.match(_code(found.get(name, ""))))]
        for name in order:
            code = _code(found.get(name, ""))
            for macro in macros:
                code = _expanded(code, macro)
            if not code or code.startswith("#define"):
                continue
            if match := re.match(r"static const double (\w+) = (.*);", code):
                self.constants[match[1]] = match[2]
            elif match := re.match(r"enum \{ (\w+) = (.*) \};", code):
                size = _SIZE.fullmatch(match[2])
                self.constants[match[1]] = str(self.sizes[size[1]]) if size else match[2]
            elif code.startswith("typedef"):
                self.structs[name] = name
                self.fields[name] = Reader(code, self.structs).members()
                own.append(name)
            else:
                known = self.structs | dict.fromkeys(self.missing, "")
                function = Reader(code, known).function()
                used = set(_names(function.body))
                function.parameters = [
                    p if p.name in used else replace(p, type="") for p in function.parameters
                ]
                self.functions[name] = function
                self.comments[name] = (
                    found[name][: found[name].index("*/") + 2]
                    if (found[name].startswith("/*"))
                    else ""
                )
        self.variants: dict[str, list[Function]] = {name: [] for name in self.functions}
        for root in roots:
            self.variant(root, [()] * len(self.functions[root].parameters))
        bodies = [
            self._function(variant)
            for name in reversed(self.functions)
            for variant in self.variants[name]
        ]
        types = [self._struct(name) for name in (*filter(self.structs.get, _ROLES), *own)]
        self.text = "\n".join([*types, _EXP.format(prefix=self.prefix), *reversed(bodies)])

    def type_name(self, type_: str) -> str:
        """Return the name of a type in structured text."""
        return f"{self.prefix}_{type_}" if type_ in self.fields else type_

    def member(self, struct: str, name: str) -> str:
        """Return the name of a member, which differs from the others by more than case."""
        names = [one.name for one in self.fields[struct]]
        return distinct(names)[name]

    def number(self, node: Node) -> int:
        """Return the value of a whole expression of constants."""
        if node.kind == "number":
            return int(node.word)
        if node.kind == "name" and node.word in self.constants:
            return self.number(Reader(self.constants[node.word], {}).expression())
        if node.kind == "binary" and node.word in "+-*":
            a, b = map(self.number, node.parts)
            return {"+": a + b, "-": a - b, "*": a * b}[node.word]
        raise UnknownModel(f"{node.word!r} is not a whole constant")

    def variant(self, name: str, sizes: Sequence[tuple[Node, ...]]) -> Function:
        """Return a function for arguments of these sizes; each other size makes another one."""
        function = self.functions[name]
        wanted = [
            replace(p, sizes=tuple(Node("number", str(self.number(n))) for n in size))
            if p.sizes or p.is_pointer
            else p
            for p, size in zip(function.parameters, sizes, strict=True)
        ]
        for known in self.variants[name]:
            if known.parameters == wanted:
                return known
        number = len(self.variants[name])
        new = replace(function, name=f"{name}_{number}" if number else name, parameters=wanted)
        self.comments[new.name] = self.comments[name]
        self.variants[name].append(new)
        return new

    def declaration(self, one: Declared, name: str) -> str:
        """Return ``name : TYPE;``."""
        array = "".join(f"ARRAY[0..{self.number(size) - 1}] OF " for size in one.sizes)
        return f"    {name} : {array}{self.type_name(one.type)};"

    def _struct(self, name: str) -> str:
        lines = [self.declaration(one, self.member(name, one.name)) for one in self.fields[name]]
        head = f"TYPE {self.type_name(name)} :\nSTRUCT\n"
        return head + "\n".join(lines) + "\nEND_STRUCT;\nEND_TYPE\n"

    def _function(self, function: Function) -> str:
        body = _Body(self, function)
        comment = self.comments[function.name]
        return body.text(comment.replace("/*", "(*").replace("*/", "*)").replace("\n * ", "\n   "))


_EXP = """(* e^x without overflow and underflow *)
FUNCTION {prefix}_exp : LREAL
VAR_INPUT
    x : LREAL;
END_VAR
    IF x < -700.0 THEN
        {prefix}_exp := 0.0;
    ELSIF x > 700.0 THEN
        {prefix}_exp := EXP(700.0);
    ELSE
        {prefix}_exp := EXP(x);
    END_IF;
END_FUNCTION
"""


class _Body:
    """The statements of one function."""

    def __init__(self, whole: Translation, function: Function) -> None:
        self.whole, self.function = whole, function
        self.parameters = [p for p in function.parameters if p.type not in ("", None)]
        self.locals: dict[str, Declared] = {}
        self.aliases: dict[str, Node] = {}
        self._collect(function.body)
        self.own = f"{whole.prefix}_{function.name}"
        self.names = distinct([*(p.name for p in self.parameters), *self.locals])
        self.known = {p.name: p for p in self.parameters} | self.locals
        self.spare: list[str] = []
        self.lines: list[str] = []
        self.depth = 1

    def text(self, comment: str) -> str:
        """Return the function."""
        self.block(self.function.body, is_last=True)
        sections = {
            "VAR_INPUT": [p for p in self.parameters if not (p.is_pointer or p.sizes)],
            "VAR_IN_OUT": [p for p in self.parameters if p.is_pointer or p.sizes],
            "VAR": list(self.locals.values()),
        }
        lines = [f"FUNCTION {self.own} : {self.whole.type_name(self.function.returns) or 'BOOL'}"]
        for section, variables in sections.items():
            shown = [self.whole.declaration(one, self.names[one.name]) for one in variables]
            shown += self.spare if section == "VAR" else []
            if shown:
                lines += [section, *shown, "END_VAR"]
        head = [comment.strip()] if comment else []
        return "\n".join([*head, *lines, *self.lines, "END_FUNCTION", ""])

    def _collect(self, statements: Iterable[Statement]) -> None:
        for one in statements:
            if one.variable is not None and not one.variable.is_pointer:
                known = self.locals.setdefault(one.variable.name, one.variable)
                if known != one.variable:
                    raise UnknownModel(f"{one.variable.name} has two types")
            for block in one.blocks:
                self._collect(block)

    def emit(self, line: str) -> None:
        self.lines.append("    " * self.depth + line)

    def inner(self, *parts: Callable[[], None]) -> None:
        self.depth += 1
        before = len(self.lines)
        for statements in parts:
            statements()
        if len(self.lines) == before:
            self.emit(";")
        self.depth -= 1

    # Statements

    def block(self, statements: Sequence[Statement], *, is_last: bool = False) -> None:
        for k, one in enumerate(statements):
            ends = is_last and k + 1 == len(statements)
            rest = statements[k + 1 :]
            if one.kind == "if" and one.blocks[0][-1:] == (Statement("continue"),):
                first, otherwise = one.blocks[0][:-1], one.blocks[1]
                whole = replace(one, blocks=(first, (*otherwise, *rest)))
                self.statement(whole, is_last=False)
                return
            self.statement(one, is_last=ends)

    def statement(self, one: Statement, *, is_last: bool) -> None:
        if one.kind == "declare":
            assert one.variable is not None  # noqa: S101 - of each declaration
            if one.variable.is_pointer and one.nodes[0] is not None:
                self.aliases[one.variable.name] = self._frozen(one.nodes[0])
            elif (value := one.nodes[0]) is not None:
                self.assign(Node("name", one.variable.name), value)
        elif one.kind == "do":
            self._do(one)
        elif one.kind == "return":
            self._return(one.nodes[0], is_last=is_last)
        elif one.kind == "if":
            self._if(one, is_last=is_last)
        elif one.kind == "while":
            self._while(one.nodes[0], one.blocks[0], ())
        elif one.kind == "for":
            self._for(one)
        elif one.kind == "break":
            self.emit("EXIT;")
        else:
            raise UnknownModel(f"{self.function.name}: cannot translate {one.kind}")

    def _do(self, one: Statement) -> None:
        target = one.nodes[0]
        assert target is not None  # noqa: S101 - of each statement
        if len(one.nodes) == 1:
            if target.kind == "call":
                call, type_, _ = self.expression(target)
                name = f"ignored_{type_}" if type_ else "done"
                self._spare(name, self.whole.type_name(type_) or "BOOL")
                self.emit(f"{name} := {call};")
            return
        value = one.nodes[1]
        assert value is not None  # noqa: S101 - of each assignment
        if one.word != "=":
            value = Node("binary", one.word[0], (target, value))
        self.assign(target, value)

    def _return(self, value: Node | None, *, is_last: bool) -> None:
        if value is not None:
            self.assign(Node("result"), value)
        if not is_last:
            self.emit("RETURN;")

    def _if(self, one: Statement, *, is_last: bool) -> None:
        condition = one.nodes[0]
        assert condition is not None  # noqa: S101 - of each if
        then, otherwise = one.blocks
        self.emit(f"IF {self.expression(condition)[0]} THEN")
        self.inner(lambda: self.block(then, is_last=is_last))
        if otherwise:
            self.otherwise(lambda: self.block(otherwise, is_last=is_last))
        self.emit("END_IF;")

    def otherwise(self, statements: Callable[[], None]) -> None:
        """Emit ELSE, or ELSIF where all that follows is one IF."""
        place = len(self.lines)
        self.emit("ELSE")
        self.inner(statements)
        inner, margin = self.lines[place + 1 :], "    " * (self.depth + 1)
        ends = [k for k, line in enumerate(inner) if line == f"{margin}END_IF;"]
        if inner[0].startswith(f"{margin}IF ") and ends[:1] == [len(inner) - 1]:
            moved = [line[4:] for line in inner[:-1]]
            self.lines[place:] = [moved[0].replace("IF ", "ELSIF ", 1), *moved[1:]]

    def _while(
        self, condition: Node | None, body: Sequence[Statement], last: Sequence[Statement]
    ) -> None:
        before = len(self.lines)
        test = "TRUE" if condition is None else self.expression(condition)[0]
        if len(self.lines) > before:
            raise UnknownModel(f"{self.function.name}: the condition of a loop has a choice in it")
        self.emit(f"WHILE {test} DO")
        self.inner(lambda: self.block(body), lambda: self.block(last))
        self.emit("END_WHILE;")

    def _for(self, one: Statement) -> None:
        first, last, body = one.blocks
        counted = self._counted(one)
        if counted is None:
            self.block(first)
            self._while(one.nodes[0], body, last)
            return
        self.emit(f"FOR {counted} DO")
        self.inner(lambda: self.block(body))
        self.emit("END_FOR;")

    def _counted(self, one: Statement) -> str | None:
        """Return ``i := 0 TO n - 1`` of a loop that counts, whose bound stays as it is."""
        first, last, body = one.blocks
        condition = one.nodes[0]
        if len(first) != 1 or len(last) != 1 or condition is None or len(condition.parts) != 2:
            return None
        start = first[0].nodes[-1]
        name = first[0].variable.name if first[0].variable else ""
        if start is None or not name or self.locals[name].type != "INT":
            return None
        counter, bound = condition.parts
        operator = {
            "<": (" - 1", ""),
            "<=": ("", ""),
            ">": (" + 1", " BY -1"),
            ">=": ("", " BY -1"),
        }
        if counter.word != name or condition.word not in operator or "call" in bound.kind:
            return None
        changed = {name, *bound.names()} & set(_assigned(body))
        if changed:
            return None
        more, by = operator[condition.word]
        begin, end = self.expression(start)[0], self.expression(bound)[0]
        if more and end.isdigit():
            end, more = str(int(end) + (1 if "+" in more else -1)), ""
        return f"{self.names[name]} := {begin} TO {end}{more}{by}"

    def assign(self, target: Node, value: Node) -> None:
        """Emit an assignment; a choice or a list becomes several."""
        if value.kind == "cast" and value.parts[0].kind == "list":
            value = value.parts[0]
        if value.kind == "choice":
            condition, *both = value.parts
            self.emit(f"IF {self.expression(condition)[0]} THEN")
            self.inner(lambda: self.assign(target, both[0]))
            self.otherwise(lambda: self.assign(target, both[1]))
            self.emit("END_IF;")
        elif value.kind == "list":
            self._list(target, value)
        else:
            left, type_ = self._target(target)
            self.emit(f"{left} := {self._as(self.expression(value), type_)[0]};")

    def _list(self, target: Node, value: Node) -> None:
        _, type_ = self._target(target)
        if type_ not in self.whole.fields:
            for k, part in enumerate(value.parts):
                self.assign(Node("index", "", (target, Node("number", str(k)))), part)
            return
        fields = self.whole.fields[type_]
        names = [word or fields[k].name for k, word in enumerate(value.words)]
        given = dict(zip(names, value.parts, strict=True))
        for one in fields:
            if one.name in given:
                self.assign(Node("member", one.name, (target,)), given[one.name])
            elif not one.sizes and type_ not in _ROLES:
                self.assign(Node("member", one.name, (target,)), Node("number", "0"))

    def _target(self, node: Node) -> tuple[str, str]:
        if node.kind == "result":
            return self.own, self.function.returns
        left, type_, _ = self.expression(node)
        return left, type_

    def _spare(self, name: str, type_: str) -> str:
        line = f"    {name} : {type_};"
        if line not in self.spare:
            self.spare.append(line)
        return name

    # Expressions

    def expression(self, node: Node) -> Text:
        """Return an expression; what has to be done before it is emitted."""
        found: Text = getattr(self, f"_{node.kind}")(node)
        return found

    def _as(self, text: Text, type_: str) -> Text:
        """Return a whole number as a real one where that is needed."""
        if text[1] == "INT" and type_ == "LREAL":
            if text[0].lstrip("-").isdigit():
                return f"{text[0]}.0", "LREAL", text[2]
            return f"INT_TO_LREAL({text[0]})", "LREAL", 9
        return text

    def _number(self, node: Node) -> Text:
        if node.word.isdigit():
            return node.word, "INT", 9
        value = float(node.word)
        return literal(value if not 0.0 < value < SMALLEST else SMALLEST), "LREAL", 9

    def _name(self, node: Node) -> Text:
        if node.word in self.aliases:
            return self.expression(self.aliases[node.word])
        if node.word in self.known:
            return self.names[node.word], self.known[node.word].type, 9
        if node.word in self.whole.constants:
            inner = Reader(self.whole.constants[node.word], {}).expression()
            return self.expression(inner)
        raise UnknownModel(f"{self.function.name}: {node.word} is not known")

    def _member(self, node: Node) -> Text:
        base, struct, _ = self.expression(node.parts[0])
        [one] = [one for one in self.whole.fields[struct] if one.name == node.word]
        return f"{base}.{self.whole.member(struct, node.word)}", one.type, 9

    def _index(self, node: Node) -> Text:
        base, place = node.parts
        array, type_, _ = self.expression(base)
        return f"{array}[{self.expression(place)[0]}]", type_, 9

    def _sizes(self, node: Node) -> tuple[Node, ...]:
        """Return the sizes of a variable, a member or an element."""
        if node.kind == "name" and node.word in self.aliases:
            return self._sizes(self.aliases[node.word])
        if node.kind == "name":
            return self.known[node.word].sizes if node.word in self.known else ()
        if node.kind == "member":
            struct = self.expression(node.parts[0])[1]
            [one] = [one for one in self.whole.fields[struct] if one.name == node.word]
            return one.sizes
        return self._sizes(node.parts[0])[1:] if node.kind == "index" else ()

    def _frozen(self, node: Node) -> Node:
        """Return what a pointer points to, with its indices as they are now."""
        if node.kind in ("member", "index"):
            base, *place = node.parts
            places = tuple(self._kept(one) for one in place)
            return replace(node, parts=(self._frozen(base), *places))
        return node

    def _kept(self, node: Node) -> Node:
        """Return a variable that keeps the value of a whole expression."""
        return node if node.kind == "number" else Node("name", self._new(node, "INT"))

    def _unary(self, node: Node) -> Text:
        inner, type_, binding = self.expression(node.parts[0])
        if node.word in "*&":
            return inner, type_, binding
        sign = "NOT " if node.word == "!" else "-"
        return f"{sign}{inner if binding > 6 else f'({inner})'}", type_, 6

    def _binary(self, node: Node) -> Text:
        if node.parts[1] == _NULL:  # a variable stands in its place, which nothing reads
            return ("TRUE" if node.word == "!=" else "FALSE"), "BOOL", 9
        left, right = (self.expression(part) for part in node.parts)
        common = "LREAL" if "LREAL" in (left[1], right[1]) else left[1]
        left, right = self._as(left, common), self._as(right, common)
        operator = _SPELT.get(node.word, node.word)
        binding = _BINDING[operator]
        a = left[0] if left[2] >= binding else f"({left[0]})"
        b = right[0] if right[2] > binding and right[0][0] != "-" else f"({right[0]})"
        return f"{a} {operator} {b}", "BOOL" if binding < 5 else common, binding

    def _choice(self, node: Node) -> Text:
        types = {self.expression(part)[1] for part in node.parts[1:] if part.kind != "choice"}
        type_ = "LREAL" if "LREAL" in types else types.pop()
        return self._new(node, type_), type_, 9

    def _new(self, value: Node, type_: str) -> str:
        """Return a further variable that has a value."""
        name = self._spare(f"value_{len(self.spare)}", self.whole.type_name(type_))
        self.known[name] = Declared(name, type_)
        self.names[name] = name
        self.assign(Node("name", name), value)
        return name

    def _cast(self, node: Node) -> Text:
        inner = self.expression(node.parts[0])
        if (inner[1], node.word) == ("LREAL", "INT"):
            return f"DINT_TO_INT(TRUNC({inner[0]}))", "INT", 9
        return self._as(inner, node.word)

    def _call(self, node: Node) -> Text:
        if node.word in _LIBRARY:
            inner = self._as(self.expression(node.parts[0]), "LREAL")[0]
            name = _LIBRARY[node.word]
            if name == "exp":
                return f"{self.whole.prefix}_exp(x := {inner})", "LREAL", 9
            return f"{name}({inner})", "LREAL", 9
        called = self.whole.variant(node.word, [self._sizes(part) for part in node.parts])
        arguments = []
        names = distinct([p.name for p in called.parameters if p.type])
        for parameter, part in zip(called.parameters, node.parts, strict=True):
            if not parameter.type:
                continue
            if part == _NULL:
                text = self._spare("nothing", self.whole.type_name(parameter.type))
            else:
                text = self._as(self.expression(part), parameter.type)[0]
            arguments.append(f"{names[parameter.name]} := {text}")
        return f"{self.whole.prefix}_{called.name}({', '.join(arguments)})", called.returns, 9


def _names(statements: Iterable[Statement]) -> Iterable[str]:
    """Yield all names that statements use."""
    for one in statements:
        for node in one.nodes:
            yield from node.names() if node is not None else ()
        for block in one.blocks:
            yield from _names(block)


def _assigned(statements: Iterable[Statement]) -> Iterable[str]:
    """Yield the names of variables that statements assign to, or hand to a function."""
    for one in statements:
        if one.kind == "do" and one.nodes[0] is not None:
            target = one.nodes[0]
            while target.kind in ("index", "member"):
                target = target.parts[0]
            yield from target.names()
        if one.variable is not None:
            yield one.variable.name
        for block in one.blocks:
            yield from _assigned(block)


def distinct(names: Iterable[str]) -> dict[str, str]:
    """Return names that differ by more than case and are not words of the language."""
    found: dict[str, str] = {}
    for name in names:
        new, taken = name, {other.lower() for other in found.values()}
        while new.lower() in taken | {*_RESERVED.split()}:
            new += "_1" if new == name else "1"
        found[name] = new
    return found


def _code(text: str) -> str:
    """Return a definition without comments."""
    return without_comments(text).strip()


def _expanded(code: str, macro: re.Match[str]) -> str:
    """Return C with a macro of one argument replaced by what it stands for."""
    name, argument, body = macro.groups()
    body = body.replace("\\\n", " ").strip()

    def replaced(match: re.Match[str]) -> str:
        return re.sub(rf"\b{argument}\b", match[1], body)

    return code if code.startswith("#define") else re.sub(rf"\b{name}\((\w+)\)", replaced, code)
