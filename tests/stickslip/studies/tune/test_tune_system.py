"""Tuning of a system of FMUs by a cost file, against a minimum that is known."""

import json
from dataclasses import replace

import pytest

import stickslip as ss
from stickslip import cli

COST = """
[[signal]]
name = "total.y"
reference = 1.0
window = [0.5, 1.0]

[[signal]]
name = "total.u2"
reference = "aim.y"
weight = 4.0
"""


@pytest.fixture
def files(tmp_path):
    """Return an .ssp that adds two numbers a and b, and a cost file.

    The cost is (a + b - 1)^2 + 4 (b - 0.7)^2, least at a = 0.3 and b = 0.7.
    """
    system = ss.System("numbers")
    system.add("total", ss.blocks.sum("++"), {"u1": 0.9, "u2": 0.1})
    system.add("aim", ss.blocks.gain(0.5), {"u": 1.4})
    cost = tmp_path / "cost.toml"
    cost.write_text(COST)
    return ss.write_ssp(system, tmp_path / "numbers.ssp"), cost


RANGES = {"total.u1": (-2.0, 2.0), "total.u2": (0.0, 3.0)}
RUN = {"stop": 1.0, "step": 0.1}


def test_a_quadratic_cost_is_least_where_it_is_known_to_be(files):
    found = ss.tune(files[0], RANGES, files[1], evaluations=400, **RUN)
    first = found.table.iloc[0]
    own = {"total.u1": 0.9, "total.u2": 0.1}  # the values of the system
    assert first[[*own]].to_dict() == pytest.approx(own)
    assert first["cost"] == pytest.approx(4.0 * 0.6**2, abs=1e-12)
    assert found.parameters == pytest.approx({"total.u1": 0.3, "total.u2": 0.7}, abs=0.01)
    assert "near an end" not in repr(found)
    assert "; total.u2: near an end of" in repr(replace(found, ranges={"total.u2": (0.699, 3.0)}))


def test_the_command_writes_what_it_found(files, tmp_path, capsys):
    ranges = [f"{name}={low}:{high}" for name, (low, high) in RANGES.items()]
    out = tmp_path / "tuned"
    words = ["tune", str(files[0]), "--set-range", *ranges, "--cost", str(files[1])]
    words += ["--stop", "1", "--step", "0.1", "--evaluations", "60", "--out", str(out)]
    assert cli.main(words) == 0
    assert "The cost is" in capsys.readouterr().out
    document = json.loads((out / "tuned.json").read_text())
    a, b = (document["parameters"][name]["after"] for name in RANGES)
    assert document["cost"] == pytest.approx((a + b - 1.0) ** 2 + 4.0 * (b - 0.7) ** 2, abs=1e-12)
    assert document["cost"] < 1.44
    assert (out / "report.html").exists()
    assert "near an end" not in capsys.readouterr().out
    words[words.index("total.u2=0.0:3.0")] = "total.u2=0.9:3"
    assert cli.main(words) == 0
    assert "; total.u2: near an end of the range" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "one .*signal.* or more"),
        ("signal = 1", "signal = 1: expected tables"),
        ("[[signal]]\nweight = 1.0", "each with name"),
        ("[[signal]]\nname = 'a'\nwindow = 3", "expected .lowest, highest"),
        ("[[signal]]\nname = 'a'\nweight = -1.0", "weights of 0 or more"),
        ("[[signal]]\nname = 'a'\nfrom = 0", "no key 'signal.from'"),
        ("[[signal]]\nname = 'total.y'\nwindow = [5.0, 6.0]", "no sample .* lies in 5 to 6"),
    ],
)
def test_a_cost_file_that_is_not_valid_is_one_line(files, text, says):
    files[1].write_text(text)
    with pytest.raises(ss.Fault, match=says):
        ss.tune(files[0], RANGES, files[1], evaluations=20, **RUN)


def test_only_real_numbers_are_searched(files):
    drive = ss.build_fmu("drive", files[1].parent, law="lugre")
    with pytest.raises(ss.Fault, match=r"noise: expected a real number .* one of type Boolean"):
        ss.tune(drive, {"noise": (0.0, 1.0)}, lambda _: 0.0, **RUN)


@pytest.mark.parametrize("text", ["total.u1=1", "total.u1=2:1", "total.u1=a:b", "total.u1"])
def test_a_range_that_is_none_is_refused(files, text, capsys):
    words = ["tune", str(files[0]), "--cost", str(files[1]), "--set-range", text]
    assert cli.main(words) != 0
    assert "--set-range" in capsys.readouterr().err
