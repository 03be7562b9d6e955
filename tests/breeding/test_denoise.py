"""Noise on all channels: what terms are grown on, and that the ordinary fit is cured by it."""

import numpy as np
import pysindy as ps
import pytest
from scipy.integrate import odeint

import pysindy_evolve as pse
from pysindy_evolve.breeding.denoise import denoise
from pysindy_evolve.breeding.dictionary import Problem
from pysindy_evolve.breeding.least_power import least_explained_power
from pysindy_evolve.datasets.rigs import noisy
from pysindy_evolve.equations import Equations
from pysindy_evolve.operators import BUILTIN, resolve
from pysindy_evolve.simulation import simulate
from pysindy_evolve.terms import call, mul, only_term, variable

PIECEWISE = ("add", "sub", "mul", "abs", "sgn")
DT = 0.004


@pytest.fixture(scope="module")
def slider():
    """A driven mass on a spring with dry friction: equations, clean x, x_dot and u."""
    q, v, u = variable(0), variable(1), variable(2)
    columns = [v, q, call(BUILTIN["sgn"], v), u]
    coef = np.array([[1.0, 0, 0, 0], [-0.4, -9.0, -1.5, 1.0]])
    equations = Equations(tuple(map(only_term, columns)), coef, ("q", "v"), ("u",))
    t = np.arange(12_000) * DT
    u = 8.0 * np.sin(2 * np.pi * (0.2 * t + 0.01 * t**2)) + 4.0 * np.sin(3.3 * t)
    x = simulate(equations, [0.5, 0.0], t, u)
    return equations, t, x, equations.evaluate(x, u), u


def measured(slider, snr_db, seed=0):
    """Return t, x, x_dot and u with noise on all of them."""
    _, t, x, x_dot, u = slider
    rng = np.random.default_rng(seed)
    q, v, a, u = (noisy(y, snr_db, rng) for y in (x[:, 0], x[:, 1], x_dot[:, 1], u))
    return t, np.column_stack([q, v]), np.column_stack([v, a]), u[:, None]


def fitted(slider, snr_db, optimizer, parts=1):
    t, x, x_dot, u = measured(slider, snr_db)
    library = pse.EvolvingLibrary(operators=PIECEWISE, random_state=0)
    model = ps.SINDy(feature_library=library, optimizer=optimizer)
    if parts == 1:
        return model.fit(x, t, x_dot=x_dot, u=u, feature_names=["q", "v", "u"])
    several = [np.array_split(column, parts) for column in (x, t, x_dot, u)]
    return model.fit(
        several[0], several[1], x_dot=several[2], u=several[3], feature_names=["q", "v", "u"]
    )


@pytest.mark.slow
@pytest.mark.parametrize("parts", [1, 3])
def test_equation_is_exact_with_noise_on_all_channels(slider, parts):
    model = fitted(slider, 30.0, pse.ElasticNet(), parts)
    names, coef = model.get_feature_names(), model.coefficients()
    found = dict(zip(names, coef[1], strict=True))
    assert {name for name, c in found.items() if c} == {"v", "q", "sgn(v)", "u"}
    true = {"v": -0.4, "q": -9.0, "sgn(v)": -1.5, "u": 1.0}
    for name, c in true.items():
        assert found[name] == pytest.approx(c, rel=0.03)


@pytest.mark.slow
def test_every_optimizer_gets_the_cured_terms(slider):
    model = fitted(slider, 30.0, ps.STLSQ(threshold=0.05))
    found = dict(zip(model.get_feature_names(), model.coefficients()[1], strict=True))
    assert found["sgn(v)"] == pytest.approx(-1.5, rel=0.03)


def test_rows_whose_signs_are_undecided_are_left_out(slider):
    _, x, x_dot, u = measured(slider, 30.0)
    rows = denoise(np.hstack([x, u]), x_dot, [len(x)], resolve(PIECEWISE, "test"))
    clean = slider[2][:, 1]
    kept = rows.kept
    assert 0.6 < kept.mean() < 0.99
    wrong = np.sign(rows.x[kept, 1]) != np.sign(clean[kept])
    assert wrong.sum() < 0.2 * np.sum(np.sign(x[:, 1]) != np.sign(clean))
    assert rows.of(x).shape == (kept.sum(), 2)


def test_rows_near_zero_stay_where_no_operator_has_a_kink(slider):
    _, x, x_dot, u = measured(slider, 30.0)
    rows = denoise(np.hstack([x, u]), x_dot, [len(x)], resolve(("add", "mul", "sin"), "test"))
    assert rows.kept.mean() > 0.9


def test_each_trajectory_is_smoothed_by_itself(slider):
    _, x, x_dot, u = measured(slider, 30.0)
    operators = resolve(PIECEWISE, "test")
    whole = np.hstack([x, u])
    first = denoise(whole[:5000], x_dot[:5000], [5000], operators)
    second = denoise(whole[5000:], x_dot[5000:], [7000], operators)
    both = denoise(whole, x_dot, [5000, 7000], operators)
    np.testing.assert_array_equal(both.x, np.concatenate([first.x, second.x]))
    np.testing.assert_array_equal(both.kept, np.concatenate([first.kept, second.kept]))


