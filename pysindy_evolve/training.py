"""Checks of the data that terms are grown on, with errors that scikit-learn's checks accept."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from scipy.sparse import issparse

from .checks import SIZES, refuse

MIN_SAMPLES = 10  # fewer rows cannot distinguish two terms from one


def finite(call: str, parameter: str, array: Any) -> None:
    """Raise unless every value is a finite real number."""
    values = np.asarray(array)
    if np.iscomplexobj(values):
        raise ValueError(
            f"{call}({parameter}=...) must hold real numbers; got type {values.dtype}: "
            "Complex data not supported. Pass real and imaginary parts as two columns."
        )
    if values.dtype.kind not in "biuf":
        raise TypeError(
            f"{call}({parameter}=...) must hold real numbers; got type {values.dtype}. "
            "Convert it to float."
        )
    with np.errstate(all="ignore"):
        if np.isfinite(values.sum(dtype=float)):
            return  # one pass and no copy: a sum is finite only if its parts are
    bad = ~np.isfinite(values)
    if bad.any():
        got = f"{values[bad].flat[0]} at sample {int(np.argwhere(bad)[0][0])}"
        advice = "Drop or interpolate such samples."
        refuse(call, parameter, "finite, neither NaN nor inf", got, advice)


def numbers(call: str, parameter: str, array: Any) -> np.ndarray:
    """Return an array-like as a dense array of finite floats, without a copy if possible."""
    if issparse(array):
        raise TypeError(
            f"{call}({parameter}=...) must be dense; got a sparse matrix. Call its .toarray()."
        )
    values = np.asarray(array)
    if values.dtype.kind == "O":
        try:
            values = values.astype(float)
        except (TypeError, ValueError) as error:
            raise TypeError(
                f"{call}({parameter}=...) must hold real numbers; got {error}. Convert it to float."
            ) from error
    finite(call, parameter, values)
    return values.astype(float, copy=False)


def differentiated(y: np.ndarray) -> slice:
    """Return the rows between those at the ends that are NaN throughout.

    PySINDy's finite differences leave them so where `drop_endpoints` is set, and its optimizers
    drop them.
    """
    known = ~np.isnan(y).all(axis=1)
    if known.all() or not known.any():
        return slice(None)
    rows = np.flatnonzero(known)
    return slice(int(rows[0]), int(rows[-1]) + 1)


def with_target(x: Any, y: Any) -> tuple[Any, Any]:
    """Leave out the rows at which y is NaN throughout, as the optimizers of PySINDy do."""
    targets = np.asarray(y)
    if targets.dtype.kind != "f" or targets.size == 0:
        return x, y
    known = ~np.isnan(targets).reshape(len(targets), -1).all(axis=1)
    if known.all() or not known.any() or len(x) != len(known):
        return x, y
    return np.asarray(x)[known], targets[known]


@contextmanager
def house_form(call: str) -> Iterator[None]:
    """Give scikit-learn's errors about arrays the form of all errors, without the values."""
    try:
        yield
    except (TypeError, ValueError) as error:
        told = str(error).split("\n", 1)[0].removesuffix(":").removesuffix(".")
        raise type(error)(
            f"{call} must be finite numbers, X of shape (n_samples, n_terms) and y as long; got "
            f"what scikit-learn refuses: {told}. Give one row per sample. Reshape your data with "
            "X.reshape(-1, 1) if it has one column."
        ) from None


def same_samples(repeated: np.ndarray | None) -> None:
    """Raise if PySINDy made constant inputs of a u that is shorter or longer than x."""
    if repeated is not None:
        n_samples, n_values = repeated.shape
        got = f"{n_values} samples, x has {n_samples}"
        refuse("SINDy.fit", "u", "as long as x", got, "Cut both to the same samples.")


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

    Raises
    ------
    ValueError
        If y is None or zero, lengths disagree, there are too few samples, a column of x never
        varies, or a value is not finite or of extreme size.
    TypeError
        If something is not made of real numbers.
    """
    if y is None:
        raise ValueError(
            "EvolvingLibrary.fit(y=...) must be x_dot, which ps.SINDy lets the library see; got "
            "None. Use the library by itself in ps.SINDy: inside a ConcatLibrary, TensoredLibrary "
            "or GeneralizedLibrary x_dot cannot reach it, so pass the other library as "
            "EvolvingLibrary(base_library=...) instead; outside of ps.SINDy, pass y."
        )
    trajectories = [numbers("EvolvingLibrary.fit", "x", xi) for xi in x]
    given = list(y) if isinstance(y, list | tuple) and y and np.ndim(y[0]) > 0 else [y]
    targets = [numbers("EvolvingLibrary.fit", "y", yi) for yi in given]
    for trajectory in trajectories:
        _two_dimensional(trajectory)
    lengths, of_targets = [len(xi) for xi in trajectories], [len(yi) for yi in targets]
    if lengths != of_targets:
        raise ValueError(
            f"EvolvingLibrary.fit(y=...) must have as many samples as x; got {of_targets} for "
            f"{lengths}. Pass x_dot at the samples of x, for each trajectory."
        )
    columns = _joined(trajectories)
    joined = _joined([yi[:, None] if yi.ndim == 1 else yi for yi in targets])
    _informative(columns, joined)
    _computable(columns, "x")
    _computable(joined, "y")
    return columns, joined


def _joined(parts: Sequence[np.ndarray]) -> np.ndarray:
    """Join trajectories; a single one is not copied, as it may fill most of the memory."""
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
    """Raise if powers of the values would leave the range of floating-point numbers."""
    size = max(values.max(initial=0.0), -values.min(initial=0.0))
    if size > 0.0 and not SIZES[0] <= size <= SIZES[1]:
        raise ValueError(
            f"EvolvingLibrary.fit({name}=...) must have sizes between {SIZES[0]:.0e} and "
            f"{SIZES[1]:.0e}; got {size:.3g}. Change its unit."
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
