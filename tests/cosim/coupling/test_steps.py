"""Steps that adapt to a transient, and components that step at rates of their own."""

import numpy as np
import pytest

from stickslip import cosim
from tests.cosim.single import joined


def errors(pair, linear, step, coupling, **abilities):
    """Return error of the left mass, m, and effort."""
    system = pair.system(linear, **abilities)
    with system.prepare(step=step, stop=10.0, coupling=coupling) as simulation:
        result = simulation.run()
        again = simulation.run()
        effort = simulation.effort
    np.testing.assert_array_equal(result.values, again.values)
    return np.abs(result["left.y1"] - pair.exact(result.time)).max(), effort


def test_adaptive_steps_take_fewer_steps_for_the_same_error(transient_pair, linear):
    fixed = cosim.Coupling("iterative", degree=2)
    adaptive = cosim.Coupling("iterative", degree=2, adaptive=cosim.Adaptive(1e-3))
    worse, many = errors(transient_pair, linear, 1e-3, fixed)
    better, few = errors(transient_pair, linear, 0.05, adaptive)
    assert better < worse
    assert few["steps"] < many["steps"] / 20
    assert few["rejected"] > 0


@pytest.mark.parametrize("method", ["iterative", "jacobi"])
@pytest.mark.parametrize("interpolates", [True, False])
def test_the_error_follows_the_tolerance_of_adaptive_steps(
    two_masses, linear, method, interpolates
):
    """Also where FMUs take the mean of a parabola, which is of second order only."""
    for tolerance in (1e-5, 1e-7):
        system = two_masses.system(linear, interpolates=interpolates)
        adaptive = cosim.Coupling(method, degree=2, adaptive=cosim.Adaptive(tolerance))
        result = system.prepare(step=0.25, stop=1.0, coupling=adaptive).run()
        error = np.abs(result["left.y1"] - two_masses.exact(result.time)).max()
        assert 1e-3 * tolerance < error < tolerance


def test_a_step_is_kept_just_when_its_prediction_holds(linear):
    """A line through the last two points misses y'' = 1 by h^2 after a step of h."""
    source = linear(), {"a12": 1.0, "b22": 1.0, "c11": 1.0, "f1": 1e3}
    parts = {"source": source, "sink": (linear(), {"b11": 1.0, "c11": 1.0})}
    system = joined(parts, "source.y1 sink.u1", u="source.u2")
    effort = {}
    for share in (0.99, 1.01):  # of the miss that the tolerance allows
        adaptive = cosim.Adaptive(share * 0.1**2 / 1e3)
        coupling = cosim.Coupling("jacobi", degree=1, adaptive=adaptive)
        with system.prepare(step=0.1, stop=1.0, coupling=coupling) as simulation:
            result = simulation.run(inputs={"u": 1.0})
            effort[share] = simulation.effort
        np.testing.assert_allclose(result["source.y1"], 1e3 + result.time**2 / 2, rtol=1e-12)
    assert effort[0.99]["rejected"] > 0
    assert (effort[1.01]["rejected"], effort[1.01]["steps"]) == (0, 10)


def test_an_adaptive_step_names_who_cannot_go_back(two_masses, linear):
    system = two_masses.system(linear, restores=False)
    coupling = cosim.Coupling("jacobi", adaptive=cosim.Adaptive())
    with pytest.raises(cosim.ConnectionFault, match=r"left .*canGetAndSetFMUstate"):
        system.prepare(step=0.1, stop=1.0, coupling=coupling)


@pytest.fixture
def sampled(make, version):
    """A gain k = -1 closes the loop around an integrator."""
    controller = make("gain", version), {"k": -1.0}
    parts = {"plant": (make("integrator", version), {"k": 1.0}), "controller": controller}
    return joined(parts, "plant.y controller.u", "controller.y plant.u")


def test_a_slow_controller_holds_its_output_while_the_plant_steps_on(sampled):
    coupling = cosim.Coupling(every={"controller": 4})
    y = sampled.prepare(step=0.0625, stop=4.0, coupling=coupling).run()["plant.y"]
    # what the controller saw at t[4 n] acts from there to t[4 n + 4]
    np.testing.assert_allclose(y[4::4], 0.75 * y[:-4:4], rtol=1e-14)
    np.testing.assert_allclose(np.diff(y, 2).reshape(-1)[:3], 0.0, atol=1e-15)


def test_rates_that_do_not_fit_are_refused(sampled, linear, two_masses):
    with pytest.raises(cosim.ExperimentError, match=r"controller steps 3 at a time.*10 steps"):
        sampled.prepare(step=0.1, stop=1.0, coupling=cosim.Coupling(every={"controller": 3}))
    with pytest.raises(cosim.ConnectionFault, match="no component 'plan'"):
        sampled.prepare(step=0.1, stop=1.0, coupling=cosim.Coupling(every={"plan": 2}))
    coupling = cosim.Coupling("iterative", degree=0, every={"left": 2})
    with pytest.raises(cosim.ExperimentError, match="must step at one rate"):
        two_masses.system(linear).prepare(step=0.1, stop=1.0, coupling=coupling)
