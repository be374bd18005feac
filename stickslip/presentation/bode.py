"""A measured frequency response over the designed Bode plot."""

from collections.abc import Mapping
from typing import Any

import control
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator, StrMethodFormatter
from numpy.typing import NDArray

from stickslip.cosim.control import MeasuredResponse
from stickslip.presentation.style import INK, PAGE, THICK, house_style, new_figure

_COLOURS = ("#004f86", "#e07b00", "#3a8f5c", "#8c4a86", "#6f6f6f")
_MARKS = "osD^v"


def draw_bode(
    designed: control.StateSpace,
    measured: Mapping[str, tuple[MeasuredResponse, str]],
    *,
    title: str = "",
    distortion: bool = False,
    label: str = "designed",
) -> Figure:
    """Draw gain [dB] and phase [deg] over frequency [Hz].

    Parameters
    ----------
    designed : what the measurements should show; one input, one output, discrete or continuous
    measured : label -> a measurement and the output of it to show, from its input
    distortion : whether to draw below how much of each output is no fundamental [%]
    label : of what the measurements should show
    """
    f = np.concatenate([m.f for m, _ in measured.values()])
    highest = 0.5 / designed.dt if designed.dt else np.inf
    line = np.geomspace(0.8 * f.min(), min(1.25 * f.max(), highest), 600)
    with house_style():
        figure = new_figure(PAGE, 125.0 if distortion else 95.0)
        axes = figure.subplots(
            2 + distortion, sharex=True, height_ratios=[3, 2, 1.5][: 2 + distortion]
        )
        gain, phase = axes[:2]
        drawn: dict[str, Any] = {"color": INK, "lw": THICK, "zorder": 1}
        _draw(gain, phase, line, _response(designed, line), label=label, **drawn)
        for k, (name, (response, output)) in enumerate(measured.items()):
            look: dict[str, Any] = {"color": _COLOURS[k % 5], "marker": _MARKS[k % 5], "lw": 0.8}
            at = _response(designed, response.f)
            _draw(gain, phase, response.f, response.response(output), near=at, label=name, **look)
            if distortion:
                axes[2].plot(response.f, 100 * response.distortion[output], **look)
        gain.set(xscale="log", ylabel="Gain [dB]", title=title)
        phase.set(ylabel="Phase [deg]")
        phase.yaxis.set_major_locator(MultipleLocator(45))
        if distortion:
            axes[2].set(ylabel="Distortion [%]")
            axes[2].set_ylim(bottom=0.0)
        axes[-1].xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axes[-1].set(xlabel="Frequency [Hz]", xlim=(line[0], line[-1]))
        for one in axes:
            one.grid(visible=True)
        figure.align_ylabels()
        figure.legend(*gain.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _draw(
    gain: Any,
    phase: Any,
    f: NDArray[np.float64],
    response: NDArray[np.complex128],
    near: NDArray[np.complex128] | None = None,
    **look: Any,
) -> None:
    """Draw one response; its phase is that branch which lies near another response's."""
    gain.plot(f, 20 * np.log10(np.abs(response)), **look)
    reference = response if near is None else near
    branch = np.unwrap(np.angle(reference))
    turned = branch if near is None else branch + np.angle(response / reference)
    phase.plot(f, np.degrees(turned), **look)


def _response(system: control.StateSpace, f: NDArray[np.float64]) -> NDArray[np.complex128]:
    s = 2j * np.pi * f
    return np.atleast_1d(np.squeeze(system(np.exp(s * system.dt) if system.dt else s)))
