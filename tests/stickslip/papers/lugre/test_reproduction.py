"""The claims of the paper, on the FMUs and by FMPy."""

import fmpy
import numpy as np
import pytest

from stickslip import models
from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.evaluation.motions import TRAINING, VALIDATION
from stickslip.papers.lugre.reproduction import Options, reproduce
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.servo.systems import Compensator, build_fmus, deployed, paper_loop
from stickslip.servo.velocity_loop import design_velocity_loop
from tests.cosim.single import by_fmpy

pytestmark = pytest.mark.slow


def measured(table):
    rows = table[table.velocity == "measured"]
    return rows.set_index(["region", "metric"])


def test_table_4_without_is_the_papers_and_compensation_reduces_it_far_beyond(reproduction):
    table = measured(reproduction.validation.table())
    assert (table.reduction > table.paper_reduction).all()
    assert (table.reduction.to_numpy() >= [0.85, 0.90, 0.85, 0.90]).all()
    whole = reproduction.validation.table()
    assert (whole[whole.velocity == "true"].reduction > 0.8).all()
    assert table["without"].to_numpy() == pytest.approx(table.paper_without.to_numpy(), rel=0.05)


def test_what_is_learned_is_near_the_drive_and_what_became_worse_is_remarked(reproduction):
    learned = reproduction.refinement.values["F_c"]
    assert learned == pytest.approx(reproduction.truth["F_c"], rel=0.01)
    for row in reproduction.table2().itertuples():
        if row.parameter in LUGRE:
            worse = abs(row.learned / row.drive - 1) > abs(row.identified / row.drive - 1)
            assert ("farther from the drive" in row.remark) == worse


@pytest.mark.thorough
def test_a_changed_drive_is_learned_as_well(tmp_path, quiet):
    truth = {"m": 9.0, "F_c": 3.0, "F_s": 5.1, "sigma_0": 8e5}
    found = reproduce(Options(truth=truth, seeds=1), tmp_path, quiet)
    assert found.refinement.values["F_c"] == pytest.approx(3.0, rel=0.01)
    table = measured(found.validation.table())
    assert (table.reduction > table.paper_reduction).all()


@pytest.mark.parametrize("command", [TRAINING, VALIDATION], ids=["training", "trapezoid"])
@pytest.mark.parametrize("current_loop", [False, True])
def test_with_exact_parameters_the_loop_is_the_nominal_loop(loop, tmp_path, command, current_loop):
    """Fig. 2(a) reduces to Fig. 2(b): RMS(v - v_r) below 0.1 % of RMS(v)."""
    build_fmus(tmp_path, {"encoder": False, "dac": False, "current_loop": current_loop})
    exact = {name: PAPER[name] for name in LUGRE}
    system = paper_loop(tmp_path, loop, exact)
    record = ["drive.v", "nominal.v_r"]
    with system.prepare(step=LOOP.T_s, stop=10.0, record=record) as simulation:
        run = simulation.run(inputs={"v_cmd": command})
    gap = run["drive.v"] - run["nominal.v_r"]
    assert np.sqrt(np.mean(gap**2)) < 1e-3 * np.sqrt(np.mean(run["drive.v"] ** 2))


T = np.arange(1401) * LOOP.T_s
COMMANDS = {
    "training": TRAINING.sample(T),
    "trapezoid": VALIDATION.sample(T),
    "not at rest": 0.02 + 0.01 * np.sin(40 * T),
}
RECORDED = "compensator.F_mean"
TUNED = {name: 1.07 * PAPER[name] for name in LUGRE}


@pytest.mark.parametrize("fmi", [2, 3])
def test_fmpy_computes_the_same_bits(fmus, tmp_path, capfd, fmi):
    """FMPy steps the compensator alone over the commands of runs of the whole loop."""
    loop = design_velocity_loop(Datasheet().axis(PAPER["m"], PAPER["b"]), LOOP)
    block = deployed(Compensator("compensator", "compensator", TUNED), loop, loop.T_s)
    fmu = models.build_fmu(block.model, tmp_path, start=block.values, fmi=fmi)
    variables = fmpy.read_model_description(fmu).modelVariables
    names = [one.name for one in variables if one.causality == "input"]
    how = {"record": (RECORDED,), "constant_step": True}
    for v_cmd in COMMANDS.values():
        given = loop.commands(v_cmd)
        with paper_loop(fmus, loop, TUNED).prepare(step=loop.T_s, stop=T[-1], **how) as simulation:
            recorded = simulation.run(inputs=given)[RECORDED]
        inputs = [T, *((name, float, given.get(name, 0.0 * T)) for name in names)]
        theirs = by_fmpy(fmu, loop.T_s, T[-1], "F_ff", inputs=inputs)["F_ff"]
        assert len(theirs) == len(T)
        assert theirs.tobytes() == recorded.tobytes()
    assert "missing input" not in "".join(capfd.readouterr())
