"""Random FMI calls, lawful and not, on several instances of one of our libraries at a time.

Each instance has a shadow that is given the lawful calls only. An unlawful call must answer error
and leave no trace: all variables of the two agree, bit for bit, after each of them. What is lawful
is told by the tables here: the life cycle as the standards draw it, and the variables as model.toml
has them. It runs in a process of its own, which has the sanitizers of the library loaded:

    python random_calls.py LIBRARY MODEL.json FIRST COUNT    prints "CALLS UNLAWFUL HASH"
"""

import ctypes
import hashlib
import json
import math
import random
import sys
from ctypes import byref, c_bool, c_double, c_int, c_size_t, c_uint8, c_uint32, c_void_p
from pathlib import Path

OK, DISCARD, ERROR = 0, 2, 3
CREATED, STARTING, STEPS, OVER, FAULTY, EVENTS, FLOWING = (1 << k for k in range(7))
WELL = CREATED | STARTING | STEPS | OVER | EVENTS | FLOWING
READABLE = STARTING | OVER | EVENTS | FLOWING  # in Model Exchange
ALWAYS = WELL | FAULTY
ODD = [math.nan, math.inf, -math.inf, 1e300, -1e300, 5e-324, -0.0, 1.0, 1e18, -1.0, 1e-3, 0.5]
STEP_SIZES = [5e-4, 1e-3, 1e-4, 3.7e-4, 0.0123]
MOST, PAIRS, KEPT, HUGE = 4, 3, 3, 2**64 - 1
LARGEST = sys.float_info.max
TO_FMI_2 = {"FMUState": "FMUstate", "Deserialize": "DeSerialize", "Float64": "Real"}
TO_FMI_2 |= {"Int32": "Integer", "ContinuousStateDerivatives": "Derivatives"}
Hear2 = ctypes.CFUNCTYPE(None, c_void_p, c_void_p, c_int, c_void_p, c_void_p)
Hear3 = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_void_p, c_void_p)


class Pair:
    """An instance and its shadow."""

    def __init__(self, at, *, exchange):
        self.at, self.exchange, self.phase, self.t = at, exchange, CREATED, 0.0
        self.kept = [([c_void_p(), c_void_p()], 0) for _ in range(KEPT)]  # states, and the phase
        self.freed = c_void_p()


