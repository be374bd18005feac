"""Random calls under sanitizers: no crash, an error changes nothing, twice gives the same.

A model with another law has the same adapter and the same memory, so each runs with its own, and
with one that has state events. What FMI 2.0 and 3.0 do not share sees the tables of a model only:
where two models have variables of the same kinds, one of them runs with FMI 2.0, too.
"""

import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from stickslip import models
from stickslip.models.export import sources

GCC = shutil.which("gcc") or ""
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not GCC, reason="gcc, with its sanitizers, is not installed here"),
]

SEQUENCES = 150
MODELS = [models.load_model(name) for name in models.model_names()]
MODELS.append(replace(models.load_model("stage", "gms"), name="stage_gms"))
KINDS = {
    frozenset((v.role, v.type, v.variability, v.is_output, v.held) for v in model.variables): model
    for model in MODELS
}
CASES = [(model, 3) for model in MODELS] + [(model, 2) for model in KINDS.values()]
USUAL = {("stage_gms", 3), ("velocity_controller", 2)}
"""Models whose calls are tried in every run of the tests."""
SANITIZE = ["-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all"]
DERIVED = ("derivative", "indicator", "mode")
KEYS = ("role", "type", "variability", "start", "minimum", "maximum", "nominal")


def library(model, version, folder):
    """Compile a library with gcc's sanitizers; ziglang brings none for addresses."""
    start = sources.start_source("token", [v.start for v in model.variables])
    files = sources.c_files(model, version) | {sources.START: start}
    files |= {f"system/{name}": text for name, text in sources.fmi_headers(version).items()}
    for path, text in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
    command = [GCC, *SANITIZE, "-g1", "-Og", "-shared", "-fPIC", "-ffp-contract=off", "-I."]
    command += ["-isystem", "system", *sources.compiled(files), "-lm", "-o", "model.so"]
    subprocess.run(command, cwd=folder, check=True)
    rows = [{key: getattr(v, key) for key in KEYS} for v in model.variables]
    for row in rows:
        row["type"] = "derived" if row["role"] in DERIVED else row["type"]
    told = {"fmi": version, "rows": rows, "model_exchange": model.has_model_exchange}
    told["slopes"] = model.is_continuous and not model.is_switched
    (folder / "model.json").write_text(json.dumps(told))


def calls(folder, first, count):
    """Return the numbers of calls and of unlawful ones, and the hash of what they gave."""
    preloaded = (
        subprocess.check_output([GCC, f"-print-file-name={name}.so"], text=True).strip()
        for name in ("libasan", "libubsan")
    )
    how = {"LD_PRELOAD": ":".join(preloaded), "ASAN_OPTIONS": "detect_leaks=0"}
    script = Path(__file__).with_name("random_calls.py")
    command = [sys.executable, script, "./model.so", "model.json", str(first), str(count)]
    done = subprocess.run(
        command, cwd=folder, env=os.environ | how, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout.split()


@pytest.mark.parametrize(
    ("model", "version"),
    [
        pytest.param(
            model,
            version,
            id=f"{model.name}-fmi{version}",
            marks=() if (model.name, version) in USUAL else pytest.mark.thorough,
        )
        for model, version in CASES
    ],
)
def test_random_calls(model, version, tmp_path):
    library(model, version, tmp_path)
    made, unlawful, _ = calls(tmp_path, 1, SEQUENCES)
    assert int(unlawful) > 5 * SEQUENCES
    assert int(made) - int(unlawful) > 10 * SEQUENCES
    again = [calls(tmp_path, first, 50)[2] for first in (7, 7, 8)]
    assert again[0] == again[1] != again[2]
