"""What only free runs show: hidden vessels, brims and limits, and that they are silent else."""

from dataclasses import replace

import numpy as np
import pytest
from loop_systems import equations_of, measured, multisine

import pysindy_evolve as pse
from pysindy_evolve.hidden_states.memory import Memory, with_memories_applied
from pysindy_evolve.hidden_states.memory_equations import with_memories
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.evidence.findings import Finding, LimitFinding, MemoryFinding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.fitting.past import with_estimated_past
from pysindy_evolve.loop.fitting.runs import free_run
from pysindy_evolve.loop.free_runs.drift import drift_of
from pysindy_evolve.loop.free_runs.judging import matters, share_of_miss
from pysindy_evolve.loop.free_runs.memory_tuning import tuned_memories
from pysindy_evolve.loop.free_runs.named_effects import find_by_runs
from pysindy_evolve.loop.free_runs.state_limits import drift_from
from pysindy_evolve.loop.free_runs.variants import Model
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.design import in_state
from pysindy_evolve.loop.given.limits import limited, limits_of
from pysindy_evolve.loop.given.resampling import widened
from pysindy_evolve.loop.given.rules import Rules
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.revision.revise import prune
from pysindy_evolve.simulation.pieces import simulate_pieces
from pysindy_evolve.terms import power, variable

RULES = Rules(0.05, 99, 0.05, 3)
TANK = pse.DeclaredModel({"h": "k1*u - k2*sqrt(h)"}, inputs=["u"])
DT = 5.0
FINE = 20  # steps in each sample of the truth


def inflow(t, seed):
    """A pump that swings slowly about its mean and never runs backwards."""
    return np.clip(3.0 + multisine(1.2, seed, band=(0.02, 2.5))(t / 200.0), 0.3, None)


def tanks(seed, upper=None, walk=0.0, noise=0.02, clip=np.inf, n=900):
    """Level of a tank that is fed through an upper one, or at once where there is none.

    `walk` is the size of the steps of an unmeasured inflow, relative to the mean of the measured.
    """
    rng = np.random.default_rng(seed)
    fine = np.arange(n * FINE) * DT / FINE
    u = inflow(fine, seed)
    acts = u if upper is None else Memory("hidden state", 0, upper).response(fine, u)
    disturbed = np.repeat(3.0 * walk * np.cumsum(rng.standard_normal(n)), FINE)
    h, levels = 6.0, np.empty(n)
    for k, arriving in enumerate(acts + disturbed):
        if k % FINE == 0:
            levels[k // FINE] = h
        h = max(h + DT / FINE * (0.02 * arriving - 0.024 * np.sqrt(h)), 0.0)
    y = np.minimum(levels + noise * rng.standard_normal(n), clip)
    return pse.prepare(fine[::FINE], y, u[::FINE], order=1)


def found_in(record, declared=TANK, **options):
    """What the runs show, with the sign of everything drawn from one seed."""
    design = design_of(declared, [record])
    rules = Rules(significance=0.05, n_twins=59, min_share=0.05, max_effects=8)
    rng = np.random.default_rng(options.get("seed", 0))
    look, _ = find_by_runs(design, [], [record], widened([record]), rules, rng)
    return list(look.found)


@pytest.mark.slow
def test_hidden_vessel_is_found_with_its_time_constant():
    (finding, *_) = found_in(tanks(1, upper=(40.0,), noise=0.1))
    assert isinstance(finding, MemoryFinding)
    assert finding.memory.kind == "hidden state"
    assert finding.memory.values[0] == pytest.approx(40.0, rel=0.15)


AXIS = pse.DeclaredModel({"q": "v", "v": "b*F - c*v"}, inputs=["F"])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lacking", "name"),
    [("- 0.15*v*abs(v)", "quadratic drag"), ("- 0.4*sgn(v)", "Coulomb friction")],
)
def test_what_position_noise_hides_in_the_derivative_shows_in_the_runs(lacking, name):
    truth = {"q": "v", "v": f"F - 0.5*v {lacking}"}
    (finding, *rest) = found_in(measured(truth, noise=0.02, size=4.0, duration=60.0), AXIS)
    assert (finding.candidate.name, finding.by_runs, rest) == (name, True, [])


def test_a_complete_axis_under_as_much_noise_lacks_nothing():
    truth = {"q": "v", "v": "F - 0.5*v"}
    assert found_in(measured(truth, noise=0.02, size=4.0, duration=60.0), AXIS) == []


@pytest.mark.parametrize("seed", range(2))
def test_what_a_regulator_answers_to_is_no_effect_of_the_input(seed):
    assert found_in(regulated(seed), AXIS) == []


