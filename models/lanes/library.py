"""Libraries of models in lanes, compiled for one kind of processor, and the one that runs them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from stickslip.fmi import toolchain
from stickslip.models.export.description import Model
from stickslip.models.export.sources import c_files, text
from stickslip.models.firmware import c99, program
from stickslip.models.lanes import translation

_HERE = Path(__file__).parent
# Any processor, AVX2, AVX-512. Where there are no such, the functions are all the same.
_LEVELS = ("", '"avx2"', '"avx512f,avx512dq,avx512vl,avx512bw"')
LEVELS = len(_LEVELS)
_LEVEL = """#ifdef __x86_64__
#pragma clang attribute push(__attribute__((target({target}))), apply_to = function)
#endif
#define LEVEL(name) name##{level}
#include "level.inc"
#ifdef __x86_64__
#pragma clang attribute pop
#endif
"""
# Functions of vectors are inlined, so no other code has to agree on how they are passed.
_FLAGS = ("-O2", "-fno-math-errno", "-fno-tree-slp-vectorize", "-Wno-everything")
_MODEL = """#include "run.h"
{code}
static void start_model(double t, V *values, M live) {{
    model_start(live, (V)t, {parts});
    model_outputs(live, (V)t, {parts}, (Outputs *)(values + {outputs}));
}}
static M step_model(double t, double h, V *values, M live) {{
    const M done = model_step(live, (V)t, (V)h, {parts});
    values[0] = live ? (V)(t + h) : values[0];
    model_outputs(live, (V)(t + h), {parts}, (Outputs *)(values + {outputs}));
    return live & ~done;
}}
static const LaneModel MODEL = {{start_model, step_model}};
EXPORT const LaneModel *lane_model(void);
const LaneModel *lane_model(void) {{ return &MODEL; }}
"""
_PARTS = {"state": "States", "memory": "Memory", "input": "Inputs", "parameter": "Parameters"}


def model_library(model: Model, level: int) -> Path:
    """Return the library of a model for one of ``LEVELS`` processors, compiled on first use.

    Raises ModelError where its C cannot be translated, or toolchain.ToolchainError.
    """
    roles = [v.role for v in model.variables]
    places = {role: roles.index(role) if role in roles else 0 for role in (*_PARTS, "output")}
    parts = ", ".join(f"({struct} *)(values + {places[role]})" for role, struct in _PARTS.items())
    code = _MODEL.format(code=_translated(model), parts=parts, outputs=places["output"])
    return _library(f"lanes_{model.name}", {"level.inc": code}, [level])


def _translated(model: Model) -> str:
    """Return its C in lanes, kept as long as neither the C nor what translates it changes."""
    files = [Path(module.__file__ or "") for module in (translation, c99, program)]
    own = c_files(model, 2) | {path.name: text(path) for path in files}
    parts = [part for name, code in sorted(own.items()) for part in (name, code)]
    code = toolchain.kept("lanes", parts, lambda: translation.translated(model).encode())
    return code.decode()


def run_library() -> Path:
    """Return the library that runs systems of models in lanes, compiled on first use."""
    names = ("run.c", "choice.c")
    code, choice = (text(_HERE / name) for name in names)
    return _library("lanes", {"level.inc": code, "choice.c": choice}, range(LEVELS))


def _library(name: str, files: dict[str, str], levels: Iterable[int]) -> Path:
    files |= {header: text(_HERE / header) for header in ("lanes.h", "run.h")}
    for level in levels:
        each = _LEVEL.format(target=_LEVELS[level], level=level)
        bare = '#define LEVEL(name) name##0\n#include "level.inc"\n'
        files[f"level{level}.c"] = each if _LEVELS[level] else bare
    return toolchain.shared_library(name, files, flags=_FLAGS, standalone=True)
