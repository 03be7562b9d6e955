"""The report of the loop: its outcome, and all that prints, draws and simulates it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pysindy as ps
import sympy

from ...hidden_states.memory_equations import MemoryEquations
from ...signals import Record
from ...warn import warn
from ..facts.effect import Effect
from ..facts.outcome import Outcome
from ..fitting.runs import free_run
from ..given.held import held_like
from .experiment import Plan, plan
from .sindy import as_sindy
from .text import as_markdown, as_text


@dataclass(frozen=True, eq=False)
class LoopReport(Outcome):
    """The effects that a declared model lacks, and the errors without and with them.

    Attributes
    ----------
    verdict : {"complete", "traced", "untraced"}
        Nothing missing that the data can show; effects found and added; or structure remains that
        no tried effect explains.
    effects : list of Effect
        The effects that were added, in the order in which they were found.
    before, after : Errors
        Errors of the declared and of the corrected model on held-out data.
    steps : list of Step
        Errors after each effect was added.
    train, test : tuple of Record
        The records.
    finished : bool
        False if the search was interrupted, reached `max_effects`, or was not begun.
    rules : Rules
        The settings.
    design : Design
        The corrected model with its coefficients free.
    rejected : Rejected, optional
        The best candidate of the last look, which did not pass; None if none improved the model.
    chance_left : float
        p-value of the test for structure in the residual of the corrected model; 1 if no structure
        was seen or the test was not made.
    found_held : tuple of int
        Inputs that the loop found to be held from one sample to the next (zero-order hold).
    interrupted : bool
        Whether an interrupt ended the search.
    shows_motion : bool
        False if the user's derivatives were smoothed so much that no effect was looked for.
    """

    @cached_property
    def model(self) -> ps.SINDy:
        """The corrected model as a fitted SINDy model.

        If an effect depends on the time, t is the last input, so that simulating it reads
        ``report.model.simulate(x0, t, u=np.column_stack([u, t]))``, and predicting likewise.

        It cannot delay an input, and warns: give it the input after its delay. For an algebraic
        target, such as a force, it predicts the target itself, though PySINDy prints a derivative;
        simulate it with `LoopReport.simulate`.
        """
        delays = self.equations.delays if isinstance(self.equations, MemoryEquations) else ()
        if any(delays):
            delayed = zip(self.equations.inputs, delays, strict=True)
            changed = ", ".join(
                f"{u} as it was {delay:.4g} earlier" for u, delay in delayed if delay
            )
            warn(
                "LoopReport.model: a SINDy model cannot delay its inputs; this one takes "
                f"{changed}. Shift the input, or use LoopReport.simulate."
            )
        return as_sindy(self.equations)

    def simulate(self, record: Record) -> np.ndarray:
        """Run the corrected model freely over a record.

        Parameters
        ----------
        record : Record
            Supplies the times, the first state and the inputs.

        Returns
        -------
        ndarray of shape (n_samples, n_states)
            States; clipped where one of the effects is a sensor that clips.

        Notes
        -----
        Between its samples an input follows a cubic spline, as prepared inputs are smooth. For
        `pysindy_evolve.simulate` an array of inputs is linear in between; give it the spline itself
        to have the same run: ``u=scipy.interpolate.CubicSpline(record.t, record.u)``.

        Raises
        ------
        TypeError
            If `record` is no Record.
        """
        if not isinstance(record, Record):
            raise TypeError(
                f"LoopReport.simulate(record=...) must be a Record; got {type(record).__name__}. "
                "Simulate one record at a time."
            )
        states = free_run(self.equations, held_like(record, self.train))
        return _clipped_by_sensors(states, self.equations.states, self.effects)

    def __str__(self) -> str:
        return as_text(self)

    def __repr__(self) -> str:
        found = ", ".join(f"{effect.name} of {effect.state}" for effect in self.effects)
        return f"LoopReport({self.verdict!r}, {found or 'no effects'}; print it to read all)"

    def _repr_markdown_(self) -> str:
        """Return the report as a notebook shows it."""
        return self.to_markdown()

    def to_markdown(self) -> str:
        """Return the printed report as Markdown, with the twins and what to measure next."""
        return as_markdown(self)

    def to_html(self, path: str | Path, units: Mapping[str, str] | None = None) -> None:
        """Write the report with its pictures as one self-contained page of HTML.

        Parameters
        ----------
        path : str or Path
            File to write; folders that are missing are made.
        units : mapping of str to str, optional
            Units of the variables and of t, for the labels: ``{"q": "m", "t": "s"}``.

        Raises
        ------
        ValueError
            If `path` is a folder, or `units` names something that is no variable.
        ImportError
            If jinja2 or matplotlib is not installed.
        """
        from .html import as_html

        file = Path(path)
        if file.is_dir():
            raise ValueError(
                f"LoopReport.to_html(path=...) must be a file; got the folder {str(path)!r}. "
                'Write a name such as "report.html" after it.'
            )
        page = as_html(self, units)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(page, encoding="utf-8")

    def suggest_experiment(self, units: Mapping[str, str] | None = None) -> Plan:
        """Say what to measure next, so that effects and their alternatives come apart.

        Parameters
        ----------
        units : mapping of str to str, optional
            Units of the variables: ``{"q": "m", "v": "m/s"}``.

        Returns
        -------
        Plan
            One experiment for each pair: the recorded motion with another amplitude or at other
            frequencies. Prints as sentences.

        Raises
        ------
        ValueError
            If `units` names something that is no variable.
        """
        return plan(self, units)

    def plot(self, state: str | None = None, units: Mapping[str, str] | None = None) -> Any:
        """Draw the held-out residual of one equation, before and after.

        Over time, over frequency, over up to three variables, and in the phase plane.

        Parameters
        ----------
        state : str, optional
            Equation to draw; by default the one that the first effect entered.
        units : mapping of str to str, optional
            Units of the variables and of t, for the labels: ``{"q": "m", "t": "s"}``.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ImportError
            If matplotlib is not installed.
        ValueError
            If the model has no such state, or no such variable as a unit is given for.
        """
        from .plot import plot_residuals

        return plot_residuals(self, state, units)


def report_of(outcome: Outcome) -> LoopReport:
    """Return the report of an outcome."""
    return LoopReport(**{one.name: getattr(outcome, one.name) for one in fields(outcome)})


def _clipped_by_sensors(
    run: np.ndarray, states: Sequence[str], effects: Sequence[Effect]
) -> np.ndarray:
    """Return a run (n_samples, n_states) clipped where the sensor of a state was found to clip."""
    run = np.array(run)
    for effect in (each for each in effects if each.of_sensor):
        reading = run[:, states.index(effect.state)]
        clip = np.minimum if isinstance(effect.term, sympy.Min) else np.maximum
        clip(reading, effect.coefficients[0], out=reading)
    return run
