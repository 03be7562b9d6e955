"""Take out of the misses of free runs what the misses before them say.

In a closed loop the input answers what disturbed the output, so that the misses of a free run are a
function of the input even where nothing is missing. What is new in each sample is not: nothing
that came before knows it (prediction errors, Ljung 1999, System Identification, section 13.4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...checks import TINY

__all__ = ["Whitener"]

ORDER = 2  # looks back


@dataclass(frozen=True, eq=False)
class Whitener:
    """A vector autoregression of the misses.

    Attributes
    ----------
    coef : ndarray of shape (ORDER * n_states, n_states)
        What the misses before, the last ones first, say of the next ones.
    scale : ndarray of shape (n_states,)
        Standard deviation of what is new.
    stride : int
        Rows from one look back to the next: a low-pass leaves nothing new in less.
    """

    coef: np.ndarray
    scale: np.ndarray
    stride: int

    @classmethod
    def of(cls, misses: np.ndarray, stride: int) -> Whitener | None:
        """Fit it to misses of shape (n_stretches, n_rows, n_states); None if they are too short.

        In short stretches it looks less far back, and what is new is noise above the cutoff.
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
        """Return what is new in columns of shape (n_stretches, n_rows * n_states, n_columns)."""
        n, _, n_columns = rows.shape
        n_states = len(self.scale)
        apart = np.moveaxis(rows.reshape(n, -1, n_states, n_columns), -1, 1)
        columns = apart.reshape(n * n_columns, -1, n_states)
        now = columns[:, ORDER * self.stride :]
        new = (now - _past(columns, self.stride) @ self.coef) / self.scale
        return np.moveaxis(new.reshape(n, n_columns, -1), 1, -1)


def _past(columns: np.ndarray, stride: int) -> np.ndarray:
    """Return the rows before each one that has enough of them, side by side."""
    n_rows = columns.shape[1]
    lags = [stride * k for k in range(1, ORDER + 1)]
    return np.concatenate([columns[:, lags[-1] - lag : n_rows - lag] for lag in lags], axis=2)
