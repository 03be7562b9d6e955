"""The order of the looks: names, what remembers, what runs show, grown terms; what falls again."""

from __future__ import annotations

from .free_runs import find_in_runs, hold_against_runs
from .grown import grow_terms
from .named import find_named, take_holds, tune_memories
from .state import Search

__all__ = ["look_for_effects"]


def look_for_effects(search: Search) -> None:
    """Find effects until none passes: names, what only runs show, then terms without a name.

    Parameters
    ----------
    search : Search
        Knows the model and the records, and keeps what is found, also if it is interrupted.
    """
    if not search.has_room:
        take_holds(search)
    _look(search)
    if search.takes_functions():
        _look(search)
    search.judge_rest()


def _look(search: Search) -> None:
    find_named(search)
    tune_memories(search)
    if search.runs_tell_more:
        find_in_runs(search)
    grow_terms(search)
    if search.runs_tell_more:
        hold_against_runs(search)
