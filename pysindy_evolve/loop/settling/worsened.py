"""Effects with which a model is further from the records that it was fitted to than without them.

In a closed loop about a machine that is unstable, the noise of the sensors is in the inputs, and
what remembers an input seems to explain it. The final fit shows that it does not. Where the runs
come closer to a record, though, the derivative may be further: noise has bent its fit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...equations import Equations
from ...signals import Record
from ..evidence.findings import Finding
from ..fitting.past import derivative_residual
from ..fitting.runs import LOST_NRMSE, simulation_errors
from ..given.rows import scale_of
from .runaway import last_free

__all__ = ["last_worsened"]


def last_worsened(
    findings: Sequence[Finding],
    declared: Equations,
    corrected: Equations,
    records: Sequence[Record],
) -> Finding | None:
    """Return the last effect, if the model is further from its own records with the effects.

    Parameters
    ----------
    findings : sequence of Finding
        What was found, in this order.
    declared : Equations
        The model at the start, fitted.
    corrected : Equations
        The model with all that was found, fitted.
    records : sequence of Record
        Training records.

    Returns
    -------
    Finding or None
        None where the derivative is closer with the effects, or the run over any record is.
    """
    last = last_free(findings, declared)
    if last is None:
        return None
    if not _left(corrected, records) > _left(declared, records):  # nor where one has no value
        return None
    return None if any(_runs_closer(declared, corrected, one) for one in records) else last


def _runs_closer(declared: Equations, corrected: Equations, record: Record) -> bool:
    """Tell whether a run comes closer to a record, which one that is lost does not."""
    before, after = (simulation_errors(e, [record]).max() for e in (declared, corrected))
    return bool(after < min(before, LOST_NRMSE))


def _left(equations: Equations, records: Sequence[Record]) -> float:
    """Return the mean square that a model leaves of the derivatives, in their variances."""
    errors = np.concatenate([derivative_residual(equations, record) for record in records])
    scale = scale_of([record.x_dot for record in records])
    return float(np.nanmean((errors / scale) ** 2))
