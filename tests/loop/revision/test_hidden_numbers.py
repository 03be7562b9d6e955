"""Hysteresis in equations of motion: a state that runs begin with, and how it is found."""

import numpy as np
import pytest
from loop_systems import multisine
from scipy.integrate import solve_ivp

import pysindy_evolve as pse
from pysindy_evolve.hidden_states.boucwen import BOUC_WEN, yielding_along
from pysindy_evolve.hidden_states.memory_equations import with_memories
from pysindy_evolve.loop.effects.hysteresis import remembered_ways
from pysindy_evolve.loop.fitting.past import first_state
from pysindy_evolve.loop.fitting.trial import Trial, converged
from pysindy_evolve.loop.fitting.unfolding import records_with_hidden_states, with_hidden_states
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.twins.twins import TwinMaker

DECLARED = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
STRENGTH, LENGTH, UNLOADING = 0.6, 0.1, 0.5
TRUE = pse.DeclaredModel(
    {"q": "v", "v": f"-k*q - c*v + b*F - s*bouc_wen(q, v, {LENGTH}, {UNLOADING})"},
    inputs=["F"],
    operators=[BOUC_WEN],
)
NUMBERS = np.array([9.0, 0.4, 1.0, STRENGTH])
DT = 0.01


def simulated(strength=STRENGTH, length=LENGTH, unloading=UNLOADING, extra=None, seed=1, n=5000):
    """Times, force and states of an oscillator whose friction remembers the path."""
    t, force = np.arange(n) * DT, multisine(3.0, seed, band=(0.05, 3.0))
    beta, gamma = 0.5 * (1.0 + unloading), 0.5 * (1.0 - unloading)
    pushed = force(t)

    def rate(now, x):
        q, v, w = x
        own = -9.0 * q - 0.4 * v + np.interp(now, t, pushed) - strength * w
        more = 0.0 if extra is None else extra(q, v)
        return [v, own + more, (v - beta * abs(v) * w - gamma * v * abs(w)) / length]

    options = {"t_eval": t, "max_step": DT, "rtol": 1e-6, "atol": 1e-8}
    return t, pushed, solve_ivp(rate, (0.0, t[-1]), [0.0, 0.0, 0.0], **options).y.T


def measured(noise=0.005, seed=1, **options):
    """Measure the position with noise, a share of its standard deviation."""
    t, force, x = simulated(seed=seed, **options)
    q = x[:, 0]
    q = q + noise * q.std() * np.random.default_rng(seed).standard_normal(len(t))
    return pse.prepare(t, q, force)


@pytest.fixture(scope="module")
def exact():
    """Record and hidden state without noise or filter."""
    t, force, x = simulated()
    w = x[:, 2]
    own = -9.0 * x[:, 0] - 0.4 * x[:, 1] + force - STRENGTH * w
    return pse.Record(t=t, x=x[:, :2], x_dot=np.column_stack([x[:, 1], own]), u=force), w


def numbers_in(report):
    (path,) = report.equations.paths
    return [float(a.evaluate(np.empty((1, 0)))[0]) for a in path.args[2:]]


def test_path_goes_on_from_where_it_was():
    x = np.cumsum(np.random.default_rng(0).standard_normal(200))
    whole = yielding_along(x, 2.0, 0.7)
    assert yielding_along(x[80:], 2.0, 0.7, whole[80]) == pytest.approx(whole[80:])


def test_path_that_rests_or_is_a_single_row_keeps_what_it_was():
    assert yielding_along(np.array([2.0, 2.0, 2.0]), 0.1, 1.0, 0.4) == pytest.approx(0.4)
    assert yielding_along(np.array([2.0]), 0.1, 1.0, 0.4) == pytest.approx([0.4])


def test_rest_on_the_way_changes_nothing():
    x = np.sin(np.arange(0.0, 9.0, 0.1))
    slow = np.repeat(x, 3)
    assert yielding_along(slow, 0.2, 2.0)[::3] == pytest.approx(yielding_along(x, 0.2, 2.0))


def test_design_with_hidden_states_has_their_rates(exact):
    record, _ = exact
    design = design_of(TRUE, [record])
    full = with_memories(design.equations(NUMBERS), ())
    (own,) = records_with_hidden_states(design, [record])
    expected = full.evaluate(own.x, own.u, own.t)
    plain = with_hidden_states(design).equations(NUMBERS)
    assert plain.evaluate(own.x, own.u, own.t) == pytest.approx(expected)
    free = with_hidden_states(design, free=True)
    coef = [*NUMBERS, 1.0 / LENGTH, UNLOADING / LENGTH]
    assert free.equations(coef).evaluate(own.x, own.u, own.t) == pytest.approx(expected)
    assert free.n_hidden == 1


def test_design_without_hysteresis_gets_no_hidden_states(exact):
    record, _ = exact
    design = design_of(DECLARED, [record])
    assert with_hidden_states(design) is design
    assert records_with_hidden_states(design, [record])[0] is record


@pytest.mark.parametrize("row", [0, 700, 1230, 3111])
def test_first_rows_say_what_the_friction_remembers(exact, row):
    record, w = exact
    equations = with_memories(design_of(TRUE, [record]).equations(NUMBERS), ())
    assert first_state(equations, record[row:]) == pytest.approx([*record.x[row], w[row]], abs=0.02)


