"""Algebraic targets: forces explained by a motion, in the same loop, nothing differentiated."""

import numpy as np
import pytest
from loop_systems import equations_of

import pysindy_evolve as pse
from pysindy_evolve.export import format_equations
from pysindy_evolve.loop.given.resampling import at_one_step, undecimated
from pysindy_evolve.signals import as_target

DECLARED = pse.DeclaredModel({"F": "c*v + k*x + F0"}, inputs=["x", "v"], algebraic=True)


def measured_force(extra, seed=0, noise=0.02, duration=30.0):
    """Measure a force on a rig whose position is prescribed: a sum of a few sines."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, duration, 0.01)
    phases = rng.uniform(0, 2 * np.pi, 5)
    frequencies = 2 * np.pi * np.array([0.3, 0.55, 0.8, 1.1, 1.45])
    arguments = np.outer(t, frequencies) + phases
    x, v = np.sin(arguments).sum(axis=1), (np.cos(arguments) * frequencies).sum(axis=1)
    force = 2.0 * v + 3.0 * x + 1.0 + extra(x, v)
    force = force + noise * force.std() * rng.standard_normal(len(t))
    return pse.Record(t=t, x=force, x_dot=force, u=np.column_stack([x, v]))


def close(record, **options):
    settings = {"operators": (), "random_state": 0, "n_twins": 59} | options
    return pse.close_loop(DECLARED, record, **settings)


@pytest.fixture(scope="module")
def lacking_nothing():
    return close(measured_force(lambda x, v: 0.0 * x))


@pytest.fixture(scope="module")
def rubbing():
    """A loop that finds the friction in a force."""
    return close(measured_force(lambda x, v: 5.0 * np.sign(v)))


def test_nothing_is_named_where_the_force_is_as_declared(lacking_nothing):
    assert lacking_nothing.effects == []
    assert lacking_nothing.verdict == "complete"


def test_coulomb_friction_in_a_force_is_found_with_its_size(rubbing):
    (effect,) = rubbing.effects
    assert effect.name == "Coulomb friction"
    assert effect.state == "F"
    assert effect.coefficients == pytest.approx([5.0], rel=0.05)


def test_a_bump_stop_in_a_force_is_found_with_its_place_and_its_side():
    record = measured_force(lambda x, v: 20.0 * np.maximum(x - 1.5, 0.0), duration=15.0)
    (effect,) = close(record).effects
    assert effect.name == "dead zone"
    assert effect.numbers["end"] == pytest.approx(1.5, rel=0.02)
    assert effect.coefficients == pytest.approx([20.0], rel=0.05)
    assert effect.term.subs(dict.fromkeys(effect.term.free_symbols, 3.0)) > 1.0


@pytest.mark.slow
def test_hysteresis_in_a_force_is_found_and_betters_what_was_held_out():
    report = close(measured_force(lambda x, v: 8.0 * np.tanh((v + 2.0 * x) / 2.0)))
    assert report.effects[0].name == "hysteresis"
    assert report.after.simulation_error[0] < 0.4 * report.before.simulation_error[0]


@pytest.mark.slow
@pytest.mark.parametrize(("zero", "seed"), [(0.0, 0), (40.0, 1)])
def test_width_slant_and_middle_of_a_hysteresis_are_tuned_together(zero, seed):
    plain = measured_force(lambda x, v: 8.0 * np.tanh((v - 0.8 * x) / 1.4), seed)
    moved = plain.u + np.array([zero, 0.0])
    (effect,) = close(pse.Record(t=plain.t, x=plain.x, x_dot=plain.x, u=moved)).effects
    assert effect.name == "hysteresis"
    assert effect.coefficients == pytest.approx([8.0], rel=0.05)
    ((atom, _),) = effect.expressions[0].parts[0][1].factors
    rows = np.array([[0.0, zero, 0.0, 0.0], [0.0, zero, 1.0, 0.0], [0.0, zero + 1.0, 0.0, 0.0]])
    middle, faster, further = atom.args[0].evaluate(rows)
    assert abs(faster - middle) == pytest.approx(1.0 / 1.4, rel=0.15)
    assert (further - middle) / (faster - middle) == pytest.approx(-0.8, rel=0.15)
    assert middle / (faster - middle) == pytest.approx(0.0, abs=0.3)


def test_run_of_an_algebraic_model_is_its_right_hand_side(rubbing):
    record = rubbing.test[0]
    expected = rubbing.equations.evaluate(record.x, record.u, record.t)
    assert rubbing.simulate(record) == pytest.approx(expected)


def test_algebraic_equation_is_printed_without_a_prime(rubbing):
    text = str(rubbing)
    assert "    F = " in text
    assert "F'" not in text


@pytest.fixture(scope="module")
def of_a_force():
    return close(measured_force(lambda x, v: 0.0 * x), max_effects=0)


@pytest.mark.parametrize(
    ("language", "said"),
    [
        ("modelica", "F = "),
        ("python", "# F is returned itself, not its rate\n"),
        ("c", "// F is returned itself, not its rate\n"),
    ],
)
def test_exported_code_does_not_call_a_force_a_rate(of_a_force, language, said):
    assert pse.to_code(of_a_force, language).startswith(said)


def test_drawn_tree_of_a_force_has_no_prime(of_a_force):
    plt = pytest.importorskip("matplotlib.pyplot")
    ax = pse.plot_tree(of_a_force)
    labels = [text.get_text() for text in ax.texts]
    plt.close(ax.figure)
    assert "F =" in labels


def test_a_force_is_not_integrated(of_a_force):
    record = of_a_force.test[0]
    with pytest.raises(ValueError, match=r"must be a differential equation; got an algebraic one"):
        pse.simulate(of_a_force, record.x[0], record.t, u=record.u)
    model = of_a_force.model
    assert model.predict(record.x, u=record.u) == pytest.approx(of_a_force.simulate(record))


def test_sign_that_sympy_takes_out_of_a_function_goes_to_its_coefficient():
    text = format_equations(equations_of({"q": "5*tanh(q - 2*F) - 3*q"}, ("F",)))
    assert text == "q' = -3 q - 5 tanh(2 F - q)"


def test_declared_target_that_depends_on_itself_is_refused():
    model = pse.DeclaredModel({"F": "-a*F + k*x"}, inputs=["x", "v"], algebraic=True)
    with pytest.raises(ValueError, match=r"must give algebraic targets from inputs"):
        pse.close_loop(model, measured_force(lambda x, v: 0.0 * x))


def test_motion_becomes_the_input_and_the_force_the_target():
    t = np.arange(0.0, 20.0, 0.01)
    prepared = pse.prepare(t, np.sin(t), np.cos(3 * t), order=2)
    record = as_target(prepared)
    assert record.x == pytest.approx(prepared.u)
    assert record.u == pytest.approx(np.column_stack([prepared.x, prepared.x_dot[:, 1]]))


def test_motion_without_a_force_is_no_target():
    t = np.arange(0.0, 20.0, 0.01)
    with pytest.raises(ValueError, match=r"must be a record with inputs"):
        as_target(pse.prepare(t, np.sin(t)))


def test_table_of_a_force_speaks_of_no_derivative_and_no_run(lacking_nothing):
    head = str(lacking_nothing).split("(NRMSE)\n")[1].splitlines()[0]
    assert head.split("  ")[-1].strip() == "F"
    assert "F, averaged" in head
    assert "dF/dt" not in str(lacking_nothing)


def test_forces_decimated_each_in_its_own_way_are_brought_to_one_step():
    t = np.arange(0.0, 30.0, 0.01)
    records = [
        as_target(pse.prepare(t, np.sin(t), np.cos(t), order=1, cutoff=4.0, decimate=k))
        for k in (3, 2, 2)
    ]
    train, test = at_one_step(records[:2], records[2:])
    assert {round(record.dt, 9) for record in (*train, *test)} == {0.02}
    middle = slice(100, -100)
    assert train[0].u[middle, 0] == pytest.approx(np.sin(train[0].t[middle]), abs=1e-3)


def test_a_target_is_looked_at_as_finely_as_it_was_measured():
    """Between rows far apart, a friction that is declared looked like one that is rounded off."""
    t = np.arange(0.0, 30.0, 0.002)
    x = 0.02 * (np.sin(3.0 * t) + np.sin(7.1 * t))
    v = np.gradient(x, t)
    rng = np.random.default_rng(0)
    force = 150.0 * v + 800.0 * x + 12.0 + 10.0 * np.sign(v) + 0.1 * rng.standard_normal(len(t))
    x = x + 5e-6 * rng.standard_normal(len(t))
    record = as_target(pse.prepare(t, x, force, decimate=3))
    (fine,), _ = undecimated([record], [])
    assert fine.dt == pytest.approx(0.002)
    assert fine.t[0] >= record.t[0] - 0.002
    assert fine.t[-1] <= record.t[-1] + 0.002
    declared = pse.DeclaredModel(
        {"F": "c*v + k*x + F0 + f*sgn(v)"}, inputs=["x", "v", "a"], algebraic=True
    )
    report = pse.close_loop(declared, record, operators=(), random_state=0)
    assert report.verdict == "complete"
