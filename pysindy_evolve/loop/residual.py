r"""What a model leaves unexplained, seen in three ways that are all linear in the residual.

*Spectral view*: both sides times tapered sines and cosines (the weak form with Fourier test
functions), each frequency weighed by the noise that the model leaves there. What is left is white,
so this is where effects are ranked and tested: generalized least squares, no row counted twice.

*Derivative view*: x_dot - f(x), averaged over smooth windows (the weak form).
*Simulation view*: the deviation e of the measured states from a simulation that starts on them.
To first order it obeys the linearized model, driven by the residual,

.. math:: \dot e = J(x) \, e + (\dot x - f(x)), \quad J = \partial f / \partial x,

so that it, too, is a linear map of the rows. It sees slow and small effects that the noise of a
second derivative drowns. These two say how much an effect matters.

Because all views are linear, declared columns, candidate effects and target pass through them
alike, and everything after that is small Gram matrices.

======  ==============================================  ======================================
symbol  shape                                           meaning
======  ==============================================  ======================================
z       (n_segments, n, n_variables)                    states, inputs, time
force   (n_segments, n, n_states, n_columns + 1)        columns and target in each equation
grams   (n_segments, n_columns + 1, n_columns + 1)      inner products, target last
======  ==============================================  ======================================
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import dct
from scipy.signal.windows import tukey

from ..equations import Equations
from ..signals import Record, Windows, choose_windows, project
from ..terms import Cache
from .design import Column, Design
from .linear import solve

__all__ = ["Segments", "derivative_grams", "jacobian", "segments", "spectral_grams", "view_grams"]

N_SEGMENTS = 16
MAX_ROWS = 24_000  # the search looks at no more rows; coefficients are fitted on all of them
MAX_GROWTH = 1e3  # ... and so short that an unstable model does not blow up in it
TAPER = 0.5  # share of a segment over which the taper falls to zero
N_WEIGHINGS = 3  # of the frequencies by what the fit of the one before leaves
LARGEST = 1e100  # a column with larger values is no candidate; its square would overflow
LEAST_POWER = 1e-8  # of the noise, relative to its peak: below it there is only rounding
BAND = 0.999  # share of the power of a derivative that is looked at, if no cutoff is known
FEWEST_FREQUENCIES = 8  # of a segment
ROWS_PER_WINDOW = 64  # of the simulated deviation, which is smooth, so many rows are kept


@dataclass(frozen=True, eq=False)
class Segments:
    """Pieces of equal length of one or several records, with the scales that weigh their rows."""

    z: np.ndarray
    x_dot: np.ndarray
    dt: float
    windows: Windows
    state_scale: np.ndarray
    rate_scale: np.ndarray
    cutoff: float
    places: tuple[tuple[int, int], ...]

    @property
    def n_states(self) -> int:
        """Number of states."""
        return self.x_dot.shape[2]

    def every_other(self, start: int) -> Segments:
        """Return every second piece, beginning with the one numbered `start`."""
        pick = slice(start, None, 2)
        return replace(self, z=self.z[pick], x_dot=self.x_dot[pick], places=self.places[pick])

    def of(self, records: Sequence[Record]) -> Segments:
        """Return the same pieces of other records of the same shape, such as twins."""
        z, x_dot = _cut(records, self.places, self.z.shape[1])
        return replace(self, z=z, x_dot=x_dot)


def segments(
    records: Sequence[Record], n_segments: int = N_SEGMENTS, max_rows: int | None = MAX_ROWS
) -> Segments:
    """Cut records into pieces of equal length.

    Parameters
    ----------
    records : sequence of Record
        Training records of equal sampling time.
    n_segments : int
        About how many pieces; no piece crosses from one record into the next.
    max_rows : int or None
        Pieces are shortened to hold no more rows in all.

    Returns
    -------
    Segments
    """
    sizes = [record.n_samples for record in records]
    step = max(8, min(sum(sizes) // n_segments, min(sizes)))
    length = step if max_rows is None else max(8, min(step, max_rows // n_segments))
    places = tuple(
        (i, start) for i, n in enumerate(sizes) for start in range(0, n - length + 1, step)
    )
    z, x_dot = _cut(records, places, length)
    state_scale = _std(np.concatenate([record.x for record in records]))
    rate_scale = _std(np.concatenate([record.x_dot for record in records]))
    windows = choose_windows(list(records))
    if windows.width > length // 2:
        windows = Windows(width=max(1, length // 2), stride=max(1, length // 8))
    slowest = FEWEST_FREQUENCIES / (length * records[0].dt)
    cutoff = min(_band(record, slowest) for record in records)
    return Segments(z, x_dot, records[0].dt, windows, state_scale, rate_scale, cutoff, places)


def _cut(
    records: Sequence[Record], places: Sequence[tuple[int, int]], length: int
) -> tuple[np.ndarray, np.ndarray]:
    stacked = [variables_of(record) for record in records]
    z = np.stack([stacked[i][start : start + length] for i, start in places])
    x_dot = np.stack([records[i].x_dot[start : start + length] for i, start in places])
    return z, x_dot


def variables_of(record: Record) -> np.ndarray:
    """Return states, inputs and time side by side, shape (n_samples, n_variables)."""
    parts = [record.x] if record.u is None else [record.x, record.u]
    return np.column_stack([*parts, record.t])


def _band(record: Record, slowest: float) -> float:
    """Return the highest frequency to look at, in cycles per unit of t.

    It is the cutoff of the preparation. Nobody knows how a record of the user was smoothed, but
    what is gone from its derivatives still is in sgn and its like, whose harmonics would speak
    against them; so the band ends where the power of the derivatives does, but not below the
    slowest that a segment can hold.
    """
    if record.preparation is not None:
        return record.preparation.cutoff or np.inf
    moving = record.x_dot[:, np.ptp(record.x_dot, axis=0) > 0.0]
    if moving.shape[1] == 0:
        return np.inf
    # Cosine transform: no taper, so what happens at the ends counts as well.
    power = dct(moving / np.ptp(moving, axis=0), axis=0)[1:] ** 2
    share = np.cumsum(power, axis=0) / power.sum(axis=0)
    reached = 1 + int(np.max(np.argmax(share >= BAND, axis=0)))
    return max(reached / (2.0 * record.n_samples * record.dt), slowest)


def _std(values: np.ndarray) -> np.ndarray:
    scale = values.std(axis=0)
    return np.where(scale > 0.0, scale, 1.0)


def forces(part: Segments, design: Design, columns: Sequence[Column]) -> np.ndarray:
    """Evaluate columns and target in each equation; the target is x_dot minus what is known."""
    n_segments, length, n_variables = part.z.shape
    flat = part.z.reshape(-1, n_variables)
    cache: Cache = {}
    target = part.x_dot.reshape(-1, part.n_states) - design.known(flat)
    values = [column.evaluate(flat, cache) for column in columns]
    return np.stack([*values, target], axis=2).reshape(n_segments, length, part.n_states, -1)


def view_grams(
    part: Segments, design: Design, columns: Sequence[Column], jacobians: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the Gram matrices of each segment in both views.

    Parameters
    ----------
    part : Segments
        Rows to look at.
    design : Design
        Supplies the known parts of the equations.
    columns : sequence of Column
        Columns of the design, then candidates.
    jacobians : ndarray of shape (n_segments, n, n_states, n_states)
        Of the model that the simulation view is linearized about.

    Returns
    -------
    dict of str to ndarray of shape (n_segments, n_columns + 1, n_columns + 1)
        "derivative" and "simulation".
    """
    force = forces(part, design, columns)
    rows = {"derivative": _derivative_rows(part, design, force)}
    rows["simulation"] = _simulation_rows(part, force, jacobians)
    return {name: np.einsum("srk,srl->skl", r, r, optimize=True) for name, r in rows.items()}


