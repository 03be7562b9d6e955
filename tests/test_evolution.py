"""Algorithm 1 on systems whose equations are known, and its building blocks."""

import numpy as np
import pysindy as ps
import pytest
from scipy.integrate import solve_ivp

from pysindy_evolve.breeding.constants import tune
from pysindy_evolve.breeding.dictionary import Problem, build_dictionary, n_nodes_expanded, price
from pysindy_evolve.breeding.fitness import rate_terms
from pysindy_evolve.breeding.generation import Settings
from pysindy_evolve.datasets import duffing
from pysindy_evolve.evolution import evolve
from pysindy_evolve.library import EvolvingLibrary
from pysindy_evolve.operators import BUILTIN, resolve
from pysindy_evolve.optimizer import ElasticNet
from pysindy_evolve.sparse.elimination import default_penalty
from pysindy_evolve.sparse.gram import gram
from pysindy_evolve.terms import ONE, add, call, constant, div, mul, only_term, power, sub, variable

PIECEWISE = ("add", "sub", "mul", "abs", "sgn")

# name: right-hand side, start, length, step, {term: coefficient} of each equation
SYSTEMS = {
    "Lorenz": (
        lambda x: [10 * (x[1] - x[0]), x[0] * (28 - x[2]) - x[1], x[0] * x[1] - 8 / 3 * x[2]],
        (-8.0, 8.0, 27.0), 10.0, 0.005,
        [{"x0": -10, "x1": 10}, {"x0": 28, "x0 x2": -1, "x1": -1}, {"x0 x1": 1, "x2": -8 / 3}],
    ),
    "Lotka-Volterra": (
        lambda x: [x[0] - 0.5 * x[0] * x[1], -0.8 * x[1] + 0.3 * x[0] * x[1]],
        (2.0, 1.0), 20.0, 0.01,
        [{"x0": 1, "x0 x1": -0.5}, {"x1": -0.8, "x0 x1": 0.3}],
    ),
    "Van der Pol": (
        lambda x: [x[1], 1.5 * (1 - x[0] ** 2) * x[1] - x[0]],
        (1.0, 0.0), 20.0, 0.01,
        [{"x1": 1}, {"x1": 1.5, "x0^2 x1": -1.5, "x0": -1}],
    ),
    "pendulum": (
        lambda x: [x[1], -2 * np.sin(x[0]) - 0.1 * x[1]],
        (2.5, 0.0), 30.0, 0.01,
        [{"x1": 1}, {"sin(x0)": -2, "x1": -0.1}],
    ),
    "nothing but the states": (
        lambda x: [x[1], -x[0]],
        (1.0, 0.0), 20.0, 0.01,
        [{"x1": 1}, {"x0": -1}],
    ),
}  # fmt: skip
LONG = {"Van der Pol", "nothing but the states"}  # to fit


def simulated(name):
    right_side, start, length, step, truth = SYSTEMS[name]
    t = np.arange(0.0, length, step)
    solution = solve_ivp(
        lambda _, x: right_side(x), (0, length), start, t_eval=t, rtol=1e-9, atol=1e-9
    )
    x = solution.y.T
    return t, x, np.column_stack([np.broadcast_to(c, len(t)) for c in right_side(x.T)]), truth


def found(model):
    names, rows = model.get_feature_names(), model.coefficients()
    return [{n: c for n, c in zip(names, row, strict=True) if c} for row in rows]


def default_model(seed):
    return ps.SINDy(feature_library=EvolvingLibrary(random_state=seed), optimizer=ElasticNet())


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow if name in LONG else ()) for name in SYSTEMS],
)
def test_known_systems_are_exact_with_the_defaults_and_noise_on_the_derivative(name):
    t, x, x_dot, truth = simulated(name)
    noise = 0.02 * x_dot.std(axis=0) * np.random.default_rng(1).normal(size=x.shape)
    rows = found(default_model(1).fit(x, t, x_dot=x_dot + noise))
    assert [set(row) for row in rows] == [set(row) for row in truth]
    for row, true_row in zip(rows, truth, strict=True):
        assert row == pytest.approx(true_row, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("name", list(SYSTEMS))
@pytest.mark.parametrize("noise", [0.0, 0.001])
def test_known_systems_are_exact_with_derivatives_that_pysindy_computes(name, noise):
    t, x, _, truth = simulated(name)
    x = x + noise * x.std(axis=0) * np.random.default_rng(0).normal(size=x.shape)
    for seed in range(2):
        rows = found(default_model(seed).fit(x, t))
        assert [set(row) for row in rows] == [set(row) for row in truth]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("friction", "snr"), [(False, 20.0), (True, 20.0), (True, 30.0)])
