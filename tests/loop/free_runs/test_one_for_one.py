"""Effects hold their places, or lose them to others whose free runs are closer to the record."""

import numpy as np
import pytest
from loop_systems import measured, oscillator

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.effects.shaping import with_units
from pysindy_evolve.loop.evidence.findings import Finding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.free_runs.contenders import Pool, steady_drift
from pysindy_evolve.loop.free_runs.one_for_one import exchanged_by_runs
from pysindy_evolve.loop.free_runs.shape_tuning import Contender
from pysindy_evolve.loop.free_runs.variants import Model
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.rules import Rules
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.reading.text import parse
from pysindy_evolve.terms import call, constant, mul, variable

RULES = Rules(significance=0.05, n_twins=59, min_share=0.05, max_effects=8)
DRAG = oscillator("quadratic drag", "- 0.3*v*abs(v)")
ROOT = oscillator("root", "- 2*sqrt(abs(v))*sgn(v)")
V = variable(1)
ROOT_OF_SPEED = mul(call(BUILTIN["sgn"], V), call(BUILTIN["sqrt"], call(BUILTIN["abs"], V)))


def held(hidden, name, grown=(), small=(), **options):
    """Plant an effect as found, by its name if it has one, and hold it against the others."""
    record = hidden.record(**options)
    design = design_of(hidden.model, [record])
    part = segments([record], design.velocities)
    offered = candidates(design, part.ranges)
    planted = name if isinstance(name, Candidate) else next(c for c in offered if c.name == name)
    finding = Finding(planted, columns_of(planted, design), 1.0, 0.016, np.zeros(60), step=1)
    pool = Pool(grown, small, part, -np.log1p(-RULES.min_share))
    (kept,) = exchanged_by_runs(Model(design), [finding], pool, [record], RULES)
    assert kept.columns == columns_of(kept.candidate, design)
    assert (kept.p_value, kept.step) == (finding.p_value, finding.step)
    return kept.candidate


@pytest.mark.parametrize("planted", ["quadratic drag", "nonlinear damping", "Coulomb friction"])
def test_the_cause_keeps_its_place_or_takes_it(planted):
    assert held(DRAG, planted).name == "quadratic drag"


def test_a_grown_term_takes_the_place_of_a_name_of_similar_shape():
    root = Candidate("evolved term", 1, (ROOT_OF_SPEED,))
    assert held(ROOT, "Coulomb friction", [root]) == root
    friction = oscillator("Coulomb friction", "- 2*sgn(v)")
    assert held(friction, "Coulomb friction", [root]).name == "Coulomb friction"


def test_a_name_takes_the_place_of_a_grown_term_that_is_no_closer_to_the_record():
    valve = oscillator("dead zone", "- 0.5*(abs(F + 4) - abs(F - 4))")
    soft = call(BUILTIN["tanh"], mul(constant(0.3), variable(2)))
    winner = held(valve, Candidate("evolved term", 1, (soft,)), noise=5e-3)
    assert winner.name == "saturation"
    assert winner.shape.values == pytest.approx([4.0], rel=0.1)


def test_a_dead_zone_between_two_places_of_the_grid_is_tuned_before_it_meets_a_grown_term():
    slack = oscillator("dead zone", "- 30*(q - (abs(q + 0.07) - abs(q - 0.07))/2)", size=10.0)
    step = call(BUILTIN["tanh"], mul(constant(20.0), variable(0)))
    winner = held(slack, Candidate("evolved term", 1, (step,)), noise=1e-3)
    assert winner.name == "dead zone"
    assert winner.shape.values == pytest.approx([0.07], rel=0.03)


def test_a_grown_term_without_one_of_its_factors_is_what_the_vocabulary_calls_it():
    speed = call(BUILTIN["abs"], V)
    grown = Candidate("evolved term", 1, (mul(mul(V, speed), call(BUILTIN["log"], speed)),))
    record = DRAG.record()
    model = Model(design_of(DRAG.model, [record]))
    pool = Pool((), (), segments([record], (1,)), 0.05)
    drift = steady_drift(model, [grown], [record])
    tuned = pool.contenders(model, Contender(grown, drift.trial), drift)
    shorter = [one.candidate.name for one in tuned if one.candidate.terms == (mul(V, speed),)]
    assert shorter == ["quadratic drag"]


def test_what_the_noise_does_not_tell_apart_stays_as_it_was():
    record = {"noise": 0.05, "size": 0.5}
    for planted in ("quadratic drag", "nonlinear damping"):
        assert held(DRAG, planted, **record).name == planted


def test_numbers_inside_an_effect_are_tuned_by_the_runs():
    slack = oscillator("dead zone", "- 8*(q - (abs(q + 0.25) - abs(q - 0.25))/2)")
    winner = held(slack, "dead zone", noise=2e-3)
    assert winner.name == "dead zone"
    assert winner.shape.values == pytest.approx([0.25], rel=0.03)


def test_a_function_of_a_plain_variable_is_given_its_scale():
    spring = oscillator(
        "a spring that stiffens", "- 4*exp(0.6*q)", "-k*q - c*v + b*F + o", size=60.0
    )
    plain = Candidate("evolved term", 1, (call(BUILTIN["exp"], variable(0)),))
    winner = held(spring, "cubic stiffness", [plain], noise=1e-4)
    assert winner.terms[0].constants == pytest.approx([0.6], rel=0.03)


