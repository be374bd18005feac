"""The force that the motor holds at a position: a weight, that of an arm, and cogging.

    F_pos(x) = F_0 + g_s sin x + g_c cos x + sum_k (a_k sin(2 pi k x / p) + b_k cos(2 pi k x / p))

The terms are linear regressors beside those of ``rows``, in the same eight regressions, and so are
the changes of pitch p. The weight of an arm loads gears and bearings: friction is
(1 + mu_g |g_s sin x + g_c cos x| / F_c) times that without it. What of the force depends on the
position without a direction, and on nothing else, tells which other terms there are. Friction may
vary along the guide with the same pitch, in a group of its own, and any other force of position
stays in a group of waves. Friction that both varies along the guide and differs between the
directions makes such waves, hence their least size.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

import numpy as np
import scipy
from threadpoolctl import threadpool_limits

from stickslip.identification.criteria.motion import position_noise, position_of
from stickslip.identification.held_out import folds, is_less, mean_squares
from stickslip.identification.sliding.friction_curve import Interval
from stickslip.identification.sliding.regression import Regression
from stickslip.identification.sliding.rows import (
    DISTANCES,
    FIXED,
    GUARDS,
    SLOWEST,
    Design,
    Rows,
    first_samples,
    shifted,
    sizes,
    together,
)
from stickslip.logs import Recording
from stickslip.logs.recording import Segment
from stickslip.servo.measurement import Array
from stickslip.thresholds import curve_shown, position_force

HARMONICS = 3  # of a pitch
PERIODS = (1.5, 250)  # fewest and most periods of a pitch in the travel
PLACES = 4096  # along the travel, for the search of a pitch
FINER = 4  # frequencies that are tried, over those that the travel tells apart
WAVES = 5e-4  # least standard deviation of waves along the travel, in the size of the force
EVEN = 0.05
"""The same, in what friction varies along the guide: as much as friction forward and backward may
differ from its mean, that variation is a force of position."""
BESIDE = (-3, -2, -1, 1, 2, 3)  # half-waves along the travel more than harmonics of a fine pitch
ROUNDS = 6  # Gauss steps of the pitch
SHIFTS = 3  # steps of the delay of the force
NEAR = 1e-3  # relative change of a weight from which on friction over it is regressed again
CLOSE = 0.1  # such a step that needs no other, in standard errors
BOTH = 0.5  # share of the travel that each direction has to cover
EDGE = 65  # rows over which the low-pass mixes them


@dataclass(frozen=True)
class PositionForce:
    """A force of position against the motor, by the parameters of the model of that name."""

    terms: dict[str, Interval]  # those that are shown, F_0 with them
    delay: float  # after which the motion shows the force of the log [s]

    @property
    def values(self) -> dict[str, float]:
        """Their values by name."""
        return {name: one.value for name, one in self.terms.items()}


def block_parameters(values: Mapping[str, float]) -> dict[str, float]:
    """Return the parameters of the model for terms by name; 0 is what is not shown."""
    every = _names(gravity=True, loads=True, orders=range(1, HARMONICS + 1))
    return dict.fromkeys(every, 0.0) | {"pitch": 1.0, "F_c": 1.0} | dict(values)


def friction_factor(values: Mapping[str, float], x: Array) -> Array | None:
    """Return by what a weight multiplies friction at x (n,); None for 1."""
    if not values.get("mu_g"):
        return None
    weight = values["g_s"] * np.sin(x) + values["g_c"] * np.cos(x)
    return np.asarray(1.0 + values["mu_g"] * np.abs(weight) / values["F_c"])


def varying(values: Mapping[str, float], x: Array) -> Array | None:
    """Return what of a force of position varies along x (n,) [N]; None where nothing does."""
    every = block_parameters(values)
    gravity = bool(every["g_s"] or every["g_c"])
    orders = [
        k for k in range(1, HARMONICS + 1) if every[f"cogging_s[{k}]"] or every[f"cogging_c[{k}]"]
    ]
    names = _names(gravity=gravity, loads=False, orders=orders)
    names = [name for name in names if name not in ("F_0", "pitch")]
    columns = _columns(x, orders, every["pitch"], gravity=gravity)
    return columns @ np.array([every[name] for name in names]) if names else None


def _names(*, gravity: bool, loads: bool, orders: Sequence[int]) -> list[str]:
    """Return the names of F_0 and the terms in the order of ``_columns``, the pitch last."""
    names = ["F_0", *(("g_s", "g_c") if gravity else ()), *(("mu_g", "F_c") if loads else ())]
    names += [f"cogging_{wave}[{k}]" for k in orders for wave in "sc"]
    return [*names, "pitch"] if orders else names


def _columns(x: Array, orders: Sequence[int], pitch: float, *, gravity: bool) -> Array:
    """Return sine and cosine of an arm and of harmonics of a pitch at positions (n,)."""
    turns = [x] if gravity else []
    turns += [2.0 * np.pi * k * x / pitch for k in orders]
    waves = [wave(turn) for turn in turns for wave in (np.sin, np.cos)]
    return np.column_stack(waves) if waves else np.empty((len(x), 0))


def with_position_force(recording: Recording, found: PositionForce | None = None) -> Recording:
    """Return a recording whose force of position is known: one found before, or what it shows."""
    found = found or find_position_force(recording)
    if found is None:
        return replace(recording, known_force=None, friction_factor=None)
    return with_known_force(recording, found.values, found.delay)


def with_known_force(recording: Recording, values: Mapping[str, float], delay: float) -> Recording:
    """Return a recording whose force of position has these values, and this delay [s]."""
    x = np.interp(recording.t + delay, recording.t, position_of(recording))
    factor = friction_factor(values, x)
    return replace(recording, known_force=varying(values, x), friction_factor=factor)


def find_position_force(recording: Recording) -> PositionForce | None:
    """Return the force of position that a recording in SI units shows, None where it shows none."""
    if recording.force is None or len(recording.t) < 8 * curve_shown.ROWS:
        return None
    signals = (position_of(recording).tobytes(), recording.force.tobytes())
    step, logs = recording.encoder_step, recording.segments
    return _found(*signals, T_s=recording.T_s, step=step, rotary=recording.rotary, logs=logs)


@lru_cache(1)  # checks and learning ask for that of the same signals
def _found(
    *signals: bytes, T_s: float, step: float, rotary: bool, logs: tuple[Segment, ...]
) -> PositionForce | None:
    with threadpool_limits(limits=1, user_api="blas"):  # sums that are split round differently
        position, force = map(np.frombuffer, signals)
        log = _Log(position, force, T_s, step, logs=logs)
        return _shown(log, rotary=rotary)


def _shown(log: "_Log", *, rotary: bool) -> PositionForce | None:
    if (rest := log.beside_friction()) is None or not rest.friction > 0.0:
        return None
    log, terms = log.aligned(rest.terms(rotary=rotary))
    while terms is not None:
        found = log.estimates(terms)
        if found is None:
            return None
        if (kept := found.kept(rest.friction)) == terms:
            return found.force()
        refined = log.refined(kept) if kept else None
        terms = refined and refined[0]
    if abs(rest.offset) < position_force.FALLS * rest.friction:
        return None
    found = log.estimates(_Terms())
    return found.force() if found else None


@dataclass(frozen=True)
class _Terms:
    """Terms with their coefficients, in the order of ``_columns``."""

    gravity: bool = False
    orders: tuple[int, ...] = ()  # harmonics of the pitch
    pitch: float = 0.0  # [m]
    coefficients: tuple[float, ...] = ()  # [N]
    loads: bool = False  # whether friction grows with the weight

    def columns(self, x: Array) -> Array:
        """Return the terms at positions (n,), and behind them the change of all with the pitch."""
        own = _columns(x, self.orders, self.pitch, gravity=self.gravity)
        if not self.orders:
            return own
        change = np.zeros_like(x)
        for k, order in enumerate(self.orders):
            first = 2 * self.gravity + 2 * k
            sine, cosine = own[:, first], own[:, first + 1]
            a, b = self.coefficients[self.parts()[str(order)]]
            change += (b * sine - a * cosine) * order
        return np.column_stack([own, change * 2.0 * np.pi * x / self.pitch**2])

    def weight(self, x: Array) -> Array:
        """Return the size of the arm's weight at positions (n,) [N]."""
        held = _columns(x, (), 1.0, gravity=True) @ np.array(self.coefficients[:2])
        return np.asarray(np.abs(held))

    def parts(self) -> dict[str, slice]:
        """Return which coefficients are of the arm, of friction over it, and of each harmonic."""
        sizes = {"gravity": 2 * self.gravity, "load": 1 * self.loads}
        sizes |= dict.fromkeys(map(str, self.orders), 2)
        ends = np.cumsum(list(sizes.values())).tolist()
        every = zip(sizes, ends, sizes.values(), strict=True)
        return {name: slice(end - size, end) for name, end, size in every if size}

    def only(self, names: set[str]) -> "_Terms | None":
        """Return the terms of some names alone; None without any."""
        if "gravity" not in names:
            names = names - {"load"}
        kept = {name: part for name, part in self.parts().items() if name in names}
        coefficients = (c for part in kept.values() for c in self.coefficients[part])
        orders = tuple(k for k in self.orders if str(k) in names)
        what = {"gravity": "gravity" in kept, "loads": "load" in kept}
        return (
            replace(self, **what, orders=orders, coefficients=tuple(coefficients)) if kept else None
        )


