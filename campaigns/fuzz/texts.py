"""Parsers of texts: tables, logs, _JSON, TOML and the files of a system structure package."""

import json
import math
import re
from functools import cache, partial
from pathlib import Path
from unittest import mock

from campaigns.fuzz.campaign import Parser, text
from campaigns.fuzz.mutation import by_tokens
from stickslip import cosim, ga, models
from stickslip.cosim.ssp.markup import violation
from stickslip.cosim.ssp.read import read_package
from stickslip.cosim.ssp.structure import Package
from stickslip.errors import StickslipError, UsageError
from stickslip.ga.execution import checkpoint
from stickslip.learned.file import LearnedFile
from stickslip.logs import Description, load_description, raise_errors, read_and_check
from stickslip.models.errors import LtiError
from stickslip.models.lti.system import read_lti
from stickslip.studies.fleet.table import read_fleet
from tests.corpus.defects.reference import members, pack
from tests.corpus.hostile.packages import (
    bound,
    component,
    connection,
    connector,
    document,
    structure,
)

PARSERS: dict[str, Parser] = {}


# simulate --input TABLE.csv

_TABLE = (
    *(b"time", b"u", b",", b";", b"\t", b'"', b"\n", b"\r", b"\r\n", b'""', b"\0", b"# ", b"\n\n"),
)


PARSERS["csv"] = text(
    "in.csv",
    cosim.read_tables,
    _TABLE,
    [
        b"time,u\n0,0\n0.5,1e-3\n1,2\n",
        b'\xef\xbb\xbf"time","a b",c\r\n0,1,2\r\n0,3,4\r\n1.5,-1,.5\r\n',
        b"u,time\n1,0\n",
        b"time,x[1],x[2],flag\n" + b"".join(b"%d,%d,0.1,1\n" % (k, k % 7) for k in range(40)),
    ],
    cosim.SignalError,
)


# learn --log LOG.csv: any dialect of text, up to the even grid

_LOG = (
    *(b",", b";", b"\t", b" ", b"|", b'"', b"\n", b"\r", b"#", b"%", b"[mm]", b"(deg)", b"/ s"),
    *(b"time", b"position", b"x", b"F", b"velocity", b"torque", b"2026-01-31T10:00:00.125", b"nan"),
    *(b"ms", b"counts", b"A", b"rpm", b"\xff\xfe", b"\xe4"),
)


def _rows(mark: str, end: str = "\n", point: str = ".") -> str:
    rows = (
        mark.join(f"{number:.9g}" for number in (k * 1e-2, math.sin(k / 9), math.cos(k / 9)))
        for k in range(60)
    )
    return end.join(rows).replace(".", point) + end


_DATED = "".join(f"2026-01-31T10:00:00.{k:03d},{k * k / 8e3},{-k / 8}\n" for k in range(30))


def read_log(file: Path) -> None:
    raise_errors(file, read_and_check(file, Description())[1])


PARSERS["log_csv"] = text(
    "log.csv",
    read_log,
    _LOG,
    [
        f"t,x,F\n{_rows(',')}".encode(),
        f"Zeit;Position;Kraft\r\ns;mm;N\r\n{_rows(';', chr(13) + chr(10), ',')}".encode("latin-1"),
        f"# a log\n# of a drive\ntime [ms]\tposition [deg]\ttorque [Nm]\n{_rows(chr(9))}".encode(),
        f"time position force\n{_rows('  ')}".encode("utf-16"),
        f"timestamp,position,force\n{_DATED}".encode(),
        _rows(" ").encode(),
    ],
    StickslipError,
)


# fleet TABLE.csv

_load = cache(models.load_model)  # which does not depend on the input
_FLEET = (
    *(b",", b"\n", b"\r", b'"', b"'", b"\\", b"=", b"drive.", b"F_c", b"m", b"noise", b"on"),
    *(b"name", b"log", b"config", b"set", b"\0", b"a.csv", b"../x", b"sigma_0", b"#", b" "),
)


def fleet(file: Path) -> None:
    with mock.patch("stickslip.models.load_model", _load):
        read_fleet(file)


PARSERS["fleet"] = text(
    "fleet.csv",
    fleet,
    _FLEET,
    [
        b"name,log,config\na,a.csv,a.toml\nb,sub/b.mat,\n",
        b'\xef\xbb\xbfname,set\r\nx,"drive.m=10 drive.noise=on"\r\ny,drive.F_c=5\r\n',
        b"name,log,set\na,a.csv,\nb,,drive.b=20 drive.sigma_0=1e6\n",
    ],
    UsageError,
)


# --parameters learned.json, --resume of a checkpoint, export lti SYSTEM.json

_JSON = (
    *(b"[", b"]", b"{", b"}", b":", b",", b'"', b'""', b"null", b"true", b"NaN", b"-Infinity"),
    *(
        b'"value"',
        b'"unit"',
        b'"F_c"',
        b'"loop"',
        b'"seed"',
        b'"evaluations"',
        b'"genes"',
        b"1e999",
    ),
    *(b'"\\ud800"', b'"\\u0000"', b"[" * 2000, b'{"a":' * 500, b'"feed"', b'"velocity"', b"0"),
)


