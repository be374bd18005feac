"""The house stands as it was drawn: arrows run down, models explain themselves."""

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from stickslip import models

ROOT = Path(models.__file__).parent.parent
ALLOWED = {
    "fmi": set(),
    "models": {"fmi"},
    "cosim": {"fmi"},
    "fmucheck": {"fmi"},
    "ga": {"cosim", "fmi"},
    "stickslip": {"fmucheck", "ga", "cosim", "models", "fmi"},
}
# From the lowest to the highest: each room uses those before it and those beside it.
ROOMS_OF_COSIM = (
    *("errors display", "kernel", "component fmu", "signals", "system", "function"),
    *("assembly", "run", "isolation", "control", "ssp", "container"),
)
# The ground first. A room imports rooms before it only; a study or paper is a room of its own.
ROOMS_OF_STICKSLIP = (
    *("thresholds", "errors", "versions", "toml_files", "output"),
    *("storage", "catalog", "servo", "presentation", "work", "compensators", "planning"),
    *("logs", "rigs", "identification", "evaluation", "tuning", "trial", "learned", "loops"),
    *("arguments", "keywords", "simulation", "contents", "laws", "blocks", "figures"),
    *("sweeping", "system", "drives"),
    *("commandline", "studies.arena", "studies.survey", "studies.learn", "papers.lugre"),
    *("studies.compare", "studies.fleet", "studies.tune", "studies.validate"),
    *("app", "precompile", "commands", "cli", "__main__"),
)
# ``prepare`` of a system imports what runs it when it is called, and for its annotation.
LATE = {
    ("stickslip.cosim.system.system", f"stickslip.cosim.{room}.simulation")
    for room in ("run", "isolation")
}
MOST_POSITIONS, MOST_PARAMETERS = 4, 8
UNCOUNTED = ("stickslip.papers.lugre", "stickslip.studies.arena")
"""Rooms that still have more; to be emptied."""
MANY_PARAMETERS = {
    "close_velocity_loop": "public: a loop has its gains and times, each a keyword of the user",
    "learn": "public: each is a keyword of the user",
    "optimise": "public: each is a keyword of the user",
    "tune": "public: each is a keyword of the user",
}
FOUR_FILES = {"model.toml", "model.c", "README.md", "reference.csv"}


def modules(package: str) -> Iterator[Path]:
    yield from sorted((ROOT / package).rglob("*.py"))


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def nodes(tree: ast.Module) -> tuple[ast.AST, ...]:
    """Return the imports, definitions and calls of a module, wherever in it."""
    looked_at = (ast.Import, ast.ImportFrom, ast.FunctionDef, ast.ClassDef, ast.Call)
    return tuple(n for n in ast.walk(tree) if isinstance(n, looked_at))


@cache
def sources() -> dict[str, ast.Module]:
    """Return the modules of the product by import name."""
    found = {}
    for package in ALLOWED:
        for path in modules(package):
            name = ".".join(path.relative_to(ROOT / package).with_suffix("").parts)
            above = package if package == "stickslip" else f"stickslip.{package}"
            name = f"{above}.{name}".removesuffix(".__init__")
            found[name] = parsed(path)
    return found


def targets(node: ast.AST) -> Iterator[str]:
    """Yield the modules of the product that an import statement names."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names if alias.name in sources())
    elif isinstance(node, ast.ImportFrom) and node.module:
        for alias in node.names:
            full = f"{node.module}.{alias.name}"
            yield from [name for name in (full, node.module) if name in sources()][:1]


@cache
def edges() -> tuple[tuple[str, str], ...]:
    """Return which module imports which other, wherever in it, but for those named above."""
    return tuple(
        (module, name)
        for module, tree in sources().items()
        for node in nodes(tree)
        for name in targets(node)
        if name != module and (module, name) not in LATE
    )


def folder_of(module: str) -> str:
    """Return the folder of a module, which for the application is ``stickslip``."""
    below = module.partition(".")[2].split(".")[0]
    return below if below in ALLOWED else "stickslip"


def room_of(module: str) -> str:
    """Return the room of a module of the application, its folder or, on top, the module itself."""
    parts = module.split(".")[1:]
    if folder_of(module) != "stickslip" or parts in ([], ["studies"], ["papers"]):
        return ""
    return ".".join(parts[: 2 if parts[0] in ("studies", "papers") else 1])


def room_of_cosim(module: str) -> str:
    return module.removeprefix("stickslip.cosim.").split(".")[0] if ".cosim." in module else ""


def test_arrows_run_down():
    wrong = [
        f"{module} imports {name}"
        for module, name in edges()
        if folder_of(name) not in {folder_of(module), *ALLOWED[folder_of(module)]}
    ]
    assert not wrong


def test_no_circle_of_modules():
    graph = defaultdict(set)
    for module, name in edges():
        graph[module].add(name)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as fault:
        pytest.fail(f"circle: {' -> '.join(fault.args[1])}")


@pytest.mark.parametrize(
    ("rooms", "room"), [(ROOMS_OF_COSIM, room_of_cosim), (ROOMS_OF_STICKSLIP, room_of)]
)
def test_rooms_have_an_order(rooms, room):
    """A module imports from its own room, from rooms beside it and from rooms before it."""
    place = {one: k for k, beside in enumerate(rooms) for one in beside.split()}
    wrong = [
        f"{module} imports {name}"
        for module, name in edges()
        if room(module) and room(name) and place[room(name)] > place[room(module)]
    ]
    assert not wrong
    assert {*map(room, sources())} == {"", *place}


def test_the_workbench_uses_the_public_interface():
    own = [(module, name) for module, name in edges() if room_of(module) == "app"]
    assert {name for _, name in own if room_of(name) != "app"} == {"stickslip"}


def counted() -> Iterator[tuple[str, ast.AST]]:
    """Yield ``nodes`` of the application's modules, with the module, but for rooms uncounted."""
    for module, tree in sources().items():
        application = module.count(".") and module.split(".")[1] not in ALLOWED
        if application and not module.startswith(UNCOUNTED):
            yield from ((module, node) for node in nodes(tree))


