"""What a search keeps, and what it takes back."""

from types import SimpleNamespace

from pysindy_evolve.loop.search.state import Search


def finding(state):
    return SimpleNamespace(candidate=SimpleNamespace(state=state))


def test_what_a_withdrawn_finding_outdid_comes_back():
    """A hysteresis took the place of friction; when it fell, the model was called complete."""
    other, hysteresis, friction, elsewhere = finding(0), finding(1), finding(1), finding(0)
    search = SimpleNamespace(findings=[other, hysteresis], outdone=[friction, elsewhere])
    search.look_through = lambda findings: setattr(search, "seen_with", findings)
    search.judge_rest = lambda: None
    Search.withdraw(search, 1)
    assert search.findings == search.seen_with == [other, friction]
    assert search.outdone == [elsewhere]
    Search.withdraw(search, 1)  # and does not come back again
    assert search.findings == [other]
