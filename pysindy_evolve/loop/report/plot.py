"""A page of panels of the held-out residual, before and after the effects were added."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...signals import Record, Windows, choose_windows
from ..facts.outcome import Outcome
from ..given.kinematics import positions
from ..given.rows import variables_of
from .number_text import check_units, label, rate_label, with_unit
from .panels import (
    draw_frequency,
    draw_plane,
    draw_time,
    draw_twins,
    draw_variable,
    label_decades,
    tidy,
)

# Orange and blue, one light and one dark: also told apart by the color-blind and in gray print.
BEFORE, AFTER = "#dd7a2a", "#1b5690"
UNVISITED = "0.86"  # behind the cells of a plane, of which zero is nearly white
MAX_VARIABLES = 3  # panels over one variable, side by side
STYLE = {"font.size": 9.0, "axes.titlesize": 9.5, "axes.titleweight": "bold"}


def plot_residuals(
    outcome: Outcome, state: str | None = None, units: Mapping[str, str] | None = None
) -> Any:
    """Draw the held-out residual of one equation, before and after.

    Parameters
    ----------
    outcome : Outcome
        What the loop found.
    state : str, optional
        Equation to draw; by default the one that the first effect entered.
    units : mapping of str to str, optional
        Units of the variables and of t.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ImportError
        If matplotlib is missing.
    ValueError
        If the model has no such state, or no such variable as a unit is given for.
    """
    try:
        from matplotlib import pyplot as plt
    except ImportError as error:
        raise ImportError(
            'LoopReport.plot() needs matplotlib: pip install "pysindy-evolve[plots]"'
        ) from error
    index = _state_index(outcome, state)
    check_units("plot", units, outcome.before.model.names)
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(11, 8.5), layout="constrained")
        draw_residuals(figure, outcome, index, units)
    return figure


def draw_residuals(
    figure: Any, outcome: Outcome, index: int, units: Mapping[str, str] | None = None
) -> None:
    """Fill a figure with the panels of one equation.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        Where to draw.
    outcome : Outcome
        What the loop found.
    index : int
        State whose equation it is.
    units : mapping of str to str, optional
        Units of the variables and of t.
    """
    names, rate = outcome.before.model.names, rate_label(outcome.before.model.states[index], units)
    shown = _variables(outcome, index)
    stages = [("declared model", BEFORE, [r[:, index] for r in outcome.residual_before])]
    if outcome.effects:
        stages.append(("corrected model", AFTER, [r[:, index] for r in outcome.residual_after]))
    lines = ["t" * 6, _row("abc"[: len(shown)]), _row("fxy"[: 1 + len(stages)])]
    panels = figure.subplot_mosaic("\n".join(lines), height_ratios=(1.0, 1.1, 1.1))
    record, windows = outcome.test[0], choose_windows(list(outcome.train))
    for name, color, raw in stages:
        draw_frequency(panels["f"], raw[0], record.dt, _highest(record), color, name)
    rows = [averaged(raw, windows)[1] for raw in stages[0][2]]
    stages = [(name, color, [averaged(r, windows)[0] for r in raw]) for name, color, raw in stages]
    record_rows = zip(outcome.test, rows, strict=True)
    variables = np.concatenate([variables_of(each)[inside] for each, inside in record_rows])
    for name, color, residuals in stages:
        pooled = np.concatenate(residuals)
        draw_time(panels["t"], record.t[rows[0]], residuals[0], color, name)
        for letter, variable in zip("abc", shown, strict=False):
            draw_variable(panels[letter], variables[:, variable], pooled, color, name)
    _label(panels, shown, names, units, rate)
    span = with_unit(windows.width * record.dt, "t", units)
    figure.suptitle(
        f"Held-out residual, averaged over windows of {span} as in the fit", fontsize=10
    )
    _draw_planes(figure, panels, outcome, index, stages, variables, units)


def averaged(residual: np.ndarray, windows: Windows) -> tuple[np.ndarray, slice]:
    """Return a residual averaged over the windows of the fit, and the rows at their centers."""
    if windows.width < 3 or len(residual) < 2 * windows.width:
        return residual, slice(None)
    smooth = np.convolve(residual, windows.weights, mode="valid")
    first = windows.width // 2
    return smooth, slice(first, first + len(smooth))


def _label(
    panels: Mapping[str, Any],
    shown: Sequence[int],
    names: Sequence[str],
    units: Mapping[str, str] | None,
    rate: str,
) -> None:
    """Label all panels but the planes."""
    has_band = bool(panels["t"].collections)
    title = "Over time: median and 80 % band" if has_band else "Over time"
    tidy(panels["t"], label("t", units), f"residual of {rate}", title)
    for letter, variable in zip("abc", shown, strict=False):
        panels[letter].xaxis.get_major_locator().set_params(nbins=18 // len(shown))
        where = f"Over {names[variable]}: median and middle half"
        tidy(panels[letter], label(names[variable], units), "", where)
    panels["a"].set_ylabel(f"residual of {rate}")
    for letter in "tabc"[: 1 + len(shown)]:
        panels[letter].axhline(0.0, color="0.5", lw=0.7, zorder=0)
    panels["t"].legend(
        frameon=False, ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1
    )
    time = (units or {}).get("t", "")
    per = {"": "cycles per unit of t", "s": "Hz"}.get(time, f"1/{time}")
    root = "√Hz" if per == "Hz" else f"√({per})"
    density = f"density of {rate.replace(']', f' per {root}]')}"
    tidy(panels["f"], f"frequency [{per}]", density, "Over frequency: amplitude density")
    panels["f"].grid(which="major", color="0.9", lw=0.6)
    label_decades(panels["f"])


def _draw_planes(
    figure: Any,
    panels: Mapping[str, Any],
    outcome: Outcome,
    index: int,
    stages: Sequence[tuple[str, str, list[np.ndarray]]],
    variables: np.ndarray,
    units: Mapping[str, str] | None,
) -> None:
    """Color a plane of two variables by the mean residual, before and after."""
    names, (x, y) = outcome.before.model.names, _plane(outcome, index)
    limit = float(np.quantile(np.abs(np.concatenate(stages[0][2])), 0.9)) or 1.0
    mesh = None
    for letter, (name, _, residuals) in zip("xy", stages, strict=False):
        pooled = np.concatenate(residuals)
        panels[letter].set_facecolor(UNVISITED)
        panels[letter].xaxis.get_major_locator().set_params(nbins=6)
        mesh = draw_plane(panels[letter], variables[:, x], variables[:, y], pooled, limit)
        vertical = label(names[y], units)
        tidy(panels[letter], label(names[x], units), vertical, f"Mean residual, {name}")
    used = [panels[letter] for letter in "xy"[: len(stages)]]
    bar = figure.colorbar(mesh, ax=used, shrink=0.9, pad=0.01)
    bar.outline.set_visible(False)
    bar.set_label(f"residual of {rate_label(names[index], units)}\n(gray: never visited)")


def draw_scores(axes: Any, scores: np.ndarray, observed: float, what: str) -> None:
    """Draw the histogram of the twins' scores, and the score in the record, with labels."""
    draw_twins(axes, scores, observed, AFTER)
    tidy(axes, what, "twins", "")


