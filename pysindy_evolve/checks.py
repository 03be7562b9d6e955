"""What must hold of data and parameters, and what to tell the user where it does not."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Integral, Real
from typing import Any

import numpy as np
from pysindy.feature_library.base import BaseFeatureLibrary
from scipy.sparse import issparse

__all__ = [
    "feature_names",
    "finite",
    "numbers",
    "positive_integer",
    "rate",
    "same_samples",
    "training_data",
]

HUGE = 1e30  # its tenth power can still be computed
MIN_SAMPLES = 10  # fewer rows cannot tell two terms from one


def finite(array: Any, owner: str, name: str) -> None:
    """Raise unless every value is a finite real number."""
    values = np.asarray(array)
    if np.iscomplexobj(values):
        raise ValueError(
            f"{owner}({name}=...) must hold real numbers; got type {values.dtype}: "
            "Complex data not supported. Pass real and imaginary parts as two columns."
        )
    if values.dtype.kind not in "biuf":
        raise TypeError(
            f"{owner}({name}=...) must hold real numbers; got type {values.dtype}. "
            "Convert it to float."
        )
    with np.errstate(all="ignore"):
        if np.isfinite(values.sum(dtype=float)):
            return  # one pass and no copy: a sum is finite only if its parts are
    bad = ~np.isfinite(values)
    if bad.any():
        row = int(np.argwhere(bad)[0][0])
        raise ValueError(
            f"{owner}({name}=...) must be finite, neither NaN nor inf; got {values[bad].flat[0]} "
            f"at sample {row}. Drop or interpolate such samples."
        )


def feature_names(names: Sequence[str], n_columns: int) -> None:
    """Raise unless there is a name for each column; PySINDy itself takes any number of them."""
    if len(names) != n_columns:
        raise ValueError(
            "SINDy.fit(feature_names=...) must name each state and each input; got "
            f"{len(names)} for {n_columns} columns. Fit with the names of all states, then of all "
            "inputs."
        )


def numbers(array: Any, owner: str, name: str) -> np.ndarray:
    """Return an array-like as a dense array of finite floats: itself, if it is one."""
    if issparse(array):
        raise TypeError(
            f"{owner}({name}=...) must be dense; got a sparse matrix. Call its .toarray()."
        )
    values = np.asarray(array)
    if values.dtype.kind == "O":
        try:
            values = values.astype(float)
        except (TypeError, ValueError) as error:
            raise TypeError(
                f"{owner}({name}=...) must hold real numbers; got {error}. Convert it to float."
            ) from error
    finite(values, owner, name)
    return values.astype(float, copy=False)


def same_samples(repeated: np.ndarray | None) -> None:
    """Raise where PySINDy made constant inputs of a u that is shorter or longer than x."""
    if repeated is not None:
        n_samples, n_values = repeated.shape
        raise ValueError(
            f"SINDy.fit(u=...) must be as long as x; got {n_values} samples, x has {n_samples}. "
            "Cut both to the same samples."
        )


def base_library(library: Any, owner: str) -> None:
    """Raise unless it is a library of PySINDy, or None."""
    if library is not None and not isinstance(library, BaseFeatureLibrary):
        raise TypeError(
            f"{owner}(base_library=...) must be a PySINDy feature library; got {library!r}. "
            "Write base_library=ps.PolynomialLibrary(degree=2), or leave it out."
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
            "EvolvingLibrary(base_library=...) instead; outside of ps.SINDy, pass y. "
            "ps.DiscreteSINDy does not hand on what it fits to: library.fit(x[:-1], x[1:]) does."
        )
    trajectories = [numbers(xi, "EvolvingLibrary.fit", "x") for xi in x]
    given = list(y) if isinstance(y, list | tuple) and y and np.ndim(y[0]) > 0 else [y]
    targets = [numbers(yi, "EvolvingLibrary.fit", "y") for yi in given]
    for trajectory in trajectories:
        _two_dimensional(trajectory)
    lengths, other = [len(xi) for xi in trajectories], [len(yi) for yi in targets]
    if lengths != other:
        raise ValueError(
            f"EvolvingLibrary.fit(y=...) must have as many samples as x; got {other} for "
            f"{lengths}. Pass x_dot at the samples of x, for each trajectory."
        )
    columns = _joined(trajectories)
    joined = _joined([yi[:, None] if yi.ndim == 1 else yi for yi in targets])
    _informative(columns, joined)
    _computable(columns, "x")
    _computable(joined, "y")
    return columns, joined


def _joined(parts: Sequence[np.ndarray]) -> np.ndarray:
    """Join trajectories; one alone is not copied, as it may be larger than the memory."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _two_dimensional(x: np.ndarray) -> None:
    if x.ndim != 2:
        raise ValueError(
            f"EvolvingLibrary.fit(x=...) must be 2-D, (n_samples, n_features); got shape {x.shape}."
            " Reshape your data with x.reshape(-1, 1) if it has one column."
        )
    if x.shape[1] == 0:
        raise ValueError(
            f"EvolvingLibrary.fit(x=...) must have columns; got 0 feature(s) (shape={x.shape}) "
            "while a minimum of 1 is required. Pass the states."
        )


def _computable(values: np.ndarray, name: str) -> None:
    """Raise where powers of the values would leave the range of floating-point numbers."""
    size = max(values.max(initial=0.0), -values.min(initial=0.0))
    if size > 0.0 and not 1.0 / HUGE <= size <= HUGE:
        raise ValueError(
            f"EvolvingLibrary.fit({name}=...) must have sizes between {1 / HUGE:.0e} and "
            f"{HUGE:.0e}; got {size:.3g}. Change its unit."
        )


def _informative(x: np.ndarray, y: np.ndarray) -> None:
    if len(x) < max(MIN_SAMPLES, 2 * x.shape[1]):
        raise ValueError(
            "EvolvingLibrary.fit(x=...) must have more samples than terms, at least "
            f"{max(MIN_SAMPLES, 2 * x.shape[1])}; got n_samples = {len(x)}. Record longer."
        )
    still = np.flatnonzero(np.ptp(x, axis=0) == 0.0)
    if len(still):
        raise ValueError(
            f"EvolvingLibrary.fit(x=...) must have columns that vary; got a constant column "
            f"{still[0]}. Drop it: the library has a constant term of its own."
        )
    if not y.any():
        raise ValueError(
            "EvolvingLibrary.fit(y=...) must not be zero; got zeros in all columns. "
            "Record a motion: at rest there is nothing to grow terms from."
        )
