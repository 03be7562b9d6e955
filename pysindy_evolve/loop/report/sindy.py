"""Equations as a fitted SINDy model, so that PySINDy's own methods work on them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pysindy as ps
from pysindy.utils import AxesArray

from ...equations import Equations
from ...optimizer import ElasticNet
from ...term_library import TermLibrary
from ...terms import ONE


class TimedLibrary(TermLibrary):
    """A fixed library of terms whose last column is the time, as an effect depends on it."""

    def _theta(self, x: Any) -> AxesArray:
        if np.shape(x)[-1] == self.n_features_in_ - 1:
            raise ValueError(
                "LoopReport.model(u=...) must have the time as its last column; got none, and an "
                "effect depends on it. Give u=np.column_stack([u, t]) to simulate and predict, or "
                "u=t if there is no other input."
            )
        return super()._theta(x)


def as_sindy(equations: Equations) -> ps.SINDy:
    """Return a fitted SINDy model with these equations.

    Parameters
    ----------
    equations : Equations
        Terms and coefficients. If a term depends on time, the model has one more input, named t.

    Returns
    -------
    pysindy.SINDy
        `predict`, `score`, `print` and `simulate` work; `fit` fits new coefficients of the terms.
    """
    inputs = (*equations.inputs, "t") if equations.needs_time else equations.inputs
    n_variables = len(equations.states) + len(inputs)
    if not equations.terms:  # a library needs a column, even where all right-hand sides are zero
        equations = replace(equations, terms=(ONE,), coef=np.zeros((len(equations.states), 1)))
    library = (TimedLibrary if equations.needs_time else TermLibrary)(equations.terms)
    library.fit(np.ones((2, n_variables)))
    n_terms, n_states = len(equations.terms), len(equations.states)
    # Fitted to dummy data: the coefficients are replaced below.
    optimizer = ElasticNet().fit(np.eye(n_terms), np.ones((n_terms, n_states)))
    optimizer.coef_ = np.array(equations.coef, dtype=float)
    optimizer.ind_ = optimizer.coef_ != 0.0
    model = ps.SINDy(feature_library=library, optimizer=optimizer)
    model.n_control_features_ = len(inputs)
    model.feature_names = [*equations.states, *inputs]
    model.n_features_in_ = n_variables
    model.n_output_features_ = len(equations.terms)
    return model
