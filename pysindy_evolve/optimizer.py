"""ElasticNet: the optimizer for ``ps.SINDy``.

Equation (11) of the paper proposes the supports; least squares decides the coefficients.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.linear_model import ElasticNet as ElasticNetAtOneWeight
from sklearn.utils.validation import check_is_fitted, validate_data

from . import checks
from .sparse import parsimony
from .sparse.elimination import default_penalty
from .sparse.gram import Gram, least_squares, refined, residual, target_grams, total
from .sparse.parsimony import MIN_ROWS, N_BLOCKS
from .sparse.proposals import LAMBDA2, supports
from .sparse.selection import select
from .threads import one_thread
from .training import house_form, with_target
from .warn import warn

TOLERANCE = 1e-9  # of coordinate descent: duality gap, as a share of the target's power


class ElasticNet(MultiOutputMixin, RegressorMixin, BaseEstimator):
    r"""Sparse linear regression: an elastic net proposes, least squares decides.

    Each target is fitted by itself. Supports come from

    .. math:: \|\Theta\xi - \dot x\|^2 / n + \lambda_1\|\xi\|_1 + \lambda_2\|\xi\|^2

    on columns of unit RMS and a target of unit RMS, so the weights are dimensionless and the
    unit of a column does not matter.

    Parameters
    ----------
    lambda1 : float, optional
        Weight of the absolute values. By default it is swept downward from where the first term
        appears, each support is pruned backward by an information criterion, and the best one is
        kept.
    lambda2 : float, optional
        Weight of the squares. By default it is swept over orders of magnitude, or zero where
        `lambda1` is given.
    max_terms : int, default=30
        Largest number of terms in the sweep of `lambda1`; not used where `lambda1` is given.
    max_iter : int, default=10000
        Most sweeps of coordinate descent where `lambda1` is given; if they are too few,
        scikit-learn warns (ConvergenceWarning).
    copy_X : bool, default=True
        Present for PySINDy's `EnsembleOptimizer`; the data is never overwritten.

    Attributes
    ----------
    coef_ : ndarray of shape (n_targets, n_features)
        Least-squares coefficients on the support, in units of the target per unit of the column.
    intercept_ : float
        Zero: a constant is a term of the library.
    ind_ : ndarray of bool of shape (n_targets, n_features)
        The support.
    n_features_in_ : int
        Number of columns.

    References
    ----------
    Goharoodi et al., Mathematical Problems in Engineering 2020, 7286575, doi:10.1155/2020/7286575,
    equation (11).

    Examples
    --------
    >>> import numpy as np
    >>> theta = np.random.default_rng(0).normal(size=(200, 5))
    >>> ElasticNet().fit(theta, 3 * theta[:, 1] - 0.5 * theta[:, 4]).coef_.round(6)
    array([[ 0. ,  3. ,  0. ,  0. , -0.5]])
    """

    def __init__(
        self,
        lambda1: float | None = None,
        lambda2: float | None = None,
        *,
        max_terms: int = 30,
        max_iter: int = 10_000,
        copy_X: bool = True,
    ) -> None:
        self.lambda1 = lambda1
        self.lambda2 = lambda2
        self.max_terms = max_terms
        self.max_iter = max_iter
        self.copy_X = copy_X

    @one_thread()
    def fit(self, X: np.ndarray, y: np.ndarray) -> ElasticNet:
        """Fit one sparse row of coefficients to each target.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_features)
            Dictionary theta, rows in order of time.
        y : array-like of shape (n_samples,) or (n_samples, n_targets)
            Targets, such as x_dot.

        Returns
        -------
        ElasticNet
            Itself.

        Raises
        ------
        ValueError
            If a parameter is out of its range, there are fewer samples than terms, or a value is
            not finite. Rows at which y is NaN throughout are left out, as in PySINDy's optimizers.
        TypeError
            If a parameter is of the wrong type.
        """
        self._check_parameters()
        X, y = with_target(X, y)
        with house_form("ElasticNet.fit(X=..., y=...)"):
            X, y = validate_data(self, X, y, multi_output=True, y_numeric=True)
        theta, targets = np.asarray(X, dtype=float), np.asarray(y, dtype=float)
        self._one_target = targets.ndim == 1
        targets = targets.reshape(len(theta), -1)
        if len(theta) < theta.shape[1]:
            raise ValueError(
                "ElasticNet.fit(X=...) must have at least as many samples as terms; got "
                f"{len(theta)} samples for {theta.shape[1]} terms. Record longer or offer fewer."
            )
        # A row of zeros carries no information about any coefficient.
        rows = np.flatnonzero(theta.any(axis=1))
        if theta.shape[1] <= len(rows) < len(theta):
            theta, targets = theta[rows], targets[rows]
        self.coef_ = self._fit_targets(theta, targets)
        self._warn_of_empty(targets)
        self.ind_ = self.coef_ != 0.0
        self.intercept_ = 0.0
        return self

    def predict(self, X: np.ndarray) -> np.ndarray:
        """Return ``X @ coef_.T``.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_features)
            Dictionary theta.

        Returns
        -------
        ndarray of shape (n_samples, n_targets), or (n_samples,) after a fit to a flat target

        Raises
        ------
        sklearn.exceptions.NotFittedError
            Before `fit`.
        ValueError
            If X has other columns than in `fit`.
        """
        check_is_fitted(self)
        with house_form("ElasticNet.predict(X=...)"):
            X = validate_data(self, X, reset=False)
        result = np.asarray(X) @ self.coef_.T
        return result[:, 0] if self._one_target else result

    @property
    def complexity(self) -> int:
        """Number of coefficients that are not zero."""
        check_is_fitted(self)
        return int(np.count_nonzero(self.coef_))

    def _warn_of_empty(self, targets: np.ndarray) -> None:
        """Warn of targets that vary, but kept no term."""
        empty = np.flatnonzero(~self.coef_.any(axis=1) & (np.ptp(targets, axis=0) > 0.0))
        if len(empty):
            reason = (
                "none predicts the rows that it was not fitted on well enough. Offer other terms, "
                "record more, filter x_dot, or set lambda1, such as 1e-3, to keep terms all the "
                "same."
            )
            if self.lambda1 is not None:
                reason = f"lambda1={self.lambda1:g} is too large. Lower it, or leave it out."
            warn(f"ElasticNet kept no term for target {', '.join(map(str, empty))}: {reason}")

    def _fit_targets(self, theta: np.ndarray, targets: np.ndarray) -> np.ndarray:
        n, p = theta.shape
        n_blocks = N_BLOCKS if n >= N_BLOCKS * max(MIN_ROWS, 2 * p) else 1
        grams = target_grams(lambda rows: theta[rows], targets, n_blocks)
        coef = np.zeros((len(grams), p))
        for row, blocks, y in zip(coef, grams, targets.T, strict=True):
            support = self._support(theta, y, blocks)
            if len(support):
                part = total(blocks).select(support)
                row[support] = refined(lambda rows: theta[rows][:, support], y, part)  # noqa: B023
        return coef

    def _support(self, theta: np.ndarray, y: np.ndarray, blocks: list[Gram]) -> np.ndarray:
        whole = total(blocks)
        if whole.yy == 0.0:
            return np.arange(0)
        scale = whole.scale
        folds = [(whole - block).scaled(scale) for block in blocks]
        whole = whole.scaled(scale)
        if self.lambda1 is not None:
            return self._support_at(theta / scale, y, float(self.lambda1))
        weights = LAMBDA2 if self.lambda2 is None else (self.lambda2,)
        proposed = supports(whole, min(self.max_terms, len(scale)), weights)

        def left(support: np.ndarray) -> np.ndarray:
            coef = least_squares(whole, support) / scale
            return residual(lambda rows: theta[rows], y, coef)

        price = partial(default_penalty, whole)
        support = select(whole, proposed, price, left, whole.yy).best
        if len(blocks) > 1:
            support = parsimony.drop_unstable(whole, folds, support)
        return parsimony.drop_immaterial(whole, support)

    def _support_at(self, theta: np.ndarray, y: np.ndarray, lambda1: float) -> np.ndarray:
        """Return the support at given weights, by scikit-learn's form of equation (11)."""
        lambda2 = 0.0 if self.lambda2 is None else float(self.lambda2)
        half = 0.5 * lambda1
        if half == 0.0:  # no penalty draws a coefficient to exactly zero
            return np.flatnonzero(theta.any(axis=0))
        net = ElasticNetAtOneWeight(
            alpha=half + lambda2,
            l1_ratio=half / (half + lambda2),
            fit_intercept=False,
            max_iter=self.max_iter,
            tol=TOLERANCE,
        )
        return np.flatnonzero(net.fit(theta, y / np.sqrt(np.mean(y**2))).coef_)

    def _check_parameters(self) -> None:
        for name in ("lambda1", "lambda2"):
            value, advice = getattr(self, name), "Leave it out to have the weights swept."
            if value is not None:
                checks.real("ElasticNet", name, value, "at least 0", lambda v: v >= 0, advice)
        for name in ("max_terms", "max_iter"):
            advice = "Give a positive whole number."
            checks.integer("ElasticNet", name, getattr(self, name), 1, advice)
