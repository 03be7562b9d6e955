"""An input that jumps is known up to its noise and the time in between: no effect hides there."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.loop.given.input_errors import as_held, input_error, known_up_to

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


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.005, 0.02])
def test_a_noisy_input_that_jumps_between_two_levels_does_not_saturate(noise):
    for seed in (1, 2):  # each was named a saturation at each noise
        report = pse.close_loop(MOTOR, motor(noise, seed), operators=(), random_state=seed)
        assert report.verdict == "complete", str(report)


@pytest.mark.slow
def test_an_input_that_does_saturate_is_named_beside_its_noise():
    levels = np.linspace(-1.0, 1.0, 9)
    record = motor(0.01, 0, levels, limit=0.7)
    report = pse.close_loop(MOTOR, record, operators=(), n_twins=59, random_state=0)
    assert [effect.name for effect in report.effects] == ["saturation"]
    (u,) = report.effects[0].term.free_symbols
    assert report.effects[0].term.subs(u, 2.0) == pytest.approx(0.7, abs=0.02)


def converter(gain, seed):
    """A state that a duty cycle drives, which jumps between its samples, and by its own product."""
    rng, t, finer = np.random.default_rng(seed), np.arange(0.0, 15.0, 1e-3), slice(None, None, 10)
    jumps = np.cumsum(rng.uniform(0.3, 0.7, 60))
    duty = rng.uniform(0.3, 0.7, 61)[np.searchsorted(jumps, t)]
    truth = pse.DeclaredModel({"x": f"10 - x - 3*d*x + {gain}*d"}, inputs=["d"])
    x = pse.simulate(truth.design().equations([]), [5.0], t, duty)[finer, 0]
    y = x + 0.003 * x.std() * rng.standard_normal(len(x))
    return pse.prepare(t[finer], y, duty[finer], order=1)


@pytest.mark.slow
@pytest.mark.parametrize("gain", [5.0, -5.0])
def test_a_missing_gain_is_no_error_of_an_input_that_jumps(gain):
    records = [converter(gain, seed) for seed in range(3)]
    declared = pse.DeclaredModel({"x": "k - a*x - b*d*x"}, inputs=["d"])
    report = pse.close_loop(declared, records[:2], records[2:], operators=(), random_state=0)
    assert [effect.name for effect in report.effects] == ["input gain"]
    assert report.effects[0].coefficients == pytest.approx([gain], rel=0.05)


def sampled(u, duration=50.0, seed=0):
    """A record of which only the input matters."""
    t = np.linspace(0.0, duration, len(u))
    y = np.sin(t) + 0.001 * np.random.default_rng(seed).standard_normal(len(u))
    return pse.prepare(t, y, u, order=1, cutoff=0.05 * len(u) / duration)


def test_the_error_of_an_input_has_the_power_of_its_noise():
    rng = np.random.default_rng(0)
    noisy = sampled(np.sin(np.linspace(0.0, 60.0, N)) + 0.05 * rng.standard_normal(N))
    drawn = np.mean([np.var(input_error(noisy, child)) for child in rng.spawn(8)])
    assert drawn == pytest.approx(0.05**2 * 0.1, rel=0.3)  # a tenth of the frequencies passes


def test_what_a_smooth_input_did_between_samples_is_known():
    smooth = sampled(np.sin(np.linspace(0.0, 600.0, N)))
    assert np.abs(input_error(smooth, np.random.default_rng(0))).max() < 1e-6
    assert known_up_to(smooth) == np.inf
    assert as_held(smooth) is smooth


def test_a_held_input_is_only_known_well_below_the_sampling_rate_and_late_where_it_begins():
    held = np.repeat(np.random.default_rng(1).choice([-1.0, 1.0], N // 20), 20)
    begins, mean = sampled(held), sampled((held + np.append(held[0], held[:-1])) / 2.0)
    assert as_held(begins) is begins
    assert known_up_to(begins) == known_up_to(mean) == pytest.approx(0.0872 * N / 50.0, rel=1e-2)
    late, quicker = (np.std(input_error(r, np.random.default_rng(0))) for r in (begins, mean))
    assert late > 3.0 * quicker > 0.0
    # As many columns as are asked for differ from zero.
    both = sampled(np.column_stack([held, held]))
    asked = input_error(both, np.random.default_rng(0), frozenset({1}))
    assert not asked[:, 0].any()
    assert asked[:, 1].any()


def test_an_exact_integral_of_a_held_input_follows_from_its_means():
    held = np.repeat(np.random.default_rng(2).choice([-1.0, 1.0], N // 20), 20)
    dt = 0.02
    way = dt * np.append(0.0, np.cumsum(held)[:-1])
    means = (held + np.append(held[0], held[:-1])) / 2.0
    record = pse.prepare(dt * np.arange(N), way, means, order=1, cutoff=4.0)
    before, after = (np.std(r.x_dot - r.u) for r in (record, as_held(record)))
    assert after < 0.2 * before


def test_nothing_is_known_of_inputs_without_raw_data():
    t = DT * np.arange(200)
    made = pse.Record(t=t, x=np.sin(t)[:, None], x_dot=np.cos(t)[:, None], u=np.cos(t)[:, None])
    assert input_error(made, np.random.default_rng(0)) is None


@pytest.mark.slow
def test_the_means_of_a_square_wave_make_no_friction():
    held = np.tile(np.repeat([1.0, -1.0], 80), 16)[:N]
    decay, v = np.exp(-1.5 * DT), np.zeros(N)
    for k in range(N - 1):
        v[k + 1] = decay * v[k] + 2.0 * (1.0 - decay) * held[k]
    y = v + 0.001 * v.std() * np.random.default_rng(0).standard_normal(N)
    means = (held + np.append(held[0], held[:-1])) / 2.0
    record = pse.prepare(DT * np.arange(N), y, means, order=1)
    report = pse.close_loop(MOTOR, record, operators=(), random_state=0)
    assert report.verdict == "complete", str(report)
    assert report.before.simulation_error[0] == pytest.approx(0.1, rel=0.1)  # the sensor's noise


@pytest.mark.slow
def test_noise_of_one_input_says_nothing_of_an_effect_of_another():
    rng, t = np.random.default_rng(3), DT * np.arange(N)
    noisy = np.repeat(rng.choice([-1.0, 1.0], 1 + N // 62), 62)[:N]
    smooth = sum(
        np.sin(w * t + p) for w, p in zip((1.0, 2.3, 4.1), rng.uniform(0, 6, 3), strict=True)
    )
    model = pse.DeclaredModel({"v": "3*u + 0.1*u^3 + 2*w - 1.5*v"}, inputs=["u", "w"])
    force = np.column_stack([smooth, (noisy + np.append(noisy[0], noisy[:-1])) / 2.0])
    v = pse.simulate(model.design().equations([]), [0.0], t, force)[:, 0]
    read = force + np.array([0.0, 0.03]) * rng.standard_normal(force.shape)
    y = v + 0.003 * v.std() * rng.standard_normal(N)
    declared = pse.DeclaredModel({"v": "a*u + b*w - c*v"}, inputs=["u", "w"])
    report = pse.close_loop(
        declared, pse.prepare(t, y, read, order=1), operators=(), random_state=0
    )
    assert [str(effect.term) for effect in report.effects] == ["u**3"]
