"""EvolvingLibrary and TermLibrary by themselves; bad input."""

import random
import tracemalloc
from itertools import pairwise

import numpy as np
import pysindy as ps
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from joblib import parallel_config

from pysindy_evolve.library import EvolvingLibrary
from pysindy_evolve.operators import Operator
from pysindy_evolve.optimizer import ElasticNet
from pysindy_evolve.term_library import TermLibrary
from pysindy_evolve.terms import ONE, call, mul, variable
from pysindy_evolve.training import training_data

PIECEWISE = ("add", "sub", "mul", "abs", "sgn")


@pytest.fixture
def data():
    rng = np.random.default_rng(0)
    x = rng.normal(size=(400, 2))
    y = 2 * x[:, 0] * x[:, 1] - 3 * np.sign(x[:, 1]) + 0.05 * rng.normal(size=400)
    return x, y[:, None]


def library(**parameters):
    chosen = {"operators": PIECEWISE, "population_size": 40, "n_generations": 8}
    return EvolvingLibrary(**{**chosen, "random_state": 0, **parameters})


def test_fit_with_a_target_works_outside_of_sindy(data):
    x, y = data
    fitted = library().fit(x, y)
    assert set(fitted.get_feature_names(["q", "v"])) == {"q v", "sgn(v)"}
    assert fitted.n_features_in_ == 2
    assert fitted.n_output_features_ == len(fitted.terms_) == 2
    theta = fitted.transform(x)
    assert theta.shape == (400, 2)
    assert fitted.get_feature_names() == fitted.get_feature_names(["x0", "x1"])


def test_a_flat_target_and_lists_of_trajectories_are_taken(data):
    x, y = data
    flat = library().fit(x, y[:, 0])
    parts = library().fit([x[:150], x[150:]], [y[:150], y[150:]])
    assert flat.terms_ == parts.terms_
    first, second = parts.transform([x[:150], x[150:]])
    np.testing.assert_array_equal(np.concatenate([first, second]), flat.transform(x))


def test_every_generation_leaves_a_record(data):
    x, y = data
    (history,) = library().fit(x, y).history_
    assert [generation.number for generation in history] == list(range(1, len(history) + 1))
    last = history[-1]
    assert last.n_terms == len(last.terms) == len(last.coef) == 2
    assert 0.0 < last.error < 0.01
    assert all(a.time <= b.time for a, b in pairwise(history))


@pytest.mark.parametrize(
    "backend",
    ["threading", pytest.param("loky", marks=pytest.mark.slow)],  # processes take long
)
def test_the_same_seed_gives_the_same_terms_whatever_n_jobs_is(backend, data):
    x, y = data
    targets = np.hstack([y, x[:, [0]] * np.abs(x[:, [1]])])
    one = library(random_state=5).fit(x, targets)
    with parallel_config(backend=backend):
        two = library(random_state=5, n_jobs=2).fit(x, targets)
    assert one.terms_ == two.terms_
    assert [len(h) for h in one.history_] == [len(h) for h in two.history_]


@pytest.mark.parametrize("make", [np.random.default_rng, np.random.RandomState])
def test_generators_are_taken_as_random_state(make, data):
    x, y = data
    one, two = (library(random_state=make(3)).fit(x, y) for _ in range(2))
    assert one.history_[0][0].terms == two.history_[0][0].terms


def test_streams_of_the_caller_are_untouched(data):
    x, y = data
    random.seed(1)
    np.random.seed(1)  # noqa: NPY002 the legacy stream is what must stay untouched
    before = random.getstate(), np.random.get_state()[1].tolist()  # noqa: NPY002
    library().fit(x, y)
    after = random.getstate(), np.random.get_state()[1].tolist()  # noqa: NPY002
    assert before == after


def test_fit_changes_no_parameter(data):
    x, y = data
    base = ps.PolynomialLibrary(degree=1)
    grown = library(base_library=base)
    before = grown.get_params(deep=False)
    grown.fit(x, y)
    assert grown.get_params(deep=False) == before
    assert vars(base) == vars(ps.PolynomialLibrary(degree=1))


def test_an_operator_of_the_user_is_found():
    relu = Operator("relu", lambda a: np.maximum(a, 0.0), 1)
    x = np.random.default_rng(0).normal(size=(300, 2))
    y = x[:, 0] * np.maximum(x[:, 1], 0.0)
    fitted = library(operators=("mul", relu)).fit(x, y)
    assert fitted.get_feature_names(["q", "v"]) == ["q relu(v)"]


