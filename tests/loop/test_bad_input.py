"""Bad input ends in a result or in an error of the house form, never in anything else."""

import re

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import pysindy_evolve as pse
from pysindy_evolve.loop.given.resampling import at_one_step

HOUSE_FORM = re.compile(r"^\w+.*\(.+=\.\.\.\) must .+; got .+\. .+", re.DOTALL)
SPRING = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v"})


def spring_record(n=400):
    t = 0.02 * np.arange(n)
    x = np.column_stack([np.sin(3.0 * t), 3.0 * np.cos(3.0 * t)])
    return pse.Record(t=t, x=x, x_dot=np.column_stack([x[:, 1], -9.0 * x[:, 0] - 0.1 * x[:, 1]]))


def ends_well(action):
    """Run an action; anything but a result or an error of the house form is a failure."""
    try:
        return action()
    except (ValueError, TypeError) as error:
        message = str(error)
    assert HOUSE_FORM.match(message), message
    return None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"significance": 0.0}, r"significance=\.\.\.\) must be in \(0, 1\); got 0\.0"),
        ({"significance": np.nan}, r"significance=\.\.\.\) must be in \(0, 1\); got nan"),
        ({"min_share": 1.5}, r"min_share=\.\.\.\) must be in \(0, 1\); got 1\.5"),
        ({"n_twins": 0}, r"n_twins=\.\.\.\) must be at least 1; got 0"),
        ({"n_twins": 5}, r"n_twins=\.\.\.\) must be at least 59 for significance=0\.05; got 5"),
        ({"max_effects": -1}, r"max_effects=\.\.\.\) must be at least 0; got -1"),
        ({"refine": "both"}, r"refine=\.\.\.\) must be one of auto, derivative, simulation"),
        ({"n_jobs": 0}, r"n_jobs=\.\.\.\) must not be 0; got 0"),
        ({"operators": ("sinus",)}, r"operators=\.\.\.\) must name built-in operators"),
    ],
)
def test_setting_out_of_range_is_refused(options, message):
    with pytest.raises(ValueError, match=rf"close_loop\({message}"):
        pse.close_loop(SPRING, spring_record(), **options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"significance": "small"}, r"significance=\.\.\.\) must be a number; got 'small'"),
        ({"min_share": True}, r"min_share=\.\.\.\) must be a number; got True"),
        ({"n_twins": 2.5}, r"n_twins=\.\.\.\) must be an integer; got 2\.5"),
        ({"max_effects": True}, r"max_effects=\.\.\.\) must be an integer; got True"),
        ({"n_jobs": "all"}, r"n_jobs=\.\.\.\) must be an integer or None; got 'all'"),
    ],
)
def test_setting_of_the_wrong_kind_is_a_type_error(options, message):
    with pytest.raises(TypeError, match=rf"close_loop\({message}"):
        pse.close_loop(SPRING, spring_record(), **options)


@pytest.mark.parametrize("parameter", ["train", "test"])
@pytest.mark.parametrize("given_records", [np.ones((50, 2)), None, [1, 2], "record.csv", {}])
def test_what_is_no_record_is_a_type_error(parameter, given_records):
    if parameter == "test" and given_records is None:
        pytest.skip("no test record is the default")
    records = {"train": spring_record(), parameter: given_records}
    with pytest.raises(TypeError, match=rf"close_loop\({parameter}=\.\.\.\) must be a Record or"):
        pse.close_loop(SPRING, **records)


def test_empty_list_of_records_is_refused():
    with pytest.raises(ValueError, match=r"close_loop\(train=\.\.\.\) must hold at least one"):
        pse.close_loop(SPRING, [])


@pytest.mark.parametrize(
    ("equations", "inputs", "message"),
    [
        ({"q": "-k*q"}, (), "one column of x for each state of the model; got 2 for 1"),
        ({"q": "v", "v": "F"}, ("F",), "one column of u for each input of the model; got 0 for 1"),
        ({"q": "v", "v": "F+G"}, ("F", "G"), r"got 0 for 2\. Pass u to prepare\(t, y, u\).* F, G "),
        ({"q": "v", "w": "-k*q"}, (), "velocity 'w' in the equation of 'q', .* parameters: v"),
    ],
)
def test_record_that_does_not_fit_the_model_is_refused(equations, inputs, message):
    with pytest.raises(ValueError, match=message):
        pse.close_loop(pse.DeclaredModel(equations, inputs=inputs), spring_record())


