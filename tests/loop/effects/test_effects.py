"""The vocabulary: which effects are proposed for which equation, and under which condition."""

from dataclasses import replace

import numpy as np
import pytest

from pysindy_evolve import DeclaredModel
from pysindy_evolve.loop.effects.candidate import OFFSET
from pysindy_evolve.loop.effects.missing import candidates, terms_in, with_parents
from pysindy_evolve.loop.effects.names import VOCABULARY
from pysindy_evolve.loop.given.design import in_state
from pysindy_evolve.loop.given.ranges import Ranges
from pysindy_evolve.terms import mul, sub, variable

ONE_MASS = {"q": "v", "v": "-k*q - c*v"}
TWO_MASSES = {"a": "va", "va": "-k*a", "b": "vb", "vb": "-m*b"}
STATIC = {
    "Coulomb friction",
    "asymmetric Coulomb friction",
    "Stribeck friction",
    "position-dependent friction",
    "viscous damping",
    "quadratic drag",
    "nonlinear damping",
    "linear stiffness",
    "quadratic stiffness",
    "cubic stiffness",
    "quintic stiffness",
    "dead zone",
    "saturation",
    "gravity",
    "second harmonic",
    "constant offset",
    "coupling",
    "input nonlinearity",
    "input gain",
    "drift",
}


def design_of(equations, inputs=("F",)):
    return DeclaredModel(equations, inputs=inputs).design()


def proposed(design, scale=3.0):
    n = len(design.states) + len(design.inputs) + 1
    return candidates(design, Ranges.about_zero(np.full(n, scale)))


def points(design, n=200):
    n_variables = len(design.states) + len(design.inputs) + 1
    return np.random.default_rng(0).uniform(-3.0, 3.0, (n, n_variables))


@pytest.mark.parametrize(("swing", "n_pairs"), [(0.3, 0), (0.6, 1)])
def test_weight_at_an_unknown_angle_is_proposed_where_it_is_no_mere_spring(swing, n_pairs):
    """At small angles a sine and a cosine together are a quadratic and a cubic spring."""
    weights = [c for c in proposed(design_of(ONE_MASS), swing) if c.name == "gravity"]
    assert sum(c.n_columns == 2 for c in weights) == n_pairs
    assert sum(c.n_columns == 1 for c in weights) == 2


def test_every_static_effect_is_proposed_for_a_mass_of_which_nothing_is_declared():
    names = {c.name for c in proposed(design_of({"q": "v", "v": "0"}))}
    assert names == STATIC
    assert names < set(VOCABULARY)


@pytest.mark.parametrize("equations", [ONE_MASS, TWO_MASSES, {"h": "-k*sqrt(h)"}])
def test_candidates_evaluate_to_columns_that_vary_or_are_the_offset(equations):
    design = design_of(equations)
    z = points(design)
    for candidate in proposed(design):
        for term in candidate.terms:
            declared = [parent.evaluate(z) for parent in candidate.parents]
            rows = z[np.isfinite(np.sum(declared, axis=0) + np.zeros(len(z)))]  # sqrt(h) is not
            values = term.evaluate(rows)
            assert values.shape == (len(rows),)
            assert np.all(np.isfinite(values))
            assert np.ptp(values) > 0.0 or term == OFFSET


@pytest.mark.parametrize("equations", [ONE_MASS, TWO_MASSES, {"h": "-k*sqrt(h)"}])
def test_no_candidate_is_proposed_twice_for_an_equation(equations):
    keys = [(c.state, c.terms) for c in proposed(design_of(equations))]
    assert len(keys) == len(set(keys))


def test_kinematic_equations_get_no_candidates():
    design = design_of(TWO_MASSES)
    assert {c.state for c in proposed(design)} == {1, 3}


def test_effects_with_a_mean_need_the_constant_first():
    design = design_of(ONE_MASS)
    z = points(design, n=4000)
    z = np.concatenate([z, -z])  # now every odd function of the variables has no mean
    for candidate in proposed(design):
        for values in (term.evaluate(z) for term in candidate.terms):
            if abs(values.mean()) > 0.05 * np.abs(values).mean() and candidate.terms != (OFFSET,):
                assert OFFSET in candidate.parents, candidate.name


def test_stribeck_friction_needs_coulomb_friction_first():
    design = design_of(ONE_MASS)
    own = [c for c in proposed(design) if c.variables == {1}]  # not beside an input
    (friction,) = (c for c in own if c.name == "Coulomb friction")
    stribeck = [c for c in own if c.name == "Stribeck friction"]
    assert stribeck
    assert all(c.parents == friction.terms for c in stribeck)


def test_stribeck_friction_of_a_slip_needs_the_coulomb_friction_of_that_slip():
    """A belt moves with a measured speed below a mass, as a brake does below its pad."""
    for friction, offered in (("f*sgn(v - w)", True), ("f*sgn(v)", False)):
        model = DeclaredModel({"q": "v", "v": f"-k*q - {friction}"}, inputs=["w"])
        design = model.design()
        able = with_parents(candidates(design, Ranges.about_zero(np.full(4, 3.0))), design)
        stribeck = [c.variables for c in able if c.name == "Stribeck friction"]
        assert (frozenset({1, 2}) in stribeck) is offered


