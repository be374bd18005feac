"""FMUs as systems of python-control, and states that cannot be set, which are refused."""

import re

import control
import numpy as np
import pytest

from stickslip import cosim, models
from stickslip.cosim.control import LinearisationError, linearise
from tests.cosim.single import members, repacked

POINT = {"states": {"v": -2e-3, "z": 4e-6}, "inputs": {"u": 2.0}}
PARAMETERS = {"m": 5.0, "b": 7.0, "F_c": 6.0, "F_s": 9.0, "v_s": 2e-3, "delta": 2.0}
PARAMETERS |= {"sigma_0": 4e5, "sigma_1": 4e3, "v_d": 0.0}


def without_derivatives(path):
    """Let a description not say that the FMU gives directional derivatives."""
    flag = re.compile(rb'providesDirectionalDerivatives?="true"')
    return repacked(path, path, lambda _, data: flag.sub(b"", data))


def test_differences_give_what_derivatives_give(version, tmp_path):
    path = models.build_fmu("stage", tmp_path, fmi=version)
    expected = linearise(path, **POINT, parameters=PARAMETERS)
    found = linearise(without_derivatives(path), **POINT, parameters=PARAMETERS)
    for name in "ABCD":
        wanted = getattr(expected, name)
        np.testing.assert_allclose(getattr(found, name), wanted, rtol=1e-6, atol=1e-6)
    assert found.dt == 0
    assert found.state_labels == ["x", "v", "z"]
    assert (found.input_labels, found.output_labels) == (["u"], ["x", "v", "F_f"])
    chosen = linearise(path, **POINT, parameters=PARAMETERS, outputs=["F_f"])
    assert chosen.output_labels == ["F_f"]
    np.testing.assert_array_equal(chosen.C, found.C[2:])


def random_system(dt: float) -> control.StateSpace:
    control_system = control.rss(5, 3, 2) if not dt else control.drss(5, 3, 2)
    return control.ss(
        control_system.A, control_system.B, control_system.C, np.arange(6.0).reshape(3, 2), dt,
        inputs=["F", "M"], outputs=["x", "v", "phi"], states=list("abcde"), name="plant",
    )  # fmt: skip


@pytest.mark.parametrize(("dt", "step"), [(0.0, None), (0.0, 0.02), (0.02, 0.02)])
def test_a_linear_system_comes_back(dt, step, version, tmp_path):
    """lti -> FMU -> lti. A held input makes of the continuous one what python-control samples."""
    np.random.seed(7)  # noqa: NPY002 - python-control draws from it
    system = random_system(dt)
    path = models.export_lti(system, tmp_path, fmi=version)
    back = linearise(path, step=step)
    expected = system if dt == (step or 0.0) else control.sample_system(system, step, method="zoh")
    off = 1e-9 if step else 0.0
    for name in "ABCD":
        np.testing.assert_allclose(getattr(back, name), getattr(expected, name), rtol=0, atol=off)
    assert back.dt == (step or 0.0)
    for labels in ("state_labels", "input_labels", "output_labels"):
        assert getattr(back, labels) == getattr(system, labels)


def test_a_loop_of_fmus_is_the_closed_loop(tmp_path):
    plant = control.ss([[0.9, 0.1], [0, 0.8]], [[0], [0.1]], [[1, 0]], 0, 0.01, name="plant")
    pi = control.ss(
        1, [[0.2, -0.2]], 1, [[0.6, -0.6]], 0.01, name="pi", inputs=["r", "y"], outputs=["u"]
    )
    system = cosim.System()
    for part in (plant, pi):
        system.add(part.name, models.export_lti(part, tmp_path, held=True))
    system.connect("pi.u", "plant.u[0]")
    system.connect("plant.y[0]", "pi.y")
    system.expose("r", "pi.r")
    found = linearise(system, step=0.01, outputs=["plant.y[0]"])
    closed = control.feedback(plant * control.ss(1, 0.2, 1, 0.6, 0.01), 1)
    np.testing.assert_allclose(
        np.sort_complex(found.poles()), np.sort_complex(closed.poles()), rtol=0, atol=1e-8
    )
    f = np.geomspace(0.1, 300, 20)
    np.testing.assert_allclose(found(np.exp(0.01j * f)), closed(np.exp(0.01j * f)), atol=1e-7)
    assert found.state_labels == ["plant_x[0]", "plant_x[1]", "pi_x[0]"]


