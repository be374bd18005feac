"""A package of FMUs becomes one FMU that does the same in other tools."""

import fmpy
import numpy as np
import pytest

from stickslip import cosim
from stickslip.cli import main

pytestmark = pytest.mark.slow

STEP, STOP = 5e-4, 1.0


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
