"""The tables of the reproduction, as terminal and page show them; Table 2 shows the truth."""

from collections.abc import Callable, Mapping
from functools import partial
from math import nan
from typing import Any

import pandas as pd

from stickslip.catalog.parameters import HIGH, LOW, PAPER, tabulated, unit_of
from stickslip.evaluation.validation import PHASES, reduction
from stickslip.identification.estimation import Estimation
from stickslip.identification.stages import Estimate, Identification
from stickslip.papers.lugre.loop_tuning import LoopTuning, spread
from stickslip.papers.lugre.published import LOGARITHMIC, OURS, SQUARES, START, PublishedStudy
from stickslip.papers.lugre.steps import (
    FILTERED,
    LEARNED,
    REDUCTION_WITH_FILTER,
    STEPS,
    UNCOMPENSATED,
    by_step,
)
from stickslip.presentation import quantity
from stickslip.presentation.table import Column, Row, Table
from stickslip.tuning.loop_runs import GENES
from stickslip.tuning.refinement import Refinement


def table2(
    identification: Identification, learned: Refinement, truth: Mapping[str, float]
) -> pd.DataFrame:
    """Return Table 2 with what was found, in SI units.

    Columns parameter, unit, paper, drive (the proxy's truth), identified, learned, spread (standard
    error of the learned value), identified_spread, remark. m and b are not learned.
    """
    rows = []
    for name, before in identification.estimates.items():
        after = learned.estimates.get(name)
        rows.append(
            {
                **_head(name, truth),
                "identified": before.value,
                "learned": after.value if after else None,
                "spread": after.standard_error if after else None,
                "identified_spread": before.standard_error,
                "remark": _remark(name, identification, learned, truth[name]),
            }
        )
    return pd.DataFrame(rows)


def table2_of_recording(estimation: Estimation, truth: Mapping[str, float]) -> pd.DataFrame:
    """Return Table 2 with what one recording gave, in SI units.

    ``identified`` is what a straight line through the recorded force gives, which shows
    nothing of friction but F_c. ``spread`` is the standard error of what was learned.
    """
    line = estimation.start.line
    rows = []
    for name in tabulated(estimation.law):
        known = estimation.known[name]
        rows.append(
            {
                **_head(name, truth),
                "identified": line[name] if name in ("m", "b", "F_c") else None,
                "learned": known.value,
                "spread": known.standard_error,
                "low": known.low,
                "high": known.high,
                "remark": known.sentence,
            }
        )
    return pd.DataFrame(rows)


def _head(name: str, truth: Mapping[str, float]) -> dict[str, Any]:
    known = {"paper": PAPER.get(name), "drive": truth[name]}
    return {"parameter": name, "unit": unit_of(name), **known}


def _remark(name: str, identification: Identification, learned: Refinement, truth: float) -> str:
    """Say how well a parameter is known, and whether learning took it away from the truth."""
    if name not in learned.estimates:
        return "identified only, not learned"
    before, after = identification.estimates[name], learned.estimates[name]
    prior = before.standard_error / before.value
    if learned.chosen == "start":
        remark = "as learning began: the training run alone would know it to "
        remark += f"+-{100 * learned.alone[name]:.2g} %"
    elif learned.alone[name] < prior:
        remark = "identifiable from the training run"
    elif learned.accepted:
        remark = (
            f"weakly identifiable from the training run "
            f"(alone +-{100 * learned.alone[name]:.2g} %): identification decides"
        )
    else:
        remark = (
            f"weakly identifiable from the training run (+-{100 * learned.alone[name]:.2g} %): "
            "less certain than identified"
        )
    error_before, error_after = (abs(value / truth - 1.0) for value in (before.value, after.value))
    if error_after > error_before:
        remark += (
            f"; farther from the drive's value than identified "
            f"({100 * error_after:.2g} % after {100 * error_before:.2g} %)"
        )
    return remark


