"""Inputs that the declared model takes through a function."""

import pickle

import numpy as np
import pytest
import sympy
from scipy.signal import lfilter

import pysindy_evolve as pse
from pysindy_evolve.loop.given.input_functions import with_functions

T = np.arange(0.0, 40.0, 0.05)
RNG = np.random.default_rng(0)
LEVELS = RNG.choice([0.6, 0.8, 1.0, 1.2], 50).repeat(16)
OTHER = RNG.choice([-0.4, 0.0, 0.3], 50).repeat(16)


def speeds(n, step):
    """The solution of V' = 0.5 n^2 - 0.05 V^2, exact for a held n."""
    found = [3.0]
    for final, moved in zip(np.sqrt(10.0) * n, np.tanh(np.sqrt(0.025) * n * step), strict=True):
        found.append(final * (found[-1] + final * moved) / (final + found[-1] * moved))
    return np.array(found[:-1])


def ship(side):
    return pse.DeclaredModel({"V": side}, inputs=["n", "d"])


def record(u=None):
    V = 0.05 * np.cumsum(LEVELS + LEVELS**2)
    return pse.prepare(T, V, np.column_stack([LEVELS, OTHER]) if u is None else u, order=1)


@pytest.mark.parametrize(
    ("side", "columns"),
    [
        ("a*n**2 - c*V + b*d", {0}),
        ("a*n**2*V - c*V + b*n**2", {0}),
        ("a*n*Abs(n) + b*d*Abs(d)", {0, 1}),
        ("a*n + b*V*n - c*V", set()),
        ("a*n + b*n**2 - c*V", {0}),
        ("a*n + b*n**2*V - c*V", set()),
        ("a*n**2 + b*sin(n*V) - c*V", set()),
        ("a*cos(9*n) - c*V", set()),
        ("a*n*d - c*V", set()),
        ("a*Max(Min(n, 1), 0.7) - c*V + b*d", {0}),
        ("a*sign(n - 0.9) - c*V", set()),
    ],
)
def test_an_input_acts_through_the_one_function_that_the_model_has(side, columns):
    (found,) = with_functions(ship(side).design(), [record()])
    assert set(found.through) == columns


def test_an_input_that_runs_smoothly_stays():
    smooth = record(np.column_stack([1.0 + 0.3 * np.sin(T), 0.1 * np.cos(2.0 * T)]))
    (found,) = with_functions(ship("a*n**2 - c*V + b*d").design(), [smooth])
    assert found is smooth


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "levels"), [(0, [0.6, 0.8, 1.0, 1.2]), (2, [0.2, 0.7, 1.3])])
def test_nothing_is_missing_where_a_held_speed_acts_by_its_square(seed, levels):
    """The mean of a square over a jump is not the square of the mean: this was an input gain."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 300.0, 0.5)

    def measured():
        n = rng.choice(levels, 38).repeat(16)[: len(t)]
        V = speeds(n, 0.5)
        return pse.prepare(
            t, V + 0.005 * V.std() * rng.standard_normal(len(V)), n, order=1, held=True
        )

    model = pse.DeclaredModel({"V": "a*n**2 - d*V*Abs(V)"}, inputs=["n"])
    report = pse.close_loop(model, measured(), measured(), random_state=0)
    assert report.verdict == "complete"
    assert report.after.simulation_error < 1.0


@pytest.mark.slow
def test_nothing_is_missing_behind_the_dead_zone_of_a_valve_that_is_held():
    """Its mean over a step is not the dead zone of the mean: this was two gains and a dead zone."""
    rng, t = np.random.default_rng(0), np.arange(0.0, 30.0, 0.01)

    def measured():
        u = rng.choice(np.linspace(-1.6, 1.6, 9), 150).repeat(20)
        flow = 220.0 * np.sign(u) * np.maximum(np.abs(u) - 0.4, 0.0)
        v = lfilter([0.0, 1.0 - np.exp(-0.12)], [1.0, -np.exp(-0.12)], flow)  # exact if held
        return pse.prepare(t, v + rng.standard_normal(len(t)), u, order=1, held=True)

    model = pse.DeclaredModel({"v": "b*sign(u)*Max(Abs(u) - 0.4, 0) - a*v"}, inputs=["u"])
    report = pse.close_loop(model, measured(), measured(), random_state=0)
    assert report.verdict == "complete"
    assert report.after.simulation_error < 1.0


def test_what_several_functions_of_an_input_give_is_fitted():
    (found,) = with_functions(ship("a*n + b*n**2 + c").design(), [record()])
    acts = found.through[0].function(np.array([0.6, 0.9, 1.2]))
    assert acts - acts[0] == pytest.approx([0.0, 0.75, 1.68], rel=0.05)


def test_what_is_known_needs_no_fit_and_all_can_be_pickled():
    (found,) = with_functions(ship("2*n + 3*n**2").design(), [record()])
    again = pickle.loads(pickle.dumps(found))
    assert again.through[0].function(np.array([1.0])) == pytest.approx([5.0])
    assert again.with_inputs(lambda _, u: u).u == pytest.approx(found.u)


def reporter(seed):
    """A protein whose production a dose switches on, u^2/(u^2 + 9), in steps of some minutes."""
    rng, t = np.random.default_rng(seed), 3.0 * np.arange(900.0)
    u = rng.uniform(0.0, 8.0, 60).repeat(15)
    rate = 12.0 * u**2 / (u**2 + 9.0) + 0.2
    decay = np.exp(-0.03 * 3.0)
    G = lfilter([0.0, (1.0 - decay) / 0.03], [1.0, -decay], rate)
    return pse.prepare(t, G + rng.standard_normal(len(t)), u, order=1, held=True)


@pytest.mark.slow
def test_a_function_of_steps_that_was_found_acts_as_if_it_had_been_declared():
    train, test = reporter(1), reporter(2)
    declared = pse.DeclaredModel({"G": "b*u - d*G + l"}, inputs=["u"])
    report = pse.close_loop(declared, train, test, random_state=0)
    whole = pse.DeclaredModel({"G": "b*u**2/(u**2 + 9) - d*G + l"}, inputs=["u"])
    true = pse.close_loop(whole, train, test, random_state=0, max_effects=0)
    (effect,) = report.effects
    assert effect.term.free_symbols == {sympy.Symbol("u", real=True)}
    assert report.after.simulation_error < 1.2 * true.before.simulation_error
