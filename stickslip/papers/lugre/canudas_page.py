"""Figures 2 to 8 of Canudas de Wit et al. 1995 in one, drawn from runs of the FMUs."""

from __future__ import annotations

import io

import numpy as np
from matplotlib.figure import Figure

from stickslip.papers.lugre import canudas_1995 as published
from stickslip.papers.lugre.phenomena import Contact, contact_of
from stickslip.presentation import style

_SHADES = (style.GREY, style.WITHOUT, style.WITH)


def draw_published() -> bytes:
    """Run the experiments and return their picture (PNG); each panel names its figure."""
    stream = io.BytesIO()
    with style.house_style():
        _figure().savefig(stream, format="png", dpi=150, metadata={"Software": None})
    return stream.getvalue()


def _figure() -> Figure:
    figure = style.new_figure(style.PAGE, 165.0)
    panels = figure.subplots(3, 2)
    titles = ("Fig. 2: presliding", "Fig. 3: frictional lag", "Fig. 4: break-away")
    more = ("Fig. 5: stick-slip, position", "Fig. 6: stick-slip", "Figs. 7 and 8: hunting")
    for axes, letter, title in zip(panels.flat, "abcdef", (*titles, *more), strict=True):
        style.name_panel(axes, letter, title)
    with contact_of("lugre", **published.PARAMETERS) as contact:
        _draw_laws(panels, contact)
        _draw_loops(panels, contact)
    return figure


def _draw_laws(panels: np.ndarray, contact: Contact) -> None:
    (slow, late), (ramp, _), _ = panels
    _, force, x = published.presliding(contact)
    slow.plot(1e6 * x, force, color=style.WITH)
    slow.set(xlabel=r"Displacement [$\mu$m]", ylabel="Force [N]")
    for omega, colour in zip(published.FREQUENCIES, _SHADES, strict=True):
        v, friction = published.lag(contact, omega)
        late.plot(1e3 * v, friction, color=colour, label=f"{omega:g} rad/s")
    late.set(xlabel="Velocity [mm/s]", ylabel="Friction [N]")
    late.legend()
    largest = [published.break_away(contact, rate) for rate in published.RATES]
    ramp.plot(published.RATES, largest, "o-", color=style.WITH)
    ramp.set(xlabel="Rate of the force [N/s]", ylabel="Break-away force [N]")


def _draw_loops(panels: np.ndarray, contact: Contact) -> None:
    (_, position), (both, hunts) = panels[1], panels[2]
    pulled = published.stick_slip(contact)
    position.plot(pulled["time"], pulled["x"], color=style.WITH, label="mass")
    position.plot(
        pulled["time"],
        0.1 * pulled["time"],
        color=style.INK,
        ls=style.DASHED,
        label="end of spring",
    )
    position.set(xlabel="Time [s]", ylabel="Position [m]")
    position.legend()
    both.plot(pulled["time"], pulled["F_f"], color=style.WITHOUT, label="friction [N]")
    both.plot(pulled["time"], pulled["v"], color=style.WITH, label="velocity [m/s]")
    both.set(xlabel="Time [s]", ylabel="Friction, velocity", ylim=(-0.1, 1.95))
    both.legend(ncols=2, loc="upper right")
    held = published.hunting(contact)
    hunts.plot(held["time"], held["F_f"], color=style.WITHOUT, lw=style.THIN, label="friction [N]")
    hunts.plot(held["time"], held["x"], color=style.WITH, label="position [m]")
    hunts.set(xlabel="Time [s]", ylabel="Friction, position", ylim=(-1.6, 2.3))
    hunts.legend(ncols=2, loc="upper right")
