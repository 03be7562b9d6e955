"""Beam search finds small equations of columns that are nearly collinear."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.sparse.beam import best_subsets, with_exchanges
from pysindy_evolve.sparse.elimination import default_penalty
from pysindy_evolve.sparse.gram import gram


@pytest.fixture
def alike():
    """Smooth functions of one variable, of which 1, 3 and 5 make the target."""
    x = np.linspace(0.1, 5.0, 400)
    columns = [np.ones_like(x), x, np.sin(x), x**2, x * np.cos(x), x / (0.6 + x), np.cos(x)]
    theta = np.column_stack([c / np.sqrt(np.mean(c**2)) for c in columns])
    noise = 1e-3 * np.random.default_rng(0).normal(size=len(x))
    return gram(theta, theta[:, [1, 3, 5]] @ np.array([2.0, -1.0, -1.5]) + noise)


def test_it_finds_the_few_right_terms_among_many_that_are_alike(alike):
    found = best_subsets(alike, default_penalty(alike, alike.n), alike.n, max_terms=6)
    assert [len(support) for support in found] == [1, 2, 3, 4, 5, 6]
    assert found[2].tolist() == [1, 3, 5]


def test_it_stops_at_the_largest_size_allowed_and_at_the_last_column(alike):
    penalty = default_penalty(alike, alike.n)
    assert len(best_subsets(alike, penalty, alike.n, max_terms=2)) == 2
    assert len(best_subsets(alike.select([0, 1]), penalty[:2], alike.n, max_terms=6)) == 2


def test_exchanges_leave_out_one_term_at_a_time_and_repeat_none():
    front = [np.array([3, 1, 4]), np.array([1, 3]), np.array([1])]
    sets = [frozenset(support.tolist()) for support in with_exchanges(front)]
    assert len(sets) == len(set(sets))
    assert set(sets) == {frozenset(s) for s in [(1, 3, 4), (1, 4), (3, 4), (1, 3), (1,), (3,), ()]}


@pytest.mark.slow
def test_a_saturation_beside_a_polynomial_is_found_in_most_runs():
    x = np.linspace(0.05, 6.0, 1200)[:, None]
    truth = (0.8 * x - 0.1 * x**2 - 1.5 * x / (0.6 + x))[:, 0]
    wide = np.linspace(0.05, 9.0, 200)[:, None]
    beyond = (0.8 * wide - 0.1 * wide**2 - 1.5 * wide / (0.6 + wide))[:, 0]
    found = 0
    for seed in range(6):
        noise = 1e-3 * truth.std() * np.random.default_rng(seed).normal(size=len(x))
        library = pse.EvolvingLibrary(random_state=seed).fit(x, truth + noise)
        theta, other = (np.asarray(library.transform(part)) for part in (x, wide))
        coef = np.linalg.lstsq(theta, truth + noise, rcond=None)[0]
        found += np.std(other @ coef - beyond) < 0.01 * np.std(beyond)
    assert found >= 2  # none of six before equations of terms that are alike were searched