def derivative_grams(part: Segments, design: Design, columns: Sequence[Column]) -> np.ndarray:
    """Return the Gram matrices of each segment in the derivative view alone."""
    rows = _derivative_rows(part, design, forces(part, design, columns))
    return np.einsum("srk,srl->skl", rows, rows, optimize=True)


def spectral_grams(part: Segments, design: Design, columns: Sequence[Column]) -> np.ndarray:
    """Return the Gram matrices of each segment in the spectral view.

    Parameters
    ----------
    part : Segments
        Rows to look at.
    design : Design
        Supplies the known parts of the equations.
    columns : sequence of Column
        Columns of the design, then candidates.

    Returns
    -------
    ndarray of shape (n_segments, n_columns + 1, n_columns + 1)
    """
    rows = _spectra(part, design, columns)
    weight = _weights(rows)
    weighed = (rows * weight[..., None]).reshape(len(rows), -1, rows.shape[-1])
    parts = np.concatenate([weighed.real, weighed.imag], axis=1)
    return np.einsum("srk,srl->skl", parts, parts, optimize=True)


def spectral_weights(part: Segments, design: Design, columns: Sequence[Column]) -> np.ndarray:
    """Return the weight of each frequency in each open equation, (n_open, n_frequencies)."""
    return _weights(_spectra(part, design, columns))


