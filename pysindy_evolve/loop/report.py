"""What the loop found: the equations and errors before and after, and each effect's evidence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from typing import Any

import numpy as np
import pysindy as ps
from scipy.interpolate import CubicSpline

from ..equations import Equations
from ..export import to_sympy
from ..signals import Record, choose_windows
from ..simulation import simulate
from ..terms import Sum
from .design import Design
from .fit import Fit, derivative_errors, derivative_fit_errors, fit
from .model import as_sindy
from .step import Finding
from .text import as_markdown, as_text

__all__ = ["Effect", "Errors", "LoopReport", "Step", "make_report"]

REFINEMENT = 4  # steps that splines put into each sample of an input


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of a model on held-out data, in percent of the standard deviation (NRMSE).

    Attributes
    ----------
    derivative_error : ndarray of shape (n_states,)
        Of x_dot, both sides averaged over the windows of the fit.
    simulation_error : ndarray of shape (n_states,)
        Of a free run from the first state of each record; infinite if it diverges.
    model : Equations
        The model that the errors belong to.
    """

    derivative_error: np.ndarray
    simulation_error: np.ndarray
    model: Equations

    @property
    def equations(self) -> list[Any]:
        """Right-hand sides as sympy expressions, one for each state."""
        return to_sympy(self.model)


@dataclass(frozen=True, eq=False)
class Effect:
    """One effect that the declared model lacks.

    Attributes
    ----------
    name : str
        From the vocabulary.
    state : str
        State whose equation it enters.
    term : sympy.Expr
        The effect without coefficient; with several terms, their sum.
    coefficients : ndarray of shape (n_terms,)
        In units of the derivative of the state per unit of the term.
    confidence_intervals : ndarray of shape (n_terms, 2)
        95 %, from a bootstrap over blocks of the training data.
    explained : float
        Share of the variance of the held-out derivative residual that it removed when it came in,
        beside what came with it.
    p_value : float
        Chance of a score as large in a twin, where nothing is missing.
    alternatives : tuple of str
        Names that this data cannot tell apart from it.
    expressions : tuple of Sum
        The terms.
    twin_scores : ndarray of shape (n_twins,)
        Best score in each twin.
    score : float
        Its own score.
    """

    name: str
    state: str
    term: Any
    coefficients: np.ndarray
    confidence_intervals: np.ndarray
    explained: float
    p_value: float
    alternatives: tuple[str, ...]
    expressions: tuple[Sum, ...]
    twin_scores: np.ndarray
    score: float


@dataclass(frozen=True, eq=False)
class Step:
    """The errors after one effect was added; the effects of a pair share them."""

    name: str
    state: str
    errors: Errors


@dataclass(frozen=True, eq=False)
class LoopReport:
    """What a declared model lacks, and what it is worth to add it.

    Attributes
    ----------
    verdict : {"complete", "traced", "untraced"}
        Nothing missing that the data can show; effects found and added; or structure remains that
        no tried effect explains.
    effects : list of Effect
        What was added, in the order of its finding.
    before, after : Errors
        Errors of the declared and of the corrected model on held-out data.
    steps : list of Step
        Errors after each effect.
    train, test : tuple of Record
        The records.
    finished : bool
        False if the search was interrupted or ran into `max_effects`.
    """

    verdict: str
    effects: list[Effect]
    before: Errors
    after: Errors
    steps: list[Step]
    train: tuple[Record, ...]
    test: tuple[Record, ...]
    finished: bool

    @property
    def equations(self) -> Equations:
        """The corrected model."""
        return self.after.model

    @cached_property
    def model(self) -> ps.SINDy:
        """The corrected model as a fitted SINDy model; time, if needed, is its last input."""
        return as_sindy(self.equations)

    @property
    def residual_before(self) -> list[np.ndarray]:
        """x_dot minus the declared model, for each held-out record."""
        return [_residual(self.before.model, record) for record in self.test]

    @property
    def residual_after(self) -> list[np.ndarray]:
        """x_dot minus the corrected model, for each held-out record."""
        return [_residual(self.after.model, record) for record in self.test]

    def simulate(self, record: Record) -> np.ndarray:
        """Run the corrected model freely over a record.

        Parameters
        ----------
        record : Record
            Supplies the times, the first state and the inputs.

        Returns
        -------
        ndarray of shape (n_samples, n_states)
        """
        return free_run(self.equations, record)

    def __str__(self) -> str:
        return as_text(self)

    def to_markdown(self) -> str:
        """Return the printed report as Markdown, with a table of the errors."""
        return as_markdown(self)

    def plot(self, state: str | None = None) -> Any:
        """Draw the held-out residual before and after, over time and over what it was traced to.

        Parameters
        ----------
        state : str, optional
            Equation to draw; by default the one that the first effect entered.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from .plot import plot_residuals

        return plot_residuals(self, state)


def _residual(equations: Equations, record: Record) -> np.ndarray:
    return record.x_dot - equations.evaluate(record.x, record.u, record.t)


def make_report(
    declared: Design,
    findings: Sequence[Finding],
    train: Sequence[Record],
    test: Sequence[Record],
    verdict: str,
    finished: bool,
    rng: np.random.Generator,
) -> LoopReport:
    """Fit each stage on all training rows and judge it on held-out records."""
    design = declared
    fitted, errors = _judge(declared, train, test, rng)
    before, effects, steps = errors, [], []
    for _, group in groupby(findings, key=lambda finding: finding.step):
        found = list(group)
        design = design.adding(column for finding in found for column in finding.columns)
        fitted, errors = _judge(design, train, test, rng)
        for finding in found:
            effects.append(_effect(design, finding, train, test))
            steps.append(Step(finding.candidate.name, effects[-1].state, errors))
    place = len(declared.columns)
    for k, finding in enumerate(findings):
        own = slice(place, place + len(finding.columns))
        place = own.stop
        effects[k] = replace(
            effects[k], coefficients=fitted.coef[own], confidence_intervals=fitted.intervals[own]
        )
    records = tuple(train), tuple(test)
    return LoopReport(verdict, effects, before, errors, steps, *records, finished)


def _effect(
    design: Design, finding: Finding, train: Sequence[Record], test: Sequence[Record]
) -> Effect:
    """Return an effect with its evidence; its coefficients are those of the final model."""
    state, terms = finding.candidate.state, finding.candidate.terms
    symbols = design.equations(np.zeros(len(design.columns))).symbols
    poorer = design.dropping(finding.columns)
    without, with_it = (derivative_fit_errors(d, train, test)[state] for d in (poorer, design))
    unknown = np.full(len(terms), np.nan)
    return Effect(
        name=finding.candidate.name,
        state=design.states[state],
        term=sum((term.to_sympy(symbols) for term in terms[1:]), terms[0].to_sympy(symbols)),
        coefficients=unknown,
        confidence_intervals=np.column_stack([unknown, unknown]),
        explained=float(1.0 - (with_it / max(without, 1e-300)) ** 2),
        p_value=finding.p_value,
        alternatives=finding.alternatives,
        expressions=terms,
        twin_scores=finding.twin_scores,
        score=finding.score,
    )


def _judge(
    design: Design, train: Sequence[Record], test: Sequence[Record], rng: np.random.Generator
) -> tuple[Fit, Errors]:
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
