"""The house stands as it was drawn: arrows run down, public names explain themselves."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
from collections.abc import Iterator
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
FOUR_FILES = {"model.toml", "model.c", "README.md", "reference.csv"}


def imported_as(package: str) -> str:
    return package if package == "stickslip" else f"stickslip.{package}"


def modules(package: str) -> Iterator[Path]:
    yield from sorted((ROOT / package).rglob("*.py"))


def imported(tree: ast.AST) -> Iterator[str]:
    """Yield the packages of stickslip that a module imports, by folder, wherever in it."""
    for node in ast.walk(tree):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            top, _, rest = f"{name}.".partition(".")
            if top == "stickslip":
                below = rest.split(".")[0]
                yield below if below in ALLOWED else "stickslip"


@pytest.mark.parametrize("package", ALLOWED)
def test_arrows_run_down(package):
    wrong = [
        f"{path.relative_to(ROOT)} imports {name}"
        for path in modules(package)
        for name in imported(ast.parse(path.read_text(encoding="utf-8")))
        if name not in {package, *ALLOWED[package]}
    ]
    assert not wrong


@pytest.mark.parametrize("package", ALLOWED)
def test_nothing_is_imported_relatively(package):
    """Absolute imports only, so that the arrows can be read off the import lines."""
    relative = [
        str(path.relative_to(ROOT))
        for path in modules(package)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and node.level
    ]
    assert not relative


@pytest.mark.parametrize("package", ALLOWED)
def test_every_module_has_a_docstring(package):
    silent = [
        str(path.relative_to(ROOT))
        for path in modules(package)
        if not ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert not silent


def public(package: str) -> Iterator[tuple[str, object]]:
    """Yield the public names of a package, and the public methods of its classes."""
    module = importlib.import_module(imported_as(package))
    for name in getattr(module, "__all__", []):
        item = getattr(module, name)
        yield f"{package}.{name}", item
        if inspect.isclass(item):
            for key, member in vars(item).items():
                function = member.fget if isinstance(member, property) else member
                if not key.startswith("_") and inspect.isfunction(function):
                    yield f"{package}.{name}.{key}", function


@pytest.mark.parametrize("package", [*ALLOWED, "cosim.control"])
def test_public_names_have_docstrings(package):
    """A dataclass without one would get its signature for a docstring, which does not count."""
    silent = [
        name
        for name, item in public(package)
        if (inspect.isclass(item) or inspect.isroutine(item))
        and (not item.__doc__ or item.__doc__.startswith(f"{name.rpartition('.')[2]}("))
    ]
    assert not silent


@pytest.mark.parametrize("package", ["stickslip", "models", "cosim", "fmucheck", "ga"])
def test_public_names_are_listed(package):
    """`__all__` is sorted the way ruff sorts it, complete, and all of it exists."""
    module = importlib.import_module(imported_as(package))
    assert module.__all__
    assert all(hasattr(module, name) for name in module.__all__)


def described(folder: Path) -> str:
    return (folder / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", models.model_names())
def test_a_model_is_four_files(name):
    """The expected results of the feedforward compensator lie with its law."""
    folder = models.load_model(name).folder
    lacks = {"reference.csv"} if name == "compensator" else set()
    assert {path.name for path in folder.iterdir()} == FOUR_FILES - lacks


@pytest.mark.parametrize("law", models.law_names())
@pytest.mark.parametrize("name", models.model_names())
def test_a_readme_explains_every_variable(name, law):
    """Every variable occurs in the README of its model or of its law, with its unit."""
    default = models.load_model(name)
    model = models.load_model(name, law if default.law else None)
    text = described(model.folder) + (described(model.law.folder) if model.law else "")
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    for variable in model.variables[1:]:
        symbol = re.sub(r"\[.*", "", variable.name)
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
