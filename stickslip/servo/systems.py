"""The paper's loops as systems of FMUs: Fig. 2a around a drive, and what experiments need of it."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from stickslip import cosim, models
from stickslip.fmi.toolchain import PLATFORMS, Platform
from stickslip.servo.velocity_loop import VelocityLoop

Feed = Literal["nominal", "command"]
NOMINAL_ORDER = 8  # states that the nominal-loop FMU has room for
COMPONENTS = ("controller", "drive", "filter", "nominal")
"""Names in a loop beside those of the compensators."""
CONTROL = ("nominal_loop", "velocity_controller", "velocity_filter")
"""Models of a loop beside the drive and the compensators."""

_MEASURED = {
    "x_enc": "{drive}.x_enc",
    "F_motor": "{drive}.F_m",
    "v_est": "controller.v_est",
    "u": "controller.u",
}
"""Where the roles of a compensator's inputs come from."""


@dataclass(frozen=True)
class Compensator:
    """A compensator in a loop.

    Attributes
    ----------
    name : of its component
    model : of ``models.model_names()``, or any name where ``own_ports`` are given
    values : parameters by name; the rest follow from the axis, or are start values
    file : its FMU in the folder of the FMUs, without suffix; by default as the model
    own_ports : how an FMU is connected that is none of the models
    law : friction law of a feedforward, by default LuGre
    """

    name: str
    model: str
    values: Mapping[str, float] = field(default_factory=dict)
    file: str = ""
    own_ports: models.Ports | None = None
    law: str = ""

    @property
    def ports(self) -> models.Ports:
        """How it is connected.

        Raises
        ------
        ValueError
            When the model is not a compensator.
        """
        ports = self.own_ports or models.load_model(self.model).ports
        if ports is None:
            raise ValueError(f"model '{self.model}' is not a compensator")
        return ports

    def parameters(self, loop: VelocityLoop) -> dict[str, float]:
        """Return its values, and those that follow from the axis and the loop."""
        axis = {"T_s": loop.T_s, "tau_f": loop.tau_f}
        axis |= {"m": loop.axis.m, "b": loop.axis.b, "tau_i": loop.axis.tau_i}
        found = {p: axis[v] if isinstance(v, str) else v for p, v in self.ports.axis.items()}
        return {**found, **self.values}


Changes = Mapping[str, float | str]
"""Start values of the drive FMU by name, and ``law``, the name of its friction law."""


def drive_law(changes: Changes) -> tuple[dict[str, float], str]:
    """Return the start values of the drive, and its friction law."""
    values = {name: float(value) for name, value in changes.items() if name != "law"}
    return values, str(changes.get("law", "lugre"))


def build_fmus(
    folder: Path,
    truth: Changes,  # goes into the drive
    law: str = "lugre",  # of the compensator, and of the identification's stage
    only: Iterable[str] | None = None,  # names of models, all by default
    platforms: Iterable[Platform] | None = None,  # what to build for; this machine by default
) -> None:
    """Build the FMUs of the loop into a folder."""
    start, own = drive_law(truth)
    for name in models.model_names() if only is None else only:
        if name == "drive":
            models.build_fmu(name, folder, start=start, law=own, platforms=platforms)
        else:
            of_law = law if name in ("compensator", "stage") else None
            models.build_fmu(name, folder, law=of_law, platforms=platforms)


def for_all_platforms(system: cosim.System, folder: Path, truth: Changes, law: str) -> cosim.System:
    """Return a system with the same FMUs, built into a folder for all platforms."""
    fmus = system.fmus("a loop")
    build_fmus(
        folder, truth, law, {fmu.path.stem for fmu in fmus.values()}, platforms=PLATFORMS.values()
    )
    whole = system.copy()
    whole.components |= {name: cosim.Fmu(folder / fmu.path.name) for name, fmu in fmus.items()}
    return whole


def servo_loop(fmus: Path, loop: VelocityLoop) -> cosim.System:
    """Return controller and drive alone, with the inputs of ``loop.commands``."""
    system = cosim.System("servo")
    _add_servo(system, fmus, loop)
    _expose(system, loop, ["controller"])
    return system


