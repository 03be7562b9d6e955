"""What a random walk shows as well is no effect of the time."""

import numpy as np
import pytest
from loop_systems import equations_of

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.evidence.findings import Finding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.facts.effect import Effect
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.settling.random_walks import last_wandering
from pysindy_evolve.terms import mul, power, variable

COOLING = equations_of({"T": "-0.1*T + 0.01*F"}, ("F",))
DECLARED = pse.DeclaredModel({"T": "-a*T + b*F"}, inputs=["F"])
TIME, SPAN = variable(2), 400.0


def cooled(slow, seed=0):
    """A record whose derivative has something slow in it, and noise."""
    rng, t = np.random.default_rng(seed), np.linspace(0.0, SPAN, 4000)
    x, u = rng.standard_normal((4000, 1)), rng.standard_normal((4000, 1))
    rates = COOLING.evaluate(x, u, t)[:, 0] + slow(t, rng) + 0.1 * rng.standard_normal(4000)
    return pse.Record(t=t, x=x, x_dot=rates[:, None], u=u)


def trend(t, rng):
    return 2e-4 * t


def walk(t, rng):
    steps = rng.standard_normal(len(t))
    return 0.08 * np.cumsum(steps) / np.sqrt(len(t))


def faint(t, rng):
    return walk(t, rng) / 4.0


def withdrawn(record, term=TIME):
    """Tell whether an effect is withdrawn that was fitted to a record of the model without it."""
    design = design_of(DECLARED, [record])
    candidate = Candidate("drift", 0, (term,))
    finding = Finding(candidate, columns_of(candidate, design), 1.0, 0.01, np.zeros(59))
    column = term.evaluate(np.column_stack([record.x, record.u, record.t]))
    left = (record.x_dot - COOLING.evaluate(record.x, record.u, record.t))[:, 0]
    left, centered = left - left.mean(), column - column.mean()
    slope = float(centered @ left / (centered @ centered))
    effect = Effect.__new__(Effect)
    object.__setattr__(effect, "coefficients", np.array([slope]))
    with_it = cooled_by(slope, term)
    return last_wandering([finding], [effect], with_it, [record], 0.05) is finding


def cooled_by(slope, term):
    design = pse.DeclaredModel({"T": "-0.1*T + 0.01*F"}, inputs=["F"]).design()
    known = Candidate("drift", 0, (term,))
    whole = design.adding(columns_of(known, design))
    return whole.equations([slope])


def test_a_trend_stays_and_most_walks_go():
    assert sum(withdrawn(cooled(trend, seed)) for seed in range(10)) <= 1
    assert sum(withdrawn(cooled(walk, seed)) for seed in range(10)) >= 8


def test_a_walk_too_faint_to_be_seen_in_the_noise_goes_too():
    """To the likelihood such a walk may be none, beside which each trend is more than noise."""
    assert sum(withdrawn(cooled(faint, seed)) for seed in range(20)) >= 18


def test_what_changes_faster_than_a_walk_is_not_asked():
    """A spring that drifts acts as often as the spring does."""
    fast = mul(TIME, variable(0))
    assert not any(withdrawn(cooled(walk, seed), fast) for seed in range(3))


def test_what_does_not_depend_on_the_time_is_not_asked():
    assert not any(withdrawn(cooled(walk, seed), power(variable(0), 2)) for seed in range(3))


def heated(seed):
    """Two bodies side by side, one of which is heated; their sensors wander by 0.1 K."""
    rng, n, dt = np.random.default_rng(seed), 2500, 5.0
    power_in = rng.choice([0.0, 20.0, 50.0, 80.0, 100.0], n // 120 + 1).repeat(120)[:n]
    sides = {
        "T1": "0.004*P - 0.01*(T1 - T2) - 0.002*(T1 - 22)",
        "T2": "0.004*(T1 - T2) - 0.003*(T2 - 22)",
    }
    fine = power_in.repeat(5)
    truth = equations_of(sides, ("P",))
    x = pse.simulate(truth, [22.0, 22.0], np.arange(len(fine)), fine[:, None])[::5]
    drifting = np.cumsum(0.002 * rng.standard_normal(x.shape), axis=0)
    y = x + 0.03 * rng.standard_normal(x.shape) + drifting
    return pse.prepare(dt * np.arange(n), y, power_in[:, None], order=1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_sensors_that_wander_leave_a_complete_model_complete(seed):
    declared = pse.DeclaredModel(
        {"T1": "b*P - k*(T1 - T2) - g*(T1 - Ta)", "T2": "h*(T1 - T2) - m*(T2 - Ta)"},
        inputs=["P"],
        known={"Ta": 22.0},
    )
    report = pse.close_loop(
        declared, heated(10 + seed), heated(50 + seed), operators=(), random_state=seed
    )
    assert [effect.name for effect in report.effects] == []
