"""Code in other languages, run where a compiler is at hand, and the picture of the tree."""

import ctypes
import shutil
import subprocess
import sys

import numpy as np
import pytest
import sympy
from scipy.special import erf

from pysindy_evolve import export
from pysindy_evolve.equations import Equations
from pysindy_evolve.export.symbolic import system_of
from pysindy_evolve.export.tree import expression_tree
from pysindy_evolve.operators import Operator
from pysindy_evolve.reading.text import parse

LANGUAGES = ("python", "c", "matlab", "julia", "modelica")
SIDES = [
    "v",
    "-1.1*v - 691.92*q - 2.37e6*q^3 - 2.93*sgn(v) - 7.63e3*q^2*sgn(v) - 1.02*F + 1.5e-5",
    "0.30000000000000004*abs(q)*v - q/(2 + v^2) + exp(-(v/0.1)^2) + 3000000000*sgn(q) + sqrt(F^2)",
    "2000000000*sgn(v) + 2000000000*sgn(q) + sin(3*t)/(1 + F^2)^2 + tanh(q) + q^7 + 2",
]
STATES = ("q", "v", "state", "x 3")


def equations_of(texts, states, inputs=(), operators=()):
    names = (*states, *inputs, "t")
    sides = [parse(text, names, operators=operators).known.parts for text in texts]
    columns = tuple(dict.fromkeys(term for side in sides for _, term in side))
    coef = [[{p: c for c, p in side}.get(term, 0.0) for term in columns] for side in sides]
    return Equations(columns, np.array(coef).reshape(len(sides), -1), tuple(states), tuple(inputs))


@pytest.fixture
def equations():
    return equations_of(SIDES, STATES, ("F",))


@pytest.fixture
def friction():
    return equations_of(SIDES[:2], ("q", "v"), ("F",))


@pytest.fixture
def points():
    rng = np.random.default_rng(0)
    points = rng.normal(size=(30, 5)) * rng.integers(0, 2, size=(30, 5))
    return np.vstack([np.zeros(5), points])


def test_python_code_computes_what_the_model_does(equations, points):
    namespace = {}
    exec(export.to_code(equations, "python", name="f"), namespace)  # noqa: S102
    x, u = points[:, :4], points[:, 4:]
    expected = export.to_callable(equations)(0.7, x, u)
    np.testing.assert_allclose(namespace["f"](0.7, x, u), expected, rtol=1e-12, atol=1e-6)
    np.testing.assert_allclose(namespace["f"](0.7, x[1], u[1]), expected[1], rtol=1e-12, atol=1e-6)


@pytest.mark.parametrize("inputs", [("F",), ("F", "G")])
def test_python_code_takes_the_inputs_that_a_callable_takes(inputs):
    equations = equations_of(["v", " + ".join(f"{k + 2}*{i}" for k, i in enumerate(inputs))],
                             ("q", "v"), inputs)  # fmt: skip
    namespace = {}
    exec(export.to_code(equations), namespace)  # noqa: S102
    x, u = np.arange(6.0).reshape(3, 2), np.arange(3.0 * len(inputs)).reshape(3, -1)
    expected = export.to_callable(equations)
    for given in [u, u[0]] + ([u[:, 0]] if len(inputs) == 1 else []):
        np.testing.assert_allclose(namespace["rhs"](0.0, x, given), expected(0.0, x, given))
    single = u[1] if len(inputs) > 1 else u[1, 0]
    np.testing.assert_allclose(namespace["rhs"](0.0, x[1], single), expected(0.0, x[1], single))
    with pytest.raises(ValueError, match=f"last axis of input must hold {', '.join(inputs)}"):
        namespace["rhs"](0.0, x, np.ones(7))
    with pytest.raises(ValueError, match="last axis of state must hold q, v"):
        namespace["rhs"](0.0, x.T, u)


