"""Numbers that two equations share, such as the gap of a coupling, are tuned together."""

import numpy as np
import pytest
import sympy
from loop_systems import measured

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import Candidate, rewritten
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.effects.partners import (
    apart,
    are_partners,
    joined,
    partnerships,
    shared_effects,
    shares_number,
)
from pysindy_evolve.loop.evidence.findings import Finding, with_columns
from pysindy_evolve.loop.evidence.scoring import columns_of, tuned
from pysindy_evolve.loop.free_runs.contenders import Pool
from pysindy_evolve.loop.free_runs.one_for_one import exchanged_by_runs
from pysindy_evolve.loop.free_runs.shared_tuning import shared_by_runs
from pysindy_evolve.loop.free_runs.variants import Model
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.ranges import Ranges
from pysindy_evolve.loop.given.rules import Rules
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.revision.shared_numbers import with_shared_numbers
from pysindy_evolve.substitution import substituted
from pysindy_evolve.terms import mul, variable

RULES = Rules(significance=0.05, n_twins=59, min_share=0.05, max_effects=8)
GAP = 0.02
PULL = f"(a - b - 0.5*abs(a - b + {GAP}) + 0.5*abs(a - b - {GAP}))"
CLUTCH = {
    "a": "va",
    "va": f"F - 40*a - va - 100*{PULL} - 2*(va - vb)",
    "b": "vb",
    "vb": f"40*{PULL} + 0.8*(va - vb) - 0.5*vb",
}
WITHOUT_GAP = pse.DeclaredModel(
    {
        "a": "va",
        "va": "F - k0*a - c*va - k*(a - b) - d*(va - vb)",
        "b": "vb",
        "vb": "0.4*k*(a - b) + 0.4*d*(va - vb) - e*vb",
    },
    inputs=["F"],
)


def planted(effects, design):
    """Return effects as if they had been found one after the other."""
    return [
        Finding(one, columns_of(one, design), 1.0, 0.016, np.zeros(60), step=1 + k)
        for k, one in enumerate(effects)
    ]


def numbers(findings):
    return [finding.candidate.shape.values[0] for finding in findings]


@pytest.fixture(scope="module")
def clutch():
    """The record of two bodies with a gap between them, the design without it, the two effects."""
    record = measured(CLUTCH, duration=20.0, noise=5e-4, size=8.0)
    between = ("a", "b")
    design = design_of(WITHOUT_GAP, [record])
    places = {design.states.index(name) for name in between}
    found = candidates(design, segments([record]).ranges)
    gaps = [c for c in found if c.name == "dead zone" and c.variables == places]
    return record, design, [next(c for c in gaps if c.state == state) for state in (1, 3)]


def test_a_force_between_two_bodies_has_partners_of_any_number(clutch):
    _, design, (one, other) = clutch
    assert are_partners(one, other)
    assert are_partners(one, other.at([3.0]))
    assert not are_partners(one, one.at([3.0]))  # in one equation
    to_ground = next(
        c
        for c in candidates(design, Ranges.about_zero(np.ones(6)))
        if c.name == "dead zone" and c.state == 3 and len(c.variables) == 1
    )
    assert not are_partners(one, to_ground)
    assert partnerships([to_ground, one, other]) == [[1, 2]]
    assert shares_number(one.at([3.0]), other.at([3.0]))
    assert not shares_number(one.at([3.0]), other.at([2.0]))


def test_a_grip_is_shared_though_one_equation_divides_it_by_a_speed():
    slip = "(d - b - 1.2*r/V)"
    sides = {"b": f"a*{slip}/V - r", "r": f"e*{slip}"}
    design = pse.DeclaredModel(sides, inputs=["d", "V"]).design()
    low, high = np.array([-1.0, -1.0, -0.1, 3.0, 0.0]), np.array([1.0, 1.0, 0.1, 18.0, 9.0])
    ranges = Ranges.of(np.random.default_rng(0).uniform(low, high, (500, 5)))
    grips = [c for c in candidates(design, ranges) if len(c.variables) == 4 and c.shape]
    one, other = (next(c for c in grips if c.state == state) for state in (0, 1))
    assert one.terms != other.terms
    assert are_partners(one, other)
    assert shares_number(one.at([0.2]), other.at([0.2]))


def test_a_gap_is_found_along_both_equations_and_along_neither_of_them(clutch):
    record, design, (one, other) = clutch
    part = segments([record], design.velocities)
    findings = planted([one.at([1.5 * GAP]), other.at([1.47 * GAP])], design)
    for own, beside in (findings, reversed(findings)):
        alone = tuned(own.candidate, with_columns(design, [beside]), part)
        assert alone.shape.values[0] > 1.2 * GAP
    kept = with_shared_numbers(design, findings, part)
    assert numbers(kept) == pytest.approx([GAP, GAP], rel=0.02)
    assert shares_number(kept[0].candidate, kept[1].candidate)
    assert [f.columns for f in kept] == [columns_of(f.candidate, design) for f in kept]
    assert [(f.step, f.candidate.state) for f in kept] == [(1, 1), (2, 3)]


