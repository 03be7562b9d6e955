"""Inputs that are held between their samples: a property of the record, and no effect."""

import numpy as np
import pytest
from loop_systems import DT, equations_of, levitated, multisine, regulated
from scipy.integrate import solve_ivp

import pysindy_evolve as pse
from pysindy_evolve.hidden_states.memory import Memory
from pysindy_evolve.loop.given.held import held_like, held_where_it_may_be
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.memories.hold_or_memory import (
    hold_beside_another,
    holds_alone,
    memory_beside_hold,
)
from pysindy_evolve.signals.zero_order_hold import hold

STEP = 10.0  # sampling time of the oven
OVEN = pse.DeclaredModel({"T": "b*P - a*(T - 20)"}, inputs=["P"])


def oven(**truth):
    """Prepare the record of an oven."""
    return pse.prepare(*raw_oven(**truth), order=1)


def raw_oven(lag=0.0, delay=0.0, jump=0.0, seed=0):
    """Record an oven whose heater jumps some sampling times before the sample that shows it."""
    rng = np.random.default_rng(seed)
    power = np.repeat(rng.uniform(5.0, 35.0, 25), 60)
    n_fine = 20
    t = np.arange(power.size * n_fine) * STEP / n_fine
    sample = np.floor(t / STEP + jump + 1e-9).astype(int)
    heat = power[np.minimum(sample, power.size - 1)]
    if lag:
        heat = Memory("actuator lag", 0, (lag,)).response(t, heat)
    if delay:
        heat = np.interp(t - delay, t, heat)
    x = np.empty(t.size)
    x[0], decay = 50.0, np.exp(-0.004 * STEP / n_fine)
    for k in range(t.size - 1):
        rest = 20.0 + 0.006 * heat[k] / 0.004
        x[k + 1] = rest + (x[k] - rest) * decay
    y = x[::n_fine] + 0.02 * rng.standard_normal(power.size)
    return t[::n_fine], y, power


def close(declared, record, **options):
    settings = {"operators": (), "random_state": 0, "n_twins": 59} | options
    return pse.close_loop(declared, record, **settings)


@pytest.fixture(scope="module")
def report():
    """A loop on an oven that lacks nothing."""
    return close(OVEN, oven())


def test_an_input_that_jumps_and_acts_late_by_half_a_step_is_held(report):
    assert report.verdict == "complete"
    assert report.train[0].held == {0: 0.5}
    assert report.after.parameters["b"] == pytest.approx(0.006, rel=2e-3)
    assert "P is taken to be held from each sample to the next" in " ".join(str(report).split())


def test_what_the_user_said_to_be_held_is_no_news():
    record = pse.prepare(*raw_oven(), order=1, held=True)
    report = close(OVEN, record)
    assert report.train[0].held == {0: 0.5}
    assert "taken to be held" not in " ".join(str(report).split())


def test_a_run_over_a_raw_record_holds_its_inputs_as_well(report):
    record = oven()
    raw, known = (report.simulate(r) for r in (record, report.train[0]))
    assert raw[: len(known)] == pytest.approx(known, abs=1e-6)


@pytest.mark.parametrize(("jump", "held"), [(0.0, {0: 0.5}), (0.5, {})])
def test_the_declared_model_alone_is_judged_with_its_inputs_held(jump, held):
    """Or its errors would not be those that a search for effects prints of it."""
    report = close(OVEN, oven(jump=jump), max_effects=0)
    assert report.train[0].held == held
    assert report.before.simulation_error.max() < 0.2


def test_an_input_that_jumps_halfway_on_average_is_not_held():
    report = close(OVEN, oven(jump=0.5))
    assert report.verdict == "complete"
    assert not report.train[0].held


@pytest.mark.parametrize(
    ("kind", "truth"), [("actuator lag", {"lag": 90.0}), ("input delay", {"delay": 60.0})]
)
def test_what_is_behind_a_hold_is_found_with_its_own_time(kind, truth):
    report = close(OVEN, oven(**truth))
    assert [effect.name for effect in report.effects] == [kind]
    assert report.effects[0].coefficients == pytest.approx(list(truth.values()), rel=0.02)


