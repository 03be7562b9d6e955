"""Compile equations into straight-line scalar programs: one integration step in one call.

======  ==================  ==================================================================
symbol  shape               meaning
======  ==================  ==================================================================
h, t    ()                  step and time at its start
x       (n_states,)         states at the start of the step
u, du   (n_inputs,)         inputs at the start, and their slopes (linear between samples)
s       (n_switches,)       frozen values of the signs
w       (n_states,)         weights of the error estimate, 1/(tolerance * size of the state)
p       (n_parameters,)     coefficients and inner constants
======  ==================  ==================================================================

A step is a Runge-Kutta step of order 5 with an embedded one of order 4 (Cash and Karp 1990).
Signs are frozen while it lasts, and each switch has a *margin* that turns negative where its sign
ceases to be right: s*g for a frozen sign. A switch that *slides* is held at g = 0 by Filippov's
convex combination of the two right-hand sides, whose weight is an equivalent sign sigma in
[-1, 1]; its margin is 1 - abs(sigma).

sympy.lambdify takes the whole program as its list of common subexpressions, so that no code is
put together from text here. Numbers enter as symbols: printed floats would lose digits.

References
----------
J. R. Cash, A. H. Karp, ACM Transactions on Mathematical Software 16 (1990) 201-222,
doi:10.1145/79505.79507.
A. F. Filippov, Differential Equations with Discontinuous Righthand Sides, Kluwer 1988.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import sympy

from ..operators import BUILTIN, Operator
from ..terms import ONE as CONSTANT_TERM
from ..terms import Atom, Call, Product, Sum, Variable
from .structure import FIRST_MARK, FREE, Structure

__all__ = ["Program", "program_of"]

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

Lines = list[tuple[Any, Any]]


@dataclass(frozen=True)
class Stage:
    """The right-hand side as a program over the symbols h, t, x, u, du, s and p.

    Attributes
    ----------
    lines : list of (symbol, expression)
        Assignments, in order.
    rates : list of expressions
        x_dot of each state.
    sigmas : dict
        Equivalent sign of each sliding switch.
    shifts : list of (switch, list of expressions)
        Newton step on each state that brings a sliding switch which is no plain state to zero.
    """

    lines: Lines
    rates: list[Any]
    sigmas: dict[int, Any]
    shifts: list[list[Any]]


class Program:
    """The compiled programs of one structure; each is made when it is first needed.

    Parameters
    ----------
    structure : Structure
        Terms and switches.
    """

    def __init__(self, structure: Structure) -> None:
        self.structure = structure
        self._functions: dict[str, Any] = {"ratio": ratio}
        self._nested = 0  # how many functions the atom that is being translated stands in
        self._literals: dict[float, Any] = {}
        self._steps: dict[frozenset[int], Callable[..., Any]] = {}
        self._slopes: Callable[..., Any] | None = None
        self._sizes: Callable[..., Any] | None = None
        self._symbols()
        self._build()

    def step(self, sliding: frozenset[int]) -> Callable[..., Any]:
        """Return step(h, t, x, u, du, s, w, p) -> (x, margins, smallest margin, error)."""
        if sliding not in self._steps:
            self._steps[sliding] = self._compile_step(sliding)
        return self._steps[sliding]

    def slopes(self) -> Callable[..., Any]:
        """Return slopes(h, t, x, u, du, s, p) -> (g, dg/dt), each with one value a switch."""
        if self._slopes is None:
            slopes = [self._slope(i, self._f) for i in range(len(self._g))]
            arguments = [self.h, self.t, self.x, self.u, self.du, self.s, self.p]
            self._slopes = self._lambdify(arguments, [], [self._g, slopes])
        return self._slopes

    def sizes(self) -> Callable[..., Any]:
        """Return sizes(t, x, u, s, p): for each row, the sum of the sizes of its terms."""
        if self._sizes is None:
            sizes = [sympy.Add(*map(sympy.Abs, parts)) for parts in self._parts]
            self._sizes = self._lambdify([self.t, self.x, self.u, self.s, self.p], [], sizes)
        return self._sizes

    def _symbols(self) -> None:
        structure = self.structure
        self.h, self.t = _symbol("h"), _symbol("t")
        self.x = _symbols("x", structure.n_states)
        self.u = _symbols("u", structure.n_inputs)
        self.du = _symbols("du", structure.n_inputs)
        self.s = _symbols("s", len(structure.switches))
        self.w = _symbols("w", structure.n_states)
        n_free = sum(kind == FREE for row in structure.entries for _, kind in row)
        marks = [c for term in structure.terms for c in term.constants]
        n_constants = int(max(marks) - FIRST_MARK) + 1 if marks else 0
        self.p = _symbols("p", n_free + n_constants)
        self._constants = self.p[n_free:]

    def _build(self) -> None:
        """Translate the rows f and the switching functions g to sympy."""
        structure = self.structure
        self._sign_of = {switch.g: s for switch, s in zip(structure.switches, self.s, strict=True)}
        self._g = [self._sum(switch.g) for switch in structure.switches]
        columns = [self._product(term) for term in structure.terms]
        free = iter(self.p)
        self._parts = [
            [(next(free) if kind == FREE else kind) * columns[i] for i, kind in row]
            for row in structure.entries
        ]
        self._f = [sympy.Add(*parts) for parts in self._parts]

    def _product(self, term: Product) -> Any:
        return sympy.Mul(*(self._atom(atom) ** n for atom, n in term.factors))

    def _sum(self, expression: Sum) -> Any:
        parts = []
        for coefficient, term in expression.parts:
            plain = abs(coefficient) == 1.0 and term != CONSTANT_TERM
            index = int(coefficient - FIRST_MARK)
            factor = sympy.Integer(int(coefficient)) if plain else self._constants[index]
            parts.append(factor * self._product(term))
        return sympy.Add(*parts)

    def _atom(self, atom: Atom) -> Any:
        if isinstance(atom, Variable):
            return [*self.x, *self.u, self.t][atom.index]
        if isinstance(atom, Sum):
            return self._sum(atom)
        if atom.operator == BUILTIN["sgn"]:
            return self._sign_of[atom.args[0]]
        if atom.operator == BUILTIN["abs"] and atom.args[0] in self._sign_of:
            argument = self._sum(atom.args[0])
            if self._nested:  # a root or logarithm has no value on the continuation below zero
                return sympy.Abs(argument)
            return self._sign_of[atom.args[0]] * argument  # no kink within a step
        self._nested += 1
        arguments = [self._sum(argument) for argument in atom.args]
        self._nested -= 1
        if atom.operator == BUILTIN["sqrt"]:
            return _ROOT(*arguments)  # as a power it would turn complex below zero
        if BUILTIN.get(atom.operator.name) == atom.operator:
            return atom.operator.to_sympy(*arguments)
        return self._user_function(atom)(*arguments)

    def _user_function(self, atom: Call) -> Any:
        """Call the user's own numpy function: what is scored is what is simulated."""
        name = f"user_{atom.operator.name}"
        self._functions[name] = on_floats(atom.operator)
        return sympy.Function(name, real=True)

    def _slope(self, i: int, rates: Sequence[Any]) -> Any:
        """Return dg_i/dt along some rates, with the inner signs of g_i frozen."""
        g = self._g[i]
        moving = [*zip(self.x, rates, strict=True), *zip(self.u, self.du, strict=True)]
        moving.append((self.t, sympy.Integer(1)))
        if g.atoms(sympy.core.function.AppliedUndef):
            step = self._number(1e-6) * self.h
            return (g.xreplace({a: a + step * rate for a, rate in moving}) - g) / step
        return sympy.Add(*(sympy.diff(g, a) * rate for a, rate in moving if g.has(a)))

    def _stage(self, sliding: Sequence[int]) -> Stage:
        """Return the right-hand side with the switches of `sliding` held at zero."""
        base, jumps = self._split(sliding)
        needs = [self._slope(i, base) for i in sliding]
        gains = [
            [self._slope(i, [b + j for b, j in zip(base, jump, strict=True)]) - need
             for jump in jumps]
            for i, need in zip(sliding, needs, strict=True)
        ]  # fmt: skip
        flat = [*base, *(j for jump in jumps for j in jump), *needs, *(g for r in gains for g in r)]
        names = sympy.numbered_symbols("c", real=True)
        lines, reduced = sympy.cse(flat, symbols=names, order="none")
        n, m, rest = self.structure.n_states, len(sliding), iter(reduced)
        base = _take(rest, n)
        jumps = [_take(rest, n) for _ in range(m)]
        needs, gains = _take(rest, m), [_take(rest, m) for _ in range(m)]
        more, sigmas = _eliminate(gains, needs)
        rates = [
            b + sum(jump[j] * sigma for jump, sigma in zip(jumps, sigmas, strict=True))
            for j, b in enumerate(base)
        ]
        shifts = []
        for k, i in enumerate(sliding):
            state = self.structure.switches[i].state
            if state is not None:
                rates[state] = sympy.Integer(0)  # rest is rest, to the last digit
                continue
            shifts.append([jump * _RATIO(self._g[i], gains[k][k]) for jump in jumps[k]])
        return Stage([*lines, *more], rates, dict(zip(sliding, sigmas, strict=True)), shifts)

    def _split(self, sliding: Sequence[int]) -> tuple[list[Any], list[list[Any]]]:
        """Split f into f0 + sum of f_i sigma_i, the affine interpolation between signs -1 and 1.

        Only f at the two signs counts for Filippov's rule, whatever f is in between.
        """
        zero = {self.s[i]: sympy.Integer(0) for i in sliding}
        rows = list(self._f)
        for i in sliding:
            up = [row.xreplace({self.s[i]: sympy.Integer(1)}) for row in rows]
            down = [row.xreplace({self.s[i]: sympy.Integer(-1)}) for row in rows]
            rows = [
                row if row == a else (a + b) / 2 + self.s[i] * ((a - b) / 2)
                for row, a, b in zip(rows, up, down, strict=True)
            ]
        base = [row.xreplace(zero) for row in rows]
        jumps = [
            [row.xreplace({**zero, self.s[i]: sympy.Integer(1)}) - b
             for row, b in zip(rows, base, strict=True)]
            for i in sliding
        ]  # fmt: skip
        return base, jumps

    def _compile_step(self, sliding: frozenset[int]) -> Callable[..., Any]:
        stage = self._stage(sorted(sliding))
        lines: Lines = []
        rates: list[list[Any]] = []
        for number, (node, weights) in enumerate(zip(NODES, STAGES, strict=True)):
            at = self._at(node, lines, [self._move(j, weights, rates) for j in range(len(self.x))])
            rates.append(_instance(stage, str(number), at, lines, stage.rates))
        end = [self._move(j, FIFTH, rates) for j in range(len(self.x))]
        after = self._at(1.0, lines, end)
        for number, shift in enumerate(stage.shifts):
            self._shift(after, lines, _instance(stage, f"p{number}", after, lines, shift))
        margins = self._margins(stage, after, lines)
        difference = [a - b for a, b in zip(FIFTH, FOURTH, strict=True)]
        zero = [sympy.Integer(0)] * len(self.x)
        errors = [self._move(j, difference, rates, zero) for j in range(len(self.x))]
        error = sympy.Add(*(w * sympy.Abs(e) for w, e in zip(self.w, errors, strict=True)))
        lowest = margins[0] if len(margins) == 1 else _LEAST(*margins) if margins else 1
        result = [[after[x] for x in self.x], margins, lowest, error]
        arguments = [self.h, self.t, self.x, self.u, self.du, self.s, self.w, self.p]
        return self._lambdify(arguments, lines, result)

    def _move(
        self,
        j: int,
        weights: Sequence[float],
        rates: Sequence[Sequence[Any]],
        start: Sequence[Any] | None = None,
    ) -> Any:
        used = [
            self._number(weight) * rate[j]
            for weight, rate in zip(weights, rates, strict=True)
            if weight and rate[j] != 0
        ]
        origin = self.x[j] if start is None else start[j]
        return origin + self.h * sympy.Add(*used) if used else origin

    def _at(self, node: float, lines: Lines, states: Sequence[Any]) -> dict[Any, Any]:
        """Assign the variables at a node of the step; return what stands for each."""
        at: dict[Any, Any] = {}
        if node == 0.0:
            return at
        tag = f"{len(lines)}"
        fraction = self.h if node == 1.0 else self._number(node) * self.h
        moved = [*zip(self.x, states, strict=True), (self.t, self.t + fraction)]
        moved += [(u, u + fraction * du) for u, du in zip(self.u, self.du, strict=True)]
        used = sympy.Add(*self._f, *self._g).free_symbols | set(self.x)
        for symbol, expression in moved:
            if symbol in used:
                at[symbol] = _symbol(f"{symbol}_{tag}")
                lines.append((at[symbol], expression))
        return at

    def _shift(self, after: dict[Any, Any], lines: Lines, shift: Sequence[Any]) -> None:
        for x, step in zip(self.x, shift, strict=True):
            if step != 0:
                moved = _symbol(f"{after[x]}m")
                lines.append((moved, after[x] + step))
                after[x] = moved

    def _margins(self, stage: Stage, after: dict[Any, Any], lines: Lines) -> list[Any]:
        """Return s*g of each frozen sign and 1 - abs(sigma) of each sliding one, after the step."""
        sigmas: dict[int, Any] = {}
        if stage.sigmas:
            values = _instance(stage, "e", after, lines, list(stage.sigmas.values()))
            sigmas = dict(zip(stage.sigmas, values, strict=True))
        margins = []
        for i, (g, s) in enumerate(zip(self._g, self.s, strict=True)):
            slack = 1 - sympy.Abs(sigmas[i]) if i in sigmas else s * g.xreplace(after)
            margins.append(_symbol(f"m{i}"))
            lines.append((margins[-1], slack))
        return margins

    def _number(self, value: float) -> Any:
        """Return a symbol that holds a number in the namespace of the compiled function."""
        if value not in self._literals:
            name = f"n{len(self._literals)}"
            self._literals[value] = _symbol(name)
            self._functions[name] = value
        return self._literals[value]

    def _lambdify(self, arguments: list[Any], lines: Lines, result: Any) -> Callable[..., Any]:
        return sympy.lambdify(
            arguments,
            result,
            modules=[dict(self._functions), {"least": min, "root": math.sqrt}, "math"],
            cse=lambda expressions: (lines, expressions),
        )