@dataclass(frozen=True)
class _Rest:
    """What the rows of a recording show of a force of position, before its terms are known."""

    x: Array  # (n,) [m]
    force: Array  # (n,) that depends on the position alone, with noise [N]
    friction: float  # mean, without its viscous part [N]
    offset: float  # F_0 [N]

    def terms(self, *, rotary: bool) -> _Terms | None:
        """Return the terms that explain it; each further one must explain much of what is left."""
        orders, whole = tuple(range(1, HARMONICS + 1)), float(np.var(self.force))
        tried = [_Terms(gravity=True)] if rotary else []
        for gravity in (False, True)[: 1 + rotary]:
            pitch = self.pitch(gravity=gravity)
            tried += [_Terms(gravity, orders=orders, pitch=pitch)] if pitch else []
        best, least = None, whole
        for one in tried:
            left = self.left(one)[0]
            if left < (position_force.SIMPLER * least if best else least):
                best, least = one, left
        if best is None or whole - least < (position_force.SHARE * self.friction) ** 2:
            return None
        found = self.left(best)[1].tolist()
        if best.gravity:
            return replace(best, loads=True, coefficients=(*found[:2], 0.0, *found[2:]))
        return replace(best, coefficients=tuple(found))

    def left(self, terms: _Terms) -> tuple[float, Array]:
        """Return the mean square that terms leave [N^2], and their coefficients (k,)."""
        x = _columns(self.x, terms.orders, terms.pitch, gravity=terms.gravity)
        columns = np.column_stack([np.ones_like(self.x), x])
        found = np.linalg.lstsq(columns, self.force, rcond=None)[0]
        return float(np.mean((self.force - columns @ found) ** 2)), np.asarray(found[1:])

    def pitch(self, *, gravity: bool) -> float | None:
        """Return the pitch of which three harmonics explain most; None where none fits."""
        travel = float(np.ptp(self.x))
        strongest = self._strongest(gravity=gravity)
        orders = tuple(range(1, HARMONICS + 1))

        def left(pitch: float) -> float:
            return self.left(_Terms(gravity, orders=orders, pitch=pitch))[0]

        able = [k * strongest for k in orders if k * strongest <= travel / PERIODS[0]]
        if not able:
            return None
        pitch, least = able[0], left(able[0])
        for longer in able[1:]:
            if left(longer) < position_force.SIMPLER * least:
                pitch, least = longer, left(longer)
        near, far = (1.0 / (1.0 / pitch + side / (FINER * travel)) for side in (1.0, -1.0))
        close = 1e-4 * pitch**2 / travel
        found = scipy.optimize.minimize_scalar(
            left, bounds=(near, far), method="bounded", options={"xatol": close}
        )
        return float(found.x)

    def _strongest(self, *, gravity: bool) -> float:
        """Return the length of the wave that explains most, by least squares at each length."""
        travel, n = float(np.ptp(self.x)), float(len(self.x))
        arm = _Terms(gravity=gravity)
        columns = np.column_stack([np.ones_like(self.x), arm.columns(self.x)])
        rest = self.force - columns @ np.linalg.lstsq(columns, self.force, rcond=None)[0]
        place = ((self.x - self.x.min()) / travel * PLACES).astype(int).clip(max=PLACES - 1)
        of_force, of_ones = (
            np.conj(np.fft.rfft(np.bincount(place, weights, PLACES), FINER * PLACES))
            for weights in (rest, None)
        )
        j = np.arange(int(np.ceil(FINER * PERIODS[0])), FINER * PERIODS[1] + 1)
        y, one, two = of_force[j], of_ones[j], of_ones[2 * j]
        # Sums of squares and products of cosine and sine, about their means.
        cc, ss = (0.5 * (n + sign * two.real) for sign in (1.0, -1.0))
        cc, ss = cc - one.real**2 / n, ss - one.imag**2 / n
        cs = 0.5 * two.imag - one.real * one.imag / n
        gain = y.real**2 * ss - 2.0 * y.real * y.imag * cs + y.imag**2 * cc
        singular = cc * ss - cs**2
        gain = np.where(singular > 1e-9 * n**2, gain / np.maximum(singular, 1e-300), 0.0)
        return float(FINER * travel / j[np.argmax(gain)])


