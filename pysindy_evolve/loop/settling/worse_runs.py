"""Effects with which a model is further from the records that it was fitted to than without them.

What explains a derivative within the range of a record may drive a run out of it, where nothing was
measured, and on to infinity. Such a model simulates nothing, though it predicts every derivative.
A machine that is unstable itself, and was held by a controller, has such a model too: its
deviations grow along the record itself, so that the noise in its first state drives any run away.
About such a machine the noise of the sensors is in the inputs, and what remembers an input seems to
explain it. The final fit shows that it does not. Where the runs come closer to a record, though,
the derivative may be further: noise has bent its fit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...equations import Equations
from ...hidden_states.memory_equations import as_acting
from ...signals import Record
from ..evidence.findings import Finding, SensorFinding, is_needed
from ..fitting.past import derivative_residual
from ..fitting.residual import MAX_GROWTH, jacobian, respond
from ..fitting.runs import LOST_NRMSE, simulation_errors
from ..given.rows import scale_of
from ..given.segments import segments

CLOSE_NRMSE = 20.0  # percent NRMSE: a run that misses no more follows its record all along
FOLLOWING_NRMSE = 50.0  # percent NRMSE: a run that misses no more follows its record
FAR_AWAY_NRMSE = 1e5  # percent NRMSE: a run that only drifts does not miss by so much
N_GROWTH_ROWS = 64  # of a record, at which it is seen how deviations have grown


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
        The last that changes an equation, and may go by itself; None where nothing runs.
    """
    free = [
        one
        for one in findings
        if not isinstance(one, SensorFinding)  # which changes no equation
        and not is_needed(one, findings)
    ]
    if not free or declared.n_algebraic:
        return None
    models = declared, corrected
    return free[-1] if runs_away(*models, records) or is_further(*models, records) else None


def runs_away(declared: Equations, corrected: Equations, records: Sequence[Record]) -> bool:
    """Tell whether the model runs away with the effects and not without them.

    It does not if deviations grow along a record that no run followed closely. A run that followed
    its record without the effects, and is lost with them, runs away.
    """
    for record in records:
        after = simulation_errors(corrected, [record]).max()
        if after <= LOST_NRMSE:  # that of the declared model may be wild, and take long
            continue
        before = simulation_errors(declared, [record]).max()
        if before < CLOSE_NRMSE:  # the machine itself is stable then
            return True
        # With the effects it is lost, or it is far away only now.
        if before < FOLLOWING_NRMSE or before < FAR_AWAY_NRMSE <= after:
            return not _is_unstable(corrected, record)
    return False


def _is_unstable(equations: Equations, record: Record) -> bool:
    """Tell whether deviations grow along a record by so much that no run can follow it."""
    equations, record = as_acting(equations, record)
    whole = segments([record], (), 1, max_rows=None)
    slopes = jacobian(equations, whole.z, whole.state_scale)
    nothing = np.zeros((*slopes.shape[:3], 0))
    keep = max(1, slopes.shape[1] // N_GROWTH_ROWS)
    grown, _ = respond(slopes, nothing, whole.dt, whole.state_scale, keep)
    return bool(np.max(np.abs(grown)) > MAX_GROWTH)


def is_further(declared: Equations, corrected: Equations, records: Sequence[Record]) -> bool:
    """Tell whether derivatives are further with the effects, and no run over a record is closer."""
    if not _left(corrected, records) > _left(declared, records):  # nor where one has no value
        return False
    return not any(_runs_closer(declared, corrected, one) for one in records)


def _runs_closer(declared: Equations, corrected: Equations, record: Record) -> bool:
    """Tell whether a run comes closer to a record, which one that is lost does not."""
    before, after = (simulation_errors(e, [record]).max() for e in (declared, corrected))
    return bool(after < min(before, LOST_NRMSE))


def _left(equations: Equations, records: Sequence[Record]) -> float:
    """Return the mean square that a model leaves of the derivatives, in their variances."""
    errors = np.concatenate([derivative_residual(equations, record) for record in records])
    scale = scale_of([record.x_dot for record in records])
    return float(np.nanmean((errors / scale) ** 2))