def regulated(seed):
    """An axis whose input fights a random force that nobody measured."""
    dt, n = 0.01, 6000
    rng = np.random.default_rng(seed)
    wish = multisine(0.5, seed)(np.arange(n) * dt)
    push = np.zeros(n)
    for k in range(1, n):
        push[k] = 0.98 * push[k - 1] + 0.2 * rng.standard_normal()
    q, v, rows = 0.0, 0.0, []
    for k in range(n):
        seen = q + 0.002 * rng.standard_normal()
        force = 30.0 * (wish[k] - seen) - 8.0 * v
        rows.append((seen, force))
        v += dt * (force + push[k] - 0.5 * v)
        q += dt * v
    seen, force = np.array(rows).T
    return pse.prepare(np.arange(n) * dt, seen, force)


@pytest.mark.slow
def test_brim_of_a_hidden_vessel_is_found():
    truth = (40.0, 12.0, 1.0)
    (finding, *_) = found_in(tanks(2, upper=truth, noise=0.1))
    assert finding.memory.kind == "hidden state"
    assert finding.memory.values == pytest.approx(truth, rel=0.25)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_single_tank_that_an_unmeasured_inflow_disturbs_has_nothing_hidden(seed):
    assert found_in(tanks(seed, walk=0.003)) == []
    assert found_in(tanks(seed + 10)) == []


def test_readings_that_stop_at_a_value_show_a_limit():
    assert limits_of([tanks(1)]) == []
    (limit,) = limits_of([tanks(1, clip=8.0)])
    assert (limit.state, limit.value, limit.upper) == (0, 8.0, True)


def test_rest_of_a_coarse_sensor_is_no_limit():
    record = tanks(1, noise=0.0)
    coarse = np.round(np.minimum(record.preparation.y, 7.0) / 0.25) * 0.25
    again = pse.prepare(record.preparation.t, coarse, record.preparation.u, order=1)
    assert limits_of([again]) == []


def test_what_only_free_runs_showed_is_not_pruned_by_the_derivative():
    record = tanks(1, clip=8.0)
    design = design_of(TANK, [record])
    (limit,) = limits_of([record])
    candidate = Candidate("saturation", 0, (limit.term,))
    found = LimitFinding(candidate, (), 30.0, 0.001, np.zeros(3), by_runs=True, limit=limit)
    assert prune(design, [found], segments([record])) == [found]


def test_limited_state_stays_at_its_limit_and_leaves_it_again():
    record = tanks(1, clip=8.0)
    limits = limits_of([record])
    design = limited(design_of(TANK, [record]), limits)
    t = np.arange(0.0, 600.0, DT)
    u = np.where(t < 300.0, 6.0, 0.5)[:, None]
    run = pse.simulate(design.equations([0.02, 0.024]), [6.0], t, u)
    # What still flows in lifts it by inflow over rate.
    assert run[t < 300.0].max() == pytest.approx(8.0, abs=0.02 * 6.0 * DT)
    assert run[-1] < 5.0


def test_vessel_with_a_brim_follows_its_printed_equations():
    memory = Memory("hidden state", 0, (0.5, 15.0, 0.7))
    t = np.arange(0.0, 20.0, 0.01)
    u = (4.0 + 2.0 * np.sin(2.0 * t))[:, None]
    plain = equations_of({"x": "-x + F"}, ("F",))
    full = with_memories(plain, [memory])
    run = pse.simulate(full, [1.0], t, u)
    direct = pse.simulate(plain, [1.0], t, memory.response(t, u[:, 0])[:, None])
    assert run[:, 0] == pytest.approx(direct[:, 0], rel=0.01)
    assert run[:, 1].max() == pytest.approx(15.0, rel=0.01)
    assert np.ptp(memory.response(t, u[:, 0]) ** 2) > 1.0


def test_pieces_run_as_one_simulation_of_each_model_does():
    t = np.arange(0.0, 5.0, 0.05)
    u = np.sin(2.0 * t)[:, None]
    model = equations_of({"q": "v", "v": "-4*q - 0.3*v - 0.5*sgn(v) + F"}, ("F",))
    coef = np.stack([model.coef, model.coef * np.array([[1.0], [0.8]])])
    starts = np.array([[0.5, 0.0], [0.1, 1.0]])
    both = simulate_pieces(model, coef, starts, np.stack([t, t]), np.stack([u, u]))
    for run, one, start in zip(both, coef, starts, strict=True):
        expected = pse.simulate(replace(model, coef=one), start, t, u)
        assert run == pytest.approx(expected, abs=2e-3)


