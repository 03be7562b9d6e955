"""From raw positions to a record of states and derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .. import checks
from .clipping import as_limits, beyond, bridged
from .filters import METHODS, MOST_ORDERS
from .lost_motion import warn_of_lost_motion
from .noise import auto_cutoff, sensor_noise
from .preparation import Preparation
from .record import Record, constant_column
from .sampling import mean_step, uniform
from .spectral import Array
from .wrapping import refuse_wrapped
from .zero_order_hold import HALF_SAMPLE, hold

# Samples kept per period of the cutoff: sgn and other kinks of the states stay resolved, and
# the low-pass (over at 1.5 times the cutoff) lets nothing alias.
OVERSAMPLING = 8.0
# Automatic decimation keeps this many rows: fewer save no time worth having.
LEAST_ROWS = 500
# Samples per period of the cutoff below which decimation would alias.
LEAST_OVERSAMPLING = 3.0
# Iterations of cutoff and bridges over gaps, which depend on each other.
N_ITERATIONS = 3
# Periods of the cutoff dropped at each end, where the unknown continuation is felt.
TRIM = 1.5


def prepare(
    t: ArrayLike,
    y: ArrayLike,
    u: ArrayLike | None = None,
    order: int = 2,
    cutoff: float | str | None = "auto",
    decimate: int | str = "auto",
    method: str = "fft",
    limits: str | Sequence[Any] | None = "auto",
    held: bool | Sequence[int] = False,
) -> Record:
    r"""Turn a raw record of positions into states and derivatives, all filtered alike.

    Every column, inputs included, passes the same zero-phase low-pass, so a linear equation
    that holds for the raw signals holds for the prepared ones. The automatic cutoff f_c
    minimizes the expected loss of the highest derivative, noise weighing ten times as much
    as lost signal:

    .. math:: \sum_{f > f_c} (2 \pi f)^{2 m} (P(f) - N)
              + 10 \sum_{f \le f_c} (2 \pi f)^{2 m} N,

    where P is the power spectrum of y, N its floor and m the order.

    Parameters
    ----------
    t : ndarray of shape (n_raw,)
        Time, strictly increasing and uniform. Time stamps off by at most half a sampling time
        are interpolated to a uniform grid by cubic splines (off by 1 %: taken as rounded).
    y : ndarray of shape (n_raw,) or (n_raw, n_columns)
        Measured positions, or first-order states.
    u : ndarray of shape (n_raw,) or (n_raw, n_inputs), optional
        Measured inputs.
    order : int
        States per column of y: 1 for y itself, 2 for position and velocity.
    cutoff : "auto", float or None
        Low-pass, cycles per unit of t, below half the sampling rate. None filters nothing.
    decimate : "auto" or int
        Keep every so many samples; automatically eight or more per period of the cutoff.
    method : {"fft", "savgol", "central"}
        How derivatives are taken: spectral, Savitzky-Golay or central differences.
    limits : "auto", None or pair of float or of ndarray of shape (n_columns,)
        Lowest and highest value that the sensors can show, units of y. At a limit the true value
        may be anywhere beyond it: such rows are bridged before the filter, and marked as not
        `seen`. "auto" takes extremes at which fine readings heap; None means no limits.
    held : bool or sequence of int
        Whether the inputs, or which of them, keep the value recorded at a sample until the next one
        (zero-order hold), as those of a digital controller do. By default they are taken as smooth
        between the samples; the loop may then find half a sampling time of delay.

    Returns
    -------
    Record
        Columns of x are y1, its derivatives up to order - 1, y2, ...; `preparation` says how
        it was made. One and a half periods of the cutoff (at most a sixteenth of
        the record) are dropped at each end.

    Raises
    ------
    ValueError
        If a value is not finite, lengths differ, time is irregular, a column of y is
        constant or an angle that wraps, samples are too few or a setting is out of range.
    TypeError
        If an argument has the wrong type.

    Warns
    -----
    UserWarning
        If the cutoff that was given removes more of a position than it keeps, noise apart.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(1000) * 0.01
    >>> record = prepare(t, np.sin(2 * t), order=2)
    >>> record.n_states
    2
    >>> bool(np.abs(record.x_dot[:, 1] + 4 * record.x[:, 0]).max() < 0.01)
    True
    """
    record = prepared(t, y, u, order, cutoff, decimate, method, limits, held)
    if cutoff != "auto" and record.preparation is not None:
        warn_of_lost_motion(record.preparation, record)
    return record


def prepared(
    t: ArrayLike,
    y: ArrayLike,
    u: ArrayLike | None = None,
    order: int = 2,
    cutoff: float | str | None = "auto",
    decimate: int | str = "auto",
    method: str = "fft",
    limits: str | Sequence[Any] | None = "auto",
    held: bool | Sequence[int] = False,
) -> Record:
    """Prepare as `prepare` does, without its warning, where no user chose the cutoff."""
    times = checks.times("prepare", t)
    raw_y = checks.columns("prepare", "y", y)
    if np.asarray(y).dtype == bool:
        advice = "Give the measured values themselves, not where they exceed a limit."
        checks.refuse_type("prepare", "y", "measured values, not booleans", y, advice)
    raw_u = None if u is None else checks.columns("prepare", "u", u)
    order = checks.count("prepare", "order", order, MOST_ORDERS)
    method = checks.choice("prepare", "method", method, METHODS)
    checks.same_length("prepare", t=times, y=raw_y, u=raw_u)
    _enough(times.size, order)
    grid, (even_y, even_u) = uniform("prepare", times, raw_y, raw_u)
    constant = constant_column(raw_y)
    if even_y is None or constant is not None:
        got = f"{raw_y[0, constant or 0]:g} in all samples of column {constant}"
        checks.refuse("prepare", "y", "changing", got, "Drop this column of y.")
    refuse_wrapped(raw_y)
    dt = mean_step(grid)
    ends = as_limits(limits, even_y)
    resolved_cutoff, filled = _resolve_cutoff(cutoff, even_y, dt, order, ends)
    trim = 2 if resolved_cutoff is None else int(np.ceil(TRIM / (resolved_cutoff * dt)))
    plan = Preparation(
        t=grid,
        y=even_y,
        u=even_u,
        order=order,
        method=method,
        cutoff=resolved_cutoff,
        decimation=_resolve_decimation(decimate, resolved_cutoff, dt, grid.size),
        trim=min(trim, grid.size // 16),
        noise=sensor_noise(filled, dt, resolved_cutoff),
        rows=(0, grid.size),
        limits=ends,
    )
    held_columns = _held_columns(held, even_u)
    return hold(plan.apply(plan.t, plan.y, plan.u), dict.fromkeys(held_columns, HALF_SAMPLE))


def _held_columns(held: Any, u: Array | None) -> list[int]:
    """Return the columns of u that are held."""
    n_inputs = 0 if u is None else u.shape[1]
    if isinstance(held, bool):
        return list(range(n_inputs)) if held else []
    advice = "Write True if all inputs are held, or their columns in u."
    if not isinstance(held, Sequence) or not all(isinstance(k, int) for k in held):
        checks.refuse_type("prepare", "held", "a bool or a sequence of int", held, advice)
    if not set(held) <= set(range(n_inputs)):
        checks.refuse("prepare", "held", f"columns of u below {n_inputs}", f"{held}", advice)
    return list(held)


def _enough(n: int, order: int) -> None:
    """Raise an error if a record is too short for a derivative of this order."""
    least = 16 + 4 * order
    if n < least:
        advice = "Record longer or sample faster."
        checks.refuse("prepare", "t", f"at least {least} samples long", f"{n}", advice)


def _resolve_cutoff(
    cutoff: Any, y: Array, dt: float, order: int, limits: Array
) -> tuple[float | None, Array]:
    """Return the cutoff in cycles per unit of t or None, and the readings with gaps bridged."""
    if isinstance(cutoff, str):
        if cutoff != "auto":
            advice = 'Write "auto" to take it from the noise floor.'
            checks.refuse("prepare", "cutoff", '"auto", a number or None', repr(cutoff), advice)
        return _auto_cutoff(y, dt, order, limits)
    resolved = None if cutoff is None else checks.cutoff("prepare", cutoff, dt)
    return resolved, bridged(y, limits, dt, resolved, order)


def _auto_cutoff(y: Array, dt: float, order: int, limits: Array) -> tuple[float, Array]:
    """Return the automatic cutoff and the bridged readings, which depend on each other."""
    cutoff, filled = auto_cutoff(y, dt, order), y
    if not beyond(y, limits).any():
        return cutoff, filled
    for _ in range(N_ITERATIONS):
        filled = bridged(y, limits, dt, cutoff, order)
        cutoff = auto_cutoff(filled, dt, order)
    return cutoff, filled


def _resolve_decimation(decimate: Any, cutoff: float | None, dt: float, n: int) -> int:
    """Return the decimation: one of so many samples is kept."""
    per_period = 0.0 if cutoff is None else 1.0 / (cutoff * dt)
    if isinstance(decimate, str):
        if decimate != "auto":
            advice = 'Write "auto" to take it from the cutoff.'
            checks.refuse("prepare", "decimate", '"auto" or an integer', repr(decimate), advice)
        return max(1, min(int(per_period / OVERSAMPLING), n // LEAST_ROWS))
    most = max(1, int(per_period / LEAST_OVERSAMPLING))
    factor = checks.count("prepare", "decimate", decimate)
    if factor > most:
        advice = "More would alias: lower the cutoff first."
        checks.refuse("prepare", "decimate", f"at most {most} here", f"{factor}", advice)
    return factor
