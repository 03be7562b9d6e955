"""Sparse regression: what proposes terms, and what a term must be to stay."""

import numpy as np
import pytest

from pysindy_evolve import parsimony, regression
from pysindy_evolve.regression import Gram


def test_supports_hold_the_true_terms(sparse_problem):
    theta, coef, y = sparse_problem
    found = regression.supports(regression.gram(theta, y), 8)
    assert any(set(np.flatnonzero(coef)) <= set(support) for support in found)


def test_a_term_that_helps_in_one_block_only_is_dropped():
    rng = np.random.default_rng(1)
    theta = rng.normal(size=(1200, 2))
    y = theta[:, 0] + 0.1 * rng.normal(size=1200)
    y[:100] += theta[:100, 1]
    blocks = regression.block_grams(lambda rows: theta[rows], y, 12)
    whole = regression.total(blocks)
    folds = [whole - block for block in blocks]
    assert sorted(regression.prune(whole, [0, 1])) == [0, 1]
    assert parsimony.stable(whole, folds, [0, 1]).tolist() == [0]


def test_a_term_below_the_error_of_a_derivative_is_dropped():
    rng = np.random.default_rng(2)
    theta = rng.normal(size=(5000, 3))
    y = theta @ [1.0, 1e-3, 0.0] + 1e-3 * rng.normal(size=5000)
    gram = regression.gram(theta, y)
    assert sorted(regression.prune(gram, range(3))) == [0, 1]
    assert parsimony.material(gram, [0, 1]).tolist() == [0]


def test_a_small_term_counts_where_nothing_else_is_left():
    rng = np.random.default_rng(2)
    theta = rng.normal(size=(5000, 2))
    gram = regression.gram(theta, theta @ [1.0, 1e-3])
    assert sorted(parsimony.material(gram, [0, 1])) == [0, 1]


def test_white_noise_counts_in_full_and_smooth_errors_do_not():
    white = np.random.default_rng(3).normal(size=4000)
    smooth = np.convolve(white, np.ones(50), mode="same")
    assert regression.effective_size(white) == pytest.approx(4000, rel=0.1)
    assert regression.effective_size(smooth) < 200
    assert regression.effective_size(np.zeros(100)) == 100


def test_columns_of_zeros_and_no_columns_do_no_harm():
    zeros = regression.gram(np.zeros((50, 2)), np.arange(50.0))
    assert len(regression.prune(zeros, [0, 1])) == 0
    none = Gram(np.empty((0, 0)), np.empty(0), 1.0, 50)
    assert [s.tolist() for s in regression.front(none, [np.arange(0)])] == [[]]
    assert all(len(support) == 0 for support in regression.supports(none, 5))
