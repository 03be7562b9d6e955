"""One step of the loop: propose, score, test on twins."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from joblib import Parallel, delayed
from scipy.optimize import minimize_scalar
from tqdm.auto import tqdm

from ..equations import Equations
from ..signals import Record
from .design import Column, Design, in_state
from .effects import (
    VOCABULARY,
    Candidate,
    Shape,
    candidates,
    periodic_candidates,
    standing,
)
from .linear import solve
from .residual import derivative_grams, jacobian, view_grams
from .rules import Rules
from .segments import Segments, ranges, variables_of
from .spectral import spectral_grams
from .trace import Score, fold_errors, rank
from .twins import TwinMaker

__all__ = [
    "Finding",
    "columns_of",
    "exchange",
    "find",
    "is_exact",
    "propose",
    "prune",
    "score",
    "view_gain",
]


Proposer = Callable[[Design, Equations, Sequence[Record]], list[Candidate]]


@dataclass(frozen=True, eq=False)
class Finding:
    """An effect that passed, with its evidence.

    Attributes
    ----------
    candidate : Candidate
        Name, equation, terms.
    columns : tuple of Column
        Its columns in the design.
    score : float
        Log ratio of the errors without and with it, per effect of its group.
    p_value : float
        Chance that a twin shows a score as large.
    twin_scores : ndarray
        Best score found in each twin.
    alternatives : tuple of str
        Names of effects that do not do significantly worse.
    step : int
        Number of the step that found it; the effects of a pair share one.
    """

    candidate: Candidate
    columns: tuple[Column, ...]
    score: float
    p_value: float
    twin_scores: np.ndarray
    alternatives: tuple[str, ...]
    step: int = 0


def find(
    declared: Design,
    design: Design,
    records: Sequence[Record],
    part: Segments,
    rules: Rules,
    rng: np.random.Generator,
    proposer: Proposer | None = None,
) -> list[Finding]:
    """Return the effect, or the pair of effects, that a design lacks; nothing if none passes.

    Parameters
    ----------
    declared : Design
        The model at the start; shares are of its error.
    design : Design
        The model so far.
    records : sequence of Record
        Training records.
    part : Segments
        Pieces of them.
    rules : Rules
        When an effect counts.
    rng : numpy.random.Generator
        Draws the twins.
    proposer : callable, optional
        Maps design, equations and records to candidates; by default the vocabulary.

    Returns
    -------
    list of Finding
    """
    if is_exact(design, part):
        return []
    proposer = proposer or propose
    equations = quick_fit(design, part)
    proposed = proposer(design, equations, records)
    proposed = sharpened(design, part, proposed)
    scores = score(design, part, proposed)
    shares = Shares(declared, design, part, proposed)
    worthy = [s for s in scores if s.value > 0.0 and shares.of(s) >= rules.min_share]
    if not worthy:
        return []
    best = plainest(worthy)
    richer = design.adding(c for candidate in best.group for c in columns_of(candidate, design))
    maker = TwinMaker.of(equations, quick_fit(richer, part), records)
    statistic = partial(_best_score, design=design, proposer=proposer)
    twins = twin_values(maker, part, statistic, best.value, rules, rng)
    p_value = float((1.0 + np.sum(twins >= best.value)) / (1.0 + len(twins)))
    if p_value > rules.level:
        return []
    names = rivals(best, scores)
    group = [tuned(c, _beside(design, best.group, c), part) for c in best.group]
    return [Finding(c, columns_of(c, design), best.value, p_value, twins, names) for c in group]


def _beside(design: Design, group: Sequence[Candidate], one: Candidate) -> Design:
    """Return the design with the other candidates of a group in it."""
    others = (c for c in group if c is not one)
    return design.adding(column for c in others for column in columns_of(c, design))


def sharpened(design: Design, part: Segments, proposed: Sequence[Candidate]) -> list[Candidate]:
    """Return candidates with the promising shapes tuned, beside those on the grid.

    Between two places of the grid a power of the input can look more like a saturation than
    either of them does.
    """
    scores = score(design, part, proposed, pairs=False)
    leader = scores[0].value if scores else 0.0
    first: dict[tuple[str, int], Score] = {}
    for s in scores:
        if s.group[0].shape is not None and s.value > max(MARGIN, leader / 2):
            first.setdefault((s.group[0].name, s.group[0].state), s)
    return [*proposed, *(tuned(s.group[0], design, part) for s in first.values())]


def tuned(candidate: Candidate, design: Design, part: Segments) -> Candidate:
    """Tune the number that a candidate's shape depends on, from its place on the grid."""
    shape = candidate.shape
    if shape is None:
        return candidate

    def at(log_value: float) -> Candidate:
        value = float(np.exp(log_value))
        return replace(candidate, terms=(shape.build(value),), shape=Shape(shape.build, value))

    def loss(log_value: float) -> float:
        scores = score(design, part, [at(log_value)], pairs=False)
        return -scores[0].value if scores else 0.0

    start = float(np.log(shape.value))
    best = minimize_scalar(
        loss, bounds=(start - REACH, start + REACH), method="bounded", options={"maxiter": 16}
    )
    return at(float(best.x)) if best.fun < loss(start) else candidate


