"""What is a quotient over a distance, or over squares, is not taken for a curved function."""

from functools import partial

import numpy as np
import pytest
import sympy
from loop_systems import measured, oscillator

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import OFFSET, Candidate
from pysindy_evolve.loop.free_runs.quotients import _over_even, _Place, as_quotients
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import call, constant, mul, power, variable

RISES = call(BUILTIN["exp"], mul(constant(0.6), variable(0)))


def forms_of(*terms, name="evolved term", declared="-k*q - c*v + b*F"):
    machine = oscillator("magnet", "", declared)
    record = machine.record()
    design = design_of(machine.model, [record])
    part = segments([record], design.velocities)
    return as_quotients(Candidate(name, 1, terms), design, part), record.x[:, 0]


@pytest.mark.parametrize("terms", [(RISES,), (RISES, OFFSET)])
def test_an_exponential_stands_for_powers_of_a_distance_that_lie_beyond_the_record(terms):
    forms, q = forms_of(*terms)
    assert [len(form.terms) for form in forms] == [1, 2, 1, 2]
    for form in forms:
        assert -form.terms[0].constants[0] > q.max()


def test_where_an_offset_stands_none_is_added():
    forms, _ = forms_of(RISES, declared="-k*q - c*v + b*F + o")
    assert [len(form.terms) for form in forms] == [1, 1]


def test_what_is_not_curved_and_grown_is_no_quotient():
    assert forms_of(mul(variable(0), variable(1)))[0] == []
    assert forms_of(RISES, name="cubic stiffness")[0] == []


def test_what_saturates_stands_for_what_falls_again():
    forms, _ = forms_of(call(BUILTIN["tanh"], mul(constant(2.0), variable(1))))
    rows = np.array([[0.0, v, 0.0, 0.0] for v in (-3.0, -0.2, 0.4, 2.0)])
    (alone, _) = (form.terms for form in forms)
    below = rows[:, 1] / alone[0].evaluate(rows) - rows[:, 1] ** 2
    assert np.allclose(below, below[0])
    assert below[0] > 0.0


def test_the_closest_is_found_though_far_away_all_are_alike():
    """Of tanh(1.1 p)/p, in 1/(c^2 + p^2): a search over all lengths at once ends far out."""
    p = np.linspace(0.3, 4.0, 300)[:, None]
    bent = mul(call(BUILTIN["tanh"], mul(constant(1.1), variable(0))), power(variable(0), -1))
    place = _Place(bent.evaluate(p), np.ones_like(p), p)
    closest = place.closest(partial(_over_even, constant(1.0), 0, 4.0, 2))
    assert 1.0 < closest.constants[0] < 4.0


def test_what_comes_not_close_is_left_out():
    assert forms_of(call(BUILTIN["sin"], mul(constant(9.0), variable(0))))[0] == []


def test_a_pole_is_close_to_its_exponential_but_for_an_offset_and_a_line():
    forms, q = forms_of(RISES)
    rows = np.zeros((len(q), 4))
    rows[:, 0] = q
    wanted = RISES.evaluate(rows)
    for form in forms:
        basis = np.column_stack([np.ones_like(q), q, form.terms[0].evaluate(rows)])
        left = wanted - basis @ np.linalg.lstsq(basis, wanted, rcond=None)[0]
        assert np.std(left) < 0.02 * np.std(wanted)


def found(declared, truth, size):
    """Return the one effect that a machine lacks, and what the declared parameters are with it."""
    record = measured({"q": "v", "v": truth}, noise=5e-4, size=size, seed=5)
    model = pse.DeclaredModel({"q": "v", "v": declared}, inputs=["F"])
    report = pse.close_loop(model, record, random_state=0)
    (effect,) = report.effects
    return effect, report.after.parameters


@pytest.mark.slow
def test_the_pull_of_a_magnet_is_found_with_its_place():
    declared, truth = "-k*q - c*v + b*F", "-9*q - 0.6*v + F + 2/(2 - q)**2"
    effect, parameters = found(declared, truth, size=3.0)
    (place,) = effect.numbers.values()
    assert place == pytest.approx(2.0, rel=0.02)
    assert parameters == pytest.approx({"k": 9.0, "c": 0.6, "b": 1.0}, rel=0.02)


@pytest.mark.slow
def test_the_pull_of_an_electromagnet_is_found_where_a_square_of_the_current_is_declared():
    declared, truth = "-k*q - c*v + a*F^2", "-20*q - 0.6*v + 0.5*F**2/(1 - q)**2"
    effect, _ = found(declared, truth, size=1.0)
    q, force = sympy.symbols("q F", real=True)
    (length,) = effect.numbers.values()
    assert length == pytest.approx(1.0, rel=0.01)
    assert sympy.simplify(effect.term - force**2 / (q - length) ** 2) == 0
    assert effect.coefficients == pytest.approx([0.5], rel=0.03)


@pytest.mark.slow
def test_a_gain_that_falls_with_the_square_of_a_state_is_found_beside_an_offset():
    """A regulated gene, whose product keeps it from being read."""
    rng, t = np.random.default_rng(0), 0.05 * np.arange(4000)
    waves = zip(rng.uniform(0.02, 0.4, 10), rng.uniform(0.0, 6.28, 10), strict=True)
    u = 3.0 + 0.3 * sum(np.sin(2.0 * np.pi * f * t + phase) for f, phase in waves)
    model = pse.DeclaredModel({"x": "2*u/(1 + x**2/4) - 0.5*x - 0.6"}, inputs=["u"])
    x = pse.simulate(model.design().equations([]), [2.0], t, u, tolerance=1e-9)
    record = pse.prepare(t, x + 5e-3 * x.std() * rng.standard_normal(x.shape), u, order=1)
    declared = pse.DeclaredModel({"x": "b*u - a*x"}, inputs=["u"])
    report = pse.close_loop(declared, record, n_twins=59, random_state=0)
    (effect,) = report.effects
    assert effect.coefficients == pytest.approx([8.0, -0.6], rel=0.05)
    assert list(effect.numbers.values()) == pytest.approx([4.0], rel=0.05)


@pytest.mark.slow
def test_a_gene_that_is_repressed_by_the_fourth_power_of_its_product_is_found():
    rng, t = np.random.default_rng(0), 0.05 * np.arange(3000)
    u = np.repeat(rng.uniform(0.0, 2.0, 25), 120)
    gene = pse.DeclaredModel({"m": "4/(1 + p**4) - m", "p": "m - p + u"}, inputs=["u"])
    x = pse.simulate(gene.design().equations([]), [1.0, 1.0], t, u, tolerance=1e-9)
    y = x + 4e-3 * x.std(axis=0) * rng.standard_normal(x.shape)
    declared = pse.DeclaredModel({"m": "-d*m", "p": "b*m - c*p + u"}, inputs=["u"])
    report = pse.close_loop(declared, pse.prepare(t, y, u, order=1), n_twins=59, random_state=0)
    (effect,) = report.effects
    p = sympy.Symbol("p", real=True)
    assert sympy.degree(1 / effect.term, p) == 4
    assert effect.coefficients == pytest.approx([4.0], rel=0.03)
    assert float(effect.term.subs(p, 0)) == pytest.approx(1.0, rel=0.05)
