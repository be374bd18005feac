"""Published drives: parameters with their sources, as ``stickslip/catalog/drives`` has them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from stickslip import cosim, models
from stickslip.blocks import kept
from stickslip.catalog import parameters
from stickslip.errors import UsageError
from stickslip.fmi.messages import suggestion
from stickslip.fmi.process import temporary_folder
from stickslip.learned.file import NORMAL, LearnedFile
from stickslip.learned.writing import LOOP_UNITS
from stickslip.models.export.units import motion_unit
from stickslip.system import System
from stickslip.toml_files import read_toml

FOLDER = Path(parameters.__file__).parent / "drives"
UNLIMITED = 1e9  # [N] or [N m], for a drive whose largest force is not published


@dataclass(frozen=True)
class Drive:
    """A drive by its parameters.

    Attributes
    ----------
    name, title : of its file in the catalogue, and a line on what it is
    law : friction law
    values : parameters by name, in SI units: m, b, those of the law, F_0 and, where they are
        published, others of the drive FMU
    rotary : whether inertia, force and position are kg m2, N m and rad
    loop : gains and sample period by name, in SI units; empty where none are published
    assumed : names of the values that are not published
    source, licence, note : where the figures come from, on which terms, and what else to know
    """

    name: str
    title: str
    law: models.Law
    values: Mapping[str, float]
    rotary: bool
    loop: Mapping[str, float] = field(default_factory=dict)
    assumed: tuple[str, ...] = ()
    source: str = ""
    licence: str = ""
    note: str = ""

    @classmethod
    def learned(cls, path: Path) -> Drive:
        """Return the drive of a learned.json; raise UsageError when it has none."""
        file = LearnedFile(path)
        block = file.position_force
        held = {name: one for name, one in block.values.items() if one} if block else {}
        values = {**held, **file.drive}
        for name in ("F_0", "delay"):  # what the log does not tell from none is left out
            error = file.document.get(name, {}).get("standard_error", 0.0)
            if abs(values[name]) < NORMAL * error:
                values[name] = 0.0
        found = cls("drive", "learned drive", file.law, values=values, rotary=file.rotary)
        if not found.values["m"] > 0.0:
            raise UsageError(
                f"{path}: parameters: m = {found.values['m']:g} {found.unit('m')}, expected a value"
                " above 0; learn from a log with quick ramps of velocity, or give a loop with m"
            )
        return found

    def unit(self, name: str) -> str:
        """Return the unit of a parameter or gain."""
        if name in self.loop:
            return motion_unit(LOOP_UNITS[name], rotary=self.rotary)
        return parameters.start_unit(name, rotary=self.rotary)

    @property
    def start(self) -> dict[str, float]:
        """Start values of its FMU, in which amplifier and encoder are ideal where not published."""
        known = {one.name for one in models.load_model("drive", self.law.name).variables}
        ideal = {"dac": False, "encoder": "encoder_step" in self.values, "current_loop": False}
        given = {name: value for name, value in self.values.items() if name in known}
        return {"u_max": UNLIMITED, **ideal, **given}

    def build_fmu(self, folder: Path | str, **options: Any) -> Path:
        """Write its drive FMU, ``folder/drive.fmu``; options are those of ``ss.build_fmu``."""
        options = {"law": self.law.name, "rotary": self.rotary, **options}
        return models.build_fmu("drive", folder, start=self.start, **options)

    def fmu(self) -> cosim.Fmu:
        """Return its drive FMU, to add to a system."""
        with temporary_folder() as folder:
            return kept(self.build_fmu(folder))

    def system(self) -> System:
        """Return a system of the drive alone, as ``drive``, with its force as the input ``u``."""
        system = System(self.name)
        system.add("drive", self.fmu())
        system.expose("u", "drive.u")
        return system

    def __str__(self) -> str:
        """Return all of it, with units."""
        model = models.load_model("drive", self.law.name)
        about = {one.name: one.description for one in model.variables}
        about |= {one.name: one.description for one in parameters.DRIVE.values()}
        about["u_max"] = "Peak force of the motor"
        lines = [self.title, f"{self.law.title} friction"]
        for name, value in self.values.items():
            assumed = " (not published; assumed)" if name in self.assumed else ""
            lines.append(f"  {name:12} {value:<12.9g} {self.unit(name):10} {about[name]}{assumed}")
        if self.loop:
            gains = (f"{name} = {x:g} {self.unit(name)}" for name, x in self.loop.items())
            lines.append(f"Loop: {', '.join(gains)}".replace(" 1,", ",").removesuffix(" 1"))
        ends = {"Source": self.source, "Licence": self.licence, "Note": self.note}
        return "\n".join([*lines, *(f"{name}: {text}" for name, text in ends.items() if text)])


def drive_names() -> list[str]:
    """Return the names of the published drives."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def drive(name: str) -> Drive:
    """Return a published drive by name, with its parameters and their source.

    Parameters
    ----------
    name : of ``ss.drive_names()``, such as ``emps``

    Returns
    -------
    Drive
        with ``values`` (SI units), ``unit(name)``, ``loop``, ``source`` and ``licence``;
        ``build_fmu(folder)``, ``fmu()`` and ``system()`` make its drive FMU, and ``print`` shows
        all of it

    Raises
    ------
    UsageError
        When there is no such drive.
    """
    if name not in drive_names():
        raise UsageError(f"there is no published drive '{name}'{suggestion(name, drive_names())}")
    table = read_toml(FOLDER / f"{name}.toml")
    texts = {key: table.get(key, "") for key in ("title", "source", "licence", "note")}
    assumed = table.get("assumed", {})
    return Drive(
        name,
        law=parameters.friction_law(table["law"]),
        values={**table["parameters"], **assumed},
        rotary=table["motion"] == "rotary",
        loop=table.get("loop", {}),
        assumed=tuple(assumed),
        **texts,
    )
