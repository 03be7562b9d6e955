"""Held-out data outside the range of the training data, where the model has large errors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...export import format_number
from ..facts.outcome import Outcome
from ..facts.residuals import percent_left
from ..given.rows import variables_of
from .number_text import percent

RANGE_MARGIN = 0.1  # excess beyond the training range that counts, as a share of that range
# Percent of the standard deviation: least error of the derivative, row by row and averaged over
# windows. The second leaves out rows at rest, where the sign of a speed is random.
LEAST_ERROR = 10.0
ERROR_RATIO = 3.0  # least ratio of the held-out error to the training error


def extrapolation_sentences(outcome: Outcome) -> list[str]:
    """Warn if the model errs far more on held-out data, and these leave the training range.

    Parameters
    ----------
    outcome : Outcome
        What the loop found.

    Returns
    -------
    list of str
        One sentence or none.
    """
    model = outcome.after.model
    if model.n_algebraic:
        return []
    on_train, on_test = percent_left(model, outcome.train), percent_left(model, outcome.test)
    notable = (on_test > LEAST_ERROR) & (outcome.after.derivative_error > LEAST_ERROR)
    ratio = np.where(notable, on_test / np.maximum(on_train, 1e-9), 0.0)
    ratio = np.nan_to_num(ratio)  # NaN where the derivative hardly varied in training
    worst = int(np.argmax(ratio))
    wider = _wider(outcome, (*model.states, *model.inputs)) if ratio[worst] > ERROR_RATIO else []
    if not wider:
        return []
    test_error, train_error = percent(on_test[worst]), percent(on_train[worst])
    return [
        f"The held-out data leaves the range of the training data ({'; '.join(wider)}), and the "
        f"model misses it there: d{model.states[worst]}/dt by {test_error}, against {train_error} "
        "in the training data. It learned nothing about that range: fit records that cover it."
    ]


def _wider(outcome: Outcome, names: Sequence[str]) -> list[str]:
    """Return the variables that leave their training range in the held-out data, with ranges."""
    train_rows, test_rows = (
        np.concatenate([variables_of(record)[:, :-1] for record in records])
        for records in (outcome.train, outcome.test)
    )
    found = []
    for name, old, new in zip(names, train_rows.T, test_rows.T, strict=False):
        (low, high), (least, most) = ((v.min(), v.max()) for v in (old, new))
        if max(low - least, most - high) > RANGE_MARGIN * (high - low):
            new_range = " to ".join(map(format_number, (least, most)))
            old_range = " to ".join(map(format_number, (low, high)))
            found.append(f"{name} from {new_range}, trained on {old_range}")
    return found
