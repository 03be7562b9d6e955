"""Where the inputs of training records stood before these began, once a memory is found."""

import numpy as np
import pytest
from scipy.signal import lsim

import pysindy_evolve as pse
from pysindy_evolve.hidden_states.memory import LAG, Memory
from pysindy_evolve.loop.effects.candidate import CandidateMaker
from pysindy_evolve.loop.evidence.findings import MemoryFinding, memories_in
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.revision.past_inputs import settled_beginning
from pysindy_evolve.terms import variable

DECLARED = pse.DeclaredModel({"T": "a - b*T + c*u"}, inputs=["u"])
TIME_CONSTANT = 40.0


def heated(before, seed=4, n=3000):
    """Measure a plate whose heater lags behind, is on in the first sample, and was so before."""
    t, rng = np.arange(float(n)), np.random.default_rng(seed)
    power = np.repeat(rng.random(n // 50) > 0.5, 50) * 1.0
    power[:50] = 1.0
    system = ([[-0.01, 0.8], [0.0, -1.0 / TIME_CONSTANT]], [[0.0], [1.0 / TIME_CONSTANT]])
    _, above, _ = lsim((*system, [[1.0, 0.0]], [[0.0]]), power, t, [0.0, before])
    return pse.prepare(
        t, 20.0 + above + 0.002 * above.std() * rng.standard_normal(n), power, order=1
    )


def begun(record, time_constant=33.0):
    lag = Memory(LAG, 0, (time_constant,))
    named = CandidateMaker(0)(LAG, variable(1))
    finding = MemoryFinding(named, (), 1.0, 0.01, np.zeros(99), memory=lag)
    part = segments([record], ())
    return settled_beginning(design_of(DECLARED, [record]), [finding], [record], part)


def test_lag_of_a_heater_switched_on_with_the_first_sample_is_tuned_from_rest():
    findings, plain, wide = begun(heated(before=0.0))
    (memory,) = memories_in(findings)
    assert memory.values[0] == pytest.approx(TIME_CONSTANT, rel=0.03)
    for record in (*plain, *wide):
        assert record.raw_u[0] == pytest.approx([0.0], abs=0.05)


def test_record_in_balance_with_its_first_input_stays_as_it_is():
    record = heated(before=1.0)
    findings, _, wide = begun(record, TIME_CONSTANT)
    assert wide == (record,)
    assert memories_in(findings) == (Memory(LAG, 0, (TIME_CONSTANT,)),)


@pytest.mark.slow
def test_heater_switched_on_with_the_first_sample_is_found_with_its_numbers():
    report = pse.close_loop(DECLARED, heated(before=0.0), operators=(), n_twins=59, random_state=0)
    assert [effect.name for effect in report.effects] == [LAG]
    (value,) = report.effects[0].coefficients
    assert value == pytest.approx(TIME_CONSTANT, rel=0.03)
    assert report.after.simulation_error[0] < 1.0
