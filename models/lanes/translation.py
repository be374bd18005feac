"""The C of a model for several instances at once: each ``double`` becomes a vector, a lane each.

Conditions become masks. ``if`` runs both branches, each with the lanes that take it; a loop goes on
until no lane is left in it; what a lane has not reached leaves its values as they are. Each lane
does the operations of the C in their order, so that its bits are those of the FMU.

A whole number is one for all lanes where only constants and such numbers tell it: the counter of a
loop. A pointer is one for all lanes; a row of an array that lanes choose is copied, and written
back at the end of its block.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from pycparser import c_ast

from stickslip.models.errors import ModelError
from stickslip.models.export.description import Model
from stickslip.models.export.sources import shared_files, variables_header
from stickslip.models.firmware.c99 import needed, pieces
from stickslip.models.firmware.program import parsed, spelt, walk

ROOTS = ("model_start", "model_step", "model_outputs")
# type in C -> in one lane, and where it is one for all lanes; truth values are masks
_LANES = {"double": "V", "int": "I", "size_t": "I", "bool": "M", "uint64_t": "U", "void": "void"}
_ONE = {"V": "double", "I": "int64_t", "M": "bool", "U": "uint64_t"}
_VECTORS = {one: lanes for lanes, one in _ONE.items()}
_COMPARED = ("<", ">", "<=", ">=", "==", "!=")
_OF_SLOPES = ("Gradient", "Jacobian", "LawJacobian")  # structs that no step needs
_ORDER = ("I", "U", "V")  # of two types the later is that of a result


@dataclass(frozen=True)
class Type:
    """Of an expression or variable: V, I, U or M, what is one for all lanes, or a struct."""

    name: str
    sizes: tuple[str, ...] = ()  # of an array, as C
    is_pointer: bool = False
    is_const: bool = False  # what it points to stays as it is

    @property
    def element(self) -> Type:
        """Of an element, or of what a pointer points to."""
        return Type(self.name, self.sizes[1:]) if self.sizes else Type(self.name)

    @property
    def lanes(self) -> str:
        """The type of the same in each lane."""
        return _VECTORS.get(self.name, self.name)


@dataclass(frozen=True)
class Text:
    """An expression in C."""

    text: str
    type: Type

    def to(self, name: str) -> str:
        """Return it as V, I, U or M of all lanes, or as what is one for all."""
        own = self.type.name
        if own == name or self.type.is_pointer or name not in (*_ONE, *_VECTORS):
            return self.text
        if own in _VECTORS and name in _ONE:
            return f"(({name})({_ONE[name]}){'-' if name == 'M' else ''}({self.text}))"
        if own in _ONE and name in _ONE:
            return f"AS({name}, {self.text})"
        return f"(({name})({self.text}))"


@dataclass
class _Block:
    """A place with a mask of its own."""

    depth: int
    copies: list[str] = field(default_factory=list)  # statements at its end


class Translation:
    """The functions that a model needs, as C with ``lanes.h``."""

    def __init__(self, model: Model) -> None:
        sources = [*shared_files(model), model.folder / "model.c"]
        found = pieces(path.read_text(encoding="utf-8") for path in sources)
        order = needed(found, ROOTS)
        code = [variables_header(model), *(found[name] for name in order)]
        self.structs: dict[str, dict[str, Type]] = {}
        self.names: dict[str, Type] = {}  # constants
        self.functions: dict[str, tuple[Type, list[Type]]] = {}
        self.lines: list[str] = []
        for node in parsed("\n".join(code)).ext:
            match node:
                case c_ast.Typedef(type=c_ast.TypeDecl(type=c_ast.Struct(decls=members))):
                    if node.name not in _OF_SLOPES:
                        self._struct(node.name, members or [])
                case c_ast.Typedef(type=c_ast.TypeDecl(type=c_ast.IdentifierType(names=[other]))):
                    if other in self.structs:
                        self.structs[node.name] = self.structs[other]
                        self.lines.append(f"typedef {other} {node.name};")
                case c_ast.Decl(type=c_ast.Enum(values=values)):
                    self.names |= {v.name: Type("int64_t") for v in values.enumerators}
                    each = (f"{one.name} = {spelt(one.value)}" for one in values)
                    self.lines.append(f"enum {{ {', '.join(each)} }};".replace("(double)", "(V)"))
                case c_ast.Decl(type=c_ast.TypeDecl(), init=c_ast.Node()):
                    self.names[node.name] = Type("double")
                    self.lines.append(f"{spelt(node)};")
                case c_ast.FuncDef() if node.decl.name in (*order, "law_scaled"):
                    self.lines += _Function(self, node).lines

    def _struct(self, name: str, members: list[c_ast.Decl]) -> None:
        own = {one.name: self.type_of(one.type) for one in members}
        self.structs[name] = own
        if not own:
            self.lines.append(f"typedef struct {name} {name};")
            return
        inner = " ".join(f"{declared(type_, one)};" for one, type_ in own.items())
        self.lines.append(f"typedef struct {name} {{ {inner} }} {name};")

    def type_of(self, node: c_ast.Node) -> Type:
        """Return the type of a declaration, in lanes."""
        sizes = []
        while isinstance(node, c_ast.ArrayDecl):
            sizes.append(spelt(node.dim) if node.dim else "")
            node = node.type
        is_pointer = isinstance(node, c_ast.PtrDecl)
        if is_pointer:
            node = node.type
        names = getattr(node.type, "names", None)
        if names is None:
            raise ModelError(f"cannot translate the type {spelt(node)!r}")
        is_const = "const" in node.quals
        return Type(_LANES.get(names[-1], names[-1]), tuple(sizes), is_pointer, is_const)


def declared(type_: Type, name: str) -> str:
    """Return a declaration without its end."""
    star = "*" if type_.is_pointer else ""
    return f"{type_.name} {star}{name}{''.join(f'[{n}]' for n in type_.sizes)}"


class _Function:
    """A function; ``live`` is the mask of the lanes that are at a statement."""

    def __init__(self, program: Translation, node: c_ast.FuncDef) -> None:
        self.program, self.name = program, node.decl.name
        given = node.decl.type.args.params
        self.returns = program.type_of(node.decl.type.type)
        types = [program.type_of(one.type) for one in given]
        program.functions[self.name] = self.returns, types
        self.known = {one.name: t for one, t in zip(given, types, strict=True)}
        self.depths = dict.fromkeys(self.known, 0)
        self.arrays = {name for name, type_ in self.known.items() if type_.sizes}  # of the caller
        self.depth = 0  # how often the mask became smaller
        self.counters: set[str] = set()
        self.unions: dict[str, dict[str, Type]] = {}
        self.fresh = 0
        self.blocks = [_Block(0)]
        parameters = ", ".join(declared(t, one.name) for one, t in zip(given, types, strict=True))
        head = f"INLINE {self.returns.name} {self.name}(M live, {parameters}) {{"
        self.masked = sum(1 for one in walk(node.body) if isinstance(one, c_ast.Return)) > 1
        self.lines = [head, *(f"(void){one};" for one in self.known)]
        if self.masked and self.returns.name != "void":
            self.lines.append(f"{self.returns.name} result = {{0}};")
        self._statements(node.body.block_items or [])
        if self.masked and self.returns.name != "void":
            self.lines.append("return result;")
        self.lines.append("}")

    # --- expressions

    def another(self, base: str) -> str:
        """Return a name that is used nowhere else."""
        self.fresh += 1
        return f"{base}_{self.fresh}"

    def refused(self, node: c_ast.Node) -> ModelError:
        return ModelError(f"{self.name}: cannot translate {spelt(node)!r}")

    def expression(self, node: c_ast.Node) -> Text:
        """Return an expression."""
        match node:
            case c_ast.Constant(type="double"):
                return Text(node.value, Type("double"))
            case c_ast.Constant():
                is_long = node.value.startswith("0x") or "u" in node.value.lower()
                return Text(node.value, Type("uint64_t" if is_long else "int64_t"))
            case c_ast.ID(name="NULL"):
                return Text("NULL", Type("void", is_pointer=True))
            case c_ast.ID(name="true" | "false" as name):
                return Text(name, Type("bool"))
            case c_ast.ID(name=name):
                type_ = self.known.get(name) or self.program.names.get(name)
                if type_ is None:
                    raise self.refused(node)
                return Text(name, type_)
            case c_ast.StructRef(field=c_ast.ID(name=name)):
                base = self.expression(node.name)
                own = self.unions.get(base.text) or self.program.structs[base.type.name]
                return Text(f"{base.text}{node.type}{name}", own[name])
            case c_ast.ArrayRef():
                array, place = self.expression(node.name), self.expression(node.subscript)
                element = array.type.element
                if place.type.name == "int64_t":
                    return Text(f"{array.text}[{place.text}]", element)
                if element.sizes or element.name != "V":
                    raise self.refused(node)
                return Text(f"gathered(live, {array.text}, {place.to('I')})", element)
            case c_ast.UnaryOp(op="sizeof"):
                return Text(spelt(node).replace("(double)", "(V)"), Type("int64_t"))
            case c_ast.UnaryOp(op="*"):
                inner = self.expression(node.expr)
                return Text(f"(*{inner.text})", inner.type.element)
            case c_ast.UnaryOp(op="&"):
                inner = self.expression(node.expr)
                return Text(f"&{inner.text}", Type(inner.type.name, is_pointer=True))
            case c_ast.UnaryOp(op="!"):
                inner = self.condition(node.expr)
                sign = "~" if inner.type.name == "M" else "!"
                return Text(f"({sign}{inner.text})", inner.type)
            case c_ast.UnaryOp(op="-"):
                inner = self.expression(node.expr)
                return Text(f"(-{inner.text})", inner.type)
            case c_ast.BinaryOp(op="&&" | "||" as sign):
                left, right = self.condition(node.left), self.condition(node.right)
                if left.type.name == right.type.name == "bool":
                    return Text(f"({left.text} {sign} {right.text})", left.type)
                return Text(f"({left.to('M')} {sign[0]} {right.to('M')})", Type("M"))
            case c_ast.BinaryOp(op=sign):
                return self._binary(sign, self.expression(node.left), self.expression(node.right))
            case c_ast.TernaryOp():
                return self._choice(node)
            case c_ast.Cast(to_type=to):
                inner = self.expression(node.expr)
                wanted = self.program.type_of(to.type)
                if wanted.is_pointer:
                    return Text(f"(({wanted.name} *){inner.text})", wanted)
                one = _ONE.get(wanted.name, wanted.name)
                if inner.type.name in _VECTORS:
                    return Text(f"(({one}){inner.text})", Type(one))
                return Text(inner.to(wanted.name), wanted)
            case c_ast.CompoundLiteral():
                type_ = self.program.type_of(node.type.type)
                return Text(f"(({type_.name}){self._list(node.init, type_)})", type_)
            case c_ast.FuncCall(name=c_ast.ID(name=name)):
                return self._call(name, node)
        raise self.refused(node)

    def condition(self, node: c_ast.Node) -> Text:
        """Return an expression as a truth value: a mask, or one for all lanes."""
        found = self.expression(node)
        if found.type.is_pointer:
            return Text(f"({found.text} != NULL)", Type("bool"))
        if found.type.name not in ("M", "bool"):
            raise self.refused(node)
        return found

    def _binary(self, sign: str, left: Text, right: Text) -> Text:
        if left.type.is_pointer or right.type.is_pointer:
            return Text(f"({left.text} {sign} {right.text})", Type("bool"))
        if sign in ("<<", ">>"):
            return Text(f"({left.text} {sign} {right.text})", left.type)
        if {left.type.lanes, right.type.lanes} == {"M"}:
            sign = "^" if sign == "!=" else "^ ~"
            return Text(f"({left.to('M')} {sign} {right.to('M')})", Type("M"))
        if sign == "/" and left.type.name == "U" and right.text == "3":
            return Text(f"third({left.text})", left.type)
        common = max(left.type.lanes, right.type.lanes, key=_ORDER.index)
        both = [left.type.name, right.type.name]
        name = _ONE[common] if all(one in _VECTORS for one in both) else common
        text = f"({left.to(name)} {sign} {right.to(name)})"
        if sign not in _COMPARED:
            return Text(text, Type(name))
        if name in _VECTORS:
            return Text(text, Type("bool"))
        return Text(f"AS(M, {text})" if name == "I" else text, Type("M"))

    def _choice(self, node: c_ast.TernaryOp) -> Text:
        condition = self.condition(node.cond)
        if condition.type.name == "bool":
            yes, no = self.expression(node.iftrue), self.expression(node.iffalse)
            name = self._common(yes, no)
            return Text(f"({condition.text} ? {yes.to(name)} : {no.to(name)})", Type(name))
        if not any(map(_is_long, walk(node))):
            yes, no = self.expression(node.iftrue), self.expression(node.iffalse)
            name = _VECTORS.get(common := self._common(yes, no), common)
            mask = self._mask(condition.text, name)
            return Text(f"({mask} ? {yes.to(name)} : {no.to(name)})", Type(name))
        # each side with its lanes, where it has any
        mask, value = self.another("chosen"), self.another("value")
        yes, no = self.expression(node.iftrue), self.expression(node.iffalse)
        name = _VECTORS.get(common := self._common(yes, no), common)
        where, before = self._mask(mask, name), f"before_{mask}"
        lines = [
            f"const M {mask} = {condition.text}, {before} = live; {name} {value} = {{0}};",
            f"live = {before} & {mask}; if (any(live)) {value} = {yes.to(name)};",
            f"live = {before} & ~{mask};",
            f"if (any(live)) {value} = {where} ? {value} : {no.to(name)}; live = {before};",
        ]
        return Text(f"__extension__({{ {' '.join(lines)} {value}; }})", Type(name))

    def _common(self, yes: Text, no: Text) -> str:
        names = {yes.type.lanes, no.type.lanes}
        lanes = names.pop() if len(names) == 1 else max(names, key=_ORDER.index)
        both = (yes.type.name, no.type.name)
        return _ONE[lanes] if all(one in _VECTORS for one in both) else lanes

    def _mask(self, text: str, name: str) -> str:
        return f"AS(I, {text})" if name == "I" else text

    def _call(self, name: str, node: c_ast.FuncCall) -> Text:
        if name not in self.program.functions:
            raise self.refused(node)
        returns, types = self.program.functions[name]
        before, after, given = [], [], ["live"]
        for part, type_ in zip(node.args.exprs, types, strict=True):
            if isinstance(part, c_ast.ArrayRef) and (type_.is_pointer or type_.sizes):
                place = self.expression(part.subscript)
                if place.type.name != "int64_t":  # a row of which each lane has its own
                    copy, back = self._copied(part, place)
                    before += copy[1:]
                    after += [] if type_.is_const else [back]
                    given.append(copy[0])
                    continue
            given.append(self.expression(part).to(type_.name))
        call = f"{name}({', '.join(given)})"
        if before:
            kept = self.another("value")
            text = " ".join([*before, f"const {returns.name} {kept} = {call};", *after, f"{kept};"])
            return Text(f"__extension__({{ {text} }})", returns)
        return Text(call, returns)

    def _copied(self, node: c_ast.ArrayRef, place: Text) -> tuple[list[str], str]:
        """Return a name for a row that lanes choose with statements before, and one that writes."""
        array = self.expression(node.name)
        (size,) = array.type.sizes[1:]
        row, index = self.another("row"), self.another("place")
        flat = f"&{array.text}[0][0]"
        copy = [row, f"const I {index} = {place.to('I')}; V {row}[{size}] = {{0}};"]
        copy.append(f"gather(live, {row}, {flat}, {index}, {size});")
        return copy, f"scatter(live, {row}, (V *){flat}, {index}, {size});"

    def _list(self, node: c_ast.Node, type_: Type) -> str:
        """Return an initialiser."""
        if not isinstance(node, c_ast.InitList):
            return self.expression(node).to(type_.name)
        if type_.sizes:
            return f"{{{', '.join(self._list(one, type_.element) for one in node.exprs)}}}"
        members, parts = self.program.structs[type_.name], []
        for (name, own), one in zip(members.items(), node.exprs, strict=False):
            if isinstance(one, c_ast.NamedInitializer):
                name = one.name[0].name
                parts.append(f".{name} = {self._list(one.expr, members[name])}")
            elif not (isinstance(one, c_ast.Constant) and one.value == "0"):
                parts.append(f".{name} = {self._list(one, own)}")
        return f"{{{', '.join(parts) or '0'}}}"

    # --- statements

    def emit(self, line: str) -> None:
        """Add a line."""
        self.lines.append(line)

    def _statements(self, nodes: list[c_ast.Node]) -> None:
        self.blocks.append(_Block(self.depth))
        for node in nodes:
            self._statement(node)
        self.lines += self.blocks.pop().copies

    def _block(self, node: c_ast.Node | None) -> None:
        self.emit("{")
        known, depths = dict(self.known), dict(self.depths)
        is_block = node is None or isinstance(node, c_ast.Compound)
        self._statements(list(node or ()) if is_block else [node])
        self.known, self.depths = known, depths
        self.emit("}")

    def _statement(self, node: c_ast.Node) -> None:
        match node:
            case c_ast.Decl():
                self._declare(node)
            case c_ast.DeclList(decls=several) | c_ast.ExprList(exprs=several):
                for one in several:
                    self._statement(one)
            case c_ast.Compound():
                self._block(node)
            case c_ast.Assignment(op="=", lvalue=target, rvalue=c_ast.Assignment() as value):
                self._statement(value)
                self._assign(target, self.expression(value.lvalue))
            case c_ast.Assignment(op="=", lvalue=target, rvalue=value):
                self._assign(target, self.expression(value))
            case c_ast.Assignment(op=operator, lvalue=target, rvalue=value):
                both = self.expression(target), self.expression(value)
                self._assign(target, self._binary(operator[:-1], *both))
            case c_ast.UnaryOp(op="p++" | "++" | "p--" | "--" as operator, expr=target):
                one = Text("1", Type("int64_t"))
                self._assign(target, self._binary(operator[-1], self.expression(target), one))
            case c_ast.Cast():
                pass  # to void
            case c_ast.FuncCall():
                self.emit(f"{self.expression(node).text};")
            case c_ast.Return():
                self._return(node)
            case c_ast.If():
                self._if(node)
            case c_ast.While():
                self._loop(None, node.cond, None, node.stmt)
            case c_ast.For():
                self._loop(node.init, node.cond, node.next, node.stmt)
            case c_ast.Break():
                self.emit("left_lanes |= live; live = (M)(int64_t)0;")
            case c_ast.Continue():
                self.emit("later_lanes |= live; live = (M)(int64_t)0;")
            case c_ast.EmptyStatement():
                pass
            case _:
                raise self.refused(node)

    def _declare(self, node: c_ast.Decl) -> None:
        if isinstance(node.type, c_ast.TypeDecl) and isinstance(node.type.type, c_ast.Union):
            self._declare_union(node)
            return
        type_, init, name = self.program.type_of(node.type), node.init, node.name
        self.depths[name] = self.depth
        if type_.is_pointer and isinstance(init, c_ast.ArrayRef):
            place = self.expression(init.subscript)
            if place.type.name != "int64_t":
                copy, back = self._copied(init, place)
                self.lines += [*copy[1:], f"V *{name} = {copy[0]};"]
                self.blocks[-1].copies += [] if type_.is_const else [back]
                self.known[name] = type_
                return
        if isinstance(init, c_ast.ArrayRef | c_ast.StructRef) and type_.is_pointer:
            self.known[name] = type_
            self.emit(f"{type_.name} *{name} = ({type_.name} *){self.expression(init).text};")
            return
        if type_.name == "I" and not type_.sizes and init is not None:
            value = self.expression(init)
            is_one = value.type.name == "int64_t"
            if is_one and (name in self.counters or "const" in node.quals):
                type_ = Type("int64_t")
        elif type_.name == "U" and init is not None and name in self.counters:
            type_ = Type("uint64_t")
        # Lanes that take no part would compute with what the memory held: slowly, if denormal.
        text = " = {0}" if init is None else f" = {self._list(init, type_)}"
        self.known[name] = type_
        const = "static const " if "static" in node.storage else ""
        self.emit(f"{const}{declared(type_, name)}{text};")

    def _declare_union(self, node: c_ast.Decl) -> None:
        own = {one.name: self.program.type_of(one.type) for one in node.type.type.decls}
        (first,) = node.init.exprs
        inner = " ".join(f"{declared(t, one)};" for one, t in own.items())
        value = self.expression(first).to(next(iter(own.values())).name)
        self.known[node.name] = Type("union")
        self.unions[node.name] = own
        self.depths[node.name] = self.depth
        self.emit(f"union {{ {inner} }} {node.name} = {{{value}}};")

    def _assign(self, target: c_ast.Node, value: Text) -> None:
        if isinstance(target, c_ast.ArrayRef):
            place = self.expression(target.subscript)
            if place.type.name != "int64_t":
                array = self.expression(target.name)
                new = self.another("new")
                self.emit(f"{{ const V {new} = {value.to('V')};")
                self.emit(f"scatter(live, &{new}, {array.text}, {place.to('I')}, 1); }}")
                return
        left = self.expression(target)
        base = target
        while isinstance(base, c_ast.StructRef | c_ast.ArrayRef):
            if isinstance(base, c_ast.StructRef) and base.type == "->":
                break
            base = base.name
        is_local = isinstance(base, c_ast.ID) and not self.known[base.name].is_pointer
        if is_local and self.depths[base.name] == self.depth and base.name not in self.arrays:
            self.emit(f"{left.text} = {value.to(left.type.name)};")
        elif left.type.name in _ONE:
            mask = self._mask("live", left.type.name)
            self.emit(f"{left.text} = {mask} ? {value.to(left.type.name)} : {left.text};")
        elif left.type.name in self.program.structs:
            new = self.another("new")
            self.emit(f"{{ const {left.type.name} {new} = {value.text};")
            self.emit(f"blend(live, &{left.text}, &{new}, sizeof {new} / sizeof(V)); }}")
        else:
            raise self.refused(target)

    def _return(self, node: c_ast.Return) -> None:
        if node.expr is None:
            self.emit("live = (M)(int64_t)0;")
            return
        value = self.expression(node.expr).to(self.returns.name)
        if not self.masked:
            for block in self.blocks:
                for line in block.copies:
                    raise ModelError(f"{self.name}: {line} before the end")
            self.emit(f"return {value};")
        else:
            mask = self._mask("live", self.returns.name)
            self.emit(f"result = {mask} ? {value} : result; live = (M)(int64_t)0;")

    def _if(self, node: c_ast.If) -> None:
        condition = self.condition(node.cond)
        if condition.type.name == "bool":
            self.emit(f"if ({condition.text})")
            self._block(node.iftrue)
            if node.iffalse:
                self.emit("else")
                self._block(node.iffalse)
            return
        mask = self.another("if")
        self.emit(f"{{ const M {mask} = {condition.text}, before_{mask} = live;")
        self.emit(f"live = before_{mask} & {mask};")
        self.depth += 1
        self._branch(node.iftrue)
        if node.iffalse:
            self.emit(f"const M after_{mask} = live; live = before_{mask} & ~{mask};")
            self._branch(node.iffalse)
            self.emit(f"live |= after_{mask};")
        else:
            self.emit(f"live |= before_{mask} & ~{mask};")
        self.depth -= 1
        self.emit("}")

    def _branch(self, node: c_ast.Node) -> None:
        """Add a branch; what is long is left out where no lane takes it."""
        if any(map(_is_long, walk(node))):
            self.emit("if (any(live))")
        self._block(node)

    def _loop(
        self,
        init: c_ast.Node | None,
        cond: c_ast.Node | None,
        step: c_ast.Node | None,
        body: c_ast.Node,
    ) -> None:
        self.emit("{")
        known, depths = dict(self.known), dict(self.depths)
        assigned = {_root(one) for one in walk(body) if _root(one)}
        stepped = {_root(one) for one in walk(step) if _root(one)} if step else set()
        decls = getattr(init, "decls", [])
        counted = {one.name for one in decls} - assigned
        self.counters |= counted
        if init is not None:
            self._statement(init)
        counted &= {n for n in self.known if self.known[n].name in ("int64_t", "uint64_t")}
        condition = self.condition(cond) if cond is not None else Text("true", Type("bool"))
        leaving = c_ast.Break | c_ast.Return | c_ast.Continue
        ends = any(isinstance(one, leaving) for one in walk(body))
        if condition.type.name == "bool" and not ends and stepped <= counted:
            text = spelt(step) if step else ""
            self.emit(f"for (; {condition.text}; {text})")
            self._block(body)
        else:
            self._masked_loop(condition, step, body, counted)
        self.known, self.depths = known, depths
        self.counters -= counted
        self.emit("}")

    def _masked_loop(
        self, condition: Text, step: c_ast.Node | None, body: c_ast.Node, counted: set[str]
    ) -> None:
        self.emit("M left_lanes = (M)(int64_t)0; for (;;) { M later_lanes = (M)(int64_t)0;")
        goes = self.another("goes")
        self.emit(f"const M {goes} = live & {condition.to('M')};")
        self.emit(f"left_lanes |= live & ~{goes}; live = {goes}; if (!any(live)) break;")
        self.depth += 1
        self._block(body)
        self.emit("live |= later_lanes;")
        for one in step.exprs if isinstance(step, c_ast.ExprList) else [step] if step else []:
            if _root(one) in counted:
                self.emit(f"{spelt(one)};")
            else:
                self._statement(one)
        self.depth -= 1
        self.emit("} live = left_lanes;")


def _root(node: c_ast.Node) -> str:
    """Return the name of the variable that a statement assigns to; empty for another node."""
    match node:
        case c_ast.Assignment(lvalue=target):
            pass
        case c_ast.UnaryOp(op="p++" | "++" | "p--" | "--", expr=target):
            pass
        case _:
            return ""
    while isinstance(target, c_ast.StructRef | c_ast.ArrayRef):
        target = target.name
    return target.name if isinstance(target, c_ast.ID) else ""


def _is_long(node: c_ast.Node) -> bool:
    """Whether it is worth a branch to leave it out where no lane needs it."""
    kinds = c_ast.FuncCall | c_ast.For | c_ast.While
    return isinstance(node, kinds) or (isinstance(node, c_ast.BinaryOp) and node.op == "/")


def translated(model: Model) -> str:
    """Return the C of a model in lanes; ModelError where it has what cannot be translated."""
    return "\n".join(Translation(model).lines)
