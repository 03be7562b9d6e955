"""A hidden state that follows a measured one: the operator, its state, and how it is found."""

from dataclasses import replace

import numpy as np
import pytest
import sympy
from loop_systems import multisine
from scipy.integrate import solve_ivp
from scipy.signal import savgol_filter

import pysindy_evolve as pse
from pysindy_evolve.equations import Equations
from pysindy_evolve.export import format_equations
from pysindy_evolve.hidden_states.boucwen import yielding
from pysindy_evolve.hidden_states.memory_equations import with_memories
from pysindy_evolve.hidden_states.path_states import path_sentences
from pysindy_evolve.hidden_states.relaxing import RELAXING, relaxing, relaxing_along
from pysindy_evolve.loop.effects.candidate import OFFSET, CandidateMaker, rewritten
from pysindy_evolve.loop.effects.followers import followers_for
from pysindy_evolve.loop.effects.relaxation import relaxed_ways
from pysindy_evolve.loop.evidence.offers import offer_for
from pysindy_evolve.loop.evidence.scoring import score
from pysindy_evolve.loop.fitting.past import first_state, rates_on
from pysindy_evolve.loop.fitting.shooting import gains_of_runs
from pysindy_evolve.loop.fitting.unfolding import (
    records_with_hidden_states,
    square_left,
    with_hidden_states,
)
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.memories.effect_or_memory import beats_tuned_memories
from pysindy_evolve.loop.memories.probes import grid_of
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.substitution import substituted
from pysindy_evolve.terms import call, mul, variable

DECLARED = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
STIFFNESS, TIME = 15.0, 0.4
TRUE = pse.DeclaredModel(
    {"q": "v", "v": f"-k*q - c*v + b*F - s*relaxing(q, t, {TIME})"},
    inputs=["F"],
    operators=[RELAXING],
)
NUMBERS = np.array([20.0, 0.3, 1.0, STIFFNESS])
DT = 0.01
T = np.arange(0.0, 20.0, DT)


def swing(t):
    """Position and velocity."""
    return np.sin(t) + 0.6 * np.sin(2.3 * t + 1.0), np.cos(t) + 1.38 * np.cos(2.3 * t + 1.0)


def simulated(stiffness=STIFFNESS, time=TIME, seed=3, n=4000):
    """Times, force, and position, velocity and hidden position of a mass on a rubber mount."""
    t, force = np.arange(n) * DT, multisine(8.0, seed, band=(0.1, 2.0))
    pushed = force(t)

    def rate(now, x):
        q, v, h = x
        own = -20.0 * q - stiffness * (q - h) - 0.3 * v
        return [v, own + np.interp(now, t, pushed), (q - h) / time]

    options = {"t_eval": t, "max_step": DT, "rtol": 1e-7, "atol": 1e-9}
    return t, pushed, solve_ivp(rate, (0.0, t[-1]), [0.0, 0.0, 0.0], **options).y.T


def measured(noise=0.005, seed=3, **options):
    """Measure the position with noise, a share of its standard deviation."""
    t, force, x = simulated(seed=seed, **options)
    q = x[:, 0] + noise * x[:, 0].std() * np.random.default_rng(seed).standard_normal(len(t))
    return pse.prepare(t, q, force)


def numbers_in(report):
    (path,) = report.equations.paths
    return float(path.args[2].evaluate(np.empty((1, 0)))[0])


@pytest.fixture(scope="module")
def exact():
    """Record and hidden state without noise or filter, begun in the middle of the motion."""
    t, force, x = simulated(n=3000)
    own = -20.0 * x[:, 0] - STIFFNESS * (x[:, 0] - x[:, 2]) - 0.3 * x[:, 1] + force
    whole = pse.Record(t=t, x=x[:, :2], x_dot=np.column_stack([x[:, 1], own]), u=force)
    return whole[500:], x[500:, 2]


