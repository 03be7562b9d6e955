"""Probes: memories that an input may have, tried beside all other effects in the same search.

The response of each memory of a grid becomes one more input of the records: a probe. A model with
the probe in place of the input has as many coefficients as before, and is proposed if it predicts
held-out segments better. Twins carry the same probes, so the search in them is the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from ...equations import Equations
from ...hidden_states.memory import DELAY, LAG, VESSEL, Memory
from ...signals import Record
from ...substitution import substituted
from ...terms import Sum, sub, variable
from ..effects.candidate import Candidate, rewritten
from ..evidence.held_out_scores import fold_errors
from ..evidence.scoring import Proposer
from ..evidence.spectral import spectral_grams
from ..fitting.linear import log_ratio, summed
from ..given.design import Column, Design
from ..given.segments import Segments
from .chains import with_trade

# Delay or time constant, in periods of the highest frequency looked at.
MIN_LENGTH_IN_PERIODS = 0.02
RATIO = 2.5  # of neighboring lengths on the grid
MAX_LENGTH_SHARE = 0.25  # share of a segment; of a record for a lag or a vessel
OWN = 0.5  # share of the gain of input and probe together that the probe alone must reach


@dataclass(frozen=True)
class MemoryCandidate(Candidate):
    """A memory that an input may have."""

    memory: Memory = field(kw_only=True)

    @property
    def is_exchange(self) -> bool:
        """Whether it changes what a term of the model depends on, instead of adding one."""
        return True


def users_of(design: Design, column: int) -> tuple[int, ...]:
    """Return the open states whose equations depend on an input."""
    index = len(design.states) + column
    return tuple(
        state
        for state in design.open_states
        if any(index in part.variables for part in design.sides_of(state))
    )


def grid_of(design: Design, part: Segments, present: Sequence[Memory] = ()) -> list[Memory]:
    """Return the memories to try: of each input that acts, from very short to very long ones.

    Parameters
    ----------
    design : Design
        The model so far.
    part : Segments
        Pieces of the training records.
    present : sequence of Memory
        Memories that the inputs have already. No kind is tried twice; for another one they may be
        shortened, see `with_trade`.

    Returns
    -------
    list of Memory
    """
    highest = min(part.cutoff, 0.5 / part.dt)
    segment = part.z.shape[1] * part.dt
    record = min(len(r) for r in part.records) * part.dt
    found = []
    for column in range(0 if design.algebraic or part.by_trajectory else len(design.inputs)):
        if not users_of(design, column):
            continue
        kinds = {memory.kind for memory in present if memory.column == column}
        longest = {DELAY: MAX_LENGTH_SHARE * segment}
        longest[LAG] = max(longest[DELAY], MAX_LENGTH_SHARE * record)
        if all(r.raw_u[:, column].min() >= 0.0 for r in part.records):
            longest[VESSEL] = longest[LAG]
        if {LAG, VESSEL} & kinds:
            longest.pop(LAG)
            longest.pop(VESSEL, None)
        for kind in (k for k in longest if k not in kinds):
            value = MIN_LENGTH_IN_PERIODS / highest
            while value < longest[kind]:
                found.append(with_trade(Memory(kind, column, (value,)), present))
                value *= RATIO
    return found


@dataclass(frozen=True, eq=False)
class Probes:
    """Memories as further inputs of a design and of its records.

    Attributes
    ----------
    design : Design
        The model so far.
    memories : tuple of Memory
        The memories to try.
    """

    design: Design
    memories: tuple[Memory, ...]

    def widen(self, expression: Sum) -> Sum:
        """Return an expression with its variables numbered as with probes, time last."""
        time = self.design.time
        if time not in expression.variables:
            return expression
        return substituted(expression, {time: variable(time + len(self.memories))})

    def narrow(self, expression: Sum) -> Sum:
        """Return an expression with its variables numbered as without probes."""
        time = self.design.time
        moved = time + len(self.memories)
        if moved not in expression.variables:
            return expression
        return substituted(expression, {moved: variable(time)})

    def widened(self, design: Design) -> Design:
        """Return a design with the probes as further inputs, which nothing depends on."""
        names = tuple(f"probe{k}" for k in range(len(self.memories)))
        columns = tuple(
            replace(c, parts=tuple(self.widen(part) for part in c.parts)) for c in design.columns
        )
        fixed = tuple(self.widen(part) for part in design.fixed)
        return replace(design, inputs=(*design.inputs, *names), fixed=fixed, columns=columns)

    def extended(self, record: Record) -> Record:
        """Return a record with the probes as further inputs."""
        return replace(record, inputs=None).with_inputs(self._beside)

    def extended_pieces(self, part: Segments) -> Segments:
        """Return pieces with the probes as further inputs."""
        return part.of([self.extended(record) for record in part.records])

    def _beside(self, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        probes = [memory.response(t, u[:, memory.column]) for memory in self.memories]
        return np.column_stack([u, *probes])

    def propose(
        self, design: Design, equations: Equations, part: Segments, *, offer: Proposer
    ) -> list[Candidate]:
        """Return the effects that are on offer, and for each input the best memory of each kind."""
        n_inputs = len(self.design.inputs)
        records = [replace(r, u=None if r.u is None else r.u[:, :n_inputs]) for r in part.records]
        terms = tuple(self.narrow(Sum(((1.0, term),))).parts[0][1] for term in equations.terms)
        plain = replace(equations, terms=terms, inputs=self.design.inputs)
        proposed = [rewritten(c, self.widen) for c in offer(self.design, plain, part.of(records))]
        return [*proposed, *self._best(design, part)]

    def _best(self, design: Design, part: Segments) -> list[Candidate]:
        """Return the best memory of each kind and input, if it does better than none."""
        swaps = [self.swap(k) for k in range(len(self.memories))]
        best: dict[tuple[str, int], tuple[float, int]] = {}
        for k, exchange in enumerate(exchanges(design, part, swaps)):
            if exchange.gain > OWN * max(exchange.gain_beside, 0.0):
                key = self.memories[k].kind, self.memories[k].column
                best[key] = max(best.get(key, (0.0, k)), (exchange.gain, k))
        return [self.candidate(design, k) for gain, k in best.values() if gain > 0.0]

    def swap(self, k: int) -> dict[int, Sum]:
        """Return the substitution of a probe for its input."""
        probe = self.design.time + k
        return {len(self.design.states) + self.memories[k].column: variable(probe)}

    def candidate(self, design: Design, k: int) -> MemoryCandidate:
        """Return a memory as a candidate: its terms are what it changes in a widened design."""
        memory = self.memories[k]
        state = users_of(self.design, memory.column)[0]
        swap = self.swap(k)
        terms = tuple(
            sub(substituted(part, swap), part)
            for part in design.sides_of(state)
            if set(swap) & part.variables
        )
        return MemoryCandidate(memory.kind, state, terms, memory=memory)


@dataclass(frozen=True, eq=False)
class Exchange:
    """Held-out errors without and with variables replaced, shape (n_folds,) each.

    Attributes
    ----------
    without, alone, beside : ndarray
        Errors with the original, with the replacement, and with both.
    """

    without: np.ndarray
    alone: np.ndarray
    beside: np.ndarray

    @property
    def gain(self) -> float:
        """log(error before / after)."""
        return log_ratio(self.without.sum(), self.alone.sum())

    @property
    def gain_beside(self) -> float:
        """The same with original and replacement together."""
        return log_ratio(self.without.sum(), self.beside.sum())


def exchanges(design: Design, part: Segments, swaps: Sequence[dict[int, Sum]]) -> list[Exchange]:
    """Apply each of several substitutions to a design, and predict held-out segments.

    Parameters
    ----------
    design : Design
        The model.
    part : Segments
        Pieces to predict from one another.
    swaps : sequence of dict of int to Sum
        Each says which variables are replaced, and by what.

    Returns
    -------
    list of Exchange
    """
    columns = list(design.columns)
    n_fixed = len(columns)
    places = []
    for swap in swaps:
        new = {
            k: _swapped(column, tuple(swap.items()))
            for k, column in enumerate((*design.columns, Column("known", design.fixed)))
            if any(set(swap) & p.variables for p in column.parts)
        }
        places.append({k: len(columns) + i for i, k in enumerate(new)})
        columns += new.values()
    grams = spectral_grams(part, design, [*columns, Column("known", design.fixed)])
    by_fold = summed(grams, part.folds)
    targets = [place.get(n_fixed) for place in places]
    replaced = [tuple(place.get(k, k) for k in range(n_fixed)) for place in places]
    extended = [
        (*range(n_fixed), *(p for k, p in place.items() if k < n_fixed)) for place in places
    ]
    (without,) = _errors(by_fold, [tuple(range(n_fixed))], [None])
    alone, beside = (_errors(by_fold, models, targets) for models in (replaced, extended))
    return [Exchange(without, *errors) for errors in zip(alone, beside, strict=True)]


def _errors(
    grams: np.ndarray, models: Sequence[tuple[int, ...]], targets: Sequence[int | None]
) -> list[np.ndarray]:
    """Return the errors of models in each fold, all models of one length and target at once."""
    alike: dict[tuple[int | None, int], list[int]] = {}
    for i, (model, target) in enumerate(zip(models, targets, strict=True)):
        alike.setdefault((target, len(model)), []).append(i)
    every_fold, found = np.arange(len(grams)), dict[int, np.ndarray]()
    for (target, _), members in alike.items():
        targeted = grams if target is None else _with_target(grams, target)
        errors = fold_errors(targeted, np.array([models[i] for i in members]), every_fold)
        found |= dict(zip(members, errors, strict=True))
    return [found[i] for i in range(len(models))]


@lru_cache(maxsize=4096)  # each twin asks for the same ones
def _swapped(column: Column, swap: tuple[tuple[int, Sum], ...]) -> Column:
    return replace(column, parts=tuple(substituted(part, dict(swap)) for part in column.parts))


def _with_target(grams: np.ndarray, place: int) -> np.ndarray:
    """Exchange the known parts in the target, next to last, for those at a place."""
    last = grams.shape[1] - 1
    change = np.eye(last + 1)
    change[last - 1, last], change[place, last] = 1.0, -1.0  # target + known - changed known
    return np.asarray(change.T @ grams @ change)
