"""What is proposed from the records themselves: each of them may show it."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.loop.evidence.scoring import propose
from pysindy_evolve.loop.given.segments import segments


def test_ripple_that_only_a_shorter_slower_record_shows_is_proposed():
    declared = pse.DeclaredModel({"q": "v", "v": "F"}, inputs=["F"])
    rng, records = np.random.default_rng(0), []
    for duration, ripple in ((30.0, 0.0), (20.0, 1.0)):
        t = np.arange(0.0, duration, 0.01)
        q = 1.5 * np.sin(0.4 * t)
        x = np.column_stack([q, 0.6 * np.cos(0.4 * t)])
        force, noise = -0.24 * np.sin(0.4 * t), 0.2 * rng.standard_normal(len(t))
        rate = np.column_stack([x[:, 1], force + ripple * np.sin(14.0 * q) + noise])
        records.append(pse.Record(t=t, x=x, x_dot=rate, u=force[:, None]))
    design = declared.design()
    proposed = propose(design, design.equations([]), segments(records))
    (found,) = [c for c in proposed if c.name == "position-periodic ripple"]
    assert found.shape.values[0] == pytest.approx(14.0, rel=0.02)
