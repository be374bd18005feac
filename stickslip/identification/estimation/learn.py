"""From one recording to a drive's parameters, with the identifiability of each.

Search (genetic algorithm, inverse model) -> fit (least squares) -> for a known loop: output error,
whitened, and corrected by a parametric bootstrap -> identifiability.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from stickslip import ga
from stickslip.catalog.parameters import Values, friction_law, presliding
from stickslip.identification.criteria import motion
from stickslip.identification.criteria.controller_check import check_controllers
from stickslip.identification.criteria.goodness_of_fit import goodness_of_fit
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import KnownLoop, OutputError
from stickslip.identification.estimation.agreement import contradictions
from stickslip.identification.estimation.estimation import Estimation, restored
from stickslip.identification.estimation.faults import (
    change_of_friction,
    check_held_out,
    found_faults,
    hidden,
)
from stickslip.identification.estimation.task import Task, choose
from stickslip.identification.fitting import bootstrap
from stickslip.identification.fitting.fit import (
    BLOCKS,
    ROUGH,
    Fit,
    fit,
    plausible,
    value_errors,
)
from stickslip.identification.fitting.identifiability import (
    among_laws,
    beside_force,
    conservative,
    identifiability,
    largest_friction,
    least_errors,
    of_ratios,
    of_sliding,
    profiles,
    unreliable,
)
from stickslip.identification.fitting.search import (
    best_fit,
    search,
    select,
    solve_linear,
    variants,
    without_stribeck,
)
from stickslip.identification.fitting.start import Start, begin
from stickslip.identification.sliding.friction_curve import VARYING, Interval
from stickslip.output import SILENT, Progress, step
from stickslip.servo.measurement import Array
from stickslip.thresholds import control_match, curve_shown, law_choice, misfit

UNEXPLAINED = 4.0  # residual of the loop, over steps and noise, above which it is fitted again
BASIN = 1e-2  # relative change of the squares at which a fit to find a minimum ends
LAG = 0.2  # initial lag of the force behind its command, in samples
F_0_DEVIATION = 0.01  # least prior standard deviation of the inverse model's constant force, in F_c
SLOWER = 0.5  # cut-off of a second low-pass, as share of the first
BIAS_ERROR = 0.12  # standard error of the bias that is subtracted, as share of it


def learn(task: Task, progress: Progress = SILENT) -> Estimation:
    """Learn the parameters of the drive that made a recording.

    Raises IdentificationError when the drive does not slide in the recording, UsageError when it
    lacks a signal that the criterion needs, or ga.NothingLearned when no candidate could be run.
    """
    scale = motion.recording_scale(task.recording)
    gains = None if task.gains is None else scale.values(task.gains)
    scaled = replace(task, recording=scale.recording(task.recording), gains=gains)
    # Sums that are split over threads round differently, and a search amplifies that.
    with threadpool_limits(limits=1, user_api="blas"):
        return restored(_learn(scaled, scale, progress), scale)


def _learn(task: Task, scale: motion.Scale, progress: Progress) -> Estimation:
    recording, check = task.recording, None
    if task.gains is not None:
        progress.stage("checking the controller")
        recording, check = check_controllers(task.fmus, recording, task.gains)
        if recording.force is None and recording.friction is None:
            recording = replace(recording, force=check.force)
        task = replace(task, gains=check.gains)
    recording, remarks = motion.against_motion(recording)
    task = replace(task, recording=recording)
    criterion, reason = choose(task, check)
    law = friction_law(task.settings.law)
    with InverseModel(task.fmus, recording, workers=task.settings.workers, law=law) as model:
        start = begin(model, recording, scale)
        if task.is_level:
            start = replace(start, space=start.space.level())
        inverse = model.over(start.narrow(start.space, start.sliding | start.rise))
        progress.stage("searching")
        compared = None
        if task.choice:
            compared = {**start.line, **scale.values(task.choice.chosen.parameters)}
        searched, found = _search(
            task, inverse, start, lambda one: progress.generation(one, scale), compared=compared
        )
        corrected = None
        if criterion == OutputError.name and task.gains is not None:
            progress.stage("fitting the known loop")
            corrected, ambiguity = _output_error(task, task.gains, start, found)
            at_rest = bool(presliding(law))  # else the motion does not give the force at rest
            why = _not_explained(corrected, start)
            if why and task.settings.criterion == "auto" and at_rest:
                criterion = InverseModel.name
                reason = f"{why}, so there is what the model has not, and the force decides"
        progress.stage("assessing identifiability")
        step(0, 3)
        # Beside the loop, only sliding motion tells mass and friction apart whatever the law.
        sliding = {} if criterion == OutputError.name else start.beside(found.parameters)
        model_error = corrected.model_error if corrected else float("nan")
        if criterion == OutputError.name and corrected and task.gains is not None:
            errors, table = _known_loop(task, task.gains, corrected, ambiguity)
            best, degrees = corrected.fit, bootstrap.RUNS - 1
        else:
            best, errors = _inverse_model(task, inverse, found, start, sliding=sliding)
            names, step_size = presliding(law), inverse.recording.encoder_step
            errors |= least_errors(errors, best.parameters, names, step_size)
            degrees = BLOCKS - len(found.q)
            table = profiles(best, inverse.map, errors)
        errors = of_ratios(errors, law)
        if recording.known_force is not None:
            errors = beside_force(errors, best.parameters)
        names = start.space.friction if inverse.measures_friction else start.space.reported
        known = {name: identifiability(name, best, errors, degrees) for name in names}
        known = of_sliding(known, sliding, start.space)
        if criterion != OutputError.name and task.choice:
            others = [scale.values(one.parameters) for one in task.choice.alike]
            known = among_laws(known, others, start.space)
        errors |= {name: one.standard_error for name, one in sliding.items()}
        step(1, 3)
        change, unsure = change_of_friction(inverse, found.parameters), errors.get("delay", 0.0)
        bent = _bent(best.parameters) / float(np.ptp(inverse.position))
        believed = check is not None and not check.error > control_match.EXACT
        held_out = check_held_out(
            inverse, found, task, task.gains if believed else None, scale=scale
        )
        step(2, 3)
        faults = (
            *task.faults,
            *start.findings,
            *found_faults(
                best, criterion, check, model_error, change=change, delay_error=unsure, bent=bent
            ),
            *held_out.findings,
            *(contradictions(inverse, found) if recording.joins_several else ()),
        )
        if any(fault.spoils for fault in faults):
            known = {name: unreliable(one) for name, one in known.items()}
        known = hidden(known, faults, float(np.max(np.abs(motion.measured_force(recording)))))
        shown = {name: one.value for name, one in sliding.items()}
        largest = largest_friction(inverse, {**best.parameters, **shown})
        known = conservative(known, start.space, largest)
        values = {**best.parameters, **shown, **{name: one.value for name, one in known.items()}}
        bounded = {name: values[name] for name in start.space.bounded}
        fitted = {**best.parameters, **shown, **bounded}
        goodness = goodness_of_fit(inverse, fitted, task.gains, check)
        step(3, 3)
    return Estimation(
        recording=recording,
        criterion=criterion,
        reason=reason,
        start=start,
        fit=best,
        known=known,
        parameters=values,
        errors=errors,
        profiles=table,
        plausible=plausible(best, task.settings.seed),
        largest_friction=largest,
        searched=searched,
        held_out=held_out,
        figures=goodness,
        controller=check,
        model_error=model_error,
        gains=task.gains,
        remarks=remarks,
        faults=faults,
        choice=task.choice,
    )


def _bent(values: Values) -> float:
    """Return the presliding deflection [m]; 0 for a law without."""
    return values["F_c"] / values["sigma_0"] if "sigma_0" in values else 0.0


def _not_explained(corrected: bootstrap.UnbiasedFit, start: Start) -> str:
    """Return why the simulated loop does not explain the recording; empty if it does."""
    if corrected.model_error > misfit.EXPLAINED:
        return f"the loop's residual is {misfit.excess(corrected.model_error)}"
    apart = start.disagreement(corrected.fit.parameters)
    if apart > curve_shown.CONTRADICTED:
        return (
            f"mass or friction of the simulated loop lie {apart:.2g} half-widths of its interval "
            "from what sliding motion shows"
        )
    if start.curve is not None:
        friction = float(np.median(start.curve.value))
        for name, force in start.curve.varying.items():
            if force > curve_shown.VARIES * friction:
                return f"{VARYING[name]} by {force / friction:.2%} of friction"
    return ""


def _search(
    task: Task,
    inverse: InverseModel,
    start: Start,
    on_generation: Callable[[ga.Optimiser], object],
    compared: Values | None,  # the fit of the law when it was compared with others
) -> tuple[ga.Optimiser, Fit]:
    """Search, and finish locally."""
    settings = task.settings
    searched = search(inverse, start, settings.seed, settings.search, on_generation=on_generation)
    values = solve_linear(inverse, start, searched.best.values)
    found = best_fit(inverse, start, values, compared)
    found = found if start.rise else without_stribeck(inverse, found)
    selection = select(variants(inverse, found), _sure(inverse))
    covariance = selection.fit.covariance + selection.ambiguity
    return searched, replace(selection.fit, covariance=covariance)


def _sure(inverse: InverseModel) -> float:
    """Return the ratio of mean squares below which an exponent of the Stribeck curve is sure."""
    # Slips shorter than the low-pass, and coarse encoder steps, bias the curve, too.
    is_biased = not presliding(inverse.law) or bootstrap.coarse(inverse, inverse.recording)
    return law_choice.EXPONENT_BIASED if is_biased else law_choice.EXPONENT


def _output_error(
    task: Task, gains: Mapping[str, float], start: Start, found: Fit
) -> tuple[bootstrap.UnbiasedFit, Array]:
    """Fit the loop from the inverse model's values on, whitened, and correct it for its bias.

    The controller's integral compensates a constant force; its prior is the mean of the logged
    force. Returned beside it: the covariance (k, k) from the ambiguity of the exponent.
    """
    delay, F_0 = start.space.index("delay"), start.space.index("F_0")
    lower, mean, deviation = (
        bound.copy()
        for bound in (start.space.lower, start.space.prior_mean, start.space.prior_deviation)
    )
    lower[delay] = 1e-3  # a lag, in samples; the inverse model's delay may be negative
    mean[F_0] = found.q[F_0]
    deviation[F_0] = max(F_0_DEVIATION, 3.0 * float(np.sqrt(found.covariance[F_0, F_0])))
    space = replace(
        start.space,
        constants=found.space.constants,
        lower=lower,
        prior_mean=mean,
        prior_deviation=deviation,
    )
    fmus, recording, workers = task.fmus, task.recording, task.settings.workers
    seed = task.settings.seed
    with (
        OutputError(fmus, recording, gains, workers, law=space.law) as whole,
        KnownLoop(fmus, recording, gains, encoder=True, workers=workers) as again,
    ):
        criterion = whole.over(space)
        lag = LAG * recording.T_s
        begins = [space.encode({**at, "delay": lag}) for at in (found.parameters, start.line)]
        step(0, 4)
        criterion.whiten(space.decode(begins[0]))
        fitted = fit(criterion, begins[:1], ROUGH)
        step(1, 4)
        values, rng = fitted.parameters, np.random.default_rng(seed)
        (steps,) = bootstrap.resimulated_residuals(criterion, again, values, 1, noise=0.0, rng=rng)
        if criterion.unexplained(values, steps) > UNEXPLAINED:
            # Whitened, a model that is far from the recording has further local minima.
            criterion.whitening = np.ones(1)
            fitted = select(variants(criterion, fit(criterion, begins, BASIN), BASIN), 1.0).fit
            criterion = criterion.over(fitted.space)
        step(2, 4)
        criterion.whiten(fitted.parameters)
        selection = select(variants(criterion, fit(criterion, [fitted.q], ROUGH), ROUGH))
        step(3, 4)
        criterion = criterion.over(selection.fit.space)
        criterion.whiten(selection.fit.parameters)
        fitted = fit(criterion, [selection.fit.q])
        corrected = bootstrap.correct(criterion, fitted, again, seed)
        return corrected, selection.ambiguity


def _inverse_model(
    task: Task, inverse: InverseModel, found: Fit, start: Start, sliding: Mapping[str, Interval]
) -> tuple[Fit, dict[str, float]]:
    """Return the fit without its bias, and standard errors by name [SI].

    What the encoder, sampling, or friction beside the law make of the fit depends on the low-pass,
    so the difference of a fit behind another one is a part of the covariance.
    """
    if inverse.measures_friction:
        return found, found.errors()
    if "F_c" in sliding:
        placed = fit(inverse.over(start.narrow(found.space, sliding)), [found.q])
        found = replace(placed, covariance=found.covariance)
    recording, cutoff, law, q = task.recording, SLOWER * inverse.cutoff, found.space.law, inverse.q
    with InverseModel(task.fmus, recording, cutoff, task.settings.workers, law=law, q=q) as slower:
        apart = fit(slower.over(found.space), [found.q]).q - found.q
    spread, best = found.covariance + np.outer(apart, apart), found
    if bootstrap.coarse(inverse, recording):
        corrected, bias, alike = bootstrap.correct_inverse(inverse, found, task.settings.seed)
        # Where it is not alike it is no valid correction, but a measure of the uncertainty.
        best, share = (corrected, BIAS_ERROR) if alike else (found, 1.0)
        spread = spread + np.outer(bias, bias) * share**2
    best = replace(best, covariance=spread)
    return best, best.errors()


def _known_loop(
    task: Task, gains: Mapping[str, float], corrected: bootstrap.UnbiasedFit, ambiguity: Array
) -> tuple[dict[str, float], pd.DataFrame]:
    """Return standard errors by name [SI], and the profiles."""
    best = corrected.fit
    bias = np.outer(corrected.bias, corrected.bias) * BIAS_ERROR**2
    errors = value_errors(best.space, best.q, best.covariance + bias + ambiguity)
    with OutputError(
        task.fmus, task.recording, gains, workers=task.settings.workers, law=best.space.law
    ) as criterion:
        criterion.whitening = corrected.whitening

        def residuals(points: list[Values]) -> list[Array]:
            return [residual - corrected.mean for residual in criterion.map(points)]

        return errors, profiles(best, residuals, errors)
