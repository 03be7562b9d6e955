"""Memories of inputs: what acts, how it is found beside other effects, and how it is reported."""

from dataclasses import replace

import numpy as np
import pytest
import sympy
from loop_systems import DT, equations_of, multisine

import pysindy_evolve as pse
from pysindy_evolve.hidden_states.memory import Memory, with_memories_applied
from pysindy_evolve.hidden_states.memory_equations import MemoryEquations, with_memories
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.memories.length_and_kind import settled_memory
from pysindy_evolve.loop.memories.probes import Probes

T = np.arange(0.0, 20.0, 0.01)
OSCILLATOR = {"q": "v", "v": "-40*q - 0.8*v + F"}
DECLARED = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])


def record_with(memory, friction=0.0, noise=2e-3, seed=0, duration=25.0):
    """Record a driven oscillator whose force goes through a memory before it acts."""
    sides = OSCILLATOR | {"v": OSCILLATOR["v"] + f" - {friction}*sgn(v)"}
    fine = np.arange(0.0, duration, DT / 10)
    force = multisine(20.0, seed)
    acts = force(fine) if memory is None else memory.response(fine, force(fine))
    x = pse.simulate(equations_of(sides, ("F",)), [0.0, 0.0], fine, acts, tolerance=1e-8)
    q = x[::10, 0]
    q = q + noise * q.std() * np.random.default_rng(seed + 1000).standard_normal(q.shape)
    return pse.prepare(fine[::10], q, force(fine[::10]))


def close(record, declared=DECLARED, **options):
    settings = {"operators": (), "random_state": 0, "n_twins": 59} | options
    return pse.close_loop(declared, record, **settings)


def test_beside_probes_the_same_equations_may_lack_something():
    """Also one such as q' = v that the records contradict."""
    design = replace(DECLARED.design(), doubted=(0,))
    widened = Probes(design, (Memory("input delay", 0, (0.01,)),)).widened(design)
    assert widened.inputs == ("F", "probe0")
    assert widened.open_states == design.open_states == (0, 1)


def test_delayed_sine_is_the_sine_of_an_earlier_time():
    delayed = Memory("input delay", 0, (0.0137,)).response(T, np.sin(3 * T))
    assert delayed[10:] == pytest.approx(np.sin(3 * (T[10:] - 0.0137)), abs=1e-6)


def test_lag_follows_a_ramp_by_its_time_constant():
    lagging = Memory("actuator lag", 0, (0.5,)).response(T, 2.0 * T)
    assert lagging[-1] == pytest.approx(2.0 * (T[-1] - 0.5))


def test_lag_of_a_fast_sine_is_that_of_the_sine_and_not_of_straight_lines():
    t, time_constant, frequency = np.arange(0.0, 4.0, 0.01), 0.02, 12.0
    omega = 2.0 * np.pi * frequency
    shown = Memory("actuator lag", 0, (time_constant,)).response(t, np.sin(omega * t))
    turn, size = np.arctan(omega * time_constant), np.hypot(1.0, omega * time_constant)
    exact = np.sin(omega * t - turn) / size
    assert np.abs(shown - exact)[50:-50].max() < 0.005 / size


def test_lag_far_shorter_than_a_sample_changes_nothing():
    u = np.sin(3 * T)
    assert Memory("actuator lag", 0, (1e-6,)).response(T, u) == pytest.approx(u, abs=1e-5)


def test_vessel_passes_on_a_steady_inflow():
    inflow = np.where(T < 1.0, 4.0, 9.0)
    out = Memory("hidden state", 0, (0.05,)).response(T, inflow)
    assert out[0] == pytest.approx(4.0)
    assert out[-1] == pytest.approx(9.0, rel=1e-3)


