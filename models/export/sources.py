"""The C of an FMU: structs and a table generated from model.toml, and how it is compiled."""

from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from struct import pack
from typing import Literal
from xml.etree import ElementTree as ET

from stickslip import fmi
from stickslip.fmi.description import writing
from stickslip.fmi.standard import standard_files
from stickslip.models.export.description import Model, Role, Variable
from stickslip.models.export.law import MODELS, Law, roots

_STRUCTS: dict[Role, str] = {
    "input": "Inputs",
    "state": "States",
    "derivative": "Derivatives",
    "indicator": "Indicators",
    "output": "Outputs",
    "memory": "Memory",
    "parameter": "Parameters",
}
_LARGEST = "1.7976931348623157e308"
_HEAD = '/* Generated from model.toml. */\n#include "instance.h"\n\n'
MARKER = "stickslip start values"
MARKER_SIZE, TOKEN_SIZE = 24, 40  # bytes, with the 0


def variables_header(model: Model) -> str:
    """Return ``variables.h``: a struct of doubles for each role."""
    lines = ["/* Generated from model.toml. */", "#ifndef VARIABLES_H", "#define VARIABLES_H", ""]
    for role, struct in _STRUCTS.items():
        # A derivative goes by the name of its state.
        fields = model.fields.get(role, ())
        if not fields:
            lines += [f"typedef struct {struct} {struct}; /* has no variables */", ""]
            continue
        lines.append("typedef struct {")
        lines += [f"    double {_member(field)};" for field in fields]
        lines += [f"}} {struct};", ""]
    return "\n".join([*lines, *_jacobian(model), *_law(model), "#endif", ""])


def _member(field: tuple[str, tuple[int, ...]]) -> str:
    name, size = field
    return name + "".join(f"[{n}]" for n in size)


def _jacobian(model: Model) -> list[str]:
    """Return the struct of all partial derivatives: a row of states and inputs for each result."""
    if not model.is_continuous or model.is_switched:
        return ["typedef struct Jacobian Jacobian; /* has no derivatives */", ""]
    rows = {role: ", ".join(map(_member, model.fields.get(role, ()))) for role in _STRUCTS}
    return [
        "typedef struct {\n    States x;\n    Inputs u;\n} Gradient;\n",
        f"typedef struct {{\n    struct {{\n        Gradient {rows['derivative']};\n    }} dx;",
        f"    struct {{\n        Gradient {rows['output']};\n    }} y;\n}} Jacobian;\n",
    ]


def law_scaled(law: Law) -> str:
    """Return the C of a law that is `factor` times as large: its forces are; see laws/law.h."""
    forces = (f"    q.{p.name} *= factor;" for p in law.parameters.values() if p.unit == "N")
    head = "static inline Law law_scaled(const Law *p, double factor) {"
    return "\n".join([head, "    Law q = *p;", *forces, "    return q;", "}"])


def _law(model: Model) -> list[str]:
    """Return what laws/law.h calls a law's parameters, states, derivatives and Jacobian."""
    law = model.law
    if law is None:
        return []
    states = list(law.states)
    lines = [f"#define LAW_IS_SMOOTH {law.is_smooth:d}"]
    lines += [f"#define LAW_SWITCHES {model.is_switched:d}", "typedef Parameters Law;"]
    lines.append(f"typedef {'Memory' if model.sampled else 'States'} LawState;")
    lines += [law_scaled(law), ""]
    if model.is_switched:
        return [*lines, "typedef Derivatives LawRate;", "typedef Indicators LawEvents;", ""]
    if not law.is_smooth:
        return [*lines, ""]
    columns = ", ".join(["v", *states])
    lines += ["", "typedef struct {"]
    lines += ["    struct {", f"        double {columns};", f"    }} {', '.join(['F', *states])};"]
    lines += ["} LawJacobian;", ""]
    if not model.is_continuous:
        members = [f"    double {name};" for name in states]
        return [*lines, "typedef struct {", *members, "} LawRate;", ""]
    v = "x.v" if any(v.name == "v" and v.role == "state" for v in model.variables) else "u.v"
    rows = {"(*F)": "F"} | {f"J->dx.{name}": name for name in states}
    return [
        *lines,
        "typedef Derivatives LawRate;\n",
        "/* Write the law's Jacobian into the rows of the force and of the law's states. */",
        "static inline void law_rows(const LawJacobian *law, Gradient *F, Jacobian *J) {",
        *(
            f"    {row}.{'x.' * (column != 'v')}{v if column == 'v' else column}"
            f" = law->{own}.{column};"
            for row, own in rows.items()
            for column in ("v", *states)
        ),
        "}\n",
    ]


