"""What is printed or written of a log has the units of its drive and the values of learned.json.

Both drives are learned in an internal scale: a rotary one with small torques at high speeds, and a
small linear one. Their logs come from a program that shares nothing with ours.
"""

import html
import json
import re
import zipfile
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO

import numpy as np
import pytest

from campaigns.sound_drives import simulator
from stickslip.cli import main
from tests.kept import further

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("brief")]

# m, F_c, F_s, v_s, deflection, b, top speed
DRIVES = {
    "rotary": (5e-4, 0.02, 0.03, 0.3, 2e-3, 1e-4, 30.0),
    "linear": (0.05, 0.01, 0.015, 3e-5, 1e-6, 0.05, 1.5e-3),
}
UNITS = {
    "rotary": ("angle [rad]", "speed [rad/s]", "torque [N.m]", "velocity_command [rad/s]"),
    "linear": ("position [m]", "velocity [m/s]", "force [N]", "velocity_command [m/s]"),
}
ASKED = ("--compensator", "static+dob")
NUMBER = r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?"
OF_LINEAR = re.compile(
    rf"(?:(?<![\w.]){NUMBER}[ \u00a0]|\[|/\* (?=\S+ \*/)|nit=\"|nit\": \")"
    r"(N/[mµu]?m|N[ .]s/m|[mµuk]?N|kg|[mµun]?m/s2?|[mµun]?m)"
    r"(?![\w/.²^]|[ \u00a0](?:m|s|rad)\b)"
)
"""A number, or what else has a unit behind it, with a unit that no rotary drive has."""


def simulated(m, F_c, F_s, v_s, deflection, b, top, rate=120.0):
    """Return time, position, velocity, force and command of a PI velocity loop."""
    t = np.arange(6000) * 1e-3
    v_cmd = top * (0.5 * np.sin(2.5 * t) + 0.3 * np.sin(11.0 * t)) * np.where(t < 4.0, 1.0, 0.05)
    drive = {"m": m, "b": b, "F_c": F_c, "F_s": F_s, "v_s": v_s, "delta": 2.0, "T_s": 1e-3}
    drive |= {"sigma_0": F_c / deflection, "sigma_1": 0.7 * np.sqrt(F_c / deflection * m)}
    drive |= {"K_p": rate * m, "K_i": 0.25 * rate**2 * m}
    found = simulator.run("lugre", drive, v_cmd)
    return np.column_stack([t, found["x"], found["v"], found["force"], v_cmd])


@pytest.fixture(scope="module", params=["rotary", *further("linear")])
def output(request, tmp_path_factory):
    """Return the kind of the drive, learned.json, and all text by what printed or wrote it."""
    kind, folder = request.param, tmp_path_factory.mktemp(request.param)
    log, out = folder / "log.csv", folder / "out"
    head = ",".join(("time [s]", *UNITS[kind]))
    np.savetxt(log, simulated(*DRIVES[kind]), "%.9g", ",", header=head, comments="")
    learned = out / "learned.json"
    printed = {}
    for command in (
        ["learn", log, "--check"],
        ["learn", log, "--out", out, "--force", "-v", "--law", "lugre", *ASKED],
        *(
            ["export", what, "--parameters", learned, "--as", form, "--force", "--out", folder]
            for what in ("compensator", "observer")
            for form in ("fmu", "c", "st")
        ),
        ["validate", learned, "--log", log, "--out", folder / "validated"],
    ):
        with redirect_stdout(StringIO()) as said, redirect_stderr(StringIO()) as warned:
            assert main([str(word) for word in command]) == 0, warned.getvalue()
        printed[" ".join(map(str, command))] = said.getvalue() + warned.getvalue()
    return kind, json.loads(learned.read_text("utf-8")), printed | dict(written(folder, log))


def written(folder, log):
    for path in folder.rglob("*"):
        if path.suffix == ".fmu":
            with zipfile.ZipFile(path) as archive:
                yield str(path), archive.read("modelDescription.xml").decode()
        elif path.suffix == ".html":
            page = path.read_text("utf-8")
            visible = re.sub(r"<(style|script|svg)\b.*?</\1>|<[^>]*>", " ", page, flags=re.DOTALL)
            yield str(path), html.unescape(visible)
        elif path.suffix in (".json", ".csv", ".c", ".h", ".st") and path != log:
            yield str(path), path.read_text("utf-8")


def numbers(entry, name):
    """Yield the numbers that learned.json has of a parameter, wherever it stands."""
    if isinstance(entry, dict):
        own = entry.get(name)
        for found in (own, *(own or {}).values()) if isinstance(own, dict) else (own,):
            yield from [found] if isinstance(found, float) else []
        for inner in entry.values():
            yield from numbers(inner, name)
    elif isinstance(entry, list):
        for inner in entry:
            yield from numbers(inner, name)


def test_no_unit_is_that_of_another_kind_of_drive(output):
    kind, _, texts = output
    assert {name.rpartition(".")[2] for name in texts} > {"fmu", "html", "csv", "h", "st", "json"}
    for name, text in texts.items():
        wrong = OF_LINEAR.findall(text) if kind == "rotary" else re.findall(r"\brad\b", text)
        assert not wrong, (name, wrong)
    right = "rad/s" if kind == "rotary" else "m/s"
    for name, text in texts.items():
        if kind == "rotary" and name.endswith((".c", ".h", ".st")):
            assert not re.search("Moving mass|the stage", text)
        if name.endswith("compensator.fmu"):
            assert 'stepSize="0.001"' in text  # T_s of the log
        if name.endswith((".fmu", ".h", ".st", "learned.json", "parameters.csv")):
            assert right in text or "observer" in name, name


def test_every_number_beside_a_name_is_that_of_learned_json(output):
    _, document, texts = output
    share, count = document["share"]["value"], 0
    names = "|".join(document["parameters"])
    beside = re.compile(
        rf"^({names}) +({NUMBER})"  # a table
        rf"|(?<!\w)({names}) = (?:R\()?({NUMBER})"  # a sentence, C
        rf"|({names}) : LREAL := ({NUMBER})"  # structured text
        rf'|name="({names})"[^>]*>\s*<Real[^>]*start="({NUMBER})"',
        re.MULTILINE,
    )
    for source, text in texts.items():
        for found in beside.findall(text):
            name, shown = filter(None, found)
            known = {factor * x for x in numbers(document, name) for factor in (1.0, share)}
            near = min(abs(float(shown) - x) / (abs(x) or 1.0) for x in known)
            assert near < 6e-3 or float(shown) == 0.0, (source, name, shown, sorted(known))
            count += 1
    assert count > 30
