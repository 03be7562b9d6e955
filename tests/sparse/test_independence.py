"""The number of independent samples in a residual, short or long, white or not."""

import numpy as np
import pytest
from scipy.signal import lfilter

from pysindy_evolve.sparse import selection
from pysindy_evolve.sparse.selection import effective_size


def colored(n, memory, seed=0):
    return lfilter([1.0], [1.0, -memory], np.random.default_rng(seed).normal(size=n))


@pytest.mark.parametrize("memory", [0.5, 0.9, 0.99])
def test_it_counts_as_the_theory_of_a_first_order_filter_says(memory):
    n = 100_000
    expected = n * (1 - memory) / (1 + memory)
    assert effective_size(colored(n, memory)) == pytest.approx(expected, rel=0.15)


def test_blocks_of_a_long_record_count_as_the_whole_does(monkeypatch):
    values = colored(60_000, 0.95)
    whole = effective_size(values)
    monkeypatch.setattr(selection, "BLOCK", 10_000)
    assert effective_size(values) == pytest.approx(whole, rel=0.05)


def test_white_noise_keeps_every_sample():
    assert effective_size(np.random.default_rng(2).normal(size=5000)) == 5000
