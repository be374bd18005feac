"""Installed is one name: a user's own modules are not in the way, nor ours in theirs.

All is tried beside modules of the user that have the names of our folders, from the editable
install of these tests and from a wheel.
"""

import os
import shutil
import site
import subprocess
import sys
import venv
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from stickslip.cli import COMMANDS
from tests.kept import further

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[1]
FOLDERS = ("models", "cosim", "ga", "fmi", "fmucheck")
COMPILED = "fmi/toolchain/compiled.zip"
THEIRS = [f"{name}.py" for name in (*FOLDERS[1:], "toolchain", "commands", "results", "report")]
Run = Callable[..., str]
SOURCES = {".py", ".pyi", ".c", ".h", ".toml", ".csv", ".css", ".typed"}

SCRIPT = """
import stickslip as ss
from stickslip import ga, models

def cost(values):
    return (values[0] - 2.0) ** 2

if __name__ == "__main__":
    stage = models.build_fmu("stage", ".")
    loop = ss.System("loop")
    loop.add("stage", stage)
    loop.expose("u", "stage.u")
    force = ss.SineSweep(frequency=(0.5, 5.0), amplitude=(12.0, 20.0), duration=2.0)
    with loop.prepare(step=1e-3, stop=2.0, isolation="process") as simulation:
        result = simulation.run(inputs={"u": force})
    rows = zip(result.time, result["stage.x"], result["u"])
    lines = ["time,position,force", *(f"{t:.6f},{x:.9f},{u:.6f}" for t, x, u in rows)]
    open("log.csv", "w").write("\\n".join(lines))
    problem = ga.Problem([ga.Gene("a", 0.1, 10.0, 1.0)])
    optimiser = ga.optimiser("default", problem, ga.Limits(generations=2))
    with ga.executor("processes", 1) as executor:
        ga.learn(optimiser, cost, executor)
    assert optimiser.best.cost <= 1.0
    assert sorted(ss.__all__) == sorted(name for name in ss.__all__ if getattr(ss, name))
    assert dir(ss) == sorted([*ss.__all__, "__version__"])
    print(ss.__version__, ss.__file__)
"""


@pytest.fixture(scope="session")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the wheel from a copy, as building leaves folders in its source."""
    folder = tmp_path_factory.mktemp("wheel")
    for name in (*FOLDERS, "stickslip"):
        skipped = shutil.ignore_patterns("__pycache__", "*.egg-info")
        shutil.copytree(ROOT / name, folder / "source" / name, ignore=skipped)
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, folder / "source")
    with zipfile.ZipFile(folder / "source" / COMPILED, "w"):
        pass  # what a release compiles is carried
    build = "from setuptools.build_meta import build_wheel; build_wheel('..')"  # as pip does
    command = [sys.executable, "-c", build]
    subprocess.run(command, cwd=folder / "source", check=True, capture_output=True)
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="session")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the wheel where our editable install is not seen; return the interpreter."""
    folder = tmp_path_factory.mktemp("installed")
    venv.create(folder, with_pip=False, symlinks=os.name != "nt")
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    where = "import sysconfig; print(sysconfig.get_path('purelib'))"
    target = Path(subprocess.check_output([python, "-c", where], text=True).strip())
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(target)
    # A folder that a .pth file names has its packages seen, but not its own .pth files.
    (target / "dependencies.pth").write_text("\n".join(site.getsitepackages()))
    return python


@pytest.fixture(scope="session", params=["wheel", *further("editable")])
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Run Python with arguments in the folder of a user, and return what it printed."""
    python = sys.executable
    if request.param == "wheel":
        python = request.getfixturevalue("installed")
    folder = tmp_path_factory.mktemp("user")
    for name in (*THEIRS, "models/__init__.py"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text("raise ImportError('this is a module of the user')")
    (folder / "script.py").write_text(SCRIPT)

    def run(*arguments: str) -> str:
        done = subprocess.run(
            [python, *arguments], cwd=folder, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    place = Path(run("script.py").split()[-1])
    assert place.is_relative_to(ROOT) == (request.param == "editable")
    return run


HELP = """
import sys
from contextlib import suppress
from stickslip.cli import COMMANDS, main

for command in COMMANDS:
    with suppress(SystemExit):
        main([command, "--help"])
"""


WORK = """
from stickslip.cli import main

for command in (
    "build compensator --out built",
    "check built/fmi3/compensator.fmu",
    "simulate stage.fmu --stop 0.1 --isolate --out stage.csv",
    "design",
):
    assert main(command.split()) == 0, command
"""


def test_every_command_is_found(run):
    shown = run("-c", HELP)
    for command in COMMANDS:
        assert f"stickslip {command} [-h]" in shown
    assert all(command in run("-m", "stickslip", "--help") for command in ("build", "learn"))


@pytest.mark.parametrize("run", ["wheel"], indirect=True)
def test_commands_do_their_work(run):
    """In one process and in children that isolate FMUs.

    From the editable install all other tests run them.
    """
    run("-c", WORK)


@pytest.mark.thorough
@pytest.mark.parametrize("run", ["wheel"], indirect=True)
def test_learning_from_a_wheel(run):
    def stickslip(*arguments: str) -> str:
        return run("-m", "stickslip", *arguments)

    assert "F_c" in stickslip(
        *("learn", "--log", "log.csv", "--criterion", "inverse", "--out", "learned"),
        *("--workers", "2", "--force"),
    )
    stickslip("verify", "learned")
    stickslip("validate", "learned/learned.json", "--log", "log.csv", "--out", "validated")


def test_the_wheel_holds_one_name_and_all_files(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if not name.endswith("/")}
    assert {name.partition("/")[0].partition("-")[0] for name in names} == {"stickslip"}
    expected = set()
    for folder in (*FOLDERS, "stickslip"):
        for path in (ROOT / folder).rglob("*"):
            if path.suffix in SOURCES and "egg-info" not in str(path):
                below = "" if folder == "stickslip" else "stickslip/"
                expected.add(below + path.relative_to(ROOT).as_posix())
    assert expected - names == set()
    assert f"stickslip/{COMPILED}" in names
    assert "stickslip/py.typed" in names


def test_in_a_clone_the_packages_are_found_beside_the_folder():
    """`pip install .` and then python in the clone, whose folder hides what was installed."""
    lines = (
        "import sys",
        "sys.meta_path = [one for one in sys.meta_path if '__editable__' not in repr(one)]",
        "from stickslip import ga, models",
        "print(models.__file__)",
    )
    command = [sys.executable, "-c", "\n".join(lines)]
    shown = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    assert Path(shown.strip()) == ROOT / "models" / "__init__.py"
