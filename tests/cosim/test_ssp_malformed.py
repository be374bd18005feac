"""Packages that are wrong end in one line that names the package, the member and the line."""

from __future__ import annotations

import zipfile

import pytest

from stickslip import cosim

NAMES = {
    "ssd": "SystemStructureDescription",
    "ssc": "SystemStructureCommon",
    "ssv": "SystemStructureParameterValues",
}
OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"
GAIN = '<ssd:Component name="a" source="resources/gain.fmu">{}</ssd:Component>'


def root(name, rest, version="1.0"):
    declared = "".join(f' xmlns:{p}="http://ssp-standard.org/SSP1/{n}"' for p, n in NAMES.items())
    return f'<{name} version="{version}" name="s"{declared}>{rest}</{name}>'


PLAIN = GAIN.format("")


def structure(elements=PLAIN, rest="", connections="", **version):
    body = f'<ssd:System name="s"><ssd:Elements>{elements}</ssd:Elements>{connections}</ssd:System>'
    return root("ssd:SystemStructureDescription", body + rest, **version)


def source(text):
    return structure(f'<ssd:Component name="a" source="{text}"/>')


def nested(kind, text):
    of = f'type="application/x-ssp-{kind}" source="{text}"'
    return structure(f'<ssd:Component name="n" {of}/>')


def binding(text, inside=""):
    content = (
        f'<ssd:ParameterBinding source="{text}">{inside}</ssd:ParameterBinding>'
        if text
        else "<ssd:ParameterBinding/>"
    )
    return structure(GAIN.format(f"<ssd:ParameterBindings>{content}</ssd:ParameterBindings>"))


def experiment(attributes="", step=None, declared=f'xmlns:osp="{OSP}"'):
    annotation = (
        '<ssd:Annotations><ssc:Annotation type="com.opensimulationplatform">'
        f'<osp:Algorithm {declared}><osp:FixedStepAlgorithm baseStepSize="{step}"/>'
        "</osp:Algorithm></ssc:Annotation></ssd:Annotations>"
    )
    inside = annotation if step is not None else ""
    return structure(rest=f"<ssd:DefaultExperiment {attributes}>{inside}</ssd:DefaultExperiment>")


def connected(unit):
    connector = f'<ssd:Connector name="y" kind="output"><ssc:Real unit="{unit}"/></ssd:Connector>'
    a = GAIN.format(f"<ssd:Connectors>{connector}</ssd:Connectors>")
    connection = '<ssd:Connection startElement="a" startConnector="y" endElement="b"'
    return structure(
        a + GAIN.format("").replace('"a"', '"b"'),
        connections=f'<ssd:Connections>{connection} endConnector="u"/></ssd:Connections>',
    )


LATER = "<ssd:Connectors><ssd:Connector name='u' kind='input'><ssc:Float64/></ssd:Connector>"
LATER = structure(GAIN.format(LATER + "</ssd:Connectors>"))
BAD = [
    (source("../../x.fmu"), "lies outside the package; .* copy it into resources/"),
    (source("http://host/x.fmu"), "lies outside the package"),
    (source("proxyfmu://localhost?file=a.fmu"), "lies outside the package"),
    (source("%00"), "names no file"),
    (source("x" * 5000), "names no file"),
    (source("resources"), "is missing from the package"),
    (structure('<ssd:Component name="a"/>', version="2.0"), "'a' has no source"),
    (binding("x.ssv"), r"'x\.ssv' is missing"),
    (binding("a.ssv", '<ssd:ParameterMapping source="x.ssm"/>'), r"'x\.ssm' is missing"),
    (binding("SystemStructure.ssd"), "root element is .*expected .*ParameterSet"),
    (binding("text.ssv"), r"text\.ssv: Start tag expected"),
    (binding(""), "ssd:ParameterValues/ssv:ParameterSet is missing"),
    (nested("definition", "SystemStructure.ssd"), "'n' contains itself"),
    (nested("definition", "ring.ssd"), "'n/n' contains itself"),
    (nested("package", "resources/gain.fmu"), r"has no SystemStructure\.ssd"),
    (nested("package", "text.ssv"), "line 1: .*not a zip archive"),
    (experiment(step=0.1, declared=""), f"osp on Algorithm .*declare it .*xmlns:osp=.{OSP}"),
    (experiment(step=-1), r"baseStepSize is -1\.0 s, expected a positive"),
    (experiment('startTime="5" stopTime="1"'), r"stopTime is 1\.0 s, expected a time after"),
    (experiment('stopTime="INF"'), "expected a finite number"),
    (structure().replace("/SSP1/", "/SSP2/"), "root element is .*SSP2.*in SSP 1.0 and 2.0 alike"),
    (connected("furlong"), "no file defines what 'furlong' is"),
]


@pytest.fixture
def pack(make, tmp_path):
    def pack(text):
        path = tmp_path / "packed.ssp"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("SystemStructure.ssd", text)
            archive.writestr("ring.ssd", nested("definition", "SystemStructure.ssd"))
            archive.writestr("a.ssv", root("ssv:ParameterSet", "<ssv:Parameters/>"))
            archive.writestr("text.ssv", "text")
            archive.write(make("gain"), "resources/gain.fmu")
        return path

    return pack


@pytest.mark.parametrize(("text", "message"), BAD, ids=[message for _, message in BAD])
def test_it_ends_in_one_line(pack, text, message):
    with pytest.raises(cosim.SspError, match=rf"packed\.ssp: .*{message}") as error:
        cosim.read_ssp(pack(text))
    assert "\n" not in str(error.value)


def test_what_a_later_version_allows_is_said(pack):
    pytest.importorskip("pyssp_standard")
    with pytest.raises(cosim.SspError, match=r"ssc:Float64.*SSP 2\.0 allows this: set version"):
        cosim.read_ssp(pack(LATER))


def test_no_stop_time_is_no_fault(pack):
    assert cosim.read_ssp(pack(experiment('startTime="1"')))[1] == cosim.DefaultExperiment(1.0)