def test_noise_alone_gives_a_library_that_works():
    rng = np.random.default_rng(0)
    x, noise = rng.normal(size=(300, 2)), rng.normal(size=(300, 1))
    fitted = library().fit(x, noise)
    assert fitted.terms_ == (ONE,)
    assert fitted.get_feature_names() == ["1"]
    model = ps.SINDy(feature_library=library(), optimizer=ElasticNet())
    with pytest.warns(UserWarning, match="kept no term for target 0, 1: none predicts"):
        model.fit(x, 0.1, x_dot=np.hstack([noise, rng.normal(size=(300, 1))]))
    assert model.complexity == 0


def test_scored_is_printed_is_predicted_at_zero_too(data):
    x, _ = data
    x = np.vstack([x, np.zeros((1, 2)), [[1.0, 0.0]]])
    x_dot = np.column_stack([x[:, 1], -x[:, 0] - np.sign(x[:, 1])])
    model = ps.SINDy(feature_library=library(), optimizer=ElasticNet())
    model.fit(x, 0.1, x_dot=x_dot, feature_names=["q", "v"])
    np.testing.assert_allclose(model.predict(x), x_dot, atol=1e-9)
    np.testing.assert_array_equal(model.predict(np.zeros((1, 2))), [[0.0, 0.0]])


def sign_until_ctrl_c():
    """A sign with which Ctrl-C comes at its sixtieth use."""
    count = 0

    def interrupting(a):
        nonlocal count
        count += 1
        if count == 60:
            raise KeyboardInterrupt
        return np.sign(a)

    return Operator("sg", interrupting, 1)


def test_ctrl_c_keeps_the_best_so_far(data):
    x, y = data
    with pytest.warns(UserWarning, match="interrupted after"):
        fitted = library(operators=("mul", "add", sign_until_ctrl_c()), n_generations=200).fit(x, y)
    assert fitted.n_output_features_ >= 1


def test_an_interrupt_ends_the_search_of_all_states(data):
    x, y = data
    operators = ("mul", "add", sign_until_ctrl_c())
    with pytest.warns(UserWarning, match="interrupted after"):
        fitted = library(operators=operators, n_generations=9).fit(
            x, np.hstack([y, y**2 + x[:, :1]])
        )
    assert len(fitted.history_[1]) == 1


def test_progress_shows_a_bar(data, capsys):
    x, y = data
    library(progress=True, n_generations=2).fit(x, y)
    assert "generation" in capsys.readouterr().err


def test_a_term_library_is_fixed():
    ((_, product),) = mul(variable(0), call(Operator("root3", np.cbrt, 1), variable(1))).parts
    fixed = TermLibrary([product])
    np.testing.assert_allclose(fixed.fit_transform(np.array([[2.0, 8.0]])), [[4.0]])
    assert fixed.get_feature_names(["q", "v"]) == ["q root3(v)"]
    with pytest.raises(ValueError, match="at least 2 columns; got 1"):
        TermLibrary([product]).fit(np.ones((3, 1)))


def bad_x(data, change):
    x, y = data
    x, y = x.copy(), y.copy()
    return change(x, y)


def put(array, value):
    array[7, 0] = value


def test_a_state_that_does_not_change_by_itself_has_an_empty_equation(data):
    x, y = data
    model = ps.SINDy(feature_library=library(), optimizer=ElasticNet())
    model.fit(x, 0.01, x_dot=np.column_stack([y, np.zeros(len(y))])[:, : x.shape[1]])
    assert not model.coefficients()[-1].any()
    assert model.coefficients()[0].any()


@pytest.mark.filterwarnings("ignore:2 axes labeled")  # PySINDy, of any flat array
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda x, y: (put(x, np.nan), (x, y))[1],
            r"fit\(x=...\) must be finite.*got nan at sample 7",
        ),
        (
            lambda x, y: (put(x, np.inf), (x, y))[1],
            r"fit\(x=...\) must be finite.*got inf at sample 7",
        ),
        (
            lambda x, y: (put(y, np.nan), (x, y))[1],
            r"fit\(y=...\) must be finite.*got nan at sample 7",
        ),
        (lambda x, y: (x, y[:-3]), r"as many samples as x; got \[397\] for \[400\]"),
        (lambda x, y: (x[:6], y[:6]), "more samples than terms"),
        (lambda x, y: (np.column_stack([x, np.ones(400)]), y), "constant column 2"),
        (lambda x, y: (x, np.zeros((400, 2))), "zeros in all columns"),
        (lambda x, y: (x, None), "base_library"),
        (lambda x, y: (x[:, 0], y), "must be 2-D"),
    ],
    ids=["nan", "inf", "nan in y", "lengths", "few", "constant", "zero", "no target", "flat"],
)
def test_bad_data_is_named_and_the_object_stays_usable(change, message, data):
    grown = library()
    with pytest.raises(ValueError, match=message):
        grown.fit(*bad_x(data, change))
    assert len(grown.fit(*data).terms_) == 2