@pytest.mark.parametrize("kind", ["input delay", "actuator lag", "hidden state"])
def test_simulated_equations_with_memory_agree_with_the_response(kind):
    memory = Memory(kind, 0, (0.3,))
    u = 5.0 + np.sin(2 * T)
    plain = equations_of({"x": "-x + F"}, ("F",))
    full = with_memories(plain, [memory])
    run = pse.simulate(full, [1.0], T, u)
    expected = pse.simulate(plain, [1.0], T, memory.response(T, u))
    assert run.shape == (len(T), 1 if kind == "input delay" else 2)
    assert run[:, 0] == pytest.approx(expected[:, 0], abs=2e-4)


def test_equations_with_memory_are_written_with_hidden_states_and_earlier_times():
    plain = equations_of({"x": "-x + F*G"}, ("F", "G"))
    memories = [Memory("input delay", 0, (0.25,)), Memory("actuator lag", 1, (0.5,))]
    full = with_memories(plain, memories)
    assert full.states == ("x", "G_lag")
    x, lag, G, t = (sympy.Symbol(name, real=True) for name in ("x", "G_lag", "G", "t"))
    earlier = sympy.Function("F", real=True)(t - 0.25)
    first, second = full.to_sympy()
    assert sympy.expand(first - (earlier * lag - x)) == 0
    assert sympy.expand(second - (2.0 * G - 2.0 * lag)) == 0


def test_equations_without_memory_stay_as_they_are():
    plain = equations_of({"x": "-x + F"}, ("F",))
    assert with_memories(plain, []) is plain


def test_record_without_hidden_states_is_evaluated_in_time_order():
    plain = equations_of({"x": "-x + F"}, ("F",))
    memory = Memory("actuator lag", 0, (0.5,))
    full = with_memories(plain, [memory])
    assert isinstance(full, MemoryEquations)
    x, u = np.cos(T)[:, None], np.sin(T)[:, None]
    acts = memory.response(T, u[:, 0])[:, None]
    assert full.evaluate(x, u, T) == pytest.approx(plain.evaluate(x, acts))


def test_memory_of_a_part_knows_the_input_before_it():
    q = np.sin(T)
    record = pse.prepare(T, q, np.cos(2 * T), cutoff=5.0)
    memory = Memory("actuator lag", 0, (2.0,))
    whole = with_memories_applied(record, [memory])
    part = with_memories_applied(record[300:], [memory])
    assert part.u == pytest.approx(whole[300:].u)


@pytest.mark.slow
@pytest.mark.parametrize(
    "memory",
    [Memory("input delay", 0, (0.004,)), Memory("actuator lag", 0, (0.05,))],
    ids=lambda memory: memory.kind,
)
def test_memory_is_found_with_its_value_and_both_errors_fall(memory):
    report = close(record_with(memory))
    (effect,) = report.effects
    assert effect.name == memory.kind
    assert effect.state == "v"
    assert effect.coefficients == pytest.approx(memory.values, rel=0.02)
    low, high = effect.confidence_intervals[0]
    assert low < effect.coefficients[0] < high < 1.1 * memory.values[0]
    assert report.after.derivative_error[1] < 0.3 * report.before.derivative_error[1]
    assert np.all(report.after.simulation_error < 0.2 * report.before.simulation_error)
    assert f"{memory.values[0]:.2g}"[:4] in str(report)


@pytest.mark.slow
def test_a_delay_that_no_sindy_model_holds_is_told_and_rounded_where_it_is_printed():
    report = close(record_with(Memory("input delay", 0, (0.0123456,))))
    with pytest.warns(UserWarning, match=r"takes F as it was 0\.0123\d* earlier\. Shift the input"):
        assert report.model.feature_names == ["q", "v", "F"]
    assert "F(t - 0.012)" in str(pse.to_sympy(report, digits=2))
    assert pse.to_code(report, language="c").startswith("// F acts late: give F(t - 0.0123")
    assert pse.to_code(report, language="python").startswith("# F acts late: give F(t - 0.0123")
    assert "delay(F, 0.0123" in pse.to_code(report, language="modelica")


