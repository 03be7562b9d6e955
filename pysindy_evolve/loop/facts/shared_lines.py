"""Spectral lines that the residuals of all records share, and that no input has.

A forcing whose phase differs between records leaves such a line. No fixed term can describe it, so
it gets no name; but a model whose residual is mostly this line is not complete.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...signals import Record
from ..effects.lines import FEWEST_FREQUENCIES
from ..effects.periodic import Signal
from .outcome import Outcome
from .residuals import residual_of

# Shares of the mean square of a residual.
MAIN_SHARE = 0.5  # above it the model lacks something; a weaker line may be a rig that hums
LEAST_SHARE = 0.01  # below it a line is not reported: harmonics of a motion leave weak lines too
NEAR_CUTOFF = 0.9  # of the cutoff; a line above it may be the rest of a motion that the filter cut
LINE_WIDTH = 3.0  # distance in 1/duration within which two lines of a residual count as one


@dataclass(frozen=True)
class Line:
    """A line in the residual of a state.

    Attributes
    ----------
    state : str
        State in whose derivative it is.
    frequency : float
        Cycles per unit of t.
    share : float
        Share of the mean square of the residual, in the record where it is least.
    """

    state: str
    frequency: float
    share: float

    @property
    def is_most(self) -> bool:
        """Whether it is most of the residual in each record, so that the model lacks something."""
        return self.share > MAIN_SHARE


def shared_lines(outcome: Outcome) -> list[Line]:
    """Return the lines that the residuals of all training records share; none for one record."""
    model, records = outcome.after.model, outcome.train
    if len(records) < 2 or model.n_algebraic or not all(map(_has_surroundings, records)):
        return []
    width = 1.0 / min(record.t[-1] - record.t[0] for record in records)
    residuals = [residual_of(model, record) for record in records]
    shared: list[Line] = []
    for k, state in enumerate(outcome.before.model.states):
        pairs = zip(records, residuals, strict=True)
        of_first, *of_others = (
            [*map(float, _lines_of(record, residual[:, k]))] for record, residual in pairs
        )
        kept: list[float] = []
        for line in of_first:
            is_shared = all(
                any(abs(line - f) < width for f in frequencies) for frequencies in of_others
            )
            if is_shared and all(abs(line - other) > LINE_WIDTH * width for other in kept):
                kept.append(line)
        for line in kept:
            pairs = zip(records, residuals, strict=True)
            shares = [_share(line, record.t, residual[:, k]) for record, residual in pairs]
            if min(shares) > LEAST_SHARE:
                shared.append(Line(state, line, min(shares)))
    return shared


def _share(frequency: float, t: np.ndarray, residual: np.ndarray) -> float:
    """Return the share of the mean square of a residual, (n_samples,), that a sine explains."""
    wave = np.exp(2j * np.pi * frequency * t)
    columns = np.column_stack([wave.real, wave.imag])
    fitted = columns @ np.linalg.lstsq(columns, residual, rcond=None)[0]
    return float(np.sum(fitted**2) / max(np.sum(residual**2), np.finfo(float).tiny))


def _lines_of(record: Record, residual: np.ndarray) -> list[float]:
    inputs = record.x[:, :0] if record.u is None else record.u
    highest = np.inf if record.cutoff is None else NEAR_CUTOFF * record.cutoff
    return [line for line in Signal(residual, inputs, record.dt).lines() if line < highest]


def _has_surroundings(record: Record) -> bool:
    """Tell whether a record has enough frequencies below its cutoff to tell a line from noise."""
    cutoff = 0.5 / record.dt if record.cutoff is None else record.cutoff
    return bool(cutoff * (record.t[-1] - record.t[0]) >= FEWEST_FREQUENCIES)
