"""What the repository shows is what its code computes."""

import re
from pathlib import Path

import pandas as pd
import pytest

ROOT = Path(__file__).parents[2]
COMMITTED = ROOT / "results" / "paper"


def test_the_committed_tables_are_those_of_this_code(results):
    """Up to what other versions of numpy and scipy change in the last digits of a search."""
    committed = pd.read_csv(COMMITTED / "table4.csv")
    fresh = pd.read_csv(results / "table4.csv")
    assert committed.without.to_numpy() == pytest.approx(fresh.without.to_numpy(), rel=0.01)
    assert committed["with"].to_numpy() == pytest.approx(fresh["with"].to_numpy(), abs=0.05)
    learned = pd.read_csv(COMMITTED / "table2.csv").set_index("parameter").learned
    fresh_learned = pd.read_csv(results / "table2.csv").set_index("parameter").learned
    assert learned["F_c"] == pytest.approx(fresh_learned["F_c"], rel=0.005)


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


def test_the_readme_names_files_that_exist():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)\)", readme):
        assert (ROOT / target).exists(), target
