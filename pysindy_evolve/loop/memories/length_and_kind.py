"""How far a memory reaches back: its tuning, and its comparison with other kinds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from ...hidden_states.memory import DELAY, LAG, VESSEL, Memory
from ...substitution import substituted
from ...terms import Sum, sub
from ..evidence.encompassing import chance
from ..evidence.plainest import as_good_as_best
from ..evidence.spectral import spectral_grams
from ..given.design import Column, Design
from ..given.segments import Segments
from .chains import Chain, Traded
from .probes import RATIO, Exchange, Probes, exchanges, grid_of


def settled_memory(
    memory: Memory,
    design: Design,
    part: Segments,
    level: float,
    rng: np.random.Generator,
    present: Sequence[Memory] = (),
) -> tuple[Memory, tuple[tuple[str, float], ...]]:
    """Tune how far a memory reaches back, and compare it with the other kinds, tuned as well.

    Parameters
    ----------
    memory : Memory
        From the grid.
    design : Design
        The model.
    part : Segments
        Pieces of the training records without this memory.
    level : float
        A rival with a smaller p-value is refuted.
    rng : numpy.random.Generator
        Draws the signs of the bootstrap.
    present : sequence of Memory
        Memories that the records have already.

    Returns
    -------
    memory : Memory
        Of the plainest kind that does as well as the best; a vessel only if the best delay or lag
        gains no more than chance beside it.
    rivals : tuple of (str, float)
        Kinds that could stand in its place, with their p-values.
    """
    grid = [m for m in grid_of(design, part, present) if m.column == memory.column]
    on_grid = best_of_kinds(grid, design, part)
    keys = [(kind, memory.column) for kind in (DELAY, LAG, VESSEL)]
    best = [reach_of(on_grid[key], design, part) for key in keys if key in on_grid]
    gains = [exchange.gain for exchange in exchanged(best, design, part)]
    chosen = plainest(best, gains)
    linear = [entry for entry in zip(best, gains, strict=True) if entry[0].kind != VESSEL]
    if chosen.kind == VESSEL and linear:
        # A vessel claims more than a delay or a lag: its outflow is the root of its level.
        other = plainest(*zip(*linear, strict=True))
        stands = _chance_of(chosen, other, design, part, level, rng) > level
        chosen = chosen if stands else other
    others = [m for m in best if m is not chosen]
    rivals = [(m.kind, _chance_of(m, chosen, design, part, level, rng)) for m in others]
    return chosen, tuple((kind, p_value) for kind, p_value in rivals if p_value > level)


def plainest(memories: Sequence[Memory], gains: Sequence[float]) -> Memory:
    """Return the first memory, and so the plainest, that does as well as the best."""
    return memories[as_good_as_best(gains)[0]]


def best_of_kinds(
    memories: Sequence[Memory], design: Design, part: Segments
) -> dict[tuple[str, int], Memory]:
    """Return the best memory of each kind and input.

    The numbers of two kinds do not compare: the delay of a vessel depends on how full it is.
    """
    gains = [exchange.gain for exchange in exchanged(memories, design, part)]
    ordered = sorted(zip(gains, memories, strict=True), key=lambda pair: pair[0])
    return {(memory.kind, memory.column): memory for _, memory in ordered}  # the last of each


def exchanged(memories: Sequence[Memory], design: Design, part: Segments) -> list[Exchange]:
    """Return what each of several memories does to the held-out errors of a design."""
    probes = Probes(design, tuple(memories))
    swaps = [probes.swap(k) for k in range(len(memories))]
    return exchanges(probes.widened(design), probes.extended_pieces(part), swaps)


def reach_of(memory: Memory, design: Design, part: Segments) -> Memory:
    """Return a memory with the number that predicts held-out pieces best."""
    start = float(np.log(memory.values[0]))

    def at(log_value: float) -> Memory:
        return replace(memory, values=(float(np.exp(log_value)),))

    reach = 1.5 * float(np.log(RATIO))
    found = minimize_scalar(
        lambda log_value: -exchanged([at(log_value)], design, part)[0].gain,
        bounds=(start - reach, start + reach),
        method="bounded",
        options={"maxiter": 20, "xatol": 0.01},
    )
    return at(float(found.x))


def trade_of(memory: Traded, design: Design, part: Segments) -> Traded:
    """Return a trade whose two numbers predict held-out pieces best."""

    def loss(logs: np.ndarray) -> float:
        value, given = np.exp(logs).tolist()
        return -exchanged([replace(memory, values=(value,), given=given)], design, part)[0].gain

    value, given = _least(loss, (memory.values[0], memory.given))
    tuned = replace(memory, values=(value,), given=given)
    return tuned if tuned.leaves_some else memory  # a trade of all changes nothing


def chain_of(chain: Chain, design: Design, part: Segments) -> Chain:
    """Return a delay and a lag that predict held-out pieces best together."""

    def loss(logs: np.ndarray) -> float:
        moved = replace(chain, values=tuple(np.exp(logs).tolist()))
        return -exchanged([moved], design, part)[0].gain

    return replace(chain, values=_least(loss, chain.values))


def _least(loss: Callable[[np.ndarray], float], start: Sequence[float]) -> tuple[float, ...]:
    """Return the positive numbers whose logarithms minimize a loss."""
    options = {"maxfev": 80, "xatol": 0.005, "fatol": 1e-4}
    found = minimize(loss, np.log(start), method="Nelder-Mead", options=options)
    return tuple(np.exp(found.x).tolist())


def _chance_of(
    rival: Memory,
    chosen: Memory,
    design: Design,
    part: Segments,
    level: float,
    rng: np.random.Generator,
) -> float:
    """Return the chance of the chosen memory's gain beside a rival, if the rival were the cause."""
    probes = Probes(design, (rival, chosen))
    pieces, wide = probes.extended_pieces(part), probes.widened(design)
    with_rival, with_chosen = (swapped(wide, probes.swap(k)) for k in (0, 1))
    # Known terms of the input act through the memory too.
    known = Column("known", tuple(map(sub, with_chosen.fixed, with_rival.fixed)))
    columns = [*with_rival.columns, *with_chosen.columns, known]
    n_fixed = len(wide.columns)
    grams = spectral_grams(pieces, with_rival, columns)
    return chance(grams, range(n_fixed), range(n_fixed, len(columns)), level, rng)


def swapped(design: Design, swap: dict[int, Sum]) -> Design:
    """Return a design with variables replaced."""
    columns = tuple(
        replace(c, parts=tuple(substituted(p, swap) for p in c.parts)) for c in design.columns
    )
    return replace(design, columns=columns, fixed=tuple(substituted(p, swap) for p in design.fixed))
