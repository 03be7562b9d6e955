"""Short runs, many at once, against the free run that they are cut from."""

import numpy as np
import pytest

from pysindy_evolve.equations import Equations
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.simulation import simulate
from pysindy_evolve.simulation.pieces import simulate_pieces
from pysindy_evolve.terms import add, call, constant, sub, variable

from .sliding_systems import block, duffing, equations, sgn, total


def cut_and_run(model, x, t, u, window, coef=None):
    """Run over pieces of a window each, from its first row; return runs and rows."""
    rows = np.arange(0, len(t) - window, window)[:, None] + np.arange(window + 1)
    coef = model.coef[None] if coef is None else coef
    u, every = np.asarray(u, dtype=float).reshape(len(t), -1), np.tile(rows, (len(coef), 1))
    run = simulate_pieces(model, coef, x[every[:, 0]], t[every], u[every])
    return run.reshape(-1, *rows.shape, x.shape[1]) if len(coef) > 1 else run, rows


class TestShortRuns:
    @pytest.mark.parametrize("window", [20, 100, 1000])
    def test_each_window_follows_the_free_run(self, record, window):
        t, u, x = record
        predicted, index = cut_and_run(duffing(), x, t, u, window=window)
        assert predicted.shape == (6000 // window, window + 1, 2)
        np.testing.assert_allclose(predicted, x[index], atol=2e-3 * np.abs(x).max(axis=0).min())

    def test_automatic_substeps_are_enough(self, record):
        t, u, x = record
        coarse = slice(None, None, 8)
        once, index = cut_and_run(duffing(), x[coarse], t[coarse], u[coarse], window=25)
        spread = x.std(axis=0)
        assert np.all(np.sqrt(np.mean((once - x[coarse][index]) ** 2, axis=(0, 1))) < 0.02 * spread)

    def test_stuck_windows_rest_exactly(self, record):
        t, u, _ = record
        still = np.zeros((len(t), 2))
        still[:, 0] = 0.002
        predicted, _ = cut_and_run(duffing(), still, t, 0.05 * u, window=50)
        assert np.all(predicted == [0.002, 0.0])

    def test_windows_break_away_and_stop_as_the_free_run_does(self):
        t = np.linspace(0.0, 12.0, 1201)
        u = 3 * np.sin(t)
        x = simulate(block(stiffness=1.0), [0.0, 0.0], t, u)
        predicted, index = cut_and_run(block(stiffness=1.0), x, t, u, window=400)
        np.testing.assert_allclose(predicted, x[index], atol=2e-4)

    def test_joint_sliding_of_two_blocks(self):
        v1, v2, force = variable(0), variable(1), variable(2)
        rows = [
            total((-1.0, sgn(sub(v1, v2))), (-0.2, v1)),
            total((1.0, sgn(sub(v1, v2))), (-0.3, sgn(v2)), (1.0, force)),
        ]
        two = equations(rows, ("v1", "v2"), ("F",))
        t = np.linspace(0.0, 20.0, 2001)
        u = 3 * np.sin(t)
        x = simulate(two, [0.0, 0.0], t, u)
        predicted, index = cut_and_run(two, x, t, u, window=200)
        np.testing.assert_allclose(predicted, x[index], atol=5e-3)

    def test_several_models_at_once_equal_one_after_the_other(self, record):
        t, u, x = record
        rig = duffing()
        batch = np.stack([rig.coef, rig.coef * [[1.0], [0.9]], rig.coef * [[1.0], [1.2]]])
        together, _ = cut_and_run(rig, x, t, u, window=60, coef=batch)
        for coef, predicted in zip(batch, together, strict=True):
            alone = Equations(rig.terms, coef, rig.states, rig.inputs)
            single, _ = cut_and_run(alone, x, t, u, window=60)
            np.testing.assert_allclose(predicted, single, atol=1e-9)

    def test_input_sign_jumps_inside_windows(self):
        model = equations([sgn(variable(1))], ("x",), ("u",))
        t = np.arange(9.0)
        u = [0, 0, 1, 1, 0, 0, -1, 1, -1]
        x = np.array([0, 0, 1, 2, 3, 3, 2, 2, 2.0])[:, None]
        predicted, index = cut_and_run(model, x, t, u, window=4)
        np.testing.assert_allclose(predicted, x[index], atol=1e-9)

    def test_sign_inside_a_sign_is_followed(self):
        outer = sgn(add(constant(0.5), sgn(add(variable(0), variable(1)))))
        model = equations([total((-1.0, variable(0)), (1.1, outer))], ("x",), ("u",))
        t = np.linspace(0.0, 10.0, 1001)
        u = 3 * np.sin(2 * t)
        x = simulate(model, [1.0], t, u)
        predicted, index = cut_and_run(model, x, t, u, window=200)
        np.testing.assert_allclose(predicted, x[index], atol=1e-5)


def test_a_term_without_a_value_says_nothing_of_the_models_without_it():
    """Contenders run side by side: the logarithm in one, of what falls below zero, was in all."""
    ((_, plain),) = variable(0).parts
    ((_, curved),) = call(BUILTIN["log"], variable(1)).parts
    equations = Equations((plain, curved), np.array([[-1.0, 0.0]]), ("x",), ("u",))
    coef = np.array([[[-1.0, 0.0]], [[-1.0, 1.0]]])
    t = np.tile(np.linspace(0.0, 1.0, 21), (2, 1))
    u = np.linspace(0.5, -0.5, 21)[None, :, None].repeat(2, axis=0)
    decays, logs = simulate_pieces(equations, coef, np.ones((2, 1)), t, u)
    assert decays[:, 0] == pytest.approx(np.exp(-t[0]), rel=1e-5)
    assert not np.isfinite(logs[-1, 0])
