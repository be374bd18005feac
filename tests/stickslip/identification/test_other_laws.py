"""The same fit estimates the parameters of other laws than LuGre's."""

import pytest
from drives import GAINS, STAGE, run

from stickslip.identification.estimation import LearnSettings, Task, candidate_fmus, learn
from stickslip.logs import Recording
from stickslip.planning import Limits, plan


@pytest.mark.slow
def test_a_dahl_drive_of_another_program_is_estimated_by_its_law():
    """Recorded without damping of the bristles, which Dahl's law does not have.

    The encoder rounds, as ours does: another phase, which a log does not tell, moves m by 0.04 %.
    """
    command = plan(Limits(duration=8.0))["velocity_command"].to_numpy()
    drive = run("dahl", command, uneven=0.0, sigma_1=0.0, phase=0.5)
    recording = Recording(
        drive["t"],
        drive["position"],
        force=drive["applied"],
        velocity_command=drive["v_cmd"],
        encoder_step=4e-7,
        source="dahl",
    )
    with candidate_fmus("dahl") as fmus:
        learned = learn(Task(fmus, recording, GAINS, LearnSettings(law="dahl")))
    assert learned.criterion == "output error"
    assert learned.known.keys() == {"sigma_0", "F_c", "m", "b"}
    for name, known in learned.known.items():
        apart = abs(known.value - STAGE[name])
        assert apart < 3.0 * known.standard_error, name
        assert apart < 0.05 * STAGE[name], name
