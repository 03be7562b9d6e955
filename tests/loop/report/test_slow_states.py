"""A state that nobody measured and that is too slow to be looked for is not passed over."""

import numpy as np
import pytest
from loop_systems import equations_of

import pysindy_evolve as pse


@pytest.mark.slow
@pytest.mark.parametrize("exchange", [0.0, 0.08])
def test_compartment_slower_than_an_eighth_of_the_record_is_not_passed_over(exchange):
    true = equations_of({"C": f"0.05*u - 0.15*C - {exchange}*(C - P)", "P": "0.05*(C - P)"}, ("u",))
    t, records = np.arange(0.0, 100.0, 0.05), []
    for seed in range(2):
        rng = np.random.default_rng(seed)
        doses = np.interp(t, np.arange(0.0, 106.0, 3.0), rng.uniform(0.0, 60.0, 36))[:, None]
        plasma = pse.simulate(true, [2.0, 2.0], t, u=doses)[:, :1]
        noise = 0.005 * plasma.std() * rng.standard_normal(plasma.shape)
        records.append(pse.prepare(t, plasma + noise, doses, order=1))
    declared = pse.DeclaredModel({"C": "a*u - k*C"}, inputs=["u"])
    report = pse.close_loop(declared, *records, operators=(), random_state=0, n_twins=59)
    said = " ".join(str(report).split())
    assert not report.effects
    assert ("or a state that nobody measured" in said) == (exchange > 0.0)