@dataclass(frozen=True)
class _Estimates:
    """The eight estimates of terms."""

    terms: _Terms
    # (8, k) F_0, coefficients, Coulomb friction behind that of friction over the weight, and the
    # change of the pitch, where there is one
    values: Array
    variances: Array  # (8, k)
    sizes: dict[str, tuple[Array, Array]]  # by part: root mean squares (8,) and standard errors [N]
    predicted: dict[str, bool]  # whether a part predicts what it was not fitted to
    delay: float  # [s]

    def kept(self, friction: float) -> _Terms | None:
        """Return the terms that are shown; a weight does not lessen friction."""
        load = self.terms.parts().get("load", slice(0, 0))
        lessens = bool((self.values[:, 1:][:, load].mean(axis=0) < 0.0).any())
        names = {
            name
            for name, (force, error) in self.sizes.items()
            if force.mean() > position_force.SHARE * friction
            and not (lessens and name == "load")
            and np.all(force > position_force.CERTAIN * error)
            and self.predicted[name]
        }
        return self.terms.only(names)

    def force(self) -> PositionForce:
        """Return the terms with their intervals."""
        value, error, width = together(self.values, self.variances)
        shown = self.terms
        names = _names(gravity=shown.gravity, loads=shown.loads, orders=shown.orders)
        if shown.orders:
            value[-1] += shown.pitch
        ends = zip(names, value, error, value - width, value + width, strict=True)
        terms = {name: Interval(*map(float, one)) for name, *one in ends}
        return PositionForce(terms, self.delay)


