"""What an installation cannot have among its own files lies in a folder of the user."""

import json
import os
import subprocess
import sys

WRITES = """
import sys
from pathlib import Path
from stickslip.commands import new
from stickslip.cli import main
new._CLONE = Path("no clone")
for kind in new._KINDS:
    assert main(["new", kind, f"my_{kind}"]) == 0
    assert main(["new", kind, f"my_{kind}"]) == 1  # the name is taken
"""
USES = """
import json
import stickslip as ss
from stickslip.cli import main
from stickslip.ga import ALGORITHMS
from stickslip.logs.formats import SUFFIXES
fmu = ss.build_fmu("my_compensator", "fmus")
law = ss.build_fmu("stage", "fmus", law="my_law")
end = ss.simulate(law, stop=0.1, step=1e-3, inputs={"u": 12.0})["stage.v"][-1]
assert main(["my_command", "press"]) == 0
print(json.dumps([end, "my_optimiser" in ALGORITHMS, ".my_format" in SUFFIXES, str(fmu)]))
"""


def test_additions_to_an_installation_are_found_in_the_folder_of_the_user(tmp_path):
    own = tmp_path / "own"
    given = {**os.environ, "STICKSLIP_ADDITIONS": str(own)}

    def run(code):
        words = [sys.executable, "-c", code]
        done = subprocess.run(words, cwd=tmp_path, env=given, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert "active from now on: stickslip my_command" in run(WRITES)
    assert {path.name for path in own.iterdir()} == {
        *("laws", "compensators", "algorithms", "formats", "commands")
    }
    *lines, last = run(USES).splitlines()
    assert "hello, press" in lines
    end, *found, fmu = json.loads(last)
    assert end > 0.0
    assert found == [True, True]
    assert fmu == "fmus/my_compensator.fmu"
