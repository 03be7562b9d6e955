r"""The residual of a model in two views, which show how much an effect matters.

*Derivative view*: x_dot - f(x), averaged over smooth windows (the weak form).
*Simulation view*: the deviation e of the measured states from a simulation that starts on them.
To first order it obeys the linearized model, driven by the residual,

.. math:: \dot e = J(x) \, e + (\dot x - f(x)), \quad J = \partial f / \partial x,

so that it, too, is a linear map of the rows. It sees slow and small effects that the noise of a
second derivative drowns.

A third view, in which effects are ranked and tested, is in spectral.py. All are linear in the
residual, so declared columns, candidate effects and target pass through them alike, and everything
after that is small Gram matrices.

======  ==============================================  ======================================
symbol  shape                                           meaning
======  ==============================================  ======================================
z       (n_segments, n, n_variables)                    states, inputs, time
force   (n_segments, n, n_states, n_columns + 1)        columns and target in each equation
grams   (n_segments, n_columns + 1, n_columns + 1)      inner products, target last
======  ==============================================  ======================================
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...equations import Equations
from ...signals import Record, project
from ...terms import Cache
from ..given.design import Column, Design
from ..given.segments import Segments
from ..given.sensor import as_observed

DIVERGED = 1e60  # deviations are clipped here, so that their squares do not overflow
MAX_GROWTH = 1e3  # of a deviation; simulation windows are shortened until it grows by less
ORDER = 5  # of the exponential that carries a deviation over a sample
ROWS_PER_WINDOW = 64  # rows to keep of the simulated deviation, which is smooth


def residual_on(equations: Equations, record: Record) -> np.ndarray:
    """Return the residual of the measured derivative, as sensors would show it.

    Parameters
    ----------
    equations : Equations
        A model; its hidden states are at rest before the record.
    record : Record
        What was measured.

    Returns
    -------
    ndarray of shape (n_samples, n_states)
        x_dot minus the model, units of x_dot; zero where no sensor saw the state.
    """
    return as_observed(record, record.x_dot - equations.evaluate(record.x, record.u, record.t))


def view_grams(
    part: Segments, design: Design, columns: Sequence[Column], jacobians: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the Gram matrices of each segment in both views.

    Parameters
    ----------
    part : Segments
        Rows of the records.
    design : Design
        Supplies the known parts of the equations.
    columns : sequence of Column
        Columns of the design, then candidates.
    jacobians : ndarray of shape (n_segments, n, n_states, n_states)
        Of the model that the simulation view is linearized about.

    Returns
    -------
    dict of str to ndarray of shape (n_segments, n_columns + 1, n_columns + 1)
        "derivative" and "simulation".
    """
    force = forces(part, design, columns)
    rows = {"derivative": _derivative_rows(part, design, force)}
    rows["simulation"] = simulation_rows(force, jacobians, part.dt, part.state_scale)
    return {name: np.einsum("srk,srl->skl", r, r, optimize=True) for name, r in rows.items()}


def derivative_grams(part: Segments, design: Design, columns: Sequence[Column]) -> np.ndarray:
    """Return the Gram matrices of each segment in the derivative view alone."""
    rows = _derivative_rows(part, design, forces(part, design, columns))
    return np.einsum("srk,srl->skl", rows, rows, optimize=True)


def forces(
    part: Segments, design: Design, columns: Sequence[Column], *, weighed: bool = True
) -> np.ndarray:
    """Evaluate columns and target in each equation; the target is x_dot minus the known part."""
    cache: Cache = {}
    force = np.stack([force_on(part, design, columns, s, cache) for s in range(part.n_states)])
    force = force.transpose(2, 3, 0, 1)
    return force * part.weight[..., None] if weighed else force