def parameters(function: ast.FunctionDef) -> list[str]:
    given = function.args
    names = [one.arg for one in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    return [name for name in names if name not in ("self", "cls")]


def definitions() -> dict[str, bool]:
    """Return whether a function or class takes any number of positions, by name."""
    found: dict[str, bool] = {}
    for tree in sources().values():
        for node in nodes(tree):
            if isinstance(node, ast.FunctionDef):
                found[node.name] = found.get(node.name, False) or bool(node.args.vararg)
            elif isinstance(node, ast.ClassDef):
                made = [one for one in node.body if getattr(one, "name", "") == "__init__"]
                found[node.name] = any(one.args.vararg for one in made)
    return found


def test_few_positions_in_a_call():
    """A call of ours names what comes after four positions, unless it takes any number of them.

    A starred sequence counts as two.
    """
    known, wrong = {**definitions(), "cls": False, "__init__": False}, []
    for module, node in counted():
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Name | ast.Attribute):
            continue
        name = node.func.id if isinstance(node.func, ast.Name) else node.func.attr
        positions = len(node.args) + sum(isinstance(one, ast.Starred) for one in node.args)
        if positions > MOST_POSITIONS and not known.get(name, True):
            wrong.append(f"{module}:{node.lineno}: {name} takes {positions} positions")
    assert not wrong


def test_few_parameters_of_a_function():
    wrong = [
        f"{module}: {node.name} has {len(parameters(node))} parameters"
        for module, node in counted()
        if isinstance(node, ast.FunctionDef) and len(parameters(node)) > MOST_PARAMETERS
        if node.name not in MANY_PARAMETERS
    ]
    assert not wrong


def described(folder: Path) -> str:
    return (folder / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", models.model_names())
def test_a_model_is_four_files(name):
    """The expected results of the feedforward compensator lie with its law."""
    folder = models.load_model(name).folder
    lacks = {"reference.csv"} if name == "compensator" else set()
    assert {path.name for path in folder.iterdir()} == FOUR_FILES - lacks


@pytest.mark.parametrize(
    ("name", "law"),
    [
        (name, law)
        for name in models.model_names()
        for law in (models.law_names() if models.load_model(name).law else [None])
    ],
)
def test_a_readme_explains_every_variable(name, law):
    """Every variable occurs in the README of its model or of its law, with its unit."""
    model = models.load_model(name, law)
    text = described(model.folder) + (described(model.law.folder) if model.law else "")
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    for variable in model.variables[1:]:
        symbol = re.sub(r"\[[\d,]+\]", "", variable.name)
        row = [line for line in rows if f"`{symbol}`" in line]
        assert row, f"{symbol} is in no table"
        if variable.unit not in (None, "1"):
            unit = variable.unit.replace("m/s2", "m/s²").replace("N.s/m", "N s/m")
            assert any(f"| {unit} |" in line for line in row), f"{symbol} is not in {unit}"


@pytest.mark.parametrize("name", models.law_names())
def test_a_law_has_its_files(name):
    present = {path.name for path in models.load_law(name).folder.iterdir()}
    assert present >= {"law.toml", "law.c", "README.md", "reference.csv"}


@pytest.mark.parametrize("room", ["laws", "plants", "compensators", "controllers"])
def test_physics_knows_no_fmi(room):
    """The C names no standard, allocates nothing and keeps nothing between calls."""
    files = [*(ROOT / "models" / room).rglob("*.[ch]")]
    assert files
    for path in files:
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"fmi|malloc|calloc|free\(", text, re.IGNORECASE)
        assert not re.search(r"^static (?!const)\w+ \w+( =|;)", text, re.MULTILINE)
