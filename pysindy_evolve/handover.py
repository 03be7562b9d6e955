"""How the target reaches the library.

``SINDy.fit`` calls ``feature_library.fit_transform(x)`` and passes no target. Before that, however,
it shows the library every array: ``correct_shape`` gets each x, then each x_dot, then each u, and
where x_dot is not given, ``calc_trajectory`` gets each x and makes its x_dot. So the library notes
these arrays. ``fit`` looks up its x in the notes, bit by bit, and takes the x_dot next to it. This
works with any optimizer, unlike a hand-over to the optimizer. ``DiscreteSINDy.fit`` without x_next
takes the x that it showed without the last sample; then the target is that x without the first.

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
    """Return the x_dot or x_next of each trajectory of x, or None if they were not noted.

    Parameters
    ----------
    library : object
        The library being fitted; its notes are dropped.
    x : sequence of ndarray of shape (n_samples, n_states + n_inputs)
        Trajectories, as `fit` receives them.

    Returns
    -------
    list of ndarray of shape (n_samples, n_targets), or None
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
    shown = notes.shown
    groups = [shown[i : i + k] for i in range(len(shown) % k, len(shown), k)]
    return _target_given(x, groups) or _next_samples(x, groups)


def _target_given(
    x: Sequence[np.ndarray], groups: list[list[np.ndarray]]
) -> list[np.ndarray] | None:
    """Return the x_dot if the last groups are x and x_dot, or x, x_dot and u.

    An x_dot of another length is accepted here; a later check raises its error.
    """
    for n in range(2, min(3, len(groups)) + 1):
        states, derivatives, *inputs = groups[-n:]
        if _is_joined(x, [states, *inputs]):
            return derivatives
    return None


def _next_samples(
    x: Sequence[np.ndarray], groups: list[list[np.ndarray]]
) -> list[np.ndarray] | None:
    """Return the x one sample on if the last groups are x, or x and u, each one sample longer."""
    for n in range(1, min(2, len(groups)) + 1):
        states, *inputs = groups[-n:]
        if _is_joined(x, [[array[:-1] for array in group] for group in (states, *inputs)]):
            return [array[1:] for array in states]
    return None


def _is_joined(x: Sequence[np.ndarray], groups: list[list[np.ndarray]]) -> bool:
    """Tell whether groups, the states and perhaps the inputs, are the columns of each x."""
    for i, xi in enumerate(x):
        columns = [group[i] for group in groups]
        if any(len(column) != len(xi) for column in columns):
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