@pytest.mark.parametrize("time", [0.02, 0.4, 30.0])
def test_operator_solves_the_differential_equation(time):
    def rate(t, h):
        return (swing(t)[0] - h) / time

    start = swing(0.0)[0]
    exact = solve_ivp(rate, (0.0, T[-1]), [start], t_eval=T, rtol=1e-9, atol=1e-10)
    x = swing(T)[0]
    assert relaxing_along(x, T, time) == pytest.approx(x - exact.y[0], abs=1e-4)


def test_operator_is_exact_on_a_straight_path_whatever_the_samples():
    t = np.array([0.0, 0.1, 0.2, 0.7, 0.8, 2.0])
    expected = 3.0 * 0.5 * -np.expm1(-t / 0.5)
    assert relaxing_along(3.0 * t + 4.0, t, 0.5) == pytest.approx(expected)


def test_operator_goes_on_from_where_it_was():
    x = np.random.default_rng(0).standard_normal(200)
    t = 0.1 * np.arange(200.0)
    whole = relaxing_along(x, t, 0.7)
    assert relaxing_along(x[80:], t[80:], 0.7, whole[80]) == pytest.approx(whole[80:])
    assert relaxing_along(x[:1], t[:1], 0.7, 0.2) == pytest.approx([0.2])


def test_record_after_another_one_begins_in_balance():
    x = swing(T)[0]
    twice = relaxing_along(np.tile(x, 2), np.tile(T, 2), 0.4)
    assert twice == pytest.approx(np.tile(relaxing_along(x, T, 0.4), 2))


def test_gap_between_rows_is_bridged_by_a_straight_path():
    x, kept = swing(T)[0], np.r_[0:800, 815:2000]
    gapped = relaxing_along(x[kept], T[kept], 0.4)
    assert gapped == pytest.approx(relaxing_along(x, T, 0.4)[kept], abs=0.01)


def relaxed(sides):
    """Equations of q and v with a relaxation of q that takes 0.4."""
    path = relaxing(variable(0), variable(2), 0.4)
    terms = tuple(sum_.parts[0][1] for sum_ in (path, variable(1), variable(0)))
    return Equations(terms, np.array(sides, dtype=float), ("q", "v"))


def test_relaxation_is_written_as_a_state_with_an_equation_of_its_own():
    full = with_memories(relaxed([[0, 1, 0], [-30, -0.5, -20]]), ())
    assert full.states == ("q", "v", "q_relax")
    q, h = (sympy.Symbol(name, real=True) for name in ("q", "q_relax"))
    _, force, rate = full.to_sympy()
    assert force.coeff(h) == 30
    assert force.coeff(q) == -50
    assert sympy.simplify(rate - (q - h) / 0.4) == 0
    assert format_equations(full).splitlines()[2].startswith("q_relax' = ")


def test_what_is_remembered_is_said_in_words():
    path, friction = (
        relaxing(variable(0), variable(2), 0.4),
        yielding(variable(0), variable(1), 0.05, 2.0),
    )
    assert path_sentences([path, path], ("q", "v", "t")) == ["q_relax: relaxation time 0.4"]
    (said,) = path_sentences([mul(variable(1), friction)], ("q", "v", "t"))
    assert said == "q_yield: builds up over a length of 0.05, unloads 2 times as fast"
    assert path_sentences([variable(0)], ("q", "v", "t")) == []


def test_relaxation_of_a_first_order_state_has_the_same_form():
    path = relaxing(variable(0), variable(1), 50.0)
    terms = (path.parts[0][1], variable(0).parts[0][1])
    full = with_memories(Equations(terms, np.array([[-0.1, -0.02]]), ("T",)), ())
    t = np.arange(0.0, 200.0, 0.5)
    run = pse.simulate(full, [1.0], t, tolerance=1e-9)
    exact = solve_ivp(
        lambda _, x: [-0.1 * (x[0] - x[1]) - 0.02 * x[0], (x[0] - x[1]) / 50.0],
        (0.0, t[-1]), [1.0, 1.0], t_eval=t, rtol=1e-9, atol=1e-11,
    )  # fmt: skip
    assert run == pytest.approx(exact.y.T, abs=1e-5)


