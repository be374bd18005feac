"""The C that a model's steps need, parsed by pycparser, with names and types of structured text."""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import prod
from operator import add, floordiv, mul, sub

from pycparser import c_ast, c_generator, c_parser

from stickslip.models.errors import UnknownModel
from stickslip.models.export.description import Model
from stickslip.models.export.sources import shared_files, variables_header
from stickslip.models.firmware.c99 import needed, pieces, without_comments

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
SMALLEST = 2.0**-126
"""Compilers such as matiec take no literal that is not 0 and below what a REAL holds."""


def literal(value: float) -> str:
    """Return a real literal: it needs a point, also before an exponent."""
    mantissa, exponent, power = repr(float(value)).partition("e")
    return (mantissa if "." in mantissa else f"{mantissa}.0") + exponent.upper() + power


def is_reserved(name: str) -> bool:
    """Whether a name is a word of the language, in upper or lower case."""
    return name.lower() in _RESERVED.split()


def distinct(names: Iterable[str]) -> dict[str, str]:
    """Return names that differ by more than case and are not words of the language."""
    found: dict[str, str] = {}
    for name in names:
        new, taken = name, {other.lower() for other in found.values()}
        while new.lower() in taken or is_reserved(new):
            new += "_1" if new == name else "1"
        found[name] = new
    return found


ROLES = ("Inputs", "States", "Memory", "Parameters", "Outputs")
LIBRARY = {"elementary_exp": "EXP", "elementary_log": "LN", "elementary_sin": "SIN"}
_WHOLE: dict[str, Callable[[int, int], int]] = {"+": add, "-": sub, "*": mul, "/": floordiv}
_TYPEDEFS = "typedef int size_t, bool, uint32_t, uint64_t, int64_t;\n"
_MACRO = re.compile(r"^#define (\w+)\((\w+)\)(.*)", re.MULTILINE)
_COMMENT = re.compile(r"\A/\*.*?\*/\n", re.DOTALL)
_SKIPPED = re.compile(r"^#.*|\(void\)\w+[,;]", re.MULTILINE)


@dataclass(frozen=True)
class Variable:
    """A variable, parameter or member: a scalar or struct, an array, or a pointer to one."""

    name: str
    type: str
    sizes: tuple[int, ...] = ()
    is_pointer: bool = False


@dataclass(frozen=True)
class Function:
    """A function; the type of a parameter that it does not use is empty, as that of no result."""

    name: str
    returns: str
    parameters: tuple[Variable, ...]
    body: c_ast.Compound
    comment: str


