"""Right-hand sides of many runs at once, one column for each run.

All columns take the same Runge-Kutta steps of order 4 in one array. A switch that is *held* stays
at zero by Filippov's rule, as in the free run.

======  =========================  ======================================================
symbol  shape                      meaning
======  =========================  ======================================================
x       (n_states, n_columns)      states
u, du   (n_inputs, n_columns)      inputs at the start of a step, and their slopes
s       (n_switches, n_columns)    frozen signs, or equivalent ones where a switch is held
held    (n_switches, n_columns)    whether a switch is held at zero
coef    (n_states, n_terms,        coefficients of the model of each column
        n_columns)
======  =========================  ======================================================
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..equations import Equations
from .structure import Switch, find_switches, is_affine
from .tape import Tape

SWEEPS = 8  # of the fixed-point iteration over several switches at zero
SIGN_TOLERANCE = 1e-9  # change of a sign between two sweeps at which the iteration ends
PROBE = 1e-3  # share of a step over which the slope of a switching function is taken


@dataclass(frozen=True)
class Field:
    """The right-hand side on columns.

    Attributes
    ----------
    tape : Tape
        Terms.
    coef : ndarray of shape (n_models, n_states, n_terms)
        Coefficients of each model.
    switches : tuple of Switch
        Arguments of sgn.
    affine : bool
        Whether signs are only factors of terms, so that x_dot is affine in them.
    """

    tape: Tape
    coef: np.ndarray
    switches: tuple[Switch, ...]
    affine: bool

    def coef_of(self, n_columns: int) -> np.ndarray:
        """Return the coefficients of each column, those of the first model first."""
        by_model = np.moveaxis(self.coef, 0, -1)
        return np.repeat(by_model, n_columns // len(self.coef), axis=-1)


class Columns(NamedTuple):
    """State of some columns at the start of a step; see the table of the module.

    `t`, of shape (n_columns,), holds the time of each column. This class is a plain tuple: steps
    make many of them, and to make a dataclass takes longer than the arithmetic.
    """

    x: np.ndarray
    u: np.ndarray
    du: np.ndarray
    t: np.ndarray
    s: np.ndarray
    held: np.ndarray
    coef: np.ndarray

    def pick(self, at: np.ndarray) -> Columns:
        """Return some of the columns."""
        return Columns(*(part[..., at] for part in self))

    def fed(self, u: np.ndarray, du: np.ndarray, t: np.ndarray) -> Columns:
        """Return the columns with the inputs of the next sample interval."""
        return self._replace(u=u, du=du, t=t)

    def put(self, at: np.ndarray, other: Columns) -> None:
        """Write the states, signs and times of other columns into some of these."""
        for name in ("x", "u", "t", "s", "held"):
            getattr(self, name)[..., at] = getattr(other, name)


def field_of(equations: Equations, batch: np.ndarray) -> Field:
    """Return the right-hand side of models that share their terms, without unused terms."""
    used = np.flatnonzero(np.any(batch != 0.0, axis=(0, 1)))
    terms = tuple(equations.terms[i] for i in used)
    n_states = len(equations.states)
    switches = find_switches(terms, n_states)
    n_variables = n_states + len(equations.inputs) + 1
    tape = Tape(terms, switches, n_variables)
    return Field(tape, batch[:, :, used], switches, is_affine(terms))


def step(field: Field, c: Columns, h: np.ndarray) -> Columns:
    """Take one Runge-Kutta step of length h in every column, with frozen signs."""
    k1 = _rates(field, c, h)
    middle = moved(c, k1, h / 2)
    k2 = _rates(field, middle, h)
    k3 = _rates(field, moved(c, k2, h / 2), h)
    end = moved(c, k3, h)
    k4 = _rates(field, end, h)
    x = c.x + h / 6 * (k1 + 2 * (k2 + k3) + k4)
    return Columns(x, end.u, c.du, end.t, c.s.copy(), c.held.copy(), c.coef)


def moved(c: Columns, k: np.ndarray, h: np.ndarray) -> Columns:
    """Return the columns after a time h at the rates k."""
    return Columns(c.x + h * k, c.u + h * c.du, c.du, c.t + h, c.s, c.held, c.coef)


def _rates(field: Field, c: Columns, h: np.ndarray) -> np.ndarray:
    """Return x_dot; a held switch has the equivalent sign that keeps it at zero."""
    rates = _plain_rates(field, c, c.s)
    if not c.held.any():
        return rates
    at = np.flatnonzero(c.held.any(axis=0))
    part = c.pick(at)
    signs = _equivalent(field, part, part.held, h[at])
    balanced = _mixed_rates(field, part, signs)
    for i, switch in enumerate(field.switches):
        if switch.state is not None:
            balanced[switch.state, part.held[i]] = 0.0  # a held state stays exactly zero
    rates[:, at] = balanced
    return rates


def _mixed_rates(field: Field, c: Columns, s: np.ndarray, first: int = 0) -> np.ndarray:
    """Return Filippov's convex combination of x_dot at the signs -1 and 1 of held switches."""
    held = [] if field.affine else np.flatnonzero(c.held.any(axis=1)).tolist()
    held = [i for i in held if i >= first]
    if not held:
        return _plain_rates(field, c, s)
    i = held[0]
    ends = []
    for end in (-1.0, 1.0):
        fixed = s.copy()
        fixed[i] = np.where(c.held[i], end, s[i])
        ends.append(_mixed_rates(field, c, fixed, i + 1))
    share = np.where(c.held[i], (s[i] + 1.0) / 2.0, 0.0)
    return ends[0] + share * (ends[1] - ends[0])


