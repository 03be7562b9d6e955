"""Runs are held against records through the same low-pass."""

from dataclasses import replace

import numpy as np
import pytest
from loop_systems import equations_of, measured, multisine

import pysindy_evolve as pse
from pysindy_evolve.loop.fitting.trial import converged
from pysindy_evolve.loop.free_runs.variants import Model
from pysindy_evolve.loop.given.band import driven, straightened
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.signals import lowpass

TRUTH = {"q": "v", "v": "-60*q - 40*q**3 - 0.8*v + F"}
RIG = pse.DeclaredModel({"q": "v", "v": "-k*q - k3*q**3 - c*v + b*F"}, inputs=["F"])


def smoothed(sides=TRUTH, cutoff=3.5):
    """A rig without noise, prepared with a cutoff that takes its harmonics off."""
    made = measured(sides, noise=0.0, size=40.0).preparation
    return pse.prepare(made.t, made.y, made.u, cutoff=cutoff)


def missed(record, model, coef, band=True):
    """RMS by which the runs of a true model, begun as well as possible, miss a record."""
    part = segments([record], (1,), 4)
    design = design_of(model, [record])
    trial = Model(design).trial(coef, part.state_scale, part)
    if not band:
        plain = part.of([record])
        trial = replace(trial, part=replace(plain, band=None))
    (trial,) = converged([trial])
    inner = trial.miss[:, 20:-20] / part.state_scale
    return np.sqrt(np.mean(inner**2)), trial.coef


def test_what_a_low_pass_takes_off_a_nonlinear_machine_is_not_missed():
    record, coef = smoothed(), np.array([60.0, 40.0, 0.8, 1.0])
    through, found = missed(record, RIG, coef)
    without, biased = missed(record, RIG, coef, band=False)
    assert through < 0.25 * without
    assert np.abs(found - coef).max() < 0.3 * np.abs(biased - coef).max()


def test_the_answer_of_a_linear_machine_is_low_passed_once():
    linear = {"q": "v", "v": "-60*q - 0.8*v + F"}
    model = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
    coef = np.array([60.0, 0.8, 1.0])
    miss, found = missed(smoothed(linear, cutoff=2.0), model, coef)
    assert miss < 0.005
    assert found == pytest.approx(coef, rel=0.005)


def test_pieces_are_low_passed_as_the_whole_record_is():
    record = smoothed()
    part = segments([record], (1,), 4)
    cutoff = record.preparation.cutoff
    wider = np.column_stack([multisine(0.3, seed, band=(0.1, 6.0))(record.t) for seed in (1, 2)])
    whole = lowpass(wider, record.dt, cutoff)
    length = part.z.shape[1]
    pieces, passed = (
        np.stack([x[row : row + length] for _, row in part.places]) for x in (wider, whole)
    )
    inner = slice(32, -32)  # four periods of the cutoff, where its kernel is over
    off = part.shown(pieces)[:, inner] - passed[:, inner]
    assert np.abs(off).max() < 0.01 * np.abs(pieces - passed).max()


def test_records_that_nobody_prepared_are_held_against_the_runs_themselves():
    record = replace(smoothed(), preparation=None)
    part = segments([record], (1,), 4)
    x = part.z[:, :, :2] + 0.1
    assert np.array_equal(part.shown(x), x)
    assert driven(record) is record
    assert straightened(record) is record


def test_a_run_that_diverges_stays_not_finite():
    part = segments([smoothed()], (1,), 4)
    x = part.z[:, :, :2].copy()
    x[1, 30:] = np.nan
    shown = part.shown(x)
    assert np.isnan(shown[1]).all()
    assert np.isfinite(shown[0]).all()


def test_inputs_of_runs_hold_what_the_record_lost():
    made = measured(TRUTH, noise=0.0).preparation
    u = made.u + 5.0 * np.sin(2 * np.pi * 4.0 * made.t)[:, None]
    record = pse.prepare(made.t, made.y, u, cutoff=3.5)
    rows = np.isin(made.t, record.t)
    lost, left = (np.abs(one.u - u[rows])[30:-30].max() for one in (record, driven(record)))
    assert lost > 3.5
    assert left < 0.1
    whole = pse.prepare(made.t, made.y, u, cutoff=3.5, decimate=1)
    assert np.array_equal(driven(whole).u, u[np.isin(made.t, whole.t)])


def test_straight_lines_between_samples_act_as_the_sine_that_they_stand_for():
    linear = {"q": "v", "v": "-60*q - 0.8*v + F"}
    t = np.arange(0.0, 40.0, 0.05)
    fine = np.arange(0.0, 40.0, 0.001)
    force = np.sin(2 * np.pi * 2.2 * fine)
    truth = pse.simulate(equations_of(linear, ("F",)), [0.0, 0.0], fine, force)[::50]
    record = replace(smoothed(linear), t=t, x=truth, x_dot=truth, u=force[::50], seen=None)
    runs = [
        pse.simulate(equations_of(linear, ("F",)), [0.0, 0.0], t, one.u)
        for one in (record, straightened(record))
    ]
    plain, mended = (np.abs(run - truth).max() / np.abs(truth).max() for run in runs)
    assert plain > 0.02
    assert mended < 0.005
