"""Linear systems as FMUs, against python-control's responses and closed forms."""

import math

import control
import fmpy
import numpy as np
import pytest

from stickslip import cosim, models
from tests.cosim.single import by_fmpy, exposed

each_version = pytest.mark.parametrize("fmi", [2, 3])


def run(path, step, n, inputs, parameters=None) -> cosim.Result:
    """Run for n steps; ``inputs`` are in the order of the system's."""
    system = exposed(path, parameters, "f")
    names = [f"f.{v.name}" for v in system.components["f"].variables.values() if v.name != "time"]
    with system.prepare(step=step, stop=n * step, record=names) as simulation:
        return simulation.run(inputs=dict(zip(system.inputs, inputs, strict=True)))


def many_modes(states: int) -> control.StateSpace:
    """Return lightly damped modes from 1 to 100 rad/s, in coordinates that mix them all."""
    rng = np.random.default_rng(3)
    w = np.geomspace(1.0, 100.0, states // 2)
    A = np.zeros((states, states))
    for k, rate in enumerate(w):
        A[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = [[-0.02 * rate, rate], [-rate, -0.02 * rate]]
    T = np.linalg.qr(rng.standard_normal((states, states)))[0]
    B, C = rng.standard_normal((states, 1)), rng.standard_normal((1, states))
    return control.ss(T @ A @ T.T, T @ B, C @ T.T, 0, name="modes")


def test_fifty_states_follow_python_controls_step_response(tmp_path):
    system = many_modes(50)
    path = models.export_lti(system, tmp_path, step=0.01)
    for step, n in ((0.01, 500), (0.0173, 20), (0.5, 10)):
        result = run(path, step, n, [1.0])
        expected = control.step_response(system, result.time).outputs
        assert np.ptp(expected) > 1.0
        np.testing.assert_allclose(result["f.y[0]"], expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("h", [1e-3, 0.37, 5.0, 1e4])
def test_stiff_first_order_lag_is_its_closed_form_at_any_step(h, tmp_path):
    """dx/dt = -(x - u) / T, T from 1 us to 10 s in one system: e^(-h / T) at every step."""
    T = np.array([1e-6, 1e-3, 10.0])
    system = control.ss(-np.diag(1 / T), 1 / T[:, None], np.eye(3), 0)
    result = run(models.export_lti(system, tmp_path), h, 3, [1e6])
    for k in range(3):
        expected = -1e6 * np.expm1(-result.time / T[k])
        np.testing.assert_allclose(result[f"f.y[{k}]"], expected, rtol=1e-12)


@pytest.mark.parametrize("h", [0.1, 0.123])
def test_double_integrator_from_its_own_start(h, tmp_path):
    """x = x0 + v0 t + u t^2 / 2: A cannot be inverted nor diagonalised."""
    system = control.ss([[0, 1], [0, 0]], [[0], [1]], [[1, 0]], 0, states=["x", "v"], inputs="u")
    path = models.export_lti(system, tmp_path, x0=[3.0, -1.0], step=0.1)
    t = run(path, h, 50, [2.0]).time
    np.testing.assert_allclose(run(path, h, 50, [2.0])["f.x"], 3 - t + t**2, rtol=0, atol=1e-11)
    again = run(path, h, 50, [2.0], {"x": 0.0, "v": 5.0})
    np.testing.assert_allclose(again["f.x"], 5 * t + t**2, rtol=0, atol=1e-11)


@pytest.mark.parametrize(("dt", "fmi"), [(0.0, 2), (0.1, 3)])
def test_transfer_functions_of_many_inputs_and_outputs(dt, fmi, tmp_path):
    """Each response is that of the single transfer function; none of them needs slycot."""
    poles = [-1.0, -5.0, -2.0] if dt == 0 else [0.9, 0.5, -0.3]
    first, second, third = ([1.0, -p] for p in poles)
    sampled = [dt] if dt else []
    system = control.tf(
        [[[1.0], [2.0, 1.0]], [[3.0], [0.0]], [[1.0, 1.0], [4.0]]],
        [[first, np.polymul(first, second)], [first, [1.0]], [third, third]],
        *sampled,
        inputs=["force", "torque"],
        outputs=["x", "phi", "i"],
    )
    path = models.export_lti(system, tmp_path, fmi=fmi)
    for k in range(2):
        inputs = [float(j == k) for j in range(2)]
        result = run(path, 0.1, 40, inputs)
        for i, name in enumerate(["x", "phi", "i"]):
            single = control.tf(system.num[i][k], system.den[i][k], *sampled)
            expected = control.step_response(single, result.time).outputs
            np.testing.assert_allclose(result[f"f.{name}"], expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("ratio", "fmi"), [(1.0, 2), (0.25, 3), (3.0, 2)])
def test_discrete_systems_sample_at_their_own_period(ratio, fmi, tmp_path):
    """Held, an output with direct gain shows the last sample taken, any other the one due."""
    system = control.ss(
        [[0.9, 0.2], [-0.1, 0.7]], [[0.3], [1.0]], [[1, 0.5], [0, 1]], [[2.0], [0.0]], 0.01
    )
    path = models.export_lti(system, tmp_path, fmi=fmi, x0=[1.0, -2.0], held=True)
    n = 60
    u = np.sin(0.3 * np.arange(n + 1))
    result = run(path, 0.01 * ratio, n, [u])
    samples = np.arange(round(n * ratio) + 1)
    met = u[np.floor(samples / ratio + 1e-9).astype(int)]  # within a step its input holds
    direct, delayed = control.forced_response(system, samples * 0.01, met, [1.0, -2.0]).outputs
    now = np.arange(n + 1) * ratio
    last = np.maximum(np.ceil(now - 1e-9).astype(int) - 1, 0)
    np.testing.assert_allclose(result["f.y[0]"], direct[last], rtol=0, atol=1e-12)
    due = np.floor(now + 1e-9).astype(int)
    np.testing.assert_allclose(result["f.y[1]"], delayed[due], rtol=0, atol=1e-12)


@each_version
def test_names_and_units_are_kept(fmi, tmp_path):
    system = control.ss(
        -np.eye(2), np.eye(2), np.eye(2), 0, name="motor",
        inputs=["voltage", "load torque"], outputs=["speed", "i"], states=["w", "flux.d"],
    )  # fmt: skip
    units = {"voltage": "mV", "speed": "rpm", "i": "A", "w": "rad/s", "flux.d": "furlong"}
    path = models.export_lti(system, tmp_path, units=units, fmi=fmi)
    assert path == tmp_path / "motor.fmu"
    fmu = cosim.Fmu(path)
    found = {v.name: (v.causality, v.unit) for v in fmu.variables.values()}
    found.pop("time", None)
    assert found == {
        "voltage": ("input", "mV"),
        "load torque": ("input", None),
        "speed": ("output", "rpm"),
        "i": ("output", "A"),
        "w": ("local", "rad/s"),
        "flux.d": ("local", "furlong"),
        "der(w)": ("local", "rad/s/s"),
        "der(flux.d)": ("local", "furlong/s"),
    }
    assert fmu.units["rad/s/s"].exponents[-1] == 1
    assert fmu.units["mV"].factor == pytest.approx(1e-3)
    assert fmu.units["rpm"].factor == pytest.approx(2 * math.pi / 60)
    assert fmu.units["rpm"].exponents == fmu.units["rad/s"].exponents
    assert fmu.units["furlong"].exponents is None


def test_the_longest_name_is_kept(tmp_path):
    name = 255 * "y"
    path = models.export_lti(control.ss(-1, 1, 1, 0, outputs=name), tmp_path)
    assert cosim.Fmu(path).variables[name].causality == "output"


def test_model_exchange_follows_python_control(tmp_path):
    """Integrated by FMPy's solver, within its tolerance."""
    system = many_modes(10)
    path = models.export_lti(system, tmp_path, fmi=3)
    how = {"fmi_type": "ModelExchange", "relative_tolerance": 1e-9}
    result = by_fmpy(path, 0.01, 3.0, "y[0]", start_values={"u[0]": 1.0}, **how)
    expected = control.step_response(system, result["time"]).outputs
    np.testing.assert_allclose(result["y[0]"], expected, rtol=0, atol=1e-5 * np.ptp(expected))
    assert np.ptp(expected) > 1.0


def test_gains_and_autonomous_systems(tmp_path):
    gain = models.export_lti(control.ss([], [], [], [[1.0, 2.0]]), tmp_path, name="gain")
    assert run(gain, 0.1, 3, [1.0, 3.0])["f.y[0]"].tolist() == [7.0] * 4
    free = models.LinearSystem(
        "free", np.array([[-1.0]]), np.zeros((1, 0)), np.array([[2.0]]), np.zeros((1, 0)), 0.0,
        {}, {"y": None}, {"x": None}, np.array([3.0]),
    )  # fmt: skip
    result = run(models.export_lti(free, tmp_path), 0.3, 4, [])
    np.testing.assert_allclose(result["f.y"], 6 * np.exp(-result.time), rtol=1e-14)


@each_version
def test_direct_gains_alone_are_feedthrough(fmi, tmp_path):
    system = control.ss(-1, [[1, 1]], [[1], [1]], [[0, 2.0], [0, 0]], inputs=["a", "b"])
    fmu = cosim.Fmu(models.export_lti(system, tmp_path, fmi=fmi))
    assert fmu.feedthrough == {"y[0]": {"b"}, "y[1]": frozenset()}
    outputs = fmpy.read_model_description(fmu.folder).outputs
    found = [
        {known.name: kind for known, kind in zip(o.dependencies, o.dependenciesKind, strict=True)}
        for o in outputs
    ]
    assert found == [{"b": "constant", "x[0]": "constant"}, {"x[0]": "constant"}]


@pytest.mark.parametrize(
    ("system", "options", "said"),
    [
        (control.tf([1, 0, 0], [1, 1]), {}, "from input 1 to output 1 is improper"),
        (control.tf([1], [1, 0.5], True), {}, "sample period is not given"),
        (control.frd([1.0], [1.0]), {}, "FrequencyResponseData is no linear system"),
        (control.ss(-1, 1, 1, 0), {"units": {"w": "N"}}, "has no variable 'w'"),
        (control.ss(-1, 1, 1, 0), {"x0": [1, 2]}, "x0 is (2,), expected (1,)"),
        (control.ss(-1, np.inf, 1, 0), {}, "B holds a number that is not finite"),
        (control.ss(-1, 1, 1, 0), {"name": "a b"}, "'a b' cannot name an FMU"),
        (control.ss(-1, 1, 1, 0), {"step": 0.0}, "step is 0.0 s"),
        (control.ss(-1, 1, 1, 0, inputs="y", outputs="y"), {}, "'y' cannot name a variable"),
        (control.ss(-1, 1, 1, 0, inputs=256 * "u"), {}, "256 characters, expected at most 255"),
        (many_modes(130), {}, "130 states, at most 128"),
    ],
)
def test_what_cannot_be_an_fmu_is_told(system, options, said, tmp_path):
    with pytest.raises(models.LtiError) as error:
        models.export_lti(system, tmp_path, **options)
    assert said in str(error.value)
    assert not list(tmp_path.iterdir())
