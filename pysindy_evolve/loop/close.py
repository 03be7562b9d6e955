"""The loop: trace the residual, test the best effect on twins, add it, repeat, prune, report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pysindy as ps

from ..operators import Operator, resolve
from ..signals import Record
from ..signals.holds import hold
from ..threads import one_thread
from .evidence.witness import witnessed
from .free_runs.state_limits import may_stop_itself
from .given.algebraic import as_algebraic
from .given.declared import DeclaredModel, design_of, doubted
from .given.design import Design
from .given.held import held_inputs
from .given.input_errors import as_held
from .given.records import alike, check_records, split_records, undecimated, widened
from .given.rules import Rules, generator
from .given.smoothing import with_own_slopes
from .growth.grow import OPERATORS
from .report.report import LoopReport
from .search import Search
from .settle import settled

__all__ = ["close_loop"]


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
    one is added if twins, in which nothing is missing, hardly ever show an effect so good.

    Parameters
    ----------
    declared : DeclaredModel or pysindy.SINDy
        The model so far; a SINDy model may be fitted or not.
    train : Record or sequence of Record
        Measurements to fit on and to search in.
    test : Record or sequence of Record, optional
        Measurements to judge on, which decide nothing. Without them the last of several records,
        or the last 30 % of a single one, are held out.
    significance : float
        Chance to add an effect where nothing is missing, in (0, 1).
    n_twins : int
        Twins of each step. The smallest possible p-value is 1 / (n_twins + 1).
    min_share : float
        An effect must remove at least this share of the error variance that all candidates
        together could remove, in the derivative or in the simulation, or halve the error that is
        left. Real records always hold traces of something; this says how small a trace matters.
    max_effects : int
        Stop once there are so many effects; two that only show together may make it one more. 0
        only fits the declared model and asks whether it is all.
    refine : {"auto", "derivative", "simulation"}
        Error that the final coefficients minimize. By default it is that of the simulation where
        this predicts parts of the training data better that it was not fitted on, and only there.
    operators : sequence of str or Operator
        Basis functions of the terms that are grown where no name fits; empty to grow none.
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
    An interrupt (Ctrl-C) ends the search. What was found until then is reported; if that is nothing
    yet, KeyboardInterrupt is raised. Expect 5 to 20 s of one quiet core for 10 000 samples, and
    more with each effect found. The matrices are small, so the linear algebra runs on one thread.

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
    design, fit_on, judge_on, shown = _checked(declared, train, test)
    if not shown:
        rules = replace(rules, max_effects=0)
    rng = generator(random_state)
    wide = widened(fit_on)
    if design.algebraic:  # nothing is simulated, and a target explains nothing
        rules = replace(rules, refine="derivative")
        wide = [replace(r, x=np.zeros_like(r.x)) for r in wide]
    if may_stop_itself(design, fit_on, rules, rng):
        fit_on, judge_on, wide = map(_believed, (fit_on, judge_on, wide))
    part = witnessed(design, wide)
    rules = replace(rules, by_trajectory=part.by_trajectory)
    basis = resolve(operators, "close_loop") if operators else ()
    search = Search(design, fit_on, part, rules, basis, rng)
    is_whole = _run(search) and len(search.findings) < rules.max_effects
    return settled(search, judge_on, is_whole)


def _checked(
    declared: DeclaredModel | ps.SINDy,
    train: Record | Sequence[Record],
    test: Record | Sequence[Record] | None,
) -> tuple[Design, list[Record], list[Record], bool]:
    """Return the design, records that fit each other, and whether they show the motion."""
    fit_on, judge_on = split_records(train, test)
    design = design_of(declared, fit_on)
    is_cut = not test and (isinstance(train, Record) or len(train) == 1)
    whole = sum(record.n_samples for record in (*fit_on, *judge_on)) if is_cut else 0
    check_records(design, [*fit_on, *judge_on], whole)
    shown = True
    if not design.algebraic:
        fit_on, judge_on, shown = with_own_slopes(design, fit_on, judge_on)
    # A force that nothing integrates follows a held input at once.
    made = as_algebraic if design.algebraic else as_held
    held = held_inputs(fit_on)
    like = alike(fit_on, judge_on)
    fit_on, judge_on = (
        [made(hold(record, held)) for record in records]
        for records in (undecimated(*like) if design.algebraic else like)
    )
    if not design.algebraic:
        design = doubted(design, fit_on)
    return design, fit_on, judge_on, shown


def _believed(records: Sequence[Record]) -> list[Record]:
    """Return records whose readings at a limit are measurements, for the state ends there."""
    return [replace(record, seen=None) for record in records]


def _run(search: Search) -> bool:
    """Search, and tell whether the search came to its end; an interrupt keeps what was found."""
    try:
        search.run()
    except KeyboardInterrupt:
        if not search.findings:
            raise
        return False
    return True