@lru_cache(maxsize=512)
def program_of(structure: Structure) -> Program:
    """Return the programs of a structure, compiled once."""
    return Program(structure)


def ratio(a: float, b: float) -> float:
    """Return -a/b, the sign that balances a + b*sigma; no net force needs none."""
    if b:
        return -a / b
    return math.copysign(math.inf, a) if a else 0.0


def on_floats(operator: Operator) -> Callable[..., float]:
    """Wrap a function of arrays as a function of floats."""

    def wrapped(*arguments: float) -> float:
        with np.errstate(all="ignore"):
            return float(np.asarray(operator(*(np.array([a]) for a in arguments)))[0])

    return wrapped


_RATIO = sympy.Function("ratio", real=True)
_ROOT = sympy.Function("root", real=True)
_LEAST = sympy.Function("least", real=True)


def _symbol(name: str) -> Any:
    return sympy.Symbol(name, real=True)


def _symbols(name: str, n: int) -> list[Any]:
    return [_symbol(f"{name}{i}") for i in range(n)]


def _take(rest: Iterable[Any], n: int) -> list[Any]:
    return [value for _, value in zip(range(n), rest, strict=False)]


def _instance(
    stage: Stage, tag: str, at: dict[Any, Any], lines: Lines, results: Sequence[Any]
) -> list[Any]:
    """Append the lines of a stage at other variables; return its results as symbols."""
    names = dict(at)
    for symbol, expression in stage.lines:
        moved = _symbol(f"{symbol}_{tag}")
        lines.append((moved, expression.xreplace(names)))
        names[symbol] = moved
    values = []
    for j, result in enumerate(results):
        value = sympy.sympify(result).xreplace(names)
        if not (value.is_Symbol or value.is_Number):
            lines.append((_symbol(f"k{j}_{tag}"), value))
            value = lines[-1][0]
        values.append(value)
    return values


def _eliminate(gains: list[list[Any]], needs: list[Any]) -> tuple[Lines, list[Any]]:
    """Solve needs + gains @ sigma = 0 in symbols, without pivots.

    The gains of friction are minus a positive definite matrix, which needs none.
    """
    lines: Lines = []
    a, b, m = [list(row) for row in gains], list(needs), len(needs)
    for k in range(m):
        for i in range(k + 1, m):
            if a[i][k] == 0:
                continue
            factor = _symbol(f"e{k}_{i}")
            lines.append((factor, _RATIO(a[i][k], a[k][k])))
            a[i] = [sympy.Integer(0) if j <= k else a[i][j] + factor * a[k][j] for j in range(m)]
            b[i] = b[i] + factor * b[k]
    sigmas: list[Any] = [None] * m
    for k in reversed(range(m)):
        rest = sympy.Add(*(a[k][j] * sigmas[j] for j in range(k + 1, m) if a[k][j] != 0))
        sigmas[k] = _symbol(f"sigma{k}")
        lines.append((sigmas[k], _RATIO(b[k] + rest, a[k][k])))
    return lines, sigmas