def test_a_small_term_that_runs_ask_for_takes_the_place_of_one_that_a_filter_makes_look_alike():
    spring = oscillator("a spring that stiffens", "- 15*q*abs(q)", "-k*q - c*v + b*F + o")
    q = variable(0)
    stiffening = Candidate("evolved term", 1, (mul(q, call(BUILTIN["abs"], q)),))
    small = [stiffening, Candidate("evolved term", 1, (call(BUILTIN["cos"], q),))]
    options = {"noise": 2e-3}
    assert held(spring, "dead zone", (), small, **options) == stiffening
    friction = oscillator("Coulomb friction", "- 2*sgn(v)")
    root = Candidate("evolved term", 1, (ROOT_OF_SPEED,))
    assert held(friction, "Coulomb friction", (), [root], **options).name == "Coulomb friction"


def test_of_what_does_clearly_better_that_wins_which_does_best():
    slack = oscillator("dead zone", "- 8*(q - (abs(q + 0.25) - abs(q - 0.25))/2)")
    sign = Candidate("evolved term", 1, (call(BUILTIN["sgn"], variable(0)),))
    winner = held(slack, sign, noise=2e-3)
    assert winner.name == "dead zone"
    assert winner.shape.values == pytest.approx([0.25], rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_a_gain_that_was_declared_too_large_does_not_saturate(seed):
    truth = {"q": "v", "v": "F - 0.8*v"}
    records = [measured(truth, size=2.0, seed=seed + 10 * k, duration=30.0) for k in range(3)]
    sides = {"q": "v", "v": "b*F - c*v"}
    declared = pse.DeclaredModel(sides, inputs=["F"], known={"b": 1.02})
    report = pse.close_loop(declared, records[:2], records[2:], operators=(), random_state=0)
    assert [effect.name for effect in report.effects] == ["input gain"]


@pytest.mark.slow
def test_no_rival_whose_runs_diverge_takes_the_place_of_a_grown_term():
    rates = {"x": "1 - 4.03*x + 3.1*x**2*y", "y": "3.03*x - 3.1*x**2*y"}
    starts = ((0.7, 1.4), (2.1, 1.3), (1.2, 0.5))
    records = [measured(rates, order=1, x0=x0, duration=12.0, noise=5e-3, seed=k)
               for k, x0 in enumerate(starts)]  # fmt: skip
    declared = pse.DeclaredModel({"x": "a - b*x + c*x**2*y", "y": "d*x"}, inputs=["F"])
    report = pse.close_loop(declared, records[:2], records[2:], operators=("mul",), random_state=0)
    assert [(e.state, str(e.term)) for e in report.effects] == [("y", "x**2*y")]


@pytest.mark.parametrize(
    ("written", "rounded"),
    [
        ("sin(0.98*q)", "sin(q)"),
        ("cos(1.02*q)*tanh(3*v)", "cos(q)*tanh(3*v)"),
        ("sin(0.0177*q)", f"sin({np.pi / 180.0!r}*q)"),
    ],
)
def test_numbers_close_to_a_unit_of_angles_are_made_that_unit(written, rounded):
    before, after = (
        Candidate("evolved term", 1, (parse(text, ("q", "v")).known,))
        for text in (written, rounded)
    )
    assert with_units(before) == after
    assert with_units(after) in (after, None)


def test_numbers_far_from_a_unit_stay():
    assert with_units(Candidate("evolved term", 1, (parse("tanh(3*v)", ("q", "v")).known,))) is None


@pytest.mark.slow
def test_a_sine_of_an_angle_stays_one_where_no_other_number_in_it_does_clearly_better():
    truth = {"q": "v", "v": "-39.2*sin(q) - 0.5*v"}
    records = [measured(truth, order=2, x0=(q0, 0.0), duration=20.0, seed=k, noise=2e-3)
               for k, q0 in enumerate((1.2, 0.8, 1.0))]  # fmt: skip
    declared = pse.DeclaredModel(
        {"q": "v", "v": "-k*sin(q) - c*v"}, inputs=["F"], known={"k": 40.4}
    )
    report = pse.close_loop(declared, records[:2], records[2:], operators=(), random_state=0)
    assert [str(effect.term) for effect in report.effects] == ["sin(q)"]
    assert "the record asks for\n-39.2" in str(report)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [2e-4, 2e-3])
def test_runs_refute_drag_in_free_decays_with_dry_friction(noise):
    rng, t, records = np.random.default_rng(0), np.arange(0.0, 8.0, 0.005), []
    sides = {"q": "v", "v": "-90*q - 0.4*v - 3*sgn(v)"}
    for amplitude in (1.0, 0.7, 0.5, 0.3, 0.2):
        x = pse.simulate(pse.DeclaredModel(sides).design().equations([]), [amplitude, 0.0], t)
        records.append(pse.prepare(t, x[:, 0] + noise * rng.standard_normal(len(t))))
    declared = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v"})
    report = pse.close_loop(declared, records[:4], records[4:], operators=(), random_state=0)
    (friction,) = report.effects
    assert friction.name == "Coulomb friction"
    assert not {"quadratic drag", "nonlinear damping"} & set(friction.alternatives)
