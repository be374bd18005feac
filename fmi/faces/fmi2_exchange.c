/* FMI 2.0 for Model Exchange over face.h. */
#include "fmi2.h"

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    REQUIRE(CONTINUOUS);
    return (fmi2Status)exchange_enter(c, EVENT);
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    REQUIRE(EVENT);
    NEED(info);
    bool defined;
    double next;
    if (exchange_update(c, &defined, &next) != OK)
        return fmi2Error;
    *info = (fmi2EventInfo){.nextEventTimeDefined = defined, .nextEventTime = next};
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    REQUIRE(EVENT);
    return (fmi2Status)exchange_enter(c, CONTINUOUS);
}

/* Nothing depends on where the solver's steps end. */
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c,
                                       fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode,
                                       fmi2Boolean *terminateSimulation) {
    REQUIRE(CONTINUOUS);
    NEED(enterEventMode && terminateSimulation);
    *enterEventMode = fmi2False;
    *terminateSimulation = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    REQUIRE(EVENT | CONTINUOUS);
    return (fmi2Status)exchange_set_time(c, time);
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx) {
    REQUIRE(CONTINUOUS);
    NEED(!nx || x);
    return (fmi2Status)exchange_set_states(c, x, nx);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx) {
    REQUIRE(INITIALIZATION | EVENT | CONTINUOUS | ENDED);
    NEED(!nx || derivatives);
    return (fmi2Status)exchange_get_derivatives(c, derivatives, nx);
}

/* The equations are continuous in all their variables: there is nothing to indicate. */
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni) {
    REQUIRE(INITIALIZATION | EVENT | CONTINUOUS | ENDED);
    return ni ? (fmi2Status)instance_mismatch(c, 0, ni, __func__) : fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx) {
    REQUIRE(INITIALIZATION | EVENT | CONTINUOUS | ENDED);
    NEED(!nx || x);
    return (fmi2Status)exchange_get_states(c, x, nx);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx) {
    REQUIRE(INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS | ENDED);
    NEED(!nx || x_nominal);
    return (fmi2Status)exchange_get_nominals(c, x_nominal, nx);
}
