"""What was found, in the equation it was found in: who needs whom, and what a model becomes."""

import numpy as np
import pytest

from pysindy_evolve.loop.effects.candidate import OFFSET, Candidate
from pysindy_evolve.loop.evidence.findings import Finding, is_needed, next_step, with_columns
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.design import Design
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.revision.revise import prune
from pysindy_evolve.signals import Record
from pysindy_evolve.terms import Sum, power, variable

A, B = 0, 1


@pytest.fixture
def two():
    """Two equations of the first order in which nothing is known."""
    return Design(("a", "b"), (), (Sum(()), Sum(())), ())


@pytest.fixture
def found(two):
    """An offset in either equation, and a square in that of b, which needs the one there."""

    def finding(name, state, term, parents=(), step=1):
        candidate = Candidate(name, state, (term,), parents)
        return Finding(candidate, columns_of(candidate, two), 1.0, 0.01, np.zeros(9), step)

    square = power(variable(B), 2)
    return [
        finding("constant offset", A, OFFSET),
        finding("constant offset", B, OFFSET, step=2),
        finding("quadratic stiffness", B, square, (OFFSET,), step=3),
    ]


def test_an_effect_needs_its_parent_in_its_own_equation_only(found):
    in_a, in_b, square = found
    assert is_needed(in_b, [square])
    assert not is_needed(in_a, [square])
    assert not is_needed(square, [in_a, in_b])


def test_columns_come_in_the_order_of_the_findings_and_steps_are_counted(two, found):
    whole = with_columns(two, found)
    assert whole.columns == tuple(f.columns[0] for f in found)
    assert next_step(found) == 4
    assert next_step([]) == 1


def test_an_offset_that_only_another_equation_needs_is_dropped(two, found):
    # The rate of a has a mean of zero; that of b has an offset and a square.
    rng = np.random.default_rng(0)
    t = 0.01 * np.arange(4000)
    x = np.column_stack([np.sin(t), np.cos(0.7 * t)])
    x_dot = np.column_stack([np.zeros_like(t), 2.0 + 3.0 * x[:, B] ** 2])
    record = Record(t=t, x=x, x_dot=x_dot + 0.01 * rng.standard_normal(x.shape))
    kept = prune(two, found, segments([record]))
    assert [(f.candidate.name, f.candidate.state) for f in kept] == [
        ("constant offset", B),
        ("quadratic stiffness", B),
    ]