def test_python_code_without_inputs_or_terms_runs():
    namespace = {}
    exec(export.to_code(equations_of(["0", "2"], ("q", "v"))), namespace)  # noqa: S102
    np.testing.assert_array_equal(namespace["rhs"](0.0, [[1, 2], [3, 4]]), [[0, 2], [0, 2]])


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
def test_c_code_compiles_and_computes_what_the_model_does(equations, points, tmp_path):
    source, library = tmp_path / "rhs.c", tmp_path / "rhs.so"
    source.write_text(export.to_code(equations, "c"), encoding="utf-8")
    command = ["gcc", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", "-std=c99"]
    subprocess.run([*command, str(source), "-o", str(library), "-lm"], check=True)
    rhs = ctypes.CDLL(str(library)).rhs
    pointer = ctypes.POINTER(ctypes.c_double)
    rhs.argtypes, rhs.restype = [ctypes.c_double, pointer, pointer, pointer], None
    expected = export.to_callable(equations)(0.7, points[:, :4], points[:, 4:])
    for point, row in zip(points, expected, strict=True):
        x, u, rate = point[:4].copy(), point[4:].copy(), np.empty(4)
        rhs(0.7, *(array.ctypes.data_as(pointer) for array in (x, u, rate)))
        np.testing.assert_allclose(rate, row, rtol=1e-12, atol=1e-6)


@pytest.mark.parametrize(
    ("language", "pieces"),
    [
        ("c", ["(((v) > 0) - ((v) < 0))", "const double q = state[0];", "2370000.0*q*q*q"]),
        ("matlab", ["function rate = rhs(t, state, input)", "sign(v)", "q.^3", "q = state(1);"]),
        ("julia", ["function rhs!(rate, state, input, t)", "sign(v)", "F = input[1]"]),
        ("modelica", ["der(q) = v;", "sign(v)", "q^3"]),
        ("python", ["numpy.sign(v)", "q**3", "1.5e-05", "691.92"]),
    ],
)
def test_code_is_in_the_language(friction, language, pieces):
    code = export.to_code(friction, language)
    assert [piece for piece in pieces if piece not in code] == []


def test_modelica_calls_time_by_its_own_name():
    assert export.to_code(equations_of(["sin(2*t)"], ("q",)), "modelica") == "der(q) = sin(2*time);"


@pytest.mark.parametrize("language", LANGUAGES)
def test_numbers_lose_no_digit(language):
    assert "0.30000000000000004" in export.to_code(
        equations_of(["0.30000000000000004*q"], ("q",)), language
    )


@pytest.mark.parametrize("language", LANGUAGES)
def test_functions_of_the_user_are_called_by_name(language):
    bump = Operator("bump", lambda a, b: np.exp(-a * b), 2)
    code = export.to_code(equations_of(["3*bump(q, 2*q)"], ("q",), operators=[bump]), language)
    assert "bump(q, 2" in code
    assert "upported" not in code


def test_functions_of_the_user_with_a_sympy_form_are_written_out():
    relu = Operator("relu", lambda a: np.maximum(a, 0.0), 1, sympy=lambda a: sympy.Max(a, 0))
    code = export.to_code(equations_of(["relu(q)"], ("q",), operators=[relu]), "c")
    assert "rate[0] = ((0.0 > q) ? 0.0 : q);" in code or "fmax(" in code


def test_what_a_language_cannot_express_is_an_error():
    odd = Operator("odd", np.sinc, 1, sympy=sympy.zeta)
    with pytest.raises(ValueError, match=r"to_code\(language=...\) must be able to express"):
        export.to_code(equations_of(["odd(q)"], ("q",), operators=[odd]), "c")


OWN = {
    "relu": Operator("relu", lambda a: np.maximum(a, 0.0), 1, lambda a: sympy.Max(a, 0)),
    "clip": Operator(
        "clip", lambda a: np.clip(a, -0.5, 0.5), 1, lambda a: sympy.Max(sympy.Min(a, 0.5), -0.5)
    ),
    "erf": Operator("erf_", erf, 1, sympy.erf),
}


@pytest.mark.parametrize("own", OWN.values(), ids=OWN)
def test_python_code_imports_what_it_calls(own):
    model, namespace = equations_of([f"{own.name}(q)"], ("q",), operators=(own,)), {}
    exec(export.to_code(model, "python", name="f"), namespace)  # noqa: S102
    q = np.linspace(-2.0, 2.0, 9)[:, None]
    np.testing.assert_allclose(namespace["f"](0.0, q)[:, 0], own(q[:, 0]), rtol=1e-12)


def test_modelica_has_max_of_two_and_no_function_that_it_does_not_know():
    clip = equations_of(["clip(q)"], ("q",), operators=(OWN["clip"],))
    assert export.to_code(clip, "modelica") == "der(q) = max(-0.5, min(0.5, q));"
    other = equations_of(["erf_(q)"], ("q",), operators=(OWN["erf"],))
    with pytest.raises(ValueError, match=r"'modelica', which is not: erf is no function"):
        export.to_code(other, "modelica")


@pytest.mark.parametrize("language", ["fortran77", "", None, 3])
def test_unknown_language_is_an_error(friction, language):
    with pytest.raises(ValueError, match=r"to_code\(language=...\) must be a known language; got"):
        export.to_code(friction, language)


@pytest.mark.parametrize("name", ["2f", "", "a b", "f;", "lambda", "for", None])
def test_name_of_the_function_must_be_an_identifier(friction, name):
    with pytest.raises(ValueError, match=r"to_code\(name=...\) must be an identifier"):
        export.to_code(friction, "c", name=name)


# -- tree ----------------------------------------------------------------------------------------


def test_tree_has_the_nodes_of_the_equation(friction):
    root = expression_tree(system_of(friction, "plot_tree"), 1)
    assert root.label == "+"
    assert [child.label for child in root.children] == [
        "−691.9", "−1.1", "−1.02", "−2.93", "−2.37·10⁶", "−7630", "1.5·10⁻⁵",
    ]  # fmt: skip
    # Sum; 4 coefficients of a variable; one of sgn and v; one of ×, q², sgn and v; constant.
    assert root.size == 1 + 4 * 2 + 3 + 5 + 1
    (product,) = root.children[5].children
    assert [child.label for child in product.children] == ["q²", "sgn"]


@pytest.mark.parametrize(
    ("text", "labels"),
    [
        ("0", ["0"]),
        ("q", ["q"]),
        ("-q", ["−", "q"]),
        ("q/(0.5 + q)", ["÷", "q", "+", "q", "0.5"]),
        ("1/q^2", ["÷", "1", "q²"]),
        ("sin(2*q)^2", ["sin²", "2", "q"]),
        ("(1 + q)^60", ["( )⁶⁰", "+", "q", "1"]),
        ("1e9", ["10⁹"]),
    ],
)
def test_tree_of_single_terms(text, labels):
    def walk(node):
        yield node.label
        for child in node.children:
            yield from walk(child)

    assert list(walk(expression_tree(system_of(equations_of([text], ("q",)), ""), 0))) == labels


@pytest.fixture
def plt():
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    yield plt
    plt.close("all")


def boxes(ax):
    from matplotlib.patches import FancyBboxPatch

    return [patch for patch in ax.patches if isinstance(patch, FancyBboxPatch)]


@pytest.mark.parametrize("n_terms", [1, 2, 6, 15])
def test_plot_draws_every_node_apart_from_the_others(plt, n_terms):
    text = " + ".join(f"{1.5 * i + 1e3}*sin({i + 2}*q)*v^{i + 1}" for i in range(n_terms))
    equations = equations_of(["v", text], ("q", "v"))
    ax = export.plot_tree(equations, "v")
    ax.figure.canvas.draw()
    drawn = boxes(ax)
    size = expression_tree(system_of(equations, ""), 1).size
    assert len(drawn) == len(ax.texts) == size + 1  # and the left-hand side
    areas = [patch.get_window_extent() for patch in drawn]
    for i, one in enumerate(areas):
        assert not any(one.overlaps(other) for other in areas[:i])
        label = ax.texts[i].get_window_extent()
        assert label.width <= one.width
        assert label.height <= one.height * 1.2


def test_plot_goes_into_given_axes_and_fits_them(plt, friction):
    figure, axes = plt.subplots(1, 2, figsize=(6, 3))
    assert export.plot_tree(friction, "v", ax=axes[1]) is axes[1]
    figure.canvas.draw()
    frame = axes[1].get_window_extent()
    for text in axes[1].texts:
        extent = text.get_window_extent()
        assert frame.x0 <= extent.x0
        assert extent.x1 <= frame.x1


def test_plot_shows_the_last_state_by_default_and_any_name(plt):
    q = equations_of(["q", "-q"], ("q", "v"))
    named = Equations(q.terms, q.coef, ("$x_0", "v^2"))
    ax = export.plot_tree(named)
    ax.figure.canvas.draw()
    assert ax.texts[0].get_text() == "v^2′ ="


def test_unknown_state_is_an_error(friction):
    with pytest.raises(
        ValueError, match=r"plot_tree\(state=...\) must be a state .* got 'w'.*q, v"
    ):
        export.plot_tree(friction, "w")


def test_plot_without_matplotlib_names_the_extra(friction, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    monkeypatch.delitem(sys.modules, "pysindy_evolve.export.drawing", raising=False)
    with pytest.raises(ImportError, match=r'pip install "pysindy-evolve\[plots\]"'):
        export.plot_tree(friction, "v")


def test_names_of_other_alphabets_are_spelled_out():
    code = export.to_code(equations_of(["ω", "-2*θ"], ("θ", "ω")), language="c")
    assert "theta = state[0]" in code
    assert "omega = state[1]" in code
