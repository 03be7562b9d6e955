"""Inputs that act through a function of them."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.signals.acting import InputFunction
from pysindy_evolve.signals.zero_order_hold import acting_through

T = np.arange(0.0, 60.0, 0.1)
STEPS = np.random.default_rng(0).choice([0.5, 0.7, 0.9, 1.1], 40).repeat(15)


def square(u):
    return u**2


def signed(u):
    return u * np.abs(u)


SQUARE = InputFunction(square, 0.5, 1.1)


def plain(u):
    return u


@pytest.mark.parametrize(
    ("function", "low", "high"),
    [(square, 0.0, 2.0), (square, -2.0, 2.0), (signed, -2.0, 2.0), (np.sqrt, 0.0, 2.0)],
)
def test_without_a_change_an_input_stays_as_it_is(function, low, high):
    one = InputFunction(function, low, high)
    u = np.linspace(low, high, 101)
    assert one.is_invertible
    assert one.after(plain, u, u) == pytest.approx(u, abs=1e-3)


def test_what_is_changed_is_the_function():
    found = SQUARE.after(lambda values: 0.5 * (values + 1.0), STEPS, STEPS)
    assert found**2 == pytest.approx(0.5 * (STEPS**2 + 1.0), abs=1e-6)


def test_a_function_that_turns_close_to_the_range_is_followed_less_far():
    one = InputFunction(lambda u: (u - 0.45) ** 2, 0.6, 1.2)
    u = np.linspace(0.6, 1.2, 31)
    assert one.after(plain, u, u) == pytest.approx(u, abs=1e-3)


@pytest.mark.parametrize("function", [np.sin, np.cos, np.sign, np.round])
def test_a_function_that_turns_or_jumps_has_no_inverse(function):
    assert not InputFunction(function, -0.3, 6.0).is_invertible


def clipped(u):
    return 0.5 * (np.abs(u + 1.0) - np.abs(u - 1.0))  # constant but for rounding


def without_play(u):
    return u - clipped(u)


@pytest.mark.parametrize("function", [clipped, without_play, lambda u: -clipped(u)])
def test_a_clip_or_a_dead_zone_acts_before_a_mean_is_taken(function):
    """Which of the inputs on a plateau stands there does not matter."""
    one, u = InputFunction(function, -2.0, 2.0), np.array([-1.9, -0.8, 0.1, 0.9, 1.6])
    halved = one.after(lambda values: 0.5 * values, u, u)
    assert one.is_invertible
    assert function(halved) == pytest.approx(0.5 * function(u), abs=0.01)


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("order", [1, 2])
def test_the_low_pass_and_the_hold_are_those_of_the_function(held, order):
    """A record with the square as input is the same as one whose input acts through its square."""
    settings = {"order": order, "cutoff": 2.0, "decimate": 1, "held": held}
    given = pse.prepare(T, np.sin(T), STEPS, **settings)
    wanted = pse.prepare(T, np.sin(T), STEPS**2, **settings)
    found = acting_through(given, {0: SQUARE})
    assert found.u**2 == pytest.approx(wanted.u, abs=1e-4)
    assert given.u**2 != pytest.approx(wanted.u, abs=0.05)
    assert found.held == given.held


def test_a_record_that_goes_further_is_followed_there():
    """A model that was found may be run with other inputs."""
    further = pse.prepare(T, np.sin(T), 3.0 * STEPS, order=2, cutoff=2.0, decimate=1)
    found = acting_through(further, {0: SQUARE})
    assert found.u**2 == pytest.approx(further.lowpass(9.0 * STEPS**2)[:, None], abs=2e-3)
    turning = InputFunction(np.sin, 0.5, 1.1)
    assert turning.is_invertible
    assert acting_through(further, {0: turning}).u == pytest.approx(further.u)


def test_what_remembers_the_input_comes_before_the_function():
    given = pse.prepare(T, np.sin(T), STEPS, order=2, cutoff=2.0, decimate=1)
    late = np.roll(STEPS, 3)
    found = acting_through(given, {0: SQUARE}).with_inputs(lambda t, u: np.roll(u, 3, axis=0))
    assert found.u**2 == pytest.approx(found.lowpass(late**2)[:, None], abs=1e-4)


def test_a_record_without_raw_inputs_stays():
    record = pse.Record(t=T, x=np.sin(T), x_dot=np.cos(T), u=STEPS)
    assert acting_through(record, {0: SQUARE}) is record
