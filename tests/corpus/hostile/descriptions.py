"""Descriptions that contradict the standard or themselves."""

from functools import partial
from pathlib import Path

from tests.corpus.hostile.case import Case
from tests.corpus.hostile.sound import describe, fmu, members, replaced, spoils, spoilt
from tests.corpus.hostile.zips import Member, zipped

_three = partial(spoilt, version=3)


_version = spoils(7, "version", 'fmiVersion="2.0"')
_VERSIONS = [
    _version("missing", "no fmiVersion", "fmiVersion is", ""),
    _version("1", "FMI 1.0", "has no function reference_fmiInstantiateSlave", 'fmiVersion="1.0"'),
    _version("digits", "Arabic digits", "fmiVersion is", 'fmiVersion="\u0663.\u0660"'),
    spoilt(7, "version-2-as-3", "FMI 2.0 that says 3.0", "no binary", ('"2.0"', '"3.0"')),
    _three(7, "version-3-as-2", "FMI 3.0 that says 2.0", "no binary", ('"3.0"', '"2.0"')),
]


_reference = spoils(8, "reference", 'valueReference="6"')
_NAMES = [
    _reference("large", "one above 2^32 - 1", "4294967296, expected", 'valueReference="4294967296"'),
    _reference("negative", "a negative one", "is -1, expected", 'valueReference="-1"'),
    _reference("none", "none", "no valueReference", ""),
]  # fmt: skip

_STRUCTURE = [
    _three(9, "indicator-3", "an event indicator that is not there", "is 99", ('EventIndicator valueReference="9"', 'EventIndicator valueReference="99"')),
]  # fmt: skip


_identifier = spoils(
    10, "identifier", '<CoSimulation modelIdentifier="reference"', "<CoSimulation {}"
)


def _system(group: int, name: str, about: str, says: str, attributes: str) -> Case:
    """Return a case of a package with one component; an FMU lies in it and another beside it."""
    top = "http://ssp-standard.org/SSP1/SystemStructureDescription"
    ssd = (
        f'<s:SystemStructureDescription xmlns:s="{top}" version="1.0" name="a">'
        f'<s:System name="a"><s:Elements><s:Component {attributes}/>'
        "</s:Elements></s:System></s:SystemStructureDescription>"
    )

    def package(_: Path) -> bytes:
        inner = Member(b"resources/a.fmu", zipped(members()))
        return zipped([Member(b"SystemStructure.ssd", ssd.encode()), inner])

    files = {"a.fmu": lambda _: zipped(members()), "a.ssp": package}
    return Case(group, name, about, says, "simulate a.ssp", files)


_IDENTIFIERS = [
    _identifier("up", "../../../evil", "modelIdentifier is", 'modelIdentifier="../../../evil"'),
    _identifier("missing", "none at all", "modelIdentifier is", ""),
    _identifier("long", "10,000 letters", "modelIdentifier is", f'modelIdentifier="{"a" * 10_000}"'),
    _identifier("device", "a device of Windows", "modelIdentifier is", 'modelIdentifier="con"'),
]  # fmt: skip


_times = spoils(11, "times", 'startTime="0" stopTime="2" tolerance="1e-6" stepSize="0.1"')
_number = spoils(11, "number", 'min="0" max="10" start="2"')
_NUMBERS = [
    spoilt(11, "indicators", "indicators that are no number", "numberOfEventIndicators", ('numberOfEventIndicators="1"', 'numberOfEventIndicators="many"')),
    spoilt(11, "indicators-many", "ten trillion indicators", "numberOfEventIndicators", ('numberOfEventIndicators="1"', 'numberOfEventIndicators="9999999999999"')),
    _times("infinite-stop", "a stop that is infinite", "must be finite", 'stopTime="INF" stepSize="0.1"'),
    _times("nan-step", "a step that is NaN", "must be finite", 'stopTime="1" stepSize="NaN"'),
    _times("no-step", "a step of 0", "must be positive", 'stopTime="1" stepSize="0"'),
    _times("stop-first", "a stop before the start", "after start", 'startTime="2" stopTime="1" stepSize="0.1"'),
    _times("no-time", "a stop at the start", "after start", 'startTime="1" stopTime="1" stepSize="0.1"'),
    _times("too-many", "1e15 steps", "steps of the interval", 'stopTime="1e9" stepSize="1e-6"'),
    _times("memory", "5e9 steps", "GB", 'stopTime="5e9" stepSize="1"'),
    _times("huge", "a time that steps do not move", "lost in rounding", 'startTime="1e17" stopTime="1.0000000000000002e17" stepSize="1e-1"'),
]  # fmt: skip


def _dimension(name: str, about: str, says: str, new: str, start: str = 'start="1"') -> Case:
    pairs = ('<Dimension valueReference="10"/>', new), ('start="1 2 3"', start)
    return _three(12, f"dimension-{name}", about, says, *pairs)


