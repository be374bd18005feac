"""What the controller as described commands along a log, beside the force that was logged."""

from collections.abc import Iterable, Iterator

from stickslip.identification.criteria.controller_check import check_reading, in_time
from stickslip.logs import Finding, Reading
from stickslip.logs.plausibility import correction
from stickslip.thresholds import control_match


def check_rig(reading: Reading) -> Iterator[Finding]:
    """Yield a finding if the force of a rig's log is not that of the loop that it was sent.

    A force that is only out of scale is a finding of the estimation.
    """
    check = check_reading(reading)
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


def check_description(reading: Reading, findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return the findings on a log, with one if the described controller does not command it."""
    reading, found = in_time(reading, findings)
    check = check_reading(reading)
    if not (check and check.error > control_match.NEAR):
        return found
    differs = f"it differs by {check.difference}"
    given = reading.recording.position_command is not None
    path = "the position command, of which half a sample counts, " if given else ""
    advice = f"check {path}gains, tau_f, feedforward, the unit of the force and its limit"
    if check.factor != 1.0:
        differs = f"the logged force is {check.factor:.3g} times as large"
        advice = f"give {correction(reading, 1.0 / check.factor)}, or correct the gains"
    other = Finding(
        "warning",
        "the controller as described does not command the logged force",
        f"{differs}; expected at most {100 * control_match.NEAR:g} %",
        f"{advice}; learn would try compensators in another loop",
    )
    return (*found, other)
