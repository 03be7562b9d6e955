"""close_loop: what is missing is found, named, added, and judged on data it was not fitted on."""

from dataclasses import replace

import numpy as np
import pysindy as ps
import pytest
from loop_systems import Hidden, equations_of, hidden_effects, measured, oscillator

import pysindy_evolve as pse
from pysindy_evolve.loop.growth.term_grower import TermGrower
from pysindy_evolve.loop.search import look_at_names as look

FRICTION = oscillator("Coulomb friction", "- 2*sgn(v)")
NOTHING = oscillator("nothing", "")


@pytest.mark.slow
def test_a_model_whose_numbers_are_all_known_may_lack_an_effect():
    record = FRICTION.record(duration=10.0)
    model = pse.DeclaredModel({"q": "v", "v": "-40*q - 0.8*v + F"}, inputs=["F"])
    report = pse.close_loop(model, record, operators=(), n_twins=59, random_state=0)
    assert [effect.name for effect in report.effects] == ["Coulomb friction"]


def names(report):
    return [effect.name for effect in report.effects]


def close_by_name(model, train, **options):
    """Close the loop with the named effects alone, which takes a second."""
    return pse.close_loop(model, train, **{"operators": (), "random_state": 0, **options})


@pytest.fixture(scope="module")
def friction_report():
    return close_by_name(FRICTION.model, friction_record())


@pytest.fixture(scope="module")
def again():
    """Copies of what was given to a second run, what was left of it, and its report."""
    record, model = friction_record(), FRICTION.model
    before, text = [a.copy() for a in arrays(record)], repr(model)
    return before, text, record, model, close_by_name(model, record)


def friction_record():
    return FRICTION.record(duration=20.0)


def arrays(record):
    return record.t, record.x, record.x_dot, record.u


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 2])
def test_friction_is_named_although_terms_may_grow(seed):
    report = pse.close_loop(FRICTION.model, FRICTION.record(seed=seed), random_state=seed)
    assert names(report) == ["Coulomb friction"]


@pytest.mark.slow
def test_effect_that_no_name_fits_is_grown():
    hidden = oscillator("evolved term", "- 15*q*sin(3*v)")
    report = pse.close_loop(hidden.model, hidden.record(size=5.0), random_state=0)
    assert "evolved term" in names(report)
    assert report.after.derivative_error[1] < 0.5 * report.before.derivative_error[1]


@pytest.mark.slow
@pytest.mark.parametrize("hidden", hidden_effects(), ids=lambda hidden: hidden.effect)
def test_hidden_effect_is_found_and_betters_what_was_held_out(hidden):
    report = close_by_name(hidden.model, hidden.record(noise=5e-3, duration=20.0))
    assert report.verdict == "traced"
    assert names(report)[0] == hidden.effect
    assert report.effects[0].state == hidden.state
    place = report.equations.states.index(hidden.state)
    assert report.after.derivative_error[place] < 0.9 * report.before.derivative_error[place]
    assert np.sum(report.after.simulation_error) < np.sum(report.before.simulation_error)


def test_friction_is_found_with_its_size_and_both_errors_fall(friction_report):
    report = friction_report
    assert report.verdict == "traced"
    assert names(report) == ["Coulomb friction"]
    (effect,) = report.effects
    assert effect.state == "v"
    assert str(effect.term) == "sign(v)"
    assert effect.coefficients == pytest.approx([-2.0], rel=0.03)
    assert effect.p_value == pytest.approx(1 / 61)
    assert effect.explained > 0.9
    assert effect.score > effect.twin_scores.max()
    assert report.after.derivative_error[1] < 0.5 * report.before.derivative_error[1]
    assert np.all(report.after.simulation_error < 0.2 * report.before.simulation_error)
    assert report.finished


@pytest.mark.slow
def test_frequency_of_a_forcing_is_found_within_a_percent():
    hidden = oscillator("periodic forcing", "+ 2*sin(21.3*t + 0.4)")
    report = close_by_name(hidden.model, hidden.record())
    (effect,) = report.effects
    assert effect.name == "periodic forcing"
    assert effect.expressions[0].constants[0] == pytest.approx(21.3, rel=0.01)
    assert np.hypot(*effect.coefficients) == pytest.approx(2.0, rel=0.1)