def _length(name: str, about: str, says: str, new: str) -> Case:
    old = 'causality="structuralParameter" variability="fixed" start="3"'
    return _three(12, f"length-{name}", about, says, (old, new), ('start="1 2 3"', 'start="1"'))


_STRUCTURAL = 'causality="structuralParameter" variability="fixed"'
_ARRAYS = [
    _dimension("0", "0 elements", "start is 0, expected", '<Dimension start="0"/>'),
    _dimension("huge", "10^18 elements", "expected an integer from 1", '<Dimension start="1000000000000000000"/>'),
    _dimension("product", "1000 x 1000 x 1000 elements", "too large", '<Dimension start="1000"/>' * 3),
    _dimension("neither", "a dimension of nothing", "either start or", "<Dimension/>"),
    _dimension("both", "a dimension twice", "either start or", '<Dimension start="3" valueReference="10"/>'),
    _dimension("missing", "a parameter that is not there", "refers to 99", '<Dimension valueReference="99"/>'),
    _dimension("float", "a length that is no integer", "refers to 6", '<Dimension valueReference="6"/>'),
    _length("0", "a structural parameter of 0", "length 'n' = 0", f'{_STRUCTURAL} start="0"'),
    _length("huge", "one of 2^64 - 1", "length 'n' = 18446744073709551615", f'{_STRUCTURAL} start="18446744073709551615"'),
    fmu(12, "length-set", "one set to 4 billion", "elements", lambda: zipped(describe(replaced(3), 3)), "--set n=4000000000"),
]  # fmt: skip


_called = spoils(13, "name", 'name="u"', 'name="{}"')


def _component(name: str, about: str, says: str, written: str) -> Case:
    attributes = f'name="{written}" source="resources/a.fmu"'
    return _system(13, f"component-{name}", about, says, attributes)


_CHARACTERS = [
    _called("formula", "an input that is a formula", "spreadsheets", "=cmd|' /C calc'!A0"),
    _called("at", "one that begins with @", "spreadsheets", "@SUM(1)"),
    _component("formula", "a component that is a formula", "spreadsheets", "=cmd"),
    _component("newline", "a newline in a component's name", "control characters", "a&#10;b"),
]  # fmt: skip

_COUNT = '<Int32 name="count" valueReference="8"'


def _clock(name: str, about: str, says: str, attributes: str) -> Case:
    """Return a case of an input clock, in FMI 3.0."""
    clock = f'<Clock name="c" valueReference="20" causality="input" {attributes}/>'
    return spoilt(9, f"clock-{name}", about, says, (_COUNT, clock + _COUNT), version=3)


def _start(name: str, about: str, says: str, parameter: str) -> Case:
    """Return a case of a further parameter, in FMI 3.0."""
    return spoilt(11, f"start-{name}", about, says, (_COUNT, parameter + _COUNT), version=3)


_BINARY = (
    '<Binary name="b" valueReference="21" causality="parameter" variability="fixed">{}</Binary>'
)
_CONSTANT = 'intervalVariability="constant"'
_FMI3 = [
    _clock("weekly", "a clock that ticks weekly", "intervalVariability is 'weekly', expected", 'intervalVariability="weekly"'),
    _clock("nan", "a clock that ticks every NaN s", "intervalDecimal is nan, expected a finite number", f'{_CONSTANT} intervalDecimal="NaN"'),
    _clock("resolution", "a clock that counts in parts of 0", "resolution is 0, expected at least 1", f'{_CONSTANT} intervalCounter="5" resolution="0"'),
    _clock("shift", "a clock that begins before time", r"shift of a clock is -1\.0 s", f'{_CONSTANT} intervalDecimal="1" shiftDecimal="-1"'),
]  # fmt: skip

