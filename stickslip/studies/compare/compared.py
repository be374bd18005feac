"""Results side by side: parameters with their intervals, and what the compensators do."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from stickslip.errors import UsageError
from stickslip.identification.fitting.identifiability import IDENTIFIABLE, NOT_IDENTIFIABLE
from stickslip.learned.file import NORMAL, LearnedFile
from stickslip.presentation.table import Table
from stickslip.studies.compare import tables

FILES = ("learned.json", "tuned.json")  # of a folder of results; it has one of them


@dataclass(frozen=True)
class DriveComparison:
    """What several results say."""

    parameters: Table  # with the columns ``tables.PARAMETERS``
    errors: Table  # with the columns ``tables.ERRORS``

    def side_by_side(self) -> pd.DataFrame:
        """Return a row for each parameter and unit, a column for each result, as text.

        The column ``differ`` names the results whose 95 % interval lies apart from that of the
        first one where both are known.
        """
        names = [row["name"] for row in self.errors.rows]
        rows = []
        for key, of in self.parameters.frame().groupby(["parameter", "unit"], sort=False):
            known = {row["name"]: row for row in of.to_dict("records")}
            row = dict.fromkeys(names, "")
            row |= {name: _shown(one) for name, one in known.items()}
            first = next(iter(known.values()))
            apart = [name for name, one in known.items() if _apart(first, one)]
            rows.append({"parameter": f"{key[0]} [{key[1]}]", **row, "differ": ", ".join(apart)})
        return pd.DataFrame(rows, columns=["parameter", *names, "differ"]).set_index("parameter")


def parameter_rows(name: str, parameters: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return rows of ``DriveComparison.parameters`` from the ``parameters`` of a learned.json."""
    rows, numbers = [], ("value", "standard_error", "low", "high")
    for parameter, one in parameters.items():
        known = {name: one.get(name) for name in ("unit", *numbers, "identifiability")}
        known |= {n: float(one[n]) for n in numbers if n == "value" or known[n] is not None}
        if one.get("low") is None and one.get("standard_error") is not None:
            half = NORMAL * one["standard_error"]
            known |= {"low": one["value"] - half, "high": one["value"] + half}
            known["identifiability"] = IDENTIFIABLE
        rows.append({"name": name, "parameter": parameter, **known})
    return rows


def compare(places: Iterable[Path | str]) -> DriveComparison:
    """Return what learned.json files say, or folders with one, or folders of a fleet.

    Raises UsageError when there is no learned.json at a place, or one is not valid, or OSError when
    a file cannot be read.
    """
    files = [file for place in places for file in _files(Path(place))]
    names = _names(files)
    parameters, errors = [], []
    for name, file in zip(names, files, strict=True):
        learned = LearnedFile(file)
        try:
            parameters += parameter_rows(name, learned.document["parameters"])
            errors.append({"name": name, **error_ratios(learned.document)})
        except (AttributeError, KeyError, TypeError, ValueError) as fault:
            raise UsageError(f"{file}: is no result of learn, reproduce or fleet") from fault
    return DriveComparison(Table(tables.PARAMETERS, parameters), Table(tables.ERRORS, errors))


def _files(place: Path) -> list[Path]:
    own = [place] if place.is_file() else [place / name for name in FILES]
    found = [file for file in own if file.exists()] or sorted(place.glob("drives/*/learned.json"))
    if not found:
        raise UsageError(
            f"{place}: expected learned.json, or a folder in which learn, reproduce or fleet wrote"
            " one"
        )
    return found


def _names(files: list[Path]) -> list[str]:
    """Return the shortest ends of the paths that tell the files apart."""
    parts = [file.absolute().parts for file in files]
    parts = [of[:-1] if of[-1] in FILES else of for of in parts]
    for n in range(1, max(map(len, parts), default=1) + 1):
        names = ["/".join(of[-n:]) for of in parts]
        if len(set(names)) == len(names):
            return names
    raise UsageError("the same result is named twice")


def error_ratios(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row of ``DriveComparison.errors`` without its name, from a learned.json."""
    ratios = {"share": np.nan, "fitted": np.nan, "worst": np.nan}
    law = document.get("law", "lugre")
    if document.get("refusal"):
        return {"law": law, "compensation": "none: refused", **ratios}
    compensation = document.get("compensation", "feedforward")
    compared = document.get("compared", {})
    for row in compared.get("compensators", ()):
        if row.get("compensator") == compared.get("chosen"):
            ratios |= {key: row[key] for key in ratios if row.get(key) is not None}
    if "cost" in document:  # of a reproduction
        cost, none = (document[key]["value"] for key in ("cost", "cost_without_compensation"))
        ratios["fitted"] = (cost / none) ** 0.5
    return {"law": law, "compensation": compensation, **ratios}


def _is_known(one: Mapping[Any, Any]) -> bool:
    return one["low"] is not None and one["identifiability"] != NOT_IDENTIFIABLE


def _shown(one: Mapping[Any, Any]) -> str:
    ends = f"{one['value']:.4g} [{one['low']:.4g}, {one['high']:.4g}]" if _is_known(one) else ""
    return ends or f"({one['value']:.4g})"


def _apart(one: Mapping[Any, Any], other: Mapping[Any, Any]) -> bool:
    known = _is_known(one) and _is_known(other)
    return known and (one["high"] < other["low"] or other["high"] < one["low"])
