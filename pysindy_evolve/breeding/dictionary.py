"""The dictionary of one generation: terms evaluated on a sample, and the price of each.

======  ====================  ========================================================
symbol  shape                 meaning
======  ====================  ========================================================
x       (n, n_variables)      states and inputs
target  (n,)                  left-hand side of the equation: one column of x_dot
fixed   (n, n_fixed)          columns that are always in the equation
theta   (m, p)                terms on the m rows of a sample, columns of unit RMS
======  ====================  ========================================================
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..operators import BUILTIN
from ..sparse.gram import Gram, block_grams, gram
from ..sparse.parsimony import PERFECT
from ..terms import Atom, Cache, Call, Product

Project = Callable[[np.ndarray], np.ndarray]

TWIN = 1.0 - 1e-9  # correlation above which two columns are one signal up to scale
SIBLING = 0.98  # the same for two terms that differ only in their inner constants
SPIKE = 0.5  # share of a column's power in one sample above which it only fits that sample
SPANNED = 1e-9  # share of a column's power that the fixed columns must leave
KINKS = (BUILTIN["abs"], BUILTIN["sgn"])
WAVES = (BUILTIN["sin"], BUILTIN["cos"], BUILTIN["tan"])
FREQUENCY = 3.0  # parameters that a frequency counts as: its error falls as n^-1.5, not n^-0.5
# Price of a node: 2 log 3, as there are about 3^size terms of a size (extended BIC).
PRICE_PER_NODE = 2.0


@dataclass(frozen=True, eq=False)
class Problem:
    """The data of one target.

    Parameters
    ----------
    x : ndarray of shape (n, n_variables)
        Variables, in the user's units.
    target : ndarray of shape (n,)
        Left-hand side of the equation.
    fixed : ndarray of shape (n, n_fixed)
        Columns that are always in the equation.
    project : callable, optional
        A linear map on rows, (n, p) to (m, p), applied to theta, fixed columns and target alike.
    noise : ndarray of shape (n_variables,) or (n, n_variables), optional
        Standard deviation of the noise in each variable, or in each of its values.
    domain : ndarray of shape (k, n_variables), optional
        Further states at which every term must have a value, such as those where a record begins.
    """

    x: np.ndarray
    target: np.ndarray
    fixed: np.ndarray
    project: Project | None = None
    noise: np.ndarray | None = None
    domain: np.ndarray | None = None

    def has_values(self, terms: Sequence[Product]) -> np.ndarray:
        """Tell which terms have a finite value everywhere in the domain, shape (n_terms,)."""
        if self.domain is None:
            return np.ones(len(terms), dtype=bool)
        with np.errstate(all="ignore"):
            return np.array([np.isfinite(t.evaluate(self.domain)).all() for t in terms], dtype=bool)

    def sample(self, n_rows: int, rng: np.random.Generator) -> Problem:
        """Draw one row from each of `n_rows` consecutive strata: the order of time is kept."""
        n = len(self.x)
        if self.project is not None or n <= n_rows:
            return self
        edges = np.linspace(0, n, n_rows + 1)
        rows = (edges[:-1] + rng.random(n_rows) * np.diff(edges)).astype(int)
        return Problem(self.x[rows], self.target[rows], self.fixed[rows], domain=self.domain)

    def theta(
        self, terms: Sequence[Product], rows: slice = slice(None), cache: Cache | None = None
    ) -> np.ndarray:
        """Evaluate fixed columns and terms, not yet projected: (rows, n_fixed + n_terms)."""
        x, n_fixed = np.asfortranarray(self.x[rows]), self.fixed.shape[1]
        cache = {} if cache is None else cache
        columns = np.empty((len(x), n_fixed + len(terms)), order="F")
        columns[:, :n_fixed] = self.fixed[rows]
        for j, term in enumerate(terms):
            columns[:, n_fixed + j] = term.evaluate(x, cache)
        return columns

    def regression(
        self, terms: Sequence[Product], cache: Cache | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the two sides of the regression: theta with fixed columns first, and target."""
        theta, y = self.theta(terms, cache=cache), self.target
        if self.project is None:
            return theta, y
        finite = np.isfinite(theta)
        projected = self.project(np.column_stack([np.where(finite, theta, 0.0), y]))
        projected[:, :-1][:, ~finite.all(axis=0)] = np.nan
        return projected[:, :-1], projected[:, -1]

    def blocks(self, terms: Sequence[Product], n_blocks: int) -> list[Gram]:
        """Return Gram matrices of consecutive blocks of all rows, fixed columns first."""
        if self.project is None:
            return block_grams(lambda rows: self.theta(terms, rows), self.target, n_blocks)
        theta, y = self.regression(terms)
        return block_grams(lambda rows: theta[rows], y, n_blocks)


@dataclass(frozen=True, eq=False)
class Dictionary:
    """Distinct, finite terms on a sample; the fixed columns are projected out of their Gram."""

    problem: Problem
    terms: tuple[Product, ...]
    theta: np.ndarray
    y: np.ndarray
    gram: Gram
    scale: np.ndarray

    @property
    def n_fixed(self) -> int:
        """Number of columns of theta before the terms."""
        return self.theta.shape[1] - len(self.terms)

    @property
    def is_exact(self) -> bool:
        """Whether all terms together leave nothing of the target but rounding."""
        remainder = self.residual(np.arange(len(self.terms)))
        return bool(remainder @ remainder <= PERFECT * (self.y @ self.y))

    def residual(self, support: np.ndarray) -> np.ndarray:
        """Return the residual of the fixed columns and the terms of a support: (m,)."""
        n = self.n_fixed
        basis = np.linalg.qr(self.theta[:, [*range(n), *(n + j for j in support)]])[0]
        return self.y - basis @ (basis.T @ self.y)


