"""Pumped terms: terms of the model times a sine and a cosine of the time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from ...terms import Call, Sum
from ..given.design import Column, Design
from .candidate import Candidate, CandidateMaker, Shape, bare
from .modulation import ActingTerm, pumping
from .names import FORCING
from .partners import joined, shared_terms
from .periodic import PERIODS_IN_TIME, Signal, frequency_of, of_line, waves_of, waves_times
from .varying_terms import parts_of


def pumped_candidates(state: int, time: int, signal: Signal, term: ActingTerm) -> list[Candidate]:
    """Return a declared term times sines and cosines of time: a stiffness that is pumped.

    The residual that lacks such a term has a line once it is multiplied by the term. A pumped
    population has that line itself; then the wave that explains most beside the term is taken.

    Parameters
    ----------
    state, time, signal
        As in `periodic_candidates` of `periodic`.
    term : ActingTerm
        The term.

    Returns
    -------
    list of Candidate
        One or none.
    """
    values, dt, highest = term.values, signal.dt, signal.highest
    drivers = np.column_stack([signal.drivers, values, values**2])
    lines = Signal(signal.values * values, drivers, dt, highest).lines(n_peaks=1)
    if not lines:
        found = pumping(signal.values, values, PERIODS_IN_TIME, highest * dt)
        lines = [cycles / dt for cycles in found]
    return [
        _pump(state, time, term.part, of_line(line, signal.length, waves_of(time), term.branch))
        for line in lines
    ]


def other_pumps(forcing: Candidate, design: Design) -> list[Candidate]:
    """Return what else may act at the frequency of a forcing: the wave, or a term times the wave.

    A system pumped near its own frequency moves with the pump. Then each term has a line there, and
    the residual does not tell which of them is pumped; free runs do.

    Parameters
    ----------
    forcing : Candidate
        The forcing that was found; the list is empty for another effect.
    design : Design
        The model without it.

    Returns
    -------
    list of Candidate
    """
    if forcing.name != FORCING or forcing.shape is None:
        return []
    plain = replace(forcing.shape, builds=waves_of(design.time))
    return [
        CandidateMaker(forcing.state)(FORCING, shape=plain),
        *_pumped(forcing.state, design, plain),
    ]


def pumps_between(forcings: Sequence[Candidate], design: Design, length: float) -> list[Candidate]:
    """Return the pumped terms whose sidebands two forcings of one equation may be.

    A wave of frequency f that multiplies a narrow resonance at g acts at f + g and at the
    difference of f and g.

    Parameters
    ----------
    forcings : sequence of Candidate
        The list is empty unless these are two forcings.
    design : Design
        The model without them.
    length : float
        Of the longest record, units of t.

    Returns
    -------
    list of Candidate
    """
    lines = [frequency_of(one) for one in forcings if one.name == FORCING]
    if len(forcings) != 2 or len(lines) != 2 or not all(lines):
        return []
    low, high = sorted(lines)
    waves = waves_of(design.time)
    pumps = (0.5 * (high + low), 0.5 * (high - low))
    shapes = [of_line(pump, length, waves, branch) for branch, pump in enumerate(pumps) if pump]
    return [one for shape in shapes for one in _pumped(forcings[0].state, design, shape)]


def partner_pumps(design: Design, length: float) -> list[Candidate]:
    """Return terms pumped at the frequencies of waves that stand in a model already.

    A flow that is pumped where it leaves one equation is pumped where it enters another, whose
    residual may have a stronger line elsewhere.

    Parameters
    ----------
    design : Design
        The model so far.
    length : float
        Of the longest record, units of t.

    Returns
    -------
    list of Candidate
    """
    plain = waves_of(design.time)
    # Each frequency is tuned by itself; the lines of a residual have the branches from zero on.
    shapes = [
        of_line(frequency, length, plain, branch=-1 - k)
        for k, frequency in enumerate(_frequencies_in(design))
    ]
    return [
        replace(pump, of_known_wave=True)
        for shape in shapes
        for state in design.open_states
        for pump in _pumped(state, design, shape)
    ]


def shared_pumps(design: Design, offered: Sequence[Candidate]) -> list[Candidate]:
    """Return pumped terms as one effect of all equations that share the coefficient of the term.

    What the seasons do to a rate of infection, they do where it takes from one group and where it
    adds to another. A wave in one of these equations alone would bend the rate in the others.

    Parameters
    ----------
    design : Design
        The model.
    offered : sequence of Candidate
        Effects of single equations, pumped terms among them.

    Returns
    -------
    list of Candidate
        Each pumped term that is shared, at its own frequency in all equations.
    """
    found = []
    for column, states in shared_terms(design):
        parts = {state: bare(column.parts[state]) for state in states}
        for pump in offered:
            if pump.name == FORCING and pump.shape and pump.parents == (parts.get(pump.state),):
                others = [
                    _pump(state, design.time, part, pump.shape)
                    for state, part in parts.items()
                    if state != pump.state
                ]
                found.append(joined([pump, *others]))
    return found


def is_partner_pump(candidate: Candidate, found: Sequence[Column], time: int) -> bool:
    """Tell whether a candidate is one of `partner_pumps`, of a wave found in another equation.

    Parameters
    ----------
    candidate : Candidate
        Any candidate.
    found : sequence of Column
        What was found, without the declared model.
    time : int
        The variable that is the time.

    Returns
    -------
    bool
        False in an equation where such a wave was found: there it is another effect.
    """
    if not candidate.of_known_wave:
        return False
    here = _frequencies_of(found, time, candidate.state)
    return bool(_frequencies_of(found, time)) and not here


def _frequencies_in(design: Design) -> list[float]:
    """Return the frequencies of waves of the time in a model, cycles per unit of t."""
    return _frequencies_of(design.columns, design.time)


def _frequencies_of(columns: Iterable[Column], time: int, state: int | None = None) -> list[float]:
    """Return the frequencies of waves of the time in columns, of one equation or of all."""
    sides = (side for one in columns for k, side in enumerate(one.parts) if state in (None, k))
    atoms = (atom for side in sides for _, term in side.parts for atom, _ in term.factors)
    waves = [
        atom.args[0]
        for atom in atoms
        if isinstance(atom, Call) and atom.operator.name in ("sin", "cos")
    ]
    found = (wave.parts[-1][0] for wave in waves if wave.variables == {time})
    return list(dict.fromkeys(abs(omega) / (2.0 * np.pi) for omega in found))


def _pumped(state: int, design: Design, wave: Shape) -> list[Candidate]:
    """Return each term of an equation times a wave; terms that hold the time are left out."""
    parts = (part for part in parts_of(design, state) if design.time not in part.variables)
    return [_pump(state, design.time, part, wave) for part in parts]


def _pump(state: int, time: int, part: Sum, wave: Shape) -> Candidate:
    """Return a term times a wave, at the frequency of the wave."""
    shape = replace(wave, builds=waves_times(part, time))
    return CandidateMaker(state)(FORCING, shape=shape, parents=(part,), never_paired=True)