def spectral_rows(part: Segments, columns: np.ndarray) -> np.ndarray:
    """Transform tapered segments.

    Parameters
    ----------
    part : Segments
        Sampling time and cutoff.
    columns : ndarray of shape (n_segments, n, n_columns)
        Anything sampled on the segments.

    Returns
    -------
    ndarray of complex of shape (n_segments, n_frequencies, n_columns)
        Frequencies up to the cutoff. A column with a value that is not finite is all zero.
    """
    length = columns.shape[1]
    band = np.fft.rfftfreq(length, part.dt) <= part.cutoff
    usable = np.all(np.abs(columns) < LARGEST, axis=(0, 1))  # False for NaN too
    tapered = np.where(usable, columns, 0.0) * tukey(length, TAPER)[None, :, None]
    return np.fft.rfft(tapered, axis=1)[:, band]


def _spectra(part: Segments, design: Design, columns: Sequence[Column]) -> np.ndarray:
    """Return spectra of columns and target, (n_segments, n_open, n_frequencies, n_columns)."""
    force = forces(part, design, columns)
    spectra = [
        spectral_rows(part, force[:, :, state]) / part.rate_scale[state]
        for state in design.open_states
    ]
    return np.stack(spectra, axis=1)


def _weights(rows: np.ndarray) -> np.ndarray:
    """Weigh each frequency by the inverse of the noise there.

    The noise is what all columns together, candidates included, leave. What only the model leaves
    would hold the effect that is sought, and hide it behind its own power.
    """
    weight = np.ones(rows.shape[1:3])
    for _ in range(N_WEIGHINGS):
        flat = (rows * weight[..., None]).reshape(-1, rows.shape[-1])
        gram = (flat.conj().T @ flat).real
        contrast = np.append(solve(gram[:-1, :-1], gram[:-1, -1]), -1.0)
        power = np.mean(np.abs(rows @ contrast) ** 2, axis=0)
        weight = 1.0 / np.sqrt(_smooth(power))
    return weight


def _smooth(power: np.ndarray) -> np.ndarray:
    """Average a power spectrum over neighboring frequencies, an eighth of an octave and more."""
    n = power.shape[-1]
    index = np.arange(n)
    reach = 1 + index // 8
    sums = np.concatenate([np.zeros((len(power), 1)), np.cumsum(power, axis=-1)], axis=-1)
    low, high = np.maximum(index - reach, 0), np.minimum(index + reach + 1, n)
    flat = (sums[:, high] - sums[:, low]) / (high - low)
    return np.maximum(flat, np.max(flat, axis=-1, keepdims=True) * LEAST_POWER + 1e-300)


def _derivative_rows(part: Segments, design: Design, force: np.ndarray) -> np.ndarray:
    """Average over windows; each open equation is weighed by the size of its derivative."""
    n_segments, length, _, n_columns = force.shape
    lengths = [length] * n_segments
    blocks = []
    for state in design.open_states:
        flat = force[:, :, state].reshape(n_segments * length, n_columns)
        averaged = project(flat, part.windows, lengths) / part.rate_scale[state]
        blocks.append(averaged.reshape(n_segments, -1, n_columns))
    return np.concatenate(blocks, axis=1)


