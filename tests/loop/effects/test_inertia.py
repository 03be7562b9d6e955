"""An inertia that goes up and down with an angle divides all forces, and has a centrifugal term."""

import numpy as np
import pytest
from loop_systems import equations_of, measured

import pysindy_evolve as pse
from pysindy_evolve.export.compact import as_fractions
from pysindy_evolve.loop.effects.inertia import inertia_candidate, inertias
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.effects.names import INERTIA
from pysindy_evolve.loop.evidence.scoring import columns_of, takes_energy
from pysindy_evolve.loop.given.inertia import InertiaWave, over_inertia
from pysindy_evolve.loop.given.ranges import Ranges
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.terms import variable

CRANK = pse.DeclaredModel({"q": "w", "w": "b*F - c*w"}, inputs=["F"])
OVER = "/(1 + 0.2*cos(2*q) - 0.1*sin(2*q))"
CENTRIFUGAL = "(0.2*sin(2*q) + 0.1*cos(2*q))*w**2"
WAVES = [(0.2, InertiaWave(0, 1, 2.0, "cos")), (-0.1, InertiaWave(0, 1, 2.0, "sin"))]
Z = np.random.default_rng(0).uniform(-3.0, 3.0, (50, 4))  # q, w, F, t


def evaluated(side):
    return side.evaluate(Z)


def rate_of(forces, over=OVER):
    (_, rate) = equations_of({"q": "w", "w": f"({forces}){over}"}, ("F",)).sums
    return evaluated(rate)


def test_forces_stand_over_the_inertia_with_its_centrifugal_term():
    rate = evaluated(over_inertia(variable(2), WAVES))
    np.testing.assert_allclose(rate, rate_of(f"F + {CENTRIFUGAL}"))


def test_kinetic_energy_is_kept_without_forces():
    sides = {"q": "w", "w": f"({CENTRIFUGAL}){OVER}"}
    x = pse.simulate(equations_of(sides), [0.3, 2.0], np.arange(0.0, 5.0, 0.01), tolerance=1e-9)
    q, w = x.T
    energy = 0.5 * (1.0 + 0.2 * np.cos(2 * q) - 0.1 * np.sin(2 * q)) * w**2
    np.testing.assert_allclose(energy, energy[0], rtol=1e-6)


def test_equations_hold_the_inertia_and_columns_what_a_constant_one_lacks():
    design = CRANK.design()
    forces = design.equations([5.0, 0.8]).sums[1]
    exact = inertia_candidate(1, 0, over_inertia(forces, WAVES), 2.0, 0.2)
    whole = design.adding(columns_of(exact, design))
    coef = np.array([5.0, 0.8, 0.2, -0.1])
    rate = evaluated(whole.equations(coef).sums[1])
    np.testing.assert_allclose(rate, rate_of(f"5*F - 0.8*w + {CENTRIFUGAL}"))
    # With the acceleration itself in them, the columns say the same.
    linear = sum(
        c * column.evaluate(Z)[:, 1] for c, column in zip(coef, whole.columns, strict=True)
    )
    np.testing.assert_allclose(linear, rate)


def test_an_inertia_is_read_about_its_mean():
    side = as_fractions(over_inertia(variable(2), WAVES)).name(["q", "w", "F"])
    assert side.endswith("/(1 + 0.2 cos(2 q) - 0.1 sin(2 q))")


@pytest.mark.parametrize(("swing", "numbers"), [(1.5, []), (1.7, [1.0, 2.0])])
def test_inertias_are_on_offer_from_a_quarter_turn_each_way(swing, numbers):
    ranges = Ranges.about_zero(np.full(4, swing))
    found = inertias(1, 0, variable(2), ranges, range(2, 3))
    assert [one.shape.values[0] for one in found] == numbers
    assert all(one.size == 2 and one.name == INERTIA for one in found)
    assert all(one.at([2.1]).waves[0].number == 2.1 for one in found)
    assert inertias(1, 0, variable(1), ranges, range(2, 3)) == []  # no measured force acts


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_the_sign_of_a_term_is_told_beside_an_inertia(sign):
    forces = f"5*F - 0.8*w - 2*q + {sign * 0.5}*sgn(w) + {CENTRIFUGAL}"
    record = measured({"q": "w", "w": f"({forces}){OVER}"}, noise=1e-4, size=3.0)
    design = pse.DeclaredModel({"q": "w", "w": "b*F - c*w - k*q"}, inputs=["F"]).design()
    inertia = inertia_candidate(1, 0, variable(2), 2.0, 0.2)
    design = design.adding(columns_of(inertia, design))
    part = segments([record], design.velocities)
    friction = next(c for c in candidates(design, part.ranges) if c.name == "Coulomb friction")
    assert takes_energy(friction, design, part) is (sign < 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("extra", ["", " - 0.5*sgn(w)"])
def test_the_inertia_of_a_crank_is_found_with_its_amplitudes_and_friction_beside_it(extra):
    model = pse.DeclaredModel({"q": "w", "w": "b*F - c*w - k*q"}, inputs=["F"])
    forces = f"F - 0.8*w - 2*q{extra} + {CENTRIFUGAL}"
    truth = {"q": "w", "w": f"({forces}){OVER}"}
    records = [measured(truth, noise=5e-4, size=12.0, seed=seed) for seed in (7, 8)]
    report = pse.close_loop(model, *records, operators=(), n_twins=59, random_state=0)
    found = {effect.name: effect for effect in report.effects}
    assert set(found) == {INERTIA} | ({"Coulomb friction"} if extra else set())
    np.testing.assert_allclose(found[INERTIA].coefficients, [0.2, -0.1], atol=0.01)
    assert found[INERTIA].numbers["wave number"] == pytest.approx(2.0, rel=5e-3)
    assert report.after.parameters == pytest.approx({"b": 1.0, "c": 0.8, "k": 2.0}, rel=0.03)
    assert "it acts in the inertia" in str(report)
