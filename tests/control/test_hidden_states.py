"""A state that cannot be set is refused, whether it is declared or not: a pole would be missing."""

from __future__ import annotations

import re
import zipfile

import control
import numpy as np
import pytest

from stickslip import cosim, models
from stickslip.cosim.control import LinearisationError, linearise, nonlinear_system

# x' = A x + [1 0]' u, y = C x; the second state is hidden
PLANTS = {
    "two lags in a row": ([[-1, 0], [1, -5]], [0, 1]),
    "a lag that both outputs see": ([[-1, 0.5], [1, -5]], [1, 0]),
    "an oscillator": ([[0, 1], [-25, -0.5]], [1, 0]),
    "a slow lag beside a fast one": ([[-20, 0], [0.1, -0.1]], [1, 1]),
    "a fast lag": ([[-1, 0], [1000, -1000]], [0, 1]),
}
STEP = 1e-3


@pytest.fixture(params=[2, 3], ids=["FMI 2.0", "FMI 3.0"])
def version(request):
    return request.param


def lti(plant, folder, version, name="plant"):
    A, C = PLANTS[plant]
    system = control.ss(A, [[1], [0]], [C], 0, name=name, inputs=["u"], outputs=["y"])
    return models.export_lti(system, folder, fmi=version)


def hide(path, *states, listed=False, exchange=False):
    """Rewrite an FMU: states without a start value and, unless listed, with no derivative."""
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    text = members["modelDescription.xml"].decode()
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
    members["modelDescription.xml"] = text.encode()
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return path


@pytest.mark.parametrize("plant", PLANTS)
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


@pytest.mark.parametrize("plant", PLANTS)
def test_a_declared_state_that_cannot_be_set(plant, version, tmp_path):
    path = hide(lti(plant, tmp_path, version), "x[1]", listed=True)
    for function in (linearise, nonlinear_system):
        with pytest.raises(LinearisationError) as error:
            function(path, step=STEP)
        assert "fmu (plant.fmu): a step cannot start from a given value of x[1]" in str(error.value)
        assert "export it for Model Exchange" in str(error.value)
        assert "measure_response" in str(error.value)


def test_model_exchange_is_advised_where_there_is_one(version, tmp_path):
    path = hide(lti("an oscillator", tmp_path, version), "x[1]", listed=True, exchange=True)
    with pytest.raises(LinearisationError, match="its Model Exchange by leaving out step="):
        linearise(path, step=STEP)
    assert len(linearise(path).poles()) == 2


@pytest.mark.parametrize("plant", PLANTS)
def test_a_state_that_is_not_declared(plant, version, tmp_path):
    path = hide(lti(plant, tmp_path, version), "x[1]")
    with pytest.raises(LinearisationError, match=r"remembers more than .*\.measure_response"):
        linearise(path, step=STEP)


@pytest.mark.parametrize("plant", PLANTS)
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


def test_components_without_states_are_no_obstacle(version, tmp_path):
    system = cosim.System("loop")
    system.add("plant", hide(lti("an oscillator", tmp_path, version)))
    gain = control.ss([], [], [], [[-3.0]], name="gain", inputs=["e"], outputs=["u"])
    system.add("gain", hide(models.export_lti(gain, tmp_path, fmi=version)))
    system.connect("gain.u", "plant.u")
    system.expose("e", "gain.e")
    assert len(linearise(system, step=STEP).poles()) == 2
