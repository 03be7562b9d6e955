"""What a search has found, and what it takes back."""

import numpy as np
import pytest
from loop_systems import oscillator

from pysindy_evolve.hidden_states.memory import Memory
from pysindy_evolve.loop.effects.candidate import OFFSET, Candidate
from pysindy_evolve.loop.evidence.findings import Finding, MemoryFinding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.rules import Rules
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.growth.term_grower import Grown
from pysindy_evolve.loop.search import found as found_module
from pysindy_evolve.loop.search.found import Found

FRICTION = oscillator("Coulomb friction", "- 2*sgn(v)")
LATE = Memory("input delay", 0, (0.02,))


@pytest.fixture(scope="module")
def start():
    record = FRICTION.record(duration=8.0)
    return Found(
        FRICTION.model.design(), [record], segments([record]), Rules(0.05, 59, 0.05, 4), ()
    )


def offset(start, equation):
    """Return an offset that was found in an equation."""
    candidate = Candidate("constant offset", equation, (OFFSET,))
    return Finding(candidate, columns_of(candidate, start.design), 1.0, 0.01, np.zeros(9))


def delay():
    """Return a delay of the force that was found."""
    candidate = Candidate("input delay", 1, ())
    return MemoryFinding(candidate, (), 1.0, 0.01, np.zeros(9), memory=LATE)


@pytest.mark.parametrize("is_needed", [True, False])
def test_what_a_withdrawn_finding_outdid_comes_back_if_it_is_needed(start, monkeypatch, is_needed):
    """A hysteresis took the place of friction; when it fell, the model was called complete."""
    other, hysteresis, friction, elsewhere = (offset(start, k) for k in (0, 1, 1, 0))
    monkeypatch.setattr(found_module, "prune", lambda _, all_, __: all_[: 1 + is_needed])
    with_outdone = Found(
        start.declared,
        start.records,
        start.pieces,
        start.rules,
        (),
        findings=(other, hysteresis),
        outdone=(friction, elsewhere),
    )
    left = with_outdone.without(hysteresis)
    assert left.findings == ((other, friction) if is_needed else (other,))
    assert left.outdone == (elsewhere,)


def test_pieces_follow_the_memories_that_are_found(start):
    """They cannot be those of other findings: an offset leaves them, a delay shifts the force."""
    force = start.corrected_pieces.z[..., 2]
    assert np.array_equal(start.with_findings([offset(start, 1)]).corrected_pieces.z[..., 2], force)
    late = start.with_findings([delay()]).corrected_pieces.z[..., 2]
    assert late[:, 2:] == pytest.approx(force[:, :-2], abs=0.02 * force.std())
    assert np.abs(late - force).max() > 0.1 * force.std()


def test_what_grew_is_forgotten_once_the_records_are_read_otherwise(start):
    grown = Grown(terms=[Candidate("evolved term", 1, (OFFSET,))])
    known = Found(start.declared, start.records, start.pieces, start.rules, (), grown=grown)
    assert known.with_findings([offset(start, 1)]).grown is grown
    assert known.with_findings([delay()]).grown.terms == []
    assert known.with_records(known.records, known.wide_records).grown.terms == []


def test_another_step_has_another_number(start):
    first = start.numbered([offset(start, 1)])
    both = start.with_findings(first).numbered([offset(start, 0), offset(start, 1)])
    assert [finding.step for finding in (*first, *both)] == [1, 2, 2]
