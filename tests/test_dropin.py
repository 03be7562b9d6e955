"""EvolvingLibrary and ElasticNet inside an ordinary ps.SINDy, in every way it can be called."""

import gc
import pickle
import threading
import weakref

import joblib
import numpy as np
import pysindy as ps
import pytest
from scipy.integrate import solve_ivp
from sklearn.base import clone
from sklearn.model_selection import GridSearchCV, TimeSeriesSplit, cross_val_score

from pysindy_evolve import handover
from pysindy_evolve.library import EvolvingLibrary
from pysindy_evolve.optimizer import ElasticNet

OPERATORS = ("add", "sub", "mul", "abs", "sgn")
STEP = 0.02
TRUE = [{"v"}, {"q", "v", "q^3"}]
TRUE_DRIVEN = [{"v"}, {"q", "v", "q^3", "f"}]


def force(t):
    return np.cos(0.7 * t) + np.sin(1.9 * t)


def record(start, driven, length=12.0):
    """A stiffening spring with damping, states q and v."""

    def right_side(t, x):
        return [x[1], -2 * x[0] - 0.3 * x[1] - 0.5 * x[0] ** 3 + driven * force(t)]

    t = np.arange(0.0, length, STEP)
    x = solve_ivp(right_side, (0, length), start, t_eval=t, rtol=1e-9, atol=1e-9).y.T
    x_dot = np.column_stack(right_side(t, x.T))
    return t, x, x_dot, force(t)[:, None]


@pytest.fixture(scope="module")
def free():
    return record([2.0, 0.0], driven=False)


@pytest.fixture(scope="module")
def driven():
    return record([2.0, 0.0], driven=True)


def library(**parameters):
    settings = {
        "operators": OPERATORS,
        "population_size": 40,
        "n_generations": 10,
        "random_state": 0,
    }
    return EvolvingLibrary(**{**settings, **parameters})


def model(optimizer=None, **parameters):
    return ps.SINDy(feature_library=library(**parameters), optimizer=optimizer or ElasticNet())


def structure(fitted):
    names = fitted.get_feature_names()
    return [{n for n, c in zip(names, row, strict=True) if c} for row in fitted.coefficients()]


@pytest.mark.parametrize("repeat", ["as made", "after clone", "refitted", "loaded"])
@pytest.mark.parametrize("trajectories", [1, 2])
@pytest.mark.parametrize("inputs", [False, True], ids=["no u", "u"])
@pytest.mark.parametrize("given", [True, False], ids=["x_dot given", "x_dot computed"])
def test_it_evolves_in_every_call_of_fit(given, inputs, trajectories, repeat):
    records = [record(s, inputs) for s in ([2.0, 0.0], [-1.0, 1.5])[:trajectories]]
    t, x, x_dot, u = ([r[i] for r in records] for i in range(4))
    if trajectories == 1:
        t, x, x_dot, u = t[0], x[0], x_dot[0], u[0]
    keywords = {"feature_names": ["q", "v", "f"][: 2 + inputs]}
    keywords |= {"x_dot": x_dot} if given else {}
    keywords |= {"u": u} if inputs else {}
    fitted = model()
    if repeat == "after clone":
        fitted = clone(fitted)
    elif repeat == "refitted":
        fitted.fit(*record([1.0, 1.0], driven=False, length=3.0)[1::-1])
        fitted.score(*record([1.0, 1.0], driven=False, length=2.0)[1::-1])
    elif repeat == "loaded":
        fitted = pickle.loads(pickle.dumps(fitted))
    fitted.fit(x, t, **keywords)
    assert structure(fitted) == (TRUE_DRIVEN if inputs else TRUE)
    score = {"u": u} if inputs else {}
    assert fitted.score(x, t, x_dot=x_dot, **score) > 0.9999


def optimizers():
    return {
        "ElasticNet": ElasticNet(),
        "STLSQ": ps.STLSQ(threshold=0.05),
        "SR3": ps.SR3(reg_weight_lam=1e-4, tol=1e-12, max_iter=10_000),
        "ensemble of STLSQ": ps.EnsembleOptimizer(ps.STLSQ(0.05), bagging=True, n_models=5),
        "ensemble of ElasticNet": ps.EnsembleOptimizer(ElasticNet(), bagging=True, n_models=5),
        "library ensemble": ps.EnsembleOptimizer(
            ElasticNet(), bagging=True, library_ensemble=True, n_models=9
        ),
    }