def is_exact(design: Design, part: Segments) -> bool:
    """Tell whether a design leaves no more than differentiation and filters get wrong anyway."""
    total = derivative_grams(part, design, design.columns).sum(axis=0)
    n_rows = len(part.z) * part.windows.count(part.z.shape[1]) * len(design.open_states)
    return _error(total, range(len(design.columns))) <= EXACT**2 * max(n_rows, 1)


def quick_fit(design: Design, part: Segments) -> Equations:
    """Fit a design on segments by its derivative."""
    total = derivative_grams(part, design, design.columns).sum(axis=0)
    return design.equations(solve(total[:-1, :-1], total[:-1, -1]))


def propose(design: Design, equations: Equations, records: Sequence[Record]) -> list[Candidate]:
    """Return what may be missing: the vocabulary, and the frequencies of the residual."""
    variables = np.concatenate([variables_of(record) for record in records])
    proposed = candidates(design, *ranges(variables))
    longest = max(records, key=len)
    residual = longest.x_dot - equations.evaluate(longest.x, longest.u, longest.t)
    time = len(design.states) + len(design.inputs)
    for state in design.open_states:
        drivers = longest.x[:, :0] if longest.u is None else longest.u
        proposed += periodic_candidates(state, time, residual[:, state], drivers, longest.dt)
    return proposed


def score(
    design: Design, part: Segments, proposed: Sequence[Candidate], *, pairs: bool = True
) -> list[Score]:
    """Score candidates on segments, each refitted together with the columns of the design."""
    extra = [column for candidate in proposed for column in columns_of(candidate, design)]
    n_fixed = len(design.columns)
    grams = spectral_grams(part, design, [*design.columns, *extra])
    return rank(grams, n_fixed, proposed, standing(design), pairs=pairs)


def columns_of(candidate: Candidate, design: Design) -> tuple[Column, ...]:
    """Return the columns that a candidate adds to a design."""
    n_states = len(design.states)
    return tuple(
        in_state(candidate.name, term, candidate.state, n_states) for term in candidate.terms
    )


class Shares:
    """What share of the explainable error, as a variance, the effects of a group remove.

    Explainable is what the declared model leaves and the model with all candidates does not. Of
    derivative and simulation the larger share counts: an offset hardly shows in the first, a
    ripple hardly in the second.
    """

    def __init__(
        self, declared: Design, design: Design, part: Segments, proposed: Sequence[Candidate]
    ) -> None:
        extra = [column for candidate in proposed for column in columns_of(candidate, design)]
        slopes = jacobian(quick_fit(design, part), part.z, part.state_scale)
        views = view_grams(part, design, [*design.columns, *extra], slopes)
        self._grams = {name: grams.sum(axis=0) for name, grams in views.items()}
        self._base = tuple(range(len(design.columns)))
        n_declared, n_columns = len(declared.columns), len(design.columns) + len(extra)
        self._explainable = {
            name: _error(gram, range(n_declared)) - _error(gram, range(n_columns))
            for name, gram in self._grams.items()
        }

    def of(self, score: Score) -> float:
        """Return the share that the least useful effect of a group removes."""
        return min(self._of_effect(score, k) for k in range(len(score.group)))

    def _of_effect(self, score: Score, k: int) -> float:
        start = sum(len(candidate.terms) for candidate in score.group[:k])
        own = score.places[start : start + len(score.group[k].terms)]
        others = tuple(place for place in score.places if place not in own)
        return max(
            (_error(gram, self._base + others) - _error(gram, self._base + score.places))
            / max(self._explainable[name], 1e-300)
            for name, gram in self._grams.items()
        )


def view_gain(design: Design, candidate: Candidate, part: Segments) -> float:
    """Return log(error without / error with), the larger one of derivative and simulation.

    Each fold of segments is predicted from the others.
    """
    columns = [*design.columns, *columns_of(candidate, design)]
    slopes = jacobian(quick_fit(design, part), part.z, part.state_scale)
    base, every = np.arange(len(design.columns))[None, :], np.arange(len(columns))[None, :]
    gains = []
    for grams in view_grams(part, design, columns, slopes).values():
        without, with_it = (fold_errors(grams, models).sum() for models in (base, every))
        gains.append(float(np.log(max(without, 1e-300) / max(with_it, 1e-300))))
    return max(gains)


def _error(gram: np.ndarray, columns: Sequence[int]) -> float:
    """Return what least squares on some columns leaves of the target's square."""
    index = np.asarray(columns, dtype=int)
    explained = solve(gram[np.ix_(index, index)], gram[index, -1]) @ gram[index, -1]
    return float(max(gram[-1, -1] - explained, 0.0))


