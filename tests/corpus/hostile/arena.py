"""Drives, ports and plans of an arena that do not fit together, or are of another form."""

import json

from tests.corpus.hostile.case import Case, family
from tests.corpus.hostile.learning import LEARNED, changed
from tests.corpus.hostile.sound import sound

_ARENA = "arena --compensators none --evaluations 10 --out out"
_drives = family(
    25, "drives", f"{_ARENA} --drives d.toml", file="d.toml", begins="d.toml: drive 'a': .*"
)
_named = family(25, "drives", f"{_ARENA} --drives d.toml", file="d.toml")
_ports = family(
    25,
    "ports",
    f"{_ARENA} --compensator a.fmu --ports p.toml",
    file="p.toml",
    begins="p.toml: .*",
    a_fmu=sound,
)
_LAW = "[a]\nlaw = 'lugre'\n"
_SOUND = "inputs = {u = 'v_ref'}\noutput = 'y'\n"


def _python(name: str, about: str, says: str, arguments: str) -> Case:
    return Case(25, f"python-{name}", about, says, "", code=f"ss.arena({arguments})")


def _learned(name: str, about: str, says: str, content: bytes, command: str) -> Case:
    return Case(25, f"learned-{name}", about, says, command, {"learned.json": content})


_EXPORT = "export compensator --parameters learned.json"
CASES = [
    _drives("gain-nan", "a drive whose K_p is NaN", "K_p is nan N s/m", f"{_LAW}loop = {{K_p = nan, K_i = 1.0}}\n"),
    _drives("measurement", "noise that is a list", "measurement: expected a table of numbers", f"measurement = [1]\n{_LAW}"),
    _drives("array", "an array of drives of one name", "expected a table with law", "[[a]]\nlaw = 'lugre'\n"),
    _named("case", "drives named A and a, one folder on Windows and macOS", "two drives have the same name, upper and lower case alike, of A, a", f"[A]\nlaw = 'lugre'\n{_LAW}"),
    _ports("inputs-list", "inputs that are a list", "inputs: expected a table of texts, got \\['u'\\]", "inputs = ['u']\noutput = 'y'\n"),
    _ports("name", "a name that is a number", "name: expected a text, got 5", f"name = 5\n{_SOUND}"),
    _ports("values", "a number in place of values", "values: expected a table of numbers, got 5", f"values = 5\n{_SOUND}"),
    _ports("genes-text", "a gene between words", "genes: expected a table of", f"{_SOUND}genes = {{k = ['a', 'b', 'c']}}\n"),
    _ports("genes-empty", "a gene of no range", r"genes: k: expected \[lowest, start, highest\], got \[1, 1, 1\]", f"{_SOUND}genes = {{k = [1, 1, 1]}}\n"),
    _ports("gene-output", "a gene that is an output", "'y' is no parameter of a.fmu", f"{_SOUND}genes = {{y = [0, 1, 2]}}\n"),
    _ports("output-is-input", "an input as output", "'u' is no output of a.fmu", "inputs = {u = 'v_ref'}\noutput = 'u'\n"),
    _ports("learned", "a parameter learned by a list", "learned: expected a table of texts", f"{_SOUND}learned = {{k = ['x']}}\n"),
    _python("budget", "a budget of -5 candidates", "evaluations=-5: expected a whole number, at least 10", '["none"], evaluations=-5'),
    _python("drive", "a drive that is a number", "drive 'a': expected a table with law", '["none"], {"a": 5}'),
    _learned("unit", "a Stribeck velocity in mm/s, which would be read as m/s", "learned.json: parameters: v_s is in 'mm/s'; expected m/s", changed("parameters", "v_s", to={"value": 9.6, "unit": "mm/s"}), _EXPORT),
    _learned("newer", "the form of a later version", "learned.json: schema: expected a number from 1 to 2, got 3", changed("schema", to=3), _EXPORT),
    _learned("plateau", "a plateau of -1 s", "learned.json: validation: .*times of 0 or more", changed("validation", "plateau", to={"value": -1.0}), _EXPORT),
    Case(25, "manifest-edited", "an interrupted arena of an edited folder", "out/manifest.json: not a manifest of results", _ARENA, {"out/manifest.json": json.dumps({"command": 1})}),
    Case(25, "two-of-one-learned", "one learned drive, twice", "two drives have the same name", f"{_ARENA} --drive learned.json learned.json", {"learned.json": LEARNED.read_bytes()}),
]  # fmt: skip
