"""Pictures of the residual: over time, and over the variable that it was traced to."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .segments import variables_of

if TYPE_CHECKING:
    from .report import LoopReport

__all__ = ["plot_residuals"]

N_BINS = 40
BEFORE, AFTER = "#c44e52", "#4c72b0"


def plot_residuals(report: LoopReport, state: str | None = None) -> Any:
    """Draw the held-out residual of one equation before and after.

    Parameters
    ----------
    report : LoopReport
        What the loop found.
    state : str, optional
        Equation to draw; by default the one that the first effect entered.

    Returns
    -------
    matplotlib.figure.Figure
        Left over time, right over the variable that the first effect depends on: the median of
        bins with as many samples each, and the band that holds half of them.

    Raises
    ------
    ImportError
        If matplotlib is missing.
    ValueError
        If the model has no such state.
    """
    try:
        from matplotlib import pyplot as plt
    except ImportError as error:
        raise ImportError(
            'LoopReport.plot() needs matplotlib: pip install "pysindy-evolve[plots]"'
        ) from error
    index = _state_index(report, state)
    variable = _traced_to(report, index)
    names = report.equations.names
    figure, (over_time, over_variable) = plt.subplots(
        1, 2, figsize=(11, 4), width_ratios=(3, 2), layout="constrained"
    )
    record = report.test[0]
    pairs = (
        ("declared model", BEFORE, report.residual_before[0][:, index]),
        ("corrected model", AFTER, report.residual_after[0][:, index]),
    )
    values = variables_of(record)[:, variable]
    for label, color, residual in pairs if report.effects else pairs[:1]:
        over_time.plot(record.t, residual, color=color, lw=0.7, label=label)
        _draw_bins(over_variable, values, residual, color, label)
    _label(over_time, "t", f"residual of d{names[index]}/dt", "held-out residual over time")
    _label(over_variable, names[variable], "", f"the same over {names[variable]}: median and half")
    over_variable.legend(frameon=False)
    return figure


def _label(axes: Any, x: str, y: str, title: str) -> None:
    axes.set(xlabel=x, ylabel=y, title=title)
    axes.axhline(0.0, color="0.6", lw=0.6, zorder=0)
    axes.spines[["top", "right"]].set_visible(False)


def _draw_bins(axes: Any, x: np.ndarray, y: np.ndarray, color: str, label: str) -> None:
    order = np.argsort(x, kind="stable")
    bins = [part for part in np.array_split(order, min(N_BINS, len(x))) if len(part)]
    center = [float(np.median(x[part])) for part in bins]
    low, middle, high = np.array([np.quantile(y[part], [0.25, 0.5, 0.75]) for part in bins]).T
    axes.fill_between(center, low, high, color=color, alpha=0.25, lw=0)
    axes.plot(center, middle, color=color, lw=1.6, label=label)


def _state_index(report: LoopReport, state: str | None) -> int:
    states = report.equations.states
    if state is None:
        worst = int(np.argmax(report.before.derivative_error))
        return states.index(report.effects[0].state) if report.effects else worst
    if state not in states:
        raise ValueError(
            f"LoopReport.plot(state=...) must be a state of the model; got {state!r}. "
            f"Choose from {', '.join(states)}."
        )
    return states.index(state)


def _traced_to(report: LoopReport, index: int) -> int:
    """Return the variable of the first effect in this equation that depends on one."""
    for effect in report.effects:
        variables = sorted(v for term in effect.expressions for v in term.variables)
        if effect.state == report.equations.states[index] and variables:
            return variables[-1] if index not in variables else index
    return index
