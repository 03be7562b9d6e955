"""Short records: the trajectory bears witness, with the noise that the likelihood finds in it."""

import numpy as np
import pytest
from loop_systems import equations_of, oscillator
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.evidence.drifting_rivals import twin_chance
from pysindy_evolve.loop.evidence.spectrum_or_trajectory import pieces_to_score
from pysindy_evolve.loop.fitting.random_force import NOISES, drift_size, whitening
from pysindy_evolve.loop.fitting.trajectory import MAX_ROWS, Trajectories, followable
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.design import in_state
from pysindy_evolve.loop.given.ranges import Ranges
from pysindy_evolve.loop.given.rows import variables_of
from pysindy_evolve.loop.twins.drifting import DriftingTwins
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import call, mul, variable

FALL = pse.DeclaredModel({"h": "v", "v": "-9.81"})
WHIFFLE, GOLF = 0.042, 0.0
SPEED = variable(1)
DRAG = in_state("drag", mul(SPEED, call(BUILTIN["abs"], SPEED)), 1, 2)


def drop(drag, seed=0, noise=0.03, rate=15.0, height=34.0):
    """A ball that falls, filmed: times and heights."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 8.0, 1.0 / rate)
    start = [48.0, 0.5 * rng.standard_normal()]
    fall = solve_ivp(
        lambda _, x: [x[1], -9.81 - drag * x[1] * abs(x[1])],
        (0.0, 8.0),
        start,
        t_eval=t,
        rtol=1e-9,
        atol=1e-9,
    ).y[0]
    n = int(np.argmax(fall < start[0] - height))
    return t[:n], fall[:n] + noise * rng.standard_normal(n)


def filmed(drag, seed=0, **options):
    return pse.prepare(*drop(drag, seed, **options))


@pytest.fixture(scope="module")
def design():
    return design_of(FALL, [filmed(WHIFFLE)])


@pytest.mark.parametrize("order", [1, 2])
def test_weights_make_each_noise_white_and_ignore_the_start(order):
    n = 30
    made = whitening(n, order)
    starts = np.vander(np.arange(n) / n, order)
    for noise, weights in zip(NOISES, made.grams(np.eye(n)), strict=True):
        apart = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
        alike = np.exp(-apart / (noise.memory * n)) if noise.memory else np.eye(n)
        integral = np.linalg.matrix_power(np.tril(np.ones((n, n))), order)
        drift = integral @ alike @ integral.T / drift_size(n, order, noise.memory) ** 2
        covariance = np.eye(n) + noise.ratio * drift
        assert np.allclose(weights @ starts, 0.0, atol=1e-8)
        assert np.trace(weights @ covariance) == pytest.approx(n - order, rel=1e-6)
        assert np.allclose(weights @ covariance @ weights, weights, atol=1e-6)


def test_the_noise_of_the_sensor_is_found_where_nothing_pushes(design):
    found = [
        Trajectories([filmed(GOLF, seed)], design, design.columns).disturbances()[0].sensor
        for seed in range(8)
    ]
    assert np.mean(found) == pytest.approx(0.03, rel=0.1)


def test_the_force_that_pushes_a_twin_is_found_in_it(design):
    record = filmed(GOLF, rate=60.0)
    pushed = DriftingTwins.of(design, [record])
    strength = 3.0
    (only,) = pushed.disturbed
    object.__setattr__(only, "force", strength)
    found = [
        Trajectories(pushed.make(np.random.default_rng(seed)), design, ()).disturbances()[0]
        for seed in range(8)
    ]
    lasting = [
        one.force * np.sqrt(1.0 if not one.memory else 2.0 * one.memory * 60.0) for one in found
    ]
    assert np.median(lasting) == pytest.approx(strength, rel=0.4)
    assert np.mean([one.sensor for one in found]) == pytest.approx(only.sensor, rel=0.2)


@pytest.mark.parametrize("noise", [1e-4, 0.03])
def test_a_coefficient_comes_from_the_readings(design, noise):
    record = filmed(WHIFFLE, noise=noise)
    coef, intervals = Trajectories([record], design, [DRAG]).fit()
    assert coef[0] == pytest.approx(-WHIFFLE, rel=0.05)
    assert intervals[0, 0] < coef[0] < intervals[0, 1]


def test_intervals_hold_the_coefficient_as_often_as_they_say(design):
    held = 0
    for seed in range(60):
        low, high = Trajectories([filmed(WHIFFLE, seed)], design, [DRAG]).fit()[1][0]
        held += low <= -WHIFFLE <= high
    assert held >= 51


def test_rows_of_a_fast_sensor_are_averaged(design):
    record = filmed(WHIFFLE, rate=480.0)
    track = Trajectories([record], design, [DRAG])
    assert len(track.courses[0].rows[0]) <= MAX_ROWS
    assert track.fit()[0][0] == pytest.approx(-WHIFFLE, rel=0.05)


def test_a_model_with_its_own_noise_is_likelier_than_one_that_lacks_the_drag(design):
    for drag, better in ((WHIFFLE, True), (GOLF, False)):
        track = Trajectories([filmed(drag)], design, [DRAG])
        without, with_it = track.errors(np.empty((1, 0), int)), track.errors(np.array([[0]]))
        assert (np.log(without / with_it)[0, 0] > 0.3) == better


def test_few_numbers_are_left_to_the_trajectory_and_many_to_the_spectrum(design):
    assert pieces_to_score(design, [filmed(WHIFFLE)]).by_trajectory
    many = oscillator("quadratic drag", "- 0.5*v*abs(v)")
    record = many.record(noise=0.01)
    assert not pieces_to_score(design_of(many.model, [record]), [record]).by_trajectory


def test_a_trajectory_needs_raw_readings_of_each_equation(design):
    record = filmed(WHIFFLE)
    assert followable(design, [record])
    assert not followable(design, [pse.Record(t=record.t, x=record.x, x_dot=record.x_dot)])
    both = design_of(pse.DeclaredModel({"h": "v + a", "v": "-9.81"}), [record])
    assert not followable(both, [record])


def test_twins_lie_as_far_from_the_model_as_the_record(design):
    left = []
    for seed in range(12):
        record = filmed(GOLF, seed)
        (twin,) = DriftingTwins.of(design, [record]).make(np.random.default_rng(seed))
        assert twin.x.shape == record.x.shape
        left.append([np.std(one.x_dot[:, 1] + 9.81) for one in (record, twin)])
    own, of_twins = np.mean(left, axis=0)
    assert of_twins == pytest.approx(own, rel=0.35)


def test_a_model_that_cannot_run_has_no_twin_but_the_record():
    record = filmed(GOLF)
    bursting = design_of(pse.DeclaredModel({"h": "v", "v": "-9.81*v**4"}), [record])
    (twin,) = DriftingTwins.of(bursting, [record]).make(np.random.default_rng(0))
    assert twin is record


def test_the_cause_stays_among_the_alternatives_and_a_wrong_one_does_not(design):
    record = filmed(WHIFFLE, seed=1)
    offered = [c for c in candidates(design, Ranges.of(variables_of(record))) if not c.parents]
    chances = {
        c.name: twin_chance(c, design, offered, [record], 0.05, np.random.default_rng(0))
        for c in offered
        if c.name in ("quadratic drag", "linear stiffness")
    }
    assert chances["quadratic drag"] > 0.05 >= chances["linear stiffness"]


@pytest.mark.slow
def test_drag_is_named_on_a_film_of_a_light_ball():
    record, second = filmed(WHIFFLE, seed=2), filmed(WHIFFLE, seed=3)
    options = {"operators": (), "n_twins": 99, "random_state": 0}
    report = pse.close_loop(FALL, record, test=second, **options)
    assert [effect.name for effect in report.effects] == ["quadratic drag"]
    assert report.effects[0].coefficients[0] == pytest.approx(-WHIFFLE, rel=0.05)
    assert report.after.simulation_error[0] < 5.0
    for rival in report.effects[0].rivals:
        assert np.isfinite(rival.coefficients).all()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*samples of a test record")
def test_an_alternative_has_the_coefficient_that_it_would_take():
    record = filmed(WHIFFLE, seed=5, noise=0.25)
    report = pse.close_loop(FALL, record, record, operators=(), n_twins=99, random_state=0)
    (effect,) = report.effects
    (drag,) = [one for one in (effect, *effect.rivals) if one.name == "quadratic drag"]
    assert drag.coefficients[0] == pytest.approx(-WHIFFLE, rel=0.1)
    for rival in effect.rivals:
        assert rival.force == rival.coefficients[0] * rival.term
    (drift,) = [one for one in effect.rivals if one.name == "drift"]
    assert f"drift {drift.coefficients[0]:.4g} t (p = " in " ".join(str(report).split())


@pytest.mark.parametrize("seed", range(4))
def test_nothing_is_named_where_a_ball_falls_freely(seed):
    record, second = filmed(GOLF, seed), filmed(GOLF, seed + 100)
    report = pse.close_loop(FALL, record, test=second, random_state=seed)
    assert report.verdict == "complete"


@pytest.mark.slow
def test_an_effect_of_the_states_is_named_where_a_drift_would_do_as_well():
    """A light ball's film of three seconds: what is linear in the time fits it best."""
    record, second = (filmed(WHIFFLE, seed=s, noise=0.2) for s in (2, 1002))
    report = pse.close_loop(FALL, record, second, operators=(), n_twins=59, random_state=2)
    (effect,) = report.effects
    assert effect.name != "drift"
    assert "drift" in effect.alternatives
    assert report.after.simulation_error[0] < 0.5 * report.before.simulation_error[0]


