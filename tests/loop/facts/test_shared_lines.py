"""Lines that several records share, and forcings near the cutoff."""

import numpy as np
import pytest
from loop_systems import DT, equations_of, multisine

import pysindy_evolve as pse
from pysindy_evolve.loop.facts.shared_lines import _lines_of

MODEL = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])


def forced(size, cycles, phase=0.4, seed=0, noise=5e-3):
    side = f"-200*q - 1.7*v + 4*F + {size}*sin({2 * np.pi * cycles}*t + {phase})"
    t, force = np.arange(0.0, 25.0, DT), multisine(10.0, seed, (0.3, 4.0))
    x = pse.simulate(equations_of({"q": "v", "v": side}, ("F",)), [0.0, 0.0], t, force)
    q = x[:, 0] + noise * x[:, 0].std() * np.random.default_rng(seed).standard_normal(t.size)
    return pse.prepare(t, q, force(t))


@pytest.mark.slow
def test_a_phase_that_differs_between_records_is_refused_and_not_complete():
    records = [forced(6.0, 2.37, phase, k) for k, phase in enumerate((0.4, 2.9, 5.1))]
    report = pse.close_loop(MODEL, records[:2], test=records[2], operators=(), random_state=0)
    assert report.verdict == "untraced"
    assert not report.effects
    said = " ".join(str(report).split())
    assert said.count("In each training record the residual of dv/dt has a line at 2.37") == 1


@pytest.mark.slow
def test_nothing_shared_is_no_line():
    records = [forced(0.0, 2.37, 0.0, k) for k in range(3)]
    report = pse.close_loop(MODEL, records[:2], test=records[2], operators=(), random_state=0)
    assert report.verdict == "complete"


@pytest.mark.slow
def test_a_forcing_near_the_cutoff_has_its_size():
    record = forced(3.0, 6.3)
    assert record.preparation.cutoff < 2.0 * 6.3
    report = pse.close_loop(MODEL, record, operators=(), random_state=0)
    (effect,) = report.effects
    assert effect.name == "periodic forcing"
    assert np.hypot(*effect.coefficients) == pytest.approx(3.0, rel=0.1)


def test_a_line_beside_the_cutoff_is_what_the_filter_left():
    t = np.arange(0.0, 40.0, 0.01)
    record = pse.prepare(t, np.sin(3.0 * t), cutoff=5.0)
    assert _lines_of(record, np.sin(2 * np.pi * 4.2 * record.t))[0] == pytest.approx(4.2)
    assert not _lines_of(record, np.sin(2 * np.pi * 4.8 * record.t))