@pytest.mark.slow
def test_two_effects_are_found_one_after_the_other_or_together():
    hidden = oscillator("friction and offset", "- 2*sgn(v) + 1.5")
    report = close_by_name(hidden.model, hidden.record(duration=20.0))
    assert sorted(names(report)) == ["Coulomb friction", "constant offset"]
    assert [step.name for step in report.steps] == names(report)
    assert report.steps[-1].errors is report.after


@pytest.mark.slow
def test_nothing_is_found_where_nothing_is_missing():
    records = [
        NOTHING.record(noise=noise, seed=seed, duration=20.0)
        for noise in (1e-3, 5e-3)
        for seed in range(6)
    ]
    verdicts = [
        pse.close_loop(NOTHING.model, record, random_state=seed).verdict
        for seed, record in enumerate(records)
    ]
    # At a significance of 5 % three or more of 12 would come once in fifty.
    assert verdicts.count("complete") >= 10, verdicts


def test_complete_model_has_no_effects_and_no_steps():
    report = close_by_name(NOTHING.model, NOTHING.record())
    assert report.verdict == "complete"
    assert report.effects == []
    assert report.steps == []
    assert report.before.derivative_error == pytest.approx(report.after.derivative_error)


@pytest.mark.slow
def test_same_seed_gives_the_same_report(friction_report, again):
    *_, second = again
    assert str(second) == str(friction_report)
    assert np.array_equal(second.effects[0].twin_scores, friction_report.effects[0].twin_scores)


@pytest.mark.slow
def test_generator_may_be_the_seed(friction_report):
    rng = np.random.default_rng(0)
    report = close_by_name(FRICTION.model, friction_record(), random_state=rng)
    assert str(report) == str(friction_report)


def test_random_streams_of_the_caller_are_left_alone():
    np.random.seed(3)  # noqa: NPY002
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    close_by_name(NOTHING.model, NOTHING.record(duration=10.0))
    assert np.array_equal(np.random.get_state()[1], before)  # noqa: NPY002


@pytest.mark.slow
def test_number_of_processes_does_not_change_the_result(friction_report):
    parallel = close_by_name(FRICTION.model, friction_record(), n_jobs=2)
    assert str(parallel) == str(friction_report)
    assert np.array_equal(parallel.effects[0].twin_scores, friction_report.effects[0].twin_scores)


@pytest.mark.slow
def test_arguments_are_left_as_they_were(again):
    before, text, record, model, _ = again
    assert all(np.array_equal(a, b) for a, b in zip(before, arrays(record), strict=True))
    assert repr(model) == text


def test_last_thirty_percent_are_held_out_of_a_single_record(friction_report):
    record = friction_record()
    (train,), (test,) = friction_report.train, friction_report.test
    assert len(train) + len(test) == len(record)
    assert len(test) == pytest.approx(0.3 * len(record), abs=1)
    assert test.t[0] > train.t[-1]
    assert [r.shape for r in friction_report.residual_before] == [test.x.shape]


@pytest.mark.slow
def test_last_of_several_records_is_held_out():
    records = [FRICTION.record(duration=d, seed=s) for s, d in enumerate((20.0, 12.0, 15.0))]
    prepared = [pse.prepare(r.preparation.t, r.preparation.y, r.preparation.u) for r in records]
    report = close_by_name(FRICTION.model, prepared)
    assert len(report.train) == 2
    assert len(report.test) == 1
    assert report.test[0].t[-1] == pytest.approx(prepared[-1].t[-1], abs=0.1)
    assert names(report) == ["Coulomb friction"]


