/* FMI 3.0 for Model Exchange over face.h. */
#include "fmi3.h"

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    REQUIRE(CONTINUOUS);
    return (fmi3Status)exchange_enter(instance, EVENT);
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation,
                                    fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged,
                                    fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime) {
    REQUIRE(EVENT);
    NEED(discreteStatesNeedUpdate && terminateSimulation && nominalsOfContinuousStatesChanged &&
         valuesOfContinuousStatesChanged && nextEventTimeDefined && nextEventTime);
    *discreteStatesNeedUpdate = false;
    *terminateSimulation = false;
    *nominalsOfContinuousStatesChanged = false;
    *valuesOfContinuousStatesChanged = false;
    return (fmi3Status)exchange_update(instance, nextEventTimeDefined, nextEventTime);
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) {
    REQUIRE(EVENT);
    return (fmi3Status)exchange_enter(instance, CONTINUOUS);
}

/* Nothing depends on where the solver's steps end. */
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance,
                                       fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode,
                                       fmi3Boolean *terminateSimulation) {
    REQUIRE(CONTINUOUS);
    NEED(enterEventMode && terminateSimulation);
    *enterEventMode = false;
    *terminateSimulation = false;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) {
    REQUIRE(EVENT | CONTINUOUS);
    return (fmi3Status)exchange_set_time(instance, time);
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates) {
    REQUIRE(CONTINUOUS);
    NEED(!nContinuousStates || continuousStates);
    return (fmi3Status)exchange_set_states(instance, continuousStates, nContinuousStates);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[],
                                             size_t nContinuousStates) {
    REQUIRE(INITIALIZATION | EVENT | CONTINUOUS | ENDED);
    NEED(!nContinuousStates || derivatives);
    return (fmi3Status)exchange_get_derivatives(instance, derivatives, nContinuousStates);
}

/* The equations are continuous in all their variables: there is nothing to indicate. */
fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[],
                                  size_t nEventIndicators) {
    REQUIRE(INITIALIZATION | EVENT | CONTINUOUS | ENDED);
    REQUIRE_COUNT(0, nEventIndicators);
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[],
                                   size_t nContinuousStates) {
    REQUIRE(INITIALIZATION | EVENT | CONTINUOUS | ENDED);
    NEED(!nContinuousStates || continuousStates);
    return (fmi3Status)exchange_get_states(instance, continuousStates, nContinuousStates);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[],
                                             size_t nContinuousStates) {
    REQUIRE(INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS | ENDED);
    NEED(!nContinuousStates || nominals);
    return (fmi3Status)exchange_get_nominals(instance, nominals, nContinuousStates);
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators) {
    REQUIRE(ANY);
    NEED(nEventIndicators);
    *nEventIndicators = 0;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates) {
    REQUIRE(ANY);
    NEED(nContinuousStates);
    *nContinuousStates = exchange_count(instance);
    return fmi3OK;
}