class Caller:
    """What calls one library, and counts."""

    def __init__(self, library, model):
        self.library, self.fmi, self.variables = ctypes.CDLL(library), model["fmi"], model["rows"]
        self.slopes, self.model_exchange = model["slopes"], model["model_exchange"]
        truth = c_int if self.fmi == 2 else c_bool
        self.types = {"real": ("Float64", c_double), "integer": ("Int32", c_int)}
        self.types["boolean"] = ("Boolean", truth)
        self.of = {kind: self._places(kind, "type") for kind in (*self.types, "derived")}
        self.states = len(self._places("derivative", "role"))
        self.calls = self.unlawful = 0
        self.hash = hashlib.sha256()
        self.hear = (Hear2 if self.fmi == 2 else Hear3)(lambda *_: None)
        self.functions = (c_void_p * 5)(ctypes.cast(self.hear, c_void_p).value)
        self.scratch = (c_double * (len(self.variables) + 8))()

    def _places(self, word, key):
        return [k for k, v in enumerate(self.variables) if v[key] == word]

    def function(self, name):
        for new, old in TO_FMI_2.items() if self.fmi == 2 else ():
            name = name.replace(new, old)
        return getattr(self.library, f"fmi{self.fmi}{name}")

    def below(self, n):
        return self.draw.randrange(n)

    def rarely(self):
        return self.below(6) == 0

    def odd(self):
        return self.draw.choice(ODD)

    def violated(self, what):
        raise SystemExit(f"sequence {self.seed}: {self.doing}: {what}")

    def everything(self, instance):
        """Return the bits of all variables."""
        found = b""
        for kind, (name, type_) in self.types.items():
            places = self.of[kind] + self.of["derived"] * (kind == "real")
            n = len(places)
            values = (type_ * n)()
            more = (c_size_t(n),) if self.fmi == 3 else ()
            given = (c_uint32 * n)(*places), c_size_t(n), values, *more
            if self.function(f"Get{name}")(instance, *given):
                self.violated(f"values of type {kind} cannot be read")
            found += bytes(values)
        return found

    def compare(self, p):
        values = self.everything(p.at[0])
        if values != self.everything(p.at[1]):
            self.violated("left a trace")
        self.hash.update(values)

    def both(self, p, lawful, name, *arguments):
        """Call, if it is lawful the shadow as well; a tuple has an argument for each of both."""

        def on(who):
            given = (a[who] if isinstance(a, tuple) else a for a in arguments)
            return self.function(name)(p.at[who], *given)

        self.doing = name
        status = on(0)
        self.calls += 1
        self.hash.update(bytes([status]))
        if not lawful:
            self.unlawful += 1
            if status != ERROR:
                self.violated(f"unlawful, but not an error: {status}")
            self.compare(p)
        elif (other := on(1)) != status:
            self.violated(f"{status}, and {other} of the shadow")
        return status

    def change(self, p, phases, name, to):
        if self.both(p, p.phase & phases, name) == OK:
            p.phase = to

    def must(self, condition):
        if not condition:
            self.violated("lawful, but answered otherwise")

    def instantiate(self, token, *, exchange, log):
        if self.fmi == 2:
            functions = byref(self.functions) if log else None
            made = self.library.fmi2Instantiate
            given = (b"x", int(not exchange), token, None, functions, 0, int(log))
        else:
            hear = self.hear if log else None
            kind = "ModelExchange" if exchange else "CoSimulation"
            made = getattr(self.library, f"fmi3Instantiate{kind}")
            given = (b"x", token, None, False, log)
            own = (False, False, None, c_size_t(0))
            given += (None, hear) if exchange else (*own, None, hear, None)
        made.restype = c_void_p
        return c_void_p(made(*given))

    def pair(self):
        self.doing = "instantiate"
        exchange = bool(self.below(2))
        wrong = self.draw.choice([None, b"stale"])
        if self.instantiate(wrong, exchange=exchange, log=bool(self.below(2))).value:
            self.violated("took a wrong token")
        exchange = exchange and self.model_exchange
        logs = bool(self.below(2)), False
        at = [self.instantiate(b"token", exchange=exchange, log=log) for log in logs]
        return Pair(at, exchange=exchange)

    def free(self, p):
        self.compare(p)
        for instance in p.at:
            self.function("FreeInstance")(instance)

    def live(self, p):
        start = self.odd() if self.rarely() else self.below(3) * 0.1
        what = self.below(7)
        if self.below(2) and p.phase & (CREATED | STARTING):  # onwards
            what = 0 if p.phase == CREATED else 2
        times = 0, c_double(0.0), c_double(start), 0, c_double(0.0)
        begins = p.phase == CREATED and math.isfinite(start)
        if what < 2 and self.fmi == 2:
            self.change(p, CREATED, "EnterInitializationMode", STARTING)
        elif what < 2:
            if self.both(p, begins, "EnterInitializationMode", *times) == OK:
                p.t, p.phase = start, STARTING
        elif what < 4:
            self.change(p, STARTING, "ExitInitializationMode", EVENTS if p.exchange else STEPS)
        elif what == 4 and self.rarely():
            self.change(p, STEPS | EVENTS | FLOWING, "Terminate", OVER)
        elif what == 5 and self.rarely():
            self.change(p, ALWAYS, "Reset", CREATED)
            self.must(p.phase == CREATED)
        elif what == 6 and self.fmi == 2:
            p.t = start if self.both(p, begins, "SetupExperiment", *times) == OK else p.t

    def go(self, p):
        h = self.odd() if self.rarely() else self.draw.choice(STEP_SIZES)
        t = self.odd() if self.rarely() and self.rarely() else p.t
        answers = self.fmi == 2 or not self.rarely()
        lawful = p.phase == STEPS and answers and math.isfinite(t) and math.isfinite(h) and h > 0
        more = [byref(self.scratch, 8 * k) for k in range(4)] if self.fmi == 3 else []
        if not answers:
            more[self.below(4)] = None
        status = self.both(p, lawful, "DoStep", c_double(t), c_double(h), 1, *more)
        if lawful:
            self.must(status in (OK, ERROR))
            p.phase, p.t = STEPS if status == OK else FAULTY, t + h
            self.compare(p)

    def fits(self, p, place, kind, value, *, setting):
        if place >= len(self.variables):
            return False
        v = self.variables[place]
        if not setting:
            return v["type"] == kind or (v["type"] == "derived" and kind == "real")
        before = CREATED | STARTING
        phases = {"input": WELL & ~OVER, "state": before, "parameter": before}
        may = phases.get(v["role"], 0)
        may |= STEPS | EVENTS if v["variability"] == "tunable" else 0
        low = -LARGEST if v["minimum"] is None else v["minimum"]
        high = LARGEST if v["maximum"] is None else v["maximum"]
        return v["type"] == kind and bool(may & p.phase) and low <= value <= high

    def some(self, kind):
        """Return a value reference, mostly of a variable of this type."""
        if self.rarely() and self.rarely():
            return self.draw.choice([len(self.variables) + self.below(3), 2**32 - 1])
        if self.rarely() or not self.of[kind]:
            return self.below(len(self.variables))
        return self.draw.choice(self.of[kind])

    def value(self, place, kind):
        if kind == "integer":
            return self.draw.choice([self.below(4), self.below(2**32) - 2**31])
        if kind == "boolean":
            return self.below(3 if self.fmi == 2 else 2)
        if self.rarely() or place >= len(self.variables):
            return self.odd()
        v = self.variables[place]
        return v["start"] + (self.draw.random() - 0.5) * (v["nominal"] or 1.0)

    def transfer(self, p, *, setting):
        kind = self.draw.choice([*self.types])
        name, type_ = self.types[kind]
        n = self.below(MOST + 1)
        places = [self.some(kind) for _ in range(n)]
        values = [self.value(place, kind) for place in places]
        each = zip(places, values, strict=True)
        lawful = all(self.fits(p, r, kind, x, setting=setting) for r, x in each)
        lawful = lawful and bool(p.phase & (WELL if setting else ALWAYS))
        given = (type_ * MOST)(*values)
        found = (type_ * MOST)(), (type_ * MOST)()
        references = (c_uint32 * MOST)(*places)
        if self.rarely() and self.rarely():  # nothing, or more than there is: the first is refused
            references[0], lawful = len(self.variables), False
            n = self.draw.choice([HUGE, n + 1])
            references = self.draw.choice([references, None])
            given, found = self.draw.choice([(given, found), (None, None)])
        counts = [n]
        if self.fmi == 3:
            other = self.draw.choice([n - 1 if n else 1, (n + 1) % 2**64])
            counts.append(other if self.rarely() and self.rarely() else n)
        lawful = lawful and len({*counts}) == 1
        ends = [c_size_t(count) for count in counts]
        values = given if setting else found
        verb = "Set" if setting else "Get"
        status = self.both(p, lawful, f"{verb}{name}", references, ends[0], values, *ends[1:])
        if lawful:
            self.must(status == OK and bytes(found[0]) == bytes(found[1]))

    def differentiate(self, p):
        roles = [v["role"] for v in self.variables]
        wanted = {"state", "derivative", "output"}, {"state", "input"}
        counts, references, lawful = [], [], self.slopes and p.phase & ~(CREATED | FAULTY)
        for known in wanted:
            pool = [k for k, role in enumerate(roles) if role in known]
            counts.append(n := self.below(MOST + 1))
            pools = [None if self.rarely() else pool for _ in range(n)]
            places = [self.draw.choice(some) if some else self.some("real") for some in pools]
            lawful = lawful and all(k < len(roles) and roles[k] in known for k in places)
            references.append((c_uint32 * MOST)(*places))
        if self.rarely() and counts[0]:
            references[0], lawful = None, False
        spare = int(self.fmi == 3 and self.rarely())
        lawful = lawful and not spare
        seeds = (c_double * (MOST + 1))(1.0, -2.0, 0.5, 3.0)
        of, by = ((r, c_size_t(n)) for r, n in zip(references, counts, strict=True))
        for adjoint in range(self.fmi - 1):  # FMI 2.0 has none
            name = "AdjointDerivative" if adjoint else "DirectionalDerivative"
            n_seeds, n_found = counts if adjoint else counts[::-1]
            found = (c_double * MOST)(), (c_double * MOST)()
            given = (seeds, found)
            if self.fmi == 3:
                given = (seeds, c_size_t(n_seeds + spare), found, c_size_t(n_found))
            status = self.both(p, lawful, f"Get{name}", *of, *by, *given)
            self.must(not lawful or (status == OK and bytes(found[0]) == bytes(found[1])))

    def foreign(self, p):
        """Return a state of another instance."""
        theirs, own = self.draw.choice(self.pairs), {of[0].value for of, _ in p.kept}
        some = theirs.kept[self.below(KEPT)][0][0], p.kept[self.below(KEPT)][0][1]
        here = ctypes.cast(self.scratch, c_void_p)
        found = self.draw.choice([c_void_p(), p.freed, *some, here])
        return c_void_p() if found.value in own else c_void_p(found.value)

    def serialize(self, p, of, phase):
        size = c_size_t()
        known = of[0].value is not None
        status = self.both(p, known, "SerializedFMUStateSize", tuple(of), byref(size))
        if not known:
            return
        self.must(status == OK and size.value > 0)
        self.both(p, False, "SerializedFMUStateSize", self.foreign(p), byref(c_size_t()))
        bits = (c_uint8 * size.value)(), (c_uint8 * size.value)()
        room = self.below(size.value) if self.rarely() else size.value
        place = (None, None) if self.rarely() else bits
        lawful = room >= size.value and place is bits
        if self.both(p, lawful, "SerializeFMUState", tuple(of), place, c_size_t(room)) != OK:
            return
        to, spoilt = self.draw.choice(self.pairs) if self.rarely() else p, self.below(2)
        if spoilt:
            bits[0][self.below(size.value)] ^= 1 + self.below(255)
        told = self.draw.choice([0, size.value - 1]) if self.rarely() else size.value
        lawful = not spoilt and told == size.value and to.exchange == p.exchange
        made = [c_void_p(), c_void_p()]
        places = byref(made[0]), byref(made[1])
        status = self.both(to, lawful, "DeserializeFMUState", bits, c_size_t(told), places)
        self.must(bool(lawful) == (status == OK))
        k = self.below(KEPT)
        if status == OK and to.kept[k][0][0].value is None:
            to.kept[k] = made, phase  # else nobody frees it: its instance will

    def remember(self, p):
        k = self.below(KEPT)
        of, phase = p.kept[k]
        places = byref(of[0]), byref(of[1])
        what = self.below(7)
        if what < 2:
            self.must(self.both(p, True, "GetFMUState", places) == OK and of[0].value)
            p.kept[k] = of, p.phase
        elif what < 4:
            known = of[0].value is not None
            status = self.both(p, known, "SetFMUState", tuple(of))
            self.must(not known or status == OK)
            p.phase = phase if status == OK else p.phase
            self.compare(p)
        elif what == 4 and of[0].value:
            p.freed = c_void_p(of[0].value)
            self.must(self.both(p, True, "FreeFMUState", places) == OK and of[0].value is None)
        elif what == 5:
            wrong = self.foreign(p)
            self.both(p, False, "SetFMUState", wrong)
            self.both(p, False, "GetFMUState", byref(wrong) if wrong.value else None)
            if wrong.value:
                self.both(p, False, "FreeFMUState", byref(wrong))
        elif what == 6:
            self.serialize(p, of, phase)

    def exchange(self, p):
        n = self.draw.choice([HUGE, self.states + 1]) if self.rarely() else self.states
        place = None if self.rarely() else self.scratch
        counted = n == self.states and (n == 0 or place is not None)
        answers, what = not self.rarely(), self.below(10)
        some = [byref(self.scratch, 8 * k) for k in range(6)]
        vector = place, c_size_t(n)
        if what == 0 and self.fmi == 2:
            asked = some[0] if answers else None
            self.both(p, p.phase == EVENTS and answers, "NewDiscreteStates", asked)
        elif what == 0:
            some[3] = some[3] if answers else None
            self.both(p, p.phase == EVENTS and answers, "UpdateDiscreteStates", *some)
        elif what == 1:
            self.change(p, EVENTS, "EnterContinuousTimeMode", FLOWING)
        elif what == 2:
            self.change(p, FLOWING, "EnterEventMode", EVENTS)
        elif what == 3:
            t = self.odd() if self.rarely() else p.t + self.below(3) * 1e-4
            lawful = p.phase & (EVENTS | FLOWING) and math.isfinite(t)
            if self.both(p, lawful, "SetTime", c_double(t)) == OK:
                p.t = t
        elif what == 4:
            asked = some[0] if answers else None, some[1]
            self.both(p, p.phase == FLOWING and answers, "CompletedIntegratorStep", 1, *asked)
        elif what < 7:
            for k in range(self.states):
                self.scratch[k] = self.odd() if self.rarely() else 1e-3 * self.below(100)
            finite = all(map(math.isfinite, self.scratch[: self.states]))
            lawful = counted and p.phase == FLOWING
            status = self.both(p, lawful, "SetContinuousStates", *vector)
            self.must(not lawful or status == (OK if finite else DISCARD))
            self.compare(p)
        elif what == 7:
            lawful = counted and p.phase & READABLE
            self.both(p, lawful, "GetContinuousStateDerivatives", *vector)
        elif what == 8:
            self.both(p, counted and p.phase & READABLE, "GetContinuousStates", *vector)
        else:
            lawful = counted and p.phase & (READABLE | CREATED)
            self.both(p, lawful, "GetNominalsOfContinuousStates", *vector)
            right = len(self._places("indicator", "role"))
            asked = right + int(self.rarely())
            lawful = p.phase & READABLE and asked == right
            self.both(p, lawful, "GetEventIndicators", self.scratch, c_size_t(asked))

    def speak(self, p):
        n = self.below(4)
        words = (ctypes.c_char_p * 3)(b"logEvents", b"no such category", None)
        given = None if self.rarely() else words
        lawful = n == 0 or (given is not None and n < 3)
        self.both(p, lawful, "SetDebugLogging", self.below(2), c_size_t(n), given)
        for name, *arguments in (
            ("Reset",),
            ("SetFMUState", p.kept[0][0][0]),
            ("DoStep", c_double(0.0), c_double(1e-3), 1, *[byref(self.scratch)] * 4),
        ):
            self.doing = f"{name} of no instance"
            if self.function(name)(None, *arguments) != ERROR:
                self.violated("not an error")
        lacking = "SetRealInputDerivatives" if self.fmi == 2 else "EnterConfigurationMode"
        self.both(p, False, lacking, *[None, c_size_t(0), None, None] * (self.fmi == 2))

    def act(self, p):
        what = self.below(20)
        if what < 5:
            self.live(p)
        elif what < 10:
            (self.exchange if p.exchange == (what < 9) else self.go)(p)
        elif what < 15:
            self.transfer(p, setting=what < 13)
        elif what < 18:
            self.remember(p)
        elif what < 19:
            (self.differentiate if self.below(3) else self.speak)(p)
        elif self.rarely():
            self.free(p)  # with the states that were not freed
            self.pairs[self.pairs.index(p)] = self.pair()

    def run(self, seed):
        self.seed, self.draw = seed, random.Random(seed)  # noqa: S311 - no secret
        self.pairs = [self.pair() for _ in range(PAIRS)]
        for _ in range(20 + self.below(60)):
            self.act(self.draw.choice(self.pairs))
        for p in self.pairs:
            self.free(p)


def main(library, model, first, count):
    caller = Caller(library, json.loads(Path(model).read_text()))
    for seed in range(int(first), int(first) + int(count)):
        caller.run(seed)
    sys.stdout.write(f"{caller.calls} {caller.unlawful} {caller.hash.hexdigest()}\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