def test_clean_states_are_not_touched(slider):
    _, _, x, x_dot, u = slider
    whole = np.column_stack([x, u])
    target = x_dot + 0.1 * np.random.default_rng(0).standard_normal(x_dot.shape)
    rows = denoise(whole, target, [len(x)], resolve(PIECEWISE, "test"))
    assert rows.x is whole
    assert rows.kept is None
    assert rows.noise is None


@pytest.mark.parametrize("transient", [0.0, 1.0])
def test_rows_at_an_end_are_kept_if_no_other_row_reaches_their_states(transient):
    t = np.arange(6000) * 1e-3
    swing, fast = np.sin(6.0 * t + 1.0), transient * np.exp(-10.0 * t)
    x = np.column_stack([swing + fast, np.cos(6.0 * t + 1.0)])
    x_dot = np.column_stack([6.0 * x[:, 1] - 10.0 * fast, -6.0 * swing])
    rng = np.random.default_rng(0)
    measured, rates = (y + 0.01 * y.std(0) * rng.normal(size=y.shape) for y in (x, x_dot))
    kept = denoise(measured, rates, [len(t)], []).kept
    assert kept[:20].all() == bool(transient)
    assert not kept[-20:].any()
    assert kept[500:-500].mean() > 0.95


def test_transients_at_the_start_are_fitted_on():
    t = np.arange(6000) * 1e-3
    fast = np.exp(-10.0 * t)
    x = np.column_stack([np.exp(-0.5 * t) + 0.2 * fast, fast])
    rates = np.array([[-0.5, -1.9], [0.0, -10.0]])
    rng = np.random.default_rng(2)
    measured = [y + 3e-3 * y.std(0) * rng.normal(size=y.shape) for y in (x, x @ rates.T)]
    library = pse.EvolvingLibrary(random_state=0)
    model = ps.SINDy(feature_library=library, optimizer=pse.ElasticNet())
    model.fit(measured[0], t, x_dot=measured[1], feature_names=["a", "b"])
    off = model.predict(x) - x @ rates.T
    assert np.all(off.std(axis=0) < 1e-3 * (x @ rates.T).std(axis=0))


def rates_of_two_scales(x):
    a, b = x.T
    return np.column_stack([-0.5 * a + 200.0 * b**2, 0.5 * a - 200.0 * b**2 - 30.0 * b])


@pytest.mark.parametrize("ratio", [3e-3, 1e-2])
def test_terms_on_a_base_do_not_spoil_kinetics_of_two_time_scales(ratio):
    t = np.linspace(0.0, 6.0, 6000)
    rng = np.random.default_rng(1)
    starts = ([1.0, 0.0], [0.2, 0.05])
    clean = [
        odeint(lambda x, _: rates_of_two_scales(x[None])[0], x0, t, rtol=1e-9, atol=1e-12)
        for x0 in starts
    ]
    pairs = [(x, rates_of_two_scales(x)) for x in clean]
    sizes = [np.vstack(columns).std(axis=0) for columns in zip(*pairs, strict=True)]
    x, x_dot = (
        [pair[i] + ratio * sizes[i] * rng.normal(size=(len(t), 2)) for pair in pairs]
        for i in range(2)
    )
    library = pse.EvolvingLibrary(base_library=ps.PolynomialLibrary(degree=2), random_state=0)
    model = ps.SINDy(feature_library=library, optimizer=pse.ElasticNet()).fit(
        x, [t, t], x_dot=x_dot
    )
    states = np.vstack(clean)
    off = model.predict(states) - rates_of_two_scales(states)
    assert np.all(off.std(axis=0) < 5e-3 * sizes[1])


def test_noise_that_lies_where_the_slope_is_large_moves_an_equation_more():
    x = np.linspace(0.0, 1.0, 500)[:, None]
    square = [only_term(mul(variable(0), variable(0)))]
    steep = np.where(x > 0.9, 0.1, 0.0)
    even = np.full(x.shape, np.sqrt(np.mean(steep**2)))
    there, anywhere = (
        least_explained_power(Problem(x, x[:, 0], np.empty((500, 0)), noise=noise), square, [1.0])
        for noise in (steep, even)
    )
    assert there > 2.0 * anywhere


def test_noise_moves_an_equation_by_its_slope():
    x = np.random.default_rng(0).normal(size=(500, 2))
    q, v = variable(0), variable(1)
    terms = [only_term(mul(q, v)), only_term(v)]
    noise = np.array([0.1, 0.2])
    problem = Problem(x, x[:, 0], np.empty((500, 0)), noise=noise)
    share = least_explained_power(problem, terms, [2.0, 1.0]) / 500
    moved = np.mean((2 * x[:, 1] * 0.1) ** 2 + ((2 * x[:, 0] + 1) * 0.2) ** 2)
    assert share == pytest.approx(0.3 * moved)
    assert least_explained_power(Problem(x, x[:, 0], np.empty((500, 0))), terms, [2.0, 1.0]) == 0.0
