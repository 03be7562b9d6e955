"""What a look returns, equation by equation."""

import numpy as np

from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.effects.partners import joined
from pysindy_evolve.loop.evidence.ranking import Score
from pysindy_evolve.loop.evidence.rejected import Rejected
from pysindy_evolve.loop.evidence.step import _by_equation
from pysindy_evolve.terms import power, variable


def test_an_effect_of_two_equations_that_did_not_pass_is_named_in_both():
    errors, square = np.ones(3), (power(variable(0), 2),)
    shared = joined([Candidate("coupling", state, square) for state in (1, 2)])
    tried = _by_equation(Score((shared,), (4, 5), errors, 0.9 * errors, 0.1))
    assert [(one.state, one.partners) for one in tried.group] == [(1, ()), (2, ())]
    shown = repr(Rejected(tried, 0.01, variables=("A", "B", "C", "t")))
    assert "coupling in B" in shown
    assert "coupling in C" in shown