@pytest.mark.slow
def test_a_gap_that_equations_share_is_tuned_by_free_runs_and_kept_against_others(clutch):
    record, design, effects = clutch
    findings = planted([one.at([1.15 * GAP]) for one in effects], design)
    kept = shared_by_runs(Model(design), findings, [record])
    assert numbers(kept) == pytest.approx([GAP, GAP], rel=0.02)
    part = segments([record], design.velocities)
    held = exchanged_by_runs(Model(design), kept, Pool((), (), part, 0.05), [record], RULES)
    assert numbers(held) == numbers(kept)


def test_two_valves_that_saturate_at_two_places_keep_their_numbers():
    rates = {
        "x": "0.5*(abs(F + 8) - abs(F - 8)) - x",
        "y": "0.5*(abs(F + 20) - abs(F - 20)) - 2*y",
    }
    record = measured(rates, order=1, duration=20.0)
    model = pse.DeclaredModel({"x": "-k*x", "y": "-m*y"}, inputs=["F"])
    design = design_of(model, [record])
    found = candidates(design, segments([record]).ranges)
    one, other = (next(c for c in found if (c.name, c.state) == ("saturation", s)) for s in (0, 1))
    part = segments([record], design.velocities)
    apart = planted([one.at([8.0]), other.at([20.0])], design)
    assert are_partners(one, other)
    assert with_shared_numbers(design, apart, part) == apart
    assert numbers(shared_by_runs(Model(design), apart, [record])) == [8.0, 20.0]


@pytest.mark.slow
def test_a_gap_between_two_bodies_is_found_with_one_width_and_no_spring_inside():
    records = [measured(CLUTCH, duration=20.0, noise=5e-4, size=8.0, seed=10 * k) for k in range(2)]
    report = pse.close_loop(
        WITHOUT_GAP, records[:1], records[1:], operators=(), n_twins=59, random_state=0
    )
    found = {effect.state: effect for effect in report.effects}
    assert {state: effect.name for state, effect in found.items()} == dict.fromkeys(
        ("va", "vb"), "dead zone"
    )
    widths = {abs(float(n)) for e in report.effects for n in e.term.atoms(sympy.Float)} - {0.5, 1.0}
    assert list(widths) == pytest.approx([GAP], rel=0.02)
    assert found["va"].coefficients == pytest.approx([-100.0], rel=0.02)
    assert found["vb"].coefficients == pytest.approx([-40.0], rel=0.02)
    assert max(report.after.simulation_error) < 1.0


def test_two_terms_with_one_coefficient_are_not_one_term():
    """Two pumps of one make: what went with the first was sought in the equation of the second."""
    sides = {"A": "b*P - k*(A - B)", "B": "b*Q - m*B"}
    design = pse.DeclaredModel(sides, inputs=["P", "Q"]).design()
    ranges = Ranges.of(np.random.default_rng(0).uniform(1.0, 3.0, (500, 5)))
    assert shared_effects(design, candidates(design, ranges)) == []


@pytest.mark.parametrize(("rate_of_loss", "is_shared"), [("k", True), ("m", False)])
def test_what_changes_terms_with_one_coefficient_is_offered_in_all_their_equations(
    rate_of_loss, is_shared
):
    sides = {"A": "F - k*A*B", "B": f"c*F - {rate_of_loss}*A*B", "C": "k*A*B - d*C"}
    design = pse.DeclaredModel(sides, inputs=["F"]).design()
    ranges = Ranges.of(np.random.default_rng(0).uniform(1.0, 3.0, (500, 5)))
    names = (*design.names, "t")
    shared = shared_effects(design, candidates(design, ranges))
    found = {one.terms[0].name(names): [c.state for c in apart(one)] for one in shared}
    inhibited = next(states for name, states in found.items() if "A B/(" in name and "C" in name)
    assert inhibited == ([0, 1, 2] if is_shared else [0, 2])
    assert not any(name == "A^2" for name in found)  # it says nothing about the shared rate


def test_partners_are_rewritten_with_the_effect():
    """Beside probes the time has another number; the partner of a drift became something else."""
    here, there = (Candidate("drift", state, (mul(variable(0), variable(3)),)) for state in (0, 1))
    moved = rewritten(joined([here, there]), lambda term: substituted(term, {3: variable(7)}))
    wanted = mul(variable(0), variable(7))
    assert [one.terms for one in apart(moved)] == [(wanted,), (wanted,)]
