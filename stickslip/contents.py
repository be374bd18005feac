"""What an FMU or a system structure package contains, without running it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.cosim import Variable, read_ssp, variants
from stickslip.cosim.display import html_table
from stickslip.cosim.fmu.fmu import Fmu, described
from stickslip.errors import UsageError
from stickslip.fmi.messages import printable, suggestion
from stickslip.simulation import packed_input

if TYPE_CHECKING:
    import pandas as pd

Row = dict[str, Any]  # a line of a table, by column


@dataclass(frozen=True, repr=False)
class Info:
    """What a file contains; shows itself as text and, in a notebook, as tables."""

    path: Path
    # name, version of FMI, interfaces, platforms and the like, by name; the default experiment has
    # times in s, and None where the file proposes nothing
    facts: Mapping[str, Any]
    # by name: ``variables`` and, of an .ssp file, ``components``, ``connections``, ``inputs`` and
    # ``outputs``; each a list of rows. Start values are in the unit of the row
    tables: Mapping[str, list[Row]]

    def __getitem__(self, name: str) -> pd.DataFrame:
        """Return one of the tables."""
        import pandas as pd  # late, for those who start quickly

        if name not in self.tables:
            raise KeyError(f"{self.path} has no table {name!r}{suggestion(name, self.tables)}")
        return pd.DataFrame(self.tables[name])

    @property
    def variables(self) -> pd.DataFrame:
        """A row for each variable, with causality, unit, start value and description."""
        return self["variables"]

    def document(self) -> dict[str, Any]:
        """Return all as mappings and lists."""
        return {"file": self.path, **self.facts, **self.tables}

    def text(self, *, whole: bool = False) -> str:
        """Return it as text, of an FMU without its internal variables unless ``whole``."""
        lines = [str(self.path)]
        lines += [f"  {name:12} {_fact(value)}" for name, value in self.facts.items() if value]
        for name, rows in self._sections(whole=whole).items():
            lines += ["", f"{name} ({len(rows)})", *_columns(rows)]
        return "\n".join(lines)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.tables)

    def __repr__(self) -> str:
        return self.text()

    def _repr_html_(self) -> str:
        facts = [(name, _fact(value)) for name, value in self.facts.items() if value]
        tables = [html_table((self.path.name, ""), facts, words=2)]
        for name, rows in self._sections(whole=True).items():
            cells = [[_cell(value) for value in row.values()] for row in rows]
            tables.append(html_table(list(rows[0]), cells, name, words=len(rows[0])))
        return "".join(tables)

    def _sections(self, *, whole: bool) -> dict[str, list[Row]]:
        """Return what is shown, by title: variables by causality, and the tables of a system."""
        if "components" in self.tables:
            shown = {n: rows for n, rows in self.tables.items() if n != "variables" or whole}
            return {name: rows for name, rows in shown.items() if rows}
        sections: dict[str, list[Row]] = {}
        for row in self.tables["variables"]:
            title = _TITLES.get(row["causality"], "other variables")
            if title in _TITLES.values() or whole:
                kept = {key: value for key, value in row.items() if key != "causality"}
                sections.setdefault(title, []).append(kept)
        order = [*dict.fromkeys(_TITLES.values()), "other variables"]
        return {title: sections[title] for title in order if title in sections}


_TITLES = {
    "input": "inputs",
    "output": "outputs",
    "parameter": "parameters",
    "structuralParameter": "parameters",
}


def info(path: Fmu | Path | str, variant: str | None = None) -> Info:
    """Return what an FMU or a system structure package contains, without running it.

    Parameters
    ----------
    path : FILE.fmu, FILE.ssp or an ``ss.Fmu``; a file may be one that this machine cannot run
    variant : name of a system of an .ssp file that has several

    Raises
    ------
    UsageError
        When the path has another suffix.
    CosimError
        When the file cannot be read.
    """
    file = path.path if isinstance(path, Fmu) else Path(path)
    if file.suffix == ".ssp":
        return _package(file, variant)
    if file.suffix != ".fmu":
        raise UsageError(f"{file}: expected a file .ssp or .fmu")
    if variant is not None:
        raise UsageError(f"{file}: a variant names a system of an .ssp; this is one FMU")
    return _fmu(file)


def _fmu(path: Path) -> Info:
    folder, found = described(path.absolute())
    binaries = folder / "binaries"
    platforms = (
        sorted(p.name for p in binaries.iterdir() if p.is_dir()) if binaries.is_dir() else []
    )
    variables = found.variables.values()
    others = sum(v.causality not in _TITLES for v in variables)
    facts = {
        "name": found.name,
        "fmi": found.standard,
        "tool": found.tool,
        "interfaces": sorted(found.interfaces),
        "platforms": platforms,
        "sources": (folder / "sources").is_dir(),
        "experiment": asdict(found.experiment),
        "states": found.n_states,
        "internal": others,
        "warnings": list(found.remarks),
    }
    return Info(path, facts, {"variables": [_row(v.name, v, v.unit, v.start) for v in variables]})


def _package(path: Path, variant: str | None) -> Info:
    system, experiment = read_ssp(path, variant)
    sources = system.sources()
    components, variables = [], []
    for name, fmu in system.fmus("info").items():
        of = {
            "fmi": fmu.description.standard,
            "interface": fmu.interface,
            "variables": len(fmu.variables),
        }
        components.append({"name": name, "file": fmu.label, **of})
        for v in fmu.variables.values():
            key = f"{name}.{v.name}"
            row = _row(key, v, v.unit, system.parameters.get(key, v.start))
            variables.append(row | {"source": sources.get(key)})
    wires: list[Row] = [
        {"from": source, "to": target, "unit": system.unit(source)}
        for target, source in sources.items()
    ]
    inputs: list[Row] = [
        {"name": name, "unit": system.unit(name), "to": list(targets)}
        for name, targets in system.inputs.items()
    ]
    outputs: list[Row] = [
        {"name": name, "unit": system.unit(source), "from": source}
        for name, source in system.outputs.items()
    ]
    facts = {
        "name": system.name,
        "variants": variants(path),
        "experiment": asdict(experiment),
        "signals": sorted(packed_input(path)),
    }
    tables = {"components": components, "inputs": inputs, "outputs": outputs}
    return Info(path, facts, tables | {"connections": wires, "variables": variables})


def _row(name: str, variable: Variable, unit: str | None, start: Any) -> Row:
    return {
        "name": name,
        "causality": variable.causality,
        "type": variable.type + "".join(f"[{length}]" for length in variable.dimensions),
        "unit": unit,
        "start": start,
        "minimum": variable.minimum,
        "maximum": variable.maximum,
        "items": [f"{name} = {number}" for name, number in variable.items] or None,
        "description": variable.description,
    }


def _fact(value: Any) -> str:
    """Return a fact as text."""
    if isinstance(value, Mapping):
        given = {name: one for name, one in value.items() if one is not None}
        units = {"start": " s", "stop": " s", "step": " s"}
        return ", ".join(f"{n} {one:g}{units.get(n, '')}" for n, one in given.items()) or "none"
    return ", ".join(map(str, value)) if isinstance(value, list) else _cell(value)


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.9g}"
    if isinstance(value, (list, tuple)):
        text = (", " if isinstance(value, list) else " ").join(map(_cell, value[:_MOST]))
        return text + (" ..." if len(value) > _MOST else "")
    return printable(" ".join(str(value).split()))


_MOST = 8  # elements of an array that are shown


def _columns(rows: Iterable[Row]) -> list[str]:
    """Return a table as text; columns without content are left out."""
    cells = [{key: _cell(value) for key, value in row.items()} for row in rows]
    keys = [key for key in cells[0] if any(row[key] for row in cells)]
    widths = {key: max(len(key), *(len(row[key]) for row in cells)) for key in keys}
    lines = [{key: key for key in keys}, *cells]
    return ["  " + "  ".join(f"{row[k]:{widths[k]}}" for k in keys).rstrip() for row in lines]
