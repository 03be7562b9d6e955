"""The order of the looks, and what an interrupt leaves of them."""

from types import SimpleNamespace

import pytest

from pysindy_evolve.loop.search import look_for_effects as in_order


class Interrupted(SimpleNamespace):
    """A search that begins again because of what it found, and is interrupted then."""

    def takes_functions(self):
        self.findings = []
        return True

    def look_through(self, findings):
        self.seen_with = findings


@pytest.mark.parametrize(("found_again", "left"), [([], ["first"]), (["second"], ["second"])])
def test_an_interrupt_of_the_second_search_loses_nothing(monkeypatch, found_again, left):
    search = Interrupted(findings=["first"], has_room=True, looks=0)

    def look(search):
        search.looks += 1
        if search.looks == 2:
            search.findings = found_again
            raise KeyboardInterrupt("Ctrl-C")

    monkeypatch.setattr(in_order, "_look", look)
    with pytest.raises(KeyboardInterrupt, match="Ctrl-C"):
        in_order.look_for_effects(search)
    assert search.findings == left


@pytest.mark.parametrize("found", [["friction"], []])
@pytest.mark.parametrize(("shows", "looks"), [(True, 2), (False, 1)])
def test_holds_that_show_in_the_end_begin_the_search_again(monkeypatch, found, shows, looks):
    search = SimpleNamespace(findings=[], has_room=True, looks=0, takes_functions=lambda: False)
    search.forget = lambda: setattr(search, "findings", [])
    search.judge_rest = lambda: None

    def look(search):
        search.looks += 1
        search.findings = found

    monkeypatch.setattr(in_order, "_look", look)
    monkeypatch.setattr(in_order, "take_holds", lambda search: shows)
    in_order.look_for_effects(search)
    assert search.looks == looks
    assert search.findings == found