@pytest.mark.slow
def test_given_test_records_decide_nothing():
    train = FRICTION.record(duration=20.0)
    tests = [FRICTION.record(duration=10.0, seed=seed) for seed in (5, 6)]
    one = close_by_name(FRICTION.model, train, test=tests[0])
    two = close_by_name(FRICTION.model, train, test=tests)
    assert names(one) == names(two) == ["Coulomb friction"]
    assert np.array_equal(one.effects[0].coefficients, two.effects[0].coefficients)
    assert not np.array_equal(one.after.simulation_error, two.after.simulation_error)
    assert len(two.residual_after) == 2


@pytest.mark.slow
def test_record_of_the_user_with_its_own_derivatives():
    made = friction_record()
    bare = pse.Record(t=made.t, x=made.x, x_dot=made.x_dot, u=made.u)
    assert names(close_by_name(FRICTION.model, bare)) == ["Coulomb friction"]


@pytest.mark.slow
def test_order_of_the_inputs_only_orders_the_columns():
    made = friction_record().preparation
    idle = np.cos(0.9 * made.t)
    first = pse.prepare(made.t, made.y, np.column_stack([made.u, idle]))
    last = pse.prepare(made.t, made.y, np.column_stack([idle, made.u]))
    sides = {"q": "v", "v": "-k*q - c*v + b*F + g*z"}
    one = close_by_name(pse.DeclaredModel(sides, inputs=["F", "z"]), first)
    two = close_by_name(pse.DeclaredModel(sides, inputs=["z", "F"]), last)
    assert names(one) == names(two) == ["Coulomb friction"]
    assert one.effects[0].coefficients == pytest.approx(two.effects[0].coefficients, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("fitted", [True, False])
def test_sindy_model_may_be_declared(fitted):
    record = replace(friction_record(), states=("q", "v"), inputs=("F",))
    library = ps.PolynomialLibrary(degree=1, include_bias=False)
    model = ps.SINDy(feature_library=library, optimizer=ps.STLSQ(threshold=0.05))
    if fitted:
        model.fit(
            record.x, t=record.t, x_dot=record.x_dot, u=record.u, feature_names=["q", "v", "F"]
        )
    report = close_by_name(model, record)
    assert names(report) == ["Coulomb friction"]
    assert report.effects[0].state == "v"
    assert report.effects[0].coefficients == pytest.approx([-2.0], rel=0.05)


@pytest.mark.slow
def test_max_effects_ends_the_search_and_is_told():
    hidden = oscillator("friction and offset", "- 2*sgn(v) + 1.5")
    report = close_by_name(hidden.model, hidden.record(duration=20.0), max_effects=1)
    assert len(report.effects) <= 2  # a pair may come at once
    assert "The search stopped early: it reached max_effects." in str(report)


def test_interrupt_keeps_what_was_found(monkeypatch):
    hidden = oscillator("friction and offset", "- 2*sgn(v) + 1.5")
    find, calls = look.find_with_memories, []

    def interrupted(*args, **options):
        if calls:
            raise KeyboardInterrupt
        calls.append(1)
        return find(*args, **options)

    monkeypatch.setattr(look, "find_with_memories", interrupted)
    with pytest.warns(UserWarning, match="close_loop was interrupted"):
        report = close_by_name(hidden.model, hidden.record(duration=20.0))
    assert not report.finished
    assert report.effects
    assert report.verdict == "traced"
    assert "The search stopped early: it was interrupted." in str(report)


def test_pendulum_without_its_gravity_is_given_it():
    hidden = Hidden(
        "gravity",
        {"q": "v", "v": "-30*sin(q) - 0.3*v"},
        {"q": "v", "v": "-c*v"},
    )
    t = np.arange(0.0, 30.0, 0.01)
    machine = pse.DeclaredModel(hidden.truth).design().equations([])
    q = pse.simulate(machine, [2.8, 0.0], t)[:, 0]
    q = q + 1e-3 * np.random.default_rng(0).standard_normal(len(t))
    report = close_by_name(pse.DeclaredModel(hidden.declared), pse.prepare(t, q))
    assert names(report) == ["gravity"]
    assert report.effects[0].coefficients == pytest.approx([-30.0], rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spring", "weight", "size", "expected"),
    [
        ("-30*q", "-20*cos(q)", 12.0, [-20.0]),  # not split into an offset and a spring
        ("", "-30*cos(q - 0.4)", 60.0, [-30.0 * np.sin(0.4), -30.0 * np.cos(0.4)]),
    ],
)
def test_weight_of_an_arm_is_one_effect_wherever_its_angle_is_measured_from(
    spring, weight, size, expected
):
    truth = {"q": "w", "w": f"{spring} - 1.7*w + F {weight}"}
    declared = {"q": "w", "w": "-k*q - c*w + b*F" if spring else "-c*w + b*F"}
    record = measured(truth, size=size)
    report = close_by_name(pse.DeclaredModel(declared, inputs=["F"]), record)
    assert names(report) == ["gravity"]
    assert report.effects[0].coefficients == pytest.approx(expected, rel=0.01)
    if not spring:  # nor can the record mistake it for anything else
        assert report.effects[0].alternatives == ()


@pytest.mark.slow
def test_interrupt_after_a_name_keeps_it(monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(TermGrower, "better", interrupted)
    with pytest.warns(UserWarning, match="close_loop was interrupted"):
        report = close_by_name(FRICTION.model, friction_record())
    assert names(report) == ["Coulomb friction"]
    assert not report.finished


@pytest.mark.slow
def test_interrupt_while_terms_grow_keeps_the_names(monkeypatch):
    """Growing alone could go on with what it has; the loop ends and says so."""

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("pysindy_evolve.evolution.solve_elastic_net", interrupted)
    with pytest.warns(UserWarning, match="close_loop was interrupted"):
        report = pse.close_loop(FRICTION.model, FRICTION.record(), random_state=0)
    assert names(report) == ["Coulomb friction"]
    assert not report.finished
    assert "The search stopped early" in str(report)


def test_what_was_not_looked_for_is_not_said_to_be_absent():
    said = str(close_by_name(FRICTION.model, friction_record(), max_effects=0))
    assert "No effect was looked for, as max_effects is 0." in " ".join(said.split())
    assert "No other effect" not in said


@pytest.mark.slow
def test_first_order_system_lacks_its_drain():
    truth = pse.DeclaredModel({"h": "0.5*p - 0.3*h - 0.2"}, inputs=["p"]).design().equations([])
    t = np.arange(0.0, 200.0, 0.1)

    def pump(t):
        return 1.5 + np.sin(0.31 * t) + 0.5 * np.sin(0.83 * t + 1.0)

    h = pse.simulate(truth, [2.0], t, pump)
    h = h + 2e-3 * np.random.default_rng(0).standard_normal(h.shape)
    record = pse.prepare(t, h, pump(t), order=1)
    report = close_by_name(
        pse.DeclaredModel({"h": "a*p - b*h"}, inputs=["p"]), record, random_state=0
    )
    assert names(report) == ["constant offset"]
    assert report.effects[0].coefficients == pytest.approx([-0.2], rel=0.1)


@pytest.mark.slow
def test_two_masses_with_friction_between_them():
    truth = {
        "a": "va",
        "va": "-40*a - va + F - 2*sgn(va - vb)",
        "b": "vb",
        "vb": "-90*b - vb",
    }
    declared = {"a": "va", "va": "-k*a - c*va + F", "b": "vb", "vb": "-m*b - d*vb"}
    model = pse.DeclaredModel({**declared, "vb": "-m*b - d*vb + g*F"}, inputs=["F"])
    truth["vb"] += " + 0.5*F"
    report = close_by_name(model, measured(truth, duration=20.0))
    assert names(report)[0] == "Coulomb friction"
    assert report.effects[0].state == "va"
    assert set(map(str, report.effects[0].term.free_symbols)) == {"va", "vb"}


@pytest.mark.slow
def test_two_names_are_not_swallowed_by_one_long_term():
    t = np.arange(0.0, 400.0, 0.05)
    pull = 1.5 + 1.2 * np.sin(0.1 * t) + 0.8 * np.sin(0.27 * t + 1.0)
    car = equations_of({"v": "F - 0.02*v - 0.004*v*abs(v) - 0.3"}, ("F",))
    v = pse.simulate(car, [10.0], t, pull)[:, 0]
    v = v + 0.005 * v.std() * np.random.default_rng(0).standard_normal(len(t))
    declared = pse.DeclaredModel({"v": "b*F - c*v"}, inputs=["F"])
    report = pse.close_loop(declared, pse.prepare(t, v, pull, order=1), random_state=0)
    assert sorted(names(report)) == ["constant offset", "quadratic drag"]
    found = {e.name: e.coefficients[0] for e in report.effects}
    assert found["constant offset"] == pytest.approx(-0.3, rel=0.05)
    assert found["quadratic drag"] == pytest.approx(-0.004, rel=0.05)


@pytest.mark.slow
def test_a_square_of_another_speed_needs_no_offset():
    truth = {
        "q": "v", "v": "-10*q - 0.5*v + F + 0.4*w^2",
        "p": "w", "w": "-6*p - 0.4*w + 1.5*F - 0.5*v*w",
    }  # fmt: skip
    sides = {"q": "v", "v": "-k*q - c*v + b*F", "p": "w", "w": "-n*p - d*w + e*F"}
    report = close_by_name(pse.DeclaredModel(sides, inputs=["F"]), measured(truth, noise=5e-3))
    assert names(report) == ["coupling", "coupling"]
    assert [e.coefficients[0] for e in report.effects] == pytest.approx([0.4, -0.5], rel=0.02)


@pytest.mark.slow
def test_a_reaction_that_saturates_is_grown_with_its_constant():
    truth = {
        "N": "0.8*N - 0.08*N^2 - 1.2*N*P/(2 + N)",
        "P": "-0.4*P + 0.6*N*P/(2 + N)",
    }  # fmt: skip
    t = np.arange(0.0, 200.0, 0.1)
    x = pse.simulate(equations_of(truth), [4.0, 1.5], t)
    x = x + 0.002 * x.std(axis=0) * np.random.default_rng(0).standard_normal(x.shape)
    declared = pse.DeclaredModel({"N": "r*N - a*N^2 - b*N*P", "P": "-m*P + e*N*P"})
    report = pse.close_loop(declared, pse.prepare(t, x, order=1), random_state=0)
    assert np.all(report.after.simulation_error < 1.0)
    assert np.all(report.before.simulation_error > 10.0)
    assert len(report.effects) <= 3


@pytest.mark.slow
def test_a_spring_that_softens_as_it_warms_up_is_found():
    softening = oscillator("drift", "+ 0.25*q*t")
    report = pse.close_loop(softening.model, softening.record(), operators=(), random_state=0)
    (effect,) = report.effects
    assert (effect.name, str(effect.term)) == ("drift", "q*t")
    assert effect.coefficients == pytest.approx([0.25], rel=0.03)


@pytest.mark.slow
def test_a_term_without_a_value_on_held_out_data_costs_no_report():
    t = np.arange(0.0, 400.0, 0.5)
    truth = equations_of({"h": "0.5*u - 0.3*sqrt(abs(h))"}, ("u",))

    def drained(low, seed):
        rng = np.random.default_rng(seed)
        u = np.repeat(rng.uniform(low, low + 0.4, 20), 40)
        h = pse.simulate(truth, [1.0], t, u)
        return pse.prepare(t, h + 2e-3 * rng.standard_normal(h.shape), u, order=1)

    train, test = drained(0.6, 1), drained(-0.01, 2)
    assert test.x.min() < 0.0
    model = pse.DeclaredModel({"h": "a*u - b*h"}, inputs=["u"])
    report = pse.close_loop(model, train, test=test, random_state=0)
    assert str(report.effects[0].term) == "sqrt(h)"
    assert report.after.undefined > 0.0
    assert "of the held-out rows the model has no value" in " ".join(str(report).split())
    assert np.isfinite(report.after.derivative_error).all()
