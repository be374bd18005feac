"""The force that a motor holds at a position, found beside friction, on motions simulated here."""

from dataclasses import replace

import numpy as np
import pytest

from campaigns.sound_drives import simulator
from stickslip import cosim
from stickslip.catalog.parameters import PAPER
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.identification.criteria.motion import Scale
from stickslip.identification.criteria.runs import candidate_fmus
from stickslip.identification.estimation import Estimation, LearnSettings
from stickslip.identification.sliding.position_force import (
    PositionForce,
    block_parameters,
    find_position_force,
    friction_factor,
    varying,
)
from stickslip.learned.file import LearnedFile
from stickslip.logs import Recording
from stickslip.servo.axis import ControlError
from stickslip.studies.learn.folder import write_learned
from stickslip.studies.learn.learned import learn_recording
from stickslip.trial.compensator_trial import Loops

T_S = 5e-4
M, B, F_C = 3.0, 20.0, 4.0
STEP = 4e-7
T = np.arange(40_000) * T_S
COGGING = {"pitch": 0.0083, "cogging_s[1]": 1.1, "cogging_c[1]": -0.6, "cogging_s[2]": 0.4}
"""Of F_c, as far as it is a force."""


def log(x: np.ndarray, force: np.ndarray, seed: int = 0, motion: str = "linear") -> Recording:
    """Return a recording of a motion and a force, with steps and noise."""
    rng = np.random.default_rng(seed)
    shown = STEP * np.round((x + 1e-7 * rng.standard_normal(len(x))) / STEP)
    noisy = force + 0.05 * rng.standard_normal(len(x))
    return Recording(np.arange(len(x)) * T_S, shown, noisy, encoder_step=STEP, motion=motion)


def moved(
    held: dict[str, float], *, guide: float = 0.0, asymmetry: float = 0.0, F_0: float = 0.0
) -> Recording:
    """Return sines whose amplitude and frequency vary, with a force of position in F_c."""
    phase = 2.0 * np.pi * (0.15 * T + 0.5 * (2.0 / 20.0) * T**2)
    x = 0.012 * np.sin(phase) + 0.004 * np.sin(2.0 * np.pi * 0.11 * T)
    v = np.gradient(x, T_S)
    turns = np.where(np.diff(np.sign(v), prepend=0.0), np.arange(len(v)), 0)
    since = np.abs(x - x[np.maximum.accumulate(turns)])  # friction turns over 20 um
    friction = F_C * (1.0 + guide * np.sin(2.0 * np.pi * x / 0.004) + asymmetry * np.sign(v))
    friction *= np.sign(v) * (1.0 - 2.0 * np.exp(-since / 2e-5))
    force = M * np.gradient(v, T_S) + B * v + friction + F_0
    known = varying({n: one * (F_C if n != "pitch" else 1.0) for n, one in held.items()}, x)
    return log(x, force if known is None else force + known)


def holds(found: PositionForce | None, truth: dict[str, float]) -> bool:
    """Return whether the intervals hold what is true, of all that is shown."""
    assert found is not None
    return all(one.low <= truth.get(n, 0.0) <= one.high for n, one in found.terms.items())


@pytest.mark.thorough
def test_cogging_is_found_with_its_pitch_and_its_two_harmonics() -> None:
    found = find_position_force(moved(COGGING, guide=0.05, F_0=0.3))
    truth = {name: one * (F_C if name != "pitch" else 1.0) for name, one in COGGING.items()}
    assert holds(found, truth | {"F_0": 0.3})
    assert set(found.terms) == {"F_0", "cogging_c[2]", *COGGING}
    widths = {name: one.high - one.low for name, one in found.terms.items()}
    assert widths.pop("pitch") < 1e-3 * COGGING["pitch"]
    assert max(widths.values()) < 0.05 * F_C


@pytest.mark.parametrize(
    "imperfection", [{}, {"guide": 0.1, "asymmetry": 0.05}, {"F_0": 0.9 * F_C}], ids=str
)
def test_friction_that_varies_along_the_guide_or_by_direction_is_none(imperfection) -> None:
    assert find_position_force(moved({}, **imperfection)) is None


def test_a_weight_that_friction_does_not_hold_is_shown_and_nothing_varies() -> None:
    found = find_position_force(moved({}, F_0=-1.2 * F_C))
    assert set(found.terms) == {"F_0"}
    assert holds(found, {"F_0": -1.2 * F_C})
    assert varying(found.values, np.zeros(3)) is None
    assert block_parameters(found.values)["F_0"] == found.terms["F_0"].value


def swing(mu_g: float = 0.0) -> Recording:
    """Return the log of an arm of another program, whose weight adds to friction."""
    t = np.arange(10_000) * T_S
    command = 1.1 * np.sin(2.0 * np.pi * 0.35 * t) + 0.15 * np.sin(2.0 * np.pi * 1.3 * t)
    arm = {"m": 0.3, "b": 0.4, "F_c": 1.5, "F_s": 1.5, "v_s": 1.0, "mu_g": mu_g, "T_s": T_S}
    arm |= {"F_0": 0.4, "g_s": 6.0, "g_c": -2.5, "K_p": 40.0, "K_x": 7.5}
    found = simulator.run("coulomb_stribeck", arm, np.gradient(command, T_S), x_cmd=command)
    return log(found["x"], found["force"], motion="rotary")


