"""How the target reaches the library.

``SINDy.fit`` calls ``feature_library.fit_transform(x)`` and passes no target. Before that, however,
it shows the library every array: ``correct_shape`` gets each x, then each x_dot, then each u, and
where x_dot is not given, ``calc_trajectory`` gets each x and makes its x_dot. So the library notes
what passes by, and in ``fit`` finds its own x again in the notes, bit by bit, and the x_dot next to
it. Chosen over a hand-over to the optimizer, as it works with any optimizer.

The notes are kept outside the library, for each thread its own, so nothing of them is cloned,
pickled or seen by another thread. They are dropped at ``fit`` and ``transform``, and when a call of
``SINDy`` that broke off has let go of its arrays. ``score`` and ``predict`` always come to
``transform``, so nothing stays.
"""

from __future__ import annotations

import threading
import weakref
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

__all__ = ["forget", "note_pair", "note_shape", "repeated", "target"]


@dataclass
class _Notes:
    """What one library saw in one thread since its last fit or transform."""

    shown: list[np.ndarray] = field(default_factory=list)
    pairs: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    first: weakref.ref[Any] | None = None

    def is_stale(self) -> bool:
        return self.first is not None and self.first() is None


class _Desk(threading.local):
    def __init__(self) -> None:
        self.notes: weakref.WeakKeyDictionary[Any, _Notes] = weakref.WeakKeyDictionary()


_desk = _Desk()


def note_shape(library: Any, array: Any) -> None:
    """Note an array that passes `correct_shape`: an x, an x_dot or a u."""
    notes = _desk.notes.get(library)
    if notes is None or notes.is_stale() or notes.pairs:
        notes = _desk.notes[library] = _Notes(first=weakref.ref(array))
    notes.shown.append(np.asarray(array))


def note_pair(library: Any, x: Any, x_dot: Any) -> None:
    """Note an x and the x_dot computed from it, unless this is `score` after `transform`."""
    notes = _desk.notes.get(library)
    if notes is not None:
        notes.pairs.append((np.asarray(x), np.asarray(x_dot)))


def repeated(library: Any) -> np.ndarray | None:
    """Return an input that ``SINDy`` repeated for each sample of x, as it had another length.

    It does so where a 1-D u cannot be a column beside x: each of its numbers becomes a constant
    input. Such an array has steps of zero bytes from row to row.
    """
    notes = _desk.notes.get(library)
    for array in notes.shown if notes else ():
        if array.ndim == 2 and len(array) > 1 and array.strides[0] == 0:
            return array
    return None


def forget(library: Any) -> None:
    """Let go of everything that was noted."""
    _desk.notes.pop(library, None)


def target(library: Any, x: Sequence[np.ndarray]) -> list[np.ndarray] | None:
    """Return the x_dot of each trajectory of x, or None if they did not pass by.

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
    notes = _desk.notes.pop(library, None)
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

    An x_dot of another length is let through: it has an error of its own.
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
