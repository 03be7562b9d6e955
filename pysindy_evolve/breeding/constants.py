"""Inner constants, such as c in x/(c + x) or w in sin(w x), tuned by variable projection.

For given inner constants the coefficients of the terms follow by least squares, so only the inner
constants are searched (Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973, doi:10.1137/0710036).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence

import numpy as np
from scipy.optimize import least_squares

from ..sparse.elimination import gains
from ..terms import Atom, Call, Product, Sum
from .dictionary import Dictionary

MAX_SMALL_TERMS = 3  # terms; equations up to this size are tuned first
N_FORMS = 24  # terms, each of another form, tuned beside plain terms in the first generation
N_TUNED = 6  # terms tuned in each generation, best first
TUNING_ROWS = 800  # enough to tune one or two constants
MAX_COLUMN_VALUE = 1e150  # largest value of a column, so that its square does not overflow
# Least span of an argument, or relative span of a divisor; below it, sin(w x) is as good as w x.
LEAST_BEND = 0.3
FACTORS = (0.1, 0.25, 0.5, 2.0, 4.0, 10.0)  # of each constant, tried before the local search


def tune(
    terms: Sequence[Product],
    x: np.ndarray,
    y: np.ndarray,
    others: np.ndarray,
    *,
    project: Callable[[np.ndarray], np.ndarray] | None = None,
) -> tuple[Product, ...]:
    """Choose the inner constants of terms so that least squares on all columns fits best.

    Parameters
    ----------
    terms : sequence of Product
        Terms whose constants are free.
    x : ndarray of shape (n, n_variables)
        Variables.
    y : ndarray of shape (m,)
        Target, projected if `project` is given.
    others : ndarray of shape (m, k)
        The other columns of the equation, projected if `project` is given.
    project : callable, optional
        Linear map on the rows of columns, (n, p) to (m, p).

    Returns
    -------
    tuple of Product
        The terms with new constants, which fit at least as well as the given ones.
    """
    start = np.array([c for term in terms for c in term.constants])
    if not len(start):
        return tuple(terms)
    basis = np.linalg.qr(others)[0] if others.shape[1] else others
    y = y - basis @ (basis.T @ y)

    def residual(constants: np.ndarray) -> np.ndarray:
        with np.errstate(all="ignore"):
            columns = np.column_stack([t.evaluate(x) for t in _with(terms, constants)])
            if not np.all(np.abs(columns) < MAX_COLUMN_VALUE):
                return y
            columns = columns if project is None else project(columns)
            columns = columns - basis @ (basis.T @ columns)
            size = np.sqrt(np.einsum("ij,ij->j", columns, columns))
            columns = columns / np.where(size > 0.0, size, 1.0)
            if not np.isfinite(columns).all():
                return y
            remainder = y - columns @ np.linalg.lstsq(columns, y, rcond=1e-10)[0]
        return remainder if np.isfinite(remainder).all() else y

    def error(constants: np.ndarray) -> float:
        value = residual(constants)
        return float(value @ value)

    first = min(_around(start), key=error)
    found = least_squares(residual, first, x_scale=np.maximum(np.abs(first), 1e-12), max_nfev=12).x
    # With a constant tuned to zero it is a different term, which the search tries by itself.
    kept = [c for c in (first, found) if np.all(np.abs(c) > 1e-6 * np.abs(start))]
    kept = [c for c in kept if all(_bends(term, x) for term in _with(terms, c))]
    best = min((start, *kept), key=error)
    return _with(terms, best)


def tune_constants(
    dictionary: Dictionary,
    front: Sequence[np.ndarray],
    fitness: np.ndarray,
    partners: np.ndarray,
    known: set[Hashable],
    *,
    smooth: bool,
) -> list[Product]:
    """Tune the inner constants of the best terms, each beside the other terms of its equation.

    Terms of small equations come first, as these are right or wrong as a whole. A form that was
    tuned beside the same forms before is `known` and skipped. With `smooth` operators, whose terms
    look alike, worse terms then take its turn, and the best equation is tuned again.
    """
    order = [j for j in np.argsort(fitness, kind="stable") if dictionary.terms[j].constants]
    forms = [term.skeleton for term in dictionary.terms]
    cases: dict[Hashable, tuple[int, list[int]]] = {}
    small = sorted((support for support in front if len(support) <= MAX_SMALL_TERMS), key=len)
    in_small = [(j, support) for support in small for j in support if dictionary.terms[j].constants]
    ranked = [(j, front[partners[j]]) for j in order]
    for j, equation in [*in_small, *(ranked if smooth else ranked[:N_TUNED])]:
        beside = [i for i in equation if i != j]
        case = forms[j], frozenset(forms[i] for i in beside)
        fresh = case not in known or (smooth and j in front[0])
        if fresh and case not in cases:
            cases[case] = j, beside
        if len(cases) == N_TUNED:
            break
    known.update(cases)
    return [_tuned_beside(dictionary, *case) for case in cases.values()]


def tune_beside(dictionary: Dictionary, plain: Sequence[Product]) -> list[Product]:
    """Tune one term of each form beside plain terms; those that gain most come first.

    Many equations are linear except for one such term. As long as its constants are wrong, other
    terms fit better, and it would not be tuned otherwise.
    """
    beside = [j for j, term in enumerate(dictionary.terms) if term in plain]
    gram = dictionary.gram.scaled(dictionary.gram.scale)
    order = np.argsort(gains(gram, beside)[0], kind="stable")
    best: dict[Hashable, int] = {}
    for j in (int(j) for j in order if dictionary.terms[j].constants):
        best.setdefault(dictionary.terms[j].skeleton, j)
    return [_tuned_beside(dictionary, j, beside) for j in list(best.values())[:N_FORMS]]


def _tuned_beside(dictionary: Dictionary, j: int, beside: Sequence[int]) -> Product:
    problem, n_fixed = dictionary.problem, dictionary.n_fixed
    step = 1 if problem.project else max(len(problem.x) // TUNING_ROWS, 1)
    others = dictionary.theta[:, [*range(n_fixed), *(n_fixed + i for i in beside)]]
    (tuned,) = tune(
        [dictionary.terms[j]],
        problem.x[::step],
        dictionary.y[::step],
        others[::step],
        project=problem.project,
    )
    return tuned


def _bends(term: Product, x: np.ndarray) -> bool:
    """Tell whether each function and divisor with constants is curved over the data.

    A straight one is a simpler term, and its constants only fit the smooth error of a derivative.
    """
    with np.errstate(all="ignore"):
        return all(_span(atom, n, x) >= LEAST_BEND for atom, n in term.factors if atom.constants)


def _span(atom: Atom, exponent: int, x: np.ndarray) -> float:
    """Return the span of a function's argument, or the relative span of a sum that divides."""
    if isinstance(atom, Call) and len(atom.args) == 1:
        return float(np.ptp(atom.args[0].evaluate(x)))
    if isinstance(atom, Sum) and exponent < 0:
        value = atom.evaluate(x)
        return float(np.ptp(value) / max(np.abs(value).max(), np.finfo(float).tiny))
    return np.inf


def _around(start: np.ndarray) -> list[np.ndarray]:
    """Return the start, and variants of it with one constant multiplied by each factor."""
    variants = [start]
    for i in range(len(start)):
        for factor in FACTORS:
            variant = start.copy()
            variant[i] *= factor
            variants.append(variant)
    return variants


def _with(terms: Sequence[Product], constants: np.ndarray) -> tuple[Product, ...]:
    rest = iter(constants)
    return tuple(t.with_constants([float(next(rest)) for _ in t.constants]) for t in terms)
