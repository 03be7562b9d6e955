"""Does the residual still depend on what was measured? The question behind "untraced".

Generic models predict held-out segments: polynomials of all variables and the recent past of the
inputs, or slow waves of time. Each term of the polynomials does so alone as well, as the noise that
many of them fit would hide a small effect. If one does better than in twins, there is structure
that no tried effect explains: perhaps a delay or a hidden state, which present values do not show.
The past of the states is left out, as filtered sensor noise alone makes x_dot a function of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations_with_replacement

import numpy as np

from ...checks import TINY
from ...equations import Equations
from ...operators import BUILTIN
from ...terms import Cache, call, constant, mul, variable
from ..fitting.linear import log_ratio
from ..given.design import Column, Design, in_state
from ..given.rules import Rules
from ..given.segments import Segments
from ..twins.chance import chance_on_twins
from ..twins.colored import ColoredTwins
from ..twins.twins import TwinMaker
from .held_out_scores import are_new, fold_errors
from .noise_floor import MIN_POWER_OVER_NOISE, NoiseFloor
from .p_values import chance_of, without_noise_shift
from .scoring import quick_fit
from .shares import is_exact
from .spectral import spectral_grams

MAX_COLUMNS = 60  # of a generic model, in each equation
LAGS = (1, 2, 4, 8)  # of the inputs, in eighths of the width of the windows
N_WAVES = 7  # most periods of a slow wave in a record: faster ones are no drift
MIN_STRUCTURE_GAIN_LOG = 0.05  # log error that the generic model must gain, or one of its terms


@dataclass(frozen=True)
class Monomial(Column):
    """A product of variables, some of them delayed, in the equation of one state."""

    factors: tuple[tuple[int, int], ...] = ()
    state: int = 0
    length: int = 1

    def values_in(
        self, state: int, variables: np.ndarray, cache: Cache | None = None
    ) -> np.ndarray | None:
        """Return the product of the variables in its own equation, and None in the others."""
        if state != self.state:
            return None
        index = np.arange(len(variables))
        start = index - index % self.length  # of the segment that a row belongs to
        product = np.ones(len(variables))
        for column, lag in self.factors:
            product = product * variables[np.maximum(index - lag, start), column]
        return product


def structure_chance(
    design: Design, part: Segments, rules: Rules, rng: np.random.Generator
) -> float:
    """Return the chance that a generic model predicts twins as well as the record.

    Parameters
    ----------
    design : Design
        The model in which no effect was found to be missing.
    part : Segments
        Pieces of the training records.
    rules : Rules
        Significance and twins.
    rng : numpy.random.Generator
        Draws the twins.

    Returns
    -------
    float
        One if the generic model gains nothing notable.
    """
    if part.by_trajectory:  # they hold fewer numbers than a generic model has coefficients
        return 1.0
    models = generic_models(design, part)
    observed = generic_gain(design, models, part)
    if observed < MIN_STRUCTURE_GAIN_LOG or is_exact(design, part):
        return 1.0
    equations = quick_fit(design, part)
    if not _exceeds_noise(equations, design, part, rng.spawn(1)[0]):
        return 1.0
    maker = TwinMaker.of(equations, part.records)
    unshifted = without_noise_shift(maker, design, part, rng.spawn(1)[0])
    if unshifted is not None and not _exceeds_noise(unshifted, design, part, rng.spawn(1)[0]):
        return 1.0
    statistic = partial(generic_gain, design, models)
    chance = chance_of(observed, statistic, design, equations, part, rules, rng)[0]
    colored = ColoredTwins.of(equations, part.records) if chance <= rules.level else None
    if colored is None:
        return chance
    other = chance_on_twins(colored, part, statistic, observed, rules, rng.spawn(1)[0])[0]
    return max(chance, other)


def may_have_structure(design: Design, part: Segments) -> bool:
    """Tell, without twins, whether a generic model or one of its terms gains anything notable.

    Parameters
    ----------
    design : Design
        The model so far.
    part : Segments
        Pieces of records, not scored by trajectory.

    Returns
    -------
    bool
        If False, other functions of the variables are unlikely to gain either: a polynomial term
        would explain part of them.
    """
    return generic_gain(design, generic_models(design, part), part) >= MIN_STRUCTURE_GAIN_LOG


def generic_models(design: Design, part: Segments) -> list[list[Column]]:
    """Return the columns of each generic model: functions of the variables, slow waves of time."""
    models = [generic_columns(design, part)]
    if len(part.records) == 1:  # the phase of a wave differs by record
        models.append(slow_waves(design, part))
    return models


def _exceeds_noise(
    equations: Equations, design: Design, part: Segments, rng: np.random.Generator
) -> bool:
    """Tell whether the residual exceeds what sensor noise alone leaves, at some frequencies.

    In a closed loop the input answers the sensor noise, and so predicts its part of the residual.
    Twins do not show this, as no controller answered their noise.
    """
    floor = NoiseFloor.of(equations, design, part, rng)
    return floor is None or floor.excess(equations) > MIN_POWER_OVER_NOISE


def generic_columns(design: Design, part: Segments) -> list[Column]:
    """Return monomials of the variables up to degree three, and delayed inputs."""
    length, n_variables = part.z.shape[1], part.z.shape[2] - 1
    inputs = range(len(design.states), n_variables)
    now = [((v, 0),) for v in range(n_variables)]
    factors: list[tuple[tuple[int, int], ...]] = [()]
    for degree in (1, 2, 3):
        factors += [sum(group, ()) for group in combinations_with_replacement(now, degree)]
    step = max(1, part.windows.width // 8)
    delays = [lag * step for lag in LAGS if lag * step < length // 4]
    past = [((v, lag),) for lag in delays for v in inputs]
    past = past[: MAX_COLUMNS // 2]  # not all, if there are many inputs
    factors = [*factors[: MAX_COLUMNS - len(past)], *past]
    return [
        Monomial(f"{state}: {f}", design.fixed, f, state, length)
        for state in design.open_states
        for f in factors
    ]


def slow_waves(design: Design, part: Segments) -> list[Column]:
    """Return sines and cosines with a few periods in a record."""
    time, n_states = part.rows[:, -1], len(design.states)
    base = 2.0 * np.pi / max(float(np.ptp(time)), TINY)
    t = variable(part.rows.shape[1] - 1)
    arguments = [mul(constant(base * k), t) for k in range(1, N_WAVES + 1)]
    waves = [call(BUILTIN[name], argument) for argument in arguments for name in ("sin", "cos")]
    return [in_state("wave", wave, s, n_states) for s in design.open_states for wave in waves]


def generic_gain(design: Design, models: Sequence[Sequence[Column]], part: Segments) -> float:
    """Return the largest gain, log(held-out error without / with columns).

    It is that of a generic model, or of one column of the first alone: all together fit much noise.
    """
    grams = [spectral_grams(part, design, [*design.columns, *columns]) for columns in models]
    n_fixed = len(design.columns)
    whole = max(_gain(gram, np.arange(gram.shape[1] - 1)[None, :], n_fixed, part) for gram in grams)
    new = n_fixed + np.flatnonzero(are_new(grams[0].sum(axis=0)[:-1, :-1], n_fixed))
    if not len(new):
        return whole
    fixed = np.broadcast_to(np.arange(n_fixed), (len(new), n_fixed))
    return max(whole, _gain(grams[0], np.hstack([fixed, new[:, None]]), n_fixed, part))


def _gain(grams: np.ndarray, models: np.ndarray, n_fixed: int, part: Segments) -> float:
    """Return the gain of the best of some models, given by their columns."""
    without = fold_errors(grams, np.arange(n_fixed)[None, :], part.folds).sum()
    errors = fold_errors(grams, models, part.folds).sum(axis=1)
    return log_ratio(without, float(errors.min()))
