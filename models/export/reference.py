"""What an FMU's results must be: reference.csv of models/, as other people's formats have it."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from xml.etree import ElementTree as ET

from stickslip.fmi.description import writing
from stickslip.models.errors import UnknownLaw
from stickslip.models.export.description import Model
from stickslip.models.export.law import read_toml
from stickslip.models.export.sources import text

LS_REF = "extra/org.fmi-standard.fmi-ls-ref"
# The schema of the standard allows no other.
_DESCRIPTION = "Layered Standard providing information on related files included in an FMU."
_MANIFEST = "http://fmi-standard.org/fmi-ls-manifest"


def reference_file(model: Model) -> Path | None:
    """Return the table of what a model does in a short run, None where there is none.

    A law's is that of the feedforward compensator; a plant's is for its default law.
    """
    law = model.law
    own = model.folder / "reference.csv"
    if law is None or (own.exists() and law.name == read_toml(model.folder / "model.toml")["law"]):
        return own
    if model.name == "compensator":
        return law.folder / "reference.csv"
    return None


def tables(model: Model) -> tuple[str, str]:
    """Return inputs and expected outputs, each a CSV with the time in its first column [s].

    The inputs are those at the beginning of each step of Co-Simulation.
    """
    path = reference_file(model)
    if path is None:
        raise UnknownLaw(f"no expected results of {model.name} with its friction law are known")
    head, *rows = csv.reader(io.StringIO(text(path)))
    inputs = {v.name for v in model.variables if v.role == "input"}
    chosen = [
        [k for k, name in enumerate(head) if name == "time" or (name in inputs) == wanted]
        for wanted in (True, False)
    ]
    written = []
    for columns in chosen:
        stream = io.StringIO()
        stream.write(",".join(f'"{head[k]}"' for k in columns) + "\n")
        stream.writelines(",".join(row[k] for k in columns) + "\n" for row in rows)
        written.append(stream.getvalue())
    return written[0], written[1]


def span(model: Model) -> tuple[float, float]:
    """Return stop time and step [s] of the reference."""
    times = [float(line.split(",")[0]) for line in tables(model)[1].splitlines()[1:]]
    return times[-1], times[1] - times[0]


def layered_standard(model: Model) -> dict[str, str]:
    """Return the files of FMI-LS-REF by path in the FMU.

    Source
    ------
    FMI Layered Standard References 1.0.0-alpha.1 (modelica/fmi-ls-ref).
    """
    stimuli, references = f"{model.name}_in.csv", f"{model.name}_out.csv"
    ET.register_namespace("fmi-ls", _MANIFEST)
    manifest = ET.Element(
        "fmiReferences",
        {
            f"{{{_MANIFEST}}}fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
            f"{{{_MANIFEST}}}fmi-ls-version": "1.0.0-alpha.1",
            f"{{{_MANIFEST}}}fmi-ls-description": _DESCRIPTION,
        },
    )
    related = (
        ("experiments.xml", "text/xml", "experiment/validation", "Run with known results"),
        (stimuli, "text/csv", "testcase", "Inputs of that run, held over each step"),
        (references, "text/csv", "result", "Outputs of that run, calculated without this FMU"),
    )
    for source, kind, role, description in related:
        writing.child(
            manifest, "Related", type=kind, source=source, role=role, description=description
        )
    stop, step = span(model)
    experiments = ET.Element("Experiments")
    run = writing.child(
        experiments,
        "Experiment",
        name="Reference",
        description="Start values of modelDescription.xml",
        startTime=0.0,
        stopTime=stop,
        stepSize=step,
    )
    writing.child(run, "Stimuli", source=stimuli, type="text/csv")
    writing.child(run, "References", source=references, type="text/csv")
    content = {
        "fmi-ls-manifest.xml": writing.document(manifest),
        "experiments.xml": writing.document(experiments),
        **dict(zip((stimuli, references), tables(model), strict=True)),
    }
    return {f"{LS_REF}/{name}": text_ for name, text_ in content.items()}


def cross_check(model: Model) -> dict[str, str]:
    """Return the files that go beside an FMU, by name.

    Source
    ------
    FMI Cross-Check, rules 4.1 (modelica/fmi-cross-check).
    """
    stop, step = span(model)
    stimuli, references = tables(model)
    options = {
        "StartTime": 0.0,
        "StopTime": stop,
        "StepSize": step,
        "RelTol": 1e-6,
        "OutputIntervalLength": step,
    }
    return {
        f"{model.name}_in.csv": stimuli,
        f"{model.name}_ref.csv": references,
        f"{model.name}_ref.opt": "".join(f"{key},{value}\n" for key, value in options.items()),
        f"{model.name}_README.md": f"# {model.name}\n\n{model.description}.\n\n"
        f"`{model.name}_ref.csv` was calculated without the FMU, for Co-Simulation with inputs\n"
        f"held over steps of {step:g} s and the start values of modelDescription.xml.\n",
    }
