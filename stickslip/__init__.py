"""stickslip learns a friction compensator for a servo drive, in FMUs.

>>> import stickslip as ss
>>> system = ss.System("loop")
>>> result = ss.simulate("drive.fmu", stop=2.0, inputs={"u": 1.0})
>>> learned = ss.learn("log.csv")

The public names are loaded when they are first used; ``__init__.pyi`` tells type checkers of them.
Below are the packages: ``stickslip.cosim`` couples and steps FMUs, ``stickslip.ga`` optimises,
``stickslip.models`` builds FMUs, ``stickslip.fmucheck`` checks them, ``stickslip.servo`` designs
velocity loops. The errors of the application are drawn in ``stickslip/errors.py``.
"""

from importlib import import_module

_PLACES = {
    "stickslip.cosim": (
        *("Adaptive", "Coupling", "Fmu", "Function", "Record", "Result", "Scenario", "Simulation"),
        *("SineSweep", "Specification", "Table", "Trapezoid"),
        *("read_tables", "write_fmu", "write_ssp"),
    ),
    "stickslip.cosim.control": ("linearise", "measure_response"),
    "stickslip.contents": ("info",),
    "stickslip.studies.arena.comparison": ("arena",),
    "stickslip.fmi.errors": ("Fault",),
    "stickslip.fmucheck": ("check",),
    "stickslip.laws": ("run_law",),
    "stickslip.logs": ("Column", "Description"),
    "stickslip.models": ("build_fmu", "export_lti", "law_names"),
    "stickslip.models.firmware": ("write_compensator",),
    "stickslip.identification.estimation": ("LearnSettings",),
    "stickslip.studies.learn.log_learning": ("learn",),
    "stickslip.studies.learn.rig_learning": ("learn_on_rig", "validate"),
    "stickslip.learned.file": ("load_learned", "save_learned"),
    "stickslip.studies.learn.folder": ("write_learned",),
    "stickslip.planning": ("Limits", "plan"),
    "stickslip.presentation.bode": ("draw_bode",),
    "stickslip.rigs.ads_rig": ("AdsRig",),
    "stickslip.rigs.contract": ("Command", "Log", "Rig"),
    "stickslip.rigs.file": ("KeptRig", "open_rig"),
    "stickslip.rigs.fmu": ("FmuRig",),
    "stickslip.rigs.limits": ("RigLimits",),
    "stickslip.rigs.socket_rig": ("SocketRig",),
    "stickslip.servo.axis": ("Axis", "Datasheet", "LoopSpecification"),
    "stickslip.servo.chain_response": ("closed_loop", "robustness"),
    "stickslip.servo.observer": ("design_observer",),
    "stickslip.servo.systems": ("Compensator", "nominal_parameters"),
    "stickslip.servo.velocity_filter": ("design_velocity_filter",),
    "stickslip.servo.velocity_loop": (
        *("VelocityLoop", "close_velocity_loop", "design_velocity_loop"),
    ),
    "stickslip.simulation": ("simulate",),
    "stickslip.studies.tune.run": ("tune",),
    "stickslip.studies.tune.writing": ("write_tuned",),
    "stickslip.sweeping": ("optimise", "sweep"),
    "stickslip.system": ("System", "read_ssp"),
}
_BELOW = ("blocks", "cosim", "fmucheck", "ga", "models", "servo")
_PLACE = {name: place for place, names in _PLACES.items() for name in names}

__all__ = [*_PLACE, *_BELOW]


def __getattr__(name: str) -> object:
    """Import a public name when it is first used."""
    if name == "__version__":
        from importlib.metadata import version  # late, for those who start quickly

        return version("stickslip")
    if name in _BELOW:
        return import_module(f"stickslip.{name}")
    if name not in _PLACE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_PLACE[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "__version__"})
