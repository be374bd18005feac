"""A rig that a file describes, and one whose logs are kept."""

import hashlib
import inspect
import io
import json
import logging
import zipfile
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, cast

import numpy as np

from stickslip.errors import LimitError, RigError, UsageError
from stickslip.fmi.files import MOST_TEXT, atomic_write, parse_json, read_limited
from stickslip.planning import Limits
from stickslip.rigs.contract import Command, Log, Rig
from stickslip.rigs.limits import RigLimits
from stickslip.rigs.lines import LOOP
from stickslip.servo.axis import Datasheet
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.toml_files import NUMBER, PAIR, TABLE, TEXT, WHOLE, Kind, checked, read_toml

_LOG = ("t", "x_enc", "F_m")
_LOGGER = logging.getLogger("stickslip")


class KeptRig(Rig):
    """Runs motions on another rig and keeps each log in a folder; a motion that is kept is not run.

    What learns is deterministic: from the same logs follow the same commands. So the same program
    started again with the same folder goes through what was done without moving the drive, and on
    from there. A motion that was begun and whose log is missing is never repeated by itself.

    The folder has ``motion-0001.npz`` and so on, with t, x_enc, F_m and the signals of the command.
    It is of one rig: its name, datasheet and limits are kept with each log, and others are refused.
    The logger ``stickslip`` reports each motion that is not run, as a warning.

    Parameters
    ----------
    rig : runs the motions, within its limits
    folder : for the logs; is made where it is missing
    """

    def __init__(self, rig: Rig, folder: Path | str) -> None:
        super().__init__(rig.datasheet, rig.T_s, None, rig.law.name)
        self.name, self._rig, self._folder = rig.name, rig, Path(folder)
        self._folder.mkdir(parents=True, exist_ok=True)
        self._motion = 0
        limits = asdict(rig.limits) if rig.limits else None
        own = {"name": rig.name, "datasheet": asdict(rig.datasheet), "limits": limits}
        self._own = json.dumps(own, default=float)

    @property
    def bounds(self) -> RigLimits | None:
        """The limits of the rig that runs the motions."""
        return self._rig.bounds

    @property
    def loop(self) -> VelocityLoop:
        """The loop of the rig that runs the motions."""
        return self._rig.loop

    def move(self, command: Command) -> Log:
        """Return the log that is kept of this motion, or run it and keep its log.

        Raises
        ------
        RigError
            When the folder is of another run or rig, a file in it is damaged, or the motion was
            begun before and has no log.
        """
        self._motion += 1
        kept = self._folder / f"motion-{self._motion:04d}.npz"
        begun = kept.with_suffix(".json")
        key = _key_of(command)
        if kept.exists():
            with _readable(kept), np.load(kept, allow_pickle=False) as content:
                log = Log(*(content[name] for name in _LOG))
                self._compare(kept, content, key)
            self._report(f"is taken from {self._folder}")
            return log
        if begun.exists():
            with _readable(begun):
                state = parse_json(read_limited(begun, MOST_TEXT))
                limit = str(state["limit"])
                self._compare(begun, state, key)
            if limit:
                self._report(f"was aborted by a limit before, as kept in {self._folder}")
                raise LimitError(limit)
            raise RigError(
                f"{begun}: motion {self._motion} of {len(command) * self.T_s:.4g} s was begun and "
                "has no log; it is not repeated by itself. Look at the drive, then delete this "
                "file to run it again"
            )
        own = {"command": key, "rig": self._own}
        state = {**own, "limit": ""}
        atomic_write(begun, json.dumps(state))
        try:
            log = self._rig.run(command)
        except LimitError as fault:
            atomic_write(begun, json.dumps(state | {"limit": str(fault)}))
            raise
        stream = io.BytesIO()
        content = {**own, **{name: getattr(log, name) for name in _LOG}}
        np.savez(stream, **cast("Any", content | command.signals))
        atomic_write(kept, stream.getvalue())
        begun.unlink()
        return log

    def _report(self, what: str) -> None:
        _LOGGER.warning("motion %d %s; the drive was not moved", self._motion, what)

    def _compare(self, file: Path, content: Mapping[str, Any], asked: str) -> None:
        """Raise RigError where a file is of another rig or command, or ValueError."""
        of, kept = str(content["rig"]), str(content["command"])
        if of != self._own:
            other, own = json.loads(of), json.loads(self._own)
            name = next((n for n in own if other.get(n) != own[n]), "rig")
            raise RigError(
                f"{file}: is of another rig: {name} {other.get(name)}; expected {own.get(name)}. "
                "Give another folder"
            )
        if kept != asked:
            raise RigError(
                f"{file}: is of another command than motion {self._motion} of this run; expected "
                "the same program, settings and version. Use another folder for another run"
            )