def fan_cooled(seed):
    """A heated body that a fan cools, in a room that warms up and cools down: a short record."""
    rng, t = np.random.default_rng(seed), np.arange(0.0, 600.0, 0.5)

    def wandering(every, low, high):
        knots = np.arange(-2.0 * every, t[-1] + 3.0 * every, every)
        return CubicSpline(knots, rng.uniform(low, high, len(knots)))(t)

    u = np.column_stack([wandering(25.0, 0, 6), wandering(18.0, 0, 4), wandering(90.0, 18, 26)])
    truth = equations_of({"T": "0.9*P - (0.03 + 0.012*n)*(T - Ta)"}, ("P", "n", "Ta"))
    x = pse.simulate(truth, [40.0], t, u)
    y = x + 0.01 * x.std() * rng.standard_normal(x.shape)
    return pse.prepare(t, y, u, order=1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [751, 754])
def test_a_rival_whose_run_bursts_does_not_take_the_place_of_the_cause(seed):
    declared = pse.DeclaredModel({"T": "b*P - a*(T - Ta)"}, inputs=["P", "n", "Ta"])
    report = pse.close_loop(declared, fan_cooled(seed), operators=(), random_state=0)
    (effect,) = report.effects
    assert str(effect.term) in ("-T*n + Ta*n", "n*(-T + Ta)")
    assert effect.coefficients == pytest.approx([0.012], rel=0.03)