def test_the_duffing_rigs_of_the_paper_are_exact(friction, snr, seed):
    rig = duffing(friction=friction, experiment=1, snr_db=snr, random_state=seed)
    x = np.column_stack([rig.x, rig.u])[rig.train]
    evolution = evolve(
        x,
        rig.x_dot[rig.train, 1],
        operators=resolve(PIECEWISE),
        rng=np.random.default_rng(seed),
    )
    names = {term.name(rig.names) for term in evolution.terms}
    assert names == {"q", "v", "q^3", "zdd"} | ({"sgn(v)", "q^2 sgn(v)"} if friction else set())


@pytest.fixture
def data():
    rng = np.random.default_rng(0)
    x = rng.uniform(0.5, 4.0, size=(1500, 2))
    return x, rng.normal(size=1500)


def grow(x, y, seed=0, operators=PIECEWISE, **parameters):
    return evolve(x, y, operators=resolve(operators), rng=np.random.default_rng(seed), **parameters)


@pytest.mark.parametrize(
    ("operators", "truth"),
    [
        (("mul", "div", "add"), lambda x: x[:, 1] / (0.7 + x[:, 0])),
        (("mul", "sin"), lambda x: np.sin(1.7 * x[:, 0]) * x[:, 1]),
        pytest.param(("mul", "exp"), lambda x: np.exp(-0.6 * x[:, 0]), marks=pytest.mark.slow),
    ],
    ids=["x/(c + x)", "sin(w x)", "exp(-c x)"],
)
def test_inner_constants_are_found(operators, truth, data):
    x, noise = data
    clean = truth(x)
    evolution = grow(x, clean + 0.01 * clean.std() * noise, operators=operators)
    fit = sum(c * t.evaluate(x) for c, t in zip(evolution.coef, evolution.terms, strict=True))
    assert np.std(fit - clean) < 0.002 * np.std(clean)
    assert len(evolution.terms) <= 2


def test_inner_constants_are_tuned_by_variable_projection(data):
    x, noise = data
    q, v = variable(0), variable(1)
    true = only_term(div(v, add(constant(0.7), q)))
    y = 3.0 * true.evaluate(x) - 2.0 * x[:, 0] + 1e-3 * noise
    start = true.with_constants([3.0])
    (tuned,) = tune([start], x, y, x[:, [0]])
    assert tuned.constants[0] == pytest.approx(0.7, rel=0.01)


def test_fixed_columns_stay_out_of_the_terms(data):
    x, noise = data
    y = 5.0 * x[:, 0] ** 2 + 2.0 * x[:, 0] * x[:, 1] + 0.01 * noise
    evolution = grow(x, y, fixed=x[:, [0]] ** 2)
    assert [t.name("qv") for t in evolution.terms] == ["q v"]
    assert evolution.coef[0] == pytest.approx(2.0, rel=0.01)


def test_a_linear_map_on_the_rows_goes_before_the_regression(data):
    x, noise = data
    y = 2.0 * x[:, 0] * x[:, 1] - x[:, 0] + 0.5 * noise

    def means(columns):
        return columns.reshape(-1, 5, columns.shape[1]).mean(axis=1)

    evolution = grow(x, y, project=means)
    assert {t.name("qv") for t in evolution.terms} == {"q v", "q"}


@pytest.mark.parametrize(
    "seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 5))]
)
def test_noise_alone_grows_nothing(seed, data):
    x, _ = data
    noise = np.random.default_rng(seed + 100).normal(size=len(x))
    evolution = grow(x, noise, seed=seed, settings=Settings(n_generations=10))
    assert evolution.terms == ()


