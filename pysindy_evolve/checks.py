"""Checks of arguments, and the form of all error messages.

Each check takes the names of the call and of the parameter, then the value, and returns the value
converted. `refuse` raises an error in the form that all errors of the package have.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from numbers import Integral, Real
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

TINY = 1e-300  # least value of a denominator

# Beyond these sizes powers of values and frequencies leave the range of floating point.
LARGEST = 1e50
STEP_LIMITS = (1e-20, 1e20)
SIZES = (1e-30, 1e30)  # narrower, for values that enter terms: ratios of powers, raised again


def refuse(call: str, parameter: str, constraint: str, got: str, advice: str) -> NoReturn:
    """Raise the ValueError of the house form."""
    raise ValueError(f"{call}({parameter}=...) must be {constraint}; got {got}. {advice}")


def refuse_type(call: str, parameter: str, constraint: str, value: Any, advice: str) -> NoReturn:
    """Raise the TypeError of the house form."""
    got = type(value).__name__
    raise TypeError(f"{call}({parameter}=...) must be {constraint}; got {got}. {advice}")


def numbers(call: str, parameter: str, values: ArrayLike, most: float = LARGEST) -> Array:
    """Return real, finite float64 values of any shape, without a copy if possible."""
    advice = "Give real numbers, one row per sample."
    try:
        array = np.asarray(values)
    except ValueError:  # rows of different lengths
        refuse(call, parameter, "a rectangular array", "rows of different lengths", advice)
    if array.dtype == object or array.dtype.kind not in "biuf":
        got = f"{type(values).__name__} of dtype {array.dtype}"
        raise TypeError(f"{call}({parameter}=...) must be real numbers; got {got}. {advice}")
    array = np.asarray(array, dtype=np.float64)
    finite(call, parameter, array)
    largest = float(np.abs(array).max(initial=0.0))
    if largest > most:
        advice = "Rescale the units."
        refuse(call, parameter, f"at most {most:g} in size", f"{largest:g}", advice)
    return array


def finite(call: str, parameter: str, array: NDArray[Any]) -> None:
    """Raise unless every value is finite; the error names the first place that is not."""
    bad = ~np.isfinite(array)
    if bad.any():
        where = tuple(int(i) for i in np.argwhere(bad)[0])
        place = f"sample {where[0]}" if len(where) else "the only value"
        place += f", column {where[1]}" if len(where) > 1 else ""
        got = f"{array[where]} at {place} ({int(bad.sum())} in all)"
        refuse(call, parameter, "finite", got, "Drop or fill these samples first.")


def floats(call: str, parameter: str, values: Any) -> Array:
    """Return finite float64 values of any shape, from anything that numpy converts to floats."""
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        refuse_type(call, parameter, "an array of numbers", values, "Convert it to floats.")
    if not np.all(np.isfinite(array)):
        at = np.unravel_index(int(np.argmin(np.isfinite(array))), array.shape)
        got = f"{array[at]} at {tuple(map(int, at))}"
        refuse(call, parameter, "finite", got, "Drop or fill these samples.")
    return array


def columns(call: str, parameter: str, values: ArrayLike, most: float = LARGEST) -> Array:
    """Return a finite float64 array of shape (n_samples, n_columns); 1-D becomes one column."""
    array = numbers(call, parameter, values, most)
    if array.ndim == 1:
        array = array[:, None]
    if array.ndim != 2 or array.shape[1] == 0:
        advice = "Give one row per sample and one column per signal."
        refuse(call, parameter, "1-D or 2-D with columns", f"shape {array.shape}", advice)
    return array


def times(call: str, values: ArrayLike) -> Array:
    """Return finite, strictly increasing sampling times of shape (n_samples,)."""
    t = numbers(call, "t", values)
    if t.ndim == 2 and t.shape[1] == 1:
        t = t[:, 0]
    if t.ndim != 1:
        advice = "Give the time of each sample."
        refuse(call, "t", "1-D", f"shape {t.shape}", advice)
    increasing(call, t)
    steps = np.diff(t)
    low, high = STEP_LIMITS
    if steps.size and not low <= float(steps.mean()) <= high:
        got = f"a mean step of {steps.mean():g}"
        refuse(call, "t", f"in steps of {low:g} to {high:g}", got, "Rescale the time.")
    return t


def increasing(call: str, t: Array) -> None:
    """Raise unless each time is later than the one before."""
    steps = np.diff(t)
    if np.any(steps <= 0):
        at = int(np.argmax(steps <= 0))
        advice = "Sort the record or drop the repeated samples."
        got = f"a step of {steps[at]:g} at sample {at + 1}"
        refuse(call, "t", "strictly increasing", got, advice)


def same_length(call: str, **arrays: Array | None) -> None:
    """Raise unless all arrays given have the same number of samples."""
    shapes = {name: a.shape for name, a in arrays.items() if a is not None}
    lengths = {name: shape[0] for name, shape in shapes.items()}
    if len(set(lengths.values())) > 1:
        first, *rest = lengths
        wrong = next(name for name in rest if lengths[name] != lengths[first])
        got = f"{lengths[wrong]} samples, {first} has {lengths[first]}"
        advice = "Cut both to the same samples."
        if lengths[first] in shapes[wrong][1:]:
            advice = "Transpose it: a row is a sample."
        refuse(call, wrong, f"as long as {first}", got, advice)


def number(call: str, parameter: str, value: Any, constraint: str, ok: Any) -> float:
    """Return a real number for which `ok` holds."""
    advice = f"Choose a value that is {constraint}."
    if isinstance(value, bool) or not isinstance(value, Real):
        refuse_type(call, parameter, f"a number {constraint}", value, advice)
    try:
        converted = float(value)
    except OverflowError:
        converted = np.inf
    if not (np.isfinite(converted) and ok(converted)):
        refuse(call, parameter, constraint, repr(value), advice)
    return converted


def count(
    call: str,
    parameter: str,
    value: Any,
    most: float = np.inf,
    advice: str = "Choose a whole number in this range.",
) -> int:
    """Return an integer of at least 1 and at most `most`."""
    limited = np.isfinite(most)
    constraint = f"an integer from 1 to {most:g}" if limited else "an integer of at least 1"
    if isinstance(value, bool) or not isinstance(value, Integral):
        refuse_type(call, parameter, constraint, value, advice)
    whole = int(value)
    if not 1 <= whole <= most:
        refuse(call, parameter, constraint, repr(value), advice)
    return whole


def integer(call: str, parameter: str, value: Any, least: int, advice: str) -> int:
    """Return an option that is an integer, and not too small."""
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise TypeError(f"{call}({parameter}=...) must be an integer; got {value!r}. {advice}")
    if value < least:
        refuse(call, parameter, f"at least {least}", repr(value), advice)
    return int(value)


def real(
    call: str, parameter: str, value: Any, constraint: str, ok: Callable[[float], bool], advice: str
) -> float:
    """Return an option that is a number for which `ok` holds."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise TypeError(f"{call}({parameter}=...) must be a number; got {value!r}. {advice}")
    if not ok(float(value)):
        refuse(call, parameter, constraint, repr(value), advice)
    return float(value)


