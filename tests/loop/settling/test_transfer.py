"""What is another one in each record is no fixed term."""

import numpy as np
import pytest
from loop_systems import measured

import pysindy_evolve as pse
from pysindy_evolve.hidden_states.relaxing import relaxing
from pysindy_evolve.loop.effects.candidate import OFFSET, Candidate
from pysindy_evolve.loop.evidence.findings import Finding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.settling.transfer import last_untransferred
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import call, constant, mul, power, variable

Q, T = variable(0), variable(3)
ANGLE = mul(constant(5.0), T)
FORCING = Candidate(
    "periodic forcing", 1, (call(BUILTIN["sin"], ANGLE), call(BUILTIN["cos"], ANGLE))
)
LOAD = Candidate("constant offset", 1, (OFFSET,))
SLOW = Candidate("hidden state", 1, (relaxing(Q, T, 8.0),))
QUICK = Candidate("hidden state", 1, (relaxing(Q, T, 0.25),))
SIGN = call(BUILTIN["sgn"], variable(1))
BESIDE = Candidate("position-dependent friction", 1, (mul(Q, SIGN),))
CUBIC = Candidate("cubic stiffness", 1, (power(Q, 3),))
MODEL = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])


def records_with(*terms: str) -> list[pse.Record]:
    """An oscillator, once with each of these terms."""
    return [
        measured({"q": "v", "v": f"-40*q - 0.8*v + F {term}"}, seed=seed)
        for seed, term in enumerate(terms)
    ]


@pytest.mark.parametrize(
    ("candidate", "terms", "differs"),
    [
        (FORCING, ("+ 2*sin(5*t)", "+ 2*sin(5*t)"), False),
        (FORCING, ("+ 2*sin(5*t)", "+ 2*sin(5*t + 2)"), True),
        (FORCING, ("+ 2*sin(5*t)",), False),
        (LOAD, ("+ 2", "+ 2"), False),
        (LOAD, ("+ 2", "- 1"), True),
        (SLOW, ("+ 2", "- 1"), True),
    ],
)
def test_what_differs_between_records_is_told_from_what_does_not(candidate, terms, differs):
    records = records_with(*terms)
    design = design_of(MODEL, records)
    finding = Finding(candidate, columns_of(candidate, design), 1.0, 0.016, np.zeros(60), 1)
    gone = last_untransferred(design, [finding], segments(records, design.velocities))
    assert (gone is finding) is differs


def test_a_state_that_relaxes_within_the_records_is_no_load():
    sides = {"q": "v", "v": "-40*q - 0.8*v + F - 30*(q - h)", "h": "4*(q - h)"}
    made = (measured(sides, seed=seed).preparation for seed in (0, 1))
    records = [pse.prepare(one.t, one.y[:, :1], one.u) for one in made]
    design = design_of(MODEL, records)
    finding = Finding(QUICK, columns_of(QUICK, design), 1.0, 0.016, np.zeros(60), 1)
    assert last_untransferred(design, [finding], segments(records, design.velocities)) is None


@pytest.mark.parametrize(
    ("candidate", "terms", "differs"),
    [
        (BESIDE, ("- 2*sgn(v) + 20", "- 1*sgn(v) - 20"), True),
        (BESIDE, ("- 1.5*sgn(v) - 2*q*sgn(v) + 20", "- 1.5*sgn(v) - 2*q*sgn(v) - 20"), False),
        (CUBIC, ("- 9*q**3", "- 9*q**3"), False),
    ],
)
def test_what_only_tells_records_apart_is_no_effect(candidate, terms, differs):
    """The friction is another one in each record, and so is where the machine stands."""
    declared = pse.DeclaredModel({"q": "v", "v": "o - k*q - c*v - f*sgn(v) + b*F"}, inputs=["F"])
    records = records_with(*terms)
    design = design_of(declared, records)
    finding = Finding(candidate, columns_of(candidate, design), 1.0, 0.016, np.zeros(60), 1)
    gone = last_untransferred(design, [finding], segments(records, design.velocities))
    assert (gone is finding) is differs


@pytest.mark.parametrize(
    ("terms", "differs"),
    [(("+ 20", "- 20"), True), (("- 30*q**3 + 20", "- 30*q**3 - 20"), False)],
)
def test_what_stands_for_another_load_in_each_record_is_no_effect(terms, differs):
    records = records_with(*terms)
    design = design_of(MODEL, records)
    finding = Finding(CUBIC, columns_of(CUBIC, design), 1.0, 0.016, np.zeros(60), 1)
    gone = last_untransferred(design, [finding], segments(records, design.velocities))
    assert (gone is finding) is differs


@pytest.mark.slow
def test_a_forcing_with_another_phase_in_each_record_leaves_the_model_untraced():
    *train, test = records_with("+ 2*sin(5*t)", "+ 2*sin(5*t + 2)", "+ 2*sin(5*t + 4)")
    report = pse.close_loop(MODEL, train, test=test, operators=(), n_twins=59, random_state=0)
    assert report.verdict == "untraced"
    assert report.effects == []
    assert "phase differs between records" in str(report)
