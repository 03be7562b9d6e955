"""A model for free runs, and variants of it that hold what may be missing.

Derivatives of a noisy record do not show slow effects: a vessel between the pump and the level, an
overflow, a lag of minutes. A free run shows them by drifting away from the record. A variant puts
another memory behind an input, or adds a term.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...hidden_states.memory import VESSEL, Memory, all_with_memories, with_past_inputs
from ...signals import Record
from ...terms import variable
from ..effects.candidate import Candidate
from ..effects.names import order_of
from ..fitting.trial import Trial
from ..given.band import driven, straightened
from ..given.design import Column, Design
from ..given.limits import Limit, limited
from ..given.segments import Segments
from ..memories.probes import grid_of, users_of

Pasts = tuple[tuple[float, ...], ...]  # for each record, its inputs before it began

BRIMS = (0.55, 0.7, 0.85)  # heights, relative to the highest level of a vessel without a brim
SHARES = (0.0, 1.0)  # of the overflow that arrives: none, or all of it


@dataclass(frozen=True, eq=False)
class Model:
    """A design, with the memories and limits of its free runs.

    Attributes
    ----------
    design : Design
        Equations of the measured states.
    memories : tuple of Memory
        What the inputs go through before they act.
    limits : tuple of Limit
        Values at which states stop.
    n_known : int
        Number of memories, the first ones, whose numbers are fixed: the derivative gave them.
    pasts : tuple of (tuple of float)
        For each training record, its inputs before it began; by default their first values.
    """

    design: Design
    memories: tuple[Memory, ...] = ()
    limits: tuple[Limit, ...] = ()
    n_known: int = 0
    pasts: Pasts = ()

    @property
    def whole(self) -> Design:
        """The design with the limits in it."""
        return limited(self.design, self.limits)

    def acted(self, records: Sequence[Record]) -> list[Record]:
        """Return training records with their inputs as they act, after all memories."""
        if self.pasts:
            records = [
                with_past_inputs(r, past) for r, past in zip(records, self.pasts, strict=True)
            ]
        return all_with_memories(records, self.memories)

    def trial(self, coef: np.ndarray, scale: np.ndarray, part: Segments) -> Trial:
        """Return a trial with initial coefficients, on pieces of records before memories."""
        acted = part.of([straightened(driven(record)) for record in self.acted(part.records)])
        starts = acted.z[:, 0, : part.n_states]
        return Trial(self.whole, acted, scale, coef, starts, acted.z[:, :, : part.n_states])


@dataclass(frozen=True, eq=False)
class Variant:
    """A model with one more memory, or with the columns of one more term.

    Attributes
    ----------
    candidate : Candidate
        Its name and equation.
    model : Model
        The model with it.
    columns : tuple of Column
        What it adds to the design.
    memory : Memory, optional
        The memory that it puts behind an input, after all other memories.
    """

    candidate: Candidate
    model: Model
    columns: tuple[Column, ...] = ()
    memory: Memory | None = None

    @property
    def family(self) -> tuple[object, ...]:
        """Key of all variants that differ from it only in numbers."""
        if self.memory is not None:
            return self.memory.kind, self.memory.column, len(self.memory.values)
        return self.candidate.name, self.candidate.state, self.candidate.terms

    @property
    def plainness(self) -> tuple[int, int, int]:
        """Number of added parameters, size of its terms, place in the vocabulary (or last)."""
        n_numbers = len(self.columns) if self.memory is None else len(self.memory.values)
        return n_numbers, self.candidate.size, order_of(self.candidate.name)

    def with_model(self, model: Model) -> Variant:
        """Return the variant with the numbers of its model tuned."""
        memory = self.memory and model.memories[-1]
        return replace(self, model=model, memory=memory)


def memories_beside(model: Model, part: Segments) -> list[Variant]:
    """Return the variants of a model that have one more memory.

    Parameters
    ----------
    model : Model
        The model so far.
    part : Segments
        Pieces of the training records, before memories are applied.

    Returns
    -------
    list of Variant
        Memories on a grid from very short to very long ones; vessels with and without a brim.
    """
    found = []
    for memory in grid_of(model.design, part, model.memories):
        state = users_of(model.design, memory.column)[0]
        acts = variable(len(model.design.states) + memory.column)
        candidate = Candidate(memory.kind, state, (acts,))
        found += [
            Variant(candidate, replace(model, memories=(*model.memories, one)), memory=one)
            for one in (memory, *_with_brims(memory, part.records))
        ]
    return found


def _with_brims(memory: Memory, records: Sequence[Record]) -> list[Memory]:
    """Return a vessel with brims that it overflows at times; nothing for other memories."""
    if memory.kind != VESSEL:
        return []
    highest = max(float(memory.state(record).max()) for record in records)
    return [
        replace(memory, values=(*memory.values, brim * highest, share))
        for brim in BRIMS
        for share in SHARES
    ]
