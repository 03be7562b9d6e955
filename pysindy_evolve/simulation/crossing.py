"""Steps of many columns that cross switches.

The rules are those of the free run: a column whose step crosses a switch is cut there by regula
falsi, decides whether it passes or sticks, and takes the rest of its step.
"""

from __future__ import annotations

import numpy as np

from .columns import (
    SIGN_TOLERANCE,
    SWEEPS,
    Columns,
    Field,
    balance,
    both_slopes,
    moved,
    step,
    switching,
)

MAX_EVENTS = 8  # switches crossed in one step
REFINEMENTS = 2  # steps of regula falsi after the first interpolation


def advance(field: Field, columns: Columns, h: np.ndarray) -> Columns:
    """Take one step of length h, shape (n_columns,), in every column."""
    if not field.switches:
        return step(field, columns, h)
    columns = _synchronized(field, columns, h)
    after = step(field, columns, h)
    todo, crossed = _crossed(field, after)
    now, rest, end = columns, h, after
    for _ in range(MAX_EVENTS):
        if not len(todo):
            break
        now, rest = _cross(field, now.pick(crossed), rest[crossed], end.pick(crossed))
        end = step(field, now, rest)
        after.put(todo, end)
        beyond, crossed = _crossed(field, end)
        todo = todo[beyond]
    return after


def start_signs(field: Field, columns: Columns, h: np.ndarray) -> Columns:
    """Set the signs at measured states, by Filippov's rule where a switch is exactly at zero."""
    for _ in field.switches:  # inner signs first
        columns = columns._replace(s=np.sign(switching(field, columns)))
    zero = switching(field, columns) == 0.0
    return _resolve(field, columns, zero, h) if zero.any() else columns


def _resolve(field: Field, c: Columns, zero: np.ndarray, h: np.ndarray) -> Columns:
    """Apply Filippov's rule to the switches that are at zero, each given the others."""
    s, held = c.s.copy(), c.held.copy()
    several = zero.sum(axis=0).max() > 1
    for _ in range(SWEEPS if several else 1):
        before = s.copy()
        for i in np.flatnonzero(zero.any(axis=1)).tolist():
            up, down = both_slopes(field, c, s, i, h)
            onward = np.where(s[i] == 0.0, 1.0, -np.sign(s[i]))
            rule = np.where(up > 0.0, np.where(down >= 0.0, 1.0, onward), balance(up, down))
            rule = np.where((up <= 0.0) & (down < 0.0), -1.0, rule)
            s[i] = np.where(zero[i], np.clip(rule, -1.0, 1.0), s[i])
        if not several or np.allclose(s, before, rtol=0.0, atol=SIGN_TOLERANCE, equal_nan=True):
            break
    held = np.where(zero, np.abs(s) < 1.0, held)
    return c._replace(s=s, held=held)


def _synchronized(field: Field, c: Columns, h: np.ndarray) -> Columns:
    """Release held switches beyond their limit, and update signs that depend on inputs only."""
    for i, switch in enumerate(field.switches):
        if switch.external:
            g = switching(field, c)[i]
            after = switching(field, moved(c, np.zeros_like(c.x), h))[i]
            c.s[i] = np.where(g == 0.0, np.sign(after), np.sign(g))
            c.held[i] = False
    if c.held.any():
        at = np.flatnonzero(c.held.any(axis=0))
        part = c.pick(at)
        c.put(at, _resolve(field, part, part.held, h[at]))
    return c


def _crossed(field: Field, after: Columns) -> tuple[np.ndarray, np.ndarray]:
    """Return the columns whose step crossed a switch: as indices, and as a mask."""
    beyond = (~after.held & (after.s * switching(field, after) < 0.0)).any(axis=0)
    return np.flatnonzero(beyond), beyond


def _cross(field: Field, c: Columns, h: np.ndarray, after: Columns) -> tuple[Columns, np.ndarray]:
    """Step to the first switch of each column, apply Filippov's rule; also return the rest of h."""
    fraction, first = _fractions(field, c, h, after)
    at = step(field, c, fraction * h)
    zero = at.held.copy()
    zero[first, np.arange(len(h))] = True
    for i, switch in enumerate(field.switches):
        if switch.state is not None:
            at.x[switch.state, zero[i]] = 0.0
    at = _resolve(field, at, zero, h)
    if len(field.switches) > 1:  # an argument may hold a sign that has just jumped
        g = switching(field, at)
        at = at._replace(s=np.where(zero | at.held | (g == 0.0), at.s, np.sign(g)))
    return at, (1.0 - fraction) * h


def _fractions(
    field: Field, c: Columns, h: np.ndarray, after: Columns
) -> tuple[np.ndarray, np.ndarray]:
    """Locate the first switch within a step: its fraction of h, and which switch it is."""
    signs = np.where(c.held, 0.0, c.s)
    start = np.maximum(signs * switching(field, c), 0.0)
    end = signs * switching(field, after)
    with np.errstate(all="ignore"):
        share = np.where(end < 0.0, start / (start - end), np.inf)
    first = np.argmin(share, axis=0)
    columns = np.arange(len(h))
    low, high = np.zeros(len(h)), np.ones(len(h))
    low_value, high_value = start[first, columns], end[first, columns]
    fraction = np.clip(share[first, columns], 0.0, 1.0)
    for _ in range(REFINEMENTS):
        trial = step(field, c, fraction * h)
        value = (signs * switching(field, trial))[first, columns]
        inside = value >= 0.0
        low, low_value = np.where(inside, fraction, low), np.where(inside, value, low_value)
        high, high_value = np.where(inside, high, fraction), np.where(inside, high_value, value)
        with np.errstate(all="ignore"):
            fraction = low + (high - low) * low_value / (low_value - high_value)
        fraction = np.clip(np.nan_to_num(fraction, nan=0.0), 0.0, 1.0)
    return fraction, first
