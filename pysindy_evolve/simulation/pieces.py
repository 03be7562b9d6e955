"""Runs several models over many pieces of records at once, each from its own initial state."""

from __future__ import annotations

import numpy as np

from ..equations import Equations
from .columns import Columns, choose_substeps, field_of
from .crossing import advance, start_signs

TOLERANCE = 1e-5  # error of a sample interval, relative to the state: enough beside a sensor
MAX_SUBSTEPS = 20


def simulate_pieces(
    equations: Equations, coef: np.ndarray, x0: np.ndarray, t: np.ndarray, u: np.ndarray
) -> np.ndarray:
    """Integrate models that share their terms, each over the same number of pieces.

    Parameters
    ----------
    equations : Equations
        Supplies terms and names.
    coef : ndarray of shape (n_models, n_states, n_terms)
        Coefficients of each model.
    x0 : ndarray of shape (n_pieces, n_states)
        Initial states of the pieces, those of the first model first.
    t : ndarray of shape (n_pieces, n)
        Times of each piece, all with the same steps.
    u : ndarray of shape (n_pieces, n, n_inputs)
        Inputs, linear in between.

    Returns
    -------
    ndarray of shape (n_pieces, n, n_states)
        Not finite where a run diverges.
    """
    field = field_of(equations, coef)
    n_pieces, n = t.shape
    given, steps = np.moveaxis(u, 0, -1), np.diff(t, axis=1)
    slopes = np.diff(given, axis=0) / steps.T[:, None]
    out = np.empty((n, len(equations.states), n_pieces))
    out[0] = x0.T
    zeros = np.zeros((len(field.switches), n_pieces))
    signs = zeros, zeros.astype(bool)
    columns = Columns(out[0], given[0], slopes[0], t[:, 0], *signs, field.coef_of(n_pieces))
    with np.errstate(all="ignore"):
        columns = start_signs(field, columns, steps[:, 0])
        n_steps = choose_substeps(field, columns, steps[:, 0], TOLERANCE, MAX_SUBSTEPS)
        for j in range(n - 1):
            columns = columns.fed(given[j], slopes[j], t[:, j])
            for _ in range(n_steps):
                columns = advance(field, columns, steps[:, j] / n_steps)
            out[j + 1] = columns.x
    return np.moveaxis(out, -1, 0)
