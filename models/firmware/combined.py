"""The blocks of a drive behind one call: each takes the force of the one before it.

The call has the same signals whatever the blocks use, so that it stays as it is when a drive is
learned again.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from textwrap import fill

from stickslip.models.errors import UnknownModel
from stickslip.models.export.description import Model
from stickslip.models.firmware.c99 import struct_name

ADDED_FORCE = "added_force"  # name of the call
SIGNALS = {  # -> unit, and what it is
    "v_cmd": ("m/s", "Velocity command of the controller; 0 where a position loop has none"),
    "x_cmd": ("m", "Position command of the controller; 0 where there is no position loop"),
    "a_cmd": ("m/s2", "Acceleration command; 0 where no feedforward of inertia is used"),
    "x_enc": ("m", "Position of the encoder at the sample"),
    "F_m": ("N", "Measured motor force at the sample, with all that is added to it"),
}
RESULT = "[N] Force to add to the controller's, for the period that begins"
_PART = re.compile(r"(\w+)\.([A-Za-z]\w*)")  # BLOCK.OUTPUT
_LONG = re.compile(r"^[^/\n]{101,}$", re.MULTILINE)


def _wired(blocks: Sequence[Model]) -> Iterator[tuple[Model, dict[str, str], str]]:
    """Yield each block, the source of each of its inputs, and the output that is its force."""
    sources = dict(zip(SIGNALS, SIGNALS, strict=True))
    sources |= {"x": "x_enc", "v_r": "v_cmd", "F_in": "0.0"}
    for block in blocks:
        inputs, outputs = ([name for name, _ in block.fields[r]] for r in ("input", "output"))
        if other := [name for name in inputs if name not in sources]:
            what = f"{other[0]!r} is not among its inputs {', '.join(sources)}"
            raise UnknownModel(f"{block.title} cannot stand behind one call: {what}")
        force = f"{block.name}.{'F_ff' if 'F_ff' in outputs else 'F'}"
        yield block, {name: sources[name] for name in inputs}, force
        sources["F_in"] = force
        if "v_r" in outputs:
            sources["v_r"] = f"{block.name}.v_r"


def used_signals(blocks: Sequence[Model]) -> Mapping[str, tuple[str, str]]:
    """Return the signals that the blocks use, with units and what they are."""
    sources = {one for _, given, _ in _wired(blocks) for one in given.values()}
    return {name: one for name, one in SIGNALS.items() if name in sources}


def combined_c(blocks: Sequence[Model]) -> dict[str, str]:
    """Return ``added_force.c`` and ``.h``, which call the code of the blocks."""
    real, upper, struct = f"{blocks[0].name}_real", ADDED_FORCE.upper(), "AddedForce"
    arguments = "".join(f", {real} {name}" for name in SIGNALS)
    signals = "\n".join(f" *   {name} [{unit}] {text}" for name, (unit, text) in SIGNALS.items())
    begin, step, last = [], [], ""
    for block, given, force in _wired(blocks):
        values = [_PART.sub(r"c->\1.outputs.\2", source) for source in given.values()]
        values = [value.replace("0.0", f"({real})0") for value in values]
        target, last = f"&c->{block.name}", _PART.sub(r"c->\1.outputs.\2", force)
        begin.append(f"    {block.name}_init({', '.join([target, *values])});\n")
        h = [] if block.sampled else [f"({real})1"]  # its force does not depend on h
        given_step = ", ".join([target, *h, *values])
        step.append(f"    finite = {block.name}_step({given_step}) && finite;\n")
    end = f"    c->F = {last};\n"
    idle = "".join(f"    (void){name};\n" for name in SIGNALS if name not in used_signals(blocks))
    prototype = {one: f"{one}({struct} *c{arguments})" for one in ("init", "step")}
    header = [
        f"/* {' -> '.join(block.title for block in blocks)}, in one call.\n{signals}\n */",
        f"#ifndef {upper}_H\n#define {upper}_H\n",
        *(f'#include "{block.name}.h"' for block in blocks),
        '\n#ifdef __cplusplus\nextern "C" {\n#endif\n\ntypedef struct {',
        *(f"    {struct_name(block)} {block.name};" for block in blocks),
        f"    /* {RESULT} */\n    {real} F;\n}} {struct};\n",
        f"/* Begin at rest with these signals. */\nvoid {ADDED_FORCE}_{prototype['init']};\n",
        "/* Call it once in each period of the controller. False: not finite, do not use c->F. */",
        f"bool {ADDED_FORCE}_{prototype['step']};\n\n#ifdef __cplusplus\n}}\n#endif\n\n#endif\n",
    ]
    source = [
        f'#include "{ADDED_FORCE}.h"\n',
        f"void {ADDED_FORCE}_{prototype['init']} {{\n{idle}{''.join(begin)}{end}}}\n",
        f"bool {ADDED_FORCE}_{prototype['step']} {{\n    bool finite = true;\n{idle}"
        f"{''.join(step)}{end}    return finite;\n}}\n",
    ]
    texts = {"h": "\n".join(header), "c": "\n".join(source)}
    return {f"{ADDED_FORCE}.{end}": _LONG.sub(_folded, text) for end, text in texts.items()}


def _folded(line: re.Match[str]) -> str:
    return fill(line[0], 100, subsequent_indent=" " * 8)


def combined_st(blocks: Sequence[Model]) -> str:
    """Return the function block ``Added_force``, which contains those of the blocks."""
    calls, kinds, last, inside = [], [], "", r"\1_block.\2"
    ahead = [block for block in blocks if ("F_ff", ()) in block.fields["output"]]
    for block, given, force in _wired(blocks):
        values = {"reset": "reset", **given}
        values |= {} if block.sampled else {"h": "1.0"}  # its force does not depend on h
        arguments = ", ".join(f"{name} := {source}" for name, source in values.items())
        calls.append(f"    {block.name}_block({_PART.sub(inside, arguments)});")
        kinds.append(f"    {block.name}_block : {block.name.capitalize()};")
        last = _PART.sub(inside, force)
    return "\n".join(
        [
            "(* Call it once in each period of the controller. The first call begins at rest. *)",
            f"FUNCTION_BLOCK {ADDED_FORCE.capitalize()}\nVAR_INPUT",
            *(f"    {name} : LREAL; (* [{of}] {said} *)" for name, (of, said) in SIGNALS.items()),
            "    reset : BOOL; (* TRUE: each call is like the first *)",
            f"END_VAR\nVAR_OUTPUT\n    F : LREAL; (* {RESULT} *)",
            *(f"    F_ff : LREAL; (* [N] Force of {block.name} *)" for block in ahead),
            "    valid : BOOL; (* FALSE: do not use F *)\nEND_VAR\nVAR",
            *kinds,
            "END_VAR",
            *calls,
            f"    F := {last};",
            *(f"    F_ff := {block.name}_block.F_ff;" for block in ahead),
            f"    valid := {' AND '.join(f'{block.name}_block.valid' for block in blocks)};",
            "END_FUNCTION_BLOCK\n",
        ]
    )
