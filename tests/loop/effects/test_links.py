"""Weights and Coriolis forces of links are found as one force at several joints."""

import numpy as np
import pytest
from loop_systems import equations_of, multisine

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.effects.names import COUPLING, GRAVITY
from pysindy_evolve.loop.given.ranges import Ranges
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import add, call, variable

D = "(0.5*(2.2 + 0.9*cos(q2)) - (0.5 + 0.45*cos(q2))**2)"
PAYLOAD = add(variable(0), variable(2))  # its direction


def arm(
    weight: str, damping: tuple[str, str] = ("- d1*w1", "- d2*w2"), coriolis: float = 0.45
) -> dict[str, str]:
    """Return the equations of an arm that hangs down, with the weight of its second link."""
    exchanged = f"{coriolis}*sin(q2)*(2*w1*w2 + w2**2)", f"{coriolis}*sin(q2)*w1**2"
    first = f"(M1 + {exchanged[0]} {damping[0]} - 14*sin(q1) {weight})"
    second = f"(M2 - {exchanged[1]} {damping[1]} {weight})"
    across, m11 = "(0.5 + 0.45*cos(q2))", "(2.2 + 0.9*cos(q2))"
    return {
        "q1": "w1",
        "w1": f"(0.5*{first} - {across}*{second})/{D}",
        "q2": "w2",
        "w2": f"({m11}*{second} - {across}*{first})/{D}",
    }


def declared(**options) -> pse.DeclaredModel:
    return pse.DeclaredModel(arm("", **options), inputs=["M1", "M2"])


def at_several(model, name, swing=2.0):
    """Return the forces at several places that may be missing: equation, places, forces."""
    rows = np.random.default_rng(0).uniform(-swing, swing, (50, model.design().time + 1))
    offered = candidates(model.design(), Ranges.of(rows))
    several = (c for c in offered if c.acts_at is not None and len(c.acts_at[0]) > 1)
    return [(c.state, *c.acts_at) for c in several if c.name == name]


def weights(model, **options):
    return at_several(model, GRAVITY, **options)


def torques(rows_or_t, seed=1):
    """Return two torques as functions of time."""
    return np.column_stack(
        [multisine(size, seed + k, (0.2, 1.5))(rows_or_t) for k, size in enumerate((6.0, 2.0))]
    )


def recorded(truth):
    t = np.arange(0.0, 20.0, 0.01)
    x = pse.simulate(equations_of(truth, ("M1", "M2")), [0.0] * 4, t, u=torques(t), tolerance=1e-8)
    y = x[:, ::2] + 1e-4 * np.random.default_rng(0).standard_normal((len(t), 2))
    return pse.prepare(t, y, torques(t))


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


@pytest.mark.parametrize(
    ("sides", "kinetic"),
    [
        # an elbow, whose angle is that between the links
        (arm(""), "cos(q2)*(w1**2 + w1*w2)"),
        # both angles from the vertical
        (
            {
                "q1": "w1",
                "w1": "(M1 - cos(q1 - q2)*M2)/(2 - cos(q1 - q2)**2) - a*w1",
                "q2": "w2",
                "w2": "(M2 - cos(q1 - q2)*M1)/(2 - cos(q1 - q2)**2) - b*w2",
            },
            "cos(q1 - q2)*w1*w2",
        ),
        # a slide on a beam whose center of mass is off its axis
        (
            {
                "q1": "w1",
                "w1": "(M1 - a*w1 + 0.3*q2*(M2 - b*w2))/(1 + q2**2)",
                "q2": "w2",
                "w2": "M2 - b*w2 + 0.3*q2*(M1 - a*w1)/(1 + q2**2)",
            },
            "q2**2*w1**2/2",
        ),
    ],
)
def test_forces_between_joints_take_the_power_that_the_changing_inertia_gives(sides, kinetic):
    """At constant speeds it is minus the rate of the kinetic energy by the angles alone."""
    model = pse.DeclaredModel(sides, inputs=["M1", "M2"])
    energy = pse.DeclaredModel({"z": kinetic}, inputs=["q1", "w1", "q2", "w2"]).design()
    rows = np.random.default_rng(1).uniform(-1.0, 1.0, (40, 7))
    step = np.zeros_like(rows)
    step[:, [0, 2]] = 1e-5 * rows[:, [1, 3]]
    moved = [energy.fixed[0].evaluate(np.roll(rows + k * step, 1, axis=1)) for k in (-1, 1)]
    rate = (moved[1] - moved[0]) / 2e-5
    found = at_several(model, COUPLING)
    powers = [
        sum(f.evaluate(rows) * rows[:, {4: 1, 5: 3}.get(p, p)] for p, f in zip(*at, strict=True))
        for _, *at in found
    ]
    assert any(power == pytest.approx(-rate, abs=1e-6) for power in powers)


def test_a_slide_on_a_turntable_exchanges_velocities_but_no_accelerations():
    model = pse.DeclaredModel(
        {"q": "w", "w": "(M - a*w)/(1 + r**2)", "r": "v", "v": "F - b*v"}, inputs=["M", "F"]
    )
    rows = np.random.default_rng(0).uniform(-1.0, 1.0, (50, 7))
    offered = candidates(model.design(), Ranges.of(rows))
    coriolis = rows[:, 1] * rows[:, 2] * rows[:, 3] / (1.0 + rows[:, 2] ** 2)
    terms = [c.terms[0].evaluate(rows) for c in offered if c.state == 1 and len(c.terms) == 1]
    assert any(term == pytest.approx(-2.0 * coriolis) for term in terms)


@pytest.mark.slow
def test_the_weight_of_a_second_link_is_named_in_both_equations():
    report = pse.close_loop(
        declared(),
        recorded(arm("- 2*sin(q1 + q2)", ("- 1.2*w1", "- 0.5*w2"))),
        operators=(),
        n_twins=59,
        random_state=0,
    )
    named = sorted((effect.name, effect.state) for effect in report.effects)
    assert named == [("gravity", "w1"), ("gravity", "w2")]
    for effect in report.effects:
        assert effect.coefficients[0] == pytest.approx(-2.0, rel=0.02)
    said = " ".join(str(report).split())
    assert "acts where M1 and M2 act, as this number times sin(q1 + q2), with coeff" in said


@pytest.mark.slow
def test_coriolis_forces_of_an_elbow_are_named_in_both_equations():
    report = pse.close_loop(
        declared(coriolis=0.0),
        recorded(arm("", ("- 1.2*w1", "- 0.5*w2"))),
        operators=(),
        n_twins=59,
        random_state=0,
    )
    named = sorted((effect.name, effect.state) for effect in report.effects)
    assert named == [("coupling", "w1"), ("coupling", "w2")]
    for effect in report.effects:
        assert effect.coefficients[0] == pytest.approx(0.45, rel=0.02)
