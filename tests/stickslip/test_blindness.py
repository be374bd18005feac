"""What identifies and learns sees the drive's commands and measurements, never its truth."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

import stickslip
from stickslip import cosim, ga
from stickslip.compensators.entrants import entrant
from stickslip.evaluation.motions import TRAINING
from stickslip.identification.stages import identify
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.servo.tuned_pi import tuned_pi
from stickslip.studies.arena.drives import default_drives
from stickslip.studies.arena.protocol import Plan, build
from stickslip.studies.arena.tuning import Budget, tune
from stickslip.tuning.drive_model import fit_models
from stickslip.tuning.learning import Study
from stickslip.tuning.loop_learning import LoopStudy, learn_loop
from stickslip.tuning.refinement import refine
from tests.cosim.single import repacked
from tests.kept import further

SOURCES = Path(stickslip.__file__).parent
BLIND = [
    *sorted((SOURCES / "identification").rglob("*.py")),
    *sorted((SOURCES / "tuning").glob("*.py")),
    *(SOURCES / "rigs" / f"{name}.py" for name in ("contract", "file", "fmu", "limits", "lines")),
    SOURCES / "rigs" / "socket_rig.py",
    SOURCES / "compensators" / "entrants.py",
    SOURCES / "studies" / "arena" / "tuning.py",
]


def found(rig):
    """Return all that identification and a short learning find, as exact text."""
    identification = identify(rig, LOOP)
    v_cmd = TRAINING.sample(rig.samples(1.0))
    refined = refine(Study(rig, identification.loop, identification.tuned, v_cmd))
    study = LoopStudy(
        rig, tuned_pi(identification.loop), refined.values, limits=ga.Limits(evaluations=12)
    )
    study = replace(study, models=fit_models(study)[:1])
    loop = learn_loop(study)
    return repr(
        (
            identification.estimates,
            refined,
            study.models,
            loop.genes,
            loop.algorithm.history.to_csv(),
        )
    )


def falsify_description(fmu: Path) -> None:
    """Change every start value in modelDescription.xml; the binary keeps its own."""

    def halved(match):
        return f'start="{float(match[1]) * 0.5:g}"'

    def change(name, content):
        if name != "modelDescription.xml":
            return content
        parts = re.split(r"(<ModelVariables>.*</ModelVariables>)", content.decode(), flags=re.S)
        parts[1], n = re.subn(r'start="([-+.e\d]+)"', halved, parts[1])
        assert n
        return "".join(parts).encode()

    repacked(fmu, fmu, change)


@pytest.mark.slow
def test_only_measurements_are_recorded_and_a_lie_about_the_truth_changes_nothing(
    make_rig, monkeypatch
):
    rig = make_rig(F_c=7.0, sigma_0=2e5)
    seen, prepare, run, given = [], cosim.Simulation.__init__, cosim.Simulation.run, set()

    def watch(self, specification):
        seen.append(specification)
        prepare(self, specification)

    def listen(self, parameters=None, *others, **options):
        given.update(dict(parameters or {}))
        return run(self, parameters, *others, **options)

    monkeypatch.setattr(cosim.Simulation, "__init__", watch)
    monkeypatch.setattr(cosim.Simulation, "run", listen)
    honest = found(rig)
    monkeypatch.undo()
    assert "model_lugre.F_c" in given  # the models of the drive are FMUs of what was identified
    assert not [name for name in given if name.startswith("drive.")]
    with_drive = [s for s in seen if "drive" in s.system.components]
    assert len(with_drive) > 20
    for specification in with_drive:
        of_drive = {name for name in specification.record if name.startswith("drive.")}
        assert of_drive <= {"drive.x_enc", "drive.F_m"}
        assert not [name for name in specification.system.parameters if name.startswith("drive.")]
    falsify_description(rig.fmus / "drive.fmu")
    assert found(rig) == honest


@pytest.mark.parametrize("name", ["static+ekbf", *further("lugre_network")])
def test_nor_does_it_change_what_the_arena_tunes(tmp_path, name):
    (drive,) = (one for one in default_drives() if one.name == "lugre")
    build(tmp_path, Plan([drive], [name]))
    fmus = tmp_path / drive.name

    def tuned():
        return tune(fmus, drive.loop, entrant(name), Budget(10), 0, Datasheet())

    honest = tuned()
    falsify_description(fmus / "drive.fmu")
    assert tuned() == honest


@pytest.mark.parametrize("source", BLIND, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_their_sources_name_no_truth(source):
    named = set(re.findall(r"drive\.(\w+)", source.read_text(encoding="utf-8")))
    assert named <= {"x_enc", "F_m", "u", "fmu"}
