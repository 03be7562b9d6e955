"""How sure the numbers inside effects are, and what that leaves of the coefficients.

What a small change of the logarithm of a number does to the rates is one more column of the model;
the interval of that column's coefficient is how far the number could be off, relative to itself.
Where a record cannot tell a time of relaxation from how strongly it acts, or a Stribeck speed from
the height of its peak, both intervals are wide. All numbers are allowed for at once, so that each
coefficient is known no better than they leave it.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import replace
from itertools import accumulate

import numpy as np

from ...hidden_states.memory import all_with_memories
from ...signals import Record
from ..effects.candidate import Shape
from ..effects.partners import joined, shares_number
from ..effects.shaping import FROM_RECIPROCALS, tuned_shape
from ..evidence.findings import Finding, memories_in
from ..facts.effect import Effect, Errors
from ..facts.outcome import Outcome
from ..fitting.fit import fit
from ..free_runs.shape_tuning import slopes_of
from ..given.design import Column, Design
from ..given.rows import variables_of
from ..given.rules import Rules

# Of how far a logarithm may be tuned, to see what it changes: mostly 2 % of a number.
STEP_PER_REACH = 1 / 60
MIN_RELATIVE_CHANGE = 1e-9  # of the rates: a change that moves them by less is rounding


def with_numbers_known(
    outcome: Outcome,
    findings: Sequence[Finding],
    design: Design,
    rules: Rules,
    rng: np.random.Generator,
) -> Outcome:
    """Return an outcome whose intervals say what coefficients and numbers may be together.

    Parameters
    ----------
    outcome : Outcome
        With the intervals that coefficients have if the numbers inside the effects are right.
    findings : sequence of Finding
        Its effects, in the same order.
    design : Design
        The corrected model, with p columns: those of the effects come last.
    rules : Rules
        Error that the coefficients minimize.
    rng : numpy.random.Generator
        Draws the blocks.

    Returns
    -------
    Outcome
        The same one where no effect has numbers in it that were tuned.
    """
    declared = design.dropping(column for finding in findings for column in finding.columns)
    shapes = [_shape_in(finding, design, declared.constants) for finding in findings]
    groups = _sharing(findings, shapes)
    if not groups:
        return outcome
    acted = all_with_memories(outcome.train, memories_in(findings))
    changes = [_changes(group, findings, shapes, outcome.effects, design) for group in groups]
    flat = [change for those in changes for change in those]
    half = _half_widths(design, flat, acted, rules, rng)
    effects = _with_wider_coefficients(outcome.effects, findings, half[: len(design.columns)])
    of_numbers = iter(half[len(design.columns) :])
    for group, those in zip(groups, changes, strict=True):
        relative = np.array([next(of_numbers) for _ in those])
        for place in group:
            effects[place] = _with_numbers(effects[place], shapes[place], relative)
    after = _with_wider_parameters(outcome.after, half)
    steps = [replace(s, errors=after) if s.errors is outcome.after else s for s in outcome.steps]
    return replace(outcome, effects=effects, after=after, steps=steps)


def _shape_in(finding: Finding, design: Design, known: Set[float]) -> Shape | None:
    """Return the numbers inside an effect; those of one that remembers may have been fixed."""
    if not finding.columns:
        return None
    remembers = len(design.dropping(finding.columns).paths) < len(design.paths)
    return finding.candidate.shape if remembers else tuned_shape(finding.candidate, known)


def _sharing(findings: Sequence[Finding], shapes: Sequence[Shape | None]) -> list[list[int]]:
    """Return the places of effects with numbers, those together that have the same ones."""
    groups: list[list[int]] = []
    for place in (k for k, shape in enumerate(shapes) if shape is not None):
        own = findings[place].candidate
        alike = (g for g in groups if shares_number(findings[g[0]].candidate, own))
        group = next(alike, None)
        if group is None:
            groups.append([place])
        else:
            group.append(place)
    return groups


def _changes(
    group: Sequence[int],
    findings: Sequence[Finding],
    shapes: Sequence[Shape | None],
    effects: Sequence[Effect],
    design: Design,
) -> list[Column]:
    """Return what the logarithm of each number changes in the rates, per unit of it."""
    shape = shapes[group[0]]
    if shape is None:
        return []
    whole = joined([findings[place].candidate for place in group])
    weights = np.concatenate([effects[place].coefficients for place in group])
    return slopes_of(whole, shape, design, weights, STEP_PER_REACH * shape.reach)


def _shows(change: Column, acted: Sequence[Record]) -> bool:
    """Tell whether records show a change: it has values, and they are more than rounding."""
    values = np.concatenate([change.evaluate(variables_of(record)) for record in acted])
    largest = max(np.abs(record.x_dot).max() for record in acted)
    return bool(np.isfinite(values).all() and np.abs(values).max() > MIN_RELATIVE_CHANGE * largest)


def _half_widths(
    design: Design,
    changes: Sequence[Column],
    acted: Sequence[Record],
    rules: Rules,
    rng: np.random.Generator,
) -> np.ndarray:
    """Return half the widths of the intervals of all coefficients, those of changes at the end.

    Nothing is known of a change that does not show.
    """
    n_own = len(design.columns)
    half = np.concatenate([np.zeros(n_own), np.full(len(changes), np.nan)])
    shown = [k for k, change in enumerate(changes) if _shows(change, acted)]
    if shown:
        whole = design.adding(changes[k] for k in shown)
        criterion = "derivative" if design.paths else rules.criterion
        low, high = fit(whole, acted, rng, criterion).intervals.T
        half[[*range(n_own), *(n_own + k for k in shown)]] = 0.5 * (high - low)
    return half


def _with_wider_coefficients(
    effects: Sequence[Effect], findings: Sequence[Finding], half: np.ndarray
) -> list[Effect]:
    """Return effects with the intervals that allow for all numbers, where these are wider."""
    counts = [len(finding.columns) for finding in findings]
    ends = accumulate(counts, initial=len(half) - sum(counts))
    found = []
    for effect, count, first in zip(effects, counts, ends, strict=False):
        if count:
            own = half[first : first + count]
            known = effect.confidence_intervals
            wide = _wider(known, effect.coefficients, own)
            # Zero would be no effect, whatever its numbers, and that was refuted.
            wide = _with_sign_of(known, wide) if count == 1 else wide
            effect = replace(effect, confidence_intervals=wide)
        found.append(effect)
    return found


def _with_sign_of(known: np.ndarray, wide: np.ndarray) -> np.ndarray:
    """Return wider intervals, (n, 2), that end at zero where the known ones do not hold it."""
    low = np.where(known[:, 0] > 0.0, np.maximum(wide[:, 0], 0.0), wide[:, 0])
    high = np.where(known[:, 1] < 0.0, np.minimum(wide[:, 1], 0.0), wide[:, 1])
    return np.column_stack([low, high])


def _with_wider_parameters(errors: Errors, half: np.ndarray) -> Errors:
    """Return errors with the intervals of the declared parameters, the first coefficients."""
    known = errors.parameter_intervals
    widths = zip(known, half, strict=False)
    wide = {name: _wider(known[name], errors.parameters[name], width) for name, width in widths}
    return replace(errors, parameter_intervals=wide)


def _wider(ends: np.ndarray, value: np.ndarray | float, half: np.ndarray | float) -> np.ndarray:
    """Return intervals, shape (..., 2), that hold others and so much to both sides of a value."""
    low, high = np.minimum(ends[..., 0], value - half), np.maximum(ends[..., 1], value + half)
    return np.stack([low, high], axis=-1)


def _with_numbers(effect: Effect, shape: Shape | None, relative: np.ndarray) -> Effect:
    """Return an effect with its numbers, which are positive, and their intervals."""
    if shape is None:
        return effect
    shown = {
        meaning: 1.0 / value if meaning.endswith(FROM_RECIPROCALS) else value
        for meaning, value in shape.named.items()
    }
    factors = np.maximum(1.0 + relative[:, None] * [-1.0, 1.0], 0.0)
    intervals = np.array(list(shown.values()))[:, None] * factors
    return replace(effect, numbers=shown, number_intervals=intervals)
