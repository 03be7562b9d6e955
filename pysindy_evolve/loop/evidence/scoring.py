"""Propose what may be missing from a design, and score it beside the design's own columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from ...equations import Equations
from ...signals import Record
from ..effects.candidate import Candidate
from ..effects.inertia import InertiaCandidate, inertias
from ..effects.missing import candidates, for_trajectories, terms_in
from ..effects.modulation import ActingTerm
from ..effects.partners import shared_effects
from ..effects.periodic import (
    N_LINES,
    Signal,
    is_same_ripple,
    periodic_candidates,
    ripple_candidates,
)
from ..effects.pumped_terms import partner_pumps, pumped_candidates, shared_pumps
from ..effects.rippled_terms import rippled_candidates
from ..effects.stops import begins_within, one_end_each
from ..effects.varying_terms import parts_of
from ..fitting.linear import solve_gram
from ..fitting.residual import derivative_grams, residual_on
from ..fitting.trajectory import Trajectories
from ..given.design import Column, Design, in_state
from ..given.ranges import Ranges
from ..given.rows import rows_of, variables_of
from ..given.segments import Segments
from .held_out_scores import rank, ranked
from .ranking import Ranking, Score
from .spectral import spectral_grams

EVALUATIONS_PER_NUMBER = 16  # evaluations for each number of a shape
Proposer = Callable[[Design, Equations, Segments], list[Candidate]]

MIN_GAIN_LOG = 0.02  # gain in log error: names do not change for less
# Log error that a grown term must gain for each node: one of ten nodes must gain 1.0.
PRICE_PER_NODE_LOG = 0.1
# Log error: extra gain asked of an effect that brings one more number, column or hidden state, as
# much as a node of a grown term costs. A filter makes the sign of a speed look as if it remembered;
# with less, a pendulum lost its drag to a hysteresis.
EXTRA_LEAD_LOG = PRICE_PER_NODE_LOG


def quick_fit(design: Design, part: Segments) -> Equations:
    """Fit a design on segments by its derivative, or by the trajectory if that is what scores."""
    return design.equations(_coefficients(design, part))


def _coefficients(design: Design, part: Segments) -> np.ndarray:
    """Return a coefficient for each column of a design."""
    if part.by_trajectory:
        return Trajectories(part.records, design, design.columns).fit()[0]
    return solve_gram(derivative_grams(part, design, design.columns).sum(axis=0))


def propose(design: Design, equations: Equations, part: Segments) -> list[Candidate]:
    """Return what may be missing: the vocabulary, and waves over time and position."""
    records = part.records
    ranges = Ranges.of(rows_of(records))
    proposed = candidates(design, ranges)
    if part.by_trajectory:
        proposed = for_trajectories(proposed)
    by_record = [residual_on(equations, record) for record in records]
    first = int(np.argmax([len(record) for record in records]))
    longest = records[first]
    drivers = longest.x[:, :0] if longest.u is None else longest.u
    cutoff = np.inf if longest.cutoff is None else longest.cutoff
    for state in design.open_states:
        residuals = [rows[:, state] for rows in by_record]
        signal = Signal(residuals[first], drivers, longest.dt, cutoff)
        proposed += periodic_candidates(state, design.time, signal)
        proposed += _varying_terms(design, state, signal, longest)
        position = design.position_of(state)
        if position is not None:
            if not part.by_trajectory:
                inputs = range(len(design.states), design.time)
                proposed += inertias(state, position, equations.sums[state], ranges, inputs)
            proposed += _ripples(state, position, residuals, records)
    shared = [*shared_effects(design, proposed), *shared_pumps(design, proposed)]
    return [*proposed, *shared, *partner_pumps(design, len(longest) * longest.dt)]


def _varying_terms(design: Design, state: int, signal: Signal, record: Record) -> list[Candidate]:
    """Return the terms of an equation times waves, of the time and of the position."""
    time, position = design.time, design.position_of(state)
    parts = (part for part in parts_of(design, state) if time not in part.variables)
    found: list[Candidate] = []
    for branch, part in enumerate(parts, N_LINES):
        term = ActingTerm(part, part.evaluate(variables_of(record)), branch)
        found += pumped_candidates(state, time, signal, term)
        if position is not None:
            q, noise = record.x[:, position], _noise_of(record, position)
            found += rippled_candidates(state, position, signal.values, term, q, noise)
    return found


def _ripples(
    state: int, position: int, residuals: Sequence[np.ndarray], records: Sequence[Record]
) -> list[Candidate]:
    """Return the ripples that any record shows: a slow one may show them best."""
    found: list[Candidate] = []
    for residual, record in zip(residuals, records, strict=True):
        q, noise = record.x[:, position], _noise_of(record, position)
        found += [
            ripple
            for ripple in ripple_candidates(state, position, residual, q, noise)
            if not any(is_same_ripple(ripple, other) for other in found)
        ]
    return found


def _noise_of(record: Record, position: int) -> float:
    """Return the noise of the sensor of a position, a standard deviation; zero if unknown."""
    made = record.preparation
    return 0.0 if made is None else float(made.noise[position // made.order])


def score(
    design: Design, part: Segments, proposed: Sequence[Candidate], *, pairs: bool = True
) -> Ranking:
    """Score candidates on segments, each refitted together with the columns of the design."""
    extra = [column for candidate in proposed for column in columns_of(candidate, design)]
    n_fixed = len(design.columns)
    columns, present = [*design.columns, *extra], terms_in(design)
    if part.by_trajectory:
        tracks = Trajectories(part.records, design, columns)
        return ranked(tracks.errors, tracks.total(0), n_fixed, proposed, present, pairs=pairs)
    grams = spectral_grams(part, design, columns)
    return rank(grams, n_fixed, proposed, present, part.folds, pairs=pairs)


def net(score: Score) -> float:
    """Return what a group gains per effect, less the price of its nodes."""
    return score.value - PRICE_PER_NODE_LOG * sum(c.size for c in score.group) / len(score.group)


def columns_of(candidate: Candidate, design: Design) -> tuple[Column, ...]:
    """Return the columns that a candidate, and then its partners, add to a design."""
    n_states = len(design.states)
    columns = [
        in_state(candidate.name, term, candidate.state, n_states) for term in candidate.terms
    ]
    if isinstance(candidate, InertiaCandidate):
        pairs = zip(columns, candidate.waves, strict=True)
        columns = [replace(column, inertia=wave) for column, wave in pairs]
    return (*columns, *(c for partner in candidate.partners for c in columns_of(partner, design)))


def sharpened(design: Design, part: Segments, proposed: Sequence[Candidate]) -> list[Candidate]:
    """Return the candidates on the grid, and the promising shapes among them tuned.

    For a saturation between two places of the grid, a power of the input may fit better than both.
    A candidate that contains its parents, as an end stop contains an offset, is tuned without them:
    the offset would make up for a wrong place.
    """
    scores = score(design, part, [_by_itself(c) for c in proposed], pairs=False)
    best_value = scores[0].value if scores else 0.0
    best_shapes: dict[tuple[str, int, int, int], Candidate] = {}
    for s in scores:
        (c,) = s.group
        if c.shape is not None and s.value > max(MIN_GAIN_LOG, best_value / 2):
            best_shapes.setdefault((c.name, c.state, c.shape.branch, len(c.partners)), c)
    parents = {_by_itself(c): c.parents for c in proposed}
    sharp = [replace(tuned(c, design, part), parents=parents[c]) for c in best_shapes.values()]
    return [*proposed, *sharp, *(end for c in sharp for end in one_end_each(c))]


def _by_itself(candidate: Candidate) -> Candidate:
    return replace(candidate, parents=()) if candidate.contains_parents else candidate


def tuned(candidate: Candidate, design: Design, part: Segments) -> Candidate:
    """Tune the numbers that a candidate's shape depends on, starting from the grid."""
    shape = candidate.shape
    if shape is None:
        return candidate

    def at(logs: np.ndarray) -> Candidate:
        return candidate.at(np.exp(logs).tolist())

    def loss(logs: np.ndarray) -> float:
        moved = at(np.atleast_1d(logs))
        if candidate.contains_parents and not begins_within(moved, part.rows):
            return 0.0
        if candidate.passive and not takes_energy(moved, design, part):
            return 0.0
        scores = score(design, part, [moved], pairs=False)
        return -scores[0].value if scores else 0.0

    start = np.log(shape.values)
    bounds = np.column_stack([start - shape.reach, start + shape.reach])
    if len(start) == 1:
        best = minimize_scalar(
            loss, bounds=bounds[0], method="bounded", options={"maxiter": EVALUATIONS_PER_NUMBER}
        )
    else:
        simplex = np.vstack([start, start + 0.5 * shape.reach * np.eye(len(start))])
        options = {"maxfev": EVALUATIONS_PER_NUMBER * len(start), "initial_simplex": simplex}
        best = minimize(loss, start, method="Nelder-Mead", bounds=bounds, options=options)
    return at(np.atleast_1d(best.x)) if best.fun < loss(start) else candidate


def takes_energy(candidate: Candidate, design: Design, part: Segments) -> bool:
    """Tell whether the coefficient of a candidate's first column is negative beside a design."""
    coef = _coefficients(design.adding(columns_of(candidate, design)), part)
    return bool(coef[len(design.columns)] < 0.0)  # partners come after it
