"""Every coupling method reaches its order, whatever the FMU and its source."""

import numpy as np
import pytest

from stickslip.cosim import Adaptive, Coupling
from tests.cosim.single import one

METHODS = ["gauss_seidel", "jacobi", "iterative"]
KINDS = {
    "CS 2.0": (2, {"interpolates": False}),
    "CS 2.0 interpolating": (2, {}),
    "CS 3.0": (3, {}),
    "ME 2.0": (2, {"exchange": True}),
    "ME 3.0": (3, {"exchange": True}),
}
FINE = 1e-11  # of the solver of Model Exchange, far below the errors of the coupling
STEPS = (0.02, 0.01, 0.005)
each_kind = pytest.mark.parametrize("kind", KINDS)


def order_of(coupling, kind="ME"):
    """Return the order of a coupling; a quadratic extrapolation has no past in its first step."""
    first, best = coupling.degree + 1, 3 if coupling.method == "iterative" else 2
    means = 3 if kind.startswith("ME") or kind.endswith("interpolating") else 2
    return min(first, best, means)


def source_error(linear, kind, step, coupling, signal):
    """Return the greatest error for u = cos 3t of x' = u, y1 = x, y2 = x + 2 u: of x, and of y2."""
    version, abilities = KINDS[kind]
    parameters = {"b11": 1.0, "c11": 1.0, "c21": 1.0, "d21": 2.0}
    spec = {"step": step, "stop": 2.0, "coupling": coupling, "tolerance": FINE}
    system = one(linear(version, "d21", **abilities), parameters, "u1")
    with system.prepare(**spec) as simulation:
        result = simulation.run(inputs={"u": signal})
        t = result.time
    state = abs(result["a.y1"] - np.sin(3 * t) / 3).max()
    shown = abs(result["a.y2"] - np.sin(3 * t) / 3 - 2 * np.cos(3 * t))[1:].max()
    return state, shown


def coupled_error(pair, linear, kind, step, coupling, stop=1.0, tolerance=FINE):
    """Return the greatest error of the left of two masses, m."""
    version, abilities = KINDS[kind]
    spec = {"step": step, "stop": stop, "coupling": coupling, "tolerance": tolerance}
    with pair.system(linear, version, **abilities).prepare(**spec) as simulation:
        result = simulation.run()
    return abs(result["left.y1"] - pair.exact(result.time)).max()


def measured(errors):
    """Return the order from the finest step and the next; errors must lie above any floor."""
    assert min(errors) > 1e-9, "a floor of rounding or of a solver would hide the order"
    return np.log2(errors[-2] / errors[-1])


@each_kind
@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("sampled", [False, True], ids=["function", "array"])
def test_a_signal_from_outside(linear, kind, method, degree, sampled):
    coupling, states, outputs = Coupling(method, degree=degree), [], []
    for step in STEPS:
        signal = np.cos(3 * step * np.arange(round(2.0 / step) + 1)) if sampled else None
        signal = (lambda t: np.cos(3 * t)) if signal is None else signal
        state, shown = source_error(linear, kind, step, coupling, signal)
        states.append(state)
        outputs.append(shown)
    order = order_of(coupling, kind)
    assert measured(states) > order - 0.1
    assert kind.startswith("ME") or degree or measured(states) < 1.2  # the test can tell them apart
    if max(outputs) > 1e-7:
        assert measured(outputs) > order - 0.1


@each_kind
@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("method", METHODS)
def test_two_masses(two_masses, linear, kind, method, degree):
    coupling, errors = Coupling(method, degree=degree), []
    exchange = kind.startswith("ME")
    for step in STEPS[1:] if exchange else (2e-3, 1e-3):
        errors += [coupled_error(two_masses, linear, kind, step, coupling)]
    order = order_of(coupling, kind)
    if exchange:
        assert measured(errors) > order - 0.2
    else:
        assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.12)


@each_kind
@pytest.mark.parametrize("every", [{"left": 2}, {"right": 3}, {"left": 2, "right": 4}])
@pytest.mark.parametrize("method", METHODS[:2])
def test_several_rates(two_masses, linear, kind, method, every):
    errors = []
    for step in (1 / 240, 1 / 480):
        coupling = Coupling(method, every=every)
        errors.append(coupled_error(two_masses, linear, kind, step, coupling))
    assert measured(errors) > order_of(coupling) - 0.2


@pytest.mark.slow
@pytest.mark.parametrize(("degree", "method"), list(enumerate(METHODS)))
def test_adaptive_steps_follow_their_tolerance(two_masses, linear, method, degree):
    """The error of a step is of order degree + 1, the steps are chosen by it."""
    errors = []
    for tolerance in (1e-3, 1e-5) if degree else (1e-2, 1e-3):
        coupling = Coupling(method, degree=degree, adaptive=Adaptive(tolerance))
        errors.append(coupled_error(two_masses, linear, "CS 3.0", 0.05, coupling))
    assert errors[1] < errors[0] / 2
    assert errors[1] < (0.02 if degree == 0 else 2e-3)


@pytest.mark.parametrize(
    ("step", "coupling"),
    [
        (1e-3, Coupling(degree=1)),
        (1e-2, Coupling("iterative")),
        (5e-2, Coupling(degree=2, adaptive=Adaptive(1e-5))),
    ],
    ids=["constant", "iterative", "adaptive"],
)
def test_the_solver_is_tighter_than_the_coupling(two_masses, linear, step, coupling):
    """With the tolerance of a single FMU, 1e-5, the errors of the solver are greater."""
    kind, finer = "ME 2.0", {"tolerance": None}
    error = coupled_error(two_masses, linear, kind, step, coupling, **finer)
    assert error < 1.25 * coupled_error(two_masses, linear, kind, step, coupling)
    assert error < coupled_error(two_masses, linear, kind, step, coupling, tolerance=1e-5) / 3


@pytest.mark.parametrize("kind", ["CS 2.0", "CS 2.0 interpolating"])
def test_iteration_keeps_a_stiff_pair_stable_where_the_others_blow_up(stiff_pair, linear, kind):
    jacobi, gauss_seidel, iterative = (
        coupled_error(stiff_pair, linear, kind, 2e-3, coupling, stop=2.0)
        for coupling in ("jacobi", "gauss_seidel", "iterative")
    )
    assert jacobi > 1e3
    assert gauss_seidel > 1e3
    assert iterative < (0.02 if "interpolating" in kind else 0.3)


@pytest.mark.parametrize("method", METHODS)
def test_an_fmu_that_refuses_derivatives_is_given_means(two_masses, linear, method, caplog):
    """It declares canInterpolateInputs, and answers error to derivatives of order 2."""
    runs = []
    for abilities in ({"flags": ("-DMAX_ORDER=1",)}, {"interpolates": False}):
        system = two_masses.system(linear, **abilities)
        with system.prepare(step=0.1, stop=1.0, coupling=Coupling(method, degree=2)) as simulation:
            runs += [simulation.run().values, simulation.run().values]
    for values in runs[1:]:
        np.testing.assert_array_equal(values, runs[0])
    said = [r.getMessage() for r in caplog.records if "derivatives" in r.getMessage()]
    assert len(said) == 2  # one for each component
    assert "left refuses derivatives of its inputs" in " ".join(said)
