"""FMUs that answer what they should not: statuses, values, states that do not come back."""

from pathlib import Path

from tests.corpus.hostile import faults
from tests.corpus.hostile.case import Case
from tests.corpus.hostile.faults import Kind
from tests.cosim.single import one

_SAVE = "--until 0.5 --save state"


def _case(
    group: int,
    name: str,
    about: str,
    plan: str,
    says: str,
    version: int = 2,
    kind: Kind = "plain",
    more: str = "",
) -> Case:
    files = {"a.fmu": lambda path: faults.write(path, plan, version, kind)}
    return Case(group, name, about, says, f"simulate a.fmu {more}", files)


def _resumed(name: str, about: str, plan: str, says: str, version: int) -> Case:
    def save(path: Path) -> None:
        system = one(path.with_name("a.fmu"), u="u", name="faults")
        with system.prepare(step=0.1, stop=1.0) as simulation:
            simulation.run(until=0.5)
            simulation.save(path)

    files = {"a.fmu": lambda path: faults.write(path, plan, version), "state": save}
    return Case(19, name, about, says, "simulate a.fmu --resume state", files)


def _read(name: str, about: str, rows: str, says: str) -> Case:
    files = {"a.fmu": lambda path: faults.write(path, "none 1 0"), "u.csv": f"time,u\n{rows}"}
    return Case(18, name, about, says, "simulate a.fmu --input u.csv", files)


_STATUSES = [
    _case(17, f"{word}-at-{function}-{version}", f"FMI {version}.0: {function} returns {word}", f"{function} {nth} {status}", f"faults: fmi{version}{function} returned {said}.*{when}", version)
    for version, function, nth, status, word, said, when in [
        (2, "DoStep", 4, 3, "error", "error", r"in the step from t = 0\.3 s"),
        (3, "DoStep", 4, 5, "five", "the unknown status 5", r".*t = 0\.3 s"),
        (2, "EnterInitializationMode", 1, 4, "fatal", "fatal", "during initialisation"),
        (3, "Terminate", 1, 4, "fatal", "fatal", "after the last step"),
    ]
]  # fmt: skip

CASES = [
    *_STATUSES,
    _case(17, "fatal-at-a-whole-number", "FMI 3.0: GetInt32 returns fatal", "GetInteger 3 4", "fmi3GetInt32 returned fatal", 3, "typed"),
    _case(17, "event-at-no-time", "the next event is at NaN", "Event 1 0", "fmi2NewDiscreteStates gave a time that cannot be", kind="exchange"),
    _case(17, "event-always-now", "the next event is at the present time, for ever", "Event 1 1", "came to no end of events", 3, "exchange"),
    _case(17, "states-without-end", "FMI 3.0: 2^40 continuous states", "States 1 0", "fmi3GetNumberOfContinuousStates needs more memory", 3, "exchange"),
    _case(18, "output-infinite", "an output is infinite from 0.5 s on", "Output 1 1", r"faults\.y: .* not finite in the step from t = 0\.4 s", 3),
    _case(18, "output-nan-typed", "an output is NaN beside one that is a whole number", "Output 1 0", r"faults\.y: .* not finite in the step from t = 0\.4 s", kind="typed"),
    _case(18, "derivative-nan", "a derivative is NaN from 0.5 s on", "Slope 1 0", r"faults.* (could not integrate|not finite)", kind="exchange"),
    _case(18, "parameter-nan", "a parameter is set to NaN", "none 1 0", r"faults\.k = nan is outside its range", more="--set k=nan"),
    _read("input-infinite", "an input is infinite", "0,0\n0.5,inf\n1,0\n", "u"),
    *(
        _case(19, f"save-{name}", f"the state: {about}", plan, says, version, more=_SAVE)
        for version, name, about, plan, says in [
            (2, "null", "what is saved is NULL", "Nothing 1 0", "GetFMUstate gave no state"),
            (3, "empty", "its bytes are none", "Size 1 0", "gave 0 bytes"),
            (2, "growing", "its bytes change their number", "Size 1 1", "gave 64 bytes, then 65"),
            (3, "huge", "its bytes are 2^60", "Size 1 2", "gave 1152921504606846976 bytes"),
        ]
    ),
    _resumed("resume-frozen", "setting a state brings nothing back", "Freeze 1 0", r"faults\.y: is .* does not bring back its state", 2),
]  # fmt: skip
"""Groups 17, 18 and 19."""
