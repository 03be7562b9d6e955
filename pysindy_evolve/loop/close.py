"""The loop: trace the residual, test the best effect on twins, add it, repeat, prune, report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pysindy as ps

from ..operators import Operator, resolve
from ..signals import Record
from ..threads import one_thread
from ..warn import warn
from .evidence.spectrum_or_trajectory import pieces_to_score
from .fitting.aliases import without_aliases
from .free_runs.state_limits import may_stop_itself
from .given.declared import DeclaredModel
from .given.given import checked_model_and_records
from .given.rules import Rules, generator
from .growth.genetic_search import OPERATORS
from .report.report import LoopReport, report_of
from .search.found import Found
from .search.look_for_effects import look_for_effects
from .settling.settle import settled


@one_thread()
def close_loop(
    declared: DeclaredModel | ps.SINDy,
    train: Record | Sequence[Record],
    test: Record | Sequence[Record] | None = None,
    *,
    significance: float = 0.05,
    n_twins: int = 299,
    min_share: float = 0.05,
    max_effects: int = 8,
    refine: str = "auto",
    operators: Sequence[str | Operator] = OPERATORS,
    random_state: int | np.random.Generator | None = None,
    n_jobs: int | None = None,
    progress: bool = False,
) -> LoopReport:
    """Find what a declared model lacks, add it, and report the errors before and after.

    Each step scores every effect of the vocabulary, refitted together with the model, on parts of
    the training data that it was not fitted on, in the derivative and in the simulation. The best
    one is added if twins, simulated records in which nothing is missing, hardly ever show an effect
    as good.

    Parameters
    ----------
    declared : DeclaredModel or pysindy.SINDy
        The model so far; a SINDy model may be fitted or not.
    train : Record or sequence of Record
        Measurements to fit on and to search in.
    test : Record or sequence of Record, optional
        Measurements to judge on, which influence no decision. Without them the last of several
        records, or the last 30 % of a single one, are held out.
    significance : float
        Chance to add an effect where nothing is missing, in (0, 1).
    n_twins : int
        Largest number of twins of each step. The smallest p-value is 1 / (n_twins + 1).
    min_share : float
        An effect must remove at least this share of the error variance that all candidates
        together could remove, in the derivative or in the simulation, or halve the remaining
        error. Exempt are the zero of a state that was found, and a term that is pumped as one in
        another equation is. Real records always hold small unknown effects; this sets how small
        one may be.
    max_effects : int
        Stop at this many effects; a pair that only shows together may exceed it by one. 0 only
        fits the declared model and tests whether anything is missing.
    refine : {"auto", "derivative", "simulation"}
        Error that the final coefficients minimize. "auto" takes the simulation where that predicts
        unseen parts of the training data better, and the derivative elsewhere.
    operators : sequence of str or Operator
        Basis functions of grown terms, for effects without a name; empty to grow none.
    random_state : int, Generator or None
        Seed of the twins and of the search.
    n_jobs : int, optional
        Processes that work on the twins; the result does not depend on it.
    progress : bool
        Show a progress bar.

    Returns
    -------
    LoopReport

    Raises
    ------
    ValueError
        If a setting is out of range, or the records do not fit the model or each other.
    TypeError
        If something is of the wrong type.

    Notes
    -----
    An interrupt (Ctrl-C) ends the search. Effects found by then are reported; if there are none
    yet, KeyboardInterrupt is raised. Expect 5 to 20 s of one quiet core for 10 000 samples of
    one position, a minute or more for two joints or bodies, and more with each effect found. The
    matrices are small, so the linear algebra runs on one thread.

    Examples
    --------
    >>> import numpy as np
    >>> import pysindy_evolve as pse
    >>> t = np.arange(0.0, 20.0, 0.01)
    >>> q = np.exp(-0.1 * t) * np.cos(2.0 * t) + 0.5
    >>> declared = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v"})
    >>> report = pse.close_loop(declared, pse.prepare(t, q), random_state=0)
    >>> report.verdict, report.effects[0].name
    ('traced', 'constant offset')
    """
    rules = Rules(significance, n_twins, min_share, max_effects, n_jobs, progress, refine)
    given = checked_model_and_records(declared, train, test)
    rng = generator(random_state)
    if given.design.algebraic:  # nothing is simulated
        rules = replace(rules, refine="derivative")
    else:
        train, test, wide = without_aliases(given.design, given.train, given.test, given.wide)
        given = replace(given, train=train, test=test, wide=wide)
    if may_stop_itself(given.design, given.train, rules, rng):
        given = given.with_clipping_as_true()
    segments = pieces_to_score(given.design, given.wide)
    n_sought = max_effects if given.shows_motion else 0
    rules = replace(rules, by_trajectory=segments.by_trajectory, max_effects=n_sought)
    basis = resolve(operators, "close_loop") if operators else ()
    told = any(record.held for record in given.train)
    start = Found(given.design, given.train, segments, rules, basis, holds_are_told=told)
    found, interrupted = _search(start, rng)
    outcome = settled(found, given.test, rng, finished=found.has_room and not interrupted)
    return report_of(replace(outcome, shows_motion=given.shows_motion, interrupted=interrupted))


def _search(found: Found, rng: np.random.Generator) -> tuple[Found, bool]:
    """Search for effects; also tell whether an interrupt ended the search."""
    try:
        for step in look_for_effects(found, rng):
            found = step
    except KeyboardInterrupt:
        if not found.findings:
            raise
        warn(
            "close_loop was interrupted. The report is being made from what was found so far; "
            "press Ctrl-C again to stop without a report."
        )
        return found, True
    return found, False
