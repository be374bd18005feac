"""What the repository shows is what its code computes."""

from pathlib import Path

import pandas as pd
import pytest

from stickslip.evaluation.motions import VALIDATION
from stickslip.evaluation.validation import PHASES, validate
from stickslip.papers.lugre.reproduction import Options, reproduce
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.axis import LOOP, Axis, Datasheet
from tests.stickslip.papers.lugre.result_tolerance import differences

ROOT = Path(__file__).parents[4]
COMMITTED = ROOT / "results" / "paper"


@pytest.mark.parametrize("name", ["table2", "table4", "motions", "loop_tuning"])
def test_the_committed_tables_are_those_of_this_code(results, name):
    committed, fresh = (pd.read_csv(folder / f"{name}.csv") for folder in (COMMITTED, results))
    assert differences(name, fresh, committed) == []


@pytest.mark.thorough
def test_last_digits_of_the_loop_leave_the_tables_within_the_tolerance(
    results, quiet, tmp_path, monkeypatch
):
    def axis(sheet, m, b):
        return Axis(m, b * (1.0 + 1e-10), sheet.tau_i)

    monkeypatch.setattr(Datasheet, "axis", axis)
    found = reproduce(Options(seeds=0), tmp_path, quiet)
    tables = {"table2": found.table2(), "table4": found.table4()}
    for name, table in tables.items():
        assert differences(name, table, pd.read_csv(results / f"{name}.csv")) == []


@pytest.mark.parametrize(("change", "equal"), [(1e-5, True), (0.05, False)])
def test_the_tolerance_is_that_of_chance(reproduction, results, change, equal):
    """As much as processors differ in what one recording gives moves cells, but not beyond it."""
    fmus = reproduction.system.components["drive"].path.parent
    rig, learned = FmuRig(fmus, Datasheet(), LOOP.T_s), reproduction.learned.friction
    changed = {**learned, "F_c": (1.0 + change) * learned["F_c"]}
    loop = reproduction.identification.loop
    table = validate(rig, loop, changed, VALIDATION, phases=PHASES).table()
    committed = pd.read_csv(results / "table4.csv")
    assert (differences("table4", table, committed) == []) is equal
    assert not table["with"].equals(committed["with"])


def test_the_documents_quote_the_committed_table():
    page = (ROOT / "docs" / "reproduction.md").read_text(encoding="utf-8")
    for file, column, label in (
        ("table4", "paper_without", "without compensation, real stage (paper)"),
        ("table4", "without", "without compensation, simulated drive, calibrated to this row"),
        ("table4_all_extras", "without", "without compensation, simulated drive, all extras on"),
        ("table4", "paper_with", "with compensation, real stage (paper)"),
        ("table4", "with", "with compensation, simulated drive"),
        ("table4_all_extras", "with", "with compensation, simulated drive, all extras on"),
    ):
        table = pd.read_csv(COMMITTED / f"{file}.csv").query("velocity == 'measured'")
        figures = " | ".join(f"{value:.2f}" for value in table[column])
        assert f"| {label} | {figures} |" in page
