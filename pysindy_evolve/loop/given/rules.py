"""The settings of the loop, checked."""

from __future__ import annotations

from dataclasses import dataclass, replace
from numbers import Integral
from typing import Any

import numpy as np

from ... import checks

REFINE = ("auto", "derivative", "simulation")
N_LOOKS = 3  # that may name an effect: names, free runs, grown terms (Bonferroni)


@dataclass(frozen=True)
class Rules:
    """When an effect counts, and how hard to look, named as in `close_loop`.

    Parameters
    ----------
    significance : float
        Chance to add an effect where nothing is missing, in (0, 1).
    n_twins : int
        Twins of each step.
    min_share : float
        Share of the error variance that could be removed, in (0, 1), which an effect must remove
        (dimensionless).
    max_effects : int
        Effects after which the search stops.
    n_jobs : int, optional
        Processes that work on the twins, as in joblib.
    progress : bool
        Whether to show a progress bar.
    refine : {"auto", "derivative", "simulation"}
        Error that final coefficients minimize.
    by_trajectory : bool
        Whether candidates are scored by the trajectories of the records, see
        spectrum_or_trajectory.py.
    n_looks : float
        Number of looks that share the significance equally; it may be fractional.

    Raises
    ------
    ValueError
        If a setting is out of its range, or there are too few twins for the significance.
    TypeError
        If a setting is of the wrong type.
    """

    significance: float
    n_twins: int
    min_share: float
    max_effects: int
    n_jobs: int | None = None
    progress: bool = False
    refine: str = "auto"
    by_trajectory: bool = False
    n_looks: float = N_LOOKS

    def __post_init__(self) -> None:
        for name in ("significance", "min_share"):
            value, advice = getattr(self, name), "Give a share such as 0.05."
            checks.real("close_loop", name, value, "in (0, 1)", lambda v: 0 < v < 1, advice)
        checks.integer("close_loop", "n_twins", self.n_twins, 1, "Give a count.")
        checks.integer("close_loop", "max_effects", self.max_effects, 0, "Give a count.")
        _check_processes(self.n_jobs)
        if self.refine not in REFINE:
            raise ValueError(
                f"close_loop(refine=...) must be one of {', '.join(REFINE)}; got {self.refine!r}. "
                "Take auto if you are not sure."
            )
        if (self.n_twins + 1) * self.level < 1.0 - 1e-9:
            raise ValueError(
                f"close_loop(n_twins=...) must be at least {1 / self.level - 1:.0f} for "
                f"significance={self.significance:g}; got {self.n_twins}. Take more twins."
            )

    @property
    def criterion(self) -> str:
        """The error that final coefficients minimize, or "auto"."""
        return "trajectory" if self.by_trajectory and self.refine == "auto" else self.refine

    def at(self, n_found: int) -> Rules:
        """Return the rules for the next search for names, after `n_found` effects.

        Trajectories are searched for names and small terms only. The first name gets four fifths of
        the significance; each further one a third of it.
        """
        return replace(self, n_looks=1.25) if self.by_trajectory and n_found == 0 else self

    @property
    def for_small_terms(self) -> Rules:
        """The rules for small terms along trajectories, which get the last fifth.

        With few twins, an effect counts only if no twin does as well.
        """
        n_looks = min(5.0, self.significance * (self.n_twins + 1))
        return replace(self, by_trajectory=False, n_looks=n_looks)

    @property
    def notable_gain(self) -> float:
        """Gain in log error of an effect that removes just `min_share` of the error variance."""
        return float(-np.log1p(-self.min_share))

    @property
    def level(self) -> float:
        """Largest p-value that counts in a look; the fourth one names nothing and has no share."""
        return self.significance / self.n_looks

    @property
    def level_of_runs(self) -> float:
        """The same for free runs, whose look is shared by limits, names and other terms."""
        return self.level / 3.0


def _check_processes(n_jobs: Any) -> None:
    if n_jobs is None:
        return
    if not isinstance(n_jobs, Integral) or isinstance(n_jobs, bool):
        raise TypeError(
            f"close_loop(n_jobs=...) must be an integer or None; got {n_jobs!r}. "
            "Give 1 for one process, -1 for as many as there are cores."
        )
    if n_jobs == 0:
        raise ValueError(
            "close_loop(n_jobs=...) must not be 0; got 0. "
            "Give 1 for one process, -1 for as many as there are cores."
        )


def generator(random_state: Any) -> np.random.Generator:
    """Return a random generator from a seed, a generator or None.

    Raises
    ------
    ValueError
        If it is none of these, or a seed below zero.
    """
    seed = random_state
    is_seed = isinstance(seed, Integral) and not isinstance(seed, bool) and int(seed) >= 0
    if not (seed is None or is_seed or isinstance(seed, np.random.Generator)):
        raise ValueError(
            "close_loop(random_state=...) must be a whole number of at least 0, a numpy Generator "
            f"or None; got {seed!r}. Give a seed such as 0."
        )
    return np.random.default_rng(seed)
