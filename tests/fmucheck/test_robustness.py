"""The checker itself: messages, patience, rules that explain themselves, our FMUs.

That any bytes give a report is tried by ``campaigns.fuzz``, see tests/hostile.
"""

import ctypes
import re
import struct
import sys
import time
from pathlib import Path

import pytest
from lxml import etree

from stickslip import fmucheck, models
from stickslip.fmi import toolchain
from stickslip.fmi.binary import read_library
from stickslip.fmucheck import check
from stickslip.fmucheck.description.model import Description
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.calls import Callbacks
from tests.corpus.defects.reference import binary_name, members, pack, with_defect
from tests.corpus.hostile import fmus
from tests.cosim.single import members as unzipped


def test_nothing_is_left_and_nothing_leaves_the_folder(tmp_path, monkeypatch):
    """Temporary files are gone whether the FMU is sound or its paths go up."""
    room = tmp_path / "room"
    room.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(room))
    outside = "terminalsAndIcons/../../../../../../../../etc/hostname"
    names = ("../../evil", "/tmp/fmucheck-evil", outside)  # noqa: S108 (not written)
    report = fmucheck.check(pack(tmp_path / "evil.fmu", members(2) | dict.fromkeys(names, b"")))
    (unsafe,) = (f for f in report if f.rule == "unsafe-path")
    assert {unsafe.place, *unsafe.others} == {repr(name) for name in names}
    assert list(room.iterdir()) == []
    assert sorted(p.name for p in tmp_path.iterdir()) == ["evil.fmu", "room"]


def test_every_rule_explains_itself():
    for rule in fmucheck.RULES.values():
        assert rule.summary.endswith("."), rule.id
        assert rule.advice, rule.id
        assert rule.sections, rule.id
        sections = rule.sections.values()
        assert all(re.fullmatch(r"(\d(\.\d+)*)?", section) for section in sections), rule.id


CODE = """
__attribute__((visibility("default"))) double shown(double x);
double shown(double x) { return x; }
"""


def test_an_unsigned_library_for_arm_macs_is_found(tmp_path):
    """The load command of the signature becomes one of another kind."""
    platform = toolchain.PLATFORMS["aarch64-darwin"]
    data = toolchain.shared_library("a", {"a.c": CODE}, platform=platform).read_bytes()
    command = struct.pack("<II", 0x1D, 16)
    assert data.count(command) == 1
    unsigned = data.replace(command, struct.pack("<II", 0x26, 16))
    assert read_library(unsigned).unsigned
    sound = models.build_fmu("stage", tmp_path, fmi=3)
    assert "unsigned-for-arm-mac" not in check(sound, run=False).rules
    path = tmp_path / "unsigned.fmu"
    pack(path, unzipped(sound) | {"binaries/aarch64-darwin/stage.dylib": unsigned})
    assert "unsigned-for-arm-mac" in check(path, run=False).rules


CALLS = {
    '"%d of %u"': "-3, 7u",
    '"%ld %lld %zu"': "-3000000000L, 1LL << 40, (unsigned long)5",
    '"%s|%10s|%-4s|%.2s"': '"word", "ten", "a", "cut off"',
    '"%g %.3f %e"': "0.1, 3.14159, -1e300",
    '"%d %g %s %g %d"': '1, 2.5, "three", 4.5, 5',
    '"%*d|%.*f|%05d|%+d|%x|%#o"': "5, 42, 2, 1.005, 7, 8, 255, 8",
    '"%c%%%c"': "'a', 'b'",
    '"%d %d %d %d %d %d %d %s"': '1, 2, 3, 4, 5, 6, 7, "eight"',
    '"plain"': "",
}


@pytest.fixture(scope="module")
def library():
    cases = "".join(
        f'case {i}: log(env, "a", 0, "b", {text}{", " * bool(given)}{given});\n'
        f"snprintf(out, 200, {text}{', ' * bool(given)}{given}); break;\n"
        for i, (text, given) in enumerate(CALLS.items())
    )
    source = (
        "#include <stdio.h>\n"
        "typedef void Log(void *, const char *, int, const char *, const char *, ...);\n"
        '__attribute__((visibility("default"))) void say(Log *log, void *env, int i, char *out);\n'
        f"void say(Log *log, void *env, int i, char *out) {{ switch (i) {{\n{cases}}} }}\n"
    )
    flags = ("-Wno-format", "-Wno-pedantic", "-Wno-error")
    return ctypes.CDLL(str(toolchain.shared_library("printf", {"say.c": source}, flags=flags)))