@pytest.mark.parametrize(("lag", "left"), [(0.0, None), (5.0, pytest.approx(5.0, rel=0.02))])
def test_a_hold_that_passes_for_a_lag_is_a_hold_and_a_lag_behind_it_is_left(lag, left):
    seen = Memory("actuator lag", 0, (lag + 0.5 * STEP,))
    late, found = memory_beside_hold(seen, OVEN.design(), segments([oven(lag=lag)]))
    assert late == 0.5
    assert (found and found.values[0]) == left


@pytest.mark.parametrize(
    ("jump", "seen", "late"), [(0.0, 0.5, 0.5), (0.0, 0.501, 0.5), (0.3, 0.2, 0.2)]
)
def test_a_hold_begins_at_the_sample_unless_another_time_does_clearly_better(jump, seen, late):
    """Six hundredths of a sample too many took 3 % off what is known of a dryer in a draught."""
    memory = Memory("input delay", 0, (seen * STEP,))
    found = memory_beside_hold(memory, OVEN.design(), segments([oven(jump=jump)]))
    assert found == (pytest.approx(late, abs=1e-12), None)


def test_one_record_may_be_driven_smoothly_and_another_in_steps():
    rng = np.random.default_rng(0)

    def chirp(t):
        return 3.0 * np.sin(2 * np.pi * (0.1 * t + 0.02 * t**2))

    levels = 3.0 * rng.choice([-1.0, 1.0], 61)

    def steps(t):
        return levels[(t + 1e-9).astype(int)]

    def swing(force, dt, n):
        def rates(t, x):
            return [x[1], float(force(np.asarray(t))) - 0.7 * x[1] - 10.0 * x[0]]

        t = np.arange(n) * dt
        q = solve_ivp(rates, (0.0, t[-1]), [0.2, 0.0], t_eval=t, rtol=1e-7, max_step=dt / 2).y[0]
        return pse.prepare(t, q + 0.003 * rng.standard_normal(n), force(t))

    declared = pse.DeclaredModel({"q": "v", "v": "b*F - c*v - k*q"}, inputs=["F"])
    records = [swing(chirp, 0.005, 4000), swing(steps, 0.02, 3000)]
    late = Memory("input delay", 0, (0.009,))
    share, left = memory_beside_hold(late, declared.design(), segments(records))
    assert (share, left) == (0.5, None)
    held = [held_where_it_may_be(record, {0: share}) for record in records]
    assert [record.held for record in held] == [{}, {0: 0.5}]
    assert [held_like(record, held).held for record in records] == [{}, {0: 0.5}]


def test_a_smooth_input_is_not_held_by_its_look():
    t = np.arange(0.0, 40.0, DT)
    record = pse.prepare(t, np.sin(t), multisine(1.0, 0)(t), order=1)
    design = pse.DeclaredModel({"q": "b*F"}, inputs=["F"]).design()
    late = Memory("input delay", 0, (0.5 * DT,))
    assert memory_beside_hold(late, design, segments([record])) == (0.0, late)


@pytest.mark.parametrize(("share", "held"), [(0.5, True), (0.45, True), (0.2, False), (2.0, False)])
@pytest.mark.parametrize("kind", ["input delay", "actuator lag"])
def test_half_a_sample_is_a_hold_where_nobody_knows_the_raw_input(kind, share, held):
    """A user's own low-pass has taken off the jumps that would show it."""
    t = np.arange(0.0, 40.0, DT)
    record = pse.Record(t=t, x=np.sin(t), x_dot=np.cos(t), u=multisine(1.0, 0)(t))
    design = pse.DeclaredModel({"q": "b*F"}, inputs=["F"]).design()
    late = Memory(kind, 0, (share * DT,))
    found = memory_beside_hold(late, design, segments([record]))
    assert found == ((0.5, None) if held else (0.0, late))
    assert held_where_it_may_be(record, {0: 0.5}).held == {0: 0.5}


