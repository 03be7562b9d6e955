"""Friction, or hysteresis: what a noisy velocity makes of a sign must not be named."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.equations import AlgebraicEquations
from pysindy_evolve.hidden_states.boucwen import yielding_along
from pysindy_evolve.loop.given.algebraic import as_algebraic
from pysindy_evolve.loop.twins.twins import TwinMaker
from pysindy_evolve.signals import as_target
from pysindy_evolve.terms import variable

DECLARED = pse.DeclaredModel({"F": "c*v + k*x + F0"}, inputs=["x", "v", "a"], algebraic=True)


def measured_force(extra, noise, seed):
    """Measure position and force of a rig, a share of noise on the position."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 20.0, 0.01)
    frequencies = 2 * np.pi * np.array([0.3, 0.55, 0.8, 1.1, 1.45])
    arguments = np.outer(t, frequencies) + rng.uniform(0, 2 * np.pi, 5)
    x, v = np.sin(arguments).sum(axis=1), (np.cos(arguments) * frequencies).sum(axis=1)
    force = 2.0 * v + 3.0 * x + 1.0 + extra(x, v)
    force = force + 0.02 * force.std() * rng.standard_normal(len(t))
    return as_target(pse.prepare(t, x + noise * x.std() * rng.standard_normal(len(t)), force))


def names(record, seed):
    report = pse.close_loop(DECLARED, record, operators=(), random_state=seed, n_twins=59)
    return [effect.name for effect in report.effects]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 3])
def test_friction_seen_through_a_noisy_velocity_is_not_named_hysteresis(seed):
    record = measured_force(lambda x, v: 5.0 * np.sign(v), 0.02, seed)
    assert names(record, seed) == ["Coulomb friction"]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 2])
def test_hysteresis_seen_through_a_noisy_velocity_keeps_its_name(seed):
    record = measured_force(lambda x, v: 8.0 * yielding_along(x, 0.3, 1.0), 0.002, seed)
    assert "hysteresis" in names(record, seed)


def test_part_of_a_record_knows_how_its_motion_was_prepared():
    record = measured_force(lambda x, v: 0.0 * v, 0.01, 0)
    part = record[100:400]
    again = part.motion.apply(part.motion.t, part.motion.y)
    assert np.column_stack([again.x, again.x_dot[:, 1:]]) == pytest.approx(part.u)


def test_twin_of_a_force_has_the_noise_of_the_motion_but_a_force_without_it():
    record = as_algebraic(measured_force(lambda x, v: 0.0 * v, 0.02, 0))
    terms = tuple(variable(k).parts[0][1] for k in (1, 2))
    equations = AlgebraicEquations(terms, np.array([[3.0, 2.0]]), ("F",), ("x", "v", "a"))
    exact = equations.evaluate(record.x, record.u, record.t)
    silent = pse.Record(t=record.t, x=exact, x_dot=exact, u=record.u, motion=record.motion)
    (twin,) = TwinMaker.of(equations, [silent]).make(np.random.default_rng(0))
    noise = record.motion.noise[0]
    assert 0.1 * noise < np.std(twin.u[:, 0] - record.u[:, 0]) < noise
    assert twin.x_dot == pytest.approx(exact, abs=1e-9 * np.abs(exact).max())