def test_simulated_hidden_state_agrees_with_the_operator():
    full = with_memories(relaxed([[0, 1, 0], [-30, -0.5, -20]]), ())
    run = pse.simulate(full, [1.0, 0.0], T, tolerance=1e-9)
    assert run[0, 2] == 1.0  # in balance
    ahead = relaxing_along(run[:, 0], T, 0.4)
    assert run[:, 0] - run[:, 2] == pytest.approx(ahead, abs=1e-3)
    assert full.along(run[:, :2], None, T)[:, 0] == pytest.approx(run[:, 2], abs=1e-3)


def test_design_with_hidden_states_has_their_rates(exact):
    record, _ = exact
    design = design_of(TRUE, [record])
    full = with_memories(design.equations(NUMBERS), ())
    (own,) = records_with_hidden_states(design, [record])
    expected = full.evaluate(own.x, own.u, own.t)
    plain = with_hidden_states(design).equations(NUMBERS)
    assert plain.evaluate(own.x, own.u, own.t) == pytest.approx(expected)
    free = with_hidden_states(design, free=True).equations([*NUMBERS, 1.0 / TIME])
    assert free.evaluate(own.x, own.u, own.t) == pytest.approx(expected)


def test_first_rows_say_where_the_hidden_state_began(exact):
    record, h = exact
    design = design_of(TRUE, [record])
    equations = design.equations(NUMBERS)
    start = first_state(with_memories(equations, ()), record)
    assert start == pytest.approx([*record.x[0], h[0]], abs=0.005)
    (own,) = records_with_hidden_states(design, [record], NUMBERS)
    assert own.x[:, 2] == pytest.approx(h, abs=0.005)
    assert rates_on(equations, record) == pytest.approx(record.x_dot, abs=0.1)


def test_what_is_right_leaves_little_though_the_record_begins_in_the_middle(exact):
    record, _ = exact
    design = design_of(TRUE, [record])
    wrong = NUMBERS * [1.0, 1.0, 1.0, 0.9]
    assert square_left(design, [record], NUMBERS) < 1e-3 * square_left(design, [record], wrong)


def test_first_rows_of_each_record_carry_no_weight_until_what_remembers_is_settled(exact):
    record, _ = exact
    records = [record[:1200], record[1200:]]
    whole = segments(records, (1,), 8)
    late = whole.after([400, 400])
    first = [k for k, (_, row) in enumerate(whole.places) if row == 0]
    assert len(first) == 2
    assert np.all(late.weight[first, :200] == 0.0)
    again = late.of([replace(r, x_dot=2.0 * r.x_dot) for r in records])
    assert np.array_equal(again.weight, late.weight)
    assert np.array_equal(late.after([400, 400]).weight, late.weight)


def test_relaxations_are_not_sought_over_gaps():
    record = measured(n=3000)
    design = design_of(DECLARED, [record])
    whole, few = (segments([record], (1,), max_rows=rows) for rows in (None, 500))
    assert not whole.has_gaps
    assert offer_for(design, whole).relaxes
    assert few.has_gaps
    assert not offer_for(design, few).relaxes


def test_hidden_state_of_what_stands_still_begins_in_balance(exact):
    record, _ = exact
    still = replace(record, x=0.0 * record.x + [0.3, 0.0], x_dot=0.0 * record.x_dot)
    equations = with_memories(design_of(TRUE, [record]).equations(NUMBERS), ())
    assert first_state(equations, still) == pytest.approx([0.3, 0.0, 0.3])


def test_hidden_state_begins_where_it_should_in_any_unit(exact):
    record, h = exact
    small = replace(record, x=1e-6 * record.x, x_dot=1e-6 * record.x_dot, u=1e-6 * record.u)
    equations = with_memories(design_of(TRUE, [small]).equations(NUMBERS), ())
    assert first_state(equations, small)[2] == pytest.approx(1e-6 * h[0], abs=5e-9)


