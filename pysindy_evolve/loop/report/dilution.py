"""Parameters that sensor noise makes too small (regression dilution).

Where a controller holds its set point, or its output is a weighted sum of the states, some
combination of the terms of an equation hardly varies. What varies in it is noise of the states,
which the derivative does not follow. So its coefficients are fitted too small, with intervals that
are too narrow.

References
----------
Fuller, Measurement Error Models (1987), DOI 10.1002/9780470316665: attenuation by errors in the
regressors.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import eigh

from ...hidden_states.memory_equations import as_acting
from ...signals import Record
from ...terms import Sum
from ..facts.outcome import Outcome
from ..given.rows import variables_of
from ..given.sticking import noise_of

NOISE_SHARE = 0.1  # noise in the mean square of a combination: its weight is too small by as much
PARTICIPATES = 0.1  # of the largest term of a combination: smaller ones are not named
MAX_CONFIRMING_NRMSE = (
    50.0  # percent, error of a free run; below it the run confirms the coefficients
)
RIDGE = 1e-12  # of the mean square of a term: keeps the Gram matrix of collinear terms invertible


def dilution_sentences(outcome: Outcome) -> list[str]:
    """Name the parameters that noise in the states makes too small, or otherwise wrong.

    Parameters
    ----------
    outcome : Outcome
        What the loop found.

    Returns
    -------
    list of str
        Sentences for each equation with such parameters; none where its free run misses the
        held-out record by less than half of the standard deviation.
    """
    design = outcome.design
    if design.algebraic:
        return []
    records = [as_acting(outcome.equations, record)[1] for record in outcome.train]
    said = []
    for state in design.open_states:
        columns = [column for column in design.columns if column.parts[state].parts]
        if not columns or outcome.after.simulation_error[state] <= MAX_CONFIRMING_NRMSE:
            continue
        share, sizes = _noisiest([column.parts[state] for column in columns], records)
        names = [c.name for c, size in zip(columns, sizes, strict=True) if size > PARTICIPATES]
        if share > NOISE_SHARE:
            said.append(_sentence(design.states[state], names, share))
    return said


def _noisiest(terms: Sequence[Sum], records: Sequence[Record]) -> tuple[float, np.ndarray]:
    """Return the largest share of noise that a combination of terms has, and the terms' part in it.

    The second has shape (n_terms,): sizes of the terms in it, relative to the largest.
    """
    values = np.concatenate([_evaluated(terms, record.x, record) for record in records])
    noise = np.concatenate([_moved_by_noise(terms, record) for record in records])
    size = np.sqrt(np.mean(values**2, axis=0))
    if not np.isfinite(values).all() or not np.isfinite(noise).all() or not size.all():
        return 0.0, np.zeros(len(terms))
    gram, errors = (rows.T @ rows / len(values) for rows in (values / size, noise / size))
    shares, vectors = eigh(errors, gram + RIDGE * np.eye(len(terms)))
    sizes = np.abs(vectors[:, -1])
    return float(shares[-1]), sizes / sizes.max()


def _evaluated(terms: Sequence[Sum], states: np.ndarray, record: Record) -> np.ndarray:
    rows = variables_of(record).copy()
    rows[:, : states.shape[1]] = states
    with np.errstate(all="ignore"):
        return np.column_stack([term.evaluate(rows) for term in terms])


def _moved_by_noise(terms: Sequence[Sum], record: Record) -> np.ndarray:
    """Return the changes of terms by one standard deviation of noise, stacked over the states.

    Shape (n_states * n_samples, n_terms).
    """
    moved = []
    for state in range(record.n_states):
        noise = np.zeros(record.n_states)
        noise[state] = noise_of(record, state)
        up, down = (_evaluated(terms, record.x + sign * noise, record) for sign in (1.0, -1.0))
        moved.append(0.5 * (up - down))
    return np.concatenate(moved)


def _sentence(state: str, names: Sequence[str], share: float) -> str:
    if len(names) == 1:
        what = f"The term of {names[0]} in d{state}/dt hardly varies along these records"
    else:
        listed = f"{', '.join(names[:-1])} and {names[-1]}"
        what = f"The terms of {listed} in d{state}/dt nearly cancel out along these records"
    return (
        f"{what}: {100 * min(share, 1.0):.0f} % of the remaining variation is noise of the "
        "sensors, which makes the fitted values wrong, mostly too small, by more than the "
        "intervals say. Move the machine further, or vary its set point."
    )