def _algorithm() -> ga.Optimiser:
    genes = [ga.Gene("a", 0.0, 2.0, 1.0, linear=True), ga.Gene("b", 1.0, 10.0, 5.0, "m")]
    return ga.GeneticAlgorithm(genes, ga.Settings(population=4, surrogates=False), seed=7)


def _checkpoint() -> bytes:
    algorithm = _algorithm()
    for _ in range(2):
        algorithm.tell(algorithm.ask().sum(axis=1))
    return json.dumps({"about": "", **algorithm.state()}).encode()


RESULTS = Path(__file__).parents[2] / "results" / "paper"
_SYSTEM = {"A": [[-1.0]], "B": [[1.0]], "C": [[1.0]], "D": [[0.0]], "inputs": {"u": "N"}}


def _adapted() -> bytes:
    """Return a learned.json with what a compensator learned while it ran."""
    document = json.loads((RESULTS / "learned.json").read_bytes())
    weights = {"s_0": 0.75, "rate": 0.05, "q_min": 2e-4}
    document["components"] = {"scale": {"model": "adaptive_scale", "parameters": weights}}
    return json.dumps(document).encode()


def read_json(file: Path) -> None:
    data = file.read_bytes()
    if b"evaluations" in data and b"genes" in data and b"standard_error" not in data:
        _algorithm().replay(checkpoint.read(file, ""))
    elif b"parameters" in data:
        learned = LearnedFile(file)
        for entry in (
            "compensator",
            "drive",
            "drive_errors",
            "standard_errors",
            "feed",
            "loop",
            "validation",
            "datasheet",
            "behind",
        ):
            getattr(learned, entry)
    else:
        read_lti(file)


PARSERS["json"] = text(
    "in.json",
    read_json,
    _JSON,
    [
        (RESULTS / "learned.json").read_bytes(),
        _adapted(),
        _checkpoint(),
        json.dumps(_SYSTEM).encode(),
        b'{"num": [1], "den": [1, 0.5], "dt": 0.1, "outputs": ["y"]}',
    ],
    UsageError,
    ga.StateError,
    LtiError,
)


# --config LOG.toml and export lti SYSTEM.toml

_TOML = (
    *(b"[", b"]", b"{", b"}", b"=", b".", b'"', b"'", b'"""', b"\n", b"#", b",", b"\\u0000"),
    *(b"columns", b"controller", b"motion", b"span", b"name", b"index", b"scale", b"true", b"nan"),
    *(b"1979-05-27T07:32:00Z", b"0x7f", b"-inf", b"[[a]]", b"a.b", b'"\\ud800"', b"A", b"B", b"D"),
    *(b"num", b"den", b"x0", b"inputs", b"[" * 2000, b"a." * 200, b"{a=" * 500),
)


def read_toml(file: Path) -> None:
    data = file.read_bytes()
    (read_lti if b"num" in data or b"D =" in data else load_description)(file)


PARSERS["toml"] = text(
    "in.toml",
    read_toml,
    _TOML,
    [
        b"""motion = "rotary"
encoder_step = 1e-6
force_limit = "2*kt"
sample_period = 0.001
span = [0.5, 20]
tau_i = 0
delimiter = ";"
decimal = ","
[columns]
time = "t"
position = {name = "x", unit = "mm"}
velocity = 3
[columns.force]
name = "i"
unit = "A"
scale = "kt*2"
offset = -0.1
[controller]
kind = "cascade"
K_x = 10
K_p = 3.5
K_i = "ki"
""",
        b'name = "s"\nA = [[0, 1], [-2, -3]]\nB = [[0], [1]]\nC = [[1, 0]]\nD = [[0]]\n'
        b'dt = 0.001\nx0 = [0, 1]\nstep = 0.01\nstop = 2\nstates = ["x", "v"]\n'
        b'[inputs]\nu = "N"\n[outputs]\ny = "m"\n',
        b"num = [1]\nden = [1, 0.5, 2.5]\n",
        b"num = [[[1], [2]], [[3], [4]]]\nden = [[[1, 1], [1, 2]], [[1, 3], [1, 4]]]\n",
    ],
    UsageError,
    LtiError,
)


# The XML files of an .ssp package: SystemStructure.ssd and an .ssv, .ssm and .ssb beside it

_BETWEEN = b"\n<!-- next file -->\n"
_FILES = ("SystemStructure.ssd", "resources/a.ssv", "resources/a.ssm", "resources/a.ssb")
_UNITS = (
    '<ssd:Units><ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit><ssc:Unit name="km/h">'
    '<ssc:BaseUnit m="1" s="-1" factor="0.2777777777777778"/></ssc:Unit></ssd:Units>'
)
_DICTIONARY = (
    '<ssd:SignalDictionaries><ssd:SignalDictionary name="bus" source="resources/a.ssb"/>'
    "</ssd:SignalDictionaries>"
)
_BINDING = bound(
    '<ssd:ParameterBinding source="resources/a.ssv" prefix="a."><ssd:ParameterMapping'
    ' source="resources/a.ssm"/></ssd:ParameterBinding>'
    "<ssd:ParameterBinding><ssd:ParameterValues>"
    + document(
        "ssv:ParameterSet",
        '<ssv:Parameters><ssv:Parameter name="b.k"><ssv:Real value="3" unit="1/s"/></ssv:Parameter>'
        '<ssv:Parameter name="b.mode"><ssv:Integer value="2"/></ssv:Parameter></ssv:Parameters>',
    )
    + "</ssd:ParameterValues></ssd:ParameterBinding>"
)