@pytest.mark.parametrize("name", list(optimizers()))
def test_it_works_with_every_optimizer(name, driven):
    np.random.seed(0)  # noqa: NPY002 PySINDy's EnsembleOptimizer draws from the global stream
    t, x, x_dot, u = driven
    fitted = model(optimizers()[name]).fit(x, t, x_dot=x_dot, u=u, feature_names=["q", "v", "f"])
    assert structure(fitted) == TRUE_DRIVEN


@pytest.mark.parametrize(
    "optimizer", [ps.SSR(kappa=1e-9), ps.FROLS(kappa=1e-9)], ids=["SSR", "FROLS"]
)
def test_it_works_with_optimizers_that_never_return_the_whole_library(optimizer, driven):
    # In PySINDy 2.1 both stop one term short of all columns, and SSR gives all states as many
    # terms; the constant of a base library is the column to spare.
    t, x, x_dot, u = driven
    fitted = model(optimizer, base_library=ps.PolynomialLibrary(degree=1))
    fitted.fit(x, t, x_dot=x_dot, u=u, feature_names=["q", "v", "f"])
    assert {"q", "v", "f", "q^3"} <= set(fitted.get_feature_names())
    assert fitted.score(x, t, x_dot=x_dot, u=u) > 0.99


def test_everything_that_sindy_offers_works_on_the_result(free, capsys):
    t, x, x_dot, _ = free
    fitted = model().fit(x, t, x_dot=x_dot, feature_names=["q", "v"])
    fitted.print()
    assert "(q)' =  1.000 v" in capsys.readouterr().out
    assert fitted.equations()[0].strip() == "1.000 v"
    assert fitted.coefficients().shape == (2, len(fitted.get_feature_names()))
    assert fitted.complexity == 4
    np.testing.assert_allclose(fitted.predict(x), x_dot, atol=1e-8)
    simulated = fitted.simulate(x[0], t[:200])
    np.testing.assert_allclose(simulated, x[:200], atol=1e-6)


@pytest.mark.parametrize("way", ["pickle", "joblib"])
def test_a_fitted_model_is_stored_and_predicts_the_same(way, free, tmp_path):
    t, x, x_dot, _ = free
    fitted = model().fit(x, t, x_dot=x_dot)
    if way == "pickle":
        loaded = pickle.loads(pickle.dumps(fitted))
    else:
        joblib.dump(fitted, tmp_path / "model.joblib")
        loaded = joblib.load(tmp_path / "model.joblib")
    np.testing.assert_array_equal(loaded.predict(x), fitted.predict(x))
    assert loaded.feature_library.terms_ == fitted.feature_library.terms_


def test_cross_val_score_needs_nothing_from_the_user(free):
    t, x, _, _ = free
    scores = cross_val_score(model(), x, t, cv=TimeSeriesSplit(2))
    assert scores.min() > 0.99


def test_grid_search_needs_nothing_from_the_user(free):
    t, x, _, _ = free
    grid = [{"feature_library__population_size": [20]}, {"optimizer__lambda2": [1e-3]}]
    search = GridSearchCV(model(n_generations=5), grid, cv=TimeSeriesSplit(2)).fit(x, t)
    assert structure(search.best_estimator_) == [{"x1"}, {"x0", "x1", "x0^3"}]


def test_cross_validation_takes_x_dot_as_it_does_with_any_library(free):
    t, x, x_dot, _ = free
    scores = cross_val_score(model(), x, t, params={"x_dot": x_dot}, cv=TimeSeriesSplit(2))
    assert scores.min() > 0.99


def test_cross_validation_by_hand_takes_inputs(driven):
    # scikit-learn passes u to fit and not to score, with any library of PySINDy.
    t, x, x_dot, u = driven
    scores = []
    for train, test in TimeSeriesSplit(2).split(x):
        fold = clone(model()).fit(x[train], t[train], x_dot=x_dot[train], u=u[train])
        scores.append(fold.score(x[test], t[test], x_dot=x_dot[test], u=u[test]))
    assert min(scores) > 0.99


def test_two_threads_give_the_answers_of_one(free, driven):
    jobs = [(free[1], free[0], {}), (driven[1], driven[0], {"u": driven[3]})]
    alone = [
        model(random_state=i, n_generations=3).fit(x, t, **kw).equations(8)
        for i, (x, t, kw) in enumerate(jobs)
    ]
    together = [None] * len(jobs)

    def work(i):
        x, t, kw = jobs[i]
        together[i] = model(random_state=i, n_generations=3).fit(x, t, **kw).equations(8)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(len(jobs))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert together == alone


