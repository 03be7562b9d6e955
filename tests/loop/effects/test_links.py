"""The weight of a link, or of what an arm carries, is found as one force at several joints."""

import numpy as np
import pytest
from loop_systems import equations_of, multisine

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.given.ranges import Ranges
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import add, call, variable

D = "(0.5*(2.2 + 0.9*cos(q2)) - (0.5 + 0.45*cos(q2))**2)"
PAYLOAD = add(variable(0), variable(2))  # its direction


def arm(weight: str, damping: tuple[str, str] = ("- d1*w1", "- d2*w2")) -> dict[str, str]:
    """Return the equations of an arm that hangs down, with the weight of its second link."""
    first = f"(M1 + 0.45*sin(q2)*(2*w1*w2 + w2**2) {damping[0]} - 14*sin(q1) {weight})"
    second = f"(M2 - 0.45*sin(q2)*w1**2 {damping[1]} {weight})"
    across, m11 = "(0.5 + 0.45*cos(q2))", "(2.2 + 0.9*cos(q2))"
    return {
        "q1": "w1",
        "w1": f"(0.5*{first} - {across}*{second})/{D}",
        "q2": "w2",
        "w2": f"({m11}*{second} - {across}*{first})/{D}",
    }


def declared(**options) -> pse.DeclaredModel:
    return pse.DeclaredModel(arm("", **options), inputs=["M1", "M2"])


def weights(model, swing=2.0):
    """Return the force of each weight at several joints that may be missing, by its places."""
    rows = np.random.default_rng(0).uniform(-swing, swing, (50, 7))
    offered = candidates(model.design(), Ranges.of(rows))
    several = (c for c in offered if c.acts_at is not None and len(c.acts_at[0]) > 1)
    return [(c.state, *c.acts_at) for c in several]


def test_a_link_is_lifted_by_both_joints_before_it():
    forces = [(call(BUILTIN[name], PAYLOAD),) for name in ("sin", "cos")]
    wanted = [(state, (4, 5), force) for state in (1, 3) for force in forces]
    assert sorted(weights(declared()), key=str) == sorted(wanted, key=str)


def test_without_a_declared_damping_it_is_the_same():
    """Nobody knows at which joint an input acts then, but all of them lift the last link."""
    assert weights(declared(damping=("", ""))) == weights(declared())


def test_a_link_that_hardly_swings_has_no_weight_but_an_offset_and_a_spring():
    assert weights(declared(), swing=0.2) == []


def test_it_enters_as_torques_at_both_joints_do():
    """In the equation of each joint it is what two equal torques would make of it."""
    model = declared().design()
    rows = np.random.default_rng(0).uniform(-2.0, 2.0, (50, 7))
    shifted = rows.copy()
    shifted[:, 4:6] += np.cos(rows[:, 0] + rows[:, 2])[:, None]
    for state in (1, 3):
        found = candidates(model, Ranges.of(rows))
        (term,) = next(
            c.terms
            for c in found
            if c.state == state and c.acts_at == ((4, 5), (call(BUILTIN["cos"], PAYLOAD),))
        )
        moved = model.fixed[state].evaluate(shifted) - model.fixed[state].evaluate(rows)
        assert term.evaluate(rows) == pytest.approx(moved)


@pytest.mark.slow
def test_the_weight_of_a_second_link_is_named_in_both_equations():
    truth = equations_of(arm("- 2*sin(q1 + q2)", ("- 1.2*w1", "- 0.5*w2")), ("M1", "M2"))
    t = np.arange(0.0, 20.0, 0.01)
    torques = np.column_stack([multisine(6.0, 1, (0.2, 1.5))(t), multisine(2.0, 2, (0.2, 1.5))(t)])
    x = pse.simulate(truth, [0.0] * 4, t, u=torques, tolerance=1e-8)
    y = x[:, ::2] + 1e-4 * np.random.default_rng(0).standard_normal((len(t), 2))
    report = pse.close_loop(declared(), pse.prepare(t, y, torques), operators=(), random_state=0)
    named = sorted((effect.name, effect.state) for effect in report.effects)
    assert named == [("gravity", "w1"), ("gravity", "w2")]
    for effect in report.effects:
        assert effect.coefficients[0] == pytest.approx(-2.0, rel=0.02)
    said = " ".join(str(report).split())
    assert "acts where M1 and M2 act, as this number times sin(q1 + q2) in both" in said