def choice(call: str, parameter: str, value: Any, allowed: tuple[str, ...]) -> str:
    """Return one of the allowed words."""
    constraint = "one of " + ", ".join(f'"{word}"' for word in allowed)
    if not isinstance(value, str):
        refuse_type(call, parameter, constraint, value, "Choose one of these words.")
    if value not in allowed:
        refuse(call, parameter, constraint, repr(value), "Choose one of these words.")
    return value


def cutoff(call: str, value: Any, dt: float, parameter: str = "cutoff") -> float:
    """Return a cutoff in (0, fs / 2), cycles per unit of t."""
    nyquist = 0.5 / dt
    constraint = f"in (0, {nyquist:g}), below half the sampling rate"
    return number(call, parameter, value, constraint, lambda v: 0 < v < nyquist)


def step(call: str, value: Any) -> float:
    """Return a sampling time."""
    low, high = STEP_LIMITS
    return number(call, "dt", value, f"in [{low:g}, {high:g}]", lambda v: low <= v <= high)


def feature_names(names: Sequence[str], n_columns: int) -> None:
    """Raise unless there is a name for each column; PySINDy itself accepts any number of names."""
    if len(names) != n_columns:
        raise ValueError(
            "SINDy.fit(feature_names=...) must name each state and each input; got "
            f"{len(names)} for {n_columns} columns. Fit with the names of all states, then of all "
            "inputs."
        )