def test_rates_of_a_model_without_inputs_need_no_hidden_states():
    full = with_memories(relaxed([[0, 1, 0], [-30, -0.5, -20]]), ())
    run = pse.simulate(full, [1.0, 0.0], T, tolerance=1e-9)
    along = full.evaluate(run[:, :2], None, T)
    assert along == pytest.approx(full.evaluate(run, None, T)[:, :2], abs=0.02)


@pytest.mark.slow
def test_model_without_free_parameters_may_lack_a_hidden_state():
    numbers = pse.DeclaredModel({"q": "v", "v": "-20*q - 0.3*v + F"}, inputs=["F"])
    report = pse.close_loop(numbers, measured(), operators=(), random_state=0, n_twins=59)
    (effect,) = report.effects
    assert str(effect.term) == "q - q_relax"
    assert -effect.coefficients[0] == pytest.approx(STIFFNESS, rel=0.03)


def test_relaxation_times_begin_where_the_filter_ends_and_are_tuned_no_further():
    record = measured(n=2000)
    ways = relaxed_ways(1, 0, record)
    shortest = 0.5 / record.preparation.cutoff
    times = [way.shape.values[0] for way in ways]
    assert times[0] == pytest.approx(shortest)
    assert times[-1] <= 0.25 * len(record) * record.dt
    (build,) = ways[0].shape.builds
    assert build(0.1 * shortest) == build(shortest)


def test_candidate_with_other_variables_is_tuned_with_them():
    way = rewritten(
        relaxed_ways(1, 0, measured(n=2000))[2], lambda term: substituted(term, {3: variable(7)})
    )
    assert way.terms[0].variables == {0, 7}
    assert way.shape.terms == way.terms


def test_relaxation_is_scored_in_no_pair():
    record = measured(n=2000)
    design = design_of(DECLARED, [record])
    offset = CandidateMaker(1)("constant offset", OFFSET)
    drag = CandidateMaker(1)("quadratic drag", mul(variable(1), call(BUILTIN["abs"], variable(1))))
    proposed = [offset, drag, *relaxed_ways(1, 0, record)]
    groups = [s.group for s in score(design, segments([record], (1,)), proposed)]
    assert (offset, drag) in groups
    assert all(len(group) == 1 for group in groups if group[0].never_paired)


def test_what_is_remembered_must_lead_late_inputs():
    record, other = measured(n=3000), measured(n=3000, stiffness=0.0)
    design = design_of(DECLARED, [record])
    for one, leads in ((record, True), (replace(other, u=np.roll(other.u, 9, axis=0)), False)):
        part = segments([one], (1,))
        ways, memories = followers_for(design, [one]), grid_of(design, part)
        assert beats_tuned_memories(ways, design, part, memories) is leads


def test_what_is_remembered_must_oppose_what_it_follows():
    record = measured(n=3000)
    ahead = relaxing_along(record.x[:, 0], record.t, TIME)
    drives = record.x_dot + np.outer(2.0 * STIFFNESS * ahead, [0.0, 1.0])
    design = design_of(DECLARED, [record])
    for one, relaxes in ((record, True), (replace(record, x_dot=drives), False)):
        assert offer_for(design, segments([one], (1,))).relaxes is relaxes


def test_free_runs_need_what_is_there_and_not_what_is_not():
    record = measured(n=3000)
    plain, full = (design_of(declared, [record]) for declared in (DECLARED, TRUE))
    assert min(gains_of_runs(plain, full, [record])) > 1.0
    other = measured(n=3000, stiffness=0.0)
    assert gains_of_runs(plain, full, [other])[0] < 0.1