@pytest.mark.slow
def test_report_names_vessel_and_limit_and_prints_the_hidden_state():
    record = tanks(3, upper=(40.0,), noise=0.1, clip=8.0, n=1200)
    report = pse.close_loop(TANK, record, operators=(), random_state=0)
    names = [effect.name for effect in report.effects]
    assert names[0] == "hidden state"
    assert report.equations.states == ("h", "u_level")
    assert report.after.simulation_error[0] < 0.5 * report.before.simulation_error[0]
    assert "time constant" in str(report)
    assert "time constant" in report.to_markdown()
    assert report.simulate(report.test[0]).shape == (len(report.test[0]), 2)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_input_of_a_closed_loop_has_no_memory(seed):
    """The input answers what disturbs the output, so the runs would like a memory."""
    rng, dt, n, fine = np.random.default_rng(seed), 0.02, 2000, 20
    reference = multisine(0.2, seed)(np.arange(n * fine) * dt / fine)
    disturbance, q, v = 0.0, 0.0, 0.0
    y, u = np.empty(n), np.empty(n)
    for k, wanted in enumerate(reference):
        force = 60.0 * (wanted - q)
        if k % fine == 0:
            y[k // fine], u[k // fine] = q + 0.004 * rng.standard_normal(), force
            disturbance += -0.01 * disturbance + 0.56 * rng.standard_normal()
        v += dt / fine * (-40.0 * q - 0.8 * v + force + disturbance)
        q += dt / fine * v
    declared = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
    found = found_in(pse.prepare(np.arange(n) * dt, y, u), declared)
    assert not [f for f in found if isinstance(f, MemoryFinding | LimitFinding)]


def cut_tanks(seed, skip=150):
    """Level of a tank behind a hidden vessel, recorded from the middle; what acted there."""
    n, upper = 750, Memory("hidden state", 0, (40.0,))
    fine = np.arange((n + skip) * FINE) * DT / FINE
    u = inflow(fine, seed)
    acts, levels, h = upper.response(fine, u), np.empty(n + skip), 6.0
    for k, arriving in enumerate(acts):
        if k % FINE == 0:
            levels[k // FINE] = h
        h += DT / FINE * (0.02 * arriving - 0.024 * np.sqrt(h))
    y = levels + 0.05 * np.random.default_rng(seed).standard_normal(n + skip)
    record = pse.prepare(fine[::FINE][skip:], y[skip:], u[::FINE][skip:], order=1)
    return record, float(acts[skip * FINE])


@pytest.mark.parametrize("seed", [1, 3])
def test_what_came_before_a_record_is_tuned_with_the_vessel(seed):
    record, acted = cut_tanks(seed)
    first = float(record.preparation.u[0, 0])
    assert abs(first - acted) > 0.3  # else a start in balance would do
    design = design_of(TANK, [record])
    model = Model(design, (Memory("hidden state", 0, (25.0,)),))
    drift = drift_of(Model(design), np.array([0.02, 0.024]), [record])
    found = tuned_memories(drift, model)
    assert found.pasts[0][0] == pytest.approx(acted, abs=0.15)
    assert found.memories[0].values[0] == pytest.approx(40.0, rel=0.2)


@pytest.mark.parametrize("seed", [1, 3])
def test_a_run_begins_with_the_hidden_state_that_the_first_rows_show(seed):
    record, acted = cut_tanks(seed)
    design = design_of(TANK, [record])
    truth = with_memories(design.equations([0.02, 0.024]), [Memory("hidden state", 0, (40.0,))])
    found = with_estimated_past(truth, record)
    assert float(found.preparation.u[0, 0]) == pytest.approx(acted, abs=0.3)
    assert np.array_equal(found.preparation.u[1:], record.preparation.u[1:])
    away = free_run(truth, record)[:, 0] - record.x[:, 0]
    acted = with_memories_applied(record, truth.memories)
    balanced = free_run(truth.inner, acted)[:, 0] - record.x[:, 0]
    assert np.sqrt(np.mean(away**2)) < 0.5 * np.sqrt(np.mean(balanced**2))


def test_a_record_that_begins_in_balance_stays_as_it_is():
    record = tanks(1, upper=(40.0,))
    design = design_of(TANK, [record])
    truth = with_memories(design.equations([0.02, 0.024]), [Memory("hidden state", 0, (40.0,))])
    assert with_estimated_past(truth, record) is record
    assert with_estimated_past(truth.inner, record) is record


def test_a_lag_shorter_than_a_sample_has_no_past_to_find():
    record = tanks(1, upper=(40.0,))
    design = design_of(TANK, [record])
    short = with_memories(design.equations([0.02, 0.024]), [Memory("hidden state", 0, (0.1 * DT,))])
    assert with_estimated_past(short, record) is record


@pytest.mark.parametrize("score", [0.1, 2.0])
@pytest.mark.parametrize("known", [True, False])
def test_a_term_must_matter_to_the_declared_model_or_halve_what_is_left(known, score):
    record = measured({"q": "v", "v": "-40*q - 0.8*v - 60*q^3 + F"})
    model = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
    design = design_of(model, [record])
    cubic = in_state("cubic stiffness", power(variable(0), 3), 1, 2)
    drift = drift_from(Model(design.adding([cubic]) if known else design), [record])
    tiny = Candidate("nonlinear damping", 1, (power(variable(1), 3),))
    finding = Finding(tiny, columns_of(tiny, design), score, 0.003, np.zeros(9), by_runs=True)
    share, removed = share_of_miss(finding, design, drift), 1.0 - np.exp(-score)
    if known:
        assert share < RULES.min_share
    else:
        assert share == pytest.approx(removed, rel=1e-3)
    assert matters(finding, share, RULES) == (score > 1.0 or not known)
