"""documentation/index.html of a container: components and connections."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from stickslip.cosim.system.system import System
from stickslip.fmi.messages import escaped

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{title}</title>
<style>
body {{ font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; }}
table {{ border-collapse: collapse; }}
td, th {{ border: 1px solid #ccc; padding: 0.2em 0.6em; text-align: left; }}
</style>
</head>
<body>
<h1>{title}</h1>
<p>A system of coupled FMUs in one. All components step by {step:g} s. {rest}</p>
<h2>Components, in the order in which they step</h2>
{components}
<h2>Connections{delay}</h2>
{connections}
<h2>Licence</h2>
<p>The components are unchanged in <code>resources/</code>, each under its own licence:
<a href="licenses/license.txt">licenses/license.txt</a>.</p>
</body>
</html>
"""


_SHORTENED = "In communication steps that are no multiples of it the last step is shorter."
_WHOLE = "Communication steps must be multiples of it."


def index(system: System, order: Sequence[str], step: float, *, jacobi: bool) -> str:
    """Return the page."""
    fmus = system.fmus("a container")
    components = [(n, fmus[n].name, f"FMI {fmus[n].version}.0", fmus[n].token) for n in order]
    connections = [(source, target) for target, source in system.sources().items()]
    return _PAGE.format(
        title=escaped(system.name),
        step=step,
        rest=_SHORTENED if all(c.varies_step for c in system.components.values()) else _WHOLE,
        components=_table(("component", "model", "standard", "token"), components),
        connections=_table(("from", "to"), connections),
        delay=", each delayed by one step" if jacobi else "",
    )


def licences(system: System) -> str:
    """Return the licence that each component declares."""
    lines = ["The FMUs in resources/ stay under their own licences:", ""]
    for name, fmu in system.fmus("a container").items():
        lines.append(f"{name} ({fmu.name}): {fmu.description.licence or 'not stated'}")
    return "\n".join([*lines, ""])


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [f"<tr>{''.join(f'<th>{escaped(cell)}</th>' for cell in head)}</tr>"]
    lines += [f"<tr>{''.join(f'<td>{escaped(cell)}</td>' for cell in row)}</tr>" for row in rows]
    return "<table>" + "\n".join(lines) + "</table>"
