"""Hysteresis, and friction whose sign is rounded off.

Hysteresis is a friction whose sign changes before or after the velocity does, sgn(v + c x) or
sgn(v + c a), sharp or rounded off. A position may have an arbitrary zero, so it counts from the
middle of the stroke. Bouc and Wen's hysteresis depends on the path only: a friction, see
boucwen.py, or a spring, see wen_spring.py.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...hidden_states.boucwen import yielding
from ...hidden_states.wen_spring import springing
from ...operators import BUILTIN
from ...terms import Sum, add, call, constant, mul, sub, variable
from ..given.ranges import Ranges
from .candidate import Candidate, CandidateMaker, Shape
from .names import (
    COULOMB_FRICTION,
    CUBIC_STIFFNESS,
    DEAD_ZONE,
    GRAVITY,
    HARMONIC,
    HYSTERESIS,
    NONLINEAR_DAMPING,
    POSITION_FRICTION,
    QUADRATIC_DRAG,
    QUADRATIC_STIFFNESS,
    QUINTIC_STIFFNESS,
    STRIBECK_FRICTION,
)

PLAINER = (COULOMB_FRICTION,)  # may look like hysteresis where the velocity is noisy
# In an equation of motion position and velocity are noisy states, and any friction or spring may
# look like Bouc and Wen's hysteresis.
SIMPLER = (
    *PLAINER,
    STRIBECK_FRICTION,
    POSITION_FRICTION,
    QUADRATIC_DRAG,
    NONLINEAR_DAMPING,
    QUADRATIC_STIFFNESS,
    CUBIC_STIFFNESS,
    QUINTIC_STIFFNESS,
    DEAD_ZONE,
    GRAVITY,
    HARMONIC,
)
SLANTS = (0.05, 0.2, 0.8)  # c in sgn(v + c x), in units of the size of v over that of x
WIDTHS = (0.04, 0.1, 0.25)  # of a rounded sign, as shares of the size of v
LENGTHS = (0.03, 0.1, 0.3)  # over which a friction builds up, in halves of the stroke
PATH_NUMBERS = ("length", "rate of unloading")
SPRING_LENGTHS = (0.1, 0.3, 1.0)  # over which a spring forgets, in halves of the stroke
SPRING_NUMBERS = ("length", "loss")
EVEN_LOSS = 0.5  # loss of a spring that grows neither stiffer nor softer on the way out
UNLOADINGS = (0.25, 1.0, 4.0)  # Dahl's friction in the middle
MIN_SIGN_CHANGES = 8  # sign changes of a hysteresis in a record, at least: in fewer no memory shows
CENTERED = 0.1  # distance of zero from the middle, over half the stroke, that is neglected


def rounded_sign(v: Sum, width: float) -> Sum:
    """Return tanh(v / width)."""
    return call(BUILTIN["tanh"], mul(constant(1.0 / width), v))


def _slanted(v: Sum, x: Sum, slant: float, middle: float) -> Sum:
    """Return v + slant (x - middle)."""
    return add(v, mul(constant(slant), sub(x, constant(middle))))


def rounded(effect: CandidateMaker, v: int, ranges: Ranges) -> Iterator[Candidate]:
    """Yield frictions whose sign is rounded off."""
    for width in WIDTHS:
        build = partial(rounded_sign, variable(v))
        smooth = Shape(
            (width * float(ranges.largest[v]),), (build,), meanings=("width of the transition",)
        )
        yield effect(COULOMB_FRICTION, shape=smooth)


@dataclass(frozen=True)
class Yield:
    """Builds the sign of v + c (x - m) from |c|, its width if any, and |m| if any.

    Attributes
    ----------
    v, x : Sum
        Velocity, and what leads or follows it.
    sign, side : float
        Signs of c and of m.
    is_sharp : bool
        Whether there is no width.
    """

    v: Sum
    x: Sum
    sign: float
    side: float
    is_sharp: bool

    def __call__(self, slant: float, *others: float) -> Sum:
        """Return the term."""
        middle = self.side * (others[-1] if self.side else 0.0)
        inside = _slanted(self.v, self.x, self.sign * slant, middle)
        return call(BUILTIN["sgn"], inside) if self.is_sharp else rounded_sign(inside, others[0])


def yields(
    effect: CandidateMaker, x: int, v: int, ranges: Ranges, middle: float
) -> Iterator[Candidate]:
    """Yield hysteretic frictions of a velocity, led or followed by another variable."""
    speed, stroke = float(ranges.largest[v]), float(ranges.largest[x]) - abs(middle)
    side = float(np.sign(middle)) if abs(middle) > CENTERED * stroke else 0.0
    places = {"distance of the middle from zero": abs(middle)} if side else {}
    for share in (None, *WIDTHS):
        width = {} if share is None else {"width of the transition": share * speed}
        for sign in (1.0, -1.0):
            build = Yield(variable(v), variable(x), sign, side, share is None)
            for slant in SLANTS:
                numbers = {"slant": slant * speed / stroke, **width, **places}
                shape = Shape(tuple(numbers.values()), (build,), meanings=tuple(numbers))
                yield effect(HYSTERESIS, shape=shape, must_beat=PLAINER)


def remembering(
    effect: CandidateMaker,
    x: int,
    v: int,
    stroke: float,
    unloadings: Sequence[float] = UNLOADINGS,
    must_beat: tuple[str, ...] = PLAINER,
    spring_lengths: Sequence[float] = SPRING_LENGTHS,
) -> Iterator[Candidate]:
    """Yield frictions and springs of Bouc and Wen, which remember the path of a position.

    `stroke` is half the range of the position.
    """
    friction = partial(yielding, variable(x), variable(v))
    for length in LENGTHS:
        for unloading in unloadings:
            shape = Shape((length * stroke, unloading), (friction,), meanings=PATH_NUMBERS)
            yield effect(HYSTERESIS, shape=shape, must_beat=must_beat)
    spring = partial(springing, variable(x), variable(v))
    for length in spring_lengths:
        shape = Shape((length * stroke, EVEN_LOSS), (spring,), meanings=SPRING_NUMBERS)
        yield effect(HYSTERESIS, shape=shape, must_beat=must_beat)


def remembered_ways(
    state: int, position: int, x: np.ndarray, *, springs: bool = True
) -> list[Candidate]:
    """Return the hystereses of Bouc and Wen that an equation of motion may lack.

    Parameters
    ----------
    state : int
        The velocity, whose equation it is.
    position : int
        The state that remembers its path.
    x : ndarray of shape (n_samples,)
        The position in time order. Where it hardly ever turns there is nothing to remember.
    springs : bool
        Whether springs are among them.

    Returns
    -------
    list of Candidate
        Dahl's frictions, and springs; all their numbers are tuned from there.
    """
    stroke, dahl = 0.5 * float(np.ptp(x)), UNLOADINGS[1:2]
    effect, lengths = CandidateMaker(state), SPRING_LENGTHS if springs else ()
    ways = remembering(effect, position, state, stroke, dahl, SIMPLER, lengths)
    return [way for way in ways if _turns(way, position, x) >= MIN_SIGN_CHANGES]


def _turns(way: Candidate, position: int, x: np.ndarray) -> int:
    """Return how often a hysteresis changes its sign along a path."""
    rows = np.zeros((len(x), max(position, way.state) + 1))
    rows[:, position] = x
    w = way.terms[0].evaluate(rows)
    return int(np.sum(w[1:] * w[:-1] < 0.0))