@pytest.mark.parametrize(
    ("parameters", "error", "message"),
    [
        ({"crossover_rate": 1.5}, ValueError, r"crossover_rate=...\) must be in \[0, 1\]; got 1.5"),
        ({"mutation_rate": -0.1}, ValueError, r"mutation_rate=...\) must be in \[0, 1\]; got -0.1"),
        ({"mutation_rate": "high"}, TypeError, r"mutation_rate=...\) must be a number"),
        ({"population_size": 0}, ValueError, r"population_size=...\) must be at least 1; got 0"),
        ({"n_generations": 2.5}, TypeError, r"n_generations=...\) must be an integer; got 2.5"),
        ({"n_jobs": "all"}, TypeError, r"n_jobs=...\) must be an integer or None; got str"),
        ({"n_jobs": 0}, ValueError, r"n_jobs=...\) must be above or below 0; got 0"),
        ({"random_state": "0"}, TypeError, r"random_state=...\) must be an integer, a numpy gen"),
        ({"operators": ("plus",)}, ValueError, "must name built-in operators; got 'plus'"),
        (
            {"operators": (Operator("bad", lambda a: a[0], 1),)},
            ValueError,
            "must work element by element",
        ),
    ],
)
def test_bad_parameters_are_named_and_the_object_stays_usable(parameters, error, message, data):
    grown = library(**parameters)
    with pytest.raises(error, match=message):
        grown.fit(*data)
    grown.set_params(**{name: library().get_params()[name] for name in parameters})
    assert len(grown.fit(*data).terms_) == 2


@pytest.mark.parametrize("where", ["x", "x_dot", "u"])
def test_nan_that_passes_through_sindy_is_named(where, data):
    x, y = data
    arrays = {"x": x.copy(), "x_dot": np.hstack([y, y]), "u": np.sin(np.arange(400.0))[:, None]}
    arrays[where][5] = np.nan
    model = ps.SINDy(feature_library=library(), optimizer=ElasticNet())
    with pytest.raises(
        ValueError, match="must be finite, neither NaN nor inf; got nan at sample 5"
    ):
        model.fit(arrays["x"], 0.1, x_dot=arrays["x_dot"], u=arrays["u"])


numbers = st.one_of(
    st.sampled_from([0.0, 1.0, -1.0, 1e-12, 1e12, 1e200, 1e-300, np.nan, np.inf]),
    st.floats(-1e3, 1e3, width=32),
)


@settings(
    max_examples=150, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck)
)
@given(
    shape=st.tuples(st.integers(0, 30), st.integers(1, 3), st.integers(1, 2)),
    draw=st.data(),
    operators=st.sampled_from([("mul",), PIECEWISE, ("div", "exp", "log", "mul"), ("sqrt", "tan")]),
)
def test_random_input_ends_in_a_result_or_an_error_that_says_what_to_do(shape, draw, operators):
    n, width, n_targets = shape
    x = draw.draw(hnp.arrays(float, (n, width), elements=numbers))
    y = draw.draw(hnp.arrays(float, (n, n_targets), elements=numbers))
    grown = EvolvingLibrary(operators, population_size=6, n_generations=2, random_state=0)
    try:
        fitted = grown.fit(x, y)
    except ValueError as error:
        said = str(error)
    else:
        theta = fitted.transform(x)
        said = "" if theta.shape == (n, fitted.n_output_features_) else f"shape {theta.shape}"
        said += "" if np.isfinite(theta).all() else "not finite"
    assert said == "" or said.startswith("EvolvingLibrary.fit(")


def test_a_single_record_of_floats_is_not_copied(data):
    x, y = data
    columns, targets = training_data([x], [y])
    assert np.shares_memory(columns, x)
    assert np.shares_memory(targets, y)


@pytest.mark.slow
def test_memory_does_not_grow_with_rows_times_population():
    t = np.arange(1_000_000) * 1e-3
    x = np.column_stack([np.sin(t) * (1 + 0.3 * np.sin(0.1 * t)), np.cos(1.3 * t)])
    y = x[:, 0] * x[:, 1] - np.sign(x[:, 1]) + 0.1 * np.random.default_rng(0).normal(size=len(t))
    tracemalloc.start()
    try:
        fitted = library(population_size=80).fit(x, y)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert set(fitted.get_feature_names(["q", "v"])) == {"q v", "sgn(v)"}
    assert peak < 1.5 * (x.nbytes + y.nbytes)