@pytest.mark.slow
def test_hidden_state_of_an_oscillator_is_found_with_its_numbers():
    report = pse.close_loop(DECLARED, measured(), operators=(), random_state=0, n_twins=59)
    (effect,) = report.effects
    assert effect.name == "hidden state"
    assert str(effect.term) == "q - q_relax"
    assert -effect.coefficients[0] == pytest.approx(STIFFNESS, rel=0.03)
    assert numbers_in(report) == pytest.approx(TIME, rel=0.03)
    assert report.after.simulation_error[0] < 0.5
    assert report.model.feature_names == ["q", "v", "q_relax", "F"]
    assert report.simulate(report.test[0]).shape == (len(report.test[0]), 3)
    assert "q_relax' = " in str(report)
    assert "q_relax" in pse.to_code(report.model, language="c")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stiffness", "time", "noise"),
    [(5.0, 0.1, 0.001), (30.0, 0.1, 0.005), (5.0, 1.5, 0.005)],
)
def test_free_runs_with_a_hidden_state_come_near_the_noise(stiffness, time, noise):
    record = measured(noise, stiffness=stiffness, time=time)
    report = pse.close_loop(DECLARED, record, operators=(), random_state=0)
    assert [effect.name for effect in report.effects] == ["hidden state"]
    assert -report.effects[0].coefficients[0] == pytest.approx(stiffness, rel=0.1)
    assert numbers_in(report) == pytest.approx(time, rel=0.1)
    assert report.after.simulation_error[0] < 100.0 * noise


def heated(lag=None, seed=3):
    """Measure a temperature: of a body that warms another, or whose heater lags behind."""
    t = np.arange(3000.0)
    power = np.repeat((np.random.default_rng(seed).random(60) > 0.5) * 1.0, 50)

    def rate(now, x):
        given, lost = np.interp(now, t, power), 0.01 * (x[0] - 20.0)
        if lag:
            return [0.8 * x[1] - lost, (given - x[1]) / lag]
        return [0.8 * given - lost - 0.03 * (x[0] - x[1]), (x[0] - x[1]) / 120.0]

    start = [20.0, 0.0 if lag else 20.0]
    warm = solve_ivp(rate, (0.0, t[-1]), start, t_eval=t, max_step=1.0, rtol=1e-6).y[0]
    noise = 0.002 * warm.std() * np.random.default_rng(seed).standard_normal(len(t))
    return pse.prepare(t, warm + noise, power, order=1)


@pytest.mark.slow
def test_heat_capacity_that_nobody_measured_is_found():
    declared = pse.DeclaredModel({"T": "a - b*T + c*u"}, inputs=["u"])
    report = pse.close_loop(declared, heated(), operators=(), random_state=0)
    (effect,) = report.effects
    assert (effect.name, str(effect.term)) == ("hidden state", "T - T_relax")
    assert -effect.coefficients[0] == pytest.approx(0.03, rel=0.05)
    assert numbers_in(report) == pytest.approx(120.0, rel=0.05)
    assert report.after.simulation_error[0] < 1.0


@pytest.mark.slow
def test_heater_that_lags_is_not_named_a_hidden_heat_capacity():
    declared = pse.DeclaredModel({"T": "a - b*T + c*u"}, inputs=["u"])
    report = pse.close_loop(declared, heated(lag=40.0), operators=(), random_state=0)
    assert [effect.name for effect in report.effects] == ["actuator lag"]


def battery(polarization, seed=3, unsettled=0.0):
    """Measure the voltage of a cell with a resistance, and a resistance beside a capacitor.

    Before the record the current was constant but for what is unsettled.
    """
    t, rng = np.arange(4000.0), np.random.default_rng(seed)
    current = np.repeat(rng.uniform(-1.0, 2.0, 200), 20)
    lagging = current - relaxing_along(current, t, 35.0, unsettled)
    voltage = 3.7 - 0.05 * current - polarization * lagging
    voltage += 0.0005 * rng.standard_normal(len(t))
    return pse.Record(t=t, x=voltage, x_dot=voltage, u=current)


