"""Hysteresis, and friction whose sign is rounded off.

Hysteresis is a friction whose sign changes before or after the velocity does, sgn(v + c x) or
sgn(v + c a), sharp or rounded off.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from ..operators import BUILTIN
from ..terms import Sum, add, call, constant, mul, variable
from .candidate import Candidate, CandidateMaker, Shape

__all__ = ["hysteretic", "rounded", "rounded_sign", "yields"]

SLANTS = (0.05, 0.2, 0.8)  # c in sgn(v + c x), in ratios of the sizes of v and x
WIDTHS = (0.0, 0.04, 0.1, 0.25)  # of a rounded sign, in sizes of v; 0 is sharp


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
