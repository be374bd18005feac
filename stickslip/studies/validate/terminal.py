"""A learned drive against another log, on a terminal."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.evaluation.tracking import FEEDFORWARD, NONE
from stickslip.studies.learn.terminal import tracking_figure
from stickslip.studies.validate.compared_logs import LogComparison, sentences
from stickslip.studies.validate.log_prediction import LogPrediction
from stickslip.studies.validate.log_verdict import SIGNALS, verdict


def print_prediction(found: LogPrediction, values: Mapping[str, float]) -> None:
    """Print the verdict on another log of a learned drive, and its errors."""
    first, *reasons = verdict(found, values)
    print(f"\nverdict: {first}")
    print(*(f"  {reason}" for reason in reasons), sep="\n")
    print("\nrecorded less predicted, RMS in SI units")
    print(f"{'':24} {'error':>10} {'noise':>10} {'intervals':>10} {'relative':>10} {'ratio':>7}")
    for name, one in found.signals.items():
        sizes = "".join(f"{x:11.3g}" for x in (one.error, one.noise, one.intervals))
        print(f"{SIGNALS[name]:24}{sizes} {100.0 * one.relative:8.3g} % {one.ratio:7.2g}")


def print_comparison(found: LogComparison, *, rotary: bool = False) -> None:
    """Print tracking errors without and with the compensator, measured and simulated."""
    print(*sentences(found), sep="\n")
    n = int(found.part.max()) + 1
    print(f"\n{'':24} {'':8}  without     with  reduction   95 % interval, {n} parts")
    for kind, one in (("measured", found.measured), ("simulated", found.simulated)):
        if one is None:
            continue
        for key, reduction in one.reductions.items():
            factor, unit, title = tracking_figure(key, rotary=rotary)
            sizes = (one.errors[name].items()[key] for name in (NONE, FEEDFORWARD))
            cells = "".join(f"{factor * size:9.3g}" for size in sizes)
            ends = f"[{100.0 * reduction.low:.3g} %, {100.0 * reduction.high:.3g} %]"
            print(f"{kind:10} {title:13} {unit:8}{cells} {100.0 * reduction.value:8.1f} %   {ends}")
