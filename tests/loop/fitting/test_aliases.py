"""What samples show of the steps of held inputs, in states that these drive directly."""

import numpy as np
import pytest
from scipy.linalg import expm

import pysindy_evolve as pse
from pysindy_evolve.hidden_states.memory import DELAY, LAG, Memory
from pysindy_evolve.loop.fitting.aliases import share_of_steps, without_aliases
from pysindy_evolve.loop.given.declared import design_of

DT, N, GAIN = 0.05, 3000, 2.0
DECAY, STIFFNESS = 0.5, 4.0
MOTOR = pse.DeclaredModel({"w": "-a*w + b*u"}, inputs=["u"])
DRIVE = pse.DeclaredModel({"q": "v", "v": "-k*q - a*v + b*u"}, inputs=["u"])
MATRICES = {
    1: (np.array([[-DECAY]]), np.array([[GAIN]])),
    2: (np.array([[0.0, 1.0], [-STIFFNESS, -DECAY]]), np.array([[0.0], [GAIN]])),
}


def levels(seed=0, hold=6):
    return np.repeat(np.random.default_rng(seed).uniform(-3.0, 3.0, N // hold), hold)


def motion(u, delay=0.0, order=1):
    """Return exact samples of a machine whose input is held, and then delayed by so many."""
    whole, part = divmod(delay, 1.0)
    late = np.concatenate([np.full(int(whole) + 1, u[0]), u])
    (a, b), (c, d) = (_step(order, share * DT) for share in (part, 1.0 - part))
    x, out = np.zeros((order, 1)), np.empty(N)
    for k in range(N):
        out[k] = x[0, 0]
        x = c @ (a @ x + b * late[k]) + d * late[k + 1]
    return out


def _step(order, time):
    """Return what a time makes of a state, and of an input that stands."""
    a, b = MATRICES[order]
    grown = expm(time * np.block([[a, b], [np.zeros((1, order + 1))]]))
    return grown[:order, :order], grown[:order, order:]


def prepared(y, u, order=1, noise=0.0, cutoff=None):
    y = y + noise * y.std() * np.random.default_rng(9).standard_normal(N)
    return pse.prepare(DT * np.arange(N), y, u, order=order, held=True, cutoff=cutoff)


def left(record, late=0.0):
    """Return what the true model leaves of the derivative, a share of what it varies by."""
    acting = Memory(DELAY, 0, (late,)).apply(record) if late else record
    error = record.x_dot[:, 0] + DECAY * record.x[:, 0] - GAIN * acting.u[:, 0]
    return error[50:-50].std() / record.x_dot.std()


@pytest.mark.parametrize("delay", [0.0, 0.5, 2.4])
def test_a_state_that_a_held_input_drives_is_smooth_without_its_steps(delay):
    u = levels()
    y = motion(u, delay)
    record = prepared(y, u, cutoff=4.0)
    ((smooth,),) = without_aliases(design_of(MOTOR, [record]), [record])
    late = Memory(DELAY, 0, ((delay + 0.5) * DT,))  # which is all that there would be to it
    plain = late.apply(pse.prepare(DT * np.arange(N), y, u, order=1, cutoff=4.0))
    assert left(smooth, delay * DT) < 0.1 * left(plain)


def test_smooth_inputs_and_positions_stay_as_they_are():
    u = levels()
    position = prepared(motion(u, order=2), u, order=2)
    assert without_aliases(design_of(DRIVE, [position]), [position])[0][0] is position
    smooth = pse.prepare(DT * np.arange(N), motion(u), u, order=1)
    assert without_aliases(design_of(MOTOR, [smooth]), [smooth], [smooth])[1][0] is smooth


def test_an_input_may_rest_in_one_record_and_all_may_be_known():
    u = levels()
    records = [prepared(motion(u), u, cutoff=4.0), prepared(motion(0.0 * u + 1.0), 0.0 * u + 1.0)]
    (smooth,) = without_aliases(design_of(MOTOR, records), records)
    assert all(np.isfinite(one.x).all() and np.isfinite(one.x_dot).all() for one in smooth)
    assert left(smooth[0]) < 1e-3
    known = pse.DeclaredModel({"w": "-0.5*w + 2*u"}, inputs=["u"])
    ((same,),) = without_aliases(design_of(known, records[:1]), records[:1])
    assert same.x == pytest.approx(smooth[0].x, abs=1e-4)


@pytest.mark.parametrize(
    ("memory", "share"),
    [
        (None, 1.0 / 12.0),
        (Memory(DELAY, 0, (3.0 * DT,)), 1.0 / 12.0),  # steps come with samples again
        (Memory(DELAY, 0, (0.5 * DT,)), -1.0 / 24.0),
        (Memory(LAG, 0, (1e-4 * DT,)), 1.0 / 12.0),
        (Memory(LAG, 0, (100.0 * DT,)), 0.0),
    ],
)
def test_what_is_left_of_steps_depends_on_when_they_come_and_on_what_rounds_them_off(memory, share):
    assert share_of_steps(memory, DT) == pytest.approx(share, abs=2e-4)


def test_the_share_of_a_lag_has_no_jump_where_a_series_takes_over():
    shares = [share_of_steps(Memory(LAG, 0, (value * DT,)), DT) for value in (9.99, 10.01)]
    assert shares[0] == pytest.approx(shares[1], rel=0.01)


@pytest.mark.parametrize(
    ("order", "delay"), [pytest.param(1, 2.4, marks=pytest.mark.slow), (2, 0.6)]
)
def test_a_part_of_a_sample_is_a_delay_and_no_lag_besides(order, delay):
    u = levels()
    declared = (MOTOR, DRIVE)[order - 1]
    record = prepared(motion(u, delay, order), u, order, noise=0.001)
    report = pse.close_loop(declared, record, operators=(), random_state=0, n_twins=59)
    (effect,) = report.effects
    assert effect.name == "input delay"
    assert effect.coefficients[0] / DT == pytest.approx(delay, abs=0.01)
    assert report.after.parameters["b"] == pytest.approx(GAIN, rel=2e-3)


@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_a_controller_that_moves_its_output_with_each_sample_makes_no_effect(noise):
    t, rng = DT * np.arange(N), np.random.default_rng(3)
    asked = sum(np.sin(2.0 * np.pi * f * t + k) for k, f in enumerate(np.linspace(0.1, 2.0, 8)))
    w, total, y, u = 0.0, 0.0, np.empty(N), np.empty(N)
    keep = np.exp(-DECAY * DT)
    for k in range(N):
        y[k] = w + noise * rng.standard_normal()
        total += (asked[k] - y[k]) * DT
        u[k] = 3.0 * (asked[k] - y[k]) + total
        w = keep * w + (1.0 - keep) * GAIN / DECAY * u[k]
    record = pse.prepare(t, y, u, order=1, held=True)
    report = pse.close_loop(MOTOR, record, operators=(), random_state=0, n_twins=59)
    assert report.verdict == "complete", str(report)
    assert report.after.parameters["b"] == pytest.approx(GAIN, rel=1e-3)
