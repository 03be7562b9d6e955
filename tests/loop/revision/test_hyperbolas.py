"""A coefficient that varies in proportion to a variable gives way to a hyperbola that fits."""

import numpy as np
import pytest
from loop_systems import equations_of, multisine, oscillator

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.evidence.findings import Finding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.revision import hyperbolas
from pysindy_evolve.loop.revision.hyperbolas import with_hyperbolas
from pysindy_evolve.terms import mul, variable

PRODUCT = Candidate("coupling", 1, (mul(variable(0), variable(1)),))


def after(term):
    """Return a damping that varies with the position, looked at again on a record."""
    machine = oscillator("coupling", term, size=12.0)
    record, design = machine.record(duration=20.0), machine.model.design()
    found = Finding(PRODUCT, columns_of(PRODUCT, design), 1.0, 0.01, np.zeros(9))
    (kept,) = with_hyperbolas(design, [found], segments([record]))
    return kept.candidate


def test_a_coefficient_that_goes_with_one_over_a_distance_is_a_hyperbola():
    """With c / (1 - q/L) it is the declared one times 1 + q/(L - q)."""
    candidate = after("- 2*v*q/(2.5 - q)")
    assert candidate.shape is not None
    assert candidate.shape.values == pytest.approx((2.5,), rel=0.02)
    assert candidate.shape.meanings == ("length",)


@pytest.mark.parametrize("term", ["- 2*q*v", "- 2*q*v - 1.5*q^2*v"])
def test_what_varies_in_proportion_or_as_a_parabola_stays(term):
    assert after(term) is PRODUCT


def test_a_product_that_stands_in_the_model_already_stays():
    """It has no score of its own then, that a hyperbola could be clearly better than."""
    machine = oscillator("coupling", "- 2*q*v", "-k*q - c*v + b*F - d*q*v")
    record, design = machine.record(duration=8.0), machine.model.design()
    found = Finding(PRODUCT, columns_of(PRODUCT, design), 1.0, 0.01, np.zeros(9))
    (kept,) = with_hyperbolas(design, [found], segments([record]))
    assert kept.candidate is PRODUCT


def test_a_product_stays_where_no_column_is_new(monkeypatch):
    """Such as on a record in which the variable does not move."""
    monkeypatch.setattr(hyperbolas, "score", lambda *_, **__: [])
    assert after("- 2*v*q/(2.5 - q)") is PRODUCT


@pytest.mark.slow
def test_a_hyperbola_is_found_though_terms_may_grow():
    """A belt gets stiffer the closer its driven end comes; an exponential would do so too."""
    t = np.arange(0.0, 25.0, 0.01)
    inputs = np.column_stack([multisine(7.0, 1, (0.3, 4.0))(t), multisine(0.15, 2, (0.2, 1.0))(t)])
    belt = equations_of({"q": "v", "v": "F - 2*v - 40*(q - b)/(0.5 - b)"}, ("F", "b"))
    q = pse.simulate(belt, [0.0, 0.0], t, inputs)[:, 0]
    noise = 2e-4 * q.std() * np.random.default_rng(0).standard_normal(len(t))
    declared = pse.DeclaredModel({"q": "v", "v": "F - c*v - k*(q - b)"}, inputs=["F", "b"])
    record = pse.prepare(t, q + noise, inputs)
    (effect,) = pse.close_loop(declared, record, n_twins=59, random_state=0).effects
    assert effect.numbers == pytest.approx({"length": 0.5}, rel=0.01)
    assert abs(effect.coefficients[0]) == pytest.approx(40.0, rel=0.01)
