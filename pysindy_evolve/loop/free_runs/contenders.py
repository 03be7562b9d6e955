"""Contenders for the place of an effect: those that come closest to it, fitted by free runs."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...operators import Operator
from ...signals import Record
from ..effects.candidate import Candidate
from ..effects.differences import gripping_stretches
from ..effects.missing import candidates
from ..effects.names import EVOLVED
from ..effects.periodic import other_ripples
from ..effects.pumped_terms import other_pumps, pumps_between
from ..evidence.plainest import is_as_good
from ..evidence.scoring import columns_of, score, sharpened
from ..fitting.fit import refit
from ..fitting.trial import Trial, converged
from ..given.design import Design
from ..given.rows import have_values
from ..given.segments import Segments
from .drift import Drift, drift_of
from .leading_terms import stand_ins
from .other_forms import other_forms
from .quotients import as_quotients
from .shape_tuning import Contender, tuned_by_runs
from .variants import Model

N_RIVALS = 5  # effects that score best in the spectral view
STRETCHES = (16, 32, 64, 128)  # to try in this order; the first steady number is taken
# Factor by which a deviation may grow if it goes on growing; in chaos, long runs only compare luck,
# as those did in which deviations grew a hundredfold.
MAX_STEADY_GROWTH = 10.0


@dataclass(frozen=True, eq=False)
class Pool:
    """Candidates that may replace an effect, besides those of the vocabulary.

    Attributes
    ----------
    grown : sequence of Candidate
        Grown terms.
    small : sequence of Candidate
        Small terms, ranked by what free runs would gain from them to first order.
    part : Segments
        Pieces of the training records as they were searched.
    matter : float
        Least gain in log error that matters.
    operators : collection of Operator
        Basis functions of grown terms.
    """

    grown: Sequence[Candidate]
    small: Sequence[Candidate]
    part: Segments
    matter: float
    operators: Collection[Operator] = ()

    def promises(self, group: Sequence[Candidate], drift: Drift, least: float) -> bool:
        """Tell whether one term gains so much in the place of a group, to first order.

        Parameters
        ----------
        group : sequence of Candidate
            Effects of one equation.
        drift : Drift
            The model with the group as its last columns.
        least : float
            Log error that the term must gain.
        """
        acted = drift.model.acted(drift.records)
        terms = tuple(term for one in group for term in one.terms)
        usable = [one for one in (*self.small, *self.grown) if have_values(one.terms, acted)]
        return bool(stand_ins(drift, replace(group[0], terms=terms), usable, least))

    def contenders(
        self, model: Model, own: Contender, drift: Drift, group: Sequence[Candidate] = ()
    ) -> list[Contender]:
        """Return an effect and the few that come closest to it, all tuned by their runs.

        Parameters
        ----------
        model : Model
            The model without the effect.
        own : Contender
            The effect, which comes first in the result.
        drift : Drift
            The model with the effect, or with a group of effects, as its last columns.
        group : sequence of Candidate, optional
            Effects, this one first, that a single contender may replace. Its other members are
            contenders too.
        """
        least = -np.inf if group else self.matter
        acted = model.acted(drift.records)
        usable = [one for one in self.grown if have_values(one.terms, acted)]
        terms = tuple(term for one in group or [own.candidate] for term in one.terms)
        leading = stand_ins(drift, replace(own.candidate, terms=terms), self.small, least)
        leading = [one for one in leading if have_values(one.terms, acted)]
        closest = _closest(model, own.candidate, usable, self.part)
        closest = [one for one in closest if have_values(one.terms, acted)]
        members = [replace(one, name=EVOLVED, parents=()) for one in group[1:]]
        length = max(float(np.ptp(record.t)) for record in drift.records)
        pumps = pumps_between(group, model.design, length)
        forms = [
            form
            for candidate in (own.candidate, *closest, *members)
            for form in other_forms(candidate, model.design, self.part, self.operators)
        ]
        forms = [one for one in forms if have_values(one.terms, acted)]
        usable = _as_named([*closest, *leading, *forms, *members, *pumps], model.design, self.part)
        rivals = [c for c in dict.fromkeys(usable) if c != own.candidate]
        started = [trial_with(model, [rival], drift) for rival in rivals]
        # The effect was fitted in other units of the errors, so it is fitted again.
        first, *fitted_rivals = converged([own.trial, *started])
        fitted = [Contender(own.candidate, first, own.tied), *map(Contender, rivals, fitted_rivals)]
        tuned = tuned_by_runs(fitted, model, drift)
        return [*tuned, *self._forms_of_best(tuned, model, drift)]

    def _forms_of_best(
        self, tuned: Sequence[Contender], model: Model, drift: Drift
    ) -> list[Contender]:
        """Return other forms of the best contender, made from its tuned numbers, and tuned."""
        best = plainest(tuned)
        if best.tied:
            return []
        design, known_terms = model.design, {one.candidate.terms for one in tuned}
        forms = [
            *other_forms(best.candidate, design, self.part, self.operators),
            *as_quotients(best.candidate, design, self.part),
        ]
        acted = model.acted(drift.records)
        new = [
            one for one in forms if one.terms not in known_terms and have_values(one.terms, acted)
        ]
        trials = converged([trial_with(model, [one], drift) for one in new])
        return tuned_by_runs(list(map(Contender, new, trials)), model, drift) if new else []


def plainest(contenders: Sequence[Contender]) -> Contender:
    """Return the plainest of the contenders that come as close to the record as the best."""
    least = min(one.error for one in contenders)
    as_good = [one for one in contenders if is_as_good(one.error, least)] or contenders
    return min(as_good, key=lambda one: (*one.candidate.plainness, one.error))


def _closest(
    model: Model, effect: Candidate, grown: Sequence[Candidate], part: Segments
) -> list[Candidate]:
    """Return the effects of the same equation that do best in the spectral view.

    Numbers are tuned before: a narrow dead zone between two widths of the grid would lose to a
    grown step. Of candidates that differ only in their numbers, the best is kept.
    """
    waves = [*other_pumps(effect, model.design), *other_ripples(effect, model.design, part.z)]
    named = [*candidates(model.design, part.ranges), *gripping_stretches(model.design, part.ranges)]
    options = [*named, *waves, *grown]
    same_equation = dict.fromkeys(
        c for c in options if c.state == effect.state and c.terms != effect.terms
    )
    scores = score(
        model.design, part, sharpened(model.design, part, list(same_equation)), pairs=False
    )
    best: dict[object, Candidate] = {}
    for candidate in (s.group[0] for s in scores):
        best.setdefault(candidate.form if candidate.shape is None else candidate.name, candidate)
    return list(best.values())[:N_RIVALS]


def _as_named(proposed: Sequence[Candidate], design: Design, part: Segments) -> list[Candidate]:
    """Return candidates; one with the terms of a named effect becomes that effect."""
    named = {(one.state, one.terms): one for one in candidates(design, part.ranges)}
    return [named.get((one.state, one.terms), one) for one in proposed]


def steady_drift(
    model: Model, effects: Sequence[Candidate], records: Sequence[Record]
) -> Drift | None:
    """Return the drift of a model with effects, over stretches on which deviations stay small."""
    return drift_of(*_fitted_with(model, effects, records), records, STRETCHES, MAX_STEADY_GROWTH)


def _fitted_with(
    model: Model, effects: Sequence[Candidate], records: Sequence[Record]
) -> tuple[Model, np.ndarray]:
    """Return a model with effects added, and its coefficients fitted to the derivative."""
    columns = [column for effect in effects for column in columns_of(effect, model.design)]
    with_effects = replace(model, design=model.design.adding(columns))
    return with_effects, refit(with_effects.design, model.acted(records), "derivative")


def trial_with(model: Model, effects: Sequence[Candidate], drift: Drift) -> Trial:
    """Return a trial of a model with effects added, started from the fit to the derivative."""
    with_effects, coef = _fitted_with(model, effects, drift.records)
    return with_effects.trial(coef, drift.trial.scale, drift.part)
