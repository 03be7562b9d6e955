"""Twins: as noisy and as colored as the record, and nothing missing in them."""

import numpy as np
import pytest
from loop_systems import equations_of, measured

import pysindy_evolve as pse
from pysindy_evolve.loop.twins import TwinMaker, shuffle_signs

SPRING = {"q": "v", "v": "-40*q - 0.8*v + F"}
RUBBED = {"q": "v", "v": "-40*q - 0.8*v + F - 2*sgn(v)"}


def colored(n=4000, seed=0):
    """Noise with a memory of some ten samples."""
    white = np.random.default_rng(seed).standard_normal(n + 40)
    return np.convolve(white, np.ones(20) / 20, mode="valid")[:n, None]


def maker_of(truth, model=SPRING, **options):
    record = measured(truth, duration=20.0, **options)
    equations = equations_of(model, ("F",))
    return TwinMaker.of(equations, equations, [record]), record


def residual_of(record, model=SPRING):
    return record.x_dot - equations_of(model, ("F",)).evaluate(record.x, record.u, record.t)


def test_shuffled_residual_is_on_average_unrelated_to_the_one_it_came_from():
    residual = colored()
    correlations = [
        np.corrcoef(shuffle_signs(residual, np.random.default_rng(seed))[:, 0], residual[:, 0])[
            0, 1
        ]
        for seed in range(200)
    ]
    # Without bias the mean of 200 is within three of its standard errors.
    assert abs(np.mean(correlations)) < 3 * np.std(correlations) / np.sqrt(200)


def test_shuffled_residual_is_no_function_of_the_state_any_more():
    t = 0.01 * np.arange(4000)
    v = np.sin(3.0 * t)
    residual = np.sign(v)[:, None]
    gains = [
        shuffle_signs(residual, np.random.default_rng(seed))[:, 0] @ np.sign(v) / 4000
        for seed in range(100)
    ]
    assert abs(np.mean(gains)) < 3 * np.std(gains) / 10
    assert np.std(gains) < 0.5  # the whole record never just changes its sign


def test_shuffled_residual_stays_as_strong_where_it_was_strong():
    residual = colored() * np.where(np.arange(4000) < 2000, 0.1, 3.0)[:, None]
    power = np.mean(
        [shuffle_signs(residual, np.random.default_rng(seed)) ** 2 for seed in range(100)], axis=0
    )
    for part in (slice(0, 1800), slice(2200, 4000)):
        assert power[part].mean() == pytest.approx(np.mean(residual[part] ** 2), rel=0.25)


def test_shuffled_residual_keeps_its_color():
    residual = colored()
    lags = [1, 3, 5, 10]

    def correlation(column):
        return np.array([np.mean(column[lag:] * column[:-lag]) for lag in lags])

    mean = np.mean(
        [correlation(shuffle_signs(residual, np.random.default_rng(s))[:, 0]) for s in range(100)],
        axis=0,
    )
    assert mean == pytest.approx(correlation(residual[:, 0]), rel=0.25)


def test_columns_are_shuffled_together():
    residual = np.column_stack([colored(), 3.0 * colored()])
    shuffled = shuffle_signs(residual, np.random.default_rng(0))
    assert shuffled[:, 1] == pytest.approx(3.0 * shuffled[:, 0])


@pytest.mark.parametrize("residual", [np.zeros((100, 2)), np.ones((100, 1)), np.zeros((8, 1))])
def test_residual_without_change_is_shuffled_without_harm(residual):
    shuffled = shuffle_signs(residual, np.random.default_rng(0))
    assert shuffled.shape == residual.shape
    assert np.all(np.isfinite(shuffled))


def test_same_seed_makes_the_same_twin_and_another_seed_another():
    maker, _ = maker_of(SPRING)
    first, again, other = (maker.make(np.random.default_rng(seed))[0] for seed in (0, 0, 1))
    assert np.array_equal(first.x, again.x)
    assert np.array_equal(first.x_dot, again.x_dot)
    assert not np.array_equal(first.x_dot, other.x_dot)


def test_twin_has_the_shape_the_times_and_the_input_of_the_record():
    maker, record = maker_of(SPRING)
    (twin,) = maker.make(np.random.default_rng(0))
    assert np.array_equal(twin.t, record.t)
    assert np.array_equal(twin.u, record.u)
    assert twin.x.shape == record.x.shape
    # It moves as the machine did, but its noise is another one.
    spread = record.x.std(axis=0)
    assert np.all(np.sqrt(np.mean((twin.x - record.x) ** 2, axis=0)) < 0.05 * spread)
    assert not np.array_equal(twin.x, record.x)


def test_residual_of_a_twin_is_as_large_as_that_of_the_record():
    maker, record = maker_of(SPRING, noise=2e-3)
    measured_size = residual_of(record).std(axis=0)
    sizes = [residual_of(maker.make(np.random.default_rng(s))[0]).std(axis=0) for s in range(20)]
    assert np.mean(sizes, axis=0)[1] == pytest.approx(measured_size[1], rel=0.2)


def test_effect_that_the_model_lacks_is_not_in_its_twins():
    maker, record = maker_of(RUBBED)
    friction = np.sign(record.x[:, 1])
    assert residual_of(record)[:, 1] @ friction / len(record) < -1.0
    found = [
        residual_of(twin)[:, 1] @ np.sign(twin.x[:, 1]) / len(record)
        for twin in (maker.make(np.random.default_rng(seed))[0] for seed in range(30))
    ]
    assert abs(np.mean(found)) < 3 * np.std(found) / np.sqrt(30) + 0.02
    assert np.median(np.abs(found)) < 0.7


def test_record_of_the_user_without_preparation_has_twins_too():
    _, record = maker_of(SPRING)
    bare = pse.Record(t=record.t, x=record.x, x_dot=record.x_dot, u=record.u)
    equations = equations_of(SPRING, ("F",))
    (twin,) = TwinMaker.of(equations, equations, [bare]).make(np.random.default_rng(0))
    assert np.array_equal(twin.x, bare.x)
    assert not np.array_equal(twin.x_dot, bare.x_dot)


def test_model_that_does_not_follow_the_record_keeps_the_measured_states():
    maker, record = maker_of(SPRING, model={"q": "v", "v": "40*q + F"})
    assert maker.simulated == (None,)
    (twin,) = maker.make(np.random.default_rng(0))
    assert np.array_equal(twin.x, record.x)


def test_part_of_a_record_has_twins_of_that_part():
    record = measured(SPRING, duration=20.0)
    equations = equations_of(SPRING, ("F",))
    last = record.split(0.3)[1]
    (twin,) = TwinMaker.of(equations, equations, [last]).make(np.random.default_rng(0))
    assert np.array_equal(twin.t, last.t)
    assert np.sqrt(np.mean((twin.x - last.x) ** 2)) < 0.05 * last.x.std()


def test_several_records_have_one_twin_each():
    records = [measured(SPRING, duration=d, seed=s) for s, d in enumerate((10.0, 15.0))]
    equations = equations_of(SPRING, ("F",))
    twins = TwinMaker.of(equations, equations, records).make(np.random.default_rng(0))
    assert [len(twin) for twin in twins] == [len(record) for record in records]
