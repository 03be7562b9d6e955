"""Compile equations into straight-line scalar programs: one integration step in one call.

The symbols are those of `rows`. A step is a Runge-Kutta step of order 5 with an embedded one of
order 4. Signs are frozen during a step. Each switch has a *margin* that turns negative where its
sign is no longer valid: s*g for a frozen sign, 1 - abs(sigma) for one that slides, see `filippov`.

References
----------
J. R. Cash, A. H. Karp, ACM Transactions on Mathematical Software 16 (1990) 201-222,
doi:10.1145/79505.79507.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache
from typing import Any

import sympy

from .filippov import Stage, stage_of
from .rows import Rows
from .scalars import LEAST, Lines, symbol
from .structure import Structure

NODES = (0.0, 1 / 5, 3 / 10, 3 / 5, 1.0, 7 / 8)
STAGES: tuple[tuple[float, ...], ...] = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (3 / 10, -9 / 10, 6 / 5),
    (-11 / 54, 5 / 2, -70 / 27, 35 / 27),
    (1631 / 55296, 175 / 512, 575 / 13824, 44275 / 110592, 253 / 4096),
)
FIFTH = (37 / 378, 0.0, 250 / 621, 125 / 594, 0.0, 512 / 1771)
FOURTH = (2825 / 27648, 0.0, 18575 / 48384, 13525 / 55296, 277 / 14336, 1 / 4)


class Program:
    """The programs of one structure; each is compiled when it is first needed.

    Parameters
    ----------
    structure : Structure
        Terms and switches.
    """

    def __init__(self, structure: Structure) -> None:
        self.structure = structure
        self._rows = Rows(structure)
        self._steps: dict[frozenset[int], Callable[..., Any]] = {}

    def step(self, sliding: frozenset[int]) -> Callable[..., Any]:
        """Return step(h, t, x, u, du, s, w, p) -> (x, margins, smallest margin, error)."""
        if sliding not in self._steps:
            self._steps[sliding] = _compiled_step(self._rows, sliding)
        return self._steps[sliding]

    @cached_property
    def slopes(self) -> Callable[..., Any]:
        """Function slopes(h, t, x, u, du, s, p) -> (g, dg/dt), each with one value a switch."""
        rows = self._rows
        slopes = [rows.slope(i, rows.f) for i in range(len(rows.g))]
        arguments = [rows.h, rows.t, rows.x, rows.u, rows.du, rows.s, rows.p]
        return rows.namespace.compiled(arguments, [], [rows.g, slopes])

    @cached_property
    def rates(self) -> Callable[..., Any]:
        """Function rates(t, x, u, s, p) -> (x_dot, sum of the sizes of its terms), row by row."""
        rows = self._rows
        sizes = [sympy.Add(*map(sympy.Abs, parts)) for parts in rows.parts]
        return rows.namespace.compiled(
            [rows.t, rows.x, rows.u, rows.s, rows.p], [], [rows.f, sizes]
        )


@lru_cache(maxsize=512)
def program_of(structure: Structure) -> Program:
    """Return the programs of a structure, compiled once."""
    return Program(structure)


def _compiled_step(rows: Rows, sliding: frozenset[int]) -> Callable[..., Any]:
    stage = stage_of(rows, sorted(sliding))
    lines: Lines = []
    rates: list[list[Any]] = []
    for number, (node, weights) in enumerate(zip(NODES, STAGES, strict=True)):
        at = _at(rows, node, lines, [_move(rows, j, weights, rates) for j in range(len(rows.x))])
        rates.append(_instance(stage, str(number), at, lines, stage.rates))
    end = [_move(rows, j, FIFTH, rates) for j in range(len(rows.x))]
    after = _at(rows, 1.0, lines, end)
    for number, shift in enumerate(stage.shifts):
        _shift(rows, after, lines, _instance(stage, f"p{number}", after, lines, shift))
    margins = _margins(rows, stage, after, lines)
    difference = [a - b for a, b in zip(FIFTH, FOURTH, strict=True)]
    zero = [sympy.Integer(0)] * len(rows.x)
    errors = [_move(rows, j, difference, rates, zero) for j in range(len(rows.x))]
    error = sympy.Add(*(w * sympy.Abs(e) for w, e in zip(rows.w, errors, strict=True)))
    lowest = margins[0] if len(margins) == 1 else LEAST(*margins) if margins else 1
    result = [[after[x] for x in rows.x], margins, lowest, error]
    arguments = [rows.h, rows.t, rows.x, rows.u, rows.du, rows.s, rows.w, rows.p]
    return rows.namespace.compiled(arguments, lines, result)


def _move(
    rows: Rows,
    j: int,
    weights: Sequence[float],
    rates: Sequence[Sequence[Any]],
    start: Sequence[Any] | None = None,
) -> Any:
    used = [
        rows.namespace.number(weight) * rate[j]
        for weight, rate in zip(weights, rates, strict=True)
        if weight and rate[j] != 0
    ]
    origin = rows.x[j] if start is None else start[j]
    return origin + rows.h * sympy.Add(*used) if used else origin


def _at(rows: Rows, node: float, lines: Lines, states: Sequence[Any]) -> dict[Any, Any]:
    """Assign the variables at a node of the step; return the symbol of each."""
    at: dict[Any, Any] = {}
    if node == 0.0:
        return at
    tag = f"{len(lines)}"
    fraction = rows.h if node == 1.0 else rows.namespace.number(node) * rows.h
    moved = [*zip(rows.x, states, strict=True), (rows.t, rows.t + fraction)]
    moved += [(u, u + fraction * du) for u, du in zip(rows.u, rows.du, strict=True)]
    used = sympy.Add(*rows.f, *rows.g).free_symbols | set(rows.x)
    for old, expression in moved:
        if old in used:
            at[old] = symbol(f"{old}_{tag}")
            lines.append((at[old], expression))
    return at


def _shift(rows: Rows, after: dict[Any, Any], lines: Lines, shift: Sequence[Any]) -> None:
    for x, step in zip(rows.x, shift, strict=True):
        if step != 0:
            moved = symbol(f"{after[x]}m")
            lines.append((moved, after[x] + step))
            after[x] = moved


def _margins(rows: Rows, stage: Stage, after: dict[Any, Any], lines: Lines) -> list[Any]:
    """Return s*g of each frozen sign and 1 - abs(sigma) of each sliding one, after the step."""
    sigmas: dict[int, Any] = {}
    if stage.sigmas:
        values = _instance(stage, "e", after, lines, list(stage.sigmas.values()))
        sigmas = dict(zip(stage.sigmas, values, strict=True))
    margins = []
    for i, (g, s) in enumerate(zip(rows.g, rows.s, strict=True)):
        slack = 1 - sympy.Abs(sigmas[i]) if i in sigmas else s * g.xreplace(after)
        margins.append(symbol(f"m{i}"))
        lines.append((margins[-1], slack))
    return margins


def _instance(
    stage: Stage, tag: str, at: dict[Any, Any], lines: Lines, results: Sequence[Any]
) -> list[Any]:
    """Append the lines of a stage at other variables; return its results as symbols."""
    names = dict(at)
    for old, expression in stage.lines:
        moved = symbol(f"{old}_{tag}")
        lines.append((moved, expression.xreplace(names)))
        names[old] = moved
    values = []
    for j, result in enumerate(results):
        value = sympy.sympify(result).xreplace(names)
        if not (value.is_Symbol or value.is_Number):
            lines.append((symbol(f"k{j}_{tag}"), value))
            value = lines[-1][0]
        values.append(value)
    return values
