"""Terms of the model that ripple with a position: times a sine and a cosine of it.

The torque of a motor goes up and down from pole to pole, the more so the more current it draws; a
guide rubs more where it is worn, and a gear where it is not round.
"""

from __future__ import annotations

import numpy as np

from .candidate import Candidate, CandidateMaker, Shape
from .modulation import ActingTerm, rippling
from .names import POSITION_FRICTION, RIPPLE
from .periodic import PERIODS_IN_SPACE, SAMPLES_PER_BIN, WAVE_NUMBER, waves_times


def rippled_candidates(
    state: int,
    position: int,
    residual: np.ndarray,
    term: ActingTerm,
    q: np.ndarray,
    noise: float = 0.0,
) -> list[Candidate]:
    """Return a term times sine and cosine of a position, at the wave number that explains most.

    Parameters
    ----------
    state, position : int
        Velocity, in whose equation the term is, and its position.
    residual : ndarray of shape (n_samples,)
        What the model leaves.
    term : ActingTerm
        The term.
    q : ndarray of shape (n_samples,)
        Position.
    noise : float
        Standard deviation of the noise of the sensor of the position.

    Returns
    -------
    list of Candidate
        One or none. None for a term of the position alone: that would be a spring of another shape.
    """
    part, n_bins = term.part, len(q) // SAMPLES_PER_BIN
    if part.variables <= {position} or n_bins < 2 * PERIODS_IN_SPACE or np.ptp(q) == 0.0:
        return []
    finest = 1.0 / (2 * np.pi * noise) if noise > 0.0 else np.inf
    name = POSITION_FRICTION if part.variables == {state} else RIPPLE
    return [
        CandidateMaker(state)(
            name,
            shape=Shape(
                (2 * np.pi * found,),
                waves_times(part, position),
                0.5 / (found * float(np.ptp(q))),
                (WAVE_NUMBER,),
                term.branch,
            ),
            parents=(part,),
            never_paired=True,
        )
        for found in rippling(residual, term.values, q, n_bins, PERIODS_IN_SPACE, finest)
    ]