@pytest.mark.parametrize(("n", "part"), [(40, 28), (46, 14), (60, 18)])
@pytest.mark.parametrize("listed", [False, True])
def test_record_too_short_to_hold_out_a_part_is_refused(n, part, listed):
    record = spring_record(n)
    message = (
        "must have at least 32 samples a record, held-out part included; got "
        rf"{part} of {n} samples, the last 30 % of them held out\. Record longer, or pass `test`"
    )
    with pytest.raises(ValueError, match=message):
        pse.close_loop(SPRING, [record] if listed else record)


def test_short_record_to_judge_on_is_not_said_to_be_cut_from_another():
    with pytest.raises(ValueError, match=r"included; got 20\. Record longer"):
        pse.close_loop(SPRING, spring_record(), test=spring_record(20))


@pytest.mark.parametrize(
    ("ratio", "cutoff", "advice"),
    [
        (1.5, 5.0, "Prepare all of them to a step of 0.03, by `decimate`, with a cutoff of at "),
        (2.0, 20.0, "to a step of 0.02, by `decimate`, with a cutoff of at most 16.7, or bring"),
        (2.0, None, "to a step of 0.02, by `decimate`, with a cutoff of at most 16.7, or bring"),
        (1.46, 1.0, "got 0.01 and 0.0146, with a cutoff of 1. Bring all records to one step with "),
    ],
)
def test_rates_without_a_common_step_are_refused_by_their_own_names(ratio, cutoff, advice):
    t = 0.01 * np.arange(2000)
    fast = pse.prepare(t, np.sin(3.0 * t), cutoff=cutoff, decimate=1)
    slow = pse.prepare(ratio * t, np.sin(3.0 * ratio * t), cutoff=cutoff, decimate=1)
    with pytest.raises(ValueError, match=re.escape(advice)) as caught:
        at_one_step([fast], [slow])
    assert HOUSE_FORM.match(str(caught.value))
    assert "resample" in str(caught.value)


def test_records_of_two_rates_meet_at_a_step_that_both_go_into():
    t = 0.001 * np.arange(9000)
    fast = pse.prepare(t, np.sin(3.0 * t), cutoff=30.0, decimate=3)
    slow = pse.prepare(2.0 * t, np.sin(6.0 * t), cutoff=20.0)
    train, test = at_one_step([fast], [slow])
    assert [round(record.dt, 9) for record in (*train, *test)] == [0.002, 0.002]
    assert [r.preparation.cutoff for r in (*train, *test)] == pytest.approx([30.0, 30.0])


def test_a_slower_record_to_judge_on_sets_the_step_where_the_training_has_a_shorter_one():
    t = 0.01 * np.arange(2000)
    fast = pse.prepare(t, np.sin(3.0 * t), cutoff=5.0, decimate=1)
    slow = pse.prepare(2.0 * t, np.sin(6.0 * t), cutoff=5.0, decimate=1)
    train, test = at_one_step([fast], [slow])
    assert [round(record.dt, 9) for record in (*train, *test)] == [0.02, 0.02]


def test_training_decimated_to_the_step_of_the_test_is_taken():
    t = 0.01 * np.arange(2000)
    fast = pse.prepare(t, np.sin(3.0 * t), cutoff=5.0, decimate=2)
    slow = pse.prepare(2.0 * t, np.sin(6.0 * t), cutoff=5.0, decimate=1)
    train, test = at_one_step([fast], [slow])
    assert train[0].dt == pytest.approx(test[0].dt)


def test_three_records_decimated_each_in_its_own_way_are_brought_to_one_step():
    t = 0.01 * np.arange(3000)
    records = [pse.prepare(t, np.sin(3.0 * t), cutoff=4.0, decimate=k) for k in (3, 2, 2)]
    train, test = at_one_step(records[:2], records[2:])
    assert {round(record.dt, 9) for record in (*train, *test)} == {0.02}


def test_a_column_that_says_nothing_is_called_by_its_name():
    t = 0.01 * np.arange(2000)
    record = pse.prepare(t, np.sin(3.0 * t), np.ones_like(t))
    declared = pse.DeclaredModel({"q": "v", "v": "-k*q + b*F"}, inputs=["F"])
    with pytest.raises(
        ValueError,
        match=r"columns of u that vary; got 1 everywhere in F\. .*"
        "and declare a free constant",
    ):
        pse.close_loop(declared, record)


