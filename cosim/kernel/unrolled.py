"""The steps of one system as straight C in place of ``steps.h``: constants instead of tables."""

from __future__ import annotations

from stickslip.cosim.kernel import structures

MOST_COMPONENTS = 64  # beyond, the code would crowd itself out of the processor's cache

_GROUP = 12  # as in steps.h

_TEXT = """#include "walk.h"

{lists}

INLINE bool step(Run *run, const double *now, double *next) {{
    const Component *c = run->components;
    (void)now, (void)next;
    return {calls};
}}

INLINE void add(Run *run, int64_t n, const double *row) {{
    (void)run, (void)n, (void)row;
{sums}}}

__attribute__((noinline)) static bool step_until(Run *run, int64_t end) {{
    return walk(run, end, step, add, {width}, {constant});
}}
"""


def unroll(run: structures.Run) -> str | None:
    """Return ``steps.h`` for the components of a run; None where the tables serve better."""
    n = run.n_components
    if not 0 < n <= MOST_COMPONENTS or any(run.components[i].maps for i in range(n)):
        return None
    size = _GROUP if run.jacobi else 1
    lists, calls = [], []
    for begin in range(0, n, size):
        group = range(begin, min(begin + size, n))
        components = [(i, run.components[i]) for i in group]
        lists += [line for i, c in components for line in _references(i, c)]
        calls += [_set(i, c) for i, c in components if c.n_inputs]
        calls += ["plain(true)"] * run.jacobi  # else the step that follows makes it so
        calls += [f"do_step(run, c + {i}, {c.version})" for i, c in components]
        calls += [_get(i, c) for i, c in components if c.n_outputs]
    sums = "".join(_add(i, run.sums[i]) for i in range(run.n_sums))
    return _TEXT.format(
        lists="\n".join(lists),
        calls=" &&\n        ".join(calls),
        sums=sums,
        width=run.width,
        constant=run.constant_step,
    )


def _references(i: int, c: structures.Component) -> list[str]:
    tables = ("in", c.input_references[: c.n_inputs]), ("out", c.output_references[: c.n_outputs])
    return [
        f"static const uint32_t {name}{i}[] = {{{', '.join(map(str, table))}}};"
        for name, table in tables
        if table
    ]


def _set(i: int, c: structures.Component) -> str:
    values = f"now + {c.input_offset}"
    if c.input_offsets:
        terms = [f"now[{offset}]" for offset in c.input_offsets[: c.n_inputs]]
        if c.scales:
            factors, shifts = c.scales[: c.n_inputs], c.scales[c.n_inputs : 2 * c.n_inputs]
            terms = [
                f"{a!r} * {term} + {b!r}" for a, term, b in zip(factors, terms, shifts, strict=True)
            ]
        values = f"(const double[]){{{', '.join(terms)}}}"
    return f"set(run, c + {i}, {c.version}, in{i}, {c.n_inputs}, {values})"


def _get(i: int, c: structures.Component) -> str:
    return f"get(run, c + {i}, {c.version}, out{i}, {c.n_outputs}, next + {c.column})"


def _add(i: int, s: structures.SumOfSquares) -> str:
    reference = f"row[{s.reference}]" if s.reference >= 0 else f"run->sums[{i}].constant"
    return f"    add_square(run->sums + {i}, n, row[{s.column}], {reference});\n"
