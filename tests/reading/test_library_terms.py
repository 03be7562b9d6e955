"""Fitted PySINDy models, read from what their libraries do."""

import pickle
from types import SimpleNamespace

import numpy as np
import pysindy as ps
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pysindy import AxesArray
from pysindy.feature_library.base import BaseFeatureLibrary, x_sequence_or_item
from sklearn.base import BaseEstimator
from sklearn.exceptions import NotFittedError
from sklearn.linear_model import ElasticNet

from pysindy_evolve import terms
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.reading.library_terms import columns_of, from_model
from pysindy_evolve.term_library import TermLibrary


def step(q):
    return np.where(q > 0.3, 1.0, 0.0)


def mixed(q, v):
    return np.maximum(q, v)


class Grown(BaseFeatureLibrary):
    """A library that holds its terms, such as an evolving one."""

    def __init__(self, base_library=None):
        self.base_library = base_library

    @x_sequence_or_item
    def fit(self, x, y=None):
        self.n_features_in_ = x[0].shape[1]
        q, v = terms.variable(0), terms.variable(1)
        grown = [terms.mul(terms.mul(q, q), terms.call(BUILTIN["sgn"], v)), terms.div(v, q)]
        self.terms_ = tuple(column.parts[0][1] for column in grown)
        n_base = 0
        if self.base_library is not None:
            self.base_library_ = self.base_library.fit(x)
            n_base = self.base_library_.n_output_features_
        self.n_output_features_ = n_base + len(self.terms_)
        return self

    @x_sequence_or_item
    def transform(self, x):
        return [self._transformed(part) for part in x]

    def _transformed(self, x):
        columns = [term.evaluate(np.asarray(x)) for term in self.terms_]
        base = [] if self.base_library is None else [np.asarray(self.base_library_.transform(x))]
        return AxesArray(np.column_stack([*base, *columns]), {"ax_time": 0, "ax_coord": 1})

    def get_feature_names(self, input_features=None):
        return [f"c{i}" for i in range(self.n_output_features_)]


LIBRARIES = {
    "polynomial": lambda: ps.PolynomialLibrary(degree=3),
    "polynomial_no_bias": lambda: ps.PolynomialLibrary(degree=4, include_bias=False),
    "polynomial_no_interaction": lambda: ps.PolynomialLibrary(degree=3, include_interaction=False),
    "polynomial_interaction_only": lambda: ps.PolynomialLibrary(degree=3, interaction_only=True),
    "polynomial_degree_zero": lambda: ps.PolynomialLibrary(degree=0),
    "identity": ps.IdentityLibrary,
    "fourier": lambda: ps.FourierLibrary(n_frequencies=3),
    "fourier_cos": lambda: ps.FourierLibrary(n_frequencies=2, include_sin=False),
    "fourier_sin": lambda: ps.FourierLibrary(n_frequencies=2, include_cos=False),
    "custom_traced": lambda: ps.CustomLibrary(
        [
            lambda q: np.sign(q),
            lambda q: q * np.abs(q),
            lambda q: 2 * q + 1,
            lambda q, v: q**2 * np.sign(v) / (1 + v**2),
            lambda q: np.sqrt(np.abs(q)),
            lambda q: np.arctan(q / 0.3),
            lambda q: -np.exp(-((q / 0.3) ** 2)),
        ],
        include_bias=True,
    ),
    "custom_opaque": lambda: ps.CustomLibrary(
        [step, mixed, lambda q: np.clip(q, -1, 1), lambda q: np.arctan(q)],
        interaction_only=False,
    ),
    "custom_two_names_alike": lambda: ps.CustomLibrary(
        [step, lambda q: np.floor(q)], function_names=[lambda q: f"h({q})"] * 2
    ),
    "concat": lambda: ps.PolynomialLibrary() + ps.FourierLibrary() + ps.CustomLibrary([step]),
    "tensored": lambda: (
        ps.PolynomialLibrary() * ps.FourierLibrary() * ps.CustomLibrary([lambda q: np.sign(q)])
    ),
    "tensored_inputs": lambda: ps.TensoredLibrary(
        [ps.PolynomialLibrary(), ps.FourierLibrary()], inputs_per_library=[[2, 0, 2], [1]]
    ),
    "generalized": lambda: ps.GeneralizedLibrary(
        [ps.PolynomialLibrary(), ps.FourierLibrary(), ps.CustomLibrary([step])]
    ),
    "generalized_all": lambda: ps.GeneralizedLibrary(
        [ps.PolynomialLibrary(), ps.FourierLibrary(), ps.IdentityLibrary()],
        tensor_array=[[1, 1, 0], [1, 0, 1], [1, 1, 1]],
        inputs_per_library=[[0, 1], [2], [1, 1, 2]],
        exclude_libraries=[1],
    ),
    "parameterized": lambda: ps.ParameterizedLibrary(
        feature_library=ps.PolynomialLibrary(degree=3), num_features=2, num_parameters=1
    ),
    "fixed_terms": lambda: TermLibrary(
        [terms.mul(terms.variable(0), terms.call(BUILTIN["abs"], terms.variable(1))).parts[0][1]]
    ),
    "grown": Grown,
    "grown_on_a_base": lambda: Grown(ps.PolynomialLibrary(degree=2)),
    "grown_in_a_tensor": lambda: ps.GeneralizedLibrary(
        [Grown(), ps.IdentityLibrary()],
        tensor_array=[[1, 1]],
        inputs_per_library=[[2, 1], [0]],
    ),
}