@contextmanager
def _readable(file: Path) -> Iterator[None]:
    """Raise a RigError where a file is damaged."""
    try:
        yield
    except (OSError, LookupError, TypeError, ValueError, EOFError, zipfile.BadZipFile) as fault:
        raise RigError(
            f"{file}: is damaged ({' '.join(str(fault).split())}); a motion is not repeated by "
            "itself. Look at the drive, then delete this file to run the motion again"
        ) from None


def _key_of(command: Command) -> str:
    """Return a hash of all that a command says."""
    loop, filtered = command.loop, command.loop.velocity_filter
    gains = {name: getattr(loop, name) for name in LOOP}
    said = {"T_s": command.T_s, **gains, "filter": filtered.parameters() if filtered else None}
    key = hashlib.sha256(json.dumps(said, default=float).encode())
    for name, values in sorted(command.signals.items()):
        key.update(name.encode() + np.asarray(values, dtype="<f8").tobytes())
    return key.hexdigest()


KINDS: dict[type, Kind] = {float: NUMBER, int: WHOLE, str: TEXT, type(None): TEXT}
"""What a key of the file has to be, by the type of the argument's default."""
PAIRS = ("travel", "frequency", "slow", "presliding")


def open_rig(path: Path | str, law: str = "lugre") -> tuple[Rig, Limits]:
    """Connect to the rig that a TOML file describes; return it with the limits of experiments.

    One key names the kind of rig, an entry point of the group ``stickslip.rigs``, and its value
    says where the drive is, such as ``socket = "HOST:PORT"``. Other keys are keyword
    arguments of that class; the sections are ``[datasheet]``, ``[limits]`` (``RigLimits``)
    and ``[experiment]`` (``Limits``). All values are in SI units.

    Parameters
    ----------
    law : friction law of the compensator

    Raises
    ------
    UsageError
        When the file cannot be read, no such kind of rig is installed, or a key is missing, unknown
        or has a wrong value.
    RigError
        When there is no answer.
    """
    path = Path(path)
    content = read_toml(path)
    try:
        needed = ("mass", "peak_force", "encoder_step")
        stated = _section(content, "datasheet", Datasheet, needed)
        sheet = Datasheet(**{"force_noise": 0.0, **stated})
        limits = RigLimits(**_section(content, "limits", RigLimits, RigLimits.__annotations__))
        experiment = Limits(**_section(content, "experiment", Limits, ()))
        name, rig = _kind(content)
        further = inspect.signature(rig).parameters.values()
        named = {
            one.name: KINDS[type(one.default)] for one in further if one.kind is one.KEYWORD_ONLY
        }
        given = checked(content, {name: TEXT, **named})
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from None
    return rig(given.pop(name), sheet, limits, law, **given), experiment


def _kind(keys: Collection[str]) -> tuple[str, Callable[..., Rig]]:
    """Return the one key that names an installed kind of rig, and the class of that kind."""
    installed = entry_points(group="stickslip.rigs")
    found = [name for name in installed.names if name in keys]
    if len(found) != 1:
        kinds, got = ", ".join(sorted(installed.names)), ", ".join(map(repr, keys)) or "none"
        raise UsageError(
            f"expected one key that names an installed kind of rig ({kinds}); got {got}"
        )
    try:
        return found[0], installed[found[0]].load()
    except (ImportError, AttributeError) as fault:
        raise UsageError(f"{installed[found[0]].value} cannot be imported ({fault})") from None


def _section(
    content: dict[str, Any], name: str, kind: type, needed: Iterable[str]
) -> dict[str, Any]:
    """Take a section out of the file; return its values by name."""
    table: dict[str, Any] = checked({name: content.pop(name, {})}, {name: TABLE})[name]
    kinds = {one: PAIR if one in PAIRS else NUMBER for one in kind.__annotations__}
    for one in needed:
        if one not in table:
            raise UsageError(f"{name}.{one} is missing; expected {kinds[one][1]}, in SI units")
    return checked(table, kinds, f"{name}.")
