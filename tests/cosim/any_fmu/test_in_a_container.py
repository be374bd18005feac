"""What a container does not take, and does not show."""

import pytest

from stickslip import cosim


@pytest.mark.parametrize(
    ("connected", "interface"),
    [("Int32", "co_simulation"), ("Float64", "model_exchange")],
)
def test_integers_and_model_exchange_are_refused(export, tmp_path, connected, interface):
    system = cosim.System("two")
    kinds = {"co_simulation": "CS", "model_exchange": "ME"}
    for name in "ab":
        system.add(name, export("feedthrough", 3, kinds[interface]), interface=interface)
    system.connect(f"a.{connected}_out", f"b.{connected}_in")
    with pytest.raises(cosim.FmuError, match=r"a \(.*cannot go into a container: it needs Model"):
        cosim.write_fmu(system, tmp_path / "a.fmu", step=0.1)


def test_outputs_that_are_no_doubles_are_not_shown(export, tmp_path):
    system = cosim.System("one")
    system.add("a", export("feedthrough", 2, "CS"))
    shown = cosim.Fmu(cosim.write_fmu(system, tmp_path / "a.fmu", step=0.1)).variables
    assert "a.Float64_out" in shown
    assert {v.type for v in shown.values() if v.causality == "output"} == {"Real"}