@pytest.fixture
def record():
    rng = np.random.default_rng(3)
    return rng.normal(size=(200, 3)), rng.normal(size=(200, 3))


@pytest.fixture(params=LIBRARIES)
def library(request):
    return LIBRARIES[request.param]()


def states(n_columns):
    """Rows of states and inputs, with zeros among them."""
    value = st.one_of(st.just(0.0), st.floats(-5, 5, allow_subnormal=False))
    return arrays(float, (4, n_columns), elements=value)


def assert_equal_where_finite(found, expected):
    expected = np.asarray(expected)
    finite = np.isfinite(expected)
    np.testing.assert_allclose(found[finite], expected[finite], rtol=1e-9, atol=1e-9)


def test_theta_is_the_transform_of_the_library(library, record):
    library.fit(record[0])
    columns = columns_of(library)

    @settings(max_examples=30, deadline=None, derandomize=True)
    @given(states(3))
    def check(x):
        with np.errstate(all="ignore"):
            found = np.column_stack([column.evaluate(x) for column in columns])
            assert_equal_where_finite(found, library.transform(x))

    check()


@pytest.mark.filterwarnings("ignore:Sparsity parameter is too big")
def test_evaluate_is_predict_without_inputs(library, record):
    x, x_dot = record
    model = ps.SINDy(feature_library=library, optimizer=ps.STLSQ(threshold=0.0, alpha=1e-6))
    model.fit(x, t=0.1, x_dot=x_dot)
    equations = from_model(model)
    assert equations.states == ("x0", "x1", "x2")
    assert equations.inputs == ()
    np.testing.assert_allclose(equations.evaluate(x), model.predict(x), rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(
        equations.theta(x), np.asarray(library.transform(x)), rtol=1e-9, atol=1e-9
    )


def test_inputs_come_after_the_states(library, record):
    x, x_dot = record
    model = ps.SINDy(feature_library=library, optimizer=ps.STLSQ(threshold=0.0, alpha=1e-6))
    model.fit(x[:, :2], t=0.1, x_dot=x_dot[:, :2], u=x[:, 2:], feature_names=["q", "v", "F"])
    equations = from_model(model)
    assert equations.states == ("q", "v")
    assert equations.inputs == ("F",)
    np.testing.assert_allclose(
        equations.evaluate(x[:, :2], x[:, 2:]),
        model.predict(x[:, :2], u=x[:, 2:]),
        rtol=1e-8,
        atol=1e-8,
    )


def test_default_names_of_inputs_are_those_of_pysindy(record):
    model = ps.SINDy().fit(record[0][:, :1], t=0.1, u=record[0][:, 1:])
    assert from_model(model).names == ("x0", "u0", "u1", "t")


def test_functions_of_arrays_become_terms(record):
    library = LIBRARIES["custom_traced"]().fit(record[0][:, :2])
    names = [column.name(["q", "v"]) for column in columns_of(library)]
    assert names[:7] == ["1", "sgn(q)", "sgn(v)", "q abs(q)", "v abs(v)", "1 + 2 q", "1 + 2 v"]
    assert names[7] == "q^2 sgn(v)/(1 + v^2)"


def test_functions_that_cannot_be_followed_keep_their_names_apart(record):
    first = ps.CustomLibrary([step], function_names=[lambda q: f"h({q})"])
    second = ps.CustomLibrary([lambda q: np.floor(q)], function_names=[lambda q: f"h({q})"])
    third = ps.CustomLibrary([step], function_names=[lambda q: f"sgn({q})"])
    library = ps.ConcatLibrary([first, second, third]).fit(record[0][:, :1])
    names = [column.name(["q"]) for column in columns_of(library)]
    assert names == ["h(q)", "h_1(q)", "sgn_1(q)"]


@pytest.mark.parametrize(
    "function",
    [
        lambda q: q if np.all(q > 0) else -q,
        lambda q: np.array([abs(value) for value in q]),
        lambda q: q * 0 + np.asarray(q).size,
        lambda q: np.sinc(q),
        lambda q: q / q,
        lambda q: q**99,
        lambda q: np.fromiter((value**2 for value in q), float),
    ],
)
def test_functions_that_arrays_alone_can_answer_stay_as_they_are(function, record):
    library = ps.CustomLibrary([function]).fit(record[0])
    (column, *_) = columns_of(library)
    assert column.name(["q", "v", "w"]) == "f0(q)"


def test_intercept_of_an_optimizer_is_a_constant_term(record):
    x, x_dot = record
    model = ps.SINDy(feature_library=ps.IdentityLibrary(), optimizer=ElasticNet(alpha=1e-3))
    model.fit(x, t=0.1, x_dot=x_dot + 3.0)
    equations = from_model(model)
    assert equations.terms[-1] == terms.ONE
    np.testing.assert_allclose(equations.evaluate(x), model.predict(x), rtol=1e-9)


def test_one_target_alone_has_one_row(record):
    x, _ = record
    model = ps.SINDy(feature_library=ps.IdentityLibrary())
    model.fit(x[:, :1], t=0.1, x_dot=3 * x[:, :1])
    assert from_model(model).coef.shape == (1, 1)


def test_equations_and_what_holds_a_model_are_read_too(record):
    model = ps.SINDy().fit(record[0], t=0.1)
    equations = from_model(model)
    assert from_model(equations) is equations
    assert from_model(SimpleNamespace(equations=equations)) is equations
    assert from_model(SimpleNamespace(model=model)).states == equations.states


def test_equations_of_ordinary_libraries_pickle(record):
    library = LIBRARIES["custom_traced"]()  # its lambdas do not pickle, its terms do
    equations = from_model(ps.SINDy(feature_library=library).fit(record[0] ** 2, t=0.1))
    again = pickle.loads(pickle.dumps(equations))
    assert again.terms == equations.terms


@pytest.mark.parametrize("model", [None, 3, "model", BaseEstimator()])
def test_what_is_no_model_is_a_type_error(model):
    with pytest.raises(TypeError, match=r"^to_sympy\(model=...\) must be a fitted pysindy.SINDy"):
        from_model(model, "to_sympy(model=...)")


def test_a_model_of_the_next_sample_is_no_model_of_rates():
    model = ps.DiscreteSINDy(feature_library=ps.PolynomialLibrary(2))
    with pytest.raises(TypeError, match=r"must be a model of rates; got a DiscreteSINDy"):
        from_model(model)


def test_model_that_is_not_fitted_is_an_error():
    with pytest.raises(NotFittedError, match=r"must be fitted; got a SINDy that is not"):
        from_model(ps.SINDy())


def test_pde_library_is_an_error():
    x = np.random.default_rng(0).normal(size=(8, 30, 1))
    library = ps.PDELibrary(
        function_library=ps.PolynomialLibrary(degree=1, include_bias=False),
        derivative_order=2,
        spatial_grid=np.linspace(0, 1, 8),
    )
    model = ps.SINDy(feature_library=library).fit(x, t=0.1)
    with pytest.raises(TypeError, match="must have a feature library of ordinary terms; got PDELi"):
        from_model(model)


class Doubled(ps.PolynomialLibrary):
    def transform(self, x_full):
        parts = super().transform(x_full)
        return [2 * part for part in parts] if isinstance(parts, list) else 2 * parts


def test_library_that_does_something_else_than_its_class_is_an_error(record):
    model = ps.SINDy(feature_library=Doubled()).fit(record[0], t=0.1)
    with pytest.raises(TypeError, match="computes what its class does; got a Doubled"):
        from_model(model)


@pytest.mark.parametrize("names", [["q", "v"], ["q", "v", "F", "G"]])
@pytest.mark.parametrize("library", [ps.PolynomialLibrary(), Grown()])
def test_names_that_are_not_one_for_each_column_are_an_error(library, names, record):
    x, x_dot = record
    model = ps.SINDy(feature_library=library, optimizer=ps.STLSQ(threshold=0.0, alpha=1e-6))
    model.fit(x[:, :2], t=0.1, x_dot=x_dot[:, :2], u=x[:, 2:], feature_names=names)
    message = rf"must name each state and each input; got {len(names)} for 3 columns\. Fit"
    with pytest.raises(ValueError, match=message):
        from_model(model)


def test_our_libraries_print_no_other_names_than_those_of_their_columns():
    library = TermLibrary([terms.variable(1).parts[0][1]]).fit(np.ones((2, 2)))
    with pytest.raises(ValueError, match="must name each state and each input; got 1 for 2 col"):
        library.get_feature_names(["q"])