def plainest(scores: Sequence[Score]) -> Score:
    """Return the smallest of the groups that do as well as the first, to one percent.

    Of equally small ones, powers come before sines, as in the vocabulary.
    """
    equal = [
        s
        for s in scores
        if s.value >= 0.99 * scores[0].value and len(s.group) == len(scores[0].group)
    ]

    def plainness(score: Score) -> tuple[int, int]:
        size = sum(candidate.size for candidate in score.group)
        return size, sum(VOCABULARY.index(candidate.name) for candidate in score.group)

    return min(equal, key=plainness)


Statistic = Callable[[Segments, list[Record]], float]


def twin_values(
    maker: TwinMaker,
    part: Segments,
    statistic: Statistic,
    observed: float,
    rules: Rules,
    rng: np.random.Generator,
) -> np.ndarray:
    """Return a statistic of each twin: what the same search finds where nothing is missing.

    Twins come in batches; once enough of them do better than what was observed for it to fail,
    the rest are spared (Besag and Clifford 1991, DOI 10.1093/biomet/78.2.301).
    """
    children = rng.spawn(rules.n_twins)
    allowed = rules.level * (rules.n_twins + 1) - 1.0
    found: list[float] = []
    bar = tqdm(total=rules.n_twins, desc="twins", disable=not rules.progress, leave=False)
    with Parallel(n_jobs=rules.n_jobs) as parallel, bar:
        for start in range(0, rules.n_twins, BATCH):
            batch = children[start : start + BATCH]
            found += parallel(delayed(_in_twin)(maker, part, statistic, c) for c in batch)
            bar.update(len(batch))
            if np.sum(np.array(found) >= observed) > allowed:
                break
    return np.array(found)


def _in_twin(
    maker: TwinMaker, part: Segments, statistic: Statistic, rng: np.random.Generator
) -> float:
    twins = maker.make(rng)
    return statistic(part.of(twins), twins)


def _best_score(
    part: Segments, records: list[Record], *, design: Design, proposer: Proposer
) -> float:
    proposed = proposer(design, quick_fit(design, part), records)
    return max((s.value for s in score(design, part, proposed)), default=0.0)


def rivals(best: Score, scores: Sequence[Score]) -> tuple[str, ...]:
    """Return names of other effects that do as well within one standard error over the folds."""
    names, own = [], {candidate.name for candidate in best.group}
    for other in scores:
        if len(other.group) != len(best.group):
            continue
        gap = np.log((other.errors + 1e-300) / (best.errors + 1e-300))
        standard_error = gap.std(ddof=1) / np.sqrt(len(gap)) if len(gap) > 1 else np.inf
        if gap.mean() <= standard_error:
            names += [c.name for c in other.group if c.name not in own]
    return tuple(dict.fromkeys(names))


def exchange(declared: Design, findings: list[Finding], part: Segments) -> list[Finding]:
    """Replace an earlier effect where another one does better beside what was found later.

    Effects that only work together may enter one after the other, and the first of them under a
    wrong name: cubic damping for drag, as long as the friction is not there yet.
    """
    for place, finding in enumerate(findings[:-1]):
        rest = [f for k, f in enumerate(findings) if k != place]
        parents = {parent for f in rest for parent in f.candidate.parents}
        if parents & set(finding.candidate.terms):
            continue
        design = declared.adding(column for f in rest for column in f.columns)
        variables = part.z.reshape(-1, part.z.shape[-1])
        options = dict.fromkeys([*candidates(design, *ranges(variables)), finding.candidate])
        scores = score(design, part, list(options), pairs=False)
        own = next((s for s in scores if s.group == (finding.candidate,)), None)
        if own is not None and scores[0].value > own.value + MARGIN:
            better = scores[0].group[0]
            findings[place] = replace(
                finding,
                candidate=better,
                columns=columns_of(better, design),
                score=scores[0].value,
                alternatives=rivals(scores[0], scores),
            )
    return findings


BATCH = 4  # twins between two looks at whether the rest can be spared
EXACT = 3e-4  # derivative error, in standard deviations, below which no sensor sees a difference
REACH = 1.2  # of the logarithm of a shape about its place on the grid: a factor of three
MARGIN = 0.02  # of the log error: names do not change for less


def prune(declared: Design, findings: list[Finding], part: Segments) -> list[Finding]:
    """Drop effects that later ones made superfluous, unless one of those needs them."""
    for finding in list(findings):
        rest = [f for f in findings if f is not finding]
        needed = {parent for f in rest for parent in f.candidate.parents}
        if needed & set(finding.candidate.terms):
            continue
        design = declared.adding(column for f in rest for column in f.columns)
        scores = score(design, part, [finding.candidate], pairs=False)
        if not scores or scores[0].value < MARGIN:
            findings = rest
    return findings