def build_dictionary(problem: Problem, terms: Sequence[Product]) -> Dictionary:
    """Evaluate terms on a sample and drop duplicates.

    Parameters
    ----------
    problem : Problem
        The sample.
    terms : sequence of Product
        Of two that are the same signal up to scale, the smaller stays; of equal size, the earlier.

    Returns
    -------
    Dictionary
        Without terms that are not finite, zero, in the span of the fixed columns, or mostly in
        one sample, and without those in which an abs or sgn has no effect: abs(q - 3 v) where q is
        always larger than 3 v.
    """
    idle = _Idle(problem.x)
    terms = sorted((t for t in dict.fromkeys(terms) if not idle(t)), key=lambda term: term.size)
    theta, y = problem.regression(terms, idle.cache)
    n_fixed = problem.fixed.shape[1]
    # Spikes are sought in the samples: projected on spectra, a slow signal fills a row or two.
    samples = theta if problem.project is None else problem.theta(terms, cache=idle.cache)
    with np.errstate(all="ignore"):
        power = np.einsum("ij,ij->j", theta, theta)
        spike = np.square(np.abs(samples).max(axis=0)) / np.einsum("ij,ij->j", samples, samples)
    good = np.isfinite(power) & (power > np.finfo(float).tiny) & (spike < SPIKE)
    good[:n_fixed] = True
    good[n_fixed:] &= problem.has_values(terms)
    scale = np.sqrt(np.where(good & (power > 0.0), power, 1.0) / len(y))
    theta = theta[:, good] / scale[good]
    terms = [term for term, ok in zip(terms, good[n_fixed:], strict=True) if ok]
    projected = gram(theta, y).without(n_fixed)
    keep = _different(projected, terms)
    return Dictionary(
        problem,
        tuple(terms[j] for j in keep),
        theta[:, [*range(n_fixed), *(n_fixed + j for j in keep)]],
        y,
        projected.select(keep),
        scale[good][n_fixed:][keep],
    )


class _Idle:
    """Tells whether the argument of an abs or sgn within a term keeps its sign on the sample."""

    def __init__(self, x: np.ndarray) -> None:
        self.x = x
        self.cache: dict[Any, np.ndarray] = {}
        self._known: dict[Any, bool] = {}

    def __call__(self, node: Product | Atom) -> bool:
        if node not in self._known:
            self._known[node] = self._is_idle_kink(node) or any(map(self, node.children))
        return self._known[node]

    def _is_idle_kink(self, node: Product | Atom) -> bool:
        if not isinstance(node, Call) or node.operator not in KINKS:
            return False
        (argument,) = node.args
        if len(argument.parts) < 2:
            return False  # the term is a duplicate of the one without the kink
        value = argument.evaluate(self.x, self.cache)
        return bool(value.min() >= 0.0 or value.max() <= 0.0)


def _different(projected: Gram, terms: Sequence[Product]) -> list[int]:
    power = np.diag(projected.xx) / projected.n
    size = np.sqrt(np.maximum(power, SPANNED)) * np.sqrt(projected.n)
    correlation = np.abs(projected.xx / np.outer(size, size))
    skeletons = [term.skeleton if term.constants else None for term in terms]
    keep: list[int] = []
    for j in np.flatnonzero(power > SPANNED):
        close = np.asarray(keep, dtype=int)[correlation[j, keep] > SIBLING]
        if any(correlation[j, i] > TWIN for i in close):
            continue
        if skeletons[j] is None or all(skeletons[i] != skeletons[j] for i in close):
            keep.append(int(j))
    return keep


def n_nodes_expanded(term: Product) -> int:
    """Return the number of nodes with powers written out: q^9 is not as simple as sin(q)."""
    return term.size + sum(abs(n) - 1 for _, n in term.factors)


def price(terms: Sequence[Product], n_effective: float) -> np.ndarray:
    """Price of each term in the information criterion.

    Log n for each fitted parameter, and `PRICE_PER_NODE` for each node, as the number of possible
    terms grows exponentially with their size. A wave can fit noise at any frequency, so a frequency
    counts as three parameters (Djuric, IEEE Trans. Signal Process. 44 (1996) 1744-1751).
    """
    frequencies = np.array([_n_frequencies(term) for term in terms], dtype=float)
    numbers = 1.0 + np.array([len(term.constants) for term in terms])
    numbers += (FREQUENCY - 1.0) * frequencies
    nodes = np.array([n_nodes_expanded(term) for term in terms], dtype=float)
    return np.asarray(numbers * np.log(max(n_effective, 2.0)) + PRICE_PER_NODE * nodes)


def _n_frequencies(node: Product | Atom) -> int:
    """Count the inner constants of the waves in a term."""
    if isinstance(node, Call) and node.operator in WAVES:
        return len(node.constants)
    return sum(map(_n_frequencies, node.children))
