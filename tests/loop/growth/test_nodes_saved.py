"""A declared term that a grown one holds whole counts as one node."""

import numpy as np
import pytest

from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.evidence.ranking import Score
from pysindy_evolve.loop.evidence.scoring import PRICE_PER_NODE_LOG, net
from pysindy_evolve.loop.growth.naming import named, nodes_saved
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import call, constant, mul, of_term, power, variable

HEIGHT, TILT, THRUST = map(variable, range(3))


def product(*factors):
    """Return the one term of a product of sums."""
    whole = constant(1.0)
    for factor in factors:
        whole = mul(whole, factor)
    ((_, term),) = whole.parts
    return term


LIFT = product(THRUST, call(BUILTIN["cos"], TILT))  # four nodes


@pytest.mark.parametrize(
    ("term", "spared"),
    [
        (product(of_term(LIFT), power(HEIGHT, -2)), 3),
        (product(of_term(LIFT), THRUST), 2),  # its square of the thrust is two nodes
        (product(call(BUILTIN["tanh"], of_term(LIFT)), HEIGHT), 3),
        (LIFT, 3),
        (product(THRUST, power(HEIGHT, -2)), 0),  # a part of it only
        (product(THRUST, call(BUILTIN["sin"], TILT)), 0),
        (product(call(BUILTIN["cos"], TILT), power(THRUST, -1)), 0),
    ],
)
def test_what_is_held_whole_is_one_node(term, spared):
    assert nodes_saved(term, [product(HEIGHT), LIFT]) == spared


def test_of_several_declared_terms_the_one_counts_that_spares_most():
    term = product(of_term(LIFT), power(HEIGHT, 2))
    assert nodes_saved(term, [product(power(HEIGHT, 2))]) == 1
    assert nodes_saved(term, [product(power(HEIGHT, 2)), LIFT]) == 3
    assert nodes_saved(term, []) == 0


def test_spared_nodes_have_no_price():
    rows = np.random.default_rng(0).uniform(0.5, 1.5, (50, 3))
    term = product(of_term(LIFT), power(HEIGHT, -2))
    dear, cheap = (
        named(term, 1, [], rows, np.ones(4, dtype=bool), declared) for declared in ([], [LIFT])
    )
    assert (dear.size, cheap.size) == (term.size, term.size - 3)
    gains = [net(Score((one,), 0, np.ones(1), np.ones(1), 1.0)) for one in (cheap, dear)]
    assert gains[0] - gains[1] == pytest.approx(3 * PRICE_PER_NODE_LOG)


def test_a_number_inside_a_grown_term_costs_as_much_as_three_nodes():
    term = call(BUILTIN["tanh"], mul(constant(4.0), variable(0)))
    grown, known = (Candidate(name, 1, (term,)) for name in ("evolved term", "Stribeck friction"))
    assert (term.size, known.size, grown.size) == (3, 3, 5)
