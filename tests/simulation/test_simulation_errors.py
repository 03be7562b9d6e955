"""Errors of free runs and windows."""

import numpy as np
import pytest

from pysindy_evolve.simulation import simulate

from .sliding_systems import block


class TestErrors:
    t = np.linspace(0.0, 1.0, 11)

    @pytest.mark.parametrize(
        ("changed", "match"),
        [
            ({"x0": [0.0]}, r"simulate\(x0=...\) must hold 2 values, one for each of q, v; got"),
            ({"x0": [0.0, np.nan]}, r"simulate\(x0=...\) must be finite; got nan at \(1,\)"),
            (
                {"t": np.zeros(11)},
                r"simulate\(t=...\) must be strictly increasing; got a step of 0",
            ),
            ({"t": [0.0]}, r"simulate\(t=...\) must be a 1-D array of at least 2 times"),
            ({"u": None}, r"simulate\(u=...\) must be given: the equations have the inputs F"),
            ({"u": np.zeros(10)}, r"simulate\(u=...\) must have shape \(11, 1\); got \(10, 1\)"),
            ({"u": np.zeros((11, 2))}, r"must have shape \(11, 1\); got \(11, 2\)"),
            ({"u": np.full(11, np.inf)}, r"simulate\(u=...\) must be finite; got inf at \(0,\)"),
            ({"substeps": 0}, r"simulate\(substeps=...\) must be an integer of at least 1"),
            ({"tolerance": -1.0}, r"simulate\(tolerance=...\) must be above 0"),
            ({"on_divergence": "ignore"}, r"simulate\(on_divergence=...\) must be"),
        ],
    )
    def test_bad_values_are_named(self, changed, match):
        given = {"x0": [0.0, 0.0], "t": self.t, "u": np.zeros(11), **changed}
        with pytest.raises(ValueError, match=match):
            simulate(block(), **given)

    def test_input_of_equations_without_inputs_is_refused(self):
        with pytest.raises(ValueError, match="Leave u out"):
            simulate(block(inputs=()), [0.0, 0.0], self.t, np.zeros(11))

    def test_text_is_no_number(self):
        with pytest.raises(TypeError, match=r"simulate\(x0=...\) must be an array of numbers"):
            simulate(block(), ["a", "b"], self.t, self.t)

    def test_something_else_is_no_model(self):
        with pytest.raises(
            TypeError, match=r"simulate\(model=...\) must be a fitted pysindy.SINDy"
        ):
            simulate(3.0, [0.0], self.t)
