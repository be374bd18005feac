"""A column that is described once is on the terminal, on the page and in files."""

import math
from dataclasses import replace

from stickslip.presentation.scale import Scale
from stickslip.presentation.table import Column, Table, scaled, share, units

TABLE = Table(
    (
        Column("law", text="", title="law", head="Friction law"),
        Column("error", text=".3g", title="error [N]", head="Error", unit="N", digits=2),
        Column("kept"),
        Column("known", text=lambda row: "yes" if row["known"] else "no", stored=False),
    ),
    [
        {"law": "LuGre", "error": 0.123456, "kept": 1, "known": True},
        {"law": "Dahl", "error": math.inf, "kept": 2, "known": False},
    ],
)


def test_words_are_set_to_the_left_and_numbers_to_the_right():
    assert TABLE.text().splitlines() == [
        "law    error [N]",
        "LuGre      0.123  yes",
        "Dahl           -  no",
    ]


def test_a_page_has_the_columns_with_a_head():
    page = TABLE.html("What was found")
    assert page.count("<th ") == 2 + 2
    assert "Friction law" in page
    assert ">0.12<" in page
    assert "0.1235" not in page


def test_files_have_units_and_no_number_that_is_not_finite():
    first, second = TABLE.records()
    assert first == {"law": "LuGre", "error": {"value": 0.123456, "unit": "N"}, "kept": 1}
    assert second["error"] == {"value": None, "unit": "N"}
    assert TABLE.by_key()["Dahl"] == {"error": {"value": None, "unit": "N"}, "kept": 2}
    assert list(TABLE.frame().columns) == ["law", "error", "kept"]
    assert TABLE.frame()["error"].tolist() == [0.123456, math.inf]


def test_without_rows_there_are_titles():
    assert replace(TABLE, rows=[]).text() == "law  error [N]"


def test_a_page_shows_what_a_function_of_the_row_returns_and_a_dash_for_what_is_absent():
    shown = Column("error", lambda row: f"{row['law']} errs", "error", "Error")
    table = replace(TABLE, columns=(shown, Column("absent", "", "absent", "Absent")))
    assert ">LuGre errs<" in table.html("")
    assert ">–<" in table.html("")
    assert table.text().splitlines()[1].split() == ["LuGre", "errs", "-"]
    assert table.records()[0]["absent"] is None


def test_values_are_scaled_and_shares_are_in_per_cent():
    def scale(row):
        return Scale(1e3, "mN") if row["error"] < 1.0 else Scale(1.0, "N")

    columns = (scaled("error", scale, "Error"), units(scale), share("error", "Share"))
    table = replace(TABLE, columns=columns)
    assert table.text().splitlines()[1].split() == ["123", "mN", "12.3", "%"]
    assert ">12.3\u00a0%<" in table.html("")
