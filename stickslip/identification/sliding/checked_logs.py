"""Logs of one drive, each checked with the force of position that all of them show together."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from stickslip.errors import RecordingError
from stickslip.identification.sliding.position_force import find_position_force, with_position_force
from stickslip.logs import Finding, Reading, Recording, read_stretches, with_checks
from stickslip.logs.joined import join
from stickslip.logs.sets import Log
from stickslip.thresholds import log_content


@dataclass(frozen=True)
class Checked:
    """A log as it was read."""

    reading: Reading
    findings: tuple[Finding, ...]  # of that and of its checks
    load: float = 0.0  # that the drive moved beside its own mass [kg]

    @property
    def gains(self) -> Mapping[str, float] | None:
        """Of its controller's FMU; None where that is not known."""
        return self.reading.controller.parameters()

    @property
    def kind(self) -> tuple[str, bool, bool]:
        """Its motion, and whether it lacks force and position: that of logs that are joined."""
        recording = self.reading.recording
        return recording.motion, recording.force is None, recording.position is None

    @property
    def fault(self) -> Finding | None:
        """The first fault of the log that spoils what is learned from it."""
        return next((one for one in self.findings if one.spoils), None)


@dataclass(frozen=True)
class Refused:
    """A log from which nothing can be learned."""

    error: RecordingError
    findings: tuple[Finding, ...] = ()


def check_logs(logs: Sequence[Log], *, alone: bool | None = None) -> Iterator[Checked | Refused]:
    """Yield each log, read and checked; one of several does not tell what it shows."""
    share = min(1.0, log_content.TOGETHER / len(logs))
    read = [_read(log, share) for log in logs]
    sound = [one for one in read if isinstance(one, Checked) and not _errors(one.findings)]
    kinds = [one.kind for one in sound]
    alike = [one for one in sound if one.kind == max(kinds, key=kinds.count)]
    found = find_position_force(joined(alike)) if alike else None
    own = len(logs) == 1 if alone is None else alone
    for log, one in zip(logs, read, strict=True):
        if isinstance(one, Refused):
            yield one
            continue
        reading = one.reading
        if found is not None:
            reading = replace(reading, recording=with_position_force(reading.recording, found))
        findings = with_checks(reading, one.findings, alone=own)
        if errors := _errors(findings):
            yield Refused(RecordingError(f"{log.path}: {errors[0]}"), findings)
        else:
            yield replace(one, reading=reading, findings=findings)


def _read(log: Log, share: float) -> Checked | Refused:
    try:
        return Checked(*read_stretches(log.path, log.description, share), log.load)
    except RecordingError as error:
        return Refused(error)


def _errors(findings: tuple[Finding, ...]) -> list[Finding]:
    return [one for one in findings if one.severity == "error"]


def joined(checked: Sequence[Checked]) -> Recording:
    """Return logs as one recording."""
    recordings = [one.reading.recording for one in checked]
    if len(checked) == 1 and not checked[0].load:
        return recordings[0]
    return join(recordings, [one.gains for one in checked], [one.load for one in checked])
