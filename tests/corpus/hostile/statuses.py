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
        (3, "DoStep", 4, 4, "fatal", "fatal", r"in the step from t = 0\.3 s"),
        (2, "DoStep", 0, 2, "discard", "discard", r"in the step from t = 0 s"),
        (3, "DoStep", 4, 5, "five", "the unknown status 5", r".*t = 0\.3 s"),
        (2, "DoStep", 4, 101, "a-number-of-ours", "the unknown status 101", r".*t = 0\.3 s"),
        (2, "EnterInitializationMode", 1, 4, "fatal", "fatal", "during initialisation"),
        (3, "Terminate", 1, 4, "fatal", "fatal", "after the last step"),
    ]
]  # fmt: skip
_EXCHANGED = [
    _case(17, f"exchange-{word}-at-{function}", f"Model Exchange: {function} returns {word}", f"{function} {nth} {status}", f"faults: fmi{version}\\w+ returned {said}", version, "exchange")
    for version, function, nth, status, word, said in [
        (2, "GetDerivatives", 5, 3, "error", "error"),
        (3, "CompletedIntegratorStep", 2, 42, "forty-two", "the unknown status 42"),
    ]
]  # fmt: skip

CASES = [
    *_STATUSES,
    *_EXCHANGED,
    _case(17, "discard-of-a-value", "FMI 2.0: SetReal discards a parameter", "SetReal 1 2", "fmi2SetReal returned discard during initialisation", more="--set k=2"),
    _case(17, "fatal-at-a-whole-number", "FMI 3.0: GetInt32 returns fatal", "GetInteger 3 4", "fmi3GetInt32 returned fatal", 3, "typed"),
    _case(17, "event-at-no-time", "the next event is at NaN", "Event 1 0", "fmi2NewDiscreteStates gave a time that cannot be", kind="exchange"),
    _case(17, "event-always-now", "the next event is at the present time, for ever", "Event 1 1", "came to no end of events", 3, "exchange"),
    _case(17, "states-without-end", "FMI 3.0: 2^40 continuous states", "States 1 0", "fmi3GetNumberOfContinuousStates needs more memory", 3, "exchange"),
    *(
        _case(18, f"output-{word}-{version}", f"FMI {version}.0: an output is {word} from 0.5 s on", f"Output 1 {number}", r"faults\.y: .* not finite in the step from t = 0\.4 s", version)
        for version in (2, 3)
        for number, word in enumerate(("nan", "infinite", "minus-infinite"))
    ),
    _case(18, "output-nan-typed", "an output is NaN beside one that is a whole number", "Output 1 0", r"faults\.y: .* not finite in the step from t = 0\.4 s", kind="typed"),
    _case(18, "derivative-nan", "a derivative is NaN from 0.5 s on", "Slope 1 0", r"faults.* (could not integrate|not finite)", kind="exchange"),
    _case(18, "parameter-nan", "a parameter is set to NaN", "none 1 0", r"faults\.k = nan is outside its range", more="--set k=nan"),
    _case(18, "parameter-infinite", "a parameter is set to infinity", "none 1 0", r"faults\.k = inf is outside its range", more="--set k=inf"),
    _read("input-nan", "an input is NaN", "0,0\n0.5,nan\n1,0\n", "u"),
    _read("input-infinite", "an input is infinite", "0,0\n0.5,inf\n1,0\n", "u"),
    *(
        _case(19, f"save-{name}-{version}", f"FMI {version}.0: {about}", plan, says, version, more=_SAVE)
        for version in (2, 3)
        for name, about, plan, says in [
            ("null", "the state that is saved is NULL", "Nothing 1 0", "GetFMU[sS]tate gave no state"),
            ("empty", "a serialised state has 0 bytes", "Size 1 0", "gave 0 bytes"),
            ("growing", "a serialised state changes its size", "Size 1 1", "gave 64 bytes, then 65"),
            ("huge", "a serialised state has 2^60 bytes", "Size 1 2", "gave 1152921504606846976 bytes"),
            ("fatal", "serialising returns fatal", "Serialize 1 4", "SerializeFMU[sS]tate returned fatal"),
        ]
    ),
    _case(19, "save-error", "the state cannot be had, though declared", "GetState 1 3", "fmi2GetFMUstate returned error", more=_SAVE),
    *(
        _resumed(f"resume-{name}-{version}", f"FMI {version}.0: {about}", plan, says, version)
        for version in (2, 3)
        for name, about, plan, says in [
            ("frozen", "setting a state brings nothing back", "Freeze 1 0", r"faults\.y: is .* does not bring back its state"),
            ("error", "a state cannot be read back", "Deserialize 1 3", r"De[sS]erializeFMU[sS]tate returned error"),
        ]
    ),
]  # fmt: skip
"""Groups 17, 18 and 19."""
