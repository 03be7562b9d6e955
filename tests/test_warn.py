"""Every warning points at the line of the user, whichever libraries lie between."""

import warnings

import numpy as np
import pysindy as ps
import pytest

import pysindy_evolve as pse

T = np.arange(0.0, 10.0, 0.05)


def decay():
    return pse.Record(T, np.exp(-T)[:, None], -np.exp(-T)[:, None])


def late():
    """Times that begin long after zero."""
    record, model = decay(), pse.DeclaredModel({"x": "-a*x"})
    shifted = pse.Record(record.t + 1e6, record.x, record.x_dot)
    pse.close_loop(model, shifted, operators=(), max_effects=0, random_state=0)


def empty():
    """An optimizer inside a SINDy model that keeps nothing of noise."""
    rng = np.random.default_rng(0)
    x, x_dot = rng.standard_normal((2, 200, 1))
    model = ps.SINDy(optimizer=pse.ElasticNet(), feature_library=ps.PolynomialLibrary(degree=1))
    model.fit(x, t=T, x_dot=x_dot)


def diverging():
    explosion = pse.DeclaredModel({"x": "x**2"}).design().equations([])
    pse.simulate(explosion, [1.0], T)


@pytest.mark.parametrize("user", [late, empty, diverging])
def test_a_warning_names_the_line_of_the_user(user):
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        user()
    assert seen
    assert {warning.filename for warning in seen} == {__file__}
