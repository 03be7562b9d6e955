"""What a later effect makes superfluous goes, and what it needs beside it stays."""

import numpy as np
import pytest
from loop_systems import measured, multisine

import pysindy_evolve as pse
from pysindy_evolve.hidden_states.memory import Memory
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.evidence.findings import Finding, MemoryFinding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.revision.superseded import without_superseded
from pysindy_evolve.loop.revision.thinning import thinned
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import call, constant, mul, power, variable

DIODE = pse.DeclaredModel({"V": "b*F - a*V"}, inputs=["F"])
CRANE = pse.DeclaredModel({"q": "v", "v": "-g*sin(q) - c*v + b*F"}, inputs=["F"])


def found(design, name, state, term, step, **options):
    """A finding of one term, as a step of the loop reports it."""
    candidate = Candidate(name, state, (term,))
    return Finding(
        candidate, columns_of(candidate, design), 1.0, 0.016, np.zeros(60), step, **options
    )


def exponential(rate):
    return call(BUILTIN["exp"], mul(constant(rate), variable(0)))


def diode(extra=""):
    """Findings of a circuit with a diode: a square and a cube, then what was grown beside them."""
    truth = {"V": f"5*F - 2*V - 0.02*exp(4*V) {extra}"}
    record = measured(truth, noise=2e-3, size=1.2, order=1, duration=60.0)
    design = design_of(DIODE, [record])
    names = [("input nonlinearity", power(variable(1), 2)), ("coupling", power(variable(0), 3))]
    named = [found(design, name, 0, term, 1 + k) for k, (name, term) in enumerate(names)]
    return design, [*named, found(design, "evolved term", 0, exponential(4.4), 3)], record


def test_names_go_that_a_grown_term_needs_only_with_the_wrong_number_in_it():
    design, findings, record = diode()
    (kept,) = thinned(design, findings, segments([record]))
    assert kept.candidate.name == "evolved term"
    assert kept.candidate.terms[0].constants == pytest.approx([4.0], rel=0.02)
    assert kept.columns == columns_of(kept.candidate, design)


def test_a_name_that_is_really_there_stays_beside_a_grown_term():
    design, findings, record = diode("- 0.5*F^2")
    kept = thinned(design, findings, segments([record]))
    assert [f.candidate.name for f in kept] == ["input nonlinearity", "evolved term"]
    assert kept[-1].candidate.terms[0].constants == pytest.approx([4.0], rel=0.02)


def test_a_name_that_came_after_the_grown_term_is_none_of_its_gaps():
    design, (square, *_, grown), record = diode()
    findings = [grown, found(design, "input nonlinearity", 0, square.candidate.terms[0], 4)]
    assert thinned(design, findings, segments([record])) == findings


def crane(truth, **options):
    """Findings of a hanging load: its input comes late, and then something else is found."""
    record = measured({"q": "v", "v": truth}, size=5.0, **options)
    design = design_of(CRANE, [record])
    acts = variable(2)
    late = Candidate("input delay", 1, (acts,))
    delay = Memory("input delay", 0, (0.03,))
    memory = MemoryFinding(late, (), 1.0, 0.001, np.zeros(999), 1, by_runs=True, memory=delay)
    swing = mul(acts, call(BUILTIN["cos"], variable(0)))
    return design, [memory, found(design, "evolved term", 1, swing, 2)], [record]


def test_a_delay_goes_that_a_later_effect_explains():
    design, findings, records = crane("-9.8*sin(q) - 0.3*v + F*cos(q)")
    assert without_superseded(design, findings, records, records) == findings[1:]


def test_a_delay_that_is_really_there_stays():
    t = np.arange(0.0, 40.0, 0.01)
    force = multisine(5.0, 0)
    model = {"q": "v", "v": "-9.8*sin(q) - 0.3*v + F*cos(q)"}
    machine = pse.DeclaredModel(model, inputs=["F"]).design().equations([])
    late = pse.simulate(machine, [0.0, 0.0], t, lambda s: force(s - 0.03), tolerance=1e-8)
    noise = 1e-3 * late[:, 0].std() * np.random.default_rng(0).standard_normal(len(t))
    design, findings, _ = crane(model["v"])
    records = [pse.prepare(t, late[:, 0] + noise, force(t))]
    assert without_superseded(design, findings, records, records) == findings


def test_what_was_found_last_is_not_looked_at_again():
    design, findings, records = crane("-9.8*sin(q) - 0.3*v + F*cos(q)")
    assert without_superseded(design, findings[:1], records, records) == findings[:1]