@pytest.mark.parametrize("i", range(len(CALLS)), ids=list(CALLS))
def test_a_message_is_formatted_as_by_printf(library, i):
    callbacks, out = Callbacks(), ctypes.create_string_buffer(200)
    library.say(callbacks.logger2, ctypes.c_void_p(callbacks.environment), i, out)
    (message,) = callbacks.messages
    assert message.text == out.value.decode()
    assert (message.category, message.status) == ("b", 0)


@pytest.mark.parametrize(("elapsed", "tried"), [(0.0, [1, 2, 3]), (1e6, [])])
def test_things_are_tried_while_there_is_time(elapsed, tried):
    description = Description(etree.XML("<a><CoSimulation/></a>"), 2)
    bench = Bench(description, description.interfaces[0], Path(), Path(), [])
    bench.began = time.monotonic() - elapsed
    assert list(bench.while_time([1, 2, 3])) == tried


@pytest.mark.slow
def test_one_instance_per_process_is_respected(tmp_path):
    """An FMU that keeps its state in a global variable is sound if it says so.

    The time is not enough for all rules: what is known by then is reported.
    """
    once = b'canBeInstantiatedOnlyOncePerProcess="true" modelIdentifier='
    sound = members(2)
    description = sound["modelDescription.xml"].replace(b"modelIdentifier=", once)
    binary = {binary_name(2): with_defect("shared-state")}
    path = pack(tmp_path / "a.fmu", sound | {"modelDescription.xml": description} | binary)
    report = fmucheck.check(path, total=3.0)
    assert [f for f in report if f.severity > fmucheck.Severity.NOTE] == []
    assert "time for all rules is over" in " ".join(f.message for f in report)


@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu_that_allows_eight_instances_at_a_time_is_sound(tmp_path, version):
    binary = {binary_name(version): with_defect("few-instances")}
    path = pack(tmp_path / "reference.fmu", members(version) | binary)
    assert list(fmucheck.check(path)) == []


def test_findings_of_one_cause_are_one(tmp_path):
    units = members(2)["modelDescription.xml"].replace(b'unit="', b'unit="other ')
    units = units.replace(b'<Unit name="other ', b'<Unit name="')
    path = pack(tmp_path / "a.fmu", members(2) | {"modelDescription.xml": units})
    found = [f for f in fmucheck.check(path, run=False) if f.rule == "undefined-unit"]
    assert 1 < sum(f.count for f in found) == len(found) + sum(len(f.others) for f in found)
    assert len({f.cause for f in found}) == len(found)


BROKEN = {"cut": 2, "of this machine": 1, "text": None}
"""Ways in which binaries for other platforms are wrong; what part of a library they are."""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="hostile.c is for POSIX")
@pytest.mark.parametrize("version", [2, 3])
def test_broken_binaries_elsewhere_do_not_stop_the_run_here(tmp_path, version):
    """A fault that only a run shows is found, with each other platform broken in another way."""

    def rules(binaries):
        path = tmp_path / "hostile.fmu"
        return check(fmus.write(path, "DoStep fail", version=version, binaries=binaries)).rules

    code, here = fmus.library(), fmus.place(version)
    alone = rules({here: code})
    assert "call-fails" in alone
    folders = ("win64", "win32", "darwin64") if version == 2 else toolchain.PLATFORMS
    others = [folder for folder in folders if f"/{folder}/" not in here]
    found = {here: code}
    for folder, part in zip(others, BROKEN.values(), strict=False):
        suffix = ".dylib" if "darwin" in folder else ".dll" if "win" in folder else ".so"
        content = code[: len(code) // part] if part else b"this is no library\n"
        found[f"binaries/{folder}/hostile{suffix}"] = content
    assert rules(found) - alone >= {"not-a-library"}
    assert alone <= rules(found)


USUAL = ("drive+gms", "dob", "velocity_filter")
SOUND = [*models.model_names(), *(f"drive+{law}" for law in models.law_names())]


@pytest.mark.parametrize(
    ("name", "version"),
    [
        pytest.param(name, 2 + k % 2, marks=() if name in USUAL else pytest.mark.thorough)
        for k, name in enumerate(SOUND)
    ],
)
def test_our_models_are_sound(tmp_path, name, version):
    model, _, law = name.partition("+")
    report = fmucheck.check(models.build_fmu(model, tmp_path, fmi=version, law=law or None))
    assert report.fmi == f"{version}.0"
    assert [f for f in report if f.severity > fmucheck.Severity.NOTE] == []
