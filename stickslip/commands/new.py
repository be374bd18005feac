"""``stickslip new``: write a law, compensator, optimiser, format or command to start from.

stickslip new law my_law
stickslip new compensator my_compensator
"""

import argparse
import re
from collections.abc import Callable
from keyword import iskeyword
from pathlib import Path

from stickslip.errors import UsageError
from stickslip.fmi.additions import own_folder
from stickslip.fmi.files import atomic_write
from stickslip.output import Answer

_NAME = re.compile(r"[a-z][a-z0-9_]*")
_CLONE = Path(__file__).parents[2] / "pyproject.toml"
_USES = {
    "law": "stickslip build stage --law {}",
    "compensator": "stickslip build {}, and stickslip arena tunes it",
    "optimiser": "--algorithm {}",
    "format": "stickslip learn LOG.{} --check",
    "command": "stickslip {}",
}
_TEMPLATES = Path(__file__).parent / "templates"


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = (
        "Write the smallest addition of a kind that works, into the folder in which stickslip "
        "finds it: in a clone that of its kind, else STICKSLIP_ADDITIONS or ~/.stickslip. See "
        "docs/adding.md for what to change, and for the tests."
    )
    parser.add_argument("kind", choices=_KINDS, help=", ".join(_KINDS))
    parser.add_argument("name", metavar="NAME", help="lower-case letters, digits and _")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Write the files, unless the name is taken."""
    name = options.name
    if not _NAME.fullmatch(name) or iskeyword(name):
        expected = "a letter, then letters, digits and _, all lower-case, as my_law"
        raise UsageError(f"{name!r:.80} cannot name a {options.kind}: expected {expected}")
    files = _KINDS[options.kind](name)
    if taken := next((path for path in files if path.exists()), None):
        raise UsageError(f"{taken} exists; give the {options.kind} another name")
    for path, text in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        title = name.replace("_", " ").capitalize()
        atomic_write(path, text.replace("NEW_TITLE", title).replace("NEW_NAME", name))
        print(f"written: {path}")
    print(f"active from now on: {_USES[options.kind].format(name)}")
    return Answer({"written": list(files)})


def _room(package: Path) -> Path:
    """Return the folder of a kind: that of a clone, else one of the user, which updates leave."""
    return package if _CLONE.exists() else own_folder() / package.name


def _law(name: str) -> dict[Path, str]:
    from stickslip import models  # late: loads compilers

    laws = Path(models.__file__).parent / "laws"
    texts = {
        **{f"law.{kind}": _template(f"law.{kind}") for kind in ("toml", "c")},
        "README.md": _template("law.md"),
        "reference.csv": (laws / "dahl" / "reference.csv").read_text(encoding="utf-8"),
    }
    if name in models.law_names():
        raise UsageError(f"there is a law {name!r}; give the new one another name")
    return {_room(laws) / name / file: text for file, text in texts.items()}


def _compensator(name: str) -> dict[Path, str]:
    from stickslip import models  # late: loads compilers

    if name in models.model_names():
        raise UsageError(f"there is a model {name!r}; give the compensator another name")
    folder = models.load_model("static_feedforward").folder
    texts = {path: path.read_text(encoding="utf-8") for path in sorted(folder.iterdir())}
    return {
        _room(folder.parent) / name / path.name: text.replace(
            'title = "Static friction feedforward"', 'title = "NEW_TITLE"'
        ).replace("# static_feedforward", "# NEW_NAME")
        for path, text in texts.items()
        if path.is_file()
    }


def _optimiser(name: str) -> dict[Path, str]:
    from stickslip import ga  # late: loads pandas

    room = _room(Path(ga.__file__).parent / "algorithms")
    return {room / f"{name}.py": _template("optimiser.py")}


def _format(name: str) -> dict[Path, str]:
    room = _room(Path(__file__).parents[1] / "logs" / "formats")
    return {room / f"{name}.py": _template("format.py")}


def _command(name: str) -> dict[Path, str]:
    root = Path(__file__).parents[1]
    places = (f"studies/{name}", f"papers/*/commands/{name}.py", f"commands/{name}.py")
    if any(True for place in places for _ in root.glob(place)):
        raise UsageError(f"there is a command {name!r}; give the new one another name")
    return {_room(Path(__file__).parent) / f"{name}.py": _template("command.py")}


def _template(file: str) -> str:
    return (_TEMPLATES / file).read_text(encoding="utf-8")


_KINDS: dict[str, Callable[[str], dict[Path, str]]] = {
    "law": _law,
    "compensator": _compensator,
    "optimiser": _optimiser,
    "format": _format,
    "command": _command,
}
