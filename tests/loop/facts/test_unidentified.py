"""Parameters of which the records tell no single one."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.loop.facts.unidentified import unidentified
from pysindy_evolve.loop.given.declared import design_of

T = np.arange(0.0, 20.0, 0.02)
F = np.sin(0.7 * T) + np.cos(2.3 * T)
Q = np.exp(-0.1 * T) * np.cos(2.0 * T) + np.sin(0.7 * T)


def record(*inputs):
    return pse.prepare(T, Q, np.column_stack([F, *inputs]))


@pytest.mark.parametrize(
    ("rate", "inputs", "groups"),
    [
        ("-k*q - c*v + b*F", [], []),
        ("-k*q - k2*q - c*v + b*F", [], [("k", "k2")]),
        ("-k*q - c*v + b*F + a*G", [2.0 * F], [("b", "a")]),
        ("-k*q - c*v + b*F + o + o2", [], [("o", "o2")]),
        ("-k*q - c*v + b*F - s*max(q - 50, 0)", [], [("s",)]),
        ("-k*q - k2*q - c*v + b*F - s*max(q - 50, 0)", [], [("k", "k2"), ("s",)]),
        ("-k*q - c*v + b*F - s*sin(q/5)", [], []),  # hardly told, but told
    ],
)
def test_terms_that_are_alike_or_zero_on_the_records_are_named(rate, inputs, groups):
    names = ["F", "G"][: 1 + len(inputs)]
    data = [record(*inputs)]
    design = design_of(pse.DeclaredModel({"q": "v", "v": rate}, inputs=names), data)
    assert unidentified(design, data) == groups


def test_what_the_records_do_not_tell_has_no_interval_and_a_sentence():
    rng = np.random.default_rng(0)
    declared = pse.DeclaredModel({"q": "v", "v": "-k*q - k2*q - c*v - s*max(q - 50, 0)"})
    q = np.exp(-0.1 * T) * np.cos(2.0 * T) + 1e-4 * rng.standard_normal(len(T))
    report = pse.close_loop(declared, pse.prepare(T, q), operators=(), random_state=0, n_twins=59)
    assert report.verdict == "complete"
    assert set(report.after.parameter_intervals) == {"c"}
    text = " ".join(str(report).split())
    assert "The records do not tell k from k2: their terms are linearly dependent there" in text
    assert "The records say nothing about s: its term is zero on all of them." in text
    assert "nan" not in text


def test_times_that_begin_long_after_zero_are_doubted():
    declared = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
    late = pse.prepare(T + 1.7e9, Q, F)
    with pytest.warns(UserWarning, match="times begin at 1700000000.*Subtract the first time"):
        pse.close_loop(declared, late, operators=(), max_effects=0, random_state=0)
