"""Errors of the true velocity with feedforward, disturbance observer and both, on many drives.

    python -m campaigns.observer_errors              # errors on drives, below
    python -m campaigns.observer_errors --loops 100  # designs for loops at random

The trapezoid of Table 4 and its windows, in the loop of the reproduction. The feedforward is LuGre
friction with the exact parameters of Table 2, on every drive; the observer is designed for the
nominal axis and Coulomb friction. Rows: drive; columns: E_max and E_rms after the start and after
the reversal in mm/s, without compensation, with feedforward, observer, and both.
"""

import argparse
from collections.abc import Iterator, Mapping

import numpy as np

from stickslip.catalog.parameters import PAPER, friction_law
from stickslip.evaluation.motions import VALIDATION, regions_after, trapezoid, windows
from stickslip.evaluation.validation import tracking_errors
from stickslip.rigs.fmu import rig_of
from stickslip.servo.axis import LOOP, Axis, ControlError, Datasheet
from stickslip.servo.observer import design_observer
from stickslip.servo.sensitivity import peak_sensitivity
from stickslip.servo.systems import Changes, Compensator, build_loop
from stickslip.servo.velocity_loop import LoopSpecification, design_velocity_loop

LUGRE = {name: PAPER[name] for name in ("F_s", "F_c", "v_s", "sigma_0", "sigma_1")}


def drives() -> Iterator[tuple[str, Changes]]:
    """Yield names and changes of the simulated drive."""
    law = friction_law()
    for share in (1.0, 0.5, 1.5):
        yield f"friction x {share:g}", law.share(LUGRE, share)
    yield "F_s = F_c", {**LUGRE, "F_s": LUGRE["F_c"]}
    for other in ("dahl", "gms", "coulomb_stribeck"):
        known = friction_law(other).parameters
        yield other, {"law": other} | {k: v for k, v in LUGRE.items() if k in known}
    yield "+-15 % along the guide", {"position_dependent": True, "position_amplitude": 0.15}
    yield "mass x 0.8", {"m": 0.8 * PAPER["m"]}
    yield "mass x 1.2", {"m": 1.2 * PAPER["m"]}
    yield "encoder of 2 um", {"encoder_step": 2e-6}
    yield "noise on", {"noise": True}


def errors(changes: Changes, chains: Mapping[str, list[Compensator]]) -> dict[str, list[float]]:
    """Return E_max and E_rms after start and reversal [m/s] by chain of compensators."""
    sheet = Datasheet()
    loop = design_velocity_loop(sheet.axis(PAPER["m"], PAPER["b"]), LOOP)
    found = {}
    with rig_of(changes) as rig:
        v_cmd = VALIDATION.sample(rig.samples(trapezoid(VALIDATION).duration))
        stop = (len(v_cmd) - 1) * LOOP.T_s
        for name, chain in chains.items():
            system = build_loop(rig.fmus, loop, chain)
            with system.prepare(step=LOOP.T_s, stop=stop, record=("drive.v",)) as simulation:
                result = simulation.run(inputs=loop.commands(v_cmd))
            error = v_cmd - result["drive.v"]
            found[name] = [
                value
                for spans in regions_after(windows(VALIDATION)).values()
                for value in tracking_errors(result.time, error, spans).values()
            ]
    return found


def design_at_random(count: int) -> None:
    """Design observers for loops of linear and rotary axes, and print what comes out."""
    rng = np.random.default_rng(0)

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    ratios, whole, peaks, refused = [], [], [], []
    for _ in range(count):
        rotary = rng.random() < 0.25
        m = between(1e-5, 0.1) if rotary else between(0.5, 100.0)
        step = 2 * np.pi / between(4e3, 3e7) if rotary else between(1e-9, 5e-6)
        friction = m * (between(10.0, 1000.0) if rotary else between(0.02, 3.0))
        T_s, tau_i = between(1e-4, 2e-3), float(rng.choice([0.0, between(5e-5, 2e-3)]))
        axis = Axis(m, m * between(1e-3, 5.0), tau_i)
        bandwidth = rng.uniform(0.005, 0.08) / (T_s + tau_i)
        try:
            requirements = LoopSpecification(bandwidth, rng.uniform(40.0, 70.0), T_s)
            loop = design_velocity_loop(axis, requirements)
        except ControlError:
            continue  # no PI controller is so fast
        try:
            designed = design_observer(loop, step, friction)
        except ControlError as error:
            refused.append(f"{m:.3g} kg, T_s {T_s:.2g} s, step {step:.2g}: {error}")
            continue
        ratios.append(designed.reversal / designed.reversal_without)
        whole.append(designed.error / designed.error_without)
        shares = (0.9, 0.95, 1.0, 1.05, 1.1)
        peaks.append(max(peak_sensitivity(loop, designed.observer, k * m) for k in shares))
    for what, values in (("reversals", ratios), ("reversals and noise", whole)):
        low, median, high = np.quantile(values, [0.0, 0.5, 1.0])
        print(f"error of {what} relative to none: {low:.3f} to {high:.3f}, median {median:.3f}")
    print(f"observers: {len(ratios)}")
    print(f"peak sensitivity at 0.9 to 1.1 times the mass: at most {max(peaks):.4g}")
    print(f"refused: {len(refused)}", *refused, sep="\n")


def main() -> None:
    """Print a row for each drive, or what comes out of loops at random."""
    parser = argparse.ArgumentParser(description="Errors with a disturbance observer")
    parser.add_argument("--loops", type=int, help="number of loops at random")
    count = parser.parse_args().loops
    if count is not None:
        design_at_random(count)
        return
    sheet = Datasheet()
    loop = design_velocity_loop(sheet.axis(PAPER["m"], PAPER["b"]), LOOP)
    designed = design_observer(loop, sheet.encoder_step, PAPER["F_c"])
    gains = designed.observer.filter
    print(
        f"L_x = {gains.L_x:.4g}, L_v = {gains.L_v:.4g} /s, L_d = {gains.L_d:.4g} N/m; peak "
        f"sensitivity for a mass off by 10 %: {designed.sensitivity:.3g}, without "
        f"{designed.without:.3g}"
    )
    feedforward = Compensator("compensator", "compensator", LUGRE)
    observer = Compensator("observer", "dob", designed.observer.parameters())
    chains = {
        "none": [],
        "feedforward": [feedforward],
        "observer": [observer],
        "both": [feedforward, observer],
    }
    print(f"{'drive':24}" + "".join(f"{name:^24}" for name in chains))
    for name, changes in drives():
        cells = errors(changes, chains).values()
        print(f"{name:24}" + " ".join(" ".join(f"{1e3 * e:5.2f}" for e in one) for one in cells))
        if not all(np.isfinite(one).all() for one in cells):
            raise SystemExit(f"{name}: an error is not finite")


if __name__ == "__main__":
    main()
