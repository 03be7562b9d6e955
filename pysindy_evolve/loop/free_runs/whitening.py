"""Remove from the misses of free runs what earlier misses predict.

In a closed loop the input reacts to disturbances of the output, so the misses of a free run depend
on the input even where nothing is missing. The innovations do not: nothing before them predicts
them (prediction errors, Ljung 1999, System Identification, section 13.4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...checks import TINY

ORDER = 2  # number of lags


@dataclass(frozen=True, eq=False)
class Whitener:
    """A vector autoregression of the misses.

    Attributes
    ----------
    coef : ndarray of shape (ORDER * n_states, n_states)
        Coefficients of the lagged misses, the latest lag first.
    scale : ndarray of shape (n_states,)
        Standard deviation of the innovations.
    stride : int
        Rows between lags; within fewer, low-passed misses hold nothing new.
    """

    coef: np.ndarray
    scale: np.ndarray
    stride: int

    @classmethod
    def of(cls, misses: np.ndarray, stride: int) -> Whitener | None:
        """Fit it to misses of shape (n_stretches, n_rows, n_states); None if they are too short.

        In short stretches the stride is shorter, and the innovations are noise above the cutoff.
        """
        stride = min(stride, misses.shape[1] // (2 * ORDER + 1))
        if stride < 1:
            return None
        n_states = misses.shape[2]
        past = _past(misses, stride).reshape(-1, ORDER * n_states)
        now = misses[:, ORDER * stride :].reshape(-1, n_states)
        coef = np.linalg.lstsq(past, now, rcond=1e-8)[0]
        return cls(coef, np.maximum((now - past @ coef).std(axis=0), TINY), stride)

    def __call__(self, rows: np.ndarray) -> np.ndarray:
        """Return the innovations of columns (n_stretches, n_rows * n_states, n_columns)."""
        n, _, n_columns = rows.shape
        n_states = len(self.scale)
        by_state = np.moveaxis(rows.reshape(n, -1, n_states, n_columns), -1, 1)
        columns = by_state.reshape(n * n_columns, -1, n_states)
        now = columns[:, ORDER * self.stride :]
        innovations = (now - _past(columns, self.stride) @ self.coef) / self.scale
        return np.moveaxis(innovations.reshape(n, n_columns, -1), 1, -1)


def _past(columns: np.ndarray, stride: int) -> np.ndarray:
    """Return the lagged rows of each row that has them all, side by side."""
    n_rows = columns.shape[1]
    lags = [stride * k for k in range(1, ORDER + 1)]
    return np.concatenate([columns[:, lags[-1] - lag : n_rows - lag] for lag in lags], axis=2)
