"""A package of FMUs becomes one FMU that does the same in other tools."""

import zipfile
from pathlib import PurePosixPath

import fmpy
import numpy as np
import pytest

from stickslip import cosim
from stickslip.cli import main
from stickslip.fmi import toolchain

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


@pytest.mark.parametrize(
    "platform",
    [
        *(name for name in toolchain.PLATFORMS if "windows" not in name),
        pytest.param("all", marks=pytest.mark.thorough),  # for Windows a C runtime is compiled
    ],
)
def test_the_tuned_loop_becomes_an_fmu_of_any_platform(results, platform, tmp_path):
    targets = toolchain.PLATFORMS if platform == "all" else [platform]
    arguments = ["export", results / "loop.ssp", "--as", "fmu", "--platform", platform]
    assert main([str(a) for a in [*arguments, "--out", tmp_path]]) == 0
    with zipfile.ZipFile(tmp_path / "loop.fmu") as archive:
        folders = {PurePosixPath(name).parent.name for name in archive.namelist()}
    assert folders.issuperset(toolchain.PLATFORMS[name].fmi2 for name in targets)


def test_its_state_restores_in_another_instance(results, tmp_path):
    arguments = ["export", results / "loop.ssp", "--as", "fmu", "--out", tmp_path]
    assert main([str(a) for a in arguments]) == 0
    system = cosim.System()
    system.add("loop", tmp_path / "loop.fmu", {"v_cmd": 0.005})
    state = tmp_path / "half.state"
    with system.prepare(step=STEP, stop=STOP) as simulation:
        whole = simulation.run()["loop.drive.v"]
        simulation.run(until=STOP / 2)
        simulation.save(state)
    with system.prepare(step=STEP, stop=STOP) as simulation:
        rest = simulation.resume(state)["loop.drive.v"]
    np.testing.assert_array_equal(rest, whole[-len(rest) :])
