"""What an FMU says of itself is true."""

from itertools import product

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from stickslip import models
from stickslip.fmi.toolchain import cache_directory
from tests.conformance.conftest import Fmu
from tests.kept import further


def test_fmpy_finds_nothing_to_complain_about(some_fmu):
    assert validate_fmu(str(some_fmu.path)) == []


def test_description_and_model_toml_list_the_same_variables(fmu):
    assert len(fmu.variables) == len(fmu.listed)
    for place, variable in fmu.listed.items():
        described = fmu.variables[variable.name]
        assert described.valueReference == place
        assert described.unit == variable.unit
        assert described.description
        bounds = (described.min, described.max)
        assert [None if b is None else float(b) for b in bounds] == [
            variable.minimum,
            variable.maximum,
        ]


@pytest.mark.parametrize("name", ["drive", "compensator+gms", "nominal_loop"])
def test_start_values_given_to_the_exporter_reach_description_and_binary(
    name, tmp_path, build, slave
):
    model = build(name, 2).model
    first = next(v for v in model.variables if v.role == "parameter" and v.start)
    path = models.build_fmu(
        model.name, tmp_path, start={first.name: 2 * first.start}, law=model.law and model.law.name
    )
    built = Fmu(path, 2, name)
    assert float(built.variables[first.name].start) == 2 * first.start
    assert slave(built).initialize().get([first.name]) == [2 * first.start]
    assert built.description.guid != build(name, 2).description.guid


def test_declared_dependences_exist(fmu, slave):
    """It shows in the first step or after some motion, with all modes on or all as they start."""
    absent = {
        v.name: v.nominal or 1.0
        for v in fmu.model.variables
        if v.role == "parameter"
        and v.start == 0.0
        and (v.type == "boolean" or (v.type == "real" and v.maximum))
    }

    def answer(output, variable, change, settings, moved):
        value = {variable.name: change * float(variable.nominal or 1.0)}
        before = value if variable.causality != "input" else {}  # a state
        instance = slave(fmu).initialize(settings | before)
        instance.run(0, moved)
        instance.set(value if not before else {})
        instance.api.doStep(moved * 5e-4, (moved + 1) * 5e-4 - moved * 5e-4)
        return instance.get([output])[0]

    for unknown in fmu.description.outputs:
        output = unknown.variable.name
        for variable in unknown.dependencies:
            assert any(
                answer(output, variable, 0.0, *tried) != answer(output, variable, 0.1, *tried)
                for tried in product((absent, {}), (0, 2, 10, 30))
            ), f"{output} does not depend on {variable.name}"


def test_initial_unknowns_depend_on_what_is_declared_and_on_nothing_else(fmu, slave, exchanged):
    """Each variable that may be set before is moved alone, from points where all matters."""
    chosen = {}
    for v in fmu.model.variables:
        if v.role in ("input", "state", "parameter") and v.type == "real":
            small = 1e-4 if v.unit == "m" else 0.3
            # No two are equal, so that the shares of elements matter.
            chosen[v.name] = v.start or small * (1 + 0.01 * len(chosen)) * (v.nominal or 1.0)
        if v.role == "state" and v.maximum is not None:  # a mode: every second one is on
            chosen[v.name] = v.maximum * (len(chosen) % 2)
    if {"z", "z_ba"} <= chosen.keys():  # a deflection between break-away and full slip
        chosen["z"] = 1.3e-5
    if "v_d" in chosen:  # and a damping that fades there
        chosen["v_d"] = 0.3
    chosen |= fmu.settings()
    if "encoder_step" in chosen:
        chosen["encoder_step"] = 1e-14  # below the noise and the error
    declared = fmu.description.initialUnknowns
    unknown = {u.variable.name: {d.name for d in u.dependencies} for u in declared}
    assert set(unknown) == set(fmu.names("derivative", "output")) - set(fmu.names("state"))
    faces = (slave, exchanged)[: 1 + fmu.model.has_model_exchange]
    instances = [face(fmu) for face in faces]

    def at(values):
        for instance in instances:
            instance.api.reset()
            instance.initialize(values, start=100.0)  # what depends on time is not at its start
        return np.array([instance.get(list(unknown)) for instance in instances])

    points = [chosen]
    if "mode" in chosen:  # a contact that is in one mode as a whole; its delay is off and on
        points = [
            chosen | {"mode": 1.0},
            chosen | {"mode": 0.0},
            chosen | {"mode": 1.0, "tau_L": 0.0},
        ]
    if "mode[1]" in chosen:  # elements in the other mode
        points.append(chosen | {n: 1.0 - x for n, x in chosen.items() if n.startswith("mode[")})
    if {"W[1]", "q[1]"} <= chosen.keys():  # elements that slip at a lower limit
        k = np.array([chosen[f"kappa[{i}]"] for i in range(1, 5)])
        k *= chosen["sigma_0"] / k.sum()
        slips = {i: chosen[f"W[{i}]"] * chosen["F_c"] / k[i - 1] for i in range(1, 4)}
        points.append(chosen | {f"q[{i}]": 0.95 * q for i, q in slips.items()})
    if "F_h" in chosen:  # at rest
        points.append(chosen | {"v": 0.0})
    felt = {name: set() for name in unknown}
    for point in points:
        base = at(point)
        for name, value in point.items():
            whole = {"Boolean": 0, "Int32": 5, "Integer": 5}
            other = whole.get(fmu.variables[name].type, 0.9 * value or 1.0)
            for k in np.flatnonzero((at(point | {name: other}) != base).any(axis=0)):
                felt[list(unknown)[k]].add(name)
    for name in unknown:
        assert felt[name] == unknown[name], name


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "version", "recompiled"),
    [("drive", 2, False), *further(("drive", 2, True), ("stage", 3, True))],
)
def test_the_same_sources_give_the_same_bytes_in_another_folder_and_cache(
    tmp_path_factory, monkeypatch, build, name, version, recompiled
):
    """The compiler keeps its own files where they are, unless all of it is compiled again."""
    cache = tmp_path_factory.mktemp("cache")
    if not recompiled:
        (cache / "zig").symlink_to(cache_directory() / "zig")
    monkeypatch.setenv("STICKSLIP_CACHE", str(cache))
    folder = tmp_path_factory.mktemp("elsewhere, with blanks")
    again = models.build_fmu(name, folder, fmi=version)
    assert again.read_bytes() == build(name, version).path.read_bytes()
