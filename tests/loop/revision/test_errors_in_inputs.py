"""An input that jumps is known up to its noise and the time in between: no effect hides there."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import pysindy_evolve as pse
from pysindy_evolve.loop.given.input_errors import input_error

DT, N = 0.02, 2500
MOTOR = pse.DeclaredModel({"v": "b*u - a*v"}, inputs=["u"])


def motor(noise, seed, levels=(-1.0, 1.0), limit=np.inf):
    """Speed of a motor, exactly as sampled, whose voltage jumps and is read with noise."""
    rng = np.random.default_rng(seed)
    held = np.repeat(rng.choice(levels, 1 + N // 62), 62)[:N]
    decay = np.exp(-1.5 * DT)
    v = np.zeros(N)
    for k in range(N - 1):
        v[k + 1] = decay * v[k] + 2.0 * (1.0 - decay) * np.clip(held[k], -limit, limit)
    u = (held + np.append(held[0], held[:-1])) / 2.0  # about each sample, as the docs advise
    y = v + 0.003 * v.std() * rng.standard_normal(N)
    return pse.prepare(DT * np.arange(N), y, u + noise * rng.standard_normal(N), order=1)


@pytest.mark.parametrize("noise", [0.0, 0.005, 0.02])
def test_a_noisy_input_that_jumps_between_two_levels_does_not_saturate(noise):
    for seed in (1, 2):  # each was named a saturation at each noise
        report = pse.close_loop(MOTOR, motor(noise, seed), random_state=seed)
        assert report.verdict == "complete", str(report)


def test_an_input_that_does_saturate_is_named_beside_its_noise():
    levels = np.linspace(-1.0, 1.0, 9)
    report = pse.close_loop(MOTOR, motor(0.01, 0, levels, limit=0.7), random_state=0)
    assert [effect.name for effect in report.effects] == ["saturation"]
    (u,) = report.effects[0].term.free_symbols
    assert report.effects[0].term.subs(u, 2.0) == pytest.approx(0.7, abs=0.02)


def test_the_error_of_an_input_has_the_power_of_its_noise_and_of_its_jumps():
    rng = np.random.default_rng(0)
    noisy = motor(0.05, 0)
    frequency = 2.0 * np.pi * np.fft.rfftfreq(N)  # a sample
    passed = np.mean(np.minimum(frequency, np.pi) <= 2.0 * np.pi * noisy.preparation.cutoff * DT)
    drawn = np.mean([np.var(input_error(noisy, child)) for child in rng.spawn(8)])
    assert drawn == pytest.approx(0.05**2 * passed, rel=0.5)
    t = DT * np.arange(N)
    smooth = pse.prepare(t, np.sin(t) + 0.001 * rng.standard_normal(N), np.sin(t), order=1)
    inner = slice(5, -5)  # the filter does not know what comes after the ends
    bent = input_error(smooth, rng)[inner, 0]
    assert_allclose(bent, -(DT**2) / 6.0 * smooth.u[inner, 0], atol=1e-5)


def test_nothing_is_known_of_inputs_without_raw_data():
    t = DT * np.arange(200)
    made = pse.Record(t=t, x=np.sin(t)[:, None], x_dot=np.cos(t)[:, None], u=np.cos(t)[:, None])
    assert input_error(made, np.random.default_rng(0)) is None
