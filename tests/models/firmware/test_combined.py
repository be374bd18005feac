"""The blocks of a drive behind one call, and structured text as XML of PLCopen."""

import ctypes
import re
from dataclasses import replace

import numpy as np
import pytest
from lxml import etree

from stickslip import models
from stickslip.fmi import toolchain
from stickslip.models.firmware import write_combined, write_compensator
from tests.models.firmware import structured_text
from tests.models.firmware.test_every_compensator import STARTS, STRICT, N, signals

SIGNALS = ["v_cmd", "x_cmd", "a_cmd", "x_enc", "F_m"]
PARTS = {
    "compensator": ("command_feedforward", "lugre", "command_lugre"),
    "position_force": ("position_force", None, "position_force"),
    "observer": ("dob", None, "observer"),
}
CHAINS = [[*PARTS], ["observer"], ["position_force"]]


def blocks(chain):
    for called in chain:
        model, law, case = PARTS[called]
        yield replace(models.load_model(model, law).with_start(STARTS[case]), name=called)


def driver(chain):
    """Return C that runs the call, and the blocks one by one as docs/deploying.md connects them."""
    begin, step, F, v_r = "", "", "0.0", "u[0]"
    for name in chain:
        given = {
            "compensator": "u[0], u[1], u[2]",
            "position_force": f"u[3], {F}",
            "observer": f"u[3], u[4], {v_r}, {F}",
        }[name]
        begin += f"{name}_init(&{name}, {given});\n"
        h = "5e-4, " if name == "position_force" else ""
        step += f"{name}_step(&{name}, {h}{given});\n"
        F = f"{name}.outputs.{'F_ff' if name == 'compensator' else 'F'}"
        v_r = "compensator.outputs.v_r" if name == "compensator" else v_r
    types = {"compensator": "Compensator", "position_force": "PositionForce"}
    declared = "".join(f"{types.get(name, 'Observer')} {name};\n" for name in chain)
    return f"""
#include "added_force.h"
__attribute__((visibility("default"))) int drive(int n, const double *u, double *out);
int drive(int n, const double *u, double *out) {{
    int finite = 0;
    AddedForce all;
    {declared}
    added_force_init(&all, u[0], u[1], u[2], u[3], u[4]);
    {begin}
    for (int i = 0; i < n; i++, u += 5, out += 2) {{
        finite += added_force_step(&all, u[0], u[1], u[2], u[3], u[4]);
        {step}
        out[0] = all.F;
        out[1] = {F};
    }}
    return finite;
}}
"""


@pytest.mark.parametrize("chain", CHAINS, ids="+".join)
def test_one_call_gives_the_bits_of_the_blocks_one_by_one(tmp_path, chain):
    paths = write_combined(tmp_path, "c", list(blocks(chain)))
    files = {path.name: path.read_text() for path in paths} | {"driver.c": driver(chain)}
    library = ctypes.CDLL(str(toolchain.shared_library("combined", files, flags=STRICT)))
    given = np.column_stack([*signals(SIGNALS).values()])
    out = np.empty((N, 2))
    pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in (given, out)]
    assert library.drive(N, *pointers) == N
    assert np.ptp(out[:, 0]) > 1.0  # N
    np.testing.assert_array_equal(out[:, 0], out[:, 1])
    (path,) = write_combined(tmp_path, "st", list(blocks(chain)))
    block = structured_text.load(path.read_text())["Added_force"]
    for row, expected in zip(given[:200], out[:, 0], strict=False):
        scope = block(**dict(zip(SIGNALS, map(float, row), strict=True)))
        assert scope["valid"]
        np.testing.assert_allclose(scope["F"], expected, rtol=0, atol=1e-7)


def test_a_block_with_a_signal_of_a_search_is_refused(tmp_path):
    with pytest.raises(models.UnknownModel, match="'u' is not among its inputs v_cmd"):
        write_combined(tmp_path, "c", [models.load_model("lffc")])
    assert not list(tmp_path.iterdir())


SECTIONS = {"localVars": "", "inputVars": "_INPUT", "outputVars": "_OUTPUT", "inOutVars": "_IN_OUT"}


def test_xml_of_plcopen_contains_the_structured_text(tmp_path):
    """Types, declarations with start values and bodies, word by word; comments as documentation."""
    for language in ("st", "plcopen"):
        write_combined(tmp_path, language, list(blocks(PARTS)), notes=["a <b> & c"])
    root = etree.parse(tmp_path / "added_force.xml").getroot()
    found = map(unit, root.iter("{*}dataType", "{*}pou"))
    text = (tmp_path / "added_force.st").read_text()
    assert units("\n".join(found)) == units(text)
    assert "a <b> & c" in root.findtext(".//{*}Comment")
    assert "Position of the encoder" in etree.tostring(root, encoding="unicode")


def units(text):
    words = " ".join(structured_text.words(text))
    return sorted(re.findall(r".*?END_(?:TYPE|FUNCTION|FUNCTION_BLOCK)\b", words))


def unit(node):
    """Return a type or a program unit as structured text."""
    name = node.get("name")
    if node.tag.endswith("dataType"):
        (own,) = node.find("{*}baseType")
        if own.tag.endswith("struct"):
            return f"TYPE {name} : STRUCT {declarations(own)} END_STRUCT; END_TYPE"
        size = own.find("{*}dimension")
        of = type_of(own.find("{*}baseType"))
        return f"TYPE {name} : ARRAY[{size.get('lower')}..{size.get('upper')}] OF {of}; END_TYPE"
    kind = {"function": "FUNCTION", "functionBlock": "FUNCTION_BLOCK"}[node.get("pouType")]
    lines = []
    for part in node.find("{*}interface"):
        tag = etree.QName(part).localname
        if tag == "returnType":
            name += f" : {type_of(part)}"
        else:
            lines.append(f"VAR{SECTIONS[tag]} {declarations(part)} END_VAR")
    body = node.findtext("{*}body/{*}ST/{http://www.w3.org/1999/xhtml}xhtml")
    return "\n".join([f"{kind} {name}", *lines, body, f"END_{kind}"])


def declarations(node):
    found = []
    for one in node.iterfind("{*}variable"):
        start = one.find("{*}initialValue")
        begin = "" if start is None else f" := {value(start[0])}"
        found.append(f"{one.get('name')} : {type_of(one.find('{*}type'))}{begin};")
    return "\n".join(found)


def type_of(node):
    return node[0].get("name") or etree.QName(node[0]).localname


def value(node):
    if node.get("value") is not None:
        return node.get("value")
    return f"[{', '.join(value(one[0]) for one in node)}]"


def test_a_block_as_xml_has_its_start_values(tmp_path):
    (path,) = write_compensator(tmp_path, "plcopen", start={"F_c": 7.25})
    variables = etree.parse(path).getroot().iterfind(".//{*}inputVars/{*}variable[@name='F_c']")
    assert "7.25" in [value(one.find("{*}initialValue")[0]) for one in variables]