def _structure(version: str) -> str:
    """Return two components, one of them in a system of its own, and a dictionary between them."""
    fmi, metres = (2 if version == "1.0" else 3), '<ssc:Real unit="m"/>'
    ends = connector("v", "input", '<ssc:Real unit="km/h"/>') + connector("x", "output", metres)
    of_a, of_d = (connector(*which, metres) for which in (("y", "output"), ("z", "inout")))
    inner = (
        f'<ssd:System name="inner"><ssd:Connectors>{ends}</ssd:Connectors><ssd:Elements>'
        f"{component('c', fmu=fmi)}</ssd:Elements><ssd:Connections>{connection('v', 'c.u')}"
        f"{connection('c.y', 'x')}</ssd:Connections></ssd:System>"
    )
    elements = (
        component("a", f"<ssd:Connectors>{of_a}</ssd:Connectors>", fmu=fmi)
        + component("b", fmu=fmi)
        + '<ssd:SignalDictionaryReference name="d" dictionary="bus"><ssd:Connectors>'
        + f"{of_d}</ssd:Connectors></ssd:SignalDictionaryReference>{inner}"
    )
    scaled = '<ssc:LinearTransformation factor="2" offset="-1"/>'
    ways = [("v", "a.u"), ("b.y", "d.z"), ("d.z", "inner.v"), ("inner.x", "x")]
    return structure(
        elements,
        [connection("a.y", "b.u", scaled), *(connection(*way) for way in ways)],
        connectors=ends,
        before=_BINDING,
        behind=_DICTIONARY,
        rest=_UNITS,
        version=version,
    )


def _beside(version: str) -> tuple[str, str, str]:
    values = (
        '<ssv:Parameters><ssv:Parameter name="k"><ssv:Real value="1.5" unit="1/s"/></ssv:Parameter>'
        '<ssv:Parameter name="x0"><ssv:Real value="2"/></ssv:Parameter></ssv:Parameters>'
    )
    mapping = (
        '<ssm:MappingEntry source="a.k" target="a.k"><ssc:LinearTransformation factor="2"/>'
        '</ssm:MappingEntry><ssm:MappingEntry source="a.x0" target="b.d"/>'
    )
    entry = '<ssb:DictionaryEntry name="z"><ssc:Real unit="m"/></ssb:DictionaryEntry>'
    return (
        document("ssv:ParameterSet", values, version),
        document("ssm:ParameterMapping", mapping, version),
        document("ssb:SignalDictionary", entry, version),
    )


_TEXTS = (_structure("2.0") + "".join(_beside("1.0"))).encode()
_SSP = (
    *sorted(set(re.findall(rb"[\w:.]+", _TEXTS))),
    *(b"<", b"/>", b"</", b'"', b"&lt;", b"&a;", b"<!--", b"]]>", b"<![CDATA[", b"<?a?>"),
    *(b'<!DOCTYPE a [<!ENTITY a "b">]>', b"x[1]", b"w[2]", b"w", b"Boolean", b"Enumeration"),
    *(b"String", b"Float64", b"Int32", b"parameter", b"calculatedParameter", b"../a.fmu"),
    *(b"ssc:Dimension", b"ssc:IntegerMappingTransformation", b"ssc:MapEntry", b"mode", b"count"),
)


def _package(version: str) -> bytes:
    return _BETWEEN.join(part.encode() for part in (_structure(version), *_beside(version)))


@cache
def _fmus(folder: Path) -> None:
    (folder / "resources").mkdir(exist_ok=True)
    for version in (2, 3):
        pack(folder / "resources" / f"{version}.fmu", members(version))


_read = cache(cosim.Fmu)
_add = cosim.System.add


def _add_once(system: cosim.System, name: str, fmu: Path) -> None:
    """Add a component whose FMU is read but the first time."""
    _add(system, name, _read(fmu))


def read_ssp(data: bytes, folder: Path) -> None:
    _fmus(folder)
    for name, part in zip(_FILES, data.split(_BETWEEN), strict=False):
        (folder / name).write_bytes(part)
    with mock.patch("stickslip.cosim.System.add", _add_once), mock.patch(*_schemas(data)):
        read_package(Package(folder, folder))


def _schemas(data: bytes) -> tuple[str, object]:
    """Let half of the inputs meet no schema, as where those of SSP 2.0 are not installed."""
    return "stickslip.cosim.ssp.markup.violation", violation if len(data) % 2 else lambda *_: None


_packages = [_package("1.0"), _package("2.0")]
PARSERS["ssp"] = Parser(
    read_ssp, lambda: _packages, partial(by_tokens, words=_SSP), (cosim.CosimError,)
)
