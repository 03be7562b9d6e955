"""How candidates are scored: by the spectrum of the derivative, or by the trajectory.

The spectral view takes the noise from the residual of all candidates together, so it needs more
numbers than there are candidates. A record holds two numbers per cycle of its cutoff, however often
it was sampled. If these are fewer than twice the columns of an equation, half of them to see the
noise by, candidates are scored by the trajectory instead.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...signals import Record
from ..effects.missing import candidates, for_trajectories
from ..effects.stops import has_two_ends
from ..fitting.trajectory import followable
from ..given.design import Design
from ..given.ranges import Ranges
from ..given.rows import rows_of
from ..given.segments import Segments, segments
from ..given.sticking import may_rest
from .spectral import n_frequencies


def pieces_to_score(design: Design, records: Sequence[Record]) -> Segments:
    """Cut records into pieces, and say whether candidates are scored by their trajectories.

    Parameters
    ----------
    design : Design
        The declared model.
    records : sequence of Record
        Training records.

    Returns
    -------
    Segments
    """
    part = segments(records, may_rest(design, records))
    if not followable(design, records) or _says_enough(design, part):
        return part
    return part.tracked()


def _says_enough(design: Design, part: Segments) -> bool:
    """Tell whether the spectra of the pieces hold twice as many numbers as there are columns.

    Effects with two ends are not counted: they hardly differ from those with one end, or with ends
    at the same distance.
    """
    usual = for_trajectories(candidates(design, Ranges.of(rows_of(part.records))))
    single = [c for c in usual if not has_two_ends(c)]
    offered = [c.state for c in single for _ in c.terms]
    n_columns = len(design.columns) + max(offered.count(state) for state in design.open_states)
    n_numbers = len(part.places) * (2 * n_frequencies(part) - 1)
    return n_numbers >= 2 * n_columns