def feedforward(fmus: Path, loop: VelocityLoop, compensator: Mapping[str, float]) -> cosim.System:
    """Return nominal loop and compensator alone, with the inputs of ``loop.commands``."""
    system = cosim.System("feedforward")
    chain = [Compensator("compensator", "compensator", compensator)]
    system.add("nominal", fmus / "nominal_loop.fmu", nominal_parameters(loop))
    _, referenced = _add_chain(system, fmus, loop, chain)
    _follow(system, referenced)
    _expose(system, loop, ["nominal"])
    return system


def paper_loop(
    fmus: Path, loop: VelocityLoop, compensator: Mapping[str, float] | None
) -> cosim.System:
    """Return Fig. 2a: servo loop, compensator, nominal loop, with the inputs of ``loop.commands``.

    Parameters are those of ``feedforward``; a compensator of None runs beside the loop only. A
    velocity filter takes the compensator's force for known friction.
    """
    chain = [Compensator("compensator", "compensator", compensator or {})]
    return build_loop(fmus, loop, chain, connected=compensator is not None)


def build_loop(
    fmus: Path,  # folder of the FMUs
    loop: VelocityLoop,  # controller, nominal loop and axis
    compensators: Sequence[Compensator],  # in the order of their forces; none without
    feed: Feed = "nominal",  # gives the velocity: the nominal loop, or the command
    *,
    connected: bool = True,  # whether the last one's force goes to the loop, or runs beside it only
    drive: str = "drive",  # name of the drive in the loop, and of its FMU
) -> cosim.System:
    """Return a servo loop with any chain of compensators, connected by the roles of their ports.

    Each one adds its force to that of the one before it, if it has an input for it. The last one's
    force goes to the controller and, as known friction, to a velocity filter. Raises ValueError
    when a model is not a compensator, or cannot take the force of the one before it.
    """
    system = cosim.System("loop")
    system.add("nominal", fmus / "nominal_loop.fmu", nominal_parameters(loop))
    force, referenced = _add_chain(system, fmus, loop, compensators)
    if feed == "nominal":
        _follow(system, referenced)
    _add_servo(system, fmus, loop, drive)
    _expose(system, loop, ["controller", "nominal"], referenced if feed == "command" else [])
    for role, place in _measured(compensators):
        system.connect(_MEASURED[role].format(drive=drive), place)
    if force is not None and connected:
        system.connect(force, "controller.F_ff")
        if loop.velocity_filter is not None:
            system.connect(force, "filter.F_ff")
    return system


def lone_chain(
    fmus: Path, loop: VelocityLoop, compensators: Sequence[Compensator]
) -> tuple[cosim.System, str]:
    """Return compensators without a loop, its inputs named by role, and the last one's force."""
    system = cosim.System("chain")
    force, referenced = _add_chain(system, fmus, loop, compensators)
    taken: dict[str, list[str]] = {"v_ref": referenced}
    for role, place in _measured(compensators):
        taken.setdefault(role, []).append(place)
    for role, places in taken.items():
        if places:
            system.expose(role, *places)
    return system, str(force)


def _measured(compensators: Sequence[Compensator]) -> Iterator[tuple[str, str]]:
    """Yield the role and the place of each input that takes a measured signal."""
    for one in compensators:
        for variable, role in one.ports.inputs.items():
            if role in _MEASURED:
                yield role, f"{one.name}.{variable}"


def _follow(system: cosim.System, referenced: Sequence[str]) -> None:
    """Connect the velocity of the nominal loop to the reference inputs of compensators."""
    for place in referenced:
        system.connect("nominal.v_r", place)


def _add_chain(
    system: cosim.System, fmus: Path, loop: VelocityLoop, compensators: Sequence[Compensator]
) -> tuple[str | None, list[str]]:
    force, referenced = None, []
    for compensator in compensators:
        ports, name = compensator.ports, compensator.name
        file = fmus / f"{compensator.file or compensator.model}.fmu"
        system.add(name, file, compensator.parameters(loop))
        roles = {role: f"{name}.{variable}" for variable, role in ports.inputs.items()}
        if "v_ref" in roles:
            referenced.append(roles["v_ref"])
        if force is not None and "F_added" not in roles:
            raise ValueError(f"compensator '{name}' cannot add its force to {force}; put it first")
        if force is not None:
            system.connect(force, roles["F_added"])
        force = f"{name}.{ports.output}"
    return force, referenced


