"""Inputs, times and models of free runs, and what happens where they diverge."""

from types import SimpleNamespace

import numpy as np
import pysindy as ps
import pytest

from pysindy_evolve.equations import Equations
from pysindy_evolve.operators import BUILTIN, Operator
from pysindy_evolve.simulation import simulate
from pysindy_evolve.terms import ONE, call, constant, mul, power, sub, variable

from .sliding_systems import block, equations, sgn, total


class TestInputsAndTime:
    def test_input_is_linear_between_samples(self):
        integrator = equations([variable(1)], ("x",), ("u",))
        x = simulate(integrator, [0.0], [0.0, 1.0, 4.0], [0.0, 2.0, -1.0])
        np.testing.assert_allclose(x[:, 0], [0.0, 1.0, 2.5], atol=1e-12)

    def test_input_may_be_a_function_of_time(self):
        integrator = equations([variable(1)], ("x",), ("u",))
        t = np.linspace(0.0, 3.0, 61)
        x = simulate(integrator, [0.0], t, np.cos)
        np.testing.assert_allclose(x[:, 0], np.sin(t), atol=1e-5)

    def test_input_named_t_is_filled_with_time(self):
        ramp = equations([mul(variable(1), variable(2))], ("x",), ("u", "t"))
        t = np.linspace(0.0, 2.0, 21)
        x = simulate(ramp, [0.0], t, np.ones(21))
        np.testing.assert_allclose(x[:, 0], t**2 / 2, atol=1e-12)
        alone = equations([variable(1)], ("x",), ("t",))
        np.testing.assert_allclose(simulate(alone, [0.0], t)[:, 0], t**2 / 2, atol=1e-12)

    def test_time_itself_may_stand_in_a_term(self):
        forced = equations([call(BUILTIN["cos"], variable(1))], ("x",))
        t = np.linspace(1.0, 4.0, 31)
        x = simulate(forced, [0.0], t)
        np.testing.assert_allclose(x[:, 0], np.sin(t) - np.sin(1.0), atol=1e-9)

    def test_irregular_samples_give_the_same_motion_as_regular_ones(self):
        t = np.linspace(0.0, 3.0, 301)
        kept = np.sort(np.random.default_rng(1).choice(np.arange(1, 301), 60, replace=False))
        kept = np.r_[0, kept]
        rig = block(friction=1.0, stiffness=20.0, inputs=())
        all_samples = simulate(rig, [1.0, 0.0], t)
        np.testing.assert_allclose(simulate(rig, [1.0, 0.0], t[kept]), all_samples[kept], atol=1e-7)

    def test_fixed_substeps_converge(self):
        rig = block(friction=0.0, stiffness=400.0, inputs=())
        t = np.linspace(0.0, 1.0, 21)
        exact = np.cos(20 * t)
        errors = [
            np.abs(simulate(rig, [1.0, 0.0], t, substeps=n)[:, 0] - exact).max() for n in (1, 2, 4)
        ]
        assert errors[0] > 20 * errors[1] > 400 * errors[2]


class TestModels:
    def test_operator_of_the_user_is_called_as_it_was_scored(self):
        relu = Operator("relu", lambda a: np.maximum(a, 0.0), 1)
        row = mul(constant(-1.0), call(relu, sub(variable(0), constant(0.5))))
        t = np.linspace(0.0, 3.0, 31)
        x = simulate(equations([row], ("x",)), [1.5], t)
        np.testing.assert_allclose(x[:, 0], 0.5 + np.exp(-t), atol=1e-8)

    def test_inner_constants_are_simulated_with_their_values(self):
        for scale in (2.0, 3.0):
            row = call(BUILTIN["tanh"], mul(constant(scale), variable(1)))
            x = simulate(equations([row], ("x",), ("u",)), [0.0], [0.0, 1.0], [0.7, 0.7])
            assert x[1, 0] == pytest.approx(np.tanh(0.7 * scale), abs=1e-10)

    def test_same_threshold_in_two_terms_is_one_switch(self):
        from pysindy_evolve.simulation.structure import structure_of

        gate = sgn(sub(variable(0), constant(0.5)))
        row = total((-1.0, gate), (-1.0, mul(variable(0), gate)))
        assert len(structure_of(equations([row], ("x",)))[0].switches) == 1

    def test_fitted_sindy_and_objects_with_equations_are_taken(self):
        t = np.linspace(0.0, 4.0, 401)
        x = np.column_stack([np.cos(2 * t), -2 * np.sin(2 * t)])
        x_dot = np.column_stack([-2 * np.sin(2 * t), -4 * np.cos(2 * t)])
        model = ps.SINDy(feature_library=ps.PolynomialLibrary(1), optimizer=ps.STLSQ(0.1))
        model.fit(x, t, x_dot=x_dot)
        np.testing.assert_allclose(simulate(model, x[0], t), x, atol=1e-7)
        rig = block(inputs=())
        wrapped = simulate(SimpleNamespace(equations=rig), [0.0, 1.0], t)
        assert np.array_equal(wrapped, simulate(rig, [0.0, 1.0], t))

    def test_constant_rate(self):
        x = simulate(Equations((ONE,), np.array([[2.5]]), ("x",)), [1.0], [0.0, 2.0])
        np.testing.assert_allclose(x[:, 0], [1.0, 6.0], atol=1e-12)


class TestDivergence:
    @pytest.fixture
    def explosive(self):
        """x' = x^2 from 1 reaches infinity at t = 1.05."""
        return equations([mul(constant(1 / 1.05), power(variable(0), 2))], ("x",))

    def test_rest_is_nan_and_a_warning_names_the_time(self, explosive):
        t = np.linspace(0.0, 2.0, 21)
        with pytest.warns(RuntimeWarning, match=r"diverged at t = 1.1 \(sample 11\)"):
            x = simulate(explosive, [1.0], t)
        np.testing.assert_allclose(x[:11, 0], 1.05 / (1.05 - t[:11]), rtol=1e-6)
        assert np.isnan(x[11:]).all()

    def test_silent_and_raising(self, explosive):
        t = np.linspace(0.0, 2.0, 21)
        assert np.isnan(simulate(explosive, [1.0], t, on_divergence="nan")[-1, 0])
        with pytest.raises(FloatingPointError, match="diverged at t"):
            simulate(explosive, [1.0], t, on_divergence="raise")

    def test_leaving_the_domain_of_a_function_counts_as_divergence(self):
        row = sub(call(BUILTIN["sqrt"], variable(0)), constant(2.0))
        with pytest.warns(RuntimeWarning, match="diverged"):
            x = simulate(equations([row], ("x",)), [1.0], np.linspace(0.0, 5.0, 51))
        assert np.isfinite(x[0, 0])
        assert np.isnan(x[-1, 0])

    def test_bound_is_kept(self):
        t = np.linspace(0.0, 10.0, 101)
        with pytest.warns(RuntimeWarning, match="left the bound of 100"):
            x = simulate(equations([variable(0)], ("x",)), [1.0], t, bound=100.0)
        assert np.nanmax(x) <= 100.0

    def test_stiff_model_ends_with_a_warning_and_not_in_a_hang(self):
        row = total((-1e7, variable(0)), (1e7, variable(1)))
        stiff = equations([row], ("x",), ("u",))
        t = np.linspace(0.0, 10.0, 11)
        with pytest.warns(RuntimeWarning, match="steps"):
            simulate(stiff, [1.0], t, np.sin(t))
