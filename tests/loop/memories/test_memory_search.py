"""Memories of inputs as candidates."""

import numpy as np

from pysindy_evolve.hidden_states.memory import Memory
from pysindy_evolve.loop.effects.candidate import OFFSET, Candidate
from pysindy_evolve.loop.evidence.findings import Finding, MemoryFinding
from pysindy_evolve.loop.memories import memory_search

EVIDENCE = 1.0, 0.01, np.zeros(9)


def memory(kind, column, value):
    found = Memory(kind, column, (value,))
    return MemoryFinding(Candidate(kind, 1, ()), (), *EVIDENCE, memory=found)


def test_a_lag_and_a_delay_that_both_turn_out_to_be_the_same_delay_are_one():
    """Applied twice, either would gain nothing beside the other."""
    offsets = [Finding(Candidate("constant offset", 0, (OFFSET,)), (), *EVIDENCE) for _ in "ab"]
    delay, again = memory("input delay", 0, 0.02), memory("input delay", 0, 0.021)
    elsewhere, lag = memory("input delay", 1, 0.02), memory("actuator lag", 0, 0.02)
    kept = memory_search._each_once([delay, offsets[0], again, elsewhere, lag, offsets[1]])
    assert kept == (delay, offsets[0], elsewhere, lag, offsets[1])
