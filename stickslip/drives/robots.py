"""Drives for simulators of robots: MJCF, the format of MuJoCo, and URDF.

MuJoCo's actuator ``dcmotor`` has LuGre friction with a Stribeck exponent of 2, so that LuGre and
Dahl's law go into it. Other laws are written as LuGre friction, too, those without presliding with
bristles as stiff as a short step allows, and Coulomb friction alone as friction loss of the joint.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from stickslip.catalog.parameters import friction_law
from stickslip.drives.published import Drive
from stickslip.errors import UsageError
from stickslip.fmi.files import atomic_write
from stickslip.fmi.messages import suggestion

SAME = {"delta": 2.0, "i": 1.0, "v_d": 0.0}
"""Values with which LuGre and Dahl's law are those of MuJoCo."""
# Time step of a MuJoCo model, to one digit, as a share of times of presliding. Its Euler steps are
# explicit in the bristles: they diverge above 2 m / sigma_1, and above sigma_1 / sigma_0 they ring.
STIFF, LIGHT = 0.05, 0.005  # of sqrt(m / sigma_0), where damping asks for less
DAMPED = 0.2  # of m / sigma_1, and of (sigma_1 + b) / sigma_0
LONGEST = 1e-3  # [s]
SHORT = 1e-4  # [s], of a law without bristles whose static friction needs them

_MJCF = """<?xml version="1.0"?>
<mujoco model={name}>
  <!-- {about} -->
  <option integrator="Euler" timestep="{step:g}"/>
  <worldbody>
    <body name="carriage">
      <joint name="axis" type="{joint}" axis="{axis}"{loss}/>
      <inertial pos="0 0 0" mass="{mass:.9g}" diaginertia="{m:.9g} {m:.9g} {m:.9g}"/>
      <geom type="box" size="0.05 0.03 0.02" mass="0" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
  <actuator>
    <!-- its control is the motor's force in {force} -->
    <dcmotor name="motor" joint="axis" input="ff" motorconst="1 1" resistance="1"
        damping="{b:.9g}"{lugre}/>{constant}
  </actuator>
</mujoco>
"""
# A constant force is a cosine of the position whose wave number is 0.
_CONSTANT = """
    <dcmotor name="constant" joint="axis" input="none" motorconst="0 0" resistance="1"
        cogging="{:.9g} 0 1.57079633"/>"""
_URDF = """<?xml version="1.0"?>
<robot name={name}>
  <!-- {about} -->
  <link name="base"/>
  <link name="carriage">
    <inertial>
      <mass value="{mass:.9g}"/>
      <inertia ixx="{m:.9g}" iyy="{m:.9g}" izz="{m:.9g}" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="axis" type="{joint}">
    <parent link="base"/>
    <child link="carriage"/>
    <axis xyz="{axis}"/>
    <limit lower="-1" upper="1" effort="1000" velocity="10"/>
    <dynamics damping="{b:.9g}" friction="{F_c:.9g}"/>
  </joint>
</robot>
"""
FORMS = {"mjcf": "xml", "urdf": "urdf"}
"""Formats, and the suffixes of their files."""


@dataclass(frozen=True)
class RobotModel:
    """A drive in the format of a simulator."""

    text: str
    lost: tuple[str, ...]  # what the format does not express, a sentence each


def export_drive(source: Drive | Path | str, folder: Path | str, form: str = "mjcf") -> Path:
    """Write a drive as a model of one joint for MuJoCo (MJCF) or as URDF, and return its path.

    Parameters
    ----------
    source : a learned.json, or a drive of ``ss.drive``
    folder : is made if it is absent
    form : ``mjcf`` or ``urdf``; the comment in the file says what the format does not express

    Raises
    ------
    UsageError
        When the file has no drive, or there is no such format.
    OSError
        When a file cannot be read or written.
    """
    drive = source if isinstance(source, Drive) else Drive.learned(Path(source))
    model = robot_model(drive, form)
    return atomic_write(Path(folder) / f"{drive.name}.{FORMS[form]}", model.text)


