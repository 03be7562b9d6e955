"""The last digits of delays and time constants, and their intervals.

A search tunes them no finer than it takes to tell effects apart, and the remaining error biases
the coefficients of the model as well. So Gauss-Newton steps follow. The change of the rates with a
number is one more column of the model, and its coefficient says how far the number is off.

Each step is fitted to averaged rows and to spectra, and the narrower interval decides: rows are
better where all is slow, spectra where the noise of the derivative is not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...hidden_states.memory import Memory, all_with_memories
from ...signals import Record
from ...substitution import substituted
from ...terms import Sum, constant, mul, sub
from ..evidence.findings import Finding, MemoryFinding, memories_in, with_findings
from ..evidence.spectral import spectral_grams
from ..fitting.bootstrap import block_intervals
from ..fitting.fit import derivative_intervals, refit
from ..fitting.linear import solve_gram
from ..given.design import Column, Design
from ..given.segments import Segments
from .length_and_kind import swapped
from .probes import Probes

N_ROUNDS = 3  # over all memories, as they affect each other
RELATIVE_STEP = 0.02  # relative step of a delay or time constant, to take the derivative by it
MAX_RELATIVE_CHANGE = 0.2  # largest relative change of a number in one step


def polished(
    declared: Design,
    findings: Sequence[Finding],
    records: Sequence[Record],
    whole: Segments,
    rng: np.random.Generator,
) -> list[Finding]:
    """Return findings whose memories fit the derivatives of records best, with their intervals.

    Parameters
    ----------
    declared : Design
        The model at the start.
    findings : sequence of Finding
        What was found, tuned.
    records : sequence of Record
        Training records without memories.
    whole : Segments
        Pieces of the same records, prepared with a wider filter.
    rng : numpy.random.Generator
        Draws the weights of blocks.

    Returns
    -------
    list of Finding
        Memories that free runs showed keep the numbers that these gave.
    """
    found, design = list(findings), with_findings(declared, findings)
    for _ in range(N_ROUNDS):
        for k, finding in enumerate(found):
            if not isinstance(finding, MemoryFinding) or finding.by_runs:
                continue
            memories = memories_in(found)
            others = [memory for memory in memories if memory is not finding.memory]
            coef = refit(design, all_with_memories(records, memories), "derivative")
            rows = all_with_memories(records, others)
            part = whole.of(all_with_memories(whole.records, others))
            found[k] = _stepped(finding, design, coef, rows, part, rng)
    return found


def row_interval(
    memory: Memory,
    design: Design,
    coef: np.ndarray,
    records: Sequence[Record],
    rng: np.random.Generator,
) -> tuple[float, float]:
    """Return the 95 % interval of a delay or time constant, from blocks of rows.

    Parameters
    ----------
    memory : Memory
        The memory, tuned.
    design : Design
        The model.
    coef : ndarray of shape (n_columns,)
        Its coefficients.
    records : sequence of Record
        Training records without this memory.
    rng : numpy.random.Generator
        Draws the blocks.

    Returns
    -------
    low, high : float
    """
    wide, probes = _with_derivative(memory, design, coef)
    low, high = derivative_intervals(wide, [probes.extended(r) for r in records], rng)[-1]
    half = 0.5 * float(high - low)
    return max(memory.values[0] - half, 0.0), memory.values[0] + half


def _stepped(
    finding: MemoryFinding,
    design: Design,
    coef: np.ndarray,
    records: Sequence[Record],
    part: Segments,
    rng: np.random.Generator,
) -> MemoryFinding:
    """Return a memory after one Gauss-Newton step, on rows or on spectra."""
    wide, probes = _with_derivative(finding.memory, design, coef)
    extended = [probes.extended(record) for record in records]
    grams = spectral_grams(probes.extended_pieces(part), wide, wide.columns)
    low, step, high = min(
        (_ends(derivative_intervals(wide, extended, rng), refit(wide, extended, "derivative"))),
        (_ends(block_intervals(grams, rng), solve_gram(grams.sum(axis=0)))),
        key=lambda ends: ends[2] - ends[0],
    )
    (value,) = finding.memory.values
    new = value + min(max(step, -MAX_RELATIVE_CHANGE * value), MAX_RELATIVE_CHANGE * value)
    interval = max(value + low, 0.0), max(value + high, 0.0)
    return replace(finding, memory=replace(finding.memory, values=(new,)), interval=interval)


def _ends(intervals: np.ndarray, coef: np.ndarray) -> tuple[float, float, float]:
    """Return how far the number of the last column is off: low end, estimate, high end."""
    low, high = intervals[-1]
    return float(low), float(coef[-1]), float(high)


def _with_derivative(memory: Memory, design: Design, coef: np.ndarray) -> tuple[Design, Probes]:
    """Return a model whose last column is the derivative of the rates by a memory's number."""
    (value,) = memory.values
    probes = Probes(design, (memory, replace(memory, values=(value * (1.0 + RELATIVE_STEP),))))
    swap, swap_longer = probes.swap(0), probes.swap(1)
    index = len(design.states) + memory.column
    sides = [probes.widen(side) for side in design.equations(coef).sums]
    slopes = tuple(
        mul(
            constant(1.0 / (RELATIVE_STEP * value)),
            sub(substituted(side, swap_longer), substituted(side, swap)),
        )
        if index in side.variables
        else Sum(())
        for side in sides
    )
    wide = swapped(probes.widened(design), swap).adding([Column("change", slopes)])
    return wide, probes
