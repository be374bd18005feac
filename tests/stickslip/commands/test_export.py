"""What was learned is exported, and refused where it is unknown or not robust."""

import json

import fmpy
import numpy as np
import pytest

import stickslip as ss
from stickslip import cosim, models
from stickslip.cli import main
from stickslip.errors import UsageError
from stickslip.learned.file import LearnedFile
from stickslip.learned.writing import loop_document
from stickslip.servo.axis import LOOP, Axis
from stickslip.servo.systems import Compensator, build_fmus, build_loop
from stickslip.servo.velocity_filter import FilterSpecification, Observer, design_velocity_filter
from stickslip.servo.velocity_loop import design_velocity_loop


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmus")
    system = ss.System("chain")
    system.add("ff", models.build_fmu("static_feedforward", folder))
    system.add("scale", models.build_fmu("adaptive_scale", folder, fmi=3), {"rate": 4.0, "b": 0.0})
    system.add("splines", models.build_fmu("lffc", folder), {"gamma": 0.1})
    system.connect("ff.F", "scale.F_in")
    system.expose("v", "ff.v", "scale.v_r", "splines.v_r")
    system.expose("x", "scale.x_enc")
    system.expose("F_m", "scale.F_m", "splines.u")
    return system


@pytest.fixture
def simulation(system):
    """Return a simulation that has slid with a friction of 8 N."""
    with system.prepare(step=5e-4, stop=1.0) as simulation:
        x = 0.02 * (simulation.time - 5e-4)
        simulation.run(inputs={"v": 0.02, "x": x, "F_m": 8.0})
        yield simulation


def test_what_was_learned_goes_through_the_file_bit_for_bit(simulation, tmp_path):
    """With the other parameters, and the other entries of the file stay."""
    path = tmp_path / "learned.json"
    path.write_text(json.dumps({"schema": 2, "refusal": "none"}))
    ss.save_learned(path, simulation)
    document = json.loads(path.read_text())
    assert document["refusal"] == "none"
    assert {*document["components"]} == {"scale", "splines"}
    found = ss.load_learned(path)
    learned = simulation.learned()
    assert len(learned) == 29
    assert learned["scale.s_0"] > 1.2
    assert {name: found[name] for name in learned} == learned
    assert (found["scale.rate"], found["splines.gamma"], found["scale.b"]) == (4.0, 0.1, 0.0)
    system = simulation.spec.system.copy()
    for name, value in found.items():
        system.set(name, value)
    with system.prepare(step=5e-4, stop=1e-3, record=["scale.s", "splines.w[1,1]"]) as again:
        first = again.run(inputs={"v": 0.0, "x": 0.0, "F_m": 0.0})
    assert first["scale.s"][-1] == learned["scale.s_0"]
    assert first["splines.w[1,1]"][-1] == learned["splines.w_0[1,1]"]


def test_each_component_is_exported_with_it(simulation, tmp_path, capsys):
    path = ss.save_learned(tmp_path / "learned.json", simulation)
    for form, ends in (("fmu", ["fmu"]), ("c", ["h", "c"]), ("st", ["st"])):
        arguments = ["export", "components", "--parameters", str(path), "--out", str(tmp_path)]
        assert main([*arguments, "--as", form]) == 0
        names = [f"{name}.{end}" for name in ("scale", "splines") for end in ends]
        assert capsys.readouterr().out.split() == [str(tmp_path / name) for name in names]
    learned = simulation.learned()
    for name, value in learned.items():
        component, _, parameter = name.partition(".")
        fmu = ss.Fmu(tmp_path / f"{component}.fmu")
        assert fmu.variables[parameter].start == value
    for end in ("c", "st"):
        assert repr(learned["scale.s_0"]) in (tmp_path / f"scale.{end}").read_text()


