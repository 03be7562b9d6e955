"""What the noise of the first state makes of a free run, and what the report says of it."""

import numpy as np
import pytest
from loop_systems import equations_of

import pysindy_evolve as pse
from pysindy_evolve.loop.facts.start_noise import run_std_from_start_noise

GROWTH = equations_of({"x": "x - x**2"})
T = np.linspace(0.0, 12.0, 601)


def grown(start, seed, noise=0.02):
    """A population that grows from a start to one, counted with noise."""
    exact = pse.simulate(GROWTH, [start], T)
    rng = np.random.default_rng(seed)
    return pse.prepare(T, exact + noise * rng.standard_normal(exact.shape), order=1, cutoff=1.0)


def test_runs_move_as_they_do_from_noisy_first_states():
    first, *noisy = [grown(0.2, seed) for seed in range(61)]
    (exact,) = first.preparation.apply(T, pse.simulate(GROWTH, [0.2], T)).x[:1]
    runs = [pse.simulate(GROWTH, record.x[0], first.t) for record in noisy]
    misses = np.array(runs) - pse.simulate(GROWTH, exact, first.t)
    observed = 100.0 * np.sqrt(np.mean(misses**2)) / first.x.std()
    assert run_std_from_start_noise(GROWTH, [first])[0] == pytest.approx(observed, rel=0.3)


def test_only_a_run_that_its_first_state_does_not_explain_says_that_something_is_missing():
    train = [grown(start, seed) for seed, start in enumerate((0.3, 0.1, 2.0, 1.6))]
    declared = pse.DeclaredModel({"x": "r*x - k*x**2"})
    for start, seed, is_known in ((0.2, 7, True), (0.0005, 8, False)):
        test = grown(start, seed)
        report = pse.close_loop(declared, train, test, operators=(), random_state=0)
        said = " ".join(str(report).split())
        missed = report.after.simulation_error[0]
        assert (missed < 5.0) == is_known
        assert ("judge by the derivative" in said) == (not is_known)
        assert "something is missing" not in said
