"""Gram matrices: blocks, projections and least squares agree with the rows."""

import numpy as np

from pysindy_evolve.gram import block_grams, gram, least_squares, total


def test_blocks_add_up_to_the_whole(sparse_problem):
    theta, _, y = sparse_problem
    whole = gram(theta, y)
    blocks = block_grams(lambda rows: theta[rows], y, 7)
    joined = total(blocks)
    np.testing.assert_allclose(joined.xx, whole.xx, rtol=1e-10)
    np.testing.assert_allclose(joined.xy, whole.xy, rtol=1e-8)
    assert joined.n == whole.n == sum(block.n for block in blocks)


def test_leaving_a_block_out_is_a_subtraction(sparse_problem):
    theta, _, y = sparse_problem
    whole, first = gram(theta, y), gram(theta[:50], y[:50])
    rest = whole - first
    np.testing.assert_allclose(rest.xx, gram(theta[50:], y[50:]).xx, rtol=1e-7)
    assert rest.n == 550


def test_least_squares_equals_lstsq_on_the_rows(sparse_problem):
    theta, _, y = sparse_problem
    support = [1, 4, 5]
    coef = least_squares(gram(theta, y), support)
    expected = np.linalg.lstsq(theta[:, support], y, rcond=None)[0]
    np.testing.assert_allclose(coef[support], expected, rtol=1e-6)
    assert np.count_nonzero(coef) == 3


def test_projecting_columns_out_leaves_the_other_coefficients(sparse_problem):
    theta, _, y = sparse_problem
    left = gram(theta[:, [1, 5, 9]], y).without(1)
    expected = np.linalg.lstsq(theta[:, [1, 5, 9]], y, rcond=None)[0][1:]
    np.testing.assert_allclose(least_squares(left, [0, 1]), expected, rtol=1e-6)
