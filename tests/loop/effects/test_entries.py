"""Forces that enter through the inverse of a mass matrix are found as what they are."""

import numpy as np
import pytest
import sympy
from loop_systems import equations_of, multisine

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.entries import entered, entries_of
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.evidence.pairing import groups_to_try
from pysindy_evolve.loop.given.ranges import Ranges
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import call, mul, power, variable

((_, CUBE),) = power(variable(0), 3).parts
D = "(1 + 0.25*sin(q)**2)"
CART = pse.DeclaredModel(
    {
        "x": "v",
        "v": f"(F - c*v + 0.125*w**2*sin(q) + 2.45*sin(q)*cos(q) + 2*d*w*cos(q)) / {D}",
        "q": "w",
        "w": f"-2*(cos(q)*(F - c*v) + 0.125*w**2*sin(q)*cos(q) + 12.3*sin(q) + 10*d*w) / {D}",
    },
    inputs=["F"],
)


def test_a_force_at_the_cart_and_a_torque_at_the_joint_enter_as_the_damping_there_does():
    design = CART.design()
    side = dict(CART.sides[3].free)
    cart, joint = entries_of(design, 3)
    assert [cart.velocities, joint.velocities] == [(1,), (3,)]
    rows = np.random.default_rng(0).uniform(0.3, 1.2, (20, 6))
    for entry, name, speed in ((cart, "c", 1), (joint, "d", 3)):
        share = entry.factor.evaluate(rows) * rows[:, speed] / side[name].evaluate(rows)
        assert share == pytest.approx(np.full(20, share[0]))


def test_what_an_effect_enters_with_is_known_whatever_it_depends_on():
    design, q, v = CART.design(), variable(2), variable(1)
    cart, joint = entries_of(design, 3)
    friction = call(BUILTIN["sgn"], v)
    for entry, force in ((cart, friction), (joint, mul(q, friction))):
        assert entered(design, 3, mul(force, entry.factor)) == (entry, force)
    assert entered(design, 3, friction) is None


def test_a_friction_of_the_cart_is_one_force_in_its_equation_and_in_that_of_the_joint():
    ranges = Ranges.of(np.random.default_rng(0).normal(size=(50, 6)))
    offered = candidates(CART.design(), ranges)
    groups = groups_to_try(offered, range(len(offered)), set(), pairs=True)
    forces = [[offered[i] for i in g] for g in groups if len(g) == 2 and offered[g[0]].acts_at]
    assert all(one.name == other.name and one.state != other.state for one, other in forces)
    assert {"Coulomb friction"} <= {one.name for one, _ in forces}


def test_a_constant_factor_is_no_entry():
    design = pse.DeclaredModel({"q": "v", "v": "b*F - c*v - k*q"}, inputs=["F"]).design()
    assert entries_of(design, 1) == []


def test_a_measured_load_on_a_brake_is_no_place_where_forces_enter():
    """A friction there, sgn(v)^2, was named as an alternative of a constant offset."""
    brake = pse.DeclaredModel({"q": "v", "v": "b*M - f*N*sgn(v)"}, inputs=["M", "N"])
    assert entries_of(brake.design(), 1) == []


def test_without_a_declared_damping_a_force_may_depend_on_any_speed():
    design = pse.DeclaredModel(
        {"q": "v", "v": "F/(1 + q**2) - k*q", "p": "w", "w": "-a*p"}, inputs=["F"]
    ).design()
    (entry,) = entries_of(design, 1)
    assert entry.velocities == (1, 3)


def test_what_is_a_spring_by_itself_is_none_of_a_damping_with_a_place():
    """In a circuit of van der Pol a cubic stiffness is v times the -v**2 of its damping."""
    model = pse.DeclaredModel({"v": "w", "w": "m*w - n*v**2*w - k*v"})
    ranges = Ranges.of(np.random.default_rng(0).normal(size=(50, 3)))
    cubic = [c.name for c in candidates(model.design(), ranges) if c.terms[0].parts[-1][1] == CUBE]
    assert cubic == ["cubic stiffness"]


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_friction_of_a_changing_inertia_is_found_with_it(friction, tmp_path):
    true = equations_of(
        {"q": "v", "v": f"(F - 4*q - 0.5*v - {friction}*sign(v)) / (1 + 2*q**2)"}, ("F",)
    )
    t, records = np.arange(0.0, 20.0, 0.01), []
    for seed in range(2):
        rng = np.random.default_rng(seed)
        phases = rng.uniform(0.0, 2.0 * np.pi, 9)
        waves = np.sin(np.multiply.outer(t, np.linspace(0.5, 6.0, 9)) + phases)
        force = waves.sum(axis=1, keepdims=True)
        q = pse.simulate(true, [0.0, 0.0], t, u=force)[:, :1]
        records.append(pse.prepare(t, q + 1e-3 * rng.standard_normal(q.shape), force))
    declared = pse.DeclaredModel({"q": "v", "v": "(F - k*q - c*v) / (1 + 2*q**2)"}, inputs=["F"])
    report = pse.close_loop(declared, *records, operators=(), random_state=0)
    assert [effect.name for effect in report.effects] == ["Coulomb friction"] * (friction > 0.0)
    if friction:
        (effect,) = report.effects
        assert effect.coefficients[0] == pytest.approx(-friction, rel=0.03)
        assert "q**2" in str(effect.term)
        said = "acts as if F were larger by this number times sgn(v)"
        report.to_html(tmp_path / "report.html")
        page = (tmp_path / "report.html").read_text(encoding="utf-8")
        assert said in str(report)
        assert said in page
        assert report.after.derivative_error[1] < 0.5 * report.before.derivative_error[1]


@pytest.mark.slow
def test_air_that_leaks_from_chamber_to_chamber_is_found_in_both():
    """It raises a pressure by the factor of the measured inflow, as the piston moves."""
    t = np.arange(0.0, 20.0, 0.01)
    place = multisine(0.03, seed=1, band=(0.1, 0.8))(t)
    flows = [multisine(1.0, seed=2 + k, band=(0.1, 1.5))(t) for k in range(2)]
    inputs = np.column_stack([*flows, place])
    sides = {
        "p1": "(0.5*m1 - 0.3*(p1 - p2) - 0.1*p1)/(0.15 + q)",
        "p2": "(0.5*m2 + 0.3*(p1 - p2) - 0.1*p2)/(0.15 - q)",
    }
    x = pse.simulate(equations_of(sides, ("m1", "m2", "q")), [0.0, 0.0], t, inputs)
    y = x + 0.003 * x.std(axis=0) * np.random.default_rng(0).standard_normal(x.shape)
    declared = {"p1": "(a*m1 - c*p1)/(0.15 + q)", "p2": "(b*m2 - d*p2)/(0.15 - q)"}
    report = pse.close_loop(
        pse.DeclaredModel(declared, inputs=["m1", "m2", "q"]),
        pse.prepare(t, y, inputs, order=1),
        operators=(),
        n_twins=59,
        random_state=0,
    )
    p1, p2, q = sympy.symbols("p1 p2 q", real=True)
    leaks = {"p1": 0.3 * (p2 - p1) / (0.15 + q), "p2": 0.3 * (p1 - p2) / (0.15 - q)}
    assert {(effect.name, effect.state) for effect in report.effects} == {
        ("coupling", "p1"), ("coupling", "p2"),
    }  # fmt: skip
    for effect in report.effects:
        ratio = sympy.simplify(effect.coefficients[0] * effect.term / leaks[effect.state])
        assert float(ratio) == pytest.approx(1.0, rel=0.03)
