"""What the report says of alternatives: their p, and that only those count that were tried."""

from dataclasses import replace

import numpy as np
import sympy

from pysindy_evolve.loop.facts.effect import Alternative
from pysindy_evolve.loop.report.effect_text import alternative, without_rivals


def test_the_p_of_an_alternative_is_explained_where_one_is_shown(report):
    (effect, *_) = report.effects
    term = effect.term
    other = Alternative("cubic stiffness", effect.state, term, 0.012, (), np.array([2.0]), 2 * term)
    form = replace(other, name=effect.name)
    explained = "chance alone would count against it as strongly if it were the true cause"
    for rivals, is_explained in (((other, form), True), ((form,), False), ((), False)):
        said = " ".join(str(replace(report, effects=(replace(effect, rivals=rivals),))).split())
        assert ("(p = 0.012)" in said) == is_explained
        assert (explained in said) == is_explained


def test_no_more_alternatives_are_said_to_do_worse_than_were_tried(report):
    alone = replace(report.effects[0], rivals=())
    for contested, said in (
        (True, "all alternatives that were tried do worse on this record, by more than chance"),
        (False, "no other effect was tried in its place"),
    ):
        shown = str(replace(report, effects=(replace(alone, contested=contested),)))
        assert said in shown


def test_an_effect_with_many_alternatives_is_said_to_be_hardly_known(report):
    (effect, *_) = report.effects
    other = Alternative("cubic stiffness", effect.state, effect.term, 1.0, (), force=effect.term)
    for n_rivals, is_said in ((5, False), (6, True)):
        shown = str(replace(report, effects=(replace(effect, rivals=(other,) * n_rivals),)))
        assert ("something is missing, but hardly what" in shown) is is_said


def test_what_has_no_alternatives_because_another_effect_needs_it_is_said_to_be_that(report):
    alone = replace(report.effects[0], rivals=(), contested=False)
    needed = "no other effect was tried in its place, as another effect here needs it"
    for quantities, is_needed in (((), True), (("delay",), False)):
        assert (needed == without_rivals(replace(alone, quantities=quantities))) is is_needed


def test_only_an_alternative_in_the_same_variables_is_the_same_in_another_form(report):
    *_, effect = report.effects
    (own,), q = effect.term.free_symbols, sympy.Symbol("q", real=True)
    for term, said in (
        (sympy.tanh(own), "the form tanh(v)"),
        (q * own, "another Coulomb friction q v"),
    ):
        rival = Alternative(effect.name, effect.state, term, 1.0, (), force=term)
        assert alternative(rival, effect) == said
