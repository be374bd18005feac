"""An FMU may log with an environment that is not the one it was given: its message is kept."""

import re
import subprocess
import sys

import pytest

from stickslip import cosim
from tests.corpus.hostile import faults
from tests.cosim.single import joined

pytestmark = pytest.mark.slow

FOREIGN = 1  # the address 1, see faults.c
SAID = re.compile("the FMU says: (call [0-9]+|it) broke")  # see faults.c


def pair(folder, plan, version, kind, first="none 1 0"):
    """Return a system of two: the first never fails, the second as planned."""
    plans = {"sound": first, "broken": plan}
    fmus = {n: faults.write(folder / f"{n}.fmu", p, version, kind) for n, p in plans.items()}
    return joined(fmus)


@pytest.mark.parametrize("environment", range(6))
@pytest.mark.parametrize("kind", ["plain", "typed"])
def test_the_message_of_a_step_that_fails(tmp_path, version, kind, environment):
    compiled = (version, kind) == (3, "plain")
    system = pair(tmp_path, f"DoStep 0 3 {environment}", version, kind)
    with (
        system.prepare(step=0.1, stop=1.0, compiled=compiled) as simulation,
        pytest.raises(cosim.SimulationError) as error,
    ):
        simulation.run()
    assert str(error.value).startswith(f"broken: fmi{version}DoStep returned error")
    assert SAID.search(str(error.value))


def test_a_message_does_not_pass_to_another_component_later(tmp_path, version):
    """The first answers OK after it has logged an error; the second fails later, saying nothing."""
    system = pair(tmp_path, f"Silent 6 3 {FOREIGN}", version, "plain", f"Say 2 3 {FOREIGN}")
    with (
        system.prepare(step=0.1, stop=1.0) as simulation,
        pytest.raises(cosim.SimulationError, match=r"^broken: \w+DoStep returned error") as error,
    ):
        simulation.run()
    assert "the FMU says" not in str(error.value)


@pytest.mark.parametrize("call", ["DoStep", "SetReal", "Terminate"])
def test_in_a_container(tmp_path, call):
    """It passes on what its component says, to a tool that is not ours."""
    plan = f"{call} {1 if call == 'Terminate' else 4} 3 {FOREIGN}"
    system = pair(tmp_path, plan, 2, "plain")
    system.expose("u", "broken.u")
    path = cosim.write_fmu(system, tmp_path / "a.fmu", step=0.1)
    script = (
        "import fmpy, sys\n"
        "try:\n"
        f"    fmpy.simulate_fmu({str(path)!r}, stop_time=1.0, output_interval=0.1,"
        " logger=lambda *a: print(a[-1].decode()))\n"
        "except Exception as error:\n"
        "    print(type(error).__name__)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-500:]
    assert "broken: " in done.stdout
    assert "broke%" in done.stdout or "broke " in done.stdout