def force_on(
    part: Segments, design: Design, columns: Sequence[Column], state: int, cache: Cache
) -> np.ndarray:
    """Evaluate columns and target in one equation, shape (n_columns + 1, n_segments, n)."""
    shape, flat = part.z.shape[:2], part.rows
    force = np.zeros((len(columns) + 1, *shape))
    for row, column in zip(force, columns, strict=False):
        values = column.values_in(state, flat, cache)
        if values is not None:
            row[:] = values.reshape(shape)
    known = Column("known", design.fixed).values_in(state, flat, cache)
    force[-1] = part.x_dot[:, :, state] - (0.0 if known is None else known.reshape(shape))
    return force


def _derivative_rows(part: Segments, design: Design, force: np.ndarray) -> np.ndarray:
    """Average over windows; each open equation is weighed by the size of its derivative."""
    n_segments, length, _, n_columns = force.shape
    lengths = [length] * n_segments
    blocks = []
    for state in design.open_states:
        flat = force[:, :, state].reshape(n_segments * length, n_columns)
        averaged = project(flat, part.windows, lengths) / part.rate_scale[state]
        blocks.append(averaged.reshape(n_segments, -1, n_columns))
    return np.concatenate(blocks, axis=1)


def simulation_rows(
    force: np.ndarray, jacobians: np.ndarray, dt: float, scale: np.ndarray
) -> np.ndarray:
    """Drive the linearized model over segments; the unknown initial states are projected out.

    Parameters
    ----------
    force : ndarray of shape (n_segments, n, n_states, n_columns)
        What drives each equation.
    jacobians : ndarray of shape (n_segments, n, n_states, n_states)
        Of the model.
    dt : float
        Sampling time.
    scale : ndarray of shape (n_states,)
        Unit of the deviation of each state.

    Returns
    -------
    ndarray of shape (n_segments, n_rows, n_columns)
    """
    n_segments, length, n_states, n_columns = force.shape
    span = length
    while True:
        n_windows = length // span
        shape = (n_segments * n_windows, span, n_states)
        driven = force[:, : n_windows * span].reshape(*shape, n_columns)
        slope = jacobians[:, : n_windows * span].reshape(*shape, n_states)
        keep = max(1, span // ROWS_PER_WINDOW)
        free, response = respond(slope, driven, dt, scale, keep)
        if span <= 8 or np.max(np.abs(free)) < MAX_GROWTH:
            break
        span = max(8, span // 2)
    basis, _ = np.linalg.qr(free)
    response -= basis @ (np.swapaxes(basis, 1, 2) @ response)
    return response.reshape(n_segments, -1, n_columns)


def respond(
    slope: np.ndarray,
    driven: np.ndarray,
    dt: float,
    scale: np.ndarray,
    keep: int,
    jumps: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Integrate e' = J e + force from rest, and from unit initial states without force.

    Trapezoidal in the force and in J, and fifth order in J dt, which few samples a period make
    large. Every `keep`-th sample of the windows is returned, in units of the scale of each state,
    as shapes (n_windows, rows, n_states) and (n_windows, rows, n_columns). Jumps, (n_windows,
    n - 1, n_states, n_states), multiply the deviation at the end of each step.
    """
    n_windows, _, n_states, n_columns = driven.shape
    with np.errstate(over="ignore", invalid="ignore"):
        passed, added = _over_blocks(slope, driven, dt, keep, jumps)
        deviation = np.zeros((n_windows, n_states, n_columns + n_states))
        deviation[:, :, n_columns:] = np.diag(scale)
        kept = [deviation]
        for k in range(passed.shape[1]):
            deviation = passed[:, k] @ deviation
            deviation[:, :, :n_columns] += added[:, k]
            kept.append(deviation)
        rows = np.stack(kept, axis=1) / scale[:, None]
    rows = np.clip(np.nan_to_num(rows, nan=DIVERGED), -DIVERGED, DIVERGED)
    rows = rows.reshape(n_windows, -1, n_columns + n_states)
    return rows[:, :, n_columns:], rows[:, :, :n_columns]


def _over_blocks(
    slope: np.ndarray, driven: np.ndarray, dt: float, keep: int, jumps: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Integrate over all blocks of `keep` steps at once.

    Return the matrix that carries a deviation over each block, and what the force adds: shapes
    (n_windows, n_blocks, n_states, n_states) and (..., n_states, n_columns).
    """
    n_windows, span, n_states, n_columns = driven.shape
    n_blocks = (span - 1) // keep
    used = slice(0, n_blocks * keep)
    blocks = (n_windows, n_blocks, keep, n_states)
    mean = 0.5 * (slope[:, used] + slope[:, 1 : n_blocks * keep + 1])
    a = dt * mean.reshape(*blocks, n_states)
    eye = np.eye(n_states)
    step = eye + a / ORDER  # the exponential of a
    for k in range(ORDER - 1, 0, -1):
        step = eye + a @ step / k
    before, after = driven[:, used], driven[:, 1 : n_blocks * keep + 1]
    before, after = (0.5 * dt * half.reshape(*blocks, n_columns) for half in (before, after))
    jumps = None if jumps is None else jumps[:, used].reshape(*blocks, n_states)
    deviation = np.zeros((n_windows, n_blocks, n_states, n_states + n_columns))
    deviation[..., :n_states] = eye
    for i in range(keep):
        deviation[..., n_states:] += before[:, :, i]
        deviation = step[:, :, i] @ deviation
        deviation[..., n_states:] += after[:, :, i]
        if jumps is not None:
            deviation = jumps[:, :, i] @ deviation
    return deviation[..., :n_states], deviation[..., n_states:]


def jacobian(equations: Equations, z: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Return d x_dot / d x on each row, without the jumps of sgn terms.

    The smaller of two differences is taken, one just ahead and one just behind: across a jump one
    of the two is huge, elsewhere they agree. Neither touches the row itself, which may stand
    exactly on a jump, as a mass at rest does.

    Parameters
    ----------
    equations : Equations
        The model.
    z : ndarray of shape (..., n_variables)
        States, inputs, time.
    scale : ndarray of shape (n_states,)
        Size of each state.

    Returns
    -------
    ndarray of shape (..., n_states, n_states)
    """
    n_states = len(equations.states)
    flat = z.reshape(-1, z.shape[-1])
    result = np.empty((len(flat), n_states, n_states))
    for j in range(n_states):
        step, along = 1e-6 * scale[j], _terms_with(j, equations)
        ahead, behind = (
            [_moved(along, flat, j, far * side * step) for far in (1, 2)] for side in (1, -1)
        )
        with np.errstate(invalid="ignore"):  # where runs diverge
            forward, backward = (ahead[1] - ahead[0]) / step, (behind[0] - behind[1]) / step
        result[:, :, j] = np.where(np.abs(forward) < np.abs(backward), forward, backward)
    return result.reshape(*z.shape[:-1], n_states, n_states)


def _terms_with(j: int, equations: Equations) -> Equations:
    """Return the part of some equations that depends on variable j: the rest has no slope in it."""
    places = [k for k, term in enumerate(equations.terms) if j in term.variables]
    terms, coef = tuple(equations.terms[k] for k in places), equations.coef[:, places]
    return Equations(terms, coef, equations.states, equations.inputs)


def _moved(equations: Equations, flat: np.ndarray, column: int, step: float) -> np.ndarray:
    moved = flat.copy()
    moved[:, column] += step
    return _rates(equations, moved)


def _rates(equations: Equations, flat: np.ndarray) -> np.ndarray:
    cache: Cache = {}
    columns = [term.evaluate(flat, cache) for term in equations.terms]
    if not columns:
        return np.zeros((len(flat), len(equations.states)))
    with np.errstate(over="ignore", invalid="ignore"):  # where runs diverge
        return np.asarray(np.column_stack(columns) @ equations.coef.T)