class _Log:
    """A recording behind two low-passes."""

    def __init__(
        self,
        position: Array,
        force: Array,
        T_s: float,
        step: float,
        *,
        logs: tuple[Segment, ...],
        delay: float = 0.0,  # of the force, which is taken out [s]
    ) -> None:
        self.position, self.force, self.T_s, self.step = position, force, T_s, step
        self.logs, self.delay, noise = logs, delay, position_noise(position, step)
        first, own = first_samples(position, T_s, noise), shifted(force, T_s, delay)
        self.rows = [
            Rows(position, own, T_s, noise, logs=logs, q=q, share=SLOWEST)
            for q in (first, 2 * first)
        ]
        self.plain = self.rows[0].design(DISTANCES[0], GUARDS[0])
        self.found = self.plain.fitted() if self.plain else None
        self.guide = 0.0  # amplitude of what friction varies along the guide [N]

    def beside_friction(self) -> _Rest | None:
        """Return what is left of the force without mass and friction; None with too few rows."""
        design, found, rows, fixed = self.plain, self.found, self.rows[0], len(FIXED)
        if design is None or found is None or not self._both_ways(design):
            return None
        c = found.coefficients
        rigid = design.fixed @ c[:fixed]
        other = sum(
            group @ c[found.places[name]]
            for name, group in design.groups.items()
            if name != "ripple"
        )
        m, b = (c[FIXED.index(name)] for name in ("m", "b"))
        F_0 = float(design.usual(found, "F_0", "asymmetry") @ c)
        ahead = rows.ahead[design.used]
        moving = m * rows.a[design.used] + b * rows.v[design.used]
        friction = float(np.mean(ahead * (rigid + other - moving - F_0)))
        return _Rest(rows.x[design.used], design.force - rigid - other, friction, F_0)

    def _both_ways(self, design: Design) -> bool:
        """Whether it slides both ways where it does: else friction may be a force of position."""
        x, ahead = self.rows[0].x[design.used], self.rows[0].ahead[design.used]
        ways = (x[ahead > 0.0], x[ahead < 0.0])
        return all(one.size and np.ptp(one) > BOTH * np.ptp(x) for one in ways)

    def aligned(self, terms: _Terms | None) -> "tuple[_Log, _Terms | None]":
        """Return the log with the force at its instant, as terms show it, and these refined."""
        log = self
        for _ in range(SHIFTS):
            refined = log.refined(terms) if terms else None
            if refined is None:
                return log, None
            terms, late = refined
            if abs(late) < 0.5 * self.T_s:
                break
            signals = (self.position, self.force, self.T_s, self.step)
            log = _Log(*signals, logs=self.logs, delay=log.delay + late)
        return log, terms

    def refined(self, terms: _Terms) -> tuple[_Terms, float] | None:
        """Return terms with coefficients and pitch of the first regression, and its delay [s]."""
        for _ in range(ROUNDS):
            design = self._design(terms, self.rows[0], DISTANCES[0], GUARDS[0])
            if design is None:
                return None
            found = self._fitted(design)
            names = [name for name in ("guide", "pitch") if name in design.groups]
            varies, _ = sizes(found, design.groups, names)
            self.guide = float(np.sqrt(2.0) * np.linalg.norm(varies))
            c = found.coefficients[len(FIXED) : design.fixed.shape[1]]
            late = float(found.coefficients[FIXED.index("delay")]) * self.rows[0].T
            if not terms.orders:
                before, terms = terms, replace(terms, coefficients=tuple(c.tolist()))
                old, new = (np.array(one.coefficients[:2]) for one in (before, terms))
                if terms.loads and not np.linalg.norm(new - old) < NEAR * np.linalg.norm(new):
                    continue
                return terms, late
            terms = replace(terms, coefficients=tuple(c[:-1].tolist()))
            k = design.fixed.shape[1] - 1
            most = terms.pitch**2 / (FINER * np.ptp(self.position))
            step = float(np.clip(c[-1], -most, most))
            terms = replace(terms, pitch=terms.pitch + step)
            if abs(step) < CLOSE * np.sqrt(found.covariance[k, k]):
                break
        return terms, late

    def _fitted(self, design: Design) -> Regression:
        least = max(WAVES, EVEN * self.guide / design.size)
        return design.fitted(dict.fromkeys({"ripple", "beside"} & design.groups.keys(), least))

    def estimates(self, terms: _Terms) -> _Estimates | None:
        """Return the eight estimates of terms; None without one of them."""
        values, variances, parts, delays = [], [], [], []
        predicted: dict[str, bool] = {}
        for rows, distance, guard in product(self.rows, DISTANCES, GUARDS):
            design = self._design(terms, rows, distance, guard)
            if design is None:
                return None
            found = self._fitted(design)
            own = slice(len(FIXED), design.fixed.shape[1])
            offset = design.usual(found, "F_0", "asymmetry")
            c, covariance = found.coefficients, found.covariance
            row, variance = [offset @ c, *c[own]], [offset @ covariance @ offset]
            variance += np.diag(covariance)[own].tolist()
            if terms.loads:
                mean = float(terms.weight(rows.x)[design.used].mean())
                # Coulomb friction without a mean weight
                level = design.usual(found, "F_c", "curve")
                level[len(FIXED) + 2] = -mean
                row.insert(4, level @ c)
                variance.insert(4, level @ covariance @ level)
            values.append(row)
            variances.append(variance)
            delays.append(c[FIXED.index("delay")] * rows.T)
            if not predicted:
                predicted = {
                    name: _predicts(design, found, part) for name, part in terms.parts().items()
                }
            parts.append([_size(design, found, part) for part in terms.parts().values()])
        by_part = np.transpose(parts, (1, 2, 0)) if terms.parts() else ()
        sizes = {name: (one[0], one[1]) for name, one in zip(terms.parts(), by_part, strict=True)}
        return _Estimates(
            terms,
            np.array(values),
            np.array(variances),
            sizes=sizes,
            predicted=predicted,
            delay=self.delay + float(np.mean(delays)),
        )

    def _design(self, terms: _Terms, rows: Rows, distance: float, guard: float) -> Design | None:
        """Return the regression on terms beside the rest."""
        design = rows.design(distance, guard)
        if design is None:
            return None
        used, size, groups = design.used, design.size, dict(design.groups)
        own = [rows.of_samples(column)[used] for column in terms.columns(self.position).T]
        if terms.loads:
            weight = terms.weight(rows.x)
            over = rows.ahead * (weight - weight[used].mean())  # beside that of the mean weight
            own.insert(2, rows.low(over[:, np.newaxis])[used, 0])
        waves = groups["ripple"].shape[1]
        if terms.orders:
            pitch, halves = _columns(rows.x, terms.orders, terms.pitch, gravity=False), set[int]()
            groups["pitch"] = size * rows.low(rows.ahead[:, np.newaxis] * pitch)[used]
            for order in terms.orders:
                k = round(2.0 * order * np.ptp(rows.x) / terms.pitch)
                halves |= {k + one for one in BESIDE if k + one > waves}
            if halves:
                groups["beside"] = size * rows.waves(sorted(halves))[used]
        return replace(design, fixed=np.column_stack([design.fixed, *own]), groups=groups)


