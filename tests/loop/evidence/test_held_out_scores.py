"""Tracing: the effect that is hidden comes first, under its name, in its equation."""

import numpy as np
import pytest
from loop_systems import hidden_effects, measured, oscillator

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import OFFSET, Candidate
from pysindy_evolve.loop.effects.missing import terms_in
from pysindy_evolve.loop.evidence.held_out_scores import fold_errors, rank
from pysindy_evolve.loop.evidence.scoring import propose, quick_fit, score
from pysindy_evolve.loop.given.design import in_state
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.terms import variable


def ranking(model, record, *, pairs=True):
    design, part = model.design(), segments([record])
    return score(design, part, propose(design, quick_fit(design, part), part), pairs=pairs)


@pytest.mark.parametrize("hidden", hidden_effects(), ids=lambda hidden: hidden.effect)
def test_hidden_effect_comes_first_in_its_equation(hidden):
    scores = ranking(hidden.model, hidden.record(noise=1e-3))
    (first,) = scores[0].group
    assert first.name == hidden.effect
    assert hidden.model.states[first.state] == hidden.state
    assert scores[0].value > 0.1
    assert np.all(scores[0].errors < scores[0].without)


@pytest.mark.parametrize("hidden", hidden_effects(), ids=lambda hidden: hidden.effect)
def test_what_ranks_first_does_not_depend_on_the_noise_or_the_force(hidden):
    record = hidden.record(noise=2e-3, seed=1)
    assert ranking(hidden.model, record, pairs=False)[0].group[0].name == hidden.effect


@pytest.mark.parametrize("effect", ["Coulomb friction", "quadratic drag", "cubic stiffness"])
def test_hidden_effect_comes_first_under_a_sweep(effect):
    (hidden,) = (h for h in hidden_effects() if h.effect == effect)
    t = np.arange(0.0, 40.0, 0.01)
    sweep = 15.0 * np.sin(2 * np.pi * (0.2 * t + 0.5 * 1.8 * t**2 / 40.0))
    machine = pse.DeclaredModel(hidden.truth, inputs=["F"]).design().equations([])
    q = pse.simulate(machine, [0.0, 0.0], t, sweep, tolerance=1e-8)[:, 0]
    q = q + 1e-3 * q.std() * np.random.default_rng(0).standard_normal(len(t))
    assert ranking(hidden.model, pse.prepare(t, q, sweep))[0].group[0].name == effect


def test_two_effects_that_only_show_together_come_first_as_a_pair():
    # The drag takes from the damping what the offset gives, so neither stands out alone.
    hidden = oscillator("both", "- 2*sgn(v) - 0.4*v*abs(v)")
    first = ranking(hidden.model, hidden.record(noise=1e-3))[0]
    assert {c.name for c in first.group} == {"Coulomb friction", "quadratic drag"}
    assert len(first.places) == 2


def test_a_model_without_columns_leaves_all_of_the_target():
    """All of its numbers were known: what it leaves was judged by indices that were floats."""
    x, target = np.random.default_rng(0).standard_normal((2, 1600))
    errors = fold_errors(made(target, x), np.array([()]), FOLDS)
    assert errors.sum() == pytest.approx(np.sum(target**2))


def test_score_is_the_log_of_the_error_ratio_per_effect():
    hidden = oscillator("Coulomb friction", "- 2*sgn(v)")
    for found in ranking(hidden.model, hidden.record())[:20]:
        ratio = found.without.sum() / found.errors.sum()
        assert found.value == pytest.approx(np.log(ratio) / len(found.group))


def test_scores_are_sorted_and_no_group_is_scored_twice():
    hidden = oscillator("Coulomb friction", "- 2*sgn(v)")
    scores = ranking(hidden.model, hidden.record())
    values = [s.value for s in scores]
    assert values == sorted(values, reverse=True)
    assert len({frozenset(s.group) for s in scores}) == len(scores)


def test_nothing_stands_out_where_nothing_is_missing():
    hidden = oscillator("nothing", "")
    assert ranking(hidden.model, hidden.record())[0].value < 0.1


# ---- the ranking itself, on columns made by hand


def made(target, *columns, n_segments=16):
    """Return the grams of random columns and a target."""
    rows = np.column_stack([*columns, target])
    parts = rows.reshape(n_segments, -1, rows.shape[1])
    return np.einsum("srk,srl->skl", parts, parts)


FOLDS = np.arange(16) // 2


@pytest.fixture
def columns():
    return np.random.default_rng(0).normal(size=(6, 1600))


def three(parents=()):
    return [
        Candidate("one", 0, (variable(1),)),
        Candidate("two", 0, (variable(2),)),
        Candidate("three", 0, (variable(3),), parents),
    ]


def test_errors_of_folds_are_those_of_least_squares_on_the_other_folds(columns):
    x, target = columns[:2].T, columns[0] + 0.5 * columns[5]
    errors = fold_errors(made(target, *x.T), np.array([[0, 1]]), FOLDS)[0]
    for k, held in enumerate(np.array_split(np.arange(1600), 8)):
        rest = np.setdiff1d(np.arange(1600), held)
        coef, *_ = np.linalg.lstsq(x[rest], target[rest], rcond=None)
        assert errors[k] == pytest.approx(np.sum((target[held] - x[held] @ coef) ** 2), rel=1e-6)