def parameters(found: pd.DataFrame) -> Table:
    """Return ``table2`` as a page shows it."""

    def value(row: Row, name: str) -> str:
        return quantity.parameter_value(row["parameter"], nan if row[name] is None else row[name])

    def estimate(row: Row, name: str, spread: str) -> str:
        return quantity.parameter_estimate(row["parameter"], Estimate(row[name], row[spread]))

    def off(name: str) -> Column:
        def cell(row: Row) -> str:
            return quantity.percent(row[name] / row["drive"] - 1.0, 2) if row["drive"] else "–"

        return Column(name, head=f"{name.capitalize()}, off by", cell=cell)

    shown: dict[str, tuple[str, Callable[[Row], str]]] = {
        "parameter": ("", lambda row: quantity.symbol(row["parameter"])),
        "paper": ("Real stage (paper)", lambda row: value(row, "paper")),
        "drive": ("Simulated drive", lambda row: value(row, "drive")),
        "identified": ("Identified", lambda row: estimate(row, "identified", "identified_spread")),
        "learned": ("Learned", lambda row: estimate(row, "learned", "spread")),
    }
    columns = (
        *(Column(name, head=head, cell=cell) for name, (head, cell) in shown.items()),
        *map(off, ("identified", "learned")),
        Column("unit", head="Unit", cell=lambda row: quantity.parameter_unit(row["parameter"])),
    )
    return Table.of(columns, found)


def table4(found: pd.DataFrame) -> Table:
    """Return Table 4, with the velocity filter where that was tried."""

    def error(name: str, title: str, digits: int = 3) -> Column:
        def shown(row: Row) -> str:
            ends = [f"{row[end]:.3f}" for end in (f"{name}{LOW}", f"{name}{HIGH}") if end in row]
            return f"{row[name]:.{digits}f}" + (f" ({'-'.join(ends)})" if ends else "")

        show = f"{{:.{digits}f}}".format
        return Column(
            name, shown, title, title.capitalize(), lambda row: quantity.ranged(row, name, show)
        )

    def share(name: str, digits: int = 1) -> Column:
        return Column(
            name,
            lambda row: f"{100 * row[name]:.{digits}f} %",
            "reduction",
            "Reduction",
            cell=lambda row: quantity.ranged(row, name, partial(quantity.percent, digits=digits)),
        )

    columns = [
        Column("velocity", "", "velocity", ""),
        Column("region", "", "region", ""),
        Column("metric", "", "metric", "", cell=lambda row: quantity.METRICS[row["metric"]]),
        error("without", "without"),
        error("with", "with"),
        share("reduction"),
        error("paper_without", "paper: without", 2),
        error("paper_with", "with", 2),
        share("paper_reduction", 0),
    ]
    if FILTERED in found:
        columns += [error(FILTERED, "velocity filter: with"), share(REDUCTION_WITH_FILTER)]
    return Table.of(columns, found)


def print_table4(found: pd.DataFrame) -> None:
    """Print Table 4 on a terminal."""
    print(
        "velocity errors in mm/s; loop, ramps and windows were calibrated so that the simulated\n"
        "drive of Table 2, measured, comes near the real stage (paper) without compensation"
        + f"\nmedian of runs from {len(PHASES)} phases of an encoder step, and range"
        * (f"with{LOW}" in found),
        table4(found).text(),
        sep="\n",
    )


STAGES = {
    "none": "None",
    "tuned_pi": "Tuned PI alone",
    "identified": "+ identified friction",
    "least_squares": "+ least squares",
    "learned": "Loop learned",
}
"""The stages as the page names them."""


def stages(loops: LoopTuning) -> Table:
    """Return what each step leaves of the error of a PI controller tuned without a model."""

    def errors(name: str) -> Column:
        def shown(row: Row) -> str:
            return spread(*row[name])

        return Column(name, shown, name, name.capitalize(), words=False)

    fitted = loops.table[loops.table["stage"] == "least_squares"]["evaluations"]
    runs = {
        "identified": "three experiments",
        "least_squares": f"{fitted.max()} more",
        "learned": f"{max(one.runs for one in loops.learned)} more",
    }
    found = loops.summary()
    motions = list(found.columns.get_level_values(0).unique()[:-1])
    columns = (
        Column("stage", "", "stage", "", cell=lambda row: STAGES[row["stage"]]),
        *map(errors, motions),
        fixed("Ms", "Ms", 2),
        Column("runs", head="Runs of the drive", words=False),
    )
    rows = [
        {"stage": stage, "Ms": own["Ms"].iloc[0], "runs": runs.get(str(stage), "–")}
        | {name: tuple(own[name]) for name in motions}
        for stage, own in found.iterrows()
    ]
    return Table(columns, rows)


def fixed(name: str, head: str, digits: int) -> Column:
    """Return a column of numbers with so many decimals."""
    return Column(name, lambda row: f"{row[name]:.{digits}f}", head, head)