def robot_model(drive: Drive, form: str) -> RobotModel:
    """Return a drive as MJCF or URDF; raise UsageError when there is no such format."""
    if form not in FORMS:
        raise UsageError(f"there is no format '{form}'{suggestion(form, FORMS)}")
    values = {name: one.start[0] for name, one in drive.law.parameters.items()} | {**drive.values}
    m, b, F_0, rotary = values["m"], values["b"], values.get("F_0"), drive.rotary
    parts: dict[str, object] = {"m": m, "mass": 1.0 if rotary else m, "b": max(b, 0.0)}
    parts |= {"name": quoteattr(drive.name), "axis": "0 0 1" if rotary else "1 0 0"}
    if form == "mjcf":
        template, (friction, lost) = _MJCF, _friction(drive, values)
        parts |= friction | {"constant": _CONSTANT.format(-F_0) if F_0 else ""}
        parts |= {"joint": "hinge" if rotary else "slide", "force": drive.unit("F_c")}
    else:
        template, lost = _URDF, ["friction is F_c; the limits of the joint are placeholders"]
        lost += _left_out(drive, values, ("F_c",))
        if F_0:
            lost.append(f"F_0 = {F_0:g} {drive.unit('F_0')} is left out")
        parts |= {"joint": "continuous" if rotary else "prismatic", "F_c": values["F_c"]}
    if held := [name for name in values if name.startswith(("g_", "mu_g", "cogging_"))]:
        lost.append(f"of the force of position, {', '.join(held)} are left out")
    if rotary:
        lost.append("the mass of 1 kg is a placeholder, only the inertia about the axis is known")
    if b < 0.0:
        lost.append(f"b = {b:g} {drive.unit('b')} is written as 0")
    if delay := values.get("delay"):
        lost.append(f"the delay of {delay:g} s is left out")
    parts["about"] = "\n       ".join([drive.title, *lost]).replace("--", "- -")
    return RobotModel(template.format(**parts), tuple(lost))


def _friction(drive: Drive, values: dict[str, float]) -> tuple[dict[str, object], list[str]]:
    """Return friction and time step of a MuJoCo model, and what it leaves out."""
    F_c, m = values["F_c"], values["m"]
    F_s, v_s, delta = values.get("F_s", F_c), values.get("v_s", 1.0), values.get("delta", 2.0)
    lost = _left_out(drive, values, friction_law("lugre").parameters)
    bristles = "sigma_0" in drive.law.parameters
    if not bristles and F_s == F_c:
        loss = f' frictionloss="{F_c:.9g}" solreffriction="{2 * LONGEST:g} 1"'
        loss += ' solimpfriction="0.9999 0.9999 0.001"'
        return {"loss": loss, "lugre": "", "step": LONGEST}, lost
    sigma_0 = values["sigma_0"] if bristles else m * (STIFF / SHORT) ** 2
    sigma_1 = values.get("sigma_1", 0.0) if bristles else math.sqrt(m * sigma_0)
    if not bristles:
        way = f"{F_s / sigma_0:.2g} {drive.unit('x')}"
        lost.append(f"in place of rest there are bristles, which yield by {way}")
    if F_s > F_c and delta != SAME["delta"]:
        v_s *= math.exp(np.euler_gamma * (1.0 / SAME["delta"] - 1.0 / delta))
        lost.append(
            f"v_s is {v_s:g}, not {values['v_s']:g} {drive.unit('v_s')}: the Stribeck curve has the"
            f" exponent 2, not {delta:g}, and the same mean over the logarithm of speed"
        )
    radian, damping = math.sqrt(m / sigma_0), DAMPED * (sigma_1 + values["b"]) / sigma_0
    step = min(LONGEST, STIFF * radian, max(LIGHT * radian, damping))
    step = float(f"{min(step, DAMPED * m / sigma_1) if sigma_1 else step:.0e}")
    lugre = " ".join(f"{x:.9g}" for x in (sigma_0, sigma_1, F_c, F_s, v_s))
    return {"loss": "", "lugre": f' lugre="{lugre}"', "step": step}, lost


def _left_out(drive: Drive, values: dict[str, float], used: Collection[str]) -> list[str]:
    """Return a sentence on parameters of the law that are not used but have an effect."""
    level = values.get("F_s") == values["F_c"]
    names = [
        name
        for name in drive.law.parameters
        if name not in used
        and values[name] != SAME.get(name)
        and not (level and name in ("F_s", "v_s", "delta"))
    ]
    return [f"of {drive.law.title} friction, {', '.join(names)} are left out"] if names else []
