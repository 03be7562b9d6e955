"""The defaults on records of real hardware show what is missing there."""

import numpy as np

from pysindy_evolve.signals import (
    choose_windows,
    prepare,
    project,
)

from .closeness import nrmse


def held_out_error(train, test, terms):
    """Derivative NRMSE %, windowed, of a least-squares fit on train judged on test."""
    windows = choose_windows(train)

    def sides(record):
        columns = np.column_stack([*terms(record), record.x_dot[:, 1]])
        return np.split(project(columns, windows), [-1], axis=1)

    theta, target = sides(train)
    coef = np.linalg.lstsq(theta, target, rcond=None)[0]
    theta, target = sides(test)
    return 100 * nrmse(theta @ coef, target)


def test_defaults_show_friction_and_offset_of_a_positioning_axis(data_dir):
    with np.load(data_dir / "emps" / "emps.npz") as d:
        train = prepare(d["train_t"], d["train_q"], d["train_force"])
        test = prepare(d["test_t"], d["test_q"], d["test_force"], **train.preparation.settings)
    declared = held_out_error(train, test, lambda r: [r.u, r.x[:, 1]])
    right = held_out_error(
        train, test, lambda r: [r.u, r.x[:, 1], np.sign(r.x[:, 1]), np.ones(len(r))]
    )
    assert declared > 20.0
    assert right < 8.0


def test_defaults_show_dry_friction_of_a_pendulum(data_dir):
    with np.load(data_dir / "pendulum_multiarm" / "single.npz") as d:
        t, angle = d["t"], d["theta"]
    n = int(0.6 * t.size)
    train = prepare(t[:n], angle[:n])
    test = prepare(t[n:], angle[n:], **train.preparation.settings)
    declared = held_out_error(train, test, lambda r: [np.sin(r.x[:, 0]), r.x[:, 1]])
    right = held_out_error(
        train, test, lambda r: [np.sin(r.x[:, 0]), r.x[:, 1], np.sign(r.x[:, 1])]
    )
    assert declared > 0.5
    assert right < 0.4


def test_defaults_show_the_hardening_spring_of_an_electronic_oscillator(data_dir):
    with np.load(data_dir / "silverbox" / "silverbox.npz") as d:
        y, u, dt = d["y"][40650:127400], d["u"][40650:127400] - d["u"].mean(), 1 / d["fs"]
    n = int(0.75 * y.size)
    times = np.arange(y.size) * dt
    train, test = (prepare(times[rows], y[rows], u[rows]) for rows in (slice(n), slice(n, None)))
    declared = held_out_error(train, test, lambda r: [r.u, *r.x.T])
    right = held_out_error(train, test, lambda r: [r.u, *r.x.T, r.x[:, 0] ** 3, np.ones(len(r))])
    assert declared > 3.0
    assert right < 1.33
