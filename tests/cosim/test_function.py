# ruff: noqa: ARG001, ARG005 - a component gives its function every argument, used or not
"""Systems of Python functions and of FMUs against closed forms."""

import pickle
import signal

import numpy as np
import pytest

from stickslip import cosim
from tests.cosim.single import joined, one

STEP, STOP = 0.1, 2.0
SYSTEM = {"step": STEP, "stop": STOP}


def integrate(t, h, x, u):
    """x' = u with the input held, which is exact."""
    x = x + h * u["u"]
    return x, x


def minus_twice(t, u):
    return -2.0 * u["u"]


def integrator(state=1.0):
    return cosim.Function(integrate, {"u": "m/s"}, {"y": "m"}, state)


def decay():
    """Return x' = -2 x."""
    gain = cosim.Function(minus_twice, {"u": "m"}, {"y": "m/s"})
    return joined({"plant": integrator(), "gain": gain}, "plant.y gain.u", "gain.y plant.u")


@pytest.mark.parametrize("compiled", [False, True])
def test_a_closed_loop_is_its_difference_equation(compiled):
    """Forward Euler: the gain sees the state at the start of each step, in each of three runs."""
    with decay().prepare(**SYSTEM, compiled=compiled) as simulation:
        assert simulation.order == ["gain", "plant"]
        for _ in range(3):
            result = simulation.run()
            x = (1 - 2 * STEP) ** np.arange(len(result.time))
            assert result["plant.y"] == pytest.approx(x, rel=1e-13)


def test_a_function_beside_an_fmu(make, version):
    """It takes part in units and exposed inputs, and gives what the FMU in its place."""
    found = []
    for gain in (
        cosim.Fmu(make("gain", version)),
        cosim.Function(lambda t, u: {"y": u["u"]}, {"u": "N"}, {"y": "N"}),
    ):
        system = joined({"gain": gain, "plant": make("integrator", version)}, F="gain.u")
        system.connect("gain.y", "plant.u", cosim.Link(cosim.Scaling(0.5)))
        with system.prepare(**SYSTEM, record=["F", "gain.u", "gain.y", "plant.y"]) as simulation:
            simulation.run(inputs={"F": 3.0})
            found.append(simulation.run(inputs={"F": np.sin}).frame())
    assert found[0].equals(found[1])


def test_a_run_goes_on_from_its_saved_state(tmp_path):
    """The state is an array; another simulation, of a system that was pickled, resumes."""

    system = decay()
    with system.prepare(**SYSTEM) as simulation:
        whole = simulation.run()
        simulation.run(until=1.0)
        simulation.save(tmp_path / "state")
        spec = pickle.loads(pickle.dumps(simulation.spec))  # noqa: S301 - written here
    with spec.prepare() as other:
        rest = other.resume(tmp_path / "state")
    assert np.array_equal(rest["plant.y"], whole["plant.y"][10:])


@pytest.mark.parametrize(
    ("step", "message"),
    [
        (lambda t, u: 1 / (1 - t), "raised ZeroDivisionError: .* in the step from t = 0.9 s"),
        (lambda t, u: {"z": 1.0}, r"returned the outputs \['z'\], expected \['y'\]"),
        (lambda t, u: "much", "could not convert .*during initialisation"),
        (lambda t, u: np.inf if t else 0.0, "f.y: .*not finite"),
        (lambda t, h, x, u: (np.ones(2), 0.0), r"new state has shape \(2,\), expected \(\)"),
    ],
    ids=["raises", "other outputs", "no number", "infinite", "another state"],
)
def test_a_function_that_fails_ends_the_run(step, message):
    state = () if step.__code__.co_argcount == 2 else (1.0,)
    system = one(cosim.Function(step, {}, {"y": None}, *state), name="f")
    with (
        system.prepare(**SYSTEM) as simulation,
        pytest.raises(cosim.SimulationError, match=message),
    ):
        simulation.run()


def test_an_interruption_is_not_an_error_of_the_function():
    def interrupted(t, u):
        raise KeyboardInterrupt

    system = one(cosim.Function(interrupted, {}, {"y": None}), name="f")
    with system.prepare(**SYSTEM) as simulation, pytest.raises(KeyboardInterrupt):
        simulation.run()


def test_what_needs_an_fmu_says_so(tmp_path):
    system = decay()
    message = "needs FMUs, but plant is the Python function integrate"
    with pytest.raises(cosim.ConnectionFault, match=f"isolation {message}"):
        system.prepare(**SYSTEM, isolation="process")
    with pytest.raises(cosim.SspError, match=f"an SSP {message}"):
        cosim.write_ssp(system, tmp_path / "s.ssp")
    with pytest.raises(cosim.ConnectionFault, match=f"a container {message}"):
        cosim.write_fmu(system, tmp_path / "s.fmu", step=STEP)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("inputs", "outputs"), [({"a": None}, {"a": None}), ({"u": None}, {}), ({"": None}, {"y": "m"})]
)
def test_names_are_checked(inputs, outputs):
    with pytest.raises(cosim.ConnectionFault, match="cannot have the variables"):
        cosim.Function(minus_twice, inputs, outputs)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs POSIX timers")
def test_an_interrupt_ends_a_run_within_about_a_second(make):
    system = joined({f"x{i}": (make("integrator"), {"u": 1.0}) for i in range(200)})

    def interrupt(*_):
        raise KeyboardInterrupt

    simulation = system.prepare(step=1e-6, stop=3.0, record=["x0.y"])
    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    try:
        with pytest.raises(KeyboardInterrupt):
            simulation.run()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
