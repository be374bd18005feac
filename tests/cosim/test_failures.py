"""A run that fails says who, what and when, and leaves a simulation that runs again."""

import numpy as np
import pytest

from stickslip import cosim

GIVE_NAN, TERMINATE, RETURN_EARLY = 10, 11, 12


HOW = [("jacobi", False), ("gauss_seidel", False), ("gauss_seidel", True)]
each_way = pytest.mark.parametrize(("coupling", "compiled"), HOW)


@pytest.fixture
def simulation(make, version, coupling, compiled):
    system = cosim.System("loop")
    system.add("source", make("integrator", version), {"u": 1.0})
    system.add("gain", make("gain", version))
    system.connect("source.y", "gain.u")
    times = {"step": 0.01, "stop": 10.0}
    with system.prepare(**times, coupling=coupling, compiled=compiled) as simulation:
        yield simulation


def test_an_early_return_that_was_not_allowed_is_a_failure(make):
    system = cosim.System()
    system.add("a", make("gain", 3), {"fault": RETURN_EARLY, "fault_time": 0.5})
    with pytest.raises(cosim.SimulationError, match="returned early"):
        system.prepare(step=0.1, stop=1.0).run()


@each_way
def test_values_that_are_not_finite_pass_where_they_are_allowed(
    make, version, compiled, coupling, tmp_path
):
    system = cosim.System()
    system.add("source", make("integrator", version), {"u": 1.0})
    system.add("gain", make("gain", version))
    system.connect("source.y", "gain.u")
    how = {"step": 0.1, "stop": 1.0, "coupling": coupling, "compiled": compiled}
    with system.prepare(**how, allow_nan=True) as simulation:
        result = simulation.run({"source.fault": GIVE_NAN, "source.fault_time": 0.45})
        assert np.isfinite(result["source.y"][:6]).all()
        assert np.isnan(result["source.y"][6:]).all()
        assert np.isnan(result["gain.y"][-1])
        rows = result.to_csv(tmp_path / "out.csv").read_text().splitlines()
        assert "nan" in rows[-1].split(",")
        with pytest.raises(cosim.ParameterError):
            simulation.run({"gain.k": float("nan")})