def _size(design: Design, found: Regression, part: slice) -> tuple[float, float]:
    """Return the root mean square of a part of the terms about its mean, and its error [N]."""
    place = slice(len(FIXED) + part.start, len(FIXED) + part.stop)
    x = design.fixed[:, place] - design.fixed[:, place].mean(axis=0)
    force = float(np.std(x @ found.coefficients[place]))
    covariance = found.covariance[place, place]
    return force, float(np.sqrt(np.mean(np.sum(x @ covariance * x, axis=1))))


def _predicts(design: Design, found: Regression, part: slice) -> bool:
    """Whether a part of the terms, fitted to some blocks, predicts the force in others."""
    place = slice(len(FIXED) + part.start, len(FIXED) + part.stop)
    x = np.column_stack([np.ones(len(design.force)), design.fixed[:, place]])
    every = np.column_stack([design.fixed, *design.groups.values()])
    rest = design.force - every @ found.coefficients
    force = rest + design.fixed[:, place] @ found.coefficients[place]
    without, left = np.empty_like(force), np.empty_like(force)
    for fold in folds(len(force), EDGE):
        fitted = np.linalg.lstsq(x[fold.fitted], force[fold.fitted], rcond=None)[0]
        left[fold.held_out] = (force - x @ fitted)[fold.held_out]
        without[fold.held_out] = (force - force[fold.fitted].mean())[fold.held_out]
    whole = np.ones(len(force), dtype=bool)
    return is_less(mean_squares(left, whole), mean_squares(without, whole))