def test_runs_over_stretches_find_numbers_and_starts_of_what_nobody_measured(exact):
    record, w = exact
    design = design_of(TRUE, [record])
    free = with_hidden_states(design, free=True)
    (own,) = records_with_hidden_states(design, [record])
    part = segments([own], design.velocities, 8, max_rows=None)
    x = part.z[:, :, :3]
    wrong = np.array([*NUMBERS, 1.2 / LENGTH, 0.7 / LENGTH])
    (found,) = converged([Trial(free, part, part.state_scale, wrong, x[:, 0] * [1, 1, 0.5], x)])
    assert 1.0 / found.coef[-2] == pytest.approx(LENGTH, rel=0.02)
    assert found.coef[-1] / found.coef[-2] == pytest.approx(UNLOADING, rel=0.1)
    assert found.coef[:4] == pytest.approx(NUMBERS, rel=0.02)
    assert found.starts[:, 2] == pytest.approx(w[:: len(w) // 8][:8], abs=0.05)


def test_twin_is_simulated_with_the_hidden_state():
    record = measured()
    maker = TwinMaker.of(design_of(TRUE, [record]).equations(NUMBERS), [record])
    (path,) = maker.simulated
    astray = (path.y - record.preparation.y)[1500:]  # the start of the hidden state is forgotten
    assert np.std(astray) < 0.006 * record.x[:, 0].std()


def test_hysteresis_is_sought_only_in_a_motion_that_turns():
    t = np.arange(0.0, 20.0, 0.01)
    assert remembered_ways(1, 0, np.sin(3.0 * t))
    assert not remembered_ways(1, 0, t + 0.1 * t**2)


@pytest.mark.slow
def test_hysteresis_of_an_oscillator_is_found_with_its_numbers():
    record = measured(n=3000)
    report = pse.close_loop(DECLARED, record, operators=(), random_state=0, n_twins=59)
    (effect,) = report.effects
    assert effect.name == "hysteresis"
    assert -effect.coefficients[0] == pytest.approx(STRENGTH, rel=0.03)
    assert numbers_in(report) == pytest.approx([LENGTH, UNLOADING], rel=0.15)
    assert report.after.simulation_error[0] < 0.1 * report.before.simulation_error[0]
    assert report.model.feature_names == ["q", "v", "q_yield", "F"]
    assert report.simulate(report.test[0]).shape == (len(report.test[0]), 3)
    assert "q_yield' = " in str(report)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("strength", "length", "unloading", "noise", "seed"),
    [(0.6, 0.1, 1.0, 0.005, 2), (0.3, 0.03, 1.0, 0.005, 3), (0.3, 0.1, 1.0, 0.02, 2)],
)
def test_free_runs_with_hysteresis_come_near_the_noise(strength, length, unloading, noise, seed):
    record = measured(noise, seed, strength=strength, length=length, unloading=unloading, n=5000)
    report = pse.close_loop(DECLARED, record, operators=(), n_twins=59, random_state=0)
    assert [effect.name for effect in report.effects] == ["hysteresis"]
    assert -report.effects[0].coefficients[0] == pytest.approx(strength, rel=0.05)
    assert numbers_in(report) == pytest.approx([length, unloading], rel=0.25)
    assert report.after.simulation_error[0] < 100.0 * noise


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "extra"),
    [
        ("cubic stiffness", lambda q, v: -3.0 * q**3),
        ("quadratic drag", lambda q, v: -0.4 * v * abs(v)),
        ("constant offset", lambda q, v: 0.3),
    ],
)
def test_what_is_missing_beside_a_hysteresis_is_found_too(name, extra):
    record = measured(extra=extra, n=6000)
    report = pse.close_loop(DECLARED, record, operators=(), n_twins=59, random_state=0)
    assert {effect.name for effect in report.effects} == {"hysteresis", name}
    assert numbers_in(report) == pytest.approx([LENGTH, UNLOADING], rel=0.25)


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "seed"), [(0.005, 0), (0.02, 2)])
def test_friction_of_an_oscillator_is_not_named_hysteresis(noise, seed):
    record = measured(
        noise, seed, strength=0.0, extra=lambda q, v: -0.4 * np.tanh(v / 1e-3), n=4000
    )
    report = pse.close_loop(DECLARED, record, random_state=seed, operators=(), n_twins=59)
    assert [effect.name for effect in report.effects] == ["Coulomb friction"]


@pytest.mark.slow
def test_friction_that_came_in_before_a_hysteresis_goes_again():
    rng, t = np.random.default_rng(2), np.arange(0.0, 30.0, 0.005)
    phases = rng.uniform(0.0, 2.0 * np.pi, 12)
    pushed = 2.0 * np.sin(np.multiply.outer(t, np.linspace(1.0, 30.0, 12)) + phases).sum(axis=1)

    def rate(now, x):
        q, v, w = x
        own = np.interp(now, t, pushed) - 2.0 * v - 100.0 * q - w
        return [v, own, (v - abs(v) * w) / 1e-3]  # Dahl's, over a fiftieth of the motion

    options = {"t_eval": t, "max_step": 5e-3, "rtol": 1e-6, "atol": 1e-9, "method": "LSODA"}
    q = solve_ivp(rate, (0.0, t[-1]), [0.0] * 3, **options).y[0]
    q = q + 0.005 * q.std() * rng.standard_normal(len(t))
    declared = pse.DeclaredModel({"q": "v", "v": "F - c*v - k*q"}, inputs=["F"])
    report = pse.close_loop(
        declared, pse.prepare(t, q, pushed), operators=(), n_twins=59, random_state=2
    )
    assert [effect.name for effect in report.effects] == ["hysteresis"]
    assert -report.effects[0].coefficients[0] == pytest.approx(1.0, rel=0.05)
