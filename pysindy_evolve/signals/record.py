"""A record: states, derivatives and inputs at the same instants."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .. import checks
from .sampling import mean_step
from .spectral import Array

if TYPE_CHECKING:
    from .acting import InputFunction
    from .preparation import Preparation


@dataclass(frozen=True, eq=False)
class Record:
    """States, their derivatives and inputs of one experiment, validated.

    Parameters
    ----------
    t : ndarray of shape (n_samples,)
        Time, strictly increasing.
    x : ndarray of shape (n_samples, n_states)
        States, units of x. One dimension is taken as one column.
    x_dot : ndarray of shape (n_samples, n_states)
        Their derivatives, units of x per unit of t.
    u : ndarray of shape (n_samples, n_inputs), optional
        Measured inputs.
    states, inputs : sequence of str, optional
        Names of the columns of x and u.
    preparation : Preparation, optional
        How the record was made from raw data; None if the user made it.
    motion : Preparation, optional
        How the inputs were prepared, if they are a motion that explains a force; see `as_target`.
    seen : ndarray of bool of shape (n_samples, n_states), optional
        False on rows where a sensor was at an end of its range, and on rows that the filter spoils
        around them: x and x_dot are interpolated there. None if all are seen.
    held : mapping of int to float, optional
        Inputs that were held from each sample to the next: column to delay, in sampling times. In u
        their delay is already applied.
    through : mapping of int to InputFunction, optional
        Inputs that act through a function; the low-pass was applied to the function.

    Raises
    ------
    ValueError
        If shapes or lengths disagree, a value is not finite, or time does not increase.
    TypeError
        If something is not made of real numbers.

    Examples
    --------
    >>> import numpy as np
    >>> from pysindy_evolve.signals import Record
    >>> t = np.linspace(0.0, 1.0, 11)
    >>> record = Record(t=t, x=np.sin(t), x_dot=np.cos(t))
    >>> record
    Record(n_samples=11, n_states=1, n_inputs=0, dt=0.1)
    >>> first, last = record.split(0.3)
    >>> first.n_samples, last.n_samples
    (8, 3)
    """

    t: Array
    x: Array
    x_dot: Array
    u: Array | None = None
    states: tuple[str, ...] | None = None
    inputs: tuple[str, ...] | None = None
    preparation: Preparation | None = None
    motion: Preparation | None = None
    seen: NDArray[np.bool_] | None = None
    held: Mapping[int, float] = field(default_factory=dict)
    through: Mapping[int, InputFunction] = field(default_factory=dict)

    def __post_init__(self) -> None:
        t = checks.times("Record", self.t)
        x = checks.columns("Record", "x", self.x)
        x_dot = checks.columns("Record", "x_dot", self.x_dot)
        u = None if self.u is None else checks.columns("Record", "u", self.u)
        checks.same_length("Record", t=t, x=x, x_dot=x_dot, u=u)
        if t.size < 2:
            advice = "Give a longer record."
            checks.refuse("Record", "t", "at least 2 samples long", f"{t.size}", advice)
        if x.shape != x_dot.shape:
            got = f"shape {x_dot.shape}, x has {x.shape}"
            checks.refuse("Record", "x_dot", "of the shape of x", got, "Give one per state.")
        if self.seen is not None and np.shape(self.seen) != x.shape:
            got = f"shape {np.shape(self.seen)}, x has {x.shape}"
            checks.refuse("Record", "seen", "of the shape of x", got, "Give one per state.")
        fields: dict[str, object] = {"t": t, "x": x, "x_dot": x_dot, "u": u}
        fields["states"] = names("states", self.states, x.shape[1])
        fields["inputs"] = names("inputs", self.inputs, 0 if u is None else u.shape[1])
        for name, value in fields.items():
            object.__setattr__(self, name, value)

    @property
    def n_samples(self) -> int:
        """Rows of the record."""
        return int(self.t.size)

    @property
    def n_states(self) -> int:
        """Columns of x."""
        return int(self.x.shape[1])

    @property
    def n_inputs(self) -> int:
        """Columns of u; 0 without inputs."""
        return 0 if self.u is None else int(self.u.shape[1])

    @property
    def dt(self) -> float:
        """Mean sampling time, units of t."""
        return mean_step(self.t)

    @property
    def cutoff(self) -> float | None:
        """Cutoff of the low-pass of the record, cycles per unit of t; None if none is known."""
        return None if self.preparation is None else self.preparation.cutoff

    @property
    def raw_dt(self) -> float:
        """Sampling time of the raw data, units of t; `dt` without raw data."""
        return self.dt if self.preparation is None else self.preparation.dt

    @property
    def has_raw_inputs(self) -> bool:
        """Whether the inputs before the low-pass are known."""
        return self.preparation is not None and self.preparation.u is not None

    @property
    def raw_u(self) -> Array:
        """Inputs before the low-pass, (n_raw, n_inputs); u if they are not known."""
        raw = self.preparation.u if self.preparation is not None else None
        raw = self.u if raw is None else raw
        return np.empty((self.n_samples, 0)) if raw is None else raw

    @property
    def recorded_u(self) -> Array:
        """Inputs as they were recorded, (n_raw, n_inputs): `raw_u` without the delay of a hold."""
        recorded = self.raw_u.copy()
        if self.preparation is not None and self.preparation.steps is not None:
            held = list(self.held)
            recorded[:, held] = self.preparation.steps[:, held]
        return recorded

    def lowpass(self, columns: Array) -> Array:
        """Return raw columns, (n_raw, n_columns), filtered and cut as those of the record."""
        return columns if self.preparation is None else self.preparation.lowpass(columns)

    def with_inputs(self, change: Callable[[Array, Array], Array]) -> Record:
        """Return a record with changed inputs, filtered as the old ones were.

        Parameters
        ----------
        change : callable
            Takes the raw times of shape (n_raw,) and `raw_u`, and returns the new raw inputs.

        Returns
        -------
        Record
            The same object if there are no inputs.
        """
        if self.u is None:
            return self
        made = self.preparation
        if made is None or made.u is None:
            return replace(self, u=change(self.t, self.u))
        raw = change(made.t, made.u)
        u = made.lowpass(raw)
        for column, function in self.through.items():
            u[:, column] = function.after(made.lowpass, raw[:, column], u[:, column])
        return replace(self, u=u, preparation=replace(made, u=raw))

    def __repr__(self) -> str:
        sizes = f"n_samples={self.n_samples}, n_states={self.n_states}, n_inputs={self.n_inputs}"
        return f"Record({sizes}, dt={self.dt:g})"

    def __len__(self) -> int:
        return self.n_samples

    def __getitem__(self, rows: slice) -> Record:
        """Return the rows a:b as a record; its preparation repeats exactly these rows."""
        if not isinstance(rows, slice):
            checks.refuse_type("Record[...]", "rows", "a slice", rows, "Write record[a:b].")
        start, stop, stride = rows.indices(self.n_samples)
        if stride != 1:
            advice = "Write record[a:b]; prepare(decimate=...) thins a record out."
            checks.refuse("Record[...]", "rows", "a slice with step 1", str(stride), advice)
        u = None if self.u is None else self.u[rows]
        made, motion = (_cut(one, start, stop) for one in (self.preparation, self.motion))
        return replace(
            self,
            t=self.t[rows],
            x=self.x[rows],
            x_dot=self.x_dot[rows],
            u=u,
            preparation=made,
            motion=motion,
            seen=None if self.seen is None else self.seen[rows],
        )

    def split(self, fraction: float = 0.3) -> tuple[Record, Record]:
        """Return the first part and the last part, which holds `fraction` of the samples.

        Parameters
        ----------
        fraction : float
            Share of the samples in the last part, to be held out; in (0, 1).

        Returns
        -------
        first, last : Record

        Raises
        ------
        ValueError
            If `fraction` is not between 0 and 1, or a part would keep fewer than two samples.
        TypeError
            If `fraction` is no number.
        """
        must_be = "between 0 and 1"
        share = checks.number("Record.split", "fraction", fraction, must_be, lambda v: 0 < v < 1)
        n_last = round(share * self.n_samples)
        if min(n_last, self.n_samples - n_last) < 2:
            got = f"{share:g} of {self.n_samples} samples"
            advice = "Hold out another share or record more."
            checks.refuse(
                "Record.split", "fraction", "such that both parts keep 2 samples", got, advice
            )
        return self[: self.n_samples - n_last], self[self.n_samples - n_last :]


def _cut(preparation: Preparation | None, start: int, stop: int) -> Preparation | None:
    """Return a preparation that repeats only the rows from `start` to `stop`."""
    if preparation is None:
        return None
    first = preparation.rows[0]
    return replace(preparation, rows=(first + start, first + stop))


def names(parameter: str, given: Sequence[str] | None, n: int) -> tuple[str, ...] | None:
    """Return the given names, checked to be n and distinct; None if none were given."""
    if given is None:
        return None
    advice = "Give one name per column."
    listed = isinstance(given, Sequence) and not isinstance(given, str)
    if not listed or not all(isinstance(name, str) for name in given):
        checks.refuse_type("Record", parameter, "a sequence of str", given, advice)
    if len(given) != n or len(set(given)) != n:
        checks.refuse("Record", parameter, f"{n} distinct names", repr(tuple(given)), advice)
    return tuple(given)


def constant_column(y: Array) -> int | None:
    """Return the index of the first column that never changes, or None."""
    is_constant = np.ptp(y, axis=0) == 0
    return int(np.argmax(is_constant)) if is_constant.any() else None
