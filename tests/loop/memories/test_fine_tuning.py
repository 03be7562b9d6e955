"""The last digits of delays and time constants."""

import numpy as np
import pytest
from scipy.signal import StateSpace, lsim

import pysindy_evolve as pse

DT, N, FINE, LAG = 0.01, 2000, 50, 0.08
DECLARED = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])


def lagging_drive(noise, highest, seed):
    """Measure an oscillator behind a lag, driven smoothly up to a frequency."""
    rng = np.random.default_rng(seed)
    speeds, phases = 2.0 * np.pi * np.linspace(0.1, highest, 12), rng.uniform(0.0, 6.28, 12)
    t = DT / FINE * np.arange(N * FINE)
    force = np.sin(np.outer(t, speeds) + phases).sum(axis=1)
    a = np.array([[0.0, 1.0, 0.0], [-30.0, -1.0, 10.0], [0.0, 0.0, -1.0 / LAG]])
    system = StateSpace(a, np.array([[0.0], [0.0], [1.0 / LAG]]), np.eye(3), np.zeros((3, 1)))
    q = lsim(system, force, t)[1][::FINE, 0]
    return pse.prepare(t[::FINE], q + noise * rng.standard_normal(N), force[::FINE])


@pytest.mark.parametrize(
    ("noise", "highest", "rel"),
    [
        (0.0, 3.0, 1e-4),
        pytest.param(3e-4, 1.0, 2e-3, marks=pytest.mark.slow),
        (3e-4, 3.0, 5e-4),
    ],
)
def test_a_time_constant_is_as_exact_as_the_record(noise, highest, rel):
    record = lagging_drive(noise, highest, seed=0)
    report = pse.close_loop(DECLARED, record, operators=(), random_state=0, n_twins=59)
    (effect,) = report.effects
    assert effect.name == "actuator lag"
    assert effect.coefficients[0] == pytest.approx(LAG, rel=rel)
    assert report.after.parameters["k"] == pytest.approx(30.0, rel=rel)
    ((low, high),) = effect.confidence_intervals
    if noise:  # without it the rounding of splines is all there is
        assert low < LAG < high < (1.0 + 3.0 * rel) * low