def test_columns_of_u_that_the_model_does_not_name_are_to_be_named():
    t = 0.01 * np.arange(500)
    message = r"of the model; got 1 for 0\. Name what acts in `inputs` of the model\."
    with pytest.raises(ValueError, match=message):
        pse.close_loop(SPRING, pse.prepare(t, np.sin(3.0 * t), np.cos(t)))


def test_booleans_are_no_measurement_but_may_be_an_input():
    t = 0.01 * np.arange(500)
    q = np.sin(3.0 * t)
    with pytest.raises(TypeError, match=r"prepare\(y=\.\.\.\) must be measured values, not bool"):
        pse.prepare(t, q > 0.0)
    assert pse.prepare(t, q, q > 0.5).n_inputs == 1


@pytest.mark.parametrize(
    "view", [pse.to_sympy, pse.to_code, lambda m: pse.simulate(m, [1.0, 0.0], [0, 1])]
)
def test_views_of_a_declared_model_say_how_to_fit_it(view):
    with pytest.raises(TypeError, match=r"pass close_loop\(declared, record\)\.model"):
        view(SPRING)


def test_irregular_time_is_refused():
    record = spring_record()
    t = record.t + np.where(np.arange(400) > 200, 5.0, 0.0)
    gap = pse.Record(t=t, x=record.x, x_dot=record.x_dot)
    with pytest.raises(
        ValueError, match=r"must be sampled uniformly; got steps from 0\.02 to 5\.02"
    ):
        pse.close_loop(SPRING, gap)


def test_records_of_two_sampling_times_without_preparation_are_refused():
    record = spring_record()
    slower = pse.Record(t=2.0 * record.t, x=record.x, x_dot=record.x_dot)
    with pytest.raises(ValueError, match=r"must have one sampling time in all records; got 0\.02"):
        pse.close_loop(SPRING, [record, slower])


@pytest.mark.parametrize("text", ["-k*log(q)", "-k*sqrt(v)", "log(q)"])
def test_model_without_a_value_on_the_record_is_refused(text):
    declared = pse.DeclaredModel({"q": "v", "v": text})
    with pytest.raises(ValueError, match=r"declared=\.\.\.\) must be finite on the records; got"):
        pse.close_loop(declared, spring_record())


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("x", 0.0, r"columns of x that vary; got 0 everywhere in q\."),
        ("x", 3.5, r"columns of x that vary; got 3\.5 everywhere in q\."),
        ("x_dot", 0.0, r"columns of x_dot that vary; got 0 everywhere in q'\."),
    ],
)
def test_column_that_says_nothing_is_refused(name, value, message):
    record = spring_record()
    fields = {"x": record.x.copy(), "x_dot": record.x_dot.copy()}
    fields[name][:, 0] = value
    with pytest.raises(ValueError, match=message):
        pse.close_loop(SPRING, pse.Record(t=record.t, **fields))


@pytest.mark.parametrize("unit", [1e40, 1e-40])
def test_units_out_of_the_range_of_the_arithmetic_are_refused(unit):
    record = spring_record()
    with pytest.raises(
        ValueError, match=r"must have a size between 1e-30 and 1e\+30 in each column"
    ):
        pse.close_loop(SPRING, pse.Record(t=record.t, x=unit * record.x, x_dot=unit * record.x_dot))


def test_objects_stay_usable_after_an_error():
    record = spring_record()
    with pytest.raises(ValueError, match="significance"):
        pse.close_loop(SPRING, record, significance=2.0)
    assert pse.close_loop(SPRING, record, operators=(), random_state=0).verdict == "complete"


def noise_record(seed, *, driven):
    """White noise whose rates, and input, are copies of its states."""
    x = np.random.default_rng(seed).standard_normal((2, 32)).T  # column by column
    return pse.Record(t=0.01 * np.arange(32), x=x, x_dot=x, u=x[:, 1:] if driven else None)


@pytest.mark.filterwarnings("ignore:.*samples of a test record")
def test_an_input_may_be_a_copy_of_a_state():
    model = pse.DeclaredModel({"q": "0", "v": "0"}, inputs=["F"])
    record = noise_record(0, driven=True)
    report = pse.close_loop(model, record, test=record, operators=(), random_state=0)
    assert report.verdict == "traced"