@pytest.mark.parametrize("polarization", [0.03, 0.0])
def test_polarization_of_a_battery_is_a_hidden_state_that_follows_the_current(polarization):
    declared = pse.DeclaredModel({"V": "E - R*i"}, inputs=["i"], algebraic=True)
    report = pse.close_loop(
        declared, battery(polarization), operators=(), random_state=0, n_twins=59
    )
    if not polarization:
        assert report.verdict == "complete"
        return
    (effect,) = report.effects
    assert (effect.name, str(effect.term)) == ("hidden state", "i - i_relax")
    assert effect.coefficients[0] == pytest.approx(polarization, rel=0.02)
    assert numbers_in(report) == pytest.approx(35.0, rel=0.02)
    ((low, high),) = effect.number_intervals
    assert low < 35.0 < high < 1.1 * low
    assert report.after.simulation_error[0] < 3.0
    unsettled = battery(polarization, seed=4, unsettled=2.0)
    assert report.simulate(unsettled)[:, 0] == pytest.approx(unsettled.x[:, 0], abs=0.003)
    assert "i_relax' = " in str(report)
    assert f"relaxation time {numbers_in(report):.4g} (95 %: " in str(report)


@pytest.mark.slow
def test_free_swing_of_one_frequency_leaves_stiffness_and_time_uncertain():
    """A spring, a damper and a relaxation at one frequency are two numbers."""

    def rate(_, x):
        return [x[1], -20.0 * x[0] - 12.0 * (x[0] - x[2]) - 0.1 * x[1], (x[0] - x[2]) / 0.3]

    t, records = np.arange(0.0, 12.0, DT), []
    for k in range(3):
        start = [1.0 + 0.3 * k, 0.0, 1.0 + 0.3 * k]
        q = solve_ivp(rate, (0.0, t[-1]), start, t_eval=t, max_step=DT, rtol=1e-7).y[0]
        noise = 0.003 * q.std() * np.random.default_rng(k).standard_normal(len(t))
        records.append(pse.prepare(t, q + noise))
    declared = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v"})
    report = pse.close_loop(declared, records, operators=(), random_state=0)
    (effect,) = report.effects
    assert str(effect.term) == "q - q_relax"
    low, high = effect.confidence_intervals[0]
    assert high - low > 0.3 * abs(effect.coefficients[0])
    assert report.after.simulation_error[0] < 5.0  # though it began beyond what the record shows


@pytest.mark.slow
@pytest.mark.parametrize("width", [31, 61])
def test_derivative_that_was_smoothed_too_much_is_not_named(width):
    record = measured(stiffness=0.0, noise=0.0)
    made = record.preparation
    noise = 0.005 * np.random.default_rng(0).standard_normal(len(made.t))
    q = made.y[:, 0] + made.y[:, 0].std() * noise
    v, a = (savgol_filter(q, width, 3, deriv=k, delta=DT) for k in (1, 2))
    x, x_dot = np.column_stack([q, v]), np.column_stack([v, a])
    record = pse.Record(t=made.t, x=x, x_dot=x_dot, u=made.u)
    with pytest.warns(UserWarning, match="smoothed too much"):
        report = pse.close_loop(DECLARED, record, random_state=0)
    assert report.effects == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["input delay", "actuator lag"])
def test_late_input_is_not_named_a_hidden_state(name):
    t, force = np.arange(4000) * DT, multisine(8.0, 3, band=(0.1, 2.0))

    def rate(now, x):
        acts = force(np.array([now - 0.3]))[0] if name == "input delay" else x[2]
        return [x[1], -20.0 * x[0] - 0.3 * x[1] + acts, (force(np.array([now]))[0] - x[2]) / 0.3]

    q = solve_ivp(rate, (0.0, t[-1]), [0.0] * 3, t_eval=t, max_step=DT, rtol=1e-6).y[0]
    q = q + 0.005 * q.std() * np.random.default_rng(0).standard_normal(len(t))
    record = pse.prepare(t, q, force(t))
    report = pse.close_loop(DECLARED, record, operators=(), random_state=0)
    assert [effect.name for effect in report.effects] == [name]
