"""The blocks of a drive behind one call, and structured text as XML of PLCopen."""

import ctypes
import re
from dataclasses import replace

import numpy as np
import pytest
from lxml import etree

from stickslip import models
from stickslip.fmi import toolchain
from stickslip.models.firmware import write_combined
from tests.models.firmware import structured_text
from tests.models.firmware.test_every_compensator import STARTS, STRICT, N, signals

SIGNALS = ["v_cmd", "x_cmd", "a_cmd", "x_enc", "F_m"]
PARTS = {
    "compensator": ("command_feedforward", "lugre", "command_lugre"),
    "position_force": ("position_force", None, "position_force"),
    "observer": ("dob", None, "observer"),
}
CHAINS = [[*PARTS], ["observer"], ["position_force"]]


WIRES = {
    "compensator": ("F_ff", "Compensator", "u[0], u[1], u[2]"),
    "position_force": ("F", "PositionForce", "5e-4, u[3], {F}"),
    "observer": ("F", "Observer", "u[3], u[4], {v_r}, {F}"),
}


def blocks(chain):
    for called in chain:
        model, law, case = PARTS[called]
        start = STARTS[case] | ({"onset": 2e-4} if called == "observer" else {})  # v_r matters
        yield replace(models.load_model(model, law).with_start(start), name=called)


def driver(chain):
    """Return C that runs the call, and the blocks one by one as docs/deploying.md connects them."""
    begin, step, declared, F, v_r = "", "", "", "0.0", "u[0]"
    for name in chain:
        output, type_, inputs = WIRES[name]
        given = inputs.format(F=F, v_r=v_r)
        declared += f"{type_} {name};\n"
        begin += f"{name}_init(&{name}, {given.removeprefix('5e-4, ')});\n"
        step += f"{name}_step(&{name}, {given});\n"
        F = f"{name}.outputs.{output}"
        v_r = "compensator.outputs.v_r" if name == "compensator" else v_r
    return f"""
#include "added_force.h"
__attribute__((visibility("default"))) int drive(int n, const double *u, double *out);
int drive(int n, const double *u, double *out) {{
    int finite = 0;
    AddedForce all;
    {declared}
    added_force_init(&all, u[0], u[1], u[2], u[3], u[4]);
    {begin}
    for (int i = 0; i < n; i++, u += 5, out += 3) {{
        finite += added_force_step(&all, u[0], u[1], u[2], u[3], u[4]);
        {step}
        out[0] = all.F;
        out[1] = {F};
        out[2] = {"compensator.outputs.F_ff" if "compensator" in chain else "0.0"};
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
    out = np.empty((N, 3))
    pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in (given, out)]
    assert library.drive(N, *pointers) == N
    assert np.ptp(out[:, 0]) > 1.0  # N
    np.testing.assert_array_equal(out[:, 0], out[:, 1])
    (path,) = write_combined(tmp_path, "st", list(blocks(chain)))
    block = structured_text.load(path.read_text())["Added_force"]
    for again in (False, True):
        for k, (row, expected) in enumerate(zip(given[:200], out, strict=False)):
            reset = again and k == 0
            scope = block(reset=reset, **dict(zip(SIGNALS, map(float, row), strict=True)))
            assert scope["valid"]
            np.testing.assert_allclose(scope["F"], expected[0], rtol=0, atol=1e-7)
            np.testing.assert_allclose(scope.get("F_ff", 0.0), expected[2], rtol=0, atol=1e-7)
        assert ("F_ff" in scope) == ("compensator" in chain)
        if "observer" in chain:  # what is not a number stays in its memory
            assert not block(x_enc=np.nan)["valid"]
            assert not block(x_enc=0.0)["valid"]


def test_one_name_makes_all_blocks_compute_in_float(tmp_path):
    """Numbers go from block to block without a conversion, of which the flags would warn."""
    paths = write_combined(tmp_path, "c", list(blocks(PARTS)))
    sizes = " + ".join(f"sizeof({name}_real)" for name in PARTS)
    files = {path.name: path.read_text() for path in paths}
    files["sizes.c"] = f"""
#include "added_force.h"
__attribute__((visibility("default"))) int sizes(void);
int sizes(void) {{ return (int)({sizes}); }}
"""
    found = [
        ctypes.CDLL(str(toolchain.shared_library("sizes", files, flags=[*STRICT, *flags]))).sizes()
        for flags in ([], ["-DSTICKSLIP_FLOAT"])
    ]
    assert found == [8 * len(PARTS), 4 * len(PARTS)]


def test_a_block_with_a_signal_of_a_search_is_refused(tmp_path):
    with pytest.raises(models.UnknownModel, match="'u' is not among its inputs v_cmd"):
        write_combined(tmp_path, "c", [models.load_model("lffc")])
    assert not list(tmp_path.iterdir())


FORMS = {  # of structured text, by the tag or the kind of a program unit
    "dataType": "TYPE {name} : {inner} END_TYPE",
    "struct": "STRUCT {inner} END_STRUCT;",
    "array": "ARRAY {inner};",
    "dimension": "[{lower}..{upper}] OF",
    "function": "FUNCTION {name} {inner} END_FUNCTION",
    "functionBlock": "FUNCTION_BLOCK {name} {inner} END_FUNCTION_BLOCK",
    "returnType": ": {inner}",
    "localVars": "VAR {inner} END_VAR",
    "inputVars": "VAR_INPUT {inner} END_VAR",
    "outputVars": "VAR_OUTPUT {inner} END_VAR",
    "inOutVars": "VAR_IN_OUT {inner} END_VAR",
    "variable": "{name} : {inner};",
    "derived": "{name}",
    "initialValue": ":= {inner}",
    "arrayValue": "[{inner}]",
    "simpleValue": "{value}",
    "documentation": "",
}


def text_of(node):
    tag = etree.QName(node).localname
    inner = (", " if tag == "arrayValue" else " ").join(map(text_of, node)) or node.text or tag
    return FORMS.get(node.get("pouType", tag), "{inner}").format(inner=inner, **node.attrib)


def units(text):
    words = " ".join(structured_text.words(text))
    return sorted(re.findall(r".*?END_(?:TYPE|FUNCTION|FUNCTION_BLOCK)\b", words))


def test_xml_of_plcopen_contains_the_structured_text(tmp_path):
    """Types, declarations with start values and bodies, word by word; the head is a comment."""
    stated = "learned on 2026-01-02 from", "exported with 3.4"
    for language in ("st", "plcopen"):
        write_combined(tmp_path, language, list(blocks(PARTS)), notes=["a <b> & c", *stated])
    root = etree.parse(tmp_path / "added_force.xml").getroot()
    found = "\n".join(map(text_of, root.iter("{*}dataType", "{*}pou")))
    assert units(found) == units((tmp_path / "added_force.st").read_text())
    assert "a <b> & c" in root.findtext(".//{*}Comment")
    header = root.find("{*}fileHeader")
    assert header.get("creationDateTime") == "2026-01-02T00:00:00"
    assert header.get("productVersion") == "3.4"