def _plain_rates(field: Field, c: Columns, s: np.ndarray) -> np.ndarray:
    theta = field.tape.theta([*c.x, *c.u, c.t], s)
    if len(field.coef) == 1:
        return field.coef[0] @ theta
    if not np.isfinite(theta).all():  # NaN must not reach models without this term
        theta = np.where(np.any(c.coef != 0.0, axis=0), theta, 0.0)
    return np.einsum("skc,kc->sc", c.coef, theta)


def switching(field: Field, c: Columns) -> np.ndarray:
    """Return the arguments g of the signs, shape (n_switches, n_columns)."""
    return field.tape.switches([*c.x, *c.u, c.t], c.s)


def _slope(field: Field, c: Columns, s: np.ndarray, i: int, h: np.ndarray) -> np.ndarray:
    """Return dg_i/dt with the signs s."""
    rates = _plain_rates(field, c, s)
    state = field.switches[i].state
    if state is not None:
        return rates[state]
    probe = PROBE * h
    ahead = moved(c, rates, probe)
    return (switching(field, ahead)[i] - switching(field, c)[i]) / probe


def both_slopes(
    field: Field, c: Columns, s: np.ndarray, i: int, h: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return dg_i/dt with sign i at 1 and at -1."""
    up, down = s.copy(), s.copy()
    up[i], down[i] = 1.0, -1.0
    return _slope(field, c, up, i, h), _slope(field, c, down, i, h)


def _equivalent(field: Field, c: Columns, held: np.ndarray, h: np.ndarray) -> np.ndarray:
    """Return the signs that keep all held switches at zero; they may exceed 1 in size."""
    s = c.s.copy()
    several = held.sum(axis=0).max() > 1
    for _ in range(SWEEPS if several else 1):
        before = s.copy()
        for i in np.flatnonzero(held.any(axis=1)).tolist():
            up, down = both_slopes(field, c, s, i, h)
            s[i] = np.where(held[i], balance(up, down), s[i])
        if not several or np.allclose(s, before, rtol=0.0, atol=SIGN_TOLERANCE, equal_nan=True):
            break
    return s


def balance(up: np.ndarray, down: np.ndarray) -> np.ndarray:
    """Return the sign, also beyond -1 and 1, at which a slope that is affine in it is zero."""
    total, gap = up + down, down - up
    with np.errstate(all="ignore"):
        return np.where(total == 0.0, 0.0, total / gap)


def choose_substeps(field: Field, c: Columns, h: np.ndarray, tolerance: float, largest: int) -> int:
    """Return the number of steps per sample interval that is enough in nine columns of ten.

    Parameters
    ----------
    field : Field
        Right-hand side.
    c : Columns
        Columns at their starts, which serve as a sample of the trajectory.
    h : ndarray of shape (n_columns,)
        Sample interval.
    tolerance : float
        Error of one interval, relative to the largest magnitude of each state, or of its change.
    largest : int
        Largest number to return.

    Returns
    -------
    int
    """
    once = step(field, c, h)
    twice = step(field, step(field, c, h / 2), h / 2)
    size = np.maximum(np.abs(c.x).max(axis=1), np.abs(once.x - c.x).max(axis=1))
    worst = np.max(np.abs(once.x - twice.x) / np.where(size > 0, size, 1.0)[:, None], axis=0)
    worst = worst[np.isfinite(worst)]
    if not len(worst):
        return 1
    typical = float(np.quantile(worst, 0.9))
    return int(min(max(np.ceil((typical / tolerance) ** 0.25), 1), largest))
