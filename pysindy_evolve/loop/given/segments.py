"""Pieces of equal length of the training records, and the frequency band of the search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.fft import dct, prev_fast_len

from ...signals import Record, Windows, choose_windows
from .band import Band
from .input_errors import known_up_to
from .ranges import Ranges
from .rows import scale_of, variables_of
from .sensor import limits_of_states, miss_of_run
from .sticking import weights_in_motion

N_SEGMENTS = 16
N_FOLDS = 8
TO_TRANSFER = 3  # number of records from which on folds are made of whole records
MAX_ROWS = 24_000  # of the search; coefficients are fitted on all rows
# Share of the rows to give up for a length whose Fourier transform is fast; short pieces that lost
# 3 % lost a grown term too.
MAX_LOST_SHARE = 0.01
# Share of the cutoff that is searched; below, the low-pass hardly changes the states.
SEARCHED_CUTOFF_SHARE = 0.6
# Share of the power of a derivative that is searched, if no cutoff is known.
SEARCHED_POWER_SHARE = 0.999
FEWEST_FREQUENCIES = 8  # of a segment, below the cutoff of the search


@dataclass(frozen=True, eq=False)
class Segments:
    """Pieces of equal length of one or several records, with the scales that weigh their rows.

    Attributes
    ----------
    z : ndarray of shape (n_segments, n, n_variables)
        States, inputs and time of each row of each piece, in the units of the records.
    x_dot : ndarray of shape (n_segments, n, n_states)
        Derivatives of the states, units of x per unit of t.
    weight : ndarray of shape (n_segments, n, n_states)
        Weight of a row in the equation of each state, from 0 to 1 (dimensionless).
    resting : tuple of int
        States whose equations are used only where the body moves.
    dt : float
        Sampling time, units of t.
    windows : Windows
        Over which derivatives are averaged.
    state_scale, rate_scale : ndarray of shape (n_states,)
        Standard deviation of each state, units of x, and of its derivative, units of x per unit of
        t; over the training records.
    cutoff : float
        Highest frequency of the search, cycles per unit of t; may be infinite.
    places : tuple of (int, int)
        Record and first row of each piece.
    records : tuple of Record
        All records, including those of pieces that were left out.
    by_trajectory : bool
        Whether candidates are scored by the trajectories of the records, not their derivatives.
    limits : ndarray of shape (2, n_states), optional
        Ends of the ranges of the sensors, units of x; None if all states were seen.
    seen : ndarray of bool of shape (n_segments, n, n_states), optional
        Where the states are measurements; None if they all are.
    band : Band, optional
        The low-passes of the records; passed on with the pieces, since it caches its results.
    settling : tuple of int
        Number of rows at the beginning of each record with little weight; empty if none.
    """

    z: np.ndarray
    x_dot: np.ndarray
    weight: np.ndarray
    resting: tuple[int, ...]
    dt: float
    windows: Windows
    state_scale: np.ndarray
    rate_scale: np.ndarray
    cutoff: float
    places: tuple[tuple[int, int], ...]
    records: tuple[Record, ...]
    by_trajectory: bool = False
    limits: np.ndarray | None = None
    seen: np.ndarray | None = None
    band: Band | None = None
    settling: tuple[int, ...] = ()

    @property
    def n_states(self) -> int:
        """Number of states."""
        return self.x_dot.shape[2]

    @property
    def rows(self) -> np.ndarray:
        """Variables of all pieces one below the other, shape (n_rows, n_variables)."""
        return self.z.reshape(-1, self.z.shape[-1])

    @property
    def ranges(self) -> Ranges:
        """Ranges of the variables in these pieces."""
        return Ranges.of(self.rows)

    @property
    def folds(self) -> np.ndarray:
        """Fold of each piece, from 0: of neighbors or, from three records on, of whole records.

        So an effect that shows in a single record is not confirmed by the others. Two records are
        too few: each would be predicted from a single one.
        """
        record = np.unique([i for i, _ in self.places], return_inverse=True)[1]
        unit = record if record[-1] + 1 >= TO_TRANSFER else np.arange(len(self.places))
        n_units = int(unit[-1]) + 1
        return unit * min(N_FOLDS, n_units) // n_units

    def tracked(self) -> Segments:
        """Return the pieces of records, to be scored by their trajectories."""
        return replace(self, by_trajectory=True)

    def after(self, rows: Sequence[int]) -> Segments:
        """Return the pieces with little weight on the first rows of each record.

        There the hidden states still depend on their unknown start.
        """
        if self.settling:
            return self
        return replace(self, weight=self._late(self.weight, rows), settling=tuple(rows))

    def _late(self, weight: np.ndarray, rows: Sequence[int]) -> np.ndarray:
        """Return weights that are zero on half of the first rows of a record, and then rise."""
        place = np.add.outer([row for _, row in self.places], np.arange(weight.shape[1]))
        n_settling = np.array([max(rows[record], 1) for record, _ in self.places])[:, None]
        return np.asarray(weight * np.clip(2.0 * place / n_settling - 1.0, 0.0, 1.0)[..., None])

    @property
    def has_gaps(self) -> bool:
        """Whether notably many rows were left out between the pieces."""
        length = self.z.shape[1]
        steps = [b[1] - a[1] for a, b in pairwise(self.places) if a[0] == b[0]]
        return max(steps, default=length) > (1.0 + 2.0 * MAX_LOST_SHARE) * length

    def cut(self, columns: Sequence[np.ndarray]) -> np.ndarray:
        """Return the rows of all pieces, (n_segments, n, ...), of one array for each record."""
        return _pieces(columns, self.places, self.z.shape[1])

    def every_other(self, start: int) -> Segments:
        """Return every second piece, beginning with the one numbered `start`."""
        return self.picked(slice(start, None, 2))

    def picked(self, pick: slice) -> Segments:
        """Return some of the pieces."""
        return replace(
            self,
            z=self.z[pick],
            x_dot=self.x_dot[pick],
            weight=self.weight[pick],
            places=self.places[pick],
            seen=None if self.seen is None else self.seen[pick],
            band=None if self.band is None else replace(self.band, places=self.places[pick]),
        )

    def of(self, records: Sequence[Record]) -> Segments:
        """Return the same pieces of other records of the same shape, such as twins."""
        length = self.z.shape[1]
        z, x_dot, weight = _cut(records, self.resting, self.places, length)
        weight = self._late(weight, self.settling) if self.settling else weight
        seen, new_records = _seen(records, self.places, length), tuple(records)
        band = Band(new_records, self.places, length)
        return replace(
            self, z=z, x_dot=x_dot, weight=weight, records=new_records, seen=seen, band=band
        )

    def with_pasts_of(self, records: Sequence[Record]) -> Segments:
        """Return the same pieces of records that differ only in what came before them."""
        new_records = tuple(records)
        band = None if self.band is None else replace(self.band, records=new_records)
        return replace(self, records=new_records, band=band)

    def miss_of(self, x: np.ndarray) -> np.ndarray:
        """Return by how much runs (n_segments, n, n_states) miss what the sensors show."""
        return miss_of_run(self.z[:, :, : self.n_states], self.shown(x), self.limits, self.seen)

    def shown(self, x: np.ndarray) -> np.ndarray:
        """Return runs (n_segments, n, n_states) as the low-passes of the records leave them."""
        return x if self.band is None else self.band.shown(x)


def segments(
    records: Sequence[Record],
    resting: Sequence[int] = (),
    n_segments: int = N_SEGMENTS,
    max_rows: int | None = MAX_ROWS,
) -> Segments:
    """Cut records into pieces of equal length.

    Parameters
    ----------
    records : sequence of Record
        Training records of equal sampling time.
    resting : sequence of int
        States whose equations are used only where the body moves.
    n_segments : int
        About how many pieces; no piece crosses from one record into the next.
    max_rows : int or None
        Largest number of rows in all pieces, which are shortened to meet it.

    Returns
    -------
    Segments
    """
    all_records = tuple(records)
    places, length = places_of(records, n_segments, max_rows)
    z, x_dot, weight = _cut(records, resting, places, length)
    state_scale = scale_of([record.x for record in records])
    rate_scale = scale_of([record.x_dot for record in records])
    windows = choose_windows(list(records))
    if windows.width > length // 2:
        windows = Windows(width=max(1, length // 2), stride=max(1, length // 8))
    slowest = FEWEST_FREQUENCIES / (length * records[0].dt)
    input_cutoff = max(slowest, min(known_up_to(record) for record in records))
    cutoff = min(input_cutoff, *(_band(record, slowest) for record in records))
    return Segments(
        z,
        x_dot,
        weight,
        tuple(resting),
        records[0].dt,
        windows,
        state_scale,
        rate_scale,
        cutoff,
        places,
        all_records,
        limits=limits_of_states(records),
        seen=_seen(records, places, length),
        band=Band(all_records, places, length),
    )


def places_of(
    records: Sequence[Record], n_segments: int, max_rows: int | None = None
) -> tuple[tuple[tuple[int, int], ...], int]:
    """Return record and first row of each piece, and the length of all of them.

    With `max_rows`, the length has small factors where that costs hardly any rows, since the search
    Fourier transforms such pieces many times.
    """
    sizes = [record.n_samples for record in records]
    step = max(8, min(sum(sizes) // n_segments, min(sizes)))
    length = step
    if max_rows is not None:
        length = max(8, min(step, max_rows // n_segments))
        fast = prev_fast_len(length)
        length = fast if length - fast <= MAX_LOST_SHARE * length else length
    places = ((i, start) for i, n in enumerate(sizes) for start in range(0, n - length + 1, step))
    return tuple(places), length


def _cut(
    records: Sequence[Record],
    resting: Sequence[int],
    places: Sequence[tuple[int, int]],
    length: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    stacked = [variables_of(record) for record in records]
    weights = [weights_in_motion(record, resting) for record in records]
    rates = [record.x_dot for record in records]
    z, x_dot, weight = (_pieces(one, places, length) for one in (stacked, rates, weights))
    return z, x_dot, weight


def _pieces(
    columns: Sequence[np.ndarray], places: Sequence[tuple[int, int]], length: int
) -> np.ndarray:
    return np.stack([columns[i][start : start + length] for i, start in places])


def _seen(
    records: Sequence[Record], places: Sequence[tuple[int, int]], length: int
) -> np.ndarray | None:
    if all(record.seen is None for record in records):
        return None
    seen = [np.ones(r.x.shape, dtype=bool) if r.seen is None else r.seen for r in records]
    return _pieces(seen, places, length)


def _band(record: Record, slowest: float) -> float:
    """Return the highest frequency of the search, in cycles per unit of t.

    It follows from the cutoff of the preparation, or of the motion that explains a target. How a
    user smoothed a record is unknown. Terms such as sgn keep the harmonics that smoothing removed
    from the derivatives, and would be rejected for them. So the band of such a record ends where
    the power of its derivatives does, but not below `slowest`.
    """
    made = record.motion if record.preparation is None else record.preparation
    if made is not None:
        return SEARCHED_CUTOFF_SHARE * (made.cutoff or np.inf)
    rates = record.x_dot[:, np.ptp(record.x_dot, axis=0) > 0.0]
    if rates.shape[1] == 0:
        return np.inf
    # Cosine transform: no taper, so what happens at the ends counts as well.
    power = dct(rates / np.ptp(rates, axis=0), axis=0)[1:] ** 2
    share = np.cumsum(power, axis=0) / power.sum(axis=0)
    reached = 1 + int(np.max(np.argmax(share >= SEARCHED_POWER_SHARE, axis=0)))
    return max(reached / (2.0 * record.n_samples * record.dt), slowest)
