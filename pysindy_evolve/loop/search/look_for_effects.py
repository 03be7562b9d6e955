"""The order of the looks: names, what remembers, what runs show, grown terms; what falls again."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from .found import Found
from .hold_against_runs import hold_against_runs
from .how_inputs_act import through_functions, with_holds
from .look_at_grown_terms import grow_terms
from .look_at_names import find_named, tune_memories
from .look_at_runs import find_in_runs

Look = Callable[[Found, np.random.Generator], Iterator[Found]]


def look_for_effects(found: Found, rng: np.random.Generator) -> Iterator[Found]:
    """Find effects until none passes: names, what only runs show, then terms without a name.

    Parameters
    ----------
    found : Found
        The model and the records.
    rng : numpy.random.Generator
        Source of all randomness.

    Yields
    ------
    Found
        What is known after each step: an interrupt leaves the last one.
    """
    for step in _look(found, rng):
        found = step
        yield found
    again = through_functions(found) or with_holds(found)
    if again is not None:
        for step in _again(again, _look, rng):
            found = step
            yield found
    yield found.judged(rng)


def _look(found: Found, rng: np.random.Generator) -> Iterator[Found]:
    looks = (_name, _name_on_held, find_in_runs, grow_terms, hold_against_runs)
    return _in_turn(found, looks, rng)


def _name(found: Found, rng: np.random.Generator) -> Iterator[Found]:
    return _in_turn(found, (find_named, tune_memories), rng)


def _name_on_held(found: Found, rng: np.random.Generator) -> Iterator[Found]:
    """Name again where inputs are held: mostly that shows by now, and what follows takes longer."""
    held = with_holds(found)
    return iter(()) if held is None else _again(held, _name, rng)


def _in_turn(found: Found, looks: tuple[Look, ...], rng: np.random.Generator) -> Iterator[Found]:
    """Look in several ways, each beside what those before it found."""
    for look in looks:
        for step in look(found, rng):
            found = step
            yield found


def _again(found: Found, look: Look, rng: np.random.Generator) -> Iterator[Found]:
    """Look from the beginning; an interrupt that comes too early leaves what was known before."""
    for step in look(found, rng):
        found = step
        if found.findings:
            yield found
    yield found
