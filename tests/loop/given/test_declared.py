"""DeclaredModel: what is read from text, sympy and SINDy models, and what is refused."""

import numpy as np
import pysindy as ps
import pytest
import sympy
from sklearn.base import clone

import pysindy_evolve as pse
from pysindy_evolve import DeclaredModel, Operator, Record
from pysindy_evolve.loop.given.declared import design_of

NAMES = ("q", "v", "F", "t")
POINT = np.array([[0.7, -1.3, 2.0, 5.0]])


def spring(**options):
    return DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"], **options)


def record(n=400, driven=True):
    """A linear spring with exact derivatives."""
    t = np.arange(n) * 0.02
    rng = np.random.default_rng(0)
    x = np.column_stack([np.sin(1.3 * t), 1.7 * np.cos(0.7 * t)])
    force = rng.standard_normal(n)
    x_dot = np.column_stack([x[:, 1], -4.0 * x[:, 0] - 0.5 * x[:, 1] + 2.0 * force * driven])
    return Record(t=t, x=x, x_dot=x_dot, u=force if driven else None)


def test_names_that_are_no_variables_are_parameters_in_the_order_of_the_text():
    declared = spring()
    assert declared.states == ("q", "v")
    assert declared.inputs == ("F",)
    assert declared.parameters == ("k", "c", "b")


def test_known_constants_are_no_parameters_and_enter_with_their_value():
    declared = spring(known={"k": 40.0, "b": 0.5})
    assert declared.parameters == ("c",)
    assert declared.design().known(POINT) == pytest.approx(np.array([[-1.3, -28.0 + 1.0]]))


def test_parameter_of_two_equations_is_one_column_with_two_parts():
    design = DeclaredModel({"a": "-r*a*b", "b": "r*a*b - s*b"}).design()
    assert [column.name for column in design.columns] == ["r", "s"]
    shared = design.columns[0].evaluate(np.array([[2.0, 3.0, 0.0]]))
    assert shared == pytest.approx(np.array([[-6.0, 6.0]]))


def test_time_may_stand_in_the_text():
    design = DeclaredModel({"v": "a*t"}).design()
    assert design.columns[0].evaluate(np.array([[1.0, 7.0]])) == pytest.approx(np.array([[7.0]]))


@pytest.mark.parametrize("value", [-9.81, np.float64(-9.81), "-9.81", sympy.Float("-9.81")])
def test_number_is_a_right_hand_side(value):
    declared = DeclaredModel({"v": value})
    assert declared.parameters == ()
    assert declared.design().known(np.zeros((1, 2))) == pytest.approx(np.array([[-9.81]]))


def test_sympy_expression_reads_like_the_same_text():
    q, v, k, f = sympy.symbols("q v k F")
    by_sympy = DeclaredModel({"q": v, "v": -k * q - 3 * sympy.sign(v) + f}, inputs=["F"])
    by_text = DeclaredModel({"q": "v", "v": "-k*q - 3*sgn(v) + F"}, inputs="F")
    assert by_sympy.parameters == by_text.parameters == ("k",)
    assert by_sympy.design().known(POINT) == pytest.approx(by_text.design().known(POINT))


def test_operator_of_the_user_may_be_called():
    relu = Operator("relu", lambda a: np.maximum(a, 0.0), 1)
    design = DeclaredModel({"v": "-c*relu(v) + relu(-v)"}, operators=[relu]).design()
    below, above = np.array([[-2.0, 0.0]]), np.array([[2.0, 0.0]])
    assert design.known(below) == pytest.approx(np.array([[2.0]]))
    assert design.columns[0].evaluate(above) == pytest.approx(np.array([[-2.0]]))