def _simulation_rows(part: Segments, force: np.ndarray, jacobians: np.ndarray) -> np.ndarray:
    """Drive the linearized model; the unknown initial states are projected out."""
    n_segments, length, n_states, n_columns = force.shape
    span = length
    while True:
        n_windows = length // span
        shape = (n_segments * n_windows, span, n_states)
        driven = force[:, : n_windows * span].reshape(*shape, n_columns)
        slope = jacobians[:, : n_windows * span].reshape(*shape, n_states)
        keep = max(1, span // ROWS_PER_WINDOW)
        free, response = _respond(slope, driven, part.dt, part.state_scale, keep)
        if span <= 8 or np.max(np.abs(free)) < MAX_GROWTH:
            break
        span = max(8, span // 2)
    basis, _ = np.linalg.qr(free)
    response -= basis @ (np.swapaxes(basis, 1, 2) @ response)
    return response.reshape(n_segments, -1, n_columns)


def _respond(
    slope: np.ndarray, driven: np.ndarray, dt: float, scale: np.ndarray, keep: int
) -> tuple[np.ndarray, np.ndarray]:
    """Integrate e' = J e + force from rest, and from unit initial states without force.

    Trapezoidal in the force, third order in J dt. Every `keep`-th sample of the windows is
    returned, in units of the scale of each state, as shapes (n_windows, rows, n_states) and
    (n_windows, rows, n_columns).
    """
    n_windows, span, n_states, n_columns = driven.shape
    a = slope * dt
    step = np.eye(n_states) + a @ (np.eye(n_states) + a @ (np.eye(n_states) + a / 3.0) / 2.0)
    deviation = np.zeros((n_windows, n_states, n_columns + n_states))
    deviation[:, :, n_columns:] = np.diag(scale)
    kept = [deviation]
    with np.errstate(over="ignore", invalid="ignore"):
        for i in range(span - 1):
            push = np.zeros_like(deviation)
            push[:, :, :n_columns] = driven[:, i] * (dt / 2.0)
            deviation = step[:, i] @ (deviation + push)
            deviation[:, :, :n_columns] += driven[:, i + 1] * (dt / 2.0)
            if (i + 1) % keep == 0:
                kept.append(deviation)
    rows = np.stack(kept, axis=1) / scale[:, None]
    rows = np.nan_to_num(rows, nan=1e30, posinf=1e30, neginf=-1e30)
    rows = rows.reshape(n_windows, -1, n_columns + n_states)
    return rows[:, :, n_columns:], rows[:, :, :n_columns]


def jacobian(equations: Equations, z: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Return d x_dot / d x on each row, without the jumps of sgn terms.

    The smaller of two differences is taken, one just ahead and one just behind: across a jump one
    of the two is huge, elsewhere they agree. Neither touches the row itself, which may stand
    exactly on a jump, as a mass at rest does.

    Parameters
    ----------
    equations : Equations
        The model.
    z : ndarray of shape (..., n_variables)
        States, inputs, time.
    scale : ndarray of shape (n_states,)
        Size of each state.

    Returns
    -------
    ndarray of shape (..., n_states, n_states)
    """
    n_states = len(equations.states)
    flat = z.reshape(-1, z.shape[-1])
    result = np.empty((len(flat), n_states, n_states))
    for j in range(n_states):
        step = 1e-6 * scale[j]
        forward = (_moved(equations, flat, j, 2 * step) - _moved(equations, flat, j, step)) / step
        backward = (
            _moved(equations, flat, j, -step) - _moved(equations, flat, j, -2 * step)
        ) / step
        result[:, :, j] = np.where(np.abs(forward) < np.abs(backward), forward, backward)
    return result.reshape(*z.shape[:-1], n_states, n_states)


def _moved(equations: Equations, flat: np.ndarray, column: int, step: float) -> np.ndarray:
    moved = flat.copy()
    moved[:, column] += step
    return _rates(equations, moved)


def _rates(equations: Equations, flat: np.ndarray) -> np.ndarray:
    cache: Cache = {}
    columns = [term.evaluate(flat, cache) for term in equations.terms]
    if not columns:
        return np.zeros((len(flat), len(equations.states)))
    return np.column_stack(columns) @ equations.coef.T