def test_effects_that_stand_in_the_equation_are_not_proposed_again():
    design = design_of({"q": "v", "v": "-k*q - c*v - f*sgn(v) + o + b*F"})
    names = {c.name for c in proposed(design)}
    assert not names & {
        "linear stiffness",
        "viscous damping",
        "Coulomb friction",
        "constant offset",
    }
    # A gain that is declared leaves the products of the input and what else stands there.
    gains = [c.terms[0].name(("q", "v", "F", "t")) for c in proposed(design) if "gain" in c.name]
    assert sorted(gains) == ["F sgn(v)", "q F", "v F"]


def test_every_effect_that_is_added_is_not_proposed_again():
    design = design_of(ONE_MASS)
    for candidate in proposed(design):
        name, state = candidate.name, candidate.state
        again = proposed(design.adding(in_state(name, term, state, 2) for term in candidate.terms))
        assert (candidate.state, candidate.terms) not in {(c.state, c.terms) for c in again}


def test_an_effect_that_stands_in_one_equation_is_proposed_for_the_other():
    design = design_of({**TWO_MASSES, "va": "-k*a - f*sgn(va)"})
    assert {c.state for c in proposed(design) if c.name == "Coulomb friction"} >= {3}


def test_what_shares_a_parameter_does_not_stand_by_itself():
    present = terms_in(design_of({"q": "v", "v": "-k*(q + 2) + F + 9.81"}))
    assert (1, OFFSET) in present  # which the 9.81 is
    assert len([state for state, _ in present if state == 1]) == 4  # q + 2, F + 9.81, F, 1


def test_a_spring_to_the_ground_may_be_missing_beside_one_between_two_masses():
    design = design_of({"a": "va", "va": "-k*(a - b)", "b": "vb", "vb": "k*(a - b)"})
    found = {(c.name, c.state) for c in proposed(design)}
    assert {("linear stiffness", 1), ("linear stiffness", 3)} <= found


def test_what_a_term_is_worth_may_drift_and_a_constant_may():
    design = design_of({"q": "v", "v": "-k*q - c*v + b*F + o"})
    terms = [c.terms[0].name(("q", "v", "F", "t")) for c in proposed(design) if c.name == "drift"]
    assert sorted(terms) == ["F t", "q t", "t", "v t"]


def test_what_drifts_already_may_do_so_faster_and_faster():
    design = design_of({"q": "v", "v": "-k*q + b*F"})
    drifting = mul(variable(3), variable(2))
    found = proposed(design.adding([in_state("drift", drifting, 1, 2)]))
    parents = {c.terms[0].name(("q", "v", "F", "t")): c.parents for c in found if c.name == "drift"}
    assert parents["F t^2"] == (drifting,)
    assert not {"q t^2", "t^2"} & parents.keys()


def test_velocities_of_two_masses_may_rub_and_their_positions_couple():
    design = design_of(TWO_MASSES)
    names = (*design.states, *design.inputs, "t")
    found = {c.terms[0].name(names): c.name for c in proposed(design) if c.state == 1}
    assert found["b"] == found["vb"] == found["va vb"] == "coupling"
    assert found["-sgn(-va + vb)"] == "Coulomb friction"


def test_first_order_state_gets_no_springs():
    names = {c.name for c in proposed(design_of({"h": "-k*sqrt(h)"}))}
    assert not names & {"linear stiffness", "cubic stiffness", "gravity", "dead zone"}


def test_a_term_with_a_known_coefficient_is_proposed_again():
    names = {c.name for c in proposed(design_of({"q": "v", "v": "-33*q - c*v - 9.81"}))}
    assert {"linear stiffness", "constant offset"} <= names
    assert "viscous damping" not in names  # its coefficient is free


def test_the_sign_of_what_keeps_its_sign_is_no_friction_but_that_of_a_velocity():
    for equations, inputs, friction in (
        ({"h": "b*F"}, ("F",), False),
        ({"q": "v", "v": "b*F"}, ("F",), True),
    ):
        design = design_of(equations, inputs)
        n = len(design.states) + 2
        positive = {"signed": np.zeros(n, dtype=bool), "middle": np.full(n, 2.0)}
        found = candidates(design, replace(Ranges.about_zero(np.full(n, 3.0)), **positive))
        names = {candidate.name for candidate in found}
        assert ("Coulomb friction" in names) is friction
        # All readings lie between 1 and 3: a clip below 1 is a constant.
        clips = [c.shape.values[0] for c in found if c.name == "saturation"]
        assert clips
        assert min(clips) > 1.0


def test_a_known_constant_is_looked_at_again_unless_it_is_the_weight_of_what_only_falls():
    tank, weight = design_of({"T": "350 - T + b*F"}), design_of({"q": "v", "v": "b*F - 9.81"})
    falls = np.array([True, False, True, True])
    for design, signed, names in (
        (tank, np.ones(3, dtype=bool), {"constant offset"}),
        (weight, np.ones(4, dtype=bool), {"constant offset"}),
        (weight, falls, set()),
    ):
        reach = Ranges.about_zero(np.full(len(design.states) + 2, 3.0))
        offered = candidates(design, replace(reach, signed=signed))
        assert {c.name for c in offered if OFFSET in c.terms} == names