def searches(loops: LoopTuning) -> Table:
    """Return what the seeds found, and their errors in the validation."""
    titles = {one.chosen: one.chosen for one in loops.learned} | STAGES
    titles["learned"] = "a candidate"
    columns = (
        Column("seed", head="Seed"),
        Column("chosen", head="Chosen", cell=lambda row: titles.get(row["chosen"], "")),
        fixed("cost", "Cost", 3),
        fixed("median", "Median error", 2),
        fixed("largest", "Largest error", 2),
        fixed("Ms", "Ms", 2),
        Column("evaluations", head="Candidates"),
        Column("runs", head="Runs of the drive"),
    )
    found: dict[Any, Any] = loops.by_seed().to_dict("index")
    return Table(columns, [{**found[one.seed], **vars(one)} for one in loops.learned])


def genes(loops: LoopTuning) -> Table:
    """Return what was learned of the loop, by the best seed and over all."""
    columns = (
        Column("gene", head="Gene"),
        Column("lower", head="From"),
        Column("upper", head="to"),
        Column("best", head="Least cost", digits=3),
        Column("least", head="Least of all seeds", digits=2),
        Column("largest", head="Largest", digits=2),
    )
    rows = []
    for gene in GENES:
        found = [one.genes[gene.name] for one in loops.learned]
        best = loops.best.genes[gene.name]
        ends = {"best": best, "least": min(found), "largest": max(found)}
        rows.append({"gene": gene.name, "lower": gene.lower, "upper": gene.upper, **ends})
    return Table(columns, rows)


METHODS = {
    START: "Coarse start",
    OURS: "As published",
    LOGARITHMIC: "As published, logarithmic genes",
    SQUARES: "Least squares",
}


def panel(study: PublishedStudy) -> Table:
    """Return what each method makes of the coarse starts."""

    def left(name: str) -> Column:
        head = name.replace("_", " ").capitalize()
        share = partial(quantity.percent, digits=0)
        return Column(name, ".3g", name, head, cell=lambda row: quantity.ranged(row, name, share))

    def cost(row: Row) -> str:
        return quantity.ranged(row, "cost", partial(quantity.number, digits=2))

    found = study.panel()
    columns = (
        Column("method", "", "method", "", cell=lambda row: METHODS[row["method"]]),
        Column("seeds", "d", "seeds", "Seeds"),
        Column("runs", "d", "runs", "Runs", cell=lambda row: row["runs"] or "–"),
        Column("cost", ".2g", "cost", "Cost (6) [m²/s²]", cell=cost),
        *map(left, [name for name in found.columns[4:] if not name.endswith((LOW, HIGH))]),
    )
    return Table.of(columns, found)


SHOWN = quantity.METRICS | {"E_x": "$E_x$"}


def error_name(row: Mapping[Any, object]) -> str:
    """Return what an error of ``Evaluation.table`` is of."""
    region = str(row["region"]).replace(" um", " µm")
    return f"{str(row['motion']).capitalize()}, {region}, {SHOWN[str(row['metric'])]}"


def _by_step(found: pd.DataFrame) -> list[Column]:
    """Return a column for each step that a table has, with its range."""

    def step(name: str) -> Column:
        return Column(name, head=STEPS[name], cell=lambda row: quantity.ranged(row, name))

    return [step(name) for name in STEPS if name in found]


def steps(table4: pd.DataFrame) -> Table:
    """Return Table 4 with what each step leaves."""

    def title(row: Row) -> str:
        return f"{row['region'].capitalize()}, {quantity.METRICS[row['metric']]}"

    found = by_step(table4)
    columns = (Column("region", head="", cell=title), Column("velocity", head=""), *_by_step(found))
    return Table.of(columns, found)


def motions(found: pd.DataFrame) -> Table:
    """Return the errors of motions, of the measured velocity and of the true one."""

    def reduced(row: Row) -> str:
        return quantity.percent(reduction(row[UNCOMPENSATED], row[LEARNED]))

    columns = (
        Column("metric", head="", cell=error_name),
        Column("velocity", head=""),
        Column("unit", head="Unit", cell=lambda row: row["unit"].replace("um", "µm")),
        *_by_step(found),
        Column(LEARNED, head="Reduction", cell=reduced),
    )
    groups = found.groupby(["region", "metric"], sort=False)
    return Table.of(columns, pd.concat([errors for _, errors in groups]))
