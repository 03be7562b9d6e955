"""Both errors of a model on held-out records."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from ..equations import Equations
from ..signals import Record, choose_windows
from ..simulation import simulate
from .design import Design
from .effect import Errors
from .fit import Fit, derivative_errors, fit

__all__ = ["free_run", "judge", "simulation_errors"]

REFINEMENT = 4  # steps that splines put into each sample of an input


def judge(
    design: Design, train: Sequence[Record], test: Sequence[Record], rng: np.random.Generator
) -> tuple[Fit, Errors]:
    """Fit a design on all training rows and take both errors on held-out records."""
    fitted = fit(design, train, rng)
    equations = design.equations(fitted.coef)
    windows = choose_windows(list(train))
    derivative = derivative_errors(design, fitted.coef, test, windows)
    return fitted, Errors(derivative, simulation_errors(equations, test), equations)


def free_run(equations: Equations, record: Record, **options: Any) -> np.ndarray:
    """Simulate over a record from its first state.

    Prepared inputs are smooth between the samples, so they are refined by splines: straight lines
    would take five percent off a sine with nine samples a period.
    """
    if record.u is None:
        return simulate(equations, record.x[0], record.t, **options)
    fine = np.interp(
        np.arange(REFINEMENT * (len(record) - 1) + 1) / REFINEMENT, np.arange(len(record)), record.t
    )
    u = CubicSpline(record.t, record.u, axis=0)(fine)
    return simulate(equations, record.x[0], fine, u, **options)[::REFINEMENT]


def simulation_errors(equations: Equations, records: Sequence[Record]) -> np.ndarray:
    """Return the NRMSE of free runs over records, percent, shape (n_states,)."""
    errors = []
    for record in records:
        run = free_run(equations, record, on_divergence="nan", tolerance=1e-7)
        errors.append(run - record.x)
    rms = np.sqrt(np.mean(np.concatenate(errors) ** 2, axis=0))
    spread = np.concatenate([record.x for record in records]).std(axis=0)
    return np.nan_to_num(100.0 * rms / np.where(spread > 0.0, spread, 1.0), nan=np.inf)
