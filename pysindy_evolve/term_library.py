"""`TermLibrary`, a fixed library of terms, and the base class that it shares with evolving ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from pysindy.feature_library.base import BaseFeatureLibrary, x_sequence_or_item
from pysindy.utils import AxesArray, comprehend_axes
from sklearn.utils.validation import check_is_fitted

from . import checks, handover
from .sparse.gram import chunks
from .terms import Cache, Product
from .training import numbers


class TermColumns(BaseFeatureLibrary):
    """Base of fixed and evolving libraries: columns of a base library, then terms."""

    terms_: tuple[Product, ...]
    base_library_: BaseFeatureLibrary | None = None

    @x_sequence_or_item
    def transform(self, x_full: list[Any]) -> list[Any]:
        """Evaluate the library.

        Parameters
        ----------
        x_full : ndarray of shape (n_samples, n_features), or list of them
            States and inputs of each trajectory.

        Returns
        -------
        ndarray of shape (n_samples, n_output_features), or list of them

        Raises
        ------
        ValueError
            If x has other columns than in `fit`, or a value that is not finite.
        TypeError
            If x is not made of real numbers.
        sklearn.exceptions.NotFittedError
            If the library has not been fitted.
        """
        handover.forget(self)
        check_is_fitted(self, "terms_")
        return [self._theta(x) for x in x_full]

    def get_feature_names(self, input_features: Sequence[str] | None = None) -> list[str]:
        """Return the names of the columns, such as ``q^2 sgn(v)``.

        Parameters
        ----------
        input_features : sequence of str, optional
            Names of states and inputs, by default x0, x1, ...

        Returns
        -------
        list of str

        Raises
        ------
        ValueError
            If there are not as many names as columns of x.
        sklearn.exceptions.NotFittedError
            If the library has not been fitted.
        """
        check_is_fitted(self, "terms_")
        names = input_features or [f"x{i}" for i in range(self.n_features_in_)]
        checks.feature_names(names, self.n_features_in_)
        base = self.base_library_
        first = [] if base is None else list(base.get_feature_names(names))
        return first + [term.name(names) for term in self.terms_]

    def _theta(self, x: Any) -> AxesArray:
        """Evaluate the columns on states and inputs, whose last axis is that of `fit`."""
        x = np.asarray(x)
        self._check_columns(x)
        flat = numbers(f"{type(self).__name__}.transform", "x", x).reshape(-1, x.shape[-1])
        n_base = self.n_output_features_ - len(self.terms_)
        theta = np.empty((len(flat), self.n_output_features_))
        if self.base_library_ is not None:
            theta[:, :n_base] = np.asarray(self.base_library_.transform(x)).reshape(-1, n_base)
        for rows in chunks(0, len(flat)):  # in chunks, to save memory
            cache: Cache = {}
            piece = np.asfortranarray(flat[rows])
            for j, term in enumerate(self.terms_, n_base):
                theta[rows, j] = term.evaluate(piece, cache)
        theta = theta.reshape(*x.shape[:-1], -1)
        return AxesArray(theta, comprehend_axes(theta))

    def _check_columns(self, x: np.ndarray) -> None:
        if x.ndim < 2 or x.shape[-1] != self.n_features_in_:
            name, width = type(self).__name__, x.shape[-1] if x.ndim > 1 else 1
            raise ValueError(
                f"{name}.transform(x=...) must have the columns of fit; got shape {x.shape}: "
                f"X has {width} features, but {name} is expecting {self.n_features_in_} features "
                "as input. Pass the same states and inputs. Reshape your data with "
                "x.reshape(-1, 1) if it has one column."
            )


class TermLibrary(TermColumns):
    """A fixed PySINDy library of terms.

    Parameters
    ----------
    terms : sequence of Product
        Columns of the library. Variables are numbered as the columns of x, inputs last.

    Attributes
    ----------
    terms_ : tuple of Product
        The terms.
    n_features_in_, n_output_features_ : int
        Numbers of columns of x and of the library.

    Examples
    --------
    >>> import numpy as np
    >>> from pysindy_evolve.terms import mul, only_term, variable
    >>> product = only_term(mul(variable(0), variable(1)))
    >>> TermLibrary([product]).fit_transform(np.array([[2.0, 3.0]])).tolist()
    [[6.0]]
    """

    def __init__(self, terms: Sequence[Product]) -> None:
        self.terms = terms

    @x_sequence_or_item
    def fit(self, x_full: list[Any], y: Any = None) -> TermLibrary:
        """Count the columns.

        Parameters
        ----------
        x_full : ndarray of shape (n_samples, n_features), or list of them
            States and inputs of each trajectory.
        y : ignored
            Present for the interface.

        Returns
        -------
        TermLibrary
            Itself.

        Raises
        ------
        ValueError
            If a term needs a column that x does not have.
        """
        width = x_full[0].shape[-1]
        needed = max((max(term.variables, default=-1) for term in self.terms), default=-1) + 1
        if needed > width:
            raise ValueError(
                f"TermLibrary.fit(x=...) must have at least {needed} columns; got {width}. "
                "Pass all states and inputs that the terms use."
            )
        self.terms_ = tuple(self.terms)
        self.n_features_in_ = width
        self.n_output_features_ = len(self.terms_)
        return self
