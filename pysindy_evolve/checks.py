"""What must hold of data and parameters, and what to tell the user where it does not."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Integral, Real
from typing import Any

import numpy as np

__all__ = ["finite", "positive_integer", "rate", "training_data"]

MIN_SAMPLES = 16  # fewer rows cannot tell two terms from one


def finite(array: Any, owner: str, name: str) -> None:
    """Raise unless every value is finite."""
    values = np.asarray(array)
    if values.dtype.kind not in "biuf":
        raise TypeError(
            f"{owner}({name}=...) must hold real numbers; got type {values.dtype}. "
            "Convert it to float."
        )
    bad = ~np.isfinite(values)
    if bad.any():
        row = int(np.argwhere(bad)[0][0])
        raise ValueError(
            f"{owner}({name}=...) must be finite; got {values[bad].flat[0]} at sample {row}. "
            "Drop or interpolate such samples."
        )


def positive_integer(value: Any, owner: str, name: str) -> None:
    """Raise unless value is an integer of at least one."""
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise TypeError(
            f"{owner}({name}=...) must be an integer; got {value!r}. Give a whole number."
        )
    if value < 1:
        raise ValueError(
            f"{owner}({name}=...) must be at least 1; got {value!r}. Give a positive number."
        )


def rate(value: Any, owner: str, name: str) -> None:
    """Raise unless value is a probability."""
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{owner}({name}=...) must be a number; got {value!r}. Give a probability.")
    if not 0.0 <= float(value) <= 1.0:
        raise ValueError(
            f"{owner}({name}=...) must be in [0, 1]; got {value!r}. It is a probability."
        )


def training_data(x: Sequence[Any], y: Any) -> tuple[np.ndarray, np.ndarray]:
    """Join trajectories and check that terms can be grown on them.

    Parameters
    ----------
    x : sequence of ndarray of shape (n_samples, n_features)
        States and inputs of each trajectory.
    y : ndarray, or sequence of ndarray, of shape (n_samples,) or (n_samples, n_targets)
        Target of each trajectory; None if it did not reach the library.

    Returns
    -------
    x : ndarray of shape (n, n_features)
    y : ndarray of shape (n, n_targets)
    """
    if y is None:
        raise ValueError(
            "EvolvingLibrary.fit(y=...) must be x_dot, which ps.SINDy lets the library see; got "
            "None. Use the library by itself in ps.SINDy: inside a ConcatLibrary, TensoredLibrary "
            "or GeneralizedLibrary x_dot cannot reach it, so pass the other library as "
            "EvolvingLibrary(base_library=...) instead; outside of ps.SINDy, pass y."
        )
    parts = list(y) if isinstance(y, list | tuple) else [y]
    _same_lengths(x, parts)
    columns = np.concatenate([np.asarray(xi).reshape(-1, np.shape(xi)[-1]) for xi in x])
    targets = np.concatenate([np.asarray(yi).reshape(len(yi), -1) for yi in parts])
    finite(columns, "EvolvingLibrary.fit", "x")
    finite(targets, "EvolvingLibrary.fit", "y")
    columns, targets = columns.astype(float), targets.astype(float)
    _informative(columns, targets)
    return columns, targets


def _same_lengths(x: Sequence[Any], y: Sequence[Any]) -> None:
    lengths, other = [len(xi) for xi in x], [len(yi) for yi in y]
    if lengths != other:
        raise ValueError(
            f"EvolvingLibrary.fit(y=...) must have as many samples as x; got {other} for "
            f"{lengths}. Pass x_dot at the samples of x, for each trajectory."
        )


def _informative(x: np.ndarray, y: np.ndarray) -> None:
    if len(x) < max(MIN_SAMPLES, 2 * x.shape[1]):
        raise ValueError(
            "EvolvingLibrary.fit(x=...) must have more samples than terms, at least "
            f"{max(MIN_SAMPLES, 2 * x.shape[1])}; got {len(x)}. Record longer."
        )
    still = np.flatnonzero(np.ptp(x, axis=0) == 0.0)
    if len(still):
        raise ValueError(
            f"EvolvingLibrary.fit(x=...) must have columns that vary; got a constant column "
            f"{still[0]}. Drop it: the library has a constant term of its own."
        )
    zero = np.flatnonzero(~y.any(axis=0))
    if len(zero):
        raise ValueError(
            f"EvolvingLibrary.fit(y=...) must not be zero; got zeros in column {zero[0]}. "
            "Leave out the state whose derivative is zero."
        )
