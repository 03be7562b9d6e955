"""Algebraic targets: a force that is what it is now, with nothing differentiated.

The effects of the vocabulary are functions of inputs here: of a position and its velocity where two
inputs are that to each other, of any other input by itself. Hysteresis is a friction whose sign
changes before or after the velocity does, sgn(v + c x) or sgn(v + c a), sharp or rounded off.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ..operators import BUILTIN
from ..signals import Record
from ..terms import Sum, add, call, constant, mul, variable
from .candidate import Candidate, CandidateMaker, Shape

__all__ = ["as_algebraic", "hysteretic", "motions_of", "rounded", "rounded_sign", "yields"]

ALIKE = 0.98  # correlation from which on one input is the slope of another
SLANTS = (0.05, 0.2, 0.8)  # c in sgn(v + c x), in ratios of the sizes of v and x
WIDTHS = (0.0, 0.04, 0.1, 0.25)  # of a rounded sign, in sizes of v; 0 is sharp


def as_algebraic(record: Record) -> Record:
    """Return a record whose target, its columns of x, stands in the place of the rates."""
    return replace(record, x_dot=record.x, preparation=None)


def motions_of(records: Sequence[Record], n_states: int) -> tuple[tuple[int, int], ...]:
    """Return which inputs are position and velocity of the same motion, as variables.

    Parameters
    ----------
    records : sequence of Record
        Training records.
    n_states : int
        Inputs are numbered after so many states.

    Returns
    -------
    tuple of (int, int)
        Position and velocity.
    """
    first = records[0]
    n = first.n_inputs
    found = []
    for position in range(n):
        for velocity in (k for k in range(n) if k != position):
            pairs = [
                (np.gradient(r.u[:, position], r.t), r.u[:, velocity])
                for r in records
                if r.u is not None
            ]
            slope, given = (np.concatenate(side) for side in zip(*pairs, strict=True))
            if slope.std() > 0.0 and given.std() > 0.0:
                alike = np.corrcoef(slope, given)[0, 1] > ALIKE
                if alike and np.isclose(slope.std(), given.std(), rtol=0.2):
                    found.append((n_states + position, n_states + velocity))
    return tuple(found)


def rounded_sign(v: Sum, width: float) -> Sum:
    """Return tanh(v / width)."""
    return call(BUILTIN["tanh"], mul(constant(1.0 / width), v))


def hysteretic(v: Sum, x: Sum, sign: float, width: float, slant: float) -> Sum:
    """Return the sign of v + c x, c being slant with a sign, rounded off over a width if any."""
    slanted = add(v, mul(constant(sign * slant), x))
    return rounded_sign(slanted, width) if width else call(BUILTIN["sgn"], slanted)


def rounded(effect: CandidateMaker, v: int, scales: np.ndarray) -> Iterator[Candidate]:
    """Go through frictions whose sign is rounded off."""
    for width in (w for w in WIDTHS if w):
        smooth = Shape(width * float(scales[v]), (partial(rounded_sign, variable(v)),))
        yield effect("Coulomb friction", shape=smooth)


def yields(effect: CandidateMaker, x: int, v: int, scales: np.ndarray) -> Iterator[Candidate]:
    """Go through hysteretic frictions of a velocity, led or followed by another variable."""
    speed, reach = float(scales[v]), float(scales[x])
    for width in WIDTHS:
        for sign in (1.0, -1.0):
            build = partial(hysteretic, variable(v), variable(x), sign, width * speed)
            for slant in SLANTS:
                yield effect("hysteresis", shape=Shape(slant * speed / reach, (build,)))