def test_the_stage_at_rest_is_held_by_its_bristles(version, tmp_path):
    """A spring sigma_0 and a damper sigma_1, by the derivatives that the FMU gives."""
    m, b, sigma_0, sigma_1 = 5.557, 6.6135, 3.9162e5, 4.4248e3
    found = linearise(models.build_fmu("stage", tmp_path, fmi=version))
    A = [[0, 1, 0], [0, -(b + sigma_1) / m, -sigma_0 / m], [0, 1, 0]]
    np.testing.assert_allclose(found.A, A, rtol=1e-14)
    np.testing.assert_allclose(found.B, [[0], [1 / m], [0]], rtol=1e-14)
    F_f = found.output_labels.index("F_f")
    np.testing.assert_allclose(found.C[F_f], [0, sigma_1, sigma_0], rtol=1e-14)


def test_memory_beside_the_states_is_found(fmus, tmp_path):
    """A sampled controller counts; the compensator remembers the velocity before."""
    compensator = models.build_fmu("compensator", tmp_path)
    with pytest.raises(LinearisationError, match="remembers more than its states"):
        linearise(compensator, step=1e-3, inputs={"v": 1e-3}, parameters={"hold": False})
    sampled = models.export_lti(control.ss(0.5, 1, 1, 0, 0.02), tmp_path, name="sampled")
    with pytest.raises(LinearisationError, match="counts time"):
        linearise(sampled, step=0.01)
    with pytest.raises(LinearisationError, match="has no states that can be set"):
        linearise(fmus / "nominal_loop.fmu", step=5e-4)


def test_wrong_names_are_told(tmp_path):
    path = models.build_fmu("stage", tmp_path)
    for options, message in (
        ({"states": {"zz": 1.0}}, "no state 'zz'; did you mean 'z'"),
        ({"inputs": {"F": 1.0}}, "no input 'F'"),
        ({"outputs": ["y"]}, "no output 'y'"),
        ({"parameters": {"g": 1.0}}, "has no variable 'g'"),
    ):
        with pytest.raises(LinearisationError) as error:
            linearise(path, **options)
        assert message in str(error.value)
    with pytest.raises(LinearisationError, match=r"give step="):
        linearise(models.export_lti(control.ss(0.5, 1, 1, 0, 0.1), tmp_path, name="lag"))


@pytest.mark.parametrize("step", [None, 0.02])
def test_in_a_process_of_its_own_it_is_the_same_bit_for_bit(step, tmp_path):
    path = models.export_lti(random_system(0.0), tmp_path)
    here, there = (linearise(path, step=step, isolation=i) for i in (None, "process"))
    for name in "ABCD":
        np.testing.assert_array_equal(getattr(there, name), getattr(here, name))
    with pytest.raises(LinearisationError, match="no output 'z'"):
        linearise(path, step=step, outputs=["z"], isolation="process")


# x' = A x + [1 0]' u, y = C x; the second state is hidden
PLANTS = {
    "two lags in a row": ([[-1, 0], [1, -5]], [0, 1]),
    "a lag that both outputs see": ([[-1, 0.5], [1, -5]], [1, 0]),
    "an oscillator": ([[0, 1], [-25, -0.5]], [1, 0]),
    "a slow lag beside a fast one": ([[-20, 0], [0.1, -0.1]], [1, 1]),
    "a fast lag": ([[-1, 0], [1000, -1000]], [0, 1]),
}
each_plant = pytest.mark.parametrize(
    ("plant", "version"), [(plant, 2 + k % 2) for k, plant in enumerate(PLANTS)]
)
STEP = 1e-3


