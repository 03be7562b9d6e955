"""What may take the place of an effect: the few that come closest to it, fitted by free runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...signals import Record
from ..effects.candidate import Candidate
from ..effects.missing import candidates
from ..effects.names import EVOLVED
from ..effects.pumps import other_pumps
from ..evidence.scoring import MARGIN, columns_of, score, sharpened
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

__all__ = ["Pool", "begun_with", "plainest", "steady_drift"]

N_RIVALS = 5  # that come closest in the spectral view
STRETCHES = (16, 32, 64, 128)  # the fewest that are steady
STEADY = 10.0  # times by which a deviation may grow: in chaos, long runs tell luck from luck


@dataclass(frozen=True, eq=False)
class Pool:
    """What may take the place of an effect, besides the effects of the vocabulary.

    Attributes
    ----------
    grown : sequence of Candidate
        Grown terms.
    small : sequence of Candidate
        Terms that count where runs show that what stands there leaves something.
    part : Segments
        Pieces of the training records as they were searched.
    matter : float
        Log error by which runs must come closer for it to matter.
    """

    grown: Sequence[Candidate]
    small: Sequence[Candidate]
    part: Segments
    matter: float

    def contenders(
        self, model: Model, own: Contender, drift: Drift, group: Sequence[Candidate] = ()
    ) -> list[Contender]:
        """Return an effect and the few that come closest to it, all tuned by their runs.

        Parameters
        ----------
        model : Model
            The model without the effect.
        own : Contender
            The effect, which comes first.
        drift : Drift
            The model with the effect, or with a group of effects, its last columns.
        group : sequence of Candidate, optional
            Effects of which this is the first, and which one may replace: one of them, too.
        """
        least = -np.inf if group else self.matter
        acted = model.acted(drift.records)
        able = [one for one in self.grown if have_values(one.terms, acted)]
        terms = tuple(term for one in group or [own.candidate] for term in one.terms)
        shown = stand_ins(drift, replace(own.candidate, terms=terms), self.small, least)
        shown = [one for one in shown if have_values(one.terms, acted)]
        closest = _closest(model, own.candidate, able, self.part)
        members = [replace(one, name=EVOLVED, parents=()) for one in group[1:]]
        forms = [
            form
            for candidate in (own.candidate, *closest, *members)
            for form in other_forms(candidate, model.design, self.part)
        ]
        forms = [one for one in forms if have_values(one.terms, acted)]
        able = _as_named([*closest, *shown, *forms, *members], model.design, self.part)
        rivals = [c for c in dict.fromkeys(able) if c != own.candidate]
        begun = [begun_with(model, [rival], drift) for rival in rivals]
        # The effect itself was fitted in other units of the errors.
        first, *others = converged([own.trial, *begun])
        fitted = [Contender(own.candidate, first, own.tied), *map(Contender, rivals, others)]
        tuned = tuned_by_runs(fitted, model, drift)
        return [*tuned, *self._forms_of_best(tuned, model, drift)]

    def _forms_of_best(
        self, tuned: Sequence[Contender], model: Model, drift: Drift
    ) -> list[Contender]:
        """Return what the best contender stands for, with its numbers as they are now, tuned."""
        best = plainest(tuned)
        if best.tied:
            return []
        design, known = model.design, {one.candidate.terms for one in tuned}
        forms = [
            *other_forms(best.candidate, design, self.part),
            *as_quotients(best.candidate, design, self.part),
        ]
        acted = model.acted(drift.records)
        new = [one for one in forms if one.terms not in known and have_values(one.terms, acted)]
        trials = converged([begun_with(model, [one], drift) for one in new])
        return tuned_by_runs(list(map(Contender, new, trials)), model, drift) if new else []


def plainest(contenders: Sequence[Contender]) -> Contender:
    """Return the plainest of the contenders that come closest to the record."""
    least = min(one.error for one in contenders)
    as_good = [one for one in contenders if one.error <= np.exp(MARGIN) * least] or contenders
    return min(as_good, key=lambda one: (*one.candidate.plainness, one.error))


def _closest(
    model: Model, own: Candidate, grown: Sequence[Candidate], part: Segments
) -> list[Candidate]:
    """Return the effects of the same equation that do best in the spectral view.

    A narrow dead zone between two places of the grid would lose to a grown step, so its width is
    tuned before. Of those that differ in their numbers alone, one is enough.
    """
    pumps = other_pumps(own, model.design)
    options = [*candidates(model.design, part.ranges), *pumps, *grown]
    alike = dict.fromkeys(c for c in options if c.state == own.state and c.terms != own.terms)
    scores = score(model.design, part, sharpened(model.design, part, list(alike)), pairs=False)
    best: dict[object, Candidate] = {}
    for candidate in (s.group[0] for s in scores):
        best.setdefault(candidate.form if candidate.shape is None else candidate.name, candidate)
    return list(best.values())[:N_RIVALS]


def _as_named(some: Sequence[Candidate], design: Design, part: Segments) -> list[Candidate]:
    """Return candidates, each as the effect of the vocabulary that it is, if it is one."""
    named = {(one.state, one.terms): one for one in candidates(design, part.ranges)}
    return [named.get((one.state, one.terms), one) for one in some]


def steady_drift(
    model: Model, effects: Sequence[Candidate], records: Sequence[Record]
) -> Drift | None:
    """Return runs of a model with effects over stretches on which deviations stay small."""
    return drift_of(*_fitted_with(model, effects, records), records, STRETCHES, STEADY)


def _fitted_with(
    model: Model, effects: Sequence[Candidate], records: Sequence[Record]
) -> tuple[Model, np.ndarray]:
    """Return a model with effects, and the coefficients that the derivative gives."""
    columns = [column for one in effects for column in columns_of(one, model.design)]
    whole = replace(model, design=model.design.adding(columns))
    return whole, refit(whole.design, model.acted(records), "derivative")


def begun_with(model: Model, effects: Sequence[Candidate], drift: Drift) -> Trial:
    """Return a trial of a model with effects, begun where the derivative says."""
    whole, coef = _fitted_with(model, effects, drift.records)
    return whole.trial(coef, drift.trial.scale, drift.part)
