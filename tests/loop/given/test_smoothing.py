"""Records of the user whose derivatives were smoothed more than their states."""

import numpy as np
import pytest
from loop_systems import multisine
from scipy.integrate import solve_ivp
from scipy.signal import savgol_filter

import pysindy_evolve as pse
from pysindy_evolve.loop.given.smoothing import with_own_slopes

DT = 0.01
LINEAR = pse.DeclaredModel({"q": "v", "v": "b*F - c*v - k*q"}, inputs=["F"])
CUBIC = pse.DeclaredModel({"q": "v", "v": "b*F - c*v - k*q - h*q**3"}, inputs=["F"])


def smoothed(width, seed=0, *, cubic=0.0, sign=0.0):
    """Record an oscillator of 1 Hz as many do: position and derivatives by Savitzky and Golay."""
    force = multisine(6.0, seed, (0.1, 1.5))
    t = np.arange(4000) * DT

    def rates(t, x):
        friction = sign * np.tanh(x[1] / 1e-3)
        return [x[1], force(t)[0] - 0.8 * x[1] - 40.0 * x[0] - cubic * x[0] ** 3 - friction]

    step = DT / 4 if sign else np.inf
    q = solve_ivp(rates, (0.0, t[-1]), [0.0, 0.0], t_eval=t, rtol=1e-7, max_step=step).y[0]
    q = q + 0.01 * q.std() * np.random.default_rng(seed).standard_normal(t.size)
    s = [savgol_filter(q, width, 3, deriv=k, delta=DT) for k in range(3)]
    x, x_dot = np.column_stack(s[:2]), np.column_stack(s[1:])
    return pse.Record(t=t, x=x, x_dot=x_dot, u=force(t))


def test_a_second_derivative_that_falls_short_is_taken_anew():
    record = smoothed(31)
    with pytest.warns(UserWarning, match=r"smoothed too much\. They are taken anew"):
        (made,), _, shown = with_own_slopes(LINEAR.design(), [record], [])
    cutoff = made.preparation.cutoff
    assert shown
    wave = np.sin(2 * np.pi * cutoff * record.t)
    bend = savgol_filter(wave, 31, 3, deriv=2, delta=DT)
    gain = -(bend @ wave) / (wave @ wave) / (2 * np.pi * cutoff) ** 2
    assert gain == pytest.approx(0.85, abs=0.03)


def test_derivatives_that_are_slopes_stay_as_they_are():
    t = np.arange(4000) * DT
    record = pse.prepare(t, multisine(1.0, 0)(t))
    own = pse.Record(t=record.t, x=record.x, x_dot=record.x_dot)
    design = pse.DeclaredModel({"q": "v", "v": "-c*v - k*q"}).design()
    train, _, shown = with_own_slopes(design, [own], [])
    assert train == [own]
    assert shown


def test_a_derivative_from_a_sensor_of_its_own_stays_as_it_is():
    t, rng = np.arange(4000) * DT, np.random.default_rng(0)
    record = pse.prepare(t, multisine(1.0, 0)(t))
    noise = 0.1 * record.x_dot.std(axis=0) * rng.standard_normal(record.x_dot.shape)
    own = pse.Record(t=record.t, x=record.x, x_dot=record.x_dot + noise)
    design = pse.DeclaredModel({"q": "v", "v": "-c*v - k*q"}).design()
    assert with_own_slopes(design, [own], [])[0] == [own]


def test_the_held_out_record_does_not_choose_the_cutoff():
    made = []
    for other in (smoothed(15, 1), smoothed(61, 1)):
        with pytest.warns(UserWarning, match="smoothed too much"):
            (train,), (test,), _ = with_own_slopes(LINEAR.design(), [smoothed(31)], [other])
        made += [train.preparation.cutoff, test.preparation.cutoff]
    assert len(set(made)) == 1


@pytest.mark.parametrize("width", [pytest.param(31, marks=pytest.mark.slow), 61])
def test_nothing_is_missing_in_an_oscillator_that_was_smoothed(width):
    with pytest.warns(UserWarning, match="smoothed too much"):
        report = pse.close_loop(LINEAR, smoothed(width), test=smoothed(width, 1), random_state=0)
    assert not report.effects
    assert report.before.simulation_error[0] < 3.0
    assert report.after.parameters["k"] == pytest.approx(40.0, rel=0.03)


@pytest.mark.slow
def test_friction_is_found_under_the_smoothing():
    train, test = smoothed(31, sign=0.8), smoothed(31, 1, sign=0.8)
    with pytest.warns(UserWarning, match="smoothed too much"):
        report = pse.close_loop(LINEAR, train, test, operators=(), random_state=0)
    assert [effect.name for effect in report.effects] == ["Coulomb friction"]


def test_no_effect_is_sought_where_the_motion_is_faster_than_what_is_left():
    train, test = smoothed(41, cubic=60.0), smoothed(41, 1, cubic=60.0)
    with pytest.warns(UserWarning, match="so no effect is looked for"):
        report = pse.close_loop(CUBIC, train, test, operators=(), random_state=0)
    assert not report.effects
    assert "No effect was looked for: the records are smoothed" in " ".join(str(report).split())


def averaged(seed):
    """Record a swing as many do: moving averages, and differences of them once more."""
    force, rng = multisine(25.0, seed, (0.1, 2.5)), np.random.default_rng(seed)
    t = np.arange(5000) * 0.004

    def rates(t, x):
        return [x[1], force(t)[0] - 1.5 * x[1] - 50.0 * x[0] + 3.0]

    def smooth(y):
        return np.convolve(y, np.ones(9) / 9.0, "same")

    q = solve_ivp(rates, (0.0, t[-1]), [0.0, 0.0], t_eval=t, rtol=1e-8, max_step=0.004).y[0]
    q = q + 1e-4 * rng.standard_normal(t.size)
    v = smooth(np.gradient(q, 0.004))
    x, x_dot = np.column_stack([q, v]), np.column_stack([v, smooth(np.gradient(v, 0.004))])
    inside = slice(30, -30)
    return pse.Record(t=t[inside], x=x[inside], x_dot=x_dot[inside], u=force(t)[inside])


@pytest.mark.slow
def test_nothing_is_missing_where_moving_averages_take_off_a_hundredth():
    """A mode of the second order was named, which explained what the averages had taken."""
    model = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F + o"}, inputs=["F"])
    with pytest.warns(UserWarning, match="smoothed too much"):
        report = pse.close_loop(model, averaged(0), averaged(1), operators=(), random_state=0)
    assert not report.effects
    assert report.after.parameters["k"] == pytest.approx(50.0, rel=0.01)
