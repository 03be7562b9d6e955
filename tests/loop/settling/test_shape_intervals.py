"""Numbers inside effects have intervals, and coefficients are known no better than they allow."""

from dataclasses import replace

import numpy as np
import pytest
from loop_systems import measured, oscillator

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.evidence.findings import Finding, with_findings
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.rules import Rules
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.report.report import report_of
from pysindy_evolve.loop.search.found import Found
from pysindy_evolve.loop.settling.assembly import assembled
from pysindy_evolve.loop.settling.shape_intervals import _with_sign_of, with_numbers_known
from pysindy_evolve.operators import BUILTIN, Operator
from pysindy_evolve.terms import call, constant, mul, variable

ROOT = Operator("root", np.sqrt, 1)  # from which nobody takes a factor out
RULES = Rules(0.05, 59, 0.05, 8, refine="derivative")
GAP = oscillator("dead zone", "- 30*(q - (abs(q + 0.2) - abs(q - 0.2))/2)")
STRIBECK = oscillator(
    "Stribeck friction",
    "- 1.5*exp(-(v/0.3)**2)*sgn(v) - 1.5*sgn(v)",
    "-k*q - c*v + b*F - f*sgn(v)",
    size=8.0,
)


def reported(model, record, name, values, states=(1,)):
    """Report effects of one name with these numbers in them; return it, findings and design."""
    declared = design_of(model, [record])
    part = segments([record], declared.velocities)
    offered = candidates(declared, part.ranges)
    findings = []
    for state in states:
        of_name = [
            c for c in offered if (c.name, c.state, c.contains_parents) == (name, state, False)
        ]
        found = of_name[-1].at(values)  # the last is between two bodies, if there are two
        columns = columns_of(found, declared)
        findings.append(Finding(found, columns, 1.0, 0.016, np.zeros(60), step=1))
    found = Found(declared, [record], part, RULES, ()).with_findings(findings)
    report = report_of(
        assembled(found, findings, [record], np.random.default_rng(0), finished=True)
    )
    return report, findings, with_findings(declared, findings)


def known(report, findings, design):
    return with_numbers_known(report, findings, design, RULES, np.random.default_rng(0))


@pytest.fixture(scope="module")
def gap():
    return reported(GAP.model, GAP.record(), "dead zone", [0.2])


@pytest.mark.parametrize(
    ("hidden", "name", "meaning", "truth"),
    [
        (GAP, "dead zone", "half width", 0.2),
        (STRIBECK, "Stribeck friction", "Stribeck speed", 0.3),
    ],
)
def test_the_interval_of_a_number_holds_it_and_the_others_allow_for_it(
    hidden, name, meaning, truth
):
    plain, findings, design = reported(hidden.model, hidden.record(), name, [truth])
    report = known(plain, findings, design)
    ((before,), (effect,)) = plain.effects, report.effects
    assert effect.numbers == {meaning: truth}
    ((low, high),) = effect.number_intervals
    assert 0.75 * truth < low < truth < high < 1.25 * truth
    (inner,), (outer,) = before.confidence_intervals, effect.confidence_intervals
    assert outer[0] < inner[0] < inner[1] < outer[1]
    for parameter, ends in plain.after.parameter_intervals.items():
        wide = report.after.parameter_intervals[parameter]
        assert wide[0] <= ends[0] < ends[1] <= wide[1]
    assert report.steps[-1].errors is report.after


def test_numbers_leave_a_coefficient_the_sign_that_it_has():
    ends = np.array([[1.0, 2.0], [-2.0, -1.0], [-1.0, 2.0]])
    wide = _with_sign_of(ends, ends + np.array([-3.0, 3.0]))
    assert wide.tolist() == [[0.0, 5.0], [-5.0, 0.0], [-4.0, 5.0]]


def test_numbers_are_said_in_every_form_of_the_report(gap, tmp_path):
    pytest.importorskip("jinja2")
    pytest.importorskip("matplotlib")
    report = known(*gap)
    report.to_html(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "   half width 0.2 (95 %: 0.1" in str(report)
    assert "- half width 0.2 (95 %: 0.1" in report.to_markdown()
    assert "<p>Half width 0.2 (95 %: 0.1" in page


@pytest.mark.parametrize(
    "unseen",
    [
        Candidate("evolved term", 1, (call(ROOT, mul(constant(2.0), variable(0))),)),
        "out of reach",
    ],
)
def test_a_number_that_the_record_shows_nothing_of_has_no_interval(gap, unseen):
    report, (finding,), design = gap
    there = finding.candidate.at([100.0]) if unseen == "out of reach" else unseen
    other = replace(finding, candidate=there, columns=columns_of(there, design))
    whole = design.dropping(finding.columns).adding(other.columns)
    (effect,) = known(report, [other], whole).effects
    assert np.isnan(effect.number_intervals).all()
    assert effect.confidence_intervals == pytest.approx(report.effects[0].confidence_intervals)
    (value,) = effect.numbers.values()
    assert f" {value:.4g}\n" in str(replace(report, effects=[effect]))


def test_an_effect_without_numbers_leaves_the_report_as_it_is(gap):
    report, (finding,), design = gap
    sine = Candidate("gravity", 1, (call(BUILTIN["sin"], variable(0)),))
    other = replace(finding, candidate=sine, columns=columns_of(sine, design))
    whole = design.dropping(finding.columns).adding(other.columns)
    assert known(report, [other], whole) is report


def test_a_number_that_two_equations_share_has_one_interval():
    gap = "30*(x - y - (abs(x - y + 0.2) - abs(x - y - 0.2))/2)"
    sides = {"x": "v", "v": f"F - 20*x - v - {gap}", "y": "w", "w": f"{gap} - 10*y - w"}
    lacking = {"x": "v", "v": "b*F - k*x - c*v", "y": "w", "w": "-n*y - d*w"}
    model = pse.DeclaredModel(lacking, inputs=["F"])
    one, other = known(*reported(model, measured(sides), "dead zone", [0.2], (1, 3))).effects
    assert one.number_intervals.tolist() == other.number_intervals.tolist()
    ((low, high),) = one.number_intervals
    assert 0.19 < low < 0.2 < high < 0.21
