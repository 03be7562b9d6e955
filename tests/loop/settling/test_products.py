"""What a product of states is called."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.evidence.findings import Finding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.settling.other_names import as_coupling
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import add, call, mul, power, variable

STATES = {"q": "v", "v": "-k*q + b*F", "w": "-a*w", "z": "-c*z"}
Q, V, W, Z, F = map(variable, range(5))


@pytest.fixture(scope="module")
def design():
    t = 0.1 * np.arange(50)
    x = np.random.default_rng(0).normal(size=(50, 4))
    record = pse.Record(t=t, x=x, x_dot=x, u=t[:, None])
    return design_of(pse.DeclaredModel(STATES, inputs=["F"]), [record])


@pytest.mark.parametrize(
    ("term", "name"),
    [
        (mul(W, Z), "coupling"),
        (mul(power(W, 2), V), "coupling"),
        (mul(Q, V), "evolved term"),  # only what moves itself
        (mul(W, F), "coupling"),  # as of a rotor that turns with the speed F
        (mul(V, F), "evolved term"),
        (mul(W, variable(5)), "evolved term"),  # with the time
        (power(W, 3), "evolved term"),
        (add(mul(W, Z), W), "evolved term"),
        (mul(W, call(BUILTIN["sin"], Z)), "evolved term"),
    ],
)
def test_a_grown_product_with_another_state_is_a_coupling(design, term, name):
    grown = Candidate("evolved term", 1, (term,))
    finding = Finding(grown, columns_of(grown, design), 1.0, 0.01, np.zeros(9))
    found = as_coupling(finding, design)
    assert found.candidate.name == name
    assert found.candidate.terms == grown.terms


def test_other_names_stay(design):
    drag = Candidate("quadratic drag", 1, (mul(W, Z),))
    finding = Finding(drag, columns_of(drag, design), 1.0, 0.01, np.zeros(9))
    assert as_coupling(finding, design) is finding