def test_the_search_ends_early_when_nothing_is_left_to_explain(data):
    x, _ = data
    evolution = grow(x, 2.0 * x[:, 0])
    assert [t.name("qv") for t in evolution.terms] == ["q"]
    assert len(evolution.history) <= 4


def test_a_dictionary_holds_each_signal_once_and_nothing_useless(data):
    x, _ = data
    x = np.column_stack([x, x[:, 0] - 2.0])
    q, v = variable(0), variable(1)
    half_defined = call(BUILTIN["log"], variable(2))
    terms = [only_term(t) for t in (q, v, call(BUILTIN["abs"], q), mul(q, v), half_defined)]
    dictionary = build_dictionary(Problem(x, x[:, 0], np.empty((len(x), 0))), [ONE, *terms])
    assert {t.name("qvw") for t in dictionary.terms} == {"1", "q", "v", "q v"}
    np.testing.assert_allclose(np.sqrt(np.mean(dictionary.theta**2, axis=0)), 1.0)


def test_a_term_that_only_fits_one_sample_is_left_out(data):
    x, _ = data
    x[3, 0] = 1e-9
    inverse = only_term(power(variable(0), -2))
    dictionary = build_dictionary(Problem(x, x[:, 1], np.empty((len(x), 0))), [inverse])
    assert dictionary.terms == ()


def test_a_slow_term_stays_whose_spectrum_is_one_line():
    q = np.sin(2.0 * np.pi * np.arange(400) / 400.0)
    x = np.column_stack([q, np.eye(400)[7]])  # a wave, and a single sample
    slow, spike = only_term(variable(0)), only_term(variable(1))

    def lines(columns):
        return np.fft.rfft(columns, axis=0).imag

    dictionary = build_dictionary(Problem(x, q, np.empty((400, 0)), lines), [slow, spike])
    assert dictionary.terms == (slow,)


def test_fitness_prefers_the_term_that_replaces_many(data):
    x, _ = data
    q, v = variable(0), variable(1)
    short = only_term(div(v, add(constant(1.0), q)))
    powers = [only_term(mul(v, power(q, n))) for n in (1, 2, 3, 4)]
    y = short.evaluate(x)
    problem = Problem(x, y, np.empty((len(x), 0)))
    dictionary = build_dictionary(problem, [only_term(v), *powers, short])
    many = np.array([dictionary.terms.index(t) for t in (only_term(v), *powers)])
    fitness, _ = rate_terms(dictionary, [many, many[:2], many[:0]], float(len(y)))
    assert dictionary.terms[int(np.argmin(fitness))] == short


def test_powers_and_constants_have_their_price():
    q = variable(0)
    ninth, sine = only_term(power(q, 9)), only_term(call(BUILTIN["sin"], q))
    assert n_nodes_expanded(ninth) > n_nodes_expanded(sine)
    saturating = only_term(div(q, add(constant(0.5), q)))
    costs = price([sine, saturating], 1000.0)
    assert costs[1] - costs[0] > np.log(1000.0)
    assert default_penalty(gram(np.eye(4), np.ones(4)), 4.0)[0] > 0


def test_a_frequency_costs_more_than_another_constant():
    q = variable(0)
    wave = only_term(call(BUILTIN["sin"], mul(constant(4.4), q)))
    curve = only_term(call(BUILTIN["tanh"], mul(constant(4.4), q)))
    costs = price([wave, curve, only_term(call(BUILTIN["sin"], q))], 1000.0)
    assert costs[0] > costs[1] + np.log(1000.0)
    assert costs[2] < costs[1]


def test_a_kink_that_no_row_reaches_is_no_term(data):
    x, _ = data
    q, v = variable(0), variable(1)
    far = float(x[:, 0].max()) + 1.0
    idle = call(BUILTIN["abs"], sub(q, constant(far)))
    active = call(BUILTIN["abs"], sub(q, constant(float(np.median(x[:, 0])))))
    terms = [only_term(mul(v, idle)), only_term(active)]
    dictionary = build_dictionary(Problem(x, x[:, 1], np.empty((len(x), 0))), terms)
    assert dictionary.terms == (only_term(active),)