def lti(plant, folder, version, name="plant"):
    A, C = PLANTS[plant]
    system = control.ss(A, [[1], [0]], [C], 0, name=name, inputs=["u"], outputs=["y"])
    return models.export_lti(system, folder, fmi=version)


def hide(path, *states, listed=False, exchange=False):
    """Rewrite an FMU: states without a start value and, unless listed, with no derivative."""
    text = members(path)["modelDescription.xml"].decode()
    for state in states:
        name = re.escape(f'name="{state}"')
        text = re.sub(rf'({name}[^>]*)initial="exact"([^>]*?)( start="[^"]*")?( ?/?>)',
                      r'\1initial="calculated"\2\4', text)  # fmt: skip
        text = re.sub(rf'({name}[^>]*>\s*<Real) start="[^"]*"', r"\1", text)
    if not listed:
        text = re.sub(r' derivative="\d+"', "", text)
        text = re.sub(r"<Derivatives>.*?</Derivatives>", "", text, flags=re.S)
        text = re.sub(r"<ContinuousStateDerivative[^>]*/>", "", text)
        text = re.sub(r"<InitialUnknowns>.*?</InitialUnknowns>", "", text, flags=re.S)
        text = re.sub(r"<InitialUnknown[^>]*/>", "", text)
    if not exchange:
        text = re.sub(r"<ModelExchange[^>]*/>", "", text)
        text = re.sub(r"<ModelExchange.*?</ModelExchange>", "", text, flags=re.S)
    new = text.encode()
    return repacked(path, path, lambda name, data: new if name == "modelDescription.xml" else data)


@each_plant
def test_nothing_hidden_nothing_refused(plant, version, tmp_path):
    """Also of Co-Simulation alone, whether it lists its derivatives or not."""
    for listed in (True, False):
        path = hide(lti(plant, tmp_path, version), listed=listed)
        found = linearise(path, step=STEP)
        A, _ = PLANTS[plant]
        expected = np.exp(np.linalg.eigvals(np.array(A, float)) * STEP)
        np.testing.assert_allclose(
            np.sort_complex(found.poles()), np.sort_complex(expected), atol=1e-8
        )


@each_plant
@pytest.mark.parametrize("listed", [True, False])
def test_a_state_that_cannot_be_set_or_is_not_declared(plant, listed, version, tmp_path):
    said = r"fmu \(plant\.fmu\): a step cannot start from a given value of x\[1\]"
    words = said + ".*export it for Model Exchange" if listed else "remembers more than "
    path = hide(lti(plant, tmp_path, version), "x[1]", listed=listed)
    with pytest.raises(LinearisationError, match=f"{words}.*measure_response"):
        linearise(path, step=STEP)


def test_model_exchange_is_advised_where_there_is_one(version, tmp_path):
    path = hide(lti("an oscillator", tmp_path, version), "x[1]", listed=True, exchange=True)
    with pytest.raises(LinearisationError, match="its Model Exchange by leaving out step="):
        linearise(path, step=STEP)
    assert len(linearise(path).poles()) == 2


@each_plant
@pytest.mark.parametrize("listed", [True, False])
def test_one_of_a_system_hides_its_states(plant, listed, version, tmp_path):
    """Its neighbour's can be set, and would be all that is found."""
    system = cosim.System("loop")
    system.add("open", lti("a fast lag", tmp_path, version, "open"))
    hidden = hide(lti(plant, tmp_path, version, "hidden"), "x[0]", "x[1]", listed=listed)
    system.add("hidden", hidden)
    system.connect("open.y", "hidden.u")
    system.connect("hidden.y", "open.u")
    words = r"hidden \(hidden\.fmu\): .* x\[0\], x\[1\]," if listed else "loop remembers more than"
    with pytest.raises(LinearisationError, match=words):
        linearise(system, step=STEP)