def table_header(model: Model) -> str:
    """Return ``table.h``: how many variables there are, and where each role begins."""
    roles = [v.role for v in model.variables]
    numbers = {"COUNT": len(roles)}
    for role, struct in {**_STRUCTS, "mode": "Modes"}.items():
        numbers[f"{struct.upper()}_AT"] = roles.index(role) if role in roles else len(roles)
        numbers[f"{struct.upper()}_COUNT"] = roles.count(role)
    return f"""/* Generated from model.toml. */
#ifndef TABLE_H
#define TABLE_H

#define START_MARKER_SIZE {MARKER_SIZE}
#define START_TOKEN_SIZE {TOKEN_SIZE}

#define IS_CONTINUOUS {model.is_continuous:d}
#define IS_SWITCHED {model.is_switched:d}
#define HAS_SLOPES {model.is_continuous and not model.is_switched:d}
#define IS_SAMPLED {model.sampled:d}

enum {{
{"".join(f"    {name} = {number},{chr(10)}" for name, number in numbers.items())}}};

#endif
"""


def table_source(model: Model) -> str:
    """Return ``table.c``: name, type, phases to set it in, range and nominal of every variable."""
    rows = "".join(f"    {_row(v)}\n" for v in model.variables)
    return f"{_HEAD}const Variable VARIABLES[COUNT] = {{\n{rows}}};\n"


def start_source(token: str, values: Sequence[float]) -> str:
    """Return ``start.c``: the token, and the start value of every variable (COUNT,)."""
    numbers = "".join(f"    {value!r},\n" for value in map(float, values))
    return f'{_HEAD}const Start START = {{"{MARKER}", "{token}", {{\n{numbers}}}}};\n'


def start_bytes(token: str, values: Sequence[float]) -> bytes:
    """Return what a library with ``start.c`` contains behind the marker."""
    return token.encode().ljust(TOKEN_SIZE, b"\0") + pack(f"<{len(values)}d", *values)


def _row(v: Variable) -> str:
    low = f"-{_LARGEST}" if v.minimum is None else repr(float(v.minimum))
    high = _LARGEST if v.maximum is None else repr(float(v.maximum))
    derived = v.role in ("derivative", "indicator", "mode")
    kind = "DERIVATIVE" if derived else v.type.upper()
    nominal = v.nominal or 1.0
    return f'{{"{v.name}", {kind}, {_phases(v)}, {low}, {high}, {nominal!r}}},'


def _phases(v: Variable) -> str:
    before = "INSTANTIATED | INITIALIZATION"
    if v.role == "input":
        return f"{before} | STEPPING | EVENT | CONTINUOUS"
    if v.variability == "tunable":
        return f"{before} | STEPPING | EVENT"
    return before if v.role in ("state", "parameter") else "0"


def _place(path: Path, places: Iterable[Path]) -> str:
    """Return the path of a C file in the source tree of an FMU."""
    root = next(root for root in places if path.is_relative_to(root))
    return path.relative_to(root).as_posix()


