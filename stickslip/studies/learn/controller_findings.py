"""What the controller as described commands along a log, beside the force that was logged."""

from collections.abc import Iterator

from stickslip.identification.criteria.controller_check import ControllerCheck, check_controller
from stickslip.identification.criteria.motion import against_motion, recording_scale
from stickslip.identification.criteria.runs import candidate_fmus
from stickslip.logs import Finding, Reading, aligned, samples_late
from stickslip.thresholds import control_match


def check_rig(reading: Reading) -> Iterator[Finding]:
    """Yield a finding if the force of a rig's log is not that of the loop that it was sent.

    A force that is only out of scale is a finding of the estimation.
    """
    check = _commanded(reading)
    if check and check.error > control_match.FOREIGN and check.factor == 1.0:
        yield Finding(
            "warning",
            "the rig's log is not that of the loop and the command that it was sent",
            f"the controller's force differs by {check.error:.2g} of the logged one; expected at "
            f"most {control_match.FOREIGN:g}",
            "check that move returns time in s, position in m and force in N with their signs, and "
            "applies the gains",
            spoils="values",
        )


def check_description(reading: Reading) -> Iterator[Finding]:
    """Yield a finding if the described controller does not command the force of a log."""
    check = _commanded(reading)
    if check and check.error > control_match.NEAR:
        differs = f"it differs by {100 * check.error:.2g} %"
        if check.factor != 1.0:
            differs = f"the logged force is {check.factor:.3g} times as large"
        given = reading.recording.position_command is not None
        path = "the position command, of which half a sample counts, " if given else ""
        yield Finding(
            "warning",
            "the controller as described does not command the logged force",
            f"{differs}; expected at most {100 * control_match.NEAR:g} %",
            f"check {path}gains, tau_f, feedforward, the unit of the force and its limit; learn"
            " would try compensators in another loop",
        )


def _commanded(reading: Reading) -> ControllerCheck | None:
    gains, recording = reading.controller.parameters(), reading.recording
    if gains is None or recording.force is None:
        return None
    recording = aligned(recording, samples_late(recording))
    scale = recording_scale(recording)
    scaled, _ = against_motion(scale.recording(recording))
    with candidate_fmus() as fmus:
        return check_controller(fmus, scaled, scale.values(gains))
