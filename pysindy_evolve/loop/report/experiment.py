"""The next measurement: a motion that tells an effect from its alternative (T-optimality).

The corrected model, and the same with a rival in the place of the effect, are compared on imagined
motions: the recorded one at other amplitudes and frequencies. The rival's coefficients are refitted
to the record and the imagined motion together, so only the difference that no coefficient can
absorb counts. It is weighed frequency by frequency by the noise of the record, and given in
standard errors.

References
----------
Atkinson and Fedorov, Biometrika 62 (1975), DOI 10.1093/biomet/62.1.57: T-optimality.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal.windows import tukey

from ...checks import TINY
from ...equations import Equations
from ...hidden_states.memory_equations import as_acting
from ..evidence.spectral import TAPER, spectral_rows
from ..facts.effect import Alternative, Effect
from ..facts.outcome import Outcome
from ..fitting.linear import solve_gram
from ..fitting.residual import forces
from ..given.design import Design, in_state
from ..given.segments import Segments, segments
from ..given.sticking import may_rest
from .advice import ENOUGH_STANDARD_ERRORS, Experiment, Plan
from .cautions import cautions
from .motions import Motion, Motions
from .number_text import check_units
from .printed_names import as_printed

MAX_ROWS = 8000  # rows of the records that are used
SMOOTHING = 4.0  # standard deviation of the Gaussian over the noise spectrum, in its bins


def plan(outcome: Outcome, units: Mapping[str, str] | None = None) -> Plan:
    """Return an experiment for each pair of an effect and an alternative.

    Parameters
    ----------
    outcome : Outcome
        What the loop found.
    units : mapping of str to str, optional
        Units of the variables.

    Returns
    -------
    Plan
    """
    check_units("suggest_experiment", units, outcome.before.model.names)
    if not any(effect.rivals for effect in outcome.effects):
        return Plan((), units)
    outcome = as_printed(outcome)
    acting = [as_acting(outcome.equations, record) for record in outcome.train]
    equations, records = acting[0][0], [record for _, record in acting]
    part = segments(records, may_rest(outcome.design, records), max_rows=MAX_ROWS)
    judge = _Judge(equations, part)
    experiments = []
    in_time = tuple(one for one in outcome.effects if one.memory is not None and one.alternatives)
    for effect in (one for one in outcome.effects if one.memory is None):
        for rival in effect.rivals:
            exchanged = _exchanged(outcome.design, effect, rival)
            experiments.append(_best(judge, exchanged, effect, rival))
    return Plan(tuple(experiments), units, in_time, settled=not cautions(outcome))


def _exchanged(design: Design, effect: Effect, rival: Alternative) -> Design:
    """Return the model with a rival in the place of an effect.

    The columns of the effect are found by their terms, as a grown term may have been renamed. Of
    two columns with the same term the last is the effect's. A limit has no column.
    """
    place, target = design.states.index(effect.state), design.states.index(rival.state)
    column_of = {column.parts[place]: column for column in design.columns}
    columns = [
        column_of[expression] for expression in effect.expressions if expression in column_of
    ]
    replacements = [
        in_state(rival.name, term, target, len(design.states)) for term in rival.expressions
    ]
    return design.dropping(columns).adding(replacements)


class _Judge:
    """Weighs the difference of two models on imagined motions by the noise of the record."""

    def __init__(self, equations: Equations, part: Segments) -> None:
        self.equations, self.part = equations, part
        self.motions = Motions(equations, part.z)
        residual = (part.x_dot - self.rates(part.z)) * part.weight
        power = np.mean(np.abs(spectral_rows(part, residual)) ** 2, axis=0)
        floor = 1e-12 * power.max(axis=0, keepdims=True) + TINY
        self.noise = gaussian_filter1d(np.maximum(power, floor), SMOOTHING, axis=0, mode="nearest")
        taper = tukey(part.z.shape[1], TAPER)
        # Factor on the noise, as neighboring frequencies of a tapered segment are not independent.
        self.overlap = len(taper) * np.sum(taper**2) / np.sum(taper) ** 2

    def rates(self, z: np.ndarray) -> np.ndarray:
        """Return the right-hand sides on states, inputs and time z."""
        flat = z.reshape(-1, z.shape[-1])
        n_states = len(self.equations.states)
        values = self.equations.evaluate(flat[:, :n_states], flat[:, n_states:-1], flat[:, -1])
        return values.reshape(*z.shape[:-1], n_states)

    def forces(self, design: Design, z: np.ndarray) -> np.ndarray:
        """Return a design's columns, then the model's rates: (segments, n, states, p + 1)."""
        imagined = replace(self.part, z=z, x_dot=self.rates(z))
        return forces(imagined, design, design.columns)

    def gram(self, design: Design, force: np.ndarray, frequency: float) -> np.ndarray:
        """Return inner products of the columns in units of the noise, shape (p + 1, p + 1).

        The noise has variance one in each real and each imaginary part of the rows. The motion is
        faster than the recorded one by the factor `frequency`, and its rows are judged by the noise
        at their own frequencies.
        """
        total = np.zeros((force.shape[-1], force.shape[-1]))
        index = np.arange(len(self.noise)) * frequency
        in_band = index <= len(self.noise) - 1  # the noise above it is not known
        for state in design.open_states:
            rows = spectral_rows(self.part, force[:, :, state])
            noise = np.interp(index, np.arange(len(self.noise)), self.noise[:, state])
            rows = rows * np.sqrt(2.0 * in_band / (self.overlap * noise))[:, None]
            flat = rows.reshape(-1, rows.shape[-1])
            total += (flat.conj().T @ flat).real
        return total


def _best(judge: _Judge, exchanged: Design, effect: Effect, rival: Alternative) -> Experiment:
    """Return the motion closest to the recorded one that suffices; the best one if none does."""
    recorded = judge.gram(exchanged, judge.forces(exchanged, judge.part.z), 1.0)
    now = _apart(recorded)
    best: tuple[float, Motion, np.ndarray] | None = None
    for motion in judge.motions:
        z = judge.motions.of(motion)
        if z is None:
            continue
        gram = judge.gram(exchanged, judge.forces(exchanged, z), motion.frequency)
        then = _apart(recorded + gram)
        if best is None or then > best[0]:
            best = then, motion, recorded + gram
        if then >= ENOUGH_STANDARD_ERRORS:
            break
    if best is None:  # the recorded motion itself is among them
        raise RuntimeError("LoopReport.suggest_experiment found no motion. Report this as a bug.")
    then, motion, total = best
    return _described(judge, exchanged, effect, rival, (motion, now, then), total)


def _apart(gram: np.ndarray) -> float:
    """Return the residual of the rival's best fit to the model, in standard errors."""
    square = gram[-1, -1] - solve_gram(gram) @ gram[:-1, -1]
    return float(np.sqrt(max(square, 0.0)))


