"""What to do with the results, and with what they were made."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.markup import (
    Html,
    element,
    join,
    paragraph,
)
from stickslip.report.picture import Picture
from stickslip.report.reproduction.fmu_table import fmu
from stickslip.report.versions import made_with


def write(reproduction: Reproduction, _: Mapping[str, Picture]) -> Html:
    """Return the last section."""
    F_c = reproduction.learned.values["F_c"]
    files = {
        "compensator.fmu": "the tuned compensator alone, for any tool that imports FMUs",
        "loop.ssp": "the whole loop of Fig. 2(a) with it, for any tool that opens SSP",
        "learned.json": "the learned parameters with units, cost, seed and versions",
        "table2.csv, table4.csv, fitness.csv": "the tables of this page, unrounded",
    }
    if reproduction.motions:
        files["motions.csv, sensitivity.csv"] = (
            "errors of all motions, and what a wrong parameter costs in each, by region"
        )
    if reproduction.extras and reproduction.extras.validation:
        files["table4_all_extras.csv"] = "Table 4 of the drive with all extras on"
    if reproduction.beforehand is not None:
        files["datasheet.csv"] = "what comes out when the data sheet is wrong"
    items = [element("li", element("code", name), ": ", what) for name, what in files.items()]
    commands = "\n".join(
        (
            "stickslip simulate loop.ssp",
            f"stickslip simulate loop.ssp --set compensator.F_c={1.1 * F_c:.4g} --out run.csv",
            "stickslip check compensator.fmu",
        )
    )
    return element(
        "section",
        element("h2", "Using the results"),
        paragraph("Beside this page lie:"),
        element("ul", join(items, "\n")),
        paragraph("Run the loop, run it with another parameter, and check the FMU:"),
        element("pre", element("code", commands)),
        *((fmu(reproduction.opinion),) if reproduction.opinion else ()),
        made_with(),
    )