def test_repr_shows_each_equation_with_its_parameters():
    assert repr(spring(known={"k": 40.0})) == "DeclaredModel(q' = v, v' = -c*v + b*F - 40 q)"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("foo(q)", r"must call known functions; got foo\(\.\.\.\) at character 1"),
        ("sin(k*q)", "must be linear in its free parameters; got 'k' inside a function"),
        ("k*c*q", "must be linear in its free parameters; got the product of 'k' and 'c'"),
        ("q/k", "must be linear in its free parameters; got a division by 'k'"),
        ("k^2*q", "must be linear in its free parameters; got 'k' inside a function or power"),
        ("q.__class__", r"must be an expression; got '\.' at character 2"),
        ("__import__('os').system('true')", 'must be an expression; got "\'" at character 12'),
        ("[q for q in v]", r"must be an expression; got '\[' at character 1"),
        ("q if v else 1", "must have an operator between two factors"),
        ("q**v", "must have constant exponents"),
        ("", "must not be empty"),
        ("1/0*q", "must have finite values"),
        ("sin", "must call its functions"),
        ("sgn(q, v)", r"must give sgn 1 argument\(s\); got 2"),
        (
            "-1,5*q",
            r"must be an expression; got a comma at character 3 of '-1,5\*q'\. Write 1\.5\.",
        ),
        ("-k*q,", "must be an expression; got a comma at character 5.* of a function only"),
        ("-k*q\u2212c*v", r".*got '\u2212' at .*\. Use - \(the minus of the keyboard\)\."),
        ("-k\u00b7q", r".*got '\u00b7' at .*\. Write a product with \*\."),
        ("k(q + v)", r".*Write k\*\(\.\.\.\) for a product\. Functions: "),
        (
            "step(q, 0)",
            r".*got step\(\.\.\.\) at character 1 of 'step\(q, 0\)'\. Functions: square, ",
        ),
        ("-c*sng(v)", r".*got sng\(\.\.\.\) at .*Did you mean sin or sgn\? Functions: "),
    ],
)
def test_text_that_is_no_model_is_refused_with_its_equation_and_place(text, message):
    with pytest.raises(ValueError, match=rf"DeclaredModel\(equations\['v'\]=\.\.\.\) {message}"):
        DeclaredModel({"q": "v", "v": text})


@pytest.mark.parametrize("text", ["b*curent", "curent*b", "sin(curent)", "b/curent", "2^curent"])
def test_misspelled_input_is_named_where_it_makes_the_model_nonlinear(text):
    message = (
        r"'curent' is neither a state \(theta, w\) nor an input \(current\), so it was read as a "
        r"free parameter\. Did you mean 'current'\? If it is a state, give its "
        r"equation; if it is an input, name it in `inputs`; if it is a constant, give it in "
        r"`known`, or name"
    )
    with pytest.raises(ValueError, match=message):
        DeclaredModel({"theta": "w", "w": f"-c*w + {text}"}, inputs=["current"])


@pytest.mark.parametrize(
    ("equations", "options", "wrong", "meant"),
    [
        ({"q": "v", "v": "b*U - c*v"}, {"inputs": ["u"]}, "U", "u"),
        ({"q": "v", "v": "b*F - c*V"}, {"inputs": ["F"]}, "V", "v"),
        ({"q": "v", "v": "b*F - c*w"}, {"inputs": ["F"]}, "w", "v"),
        ({"q": "w", "w": "b*F - c*q_dot"}, {"inputs": ["F"]}, "q_dot", "w"),
        ({"q": "v", "v": "b*cur - c*v"}, {"inputs": ["cor"]}, "cur", "cor"),
        ({"q": "v", "v": "(g/M)*q + m*q"}, {"known": {"m": 2.0}}, "M", "m"),
        ({"q": "v", "v": "b*mas*q + mass*q"}, {"known": {"mass": 2.0}}, "mas", "mass"),
    ],
)
def test_name_that_another_is_written_as_is_asked_for(equations, options, wrong, meant):
    message = rf"'{wrong}' is neither .* as a free parameter\. Did you mean '{meant}'\?"
    with pytest.raises(ValueError, match=message):
        DeclaredModel(equations, **options)


@pytest.mark.parametrize("text", ["sin(w*t)", "k*c*q", "b*q/e", "k12*c*q + k13"])
def test_name_like_no_other_is_not_guessed(text):
    known = {"k13": 1.0} if "k13" in text else {}
    with pytest.raises(ValueError, match="linear in its free parameters") as caught:
        DeclaredModel({"q": "v", "v": text}, inputs=["u"], known=known)
    assert "Did you mean" not in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"inputs": ["q"]}, "must use each name once, and t for time only; got 'q' again"),
        ({"inputs": ["F", "F"]}, "must use each name once, and t for time only; got 'F' again"),
        ({"known": {"v": 1.0}}, "must use each name once, and t for time only; got 'v' again"),
        ({"inputs": ["t"]}, "must use each name once, and t for time only; got 't' again"),
        ({"inputs": ["motor force"]}, "by identifiers; got 'motor force'"),
        ({"known": {"k": np.nan}}, r"known\['k'\]=\.\.\.\) must be a finite number; got nan"),
        ({"known": {"k": "two"}}, r"known\['k'\]=\.\.\.\) must be a finite number; got 'two'"),
        ({"known": {"kk": 2.0}}, "must hold constants of the equations; got 'kk', which stands in"),
    ],
)
def test_name_or_constant_that_cannot_be_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        DeclaredModel({"q": "v", "v": "-k*q"}, **arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"inputs": 5}, r"inputs=\.\.\.\) must be a sequence of names; got int"),
        ({"inputs": [1]}, "must name states, inputs and constants by text; got int"),
        ({"known": ["k"]}, r"known=\.\.\.\) must be a mapping of name to number; got list"),
        ({"operators": ["sin"]}, r"operators=\.\.\.\) must be a sequence of Operator objects"),
        ({"operators": 5}, r"operators=\.\.\.\) must be a sequence of Operator objects; got 5"),
    ],
)
def test_argument_of_the_wrong_kind_is_a_type_error(arguments, message):
    with pytest.raises(TypeError, match=message):
        DeclaredModel({"q": "v", "v": "-k*q"}, **arguments)