def test_true_column_comes_first(columns):
    model, a, b, c, noise, _ = columns
    grams = made(2 * model + b + 0.1 * noise, model, a, b, c)
    scores = rank(grams, 1, three(), set(), FOLDS)
    assert [candidate.name for candidate in scores[0].group] == ["two"]
    assert scores[0].places == (2,)


def test_column_that_the_model_already_spans_is_left_out(columns):
    model, other, b, c, noise, _ = columns
    grams = made(b + 0.1 * noise, model, other, 2 * model - 3 * other, b, c)
    names = {n.name for s in rank(grams, 2, three(), set(), FOLDS) for n in s.group}
    assert names == {"two", "three"}


@pytest.mark.parametrize("bad", [0.0, np.nan])
def test_column_of_zeros_or_without_values_is_left_out(columns, bad):
    model, a, b, _, noise, _ = columns
    grams = made(b + 0.1 * noise, model, a, b, np.zeros(1600))
    grams[:, 3, :] = grams[:, :, 3] = bad
    names = {n.name for s in rank(grams, 1, three(), set(), FOLDS) for n in s.group}
    assert names == {"one", "two"}


def test_effect_waits_for_its_parent_or_comes_with_it(columns):
    model, a, b, c, noise, _ = columns
    grams = made(c + 0.1 * noise, model, a, b, c)
    needs = three(parents=(variable(1),))
    groups = [{c.name for c in s.group} for s in rank(grams, 1, needs, set(), FOLDS)]
    assert {"three"} not in groups
    assert {"one", "three"} in groups
    assert {"two", "three"} not in groups
    standing_parent = {(0, variable(1))}
    groups = [{c.name for c in s.group} for s in rank(grams, 1, needs, standing_parent, FOLDS)]
    assert groups[0] == {"three"}


def test_parent_in_another_equation_does_not_count(columns):
    model, a, b, c, *_ = columns
    grams = made(c, model, a, b, c)
    needs = three(parents=(OFFSET,))
    groups = [{c.name for c in s.group} for s in rank(grams, 1, needs, {(1, OFFSET)}, FOLDS)]
    assert not any("three" in group for group in groups)


@pytest.mark.parametrize(("offset", "names"), [(0.0, {"square"}), (0.5, {"offset", "square"})])
def test_what_could_pose_as_an_offset_needs_one_only_where_there_is_one(columns, offset, names):
    model, a, _, _, noise, _ = columns
    square = a**2
    posing = [
        Candidate("offset", 0, (OFFSET,)),
        Candidate("square", 0, (variable(1),), parents=(OFFSET,)),
    ]
    target = model + square + offset + 0.01 * noise
    scores = rank(made(target, model, np.ones(1600), square), 1, posing, set(), FOLDS)
    assert {candidate.name for candidate in scores[0].group} == names
    assert scores[0].value == pytest.approx(max(s.value for s in scores))
    alone = [s.group for s in scores if {c.name for c in s.group} == {"square"}]
    assert alone == ([(Candidate("square", 0, (variable(1),)),)] if not offset else [])


def test_an_offset_is_not_taken_for_what_could_pose_as_one(columns):
    model, a, _, _, noise, _ = columns
    posing = [
        Candidate("offset", 0, (OFFSET,)),
        Candidate("square", 0, (variable(1),), parents=(OFFSET,)),
    ]
    grams = made(model + 1.0 + 0.1 * noise, model, np.ones(1600), 1.0 + 0.1 * a)
    groups = [{c.name for c in s.group} for s in rank(grams, 1, posing, set(), FOLDS)]
    assert groups[0] == {"offset"}
    assert {"square"} not in groups


def test_two_shapes_of_one_effect_are_no_pair(columns):
    model, a, b, c, *_ = columns
    same = [Candidate("drag", 0, (variable(1),)), Candidate("drag", 0, (variable(2),))]
    scores = rank(made(c, model, a, b), 1, same, set(), FOLDS)
    assert [len(s.group) for s in scores] == [1, 1]


def test_coupling_is_traced_to_the_equation_that_lacks_it():
    truth = {"a": "va", "va": "-40*a - va + F", "b": "vb", "vb": "-90*b - vb + 15*a + F"}
    declared = {"a": "va", "va": "-k*a - c*va + F", "b": "vb", "vb": "-m*b - d*vb + F"}
    model = pse.DeclaredModel(declared, inputs=["F"])
    first = ranking(model, measured(truth), pairs=False)[0]
    assert first.group[0].state == 3
    assert first.group[0].terms == (variable(0),)
    richer = model.design().adding([in_state("coupling", variable(0), 3, 4)])
    assert (3, variable(0)) in terms_in(richer)


def test_a_column_that_is_zero_in_all_folds_but_one_tells_nothing_about_that_one(columns):
    x, other, noise = columns[0], columns[1], columns[5]
    once = np.where(np.arange(1600) < 200, 1e4 * other, 0.0)
    grams = made(x + 0.5 * noise, x, once)
    with np.errstate(all="raise"):
        both = fold_errors(grams, np.array([[0, 1]]), FOLDS)
    assert both[0, 0] == pytest.approx(fold_errors(grams, np.array([[0]]), FOLDS)[0, 0], rel=1e-6)
