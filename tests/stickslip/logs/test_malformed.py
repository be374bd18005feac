"""Each fault of a log is reported in one line; tests/corpus/hostile holds more of them."""

import io

import numpy as np
import pytest
import scipy.io

from stickslip import models
from stickslip.errors import RecordingError, UsageError
from stickslip.logs import Column, Controller, Description, load_description, read_recording

ROWS = [f"{k * 0.001:.3f},{np.sin(k / 50):.9f},{np.cos(k / 50):.9f}" for k in range(100)]


def csv(*, header="t,x,F", **changed: str) -> bytes:
    """Return a log of 100 rows; ``row_7="..."`` puts a text into that row of the file."""
    lines = [header, *ROWS]
    for key, text in changed.items():
        lines[int(key.removeprefix("row_")) - 1] = text
    return "\n".join(lines).encode()


def mat(content) -> bytes:
    stream = io.BytesIO()
    scipy.io.savemat(stream, content)
    return stream.getvalue()


T, X = np.arange(50) * 1e-3, np.linspace(0, 1, 50)

FILES = {
    "blank": (b"\n \n\t\n", "empty"),
    "text in the first row": (csv(row_2="0,abc,1"), "column 'x'", "row 2", "'abc'"),
    "time hardly moves": (csv(row_40="0.03700000000001,1,2"), "row 40", "time moves by 1e-14 s"),
    "nanoseconds as s": (csv().replace(b"t,x", b"time [ns],x"), "sample period of 1e-12 s"),
    "time not finite": (csv(row_9="nan,1,2"), "row 9", "nan"),
    "time empty": (csv(row_9=",1,2"), "row 9"),
    "huge": (csv(row_12="0.010,1e300,2"), "'x'", "row 12", "1e+300"),
    "an empty column": (csv(**{f"row_{k}": f"{k},,1" for k in range(2, 102)}), "position: no"),
    "no time": (csv(header="a,x,F"), "no column of time", "Column(name=NAME)", "a, x, F"),
    "no header": (csv(header=ROWS[0], row_2="0.0005,0,1"), "no column of time"),
    "two positions": (csv(header="t,x,q"), "which column is position, x or q?"),
    "unknown unit": (csv(header="t,x [furlong],F"), "'x'", "'furlong'", "Column(unit="),
    "current without scale": (csv(header="t,x,current_A"), "force is in A", "Column(scale="),
    "counts without scale": (csv(header="t,x [counts],F"), "is in counts", "encoder_step"),
    "wrong delimiter": (csv().replace(b",", b":"), "no row of numbers", "'0.099:"),
    "mat of structs": (mat({"log": np.array([(1, 2), (3, 4)], dtype=[("a", "O"), ("b", "O")])}),
                       "no vectors", "log"),
    "mat without vectors": (mat({"kp": 3.0, "name": "axis"}), "no vectors", "kp, name"),
    "mat of unequal lengths": (mat({"t": T, "x": X[:40]}), "'x'", "40 values", "'t'", "50"),
    "mat with text for x": (mat({"t": T, "x": "abc"}), "no column of position"),
}  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_a_malformed_file_is_reported_in_one_line(name, tmp_path):
    content, *parts = FILES[name]
    path = tmp_path / "log.bin"
    path.write_bytes(content)
    with pytest.raises((RecordingError, UsageError)) as caught:
        read_recording(path)
    message = str(caught.value)
    assert "\n" not in message
    assert all(part in message for part in parts)


DESCRIPTIONS = {
    "column beyond": ({"columns": {"position": Column(7)}}, "no column 7, there are 3"),
    "column twice": ({"columns": {"position": Column("x"), "force": Column("x")}}, "cannot be"),
    "unit": ({"columns": {"position": Column("x", "parsec")}}, "unit 'parsec' of position"),
    "motion": ({"motion": "linear", "columns": {"position": Column("x", "deg")}}, "Column(scale="),
    "scalar": ({"columns": {"force": Column("F", "V", "gtau")}}, "'gtau' is not a number"),
    "no product": ({"columns": {"force": Column("F", "V", "2+3")}}, "'2+3' is not a number"),
    "scale 0": ({"columns": {"force": Column("F", scale=0)}}, "other than 0"),
    "span": ({"span": (5.0, 6.0)}, "no samples there; the log has 0 to 0.099 s"),
    "step": ({"encoder_step": -1.0}, "encoder_step = -1"),
    "gain": ({"controller": "PI", "gains": {"K_p": "x", "K_i": 1.0}}, "gain K_p = x"),
    "role": ({"columns": {"pos": Column(1)}}, "did you mean 'position'"),
    "no motion": ({"motion": "sideways"}, "linear or rotary"),
    "kind": ({"controller": "fuzzy"}, "P, PI, PID, cascade, P-PI, P-P, none"),
    "few": ({"controller": "PI", "gains": {"K_p": 1}}, "expected gains I_x and P_x or K_i and K_p"),
    "more": ({"controller": "P-P", "gains": {"K_x": 1, "K_p": 1, "P_x": 2}}, "got K_p, K_x, P_x"),
    "name": ({"gains": {"Kp": 1}}, "did you mean"),
    "period": ({"sample_period": 0.0}, "more than 0"),
    "backwards": ({"span": (2.0, 1.0)}, "begin before end"),
    "delimiter": ({"delimiter": "ab"}, "one character"),
    "decimal": ({"decimal": ";"}, "expected . or ,"),
}


@pytest.mark.parametrize("name", DESCRIPTIONS)
def test_a_description_that_does_not_suit_the_file(name, tmp_path):
    given, message = DESCRIPTIONS[name]
    path = tmp_path / "log.csv"
    path.write_bytes(csv())
    with pytest.raises((RecordingError, UsageError)) as caught:
        read_recording(path, Description(**given))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("columns = 3", "expected a table"),
        ("[columns.position]\nnam = 'x'", "did you mean 'name'"),
        ("[columns]\nposition = {index = 0}", "a number from 1"),
        ("[columns]\nposition = {name = 'x', index = 1}", "got both"),
        ("span = [1, 2, 3]", "[begin, end]"),
        ("[controller]\nK_p = 3", "controller '': expected one of P"),
        ("[controller]\nkind = 'P'\nK_p = [3]", "controller.K_p"),
    ],
)
def test_a_toml_file_that_is_wrong(text, message, tmp_path):
    path = tmp_path / "log.toml"
    path.write_text(text)
    with pytest.raises(UsageError) as caught:
        load_description(path)
    assert message in str(caught.value)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_a_controller_sets_all_gains_of_its_fmu():
    """Missing gains are 0, whatever the FMU starts with; unknown T_s and u_max are not set."""
    given = Controller("cascade", K_x=5.0, K_p=2.0, tau_f=1e-3).parameters()
    names = {variable.name for variable in models.load_model("velocity_controller").variables}
    assert set(given) <= names
    assert given == {"K_x": 5.0, "P_x": 0.0, "I_x": 0.0, "K_p": 2.0, "K_i": 0.0, "tau_f": 1e-3}
    assert Controller("P", K_p=1.0, T_s=1e-3, u_max=9.0).parameters()["u_max"] == 9.0
    assert Controller().parameters() is None