TOLERATED = [
    spoilt(8, "name-twice", "two variables of one name", "second variable 'u'", ('"x"', '"u"')),
    _three(8, "alias-nameless", "an alias without a name", "name of a Alias", (' name="position"', "")),
    spoilt(8, "nameless-variable", "a variable without a name", "is missing", (' name="u"', "")),
    _three(8, "reference-twice", "one value reference for two, FMI 3.0", "has the valueReference of 'u'", ('valueReference="2"', 'valueReference="1"')),
    spoilt(9, "index-large", "an output behind the list", "index of Unknown is 99", ('index="5"', 'index="99"')),
    spoilt(9, "index-text", "output y", "index is 'y'", ('index="5"', 'index="y"')),
    spoilt(9, "dependency", "a dependency behind the list", "is 77", ('dependencies="2 3"', 'dependencies="2 77"')),
    spoilt(9, "initial", "an initial unknown behind the list", "is 77", ('"4" dependencies="2 3 7"', '"77"')),
    _three(9, "output-3", "an output that is not there, FMI 3.0", "is 99", ('Output valueReference="4"', 'Output valueReference="99"')),
    spoilt(9, "derivative", "derivative of a variable behind the list", "derivative of Real is 99", ('derivative="3"', 'derivative="99"')),
    spoilt(9, "own-derivative", "a derivative of itself", "derivative of itself", ('derivative="3"', 'derivative="4"')),
    spoilt(9, "derivatives-in-a-circle", "two that are each other's", "derivative of itself", ('derivative="3"', 'derivative="3"'), ('declaredType="Length" start="1"', 'derivative="4" start="1"')),
    spoilt(9, "type", "a type that is not defined", "declaredType of 'y' is 'Nothing'", ('initial="calculated"><Real declaredType="Length"/>', 'initial="calculated"><Real declaredType="Nothing"/>')),
    spoilt(9, "no-type", "a variable of no type", "has no type", ('<Real unit="m/s" start="0"/>', "")),
    spoilt(9, "empty-type", "a declared type of nothing", "SimpleType is empty", ('<Real quantity="Length" unit="m" displayUnit="mm" min="-1000" max="1000" nominal="1"/>', "")),
    _three(9, "tag", "an unknown type, FMI 3.0", "Float128 'u' has no type", ('<Float64 name="u"', '<Float128 name="u"')),
    spoilt(9, "causality", "a causality that there is not", "does not allow: 'master'", ('causality="input"', 'causality="master"')),
    spoilt(9, "fixed-output", "an output that is fixed", "read as a discrete output", ('causality="output" variability="discrete" initial="exact"', 'causality="output" variability="fixed"')),
    spoilt(9, "parameter", "a parameter that varies", "read as a fixed parameter", ('causality="parameter" variability="fixed" initial="exact"', 'causality="parameter"')),
    spoilt(9, "combination", "a constant input", "does not allow: 'input', 'constant'", ('causality="input" variability="continuous"', 'causality="input" variability="constant"')),
    _number("outside", "a start above max", "outside its range 0", 'min="0" max="10" start="11"'),
    _number("no-start", "a start that is NaN", "start of 'k' is nan", 'min="0" start="NaN"'),
    _number("no-range", "min above max", "above its max", 'min="10" max="0" start="5"'),
    _number("text-start", "a start that is text", "is 'two', expected a number", 'start="two"'),
    spoilt(11, "nominal-0", "a nominal value of 0", "nominal of 'd' is 0", ('nominal="0.5"', 'nominal="0"')),
    spoilt(11, "nominal-infinite", "an infinite one", "nominal of 'd' is inf", ('nominal="0.5"', 'nominal="INF"')),
    spoilt(11, "whole", "half a count", "expected an integer", ('<Integer min="0" start="0"/>', '<Integer min="0" start="0.5"/>')),
    spoilt(11, "unit", "a unit of factor 0", "factor is 0", ('m="1"/><DisplayUnit', 'm="1" factor="0"/><DisplayUnit')),
    spoilt(11, "exponent", "a unit of half a metre", "expected an integer", ('<BaseUnit m="1"/>', '<BaseUnit m="0.5"/>')),
    spoilt(11, "unit-nameless", "a unit of an empty name", "name of a Unit is missing", ('Unit name="1/s"', 'Unit name=""')),
    spoilt(11, "item", "an item of an enumeration that is text", "value of an Item", ('name="first" value="1"', 'name="first" value="one"')),
    _times("text", "a start time that is text", "startTime is 'soon'", 'startTime="soon" stopTime="1"'),
    _times("tolerance", "a tolerance that is text", "tolerance is 'small'", 'stopTime="1" tolerance="small"'),
    _dimension("starts", "two start values for three", "2 values, expected 3", '<Dimension start="3"/>', 'start="1 2"'),
    _called("newline", "a newline in a name", "control characters", "u&#10;stickslip: all is well"),
    _called("separator", "a line separator of Unicode", "control characters", "u&#x2028;v"),
    _called("c1", "a control character beyond ASCII", "control characters", "u&#x9b;31m"),
    spoilt(13, "name-unit", "a newline in a unit", "control characters", ('Unit name="1/s"', 'Unit name="1&#10;s"')),
    spoilt(9, "clocks-nothing", "a variable of a clock that is none, in FMI 3.0", "clocks has '99', which is no clock", (_COUNT, f'{_COUNT} clocks="99"'), version=3),
    spoilt(8, "alias-taken", "an alias that has the name of a variable", "a second variable 'u'", ('<Alias name="position"', '<Alias name="u"'), version=3),
    _start("no-digits", "binary data that is text", "start of 'b' is '0g', expected hexadecimal", _BINARY.format('<Start value="0g"/>')),
]  # fmt: skip
"""Cases of which no run needs what is wrong: a warning says so, and they run."""

CASES = [
    *(*_VERSIONS, *_NAMES, *_STRUCTURE, *_IDENTIFIERS, *_NUMBERS, *_ARRAYS, *_CHARACTERS),
    *_FMI3,
]
