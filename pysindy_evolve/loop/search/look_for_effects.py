"""The order of the looks: names, what remembers, what runs show, grown terms; what falls again."""

from __future__ import annotations

from collections.abc import Callable

from ..evidence.findings import Finding
from .holding import take_holds
from .look_at_grown_terms import grow_terms
from .look_at_names import find_named, tune_memories
from .look_at_runs import find_in_runs, hold_against_runs
from .state import Search

__all__ = ["look_for_effects"]


def look_for_effects(search: Search) -> None:
    """Find effects until none passes: names, what only runs show, then terms without a name.

    Parameters
    ----------
    search : Search
        Knows the model and the records, and keeps what is found, also if it is interrupted.
    """
    _look(search)
    before = search.findings
    if search.takes_functions() or _holds_show(search):
        _again(search, before, _look)
    search.judge_rest()


def _holds_show(search: Search) -> bool:
    """Tell whether inputs turn out to be held by the model as it is now; forget all findings."""
    if not take_holds(search):
        return False
    search.forget()
    return True


def _again(search: Search, before: list[Finding], look: Callable[[Search], None]) -> None:
    """Look from the beginning; an interrupt that comes too early leaves what was known before."""
    try:
        look(search)
    except KeyboardInterrupt:
        if not search.findings:
            search.findings = before
            search.look_through(before)
        raise


def _look(search: Search) -> None:
    _name(search)
    before = search.findings
    if _holds_show(search):  # mostly they do by now, and what follows takes longer
        _again(search, before, _name)
    if search.runs_tell_more:
        find_in_runs(search)
    grow_terms(search)
    if search.runs_tell_more:
        hold_against_runs(search)


def _name(search: Search) -> None:
    find_named(search)
    tune_memories(search)
