"""The order of the looks, and what an interrupt leaves of them."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from pysindy_evolve.loop.search import look_for_effects as in_order


@dataclass(frozen=True)
class Findings:
    """What the looks of these tests find."""

    findings: tuple[str, ...] = ()

    def judged(self, _):
        return self


def ended_by(steps):
    """Return the last step, and whether an interrupt ended them."""
    last = Findings()
    try:
        for step in steps:
            last = step
    except KeyboardInterrupt:
        return last, True
    return last, False


@pytest.fixture
def looked(monkeypatch):
    """Return a search whose first and second look, by name, are given."""

    def search(first, second):
        looks = iter((first, second))
        monkeypatch.setattr(in_order, "_look", lambda found, rng: next(looks)(found))
        monkeypatch.setattr(in_order, "with_holds", lambda _: None)
        return in_order.look_for_effects(Findings(), np.random.default_rng(0))

    return search


def finds(*names):
    """Return a look that finds some effects."""

    def look(found):
        yield replace(found, findings=names)

    return look


def is_interrupted(*names):
    """Return a look that is interrupted after it found some effects."""

    def look(found):
        yield replace(found, findings=names)
        raise KeyboardInterrupt

    return look


@pytest.mark.parametrize(("found_again", "left"), [((), ("first",)), (("second",), ("second",))])
def test_an_interrupt_of_the_second_search_loses_nothing(monkeypatch, looked, found_again, left):
    monkeypatch.setattr(in_order, "through_functions", lambda _: Findings())
    last, interrupted = ended_by(looked(finds("first"), is_interrupted(*found_again)))
    assert interrupted
    assert last.findings == left


@pytest.mark.parametrize("again", [("second",), ()])
def test_a_search_begins_again_where_records_turn_out_to_be_read_otherwise(
    monkeypatch, looked, again
):
    """Also where that finds nothing: what was found before stood for how the input acts."""
    monkeypatch.setattr(in_order, "through_functions", lambda _: Findings())
    assert ended_by(looked(finds("first"), finds(*again))) == (Findings(again), False)


def test_a_search_ends_where_nothing_is_read_otherwise(monkeypatch, looked):
    monkeypatch.setattr(in_order, "through_functions", lambda _: None)
    last, _ = ended_by(looked(finds("first"), finds("second")))
    assert last.findings == ("first",)


def test_looks_go_on_from_what_those_before_them_found():
    def adds(name):
        def look(found, _):
            yield replace(found, findings=(*found.findings, name))

        return look

    def finds_nothing(*_):
        return iter(())

    looks = (adds("friction"), finds_nothing, adds("drag"))
    steps = list(in_order._in_turn(Findings(), looks, np.random.default_rng(0)))
    assert [step.findings for step in steps] == [("friction",), ("friction", "drag")]


def test_names_are_looked_for_again_on_inputs_that_are_held(monkeypatch):
    monkeypatch.setattr(in_order, "_name", lambda found, _: finds("on held inputs")(found))
    for held, names in [(None, []), (Findings(), [("on held inputs",)] * 2)]:
        monkeypatch.setattr(in_order, "with_holds", lambda _, held=held: held)
        steps = in_order._name_on_held(Findings(("before",)), np.random.default_rng(0))
        assert [step.findings for step in steps] == names
