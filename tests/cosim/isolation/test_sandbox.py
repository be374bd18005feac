"""What an FMU tries beyond its folder is denied, and named in one line."""

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

import pytest

from stickslip import cosim
from stickslip.fmi.process import permitted, sandbox
from stickslip.fmi.toolchain import cache_directory
from tests.corpus.hostile import attempts
from tests.cosim.single import one

pytestmark = pytest.mark.skipif(bool(sandbox.unavailable()), reason=sandbox.unavailable())


def told(hostile, caplog, behaviour, limits):
    """Return the error of a run, or what it warns of."""
    try:
        with hostile(f"DoStep {behaviour}").prepare(step=0.1, stop=0.2, isolation=limits) as s:
            s.run()
    except cosim.SimulationError as error:
        return str(error)
    return "".join(record.getMessage() for record in caplog.records if "sandbox" in record.msg)


def test_an_isolated_program_finds_the_files_that_were_built_for_it(monkeypatch, tmp_path):
    monkeypatch.delenv("STICKSLIP_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    ask = "from stickslip.fmi.toolchain import cache_directory; print(cache_directory())"
    command = [sys.executable, "-c", ask]
    own = sandbox.Permissions().environment()
    answer = subprocess.run(command, env=own, capture_output=True, text=True, check=True).stdout
    assert Path(answer.strip()) == cache_directory()
    assert cache_directory().is_relative_to(tmp_path)


@pytest.mark.parametrize(
    ("behaviour", "word"),
    [("connect", "network"), ("execute", "exec"), ("read_home", f"files={Path.home()}")],
)
def test_what_is_allowed_works(hostile, caplog, behaviour, word):
    assert not told(hostile, caplog, behaviour, cosim.Isolation(allow=(word,)))


@pytest.mark.parametrize(
    ("behaviour", "says"),
    [
        ("share_out", "took more than the 100 MB it may"),
        ("fill", "tried to take more than 100 MB of files"),
    ],
)
def test_limits_hold_for_all_processes_and_files_together(hostile, caplog, behaviour, says):
    assert says in told(hostile, caplog, behaviour, cosim.Isolation(memory=100.0, patience=8.0))


def test_other_threads_of_the_child_are_in_the_sandbox():
    """A signal handler of an FMU runs in any of them, such as the one that waits for our end."""
    with attempts.a_victim() as (victim, room):
        binary = attempts.library().read_bytes()
        path = attempts.write(room / "attempts.fmu", binary, victim, ["other_threads"])
        before = victim.state()
        system = one(path)
        with pytest.raises(cosim.SimulationError, match=r"tried to write .*/new"):
            system.prepare(step=0.1, stop=0.2, isolation="process")
        assert victim.state() == before


def test_variables_of_the_environment_are_let_through_by_name(monkeypatch):
    monkeypatch.setenv("LICENCE", "27000@host")
    assert "LICENCE" not in sandbox.Permissions().environment()
    given = sandbox.Permissions.of(["env=LICENCE"]).environment()
    assert given["LICENCE"] == "27000@host"


def test_an_unknown_permission_is_refused():
    with pytest.raises(cosim.ExperimentError, match="expected 'network', 'exec' or 'files=DIR'"):
        cosim.Isolation(allow=("everything",))


ROOT = Path(__file__).parents[3]
PARTS = ("fmi", "models", "cosim", "ga", "fmucheck")
NOBODY = 65534


def outcomes(library, folder, user):
    """Return what came of the attempts of a user, None where there is none to become."""
    package = folder / "stickslip"
    package.mkdir(exist_ok=True)
    for part in (*(ROOT / "stickslip").iterdir(), *(ROOT / part for part in PARTS)):
        (package / part.name).symlink_to(part)
    folder.chmod(0o777)
    binary = shutil.copy(library, folder)
    search = os.pathsep.join((str(folder), str(ROOT), sysconfig.get_path("purelib")))
    system = f"/usr/bin/python3.{sys.version_info.minor}"
    for python in (sys.executable, system) if user else (sys.executable,):
        try:
            ended = subprocess.run(
                [python, "-P", "-m", "tests.corpus.hostile.attempts", binary],
                env={**os.environ, "PYTHONPATH": search, "HOME": str(folder)},
                cwd=folder,
                stdout=subprocess.PIPE,
                check=False,
                **({"user": user, "group": user, "extra_groups": ()} if user else {}),
            )
        except PermissionError:  # Python is in the home folder of root
            continue
        return json.loads(ended.stdout)
    return None


@pytest.mark.parametrize("user", [0, NOBODY], ids=["as we are", "as an ordinary user"])
def test_what_an_fmu_tries_is_refused_named_and_leaves_no_trace(user):
    """It also looks for secrets in its environment, and prints what has worked: nothing."""
    if user and os.getuid():
        pytest.skip("only root can become another user")
    with tempfile.TemporaryDirectory() as folder:  # that of pytest is closed to others
        made = outcomes(attempts.library(), Path(folder), user)
    if made is None:
        pytest.skip("no other user may start this Python")
    assert made == {"lacking": [], "beside": [], "printed": [], "changed": []}


@pytest.mark.parametrize("machine", ["x86_64", "aarch64"])
@pytest.mark.parametrize("words", [(), ("network",), ("network", "exec")])
def test_the_filter_decides_as_its_table_says(machine, words):
    """Of every call, with arguments that are listed and with some that are not."""
    numbers = sandbox.numbers(machine)
    program = permitted.program(numbers, 7, frozenset(words))
    rules = {}
    for rule in permitted.ALLOWED:
        if not rule.word or rule.word in words:
            rules |= dict.fromkeys(rule.calls.split(), rule)
    by_number = {number: name for name, number in numbers.items()}
    for number in range(600):
        rule = rules.get(by_number.get(number, ""))
        listed = rule is not None and not rule.asks
        fitting = [0] * 6
        for test in rule.where if rule else ():
            fitting[test.place] = test.values[-1]
        if by_number.get(number) == "clone3":
            assert run(program, 7, number, fitting) == permitted.ERROR | 38
            continue
        expected = permitted.ALLOW if listed else permitted.NOTIFY
        assert run(program, 7, number, fitting) == expected, by_number.get(number)
        assert run(program, 8, number, fitting) == permitted.NOTIFY
        if listed and rule.where:
            assert run(program, 7, number, [0x7EEEEEEE] * 6) == permitted.NOTIFY


def run(program, processor, number, arguments):
    """Interpret a filter."""
    words = {0: number, 4: processor}
    for place, value in enumerate(arguments):
        words |= {16 + 8 * place: value & 0xFFFFFFFF, 20 + 8 * place: value >> 32}
    lines = list(permitted._INSTRUCTION.iter_unpack(program))
    at = kept = 0
    while True:
        what, then, other, value = lines[at]
        match what:
            case 0x20:
                kept = words[value]
            case 0x54:
                kept &= value
            case 0x15:
                at += then if kept == value else other
            case 0x35:
                at += then if kept >= value else other
            case 0x06:
                return value
        at += 1


def test_the_documentation_has_the_table_of_what_is_allowed():
    text = (ROOT / "docs" / "isolation.md").read_text(encoding="utf-8")
    for rule in permitted.ALLOWED:
        word = f" (`--allow {rule.word}`)" if rule.word else ""
        assert f"| {rule.why}{word} | {rule.limit} | {rule.calls} |" in text
    for name in (*sandbox.SYSTEM, *sandbox.SETTINGS, *sandbox.VARIABLES, *sandbox.FAMILIES):
        assert f"`{name}" in text, name
