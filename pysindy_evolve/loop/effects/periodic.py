"""Periodic forcing and ripple: sines and cosines where a residual has a line in its spectrum."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.stats import binned_statistic, linregress

from ...operators import BUILTIN
from ...terms import Sum, call, constant, mul, variable
from ..given.design import Design
from .candidate import Candidate, CandidateMaker, Shape
from .lines import find_lines
from .names import FORCING, RIPPLE

FREQUENCY = "angular frequency"
WAVE_NUMBER = "wave number"
N_LINES = 2  # to try in each equation
PERIODS_IN_TIME = 8  # of a line in a record, at least; fewer look like slow disturbances
FEWEST_PERIODS = 4  # of a plain forcing, which acts whatever the state is
PERIODS_IN_SPACE = 4  # fewer within the stroke look like a spring or a slope
MIN_IN_STEP = 0.9  # correlation with a position of what a ripple may repeat with in its place
SAMPLES_PER_BIN = 8  # of the stroke, on average: as fine as the record can tell


@dataclass(frozen=True, eq=False)
class Signal:
    """A residual over the time, with the inputs beside it.

    Attributes
    ----------
    values : ndarray of shape (n_samples,)
        On a uniform grid of step dt.
    drivers : ndarray of shape (n_samples, n_drivers)
        Inputs, and whatever else has lines that do not count.
    dt : float
        Sampling time, units of t.
    highest : float
        Frequency up to which to look for lines, cycles per unit of t, such as the cutoff of a
        low-pass.
    """

    values: np.ndarray
    drivers: np.ndarray
    dt: float
    highest: float = np.inf

    @property
    def length(self) -> float:
        """Its length, units of t."""
        return len(self.values) * self.dt

    def lines(self, n_peaks: int = N_LINES, n_periods: int = PERIODS_IN_TIME) -> list[float]:
        """Return the frequencies, cycles per unit of t, of lines that no driver has.

        Parameters
        ----------
        n_peaks : int
            How many to return at most.
        n_periods : int
            Periods of a line in the signal, at least.

        Returns
        -------
        list of float
            The clearest first.
        """
        highest = self.highest * self.dt
        found = find_lines(self.values, self.drivers.T, n_periods, n_peaks, highest)
        return [cycles / self.dt for cycles in found]


def periodic_candidates(state: int, time: int, signal: Signal) -> list[Candidate]:
    """Return sines and cosines of time at the strongest frequencies of a residual.

    A line that an input has too is left out: it is no forcing, but a response to the input that the
    model gets wrong.

    Parameters
    ----------
    state : int
        Equation that the residual belongs to.
    time : int
        Column of the variables that holds time.
    signal : Signal
        The residual.

    Returns
    -------
    list of Candidate
    """
    effect = CandidateMaker(state)
    lines = signal.lines(n_periods=FEWEST_PERIODS)
    return [
        effect(FORCING, shape=of_line(frequency, signal.length, waves_of(time), branch))
        for branch, frequency in enumerate(lines)
    ]


def of_line(
    frequency: float, length: float, waves: tuple[Callable[[float], Sum], ...], branch: int
) -> Shape:
    """Return waves at a frequency, tuned by up to half of what a record of a length resolves."""
    reach = 0.5 / (frequency * length)
    return Shape((2 * np.pi * frequency,), waves, reach, (FREQUENCY,), branch)


def frequency_of(candidate: Candidate) -> float:
    """Return the frequency of a periodic forcing, cycles per unit of t; zero of another effect."""
    if candidate.shape is None or FREQUENCY not in candidate.shape.meanings:
        return 0.0
    return candidate.shape.named[FREQUENCY] / (2 * np.pi)


def ripple_candidates(
    state: int, position: int, residual: np.ndarray, q: np.ndarray, noise: float = 0.0
) -> list[Candidate]:
    """Return sine and cosine of a position at the strongest wave number of a residual.

    Cogging of a motor, teeth of a gear and the pitch of a screw repeat at the same places, whenever
    the machine passes there. So the residual is averaged over short pieces of the stroke first.
    Waves finer than the noise of the position are left out: the steps of an encoder, too, repeat at
    the same readings.

    Parameters
    ----------
    state : int
        Equation that the residual belongs to.
    position : int
        Column of the variables that holds the position.
    residual : ndarray of shape (n_samples,)
        What the model leaves.
    q : ndarray of shape (n_samples,)
        Position.
    noise : float
        Standard deviation of the noise of the sensor of the position.

    Returns
    -------
    list of Candidate
        One, or none.
    """
    n_bins = len(q) // SAMPLES_PER_BIN
    if n_bins < 2 * PERIODS_IN_SPACE or np.ptp(q) == 0.0:
        return []
    mean, edges, _ = binned_statistic(q, residual, "mean", n_bins)
    seen = np.isfinite(mean)
    mean = np.interp(np.arange(n_bins), np.flatnonzero(seen), mean[seen])
    effect, width = CandidateMaker(state), float(edges[1] - edges[0])
    finest = width / (2 * np.pi * noise) if noise > 0.0 else np.inf
    lines = find_lines(mean, (), PERIODS_IN_SPACE, 1, finest)
    return [
        effect(
            RIPPLE,
            # Half a period over the stroke: pieces that were passed less often shift the line.
            shape=Shape(
                (2 * np.pi * cycles / width,),
                waves_of(position),
                0.5 / (n_bins * cycles),
                (WAVE_NUMBER,),
            ),
        )
        for cycles in lines
    ]


def other_ripples(ripple: Candidate, design: Design, pieces: np.ndarray) -> list[Candidate]:
    """Return the same ripple over what moves in step with the position, such as a motor's angle.

    The error of a gear repeats with the angle of its motor. The load nearly follows that angle, so
    that the residual does not tell over which of the two it repeats; free runs do.

    Parameters
    ----------
    ripple : Candidate
        The ripple that was found; the list is empty for another effect.
    design : Design
        The model without it.
    pieces : ndarray of shape (n_pieces, n_samples, n_variables)
        Measured variables. Each piece may count its angles from another zero.

    Returns
    -------
    list of Candidate
        One for each other position and input of the equation that is nearly proportional to the
        position within the pieces.
    """
    state, position = ripple.state, design.position_of(ripple.state)
    if ripple.name != RIPPLE or ripple.shape is None or ripple.variables != {position}:
        return []
    in_equation = frozenset().union(*(side.variables for side in design.sides_of(state)))
    moved = pieces - pieces.mean(axis=1, keepdims=True)
    moved = moved.reshape(-1, pieces.shape[2])
    found = []
    for other in sorted(in_equation - {position, design.time, *design.velocities}):
        if not np.ptp(moved[:, other]) > 0.0:
            continue
        line = linregress(moved[:, other], moved[:, position])
        if abs(line.rvalue) > MIN_IN_STEP:
            values = (ripple.shape.values[0] * abs(float(line.slope)),)
            shape = replace(ripple.shape, values=values, builds=waves_of(other), branch=other)
            found.append(CandidateMaker(state)(RIPPLE, shape=shape))
    return found


def is_same_ripple(one: Candidate, other: Candidate) -> bool:
    """Tell whether either of two ripples can be tuned to the wave number of the other."""
    if one.shape is None or other.shape is None:
        return False
    apart = abs(np.log(one.shape.values[0] / other.shape.values[0]))
    return bool(apart <= max(one.shape.reach, other.shape.reach))


def waves_of(column: int) -> tuple[Callable[[float], Sum], ...]:
    """Return builders of sine and cosine of a variable, from a frequency in radians per unit."""
    return partial(_wave, "sin", column), partial(_wave, "cos", column)


def waves_times(part: Sum, column: int) -> tuple[Callable[[float], Sum], ...]:
    """Return the same for an expression times these waves."""
    return tuple(partial(_times, part, wave) for wave in waves_of(column))


def _times(part: Sum, wave: Callable[[float], Sum], frequency: float) -> Sum:
    return mul(part, wave(frequency))


def _wave(function: str, column: int, frequency: float) -> Sum:
    return call(BUILTIN[function], mul(constant(frequency), variable(column)))
