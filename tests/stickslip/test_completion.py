"""Keywords of the public functions are completed in a notebook, and are those that are taken."""

from dataclasses import fields
from inspect import Parameter, signature

import pytest
from IPython.core.completer import provisionalcompleter
from IPython.core.interactiveshell import InteractiveShell

import stickslip as ss
from stickslip.keywords import DEFAULTS, RunOptions, SearchOptions, SweepOptions
from stickslip.thresholds import harm
from tests.kept import further

RUNS = (ss.simulate, ss.sweep, ss.optimise, ss.System.simulate, ss.System.sweep, ss.tune)


@pytest.fixture(scope="module")
def shell():
    shell = InteractiveShell(warn_venv=False)  # of another one that is active
    shell.user_ns |= {"ss": ss, "system": ss.System("loop")}
    return shell


@pytest.mark.parametrize(
    ("typed", "completed"),
    [
        ("system.sim", "simulate"),
        ("system.simulate(tol", "tolerance="),
        ("ss.simulate(fmu, iso", "isolation="),
        ("ss.learn(log, comp", "compensator="),
        *further(("ss.sweep(fmu, {}, {}, sto", "stop="), ("ss.tune(fmu, force", "force_limit=")),
    ],
)
def test_a_notebook_completes(shell, typed, completed):
    with provisionalcompleter():
        found = {one.text.lstrip(".") for one in shell.Completer.completions(typed, len(typed))}
    assert completed in found


@pytest.mark.parametrize("function", RUNS, ids=lambda one: one.__qualname__)
def test_a_run_takes_what_preparing_it_takes(function):
    taken, known = signature(function).parameters, signature(ss.cosim.System.prepare).parameters
    assert {*known} - {"self"} == {*RunOptions.__annotations__} <= {*taken}
    assert Parameter.VAR_KEYWORD not in {one.kind for one in taken.values()}
    for name in {*known} - {"self", "start", "stop", "step"}:
        assert taken[name].default == known[name].default


@pytest.mark.parametrize(
    ("function", "options"), [(ss.sweep, SweepOptions), (ss.optimise, SearchOptions)]
)
def test_a_method_takes_what_its_function_takes(function, options):
    taken = signature(function).parameters
    assert {name: taken[name].default for name in options.__annotations__} == {
        name: DEFAULTS[name] for name in options.__annotations__
    }
    assert {*taken} == {*options.__annotations__, *[*taken][:3]}


def test_learning_takes_the_fields_of_its_settings():
    taken, given = signature(ss.learn).parameters, ss.LearnSettings()
    for name in (one.name for one in fields(given)):
        default = taken[name].default
        assert default == getattr(given, name) or default is None
    assert given.friction_range == harm.levels()


def test_a_keyword_of_the_other_kind_is_refused(tmp_path):
    path = tmp_path / "learned.json"
    with pytest.raises(ss.Fault, match="step is of a system, and this is a learned drive"):
        ss.tune(path, step=1e-3)
    with pytest.raises(ss.Fault, match="fixed is of a learned drive; expected a learned"):
        ss.tune("loop.ssp", {"K_p": (1.0, 2.0)}, abs, fixed=["observer"])
