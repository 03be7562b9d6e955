"""Where held-out data goes beyond what the model was fitted to, and the model errs there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...export import format_number
from ..given.rows import variables_of
from .residuals import percent_left
from .units import percent

if TYPE_CHECKING:
    from .report import LoopReport

__all__ = ["beyond"]

BEYOND = 0.1  # of a variable's range in the training data
MISSED = 10.0  # percent of the standard deviation, that the derivative must err at least, also
# averaged and without rows at rest, where the sign of a speed is a coin toss ...
TIMES = 3.0  # ... and times what it errs on the training data


def beyond(report: LoopReport) -> list[str]:
    """Say so where the model errs far more on held-out data, and that data goes further.

    Parameters
    ----------
    report : LoopReport
        What the loop found.

    Returns
    -------
    list of str
        One sentence or none.
    """
    model = report.after.model
    if model.n_algebraic:
        return []
    fitted, judged = percent_left(model, report.train), percent_left(model, report.test)
    errs = (judged > MISSED) & (report.after.derivative_error > MISSED)
    times = np.where(errs, judged / np.maximum(fitted, 1e-9), 0.0)
    times = np.nan_to_num(times)  # a derivative that hardly varied while training has no share
    worst = int(np.argmax(times))
    wider = _wider(report, (*model.states, *model.inputs)) if times[worst] > TIMES else []
    if not wider:
        return []
    there, here = percent(judged[worst]), percent(fitted[worst])
    return [
        f"The held-out data goes where no training data was ({', '.join(wider)}), and the model "
        f"errs there: d{model.states[worst]}/dt by {there}, by {here} in the training data. "
        "Nothing was learned of that range: fit records that cover it."
    ]


def _wider(report: LoopReport, names: Sequence[str]) -> list[str]:
    """Return the variables of which the held-out data has values that no training data has."""
    trained, held = (
        np.concatenate([variables_of(record)[:, :-1] for record in records])
        for records in (report.train, report.test)
    )
    said = []
    for name, known, new in zip(names, trained.T, held.T, strict=False):
        (low, high), (least, most) = ((v.min(), v.max()) for v in (known, new))
        if max(low - least, most - high) > BEYOND * (high - low):
            ranges = " to ".join(map(format_number, (least, most)))
            before = " to ".join(map(format_number, (low, high)))
            said.append(f"{name} from {ranges}, trained on {before}")
    return said
