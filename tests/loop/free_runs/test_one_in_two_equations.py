"""What one species loses another gains: one expression takes the place of two."""

from dataclasses import replace

import numpy as np
import pytest
from loop_systems import equations_of

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import OFFSET, Candidate
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.effects.names import EVOLVED, SATURATING
from pysindy_evolve.loop.evidence.findings import Finding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.free_runs.contenders import Pool
from pysindy_evolve.loop.free_runs.one_in_two_equations import (
    _in_equation,
    one_in_two_equations,
)
from pysindy_evolve.loop.free_runs.variants import Model
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.rules import Rules
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import call, constant, mul, power, variable

RULES = Rules(significance=0.05, n_twins=59, min_share=0.05, max_effects=8)
X, S = variable(0), variable(1)
MONOD = pse.DeclaredModel(
    {"X": "m*S/(1.2 + S)*X - D*X", "S": "D*(F - S) - 2*m*S/(1.2 + S)*X"}, inputs=["D", "F"]
)


def chemostat(uptake, lost="0", poured="0"):
    """Measure cells X that eat S, diluted by D, with fresh food F, over 400 h."""
    t, rng = np.arange(0.0, 400.0, 0.2), np.random.default_rng(0)
    stairs = [np.repeat(rng.uniform(*ends, 20), 100) for ends in ((0.05, 0.3), (6.0, 14.0))]
    inputs = np.column_stack([np.convolve(u, np.ones(15) / 15.0, "same") for u in stairs])
    sides = {"X": f"{uptake} - D*X - {lost}", "S": f"D*(F - S) - 2*{uptake} - {poured}"}
    t, inputs = t[:-30], inputs[15:-15]  # where the average of the stairs is over whole windows
    x = pse.simulate(equations_of(sides, ("D", "F")), [3.0, 3.0], t, inputs)
    y = x + 0.002 * x.std(axis=0) * rng.standard_normal(x.shape)
    return pse.prepare(t, y, inputs, order=1)


def evolved(state, term):
    return Candidate(EVOLVED, state, (term,))


def exchanged(record, *chosen):
    """Return the effects that take the place of those in two equations."""
    design = design_of(MONOD, [record])
    part = segments([record], design.velocities)
    found = [
        Finding(c, columns_of(c, design), 1.0, 0.016, np.zeros(60), step=k + 1)
        for k, c in enumerate(chosen)
    ]
    pool = Pool((), (), part, 0.05)
    kept = one_in_two_equations(Model(design), found, pool, [record], RULES)
    assert [(f.step, f.columns) for f in kept] == [
        (k + 1, columns_of(f.candidate, design)) for k, f in enumerate(kept)
    ]
    return [f.candidate for f in kept]


def test_an_expression_in_both_takes_the_place_of_two_that_resemble_it():
    record = chemostat("0.5*S*X/(1.2 + S + S^2/9)")
    wrong = evolved(0, mul(X, call(BUILTIN["tanh"], mul(constant(0.1), S))))
    growth, uptake = exchanged(record, wrong, evolved(1, mul(X, power(S, 2))))
    assert (growth.name, growth.state, uptake.name, uptake.state) == (SATURATING, 0, SATURATING, 1)
    # Over its constant, the denominator is 1 + S/1.2 + S^2/10.8.
    assert growth.shape.values == uptake.shape.values == pytest.approx((10.8**0.5,), rel=0.01)


def test_a_grown_term_may_be_the_one_that_stands_in_both():
    record = chemostat("(0.5*S*X/(1.2 + S) - 0.1*X*sin(0.7*S))")
    wave = mul(X, call(BUILTIN["sin"], mul(constant(0.65), S)))
    growth, uptake = exchanged(record, evolved(0, wave), evolved(1, mul(X, power(S, 2))))
    assert growth.terms == uptake.terms
    assert growth.shape.values == uptake.shape.values
    assert growth.numbers == pytest.approx((0.7,), rel=0.01)


def test_two_that_differ_stay():
    record = chemostat("0.5*S*X/(1.2 + S)", lost="0.02*X^2", poured="0.03*S^2")
    design = design_of(MONOD, [record])
    offered = candidates(design, segments([record], design.velocities).ranges)
    squares = [evolved(k, power(variable(k), 2)) for k in (0, 1)]
    named = [c for k in (0, 1) for c in offered if (c.state, c.terms) == (k, squares[k].terms)]
    assert exchanged(record, *named) == named
    assert exchanged(record, *squares) == squares


def test_a_grown_term_brings_no_second_offset():
    bent = replace(evolved(0, call(BUILTIN["exp"], S)), terms=(call(BUILTIN["exp"], S), OFFSET))
    moved = _in_equation(bent, 1, {(1, OFFSET)})
    assert (moved.state, moved.terms) == (1, bent.terms[:1])
    assert _in_equation(bent, 1, {(0, OFFSET)}).terms == bent.terms
    # One that stands there already keeps its term: it is a combination of columns, and drops out.
    assert _in_equation(evolved(0, S), 1, {(1, S), (1, OFFSET)}).terms == (S,)