def _expose(
    system: cosim.System, loop: VelocityLoop, commanded: list[str], referenced: Sequence[str] = ()
) -> None:
    """Expose what ``loop.commands`` gives to the components that take it."""
    system.expose("v_cmd", *(f"{name}.v_cmd" for name in commanded), *referenced)
    if loop.m_ff:
        system.expose("a_cmd", *(f"{name}.a_cmd" for name in commanded))
    if loop.K_x:
        system.expose("x_cmd", "controller.x_cmd")


def nominal_parameters(loop: VelocityLoop) -> dict[str, float]:
    """Return the parameters of the nominal-loop FMU: the matrices of ``nominal``, ``acceleration``.

    What the order of the loop leaves unused is 0, whatever the FMU starts with.
    """
    nominal = loop.nominal
    matrices = {
        "A": nominal.A,
        "B": nominal.B[:, 0],
        "E": loop.acceleration.B[:, 0],
        "C": nominal.C[0],
    }
    values = {"T_s": loop.T_s, "D": float(nominal.D[0, 0])}
    for name, matrix in matrices.items():
        room = np.zeros((NOMINAL_ORDER,) * matrix.ndim)
        room[tuple(slice(n) for n in matrix.shape)] = matrix
        for index, value in np.ndenumerate(room):
            values[f"{name}[{','.join(str(i + 1) for i in index)}]"] = float(value)
    return values


def _add_servo(system: cosim.System, fmus: Path, loop: VelocityLoop, drive: str = "drive") -> None:
    gains = {"T_s": loop.T_s, "K_p": loop.K_p, "K_i": loop.K_i, "tau_f": loop.tau_f}
    gains |= {"m_ff": loop.m_ff, "K_x": loop.K_x}
    gains["velocity_feedforward"] = loop.velocity_feedforward
    filtered = loop.velocity_filter
    if filtered is not None:
        system.add("filter", fmus / "velocity_filter.fmu", filtered.parameters())
    system.add(
        "controller", fmus / "velocity_controller.fmu", {**gains, "use_v_hat": filtered is not None}
    )
    system.add(drive, fmus / f"{drive}.fmu")
    system.connect("controller.u", f"{drive}.u")
    system.connect(f"{drive}.x_enc", "controller.x_enc")
    if filtered is not None:
        system.connect(f"{drive}.x_enc", "filter.x_enc")
        system.connect(f"{drive}.F_m", "filter.F_m")
        system.connect("filter.v_hat", "controller.v_hat")


BLOCKS = {"compensator": "command_feedforward", "static_feedforward": "command_static"}
"""Compensator behind a nominal loop -> the model that contains this loop as well."""
_OF_THE_LOOP = ("hold", "T_s")


def deployed(one: Compensator, loop: VelocityLoop | None, T_s: float) -> Compensator:
    """Return a feedforward with the loop without friction in it.

    The controller of the loop gives the commands; without a loop, friction is that of the velocity
    command, and T_s the sample period of the controller [s].
    """
    values = {"T_s": T_s}
    if loop is not None:
        values = {**loop_values(loop), "lead": loop.axis.tau_i}
    values |= {name: value for name, value in one.values.items() if name not in _OF_THE_LOOP}
    return replace(one, model=BLOCKS[one.model], values=values)


def loop_values(loop: VelocityLoop) -> dict[str, float]:
    """Return the parameters of the loop without friction in a block of ``BLOCKS``.

    The position error of a cascade is the last state. The nominal loop adds T_s v_cmd to it in each
    period; here the change of x_cmd is added instead.
    """
    nominal = nominal_parameters(loop)
    values = {name if name == "T_s" else f"loop_{name}": v for name, v in nominal.items()}
    if loop.K_x:
        values[f"loop_B[{loop.nominal.nstates}]"] -= loop.T_s
        values[f"loop_G[{loop.nominal.nstates}]"] = 1.0
    return values
