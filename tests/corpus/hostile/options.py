"""Values on the command line that are numbers, and make no sense."""

from tests.corpus.hostile.case import Case, Content
from tests.corpus.hostile.sound import sound
from tests.corpus.hostile.tables import LOG


def _case(name: str, about: str, says: str, command: str) -> Case:
    files: dict[str, Content] = {"a.fmu": sound} if "a.fmu" in command else {}
    files |= {"in.csv": "time,u\n0,1\n"} if "in.csv" in command else {}
    files |= {"log.csv": LOG} if "log.csv" in command else {}
    return Case(27, name, about, says, command, files)


def _cache(name: str, about: str, says: str, place: str) -> Case:
    """Return a case of a run with its cache elsewhere."""
    code = f'import os, sys\nos.environ["STICKSLIP_CACHE"] = {place}\nmain(["simulate", "a.fmu"]) and sys.exit(1)'
    return Case(27, f"cache-{name}", about, says, "", {"a.fmu": sound, "in.csv": ""}, code)


CASES = [
    _cache("file", "a cache that is a file", "a.fmu: cannot be unpacked .*Not a directory", '"in.csv"'),
    _cache("long", "a cache whose name is too long", "a.fmu: cannot be unpacked", '"x" * 5000'),
    _case("save-over-the-fmu", "a state that would be saved over the FMU that is run", "--save a.fmu: is what the run reads", "simulate a.fmu --until 0.5 --save a.fmu"),
    _case("out-over-the-input", "results that would be written over the input", "--out in.csv: is what the run reads", "simulate a.fmu --input in.csv --out ./in.csv"),
    _case("memory", "a limit of 1e300 MB", "isolation: memory is 1e\\+300, expected a positive number below", "simulate a.fmu --memory 1e300"),
    _case("timeout-of-nothing", "a time limit for an FMU that runs in the same process", "--timeout needs --isolate", "simulate a.fmu --no-isolate --timeout 5"),
    _case("allow-missing", "access to a folder that is not there", "allow is 'files=missing', expected a folder that exists", "simulate a.fmu --allow files=missing"),
    _case("allow-nothing", "access to no folder, which would be the present one", "allow is 'files=', expected a folder", "simulate a.fmu --allow files="),
    _case("until-nan", "an end at NaN", "until = nan s is not a point in time", "simulate a.fmu --until nan"),
    _case("mass-tiny", "a mass of 1e-300 kg", "m is 1e-300 kg; expected 1e-18 to 1e12", "design --mass 1e-300"),
    _case("negative-exponent", "a negative bandwidth with an exponent", "bandwidth is -0.01 Hz", "design --bandwidth -1e-2"),
    _case("travel-units", "a travel in millimetres below and in degrees above", "--travel is in deg, but the motion is linear", "plan --travel 10mm 5deg"),
    _case("travel-tiny", "a travel of 2 nm, which the moves would leave", "stroke and travel leave 2e-09 m or rad; expected at least 1e-06", "plan --travel 1e-9"),
    _case("heartbeat", "a heartbeat of infinity", "--heartbeat inf: expected more than 0 and less than 1e6", "serve a.fmu --heartbeat inf"),
    _case("scale-tiny", "forces scaled by 1e-300", "the mass is extreme: 5e-300 kg", "learn log.csv --check --scale force=1e-300"),
]  # fmt: skip
