"""LoopReport: what is printed, predicted, simulated and drawn is one model."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import sympy
from loop_systems import equations_of, measured, multisine, oscillator

import pysindy_evolve as pse
from pysindy_evolve.export import format_equations, format_number
from pysindy_evolve.hidden_states.boucwen import yielding
from pysindy_evolve.hidden_states.memory import Memory
from pysindy_evolve.hidden_states.memory_equations import with_memories
from pysindy_evolve.hidden_states.relaxing import relaxing
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.facts.effect import Step
from pysindy_evolve.loop.facts.start_noise import run_std_from_start_noise
from pysindy_evolve.loop.fitting.runs import LOST_NRMSE, simulation_errors
from pysindy_evolve.loop.given.design import in_state
from pysindy_evolve.loop.report.effect_text import evidence, with_sign
from pysindy_evolve.loop.report.number_text import interval, percent, value_within
from pysindy_evolve.loop.report.text import as_text, note_on_shared_terms, table_cells
from pysindy_evolve.loop.settling.quantities import with_share_of_runs
from pysindy_evolve.loop.settling.zero_in_interval import most_doubtful
from pysindy_evolve.terms import add, constant, mul, power, variable

FRICTION = oscillator("friction and offset", "- 2*sgn(v) + 1.5")


@pytest.fixture(scope="module")
def drifting():
    """The corrected model depends on time."""
    hidden = oscillator("drift", "+ 0.1*t + 1", "-k*q - c*v + b*F + o")
    return pse.close_loop(hidden.model, hidden.record(), operators=(), random_state=0)


@pytest.mark.parametrize(
    ("low", "high", "shown"),
    [
        (-2.0000012, -1.9999988, "-2.0000012 to -1.9999988"),
        (0.31, 0.42, "0.31 to 0.42"),
        (0.927, 0.9534, "0.9270 to 0.9534"),  # as many digits in both
        (2.0, 3.0, "2 to 3"),
        (9.0, 136.2, "9.000 to 136.2"),
        (-6.141, 0.0, "-6.141 to 0"),
        (20.0, 30.0, "20 to 30"),
        (1.5e-7, 3e-7, "1.5e-7 to 3e-7"),
    ],
)
def test_the_ends_of_an_interval_can_be_told_apart(low, high, shown):
    assert interval(low, high) == f"(95 %: {shown})"


@pytest.mark.parametrize("spared", [False, True])
def test_a_verdict_says_so_if_the_corrected_model_is_further_off_in_every_error(report, spared):
    """A hum whose phase differs by record was called traced, though all errors had doubled."""
    before, times = report.before, 1.0 if spared else 2.0
    doubled = replace(
        report.after,
        derivative_error=2.0 * before.derivative_error,
        simulation_error=times * before.simulation_error,
    )
    text = str(replace(report, after=doubled))
    assert ("in every error" in " ".join(text.split())) is not spared
    assert "On the held-out data some errors grew" in text
    hardly = replace(before, simulation_error=1.0001 * before.simulation_error)
    assert "in every error" not in str(replace(report, after=hardly))


def test_report_prints_verdict_equations_table_and_evidence_in_this_order(report):
    text = str(report)
    free = r"    Free parameters: k = \S+, c = \S+, b = \S+"
    ends = r"\s+\(\S+\s+to\s+\S+\)"
    known = r",\s+".join(rf"{name}\s+=\s+\S+{ends}" for name in "kcb")
    sure = rf"    Free parameters, with 95 % intervals: {known}"
    expected = (
        r"Verdict: traced: the model lacked the effects below, which have been added\.\n\n"
        rf"Declared model, fitted\n    q' = v\n    v' = .*\n{free}\n\n"
        rf"Corrected model\n    q' = v\n    v' = .*sgn\(v\).*\n{sure}\n\n"
        r"Errors on held-out data, % of the standard deviation \(NRMSE\)\n"
        r" +dv/dt +q free run +v free run\n"
        r"    declared( +[\d.e+]+){3}\n"
        r"(    \+ .*( +[\d.e+]+){3}\n)+"
        r"\n1\. .* in the equation of v\n"
        r"(   -?[\d.e+-]+(?: times .*)? +\(95 %: -?[\d.e+-]+ to -?[\d.e+-]+\)\n)+"
        r"   removes .* % of the held-out residual variance; p = 0\.016 \(60 twins\)"
    )
    assert re.match(expected, text), text
    assert max(map(len, text.splitlines())) <= 100
    for effect in report.effects:
        assert f"{effect.name} in the equation of {effect.state}" in text


def test_complete_report_says_so_and_shows_one_equation(complete):
    text = str(complete)
    assert text.startswith("Verdict: complete: nothing is missing that this data can show.")
    assert "Corrected model" not in text
    assert not re.search(r"^1\. ", text, flags=re.MULTILINE)
    assert "No other effect stands out: " in text


def test_free_parameters_have_the_values_of_the_equation_that_they_stand_below(report):
    v = sympy.Symbol("v", real=True)
    for errors in (report.before, report.after):
        assert list(errors.parameters) == ["k", "c", "b"]
        side = sympy.expand(errors.equations[1])
        assert -errors.parameters["c"] == pytest.approx(float(side.coeff(v)), rel=1e-9)
        assert f"c = {format_number(errors.parameters['c'])}" in str(report)
    assert f"c = {format_number(report.after.parameters['c'])}" in report.to_markdown()


@pytest.mark.parametrize("which", ["report", "complete"])
def test_intervals_of_declared_parameters_are_those_of_the_model_that_lacks_nothing(which, request):
    report = request.getfixturevalue(which)
    assert (report.before.parameter_intervals == {}) == (which == "report")
    for name, truth in {"k": 40.0, "c": 0.8, "b": 1.0}.items():
        low, high = report.after.parameter_intervals[name]
        assert low < report.after.parameters[name] < high
        assert (low + high) / 2 == pytest.approx(truth, abs=2 * (high - low))


def test_steps_of_one_name_are_told_apart_in_the_table(report):
    def rows(*places):
        steps = [Step(*place, replace(report.after)) for place in places]
        return [name for name, _ in table_cells(replace(report, steps=steps))[1][1:]]

    assert rows(("drag", "v"), ("drag", "v")) == ["+ drag", "+ a further drag"]
    assert rows(("drag", "v"), ("drag", "q")) == ["+ drag (v)", "+ drag (q)"]
    assert rows(("drag", "v"), ("offset", "v")) == ["+ drag", "+ offset"]
    together = [Step("drag", state, report.after) for state in ("v", "q")]
    cells = table_cells(replace(report, steps=together))
    assert [name for name, _ in cells[1][1:]] == ["+ drag (v, q)"]


def test_table_shows_the_errors_of_the_report(report):
    row = next(line for line in str(report).splitlines() if line.strip().startswith("declared "))
    shown = [float(value) for value in row.split()[1:]]
    errors = [report.before.derivative_error[1], *report.before.simulation_error]
    assert shown == pytest.approx(errors, rel=6e-3)


def test_titles_of_long_names_stand_apart(report):
    model = replace(report.before.model, states=("piston_position_mm", "piston_speed_mm_per_s"))
    renamed = replace(report, before=replace(report.before, model=model))
    lines = as_text(renamed).splitlines()
    (title,) = (line for line in lines if "free run" in line and "/dt" in line)
    assert len(re.split(r"  +", title.strip())) == 3


def test_large_errors_stand_apart(report):
    lost = replace(report.before, simulation_error=np.array([3e6, 4e6]))
    lines = as_text(replace(report, before=lost)).splitlines()
    assert any("  over 1000 times  over 1000 times" in line for line in lines)


def test_rows_of_effects_with_one_name_say_which_equation(report):
    step = report.steps[-1]
    twice = replace(report, steps=[replace(step, state="q"), replace(step, errors=report.before)])
    assert f"+ {step.name} (q)  " in str(twice)
    assert f"+ {step.name} (v)  " in str(twice)
    assert f"+ {step.name} (v)" not in str(report)


def test_the_p_of_an_effect_is_explained_once(report, complete):
    fewest = min(len(effect.twin_scores) for effect in report.effects)
    said = f"{1 / (1 + fewest):.2g} is the smallest that {fewest} twins can show."
    for text in (str(report), report.to_markdown()):
        assert " ".join(text.split()).count(said) == 1
    assert "p of an effect" not in str(complete)


@pytest.mark.parametrize("which", ["report", "drifting"])
def test_model_predicts_what_the_equations_evaluate(which, request):
    report = request.getfixturevalue(which)
    (test,) = report.test
    u = np.column_stack([test.u, test.t]) if report.equations.needs_time else test.u
    expected = report.equations.evaluate(test.x, test.u, test.t)
    assert report.model.predict(test.x, u=u) == pytest.approx(expected)


def test_a_model_with_an_effect_of_the_time_asks_for_the_time(drifting):
    (test,) = drifting.test
    with pytest.raises(ValueError, match=r"must have the time as its last column; .* u=np\.column"):
        drifting.model.predict(test.x, u=test.u)


@pytest.mark.parametrize("which", ["report", "drifting"])
def test_sympy_form_has_the_same_values(which, request):
    report = request.getfixturevalue(which)
    (test,) = report.test
    symbols = sympy.symbols(report.equations.names, real=True)
    sides = sympy.lambdify(symbols, pse.to_sympy(report.model), "numpy")
    values = sides(*test.x.T, *test.u.T, test.t)
    stacked = np.column_stack([np.broadcast_to(v, len(test)) for v in values])
    expected = report.equations.evaluate(test.x, test.u, test.t)
    assert stacked == pytest.approx(expected, rel=1e-6)
    assert report.after.equations == report.equations.to_sympy()


@pytest.mark.parametrize("which", ["report", "drifting"])
def test_free_run_of_the_report_is_a_simulation_of_its_model(which, request):
    report = request.getfixturevalue(which)
    (test,) = report.test
    run = report.simulate(test)
    assert run.shape == test.x.shape
    assert np.array_equal(run[0], test.x[0])
    direct = pse.simulate(report.model, test.x[0], test.t, test.u)
    assert run == pytest.approx(direct, abs=0.02 * np.abs(test.x).max())
    error = 100 * np.sqrt(np.mean((run - test.x) ** 2, axis=0)) / test.x.std(axis=0)
    assert report.after.simulation_error == pytest.approx(error, rel=0.05)


def test_time_is_an_input_of_a_model_that_needs_it(drifting):
    assert [effect.name for effect in drifting.effects] == ["drift"]
    assert drifting.model.feature_names == ["q", "v", "F", "t"]


def test_drift_may_be_a_state_too_slow_to_be_looked_for(drifting):
    assert "The drift of v may also be a state that nobody measured" in str(drifting)


def test_effects_are_the_terms_of_the_corrected_equation(report):
    q, v, force = sympy.symbols("q v F", real=True)
    added = sympy.expand(report.after.equations[1])
    terms = {sympy.sign(v): -2.0, sympy.Integer(1): 1.5}
    for effect in report.effects:
        assert effect.coefficients == pytest.approx([terms[effect.term]], rel=0.05)
        low, high = effect.confidence_intervals.T
        assert np.all((low <= effect.coefficients) & (effect.coefficients <= high))
        assert 0.0 < effect.p_value <= 0.05
        assert effect.name not in effect.alternatives
    assert added.free_symbols == {q, v, force}
    assert added.coeff(sympy.sign(v)) == pytest.approx(-2.0, rel=0.05)


def test_what_was_found_and_what_was_not_print_in_one_line(report, complete):
    for effect in report.effects:
        shown = repr(effect)
        assert shown.startswith(f"Effect({effect.name!r}, state='v', term=")
        assert f"{effect.coefficients[0]:.4g} ({effect.confidence_intervals[0, 0]:.4g} to" in shown
        assert len(shown) < 200
    shown = repr(complete.rejected)
    assert re.match(r"Rejected\(.+ in v: .+; share=.+, score=.+, p_value=.+, \d+ twins\)$", shown)
    assert "Call(" not in shown
    assert len(shown) < 300


def test_steps_lead_from_before_to_after(report):
    assert [step.name for step in report.steps][-1] == report.effects[-1].name
    assert report.steps[-1].errors is report.after
    errors = [report.before, *(step.errors for step in report.steps)]
    derivative = [e.derivative_error[1] for e in errors]
    assert derivative == sorted(derivative, reverse=True)


def test_residuals_are_the_measured_derivative_less_the_model(report):
    (test,) = report.test
    expected = test.x_dot - report.equations.evaluate(test.x, test.u, test.t)
    assert report.residual_after[0] == pytest.approx(expected)
    assert report.residual_before[0].std(axis=0)[1] > report.residual_after[0].std(axis=0)[1]


def test_kinematic_equation_is_not_rated(report):
    assert report.before.derivative_error[0] == pytest.approx(0.0, abs=1e-6)
    assert "dq/dt" not in str(report)


def test_model_of_nothing_at_all_predicts_zeros():
    t = 0.01 * np.arange(400)
    rng = np.random.default_rng(0)
    record = pse.Record(t=t, x=rng.normal(size=400), x_dot=rng.normal(size=400))
    report = pse.close_loop(pse.DeclaredModel({"q": "0"}), record, operators=())
    assert report.model.predict(np.ones((3, 1))).tolist() == [[0.0]] * 3
    assert "q' = 0" in str(report)


def test_a_notebook_shows_all_and_a_debugger_one_line(report):
    first = report.effects[0]
    assert repr(report).startswith(f"LoopReport('traced', {first.name} of {first.state}")
    assert "\n" not in repr(report)
    assert report._repr_markdown_() == report.to_markdown()


def test_markdown_holds_the_table_and_every_effect(report):
    page = report.to_markdown()
    assert page.startswith("**Verdict:** traced")
    assert page.count("|---") == 4
    for effect in report.effects:
        assert f"### {effect.name} in the equation of v" in page


@pytest.mark.slow
def test_each_term_of_an_effect_is_printed_with_its_own_coefficient():
    hidden = oscillator("periodic forcing", "+ 3*sin(7.3*t) + 0.5*cos(7.3*t)")
    record = hidden.record(duration=20.0)
    forced = pse.close_loop(hidden.model, record, operators=(), random_state=0)
    (effect,) = forced.effects
    assert effect.name == "periodic forcing"
    sine, cosine = effect.coefficients
    assert abs(sine) > abs(cosine)
    assert f"{sine:.4g} times sin(" in str(forced)
    assert f"{cosine:.4g} times cos(" in str(forced)


def test_a_coefficient_that_is_pumped_is_said_to_vary(report):
    q, t = sympy.symbols("q t", real=True)
    wave, said = sympy.sin(3.3 * t) + sympy.cos(3.3 * t), "varies periodically"
    pumped_q, forced, rippled = (
        str(replace(report, effects=[replace(report.effects[0], name=name, term=term)]))
        for name, term in (
            ("periodic forcing", sympy.expand(q * wave)),
            ("periodic forcing", wave),
            ("position-periodic ripple", sympy.sin(3.3 * q)),
        )
    )
    assert f"the coefficient of q {said}" in pumped_q
    assert said not in forced + rippled


def test_the_sign_of_a_term_goes_to_its_coefficient(report, tmp_path):
    (*_, effect) = report.effects
    turned = replace(
        effect,
        expressions=tuple(mul(constant(-1.0), one) for one in effect.expressions),
        coefficients=-effect.coefficients,
        confidence_intervals=-effect.confidence_intervals[:, ::-1],
    )
    said = [evidence(one, report.equations.inner_symbols) for one in (effect, turned)]
    assert said[0] == said[1]
    for one, name in ((effect, "plain"), (turned, "turned")):
        replace(report, effects=[one]).to_html(tmp_path / name)
    plain, other = ((tmp_path / name).read_text("utf-8") for name in ("plain", "turned"))
    assert plain == other


def test_a_force_that_adds_to_an_input_keeps_its_sign(report):
    """A moment of friction, which is negative, over what is negative."""
    (*_, effect) = report.effects
    turned = replace(
        effect,
        expressions=tuple(mul(constant(-1.0), one) for one in effect.expressions),
        entry="as if T were larger by this number",
    )
    term, value, _, _ = with_sign(turned, 0, report.equations.inner_symbols)
    assert value == effect.coefficients[0]
    assert str(term).startswith("-")


def test_residual_of_a_delayed_input_is_taken_at_the_earlier_time(report):
    t = 0.01 * np.arange(400)
    inner = equations_of({"q": "-q + 2*F"}, ("F",))
    x = np.cos(t)[:, None]
    x_dot = inner.evaluate(x, np.sin(3.0 * (t - 0.05))[:, None], t)
    record = pse.Record(t=t, x=x, x_dot=x_dot, u=np.sin(3.0 * t))
    delayed = with_memories(inner, [Memory("input delay", 0, (0.05,))])
    errors = replace(report.after, model=delayed)
    before, after = replace(errors, model=inner), errors
    held_out = replace(report, before=before, after=after, test=(record,), effects=[])
    assert np.abs(held_out.residual_before[0]).max() > 0.2
    assert held_out.residual_after[0][10:] == pytest.approx(0.0, abs=1e-5)


def test_twins_that_show_an_effect_as_good_agree_with_the_p_value(complete):
    best = complete.rejected
    tried = replace(best, p_value=0.035, twin_scores=np.zeros(199), level=0.05 / 3)
    said = " ".join(str(replace(complete, rejected=tried)).split())
    assert "6 of 199 twins, in which nothing is missing, show an effect as good (p = 0.035;" in said
    assert "several looks share the significance, and this one asks for 0.017)." in said
    assert "it would remove" not in said  # what chance would do


def test_an_effect_that_is_no_chance_but_too_small_is_said_to_be_that(complete):
    tried = replace(
        complete.rejected, p_value=0.005, twin_scores=np.zeros(199), share=0.01, level=0.05
    )
    said = " ".join(str(replace(complete, rejected=tried)).split())
    assert (
        "0 of 199 twins, in which nothing is missing, show an effect as good (p = 0.005)," in said
    )
    assert ", but it would remove 1 % of the error that could be explained, less than" in said


@pytest.mark.parametrize(("p_value", "is_named"), [(0.4, True), (0.6, False)])
def test_what_most_twins_show_as_well_is_no_strong_candidate(complete, p_value, is_named):
    tried = replace(complete.rejected, p_value=p_value, twin_scores=np.zeros(99))
    said = " ".join(str(replace(complete, rejected=tried)).split())
    assert ("The strongest candidate that did not pass is" in said) is is_named
    assert ("is matched in 59 of 99 twins" in said) is not is_named


@pytest.mark.parametrize(("share", "is_named"), [(9e-4, False), (2e-3, True)])
def test_a_trace_that_was_not_tested_has_no_name(complete, share, is_named):
    tried = replace(complete.rejected, p_value=np.nan, twin_scores=np.empty(0), share=share)
    said = " ".join(str(replace(complete, rejected=tried)).split())
    assert ("The strongest candidate" in said) is is_named
    assert ("No other effect would remove even 0.1 % of the error" in said) is not is_named


def test_a_free_run_that_misses_the_record_is_mentioned(complete, monkeypatch):
    # Its run does not err as said here: without the low-pass it would be called fast motion.
    monkeypatch.setattr("pysindy_evolve.loop.report.cautions.fast_motion", lambda _: [])
    missing = replace(complete.after, simulation_error=np.array([46.0, 55.0]))
    said = " ".join(str(replace(complete, after=missing)).split())
    assert "still misses the record by 55 %" in said
    assert "still misses" not in str(complete)


@pytest.mark.slow
def test_what_is_left_of_a_derivative_beside_the_noise_is_mentioned(complete):
    t, rng = np.arange(0.0, 20.0, 0.01), np.random.default_rng(3)
    force, push = multisine(20.0, 3)(t), np.interp(t, t[::20], rng.normal(0.0, 4.0, t[::20].size))
    model = equations_of({"q": "v", "v": "-40*q - 0.8*v + F"}, ("F",))
    q = pse.simulate(model, [0.0, 0.0], t, force + push)[:, 0]  # and nobody measured the push
    record = pse.prepare(t, q + 1e-3 * q.std() * rng.standard_normal(t.size), force)
    declared = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
    report = pse.close_loop(declared, record, operators=(), random_state=0)
    assert report.verdict == "complete"
    said = " ".join(str(report).split())
    left = r"the model leaves 7\S* % of dv/dt, where the noise of the sensors leaves \d.* if that"
    assert re.search(left, said)
    assert "the noise of the sensors leaves" not in str(complete)


def test_short_records_say_that_only_small_terms_were_tried(complete):
    missing = replace(complete.after, simulation_error=np.array([46.0, np.nan]))
    short = replace(complete.rules, by_trajectory=True)
    for rules, is_said in ((complete.rules, False), (short, True)):
        said = " ".join(str(replace(complete, after=missing, rules=rules)).split())
        assert "departs from the record by more than the record varies" in said
        assert ("too short to search for terms" in said) == is_said


@pytest.mark.slow
def test_held_out_data_beyond_the_training_data_is_mentioned_where_the_model_errs_there():
    truth = {"q": "v", "v": "-40*q - 2*v - 300*q**3 + F"}
    small, other, large = (measured(truth, size=s, seed=k) for k, s in enumerate((1.0, 1.0, 60.0)))
    declared = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
    reports = [
        pse.close_loop(declared, small, test, operators=(), random_state=0)
        for test in (other, large)
    ]
    near, far = (" ".join(str(one).split()) for one in reports)
    assert "leaves the range of the training data" not in near
    assert re.search(r"leaves the range of the training data \(q from -\S+ to \S+, trained on", far)
    assert re.search(
        r"misses it there: dv/dt by [2-9]\d %, against 0\.\d+ % in the training data", far
    )
    by_rests = replace(reports[1].after, derivative_error=np.array([0.0, 4.0]))
    assert "leaves the range of the training data" not in str(replace(reports[1], after=by_rests))


def test_an_effect_that_removes_nothing_by_itself_does_not_remove_less_than_nothing(report):
    idle = replace(report.effects[0], explained=-0.04)
    said = str(replace(report, effects=(idle, *report.effects[1:])))
    assert "by itself removes nothing of the held-out residual variance" in said


def test_an_effect_with_which_nothing_can_be_run_removes_nothing(report):
    (effect, *_), finding = report.effects, SimpleNamespace(candidate=SimpleNamespace(state=1))
    never = replace(report.before, simulation_error=np.full(2, np.inf))
    for before, after, removed in (
        (never, never, 0.0),
        (report.before, never, 0.0),
        (never, report.after, 1.0),
    ):
        shown = with_share_of_runs(effect, finding, before, after)
        assert shown.explained == pytest.approx(removed)
        assert "held-out" in str(replace(report, effects=[shown]))


def test_an_effect_whose_interval_holds_zero_is_the_most_doubtful(report):
    effects = [e for e in report.effects if len(e.coefficients) == 1]
    design, (column, *_) = report.design, report.design.columns
    findings = [SimpleNamespace(columns=(column,), candidate=_alone(k)) for k in range(2)]
    sure = replace(effects[0], confidence_intervals=np.array([[-2.1, -1.9]]))
    sure = replace(sure, coefficients=np.array([-2.0]))
    doubtful = replace(sure, confidence_intervals=np.array([[-4.1, 0.1]]))
    assert most_doubtful(findings, [sure, doubtful], design) is findings[1]
    assert most_doubtful(findings, [sure, sure], design) is None
    memory = SimpleNamespace(columns=(), candidate=_alone(1))
    assert most_doubtful([findings[0], memory], [sure, doubtful], design) is None


def test_only_a_corrected_model_is_said_to_leave_structure(report, complete):
    said = "The residual of the corrected model still depends on the measured variables"
    assert said not in str(report)
    left = str(replace(report, chance_left=0.001))
    assert said in left
    assert left.startswith("Verdict: traced in part")
    assert said not in str(replace(complete, chance_left=0.001))


def test_what_remembers_a_motion_is_not_doubted_for_the_width_of_its_interval(report):
    q, v, t = (variable(k) for k in (0, 1, 3))
    memory = in_state("hidden state", relaxing(q, t, 0.4), 1, 2)
    wide = {"coefficients": np.ones(1), "confidence_intervals": np.array([[-1.0, 3.0]])}
    for column, doubted in ((memory, False), (in_state("drag", power(v, 5), 1, 2), True)):
        design = report.design.adding([column])
        finding = SimpleNamespace(columns=(column,), candidate=_alone(1))
        found = most_doubtful([finding], [SimpleNamespace(**wide)], design)
        assert (found is finding) is doubted


def _alone(state):
    return Candidate("viscous damping", state, (variable(state),))


@pytest.fixture(scope="module")
def softened():
    """A loop that finds a spring with half its stiffness away from its middle."""
    gap = oscillator("dead zone", "+ 20*(q - 0.5*(abs(q + 0.2) - abs(q - 0.2)))")
    return pse.close_loop(gap.model, gap.record(), operators=(), random_state=0)


def test_a_declared_term_that_an_effect_holds_too_is_mentioned(report, softened):
    assert "Where an effect below has a term in common with the rest" in str(softened)
    assert "Where an effect below has a term in common" not in str(report)


def _told(before, after, *expressions):
    """Return an outcome of which only the equations and the terms of its effects matter."""
    effects = [
        SimpleNamespace(state="v", expressions=(e,), quantities=(), written=()) for e in expressions
    ]
    models = {"before": SimpleNamespace(model=before), "equations": after}
    return SimpleNamespace(
        effects=effects, after=SimpleNamespace(model=after, parameters={"k": 2.0}), **models
    )


def test_hidden_states_do_not_make_a_sum_of_terms():
    """They come before the inputs, and so shift the numbers of these."""
    before = equations_of({"q": "v", "v": "-2*q + F"}, ("F",))
    yielded = yielding(variable(0), variable(1), 0.1, 0.5)
    (path,), (square,) = yielded.parts, power(variable(2), 2).parts
    coef = np.pad(before.coef, ((0, 0), (0, 2)))
    coef[1, -2:] = 3.0
    inner = replace(before, terms=(*before.terms, path[1], square[1]), coef=coef)
    after = with_memories(inner, [])
    assert len(after.states) == 3
    assert note_on_shared_terms(_told(before, after, yielded, power(variable(2), 2))) == []


def test_the_power_of_a_difference_is_said_to_be_multiplied_out():
    before = equations_of({"q": "v", "v": "-2*q", "p": "w", "w": "-p"})
    after = equations_of({"q": "v", "v": "-2*q - 4*(q - p)**3", "p": "w", "w": "-p"})
    cube = power(add(variable(0), mul(constant(-1.0), variable(2))), 3)
    (said,) = note_on_shared_terms(_told(before, after, cube))
    assert said.endswith("the power of a difference below multiplied out.")
    assert "q^3 " in format_equations(after)


def test_a_sum_that_a_coefficient_multiplies_stands_in_parentheses(softened):
    (effect,) = softened.effects
    assert effect.name == "dead zone"
    assert f"{effect.coefficients[0]:.4g} times (" in str(softened)


def test_the_loop_says_how_sure_a_half_width_is(softened):
    (effect,) = softened.effects
    ((low, high),) = effect.number_intervals
    assert list(effect.numbers) == ["half width"]
    assert 0.18 < low < 0.2 < high < 0.22
    assert f"half width {effect.numbers['half width']:.4g} (95 %: " in str(softened)


def test_a_parameter_that_turns_its_sign_is_mentioned(report):
    turned = dict(report.after.parameters) | {"c": -0.3}
    said = " ".join(str(replace(report, after=replace(report.after, parameters=turned))).split())
    was = format_number(report.before.parameters["c"])
    assert f"reverses the sign of a parameter: c from {was} to -0.3. If the" in said
    assert "reverses the sign" not in str(report)


def test_a_parameter_of_which_nothing_is_left_is_mentioned(report):
    gone = dict(report.after.parameters) | {"c": -1e-3}
    said = " ".join(str(replace(report, after=replace(report.after, parameters=gone))).split())
    was = format_number(report.before.parameters["c"])
    assert f"little is left of a declared term: c from {was} to -0.001. The model" in said
    assert "little is left" not in str(report)


def test_a_parameter_that_may_be_zero_beside_the_effects_is_mentioned(report):
    values = dict(report.after.parameters) | {"c": -0.3}
    ends = dict(report.after.parameter_intervals) | {"c": np.array([-0.7, 0.1])}
    open_ = replace(report.after, parameters=values, parameter_intervals=ends)
    said = " ".join(str(replace(report, after=open_)).split())
    was = format_number(report.before.parameters["c"])
    assert f"zero lies in the interval of a declared parameter: c from {was} to -0.3." in said
    assert "reverses the sign" not in said
    assert "zero lies in the interval of" not in str(report)


@pytest.mark.parametrize(("numbers", "shown"), [({}, "3 times v"), ({"end": 2.0}, "1.5 times 2 v")])
def test_a_number_before_a_term_goes_to_its_coefficient_unless_it_is_tuned(report, numbers, shown):
    effect = replace(
        report.effects[-1],
        expressions=(mul(constant(2.0), variable(1)),),
        coefficients=np.array([1.5]),
        confidence_intervals=np.array([[1.0, 2.0]]),
        numbers=numbers,
        number_intervals=np.full((len(numbers), 2), np.nan),
    )
    lines = evidence(effect, report.equations.inner_symbols)
    assert lines[0].startswith(f"{shown}   (95 %: ")
    assert ("1.5 times 2 is 3 in the equation" in lines) is bool(numbers)


@pytest.mark.slow
def test_a_wrong_known_value_is_found_under_its_own_name_and_told():
    sides = {"q": "v", "v": "-30*q - c*v + b*F"}
    record = measured({**sides, "v": "-30*q - 0.8*v + F"}, noise=5e-3, duration=20.0)
    declared = pse.DeclaredModel({**sides, "v": "-33*q - c*v + b*F"}, inputs=["F"])
    found = pse.close_loop(declared, record, operators=(), random_state=0)
    assert [effect.name for effect in found.effects] == ["linear stiffness"]
    assert found.effects[0].coefficients[0] == pytest.approx(3.0, rel=0.02)
    said = " ".join(str(found).split())
    assert "The declared equation of v holds q with the known coefficient -33" in said
    assert "Check what was given as known." in said


def test_errors_that_grew_on_held_out_data_are_mentioned(report):
    grown = replace(report.after, derivative_error=2.0 * report.before.derivative_error)
    said = " ".join(str(replace(report, after=grown)).split())
    assert "On the held-out data some errors grew: dv/dt from" in said
    assert "errors grew" not in str(report)


def test_an_error_that_earlier_effects_had_made_small_is_mentioned(report):
    low, high = (replace(report.after, derivative_error=np.array([0.0, e])) for e in (2.0, 30.0))
    steps = [Step("drag", "v", low), Step("offset", "v", low), Step("input gain", "v", high)]
    said = " ".join(str(replace(report, steps=steps, after=high)).split())
    assert "With drag and offset the held-out error of dv/dt came down to 2 %" in said
    assert "One of the later effects may be wrong" not in str(report)


@pytest.mark.parametrize(("interrupted", "why"), [(True, "interrupted"), (False, "max_effects")])
def test_a_search_that_stopped_early_says_why_also_if_effects_were_withdrawn(
    report, interrupted, why
):
    said = str(replace(report, finished=False, interrupted=interrupted))
    assert why in said.split("The search stopped early: it ")[1]


def test_a_corrected_model_that_diverges_where_the_declared_one_did_not_is_mentioned(report):
    wild = equations_of({"q": "v", "v": "9*q**3"}, ("F",))
    after = replace(report.after, model=wild, simulation_error=simulation_errors(wild, report.test))
    assert np.isinf(after.simulation_error).all()
    by_start = run_std_from_start_noise(wild, report.test)
    assert np.isinf(by_start).all()  # which explains nothing here
    said = " ".join(str(replace(report, after=after)).split())
    was = percent(report.before.simulation_error[0])
    assert f"some errors grew: the free run of q from {was} to no finite value" in said
    lost = np.full(2, 137.0 * LOST_NRMSE)  # no run of an unstable machine follows its record
    before = replace(report.before, simulation_error=lost)
    assert "some errors grew" not in str(replace(report, before=before, after=after))


def test_a_list_of_records_and_a_folder_are_refused(report, tmp_path):
    with pytest.raises(TypeError, match=r"simulate\(record=\.\.\.\) must be a Record; got list"):
        report.simulate(list(report.test))
    with pytest.raises(ValueError, match=r"to_html\(path=\.\.\.\) must be a file; got the folder"):
        report.to_html(tmp_path)


@pytest.mark.parametrize(
    "terms", [["+ 2*sin(21.3*t + 0.4)", "+ 2*sin(21.3*t + 2.5)", "+ 2*sin(21.3*t + 4.6)"], [""] * 3]
)
def test_a_line_whose_phase_differs_between_records_is_told_and_not_named(terms):
    machines = [oscillator("a line, or nothing", term) for term in terms]
    train = [m.record(noise=5e-3, duration=20.0, seed=k) for k, m in enumerate(machines)]
    found = pse.close_loop(machines[0].model, train, operators=(), random_state=0)
    lines = re.findall(r"has a line at (\S+) cycles per unit of t", " ".join(str(found).split()))
    assert found.effects == []
    assert [float(line) for line in lines] == pytest.approx([21.3 / (2 * np.pi)] * any(terms), 1e-2)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*samples of a test record")
def test_no_line_is_told_of_a_record_too_short_to_know_its_noise():
    truth = pse.DeclaredModel({"S": "-0.4*S*I", "I": "0.4*S*I - 0.1*I"}).design().equations([])
    t, records = np.linspace(0.0, 120.0, 600), []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        x = pse.simulate(truth, [0.99 - 0.02 * (seed % 2), 0.01], t)
        records.append(
            pse.prepare(t, x + 0.005 * x.std(axis=0) * rng.standard_normal(x.shape), order=1)
        )
    declared = pse.DeclaredModel({"S": "-a*S*I", "I": "b*S*I - c*I"})
    for first in range(0, 12, 2):  # more than half of such pairs had a common one
        pair = records[first : first + 2]
        report = pse.close_loop(declared, pair, pair[:1], operators=(), random_state=0)
        assert "has a line at" not in str(report)


@pytest.mark.slow
def test_a_wrong_weight_is_no_gravity_of_an_angle():
    sides = {"q": "v", "v": "-k*q - c*v + b*F"}
    record = measured({"q": "v", "v": "-30*q - 0.8*v + F - 14.8"}, noise=1e-3, duration=20.0)
    declared = pse.DeclaredModel({**sides, "v": sides["v"] + " - 9.81"}, inputs=["F"])
    found = pse.close_loop(declared, record, operators=(), random_state=0)
    assert [effect.name for effect in found.effects] == ["constant offset"]
    assert found.effects[0].coefficients == pytest.approx([-4.99], rel=0.02)
    assert "gravity" not in found.effects[0].alternatives
    said = " ".join(str(found).split())
    assert "holds the known constant -9.81; the record asks for -14.8" in said


@pytest.mark.parametrize(
    ("value", "ends", "shown"),
    [
        (100.026, (100.003, 100.049), "100.026"),  # 100 is not between them
        (3.0012, (2.9963, 3.0045), "3.001"),
        (-1.5e-7, (-1.6e-7, -1.4e-7), "-1.5e-7"),
        (0.2, (0.3, 0.4), "0.2"),  # nor is the number itself
    ],
)
def test_a_number_is_printed_within_its_interval(value, ends, shown):
    assert value_within(value, *ends) == shown


def lines_of(name, coefficients, intervals):
    """Return what is said of an effect with a term in q and one in its square."""
    known = {"confidence_intervals": np.array(intervals)}
    values = {"coefficients": np.array(coefficients), "quantities": (), "entry": ""}
    rest = {"numbers": {}, "number_intervals": np.empty((0, 2)), "by_runs": False, "explained": 0.5}
    rest |= {
        "of_sensor": False,
        "p_value": 0.01,
        "twin_scores": np.zeros(9),
        "rivals": (),
        "contested": True,
        "term": sympy.Symbol("q", real=True),
    }
    rest |= {
        "state": "v",
        "together": (),
        "written": (),
        "expressions": (variable(0), power(variable(0), 2)),
    }
    symbols = [sympy.Symbol("q", real=True)]
    return evidence(SimpleNamespace(name=name, **known, **values, **rest), symbols)


@pytest.mark.parametrize(
    ("name", "said"), [("periodic forcing", False), ("quadratic stiffness", True)]
)
def test_a_wave_with_a_phase_of_zero_is_not_said_to_be_unknown(name, said):
    lines = lines_of(name, [2.0, 0.0], [[1.0, 3.0], [-0.5, 0.5]])
    assert any("contains zero" in line for line in lines) is said


@pytest.mark.parametrize(("end", "said"), [(0.0, 1), (0.1, 0)])
def test_an_interval_that_ends_at_zero_is_explained(end, said):
    lines = lines_of("Stribeck friction", [2.0, -3.0], [[1.0, 3.0], [-6.0, -end]])
    assert sum("zero itself was ruled out" in line for line in lines) == said
