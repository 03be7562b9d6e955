"""The data of a search: settings, one record for each generation, and the result."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from ..sparse.gram import least_squares, rss
from ..terms import Product
from .dictionary import Dictionary


@dataclass(frozen=True)
class Settings:
    """Parameters of the search, named as in `EvolvingLibrary`."""

    population_size: int = 80
    n_generations: int = 30
    crossover_rate: float = 0.9
    mutation_rate: float = 0.1
    max_depth: int = 4
    max_terms: int = 12
    patience: int = 10


@dataclass(frozen=True)
class Generation:
    """The record of one generation: its best equation.

    Parameters
    ----------
    number : int
        Counted from one.
    terms : tuple of Product
        The best equation, without coefficients.
    coef : tuple of float
        Its coefficients, in units of the target per unit of the term.
    error : float
        Mean square error of the best equation, as a share of the mean square of the target.
    time : float
        Seconds since the search began.
    """

    number: int
    terms: tuple[Product, ...]
    coef: tuple[float, ...]
    error: float
    time: float

    @classmethod
    def of(
        cls, dictionary: Dictionary, support: np.ndarray, number: int, start: float
    ) -> Generation:
        """Record the best equation, given as a support; the search began at time `start`."""
        gram = dictionary.gram
        coef = least_squares(gram, support)
        power = max(float(dictionary.y @ dictionary.y), np.finfo(float).tiny)
        return cls(
            number,
            tuple(dictionary.terms[j] for j in support),
            tuple(float(c) for c in coef[support] / dictionary.scale[support]),
            rss(gram, coef) / power,
            time.perf_counter() - start,
        )

    @property
    def n_terms(self) -> int:
        """Number of terms of the best equation."""
        return len(self.terms)


@dataclass(frozen=True)
class Evolution:
    """Result of a search.

    Parameters
    ----------
    terms : tuple of Product
        Terms of the equation, beside the fixed columns.
    coef : tuple of float
        Their coefficients, least squares on all rows, in units of the target per unit of term.
    history : tuple of Generation
        One record for each generation.
    finalists : tuple of Product
        Terms that were weighed against each other at the end, best first.
    interrupted : bool
        Whether Ctrl-C ended the search.
    """

    terms: tuple[Product, ...]
    coef: tuple[float, ...]
    history: tuple[Generation, ...]
    finalists: tuple[Product, ...] = ()
    interrupted: bool = False
