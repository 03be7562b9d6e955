"""Effects with which a model runs away from the records that it was fitted to.

What explains a derivative within the range of a record may drive a run out of it, where nothing was
measured, and on to infinity. Such a model simulates nothing, though it predicts every derivative.
A machine that is unstable itself, and was held by a controller, has such a model too: its
deviations grow along the record itself, so that the noise in its first state drives any run away.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...equations import Equations
from ...hidden_states.memory_equations import as_acting
from ...signals import Record
from ..evidence.findings import Finding, SensorFinding, excluding, is_needed
from ..fitting.residual import MAX_GROWTH, jacobian, respond
from ..fitting.runs import LOST_NRMSE, simulation_errors
from ..given.segments import segments

__all__ = ["last_free", "last_runaway"]

CLOSE_NRMSE = 20.0  # percent NRMSE: a run that misses no more follows its record all along
FOLLOWING_NRMSE = 50.0  # percent NRMSE: a run that misses no more follows its record
FAR_AWAY_NRMSE = 1e5  # percent NRMSE: a run that only drifts does not miss by so much
N_GROWTH_ROWS = 64  # of a record, at which it is seen how deviations have grown


def last_runaway(
    findings: Sequence[Finding],
    declared: Equations,
    corrected: Equations,
    records: Sequence[Record],
) -> Finding | None:
    """Return the last effect, if the model runs away with the effects and not without them.

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
        None if the runs hold, or if deviations grow along a record that no run followed closely. A
        run that followed its record without the effects, and is lost with them, does not hold.
    """
    last = last_free(findings, declared)
    if last is None:
        return None
    for record in records:
        after = simulation_errors(corrected, [record]).max()
        if after <= LOST_NRMSE:  # that of the declared model may be wild, and take long
            continue
        before = simulation_errors(declared, [record]).max()
        if before < CLOSE_NRMSE:  # the machine itself is stable then
            return last
        # With the effects it is lost, or it is far away only now.
        if before < FOLLOWING_NRMSE or before < FAR_AWAY_NRMSE <= after:
            return None if _is_unstable(corrected, record) else last
    return None


def last_free(findings: Sequence[Finding], declared: Equations) -> Finding | None:
    """Return the last that changes an equation, and may go by itself; None where nothing runs."""
    if declared.n_algebraic:
        return None
    free = (
        one
        for one in reversed(findings)
        if not isinstance(one, SensorFinding)  # which changes no equation
        and not is_needed(one, excluding(findings, one))
    )
    return next(free, None)


def _is_unstable(equations: Equations, record: Record) -> bool:
    """Tell whether deviations grow along a record by so much that no run can follow it."""
    equations, record = as_acting(equations, record)
    whole = segments([record], (), 1, max_rows=None)
    slopes = jacobian(equations, whole.z, whole.state_scale)
    nothing = np.zeros((*slopes.shape[:3], 0))
    keep = max(1, slopes.shape[1] // N_GROWTH_ROWS)
    grown, _ = respond(slopes, nothing, whole.dt, whole.state_scale, keep)
    return bool(np.max(np.abs(grown)) > MAX_GROWTH)
