"""Friction in a joint that stands in two equations is one force."""

from types import SimpleNamespace

import numpy as np
import pytest
import sympy

from pysindy_evolve.loop.report.one_force import one_force

ENTRY = "as if u2 were larger by this number times sgn(w2)"


def effect(state, low, high, entry=ENTRY, name="Coulomb friction", term=None):
    return SimpleNamespace(
        name=name,
        state=state,
        entry=entry,
        confidence_intervals=np.array([[low, high]]),
        quantities=(),
        expressions=(term or state,),
        term=sympy.Symbol(term or state),
    )


def said(*effects):
    return one_force(SimpleNamespace(effects=effects))


def test_two_effects_that_enter_alike_with_one_number_are_one_force():
    (sentence,) = said(effect("w1", -0.37, -0.33), effect("w2", -0.36, -0.34))
    assert sentence.startswith("Coulomb friction in the equations of w1 and w2 acts as if u2 were")
    assert sentence.endswith("it is one force that acts in both equations.")


@pytest.mark.parametrize(
    "other",
    [
        effect("w2", -0.30, -0.25),
        effect("w2", -0.36, -0.34, entry="as if u1 were larger by this number times sgn(w2)"),
        effect("w2", -0.36, -0.34, name="viscous damping"),
        effect("w1", -0.36, -0.34),
    ],
)
def test_others_are_not(other):
    assert said(effect("w1", -0.37, -0.33), other) == []
    assert said(effect("w1", -0.37, -0.33, entry=""), effect("w2", -0.36, -0.34, entry="")) == []


def test_one_term_that_has_two_names_is_told_to_be_one():
    flow = {"entry": "", "term": "x"}
    second = effect("B", 0.2, 0.3, name="evolved term", **flow)
    (sentence,) = said(effect("A", -0.3, -0.2, name="coupling", **flow), second)
    assert sentence.startswith("Coupling in the equation of A and evolved term in that of B are")
    assert "the same term, x." in sentence
    assert said(effect("A", 1.0, 2.0, name="linear term", **flow), second) == []
    same_name = (effect(state, 0.2, 0.3, name="coupling", **flow) for state in "AB")
    assert said(*same_name) == []