def test_the_weight_of_an_arm_is_found_at_its_angle() -> None:
    found = find_position_force(swing())
    assert set(found.terms) == {"F_0", "g_s", "g_c"}
    assert holds(found, {"F_0": 0.4, "g_s": 6.0, "g_c": -2.5})
    assert found.terms["g_s"].high - found.terms["g_s"].low < 0.3
    x = np.linspace(-1.0, 1.0, 9)
    held = varying(found.values, x)
    np.testing.assert_allclose(held, 6.0 * np.sin(x) - 2.5 * np.cos(x), atol=0.1)


def test_friction_that_grows_with_the_weight_of_the_arm_is_told_from_the_rest() -> None:
    found = find_position_force(swing(mu_g=0.15))
    assert holds(found, {"F_0": 0.4, "g_s": 6.0, "g_c": -2.5, "mu_g": 0.15, "F_c": 1.5})
    assert {"mu_g", "F_c"} < set(found.terms)
    assert found.terms["mu_g"].high - found.terms["mu_g"].low < 0.06
    x = np.linspace(-1.0, 1.0, 9)
    weight = np.abs(6.0 * np.sin(x) - 2.5 * np.cos(x))
    np.testing.assert_allclose(friction_factor(found.values, x), 1.0 + 0.1 * weight, rtol=0.05)


def test_a_weight_does_not_lessen_friction() -> None:
    """The block of the force of position takes no mu_g below 0."""
    found = find_position_force(swing(mu_g=-0.15))
    assert set(found.terms) == {"F_0", "g_s", "g_c"}


VALUES = {**PAPER, "F_0": 0.0, "delay": 1e-7, "delta": 1.0}
GAINS = {"K_p": 3000.0, "K_i": 3e4, "K_x": 30.0, "tau_f": T_S, "T_s": T_S}


def commanded(amplitude: float, frequency: float, n: int) -> Recording:
    """Return a recording of a drive that follows a sine."""
    command = amplitude * np.sin(2.0 * np.pi * frequency * T_S * np.arange(n))
    place = {"velocity_command": np.gradient(command, T_S), "position_command": command}
    return Recording(np.arange(n) * T_S, command, encoder_step=1e-9, **place)


def test_the_drive_and_the_inverse_model_have_the_same_friction_under_a_weight() -> None:
    held = {"g_s": 60.0, "g_c": 20.0, "mu_g": 0.2, "F_c": VALUES["F_c"]}
    recording = commanded(0.4, 0.5, 6000)
    further = {f"candidate.{name}": held[name] for name in ("g_s", "g_c", "mu_g")}
    with candidate_fmus() as fmus:
        with KnownLoop(fmus, recording, GAINS) as loop:
            run = loop.run(VALUES, further)
        x, force = run["candidate.x"], np.append(run["candidate.F_m"][1:], 0.0)
        moved = replace(recording, position=x, force=force, known_force=varying(held, x))
        left = []
        for factor in (friction_factor(held, x), None):
            with InverseModel(fmus, replace(moved, friction_factor=factor)) as model:
                left.append(np.median(np.abs(model.residual(VALUES))))
    assert left[0] < 0.05 * left[1]


def test_what_is_known_is_no_friction_whatever_the_units() -> None:
    """A drive with cogging and known_force leaves what the same drive leaves without it."""
    recording, scale = commanded(0.02, 0.7, 4000), Scale(10.0, 10.0)
    with candidate_fmus() as fmus:
        with KnownLoop(fmus, recording, GAINS) as loop:
            plain = loop.run(VALUES)
        x = plain["candidate.x"]
        held = varying({"cogging_s[1]": 3.0, "cogging_c[2]": 1.0, "pitch": 0.013}, x)
        left, paths = [], []
        for known in (None, held):
            force = np.append(plain["candidate.F_m"][1:], 0.0) + (0.0 if known is None else known)
            own = replace(recording, position=x, force=force, known_force=known)
            with InverseModel(fmus, scale.recording(own)) as model:
                left.append(model.residual(scale.values(VALUES)))
            with KnownLoop(fmus, own, GAINS) as loop:
                again = loop.run(VALUES, feedforward=0.0 if known is None else known)
                paths.append(again["candidate.x"])
    np.testing.assert_allclose(left[1], left[0], atol=1e-9)
    np.testing.assert_allclose(paths[1], paths[0], atol=1e-12)


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.usefixtures("without_pictures")
def test_learn_gives_the_drive_without_it_and_writes_its_block(tmp_path) -> None:
    def design(_: Estimation) -> Loops:
        raise ControlError("there is no loop")

    settings = LearnSettings(law="coulomb_stribeck", criterion="inverse")
    short = moved(COGGING, F_0=1.5 * F_C).part(0, 20_000)
    learned = learn_recording(short, None, design, (), settings)
    known, found = learned.estimation.known, learned.estimation.position_force
    assert known["m"].low <= M <= known["m"].high
    assert known["F_c"].value == pytest.approx(F_C, rel=0.02)
    write_learned(learned, tmp_path)
    again = LearnedFile(tmp_path / "learned.json")
    assert "position_force.fmu" in again.written
    assert again.position_force.values == block_parameters(found.values)
    start = cosim.Fmu(tmp_path / "position_force.fmu").variables
    assert {n: start[n].start for n in found.terms} == found.values
    assert start["cogging_s[3]"].start == 0.0
    assert "Force of position" in (tmp_path / "report.html").read_text(encoding="utf-8")