@pytest.mark.parametrize("equations", ["-k*q", None, [("q", "v")], 5])
def test_equations_that_are_no_mapping_are_a_type_error(equations):
    with pytest.raises(TypeError, match="must be a mapping of state to right-hand side; got"):
        DeclaredModel(equations)


def test_model_without_states_is_refused():
    with pytest.raises(ValueError, match="must hold at least one state; got none"):
        DeclaredModel({})


@pytest.mark.parametrize("side", [None, ["v"], 1j, True, {"v": 1}])
def test_right_hand_side_of_the_wrong_kind_is_a_type_error(side):
    with pytest.raises(TypeError, match="must be text, a sympy expression or a number; got"):
        DeclaredModel({"q": side})


def polynomial_model():
    library = ps.PolynomialLibrary(degree=2, include_bias=False)
    return ps.SINDy(feature_library=library, optimizer=ps.STLSQ(threshold=0.1))


def test_terms_of_a_fitted_sindy_model_are_the_columns_and_kinematics_stay_known():
    data, model = record(), polynomial_model()
    model.fit(data.x, t=data.t, x_dot=data.x_dot, u=data.u, feature_names=["q", "v", "F"])
    design = design_of(model, [data])
    assert design.kinematic(0)
    assert [column.name for column in design.columns] == ["v: q", "v: v", "v: F"]


def test_sindy_model_that_is_not_fitted_is_fitted_on_a_copy():
    data, model = record(), polynomial_model()
    before = clone(model).get_params().keys()
    design = design_of(model, [data])
    assert [column.name for column in design.columns] == ["x1: x0", "x1: x1", "x1: u0"]
    assert design.inputs == ("u0",)
    assert not hasattr(model, "model")
    assert not hasattr(model.optimizer, "coef_")
    assert not hasattr(model.feature_library, "n_features_in_")
    assert model.get_params().keys() == before


def test_sindy_model_takes_the_names_that_the_record_has():
    data = record()
    named = Record(t=data.t, x=data.x, x_dot=data.x_dot, u=data.u, states=("q", "v"))
    design = design_of(polynomial_model(), [named])
    assert design.states == ("q", "v")
    assert design.inputs == ("u0",)


def test_custom_library_that_scikit_learn_cannot_clone_is_fitted_all_the_same():
    library = ps.CustomLibrary(library_functions=[lambda x: x, lambda x: x**3])
    model = ps.SINDy(feature_library=library, optimizer=ps.STLSQ(threshold=0.1))
    design = design_of(model, [record()])
    assert [column.name for column in design.columns] == ["x1: x0", "x1: x1", "x1: u0"]


@pytest.mark.parametrize("nested", [False, True])
@pytest.mark.parametrize(
    "library",
    [
        ps.PDELibrary(derivative_order=1, spatial_grid=np.linspace(0.0, 1.0, 8)),
        ps.WeakPDELibrary(
            function_library=ps.PolynomialLibrary(degree=2),
            spatiotemporal_grid=np.linspace(0.0, 1.0, 50),
        ),
    ],
    ids=lambda library: type(library).__name__,
)
def test_library_without_ordinary_terms_is_refused_before_it_is_fitted(library, nested):
    whole = ps.ConcatLibrary([ps.PolynomialLibrary(), library]) if nested else library
    message = (
        rf"declared=\.\.\.\) must have a feature library .*; got {type(library).__name__}\. Use"
    )
    with pytest.raises(TypeError, match=message):
        design_of(ps.SINDy(feature_library=whole), [record()])


def test_model_of_another_kind_is_a_type_error():
    with pytest.raises(TypeError, match=r"close_loop\(declared=\.\.\.\) must be a DeclaredModel"):
        design_of("-k*q", [record()])


def test_traces_of_other_terms_in_a_fitted_model_leave_a_velocity_what_it_is():
    t = np.arange(0.0, 40.0, 0.01)
    record = pse.prepare(t, np.exp(-0.1 * t) * np.sin(2.0 * t))
    model = ps.SINDy(
        feature_library=ps.PolynomialLibrary(1, include_bias=False),
        optimizer=ps.STLSQ(threshold=0.0),
    )
    model.fit(record.x, record.t, x_dot=record.x_dot, feature_names=["q", "v"])
    assert model.coefficients()[0].all()  # about 1e-11 q + v
    design = design_of(model, [record])
    assert design.kinematic(0)
    assert [column.name for column in design.columns] == ["v: q", "v: v"]
