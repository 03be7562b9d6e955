"""What an effect had to enter beside goes where it gains nothing, and stays where it does."""

import numpy as np
import pytest
from loop_systems import oscillator

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.evidence.findings import Finding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.revision.marginality import without_parents

ASYMMETRY = ("constant offset", "Coulomb friction", "asymmetric Coulomb friction")


def kept_of(names, term, declared="-k*q - c*v + b*F", **options):
    """Plant effects as found in a machine with a term, and look which of them stay."""
    hidden = oscillator("hidden", term, declared)
    record = hidden.record(noise=2e-3, **options)
    design = design_of(hidden.model, [record])
    part = segments([record], design.velocities)
    offered = candidates(design, part.ranges)
    planted = [next(c for c in offered if c.name == name) for name in names]
    findings = [
        Finding(c, columns_of(c, design), 1.0, 0.016, np.zeros(60), step)
        for step, c in enumerate(planted, start=1)
    ]
    return without_parents(design, findings, part)


def test_an_absolute_value_does_without_an_offset_and_a_friction_that_are_not_there():
    (damping,) = kept_of(ASYMMETRY, "- 0.6*abs(v)")
    assert damping.candidate.name == "nonlinear damping"  # no friction is left to be asymmetric
    assert damping.candidate.parents == ()
    assert damping.step == 3


def test_all_parents_stay_where_the_friction_is_there():
    kept = kept_of(ASYMMETRY, "- 2*sgn(v) + 0.6*abs(v)")
    assert [f.candidate.name for f in kept] == list(ASYMMETRY)


def test_a_load_may_pull_on_a_damper_that_is_stiffer_one_way():
    offset, damping = kept_of(ASYMMETRY, "+ 1.5 + 0.6*abs(v)")
    assert (offset.candidate.name, damping.candidate.name) == (
        "constant offset",
        "nonlinear damping",
    )
    assert damping.candidate.parents == offset.candidate.terms


def test_a_parent_that_another_effect_needs_stays():
    names = ("constant offset", "quadratic stiffness", "drift")
    kept = kept_of(names, "- 12*q^2 + 0.2*t", size=6.0)
    assert [f.candidate.name for f in kept] == list(names)


def test_a_friction_that_is_not_there_goes_where_the_offset_is_declared():
    names = ("Coulomb friction", "asymmetric Coulomb friction")
    kept = kept_of(names, "- 0.6*abs(v)", "-k*q - c*v + b*F + o")
    assert [f.candidate.name for f in kept] == ["nonlinear damping"]
    kept = kept_of(names, "- 2*sgn(v) + 0.6*abs(v)", "-k*q - c*v + b*F + o")
    assert [f.candidate.name for f in kept] == list(names)


@pytest.mark.slow
def test_a_damper_that_is_stiffer_one_way_is_one_effect():
    hidden = oscillator("damper", "- 0.6*abs(v)")
    report = pse.close_loop(hidden.model, hidden.record(noise=5e-3), n_twins=59, random_state=0)
    (effect,) = report.effects
    assert effect.name == "nonlinear damping"
    assert effect.coefficients == pytest.approx([-0.6], rel=0.03)
