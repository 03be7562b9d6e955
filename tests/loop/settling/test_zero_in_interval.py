"""An effect stays only if the final fit is sure of what makes it one."""

from types import SimpleNamespace

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.hidden_states.memory import VESSEL, Memory
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.evidence.findings import MemoryFinding
from pysindy_evolve.loop.settling.zero_in_interval import most_doubtful

LEVEL = pse.DeclaredModel({"h": "a*sqrt(u) - b*h"}, inputs=["u"]).design()


@pytest.mark.parametrize(
    ("brim", "is_doubted"), [((5.5, 6.5), False), ((0.0, 12.0), True), ((0.0, 5e304), True)]
)
def test_a_vessel_whose_brim_is_unknown_is_doubted(brim, is_doubted):
    """Without one it is a lag, and its time and share are sure though nothing runs over."""
    vessel = Memory(VESSEL, 0, (0.8, 6.0, 1.0))
    named = Candidate("hidden state", 0, ())
    finding = MemoryFinding(named, (), 1.0, 0.001, np.zeros(999), memory=vessel)
    ends = np.array([[0.7, 0.9], brim, [0.9, 1.1]])
    effect = SimpleNamespace(coefficients=np.array(vessel.values), confidence_intervals=ends)
    assert (most_doubtful([finding], [effect], LEVEL) is finding) is is_doubted
