"""Records whose target is a force, to be explained by the motion."""

from __future__ import annotations

import numpy as np

from .. import checks
from .record import Record


def as_target(record: Record) -> Record:
    """Exchange inputs and motion: the force becomes the target, and the motion its inputs.

    Parameters
    ----------
    record : Record
        Positions and their derivatives, units of x and of x per unit of t, with the forces as
        inputs, as `prepare` makes it: all columns are filtered alike.

    Returns
    -------
    Record
        Its x and x_dot are the forces, shape (n_samples, n_forces). Its inputs are the columns of
        x and, last, the highest derivative of each position.

    Raises
    ------
    ValueError
        If the record has no inputs.

    Notes
    -----
    The model has to declare each column of the result, in this order: the forces as its equations,
    and all inputs, with the acceleration of ``prepare(..., order=2)`` last, whether or not the
    declared force depends on it. The loop looks for missing terms of all of them.

    Examples
    --------
    A damper whose force was measured, and its position:

    >>> import numpy as np
    >>> from pysindy_evolve import DeclaredModel, prepare
    >>> t = np.arange(1000) * 0.01
    >>> record = as_target(prepare(t, np.sin(t), np.cos(t)))
    >>> record.n_states, record.n_inputs
    (1, 3)
    >>> DeclaredModel({"F": "c*v"}, inputs=["x", "v", "a"], algebraic=True).inputs
    ('x', 'v', 'a')
    """
    if record.u is None:
        checks.refuse("as_target", "record", "a record with inputs", "none", "Give forces as u.")
    order = 1 if record.preparation is None else record.preparation.order
    u = np.column_stack([record.x, record.x_dot[:, order - 1 :: order]])
    seen = record.seen
    if seen is not None:  # a force counts only on rows where the whole motion was seen
        seen = np.repeat(np.all(seen, axis=1)[:, None], record.n_inputs, axis=1)
    made = record.preparation
    return Record(t=record.t, x=record.u, x_dot=record.u, u=u, motion=made, seen=seen)
