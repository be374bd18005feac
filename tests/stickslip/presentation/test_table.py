"""Tables on the terminal, on pages and in files, and the numbers and symbols in them."""

import math
from dataclasses import replace

import pytest
from jinja2 import UndefinedError

from stickslip.presentation.markup import fill, text
from stickslip.presentation.quantity import interval, number, with_error
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


@pytest.mark.parametrize(
    ("shown", "expected"),
    [
        (number(0.5), "0.5"),
        (number(4696.9), "4697"),
        (number(68314.0), "68 310"),
        (number(-0.00123456, 3), "−0.00123"),
        (number(4.35e-6, 3), "4.35 × 10⁻⁶"),
        (number(100.0, 3), "100"),
        (number(0.0, 3), "0"),
        (number(float("inf"), 3), "–"),
        (with_error(5.99669, 0.00154), "5.9967 ± 0.0015"),
        (with_error(391502.8, 533.8), "391 500 ± 530"),
        (with_error(6.743, 0.0), "6.743"),
        (with_error(6.743, float("inf")), "6.743"),
        (with_error(3.21e-5, 1.2e-7), "(3.210 ± 0.012) × 10⁻⁵"),
        (with_error(-1e-9, 0.016), "−0.000 ± 0.016"),
        (interval(5.996885, 6.000049), "5.9969 … 6.0000"),
        (interval(391117.5, 391968.7), "391 120 … 391 970"),
        (interval(-0.2, 0.3), "−0.20 … 0.30"),
        (interval(4230.0, 1.34e9), "4230 … 1.34 × 10⁹"),
        (interval(1.2e-5, 1.4e-5), "(1.20 … 1.40) × 10⁻⁵"),
        (interval(1.0, float("inf")), "–"),
    ],
)
def test_numbers_have_as_many_digits_as_their_errors_allow(shown, expected):
    assert " " not in shown.replace(" … ", "")  # spaces do not break
    assert shown.replace("\u00a0", " ") == expected


def test_symbols_are_set_and_all_other_text_is_escaped():
    assert text(r"$v$ − $\sigma_0$") == "<i>v</i> − <i>σ</i><sub>0</sub>"
    assert text("$E_{rms}$ < 5 & more") == "<i>E</i><sub>rms</sub> &lt; 5 &amp; more"
    for plain in ("costs $5 to $6", "$F_c", "$<b>$"):
        assert "<" not in text(plain)
    assert "<b" not in text(r"$\lt_b$")


def test_templates_escape_values_set_symbols_and_join_lines():
    shown = fill("<p>{{ name }} of\n$F_c$</p>\n<p></p>", name="<b> $v$")
    assert shown == "<p>&lt;b&gt; <i>v</i> of <i>F</i><sub>c</sub></p>\n<p></p>"
    assert fill('<i title="{{ name | attribute }}">', name='"$v$"') == '<i title="&quot;$v$&quot;">'


def test_a_value_that_a_template_lacks_is_an_error():
    with pytest.raises(UndefinedError, match="'name' is undefined"):
        fill("{{ name }}")