@pytest.mark.parametrize(
    ("components", "reason"),
    [
        ({"a": {"model": "lfc", "parameters": {}}}, "there is no model 'lfc'"),
        ({"a": {"model": "lffc", "parameters": {"w_1": 1.0}}}, "lffc has no parameter w_1"),
        ({"a": {"model": "lffc", "parameters": {"gamma": 7.0}}}, "gamma = 7 1 is outside 0"),
        ({"a": {"model": "lffc", "parameters": {"gamma": "fast"}}}, "could not convert"),
        ({"a": {"model": "drive", "parameters": {}}}, "drive is not a compensator"),
        ({"a": {"model": "lffc", "law": "gms", "parameters": {}}}, "contains no friction law"),
        ({"../a": {"model": "lffc", "parameters": {}}}, "expected a name of letters"),
        ({"a": {"model": "lffc"}}, "'parameters'"),
        ([1], "no attribute"),
    ],
)
@pytest.mark.parametrize("command", ["export components", "export compensator", "validate"])
def test_what_is_unknown_is_refused_in_one_line(tmp_path, capsys, components, reason, command):
    path = tmp_path / "learned.json"
    path.write_text(json.dumps({"components": components}))
    option = [] if command == "validate" else ["--parameters"]
    assert main([*command.split(), *option, str(path)]) == 1
    error = capsys.readouterr().err
    assert reason in error
    assert "components: expected names, each with model and parameters" in error
    assert error.count("\n") == 1


def test_a_system_that_learns_nothing_writes_nothing(tmp_path):
    system = ss.System("plain")
    system.add("ff", models.build_fmu("static_feedforward", tmp_path))
    with system.prepare(step=5e-4, stop=1e-3) as simulation:
        simulation.run()
        with pytest.raises(UsageError, match="no component of plain learns"):
            ss.save_learned(tmp_path / "learned.json", simulation)
    assert not (tmp_path / "learned.json").exists()


def test_a_file_without_components_has_nothing_to_export(tmp_path, capsys):
    path = tmp_path / "learned.json"
    path.write_text("{}")
    assert main(["export", "components", "--parameters", str(path)]) == 1
    assert "contains no components" in capsys.readouterr().err
    assert ss.load_learned(path) == {}


def test_components_stand_behind_the_compensator_when_it_is_validated(tmp_path):
    """A scale of 0.5 halves its force; what contains a law cannot stand there."""
    parts = {"scale": {"model": "adaptive_scale", "parameters": {"s_0": 0.5, "rate": 0.0}}}
    path = tmp_path / "learned.json"
    path.write_text(json.dumps({"components": parts}))
    chain = [Compensator("compensator", "compensator"), *LearnedFile(path).behind]
    build_fmus(tmp_path, {})
    loop = design_velocity_loop(Axis(5.557, 6.6135, 1e-4), LOOP)
    system = build_loop(tmp_path, loop, chain)
    with system.prepare(step=5e-4, stop=0.1) as simulation:
        result = simulation.run(inputs={"v_cmd": 0.01})
    assert result["scale.F"][-1] == 0.5 * result["compensator.F_mean"][-1] > 2.0
    path.write_text(json.dumps({"components": {"a": {"model": "compensator", "parameters": {}}}}))
    with pytest.raises(UsageError, match="'a' cannot stand behind the compensator"):
        _ = LearnedFile(path).behind


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


STEP, STOP = 5e-4, 1.0


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_the_tuned_loop_in_fmpy(results, fmi, tmp_path, capsys):
    package = results / "loop.ssp"
    chosen = ["--outputs", "drive.*", "--parameters", "compensator.*", "--set", "drive.F_c=5"]
    arguments = ["export", package, "--as", "fmu", "--fmi", fmi, "--out", tmp_path, *chosen]
    assert main([str(a) for a in arguments]) == 0
    path = tmp_path / "loop.fmu"
    assert capsys.readouterr().out.strip() == str(path)

    system, _ = cosim.read_ssp(package)
    system.set("drive.F_c", 5.0)
    with system.prepare(step=STEP, stop=STOP) as simulation:
        v_cmd = 0.01 * np.sin(2 * np.pi * simulation.time)
        ours = simulation.run({"compensator.sigma_0": 1e5}, {"v_cmd": v_cmd})
    command = np.array(
        list(zip(ours.time, v_cmd, strict=True)), dtype=[("time", "f8"), ("v_cmd", "f8")]
    )
    theirs = fmpy.simulate_fmu(
        str(path),
        stop_time=STOP,
        step_size=STEP,
        output_interval=STEP,
        start_values={"compensator.sigma_0": 1e5},
        input=command,
    )
    shown = theirs.dtype.names[1:]
    assert shown
    assert all(name.startswith("drive.") for name in shown)
    for name in shown:
        np.testing.assert_array_equal(theirs[name], ours[name], err_msg=name)
