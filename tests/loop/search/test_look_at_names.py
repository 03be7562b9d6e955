"""Naming effects one after the other ends, also where a step takes back what it found."""

import numpy as np
import pytest
from loop_systems import oscillator

from pysindy_evolve.hidden_states.memory import Memory
from pysindy_evolve.loop.effects.candidate import OFFSET, Candidate
from pysindy_evolve.loop.evidence.findings import Finding, MemoryFinding, memories_in
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.rules import Rules
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.growth.term_grower import TermGrower
from pysindy_evolve.loop.search import found as found_module
from pysindy_evolve.loop.search import look_at_names
from pysindy_evolve.loop.search.found import Found
from pysindy_evolve.terms import variable

FRICTION = oscillator("Coulomb friction", "- 2*sgn(v)")
EVIDENCE = 1.0, 0.01, np.zeros(9)
MOST_LOOKS = 6  # an endless search is ended there


@pytest.fixture
def start():
    record = FRICTION.record(duration=8.0)
    return Found(
        FRICTION.model.design(), [record], segments([record]), Rules(0.05, 59, 0.05, 8), ()
    )


@pytest.fixture
def search(start, monkeypatch):
    """Return what a search finds whose looks find the same each time, and how often it looks."""

    def searched(*new):
        looks = []

        def look(found, _):
            looks.append(found)
            return found, found.numbered(new) if len(looks) < MOST_LOOKS else []

        monkeypatch.setattr(look_at_names, "_look_once", look)
        *_, last = look_at_names.find_named(start, np.random.default_rng(0))
        return last, len(looks)

    return searched


def delay(kind="input delay"):
    memory = Memory(kind, 0, (0.02,))
    return MemoryFinding(Candidate(kind, 1, ()), (), *EVIDENCE, memory=memory)


def test_a_memory_that_its_tuning_drops_is_not_looked_for_again(search, monkeypatch):
    """The loop of a piezo stage, whose hysteresis followed the voltage, never ended."""
    monkeypatch.setattr(look_at_names, "_tuned", lambda found: found.with_findings([]))
    left, n_looks = search(delay(), delay("actuator lag"))
    assert not left.findings
    assert n_looks == 1


def test_a_memory_that_is_how_the_input_was_recorded_is_looked_for_once_if_nothing_changes(
    search, monkeypatch
):
    monkeypatch.setattr(look_at_names, "without_holds", lambda found, _: (found, []))
    left, n_looks = search(delay())
    assert not left.findings
    assert n_looks == 1


def test_another_effect_of_the_same_name_is_looked_for(search, start, monkeypatch):
    """What ends the search is a state that was there before, not a name."""
    for step in ("_exchanged", "_pruned", "_tuned"):
        monkeypatch.setattr(look_at_names, step, lambda found: found)
    monkeypatch.setattr(look_at_names, "_or_grown", lambda found, *_: found)
    candidate = Candidate("constant offset", 1, (OFFSET,))
    left, n_looks = search(Finding(candidate, columns_of(candidate, start.design), *EVIDENCE))
    assert len(left.findings) == MOST_LOOKS - 1
    assert n_looks == MOST_LOOKS
    assert not memories_in(left.findings)


def test_a_name_comes_back_if_the_grown_term_in_its_place_does_not_stand(start, monkeypatch):
    """A fan was left without an effect once a grown term fell, though a name had passed."""

    def finding(name):
        candidate = Candidate(name, 1, (variable(0),))
        return Finding(candidate, columns_of(candidate, start.design), *EVIDENCE)

    named, grown = finding("linear stiffness"), finding("evolved term")
    monkeypatch.setattr(TermGrower, "better", lambda *_: [grown])
    better = look_at_names._or_grown(start, start, [named], np.random.default_rng(0))
    assert [one.candidate.name for one in better.findings] == ["evolved term"]
    monkeypatch.setattr(found_module, "prune", lambda _, findings, __: list(findings))
    back = better.without(better.findings[0])
    assert [one.candidate.name for one in back.findings] == ["linear stiffness"]
