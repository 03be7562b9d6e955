"""Both errors of a model on held-out records."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...hidden_states.memory import all_with_memories, with_memories_applied
from ...hidden_states.memory_equations import with_memories
from ...signals import Record, choose_windows
from ..evidence.findings import Finding, memories_in
from ..facts.effect import Errors
from ..fitting.fit import Fit, derivative_errors, fit
from ..fitting.past import rates_on, with_estimated_past
from ..fitting.runs import simulation_errors
from ..fitting.shooting import fit_by_shooting
from ..free_runs.memory_tuning import fit_by_runs
from ..given.design import Design
from ..given.rules import Rules
from .bias import unbiased

# Times both errors of another fit: more than the choice among good fits makes.
MIN_ERROR_RATIO = 1.2


def judge(
    design: Design,
    findings: Sequence[Finding],
    train: Sequence[Record],
    test: Sequence[Record],
    rules: Rules,
    rng: np.random.Generator,
    *,
    final: bool,
) -> tuple[Fit, Errors]:
    """Fit a design with findings on all training rows, and take both errors on held-out records.

    The bias of the coefficients is taken off a final model only: that of a model which lacks
    something is of no interest. Memories are what the inputs go through before they act. What only
    free runs showed is also fitted to them, as the derivative does not know it.
    """
    memories = memories_in(findings)
    train = all_with_memories(train, memories)
    fitted = fit(design, train, rng, rules.criterion)
    if fitted.criterion == "trajectory":
        fitted = _unless_beaten(design, fitted, train, rng)
    if needs_runs(findings):
        fitted = fit_by_runs(design, fitted, train, rng)
    elif final and fitted.criterion != "trajectory":
        fitted = unbiased(design, fitted, train, rng, rules.n_jobs)
        fitted = fit_by_shooting(design, fitted, train) if rules.refine != "derivative" else fitted
    equations = design.equations(fitted.coef)
    whole = with_memories(equations, memories)
    test = [with_memories_applied(with_estimated_past(whole, record), memories) for record in test]
    windows = choose_windows(list(train))
    derivative = derivative_errors(design, fitted.coef, test, windows)
    simulation = simulation_errors(equations, test)
    valued = [np.isfinite(rates_on(equations, record)).all(axis=1) for record in test]
    undefined = 1.0 - float(np.mean(np.concatenate(valued)))
    return fitted, Errors(derivative, simulation, whole, undefined=undefined)


def needs_runs(findings: Sequence[Finding]) -> bool:
    """Tell whether only free runs know the number of a finding."""
    return any(finding.by_runs and not finding.columns for finding in findings)


def _unless_beaten(
    design: Design, fitted: Fit, train: Sequence[Record], rng: np.random.Generator
) -> Fit:
    """Return the fit of a trajectory, or another one that is closer to its record in every way.

    Where a random force takes the blame for what the columns would explain, the likeliest
    coefficients are not those that the machine has.
    """
    other = fit(design, train, rng)
    own, its = (_training_errors(design, one.coef, train) for one in (fitted, other))
    return other if np.all(own > MIN_ERROR_RATIO * its) else fitted


def _training_errors(design: Design, coef: np.ndarray, train: Sequence[Record]) -> np.ndarray:
    """Return the errors of derivative and free run, each of the state that is missed most."""
    derivative = derivative_errors(design, coef, train, choose_windows(list(train)))
    return np.array([derivative.max(), simulation_errors(design.equations(coef), train).max()])
