"""Motion that a low-pass leaves out of a record."""

from __future__ import annotations

import numpy as np

from ..warn import warn
from .clipping import bridged
from .preparation import Preparation
from .record import Record
from .sampling import mean_step

# Share of the variance of a column, its noise apart, whose loss is that of most of the motion.
MOST_OF_MOTION = 0.5


def warn_of_lost_motion(plan: Preparation, record: Record) -> None:
    """Warn if a low-pass leaves out more of a column than it keeps, its noise apart.

    Parameters
    ----------
    plan : Preparation
        The raw positions and their low-pass.
    record : Record
        What came of it.

    Warns
    -----
    UserWarning
        With the columns.
    """
    if plan.cutoff is None:
        return
    y = bridged(plan.y, plan.limits, plan.dt, plan.cutoff, plan.order)
    rows = np.searchsorted(plan.t, record.t - 0.5 * mean_step(plan.t))
    kept, measured, noise = record.x[:, :: plan.order], y[rows], plan.noise**2
    lost = np.mean((measured - kept) ** 2, axis=0) - noise
    motion = np.var(measured, axis=0) - noise
    columns = np.flatnonzero((lost > noise) & (lost > MOST_OF_MOTION * motion))
    if len(columns):
        warn(
            f"prepare(cutoff={plan.cutoff:g}) removes most of the motion in column "
            f"{', '.join(map(str, columns))} of y. Raise the cutoff, or leave it out."
        )
