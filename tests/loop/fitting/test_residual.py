"""The three views of a residual: linear in it, and each what it says it is."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.loop.evidence.spectral import spectral_grams
from pysindy_evolve.loop.fitting.linear import solve
from pysindy_evolve.loop.fitting.residual import jacobian, respond, view_grams
from pysindy_evolve.loop.given.design import in_state
from pysindy_evolve.loop.given.rows import variables_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.terms import mul, power, variable

SPRING = {"q": "v", "v": "-k*q - c*v - e*q^3 + b*F"}
TRUE = np.array([40.0, 0.8, 12.0, 1.0])


def force(t):
    return 8.0 * np.sin(3.1 * t) + 6.0 * np.cos(5.3 * t + 1.0)


def declared():
    return pse.DeclaredModel(SPRING, inputs=["F"]).design()


def clean(n=1500, dt=0.01, start=(0.3, 0.0), offset=0.0):
    """Simulate the spring; states and derivatives are exact."""
    t = offset + dt * np.arange(n)
    equations = declared().equations(TRUE)
    x = pse.simulate(equations, start, t, force, tolerance=1e-10)
    u = force(t)[:, None]
    return pse.Record(t=t, x=x, x_dot=equations.evaluate(x, u, t), u=u)


def slopes(part, coef=TRUE):
    return jacobian(declared().equations(coef), part.z, part.state_scale)


def all_grams(part, columns):
    grams = view_grams(part, declared(), columns, slopes(part))
    return {**grams, "spectral": spectral_grams(part, declared(), columns)}


@pytest.mark.parametrize("view", ["derivative", "simulation", "spectral"])
def test_true_coefficients_solve_the_grams_of_clean_data(view):
    part = segments([clean()])
    total = all_grams(part, declared().columns)[view].sum(axis=0)
    assert solve(total[:-1, :-1], total[:-1, -1]) == pytest.approx(TRUE, rel=1e-6)


@pytest.mark.parametrize("view", ["derivative", "simulation", "spectral"])
def test_every_part_of_the_record_has_a_gram_of_its_own(view):
    part = segments([clean()])
    grams = all_grams(part, declared().columns)[view]
    assert grams.shape == (len(part.z), 5, 5)
    assert grams == pytest.approx(np.swapaxes(grams, 1, 2))
    assert np.all(np.linalg.eigvalsh(grams) > -1e-9 * np.abs(grams).max())
    # Each by itself knows the truth as well.
    each = solve(grams[:, :-1, :-1], grams[:, :-1, -1])
    assert np.median(each, axis=0) == pytest.approx(TRUE, rel=1e-3)


@pytest.mark.parametrize("view", ["derivative", "simulation"])
def test_views_are_linear_in_the_columns(view):
    part = segments([clean()])
    q, v = variable(0), variable(1)
    columns = [in_state("a", mul(q, v), 1, 2), in_state("b", power(v, 2), 1, 2)]
    both = in_state("a + 2b", pse.DeclaredModel({"q": "q*v + 2*v^2", "v": 0}).sides[0].known, 1, 2)
    gram = view_grams(part, declared(), [*columns, both], slopes(part))[view].sum(axis=0)
    contrast = np.array([1.0, 2.0, -1.0, 0.0])
    assert contrast @ gram @ contrast == pytest.approx(0.0, abs=1e-9 * gram[2, 2])


@pytest.mark.parametrize(("dt", "accuracy"), [(0.01, 2e-2), (0.0025, 5e-3)])
def test_simulated_deviation_is_that_of_a_real_simulation_to_first_order(dt, accuracy):
    size, t = 1e-4, np.arange(0.0, 4.0, dt)
    base = declared().equations(TRUE)
    other = declared().equations(TRUE + np.array([0.0, 0.0, size, 0.0]))
    x = pse.simulate(base, [0.3, 0.0], t, force, tolerance=1e-11)
    moved = pse.simulate(other, [0.3, 0.0], t, force, tolerance=1e-11)
    slope = jacobian(base, np.column_stack([x, force(t), t]), np.ones(2))[None]
    push = np.zeros((1, len(t), 2, 1))
    push[0, :, 1, 0] = -size * x[:, 0] ** 3
    _, rows = respond(slope, push, dt, np.ones(2), keep=1)
    deviation = rows[0, :, 0].reshape(len(t), 2)
    largest = np.abs(deviation).max()
    assert largest > 1e-7
    assert deviation == pytest.approx(moved - x, abs=accuracy * largest)


@pytest.mark.parametrize(("dt", "accuracy"), [(0.01, 1e-3), (0.0025, 1e-4)])
def test_free_response_is_that_of_another_initial_state(dt, accuracy):
    t = np.arange(0.0, 3.0, dt)
    base = declared().equations(TRUE)
    x = pse.simulate(base, [0.3, 0.0], t, force, tolerance=1e-11)
    moved = pse.simulate(base, [0.3 + 1e-5, 0.0], t, force, tolerance=1e-11) - x
    slope = jacobian(base, np.column_stack([x, force(t), t]), np.ones(2))[None]
    free, _ = respond(slope, np.zeros((1, len(t), 2, 1)), dt, np.ones(2), keep=1)
    largest = np.abs(moved).max()
    assert 1e-5 * free[0, :, 0].reshape(-1, 2) == pytest.approx(moved, abs=accuracy * largest)


def test_free_response_neither_grows_nor_fades_with_seven_samples_a_period():
    n, frequency = 150, 2.0 * np.pi / 7.0  # radians per sample
    slope = np.tile([[0.0, frequency], [-frequency, 0.0]], (1, n, 1, 1))
    free, _ = respond(slope, np.zeros((1, n, 2, 1)), 1.0, np.ones(2), keep=1)
    sizes = np.linalg.norm(free.reshape(n, 2, 2), axis=1)
    assert np.all(np.abs(sizes - 1.0) < 0.1)


def test_jacobian_is_the_derivative():
    z = np.random.default_rng(0).normal(size=(50, 4))
    found = jacobian(declared().equations(TRUE), z, np.ones(2))
    expected = np.zeros((50, 2, 2))
    expected[:, 0, 1] = 1.0
    expected[:, 1, 0] = -40.0 - 36.0 * z[:, 0] ** 2
    expected[:, 1, 1] = -0.8
    assert found == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("speed", [0.0, 1e-7, -1e-7, 1.5e-6, -1.5e-6, 1e-6, -1e-6, 2.0, -2.0])
def test_jacobian_leaves_out_the_jump_of_friction(speed):
    equations = pse.DeclaredModel({"q": "v", "v": "-4*q - 0.5*v - 3*sgn(v)"}).design().equations([])
    found = jacobian(equations, np.array([[0.2, speed, 0.0]]), np.ones(2))
    assert found[0] == pytest.approx(np.array([[0.0, 1.0], [-4.0, -0.5]]), abs=1e-6)


def test_jacobian_keeps_the_shape_of_the_rows():
    part = segments([clean()])
    assert slopes(part).shape == (*part.z.shape[:2], 2, 2)


def test_model_that_leaves_nothing_to_fit_has_a_jacobian_of_zeros():
    equations = pse.DeclaredModel({"q": "0", "v": "0"}).design().equations([])
    assert not jacobian(equations, np.ones((3, 3)), np.ones(2)).any()


@pytest.mark.parametrize("sizes", [(1500,), (700, 400), (900, 100, 250), (40, 3000), (32, 32)])
def test_segments_have_one_length_and_never_cross_from_one_record_into_the_next(sizes):
    records = [clean(n, offset=100.0 * k) for k, n in enumerate(sizes)]
    part = segments(records)
    assert len(part.places) == len(part.z)
    for (index, start), z, x_dot in zip(part.places, part.z, part.x_dot, strict=True):
        rows = slice(start, start + len(z))
        assert np.array_equal(z, variables_of(records[index])[rows])
        assert np.array_equal(x_dot, records[index].x_dot[rows])
    assert {index for index, _ in part.places} == set(range(len(sizes)))


def test_segments_cover_the_record_but_for_a_rest():
    part = segments([clean(1500)])
    assert 14 <= len(part.z) <= 16
    assert part.z.shape[0] * part.z.shape[1] >= 1500 - part.z.shape[1]


def test_segments_of_a_long_record_are_shortened_and_spread_over_it():
    record = clean(200)
    many = pse.Record(
        t=0.01 * np.arange(60_000),
        x=np.tile(record.x, (300, 1)),
        x_dot=np.tile(record.x_dot, (300, 1)),
        u=np.tile(record.u, (300, 1)),
    )
    part = segments([many])
    assert part.z.shape[0] * part.z.shape[1] <= 24_000
    assert part.places[-1][1] > 0.9 * 60_000
    every = segments([many], max_rows=None)
    assert every.z.shape[0] * every.z.shape[1] > 0.9 * 60_000


@pytest.mark.parametrize(
    ("sizes", "expected"),
    [
        ((1600,), np.arange(16) // 2),
        ((800, 800), np.arange(16) // 2),
        ((400, 400, 800), [0] * 4 + [1] * 4 + [2] * 8),
    ],
)
def test_folds_are_whole_records_where_there_are_three(sizes, expected):
    records = [clean(n) for n in sizes]
    np.testing.assert_array_equal(segments(records).folds, expected)


def test_many_records_share_eight_folds():
    folds = segments([clean(64)] * 20).folds
    assert len(np.unique(folds)) == 8
    assert np.all(np.diff(folds) >= 0)


def test_same_pieces_of_a_twin():
    record, twin = clean(), clean(start=(-0.2, 1.0))
    part = segments([record]).of([twin])
    again = segments([twin])
    assert np.array_equal(part.z, again.z)
    assert np.array_equal(part.x_dot, again.x_dot)
    # The rows of a twin are weighed like those of the record.
    assert np.array_equal(part.state_scale, segments([record]).state_scale)


def test_column_without_a_finite_value_takes_no_part_in_the_spectral_view():
    part = segments([clean()])
    bad = pse.DeclaredModel({"q": "log(q)", "v": 0}).sides[0].known
    grams = spectral_grams(part, declared(), [*declared().columns, in_state("bad", bad, 1, 2)])
    assert np.all(np.isfinite(grams))
    assert not grams[:, 4].any()
    total = np.delete(np.delete(grams.sum(axis=0), 4, axis=0), 4, axis=1)
    assert solve(total[:-1, :-1], total[:-1, -1]) == pytest.approx(TRUE, rel=1e-6)


def test_unstable_model_does_not_drown_the_simulation_view():
    part = segments([clean()])
    wild = slopes(part, np.array([-4000.0, -5.0, 0.0, 1.0]))
    grams = view_grams(part, declared(), declared().columns, wild)["simulation"]
    assert np.all(np.isfinite(grams))
    total = grams.sum(axis=0)
    assert solve(total[:-1, :-1], total[:-1, -1]) == pytest.approx(TRUE, rel=1e-4)


def test_solve_does_not_mind_columns_of_very_different_size():
    rows = np.random.default_rng(0).normal(size=(100, 3)) * [1e-9, 1.0, 1e9]
    coef = np.array([2e9, -3.0, 4e-9])
    assert solve(rows.T @ rows, rows.T @ (rows @ coef)) == pytest.approx(coef, rel=1e-6)


def test_solve_shares_a_coefficient_among_equal_columns_instead_of_failing():
    rows = np.random.default_rng(0).normal(size=(100, 1))[:, [0, 0]]
    coef = solve(rows.T @ rows, rows.T @ rows[:, 0])
    assert coef == pytest.approx([0.5, 0.5], rel=1e-4)


def test_solve_gives_a_column_of_zeros_no_coefficient():
    assert solve(np.diag([4.0, 0.0]), np.array([8.0, 0.0])) == pytest.approx([2.0, 0.0])


def test_band_of_a_record_that_the_user_smoothed_ends_with_its_power():
    t = 0.01 * np.arange(2000)
    x = np.column_stack([np.sin(3.0 * t), 3.0 * np.cos(3.0 * t)])
    slow = pse.Record(t=t, x=x, x_dot=np.column_stack([x[:, 1], -9.0 * x[:, 0]]))
    assert segments([slow]).cutoff == pytest.approx(8 / (125 * 0.01))  # a few frequencies stay
    noise = np.random.default_rng(0).standard_normal((2000, 2))
    raw = pse.Record(t=t, x=x, x_dot=slow.x_dot + 3.0 * noise)
    assert segments([raw]).cutoff > 45.0
    prepared = pse.prepare(t, x[:, 0], cutoff=5.0)
    assert 2.0 < segments([prepared]).cutoff <= 5.0
