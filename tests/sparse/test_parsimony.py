"""What proposes terms, and what a term must be to stay."""

import numpy as np
import pytest

from pysindy_evolve.sparse import parsimony
from pysindy_evolve.sparse.elimination import default_penalty, front
from pysindy_evolve.sparse.gram import Gram, block_grams, total
from pysindy_evolve.sparse.gram import gram as gram_of
from pysindy_evolve.sparse.proposals import supports
from pysindy_evolve.sparse.selection import effective_size


def pruned(rows, support):
    return front(rows, [support], default_penalty(rows, rows.n), rows.n)[0]


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def test_supports_hold_the_true_terms(sparse_problem):
    theta, coef, y = sparse_problem
    found = supports(gram_of(theta, y), 8)
    assert any(set(np.flatnonzero(coef)) <= set(support) for support in found)


def test_a_term_that_helps_in_one_block_only_is_dropped():
    rng = np.random.default_rng(1)
    theta = rng.normal(size=(1200, 2))
    y = theta[:, 0] + 0.1 * rng.normal(size=1200)
    y[:100] += theta[:100, 1]
    blocks = block_grams(lambda rows: theta[rows], y, 12)
    whole = total(blocks)
    folds = [whole - block for block in blocks]
    assert sorted(pruned(whole, [0, 1])) == [0, 1]
    assert parsimony.drop_unstable(whole, folds, [0, 1]).tolist() == [0]


def test_a_term_below_the_error_of_a_derivative_is_dropped():
    rng = np.random.default_rng(2)
    theta = rng.normal(size=(5000, 3))
    y = theta @ [1.0, 1e-3, 0.0] + 1e-3 * rng.normal(size=5000)
    gram = gram_of(theta, y)
    assert sorted(pruned(gram, range(3))) == [0, 1]
    assert parsimony.drop_immaterial(gram, [0, 1]).tolist() == [0]


def test_a_small_term_counts_where_nothing_else_is_left():
    rng = np.random.default_rng(2)
    theta = rng.normal(size=(5000, 2))
    gram = gram_of(theta, theta @ [1.0, 1e-3])
    assert sorted(parsimony.drop_immaterial(gram, [0, 1])) == [0, 1]


def test_white_noise_counts_in_full_and_smooth_errors_do_not():
    white = np.random.default_rng(3).normal(size=4000)
    smooth = np.convolve(white, np.ones(50), mode="same")
    assert effective_size(white) == pytest.approx(4000, rel=0.1)
    assert effective_size(smooth) < 200
    assert effective_size(np.zeros(100)) == 100


def test_columns_of_zeros_and_no_columns_do_no_harm():
    zeros = gram_of(np.zeros((50, 2)), np.arange(50.0))
    assert len(pruned(zeros, [0, 1])) == 0
    none = Gram(np.empty((0, 0)), np.empty(0), 1.0, 50)
    assert [s.tolist() for s in front(none, [np.arange(0)], np.empty(0), 50.0)] == [[]]
    assert all(len(support) == 0 for support in supports(none, 5))


def equation_gram(columns, y):
    """Inner products of columns of unit RMS."""
    theta = np.column_stack(columns)
    return gram_of(theta / np.sqrt(np.mean(theta**2, axis=0)), y)


def test_a_term_makes_way_for_a_cheaper_one_that_says_the_same(rng):
    q, v = 0.01 * rng.standard_normal(2000), rng.standard_normal(2000)
    y = v + 0.05 * rng.standard_normal(2000)
    gram = equation_gram([v / (1.0 + q * v), v, q], y)
    cost, n_free = np.array([20.0, 10.0, 10.0]), np.zeros(3, dtype=int)
    assert parsimony.exchange_for_simpler(gram, [0], cost, n_free).tolist() == [1]
    assert parsimony.exchange_for_simpler(gram, [1], cost, n_free).tolist() == [1]


def test_a_term_stays_where_a_cheaper_one_leaves_more(rng):
    q = rng.uniform(-1.5, 1.5, 2000)
    y = np.sin(q) + 0.02 * rng.standard_normal(2000)
    gram = equation_gram([np.sin(q), q], y)
    assert parsimony.exchange_for_simpler(
        gram, [0], np.array([12.0, 10.0]), np.zeros(2, dtype=int)
    ) == [0]
    exact = equation_gram([np.sin(q), q], np.sin(q))
    assert parsimony.exchange_for_simpler(
        exact, [0], np.array([12.0, 10.0]), np.zeros(2, dtype=int)
    ) == [0]


def test_terms_that_cancel_are_dearer_than_one_that_does_not(rng):
    q, s = 0.01 * rng.standard_normal(2000), np.sign(rng.standard_normal(2000))
    y = q**2 * s + 1e-6 * rng.standard_normal(2000)
    gram = equation_gram([1.0 / (s - q), s, q, q**2 * s], y)
    cost = np.array([15.0, 10.0, 10.0, 20.0])
    assert 3 in parsimony.exchange_for_simpler(gram, [0, 1, 2], cost, np.zeros(4, dtype=int))


def test_a_free_constant_makes_way_for_a_term_that_fits_as_well_as_a_derivative_is_known(rng):
    x = rng.uniform(-2.0, 2.0, 2000)
    # The cube stands for the error of a finite difference.
    y = x + 1e-5 * x**3 + 1e-5 * rng.standard_normal(2000)
    gram = equation_gram([x * np.cosh(0.00447 * x), x], y)
    cost = np.array([20.0, 10.0])
    assert parsimony.exchange_for_simpler(gram, [0], cost, np.array([1, 0])).tolist() == [1]
    assert parsimony.exchange_for_simpler(gram, [0], cost, np.array([0, 0])).tolist() == [0]


def test_a_term_that_one_part_knows_alone_stays_if_it_is_known_well_there():
    rng = np.random.default_rng(0)
    x = rng.normal(size=(1200, 2))
    x[100:, 1] *= 0.01  # a transient: later there is nothing of it
    y = x[:, 0] + 0.2 * x[:, 1] + 0.3 * rng.normal(size=1200)
    theta = np.column_stack([x, rng.normal(size=1200)])
    theta[100:, 2] *= 0.01
    blocks = block_grams(lambda rows: theta[rows], y, 12)
    whole = total(blocks)
    folds = [whole - block for block in blocks]
    assert parsimony.drop_unstable(whole, folds, [0, 1, 2]).tolist() == [0, 1]


def test_a_term_worth_less_than_the_noise_moves_the_equation_by_is_dropped():
    rng = np.random.default_rng(0)
    theta = rng.normal(size=(2000, 2))
    y = theta @ [1.0, 0.05] + 0.1 * rng.normal(size=2000)
    (gram,) = block_grams(lambda rows: theta[rows], y)
    assert list(parsimony.drop_immaterial(gram, [0, 1])) == [0, 1]
    assert list(parsimony.drop_immaterial(gram, [0, 1], least=20.0)) == [0]


def test_a_large_term_that_shows_in_one_part_of_the_record_only_is_kept():
    rng = np.random.default_rng(0)
    theta = rng.normal(size=(2400, 2)) * [1.0, 0.02]
    theta[:200, 1] *= 50.0
    y = theta @ [1.0, 1.0] + 0.3 * rng.normal(size=2400) * np.linspace(0.1, 1.0, 2400)
    y[200:] += 0.5 * np.sign(theta[200:, 1]) * rng.normal(size=2200)
    blocks = block_grams(lambda rows: theta[rows], y, 12)
    whole = total(blocks)
    assert 1 in parsimony.drop_unstable(
        whole, [whole - block for block in blocks], [0, 1], min_ratio=50.0
    )