@pytest.mark.filterwarnings("ignore:.*samples of a test record")
def test_a_state_may_be_its_own_rate():
    model = pse.DeclaredModel({"q": "0", "v": "-k*q"})
    record = noise_record(5, driven=False)
    options = {"n_twins": 29, "significance": 0.1, "operators": (), "random_state": 0}
    report = pse.close_loop(model, record, test=record, **options)
    assert {effect.name for effect in report.effects} == {"viscous damping"}


# ---- anything at all

KINDS = ("noise", "wave", "zero", "constant", "copy", "huge", "tiny", "nan", "inf", "steps")


def column(kind, rng, n, first):
    base = rng.standard_normal(n)
    return {
        "noise": base,
        "wave": np.sin(np.linspace(0.0, 20.0, n)) + 1e-3 * base,
        "zero": np.zeros(n),
        "constant": np.full(n, 3.7),
        "copy": base if first is None else first.copy(),
        "huge": 1e150 * base,
        "tiny": 1e-150 * base,
        "nan": np.where(np.arange(n) == n // 2, np.nan, base),
        "inf": np.where(np.arange(n) == n // 2, np.inf, base),
        "steps": np.sign(base),
    }[kind]


@st.composite
def tables(draw, max_columns=3):
    """Draw times and a few columns of up to 60 rows, well behaved or not."""
    n = draw(st.integers(8, 31) if draw(st.integers(0, 4)) == 0 else st.integers(32, 60))
    rng = np.random.default_rng(draw(st.integers(0, 99)))
    usual = st.sampled_from(("noise", "wave", "wave", "steps"))
    unusual = st.sampled_from(KINDS)
    each = usual if draw(st.booleans()) else unusual
    kinds = draw(st.lists(each, min_size=1, max_size=max_columns))
    table: list[np.ndarray] = []
    for kind in kinds:
        table.append(column(kind, rng, n, table[0] if table else None))
    t = np.arange(n) * draw(st.sampled_from([0.01, 1.0, 1e-6, 1e5]))
    flaw = draw(st.sampled_from([*["none"] * 8, "back", "gap", "nan", "short"]))
    if flaw == "back":
        t[n // 2] = t[n // 2 - 1]
    elif flaw == "gap":
        t[n // 2 :] += 30 * (t[1] - t[0])
    elif flaw == "nan":
        t[1] = np.nan
    elif flaw == "short":
        t = t[:-1]
    return t, np.column_stack(table)


TEXTS = st.sampled_from(
    ["0", "v", "-k*q", "-k*q - c*v", "k", "k*q^3", "1/q", "k*sqrt(q)", "exp(q)", "k*exp(v)*q",
     "-9.81", "t", "k*t", "k*sgn(v)", "F", "b*F - k*q", "k*c", "sin(k)", "foo(q)", "q +", "",
     "q..v", "k*q - k*q", "1e308*q*q", "q^64", "__import__('os')", "(((((q)))))", "é*q", "0*k"]
)  # fmt: skip
FITTING = st.sampled_from(["-k*q - c*v", "k*q^3", "-9.81", "k*sgn(v)", "k*t", "0", "k*exp(v)*q"])
FUZZ = {
    "deadline": None,
    "derandomize": True,
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.data_too_large],
}


@settings(max_examples=200, **FUZZ)
@given(table=tables(), order=st.sampled_from([1, 2, 3, 0, "2"]), driven=st.booleans())
def test_prepare_takes_anything(table, order, driven):
    t, columns = table
    y, u = columns[:, :1], columns[:, 1:] if driven and columns.shape[1] > 1 else None
    record = ends_well(lambda: pse.prepare(t, y, u, order=order))
    if record is not None:
        assert np.all(np.isfinite(record.x))
        assert np.all(np.isfinite(record.x_dot))


@settings(max_examples=120, **FUZZ)
@given(sides=st.lists(TEXTS, min_size=1, max_size=3), inputs=st.sampled_from([(), "F", ["q"], 3]))
def test_declared_model_takes_anything(sides, inputs):
    equations = dict(zip(["q", "v", "w"], sides, strict=False))
    ends_well(lambda: pse.DeclaredModel(equations, inputs=inputs).design())


@pytest.mark.filterwarnings("ignore:.*samples of a test record")
@pytest.mark.slow
@settings(max_examples=75, **FUZZ)
@given(
    table=tables(max_columns=4),
    sides=st.tuples(TEXTS, TEXTS) | st.tuples(st.sampled_from(["v", "0"]), FITTING),
    driven=st.booleans(),
    grow=st.booleans(),
)
def test_close_loop_takes_anything(table, sides, driven, grow):
    t, columns = table

    def action():
        columns4 = np.column_stack([columns] * 4)[:, :4]
        u = columns[:, -1:] if driven else None
        record = pse.Record(t=t, x=columns4[:, :2], x_dot=columns4[:, 2:], u=u)
        model = pse.DeclaredModel(
            dict(zip(["q", "v"], sides, strict=True)), inputs=["F"] if driven else []
        )
        options = {} if grow else {"operators": ()}
        return pse.close_loop(
            model, record, record, n_twins=29, significance=0.1, random_state=0, **options
        )

    report = ends_well(action)
    if report is not None:
        assert report.verdict in {"complete", "traced", "untraced"}
        assert str(report)


@settings(max_examples=40, **FUZZ)
@given(table=tables(max_columns=4), seed=st.integers(0, 3))
def test_library_takes_anything(table, seed):
    _, columns = table
    library = pse.EvolvingLibrary(population_size=12, n_generations=2, random_state=seed)
    ends_well(lambda: library.fit(columns[:, :-1], columns[:, -1:]))


@settings(max_examples=100, **FUZZ)
@given(table=tables(max_columns=4))
@pytest.mark.filterwarnings("ignore:ElasticNet kept no term")
def test_optimizer_takes_anything_finite(table):
    _, columns = table  # scikit-learn itself refuses NaN, in the words of its own contract
    columns = np.nan_to_num(np.column_stack([columns[:, 0], columns]), posinf=0.0)
    fitted = ends_well(lambda: pse.ElasticNet().fit(columns[:, :-1], columns[:, -1:]))
    if fitted is not None:
        assert np.all(np.isfinite(fitted.coef_))


def test_columns_under_names_of_the_model_must_stand_in_its_order():
    record = spring_record()
    turned = pse.Record(record.t, record.x[:, ::-1], record.x_dot[:, ::-1], states=("v", "q"))
    with pytest.raises(ValueError, match=r"states in the order of the model, q, v; got v, q\."):
        pse.close_loop(SPRING, turned)


def test_a_velocity_before_its_position_is_an_error_though_a_spring_holds_the_position():
    record = pse.prepare(0.02 * np.arange(400), np.sin(0.06 * np.arange(400)), cutoff=10.0)
    declared = pse.DeclaredModel({"v": "-k*q - c*v", "q": "v"})
    with pytest.raises(ValueError, match=r"each position followed by its velocity; got v, q\."):
        pse.close_loop(declared, record)


def test_states_in_another_order_than_positions_and_velocities_are_an_error():
    t = 0.02 * np.arange(400)
    record = pse.prepare(t, np.column_stack([np.sin(3.0 * t), np.cos(2.0 * t)]), cutoff=10.0)
    declared = pse.DeclaredModel({"a": "p", "b": "q", "p": "-k*a", "q": "-r*b"})
    with pytest.raises(ValueError, match=r"each position followed by its velocity; got a, b, p, q"):
        pse.close_loop(declared, record)


def test_a_column_given_twice_is_refused_as_such():
    t = 0.02 * np.arange(400)
    record = pse.prepare(t, np.column_stack([np.sin(3.0 * t)] * 2))
    two = pse.DeclaredModel({"q": "v", "v": "-k*q", "p": "w", "w": "-l*p"})
    with pytest.raises(ValueError, match=r"column of its own for each state; got .* q and p"):
        pse.close_loop(two, record)


def test_a_record_that_is_fitted_and_judged_on_is_warned_of():
    record = spring_record()
    with pytest.warns(UserWarning, match="100 samples of a test record are in a training record"):
        pse.close_loop(SPRING, record[:300], test=record[200:], max_effects=0, random_state=0)


def test_other_records_at_the_same_times_are_not(recwarn):
    record = spring_record()
    pse.close_loop(SPRING, record[:200], test=record[200:], max_effects=0, random_state=0)
    assert not recwarn.list
