"""Records of a force to be explained by the motion, instead of a motion by the force."""

from __future__ import annotations

import numpy as np

from .. import checks
from .record import Record

__all__ = ["as_target"]


def as_target(record: Record) -> Record:
    """Exchange inputs and motion: what drove the motion becomes what is to be explained by it.

    Parameters
    ----------
    record : Record
        Positions and their derivatives, with the forces as inputs, as `prepare` makes it: all
        columns are filtered alike.

    Returns
    -------
    Record
        Its x and x_dot are the forces, its inputs the columns of x and, last, the highest
        derivative of each position.

    Raises
    ------
    ValueError
        If the record has no inputs.

    Examples
    --------
    >>> import numpy as np
    >>> from pysindy_evolve.signals import prepare
    >>> t = np.arange(1000) * 0.01
    >>> record = as_target(prepare(t, np.sin(t), np.cos(t), order=1))
    >>> record.n_states, record.n_inputs
    (1, 2)
    """
    if record.u is None:
        checks.refuse("as_target", "record", "a record with inputs", "none", "Give forces as u.")
    order = 1 if record.preparation is None else record.preparation.order
    u = np.column_stack([record.x, record.x_dot[:, order - 1 :: order]])
    seen = record.seen
    if seen is not None:  # a force says nothing of a motion that nobody saw
        seen = np.repeat(np.all(seen, axis=1)[:, None], record.n_inputs, axis=1)
    made = record.preparation
    return Record(t=record.t, x=record.u, x_dot=record.u, u=u, motion=made, seen=seen)
