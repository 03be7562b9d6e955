"""The given model and records, checked and brought to one form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pysindy as ps

from ...signals import Record
from ...signals.zero_order_hold import hold
from .algebraic import as_algebraic
from .declared import DeclaredModel, design_of, with_contradicted
from .design import Design
from .held import held_inputs
from .input_errors import as_held
from .input_functions import with_functions
from .record_checks import check_records, doubt_held_out
from .record_split import split_records
from .resampling import at_one_step, undecimated, widened
from .smoothing import with_own_slopes


@dataclass(frozen=True)
class Given:
    """A declared model, and records that fit it and each other.

    Attributes
    ----------
    design : Design
        The declared model.
    train, test : list of Record
        Training records and held-out ones.
    wide : list of Record
        Training records with the higher cutoff of the search. Of an algebraic target x is zero
        there, since it must not explain itself.
    shows_motion : bool
        False if the derivatives that the user gave are smoothed so strongly that no effect can be
        seen.
    """

    design: Design
    train: list[Record]
    test: list[Record]
    wide: list[Record]
    shows_motion: bool = True

    def with_clipping_as_true(self) -> Given:
        """Return the same with clipped readings taken as true values: the state itself stops."""
        train, test, wide = (
            [replace(record, seen=None) for record in records]
            for records in (self.train, self.test, self.wide)
        )
        return replace(self, train=train, test=test, wide=wide)


def checked_model_and_records(
    declared: DeclaredModel | ps.SINDy,
    train: Record | Sequence[Record],
    test: Record | Sequence[Record] | None,
) -> Given:
    """Return what `close_loop` is given, checked and brought to one form.

    Parameters
    ----------
    declared, train, test
        As in `close_loop`.

    Returns
    -------
    Given

    Raises
    ------
    ValueError
        If the records do not fit the model or each other.
    TypeError
        If something is of the wrong type.
    """
    fit_on, judge_on = split_records(train, test)
    design = design_of(declared, fit_on)
    is_split = not test and (isinstance(train, Record) or len(train) == 1)
    n_whole = sum(record.n_samples for record in (*fit_on, *judge_on)) if is_split else 0
    check_records(design, [*fit_on, *judge_on], n_whole)
    doubt_held_out(fit_on, judge_on)
    if design.algebraic:
        # An algebraic target is not integrated, so it follows a held input at once.
        held, resampled = held_inputs(fit_on), undecimated(*at_one_step(fit_on, judge_on))
        fit_on, judge_on = ([as_algebraic(hold(r, held)) for r in records] for records in resampled)
        wide = [replace(r, x=np.zeros_like(r.x)) for r in widened(fit_on)]
        return Given(design, fit_on, judge_on, wide)
    fit_on, judge_on, shows_motion = with_own_slopes(design, fit_on, judge_on)
    held, resampled = held_inputs(fit_on), at_one_step(fit_on, judge_on)
    fit_on, judge_on = ([hold(r, held) for r in records] for records in resampled)
    acting = [as_held(record) for record in with_functions(design, fit_on, judge_on)]
    fit_on, judge_on = acting[: len(fit_on)], acting[len(fit_on) :]
    return Given(with_contradicted(design, fit_on), fit_on, judge_on, widened(fit_on), shows_motion)
