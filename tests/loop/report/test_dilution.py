"""What noise makes too small is said where too little moved to tell it."""

import numpy as np
import pytest

import pysindy_evolve as pse


def regulated(seed, steps):
    """A room that a controller keeps at 5 degrees, or that follows steps of its set point."""
    rng, n, dt = np.random.default_rng(seed), 2400, 5.0
    wanted = 5.0 + steps * rng.uniform(-3.0, 3.0, 30).repeat(n // 30)
    decay = np.exp(-0.01 * dt)
    T, integral, rows = 5.0, 40.0, []
    for goal in wanted:
        read = T + 0.05 * rng.standard_normal()
        integral += 0.02 * (read - goal)
        f = np.clip(integral + 2.0 * (read - goal), 0.0, 200.0)
        rows.append((read, f))
        rest = 21.0 - 0.4 * f
        T = rest + (T - rest) * decay
    read, f = np.array(rows).T
    return pse.prepare(dt * np.arange(n), read, f, order=1, held=True)


@pytest.mark.parametrize(("steps", "said"), [(0.0, 1), (1.0, 0)])
def test_a_regulated_rest_makes_all_values_too_small_and_steps_do_not(steps, said):
    declared = pse.DeclaredModel({"T": "-a*f + l*(21 - T)"}, inputs=["f"])
    records = regulated(1, steps), regulated(2, steps)
    report = pse.close_loop(declared, *records, operators=(), random_state=0)
    found = np.array([report.after.parameters[name] for name in ("a", "l")])
    assert str(report).count("nearly cancel out along these records") == said
    assert (np.max(np.abs(found / [0.004, 0.01] - 1.0)) > 0.3) == bool(said)


def test_what_runs_bear_out_is_not_doubted():
    t = 0.01 * np.arange(4000)
    q = np.exp(-0.05 * t) * np.cos(3.0 * t)
    declared = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v"})
    report = pse.close_loop(declared, pse.prepare(t, q + 1e-3 * np.sin(977.0 * t)), max_effects=0)
    assert "noise of the sensors, which makes" not in " ".join(str(report).split())
