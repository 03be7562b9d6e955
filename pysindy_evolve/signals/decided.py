"""Rows on which the low-pass leaves the direction of motion certain."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from .. import checks
from .record import Record

# Share of the rows; if fewer are decided, as for a body that keeps turning, all count.
MIN_DECIDED_SHARE = 0.5


def is_decided(record: Record) -> NDArray[np.bool_]:
    """Tell on which rows no velocity changes its sign within reach of the low-pass.

    Where a body turns, the low-pass smears a jump such as that of dry friction, while the sign of
    the filtered velocity still jumps. On such rows a fit with sgn(v) picks up other terms that jump
    there; without these rows it finds the friction alone.

    Parameters
    ----------
    record : Record
        From `prepare`, with velocities among its states.

    Returns
    -------
    ndarray of bool of shape (n_samples,)
        All true where nothing was filtered, where no state is a velocity, or where less than half
        of the rows would be left.

    Raises
    ------
    TypeError
        If `record` is not a Record.

    Examples
    --------
    >>> import numpy as np
    >>> from pysindy_evolve.signals import prepare
    >>> t = np.arange(0.0, 10.0, 0.01)
    >>> record = prepare(t, np.sin(t), cutoff=5.0)
    >>> decided = is_decided(record)
    >>> bool(np.all(np.abs(record.x[~decided, 1]) < 0.25)), bool(decided.mean() > 0.8)
    (True, True)
    """
    if not isinstance(record, Record):
        advice = "Give what prepare returned."
        checks.refuse_type("is_decided", "record", "a Record", record, advice)
    everything, made = np.ones(len(record), dtype=bool), record.preparation
    if made is None or made.cutoff is None or made.order < 2:
        return everything
    velocities = record.x[:, 1 :: made.order]
    turns = np.zeros(len(record), dtype=bool)
    turns[1:] = np.any(np.diff(np.sign(velocities), axis=0) != 0.0, axis=1)
    reach = int(np.ceil(1.0 / (made.cutoff * record.dt)))
    decided = ~maximum_filter1d(turns, 2 * reach + 1, mode="constant")
    return decided if decided.mean() >= MIN_DECIDED_SHARE else everything
