"""Sensors that end before the machine does: rows are marked, and the filter meets no kinks."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.signals.clipping import bridged, sensor_limits

T = np.arange(0.0, 40.0, 0.01)
DRIVE = 2.0 * np.pi * 0.4


def motion(noise=1e-3, seed=0):
    """Two sines, and the noise of the sensor."""
    noise = noise * np.random.default_rng(seed).standard_normal(len(T))
    return np.sin(DRIVE * T) + 0.4 * np.sin(2.7 * DRIVE * T + 1.0) + noise


def acceleration(t):
    return -(DRIVE**2) * (np.sin(DRIVE * t) + 0.4 * 2.7**2 * np.sin(2.7 * DRIVE * t + 1.0))


@pytest.mark.parametrize("ends", [(-9.0, 0.9), (-0.9, 9.0), (-0.9, 0.8)])
def test_ends_at_which_readings_heap_are_the_limits_of_the_sensor(ends):
    limits = sensor_limits(np.clip(motion(), *ends)[:, None])[:, 0]
    assert limits[0] == (ends[0] if ends[0] > -9.0 else -np.inf)
    assert limits[1] == (ends[1] if ends[1] < 9.0 else np.inf)


@pytest.mark.parametrize("step", [0.3, 0.1, 0.03, 0.01, 0.003])
@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_crests_of_a_rounded_signal_are_no_limits(step, noise):
    rounded = np.round(motion(noise) / step) * step
    assert not np.isfinite(sensor_limits(rounded[:, None])).any()


def test_a_machine_that_rests_at_its_highest_place_has_no_limit():
    noise = 1e-3 * np.random.default_rng(1).standard_normal(len(T))
    resting = np.minimum(motion(0.0), 0.9)
    assert not np.isfinite(sensor_limits((resting + noise)[:, None])).any()


@pytest.mark.parametrize("step", [1e-2, 1e-3, 1e-4])
def test_ends_at_which_a_machine_comes_to_rest_are_no_limits(step):
    phase = T / 4.0 % 1.0  # out, dwell, back, dwell
    way = np.clip(np.minimum(phase, 0.55 - phase) / 0.2, 0.0, 1.0)
    smooth = way**3 * (10.0 - 15.0 * way + 6.0 * way**2)
    rounded = np.round(smooth / step) * step
    assert not np.isfinite(sensor_limits(rounded[:, None])).any()


def test_rest_before_the_machine_starts_is_no_limit():
    y = np.where(T < 5.0, 0.0, 1.0 - np.cos(DRIVE * (T - 5.0)) + 1e-3 * (motion() - motion(0.0)))
    assert not np.isfinite(sensor_limits(np.maximum(y, 0.0)[:, None])[0])


@pytest.mark.parametrize("begins", [0.0, 3.0])
def test_a_table_that_stops_elsewhere_does_not_end_at_its_highest_stop(begins):
    """It comes there once, which does not tell how it slows down."""
    stops = np.interp(T - begins, [0, 3, 8, 9, 14, 15, 50], [0, 80, 80, 30, 30, 10, 70])
    readings = 0.01 * np.round(stops / 0.01)
    assert not np.isfinite(sensor_limits(readings[:, None])).any()
    ended = np.where(readings == 30.0, readings + 0.1 * motion(0.0), readings)
    assert sensor_limits(ended[:, None])[1] == 80.0


def test_second_derivative_is_right_beside_the_gaps():
    record = pse.prepare(T, np.minimum(motion(), 0.9))
    seen = record.seen.all(axis=1)
    assert 0.5 < seen.mean() < 0.9
    miss = (record.x_dot[:, 1] - acceleration(record.t))[seen]
    assert miss.std() < 0.03 * acceleration(T).std()
    blind = pse.prepare(T, np.minimum(motion(), 0.9), limits=None)
    assert blind.seen is None
    assert (blind.x_dot[:, 1] - acceleration(blind.t)).std() > 0.3 * acceleration(T).std()


def test_cutoff_and_noise_are_those_of_the_motion_and_not_of_the_kinks():
    whole = pse.prepare(T, motion()).preparation
    clipped = pse.prepare(T, np.clip(motion(), -0.9, 0.9)).preparation
    assert clipped.cutoff == pytest.approx(whole.cutoff, rel=0.25)
    assert clipped.noise == pytest.approx(whole.noise, rel=0.25)


def test_bridge_stays_beyond_the_limit_and_leaves_all_other_readings_alone():
    y = np.clip(motion(), -0.9, 0.9)[:, None]
    whole = bridged(y, np.array([[-0.9], [0.9]]), 0.01, 4.0)
    inside = np.abs(y) < 0.9
    assert np.array_equal(whole[inside], y[inside])
    assert (np.abs(whole[~inside]) >= 0.9).all()
    ends = np.zeros(len(y), dtype=bool)
    ends[[0, -1]] = True
    assert np.abs(whole - motion(0.0)[:, None])[~ends].max() < 0.1


def test_gap_at_an_end_of_the_record_is_not_bridged():
    y = np.minimum(T + 1e-3 * motion(), 30.0)[:, None]
    whole = bridged(y, np.array([[-np.inf], [30.0]]), 0.01, 4.0)
    assert np.array_equal(whole[-500:], y[-500:])


def test_very_long_gap_of_a_finely_sampled_record_has_a_bridge():
    t = np.linspace(-1.0, 1.0, 50_001)
    y = np.minimum(1.0 - np.abs(t) + 0.1 * np.sin(40.0 * t), 0.7)[:, None]
    whole = bridged(y, np.array([[-np.inf], [0.7]]), 1e-4, 0.5)
    assert np.ptp(whole) <= 2.0 * np.ptp(y)
    assert np.array_equal(whole[y < 0.7], y[y < 0.7])


def test_what_is_prepared_alike_passes_the_same_sensor():
    record = pse.prepare(T, np.minimum(motion(), 0.9))
    twin = record.preparation.apply(T, motion(seed=1))
    assert twin.seen.mean() == pytest.approx(record.seen.mean(), abs=0.03)
    again = pse.prepare(T, np.minimum(motion(), 0.9), **record.preparation.settings)
    assert np.array_equal(again.x, record.x)
    assert np.array_equal(record[100:200].seen, record.seen[100:200])


def test_limits_may_be_given():
    record = pse.prepare(T, np.minimum(motion(), 0.9), limits=(-np.inf, 0.9))
    assert np.array_equal(record.x, pse.prepare(T, np.minimum(motion(), 0.9)).x)


@pytest.mark.parametrize("limits", ["none", 3.0, (1.0, -1.0), (0.0, 1.0, 2.0)])
def test_limits_that_are_none_are_refused(limits):
    with pytest.raises(ValueError, match=r"prepare\(limits=\.\.\.\) must be"):
        pse.prepare(T, motion(), limits=limits)


def test_record_refuses_rows_seen_of_another_shape():
    with pytest.raises(ValueError, match=r"Record\(seen=\.\.\.\) must be of the shape of x"):
        pse.signals.Record(t=T, x=motion(), x_dot=motion(), seen=np.ones((3, 1), dtype=bool))