def test_a_difference_is_offered_where_its_own_part_has_no_coefficient_of_its_own():
    w, own = variable(1), variable(0)
    rest = {"w": "c*(w - y)", "y": "d*w - e*y"}
    tied = design_of({"x": "a*F - b*(x - y)", **rest})
    alone = design_of({"x": "a*F - b*x", **rest})
    for design, offered in ((tied, True), (alone, False)):
        found = [c.terms for c in proposed(design) if c.name == "coupling" and c.state == 0]
        assert ((sub(w, own),) in found) == offered
        assert (w,) in found


def test_what_stands_inside_a_sine_is_an_angle_and_acts_on_other_angles_by_their_difference():
    rotors = {"a": "w - b*sin(a - p)", "p": "u - b*sin(p - a)", "y": "r*a - s*y"}
    found = {
        (c.state, c.terms[0].name(("a", "p", "y", "t")))
        for c in proposed(DeclaredModel(rotors).design())
        if c.name == "coupling"
        and not c.never_paired
        and "sin" in c.terms[0].name(("a", "p", "y", "t"))
    }
    assert len(found) == 2 * 1  # the sine of twice the difference in both equations
    assert {state for state, _ in found} == {0, 1}
    springs = design_of({"a": "va", "va": "-k*a", "p": "vp", "vp": "-k*p + F"})
    assert not [c for c in proposed(springs) if c.name == "coupling" and _waves(c)]


def _waves(candidate):
    return "sin" in candidate.terms[0].name(("a", "va", "p", "vp", "F", "t"))


def test_a_difference_is_one_of_like_states():
    sides = {"q": "v", "v": "-k*(q - i) + b*F", "i": "-k*(i - q) + F"}
    found = [c for c in proposed(design_of(sides)) if c.name == "coupling" and not c.never_paired]
    differences = {(c.state, c.terms[0].variables) for c in found if len(c.terms[0].parts) == 2}
    assert not differences  # neither a position nor a velocity is a current


def _coupled(design, state, variables=("x", "y", "z", "F", "t")):
    found = (c for c in proposed(design) if c.name == "coupling" and c.state == state)
    return {c.terms[0].name(variables) for c in found}


def test_two_other_states_act_together_but_no_positions():
    gyro = design_of({"x": "-a*x", "y": "-b*y", "z": "-c*z + F"})
    assert "y z" in _coupled(gyro, 0)
    assert "x y" in _coupled(gyro, 2)
    masses = design_of({**TWO_MASSES, "c": "vc", "vc": "-n*c"})
    names = ("a", "va", "b", "vb", "c", "vc", "F", "t")
    assert "vb vc" in _coupled(masses, 1, names)
    assert not {"b c", "b vc"} & _coupled(masses, 1, names)


def test_an_arm_that_turns_pulls_at_what_carries_it():
    names = ("p", "v", "q", "w", "F", "t")
    cart = {"p": "v", "v": "(F - c*v)/(2 + sin(q)**2)", "q": "w", "w": "-k*sin(q)"}
    assert {"w^2 sin(q)", "w^2 sin(q)/(2 + sin(q)^2)"} <= _coupled(design_of(cart), 1, names)
    assert not [name for name in _coupled(design_of(cart), 3, names) if "w^2" in name]
    spring = {**cart, "v": "F - c*v", "w": "-k*q"}
    assert "w^2 sin(q)" not in _coupled(design_of(spring), 1, names)


@pytest.mark.parametrize(
    ("spring", "expected"), [("k*q", "q F^2"), ("k*sin(q)", "F^2 cos(q) sin(q)"), ("k*q - F", None)]
)
def test_an_input_may_be_a_rotation_that_drives_outward(spring, expected):
    names = ("q", "v", "F", "t")
    offered = proposed(design_of({"q": "v", "v": f"-{spring} - c*v"}))
    found = {c.terms[0].name(names) for c in offered if c.name == "input gain" and c.state == 1}
    assert [name for name in found if "F^2" in name] == [expected] * (expected is not None)


def test_an_input_saturates_within_the_declared_term_that_it_stands_in():
    """A valve with a dead zone was given one outside of its flow, beside an offset of nothing."""
    design = design_of({"p": "a*F*sqrt(60 - p) - l*p"})
    state, force = variable(0), variable(1)
    within = [c for c in proposed(design) if c.acts_at is not None and c.name == "saturation"]
    assert len(within) == 6
    z = np.array([[20.0, 9.0, 0.0], [20.0, -9.0, 0.0], [20.0, 1e-3, 0.0]])
    for candidate in within:
        (limit,) = candidate.shape.values
        expected = np.sqrt(40.0) * np.clip(z[:, 1], -limit, limit)
        assert candidate.terms[0].evaluate(z) == pytest.approx(expected)
        assert candidate.variables == state.variables | force.variables
