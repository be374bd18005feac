"""Which functions a binary must export."""

from __future__ import annotations

_TYPES3 = [f"{sign}Int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "U")]
_TYPES3 += ["Float32", "Float64", "Boolean", "String", "Binary", "Clock"]

_COMMON2 = """
    GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment
    EnterInitializationMode ExitInitializationMode Terminate Reset
    GetReal GetInteger GetBoolean GetString SetReal SetInteger SetBoolean SetString
    GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize SerializeFMUstate
    DeSerializeFMUstate GetDirectionalDerivative
"""
_ONLY2 = {
    "ModelExchange": """
        EnterEventMode NewDiscreteStates EnterContinuousTimeMode CompletedIntegratorStep SetTime
        SetContinuousStates GetDerivatives GetEventIndicators GetContinuousStates
        GetNominalsOfContinuousStates
    """,
    "CoSimulation": """
        SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep GetStatus GetRealStatus
        GetIntegerStatus GetBooleanStatus GetStringStatus
    """,
}
_COMMON3 = """
    GetVersion SetDebugLogging FreeInstance EnterInitializationMode ExitInitializationMode
    EnterEventMode Terminate Reset GetNumberOfVariableDependencies GetVariableDependencies
    GetFMUState SetFMUState FreeFMUState SerializedFMUStateSize SerializeFMUState
    DeserializeFMUState GetDirectionalDerivative GetAdjointDerivative EnterConfigurationMode
    ExitConfigurationMode GetIntervalDecimal GetIntervalFraction GetShiftDecimal GetShiftFraction
    SetIntervalDecimal SetIntervalFraction SetShiftDecimal SetShiftFraction
    EvaluateDiscreteStates UpdateDiscreteStates
"""
_ONLY3 = {
    "ModelExchange": """
        InstantiateModelExchange EnterContinuousTimeMode CompletedIntegratorStep SetTime
        SetContinuousStates GetContinuousStateDerivatives GetEventIndicators GetContinuousStates
        GetNominalsOfContinuousStates GetNumberOfEventIndicators GetNumberOfContinuousStates
    """,
    "CoSimulation": "InstantiateCoSimulation EnterStepMode GetOutputDerivatives DoStep",
    "ScheduledExecution": "InstantiateScheduledExecution ActivateModelPartition",
}


def required(version: int, interface: str) -> list[str]:
    """Return the names of all functions of an interface, those of optional abilities included."""
    if version == 2:
        words = f"{_COMMON2} {_ONLY2.get(interface, '')}".split()
    else:
        words = f"{_COMMON3} {_ONLY3[interface]}".split()
        words += [verb + kind for kind in _TYPES3 for verb in ("Get", "Set")]
    return [f"fmi{version}{word}" for word in words]