class Program:
    """What the functions ``roots`` of a model need; names of functions and types have a prefix."""

    def __init__(self, model: Model, roots: Sequence[str]) -> None:
        self.prefix = model.name.capitalize()
        sources = [*shared_files(model), model.folder / "model.c"]
        found = pieces(path.read_text(encoding="utf-8") for path in sources)
        found |= dict.fromkeys(LIBRARY, "")
        order = needed(found, roots)
        self.types = {"double": "LREAL", "int": "INT", "size_t": "INT", "bool": "BOOL"}
        self.fields: dict[str, dict[str, Variable]] = {}  # struct -> member -> variable
        self.arrays: dict[str, str] = {}  # definition by name, those that others contain first
        self.constants: dict[str, c_ast.Node] = {}
        self.functions: dict[str, Function] = {}  # callees first
        # name -> parameters of the sizes that arguments have -> function
        self.variants: dict[str, dict[tuple[Variable, ...], Function]] = {}
        code = "\n".join([variables_header(model), *(found[name] for name in order)])
        for node in parsed(code).ext:
            match node:
                case c_ast.Typedef(type=c_ast.TypeDecl(type=c_ast.Struct(decls=members))):
                    if node.name in (*ROLES, *order):
                        own = {one.name: self.variable(one) for one in members or ()}
                        self.fields[node.name] = own
                        self.types[node.name] = node.name if own else ""
                case c_ast.Typedef(type=c_ast.TypeDecl(type=c_ast.IdentifierType(names=[other]))):
                    if other in ROLES:
                        self.types[node.name] = self.types[other]
                case c_ast.Decl(type=c_ast.Enum(values=values)):
                    for one in values.enumerators:
                        self.constants[one.name] = whole(self.number(one.value))
                case c_ast.Decl():
                    self.constants[node.name] = node.init
                case c_ast.FuncDef() if node.decl.name in order:
                    comment = "".join(_COMMENT.findall(found[node.decl.name]))
                    self.functions[node.decl.name] = self._function(node, comment)
        for root in roots:
            self.variant(root, [()] * len(self.functions[root].parameters))

    def _function(self, node: c_ast.FuncDef, comment: str) -> Function:
        name, declared = node.decl.name, node.decl.type
        if isinstance(declared.type, c_ast.PtrDecl):
            raise UnknownModel(f"{name} returns a pointer")
        returns = "" if spelt(declared.type) == "void" else self.type_of(declared.type)
        used = {*used_names(node.body)}
        parameters = [self.variable(one) for one in declared.args.params]
        parameters = [p if p.name in used else replace(p, type="") for p in parameters]
        return Function(name, returns, tuple(parameters), node.body, comment)

    def variable(self, node: c_ast.Decl) -> Variable:
        """Return what is declared."""
        declared, sizes = node.type, []
        while isinstance(declared, c_ast.ArrayDecl):
            sizes.append(self.number(declared.dim) if declared.dim else 0)
            declared = declared.type
        is_pointer = not sizes and isinstance(declared, c_ast.PtrDecl)
        type_ = self.type_of(declared.type if is_pointer else declared)
        return Variable(node.name, type_, tuple(sizes), is_pointer)

    def type_of(self, node: c_ast.Node) -> str:
        """Return a scalar or the name of a struct."""
        if isinstance(node, c_ast.TypeDecl) and spelt(node.type) in self.types:
            return self.types[spelt(node.type)]
        raise UnknownModel(f"cannot translate the type {spelt(node)!r}")

    def type_name(self, type_: str) -> str:
        """Return the name of a type in structured text."""
        return f"{self.prefix}_{type_}" if type_ in self.fields else type_

    def member(self, struct: str, name: str) -> str:
        """Return the name of a member, which differs from the others by more than case."""
        return distinct(self.fields[struct])[name]

    def declaration(self, one: Variable, name: str) -> str:
        """Return ``name : TYPE;``."""
        return f"    {name} : {self.array_name(one.type, one.sizes)};"

    def array_name(self, type_: str, sizes: Sequence[int]) -> str:
        """Return the name of an array's type, as the standard needs, or the type without sizes."""
        if not sizes:
            return self.type_name(type_)
        inner = self.array_name(type_, sizes[1:])
        name = "_".join([self.prefix, type_, *map(str, sizes)])
        self.arrays[name] = f"TYPE {name} : ARRAY[0..{sizes[0] - 1}] OF {inner}; END_TYPE\n"
        return name

    def number(self, node: c_ast.Node) -> int:
        """Return the value of a whole expression of constants; sizes are in doubles."""
        match node:
            case c_ast.Constant(type="int", value=value) if value.isdigit():
                return int(value)
            case c_ast.ID(name=name) if name in self.constants:
                return self.number(self.constants[name])
            case c_ast.UnaryOp(op="sizeof", expr=c_ast.Typename()) if spelt(node.expr) == "double":
                return 1
            case c_ast.UnaryOp(op="sizeof", expr=c_ast.StructRef(name=c_ast.Cast() as of) as one):
                struct = self.type_of(of.to_type.type.type)
                return prod(self.fields[struct][one.field.name].sizes)
            case c_ast.BinaryOp(op=operator) if operator in _WHOLE:
                return _WHOLE[operator](self.number(node.left), self.number(node.right))
        raise UnknownModel(f"{spelt(node)!r} is not a whole constant")

    def variant(self, name: str, sizes: Sequence[tuple[int, ...]]) -> Function:
        """Return a function for arguments of these sizes; each other size makes another one."""
        function, known = self.functions[name], self.variants.setdefault(name, {})
        pairs = zip(function.parameters, sizes, strict=True)
        wanted = tuple(replace(p, sizes=s) if p.sizes or p.is_pointer else p for p, s in pairs)
        own = f"{name}_{len(known)}" if known else name
        return known.setdefault(wanted, replace(function, name=own, parameters=wanted))


def parsed(text: str) -> c_ast.FileAST:
    """Return the tree of C; macros of one argument are replaced by what they stand for."""
    text = without_comments(text).replace("\\\n", " ")
    macros = _MACRO.findall(text)
    text = _SKIPPED.sub("", text)
    for name, argument, body in macros:
        given = re.sub(rf"\b{argument}\b", r"\\1", body)
        text = re.sub(rf"\b{name}\((\w+)\)", given, text)
    try:
        return c_parser.CParser().parse(_TYPEDEFS + text)
    except c_parser.ParseError as error:
        raise UnknownModel(f"cannot read {error}") from None


def whole(number: int) -> c_ast.Constant:
    """Return a number as a tree."""
    return c_ast.Constant("int", str(number))


def spelt(node: c_ast.Node) -> str:
    """Return a tree as C."""
    return " ".join(c_generator.CGenerator().visit(node).split())


def walk(node: c_ast.Node) -> Iterator[c_ast.Node]:
    """Yield a tree and all trees in it."""
    yield node
    for inner in node:
        yield from walk(inner)


def used_names(node: c_ast.Node) -> Iterator[str]:
    """Yield the names of variables, constants and functions in a tree."""
    match node:
        case c_ast.ID():
            yield node.name
        case c_ast.StructRef(name=inner) | c_ast.NamedInitializer(expr=inner):
            yield from used_names(inner)
        case _:
            for inner in node:
                yield from used_names(inner)