def test_one_fitted_model_serves_two_threads(driven):
    t, x, x_dot, u = driven
    fitted = model().fit(x, t, x_dot=x_dot, u=u)
    expected, results = fitted.predict(x, u), []
    threads = [
        threading.Thread(target=lambda: results.append(fitted.predict(x, u))) for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(result, expected) for result in results)


def test_data_is_released_after_fit_and_score(free):
    class Array(np.ndarray):
        """An ndarray that tells when it is gone."""

    t, x, x_dot, _ = free
    x, x_dot = x.copy().view(Array), x_dot.copy().view(Array)
    fitted = model().fit(x, t, x_dot=x_dot)
    fitted.score(x, t, x_dot=x_dot)
    fitted.score(x, t)
    fitted.predict(x)
    gone = [weakref.ref(x), weakref.ref(x_dot)]
    del x, x_dot
    fitted.differentiation_method = None  # PySINDy keeps its last smoothed x there
    gc.collect()
    assert [ref() for ref in gone] == [None, None]


def test_calls_that_broke_off_leave_no_trace(free):
    t, x, x_dot, _ = free
    fitted = model()
    with pytest.raises(ValueError, match="strictly increasing"):
        fitted.fit(x, t[::-1].copy(), x_dot=x_dot)
    fitted.fit(x, t, x_dot=x_dot, feature_names=["q", "v"])
    assert structure(fitted) == TRUE


def test_notes_of_a_broken_call_are_dropped_at_the_next_one():
    owner = library()
    first = owner.correct_shape(ps.AxesArray(np.zeros((4, 1)), {"ax_time": 0, "ax_coord": 1}))
    del first
    x = ps.AxesArray(np.ones((5, 1)), {"ax_time": 0, "ax_coord": 1})
    x_dot = ps.AxesArray(np.full((5, 1), 2.0), {"ax_time": 0, "ax_coord": 1})
    handover.note_shape(owner, x)
    handover.note_shape(owner, x_dot)
    (found,) = handover.target(owner, [np.ones((5, 1))])
    np.testing.assert_array_equal(found, x_dot)


@pytest.mark.parametrize(
    "combine",
    [
        lambda lib: ps.ConcatLibrary([lib, ps.PolynomialLibrary()]),
        lambda lib: ps.PolynomialLibrary() + lib,
        lambda lib: ps.TensoredLibrary([lib, ps.PolynomialLibrary()]),
        lambda lib: ps.GeneralizedLibrary([lib, ps.PolynomialLibrary()]),
    ],
    ids=["first in Concat", "last in Concat", "Tensored", "Generalized"],
)
@pytest.mark.parametrize("given", [True, False], ids=["x_dot given", "x_dot computed"])
def test_inside_another_library_the_error_names_base_library(combine, given, free):
    t, x, x_dot, _ = free
    combined = ps.SINDy(feature_library=combine(library()), optimizer=ElasticNet())
    with pytest.raises(ValueError, match="base_library"):
        combined.fit(x, t, x_dot=x_dot if given else None)


def test_the_base_library_stays_and_terms_come_on_top(free):
    t, x, x_dot, _ = free
    base = ps.PolynomialLibrary(degree=1)
    fitted = model(base_library=base).fit(x, t, x_dot=x_dot, feature_names=["q", "v"])
    assert fitted.get_feature_names() == ["1", "q", "v", "q^3"]
    assert structure(fitted) == TRUE
    assert not hasattr(base, "n_output_features_")


def test_a_base_of_functions_of_ones_own_stays_too(free):
    t, x, x_dot, _ = free
    base = ps.CustomLibrary([lambda a: a], [lambda a: a]) + ps.PolynomialLibrary(degree=1)
    fitted = model(base_library=base).fit(x, t, x_dot=x_dot, feature_names=["q", "v"])
    assert "q^3" in fitted.get_feature_names()


def test_x_dot_of_another_length_is_named(free):
    _, x, x_dot, _ = free
    with pytest.raises(ValueError, match="as many samples as x"):
        model().fit(x, STEP, x_dot=x_dot[:-5])


@pytest.mark.parametrize("given", [True, False], ids=["x_dot given", "x_dot computed"])
def test_an_input_one_sample_short_is_named(given, driven):
    t, x, x_dot, u = driven
    message = rf"u=\.\.\.\) must be as long as x; got {len(x) - 1} samples, x has {len(x)}\. Cut"
    with pytest.raises(ValueError, match=message):
        model().fit(x, t, x_dot=x_dot if given else None, u=np.ravel(u)[:-1])


