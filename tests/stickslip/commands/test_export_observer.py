"""``stickslip export observer``: the observer of a learned.json, and when it is refused."""

import json

import pytest

from stickslip.cli import main
from stickslip.learned.writing import loop_document
from stickslip.servo.axis import LOOP, Axis
from stickslip.servo.velocity_filter import FilterSpecification, Observer, design_velocity_filter
from stickslip.servo.velocity_loop import design_velocity_loop

AXIS = Axis(5.557, 6.6135, 1e-4)


def document(rate: float = 1.5, refusal: str = "", order: int = 1) -> dict:
    """Return a learned.json with the observer of a disturbance rate [N/s^0.5], or [N/s^1.5]."""
    kalman = design_velocity_filter(AXIS, LOOP.T_s, FilterSpecification(4e-7, 0.05, rate, order))
    values = Observer(kalman, 0.75).parameters()
    return {
        "loop": loop_document(design_velocity_loop(AXIS, LOOP)),
        "observer": {
            "refusal": refusal,
            "parameters": {name: {"value": value} for name, value in values.items()},
        },
    }


@pytest.fixture
def export(tmp_path, capsys):
    def run(content: dict, *options: str) -> tuple[int, str, str]:
        path = tmp_path / "learned.json"
        path.write_text(json.dumps(content))
        arguments = ["export", "observer", "--parameters", str(path), "--out", str(tmp_path)]
        status = main([*arguments, *options])
        return status, *capsys.readouterr()

    return run


@pytest.mark.parametrize(("rate", "order", "name"), [(1.5, 1, "L_d"), (300.0, 2, "L_1")])
def test_it_writes_the_gains_in_each_form(export, tmp_path, rate, order, name):
    content = document(rate, order=order)
    gain = repr(content["observer"]["parameters"][name]["value"])
    for form, names in (("fmu", ["fmu"]), ("c", ["h", "c"]), ("st", ["st"])):
        status, out, error = export(content, "--as", form)
        assert (status, error) == (0, "")
        assert out.split() == [str(tmp_path / f"observer.{end}") for end in names]
    assert gain in (tmp_path / "observer.c").read_text()
    assert gain in (tmp_path / "observer.st").read_text()


def test_a_loop_that_is_not_robust_with_it_is_refused(export, tmp_path):
    status, _, error = export(document(rate=50.0))
    assert status == 1
    assert "with the observer the loop has a peak sensitivity of 2.5" in error
    assert not (tmp_path / "observer.fmu").exists()
    status, _, error = export(document(rate=50.0), "--force", "--as", "c")
    assert status == 0
    assert "peak sensitivity" in error


def test_what_learn_refused_or_never_designed_is_refused_in_a_line(export):
    status, _, error = export(document(refusal="creep is 1.2 times worse"))
    assert status == 1
    assert "learn does not recommend the observer: creep is 1.2 times worse; --force" in error
    status, _, error = export({"observer": {"refusal": "the mass is not known"}})
    assert status == 1
    assert "contains no disturbance observer: the mass is not known" in error
    broken = document()
    del broken["observer"]["parameters"]["tau_i"]
    assert "observer: 'tau_i' is missing" in export(broken)[2]
    broken["observer"]["parameters"]["tau_i"] = {"value": -1.0}
    assert "observer: dob: tau_i = -1 s is outside 0 .. 1 s" in export(broken)[2]
    broken["observer"]["model"] = "drive"
    assert "observer: model 'drive' is not a compensator" in export(broken)[2]
    broken["observer"]["model"] = "absent"
    assert "observer: " in export(broken)[2]