def test_lag_is_a_state_of_the_reported_model():
    report = close(record_with(Memory("actuator lag", 0, (0.1,))))
    assert report.equations.states == ("q", "v", "F_lag")
    assert report.model.feature_names == ["q", "v", "F_lag", "F"]
    run = report.simulate(report.test[0])
    assert run.shape == (len(report.test[0]), 3)
    assert run[:, 0] == pytest.approx(report.test[0].x[:, 0], abs=0.02 * np.ptp(run[:, 0]))
    assert report.residual_after[0].shape == report.test[0].x.shape


@pytest.mark.slow
def test_delay_and_friction_are_found_together():
    report = close(record_with(Memory("input delay", 0, (0.01,)), friction=2.0))
    found = {effect.name: effect for effect in report.effects}
    assert set(found) == {"input delay", "Coulomb friction"}
    assert found["input delay"].coefficients[0] == pytest.approx(0.01, rel=0.03)
    assert found["Coulomb friction"].coefficients[0] == pytest.approx(-2.0, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_no_memory_is_named_where_the_input_acts_at_once(seed):
    noise = (2e-3, 2e-2)[seed % 2]
    assert close(record_with(None, noise=noise, seed=seed)).verdict == "complete"


def test_a_delay_is_found_from_where_a_vessel_was_the_best_of_the_grid():
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 1500.0)
    steps = np.repeat(rng.uniform(0.0, 10.0, 30), 50)
    truth = equations_of({"T": "0.06*F - 0.02*(T - 15)"}, ("F",))
    late = Memory("input delay", 0, (7.0,)).response(t, steps)
    x = pse.simulate(truth, [15.0], t, late)
    record = pse.prepare(t, x + 0.005 * x.std() * rng.standard_normal(x.shape), steps, order=1)
    model = pse.DeclaredModel({"T": "b*F - a*(T - 15)"}, inputs=["F"])
    design, part = model.design(), segments([record])
    short = Memory("hidden state", 0, (0.4,))  # far shorter than the delay is, in its own units
    tuned, _ = settled_memory(short, design, part, 0.01, rng)
    assert tuned.kind == "input delay"
    assert tuned.values == pytest.approx((7.0,), rel=0.02)


@pytest.mark.slow
def test_memories_that_cannot_be_told_apart_get_a_proposal_too():
    report = close(record_with(Memory("actuator lag", 0, (0.006,)), noise=0.01))
    (effect,) = report.effects
    assert effect.alternatives
    plan = " ".join(str(report.suggest_experiment(units={"t": "s"})).split())
    assert plan.startswith(f"1. {effect.name} or {effect.alternatives[0]}")
    assert "sampled much faster than the 0.00" in plan


@pytest.mark.slow
def test_a_lag_of_an_input_that_is_known_is_found_in_a_model_without_parameters():
    truth = Memory("actuator lag", 0, (0.2,))
    record = record_with(truth)
    sides = {"q": "v", "v": "-40*q - 0.8*v + F"}
    report = close(record, pse.DeclaredModel(sides, inputs=["F"]))
    assert report.effects[0].name == "actuator lag", str(report)
    assert report.effects[0].coefficients == pytest.approx([0.2], rel=0.02)


@pytest.mark.slow
def test_a_delay_beside_a_spring_is_tuned_with_it_and_needs_no_lag():
    fine, force = np.arange(0.0, 25.0, DT / 10), multisine(20.0, 0)
    truth = equations_of({"q": "v", "v": "-40*q - 0.8*v + F - 30*q**3"}, ("F",))
    late = Memory("input delay", 0, (0.013,)).response(fine, force(fine))
    q = pse.simulate(truth, [0.0, 0.0], fine, late, tolerance=1e-8)[::10, 0]
    q = q + 3e-3 * q.std() * np.random.default_rng(1).standard_normal(q.shape)
    report = close(pse.prepare(fine[::10], q, force(fine[::10])))
    found = {effect.name: effect.coefficients[0] for effect in report.effects}
    assert set(found) == {"cubic stiffness", "input delay"}
    assert found["input delay"] == pytest.approx(0.013, rel=0.03)
