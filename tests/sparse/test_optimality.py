"""The elastic net satisfies its optimality conditions; predictions are theta @ coef.T."""

import numpy as np
import pytest
from sklearn.exceptions import ConvergenceWarning

from pysindy_evolve.optimizer import ElasticNet
from pysindy_evolve.sparse.gram import gram
from pysindy_evolve.sparse.proposals import path


@pytest.fixture
def problem():
    rng = np.random.default_rng(0)
    theta = rng.normal(size=(200, 8))
    theta[:, 3] = theta[:, 2] + 0.1 * rng.normal(size=200)
    return theta, theta @ [1.0, 0, 2.0, 0, 0, -0.5, 0, 0] + 0.2 * rng.normal(size=200)


def conditions(theta, y, coef, lambda1, lambda2):
    """Distance from the optimality conditions of equation (11), in units of lambda1."""
    slope = 2 * theta.T @ (theta @ coef - y) + 2 * lambda2 * coef
    active = coef != 0.0
    at = np.abs(slope[active] + lambda1 * np.sign(coef[active]))
    off = np.maximum(np.abs(slope[~active]) - lambda1, 0.0)
    return max([*at, *off]) / lambda1


@pytest.mark.parametrize("lambda2", [1e-3, 1.0, 100.0])
def test_every_knot_of_the_path_is_optimal(problem, lambda2):
    theta, y = problem
    weights, coefs = path(gram(theta, y), lambda2)
    assert len(weights) > 4
    for lambda1, coef in zip(weights[:-1], coefs[:-1], strict=True):
        assert conditions(theta, y, coef, lambda1, lambda2) < 1e-8


@pytest.mark.parametrize("lambda2", [0.0, 0.01, 1.0])
def test_support_at_given_weights_is_that_of_the_path_between_its_knots(problem, lambda2):
    theta, y = problem
    rms, n = np.sqrt(np.mean(theta**2, axis=0)), len(y)
    rows = gram(theta / rms, y / np.sqrt(np.mean(y**2)))
    weights, coefs = path(rows, lambda2 * n)
    for k in range(len(weights) - 1):
        at = 0.5 * (weights[k] + weights[k + 1]) / n
        support = np.flatnonzero(coefs[k] + coefs[k + 1])  # linear between the knots
        found = ElasticNet(lambda1=at, lambda2=lambda2).fit(theta, y).ind_[0]
        assert np.flatnonzero(found).tolist() == support.tolist()


def test_no_weight_on_absolute_values_keeps_every_column_that_is_not_zero(problem):
    theta, y = problem
    theta[:, 4] = 0.0
    found = ElasticNet(lambda1=0.0, lambda2=0.1).fit(theta, y).ind_[0]
    assert np.flatnonzero(found).tolist() == [0, 1, 2, 3, 5, 6, 7]


def test_too_few_sweeps_are_reported(problem):
    theta, y = problem
    with pytest.warns(ConvergenceWarning, match="increas"):
        ElasticNet(lambda1=1e-3, max_iter=1).fit(theta, y)


@pytest.mark.parametrize("parameters", [{}, {"lambda1": 0.1}, {"lambda1": 0.05, "lambda2": 0.1}])
def test_predictions_are_theta_times_coefficients(problem, parameters):
    theta, y = problem
    targets = np.column_stack([y, -y, theta[:, 1]])
    fitted = ElasticNet(**parameters).fit(theta, targets)
    assert fitted.coef_.shape == (3, 8)
    np.testing.assert_allclose(fitted.predict(theta), theta @ fitted.coef_.T, rtol=1e-12)


@pytest.mark.parametrize("parameters", [{}, {"lambda1": 0.1, "lambda2": 0.01}])
def test_coefficients_are_least_squares_on_the_support(problem, parameters):
    theta, y = problem
    fitted = ElasticNet(**parameters).fit(theta, y)
    support = fitted.ind_[0]
    assert 0 < support.sum() < 8
    residual = y - theta @ fitted.coef_[0]
    np.testing.assert_allclose(theta[:, support].T @ residual, 0.0, atol=1e-9 * len(y))
