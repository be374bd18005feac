"""Sound descriptions are read as FMPy reads them; odd ones that are lawful are taken."""

import csv
import io
import time

import fmpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip import cosim
from stickslip.cli import main
from stickslip.fmi.description import DescriptionFault, read_description
from stickslip.fmi.xml import Malformed, parse_xml
from tests.corpus.hostile.sound import describe, replaced
from tests.corpus.hostile.zips import zipped
from tests.cosim.single import one

HEAD = '<?xml version="1.0" encoding="UTF-8"?>'


def read(version, *pairs):
    return read_description(parse_xml(replaced(version, *pairs)))


@pytest.fixture(params=[2, 3])
def both(request, tmp_path):
    """Return a sound description as we and as FMPy read it."""
    (tmp_path / "modelDescription.xml").write_bytes(replaced(request.param))
    theirs = fmpy.read_model_description(tmp_path, validate=False)
    return read(request.param), theirs


def number(text):
    return None if text is None else float(text)


def test_variables_are_those_of_fmpy(both):
    ours, theirs = both
    described = {v.name: v for v in theirs.modelVariables if v.alias is None}
    assert list(ours.variables) == list(described)
    for name, variable in described.items():
        mine, declared = ours.variables[name], variable.declaredType
        assert (mine.reference, mine.type) == (variable.valueReference, variable.type)
        assert (mine.causality, mine.variability) == (variable.causality, variable.variability)
        assert mine.initial == variable.initial
        assert mine.dimensions == variable.shape
        assert mine.unit == (variable.unit or getattr(declared, "unit", None))
        assert mine.nominal == number(variable.nominal or getattr(declared, "nominal", None))
        if not mine.dimensions:
            assert mine.start == number(variable.start)
    aliases = {v.name: v.alias.name for v in theirs.modelVariables if v.alias is not None}
    assert ours.aliases == aliases


def test_structure_is_that_of_fmpy(both):
    ours, theirs = both
    assert [(o.name, o.dependencies) for o in ours.outputs] == [
        (o.variable.name, tuple(d.name for d in o.dependencies)) for o in theirs.outputs
    ]
    assert ours.derivatives == {
        u.variable.name: u.variable.derivative.name for u in theirs.derivatives
    }
    assert ours.n_states == theirs.numberOfContinuousStates
    assert ours.n_indicators == theirs.numberOfEventIndicators
    assert (ours.name, ours.token) == (theirs.modelName, theirs.guid)
    assert ours.experiment.stop == number(theirs.defaultExperiment.stopTime)


def test_variables_of_fmi_2_may_be_one_quantity():
    pair = ('name="z" valueReference="5"', 'name="z" valueReference="4"')
    assert read(2, pair).variables["z"].reference == 4
    assert "has the valueReference of 'y'" in read(3, pair).remarks[0]


NAMES = st.text(st.characters(codec="utf-8", exclude_categories=["C", "Z"]), min_size=1)


@given(NAMES.filter(lambda name: name not in read(2).variables))
def test_names_are_kept_as_they_are(name):
    quoted = name.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    assert list(read(2, ('name="u"', f'name="{quoted}"')).variables)[1] == name


@given(st.binary(max_size=200) | st.text(max_size=200).map(str.encode))
def test_a_doctype_is_never_read(noise):
    hidden = replaced(2).replace(HEAD.encode(), HEAD.encode() + noise + b"<!DOCTYPE a>")
    with pytest.raises(Malformed):
        parse_xml(hidden)


def written(tmp_path, *pairs):
    path = tmp_path / "a.fmu"
    path.write_bytes(zipped(describe(replaced(2, *pairs))))
    return path