def _row(letters: str) -> str:
    """Return a mosaic row of six columns shared equally by some letters."""
    return "".join(letter * (6 // len(letters)) for letter in letters)


def _highest(record: Record) -> float:
    """Return the highest frequency to draw: the cutoff, at most half the sampling rate."""
    nyquist = 0.5 / record.dt
    return nyquist if record.cutoff is None else min(nyquist, record.cutoff)


def _variables(outcome: Outcome, index: int) -> list[int]:
    """Return the variables to draw the residual over, three at most.

    In this order of choice: those of the effects in this equation, the state, its position, and
    others that occur in the model.
    """
    time = len(outcome.before.model.names) - 1
    state = outcome.before.model.states[index]
    here = [effect for effect in outcome.effects if effect.state == state]
    wanted = [v for e in here for term in e.expressions for v in sorted(term.variables)]
    wanted += [index, *_position(outcome, index), *range(time)]
    occurring = {v for side in outcome.before.model.sums for v in side.variables} | {index}
    occurring |= {v for effect in here for term in effect.expressions for v in term.variables}
    chosen = dict.fromkeys(v for v in wanted if v != time and v in occurring)
    return sorted(list(chosen)[:MAX_VARIABLES])


def _position(outcome: Outcome, index: int) -> list[int]:
    """Return the position of a velocity; nothing for another state."""
    known = positions(outcome.before.model)
    return [known[index]] if index in known else []


def _plane(outcome: Outcome, index: int) -> tuple[int, int]:
    """Return the axes of the plane: the position, else another variable or time, and the state."""
    if position := _position(outcome, index):
        return position[0], index
    others = [v for v in _variables(outcome, index) if v != index]
    return (others[0] if others else len(outcome.before.model.names) - 1), index


def _state_index(outcome: Outcome, state: str | None) -> int:
    """Return the equation to draw; by default that of the first effect, or of the largest error."""
    states = outcome.before.model.states
    if state is None:
        worst = int(np.argmax(outcome.before.derivative_error))
        first = next((effect.state for effect in outcome.effects if not effect.of_sensor), None)
        return worst if first is None else states.index(first)
    if state not in states:
        raise ValueError(
            f"LoopReport.plot(state=...) must be a state of the model; got {state!r}. "
            f"Choose from {', '.join(states)}."
        )
    return states.index(state)
