"""ElasticNet by itself and in ps.SINDy with a fixed library."""

import pickle

import numpy as np
import pysindy as ps
import pytest

from pysindy_evolve.optimizer import ElasticNet


@pytest.fixture
def problem():
    rng = np.random.default_rng(0)
    theta = rng.normal(size=(400, 20)) * 10.0 ** rng.integers(-7, 7, 20)
    coef = np.zeros((2, 20))
    coef[0, [2, 7]] = [1.0, -3.0] / np.std(theta[:, [2, 7]], axis=0)
    coef[1, [7, 11, 15]] = [1.0, 2.0, 0.2] / np.std(theta[:, [7, 11, 15]], axis=0)
    return theta, coef, theta @ coef.T + 0.05 * rng.normal(size=(400, 2))


def test_columns_of_all_sizes_are_found(problem):
    theta, coef, y = problem
    fitted = ElasticNet().fit(theta, y)
    np.testing.assert_array_equal(fitted.ind_, coef != 0.0)
    np.testing.assert_allclose(fitted.coef_, coef, rtol=0.1)
    assert fitted.complexity == 5
    assert fitted.intercept_ == 0.0


def test_the_unit_of_a_column_does_not_matter(problem):
    theta, _, y = problem
    factor = 10.0 ** np.linspace(-3, 3, 20)
    one, other = ElasticNet().fit(theta, y), ElasticNet().fit(theta * factor, y)
    np.testing.assert_allclose(other.coef_ * factor, one.coef_, rtol=1e-6)


def test_given_weights_are_used(problem):
    theta, _, y = problem
    few = ElasticNet(lambda1=0.5, lambda2=0.0).fit(theta, y)
    many = ElasticNet(lambda1=0.001, lambda2=0.0).fit(theta, y)
    assert few.complexity < many.complexity


def test_what_varies_and_has_no_term_left_is_warned_of():
    rng = np.random.default_rng(4)
    theta = rng.normal(size=(500, 3))
    targets = np.column_stack([theta[:, 0], rng.normal(size=500), np.zeros(500)])
    with pytest.warns(UserWarning, match="kept no term for target 1: .* set lambda1") as said:
        ElasticNet().fit(theta, targets)
    assert len(said) == 1


@pytest.mark.filterwarnings("ignore:ElasticNet kept no term")
def test_noise_alone_gives_no_term():
    rng = np.random.default_rng(4)
    counts = [
        ElasticNet().fit(rng.normal(size=(500, 30)), rng.normal(size=500)).complexity
        for _ in range(20)
    ]
    assert sum(counts) <= 1


def test_a_target_of_zeros_gives_zero_coefficients():
    theta = np.random.default_rng(0).normal(size=(50, 3))
    fitted = ElasticNet().fit(theta, np.zeros((50, 1)))
    np.testing.assert_array_equal(fitted.coef_, np.zeros((1, 3)))


def test_it_is_a_good_optimizer_of_a_fixed_library():
    def lorenz(x):
        return np.column_stack(
            [10 * (x[:, 1] - x[:, 0]), x[:, 0] * (28 - x[:, 2]) - x[:, 1],
             x[:, 0] * x[:, 1] - 8 / 3 * x[:, 2]]
        )  # fmt: skip

    rng = np.random.default_rng(0)
    x = rng.normal(size=(800, 3)) * [8, 9, 8] + [0, 0, 24]
    x_dot = lorenz(x)
    noisy = x_dot + 0.02 * x_dot.std(axis=0) * rng.normal(size=x.shape)
    model = ps.SINDy(feature_library=ps.PolynomialLibrary(degree=4), optimizer=ElasticNet())
    model.fit(x, 0.01, x_dot=noisy, feature_names=["x", "y", "z"])
    names = np.array(model.get_feature_names())
    found = [set(names[row != 0.0]) for row in model.coefficients()]
    assert found == [{"x", "y"}, {"x", "y", "x z"}, {"z", "x y"}]


def test_it_is_pickled(problem):
    theta, _, y = problem
    fitted = ElasticNet().fit(theta, y)
    loaded = pickle.loads(pickle.dumps(fitted))
    np.testing.assert_array_equal(loaded.predict(theta), fitted.predict(theta))


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"lambda1": -1.0}, r"ElasticNet\(lambda1=...\) must be at least 0; got -1.0"),
        ({"lambda2": float("nan")}, r"ElasticNet\(lambda2=...\) must be at least 0; got nan"),
        ({"max_terms": 0}, r"ElasticNet\(max_terms=...\) must be at least 1; got 0"),
        ({"lambda1": "a"}, r"ElasticNet\(lambda1=...\) must be a number; got 'a'"),
        ({"max_iter": 1.5}, r"ElasticNet\(max_iter=...\) must be an integer; got 1.5"),
    ],
)
def test_bad_parameters_are_named_and_the_object_stays_usable(parameters, message, problem):
    theta, _, y = problem
    optimizer = ElasticNet(**parameters)
    with pytest.raises((TypeError, ValueError), match=message):
        optimizer.fit(theta, y)
    optimizer.set_params(**{name: getattr(ElasticNet(), name) for name in parameters})
    assert optimizer.fit(theta, y).complexity == 5


def test_fewer_samples_than_terms_are_named():
    theta = np.random.default_rng(0).normal(size=(10, 20))
    with pytest.raises(ValueError, match="at least as many samples as terms"):
        ElasticNet().fit(theta, theta[:, 0])


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda x, y: (x[:, 0], y), "Expected 2D array, got 1D array instead"),
        (lambda x, y: (x, y[:-1]), "inconsistent numbers of samples"),
        (lambda x, y: (np.where(x == x.max(), np.nan, x), y), "Input X contains NaN"),
        (lambda x, y: (x.astype(str).astype(object) + "m", y), "could not convert string"),
    ],
)
def test_errors_of_the_data_are_short_and_of_one_form(problem, change, told):
    theta, _, y = problem
    form = rf"ElasticNet\.fit\(X=..., y=...\) must be .*; got .*{told}.*\. Give one row per sample"
    with pytest.raises(ValueError, match=form) as said:
        ElasticNet().fit(*change(theta, y))
    assert len(str(said.value)) < 400


def test_other_columns_than_in_fit_are_refused_in_the_same_form(problem):
    theta, _, y = problem
    fitted = ElasticNet().fit(theta, y)
    with pytest.raises(ValueError, match=r"predict\(X=...\) must be .* has 3 features"):
        fitted.predict(theta[:, :3])


def test_rows_without_a_target_are_left_out(problem):
    theta, _, y = problem
    holes = y.copy()
    holes[[0, 17, -1]] = np.nan
    inner = np.isfinite(holes[:, 0])
    one, other = ElasticNet().fit(theta, holes), ElasticNet().fit(theta[inner], y[inner])
    np.testing.assert_array_equal(one.coef_, other.coef_)
    holes[5, 0] = np.nan
    with pytest.raises(ValueError, match="contains NaN"):
        ElasticNet().fit(theta, holes)


def test_a_weight_that_leaves_no_term_is_named(problem):
    theta, _, y = problem
    with pytest.warns(UserWarning, match="target 0, 1: lambda1=9 is too large. Lower it"):
        ElasticNet(lambda1=9).fit(theta, y)
