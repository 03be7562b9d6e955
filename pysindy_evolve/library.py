"""EvolvingLibrary, a PySINDy feature library that grows its terms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import replace
from functools import partial
from numbers import Integral
from typing import Any

import numpy as np
from joblib import Parallel, delayed, effective_n_jobs
from pysindy.feature_library.base import BaseFeatureLibrary, x_sequence_or_item
from pysindy.utils import AxesArray, comprehend_axes

from . import checks, handover
from .breeding.denoise import Rows, denoise
from .breeding.dictionary import Problem, build_dictionary
from .breeding.generation import Evolution, Settings
from .evolution import ROWS_PER_GENERATION, evolve
from .operators import Operator, resolve
from .term_library import TermColumns
from .terms import ONE, Product
from .threads import one_thread
from .training import differentiated, finite, same_samples, training_data

OPERATORS = ("add", "sub", "mul", "div", "sin", "cos", "abs", "sgn")


class EvolvingLibrary(TermColumns):
    """A PySINDy feature library that grows its terms by genetic programming.

    In an ordinary ``ps.SINDy(feature_library=EvolvingLibrary(), optimizer=...)`` it finds, for
    each state, terms whose combination gives x_dot (Algorithm 1 of the paper), and offers their
    union as the library.

    Parameters
    ----------
    operators : sequence of str or Operator
        Basis functions: names of built-in ones, or `Operator` objects.
    base_library : PySINDy library, optional
        A fixed library whose columns always stay; evolved terms come on top of them.
    population_size : int, default=80
        Number of new terms in each generation.
    n_generations : int, default=30
        Largest number of generations.
    crossover_rate, mutation_rate : float, default=0.9, 0.1
        Probabilities in [0, 1] that a new term is crossed with another, and mutated.
    max_depth : int, default=4
        Height of the tallest term.
    max_terms : int, default=12
        Most evolved terms in the equation of one state.
    random_state : int, numpy.random.RandomState, numpy.random.Generator or None
        Seed. The same seed gives the same equation, whatever `n_jobs` is.
    n_jobs : int, optional
        Number of states whose terms are grown at a time, as in joblib. With one, Ctrl-C ends the
        search with the best equations so far, and states not reached yet get one generation each;
        with several processes Ctrl-C ends without a result.
    progress : bool, default=False
        Show a progress bar for each state.

    Attributes
    ----------
    terms_ : tuple of Product
        The evolved terms.
    history_ : list of tuple of Generation
        For each target, one record for each generation.
    interrupted_ : bool
        Whether Ctrl-C ended the search.
    n_features_in_, n_output_features_ : int
        Numbers of columns of x (states and inputs) and of the library.

    References
    ----------
    Goharoodi et al., Mathematical Problems in Engineering 2020, 7286575, doi:10.1155/2020/7286575,
    Algorithm 1.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.random.default_rng(0).normal(size=(300, 2))
    >>> y = 2 * x[:, [0]] * x[:, [1]] - 3 * np.sign(x[:, [1]])
    >>> EvolvingLibrary(random_state=0).fit(x, y).get_feature_names(["q", "v"])
    ['sgn(v)', 'q v']
    """

    def __init__(
        self,
        operators: Sequence[str | Operator] = OPERATORS,
        base_library: BaseFeatureLibrary | None = None,
        *,
        population_size: int = Settings.population_size,
        n_generations: int = Settings.n_generations,
        crossover_rate: float = Settings.crossover_rate,
        mutation_rate: float = Settings.mutation_rate,
        max_depth: int = Settings.max_depth,
        max_terms: int = Settings.max_terms,
        random_state: Any = None,
        n_jobs: int | None = None,
        progress: bool = False,
    ) -> None:
        self.operators = operators
        self.base_library = base_library
        self.population_size = population_size
        self.n_generations = n_generations
        self.crossover_rate = crossover_rate
        self.mutation_rate = mutation_rate
        self.max_depth = max_depth
        self.max_terms = max_terms
        self.random_state = random_state
        self.n_jobs = n_jobs
        self.progress = progress

    def correct_shape(self, x: Any) -> Any:
        """Note an array that ``SINDy`` is about to use, see `handover`, and return it as 2-D."""
        x = super().correct_shape(x)
        finite("SINDy", "x, x_dot or u", x)
        handover.note_shape(self, x)
        return x

    def calc_trajectory(self, diff_method: Any, x: Any, t: Any) -> tuple[Any, Any]:
        """Differentiate a trajectory as every library does, and note the result."""
        try:
            x, x_dot = super().calc_trajectory(diff_method, x, t)
        except IndexError:  # PySINDy's finite differences reach past the ends of a few samples
            raise ValueError(
                "SINDy.fit(x=...) must have more samples than its derivative needs; got "
                f"n_samples = {len(x)}. Record longer, or pass x_dot."
            ) from None
        handover.note_pair(self, x, x_dot)
        return x, x_dot

    @x_sequence_or_item
    def fit(self, x_full: list[Any], y: Any = None) -> EvolvingLibrary:
        """Grow the terms.

        Parameters
        ----------
        x_full : ndarray of shape (n_samples, n_features), or list of them
            States and inputs of each trajectory.
        y : ndarray of shape (n_samples,) or (n_samples, n_targets), or list of them
            Target of the terms, such as x_dot. ``ps.SINDy`` does not pass it: there it is
            taken from the arrays that ``SINDy`` shows the library before, see `handover`.

        Returns
        -------
        EvolvingLibrary
            Itself.

        Raises
        ------
        ValueError
            If x and y differ in length, hold too few samples, a value that is not finite or of
            extreme size, or a column of x that never varies, if y is zero or did not reach the
            library, or a parameter is out of its range.
        TypeError
            If something is not made of real numbers, or a parameter is of the wrong type.
        """
        x_full, y, _ = self._data(x_full, y)
        self._grow(x_full, y)
        return self

    @x_sequence_or_item
    def fit_transform(self, x_full: list[Any], y: Any = None) -> list[Any]:
        """Grow the terms and evaluate the library for a regression on the training data.

        Where x is noisy, this differs from `transform`: terms are evaluated on the denoised rows
        that they were grown on (see `denoise`), and rows that were left out are zero. So every
        optimizer gets coefficients that the noise in x does not bias.

        Parameters
        ----------
        x_full, y
            As in `fit`.

        Returns
        -------
        ndarray of shape (n_samples, n_output_features), or list of them

        Raises
        ------
        ValueError, TypeError
            As in `fit`.
        """
        lengths = [len(x) for x in x_full]
        x_full, y, places = self._data(x_full, y)
        rows = self._grow(x_full, y)
        edges = np.cumsum([len(x) for x in x_full])[:-1]
        theta = [self._theta(x) for x in np.split(rows.x, edges)]
        if rows.kept is not None:
            for part, kept in zip(theta, np.split(rows.kept, edges), strict=True):
                part[~kept] = 0.0
        return [_padded(*each) for each in zip(theta, places, lengths, strict=True)]

    @one_thread()
    def _grow(self, x_full: list[Any], y: Any) -> Rows:
        """Grow the terms; return the rows that they were grown on."""
        x, targets = training_data(x_full, y)
        lengths = [len(xi) for xi in x_full]
        domain = _edges(x, lengths)
        operators, settings = resolve(self.operators, "EvolvingLibrary"), self._settings()
        rows = denoise(x, targets, lengths, operators)
        x, targets = rows.of(rows.x), rows.of(targets)
        noise = None if rows.noise is None else rows.of(rows.noise)
        base = self._fitted_base(x_full)
        fixed = np.empty((len(x), 0)) if base is None else _columns_of(base, x)
        search = partial(
            evolve, x, operators=operators, fixed=fixed, noise=noise, domain=domain,
            progress=self.progress,
        )  # fmt: skip
        streams = np.random.SeedSequence(_entropy(self.random_state)).spawn(targets.shape[1])
        searches = [
            partial(search, column, rng=np.random.default_rng(stream))
            for column, stream in zip(targets.T, streams, strict=True)
        ]
        found = _run_each(searches, settings, self.n_jobs)
        terms = _union(x, fixed, found)
        self.base_library_ = base
        self.terms_ = terms if terms or base is not None else (ONE,)
        self.history_ = [evolution.history for evolution in found]
        self.interrupted_ = any(evolution.interrupted for evolution in found)
        self.n_features_in_ = x.shape[1]
        self.n_output_features_ = fixed.shape[1] + len(self.terms_)
        return rows

    def _data(self, x_full: list[Any], y: Any) -> tuple[list[Any], Any, list[slice]]:
        """Return x, its target, and the rows of each trajectory that they are.

        Without y it is the target that ``SINDy`` showed beside x, see `handover`, and None if it
        did not. PySINDy leaves its derivatives NaN at the ends if asked to; there x is cut.
        """
        whole = [slice(None)] * len(x_full)
        if y is not None:
            handover.forget(self)
            return x_full, y, whole
        same_samples(handover.input_repeated_by_sindy(self))
        y = handover.target(self, x_full)
        if y is None:
            return x_full, None, whole
        places = [differentiated(yi) for yi in y]
        x = [xi[place] for xi, place in zip(x_full, places, strict=True)]
        return x, [yi[place] for yi, place in zip(y, places, strict=True)], places

    def _fitted_base(self, x_full: list[Any]) -> BaseFeatureLibrary | None:
        """Return the base library after its fit; a copy, as `clone` refuses a CustomLibrary."""
        base = self.base_library
        if base is not None and not isinstance(base, BaseFeatureLibrary):
            raise TypeError(
                "EvolvingLibrary(base_library=...) must be a PySINDy feature library; got "
                f"{base!r}. Write base_library=ps.PolynomialLibrary(degree=2), or leave it out."
            )
        return None if base is None else deepcopy(base).fit(x_full)

    def _settings(self) -> Settings:
        counts = ("population_size", "n_generations", "max_depth", "max_terms")
        rates = ("crossover_rate", "mutation_rate")
        given = {name: getattr(self, name) for name in (*counts, *rates)}
        for name in counts:
            advice = "Give a positive whole number."
            checks.integer("EvolvingLibrary", name, given[name], 1, advice)
        for name in rates:
            advice = "Give a probability."
            checks.real(
                "EvolvingLibrary", name, given[name], "in [0, 1]", lambda v: 0 <= v <= 1, advice
            )
        self._check_jobs()
        return Settings(**given)

    def _check_jobs(self) -> None:
        n_jobs, advice = self.n_jobs, "Give 1, or -1 for all cores."
        if n_jobs is not None and (isinstance(n_jobs, bool) or not isinstance(n_jobs, Integral)):
            checks.refuse_type("EvolvingLibrary", "n_jobs", "an integer or None", n_jobs, advice)
        if n_jobs == 0:
            checks.refuse("EvolvingLibrary", "n_jobs", "above or below 0", "0", advice)


def _run_each(
    searches: Sequence[Callable[..., Evolution]], settings: Settings, n_jobs: int | None
) -> list[Evolution]:
    """Run the searches; once Ctrl-C has ended one, the remaining ones get one generation each."""
    if effective_n_jobs(n_jobs) > 1:
        return list(Parallel(n_jobs=n_jobs)(delayed(run)(settings=settings) for run in searches))
    found: list[Evolution] = []
    for run in searches:
        found.append(run(settings=settings))
        if found[-1].interrupted:
            settings = replace(settings, n_generations=1)
    return found


def _edges(x: np.ndarray, lengths: Sequence[int]) -> np.ndarray:
    """Return measured states at which a term is most likely to have no value.

    These are the ends of trajectories, and the rows where a variable is largest, smallest or
    closest to zero. 1/t has no value at the first sample, but the search does not see this, as it
    works on denoised rows.
    """
    ends = np.cumsum([0, *lengths])
    places = [ends[:-1], ends[1:] - 1, x.argmin(axis=0), x.argmax(axis=0)]
    return x[np.unique(np.concatenate([*places, np.abs(x).argmin(axis=0)]))]


def _padded(theta: AxesArray, place: slice, n_samples: int) -> AxesArray:
    """Return the rows of a library at their place among rows of zeros."""
    if len(theta) == n_samples:
        return theta
    whole = np.zeros((n_samples, theta.shape[1]))
    whole[place] = theta
    return AxesArray(whole, comprehend_axes(whole))


def _columns_of(base: BaseFeatureLibrary, x: np.ndarray) -> np.ndarray:
    """Return the columns of a base library."""
    columns = np.asarray(base.transform(x))
    if columns.shape[:1] != x.shape[:1]:
        constraint, got = "a library with a row for each sample", f"{len(columns)} for {len(x)}"
        advice = "A weak library has none; take one of ordinary terms."
        checks.refuse("EvolvingLibrary", "base_library", constraint, got, advice)
    return columns


def _union(x: np.ndarray, fixed: np.ndarray, found: Sequence[Evolution]) -> tuple[Product, ...]:
    """Join the terms of all targets and drop duplicates, which would confuse an optimizer."""
    terms = list(dict.fromkeys(term for evolution in found for term in evolution.terms))
    if len(found) == 1 or len(terms) < 2:
        return tuple(terms)
    sample = Problem(x, x[:, 0], fixed).sample(ROWS_PER_GENERATION, np.random.default_rng(0))
    kept = set(build_dictionary(sample, terms).terms)
    return tuple(term for term in terms if term in kept)


def _entropy(random_state: Any) -> int | None:
    if random_state is None or isinstance(random_state, int | np.integer):
        return None if random_state is None else int(random_state)
    if isinstance(random_state, np.random.Generator):
        return int(random_state.integers(2**62))
    if not isinstance(random_state, np.random.RandomState):
        must, advice = "an integer, a numpy generator or None", "Give a seed."
        checks.refuse_type("EvolvingLibrary", "random_state", must, random_state, advice)
    return int(random_state.randint(2**31 - 1))
