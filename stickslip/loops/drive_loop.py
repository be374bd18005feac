"""The loop of a learned drive as what is tuned: parameters of its FMUs by name."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Self

from stickslip import ga
from stickslip.catalog.parameters import friction_law
from stickslip.compensators.entrants import parts
from stickslip.errors import UsageError
from stickslip.fmi.messages import suggestion
from stickslip.learned.file import LearnedFile
from stickslip.learned.writing import LOOP_UNITS
from stickslip.models import Law, load_model
from stickslip.models.export.description import Variable
from stickslip.models.export.units import motion_unit
from stickslip.servo.systems import Compensator, nominal_parameters
from stickslip.servo.velocity_loop import VelocityLoop

GAINS = ("K_p", "K_i", "tau_f", "K_x", "m_ff", "velocity_feedforward")
SHARE = "compensator.share"  # of the feedforward's whole force
SEARCHED = {"K_p": (0.3, 4.0), "K_i": (0.1, 10.0), "tau_f": (0.1, 4.0), "K_x": (0.3, 5.0)}
"""Range of a gain that may change, over its present value."""
OBSERVED = (0.1, 4.0)  # the same of a gain of an observer
LEAST = 0.05  # share of a feedforward, or of an observer's estimate, where the search begins


@dataclass(frozen=True)
class DriveLoop:
    """A velocity loop or a cascade with its compensators."""

    loop: VelocityLoop
    law: Law  # friction law of the file
    feedforward: Compensator | None  # at its share
    observer: Compensator | None
    share: float = 1.0  # of the feedforward's whole force

    @classmethod
    def of(cls, learned: LearnedFile) -> Self:
        """Return the loop of a file with what was written for it; raise UsageError without."""
        if learned.loop is None:
            raise UsageError(
                f"{learned.path}: contains no loop; learn with the controller of the log, "
                "<controller> and <gain>"
            )
        files = learned.written
        return cls(
            learned.loop,
            learned.law,
            learned.feedforward if "compensator.fmu" in files else None,
            _unloaded(learned.observer) if "observer.fmu" in files else None,
            share=learned.share,
        )

    @property
    def chain(self) -> tuple[Compensator, ...]:
        """Its compensators in the order of their forces."""
        return tuple(one for one in (self.feedforward, self.observer) if one)

    @property
    def tunable(self) -> dict[str, float]:
        """What may be tuned, by ``component.variable``, and the share of the feedforward."""
        found = {f"controller.{name}": float(getattr(self.loop, name)) for name in GAINS}
        if not self.loop.K_x:
            del found["controller.K_x"], found["controller.velocity_feedforward"]
        for one in self.chain:
            own = {n: float(x) for n, x in one.values.items() if n not in one.ports.axis}
            found |= {f"{one.name}.{name}": value for name, value in own.items()}
        return found | ({SHARE: self.share} if self.feedforward else {})

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters of its FMUs, ``component.variable``, with those of the nominal loop."""
        found = {f"controller.{name}": float(getattr(self.loop, name)) for name in GAINS}
        known = {"nominal": nominal_parameters(self.loop)}
        known |= {one.name: one.parameters(self.loop) for one in self.chain}
        return found | {
            f"{part}.{n}": value for part, own in known.items() for n, value in own.items()
        }

    def unit(self, name: str) -> str:
        """Return the unit of one of ``tunable``."""
        found = self._variable(name)
        unit = found.unit or "1" if found else LOOP_UNITS.get(name.partition(".")[2], "1")
        return motion_unit(unit, rotary=self.loop.axis.rotary)

    def _variable(self, name: str) -> Variable | None:
        """Return that of a compensator's model which one of ``tunable`` sets; else None."""
        component, _, variable = name.partition(".")
        for one in self.chain:
            if one.name == component and name != SHARE:
                model = load_model(one.model, (one.law or self.law.name) if one.law else None)
                return next((v for v in model.variables if v.name == variable), None)
        return None

    def problem(
        self, ranges: Mapping[str, tuple[float, float]], fixed: Collection[str] = ()
    ) -> ga.Problem:
        """Return what is searched: gains, share and gains of the observer, or other ranges."""
        values, components = self.tunable, {name.partition(".")[0] for name in self.tunable}
        for name in (*ranges, *(one for one in fixed if one not in components)):
            if name not in values:
                raise UsageError(f"no '{name}' that may be tuned{suggestion(name, values)}")
        if not values["controller.m_ff"]:  # feedforward of the learned mass is the usual best
            values["controller.m_ff"] = self.loop.axis.m
        spans = {**self._spans(), **ranges}
        found = []
        for name, (low, high) in spans.items():
            if name in ranges or not {name, name.partition(".")[0]} & {*fixed}:
                start = min(max(values[name], low), high)
                unit = self.unit(name)
                found.append(ga.Gene(name, low, high, start, unit=unit, linear=low <= 0.0))
        if not found:
            raise UsageError("nothing is left to tune; expected fewer names in <fixed>")
        return ga.Problem(found)

    def _spans(self) -> dict[str, tuple[float, float]]:
        """Return what is searched by default: what is above 0, around its present value."""
        values = self.tunable
        spans = {f"controller.{name}": factors for name, factors in SEARCHED.items()}
        if self.observer:
            spans |= {f"observer.{name}": OBSERVED for name in _gains(self.observer.model)}
        found = {
            name: self._within(name, low * values[name], high * values[name])
            for name, (low, high) in spans.items()
            if values.get(name, 0.0) > 0.0
        }
        shares = {SHARE, "observer.share"} & {name for name in values if values[name] > 0.0}
        return found | {name: (min(LEAST, values[name]), 1.0) for name in sorted(shares)}

    def _within(self, name: str, low: float, high: float) -> tuple[float, float]:
        """Return a range within that of the model."""
        own = self._variable(name)
        if own and own.minimum is not None:
            low = max(low, own.minimum)
        if own and own.maximum is not None:
            high = min(high, own.maximum)
        return low, high

    def with_values(self, genes: Mapping[str, float]) -> "DriveLoop":
        """Return the loop with other values; raise ControlError when it is unstable."""
        gains = {n: genes[f"controller.{n}"] for n in GAINS if f"controller.{n}" in genes}
        loop = self.loop.changed(**gains) if gains else self.loop
        share, feedforward = genes.get(SHARE, self.share), self.feedforward
        if feedforward and share != self.share:
            law = friction_law(feedforward.law) if feedforward.law else self.law
            shared = law.share(feedforward.values, share / self.share)
            feedforward = replace(feedforward, values=shared)
        return replace(
            self,
            loop=loop,
            feedforward=_changed(feedforward, genes, loop),
            observer=_changed(self.observer, genes, loop),
            share=share,
        )


def _unloaded(one: Compensator) -> Compensator:
    """Return an observer for drives without the constant force that it leaves to the controller."""
    return replace(one, values={name: x for name, x in one.values.items() if name != "F_0"})


def _changed(
    one: Compensator | None, genes: Mapping[str, float], loop: VelocityLoop
) -> Compensator | None:
    """Return a compensator with other values, of which the filter time is that of the loop."""
    if one is None:
        return None
    own = {n: genes[f"{one.name}.{n}"] for n in one.values if f"{one.name}.{n}" in genes}
    own.pop("share", None) if one.name == "compensator" else None
    timed = {n: loop.tau_f for n, of in one.ports.axis.items() if of == "tau_f" and n in one.values}
    return replace(one, values={**one.values, **timed, **own})


def _gains(model: str) -> list[str]:
    """Return the parameters of an observer that the arena tunes, and the gain of its estimate."""
    ranges = [name for part in parts().values() if part.model == model for name in part.ranges]
    return [*dict.fromkeys([*ranges, "L_d"])]
