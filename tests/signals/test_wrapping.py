"""Angles that start again after a turn are refused; what only looks like them is not."""

import numpy as np
import pytest

from pysindy_evolve.signals import prepare

T = np.arange(0.0, 20.0, 0.005)


def turning(speed=8.0, change=3.0):
    return np.cumsum(speed + change * np.sin(0.7 * T)) * 0.005


def swinging():
    return 0.3 * np.sin(2.0 * T)


ANGLES = {
    "turns": turning(),
    "turns back": -turning(),
    "turns fast": turning(200.0),
    "goes to and fro": 5.0 * np.sin(0.6 * T),
    "swings about where it wraps": swinging(),
    "turns once": turning(0.4, 0.1),
}


@pytest.mark.parametrize("angle", ANGLES.values(), ids=ANGLES)
@pytest.mark.parametrize("step", [0.0, 0.36, 5.0], ids="counts of {} degrees".format)
def test_an_angle_in_degrees_that_wraps_is_refused_with_the_way_out(angle, step):
    degrees = np.degrees(angle)
    degrees = step * np.round(degrees / step) if step else degrees
    message = r"a jump from .* a whole turn\. .*unwrap\(column, period=360\).*--unwrap NAME=360\."
    with pytest.raises(ValueError, match=message):
        prepare(T, np.mod(degrees, 360.0))
    assert prepare(T, degrees).n_states == 2


@pytest.mark.parametrize("angle", ANGLES.values(), ids=ANGLES)
def test_an_angle_in_radians_that_wraps_at_half_a_turn_is_refused(angle):
    noisy = angle + np.pi + 0.01 * np.random.default_rng(0).standard_normal(len(T))
    columns = np.column_stack([np.sin(T), np.angle(np.exp(1j * noisy))])
    with pytest.raises(ValueError, match=r"column 1, a whole turn\. .*2\*np\.pi\).*=6\.28318"):
        prepare(T, columns)


def relaxation(stiffness=30.0):
    x, y, rows = 2.0, 0.0, []
    for _ in T:
        for _ in range(50):  # van der Pol in the plane of Lienard, whose jumps take microseconds
            x, y = x + 1e-3 * stiffness * (x - x**3 / 3 - y), y + 1e-3 / stiffness * x
        rows.append(x)
    return np.array(rows)


def spikes(column, size):
    column = column.copy()
    column[500::700] += size
    return column


SQUARE = np.where(np.sin(1.3 * T) > 0, 1.0, -1.0)
NOISE = np.random.default_rng(1).standard_normal(len(T))
BOUNCES = np.mod(T, 1.3) - 0.65
OTHERS = {
    "square": np.pi * SQUARE,
    "noisy square": np.pi * SQUARE + 0.01 * NOISE,
    "noisier square": 170 * SQUARE + 2 * NOISE,
    "square that sags": 180 * SQUARE * np.exp(-0.04 * np.mod(T, np.pi / 1.3)),
    "one step": np.where(T > 10, 360.0, 0.0) + 0.3 * np.sin(T),
    "relaxation": np.pi * relaxation() / 2.0,
    "spikes": spikes(np.sin(T), 2 * np.pi),
    "spikes of a turn": spikes(0.3 * np.sin(T) - 180.0, 360.0),
    "speed of a ball that loses": -9.7 * BOUNCES * np.exp(-0.05 * np.floor(T / 1.3)),
    "another saw": 300.0 * BOUNCES / 1.3,
    "noise": NOISE,
    "coarse": 90.0 * np.round(2.0 * np.sin(T)),
    "a sine over a turn": 180.0 * np.sin(2.0 * T),
    "a fast sine over a turn": np.pi * np.sin(300.0 * T),
}


@pytest.mark.parametrize("column", OTHERS.values(), ids=OTHERS)
def test_other_signals_of_the_range_of_a_turn_are_no_angles_that_wrap(column):
    assert prepare(T, column, order=1).n_states == 1


@pytest.mark.parametrize("speed", [0.4, -0.8, 8.0, -30.0, 200.0])
@pytest.mark.parametrize("noise", [0.0, 0.001, 0.01])
@pytest.mark.parametrize("count", [0.0, 0.36, 10.0], ids="counts of {} degrees".format)
def test_an_angle_that_wraps_is_refused_at_any_speed_with_noise_and_counts(speed, noise, count):
    degrees = np.degrees(speed * T + 0.3 + noise * NOISE)
    degrees = count * np.round(degrees / count) if count else degrees
    with pytest.raises(ValueError, match=r"a whole turn\. .*--unwrap"):
        prepare(T, np.mod(degrees, 360.0))


def held(levels, dwell=20):
    return np.resize(np.repeat(np.asarray(levels, dtype=float), dwell), len(T))


DRAWN = np.random.default_rng(2)
STAIRS = {
    "up, and from the first again": held(np.arange(0, 361, 60)),
    "down, and from the last again": held(np.arange(300, -1, -60)),
    "up, then in one step down": held([0, 90, 180, 270, 360, 0]),
    "steps up and down of equal size": held([0, 40, 0, 320, 360, 320, 0, 40]),
    "levels at random": held(60 * DRAWN.integers(0, 7, 500)),
    "set points at random": held(DRAWN.uniform(0.0, 2.0 * np.pi, 500), 35),
    "set points that change fast": held(DRAWN.uniform(0.0, 360.0, 2000), 2),
    "gears": held([0, 1, 2, 3, 4, 5, 6, 0, 1, 2, 1, 6, 5, 0]),
    "a coarse count that is reset": held(np.pi / 6.0 * np.arange(12)),
    "square as high as a turn": held([0, 360]),
    "square on two levels": held([0, 360, 0, 360, 120, 360]),
    "no memory": DRAWN.uniform(0.0, 360.0, len(T)),
}


@pytest.mark.parametrize("noise", [0.0, 0.002], ids="noise {}".format)
@pytest.mark.parametrize("column", STAIRS.values(), ids=STAIRS)
def test_staircases_are_no_angles_that_wrap(column, noise):
    noisy = column + noise * np.ptp(column) * NOISE
    assert prepare(T, noisy, order=1).n_states == 1


def test_what_rests_once_it_jumped_back_is_no_angle_that_wraps():
    ramp = np.repeat(np.arange(0.0, 360.0, 10.0), 20)
    rest = np.zeros(len(T) - len(ramp))
    assert prepare(T, np.r_[ramp, rest], order=1).n_states == 1
    with pytest.raises(ValueError, match="a whole turn"):
        prepare(T, np.r_[ramp, ramp, rest[len(ramp) :]])
