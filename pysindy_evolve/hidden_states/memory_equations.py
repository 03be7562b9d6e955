"""Equations with memory: their last states are hidden, and their inputs may be delayed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy

from ..equations import Equations, collected, stack
from ..signals import Record
from ..substitution import substituted
from ..terms import Call, Sum, variable
from .memory import Memory, balance, output_of, rate, with_memories_applied
from .path_states import (
    hidden_along,
    kind_of,
    n_hidden_of,
    path_rates,
    paths_in,
    with_replaced_arguments,
)


@dataclass(frozen=True, eq=False)
class MemoryEquations(Equations):
    """Equations whose last states are hidden and whose inputs may be delayed.

    If the measured states are given without the hidden ones, these are computed: `evaluate` does so
    from a whole record in time order, `simulate` from an initial state in balance.

    Parameters
    ----------
    inner : Equations
        The equations of the measured states, with the outputs of the memories as inputs.
    memories : tuple of Memory
        Memories between the inputs and `inner`.
    delays : tuple of float
        Delay of each input, units of t.
    rests : tuple of Sum
        Value of each hidden state in balance, as an expression of states, inputs and time.
    paths : tuple of Call
        Terms of `inner` with hidden states that follow a measured one, see path_states.py. Their
        hidden states come after those of the memories.
    acting : tuple of Sum
        The inputs of `inner`, as expressions of the states and inputs of these equations.
    """

    inner: Equations = field(kw_only=True)
    memories: tuple[Memory, ...] = ()
    delays: tuple[float, ...] = ()
    rests: tuple[Sum, ...] = ()
    paths: tuple[Call, ...] = ()
    acting: tuple[Sum, ...] = ()

    @property
    def n_algebraic(self) -> int:
        """Number of first states that are algebraic: the right-hand sides are their values."""
        return self.inner.n_algebraic

    @property
    def n_measured(self) -> int:
        """Number of states that are not hidden."""
        return len(self.states) - len(self.rests)

    @property
    def symbols(self) -> tuple[Any, ...]:
        """Sympy symbols; a delayed input is a function of an earlier time."""
        symbols = list(super().symbols)
        for j, delay in enumerate(self.delays):
            if delay:
                place = len(self.states) + j
                earlier = sympy.Function(self.inputs[j], real=True)
                symbols[place] = earlier(symbols[-1] - delay)
        return tuple(symbols)

    @property
    def inner_symbols(self) -> tuple[Any, ...]:
        """Sympy forms of the variables of `inner`, in terms of these equations."""
        symbols = self.symbols
        acting = (expression.to_sympy(symbols) for expression in self.acting)
        return (*symbols[: self.n_measured], *acting, symbols[-1])

    def evaluate(
        self, x: np.ndarray, u: np.ndarray | None = None, t: np.ndarray | None = None
    ) -> np.ndarray:
        """Evaluate the right-hand sides.

        Parameters
        ----------
        x : ndarray of shape (n_samples, n_states) or (n_samples, n_measured)
            States. Without the hidden ones, the rows must be a whole record in time order.
        u : ndarray of shape (n_samples, n_inputs)
            Inputs; after their delays, if all states are given.
        t : ndarray of shape (n_samples,), optional
            Time, needed for hidden states and delays.

        Returns
        -------
        ndarray of the shape of x
        """
        if x.shape[1] == len(self.states) or t is None or (u is None and self.memories):
            return super().evaluate(x, u, t)
        return self.inner.evaluate(x, None if u is None else self.acts(t, u), t)

    def acts(self, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return the inputs after all memories, shape (n_samples, n_inputs)."""
        result = np.array(u, dtype=float)
        for memory in self.memories:
            result[:, memory.column] = memory.response(t, result[:, memory.column])
        return result

    def along(self, x: np.ndarray, u: np.ndarray | None, t: np.ndarray) -> np.ndarray:
        """Return the hidden states of the paths, shape (n_samples, n_hidden)."""
        return hidden_along(self.paths, stack(x, u, t))

    def arriving(self, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return the inputs after their delays only, shape (n_samples, n_inputs)."""
        result = np.array(u, dtype=float)
        for memory in self.memories:
            if not memory.has_state:
                result[:, memory.column] = memory.response(t, result[:, memory.column])
        return result

    def complete(self, x0: np.ndarray, u0: np.ndarray, t0: float) -> np.ndarray:
        """Return an initial state with the hidden states in balance with the first inputs."""
        if len(x0) != self.n_measured:
            return x0
        start = np.concatenate([x0, np.zeros(len(self.rests)), u0, [t0]])
        for k, rest in enumerate(self.rests):
            start[self.n_measured + k] = rest.evaluate(start[None, :])[0]
        return start[: len(self.states)]


def with_memories(equations: Equations, memories: Sequence[Memory]) -> Equations:
    """Return equations with hidden states and delays written out.

    Parameters
    ----------
    equations : Equations
        Their inputs are the outputs of the memories. Terms may be paths, see path_states.py.
    memories : sequence of Memory
        Memories between the inputs and these equations.

    Returns
    -------
    Equations
        The same object if there are no memories and no paths.
    """
    paths = paths_in(equations)
    if not memories and not paths:
        return equations
    n, n_inputs = len(equations.states), len(equations.inputs)
    with_state = [m for m in memories if m.has_state]
    n_total = n + len(with_state) + n_hidden_of(paths)
    outputs = [variable(n_total + j) for j in range(n_inputs)]
    names, rates, rests = list(equations.names), [], []
    for k, memory in enumerate(with_state):
        state, source = variable(n + k), outputs[memory.column]
        rates.append(rate(memory, state, source))
        rests.append(balance(memory, source))
        outputs[memory.column] = output_of(memory, state)
        names.insert(n + k, _new_name(f"{equations.inputs[memory.column]}_{memory.suffix}", names))
    places: dict[int | Call, Sum] = dict(
        enumerate([*outputs, variable(n_total + n_inputs)], start=n)
    )
    replacements = dict(places)
    for path in paths:
        kind, shifted, place = kind_of(path), with_replaced_arguments(path, places), n + len(rates)
        states = [variable(k) for k in range(place, place + kind.order)]
        rates += path_rates(shifted, states)
        rests += kind.rests(shifted)
        replacements[path] = kind.term(shifted, states)
        for k, source in enumerate(path.args[: kind.order], start=place):
            names.insert(k, _new_name(f"{source.name(equations.names)}_{kind.suffix}", names))
    right_hand_sides = [substituted(side, replacements) for side in equations.sums] + rates
    return MemoryEquations(
        *collected(right_hand_sides),
        tuple(names[:n_total]),
        equations.inputs,
        inner=equations,
        memories=tuple(memories),
        delays=_delays(memories, n_inputs),
        rests=tuple(rests),
        paths=paths,
        acting=tuple(outputs),
    )


def as_acting(equations: Equations, record: Record) -> tuple[Equations, Record]:
    """Return equations without memories, and a record with the memories applied to its inputs."""
    if not isinstance(equations, MemoryEquations):
        return equations, record
    return equations.inner, with_memories_applied(record, equations.memories)


def _delays(memories: Sequence[Memory], n_inputs: int) -> tuple[float, ...]:
    """Return the pure delay of each input, units of t."""
    late = [0.0] * n_inputs
    for memory in memories:
        if not memory.has_state:
            late[memory.column] += memory.values[0]
    return tuple(late)


def _new_name(name: str, taken: Sequence[str]) -> str:
    """Return a name that is not taken, by appending underscores."""
    while name in taken:
        name += "_"
    return name