@pytest.mark.parametrize("n", [1, 2])
def test_too_few_samples_to_differentiate_are_named(n, free):
    with pytest.raises(ValueError, match=rf"must have more samples than .*; got n_samples = {n}\."):
        model().fit(free[1][:n], free[0][:n])


@pytest.mark.parametrize("base", ["poly", 2, ps.PolynomialLibrary])
def test_a_base_library_of_another_kind_is_a_type_error(base, free):
    t, x, x_dot, _ = free
    with pytest.raises(TypeError, match=r"base_library=\.\.\.\) must be a PySINDy feature library"):
        model(base_library=base).fit(x, t, x_dot=x_dot)


def test_ends_without_a_derivative_are_left_out_as_pysindy_leaves_them_out(driven):
    t, x, _, u = driven
    centered = ps.FiniteDifference(order=2, drop_endpoints=True)
    for library in (EvolvingLibrary(OPERATORS, random_state=0), ps.PolynomialLibrary(degree=3)):
        for optimizer in (ElasticNet(), ps.STLSQ(threshold=0.05)):
            model = ps.SINDy(optimizer, library, differentiation_method=centered).fit(x, t, u=u)
            assert model.score(x, t, u=u) > 0.999


def test_ends_without_a_derivative_are_left_out_of_each_trajectory(driven):
    t, x, _, u = driven
    centered = ps.FiniteDifference(order=2, drop_endpoints=True)
    library = EvolvingLibrary(OPERATORS, random_state=0)
    theta = {}

    class Spy(ps.STLSQ):
        def fit(self, x, y, **options):
            theta.update(x=np.asarray(x), y=np.asarray(y))
            return super().fit(x, y, **options)

    model = ps.SINDy(Spy(threshold=0.05), library, differentiation_method=centered)
    model.fit([x, x[:301]], [t, t[:301]], u=[u, u[:301]])
    empty = np.flatnonzero(np.isnan(theta["y"]).all(axis=1))
    np.testing.assert_array_equal(empty, [0, len(x) - 1, len(x), len(x) + 300])
    assert not theta["x"][empty].any()


@pytest.mark.parametrize("optimizer", [ElasticNet(), ps.STLSQ(threshold=0.05)])
def test_the_derivative_of_one_state_is_enough(optimizer, driven):
    t, x, x_dot, u = driven
    model = ps.SINDy(optimizer, EvolvingLibrary(OPERATORS, random_state=0))
    model.fit(x, t, x_dot=x_dot[:, 1:], u=u)
    assert model.coefficients().shape[0] == 1
    assert model.score(x, t, x_dot=x_dot[:, 1:], u=u) > 0.9999


@pytest.mark.parametrize("n_trajectories", [1, 2])
@pytest.mark.parametrize("with_input", [False, True])
def test_a_discrete_model_takes_the_next_samples_by_itself(n_trajectories, with_input):
    rng = np.random.default_rng(0)
    xs, us = [], []
    for _ in range(n_trajectories):
        u = 0.1 * rng.uniform(size=(150, 1))
        x = np.full((150, 1), 0.3)
        for i in range(149):
            x[i + 1] = 3.2 * x[i] * (1.0 - x[i]) + with_input * u[i]
        xs.append(x)
        us.append(u)
    model = ps.DiscreteSINDy(ElasticNet(), EvolvingLibrary(("add", "mul"), random_state=0))
    given = {"u": us if n_trajectories > 1 else us[0]} if with_input else {}
    model.fit(xs if n_trajectories > 1 else xs[0], 1, **given)
    found = dict(zip(model.get_feature_names(), model.coefficients()[0], strict=True))
    assert found["x0"] == pytest.approx(3.2)
    assert found["x0^2"] == pytest.approx(-3.2)
    assert found.get("u0", 0.0) == pytest.approx(float(with_input), abs=1e-9)


@pytest.mark.filterwarnings("ignore:2 axes labeled")  # PySINDy, of the grid of a weak library
def test_a_weak_library_is_refused_as_base(free):
    t, x, _, _ = free
    weak = ps.WeakPDELibrary(function_library=ps.PolynomialLibrary(), spatiotemporal_grid=t)
    grown = EvolvingLibrary(OPERATORS, weak, random_state=0)
    with pytest.raises(ValueError, match="must be a library with a row for each sample"):
        ps.SINDy(ElasticNet(), grown).fit(x, t)
