"""One effect in two equations, in place of a different one in each.

What one species loses another gains, and a force between two bodies acts on both: one expression
stands in two equations. Unless these share a coefficient of the declared model, a search looks at
one equation at a time, and noise lets another form win in either. Both together tell more. Nor can
one of two wrong forms be exchanged alone where a shared coefficient has made each fit the other. So
every two effects of different equations are compared with those that may stand in both.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations

from tqdm.auto import tqdm

from ...signals import Record
from ...terms import Sum
from ..effects.candidate import OFFSET, Candidate
from ..effects.differences import gripping_stretches
from ..effects.missing import beside, candidates, terms_in, with_parents
from ..effects.names import EVOLVED
from ..effects.partners import acting_in, apart, joined
from ..effects.shaping import shape_of
from ..evidence.findings import Finding, excluding, is_needed, with_columns
from ..evidence.scoring import MIN_GAIN_LOG, score, tuned
from ..fitting.trial import converged
from ..given.design import Design
from ..given.rows import have_values
from ..given.rules import Rules
from ..given.segments import Segments
from .contenders import N_RIVALS, Pool, steady_drift, trial_with
from .one_for_one import best_of
from .shape_tuning import Contender, tuned_by_runs
from .variants import Model


def one_in_two_equations(
    model: Model, findings: Sequence[Finding], pool: Pool, records: Sequence[Record], rules: Rules
) -> list[Finding]:
    """Return the findings, two of them replaced by one effect in both equations if that is closer.

    Parameters
    ----------
    model : Model
        The declared model, with the memories and limits among the findings.
    findings : sequence of Finding
        What was found.
    pool : Pool
        Candidates that may replace two effects, besides those of the vocabulary.
    records : sequence of Record
        Training records, before memories are applied.
    rules : Rules
        Gives the significance.

    Returns
    -------
    list of Finding
        They keep their p-values: that an effect is missing there was tested before.
    """
    kept = list(findings)
    places = [(i, j) for i, j in combinations(range(len(kept)), 2) if _may_share(kept[i], kept[j])]
    for pair in tqdm(places, desc="free runs", disable=not rules.progress, leave=False):
        both = [kept[place] for place in pair]
        rest = excluding(kept, *both)
        if any(is_needed(finding, rest) for finding in both):
            continue
        without = replace(model, design=with_columns(model.design, rest))
        present = [finding.candidate for finding in both]
        closest = _closest(present, without, pool, records, rules)
        for place, effect in zip(pair, closest, strict=True):
            own = beside(effect, without.design)
            kept[place] = kept[place].with_candidate(own, without.design)
    return kept


def _may_share(first: Finding, second: Finding) -> bool:
    """Tell whether two effects are terms of two equations."""
    in_two = first.candidate.state != second.candidate.state
    return in_two and bool(first.columns) and bool(second.columns)


def _closest(
    present: Sequence[Candidate], model: Model, pool: Pool, records: Sequence[Record], rules: Rules
) -> tuple[Candidate, ...]:
    """Return the effects of two equations whose runs come closest, in a model without them."""
    drift = steady_drift(model, present, records)
    if drift is None:
        return tuple(present)
    acted = model.acted(records)
    rivals = [one for one in _shared(present, model.design, pool) if have_values(one.terms, acted)]
    if not rivals:
        return tuple(present)
    separate, *fitted = converged([drift.trial, *(trial_with(model, [c], drift) for c in rivals)])
    shared = tuned_by_runs(list(map(Contender, rivals, fitted)), model, drift)
    contenders = [Contender(present[0], separate, tied=True), *shared]
    best = best_of(contenders, pool.matter, rules.significance / len(rivals)).candidate
    return tuple(present) if best is present[0] else apart(best)


def _shared(present: Sequence[Candidate], design: Design, pool: Pool) -> list[Candidate]:
    """Return the effects of both equations that do best in the spectral view.

    The best of each form is tuned before: the less noise there is, the less does a place of the
    grid tell of the best one.
    """
    first, second = (effect.state for effect in present)
    ranges = pool.part.ranges
    named = [*candidates(design, ranges), *gripping_stretches(design, ranges)]
    offered = with_parents(named, design)
    grown = [one for one in (*present, *pool.grown) if one.name == EVOLVED]
    options = [*acting_in((first, second), offered), *_grown_in_both(grown, first, second, design)]
    best = [tuned(one, design, pool.part) for one in _best_forms(options, design, pool.part)]
    return _best_forms(best, design, pool.part)[:N_RIVALS]


def _best_forms(options: Sequence[Candidate], design: Design, part: Segments) -> list[Candidate]:
    """Return the best of the candidates that differ only in their numbers, best first."""
    scores = score(design, part, list(dict.fromkeys(options)), pairs=False)
    best: dict[object, Candidate] = {}
    for one in (s.group[0] for s in scores if s.value > MIN_GAIN_LOG):
        is_named = one.name != EVOLVED and one.shape is not None
        best.setdefault((one.name, one.branch) if is_named else one.form, one)
    return list(best.values())


def _grown_in_both(
    grown: Iterable[Candidate], first: int, second: int, design: Design
) -> Iterator[Candidate]:
    """Yield each grown term as one of two equations, whose numbers are tuned in both at once."""
    present = terms_in(design)
    for one in grown:
        shaped = replace(one, shape=shape_of(one, design.constants), parents=())
        yield joined([_in_equation(shaped, state, present) for state in (first, second)])


def _in_equation(one: Candidate, state: int, present: set[tuple[int, Sum]]) -> Candidate:
    """Return a candidate for another equation, without an offset that this one has already."""
    moved = replace(one, state=state)
    if (state, OFFSET) not in present:
        return moved
    shape, kept = one.shape, [k for k, term in enumerate(one.terms) if term != OFFSET]
    if shape is not None:
        shape = replace(shape, builds=tuple(shape.builds[k] for k in kept))
    return replace(moved, terms=tuple(one.terms[k] for k in kept), shape=shape)
