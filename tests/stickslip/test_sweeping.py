"""Sweeps and searches over parameters, against the closed form of a sliding mass."""

import os
import warnings

import numpy as np
import pandas as pd
import pytest

import stickslip as ss
from stickslip.ga.execution.evaluation import DIED
from stickslip.simulation import IdleInputs, MissedSamples
from tests.cosim.single import one

M, B, PUSH, STOP = 5.557, 6.6135, 12.0, 0.5
RUN = {"stop": STOP, "step": 1e-3, "inputs": {"u": PUSH}}


def end(result: ss.Result) -> float:
    """Return the velocity at the end [m/s]."""
    return float(result["v"][-1])


def expected(F_c: float, m: float) -> float:
    return (PUSH - F_c) / B * (1.0 - np.exp(-B / m * STOP))


@pytest.fixture(scope="module")
def stage(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stage")
    return ss.build_fmu("stage", folder, law="coulomb_stribeck", start={"F_s": 1.0, "F_c": 1.0})


def test_a_sweep_is_a_table_of_all_combinations(stage):
    values = {"F_c": [0.2, 0.5], "stage.m": [M, 2 * M, 3 * M]}
    done = []
    table = ss.sweep(stage, values, {"end": end}, progress=lambda *n: done.append(n), **RUN)
    assert list(table) == ["F_c", "stage.m", "end"]
    assert table["stage.m"].tolist() == 2 * [M, 2 * M, 3 * M]
    closed = [expected(row["F_c"], row["stage.m"]) for _, row in table.iterrows()]
    np.testing.assert_allclose(table["end"], closed, rtol=1e-3)
    assert done == [(n, 6) for n in range(1, 7)]


def test_a_row_of_the_table_gives_its_run_again(stage):
    table = ss.sweep(stage, pd.Series({"F_c": [0.2, 0.5], "m": [M, 2 * M]}), {"end": end}, **RUN)
    row, frame = table[["F_c", "m"]].iloc[2], table.loc[[2], ["F_c", "m"]]
    alone = one(stage, row, "u", "stage")
    start = pd.concat([row, pd.Series({"F_s": 1.0})])
    built = ss.build_fmu("stage", stage.parent / "built", law="coulomb_stribeck", start=start)
    ends = [end(ss.simulate(stage, parameters=given, **RUN)) for given in (row, frame)]
    ends += [end(ss.simulate(model, **RUN)) for model in (built, alone)]
    for isolation in (None, "process"):
        with alone.prepare(step=1e-3, stop=STOP, isolation=isolation) as simulation:
            given = row.rename({"F_c": "stage.F_c", "m": "stage.m"})
            inputs = pd.DataFrame({"u": [PUSH, PUSH]}, index=[0.0, STOP])
            ends.append(end_of_stage(simulation.run(given, inputs)))
    assert ends == [table["end"][2]] * 6
    with pytest.raises(ss.Fault, match="workers must be a whole number and at least 1, got '2'"):
        ss.sweep(stage, {"F_c": [0.2]}, {"end": end}, workers="2", **RUN)


def test_a_frame_drives_and_a_bar_shows(stage, capsys):
    frame = pd.DataFrame({"u": [PUSH, PUSH]}, index=[0.0, STOP])
    run = RUN | {"inputs": frame, "record": ["v"], "progress": True}
    table = ss.sweep(stage, {"F_c": [0.2, 0.5]}, {"end": end}, **run)
    assert table["end"].iloc[0] == pytest.approx(expected(0.2, M), rel=1e-3)
    assert "2/2" in capsys.readouterr().err
    ss.optimise(stage, {"F_c": (0.1, 0.5, 0.9)}, end, evaluations=30, **run)
    assert "/30" in capsys.readouterr().err


def test_workers_give_the_same_table(stage):
    values = {"F_c": np.linspace(0.1, 0.9, 5)}
    alone = ss.sweep(stage, values, {"end": end}, **RUN)
    assert ss.sweep(stage, values, {"end": end}, workers=2, **RUN).equals(alone)


def test_a_run_that_fails_is_a_row_with_its_reason(stage):
    def fails(_: float, u: dict[str, float]) -> float:
        if u["v"] > 0.4:
            raise ValueError("too fast")
        return u["v"]

    system = ss.System("watched")
    system.add("stage", stage, {"u": PUSH})
    system.add("guard", ss.Function(fails, {"v": "m/s"}, {"y": "m/s"}))
    system.connect("stage.v", "guard.v")
    table = ss.sweep(system, {"stage.F_c": [0.1, 9.0]}, {"end": end_of_stage}, stop=0.5, step=1e-2)
    assert "too fast" in table["reason"][0]
    assert np.isnan(table["end"][0])
    assert table["reason"][1] == ""
    assert table["end"][1] == pytest.approx(expected(9.0, M), rel=2e-2)


def test_a_figure_that_raises_costs_its_own_cell(stage):
    system = ss.System("lone")
    system.add("stage", stage, {"u": PUSH})
    figures = {
        "end": end_of_stage,
        "one": lambda result: 1 // int(end_of_stage(result) > 0.1),
        "none": lambda result: 1.0 if end_of_stage(result) > 0.1 else None,
    }
    table = system.sweep({"F_c": [0.2, 20.0]}, figures, stop=STOP)
    assert table["end"][0] == pytest.approx(expected(0.2, M), rel=1e-2)
    assert table["end"][1] == pytest.approx(0.0, abs=1e-3)
    assert table["one"][0] == 1.0
    assert table.loc[1, ["one", "none"]].isna().all()
    assert table["reason"][0] == ""
    assert table["reason"][1].startswith("figure 'one': ZeroDivisionError")


def end_of_stage(result: ss.Result) -> float:
    return float(result["stage.v"][-1])


def test_mistakes_are_one_line(stage):
    with pytest.raises(ss.Fault, match="has no variable 'F_k'; did you mean"):
        ss.sweep(stage, {"F_k": [1.0]}, {"end": end}, **RUN)
    with pytest.raises(ss.Fault, match="needs parameters with values, and figures"):
        ss.sweep(stage, {"F_c": []}, {"end": end}, **RUN)
    with pytest.raises(ss.Fault, match=r"figure .end.: KeyError: .*w' was not recorded.*; no run"):
        ss.sweep(stage, {"F_c": [1.0]}, {"end": lambda result: result["w"][-1]}, **RUN)
    with pytest.raises(ss.Fault, match=r"F_c: expected \(lowest, highest\) or .*, got \(0.1,\)"):
        ss.optimise(stage, {"F_c": (0.1,)}, end, **RUN)
    with pytest.raises(ss.Fault, match=r"F_c: .* that grow, got \(2, 1\)"):
        ss.optimise(stage, {"F_c": (2, 1)}, end, **RUN)
    with pytest.raises(ss.Fault, match=r"stage\.b = -1\.0 .* is outside its range 0\.0 "):
        ss.optimise(stage, {"b": (-1.0, 5.0)}, end, **RUN)
    for given in ({"parameters": [1.0], "figures": {}}, {"parameters": {}, "figures": [end]}):
        with pytest.raises(ss.Fault, match="expected a dictionary with a name for each"):
            ss.sweep(stage, **given, **RUN)
    with pytest.raises(ss.Fault, match="lone: no stop time is proposed; give one in s: stop="):
        ss.simulate(ss.System("lone"))


def test_a_run_whose_process_dies_leaves_the_others_of_its_batch(stage):
    figures = {"end": lambda run: end(run) if end(run) > expected(0.35, M) else os._exit(1)}
    found = ss.sweep(stage, {"F_c": [0.2, 0.2, 0.5]}, figures, where="processes", **RUN)
    assert list(found["reason"]) == ["", "", DIED]
    assert found["end"][0] == found["end"][1]
    with pytest.raises(ss.Fault, match="worker process that ran it died; no run gave a figure"):
        ss.sweep(stage, {"F_c": [0.5]}, figures, where="processes", **RUN)


def test_a_run_warns_of_inputs_that_nothing_drives(stage):
    with pytest.warns(IdleInputs, match=r"u = 0\S* .*by inputs, or any constants by parameters"):
        ss.simulate(stage, stop=0.1, step=1e-3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ss.simulate(stage, stop=0.1, step=1e-3, inputs={"u": 1.0})
        ss.simulate(stage, stop=0.1, step=1e-3, parameters={"u": 1.0})


@pytest.fixture
def two(stage):
    """A stage behind a controller of 0.5 ms."""
    system = ss.System("two")
    system.add("stage", stage)
    system.add("c", ss.build_fmu("velocity_controller", stage.parent))
    system.expose("v_cmd", "c.v_cmd", "c.v_hat")
    return system


def test_a_run_warns_of_a_component_that_nothing_drives(two):
    """An optional input of a controller that something else drives is no reason to warn."""
    with pytest.warns(IdleInputs, match=r"^inputs .*values: stage\.u = 0\S* N;"):
        ss.simulate(two, stop=0.1, step=5e-4, inputs={"v_cmd": 0.1})


@pytest.mark.parametrize(
    ("step", "better"), [(5e-4, ""), (2.5e-4, ""), (4e-4, "0.00025"), (0.02, "0.0005")]
)
def test_a_run_warns_of_a_step_that_divides_no_sample_period(two, step, better):
    two.connect("c.u", "stage.u")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", MissedSamples)
        ss.simulate(two, stop=0.1, step=step, inputs={"v_cmd": 0.1})
    late = f"period c.T_s = 0.0005 s, so that it samples late or not at all; choose {better} s"
    assert [str(one.message)[-len(late) :] for one in caught] == [late] * bool(better)


def test_a_system_as_one_fmu_warns_of_such_a_step_as_well(two, tmp_path):
    two.connect("c.u", "stage.u")
    fmu = ss.write_fmu(two, tmp_path / "two.fmu", step=5e-4)
    with pytest.warns(MissedSamples, match=r"sample period two\.c\.T_s = 0\.0005 s"):
        ss.simulate(fmu, stop=0.1, step=4e-4, inputs={"v_cmd": 0.1})


def test_a_constant_of_an_exposed_input_reaches_all_its_targets(two):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", IdleInputs)
        by = {
            how: ss.simulate(two, stop=0.1, step=5e-4, record=["c.u"], **{how: {"v_cmd": 0.1}})
            for how in ("parameters", "inputs")
        }
    np.testing.assert_array_equal(by["parameters"]["c.u"], by["inputs"]["c.u"])
    assert by["inputs"]["c.u"][-1] != 0.0


def test_a_start_value_that_something_overrules_is_refused(stage):
    system = ss.System("two")
    system.add("stage", stage)
    system.add("half", ss.blocks.gain(0.5))
    system.expose("u", "half.u")
    system.connect("half.y", "stage.u")
    figures = {"end": end_of_stage}
    with pytest.raises(ss.Fault, match=r"stage.u: .* gets its values from half.y"):
        system.sweep({"stage.u": [1.0, 2.0]}, figures, stop=STOP)
    with pytest.raises(ss.Fault, match=r"half.u: .* gets its values from u"):
        ss.simulate(system, parameters={"half.u": 1.0}, inputs={"u": 2.0}, stop=STOP)
    with pytest.raises(ss.Fault, match=r"no exposed input 'stage\.u'"):  # not that of half.u
        ss.simulate(system, inputs={"stage.u": 2.0}, stop=STOP)
    with pytest.raises(ss.Fault, match=r"an input is given twice: u, stage\.u"):
        ss.simulate(stage, inputs={"u": 12.0, "stage.u": 3.0}, stop=STOP)
    free = system.sweep({"half.u": [2.0 * PUSH]}, figures, stop=STOP)
    assert free["end"][0] == pytest.approx(expected(1.0, M), rel=1e-2)


def test_an_fmu_runs_from_a_start_time(stage):
    fmu = ss.Fmu(stage)
    result = ss.simulate(fmu, start=1.0, stop=1.0 + STOP, step=1e-3, inputs={"stage.u": PUSH})
    assert result.time[0] == 1.0
    assert end(result) == pytest.approx(expected(1.0, M), rel=1e-3)
    assert repr(ss.info(fmu)) == repr(ss.info(stage))


@pytest.mark.parametrize("workers", [1, 2])
def test_a_search_finds_the_value_that_made_a_run(stage, workers):
    aim = expected(0.4, M)

    def off(result: ss.Result) -> float:
        return abs(end(result) - aim)

    found = ss.optimise(
        stage, {"F_c": (0.05, 0.9, 0.95)}, off, evaluations=150, **RUN, workers=workers
    )
    assert found.parameters["F_c"] == pytest.approx(0.4, rel=5e-3)
    assert f"F_c = {found.parameters['F_c']:.6g}; cost" in repr(found)
    assert found.cost == found.table["cost"].min()
    assert list(found.table) == ["generation", "F_c", "cost", "reason"]
    assert len(found.table) <= 150
    assert found.table["F_c"][0] == pytest.approx(0.9)


def test_a_search_finds_the_constant_input_of_one_fmu(stage, caplog):
    def off(result: ss.Result) -> float:
        return abs(end(result) - expected(1.0, M))

    run = {"stop": STOP, "step": 1e-3, "evaluations": 60}
    found = ss.optimise(stage, {"u": (5.0, 40.0)}, off, **run)
    assert found.parameters["u"] == pytest.approx(PUSH, rel=0.02)
    assert "u: its own value, 0, is outside the range; the search begins at 5" in caplog.text
    swept = ss.sweep(stage, {"u": [PUSH]}, {"end": end}, stop=STOP, step=1e-3)
    assert swept["end"].tolist() == pytest.approx([expected(1.0, M)], rel=1e-3)