def _described(
    judge: _Judge,
    exchanged: Design,
    effect: Effect,
    rival: Alternative,
    chosen: tuple[Motion, float, float],
    gram: np.ndarray,
) -> Experiment:
    """Return an experiment with what its motion reaches, and where the two models differ most."""
    motion, now, then = chosen
    z = judge.motions.of(motion)
    moved = judge.part.z if z is None else z
    coef = solve_gram(gram)
    force = judge.forces(exchanged, moved)
    gap = np.abs(force[..., -1] - force[..., :-1] @ coef).max(axis=-1)
    # The 99.9 % quantile: the very largest difference may be an outlier.
    place = np.unravel_index(np.argsort(gap, axis=None)[int(0.999 * (gap.size - 1))], gap.shape)
    names, reach = judge.equations.names, {}
    used = {
        variable
        for expression in (*effect.expressions, *rival.expressions)
        for variable in expression.variables
    }
    for variable in sorted({*used, *judge.motions.speeds} - {len(names) - 1}):
        recorded, proposed = (
            float(np.abs(values[..., variable]).max()) for values in (judge.part.z, moved)
        )
        reach[names[variable]] = (recorded, proposed, float(moved[(*place, variable)]))
    target = effect.state if judge.equations.n_algebraic else f"d{effect.state}/dt"
    return Experiment(effect, rival, motion, now, then, reach, float(gap[place]), target)
