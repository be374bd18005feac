"""Every public function and class names the argument that is of another class."""

import inspect
import pickle
from collections.abc import Callable

import pandas as pd
import pytest

import stickslip as ss
from stickslip.arguments import checked
from stickslip.fmi.errors import Fault

CALLED = [
    name
    for name in ss.__all__
    if not (inspect.ismodule(one := getattr(ss, name)) or inspect.isabstract(one) or one is Fault)
    if inspect.signature(one).parameters
]


def positions(call):
    """Return the names of the arguments that have to be given, and of the first in any case."""
    given = [*inspect.signature(call).parameters.values()]
    return [one.name for k, one in enumerate(given) if not k or one.default is one.empty]


@pytest.mark.parametrize("value", [3, "x", None, (1, 2)], ids=repr)
@pytest.mark.parametrize("name", CALLED)
def test_an_argument_of_another_class_is_named(name, value, tmp_path, monkeypatch):
    call = getattr(ss, name)
    names, parameters = positions(call), inspect.signature(call).parameters
    if parameters[names[0]].default is value:
        pytest.skip("the default")
    monkeypatch.chdir(tmp_path)
    try:
        call(**dict.fromkeys(names, value))
    except (Fault, TypeError, OSError) as error:
        wrong = names if isinstance(error, TypeError) else (*parameters, str(value))
        assert any(word in str(error) for word in wrong)  # noqa: PT017 - of some classes
    else:
        assert inspect.isclass(call)  # an object that keeps what it is given


@pytest.mark.parametrize("name", CALLED)
def test_an_unknown_argument_gets_the_name_of_one_that_is_there(name):
    call = getattr(ss, name)
    known = positions(call)[0]
    with pytest.raises(TypeError, match=rf"no argument '{known}_'; .*\b{known}\b"):
        call(**{f"{known}_": None})


def test_a_method_names_itself_and_what_may_have_been_meant():
    expected = "^System.simulate has no argument 'stop_time'; did you mean 'stop'"
    with pytest.raises(TypeError, match=expected):
        ss.System("loop").simulate(stop_time=1.0)


def test_a_value_without_a_name_that_needs_one_gets_the_names():
    with pytest.raises(TypeError, match=r"^System.simulate: 4.0: give it by name; .*\bstop\b"):
        ss.System("loop").simulate(4.0)


def test_lists_and_series_are_arrays():
    assert ss.Table([0.0, 0.3], pd.Series([1.0, 2.0])).time[1] == 0.3


def test_an_error_of_a_function_of_the_user_stays_as_it_is():
    @checked
    def run(work: Callable[[], object], times: int) -> None:
        for _ in range(times):
            work()

    with pytest.raises(AttributeError, match="missing"):
        run(lambda: (0).missing, 1)
    with pytest.raises(TypeError, match="run: times: expected int, got 'x'"):
        run(lambda: None, "x")


def test_a_text_is_no_list_of_texts():
    with pytest.raises(TypeError, match=r"^arena: only: expected Sequence\[str\], got 'lugre'"):
        ss.arena(only="lugre")


def test_public_functions_go_to_other_processes():
    assert pickle.loads(pickle.dumps(ss.simulate)) is ss.simulate  # noqa: S301


def test_times_of_a_package_are_given_by_name(tmp_path):
    system = ss.System("push")
    system.add("stage", ss.build_fmu("stage", tmp_path))
    path = ss.write_ssp(system, tmp_path / "push.ssp", stop=1.0, step=1e-3)
    assert ss.read_ssp(path)[1] == ss.cosim.DefaultExperiment(stop=1.0, step=1e-3)
    given = ss.cosim.DefaultExperiment(start=0.5, stop=3.0)
    path = ss.write_ssp(system, path, given, stop=1.0)
    assert ss.read_ssp(path)[1] == ss.cosim.DefaultExperiment(start=0.5, stop=1.0)
