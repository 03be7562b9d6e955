"""Gram matrices: blocks, projections and least squares agree with the rows."""

import numpy as np
import pytest

from pysindy_evolve.sparse.gram import (
    Gram,
    block_grams,
    gram,
    inverse,
    least_squares,
    refined,
    residual,
    target_grams,
    total,
)


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


def test_several_targets_share_one_pass(sparse_problem):
    theta, _, y = sparse_problem
    targets = np.column_stack([y, theta[:, 2], -y])
    shared = target_grams(lambda rows: theta[rows], targets, 5)
    for blocks, column in zip(shared, targets.T, strict=True):
        for one, other in zip(
            blocks, block_grams(lambda rows: theta[rows], column, 5), strict=True
        ):
            np.testing.assert_allclose(one.xx, other.xx, rtol=1e-12)
            np.testing.assert_allclose(one.xy, other.xy, rtol=1e-9, atol=1e-9)
            assert one.yy == pytest.approx(other.yy)
            assert one.n == other.n


def test_refinement_gives_back_what_the_gram_matrix_rounds_away():
    rng = np.random.default_rng(0)
    base = rng.normal(size=20_000)
    theta = np.column_stack([base, base + 1e-5 * rng.normal(size=20_000)])
    truth = np.array([2.0, -1.0])
    y = theta @ truth
    whole = gram(theta, y)
    rough = np.abs(least_squares(whole, [0, 1]) - truth).max()
    fine = np.abs(refined(lambda rows: theta[rows], y, whole) - truth).max()
    assert fine < 0.05 * rough


def test_the_residual_is_taken_in_pieces_and_is_the_same(sparse_problem, monkeypatch):
    theta, _, y = sparse_problem
    monkeypatch.setattr("pysindy_evolve.sparse.gram.ROWS_PER_CHUNK", 64)
    coef = np.arange(theta.shape[1], dtype=float)
    left = residual(lambda rows: theta[rows], y, coef)
    np.testing.assert_allclose(left, y - theta @ coef, rtol=1e-9, atol=1e-9)


def test_an_inverse_exists_for_equal_columns_and_for_none(sparse_problem):
    theta, _, y = sparse_problem
    twice = gram(np.column_stack([theta[:, 0], theta[:, 0]]), y)
    assert np.isfinite(inverse(twice)).all()
    assert inverse(gram(theta[:, :0], y)).shape == (0, 0)


def test_an_indefinite_matrix_is_inverted_by_its_eigenvalues():
    indefinite = Gram(np.diag([1.0, -0.5]), np.ones(2), 1.0, 1)
    np.testing.assert_allclose(inverse(indefinite), np.diag([1.0, -2.0]), rtol=1e-9)


def test_what_rounding_leaves_of_a_column_without_rows_has_no_scale():
    emptied = Gram(np.diag([16.0, -1e-18]), np.zeros(2), 1.0, 4)
    assert emptied.scale.tolist() == [2.0, 1.0]
