"""Effects with which a model runs away from its record are withdrawn."""

import numpy as np
import pytest
from loop_systems import equations_of, multisine, oscillator

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.evidence.findings import Finding, SensorFinding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.fitting.runs import simulation_errors
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.limits import Limit
from pysindy_evolve.loop.given.rules import Rules
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.search.found import Found
from pysindy_evolve.loop.settling import worse_runs
from pysindy_evolve.loop.settling.settle import settled
from pysindy_evolve.loop.settling.worse_runs import last_worsened, runs_away
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import call, constant, mul, power, variable

Q, V = variable(0), variable(1)
# A spring that yields, as no cubic one does: with a cubic one no force pulls back far outside.
YIELDING = oscillator("yielding spring", "+ 40*q - 15*tanh(q*40/15)", size=6.0)
LINEAR = equations_of({"q": "v", "v": "-30*q - 0.8*v + F"}, ("F",))
WILD = equations_of({"q": "v", "v": "-30*q - 0.8*v + F + 16*q**3"}, ("F",))


@pytest.fixture(scope="module")
def record():
    return YIELDING.record()


def findings_of(design, *candidates):
    return [Finding(c, columns_of(c, design), 1.0, 0.01, np.zeros(59)) for c in candidates]


def test_the_last_effect_that_changes_an_equation_is_named(record):
    design = design_of(YIELDING.model, [record])
    cubic, drag = (
        Candidate("cubic stiffness", 1, (power(Q, 3),)),
        Candidate("coupling", 1, (mul(Q, V),)),
    )
    first, last = findings_of(design, drag, cubic)
    clipped = SensorFinding(cubic, (), 1.0, 0.01, np.zeros(59), limit=Limit(0, 1.0, 100.0, True))
    assert last_worsened([first, last, clipped], LINEAR, WILD, [record]) is last
    assert last_worsened([first, last], LINEAR, LINEAR, [record]) is None
    assert last_worsened([first, last], WILD, WILD, [record]) is None
    assert last_worsened([clipped], LINEAR, WILD, [record]) is None


def test_the_declared_model_is_run_only_where_the_corrected_one_is_lost(record, monkeypatch):
    """A fit that lacks much may be wild, and its run take longer than all else."""

    def errors(equations, _):
        assert equations is LINEAR, "the declared model was run"
        return np.array([5.0])

    monkeypatch.setattr(worse_runs, "simulation_errors", errors)
    assert not runs_away(WILD, LINEAR, [record])


def test_an_effect_with_which_the_run_no_longer_follows_its_record_is_named(record):
    right = equations_of(YIELDING.truth, ("F",))
    slack = equations_of({"q": "v", "v": "-0.8*v + F"}, ("F",))  # drifts, not far
    miss, off = (simulation_errors(model, [record]).max() for model in (right, slack))
    assert miss < 50.0 < 100.0 < off < 1e4
    assert runs_away(right, slack, [record])
    assert not runs_away(slack, slack, [record])


@pytest.mark.parametrize(
    ("term", "is_kept"),
    [(power(Q, 3), False), (call(BUILTIN["tanh"], mul(constant(40.0 / 15.0), Q)), True)],
)
def test_only_what_drives_the_run_over_the_training_data_away_is_withdrawn(record, term, is_kept):
    train, test = record[: len(record) // 2], record[len(record) // 2 :]
    design, part = design_of(YIELDING.model, [train]), segments([train], (1,))
    rules, rng = Rules(0.05, 59, 0.05, 8), np.random.default_rng(0)
    found = Found(design, [train], part, rules, ())
    found = found.with_findings(findings_of(design, Candidate("spring", 1, (term,))))
    outcome = settled(found, [test], rng, finished=True)
    assert [effect.name for effect in outcome.effects] == ["spring"] * is_kept
    assert np.isfinite(outcome.after.simulation_error).all()


@pytest.mark.slow
def test_an_unstable_machine_that_a_controller_held_keeps_its_effect():
    t, rng = np.arange(0.0, 40.0, 0.01), np.random.default_rng(0)
    asked = multisine(20.0, 0)(t)
    held = equations_of({"q": "v", "v": "15*q - 0.8*v + R - 60*q - 6*v"}, ("R",))
    x = pse.simulate(held, [0.0, 0.0], t, asked)
    q = x[:, :1] + 1e-3 * x[:, 0].std() * rng.standard_normal((len(t), 1))
    record = pse.prepare(t, q, asked - x @ [60.0, 6.0])
    declared = pse.DeclaredModel({"q": "v", "v": "-c*v + b*F"}, inputs=["F"])
    report = pse.close_loop(declared, record, operators=(), random_state=0)
    assert report.after.simulation_error.min() > 1e6  # nobody holds the run
    assert [effect.name for effect in report.effects] == ["linear stiffness"]
    assert report.effects[0].coefficients[0] == pytest.approx(15.0, rel=0.01)


def test_a_machine_that_its_declared_model_follows_is_not_unstable(record):
    """An effect that makes it so is wrong; of one that no model follows nobody knows."""
    stable = equations_of(YIELDING.truth, ("F",))
    burst = equations_of({"q": "v", "v": "300*q - 0.8*v + F"}, ("F",))
    assert simulation_errors(stable, [record]).max() < 20.0
    assert runs_away(stable, burst, [record])
    assert not runs_away(LINEAR, burst, [record])
