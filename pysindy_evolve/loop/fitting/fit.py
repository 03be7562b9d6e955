"""Fit the coefficients of a design on whole records, and say how sure they are.

The derivative is fitted first, in windows. If the simulation does better on held-out parts of the
training data, the coefficients come from simulations over short and long stretches alike. Position
noise, which the second derivative magnifies and which biases sgn and similar functions, hardly
enters there. Small effects that add up over a long run, such as a loss of energy, do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...checks import TINY
from ...signals import Record, Windows, choose_windows, project
from ...terms import Cache
from ..given.design import Design
from ..given.rows import scale_of, variables_of
from ..given.segments import places_of, segments
from ..given.sticking import may_rest, weights_in_motion
from .bootstrap import block_intervals
from .linear import solve_gram, square_of
from .past import rates_on, settled_rows
from .residual import forces, jacobian, simulation_rows
from .trajectory import Trajectories

N_BLOCKS = 40  # of the derivative fit; each much longer than a residual is correlated
N_STRETCHES = (32, 16, 8, 4, 2, 1)  # of the simulation fit, each with its own initial state
JUDGED = 16  # stretches on which simulation fit and derivative fit are compared
MIN_RELATIVE_SQUARE = 1e-16  # least squared residual, relative to the squared target
# A model that lacks something fits simulation and derivative with different coefficients. If the
# simulation fit raises the squared derivative error by more than this factor, it is not used.
MAX_TORN = 2.0


@dataclass(frozen=True, eq=False)
class Fit:
    """Coefficients, their 95 % intervals, and which error they were fitted to.

    Attributes
    ----------
    coef : ndarray of shape (p,)
        One for each column of the design.
    intervals : ndarray of shape (p, 2)
        From randomly weighted blocks of rows, so they respect autocorrelated residuals.
    criterion : {"derivative", "simulation", "trajectory"}
        The error that was minimized.
    """

    coef: np.ndarray
    intervals: np.ndarray
    criterion: str


def fit(
    design: Design, records: Sequence[Record], rng: np.random.Generator, refine: str = "auto"
) -> Fit:
    """Fit a design on training records.

    Parameters
    ----------
    design : Design
        Model with p columns.
    records : sequence of Record
        Training records.
    rng : numpy.random.Generator
        Draws the blocks of the intervals.
    refine : {"auto", "derivative", "simulation", "trajectory"}
        Error to minimize; by default the better one of the first two. The last is for short
        records, see trajectory.py.

    Returns
    -------
    Fit
    """
    if not design.columns:
        return Fit(np.empty(0), np.empty((0, 2)), "derivative")
    if refine == "trajectory":
        return Fit(*Trajectories(records, design, design.columns).fit(), refine)
    blocks = _block_grams(design, records)
    by_derivative = _solve(blocks)
    if refine == "derivative":
        return Fit(by_derivative, block_intervals(blocks, rng), "derivative")
    horizons = simulation_grams(design, by_derivative, records)
    by_simulation = _fit_to_all(horizons)
    if refine == "auto" and not _is_better(horizons[JUDGED], blocks, by_derivative, by_simulation):
        return Fit(by_derivative, block_intervals(blocks, rng), "derivative")
    shortest = horizons[max(horizons)]
    shift = by_simulation - _solve(shortest)
    return Fit(by_simulation, block_intervals(shortest, rng) + shift[:, None], "simulation")


def _is_better(
    judged: np.ndarray, blocks: np.ndarray, by_derivative: np.ndarray, by_simulation: np.ndarray
) -> bool:
    """Tell whether a fit to the other stretches simulates each better than the derivative fit."""
    total = blocks.sum(axis=0)
    is_torn = square_of(total, by_simulation) > MAX_TORN * square_of(total, by_derivative)
    if len(judged) < 2 or is_torn:
        return False
    held_out = sum(
        square_of(stretch, _solve(np.delete(judged, k, axis=0))) for k, stretch in enumerate(judged)
    )
    plain = sum(square_of(stretch, by_derivative) for stretch in judged)
    return bool(held_out < plain)


def derivative_square(design: Design, records: Sequence[Record], coef: np.ndarray) -> float:
    """Return the squared residual of the windowed derivative for given coefficients."""
    return square_of(_block_grams(design, records).sum(axis=0), coef)


def refit(design: Design, records: Sequence[Record], criterion: str) -> np.ndarray:
    """Return the coefficients, shape (p,), that minimize the error named by a criterion."""
    if criterion == "trajectory":
        return Trajectories(records, design, design.columns).fit()[0]
    by_derivative = _solve(_block_grams(design, records))
    if criterion == "derivative":
        return by_derivative
    return _fit_to_all(simulation_grams(design, by_derivative, records))


def _fit_to_all(horizons: dict[int, np.ndarray]) -> np.ndarray:
    return _solve(np.array([_normalized(grams) for grams in horizons.values()]))


def _normalized(grams: np.ndarray) -> np.ndarray:
    """Sum over the stretches, in units of the squared residual of the best fit to them."""
    total = grams.sum(axis=0)
    residual = sum(square_of(g, _solve(grams)) for g in grams)
    return total / max(residual, MIN_RELATIVE_SQUARE * float(total[-1, -1]), 1e-100)


def _block_grams(design: Design, records: Sequence[Record]) -> np.ndarray:
    """Return inner products of columns and target in consecutive blocks of windowed rows.

    Shape (n_blocks, p + 1, p + 1), target last. Each equation is weighed by the size of its
    derivative.
    """
    windows = choose_windows(list(records))
    scale = scale_of([record.x_dot for record in records])
    total = sum(record.n_samples for record in records)
    grams = []
    for record in records:
        rows = _rows(design, record, windows, scale)
        n_blocks = max(1, round(N_BLOCKS * record.n_samples / total))
        grams += [block.T @ block for block in np.array_split(rows, n_blocks) if len(block)]
    return np.array(grams)


def derivative_intervals(
    design: Design, records: Sequence[Record], rng: np.random.Generator
) -> np.ndarray:
    """Return the 95 % intervals of the coefficients that fit the derivative, shape (p, 2)."""
    return block_intervals(_block_grams(design, records), rng)


def simulation_grams(
    design: Design, coef: np.ndarray, records: Sequence[Record]
) -> dict[int, np.ndarray]:
    """Return, for each number of stretches, inner products of the deviations in each stretch."""
    equations, dt = design.equations(coef), records[0].dt
    scale = scale_of([record.x for record in records])
    wholes = [
        segments([record], may_rest(design, [record]), 1, max_rows=None) for record in records
    ]
    force = [forces(whole, design, design.columns)[0] for whole in wholes]
    slopes = [jacobian(equations, whole.z, scale)[0] for whole in wholes]
    grams = {}
    for n_stretches in N_STRETCHES:
        places, length = places_of(records, n_stretches)
        driven, slope = (
            np.stack([rows[i][start : start + length] for i, start in places])
            for rows in (force, slopes)
        )
        rows = simulation_rows(driven, slope, dt, scale)
        grams[n_stretches] = np.swapaxes(rows, 1, 2) @ rows
    return grams


def _rows(design: Design, record: Record, windows: Windows, scale: np.ndarray) -> np.ndarray:
    """Return windowed columns and target, equations side by side in time order."""
    variables = variables_of(record)
    cache: Cache = {}
    target = record.x_dot - design.known(variables)
    values = [column.evaluate(variables, cache) for column in design.columns]
    stacked = []
    weights = weights_in_motion(record, may_rest(design, [record])) * settled_rows(design, record)
    for state in design.open_states:
        columns = np.column_stack([*(v[:, state] for v in values), target[:, state]])
        stacked.append(project(columns * weights[:, state, None], windows) / scale[state])
    return np.stack(stacked, axis=1).reshape(-1, len(values) + 1)


def _solve(grams: np.ndarray) -> np.ndarray:
    return solve_gram(grams.sum(axis=0))


def derivative_errors(
    design: Design, coef: np.ndarray, records: Sequence[Record], windows: Windows
) -> np.ndarray:
    """Return the NRMSE of the derivative, percent of the standard deviation, for each state.

    Both sides are averaged over the windows of the fit, so that it is the error of the model and
    not of the differentiation. Two kinds of rows are left out: rows at rest, where the sign of the
    velocity is random, and rows on which the model has no value, such as the root of a negative
    state. The error is infinite if no row is left.
    """
    equations = design.equations(coef)
    squares, samples, weights, has_rows = [], [], [], np.zeros(len(design.states), dtype=bool)
    for record in records:
        wide = windows if record.n_samples >= windows.width else Windows(1)
        error = record.x_dot - rates_on(equations, record)
        valued = np.isfinite(error)
        has_rows |= valued.any(axis=0)
        weight = weights_in_motion(record, may_rest(design, [record])) * valued
        error = np.where(valued, error, 0.0)
        squares.append(project(error * weight, wide) ** 2)
        samples.append(project(record.x_dot, wide))
        weights.append(project(weight, wide) ** 2)
    rows = np.maximum(np.concatenate(weights).sum(axis=0), TINY)
    rms = np.sqrt(np.concatenate(squares).sum(axis=0) / rows)
    return np.where(has_rows, 100.0 * rms / scale_of(samples), np.inf)


def derivative_fit_errors(
    design: Design, train: Sequence[Record], test: Sequence[Record]
) -> np.ndarray:
    """Fit the derivative on training records; return its NRMSE on others, for each state."""
    coef = _solve(_block_grams(design, train))
    return derivative_errors(design, coef, test, choose_windows(list(train)))
