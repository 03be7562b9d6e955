"""Backward elimination: the true terms stay, the price decides how many, every size is kept."""

import numpy as np
import pytest

from pysindy_evolve.sparse.elimination import default_penalty, eliminate, front, gains
from pysindy_evolve.sparse.gram import gram, least_squares, rss


def walked(rows, proposals, penalty=None, max_terms=None):
    penalty = default_penalty(rows, rows.n) if penalty is None else penalty
    return front(rows, proposals, penalty, rows.n, max_terms)


def test_elimination_keeps_the_true_terms_whatever_their_units(sparse_problem):
    theta, coef, y = sparse_problem
    kept = walked(gram(theta, y), [np.arange(12)])[0]
    assert sorted(kept) == list(np.flatnonzero(coef))


def test_elimination_walks_down_by_least_squares(sparse_problem):
    theta, _, y = sparse_problem
    rows = gram(theta, y)
    for support, error in eliminate(rows, range(12), np.ones(12), 600.0):
        columns = theta[:, support]
        residual = y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]
        assert error == pytest.approx(float(residual @ residual), rel=1e-6)


def test_a_higher_price_keeps_fewer_terms(sparse_problem):
    theta, _, y = sparse_problem
    rows = gram(theta, y)
    sizes = [len(walked(rows, [range(12)], np.full(12, p))[0]) for p in (0.0, 10.0, 1e5)]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[-1] == 0


def test_max_terms_bounds_the_support(sparse_problem):
    theta, _, y = sparse_problem
    assert len(walked(gram(theta, y), [range(12)], max_terms=2)[0]) == 2


def test_the_front_has_the_best_first_then_smaller_ones(sparse_problem):
    theta, coef, y = sparse_problem
    found = walked(gram(theta, y), [range(12), range(6)])
    assert [len(support) for support in found] == [3, 2, 1, 0]
    assert sorted(found[0]) == list(np.flatnonzero(coef))


def test_gains_are_those_of_refits(sparse_problem):
    theta, _, y = sparse_problem
    rows = gram(theta / np.std(theta, axis=0), y)
    support = [1, 5, 7]
    with_column, without = gains(rows, support)

    def error(columns):
        return rss(rows, least_squares(rows, columns))

    assert with_column[9] == pytest.approx(error([1, 5, 7, 9]), rel=1e-8)
    assert without[5] == pytest.approx(error([1, 7]), rel=1e-8)
    assert with_column[5] == pytest.approx(error(support), rel=1e-8)
