"""Filippov's rule: the right-hand side while switches are held at zero.

Where the two right-hand sides beside a switch push against each other, the motion *slides* along
g = 0 under their convex combination, whose weight is an equivalent sign sigma in [-1, 1].

References
----------
A. F. Filippov, Differential Equations with Discontinuous Righthand Sides, Kluwer 1988.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from .rows import Rows
from .scalars import RATIO, Lines, symbol


@dataclass(frozen=True)
class Stage:
    """The right-hand side as a program over the symbols h, t, x, u, du, s and p.

    Attributes
    ----------
    lines : list of (symbol, expression)
        Assignments, in order.
    rates : list of expressions
        x_dot of each state.
    sigmas : dict of int to expression
        Equivalent sign of each sliding switch.
    shifts : list of list of expressions
        Newton step on each state that brings a sliding switch to zero, for each sliding switch
        that is not a plain state.
    """

    lines: Lines
    rates: list[Any]
    sigmas: dict[int, Any]
    shifts: list[list[Any]]


def stage_of(rows: Rows, sliding: Sequence[int]) -> Stage:
    """Return the right-hand side with the switches of `sliding` held at zero."""
    base, jumps = _split(rows, sliding)
    needs = [rows.slope(i, base) for i in sliding]
    gains = [
        [rows.slope(i, [b + j for b, j in zip(base, jump, strict=True)]) - need
         for jump in jumps]
        for i, need in zip(sliding, needs, strict=True)
    ]  # fmt: skip
    flat = [*base, *(j for jump in jumps for j in jump), *needs, *(g for r in gains for g in r)]
    names = sympy.numbered_symbols("c", real=True)
    lines, reduced = sympy.cse(flat, symbols=names, order="none")
    n, m, rest = rows.structure.n_states, len(sliding), iter(reduced)
    base = _take(rest, n)
    jumps = [_take(rest, n) for _ in range(m)]
    needs, gains = _take(rest, m), [_take(rest, m) for _ in range(m)]
    more, sigmas = _eliminate(gains, needs)
    x_dot = [
        b + sum(jump[j] * sigma for jump, sigma in zip(jumps, sigmas, strict=True))
        for j, b in enumerate(base)
    ]
    shifts = []
    for k, i in enumerate(sliding):
        state = rows.structure.switches[i].state
        if state is not None:
            x_dot[state] = sympy.Integer(0)  # a held state stays exactly zero
            continue
        shifts.append([jump * RATIO(rows.g[i], gains[k][k]) for jump in jumps[k]])
    return Stage([*lines, *more], x_dot, dict(zip(sliding, sigmas, strict=True)), shifts)


def _split(rows: Rows, sliding: Sequence[int]) -> tuple[list[Any], list[list[Any]]]:
    """Split f into f0 + sum of f_i sigma_i, the affine interpolation between signs -1 and 1.

    Only f at the two signs counts for Filippov's rule, whatever f is in between.
    """
    zero = {rows.s[i]: sympy.Integer(0) for i in sliding}
    f = list(rows.f)
    for i in sliding:
        up = [row.xreplace({rows.s[i]: sympy.Integer(1)}) for row in f]
        down = [row.xreplace({rows.s[i]: sympy.Integer(-1)}) for row in f]
        f = [
            row if row == a else (a + b) / 2 + rows.s[i] * ((a - b) / 2)
            for row, a, b in zip(f, up, down, strict=True)
        ]
    base = [row.xreplace(zero) for row in f]
    jumps = [
        [row.xreplace({**zero, rows.s[i]: sympy.Integer(1)}) - b
         for row, b in zip(f, base, strict=True)]
        for i in sliding
    ]  # fmt: skip
    return base, jumps


def _take(rest: Iterable[Any], n: int) -> list[Any]:
    return [value for _, value in zip(range(n), rest, strict=False)]


def _eliminate(gains: list[list[Any]], needs: list[Any]) -> tuple[Lines, list[Any]]:
    """Solve needs + gains @ sigma = 0 in symbols, without pivots.

    The gains of friction are minus a positive definite matrix, which needs no pivots.
    """
    lines: Lines = []
    a, b, m = [list(row) for row in gains], list(needs), len(needs)
    for k in range(m):
        for i in range(k + 1, m):
            if a[i][k] == 0:
                continue
            factor = symbol(f"e{k}_{i}")
            lines.append((factor, RATIO(a[i][k], a[k][k])))
            a[i] = [sympy.Integer(0) if j <= k else a[i][j] + factor * a[k][j] for j in range(m)]
            b[i] = b[i] + factor * b[k]
    sigmas: list[Any] = [None] * m
    for k in reversed(range(m)):
        rest = sympy.Add(*(a[k][j] * sigmas[j] for j in range(k + 1, m) if a[k][j] != 0))
        sigmas[k] = symbol(f"sigma{k}")
        lines.append((sigmas[k], RATIO(b[k] + rest, a[k][k])))
    return lines, sigmas
