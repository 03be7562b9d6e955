"""Kernels of the regression: Gram matrices, elimination, stability."""

import numpy as np
import pytest

from pysindy_evolve import regression
from pysindy_evolve.regression import Gram


@pytest.fixture
def problem():
    """Twelve columns of very different sizes, three of them true."""
    rng = np.random.default_rng(0)
    theta = rng.normal(size=(600, 12)) * 10.0 ** rng.integers(-6, 6, 12)
    coef = np.zeros(12)
    coef[[1, 5, 9]] = [2.0, -1.0, 0.5] / np.std(theta[:, [1, 5, 9]], axis=0)
    return theta, coef, theta @ coef + 0.1 * rng.normal(size=600)


def test_blocks_add_up_to_the_whole(problem):
    theta, _, y = problem
    whole = regression.gram(theta, y)
    blocks = regression.block_grams(lambda rows: theta[rows], y, 7)
    joined = regression.total(blocks)
    np.testing.assert_allclose(joined.xx, whole.xx, rtol=1e-10)
    np.testing.assert_allclose(joined.xy, whole.xy, rtol=1e-8)
    assert joined.n == whole.n == sum(block.n for block in blocks)


def test_leaving_a_block_out_is_a_subtraction(problem):
    theta, _, y = problem
    whole, first = regression.gram(theta, y), regression.gram(theta[:50], y[:50])
    rest = whole - first
    np.testing.assert_allclose(rest.xx, regression.gram(theta[50:], y[50:]).xx, rtol=1e-7)
    assert rest.n == 550


def test_least_squares_equals_lstsq_on_the_rows(problem):
    theta, _, y = problem
    support = [1, 4, 5]
    coef = regression.least_squares(regression.gram(theta, y), support)
    expected = np.linalg.lstsq(theta[:, support], y, rcond=None)[0]
    np.testing.assert_allclose(coef[support], expected, rtol=1e-6)
    assert np.count_nonzero(coef) == 3


def test_projecting_columns_out_leaves_the_other_coefficients(problem):
    theta, _, y = problem
    left = regression.gram(theta[:, [1, 5, 9]], y).without(1)
    expected = np.linalg.lstsq(theta[:, [1, 5, 9]], y, rcond=None)[0][1:]
    np.testing.assert_allclose(regression.least_squares(left, [0, 1]), expected, rtol=1e-6)


def test_elimination_keeps_the_true_terms_whatever_their_units(problem):
    theta, coef, y = problem
    kept = regression.prune(regression.gram(theta, y), np.arange(12))
    assert sorted(kept) == list(np.flatnonzero(coef))


def test_elimination_walks_down_by_least_squares(problem):
    theta, _, y = problem
    gram = regression.gram(theta, y)
    for support, error in regression.eliminate(gram, range(12), np.ones(12), 600.0):
        columns = theta[:, support]
        residual = y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]
        assert error == pytest.approx(float(residual @ residual), rel=1e-6)


def test_a_higher_price_keeps_fewer_terms(problem):
    theta, _, y = problem
    gram = regression.gram(theta, y)
    sizes = [len(regression.prune(gram, range(12), np.full(12, p))) for p in (0.0, 10.0, 1e5)]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[-1] == 0


def test_max_terms_bounds_the_support(problem):
    theta, _, y = problem
    assert len(regression.prune(regression.gram(theta, y), range(12), max_terms=2)) == 2


def test_the_front_has_the_best_first_then_smaller_ones(problem):
    theta, coef, y = problem
    front = regression.front(regression.gram(theta, y), [range(12), range(6)])
    assert [len(support) for support in front] == [3, 2, 1, 0]
    assert sorted(front[0]) == list(np.flatnonzero(coef))


def test_supports_hold_the_true_terms(problem):
    theta, coef, y = problem
    found = regression.supports(regression.gram(theta, y), 8)
    assert any(set(np.flatnonzero(coef)) <= set(support) for support in found)


def test_gains_are_those_of_refits(problem):
    theta, _, y = problem
    gram = regression.gram(theta / np.std(theta, axis=0), y)
    support = [1, 5, 7]
    with_column, without = regression.gains(gram, support)

    def error(columns):
        return regression.rss(gram, regression.least_squares(gram, columns))

    assert with_column[9] == pytest.approx(error([1, 5, 7, 9]), rel=1e-8)
    assert without[5] == pytest.approx(error([1, 7]), rel=1e-8)
    assert with_column[5] == pytest.approx(error(support), rel=1e-8)


def test_a_term_that_helps_in_one_block_only_is_dropped():
    rng = np.random.default_rng(1)
    theta = rng.normal(size=(1200, 2))
    y = theta[:, 0] + 0.1 * rng.normal(size=1200)
    y[:100] += theta[:100, 1]
    blocks = regression.block_grams(lambda rows: theta[rows], y, 12)
    whole = regression.total(blocks)
    folds = [whole - block for block in blocks]
    assert sorted(regression.prune(whole, [0, 1])) == [0, 1]
    assert regression.stable(whole, folds, [0, 1]).tolist() == [0]


def test_a_term_below_the_error_of_a_derivative_is_dropped():
    rng = np.random.default_rng(2)
    theta = rng.normal(size=(5000, 3))
    y = theta @ [1.0, 1e-3, 0.0] + 1e-3 * rng.normal(size=5000)
    gram = regression.gram(theta, y)
    assert sorted(regression.prune(gram, range(3))) == [0, 1]
    assert regression.material(gram, [0, 1]).tolist() == [0]


def test_a_small_term_counts_where_nothing_else_is_left():
    rng = np.random.default_rng(2)
    theta = rng.normal(size=(5000, 2))
    gram = regression.gram(theta, theta @ [1.0, 1e-3])
    assert sorted(regression.material(gram, [0, 1])) == [0, 1]


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
