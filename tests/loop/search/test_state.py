"""What a search keeps, and what it takes back."""

from types import SimpleNamespace

import pytest

from pysindy_evolve.loop.search import state
from pysindy_evolve.loop.search.state import Search


def finding(equation):
    return SimpleNamespace(candidate=SimpleNamespace(state=equation))


@pytest.mark.parametrize("is_needed", [True, False])
def test_what_a_withdrawn_finding_outdid_comes_back_if_it_is_needed(monkeypatch, is_needed):
    """A hysteresis took the place of friction; when it fell, the model was called complete."""
    other, hysteresis, friction, elsewhere = finding(0), finding(1), finding(1), finding(0)
    search = SimpleNamespace(findings=[other, hysteresis], outdone=[friction, elsewhere])
    search.declared = search.corrected_pieces = None
    search.look_through = lambda findings: setattr(search, "seen_with", findings)
    search.judge_rest = lambda: None
    monkeypatch.setattr(state, "prune", lambda _, found, __: found if is_needed else found[:1])
    Search.withdraw(search, 1)
    assert search.seen_with == [other, friction]
    assert search.findings == ([other, friction] if is_needed else [other])
    assert search.outdone == [elsewhere]
