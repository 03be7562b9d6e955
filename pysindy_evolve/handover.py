"""How the target reaches the library.

``SINDy.fit`` calls ``feature_library.fit_transform(x)`` and passes no target. Before that, however,
it shows the library every array: ``correct_shape`` gets each x, then each x_dot, then each u, and
where x_dot is not given, ``calc_trajectory`` gets each x and makes its x_dot. So the library notes
these arrays. ``fit`` looks up its x in the notes, bit by bit, and takes the x_dot next to it. This
works with any optimizer, unlike a hand-over to the optimizer.

The notes are kept outside the library, separately for each thread, so they are not cloned, pickled
or seen by another thread. They are dropped at ``fit`` and ``transform``, and when a ``SINDy`` call
that was aborted has released its arrays. ``score`` and ``predict`` always call ``transform``, so no
notes remain.
"""

from __future__ import annotations

import threading
import weakref
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np


@dataclass
class _Notes:
    """The arrays that one library was shown in one thread since its last fit or transform."""

    shown: list[np.ndarray] = field(default_factory=list)
    pairs: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    first: weakref.ref[Any] | None = None

    def is_stale(self) -> bool:
        return self.first is not None and self.first() is None


class _Desk(threading.local):
    """The notes of one thread, for each library."""

    def __init__(self) -> None:
        self.notes: weakref.WeakKeyDictionary[Any, _Notes] = weakref.WeakKeyDictionary()


_of_thread = _Desk()


def note_shape(library: Any, array: Any) -> None:
    """Note an array that `correct_shape` receives: an x, an x_dot or a u."""
    notes = _of_thread.notes.get(library)
    if notes is None or notes.is_stale() or notes.pairs:
        notes = _of_thread.notes[library] = _Notes(first=weakref.ref(array))
    notes.shown.append(np.asarray(array))


def note_pair(library: Any, x: Any, x_dot: Any) -> None:
    """Note an x and the x_dot computed from it, unless this is `score` after `transform`."""
    notes = _of_thread.notes.get(library)
    if notes is not None:
        notes.pairs.append((np.asarray(x), np.asarray(x_dot)))


def input_repeated_by_sindy(library: Any) -> np.ndarray | None:
    """Return an input that ``SINDy`` repeated for each sample of x because of its other length.

    A 1-D u that cannot be a column beside x is taken for constant inputs, one for each number.
    The repeated array has steps of zero bytes from row to row.
    """
    notes = _of_thread.notes.get(library)
    for array in notes.shown if notes else ():
        if array.ndim == 2 and len(array) > 1 and array.strides[0] == 0:
            return array
    return None


def forget(library: Any) -> None:
    """Drop the notes of a library."""
    _of_thread.notes.pop(library, None)


def target(library: Any, x: Sequence[np.ndarray]) -> list[np.ndarray] | None:
    """Return the x_dot of each trajectory of x, or None if they were not noted.

    Parameters
    ----------
    library : object
        The library being fitted; its notes are dropped.
    x : sequence of ndarray of shape (n_samples, n_states + n_inputs)
        Trajectories, as `fit` receives them.

    Returns
    -------
    list of ndarray of shape (n_samples, n_states), or None
    """
    notes = _of_thread.notes.pop(library, None)
    if notes is None:
        return None
    k = len(x)
    if len(notes.pairs) == k:
        states, targets = zip(*notes.pairs, strict=True)
        return list(targets) if all(map(_begins_with, x, states)) else None
    if notes.pairs:
        return None
    for groups in (2, 3):  # x and x_dot; x, x_dot and u
        shown = notes.shown[-groups * k :]
        if len(shown) == groups * k and _is_fit(
            x, [shown[i : i + k] for i in range(0, len(shown), k)]
        ):
            return shown[k : 2 * k]
    return None


def _is_fit(x: Sequence[np.ndarray], groups: list[list[np.ndarray]]) -> bool:
    """Tell whether groups are the x, x_dot and u of the x that `fit` received.

    An x_dot of another length is accepted here; a later check raises its error.
    """
    for i, xi in enumerate(x):
        state, derivative, *inputs = (group[i] for group in groups)
        columns = [state, *inputs]
        if state.shape[1:] != derivative.shape[1:] or any(len(c) != len(xi) for c in columns):
            return False
        edges = np.cumsum([0, *(column.shape[1] for column in columns)])
        if xi.shape != (len(xi), edges[-1]):
            return False
        parts = zip(columns, pairwise(edges), strict=True)
        if not all(np.array_equal(column, xi[:, a:b]) for column, (a, b) in parts):
            return False
    return True


def _begins_with(x: np.ndarray, states: np.ndarray) -> bool:
    width = states.shape[-1]
    return len(x) == len(states) and np.array_equal(x[:, :width], states)