FmiVersion = Literal[2, 3]
FACES = Path(fmi.__file__).parent / "faces"
# Files that are the same for all models, and in no step: the functions of FMI are called faster
# where they are compiled with the model, by 7 to 20 % of a step.
_COMMON = "heap", "text"
START = "start.c"  # the token and the start values
# Without fused multiply-add, all compilers give the same bits; scalar equations packed into vectors
# took a tenth more time.
COMPILER_OPTIONS = "-O2 -ffp-contract=off -fno-tree-slp-vectorize"


def text(path: Path) -> str:
    """Return a text file."""
    return path.read_text(encoding="utf-8")


def c_files(model: Model, fmi: FmiVersion) -> dict[str, str]:
    """Return the C files of an FMU by path in the source tree, all but ``START``."""
    files = {
        path.name: text(path)
        for folder in (MODELS / "adapter", FACES)
        for path in sorted(folder.glob("*.[ch]"))
        if not path.name.startswith(f"fmi{5 - fmi}")  # the other standard
    }
    places = roots()
    return files | {
        **{_place(path, places): text(path) for path in shared_files(model)},
        **{path.name: text(path) for path in sorted(model.folder.glob("*.[ch]"))},
        "variables.h": variables_header(model),
        "table.h": table_header(model),
        "table.c": table_source(model),
    }


def shared_files(model: Model) -> list[Path]:
    """Return the C files that a model has from other rooms: numerics, its law and its motion."""
    files = [*(MODELS / "numerics").glob("*.[ch]"), *model.sources]
    if model.law is not None:
        files += [*(MODELS / "laws").glob("*.h"), *model.law.folder.glob("*.[ch]")]
        if model.folder.parent.name == "plants":
            own, plants = model.law.folder / "motion.c", MODELS / "plants"
            needs = own.read_text(encoding="utf-8") if own.exists() else ""
            files += [plants / "motion.h", *([] if needs else [plants / "midpoint.c"])]
            files += [plants / "rodas3.h"] if "plants/rodas3.h" in needs else []
        else:
            files = [path for path in files if path.name != "motion.c"]
    return sorted(files)


def compiled(files: Iterable[str]) -> list[str]:
    """Return those that a compiler is called with."""
    return sorted(path for path in files if path.endswith(".c"))


def grouped(files: dict[str, str]) -> tuple[dict[str, str], dict[str, str]]:
    """Return the same C with the adapter in two files, and what the second, ``common.c``, needs.

    That is the same for all models, so it is compiled once; the first is compiled in half the time
    of its parts.
    """
    common = {path for path in files if path.partition(".")[0] in _COMMON}
    alone = {"model.c", START, *common}
    adapter = [path for path in compiled(files) if "/" not in path and path not in alone]
    own = {f"{path}.inc" if path in adapter else path: text for path, text in files.items()}
    shared = {f"{path}.inc" if path.endswith(".c") else path: files[path] for path in common}
    return (
        {path: text for path, text in own.items() if path not in compiled(common)}
        | {"adapter.c": _including(adapter)},
        shared | {"common.c": _including(compiled(common))},
    )


def _including(files: Iterable[str]) -> str:
    return "".join(f'#include "{path}.inc"\n' for path in files)


@cache
def fmi_headers(fmi: FmiVersion) -> dict[str, str]:
    """Return the headers of the FMI project by name, which FMPy's wheel carries."""
    return {
        entry.name: entry.read_text(encoding="utf-8")
        for entry in standard_files("c-code").iterdir()
        if entry.name.startswith(f"fmi{fmi}")
    }


def build_description(model: Model, files: Iterable[str]) -> str:
    """Return buildDescription.xml of FMI 3.0.2, section 2.5.1.2; FMI 2.0.4 takes the same file."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = writing.child(root, "BuildConfiguration", modelIdentifier=model.name)
    options = {"language": "C11", "compiler": "gcc", "compilerOptions": COMPILER_OPTIONS}
    sources = writing.child(configuration, "SourceFileSet", **options)
    for path in compiled(files):
        writing.child(sources, "SourceFile", name=path)
    writing.child(sources, "IncludeDirectory", name=".")
    return writing.document(root)