@pytest.mark.parametrize("name", ["\u5165\u529b 'x', \"y\";\u00fc", "a" * 10_000, "u,=1+1"])
def test_strange_names_reach_the_table_unchanged(tmp_path, name):
    path = written(tmp_path, ('name="u"', f'name="{name.replace(chr(34), "&quot;")}"'))
    assert main(["simulate", str(path), "--out", str(tmp_path / "a.csv")]) == 0
    header = next(csv.reader(io.StringIO((tmp_path / "a.csv").read_text("utf-8"))))
    assert name in header
    assert not any(column.startswith(("=", "+", "-", "@")) for column in header)


def test_names_stay_apart_and_each_reaches_its_variable():
    description = read(2, ('name="z"', 'name="y"'), ('name="d"', 'name=""'))
    of = {name: v.reference for name, v in description.variables.items()}
    assert (of["y"], of["y#5"], of["#7"]) == (4, 5, 7)
    assert len(description.remarks) == 2


def test_many_remarks_are_few_lines():
    rows = "".join(
        f'<ScalarVariable name="v{i}" valueReference="{i}"><Real nominal="0"/></ScalarVariable>'
        for i in range(100)
    )
    lines = read(2, ("</ModelVariables>", f"{rows}</ModelVariables>")).remarks
    assert (len(lines), lines[-1]) == (21, "80 more")


@pytest.mark.parametrize(
    ("part", "each"),
    [
        ("</ModelVariables>", '<ScalarVariable name="v{}" valueReference="1"/>'),
        ("</UnitDefinitions>", '<Unit name="u{}"/>'),
    ],
)  # fmt: skip
def test_a_million_elements_are_refused_before_they_are_read(part, each):
    data = replaced(2, (part, "".join(map(each.format, range(500_000))) + part))
    begin = time.process_time()
    with pytest.raises(Malformed, match="more than 500000 elements"):
        parse_xml(data)
    assert time.process_time() - begin < 1.0  # 8 to 28 s when they were read


def test_infinite_times_can_be_mended(tmp_path):
    path = written(tmp_path, ('stopTime="2"', 'stopTime="INF"'))
    assert main(["simulate", str(path)]) == 1
    assert main(["simulate", str(path), "--stop", "1"]) == 0


def test_an_array_too_large_is_refused_by_its_parameter(tmp_path):
    path = tmp_path / "a.fmu"
    path.write_bytes(zipped(describe(replaced(3), 3)))
    system = one(path)
    with pytest.raises(cosim.ParameterError, match="w would have 1000001 elements"):
        system.set("a.n", 1_000_001)
    with pytest.raises(cosim.ParameterError, match="w would have 0 elements"):
        system.set("a.n", 0)
    assert system.parameters == {}
    system.set("a.n", 7)
    assert system.variable("a.w").dimensions == (7,)


def annotated(version, parameter, variable):
    """Return a description whose annotation says what is learned."""
    state = f'<State parameter="{parameter}" variable="{variable}"/>'
    entry = f'<Learned model="a">{state}</Learned>'
    if version == 2:
        place, tool = "<ModelVariables>", f'<Tool name="stickslip">{entry}</Tool>'
        return read(2, (place, f"<VendorAnnotations>{tool}</VendorAnnotations>{place}"))
    place, tool = "</fmiModelDescription>", f'<Annotation type="stickslip">{entry}</Annotation>'
    return read(3, (place, f"<Annotations>{tool}</Annotations>{place}"))


@pytest.mark.parametrize("version", [2, 3])
def test_an_annotation_says_what_is_learned(version):
    found = annotated(version, "k", "x").learned
    assert (found.model, found.variables) == ("a", {"k": "x"})
    assert read(version).learned.variables == {}
    for parameter, variable in (("k", "nothing"), ("nothing", "x"), ("", "")):
        with pytest.raises(DescriptionFault, match="are not variables of the same size"):
            annotated(version, parameter, variable)


def test_of_an_array_all_elements_are_learned():
    names = {f"w[{i}]": f"w[{i}]" for i in (1, 2, 3)}
    assert annotated(3, "w", "w").learned.variables == names
    with pytest.raises(DescriptionFault, match="are not variables of the same size"):
        annotated(3, "w", "x")