def test_an_input_is_held_only_once():
    record = hold(oven(), {0: 0.1})
    late = Memory("input delay", 0, (0.3 * STEP,))
    assert memory_beside_hold(late, OVEN.design(), segments([record])) == (0.0, late)


def driven(delay, friction=0.0):
    """Record an oscillator whose smooth force acts some sampling times later."""
    truth = equations_of({"q": "v", "v": f"-40*q - 0.8*v + F - {friction}*sgn(v)"}, ("F",))
    fine, force = np.arange(0.0, 25.0, DT / 10), multisine(20.0, 0)
    x = pse.simulate(truth, [0.0, 0.0], fine, force(fine - delay * DT), tolerance=1e-8)
    q = x[::10, 0]
    q = q + 2e-3 * q.std() * np.random.default_rng(1).standard_normal(q.shape)
    return pse.prepare(fine[::10], q, force(fine[::10]))


OSCILLATOR = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])


@pytest.mark.slow
def test_half_a_sample_alone_is_a_hold():
    report = close(OSCILLATOR, driven(0.5))
    assert report.verdict == "complete"
    assert report.train[0].held == {0: pytest.approx(0.5, abs=0.05)}
    assert (
        report.after.simulation_error[0]
        < 0.5 * close(OSCILLATOR, driven(0.5), max_effects=0).after.simulation_error[0]
    )


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0.8, 1.5])
def test_another_share_of_a_sample_is_a_delay(delay):
    report = close(OSCILLATOR, driven(delay))
    assert [effect.name for effect in report.effects] == ["input delay"]
    assert report.effects[0].coefficients[0] == pytest.approx(delay * DT, rel=0.05)


@pytest.mark.slow
def test_beside_an_effect_half_a_sample_is_named_and_explained():
    report = close(OSCILLATOR, driven(0.5, friction=2.0))
    assert {effect.name for effect in report.effects} == {"Coulomb friction", "input delay"}
    assert "The input delay of F is half a sampling time" in " ".join(str(report).split())


@pytest.mark.slow
def test_in_a_closed_loop_a_held_input_is_neither_delay_nor_damping():
    # Half a sample is shorter than all that is tried first; a damping comes close to it.
    declared = pse.DeclaredModel({"z": "v", "v": "g - C*i**2/z**2"}, inputs=["i"])
    record = levitated(7, held=True)
    report = pse.close_loop(declared, record, operators=(), random_state=0)
    assert report.verdict == "complete"
    assert report.train[0].held == {0: pytest.approx(0.5, abs=0.02)}


@pytest.mark.slow
@pytest.mark.parametrize("n_steps", [8, 60])  # a short record, and one that is not
@pytest.mark.parametrize(("is_held", "found"), [(True, {0: 0.5}), (False, {})])
def test_a_controller_that_answers_noise_is_seen_to_hold_its_output(is_held, found, n_steps):
    declared = pse.DeclaredModel({"q": "v", "v": "b*M - c*v"}, inputs=["M"])
    report = close(declared, regulated(is_held, n_steps))
    assert report.verdict == "complete"
    assert report.train[0].held == found
    low, high = report.after.parameter_intervals["c"]
    assert low < 0.8 < high


@pytest.mark.parametrize("is_held", [True, False])
def test_a_hold_that_a_missing_damping_hides_shows_beside_it(is_held):
    """Half a sample late, what the controller answers drives as much as the damping brakes."""
    record = regulated(is_held, 8)
    design = pse.DeclaredModel({"q": "v", "v": "b*M"}, inputs=["M"]).design()
    part, held = segments([record]), segments([hold(record, {0: 0.5})])
    assert holds_alone(design, part) == {}
    assert hold_beside_another(0, design, part, held) is is_held
